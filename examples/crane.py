"""A trolley crane: the trolley drives 8 m in 6 s, the load hangs on a rope, a rod without mass. How far does it swing?

Prints::

    the load lags by 2.004 m and overtakes by 3.866 m
    rope 54.02 kN, drive 9.73 kN
    impulse of the drive 3285.6 N s is the momentum left in the swing: 3285.6 N s
"""

import numpy as np

from mbsd3d import GROUND, Body, Distance, Polynomial, Prismatic, SlideDriver, System, measures, simulate

ROPE, WAY, TIME = 10.0, 8.0, 6.0  # [m], [m], [s]

trolley = Body("trolley", 800.0, (50.0, 50.0, 50.0), position=(0, 0, 20))
load = Body("load", 5000.0, (2000.0, 2000.0, 1500.0), position=(0, 0, 20 - ROPE), omega=(0, 0, 0))
rail = Prismatic(GROUND, trolley, at=(0, 0, 20), axis=(1, 0, 0), name="rail")
rope = Distance(trolley, load, at_a=(0, 0, 20), at_b=(0, 0, 20 - ROPE), name="rope")
smooth = [WAY * c / TIME**k for k, c in enumerate((0, 0, 0, 10, -15, 6))]  # at rest at both ends
drive = SlideDriver(rail, Polynomial(smooth), name="drive")
crane = System([trolley, load], [rail, rope, drive], name="crane")

run = simulate(crane, TIME, output=601)
lead = run.measure(measures.offset(trolley, load, along=(1, 0, 0)))
print(f"the load lags by {-lead.min():.3f} m and overtakes by {lead.max():.3f} m")
pull = np.linalg.norm(run.reaction(rope).force, axis=1).max() / 1e3
print(f"rope {pull:.2f} kN, drive {run.effort(drive).max() / 1e3:.2f} kN")

momentum = run.momentum().linear[-1, 0]
given = np.trapezoid(run.effort(drive), run.t)
print(f"impulse of the drive {given:.1f} N s is the momentum left in the swing: {momentum:.1f} N s")
figure = run.picture([0.0, 2.0, 3.5, 6.0], traces=[load])
