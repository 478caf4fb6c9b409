"""A run in slices run again: with inputs that change when they did."""

from collections.abc import Sequence
from dataclasses import fields, replace
from functools import partial
from typing import Any

import numpy as np

from ..base.checks import number, shown
from ..base.errors import InputError
from ..equations.compiled import History, Switches
from ..integrators.method import Method
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from ..results.run_result import RunResult
from ..run.segments import Slices
from ..run.simulation import check_end, output_times
from .solution import Solution

SWITCHES = tuple(x.name for x in fields(Switches))


def played(result: RunResult) -> Solution:
    """The solution of a ride: to run it again is to repeat its slices and its changes of inputs."""
    return Solution.of(result, partial(replay, result.record.inputs))


def replay(
    history: History,
    system: Mechanism,
    t_end: float,
    *,
    state: State,
    output: int | Sequence[float],
    method: Method,
    rtol: float,
    as_built: float | None = None,
    **others: Any,
) -> Solution:
    """`mbsd3d.simulate` with inputs that change when they did; it knows the ends of slices, but not steps or stops."""
    switches = Switches(**{name: others.pop(name) for name in SWITCHES if name in others})
    if others or output is None:
        raise InputError(
            f"solution.again: a ride in slices is not repeated with {', '.join(others) or 'output=None'}; give t_end, "
            f"state, output (a count or times), method, rtol, as_built, {', '.join(SWITCHES)}"
        )
    if not isinstance(state, State):
        raise InputError(f"solution.again: state {shown(state)} is not a State; give one, e.g. ride.start")
    t_end = check_end(number(t_end, "solution.again: t_end"), state.t)
    wanted = set(output_times(output, state.t, t_end, method).tolist())
    run = Slices(system, state, switches, method, rtol, as_built, ())
    changes = {t: [] for t in sorted({*wanted, t_end, *(t for x in history.values() for t, _ in x)})}
    for name, values in history.items():
        for t, value in values:
            changes[t].append((name, value))
    for t, values in changes.items():
        if state.t < t <= t_end:
            run.keep = t in wanted or run.t == state.t  # the first slice has the start too
            run.advance(t)
        if t <= t_end:
            for name, value in values:
                run.set(name, value)
    made = run.solution()
    chosen = np.isin(made.t, list(wanted))
    made = replace(made, arrays={name: array[chosen] for name, array in made.arrays.items()})
    return Solution.of(made, partial(replay, history))
