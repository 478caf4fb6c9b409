"""Snapshots of a stepper: to the last bit the same motion after going back, for all methods and all that remembers."""

import copy
import pickle
import re

import numpy as np
import pytest
from helpers.models import direction, random_body

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AngleDriver,
    Body,
    Brake,
    Contact,
    CustomForce,
    EndStop,
    Force,
    GeneralizedAlpha,
    Input,
    IntegrationError,
    Kinematic,
    Prismatic,
    Pulse,
    RadauIIA,
    Ramp,
    Revolute,
    Sine,
    Spherical,
    SpringDamper,
    Stepper,
    System,
    Table,
    Torque,
    linkages,
    measures,
    shapes,
)


def lagging(t, bodies, z, parameters, loads, z_dot):
    """An internal state that follows a rate; it acts as a torque."""
    z_dot[0] = 4.0 * (bodies[0].w[1] - z[0])
    loads[0, 4] = -0.3 * z[0]


def pendulum():
    """Two bodies in general position, an internal state, a pulse and an input."""
    rng = np.random.default_rng(3)
    upper, lower = random_body(rng, "upper"), random_body(rng, "lower")
    elbow = Revolute(upper, lower, at=rng.normal(size=3), axis=direction(rng), name="elbow")
    forces = [
        CustomForce(lagging, on=(upper,), states=(0.7,), external=True),
        Force(lower, (Input("push"), Pulse(2.0, 0.13, 0.09), 0.0), at=lower.centre + 0.3),
    ]
    joints = [Spherical(GROUND, upper, at=rng.normal(size=3)), elbow]
    pull = measures.reaction(elbow, axis=(0, 0, 1))  # whose reading solves the equations in between
    return System([upper, lower], joints, forces), [measures.angle(elbow), pull]


def braked():
    """A hinge that turns several times, is held by a brake, and torn loose; an end stop on a slide beside it."""
    disc = Body("disc", 2.0, (0.3, 0.4, 0.5), com=(0.02, 0.01, 0), omega=(0, 0, 40.0))
    sled = Body("sled", 1.0, (0.1, 0.1, 0.1), position=(3, 0, 0), velocity=(2.0, 0, 0))
    hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    slide = Prismatic(GROUND, sled, at=(3, 0, 0), axis=(1, 0, 0), name="slide")
    forces = [
        Brake(hinge, torque=20.0 + 10.0 * Input("push"), stiffness=2e3, damping=20.0),
        EndStop(slide, upper=0.2, lower=-0.1, stiffness=5e3, damping=30.0),
        Torque(disc, (0, 0, Sine(15.0, 3.0))),
    ]
    return System([disc, sled], [hinge, slide], forces), [measures.angle(hinge), measures.slide(slide)]


def bouncing():
    """A ball that bounces, slips and rolls, under a table of wind."""
    ball = Body(
        "ball", 1.5, (0.01, 0.012, 0.008), position=(0, 0, 0.25), velocity=(1.0, 0.3, 0), omega=(3.0, 1.0, -5.0)
    )
    wind = Table([0.0, 0.1, 0.25, 1.0, 9.0], [0.0, 2.0, -1.0, 0.5, 0.0])
    floor = Contact(GROUND, ball, shapes.Sphere(0.1), stiffness=2e4, loss=0.3, friction=0.3, rolling=0.002)
    return System([ball], forces=[floor, Force(ball, (wind, Input("push"), 0))]), [measures.clearance(floor)]


def looped():
    """A closed loop of four hinges, whose rows repeat each other, turned by an input."""
    loop = linkages.bennett(0.4, 0.7, 0.4 * np.sin(1.2) / np.sin(0.7), 1.2, 0.8)
    torque = Torque(loop.bodies[-1], (Input("push"), 0.2, 0.3))
    return System(loop.bodies, loop.joints, [*loop.forces, torque]), [measures.angle(loop.joints[0])]


def driven():
    """An arm on a driver, with a spring to another body that moves along."""
    arm = Body("arm", 2.0, (0.1, 0.2, 0.15), com=(0.3, 0.1, 0))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(1, 2, 2), name="hinge")
    spring = SpringDamper(GROUND, arm, at_a=(1, 1, 1), at_b=(0.3, 0.1, 0), stiffness=30.0, damping=2.0)
    push = Force(arm, (Input("push"), 0, 0))
    motor = AngleDriver(hinge, Ramp(9.0) + Sine(0.2, 1.0))
    return System([arm], [hinge, motor], [spring, push]), [measures.angle(hinge)]


ALL = [
    DOP853(), DOP853(dt=0.004), RK4(0.004), GeneralizedAlpha(), GeneralizedAlpha(dt=0.004), RadauIIA(),
    RadauIIA(dt=0.01),
]  # fmt: skip
CASES = [
    *((pendulum, method) for method in ALL),
    *((braked, method) for method in (DOP853(), GeneralizedAlpha(), RadauIIA())),
    *((bouncing, method) for method in (DOP853(), RadauIIA())),
    *((looped, method) for method in (DOP853(), GeneralizedAlpha())),
    (driven, Kinematic()),
    (driven, DOP853()),
]


