"""Springs, dampers, bushings and friction between two bodies."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...base.checks import number, vector
from ...base.rotations import as_quaternion, matrix
from ...kernels import kinds
from ..bodies import Body, Ground
from ..force_element import ForceElement, ForceRecord, check_pair, hinge_coordinate
from ..joints import Joint


@dataclass(frozen=True, eq=False)
class SpringDamper(ForceElement):
    """Spring and damper between a point of body ``a`` and a point of body ``b``.

    The force on ``b`` is ``-(k (l - l0) + c l_dot) n``, with ``n`` from a to b and ``l`` the distance; the
    opposite force acts on ``a``. Energy ``k (l - l0)^2 / 2``; dissipated power ``c l_dot^2``.

    Parameters
    ----------
    at_a, at_b : (3,) array_like
        End points, world at the reference pose [m].
    stiffness, damping : float
        k >= 0 [N/m], c >= 0 [N s/m].
    length : float or None
        l0 >= 0 [m]; None = the distance at the reference pose.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, SpringDamper
    >>> bob = Body("bob", mass=1.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, -1.5))
    >>> SpringDamper(GROUND, bob, at_a=(0, 0, 0), at_b=(0, 0, -1.5), stiffness=40.0).length
    1.5
    """

    a: Any
    b: Any
    at_a: Any = field(kw_only=True)
    at_b: Any = field(kw_only=True)
    stiffness: float = field(kw_only=True)
    damping: float = field(default=0.0, kw_only=True)
    length: float | None = field(default=None, kw_only=True)

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        at_a, at_b = vector(self.at_a, f"{what}: at_a"), vector(self.at_b, f"{what}: at_b")
        span = float(np.linalg.norm(at_b - at_a))
        if span < 1e-12:
            raise ValueError(f"{what}: the end points coincide, so the force has no direction; move one of them")
        self.set(
            at_a=at_a,
            at_b=at_b,
            stiffness=number(self.stiffness, f"{what}: stiffness", minimum=0.0),
            damping=number(self.damping, f"{what}: damping", minimum=0.0),
            length=span if self.length is None else number(self.length, f"{what}: length", minimum=0.0),
        )

    def record(self) -> ForceRecord:
        values = (self.stiffness, self.damping, self.length)
        return ForceRecord(kinds.SPRING, (self.a, self.b), (self.at_a, self.at_b), values=values)


@dataclass(frozen=True, eq=False)
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

    hinge: Joint
    stiffness: float = field(kw_only=True)
    damping: float = field(default=0.0, kw_only=True)
    angle: float = field(default=0.0, kw_only=True)

    def check(self, what: str) -> None:
        hinge_coordinate(self.hinge, what)
        self.set(
            stiffness=number(self.stiffness, f"{what}: stiffness", minimum=0.0),
            damping=number(self.damping, f"{what}: damping", minimum=0.0),
            angle=number(self.angle, f"{what}: angle"),
        )

    def record(self) -> ForceRecord:
        x = hinge_coordinate(self.hinge, "")
        values = (self.stiffness, self.damping, self.angle)
        return ForceRecord(kinds.COORDINATE_SPRING, (x.a, x.b), values=values, coordinate=x)

    def partners(self) -> tuple:
        return (self.hinge,)


@dataclass(frozen=True, eq=False)
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

    hinge: Joint
    coulomb: float = field(default=0.0, kw_only=True)
    viscous: float = field(default=0.0, kw_only=True)
    transition: float = field(default=1e-2, kw_only=True)

    def check(self, what: str) -> None:
        hinge_coordinate(self.hinge, what)
        self.set(
            coulomb=number(self.coulomb, f"{what}: coulomb", minimum=0.0),
            viscous=number(self.viscous, f"{what}: viscous", minimum=0.0),
            transition=number(self.transition, f"{what}: transition", positive=True),
        )

    def record(self) -> ForceRecord:
        x = hinge_coordinate(self.hinge, "")
        values = (self.coulomb, self.viscous, self.transition)
        return ForceRecord(kinds.FRICTION, (x.a, x.b), values=values, coordinate=x)

    def partners(self) -> tuple:
        return (self.hinge,)


@dataclass(frozen=True, eq=False)
class Bushing(ForceElement):
    """Elastic joint between a and b: linear in the displacement of a point and in the relative rotation.

    In the axes F fixed in a, with d the displacement of the point of b, and (p0, p) the relative quaternion:
    force on b ``-(K d + C d_dot)``, moment ``-2 (p0 K_r p + p x K_r p) - C_r w``. Energy ``d'K d / 2 + 2 p'K_r p``
    (``theta' K_r theta / 2`` for small rotations); valid below half a turn.

    Parameters
    ----------
    at : (3,) array_like
        The point, world at the reference pose [m].
    stiffness, damping : float or (3,) array_like
        Along the element's axes [N/m], [N s/m].
    turning_stiffness, turning_damping : float or (3,) array_like
        About the element's axes [N m/rad], [N m s/rad].
    axes : (4,) or (3, 3) array_like
        Orientation of the element's axes, world at the reference pose.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Bushing, System, accelerations
    >>> engine = Body("engine", mass=2.0, inertia=(0.1, 0.1, 0.1), velocity=(0, 0, 0.5))
    >>> mount = Bushing(GROUND, engine, at=(0, 0, 0), stiffness=400.0, damping=(3.0, 3.0, 8.0))
    >>> system = System([engine], forces=[mount], gravity=(0, 0, 0))
    >>> round(float(accelerations(system).acceleration(engine)[0, 2]), 12)  # -8 * 0.5 / 2
    -2.0
    """

    a: Any
    b: Any
    at: Any = field(kw_only=True)
    stiffness: Any = field(kw_only=True)
    turning_stiffness: Any = field(default=0.0, kw_only=True)
    damping: Any = field(default=0.0, kw_only=True)
    turning_damping: Any = field(default=0.0, kw_only=True)
    axes: Any = field(default=(1.0, 0.0, 0.0, 0.0), kw_only=True)

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        self.set(at=vector(self.at, f"{what}: at"), axes=as_quaternion(self.axes, f"{what}: axes"))
        for name in ("stiffness", "turning_stiffness", "damping", "turning_damping"):
            value = getattr(self, name)
            three = vector((value,) * 3 if np.ndim(value) == 0 else value, f"{what}: {name}")
            if (three < 0).any():
                raise ValueError(f"{what}: {name} {three.tolist()} has a negative entry; give numbers >= 0")
            self.set(**{name: three})

    def record(self) -> ForceRecord:
        values = (*self.stiffness, *self.turning_stiffness, *self.damping, *self.turning_damping)
        return ForceRecord(kinds.BUSHING, (self.a, self.b), (self.at, self.at), frame=matrix(self.axes), values=values)

    def acts_at(self, body: Body | Ground) -> tuple[Body | Ground, np.ndarray]:
        return self.b, self.at  # also on a: the force acts where the point of b is
