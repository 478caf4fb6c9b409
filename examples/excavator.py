"""An excavator: boom and stick on hydraulic cylinders. What do the cylinders hold with a full bucket?

Prints::

    mobility 0
    lift cylinder 247.70 kN at first, 218.18 kN at the end
    crowd cylinder -32.39 kN at first, -49.10 kN at the end
    the bucket rises by 1.905 m
    work of the cylinders 46.540 kJ, gained 46.540 kJ
"""

import numpy as np

from mbsd3d import GROUND, Body, Force, Prismatic, Ramp, Revolute, SlideDriver, Spherical, System, Universal, simulate

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
lift = cylinder("lift", GROUND, boom, (0.6, 0, 1.2), (2.4, 0, 3.4), Ramp(0.05))
crowd = cylinder("crowd", boom, stick, (2.8, 0, 4.1), (4.6, 0, 4.4), Ramp(0.0))
bucket = Force(stick, (0, 0, -12e3), at=(6.4, 0, 1.2), name="full bucket")
digger = System([boom, stick, *lift[0], *crowd[0]], [*pins, *lift[1], *crowd[1]], [bucket], name="excavator")
print("mobility", digger.check().mobility)

run = simulate(digger, 4.0, output=41)
for name in ("lift", "crowd"):
    force = run.effort(name) / 1e3
    print(f"{name} cylinder {force[0]:.2f} kN at first, {force[-1]:.2f} kN at the end")
bucket_rise = run.body_point(stick, (6.4, 0, 1.2))[:, 2]
print(f"the bucket rises by {bucket_rise[-1] - bucket_rise[0]:.3f} m")
given = sum(run.work(name)[-1] for name in ("lift", "crowd"))
potential = run.energy().total[-1] - run.energy().total[0] + 12e3 * (bucket_rise[-1] - bucket_rise[0])
print(f"work of the cylinders {given / 1e3:.3f} kJ, gained {potential / 1e3:.3f} kJ")
figure = run.picture(shown=["reaction force"])
