"""A candidate climbed from coarse to fine, and the time until an error is reached, without extrapolation."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from mbsd3d import IntegrationError
from validation.benchmark.candidates import Candidate, Run
from validation.benchmark.problems import Poses
from validation.twins.base import NotComparable

TARGETS = (1e-4, 1e-6, 1e-8)  # errors: distances over the length of the model, and angles in radians
DOMINATED, CLIMBED = 4.0, 4
"""After so many settings one gives up where a rival took a quarter of the time for less error."""
REPEATS, SHORT = 3, 0.03  # runs of a setting, while they take less than so many seconds together
NOISE = 3.0  # an error that rises by this factor at a finer setting has met rounding


class Point(NamedTuple):
    """One setting: seconds of the time loop, error at the end."""

    setting: float
    seconds: float
    error: float


@dataclass(frozen=True)
class Climb:
    """What was measured of a candidate.

    ``engine, label``: as of `Candidate`; ``points``: from coarse to fine; settings that failed are left out;
    ``failed``: how many settings ended in an error or in numbers that are not finite; ``note``: why there are no
    points, or what the last failure said.
    """

    engine: str
    label: str
    points: tuple[Point, ...] = ()
    failed: int = 0
    note: str = field(default="")


class Reached(NamedTuple):
    """Time to an error: seconds, and "" (measured), "<" (the coarsest setting does better) or ">" (never reached)."""

    seconds: float
    bound: str
    label: str = ""


def climb(
    candidate: Candidate, truth: Poses, length: float, limit: float, rivals: Sequence[Point] = ()
) -> tuple[Climb, Callable[[float], Run] | None]:
    """Run a candidate until its error is below all targets, a run takes more than half of ``limit``, or a rival wins.

    Returns what was measured and the function that runs it again.
    """
    try:
        run = candidate.start()
    except NotComparable as error:
        return Climb(candidate.engine, candidate.label, note=str(error)), None
    points: list[Point] = []
    failed, note = 0, ""
    for setting in candidate.ladder:
        began = time.perf_counter()
        try:
            seconds, end = least(run, setting)
        except (NotComparable, IntegrationError) as error:
            failed, note = failed + 1, str(error)
            if time.perf_counter() - began > limit / 2:
                note += f"; given up, that took {time.perf_counter() - began:.1f} s"
                break
            continue
        points.append(Point(float(setting), seconds, end.distance(truth, length)))
        if finished(points, limit, rivals):
            break
    return Climb(candidate.engine, candidate.label, tuple(points), failed, note), run


def least(run: Callable[[float], Run], setting: float) -> Run:
    """The fastest of a few runs, or one that is long."""
    runs = [run(setting)]
    while len(runs) < REPEATS and sum(done.seconds for done in runs) < SHORT:
        runs.append(run(setting))
    return min(runs, key=lambda done: done.seconds)


def finished(points: list[Point], limit: float, rivals: Sequence[Point]) -> bool:
    """Whether a finer setting tells nothing more."""
    _, seconds, error = points[-1]
    best = min(point.error for point in points)
    below = len(points) > 1 and all(point.error <= TARGETS[-1] for point in points[-2:])
    rounding = best <= TARGETS[-1] and error > NOISE * best
    beaten = any(rival.seconds * DOMINATED < seconds and rival.error < error for rival in rivals)
    return below or rounding or seconds > limit / 2 or (beaten and len(points) >= CLIMBED)


def in_bounds(climbed: Climb, target: float) -> int:
    """First point from which on all errors are at most ``target``."""
    inside = len(climbed.points)
    while inside and climbed.points[inside - 1].error <= target:
        inside -= 1
    return inside


def time_to(climbed: Climb, target: float) -> Reached:
    """Time to an error, on the line between the two settings around it in logarithms.

    The finer one is the coarsest from which on all errors are in bounds: no error that is small by chance.
    """
    points, label, inside = climbed.points, climbed.label, in_bounds(climbed, target)
    if inside == len(points):
        return Reached(max((point.seconds for point in points), default=0.0), ">", label)
    if inside == 0:
        return Reached(points[0].seconds, "<", label)
    coarse, fine = points[inside - 1], points[inside]
    share = np.log(coarse.error / target) / np.log(coarse.error / max(fine.error, 1e-300))
    seconds = np.exp((1 - share) * np.log(coarse.seconds) + share * np.log(fine.seconds))
    return Reached(float(min(seconds, fine.seconds)), "", label)


def best(climbs: Sequence[Climb], target: float) -> Reached | None:
    """The fastest candidate; if none comes so far, the longest time that was tried. None without any measurement."""
    found = [time_to(climbed, target) for climbed in climbs if climbed.points]
    met = [reached for reached in found if reached.bound != ">"]
    if met:
        return min(met, key=lambda reached: reached.seconds)
    return max(found, key=lambda reached: reached.seconds, default=None)


def around(climbed: Climb, target: float) -> list[int]:
    """Places of the points that decide the time to an error."""
    inside = in_bounds(climbed, target)
    return [k for k in (inside - 1, inside) if 0 <= k < len(climbed.points)]


def retimed(climbed: Climb, seconds: dict[int, float]) -> Climb:
    """With the least time of some points."""
    points = [
        point._replace(seconds=min(point.seconds, seconds.get(k, np.inf))) for k, point in enumerate(climbed.points)
    ]
    return replace(climbed, points=tuple(points))
