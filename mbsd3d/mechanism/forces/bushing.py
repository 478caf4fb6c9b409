"""Elastic mounts between two bodies."""

from dataclasses import KW_ONLY
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...base.checks import vector
from ...base.errors import InputError
from ...base.fields import Orientation, Stored, Vector, kept, part_class
from ...base.rotations import matrix
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.force_laws import add_force, add_moment
from ...kernels.vectors import add, arm, columns, dot, point, point_velocity, scale, sub, vec
from ..bodies import Body, Ground
from ..force_element import ForceElement, ForceRecord, check_pair


@inner_kernel
def into_axes(F, a):
    """F'a for axes F given as three columns."""
    return dot(F[0], a), dot(F[1], a), dot(F[2], a)


@inner_kernel
def out_of_axes(F, a):
    """F a for axes F given as three columns."""
    return add(add(scale(a[0], F[0]), scale(a[1], F[1])), scale(a[2], F[2]))


@inner_kernel
def relative_turn(A, B):
    """Products of the relative quaternion (p0, p) of A'B: 4 p0 p, 4 (p2 p3, p3 p1, p1 p2) and 4 (p1^2, p2^2, p3^2).

    They are linear in A'B and have neither the sign of the quaternion nor a singularity at half a turn.
    """
    xx, yy, zz = dot(A[0], B[0]), dot(A[1], B[1]), dot(A[2], B[2])
    yz, zx, xy = dot(A[1], B[2]), dot(A[2], B[0]), dot(A[0], B[1])
    zy, xz, yx = dot(A[2], B[1]), dot(A[0], B[2]), dot(A[1], B[0])
    away = (zy - yz, xz - zx, yx - xy)
    rest = 1.0 - xx - yy - zz
    squares = (rest + 2.0 * xx, rest + 2.0 * yy, rest + 2.0 * zz)
    if rest.real < 0.0:  # below a third of a turn these are small differences of numbers near 1
        k = 1.0 / (2.0 - rest)
        squares = (k * away[0] * away[0], k * away[1] * away[1], k * away[2] * away[2])
    return away, (yz + zy, zx + xz, xy + yx), squares


@inner_kernel
def scaled(k, x):
    """Return a diagonal stiffness or damping times a vector: k_i x_i."""
    return k[0] * x[0], k[1] * x[1], k[2] * x[2]


BUSHING = Parameters(
    stiffness=("N/m", 3), turning_stiffness=("N m/rad", 3), damping=("N s/m", 3), turning_damping=("N m s/rad", 3)
)
bushing_parameters = BUSHING.reader()


@inner_kernel
def bushing(m, d, p, out, t):
    """Linear bushing in the axes F of a: force -(K d + C d_dot), moment from U = 2 p'K_r p and -C_r w.

    d is the displacement of the point of b in F; p the vector part of the relative quaternion, so that
    p_dot = (p0 w + w x p)/2 and the elastic moment on b is -2 (p0 K_r p + p x K_r p) in F; the first component of
    p x K_r p is (K_3 - K_2) p2 p3.
    """
    own = bushing_parameters(m.number, p.number)
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    A, B = columns(a, p.frame[0]), columns(b, p.frame[1])
    sb = arm(b, p.point[1])
    reach = sub(point(b, sb), vec(a.r))  # the force on a acts where the point of b is
    x = into_axes(A, sub(reach, arm(a, p.point[0])))
    x_dot = into_axes(A, sub(point_velocity(b, sb), point_velocity(a, reach)))
    w = into_axes(A, sub(vec(b.w), vec(a.w)))
    away, mixed, squares = relative_turn(A, B)
    Kx, Cx = scaled(own.stiffness, x), scaled(own.damping, x_dot)
    Ka, Cw = scaled(own.turning_stiffness, away), scaled(own.turning_damping, w)
    k1, k2, k3 = vec(own.turning_stiffness)
    across = ((k3 - k2) * mixed[0], (k1 - k3) * mixed[1], (k2 - k1) * mixed[2])
    force = out_of_axes(A, scale(-1.0, add(Kx, Cx)))
    moment = out_of_axes(A, sub(scale(-0.5, add(Ka, across)), Cw))
    add_force(b, force, sb)
    add_force(a, scale(-1.0, force), reach)
    add_moment(b, moment)
    add_moment(a, scale(-1.0, moment))
    out.potential = 0.5 * dot(x, Kx) + 0.5 * (k1 * squares[0] + k2 * squares[1] + k3 * squares[2])
    out.power = -dot(x_dot, Cx) - dot(w, Cw)


def as_three(value: Any, what: str, part: Any) -> np.ndarray:
    """Three numbers >= 0, or one that counts for all."""
    several = isinstance(value, list | tuple) or np.ndim(value)
    three = vector(value if several else (value,) * 3, what)
    if min(three.tolist()) < 0.0:
        raise InputError(f"{what} {three.tolist()} has a negative entry; give numbers >= 0")
    return three


class OneOrThree(Stored[ArrayLike, np.ndarray]):
    """One number >= 0, or one for each axis."""

    accepts = "float | array_like"
    convert = staticmethod(as_three)


@part_class()
class Bushing(ForceElement):
    """Elastic joint between a and b: linear in the displacement of a point and in the relative rotation.

    In the axes F fixed in a, with d the displacement of the point of b, and (p0, p) the relative quaternion:
    force on b ``-(K d + C d_dot)``, moment ``-2 (p0 K_r p + p x K_r p) - C_r w``. Energy ``d'K d / 2 + 2 p'K_r p``
    (``theta' K_r theta / 2`` for small rotations). Turns are not counted: with equal stiffnesses the moment is
    ``-K_r sin(theta)``, greatest at a quarter turn and 0 again at half a turn, from where it pulls on to the whole one;
    `TorsionSpring` counts.

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

    law, law_parameters = staticmethod(bushing), BUSHING

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    at: Vector = kept()
    stiffness: OneOrThree = kept()
    turning_stiffness: OneOrThree = kept(default=0.0)
    damping: OneOrThree = kept(default=0.0)
    turning_damping: OneOrThree = kept(default=0.0)
    axes: Orientation = kept(default=(1.0, 0.0, 0.0, 0.0))

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)

    def record(self) -> ForceRecord:
        return ForceRecord((self.a, self.b), (self.at, self.at), frame=matrix(self.axes), parameters=self.read_by_law())

    def acts_at(self, body: Body | Ground) -> tuple[Body | Ground, np.ndarray]:
        return self.b, self.at  # also on a: the force acts where the point of b is
