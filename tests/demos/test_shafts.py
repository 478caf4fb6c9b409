"""Shafts out of line: every demo of the family."""

from helpers.demo_checks import *  # noqa: F403
from helpers.demo_checks import demos_of

from mbsd3d.demos import shafts

pytestmark = demos_of(shafts)
