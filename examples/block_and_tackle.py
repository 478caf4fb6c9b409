"""A winch raises 200 kg by a block and tackle. How hard does it pull with 2, 4 and 6 falls, also on worn sheaves?

Prints::

    2 falls: 981.00 N on smooth sheaves (W/n 981.00), 1147.37 N at an efficiency of 0.90 each (exact 1147.37)
    4 falls: 490.50 N on smooth sheaves (W/n 490.50), 633.91 N at an efficiency of 0.90 each (exact 633.91)
    6 falls: 327.00 N on smooth sheaves (W/n 327.00), 465.26 N at an efficiency of 0.90 each (exact 465.26)
"""

import numpy as np

from mbsd3d import GROUND, Body, Prismatic, Pulley, Revolute, Rope, SpeedDriver, System, Winch, simulate

MASS, R, DRUM, G = 200.0, 0.05, 0.08, 9.81
EFFICIENCY = 0.90


def raised(n, mu):
    """Return the run in which the drum winds in evenly; sheaves in a row, x to the right, z up."""
    load = Body("load", MASS, (5, 5, 5), position=(R * n, 0, -2))
    drum = Body("drum", 8.0, (0.03, 0.03, 0.03), position=(2 * R * n + DRUM, 0, -2))
    guide = Prismatic(GROUND, load, at=load.position, axis=(0, 0, 1))
    axle = Revolute(GROUND, drum, at=drum.position, axis=(0, -1, 0))
    below = [Pulley(load, radius=R, sense=1, centre=(R * (2 * k + 1), 0, -2), axis=(0, -1, 0)) for k in range(0, n, 2)]
    above = [
        Pulley(GROUND, radius=R, sense=-1, centre=(R * (2 * k + 1), 0, 0), axis=(0, -1, 0)) for k in range(1, n, 2)
    ]
    sheaves = [sheave for pair in zip(below, above, strict=True) for sheave in pair]
    ends = ((GROUND, (0, 0, 0)), Winch(axle, radius=DRUM, sense=1))
    rope = Rope(ends, sheaves, stiffness=2e5, damping=4e3, mu=mu, pretension=MASS * G / n, name="rope")
    winding = SpeedDriver(axle, 0.5)
    return simulate(System([load, drum], [guide, axle, winding], [rope]), 4.0)


for n in (2, 4, 6):
    runs = raised(n, 0.0), raised(n, -np.log(EFFICIENCY) / np.pi)
    smooth, worn = (run.force("rope").tension[-1, -1] for run in runs)
    exact = MASS * G * (1 - EFFICIENCY) / (EFFICIENCY * (1 - EFFICIENCY**n))
    print(f"{n} falls: {smooth:.2f} N on smooth sheaves (W/n {MASS * G / n:.2f}), ", end="")
    print(f"{worn:.2f} N at an efficiency of {EFFICIENCY:.2f} each (exact {exact:.2f})")
figure = runs[0].picture(0.0, hidden=["body names", "joint names"])
