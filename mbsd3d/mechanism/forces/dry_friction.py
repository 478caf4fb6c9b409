"""Dry friction of joints, by the reaction that presses them together while it acts."""

from dataclasses import KW_ONLY
from typing import NamedTuple

import numpy as np

from ...base.checks import short_repr
from ...base.errors import InputError
from ...base.fields import Number, NumberOrDerived, NumberOrNone, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import apply_along_gradient
from ...kernels.vectors import (
    add,
    arm,
    cross,
    dot,
    mat,
    pair,
    point,
    point_velocity,
    put,
    rotate,
    rotate_back,
    scale,
    sub,
    vec,
)
from ..bodies import describe_part
from ..couplings import GearMesh
from ..force_element import ForceElement, ForceRecord
from ..joints import AxisJoint, Joint
from ..joints.pairs import Cylindrical, Prismatic, Revolute, Screw, Spherical

PIN, GUIDE, BALL, THREAD, TEETH = range(5)  # what presses, and how it slips
SLIP_MIN = 1e-6  # [1] slip of teeth at the pitch point over the velocity there, below which they roll
SETTLING_DECELERATION = 10.0
"""[m/s^2 or rad/s^2] Deceleration by friction for which the elastic slip settles without ringing by default."""

DRY_FRICTION = Parameters(
    mu="-", excess="-", preload="N", lever="m or -", collar="m", length="m",
    slide="-", turn="m or -", spin="m", yields="rad or m", settles="s",
)  # fmt: skip
dry_friction_parameters = DRY_FRICTION.reader()


@inner_kernel
def joint_reaction(m, d, p):
    """Return the reaction of the joint on its body b: force, and moment about the joint's point on b."""
    b = d.body[p.body[1]]
    force, moment = scale(0.0, vec(b.w)), scale(0.0, vec(b.w))
    for k in range(p.row, p.row + p.rows):
        for slot in range(4):
            if m.row[k].body[slot] == p.body[1]:
                linear, angular = pair(d.row[k].J[slot])
                force = sub(force, scale(d.row[k].lam, linear))
                moment = sub(moment, scale(d.row[k].lam, angular))
    return force, sub(moment, cross(arm(b, p.point[1]), force))


@inner_kernel
def friction_axis(d, p):
    """Return the axis of the joint, fixed in a, world axes."""
    R, F = mat(d.body[p.body[0]].R), mat(p.frame[0])
    return rotate(R, (F[2], F[5], F[8]))


@inner_kernel
def pressing(m, d, p):
    """Return two vectors [N or N m], linear in the reaction, the sum of whose sizes presses: w = mu (|x| + |y| + ...).

    Pin: R F across and R_collar F along the axis. Guide: forces of the two pads, N/2 -+ k x M/L. Ball: R F. Thread:
    axial force over the cosines of lead and flank. Teeth: F.
    """
    own, (force, moment) = dry_friction_parameters(m.number, p.number), joint_reaction(m, d, p)
    if p.option >= BALL:
        if p.option == THREAD:
            axis = friction_axis(d, p)
            force = scale(dot(axis, force), axis)
        return scale(own.lever, force), scale(0.0, force)
    axis = friction_axis(d, p)
    along = scale(dot(axis, force), axis)
    across = sub(force, along)
    if p.option == PIN:
        return scale(own.lever, across), scale(own.collar, along)
    if own.length > 0.0:
        tilt = scale(1.0 / own.length, cross(axis, moment))
        half = scale(0.5, across)
        return sub(half, tilt), add(half, tilt)
    return across, scale(0.0, across)


@inner_kernel
def length_of(x):
    """Return |x|."""
    return np.sqrt(dot(x, x))


@inner_kernel
def friction_coefficient(m, p):
    """Return mu."""
    return dry_friction_parameters(m.number, p.number).mu


@inner_kernel
def friction_size(m, p, x, y):
    """Return w [N or N m] of the two pressing vectors."""
    own = dry_friction_parameters(m.number, p.number)
    return own.mu * (length_of(x) + length_of(y) + own.lever * own.preload)


@inner_kernel
def slip_velocity(m, d, p):
    """Return the slip velocity (3,), unused components zero, and the arms on a and b of the point where it is taken."""
    own, a, b = dry_friction_parameters(m.number, p.number), d.body[p.body[0]], d.body[p.body[1]]
    holder = d.body[p.body[p.bodies - 1]]
    place = point(holder, arm(holder, p.point[p.bodies - 1]))
    sa, sb = sub(place, vec(a.r)), sub(place, vec(b.r))
    velocity, w = sub(point_velocity(b, sb), point_velocity(a, sa)), sub(vec(b.w), vec(a.w))
    if p.option == BALL:
        return rotate_back(mat(a.R), w), sa, sb
    if p.option == TEETH:
        return rotate_back(mat(holder.R), velocity), sa, sb
    axis = friction_axis(d, p)
    turning = dot(axis, w)
    return (own.slide * dot(axis, velocity) + own.turn * turning, own.spin * turning, 0.0 * turning), sa, sb


