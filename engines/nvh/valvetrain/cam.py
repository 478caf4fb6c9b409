"""Cams with a follower: lift over the angle as a periodic spline; a flat face, a roller, a roller on the rim of a drum.

Followers go along z, and the cam starts with its nose away from them. With s(angle) the lift, the cam is curved where
it touches them with the radius

    face    base + s + s''                                   roller, drum    1 / k - roller

    roller  k = (p^2 + 2 s'^2 - p s'') / (p^2 + s'^2)^1.5,  p = base + roller + s
    drum    k = - base s'' / (base^2 + s'^2)^1.5,           base: where the roller's middle is

below zero it would have a cusp. A roller is pushed at the pressure angle: ``tan = s' / p``, on a drum ``s' / base``.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from scipy.interpolate import CubicSpline

from mbsd3d import Body, CurveContact, shapes
from mbsd3d.errors import InputError
from mbsd3d.extend import number

OUTLINE_POINTS = 720  # [1] points of a turn
LAWS = ("cycloidal", "harmonic", "polynomial")
X, Z = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
ROLLER_WIDTH = 0.012  # [m] of a roller in drawings


@dataclass(frozen=True, eq=False)
class Cam:
    """Cam with a flat follower, about x. The face is perpendicular to its guide, which crosses the axis of the cam; the
    contact is at (s', base + s) beside and above the axis.

    ``lift`` (n,): at even angles from the nose on, one turn without the last point [m]; ``base``: radius [m].

    ValueError for fewer than 8 points, a value that is not finite, or a cam with a cusp.
    """

    lift: np.ndarray
    base: float
    kind: ClassVar[int] = 0  # as the contact knows it
    axis: ClassVar[tuple[float, float, float]] = X

    def __post_init__(self) -> None:
        lift = np.array(self.lift, dtype=float)
        if lift.ndim != 1 or lift.size < 8 or not np.isfinite(lift).all():
            raise InputError(f"cam: lift of shape {lift.shape}; give 8 or more finite heights, one turn")
        number(self.base, "cam: base", positive=True)
        object.__setattr__(self, "lift", lift)
        least = float(self.radius.min())
        if least <= 0.0:
            raise InputError(f"cam: radius of curvature {1e3 * least:.2f} mm, a cusp; {self.remedy(least)}")

    def remedy(self, least: float) -> str:
        """Return the remedy for a cusp of such a radius [m]."""
        return f"give a base above {1e3 * (self.base - least):.2f} mm or a slower lift"

    @cached_property
    def spline(self) -> CubicSpline:
        """Return the lift s over the angle from the nose [rad] as a periodic spline."""
        angle = 2 * np.pi * np.arange(self.lift.size + 1) / self.lift.size
        return CubicSpline(angle, np.append(self.lift, self.lift[0]), bc_type="periodic")

    @property
    def ring(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return (angle, s, s', s''), (n + 1,) each, one turn from the back of the cam on."""
        angle = self.spline.x + np.pi
        return angle, *(self.spline(np.mod(angle, 2 * np.pi), k) for k in range(3))

    @property
    def height(self) -> float:
        """Return the height of the follower over the origin at no lift [m]."""
        return self.base

    @property
    def at(self) -> np.ndarray:
        """Return the contact point of the follower, or the middle of its roller, at the start [m], shape (3,)."""
        return np.array([0.0, 0.0, self.height + float(self.spline(np.pi))])

    @property
    def radius(self) -> np.ndarray:
        """Return the radius of curvature at the contact with the follower, inf where the cam is hollow [m], shape (n +
        1,).
        """
        _, s, _, bend = self.ring
        return self.base + s + bend

    @property
    def lean(self) -> float:
        """Return the greatest pressure angle [rad]."""
        return 0.0

    @property
    def outline(self) -> np.ndarray:
        """Return the points of the cam at the start, the last equal to the first [m], shape (n + 1, 3)."""
        angle, s, slope, _ = self.ring
        return turned_back(slope, self.base + s, angle - np.pi)

    def touch(self, shaft: Body, valve: Body) -> CurveContact:
        """Return the joint that keeps the follower on the cam."""
        return CurveContact(shaft, valve, self.outline[:-1], at=self.at, face=Z, name="cam")

    @property
    def looks(self) -> tuple[list, list]:
        """Return the shapes of the cam and of the end of the follower."""
        return [shapes.Lines(self.outline)], [shapes.Disc(0.016, 0.003, "z")]


@dataclass(frozen=True, eq=False)
class RollerCam(Cam):
    """Cam about x with a follower on a ``roller`` of this radius [m] that crosses the axis of the cam."""

    roller: float = 0.009
    kind: ClassVar[int] = 1

    def __post_init__(self) -> None:
        number(self.roller, "cam: roller", positive=True)
        super().__post_init__()

    def remedy(self, least: float) -> str:
        return f"give a roller below {1e3 * (self.roller + least):.2f} mm, a larger base or a slower lift"

    @property
    def height(self) -> float:
        return self.base + self.roller

    @property
    def bend(self) -> np.ndarray:
        """Return the curvature k of the path of the roller's middle on the cam, > 0 where it is convex [1/m], shape (n
        + 1,).
        """
        _, s, slope, bend = self.ring
        p = self.height + s
        return (p**2 + 2 * slope**2 - p * bend) / (p**2 + slope**2) ** 1.5

    @property
    def radius(self) -> np.ndarray:
        k = self.bend
        return np.divide(1.0, k, out=np.full(k.size, np.inf), where=k > 0) - self.roller

    @property
    def tilt(self) -> np.ndarray:
        """Return the pressure angle [rad], shape (n + 1,)."""
        _, s, slope, _ = self.ring
        return np.arctan2(slope, self.height + s)

    @property
    def lean(self) -> float:
        return float(np.abs(self.tilt).max())

    @property
    def outline(self) -> np.ndarray:
        angle, s, _, _ = self.ring
        across, up = self.roller * np.sin(self.tilt), self.height + s - self.roller * np.cos(self.tilt)
        return turned_back(across, up, angle - np.pi)

    def touch(self, shaft: Body, valve: Body) -> CurveContact:
        return CurveContact(shaft, valve, self.outline[:-1], at=self.at, pin=self.pins, radius=self.roller, name="cam")

    @property
    def pins(self) -> np.ndarray:
        """Return the axis of the roller, at every point of the outline, shape (3,) or (n, 3)."""
        return np.array(X)

    @property
    def looks(self) -> tuple[list, list]:
        return [shapes.Lines(self.outline)], [shapes.Disc(self.roller, ROLLER_WIDTH, "x")]


@dataclass(frozen=True, eq=False)
class BarrelCam(RollerCam):
    """Drum about z whose rim lifts a follower on a ``roller`` with a radial axis, its middle ``base`` from the axis of
    the drum [m].
    """

    kind: ClassVar[int] = 2
    axis: ClassVar[tuple[float, float, float]] = Z

    @property
    def height(self) -> float:
        return 0.0

    @property
    def at(self) -> np.ndarray:
        return np.array([self.base, 0.0, float(self.spline(np.pi))])

    @property
    def bend(self) -> np.ndarray:
        _, _, slope, bend = self.ring
        return -self.base * bend / (self.base**2 + slope**2) ** 1.5

    @property
    def tilt(self) -> np.ndarray:
        return np.arctan2(self.ring[2], self.base)

    @property
    def radial(self) -> np.ndarray:
        """Return the direction from the axis to the roller, seen from the drum, shape (n + 1, 3)."""
        turn = self.ring[0] - np.pi
        return np.column_stack([np.cos(turn), -np.sin(turn), 0 * turn])

    @property
    def pins(self) -> np.ndarray:
        return self.radial[:-1]

    @property
    def outline(self) -> np.ndarray:
        out, back = self.radial, np.cross(self.radial, Z)  # the way a point of the drum comes from
        normal = np.cos(self.tilt)[:, None] * np.array(Z) - np.sin(self.tilt)[:, None] * back
        return self.base * out + self.ring[1][:, None] * np.array(Z) - self.roller * normal

    @property
    def looks(self) -> tuple[list, list]:
        drum = shapes.Cylinder(self.base - ROLLER_WIDTH / 2, self.base, "z", at=(0, 0, -self.roller - self.base / 2))
        rim, roller = super().looks
        return [*rim, drum], roller


FOLLOWERS = {"flat": Cam, "roller": RollerCam, "barrel": BarrelCam}


def turned_back(across: np.ndarray, up: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return points beside and above the axis of a rotated cam about x, in the cam's own axes, shape (n, 3)."""
    c, s = np.cos(turn), np.sin(turn)
    return np.column_stack([0 * turn, across * c + up * s, up * c - across * s])


def cam(law: str, lift: float, half: float, base: float, follower: str = "flat") -> Cam:
    """Return a cam that lifts by ``lift`` [m] within ``half`` [rad] on both sides of the nose, by one of `LAWS`, with
    one of `FOLLOWERS`.

    With x from 0 to 1 up to the nose: cycloidal ``x - sin(2 pi x) / 2 pi``, harmonic ``(1 - cos(pi x)) / 2``,
    polynomial ``10 x^3 - 15 x^4 + 6 x^5``. ValueError for another law or follower, or a lift or angle that no cam has.
    """
    number(lift, "cam: lift", positive=True)
    if follower not in FOLLOWERS:
        raise InputError(f"cam: follower '{follower}' is unknown; there are {', '.join(FOLLOWERS)}")
    if not 0.0 < number(half, "cam: half") <= np.pi:
        raise InputError(f"cam: half {half:g} rad; the lift takes at most half a turn to each side")
    angle = 2 * np.pi * np.arange(OUTLINE_POINTS) / OUTLINE_POINTS
    x = np.clip(1 - np.minimum(angle, 2 * np.pi - angle) / half, 0.0, 1.0)
    if law == "cycloidal":
        share = x - np.sin(2 * np.pi * x) / (2 * np.pi)
    elif law == "harmonic":
        share = (1 - np.cos(np.pi * x)) / 2
    elif law == "polynomial":
        share = x**3 * (10 - 15 * x + 6 * x**2)
    else:
        raise InputError(f"cam '{law}' is unknown; there are {', '.join(LAWS)}")
    return FOLLOWERS[follower](lift * share, base)
