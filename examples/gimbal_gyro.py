"""A gyroscope in gimbals with a weight on its inner ring: it does not fall, it walks around the vertical.

The rate of the walk is the moment of the weight over the spin momentum, m g l / (I Omega).

Prints::

    walk 0.15696 rad/s, in theory 0.15696 rad/s
    inner ring sinks by less than 0.1 degrees: True
"""

import numpy as np

from mbsd3d import GROUND, Body, Revolute, System, simulate

SPIN, INERTIA, WEIGHT, ARM = 500.0, 0.01, 0.4, 0.2  # [rad/s], [kg m^2], [kg], [m]

walk = WEIGHT * 9.81 * ARM / (INERTIA * SPIN)
outer = Body("outer ring", 0.5, (2e-3, 1e-3, 1e-3), omega=(0, 0, walk))
inner = Body("inner ring", WEIGHT, (1e-4, 1e-4, 1e-4), com=(ARM, 0, 0), omega=(0, 0, walk))
wheel = Body("wheel", 2.0, (INERTIA, 0.006, 0.006), omega=(SPIN, 0, walk))
rings = [
    Revolute(GROUND, outer, at=(0, 0, 0), axis=(0, 0, 1), name="vertical"),
    Revolute(outer, inner, at=(0, 0, 0), axis=(0, 1, 0), name="level"),
    Revolute(inner, wheel, at=(0, 0, 0), axis=(1, 0, 0), name="spin"),
]
run = simulate(System([outer, inner, wheel], rings), 5.0)
print(f"walk {run.angle('vertical')[-1] / 5.0:.5f} rad/s, in theory {walk:.5f} rad/s")
print("inner ring sinks by less than 0.1 degrees:", bool(np.abs(np.degrees(run.angle("level"))).max() < 0.1))
figure = run.picture()