def seen(stepper):
    """All numbers of a stepper as bytes."""
    state = stepper.state
    now = (stepper.t, stepper.q, stepper.v, stepper.z, state.coordinates, stepper.measured)
    return b"".join(np.asarray(x, float).tobytes() for x in (*now, *stepper.inputs.values()))


def judged(solution):
    """The certificate without the time that the computer took."""
    return re.sub(r"evaluations, [^ ]+ s", "", str(solution.certificate))


def go(stepper, move):
    """Set an input and integrate by one of a few lengths."""
    push, length = move
    stepper.set("push", push)
    stepper.advance(stepper.t + length)


MOVES = [(0.0, 0.03), (1.5, 0.011), (-0.7, 0.05)]


@pytest.mark.parametrize(("model", "method"), CASES, ids=[f"{model.__name__}, {method}" for model, method in CASES])
def test_all_ways_to_a_point_are_one(model, method):
    """A random tree of moves, snapshots and restores: the same moves lead to the same bits, as without snapshots."""
    rng = np.random.default_rng(11)
    system, read = model()
    stepper = Stepper(system, measures=read, method=method)
    kept, found, path = {(): stepper.snapshot()}, {(): seen(stepper)}, ()
    repeated = 0
    for _ in range(60):
        what = rng.integers(4)
        if what == 0:
            kept[path] = stepper.snapshot()
        elif what == 1 or len(path) > 12:
            path = sorted(kept)[rng.integers(len(kept))]
            stepper.restore(kept[path])
            assert seen(stepper) == found[path]
        else:
            k = int(rng.integers(len(MOVES)))
            path = (*path, k)
            go(stepper, MOVES[k])
            repeated += path in found
            assert found.setdefault(path, seen(stepper)) == seen(stepper)
    assert repeated > 3
    longest = max(found, key=len)
    fresh = Stepper(system, measures=read, method=method)
    for i, k in enumerate(longest):
        go(fresh, MOVES[k])
        assert seen(fresh) == found[longest[: i + 1]]
    start = max((x for x in kept if longest[: len(x)] == x), key=len)
    stepper.restore(kept[start])
    for k in longest[len(start) :]:
        go(stepper, MOVES[k])
    one, other = stepper.solution(), fresh.solution()
    assert all(np.array_equal(one.arrays[name], other.arrays[name]) for name in one.arrays)
    assert one.record.inputs == other.record.inputs and one.record.steps == other.record.steps
    assert judged(one) == judged(other)


def test_a_failure_is_taken_back():
    """After a force without a value the run goes on from before it, as if nothing had been."""

    def burst(t, bodies, z, parameters, loads, z_dot):
        loads[0, 0] = np.sqrt(0.25 - t) if bodies[0].velocity[2] < 1.0 else np.sqrt(4.0 - t)

    stone = Body("stone", 2.0, (0.1, 0.2, 0.3), com=(0.1, 0, 0.2), velocity=(0, 0, 0), omega=(0.3, 0.1, 2.0))
    system = System([stone], forces=[CustomForce(burst, on=(stone,)), Force(stone, (0, 0, 100.0 * Input("lift")))])
    stepper, fresh = Stepper(system), Stepper(system)
    stepper.advance(0.01)
    before = stepper.snapshot()
    with pytest.raises(IntegrationError):
        stepper.advance(0.5)
    stepper.restore(before)
    fresh.advance(0.01)
    for one in (stepper, fresh):
        one.set("lift", 3.0)
        one.advance(0.5)
    assert seen(stepper) == seen(fresh)
    assert judged(stepper.solution()) == judged(fresh.solution())


def test_a_snapshot_stays_what_it_is():
    system, read = pendulum()
    stepper = Stepper(system, measures=read, keep=False)
    go(stepper, MOVES[0])
    there = stepper.snapshot()
    assert repr(there) == "<snapshot: at t = 0.03 s>"
    once = []
    for _ in range(3):
        stepper.restore(there)
        go(stepper, MOVES[1])
        once.append(seen(stepper))
    assert once[0] == once[1] == once[2]


def test_foreign_snapshots_are_refused():
    (system, _), (again, _) = pendulum(), pendulum()
    stepper = Stepper(system)
    for other in (Stepper(system), Stepper(again)):
        with pytest.raises(ValueError, match="at t = 0 s> is of another stepper; restore it there"):
            stepper.restore(other.snapshot())
    with pytest.raises(ValueError, match="restore: 0.5 is not a snapshot"):
        stepper.restore(0.5)
    for use in (copy.deepcopy, pickle.dumps):
        with pytest.raises(ValueError, match="a snapshot is neither copied nor pickled"):
            use(stepper.snapshot())
