"""Derivatives of runs with every force element, joint and driver against central differences of free runs."""

from dataclasses import fields, replace
from functools import partial

import numpy as np
import pytest
from helpers.forces import EXAMPLES as FORCES
from helpers.models import EXAMPLES as JOINTS
from helpers.models import consistent_state, direction, middle, public_classes, random_body

import mbsd3d
from mbsd3d import (
    DOP853,
    RK4,
    Breaks,
    Clutch,
    Constant,
    DryFriction,
    Force,
    Freewheel,
    GeneralizedAlpha,
    Input,
    Joint,
    JointFriction,
    Kinematic,
    Polynomial,
    Pulse,
    RadauIIA,
    Ramp,
    Ratchet,
    Revolute,
    Signal,
    Sine,
    SpeedDriver,
    Spherical,
    Study,
    Switched,
    System,
    Table,
    signals,
    simulate,
)
from mbsd3d.errors import InputError
from mbsd3d.extend import ForceElement
from mbsd3d.signals import as_signal

slow = pytest.mark.slow  # kernels of complex numbers are compiled for every element
RUN = {"t_end": 0.05, "rtol": 1e-13, "output": 2}  # free runs at 1e-11 differ by 3e-7 where steps find a kink
STEP = 1e-3  # [1] of differences of fourth order, of factors of numbers
EXACT = 3e-7  # [1] of the largest derivative by the parameter: rounding and steps of free runs over STEP
TOUCHED = 1e-5  # [1] the same of stops, whose limits move by up to a tenth of the way to them: h^4 counts there
SMALL = 1e-2  # [m, m/s or rad/s] derivative by a factor that counts as small
SHIFT = np.array([0.3, -0.2, 0.5])


def numbers_of(element):
    """Return the names of the fields of an element that hold a finite number but zero."""
    values = {one.name: getattr(element, one.name) for one in fields(element) if one.init}
    return [name for name, x in values.items() if isinstance(x, float) and np.isfinite(x) and x != 0.0]


def measured(solution):
    """Return pose and velocities of the bodies at the end."""
    names = [body.name for body in solution.system.bodies[:2]]
    found = [x(name)[-1] for name in names for x in (solution.position, solution.velocity, solution.omega_body)]
    return np.concatenate(found)


def moving(system):
    return system, {"state": consistent_state(system, np.random.default_rng(5))}


def compare(build, x0, tolerance=EXACT):
    """Compare the derivatives of a run by its parameters with differences of free runs."""
    found, jac = Study(build, x0, measured, RUN).fun_and_jac()
    for j, name in enumerate(x0):

        def value(k, name=name):
            system, more = build(**{**x0, name: x0[name] + k * STEP})
            return measured(simulate(system, **RUN, **more))

        free = (8.0 * (value(1) - value(-1)) - (value(2) - value(-2))) / (12.0 * STEP)
        size = max(np.abs(free).max(), np.abs(jac[:, j]).max(), SMALL)
        np.testing.assert_allclose(jac[:, j], free, rtol=0.0, atol=tolerance * size, err_msg=name)
    return jac


# Numbers in place of those of the examples: limits that a run begins within, and passes, and exponents that may change.
INSTEAD = {
    "SumStop beyond its limit": dict(lower=-0.01, upper=0.01),
    "EndStop of a hinge": dict(lower=-0.01, upper=0.01),
    "EndStop of a slide": dict(lower=-0.01, upper=0.01),
    "PointStop": dict(lower=-0.775, upper=-0.76),
    "PinPlay that rubs": dict(clearance=1.25),
    "ConeStop of the swing": dict(half_angle=0.11),
    "ConeStop of the twist": dict(twist=(-0.01, 0.01)),
    "ConeStop of both": dict(half_angle=0.11, twist=(-0.01, 0.01)),
    "LinearActuator that pulls at its end": dict(stroke=(4.44, 4.46)),
    "LinearActuator that pushes at its end": dict(stroke=(3.94, 3.96)),
    "Contact that slips": dict(exponent=1.3),
    "Contact that creeps": dict(exponent=1.3),
    "Contact with a capsule that creeps": dict(exponent=1.3),
}
TOUCHING = {name for name in INSTEAD if "Contact" not in name} | {"RotationStop", "Backlash"}


