"""Shell of a car as a uniform thin plate with free edges, by Ritz with Legendre polynomials.

    w = sum a_ij P_i(2 x / L) P_j(2 y / B),
    strain energy  D/2 int w_xx^2 + w_yy^2 + 2 nu w_xx w_yy + 2 (1 - nu) w_xy^2

The polynomials meet the free edges in the limit; with 12 each way the first ten frequencies hold seven digits. Surge,
sway and yaw are those of a rigid body. A place above the plate moves with its normal.
"""

import numpy as np
from numpy.polynomial.legendre import Legendre, leggauss
from scipy.linalg import eigh

from engines.nvh.cabin.shell import ModalShell
from mbsd3d.errors import InputError
from mbsd3d.extend import number

POLYNOMIAL_COUNT, ELASTIC_MODES, RIGID_MODES = 12, 12, 3  # polynomials each way; elastic modes; heave, roll, pitch
POISSON_RATIO = 0.3  # [1] of steel


def plate_modes(length: float, width: float, poisson: float = POISSON_RATIO) -> tuple[np.ndarray, np.ndarray]:
    """Return w sqrt(m / D) of all modes [1/m^2], m per area, and (modes, i, j) coefficients with mean square 1 over the
    plate.

    ValueError for a size that is not positive, or a Poisson's ratio outside 0 ... 0.5.
    """
    sx, sy = (2 / number(x, f"plate: {name}", positive=True) for name, x in (("length", length), ("width", width)))
    if number(poisson, "plate: poisson", minimum=0.0) > 0.5:
        raise InputError(f"plate: poisson {poisson:g} is above 0.5; give a smaller one")
    s, weight = leggauss(POLYNOMIAL_COUNT)
    base = [Legendre.basis(i) for i in range(POLYNOMIAL_COUNT)]
    P, P1, P2 = (np.array([p.deriv(k)(s) for p in base]) for k in range(3))
    A, B, C, E = ((left * weight) @ right.T for left, right in ((P, P), (P1, P1), (P2, P2), (P2, P)))
    bent = sx**4 * np.kron(C, A) + sy**4 * np.kron(A, C)
    crossed = sx**2 * sy**2 * (poisson * (np.kron(E, E.T) + np.kron(E.T, E)) + 2 * (1 - poisson) * np.kron(B, B))
    squares, found = eigh(bent + crossed, np.kron(A, A) / 4)
    squares[:RIGID_MODES] = 0.0
    return np.sqrt(squares / 4), found.T.reshape(-1, POLYNOMIAL_COUNT, POLYNOMIAL_COUNT)


def plate_shell(
    mass: float, length: float, width: float, first: float, damping: float, poisson: float = POISSON_RATIO
) -> ModalShell:
    """Return the modes of a uniform plate: ``mass`` [kg], ``length`` along x, ``width`` along y [m], its ``first``
    elastic frequency [Hz], ``damping`` of all elastic modes [-].

    ValueError for a number that is not positive, a negative damping, or a place beyond the edges.
    """
    number(mass, "plate: mass", positive=True)
    number(first, "plate: first", positive=True)
    numbers, parts = plate_modes(length, width, poisson)
    rates = 2 * np.pi * first * numbers[: RIGID_MODES + ELASTIC_MODES] / numbers[RIGID_MODES]
    size = np.array([length, width]) / 2

    def bent(at: np.ndarray, part: np.ndarray) -> np.ndarray:
        x, y = (at[:, :2] / size).T
        if max(np.abs(x).max(), np.abs(y).max()) > 1.0:
            raise InputError(f"plate: {length:g} m long and {width:g} m wide, a place lies beyond; give a larger one")
        P = [np.array([Legendre.basis(i).deriv(k)(s) for i in range(POLYNOMIAL_COUNT)]) for s in (x, y) for k in (0, 1)]
        w, along, across = (
            np.einsum("ij,ip,jp->p", part, *pair) for pair in ((P[0], P[2]), (P[1], P[2]), (P[0], P[3]))
        )
        return np.stack([-at[:, 2] * along / size[0], -at[:, 2] * across / size[1], w], axis=1) / np.sqrt(mass)

    turning = mass * (length**2 + width**2) / 12
    flat = [
        lambda at: np.tile([1 / np.sqrt(mass), 0, 0], (len(at), 1)),
        lambda at: np.tile([0, 1 / np.sqrt(mass), 0], (len(at), 1)),
        lambda at: np.stack([-at[:, 1], at[:, 0], 0 * at[:, 0]], axis=1) / np.sqrt(turning),
    ]
    shapes = [lambda at, part=part: bent(at, part) for part in parts[: RIGID_MODES + ELASTIC_MODES]]
    rates = np.concatenate([np.zeros(len(flat)), rates])
    return ModalShell(rates, np.where(rates > 0, damping, 0.0), [*flat, *shapes])
