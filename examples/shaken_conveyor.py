"""Shaker test of a vibrating conveyor: a trough on leaf springs and its frame on mounts; where does it resonate?

What the linear model says of a force on the frame, and a run of the whole mechanism that is shaken by a sine.

Prints::

    modes at 2.75, 3.68, 4.86, 16.31 Hz
    a push of 1 N at 9 Hz: trough 7.30 mm/s^2, floor 0.11 N by the model
    shaken by 20 N at 9 Hz: trough 7.30 mm/s^2, floor 0.11 N a newton
    the pushed point all but stands still at 3.67, 4.69, 13.91 Hz
"""

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    Bushing,
    Force,
    Input,
    Planar,
    Revolute,
    Sine,
    System,
    TorsionSpring,
    inertia,
    measures,
    simulate,
    state_space,
)

LEAF = 0.25 * np.array([-0.5, 0.0, np.sqrt(0.75)])  # [m] from frame to trough: leaves lean by 30 degrees
SIDE, HERTZ, PUSH = (0, 1, 0), 9.0, 20.0


def conveyor(push):
    """A conveyor that moves in its plane, pushed on its frame along x; its weight would only shift it."""
    frame = Body("frame", 120.0, inertia.box(120.0, (2.0, 0.5, 0.2)))
    trough = Body("trough", 60.0, inertia.box(60.0, (2.2, 0.4, 0.15)), position=LEAF + (0, 0, 0.15))
    bodies, joints = [frame, trough], [Planar(GROUND, frame, at=(0, 0, 0), normal=SIDE, name="plane")]
    forces = [Force(frame, (push, 0, 0), at=(0.3, 0, 0.05), name="shaker")]
    for end, x in (("rear", -0.8), ("front", 0.8)):
        foot = np.array([x, 0, 0.1])
        leaf = Body(f"{end} leaf", 2.0, (0.01, 0.01, 0.001), position=foot + LEAF / 2)
        clamps = [
            Revolute(frame, leaf, at=foot, axis=SIDE, name=f"{end} foot"),
            Revolute(leaf, trough, at=foot + LEAF, axis=SIDE, name=f"{end} head"),
        ]
        bodies.append(leaf)
        joints += clamps
        forces += [TorsionSpring(clamp, stiffness=6000.0, damping=8.0) for clamp in clamps]  # the leaves bend
        forces.append(
            Bushing(GROUND, frame, at=(x, 0, -0.1), stiffness=(3e4, 3e4, 5e4), damping=(200, 200, 300),
                    name=f"{end} mount")
        )  # fmt: skip
    return System(bodies, joints, forces, gravity=(0, 0, 0))


shaken = conveyor(Input("push"))
outputs = [("acceleration", "trough"), ("force", "rear mount"), ("force", "front mount")]
model = state_space(shaken, outputs=outputs)  # model.bode() draws it
frequencies = model.poles.imag[model.poles.imag > 0.0] / (2 * np.pi)
print("modes at", ", ".join(f"{x:.2f}" for x in np.sort(frequencies)), "Hz")
H = dict(zip(model.outputs, model.frequency_response([2 * np.pi * HERTZ]).H[0, :, 0], strict=True))
trough, floor = H["acceleration x of trough"], H["force x of rear mount"] + H["force x of front mount"]
print(f"a push of 1 N at 9 Hz: trough {1e3 * abs(trough):.2f} mm/s^2, floor {abs(floor):.2f} N by the model")

times = 10.0 + np.arange(288) / 144.0  # the slowest mode has died out by then
run = simulate(conveyor(Sine(PUSH, HERTZ)), times[-1], rtol=1e-8, output=times)
trough = run.spectrum("acceleration", "trough").at(HERTZ)[0]
floor = sum(run.spectrum("force", f"{end} mount").at(HERTZ)[0] for end in ("rear", "front"))
print(f"shaken by {PUSH:g} N at 9 Hz: trough {1e3 * abs(trough) / PUSH:.2f} mm/s^2, ", end="")
print(f"floor {abs(floor) / PUSH:.2f} N a newton")

pushed_point = measures.position(shaken.part("frame"), axis=(1, 0, 0), at=(0.3, 0, 0.05))
at_shaker = state_space(shaken, outputs=[pushed_point])
zeros = at_shaker.zeros
still = np.sort(zeros.imag[zeros.imag > 0.0]) / (2 * np.pi)
print("the pushed point all but stands still at", ", ".join(f"{x:.2f}" for x in still), "Hz")
figure = at_shaker.bode()
