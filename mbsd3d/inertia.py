"""Moments and products of inertia of simple solids, and of parts put together."""

from .base.inertia import box as box
from .base.inertia import capsule as capsule
from .base.inertia import cone as cone
from .base.inertia import cylinder as cylinder
from .base.inertia import ellipsoid as ellipsoid
from .base.inertia import rod as rod
from .base.inertia import sphere as sphere
from .base.mass_properties import MassProperties as MassProperties
from .base.mass_properties import combine as combine
from .base.mass_properties import steiner as steiner
