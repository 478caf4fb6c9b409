"""What was aimed at, against what was measured, and how the cost grows with the size."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from .candidates import CONSTRAINTS, PEERS
from .precision import Row

MIDDLE = 1e-6  # the error the goals speak of


class Goal(NamedTuple):
    """``peer`` is to take at least ``factor`` times as long as we do, on every problem that ``applies``.

    ``only`` keeps candidates of the peer with this word: its joints as constraints, as ours are.
    """

    text: str
    peer: str
    factor: float
    applies: Callable[[Row], bool]
    only: str = ""


class Verdict(NamedTuple):
    """The problem with the least ratio, and whether the goal is met; "open" where a bound does not decide."""

    goal: Goal
    problem: str
    ratio: float
    bound: str
    met: str


def family(name: str, least: int = 0, most: int = 10**9) -> Callable[[Row], bool]:
    """Problems of a family with so many bodies."""
    return lambda row: row.family == name and least <= row.bodies <= most


GOALS = (
    *(Goal("loops", peer, 100.0, family("loop")) for peer in PEERS),
    Goal("tops", "MuJoCo", 20.0, family("top")),
    Goal("tops", "Exudyn", 200.0, family("top")),
    Goal("tops, by constraints", "Exudyn", 200.0, family("top"), CONSTRAINTS),
    Goal("bicycle", "Exudyn", 50.0, family("bicycle")),
    Goal("free body", "MuJoCo", 10.0, family("free body")),
    Goal("free body", "Exudyn", 2.0, family("free body")),
    Goal("chains up to 30", "MuJoCo", 0.5, family("chain", most=30)),
    Goal("chains from 150", "MuJoCo", 1.0, family("chain", least=150)),
)


def verdicts(rows: Sequence[Row]) -> list[Verdict]:
    """All goals of which a problem was measured."""
    found = []
    for goal in GOALS:
        ratios = [(row.ratio(goal.peer, MIDDLE, goal.only), row.name) for row in rows if goal.applies(row)]
        known = [(value, bound, name) for ratio, name in ratios if ratio for value, bound in [ratio]]
        if not known:
            continue
        ratio, bound, name = min(known)
        found.append(Verdict(goal, name, ratio, bound, judge(ratio, bound, goal.factor)))
    return found


def judge(ratio: float, bound: str, factor: float) -> str:
    """ "met", "MISSED", or "open" where the ratio is a bound on the wrong side of the factor."""
    if ratio >= factor:
        return "open" if bound == "<" else "met"
    return "open" if bound == ">" else "MISSED"


def growth(rows: Sequence[Row], engine: str, prefix: str) -> tuple[float, int, int] | None:
    """(p, least, most) of time ~ bodies^p at the middle error, over problems named "prefix n", from 30 bodies on."""
    found = []
    for row in rows:
        reached = row.reached(engine, MIDDLE) if row.name.rsplit(" ", 1)[0] == prefix and row.bodies >= 30 else None
        if reached is not None and not reached.bound:
            found.append((row.bodies, reached.seconds))
    if len(found) < 2:
        return None
    bodies, seconds = np.array(sorted(found), float).T
    return float(np.polyfit(np.log(bodies), np.log(seconds), 1)[0]), int(bodies[0]), int(bodies[-1])
