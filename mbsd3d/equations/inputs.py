"""Values of inputs in the tables of the kernels, set during a run, and their history after it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..kernels.kinds import SPLINE
from .compiled import Compiled

History = Mapping[str, Sequence[tuple[float, float]]]  # name -> (time [s], value) of the start and of every change


def starts(compiled: Compiled) -> dict[str, float]:
    """Return the value of each input at the start, by name."""
    return {place.name: place.start for place in compiled.inputs}


def with_own_inputs(compiled: Compiled) -> Compiled:
    """Return the same tables with signal numbers that `set_input` may overwrite."""
    return replace(compiled, model=compiled.model._replace(term_data=compiled.model.term_data.copy()))


def set_input(compiled: Compiled, name: str, value: float) -> None:
    """Set the value of all terms of an input."""
    for place in compiled.inputs:
        if place.name == name:
            compiled.model.term_data[compiled.model.term["first"][place.term]] = place.factor * value


def with_history(compiled: Compiled, history: History) -> Compiled:
    """Return the tables with each input as a step function; at the time of a change its old value holds.

    So the sample at the end of a slice, taken before the change, meets the equations it was made with.
    """
    term, data = compiled.model.term.copy(), list(compiled.model.term_data)
    for place in compiled.inputs:
        if place.name not in history:
            continue
        times, values = np.array(history[place.name], float).reshape(-1, 2).T
        breaks = np.append(np.nextafter(times, np.inf), np.inf)
        pieces = np.zeros((values.size, 4))
        pieces[:, 3] = place.factor * values
        term["kind"][place.term], term["first"][place.term] = SPLINE, len(data)
        data += [values.size, *breaks, *pieces.ravel()]
        term["end"][place.term] = len(data)
    return replace(compiled, model=compiled.model._replace(term=term, term_data=np.array(data, float)))
