"""Problem of the calibration: a mechanism in general position, and its true motion."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.random import Generator

from mbsd3d import Body, Solution, State, System
from validation.cases.examples import random_orientation
from validation.theory import rotation_matrix

Array = np.ndarray

EXPLICIT = ("DOP853", "RK4", "DOP853(dt)")
IMPLICIT = ("GeneralizedAlpha", "RadauIIA", "GeneralizedAlpha(dt)", "RadauIIA(dt)")
METHODS = EXPLICIT + IMPLICIT
DRIVEN = (*METHODS, "Kinematic", "Kinematic")  # as often as any two others


@dataclass(frozen=True, eq=False)
class Reading:
    """Quantity of a run with its true course.

    ``computed``: of a solution, (samples,) or (samples, k); ``truth``: the same of the times of the samples;
    ``scale``: what an error is divided by, 1 rad of an angle; None = the length of the model.
    """

    name: str
    computed: Callable[[Solution], Array]
    truth: Callable[[Array], Array]
    scale: float | None = 1.0


@dataclass(frozen=True, eq=False)
class Problem:
    """Mechanism, its runs, and its truth.

    ``rate``: of its fastest motion [rad/s], from which fixed steps are chosen; ``methods``: those that make sense;
    ``stops``: conditions with the true times [s] at which they come true and the rates [rad/s] of the motion there, by
    which a late stop is judged; each run restarts there by ``restart``;
    ``unsure``: a run may well be refused, for chaos or for a force that jumps unannounced; ``start``: makes the
    first state; None = as the bodies give.
    """

    system: System
    t_end: float
    readings: Sequence[Reading]
    rate: float
    methods: tuple[str, ...] = METHODS
    stops: Sequence[tuple[Any, float, float]] = ()
    restart: Callable[[State], State] = lambda state: state
    unsure: bool = False
    start: Callable[[], State | None] = lambda: None


class Place:
    """Random position of a mechanism: rotated, shifted, in metres or millimetres.

    Families are written in a frame of their own, z up, with lengths in multiples of ``unit``.
    """

    def __init__(self, rng: Generator) -> None:
        self.rng = rng
        self.unit = float(rng.choice([1.0, 1000.0]))
        self.axes = rotation_matrix(random_orientation(rng)).astype(float)
        self.shift = self.unit * float(rng.choice([0.3, 3.0, 30.0])) * rng.normal(size=3)
        self.g = 9.81 * self.unit
        self.moving = True  # whether bodies are given velocities: those of the reference pose

    @property
    def gravity(self) -> Array:
        """Return the gravity of the earth in world axes."""
        return self.axes @ (0.0, 0.0, -self.g)

    def point(self, *x: float | Array) -> Array:
        """Return a point of the frame in world coordinates."""
        return self.shift + self.axes @ np.hstack(x)

    def axis(self, *x: float | Array) -> Array:
        """Return a direction or vector of the frame in world axes."""
        return self.axes @ np.hstack(x)

    def length(self, low: float, high: float) -> float:
        """Draw a length [unit]."""
        return self.unit * float(self.rng.uniform(low, high))

    def inertia(self, mass: float, size: float) -> Array:
        """Draw the inertia of six equal masses at random points of this size, shape (3, 3)."""
        points = size * self.rng.normal(size=(6, 3))
        points -= points.mean(axis=0)
        return mass / 6.0 * sum((x @ x) * np.eye(3) - np.outer(x, x) for x in points)

    def body(
        self, name: str, mass: float, inertia: Any, centre: Any,
        velocity: Any = None, omega: Any = None, size: float | None = None,
    ) -> Body:  # fmt: skip
        """Return a body with its centre of mass at ``centre``, its reference point and axes anywhere.

        ``inertia`` (3,) or (3, 3) about the centre, ``velocity`` of the centre and ``omega``: axes of the frame.
        """
        inertia = np.asarray(inertia, float)
        inertia = np.diag(inertia) if inertia.ndim == 1 else inertia
        orientation = random_orientation(self.rng)
        R = rotation_matrix(orientation).astype(float)
        com = (size or 0.3 * self.unit) * self.rng.normal(size=3)
        turned = R.T @ self.axes
        moments = turned @ inertia @ turned.T
        motion: dict[str, Array] = {}
        if omega is not None and self.moving:
            w = self.axis(omega)
            motion = {
                "omega": w,
                "velocity": self.axis(np.zeros(3) if velocity is None else velocity) - np.cross(w, R @ com),
            }
        return Body(
            name, mass, 0.5 * (moments + moments.T), com=com, position=self.point(centre) - R @ com,
            orientation=orientation, **motion,
        )  # fmt: skip


def column(k: int, course: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """Return one of the columns of a course (n, columns)."""
    return lambda t: course(t)[:, k]


def scaled(factor: float, course: Callable[[Array], Array]) -> Callable[[Array], Array]:
    """Return a course times a factor."""
    return lambda t: factor * course(t)


def angle(name: str, joint: Any, truth: Callable[[Array], Array]) -> Reading:
    """Return the reading of the angle of a hinge, counted over all turns [rad]."""
    return Reading(name, lambda run: run.angle(joint), truth)


def slide(name: str, joint: Any, truth: Callable[[Array], Array]) -> Reading:
    """Return the reading of the displacement of a joint."""
    return Reading(name, lambda run: run.slide(joint), truth, None)


def centre(body: Any, truth: Callable[[Array], Array]) -> Reading:
    """Return the reading of the centre of mass of a body, world."""
    return Reading(f"centre of {body.name}", lambda run: run.com(body), truth, None)


def attitude(body: Any, truth: Callable[[Array], Array]) -> Reading:
    """Return the reading of the rotation of a body since the start: truth (n, 3, 3), from the reference pose to now,
    world [rad].
    """

    def computed(run: Solution) -> Array:
        return (run.rotation(body) @ body.axes.T).reshape(-1, 9)

    # |R - R'| = 2 sqrt(2) sin(angle / 2)
    return Reading(f"attitude of {body.name}", computed, lambda t: truth(t).reshape(-1, 9), float(np.sqrt(2.0)))
