"""What every twin asks of its start and of a run."""

from typing import Any

import numpy as np

from mbsd3d import State
from mbsd3d.evaluation import pack
from mbsd3d.simulation import check_signals, check_state


def start_of(system: Any, state: State | None, engine: str) -> State:
    """The start, a state of this system; a ValueError says what is wrong with it."""
    check_state(state, engine)
    start = system.state() if state is None else state
    pack(system.lowered, start)
    return start


def check_run(engine: str, system: Any, start: float, t_end: float, steps: int, samples: int) -> None:
    """ValueError if samples do not lie on steps, the end is not after the start, or tables do not reach it."""
    for count, name in ((steps, "steps"), (samples, "samples")):
        if isinstance(count, bool) or not isinstance(count, int | np.integer) or count < 1:
            raise ValueError(f"{engine}: {name} = {count!r}; give a whole number >= 1")
    if steps % samples:
        raise ValueError(f"{engine}: {samples} samples do not divide {steps} steps; give a multiple")
    if not start < t_end < np.inf:
        raise ValueError(f"{engine}: t_end {t_end:g} s is not after the start at {start:g} s; give a later time")
    check_signals(system.lowered, start, t_end)
