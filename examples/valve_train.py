"""A valve train: a cam lifts a valve against its spring. At which speed does the valve leave the cam?

The effort of the driver is the force of the cam; where it turns negative, the valve floats.

Prints::

      2400 strokes a minute: least force   286.72 N
      6000 strokes a minute: least force   291.95 N
      9600 strokes a minute: least force   -77.57 N
    it floats from 149.4169 Hz, in theory 149.4169 Hz
"""

import numpy as np

from mbsd3d import GROUND, Body, Kinematic, Prismatic, Sine, SlideDriver, System, TorsionSpring, simulate

LIFT, MASS, STIFFNESS, PRELOAD = 0.010, 0.12, 28e3, 250.0  # [m], [kg], [N/m], [N]

valve = Body("valve", MASS, (1e-4, 1e-4, 1e-5))
guide = Prismatic(GROUND, valve, at=(0, 0, 0), axis=(0, 0, -1), name="guide")  # it opens downwards
spring = TorsionSpring(guide, stiffness=STIFFNESS, angle=-PRELOAD / STIFFNESS, name="spring")


def least_force(frequency):
    """Least force between cam and valve [N] at a frequency of strokes [Hz]."""
    stroke = Sine(LIFT / 2, frequency, -np.pi / 2, offset=LIFT / 2)
    cam = SlideDriver(guide, stroke, name="cam")
    run = simulate(System([valve], [guide, cam], [spring]), 1.0 / frequency, method=Kinematic(), output=721)
    return run.effort(cam).min()


for frequency in (40.0, 100.0, 160.0):
    print(f"{60 * frequency:6.0f} strokes a minute: least force {least_force(frequency):8.2f} N")
low, high = 100.0, 200.0
for _ in range(30):
    middle = (low + high) / 2
    low, high = (middle, high) if least_force(middle) > 0 else (low, middle)
top = PRELOAD + STIFFNESS * LIFT - MASS * 9.81  # at full lift the spring alone turns the valve round
print(f"it floats from {low:.4f} Hz, in theory {np.sqrt(2 * top / (MASS * LIFT)) / (2 * np.pi):.4f} Hz")
