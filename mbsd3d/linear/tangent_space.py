"""The deviations that the constraints allow: X = E x, with states x that are entries of X themselves.

configuration   C delta q = 0                      C: holonomic rows
velocity        D_v delta v + D_q delta q = 0      D: variation of J v - b, all rows
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg

from ..equations.at_state import worst_joint
from ..equations.compiled import Compiled
from ..equations.jacobian import RANK_TOLERANCE, displacement_units
from ..kernels.layout import Model
from ..mechanism.mechanism import Mechanism
from .variations import Variations

COMPONENTS = ("x", "y", "z", "theta_x", "theta_y", "theta_z", "v_x", "v_y", "v_z", "w_x", "w_y", "w_z")
UNITS = ("m", "rad", "m/s", "rad/s")


@dataclass(frozen=True, eq=False)
class Tangent:
    """X = E x; x are the entries ``chosen`` of X: configuration, velocity and own states."""

    E: np.ndarray  # (N, n_x)
    chosen: np.ndarray  # (n_x,)
    configuration: int
    velocity: int

    def names(self, system: Mechanism) -> tuple[str, ...]:
        """One name per state."""
        n, found = 6 * len(system.bodies), []
        for j in self.chosen:
            part = system.name(system.bodies[j % n // 6]) if j < 2 * n else None
            found.append(f"{COMPONENTS[j % 6 + 6 * (j // n)]} of {part}" if part else f"z{j - 2 * n}")
        return tuple(found)

    def unit_names(self, model: Model) -> tuple[str, ...]:
        """One unit per state; own states of force elements have the element's unit."""
        n = 6 * model.body.size
        return tuple(UNITS[j % 6 // 3 + 2 * (j // n)] if j < 2 * n else "-" for j in self.chosen)


def free_basis(A: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(basis N of the null space of A with the unit matrix in the rows ``chosen``, these rows)."""
    _, s, Vt = scipy.linalg.svd(A)
    rank = int((s > RANK_TOLERANCE * s[0]).sum()) if s.size and s[0] > 0.0 else 0
    Z = Vt[rank:].T
    _, _, pivot = scipy.linalg.qr(Z.T, mode="economic", pivoting=True)
    chosen = np.sort(pivot[: Z.shape[1]])
    return np.linalg.solve(Z[chosen].T, Z.T).T, chosen


def tangent_space(compiled: Compiled, at: Variations) -> Tangent:
    """E at a state.

    Raises
    ------
    ValueError
        If a row that is redundant here is not so for neighbouring states: a singular position.
    """
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
    """All rows, also the redundant ones, admit velocities at the neighbouring configurations."""
    miss = np.abs(left).max(axis=1, initial=0.0)
    if miss.max(initial=0.0) > 1e-7 * max(size, 1e-300):  # rows of a regular position agree to rounding
        part, residual = worst_joint(compiled, miss / compiled.model.row["scale"])
        raise ValueError(
            f"linearize: singular position: at neighbouring positions no velocities meet {part} (residual "
            f"{residual:.2g}); move away from the dead centre"
        )
