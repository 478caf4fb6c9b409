"""The linear equations of the Whipple bicycle in closed form, independent of the general model.

    M q'' + v C1 q' + (g K0 + v^2 K2) q = 0,      q = (lean, steer)

Meijaard, Papadopoulos, Ruina and Schwab, Linearized dynamics equations for the balance and steer of a bicycle,
2007, appendix A; checked against the matrices it prints. Symbols and axes (x forward, y right, z down) are the paper's.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from .parameters import Parameters


@dataclass(frozen=True, eq=False)
class Canonical:
    """``M q'' + v C1 q' + (g K0 + v^2 K2) q = f``, q = (lean, steer) [rad], f their torques [N m].

    Attributes
    ----------
    M, C1, K0, K2 : (2, 2) ndarray
        Units kg m^2, kg m, kg m, kg.
    g : float
        [m/s^2]
    """

    M: np.ndarray
    C1: np.ndarray
    K0: np.ndarray
    K2: np.ndarray
    g: float

    def A(self, speed: float | np.ndarray) -> np.ndarray:
        """(..., 4, 4) of ``x' = A x``, x = (lean, steer, lean rate, steer rate), at speeds (...) [m/s]."""
        v = np.asarray(speed, float)[..., None, None]
        A = np.zeros((*v.shape[:-2], 4, 4))
        A[..., :2, 2:] = np.eye(2)
        A[..., 2:, :2] = -np.linalg.solve(self.M, self.g * self.K0 + v**2 * self.K2)
        A[..., 2:, 2:] = -np.linalg.solve(self.M, v * self.C1)
        return A

    def eigenvalues(self, speeds: np.ndarray) -> np.ndarray:
        """(n, 4) eigenvalues [1/s] at n speeds [m/s], each row by real part, conjugates together."""
        return np.sort_complex(np.linalg.eigvals(self.A(checked_speeds(speeds))))


def checked_speeds(speeds: np.ndarray) -> np.ndarray:
    """(n,) finite speeds, or a ValueError."""
    try:
        found = np.atleast_1d(np.asarray(speeds, dtype=float))
    except (TypeError, ValueError):
        raise ValueError(f"speeds: {speeds!r} are no numbers; give speeds in m/s") from None
    if found.ndim != 1 or not found.size or not np.isfinite(found).all():
        raise ValueError("speeds: give one or more finite speeds in m/s")
    return found


def canonical(p: Parameters) -> Canonical:
    """The matrices of a bicycle with knife-edge wheels.

    Parameters
    ----------
    p : Parameters

    Returns
    -------
    Canonical

    Raises
    ------
    ValueError
        If the tyres are round: these equations have no crown radius.

    Examples
    --------
    >>> from bicycle import Meijaard2007
    >>> canonical(Meijaard2007()).M.round(5)
    array([[80.81722,  2.31941],
           [ 2.31941,  0.29784]])
    """
    if p.tR or p.tF:
        raise ValueError(
            f"bicycle '{p.name}': the closed form is that of knife-edge wheels, here tR = {p.tR}, tF = {p.tF}; "
            "use the general model, or set both to zero"
        )
    # the whole bicycle (T) about the rear contact
    mx = p.mB * p.xB + p.mH * p.xH + p.mF * p.w
    mz = -p.mR * p.rR + p.mB * p.zB + p.mH * p.zH - p.mF * p.rF
    ITxx = p.IRxx + p.IBxx + p.IHxx + p.IFxx + p.mR * p.rR**2 + p.mB * p.zB**2 + p.mH * p.zH**2 + p.mF * p.rF**2
    ITxz = p.IBxz + p.IHxz - p.mB * p.xB * p.zB - p.mH * p.xH * p.zH + p.mF * p.w * p.rF
    ITzz = p.IRxx + p.IBzz + p.IHzz + p.IFxx + p.mB * p.xB**2 + p.mH * p.xH**2 + p.mF * p.w**2
    # the front assembly (A) about its centre of mass
    mA = p.mH + p.mF
    xA, zA = (p.xH * p.mH + p.w * p.mF) / mA, (p.zH * p.mH - p.rF * p.mF) / mA
    IAxx = p.IHxx + p.IFxx + p.mH * (p.zH - zA) ** 2 + p.mF * (p.rF + zA) ** 2
    IAxz = p.IHxz - p.mH * (p.xH - xA) * (p.zH - zA) + p.mF * (p.w - xA) * (p.rF + zA)
    IAzz = p.IHzz + p.IFxx + p.mH * (p.xH - xA) ** 2 + p.mF * (p.w - xA) ** 2
    # about the steer axis, from which it lies uA ahead
    sin, cos = np.sin(p.lam), np.cos(p.lam)
    uA = (xA - p.w - p.c) * cos - zA * sin
    IAll = mA * uA**2 + IAxx * sin**2 + 2.0 * IAxz * sin * cos + IAzz * cos**2
    IAlx = -mA * uA * zA + IAxx * sin + IAxz * cos
    IAlz = mA * uA * xA + IAxz * sin + IAzz * cos
    mu = p.c * cos / p.w  # ratio of trails
    SR, SF = p.IRyy / p.rR, p.IFyy / p.rF  # spin momentum over speed
    ST, SA = SR + SF, mA * uA + mu * mx
    M = [[ITxx, IAlx + mu * ITxz], [IAlx + mu * ITxz, IAll + 2.0 * mu * IAlz + mu**2 * ITzz]]
    K0 = [[mz, -SA], [-SA, -SA * sin]]
    K2 = [[0.0, (ST - mz) / p.w * cos], [0.0, (SA + SF * sin) / p.w * cos]]
    C1 = [
        [0.0, mu * ST + SF * cos + ITxz / p.w * cos - mu * mz],
        [-(mu * ST + SF * cos), IAlz / p.w * cos + mu * (SA + ITzz / p.w * cos)],
    ]
    return Canonical(matrix(M), matrix(C1), matrix(K0), matrix(K2), p.g)


def matrix(rows: list[list[Any]]) -> np.ndarray:
    """(..., 2, 2) of entries that may be arrays (...), for many bicycles at once."""
    entries = np.broadcast_arrays(*rows[0], *rows[1])
    return np.stack(entries, axis=-1).reshape(*entries[0].shape, 2, 2)
