"""Weight in a rotating frame, and the attraction by a nearby centre."""

from dataclasses import KW_ONLY

import numpy as np

from ...base.errors import InputError
from ...base.fields import Number, Vector, kept, part_class
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import add_force, add_moment
from ...kernels.vectors import (
    add,
    arm,
    columns,
    cross,
    dot,
    mat,
    point,
    point_velocity,
    rotate,
    rotate_back,
    scale,
    sub,
    vec,
)  # fmt: skip
from ..bodies import Body, Ground
from ..force_element import ForceElement, ForceRecord, check_body, check_pair
from .bushing import out_of_axes

WEIGHT = Parameters(acceleration=("m/s^2", 3))
weight_parameters = WEIGHT.reader()


@inner_kernel
def weight(m, d, p, out, t):
    """Force mass g at the centre of mass of b, g resting in a."""
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    s = vec(b.s)
    g = out_of_axes(columns(a, p.frame[0]), vec(weight_parameters(m.number, p.number).acceleration))
    pull = scale(m.body[p.body[1]].mass, g)
    add_force(b, pull, s)
    out.power = dot(pull, point_velocity(b, s))


@part_class()
class Weight(ForceElement):
    """Weight m g of body ``b`` at its centre of mass, g fixed in body ``a``: a laboratory that turns with the Earth.

    The attracting body is not part of the system, so nothing acts on ``a``. The work is counted; no energy is stored,
    as the field moves. Give the system ``gravity=(0, 0, 0)``, or it acts as well.

    Parameters
    ----------
    a : Body or GROUND
        The body in which g is fixed.
    b : Body
        The body that has the weight.
    acceleration : (3,) array_like
        g, world at the reference pose [m/s^2].

    Examples
    --------
    >>> from mbsd3d import Body, System, Weight, accelerations, rotation
    >>> lab, stone = (Body(name, mass=2.0, inertia=(0.1, 0.1, 0.1)) for name in ("lab", "stone"))
    >>> system = System([lab, stone], forces=[Weight(lab, stone, acceleration=(0, 0, -9.81))], gravity=(0, 0, 0))
    >>> round(float(accelerations(system).acceleration(stone)[0, 2]), 12)
    -9.81
    """

    law, law_parameters = staticmethod(weight), WEIGHT

    a: Body | Ground
    b: Body
    _: KW_ONLY
    acceleration: Vector = kept()

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        check_body(self.b, what)

    def record(self) -> ForceRecord:
        return ForceRecord((self.a, self.b), (self.b.centre, self.b.centre), parameters=self.read_by_law())


ATTRACTION = Parameters(mu="m^3/s^2")
attraction_parameters = ATTRACTION.reader()


@inner_kernel
def attraction(m, d, p, out, t):
    """Force and moment of U = -mu (m/r + (tr I - 3 n.I n)/(2 r^3)) on b, and their opposites on a.

    n = unit vector from the centre to the centre of mass; its moment about the centre vanishes, as a centre turns
    nothing about itself.
    """
    a, b, i = d.body[p.body[0]], d.body[p.body[1]], p.body[1]
    sa, s = arm(a, p.point[0]), vec(b.s)
    reach = sub(point(b, s), point(a, sa))
    r = np.sqrt(dot(reach, reach))
    n, I, R = scale(1.0 / r, reach), mat(m.body[i].inertia), mat(b.R)
    In = rotate(R, rotate(I, rotate_back(R, n)))
    along, trace, k = dot(n, In), I[0] + I[4] + I[8], attraction_parameters(m.number, p.number).mu / (r * r)
    outwards = scale(-k * (m.body[i].mass + 1.5 * (trace - 5.0 * along) / (r * r)), n)
    pull = add(outwards, scale(-3.0 * k / (r * r), In))
    add_force(b, pull, s)
    add_moment(b, scale(3.0 * k / r, cross(n, In)))
    add_force(a, scale(-1.0, pull), sa)
    out.potential = -k * r * (m.body[i].mass + 0.5 * (trace - 3.0 * along) / (r * r))


@part_class()
class CentralGravity(ForceElement):
    """Newton's attraction of body ``b`` by a centre in body ``a``, to second order in the size of ``b`` (MacCullagh).

    Energy U = -mu (m/r + (tr I - 3 n.I n)/(2 r^3)), n from the centre to the centre of mass of ``b``, I about it.
    Beside the force there is the moment 3 mu n x I n/r^3, which turns a long satellite towards the Earth (gravity
    gradient). Left out are terms of third order in the size of ``b`` over r. The opposite force acts on ``a``.

    Parameters
    ----------
    a : Body or GROUND
        The body in which the centre is fixed.
    b : Body
        The body that is attracted.
    at : (3,) array_like
        The centre, world at the reference pose [m].
    mu : float
        Newton's constant times the mass of the centre, > 0 [m^3/s^2]; of the Earth 3.986e14.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, CentralGravity, System, accelerations
    >>> stone = Body("stone", mass=5.0, inertia=(1, 1, 1), position=(2.0, 0, 0))
    >>> system = System([stone], forces=[CentralGravity(GROUND, stone, at=(0, 0, 0), mu=12.0)], gravity=(0, 0, 0))
    >>> round(float(accelerations(system).acceleration(stone)[0, 0]), 12)
    -3.0
    """

    law, law_parameters = staticmethod(attraction), ATTRACTION

    a: Body | Ground
    b: Body
    _: KW_ONLY
    at: Vector = kept()
    mu: Number = kept(positive=True)

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        check_body(self.b, what)
        if np.linalg.norm(self.b.centre - self.at) < 1e-12:
            raise InputError(f"{what}: the centre of mass of '{self.b.name}' lies in the centre; move one of them")

    def record(self) -> ForceRecord:
        return ForceRecord((self.a, self.b), (self.at, self.b.centre), parameters=self.read_by_law())
