"""Random closed loops in general position, and the same loop as its axes alone, for `validation.theory`."""

from collections.abc import Callable
from typing import Any

import numpy as np

from mbsd3d import Revolute, System, linkages, rotation
from mbsd3d.extend import matrix
from mbsd3d.inertia import MassProperties
from validation.theory import HingeLoop

ORIGIN = (0.0, 0.0, 0.0)


def parts(rng: np.random.Generator, count: int) -> list[MassProperties]:
    """Draw masses of 0.5 to 2 kg, centres up to 0.2 m off the reference point, and inertias that a body can have."""
    found = []
    for _ in range(count):
        moments, turn = rng.uniform(0.7, 1.0, 3), matrix(rotation(rng.normal(size=3), rng.uniform(0.0, np.pi)))
        mass = rng.uniform(0.5, 2.0)
        found.append(MassProperties(mass, rng.uniform(-0.2, 0.2, 3), 0.1 * mass * turn @ np.diag(moments) @ turn.T))
    return found


def place(rng: np.random.Generator) -> dict[str, Any]:
    """Draw a base pose anywhere."""
    return {
        "position": rng.normal(size=3), "orientation": rotation(rng.normal(size=3), rng.uniform(0.3, 3.0)),
        "gravity": ORIGIN,
    }  # fmt: skip


def bennett(rng: np.random.Generator) -> System:
    """Draw a Bennett linkage."""
    alpha, beta, a = rng.uniform(0.4, 1.4), rng.uniform(1.6, 2.6), rng.uniform(0.5, 1.5)
    b, angle = a * np.sin(beta) / np.sin(alpha), rng.uniform(0.5, 2.0)
    return linkages.bennett(a, alpha, b, beta, angle, links=parts(rng, 3), **place(rng))


def goldberg(rng: np.random.Generator) -> System:
    """Draw a Goldberg linkage."""
    alpha, beta, gamma, a = rng.uniform(0.4, 1.2), rng.uniform(1.7, 2.6), rng.uniform(0.4, 1.2), rng.uniform(0.4, 1.0)
    (b, c), angle = a * np.sin([beta, gamma]) / np.sin(alpha), rng.uniform(0.5, 2.0)
    return linkages.goldberg(a, alpha, b, beta, c, gamma, angle, links=parts(rng, 4), **place(rng))


def myard(rng: np.random.Generator) -> System:
    """Draw a Myard linkage."""
    alpha, a, angle = rng.uniform(0.4, 1.2), rng.uniform(0.4, 1.0), rng.uniform(0.5, 2.0)
    return linkages.myard(a, alpha, a / np.sin(alpha), angle, links=parts(rng, 4), **place(rng))


def _bricard(make: Callable[..., System], rng: np.random.Generator, offsets: int) -> System:
    """Draw random numbers until a linkage closes."""
    while True:
        numbers = rng.uniform(0.5, 1.5, 3), rng.uniform(0.5, 2.6, 3), rng.uniform(-0.3, 0.3, offsets)
        angle, links, base = rng.uniform(-2.0, 2.0), parts(rng, 5), place(rng)
        try:
            return make(*numbers, angle, links=links, **base)
        except ValueError as refusal:
            if "no closed pose" not in str(refusal):
                raise


def bricard_line(rng: np.random.Generator) -> System:
    """Draw a line-symmetric Bricard linkage."""
    return _bricard(linkages.bricard_line, rng, 3)


def bricard_plane(rng: np.random.Generator) -> System:
    """Draw a plane-symmetric Bricard linkage."""
    return _bricard(linkages.bricard_plane, rng, 2)


def sarrus(rng: np.random.Generator) -> System:
    """Draw a Sarrus linkage whose legs are not nearly straight."""
    first, second = rng.uniform(0.5, 0.6, 2), rng.uniform(0.65, 0.75, 2)
    between, angle, reach = rng.uniform(1.0, 2.2), rng.uniform(0.7, 1.0), rng.uniform(0.1, 0.4)
    return linkages.sarrus(first, second, between, angle, reach=reach, links=parts(rng, 5), **place(rng))


def schatz(rng: np.random.Generator) -> System:
    """Draw a Schatz linkage."""
    length, angle, offset = rng.uniform(0.4, 1.0), rng.uniform(-1.2, 1.2), rng.uniform(-0.3, 0.3)
    return linkages.schatz(length, angle, offset=offset, links=parts(rng, 5), **place(rng))


FAMILIES = {
    "bennett": bennett, "goldberg": goldberg, "myard": myard, "bricard_line": bricard_line,
    "bricard_plane": bricard_plane, "sarrus": sarrus, "schatz": schatz,
}  # fmt: skip


def as_axes(system: System) -> HingeLoop:
    """Return axes, masses, centres and inertias of a loop of hinges at its reference pose, for the closed form."""
    bodies, hinges = system.bodies, [joint for joint in system.joints if isinstance(joint, Revolute)]
    R = [matrix(body.orientation) for body in bodies]
    return HingeLoop(
        np.array([joint.at for joint in hinges]), np.array([joint.axis for joint in hinges]),
        np.array([body.mass for body in bodies]),
        np.array([body.position + turn @ body.com for body, turn in zip(bodies, R, strict=True)]),
        np.array([turn @ body.inertia @ turn.T for body, turn in zip(bodies, R, strict=True)]),
        np.asarray(system.gravity, float),
    )  # fmt: skip
