"""Coefficients and memory of generalised alpha."""

from typing import NamedTuple

import numpy as np

from .newton import Newton
from .runge_kutta import Table

FIRST, MADE = range(2)  # Alpha.flag: 1 before the first step; 1 when there is a matrix
LAST, OF_MATRIX = range(2)  # Alpha.h: last step, step that the matrix belongs to


class Weights(NamedTuple):
    """Coefficients of the method for one rho, and of its local errors: C_q h^3 d3q/dt3, C_v h^3 d3v/dt3."""

    alpha_m: float
    alpha_f: float
    beta: float
    gamma: float
    error_q: float
    error_v: float


def weights(rho: float) -> Weights:
    """Chung and Hulbert's optimal choice; errors from inserting the exact solution."""
    alpha_m, alpha_f = (2.0 * rho - 1.0) / (rho + 1.0), rho / (rho + 1.0)
    theta = alpha_m - alpha_f
    gamma = 0.5 - theta
    beta = 0.25 * (gamma + 0.5) ** 2
    # a = v_dot(t + theta h) + kappa h^2 d3v
    kappa = 0.5 * (1.0 - alpha_f) - 0.5 * (1.0 - alpha_m) * (1.0 + theta) ** 2 - 0.5 * alpha_m * theta**2
    error_v = 0.5 * (1.0 - gamma) * theta**2 + 0.5 * gamma * (1.0 + theta) ** 2 + kappa - 1.0 / 6.0
    return Weights(alpha_m, alpha_f, beta, gamma, 0.5 * theta + beta - 1.0 / 6.0, error_v)


class Alpha(NamedTuple):
    """Memory of the method; arrays in the layout of y use its velocity and z parts only."""

    table: Table  # number of steps; empty stages
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
    h: np.ndarray  # (2,) see LAST, OF_MATRIX
    flag: np.ndarray  # (2,) see FIRST, MADE
