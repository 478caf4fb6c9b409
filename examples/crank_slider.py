"""A crank slider at 3000 rpm: loads of its bearings over the crank angle, and the shaking force on the frame.

Prints::

    redundant rows: 0
    main bearing up to   5818 N, at   0 deg
    big end      up to   5818 N, at   0 deg
    small end    up to   2887 N, at   0 deg
    bore         up to    545 N, at 118 deg
    shaking force on the frame up to 5818.1 N; closed form 5818.1 N
"""

import numpy as np

from mbsd3d import GROUND, AngleDriver, Body, Kinematic, PointOnLine, Prismatic, Ramp, Revolute, System, simulate

R, L, W = 0.045, 0.150, 3000 * 2 * np.pi / 60  # crank radius, connecting rod [m], speed [rad/s]
CRANK, ROD, PISTON = 2.0, 0.6, 0.5  # kg
BIG_END = L / 3  # m, from the big end to the centre of mass of the rod
Y = (0, 1, 0)

crank = Body("crank", CRANK, (4e-3, 4e-3, 6e-3), position=(0, 0, 0))
about = ROD * BIG_END * (L - BIG_END)  # a rod that moves as two masses at its ends would
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
machine = System([crank, rod, piston], joints, gravity=(0, 0, 0), name="crank slider")
print("redundant rows:", machine.check().redundant)

turn = simulate(machine, 2 * np.pi / W, method=Kinematic(), output=361)
angle = np.degrees(turn.angle(main))
for name in ("main bearing", "big end", "small end", "bore"):
    load = np.linalg.norm(turn.reaction(name).force, axis=1)
    first = np.argmax(load > (1 - 1e-9) * load.max())  # of equal ones the first, whatever rounding says
    print(f"{name:12s} up to {load.max():6.0f} N, at {angle[first]:3.0f} deg")

a = np.radians(angle)
swing = np.arcsin(R / L * np.sin(a))  # of the rod
rate = W * R * np.cos(a) / (L * np.cos(swing))
turning = (np.sin(swing) * rate**2 - R / L * np.sin(a) * W**2) / np.cos(swing)  # its angular acceleration
acceleration = -R * W**2 * np.cos(a) - L * (np.cos(swing) * rate**2 + np.sin(swing) * turning)
rotating, reciprocating = ROD * (L - BIG_END) / L, PISTON + ROD * BIG_END / L
shaking = rotating * R * W**2 * np.cos(a) - reciprocating * acceleration
found = -turn.reaction("main bearing").force[:, 2]
print(f"shaking force on the frame up to {abs(found).max():.1f} N; closed form {abs(shaking).max():.1f} N")
figure = turn.plot("reaction", "main bearing", "small end", "bore", against=("angle", main), degrees=True)
