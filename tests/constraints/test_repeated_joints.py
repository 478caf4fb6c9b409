"""Joints that repeat others move nothing otherwise, in free flight as at rest; references have no repeated joint."""

import numpy as np
import pytest

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    Body,
    Fixed,
    GeneralizedAlpha,
    Prismatic,
    RadauIIA,
    Revolute,
    Spherical,
    SpringDamper,
    State,
    System,
    TorsionSpring,
    rotation,
    simulate,
)

AXIS, AT = np.array([1.0, -2.0, 2.0]) / 3.0, np.array([0.4, -0.3, 0.7])


def body(name, k, at):
    """A body of general shape, r_G != 0, no axis aligned."""
    com = 0.1 * np.sin(k + np.array([1.0, 2.0, 3.0]))
    turn = rotation((1.0, k, -2.0), 0.7 + k)
    return Body(name, 1.0 + 0.6 * k, (0.1, 0.12, 0.15), com=com, position=at, orientation=turn)


def tumbling(joints_of, count=2):
    """Free bodies that fly and turn as one at the start, with the joints that a function gives for them."""
    bodies = [body(f"body {k}", k, AT + 0.5 * np.cos(k + np.array([0.0, 2.0, 4.0]))) for k in range(count)]
    w, v = np.array([9.0, -12.0, 7.0]), np.array([2.0, 1.0, -3.0])
    velocities = np.concatenate([[*(v + np.cross(w, each.position)), *w] for each in bodies])
    system = System(bodies, joints_of(*bodies), gravity=(0, 0, 0))
    poses = np.concatenate([[*each.position, *each.orientation] for each in bodies])
    return system, State(0.0, poses, velocities)


def hinges(count):
    return lambda a, b: [Revolute(a, b, at=AT + 0.3 * k * AXIS, axis=AXIS, name=f"hinge {k}") for k in range(count)]


def ring(a, b, c):
    return [Fixed(x, y, at=x.position, name=f"weld {k}") for k, (x, y) in enumerate(((a, b), (b, c), (c, a)))]


CASES = {
    "two hinges": (hinges(2), hinges(1), 2),
    "three hinges": (hinges(3), hinges(1), 2),
    "ring of welds": (ring, lambda a, b, c: ring(a, b, c)[:2], 3),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("dt", [4e-3, 1e-3])
def test_fixed_steps_with_repeated_joints_are_those_without(name, dt):
    """Stages of a step are off c = 0, where repeated rows contradict each other."""
    repeated, simple, count = CASES[name]
    finals = []
    for joints_of in (repeated, simple):
        system, state = tumbling(joints_of, count)
        run = simulate(system, 0.2, state=state, method=RK4(dt=dt), rtol=1e-6)
        assert run.certificate.passed, run.certificate.failures
        finals.append(run.final.v)
    # of 17 rad/s: the paths of the stages differ by what projection moves, 1e-10 of a step of 4e-3 s
    assert np.allclose(*finals, rtol=0, atol=1e-7)


@pytest.mark.parametrize("name", CASES)
def test_adaptive_steps_are_as_long_with_repeated_joints(name):
    repeated, simple, count = CASES[name]
    runs = []
    for joints_of in (repeated, simple):
        system, state = tumbling(joints_of, count)
        runs.append(simulate(system, 0.2, state=state))
    assert np.allclose(runs[0].final.v, runs[1].final.v, rtol=0, atol=1e-6)  # 100 rtol of 17 rad/s
    assert runs[0].certificate.steps <= 1.1 * runs[1].certificate.steps  # four times as many once


def test_two_balls_are_a_hinge_however_they_tumble():
    """Which rows of the balls stand for the hinge changes as the line between them turns."""

    def balls(a, b):
        return [Spherical(a, b, at=AT + 0.4 * k * AXIS, name=f"ball {k}") for k in range(2)]

    def hinge(a, b):
        return [Revolute(a, b, at=AT, axis=AXIS, name="hinge")]

    finals = []
    for joints_of in (balls, hinge):
        system, state = tumbling(joints_of)
        run = simulate(system, 0.4, state=state, method=DOP853(), rtol=1e-9)
        assert run.certificate.passed, run.certificate.failures
        finals.append(run.final.v)
    assert np.allclose(*finals, rtol=0, atol=1e-6)  # 50 rtol of 17 rad/s


METHODS = {
    "DOP853": {},
    "tight": {"rtol": 1e-10},
    "alpha": {"method": GeneralizedAlpha(dt=1e-2), "rtol": 1e-4},
    "Radau": {"method": RadauIIA()},
    "RK4": {"method": RK4(dt=1e-2), "rtol": 1e-6},
}


def slide(springs):
    """One body on two parallel guides, on its own or between springs that balance each other."""
    block = Body("block", 1.3, (0.1, 0.12, 0.15), com=(0.02, 0.1, -0.01), position=AT)
    guides = [
        Prismatic(GROUND, block, at=AT + offset, axis=AXIS, name=f"guide {k}")
        for k, offset in enumerate(((0.1, 0.2, 0.0), (-0.1, 0.0, 0.3)))
    ]
    side = np.cross(AXIS, (0.3, 0.5, -0.2))
    pulls = [
        SpringDamper(GROUND, block, at_a=AT + s * side, at_b=AT, stiffness=100.0, length=0.1, name=f"spring {s}")
        for s in (-1, 1)
    ]
    return System([block], guides, pulls if springs else [], gravity=(0, 0, 0))


def pair(springs):
    """Two free bodies on two hinges."""
    a, b = (body(f"body {k}", k, AT + 0.5 * np.cos(k + np.array([0.0, 2.0, 4.0]))) for k in range(2))
    joints = hinges(2)(a, b)
    held = [TorsionSpring(joints[0], stiffness=20.0, damping=0.3, name="spring")] if springs else []
    return System([a, b], joints, held, gravity=(0, 0, 0))


@pytest.mark.parametrize("options", METHODS.values(), ids=METHODS)
@pytest.mark.parametrize("make", [slide, pair])
@pytest.mark.parametrize("speed", [0.0, 20.0])
@pytest.mark.parametrize("springs", [False, True])
def test_what_moves_nothing_passes(make, speed, springs, options):
    """Without gravity, forces and spins only rounding is left to judge: it is no error."""
    system = make(springs)
    poses = np.concatenate([[*each.position, *each.orientation] for each in system.bodies])
    flight = State(0.0, poses, np.tile([*(speed * AXIS), 0.0, 0.0, 0.0], len(system.bodies)))
    certificate = simulate(system, 1.0, state=flight, **options).certificate
    assert certificate.passed, certificate.failures
