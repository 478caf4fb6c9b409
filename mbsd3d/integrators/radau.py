"""Radau IIA of order 5, for stiff systems at tight tolerances: collocation at three points of the step.

    Z_i = h sum_j a_ij f(t + c_j h, y + Z_j)        y' = y + Z_3        (c_3 = 1: stiffly accurate, no loss of order)

Hairer, Wanner: Solving Ordinary Differential Equations II, section IV.8. With A^-1 = T D T^-1, D of one real and one
pair of complex eigenvalues, Newton's method splits into a real and a complex system of the size of y; its matrix J of
the rates f (accelerations by the saddle point, joints included) is found by differences and kept while it converges.
Poses and velocities are projected after the step, as with all methods.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..base.checks import number
from ..compiler.arguments import by_reference
from ..kernels.layout import Data, Model, single
from .method import Method, check_max_step
from .radau_step import collocation

SQUARE_ROOT_OF_6 = np.sqrt(6.0)
C = np.array([(4.0 - SQUARE_ROOT_OF_6) / 10.0, (4.0 + SQUARE_ROOT_OF_6) / 10.0, 1.0])
POWERS = np.arange(3)
A = (C[:, None] ** (POWERS + 1.0) / (POWERS + 1.0)) @ np.linalg.inv(C[:, None] ** POWERS)
"""sum_j a_ij c_j^(k-1) = c_i^k / k for k = 1, 2, 3: what makes it collocation."""


def split() -> tuple[float, complex, np.ndarray]:
    """Return (real eigenvalue, complex one, T) of A^-1: A^-1 T = T [[g, 0, 0], [0, a, -b], [0, b, a]]."""
    values, vectors = np.linalg.eig(np.linalg.inv(A))
    real, pair = int(np.argmin(np.abs(values.imag))), int(np.argmin(values.imag))
    T = np.column_stack([vectors[:, real].real, vectors[:, pair].real, vectors[:, pair].imag])
    return float(values[real].real), complex(values[pair].conjugate()), T


REAL, PAIR, T = split()
ERROR = (
    np.array([-13.0 - 7.0 * SQUARE_ROOT_OF_6, -13.0 + 7.0 * SQUARE_ROOT_OF_6, -1.0]) / 3.0
)  # eq. (8.17) over the real eigenvalue
PAST = [
    ("jacobian", int),  # 1: J belongs to the start of this step, 0: to an earlier one, -1: there is none
    ("factored", float),  # s, step of the factors at hand; 0 = none
    ("contraction", float),  # of Newton's method in the last step
    ("step", float),  # s, step of the polynomial in old; 0 = none
]


@by_reference
class Collocation(NamedTuple):
    """Coefficients and memory of the method; arrays of length N leave out the audit states."""

    c: np.ndarray  # (3,)
    A: np.ndarray  # (3, 3)
    T: np.ndarray  # (3, 3)
    inverse: np.ndarray  # (3, 3) T^-1
    error: np.ndarray  # (3,) weights of the stages in the error
    real: float
    pair: complex
    spread: np.ndarray  # (3, 3) Z = spread polynomials: coefficients of x, x^2, x^3 from Z
    J: np.ndarray  # (N, N) df/dy
    R: np.ndarray  # (N, N) factors of real/h - J
    P: np.ndarray  # (N, N) factors of pair/h - J
    exchange_real: np.ndarray  # (N,)
    exchange_pair: np.ndarray  # (N,)
    Z: np.ndarray  # (3, ny) stages less y
    W: np.ndarray  # (3, N) T^-1 Z
    K: np.ndarray  # (3, ny) rates of the stages
    x: np.ndarray  # (N,) right side and correction
    x_pair: np.ndarray  # (N,) the same of the complex system
    old: np.ndarray  # (3, N) coefficients of x, x^2, x^3 in the last step
    past: np.record  # PAST


@dataclass(frozen=True)
class RadauIIA(Method):
    """Implicit method of order 5 for stiff systems without jumps: springs, dampers, bushings, at tight tolerances.

    Where `GeneralizedAlpha` needs thousands of steps for an error of 1e-6, it needs a few hundred. Its cost grows with
    the cube of the number of bodies: for some ten bodies.

    Parameters
    ----------
    dt : float or None
        Fixed step [s], adjusted to end at ``t_end``, split at kinks of signals; None = adaptive: the
        local error is held to ``rtol``.
    max_step : float
        Longest step [s].

    Raises
    ------
    ValueError
        For a step that is not positive.

    Examples
    --------
    A pendulum held by a hinge of 1e8 N/m instead of a joint:

    >>> from mbsd3d import GROUND, Body, Bushing, RadauIIA, System, simulate
    >>> bob = Body("bob", 2.0, (0.1, 0.1, 0.1), position=(1.0, 0, 0))
    >>> pin = Bushing(GROUND, bob, at=(0, 0, 0), stiffness=1e8, damping=1e5)
    >>> run = simulate(System([bob], forces=[pin]), 0.5, method=RadauIIA())
    >>> run.certificate.passed
    True
    """

    dt: float | None = None
    max_step: float = np.inf

    order = 5
    loop = staticmethod(collocation)

    def __post_init__(self) -> None:
        if self.dt is not None:
            number(self.dt, "RadauIIA: dt", positive=True)
        check_max_step(self.max_step, "RadauIIA")

    def start(self, model: Model, data: Callable[[type], Data]) -> Collocation:
        core = 13 * model.body.size + model.z_work
        ny = 13 * model.body.size + model.state.size
        past = single(PAST)
        past.jacobian, past.contraction = -1, 1.0
        return Collocation(
            c=C, A=A, T=T, inverse=np.linalg.inv(T), error=ERROR, real=REAL, pair=PAIR,
            spread=np.linalg.inv(C[:, None] ** (POWERS + 1.0)),
            J=np.zeros((core, core)), R=np.zeros((core, core)), P=np.zeros((core, core), complex),
            exchange_real=np.zeros(core, np.int64), exchange_pair=np.zeros(core, np.int64), Z=np.zeros((3, ny)),
            W=np.zeros((3, core)), K=np.zeros((3, ny)), x=np.zeros(core), x_pair=np.zeros(core, complex),
            old=np.zeros((3, core)), past=past,
        )  # fmt: skip
