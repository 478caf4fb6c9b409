"""Array type, precision and constants of the closed forms."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.floating]

GRAVITY = 9.81
"""Acceleration of free fall used when none is given [m/s^2]."""

EXTENDED = np.longdouble
"""80-bit floats where the machine has them (64-bit elsewhere: results then lose about three digits)."""
