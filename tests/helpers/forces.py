"""An example of every force element, with forces of some newtons, between two bodies or one and the ground."""

from dataclasses import replace

import numpy as np

from helpers.models import (
    direction,
    middle,
    random_orientation,
    signal,
)
from mbsd3d import (
    AeroDrag,
    Backlash,
    Belt,
    Brake,
    Bushing,
    CentralGravity,
    Clutch,
    ConeStop,
    Contact,
    CustomForce,
    Cylindrical,
    DryFriction,
    EndStop,
    FluidDrag,
    Force,
    ForceBetween,
    ForceCurve,
    Freewheel,
    Gear,
    JointFriction,
    LinearActuator,
    PinPlay,
    PointStop,
    Polynomial,
    Prismatic,
    Pulley,
    Ratchet,
    Revolute,
    Rope,
    RotationSpring,
    RotationStop,
    Spherical,
    SpringDamper,
    StateFeedback,
    SumSpring,
    SumStop,
    Torque,
    TorqueBetween,
    TorqueCurve,
    TorsionSpring,
    Tyre,
    Weight,
    Winch,
    measures,
    rotation,
    shapes,
)


def _hinge(rng, a, b):
    return Revolute(a, b, at=middle(rng, a, b), axis=direction(rng))


def _slider(rng, a, b):
    return Prismatic(a, b, at=middle(rng, a, b), axis=direction(rng))


def _summed(rng, a, b, kind=SumSpring, **rest):
    guide = Cylindrical(a, b, at=middle(rng, a, b), axis=direction(rng))
    sums = dict(weights=(0.9, -0.6), of=("angle", "slide"))
    return [guide], kind((guide, guide), **sums, stiffness=3.0, damping=0.7, **rest)


def _signals(rng):
    return (signal(rng, 0.5), Polynomial((0.3, -0.8, 1.1)), -0.7)


def _spring(rng, a, b):
    ends = dict(at_a=a.position + 0.3 * direction(rng), at_b=b.position + 0.3 * direction(rng))
    return SpringDamper(a, b, **ends, stiffness=7.0, damping=0.9, length=0.8)


def _bushing(rng, a, b):
    numbers = dict(
        stiffness=(5.0, 7.0, 3.0), turning_stiffness=(2.0, 1.3, 4.0), damping=(0.4, 0.7, 0.2),
        turning_damping=(0.3, 0.6, 0.5),
    )  # fmt: skip
    return Bushing(a, b, at=middle(rng, a, b), axes=random_orientation(rng), **numbers)


def _seen(joint):
    seen = [measures.angle(joint), measures.rate(joint)]
    return [joint], StateFeedback(measures=seen, gains=(2.0, 0.7), on=joint, reference=(0.4, -0.3))


def _rubber_band(t, bodies, z, parameters, loads, z_dot):
    """Progressive spring and damper along the line between two points, stiffening with time.

    Number by number, which compiles six times as fast as arrays; tests/mechanism/test_custom.py has both ways.
    """
    square, along = 0.0, 0.0
    for k in range(3):
        gap = bodies[1].r[k] - bodies[0].r[k]
        square += gap * gap
        along += gap * (bodies[1].velocity[k] - bodies[0].velocity[k])
    length = np.sqrt(square)
    pull = parameters[0] * (1.0 + t) * square + parameters[1] * along / length
    for k in range(3):
        loads[0, k] = pull / length * (bodies[1].r[k] - bodies[0].r[k])
        loads[0, 3 + k] = parameters[2] * (bodies[1].w[k] - bodies[0].w[k])
        loads[1, k], loads[1, 3 + k] = -loads[0, k], -loads[0, 3 + k]


def _custom(rng, a, b):
    points = (middle(rng, a, b), b.position + 0.3 * direction(rng))
    return CustomForce(_rubber_band, on=(a, b), points=points, parameters=(3.0, 0.8, 0.4))


def _contact(rng, a, b, surface, **numbers):
    """Pressed into a plane of a, with states that the numbers below set: no pose leaves it."""
    normal = direction(rng)
    plane = (b.position + 3.0 * normal + direction(rng), normal)
    return [], Contact(a, b, surface, plane=plane, stiffness=0.8, **numbers)


def _round_contact(rng, a, b, half=0.0, **numbers):
    """A sphere pressed into a sphere of a, or into the side of a capsule of this half length."""
    n, axis = direction(rng), direction(rng)
    side = np.cross(n, axis) / np.linalg.norm(np.cross(n, axis))
    at = a.local_point(b.position + 4.0 * side + 0.1 * half * axis)
    other = shapes.Capsule(8.0, 2.0 * half, a.local_axis(axis), at=at) if half else shapes.Sphere(8.0, at=at)
    return [], Contact(a, b, shapes.Sphere(0.6, at=(0.1, -0.2, 0.1)), other=other, stiffness=0.15, **numbers)


