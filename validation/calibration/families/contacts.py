"""Ball that bounces on a spring and damper, tyre with relaxation length, cams with flat faces and rollers."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from mbsd3d import (
    GROUND,
    AngleDriver,
    Contact,
    CurveContact,
    Prismatic,
    Ramp,
    Revolute,
    SlideDriver,
    System,
    Tyre,
    shapes,
)
from validation.calibration.problem import DRIVEN, Array, Place, Problem, angle, centre, slide
from validation.calibration.rates import TRUTH_RTOL, motion


@dataclass(frozen=True)
class End:
    """Event of `scipy.integrate.solve_ivp` that ends a piece: ``value`` of the state passes 0, ``direction`` 1 up."""

    value: Callable[[Array], float]
    direction: float
    terminal: bool = True

    def __call__(self, _: float, y: Array) -> float:
        return self.value(y)


def bounces(slopes: list, ends: list[End], start: Array, t_end: float) -> tuple[list, list]:
    """Return the pieces of a motion with slopes in turn, each up to a zero of its end; (times at which they begin,
    courses).
    """
    courses: list[Callable] = []
    times, t, y = [0.0], 0.0, np.asarray(start, float)
    while t < t_end and len(courses) < 400:
        k = len(courses) % 2
        found = solve_ivp(
            slopes[k],
            (t, t_end),
            y,
            "DOP853",
            rtol=TRUTH_RTOL,
            atol=TRUTH_RTOL * 1e-3,
            events=[ends[k]],
            dense_output=True,
            max_step=0.02,
        )
        courses.append(found.sol)
        t, y = float(found.t[-1]), found.y[:, -1]
        times.append(t)
        if found.status == 0:
            break
    return times, courses


def bounce(place: Place) -> Problem:
    """Draw a ball that drops without rotation on a contact without tension."""
    rng, unit = place.rng, place.unit
    r, mass, high = place.length(0.05, 0.2), float(rng.uniform(0.5, 3.0)), place.length(0.05, 0.5)
    w, zeta = float(np.exp(rng.uniform(4.0, 6.0))), float(rng.choice([0.0, rng.uniform(0.02, 0.4)]))
    k, c, g = mass * w * w, 2.0 * zeta * mass * w, place.g
    along = place.length(-1.0, 1.0)
    at = np.array([0.3, -0.2, 0.0]) * unit + (r + high) * np.array([0.0, 0.0, 1.0])
    ball = place.body("ball", mass, 0.4 * mass * r**2 * np.ones(3), at, (along, 0.0, 0.0), np.zeros(3))
    floor = Contact(
        GROUND,
        ball,
        shapes.Sphere(r, at=ball.com),
        stiffness=k,
        damping=c,
        plane=(place.point(0, 0, 0), place.axis(0, 0, 1)),
    )

    # it lands, or, where it has not left the floor, the damper begins to press again
    lands = End(lambda y: max(y[0], y[0] + c / k * y[1]), -1.0)
    leaves = End(lambda y: k * y[0] + c * y[1], 1.0)
    slopes = [lambda t, y: (y[1], -g), lambda t, y: (y[1], -g - (k * y[0] + c * y[1]) / mass)]
    t_end = float(rng.uniform(0.3, 1.5))
    times, courses = bounces(slopes, [lands, leaves], np.array([high, 0.0]), t_end)

    def height(t: Array) -> Array:
        which = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(courses) - 1)
        return np.array([courses[i](x)[0] for i, x in zip(which, t, strict=True)])

    def path(t: Array) -> Array:
        z = height(t) + r
        return place.shift + np.stack([at[0] + along * t, at[1] + 0.0 * t, z], axis=-1) @ place.axes.T

    system = System([ball], forces=[floor], gravity=place.gravity)
    return Problem(system, t_end, [centre(ball, path)], w)


def tyre(place: Place) -> Problem:
    """Draw a wheel on a carriage of constant speed: its slip decays through the relaxation length of its tyre."""
    rng, unit = place.rng, place.unit
    R, mass, sink = place.length(0.25, 0.4), float(rng.uniform(5.0, 20.0)), place.length(0.003, 0.02)
    h, k, V = R - sink, float(rng.uniform(1e4, 2e5)), place.length(1.0, 10.0)
    C, relax, J = float(rng.uniform(3.0, 15.0)), place.length(0.05, 0.4), 0.5 * mass * R**2
    load, spin = k * sink, V / R * float(rng.uniform(0.7, 1.3))
    ahead, left, up = np.eye(3)
    base, at = np.array([0.3, 0.4, 0.8]) * unit, np.array([0.1, 0.2, 0.0]) * unit + h * up
    sled = place.body("sled", 3.0, place.inertia(3.0, 0.3 * unit), base, V * ahead, np.zeros(3))
    wheel = place.body("wheel", mass, np.diag([0.3, 0.5, 0.3]) * mass * R**2, at, V * ahead, spin * left)
    rail = Prismatic(GROUND, sled, at=place.point(base), axis=place.axis(ahead), name="rail")
    hub = Revolute(sled, wheel, at=place.point(at), axis=place.axis(left), name="hub")
    road = Tyre(
        GROUND, wheel, axis=place.axis(left), radius=R, stiffness=k, cornering=C, relaxation=relax, mu=None,
        plane=(place.point(0, 0, 0), place.axis(up)),
    )  # fmt: skip

    def slope(_: float, y: Array) -> tuple:  # angle, rate, deflection
        slip = V - y[1] * h
        return y[1], -h * load * C * y[2] / J, (-slip - V * y[2]) / relax

    t_end = float(rng.uniform(0.2, 1.0))
    course = motion(slope, (0.0, spin, 0.0), t_end)
    readings = [
        angle("hub", hub, lambda t: course(t)[:, 0]), slide("rail", rail, lambda t: V * t),
    ]  # fmt: skip
    system = System([sled, wheel], [rail, hub, SlideDriver(rail, Ramp(V))], [road], gravity=place.gravity)
    return Problem(system, t_end, readings, max(spin, V / relax, h * np.sqrt(load * C / (J * relax / h))))


def cam(place: Place) -> Problem:
    """Draw a round cam off its shaft that lifts a flat face or a roller, over many turns."""
    rng, unit = place.rng, place.unit
    off, radius, roll = place.length(0.02, 0.06), place.length(0.15, 0.25), place.length(0.05, 0.1)
    begin, t_end = float(rng.uniform(0.0, 6.0)), float(rng.uniform(0.5, 2.0))
    rate = float(np.exp(rng.uniform(0.0, 4.0))) * float(rng.choice([-1.0, 1.0]))
    flat = rng.random() < 0.5
    turn = np.linspace(0.0, 2.0 * np.pi, 180, endpoint=False)
    round_ = np.stack(
        [off * np.cos(begin) + radius * np.cos(turn), off * np.sin(begin) + radius * np.sin(turn), 0 * turn], -1
    )
    reach = radius if flat else radius + roll

    def lift(t: Array) -> Array:
        phi = begin + rate * t
        if flat:
            return off * np.sin(phi) + reach
        return off * np.sin(phi) + np.sqrt(reach**2 - (off * np.cos(phi)) ** 2)

    z0 = float(lift(np.array(0.0)))
    tip = np.array([0.0, z0, 0.0])
    shaft = place.body("cam", 1.5, place.inertia(1.5, 0.1 * unit), (0.01 * unit, 0.02 * unit, 0.0))
    valve = place.body("valve", 0.3, place.inertia(0.3, 0.1 * unit), tip + 0.1 * unit)
    axle = Revolute(GROUND, shaft, at=place.point(0, 0, 0), axis=place.axis(0, 0, 1), name="axle")
    guide = Prismatic(GROUND, valve, at=place.point(tip), axis=place.axis(0, 1, 0), name="guide")
    how = {"face": place.axis(0, 1, 0)} if flat else {"pin": place.axis(0, 0, 1), "radius": roll}
    touch = CurveContact(shaft, valve, np.array([place.point(x) for x in round_]), at=place.point(tip), **how)
    readings = [
        angle("axle", axle, lambda t: rate * t), slide("guide", guide, lambda t: lift(t) - z0),
    ]  # fmt: skip
    system = System([shaft, valve], [axle, guide, touch, AngleDriver(axle, Ramp(rate))], gravity=place.gravity)
    return Problem(system, t_end, readings, abs(rate), DRIVEN)


FAMILIES = (bounce, tyre, cam)
