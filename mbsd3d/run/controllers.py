"""Controllers in FMUs, coupled to a run in segments: sampled, their outputs held from sample to sample.

At a sample t_k the FMU gets what it reads at t_k, its outputs of t_k become inputs of the mechanism, and both go on to
t_k + H: parallel (Jacobi), values held, so that the coupling errs in proportion to H. Held forces do other work than
forces that follow the motion: the energy that passes is measured, beside power at the samples times H.
"""

import shutil
import tempfile
import weakref
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import KW_ONLY, dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ..base.checks import number, short_repr
from ..base.errors import ChecksArguments, InputError, IntegrationError, similar
from ..base.paths import as_path
from ..dynamics.applied_forces import loads
from ..kernels.kinematics import kinematics
from ..mechanism.measures import Measure
from ..mechanism.signals.signal import Input
from .segments import Segments

SAME_TIME = 1e-9  # [1] of the time between two samples: by what sums of times may miss a sample


@dataclass(frozen=True, eq=False)
class FmuController(metaclass=ChecksArguments):
    """A controller in an FMU (co-simulation, FMI 2.0 or 3.0), for `Stepper`; it needs the extra ``fmu``.

    At each sample it reads measures and sets inputs, which hold until the next sample: order 1 in ``every``.

    Parameters
    ----------
    path : str or Path
        The FMU. It runs in this process, with all that it contains: take it from whom you trust.
    reads : mapping of a name to a measure
        Inputs of the FMU, in SI units, and what of the mechanism they get.
    sets : mapping of a name to an Input or its name
        Outputs of the FMU, and the inputs of the mechanism that they set.
    every : float
        Time between two samples [s].
    parameters : mapping of a name to a number
        Values that the FMU starts with.

    Raises
    ------
    ValueError
        For a file that is not there, values of the wrong kind; when a `Stepper` is made, for names that the FMU or the
        mechanism does not have, units that are not base units, an FMU that cannot be loaded.

    Examples
    --------
    >>> from mbsd3d import FmuController
    >>> FmuController("pid.fmu", reads={}, sets={"u": "push"}, every=0.01)
    Traceback (most recent call last):
    ...
    mbsd3d.base.errors.InputError: FmuController: 'pid.fmu' does not exist; give an FMU (.fmu)
    """

    path: str | Path
    _: KW_ONLY
    reads: Mapping[str, Measure]
    sets: Mapping[str, Input | str]
    every: float
    parameters: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        path = as_path(self.path, "pid.fmu")
        if not path.is_file():
            raise InputError(f"FmuController: '{path}' does not exist; give an FMU (.fmu)")
        kinds: tuple[tuple[str, Any, str], ...] = (
            ("reads", Measure, "a measure"), ("sets", Input | str, "an Input or its name"),
            ("parameters", int | float, "a number"),
        )  # fmt: skip
        for part, kind, what in kinds:
            given = getattr(self, part)
            if not isinstance(given, Mapping):
                raise InputError(f"FmuController: {part} = {short_repr(given)}; give a dict of name and {what}")
            for name, value in given.items():
                if not isinstance(name, str) or not isinstance(value, kind):
                    raise InputError(
                        f"FmuController: {part}: {short_repr(name)}: {short_repr(value)}; give a name and {what}"
                    )
        if not self.sets:
            raise InputError("FmuController: sets is empty; give an output of the FMU, and the Input that it sets")
        number(self.every, "FmuController: every", positive=True)

    @property
    def name(self) -> str:
        """Return the name of the file."""
        return Path(self.path).name

    @property
    def inputs(self) -> dict[str, str]:
        """Return output of the FMU -> name of the input that it sets."""
        return {name: x.name if isinstance(x, Input) else x for name, x in self.sets.items()}