STONE = dict(at=(0.1, -0.2, 0.15), orientation=rotation((1, 2, -1), 0.8))

LINING = dict(stiffness=1.7, damping=6.0)

STICKS = dict(
    exponent=1.5, damping=0.02, loss=0.01, friction=3.0, rolling=2.0, spinning=1.5, grip=1.2, grip_damping=0.3
)

SLIPS = dict(damping=0.02, friction=0.05, rolling=0.02, spinning=0.01, grip=1.2, grip_damping=0.3)

CREEPS = dict(loss=0.02, friction=0.4, rolling=0.3, spinning=0.2, creep=0.5)


def _on(joint, cls, **numbers):
    return [joint], cls(joint, **numbers)


def _tyre(rng, a, b, **given):
    """So large a tube that the general poses press it."""
    numbers = dict(radius=3.0, crown=2.4, stiffness=4.0, damping=0.1, trail=0.3, twisting=0.2, rolling_resistance=0.1)
    more = dict(cornering=1.3, longitudinal=1.7, camber=0.8, mu=0.7, standing_damping=0.4, standing_speed=2.0)
    more |= dict(relaxation=0.5, relaxation_x=0.3, nominal_load=6.0, grip_sensitivity=0.1, stiffness_sensitivity=0.2)
    more |= given
    plane = (b.position - np.array([0.3, 0.2, 1.1]), np.array([0.2, -0.1, 1.0]))
    return Tyre(a, b, axis=(0.3, 1.0, -0.2), plane=plane, centre=b.position + 0.2 * direction(rng), **numbers, **more)


PRESSED = dict(mu=0.3, preload=9.0)
STOP = dict(stiffness=3.0, damping=0.4)
BENT = [(-9.0, 4.0), (-1.0, 2.5), (0.3, 0.7), (1.5, -0.9), (4.0, -1.7), (9.0, -6.0)]


def _cone(rng, a, b, **limits):
    """A narrow cone that general poses leave, about axes that stand apart as built."""
    ball, axis = Spherical(a, b, at=middle(rng, a, b)), direction(rng)
    return [ball], ConeStop(ball, axis_a=axis, axis_b=axis + 0.2 * direction(rng), **limits, **STOP)


def _turned(rng, a, b, **limits):
    ball = Spherical(a, b, at=middle(rng, a, b))
    return [ball], RotationStop(ball, **limits, **STOP)


def _teeth(rng, a, b):
    """Flanks that general poses press, between two hinges on one axis."""
    on = dict(at=middle(rng, a, b), axis=direction(rng))
    hinges = [Revolute(a, b, **on), Cylindrical(a, b, **on)]
    return hinges, Backlash(Gear(*hinges, ratio=-1.7), angle=0.01, **STOP)


def _table(rng, a, b, **choice):
    ends = dict(at_a=a.position + 0.3 * direction(rng), at_b=b.position + 0.3 * direction(rng))
    return [], ForceCurve(a, b, **ends, points=BENT, length=0.8, **choice)


def _actuator(rng, a, b, thrust, stroke):
    ends = dict(at_a=a.position + 0.3 * direction(rng), at_b=b.position + 0.3 * direction(rng))
    return [], LinearActuator(a, b, **ends, thrust=thrust, rate=9.0, stroke=stroke, **STOP)


def _plane(rng, a, b):
    """(x, y, normal) of a plane that contains a point near a and one near b."""
    x = b.position - a.position
    x = x / np.linalg.norm(x)
    normal = np.cross(x, direction(rng))
    normal /= np.linalg.norm(normal)
    return x, np.cross(normal, x), normal


def _rope(rng, a, b, **given):
    """From a over a pulley of b and one of a, back through an eye of a, to a drum of b: all in one plane."""
    x, y, n = _plane(rng, a, b)
    first = Pulley(b, radius=0.3, sense=-1, centre=b.position + 0.6 * y, axis=n)
    second = Pulley(a, radius=0.2, sense=1, centre=a.position - 0.7 * y, axis=-n)
    eye = (a, a.position - 0.9 * y + 0.3 * x)
    drum = Winch(b, radius=0.25, sense=1, centre=b.position - 1.1 * y, axis=n)
    ends = ((a, a.position + 0.5 * y), drum)
    return [], Rope(ends, (first, second, eye), **given)