@inner_kernel
def load_along(m, d, p, s):
    """Return force and moment on b that do the power s . slip velocity."""
    own = dry_friction_parameters(m.number, p.number)
    if p.option == BALL:
        moment = rotate(mat(d.body[p.body[0]].R), s)
        return scale(0.0, moment), moment
    if p.option == TEETH:
        force = rotate(mat(d.body[p.body[2]].R), s)
        return force, scale(0.0, force)
    axis = friction_axis(d, p)
    return scale(own.slide * s[0], axis), scale(own.turn * s[0] + own.spin * s[1], axis)


@inner_kernel
def slip_direction(m, d, p, v):
    """Return the direction s (3,) of the slip, of length 1 while it slips; set the rates of the elastic slip z.

    Elastic slip: s = (z + tau v) / y, cut to length 1 (at rest mu_static / mu); tau z_dot = y s - z.
    """
    own = dry_friction_parameters(m.number, p.number)
    if own.yields == 0.0:
        speed = length_of(v)
        return scale(1.0 / speed if speed.real > 0.0 else 0.0 * speed, v)
    first, zero = p.state, 0.0 * v[0]
    z = (d.z[first], d.z[first + 1] if p.states > 1 else zero, d.z[first + 2] if p.states > 2 else zero)
    s = scale(1.0 / own.yields, add(z, scale(own.settles, v)))
    creep = own.settles / own.yields
    most, size = 1.0 + own.excess / (1.0 + creep * creep * dot(v, v)), length_of(s)
    if size.real > most.real:
        s = scale(most / size, s)
    rate = scale(1.0 / own.settles, sub(scale(own.yields, s), z))
    for k in range(p.states):
        d.state_rate[first + k] = rate[k]
    return s


@inner_kernel
def dry_friction(m, d, p, out, t):
    """Load w against the slip, w by the multipliers at hand; the unit load stands in ``out.gradient``."""
    v, sa, sb = slip_velocity(m, d, p)
    s = slip_direction(m, d, p, v)
    force, moment = load_along(m, d, p, scale(-1.0, s))
    put(out.gradient[0], scale(-1.0, force))
    put(out.gradient[1], scale(-1.0, add(cross(sa, force), moment)))
    put(out.gradient[2], force)
    put(out.gradient[3], add(cross(sb, force), moment))
    x, y = pressing(m, d, p)
    out.load, out.rate = friction_size(m, p, x, y), -dot(s, v)
    if not np.isfinite(out.load.real):  # the multipliers at hand are those of a trial without a solution
        out.load = 0.0 * out.rate
    apply_along_gradient(d, p.body, out)
    out.power = out.load * out.rate


class Surface(NamedTuple):
    """What the friction of a kind of joint needs and may have, of the sizes of its surfaces."""

    joint: type[Joint]
    law: int
    needed: tuple[str, ...]
    optional: tuple[str, ...]
    states: int  # components of its elastic slip


SURFACES = (
    Surface(Revolute, PIN, ("pin_radius",), ("collar_radius",), 1),
    Surface(Prismatic, GUIDE, (), ("guide_length",), 1),
    Surface(Cylindrical, GUIDE, (), ("pin_radius", "guide_length"), 2),
    Surface(Spherical, BALL, ("ball_radius",), (), 3),
    Surface(Screw, THREAD, ("thread_radius",), ("flank_angle",), 1),
    Surface(GearMesh, TEETH, (), (), 3),
)
SIZES = ("pin_radius", "collar_radius", "ball_radius", "guide_length", "thread_radius", "flank_angle")


def settling_time(friction: "DryFriction") -> float:
    """Return the time in which a body that friction slows by `SETTLING_DECELERATION` settles without ringing [s]."""
    return 0.0 if friction.yields is None else 2.0 * float(np.sqrt(friction.yields / SETTLING_DECELERATION))


