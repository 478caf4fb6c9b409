"""Error against run time of one problem: every candidate from coarse to fine, then the best of each engine in turns.

The time to an error is read between two runs; nothing is extrapolated.
"""

import json
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import IntegrationError
from mbsd3d.errors import InputError
from mbsd3d.extend import one_thread, write_atomically
from validation.benchmark.candidates import CONSTRAINTS_LABEL, ENGINES, PEERS, Candidate, Run, of_peer, ours
from validation.benchmark.problems import Poses, Problem
from validation.machine import installed
from validation.twins.base import NotComparable

PACKAGES = ("mbsd3d", "mujoco-core", "exudyn", "numpy", "numba")
TARGET_ERRORS = (1e-4, 1e-6, 1e-8)  # [1] distances over the length of the model, and angles [rad]
DOMINATED_RATIO, CLIMB_POINTS_MIN = 4.0, 4
"""After so many settings one gives up where a rival took a quarter of the time for less error."""
REPEAT_COUNT, SHORT_RUN_SECONDS = 3, 0.03  # runs of a setting, while they take less than so many seconds together
ROUNDING_RISE_RATIO = 3.0  # [1] rise of the error at a finer setting that shows rounding


class Point(NamedTuple):
    """Result of one setting: seconds of the time loop, error at the end."""

    setting: float
    seconds: float
    error: float


@dataclass(frozen=True)
class Climb:
    """Errors and run times [s] of one candidate, one pair per tolerance."""

    engine: str
    label: str
    points: tuple[Point, ...] = ()  # from coarse to fine, without settings that failed
    failed: int = 0  # settings that ended in an error or in numbers that are not finite
    note: str = ""  # why there are no points, or what the last failure said


class Reached(NamedTuple):
    """Time to an error: seconds, and "" (measured), "<" (the coarsest setting is better) or ">" (never reached)."""

    seconds: float
    bound: str
    label: str = ""


def climb(
    candidate: Candidate, truth: Poses, length: float, limit: float, rivals: Sequence[Point] = ()
) -> tuple[Climb, Callable[[float], Run] | None]:
    """Run a candidate until its error is below all targets, a run takes more than half of ``limit``, or a rival is
    faster.

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
    """Return the fastest of a few runs, or one that is long."""
    runs = [run(setting)]
    while len(runs) < REPEAT_COUNT and sum(done.seconds for done in runs) < SHORT_RUN_SECONDS:
        runs.append(run(setting))
    return min(runs, key=lambda done: done.seconds)


def finished(points: list[Point], limit: float, rivals: Sequence[Point]) -> bool:
    """Return whether a finer setting gives no further information."""
    _, seconds, error = points[-1]
    best = min(point.error for point in points)
    below = len(points) > 1 and all(point.error <= TARGET_ERRORS[-1] for point in points[-2:])
    rounding = best <= TARGET_ERRORS[-1] and error > ROUNDING_RISE_RATIO * best
    beaten = any(rival.seconds * DOMINATED_RATIO < seconds and rival.error < error for rival in rivals)
    return below or rounding or seconds > limit / 2 or (beaten and len(points) >= CLIMB_POINTS_MIN)


def in_bounds(climbed: Climb, target: float) -> int:
    """Return the first point from which on all errors are at most ``target``."""
    inside = len(climbed.points)
    while inside and climbed.points[inside - 1].error <= target:
        inside -= 1
    return inside


def time_to(climbed: Climb, target: float) -> Reached:
    """Return the time to an error [s], interpolated between the two settings around it in logarithms.

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
    """Return the fastest candidate; if none reaches the error, the longest time that was tried; None without any
    measurement.
    """
    found = [time_to(climbed, target) for climbed in climbs if climbed.points]
    met = [reached for reached in found if reached.bound != ">"]
    if met:
        return min(met, key=lambda reached: reached.seconds)
    return max(found, key=lambda reached: reached.seconds, default=None)


def retimed(climbed: Climb, seconds: dict[int, float]) -> Climb:
    """Return the results of a candidate with the least time of some points."""
    points = [
        point._replace(seconds=min(point.seconds, seconds.get(k, np.inf))) for k, point in enumerate(climbed.points)
    ]
    return replace(climbed, points=tuple(points))


PEER_SECONDS_MIN, PEER_SECONDS_MAX = 0.6, 8.0  # s: bounds of what the longest run of a peer may take
PEER_TIME_RATIO = 210.0  # [1] of the time of mbsd3d to the middle error; half of that is tried for sure: a ratio of 100
PEER_TIME_RATIO_ON_CHAINS = 20.0  # [1] on chains, where peers are as fast
ROUND_COUNT, ROUND_SECONDS = 5, 3.0  # rounds in which the engines take turns, and what they may take altogether


