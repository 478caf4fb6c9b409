"""What every twin asks of its start and of a run."""

from numbers import Real
from typing import Any

import numpy as np

from mbsd3d import State
from mbsd3d.extend import (
    check_quaternions,
    check_signals,
    check_state,
    check_system,
    driven_coordinates,
    load_state,
    new_data,
    pack,
    unmet,
    worst_joint,
)

from .base import label

MET = 1e-8  # [1] of the model's length, or rad: the joints of a start; what `mbsd3d.simulate` asks for


def start_of(system: Any, state: State | None, engine: str) -> State:
    """The start, a state of this system; a ValueError says what is wrong with either."""
    check_system(system, engine)
    check_state(state, engine)
    start = system.state() if state is None else state
    pack(system.lowered, start)
    check_quaternions(system, start)
    return start


def check_met(system: Any, start: State) -> None:
    """ValueError naming the joint, driver or gear that a start does not meet, as `mbsd3d.simulate` judges it."""
    compiled = system.lowered
    data = new_data(compiled.model)  # no loads: functions of forces need not be compiled
    known = driven_coordinates(compiled, start.t) if start.coordinates is None else start.coordinates
    load_state(compiled, data, State(start.t, start.q, start.v, start.z, known))
    missed = unmet(compiled, data, start.v, MET)
    if missed is not None:
        residual, unit = missed
        worst = int(np.argmax(np.abs(residual) * compiled.model.row["scale"]))
        part = label(system, system.joints[compiled.row_joint[worst]])
        raise ValueError(
            f"state: {part} is off by {worst_joint(compiled, residual)[1]:.3g} {unit}; "
            "start from system.state() or system.assemble()"
        )


def check_run(engine: str, system: Any, start: float, t_end: float, steps: int, samples: int) -> None:
    """ValueError if samples do not lie on steps, the end is not after the start, or tables do not reach it."""
    whole = all(isinstance(n, int | np.integer) and not isinstance(n, bool) and n >= 1 for n in (steps, samples))
    if not whole or steps % samples:
        raise ValueError(
            f"{engine}: {samples!r} samples do not divide {steps!r} steps; give a whole number >= 1 of samples, and of "
            "steps a multiple of it"
        )
    if not isinstance(t_end, Real) or not start < t_end < np.inf:
        raise ValueError(
            f"{engine}: a run that is not after the start: t_end = {t_end} s does not lie after the start at "
            f"{start:g} s; give a later, finite one"
        )
    check_signals(system.lowered, start, t_end)
