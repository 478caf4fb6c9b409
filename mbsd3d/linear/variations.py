"""First-order variations of the equations of motion at a state, by complex steps through the kernels.

    X = (delta r_G, delta theta per body | delta v_G, delta w per body | delta z),   X_dot = F X,   world axes

with r_G the centre of mass: the displacement of a reference point off the axis of a spinning wheel would turn with
the wheel. ``delta theta_dot = delta w + w x delta theta``; C X and D X are the variations of the residuals c and of
J v - b, L X those of the measures. One imaginary step of 1e-30 gives a column of F, C, D and L exact to rounding.

The deviations that the constraints allow are X = E x, with states x that are entries of X themselves:

configuration   C delta q = 0                      C: holonomic rows
velocity        D_v delta v + D_q delta q = 0      D: variation of J v - b, all rows
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..base.errors import AssemblyError, InputError
from ..base.rotations import H, matrix, skew
from ..constraints.rank import choose_rows
from ..dynamics.applied_forces import loads
from ..dynamics.state_rates import accelerate
from ..equations.at_state import load_rows, load_state, worst_joint
from ..equations.compiled import Compiled, new_data
from ..equations.jacobian import RANK_TOLERANCE, displacement_units
from ..equations.tree import build_spanning_tree
from ..kernels.coordinates import remember
from ..kernels.kinematics import kinematics
from ..kernels.layout import Data, Model, Tree
from ..kernels.measures import measure
from ..kernels.rows import rows
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from ..solver.saddle_point import SOLVED, factor

COMPONENTS = ("x", "y", "z", "theta_x", "theta_y", "theta_z", "v_x", "v_y", "v_z", "w_x", "w_y", "w_z")
UNITS = ("m", "rad", "m/s", "rad/s")
COMPLEX_STEP = 1e-30  # [1] imaginary part of a complex step: its square is lost, and no difference is taken


@dataclass(frozen=True, eq=False)
class Variations:
    """Vector field and its derivatives at one state of n bodies, N = 12 n + internal states of the force elements."""

    F: np.ndarray  # (N, N) X_dot = F X
    C: np.ndarray  # (rows, N) of the residuals c; zero in nonholonomic rows
    D: np.ndarray  # (rows, N) of J v - b
    L: np.ndarray  # (outputs, N) of the measures
    outputs: np.ndarray  # (outputs,) their values
    centre: np.ndarray  # (n, 3) r_G [m]
    velocity: np.ndarray  # (n, 6) v_G, w
    acceleration: np.ndarray  # (n, 6) their rates
    z_rate: np.ndarray  # internal states
    c: np.ndarray  # (rows,) residuals
    slip: np.ndarray  # (rows,) J v - b


class Field:
    """Equations of motion of a system near a state, for complex states."""

    def __init__(self, compiled: Compiled, state: State, outputs: int) -> None:
        self.compiled, self.t, self.outputs = compiled, state.t, outputs
        self.real, self.data = compiled.data(), compiled.data(complex)
        self.y = load_state(compiled, self.real, state)
        remember(compiled.model, self.real, state.t)  # hinge angles go on from here, also at a later time
        self.data.coordinate[:] = self.real.coordinate
        self.data.unwrap_time[:] = self.real.unwrap_time

    def loaded_alone(self, model: Model, y: np.ndarray, dtype: type = float) -> Data:
        """Return a work space of force elements alone at a real or complex state; its hinges count turns as here."""
        data = new_data(model, dtype)
        data.coordinate[:], data.unwrap_time[:] = self.real.coordinate, self.real.unwrap_time
        kinematics(model, data, y)
        return data

    def rows_at(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return independent rows at a state; they are fixed while the state is varied."""
        load_rows(self.compiled, self.real, y, t)
        return choose_rows(self.compiled.model, self.real)

    def at(self, t: float, y: np.ndarray) -> Variations:
        """Return all variations at a state y."""
        model, moves = self.compiled.model, directions(self.compiled.model, y)
        tree = build_spanning_tree(model, self.real, self.rows_at(t, y), complex)
        here, change = self.derivatives(tree, t, y, moves)
        n = model.body.size
        X_dot = np.zeros((moves.shape[1], moves.shape[1]))
        X_dot[: 6 * n] = change["position_rate"]
        X_dot[6 * n : 12 * n] = change["acceleration"]
        X_dot[12 * n :] = change["z_rate"]
        acceleration, velocity = here["acceleration"].reshape(n, 6), here["velocity"].reshape(n, 6)
        holonomic = model.row["holonomic"][:, None] == 1
        return Variations(
            X_dot, np.where(holonomic, change["c"], 0.0), change["slip"], change["outputs"], here["outputs"],
            here["centre"].reshape(n, 3), velocity, acceleration, here["z_rate"], here["c"], here["slip"],
        )  # fmt: skip

    def columns(self, tree: Tree, t: float, y: np.ndarray, moves: np.ndarray) -> dict[str, np.ndarray]:
        """Return bodies, rows, rates of internal states and measures at complex steps along ``moves``, a row each."""
        model, data, k = self.compiled.model, self.data, moves.shape[1]
        tables = {"body": data.body, "row": data.row}
        copies = {key: np.empty((k, table.nbytes), np.uint8) for key, table in tables.items()}  # bytes copy fastest
        z_rate, outputs = np.empty((k, model.z_work), complex), np.empty((k, self.outputs), complex)
        for j, move in enumerate(moves.T):
            solve(model, data, tree, t, y + 1j * COMPLEX_STEP * move)
            for key, table in tables.items():
                copies[key][j] = table.view(np.uint8)
            z_rate[j] = data.state_rate[: model.z_work]
            outputs[j] = [measure(model, data, i, t) for i in range(self.outputs)]
        return {key: copies[key].view(table.dtype) for key, table in tables.items()} | {
            "z_rate": z_rate, "outputs": outputs,
        }  # fmt: skip

    def derivatives(
        self, tree: Tree, t: float, y: np.ndarray, moves: np.ndarray
    ) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Return (values at y, derivatives along the columns of ``moves``): one call of the kernels a column."""
        found = self.columns(tree, t, y, moves)
        columns = {
            **values(self.compiled.model, found["body"], found["row"]),
            "z_rate": found["z_rate"], "outputs": found["outputs"],
        }  # fmt: skip
        self.check_finite(columns)
        return {key: x[0].real for key, x in columns.items()}, {
            key: x.imag.T / COMPLEX_STEP for key, x in columns.items()
        }

    def output_rates(self, t: float, y: np.ndarray, moves: np.ndarray) -> np.ndarray:
        """Return the derivatives (outputs, k) of the measures along the columns of ``moves``."""
        model, data = self.compiled.model, self.data
        found = np.empty((moves.shape[1], self.outputs))
        for j, move in enumerate(moves.T):
            kinematics(model, data, y + 1j * COMPLEX_STEP * move)
            found[j] = [measure(model, data, i, t).imag / COMPLEX_STEP for i in range(self.outputs)]
        return found.T

    def check_finite(self, columns: dict[str, np.ndarray]) -> None:
        """Raise an error if a force has no derivative: a user's function that fails for complex numbers has none."""
        system, power = self.compiled.system, self.data.force["power"]
        for force, value in zip(system.forces, power, strict=True):
            if not np.isfinite(value):
                raise InputError(
                    f"linearize: {type(force).__name__} '{system.name(force)}' has no derivative at this state; "
                    "linearise about another one, or give a function that also takes complex numbers"
                )
        if not all(np.isfinite(x).all() for x in columns.values()):
            raise InputError("linearize: the equations have no finite derivative at this state; give another one")


