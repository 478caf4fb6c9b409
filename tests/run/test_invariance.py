"""What must not change: reference points, frames, order of parts, and twin formulations of one mechanism."""

import numpy as np
import pytest
from helpers.models import (
    across,
    consistent_state,
    direction,
    moved_reference,
    pair_at,
    pendulum,
    random_body,
    random_inertia,
    random_orientation,
    same_rotation,
)

from mbsd3d import (
    GROUND,
    Body,
    Cylindrical,
    Distance,
    Gear,
    Parallel,
    Perpendicular,
    PointOnLine,
    Prismatic,
    RackPinion,
    Revolute,
    Screw,
    Spherical,
    SpringDamper,
    State,
    System,
    Torque,
    TorsionSpring,
    Universal,
    simulate,
)
from mbsd3d.rotations import matrix, multiply

RTOL = 1e-12

MOTION, REACTIONS = 1e-10, 1e-9
"""The limit set: two integrations of one motion at rtol 1e-12, each good to 1e-11 or better over a second."""


class Frame:
    """A rotation and a shift of the whole world."""

    def __init__(self, e=(1.0, 0.0, 0.0, 0.0), shift=(0.0, 0.0, 0.0)):
        self.e, self.R, self.shift = np.array(e), matrix(np.array(e)), np.array(shift)

    def point(self, p):
        """A point of the first world in the second."""
        return self.R @ p + self.shift

    def body(self, body):
        """A body of the first world in the second."""
        return Body(
            body.name,
            body.mass,
            body.inertia,
            com=body.com,
            position=self.point(body.position),
            orientation=multiply(self.e, body.orientation),
        )


def linkage(frame=None, shift_seed=None, reverse=False):
    """Crank (Revolute), arm (Universal) and rod (Spherical, and a Distance that closes the loop), with a spring."""
    frame, rng = frame or Frame(), np.random.default_rng(31)
    places = ((0.3, 0.2, 0.1), (0.9, -0.1, 0.4), (1.6, 0.3, -0.2))
    bodies = [
        random_body(rng, name, position=np.array(p)) for name, p in zip(("crank", "arm", "rod"), places, strict=True)
    ]
    axis, cross = direction(rng), direction(rng)
    other, points = across(rng, cross), [np.array(p) + 0.1 * rng.normal(size=3) for p in ((0, 0, 0), *places)]
    if shift_seed is not None:
        shifts = 0.5 * np.random.default_rng(shift_seed).normal(size=(3, 3))
        bodies = [moved_reference(body, shift) for body, shift in zip(bodies, shifts, strict=True)]
    crank, arm, rod = bodies = [frame.body(body) for body in bodies]
    p, turn = frame.point, frame.R
    joints = [
        Revolute(GROUND, crank, at=p(points[0]), axis=turn @ axis, name="hinge"),
        Universal(crank, arm, at=p(points[1]), axis_a=turn @ cross, axis_b=turn @ other, name="cross"),
        Spherical(arm, rod, at=p(points[2]), name="ball"),
        Distance(GROUND, rod, at_a=p(np.array([2.2, 0.5, 0.9])), at_b=p(points[3]), name="loop"),
    ]
    ends = dict(at_a=p(np.array([0.7, -0.4, 1.1])), at_b=p(points[2] + 0.3))
    spring = SpringDamper(GROUND, arm, **ends, stiffness=40.0, damping=0.8, length=0.5, name="spring")
    if reverse:
        bodies, joints = bodies[::-1], joints[::-1]
    return System(bodies=bodies, joints=joints, forces=[spring], gravity=turn @ np.array([0.4, -0.9, -9.5]))


def run(system, t_end=1.0):
    """A run that starts with a turning crank and everything else at least kinetic energy."""
    start = system.assemble(rates={"hinge": 1.7})
    return simulate(system, t_end, state=start, rtol=RTOL, output=6)


@pytest.fixture(scope="module")
def reference():
    return run(linkage())


def assert_same_motion(found, expected, frame=None):
    """Centres of mass, rotations and angular velocities, and reactions of all joints, as seen from ``frame``."""
    frame = frame or Frame()
    for name in ("crank", "arm", "rod"):
        assert found.com(name) == pytest.approx(expected.com(name) @ frame.R.T + frame.shift, abs=MOTION)
        turned = multiply(frame.e, expected.orientation(name))
        assert same_rotation(found.orientation(name), turned) < MOTION
        assert found.omega(name) == pytest.approx(expected.omega(name) @ frame.R.T, abs=10 * MOTION)  # 10 rad/s
    for name in ("hinge", "cross", "ball", "loop"):
        mine, other = found.reaction(name), expected.reaction(name)
        size = np.abs(other.force).max()
        assert mine.force == pytest.approx(other.force @ frame.R.T, abs=REACTIONS * size)
        assert mine.moment == pytest.approx(other.moment @ frame.R.T, abs=REACTIONS * size)
        assert mine.point == pytest.approx(other.point @ frame.R.T + frame.shift, abs=MOTION)


