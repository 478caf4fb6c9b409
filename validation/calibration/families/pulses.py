"""Loads of short duration: pulses at known times, and user functions at unknown times."""

from functools import partial
from typing import Any

import numpy as np

from mbsd3d import GROUND, CustomForce, Force, Prismatic, Pulse, System
from validation.calibration.families.rotors import direction
from validation.calibration.problem import Array, Place, Problem, slide


def push_for_a_while(t: float, bodies: Any, z: Array, parameters: Array, loads: Array, z_dot: Array) -> None:
    """Apply a force (3 numbers) from one time to another."""
    if parameters[3] <= t < parameters[4]:
        for i in range(3):
            loads[0, i] = parameters[i]


def block(place: Place) -> tuple:
    """Return (body, rail, direction, mass) without weight, at rest or not."""
    way, mass = direction(place), float(place.rng.uniform(0.5, 3.0))
    at = place.unit * place.rng.normal(size=3)
    speed = place.length(-1.0, 1.0) * float(place.rng.choice([0.0, 1.0]))
    body = place.body("block", mass, place.inertia(mass, 0.2 * place.unit), at, speed * way, np.zeros(3))
    return body, Prismatic(GROUND, body, at=place.point(at), axis=place.axis(way), name="rail"), way, mass, speed


def fallen(start: float, edge: float, t: Array) -> Array:
    """Return the displacement by a smooth force: twice integrated 0 before ``start``, 3 s^2 - 2 s^3 of its share of the
    edge, 1 afterwards.
    """
    s = np.clip((t - start) / edge, 0.0, None)
    within = edge**2 * (s**4 / 4.0 - s**5 / 10.0)
    after = edge**2 * (0.15 + 0.5 * (s - 1.0) + 0.5 * (s - 1.0) ** 2)
    return np.where(s < 1.0, within, after)


def pulse(place: Place) -> Problem:
    """Draw a short pulse on a block that slides freely."""
    body, rail, way, mass, speed = block(place)
    rng, t_end = place.rng, float(place.rng.uniform(0.5, 2.0))
    edge = float(np.exp(rng.uniform(np.log(2e-5), np.log(2e-2))))
    last, start = edge * float(rng.uniform(2.0, 5.0)), t_end * float(rng.uniform(0.05, 0.6))
    gained = place.length(0.5, 2.0)
    height = mass * gained / (last - edge)
    signals = [Pulse(float(x), start, edge, duration=last) for x in height * place.axis(way)]
    course = lambda t: (  # noqa: E731
        speed * t + height / mass * (fallen(start, edge, t) - fallen(start + last - edge, edge, t))
    )
    system = System([body], [rail], [Force(body, signals)], gravity=(0, 0, 0))
    return Problem(system, t_end, [slide("rail", rail, course)], 2.0 * np.pi / t_end)


def own_force(place: Place) -> Problem:
    """Draw a force by a user function that acts for a hundredth of the run up to a third of it; its times are given, or
    not.
    """
    body, rail, way, mass, speed = block(place)
    rng, t_end = place.rng, float(place.rng.uniform(0.5, 2.0))
    last = t_end * float(np.exp(rng.uniform(np.log(0.005), np.log(0.3))))
    start = t_end * float(rng.uniform(0.05, 0.6))
    gain = place.length(0.5, 2.0) / last
    told = rng.random() < 0.5
    numbers = (*(mass * gain * place.axis(way)), start, start + last)
    force = CustomForce(
        push_for_a_while, on=body, points=[body.centre], parameters=numbers,
        times=(start, start + last) if told else (),
    )  # fmt: skip
    kink = partial(np.clip, a_min=0.0, a_max=None)
    course = lambda t: speed * t + 0.5 * gain * (kink(t - start) ** 2 - kink(t - start - last) ** 2)  # noqa: E731
    system = System([body], [rail], [force], gravity=(0, 0, 0))
    return Problem(system, t_end, [slide("rail", rail, course)], 2.0 * np.pi / t_end, unsure=not told)


FAMILIES = (pulse, own_force)
