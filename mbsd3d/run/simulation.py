"""From a mechanism and a state to the result of a run."""

from functools import lru_cache
from typing import Any

import numpy as np

from ..base.checks import MAGNITUDE_MIN, floats, number, short_repr
from ..base.errors import InputError
from ..base.progress import Progress
from ..equations.compiled import Compiled, compile_system, modes_at
from ..equations.tables import signals_of
from ..integrators.method import Method
from ..mechanism.lock import Lock
from ..mechanism.measures import check_members
from ..mechanism.mechanism import Mechanism
from ..mechanism.signals import check_interval
from ..mechanism.state import State
from ..results.record import MOST_NUMBERS, RunOptions
from ..results.result import RunResult
from .initial_checks import own_forces
from .job import Job
from .switched_run import SwitchedRun, modes_at_rest, switching

RUN_SHARE_MIN = 1e-12  # [1] of the time, the shortest run: a hundred of the shortest steps
MOST_STEPS = 1e9  # of a run: days


def run_to(system: Mechanism, start: State, t_end: float, options: RunOptions) -> RunResult:
    """Integrate a mechanism from a state to ``t_end`` [s]; errors as `mbsd3d.simulate`."""
    compiled, t_end, times = check_run(system, start, t_end, options)
    if compiled.modes:
        return SwitchedRun(system, start, t_end, times, options).run()
    job = Job(compiled, start, t_end, times, options)
    return job.run(Progress(f"simulate to {t_end:g} s", start.t, t_end, options.progress))


def check_run(
    system: Mechanism, start: State, t_end: float, options: RunOptions
) -> tuple[Compiled, float, np.ndarray | None]:
    """Check the arguments of a run; return the arrays of the system, the end [s] and the output times [s]."""
    t_end = check_end(t_end, start.t, "simulate")
    check_steps(options.method, t_end - start.t, "simulate")
    check_own_steps(system, t_end - start.t)
    stop_when = options.stop_when
    if stop_when is not None:
        check_members(system, stop_when.measure, "simulate: stop_when")
    modes_at(system, start)  # refuses those of other parts
    compiled = compile_system(system, () if stop_when is None else (stop_when.measure,), options.switches)
    check_signals(compiled, start.t, t_end)
    width = 19 * len(system.bodies) + compiled.model.state.size + 2 * compiled.model.row.size
    return compiled, t_end, output_times(options.output, start.t, t_end, options.method, width)


def check_end(t_end: Any, t_start: float, what: str) -> float:
    """Return the end of a run [s]; ValueError for an end that leaves no room for a step."""
    t_end = number(t_end, f"{what}: t_end")
    if not t_end - t_start > max(RUN_SHARE_MIN * abs(t_end), MAGNITUDE_MIN):
        raise InputError(
            f"{what}: t_end = {t_end:g} s is not later than the start time {t_start:g} s; give a later time"
        )
    return t_end


def check_steps(method: Method, span: float, what: str) -> None:
    """Refuse steps [s] so short that a time span [s] takes days."""
    name, longest = ("max_step", method.max_step) if method.dt is None else ("dt", method.dt)
    if (steps := span / longest) > MOST_STEPS:
        raise InputError(f"{what}: {name} = {longest:g} s needs {steps:.2g} steps; give a longer one")


def check_own_steps(system: Mechanism, span: float) -> None:
    """Refuse a custom force that asks for steps so short that a time span [s] takes days."""
    for _, force in own_forces(system):
        if (steps := span / force.max_step) > MOST_STEPS:
            raise InputError(
                f"force '{system.name(force)}' (CustomForce): max_step = {force.max_step:g} s needs {steps:.2g} steps; "
                "give a longer one, or the times at which the force jumps"
            )


def check_system(system: Any, what: str) -> None:
    """Refuse anything but a System."""
    if not isinstance(system, Mechanism):
        raise InputError(f"{what}: {short_repr(system)} is not a System; give System(bodies=[...], joints=[...])")


def check_state(state: Any, what: str, needed: bool = False) -> None:
    """Raise a ValueError for anything but a State, or None where it is not ``needed``."""
    if (needed or state is not None) and not isinstance(state, State):
        held = isinstance(getattr(state, "state", None), State)  # by an equilibrium
        remedy = "its .state" if held else "one of system.assemble() or solution.final"
        raise InputError(f"{what}: state {short_repr(state)} is not a State; give {remedy}")


def check_signals(compiled: Compiled, t_start: float, t_end: float) -> None:
    """Check that tables cover the run."""
    for part, signal in signals_of(compiled.system):
        check_interval(signal, t_start, t_end, f"'{compiled.system.name(part)}'")


def check_room(samples: int, width: int, what: str = "simulate: output") -> None:
    """Refuse more samples than memory has room for."""
    if samples * width > MOST_NUMBERS:
        raise InputError(
            f"{what}: {short_repr(samples)} samples of {width} numbers are more than memory holds; give at most "
            f"{MOST_NUMBERS // width}"
        )


def output_times(output: Any, t_start: float, t_end: float, method: Method, width: int = 1) -> np.ndarray | None:
    """Sample times, or None for every accepted step; a sample has ``width`` numbers."""
    if output is None:
        return None if method.order else np.linspace(t_start, t_end, 201)  # no steps of its own
    if isinstance(output, int | np.integer) and not isinstance(output, bool):
        if output < 2:
            raise InputError(f"simulate: output = {short_repr(output)} samples; give at least 2, or an array of times")
        check_room(int(output), width)
        return even_times(t_start, t_end, int(output)).copy()
    if isinstance(output, float):
        raise InputError(
            f"simulate: output = {output}: give a count, or an array of times, e.g. numpy.arange(0, t_end, {output})"
        )
    times = floats(output, "simulate: output", "a count or an array of times")
    check_room(times.size, width)
    if times.ndim != 1 or not times.size or (np.diff(times) <= 0).any():
        raise InputError("simulate: output: give a count, or finite times in strictly increasing order")
    if times[0] < t_start or times[-1] > t_end:
        raise InputError(
            f"simulate: output times {times[0]:g} ... {times[-1]:g} s leave the run {t_start:g} ... {t_end:g} s"
        )
    return times


@lru_cache(maxsize=8)
def even_times(t_start: float, t_end: float, count: int) -> np.ndarray:
    """Return equally spaced times; cells of a sweep ask for the same."""
    return np.linspace(t_start, t_end, count)


def accelerations_at(system: Mechanism, start: State, options: RunOptions) -> RunResult:
    """Return accelerations and reactions at one state, as a result with a single sample.

    What sticks by a row at rest holds or slips as it would at the start of a run.
    """
    modes = modes_at(system, start)
    if any(isinstance(part, Lock) and part.sticks for part in switching(system)):
        modes = modes_at_rest(system, start, options)
    compiled = compile_system(system, (), options.switches, modes)
    return Job(compiled, start, start.t, np.array([start.t]), options).evaluate()
