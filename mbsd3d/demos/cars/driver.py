"""Driver who follows a course: he steers at a point that runs ahead of him on it, and keeps his distance to it.

The point is a body, driven along the course; what the driver sees and does is feedback on the kingpins and the hubs.
"""

from typing import Any

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    Prismatic,
    Ramp,
    Signal,
    SlideDriver,
    SpeedDriver,
    StateFeedback,
    System,
    measures,
    shapes,
)

from .car import WHEELS, Car, G, car
from .linear import HEADING, ROLL, Linear, Y, linear
from .theory import understeer_gradient

STEER_STIFFNESS, STEER_DAMPING = 2e4, 140.0  # N m/rad and N m s/rad of the hands about each kingpin
FOOT_STIFFNESS, FOOT_DAMPING = (
    300.0,
    600.0,
)  # N m/m and N m s/m of the foot on each rear wheel, by the distance to the point


def gain(c: Car, speed: float, preview: float) -> float:
    """Return the gain from lateral distance of the point to steer [rad/m]: the circle through the point, with its slip
    angle.

    2 (L + K v^2)/s^2 for a point s = ``preview`` times v ahead; K is the understeer gradient.
    """
    return 2.0 * (c.wheelbase + understeer_gradient(c) * speed**2) / (preview * speed) ** 2


def followed(c: Car, speed: float, course: Signal, preview: float, lag: float) -> System:
    """Build car, point and driver: the point is ``preview`` [s] ahead, ``course`` [m] to the left; he lags by ``lag``
    [s].
    """
    free, at = car(c, speed, None), np.array([preview * speed, 0.0, c.h])
    moving: dict[str, Any] = {"position": at, "velocity": (speed, 0, 0), "omega": (0, 0, 0)}
    sled = Body("sled", 1.0, (1, 1, 1), shape=shapes.Sphere(0.05), **moving)  # within the point on a straight course
    point = Body("point", 1.0, (1, 1, 1), shape=shapes.Sphere(0.3), **moving)
    road = Prismatic(GROUND, sled, at=at, axis=(1, 0, 0), name="road")
    lanes = Prismatic(sled, point, at=at, axis=(0, 1, 0), name="lanes")
    leads = [SlideDriver(road, Ramp(speed), name="way"), SlideDriver(lanes, course, name="course")]
    joints = [joint for joint in free.joints if not isinstance(joint, SpeedDriver)]  # nothing else holds the steer
    acts = [force for name in WHEELS for force in acts_on(free, name, point, gain(c, speed, preview), lag)]
    bodies = [*free.bodies, sled, point]
    return System(bodies, [*joints, road, lanes, *leads], [*free.forces, *acts], gravity=(0, 0, -G))


def acts_on(free: System, name: str, point: Body, steer: float, lag: float) -> list[StateFeedback]:
    """Return the feedback of the driver at a wheel: at the kingpins in front, at the hubs behind."""
    chassis, far = free.part("chassis"), point.position[0]
    if name.startswith("front"):
        pin = free.part(f"{name} slide", "joints")
        turned, aside = [measures.angle(pin), measures.rate(pin)], [measures.offset(chassis, point, along=(0, 1, 0))]
        return [
            StateFeedback(measures=turned, gains=(STEER_STIFFNESS, STEER_DAMPING), on=pin, name=f"{name} hand"),
            StateFeedback(
                measures=aside, gains=(-STEER_STIFFNESS * steer,), on=pin, time_constant=lag, name=f"{name} eye"
            ),
        ]
    ahead = [measure(chassis, point, along=(1, 0, 0)) for measure in (measures.offset, measures.offset_rate)]
    hub, gains = free.part(f"{name} hub", "joints"), (-FOOT_STIFFNESS, -FOOT_DAMPING)
    return [StateFeedback(measures=ahead, gains=gains, reference=(far, 0.0), on=hub, name=f"{name} foot")]


def closed(c: Car, speed: float, preview: float, lag: float) -> Linear:
    """Return the small motions of car and driver under the course: states of `linear`, steer, its rate, and the
    driver's measures.

    About each kingpin Iw/2 (steer'' + heading'') = hands - Iw v/r roll'.
    """
    A, B = linear(c, speed)
    n, turn, half = len(A), 5 + HEADING, 0.5 * c.Iw
    whole, course = np.zeros((n + 3, n + 3)), np.zeros((n + 3, 3))
    whole[:n, :n], whole[:n, n : n + 2], whole[n, n + 1] = A, B[:, :2], 1.0
    bend = whole[n + 1]
    bend[n:] = np.array([-STEER_STIFFNESS, -STEER_DAMPING, STEER_STIFFNESS * gain(c, speed, preview)]) / half
    bend[: n + 2] -= whole[turn, : n + 2]
    bend[5 + ROLL] -= c.Iw * speed / c.r / half
    bend /= 1.0 + B[turn, 2]
    whole[:n] += np.outer(B[:, 2], bend)
    whole[n + 2, [Y, HEADING, n + 2]] = np.array([-1.0, -preview * speed, -1.0]) / lag
    course[n + 2, 0] = 1.0 / lag
    return Linear(whole, course)