def _belt(rng, a, b, **given):
    """Each body is a pulley that turns about the other."""
    _, y, n = _plane(rng, a, b)
    hinges = [Cylindrical(a, b, at=b.position - 0.2 * y, axis=n), Cylindrical(b, a, at=a.position + 0.1 * y, axis=-n)]
    return hinges, Belt(*hinges, radii=(0.3, 0.2), stiffness=3.0, damping=0.4, pretension=40.0, **given)


LOCKS = (Clutch, Freewheel, Ratchet)
"""Elements without a load of their own before a run switches them; tests/run/test_clutches.py is about them."""

EXAMPLES = {
    "Force in world axes": lambda rng, a, b: ([], Force(b, _signals(rng), at=b.position + direction(rng))),
    "Force in body axes": lambda rng, a, b: ([], Force(b, _signals(rng), at=b.position + direction(rng), frame="body")),
    "Torque in world axes": lambda rng, a, b: ([], Torque(b, _signals(rng))),
    "Torque in body axes": lambda rng, a, b: ([], Torque(b, _signals(rng), frame="body")),
    "SpringDamper": lambda rng, a, b: ([], _spring(rng, a, b)),
    "SpringDamper without length": lambda rng, a, b: ([], replace(_spring(rng, a, b), length=0.0)),
    "TorsionSpring on a hinge": lambda rng, a, b: _on(
        _hinge(rng, a, b), TorsionSpring, stiffness=3.0, damping=0.7, angle=0.4
    ),
    "TorsionSpring on a slider": lambda rng, a, b: _on(
        _slider(rng, a, b), TorsionSpring, stiffness=3.0, damping=0.7, angle=0.4
    ),
    "JointFriction in a hinge": lambda rng, a, b: _on(
        _hinge(rng, a, b), JointFriction, coulomb=0.8, viscous=0.3, transition=0.5
    ),
    "JointFriction in a slider": lambda rng, a, b: _on(
        _slider(rng, a, b), JointFriction, coulomb=0.8, viscous=0.3, transition=0.5
    ),
    "SumSpring of angle and slide": lambda rng, a, b: _summed(rng, a, b, rest=0.4),
    "SumSpring beyond its slack": lambda rng, a, b: _summed(rng, a, b, rest=(20.0, 30.0)),
    "SumStop beyond its limit": lambda rng, a, b: _summed(rng, a, b, SumStop, upper=-20.0),
    "RotationStop": lambda rng, a, b: _turned(rng, a, b, angle=0.05),
    "RotationSpring": lambda rng, a, b: ([], RotationSpring(a, b, stiffness=3.0, damping=0.7)),
    "Brake that holds": lambda rng, a, b: _on(_hinge(rng, a, b), Brake, torque=90.0 + signal(rng, 1.0), **LINING),
    "Brake that slips": lambda rng, a, b: _on(_slider(rng, a, b), Brake, torque=Polynomial((0.3, 0.1)), **LINING),
    "DryFriction of a hinge": lambda rng, a, b: _on(
        _hinge(rng, a, b), DryFriction, pin_radius=0.4, yields=0.05, **PRESSED
    ),
    "DryFriction of a slide": lambda rng, a, b: _on(
        _slider(rng, a, b), DryFriction, guide_length=0.3, yields=0.1, **PRESSED
    ),
    "DryFriction of a ball": lambda rng, a, b: _on(
        Spherical(a, b, at=middle(rng, a, b)), DryFriction, ball_radius=0.5, yields=0.2, **PRESSED
    ),
    "EndStop of a hinge": lambda rng, a, b: _on(_hinge(rng, a, b), EndStop, upper=-4.0, **STOP),
    "EndStop of a slide": lambda rng, a, b: _on(_slider(rng, a, b), EndStop, lower=7.0, upper=8.0, **STOP),
    "PointStop": lambda rng, a, b: (
        [],
        PointStop(a, b, at=middle(rng, a, b), at_b=b.position + direction(rng), axis=direction(rng), lower=9.0, **STOP),
    ),
    "Backlash": lambda rng, a, b: _teeth(rng, a, b),
    "PinPlay that rubs": lambda rng, a, b: (
        [],
        PinPlay(
            a,
            b,
            at=middle(rng, a, b),
            at_b=b.position + direction(rng),
            axis=direction(rng),
            clearance=0.02,
            stiffness=0.8,
            damping=0.02,
            loss=0.01,
            mu=0.4,
            creep=0.5,
            pin_radius=0.3,
        ),
    ),
    "ConeStop of the swing": lambda rng, a, b: _cone(rng, a, b, half_angle=0.05),
    "ConeStop of the twist": lambda rng, a, b: _cone(rng, a, b, half_angle=3.1, twist=(0.1, 0.11)),
    "ConeStop of both": lambda rng, a, b: _cone(rng, a, b, half_angle=0.1, twist=(-0.03, 0.02)),
    "ForceCurve over the stretch": lambda rng, a, b: _table(rng, a, b),
    "ForceCurve over the rate": lambda rng, a, b: _table(rng, a, b, over="rate", between="monotone", beyond="line"),
    "TorqueCurve over the angle": lambda rng, a, b: _on(
        _hinge(rng, a, b), TorqueCurve, points=BENT, over="angle", between="monotone", beyond="hold"
    ),
    "TorqueCurve over the slide": lambda rng, a, b: _on(
        _slider(rng, a, b), TorqueCurve, points=[(x, 3.0 - y) for x, y in BENT], over="slide", beyond="line"
    ),
    "TorqueCurve over the rate": lambda rng, a, b: _on(_hinge(rng, a, b), TorqueCurve, points=BENT),
    "ForceBetween in axes of a": lambda rng, a, b: (
        [],
        ForceBetween(a, b, _signals(rng), at=b.position + direction(rng), frame="a"),
    ),
    "ForceBetween in world axes": lambda rng, a, b: ([], ForceBetween(a, b, _signals(rng))),
    "TorqueBetween in axes of b": lambda rng, a, b: ([], TorqueBetween(a, b, _signals(rng), frame="b")),
    "TorqueBetween in world axes": lambda rng, a, b: ([], TorqueBetween(a, b, _signals(rng))),
    "LinearActuator that pulls at its end": lambda rng, a, b: _actuator(rng, a, b, -2.0 + signal(rng, 0.1), (0.1, 0.2)),
    "LinearActuator that pushes at its end": lambda rng, a, b: _actuator(rng, a, b, 2.0, (20.0, 30.0)),
    "Rope over smooth pulleys": lambda rng, a, b: _rope(rng, a, b, stiffness=3.0, damping=0.4, pretension=30.0),
    "Rope that turns its pulleys": lambda rng, a, b: _rope(
        rng, a, b, stiffness=(3.0, 5.0, 4.0), damping=0.4, pretension=30.0, mu=(None, 3.0)
    ),
    "Rope that slips": lambda rng, a, b: _rope(rng, a, b, stiffness=3.0, damping=0.4, pretension=40.0, mu=0.01),
    "Belt": lambda rng, a, b: _belt(rng, a, b),
    "Belt that is crossed": lambda rng, a, b: _belt(rng, a, b, crossed=True),
    "StateFeedback": lambda rng, a, b: _seen(_hinge(rng, a, b)),
    "CustomForce": lambda rng, a, b: ([], _custom(rng, a, b)),
    "Tyre": lambda rng, a, b: ([], _tyre(rng, a, b)),
    "Tyre with instant camber": lambda rng, a, b: ([], _tyre(rng, a, b, camber_lag=False)),
    "Bushing": lambda rng, a, b: ([], _bushing(rng, a, b)),
    "Contact that sticks": lambda rng, a, b: _contact(rng, a, b, shapes.Ellipsoid((0.7, 0.5, 0.3), **STONE), **STICKS),
    "Contact that slips": lambda rng, a, b: _contact(rng, a, b, shapes.Torus(0.4, 0.3, (3, -1, 2), **STONE), **SLIPS),
    "Contact that creeps": lambda rng, a, b: _contact(rng, a, b, shapes.Sphere(0.6, at=(0.1, -0.2, 0.1)), **CREEPS),
    "Contact of spheres that sticks": lambda rng, a, b: _round_contact(rng, a, b, **STICKS),
    "Contact with a capsule that creeps": lambda rng, a, b: _round_contact(rng, a, b, 5.0, **CREEPS),
    "Weight": lambda rng, a, b: ([], Weight(a, b, acceleration=rng.normal(size=3))),
    "CentralGravity": lambda rng, a, b: ([], CentralGravity(a, b, at=a.position + direction(rng), mu=2.3)),
    "FluidDrag": lambda rng, a, b: (
        [],
        FluidDrag(
            b,
            lengths=(0.7, 0.5, 1.1),
            density=3.0,
            viscosity=0.6,
            at=b.position + direction(rng),
            axes=rotation(direction(rng), 0.8),
        ),
    ),
    "AeroDrag": lambda rng, a, b: ([], AeroDrag(b, drag_area=0.6, at=b.position + direction(rng), wind=_signals(rng))),
}
"""Name -> factory(rng, a, b) of (joints it needs, element)."""