@dataclass(frozen=True)
class Row:
    """Measurements of one problem."""

    name: str
    family: str
    bodies: int  # of the system as built
    rows: int
    climbs: tuple[Climb, ...]  # everything that was tried

    def of(self, engine: str) -> list[Climb]:
        """Return the candidates of an engine."""
        return [climbed for climbed in self.climbs if climbed.engine == engine]

    def reached(self, engine: str, target: float, only: str = "") -> Reached | None:
        """Return the time of an engine to an error [s], of candidates whose label has the word; None where it was not
        compared.
        """
        return best([climbed for climbed in self.of(engine) if only in climbed.label], target)

    def ratio(self, peer: str, target: float, only: str = "") -> tuple[float, str] | None:
        """Return the ratio of a peer's time to an error to that of mbsd3d, with its bound: ">" if the peer never
        reaches it.
        """
        mine, theirs = self.reached("mbsd3d", target), self.reached(peer, target, only)
        if mine is None or theirs is None or mine.bound == ">":
            return None
        # "<" of ours makes the ratio greater than said, "<" of the peer's makes it smaller
        return theirs.seconds / mine.seconds, theirs.bound or (">" if mine.bound == "<" else "")

    def agreement(self, peer: str) -> float | None:
        """Return the least error of a peer, the distance of its limit from the truth; None where it was not
        compared."""
        return min((point.error for climbed in self.of(peer) for point in climbed.points), default=None)


def from_dict(data: dict[str, Any]) -> Row:
    """Return the row of JSON data."""
    climbs = [{**x, "points": tuple(Point(*point) for point in x["points"])} for x in data["climbs"]]
    return Row(**{**data, "climbs": tuple(Climb(**x) for x in climbs)})


def identity() -> dict[str, Any]:
    """Return the properties that rows of one run have in common."""
    return {"versions": [installed(package) for package in PACKAGES], "targets": list(TARGET_ERRORS)}


def save(path: Path, rows: Sequence[Row], machine: str, complete: bool) -> None:
    """Write all rows as JSON; ValueError if the folder cannot be written."""
    data = {"machine": machine, **identity(), "complete": complete, "rows": [asdict(row) for row in rows]}
    write_atomically(path, json.dumps(data, indent=1).encode())


def load(path: Path) -> list[Row]:
    """Load the rows of a file of `save`; raise ValueError if it is missing or something else."""
    if not path.is_file():
        raise InputError(f"{path}: not found; measure first, python -m validation.benchmark --out {path.parent}")
    try:
        return [from_dict(row) for row in json.loads(path.read_text(encoding="utf-8"))["rows"]]
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: no rows of a benchmark ({error}); move it away, or give another --out") from None


def measure(problem: Problem, say: Callable[[str], None] = lambda text: None) -> Row:
    """Measure all candidates of a problem, then time the best of all engines in turns on one thread."""
    with one_thread():
        truth, length = problem.truth(), float(problem.system.lowered.model.length)
        say("mbsd3d")
        own = ours(problem)
        own.start()(own.ladder[0])  # its kernels are compiled before anything is timed
        found = [climb(own, truth, length, 60.0)]
        middle = best([found[0][0]], TARGET_ERRORS[1])
        patience = PEER_TIME_RATIO_ON_CHAINS if problem.family == "chain" else PEER_TIME_RATIO
        limit = float(np.clip(patience * (middle.seconds if middle else 0.0), PEER_SECONDS_MIN, PEER_SECONDS_MAX))
        for peer in PEERS:
            rivals: dict[bool, list[Point]] = {True: [], False: []}  # constraints compete with constraints
            for candidate in of_peer(problem, peer):
                say(f"{peer}: {candidate.label}")
                alike = rivals[CONSTRAINTS_LABEL in candidate.label]
                found.append(climb(candidate, truth, length, limit, alike))
                alike += found[-1][0].points
        say("in turns")
        climbs = in_turns(found)
    rows = sum(row.n_rows for joint in problem.system.joints for row in joint.rows())
    return Row(problem.name, problem.family, len(problem.system.bodies), rows, climbs)


def in_turns(found: list[tuple[Climb, Callable[[float], Run] | None]]) -> tuple[Climb, ...]:
    """Time the decisive points once more, engine after engine, round by round, and keep the least times."""
    climbs = [climbed for climbed, _ in found]
    wanted: dict[tuple[int, int], float] = {}
    for engine in ENGINES:
        mine = [climbed for climbed in climbs if climbed.engine == engine]
        for target in TARGET_ERRORS:
            reached = best(mine, target)
            for i, climbed in enumerate(climbs):
                if reached is not None and climbed.engine == engine and climbed.label == reached.label:
                    inside, points = in_bounds(climbed, target), climbed.points
                    wanted |= {(i, k): points[k].seconds for k in (inside - 1, inside) if 0 <= k < len(points)}
    began = time.perf_counter()
    for _ in range(ROUND_COUNT):
        for i, k in wanted:
            run = found[i][1]
            if run is None or time.perf_counter() - began + wanted[i, k] > ROUND_SECONDS:
                continue  # a long run needs no repetition, and there are other problems
            wanted[i, k] = min(wanted[i, k], run(climbs[i].points[k].setting).seconds)
    return tuple(
        retimed(climbed, {k: seconds for (j, k), seconds in wanted.items() if j == i})
        for i, climbed in enumerate(climbs)
    )
