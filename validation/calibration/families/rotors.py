"""Wheels and their couplings, over many turns: closed forms with a constant acceleration or a drag."""

from collections.abc import Callable
from functools import reduce
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import GROUND, Gear, GearMesh, Prismatic, RackPinion, Revolute, Screw, State, System, Torque, TorsionSpring
from validation.calibration.problem import Array, Place, Problem, angle, centre, scaled, slide

UP = np.array([0.0, 0.0, 1.0])


class Turning(NamedTuple):
    """Angle over time: begin + rate t + gain t^2 / 2 [rad]."""

    rate: float
    gain: float
    t_end: float
    begin: float = 0.0

    def course(self, t: Array) -> Array:
        """Return the angle at time t [rad]."""
        return self.begin + self.rate * t + 0.5 * self.gain * t**2

    @property
    def fastest(self) -> float:
        """Return the greatest rate [rad/s]."""
        return max(abs(self.rate), abs(self.rate + self.gain * self.t_end))

    def start(self, system: System, hinge: Any) -> Callable[[], State | None]:
        """Return a function that sets a start some turns from the reference pose, where the bodies have their
        velocities.
        """
        if not self.begin:
            return lambda: None
        return lambda: system.assemble(angles={hinge: self.begin}, rates={hinge: self.rate})


def turning(place: Place) -> Turning:
    """Draw a rotation by 3 to 300 rad; one in four starts some turns from its reference pose."""
    rng = place.rng
    t_end = float(rng.uniform(0.5, 3.0))
    turned = float(np.exp(rng.uniform(np.log(3.0), np.log(300.0)))) * float(rng.choice([-1.0, 1.0]))
    share = float(rng.choice([0.0, 1.0, rng.uniform()]))  # of the turning that is there at the start
    begin = float(rng.uniform(-30.0, 30.0)) if rng.random() < 0.25 else 0.0
    place.moving = begin == 0.0
    return Turning(share * turned / t_end, 2.0 * (1.0 - share) * turned / t_end**2, t_end, begin)


def rotor(place: Place, name: str, at: Array, axis: Array, rate: float, off: float = 0.0) -> tuple:
    """Return (body, hinge on the ground, moment of inertia about its axis): centre of mass ``off`` beside the axis."""
    mass = float(place.rng.uniform(0.5, 3.0))
    tensor = place.inertia(mass, place.length(0.1, 0.3))
    across = np.cross(axis, (0.3, -0.5, 0.8))
    arm = off * across / np.linalg.norm(across)
    body = place.body(name, mass, tensor, at + arm, rate * np.cross(axis, arm), rate * axis)
    hinge = Revolute(GROUND, body, at=place.point(at), axis=place.axis(axis), name=f"{name} hinge")
    return body, hinge, axis @ tensor @ axis + mass * off**2


def wheel(place: Place) -> Problem:
    """Draw a wheel with its centre beside an upright axis, under a torque or a drag."""
    turn = turning(place)
    rate, gain, course = turn.rate, turn.gain, turn.course
    body, hinge, inertia = rotor(place, "wheel", place.length(-1, 1) * np.ones(3), UP, rate, place.length(0.05, 0.3))
    loads: list = [Torque(body, place.axis(inertia * gain * UP))]
    if gain == 0.0:
        drag = float(place.rng.uniform(0.1, 2.0)) / turn.t_end
        loads = [TorsionSpring(hinge, stiffness=0.0, damping=drag * inertia)]
        course = lambda t: turn.begin - rate / drag * np.expm1(-drag * t)  # noqa: E731
    system = System([body], [hinge], loads, gravity=place.gravity)
    start = turn.start(system, hinge)
    return Problem(system, turn.t_end, [angle("wheel", hinge, course)], turn.fastest, start=start)


def direction(place: Place) -> Array:
    """Draw a unit vector of the frame."""
    axis = place.rng.normal(size=3)
    return axis / np.linalg.norm(axis)


