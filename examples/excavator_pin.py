"""Does the pin shear? The stick pin of an excavator over a digging cycle: pressure, shear, bending, and fatigue.

Prints::

    stick pin: 300.23 kN at most
    bending 124.3 MPa, shear 23.6 MPa, no point above 130.8 MPa
    pressure 26.7 MPa in the stick, 33.4 MPa in the cheeks
    life 8.91e+05 cycles, worst at 260 degrees
    by the size of the force alone 1.37e+06 cycles
"""

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    Force,
    Prismatic,
    Pulse,
    Revolute,
    SlideDriver,
    SNCurve,
    Spherical,
    System,
    Universal,
    miner,
    pin_stress,
    rainflow,
    simulate,
)

Y = np.array([0, 1.0, 0])


def cylinder(name, a, b, at_a, at_b, signal):
    """(bodies, joints) of a cylinder: barrel on a cross at a, rod in a ball at b, driven by its stroke [m]."""
    at_a, at_b = np.array(at_a), np.array(at_b)
    along = (at_b - at_a) / np.linalg.norm(at_b - at_a)
    barrel = Body(f"{name} barrel", 60.0, (6.0, 6.0, 0.3), position=at_a + 0.3 * (at_b - at_a))
    rod = Body(f"{name} rod", 40.0, (4.0, 4.0, 0.1), position=at_a + 0.7 * (at_b - at_a))
    slide = Prismatic(barrel, rod, at=(at_a + at_b) / 2, axis=along, name=f"{name} slide")
    joints = [
        Universal(a, barrel, at=at_a, axis_a=Y, axis_b=np.cross(Y, along), name=f"{name} foot"),
        slide,
        Spherical(rod, b, at=at_b, name=f"{name} head"),
        SlideDriver(slide, signal, name=name),
    ]
    return [barrel, rod], joints


boom = Body("boom", 1500.0, (200.0, 4500.0, 4500.0), position=(2.5, 0, 3.0))
stick = Body("stick", 800.0, (50.0, 800.0, 800.0), position=(5.6, 0, 2.6))
pins = [
    Revolute(GROUND, boom, at=(0, 0, 1.5), axis=Y, name="boom pin"),
    Revolute(boom, stick, at=(5.0, 0, 3.8), axis=Y, name="stick pin"),
]
# crowd in through the soil, lift the load, swing back empty
lift = cylinder("lift", GROUND, boom, (0.6, 0, 1.2), (2.4, 0, 3.4), Pulse(0.15, start=4.0, edge=2.0, duration=6.0))
crowd = cylinder("crowd", boom, stick, (2.8, 0, 4.1), (4.6, 0, 4.4), Pulse(0.35, start=0.5, edge=3.0, duration=9.5))
teeth = (6.4, 0, 1.2)
soil = Force(stick, (Pulse(60e3, start=0.5, edge=1.0, duration=3.5), 0, 0), at=teeth, name="soil")
load = Force(stick, (0, 0, Pulse(-12e3, start=2.0, edge=1.0, duration=7.0)), at=teeth, name="full bucket")
digger = System([boom, stick, *lift[0], *crowd[0]], [*pins, *lift[1], *crowd[1]], [soil, load], name="excavator")
run = simulate(digger, 11.0, output=111)

pin = pin_stress(run, "stick pin", diameter=0.09, cheek=0.05, link=0.125, gap=0.003)  # the boom holds it
most = int(np.argmax(pin.load))
print(f"stick pin: {pin.load[most] / 1e3:.2f} kN at most")
shown = (pin.bending[most] / 1e6, pin.shear[most] / 1e6, pin.bound[most] / 1e6)
print("bending {:.1f} MPa, shear {:.1f} MPa, no point above {:.1f} MPa".format(*shown))
print("pressure {:.1f} MPa in the stick, {:.1f} MPa in the cheeks".format(*(p[most] / 1e6 for p in pin.pressures)))
steel = SNCurve(amplitude=60e6, cycles=2e6, slope=5)  # of the material, its surface and notches, by your own data
life = pin.life(steel, strength=900e6)
print(f"life {life.runs:.3g} cycles, worst at {np.degrees(life.worst):.0f} degrees")
print(f"by the size of the force alone {1 / miner(rainflow(pin.bending), steel, strength=900e6):.3g} cycles")
figure = run.plot("effort")
