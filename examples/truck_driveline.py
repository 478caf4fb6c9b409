"""A truck's driveline: two crosses between gearbox and axle. In phase they cancel, a quarter turn out they add.

Prints::

    in phase: 150.0000 to 150.0000 rad/s
    out of phase: 147.0946 to 152.9628 rad/s
    in theory out of phase 147.0946 to 152.9628 rad/s
"""

import numpy as np

from mbsd3d import GROUND, Body, Cylindrical, Revolute, SpeedDriver, System, Universal, rotation, simulate

BEND, RATE, LENGTH = np.radians(8.0), 150.0, 1.6


def line(out_of_phase):
    """Gearbox shaft, propeller shaft and pinion, parallel at both ends (Z arrangement)."""
    along = np.array([np.cos(BEND), 0, -np.sin(BEND)])
    turn = rotation("y", BEND)
    far = LENGTH * along
    gearbox = Body("gearbox", 3.0, (0.02, 0.05, 0.05), position=(-0.2, 0, 0))
    shaft = Body("shaft", 15.0, (0.05, 3.0, 3.0), position=far / 2, orientation=turn)
    pinion = Body("pinion", 4.0, (0.03, 0.05, 0.05), position=far + (0.2, 0, 0))
    y, across = np.array([0, 1.0, 0]), np.array([np.sin(BEND), 0, np.cos(BEND)])
    fork = (y, np.array([0, 0, 1.0])) if not out_of_phase else (across, y)
    return System(
        [gearbox, shaft, pinion],
        [
            first := Revolute(GROUND, gearbox, at=(-0.2, 0, 0), axis=(1, 0, 0), name="in"),
            Universal(gearbox, shaft, at=(0, 0, 0), axis_a=(0, 0, 1), axis_b=y, name="cross 1"),
            Universal(shaft, pinion, at=far, axis_a=fork[0], axis_b=fork[1], name="cross 2"),
            Cylindrical(GROUND, pinion, at=far + (0.2, 0, 0), axis=(1, 0, 0), name="out"),
            SpeedDriver(first, RATE, name="engine"),
        ],
        gravity=(0, 0, 0),
    )


for out_of_phase in (False, True):
    run = simulate(line(out_of_phase), 2 * np.pi / RATE, output=361)
    rate = run.rate("out")
    print(f"{'out of' if out_of_phase else 'in'} phase: {rate.min():.4f} to {rate.max():.4f} rad/s")
print(f"in theory out of phase {RATE * np.cos(BEND) ** 2:.4f} to {RATE / np.cos(BEND) ** 2:.4f} rad/s")
figure = run.plot("rate", "in", "out")
