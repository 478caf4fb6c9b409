"""Washing machine: a drum with an unbalanced load spins in a tub that hangs on soft mounts.

Far above the resonance of the mounts the tub moves as if it floated: m r / M.

Prints::

    passing the resonance 9.3 mm, spinning 6.11 mm
    a floating tub would move 6.11 mm
"""

import numpy as np

from mbsd3d import GROUND, Body, Bushing, Pulse, Revolute, SpeedDriver, System, inertia, simulate

TUB, DRUM, LAUNDRY, RADIUS = 25.0, 10.0, 1.0, 0.22  # [kg], [kg], [kg], [m]
SPEED = 2 * np.pi * 1000 / 60  # [rad/s]

turning = inertia.combine([
    (DRUM, (0, 0, 0), inertia.cylinder(DRUM, 0.24, 0.3, "y")),
    (LAUNDRY, (RADIUS, 0, 0), inertia.sphere(LAUNDRY, 0.05)),
])  # fmt: skip
tub = Body("tub", TUB, inertia.cylinder(TUB, 0.3, 0.4, "y"))
drum = Body("drum", **vars(turning))
shaft = Revolute(tub, drum, at=(0, 0, 0), axis=(0, 1, 0), name="shaft")
corners = [(x, y, -0.2) for x in (-0.25, 0.25) for y in (-0.2, 0.2)]
mounts = [
    Bushing(GROUND, tub, at=at, stiffness=4000.0, damping=150.0, name=f"mount {k}") for k, at in enumerate(corners, 1)
]
motor = SpeedDriver(shaft, Pulse(height=SPEED, start=0.0, edge=4.0, duration=60.0), name="motor")
machine = System([tub, drum], [shaft, motor], mounts, gravity=(0, 0, 0))  # weight would only shift the mounts

run = simulate(machine, 8.0, output=4001, rtol=1e-7)
x = run.position(tub)[:, 0]
passing, spinning = np.ptp(x[run.t < 4.0]) / 2, np.ptp(x[run.t > 7.5]) / 2
print(f"passing the resonance {1e3 * passing:.1f} mm, spinning {1e3 * spinning:.2f} mm")
print(f"a floating tub would move {1e3 * LAUNDRY * RADIUS / (TUB + DRUM + LAUNDRY):.2f} mm")
figure = run.plot([("position", tub), ("rate", shaft)])
