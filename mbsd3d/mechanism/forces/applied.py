"""Forces and torques that act on one body."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import number, vector
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import add_force, add_moment, components
from ...kernels.vectors import add, arm, dot, mat, point_velocity, rotate, scale, sub, vec
from ..bodies import GROUND, Body
from ..force_element import ForceElement, ForceRecord, check_body, in_body_frame
from ..signals import Signal, three_signals


@inner_kernel
def given(m, d, p, t):
    """Return the components of a load in world axes; option 1: they are given in body axes."""
    body, x = d.body[p.body[1]], components(m, p, t)
    return rotate(mat(body.R), x) if p.option == 1 else add(x, scale(0.0, vec(body.w)))


@inner_kernel
def force(m, d, p, out, t):
    """Force with given components at a point."""
    body, load = d.body[p.body[1]], given(m, d, p, t)
    s = arm(body, p.point[1])
    add_force(body, load, s)
    out.power = dot(load, point_velocity(body, s))


@dataclass(frozen=True, eq=False)
class Force(ForceElement):
    """A force [N] at a point of a body; components are numbers or signals, in world or body axes.

    ``at`` None is the centre of mass. Its work is counted, it stores no energy.

    Examples
    --------
    >>> from mbsd3d import Body, Force, Sine, System, accelerations
    >>> box = Body("box", mass=2.0, inertia=(0.1, 0.1, 0.1))
    >>> system = System([box], forces=[Force(box, (3.0, 0, Sine(5.0, 2.0)))], gravity=(0, 0, 0))
    >>> round(float(accelerations(system).acceleration(box)[0, 0]), 12)
    1.5
    """

    law = staticmethod(force)

    body: Body
    force: Sequence[Signal | float]
    at: ArrayLike | None = None
    frame: str = "world"

    def check(self, what: str) -> None:
        check_body(self.body, what)
        at = self.body.centre if self.at is None else vector(self.at, f"{what}: at")
        in_body_frame(self.frame, what)
        self.set(force=three_signals(self.force, f"{what}: force"), at=at)

    def record(self) -> ForceRecord:
        option = in_body_frame(self.frame, "")
        return ForceRecord((GROUND, self.body), (self.at, self.at), option=option, signals=self.force)


@inner_kernel
def torque(m, d, p, out, t):
    """Torque with given components."""
    body, load = d.body[p.body[1]], given(m, d, p, t)
    add_moment(body, load)
    out.power = dot(load, vec(body.w))


@dataclass(frozen=True, eq=False)
class Torque(ForceElement):
    """A torque [N m] on a body; components are numbers or signals, in world or body axes.

    Examples
    --------
    >>> from mbsd3d import Body, System, Torque, accelerations
    >>> rotor = Body("rotor", mass=2.0, inertia=(0.3, 0.3, 0.4))
    >>> system = System([rotor], forces=[Torque(rotor, (0, 0, 0.6))], gravity=(0, 0, 0))
    >>> round(float(accelerations(system).alpha(rotor)[0, 2]), 12)
    1.5
    """

    law = staticmethod(torque)

    body: Body
    torque: Sequence[Signal | float]
    frame: str = "world"

    def check(self, what: str) -> None:
        check_body(self.body, what)
        in_body_frame(self.frame, what)
        self.set(torque=three_signals(self.torque, f"{what}: torque"))

    def record(self) -> ForceRecord:
        return ForceRecord((GROUND, self.body), option=in_body_frame(self.frame, ""), signals=self.torque)


DRAG = Parameters(density="kg/m^3", drag_area="m^2")
drag_parameters = DRAG.reader()


@inner_kernel
def drag(m, d, p, out, t):
    """Aerodynamic drag -rho/2 (c_d A) |v| v at a point, v relative to the wind."""
    own = drag_parameters(m.number, p.number)
    body = d.body[p.body[1]]
    s = arm(body, p.point[1])
    v = sub(point_velocity(body, s), components(m, p, t))
    force = scale(-(0.5 * own.density * own.drag_area) * np.sqrt(dot(v, v)), v)
    add_force(body, force, s)
    out.power = dot(force, point_velocity(body, s))


@dataclass(frozen=True, eq=False)
class AeroDrag(ForceElement):
    """Drag -rho/2 (c_d A) |u| u at a point of a body, u its velocity relative to the wind.

    Parameters
    ----------
    drag_area : float
        c_d A >= 0 [m^2].
    density : float
        rho > 0 [kg/m^3].
    at : (3,) array_like or None
        Centre of pressure, world at the reference pose [m]; None = centre of mass.
    wind : three numbers or signals
        Velocity of the air, world [m/s].

    Examples
    --------
    >>> from mbsd3d import AeroDrag, Body, System, accelerations
    >>> kite = Body("kite", mass=3.0, inertia=(0.1, 0.1, 0.1), velocity=(6.0, 0, 0))
    >>> system = System([kite], forces=[AeroDrag(kite, drag_area=0.5, density=1.2, wind=(-4.0, 0, 0))])
    >>> round(float(accelerations(system).acceleration(kite)[0, 0]), 12)  # -0.5 * 1.2 * 0.5 * 10^2 / 3
    -10.0
    """

    law, law_parameters = staticmethod(drag), DRAG

    body: Body
    drag_area: float = field(kw_only=True)
    density: float = field(default=1.225, kw_only=True)
    at: ArrayLike | None = field(default=None, kw_only=True)
    wind: Sequence[Signal | float] = field(default=(0.0, 0.0, 0.0), kw_only=True)

    def check(self, what: str) -> None:
        check_body(self.body, what)
        self.set(
            drag_area=number(self.drag_area, f"{what}: drag_area", minimum=0.0),
            density=number(self.density, f"{what}: density", positive=True),
            at=self.body.centre if self.at is None else vector(self.at, f"{what}: at"),
            wind=three_signals(self.wind, f"{what}: wind"),
        )

    def record(self) -> ForceRecord:
        return ForceRecord((GROUND, self.body), (self.at, self.at), parameters=self.read_by_law(), signals=self.wind)
