"""Global error estimate: the same run at tighter settings, and the growth rate of the difference."""

from dataclasses import replace
from typing import Any

import numpy as np

from ..base.errors import InputError, IntegrationError
from ..integrators.method import Method
from ..results.certificate import Certificate, certificate_of
from ..results.checks.between_stages import unseen_parts
from ..results.result import RunResult
from .repeat import options_to_repeat, repeat

GROWTH_SAMPLES_MIN = 8  # for a fit of the growth by a straight line
FACTORS = 32.0, 4.0  # of tolerances; some methods and positions do not let the first be reached
PROBES, FINER = 2000, 4  # steps of the run that looks for what lies between stages, and times those of the run
GOLDEN = 0.5 * (1.0 + np.sqrt(5.0))  # the factor that is farthest from all ratios of small numbers
SEEN, ROUNDING = 10.0, 1e-9  # times the error otherwise found, and the least, which tell that it met something new


def estimate(solution: RunResult) -> Certificate:
    """Return the certificate with a global error estimate: the same run at tighter settings, compared at the samples.

    Adaptive: rtol/32 and rtol/1024 (rtol/4 and rtol/16 where these cannot be reached); fixed steps: dt/2 and dt/4;
    driven poses: half and a quarter apart. The error is the largest difference of positions (model lengths) and angles
    [rad] from the tightest run; the order is log2 of the ratio of successive differences for fixed steps, and the
    exponent of rtol for adaptive ones. Where a `CustomForce` was not looked for between the stages of steps, or a
    `Sine` is faster than fixed steps, one more run looks at other times, several times as many (`probed`).
    """
    record = solution.record
    if not record.steps or not solution.t.size:
        raise InputError("estimate: nothing was integrated, or no sample kept; estimate a run of `simulate`")
    if record.method.dt is None and not record.kinematic and record.rtol < 3.2e-12:
        raise InputError(
            f"estimate: rtol {record.rtol:g} leaves no room for a tighter run; estimate at 1e-11 or looser"
        )
    finer, finest, factor = tighter(solution)
    last = distances(finer, finest)
    error, first, second = (
        float(x.max(initial=0.0)) for x in (distances(solution, finest), distances(solution, finer), last)
    )
    order = float(np.log(first / second) / np.log(factor)) if 0.0 < second < first else None
    known = replace(
        certificate_of(solution),
        error=error,
        order=order,
        doubling=doubling_time(np.intersect1d(finer.t, finest.t), last),
    )
    unseen = unseen_parts(solution)
    missed = float(distances(solution, probed(solution)).max(initial=0.0)) if unseen else 0.0
    if not missed > max(SEEN * error, ROUNDING):
        return known
    note = f"stages at other times find another motion, {missed:.2g} away: {' or '.join(map(repr, unseen))} acts there"
    return replace(known, error=max(error, missed), order=None, notes=(*known.notes, note))


def tighter(solution: RunResult) -> tuple[RunResult, RunResult, float]:
    """Return the run refined once and twice, and the factor of the refinement."""
    fixed = solution.record.kinematic or solution.record.method.dt is not None
    for factor in (2.0,) if fixed else FACTORS:
        try:
            return refined(solution, factor), refined(solution, factor**2), factor
        except IntegrationError as error:
            failed = error
    raise failed


def refined(solution: RunResult, factor: float) -> RunResult:
    """Repeat the run with a tolerance, or a step, smaller by a factor."""
    record, options = solution.record, options_to_repeat(solution)
    method = options.method
    if record.kinematic:
        apart = (solution.final.t - solution.start.t) / record.steps
        finer = replace(options, method=changed_method(method, max_step=min(method.max_step, apart) / factor))
    elif method.dt is None:
        finer = replace(options, rtol=max(options.rtol / factor, 1e-13))
    else:
        finer = replace(options, method=changed_method(method, dt=method.dt / factor))
    return repeat(solution, options=finer)


def changed_method(method: Method, **changes: float) -> Method:
    """Return a method, which is a frozen dataclass, with other settings."""
    settings: Any = method
    return replace(settings, **changes)


def probed(solution: RunResult) -> RunResult:
    """Repeat the run with stages at other times: steps shorter by an irrational factor, and many of them."""
    method, span = solution.record.method, solution.final.t - solution.start.t
    step = span / (GOLDEN * max(FINER * solution.record.steps, PROBES))
    finer = changed_method(method, **{"max_step" if method.dt is None else "dt": step})
    return repeat(solution, options=replace(options_to_repeat(solution), method=finer))


def distances(one: RunResult, other: RunResult) -> np.ndarray:
    """Return the largest difference of poses over the bodies (times,): in model lengths and in radians.

    At the times that both have: runs with events have those of theirs besides.
    """
    _, i, j = np.intersect1d(one.t, other.t, return_indices=True)
    a, b = one.arrays["q"][i], other.arrays["q"][j]
    shift = np.linalg.norm(a[..., :3] - b[..., :3], axis=-1) / one.compiled.model.length
    turn = 2.0 * np.minimum(
        np.linalg.norm(a[..., 3:] - b[..., 3:], axis=-1), np.linalg.norm(a[..., 3:] + b[..., 3:], axis=-1)
    )
    return np.maximum(shift, turn).max(axis=1, initial=0.0)


def doubling_time(t: np.ndarray, apart: np.ndarray) -> float | None:
    """Return the time [s] in which the distance of two runs doubles, if it grows like exp(k t), not like a power of t.

    Read where it is neither rounding nor as large as the motion itself, and only where it grows a thousandfold.
    """
    grown = np.maximum.accumulate(apart)
    use = (grown > 1e-13) & (grown < 0.03) & (t > t[0])
    if use.sum() < GROWTH_SAMPLES_MIN or grown[use][-1] < 1e3 * grown[use][0]:
        return None
    x, y = t[use] - t[0], np.log(grown[use])
    slopes = [np.polynomial.polynomial.polyfit(base, y, 1, full=True) for base in (x, np.log(x))]
    (exponential, (misfit, *_)), (_, (power_misfit, *_)) = slopes
    return float(np.log(2.0) / exponential[1]) if misfit[0] < power_misfit[0] else None
