"""A run in slices run again: with inputs that change when they did."""

from collections.abc import Sequence
from functools import partial
from typing import Any

from ..equations.compiled import Switches
from ..equations.inputs import History
from ..integrators.method import Method
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from ..results.run_result import RunResult
from ..run.slices import Slices
from .solution import Solution


def played(result: RunResult) -> Solution:
    """The solution of a ride: to run it again is to repeat its slices and its changes of inputs."""
    return Solution.of(result, partial(replay, result.record.inputs))


def replay(
    history: History,
    system: Mechanism,
    t_end: float,
    *,
    state: State,
    output: Sequence[float],
    method: Method,
    rtol: float,
    as_built: float | None = None,
    **switches: Any,
) -> Solution:
    """`mbsd3d.simulate` with inputs that change when they did."""
    run = Slices(system, state, Switches(**switches), method, rtol, as_built, ())
    changes = {t: [] for t in sorted({*map(float, output), t_end, *(t for x in history.values() for t, _ in x)})}
    for name, values in history.items():
        for t, value in values:
            changes[t].append((name, value))
    wanted = set(map(float, output))
    for t, values in changes.items():
        if state.t < t <= t_end:
            run.keep = t in wanted
            run.advance(t)
        if t <= t_end:
            for name, value in values:
                run.set(name, value)
    return Solution.of(run.solution(), partial(replay, history))
