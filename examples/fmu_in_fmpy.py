"""A cart with a pole as an FMU, balanced in FMPy by a controller: it steps back to an earlier state, and goes on alike.

Needs the extra fmu: pip install "mbsd3d[fmu]". Prints::

    stand.fmu: valid, 3 inputs and parameters, 8 outputs
    after 3.0 s the pole is at 0.0062 rad, the cart at 0.1567 m
    from 1.0 s once more: the same numbers to the last digit
    certificate passed
"""

import fmpy
import numpy as np
from fmpy.fmi3 import FMU3Slave
from fmpy.validation import validate_fmu

from mbsd3d import GROUND, Body, Force, Input, Prismatic, Revolute, System, measures

cart = Body("cart", 1.0, (0.1, 0.1, 0.1))
pole = Body("pole", 0.3, (0.02, 0.02, 0.001), com=(0, 0, 0.5))
rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
pin = Revolute(cart, pole, at=(0, 0, 0), axis=(0, 1, 0), name="pin")
stand = System([cart, pole], [rail, pin], [Force(cart, (Input("push"), 0, 0))], name="stand")
path = stand.to_fmu(
    "stand.fmu",
    state=stand.assemble(angles={pin: 0.2}),
    outputs={
        "x": measures.slide(rail),
        "v": measures.slide_rate(rail),
        "angle": measures.angle(pin),
        "rate": measures.rate(pin),
    },
    parameters=["pole.mass", "cart.mass"],
)
model = fmpy.read_model_description(str(path))
kinds = [x.causality for x in model.modelVariables]
given, outputs = kinds.count("input") + kinds.count("parameter"), kinds.count("output")
print(f"{path}: {validate_fmu(str(path)) or 'valid'}, {given} inputs and parameters, {outputs} outputs")

folder = fmpy.extract(str(path))
name = model.coSimulation.modelIdentifier
fmu = FMU3Slave(guid=model.guid, unzipDirectory=folder, modelIdentifier=name, instanceName="one")
place = {x.name: x.valueReference for x in model.modelVariables}
seen, push = [place[name] for name in ("x", "v", "angle", "rate")], [place["push"]]
gains = np.array([3.0, 5.0, 60.0, 14.0])


def balanced(t, t_end, every=0.01):
    """The outputs at t_end, with a push that is set every 10 ms."""
    for k in range(round(t / every), round(t_end / every)):
        fmu.setFloat64(push, [float(gains @ fmu.getFloat64(seen))])
        fmu.doStep(currentCommunicationPoint=k * every, communicationStepSize=every)
    return fmu.getFloat64(seen)


fmu.instantiate(logMessage=lambda *said: None)  # the certificate comes here in the end
fmu.enterInitializationMode(startTime=0.0)
fmu.exitInitializationMode()
balanced(0.0, 1.0)
there = fmu.getFMUState()
x, _, angle, _ = end = balanced(1.0, 3.0)
print(f"after 3.0 s the pole is at {angle:.4f} rad, the cart at {x:.4f} m")
fmu.setFMUState(there)
print("from 1.0 s once more:", "the same numbers to the last digit" if balanced(1.0, 3.0) == end else "others")
fmu.freeFMUState(there)
fmu.terminate()
print("certificate", "passed" if fmu.getBoolean([place["certificate.passed"]])[0] else "failed")
fmu.freeInstance()
figure = stand.picture()
