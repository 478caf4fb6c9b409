"""A robot arm with three axes: its tool draws a circle, and the joint torques follow. Then the other way round.

Prints::

    M1:   -1.959 to    1.960 N m
    M2:  -44.971 to  -23.580 N m
    M3:  -10.141 to   -9.716 N m
    power at the tool and at the motors differ by less than 0.01 W: True
"""

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Kinematic,
    PositionDriver,
    Revolute,
    Sine,
    System,
    Table,
    simulate,
)

base = Body("base", 12.0, (0.2, 0.2, 0.1), position=(0, 0, 0.2))
upper = Body("upper", 8.0, (0.3, 0.3, 0.03), position=(0.2, 0, 0.55), com=(0.02, 0.01, 0))
fore = Body("fore", 4.0, (0.02, 0.12, 0.12), position=(0.6, 0, 0.75), com=(0, -0.01, 0.02))
axes = [
    Revolute(GROUND, base, at=(0, 0, 0), axis=(0, 0, 1), name="waist"),
    Revolute(base, upper, at=(0, 0, 0.4), axis=(0, 1, 0), name="shoulder"),
    Revolute(upper, fore, at=(0.35, 0, 0.75), axis=(0, 1, 0), name="elbow"),
]
bodies, tool, way = [base, upper, fore], (0.9, 0, 0.7), 0.1
circle = (Sine(way, 0.5, np.pi / 2, offset=-way), Sine(way, 0.5), 0.0)  # 2 s a turn
led = System(bodies, [*axes, PositionDriver(fore, at=tool, signal=circle, name="tool")])
path = simulate(led, 2.0, method=Kinematic(), output=201)

motors = [AngleDriver(axis, Table(path.t, path.angle(axis)), name=f"M{k}") for k, axis in enumerate(axes, 1)]
driven = simulate(System(bodies, [*axes, *motors]), 2.0, method=Kinematic(), output=201)
for motor in motors:
    torque = driven.effort(motor)
    print(f"{motor.name}: {torque.min():8.3f} to {torque.max():8.3f} N m")

led_work, driven_work = path.work("tool")[-1], sum(driven.work(motor)[-1] for motor in motors)
print(f"power at the tool and at the motors differ by less than 0.01 W: {abs(led_work - driven_work) / 2.0 < 0.01}")
figure = driven.plot("effort")
