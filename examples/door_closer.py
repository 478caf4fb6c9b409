"""A door closer: a spring pulls the door shut, a damper brakes it, and a stop ends it. How fast does it meet the frame?

Prints::

    4 N m s: shut after 1.40 s, its edge meets the frame at 1.573 m/s (exact 1.573)
    20 N m s: shut after 2.43 s, its edge meets the frame at 0.478 m/s (exact 0.478)
    40 N m s: shut after 4.61 s, its edge meets the frame at 0.198 m/s (exact 0.198)
"""

import numpy as np
from matplotlib.figure import Figure

from mbsd3d import GROUND, Body, EndStop, Revolute, System, TorsionSpring, inertia, measures, simulate

WIDTH, OPEN = 0.9, np.radians(90.0)
K, PRELOAD = 8.0, np.radians(60.0)  # N m/rad, wound up when the door is shut

leaf = Body("door", 35.0, inertia.box(35.0, (WIDTH, 0.04, 2.0)), position=(0, 0.01, 0), com=(WIDTH / 2, 0.0, 0))
hinge = Revolute(GROUND, leaf, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
moment = leaf.inertia[2, 2] + 35.0 * ((WIDTH / 2) ** 2 + 0.01**2)  # kg m^2 about the hinge


def close(damping):
    """Return the run from the open door until it has come to rest in the frame."""
    spring = TorsionSpring(hinge, stiffness=K, damping=damping, angle=-PRELOAD, name="closer")
    frame = EndStop(hinge, lower=0.0, stiffness=2e4, damping=300.0, name="frame")
    door = System([leaf], [hinge], [spring, frame])
    return simulate(door, 20.0, state=door.assemble(angles={hinge: OPEN}), stop_when=measures.angle(hinge) < 0.0)


figure = Figure(figsize=(6.4, 3.6), layout="constrained")
axes = figure.subplots()
for damping in (4.0, 20.0, 40.0):
    run = close(damping)
    decay, root = damping / (2 * moment), np.sqrt(complex((damping / (2 * moment)) ** 2 - K / moment))
    t = run.t[-1]
    rate = -(OPEN + PRELOAD) * K / moment * (np.exp(-decay * t) * np.sinh(root * t) / root).real
    found, exact = -WIDTH * run.rate(hinge)[-1], -WIDTH * rate
    print(f"{damping:.0f} N m s: shut after {t:.2f} s, its edge meets the frame at {found:.3f} m/s (exact {exact:.3f})")
    axes.plot(run.t, np.degrees(run.angle(hinge)), label=f"{damping:.0f} N m s")
axes.set(xlabel="time [s]", ylabel="opening [deg]")
axes.legend()
