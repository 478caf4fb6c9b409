"""Stops of ball and universal joints: limits of swing and twist, or of the total rotation angle."""

from dataclasses import KW_ONLY
from typing import Any

import numpy as np

from ...base.checks import short_repr
from ...base.errors import InputError
from ...base.fields import Direction, DirectionOrDerived, Number, Stored, kept, or_none, part_class
from ...base.rotations import perpendiculars
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.coordinates import arctan2
from ...kernels.force_laws import add_moment, stop_load
from ...kernels.vectors import add, columns, cross, dot, scale, sub, vec
from ..force_element import ForceRecord
from ..joints import Joint
from ..joints.conditions import ConstantVelocity
from ..joints.pairs import Spherical, Universal
from .end_stop import Stop, see_gap
from .rotation_spring import built_turn, turn_since

OPPOSITE_COSINE = -1.0 + 1e-12  # [1] of axes that are opposite to 1e-6 rad: a swing between them has no axis
SWINGING_JOINTS = (Spherical, Universal, ConstantVelocity)
CONE_STOP = Parameters(
    stiffness="N m/rad", damping="N m s/rad", half_angle="rad", middle_twist="rad", half_twist="rad"
)  # fmt: skip
cone_stop_parameters = CONE_STOP.reader()
ROTATION_STOP = Parameters(stiffness="N m/rad", damping="N m s/rad", angle="rad", built=("1", 4))
rotation_stop_parameters = ROTATION_STOP.reader()


@inner_kernel
def swing(A, B):
    """Return (angle from z_a to z_b, axis about which z_b swings) of axes given as columns; 0 has no axis."""
    n = cross(A[2], B[2])
    sine = np.sqrt(dot(n, n))
    return arctan2(sine, dot(A[2], B[2])), scale(1.0 / sine if sine.real > 0.0 else 0.0 * sine, n)


@inner_kernel
def twist(A, B, middle):
    """Return (turn of B about z_b since A was swung onto z_b, as far as it is from ``middle``, and its gradient by w).

    With B = A S T, S a swing about an axis across z and T a turn f about z: B_11 + B_22 = (1 + cos) cos f and
    B_21 - B_12 = (1 + cos) sin f, cos that of the swing, and f_dot = w . (z_a + z_b) / (1 + cos).
    """
    x, y = dot(A[0], B[0]) + dot(A[1], B[1]), dot(A[1], B[0]) - dot(A[0], B[1])
    c, s = np.cos(middle), np.sin(middle)
    gradient = scale(1.0 / (1.0 + dot(A[2], B[2])), add(A[2], B[2]))
    return arctan2(c * y - s * x, c * x + s * y), gradient


@inner_kernel
def cone_stop(m, d, p, out, t):
    """Apply moments against swing and twist beyond their limits."""
    own = cone_stop_parameters(m.number, p.number)
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    A, B, k = columns(a, p.frame[0]), columns(b, p.frame[1]), own.stiffness
    w = sub(vec(b.w), vec(a.w))
    out.potential, out.power = 0.0 * w[0], 0.0 * w[0]
    moment = scale(0.0, w)
    for limit in range(2):
        if limit == 0:
            angle, axis = swing(A, B)
            depth = angle - own.half_angle
        else:
            angle, axis = twist(A, B, own.middle_twist)
            if angle.real < 0.0:
                angle, axis = -angle, scale(-1.0, axis)
            depth = angle - own.half_twist
        rate = dot(axis, w)
        load, elastic = stop_load(k, own.damping, depth, rate)
        moment = add(moment, scale(load, axis))
        out.potential += 0.5 * elastic * elastic / k
        out.power += (elastic - load) * rate
    add_moment(a, moment)
    add_moment(b, scale(-1.0, moment))


@inner_kernel
def cone_stop_gap(m, d, p, limit, t, seen):
    """Store the distance to the limit of the swing (0), the lower (1) or the upper twist (2)."""
    own = cone_stop_parameters(m.number, p.number)
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    A, B, w = columns(a, p.frame[0]), columns(b, p.frame[1]), sub(vec(b.w), vec(a.w))
    if limit == 0:
        angle, axis = swing(A, B)
        gap, rate = own.half_angle - angle, -dot(axis, w)
    else:
        angle, axis = twist(A, B, own.middle_twist)
        way = 1.0 if limit == 1 else -1.0
        gap, rate = own.half_twist + way * angle, way * dot(axis, w)
    see_gap(own.stiffness, own.damping, gap, rate, seen)


