"""`Study`: measured values of a mechanism with parameters, and their derivatives with respect to these."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..api.simulation import start_of
from ..api.solution import Solution
from ..api.system import System
from ..base.checks import number, short_repr
from ..base.concurrency import one_thread
from ..base.errors import GradientError, InputError, MbsError, checks_method_arguments
from ..base.progress import Progress
from ..base.style import Result, Told
from ..equations.compiled import Compiled, Switches
from ..integrators.dop853 import DOP853
from ..integrators.method import Method
from ..mechanism.state import State
from ..results.record import RunOptions
from ..run.derivatives import (
    OFFSETS,
    Lowered,
    Parameter,
    RecordedJob,
    Replay,
    SampleDerivatives,
    check_differentiable,
    difference,
    same_structure,
)
from ..run.simulation import check_run
from .experiment import Experiment, MisuseError, Outcome, check_parameters, check_settings
from .grids import check_names
from .store import PointCells, PointLedger, identity_of_study, point_key, run_stamp, stamp

if TYPE_CHECKING:
    from xarray import Dataset

SHOWN_MAX = 6  # [1] parameters that a study names in a console

STEP_SHARE = 5e-4  # [1] of a parameter p: step of its differences, which err by 3e-13 for 1/p, as by rounding
SIZE_SHARE_MIN = 0.1  # [1] of the typical value of a parameter: what counts as its size near zero
STEP_REDUCTIONS = (1.0, 0.1, 0.01)  # [1] of that step, where `build` refuses a model beside the point
MOTION_MAX = 1e-3  # [1 or rad] of bodies by such a step, over which a measure is differenced: it errs by 3e-14
ESTIMATE_MAX = 1e-3  # [1] of the largest change of a value by any parameter: a gradient with more is refused
VANISHING_SHARE = 1e-12  # [1] of the largest value, by a change of a parameter by its size: that is no change
ESTIMATE_FACTOR = 2.0  # [1] of the difference of two runs, whose errors may partly be the same
ESTIMATE_ROUNDING = 1e-12  # [1] of a value, over its parameter: what rounding leaves of a difference
RTOL_RATIO, RTOL_MIN = 0.01, 1e-13  # [1] of the tolerance, of the second run: over it where there is no smaller one
HOP_RATIO = (
    20.0  # [1] of the time over which a touch is passed, of the second run: what it errs by shows in the estimate
)
REFINED_STEP_SHARE = 0.5  # [1] of a fixed step, of the second run


@dataclass(frozen=True, eq=False, repr=False)
class Gradient(Result):
    """Values of a study at a point, their derivatives, and how exact these are.

    ``estimate`` [unit of a value per unit of a parameter] is twice the difference from the derivatives of a second run
    with a hundredth of ``rtol`` (half of a fixed step), and not less than rounding leaves.

    Examples
    --------
    >>> from mbsd3d import Body, Study, System
    >>> def stone(speed):
    ...     return System([Body("stone", 1.0, (0.1, 0.1, 0.1), velocity=(speed, 0, 3.0), omega=(0, 0, 0))])
    >>> study = Study(stone, {"speed": 2.0}, lambda solution: {"r": solution.position("stone")[-1]}, {"t_end": 0.5})
    >>> found = study.gradient()
    >>> found.names, found.jac.round(9).tolist(), found.error < 1e-9
    (('r[0]', 'r[1]', 'r[2]'), [[0.5], [0.0], [0.0]], True)
    """

    parameters: dict[str, float]
    names: tuple[str, ...]  # of the values; those of an array by number
    values: np.ndarray  # (n,)
    jac: np.ndarray  # (n, k) derivative of value i by parameter j
    estimate: np.ndarray  # (n, k) of its error
    size: np.ndarray  # (k,) of the parameters
    units: Mapping[str, str]

    @property
    def error(self) -> float:
        """Return the largest estimate, relative to the largest change of its value by any parameter."""
        return float(relative_errors(self.jac, self.estimate, self.size).max(initial=0.0))

    @property
    def verdict(self) -> str:
        """Return the comparison of the two runs in a sentence."""
        return f"derivatives agree within {self.error:.1g} of the largest of each value with a run of a finer tolerance"

    @property
    def dataset(self) -> "Dataset":
        """Return values, derivatives and estimates as an xarray.Dataset with dimensions "value" and "parameter"."""
        import xarray

        coordinates = {
            "value": list(self.names), "parameter": list(self.parameters),
            "at": ("parameter", np.array(list(self.parameters.values()))),
            "unit": ("value", [self.units.get(name.partition("[")[0], "") for name in self.names]),
            "parameter_unit": ("parameter", [self.units.get(name, "") for name in self.parameters]),
        }  # fmt: skip
        two = ("value", "parameter")
        found = {"values": ("value", self.values), "jac": (two, self.jac), "estimate": (two, self.estimate)}
        return xarray.Dataset(found, coordinates, {"verdict": self.verdict})

    def __str__(self) -> str:
        width = max(len(name) for name in (*self.parameters, *self.names))
        lines = [" " * width + "".join(f"{name:>14}" for name in ("value", *self.parameters))]
        for name, value, row in zip(self.names, self.values, self.jac, strict=True):
            lines.append(f"{name:<{width}}{value:14.6g}" + "".join(f"{x:14.6g}" for x in row))
        return "\n".join([*lines, self.verdict])


def relative_errors(jac: np.ndarray, estimate: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return estimates (n, k) over the largest change of their value, parameters in units of their size (k,)."""
    largest = np.abs(jac * size).max(axis=1, initial=0.0, keepdims=True)
    return np.divide(estimate * size, largest, out=np.zeros_like(jac), where=largest > 0.0)


