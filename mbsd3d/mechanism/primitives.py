"""Constraint primitives as data in world coordinates of the reference pose; joints and drivers are lists of them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..base.checks import short_repr
from ..base.errors import InputError
from ..kernels import kinds
from ..kernels.surfaces import GROUP_NUMBERS_COUNT
from .bodies import Body, Ground
from .signals import Signal

ZERO = np.zeros(3)
# By kind of primitive: which of its rows have a residual c(q, t).
HOLONOMIC_ROWS = tuple(
    (True, False, False) if kind == kinds.ROLL else (kind not in (kinds.TURN_RATE, kinds.NO_SIDESLIP),) * rows
    for kind, rows in enumerate(kinds.ROWS_OF)
)
COORDINATES = {
    "angle": kinds.ANGLE, "slide": kinds.SLIDE, "path": kinds.PATH, "touch": kinds.FACE_CONTACT,
    "bearing": kinds.BEARING,
}  # fmt: skip
CURVE_COORDINATES = ("path", "touch")
AXIS_FIELDS = ("axis", "axis_b", "zero_a", "zero_b")
UNIT_LENGTH_TOLERANCE = 1e-6  # [1] more than rounding, less than any intended length
MEASURE_REMEDY = "build what it measures with a function of mbsd3d.measures"


def check_kind(kind: str, known: Mapping[str, int], what: str) -> None:
    """Return one of the kinds there are, or a ValueError that lists them."""
    if kind not in known:
        raise InputError(f"{what}: kind {kind!r} is unknown; give one of {', '.join(map(repr, known))}")


@dataclass(frozen=True, eq=False)
class Coordinate:
    """A hinge coordinate between bodies a and b: an angle about ``axis`` (zero at the reference pose), a slide, or a
    arc length of a curve.

    Angle: between x_a and x_b, both at the reference pose along the first perpendicular of the axis, or along
    ``zero_a`` (across the axis) and ``zero_b``. Slide: ``axis . (point_b - point_a)``. Path: length of a curve up to
    where it is nearest to ``point_b``; touch: to where it is highest along ``axis_b``. Bearing: angle about ``axis`` of
    a from ``zero_a`` to where ``point_b`` is seen from ``point_a``. World coordinates at the reference pose;
    ``numbers`` of the curve as the kernels have them (see `kernels.surfaces`).
    """

    kind: str  # a key of COORDINATES
    a: Body | Ground
    b: Body | Ground
    axis: np.ndarray
    axis_b: np.ndarray
    point_a: np.ndarray = field(default_factory=lambda: ZERO)
    point_b: np.ndarray = field(default_factory=lambda: ZERO)
    zero_a: np.ndarray | None = None
    zero_b: np.ndarray | None = None
    numbers: np.ndarray = field(default_factory=lambda: ZERO[:0])

    def __post_init__(self) -> None:
        """Check the coordinate: a file may describe one, and kernels do not check."""
        check_kind(self.kind, COORDINATES, "Coordinate")
        for name in (*AXIS_FIELDS, "point_a", "point_b"):
            x = getattr(self, name)
            if x is not None and (
                x.shape != (3,)
                or (name in AXIS_FIELDS and not abs(math.hypot(*x.tolist()) - 1.0) < UNIT_LENGTH_TOLERANCE)
            ):
                what = "a direction of length 1" if name in AXIS_FIELDS else "three numbers"
                raise InputError(f"Coordinate: {name} = {short_repr(x.tolist())} is not {what}; {MEASURE_REMEDY}")
        if (self.zero_a is None) != (self.zero_b is None):
            raise InputError(f"Coordinate: zero_a and zero_b belong together; {MEASURE_REMEDY}")
        if self.kind in CURVE_COORDINATES and not is_curve(self.numbers):
            raise InputError(f"Coordinate: {self.numbers.size} numbers are not those of a curve; {MEASURE_REMEDY}")

    @cached_property
    def geometry(self) -> bytes:
        """Return all numbers of the coordinate: equal bytes between the same bodies are the same coordinate."""
        zeros = () if self.zero_a is None or self.zero_b is None else (self.zero_a, self.zero_b)
        given = (self.axis, self.axis_b, self.point_a, self.point_b, *zeros, self.numbers)
        return b"".join([np.asarray(x, float).tobytes() for x in given])


@dataclass(frozen=True, eq=False)
class TurnRate:
    """The rate axis . (w_b - w_a) about an axis fixed in b, world at the reference pose, of which there is no angle."""

    a: Body | Ground
    b: Body | Ground
    axis: np.ndarray


def is_curve(x: np.ndarray) -> bool:
    """Return whether numbers are as many as `kernels.surfaces` reads of a curve."""
    n, k = x[[0, 2]].tolist() if x.ndim == 1 and x.size > GROUP_NUMBERS_COUNT else (0.0, 0.0)
    return n >= 1.0 and k >= 1.0 and n % 1.0 == k % 1.0 == 0.0 and x.size == 4 + n + GROUP_NUMBERS_COUNT * n * k


class Primitive(NamedTuple):
    """Rows between up to four bodies: kind, bodies of the slots, points, axes, numbers; see kernels/rows.py."""

    kind: int
    bodies: tuple[Any, ...]
    points: tuple[Any, ...] = ()
    axes: tuple[Any, ...] = ()
    second_axes: tuple[Any, ...] = ()
    values: tuple[Any, ...] = ()
    coordinates: tuple[Coordinate, ...] = ()
    numbers: tuple[float, ...] = ()
    signal: Signal | None = None
    in_metres: bool = True

    @property
    def n_rows(self) -> int:
        """Number of rows."""
        return kinds.ROWS_OF[self.kind]

    @property
    def holonomic(self) -> tuple[bool, ...]:
        """Return which rows have a residual c(q, t)."""
        return HOLONOMIC_ROWS[self.kind]


def coincide(a: Body | Ground, b: Body | Ground, at: np.ndarray, at_b: np.ndarray) -> Primitive:
    """Return p_b - p_a = 0 (3 rows)."""
    return Primitive(kinds.COINCIDE, (a, b), points=(at, at_b))


def perpendicular(a: Body | Ground, b: Body | Ground, axis_a: np.ndarray, axis_b: np.ndarray) -> Primitive:
    """Return x_a . y_b = 0 (1 row)."""
    return Primitive(kinds.DOT, (a, b), axes=(axis_a, axis_b), in_metres=False)


def in_plane(
    a: Body | Ground,
    b: Body | Ground,
    normal: np.ndarray,
    at: np.ndarray,
    at_b: np.ndarray,
    signal: Signal | None = None,
) -> Primitive:
    """Return n_a . (p_b - p_a) = 0, or = f(t) (1 row)."""
    return Primitive(kinds.IN_PLANE, (a, b), points=(at, at_b), axes=(normal, ZERO), signal=signal)


def ratio(
    first: Coordinate, factor: float, second: Coordinate | None = None, factor_second: float = 0.0, *,
    signal: Signal | None = None, in_metres: bool = False,
) -> Primitive:  # fmt: skip
    """factor x0 + factor_second x1 = 0, or = f(t) (1 row over two or four bodies)."""
    both = (first,) if second is None else (first, second)
    bodies = tuple(body for x in both for body in (x.a, x.b))
    return Primitive(
        kinds.RATIO, bodies, values=(factor, factor_second), coordinates=both, signal=signal, in_metres=in_metres
    )
