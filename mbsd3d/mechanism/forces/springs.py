"""Springs, dampers and friction between two bodies."""

from dataclasses import KW_ONLY
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...base.fields import Number, NumberOrDerived, Vector, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import add_force, tanh
from ...kernels.vectors import add, arm, dot, point, point_velocity, scale, sub
from ..bodies import Body, Ground
from ..force_element import ForceElement, ForceRecord, check_pair, hinge_coordinate
from ..joints import Joint
from ..joints.conditions import ends_coincide, span

COINCIDENCE_ROUNDING = 1e-15  # [1] of the lengths that make the gap; 5 roundings: one below has no direction


SPRING = Parameters(stiffness="N/m", damping="N s/m", length="m")
spring_parameters = SPRING.reader()


@inner_kernel
def spring(m, d, p, out, t):
    """Force -(k (l - l0) + c l_dot) n on b along the line from a to b."""
    own = spring_parameters(m.number, p.number)
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    sa, sb = arm(a, p.point[0]), arm(b, p.point[1])
    pa, pb = point(a, sa), point(b, sb)
    gap, rate = sub(pb, pa), sub(point_velocity(b, sb), point_velocity(a, sa))
    length = np.sqrt(dot(gap, gap))
    reach = np.sqrt(dot(pa, pa) + dot(pb, pb) + dot(sa, sa) + dot(sb, sb))
    coincide = length.real <= COINCIDENCE_ROUNDING * reach.real
    if coincide and own.length.real == 0.0:
        pull = add(scale(own.stiffness, gap), scale(own.damping, rate))  # smooth; the gap opens along the rate
        out.potential = 0.5 * own.stiffness * dot(gap, gap)
        out.power = -own.damping * dot(rate, rate)
    else:
        n = scale(np.nan if coincide else 1.0 / length, gap)  # no direction: the run names the spring
        stretch, speed = length - own.length, dot(n, rate)
        pull = scale(own.stiffness * stretch + own.damping * speed, n)
        out.potential = 0.5 * own.stiffness * stretch * stretch
        out.power = -own.damping * speed * speed
    add_force(a, pull, sa)
    add_force(b, scale(-1.0, pull), sb)


def without_direction(what: str, length: float | None) -> str:
    """Return what to say of end points that coincide."""
    return (
        f"{what}: at_a and at_b coincide, so a force of length={length} has no direction; "
        f"give length=0 for a pull of stiffness times distance, or move one of them"
    )


def free_length(part: Any) -> float:
    """Return the distance between the end points of a spring [m]."""
    length = span(part)
    if length < 1e-12:
        raise InputError(without_direction(part.what(), None))
    return length


@part_class()
class SpringDamper(ForceElement):
    """Spring and damper between a point of body ``a`` and a point of body ``b``.

    The force on ``b`` is ``-(k (l - l0) + c l_dot) n``, with ``n`` from a to b and ``l`` the distance; the
    opposite force acts on ``a``. Energy ``k (l - l0)^2 / 2``; dissipated power ``c l_dot^2``.

    With ``length=0`` the elastic force is ``-k (p_b - p_a)`` in all directions, also where the end points meet. There
    the line of the damper has no direction, and its force is ``-c (v_b - v_a)``: that of a motion straight through.

    Parameters
    ----------
    at_a, at_b : (3,) array_like
        End points, world at the reference pose [m]; they may coincide where ``length`` is 0.
    stiffness, damping : float
        k >= 0 [N/m], c >= 0 [N s/m].
    length : float or None
        l0 >= 0 [m]; None = the distance at the reference pose.

    Raises
    ------
    ValueError
        If the end points coincide and the length is not 0: the force has no direction there.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, SpringDamper
    >>> bob = Body("bob", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, -1.5))
    >>> SpringDamper(GROUND, bob, at_a=(0, 0, 0), at_b=(0, 0, -1.5), stiffness=40.0).length
    1.5
    """

    law, law_parameters = staticmethod(spring), SPRING

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    at_a: Vector = kept()
    at_b: Vector = kept()
    stiffness: Number = kept(minimum=0.0)
    damping: Number = kept(default=0.0, minimum=0.0)
    length: NumberOrDerived = kept(default=None, minimum=0.0, derived=free_length)

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        if self.length > 0.0 and ends_coincide(self):
            raise InputError(without_direction(what, self.length))

    def record(self) -> ForceRecord:
        return ForceRecord((self.a, self.b), (self.at_a, self.at_b), parameters=self.read_by_law())