class Instance:
    """An FMU that runs: variables by name, values in and out, one step after the other."""

    def __init__(self, controller: FmuController, t: float) -> None:
        if find_spec("fmpy") is None:
            raise InputError("FmuController needs the package fmpy; install it: pip install 'mbsd3d[fmu]'")
        import fmpy  # the extra "fmu"

        self.what, self.heard = f"FmuController: '{controller.name}'", [""]
        folder = tempfile.mkdtemp(prefix="mbsd3d_fmu_")
        heard = self.heard  # the callback must not hold this instance, or it would never be freed

        def hear(*said: Any) -> None:
            heard.append(said[-1].decode(errors="replace") if isinstance(said[-1], bytes) else str(said[-1]))

        try:
            description = fmpy.read_model_description(str(controller.path))
            self.check(description)
            fmpy.extract(str(controller.path), unzipdir=folder)
            self.fmu = fmpy.instantiate_fmu(folder, description, "CoSimulation", logger=hear)
        except Exception as error:  # whatever a foreign file or its binary brings about
            shutil.rmtree(folder, ignore_errors=True)
            if isinstance(error, InputError):
                raise
            raise InputError(
                f"{self.what} cannot be loaded: {error}{self.last}; give an FMU with a binary for this platform"
            ) from error
        weakref.finalize(self, ended, self.fmu, folder)
        self.old = description.fmiVersion.startswith("2")
        self.places = {x.name: x for x in description.modelVariables}
        self.check_names(controller.reads, "input", description)
        self.check_names(controller.sets, "output", description)
        self.check_names(controller.parameters, None, description)
        self.begin(controller, t)

    @property
    def last(self) -> str:
        """Return the last sentence of the FMU's log, in brackets."""
        return f" ({self.heard[-1].strip()})" if self.heard[-1] else ""

    def check(self, description: Any) -> None:
        """Refuse other kinds of FMUs."""
        if description.coSimulation is None or not description.fmiVersion.startswith(("2", "3")):
            raise InputError(f"{self.what} is no FMU for co-simulation by FMI 2.0 or 3.0; export it as one")

    def check_names(self, names: Mapping[str, Any], causality: str | None, description: Any) -> None:
        """Refuse names that the FMU does not have as such variables, and units with a factor."""
        units = {x.name: x.baseUnit for x in description.unitDefinitions or ()}
        known = [x.name for x in description.modelVariables if causality in (None, x.causality)]
        for name in names:
            if name not in known:
                near = similar(name, known)
                hint = f", did you mean '{near[0]}'? There" if near else "; there"
                have = ", ".join(f"'{x}'" for x in known[:20]) or "none"
                raise InputError(f"{self.what} has no {causality or 'variable'} '{name}'{hint} are {have}")
            base = units.get(self.places[name].unit)
            if base is not None and (base.factor != 1.0 or base.offset != 0.0):
                raise InputError(
                    f"{self.what}: '{name}' is in {self.places[name].unit}; export it in SI units and radians"
                )

    def begin(self, controller: FmuController, t: float) -> None:
        """Initialize the FMU at time t [s]."""
        with self.telling(t):
            self.put(dict(controller.parameters))
            if self.old:
                self.fmu.setupExperiment(startTime=t)
                self.fmu.enterInitializationMode()
            else:
                self.fmu.enterInitializationMode(startTime=t)
            self.fmu.exitInitializationMode()

    def put(self, values: Mapping[str, float]) -> None:
        """Set variables by name."""
        if values:
            places = [self.places[name].valueReference for name in values]
            (self.fmu.setReal if self.old else self.fmu.setFloat64)(places, [float(x) for x in values.values()])

    def take(self, names: Sequence[str]) -> list[float]:
        """Return variables by name."""
        places = [self.places[name].valueReference for name in names]
        return list((self.fmu.getReal if self.old else self.fmu.getFloat64)(places))

    def step(self, t: float, length: float) -> None:
        """Integrate the FMU over a time."""
        self.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=length)

    def telling(self, t: float) -> "Telling":
        """Return a context in which errors of the FMU name it, with the last sentence of its log."""
        return Telling(self, t)


class Telling:
    """Turns errors of an FMU into an IntegrationError."""

    def __init__(self, instance: Instance, t: float) -> None:
        self.instance, self.t = instance, t

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: Any, error: BaseException | None, trace: Any) -> None:
        if isinstance(error, Exception):
            raise IntegrationError(
                f"the FMU reports an error: {error}{self.instance.last}", time=self.t, part=self.instance.what,
                advice="see its documentation",
            ) from error  # fmt: skip


