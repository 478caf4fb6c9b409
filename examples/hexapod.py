"""A hexapod: six legs with a slide each carry a platform; it heaves and yaws, and the legs share its weight.

Prints::

    mobility 6
    heave 181.207 mm, by Pythagoras 181.207 mm
    a leg pushes with 291.3 to 361.8 N
    no yaw: True
"""

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    Kinematic,
    Prismatic,
    Sine,
    SlideDriver,
    Spherical,
    System,
    Universal,
    measures,
    simulate,
)  # fmt: skip

BASE, TOP, HEIGHT = 1.0, 0.6, 1.2  # radii and height [m]

platform = Body("platform", 150.0, (12.0, 12.0, 20.0), position=(0, 0, HEIGHT))
bodies, joints = [platform], []
for k in range(6):
    ring, pair = 2 * np.pi * (k // 2) / 3, (-1) ** k
    low = BASE * np.array([np.cos(ring + 0.2 * pair), np.sin(ring + 0.2 * pair), 0])
    high = TOP * np.array([np.cos(ring + 0.85 * pair), np.sin(ring + 0.85 * pair), 0]) + (0, 0, HEIGHT)
    along = (high - low) / np.linalg.norm(high - low)
    across = np.cross((0, 0, 1), along) / np.linalg.norm(np.cross((0, 0, 1), along))
    barrel = Body(f"barrel {k}", 8.0, (0.5, 0.5, 0.02), position=low + 0.3 * (high - low))
    rod = Body(f"rod {k}", 4.0, (0.3, 0.3, 0.01), position=low + 0.7 * (high - low))
    bodies += [barrel, rod]
    joints += [
        Universal(GROUND, barrel, at=low, axis_a=across, axis_b=np.cross(across, along), name=f"foot {k}"),
        Prismatic(barrel, rod, at=(low + high) / 2, axis=along, name=f"leg {k}"),
        Spherical(rod, platform, at=high, name=f"head {k}"),
    ]
print("mobility", System(bodies, joints).check().mobility)

legs = joints[1::3]
drives = [SlideDriver(leg, Sine(0.08, 0.5), name=f"drive {k}") for k, leg in enumerate(legs)]
heave = simulate(System(bodies, [*joints, *drives], name="hexapod"), 2.0, method=Kinematic(), output=201)
length, reach = np.linalg.norm(high - low), np.linalg.norm((high - low)[:2])
rise = np.ptp(heave.position(platform)[:, 2])
theory = np.sqrt((length + 0.08) ** 2 - reach**2) - np.sqrt((length - 0.08) ** 2 - reach**2)
print(f"heave {1e3 * rise:.3f} mm, by Pythagoras {1e3 * theory:.3f} mm")
turned = heave.measure(measures.turn(GROUND, platform, about=(0, 0, 1)))
print(f"a leg pushes with {heave.effort('drive 0').min():.1f} to {heave.effort('drive 0').max():.1f} N")
print("no yaw:", bool(np.abs(turned).max() < 1e-9))
figure = heave.picture()
