"""What runs in an FMU that `System.to_fmu` wrote: a run in segments behind the functions of FMI 3.0 co-simulation.

It is imported by the script in the FMU, in the Python of the host, beside the copy of pythonfmu3 that the FMU carries.
"""

import json
from collections.abc import Callable, Mapping
from copy import copy, deepcopy
from pathlib import Path
from typing import Any
from uuid import NAMESPACE_OID, uuid5

import numpy as np
from pythonfmu3 import (
    Boolean,
    DefaultExperiment,
    Float64,
    Fmi3Causality,
    Fmi3Initial,
    Fmi3Status,
    Fmi3StepResult,
    Fmi3Variability,
    Unit,
)

from ..base.errors import InputError
from ..base.paths import package_version
from ..base.wording import counted
from ..results.certificate import certificate_of
from ..run.controllers import Ports
from ..run.segments import Segments
from .fmu import DOCUMENT, begin

CERTIFICATE = "certificate"
SAME_OUTPUT = 1e-9  # [1] by what rounding may change an output, of itself or one SI unit
SAME_TIME = 1e-9  # [1] of a communication step: by what its start may miss the time reached, from sums of steps
UNITS = {
    "rad": {"rad": 1}, "m": {"m": 1}, "rad/s": {"rad": 1, "s": -1}, "m/s": {"m": 1, "s": -1},
    "rad/s^2": {"rad": 1, "s": -2}, "m/s^2": {"m": 1, "s": -2}, "N": {"kg": 1, "m": 1, "s": -2},
    "N m": {"kg": 1, "m": 2, "s": -2}, "J": {"kg": 1, "m": 2, "s": -2}, "s": {"s": 1},
}  # fmt: skip
"""Units here -> exponents of the base units of FMI."""


