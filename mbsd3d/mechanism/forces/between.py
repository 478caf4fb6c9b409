"""Forces and torques that one body exerts on another: action and reaction."""

from dataclasses import KW_ONLY
from operator import attrgetter

import numpy as np

from ...base.checks import check_choice
from ...base.fields import VectorOrDerived, kept, part_class
from ...compiler.decorators import inner_kernel
from ...kernels.force_laws import add_force, add_moment, components
from ...kernels.vectors import add, arm, dot, mat, point, point_velocity, rotate, scale, sub, vec
from ..bodies import Body, Ground
from ..force_element import ForceElement, ForceRecord, check_pair
from ..signals import ThreeSignals

FRAMES = ("world", "a", "b")


@inner_kernel
def given_by_frame(m, d, p, t):
    """Return the components of a load in world axes; option 1, 2: they are given in the axes of a, of b."""
    x, w = components(m, p, t), vec(d.body[p.body[1]].w)
    if p.option == 0:
        return add(x, scale(0.0, w))
    return rotate(mat(d.body[p.body[p.option - 1]].R), x)


@inner_kernel
def force_between(m, d, p, out, t):
    """Force on b at one of its points, and the opposite one on a at the same place."""
    a, b, load = d.body[p.body[0]], d.body[p.body[1]], given_by_frame(m, d, p, t)
    sb = arm(b, p.point[1])
    sa = sub(point(b, sb), vec(a.r))
    add_force(b, load, sb)
    add_force(a, scale(-1.0, load), sa)
    out.power = dot(load, sub(point_velocity(b, sb), point_velocity(a, sa)))


@part_class()
class ForceBetween(ForceElement):
    """A force [N] of body a on body b at a point of b, and the opposite one on a at the same place.

    Components are numbers or signals. Both act along one line, so momentum and angular momentum of the pair are
    kept. Its work is counted, it stores no energy.

    Parameters
    ----------
    a, b : Body or GROUND
    force : three numbers or signals
        On b [N].
    at : (3,) array_like or None
        The point, carried by b, world at the reference pose [m]; None = centre of mass of b.
    frame : "world", "a" or "b"
        Axes of the components: those of the world, or the body axes of a or b.

    Examples
    --------
    >>> from mbsd3d import Body, ForceBetween, System, accelerations
    >>> ship = Body("ship", mass=6.0, inertia=(1, 1, 1))
    >>> probe = Body("probe", mass=2.0, inertia=(0.1, 0.1, 0.1), position=(0, 0, 1.0))
    >>> push = ForceBetween(ship, probe, (0, 0, 3.0), frame="a")
    >>> now = accelerations(System([ship, probe], forces=[push], gravity=(0, 0, 0)))
    >>> print(now.acceleration(probe)[0, 2], now.acceleration(ship)[0, 2])
    1.5 -0.5
    """

    law = staticmethod(force_between)

    a: Body | Ground
    b: Body | Ground
    force: ThreeSignals = kept()
    _: KW_ONLY
    at: VectorOrDerived = kept(default=None, derived=attrgetter("b.centre"))
    frame: str = "world"

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        check_choice(self.frame, FRAMES, f"{what}: frame")

    def signal_unit(self) -> str:
        return "N"

    def record(self) -> ForceRecord:
        return ForceRecord((self.a, self.b), (self.at, self.at), option=FRAMES.index(self.frame), signals=self.force)

    def acts_at(self, body: Body | Ground) -> tuple[Body | Ground, np.ndarray]:
        return self.b, self.at


@inner_kernel
def torque_between(m, d, p, out, t):
    """Apply a torque on b, and the opposite one on a."""
    a, b, load = d.body[p.body[0]], d.body[p.body[1]], given_by_frame(m, d, p, t)
    add_moment(b, load)
    add_moment(a, scale(-1.0, load))
    out.power = dot(load, sub(vec(b.w), vec(a.w)))


@part_class()
class TorqueBetween(ForceElement):
    """A torque [N m] of body a on body b, and the opposite one on a: a motor between them.

    Components are numbers or signals. Its work is counted, it stores no energy.

    Parameters
    ----------
    a, b : Body or GROUND
    torque : three numbers or signals
        On b [N m].
    frame : "world", "a" or "b"
        Axes of the components: those of the world, or the body axes of a or b.

    Examples
    --------
    >>> from mbsd3d import Body, System, TorqueBetween, accelerations
    >>> hull = Body("hull", mass=6.0, inertia=(2.0, 2.0, 3.0))
    >>> wheel = Body("wheel", mass=2.0, inertia=(0.1, 0.1, 0.2))
    >>> now = accelerations(System([hull, wheel], forces=[TorqueBetween(hull, wheel, (0, 0, 0.6))], gravity=(0, 0, 0)))
    >>> print(now.alpha(wheel)[0, 2].round(12), now.alpha(hull)[0, 2].round(12))
    3.0 -0.2
    """

    law = staticmethod(torque_between)

    a: Body | Ground
    b: Body | Ground
    torque: ThreeSignals = kept()
    _: KW_ONLY
    frame: str = "world"

    def check(self, what: str) -> None:
        check_pair(self.a, self.b, what)
        check_choice(self.frame, FRAMES, f"{what}: frame")

    def signal_unit(self) -> str:
        return "N m"

    def record(self) -> ForceRecord:
        return ForceRecord((self.a, self.b), option=FRAMES.index(self.frame), signals=self.torque)
