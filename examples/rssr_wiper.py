"""A windscreen wiper: a motor's crank drives a skew wiper shaft by a rod with two ball joints (RSSR).

Prints::

    the blade sweeps 78.50 degrees
    the motor needs up to 3.34 N m
    its work is what friction takes: 12.341 J, 12.341 J
"""

import numpy as np

from mbsd3d import JointFriction, SpeedDriver, System, linkages, simulate

RATE = 2 * np.pi * 0.75  # 45 strokes a minute [rad/s]

linkage = linkages.rssr(crank=0.05, rod=0.35, rocker=0.09, distance=0.32, twist=np.radians(75), angle=0.4)
shaft = linkage.part("rocker shaft", "joints")
motor = SpeedDriver(linkage.part("crank shaft", "joints"), RATE, name="motor")
drag = JointFriction(shaft, coulomb=4.0, viscous=0.2, name="blade on the glass")
wiper = System(linkage.bodies, [*linkage.joints, motor], [drag], name="wiper")

stroke = simulate(wiper, 2 * np.pi / RATE, output=721)
sweep = np.degrees(stroke.angle("rocker shaft"))
print(f"the blade sweeps {np.ptp(sweep):.2f} degrees")
print(f"the motor needs up to {np.abs(stroke.effort(motor)).max():.2f} N m")
print(f"its work is what friction takes: {stroke.work(motor)[-1]:.3f} J, {-stroke.work(drag)[-1]:.3f} J")
figure = stroke.picture(hidden=["body names", "joint names"])
