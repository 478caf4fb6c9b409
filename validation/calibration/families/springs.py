"""Springs, dampers and bushings from soft to stiff, dry friction, a controller with a filter."""

from dataclasses import replace

import numpy as np

from mbsd3d import (
    GROUND,
    Bushing,
    Force,
    JointFriction,
    Prismatic,
    Sine,
    SpringDamper,
    StateFeedback,
    System,
    measures,
)
from validation.calibration.families.rotors import UP, direction, rotor
from validation.calibration.problem import IMPLICIT, Array, Place, Problem, angle, centre, slide
from validation.calibration.rates import motion


def spring(place: Place) -> Problem:
    """Draw a mass on a rail between spring and damper, swinging, under its weight and an alternating force."""
    rng, way = place.rng, direction(place)
    mass, w = float(rng.uniform(0.5, 3.0)), float(np.exp(rng.uniform(0.5, 4.0)))
    zeta, force = float(rng.choice([0.0, 0.05, 0.7])), mass * place.length(0.0, 20.0)
    hertz, speed = float(rng.uniform(0.2, 3.0)), place.length(-2.0, 2.0)
    k, c = mass * w * w, 2.0 * zeta * w * mass
    at = place.unit * rng.normal(size=3)
    body = place.body("mass", mass, place.inertia(mass, place.length(0.1, 0.3)), at, speed * way, np.zeros(3))
    rail = Prismatic(GROUND, body, at=place.point(at), axis=place.axis(way), name="rail")
    # ends so far apart that the spring never turns over
    far = place.unit * (5.0 + 30.0 / w) * 2.0
    damper = SpringDamper(GROUND, body, at_a=place.point(at - far * way), at_b=place.point(at), stiffness=k, damping=c)
    pull = Force(body, [float(x) * Sine(1.0, hertz) for x in force * place.axis(way)])

    def slope(t: float, y: Array) -> tuple:
        load = force * np.sin(2.0 * np.pi * hertz * t) - mass * place.g * way[2]
        return y[1], (load - k * y[0] - c * y[1]) / mass

    t_end = float(rng.uniform(0.5, 3.0)) * min(2.0 * np.pi / w * 4.0, 3.0)
    course = motion(slope, (0.0, speed), t_end)
    readings = [slide("rail", rail, lambda t: course(t)[:, 0])]
    return Problem(System([body], [rail], [damper, pull], gravity=place.gravity), t_end, readings, max(w, 6.3 * hertz))


def stiff_bushing(place: Place) -> Problem:
    """Draw a body on a stiff bushing at its centre of mass under a slow force, which should determine the step."""
    rng = place.rng
    mass, w = float(rng.uniform(0.5, 3.0)), float(np.exp(rng.uniform(5.0, 9.0)))
    zeta, hertz, push = float(rng.uniform(0.02, 0.5)), float(rng.uniform(0.3, 2.0)), place.length(0.1, 0.4)
    way = direction(place)
    k, c = mass * w * w, 2.0 * zeta * w * mass
    force = k * push  # as far as the bushing is pushed
    nu = 2.0 * np.pi * hertz
    # steady motion Re and Im of H exp(i nu t): no fast part is excited
    H = k / (k - mass * nu**2 + 1j * c * nu)
    sag = -mass * place.g / k * UP
    course = lambda t: np.outer(np.imag(push * H * np.exp(1j * nu * t)), way) + sag  # noqa: E731
    # the mount is unloaded at the reference pose, and the motion begins elsewhere
    begin, speed = float(np.imag(push * H)) * way + sag, push * nu * float(np.real(H)) * way
    turning = mass * (0.2 * place.unit * w) ** 2
    block = place.body("block", mass, place.inertia(mass, 0.2 * place.unit), place.unit * rng.normal(size=3))
    mount = Bushing(
        GROUND, block, at=block.centre, stiffness=k, damping=c, turning_stiffness=turning,
        turning_damping=0.1 * turning / w,
    )  # fmt: skip
    loads = [mount, Force(block, [float(x) * Sine(1.0, hertz) for x in force * place.axis(way)])]
    system = System([block], forces=loads, gravity=place.gravity)
    start, home = system.state(), block.centre
    moved = replace(
        start, q=start.q + np.append(place.axis(begin), np.zeros(4)), v=np.append(place.axis(speed), np.zeros(3))
    )
    path = lambda t: home + course(t) @ place.axes.T  # noqa: E731
    readings = [centre(block, path)]
    return Problem(system, float(rng.uniform(0.5, 2.0)), readings, nu, IMPLICIT, start=lambda: moved)


def filtered(place: Place) -> Problem:
    """Draw a wheel with a controller that reads its angle and rate through filters, over a few turns."""
    rng = place.rng
    body, hinge, J = rotor(place, "wheel", np.zeros(3), UP, 0.0, place.length(0.05, 0.2))
    w, zeta, target, tau = float(rng.uniform(3, 20)), float(rng.uniform(0.3, 0.9)), float(rng.uniform(-20, 20)), 0.02
    gains = (J * w * w, 2.0 * zeta * w * J)
    servo = StateFeedback(
        measures=[measures.angle(hinge), measures.rate(hinge)], gains=gains, on=hinge, reference=(target, 0.0),
        time_constant=tau,
    )  # fmt: skip

    def slope(_: float, y: Array) -> tuple:
        load = -gains[0] * (y[2] - target) - gains[1] * y[3]
        return y[1], load / J, (y[0] - y[2]) / tau, (y[1] - y[3]) / tau

    t_end = float(rng.uniform(0.5, 2.0))
    course = motion(slope, (0.0, 0.0, target, 0.0), t_end)
    fast = np.abs(course(np.linspace(0, t_end, 200))[:, 1]).max()
    system = System([body], [hinge], [servo], gravity=place.gravity)
    return Problem(system, t_end, [angle("wheel", hinge, lambda t: course(t)[:, 0])], max(float(fast), 1.0 / tau))


def friction(place: Place) -> Problem:
    """Draw a wheel that slows down by dry and viscous friction in its hinge, and stops."""
    rng = place.rng
    rate = float(rng.uniform(2.0, 60.0))
    body, hinge, J = rotor(place, "wheel", np.zeros(3), UP, rate, place.length(0.05, 0.2))
    t_end, smooth = float(rng.uniform(0.5, 2.0)), float(rng.uniform(0.05, 0.5))
    dry, wet = J * rate * float(rng.uniform(0.3, 1.5)) / t_end, J * float(rng.uniform(0.0, 1.0)) / t_end
    brake = JointFriction(hinge, coulomb=dry, viscous=wet, transition=smooth)
    course = motion(lambda t, y: (y[1], -(dry * np.tanh(y[1] / smooth) + wet * y[1]) / J), (0.0, rate), t_end)
    system = System([body], [hinge], [brake], gravity=place.gravity)
    return Problem(system, t_end, [angle("wheel", hinge, lambda t: course(t)[:, 0])], rate)


FAMILIES = (spring, stiff_bushing, filtered, friction)
