"""Bodies without joints or on one ball joint: tumbling flight, heavy tops, an orbit."""

import numpy as np

from mbsd3d import GROUND, CentralGravity, Spherical, System
from validation.calibration.problem import Array, Place, Problem, attitude, centre
from validation.theory import free_body, spinning_body

IDENTITY_QUATERNION = (1.0, 0.0, 0.0, 0.0)


def turned(place: Place, rotation: Array) -> Array:
    """Return rotations of the frame in world axes, shape (n, 3, 3)."""
    return place.axes @ rotation.astype(float) @ place.axes.T


def free(place: Place) -> Problem:
    """Draw a body that tumbles and flies, seen by an observer at rest or a fast one."""
    rng = place.rng
    mass = float(rng.uniform(0.5, 3.0))
    moments = np.linalg.eigvalsh(place.inertia(mass, place.length(0.2, 0.6)))[rng.permutation(3)]
    omega = rng.normal(size=3) * float(np.exp(rng.uniform(0.0, 3.5)))
    boost = place.unit * float(rng.choice([0.0, 1.0, 100.0, 1e4])) * rng.normal(size=3)
    t_end = float(rng.uniform(0.5, 2.0))
    body = place.body("body", mass, moments, place.unit * rng.normal(size=3), boost, omega)
    at = body.centre

    def path(t: Array) -> Array:
        return at + np.outer(t, place.axis(boost)) + 0.5 * np.outer(t * t, place.gravity)

    def pose(t: Array) -> Array:
        return turned(place, free_body(t, moments, omega, IDENTITY_QUATERNION).rotation)

    rate = float(np.linalg.norm(omega))
    readings = [centre(body, path), attitude(body, pose)]
    return Problem(System([body], gravity=place.gravity), t_end, readings, rate)


def top(place: Place) -> Problem:
    """Draw a top of any inertia on a ball joint, slow or fast."""
    rng = place.rng
    mass, arm = float(rng.uniform(0.5, 3.0)), place.length(0.1, 0.5) * (0.3 * rng.normal(size=3) + (0, 0, 1.0))
    tensor = place.inertia(mass, place.length(0.1, 0.3))
    spin = float(np.exp(rng.uniform(0.0, 4.0)))
    omega = spin * np.array([0.1, -0.05, 1.0]) + rng.normal(size=3)
    t_end = float(rng.uniform(0.3, 1.2))
    body = place.body("top", mass, tensor, arm, np.cross(omega, arm), omega)
    tip = Spherical(GROUND, body, at=place.point(0, 0, 0), name="tip")
    about = tensor + mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))

    def pose(t: Array) -> Array:
        return turned(place, spinning_body(t, about, omega, IDENTITY_QUATERNION, mass * place.g * arm).rotation)

    def path(t: Array) -> Array:
        return place.shift + pose(t) @ place.axis(arm)

    readings = [attitude(body, pose), centre(body, path)]
    rate = float(np.linalg.norm(omega)) + np.sqrt(place.g / np.linalg.norm(arm))
    return Problem(System([body], [tip], gravity=place.gravity), t_end, readings, rate)


def orbit(place: Place) -> Problem:
    """Draw a Kepler orbit of up to eight rounds, of a satellite with the inertia of a ball: no moment turns it."""
    rng = place.rng
    axis, excentric, rate = place.length(1.0, 3.0), float(rng.uniform(0.05, 0.6)), float(rng.uniform(1.0, 5.0))
    rounds, phase, mass = float(rng.uniform(0.5, 8.0)), float(rng.uniform(0.0, 6.0)), float(rng.uniform(0.5, 3.0))
    wide = np.sqrt(1.0 - excentric**2)

    def anomaly(mean: Array) -> Array:
        E = mean + excentric * np.sin(mean)
        for _ in range(30):
            E = E - (E - excentric * np.sin(E) - mean) / (1.0 - excentric * np.cos(E))
        return E

    def place_of(E: Array) -> Array:
        return axis * np.stack([np.cos(E) - excentric, wide * np.sin(E), 0.0 * E], axis=-1)

    E = anomaly(np.array(phase))
    speed = rate / (1.0 - excentric * np.cos(E)) * axis * np.array([-np.sin(E), wide * np.cos(E), 0.0])
    omega = rng.normal(size=3)
    moon = place.body(
        "moon", mass, 0.1 * mass * place.unit**2 * np.ones(3), place_of(E), speed, omega, 0.05 * place.unit
    )
    pull = CentralGravity(GROUND, moon, at=place.point(0, 0, 0), mu=rate**2 * axis**3)
    path = lambda t: place.shift + place_of(anomaly(phase + rate * t)) @ place.axes.T  # noqa: E731
    system = System([moon], forces=[pull], gravity=(0, 0, 0))
    nearest = rate * (1.0 + excentric) ** 0.5 / (1.0 - excentric) ** 1.5
    return Problem(
        system, 2.0 * np.pi * rounds / rate, [centre(moon, path)], max(nearest, float(np.linalg.norm(omega)))
    )


FAMILIES = (free, top, orbit)
