"""A door is pushed open, strikes its stop, is drawn back by a spring, and the latch catches: what do the hinges feel?

Prints::

    <0.509901025 s: 'stop' is struck at its upper limit, 20.5139 J lost>
    <1.43943518 s: 'latch' engages, 12.5774 J lost>
        by energy 20.5139 and 12.5774 J
        latch 0.850 m from the hinge, which takes 5.705 N s (exact 5.705)
    <0.509901025 s: 'stop' is struck at its upper limit, 20.5139 J lost>
    <1.43943518 s: 'latch' engages, 12.5774 J lost>
        by energy 20.5139 and 12.5774 J
        latch 0.600 m from the hinge, which takes 0.000 N s (exact 0.000)
"""

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    EndStop,
    PointOnPlane,
    Revolute,
    Switched,
    System,
    TorsionSpring,
    inertia,
    measures,
    simulate,
)

MASS, WIDTH, THICKNESS, HEIGHT = 20.0, 0.9, 0.04, 2.0
OPEN, REBOUND, SPRING, PUSHED = 1.7, 0.4, 6.0, 3.5  # rad to the stop, its restitution, N m/rad, rad/s
ABOUT_HINGE = MASS * (WIDTH**2 / 3 + THICKNESS**2 / 12)


def house(latch_at):
    """Return the door, shut, with its hinge, a closer, a stop, and a latch at a distance from the hinge [m]."""
    size = (WIDTH, THICKNESS, HEIGHT)
    leaf = Body("door", MASS, inertia.box(MASS, size), com=(WIDTH / 2, 0, 0), omega=(0, 0, PUSHED))
    hinge = Revolute(GROUND, leaf, at=(0, 0, 0), axis="z", name="hinge")
    bolt = PointOnPlane(GROUND, leaf, at=(latch_at, 0, 0), normal="y")
    latch = Switched(bolt, engage=measures.angle(hinge) < 0.0, name="latch")
    forces = [
        TorsionSpring(hinge, stiffness=SPRING, name="closer"),
        EndStop(hinge, upper=OPEN, restitution=REBOUND, name="stop"),
    ]
    return System([leaf], [hinge, latch], forces, name="door with latch and stop")


at_stop = np.sqrt(PUSHED**2 - SPRING * OPEN**2 / ABOUT_HINGE)
back = np.sqrt((REBOUND * at_stop) ** 2 + SPRING * OPEN**2 / ABOUT_HINGE)  # rad/s at the latch
percussion = ABOUT_HINGE / (MASS * WIDTH / 2)  # m from the hinge: a knock there is not felt in it
for latch_at in (0.85, percussion):
    run = simulate(house(latch_at), 3.0)
    stop, latch = run.events
    print(f"{stop}\n{latch}")
    takes = (1 - REBOUND**2) * ABOUT_HINGE * at_stop**2 / 2, ABOUT_HINGE * back**2 / 2
    print(f"    by energy {takes[0]:.6g} and {takes[1]:.6g} J")
    felt, exact = latch.impulses["hinge"].force[1], ABOUT_HINGE * back * (1 / latch_at - 1 / percussion)
    print(f"    latch {latch_at:.3f} m from the hinge, which takes {abs(felt):.3f} N s (exact {abs(exact):.3f})")
figure = run.plot([("angle", "hinge"), ("rate", "hinge")], degrees=True)
