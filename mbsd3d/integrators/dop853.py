"""Dormand and Prince's method of order 8 with dense output of order 7."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base.checks import check_choice, number
from ..kernels.layout import Data, Model
from .dop853_coefficients import A_EXTRA, C_EXTRA, E3, E5, A, B, C, D
from .memory import Stages, Table, new_stages, widest_gap
from .method import Method, check_max_step
from .runge_kutta import advance

STIFF_WORK_MAX = 2e5  # [steps times bodies] a stiff run may still take before it stops; some three seconds
DENSE_NODES = [0, 6, 7, 8, 9, 10]  # stages of the interpolant: of all choices with small weights the best at a kink


def second_estimate(first: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Return weights of a divided difference of the rates at `DENSE_NODES`, scaled like the first estimate.

    Where a rate has a kink within the step, as when a contact opens, any estimate vanishes for some places of the kink,
    and the step would be accepted whatever its error. Two estimates vanish at different places.
    """
    apart = c[DENSE_NODES, None] - c[DENSE_NODES] + np.eye(len(DENSE_NODES))
    weights = np.zeros(c.size)
    weights[DENSE_NODES] = first @ c**5 / apart.prod(axis=1)
    return weights


TABLE = Table(
    A=A,
    b=B,
    c=C,
    error=np.array([E5, second_estimate(E5, C), E3]),
    A_dense=A_EXTRA,
    c_dense=C_EXTRA,
    D=D,
    order=8,
    gap=widest_gap(C),
)


@dataclass(frozen=True)
class DOP853(Method):
    """Adaptive explicit Runge-Kutta method of order 8, or with fixed steps when ``dt`` [s] is given.

    The default for systems that are not stiff. Adaptive steps may span whole turns of bodies that spin about an axis
    of symmetry, as wheels and tops do: the motion of the axis limits them. Hairer, Norsett, Wanner: Solving Ordinary
    Differential Equations I.

    Parameters
    ----------
    dt : float or None
        Fixed step [s], adjusted to end at ``t_end``, split at kinks of signals; None = adaptive.
    max_step : float
        Longest step [s].
    stiff : "stop" or "run"
        Action if stability, not accuracy, limits the steps (h |lambda| > 3.4 in 15 tests) and the rest of the
        run needs more than 2e5 steps times bodies: stop with an `IntegrationError` that names the force, or go on.

    Examples
    --------
    >>> from mbsd3d import DOP853, Body, System, simulate
    >>> stone = Body("stone", 1.0, (0.1, 0.1, 0.1), velocity=(0, 0, 3.0), omega=(0, 0, 0))
    >>> run = simulate(System([stone]), 0.5, method=DOP853(dt=0.25))
    >>> round(float(run.position(stone)[-1, 2]), 5), run.certificate.steps
    (0.27375, 2)
    """

    dt: float | None = None
    max_step: float = np.inf
    stiff: str = "stop"

    order = TABLE.order
    loop = staticmethod(advance)
    dense_terms = 3 + TABLE.D.shape[0]

    def __post_init__(self) -> None:
        if self.dt is not None:
            number(self.dt, "DOP853: dt", positive=True)
        check_max_step(self.max_step, "DOP853")
        check_choice(self.stiff, ("stop", "run"), "DOP853: stiff")

    @property
    def patience(self) -> float:  # type: ignore[override]  # frozen, as a field is
        """Return the work [steps x bodies] a stiff run with adaptive steps may take; fixed steps are not limited."""
        return STIFF_WORK_MAX if self.stiff == "stop" else np.inf

    def start(self, model: Model, data: Callable[[type], Data]) -> Stages:
        return new_stages(TABLE, 13 * model.body.size + model.state.size)
