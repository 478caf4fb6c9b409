"""Forward kinematics of the spanning tree: moving everything beyond a hinge by its angle or slide."""

import numpy as np
from scipy.cluster.hierarchy import DisjointSet

from ..base.quaternions import exponential, multiply
from ..base.rotations import matrix
from ..equations.compiled import Compiled
from ..kernels import kinds
from ..mechanism.couplings import Coupling
from ..mechanism.mechanism import Mechanism
from ..mechanism.primitives import Coordinate
from ..mechanism.state import State


def swing(compiled: Compiled, pose: State, targets: list[tuple[Coordinate, float]], pinned: set[int]) -> State:
    """Forward kinematics: everything beyond a joint in the spanning tree moves by the asked-for angle or slide."""
    system, index = compiled.system, compiled.body_index
    n = len(system.bodies)
    poses = pose.q.reshape(n, 7).copy()
    links, points = joint_links(system, index), hinge_points(system)
    for x, value in targets:
        k = bodies_beyond(links, index[id(x.a)], index[id(x.b)])
        if k is None or x.kind not in ("angle", "slide") or pinned.intersection(k):
            continue  # the joint closes a loop, leads along a curve, or what it moves is held: Newton's task
        sign = 1.0 if index[id(x.b)] in k else -1.0
        fixed = x.a if sign > 0.0 else x.b
        i = index[id(fixed)]
        e, r = (fixed.orientation, fixed.position) if i == n else (poses[i, 3:], poses[i, :3])
        own = x.axis if fixed is x.a else x.axis_b
        axis = matrix(e) @ fixed.local_axis(own)
        if x.kind == "slide":
            poses[k, :3] += sign * value * axis
            continue
        point = points.get(line_of(x), x.point_a if fixed is x.a else x.point_b)
        pivot = r + matrix(e) @ fixed.local_point(point)
        turn = exponential(sign * value * axis)
        poses[k, :3] = pivot + (poses[k, :3] - pivot) @ matrix(turn).T
        poses[k, 3:] = multiply(turn, poses[k, 3:])
    return State(pose.t, poses.ravel(), pose.v, pose.z)


def geared(compiled: Compiled, targets: list[tuple[Coordinate, float]]) -> list[tuple[Coordinate, float]]:
    """The asked-for angles and slides, and what gears, racks and screws make of them: f_0 x_0 + f_1 x_1 = 0."""
    known, before = {compiled.coordinate(x): (x, value) for x, value in targets}, 0
    rows = [row for joint in compiled.system.joints for row in joint.primitives]
    rows = [row for row in rows if row.kind in (kinds.RATIO, kinds.MESH) and len(row.coordinates) == 2]
    while before < len(known):
        before = len(known)
        for row in rows:
            ends = [(compiled.coordinate(x), x, factor) for x, factor in zip(row.coordinates, row.values, strict=True)]
            for (i, _, factor), (j, x, other) in (ends, ends[::-1]):
                if i in known and j not in known and other != 0.0:
                    known[j] = (x, -factor * known[i][1] / other)
    return list(known.values())


def line_of(x: Coordinate) -> tuple:
    """Coordinates of one line: same bodies, same axis."""
    return id(x.a), id(x.b), x.axis.tobytes()


def hinge_points(system: Mechanism) -> dict[tuple, np.ndarray]:
    """A point on the line of each hinge, world at the reference pose."""
    points: dict[tuple, np.ndarray] = {}
    for joint in system.joints:
        x = joint.angle()
        if x is not None and hasattr(joint, "at"):
            points.setdefault(line_of(x), joint.at)
    return points


def joint_links(system: Mechanism, index: dict[int, int]) -> list[set[int]]:
    """Bodies that share a joint with each body; the ground is the last. Couplings (see `geared`) hold none in place."""
    links: list[set[int]] = [set() for _ in range(len(system.bodies) + 1)]
    for joint in system.joints:
        if isinstance(joint, Coupling):
            continue
        ends = {index[id(body)] for body in joint.bodies()}
        for i in ends:
            links[i] |= ends - {i}
    return links


def bodies_beyond(links: list[set[int]], a: int, b: int) -> list[int] | None:
    """Bodies that hang on the ground through the hinge of a and b only; None where the hinge is part of a loop."""
    reached = reachable(links, len(links) - 1, {a, b})
    if (a in reached) == (b in reached):
        return None
    return sorted(reachable(links, b if a in reached else a, {a, b}))


def reachable(links: list[set[int]], start: int, cut: set[int]) -> set[int]:
    """Bodies connected to one, without the direct way between the two of ``cut``."""
    reached, queue = {start}, [start]
    while queue:
        i = queue.pop()
        new = links[i] - reached - (cut if i in cut else set())
        reached |= new
        queue += new
    return reached


def loop_weights(compiled: Compiled) -> np.ndarray:
    """1 for the rows of a spanning tree of joints, 1e-4 for those that close loops."""
    weights, trees = np.ones(compiled.model.row.size), DisjointSet(range(compiled.model.body.size + 1))
    for joint in compiled.system.joints:
        first, *others = (compiled.body_index[id(body)] for body in joint.bodies())
        if not any([trees.merge(first, other) for other in others]):
            weights[compiled.rows[id(joint)]] = 1e-4
    return weights
