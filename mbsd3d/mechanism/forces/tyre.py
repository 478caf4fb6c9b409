"""Tyres: a torus pressed into a plane, two deflections with relaxation lengths, and the brush curve of their forces."""

from dataclasses import KW_ONLY
from functools import cached_property
from operator import attrgetter
from typing import Any, ClassVar

import numpy as np

from ...base.checks import number
from ...base.errors import InputError
from ...base.fields import (
    Direction,
    Number,
    NumberOrNone,
    VectorOrDerived,
    kept,
    part_class,
    true_or_false,
)
from ...base.rotations import cross as cross_product
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import add_force, add_moment, tanh
from ...kernels.signals import signal
from ...kernels.vectors import add, arm, cross, dot, mat, point, point_velocity, put, rotate, scale, sub, vec
from ..bodies import GROUND, Body, Ground, as_body
from ..contacts import Plane, level_plane
from ..force_element import ForceElement, ForceRecord, check_pair
from ..rounded import Rounded, circle
from ..signals import Signal, SignalOrNone, as_signal

LOAD_FACTOR_MIN = 0.1
"""Share of grip and stiffness that no load takes away."""
FULL_SLIDING_DEFLECTION = 1.5
"""Deflection, in units of that of full grip, from which all of the contact patch slides."""


@inner_kernel
def clamp_below(x, least):
    """Return x, but no less than a number."""
    return x if x.real > least else least + 0.0 * x


@inner_kernel
def load_factor(k, load):
    """Share 1 - k (N/N0 - 1) of a coefficient that is left at a load, given as N/N0."""
    return clamp_below(1.0 - k * (load - 1.0), LOAD_FACTOR_MIN)


@inner_kernel
def brush_force_and_trail(q):
    """Return (force over that of the linear tyre, trail over that at rest) at a linear force of q times the grip.

    With the theoretical slip s = q/(1 - q/3) the force is mu N (1 - (1 - s/3)^3): the steady deflection under s is q.
    """
    force, trail = 1.0 + 0.0 * q, 1.0 + 0.0 * q
    if q.real < FULL_SLIDING_DEFLECTION:
        s = q / (1.0 - q / 3.0)
        rest, adhesion = 1.0 - s / 3.0, 1.0 - s / 3.0 + s * s / 27.0
        force, trail = adhesion / (1.0 - q / 3.0), rest * rest * rest / adhesion
    else:
        force, trail = 1.0 / q, 0.0 * q
    return force, trail


ROLLING_RESISTANCE_SPEED, ALIGNING_MOMENT_SPEED = 0.05, 0.01
"""Speeds [m/s] of the tread and of the hub at which rolling resistance and moment about the normal reach 76 %."""
FRICTION_MIN = 0.01
"""Least grip: with less, deflections of a sliding wheel come and go in microseconds; wet ice has 0.05."""
DEFLECTION_SCALE = 0.1
"""Size of the deflections at full grip."""


TYRE = Parameters(
    ring="m", crown="m", stiffness="N/m", damping="N s/m", longitudinal="1/rad", cornering="1/rad", camber="1/rad",
    relaxation_x="m", relaxation="m", trail="m", rolling_resistance="1", nominal_load="N", grip_sensitivity="1",
    stiffness_sensitivity="1", standing_damping="s/m", standing_speed="m/s", twisting="m",
)  # fmt: skip
tyre_parameters = TYRE.reader()


