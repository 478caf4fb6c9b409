"""A double wishbone: camber and toe of the wheel over the travel of the spring.

Prints::

    travel  -74.31 mm, camber -1.121, toe  0.215 degrees
    travel  -37.63 mm, camber -0.744, toe  0.072 degrees
    travel    0.00 mm, camber  0.000, toe -0.000 degrees
    travel   38.18 mm, camber  1.117, toe -0.024 degrees
    travel   76.54 mm, camber  2.648, toe -0.024 degrees
"""

import numpy as np

from mbsd3d import GROUND, AngleDriver, Body, Distance, Kinematic, Ramp, Revolute, Spherical, System, measures, simulate

X = (1, 0, 0)
INNER = {"lower": (0, 0.35, 0.20), "upper": (0, 0.45, 0.48)}
OUTER = {"lower": (0, 0.72, 0.18), "upper": (-0.02, 0.68, 0.50)}

arms = {name: Body(name, 3.0, (0.02, 0.05, 0.05), position=np.add(INNER[name], OUTER[name]) / 2) for name in INNER}
wheel = Body("wheel", 25.0, (0.6, 1.0, 0.6), position=(0, 0.78, 0.31))
pivots = {name: Revolute(GROUND, arm, at=INNER[name], axis=X, name=f"{name} pivot") for name, arm in arms.items()}
balls = [Spherical(arm, wheel, at=OUTER[name], name=f"{name} ball") for name, arm in arms.items()]
track_rod = Distance(GROUND, wheel, at_a=(-0.15, 0.38, 0.25), at_b=(-0.15, 0.70, 0.24), name="track rod")
bump = AngleDriver(pivots["lower"], Ramp(0.4, offset=-0.2), name="bump")
corner = System([*arms.values(), wheel], [*pivots.values(), *balls, track_rod, bump], name="double wishbone")

lowest = corner.assemble(angles={pivots["lower"]: -0.2})
travel = simulate(corner, 1.0, state=lowest, method=Kinematic(), output=5)
height = 1e3 * travel.measure(measures.position(wheel, axis=(0, 0, 1)))
camber = np.degrees(travel.measure(measures.camber(wheel, axle=(0, 1, 0))))
toe = np.degrees(travel.measure(measures.heading(wheel)))
for row in zip(height - 310, camber, toe, strict=True):
    print("travel {:7.2f} mm, camber {:6.3f}, toe {:6.3f} degrees".format(*row))
figure = travel.picture([0.0, 1.0], hidden=["body names", "joint names"])