def directions(model: Model, y: np.ndarray) -> np.ndarray:
    """Return (ny, N) the change of y = (q, u, z) with X: r = r_G - s, e_dot = H w / 2, u = (r_dot, R'w)."""
    n, k = model.body.size, model.z_work
    moves = np.zeros((y.size, 12 * n + k))
    for i in range(n):
        e, u = y[7 * i + 3 : 7 * i + 7], y[7 * n + 6 * i : 7 * n + 6 * i + 6]
        R = matrix(e)
        S, W = skew(R @ model.body["com"][i]), skew(R @ u[3:])
        q, p = slice(7 * i, 7 * i + 3), slice(7 * n + 6 * i, 7 * n + 6 * i + 3)
        x, v = 6 * i, 6 * n + 6 * i
        moves[q, x : x + 3] = np.eye(3)
        moves[q, x + 3 : x + 6] = S
        moves[7 * i + 3 : 7 * i + 7, x + 3 : x + 6] = 0.5 * H(e)
        moves[p, v : v + 3] = np.eye(3)
        moves[p, v + 3 : v + 6] = S
        moves[p, x + 3 : x + 6] = W @ S
        moves[p.stop : p.stop + 3, v + 3 : v + 6] = R.T
        moves[p.stop : p.stop + 3, x + 3 : x + 6] = R.T @ W
    moves[13 * n : 13 * n + k, 12 * n :] = np.eye(k)
    return moves


def solve(model: Model, data: Data, tree: Tree, t: float, y: np.ndarray) -> None:
    """Evaluate ``data`` at a complex state."""
    kinematics(model, data, y)
    rows(model, data, t)
    factor(model, data, tree)
    if accelerate(model, data, tree, t) != SOLVED:
        raise AssemblyError(
            "linearize: the equations of motion have no solution", time=t,
            advice="see system.check(); give massless bodies joints that determine their motion",
        )  # fmt: skip


def values(model: Model, body: np.ndarray, row: np.ndarray) -> dict[str, np.ndarray]:
    """Return all varied quantities of bodies (k, n + 1) and rows (k, m) at k complex states of one real part."""
    k, n = body.shape[0], model.body.size
    moving, body = np.concatenate([body["velocity"], body["w"]], axis=-1), body[:, :n]  # the ground is at rest
    s, w = body["s"], body["w"]
    v_dot, w_dot = body["acceleration"][..., :3], body["acceleration"][..., 3:]
    v_G = body["velocity"] + cross(w, s)
    a_G = v_dot + cross(w_dot, s) + cross(w, cross(w, s))
    on = np.where(model.row["body"] < 0, n, model.row["body"])  # unused slots: the ground
    turn_rate = w + cross(w.real, turns(body["e"]))
    return {
        "position_rate": np.concatenate([v_G, turn_rate], axis=-1).reshape(k, -1),
        "acceleration": np.concatenate([a_G, w_dot], axis=-1).reshape(k, -1),
        "centre": (body["r"] + s).reshape(k, -1),
        "velocity": np.concatenate([v_G, w], axis=-1).reshape(k, -1),
        "c": row["c"],
        "slip": np.einsum("kisj,kisj->ki", row["J"], moving[:, on]) - row["b"],
    }