def test_the_linkage_moves_and_carries_load(reference):
    assert np.ptp(reference.com("rod"), axis=0).min() > 0.1
    assert all(np.abs(reference.reaction(name).force).min() > 1e-3 for name in ("hinge", "cross", "ball", "loop"))
    assert reference.certificate.passed


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_reference_points_do_not_matter(reference, seed):
    assert_same_motion(run(linkage(shift_seed=seed)), reference)


@pytest.mark.parametrize("seed", [4, 5])
def test_a_turned_and_shifted_model_gives_turned_and_shifted_results(reference, seed):
    rng = np.random.default_rng(seed)
    frame = Frame(random_orientation(rng), 2.0 * rng.normal(size=3))
    assert_same_motion(run(linkage(frame)), reference, frame)


def test_order_of_bodies_and_joints_does_not_matter(reference):
    assert_same_motion(run(linkage(reverse=True)), reference)


def test_ablation_without_centripetal_force_reference_points_matter(reference):
    """What the first invariance must see: r_G only in the mass matrix."""
    system = linkage(shift_seed=1)
    start = system.assemble(rates={"hinge": 1.7})
    wrong = simulate(system, 1.0, state=start, rtol=RTOL, output=6, centripetal=False)
    assert np.abs(wrong.com("rod") - reference.com("rod")).max() > 100 * MOTION


def test_a_free_mechanism_does_not_feel_its_speed():
    rng = np.random.default_rng(32)
    one, two = random_body(rng, "one"), random_body(rng, "two")
    axis = direction(rng)
    joint = Universal(one, two, at=direction(rng), axis_a=axis, axis_b=across(rng, axis))
    spring = SpringDamper(one, two, at_a=one.position + 0.3, at_b=two.position - 0.4, stiffness=9.0, damping=0.2)
    system = System(bodies=[one, two], joints=[joint], forces=[spring])
    start, velocity = consistent_state(system, rng), np.array([31.0, -22.0, 13.0])
    moving = State(0.0, start.q, start.v + np.tile(np.concatenate([velocity, np.zeros(3)]), 2))
    still, fast = (simulate(system, 1.0, state=s, rtol=RTOL, output=6) for s in (start, moving))
    for body in (one, two):
        assert fast.com(body) == pytest.approx(still.com(body) + np.outer(still.t, velocity), abs=MOTION)
        assert same_rotation(fast.orientation(body), still.orientation(body)) < MOTION
    assert fast.reaction(joint).force == pytest.approx(still.reaction(joint).force, abs=1e-8)  # REACTIONS times 10 N


def swing(system, joint, rate=2.0):
    """A second of a body on the ground, started with a rate about its joint."""
    return simulate(system, 1.0, state=system.assemble(rates={joint: rate}), rtol=RTOL, output=6)


def test_revolute_is_spherical_and_two_perpendicular():
    system, body, hinge = pendulum()
    normals = (x := across(np.random.default_rng(33), hinge.axis)), np.cross(hinge.axis, x)
    ball = Spherical(GROUND, body, at=hinge.at)
    flat = [Perpendicular(GROUND, body, axis_a=n, axis_b=hinge.axis) for n in normals]
    twin = System(bodies=[body], joints=[ball, *flat])
    first = swing(system, hinge)
    second = simulate(twin, 1.0, state=State(0.0, first.state(0).q, first.state(0).v), rtol=RTOL, output=6)
    assert second.com(body) == pytest.approx(first.com(body), abs=MOTION)
    one, other = first.reaction(hinge), second.reaction(ball, *flat)
    size = np.abs(one.force).max()
    assert other.force == pytest.approx(one.force, abs=REACTIONS * size)
    assert other.moment == pytest.approx(one.moment, abs=REACTIONS * size)
    assert np.abs(one.moment).max() > 0.1
    assert np.abs(second.reaction(ball).moment).max() < 1e-12 * size  # a ball transmits no moment about its centre


