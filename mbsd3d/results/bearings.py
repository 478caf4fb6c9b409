"""Bearing loads: reactions as radial force, axial force and tilting moment; rating life of rolling bearings by ISO 281.

    P = F_r where |F_a| <= e F_r, else X F_r + Y |F_a|;   P_m = (int P^p |n| dt / int |n| dt)^(1/p);   L10 = (C / P_m)^p

with L10 in millions of revolutions, p = 3 for balls and 10/3 for rollers; the ratings come from the catalogue. A hinge
can be read as a pair of bearings.
"""

from dataclasses import KW_ONLY, dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import check_choice, number, short_repr, vector
from ..base.errors import InputError, checks_arguments
from ..base.fields import Frozen, Number, kept, part_class
from ..base.rotations import perpendiculars, unit
from ..base.style import Sampled
from ..mechanism.joints import Joint, PointJoint
from ..mechanism.joints.pairs import Fixed, Prismatic
from .result import RunResult

BALL_LIFE_EXPONENT, ROLLER_LIFE_EXPONENT = 3.0, 10.0 / 3.0
"""[1] p of ISO 281."""

LOAD_ROUNDING = 1e-9
"""[1] Forces below this share of the greatest, moments below it times the model's length, are rounding of zero."""

AXIAL_LOAD_RATIO = (0.172, 0.345, 0.689, 1.03, 1.38, 2.07, 3.45, 5.17, 6.89)
LIMIT_RATIO = (0.19, 0.22, 0.26, 0.28, 0.30, 0.34, 0.38, 0.42, 0.44)
AXIAL_FACTOR = (2.30, 1.99, 1.71, 1.55, 1.45, 1.31, 1.15, 1.04, 1.00)
"""f0 F_a / C0, e and Y of single-row deep groove ball bearings, X = 0.56 (ISO 281, table 3; SKF catalogue, table 9)."""


@dataclass(frozen=True, eq=False, repr=False)
class BearingLoad(Sampled):
    """Bearing load at the samples; force and moment in the joint's frame: two transverse axes, then the axis.

    ``unique_force`` and ``unique_moment`` say which of these components the constraints determine; the others, of
    redundant joints, are NaN, and `axial` or `tilting` made of them raise ValueError. The radial load is determined; at
    singular poses, whose times the certificate names, it is one of least norm.
    """

    t: np.ndarray  # (samples,) [s]
    force: np.ndarray  # (samples, 3) on body b at ``point`` [N]
    moment: np.ndarray  # (samples, 3) [N m]
    point: np.ndarray  # (samples, 3) world [m]
    speed: np.ndarray  # (samples,) rate of b relative to a about the axis [rad/s]
    length: float  # of the model [m]: decides what is rounding in a moment
    name: str
    unique_force: np.ndarray = field(default_factory=lambda: np.ones(3, bool), repr=False)  # (3,)
    unique_moment: np.ndarray = field(default_factory=lambda: np.ones(3, bool), repr=False)  # (3,)

    def check(self, what: str, determined: bool) -> None:
        """Refuse a part of the load that redundant constraints leave open."""
        if not determined:
            raise InputError(
                f"bearing load of '{self.name}': redundant constraints leave its {what} open; remove them, see "
                "system.check()"
            )

    @property
    def radial(self) -> np.ndarray:
        """Return F_r >= 0 (samples,) [N]."""
        return np.hypot(self.force[:, 0], self.force[:, 1])

    @property
    def axial(self) -> np.ndarray:
        """Return F_a (samples,) along the axis, with sign [N]; ValueError where the constraints leave it open."""
        self.check("axial force", bool(self.unique_force[2]))
        return self.force[:, 2]

    @property
    def tilting(self) -> np.ndarray:
        """Return the moment across the axis >= 0 (samples,) [N m]; one bearing carries none, a `bearing_pair` does.

        ValueError where the constraints leave it open.
        """
        self.check("tilting moment", bool(self.unique_moment[:2].all()))
        return np.hypot(self.moment[:, 0], self.moment[:, 1])


