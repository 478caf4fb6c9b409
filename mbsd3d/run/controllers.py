"""Controllers in FMUs, coupled to a run in segments: sampled, their outputs held or extrapolated from sample to sample.

At a sample t_k the FMU gets what it reads at t_k, its outputs of t_k become inputs of the mechanism, and both go on to
t_k + H: parallel (Jacobi). Values that hold err in proportion to H, values that go on with the slope of the last two
in proportion to H^2. Such forces do other work than forces that follow the motion: their jumps at samples say how much.
"""

import shutil
import tempfile
import weakref
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import suppress
from copy import copy
from ctypes import c_void_p
from dataclasses import KW_ONLY, dataclass, field
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ..base.checks import check_choice, number, short_repr
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

    At each sample it reads measures and sets inputs, which hold until the next sample (order 1 in ``every``), or go on
    with the slope of the last two (order 2).

    Parameters
    ----------
    path : str or Path
        The FMU. Its code runs in this process: use only files from sources you trust.
    reads : mapping of a name to a measure
        Inputs of the FMU, in SI units, and the measures that set them.
    sets : mapping of a name to an Input or its name
        Outputs of the FMU, and the inputs of the mechanism that they set.
    every : float
        Time between two samples [s].
    parameters : mapping of a name to a number
        Initial values of the FMU.
    coupling : "held" or "extrapolated"
        "held" is what a sampled controller does. "extrapolated" is for a continuous model in an FMU, as a spring, a
        motor or another mechanism: inputs of this mechanism go on with the slope of the last two samples; those of the
        FMU, which has no slopes, get for each step the value that the last two give for its middle.

    Raises
    ------
    ValueError
        For a missing file or values of the wrong kind; when a `Stepper` is made, for names that the FMU or the
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
    coupling: str = "held"

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
        check_choice(self.coupling, ("held", "extrapolated"), "FmuController: coupling")

    @property
    def name(self) -> str:
        """Return the name of the file."""
        return Path(self.path).name

    @property
    def inputs(self) -> dict[str, str]:
        """Return output of the FMU -> name of the input that it sets."""
        return {name: x.name if isinstance(x, Input) else x for name, x in self.sets.items()}


class Instance:
    """A running FMU: variables by name, inputs and outputs, step by step."""

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
        self.goes_back = bool(description.coSimulation.canGetAndSetFMUstate)
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
        """Reject other kinds of FMUs."""
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

    def state(self, t: float) -> Any:
        """Return the state of the FMU at time t [s]; the FMU frees it when it is no longer referenced."""
        if not self.goes_back:
            raise InputError(
                f"{self.what} does not offer its state (canGetAndSetFMUState), so no snapshot can go back to it; "
                "export it with its state, or take snapshots of a run without it"
            )
        with self.telling(t):
            kept = self.fmu.getFMUState()
        weakref.finalize(kept, forgotten, self, kept.value)  # before the instance, which it keeps alive
        return kept

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


def forgotten(instance: Instance, address: int) -> None:
    """Free a stored state of an FMU."""
    with suppress(Exception):
        instance.fmu.freeFMUState(c_void_p(address))


def ended(fmu: Any, folder: str) -> None:
    """End an FMU and remove its files."""
    with suppress(Exception):
        fmu.terminate()
    with suppress(Exception):
        fmu.freeInstance()
    shutil.rmtree(folder, ignore_errors=True)


class Ports:
    """Inputs of a run that another program sets from time to time, and the work of the forces that read them.

    Where forces with the old inputs have the power P at a change, and P' with the new ones, inputs that had gone
    straight to their new values over the time H since the last change would have given (P - P') H / 2 less: so much
    energy the coupling may have created. Extrapolated inputs leave their course as s (s + H) does at s = H: 5/12.
    """

    def __init__(self, run: Segments, names: Collection[str], extrapolated: bool = False) -> None:
        self.run, self.extrapolated = run, extrapolated
        self.forces = [k for k, force in enumerate(run.compiled.system.forces) if reads_any(force, names)]
        self.share = 5.0 / 12.0 if extrapolated else 0.5
        self.values: dict[str, float] = {}
        self.before = (run.t, self.values)  # the change before this one
        self.now, self.power = run.t, 0.0  # time [s] of this change, and power [W] with the values before it
        self.settled = self.created = 0.0  # [J] until the change before this one; until now

    def set(self, values: dict[str, float]) -> None:
        """Set inputs by name; again at the same time, the last values are those that count."""
        run = self.run
        if run.t > self.now:
            self.before = self.now, self.values
            self.now, self.power, self.settled = run.t, self.read_power(), self.created
        then, old = self.before
        length = self.now - then
        for name, value in values.items():
            slope = (value - old[name]) / length if self.extrapolated and name in old and length > 0.0 else 0.0
            run.set(name, value, slope)
        self.values = dict(values)
        if length > 0.0:
            self.created = self.settled + self.share * length * (self.power - self.read_power())

    def read_power(self) -> float:
        """Return the power [W] of the forces with these inputs at the state at hand."""
        run = self.run
        if not self.forces:
            return 0.0
        kinematics(run.model, run.data, run.memory.y)
        loads(run.model, run.data, run.t)
        return float(run.data.force["power"][self.forces].sum())

    @property
    def work(self) -> float:
        """Return the work [J] so far of the forces with these inputs."""
        run = self.run
        first = 13 * run.model.body.size + run.model.z_work
        return float(run.memory.y[[first + k for k in self.forces]].sum())


