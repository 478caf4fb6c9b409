"""Rolling without slip: a ball on a slope, a disc on a circle."""

import numpy as np

from mbsd3d import GROUND, Rolling, RollingDisc, System, shapes
from validation.calibration.families.free import turned
from validation.calibration.families.rotors import direction
from validation.calibration.problem import Array, Place, Problem, attitude, centre
from validation.calibration.rates import motion, skew, turn
from validation.theory import rolling_circle


def ball(place: Place) -> Problem:
    """Draw a ball that rolls on a slope and spins about its normal."""
    rng = place.rng
    n = np.array([0.3, -0.2, 1.0]) * rng.uniform(0.5, 1.5, 3)
    n /= np.linalg.norm(n)
    r, mass = place.length(0.05, 0.3), float(rng.uniform(0.5, 3.0))
    J = 0.4 * float(rng.uniform(0.7, 1.5)) * mass * r**2
    omega = float(np.exp(rng.uniform(0.0, 3.5))) * direction(place)
    velocity = r * np.cross(omega, n)
    weight = np.array([0.0, 0.0, -place.g])
    gain = (weight - weight @ n * n) / (1.0 + J / (mass * r**2))
    alpha = np.cross(n, gain) / r
    t_end = float(rng.uniform(0.3, 1.2))
    at = 0.4 * place.unit * rng.normal(size=3) + r * n
    body = place.body("ball", mass, J * np.ones(3), at, velocity, omega)
    ground = (place.point(at - r * n + 0.3 * place.unit * np.cross(n, gain / place.g)), place.axis(n))
    contact = Rolling(GROUND, body, shapes.Sphere(r, at=body.com), plane=ground)

    def slope(t: float, y: Array) -> Array:
        return (skew(omega + alpha * t) @ y.reshape(3, 3)).ravel()

    course = motion(slope, np.eye(3).ravel(), t_end)
    start = body.centre

    def path(t: Array) -> Array:
        return start + (np.outer(t, velocity) + 0.5 * np.outer(t * t, gain)) @ place.axes.T

    readings = [
        centre(body, path), attitude(body, lambda t: turned(place, course(t).reshape(-1, 3, 3))),
    ]  # fmt: skip
    rate = np.linalg.norm(omega) + np.linalg.norm(alpha) * t_end
    return Problem(System([body], [contact], gravity=place.gravity), t_end, readings, float(rate))


def disc(place: Place) -> Problem:
    """Draw a disc that rolls on a circle, leaning inwards, for up to three rounds."""
    rng = place.rng
    r, lean = place.length(0.2, 0.5), float(rng.uniform(0.1, 0.6))
    mass, circle = float(rng.uniform(0.5, 3.0)), r * float(rng.uniform(2.0, 6.0))
    C = float(rng.uniform(0.5, 0.95)) * mass * r**2
    A = 0.5 * C + 0.05 * mass * r**2
    steady = rolling_circle(mass, r, A, C, circle, lean, place.g)
    W, spin, rho = steady.precession, steady.spin, steady.centre_radius
    heading = float(rng.uniform(0.0, 6.0))
    out = np.array([np.cos(heading), np.sin(heading), 0.0])
    up = np.array([0.0, 0.0, 1.0])
    axle, at = np.cos(lean) * out + np.sin(lean) * up, rho * out + steady.centre_height * up
    tensor = A * np.eye(3) + (C - A) * np.outer(axle, axle)
    body = place.body("disc", mass, tensor, at, W * rho * np.cross(up, out), W * up + spin * axle)
    ground = (place.point(0, 0, 0), place.axis(up))
    contact = RollingDisc(GROUND, body, axis=place.axis(axle), radius=r, plane=ground)

    def pose(t: Array) -> Array:
        return turned(place, np.array([turn(up, W * x) @ turn(axle, spin * x) for x in t]))

    def path(t: Array) -> Array:
        return place.shift + np.array([turn(up, W * x) @ at for x in t]) @ place.axes.T

    t_end = float(rng.uniform(0.2, 3.0)) * steady.period
    system = System([body], [contact], gravity=place.gravity)
    return Problem(system, t_end, [centre(body, path), attitude(body, pose)], abs(spin) + W)


FAMILIES = (ball, disc)
