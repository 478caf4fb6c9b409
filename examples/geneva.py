"""A Geneva drive: a pin enters a slot of the wheel, turns it by a quarter and leaves; between, a cam holds the wheel.

The walls of the slots and the locking cam are stiff springs written as a force of one's own.

Prints::

    two turns of the pin turn the wheel by -180.00 degrees
    it is fastest with 9.67 rad/s, in theory 9.66 rad/s
"""

import numpy as np

from mbsd3d import GROUND, RK4, Body, CustomForce, Revolute, SpeedDriver, System, rotation, simulate

CENTRES, SLOTS, RATE = 0.10, 4, 4.0  # distance of the shafts [m], [rad/s]
PIN = CENTRES * np.sin(np.pi / SLOTS)  # the pin enters along the slot, without a knock
REACH = CENTRES * np.cos(np.pi / SLOTS)  # of the slots


def contact(t, bodies, z, parameters, loads, z_dot):
    """Pin against the nearest slot while it is inside, else the cam against the turn of the wheel."""
    k, c, hold, damp, reach = parameters
    pin, wheel = bodies[0], bodies[1]
    arm = pin.r - wheel.r
    x = wheel.R[0, 0] * arm[0] + wheel.R[1, 0] * arm[1]  # in axes of the wheel
    y = wheel.R[0, 1] * arm[0] + wheel.R[1, 1] * arm[1]
    spin = wheel.w[2]
    if (x * x + y * y).real < reach * reach:
        along_x = (x * x).real > (y * y).real  # slots lie along x and y of the wheel
        axis = wheel.R[:, 1] if along_x else wheel.R[:, 0]
        off = y if along_x else x
        lever = np.array([-arm[1], arm[0], 0.0 * arm[2]])
        rate = np.sum(axis * (pin.velocity - spin * lever))
        force = -(k * off + c * rate) * axis
        loads[0, :3] = force
        loads[1, :3] = -force
        loads[1, 5] = -(arm[0] * force[1] - arm[1] * force[0])
    else:
        sin, cos = wheel.R[1, 0], wheel.R[0, 0]
        loads[1, 5] = hold * 4.0 * sin * cos * (cos * cos - sin * sin) - damp * spin  # slots rest 45 degrees off
        loads[0, 5] = -loads[1, 5]  # the cam sits on the driver


driver = Body("driver", 0.5, (1e-3, 1e-3, 1e-3), position=(0, 0, 0))
wheel = Body(
    "wheel", 0.8, (5e-4, 5e-4, 8e-4), position=(CENTRES, 0, 0), orientation=rotation("z", np.pi / 4), omega=(0, 0, 0)
)
shaft = Revolute(GROUND, driver, at=(0, 0, 0), axis=(0, 0, 1), name="driver shaft")
output = Revolute(GROUND, wheel, at=(CENTRES, 0, 0), axis=(0, 0, 1), name="wheel shaft")
teeth = CustomForce(
    contact, on=(driver, wheel), points=((-PIN, 0, 0), (CENTRES, 0, 0)), parameters=(2e5, 200.0, 60.0, 0.3, REACH)
)  # fmt: skip
geneva = System([driver, wheel], [shaft, output, SpeedDriver(shaft, RATE, name="motor")], [teeth], name="Geneva drive")

run = simulate(geneva, 2 * 2 * np.pi / RATE, method=RK4(dt=5e-4), output=2001)
print(f"two turns of the pin turn the wheel by {np.degrees(run.angle(output)[-1]):.2f} degrees")
ratio = np.sin(np.pi / SLOTS) / (1 - np.sin(np.pi / SLOTS))
print(f"it is fastest with {np.abs(run.rate(output)).max():.2f} rad/s, in theory {RATE * ratio:.2f} rad/s")
