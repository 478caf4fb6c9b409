"""Arrows, traces and curves over time of a motion, and the reactions that arrows show; no plotting library."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import Akima1DInterpolator

from ...base.checks import as_tuple, short_repr, vector
from ...base.errors import InputError
from ...base.rotations import matrix
from ...base.style import COLOURS, colour, muted_colour
from ...equations.at_state import load_rows
from ...equations.compiled import Compiled
from ...mechanism.bodies import GROUND, Body, Ground
from ...mechanism.joints import Joint
from ...mechanism.mechanism import Mechanism
from ...plotting.default_curves import default_curves, seen_panels
from ...plotting.panels import Panel, Wanted, engaged_parts
from ...results.checks.check import scales_of
from ...results.motion import Motion
from ...results.reactions import Reaction
from ...results.result import RunResult
from .drawing import ARROWS, Drawing
from .frames import Between, Frames, between

TRACES_MAX = 12  # [traces] drawn unless more are asked for
VECTOR_ROUNDING = 1e-9  # [1] of the scale of a vector: rounding of one that is zero
Point = Body | str | tuple[Body | str, ArrayLike] | tuple[Body | str, ArrayLike, Body | Ground | str]
Points = Iterable[Point]


class Arrows(NamedTuple):
    """Vectors of one kind over the frames."""

    kind: str  # one of `drawing.ARROWS`
    unit: str  # "rad/s", "kg m^2/s", "N", "N m"; "" where a length says nothing
    names: list[str]  # of the bodies or joints
    colour: str
    points: np.ndarray  # (frames, k, 3) world [m]
    vectors: np.ndarray  # (frames, k, 3) world [unit]
    uncertain: tuple[bool, ...]  # True where the constraints determine nothing of a reaction; else it is what they do

    @property
    def longest(self) -> float:
        """Return the largest magnitude over the frames [unit]."""
        return float(np.linalg.norm(self.vectors, axis=-1).max(initial=0.0))

    @property
    def heads(self) -> int:
        """Return the heads of an arrow: two for axial vectors (rotations, moments), one for forces."""
        return 1 if self.kind == "reaction force" else 2

    @property
    def tints(self) -> list[str]:
        """Return the colours of the arrows; uncertain ones are pale."""
        return [muted_colour(self.colour) if unsure else self.colour for unsure in self.uncertain]


class Vectors(NamedTuple):
    """Vector that becomes an arrow."""

    name: str
    points: np.ndarray  # (frames, 3) world [m]
    values: np.ndarray  # (samples, 3)
    uncertain: bool = False


class Trace(NamedTuple):
    """Path of a point, as it is seen from a body or from the ground."""

    name: str
    colour: str
    points: np.ndarray  # (frames, 3) axes of that body [m]
    frame: int  # its number; the ground is the last one

    def at(self, r: np.ndarray, e: np.ndarray) -> np.ndarray:
        """Return the points in the world (frames, 3) at a pose of all bodies, r (n + 1, 3) and e (n + 1, 4)."""
        return self.points @ matrix(e[self.frame]).T + r[self.frame]


class Curve(NamedTuple):
    """Lines (frames,) over time of one plot."""

    label: str  # "angle of hinge"
    unit: str  # "rad"
    lines: list[tuple[str, np.ndarray]]
    size: float = 0.0  # what such a quantity amounts to in the run; 1e-9 of it is rounding


def arrows_of(motion: Motion, frames: Frames) -> list[Arrows]:
    """Return the kinds of arrows, without those that are zero throughout; a mode has none.

    Angular velocities and angular momenta ``R I R' w`` are drawn at the centres of mass, reactions at the points at
    which `Solution.reaction` gives them, and while a part is engaged that switches at events, its axis (or z); between
    samples vectors change along straight lines.
    """
    if not isinstance(motion, RunResult):
        return []
    scale = scales_of(motion)
    used, where = between(motion, frames.t).compact()
    spins: list[Vectors] = []
    momenta: list[Vectors] = []
    forces: list[Vectors] = []
    moments: list[Vectors] = []
    for i, body in enumerate(motion.system.bodies):
        centre, w = moved(frames, i, body.com), motion.omega(body)
        L = np.einsum("tij,tj->ti", motion.rotation(body), motion.omega_body(body) @ body.inertia)
        spins.append(Vectors(body.name, centre, w[used]))
        momenta.append(Vectors(body.name, centre, L[used]))
    for joint, reaction in zip(motion.system.joints, every_reaction(motion, used), strict=True):
        name = motion.system.name(joint)
        point = carried(motion, frames, used, where, joint.b, reaction.point)
        for shares, kind in ((forces, "force"), (moments, "moment")):
            values, known = reaction.shown(kind)
            shares.append(Vectors(name, point, values, known == "none"))
    engaged = []
    for name, (part, holds) in engaged_parts(motion).items():
        if not isinstance(part, Joint) and not part.partners():
            continue  # a pin in its play has no axis
        joint = part.held() if isinstance(part, Joint) else part.partners()[0]
        x = joint.angle() or joint.slide()
        axis = motion.body_axis(joint.b, np.array([0.0, 0.0, 1.0]) if x is None else x.axis_b)
        point = carried(motion, frames, used, where, joint.b, joint.reaction_points(motion)[used])
        engaged.append(Vectors(name, point, (holds[:, None] * axis)[used]))
    fastest = max(1.0, *(float(np.abs(spin.values).max()) for spin in spins))
    kinds = (
        ("rad/s", spins, fastest, COLOURS[2]),
        ("kg m^2/s", momenta, scale.angular_momentum, COLOURS[5]),
        ("N", forces, scale.force, COLOURS[1]),
        ("N m", moments, scale.moment, COLOURS[3]),
        ("", engaged, 1.0, COLOURS[4]),
    )
    made = []
    for kind, (unit, found, size, tint) in zip(ARROWS, kinds, strict=True):
        if seen := [x for x in found if np.abs(x.values).max() > VECTOR_ROUNDING * size]:
            points = np.stack([x.points for x in seen], axis=1)
            vectors = np.stack([where.blend(x.values) for x in seen], axis=1)
            unsure = tuple(x.uncertain for x in seen)
            made.append(Arrows(kind, unit, [x.name for x in seen], tint, points, vectors, unsure))
    return made


def moved(frames: Frames, body: int, local: np.ndarray) -> np.ndarray:
    """Return the world position (frames, 3) of a point of a body, given in its axes from O: (3,), or (frames, 3)."""
    r = frames.r[:, body]
    return r + np.einsum("tij,tj->ti", matrix(frames.e[:, body]), np.broadcast_to(local, r.shape))


def carried(
    run: RunResult, frames: Frames, used: np.ndarray, where: Between, body: Body | Ground, points: np.ndarray
) -> np.ndarray:
    """Return a point (frames, 3) given at the used samples, interpolated in body axes to stay on its circle."""
    if isinstance(body, Ground):
        return where.blend(points)
    local = np.einsum("tji,tj->ti", run.rotation(body)[used], points - run.position(body)[used])
    return moved(frames, run.compiled.body_index[id(body)], where.blend(local))


def nearby(
    drawing: Drawing, frames: Frames, arrows: Sequence[Arrows] = (), traces: Sequence[Trace] = ()
) -> tuple[Drawing, Frames, list[Arrows], list[Trace]]:
    """Return frames, arrows and traces about the origin of the drawing; what is fixed to the ground moves."""
    o, ground = drawing.origin, frames.r.shape[1] - 1

    def there(body: int, points: np.ndarray) -> np.ndarray:
        return points - o if body == ground else points

    def end(place: tuple[int, np.ndarray]) -> tuple[int, np.ndarray]:
        return place[0], there(*place)

    near = Drawing(
        [x._replace(mesh=x.mesh._replace(vertices=there(x.body, x.mesh.vertices))) for x in drawing.pieces],
        [x._replace(points=there(x.body, x.points)) for x in drawing.wires],
        [x._replace(ends=(end(x.ends[0]), end(x.ends[1]))) for x in drawing.links],
        [x._replace(point=there(x.body, x.point)) for x in drawing.tags],
        drawing.size,
        float(drawing.floor - o[2]),
    )
    r = np.concatenate([frames.r[:, :ground] - o, frames.r[:, ground:]], axis=1)
    paths = [x._replace(points=there(x.frame, x.points)) for x in traces]
    return near, frames._replace(r=r), [x._replace(points=x.points - o) for x in arrows], paths


def traces_of(motion: Motion, frames: Frames, points: Points | None = None) -> list[Trace]:
    """Return the paths of points of bodies, in the colours of the bodies.

    ``points``: bodies or names, whose centres of mass are meant; pairs of one and a world point at the reference pose
    [m], carried by the body; and a third, a body from which the path is seen. None = the centres of mass that move by
    more than 1 % of the mechanism's size, at most 12, those that move most.
    """
    system, ground = motion.system, len(motion.system.bodies)
    index = {id(body): i for i, body in enumerate(system.bodies)} | {id(GROUND): ground}
    if points is not None:
        if isinstance(points, str):
            raise InputError(f"traces = {points!r:.80}; give a list of (body, (x, y, z))")
        found = [trace_point(system, entry) for entry in as_tuple(points, "traces", "a list of (body, (x, y, z))")]
        return [
            Trace(
                body.name,
                colour(index[id(body)]),
                relative_to(frames, index[id(base)], moved(frames, index[id(body)], x)),
                index[id(base)],
            )
            for body, x, base in found
        ]
    paths = [moved(frames, i, body.com) for i, body in enumerate(system.bodies)]
    ways = np.array([float(np.ptp(path, axis=0).max()) for path in paths])
    size = max(motion.compiled.model.length, float(np.ptp(np.concatenate(paths), axis=0).max()))
    most = sorted(np.argsort(-ways, kind="stable")[:TRACES_MAX].tolist())
    return [Trace(system.bodies[i].name, colour(i), paths[i], ground) for i in most if ways[i] > 0.01 * size]


def relative_to(frames: Frames, base: int, points: np.ndarray) -> np.ndarray:
    """Return points (frames, 3) of the world in the axes of a body; the ground's are those of the world."""
    return np.einsum("tji,tj->ti", matrix(frames.e[:, base]), points - frames.r[:, base])