def turns(e: np.ndarray) -> np.ndarray:
    """Return (k, n, 3) the rotation delta theta of complex quaternions (k, n, 4): i delta theta = 2 H' e."""
    return 2j * np.einsum("bij,kbi->kbj", H(e[0].real), e.imag)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return (..., 3) a x b; `numpy.cross` takes several times as long for a few vectors."""
    ahead, behind = [1, 2, 0], [2, 0, 1]
    return a[..., ahead] * b[..., behind] - a[..., behind] * b[..., ahead]


@dataclass(frozen=True, eq=False)
class Tangent:
    """Tangent space X = E x; x are the entries ``chosen`` of X: configuration, velocity and internal states."""

    E: np.ndarray  # (N, n_x)
    chosen: np.ndarray  # (n_x,)
    configuration: int
    velocity: int

    def names(self, system: Mechanism) -> tuple[str, ...]:
        """Return one name per state."""
        n, found = 6 * len(system.bodies), []
        for j in self.chosen:
            part = system.name(system.bodies[j % n // 6]) if j < 2 * n else None
            found.append(f"{COMPONENTS[j % 6 + 6 * (j // n)]} of {part}" if part else f"z{j - 2 * n}")
        return tuple(found)

    def unit_names(self, model: Model) -> tuple[str, ...]:
        """Return one unit per state; internal states of force elements have the unit of the element."""
        n = 6 * model.body.size
        return tuple(UNITS[j % 6 // 3 + 2 * (j // n)] if j < 2 * n else "-" for j in self.chosen)


def free_basis(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (basis N of the null space of A with the unit matrix in the rows ``chosen``, these rows)."""
    _, s, Vt = scipy.linalg.svd(A)
    rank = int((s > RANK_TOLERANCE * s[0]).sum()) if s.size and s[0] > 0.0 else 0
    Z = Vt[rank:].T
    _, _, pivot = scipy.linalg.qr(Z.T, mode="economic", pivoting=True)
    chosen = np.sort(pivot[: Z.shape[1]])
    return np.linalg.solve(Z[chosen].T, Z.T).T, chosen


def tangent_space(compiled: Compiled, at: Variations) -> Tangent:
    """Return E at a state; raise a ValueError at a singular pose, where a redundant row is independent beside it."""
    model, n = compiled.model, 6 * compiled.model.body.size
    columns = displacement_units(model.length, model.body.size)
    rows = model.row["scale"][:, None]
    D_q, D_v = rows * at.D[:, :n] * columns, rows * at.D[:, n : 2 * n] * columns
    N_q, free_q = free_basis(rows * at.C[:, :n] * columns)
    N_v, free_v = free_basis(D_v)
    P = (
        scipy.linalg.lstsq(D_v, -D_q @ N_q, cond=RANK_TOLERANCE)[0]
        if D_v.size and free_q.size
        else np.zeros((n, free_q.size))
    )
    P -= N_v @ P[free_v]
    check_consistent(compiled, D_v @ P + D_q @ N_q, np.abs(D_q).max(initial=0.0))
    N_q, P = N_q * columns[:, None] / columns[free_q], P * columns[:, None] / columns[free_q]
    N_v = N_v * columns[:, None] / columns[free_v]
    E = scipy.linalg.block_diag(N_q, N_v, np.eye(model.z_work))
    E[n : 2 * n, : free_q.size] = P
    chosen = np.concatenate([free_q, n + free_v, 2 * n + np.arange(model.z_work)])
    return Tangent(E, chosen, free_q.size, free_v.size)


def check_consistent(compiled: Compiled, left: np.ndarray, size: float) -> None:
    """Check that all rows, also the redundant ones, admit velocities at the neighbouring configurations."""
    miss = np.abs(left).max(axis=1, initial=0.0)
    if miss.max(initial=0.0) > 1e-7 * max(size, 1e-300):  # rows of a regular position agree to rounding
        part, residual = worst_joint(compiled, miss / compiled.model.row["scale"])
        raise InputError(
            f"linearize: singular position: at neighbouring positions no velocities meet {part} (residual "
            f"{residual:.2g}); move away from the dead centre"
        )


def loads_and_rates(model: Model, data: Data, t: float) -> np.ndarray:
    """Return forces and moments about O (6 n,) and rates of internal states (z_work,) of all force elements."""
    data.state_rate[:] = 0.0
    loads(model, data, t)
    return np.concatenate([data.body["Q"][: model.body.size].ravel(), data.state_rate[: model.z_work]])
