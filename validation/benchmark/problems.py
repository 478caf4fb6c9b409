"""Mechanisms of the benchmark, their exact final poses, and the error of a run.

Loops come in two forms with the same motion: all hinges, as one would build it, and with weaker joints where loops are
cut, so that no row repeats another. A peer is measured in the form that suits it best.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

import mbsd3d
from mbsd3d.extend import matrix
from validation import cases
from validation.cases import mechanisms
from validation.theory.one_freedom import pendulum_motion
from validation.theory.torque_free import free_body

PLANAR_CUTS = "planar cuts"  # of planar loops; in joint coordinates the other body becomes two that are welded
POINT_CUTS = "point cuts"  # a row of each still repeats others
TRUTH_RTOL = 1e-12  # [1] rtol of the reference run where there is no closed form


class Poses(NamedTuple):
    """Poses of all bodies at the end of a run: reference points (bodies, 3) [m], rotations (bodies, 3, 3)."""

    position: np.ndarray
    rotation: np.ndarray

    def distance(self, other: "Poses", length: float) -> float:
        """Return the greatest distance of a reference point over ``length``, or angle between rotations [rad]."""
        shift = np.linalg.norm(self.position - other.position, axis=1) / length
        # |R - R'| = 2 sqrt(2) sin(angle / 2), which is exact where arccos of the trace is not
        chord = np.linalg.norm(self.rotation - other.rotation, axis=(1, 2)) / np.sqrt(8.0)
        return float(max(shift.max(), (2.0 * np.arcsin(np.minimum(chord, 1.0))).max()))


def whole(system: mbsd3d.System, t_end: float, output: int = 2, **options: Any) -> Any:
    """Simulate to the end; raise KeyboardInterrupt after Ctrl-C instead of keeping a part."""
    solution = mbsd3d.simulate(system, t_end, output=output, progress=False, **options)
    if solution.record.stopped_by:
        raise KeyboardInterrupt(solution.record.stopped_by)
    return solution


def poses(solution: mbsd3d.Solution) -> Poses:
    """Return the poses at the end of a solution."""
    bodies = solution.system.bodies
    return Poses(
        np.array([solution.position(body)[-1] for body in bodies]),
        np.array([solution.rotation(body)[-1] for body in bodies]),
    )


@dataclass(frozen=True, eq=False)
class Problem:
    """Mechanism from its reference pose to ``t_end``.

    ``name, family``: "four-bar 40", "loop"; ``system``: as one would build it; ``t_end``: [s]; ``forms``: text ->
    System with the same motion, other joints at the cuts; ``tree``: the mechanism as a tree of hinges, if it is one;
    massless bodies it adds come before the others; ``exact``: poses at ``t_end`` in closed form.
    """

    name: str
    family: str
    system: mbsd3d.System
    t_end: float
    forms: Mapping[str, mbsd3d.System] = field(default_factory=dict)
    tree: mbsd3d.System | None = None
    exact: Callable[[], Poses] | None = None

    def determinate(self) -> dict[str, mbsd3d.System]:
        """Return the forms without redundant rows, which an implicit solver needs."""
        return {
            **({} if self.repeats else {"as built": self.system}),
            **{text: form for text, form in self.forms.items() if text != POINT_CUTS},
        }

    @property
    def repeats(self) -> bool:
        """Return whether the system as built has redundant rows; then it has forms where none is redundant."""
        return bool(self.forms)

    def truth(self) -> Poses:
        """Return the true final poses: closed form, or a run at rtol `TRUTH_RTOL` that the peers' limits confirm."""
        if self.exact:
            return self.exact()
        return poses(whole(self.system, self.t_end, rtol=TRUTH_RTOL))


