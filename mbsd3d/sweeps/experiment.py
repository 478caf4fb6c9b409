"""One cell of a sweep: build, simulate, measure; its outcome is plain numbers and text."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ..api.simulation import simulate
from ..api.solution import Solution
from ..api.system import System
from ..base.checks import short_repr
from ..base.concurrency import one_thread
from ..base.errors import InputError


class MisuseError(InputError):
    """Error for functions given to `sweep` that do not fit, in every cell alike."""


class Outcome(NamedTuple):
    """Result of a cell: numbers, or the text of its error."""

    values: dict[str, float | list[float]]
    error: str = ""
    settings: str = ""  # method and rtol of the run
    misuse: bool = False


@dataclass(frozen=True)
class Experiment:
    """Work of every cell; it is pickled for the workers."""

    build: Callable[..., System | tuple[System, Mapping[str, Any]]]
    measure: Callable[[Solution], Any]
    run: Mapping[str, Any] | Callable[..., Mapping[str, Any]] = field(default_factory=dict)

    def __call__(self, parameters: dict[str, Any]) -> Outcome:
        """Run one cell; its errors become part of the outcome."""
        try:
            with one_thread():
                solution = self.solve(parameters)
                values = self.numbers(self.measure(solution))
        except MisuseError as error:
            return Outcome({}, str(error), misuse=True)
        except (Exception, SystemExit) as error:
            return Outcome({}, f"{type(error).__name__}: {error}")
        return Outcome(values, "", f"{solution.record.method}, rtol {solution.record.rtol:g}")

    def solve(self, parameters: dict[str, Any]) -> Solution:
        """Build and simulate the system of a cell."""
        system, settings = self.settings(parameters)
        solution = simulate(system, **settings)
        if (solution.record.stopped_by or "").startswith("interrupted"):
            raise KeyboardInterrupt  # the run stood in the main thread and has seen it first
        return solution

    def settings(self, parameters: dict[str, Any]) -> tuple[System, dict[str, Any]]:
        """Build the system of a cell; return it and the arguments of simulate."""
        built = self.build(**parameters)
        system, own = built if isinstance(built, tuple) and len(built) == 2 else (built, {})
        if not isinstance(system, System) or not isinstance(own, Mapping):
            raise MisuseError(
                f"build returned {type(built).__name__}; return a System, or (System, dict of arguments of simulate)"
            )
        run = self.run(**parameters) if callable(self.run) else self.run
        if not isinstance(run, Mapping):
            raise MisuseError(f"run returned {type(run).__name__}; return a dict of arguments of simulate")
        settings = {"progress": False, **run, **own}
        check_settings(settings)
        if "t_end" not in settings:
            raise MisuseError("the cells have no t_end; give run=dict(t_end=...), or return it from build")
        return system, settings

    def numbers(self, measured: Any) -> dict[str, float | list[float]]:
        """Return the result of measure as floats and lists of floats by name."""
        if not isinstance(measured, Mapping):
            name = getattr(self.measure, "__name__", "value")
            measured = {name if name.isidentifier() else "value": measured}
        for key in measured:
            if not isinstance(key, str) or not key or key == "error":
                raise MisuseError(f"measure returned a value named {key!r}; name values by texts other than 'error'")
        return {key: plain(key, value) for key, value in measured.items()}


def plain(name: str, value: Any) -> float | list[float]:
    """Return a float or a list of floats; raise MisuseError for anything else."""
    try:
        array = np.asarray(value)
        real = array.dtype.kind in "fiub"
    except (TypeError, ValueError):
        real = False
    if not real or array.ndim > 1:
        found = f"an array of shape {value.shape}, type {value.dtype}" if isinstance(value, np.ndarray) else repr(value)
        raise MisuseError(
            f"measure returned '{name}' = {found}; return a number, a 1-D array of numbers, or a dict of them"
        )
    return array.astype(float).tolist()


def check_settings(settings: Mapping[str, Any]) -> None:
    """Raise MisuseError for an argument that simulate does not have."""
    known = settings_of_simulate()
    for name in settings:
        if name not in known:
            raise MisuseError(f"simulate has no argument {name!r}; it has {', '.join(known)}")


@cache
def settings_of_simulate() -> tuple[str, ...]:
    """Return the names of the arguments of simulate but for the system; Python takes as long to find them as to build a
    body.
    """
    return tuple(name for name in inspect.signature(simulate).parameters if name != "system")


def check_parameters(function: Callable, what: str, parameters: Mapping[str, Any], caller: str = "sweep") -> None:
    """Raise ValueError where the function does not take exactly these parameters."""
    if not callable(function):
        raise InputError(f"{caller}: {what} {short_repr(function)} is not a function; give one")
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        return  # a function without a signature says itself what it wants
    try:
        signature.bind(**parameters)
    except TypeError as error:
        takes = ", ".join(signature.parameters) or "none"
        given = ", ".join(parameters) or "none"
        raise InputError(f"{caller}: {what} does not take the parameters {given} ({error}); it takes {takes}") from None
