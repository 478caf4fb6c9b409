"""Classical method of order 4 with fixed steps; dense output by cubic Hermite, which keeps the order."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base.checks import number
from ..kernels.layout import Data, Model
from .memory import Stages, Table, new_stages, widest_gap
from .method import Method
from .runge_kutta import advance

C = np.array([0, 0.5, 0.5, 1.0])
TABLE = Table(
    A=np.array([[0, 0, 0, 0], [0.5, 0, 0, 0], [0, 0.5, 0, 0], [0, 0, 1.0, 0]]),
    b=np.array([1, 2, 2, 1]) / 6.0,
    c=C,
    error=np.zeros((3, 4)),
    A_dense=np.zeros((0, 5)),
    c_dense=np.zeros(0),
    D=np.zeros((0, 5)),
    order=4,
    gap=widest_gap(C),
)


@dataclass(frozen=True)
class RK4(Method):
    """Classical Runge-Kutta method of order 4 with fixed steps of ``dt`` [s], adjusted to land on ``t_end``, and split
    where a pulse or a table turns.

    Examples
    --------
    >>> from mbsd3d import RK4, Body, System, simulate
    >>> stone = Body("stone", 1.0, (0.1, 0.1, 0.1), velocity=(0, 0, 3.0), omega=(0, 0, 0))
    >>> run = simulate(System([stone]), 0.5, method=RK4(dt=0.2))
    >>> run.t.round(9)  # equal steps of at most dt
    array([0.        , 0.16666667, 0.33333333, 0.5       ])
    """

    dt: float

    order = TABLE.order
    loop = staticmethod(advance)

    def __post_init__(self) -> None:
        number(self.dt, "RK4: dt", positive=True)

    def start(self, model: Model, data: Callable[[type], Data]) -> Stages:
        return new_stages(TABLE, 13 * model.body.size + model.state.size)
