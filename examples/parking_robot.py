"""A robot on two wheels drives an S and parks beside its lane. Its wheels roll and never slip sideways.

Prints::

    it turns up to 17.30 degrees and ends 66.1 mm aside
    speed 0.274 m/s at most, 0.014 at the end; slip below 1e-12: True
    the wheels hold up to 4.03 N
    distance by its wheels and place differ by less than 0.1 mm: True
"""

import numpy as np

from mbsd3d import GROUND, Body, Force, KnifeEdge, Planar, Pulse, System, Torque, measures, simulate

PUSH, TWIST = 4.0, 1.0  # [N], [N m]

robot = Body("robot", 20.0, (0.5, 0.6, 0.8), com=(0.05, 0, 0.1))  # O between the wheels, the battery in front of them
floor = Planar(GROUND, robot, at=(0, 0, 0), normal=(0, 0, 1), name="floor")
wheels = KnifeEdge(GROUND, robot, at=(0, 0, 0), heading=(1, 0, 0), name="wheels")
motors = [
    Force(robot, (Pulse(height=PUSH, start=0.0, edge=0.2, duration=1.5), 0, 0), at=(0, 0, 0), frame="body"),
    Force(robot, (Pulse(height=-PUSH, start=4.5, edge=0.2, duration=1.5), 0, 0), at=(0, 0, 0), frame="body"),
    *(
        Torque(robot, (0, 0, Pulse(height=sign * TWIST, start=start, edge=0.1, duration=0.6)))
        for sign, start in ((1, 1.5), (-1, 2.1), (-1, 3.0), (1, 3.6))
    ),
]
run = simulate(System([robot], [floor, wheels], motors, name="robot"), 6.5, output=651)

heading = run.measure(measures.heading(robot))
ahead = np.array([np.cos(heading), np.sin(heading), 0 * heading]).T
speed = np.sum(run.velocity(robot) * ahead, axis=1)
aside = np.linalg.norm(run.velocity(robot) - speed[:, None] * ahead, axis=1)
print(
    f"it turns up to {np.degrees(heading.max()):.2f} degrees and ends {1e3 * run.position(robot)[-1, 1]:.1f} mm aside"
)
print(f"speed {speed.max():.3f} m/s at most, {speed[-1]:.3f} at the end; slip below 1e-12: {aside.max() < 1e-12}")
print(f"the wheels hold up to {np.abs(run.reaction(wheels).force).max():.2f} N")
way = np.trapezoid(speed[:, None] * ahead, run.t, axis=0)
print(
    f"distance by its wheels and place differ by less than 0.1 mm: {np.abs(way - run.position(robot)[-1]).max() < 1e-4}"
)
figure = run.picture([0.0, 2.0, 4.0, 6.5])
