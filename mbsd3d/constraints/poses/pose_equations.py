"""Joints and asked-for values as equations F(q) = 0 of a pose, with Newton's method."""

from typing import NamedTuple

import numpy as np

from ...base.rotations import conjugate, logarithm, matrix, multiply
from ...dynamics.state_rates import FACTOR_FROM_OTHER_POSE, PROJECTED, project_positions
from ...equations.at_state import coordinate_row, load_state
from ...equations.compiled import Compiled
from ...equations.jacobian import BlockRows, block_rows, displacement_units
from ...kernels.coordinates import coordinate, remember
from ...kernels.kinds import ANGLE
from ...kernels.kinematics import displace, displace_body, kinematics
from ...kernels.layout import Data, Model, Tree
from ...kernels.measures import measure
from ...kernels.rows import rows
from ...mechanism.state import State
from ..least_squares import least_motion, shortest
from .joint_motion import JointGraph


def nudged(y: np.ndarray, b: int, j: int, h: float) -> np.ndarray:
    """Return the state y with body b displaced by h in world direction j, or for j > 2 turned about direction j - 3."""
    dx, moved = np.zeros(6), y.copy()
    dx[j] = h
    displace_body(moved, 7 * b, tuple(dx[:3]), tuple(dx[3:]))
    return moved


def displaced(model: Model, y: np.ndarray, X: np.ndarray) -> np.ndarray:
    """Return y with r_G + delta r_G and exp(delta theta) o e for every body, from the first 6 n entries of X."""
    moved = y.copy()
    for i, (shift, turn) in enumerate(X[: 6 * model.body.size].reshape(-1, 2, 3)):
        q = 7 * i
        before = matrix(y[q + 3 : q + 7]) @ model.body["com"][i]
        displace_body(moved, q, tuple(shift), tuple(turn))
        moved[q : q + 3] += before - matrix(moved[q + 3 : q + 7]) @ model.body["com"][i]
    return moved


def closed(model: Model, data: Data, tree: Tree, t: float, y: np.ndarray, X: np.ndarray) -> np.ndarray | None:
    """Return `displaced`, projected onto c = 0 in the metric of M; None if the joints do not close there."""
    moved = displaced(model, y, X)
    return moved if project_positions(model, data, tree, t, moved, FACTOR_FROM_OTHER_POSE) == PROJECTED else None


CLOSED_GAP_MAX = 1e-9  # [1] residual in lengths of the model and radians of a pose that counts as closed
CORRECTION_MAX = 1e-6  # [1] residual from which Newton's method goes straight to the one pose nearby
ITERATIONS_MAX = 200  # of Newton's method; a chain that is drawn far off takes some fifty


class JointMotion(NamedTuple):
    """A displacement that moves the joints least."""

    x: np.ndarray  # (6 n,) m, rad
    rank: int  # of the rows, 0 = not computed
    twists: BlockRows  # of the joints, see `JointGraph.twist_rows`


