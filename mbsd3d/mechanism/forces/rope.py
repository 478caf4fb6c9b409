"""Ropes over pulleys: they pull only, slide on smooth pulleys, and turn the rough ones or slip on them.

A span runs between two nodes: points, eyes and circles. With rho = s_i R_i - s_j R_j, psi = arg D + asin(rho / d) its
direction in the axes of the body of one circle (see `mechanism.pulleys`) and theta the turn of the second circle by the
first, the length of rope between a mark on circle i and a mark on circle j is

    M = sqrt(d^2 - rho^2 + h^2) + rho psi + s_j R_j theta.

Over a smooth pulley both spans share one tension, and the mark drops out of their sum, which is tangents + R phi. A
rough one parts the rope into sections: each is stretched by the sum of its M over its rest and by what has slipped.
"""

from collections.abc import Sequence
from dataclasses import KW_ONLY
from functools import cached_property
from math import inf
from typing import Any, NamedTuple

import numpy as np

from ...base.checks import as_tuple, number
from ...base.errors import InputError
from ...base.fields import NumberOrNone, Stored, kept, part_class
from ...base.wording import counted
from ...compiler.decorators import inner_kernel
from ...kernels.coordinates import coordinate
from ...kernels.force_laws import add_force, add_moment, stop_load
from ...kernels.ropes import (
    ARMS,
    DAMPINGS,
    GRIPS,
    RATES,
    STIFFNESSES,
    STRETCHES,
    TENSIONS,
    TURNS,
    WRAPS,
    find_slips,
    find_stretches,
    found,
    given,
    span,
    turned,
)
from ...kernels.vectors import add6, arm, cross, point, scale, sub
from ..bodies import Body, Ground
from ..force_element import ForceRecord
from ..joints import Joint
from ..measures import of_coordinate
from ..pulleys import Ends, Given, Passed, Path, Pulley, path_of
from .end_stop import Stop, see_gap

SLIP_SCALE = 1e-3  # [1] of the length of the model: size against which errors of a slip are measured


@inner_kernel
def pull(m, d, p, out, t):
    """Apply the tensions of all sections along the gradients of their spans."""
    arms, grips, tensions, section = given(m, p, ARMS), given(m, p, GRIPS), found(d, p, TENSIONS), 0
    for k in range(p.option):
        section += 1 if k > 0 and grips[k].real != 0.0 else 0
        tension = tensions[section]
        x = m.coordinate[m.measure[p.measure + k].coordinate]
        a, b = d.body[x.body[0]], d.body[x.body[1]]
        sa, sb = arm(a, x.point[0]), arm(b, x.point[1])
        gap = sub(point(b, sb), point(a, sa))
        _, speed, g, _ = span(m, d, p, k, t)
        force = scale(tension, g)
        add_force(a, force, sa)
        add_moment(a, cross(gap, force))
        add_force(b, scale(-1.0, force), sb)
        out.power -= tension * speed
        place = int(given(m, p, TURNS)[k].real)
        if place >= 0:
            i = m.measure[p.measure + place].coordinate
            a, b, load = d.body[m.coordinate[i].body[0]], d.body[m.coordinate[i].body[1]], -tension * arms[k + 1]
            _, _, la, ta, lb, tb = coordinate(m, d, i, t)
            add6(a.Q, scale(load, la), scale(load, ta))
            add6(b.Q, scale(load, lb), scale(load, tb))
            out.power += load * turned(m, d, p, k, t)[1]


@inner_kernel
def rope(m, d, p, out, t):
    """Tension max(0, k x + c x_dot) of each section that is stretched by x; slips at e^(mu phi)."""
    k, c = given(m, p, STIFFNESSES), given(m, p, DAMPINGS)
    x, rate, tensions = found(d, p, STRETCHES), found(d, p, RATES), found(d, p, TENSIONS)
    least = find_stretches(m, d, p, t)
    find_slips(m, d, p)
    out.potential, out.power = 0.0 * x[0], 0.0 * x[0]
    for i in range(p.option):
        tensions[i], elastic = stop_load(k[i], c[i], x[i], rate[i])
        out.potential += 0.5 * elastic * elastic / k[i] if k[i].real > 0.0 else 0.0 * x[i]
        out.power += elastic * rate[i]
    pull(m, d, p, out, t)
    if least < 0.0:
        out.power = np.nan * out.power  # it has come off a pulley: the run names the rope


@inner_kernel
def rope_gap(m, d, p, limit, t, seen):
    """See how far a section is from being taut [m]."""
    find_stretches(m, d, p, t)
    x, rate = found(d, p, STRETCHES)[limit], found(d, p, RATES)[limit]
    see_gap(given(m, p, STIFFNESSES)[limit], given(m, p, DAMPINGS)[limit], -x.real, -rate.real, seen)


def as_each(value: Any, what: str, part: Any, *, positive: bool = False) -> tuple[float, ...]:
    """Convert a number, or several, to a tuple of numbers >= 0, or > 0."""
    several = (value,) if isinstance(value, int | float | np.number) else as_tuple(value, what, "a number, or several")
    return tuple(number(x, what, minimum=0.0, positive=positive) for x in several)


