"""Vehicles off the ground as cases for engines without tyres: bearings, springs, steering, a brake."""

from dataclasses import replace
from typing import Any

import numpy as np

from bicycle import named, whipple
from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Brake,
    Cylindrical,
    Joint,
    Polynomial,
    Revolute,
    Sine,
    Spherical,
    SpringDamper,
    System,
    rotation,
)
from validation.suite.trials.trial import Run, Trial, run

T_END, SAMPLES = 0.6, 9
CORNERS = {
    "front left": (1.25, 0.74),
    "front right": (1.2, -0.71),
    "rear left": (-1.45, 0.76),
    "rear right": (-1.4, -0.7),
}
"""Of the car [m], ahead and to the left of its O."""


def trials(quick: bool) -> list[Trial]:
    """Return a bicycle in the air, a car on a hook, a wheel that is braked to rest."""
    titles = {
        thrown: "a bicycle in the air: it turns, steers, and its wheels spin",
        hooked: "a car on a hook: springs, spinning wheels, front ones that steer",
        braked: "an unbalanced wheel on a slanted axle, braked until it stands",
    }
    alone = "in a short run other engines are not asked about vehicles" if quick else ""
    return [Trial(f"vehicle_{make.__name__}", "vehicles", title, make, alone=alone) for make, title in titles.items()]


def thrown() -> Run:
    """Simulate a bicycle with its nine degrees of freedom on tyres, and a strut that springs and damps the steering."""
    motion: dict[str, Any] = {"lean": 0.2, "steer": -0.3, "lean_rate": 0.7, "steer_rate": -1.1}
    ridden = whipple(named("meijaard2007_browser_jason"), 6.0, **motion)
    frame, fork = (ridden.part(name) for name in ("frame", "fork"))
    ends = {"at_a": frame.position + (0.6, 0.05, 0.3), "at_b": fork.position + (-0.1, 0.12, 0.35)}
    strut = SpringDamper(frame, fork, **ends, stiffness=900.0, damping=40.0, name="steering strut")
    system = replace(ridden, joints=list(ridden.joints)[:3], forces=[strut])
    return run(system, T_END, state=system.state(), output=SAMPLES)


def hooked() -> Run:
    """Simulate a chassis on a ball, four carriers that slide in it on springs, wheels that spin in them at 40 rad/s."""
    at = np.array([0.3, -0.2, 1.6])
    turned = rotation((0.4, 1.0, 0.2), 0.3)
    chassis = Body(
        "chassis",
        900.0,
        (300.0, 1200.0, 1350.0),
        com=(0.05, 0.03, 0.1),
        position=at,
        orientation=turned,
        omega=(0.1, -0.2, 0.3),
    )
    ahead, aside, up = chassis.axes.T
    bodies, forces = [chassis], []
    joints: list[Joint] = [Spherical(GROUND, chassis, at=at + 0.8 * up - 0.2 * ahead, name="hook")]
    for k, (name, (x, y)) in enumerate(CORNERS.items()):
        hub = at + x * ahead + y * aside - 0.25 * up
        place = {"position": hub, "orientation": turned}
        carrier = Body(f"{name} carrier", 15.0, (0.4, 0.5, 0.3), com=(0.02, -0.06 * np.sign(y), 0.04), **place)
        wheel = Body(f"{name} wheel", 22.0, (0.7, 1.2, 0.75), com=(0.002, 0.01, -0.003), **place)
        leg = Cylindrical(chassis, carrier, at=hub, axis=up + 0.1 * ahead, name=f"{name} leg")
        steer = Sine(0.3, 1.3) + 0.02 * k if name.startswith("front") else 0.0
        joints += [leg, AngleDriver(leg, steer, name=f"{name} steering")]
        joints.append(Revolute(carrier, wheel, at=hub, axis=aside + 0.02 * up, name=f"{name} hub"))
        ends = {"at_a": hub + 0.45 * up + 0.05 * ahead, "at_b": hub + 0.1 * up}
        forces.append(SpringDamper(chassis, carrier, **ends, stiffness=18e3, damping=900.0, name=f"{name} spring"))
        bodies += [carrier, wheel]
    system = System(bodies, joints, forces)
    spins: dict[Joint | str, float] = {f"{name} hub": 40.0 - 3.0 * k for k, name in enumerate(CORNERS)}
    start = system.assemble(rates=spins)
    return run(system, T_END, state=start, output=SAMPLES)


def braked() -> Run:
    """Simulate a wheel that slips under a rising torque, stops after 0.3 s, and is held against its weight."""
    axis, hub = np.array([0.3, 1.0, -0.2]), (0.4, -0.1, 0.7)
    wheel = Body("wheel", 6.0, (0.17, 0.31, 0.16), com=(0.05, 0.01, 0.03), position=hub, orientation=rotation("x", 0.4))
    hinge = Revolute(GROUND, wheel, at=hub, axis=axis, name="hub")
    brake = Brake(hinge, torque=Polynomial((4.0, 40.0)), stiffness=900.0, damping=25.0, name="brake")
    system = System([wheel], [hinge], [brake])
    return run(system, T_END, state=system.assemble(rates={"hub": 9.0}), output=SAMPLES)
