"""Linear equations of the Whipple bicycle in closed form, independent of the general model, and their modes.

    M q'' + v C1 q' + (g K0 + v^2 K2) q = 0,      q = (lean, steer)

Meijaard, Papadopoulos, Ruina and Schwab, Linearized dynamics equations for the balance and steer of a bicycle,
2007, appendix A; checked against the matrices it prints. Symbols and axes (x forward, y right, z down) are the paper's.

Modes are followed over the speed as continuous branches: from one speed to the next the four modes are paired such that
vectors and eigenvalues change least; a step is halved until they hardly change. Where a pair of real modes becomes an
oscillation no vector tells the two apart, and the step is as small as it gets.
"""

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from mbsd3d.errors import InputError
from mbsd3d.extend import Result

from ..parameters import Parameters, check_set

MODES = ("weave", "capsize", "castering")
NAMES = ("weave", "weave, conjugate", "capsize", "castering")
BRANCH_STEP_MIN = 1e-6  # [m/s] smallest step of a branch
MODE_CHANGE_MAX = 0.05  # [1] largest change of a mode in one step, see `changes`


@dataclass(frozen=True, eq=False, repr=False)
class Canonical(Result):
    """Linear equations ``M q'' + v C1 q' + (g K0 + v^2 K2) q = f``, q = (lean, steer) [rad], f their torques [N m]."""

    M: np.ndarray  # (2, 2) [kg m^2]
    C1: np.ndarray  # [kg m]
    K0: np.ndarray  # [kg m]
    K2: np.ndarray  # [kg]
    g: float  # [m/s^2]

    def A(self, speed: float | np.ndarray) -> np.ndarray:
        """Return A of ``x' = A x``, x = (lean, steer, lean rate, steer rate), at speeds (...) [m/s], shape (..., 4,
        4)."""
        v = np.asarray(speed, float)[..., None, None]
        A = np.zeros((*v.shape[:-2], 4, 4))
        A[..., :2, 2:] = np.eye(2)
        A[..., 2:, :2] = -np.linalg.solve(self.M, self.g * self.K0 + v**2 * self.K2)
        A[..., 2:, 2:] = -np.linalg.solve(self.M, v * self.C1)
        return A

    def dynamic_stiffness(self, speed: float, frequencies: np.ndarray) -> np.ndarray:
        """Return the torques per lean and steer that oscillate at n frequencies [rad/s], shape (n, 2, 2) [N m/rad]."""
        s = 1j * frequencies[:, None, None]
        return s**2 * self.M + s * speed * self.C1 + self.g * self.K0 + speed**2 * self.K2

    def eigenvalues(self, speeds: ArrayLike) -> np.ndarray:
        """Return the eigenvalues [1/s] at n speeds [m/s], each row by real part, conjugates together, shape (n, 4)."""
        return np.sort_complex(np.linalg.eigvals(self.A(checked_speeds(speeds))))

    def __str__(self) -> str:
        units = {"M": "kg m^2", "C1": "kg m", "K0": "kg m", "K2": "kg"}
        lines = [f"M q'' + v C1 q' + (g K0 + v^2 K2) q = f, q = (lean, steer), g = {self.g} m/s^2"]
        for name, unit in units.items():
            first, *rest = np.array_str(getattr(self, name), precision=6, suppress_small=True).splitlines()
            lines += [f"{name:2} [{unit:6}]  {first}", *(f"{'':12}{line}" for line in rest)]
        return "\n".join(lines)


def checked_list(values: ArrayLike, what: str, remedy: str) -> np.ndarray:
    """Return finite numbers (n,), n > 0; raise ValueError for others."""
    try:
        found = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError):
        found = np.zeros(0)
    if found.ndim != 1 or not found.size or not np.isfinite(found).all():
        raise InputError(f"{what}: {values!r:.80}; give {remedy}")
    return found


def checked_speeds(speeds: ArrayLike) -> np.ndarray:
    """Return finite speeds (n,); raise ValueError for others."""
    return checked_list(speeds, "speeds", "one or more finite speeds in m/s")


