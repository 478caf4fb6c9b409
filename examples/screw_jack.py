"""A screw jack raises a car and is let go: below its friction angle the thread holds, above it the car comes down.

Prints::

     4 mm a turn: 8.2009 N m raise it (W R tan(lead + phi) 8.2009), let go it stays
     8 mm a turn: 10.7841 N m raise it (W R tan(lead + phi) 10.7841), let go it stays
    12 mm a turn: 13.4008 N m raise it (W R tan(lead + phi) 13.4008), let go it falls 91.869 mm in 0.2 s (91.869)
    20 mm a turn: 18.7375 N m raise it (W R tan(lead + phi) 18.7375), let go it falls 165.435 mm in 0.2 s (165.435)
"""

import numpy as np

from mbsd3d import GROUND, Body, DryFriction, Prismatic, Revolute, Screw, SpeedDriver, System, simulate

LOAD, RADIUS, MU, G = 400.0, 0.012, 0.12, 9.81  # kg, m of the thread, friction in it
SCREW = 4e-4  # kg m^2 of the screw with its handle


def jack(pitch):
    """Return the jack without its handle, its bearing and the friction; a turn raises the load by the pitch [m]."""
    screw = Body("screw", 3.0, (0.02, 0.02, SCREW), position=(0, 0, -0.2))
    car = Body("car", LOAD, (60.0, 60.0, 60.0), position=(0, 0, 0.1))
    bearing = Revolute(GROUND, screw, at=(0, 0, -0.2), axis="z", name="bearing")
    column = Prismatic(GROUND, car, at=(0, 0, 0.1), axis="z", name="column")
    thread = Screw(screw, car, at=(0, 0, 0), axis="z", pitch=-pitch, name="thread")
    friction = DryFriction(thread, mu=MU, thread_radius=RADIUS, name="friction")
    return System([screw, car], [bearing, column, thread], [friction]), bearing, friction


phi = np.arctan(MU)
for pitch in (0.004, 0.008, 0.012, 0.020):
    system, bearing, friction = jack(pitch)
    lead = np.arctan2(pitch, 2 * np.pi * RADIUS)
    handle = SpeedDriver(bearing, 2 * np.pi, name="handle")
    raised = simulate(System(system.bodies, [*system.joints, handle], system.forces), 1.0)
    torque, exact = raised.reaction(handle).moment[-1, 2], LOAD * G * RADIUS * np.tan(lead + phi)
    print(f"{1e3 * pitch:2.0f} mm a turn: {torque:.4f} N m raise it (W R tan(lead + phi) {exact:.4f}), ", end="")
    back = -simulate(system, 0.2).slide("column")[-1]
    arm = RADIUS * np.tan(lead - phi)
    falls = 0.5 * G * 0.2**2 / (1 + SCREW * (2 * np.pi / pitch) / (LOAD * arm))
    print(f"let go it falls {1e3 * back:.3f} mm in 0.2 s ({1e3 * falls:.3f})" if back else "let go it stays")
figure = raised.picture()
