"""Settings of a run: method, tolerance or step, and sample times, drawn at random."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.random import Generator

from mbsd3d import DOP853, RK4, GeneralizedAlpha, Kinematic, RadauIIA
from validation.calibration.problem import Problem

RTOL_EXPONENT_MAX = -2.0  # [1] log10 of rtol
# [1] log10 of rtol; method of order 2: many steps
RTOL_EXPONENT_MIN = {"DOP853": -12.0, "RadauIIA": -11.0, "GeneralizedAlpha": -6.0}
STEP_ANGLE_MIN, STEP_ANGLE_MAX = 0.02, 5.0  # fixed steps times the fastest rate of the motion [rad]
STEP_ANGLE_MIN_BY_METHOD = {"DOP853(dt)": 0.05, "RadauIIA(dt)": 0.05}  # [rad] of high order: rounding is reached
STEP_COUNT_MAX = 10_000
DEFAULT_RTOL = 1e-8  # of simulate; with fixed steps only Newton's method and the limits of the checks read it
CLASSES = ((1e-4, "rtol 1e-2 to 1e-4"), (1e-8, "rtol 1e-4 to 1e-8"), (0.0, "rtol 1e-8 to 1e-12"))
FIXED_CLASSES = ((0.1, "step fine"), (1.0, "step coarse"), (np.inf, "step hopeless"))
"""By the step times the fastest rate [rad]."""


@dataclass(frozen=True)
class Settings:
    """Method and options of `simulate`; ``kind``: row of the table."""

    name: str
    method: Any = field(repr=False)
    rtol: float
    output: Any = field(repr=False)
    kind: str
    shown: str


def draw(rng: Generator, problem: Problem) -> Settings:
    """Draw settings that a problem may have."""
    name = str(rng.choice(problem.methods))
    output = samples(rng, problem.t_end)
    if name == "Kinematic":
        apart = problem.t_end / int(rng.integers(8, 200))
        return Settings(name, Kinematic(max_step=apart), DEFAULT_RTOL, output, "poses", f"Kinematic({apart:.4g})")
    if name in RTOL_EXPONENT_MIN:
        rtol = float(10.0 ** rng.uniform(RTOL_EXPONENT_MIN[name], RTOL_EXPONENT_MAX))
        rtol = float(f"{rtol:.2g}")
        made = {"DOP853": DOP853, "RadauIIA": RadauIIA, "GeneralizedAlpha": GeneralizedAlpha}[name]()
        kind = next(text for least, text in CLASSES if rtol > least)
        return Settings(name, made, rtol, output, kind, f"{name}() rtol {rtol:g}")
    turned = float(
        np.exp(rng.uniform(np.log(STEP_ANGLE_MIN_BY_METHOD.get(name, STEP_ANGLE_MIN)), np.log(STEP_ANGLE_MAX)))
    )
    dt = max(turned / problem.rate, problem.t_end / STEP_COUNT_MAX)
    dt = min(dt, 0.5 * problem.t_end)
    makes = {"RK4": RK4, "DOP853(dt)": lambda h: DOP853(dt=h), "RadauIIA(dt)": lambda h: RadauIIA(dt=h)}
    made = makes.get(name, lambda h: GeneralizedAlpha(dt=h))(dt)
    kind = next(text for most, text in FIXED_CLASSES if dt * problem.rate <= most)
    return Settings(
        name, made, DEFAULT_RTOL, output, kind, f"{name.split('(')[0]}(dt={dt:.5g}), {dt * problem.rate:.2g} rad a step"
    )


def samples(rng: Generator, t_end: float) -> Any:
    """Draw every accepted step, equally spaced times, or random times: between steps the dense output is tested too."""
    which = rng.integers(3)
    if which == 0:
        return None
    count = int(rng.integers(3, 80))
    if which == 1:
        return count
    return np.unique(np.append(rng.uniform(0.0, t_end, count), t_end))