@inner_kernel
def tyre(m, d, p, out, t):
    """Apply the forces of a tyre at its contact point and set its rates of deflection; option 1: camber without lag."""
    own = tyre_parameters(m.number, p.number)
    ground, wheel, z = d.body[p.body[0]], d.body[p.body[1]], d.z[p.state : p.state + 2]
    n = rotate(mat(ground.R), (p.frame[0, 2], p.frame[0, 5], p.frame[0, 8]))
    axle = rotate(mat(wheel.R), (p.frame[1, 0], p.frame[1, 3], p.frame[1, 6]))
    lean = dot(axle, n)  # its sine, to the right
    level = 1.0 / np.sqrt(1.0 - lean * lean)
    ahead = scale(level, cross(axle, n))
    left = cross(n, ahead)
    hub = arm(wheel, p.point[1])
    lowest = add(hub, scale(own.ring * level, sub(scale(lean, axle), n)))  # of the circle of tube centres
    above = sub(point(wheel, lowest), point(ground, arm(ground, p.point[0])))
    height = dot(above, n)
    s = sub(lowest, scale(height, n))  # the contact point from O of the wheel,
    s_ground = sub(point(wheel, s), vec(ground.r))  # and from O of the ground
    there = point_velocity(ground, s_ground)
    v, w = sub(point_velocity(wheel, s), there), sub(vec(wheel.w), vec(ground.w))
    speed = dot(sub(point_velocity(wheel, hub), there), ahead)
    slip_x, slip_y, climb = dot(v, ahead), dot(v, left), dot(v, n)

    sink = own.crown - height
    spring = own.stiffness * sink if sink.real > 0.0 else 0.0 * sink
    N = spring - own.damping * climb
    if sink.real <= 0.0 or N.real <= 0.0:
        N = 0.0 * N  # neither tension nor a pull on release
    load = N / own.nominal_load
    share = load_factor(own.stiffness_sensitivity, load)
    C_x, C_y, C_g = share * own.longitudinal, share * own.cornering, share * own.camber
    instant = float(p.option)

    V = speed if speed.real >= 0.0 else -speed
    grip = speed * 0.0 + np.inf
    limit = 0.0 * V
    if p.signal[0] >= 0:
        grip = clamp_below(signal(m, p.signal[0], t)[0], FRICTION_MIN) * load_factor(own.grip_sensitivity, load)
        limit = np.sqrt(C_x * C_x * slip_x * slip_x + C_y * C_y * slip_y * slip_y) / (3.0 * grip)
    d.state_rate[p.state] = (-slip_x - (V + limit) * z[0]) / own.relaxation_x
    lag = (1.0 - instant) * V * C_g / C_y * lean
    d.state_rate[p.state + 1] = (-slip_y - lag - (V + limit) * z[1]) / own.relaxation

    slow = speed / own.standing_speed
    damping = own.standing_damping / (1.0 + slow * slow)
    pull_x, pull_y = C_x * z[0] - damping * slip_x, C_y * z[1] - damping * slip_y
    q, force, trail = 0.0 * V, 1.0 + 0.0 * V, 1.0 + 0.0 * V
    if p.signal[0] >= 0:
        q = np.sqrt(pull_x * pull_x + pull_y * pull_y) / grip
        force, trail = brush_force_and_trail(q)
    F_x, F_y = N * force * pull_x, N * (force * pull_y - instant * C_g * lean)
    by_slip = N * force * (pull_y + (1.0 - instant) * C_g * lean)
    M_z = tanh(speed / ALIGNING_MOMENT_SPEED) * (N * own.twisting * lean - own.trail * trail * by_slip)
    reach = sub(s, hub)
    radius = np.sqrt(dot(reach, reach))
    M_y = -own.rolling_resistance * N * radius * tanh(dot(w, axle) * radius / ROLLING_RESISTANCE_SPEED)

    F = add(scale(N, n), add(scale(F_x, ahead), scale(F_y, left)))
    M = add(scale(M_y, left), scale(M_z, n))
    add_force(wheel, F, s)
    add_force(ground, scale(-1.0, F), s_ground)
    add_moment(wheel, M)
    add_moment(ground, scale(-1.0, M))
    out.potential = 0.5 * spring * sink
    out.power = dot(F, v) + dot(M, w) - spring * climb
    put(out.shown, point(wheel, s))
    put(out.shown[3:6], (N, F_x, F_y))
    put(out.shown[6:9], (M_z, slip_x, slip_y))
    put(out.shown[9:12], (V, lean, force * q))


