"""The benchmark bicycle with its rider: at which speeds is it stable by itself, and what would 10 kg of luggage do?

Prints::

    as it is: 4.292383 ... 6.024262 m/s
    loaded: 4.452043 ... 5.913017 m/s
    a push at 5 m/s: 2.70 degrees of lean, after 6 s -0.05
"""

from dataclasses import replace

import numpy as np

from bicycle import Meijaard2007, ride, stability

bare = Meijaard2007()
print("as it is:", *stability.study(bare).critical.stable)


def with_luggage(p, mass, x, z):
    """Frame and rider with a point mass [kg] at (x, z) [m]: mass, centre and Steiner's rule."""
    whole = p.mB + mass
    xB, zB = (p.mB * p.xB + mass * x) / whole, (p.mB * p.zB + mass * z) / whole
    parts = [(p.mB, p.xB - xB, p.zB - zB), (mass, x - xB, z - zB)]
    return replace(
        p,
        mB=whole,
        xB=xB,
        zB=zB,
        IBxx=p.IBxx + sum(m * dz**2 for m, _, dz in parts),
        IByy=p.IByy + sum(m * (dx**2 + dz**2) for m, dx, dz in parts),
        IBzz=p.IBzz + sum(m * dx**2 for m, dx, _ in parts),
        IBxz=p.IBxz - sum(m * dx * dz for m, dx, dz in parts),
    )


loaded = with_luggage(bare, 10.0, -0.1, -0.85)  # on the carrier
print("loaded:", *stability.study(loaded).critical.stable)

push = ride.run(loaded, 6.0, speed=5.0, lean_rate=0.2)
print(f"a push at 5 m/s: {np.degrees(push.lean.max()):.2f} degrees of lean, after 6 s {np.degrees(push.lean[-1]):.2f}")
figure = stability.study(loaded).figure()