@pytest.mark.parametrize("joint", [Revolute, Cylindrical])
def test_a_joint_seen_from_its_other_side(joint):
    system, body, hinge = pendulum(joint=joint)
    other = joint(body, GROUND, at=hinge.at, axis=hinge.axis)
    first = swing(system, hinge)
    start = State(0.0, first.state(0).q, first.state(0).v)
    second = simulate(System(bodies=[body], joints=[other]), 1.0, state=start, rtol=RTOL, output=6)
    assert second.com(body) == pytest.approx(first.com(body), abs=MOTION)
    assert second.angle(other) == pytest.approx(-first.angle(hinge), abs=MOTION)
    assert second.rate(other) == pytest.approx(-first.rate(hinge), abs=10 * MOTION)  # 10 rad/s
    one, opposite = first.reaction(hinge), second.reaction(other)
    size = np.abs(one.force).max()
    assert opposite.force == pytest.approx(-one.force, abs=REACTIONS * size)
    # the reaction on the ground is given at the ground's point of the joint
    arm = one.point - opposite.point
    assert opposite.moment == pytest.approx(-one.moment - np.cross(arm, one.force), abs=REACTIONS * size)


def test_cylindrical_is_point_on_line_and_parallel():
    system, body, guide = pendulum(joint=Cylindrical)
    line = PointOnLine(GROUND, body, at=guide.at, axis=guide.axis)
    along = Parallel(GROUND, body, axis=guide.axis)
    twin = System(bodies=[body], joints=[line, along])
    first = swing(system, guide)
    second = simulate(twin, 1.0, state=State(0.0, first.state(0).q, first.state(0).v), rtol=RTOL, output=6)
    assert second.com(body) == pytest.approx(first.com(body), abs=MOTION)
    one, other = first.reaction(guide), second.reaction(line, along)
    size = np.abs(one.force).max()
    assert other.force == pytest.approx(one.force, abs=REACTIONS * size)
    assert other.moment == pytest.approx(one.moment, abs=REACTIONS * size)
    assert second.angle(along) == pytest.approx(first.angle(guide), abs=MOTION)


def test_slide_without_friction_falls_freely_along_its_axis():
    """The part of the motion of a Cylindrical joint along its axis: g . u t^2 / 2 whatever the swing."""
    system, _, guide = pendulum(joint=Cylindrical)
    solution = swing(system, guide)
    expected = solution.slide(guide)[0] + system.gravity @ guide.axis * solution.t**2 / 2
    start = solution.rate(guide)[0]
    assert start == pytest.approx(2.0, abs=1e-12)
    drift = solution.slide(guide) - expected
    # linear in time: the speed that least kinetic energy gave it
    assert drift == pytest.approx(drift[-1] * solution.t, abs=MOTION)


def wheel(rng, name, at, axis, moment):
    """A body with its centre of mass at ``at`` on the axis, O elsewhere, and ``moment`` about the axis."""
    e, mass, shift = random_orientation(rng), rng.uniform(1.0, 2.0), 0.4 * direction(rng)
    inertia, u = random_inertia(rng, mass), matrix(e).T @ axis
    inertia *= moment / (u @ inertia @ u)
    return Body(name, mass, inertia, com=-matrix(e).T @ shift, position=at + shift, orientation=e)


RATIO, J_A, J_B = -1.7, 0.31, 0.12


def gear_train(rng, load):
    """Two wheels on general axes, in gear; ``load(wheel, hinge)`` of the first one."""
    axes, places = [direction(rng), direction(rng)], [rng.normal(size=3), rng.normal(size=3)]
    first, second = (
        wheel(rng, name, at, axis, J)
        for name, at, axis, J in zip(("first", "second"), places, axes, (J_A, J_B), strict=True)
    )
    hinges = [
        Revolute(GROUND, body, at=at + 0.3 * axis, axis=axis)
        for body, at, axis in zip((first, second), places, axes, strict=True)
    ]
    gear = Gear(*hinges, ratio=RATIO)
    return System(bodies=[first, second], joints=[*hinges, gear], forces=[load(first, hinges[0])]), gear


def test_gear_reflects_inertia_over_many_turns():
    rng = np.random.default_rng(34)
    system, gear = gear_train(rng, lambda body, hinge: Torque(body, 5.0 * hinge.axis))
    solution = simulate(system, 3.0, rtol=RTOL, output=31)
    alpha = 5.0 / (J_A + RATIO**2 * J_B)
    first, second, _ = system.joints
    angle = alpha * solution.t**2 / 2
    assert angle[-1] > 5 * 2 * np.pi
    # rounding and projection over five and nine turns
    assert solution.angle(first) == pytest.approx(angle, abs=1e-10)
    assert solution.angle(second) == pytest.approx(RATIO * angle, abs=1e-10)
    mesh = solution.reaction(gear)
    torque = RATIO * J_B * alpha * second.axis
    assert mesh.moment == pytest.approx(np.tile(torque, (31, 1)), abs=REACTIONS)
    assert np.abs(mesh.force).max() < 1e-12  # a pure moment


