"""Open chains of hinges and slides: pendulums over many turns, double pendulums, arms with springs, chaos."""

from collections.abc import Callable
from math import cos, sin
from typing import Any

import numpy as np

from mbsd3d import GROUND, Prismatic, Revolute, System, TorsionSpring
from validation.calibration.families.rotors import direction
from validation.calibration.problem import Array, Place, Problem, angle, centre, column, slide
from validation.calibration.rates import Chain, motion
from validation.theory import pendulum_frequency, pendulum_motion


def chain(place: Place, axes: list[Array], slides: list[bool], rates: Array, stiff: float, drag: float) -> tuple:
    """Return (Chain, bodies, joints, springs): links of about a unit length in a zigzag."""
    n, rng, unit = len(axes), place.rng, place.unit
    steps = unit * (0.5 * rng.normal(size=(n, 3)) + (0.2, 0.1, -0.6))
    points = np.cumsum(np.vstack([np.zeros(3), steps[:-1]]), axis=0)
    masses = rng.uniform(0.5, 2.0, n)
    tensors = np.array([place.inertia(m, place.length(0.1, 0.3)) for m in masses])
    centres = points + 0.6 * steps + 0.1 * unit * rng.normal(size=(n, 3))
    scale = masses.mean() * unit * unit
    k = stiff * scale * np.where(slides, 1.0 / unit**2, 1.0)
    c = drag * scale * np.where(slides, 1.0 / unit**2, 1.0)
    link = Chain(
        points, np.array(axes), np.array(slides), masses, centres, tensors, np.array([0.0, 0.0, -place.g]), k, c
    )
    bodies: list[Any] = [GROUND]
    joints, springs = [], []
    for i, (speed, spin) in enumerate(link.velocities(rates)):
        bodies.append(place.body(f"link {i}", masses[i], tensors[i], centres[i], speed, spin))
        kind = Prismatic if slides[i] else Revolute
        joints.append(
            kind(bodies[-2], bodies[-1], at=place.point(points[i]), axis=place.axis(axes[i]), name=f"joint {i}")
        )
        if stiff or drag:
            springs.append(TorsionSpring(joints[-1], stiffness=k[i], damping=c[i]))
    return link, bodies[1:], joints, springs


Truth = Callable[[Chain, Array, float], Callable[[Array], Array]]


def least(link: Chain, rates: Array, t_end: float) -> Callable[[Array], Array]:
    """Return the truth by the equations of `Chain`."""
    return link.motion(np.zeros(len(rates)), rates, t_end)


def problem(
    place: Place, axes: list, slides: list, rates: Array, t_end: float, truth: Truth = least, unsure: bool = False,
    **law: float,
) -> Problem:  # fmt: skip
    """Return a chain on its joints, with its truth (q, v)(t) from the reference pose."""
    link, bodies, joints, springs = chain(place, axes, slides, rates, law.get("stiff", 0.0), law.get("drag", 0.0))
    n = len(axes)
    course = truth(link, rates, t_end)
    readings = [
        slide(j.name, j, column(i, course)) if slides[i] else angle(j.name, j, column(i, course))
        for i, j in enumerate(joints)
    ]  # fmt: skip
    last = link.centre(n - 1, course)
    readings.append(centre(bodies[-1], lambda t: place.shift + last(t) @ place.axes.T))
    sizes = np.where(slides, place.unit, 1.0)
    fast = float((np.abs(course(np.linspace(0.0, t_end, 200))[:, n:]) / sizes).max())
    system = System(bodies, joints, springs, gravity=place.gravity)
    return Problem(system, t_end, readings, max(fast, np.sqrt(9.81 + law.get("stiff", 0.0))), unsure=unsure)


def across(link: Chain) -> tuple[float, Callable[[Array], tuple[float, float]]]:
    """Return (gravity across the parallel axes, polar coordinates of a vector in the plane across them, from down)."""
    u = link.axes[0]
    g = link.gravity - link.gravity @ u * u
    down = g / np.linalg.norm(g)
    side = np.cross(u, down)
    return float(np.linalg.norm(g)), lambda x: (
        float(np.hypot(x @ down, x @ side)),
        float(np.arctan2(x @ side, x @ down)),
    )


