"""What is shown of a motion besides the bodies: arrows and traces; no plotting library."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from ...base.checks import vector
from ...base.rotations import matrix
from ...base.style import COLOURS, colour, paler
from ...mechanism.bodies import GROUND
from ...results.certificate import scales_of
from ...results.reactions import every_reaction
from .frames import Between, Frames, between
from .layers import ARROWS

TRACES = 12  # drawn at most, unless asked for
NOTHING = 1e-9  # of its scale: what rounding leaves of a vector that is zero


class Arrows(NamedTuple):
    """Vectors of one kind over the frames."""

    kind: str  # "angular velocity", "angular momentum", "reaction force", "reaction moment"
    unit: str  # "rad/s", "kg m^2/s", "N", "N m"
    names: list[str]  # of the bodies or joints
    colour: str
    points: np.ndarray  # (frames, k, 3) world [m]
    vectors: np.ndarray  # (frames, k, 3) world [unit]
    uncertain: tuple[bool, ...]  # True where a reaction is not determined by the constraints

    @property
    def longest(self) -> float:
        """Largest magnitude over the frames [unit]."""
        return float(np.linalg.norm(self.vectors, axis=-1).max(initial=0.0))

    @property
    def heads(self) -> int:
        """Two for axial vectors (rotations, moments), as on paper; one for forces."""
        return 1 if self.kind == "reaction force" else 2

    @property
    def tints(self) -> list[str]:
        """Colours of the arrows; uncertain ones are pale."""
        return [paler(self.colour) if unsure else self.colour for unsure in self.uncertain]


class Trace(NamedTuple):
    """The path of a point."""

    name: str
    colour: str
    points: np.ndarray  # (frames, 3) world [m]


def arrows_of(solution: Any, frames: Frames) -> list[Arrows]:
    """The four kinds, those that are zero throughout or cannot be had (a mode has no forces) left out.

    Angular velocities and angular momenta ``R I R' w`` stand at the centres of mass, reactions at the points at which
    `Solution.reaction` gives them; between samples vectors change along straight lines.

    Parameters
    ----------
    solution : Solution or Motion
    frames : Frames
        Of the same run, see `frames_of`.

    Returns
    -------
    list of Arrows
    """
    if "v" not in solution.arrays:
        return []
    scale = scales_of(solution)
    used, where = between(solution, frames.t).compact()
    spins, momenta, forces, moments = [], [], [], []
    for i, body in enumerate(solution.system.bodies):
        centre, w = moved(frames, i, body.com), solution.omega(body)
        L = np.einsum("tij,tj->ti", solution.rotation(body), solution.omega_body(body) @ body.inertia)
        spins.append((body.name, centre, w[used], False))
        momenta.append((body.name, centre, L[used], False))
    for joint, found in zip(solution.system.joints, every_reaction(solution, used), strict=True):
        name = solution.system.name(joint)
        point = carried(solution, frames, used, where, joint.b, found.point)
        forces.append((name, point, found.force, not found.unique))
        moments.append((name, point, found.moment, not found.unique))
    fastest = max(1.0, *(float(np.abs(w).max()) for _, _, w, _ in spins))
    kinds = (
        ("rad/s", spins, fastest, COLOURS[2]),
        ("kg m^2/s", momenta, scale.angular_momentum, COLOURS[5]),
        ("N", forces, scale.force, COLOURS[1]),
        ("N m", moments, scale.moment, COLOURS[3]),
    )
    made = [
        gather(kind, unit, tint, where, [x for x in found if np.abs(x[2]).max() > NOTHING * size])
        for kind, (unit, found, size, tint) in zip(ARROWS, kinds, strict=True)
    ]
    return [arrows for arrows in made if arrows.names]


def gather(kind: str, unit: str, colour: str, where: Between, found: list[tuple[str, Any, Any, bool]]) -> Arrows:
    """Arrows of (name, points at the frames, vectors at the samples, uncertain)."""
    names, points, vectors, uncertain = zip(*found, strict=True) if found else ((), (), (), ())
    empty = np.zeros((where.left.size, 0, 3))
    return Arrows(
        kind,
        unit,
        list(names),
        colour,
        np.stack(points, axis=1) if found else empty,
        np.stack([where.blend(x) for x in vectors], axis=1) if found else empty,
        tuple(uncertain),
    )


def moved(frames: Frames, body: int, local: np.ndarray) -> np.ndarray:
    """(frames, 3) world position of a point of a body, given in its axes from O: (3,), or (frames, 3)."""
    r = frames.r[:, body]
    return r + np.einsum("tij,tj->ti", matrix(frames.e[:, body]), np.broadcast_to(local, r.shape))


def carried(
    solution: Any, frames: Frames, used: np.ndarray, where: Between, body: Any, points: np.ndarray
) -> np.ndarray:
    """(frames, 3) a point given at the used samples, interpolated as the body sees it: it stays on its circle."""
    if body is GROUND:
        return where.blend(points)
    local = np.einsum("tji,tj->ti", solution.rotation(body)[used], points - solution.position(body)[used])
    return moved(frames, solution.compiled.body_index[id(body)], where.blend(local))


def traces_of(solution: Any, frames: Frames, points: Any = None) -> list[Trace]:
    """Paths of points of bodies.

    Parameters
    ----------
    solution : Solution or Motion
    frames : Frames
        Of the same run, see `frames_of`.
    points : sequence of (body, point) or None
        A body or its name, and a world point at the reference pose, carried by the body [m]; None = the centres of
        mass that move by more than 1 % of the mechanism's size, at most 12, those that move most.

    Returns
    -------
    list of Trace
        In the colours of their bodies.

    Raises
    ------
    ValueError
        Naming the entry, for an unknown body or a point that is none.
    """
    system = solution.system
    index = {id(body): i for i, body in enumerate(system.bodies)}
    if isinstance(points, str) or not (points is None or isinstance(points, Iterable)):
        raise ValueError(f"traces = {points!r}; give a list of (body, (x, y, z))")
    if points is not None:
        found = [trace_point(system, entry) for entry in points]
        return [Trace(body.name, colour(index[id(body)]), moved(frames, index[id(body)], x)) for body, x in found]
    paths = [moved(frames, i, body.com) for i, body in enumerate(system.bodies)]
    ways = np.array([float(np.ptp(path, axis=0).max()) for path in paths])
    size = max(solution.compiled.model.length, float(np.ptp(np.concatenate(paths), axis=0).max()))
    most = set(np.argsort(-ways, kind="stable")[:TRACES].tolist())
    shown = [i for i in range(len(paths)) if i in most and ways[i] > 0.01 * size]
    return [Trace(system.bodies[i].name, colour(i), paths[i]) for i in shown]


def trace_point(system: Any, entry: Any) -> tuple[Any, np.ndarray]:
    """Body and point in its axes, of an entry (body or name, world point at the reference pose)."""
    if not isinstance(entry, tuple | list) or len(entry) != 2:
        raise ValueError(f"trace {entry!r} is no pair; give (body, (x, y, z))")
    part, point = entry
    body = system.part(part)
    return body, body.local_point(vector(point, f"trace of body '{body.name}'"))
