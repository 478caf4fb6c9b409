"""An overhead crane drives round a corner: bridge and trolley along a path. Which ramps leave the load at rest?

A ramp 3 s^2 - 2 s^3 of the speed excites the swing by 3 (sin y - y cos y) / y^3 of what a jump would, with y = half the
ramp's time times the frequency of the rope. It leaves nothing where tan y = y: a ramp of 1.43 periods.

Prints::

    ramps of 2.00 s: 25.0 s, then the load swings by 7.0 and 114.2 cm; small swings in theory 6.9 and 114.8 cm
    ramps of 8.12 s: 31.1 s, then the load swings by 0.0 and 0.0 cm; small swings in theory 0.0 and 0.0 cm
"""

import numpy as np

from mbsd3d import GROUND, Body, Distance, Prismatic, Pulse, SpeedDriver, System, simulate

ROPE, SPEED, WAYS, TURN = 8.0, 0.8, (9.0, 12.0), 8.0  # m, m/s, m of trolley and bridge, s from start to start
X, Y, G = (1, 0, 0), (0, 1, 0), 9.81
W = np.sqrt(G / ROPE)


def driven(ramp):
    """Return the run along the path with ramps of a time [s] until 6 s after its end."""
    bridge = Body("bridge", 4000.0, (2e4, 2e3, 2e4), position=(4, 0, 10.2))
    trolley = Body("trolley", 800.0, (50.0, 50.0, 50.0), position=(0, 0, 10))
    load = Body("load", 3000.0, (900.0, 900.0, 900.0), position=(0, 0, 10 - ROPE), omega=(0, 0, 0))
    rails = [
        Prismatic(bridge, trolley, at=(0, 0, 10), axis=X, name="trolley rail"),
        Prismatic(GROUND, bridge, at=(4, 0, 10.2), axis=Y, name="bridge rail"),
    ]
    rope = Distance(trolley, load, at_a=(0, 0, 10), at_b=(0, 0, 10 - ROPE), name="rope")
    plan = [Pulse(SPEED, start=k * TURN, edge=ramp, duration=way / SPEED + ramp) for k, way in enumerate(WAYS)]
    drives = [SpeedDriver(rail, speed, name=f"{rail.name} drive") for rail, speed in zip(rails, plan, strict=True)]
    end = TURN + WAYS[1] / SPEED + ramp
    crane = System([bridge, trolley, load], [*rails, rope, *drives], name="overhead crane")
    return simulate(crane, end + 6.0, output=601), end


for ramp in (2.0, 2 * 4.493409457909064 / W):
    run, end = driven(ramp)
    swing = (run.position("load") - run.position("trolley"))[run.t > end][:, :2]
    y = ramp * W / 2
    jump = SPEED / W * abs(3 * (np.sin(y) - y * np.cos(y)) / y**3)  # m of swing that one ramp leaves
    theory = [jump * abs(1 - np.exp(1j * W * way / SPEED)) for way in WAYS]  # start and stop together
    found = abs(swing).max(axis=0)
    print(f"ramps of {ramp:.2f} s: {end:.1f} s, then the load swings by ", end="")
    print(f"{100 * found[0]:.1f} and {100 * found[1]:.1f} cm; small swings in theory ", end="")
    print(f"{100 * theory[0]:.1f} and {100 * theory[1]:.1f} cm")
figure = run.picture([0.0, 0.5 * end, end], traces=["load"], hidden=["body names", "joint names"])
