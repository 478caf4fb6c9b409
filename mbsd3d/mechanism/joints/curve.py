"""Curves through points: splines of fifth degree over their own length, and directions that go along with them."""

from dataclasses import dataclass
from functools import cached_property
from math import factorial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import check_size, floats
from ...base.errors import InputError

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

SPLINE_DEGREE = 5  # [1] forces of cams follow the second derivative, which then is smooth too
CURVE_POINTS_MIN = {True: 8, False: 6}  # [points] of a closed and of an open curve
CURVE_POINTS_MAX = 20_000  # [points] all of them are searched for where the curve is met
TURN_PER_POINT_MAX = np.radians(60.0)  # [rad] between two points of a curve
CLOSING_CHORD_RATIO_MAX = 4.0  # [1] of the next longest chord, for the one that closes a curve
NEAREST_POINT_STARTS = 8  # [1] places of a piece from which the nearest point is searched


@dataclass(frozen=True, eq=False)
class Curve:
    """A curve through ``points`` (n, 3), world at the reference pose [m]; a closed one ends where it begins.

    ValueError, beginning with ``what``, for too few points, points that coincide, corners, cusps and gaps.
    """

    points: np.ndarray
    closed: bool
    what: str

    def __post_init__(self) -> None:
        points = floats(self.points, self.what, "points (n, 3) in metres")
        least, kind = CURVE_POINTS_MIN[self.closed], "a closed" if self.closed else "an open"
        if points.ndim != 2 or points.shape[1] != 3 or not least <= len(points) <= CURVE_POINTS_MAX:
            raise InputError(
                f"{self.what} has shape {points.shape}; "
                f"give {least} to {CURVE_POINTS_MAX} points (n, 3) of {kind} curve"
            )
        check_size(points, self.what)
        object.__setattr__(self, "points", points)
        chords = np.diff(self.ring, axis=0)
        long = np.linalg.norm(chords, axis=1)
        if long.min() <= 1e-9 * long.sum():
            k = int(long.argmin())
            last = self.closed and k == len(points) - 1
            remedy = "a closed curve ends at its first point: leave the last one out" if last else "leave one out"
            raise InputError(f"{self.what}: points {k} and {(k + 1) % len(points)} coincide; {remedy}")
        if self.closed and long[-1] > CLOSING_CHORD_RATIO_MAX * np.delete(long, -1).max():
            raise InputError(
                f"{self.what}: a gap of {long[-1]:.3g} m between the last point and the first, where neighbours are at "
                f"most {np.delete(long, -1).max():.3g} m apart; give the points between, or closed=False"
            )
        self.check_corners(chords / long[:, None])

    def check_corners(self, along: np.ndarray) -> None:
        """Raise a ValueError for a curve that turns sharply; ``along``: directions of its chords."""
        before, after = (np.roll(along, 1, axis=0), along) if self.closed else (along[:-1], along[1:])
        turns = np.arctan2(np.linalg.norm(np.cross(before, after), axis=1), (before * after).sum(axis=1))
        if turns.max() > TURN_PER_POINT_MAX:
            k = int(turns.argmax()) + (not self.closed)
            raise InputError(
                f"{self.what}: a corner or a cusp at point {k}, a turn of {np.degrees(turns.max()):.0f} degrees; "
                "round it, give more points, or, for the outline of a cam, a larger base circle or a smaller roller"
            )

    @property
    def ring(self) -> np.ndarray:
        """Return the points (n + 1, 3), of a closed curve with the first one again at the end."""
        return np.concatenate([self.points, self.points[:1]]) if self.closed else self.points

    @cached_property
    def lengths(self) -> np.ndarray:
        """Return s of `ring` from the first point on [m]."""
        long = np.linalg.norm(np.diff(self.ring, axis=0), axis=1)
        places, weights = np.polynomial.legendre.leggauss(8)
        for _ in range(4):  # the length of the spline over the length before: what is left falls by h^4 each time
            s = np.concatenate([[0.0], np.cumsum(long)])
            inside = s[:-1, None] + 0.5 * np.diff(s)[:, None] * (1.0 + places)
            long = 0.5 * np.diff(s) * (np.linalg.norm(spline(s, self.ring, self.closed)(inside, 1), axis=-1) @ weights)
        return np.concatenate([[0.0], np.cumsum(long)])

    @property
    def length(self) -> float:
        """Return the length of the curve [m]."""
        return float(self.lengths[-1])

    @cached_property
    def x(self) -> "PPoly":
        """Return the point over s, world at the reference pose."""
        return spline(self.lengths, self.ring, self.closed)

    @cached_property
    def tangents(self) -> np.ndarray:
        """Return (n, 3) unit tangents at the points."""
        return self.along(self.lengths[: len(self.points)])

    def along(self, s: ArrayLike) -> np.ndarray:
        """Return (..., 3) unit tangents."""
        tangent = self.x(s, 1)
        return tangent / np.linalg.norm(tangent, axis=-1, keepdims=True)

    def point_at(self, s: float) -> int:
        """Number of the point nearest to s."""
        return int(np.abs(self.lengths[: len(self.points)] - s).argmin())

    def directions(self, values: np.ndarray) -> "PPoly":
        """Return a direction over s from one per point (n, 3)."""
        return spline(self.lengths, np.concatenate([values, values[:1]]) if self.closed else values, self.closed)

    @cached_property
    def frame(self) -> tuple[np.ndarray, np.ndarray]:
        """Return two directions across the curve at every point, (n, 3) each: they turn about it as little as they can.

        By double reflection; what the last one has turned against the first is spread over a closed curve.
        """
        s, ring = self.lengths, self.ring
        t = self.along(s)
        u = np.empty_like(t)
        u[0] = np.linalg.svd(t[:1])[2][1]
        for k in range(len(t) - 1):
            first = mirrored(ring[k + 1] - ring[k], u[k], t[k])
            u[k + 1] = mirrored(t[k + 1] - first[1], first[0])[0]
        v = np.cross(t, u)
        if self.closed:
            turned = np.arctan2(u[-1] @ v[0], u[-1] @ u[0]) * s / s[-1]
            c, w = np.cos(turned)[:, None], np.sin(turned)[:, None]
            u, v = (c * u - w * v)[:-1], (c * v + w * u)[:-1]
        return u, v

    @cached_property
    def normal(self) -> np.ndarray | None:
        """Return the unit normal of the curve's plane, about which a closed one turns forwards; None off a plane."""
        centred = self.points - self.points.mean(axis=0)
        _, sizes, axes = np.linalg.svd(centred, full_matrices=False)
        if sizes[2] > 1e-9 * sizes[0]:
            return None
        area = np.cross(centred, np.roll(centred, -1, axis=0)).sum(axis=0)
        return axes[2] * (1.0 if area @ axes[2] >= 0.0 else -1.0)

    @cached_property
    def fine(self) -> np.ndarray:
        """Return s at `STARTS` even places of every piece."""
        low, width = self.x.x[:-1, None], np.diff(self.x.x)[:, None]
        return (low + width * np.arange(NEAREST_POINT_STARTS) / NEAREST_POINT_STARTS).ravel()

    def nearest(self, point: np.ndarray) -> float:
        """Return s where the curve is nearest to a point."""
        away = np.linalg.norm(self.x(self.fine) - point, axis=1)
        return self.refined(float(self.fine[away.argmin()]), point, 1.0)

    def highest(self, normal: np.ndarray) -> float:
        """Return s where the curve is highest along a direction."""
        return self.refined(float(self.fine[(self.x(self.fine) @ normal).argmax()]), normal, 0.0)

    def refined(self, s: float, e: np.ndarray, weight: float) -> float:
        """Refine s by Newton's method for x' . (e - weight x) = 0."""
        for _ in range(20):
            x, t, bend = self.x(s), self.x(s, 1), self.x(s, 2)
            off = e - weight * x
            s = float(np.clip(s - (t @ off) / (bend @ off - weight * t @ t), *self.ends))
        return s

    @property
    def ends(self) -> tuple[float, float]:
        """Return the least and largest s; infinite for a closed curve."""
        return (-np.inf, np.inf) if self.closed else (0.0, self.length)

    def numbers(self, start: float, axes: np.ndarray, origin: np.ndarray, groups: "list[PPoly]") -> np.ndarray:
        """Return what the kernels read (see `kernels.surfaces`): s from ``start`` on, x and directions.

        They are given in axes, the columns of ``axes`` (3, 3), about ``origin``, world at the reference pose.
        """
        own = self.x.c @ axes
        own[-1] -= origin @ axes
        blocks = np.stack([own, *(group.c @ axes for group in groups)])  # group, power, piece, component
        head = [own.shape[1], self.length if self.closed else 0.0, len(blocks)]
        return np.concatenate([head, self.x.x - start, blocks.transpose(2, 0, 3, 1).ravel()])


def spline(s: np.ndarray, values: np.ndarray, closed: bool) -> "PPoly":
    """Return the pieces of fifth degree through values (n, 3) at s; four derivatives are continuous."""
    from scipy.interpolate import PPoly, make_interp_spline  # a tenth of a second, for curves alone

    made = make_interp_spline(s, values, SPLINE_DEGREE, bc_type="periodic" if closed else None)
    breaks = np.unique(made.t[SPLINE_DEGREE:-SPLINE_DEGREE])
    powers = [made(breaks[:-1], k) / factorial(k) for k in range(SPLINE_DEGREE, -1, -1)]
    return PPoly(np.array(powers), breaks, extrapolate="periodic" if closed else True)


def mirrored(across: np.ndarray, *vectors: np.ndarray) -> list[np.ndarray]:
    """Return the vectors reflected at the plane with this normal of any length."""
    size = across @ across
    return [x - 2.0 * (across @ x) / size * across if size > 0.0 else x for x in vectors]