@checks_arguments
def bearing_load(
    solution: RunResult, joint: Joint | str, axis: ArrayLike | None = None, *, frame: str = "a"
) -> BearingLoad:
    """Return the reaction of a joint as radial force, axial force and tilting moment.

    ``joint``: one that lets b rotate about its point: Revolute, Cylindrical, Screw, Spherical, ... ``axis``: of the
    bearing (3,), world at the reference pose; None = the joint's own. ``frame``: the body, "a" or "b", in which the
    axis and the directions across it are fixed: a for the load on a fixed ring, b for a turning one. Redundant
    constraints may leave the axial force or the tilting moment undetermined, as between hinges with parallel axes:
    reading these then raises ValueError. ValueError for joints that do not rotate or have no axis, and if the radial
    load itself is undetermined.

    >>> from mbsd3d import GROUND, Body, Revolute, System, accelerations
    >>> disc = Body("disc", mass=10.0, inertia=(0.1, 0.1, 0.2))
    >>> hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0.6, 0.8), name="hinge")
    >>> load = bearing_load(accelerations(System([disc], [hinge])), hinge)
    >>> round(float(load.radial[0]), 6), round(float(load.axial[0]), 6)
    (58.86, 78.48)
    """
    return loads_across(solution, joint, axis, frame, "bearing_load")


def loads_across(
    solution: RunResult, joint: Joint | str, axis: ArrayLike | None, frame: str, asked: str
) -> BearingLoad:  # fmt: skip
    """See `bearing_load`; ``asked``: the function that errors name."""
    if not isinstance(solution, RunResult):
        raise InputError(f"{asked}: {short_repr(solution)} is not a solution; give one of simulate(...)")
    part = solution.system.part(joint, "joints")
    what = f"{asked}: '{solution.system.name(part)}' ({type(part).__name__})"
    if not isinstance(part, PointJoint) or isinstance(part, Prismatic | Fixed):
        raise InputError(f"{what} does not turn like a bearing; give a Revolute, Cylindrical, Spherical or the like")
    check_choice(frame, ("a", "b"), f"{what}: frame")
    own = part.angle()
    if axis is not None:
        along = unit(axis, f"{what}: axis")
    elif own is not None:
        along = own.axis if frame == "a" else own.axis_b
    else:
        raise InputError(f"{what} has no axis; give axis=")
    reaction = solution.reaction(part)
    axes = [solution.body_axis(part.a if frame == "a" else part.b, x) for x in (*perpendiculars(along), along)]
    R, spin = np.stack(axes, axis=1), relative_spin(solution, part)
    known = solution._determined([part]).along(R)
    if not known[0][:2].all():
        raise InputError(
            f"{what}: redundant constraints leave its reaction open across the axis; remove them, see system.check()"
        )
    components = (np.einsum("tij,tj->ti", R, x) for x in (reaction.force, reaction.moment))
    force, moment = (np.where(is_known, x, np.nan) for is_known, x in zip(known, components, strict=True))
    speed = np.einsum("ti,ti->t", R[:, 2], spin)
    return BearingLoad(
        solution.t, force, moment, reaction.point, speed, solution.compiled.model.length, solution.system.name(part),
        *known,
    )  # fmt: skip


def relative_spin(solution: RunResult, part: Joint) -> np.ndarray:
    """Return w_b - w_a (samples, 3), world [rad/s]."""
    rates = [solution.omega(body) if body in solution.system.bodies else np.zeros(3) for body in (part.a, part.b)]
    return rates[1] - rates[0]


