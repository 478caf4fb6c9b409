"""Higher pairs: a point, a roller or a flat face of one body stays on a curve of another."""

from dataclasses import KW_ONLY
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import check_choice, floats
from ...base.errors import InputError
from ...base.fields import Array, DirectionOrNone, NumberOrNone, Stored, Vector, kept, locked, or_none, part_class
from ...base.rotations import NORM_ROUNDING, by_letter
from ...kernels import kinds
from ..bodies import Body, Ground
from ..motion_protocols import LoadedMotion
from ..primitives import ZERO, Coordinate, Primitive
from .curve import NEAREST_POINT_STARTS, Curve
from .joint import Joint

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

PIN_CURVE_SINE_MIN = 0.05  # [1] sine of the angle between a pin and its curve
TENSION_ROUNDING = 1e-9  # [1] of the largest force


def as_curve(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert the points of a curve that has no corners and no gaps."""
    check_choice(part.closed, (True, False), f"{part.what()}: closed")
    return locked(Curve(value, part.closed, what).points)


def as_pin(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert to a unit vector, or one for each point of the curve."""
    pin = floats(by_letter(value, what), what, "a direction, or one for each point")
    if pin.shape not in ((3,), part.curve.shape):
        raise InputError(f"{what} has shape {pin.shape}; give (3,), or {part.curve.shape} as the curve has")
    size = np.linalg.norm(pin, axis=-1, keepdims=True)
    if size.min() < 1e-12:
        raise InputError(f"{what} has zero length; give a direction")
    return locked(np.where(np.abs(size - 1.0) < NORM_ROUNDING, pin, pin / size))


class Pin(Stored[str | ArrayLike | None, np.ndarray | None]):
    """Direction of a pin, or one for each point of a curve, or None."""

    accepts = "str | array_like | None"
    convert = staticmethod(or_none(as_pin))


@part_class()
class CurveContact(Joint):
    """A point, a roller or a flat face of b stays on a curve fixed in a: cams, grooves, rails (2 rows or 1).

    With x(s) the spline of fifth degree through the points, over its length s, and p the point ``at`` of b:

    - a point on a curve in space, 2 rows: ``n_i(s) . (p - x(s)) = 0`` with two directions n_i across the curve;
    - ``pin=``, 1 row, ``n(s) . (p - x(s)) = radius`` with n at right angles to the curve and to the pin: free are the
      motions along the curve and along the pin. The roller of a plate cam, or the pin in the groove of a barrel cam;
    - ``face=``, 1 row, ``n . (p - x(s)) = 0`` with n the normal of a plane of b: a flat follower.

    s is that of the nearest, for a face of the highest point of the curve, found by Newton's method from where it was:
    `Solution.slide` has it, from 0 at the reference pose, and drivers, springs and friction may act on it.

    The rows act both ways, as a groove does. A roller or a face can only be pushed, and where `normal_force` is
    negative a real one would leave the curve; the certificate reports this.

    Parameters
    ----------
    curve : (n, 3) array_like
        Points of the curve, world at the reference pose [m]: 8 or more of a closed, 6 or more of an open one.
    at : (3,) array_like
        Point of b: on the curve, at the centre of the roller, on the face; world at the reference pose [m].
    pin : (3,) or (n, 3) array_like, optional
        Direction of the axis of the pin or roller, fixed in a, or one for each point of the curve.
    radius : float, optional
        Of the roller, >= 0 [m]; it rolls on the side of the curve where ``at`` is, with 0, a knife edge, outside of it.
        None: a pin that both flanks of a groove hold, and the curve is the path of its centre.
    face : (3,) array_like, optional
        Normal of a flat face, away from the curve, world at the reference pose; the curve is flat then, and convex.
    closed : bool
        True if the curve ends where it begins; its first point is not repeated.

    Raises
    ------
    ValueError
        For a curve with corners, cusps, gaps or points that coincide; a pin along the curve; a roller that is larger
        than a hollow of the curve; a face on a curve that is hollow, or not in a plane across the face.

    Examples
    --------
    >>> import numpy as np
    >>> from mbsd3d import GROUND, Body, CurveContact, Prismatic, Revolute, System
    >>> turn = np.linspace(0.0, 2 * np.pi, 72, endpoint=False)
    >>> disc = np.column_stack([0.01 + 0.03 * np.cos(turn), 0.03 * np.sin(turn), 0 * turn])  # 10 mm off its axis
    >>> cam = Body("cam", 1.0, (1e-3, 1e-3, 1e-3))
    >>> valve = Body("valve", 0.1, (1e-5, 1e-5, 1e-5), position=(0, 0.03, 0))
    >>> shaft = Revolute(GROUND, cam, at=(0, 0, 0), axis=(0, 0, 1), name="shaft")
    >>> guide = Prismatic(GROUND, valve, at=(0, 0.03, 0), axis=(0, 1, 0))
    >>> face = CurveContact(cam, valve, disc, at=(0, 0.03, 0), face=(0, 1, 0))
    >>> state = System([cam, valve], [shaft, guide, face]).assemble(angles={"shaft": np.pi / 2})
    >>> round(float(state.q[8]), 9)  # lifted by the 10 mm
    0.04
    """

    a: Body | Ground
    b: Body | Ground
    curve: Array = kept(by=as_curve)
    _: KW_ONLY
    at: Vector = kept()
    pin: Pin = kept(default=None)
    radius: NumberOrNone = kept(default=None, minimum=0.0)
    face: DirectionOrNone = kept(default=None)
    closed: bool = True

    def check(self, what: str) -> None:
        super().check(what)
        if self.face is not None:
            self.check_face(what)
        elif self.pin is not None:
            self.check_pin(what, self.pin)
        elif self.radius is not None:
            raise InputError(f"{what}: a radius without pin=; give the direction of the axis of the roller")

    def check_face(self, what: str) -> None:
        """Check that a face lies on a convex curve in a plane across it."""
        if self.pin is not None or self.radius is not None:
            raise InputError(f"{what}: both face and pin or radius; give face= for a flat one, pin= for a roller")
        plane = self.line.normal
        if plane is None or abs(plane @ self.face) > 1e-6:
            raise InputError(f"{what}: the curve is not in a plane that holds the normal of the face; give such a one")
        curved = np.cross(self.line.x(self.line.fine, 1), self.line.x(self.line.fine, 2)) @ plane
        if not self.line.closed and curved.sum() < 0.0:
            curved = -curved
        if curved.min() <= 0.0:
            k = self.line.point_at(self.line.fine[curved.argmin()])
            raise InputError(
                f"{what}: the curve is hollow or straight at point {k}, where a flat face does not touch it; "
                "give a convex curve, or a roller"
            )

    def check_pin(self, what: str, pin: np.ndarray) -> None:
        """Check that a pin stands across its curve, and that a roller is smaller than what it rolls in."""
        sine = np.linalg.norm(np.cross(self.line.tangents, pin), axis=1)
        if sine.min() < PIN_CURVE_SINE_MIN:
            raise InputError(f"{what}: the pin lies along the curve at point {sine.argmin()}; turn it across")
        if self.radius is None:
            return
        s = self.line.fine
        room = 1.0 - self.radius * np.einsum("ij,ij->i", self.line.x(s, 2), self.across[0](s))
        if room.min() <= 0.0:
            hollow, k = self.radius / (1.0 - room.min()), self.line.point_at(s[room.argmin()])
            raise InputError(
                f"{what}: the roller of radius {self.radius:g} m meets a hollow of radius {hollow:.3g} m at point {k} "
                "and touches it twice; give a smaller roller or a smoother curve"
            )

    @cached_property
    def line(self) -> Curve:
        """Return the curve, world at the reference pose."""
        return Curve(self.curve, self.closed, "curve")

    @cached_property
    def start(self) -> float:
        """Return the length along the curve at the reference pose, from its first point on [m]."""
        return self.line.nearest(self.at) if self.face is None else self.line.highest(self.face)

    @cached_property
    def across(self) -> "list[PPoly]":
        """Return the directions n of the rows over the length, world at the reference pose; none of a face."""
        if self.face is not None:
            return []
        if self.pin is None:
            return [self.line.directions(values) for values in self.line.frame]
        n = np.cross(self.line.tangents, self.pin)
        n /= np.linalg.norm(n, axis=1, keepdims=True)
        return [self.line.directions(n if self.radius is None else self.side(n) * n)]

    def side(self, n: np.ndarray) -> float:
        """Return 1 or -1: the side of the directions n (points, 3) on which the roller is, or which is outside."""
        here, there = self.line.x(self.start), self.line.directions(n)(self.start)
        out = (self.at - here) @ there
        if abs(out) <= 1e-9 * self.line.length:
            out = (here - self.curve.mean(axis=0)) @ there
        return 1.0 if out >= 0.0 else -1.0

    @cached_property
    def axes_of_a(self) -> np.ndarray:
        """Return (3, 3) axes of body a at the reference pose as columns, world."""
        return np.array([self.a.local_axis(x) for x in np.eye(3)])

    @cached_property
    def way(self) -> Coordinate:
        """Return the arc length along the curve, from 0 at the reference pose."""
        kind, axis = ("path", self.line.along(self.start)) if self.face is None else ("touch", self.face)
        numbers = self.line.numbers(self.start, self.axes_of_a, self.a.position, self.across)
        return Coordinate(kind, self.a, self.b, axis, axis, self.at, self.at, numbers=numbers)

    @property
    def outline(self) -> np.ndarray:
        """Return (k, 3) points of the curve in axes of a, from O [m]: four a piece, to be drawn."""
        line = self.line.x(np.append(self.line.fine[:: NEAREST_POINT_STARTS // 4], self.line.x.x[-1]))
        return (line - self.a.position) @ self.axes_of_a

    @property
    def pin_here(self) -> np.ndarray:
        """Return the axis of the roller at the reference pose, world."""
        pin: np.ndarray = np.asarray(self.pin)
        return pin if pin.ndim == 1 else pin[self.line.point_at(self.start)]

    def slide(self) -> Coordinate:
        return self.way

    def point(self) -> np.ndarray:
        return self.at

    def rows(self) -> list[Primitive]:
        both, points = (self.a, self.b), (self.at, self.at)
        if self.face is not None:
            return [Primitive(kinds.ON_FACE, both, points, (ZERO, self.face), coordinates=(self.way,))]
        values = [(self.radius or 0.0, 1.0 + k) for k in range(len(self.across))]
        return [Primitive(kinds.ON_CURVE, both, points, values=v, coordinates=(self.way,)) for v in values]

    def contact_normal(self, solution: LoadedMotion) -> np.ndarray:
        """Return (samples, 3) unit directions in which a pushes b, world; ValueError for a point on a curve in space.

        Its angle to the direction in which b can move is the pressure angle.
        """
        if self.face is not None:
            return solution.body_axis(self.b, self.face)
        if self.pin is None:
            raise InputError("contact_normal: a point on a curve in space is held from all sides; ask for its reaction")
        n = self.across[0](self.start + solution.slide(self))
        axes = np.stack([solution.body_axis(self.a, x) for x in np.eye(3)], axis=1)
        return np.einsum("tk,tki->ti", n / np.linalg.norm(n, axis=1, keepdims=True), axes)

    def normal_force(self, solution: LoadedMotion) -> np.ndarray:
        """Return (samples,) force of a on b along `contact_normal` [N]; negative where the row pulls."""
        return np.einsum("ti,ti->t", solution.reaction(self).force, self.contact_normal(solution))

    def lifts_off(self, solution: LoadedMotion) -> float | None:
        """Return the time [s] from which a roller or a face would have to be pulled; None: never."""
        if self.face is None and self.radius is None:
            return None
        force, t = self.normal_force(solution), solution.t
        pulled = np.flatnonzero(force < -TENSION_ROUNDING * np.abs(force).max(initial=0.0))
        if not pulled.size:
            return None
        k = pulled[0]
        return float(t[0] if k == 0 else np.interp(0.0, force[[k, k - 1]], t[[k, k - 1]]))

    def notes(self, solution: LoadedMotion) -> list[str]:
        t = self.lifts_off(solution)
        if t is None:
            return []
        least = self.normal_force(solution).min()
        return [f"'{solution.system.name(self)}' lifts off at t = {t:.6g} s: its row pulls with up to {-least:.4g} N"]