@part_class()
class DryFriction(ForceElement):
    """Dry friction of a joint by its own reaction: a load w = mu R |F| against the slip, F the reaction with w acting.

    ============= =============================================================== ==========================
    joint         w                                                               against
    ============= =============================================================== ==========================
    `Revolute`    ``mu (R_pin |F_across| + R_collar |F_along| + R_pin P)`` [N m]  the rate of its angle
    `Prismatic`   ``mu (|N/2 + k x M/L| + |N/2 - k x M/L| + P)`` [N]              the rate of its slide
    `Cylindrical` the same                                                        the slip (s', R_pin theta')
    `Spherical`   ``mu R_ball (|F| + P)`` [N m]                                   the relative omega
    `Screw`       ``mu (|W| + P) / (cos lam cos beta)`` [N]                       the slip along the thread
    `GearMesh`    ``mu (|F| + P)`` [N], of crossed axes                           the slip at the pitch point
    ============= =============================================================== ==========================

    N is the force across the axis k and M the moment at the joint's point on b, carried by two pads at +-L/2; in a
    plane that is ``mu max(|N|, 2 |M| / L)``. W is the axial force of a thread with the lead angle
    ``tan lam = pitch / (2 pi R)``: with the friction it needs ``W R tan(lam +- phi)``, ``tan phi = mu / cos beta``.

    w acts on the reaction, and the reaction on w: both are solved together in every evaluation, to rounding. The gain
    of friction on itself is the spectral radius of dg/dw, w = g(reaction under w). From 1 on there is no motion that
    meets the law, or more than one, and the run ends with an error. The certificate has the greatest gain of a run.

    Without ``yields`` friction acts as long as the joint slips. It has no direction at rest, so a joint that comes to
    rest and stays there ends the run with an error; one that turns back goes on. With ``yields = y`` it holds at rest,
    by an elastic slip z, an internal state: w s with ``s = (z + tau v) / y``, cut to length 1, and
    ``tau z' = y s - z``. It holds without creep; where it comes to rest errs by a few y, so it falls with y.

    Exact journals (friction circles) have ``mu / sqrt(1 + mu^2)`` in place of mu, as F is the whole reaction here.

    Parameters
    ----------
    joint : Revolute, Prismatic, Cylindrical, Spherical, Screw or GearMesh
    mu : float
        Coefficient of friction while it slips, >= 0.
    mu_static : float or None
        At rest, >= mu; None = mu. It takes ``yields``.
    preload : float
        P >= 0 [N], a force that presses besides the reaction, as of a seal or a clamp.
    yields : float or None
        y > 0 of hinges and balls [rad], of others [m]: elastic slip at which it lets go.
    settles : float or None
        tau > 0 [s], damping of the elastic slip over its stiffness; None = ``2 sqrt(y / 10)``, critical where friction
        decelerates by 10 m/s^2 or rad/s^2.
    pin_radius, collar_radius, ball_radius, guide_length, thread_radius : float or None
        Sizes of the surfaces [m] > 0, for the joints of the table; optional: collar_radius, guide_length, and
        pin_radius of a Cylindrical.
    flank_angle : float or None
        beta of a thread [rad], 0 <= beta < pi/2: half the angle between its flanks; None = 0.

    Raises
    ------
    ValueError
        For a joint without such a law, a size that it does not use or that is missing, mu_static < mu or without
        ``yields``, teeth that do not slip at the pitch point; at the start of a run where the joints do not determine
        what presses; of accelerations and linearisations of a joint at rest without ``yields``.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, DryFriction, Prismatic, System, accelerations
    >>> block = Body("block", mass=2.0, inertia=(0.01, 0.01, 0.01), velocity=(1.5, 0, 0))
    >>> guide = Prismatic(GROUND, block, at=(0, 0, 0), axis=(1, 0, 0))
    >>> system = System([block], [guide], [DryFriction(guide, mu=0.3)])
    >>> round(float(accelerations(system).acceleration(block)[0, 0]), 12)  # -0.3 g
    -2.943
    """

    law, law_parameters = staticmethod(dry_friction), DRY_FRICTION

    joint: Joint
    _: KW_ONLY
    mu: Number = kept(minimum=0.0)
    mu_static: NumberOrNone = kept(default=None, minimum=0.0)
    preload: Number = kept(default=0.0, minimum=0.0)
    yields: NumberOrNone = kept(default=None, positive=True)
    settles: NumberOrDerived = kept(default=None, minimum=0.0, derived=settling_time)
    pin_radius: NumberOrNone = kept(default=None, positive=True)
    collar_radius: NumberOrNone = kept(default=None, positive=True)
    ball_radius: NumberOrNone = kept(default=None, positive=True)
    guide_length: NumberOrNone = kept(default=None, positive=True)
    thread_radius: NumberOrNone = kept(default=None, positive=True)
    flank_angle: NumberOrNone = kept(default=None, minimum=0.0)

    def check(self, what: str) -> None:
        surface = self.surface(what)
        for name in SIZES:
            given, used = getattr(self, name) is not None, name in surface.needed + surface.optional
            if given and not used:
                has = ", ".join(surface.needed + surface.optional) or "no sizes"
                raise InputError(
                    f"{what}: {name} = {getattr(self, name):g}: the friction of {describe_part(self.joint)} has "
                    f"{has}; leave it out"
                )
            if name in surface.needed and not given:
                raise InputError(f"{what}: the friction of {describe_part(self.joint)} needs {name}; give it in metres")
        if self.flank_angle is not None and self.flank_angle >= np.pi / 2:
            raise InputError(f"{what}: flank_angle = {self.flank_angle:g} rad; give 0 <= flank_angle < pi/2")
        if self.mu_static is not None and self.mu_static < self.mu:
            raise InputError(f"{what}: mu_static = {self.mu_static:g} is below mu = {self.mu:g}; give at least mu")
        if self.mu_static is not None and self.mu_static > self.mu and (self.yields is None or self.mu == 0.0):
            raise InputError(
                f"{what}: mu_static = {self.mu_static:g} acts at rest, which takes yields= and mu > 0; give both"
            )
        if (self.yields is None) != (self.settles == 0.0):
            remedy = "give yields= too" if self.yields is None else "give a time > 0, or leave it out"
            raise InputError(f"{what}: settles = {self.settles:g} s is the time of an elastic slip; {remedy}")
        if isinstance(self.joint, GearMesh) and not slips(self.joint):
            raise InputError(
                f"{what}: the teeth of {describe_part(self.joint)} roll at the pitch point, without slip; give a mesh "
                "of crossed axes, as of a worm, or a Brake on a hinge for the loss"
            )

    def surface(self, what: str) -> Surface:
        """Return what the friction of the joint has."""
        for surface in SURFACES:
            if isinstance(self.joint, surface.joint):
                return surface
        given = describe_part(self.joint) if isinstance(self.joint, Joint) else short_repr(self.joint)
        known = ", ".join(surface.joint.__name__ for surface in SURFACES)
        raise InputError(f"{what}: {given} has no law of friction; give one of {known}")

    @property
    def lead_angle(self) -> float:
        """Return the lead angle of the thread [rad], 0 of other joints."""
        if not isinstance(self.joint, Screw) or self.thread_radius is None:
            return 0.0
        return float(np.arctan(self.joint.pitch / (2.0 * np.pi * self.thread_radius)))

    def arms(self) -> dict[str, float]:
        """Return lever of the reaction, and by what the slip follows from the rates of slide and angle."""
        if isinstance(self.joint, Screw):
            lam, beta, R = self.lead_angle, self.flank_angle or 0.0, self.thread_radius or 0.0
            lever = 1.0 / float(np.cos(lam) * np.cos(beta))
            return {"lever": lever, "slide": float(np.sin(lam)), "turn": R * float(np.cos(lam)), "spin": 0.0}
        turns = isinstance(self.joint, Revolute)
        radius = self.pin_radius if turns else self.ball_radius
        spin = 0.0 if turns else self.pin_radius or 0.0
        return {"lever": radius or 1.0, "slide": 0.0 if turns else 1.0, "turn": 1.0 if turns else 0.0, "spin": spin}

    def record(self) -> ForceRecord:
        joint, surface = self.joint, self.surface("")
        frame = np.column_stack([*joint.across, joint.axis]) if isinstance(joint, AxisJoint) else np.eye(3)
        holders = (joint.support(),) if isinstance(joint, GearMesh) else ()
        bodies = (joint.a, joint.b, *holders)
        excess = 0.0 if self.mu_static is None or self.mu == 0.0 else self.mu_static / self.mu - 1.0
        states = 0 if self.yields is None else surface.states
        given = {"collar": self.collar_radius or 0.0, "length": self.guide_length or 0.0, "excess": excess}
        return ForceRecord(
            bodies, (joint.point(),) * len(bodies), frame, option=surface.law, joint=joint,
            parameters=self.read_by_law(**given, **self.arms(), yields=self.yields or 0.0),
            states=(0.0,) * states, scales=((self.yields, 0.0, 0.0),) * states,
        )  # fmt: skip

    def partners(self) -> tuple:
        return (self.joint,)

    def state_names(self) -> tuple[str, ...]:
        count = len(self.record().states)
        return ("yielding",) if count == 1 else ("yielding x", "yielding y", "yielding z")[:count]


def slips(mesh: GearMesh) -> bool:
    """Return whether the teeth of a mesh slip along each other at the pitch point."""
    axles = mesh.axle(mesh.hinge_a), mesh.axle(mesh.hinge_b)
    first, second = (np.cross(axle.axis, axle.arm(mesh.at)) for axle in axles)
    return bool(np.linalg.norm(mesh.ratio * second - first) > SLIP_MIN * np.linalg.norm(first))
