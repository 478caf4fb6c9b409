"""Modes of a bicycle followed over the speed: weave, capsize and castering as continuous branches.

From one speed to the next the four modes are paired such that vectors and eigenvalues change least, each used once; a
step is halved until they hardly change. Where a pair of real modes becomes an oscillation no vector tells the two
apart, and the step is as small as it gets.
"""

import numpy as np
from scipy.optimize import linear_sum_assignment

from .equations import Canonical

MODES = ("weave", "capsize", "castering")
NAMES = ("weave", "weave, conjugate", "capsize", "castering")
FINEST = 1e-6
"""[m/s] Smallest step."""
ALIKE = 0.05
"""Largest change of a mode in one step, see `changes`."""


def follow(linear: Canonical, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eigenvalues and vectors by mode, over the speed.

    Parameters
    ----------
    linear : Canonical
    speeds : (n,) ndarray
        [m/s], in any order.

    Returns
    -------
    values : (n, 4) complex ndarray
        [1/s] columns as `NAMES`. The names are given at the fastest speed forward and at the fastest backward: weave
        is the fastest oscillation (without any, the two least stable modes), castering the faster of the two others.
        Where two real modes come out of an oscillation, the slower one goes on in the first column of the two.
    vectors : (n, 4, 4) complex ndarray
        [speed, (lean, steer, rates), mode] of unit length.
    """
    order = np.argsort(-np.abs(speeds), kind="stable")
    values = np.empty((speeds.size, 4), complex)
    vectors = np.empty((speeds.size, 4, 4), complex)
    for side in (order[speeds[order] >= 0.0], order[speeds[order] < 0.0]):
        if not side.size:
            continue
        start = np.linalg.eig(linear.A(speeds[side[0]]))
        here, modes = named(*start)
        at = speeds[side[0]]
        for k in side:
            at, here, modes = walk(linear, at, here, modes, speeds[k])
            values[k], vectors[k] = here, modes
    return values, vectors


def named(values: np.ndarray, vectors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The modes in the order of `NAMES`."""
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
    """(4, 4) how much mode i here differs from mode j there: of the eigenvalue, in units of the largest, and shape."""
    size = np.abs(values).max() or 1.0
    shape = 1.0 - np.abs(modes.conj().T @ vectors) ** 2
    return np.abs(here[:, None] - values) / size + shape


def walk(
    linear: Canonical, start: float, here: np.ndarray, modes: np.ndarray, end: float
) -> tuple[float, np.ndarray, np.ndarray]:
    """Follow the modes from one speed to another."""
    at, step = start, end - start
    while at != end:
        step = np.sign(end - at) * min(abs(step), abs(end - at))
        there = end if abs(end - at) <= abs(step) else at + step
        values, vectors = np.linalg.eig(linear.A(there))
        cost = changes(here, modes, values, vectors)
        pairing = linear_sum_assignment(cost)[1]
        if cost[np.arange(4), pairing].max() > ALIKE and abs(step) > FINEST:
            step /= 2.0
            continue
        pairing = parted(here, values, pairing)
        at, here, modes = there, values[pairing], vectors[:, pairing]
        step *= 2.0
    return at, here, modes


def parted(here: np.ndarray, values: np.ndarray, pairing: np.ndarray) -> np.ndarray:
    """The pairing, with two modes in order that have just met: the slower first, in an oscillation Im > 0 first."""
    there = values[pairing]
    came_apart, came_together = (here.imag != 0.0) & (there.imag == 0.0), (here.imag == 0.0) & (there.imag != 0.0)
    for met, order in ((came_apart, np.abs(there.real)), (came_together, -there.imag)):
        (k,) = np.nonzero(met)
        pairing[k] = pairing[k[np.argsort(order[k], kind="stable")]]
    return pairing