class FmuInstance:
    """A mechanism in an FMU; the script in the FMU derives its class from this and from `pythonfmu3.Fmi3Slave`."""

    guid: Any  # this and the next ones are those of pythonfmu3
    description: str | None
    default_experiment: Any
    register_variable: Callable[..., None]
    register_units: Callable[[list[Any]], None]
    log: Callable[..., None]
    resources: str

    def __init__(self, **given: Any) -> None:
        super().__init__(**given)
        text = (Path(self.resources) / DOCUMENT).read_text(encoding="utf-8")
        self.document = json.loads(text)
        self.guid = uuid5(NAMESPACE_OID, text)
        self.description = self.document["description"]
        self.run: Segments | None = None
        self.ports: Ports | None = None  # of the run
        start = self.document["start"] or {}
        self.failure, self.start_time, self.longest, self.rollbacks = "", float(start.get("t", 0.0)), 0.0, 0
        self.default_experiment = DefaultExperiment(start_time=self.start_time)
        self.segments, self.passed, self.worst, self.started = 0, False, np.inf, False
        self.seen: dict[str, float] = {}
        self.told: list[tuple[dict[str, float], dict[str, float]]] = []  # inputs, outputs read before the first step
        self.given = {x["name"]: x["start"] for x in self.document["inputs"]}
        self.chosen = {x["name"]: x["start"] for x in self.document["parameters"]}
        self.register()

    def register(self) -> None:
        """Register the variables: parameters, inputs, outputs and the certificate."""
        used = {x["unit"] for x in (*self.document["inputs"], *self.document["outputs"])} | {"s", "J"}
        self.register_units([Unit(name, **UNITS[name]) for name in sorted(used & set(UNITS))])
        continuous, discrete = Fmi3Variability.continuous, Fmi3Variability.discrete
        self.variable("time", "time of the model", Fmi3Causality.independent, continuous, "s", lambda: self.t)
        for x in self.document["parameters"]:
            self.number(self.chosen, x, Fmi3Causality.parameter, Fmi3Variability.fixed)
        for x in self.document["inputs"]:
            self.number(self.given, x, Fmi3Causality.input, continuous)
        for x in self.document["outputs"]:
            read = self.reader(x["name"])
            self.variable(x["name"], x["description"], Fmi3Causality.output, continuous, x["unit"], read)
        when = "after 1, 2, 4, 8, ... communication steps, and at the end"
        self.register_variable(
            Boolean(
                f"{CERTIFICATE}.passed", causality=Fmi3Causality.output, variability=discrete,
                initial=Fmi3Initial.calculated, description=f"whether all checks of the run hold, {when}",
                getter=lambda: self.passed,
            ),
            nested=False,
        )  # fmt: skip
        worst = f"largest error of a check over its limit, {when}"
        self.variable(f"{CERTIFICATE}.worst", worst, Fmi3Causality.output, discrete, "-", lambda: self.worst)
        work, created = "work of the forces with inputs", "energy that holding the inputs may have created"
        for name, what in (("work", work), ("created", created)):
            self.variable(
                f"{CERTIFICATE}.{name}", what, Fmi3Causality.output, continuous, "J", self.energy_reader(name)
            )

    def number(self, values: dict[str, float], entry: Mapping[str, Any], causality: Any, variability: Any) -> None:
        """Register a number that the host sets."""
        name = entry["name"]

        def set_value(value: float) -> None:
            fixed = causality == Fmi3Causality.parameter
            if fixed and self.started and value != values[name]:
                self.fail(
                    InputError(f"parameter '{name}' is set after the start; set it before the initialization ends")
                )
                return
            values[name] = float(value)
            self.seen = {}
            if fixed and not self.started:
                self.run = None

        def get_value() -> float:
            return values[name]

        self.variable(name, entry["description"], causality, variability, entry["unit"], get_value, set_value)

    def reader(self, name: str) -> Callable[[], float]:
        """Return a function that reads an output."""

        def read() -> float:
            value = self.outputs().get(name, np.nan)
            if self.started and not self.segments:
                if not self.told or self.told[-1][0] != self.given:
                    self.told.append((dict(self.given), {}))
                self.told[-1][1][name] = value
            return value

        return read

    def energy_reader(self, name: str) -> Callable[[], float]:
        """Return a function that reads an energy [J] of the inputs."""
        return lambda: np.nan if self.failure else float(getattr(self.ports, name, 0.0))

    def variable(
        self, name: str, description: str, causality: Any, variability: Any, unit: str, getter: Callable[[], float],
        setter: Callable[[float], None] | None = None,
    ) -> None:  # fmt: skip
        """Register a number."""
        calculated = Fmi3Initial.calculated if causality == Fmi3Causality.output else None
        self.register_variable(
            Float64(
                name, causality=causality, variability=variability, initial=calculated, description=description,
                unit=unit if unit in UNITS else None, getter=getter, setter=setter,
            ),
            nested=False,
        )  # fmt: skip

    @property
    def t(self) -> float:
        """Return the time reached [s]."""
        return self.start_time if self.run is None else self.run.t

    def running(self) -> Segments:
        """Return the run with the inputs as they are set; it is made where there is none yet."""
        if self.run is None:
            self.run = begin(self.document, self.chosen, self.start_time)
            self.ports = Ports(self.run, [x["input"] for x in self.document["inputs"]])
        if self.ports is not None:
            self.ports.set({x["input"]: self.given[x["name"]] for x in self.document["inputs"]})
        return self.run

    def outputs(self) -> dict[str, float]:
        """Return the outputs by name: now, and with the inputs as they are set; none after a failure."""
        if self.failure:
            return {}
        if not self.seen:
            try:
                values = self.running().measured.tolist()
            except Exception as error:  # in C it would be fatal for all instances
                self.fail(error)
                return {}
            self.seen = {x["name"]: value for x, value in zip(self.document["outputs"], values, strict=True)}
        return self.seen

    def fail(self, error: Exception) -> Fmi3StepResult:
        """Log why there is no result; nothing but an error is returned from now on."""
        kind = "" if isinstance(error, ValueError | RuntimeError) else f"{type(error).__name__}: "
        self.failure, self.seen = f"{kind}{error}", {}
        self.passed, self.worst = False, np.inf
        self.log(self.failure, Fmi3Status.error)
        return Fmi3StepResult(status=Fmi3Status.error)

    def exit_initialization_mode(self) -> None:
        """Make the model with its parameters, which are fixed from now on."""
        self.outputs()
        self.started = True

    def do_step(self, current_time: float, step_size: float) -> Fmi3StepResult:
        """Integrate over a communication step, in which inputs hold what they are set to."""
        if self.failure:
            self.log(self.failure, Fmi3Status.error)
            return Fmi3StepResult(status=Fmi3Status.error)
        try:
            if self.segments == 0 and current_time != self.t:  # pythonfmu3 does not pass the start time on
                self.start_again(current_time)
            run = self.running()
            if abs(current_time - run.t) > SAME_TIME * step_size:
                raise InputError(
                    f"a step from {current_time:.9g} s is asked for, but the FMU is at {run.t:.9g} s; set the FMU "
                    "state of that time first, or go on from here"
                )
            self.seen = {}
            run.advance(current_time + step_size)
            self.longest = max(self.longest, step_size)
            self.segments += 1
            if self.segments & (self.segments - 1) == 0:
                self.judge()
        except Exception as error:  # in C it would be fatal for all instances
            return self.fail(error)
        return Fmi3StepResult()

    def start_again(self, t: float) -> None:
        """Start at another time; an InputError where outputs that were read already would have been others."""
        before, given = self.start_time, dict(self.given)
        self.start_time, self.run = t, None
        for inputs, told in self.told:
            self.given.update(inputs)
            now = dict(zip((x["name"] for x in self.document["outputs"]), self.running().measured, strict=True))
            for name, value in told.items():
                if abs(now[name] - value) > SAME_OUTPUT * max(abs(value), 1.0):
                    raise InputError(
                        f"'{name}' was read before the first step, of {before:.9g} s: the start time {t:.9g} s does "
                        "not reach the model before that step; write the FMU with a state of that time (to_fmu: "
                        "state), or read no such output before"
                    )
        self.given.update(given)

    def judge(self) -> str:
        """Judge the run so far; return the certificate."""
        certificate = certificate_of(self.running().solution())
        self.passed = certificate.passed
        self.worst = max((x.error / x.limit if x.limit > 0.0 else np.inf for x in certificate.checks), default=np.inf)
        return str(certificate)

    def terminate(self) -> None:
        """Log the certificate of the run."""
        try:
            text = self.judge() if self.run is not None and self.segments else "nothing was computed"
        except Exception as error:
            text = f"no certificate: {error}"
        if self.failure:
            text, self.passed, self.worst = f"failed: {self.failure}\n{text}", False, np.inf
        self.log(f"{self.document['title']}, mbsd3d {package_version()}\n{text}\n  {self.coupling()}")

    def coupling(self) -> str:
        """Describe how the inputs were coupled."""
        held = "no inputs"
        if self.given and self.ports is not None:
            held = (
                f"inputs held over communication steps of up to {self.longest:g} s: forces with them gave "
                f"{self.ports.work:.6g} J, of which holding may have created {self.ports.created:.6g} J"
            )
        return f"{held}; {counted(self.rollbacks, 'time')} back to an earlier state; model {self.document['hash'][:16]}"

    def _get_fmu_state(self) -> dict[str, Any]:
        """Return all that later steps depend on."""
        return {
            "snapshot": self.run and self.run.snapshot(), "given": dict(self.given),
            "chosen": dict(self.chosen), "failure": self.failure, "segments": self.segments,
            "judged": (self.passed, self.worst), "run": self.run, "ports": copy(self.ports),
            "start_time": self.start_time, "started": self.started, "told": deepcopy(self.told),
        }  # fmt: skip

    def _set_fmu_state(self, state: Mapping[str, Any]) -> None:
        """Go back, or on, to a state."""
        self.run, self.ports = state["run"], copy(state["ports"])
        if self.run is not None:
            self.run.restore(state["snapshot"])
        self.given.update(state["given"])
        self.chosen.update(state["chosen"])
        self.failure, self.segments, self.start_time = state["failure"], state["segments"], state["start_time"]
        self.started, (self.passed, self.worst) = state["started"], state["judged"]
        self.told = deepcopy(state["told"])
        self.seen, self.rollbacks = {}, self.rollbacks + 1
