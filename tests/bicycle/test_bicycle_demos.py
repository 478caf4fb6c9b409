"""The demos of the bicycle."""

from family_checks import *  # noqa: F403
from family_checks import demos_of

from bicycle import demos

pytestmark = demos_of(demos)
