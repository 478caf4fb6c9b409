"""Error against wall time of one problem: a search over all candidates, then the best of each engine in turns."""

import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from mbsd3d.extend import compile_system, one_thread

from .candidates import CONSTRAINTS, PEERS, Run, of_peer, ours
from .ladders import TARGETS, Climb, Point, Reached, around, best, climb, retimed
from .problems import Problem

LEAST, MOST = 0.6, 8.0  # s: bounds of what the longest run of a peer may take
PATIENCE = 210.0  # the same in times of ours to the middle error; half of that is tried for sure: a ratio of 100
PATIENCE_ON_CHAINS = 20.0  # where peers are as fast
TURNS, TURN_SECONDS = 5, 3.0  # rounds in which the engines take turns, and what they may take altogether


@dataclass(frozen=True)
class Row:
    """One problem, measured.

    Attributes
    ----------
    name, family : str
        Of the problem.
    bodies, rows : int
        Size of the system as built.
    climbs : tuple of Climb
        Everything that was tried.
    """

    name: str
    family: str
    bodies: int
    rows: int
    climbs: tuple[Climb, ...]

    def of(self, engine: str) -> list[Climb]:
        """The candidates of an engine."""
        return [climbed for climbed in self.climbs if climbed.engine == engine]

    def reached(self, engine: str, target: float, only: str = "") -> Reached | None:
        """Time of an engine to an error, of candidates whose label has the word; None where it was not compared."""
        return best([climbed for climbed in self.of(engine) if only in climbed.label], target)

    def ratio(self, peer: str, target: float, only: str = "") -> tuple[float, str] | None:
        """Times of a peer to an error over ours, with its bound: ">" if the peer never got there."""
        mine, theirs = self.reached("mbsd3d", target), self.reached(peer, target, only)
        if mine is None or theirs is None or mine.bound == ">":
            return None
        # "<" of ours makes the ratio greater than said, "<" of the peer's makes it smaller
        return theirs.seconds / mine.seconds, theirs.bound or (">" if mine.bound == "<" else "")

    def agreement(self, peer: str) -> float | None:
        """Least error of a peer: how far its limit is from the truth; None where it was not compared."""
        return min((point.error for climbed in self.of(peer) for point in climbed.points), default=None)

    def to_dict(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def from_dict(data: dict[str, Any]) -> Row:
    """Back from JSON."""
    climbs = [{**x, "points": tuple(Point(*point) for point in x["points"])} for x in data["climbs"]]
    return Row(**{**data, "climbs": tuple(Climb(**x) for x in climbs)})


def measure(problem: Problem, say: Callable[[str], None] = lambda text: None) -> Row:
    """Search, then time the best candidates of all engines in turns on one thread."""
    compiled = compile_system(problem.system)
    with one_thread():
        truth, length = problem.truth(), float(compiled.model.length)
        say("mbsd3d")
        own = ours(problem)
        own.start()(own.ladder[0])  # its kernels are compiled before anything is timed
        found = [climb(own, truth, length, 60.0)]
        middle = best([found[0][0]], TARGETS[1])
        patience = PATIENCE_ON_CHAINS if problem.family == "chain" else PATIENCE
        limit = float(np.clip(patience * (middle.seconds if middle else 0.0), LEAST, MOST))
        for peer in PEERS:
            rivals: dict[bool, list[Point]] = {True: [], False: []}  # constraints compete with constraints
            for candidate in of_peer(problem, peer):
                say(f"{peer}: {candidate.label}")
                alike = rivals[CONSTRAINTS in candidate.label]
                found.append(climb(candidate, truth, length, limit, alike))
                alike += found[-1][0].points
        say("in turns")
        climbs = in_turns(found)
    rows = sum(row.n_rows for joint in problem.system.joints for row in joint.rows())
    return Row(problem.name, problem.family, len(problem.system.bodies), rows, climbs)


def in_turns(found: list[tuple[Climb, Callable[[float], Run] | None]]) -> tuple[Climb, ...]:
    """Time the points that decide once more, engine after engine, round by round, and keep the least times."""
    climbs = [climbed for climbed, _ in found]
    wanted: dict[tuple[int, int], float] = {}
    for engine in ("mbsd3d", *PEERS):
        mine = [climbed for climbed in climbs if climbed.engine == engine]
        for target in TARGETS:
            reached = best(mine, target)
            for i, climbed in enumerate(climbs):
                if reached is not None and climbed.engine == engine and climbed.label == reached.label:
                    wanted |= {(i, k): climbed.points[k].seconds for k in around(climbed, target)}
    began = time.perf_counter()
    for _ in range(TURNS):
        for i, k in wanted:
            if time.perf_counter() - began + wanted[i, k] > TURN_SECONDS:
                continue  # a long run needs no repetition, and there are other problems
            run = found[i][1]
            wanted[i, k] = min(wanted[i, k], run(climbs[i].points[k].setting).seconds)
    return tuple(
        retimed(climbed, {k: seconds for (j, k), seconds in wanted.items() if j == i})
        for i, climbed in enumerate(climbs)
    )
