"""Cams and grooves: every demo of the family."""

from family_checks import *  # noqa: F403
from family_checks import demos_of

from mbsd3d.demos import cams

pytestmark = demos_of(cams)
