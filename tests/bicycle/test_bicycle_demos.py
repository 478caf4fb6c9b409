"""The demos of the bicycle."""

from helpers.demo_checks import *  # noqa: F403
from helpers.demo_checks import demos_of

from bicycle import demos

pytestmark = demos_of(demos)
