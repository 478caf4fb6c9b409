"""Runs that several demos need."""

from mbsd3d import Solution, System, simulate
from mbsd3d.mechanism.measures import Measure


def half_swing(system: System, rate: Measure, about: float, **settings: object) -> Solution:
    """From the first moment at which a rate turns negative to the next one at which it turns positive.

    ``about``: a time of the order of the half swing [s]; the search ends after a hundred of them.
    """
    settings = {"rtol": 1e-13, **settings}
    top = simulate(system, 100 * about, stop_when=rate < 0, **settings)
    start = top.final
    on = simulate(system, start.t + 0.1 * about, state=start, output=2, **settings)
    rest = simulate(system, start.t + 100 * about, state=on.final, stop_when=rate > 0, **settings)
    return simulate(system, rest.final.t, state=start, output=2, **settings)