def canonical(p: Parameters | SimpleNamespace) -> Canonical:
    """Return the matrices of a bicycle with knife-edge wheels; raise ValueError for round tyres.

    Examples
    --------
    >>> from bicycle import Meijaard2007, equations
    >>> equations.canonical(Meijaard2007()).M.round(5)
    array([[80.81722,  2.31941],
           [ 2.31941,  0.29784]])
    """
    check_set(p, "bicycle")
    if p.tR or p.tF:
        raise InputError(
            f"bicycle '{p.name}': the closed form holds for knife-edge wheels, here tR = {p.tR}, tF = {p.tF}; "
            "use the general model, or set both to zero"
        )
    # the whole bicycle (T) about the rear contact
    mx = p.mB * p.xB + p.mH * p.xH + p.mF * p.w
    mz = -p.mR * p.rR + p.mB * p.zB + p.mH * p.zH - p.mF * p.rF
    ITxx = p.IRxx + p.IBxx + p.IHxx + p.IFxx + p.mR * p.rR**2 + p.mB * p.zB**2 + p.mH * p.zH**2 + p.mF * p.rF**2
    ITxz = p.IBxz + p.IHxz - p.mB * p.xB * p.zB - p.mH * p.xH * p.zH + p.mF * p.w * p.rF
    ITzz = p.IRxx + p.IBzz + p.IHzz + p.IFxx + p.mB * p.xB**2 + p.mH * p.xH**2 + p.mF * p.w**2
    # the front assembly (A) about the steer axis, from which its two centres of mass lie u ahead
    sin, cos = np.sin(p.lam), np.cos(p.lam)
    mAuA = IAll = IAlx = IAlz = 0.0
    for m, x, z, Ixx, Ixz, Izz in (
        (p.mH, p.xH, p.zH, p.IHxx, p.IHxz, p.IHzz), (p.mF, p.w, -p.rF, p.IFxx, 0.0, p.IFxx)
    ):  # fmt: skip
        u = (x - p.w - p.c) * cos - z * sin
        mAuA = mAuA + m * u
        IAll = IAll + m * u**2 + Ixx * sin**2 + 2.0 * Ixz * sin * cos + Izz * cos**2
        IAlx = IAlx - m * u * z + Ixx * sin + Ixz * cos
        IAlz = IAlz + m * u * x + Ixz * sin + Izz * cos
    mu = p.c * cos / p.w  # ratio of trails
    SR, SF = p.IRyy / p.rR, p.IFyy / p.rF  # spin momentum over speed
    ST, SA = SR + SF, mAuA + mu * mx
    M = [[ITxx, IAlx + mu * ITxz], [IAlx + mu * ITxz, IAll + 2.0 * mu * IAlz + mu**2 * ITzz]]
    K0 = [[mz, -SA], [-SA, -SA * sin]]
    K2 = [[0.0, (ST - mz) / p.w * cos], [0.0, (SA + SF * sin) / p.w * cos]]
    C1 = [
        [0.0, mu * ST + SF * cos + ITxz / p.w * cos - mu * mz],
        [-(mu * ST + SF * cos), IAlz / p.w * cos + mu * (SA + ITzz / p.w * cos)],
    ]
    return Canonical(matrix(M), matrix(C1), matrix(K0), matrix(K2), p.g)


def matrix(rows: list[list[ArrayLike]]) -> np.ndarray:
    """Return a matrix (..., 2, 2) of entries that may be arrays (...), for many bicycles at once."""
    entries = np.broadcast_arrays(*rows[0], *rows[1])
    return np.stack(entries, axis=-1).reshape(*entries[0].shape, 2, 2)


def follow(linear: Canonical, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return eigenvalues and vectors by mode, over speeds (n,) [m/s] in any order.

    Returns
    -------
    values : (n, 4) complex ndarray
        [1/s] Columns as `NAMES`. The names are given at the fastest speed forward and at the fastest backward: weave
        is the fastest oscillation (without any, the two least stable modes), castering the faster of the two others.
        Where an oscillation splits into two real modes, the slower one continues in the first of the two columns.
    vectors : (n, 4, 4) complex ndarray
        [speed, (lean, steer, rates), mode] of unit length.
    """
    order = np.argsort(-np.abs(speeds), kind="stable")
    values = np.empty((speeds.size, 4), complex)
    vectors = np.empty((speeds.size, 4, 4), complex)
    for side in (order[speeds[order] >= 0.0], order[speeds[order] < 0.0]):
        if not side.size:
            continue
        at = speeds[side[0]]
        here, modes = ordered(*np.linalg.eig(linear.A(at)))
        for k in side:
            here, modes = walk(linear.A, at, here, modes, speeds[k])
            at, values[k], vectors[k] = speeds[k], here, modes
    return values, vectors


def ordered(values: np.ndarray, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the modes in the order of `NAMES`."""
    pairs = [k for k in np.argsort(-values.imag) if values[k].imag > 0.0]
    if pairs:
        weave = pairs[0]
        conjugate = int(np.argmin(np.abs(values - values[weave].conj())))
    else:
        weave, conjugate = np.argsort(-values.real)[:2]
    rest = sorted(set(range(4)) - {weave, conjugate}, key=lambda k: (abs(values[k].real), -values[k].imag))
    order = [weave, conjugate, *rest]
    return values[order], vectors[:, order]


def changes(here: np.ndarray, modes: np.ndarray, values: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Return the difference of mode i here from mode j there: of eigenvalues, in units of the largest, and of shapes,
    shape (k, k).
    """
    size = np.abs(values).max() or 1.0
    shape = 1.0 - np.abs(modes.conj().T @ vectors) ** 2
    return np.abs(here[:, None] - values) / size + shape


def walk(
    A: Callable[[float], np.ndarray], at: float, here: np.ndarray, modes: np.ndarray, end: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return eigenvalues and vectors of the k modes of A(v) (k, k), followed from the speed ``at`` to another."""
    step = end - at
    while at != end:
        step = np.sign(end - at) * min(abs(step), abs(end - at))
        there = end if abs(end - at) <= abs(step) else at + step
        values, vectors = np.linalg.eig(A(there))
        cost = changes(here, modes, values, vectors)
        pairing = linear_sum_assignment(cost)[1]
        if cost[np.arange(len(here)), pairing].max() > MODE_CHANGE_MAX and abs(step) > BRANCH_STEP_MIN:
            step /= 2.0
            continue
        pairing = parted(here, values, pairing)
        at, here, modes = there, values[pairing], vectors[:, pairing]
        step *= 2.0
    return here, modes


def parted(here: np.ndarray, values: np.ndarray, pairing: np.ndarray) -> np.ndarray:
    """Return the pairing with two modes in order that have just met: the slower first, in an oscillation Im > 0
    first."""
    there = values[pairing]
    came_apart, came_together = (here.imag != 0.0) & (there.imag == 0.0), (here.imag == 0.0) & (there.imag != 0.0)
    for met, order in ((came_apart, np.abs(there.real)), (came_together, -there.imag)):
        (k,) = np.nonzero(met)
        pairing[k] = pairing[k[np.argsort(order[k], kind="stable")]]
    return pairing
