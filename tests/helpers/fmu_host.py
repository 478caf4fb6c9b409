"""A host of FMUs for the tests, by FMPy: one FMU, its variables by name, and what it logs. Needs the extra fmu."""

from contextlib import contextmanager

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave

from mbsd3d import GROUND, Body, Force, Prismatic, SpringDamper, System, measures

__all__ = ["FMICallException", "Host", "half_of_a_pair", "hosted", "write_controller", "write_old_controller"]


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
        self.register_variable(Float64("sum", causality=Fmi3Causality.local))
        self.register_variable(Float64("u", causality=Fmi3Causality.output, getter=lambda: self.output()))

    def output(self):
        return self.P * self.angle + self.I * self.sum + self.D * self.rate

    def do_step(self, current_time, step_size):
        self.sum += step_size * self.angle
        return Fmi3StepResult()
'''


def write_controller(folder, name="pid", P=60.0, I=40.0, D=8.0, goes_back=False):  # noqa: E741
    """An FMU with a sampled controller, written by pythonfmu3 alone; it may offer its state, which is its variables."""
    from pythonfmu3.builder import FmuBuilder

    script = folder / f"{name}_script.py"
    script.write_text(CONTROLLER.format(name=name, P=P, I=I, D=D))
    return FmuBuilder.build_FMU(script, dest=folder, canGetAndSetFMUState=goes_back)


OLD_CONTROLLER = '''
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class old(Fmi2Slave):
    """u = 60 angle + 40 S + 8 rate, S += H angle after use."""

    def __init__(self, **given):
        super().__init__(**given)
        self.angle = self.rate = self.sum = 0.0
        for name, causality in (("angle", "input"), ("rate", "input"), ("sum", "local")):
            self.register_variable(Real(name, causality=Fmi2Causality[causality]))
        self.register_variable(Real("u", causality=Fmi2Causality.output, getter=lambda: self.output()))

    def output(self):
        return 60.0 * self.angle + 40.0 * self.sum + 8.0 * self.rate

    def do_step(self, current_time, step_size):
        self.sum += step_size * self.angle
        return True
'''


def write_old_controller(folder):
    """The controller as an FMU of FMI 2.0, by pythonfmu, with its state."""
    from pythonfmu.builder import FmuBuilder

    script = folder / "old_script.py"
    script.write_text(OLD_CONTROLLER)
    return FmuBuilder.build_FMU(script, dest=folder, handle_state=True, canGetAndSetFMUstate=True)


def half_of_a_pair(name, mass, stiffness, damping, pull, x=0.0):
    """A mass on a rail between the ground, by a spring and a damper, and a pull."""
    body = Body(name, mass, (0.1, 0.1, 0.1), position=(x, 0, 0), velocity=(0, 0, 0), omega=(0, 0, 0))
    rail = Prismatic(GROUND, body, at=(x, 0, 0), axis=(1, 0, 0), name=f"rail of {name}")
    spring = SpringDamper(
        GROUND, body, at_a=(-9.0, 0, 0), at_b=(x, 0, 0), stiffness=stiffness, damping=damping, length=9.0
    )
    force = Force(body, (pull, 0, 0))
    return System([body], [rail], [spring, force], name=name), measures.position(body, axis=(1, 0, 0)), rail
