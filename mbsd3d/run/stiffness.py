"""Which force makes a model stiff: the fastest rate that each force element gives to the bodies it acts on."""

from collections.abc import Callable
from functools import partial

import numpy as np
import scipy.linalg

from ..base.errors import IntegrationError
from ..base.rotations import matrix
from ..constraints.poses.pose_equations import nudged
from ..dynamics.applied_forces import loads
from ..equations.at_state import load_rows
from ..equations.compiled import Compiled
from ..equations.dense_solvers import inertia_about_origin
from ..integrators.runge_kutta import STIFFNESS_PRODUCT_MIN
from ..kernels.layout import Data, Model
from ..results.result import RunResult

IMPLICIT_BODIES_MAX = 20  # beyond, the matrices of RadauIIA cost more than its longer steps save
STEP = 1e-7  # of central differences, in model lengths and radians; a rate needs no more than two digits


def check_forces(compiled: Compiled, y: np.ndarray, t: float, h: float, solution: Callable[[], RunResult]) -> None:
    """Raise an IntegrationError that names the force whose own rate [1/s] explains why steps h [s] cannot be longer.

    ``solution()`` returns the result so far.
    """
    rates = [force_rate(compiled, compiled.data(), y, t, k) for k in range(len(compiled.system.forces))]
    k = int(np.argmax(rates)) if rates else 0
    if not rates or rates[k] * h < STIFFNESS_PRODUCT_MIN:
        return
    few = compiled.model.body.size <= IMPLICIT_BODIES_MAX
    implicit = "RadauIIA() or, where forces jump, GeneralizedAlpha()" if few else "GeneralizedAlpha()"
    raise IntegrationError(
        f"the model is stiff (rate {rates[k]:.2g} 1/s): stability, not accuracy, limits the step to {h:.2g} s",
        time=float(t),
        part=f"force '{compiled.system.name(compiled.system.forces[k])}'",
        solution=solution(),
        advice=f"use {implicit}, or DOP853(stiff='run') to go on all the same",
    )


def force_rate(compiled: Compiled, data: Data, y: np.ndarray, t: float, k: int) -> float:
    """Return the largest |eigenvalue| of M x_ddot = K x + D x_dot: element k alone, linearised, its bodies free."""
    model = compiled.forces_alone(slice(k, k + 1))
    bodies = [b for b in element_bodies(model) if 0 <= b < model.body.size]
    if not bodies or (model.body["mass"][bodies] == 0.0).any():
        return 0.0

    def load(moved: np.ndarray) -> np.ndarray:
        load_rows(compiled, data, moved, t)
        loads(model, data, t)
        return data.body["Q"][bodies].ravel()

    blocks = []
    for change in (nudged, partial(hastened, model.body.size)):
        columns = []
        for b in bodies:
            for j in range(6):
                h = STEP * (model.length if j < 3 else 1.0)
                columns.append((load(change(y, b, j, h)) - load(change(y, b, j, -h))) / (2.0 * h))
        blocks.append(np.column_stack(columns))
    M = scipy.linalg.block_diag(*[mass_block(model, y, b) for b in bodies])
    A = np.linalg.solve(M, np.hstack(blocks))
    A = np.vstack([np.eye(A.shape[0], A.shape[1], k=M.shape[0]), A])
    return float(np.abs(np.linalg.eigvals(A)).max()) if np.isfinite(A).all() else 0.0


def element_bodies(model: Model) -> list[int]:
    """Return the bodies of the only force element of a model, the ground included."""
    coordinate = int(model.force["coordinate"][0])
    bodies = model.force["body"][0] if coordinate < 0 else model.coordinate["body"][coordinate]
    return sorted({int(b) for b in bodies})


def mass_block(model: Model, y: np.ndarray, b: int) -> np.ndarray:
    """Return the mass matrix (6, 6) of one body about its reference point."""
    body = model.body[b]
    return inertia_about_origin(y[7 * b + 3 : 7 * b + 7], body["com"], body["mass"], body["inertia"].reshape(3, 3))


def hastened(n: int, y: np.ndarray, b: int, j: int, h: float) -> np.ndarray:
    """Return the state of n bodies with a world component of velocity or angular velocity of body b changed by h."""
    dv, moved, u = np.zeros(6), y.copy(), 7 * n + 6 * b
    dv[j] = h
    moved[u : u + 3] += dv[:3]
    moved[u + 3 : u + 6] += matrix(y[7 * b + 3 : 7 * b + 7]).T @ dv[3:]
    return moved