def as_wheel(value: Any, what: str, part: Any) -> Body:
    """Accept a body, not the ground."""
    if value is GROUND:
        raise InputError(f"{what.removesuffix(': b')}: the ground has no tyre; give (ground, wheel)")
    return as_body(value, what, part)


def as_grip(value: Any, what: str, part: Any) -> Signal | None:
    """Convert to a signal above 0, or None."""
    if value is not None and not isinstance(value, Signal):
        number(value, what, positive=True)
    return None if value is None else as_signal(value, what)


@part_class()
class Tyre(ForceElement):
    """A tyre of wheel b on a plane of a: spring and damper along the normal, slip forces with relaxation lengths.

    The tyre is a torus with the outer ``radius`` and the tube radius ``crown`` that the plane presses flat by ``d``.
    At P, its lowest point put onto the plane, N = k d + c d' >= 0 presses. With the slip velocities V_x (ahead) and V_y
    (left) of the wheel at P, the speed V of the hub ahead, and the sine of the lean to the right, the internal states
    "longitudinal" and "lateral", deflections over relaxation lengths, follow

        s_x z_x' = -V_x - (|V| + W) z_x
        s_y z_y' = -V_y - |V| C_g/C_y sin(lean) - (|V| + W) z_y,     W = |(C_x V_x, C_y V_y)|/(3 mu)

    which holds at rest too. The forces are those of the brush model, with q = |C z|/mu:

        F = mu N (1 - (1 - s/3)^3) C z/|C z|,     s = q/(1 - q/3), 3 from q = 1.5 on

    so in steady running s is the theoretical slip, and F never leaves the circle mu N. Moments about P: about the
    normal tanh(V/(0.01 m/s)) (m_g N sin(lean) - t (1 - s/3)^3/(1 - s/3 + s^2/27) F_s), with the part F_s of F_y that is
    not by camber: what acts behind P acts before it where it rolls back. About the left the rolling resistance
    -f N r tanh(r spin/(0.05 m/s)). Energy k d^2/2; the rest of the power is counted.

    Parameters
    ----------
    axis : (3,) array_like
        Axle, to the left of a wheel that rolls forward, world at the reference pose.
    radius, crown : float
        Of the tyre without load [m], outside and of its tube, 0 <= crown <= radius.
    stiffness, damping : float
        k > 0 [N/m], c >= 0 [N s/m] of the normal force.
    cornering, longitudinal, camber : float
        C_y > 0, C_x > 0 (None = C_y), C_g [1/rad]: stiffnesses over the load.
    relaxation, relaxation_x : float
        s_y > 0, s_x > 0 (None = s_y) [m].
    mu : float, Signal or None
        Grip > 0, that counts as 0.01 where it is less; None = no limit, a linear tyre.
    trail, twisting : float
        t [m], m_g [m]; the camber force has no trail.
    rolling_resistance : float
        f >= 0.
    nominal_load : float or None
        N0 [N], at which grip and stiffnesses have the values given.
    grip_sensitivity, stiffness_sensitivity : float
        k in x (1 - k (N/N0 - 1)) for mu and for C_x, C_y, C_g; at least a tenth of x is left.
    standing_damping, standing_speed : float
        c_0 [s/m] and V_0 [m/s]: -c_0 V_xy/(1 + (V/V_0)^2) is added to C z. About 0.5 s/m keeps a parked wheel from
        ringing; it is within the circle too.
    camber_lag : bool
        False: the camber force has no lag, -C_g N sin(lean) beside the brush and its circle.
    centre : (3,) array_like or None
        Hub, world [m]; None = centre of mass of the wheel.
    plane : (point, normal) or None
        Plane fixed in a, world at the reference pose; None = z = 0.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, System, Tyre, accelerations
    >>> wheel = Body("wheel", mass=20.0, inertia=(0.5, 1.0, 0.5), position=(0, 0, 0.299))
    >>> tyre = Tyre(GROUND, wheel, axis=(0, 1, 0), radius=0.3, crown=0.02, stiffness=1.5e5)
    >>> round(float(accelerations(System([wheel], forces=[tyre])).acceleration(wheel)[0, 2]), 9)  # 150/20 - g
    -2.31
    """

    law, law_parameters = staticmethod(tyre), TYRE
    shows: ClassVar[tuple[str, ...]] = (
        "normal", "longitudinal", "lateral", "aligning", "slip_x", "slip_y", "speed", "camber", "saturation",
    )  # fmt: skip

    a: Body | Ground
    b: Body = kept(by=as_wheel)
    _: KW_ONLY
    axis: Direction = kept()
    radius: Number = kept(positive=True)
    crown: Number = kept(default=0.0, minimum=0.0)
    stiffness: Number = kept(positive=True)
    damping: Number = kept(default=400.0, minimum=0.0)
    cornering: Number = kept(default=14.0, positive=True)
    longitudinal: NumberOrNone = kept(default=None, positive=True)  # None stays, and follows what `replace` changes
    camber: Number = kept(default=0.0)
    relaxation: Number = kept(default=0.1, positive=True)
    relaxation_x: NumberOrNone = kept(default=None, positive=True)
    mu: SignalOrNone = kept(default=0.9, by=as_grip)
    trail: Number = kept(default=0.0, minimum=0.0)
    twisting: Number = kept(default=0.0)
    rolling_resistance: Number = kept(default=0.0, minimum=0.0)
    nominal_load: NumberOrNone = kept(default=None, positive=True)
    grip_sensitivity: Number = kept(default=0.0, minimum=0.0)
    stiffness_sensitivity: Number = kept(default=0.0, minimum=0.0)
    standing_damping: Number = kept(default=0.0, minimum=0.0)
    standing_speed: Number = kept(default=0.1, positive=True)
    camber_lag: bool = kept(default=True, by=true_or_false)
    centre: VectorOrDerived = kept(default=None, derived=attrgetter("b.centre"))
    plane: Plane = kept(default=None, derived=level_plane)

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        if self.crown > self.radius:
            raise InputError(f"{what}: crown {self.crown} exceeds the outer radius {self.radius}; give crown <= radius")
        if self.nominal_load is None and (self.grip_sensitivity or self.stiffness_sensitivity):
            raise InputError(f"{what}: sensitive to the load, but without nominal_load; give it in N")
        if abs(cross_product(self.axis, self.plane[1])).max() < 1e-9:
            raise InputError(f"{what}: the wheel lies flat on the plane, so it has no contact point; tilt its axis")

    @cached_property
    def ahead(self) -> tuple[float, float]:
        """Return c_x [1/rad] and s_x [m], given or those of the lateral direction."""
        return (
            self.cornering if self.longitudinal is None else self.longitudinal,
            self.relaxation if self.relaxation_x is None else self.relaxation_x,
        )

    @cached_property
    def outline(self) -> Rounded:
        """Return the unloaded torus, world at the reference pose."""
        return circle(self.centre, self.axis, self.radius - self.crown, self.crown)

    def signal_unit(self) -> str:
        return "1"

    def record(self) -> ForceRecord:
        C_x, s_x = self.ahead
        return ForceRecord(
            (self.a, self.b), (self.plane[0], self.centre), signals=(self.mu, None, None),
            frame=np.column_stack([self.axis, np.zeros(3), self.plane[1]]), option=int(not self.camber_lag),
            parameters=self.read_by_law(
                ring=self.radius - self.crown, longitudinal=C_x, relaxation_x=s_x, nominal_load=self.nominal_load or 1.0
            ),
            states=(0.0, 0.0), scales=((DEFLECTION_SCALE, 0.0, 0.0), (DEFLECTION_SCALE, 0.0, 0.0)),
        )  # fmt: skip

    def state_names(self) -> tuple[str, ...]:
        return ("longitudinal", "lateral")
