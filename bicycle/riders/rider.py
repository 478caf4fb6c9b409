"""Rider who closes five loops, one around the other: steer angle, roll rate, roll, heading, lateral deviation.

    U = k_delta (k_phidot (k_phi (k_psi (k_y (y_c - y) - psi) - phi) - phi_dot) - delta)
    T'' = 900 (U - T) - 42.42 T'          steer torque: arms and muscles of second order, 30 rad/s, damping 0.707

The model and its rule for gains are those of R. A. Hess, J. K. Moore and M. Hubbard (2012). psi and y, the heading and
the lateral deviation of the front contact, are positive to the right, as lean phi and steer delta are.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from mbsd3d.errors import InputError
from mbsd3d.extend import checks_arguments, number

from ..linear.equations import canonical
from ..parameters import Parameters, check_set

STATES = ("lean", "steer", "lean rate", "steer rate", "heading", "deviation", "torque", "torque rate")
LOOPS = ("steer angle", "roll rate", "roll", "heading", "lateral deviation")
LOOP_STATES = (1, 2, 0, 4, 5)  # the state each loop compares with its command
CROSSOVER_FREQUENCIES = (2.0, 1.0, 0.5)  # [rad/s] of the loops of roll, heading and lateral deviation
MUSCLES = (900.0, 42.42)
RESONANCE_PEAK = 10.0  # [dB] of the two inner loops above what they transmit at `REFERENCE_FREQUENCIES`
REFERENCE_FREQUENCIES = (1.0, 3.0)  # [rad/s] of the two inner loops
GAIN_BRACKETS = (1e-2, 1e4), (-1e-5, -1.0)  # [1] in which the gains of the inner loops are sought
SPEEDS = np.linspace(1.0, 15.0, 29)  # [m/s] at which the rule is tried for who asks where it works
FREQUENCIES = np.geomspace(3.0, 60.0, 400)  # [rad/s] where the peaks are


class Gains(NamedTuple):
    """Gains of the five loops, from the inside out."""

    steer: float  # [N m/rad]
    roll_rate: float  # [s]
    roll: float  # [1/s]
    heading: float
    deviation: float  # [rad/m]


def checked_gains(gains: Sequence[float]) -> Gains:
    """Return five finite gains; raise ValueError for others."""
    if np.shape(gains) != (len(LOOPS),):
        raise InputError(f"rider: gains = {gains!r:.80}; give five: of the loops of {', '.join(LOOPS)}")
    return Gains(*(number(k, f"rider: gain of the {name} loop") for k, name in zip(gains, LOOPS, strict=True)))


class Loop(NamedTuple):
    """Closed loop x' = A x + B command, x = `STATES`."""

    A: np.ndarray  # (8, 8)
    B: np.ndarray  # (8,)

    def response(self, frequency: np.ndarray | float) -> np.ndarray:
        """Return the complex response x/command at frequencies [rad/s], shape (n, 8)."""
        s = 1j * np.atleast_1d(frequency)[:, None, None]
        return np.linalg.solve(s * np.eye(len(STATES)) - self.A, self.B[:, None])[..., 0]


def open_loop(parameters: Parameters, speed: float) -> Loop:
    """Return the transfer from the rider's command U to the states at a speed [m/s], on ideal wheels."""
    check_set(parameters, "rider")
    v, k = number(speed, "rider: speed", positive=True), np.cos(parameters.lam) / parameters.w
    linear = canonical(parameters)
    A = np.zeros((8, 8))
    A[:4, :4] = linear.A(v)
    A[2:4, 6] = np.linalg.solve(linear.M, (0.0, 1.0))
    A[4, 1], A[4, 3] = v * k, parameters.c * k
    A[5, 4] = v  # of the rear contact, and the wheelbase ahead of it the front contact less its trail
    A[5] += parameters.w * A[4]
    A[5, 3] -= parameters.c * np.cos(parameters.lam)
    A[6, 7] = 1.0
    A[7, 6:] = -MUSCLES[0], -MUSCLES[1]
    B = np.zeros(8)
    B[7] = MUSCLES[0]
    return Loop(A, B)


def closed_loops(parameters: Parameters, speed: float, gains: Gains, count: int = 5) -> Loop:
    """Return the transfer from the command of the outermost of ``count`` closed loops to the states; no loop is
    `open_loop`.
    """
    A, B = open_loop(parameters, speed)
    for k, seen in zip(checked_gains(gains)[:count], LOOP_STATES, strict=False):
        B = B * k
        A[:, seen] -= B
    return Loop(A, B)


def eigenvalues(parameters: Parameters, speed: float, gains: Gains, count: int = 5) -> np.ndarray:
    """Return the complex eigenvalues [1/s] of bicycle and rider with ``count`` closed loops, two zero until heading and
    path are controlled, shape (8,).
    """
    return np.sort_complex(np.linalg.eigvals(closed_loops(parameters, speed, gains, count).A))


