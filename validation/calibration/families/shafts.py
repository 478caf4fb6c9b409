"""Shafts at an angle: one universal joint, two of them, a constant-velocity joint; coasting, pulled or driven."""

import numpy as np

from mbsd3d import GROUND, AngleDriver, ConstantVelocity, Ramp, Revolute, SpeedDriver, System, Torque, Universal
from validation.calibration.families.rotors import Turning, direction, turning
from validation.calibration.problem import DRIVEN, METHODS, Array, Place, Problem, angle
from validation.calibration.rates import motion


def at_reference(place: Place) -> Turning:
    """Draw a rotation that begins at the reference pose."""
    turn = turning(place)
    place.moving = True
    return turn._replace(begin=0.0)


def passed_on(angle_in: Array, bend: float) -> Array:
    """Return the output angle of tan out = cos(bend) tan in, counted over turns; zero where the arm of the input is
    across the plane of both.
    """
    s, c = np.sin(angle_in), np.cos(angle_in)
    return angle_in + np.arctan2((np.cos(bend) - 1.0) * s * c, c * c + np.cos(bend) * s * s)


def ratio(angle_in: float, bend: float) -> tuple[float, float]:
    """Return (d out / d in, its derivative)."""
    s, c, b = np.sin(angle_in), np.cos(angle_in), np.cos(bend)
    below = c * c + b * b * s * s
    return b / below, 2.0 * b * (1.0 - b * b) * s * c / below**2


def shaft(place: Place, name: str, axis: Array, at: Array, rate: float) -> tuple:
    """Return (body, hinge, moment of inertia): the centre of mass on the axis."""
    mass = float(place.rng.uniform(0.5, 3.0))
    tensor = place.inertia(mass, place.length(0.05, 0.3))
    body = place.body(name, mass, tensor, at, np.zeros(3), rate * axis)
    return (
        body,
        Revolute(GROUND, body, at=place.point(at), axis=place.axis(axis), name=f"{name} hinge"),
        axis @ tensor @ axis,
    )


def bent(place: Place, most: float) -> tuple[Array, Array, Array, float]:
    """Return (axis of the input, of the output, common normal, angle between them)."""
    a, bend = direction(place), float(place.rng.uniform(0.1, most))
    n = np.cross(a, direction(place))
    n /= np.linalg.norm(n)
    return a, np.cos(bend) * a + np.sin(bend) * np.cross(n, a), n, bend


def cardan(place: Place) -> Problem:
    """Draw two shafts with a universal joint, coasting or pulled: three redundant rows, an uneven output."""
    rate, gain, t_end, _ = at_reference(place)
    bodies, joints, (J_a, J_b), bend, begin = crossed(place, rate)
    start = passed_on(np.array(begin), bend)
    pull = gain * (J_a + J_b)

    def slope(_: float, y: Array) -> tuple:
        s, change = ratio(begin + y[0], bend)
        return y[1], (pull - J_b * s * change * y[1] ** 2) / (J_a + J_b * s * s)

    turned = motion(slope, (0.0, rate), t_end)
    readings = [
        angle("input", joints[0], lambda t: turned(t)[:, 0]),
        angle("output", joints[1], lambda t: passed_on(begin + turned(t)[:, 0], bend) - start),
    ]
    most = np.abs(turned(np.linspace(0.0, t_end, 200))[:, 1]).max() / np.cos(bend)
    system = System(bodies, joints, [Torque(bodies[0], pull * joints[0].axis)], gravity=place.gravity)
    return Problem(system, t_end, readings, max(most, 1.0))


def driven_cardan(place: Place) -> Problem:
    """Draw the same shafts, the input driven at a constant rate by its angle or by its speed."""
    t_end = float(place.rng.uniform(0.5, 3.0))
    rate = float(np.exp(place.rng.uniform(np.log(3.0), np.log(300.0)))) / t_end
    bodies, joints, _, bend, begin = crossed(place, rate)
    start, by_speed = passed_on(np.array(begin), bend), place.rng.random() < 0.5
    driver = SpeedDriver(joints[0], rate) if by_speed else AngleDriver(joints[0], Ramp(rate))
    readings = [
        angle("input", joints[0], lambda t: rate * t),
        angle("output", joints[1], lambda t: passed_on(begin + rate * t, bend) - start),
    ]
    system = System(bodies, [*joints, driver], gravity=place.gravity)
    return Problem(system, t_end, readings, rate / np.cos(bend), METHODS if by_speed else DRIVEN)


