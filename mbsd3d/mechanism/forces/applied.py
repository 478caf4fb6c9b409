"""Forces and torques that act on one body."""

from dataclasses import KW_ONLY
from operator import attrgetter

import numpy as np

from ...base.fields import Number, VectorOrDerived, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import add_force, add_moment, components
from ...kernels.vectors import add, arm, dot, mat, point_velocity, rotate, scale, sub, vec
from ..bodies import GROUND, Body, as_body
from ..force_element import ForceElement, ForceRecord, in_body_frame
from ..signals import ThreeSignals


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


@part_class()
class Force(ForceElement):
    """A force [N] at a point of a body; components are numbers or signals, in world or body axes.

    Its work enters the energy balance; it stores no energy.

    Parameters
    ----------
    body : Body
        Body on which it acts.
    force : three numbers or signals
        Components [N].
    at : (3,), optional
        Point of the body [m], world axes at the reference pose, fixed to the body; by default the centre of mass.
    frame : "world" or "body"
        Axes of the components: fixed in space, or those of the body.
    name : str, optional
        For results and messages; "Force 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import Body, Force, Sine, System, accelerations
    >>> box = Body("box", mass=2.0, inertia=(0.1, 0.1, 0.1))
    >>> system = System([box], forces=[Force(box, (3.0, 0, Sine(5.0, 2.0)))], gravity=(0, 0, 0))
    >>> round(float(accelerations(system).acceleration(box)[0, 0]), 12)
    1.5
    """

    law = staticmethod(force)

    body: Body = kept(by=as_body)
    force: ThreeSignals = kept()
    at: VectorOrDerived = kept(default=None, derived=attrgetter("body.centre"))
    frame: str = "world"

    def check(self, what: str) -> None:
        in_body_frame(self.frame, what)

    def signal_unit(self) -> str:
        return "N"

    def record(self) -> ForceRecord:
        option = in_body_frame(self.frame, "")
        return ForceRecord((GROUND, self.body), (self.at, self.at), option=option, signals=self.force)


@inner_kernel
def torque(m, d, p, out, t):
    """Apply a torque with given components."""
    body, load = d.body[p.body[1]], given(m, d, p, t)
    add_moment(body, load)
    out.power = dot(load, vec(body.w))


@part_class()
class Torque(ForceElement):
    """A torque [N m] on a body; components are numbers or signals, in world or body axes.

    Its work enters the energy balance; it stores no energy.

    Parameters
    ----------
    body : Body
        Body on which it acts.
    torque : three numbers or signals
        Components [N m].
    frame : "world" or "body"
        Axes of the components: fixed in space, or those of the body.
    name : str, optional
        For results and messages; "Torque 1" and so on by default.

    Examples
    --------
    >>> from mbsd3d import Body, System, Torque, simulate
    >>> rotor = Body("rotor", mass=2.0, inertia=(0.3, 0.3, 0.4))
    >>> system = System([rotor], forces=[Torque(rotor, (0, 0, 0.6), name="motor")], gravity=(0, 0, 0))
    >>> run = simulate(system, 2.0)
    >>> float(run.omega(rotor)[-1, 2].round(9)), float(run.work("motor")[-1].round(9))  # T t / I, and half I omega^2
    (3.0, 1.8)
    """

    law = staticmethod(torque)

    body: Body = kept(by=as_body)
    torque: ThreeSignals = kept()
    frame: str = "world"

    def check(self, what: str) -> None:
        in_body_frame(self.frame, what)

    def signal_unit(self) -> str:
        return "N m"

    def record(self) -> ForceRecord:
        return ForceRecord((GROUND, self.body), option=in_body_frame(self.frame, ""), signals=self.torque)


DRAG = Parameters(density="kg/m^3", drag_area="m^2")
drag_parameters = DRAG.reader()


@inner_kernel
def drag(m, d, p, out, t):
    """Apply the aerodynamic drag -rho/2 (c_d A) |v| v at a point, v relative to the wind."""
    own = drag_parameters(m.number, p.number)
    body = d.body[p.body[1]]
    s = arm(body, p.point[1])
    v = sub(point_velocity(body, s), components(m, p, t))
    force = scale(-(0.5 * own.density * own.drag_area) * np.sqrt(dot(v, v)), v)
    add_force(body, force, s)
    out.power = dot(force, point_velocity(body, s))


@part_class()
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

    body: Body = kept(by=as_body)
    _: KW_ONLY
    drag_area: Number = kept(minimum=0.0)
    density: Number = kept(default=1.225, positive=True)
    at: VectorOrDerived = kept(default=None, derived=attrgetter("body.centre"))
    wind: ThreeSignals = kept(default=(0.0, 0.0, 0.0))

    def signal_unit(self) -> str:
        return "m/s"

    def record(self) -> ForceRecord:
        return ForceRecord((GROUND, self.body), (self.at, self.at), parameters=self.read_by_law(), signals=self.wind)