def with_force(name):
    """Return a build with all numbers of an example as factors, and where body b is; and the factors."""

    def parts(x):
        rng = np.random.default_rng(7)
        a, b = random_body(rng, "a"), random_body(rng, "b")
        b = replace(b, position=b.position + x * SHIFT, mass=b.mass * (1.0 + x))
        joints, element = FORCES[name](rng, a, b)
        return [a, b], joints, replace(element, **INSTEAD.get(name, {}))

    factors = numbers_of(parts(0.0)[2])

    def build(x, **given):
        bodies, joints, element = parts(x)
        element = replace(element, **{key: factor * getattr(element, key) for key, factor in given.items()})
        return moving(System(bodies, joints, [element], gravity=(0.3, -0.7, -9.6)))

    return build, {"x": 0.1, **dict.fromkeys(factors, 1.0)}


@slow
@pytest.mark.parametrize("name", FORCES)
def test_derivatives_by_numbers_of_forces(name):
    build, x0 = with_force(name)
    if name.startswith("DryFriction"):
        with pytest.raises(InputError, match="DryFriction 'DryFriction 1' depends on a reaction"):
            compare(build, x0)
        return
    jac = compare(build, x0, TOUCHED if name in TOUCHING else EXACT)
    if name in TOUCHING:
        assert np.abs(jac[:, [*x0].index("stiffness")]).max() > 0.0  # it has touched


def with_joint(cls):
    def build(x):
        rng = np.random.default_rng(4)
        bodies = [random_body(rng, name) for name in ("one", "two", "three", "four")]
        two = bodies[1]
        bodies[1] = replace(two, position=two.position + x * SHIFT, mass=two.mass * (1.0 + x))
        joints = JOINTS[cls](rng, *bodies)
        return moving(System(bodies, joints, gravity=(0.3, -0.7, -9.6)))

    return build


@slow
@pytest.mark.parametrize("cls", JOINTS, ids=lambda cls: cls.__name__)
def test_derivatives_by_numbers_of_joints(cls):
    if cls in (Breaks, Switched):
        with pytest.raises(InputError, match=f"{cls.__name__} '{cls.__name__} 1' switches at events"):
            compare(with_joint(cls), {"x": 0.1})
        return
    compare(with_joint(cls), {"x": 0.1})


def with_inertia(cls, x, reflected):
    rng = np.random.default_rng(4)
    a, b = random_body(rng, "one"), random_body(rng, "two")
    b = replace(b, position=b.position + x * SHIFT)
    axis = {} if cls is Spherical else {"axis": direction(rng)}
    joint = cls(a, b, at=middle(rng, a, b), **axis, reflected_inertia=reflected)
    return moving(System([a, b], [joint], [Force(b, (3.0, -2.0, 1.0), at=middle(rng, a, b))]))


@slow
@pytest.mark.parametrize("cls", [Revolute, Spherical], ids=lambda cls: cls.__name__)
def test_derivatives_by_reflected_inertia(cls):
    compare(partial(with_inertia, cls), {"x": 0.1, "reflected": 0.3})


TIMES = np.array([-1.0, 0.0, 0.01, 0.03, 0.06, 1.0])
SIGNALS = {
    "constant": lambda p: Constant(p),
    "ramp": lambda p: Ramp(rate=-0.8 * p, offset=0.3),
    "sine": lambda p: Sine(amplitude=0.6, frequency=4.0 * p, phase=0.5 * p, offset=-0.2),
    "polynomial": lambda p: Polynomial([0.3, -1.1 * p, 0.7, 2.5 * p]),
    "pulse": lambda p: Pulse(height=1.3, start=0.01 * p, edge=0.02, duration=1.5),
    "table": lambda p: Table(TIMES, np.cos(30.0 * TIMES * p)),
    "input": lambda p: Input("push", 0.7 * p),
    "sum": lambda p: 2.0 * p - 3.0 * (Ramp(rate=p) + Sine(0.6, 1.4 * p)),
}  # fmt: skip


