"""Springs of ball joints: a moment against the rotation of one body relative to another."""

from dataclasses import KW_ONLY

import numpy as np

from ...base.fields import Number, kept, part_class
from ...base.rotations import conjugate, multiply
from ...compiler.decorators import inner_kernel
from ...compiler.records import Parameters
from ...kernels.coordinates import arctan2
from ...kernels.force_laws import add_moment
from ...kernels.kinematics import product
from ...kernels.vectors import add, dot, mat, rotate, scale, sub, vec
from ..bodies import Body, Ground
from ..force_element import ForceElement, ForceRecord, check_pair

ROTATION_SPRING = Parameters(stiffness="N m/rad", damping="N m s/rad", built=("1", 4))
rotation_spring_parameters = ROTATION_SPRING.reader()
SERIES_TANGENT_SQUARE_MAX = 1e-4  # [1] tan^2 of half an angle: below it four terms of its series are exact to rounding


@inner_kernel
def rotation_vector(p0, p):
    """Return the shortest rotation vector [rad] of a quaternion (p0, p) of any length, p0 >= 0 or not."""
    if p0.real < 0.0:
        p0, p = -p0, scale(-1.0, p)
    s = dot(p, p)
    if s.real < SERIES_TANGENT_SQUARE_MAX * (p0 * p0).real:
        u = s / (p0 * p0)
        factor = 2.0 / p0 * (1.0 - u * (1.0 / 3.0 - u * (0.2 - u / 7.0)))
    else:
        size = np.sqrt(s)
        factor = 2.0 * arctan2(size, p0) / size
    return scale(factor, p)


@inner_kernel
def turn_since(a, b, built):
    """Return the shortest rotation vector [rad], world axes, of b relative to a since its quaternion was ``built``."""
    back = a.e[0], -a.e[1], -a.e[2], -a.e[3]
    now = product(back, (b.e[0], b.e[1], b.e[2], b.e[3]))
    p0, p1, p2, p3 = product(now, (built[0], -built[1], -built[2], -built[3]))
    return rotate(mat(a.R), rotation_vector(p0, (p1, p2, p3)))


def built_turn(a: Body | Ground, b: Body | Ground) -> np.ndarray:
    """Return the quaternion of b relative to a at the reference pose."""
    return multiply(conjugate(a.orientation), b.orientation)


@inner_kernel
def rotation_spring(m, d, p, out, t):
    """Moment -(k theta + c w) on b; theta rotates b from where it was built to where it is, w is its rate, in a.

    theta_dot differs from w, but theta . theta_dot = theta . w.
    """
    own = rotation_spring_parameters(m.number, p.number)
    a, b = d.body[p.body[0]], d.body[p.body[1]]
    theta = turn_since(a, b, own.built)
    w = sub(vec(b.w), vec(a.w))
    moment = scale(-1.0, add(scale(own.stiffness, theta), scale(own.damping, w)))
    add_moment(b, moment)
    add_moment(a, scale(-1.0, moment))
    out.potential = 0.5 * own.stiffness * dot(theta, theta)
    out.power = -own.damping * dot(w, w)


@part_class()
class RotationSpring(ForceElement):
    """Spring and damper against the rotation of b relative to a, as in a ball joint: moment -(k theta + c w) on b.

    theta is the rotation vector [rad] from the orientation at the reference pose, shorter than half a turn, and w the
    relative angular velocity; the opposite moment acts on a. Energy ``k |theta|^2 / 2``; dissipated power ``c |w|^2``.
    At half a turn the moment changes its sign. (A `Bushing` is softer at large angles: 2 k sin(theta / 2)
    cos(theta / 2).)

    Parameters
    ----------
    stiffness, damping : float
        k >= 0 [N m/rad], c >= 0 [N m s/rad].

    Examples
    --------
    >>> from math import pi
    >>> from mbsd3d import GROUND, Body, RotationSpring, Spherical, System, simulate
    >>> head = Body("head", mass=2.0, inertia=(0.2, 0.2, 0.2), omega=(0, 6.0, 8.0))
    >>> ball = Spherical(GROUND, head, at=(0, 0, 0))
    >>> spring = RotationSpring(GROUND, head, stiffness=3.2)
    >>> run = simulate(System([head], [ball], [spring]), pi / 8)  # a quarter of a period, sqrt(3.2 / 0.2) = 4 rad/s
    >>> abs(run.force(spring).moment[-1]).round(6)  # 10 / 4 rad of turn
    array([0. , 4.8, 6.4])
    """

    law, law_parameters = staticmethod(rotation_spring), ROTATION_SPRING

    a: Body | Ground
    b: Body | Ground
    _: KW_ONLY
    stiffness: Number = kept(minimum=0.0)
    damping: Number = kept(default=0.0, minimum=0.0)

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)

    def record(self) -> ForceRecord:
        return ForceRecord((self.a, self.b), parameters=self.read_by_law(built=built_turn(self.a, self.b)))
