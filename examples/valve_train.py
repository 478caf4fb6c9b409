"""A valve train: a cam lifts a valve against its spring. At which speed does the valve leave the cam?

The cam is an eccentric disc under a flat face. Where its force on the valve turns negative, the valve floats.

Prints::

      2400 strokes a minute: least force   286.72 N
      6000 strokes a minute: least force   291.95 N
      9600 strokes a minute: least force   -77.57 N
    'cam' lifts off at t = 0.00254305 s: its row pulls with up to 77.57 N
    it floats from 149.4169 Hz, in theory 149.4169 Hz
"""

import numpy as np
from matplotlib.figure import Figure

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    CurveContact,
    Kinematic,
    Prismatic,
    Ramp,
    Revolute,
    System,
    TorsionSpring,
    simulate,
)

LIFT, RADIUS, MASS, STIFFNESS, PRELOAD = 0.010, 0.020, 0.12, 28e3, 250.0  # [m], [m], [kg], [N/m], [N]

turn = 2 * np.pi * np.arange(180) / 180
disc = np.column_stack([0 * turn, RADIUS * np.sin(turn), LIFT / 2 + RADIUS * np.cos(turn)])
shut = np.array([0, 0, LIFT / 2 - RADIUS])  # the lowest point of the disc, whose centre is up
shaft = Body("shaft", 1.0, (1e-3, 1e-3, 1e-3))
valve = Body("valve", MASS, (1e-4, 1e-4, 1e-5), position=shut)
bearing = Revolute(GROUND, shaft, at=(0, 0, 0), axis=(1, 0, 0), name="bearing")
guide = Prismatic(GROUND, valve, at=shut, axis=(0, 0, -1), name="guide")  # it opens downwards
cam = CurveContact(shaft, valve, disc, at=shut, face=(0, 0, -1), name="cam")
spring = TorsionSpring(guide, stiffness=STIFFNESS, angle=-PRELOAD / STIFFNESS, name="spring")


def one_turn(frequency):
    """The motion over a turn of the shaft at a frequency [Hz]."""
    motor = AngleDriver(bearing, Ramp(2 * np.pi * frequency), name="motor")
    system = System([shaft, valve], [bearing, guide, cam, motor], [spring])
    return simulate(system, 1.0 / frequency, method=Kinematic(), output=721)


def least_force(frequency):
    """Least force between cam and valve [N]."""
    return cam.normal_force(one_turn(frequency)).min()


for frequency in (40.0, 100.0, 160.0):
    print(f"{60 * frequency:6.0f} strokes a minute: least force {least_force(frequency):8.2f} N")
print(*one_turn(160.0).certificate.notes)
low, high = 100.0, 200.0
for _ in range(30):
    middle = (low + high) / 2
    low, high = (middle, high) if least_force(middle) > 0 else (low, middle)
top = PRELOAD + STIFFNESS * LIFT - MASS * 9.81  # at full lift the spring alone turns the valve round
print(f"it floats from {low:.4f} Hz, in theory {np.sqrt(2 * top / (MASS * LIFT)) / (2 * np.pi):.4f} Hz")

figure = Figure(figsize=(6.4, 3.6), layout="constrained")
axes = figure.subplots()
for frequency in (40.0, 100.0, 160.0):
    run = one_turn(frequency)
    axes.plot(np.degrees(run.angle(bearing)), cam.normal_force(run), label=f"{60 * frequency:.0f} strokes a minute")
axes.set(xlabel="angle of the shaft [deg]", ylabel="force on the cam [N]")
axes.legend()
