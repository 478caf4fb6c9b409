"""Thin rectangular plate with free edges, by Ritz with products of the modes of free beams.

36 products, as the published tables have them: upper bounds of the frequencies, up to 1 % above.
"""

import numpy as np

from engines.closed_forms.free_beam import bending_roots, bending_shape

BEAM_FUNCTIONS, QUADRATURE_POINTS = 6, 4001  # beam functions each way, rigid ones among them; of the trapezoidal rule


def free_plate(ratio: float, poisson: float, count: int) -> np.ndarray:
    """Return the lowest elastic ``w a^2 sqrt(rho h / D)`` of a plate with sides a and a / ratio, shape (count,).

    ``int w_ss^2 + r^4 w_tt^2 + 2 nu r^2 w_ss w_tt + 2 (1 - nu) r^2 w_st^2`` over ``int w^2``, s = x / a, t = r y / a.
    """
    s = np.linspace(0.0, 1.0, QUADRATURE_POINTS)
    roots = bending_roots(BEAM_FUNCTIONS - 2)
    base = np.array([np.ones_like(s), np.sqrt(12) * (s - 0.5), *(bending_shape(x, s) for x in roots)])
    first = np.gradient(base, s, axis=1, edge_order=2)
    second = np.array([0 * s, 0 * s, *(np.gradient(x, s, edge_order=2) for x in first[2:])])
    w = np.full(QUADRATURE_POINTS, s[1])
    w[[0, -1]] /= 2
    one, slope, bend, mixed = (
        (a * w) @ b.T for a, b in ((base, base), (first, first), (second, second), (second, base))
    )
    r2 = ratio**2
    V = np.kron(bend, one) + r2**2 * np.kron(one, bend) + 2 * (1 - poisson) * r2 * np.kron(slope, slope)
    V += poisson * r2 * (np.kron(mixed, mixed.T) + np.kron(mixed.T, mixed))
    squares = np.linalg.eigvals(np.linalg.solve(np.kron(one, one), V)).real
    return np.sqrt(np.sort(squares)[3 : 3 + count])
