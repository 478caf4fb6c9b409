"""A pendulum clock: at every passage to the right the escapement gives the same small energy; the air takes it back.

Runs from event to event: stop at the lowest point, add to the speed, go on. The swing grows to where both are equal.

Prints::

    it swings by 5.887 degrees, small swings in theory 5.885
    a tick-tock takes 2.003499 s, small swings without air 2.002063 s
"""

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from mbsd3d import GROUND, Body, Revolute, System, TorsionSpring, measures, simulate

MASS, LENGTH, DAMPING, ENERGY = 0.5, 0.994, 0.04, 4e-3  # [kg], [m], [N m s/rad], [J]

bob = Body("bob", MASS, (1e-3, 1e-3, 1e-3), com=(0, 0, -LENGTH))
hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, -1, 0), name="hinge")
clock = System([bob], [hinge], [TorsionSpring(hinge, stiffness=0.0, damping=DAMPING, name="air")], name="clock")
inertia = 1e-3 + MASS * LENGTH**2


def until(state, condition):
    """On from a state to the next event."""
    return simulate(clock, state.t + 5.0, state=state, rtol=1e-9, stop_when=condition)


state = clock.assemble(rates={hinge: 0.05})
ticks: list[tuple[float, float]] = []
while len(ticks) < 60:
    forth = until(state, measures.rate(hinge) < 0.0)
    back = until(forth.final, measures.rate(hinge) > 0.0)
    swing = until(back.final, measures.angle(hinge) > 0.0)
    rate = swing.rate(hinge)[-1]
    ticks.append((swing.final.t, forth.angle(hinge)[-1]))
    faster = np.sqrt(rate**2 + 2 * ENERGY / inertia)
    state = replace(swing.final, v=swing.final.v * faster / rate)
times, swings = np.array(ticks).T
frequency = np.sqrt(MASS * 9.81 * LENGTH / inertia)
period = 2 * np.pi / frequency
kept = np.exp(-DAMPING / inertia * period)  # share of the energy that is left after a period
energy = ENERGY / (1 - kept) * kept**0.25  # a quarter of a period after the push
theory = np.sqrt(2 * energy / (MASS * 9.81 * LENGTH))
print(f"it swings by {np.degrees(swings[-1]):.3f} degrees, small swings in theory {np.degrees(theory):.3f}")
print(f"a tick-tock takes {times[-1] - times[-2]:.6f} s, small swings without air {period:.6f} s")

figure = Figure(figsize=(6.4, 3.6), layout="constrained")
axes = figure.subplots()
axes.plot(times, np.degrees(swings), ".-", label="swing")
axes.axhline(np.degrees(theory), color="grey", label="theory")
axes.set(xlabel="time [s]", ylabel="swing [deg]")
axes.legend()
