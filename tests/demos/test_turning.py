"""Turning does not add up: every demo of the family."""

from family_checks import *  # noqa: F403
from family_checks import demos_of

from mbsd3d.demos import turning

pytestmark = demos_of(turning)
