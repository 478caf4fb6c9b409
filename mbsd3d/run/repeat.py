"""Repeat a run: with its options or changed ones, and with inputs that change when they did."""

from dataclasses import replace

import numpy as np

from ..base.errors import InputError
from ..equations.compiled import History, starts
from ..mechanism.mechanism import Mechanism
from ..mechanism.state import State
from ..results.record import RunOptions
from ..results.result import RunResult
from .segments import Segments
from .simulation import check_end, check_state, output_times, run_to


def options_to_repeat(run: RunResult) -> RunOptions:
    """Return the options of a run with its sample times as output, and without a condition to stop."""
    return replace(run.record.options, output=np.unique(run.t), stop_when=None, progress=None)


def repeat(
    run: RunResult, t_end: float | None = None, start: State | None = None, options: RunOptions | None = None
) -> RunResult:
    """Integrate the system of a run again, from its start to its end with its options where None is given.

    Inputs that were set to other values than their own change at the same times as in the run.
    """
    t_end, start = run.final.t if t_end is None else t_end, run.start if start is None else start
    options = options or options_to_repeat(run)
    check_state(start, "solution.again")
    if has_changed_inputs(run):
        return repeat_segments(run.system, start, t_end, options, run.record.inputs)
    return run_to(run.system, start, t_end, options)


def has_changed_inputs(run: RunResult) -> bool:
    """Return whether an input was ever set to another value than the one it starts with."""
    own = starts(run.compiled)
    return any(change[1:] != (own[name],) for name, changes in run.record.inputs.items() for change in changes)


def repeat_segments(system: Mechanism, start: State, t_end: float, options: RunOptions, history: History) -> RunResult:
    """Integrate from a state to ``t_end`` [s] with the changes of inputs of a history.

    ValueError for what a run in segments cannot do: stop at a condition, or keep every step.
    """
    refused = [name for name in ("stop_when", "progress") if getattr(options, name) is not None]
    if refused or options.output is None:
        raise InputError(
            f"solution.again: a run in segments is not repeated with {', '.join(refused) or 'output=None'}; "
            "give t_end, state, output (a count or times), method, rtol, as_built or teaching switches"
        )
    t_end = check_end(t_end, start.t, "solution.again")
    times = output_times(options.output, start.t, t_end, options.method)
    wanted = set() if times is None else set(times.tolist())
    run = Segments(system, start, options)
    changes: dict[float, list[tuple[str, tuple[float, ...]]]] = {
        t: [] for t in sorted({*wanted, t_end, *(t for x in history.values() for t, *_ in x)})
    }
    for name, values in history.items():
        for change in values:
            changes[change[0]].append((name, change[1:]))
    for t, found in changes.items():
        if start.t < t <= t_end:
            run.keep = t in wanted or run.t == start.t  # the first segment has the start too
            run.advance(t)
        if t <= t_end:
            for name, course in found:
                run.set(name, *course)
    made = run.solution()
    chosen = np.isin(made.t, list(wanted))
    arrays = {name: array[chosen] for name, array in made.arrays.items()}
    return replace(made, arrays=arrays, record=replace(made.record, inputs=dict(history)))
