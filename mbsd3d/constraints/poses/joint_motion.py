"""Relative motion of bodies: the joints that carry them, their relative twists, and poses along these."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ...base.rotations import crosses, exponential, multiply, skew
from ...equations.compiled import Compiled
from ...equations.jacobian import BlockRows
from ...equations.tree import Groups
from ...kernels.layout import Data
from ...mechanism.couplings import Coupling
from ...mechanism.drivers import Driver
from ...mechanism.joints import Joint

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
    levels: list[list[int]]  # bodies that are carried by others than the ground, parents first

    def twist_rows(self, data: Data, length: float) -> BlockRows:
        """Return B (6 j rows): B v are the twists of b relative to a at the joints, axes of a; units of order one."""
        r, R = data.body["r"], data.body["R"].reshape(-1, 3, 3)
        R_a = R[self.a].transpose(0, 2, 1)
        arm_b = (R[self.b] @ self.point[:, :, None])[:, :, 0]
        arm_a = r[self.b] + arm_b - r[self.a]
        J = np.zeros((self.a.size, 6, 4, 6))
        J[:, :3, 0, :3], J[:, :3, 0, 3:] = -R_a, R_a @ skew(arm_a / length)
        J[:, :3, 1, :3], J[:, :3, 1, 3:] = R_a, R_a @ skew(arm_b / -length)
        J[:, 3:, 0, 3:], J[:, 3:, 1, 3:] = -R_a, R_a
        return BlockRows(self.slots, J.reshape(-1, 4, 6), self.parent.size)

    @cached_property
    def slots(self) -> np.ndarray:
        """Return the bodies (6 j, 4) of the rows."""
        slots = np.full((self.a.size, 4), -1)
        slots[:, 0], slots[:, 1] = self.a, self.b
        return np.repeat(slots, 6, axis=0)

    def relative(self, data: Data, motion: np.ndarray) -> np.ndarray:
        """Return motions (6 n,) of bodies relative to their parents at their reference points, body axes [m, rad]."""
        r, moved = data.body["r"], with_ground(motion.reshape(-1, 6))
        own, carrier = moved[:-1].copy(), moved[self.parent]
        own[:, :3] -= carrier[:, :3] + crosses(carrier[:, 3:], r[:-1] - r[self.parent])
        own[:, 3:] -= carrier[:, 3:]
        R = data.body["R"][:-1].reshape(-1, 3, 3)
        return (own.reshape(-1, 2, 3) @ R).ravel()

    def moved(self, data: Data, relative: np.ndarray) -> np.ndarray:
        """Return poses (7 n,) after `relative` motions: every body goes along a screw that rests in its parent.

        That is exact for chains of hinges, slides and screws, however far each of them moves.
        """
        r_before, e_before = data.body["r"], data.body["e"][:-1]
        R = data.body["R"][:-1].reshape(-1, 3, 3)
        shift, turn = (relative.reshape(-1, 2, 3) @ R.transpose(0, 2, 1)).transpose(1, 0, 2)
        turned = np.vstack([exponential(turn), [1.0, 0.0, 0.0, 0.0]])  # of bodies, the ground last
        r = r_before + with_ground(advance(shift, turn))
        for level in self.levels:
            p = self.parent[level]
            r[level] = r[p] + rotated(turned[p], r[level] - r_before[p])
            turned[level] = multiply(turned[p], turned[level])
        return np.concatenate([r[:-1], multiply(turned[:-1], e_before)], axis=1).ravel()


def with_ground(x: np.ndarray) -> np.ndarray:
    """Return values of the bodies, and zero of the ground below them."""
    return np.vstack([x, np.zeros(x.shape[1])])


def rotated(e: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return (n, 3) vectors turned by unit quaternions: x + 2 e_0 e_v x x + 2 e_v x (e_v x x)."""
    across = 2.0 * crosses(e[:, 1:], x)
    return x + e[:, :1] * across + crosses(e[:, 1:], across)


def advance(shift: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Return the way (n, 3) [m] of points that set out along ``shift`` while their bodies turn by ``turn`` [rad].

    s + (1 - cos a) / a^2 t x s + (a - sin a) / a^3 t x (t x s), a = |t|.
    """
    angle = np.maximum(np.linalg.norm(turn, axis=1), 1e-4)[:, None]  # below, a^2 / 20 is less than rounding of turns
    across = crosses(turn, shift)
    first, second = (1.0 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3
    return shift + first * across + second * crosses(turn, across)


def carrying_rows(joint: Joint) -> int:
    """Return the number of holonomic rows of a joint between two bodies, 0 of couplings and drivers."""
    if isinstance(joint, Coupling | Driver) or len(joint.bodies()) != 2:
        return 0
    return sum(sum(row.holonomic) for row in joint.primitives)


def joint_graph(compiled: Compiled, pinned: set[int]) -> JointGraph:
    """Return the joints that carry bodies; trees start at the ground and at the pinned bodies."""
    if pinned:
        return new_joint_graph(compiled, pinned)
    if "joint graph" not in compiled.system.derived:
        compiled.system.derived["joint graph"] = new_joint_graph(compiled, pinned)
    return compiled.system.derived["joint graph"]


def new_joint_graph(compiled: Compiled, pinned: set[int]) -> JointGraph:
    """Return a `joint_graph` that is made anew."""
    system, index, n = compiled.system, compiled.body_index, len(compiled.system.bodies)
    joints = [joint for joint in system.joints if carrying_rows(joint) >= CARRYING_ROWS_MIN]
    joints.sort(key=carrying_rows, reverse=True)
    edges = [(index[id(joint.a)], index[id(joint.b)], joint.b.local_point(joint.point())) for joint in joints]
    groups = Groups(n + 1)
    neighbours: list[list[int]] = [[] for _ in range(n + 1)]
    for i in pinned:
        groups.merge(n, i)
    for i, j, _ in edges:
        if groups.merge(i, j):
            neighbours[i].append(j)
            neighbours[j].append(i)
    for group in groups.members():
        if n not in group:
            root = max(group, key=lambda i: (system.bodies[i].mass, system.name(system.bodies[i])))
            edges.append((n, root, np.zeros(3)))
            neighbours[n].append(root)
    a, b = (np.array([edge[k] for edge in edges], int) for k in (0, 1))
    parent, levels = spread(neighbours, [n, *sorted(pinned)])
    return JointGraph(a, b, np.array([edge[2] for edge in edges]).reshape(-1, 3), parent, levels)


def spread(neighbours: list[list[int]], roots: list[int]) -> tuple[np.ndarray, list[list[int]]]:
    """Return (parent of each body, bodies that are carried by others than the roots, parents first)."""
    n = len(neighbours) - 1
    parent, levels, level, seen = np.full(n, n), [], roots, set(roots)
    while level:
        carried = {j: i for i in level for j in neighbours[i] if j not in seen}
        level = list(carried)
        parent[level] = list(carried.values())
        seen.update(level)
        levels.append(level)
    return parent, levels[1:-1]