def trace_point(system: Mechanism, entry: Point) -> tuple[Body, np.ndarray, Body | Ground]:
    """Return the body, the point in its axes, and the body from which it is seen, of an entry of ``traces``."""
    if isinstance(entry, Body | str):
        body = system.part(entry)
        return body, body.com, GROUND
    if not isinstance(entry, tuple | list) or len(entry) not in (2, 3):
        raise InputError(
            f"trace {short_repr(entry)} is neither a body nor a point of one; give a body, (body, (x, y, z)), or "
            "(body, (x, y, z), body from which it is seen)"
        )
    part, point, *base = entry
    body = system.part(part)
    return (
        body,
        body.local_point(vector(point, f"trace of body '{body.name}'")),
        system.part(base[0]) if base and not is_ground(base[0]) else GROUND,
    )


def is_ground(base: Any) -> bool:
    """Return whether a path is seen from the ground, GROUND or its name, which no body has."""
    return base is GROUND or (isinstance(base, str) and base == GROUND.name)


def curves_of(motion: Motion, frames: Frames, wanted: Wanted | None = None) -> list[Curve]:
    """Return the panels of `Solution.plot` over the time of the frames; a mode has none.

    Of force and moment, momentum and angular momentum the one that is zero throughout is left out. ``wanted`` None =
    what tells most: angles or slides of at most 6 joints that move (else the angular velocity of the first body), the
    energies, the efforts of drivers, the reactions of at most 6 joints, and which parts that switch are engaged.
    """
    if not isinstance(motion, RunResult):
        return []
    if isinstance(wanted, str) or not (wanted is None or isinstance(wanted, Iterable)):
        raise InputError(f"curves = {short_repr(wanted)}; give a list of quantities or (quantity, part, ...)")
    panels = seen_panels(motion, default_curves(motion) if wanted is None else wanted)
    return [curve(motion.t, frames.t, panel) for panel in panels]