def swinging(link: Chain, rates: Array, t_end: float) -> Callable[[Array], Array]:
    """Return the truth of one link by elliptic functions."""
    g, polar = across(link)
    u, m = link.axes[0], link.masses[0]
    far, begin = polar(link.centres[0] - link.points[0])
    w = pendulum_frequency(u @ link.inertias[0] @ u + m * far**2, m, far, g)

    def course(t: Array) -> Array:
        turned, rate = pendulum_motion(t, w, begin, float(rates[0]))
        return np.stack([turned - begin, rate], axis=-1)

    return course


def doubled(link: Chain, rates: Array, t_end: float) -> Callable[[Array], Array]:
    """Return the truth of two links on parallel axes: the double pendulum of the textbooks, angles from the
    vertical."""
    (g, polar), u, (m_1, m_2) = across(link), link.axes[0], link.masses
    (d_1, psi), (d_2, phi_2) = (polar(G - p) for G, p in zip(link.centres, link.points, strict=True))
    l, phi_1 = polar(link.points[1] - link.points[0])
    M_1 = u @ link.inertias[0] @ u + m_1 * d_1**2 + m_2 * l**2
    M_2, c = u @ link.inertias[1] @ u + m_2 * d_2**2, m_2 * l * d_2

    def slope(_: float, y: Array) -> tuple:
        a, b, v, w = y
        apart = phi_1 + a - phi_2 - b
        off, s = c * cos(apart), c * sin(apart)
        one = -s * w * w - g * (m_1 * d_1 * sin(psi + a) + m_2 * l * sin(phi_1 + a))
        two = s * v * v - g * m_2 * d_2 * sin(phi_2 + b)
        below = M_1 * M_2 - off * off
        return v, w, (M_2 * one - off * two) / below, (M_1 * two - off * one) / below

    course = motion(slope, (0.0, 0.0, rates[0], rates[0] + rates[1]), t_end)
    between = np.array([[1.0, 0, 0, 0], [-1.0, 1.0, 0, 0], [0, 0, 1.0, 0], [0, 0, -1.0, 1.0]])
    return lambda t: course(t) @ between.T


def pendulum(place: Place) -> Problem:
    """Draw a body on a hinge in any direction, swinging or turning many times."""
    rng = place.rng
    rate = np.array([float(rng.choice([0.0, rng.normal() * 3.0, rng.choice([-1, 1]) * rng.uniform(10.0, 60.0)]))])
    return problem(place, [direction(place)], [False], rate, float(rng.uniform(0.5, 3.0)), swinging)


def double_pendulum(place: Place) -> Problem:
    """Draw two links on parallel axes."""
    axis, t_end = direction(place), float(place.rng.uniform(0.5, 1.5))
    return problem(place, [axis, axis], [False, False], 3.0 * place.rng.normal(size=2), t_end, doubled)


def arm(place: Place) -> Problem:
    """Draw two or three links on hinges in all directions, with springs and dampers about them."""
    n, rng = int(place.rng.integers(2, 4)), place.rng
    law: dict[str, Any] = {"stiff": float(rng.choice([0.0, 20.0, 300.0])), "drag": float(rng.choice([0.0, 2.0]))}
    axes = [direction(place) for _ in range(n)]
    return problem(place, axes, [False] * n, 4.0 * rng.normal(size=n), float(rng.uniform(0.3, 1.0)), **law)


def crane(place: Place) -> Problem:
    """Draw alternating hinges and slides, held by springs."""
    rng, axes = place.rng, [direction(place) for _ in range(3)]
    slides = [bool(x) for x in rng.permutation([True, False, bool(rng.random() < 0.5)])]
    rates = np.where(slides, place.unit, 1.0) * rng.normal(size=3)
    return problem(
        place, axes, slides, rates, float(rng.uniform(0.3, 1.0)), stiff=50.0, drag=float(rng.choice([0.0, 3.0]))
    )


def chaos(place: Place) -> Problem:
    """Draw a double pendulum of high energy, long enough for errors to grow a thousandfold and more."""
    rng, axis = place.rng, np.cross(direction(place), (0.0, 0.0, 1.0))
    axis /= np.linalg.norm(axis)
    t_end, rates = float(rng.uniform(2.0, 5.0)), rng.uniform(5.0, 8.0, 2)
    return problem(place, [axis, axis], [False, False], rates, t_end, doubled, unsure=True)


FAMILIES = (pendulum, double_pendulum, arm, crane, chaos)
