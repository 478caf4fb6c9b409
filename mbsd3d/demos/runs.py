"""Runs that several demos need."""

from typing import Any

from mbsd3d import Solution, State, System, simulate
from mbsd3d.mechanism.measures import Measure


def next_turn(
    system: System, rate: Measure, about: float, *, rising: bool, state: State | None = None, **settings: Any
) -> Solution:
    """Run from a turning point until a rate that is now positive (``rising``) or negative changes sign.

    ``about``: a time of the order of the swing [s]; the search begins after a tenth and ends after a hundred of them.
    """
    settings = {"rtol": 1e-13, **settings}
    start = state or system.state()
    on = simulate(system, start.t + 0.1 * about, state=start, output=2, **settings)
    turned = rate < 0 if rising else rate > 0
    rest = simulate(system, start.t + 100 * about, state=on.final, stop_when=turned, **settings)
    return simulate(system, rest.final.t, state=start, output=2, **settings)


def half_swing(system: System, rate: Measure, about: float, *, up: bool = True, **settings: Any) -> Solution:
    """Run from one turning point to the next, of a rate that is positive at the start (``up``) or negative."""
    first = simulate(system, 100 * about, stop_when=rate < 0 if up else rate > 0, **{"rtol": 1e-13, **settings})
    return next_turn(system, rate, about, rising=not up, state=first.final, **settings)
