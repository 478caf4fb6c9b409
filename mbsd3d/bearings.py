"""Rolling bearings: from reactions to loads in the joint's frame, equivalent load and rating life by ISO 281.

    P = F_r where |F_a| <= e F_r, else X F_r + Y |F_a|;   P_m = (int P^p |n| dt / int |n| dt)^(1/p);   L10 = (C / P_m)^p

with L10 in millions of revolutions, p = 3 for balls and 10/3 for rollers; C, X, Y, e come from the bearing's catalogue.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from .joints import Fixed, PointJoint, Prismatic, perpendiculars, unit
from .parts import number, vector

BALL, ROLLER = 3.0, 10.0 / 3.0
"""Load-life exponents p."""

ROUNDING = 1e-9
"""Moments below this part of force times model length are what the solver leaves of zero."""


@dataclass(frozen=True, eq=False)
class BearingLoad:
    """What a bearing carries at the samples of a run.

    Attributes
    ----------
    t : (samples,) ndarray
        [s].
    force, moment : (samples, 3) ndarray
        On body b at ``point`` [N, N m], in the joint's frame: two directions across the axis, then the axis.
    point : (samples, 3) ndarray
        World [m].
    speed : (samples,) ndarray
        Rate of b relative to a about the axis [rad/s].
    length : float
        Length of the model [m], which says what is rounding in a moment.
    """

    t: np.ndarray
    force: np.ndarray
    moment: np.ndarray
    point: np.ndarray
    speed: np.ndarray
    length: float
    name: str

    @property
    def radial(self) -> np.ndarray:
        """(samples,) F_r >= 0 [N]."""
        return np.hypot(self.force[:, 0], self.force[:, 1])

    @property
    def axial(self) -> np.ndarray:
        """(samples,) F_a along the axis, with sign [N]."""
        return self.force[:, 2]

    @property
    def tilting(self) -> np.ndarray:
        """(samples,) moment across the axis >= 0 [N m]; a single bearing carries none, a pair does: `bearing_pair`."""
        return np.hypot(self.moment[:, 0], self.moment[:, 1])


def bearing_load(solution: Any, joint: Any, axis: Any = None, *, frame: str = "a") -> BearingLoad:
    """The reaction of a joint as radial force, axial force and tilting moment.

    Parameters
    ----------
    solution : Solution
    joint : Joint or str
        A joint at a point that lets b turn: Revolute, Cylindrical, Screw, Spherical, ...
    axis : (3,) array_like or None
        Axis of the bearing, world at the reference pose; None = the joint's own.
    frame : "a" or "b"
        Body the axis and the directions across it are fixed in: a for the load on a fixed ring, b for a turning one.

    Returns
    -------
    BearingLoad

    Raises
    ------
    ValueError
        For joints that do not turn or have no axis, and where redundant constraints leave the reaction undetermined.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, System, accelerations
    >>> disc = Body("disc", mass=10.0, inertia=(0.1, 0.1, 0.2))
    >>> hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0.6, 0.8), name="hinge")
    >>> load = bearing_load(accelerations(System([disc], [hinge])), hinge)
    >>> round(float(load.radial[0]), 6), round(float(load.axial[0]), 6)
    (58.86, 78.48)
    """
    part = solution.system.part(joint, "joints")
    what = f"bearing_load: '{solution.system.name(part)}' ({type(part).__name__})"
    if not isinstance(part, PointJoint) or isinstance(part, Prismatic | Fixed):
        raise ValueError(f"{what} does not turn like a bearing; give a Revolute, Cylindrical, Spherical or the like")
    if frame not in ("a", "b"):
        raise ValueError(f"{what}: frame {frame!r} is unknown; give 'a' or 'b'")
    own = part.angle()
    if axis is None and own is None:
        raise ValueError(f"{what} has no axis of its own; give axis=")
    reaction = solution.reaction(part)
    if not reaction.unique:
        raise ValueError(f"{what}: redundant constraints leave its reaction open; cure them, see system.check()")
    along = unit(axis, f"{what}: axis") if axis is not None else own.axis if frame == "a" else own.axis_b
    axes = [solution.body_axis(part.a if frame == "a" else part.b, x) for x in (*perpendiculars(along), along)]
    R, spin = np.stack(axes, axis=1), relative_spin(solution, part)
    force, moment = (np.einsum("tij,tj->ti", R, x) for x in (reaction.force, reaction.moment))
    speed = np.einsum("ti,ti->t", R[:, 2], spin)
    return BearingLoad(
        solution.t, force, moment, reaction.point, speed, solution.compiled.model.length, solution.system.name(part)
    )


def relative_spin(solution: Any, part: Any) -> np.ndarray:
    """(samples, 3) w_b - w_a, world [rad/s]."""
    rates = [solution.omega(body) if body in solution.system.bodies else np.zeros(3) for body in (part.a, part.b)]
    return rates[1] - rates[0]


def bearing_pair(solution: Any, joint: Any, *, fixed: Any, floating: Any) -> tuple[BearingLoad, BearingLoad]:
    """Loads of two bearings on one shaft that together are the hinge: the fixed one takes the axial force.

    From force F and moment M at the fixed bearing A, with the floating one at B = A + L u:
    ``F_B = M x u / L``, ``F_A = F - F_B``.

    Parameters
    ----------
    solution : Solution
    joint : Revolute or str
        The hinge of the shaft; its body a carries the housing.
    fixed, floating : (3,) array_like
        Middles of the bearings on the axis of the hinge, world at the reference pose [m].

    Returns
    -------
    tuple of BearingLoad
        (fixed, floating), without tilting moments.

    Raises
    ------
    ValueError
        As `bearing_load`; for points off the axis or at one place.

    Examples
    --------
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
            raise ValueError(f"{what}: {name} = {x.tolist()} lies {off:g} m off the axis; give points on it")
    if abs(span) < 1e-9 * load.length:
        raise ValueError(f"{what}: both bearings are at one place; give two")
    places = [solution.body_point(part.a, x) for x in ends]
    axes = [solution.body_axis(part.a, x) for x in (*perpendiculars(axis), axis)]
    arm = np.einsum("tij,tj->ti", np.stack(axes, axis=1), load.point - places[0])
    moment, u = load.moment + np.cross(arm, load.force), np.array([0.0, 0.0, 1.0])
    second = np.cross(moment, u) / span
    none = np.zeros_like(second)
    return tuple(
        BearingLoad(load.t, force, none, at, load.speed, load.length, f"{load.name}, {name} bearing")
        for force, at, name in zip((load.force - second, second), places, ("fixed", "floating"), strict=True)
    )


