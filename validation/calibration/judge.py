"""One run of the calibration: the true error against the statements of certificate and estimate."""

import time
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from mbsd3d import Solution, simulate
from mbsd3d.errors import MbsError
from validation.calibration.families import FAMILIES
from validation.calibration.problem import Place, Problem
from validation.calibration.settings import Settings, draw

WRONG_ERROR = 1e-2  # [1] of the scale: error that needs a warning; the limit of `estimate` too
RIGHT_RTOL_RATIO = 10.0  # [1] of rtol: error with which no run may fail
WARNING_TEXTS = ("not looked for", "never armed", "rad in a step")
"""In notes, and in the line of the global error, of what may make the motion wrong."""


@dataclass(frozen=True)
class Record:
    """Settings of a run, its true error, and the statements of certificate and estimate.

    ``error``: largest over samples and readings, over their scales (1 rad, a length): decides whether it is wrong;
    ``relative``: with the scales raised to the largest true value, as tolerances are: decides whether it is right;
    ``estimate``: "agrees", "warns", "raises" or "none" (rtol leaves no room); ``stopped``: why there is no result.
    """

    family: str
    seed: int
    method: str
    kind: str
    settings: str
    rtol: float
    fixed: bool
    unsure: bool
    error: float = np.nan
    relative: float = np.nan
    worst: str = ""
    passed: bool = False
    failures: tuple[str, ...] = ()
    warned: bool = False
    estimate: str = "none"
    estimated: float = 0.0
    stopped: str = ""
    seconds: float = 0.0

    @property
    def wrong(self) -> bool:
        """Return whether the run is wrong by more than a hundredth of a scale."""
        return not self.stopped and not self.error <= WRONG_ERROR

    @property
    def silent(self) -> bool:
        """Return whether the run is wrong without a warning by certificate or estimate."""
        return self.wrong and not self.warned and self.estimate != "warns"

    @property
    def right(self) -> bool:
        """Return whether the run is right to ten times its tolerance."""
        return not self.stopped and self.error <= WRONG_ERROR and self.relative <= RIGHT_RTOL_RATIO * self.rtol

    @property
    def false_alarm(self) -> bool:
        """Return whether certificate or estimate reject a right run; an estimate may give ten times the true error.

        Its poses are those of the reference points, which may be farther out than what is read.
        """
        warned = self.estimate == "raises" or (self.estimate == "warns" and self.error <= 0.1 * WRONG_ERROR)
        return self.right and not self.unsure and (not self.passed or warned)


def cases(runs: int, seed: int, names: Sequence[str]) -> list[tuple[str, int]]:
    """Return (family, seed) of so many runs: families alternate, seeds increase from the first."""
    return [(names[k % len(names)], seed + k // len(names)) for k in range(runs)]


def generator(family: str, seed: int) -> np.random.Generator:
    """Return the random numbers of a problem and its settings."""
    return np.random.default_rng([seed, zlib.crc32(family.encode())])


def build(family: str, seed: int) -> tuple[Problem, Settings]:
    """Return the problem of a seed, and its settings."""
    rng = generator(family, seed)
    problem = FAMILIES[family](Place(rng))
    return problem, draw(rng, problem)


def examine(family: str, seed: int) -> Record:
    """Run a problem, compare it with its truth, and read its certificate."""
    begun = time.perf_counter()
    problem, settings = build(family, seed)
    what = Record(
        family, seed, settings.name, settings.kind, settings.shown, settings.rtol, settings.method.dt is not None,
        problem.unsure,
    )  # fmt: skip
    try:
        runs = march(problem, settings.method, settings.rtol, settings.output)
    except MbsError as reason:
        return replace(what, stopped=str(reason).split("\n")[0], seconds=time.perf_counter() - begun)
    error, relative, worst = compare(problem, runs)
    return replace(
        what, error=error, relative=relative, worst=worst, **verdict(runs), seconds=time.perf_counter() - begun
    )


def march(problem: Problem, method: Any, rtol: float, output: Any = None) -> list[Solution]:
    """Simulate the runs from stop to stop, and on to the end."""
    state, runs, begin = problem.start(), [], 0.0
    for condition in (*(stop[0] for stop in problem.stops), None):
        if begin >= problem.t_end:
            break
        times = output[output > begin] if isinstance(output, np.ndarray) else output
        run = simulate(
            problem.system, problem.t_end, state=state, method=method, rtol=rtol, output=times, stop_when=condition,
            progress=False,
        )  # fmt: skip
        runs.append(run)
        begin = run.final.t
        state = problem.restart(run.final)
    return runs


def compare(problem: Problem, runs: Sequence[Solution]) -> tuple[float, float, str]:
    """Return (error over the scale, error over scale or largest true value, worst reading)."""
    found: list[tuple[float, float, str]] = [(0.0, 0.0, "")]
    for run in runs:
        for reading in problem.readings:
            true = np.asarray(reading.truth(run.t), float)
            computed = np.asarray(reading.computed(run), float)
            off = np.abs(computed - true)
            off = off if off.ndim == 1 else np.linalg.norm(off, axis=-1)
            scale = run.compiled.model.length if reading.scale is None else reading.scale
            size = max(scale, float(np.abs(true).max(initial=0.0)))
            worst = float(np.max(off, initial=0.0)) if np.isfinite(off).all() else np.inf
            found.append((worst / scale, worst / size, reading.name))
    for run, (_, due, rate) in zip(runs, problem.stops, strict=False):
        late = abs(run.final.t - due)
        found.append((late * rate, late / problem.t_end, f"stop at {due:.4g} s"))
    error, _, name = max(found, key=lambda x: x[0])
    return error, max(x[1] for x in found), name


def verdict(runs: Sequence[Solution]) -> dict[str, Any]:
    """Return the worst statement of certificate and estimate on successive runs."""
    certificates = [run.certificate for run in runs]
    failures = tuple(text for certificate in certificates for text in certificate.failures)
    outcomes, sizes = zip(*(ask(run) for run in runs), strict=True)
    estimated = sum(sizes)  # each run is estimated from its own start: errors add
    order = ("warns", "raises", "none", "agrees")
    estimate = "warns" if estimated > WRONG_ERROR else min(outcomes, key=order.index)
    return {
        "passed": not failures,
        "failures": failures,
        "warned": any(warns(certificate) for certificate in certificates),
        "estimate": estimate,
        "estimated": estimated,
    }


def warns(certificate: Any) -> bool:
    """Return whether a certificate fails or warns of a wrong motion."""
    notes = (*certificate.notes, certificate.global_error)
    return not certificate.passed or any(text in note for note in notes for text in WARNING_TEXTS)


def ask(run: Solution) -> tuple[str, float]:
    """Return the statement of `estimate` and its error; 0 where it finds none."""
    if run.record.steps and not run.record.kinematic and run.record.method.dt is None and run.record.rtol < 3.2e-12:
        return "none", 0.0
    try:
        error = run.estimate().error
    except MbsError:
        return "raises", 0.0
    if error is None:
        return "none", 0.0
    return ("agrees" if error <= WRONG_ERROR else "warns"), error
