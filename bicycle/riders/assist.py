"""Balance assist: steer torque from sensor signals, and the speeds it makes self-stable.

    T = -K (phi, delta, phi_dot, delta_dot)

with roll-rate feedback, K = (0, 0, k, 0); steer into the fall, K = (k, 0, c, 0); or the linear-quadratic regulator.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_continuous_are

from mbsd3d.errors import InputError
from mbsd3d.extend import number, on_one_thread

from ..linear.critical import Range
from ..linear.equations import canonical, checked_speeds
from ..linear.tyre_equations import stable_between
from ..parameters import Parameters

Law = Callable[[float], np.ndarray]
"""K (4,) at a speed [m/s]."""
SPEED_GRID = np.linspace(0.05, 15.0, 600)
"""[m/s] between two of which a limit is sought."""


def roll_rate(gain: float) -> Law:
    """Return the control law T = -k phi_dot: k < 0 [N m s/rad] steers into the fall."""
    k = number(gain, "assist: gain")
    return lambda speed: np.array([0.0, 0.0, k, 0.0])


def into_the_fall(roll: float, rate: float) -> Law:
    """Return the control law T = -(k phi + c phi_dot), with k [N m/rad] and c [N m s/rad]."""
    k, c = number(roll, "assist: roll"), number(rate, "assist: rate")
    return lambda speed: np.array([k, 0.0, c, 0.0])


def regulator(parameters: Parameters, weights: Sequence[float] = (1.0, 1.0, 1.0, 1.0), effort: float = 1e-2) -> Law:
    """Return the gains K that minimise the integral of sum w_i x_i^2 + effort T^2, computed at every speed."""
    if np.shape(weights) != (4,):
        raise InputError(f"assist: weights = {weights!r:.80}; give four: of lean, steer and their rates")
    Q, linear = np.diag([number(w, "assist: weight", minimum=0.0) for w in weights]), canonical(parameters)
    R = np.array([[number(effort, "assist: effort", positive=True)]])
    B = input_of(parameters)
    return lambda speed: np.linalg.solve(R, B.T @ solve_continuous_are(linear.A(speed), B, Q, R))[0]


def input_of(parameters: Parameters) -> np.ndarray:
    """Return the rates of (lean, steer, rates) by a unit steer torque, shape (4, 1)."""
    return np.r_[0.0, 0.0, np.linalg.solve(canonical(parameters).M, (0.0, 1.0))][:, None]


def eigenvalues(parameters: Parameters, speeds: ArrayLike, law: Law) -> np.ndarray:
    """Return the complex eigenvalues [1/s] at speeds (n,) [m/s], by real part, shape (n, 4)."""
    linear, B = canonical(parameters), input_of(parameters)
    matrices = [linear.A(v) - B * law(v) for v in np.asarray(speeds, float).ravel().tolist()]
    return np.sort_complex(np.linalg.eigvals(np.array(matrices)))


@on_one_thread
def stable_ranges(parameters: Parameters, law: Law, speeds: ArrayLike | None = None) -> list[Range]:
    """Return ranges of self-stable speeds within the first and the last one given [m/s]; None = 0.05 ... 15.

    Examples
    --------
    >>> from bicycle import Meijaard2007, assist
    >>> [(round(x.low, 5), round(x.high, 5)) for x in assist.stable_ranges(Meijaard2007(), assist.roll_rate(-10.0))]
    [(2.81174, 6.02426)]
    """
    grid = SPEED_GRID if speeds is None else np.unique(checked_speeds(speeds))
    if grid.size < 2:
        raise InputError("assist: give at least two different speeds, between which limits are sought")
    linear, B = canonical(parameters), input_of(parameters)
    return stable_between(lambda v: linear.A(v) - B * law(v), grid)
