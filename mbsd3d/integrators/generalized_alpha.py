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

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..base.checks import number
from .alpha_loop import integrate
from .alpha_memory import Alpha, weights
from .newton import Newton
from .runge_kutta import Table


@dataclass(frozen=True)
class GeneralizedAlpha:
    """Implicit method of order 2 for stiff systems: stiff springs, bushings, contact dampers, controllers.

    Its step follows the motion asked for, not the fastest frequency in the model. What the step does not resolve is
    damped by the factor ``rho`` per step; the energy lost so is not hidden: it stands in the certificate's balance.

    Parameters
    ----------
    dt : float or None
        Fixed step [s], adjusted to land on ``t_end``; None = adaptive: the local error is held to ``rtol``.
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
            raise ValueError(f"GeneralizedAlpha: rho {self.rho:g} is outside 0 ... 1; give e.g. 0.8")
        if not self.max_step > 0.0:
            raise ValueError(f"GeneralizedAlpha: max_step {self.max_step} is not positive; give a time > 0")

    def table(self, steps: int) -> Table:
        """A table without stages: it holds the number of steps, 0 = adaptive, and the shape of the dense output."""
        none = np.zeros((1, 1))
        return Table(
            A=none, b=np.zeros(1), c=np.zeros(1), error=np.zeros((2, 1)), A_dense=np.zeros((0, 2)),
            c_dense=np.zeros(0), D=np.zeros((0, 2)), order=2, steps=steps,
            patience=np.inf,
        )  # fmt: skip

    def own(self, compiled: Any, table: Table) -> tuple:
        """What the time loop takes beside model, work space, rows and run."""
        if not compiled.switches.gamma or compiled.switches.stabilisation == "baumgarte":
            raise ValueError(
                "GeneralizedAlpha: its equations hold no gamma = b_dot - J_dot v, so gamma=False and "
                "stabilisation='baumgarte' would change nothing; use DOP853() or RK4(dt) to show their effect"
            )
        model = compiled.model
        n, m, ny = model.body.size, model.row.size, 13 * model.body.size + model.state.size
        size = 6 * n + model.z_work + m
        newton = Newton(
            rate=np.zeros(ny), lam=np.zeros(m), move=np.zeros((n, 3)), x=np.zeros(size), A=np.zeros((size, size)),
            pivot=np.zeros(size, np.int64), data=compiled.data(complex), y_c=np.zeros(ny, complex),
            rate_c=np.zeros(ny, complex), x_c=np.zeros(size, complex),
        )  # fmt: skip
        names = ("rate", "shift", "a", "jerk", "jerk_new", "mean")
        return (
            Alpha(
                table=table, first=weights(1.0), weights=weights(float(self.rho)), newton=newton, lam=np.zeros(m),
                h=np.zeros(2), flag=np.zeros(2, np.int64), **{name: np.zeros(ny) for name in names},
            ),
        )  # fmt: skip