def as_range(value: Any, what: str, part: Any) -> tuple[float, float]:
    """Convert to two finite numbers, the first below the second, less than a turn apart."""
    try:
        low, high = (float(x) for x in value)
    except (TypeError, ValueError):
        raise InputError(f"{what} = {short_repr(value)}; give (lower, upper) in rad") from None
    if not 0.0 < high - low < 2.0 * np.pi:
        raise InputError(f"{what} = {short_repr(value)}; give a lower and an upper limit less than a turn apart")
    return low, high


class RangeOrNone(Stored[tuple[float, float] | None, tuple[float, float] | None]):
    """A lower and an upper limit [rad], or None."""

    accepts, file_type = "tuple[float, float] | None", list[float] | None
    convert = staticmethod(or_none(as_range))


def check_swings(joint: Any, what: str) -> None:
    """Accept a joint whose axis is free to swing."""
    if not isinstance(joint, SWINGING_JOINTS):
        kind = type(joint).__name__ if isinstance(joint, Joint) else short_repr(joint)
        raise InputError(
            f"{what}: {kind} does not swing; give a Spherical, Universal or ConstantVelocity, and limit the angle "
            "of a hinge by an EndStop"
        )


@part_class()
class ConeStop(Stop):
    """Stop of a ball or universal joint: ``axis_b`` of b stays within a cone about ``axis_a`` of a.

    The swing is the angle from axis_a to axis_b, the twist the turn of b about axis_b that is left when it has been
    swung back by the shortest way; both are 0 where b stands as built, but for the swing between the axes given. Beyond
    a limit by d a moment ``max(0, k d + c d_dot)`` acts on b, about the normal of both axes against the swing, along
    ``(axis_a + axis_b) / (1 + cos(swing))`` against the twist; the opposite one acts on a. It never pulls.
    Energy ``k d^2 / 2`` each; the rest of the power is dissipated.

    Parameters
    ----------
    joint : Spherical, Universal or ConstantVelocity
    axis_a, axis_b : (3,) array_like
        Axis of the cone, in a, and the axis that stays in it, in b: world at the reference pose; ``axis_b`` None = the
        same direction. Of a universal joint these are the shafts, not the arms of its cross.
    half_angle : float
        Half angle of the cone [rad], between 0 and pi.
    twist : (lower, upper) or None
        Limits of the twist [rad], less than a turn apart; None: it is free.
    stiffness, damping : float
        k > 0 [N m/rad], c >= 0 [N m s/rad].

    Raises
    ------
    ValueError
        For another joint, or limits out of their range. A run that starts from the reference pose, and that beyond a
        limit, is refused at its start.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, ConeStop, Spherical, System, simulate
    >>> arm = Body("arm", mass=2.0, inertia=(0.2, 0.2, 0.01), position=(0, 0, -0.5), com=(0, 0, 0))
    >>> ball = Spherical(GROUND, arm, at=(0, 0, 0))
    >>> stop = ConeStop(ball, axis_a=(0, 0, -1), half_angle=0.4, stiffness=5e3, damping=40.0)
    >>> leaning = System([arm], [ball], [stop], gravity=(9.81, 0, -1.0))
    >>> rest = simulate(leaning, 3.0).rotation(arm)[-1] @ (0, 0, -1)
    >>> import numpy as np
    >>> bool(0.4 < np.arccos(-rest[2]) < 0.402)  # it sinks in by 2 N m / 5 kN m
    True
    """

    law, law_parameters = staticmethod(cone_stop), CONE_STOP
    gap, gaps = staticmethod(cone_stop_gap), 3

    joint: Joint
    _: KW_ONLY
    axis_a: Direction = kept()
    axis_b: DirectionOrDerived = kept(default=None, derived=lambda stop: stop.axis_a)
    half_angle: Number = kept(positive=True)
    twist: RangeOrNone = kept(default=None)
    stiffness: Number = kept(positive=True)
    damping: Number = kept(default=0.0, minimum=0.0)

    def check(self, what: str) -> None:
        check_swings(self.joint, what)
        if not self.half_angle < np.pi:
            raise InputError(f"{what}: half_angle = {self.half_angle:g} limits nothing; give less than pi")
        if self.axis_a @ self.axis_b < OPPOSITE_COSINE:
            raise InputError(f"{what}: axis_a and axis_b are opposite, so the swing has no direction; reverse one")

    def depth_as_built(self) -> float:
        low, high = (0.0, 0.0) if self.twist is None else self.twist
        off = float(np.arctan2(np.linalg.norm(np.cross(self.axis_a, self.axis_b)), self.axis_a @ self.axis_b))
        return max(off - self.half_angle, low, -high, 0.0)

    def record(self) -> ForceRecord:
        low, high = (-np.inf, np.inf) if self.twist is None else self.twist
        middle = 0.0 if self.twist is None else 0.5 * (low + high)
        on_a, both = perpendiculars(self.axis_a), self.axis_a + self.axis_b
        on_b = [x - (x @ self.axis_b) / (1.0 + self.axis_a @ self.axis_b) * both for x in on_a]  # swung, not turned
        return ForceRecord(
            (self.joint.a, self.joint.b),
            frame=np.column_stack([*on_a, self.axis_a]), frame_b=np.column_stack([*on_b, self.axis_b]),
            parameters=self.read_by_law(middle_twist=middle, half_twist=high - middle),
        )  # fmt: skip

    def partners(self) -> tuple:
        return (self.joint,)