def test_gear_train_is_one_body_with_the_reflected_inertia():
    rng = np.random.default_rng(35)
    system, _ = gear_train(rng, lambda body, hinge: TorsionSpring(hinge, stiffness=2.3, angle=8.0))
    solution = simulate(system, 4.0, rtol=RTOL, output=31)
    axis = direction(rng)
    alone = wheel(rng, "alone", rng.normal(size=3), axis, J_A + RATIO**2 * J_B)
    hinge = Revolute(GROUND, alone, at=alone.position + matrix(alone.orientation) @ alone.com, axis=axis)
    single = System(bodies=[alone], joints=[hinge], forces=[TorsionSpring(hinge, stiffness=2.3, angle=8.0)])
    twin = simulate(single, 4.0, rtol=RTOL, output=31)
    closed = 8.0 * (1 - np.cos(np.sqrt(2.3 / (J_A + RATIO**2 * J_B)) * twin.t))
    # swings of 16 rad: relative 1e-11
    assert solution.angle(system.joints[0]) == pytest.approx(twin.angle(hinge), abs=1e-9)
    assert twin.angle(hinge) == pytest.approx(closed, abs=1e-9)


def test_screw_turns_weight_into_spin():
    """(J + m p^2) theta_ddot = m p g.u with p = pitch / 2 pi, also with the centre of mass off the axis."""
    rng = np.random.default_rng(36)
    body = random_body(rng, "nut")
    axis, at, pitch, g = direction(rng), body.position + 0.3 * direction(rng), 0.9, 9.3
    screw = Screw(GROUND, body, at=at, axis=axis, pitch=pitch)
    system = System(bodies=[body], joints=[screw], gravity=g * axis)
    R = matrix(body.orientation)
    arm = np.cross(axis, body.position + R @ body.com - at)
    J = axis @ R @ body.inertia @ R.T @ axis + body.mass * arm @ arm
    p = pitch / (2 * np.pi)
    alpha = body.mass * p * g / (J + body.mass * p**2)
    solution = simulate(system, 3.0, rtol=RTOL, output=31)
    angle = alpha * solution.t**2 / 2
    assert angle[-1] > 2 * np.pi
    assert solution.angle(screw) == pytest.approx(angle, abs=1e-10)  # of up to 10 rad
    assert solution.slide(screw) == pytest.approx(p * angle, abs=1e-10)


def test_rack_falls_while_it_turns_its_pinion():
    """(m + J / r^2) s_ddot = m g.u; the teeth carry what is left of the weight."""
    rng = np.random.default_rng(37)
    axis, slope, at = direction(rng), direction(rng), rng.normal(size=3)
    pinion, rack = wheel(rng, "pinion", at, axis, 0.14), random_body(rng, "rack")
    hinge = Revolute(GROUND, pinion, at=at, axis=axis)
    slider = Prismatic(GROUND, rack, at=rack.position, axis=slope)
    mesh = RackPinion(hinge, slider, radius=0.22)
    system = System(bodies=[pinion, rack], joints=[hinge, slider, mesh])
    pull = system.gravity @ slope
    acceleration = rack.mass * pull / (rack.mass + 0.14 / 0.22**2)
    solution = simulate(system, 2.0, rtol=RTOL, output=21)
    way = acceleration * solution.t**2 / 2
    assert abs(way[-1]) / 0.22 > 2 * np.pi
    assert solution.slide(slider) == pytest.approx(way, abs=1e-10)  # of up to 10 m
    assert solution.angle(hinge) == pytest.approx(way / 0.22, abs=1e-10)
    force = rack.mass * (acceleration - pull) * slope
    assert solution.reaction(mesh).force == pytest.approx(np.tile(force, (21, 1)), abs=REACTIONS)


def test_far_from_the_origin_steps_are_as_long():
    """Shifted by 1.3e6 m it took 3 million steps for 100: errors of the angular impulse about the origin counted."""
    shift = 1e6 * np.array([1.0, -0.7, 0.3])
    near, far = (simulate(pair_at(k * shift), 2.0, rtol=1e-8, output=5) for k in (0.0, 1.0))
    assert far.certificate.passed and far.certificate.steps < 1.2 * near.certificate.steps
    apart = far.position("bob") - near.position("bob") - shift
    # 1e-10 m is a unit in the last place of a place there; rtol 1e-8 of a run of 2 s leaves less than 1e-6
    assert np.abs(apart).max() < 1e-6
