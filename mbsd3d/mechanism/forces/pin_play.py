"""Pins with radial clearance in their bearings: they move freely within it, and press and rub at its edge."""

from dataclasses import KW_ONLY
from functools import cached_property
from operator import attrgetter

import numpy as np

from ...base.errors import InputError
from ...base.fields import Direction, Number, NumberOrNone, Vector, VectorOrDerived, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels import kinds
from ...kernels.force_laws import add_force
from ...kernels.surfaces import pressure
from ...kernels.vectors import add, arm, dot, point, point_velocity, scale, sub, vec
from ..bodies import Body, Ground
from ..force_element import ForceRecord, check_pair
from ..joints import Joint
from ..joints.pairs import Planar
from ..measures import Measure, label
from ..primitives import Primitive
from ..switching import Mode, Watch
from .end_stop import YieldingOrRigidStop

PIN_PLAY = Parameters(
    axis=("1", 3), clearance="m", stiffness="N/m^m", exponent="1", damping="N s/m", loss="s/m", mu="1", creep="m/s",
    pin_radius="m",
)  # fmt: skip
pin_play_parameters = PIN_PLAY.reader()


@inner_kernel
def eccentricity(own, d, p):
    """Return (distance of the pin from the axis of its bearing, unit vector outwards there), both 0 at the axis."""
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    axis = arm(a, vec(own.axis))
    off = sub(point(b, arm(b, p.point[1])), point(a, arm(a, p.point[0])))
    off = sub(off, scale(dot(axis, off), axis))
    square = dot(off, off)
    if square.real > 0.0:
        distance = np.sqrt(square)
        return distance, scale(1.0 / distance, off)
    return 0.0 * square, scale(0.0, off)


@inner_kernel
def velocity_at(d, p, place):
    """Return the velocity of b relative to a at a place in space."""
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    return sub(point_velocity(b, sub(place, vec(b.r))), point_velocity(a, sub(place, vec(a.r))))


@inner_kernel
def pin_play(m, d, p, out, t):
    """Apply the force of the bearing on the pin where that is farther from the axis than the clearance."""
    own = pin_play_parameters(m.number, p.number)
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    distance, outwards = eccentricity(own, d, p)
    centre = point(b, arm(b, p.point[1]))
    speed = dot(outwards, velocity_at(d, p, centre))
    normal, elastic, depth = pressure(own, own.clearance - distance, speed)
    out.potential = elastic * depth / (own.exponent + 1.0)
    out.power = (elastic - normal) * speed
    place = add(centre, scale(own.pin_radius, outwards))
    slip = velocity_at(d, p, place)
    slip = sub(slip, scale(dot(outwards, slip), outwards))
    share = own.mu * normal / np.sqrt(dot(slip, slip) + own.creep * own.creep)
    out.power -= share * dot(slip, slip)
    force = sub(scale(-normal, outwards), scale(share, slip))
    add_force(b, force, sub(place, vec(b.r)))
    add_force(a, scale(-1.0, force), sub(place, vec(a.r)))


@inner_kernel
def pin_play_gap(m, d, p, limit, t, seen):
    """See how far the pin is from touch [m]."""
    own = pin_play_parameters(m.number, p.number)
    distance, outwards = eccentricity(own, d, p)
    speed = dot(outwards, velocity_at(d, p, point(d.body[p.body[1]], arm(d.body[p.body[1]], p.point[1]))))
    gap = own.clearance - distance
    _, elastic, _ = pressure(own, gap, speed)
    seen[0], seen[1], seen[3] = gap, -speed, elastic * (1.0 + own.loss * speed) + own.damping * speed