class Values(dict):
    """Values that a measure returned, by name, with their numbers side by side."""

    @cached_property
    def vector(self) -> np.ndarray:
        """Return all numbers (n,)."""
        return np.concatenate([np.zeros(0), *(np.atleast_1d(np.array(x, float)) for x in self.values())])

    @property
    def labels(self) -> tuple[str, ...]:
        """Return a name for each number."""
        found: list[str] = []
        for name, value in self.items():
            found += [f"{name}[{i}]" for i in range(len(value))] if isinstance(value, list) else [name]
        return tuple(found)


class Change(NamedTuple):
    """What is measured beside a point, by the number of steps in a parameter; at the point itself by 0."""

    parameter: int
    step: float
    beside: dict[int, Values]


@dataclass(frozen=True)
class SystemExperiment(Experiment):
    """A point at which nothing runs: build and measure a system."""

    def __call__(self, parameters: dict[str, Any]) -> Outcome:
        """Measure the system of a point; errors become part of the outcome."""
        try:
            with one_thread():
                measured: Any = self.measure(self.built(parameters))  # type: ignore[arg-type]  # of a system here
                return Outcome(self.numbers(measured))
        except MisuseError as error:
            return Outcome({}, str(error), misuse=True)
        except (Exception, SystemExit) as error:
            return Outcome({}, f"{type(error).__name__}: {error}")

    def built(self, parameters: dict[str, Any]) -> System:
        """Return the system of a point."""
        found = self.build(**parameters)
        system = found[0] if isinstance(found, tuple) and found else found
        if not isinstance(system, System):
            raise MisuseError(f"Study: build returned {type(found).__name__}; return a System")
        return system


