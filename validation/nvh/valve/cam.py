"""A cam with a flat follower: lift over its angle as a periodic spline.

The flat face stands square to its guide, which crosses the axis of the cam. It touches the cam at (s', base + s) beside
and above the axis, where the cam is curved with the radius ``base + s + s''``: below zero it would have a cusp.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline

from mbsd3d.errors import InputError
from mbsd3d.extend import number

COUNT = 720  # points of a turn
LAWS = ("cycloidal", "harmonic", "polynomial")


@dataclass(frozen=True, eq=False)
class Cam:
    """``lift`` (n,): at even angles from the nose on, one turn without the last point [m]; ``base``: radius [m].

    ValueError for fewer than 8 points, a value that is not finite, or a cam with a cusp.
    """

    lift: np.ndarray
    base: float

    def __post_init__(self) -> None:
        lift = np.array(self.lift, dtype=float)
        if lift.ndim != 1 or lift.size < 8 or not np.isfinite(lift).all():
            raise InputError(f"cam: lift of shape {lift.shape}; give 8 or more finite heights, one turn")
        number(self.base, "cam: base", positive=True)
        object.__setattr__(self, "lift", lift)
        least = self.radius.min()
        if least <= 0.0:
            raise InputError(
                f"cam: radius of curvature {1e3 * least:.2f} mm, a cusp; give a base above "
                f"{1e3 * (self.base - least):.2f} mm or a slower lift"
            )

    @cached_property
    def spline(self) -> CubicSpline:
        """s over the angle from the nose [rad], periodic."""
        angle = 2 * np.pi * np.arange(self.lift.size + 1) / self.lift.size
        return CubicSpline(angle, np.append(self.lift, self.lift[0]), bc_type="periodic")

    @property
    def radius(self) -> np.ndarray:
        """(n,) of curvature where the follower touches [m]."""
        angle = self.spline.x[:-1]
        return self.base + self.spline(angle) + self.spline(angle, 2)

    @property
    def outline(self) -> np.ndarray:
        """(n, 2) points of the cam in its own axes, the nose up: across, up [m]."""
        angle = self.spline.x
        s, slope = self.spline(angle), self.spline(angle, 1)
        # seen from a cam that has turned by the angle
        across, up = slope, self.base + s
        return np.stack([across * np.cos(angle) + up * np.sin(angle), up * np.cos(angle) - across * np.sin(angle)], 1)


def cam(law: str, lift: float, half: float, base: float) -> Cam:
    """A cam that lifts by ``lift`` [m] within ``half`` [rad] on both sides of the nose, by one of `LAWS`.

    With x from 0 to 1 up to the nose: cycloidal ``x - sin(2 pi x) / 2 pi``, harmonic ``(1 - cos(pi x)) / 2``,
    polynomial ``10 x^3 - 15 x^4 + 6 x^5``. ValueError for another law, or a lift or angle that no cam has.
    """
    number(lift, "cam: lift", positive=True)
    if not 0.0 < number(half, "cam: half") <= np.pi:
        raise InputError(f"cam: half {half:g} rad; the lift takes at most half a turn to each side")
    angle = 2 * np.pi * np.arange(COUNT) / COUNT
    x = np.clip(1 - np.minimum(angle, 2 * np.pi - angle) / half, 0.0, 1.0)
    if law == "cycloidal":
        share = x - np.sin(2 * np.pi * x) / (2 * np.pi)
    elif law == "harmonic":
        share = (1 - np.cos(np.pi * x)) / 2
    elif law == "polynomial":
        share = x**3 * (10 - 15 * x + 6 * x**2)
    else:
        raise InputError(f"cam '{law}' is unknown; there are {', '.join(LAWS)}")
    return Cam(lift * share, base)