def crossed(place: Place, rate: float) -> tuple:
    """Return (bodies, joints, moments of inertia, angle between the shafts, angle of the input at the start)."""
    a, b, n, bend = bent(place, 1.1)
    begin = float(place.rng.uniform(-3.0, 3.0))
    one, hinge, J_a = shaft(place, "input", a, -0.5 * place.unit * a, rate)
    two, other, J_b = shaft(place, "output", b, 0.4 * place.unit * b, rate * ratio(begin, bend)[0])
    arm = np.cos(begin) * n + np.sin(begin) * np.cross(a, n)
    arm_b = np.cross(b, arm)
    cross = Universal(
        one, two, at=place.point(0, 0, 0), axis_a=place.axis(arm),
        axis_b=place.axis(arm_b / np.linalg.norm(arm_b)), name="cross",
    )  # fmt: skip
    return [one, two], [hinge, other, cross], (J_a, J_b), bend, begin


def constant_velocity(place: Place) -> Problem:
    """Draw two shafts with a constant-velocity joint."""
    turn = at_reference(place)
    rate, gain, course = turn.rate, turn.gain, turn.course
    a, b, n, bend = bent(place, 0.8)
    one, hinge, J_a = shaft(place, "input", a, -0.5 * place.unit * a, rate)
    two, other, J_b = shaft(place, "output", b, 0.4 * place.unit * b, rate)
    joint = ConstantVelocity(one, two, at=place.point(0, 0, 0), axis_a=place.axis(a), axis_b=place.axis(b))
    drive = Torque(one, gain * (J_a + J_b) * hinge.axis)
    system = System([one, two], [hinge, other, joint], [drive], gravity=place.gravity)
    readings = [angle("input", hinge, course), angle("output", other, course)]
    return Problem(system, turn.t_end, readings, turn.fastest)


def two_cardans(place: Place) -> Problem:
    """Draw two universal joints in phase, the middle shaft carried by them alone: input and output turn alike."""
    rate, gain, t_end, _ = at_reference(place)
    a, m, n, bend = bent(place, 0.7)
    begin, long = float(place.rng.uniform(-3.0, 3.0)), place.length(0.4, 0.8)
    first = ratio(begin, bend)[0]
    one, hinge, J_a = shaft(place, "input", a, -0.5 * place.unit * a, rate)
    mass, J_m = 0.7, place.length(0.05, 0.2) ** 2
    middle = place.body("middle", mass, J_m * np.eye(3), 0.5 * long * m, np.zeros(3), rate * first * m)
    two, other, J_b = shaft(place, "output", a, long * m + 0.4 * place.unit * a, rate)
    arm = np.cos(begin) * n + np.sin(begin) * np.cross(a, n)
    arm_m = np.cross(m, arm)
    crosses = [
        Universal(one, middle, at=place.point(0, 0, 0), axis_a=place.axis(arm), axis_b=place.axis(arm_m)),
        Universal(middle, two, at=place.point(long * m), axis_a=place.axis(arm_m), axis_b=place.axis(arm)),
    ]
    J = J_a + J_b

    def slope(_: float, y: Array) -> tuple:
        s, change = ratio(begin + y[0], bend)
        return y[1], (gain * J - J_m * s * change * y[1] ** 2) / (J + J_m * s * s)

    turned = motion(slope, (0.0, rate), t_end)
    system = System(
        [one, middle, two], [hinge, other, *crosses], [Torque(one, gain * J * hinge.axis)], gravity=place.gravity
    )
    readings = [angle(x.name, x, lambda t: turned(t)[:, 0]) for x in (hinge, other)]
    most = np.abs(turned(np.linspace(0.0, t_end, 200))[:, 1]).max() / np.cos(bend)
    return Problem(system, t_end, readings, most)


FAMILIES = (cardan, driven_cardan, constant_velocity, two_cardans)
