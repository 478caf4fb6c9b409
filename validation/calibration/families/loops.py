"""Closed loops, most of them with redundant rows: four-bars, Bennett, Sarrus, slider-crank, parallelogram."""

from typing import Any

import numpy as np
from scipy.interpolate import make_interp_spline

from mbsd3d import GROUND, AngleDriver, Prismatic, Ramp, Revolute, System, TorsionSpring
from validation.calibration.families.rotors import direction
from validation.calibration.problem import DRIVEN, Array, Place, Problem, angle, centre, column, scaled, slide
from validation.calibration.rates import motion, turn
from validation.theory import HingeLoop

SPLINE_SAMPLES = 600  # [1] of a motion of some turns; a spline of degree 9 through them errs by 1e-13


def loop(place: Place, points: Array, axes: Array, rate: float, t_end: float) -> Problem:
    """Return a loop of hinges with general links, from the rate of its first hinge; truth along its curve of closed
    poses.
    """
    n, rng = len(points), place.rng
    masses = rng.uniform(0.5, 2.0, n - 1)
    tensors = np.array([place.inertia(m, place.length(0.1, 0.3)) for m in masses])
    ends = points[1:]
    centres = 0.5 * (points[:-1] + ends) + 0.1 * place.unit * rng.normal(size=(n - 1, 3))
    links: list[Any] = [GROUND]
    links += [place.body(f"link {k}", masses[k], tensors[k], centres[k]) for k in range(n - 1)]
    hinges = [
        Revolute(links[k], links[(k + 1) % n], at=place.point(points[k]), axis=place.axis(axes[k]), name=f"hinge {k}")
        for k in range(n)
    ]
    system = System(links[1:], hinges, gravity=place.gravity)
    truth = HingeLoop(points, axes, masses, centres, tensors, np.array([0.0, 0.0, -place.g]))
    grid = np.linspace(0.0, t_end, SPLINE_SAMPLES)
    course = make_interp_spline(grid, truth.motion(rate, grid), k=9)
    size = np.abs(course.derivative()(grid)).max()
    readings = [angle(f"hinge {k}", h, column(k, course)) for k, h in enumerate(hinges)]
    return Problem(
        system, t_end, readings, max(float(size), np.sqrt(9.81)), start=lambda: system.assemble(rates={hinges[0]: rate})
    )


def four_bar(place: Place) -> Problem:
    """Draw four parallel hinges with three redundant rows; Grashof's crank turns through."""
    rng = place.rng
    axis = direction(place)
    u = np.cross(axis, direction(place))
    u /= np.linalg.norm(u)
    w = np.cross(axis, u)
    crank, ground, rod, rocker = place.unit * np.array([0.2, 0.7, 0.6, 0.5]) * rng.uniform(0.95, 1.05, 4)
    begin = float(rng.uniform(0.0, 6.0))
    knee = crank * np.array([np.cos(begin), np.sin(begin)])
    far = np.array([ground, 0.0]) - knee
    d = np.linalg.norm(far)
    along = (rod**2 - rocker**2 + d**2) / (2.0 * d)
    up = np.sqrt(rod**2 - along**2)
    tip = knee + along * far / d + up * np.array([-far[1], far[0]]) / d
    flat = np.array([(0.0, 0.0), knee, tip, (ground, 0.0)])
    points = flat @ np.array([u, w]) + np.outer(0.1 * place.unit * rng.normal(size=4), axis)
    return loop(place, points, np.tile(axis, (4, 1)), float(rng.normal() * 6.0), float(rng.uniform(0.3, 1.0)))


def bennett(place: Place) -> Problem:
    """Draw Bennett's loop of four skew hinges."""
    rng = place.rng
    alpha, beta = float(rng.uniform(0.4, 1.0)), float(rng.uniform(1.2, 1.8))
    a = place.length(0.3, 0.5)
    b = a * np.sin(beta) / np.sin(alpha)
    first = float(rng.uniform(0.6, 2.4))
    second = 2.0 * np.arctan(np.sin(0.5 * (beta + alpha)) / np.sin(0.5 * (beta - alpha)) / np.tan(0.5 * first))
    R, p, points, axes = np.eye(3), np.zeros(3), [], []
    x, z = np.eye(3)[0], np.eye(3)[2]
    for theta, far, twist in ((first, a, alpha), (second, b, beta), (-first, a, alpha), (-second, b, beta)):
        points.append(p)
        axes.append(R @ z)
        R = R @ turn(z, theta)
        p = p + R @ (far * x)
        R = R @ turn(x, twist)
    return loop(place, np.array(points), np.array(axes), float(rng.normal() * 3.0), float(rng.uniform(0.3, 0.8)))


def sarrus(place: Place) -> Problem:
    """Draw Sarrus' loop: three and three parallel hinges move a platform along a straight line; one redundant row."""
    rng, unit = place.rng, place.unit
    between, height = float(rng.uniform(1.0, 2.0)), place.length(0.5, 0.7)
    legs = []
    for heading in (0.0, between):
        out = np.array([np.cos(heading), np.sin(heading), 0.0])
        knee = place.length(0.5, 0.8) * out + place.length(0.2, 0.3) * np.eye(3)[2]
        legs.append(([0.2 * unit * out, knee, 0.2 * unit * out + height * np.eye(3)[2]], np.cross(np.eye(3)[2], out)))
    points = np.array([*legs[0][0], *legs[1][0][::-1]])
    axes = np.array([legs[0][1]] * 3 + [legs[1][1]] * 3)
    return loop(place, points, axes, float(rng.normal() * 2.0), float(rng.uniform(0.1, 0.25)))