def belt(place: Place) -> Problem:
    """Draw two to five wheels on axes of any direction, each geared to the one before."""
    turn = turning(place)
    rate, gain, course = turn.rate, turn.gain, turn.course
    count = int(place.rng.integers(2, 6))
    ratios = [float(place.rng.uniform(0.3, 2.5) * place.rng.choice([-1.0, 1.0])) for _ in range(count - 1)]
    total = [reduce(lambda x, y: x * y, ratios[:k], 1.0) for k in range(count)]
    parts = [
        rotor(place, f"wheel {k}", place.unit * np.array([0.8 * k, 0.1, -0.2]), direction(place), rate * i)
        for k, i in enumerate(total)
    ]
    bodies, hinges, inertias = zip(*parts, strict=True)
    gears = [Gear(a, b, ratio=r) for a, b, r in zip(hinges, hinges[1:], ratios, strict=False)]
    moment = gain * sum(J * i**2 for J, i in zip(inertias, total, strict=True))
    drive = Torque(bodies[0], moment * hinges[0].axis)
    readings = [angle(h.name, h, scaled(i, course)) for h, i in zip(hinges, total, strict=True)]
    most = turn.fastest * max(abs(i) for i in total)
    system = System(bodies, [*hinges, *gears], [drive], gravity=place.gravity)
    return Problem(system, turn.t_end, readings, most, start=turn.start(system, hinges[0]))


def mesh(place: Place) -> Problem:
    """Draw two helical gears in mesh on parallel axes, outside each other."""
    turn = turning(place)
    rate, gain, course = turn.rate, turn.gain, turn.course
    axis, (r_a, r_b) = direction(place), (place.length(0.05, 0.3), place.length(0.05, 0.3))
    out = np.cross(axis, (0.2, 0.9, -0.4))
    out /= np.linalg.norm(out)
    ratio = -r_a / r_b
    a, hinge_a, J_a = rotor(place, "a", np.zeros(3), axis, rate)
    b, hinge_b, J_b = rotor(place, "b", (r_a + r_b) * out, axis, rate * ratio)
    teeth = GearMesh(hinge_a, hinge_b, at=place.point(r_a * out), helix_angle=float(place.rng.uniform(-0.5, 0.5)))
    drive = Torque(a, gain * (J_a + J_b * ratio**2) * hinge_a.axis)
    readings = [angle("a", hinge_a, course), angle("b", hinge_b, lambda t: ratio * course(t))]
    system = System([a, b], [hinge_a, hinge_b, teeth], [drive], gravity=place.gravity)
    start = turn.start(system, hinge_a)
    return Problem(system, turn.t_end, readings, turn.fastest * max(1.0, -ratio), start=start)


def planetary(place: Place) -> Problem:
    """Draw sun, planet on a carrier, and ring at rest (Willis), upright."""
    turn = turning(place)  # of the sun
    rate, gain, course = turn.rate, turn.gain, turn.course
    r_s, r_p = place.length(0.1, 0.3), place.length(0.05, 0.2)
    arm, ring = r_s + r_p, r_s + 2.0 * r_p
    i_c = 1.0 / (1.0 + ring / r_s)
    i_rel = -(1.0 - i_c) * r_s / r_p
    i_p = i_c + i_rel
    sun, hinge_s, J_s = rotor(place, "sun", np.zeros(3), UP, rate)
    carrier, hinge_c, J_c = rotor(place, "carrier", np.zeros(3), UP, rate * i_c)
    out, mass = np.array([np.cos(0.7), np.sin(0.7), 0.0]), float(place.rng.uniform(0.2, 2.0))
    tensor = place.inertia(mass, place.length(0.05, 0.1))
    planet = place.body("planet", mass, tensor, arm * out, rate * i_c * arm * np.cross(UP, out), rate * i_p * UP)
    hinge_p = Revolute(carrier, planet, at=place.point(arm * out), axis=place.axis(UP), name="planet hinge")
    teeth = [
        GearMesh(hinge_s, hinge_p, at=place.point(r_s * out), carrier=carrier),
        GearMesh(hinge_c, hinge_p, at=place.point(ring * out), carrier=carrier),
    ]
    J = J_s + (J_c + mass * arm**2) * i_c**2 + tensor[2, 2] * i_p**2
    drive = Torque(sun, gain * J * hinge_s.axis)
    system = System([sun, carrier, planet], [hinge_s, hinge_c, hinge_p, *teeth], [drive], gravity=place.gravity)
    readings = [
        angle("sun", hinge_s, course), angle("carrier", hinge_c, lambda t: i_c * course(t)),
        angle("planet", hinge_p, lambda t: i_rel * course(t)),
    ]  # fmt: skip
    most = turn.fastest * max(1.0, abs(i_p), abs(i_rel))
    return Problem(system, turn.t_end, readings, most, start=turn.start(system, hinge_s))