class Coupling:
    """A running controller: its FMU, the next sample and the inputs that it sets."""

    def __init__(self, controller: FmuController, run: Segments, first: int) -> None:
        self.controller, self.run, self.begin = controller, run, run.t
        self.measures = range(first, first + len(controller.reads))
        for name in controller.inputs.values():
            if name not in run.inputs:
                have = ", ".join(f"'{x}'" for x in run.inputs) or "none"
                raise InputError(
                    f"FmuController: '{controller.name}' sets {short_repr(name)}, which is not an input of this "
                    f"system; there are {have}"
                )
            if run.driving[name] is not None:
                raise InputError(
                    f"FmuController: '{controller.name}' sets '{name}', which prescribes the motion of driver "
                    f"'{run.driving[name]}', and a jump would tear the joints apart; let it set a force, or a reference"
                )
        self.extrapolated = controller.coupling == "extrapolated"
        self.ports = Ports(run, controller.inputs.values(), self.extrapolated)
        self.samples, self.read = 0, np.zeros(0)
        self.instance = Instance(controller, run.t)

    @property
    def due(self) -> float:
        """Return the time [s] of the next sample."""
        return self.begin + self.samples * self.controller.every

    def is_due(self) -> bool:
        """Return whether the run has come to the next sample."""
        return self.run.t >= self.due - SAME_TIME * self.controller.every

    def exchange(self, values: np.ndarray) -> Callable[[], None]:
        """Set the inputs of the FMU, advance it by one sample and return the new inputs of the mechanism."""
        t, sets = self.run.t, self.controller.inputs
        read, self.read = self.read, values[self.measures]
        with self.instance.telling(t):
            self.put(self.read)
            found = self.instance.take(list(sets))
            if self.extrapolated and self.samples:
                self.put(1.5 * self.read - 0.5 * read)  # in the middle of the step
            self.instance.step(self.due, self.controller.every)
        self.samples += 1
        return lambda: self.ports.set(dict(zip(sets.values(), found, strict=True)))

    def put(self, values: np.ndarray) -> None:
        """Set the inputs of the FMU."""
        self.instance.put(dict(zip(self.controller.reads, values, strict=True)))

    def snapshot(self) -> tuple[Any, ...]:
        """Return the state of the controller."""
        return self.instance.state(self.run.t), copy(self.ports), self.samples, self.read

    def restore(self, kept: tuple[Any, ...]) -> None:
        """Restore a state of the controller."""
        state, ports, self.samples, self.read = kept
        self.ports = copy(ports)
        with self.instance.telling(self.run.t):
            self.instance.fmu.setFMUState(state)

    def note(self) -> str:
        """Describe the coupling and the energy that has passed, for the certificate."""
        name, every = self.controller.name, self.controller.every
        how, doing = ("extrapolated (order 2)", "extrapolating") if self.extrapolated else ("held (order 1)", "holding")
        return (
            f"controller '{name}': sampled every {every:g} s, values {how}; forces with its inputs gave "
            f"{self.ports.work:.6g} J, of which {doing} may have created {self.ports.created:.6g} J: halve every to see"
        )


def reads_any(force: Any, names: Collection[str]) -> bool:
    """Return whether a force reads any of some inputs."""
    terms = [term for signal in force.record().signals if signal is not None for term in signal.terms()]
    return any(term.input and term.input[0] in names for term in terms)


def advance_coupled(run: Segments, couplings: Sequence[Coupling], t: float) -> None:
    """Integrate a run with its controllers to time t [s], from sample to sample."""
    while True:
        due = [x for x in couplings if x.is_due()]
        values = run.measured if due else np.zeros(0)
        for set_inputs in [x.exchange(values) for x in due]:  # all read before any sets
            set_inputs()
        until = min(t, *(x.due for x in couplings))
        run.advance(until if until < t - SAME_TIME * min(x.controller.every for x in couplings) else t)
        if run.t >= t:
            return