def cut(system: mbsd3d.System, kind: Callable[[mbsd3d.Joint], mbsd3d.Joint], names: tuple[str, ...]) -> mbsd3d.System:
    """Return the system with some hinges replaced by weaker joints; these come last, where a tree of joints ends."""
    chosen = [joint for joint in system.joints if joint.name in names]
    kept = [joint for joint in system.joints if joint.name not in names]
    return replace(system, joints=[*kept, *map(kind, chosen)])


def on_line(hinge: Any) -> mbsd3d.PointOnLine:
    """Return the planar cut of a hinge: the two rows that a planar mechanism needs."""
    return mbsd3d.PointOnLine(hinge.a, hinge.b, at=hinge.at, axis=hinge.axis, name=hinge.name)


def ball(hinge: Any) -> mbsd3d.Spherical:
    """Return the three rows of a hinge that hold its point."""
    return mbsd3d.Spherical(hinge.a, hinge.b, at=hinge.at, name=hinge.name)


def sliding(hinge: Any) -> mbsd3d.Cylindrical:
    """Return a hinge that may slide."""
    return mbsd3d.Cylindrical(hinge.a, hinge.b, at=hinge.at, axis=hinge.axis, name=hinge.name)


def planar_forms(system: mbsd3d.System, names: tuple[str, ...]) -> dict[str, mbsd3d.System]:
    """Return the forms of a mechanism whose loops are planar, one hinge of each loop named."""
    return {PLANAR_CUTS: cut(system, on_line, names), POINT_CUTS: cut(system, ball, names)}


def from_case(name: str, case: str, family: str, t_end: float | None = None, forms: Callable | None = None) -> Problem:
    """Return a reference case; ``forms`` makes the other forms from its system."""
    found = cases.load(case)
    return Problem(name, family, found.system, t_end or found.t_end, forms(found.system) if forms else {})


def coasting(name: str, case: str, supports: tuple[str, ...]) -> Problem:
    """Return a driven case from its own start without the motor, since a driven motion is known without integrating.

    The hinges named repeat rows; another form has points on lines there.
    """
    found = cases.load(case)
    system = replace(
        found.system, joints=[joint for joint in found.system.joints if type(joint) is not mbsd3d.SpeedDriver]
    )
    forms = {"point-on-line support": cut(system, on_line, supports)} if supports else {}
    return Problem(name, "loop", system, found.t_end, forms)


