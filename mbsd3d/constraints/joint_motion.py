"""How bodies move relative to each other: the joints that carry them, their relative twists, poses along these."""

from dataclasses import dataclass

import numpy as np
from scipy.cluster.hierarchy import DisjointSet

from ..base.quaternions import exponential, multiply, skew
from ..base.rotations import matrix
from ..equations.compiled import Compiled
from ..equations.jacobian import BlockRows
from ..kernels.layout import Data
from ..mechanism.couplings import Coupling
from ..mechanism.drivers import Driver
from ..mechanism.joints import Joint

CARRYING_ROWS_MIN = 3  # [1] holonomic rows of a joint that carries a body along; one with fewer only touches it


@dataclass(frozen=True)
class JointGraph:
    """The joints that carry bodies, and the body that each body is carried by; the ground is body n.

    The heaviest body of each group that no joint ties to the ground counts as joined to it: the others move by it.
    """

    a: np.ndarray  # (j,) bodies of the joints
    b: np.ndarray  # (j,)
    point: np.ndarray  # (j, 3) m, point of the joint, axes of b
    parent: np.ndarray  # (n,)
    order: list[int]  # bodies, parents first

    def twist_rows(self, data: Data, length: float) -> BlockRows:
        """Return B (6 j rows): B v are the twists of b relative to a at the joints, in axes of a; units of order one."""
        r, R = data.body["r"], data.body["R"].reshape(-1, 3, 3)
        R_a = R[self.a].transpose(0, 2, 1)
        arm_b = np.einsum("kij,kj->ki", R[self.b], self.point)
        arm_a = r[self.b] + arm_b - r[self.a]
        J = np.zeros((self.a.size, 6, 4, 6))
        J[:, :3, 0, :3], J[:, :3, 0, 3:] = -R_a, R_a @ skew(arm_a)
        J[:, :3, 1, :3], J[:, :3, 1, 3:] = R_a, -R_a @ skew(arm_b)
        J[:, 3:, 0, 3:], J[:, 3:, 1, 3:] = -R_a, R_a
        body = np.full((self.a.size, 4), -1)
        body[:, 0], body[:, 1] = self.a, self.b
        rows = BlockRows(np.repeat(body, 6, axis=0), J.reshape(-1, 4, 6), self.parent.size)
        return rows.scaled(np.tile(np.repeat([1.0 / length, 1.0], 3), self.a.size), length)

    def relative(self, q: np.ndarray, motion: np.ndarray) -> np.ndarray:
        """(n, 6) motions of the bodies relative to their parents, at their reference points [m, rad, world]."""
        r, moved = with_ground(q.reshape(-1, 7)[:, :3]), with_ground(motion.reshape(-1, 6))
        own, carrier = moved[:-1].copy(), moved[self.parent]
        own[:, :3] -= carrier[:, :3] + np.cross(carrier[:, 3:], r[:-1] - r[self.parent])
        own[:, 3:] -= carrier[:, 3:]
        return own

    def moved(self, q: np.ndarray, motion: np.ndarray) -> np.ndarray:
        """(7 n,) poses after a motion (6 n,) [m, rad]: every body goes along a screw that rests in its parent.

        That is exact for chains of hinges, slides and screws, however far each of them moves.
        """
        before, relative = q.reshape(-1, 7), self.relative(q, motion)
        turns = exponential(relative[:, 3:])
        screwed = np.concatenate(
            [before[:, :3] + advance(relative[:, :3], relative[:, 3:]), multiply(turns, before[:, 3:])], axis=1
        )
        n, after = self.parent.size, screwed.copy()
        turned = np.vstack([turns, [1.0, 0.0, 0.0, 0.0]])  # of each body, by all joints up to it
        for i in self.order:
            p = self.parent[i]
            if p < n:
                after[i, :3] = after[p, :3] + matrix(turned[p]) @ (screwed[i, :3] - before[p, :3])
                after[i, 3:] = multiply(turned[p], screwed[i, 3:])
                turned[i] = multiply(turned[p], turned[i])
        return after.ravel()


def with_ground(x: np.ndarray) -> np.ndarray:
    """Values of the bodies, and zero of the ground below them."""
    return np.vstack([x, np.zeros(x.shape[1])])


def advance(shift: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """(n, 3) way [m] of points that start with ``shift`` and turn with their bodies, which turn by ``turn`` [rad]."""
    angle = np.linalg.norm(turn, axis=1)
    small = np.maximum(angle, 1e-4)  # below, the next term of either series is 1e-9 of the last one kept
    first = np.where(angle > small * 0.999, (1.0 - np.cos(small)) / small**2, 0.5)[:, None]
    second = np.where(angle > small * 0.999, (small - np.sin(small)) / small**3, 1.0 / 6.0)[:, None]
    across = np.cross(turn, shift)
    return shift + first * across + second * np.cross(turn, across)


def carrying_rows(joint: Joint) -> int:
    """Return the number of holonomic rows of a joint between two bodies, 0 of couplings and drivers."""
    if isinstance(joint, Coupling | Driver) or len(joint.bodies()) != 2:
        return 0
    return sum(sum(row.holonomic) for row in joint.primitives)


def joint_graph(compiled: Compiled, pinned: set[int]) -> JointGraph:
    """Return the joints that carry bodies; trees start at the ground and at the pinned bodies."""
    system, index, n = compiled.system, compiled.body_index, len(compiled.system.bodies)
    joints = sorted(
        (j for j in system.joints if carrying_rows(j) >= CARRYING_ROWS_MIN), key=lambda j: -carrying_rows(j)
    )
    edges = [(index[id(joint.a)], index[id(joint.b)], joint.b.local_point(joint.point())) for joint in joints]
    groups, neighbours = DisjointSet(range(n + 1)), [[] for _ in range(n + 1)]
    for i in pinned:
        groups.merge(n, i)
    for i, j, _ in edges:
        if groups.merge(i, j):
            neighbours[i].append(j)
            neighbours[j].append(i)
    for group in groups.subsets():
        if n not in group:
            root = max(group, key=lambda i: (system.bodies[i].mass, system.name(system.bodies[i])))
            edges.append((n, root, np.zeros(3)))
            neighbours[n].append(root)
    parent, order = np.full(n, n), sorted(pinned)
    seen, queue = {n, *pinned}, [n, *order]
    for i in queue:
        for j in neighbours[i]:
            if j not in seen:
                parent[j] = i
                seen.add(j)
                queue.append(j)
                order.append(j)
    a, b = (np.array([edge[k] for edge in edges], int) for k in (0, 1))
    return JointGraph(a, b, np.array([edge[2] for edge in edges]).reshape(-1, 3), parent, order)
