"""A host of FMUs for the tests, by FMPy: one FMU, its variables by name, and what it logs. Needs the extra fmu."""

from contextlib import contextmanager

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave

__all__ = ["FMICallException", "Host", "hosted", "write_controller"]


class Host:
    """An instance of an FMU."""

    def __init__(self, path, folder):
        self.description = fmpy.read_model_description(str(path))
        self.places = {x.name: x for x in self.description.modelVariables}
        self.lines = []
        unzipped = fmpy.extract(str(path), unzipdir=str(folder))
        model = self.description.coSimulation
        self.fmu = FMU3Slave(
            guid=self.description.guid, unzipDirectory=unzipped, modelIdentifier=model.modelIdentifier,
            instanceName=path.stem,
        )  # fmt: skip
        self.fmu.instantiate(loggingOn=True, logMessage=self.hear)

    def hear(self, environment, status, category, message):
        """Keep a message of the log with its status."""
        self.lines.append((status, message.decode() if isinstance(message, bytes) else message))

    def start(self, t=0.0, **values):
        """Set values and leave the initialization."""
        self.set(**values)
        self.fmu.enterInitializationMode(startTime=t)
        self.fmu.exitInitializationMode()

    def set(self, **values):
        """Set inputs or parameters; "__" stands for a dot."""
        for name, value in values.items():
            self.fmu.setFloat64([self.places[name.replace("__", ".")].valueReference], [value])

    def get(self, *names):
        """Return outputs."""
        return [float(self.fmu.getFloat64([self.places[name].valueReference])[0]) for name in names]

    @property
    def passed(self):
        """Whether the certificate says so."""
        return bool(self.fmu.getBoolean([self.places["certificate.passed"].valueReference])[0])

    def step(self, t, length):
        """Integrate over a communication step."""
        self.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=length)


@contextmanager
def hosted(path, folder):
    """An instance that is freed in the end, whatever it has done."""
    host = Host(path, folder)
    try:
        yield host
    finally:
        host.fmu.freeInstance()


CONTROLLER = '''
from pythonfmu3 import Fmi3Causality, Fmi3Slave, Fmi3StepResult, Fmi3Variability, Float64


class {name}(Fmi3Slave):
    """u = P angle + I S + D rate, S += H angle after use."""

    def __init__(self, **given):
        super().__init__(**given)
        self.angle, self.rate, self.sum, self.P, self.I, self.D = 0.0, 0.0, 0.0, {P}, {I}, {D}
        self.time = 0.0
        self.register_variable(Float64("time", causality=Fmi3Causality.independent))
        for name in ("angle", "rate"):
            self.register_variable(Float64(name, causality=Fmi3Causality.input, variability=Fmi3Variability.continuous))
        self.register_variable(Float64("u", causality=Fmi3Causality.output, getter=lambda: self.output()))

    def output(self):
        return self.P * self.angle + self.I * self.sum + self.D * self.rate

    def do_step(self, current_time, step_size):
        self.sum += step_size * self.angle
        return Fmi3StepResult()
'''


def write_controller(folder, name="pid", P=60.0, I=40.0, D=8.0):  # noqa: E741
    """An FMU with a sampled controller, written by pythonfmu3 alone."""
    from pythonfmu3.builder import FmuBuilder

    script = folder / f"{name}_script.py"
    script.write_text(CONTROLLER.format(name=name, P=P, I=I, D=D))
    return FmuBuilder.build_FMU(script, dest=folder)