def ended(fmu: Any, folder: str) -> None:
    """End an FMU and remove its files."""
    with suppress(Exception):
        fmu.terminate()
    with suppress(Exception):
        fmu.freeInstance()
    shutil.rmtree(folder, ignore_errors=True)


class Coupling:
    """A controller at work: its FMU, the next sample, and the energy that has passed."""

    def __init__(self, controller: FmuController, run: Segments, first: int) -> None:
        self.controller, self.run, self.begin = controller, run, run.t
        self.measures = range(first, first + len(controller.reads))
        for name in controller.inputs.values():
            if name not in run.inputs:
                have = ", ".join(f"'{x}'" for x in run.inputs) or "none"
                raise InputError(
                    f"FmuController: '{controller.name}' sets {short_repr(name)}, which is no input of this system; "
                    f"there are {have}"
                )
            if run.driving[name] is not None:
                raise InputError(
                    f"FmuController: '{controller.name}' sets '{name}', which prescribes the motion of driver "
                    f"'{run.driving[name]}', and a jump would tear the joints apart; let it set a force, or a reference"
                )
        self.forces = [k for k, force in enumerate(run.compiled.system.forces) if reads_any(force, controller.inputs)]
        self.samples, self.power, self.held = 0, 0.0, 0.0
        self.instance = Instance(controller, run.t)

    @property
    def due(self) -> float:
        """Return the time [s] of the next sample."""
        return self.begin + self.samples * self.controller.every

    def is_due(self) -> bool:
        """Return whether the run has come to the next sample."""
        return self.run.t >= self.due - SAME_TIME * self.controller.every

    def exchange(self, values: np.ndarray) -> Callable[[], None]:
        """Give the FMU what it reads now, and let it go on; return what sets the inputs of the mechanism."""
        t, sets = self.run.t, self.controller.inputs
        with self.instance.telling(t):
            self.instance.put(dict(zip(self.controller.reads, values[self.measures], strict=True)))
            found = self.instance.take(list(sets))
            self.instance.step(self.due, self.controller.every)
        self.samples += 1

        def set_inputs() -> None:
            for name, value in zip(sets.values(), found, strict=True):
                self.run.set(name, value)

        return set_inputs

    def read_power(self) -> None:
        """Read the power [W] of the forces with these inputs at the state at hand."""
        run = self.run
        kinematics(run.model, run.data, run.memory.y)
        loads(run.model, run.data, run.t)
        self.power = float(run.data.force["power"][self.forces].sum())

    def note(self) -> str:
        """Describe the coupling and the energy that has passed, for the certificate."""
        run = self.run
        first = 13 * run.model.body.size + run.model.z_work
        passed = float(run.memory.y[[first + k for k in self.forces]].sum())
        name, every = self.controller.name, self.controller.every
        return (
            f"controller '{name}': sampled every {every:g} s, values held (order 1); forces with its inputs gave "
            f"{passed:.6g} J, their power at the samples times {every:g} s is {self.held:.6g} J: halve every to see "
            "what holding does"
        )


def reads_any(force: Any, inputs: Mapping[str, str]) -> bool:
    """Return whether a force reads any of some inputs."""
    terms = [term for signal in force.record().signals if signal is not None for term in signal.terms()]
    return any(term.input and term.input[0] in inputs.values() for term in terms)


def advance_coupled(run: Segments, couplings: Sequence[Coupling], t: float) -> None:
    """Integrate a run with its controllers to time t [s], from sample to sample."""
    while True:
        due = [x for x in couplings if x.is_due()]
        values = run.measured if due else np.zeros(0)
        for set_inputs in [x.exchange(values) for x in due]:  # all read before any sets
            set_inputs()
        for x in couplings if due else ():
            x.read_power()
        before = run.t
        until = min(t, *(x.due for x in couplings))
        run.advance(until if until < t - SAME_TIME * min(x.controller.every for x in couplings) else t)
        for x in couplings:
            x.held += x.power * (run.t - before)
        if run.t >= t:
            return