class OneOrEach(Stored[float | Sequence[float], tuple[float, ...]]):
    """A number for all, or one for each."""

    accepts, file_type = "float | Sequence[float]", float | list[float]
    convert = staticmethod(as_each)


def as_grips(value: Any, what: str, part: Any) -> tuple[float | None, ...]:
    """Convert a coefficient of friction, None for a grip that never slips, or several of them."""
    alone = value is None or isinstance(value, int | float | np.number)
    several = (value,) if alone else as_tuple(value, what, "numbers")
    return tuple(None if x is None else number(x, what, minimum=0.0) for x in several)


class Grips(Stored[float | Sequence[float | None] | None, tuple[float | None, ...]]):
    """A coefficient of friction, or None where nothing slips; one for all, or one for each."""

    accepts, file_type = "float | None | Sequence[float | None]", float | None | list[float | None]
    convert = staticmethod(as_grips)


def for_each(values: tuple[Any, ...], count: int, what: str, of: str) -> list[Any]:
    """Return one value for each, where one may be given for all."""
    if len(values) not in (1, count):
        raise InputError(f"{what}: {counted(len(values), 'value')} for {count} {of}; give one, or one each")
    return list(values) * (count if len(values) == 1 else 1)


class Sections(NamedTuple):
    """The sections of a rope, between its ends and the pulleys that grip it."""

    grips: list[float]  # by node: mu, 0 where the rope slides without friction, inf where it never slips
    stiffnesses: list[float]  # by section
    dampings: list[float]
    stretches: list[float]  # at the reference pose [m]


def rope_record(path: Path, sections: Sections) -> ForceRecord:
    """Return what the law of a rope reads."""
    n, rests = len(path.spans), path.rests()
    with_turn = [k for k, span_ in enumerate(path.spans) if len(span_.ways) > 1]
    turns = [n + with_turn.index(k) if k in with_turn else -1 for k in range(n)]  # places among the ways
    ways = [span_.ways[0] for span_ in path.spans] + [path.spans[k].ways[1] for k in with_turn]
    first = [0, *(k for k in range(1, n) if sections.grips[k] != 0.0)]  # span of each section
    for k, stretch in zip(first, sections.stretches, strict=True):
        rests[k] -= stretch
    spare = [0.0] * (n + 1)
    series_ = (
        [node.arm for node in path.nodes], sections.grips, path.offsets(), rests, sections.stiffnesses,
        sections.dampings, turns,
    )  # fmt: skip
    slipping = sum(0.0 < grip < inf for grip in sections.grips)
    return ForceRecord(
        tuple({id(node.body): node.body for node in path.nodes}.values()),
        option=n,
        measures=tuple(of_coordinate(x, "way of a rope") for x in ways),
        series=tuple(tuple([*map(float, x), *spare][: n + 1]) for x in series_),
        states=(0.0,) * slipping,
        scales=((SLIP_SCALE, 1.0, 0.0),) * slipping,
    )