@checks_method_arguments
class Study(Told):
    """A mechanism with parameters: what is measured of a run, as a function for `scipy.optimize`, with derivatives.

    The run itself is differentiated step by step, exactly up to the tolerance of the run. ``build``,
    ``measure`` and ``run`` are those of `sweep`, and may be any Python; only differences of their numbers are taken.

    Parameters
    ----------
    build : callable
        ``build(**parameters)`` returns a System, or (System, dict of arguments of `simulate`), of which numbers may
        depend on the parameters: ``state``, ``t_end``, output times, the value of ``stop_when``. Its structure may not.
    x0 : mapping
        Parameter -> value: the order of vectors x, the point of `gradient`, and the sizes of the parameters.
    measure : callable
        ``measure(solution)`` returns a number, a 1-D array of numbers, or a dict of them by name.
    run : mapping or callable or None
        Arguments of `simulate`, or ``run(**parameters)`` that returns them. None: nothing runs, and ``measure(system)``
        is differenced itself, e.g. an equilibrium or eigenvalues by `linearize`.
    x_scale : mapping
        Parameter -> typical value [unit of the parameter], for those that are zero in ``x0`` (otherwise 1) or small.
    units : mapping
        Parameter or value -> unit, for the dataset.
    progress : bool, "lines" or None
        Show the progress of derivatives; None = on a terminal, after two seconds.
    ledger : path or None
        SQLite file that keeps what is found at every point, values and derivatives: the same study with the same ledger
        finds it there, and so do `fit`, `uncertainty` and any optimiser that were interrupted. The code of functions is
        not compared: after a change of it, give another file.

    Raises
    ------
    InputError
        Before anything runs: a parameter that ``build`` does not take, an unknown argument of `simulate`, the ledger of
        another study or one that cannot be opened. Later: a part that has no derivative, by name.
    GradientError
        For a derivative that does not exist or cannot be trusted: a kink or a jump, a structure that changes, an event
        that is grazed, a measure that is not a number, a run that cannot be repeated; in `gradient` also two runs that
        disagree, as after chaos or a contact at a loose tolerance.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Revolute, Study, System, measures
    >>> def pendulum(length, mass):
    ...     bob = Body("bob", mass, (0.05, 0.05, 0.05), position=(length, 0, 0), omega=(0, 0, 0))
    ...     hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
    ...     return System([bob], [hinge]), {"stop_when": measures.position(bob, axis=(1, 0, 0)) < 0.0}
    >>> run = {"t_end": 5.0, "rtol": 1e-10}
    >>> study = Study(pendulum, {"length": 0.7, "mass": 1.3}, lambda solution: solution.t[-1], run)
    >>> round(study.fun([0.7, 1.3]), 6)  # time from a horizontal start to the lowest point
    0.51434
    >>> study.jac([0.7, 1.3]).round(6)  # by length [s/m] and by mass [s/kg]
    array([ 0.313909, -0.014398])
    """

    def __init__(
        self,
        build: Callable[..., Any],
        x0: Mapping[str, float],
        measure: Callable[[Any], Any],
        run: Mapping[str, Any] | Callable[..., Mapping[str, Any]] | None = None,
        *,
        x_scale: Mapping[str, float] | None = None,
        units: Mapping[str, str] | None = None,
        progress: bool | str | None = None,
        ledger: str | Path | None = None,
    ) -> None:
        self.x0, self.units, self.progress = checked_point(x0), dict(units or {}), progress
        self.names = tuple(self.x0)
        self.runs = run is not None
        self.experiment = SystemExperiment(build, measure) if run is None else Experiment(build, measure, run)
        check_study(self.experiment, self.x0)
        given = {
            name: number(value, f"Study: x_scale '{name}'", positive=True) for name, value in (x_scale or {}).items()
        }
        if unknown := sorted(given.keys() - self.x0.keys()):
            raise InputError(
                f"Study: x_scale of '{unknown[0]}', which x0 does not have; it has {', '.join(self.names)}"
            )
        self.typical = np.array([given.get(name, abs(value) or 1.0) for name, value in self.x0.items()])
        self._last: tuple[bytes, Values, np.ndarray | None] | None = None  # the last point, and what was found there
        self._ledger = None if ledger is None else PointLedger(ledger, identity_of_study(self.experiment, self.names))
        # on which what is found at a point depends
        self._settings = stamp([run_stamp(self.experiment.run), self.typical])

    def __repr__(self) -> str:
        build = getattr(self.experiment.build, "__name__", type(self.experiment.build).__name__)
        first = ", ".join(f"{name} = {x:.6g}" for name, x in list(self.x0.items())[:SHOWN_MAX])
        return f"<study of {build}: {first}{', ...' if len(self.x0) > SHOWN_MAX else ''}>"

    @property
    def functions(self) -> list[Callable]:
        """Return the functions that a point needs, for workers."""
        run = self.experiment.run
        return [self.experiment.build, self.experiment.measure, *([run] if callable(run) else [])]

    def fun(self, x: Any = None) -> float | np.ndarray:
        """Return what is measured at x (k,), or at a mapping of parameters; None = x0.

        A number if the measure is one, else all its numbers (n,), those of a dict side by side in its order.
        """
        return shaped(self.values(x))

    def jac(self, x: Any = None) -> np.ndarray:
        """Return the derivatives at x: (k,) of a number, (n, k) of n numbers."""
        return self.fun_and_jac(x)[1]

    def fun_and_jac(self, x: Any = None) -> tuple[float | np.ndarray, np.ndarray]:
        """Return `fun` and `jac` at x, by one run with its derivatives."""
        values, jac = self._derivatives(self.point(x))
        found = shaped(values)
        return found, jac[0] if isinstance(found, float) else jac

    def gradient(self, x: Any = None) -> Gradient:
        """Return values and derivatives at x with an estimate of their errors, by a second run.

        Raises
        ------
        GradientError
            If the two runs disagree by more than 1e-3 of the largest change of a value by any parameter.
        """
        at = self.point(x)
        values, jac = self._derivatives(at)
        again = jac if not self.runs else self._derivatives(at, finer=True)[1]
        size = self.sizes(at)
        rounding = ESTIMATE_ROUNDING * (np.abs(values.vector)[:, None] / size + row_sizes(jac, size))
        found = Gradient(
            self.mapping(at),
            values.labels,
            values.vector,
            jac,
            ESTIMATE_FACTOR * np.abs(jac - again) + rounding,
            size,
            self.units,
        )
        nothing = VANISHING_SHARE * np.abs(values.vector).max(initial=0.0) / size  # by which what vanishes may differ
        worst = relative_errors(jac, np.maximum(np.abs(jac - again) - nothing, 0.0), size)
        if (worst > ESTIMATE_MAX).any():
            i, j = np.unravel_index(np.argmax(worst), worst.shape)
            raise GradientError(
                f"the derivative of '{values.labels[i]}' by '{self.names[j]}' is {jac[i, j]:.6g}, with a finer "
                f"tolerance {again[i, j]:.6g}",
                advice="give a smaller rtol; a chaotic motion has none that can be trusted: end the run earlier",
            )
        return found

    def at_times(self, t: np.ndarray) -> "Study":
        """Return the same study with samples at these times [s], which end the run."""
        run = self.experiment.run
        at = {"output": t, "t_end": float(t[-1])}
        sampled = (lambda **given: {**run(**given), **at}) if callable(run) else {**run, **at}
        x_scale = dict(zip(self.names, self.typical.tolist(), strict=True))
        found = Study(
            self.experiment.build, self.x0, self.experiment.measure, sampled, x_scale=x_scale, units=self.units,
            progress=self.progress,
        )  # fmt: skip
        found._ledger, found._settings = self._ledger, stamp([self._settings, np.array(t, float)])
        return found

    def cells(self, points: np.ndarray) -> PointCells | None:
        """Return what the ledger knows of points (m, k), and where it keeps what is measured there; None without
        one.
        """
        return None if self._ledger is None else PointCells(self._ledger, [self._key("values", x) for x in points])

    def _key(self, kind: str, at: np.ndarray) -> str:
        """Return the key of a point in the ledger."""
        return point_key(kind, self._settings, at)

    def values(self, x: Any = None) -> Values:
        """Return what is measured at x, by name."""
        at = self.point(x)
        if self._last is None or self._last[0] != at.tobytes():
            values, _ = self._kept("values", at, lambda: (self._valued(at), None))
            self._last = at.tobytes(), values, None
        return self._last[1]

    def _valued(self, at: np.ndarray) -> Values:
        """Compute values at x."""
        with one_thread():
            given = self.mapping(at)
            return self._measured(self.experiment.solve(given) if self.runs else self._built(given))

    def _kept(
        self, kind: str, at: np.ndarray, compute: Callable[[], tuple[Values, np.ndarray | None]]
    ) -> tuple[Values, np.ndarray | None]:
        """Return what the ledger has of a point, else compute and keep it."""
        if self._ledger is None:
            return compute()
        key = self._key(kind, at)
        if (found := self._ledger.known.get(key)) is not None:
            return Values(found.values), None if found.jac is None else np.array(found.jac).reshape(-1, at.size)
        values, jac = compute()
        self._ledger.keep(key, values, None if jac is None else jac.tolist())
        return values, jac

    def _derivatives(self, at: np.ndarray, finer: bool = False) -> tuple[Values, np.ndarray]:
        """Return values and their derivatives (n, k) at x, ``finer``: of a run with a finer tolerance."""
        last = self._last
        if not finer and last is not None and last[0] == at.tobytes() and last[2] is not None:
            return last[1], last[2]
        kind = "finer derivatives" if finer else "derivatives"
        values, jac = self._kept(kind, at, lambda: self._differenced(at, finer))
        if not finer:
            self._last = at.tobytes(), values, jac
        return values, jac  # type: ignore[return-value]  # of derivatives there is a Jacobian

    def _differenced(self, at: np.ndarray, finer: bool) -> tuple[Values, np.ndarray]:
        """Compute values and their derivatives (n, k) at x."""
        with one_thread():
            values, changes = self._of_run(at, finer) if self.runs else self._of_system(at)
        size, jac = self.sizes(at), np.zeros((values.vector.size, at.size))
        if not np.isfinite(values.vector).all():
            raise GradientError(f"measure returned {short_repr(dict(values))}", advice="return finite numbers")
        for change in changes:
            j = change.parameter
            for other in change.beside.values():
                self._check_values(other, values, f"beside '{self.names[j]}' = {at[j]:g}")
            vectors = {k: other.vector for k, other in change.beside.items()}
            jac[:, j] += difference(vectors, change.step, f"what is measured, by '{self.names[j]}',", size[j])
        return values, jac

    def _check_values(self, other: Values, values: Values, where: str) -> None:
        """Refuse values beside a point that are no numbers, or others than there."""
        if other.labels != values.labels:
            raise GradientError(
                f"measure returned {len(other.labels)} numbers {where}, and {len(values.labels)} there",
                advice="return the same names and lengths everywhere, e.g. with run=dict(output=count)",
            )
        if not np.isfinite(other.vector).all():
            bad = other.labels[int(np.argmax(~np.isfinite(other.vector)))]
            raise GradientError(
                f"'{bad}' is not a number {where}",
                advice="measure what has a derivative there: of Kinematic() no work and no internal state",
            )

    def _of_system(self, at: np.ndarray) -> tuple[Values, list["Change"]]:
        """Return what is measured of the system at x, and its changes beside it in each parameter."""
        values = self._measured(self._built(self.mapping(at)))
        found = [self._beside(at, j, lambda given: self._measured(self._built(given)), values) for j in range(at.size)]
        return values, [Change(j, step, beside) for j, (step, beside) in enumerate(found)]

    def _of_run(self, at: np.ndarray, finer: bool) -> tuple[Values, list["Change"]]:
        """Return what is measured of the run at x, and its changes along the derivatives in each parameter.

        Where a step of a parameter moves the samples far, they move by less of it with the model that stands still, and
        the model changes while they stand still: the derivative is the sum of both.
        """
        derivatives = self._sampled(at, finer)
        values = self._measured(Solution.of(derivatives.result))
        found = []
        for j, parameter in enumerate(derivatives.parameters):
            step, beside = parameter.step, parameter.beside
            shares = [(step, 1.0, beside)]
            if (moved := derivatives.motion(j)) > MOTION_MAX:
                shares = [(step, 0.0, beside), (MOTION_MAX / moved * step, 1.0, dict.fromkeys(OFFSETS, beside[0]))]
            for step, share, models in shares:
                results = {k: derivatives.beside(j, share * k * step, models[k]) for k in OFFSETS}
                moved_by = {k: self._measured(Solution.of(result)) for k, result in results.items()}
                found.append(Change(j, step, {0: values, **moved_by}))
        return values, found

    def _sampled(self, at: np.ndarray, finer: bool) -> SampleDerivatives:
        """Run at x; return the samples and their derivatives."""
        job = RecordedJob(*self._start(self.mapping(at), finer))
        check_differentiable(job)
        before = Lowered.of(job)
        parameters = []
        for j, (name, size) in enumerate(zip(self.names, self.sizes(at), strict=True)):
            step, beside = self._beside(at, j, lambda given: before.beside(*self._start(given, finer)), before)
            for one in beside.values():
                if not same_structure(before, one):
                    raise GradientError(
                        f"the structure of the model changes near '{name}' = {at[j]:g}",
                        advice="build the same parts, signals and number of samples beside it, or give another point",
                    )
            parameters.append(Parameter(name, step, size, beside))
        options, end = job.options, float(job.memory.task["t_end"])
        result = job.run(Progress(f"run to {end:g} s", job.start.t, end, options.progress))
        if job.interrupted:
            raise KeyboardInterrupt
        title = f"derivatives by {at.size} parameters to {end:g} s"
        run = Replay(job, before, result, parameters, HOP_RATIO if finer else 1.0)
        return run.samples(Progress(title, job.start.t, end, self.progress))

    def _beside(
        self, at: np.ndarray, j: int, call: Callable[[dict[str, float]], Any], there: Any
    ) -> tuple[float, dict[int, Any]]:
        """Return the step in parameter j, and what a function gives beside x by the number of steps; at x ``there``."""
        trouble: MbsError | None = None
        for share in STEP_REDUCTIONS:
            step, found = share * STEP_SHARE * float(self.sizes(at)[j]), {0: there}
            try:
                for k in OFFSETS:
                    x = at.copy()
                    x[j] += k * step
                    found[k] = call(self.mapping(x))
            except MisuseError:
                raise
            except MbsError as error:
                trouble = error
                continue
            return step, found
        raise GradientError(
            f"there is no model beside '{self.names[j]}' = {at[j]:g}: {trouble}",
            advice="give a point that lies farther inside, or the size of the parameter as x_scale",
        ) from trouble

    def _start(
        self, given: dict[str, float], finer: bool
    ) -> tuple[Compiled, State, float, np.ndarray | None, RunOptions]:
        """Return model, start, end [s], output times [s] and options of the run of a point."""
        system, settings = self.experiment.settings(given)
        t_end, state, options = arguments_of_run(settings)
        if finer:
            options = with_finer_tolerance(options)
        start = start_of(system, state, "simulate", options.as_built)
        compiled, t_end, times = check_run(system, start, t_end, options)
        return compiled, start, t_end, times, options

    def _built(self, given: dict[str, float]) -> System:
        """Return the system of a point where nothing runs."""
        return self.experiment.built(given)  # type: ignore[attr-defined]  # without a run it is a SystemExperiment

    def _measured(self, what: Any) -> Values:
        """Return what is measured, by name."""
        return Values(self.experiment.numbers(self.experiment.measure(what)))

    def point(self, x: Any) -> np.ndarray:
        """Return the vector (k,) of a point."""
        if x is None:
            return np.array(list(self.x0.values()))
        if isinstance(x, Mapping):
            check_same_names(x, self.names)
            x = [x[name] for name in self.names]
        at = np.array(x, float)
        if at.shape != (len(self.names),) or not np.isfinite(at).all():
            raise InputError(
                f"Study: x {short_repr(x)}; give {len(self.names)} finite numbers: {', '.join(self.names)}"
            )
        return at

    def mapping(self, at: np.ndarray) -> dict[str, float]:
        """Return the parameters of a point by name."""
        return dict(zip(self.names, at.tolist(), strict=True))

    def sizes(self, at: np.ndarray) -> np.ndarray:
        """Return the sizes (k,) of the parameters at a point."""
        return np.maximum(np.abs(at), SIZE_SHARE_MIN * self.typical)


