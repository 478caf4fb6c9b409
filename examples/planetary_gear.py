"""A planetary gear: sun in, carrier out, ring held, three planets. Ratio 1 + z_ring / z_sun, and tooth forces.

Prints::

    ratio 3.333333, in theory 3.333333
    motor 18.0000 N m, in theory 18.0000 N m
"""

import numpy as np

from mbsd3d import GROUND, Body, GearMesh, Joint, Revolute, SpeedDriver, System, Torque, simulate

SUN, PLANET = 0.03, 0.02  # pitch radii [m]
RING = SUN + 2 * PLANET
LOAD = -60.0  # torque on the carrier [N m]

sun = Body("sun", 0.5, (1e-3, 1e-3, 5e-4))
carrier = Body("carrier", 2.0, (5e-3, 5e-3, 8e-3))
joints: list[Joint] = [
    sun_shaft := Revolute(GROUND, sun, at=(0, 0, 0), axis=(0, 0, 1), name="sun shaft"),
    out := Revolute(GROUND, carrier, at=(0, 0, 0), axis=(0, 0, 1), name="carrier shaft"),
]
planets = []
for k, angle in enumerate(2 * np.pi * np.arange(3) / 3):
    ray = np.array([np.cos(angle), np.sin(angle), 0.0])
    planets.append(planet := Body(f"planet {k}", 0.2, (1e-4, 1e-4, 4e-5), position=(SUN + PLANET) * ray))
    joints.append(pin := Revolute(carrier, planet, at=(SUN + PLANET) * ray, axis=(0, 0, 1), name=f"pin {k}"))
    joints.append(GearMesh(sun_shaft, pin, at=SUN * ray, carrier=carrier, name=f"sun mesh {k}"))
    joints.append(GearMesh(out, pin, at=RING * ray, carrier=carrier, name=f"ring mesh {k}"))
motor = SpeedDriver(sun_shaft, 100.0, name="motor")
gear = System([sun, carrier, *planets], [*joints, motor], [Torque(carrier, (0, 0, LOAD))], gravity=(0, 0, 0))

run = simulate(gear, 0.2)
ratio = 100.0 / run.rate("carrier shaft")[-1]
print(f"ratio {ratio:.6f}, in theory {1 + RING / SUN:.6f}")
print(f"motor {run.effort(motor)[-1]:.4f} N m, in theory {-LOAD / (1 + RING / SUN):.4f} N m")
figure = run.picture()