@slow
@pytest.mark.parametrize("name", SIGNALS)
def test_derivatives_by_numbers_of_signals(name):
    def build(p):
        rng = np.random.default_rng(4)
        a, b = random_body(rng, "one"), random_body(rng, "two")
        push = Force(b, (3.0 * SIGNALS[name](p), -2.0, SIGNALS[name](p)), at=middle(rng, a, b))
        driver = SpeedDriver(a, b, axis=direction(rng), speed=SIGNALS[name](p))
        return moving(System([a, b], [driver], [push]))

    compare(build, {"p": 1.0})


def rubbing(cls, **numbers):
    rng = np.random.default_rng(4)
    a, b = random_body(rng, "one"), random_body(rng, "two")
    hinge = Revolute(a, b, at=middle(rng, a, b), axis=direction(rng))
    return [a, b], [hinge], [cls(hinge, **numbers)]


REFUSED = {
    DryFriction: lambda: rubbing(DryFriction, mu=0.3, pin_radius=0.1),
    Clutch: lambda: rubbing(Clutch, torque=3.0, engaged=True),
    Freewheel: lambda: rubbing(Freewheel),
    Ratchet: lambda: rubbing(Ratchet, teeth=12),
}
METHODS = {DOP853, RK4, Kinematic}  # in test_study.py against closed forms
REFUSED_METHODS = {GeneralizedAlpha: GeneralizedAlpha(1e-3), RadauIIA: RadauIIA()}


def kinds_of(signal):
    """Yield the classes of a signal and of its parts."""
    yield type(signal)
    for part in (*getattr(signal, "signals", ()), *([signal.signal] if hasattr(signal, "signal") else [])):
        yield from kinds_of(part)


def test_every_public_part_has_its_derivative_tried():
    """A new joint, force, signal or method fails here until it is tried above, or refused by name below."""
    rng = np.random.default_rng(7)
    bodies = random_body(rng, "a"), random_body(rng, "b")
    tried = {type(make(rng, *bodies)[1]) for make in FORCES.values()} | {*REFUSED}
    assert tried == public_classes(ForceElement)
    assert {*JOINTS} == {cls for cls in public_classes(Joint) if cls.__name__ != "Driver"}
    curves = {kind for make in SIGNALS.values() for kind in kinds_of(as_signal(make(1.0), "test"))}
    own = {x for x in vars(signals).values() if isinstance(x, type) and issubclass(x, Signal) and x is not Signal}
    assert curves == own | public_classes(Signal)
    public = {getattr(mbsd3d, name) for name in mbsd3d.__all__}
    assert METHODS | {*REFUSED_METHODS} == {x for x in public if isinstance(x, type) and "integrators" in x.__module__}


@slow
@pytest.mark.parametrize("method", REFUSED_METHODS.values(), ids=lambda x: type(x).__name__)
def test_methods_without_derivatives_are_refused_by_name(method):
    def build(g):
        return System(*rubbing(JointFriction, coulomb=0.8), gravity=(0.3 * g, -0.7, -9.6))

    words = f"gradient: {type(method).__name__} has no derivatives; give DOP853"
    with pytest.raises(InputError, match=words):
        Study(build, {"g": 1.0}, measured, RUN | {"method": method}).jac()


@slow
@pytest.mark.parametrize("cls", REFUSED, ids=lambda cls: cls.__name__)
def test_parts_without_derivatives_are_refused_by_name(cls):
    def build(g):
        return System(*REFUSED[cls](), gravity=(0.3 * g, -0.7, -9.6))

    with pytest.raises(
        InputError,
        match=f"gradient: {cls.__name__} '.*' (switches at events|depends on a reaction).*; leave it out, or",
    ):
        Study(build, {"g": 1.0}, measured, RUN).jac()