TORSION = Parameters(stiffness="N m/rad or N/m", damping="N m s/rad or N s/m", angle="rad or m")
torsion_parameters = TORSION.reader()


@inner_kernel
def torsion(m, d, p, out, t):
    """Load -(k (x - x0) + c x_dot) along a hinge coordinate."""
    own = torsion_parameters(m.number, p.number)
    stretch = out.x - own.angle
    out.load = -own.stiffness * stretch - own.damping * out.rate
    out.potential = 0.5 * own.stiffness * stretch * stretch
    out.power = -own.damping * out.rate * out.rate


@part_class()
class TorsionSpring(ForceElement):
    """Spring and damper about a hinge (or along a Prismatic): load -(k (x - x0) + c x_dot) on b, angles unwrapped.

    Energy ``k (x - x0)^2 / 2``; dissipated power ``c x_dot^2``.

    Parameters
    ----------
    stiffness, damping : float
        k >= 0 [N m/rad or N/m], c >= 0 [N m s/rad or N s/m].
    angle : float
        Unloaded value x0 [rad or m], counted from the reference pose.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System, TorsionSpring, accelerations
    >>> flap = Body("flap", mass=2.0, inertia=(0.1, 0.5, 0.5), com=(0.5, 0, 0))
    >>> hinge = Revolute(GROUND, flap, at=(0, 0, 0), axis=(0, 0, 1))
    >>> system = System([flap], [hinge], [TorsionSpring(hinge, stiffness=30.0, angle=0.2)])
    >>> round(float(accelerations(system).alpha(flap)[0, 2]), 12)  # 30 * 0.2 / (0.5 + 2 * 0.5^2)
    6.0
    """

    law, law_parameters = staticmethod(torsion), TORSION

    hinge: Joint
    _: KW_ONLY
    stiffness: Number = kept(minimum=0.0)
    damping: Number = kept(default=0.0, minimum=0.0)
    angle: Number = kept(default=0.0)

    def check(self, what: str) -> None:
        hinge_coordinate(self.hinge, what)

    def record(self) -> ForceRecord:
        x = hinge_coordinate(self.hinge, "")
        return ForceRecord((x.a, x.b), parameters=self.read_by_law(), coordinate=x)

    def partners(self) -> tuple:
        return (self.hinge,)


FRICTION = Parameters(coulomb="N m or N", viscous="N m s/rad or N s/m", transition="rad/s or m/s")
friction_parameters = FRICTION.reader()


@inner_kernel
def friction(m, d, p, out, t):
    """Load -(T tanh(x_dot / v0) + c x_dot) along a hinge coordinate."""
    own = friction_parameters(m.number, p.number)
    out.load = -own.coulomb * tanh(out.rate / own.transition) - own.viscous * out.rate
    out.power = out.load * out.rate


@part_class()
class JointFriction(ForceElement):
    """Dry and viscous friction in a hinge or slide: load -(T tanh(x_dot / v0) + c x_dot) on b; smooth at rest.

    Parameters
    ----------
    coulomb : float
        T >= 0 [N m or N], magnitude of the dry part.
    viscous : float
        c >= 0 [N m s/rad or N s/m].
    transition : float
        v0 > 0 [rad/s or m/s]; the dry part reaches 76 % of T at this speed.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, JointFriction, Revolute, System, accelerations
    >>> disc = Body("disc", mass=2.0, inertia=(0.3, 0.3, 0.5), omega=(0, 0, 5.0))
    >>> hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0, 1))
    >>> system = System([disc], [hinge], [JointFriction(hinge, coulomb=0.3, viscous=0.02)])
    >>> round(float(accelerations(system).alpha(disc)[0, 2]), 12)  # -(0.3 + 0.02 * 5) / 0.5
    -0.8
    """

    law, law_parameters = staticmethod(friction), FRICTION

    hinge: Joint
    _: KW_ONLY
    coulomb: Number = kept(default=0.0, minimum=0.0)
    viscous: Number = kept(default=0.0, minimum=0.0)
    transition: Number = kept(default=1e-2, positive=True)

    def check(self, what: str) -> None:
        hinge_coordinate(self.hinge, what)

    def record(self) -> ForceRecord:
        x = hinge_coordinate(self.hinge, "")
        return ForceRecord((x.a, x.b), parameters=self.read_by_law(), coordinate=x)

    def partners(self) -> tuple:
        return (self.hinge,)
