"""Turning does not add up: every demo of the family."""

from helpers.demo_checks import *  # noqa: F403
from helpers.demo_checks import demos_of

from mbsd3d.demos import turning

pytestmark = demos_of(turning)
