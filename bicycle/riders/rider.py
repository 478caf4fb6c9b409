"""A rider who closes five loops, one around the other: steer angle, roll rate, roll, heading, lateral deviation.

    U = k_delta (k_phidot (k_phi (k_psi (k_y (y_c - y) - psi) - phi) - phi_dot) - delta)
    T'' = 900 (U - T) - 42.42 T'          steer torque: arms and muscles of second order, 30 rad/s, damping 0.707

The model and its rule for gains are those of R. A. Hess, J. K. Moore and M. Hubbard (2012). psi and y, the heading and
the lateral deviation of the front contact, are positive to the right, as lean phi and steer delta are.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from mbsd3d.errors import InputError
from mbsd3d.extend import number

from ..linear.equations import canonical
from ..parameters import Parameters

STATES = ("lean", "steer", "lean rate", "steer rate", "heading", "deviation", "torque", "torque rate")
LOOPS = ("steer angle", "roll rate", "roll", "heading", "lateral deviation")
SEEN = (1, 2, 0, 4, 5)  # the state each loop compares with its command
CROSSOVER = (2.0, 1.0, 0.5)  # [rad/s] of the loops of roll, heading and lateral deviation
MUSCLES = (900.0, 42.42)
PEAK = 10.0  # [dB] of the two inner loops,
LEVEL = (1.0, 3.0)  # above what they let pass at this frequency [rad/s]
FREQUENCIES = np.geomspace(3.0, 60.0, 400)  # [rad/s] where the peaks are


class Gains(NamedTuple):
    """Gains of the five loops, from the inside out."""

    steer: float  # [N m/rad]
    roll_rate: float  # [s]
    roll: float  # [1/s]
    heading: float
    deviation: float  # [rad/m]


class Loop(NamedTuple):
    """x' = A x + B command, x = `STATES`."""

    A: np.ndarray  # (8, 8)
    B: np.ndarray  # (8,)

    def response(self, frequency: np.ndarray | float) -> np.ndarray:
        """(n, 8) complex x/command at frequencies [rad/s]."""
        s = 1j * np.atleast_1d(frequency)[:, None, None]
        return np.linalg.solve(s * np.eye(len(STATES)) - self.A, self.B[:, None])[..., 0]


def open_loop(parameters: Parameters, speed: float) -> Loop:
    """Transfer from the rider's command U to the states at a speed [m/s], on ideal wheels."""
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
    """Transfer from the command of the outermost of ``count`` closed loops to the states; no loop is `open_loop`."""
    A, B = open_loop(parameters, speed)
    for k, seen, name in zip(gains[:count], SEEN, LOOPS, strict=False):
        B = B * number(k, f"rider: gain of the {name} loop")
        A[:, seen] -= B
    return Loop(A, B)


def eigenvalues(parameters: Parameters, speed: float, gains: Gains, count: int = 5) -> np.ndarray:
    """(8,) complex [1/s] of bicycle and rider with ``count`` closed loops; two zeros until heading and way are held."""
    return np.sort_complex(np.linalg.eigvals(closed_loops(parameters, speed, gains, count).A))


def gains_of(
    parameters: Parameters, speed: float, *, steer: float | None = None, roll_rate: float | None = None
) -> Gains:  # fmt: skip
    """Gains by rule: 10 dB of peak in the inner loops, crossovers of the outer ones at 2, 1 and 0.5 rad/s.

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
        If no gain makes such a peak; give it then.

    Examples
    --------
    >>> from bicycle import Meijaard2007, rider
    >>> found = rider.gains_of(Meijaard2007(), 5.0, steer=46.5457, roll_rate=-0.0522)
    >>> [round(k, 4) for k in found[2:]]
    [12.6635, 0.1849, 0.0959]
    """
    found: list[float] = []
    for given, brackets in ((steer, (1.0, 5e3)), (roll_rate, (-1e-3, -1.0))):
        found.append(peaked(parameters, speed, found, brackets) if given is None else given)
    for frequency in CROSSOVER:
        plant = closed_loops(parameters, speed, Gains(*found, *[0.0] * (5 - len(found))), len(found))
        found.append(float(1.0 / np.abs(plant.response(frequency)[0, SEEN[len(found)]])))
    return Gains(*found)


def peaked(parameters: Parameters, speed: float, inner: list[float], brackets: tuple[float, float]) -> float:
    """The largest gain k of the next loop with which k G/(1 + k G) does not exceed the rule's peak."""
    count = len(inner)
    plant = closed_loops(parameters, speed, Gains(*inner, *[0.0] * (5 - count)), count)
    G = plant.response(np.append(FREQUENCIES, LEVEL[count]))[:, SEEN[count]]

    def excess(gain: float) -> float:
        closed = np.abs(gain * G / (1.0 + gain * G))
        return float(20.0 * np.log10(closed[:-1].max() / closed[-1]) - PEAK)

    tried = np.geomspace(*brackets, 80)
    values = np.array([excess(gain) for gain in tried])
    crossed = np.flatnonzero((values[:-1] < 0.0) & (values[1:] >= 0.0))
    if not crossed.size:
        raise InputError(
            f"bicycle '{parameters.name}': at {speed:g} m/s no gain of the {LOOPS[count]} loop makes a peak of "
            f"{PEAK:g} dB; give this gain"
        )
    return float(brentq(excess, tried[crossed[-1]], tried[crossed[-1] + 1], xtol=1e-14))


def factors(poles: np.ndarray, digits: int = 4) -> str:
    """A polynomial by its roots as papers print it: (s+3.175)(s-1.767)(s2+10.86s+97.55)."""
    real = sorted(s.real for s in poles if s.imag == 0.0 and abs(s) > 1e-9)
    pairs = sorted((s for s in poles if s.imag > 0.0), key=abs)
    signed = [f"(s{-x:+.{digits}g})" for x in real]
    return "".join(signed + [f"(s2{-2.0 * s.real:+.{digits}g}s{abs(s) ** 2:+.{digits}g})" for s in pairs])