class PoseEquations:
    """F(q): residuals of the holonomic rows, then of hinge coordinates and measures with values asked for.

    Of order one: rows and slides in lengths of the model, angles in radians, measures as they are.
    """

    def __init__(
        self, compiled: Compiled, pose: State, targets: list[tuple[int, float]], goals: list[float], pinned: set[int],
        weights: np.ndarray | None = None,
    ) -> None:  # fmt: skip
        model = compiled.model
        self.compiled, self.model, self.pose, self.t = compiled, model, pose, pose.t
        self.targets, self.goals, self.data = targets, goals, compiled.data()
        self.holonomic = model.row["holonomic"].astype(bool)
        self.scale = (model.row["scale"] * (1.0 if weights is None else weights))[self.holonomic]
        turns = [model.coordinate["kind"][i] == ANGLE for i, _ in targets]
        self.asked_scale = np.where([*turns, *(True for _ in goals)], 1.0, 1.0 / model.length)
        self.free = np.repeat([i not in pinned for i in range(model.body.size)], 6)
        self.columns = displacement_units(model.length, model.body.size) * self.free
        self.y = load_state(compiled, self.data, pose)

    @property
    def q(self) -> np.ndarray:
        """Return the pose (7 n,), a view."""
        return self.y[: 7 * self.model.body.size]

    def residual(self) -> np.ndarray:
        """Return F at the present pose."""
        return np.concatenate([self.data.row["c"][self.holonomic] * self.scale, self.misses() * self.asked_scale])

    def misses(self) -> np.ndarray:
        """Return what the asked-for values are off, hinge coordinates first [rad, m]."""
        model, data, t = self.model, self.data, self.t
        off = [coordinate(model, data, i, t)[0] - value for i, value in self.targets]
        return np.array(off + [measure(model, data, i, t) - value for i, value in enumerate(self.goals)], float)

    def asked_rows(self) -> np.ndarray:
        """Return gradients of the asked-for values with respect to displacements (6 n), one a row."""
        more = [coordinate_row(self.compiled, self.data, i, self.t)[1] for i, _ in self.targets]
        more += [self.measure_gradient(i) for i in range(len(self.goals))]
        return self.asked_scale[:, None] * np.array(more).reshape(-1, self.columns.size)

    def measure_gradient(self, i: int) -> np.ndarray:
        """Return the gradient of measure i by central differences; Newton needs no better."""
        model, data = self.model, self.data
        gradient, step = np.zeros((model.body.size, 6)), 1e-6
        probe = model.measure[i]
        on = probe["body"] if probe["coordinate"] < 0 else model.coordinate[probe["coordinate"]]["body"]
        for body in sorted({int(b) for b in on} - {model.body.size}):
            for j in range(6):
                values = []
                for sign in (1.0, -1.0):
                    kinematics(model, data, nudged(self.y, body, j, sign * step))
                    values.append(measure(model, data, i, self.t))
                gradient[body, j] = (values[0] - values[1]) / (2 * step)
        kinematics(model, data, self.y)
        return gradient.ravel()

    def motion(self, F: np.ndarray, graph: JointGraph | None = None) -> np.ndarray:
        """Return the least displacement (6 n,) [m, rad] that changes the residual by F, in the sense of least squares.

        With a graph it is the one that moves the joints least, so that what nobody asks for rests in its carrier.
        """
        if graph is not None:
            return self.joint_motion(F, graph).x
        J = block_rows(self.model, self.data).take(self.holonomic)
        return self.columns * shortest(J, self.scale, self.asked_rows(), self.columns, F)

    def joint_motion(self, F: np.ndarray, graph: JointGraph) -> JointMotion:
        """Return the `motion` by a graph with what it was found from."""
        J, B = block_rows(self.model, self.data).take(self.holonomic), graph.twist_rows(self.data, self.model.length)
        x, rank = least_motion(J, self.scale, self.asked_rows(), self.columns, F, B)
        return JointMotion(self.columns * x, rank, B)

    def change(self, motion: np.ndarray) -> np.ndarray:
        """Return the change of F in a small motion (6 n,) [m, rad]."""
        J = block_rows(self.model, self.data).take(self.holonomic)
        return np.concatenate([self.scale * J.times(motion), self.asked_rows() @ motion])

    def rates(self, motion: np.ndarray) -> np.ndarray:
        """Return the rates of the hinge coordinates in a motion (6 n,) [m, rad]."""
        data = self.data
        data.body["velocity"][:-1], data.body["w"][:-1] = motion.reshape(-1, 2, 3).transpose(1, 0, 2)
        remember(self.model, data, self.t)
        return data.coordinate["rate"].copy()

    def displace(self, dx: np.ndarray) -> None:
        """Move the bodies by dx (6 n,) [m, rad], counting turns on the way."""
        model, data = self.model, self.data
        data.body["acceleration"][:-1] = dx.reshape(-1, 6)
        displace(model, data, self.y)
        kinematics(model, data, self.y)
        remember(model, data, self.t)
        rows(model, data, self.t)

    def counted(self) -> np.ndarray:
        """Return hinge coordinates as they were counted last, a copy."""
        return self.data.coordinate["value"].copy()

    def put(self, q: np.ndarray, coordinates: np.ndarray) -> None:
        """Take the poses q, with turns counted near the given hinge coordinates."""
        self.q[:] = q
        self.data.coordinate["value"] = coordinates
        kinematics(self.model, self.data, self.y)
        remember(self.model, self.data, self.t)
        rows(self.model, self.data, self.t)

    def close(
        self, rest: np.ndarray | float = 0.0, graph: JointGraph | None = None, *, enough: float = 1e-15,
        most: int = ITERATIONS_MAX,
    ) -> float:  # fmt: skip
        """Solve F = rest by Newton's method; return the largest residual left, of the best pose, which is taken.

        Where the rows cannot all be met, the sum of squares of the weighted residuals is least.
        """
        best, taken, stalled = np.inf, (self.q.copy(), self.counted()), 0
        for _ in range(most):
            c = self.residual() - rest
            size = float(np.abs(c).max()) if c.size else 0.0
            stalled = 0 if size < 0.9 * best else stalled + 1
            if size < best:
                best, taken = size, (self.q.copy(), self.counted())
            if size < enough or stalled > (8 if best > 1e-12 else 1):
                break
            dx = self.motion(-c, graph if size > CORRECTION_MAX else None)
            turn = np.abs(dx.reshape(-1, 6)[:, 3:]).max(initial=0.0)
            shift = np.abs(dx.reshape(-1, 6)[:, :3]).max(initial=0.0) / self.model.length
            self.displace(dx * min(1.0, 0.5 / max(turn, shift, 1e-300)))  # half a radian, half a length
        if stalled:
            self.put(*taken)
        return best

    def state(self) -> State:
        """Return the pose with its hinge coordinates, velocities as at the start."""
        return State(self.t, self.q, self.pose.v, self.pose.z, self.values())

    def values(self) -> np.ndarray:
        """Return the hinge coordinates of the pose."""
        values = [coordinate(self.model, self.data, i, self.t)[0] for i in range(self.model.coordinate.size)]
        return np.array(values, float)

    def row_residual(self) -> np.ndarray:
        """Return the residual (m,) of all rows [m, rad], 0 of those without one."""
        return np.where(self.holonomic, self.data.row["c"], 0.0)


def newton(
    compiled: Compiled, pose: State, targets: list[tuple[int, float]], goals: list[float], pinned: set[int],
    weights: np.ndarray | None = None,
) -> tuple[State, np.ndarray]:  # fmt: skip
    """Return (closest state, residual left in the rows) of Newton's method with least displacements onto F = 0."""
    equations = PoseEquations(compiled, pose, targets, goals, pinned, weights)
    equations.close()
    return equations.state(), equations.row_residual()


def gap_size(compiled: Compiled, residual: np.ndarray) -> float:
    """Return the largest residual in units of the model (lengths, radians)."""
    return float(np.abs(residual * compiled.model.row["scale"]).max(initial=0.0))


def displacements(before: State, after: State) -> np.ndarray:
    """Return the displacements (n, 6) of all bodies between two poses: of O [m] and rotation vectors [rad], world."""
    a, b = before.q.reshape(-1, 7), after.q.reshape(-1, 7)
    return np.hstack([b[:, :3] - a[:, :3], logarithm(multiply(b[:, 3:], conjugate(a[:, 3:])))])
