"""Dry friction of joints, by the reaction that presses them together while it acts."""

from collections.abc import Iterable
from dataclasses import KW_ONLY
from typing import Any, ClassVar, NamedTuple

import numpy as np

from ...base.checks import short_repr
from ...base.errors import InputError
from ...base.fields import Number, NumberOrDerived, NumberOrNone, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import apply_along_gradient
from ...kernels.measures import joint_reaction
from ...kernels.vectors import (
    add,
    arm,
    cross,
    dot,
    mat,
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
from ..force_element import ForceRecord
from ..joints import AxisJoint, Joint, angle_of, slide_of
from ..joints.pairs import Cylindrical, Prismatic, Revolute, Screw, Spherical
from ..lock import Lock
from ..measures import Condition, Measure, label
from ..primitives import Coordinate, Primitive, ratio
from ..signals import Constant
from ..switching import OPEN, Mode, Watch

PIN, GUIDE, BALL, THREAD, TEETH = range(5)  # what presses, and how it slips
SLIP_MIN = 1e-6  # [1] slip of teeth at the pitch point over the velocity there, below which they roll
LEAVING_RATES = 10.0  # [1] times what counts as no rate: a joint at rest that is held by no row has left it
NUMBERS_OF_MODES = {"open": 0, "slipping": 1, "resting": 2, "held": 1}  # sense; sense and rate; place
STOPS = "stops"  # what is watched while it slips
SETTLING_DECELERATION = 10.0
"""[m/s^2 or rad/s^2] Deceleration by friction for which the elastic slip settles without ringing by default."""

DRY_FRICTION = Parameters(
    mu="-", excess="-", preload="N", lever="m or -", collar="m", length="m",
    slide="-", turn="m or -", spin="m", yields="rad or m", settles="s", known="-", x="-", y="-", z="-",
)  # fmt: skip
dry_friction_parameters = DRY_FRICTION.reader()


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
    if own.length.real > 0.0:
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

    It is (x, y, z) where it is known from the events of a run, zero where a row holds the joint. Elastic slip:
    s = (z + tau v) / y, cut to length 1 (at rest mu_static / mu); tau z_dot = y s - z.
    """
    own = dry_friction_parameters(m.number, p.number)
    if own.known.real > 0.0:
        rest = 0.0 * v[0]
        return own.x + rest, own.y + rest, own.z + rest
    if own.yields.real == 0.0:
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
    """Surface dimensions that the friction of a joint type requires or accepts."""

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


class Slip(NamedTuple):
    """Slip of a joint along one coordinate: factor times the coordinate."""

    coordinate: Coordinate
    factor: float  # [1, m/rad], > 0
    direction: np.ndarray  # (3,) unit, of the slip as the law has it
    row: Primitive  # slip = 0, with the multiplier along it


class Efficiency(NamedTuple):
    """Output power over input power if friction is the only loss; <= 0 if it is self-locking."""

    forward: float  # a screw that is turned, gear a of a mesh that drives
    back: float  # a thread under its axial load, gear b that drives


SIZES = ("pin_radius", "collar_radius", "ball_radius", "guide_length", "thread_radius", "flank_angle")


def settling_time(friction: "DryFriction") -> float:
    """Return the time in which a body that friction slows by `SETTLING_DECELERATION` settles without ringing [s]."""
    return 0.0 if friction.yields is None else 2.0 * float(np.sqrt(friction.yields / SETTLING_DECELERATION))


@part_class()
class DryFriction(Lock):
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

    Sticking is exact: where the slip comes to rest, an event of the run, one row holds the joint as long as its load
    stays within ``mu_static`` in place of mu; else it slips on or turns back at once. Where several joints that move
    together come to rest, one row holds all, and the others bear their static friction in full: their sum is what the
    motion asks for, each share is one of many. A `Spherical`, and a `Cylindrical` with ``pin_radius``, slip in more
    than one way and are not held by a row.

    With ``yields = y`` it holds by an elastic slip z instead, an internal state: w s with ``s = (z + tau v) / y``, cut
    to length 1, and ``tau z' = y s - z``. It holds without creep; its position at rest errs by a few y. Use it with
    `Stepper`, which looks for no events, and for a joint whose reactions are not determined at rest.

    For threads and teeth `efficiency` and `self_locking` follow from the dimensions alone.

    Exact journals (friction circles) have ``mu / sqrt(1 + mu^2)`` in place of mu, as F is the whole reaction here.

    Parameters
    ----------
    joint : Revolute, Prismatic, Cylindrical, Spherical, Screw or GearMesh
    mu : float
        Coefficient of friction while it slips, >= 0.
    mu_static : float or None
        At rest, >= mu; None = mu.
    preload : float
        P >= 0 [N], a force that presses besides the reaction, as of a seal or a clamp.
    yields : float or None
        y > 0 of hinges and balls [rad], of others [m]: elastic slip at which it lets go.
    settles : float or None
        tau > 0 [s], damping of the elastic slip over its stiffness; None = ``2 sqrt(y / 10)``, critical where friction
        decelerates by 10 m/s^2 or rad/s^2.
    pin_radius, collar_radius, ball_radius, guide_length, thread_radius : float or None
        Dimensions of the surfaces [m] > 0, for the joints of the table; optional: collar_radius, guide_length, and
        pin_radius of a Cylindrical.
    flank_angle : float or None
        beta of a thread [rad], 0 <= beta < pi/2: half the angle between its flanks; None = 0.

    Raises
    ------
    ValueError
        For a joint without such a law, a size that it does not use or that is missing, mu_static < mu, or mu_static of
        a joint that no row holds without ``yields``; teeth that do not slip at the pitch point; at the start of a run
        where the joints do not determine what presses.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, DryFriction, Prismatic, System, accelerations, simulate
    >>> block = Body("block", mass=2.0, inertia=(0.01, 0.01, 0.01), velocity=(1.5, 0, 0))
    >>> guide = Prismatic(GROUND, block, at=(0, 0, 0), axis=(1, 0, 0))
    >>> system = System([block], [guide], [DryFriction(guide, mu=0.3, name="pads")])
    >>> round(float(accelerations(system).acceleration(block)[0, 0]), 12)  # -0.3 g
    -2.943
    >>> run = simulate(system, 1.0)
    >>> run.events[0].what, round(run.events[0].t, 9), round(float(run.slide(guide)[-1]), 9)  # v / 0.3 g, v^2 / 0.6 g
    ("'pads' sticks", 0.509683996, 0.382262997)
    """

    one_sided: ClassVar[bool] = False
    sticks: ClassVar[bool] = True
    leaves: ClassVar[str] = "slips"
    without_events: ClassVar[str] = "give it yields="
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
        if isinstance(self.joint, GearMesh) and not slips(self.joint):
            raise InputError(
                f"{what}: the teeth of {describe_part(self.joint)} roll at the pitch point, without slip; give a mesh "
                "of crossed axes, as of a worm, or a Brake on a hinge for the loss"
            )
        if self.mu_static is not None and self.mu_static < self.mu:
            raise InputError(f"{what}: mu_static = {self.mu_static:g} is below mu = {self.mu:g}; give at least mu")
        if self.mu_static is not None and self.mu_static > self.mu:
            if self.yields is None and not self.one_way:
                raise InputError(
                    f"{what}: mu_static = {self.mu_static:g}: {describe_part(self.joint)} slips in more than one way, "
                    "so no row holds it; give yields= too"
                )
            if self.yields is not None and self.mu == 0.0:
                raise InputError(f"{what}: mu = 0 has no elastic slip; give mu > 0, or leave out yields")
        if (self.yields is None) != (self.settles == 0.0):
            remedy = "give yields= too" if self.yields is None else "give a time > 0, or leave it out"
            raise InputError(f"{what}: settles = {self.settles:g} s is the time of an elastic slip; {remedy}")

    def surface(self, what: str) -> Surface:
        """Return the surface dimensions that the friction of this joint uses."""
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

    @property
    def efficiency(self) -> Efficiency:
        """Return the efficiency of a thread or of teeth at even speed, of what drives forwards and backwards.

        With p the power of the normal force, t and s what friction takes beside the drive and beside the driven part:
        ``(p - s) / (p + t)`` forwards, ``(p - t) / (p + s)`` backwards.
        """
        p, t, s = self.shares_of_power()
        return Efficiency((p - s) / (p + t), (p - t) / (p + s))

    @property
    def self_locking(self) -> bool:
        """Return whether the friction of a thread or of teeth at rest holds any load that would drive it backwards."""
        p, t, _ = self.shares_of_power(self.greatest_mu)
        return p <= t

    def shares_of_power(self, mu: float | None = None) -> tuple[float, float, float]:
        """Return the powers (p, t, s) of a unit normal force and its friction per rate of what drives."""
        mu = self.mu if mu is None else mu
        if isinstance(self.joint, GearMesh):
            first, second = pitch_velocities(self.joint)
            slip = (second - first) / np.linalg.norm(second - first)
            p = float(abs(self.joint.direction() @ first))
            return p, -mu * float(slip @ first), mu * float(slip @ second)
        if isinstance(self.joint, Screw):
            own, lead = self.arms(), self.joint.pitch / (2.0 * np.pi)
            return abs(lead), mu * own["lever"] * own["turn"], mu * own["lever"] * own["slide"] * lead
        raise InputError(f"{self.what()}: {describe_part(self.joint)} transmits nothing; ask a Screw or a GearMesh")

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

    @property
    def one_way(self) -> bool:
        """Return whether the joint slips along one coordinate."""
        around = isinstance(self.joint, Cylindrical) and self.pin_radius is not None
        return not around and not isinstance(self.joint, Spherical)

    @property
    def slip(self) -> Slip:
        """Return how a joint slips that does so along one coordinate."""
        joint = self.joint
        if isinstance(joint, GearMesh):
            first, second = pitch_velocities(joint)
            factor = float(np.linalg.norm(second - first))
            n = (second - first) / factor
            row = joint.row_along(n)
            return Slip(row.coordinates[0], factor, joint.support().local_axis(n), row)
        if isinstance(joint, Screw):
            own, lead = self.arms(), joint.pitch / (2.0 * np.pi)
            row = ratio(angle_of(joint), own["turn"], slide_of(joint), own["slide"], in_metres=True)
            return Slip(angle_of(joint), own["turn"] + lead * own["slide"], np.eye(3)[0], row)
        x = angle_of(joint) if isinstance(joint, Revolute) else slide_of(joint)
        return Slip(x, 1.0, np.eye(3)[0], ratio(x, 1.0, in_metres=x.kind != "angle"))

    @property
    def switches(self) -> bool:
        """Return whether a constraint equation holds the joint when it sticks."""
        return self.yields is None and self.greatest_mu > 0.0 and self.one_way

    @property
    def needs_slip(self) -> bool:
        """Return whether nothing holds the joint at rest, where its friction has no direction."""
        return self.yields is None and self.greatest_mu > 0.0 and not self.one_way

    @property
    def greatest_mu(self) -> float:
        """Return the coefficient at rest."""
        return self.mu if self.mu_static is None else self.mu_static

    def record(self) -> ForceRecord:
        return self.record_in(OPEN)

    def record_in(self, mode: Mode) -> ForceRecord:
        """Return what its law reads: by velocity in the mode "open", else in a sense that is known."""
        joint, surface, known = self.joint, self.surface(""), mode.name != OPEN.name
        x, y, z = mode.numbers[0] * self.slip.direction if known and not self.holds(mode) else np.zeros(3)
        mu = self.mu if mode.name in (OPEN.name, "slipping") else self.greatest_mu
        frame = np.column_stack([*joint.across, joint.axis]) if isinstance(joint, AxisJoint) else np.eye(3)
        holders = (joint.support(),) if isinstance(joint, GearMesh) else ()
        bodies = (joint.a, joint.b, *holders)
        excess = 0.0 if self.mu_static is None or self.mu == 0.0 else self.mu_static / self.mu - 1.0
        states = 0 if self.yields is None else surface.states
        given = {"mu": mu, "collar": self.collar_radius or 0.0, "length": self.guide_length or 0.0, "excess": excess}
        given |= {"known": float(known), "x": x, "y": y, "z": z}
        return ForceRecord(
            bodies, (joint.point(),) * len(bodies), frame, option=surface.law, joint=joint,
            parameters=self.read_by_law(**given, **self.arms(), yields=self.yields or 0.0),
            states=(0.0,) * states, scales=((self.yields, 0.0, 0.0),) * states,
        )  # fmt: skip

    def through(self) -> Joint:
        return self.joint

    def coordinate(self) -> Coordinate:
        return self.slip.coordinate

    def rows_in(self, mode: Mode) -> list[Primitive]:
        if len(mode.numbers) != NUMBERS_OF_MODES.get(mode.name, -1):
            raise InputError(f"{self.what()}: mode {short_repr(tuple(mode))} is unknown; give a state of a run")
        if not self.holds(mode):
            return []
        return [self.slip.row._replace(signal=Constant(mode.numbers[0]))]

    @property
    def in_metres(self) -> bool:
        return self.slip.row.in_metres

    def opened(self, mode: Mode) -> Mode:
        return waiting(1.0 if self.holds(mode) or mode.name == OPEN.name else mode.numbers[0] or 1.0)

    def idle(self, mode: Mode) -> Mode:
        return waiting(0.0)

    def moving(self, mode: Mode, rate: float, slow: float) -> Mode:
        return mode if abs(rate) <= slow else slipping(rate)

    def yielding(self, mode: Mode, load: float) -> Mode:
        return slipping(-load)

    def after(self, mode: Mode, watch: Watch) -> Mode:
        return slipping(-watch.condition.direction) if self.holds(mode) else mode

    def outcome(self, before: Mode, after: Mode, action: str) -> str:
        if action != STOPS:
            return "reaches its limit" if after.name == "resting" and self.holds(before) else action
        if after.name != "slipping":
            return "sticks"
        return "slips on" if after == before else "turns back"

    def excess(self, load: float, mode: Mode, capacity: float) -> float:
        return abs(load) - capacity

    def returns(self, a: float, held: Mode, free: Mode) -> float:
        return -free.numbers[0] * a

    def starts(self, a: float, slow: float, free: Mode, others_hold: bool) -> Mode:
        if free.name == "resting":
            return slipping(a) if (free.numbers[0] * a if free.numbers[0] else abs(a)) > slow else free
        return waiting(free.numbers[0]) if others_hold and abs(a) <= slow else free

    def helps(self, free: Mode, rate: float) -> bool:
        return free.name == "resting" and free.numbers[0] * rate < 0.0

    def resting(self, mode: Mode, slow: float) -> Mode:
        return waiting(mode.numbers[0], LEAVING_RATES * slow / self.slip.factor) if mode.name == "resting" else mode

    def touching(self, mode: Mode, x: float, rate: float, slack: float, slow: float) -> Mode | None:
        if self.holds(mode):
            return mode
        return Mode("held", (x,)) if abs(rate) <= slow else None

    def watched(self, mode: Mode) -> list[Watch]:
        rate = self.rate_measure()
        if self.holds(mode):
            return [Watch(Condition(self.excess_measure(sign), 0.0, sign), self.leaves) for sign in (1.0, -1.0)]
        if mode.name == "resting":
            return [Watch(rate > mode.numbers[1], self.leaves), Watch(rate < -mode.numbers[1], self.leaves)]
        return [Watch(Condition(rate, 0.0, -mode.numbers[0]), STOPS)] if mode.name == "slipping" else []

    def excess_measure(self, sign: float) -> Measure:
        """Return the load of the row less the limit of a sign."""
        unit = "N m" if isinstance(self.joint, Revolute) else "N"
        return Measure(
            "excess load", f"load of {label(self)} beyond friction", unit, part=self, axis=sign * np.eye(3)[0]
        )

    def state_names(self) -> tuple[str, ...]:
        count = len(self.record().states)
        return ("yielding",) if count == 1 else ("yielding x", "yielding y", "yielding z")[:count]


def slipping(sense: float) -> Mode:
    """Return the mode of a joint that slips in the sense of a rate."""
    return Mode("slipping", (float(np.copysign(1.0, sense)),))


def waiting(sense: float, rate: float = 0.0) -> Mode:
    """Return the mode of a joint at rest that another one holds, under its friction in a sense, 0: under none.

    ``rate`` of its coordinate: from there on it has left rest.
    """
    return Mode("resting", (float(np.sign(sense)), rate))


def frictions_of_teeth(joints: Iterable[Any], forces: Iterable[Any]) -> list[DryFriction]:
    """Return the friction of every mesh that has a coefficient and no friction among the forces."""
    known = {id(x.joint) for x in forces if isinstance(x, DryFriction)}
    return [
        DryFriction(x, mu=x.mu, name=x.name and f"friction of {x.name}")
        for x in joints
        if isinstance(x, GearMesh) and x.mu is not None and id(x) not in known
    ]


def pitch_velocities(mesh: GearMesh) -> tuple[np.ndarray, np.ndarray]:
    """Return the velocities (3,) of both gears at the pitch point per rate of gear a [m]."""
    axles = mesh.axle(mesh.hinge_a), mesh.axle(mesh.hinge_b)
    first, second = (np.cross(axle.axis, axle.arm(mesh.at)) for axle in axles)
    return first, mesh.ratio * second


def slips(mesh: GearMesh) -> bool:
    """Return whether the teeth of a mesh slip along each other at the pitch point."""
    first, second = pitch_velocities(mesh)
    return bool(np.linalg.norm(second - first) > SLIP_MIN * np.linalg.norm(first))