@checks_arguments
def gains_of(
    parameters: Parameters, speed: float, *, steer: float | None = None, roll_rate: float | None = None
) -> Gains:  # fmt: skip
    """Return gains by rule: 10 dB of peak in the inner loops, crossovers of the outer ones at 2, 1 and 0.5 rad/s.

    Parameters
    ----------
    speed : float
        [m/s]
    steer, roll_rate : float or None
        Gains of the inner loops; None = such that |delta/delta_c| and |phi_dot/phi_dot_c| peak 10 dB above their
        values at 1 and 3 rad/s.

    Raises
    ------
    ValueError
        If no gain makes such a peak: bicycles whose weave is hardly damped, most of them without a rider, peak more by
        themselves. The text says at which speeds the rule works.

    Examples
    --------
    >>> from bicycle import Meijaard2007, rider
    >>> found = rider.gains_of(Meijaard2007(), 5.0, steer=46.5457, roll_rate=-0.0522)
    >>> [round(k, 4) for k in found[2:]]
    [12.6635, 0.1849, 0.0959]
    """
    found: list[float] = []
    for count, given in enumerate((steer, roll_rate)):
        found.append(peaked(parameters, speed, found) if given is None else number(given, f"rider: {LOOPS[count]}"))
    for frequency in CROSSOVER_FREQUENCIES:
        plant = closed_loops(parameters, speed, Gains(*found, *[0.0] * (5 - len(found))), len(found))
        found.append(float(1.0 / np.abs(plant.response(frequency)[0, LOOP_STATES[len(found)]])))
    return Gains(*found)


class Tried(NamedTuple):
    """Gains of an inner loop and their peaks; ``gain`` is that of the rule, NaN if none makes its peak."""

    gain: float
    gains: np.ndarray
    peaks: np.ndarray  # [dB] above what the closed loop lets pass at `REFERENCE_FREQUENCIES`


def tried(parameters: Parameters, speed: float, inner: list[float]) -> Tried:
    """Return the largest gain k of the next loop with which k G/(1 + k G) does not exceed the rule's peak."""
    count = len(inner)
    plant = closed_loops(parameters, speed, Gains(*inner, *[0.0] * (5 - count)), count)
    G = plant.response(np.append(FREQUENCIES, REFERENCE_FREQUENCIES[count]))[:, LOOP_STATES[count]]

    def height(gain: float) -> float:
        closed = np.abs(gain * G / (1.0 + gain * G))
        return float(20.0 * np.log10(closed[:-1].max() / closed[-1]))

    gains = np.geomspace(*GAIN_BRACKETS[count], 120)
    peaks = np.array([height(gain) for gain in gains])
    crossed = np.flatnonzero((peaks[:-1] < RESONANCE_PEAK) & (peaks[1:] >= RESONANCE_PEAK))
    if not crossed.size:
        return Tried(np.nan, gains, peaks)
    ends = gains[crossed[-1] : crossed[-1] + 2]
    return Tried(float(brentq(lambda gain: height(gain) - RESONANCE_PEAK, *ends, xtol=1e-14)), gains, peaks)


def peaked(parameters: Parameters, speed: float, inner: list[float]) -> float:
    """Return the gain of the next loop by the rule; raise InputError with the cause and the speeds at which the rule
    works.
    """
    gain, gains, peaks = tried(parameters, speed, inner)
    if np.isnan(gain):
        first = f"{peaks[0]:.3g} dB however small its gain, as the bicycle swings by itself"
        why = first if peaks[0] >= RESONANCE_PEAK else f"{peaks.max():.3g} dB at most, with gains up to {gains[-1]:g}"
        where = np.array([balances(parameters, v) for v in SPEEDS])
        some = spans(SPEEDS, where), "give such a speed, or gains"
        speeds, cure = some if where.any() else ("no speed", "give gains")
        raise InputError(
            f"bicycle '{parameters.name}': at {speed:g} m/s the {LOOPS[len(inner)]} loop peaks by {why}, where the "
            f"rule for gains wants {RESONANCE_PEAK:g} dB; "
            f"of {SPEEDS[0]:g} to {SPEEDS[-1]:g} m/s the rule balances it at "
            f"{speeds}; {cure}"
        )
    return gain


def by_rule(parameters: Parameters, speed: float) -> Gains | None:
    """Return the gains of the rule, None where it finds none."""
    inner: list[float] = []
    while len(inner) < len(GAIN_BRACKETS):
        inner.append(tried(parameters, speed, inner).gain)
        if np.isnan(inner[-1]):
            return None
    return gains_of(parameters, speed, steer=inner[0], roll_rate=inner[1])


def balances(parameters: Parameters, speed: float) -> bool:
    """Return whether the rule finds gains with which the rider stays upright."""
    gains = by_rule(parameters, speed)
    return gains is not None and bool(eigenvalues(parameters, speed, gains).real.max() < 0.0)


def spans(speeds: np.ndarray, here: np.ndarray) -> str:
    """Return runs of neighbouring speeds as text."""
    edges = np.flatnonzero(np.diff(np.r_[False, here, False].astype(int)))
    parts = [(speeds[a], speeds[b - 1]) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    return ", ".join(f"{a:.4g} ... {b:.4g} m/s" if a < b else f"{a:.4g} m/s" for a, b in parts) or "nowhere"


def factors(poles: np.ndarray) -> str:
    """Format a polynomial by its roots as papers print it: (s+3.175)(s-1.767)(s2+10.86s+97.55)."""
    real = sorted(s.real for s in poles if s.imag == 0.0 and abs(s) > 1e-9)
    pairs = sorted((s for s in poles if s.imag > 0.0), key=abs)
    signed = [f"(s{-x:+.4g})" for x in real]
    return "".join(signed + [f"(s2{-2.0 * s.real:+.4g}s{abs(s) ** 2:+.4g})" for s in pairs])
