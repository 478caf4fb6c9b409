"""A planar multibody solver, independent of mbsd3d: three coordinates per body.

    [ M  J' ] [ v_dot ]   [ Q - h ]      per body q = (x, y, theta) of a reference point O, v = q_dot, s = R r_G:
    [ J  0  ] [  lam  ] = [ gamma ]      M = [[m, 0, -m s_y], [0, m, m s_x], [-m s_y, m s_x, I_G + m s^2]],
                                         h = (-m w^2 s_x, -m w^2 s_y, 0)

Where r_G is not zero, h is as important as M: without it, the bearing of an engine crank is a tenth wrong while every
motion stays right (``centripetal=False`` shows that).

Examples
--------
>>> from engines import planar
>>> rod = planar.Body("rod", mass=2.0, inertia=0.1, com=(0.5, 0.0))
>>> hinge = planar.Revolute(planar.GROUND, rod, at=(0, 0), name="hinge")
>>> solution = planar.simulate(planar.System([rod], [hinge]), 1.0, dt=1e-3)
>>> bool(abs(solution.energy().total).max() < 1e-9)
True
"""

from engines.planar.bodies import GROUND, Body, Motion, Polynomial, Sine, Table, rate
from engines.planar.joints import (
    AngleDriver,
    Distance,
    Driver,
    Fixed,
    Gear,
    Joint,
    PointJoint,
    Revolute,
    Rolling,
    SlideDriver,
    Slider,
)
from engines.planar.loads import Force, Spring, TorsionSpring
from engines.planar.runs import Energy, Reaction, Solution, kinematics, simulate
from engines.planar.system import System
