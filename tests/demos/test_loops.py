"""Loops that should not move: every demo of the family."""

from helpers.demo_checks import *  # noqa: F403
from helpers.demo_checks import demos_of

from mbsd3d.demos import loops

pytestmark = demos_of(loops)