def slider_crank(place: Place) -> Problem:
    """Draw a driven slider-crank with hinges, offset, over many turns."""
    rng = place.rng
    r, l, off = place.length(0.1, 0.2), place.length(0.5, 0.8), place.length(-0.1, 0.1)
    rate = float(np.exp(rng.uniform(0.0, 4.0)))
    begin, t_end = float(rng.uniform(0.0, 6.0)), float(rng.uniform(0.5, 2.0))

    def reach(phi: Array) -> Array:
        return r * np.cos(phi) + np.sqrt(l**2 - (r * np.sin(phi) - off) ** 2)

    x0 = reach(np.array(begin))
    pin = r * np.array([np.cos(begin), np.sin(begin), 0.0])
    end, axis = np.array([x0, off, 0.0]), np.array([0.0, 0.0, 1.0])
    parts = []
    for name, near, far in (("crank", np.zeros(3), pin), ("rod", pin, end), ("slider", end, end)):
        mass = float(rng.uniform(0.3, 2.0))
        at = 0.5 * (near + far) + 0.05 * place.unit * rng.normal(size=3)
        parts.append(place.body(name, mass, place.inertia(mass, place.length(0.05, 0.2)), at))
    crank, rod, piston = parts
    main = Revolute(GROUND, crank, at=place.point(0, 0, 0), axis=place.axis(axis), name="main")
    big = Revolute(crank, rod, at=place.point(pin), axis=place.axis(axis), name="big end")
    small = Revolute(rod, piston, at=place.point(end), axis=place.axis(axis), name="small end")
    rail = Prismatic(GROUND, piston, at=place.point(end), axis=place.axis(1, 0, 0), name="rail")
    driver = AngleDriver(main, Ramp(rate), name="motor")
    slope = lambda phi: np.arcsin((off - r * np.sin(phi)) / l)  # noqa: E731  # of the rod
    readings = [
        angle("main", main, lambda t: rate * t),
        slide("rail", rail, lambda t: reach(begin + rate * t) - x0),
        angle("big end", big, lambda t: slope(begin + rate * t) - slope(begin) - rate * t),
    ]
    system = System(parts, [main, big, small, rail, driver], gravity=place.gravity)
    return Problem(system, t_end, readings, rate, DRIVEN)


def parallelogram(place: Place) -> Problem:
    """Draw a parallelogram that swings within half a turn, with a torsion spring at a pin of its coupler."""
    rng, unit = place.rng, place.unit
    long, wide = place.length(0.3, 0.6), place.length(0.5, 0.9)
    stiff = float(rng.uniform(0.0, 5.0)) * unit**2
    begin = float(rng.uniform(0.8, 1.2))  # of the cranks from the line of the ground hinges, in the plane x, z
    leg = long * np.array([np.cos(begin), 0.0, -np.sin(begin)])
    far, axis = np.array([wide, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])  # + turns z to x: the angle of leg grows
    masses = rng.uniform(0.5, 2.0, 3)
    tensors = [place.inertia(m, 0.1 * unit) for m in masses]
    shares = [0.4 * leg, 0.6 * leg + far, 0.5 * far + leg + 0.1 * unit * axis]
    a, b, coupler = (place.body(x, m, I, c) for x, m, I, c in zip("abc", masses, tensors, shares, strict=True))
    joints = [
        Revolute(GROUND, a, at=place.point(0, 0, 0), axis=place.axis(axis), name="left"),
        Revolute(GROUND, b, at=place.point(far), axis=place.axis(axis), name="right"),
        Revolute(a, coupler, at=place.point(leg), axis=place.axis(axis), name="pin"),
        Revolute(b, coupler, at=place.point(far + leg), axis=place.axis(axis), name="other pin"),
    ]
    J = sum(I[1, 1] + m * s**2 for I, m, s in zip(tensors, masses, (0.4 * long, 0.6 * long, 0.0), strict=True))
    J += masses[2] * long**2 - tensors[2][1, 1]  # the coupler does not turn
    weight = place.g * long * (0.4 * masses[0] + 0.6 * masses[1] + masses[2])
    rate, t_end = float(rng.normal()), float(rng.uniform(0.3, 0.8))

    def slope(_: float, y: Array) -> tuple:  # heights are -s sin(begin + angle)
        return y[1], (weight * np.cos(begin + y[0]) - stiff * y[0]) / J

    course = motion(slope, (0.0, rate), t_end)
    turns, sense = column(0, course), {"left": 1.0, "right": 1.0, "pin": -1.0, "other pin": -1.0}
    readings = [angle(name, j, scaled(s, turns)) for (name, s), j in zip(sense.items(), joints, strict=True)]
    start = place.point(shares[2])

    def path(t: Array) -> Array:
        phi = begin + course(t)[:, 0]
        moved = long * np.stack([np.cos(phi), 0.0 * phi, -np.sin(phi)], axis=-1) - leg
        return start + moved @ place.axes.T

    readings.append(centre(coupler, path))
    system = System([a, b, coupler], joints, [TorsionSpring(joints[2], stiffness=stiff)], gravity=place.gravity)
    fast = np.abs(course(np.linspace(0.0, t_end, 100))[:, 1]).max()
    return Problem(
        system,
        t_end,
        readings,
        max(float(fast), np.sqrt(weight / J)),
        start=lambda: system.assemble(rates={joints[0]: rate}),
    )


FAMILIES = (four_bar, bennett, sarrus, slider_crank, parallelogram)
