"""Variants of a bicycle in which one thing is taken away or moved, for `bicycle.why`."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from .parameters import Parameters, named

SHIFT = 0.1  # [m]
NO_SPIN_R, NO_SPIN_F, NO_TRAIL = {"IRyy": 0.0}, {"IFyy": 0.0}, {"c": 0.0}

Change = Callable[[Parameters], dict[str, float]]
CHANGES: dict[str, Change] = {
    "as built": lambda p: {},
    "rear wheel without spin momentum": lambda p: NO_SPIN_R,
    "front wheel without spin momentum": lambda p: NO_SPIN_F,
    "no spin momentum": lambda p: NO_SPIN_R | NO_SPIN_F,
    "no trail": lambda p: NO_TRAIL,
    "no trail, no spin momentum": lambda p: NO_TRAIL | NO_SPIN_R | NO_SPIN_F,
    "steer axis vertical, same trail": lambda p: {"lam": 0.0},
    "front mass on the steer axis": lambda p: {"xH": on_axis(p)},
    "frame and rider 0.1 m forward": lambda p: {"xB": p.xB + SHIFT},
    "frame and rider 0.1 m back": lambda p: {"xB": p.xB - SHIFT},
    "frame and rider 0.1 m up": lambda p: {"zB": p.zB - SHIFT},
    "frame and rider 0.1 m down": lambda p: {"zB": p.zB + SHIFT},
    "fork 0.1 m forward": lambda p: {"xH": p.xH + SHIFT},
    "fork 0.1 m back": lambda p: {"xH": p.xH - SHIFT},
}
"""Name -> parameters that change [SI units]. Spin momentum is all that I_yy of a wheel does to small motions."""


def on_axis(p: Parameters) -> float:
    """x_H [m] such that the common centre of mass of fork and front wheel lies on the steer axis."""
    if p.mH == 0.0:
        raise ValueError(f"bicycle '{p.name}': the fork has no mass (mH = 0) that could be moved; give it one")
    mass = p.mH + p.mF
    height = (p.mF * p.rF - p.mH * p.zH) / mass
    return float((mass * (p.w + p.c - height * np.tan(p.lam)) - p.mF * p.w) / p.mH)


def two_mass_skate() -> Parameters:
    """Two point masses on skates, with neither trail nor spin momentum; the tilt of 5 degrees to all digits."""
    return replace(named("Tms"), lam=np.pi / 36.0, name="two-mass skate")