@dataclass(frozen=True)
class RatingLife:
    """Basic rating life of 90 % reliability under the loads of a run, repeated for ever.

    Attributes
    ----------
    load : float
        Mean equivalent dynamic load P_m [N].
    speed : float
        Mean of the magnitude of the speed [rad/s].
    revolutions : float
        L10 [millions of revolutions].
    hours : float
        L10h [h].
    """

    load: float
    speed: float
    revolutions: float
    hours: float


@dataclass(frozen=True)
class RollingBearing:
    """Catalogue data of a bearing.

    Parameters
    ----------
    C : float
        Basic dynamic load rating [N] > 0.
    X, Y, e : float
        Radial and axial factor and the ratio |F_a| / F_r above which they count; the defaults are those of a bearing
        that carries radial loads alone.
    p : float
        Load-life exponent: `BALL` = 3, `ROLLER` = 10/3.
    tilting : float
        Tilting moment it can carry besides [N m].

    Examples
    --------
    >>> bearing = RollingBearing(C=7350.0, X=0.56, Y=1.6, e=0.3)
    >>> round(float(bearing.equivalent(2500.0, 1000.0)), 6)
    3000.0
    """

    C: float
    X: float = 1.0
    Y: float = 0.0
    e: float = 0.0
    p: float = BALL
    tilting: float = 0.0

    def __post_init__(self) -> None:
        for name in ("C", "p"):
            object.__setattr__(self, name, number(getattr(self, name), f"RollingBearing: {name}", positive=True))
        for name in ("X", "Y", "e", "tilting"):
            object.__setattr__(self, name, number(getattr(self, name), f"RollingBearing: {name}", minimum=0.0))

    def equivalent(self, radial: Any, axial: Any) -> np.ndarray:
        """Equivalent dynamic load P [N] of radial and axial forces [N]."""
        radial, axial = np.abs(radial), np.abs(axial)
        return np.where(axial <= self.e * radial, radial, self.X * radial + self.Y * axial)

    def life(self, load: BearingLoad) -> RatingLife:
        """L10 and L10h under the loads and speeds of a run.

        Raises
        ------
        ValueError
            If the bearing does not turn, is never loaded, cannot carry axial forces (Y = 0) or tilting moments that
            are there.
        """
        what = f"RollingBearing.life: '{load.name}'"
        zero = ROUNDING * np.abs(load.force).max(initial=0.0)
        if load.tilting.max() > self.tilting + zero * load.length:
            raise ValueError(
                f"{what}: a tilting moment of {load.tilting.max():g} N m, the bearing carries {self.tilting:g}; "
                "give tilting=, or split the hinge with bearing_pair"
            )
        if self.Y == 0.0 and np.abs(load.axial).max() > zero:
            raise ValueError(f"{what}: an axial force of {np.abs(load.axial).max():g} N, but Y = 0; give X, Y and e")
        return self.life_of(load.t, self.equivalent(load.radial, load.axial), load.speed, what)

    def life_of(self, t: Any, load: Any, speed: Any, what: str = "RollingBearing.life_of") -> RatingLife:
        """L10 of equivalent loads P [N] and speeds [rad/s] over times [s] (trapezoidal rule)."""
        t, load, speed = (np.asarray(x, float) for x in (t, load, np.abs(speed)))
        angle = np.trapezoid(speed, t)
        if not angle > 0.0:
            raise ValueError(f"{what}: it does not turn in this run, so it has no rating life; size it by C0")
        mean = (np.trapezoid(load**self.p * speed, t) / angle) ** (1.0 / self.p)
        if not mean > 0.0:
            raise ValueError(f"{what}: it is never loaded, so its life has no end; give a run with loads")
        revolutions, rate = (self.C / mean) ** self.p, angle / (t[-1] - t[0])
        return RatingLife(float(mean), float(rate), float(revolutions), revolutions * 1e6 * 2 * np.pi / rate / 3600.0)


def reliability_factor(reliability: float) -> float:
    """a1 of L_n = a1 L10: Weibull's ``(ln(1/R) / ln(1/0.9))^(1/1.5)``, which gives the table of ISO 281:1990.

    Parameters
    ----------
    reliability : float
        R, 0.9 <= R < 1. (The table of the 2007 edition allows somewhat more: this is on the safe side.)

    Examples
    --------
    >>> round(reliability_factor(0.95), 2)
    0.62
    """
    R = number(reliability, "reliability_factor: reliability", minimum=0.9)
    if R >= 1.0:
        raise ValueError(f"reliability_factor: reliability {R:g}: no bearing is certain; give 0.9 <= R < 1, e.g. 0.95")
    return float((np.log(R) / np.log(0.9)) ** (1.0 / 1.5))
