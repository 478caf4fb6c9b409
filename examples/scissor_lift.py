"""A scissor lift with one cylinder: which force does it need, and why is the start the hardest?

Prints::

    mobility 0 with the cylinder, redundant rows: 0
    platform from 0.60 m to 2.15 m; slope 58.6 deg
    cylinder 103.94 kN at the start, 17.90 kN at the end
    virtual work: 103.97 kN and 17.90 kN
    loads at the start: foot hinge [-98566.      0. -20054.] N
"""

import numpy as np

from mbsd3d import GROUND, Body, Kinematic, LengthDriver, PointOnPlane, Ramp, Revolute, System, rotation, simulate

ARM, FLAT = 2.4, np.radians(12.0)  # length of the arms [m], their slope at the start
LOAD, ARM_MASS, G = 800.0, 60.0, 9.81  # platform with its load, one arm [kg], m/s^2
FOOT, HEAD = 0.25, 0.70  # ends of the cylinder: on the ground from the fixed hinge [m], along the rising arm (share)
Y = (0, 1, 0)
reach, rise = ARM * np.cos(FLAT), ARM * np.sin(FLAT)


def bar(name, slope):
    """Return an arm through the middle of the scissors."""
    return Body(name, ARM_MASS, ARM_MASS / 12 * ARM**2 * np.array([0.01, 1, 1]), position=(reach / 2, 0, rise / 2),
                orientation=rotation("y", -slope))  # fmt: skip


rising, falling = bar("rising", FLAT), bar("falling", -FLAT)
platform = Body("platform", LOAD, (60.0, 400.0, 450.0), position=(reach / 2, 0, rise + 0.1))
joints = [
    Revolute(GROUND, rising, at=(0, 0, 0), axis=Y, name="foot hinge"),
    Revolute(rising, falling, at=(reach / 2, 0, rise / 2), axis=Y, name="middle"),
    PointOnPlane(GROUND, falling, at=(reach, 0, 0), normal=(0, 0, 1), name="foot roller"),
    Revolute(platform, falling, at=(0, 0, rise), axis=Y, name="head hinge"),
    PointOnPlane(platform, rising, at=(reach, 0, rise), normal=(0, 0, 1), name="head roller"),
]
ends = np.array([FOOT * ARM, 0, 0]), HEAD * np.array([reach, 0, rise])
first = float(np.linalg.norm(ends[1] - ends[0]))
pump = LengthDriver(GROUND, rising, at_a=ends[0], at_b=ends[1], length=Ramp(0.003, first), name="cylinder")
lift = System([rising, falling, platform], [*joints, pump], name="scissor lift")
found = lift.check()
print(f"mobility {found.mobility} with the cylinder, redundant rows: {found.redundant}")

run = simulate(lift, 120.0, method=Kinematic(), output=25)
height, force, slope = run.position(platform)[:, 2], run.effort(pump), FLAT - run.angle("foot hinge")
print(f"platform from {height[0]:.2f} m to {height[-1]:.2f} m; slope {np.degrees(slope[-1]):.1f} deg")
print(f"cylinder {force[0] / 1e3:.2f} kN at the start, {force[-1] / 1e3:.2f} kN at the end")
length = np.hypot(HEAD * ARM * np.cos(slope) - FOOT * ARM, HEAD * ARM * np.sin(slope))
gain = FOOT * HEAD * ARM**2 * np.sin(slope) / length  # m of cylinder a radian of slope
virtual_work = (LOAD + ARM_MASS) * G * ARM * np.cos(slope) / gain
print(f"virtual work: {virtual_work[0] / 1e3:.2f} kN and {virtual_work[-1] / 1e3:.2f} kN")
print(f"loads at the start: foot hinge {run.reaction('foot hinge').force[0].round(0)} N")
figure = run.picture([0.0, 120.0], hidden=["body names", "joint names"])
