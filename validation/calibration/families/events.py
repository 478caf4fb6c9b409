"""Runs that stop where a condition comes true, and continue from there."""

from dataclasses import replace

import numpy as np

from mbsd3d import State, System, Torque, measures
from validation.calibration.families.chains import chain, swinging
from validation.calibration.families.rotors import UP, direction, rotor
from validation.calibration.problem import Array, Place, Problem, angle, centre


def stopped_wheel(place: Place) -> Problem:
    """Draw a wheel under a torque, stopped at three angles of many turns, and continued."""
    rng = place.rng
    t_end = float(rng.uniform(0.5, 3.0))
    turned = float(np.exp(rng.uniform(np.log(3.0), np.log(300.0))))
    gain = 2.0 * turned / t_end**2
    body, hinge, J = rotor(place, "wheel", np.zeros(3), UP, 0.0, place.length(0.05, 0.3))
    marks = np.sort(rng.uniform(0.1, 0.95, 3)) * turned
    times = [float(np.sqrt(2.0 * x / gain)) for x in marks]
    stops = [(measures.angle(hinge) > float(x), t, gain * t) for x, t in zip(marks, times, strict=True)]
    system = System([body], [hinge], [Torque(body, place.axis(J * gain * UP))], gravity=place.gravity)
    readings = [angle("wheel", hinge, lambda t: 0.5 * gain * t * t)]
    return Problem(system, t_end, readings, gain * t_end, stops=stops)


def restarted_ball(place: Place) -> Problem:
    """Draw a ball that bounces by an impact law: each run ends on the floor, the next begins with the speed
    reversed."""
    rng, unit = place.rng, place.unit
    mass, high, e, g = float(rng.uniform(0.5, 2.0)), place.length(0.3, 1.0), float(rng.uniform(0.6, 0.9)), place.g
    at = np.array([0.2, 0.3, high])
    ball = place.body(
        "ball", mass, place.inertia(mass, 0.1 * unit), unit * at * (1, 1, 0) + high * UP, np.zeros(3), np.zeros(3)
    )
    up = place.axis(UP)
    floor = float(up @ place.shift)
    count = int(rng.integers(2, 9))
    first = np.sqrt(2.0 * high / g)
    times = [first]
    speeds = [g * first]
    for _ in range(count - 1):
        speeds.append(e * speeds[-1])
        times.append(times[-1] + 2.0 * speeds[-1] / g)
    t_end = times[-1] + e * speeds[-1] / g
    lands = measures.position(ball, axis=up) < floor
    home = ball.centre

    def restart(state: State) -> State:
        v = state.v.copy()
        v[:3] -= (1.0 + e) * (v[:3] @ up) * up
        return replace(state, v=v)

    def path(t: Array) -> Array:
        k = np.searchsorted(times, t, side="right")
        begun = np.append(0.0, times)[k]
        v = np.where(k == 0, 0.0, e * np.append(0.0, speeds)[k])
        z = np.where(k == 0, high, 0.0) + v * (t - begun) - 0.5 * g * (t - begun) ** 2
        return home + np.outer(z - high, up)

    system = System([ball], gravity=place.gravity)
    stops = [(lands, t, v / unit) for t, v in zip(times, speeds, strict=True)]
    return Problem(system, t_end, [centre(ball, path)], 2.0 * np.pi / first, stops=stops, restart=restart)


def stopped_pendulum(place: Place) -> Problem:
    """Draw a pendulum that turns through, stopped at an angle and at a rate, and continued."""
    rng = place.rng
    rate = np.array([float(rng.uniform(12.0, 30.0))])
    link, bodies, joints, _ = chain(place, [direction(place)], [False], rate, 0.0, 0.0)
    t_end = float(rng.uniform(0.5, 2.0))
    course = swinging(link, rate, t_end)
    grid = np.linspace(0.0, t_end, 4001)
    turned = course(grid)[:, 0]
    mark = float(rng.uniform(0.2, 0.9) * turned[-1])
    if np.any(np.diff(turned) <= 0.0):  # it does not turn through
        return stopped_pendulum(place)
    k = int(np.searchsorted(turned, mark))
    low, high = grid[k - 1], grid[k]
    for _ in range(60):
        mid = 0.5 * (low + high)
        low, high = (mid, high) if course(np.array([mid]))[0, 0] < mark else (low, mid)
    readings = [angle("hinge", joints[0], lambda t: course(t)[:, 0])]
    when = 0.5 * (low + high)
    stops = [(measures.angle(joints[0]) > mark, when, float(course(np.array([when]))[0, 1]))]
    system = System(bodies, joints, gravity=place.gravity)
    fast = float(np.abs(course(grid)[:, 1]).max())
    return Problem(system, t_end, readings, fast, stops=stops)


FAMILIES = (stopped_wheel, restarted_ball, stopped_pendulum)