@part_class()
class PinPlay(YieldingOrRigidStop):
    """A pin of b with radial clearance in a bearing of a: free within the clearance, pressed back beyond it.

    With the distance e of the pin from the axis of the bearing and the depth d = e - clearance > 0, across the axis:

    - normal force ``N = k d^m (1 + x d_dot) + c d_dot``, never below 0, towards the axis. By Lankarani and Nikravesh
      ``x = 3 (1 - r^2) / (4 v)`` of a restitution r at an impact speed v, with m = 1.5;
    - friction ``mu N V / sqrt(V'V + creep^2)`` against the slip V of the surfaces where they touch, at ``pin_radius``
      from the centre of the pin. It is smooth, and creeps at rest.

    Energy ``k d^(m+1) / (m+1)``; the rest of the power is dissipated. Nothing acts along the axis or against tilting:
    with ``guide``, a `Planar` joint, in the system all but the clearance is held as by a `Revolute`. Two of them apart
    on one shaft hold it as two bearings do.

    With ``restitution=r`` instead of a stiffness pin and bearing are rigid and smooth: the pin is struck at events,
    comes back with r times its speed along the normal, and slides round the bearing where its hops end, until the load
    changes sign; see `EndStop`. That needs the ``guide``.

    Parameters
    ----------
    a, b : Body or GROUND
        That have the bearing and the pin.
    at : (3,) array_like
        Centre of bearing and pin, world at the reference pose [m]; ``at_b``: that of the pin, where it differs.
    axis : (3,) array_like
        Of the bearing, fixed in a; world at the reference pose.
    clearance : float
        Radius of the bearing less that of the pin > 0 [m].
    stiffness, exponent, damping, loss : float
        k > 0 [N/m^m], m >= 1, c >= 0 [N s/m] and x >= 0 [s/m].
    mu, creep, pin_radius : float
        mu >= 0; creep > 0 [m/s] and radius >= 0 [m] of the pin, with mu only.
    restitution : float
        r of 0 ... 1.

    Raises
    ------
    ValueError
        For both stiffness and restitution, what belongs to the other one, friction without ``creep``, or bodies that do
        not differ. A run that starts from the reference pose with the pin beyond the clearance is refused, of rigid
        ones every run that does.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, PinPlay, System, simulate
    >>> rod = Body("rod", mass=2.0, inertia=(0.1, 0.1, 0.1))
    >>> pin = PinPlay(GROUND, rod, at=(0, 0, 0), axis=(0, 1, 0), clearance=1e-3, stiffness=1e6, exponent=1, damping=900)
    >>> run = simulate(System([rod], [pin.guide], [pin]), 1.0, output=2)
    >>> round(float(run.position(rod)[-1, 2]), 7)  # 1 mm of play, and 2 kg on 1 N/um
    -0.0010196
    """

    law, law_parameters = staticmethod(pin_play), PIN_PLAY
    gap, gaps = staticmethod(pin_play_gap), 1
    leaves = "lifts off"
    in_metres = True

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    at: Vector = kept()
    at_b: VectorOrDerived = kept(default=None, derived=attrgetter("at"))
    axis: Direction = kept()
    clearance: Number = kept(positive=True)
    stiffness: NumberOrNone = kept(default=None, positive=True)
    exponent: Number = kept(default=1.5, minimum=1.0)
    damping: Number = kept(default=0.0, minimum=0.0)
    loss: Number = kept(default=0.0, minimum=0.0)
    mu: Number = kept(default=0.0, minimum=0.0)
    creep: NumberOrNone = kept(default=None, positive=True)
    pin_radius: Number = kept(default=0.0, minimum=0.0)
    restitution: NumberOrNone = kept(default=None, minimum=0.0)

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        self.check_law(what)
        if self.restitution is not None and (self.loss or self.mu):
            raise InputError(f"{what}: a rigid pin is smooth and has no loss; give stiffness= for loss= and mu=")
        if (self.mu > 0.0) != (self.creep is not None):
            raise InputError(
                f"{what}: mu = {self.mu:g} with creep = {self.creep}; friction needs both, creep being "
                "the slip speed [m/s] below which it fades"
            )
        if self.pin_radius and not self.mu:
            raise InputError(f"{what}: pin_radius does nothing without mu; leave it out, or give mu and creep")

    @cached_property
    def guide(self) -> Planar:
        """Return the joint that holds the rest as a hinge does: along the axis, and against tilting."""
        name = None if self.name is None else f"guide of {self.name}"
        return Planar(self.a, self.b, at=self.at, at_b=self.at_b, normal=self.axis, name=name)

    @property
    def limits(self) -> tuple[float, float]:
        return (-np.inf, self.clearance)

    @property
    def play(self) -> Measure:
        """Return the measure of the distance of the pin from the centre of the bearing [m], for ``stop_when``."""
        return Measure("distance", f"play of {label(self)}", "m", self.a, self.b, self.at, self.at_b)

    def value_measure(self) -> Measure:
        return self.play

    def watched(self, mode: Mode) -> list[Watch]:
        return self.watch_load(mode) if self.holds(mode) else [Watch(self.play > self.clearance, "touches")]

    def depth_as_built(self) -> float:
        off = self.at_b - self.at
        return max(self.depth(float(np.linalg.norm(off - (self.axis @ off) * self.axis))), 0.0)

    def row_at(self, value: float) -> Primitive:
        return Primitive(kinds.DISTANCE, (self.a, self.b), points=(self.at, self.at_b), values=(value,))

    def point(self) -> np.ndarray:
        """Return the centre of the pin (world, reference pose)."""
        return self.at_b

    def bodies(self) -> tuple[Body | Ground, ...]:
        return (self.a, self.b)

    def partners(self) -> tuple[Joint, ...]:
        return ()

    def record(self) -> ForceRecord:
        own = {"axis": self.a.local_axis(self.axis), "creep": self.creep or 1.0, "stiffness": self.stiffness or 0.0}
        return ForceRecord((self.a, self.b), (self.at, self.at_b), parameters=self.read_by_law(**own))