class OverPulleys(Stop):
    """Base class of ropes and belts: what passes nodes with a tension of each section."""

    law, gap = staticmethod(rope), staticmethod(rope_gap)

    def passed(self) -> tuple[Given, ...]:
        """Return what it passes, from end to end."""
        raise NotImplementedError

    def sections(self) -> Sections:
        """Return the sections with their numbers."""
        raise NotImplementedError

    @cached_property
    def path(self) -> Path:
        """Return the path at the reference pose."""
        return path_of(self.passed(), self.what())

    @property
    def gaps(self) -> int:
        return len(self.sections().stretches)

    @property
    def strands(self) -> int:
        return self.gaps

    def depth_as_built(self) -> float:
        return 0.0  # it may start taut

    def record(self) -> ForceRecord:
        return rope_record(self.path, self.sections())

    def acts_at(self, body: Body | Ground) -> tuple[Body | Ground, np.ndarray]:
        return next((node.body, node.point) for node in self.path.nodes if node.body is body)

    def read(self, scratch: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (tensions by section [N], wraps by pulley [rad]) of what the law has found."""
        nodes = self.path.nodes
        tensions, wraps = (scratch.reshape(-1)[i * len(nodes) : (i + 1) * len(nodes)] for i in (TENSIONS, WRAPS))
        return tensions[: self.gaps], wraps[1:-1][[node.is_circle for node in nodes[1:-1]]]


@part_class()
class Rope(OverPulleys):
    """A rope from end to end over pulleys and through eyes; it pulls only.

    Each section that is stretched by x has the tension ``T = max(0, k x + c x_dot)``, slack ones none. The whole rope
    is one section while it slides over all its pulleys without friction (``mu=0``): its length is the sum of the
    tangents and of ``R phi``, and the load is T along both tangents at the centre of each pulley. A pulley with
    ``mu > 0`` parts it into two sections. It holds the rope on its rim, and so turns with it, as long as the higher
    tension is at most ``e^(mu phi)`` times the lower one; beyond, the rope slips at that ratio, by an internal state.
    ``mu=None`` never slips. Energy ``k x^2 / 2``; the rest of the power is dissipated.

    Wraps phi count turns. Where one falls below 0, the rope has come off its pulley and the run ends with an error.
    Axes of pulleys that follow each other are parallel, and each pulley lies in one plane with what comes before and
    after it; eyes may lead from plane to plane. In a run, a span that leaves the plane of its pulley by an angle beta
    has the length of the true tangent to a circle of radius R in that plane, and loads that err by its square; the
    certificate refuses 0.1. The rope has no mass, and no stretch where it lies on a rough pulley.

    Parameters
    ----------
    points : two of (body, point) or `Winch`
        Ends: points of bodies, world at the reference pose [m], or drums.
    pulleys : sequence of `Pulley` or (body, point)
        What it passes, from the first end to the last; (body, point) is an eye through which it slides.
    stiffness, damping : float or sequence
        k > 0 [N/m] and c >= 0 [N s/m] of every section, or one each; ``EA / length`` of it.
    mu : float, None or sequence
        Friction on the pulleys, one for all or one each. Above 0 it needs c > 0: a slip settles within c/k.
    length : float or None
        Free length between the ends at the reference pose, drums apart [m]; None = as long as the path, just taut. More
        is slack.
    pretension : float
        Tension at the reference pose [N].

    Raises
    ------
    ValueError
        For a pulley inside another or an end inside a pulley, one that the rope passes without lying on it, pulleys
        whose planes do not contain their neighbours, a length shorter than the path, or mu > 0 without damping.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Pulley, Rope, System, accelerations
    >>> one, two = (Body(n, mass=2.0, inertia=(1, 1, 1), position=(x, 0, 0)) for n, x in (("one", -0.1), ("two", 0.1)))
    >>> wheel = Pulley(GROUND, radius=0.1, sense=1, centre=(0, 0, 3), axis=(0, 1, 0))
    >>> rope = Rope(((one, (-0.1, 0, 0)), (two, (0.1, 0, 0))), wheel, stiffness=1e4, pretension=50.0)
    >>> round(rope.path.length, 6)  # 6 m and half a turn
    6.314159
    >>> round(float(accelerations(System([one, two], forces=[rope])).acceleration(one)[0, 2]), 9)  # 50 / 2 - 9.81
    15.19
    """

    points: Ends = kept()
    pulleys: Passed = kept(default=())
    _: KW_ONLY
    stiffness: OneOrEach = kept(positive=True)
    damping: OneOrEach = kept(default=0.0)
    mu: Grips = kept(default=0.0)
    length: NumberOrNone = kept(default=None, minimum=0.0)
    pretension: NumberOrNone = kept(default=None, minimum=0.0)

    def check(self, what: str) -> None:
        path, sections = self.path, self.sections()
        if any(0.0 < grip < inf for grip in sections.grips) and min(sections.dampings) == 0.0:
            raise InputError(f"{what}: mu > 0 with damping = 0; give damping > 0, which sets how fast a slip settles")
        if self.length is not None and self.pretension is not None:
            raise InputError(f"{what}: both length and pretension; give one of them")
        if self.length is not None and self.length < path.length:
            raise InputError(
                f"{what}: length = {self.length:g} m is shorter than its path of {path.length:.6g} m at the reference "
                "pose; give at least that, or pretension= for a rope that starts taut"
            )

    def passed(self) -> tuple[Given, ...]:
        return self.points[0], *self.pulleys, self.points[1]

    def sections(self) -> Sections:
        what, wheels = self.what(), [x for x in self.pulleys if isinstance(x, Pulley)]
        coefficients = iter(for_each(self.mu, len(wheels), what, "pulleys in mu") if wheels else [])
        inner = [next(coefficients) if isinstance(x, Pulley) else 0.0 for x in self.pulleys]
        grips = [0.0, *(inf if mu is None else mu for mu in inner), 0.0]
        count = 1 + sum(grip != 0.0 for grip in grips)
        k = for_each(self.stiffness, count, what, "sections in stiffness")
        c = for_each(self.damping, count, what, "sections in damping")
        stretches = [(self.pretension or 0.0) / each for each in k]
        if self.length is not None:
            slack, give = self.length - self.path.length, sum(1.0 / each for each in k)
            stretches = [-slack / (each * give) for each in k]
        return Sections(grips, k, c, stretches)

    def partners(self) -> tuple:
        wheels = [x.on for x in (*self.points, *self.pulleys) if isinstance(x, Pulley)]
        return tuple({id(on): on for on in wheels if isinstance(on, Joint)}.values())

    def state_names(self) -> tuple[str, ...]:
        slipping = [k for k, grip in enumerate(self.sections().grips) if 0.0 < grip < inf]
        return tuple(f"slip {k}" for k in slipping)