def curve(samples: np.ndarray, t: np.ndarray, panel: Panel) -> Curve:
    """Return a panel read at the times [s], between samples along Akima's curves, which hardly swing beside a jump.

    Along straight lines what is rounding (``log``), what is somewhere not finite, and what has two samples or a time
    twice.
    """
    label = f"{panel.label} ({' '.join(panel.note.split())})" if panel.note else panel.label

    def read(values: np.ndarray) -> np.ndarray:
        smooth = samples.size > 2 and np.diff(samples).min() > 0.0 and not panel.log and np.isfinite(values).all()
        return Akima1DInterpolator(samples, values)(t) if smooth else np.interp(t, samples, values)

    lines = [(name, read(values)) for name, values in panel.lines]
    return Curve(label, panel.unit.strip("[]"), lines, panel.size)


def every_reaction(solution: RunResult, samples: np.ndarray) -> list[Reaction]:
    """Return `Solution.reaction` of every joint at the given samples, by one pass over them, not one per joint."""
    compiled, joints = solution.compiled, solution.system.joints
    lam = solution.arrays["lam"][samples]
    for joint in (joint for joint in joints if not solution._is_unique([joint])):
        rows = compiled.rows[id(joint)]
        lam[:, rows] = solution._shares[0][samples, rows]
    states, coordinates = solution.arrays["state"][samples], solution.arrays["coordinate"][samples]
    wrenches = wrenches_about_O(compiled, solution.t[samples], states, coordinates, lam)
    found = []
    for k, joint in enumerate(joints):
        point = joint.reaction_points(solution)[samples]
        origin = 0.0 if isinstance(joint.b, Ground) else solution.position(joint.b)[samples]
        force = wrenches[:, k, :3]
        moment = wrenches[:, k, 3:] - np.cross(point - origin, force)
        found.append(solution._determined([joint]).reaction(force, moment, point, samples))
    return found


def wrenches_about_O(
    compiled: Compiled, t: np.ndarray, states: np.ndarray, coordinates: np.ndarray, lam: np.ndarray
) -> np.ndarray:
    """Return force and moment (samples, joints, 6) of every joint on its body b about O: minus the sum of J' lam."""
    data, joints, pairs = compiled.data(), compiled.system.joints, []
    for k, joint in enumerate(joints):
        rows = compiled.rows[id(joint)]
        on_b = np.argwhere(compiled.model.row["body"][rows] == compiled.body_index[id(joint.b)])
        pairs += [(k, rows.start + row, slot) for row, slot in on_b]
    which, row, slot = np.array(pairs, dtype=int).reshape(-1, 3).T
    out = np.zeros((t.size, len(joints), 6))
    for i in range(t.size):
        load_rows(compiled, data, states[i], t[i], coordinates[i])
        np.subtract.at(out[i], which, data.row["J"][row, slot] * lam[i, row, None])
    return out
