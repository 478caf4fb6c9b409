"""A fan on rubber runs up: where does its unbalance shake the housing, and what does the Campbell diagram say?

Of four critical speeds across the shaft an unbalance excites the forward ones alone; peaks come late, as it hurries.

Prints::

    Campbell diagram: backward 86.5, forward 87.4, backward 138.0, forward 255.3 rad/s
    run-up at 4 rad/s^2: 15.1 m/s^2 at 90.2 rad/s, 13.3 m/s^2 at 266.8 rad/s, 13.6 m/s^2 at the end
"""

import numpy as np

from mbsd3d import GROUND, Body, Bushing, Polynomial, Revolute, SpeedDriver, System, campbell, inertia, simulate

ACCELERATION, SHAFT = 4.0, (0, 0, 1)  # [rad/s^2]


def fan(speed, *weights):
    """A fan with unbalanced weights (mass [kg], place [m]) in a housing on two rubber mounts, driven at a speed."""
    point = np.zeros((3, 3))
    turning = inertia.combine([(20.0, (0, 0, 0), (0.4, 0.4, 0.25)), *((mass, at, point) for mass, at in weights)])
    housing, wheel = Body("housing", 5.0, (0.05, 0.05, 0.05)), Body("wheel", **vars(turning))
    shaft = Revolute(housing, wheel, at=(0, 0, 0), axis=SHAFT, name="shaft")
    soft = dict(stiffness=(1e5, 1e5, 1e6), damping=(60, 60, 100), turning_stiffness=(0, 0, 1e4),
                turning_damping=(0, 0, 10))  # fmt: skip
    mounts = [Bushing(GROUND, housing, at=(0, 0, z), name=f"mount {z}", **soft) for z in (-0.2, 0.3)]
    return System([housing, wheel], [shaft, SpeedDriver(shaft, speed, name="motor")], mounts, gravity=(0, 0, 0))


balanced = fan(0.0)
diagram = campbell(balanced, spin=balanced.part("shaft", "joints"), speeds=np.linspace(0.0, 300.0, 7))
across = [x for x in diagram.critical_speeds() if x.whirl != "planar"]
print("Campbell diagram:", ", ".join(f"{x.whirl} {x.speed:.1f}" for x in across), "rad/s")

running = fan(Polynomial((10.0, ACCELERATION)), (0.02, (0.1, 0, 0.15)), (0.02, (0, 0.1, -0.05)))
run = simulate(running, 75.0, output=751, rtol=1e-7)
seen = run.waterfall("shaft", "acceleration", "housing", turns=4, per_turn=16)  # seen.plot() draws it
once = np.linalg.norm(np.abs(seen.at(1)), axis=1) / np.sqrt(2.0)  # a circle has its radius as both amplitudes
print(f"run-up at {ACCELERATION:g} rad/s^2:", end=" ")
for critical in (x.speed for x in across if x.whirl == "forward"):
    near = np.flatnonzero(np.abs(seen.speeds / critical - 1.0) < 0.1)
    peak = near[once[near].argmax()]
    print(f"{once[peak]:.1f} m/s^2 at {seen.speeds[peak]:.1f} rad/s", end=", ")
print(f"{once[-1]:.1f} m/s^2 at the end")
figure = seen.plot()
