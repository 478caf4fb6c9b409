"""Bearing loads: reactions as radial force, axial force and tilting moment; hinges as pairs of bearings.

What they mean for the life of a rolling bearing: `mbsd3d.results.bearing_life`.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import check_choice, shown, vector
from ..base.directions import perpendiculars, unit
from ..base.errors import InputError, explaining
from ..base.style import Sampled
from ..mechanism.joints import Joint, PointJoint
from ..mechanism.joints.pairs import Fixed, Prismatic
from .result import RunResult


@dataclass(frozen=True, eq=False, repr=False)
class BearingLoad(Sampled):
    """The load of a bearing at the samples; force and moment in the joint's frame: two axes across, then the axis.

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
        """ValueError for a part of the load that redundant constraints leave open."""
        if not determined:
            raise InputError(
                f"bearing load of '{self.name}': redundant constraints leave its {what} open; cure them, see "
                "system.check()"
            )

    @property
    def radial(self) -> np.ndarray:
        """(samples,) F_r >= 0 [N]."""
        return np.hypot(self.force[:, 0], self.force[:, 1])

    @property
    def axial(self) -> np.ndarray:
        """(samples,) F_a along the axis, with sign [N]; ValueError where the constraints leave it open."""
        self.check("axial force", bool(self.unique_force[2]))
        return self.force[:, 2]

    @property
    def tilting(self) -> np.ndarray:
        """(samples,) moment across the axis >= 0 [N m]; a single bearing carries none, a pair does: `bearing_pair`.

        ValueError where the constraints leave it open.
        """
        self.check("tilting moment", bool(self.unique_moment[:2].all()))
        return np.hypot(self.moment[:, 0], self.moment[:, 1])


@explaining
def bearing_load(
    solution: RunResult, joint: Joint | str, axis: ArrayLike | None = None, *, frame: str = "a"
) -> BearingLoad:
    """The reaction of a joint as radial force, axial force and tilting moment.

    ``joint``: one at a point that lets b turn: Revolute, Cylindrical, Screw, Spherical, ... ``axis``: of the bearing
    (3,), world at the reference pose; None = the joint's own. ``frame``: the body, "a" or "b", in which the axis and
    the directions across it are fixed: a for the load on a fixed ring, b for a turning one. Redundant constraints may
    leave the axial force or the tilting moment open, as between hinges with parallel axes: these raise when they are
    read. ValueError for joints that do not turn or have no axis, and where the radial load itself is open.

    >>> from mbsd3d import GROUND, Body, Revolute, System, accelerations
    >>> disc = Body("disc", mass=10.0, inertia=(0.1, 0.1, 0.2))
    >>> hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0.6, 0.8), name="hinge")
    >>> load = bearing_load(accelerations(System([disc], [hinge])), hinge)
    >>> round(float(load.radial[0]), 6), round(float(load.axial[0]), 6)
    (58.86, 78.48)
    """
    if not isinstance(solution, RunResult):
        raise InputError(f"bearing_load: {shown(solution)} is not a solution; give one of simulate(...)")
    part = solution.system.part(joint, "joints")
    what = f"bearing_load: '{solution.system.name(part)}' ({type(part).__name__})"
    if not isinstance(part, PointJoint) or isinstance(part, Prismatic | Fixed):
        raise InputError(f"{what} does not turn like a bearing; give a Revolute, Cylindrical, Spherical or the like")
    check_choice(frame, ("a", "b"), f"{what}: frame")
    own = part.angle()
    if axis is None and own is None:
        raise InputError(f"{what} has no axis; give axis=")
    reaction = solution.reaction(part)
    along = unit(axis, f"{what}: axis") if axis is not None else own.axis if frame == "a" else own.axis_b
    axes = [solution.body_axis(part.a if frame == "a" else part.b, x) for x in (*perpendiculars(along), along)]
    R, spin = np.stack(axes, axis=1), relative_spin(solution, part)
    known = solution._determined([part]).along(R)
    if not known[0][:2].all():
        raise InputError(
            f"{what}: redundant constraints leave its reaction open across the axis; cure them, see system.check()"
        )
    components = (np.einsum("tij,tj->ti", R, x) for x in (reaction.force, reaction.moment))
    force, moment = (np.where(is_known, x, np.nan) for is_known, x in zip(known, components, strict=True))
    speed = np.einsum("ti,ti->t", R[:, 2], spin)
    return BearingLoad(
        solution.t, force, moment, reaction.point, speed, solution.compiled.model.length, solution.system.name(part),
        *known,
    )  # fmt: skip


def relative_spin(solution: RunResult, part: Joint) -> np.ndarray:
    """(samples, 3) w_b - w_a, world [rad/s]."""
    rates = [solution.omega(body) if body in solution.system.bodies else np.zeros(3) for body in (part.a, part.b)]
    return rates[1] - rates[0]


@explaining
def bearing_pair(
    solution: RunResult, joint: Joint | str, *, fixed: ArrayLike, floating: ArrayLike
) -> tuple[BearingLoad, BearingLoad]:
    """Loads of two bearings on one shaft that together are the hinge, (fixed, floating); the fixed one takes the axial
    force.

    From force F and moment M at the fixed bearing A, with the floating one at B = A + L u: ``F_B = M x u / L``, ``F_A =
    F - F_B``; no tilting moments are left. The radial loads need the radial force and the tilting moment of the hinge.

    ``joint``: the Revolute of the shaft; its body a carries the housing. ``fixed``, ``floating``: middles (3,) of the
    bearings on the axis of the hinge, world at the reference pose [m]. ValueError as `bearing_load`, where the tilting
    moment is open, and for points off the axis or at one place.

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
    none = np.zeros_like(second)
    return tuple(
        BearingLoad(
            load.t, force, none, at, load.speed, load.length, f"{load.name}, {name} bearing", unique_force=unique
        )
        for force, at, name, unique in zip(
            (load.force - second, second), places, ("fixed", "floating"), (load.unique_force, np.ones(3, bool)),
            strict=True,
        )
    )  # fmt: skip
