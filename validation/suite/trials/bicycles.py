"""Bicycles as cases: their motion against Lagrange's equations in eight coordinates, and the published eigenvalues."""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from bicycle import Meijaard2007, general, whipple
from validation import cases
from validation.suite.findings import REFERENCE, THEORY, Finding, judged
from validation.suite.trials.references import START_ROUNDING
from validation.suite.trials.trial import Run, Trial, run
from validation.theory import whipple_lagrange

BODIES = ("rear wheel", "frame", "fork", "front wheel")  # In the order of the paper: R, B, H, F
PAPER_TO_MODEL = np.array([1.0, -1.0, -1.0])  # from the axes of the paper, y right and z down, to those of the model
INITIAL_STATE: dict[str, Any] = {"lean": 0.15, "steer": -0.1, "lean_rate": 0.3, "steer_rate": -0.2}
"""[rad, rad/s]; far from upright, so that the equations are not linear."""
BENCHMARK = Meijaard2007()
ROUND_TYRES = replace(BENCHMARK, tR=0.03, tF=0.02, rF=0.31)
T_END, SAMPLES, RTOL = 1.0, 5, 1e-9
# [1] of Lagrange's equations: a hundred times their tolerance; their own rounding, of differences, is 1e-12
DIFFERENCE_MAX = 1e-7


def trials(quick: bool) -> list[Trial]:
    """Return the benchmark bicycle in its range of stability and above it, and one with round tyres."""
    plans = {
        "bicycle_benchmark": ("Meijaard et al. 2007, 4.6 m/s", BENCHMARK, 4.6, {REFERENCE: eigenvalues}),
        "bicycle_fast": ("the same, 8 m/s: it falls slowly", BENCHMARK, 8.0, {}),
        "bicycle_round_tyres": ("round tyres, a smaller front wheel, 4.6 m/s", ROUND_TYRES, 4.6, {}),
    }
    return [
        Trial(name, "bicycles", title, partial(riding, p, speed), {THEORY: lagrange, **more})
        for name, (title, p, speed, more) in (list(plans.items())[:1] if quick else plans.items())
    ]


def riding(p: Any, speed: float) -> Run:
    """Simulate a ride without hands."""
    system = whipple(p, speed, **INITIAL_STATE)
    start: Mapping[str, Any] = {"parameters": p, "speed": speed}
    return run(system, T_END, state=system.state(), output=SAMPLES, source=start)


def lagrange(made: Run) -> Iterable[Finding]:
    """Return the centres of mass of the four bodies by Lagrange's equations, integrated by scipy."""
    p, speed = made.source["parameters"], made.source["speed"]
    rates = np.array([INITIAL_STATE["lean_rate"], INITIAL_STATE["steer_rate"], speed])
    c, c_dot = whipple_lagrange.state(p, INITIAL_STATE["lean"], INITIAL_STATE["steer"], rates)

    def derivative(_: float, y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[8:], whipple_lagrange.accelerations(p, y[:8], y[8:])])

    times, start = made.motion.t, np.concatenate([c, c_dot])
    found = solve_ivp(derivative, (0.0, T_END), start, "DOP853", times, rtol=RTOL, atol=RTOL).y[:8].T
    known = np.array([whipple_lagrange.places(p, c)[0] for c in found]) * PAPER_TO_MODEL
    ours = np.stack([made.motion.com(body) for body in BODIES], axis=1)
    yield judged(THEORY, "centres of mass", np.abs(ours - known).max() / np.abs(known).max(), DIFFERENCE_MAX)
    lean = np.arcsin(made.motion.rotation("frame")[:, 2, 1])
    yield judged(THEORY, "lean [rad]", np.abs(lean - found[:, 3]).max(), DIFFERENCE_MAX)
    yield judged(THEORY, "steer [rad]", np.abs(made.motion.angle("steer") - found[:, 5]).max(), DIFFERENCE_MAX)


def eigenvalues(made: Run) -> Iterable[Finding]:
    """Compare eigenvalues of the straight run at the published speeds."""
    rows = cases.read("bicycle_eigenvalues")["reference"]["values"]
    found = general.eigenvalues(whipple, made.source["parameters"], np.array([row["v"] for row in rows]))
    known = np.array([[complex(*pair) for pair in row["eigenvalues"]] for row in rows])
    away = [np.abs(a[:, None] - b).min(axis=0).max() / np.abs(b).max() for a, b in zip(found, known, strict=True)]
    yield judged(REFERENCE, f"eigenvalues at {len(rows)} speeds", max(away), START_ROUNDING)
