"""A counterweight for a single cylinder: scipy.optimize finds which one shakes the frame least at 3000 rpm.

Two aims: the smallest mean square over a turn, whose closed form is (rotating + half of the reciprocating mass) times
the crank radius, and the smallest peak.

Prints::

    without: 5818 N at most, 3737 N on average
    least average: 33.75 g m, closed form 33.75 g m: 2487 N at most, 1695 N on average
    least peak:    37.01 g m, by the exact series 37.01 g m: 2165 N at most, 1725 N on average
"""

import numpy as np
from matplotlib.figure import Figure
from scipy.optimize import minimize_scalar

from mbsd3d import GROUND, AngleDriver, Body, Kinematic, PointOnLine, Prismatic, Ramp, Revolute, System, simulate

R, L, W = 0.045, 0.150, 3000 * 2 * np.pi / 60  # crank radius, connecting rod [m], speed [rad/s]
ROD, PISTON, BIG_END = 0.6, 0.5, 0.05  # kg, kg, m from the big end to the centre of mass of the rod
Y = (0, 1, 0)


def engine(unbalance):
    """The engine, piston on top; the counterweight is a mass times its arm [kg m], opposite to the crank pin."""
    crank = Body("crank", 2.0, (4e-3, 4e-3, 6e-3), com=(0, 0, -unbalance / 2.0))
    about = ROD * BIG_END * (L - BIG_END)
    rod = Body("rod", ROD, (about, about, 1e-4), position=(0, 0, R + BIG_END))
    piston = Body("piston", PISTON, (3e-4, 3e-4, 3e-4), position=(0, 0, R + L))
    main = Revolute(GROUND, crank, at=(0, 0, 0), axis=Y, name="main bearing")
    joints = [
        main,
        Revolute(crank, rod, at=(0, 0, R), axis=Y, name="big end"),
        PointOnLine(piston, rod, at=(0, 0, R + L), axis=Y, name="small end"),  # a hinge there would be redundant
        Prismatic(GROUND, piston, at=(0, 0, R + L), axis=(0, 0, 1), name="bore"),
        AngleDriver(main, Ramp(W), name="motor"),
    ]
    return System([crank, rod, piston], joints, gravity=(0, 0, 0), name="crank slider")


def shaking(unbalance):
    """Size of the force on the frame over a turn [N]."""
    turn = simulate(engine(unbalance), 2 * np.pi / W, method=Kinematic(), output=361)
    return np.linalg.norm(turn.reaction("main bearing").force + turn.reaction("bore").force, axis=1)[:-1]


def series(unbalance):
    """The same by the motion of two masses: one turns with the crank pin, one moves with the piston."""
    a = 2 * np.pi * np.arange(360) / 360
    swing = np.arcsin(R / L * np.sin(a))
    rate = W * R * np.cos(a) / (L * np.cos(swing))
    turning = (np.sin(swing) * rate**2 - R / L * np.sin(a) * W**2) / np.cos(swing)
    acceleration = -R * W**2 * np.cos(a) - L * (np.cos(swing) * rate**2 + np.sin(swing) * turning)
    across = (rotating * R - unbalance) * W**2
    return np.hypot(across * np.cos(a) - reciprocating * acceleration, across * np.sin(a))


def mean(force):
    """Root of the mean square [N]."""
    return float(np.sqrt((force**2).mean()))


def said(unbalance):
    """What is left with a counterweight."""
    force = shaking(unbalance)
    return f"{force.max():.0f} N at most, {mean(force):.0f} N on average"


rotating, reciprocating = ROD * (L - BIG_END) / L, PISTON + ROD * BIG_END / L
wanted = {"method": "bounded", "bounds": (0.0, 0.1), "options": {"xatol": 1e-7}}
print("without:", said(0.0))
even = minimize_scalar(lambda x: mean(shaking(x)), **wanted).x
exact = (rotating + reciprocating / 2) * R
print(f"least average: {1e3 * even:.2f} g m, closed form {1e3 * exact:.2f} g m: {said(even)}")
least = minimize_scalar(lambda x: shaking(x).max(), **wanted).x
exact = minimize_scalar(lambda x: series(x).max(), **wanted).x
print(f"least peak:    {1e3 * least:.2f} g m, by the exact series {1e3 * exact:.2f} g m: {said(least)}")

figure = Figure(figsize=(6.4, 3.6), layout="constrained")
axes = figure.subplots()
for name, unbalance in (("without", 0.0), ("least average", even), ("least peak", least)):
    axes.plot(np.arange(360), shaking(unbalance) / 1e3, label=name)
axes.set(xlabel="crank angle [deg]", ylabel="force on the frame [kN]")
axes.legend()