@checks_arguments
def bearing_pair(
    solution: RunResult, joint: Joint | str, *, fixed: ArrayLike, floating: ArrayLike
) -> tuple[BearingLoad, BearingLoad]:
    """Return the loads of the (fixed, floating) bearings of one shaft that together replace the hinge.

    The fixed one takes the axial force.

    From force F and moment M at the fixed bearing A, with the floating one at B = A + L u: ``F_B = M x u / L``, ``F_A =
    F - F_B``; no tilting moments are left. The radial loads need the radial force and the tilting moment of the hinge.

    ``joint``: the Revolute of the shaft; its body a carries the housing. ``fixed``, ``floating``: centres (3,) of the
    bearings on the axis of the hinge, world at the reference pose [m]. ValueError as for `bearing_load`, if the tilting
    moment is undetermined, and for points that are off the axis or coincide.

    >>> from mbsd3d import GROUND, Body, Revolute, System, accelerations
    >>> disc = Body("disc", mass=10.0, inertia=(0.1, 0.1, 0.2), position=(0.25, 0, 0))
    >>> hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(1, 0, 0), name="hinge")
    >>> run = accelerations(System([disc], [hinge]))
    >>> [round(float(x.radial[0]), 6) for x in bearing_pair(run, hinge, fixed=(0, 0, 0), floating=(1, 0, 0))]
    [73.575, 24.525]
    """
    load, part = bearing_load(solution, joint), solution.system.part(joint, "joints")
    what, axis = f"bearing_pair: '{load.name}'", part.angle().axis
    ends = [vector(x, f"{what}: {name}") for name, x in (("fixed", fixed), ("floating", floating))]
    span = float((ends[1] - ends[0]) @ axis)
    for name, x in zip(("fixed", "floating"), ends, strict=True):
        off = np.linalg.norm(np.cross(axis, x - part.at))
        if off > 1e-6 * load.length:
            raise InputError(f"{what}: {name} = {x.tolist()} lies {off:g} m off the axis; give points on it")
    if abs(span) < 1e-9 * load.length:
        raise InputError(f"{what}: both bearings are at one place; give two")
    load.check("tilting moment", bool(load.unique_moment[:2].all()))
    places = [solution.body_point(part.a, x) for x in ends]
    along = np.einsum("ti,ti->t", solution.body_axis(part.a, axis), load.point - places[0])
    x, y = load.moment[:, 0] - along * load.force[:, 1], load.moment[:, 1] + along * load.force[:, 0]
    second = np.stack([y, -x, np.zeros_like(x)], axis=1) / span  # M x u / L

    def bearing(name: str, at: np.ndarray, force: np.ndarray, unique: np.ndarray) -> BearingLoad:
        own, none = f"{load.name}, {name} bearing", np.zeros_like(force)
        return BearingLoad(load.t, force, none, at, load.speed, load.length, own, unique_force=unique)

    return (
        bearing("fixed", places[0], load.force - second, load.unique_force),
        bearing("floating", places[1], second, np.ones(3, bool)),
    )


@dataclass(frozen=True)
class RatingLife:
    """Basic rating life at 90 % reliability under the loads of a run, repeated indefinitely."""

    load: float  # mean equivalent dynamic load P_m [N]
    speed: float  # mean of the magnitude of the speed [rad/s]
    revolutions: float  # L10 [millions of revolutions]
    hours: float  # L10h [h]


@part_class(eq=True)
class Rating(Frozen):
    """Base class of rolling bearings.

    ``C``: basic dynamic load rating [N] > 0; ``p``: load-life exponent, 3 for balls and 10/3 for rollers; ``tilting``:
    tilting moment that it can also carry [N m].
    """

    _: KW_ONLY
    C: Number = kept(positive=True)
    p: Number = kept(default=BALL_LIFE_EXPONENT, positive=True)
    tilting: Number = kept(default=0.0, minimum=0.0)

    def factors(self, axial: np.ndarray) -> tuple[np.ndarray | float, np.ndarray | float, np.ndarray | float]:
        """Return (X, Y, e) under axial forces >= 0 [N]."""
        raise NotImplementedError

    def equivalent(self, radial: ArrayLike, axial: ArrayLike) -> np.ndarray:
        """Return the equivalent dynamic load P [N] of radial and axial forces [N]."""
        Fr, Fa = np.abs(np.asarray(radial, float)), np.abs(np.asarray(axial, float))
        X, Y, e = self.factors(Fa)
        return np.where(Fa <= e * Fr, Fr, X * Fr + Y * Fa)

    def life(self, load: BearingLoad) -> RatingLife:
        """Return L10 and L10h under the loads and speeds of a run.

        ValueError if the bearing does not turn, is never loaded, or cannot carry the axial forces (Y = 0) or tilting
        moments.
        """
        what = f"{type(self).__name__}.life: '{load.name}'"
        zero = LOAD_ROUNDING * np.abs(load.force).max(initial=0.0)
        if load.tilting.max() > self.tilting + zero * load.length:
            raise InputError(
                f"{what}: a tilting moment of {load.tilting.max():g} N m, the bearing carries {self.tilting:g}; "
                "give tilting=, or split the hinge with bearing_pair"
            )
        if np.abs(load.axial).max() > zero and not np.min(self.factors(np.abs(load.axial))[1]) > 0.0:
            raise InputError(f"{what}: an axial force of {np.abs(load.axial).max():g} N, but Y = 0; give X, Y and e")
        return self.life_of(load.t, self.equivalent(load.radial, load.axial), load.speed, what)

    def life_of(self, t: ArrayLike, load: ArrayLike, speed: ArrayLike, what: str = "life_of") -> RatingLife:
        """Return L10 of equivalent loads P [N] and speeds [rad/s] over times [s] (trapezoidal rule)."""
        t, load, speed = (np.asarray(x, float) for x in (t, load, np.abs(speed)))
        angle = np.trapezoid(speed, t)
        if not angle > 0.0:
            raise InputError(f"{what}: it does not turn in this run, so it has no rating life; size it by C0")
        mean = (np.trapezoid(load**self.p * speed, t) / angle) ** (1.0 / self.p)
        if not mean > 0.0:
            raise InputError(f"{what}: it is never loaded, so its life has no end; give a run with loads")
        revolutions, rate = (self.C / mean) ** self.p, angle / (t[-1] - t[0])
        return RatingLife(
            float(mean), float(rate), float(revolutions), float(revolutions * 1e6 * 2 * np.pi / rate / 3600.0)
        )


