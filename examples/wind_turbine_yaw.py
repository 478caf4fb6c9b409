"""A wind turbine turns into the wind: two blades load the yaw bearing in pulses, three do not.

The rotor's gyroscopic moment is I Omega yaw_rate; with two blades the whole moment swings between 0 and twice that.

Prints::

    2 blades:     1.62 to  1153.62 kN m, I Omega yaw_rate = 577.62 kN m
    3 blades:   865.62 to   865.62 kN m, I Omega yaw_rate = 865.62 kN m
"""

import numpy as np
from matplotlib.figure import Figure

from mbsd3d import GROUND, Body, Revolute, SpeedDriver, System, inertia, rotation, simulate

BLADE, LENGTH, SPIN, YAW = 6000.0, 40.0, 1.8, 0.05  # [kg], [m], [rad/s], [rad/s]


def rotor(blades):
    """Mass properties of a hub with its blades, axis x."""
    rod = inertia.rod(BLADE, LENGTH, "z")
    parts = [(20e3, (0, 0, 0), inertia.sphere(20e3, 1.5))]
    for k in range(blades):
        turn = rotation("x", 2 * np.pi * k / blades)
        angle = 2 * np.pi * k / blades
        middle = LENGTH / 2 * np.array([0, -np.sin(angle), np.cos(angle)])
        parts.append((BLADE, middle, rod, turn))
    return inertia.combine(parts)


figure = Figure(figsize=(6.4, 3.6), layout="constrained")
axes = figure.subplots()
for blades in (2, 3):
    solid = rotor(blades)
    nacelle = Body("nacelle", 80e3, (2e5, 4e5, 4e5))
    wheel = Body("rotor", **vars(solid))
    yaw = Revolute(GROUND, nacelle, at=(0, 0, 0), axis=(0, 0, 1), name="yaw")
    shaft = Revolute(nacelle, wheel, at=(0, 0, 0), axis=(1, 0, 0), name="shaft")
    drives = [SpeedDriver(yaw, YAW, name="yaw drive"), SpeedDriver(shaft, SPIN, name="wind")]
    run = simulate(System([nacelle, wheel], [yaw, shaft, *drives], gravity=(0, 0, 0)), 2 * np.pi / SPIN, output=181)
    across = np.array([-np.sin(YAW * run.t), np.cos(YAW * run.t), 0 * run.t]).T  # nods the nacelle
    nod = np.abs(np.sum(run.reaction(yaw).moment * across, axis=1)) / 1e3
    mean = solid.inertia[0, 0] * SPIN * YAW / 1e3
    print(f"{blades} blades: {nod.min():8.2f} to {nod.max():8.2f} kN m, I Omega yaw_rate = {mean:.2f} kN m")
    axes.plot(np.degrees(run.angle(shaft)), nod, label=f"{blades} blades")
axes.set(xlabel="angle of the rotor [deg]", ylabel="moment on the yaw bearing [kN m]")
axes.legend()
