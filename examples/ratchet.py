"""A rack jack: an arm swings a lever to and fro, one pawl takes the pinion along, and another one holds the load.

Prints::

    <0.0670998206 s: 'holding pawl' lets go>
    <0.313908444 s: 'holding pawl' passes a tooth>
    <0.466328896 s: 'holding pawl' passes a tooth>
    <0.675056154 s: 'holding pawl' passes a tooth>
    <0.865022249 s: 'holding pawl' catches, 'driving pawl' runs free, 0.0692479 J lost>
    <1.5200022 s: 'driving pawl' locks>
    <1.5692434 s: 'holding pawl' lets go>
    3 strokes raise the load by 9.000000 teeth, in theory 3 floor(3.121) = 9
    the pawl takes 0.203 J in its knocks, the load gains 83.211 J
"""

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    Constant,
    Cylindrical,
    Freewheel,
    Prismatic,
    RackPinion,
    Ratchet,
    Revolute,
    Sine,
    System,
    Torque,
    TorsionSpring,
    simulate,
)

LOAD, RADIUS, TEETH, G = 50.0, 0.06, 20, 9.81  # kg, m of the pinion, teeth of the holding ratchet
SWING, PERIOD, ARM, STROKES = 1.0, 1.5, 1500.0, 3  # rad, s to and fro, N m/rad of the arm that moves the lever

lever = Body("lever", 1.5, (0.05, 0.05, 0.05), com=(0, 0.02, 0.15))
pinion = Body("pinion", 8.0, (0.02, 0.03, 0.02))
load = Body("load", LOAD, (2.0, 2.0, 2.0), position=(RADIUS, 0, -1.0))
pivot = Revolute(GROUND, lever, at=(0, -0.1, 0), axis="y", name="pivot")
axle = Revolute(GROUND, pinion, at=(0, 0, 0), axis="y", name="axle")
between = Cylindrical(lever, pinion, at=(0, -0.05, 0), axis="y", name="between")
guide = Prismatic(GROUND, load, at=load.position, axis="z", name="guide")
rack = RackPinion(axle, guide, radius=RADIUS, name="rack")
wanted = Constant(SWING / 2) + Sine(-SWING / 2, 1 / PERIOD, np.pi / 2)  # angle that the arm goes for
forces = [
    Torque(lever, (0, ARM * wanted, 0), name="arm"),
    TorsionSpring(pivot, stiffness=ARM, damping=30.0, name="elbow"),
    Freewheel(between, name="driving pawl"),
    Ratchet(axle, teeth=TEETH, name="holding pawl"),
]
jack = System([lever, pinion, load], [pivot, axle, between, guide, rack], forces, name="rack jack")

run = simulate(jack, STROKES * PERIOD)
for event in run.events:
    if event.t < PERIOD + 0.1:
        print(event)
pitch = 2 * np.pi / TEETH
reach = SWING - LOAD * G * RADIUS / ARM  # of a stroke, less what the arm yields
print(f"{STROKES} strokes raise the load by {run.angle(axle)[-1] / pitch:.6f} teeth, ", end="")
print(f"in theory {STROKES} floor({reach / pitch:.3f}) = {STROKES * np.floor(reach / pitch):.0f}")
lost = sum(event.lost for event in run.events)
print(f"the pawl takes {lost:.3f} J in its knocks, the load gains {LOAD * G * run.slide(guide)[-1]:.3f} J")
figure = run.plot([("angle", pivot), ("angle", axle)], degrees=True)