def rack(place: Place) -> Problem:
    """Draw a pinion that drives a rack up or down a slope, against its weight."""
    turn = turning(place)
    rate, gain, course = turn.rate, turn.gain, turn.course
    radius, way = place.length(0.02, 0.2) * float(place.rng.choice([-1.0, 1.0])), direction(place)
    pinion, hinge, J = rotor(place, "pinion", np.zeros(3), direction(place), rate)
    mass, at = float(place.rng.uniform(0.5, 5.0)), place.unit * np.array([0.4, 0.3, -0.2])
    bar = place.body("bar", mass, place.inertia(mass, place.length(0.1, 0.3)), at, rate * radius * way, np.zeros(3))
    rail = Prismatic(GROUND, bar, at=place.point(at), axis=place.axis(way), name="rail")
    moment = gain * (J + mass * radius**2) + mass * place.g * way[2] * radius
    system = System(
        [pinion, bar], [hinge, rail, RackPinion(hinge, rail, radius=radius)], [Torque(pinion, moment * hinge.axis)],
        gravity=place.gravity,
    )  # fmt: skip
    start = place.point(at)
    readings = [
        angle("pinion", hinge, course), slide("rail", rail, lambda t: radius * course(t)),
        centre(bar, lambda t: start + radius * np.outer(course(t), place.axis(way))),
    ]  # fmt: skip
    return Problem(system, turn.t_end, readings, turn.fastest, start=turn.start(system, hinge))


def nut(place: Place) -> Problem:
    """Draw a nut that winds down a thread at rest by its own weight."""
    rng, way, mass = place.rng, direction(place), float(place.rng.uniform(0.2, 3.0))
    lead = place.length(0.01, 0.3) * float(rng.choice([-1.0, 1.0]))
    tensor = place.inertia(mass, place.length(0.05, 0.2))
    p, J = lead / (2.0 * np.pi), way @ tensor @ way
    gain = -mass * place.g * way[2] * p / (J + mass * p**2)
    t_end, rate = float(rng.uniform(0.5, 4.0)), float(rng.normal() * 10.0)
    body = place.body("nut", mass, tensor, np.zeros(3), rate * p * way, rate * way)
    thread = Screw(GROUND, body, at=place.point(place.unit * way), axis=place.axis(way), pitch=lead, name="thread")
    turn = Turning(rate, gain, t_end)
    readings = [angle("thread", thread, turn.course), slide("thread", thread, lambda t: p * turn.course(t))]
    return Problem(System([body], [thread], gravity=place.gravity), t_end, readings, max(turn.fastest, 1.0))


def lead_screw(place: Place) -> Problem:
    """Draw a spindle that turns on the ground and moves a nut that slides."""
    turn = turning(place)
    rate, gain, course = turn.rate, turn.gain, turn.course
    way = direction(place)
    lead = place.length(0.005, 0.1) * float(place.rng.choice([-1.0, 1.0]))
    p, mass = -lead / (2.0 * np.pi), float(place.rng.uniform(0.2, 3.0))
    spindle, hinge, J = rotor(place, "spindle", np.zeros(3), way, rate)
    at = 0.4 * place.unit * way
    body = place.body("nut", mass, place.inertia(mass, place.length(0.05, 0.2)), at, rate * p * way, np.zeros(3))
    rail = Prismatic(GROUND, body, at=place.point(at), axis=place.axis(way), name="rail")
    thread = Screw(spindle, body, at=place.point(at), axis=place.axis(way), pitch=lead, name="thread")
    moment = gain * (J + mass * p**2) + mass * place.g * way[2] * p
    system = System(
        [spindle, body], [hinge, rail, thread], [Torque(spindle, moment * hinge.axis)], gravity=place.gravity
    )
    readings = [
        angle("spindle", hinge, course), slide("rail", rail, lambda t: p * course(t)),
        angle("thread", thread, lambda t: -course(t)),
    ]  # fmt: skip
    return Problem(system, turn.t_end, readings, turn.fastest, start=turn.start(system, hinge))


FAMILIES = (wheel, belt, mesh, planetary, rack, nut, lead_screw)