@inner_kernel
def turned(own, a, b):
    """Return (angle by which b has turned relative to a since it was built, its axis); 0 has no axis."""
    theta = turn_since(a, b, own.built)
    angle = np.sqrt(dot(theta, theta))
    return angle, scale(1.0 / angle if angle.real > 0.0 else 0.0 * angle, theta)


@inner_kernel
def rotation_stop(m, d, p, out, t):
    """Apply a moment against the turn beyond its limit, about its axis n: the rate of the angle is n . w."""
    own = rotation_stop_parameters(m.number, p.number)
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    angle, axis = turned(own, a, b)
    rate = dot(axis, sub(vec(b.w), vec(a.w)))
    load, elastic = stop_load(own.stiffness, own.damping, angle - own.angle, rate)
    out.potential = 0.5 * elastic * elastic / own.stiffness
    out.power = (elastic - load) * rate
    add_moment(a, scale(load, axis))
    add_moment(b, scale(-load, axis))


@inner_kernel
def rotation_stop_gap(m, d, p, limit, t, seen):
    """Store the distance to the limit of the rotation angle."""
    own = rotation_stop_parameters(m.number, p.number)
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    angle, axis = turned(own, a, b)
    see_gap(own.stiffness, own.damping, own.angle - angle, -dot(axis, sub(vec(b.w), vec(a.w))), seen)


@part_class()
class RotationStop(Stop):
    """Stop of a ball joint: limits the rotation of b from its reference orientation, about any axis.

    The turn is the length of the rotation vector theta of b relative to a, at most half a turn. Beyond the limit by d a
    moment ``max(0, k d + c d_dot)`` about theta acts against it on b, the opposite one on a. It never pulls. Energy
    ``k d^2 / 2``; the rest of the power is dissipated. (A `ConeStop` tells swing from twist.)

    Parameters
    ----------
    joint : Spherical, Universal or ConstantVelocity
    angle : float
        Limit of the turn [rad], between 0 and pi.
    stiffness, damping : float
        k > 0 [N m/rad], c >= 0 [N m s/rad].

    Raises
    ------
    ValueError
        For another joint, or an angle out of its range.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, RotationStop, Spherical, System, simulate
    >>> head = Body("head", mass=2.0, inertia=(0.2, 0.2, 0.2), omega=(0, 1.2, 1.6))
    >>> ball = Spherical(GROUND, head, at=(0, 0, 0))
    >>> stop = RotationStop(ball, angle=0.5, stiffness=80.0)
    >>> run = simulate(System([head], [ball], [stop]), 0.6)  # it turns at 2 rad/s, and comes back as fast
    >>> run.omega(head)[-1, 1:].round(6)
    array([-1.2, -1.6])
    """

    law, law_parameters = staticmethod(rotation_stop), ROTATION_STOP
    gap, gaps = staticmethod(rotation_stop_gap), 1

    joint: Joint
    _: KW_ONLY
    angle: Number = kept(positive=True)
    stiffness: Number = kept(positive=True)
    damping: Number = kept(default=0.0, minimum=0.0)

    def check(self, what: str) -> None:
        check_swings(self.joint, what)
        if not self.angle < np.pi:
            raise InputError(f"{what}: angle = {self.angle:g} limits nothing; give less than pi")

    def depth_as_built(self) -> float:
        return 0.0

    def record(self) -> ForceRecord:
        a, b = self.joint.a, self.joint.b
        return ForceRecord((a, b), parameters=self.read_by_law(built=built_turn(a, b)))

    def partners(self) -> tuple:
        return (self.joint,)
