"""Bodies that float: every demo of the family."""

from helpers.demo_checks import *  # noqa: F403
from helpers.demo_checks import demos_of

from mbsd3d.demos import floating

pytestmark = demos_of(floating)
