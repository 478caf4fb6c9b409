"""Lie group generalised alpha for stiff systems (Arnold, Bruels, Cardona: Numer. Math. 129, 2015), stabilised index 2.

With a the method's own acceleration, tied to v_dot by a recurrence that damps what the step does not resolve:

    (1 - alpha_m) a' + alpha_m a = (1 - alpha_f) v_dot' + alpha_f v_dot        (' at the end of the step)
    q' = project(q o exp(h (v + h ((1/2 - beta) a + beta a'))))                c(q', t') = 0
    v' = v + h ((1 - gamma) a + gamma a')                                      J' v' = b', determines lam'
    M' v_dot' + h' + J'^T lam' = Q'

Rotations by the exponential map in body axes, the position kept on c = 0 by the same mass-weighted projection as in
all other methods, here inside Newton's method, so that lam keeps order 2 when the step changes (from c = 0 alone,
index 3, it would drop to order 1 there). States z follow the velocity's formula. Since a belongs to the time
t + theta h, theta = alpha_m - alpha_f, it is stored as v_dot + h shift and adapts to the step; the first step, which
has no history, is taken with rho = 1, where theta = 0.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..base.checks import number
from ..base.errors import InputError
from ..compiler.arguments import by_reference
from ..kernels.kinds import BAUMGARTE
from ..kernels.layout import Data, Model, single
from .alpha_step import integrate
from .method import Method, check_max_step
from .newton import Newton, new_newton


@by_reference
class Weights(NamedTuple):
    """Coefficients of the method for one rho, and of its local errors: C_q h^3 d3q/dt3, C_v h^3 d3v/dt3."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    error_q: float
    error_v: float


def weights(rho: float) -> Weights:
    """Return the coefficients of Chung and Hulbert's optimal method.

    Errors follow from inserting the exact solution.
    """
    alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    theta = alpha_m - alpha_f
    gamma = 0.5 - theta
    beta = 0.25 * (gamma + 0.5) ** 2
    # a = v_dot(t + theta h) + kappa h^2 d3v
    kappa = 0.5 * (1.0 - alpha_f) - 0.5 * (1.0 - alpha_m) * (1.0 + theta) ** 2 - 0.5 * alpha_m * theta**2
    error_v = 0.5 * (1.0 - gamma) * theta**2 + 0.5 * gamma * (1.0 + theta) ** 2 + kappa - 1.0 / 6.0
    return Weights(alpha_m, alpha_f, beta, gamma, 0.5 * theta + beta - 1.0 / 6.0, error_v)


PAST = [
    ("first", int),  # 1 before the first step
    ("step", float),  # s, length of the last step
    ("matrix", int),  # 1 when there is a matrix of Newton's method
    ("matrix_step", float),  # s, the step it belongs to
]


@by_reference
class Alpha(NamedTuple):
    """Memory of the method; arrays in the layout of y use its velocity and z parts only."""

    first: Weights  # of the first step: rho = 1
    weights: Weights
    newton: Newton
    rate: np.ndarray  # (ny,) v_dot and z_dot at the start of the step
    lam: np.ndarray  # (m,) multipliers there
    shift: np.ndarray  # (ny,) (a - v_dot) / h
    a: np.ndarray  # (ny,) a at the end of the step
    jerk: np.ndarray  # (ny,) its slope over the last step
    jerk_new: np.ndarray  # (ny,) and over this one
    mean: np.ndarray  # (ny,) mean velocity of the step
    past: np.record  # PAST


@dataclass(frozen=True)
class GeneralizedAlpha(Method):
    """Implicit method of order 2 for stiff systems: stiff springs, bushings, contact dampers, controllers.

    The step size follows the slow motion, not the highest frequency in the model. Motion that it does not resolve is
    damped by the factor ``rho`` per step; the energy balance of the certificate shows the energy lost.

    Parameters
    ----------
    dt : float or None
        Fixed step [s], adjusted to end at ``t_end``, split at kinks of signals; None = adaptive: the
        local error is held to ``rtol``.
    rho : float
        Spectral radius at infinite frequency, 0 (damps at once) ... 1 (no numerical damping).
    max_step : float
        Longest step [s].

    Raises
    ------
    ValueError
        For a step that is not positive or a rho outside 0 ... 1.

    Examples
    --------
    A pendulum held by a hinge of 1e8 N/m instead of a joint, in steps of a hundredth of a second:

    >>> from mbsd3d import GROUND, Body, Bushing, GeneralizedAlpha, System, simulate
    >>> bob = Body("bob", 2.0, (0.1, 0.1, 0.1), position=(1.0, 0, 0))
    >>> pin = Bushing(GROUND, bob, at=(0, 0, 0), stiffness=1e8, damping=1e5)
    >>> run = simulate(System([bob], forces=[pin]), 0.5, method=GeneralizedAlpha(dt=0.01), rtol=1e-3)
    >>> run.certificate.steps
    50
    """

    dt: float | None = None
    rho: float = 0.8
    max_step: float = np.inf

    order = 2
    loop = staticmethod(integrate)

    def __post_init__(self) -> None:
        if self.dt is not None:
            number(self.dt, "GeneralizedAlpha: dt", positive=True)
        if not 0.0 <= number(self.rho, "GeneralizedAlpha: rho") <= 1.0:
            raise InputError(f"GeneralizedAlpha: rho {self.rho:g} is outside 0 ... 1; give e.g. 0.8")
        check_max_step(self.max_step, "GeneralizedAlpha")

    def start(self, model: Model, data: Callable[[type], Data]) -> Alpha:
        if not model.gamma or model.stabilisation == BAUMGARTE:
            raise InputError(
                "GeneralizedAlpha: its equations hold no gamma = b_dot - J_dot v, so gamma=False and "
                "stabilisation='baumgarte' would change nothing; use DOP853() or RK4(dt) to show their effect"
            )
        newton = new_newton(model, data(complex))
        rate, shift, a, jerk, jerk_new, mean = np.zeros((6, newton.rate.size))
        return Alpha(
            first=weights(1.0), weights=weights(float(self.rho)), newton=newton, lam=np.zeros(model.row.size),
            rate=rate, shift=shift, a=a, jerk=jerk, jerk_new=jerk_new, mean=mean, past=single(PAST),
        )  # fmt: skip
