"""From a mechanism and a state to the result of a run."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..base.checks import SMALLEST, floats, number, shown
from ..base.errors import InputError
from ..base.progress import Progress
from ..equations.compiled import Compiled, Switches, compile_system
from ..equations.tables import signals_of
from ..integrators.dop853 import DOP853
from ..integrators.method import Method
from ..mechanism.measures import Condition, check_members
from ..mechanism.mechanism import Mechanism
from ..mechanism.signals import check_interval
from ..mechanism.state import State
from ..results.record import MOST_NUMBERS
from ..results.run_result import RunResult
from .job import Job
from .own_functions import own_forces

SHORTEST = 1e-12  # of the time, the shortest run: a hundred of the shortest steps
MOST_STEPS = 1e9  # of a run: days


def run_to(
    system: Mechanism,
    start: State,
    t_end: float,
    switches: Switches,
    *,
    method: Method | None = None,
    rtol: float = 1e-8,
    output: int | Sequence[float] | None = None,
    stop_when: Condition | None = None,
    as_built: float | None = None,
    progress: bool | str | None = None,
) -> RunResult:
    """Integrate a mechanism from a state to ``t_end``; arguments and errors as `mbsd3d.simulate`."""
    method = DOP853() if method is None else method
    check_kinds(method, rtol, stop_when)
    t_end = number(t_end, "simulate: t_end")
    check_steps(method, t_end - start.t, "simulate")
    check_own_steps(system, t_end - start.t)
    check_end(t_end, start.t)
    if stop_when is not None:
        check_members(system, stop_when.measure, "simulate: stop_when")
    compiled = compile_system(system, () if stop_when is None else (stop_when.measure,), switches)
    check_signals(compiled, start.t, t_end)
    width = 19 * len(system.bodies) + compiled.model.state.size + 2 * compiled.model.row.size
    times = output_times(output, start.t, t_end, method, width)
    job = Job(compiled, start, t_end, times, method, rtol, stop_when, as_built)
    return job.run(Progress(f"simulate to {t_end:g} s", start.t, t_end, progress))


def check_end(t_end: float, t_start: float) -> float:
    """The end of a run, or a ValueError for one that no step fits in."""
    if not t_end - t_start > max(SHORTEST * abs(t_end), SMALLEST):
        raise InputError(
            f"simulate: t_end = {t_end:g} s does not lie after the start at {t_start:g} s; give a later time"
        )
    return t_end


def check_steps(method: Method, span: float, what: str) -> None:
    """ValueError for steps [s] so short that a time span [s] takes days."""
    name, longest = ("max_step", method.max_step) if method.dt is None else ("dt", method.dt)
    if (steps := span / longest) > MOST_STEPS:
        raise InputError(f"{what}: {name} = {longest:g} s needs {steps:.2g} steps; give a longer one")


def check_own_steps(system: Mechanism, span: float) -> None:
    """ValueError for a custom force that asks for steps so short that a time span [s] takes days."""
    for _, force in own_forces(system):
        if (steps := span / force.max_step) > MOST_STEPS:
            raise InputError(
                f"force '{system.name(force)}' (CustomForce): max_step = {force.max_step:g} s needs {steps:.2g} steps; "
                "give a longer one, or the times at which the force jumps"
            )


def check_kinds(method: Any, rtol: float, stop_when: Any) -> None:
    """ValueError for arguments of the wrong kind or range."""
    if Method not in type(method).__mro__ and (isinstance(method, type) or not isinstance(method, Method)):
        names = "DOP853, RK4, GeneralizedAlpha, RadauIIA, Kinematic"
        raise InputError(f"simulate: method {shown(method)} is unknown; give one of {names}, e.g. DOP853()")
    if not 1e-13 <= number(rtol, "simulate: rtol") <= 0.1:
        raise InputError(f"simulate: rtol {rtol:g} is outside 1e-13 ... 0.1; give a number in this range")
    if stop_when is not None and not isinstance(stop_when, Condition):
        raise InputError(
            f"simulate: stop_when {shown(stop_when)} is not a condition; write e.g. measures.angle(hinge) > 1.2"
        )


def check_system(system: Any, what: str) -> None:
    """ValueError for anything but a System."""
    if not isinstance(system, Mechanism):
        raise InputError(f"{what}: {shown(system)} is not a System; give System(bodies=[...], joints=[...])")


def check_state(state: Any, what: str) -> None:
    """ValueError for a start that is not a State."""
    if state is not None and not isinstance(state, State):
        held = isinstance(getattr(state, "state", None), State)  # by an equilibrium
        remedy = "its .state" if held else "one of system.assemble() or solution.final"
        raise InputError(f"{what}: state {shown(state)} is not a State; give {remedy}")


def check_signals(compiled: Compiled, t_start: float, t_end: float) -> None:
    """Tables must cover the run."""
    for part, signal in signals_of(compiled.system):
        check_interval(signal, t_start, t_end, f"'{compiled.system.name(part)}'")


def check_room(samples: int, width: int, what: str = "simulate: output") -> None:
    """ValueError for more samples than memory has room for."""
    if samples * width > MOST_NUMBERS:
        raise InputError(
            f"{what}: {shown(samples)} samples of {width} numbers are more than memory holds; give at most "
            f"{MOST_NUMBERS // width}"
        )


def output_times(output: Any, t_start: float, t_end: float, method: Method, width: int = 1) -> np.ndarray | None:
    """Sample times, or None for every accepted step; a sample has ``width`` numbers."""
    if output is None:
        return None if method.order else np.linspace(t_start, t_end, 201)  # no steps of its own
    if isinstance(output, int | np.integer) and not isinstance(output, bool):
        if output < 2:
            raise InputError(f"simulate: output = {shown(output)} samples; give at least 2, or an array of times")
        check_room(int(output), width)
        return np.linspace(t_start, t_end, int(output))
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


def accelerations_at(
    system: Mechanism, start: State, switches: Switches | None = None, as_built: float | None = None
) -> RunResult:
    """Accelerations and reactions at one state, as a result with a single sample."""
    compiled = compile_system(system, (), switches)
    return Job(compiled, start, start.t, np.array([start.t]), DOP853(), 1e-8, None, as_built).evaluate()
