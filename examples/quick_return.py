"""A quick return: a crank pin slides in a slotted lever; the stroke back is faster than the stroke forth.

The ratio of times is that of the crank angles between the extreme poses of the lever, (pi + 2 a) / (pi - 2 a) with
sin a = r / d.

Prints::

    the lever swings 47.1564 degrees, in theory 47.1564
    times 1.710 to 1, in theory 1.710
"""

import numpy as np

from mbsd3d import GROUND, Body, PointOnLine, Revolute, SpeedDriver, System, simulate

CRANK, DISTANCE, RATE = 0.1, 0.25, 5.0  # [m], [m], [rad/s]
Z = (0, 0, 1)

crank = Body("crank", 1.0, (1e-3, 1e-3, 2e-3), com=(0.04, 0, 0), position=(0, DISTANCE, 0))
pin = np.array([CRANK, DISTANCE, 0.0])
lever = Body("lever", 3.0, (0.1, 0.1, 0.1), com=(0.02, 0.2, 0))
joints = [
    shaft := Revolute(GROUND, crank, at=(0, DISTANCE, 0), axis=Z, name="shaft"),
    pivot := Revolute(GROUND, lever, at=(0, 0, 0), axis=Z, name="pivot"),
    PointOnLine(lever, crank, at=pin, axis=pin / np.linalg.norm(pin), name="slot"),
    SpeedDriver(shaft, RATE, name="motor"),
]
run = simulate(System([crank, lever], joints), 2 * np.pi / RATE, output=20001)
speed = run.rate(pivot)
forth = np.mean(speed[:-1] < 0)  # share of the turn
a = np.arcsin(CRANK / DISTANCE)
print(f"the lever swings {np.degrees(np.ptp(run.angle(pivot))):.4f} degrees, in theory {np.degrees(2 * a):.4f}")
longer = max(forth, 1 - forth)
print(f"times {longer / (1 - longer):.3f} to 1, in theory {(np.pi + 2 * a) / (np.pi - 2 * a):.3f}")
figure = run.plot([("angle", pivot), ("rate", pivot)])
