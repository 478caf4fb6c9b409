"""Machines as they are built: every demo of the family."""

from helpers.demo_checks import *  # noqa: F403
from helpers.demo_checks import demos_of

from mbsd3d.demos import machines

pytestmark = demos_of(machines)