def row_sizes(jac: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return the largest change of each value by any parameter, over the size of each: (n, k)."""
    return np.abs(jac * size).max(axis=1, initial=0.0, keepdims=True) / size


def shaped(values: Values) -> float | np.ndarray:
    """Return a single number as a scalar, otherwise the vector of all."""
    single = len(values) == 1 and not isinstance(next(iter(values.values())), list)
    return float(values.vector[0]) if single else values.vector.copy()


def arguments_of_run(settings: Mapping[str, Any]) -> tuple[float, State | None, RunOptions]:
    """Return end [s], start and options of a run with these arguments of `simulate`."""
    switches = Switches(**{x.name: settings[x.name] for x in fields(Switches) if x.name in settings})
    given = {name: settings[name] for name in ("rtol", "output", "stop_when", "as_built") if name in settings}
    options = RunOptions(settings.get("method") or DOP853(), progress=settings["progress"], switches=switches, **given)
    return settings["t_end"], settings.get("state"), options


def with_finer_tolerance(options: RunOptions) -> RunOptions:
    """Return the options of the second run."""
    method: Method = options.method
    if method.dt is not None:
        method = replace(method, dt=REFINED_STEP_SHARE * method.dt)  # type: ignore[type-var]  # every method is a dataclass
    finer = RTOL_RATIO * options.rtol
    return replace(options, method=method, rtol=finer if finer >= RTOL_MIN else options.rtol / RTOL_RATIO)


def checked_point(x0: Any) -> dict[str, float]:
    """Return the parameters as numbers by name."""
    if not isinstance(x0, Mapping):
        raise InputError(f"Study: x0 {short_repr(x0)}; give a mapping of parameters to their values")
    check_names(tuple(x0))
    return {name: number(value, f"Study: x0: '{name}'") for name, value in x0.items()}


def check_same_names(x: Mapping[str, Any], names: tuple[str, ...]) -> None:
    """Refuse a point with other parameters."""
    if set(x) != set(names):
        raise InputError(f"Study: x has {', '.join(map(str, x)) or 'nothing'}; give {', '.join(names)}")


def check_study(experiment: Experiment, x0: dict[str, float]) -> None:
    """Check functions and arguments of `simulate` before anything runs."""
    check_parameters(experiment.build, "build", x0, "Study")
    if callable(experiment.run):
        check_parameters(experiment.run, "run", x0, "Study")
    elif isinstance(experiment.run, Mapping):
        try:
            check_settings(experiment.run)
        except MisuseError as error:
            raise InputError(f"Study: {error}") from None
    else:
        raise InputError(
            f"Study: run {short_repr(experiment.run)}; give a mapping of arguments of simulate, or a function"
        )
    if not callable(experiment.measure):
        raise InputError(f"Study: measure {short_repr(experiment.measure)} is not a function; give one of a solution")