@part_class(eq=True)
class RollingBearing(Rating):
    """A bearing with the factors of its catalogue; the defaults suit one that carries only radial loads.

    ``X``, ``Y``: radial and axial factor; ``e``: the ratio |F_a| / F_r above which they count; ``C, p, tilting`` as
    `Rating`.

    >>> bearing = RollingBearing(C=7350.0, X=0.56, Y=1.6, e=0.3)
    >>> round(float(bearing.equivalent(2500.0, 1000.0)), 6)
    3000.0
    """

    _: KW_ONLY
    X: Number = kept(default=1.0, minimum=0.0)
    Y: Number = kept(default=0.0, minimum=0.0)
    e: Number = kept(default=0.0, minimum=0.0)

    def factors(self, axial: np.ndarray) -> tuple[float, float, float]:
        return self.X, self.Y, self.e


@part_class(eq=True)
class DeepGrooveBallBearing(Rating):
    """A single-row deep groove ball bearing of normal clearance: Y and e from f0 F_a / C0 by the table of ISO 281.

    Values between the rows are interpolated; below the first row its values hold, above the last is an error. ``C``,
    ``C0``: basic dynamic and static load rating [N] > 0; ``f0``: factor of the catalogue, 11 ... 17 by size; ``p,
    tilting`` as `Rating`.

    >>> bearing = DeepGrooveBallBearing(C=30700.0, C0=19000.0, f0=14.0)
    >>> [round(float(x), 3) for x in bearing.factors(19000.0 / 14.0 * 1.205)]  # half-way between two rows
    [0.56, 1.5, 0.29]
    """

    _: KW_ONLY
    C0: Number = kept(positive=True)
    f0: Number = kept(positive=True)

    def factors(self, axial: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        ratio = self.f0 * np.asarray(axial, float) / self.C0
        if ratio.max() > AXIAL_LOAD_RATIO[-1]:
            raise InputError(
                f"DeepGrooveBallBearing: f0 F_a / C0 = {ratio.max():g} is beyond the table, "
                f"which ends at {AXIAL_LOAD_RATIO[-1]}; take a greater bearing, or one made for axial loads"
            )
        return 0.56, np.interp(ratio, AXIAL_LOAD_RATIO, AXIAL_FACTOR), np.interp(ratio, AXIAL_LOAD_RATIO, LIMIT_RATIO)


@checks_arguments
def reliability_factor(reliability: float) -> float:
    """Return a1 of L_n = a1 L10: Weibull's ``(ln(1/R) / ln(1/0.9))^(1/1.5)``, the table of ISO 281:1990.

    0.9 <= R < 1. (The table of the 2007 edition allows somewhat more: this is on the safe side.)

    >>> round(reliability_factor(0.95), 2)
    0.62
    """
    R = number(reliability, "reliability_factor: reliability", minimum=0.9)
    if R >= 1.0:
        raise InputError(f"reliability_factor: reliability {R:g}: no bearing is certain; give 0.9 <= R < 1, e.g. 0.95")
    return float((np.log(R) / np.log(0.9)) ** (1.0 / 1.5))
