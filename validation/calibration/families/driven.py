"""Machines with a fully driven motion: arms by sines and ramps, gears and racks behind drivers."""

from typing import Any

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Constant,
    Gear,
    Prismatic,
    RackPinion,
    Ramp,
    Signal,
    Sine,
    SlideDriver,
    System,
)
from validation.calibration.families.chains import chain
from validation.calibration.families.rotors import direction, rotor
from validation.calibration.problem import DRIVEN, Array, Place, Problem, angle, centre, slide


def signal(place: Place, size: float) -> tuple[Signal, float, Any]:
    """Return (signal from zero, its greatest rate, its first rate): a sine and a ramp of up to some turns."""
    rng = place.rng
    amplitude, hertz, phase = (
        size * float(rng.uniform(0.3, 2.0)),
        float(rng.uniform(0.2, 1.5)),
        float(rng.uniform(0, 6)),
    )
    slope = size * float(rng.choice([0.0, rng.normal() * 20.0]))
    made = Sine(amplitude, hertz, phase, -amplitude * np.sin(phase)) + Ramp(slope)
    w = 2.0 * np.pi * hertz
    course = lambda t: amplitude * (np.sin(w * t + phase) - np.sin(phase)) + slope * t  # noqa: E731
    return made, max(amplitude * w + abs(slope), w), (course, amplitude * w * np.cos(phase) + slope)


def driven_arm(place: Place) -> Problem:
    """Draw three links on hinges and a slide, all driven."""
    slides = [False, bool(place.rng.random() < 0.5), False]
    made = [signal(place, 0.3 * place.unit if s else 1.0) for s in slides]
    rates = np.array([first for _, _, (_, first) in made])
    link, bodies, joints, _ = chain(place, [direction(place) for _ in range(3)], slides, rates, 0.0, 0.0)
    drivers = [(SlideDriver if s else AngleDriver)(j, f) for j, s, (f, _, _) in zip(joints, slides, made, strict=True)]

    def course(t: Array) -> Array:
        return np.hstack([np.stack([c(t) for _, _, (c, _) in made], axis=-1), np.zeros((len(t), 3))])

    last = link.centre(2, course)
    readings = [
        slide(j.name, j, c) if s else angle(j.name, j, c)
        for j, s, (_, _, (c, _)) in zip(joints, slides, made, strict=True)
    ]
    readings.append(centre(bodies[-1], lambda t: place.shift + last(t) @ place.axes.T))
    most = max(most / (0.3 * place.unit if s else 1.0) for s, (_, most, _) in zip(slides, made, strict=True))
    system = System(bodies, [*joints, *drivers], gravity=place.gravity)
    return Problem(system, float(place.rng.uniform(0.5, 2.0)), readings, most, DRIVEN)


def driven_gears(place: Place) -> Problem:
    """Draw a driven wheel, a gear on any axis behind it, and a rack behind that; the driver may begin some turns
    away."""
    rng, (made, most, (way_of, _)) = place.rng, signal(place, 1.0)
    begin = float(rng.choice([0.0, rng.uniform(-30.0, 30.0)]))
    course = lambda t: begin + way_of(t)  # noqa: E731
    place.moving = False  # drivers say all
    ratio = float(rng.uniform(0.3, 10.0) * rng.choice([-1.0, 1.0]))
    radius, way = place.length(0.02, 0.2) * float(rng.choice([-1.0, 1.0])), direction(place)
    one, hinge, _ = rotor(place, "one", np.zeros(3), direction(place), 0.0, place.length(0.0, 0.2))
    two, other, _ = rotor(place, "two", place.unit * np.array([0.6, 0.3, 0.2]), direction(place), 0.0, 0.1 * place.unit)
    at = place.unit * np.array([0.1, 0.9, -0.3])
    bar = place.body("bar", 1.3, place.inertia(1.3, 0.2 * place.unit), at)
    rail = Prismatic(GROUND, bar, at=place.point(at), axis=place.axis(way), name="rail")
    couplings = [Gear(hinge, other, ratio=ratio), RackPinion(other, rail, radius=radius)]
    readings = [
        angle("one", hinge, course), angle("two", other, lambda t: ratio * course(t)),
        slide("rail", rail, lambda t: ratio * radius * course(t)),
    ]  # fmt: skip
    driver = AngleDriver(hinge, Constant(begin) + made)
    system = System([one, two, bar], [hinge, other, rail, *couplings, driver], gravity=place.gravity)
    most *= max(1.0, abs(ratio))
    return Problem(system, float(rng.uniform(0.5, 2.0)), readings, most, DRIVEN, start=system.assemble)


FAMILIES = (driven_arm, driven_gears)
