"""Gear rattle: an engine shakes the driving gear, the loose gear is thrown from flank to flank of its backlash.

Prints::

    200 impacts in 100 turns of the engine, two a turn
    the loose gear flies at 0.189558 rad/s, in theory 0.189558
    each impact takes 1.60 mJ, so the driver gives 0.05 W
"""

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import brentq

from mbsd3d import GROUND, AngleDriver, Backlash, Body, Gear, Revolute, Sine, System, simulate

SWING, SPEED, PLAY, BOUNCE = 1e-3, 100.0, 4e-3, 0.8  # of the driver [rad], [rad/s]; whole play [rad]; restitution
RATIO, INERTIA = -2.0, 0.2  # [kg m^2] of the loose gear

pinion = Body("pinion", 1.0, (0.05, 0.05, 0.1))
wheel = Body("loose gear", 2.0, (0.1, 0.1, INERTIA), position=(0.3, 0, 0))
fast = Revolute(GROUND, pinion, at=(0, 0, 0), axis=(0, 0, 1), name="fast shaft")
slow = Revolute(GROUND, wheel, at=(0.3, 0, 0), axis=(0, 0, 1), name="slow shaft")
engine = AngleDriver(fast, Sine(SWING / RATIO, SPEED / (2 * np.pi)), name="engine")
teeth = Backlash(Gear(fast, slow, ratio=RATIO), angle=PLAY, restitution=BOUNCE, name="teeth")
box = System([pinion, wheel], [fast, slow, engine], [teeth], name="gear rattle")

turn = 2 * np.pi / SPEED
run = simulate(box, 100 * turn, state=box.assemble(rates={slow: 0.19}), rtol=1e-10)
print(f"{len(run.events)} impacts in 100 turns of the engine, two a turn")


def flight(phase):
    """Rate [rad/s] between impacts at opposite phases: half a turn for the play and twice the swing."""
    return 2 * SPEED / np.pi * (SWING * np.sin(phase) + PLAY / 2)


def missing(phase):
    """How far the law of impact is from what the motion needs."""
    return SWING * SPEED * np.cos(phase) + flight(phase) * (1 - BOUNCE) / (1 + BOUNCE)


rate = flight(brentq(missing, np.pi / 2, np.pi))
print(f"the loose gear flies at {abs(run.rate(slow)[-1]):.6f} rad/s, in theory {rate:.6f}")
lost = run.events[-1].lost
print(f"each impact takes {1e3 * lost:.2f} mJ, so the driver gives {2 * lost / turn:.2f} W")

late = run.t > 97 * turn
figure = Figure(figsize=(6.4, 3.6), layout="constrained")
axes = figure.subplots()
axes.plot(run.t[late], RATIO * run.rate(fast)[late], label="driver")
axes.plot(run.t[late], run.rate(slow)[late], label="loose gear")
axes.set(xlabel="time [s]", ylabel="rate at the loose gear [rad/s]")
axes.legend()
