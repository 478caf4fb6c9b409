"""A Geneva drive: a pin enters a slot of the wheel, turns it by a quarter and leaves; between, a cam holds the wheel.

Slot and cam are joints that come and go: the run stops where the pin enters or leaves, and goes on with the other one.

Prints::

    4 turns of the pin turn the wheel by -360.000000 degrees
    it is fastest with 9.6569 rad/s, in theory 9.6569 rad/s
    the pin presses with up to 2.0851 N, in theory 2.0851 N
    no knock where it enters and where the cam takes over: True
"""

import numpy as np

from mbsd3d import GROUND, Body, PointOnPlane, Revolute, SpeedDriver, System, simulate

CENTRES, SLOTS, RATE, INERTIA = 0.10, 4, 4.0, 8e-4  # m between the shafts, rad/s, kg m^2 of the wheel
PIN = CENTRES * np.sin(np.pi / SLOTS)  # the pin enters along the slot, without a knock
REACH = CENTRES * np.cos(np.pi / SLOTS)  # of the slots
HUB = np.array([CENTRES, 0, 0])

driver = Body("driver", 0.5, (1e-3, 1e-3, 1e-3), com=(0, 0, 0))
wheel = Body("wheel", 0.8, (5e-4, 5e-4, INERTIA), position=HUB)
shaft = Revolute(GROUND, driver, at=(0, 0, 0), axis="z", name="driver shaft")
output = Revolute(GROUND, wheel, at=HUB, axis="z", name="wheel shaft")
geneva = System([driver, wheel], [shaft, output, SpeedDriver(shaft, RATE, name="motor")], name="Geneva drive")


def slot(k):
    """Return the joint of the pin in slot k: it stays in the plane of the slot, which turns with the wheel."""
    turn = np.pi + np.pi / SLOTS + k * 2 * np.pi / SLOTS  # of the slot, as built
    along = np.array([np.cos(turn), np.sin(turn), 0])
    return PointOnPlane(wheel, driver, at=HUB + REACH * along, normal=(-along[1], along[0], 0), name="slot")


cam = PointOnPlane(GROUND, wheel, at=HUB + (0.03, 0, 0), normal="y", name="cam")
half = np.pi / 2 - np.pi / SLOTS  # of the driver, while the pin is in a slot
state = geneva.assemble(angles={shaft: -half})
rates, forces, losses = [], [], []
for k in range(SLOTS):
    for joint, turned in ((slot(k), 2 * half), (cam, 2 * np.pi - 2 * half)):
        held = geneva.engage(joint, state)
        run = simulate(held.system, state.t + turned / RATE, state=held.state, rtol=1e-10, output=401)
        state = held.system.release(str(joint.name), run.final).state
        losses.append(held.lost)
        if joint is not cam:
            turning = run
            rates.append(run.rate(output))
            forces.append(np.linalg.norm(run.reaction("slot").force, axis=1))
print(f"{SLOTS} turns of the pin turn the wheel by {np.degrees(run.angle(output)[-1]):.6f} degrees")

ratio, angle = PIN / CENTRES, np.linspace(-half, half, 4001)
square = 1 - 2 * ratio * np.cos(angle) + ratio**2  # of the pin from the hub, over that of the shafts
rate = RATE * ratio * (np.cos(angle) - ratio) / square
load = INERTIA * RATE**2 * ratio * (1 - ratio**2) * np.abs(np.sin(angle)) / square**2.5 / CENTRES
print(f"it is fastest with {np.abs(rates).max():.4f} rad/s, in theory {rate.max():.4f} rad/s")
print(f"the pin presses with up to {np.max(forces):.4f} N, in theory {load.max():.4f} N")
print("no knock where it enters and where the cam takes over:", max(losses) < 1e-12)
figure = turning.plot([("angle", output), ("rate", output)])
