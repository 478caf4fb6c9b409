"""Torque-roll axis of a powertrain, and mounts that let it roll about this axis alone.

A torque about the crank turns a free body about ``I^-1 x`` through its centre of mass, not about the crank. Held by
mounts of stiffness K it goes on doing so at all speeds if that motion t = (0, I^-1 x) is a mode,

    K t = lam M t,    lam = t'K t / t'M t,

and what is left of ``K t - lam M t``, over lam M t in the metric of M^-1, is the coupling: 0 for a decoupled one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from engines.nvh.mounts.mounts import Mount
from engines.nvh.mounts.rigid_modes import mass_matrix, rigid_modes
from mbsd3d import Body
from mbsd3d.errors import InputError
from mbsd3d.extend import number, skew

REGULARISATION_WEIGHT = 0.02  # [1] of changes of the mounts, against the coupling
SEARCH_STEPS_MAX = 60  # [1] of the last search: 4 to 7 where the coupling can vanish, all where mounts are limited


def stiffness_matrix(body: Body, placed: Sequence[Mount]) -> np.ndarray:
    """Return the stiffness of all mounts about the centre of mass, ``sum T_j' k_j T_j``, shape (6, 6)."""
    K = np.zeros((6, 6))
    for mount in placed:
        T = np.hstack([np.eye(3), -skew(np.array(mount.at) - body.com)])
        K += T.T @ mount.stiffness @ T
    return K


def roll_axis(body: Body) -> np.ndarray:
    """Return the unit vector of the torque-roll axis through the centre of mass, shape (3,)."""
    axis = np.linalg.solve(body.inertia, (1.0, 0.0, 0.0))
    return axis / np.linalg.norm(axis)


def left_over(body: Body, placed: Sequence[Mount]) -> np.ndarray:
    """Return M^(-1/2) (K t - lam M t) over the size of lam M^(1/2) t, whose length is the coupling, shape (6,)."""
    M, K = mass_matrix(body), stiffness_matrix(body, placed)
    t = np.concatenate([np.zeros(3), roll_axis(body)])
    lam = (t @ K @ t) / (t @ M @ t)
    root = np.linalg.cholesky(M)
    return np.linalg.solve(root, K @ t - lam * (M @ t)) / (lam * np.linalg.norm(root.T @ t))


def coupling(body: Body, placed: Sequence[Mount]) -> float:
    """Return the coupling [-]: 0 for a powertrain that rolls about its torque-roll axis alone."""
    return float(np.linalg.norm(left_over(body, placed)))


def roll_share(body: Body, placed: Sequence[Mount]) -> tuple[float, float]:
    """Return (share of kinetic energy, frequency [Hz]) of the mode closest to a roll about the torque-roll axis."""
    M, t = mass_matrix(body), np.concatenate([np.zeros(3), roll_axis(body)])
    found = []
    for mode in rigid_modes(body, placed):
        s = mode.shape
        found.append(((t @ M @ s) ** 2 / ((t @ M @ t) * (s @ M @ s)), mode.frequency))
    return max(found)


@dataclass(frozen=True)
class Decoupled:
    """Result of the search: ``mounts``; ``before, after``: coupling; ``moved``: largest shift of a mount [m];
    ``rates``: largest factor between old and new rate.
    """

    mounts: list[Mount]
    before: float
    after: float
    moved: float
    rates: float


def decouple(body: Body, placed: Sequence[Mount], *, reach: float = 0.15, factor: float = 2.0) -> Decoupled:
    """Move mounts by up to ``reach`` [m] along each axis and change rates by up to ``factor`` until the roll is free.

    Least squares on the coupling, with the total rates held and everything else changed as little as possible.
    ValueError for a reach or factor that leaves nothing to change.
    """
    reach = number(reach, "decouple: reach", positive=True)
    if not number(factor, "decouple: factor") > 1.0:
        raise InputError(f"decouple: factor {factor:g} leaves the rates as they are; give one above 1")
    total, n = sum(mount.stiffness[2, 2] for mount in placed), len(placed)

    def changed(x: np.ndarray) -> list[Mount]:
        shifts, scales = reach * x[: 3 * n].reshape(n, 3), factor ** x[3 * n :].reshape(n, 3)
        return [
            replace(
                mount, at=tuple(np.array(mount.at) + d), rates=tuple(np.array(mount.rates) * s),
                damping=tuple(np.array(mount.damping) * s),
            )
            for mount, d, s in zip(placed, shifts, scales, strict=True)
        ]  # fmt: skip

    def errors(x: np.ndarray) -> np.ndarray:
        moved = changed(x)
        load = sum(mount.stiffness[2, 2] for mount in moved) / total - 1.0
        return np.concatenate([left_over(body, moved), [load], REGULARISATION_WEIGHT * x])

    search = least_squares(errors, np.zeros(6 * n), bounds=(-1.0, 1.0))
    # seven conditions for all the mounts: of the steps that meet them lsmr takes the shortest
    final = least_squares(
        lambda x: errors(x)[:7], search.x, bounds=(-1.0, 1.0), xtol=1e-15, ftol=1e-15, gtol=1e-15, tr_solver="lsmr",
        max_nfev=SEARCH_STEPS_MAX,
    )  # fmt: skip
    moved = changed(final.x)
    return Decoupled(
        moved, coupling(body, placed), coupling(body, moved), float(reach * np.abs(final.x[: 3 * n]).max()),
        float(factor ** np.abs(final.x[3 * n :]).max()),
    )  # fmt: skip
