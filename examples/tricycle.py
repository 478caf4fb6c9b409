"""A tricycle on three tyres turns: from which speed on does it lift its inner wheel?

Prints::

    rigid, it tips at 0.354 g: at 5.90 m/s
    3.0 m/s, 0.090 g: inner wheel 261 N, by balance of moments 261 N
    4.5 m/s, 0.195 g: inner wheel 150 N, by balance of moments 150 N
    5.6 m/s, 0.287 g: inner wheel 53 N, by balance of moments 53 N
"""

import numpy as np

from mbsd3d import GROUND, AngleDriver, Body, Pulse, Revolute, System, Tyre, simulate

BASE, TRACK, RADIUS, G = 1.2, 0.75, 0.28, 9.81  # m, m, m, m/s^2
FRAME, WHEEL, COM = 100.0, 3.0, np.array([-0.8, 0, 0.72])  # kg with the rider, kg, from the front contact [m]
STEER, STIFF = 0.12, 1.2e5  # rad, N/m
AXLE = (0, 1, 0)  # of all wheels, to the left


def turning(speed):
    """Return the run from straight ahead into a left turn at a speed [m/s], coasting."""
    places = {"front": (0, 0), "left": (-BASE, TRACK / 2), "right": (-BASE, -TRACK / 2)}
    rolling = {"velocity": (speed, 0, 0), "omega": (0, speed / RADIUS, 0)}
    sag = FRAME * G / 3 / STIFF
    hubs = {name: np.array([x, y, RADIUS - sag]) for name, (x, y) in places.items()}
    wheels = {name: Body(name, WHEEL, (0.06, 0.12, 0.06), position=hub, **rolling) for name, hub in hubs.items()}
    frame = Body("frame", FRAME, (14.0, 18.0, 10.0), position=COM, velocity=(speed, 0, 0), omega=(0, 0, 0))
    fork = Body("fork", 4.0, (0.2, 0.2, 0.05), position=(0, 0, 0.6), velocity=(speed, 0, 0), omega=(0, 0, 0))
    head = Revolute(frame, fork, at=(0, 0, 0.6), axis=(0, 0, 1), name="head")
    hinges = [
        Revolute(fork if name == "front" else frame, wheel, at=hubs[name], axis=AXLE, name=f"{name} hub")
        for name, wheel in wheels.items()
    ]
    handlebar = AngleDriver(head, Pulse(STEER, start=0.5, edge=1.0), name="handlebar")
    tyres = [
        Tyre(GROUND, wheel, axis=AXLE, radius=RADIUS, crown=0.02, stiffness=STIFF, cornering=12.0, relaxation=0.15,
             name=f"{name} tyre")
        for name, wheel in wheels.items()
    ]  # fmt: skip
    trike = System([frame, fork, *wheels.values()], [head, *hinges, handlebar], tyres, name="tricycle")
    return simulate(trike, 5.0, output=501)


mass = FRAME + 4.0 + 3 * WHEEL
back = -(FRAME * COM[0] - 2 * WHEEL * BASE) / mass  # of the common centre of mass behind the front contact [m]
height = (FRAME * COM[2] + 4.0 * 0.6 + 3 * WHEEL * RADIUS) / mass
limit = G * back / BASE * TRACK / 2 / height  # acceleration across at which the inner wheel of a rigid one is free
print(f"rigid, it tips at {limit / G:.3f} g: at {np.sqrt(limit * BASE / STEER):.2f} m/s")
for speed in (3.0, 4.5, 5.6):
    run = turning(speed)
    inner, outer = (run.force(f"{side} tyre").normal[-1] for side in ("left", "right"))
    pull = sum(body.mass * run.acceleration(body)[-1] for body in run.system.bodies) / mass
    ahead, across, _ = pull @ run.rotation("frame")[-1]
    lean = (outer - inner) / (STIFF * TRACK)  # of the frame, on its tyres
    spin = 3 * 0.12 * run.rate("left hub")[-1] * run.omega("frame")[-1, 2]  # moment that turns the wheels' spin
    rear = mass * (G * back + ahead * height) / BASE
    theory = rear / 2 - (mass * height * (across + G * lean) + spin) / TRACK
    print(f"{speed} m/s, {across / G:.3f} g: inner wheel {inner:.0f} N, by balance of moments {theory:.0f} N")
figure = run.picture(2.0, traces=(), hidden=["body names", "joint names"], view=(-60, 25))
