"""A satellite turns by its reaction wheel alone: the wheel spins up, the body turns; the wheel stops, the body stops.

Prints::

    turned by 90.000000 degrees, at rest: True
    wheel up to 282.2 rpm, motor up to 0.0303 N m
    angular momentum stays zero: True
"""

import numpy as np

from mbsd3d import AngleDriver, Body, Polynomial, Revolute, System, rotations, simulate

BODY, WHEEL, TIME, TURN = 12.0, 0.02, 60.0, np.pi / 2  # [kg m^2], [kg m^2], [s], [rad]

still = dict(velocity=(0, 0, 0))
satellite = Body("satellite", 120.0, (14.0, 16.0, BODY), **still)
wheels, hinges = [], []
for name, axis in zip("xyz", np.eye(3), strict=True):
    wheels.append(Body(f"wheel {name}", 3.0, WHEEL / 2 * (1 + axis)))
    hinges.append(Revolute(satellite, wheels[-1], at=(0, 0, 0), axis=axis, name=name))
about_z = BODY + 2 * WHEEL / 2  # the body and the two wheels across
ratio = (about_z + WHEEL) / WHEEL  # turns of the wheel per turn of the body
smooth = [-ratio * TURN * c / TIME**k for k, c in enumerate((0, 0, 0, 10, -15, 6))]
locks = [AngleDriver(h, 0.0, name=f"brake {h.name}") for h in hinges[:2]]
motor = AngleDriver(hinges[2], Polynomial(smooth), name="motor z")

run = simulate(System([satellite, *wheels], [*hinges, *locks, motor], gravity=(0, 0, 0)), TIME, output=301)
turned = rotations.logarithm(run.orientation("satellite")[-1])
print(f"turned by {np.degrees(turned[2]):.6f} degrees, at rest: {abs(run.omega('satellite')[-1, 2]) < 1e-12}")
rpm, torque = np.abs(run.rate("z")).max() * 30 / np.pi, np.abs(run.effort(motor)).max()
print(f"wheel up to {rpm:.1f} rpm, motor up to {torque:.4f} N m")
print(f"angular momentum stays zero: {np.abs(run.momentum().angular).max() < 1e-12}")
figure = run.plot([("rate", hinges[2]), ("effort", motor)])
