"""Drag of a box in a fluid at rest: inertial by its faces, viscous as that of a ball."""

from dataclasses import KW_ONLY
from operator import attrgetter

import numpy as np

from ...base.fields import Number, Orientation, VectorOrDerived, kept, part_class
from ...base.rotations import matrix
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import add_force, add_moment
from ...kernels.vectors import arm, columns, dot, point_velocity, vec
from ..bodies import GROUND, Body, as_body
from ..force_element import ForceElement, ForceRecord
from .bushing import OneOrThree, into_axes, out_of_axes

FLUID_DRAG = Parameters(lengths=("m", 3), density="kg/m^3", viscosity="Pa s")
fluid_drag_parameters = FLUID_DRAG.reader()


@inner_kernel
def signed_square(x):
    """Return |x| x of a real or complex number."""
    square = x * x
    if x.real < 0.0:
        square = -square
    return square


@inner_kernel
def resisted(inertial, viscous, x):
    """Return -(k_i |x_i| x_i + c x_i)."""
    return (
        -inertial[0] * signed_square(x[0]) - viscous * x[0],
        -inertial[1] * signed_square(x[1]) - viscous * x[1],
        -inertial[2] * signed_square(x[2]) - viscous * x[2],
    )


@inner_kernel
def fluid_drag(m, d, p, out, t):
    """Force and moment on a box with edges L in its axes: see `FluidDrag`."""
    own = fluid_drag_parameters(m.number, p.number)
    body, (a, b, c) = d.body[p.body[1]], vec(own.lengths)
    F, s = columns(body, p.frame[1]), arm(body, p.point[1])
    v, w = into_axes(F, point_velocity(body, s)), into_axes(F, vec(body.w))
    k, g, mean = 0.5 * own.density, own.density / 64.0, (a + b + c) / 3.0
    faces = (k * b * c, k * c * a, k * a * b)
    arms = (g * a * (b**4 + c**4), g * b * (c**4 + a**4), g * c * (a**4 + b**4))
    force = resisted(faces, 3.0 * np.pi * own.viscosity * mean, v)
    moment = resisted(arms, np.pi * own.viscosity * mean**3, w)
    add_force(body, out_of_axes(F, force), s)
    add_moment(body, out_of_axes(F, moment))
    out.power = dot(force, v) + dot(moment, w)


@part_class()
class FluidDrag(ForceElement):
    """Drag of a box with edges L in a fluid at rest; v is the velocity of its centre, w the spin, in the box's axes.

    ``f_i = -rho/2 L_j L_k |v_i| v_i - 3 pi mu L_m v_i``, moment
    ``-rho/64 L_i (L_j^4 + L_k^4) |w_i| w_i - pi mu L_m^3 w_i``, with ``L_m`` the mean of the edges: pressure on the
    faces, and the viscous drag of a ball. The fluid has no mass of its own and does not lift.

    Parameters
    ----------
    lengths : (3,) array_like or float
        L >= 0, edges along the axes [m].
    density, viscosity : float
        rho >= 0 [kg/m^3] and mu >= 0 [Pa s] of the fluid.
    at : (3,) array_like or None
        Centre of the box, world at the reference pose [m]; None = centre of mass.
    axes : (4,) or (3, 3) array_like
        Axes of the box at the reference pose -> world, unit quaternion, scalar first, or matrix; the body carries them.

    Examples
    --------
    >>> from mbsd3d import Body, FluidDrag, System, accelerations
    >>> plate = Body("plate", mass=0.5, inertia=(0.01, 0.01, 0.02), velocity=(0, 0, -2.0))
    >>> drag = FluidDrag(plate, lengths=(0.3, 0.2, 0.01), density=1000.0)
    >>> at = accelerations(System([plate], forces=[drag], gravity=(0, 0, 0)))
    >>> round(float(at.acceleration(plate)[0, 2]), 9)  # 500 * 0.3 * 0.2 * 2^2 N on 0.5 kg
    240.0
    """

    law, law_parameters = staticmethod(fluid_drag), FLUID_DRAG

    body: Body = kept(by=as_body)
    _: KW_ONLY
    lengths: OneOrThree = kept()
    density: Number = kept(default=0.0, minimum=0.0)
    viscosity: Number = kept(default=0.0, minimum=0.0)
    at: VectorOrDerived = kept(default=None, derived=attrgetter("body.centre"))
    axes: Orientation = kept(default=(1.0, 0.0, 0.0, 0.0))

    def record(self) -> ForceRecord:
        on = (GROUND, self.body)
        return ForceRecord(on, (self.at, self.at), frame=matrix(self.axes), parameters=self.read_by_law())