def top(name: str, system: mbsd3d.System, t_end: float) -> Problem:
    """Return a top on a ball; as a tree: three hinges, the first along the direction from which the axis stays away
    most.
    """
    body = system.bodies[0]
    pivot = next(joint.at for joint in system.joints if isinstance(joint, mbsd3d.Spherical))
    path = whole(system, t_end, output=200).com(body) - pivot
    path /= np.linalg.norm(path, axis=1, keepdims=True)
    directions = np.random.default_rng(1).normal(size=(500, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    first = directions[np.argmin(np.abs(directions @ path.T).max(axis=1))]
    ring = mbsd3d.Body("ring", 0.0, (0.0, 0.0, 0.0), position=pivot)
    outer = mbsd3d.Revolute(mbsd3d.GROUND, ring, at=pivot, axis=first, name="outer")
    inner = mbsd3d.Universal(
        ring, body, at=pivot, axis_a=np.cross(path[0], first), axis_b=path[0], name="inner and spin"
    )
    return Problem(name, "top", system, t_end, tree=replace(system, bodies=[ring, body], joints=[outer, inner]))


def tree(name: str, family: str, system: mbsd3d.System, t_end: float) -> Problem:
    """Return a problem of a tree of hinges."""
    return Problem(name, family, system, t_end, tree=system)


def four_bar(n: int) -> Problem:
    """Return the N-four-bar: all rods turn alike, as one physical pendulum, through ten poses with n + 1 degrees of
    freedom.
    """
    system = mechanisms.four_bars(n)
    names = tuple(f"B{k}r" for k in range(n))
    exact = partial(four_bar_poses, n, 10.0)
    return Problem(f"four-bar {n}", "loop", system, 10.0, planar_forms(system, names), exact=exact)


def four_bar_poses(n: int, t: float) -> Poses:
    """Return the poses of rods that turn by phi from hanging: (n + 1) inertias m l^2 / 3 and n couplers m l^2 in
    translation.
    """
    frequency = np.sqrt(9.81 * ((n + 1) / 2 + n) / ((n + 1) / 3 + n))
    phi = float(pendulum_motion(t, frequency, np.pi, -1.0)[0])
    along = np.array([np.sin(phi), -np.cos(phi), 0.0])
    rods = [(k, 0, 0) + along / 2 for k in range(n + 1)]
    couplers = [(k + 0.5, 0, 0) + along for k in range(n)]
    turn = np.array([[along[0], -along[1], 0], [along[1], along[0], 0], [0, 0, 1.0]])  # x of the rod along it
    return Poses(np.array([*rods, *couplers]), np.array([turn] * (n + 1) + [np.eye(3)] * n))


def dzhanibekov(t_end: float = 11.0) -> Problem:
    """Return a free body about its middle axis; 11 s hold two flips and amplify an error some hundred times."""
    system = cases.load("free_dzhanibekov").system
    body = system.bodies[0]

    def exact() -> Poses:
        moments, R = np.diag(body.inertia), matrix(body.orientation)
        position = body.position + np.array(body.velocity) * t_end + system.gravity * t_end**2 / 2
        turned = free_body([t_end], moments, R.T @ body.omega, body.orientation).rotation[0]
        return Poses(position[None], np.asarray(turned, dtype=float)[None])

    return Problem("free body", "free body", system, t_end, exact=exact)


def ladder(n: int) -> Problem:
    """Return parallelograms in a tilted plane, 0.5 s of their fall."""
    system = mechanisms.ladder(n)
    return Problem(f"ladder {n}", "loop", system, 0.5, planar_forms(system, tuple(f"right {k}" for k in range(n))))


def chain(n: int) -> Problem:
    """Return a chain of n hinges, 0.5 s of its fall from the horizontal."""
    return tree(f"chain {n}", "chain", mechanisms.chain(n), 0.5)


CHAINS = (10, 30, 100, 150, 300, 1000)
PROBLEMS: dict[str, Callable[[], Problem]] = {
    "top fast": lambda: top("top fast", cases.load("heavy_top_fast").system, 2.0),
    "top slow": lambda: top("top slow", mechanisms.slow_top(), 2.0),
    "free body": dzhanibekov,
    "Cardan": lambda: coasting("Cardan", "cardan_single_45", ("R2",)),
    "Bricard": partial(
        from_case, "Bricard", "iftomm_A04_bricard", "loop",
        forms=lambda system: {"one sliding hinge": cut(system, sliding, ("J5",))},
    ),
    "Andrews": partial(
        from_case, "Andrews", "iftomm_A03_andrews", "loop",
        forms=lambda system: planar_forms(system, ("E1", "A1", "A2")),
    ),
    "RSSR": lambda: coasting("RSSR", "rssr_driven", ()),
    "Stewart platform": lambda: Problem("Stewart platform", "loop", mechanisms.stewart(), 2.0),
    "four-bar 2": partial(four_bar, 2),
    "four-bar 40": partial(four_bar, 40),
    "ladder 10": partial(ladder, 10),
    "ladder 30": partial(ladder, 30),
    "bicycle M1": partial(from_case, "bicycle M1", "bicycle_M1", "bicycle"),
    "bicycle M3": partial(from_case, "bicycle M3", "bicycle_M3", "bicycle"),
    "arm 6R": lambda: tree("arm 6R", "arm", cases.load("robot6r_inverse_dynamics").system, 1.0),
    "ball chain 10": partial(from_case, "ball chain 10", "chain10_spherical", "chain", 0.5),
    **{f"chain {n}": partial(chain, n) for n in CHAINS},
}  # fmt: skip
"""Name -> builder."""
