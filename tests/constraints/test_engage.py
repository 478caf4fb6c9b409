"""Joints that engage and let go at the pose of the moment, against momenta in closed form."""

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Breaks,
    Clutch,
    Cylindrical,
    Distance,
    Fixed,
    Gear,
    Planar,
    PointOnLine,
    Prismatic,
    Revolute,
    Screw,
    Sine,
    Spherical,
    State,
    Switched,
    System,
    TorsionSpring,
    Universal,
    measures,
    rotation,
    simulate,
)  # fmt: skip
from mbsd3d.rotations import matrix, multiply

TURNED = rotation((0.3, -0.5, 0.8), 1.1)  # of whole cases, so that nothing lies along an axis
R = matrix(TURNED)
PLACE = np.array([0.7, -1.3, 0.4])
START = rotation((1, 2, -1), 0.6)


def placed(name, mass, inertia, r, offset=(0.11, -0.07, 0.05), **motion):
    """Return a body whose centre of mass is at R r + PLACE, principal axes along those of R, and its pose there.

    Its reference point and axes are others: O is off the centre of mass, axes are turned, and the reference pose is not
    the pose asked for.
    """
    own = rotation((0.2, 1.0, 0.4), 0.9)  # body axes in the principal axes
    C = matrix(own).T @ np.diag(inertia) @ matrix(own)
    com = np.array(offset)
    body = Body(name, mass, C, com=com, position=(0.3, 0.2, -0.4), orientation=START, **motion)
    e = multiply(TURNED, own)
    return body, np.concatenate([R @ r + PLACE - matrix(e) @ com, e])


def velocity_of(body, q, v, w):
    """Return (velocity of O, angular velocity), world, of a body whose centre of mass moves with R v, R w."""
    arm = matrix(q[3:]) @ body.com
    return np.concatenate([R @ v - np.cross(R @ w, arm), R @ w])


def momenta(system, state):
    """Return (linear momentum, angular momentum about the origin, kinetic energy)."""
    p, L, T = np.zeros(3), np.zeros(3), 0.0
    for body, q, v in zip(system.bodies, state.q.reshape(-1, 7), state.v.reshape(-1, 6), strict=True):
        A = matrix(q[3:])
        arm, I = A @ body.com, A @ body.inertia @ A.T
        v_G = v[:3] + np.cross(v[3:], arm)
        p += body.mass * v_G
        L += np.cross(q[:3] + arm, body.mass * v_G) + I @ v[3:]
        T += 0.5 * body.mass * v_G @ v_G + 0.5 * v[3:] @ I @ v[3:]
    return p, L, T


def test_two_free_bodies_are_joined():
    one, q1 = placed("one", 2.0, (0.1, 0.2, 0.25), np.zeros(3))
    two, q2 = placed("two", 3.0, (0.3, 0.15, 0.2), np.array([0.4, 0.3, 0.1]))
    v = [velocity_of(one, q1, (1.0, 0.5, -0.2), (0, 0, 3.0)), velocity_of(two, q2, (-0.5, 0, 0.3), (1.0, -2.0, 0))]
    system = System([one, two], gravity=(0, 0, 0))
    state = State(1.3, np.concatenate([q1, q2]), np.concatenate(v))
    joined = system.engage(Fixed(one, two, at=(5.0, 1.0, 2.0), name="weld"), state)
    w = R.T @ joined.state.v.reshape(2, 6)[0, 3:]
    v_G = R.T @ (joined.state.v[:3] + np.cross(joined.state.v[3:6], matrix(q1[3:]) @ one.com))
    assert np.abs(w - (0.8988730687670403, -0.9743229324447134, 1.410760375643744)).max() < 1e-12
    assert np.abs(v_G - (0.4123962435625568, -0.08465010602847617, -0.2956346561647985)).max() < 1e-12
    assert abs(joined.lost - 1.8908988185398372) < 1e-12 and joined.work == pytest.approx(0.0, abs=1e-12)
    before, after = momenta(system, state), momenta(system, joined.state)
    assert np.abs(before[0] - after[0]).max() < 3e-14 and np.abs(before[1] - after[1]).max() < 3e-14
    assert abs(before[2] - after[2] - joined.lost) < 1e-13
    assert np.array_equal(joined.state.q, state.q)
    impulse = joined.impulse
    p2 = momenta(System([two]), State(0.0, q2, joined.state.v[6:]))[0] - momenta(System([two]), State(0.0, q2, v[1]))[0]
    assert impulse.unique and np.abs(impulse.force - p2).max() < 1e-13
    run = simulate(joined.system, 3.0, state=joined.state)
    assert run.certificate.passed
    assert np.abs(run.omega("one") - run.omega("two")).max() < 1e-9


def double_pendulum(a, b, u, v):
    """Return a plane double pendulum across the axes, and its state at the angles a, b from straight down."""
    n, down, across = R[:, 1], -R[:, 2], R[:, 0]
    bodies = []
    for name, m, l, I, at in (("upper", 2.0, 0.3, 0.05, 0.0), ("lower", 1.0, 0.25, 0.02, 0.6)):
        C = R @ np.diag([I, I, 0.3 * I]) @ R.T
        bodies.append(Body(name, m, C, com=down * l, position=PLACE + down * at))
    upper, lower = bodies
    shoulder = Revolute(GROUND, upper, at=PLACE, axis=-n, name="shoulder")
    elbow = Revolute(upper, lower, at=lower.position, axis=-n, name="elbow")
    system = System(bodies, [shoulder, elbow], gravity=9.81 * down)
    state = system.assemble(angles={shoulder: a, elbow: b - a}, rates={shoulder: u, elbow: v - u})
    return system, state, across


@pytest.mark.parametrize("turns", [0, 3])
def test_an_elbow_locks_in_flight(turns):
    system, state, _ = double_pendulum(0.7, -0.2 + 2 * np.pi * turns, 2.0, -3.0)
    upper, lower = system.bodies
    locked = system.engage(Fixed(lower, upper, at=(0, 0, 0), name="lock"), state)
    rates = locked.state.v.reshape(2, 6)[:, 3:] @ -R[:, 1]
    assert np.abs(rates - 0.977037396618588).max() < 1e-13
    assert abs(locked.lost - 0.5818075562663353) < 1e-13
    assert not locked.impulse.unique  # the elbow and the lock share it
    run = simulate(locked.system, 0.8, state=locked.state)
    assert run.certificate.passed
    assert np.abs(run.angle("elbow") - (-0.9 + 2 * np.pi * turns)).max() < 1e-9
    again = locked.system.release("lock", run.final)
    assert simulate(again.system, 0.2 + again.state.t, state=again.state).certificate.passed
    assert abs(again.state.coordinates[1] - (-0.9 + 2 * np.pi * turns)) < 1e-9


def test_a_lock_about_the_hinge_alone_has_a_determined_impulse():
    """A coupling row takes the angular impulse about the axis, which the elbow does not."""
    system, state, _ = double_pendulum(0.7, -0.2 + 4 * np.pi, 2.0, -3.0)
    shoulder, elbow = system.joints
    locked = system.engage(Gear(shoulder, elbow, ratio=1.7, name="gear"), state)
    rates = locked.state.v.reshape(2, 6)[:, 3:] @ -R[:, 1]
    assert abs(rates[1] - 2.7 * rates[0]) < 1e-12
    # generalised momenta of the two angles, mapped by (1, 2.7) onto what is left
    c = 0.6 * 0.25 * np.cos(0.9)
    M = np.array([[0.05 + 2.0 * 0.09 + 0.36, c], [c, 0.02 + 0.0625]])
    way, before = np.array([1.0, 2.7]), np.array([2.0, -3.0])
    expected = way @ M @ before / (way @ M @ way)
    assert abs(rates[0] - expected) < 1e-12
    change = M @ (expected * way - before)
    assert abs(abs(locked.impulse.moment @ R[:, 1]) - abs(change[1])) < 1e-12 and locked.impulse.unique
    run = simulate(locked.system, 1.5, state=locked.state)
    assert run.certificate.passed
    turned = run.angle("elbow") - run.angle("elbow")[0] - 1.7 * (run.angle("shoulder") - run.angle("shoulder")[0])
    assert np.abs(turned).max() < 1e-8


def test_a_door_falls_into_its_latch():
    m, l, I, d, w = 20.0, 0.45, 5.4, 0.85, 1.8
    hinge_axis, out = R[:, 2], R[:, 0]
    inertia = R @ np.diag([1.0, 2.0, I - m * l * l]) @ R.T
    door = Body("door", m, inertia, com=l * out, position=PLACE)
    hinge = Revolute(GROUND, door, at=PLACE, axis=hinge_axis, name="hinge")
    system = System([door], [hinge], gravity=(0, 0, 0))
    state = system.assemble(angles={hinge: -2.4}, rates={hinge: w})
    swung = matrix(rotation(hinge_axis, -2.4)) @ out
    latch = PointOnLine(GROUND, door, at=PLACE + d * swung, axis=swung, name="latch")
    caught = system.engage(latch, state)
    assert np.abs(caught.state.v).max() < 1e-13 and abs(caught.lost - 8.748) < 1e-12
    side = np.cross(hinge_axis, swung)
    assert abs(caught.impulses["latch"].force @ side + 11.435294117647059) < 1e-10
    assert abs(caught.impulses["hinge"].force @ side + 4.764705882352941) < 1e-10


def test_a_falling_bar_is_caught_at_its_end():
    m, I, s, v, w = 2.0, 0.1666, 0.5, -4.0, 1.5
    bar, q = placed("bar", m, (I, 0.5 * I + 0.02, I), np.zeros(3))
    state = State(0.0, q, velocity_of(bar, q, (0, v, 0), (0, 0, w)))
    system = System([bar])
    caught = system.engage(Spherical(GROUND, bar, at=PLACE - s * R[:, 0], name="pin"), state)
    assert np.abs(R.T @ caught.state.v[3:] - (0, 0, -5.625712571257126)).max() < 1e-12
    assert abs(caught.lost - 5.638932643264327) < 1e-12
    assert np.abs(R.T @ caught.impulse.force - (0, 2.3742874287428744, 0)).max() < 1e-12
    assert abs(np.linalg.norm(caught.impulse.point - (PLACE - s * R[:, 0]))) < 1e-12


JOINTS = [
    lambda a, b: Revolute(a, b, at=(0.2, 0.3, -0.1), axis=(1, 2, -0.5)),
    lambda a, b: Prismatic(a, b, at=(0.2, 0.3, -0.1), axis=(1, 2, -0.5)),
    lambda a, b: Cylindrical(a, b, at=(0.2, 0.3, -0.1), axis=(1, 2, -0.5)),
    lambda a, b: Screw(a, b, at=(0.2, 0.3, -0.1), axis=(1, 2, -0.5), pitch=0.02),
    lambda a, b: Universal(a, b, at=(0.2, 0.3, -0.1), axis_a=(1, 2, 2), axis_b=(2, 1, -2)),
    lambda a, b: Planar(a, b, at=(0.2, 0.3, -0.1), normal=(1, 2, -0.5)),
    lambda a, b: Distance(a, b, at_a=(0.2, 0.3, -0.1), at_b=(0.1, 0.9, 0.3)),
    lambda a, b: Fixed(a, b, at=(0.2, 0.3, -0.1)),
]


@pytest.mark.parametrize("make", JOINTS, ids=lambda make: type(make(*(Body(n, 1, (1, 1, 1)) for n in "ab"))).__name__)
def test_joints_hold_the_pose_at_which_they_engage(make, tmp_path):
    one, q1 = placed("one", 2.0, (0.1, 0.2, 0.25), np.zeros(3))
    two, q2 = placed("two", 3.0, (0.3, 0.15, 0.2), np.array([0.4, 0.3, 0.1]))
    v = [velocity_of(one, q1, (1.0, 0.5, -0.2), (0, 0, 3.0)), velocity_of(two, q2, (-0.5, 0, 0.3), (1.0, -2.0, 0))]
    system = System([one, two])
    state = State(0.0, np.concatenate([q1, q2]), np.concatenate(v))
    joined = system.engage(make(one, two), state)
    before, after = momenta(system, state), momenta(system, joined.state)
    assert np.abs(before[0] - after[0]).max() < 1e-12 and np.abs(before[1] - after[1]).max() < 1e-12
    assert 0.0 < joined.lost == pytest.approx(before[2] - after[2], abs=1e-12)
    run = simulate(joined.system, 1.0, state=joined.state)
    assert run.certificate.passed
    file = joined.system.to_file(tmp_path / "joined.toml")
    same = simulate(System.from_file(file), 1.0, state=joined.state)
    assert np.array_equal(run.position("one"), same.position("one"))


def test_a_distance_keeps_its_points_and_takes_the_length_of_the_moment():
    one, q1 = placed("one", 2.0, (0.1, 0.2, 0.25), np.zeros(3))
    two, q2 = placed("two", 3.0, (0.3, 0.15, 0.2), np.array([0.4, 0.3, 0.1]))
    system, state = System([one, two]), State(0.0, np.concatenate([q1, q2]), np.zeros(12))
    rod = Distance(one, two, at_a=one.position, at_b=two.position + (0.0, 0.2, 0.0), name="rod", length=9.0)
    joined = system.engage(rod, state)
    end = q2[:3] + matrix(q2[3:]) @ two.local_point(two.position + (0.0, 0.2, 0.0))
    assert joined.joint.length == pytest.approx(np.linalg.norm(q1[:3] - end), rel=1e-14)


def test_hinges_count_from_where_they_engage_and_carry_springs():
    system, state, _ = double_pendulum(0.7, -0.2, 2.0, -3.0)
    upper, lower = system.bodies
    free = system.release("elbow", state)
    caught = free.system.engage(Revolute(lower, upper, at=lower.position, axis=(R @ (0, 1, 0)), name="new"), free.state)
    with_spring = System(
        caught.system.bodies, caught.system.joints, [TorsionSpring(caught.joint, stiffness=5.0)],
        gravity=caught.system.gravity,
    )  # fmt: skip
    run = simulate(with_spring, 0.7, state=caught.state)
    assert abs(run.angle("new")[0]) < 1e-12 and run.certificate.passed
    assert caught.lost == pytest.approx(0.0, abs=1e-12)  # the same hinge: nothing is lost


def test_drivers_work_in_the_impact():
    a, b = (Body(n, 1.0, (0.2, 0.3, 0.4), com=(0.1, 0, 0.2), position=(0.5 * k, 0, 0)) for k, n in enumerate("ab"))
    hinges = [Revolute(GROUND, x, at=x.position, axis=(0.2, 0.4, 1.0), name=x.name + " hinge") for x in (a, b)]
    motor = AngleDriver(hinges[0], Sine(0.4, 2.0), name="motor")
    system = System([a, b], [*hinges, motor], gravity=(0, 0, 0))
    start = system.assemble(rates={hinges[1]: -1.0})
    meshed = system.engage(Gear(*hinges, ratio=-0.5, name="mesh"), start)
    rate = 0.4 * 2 * np.pi * 2.0
    axis = np.array([0.2, 0.4, 1.0]) / np.linalg.norm((0.2, 0.4, 1.0))
    rates = meshed.state.v.reshape(2, 6)[:, 3:] @ axis
    assert np.abs(rates - (rate, -0.5 * rate)).max() < 1e-12
    I = axis @ b.inertia @ axis + 1.0 * np.linalg.norm(np.cross(axis, b.com)) ** 2
    L = I * (-0.5 * rate + 1.0)  # of the tooth on b, whose share through the ratio the motor pays at its rate
    assert meshed.lost == pytest.approx(0.5 * I * (-0.5 * rate + 1.0) ** 2, rel=1e-12)
    assert meshed.work == pytest.approx(-0.5 * L * rate, rel=1e-11)
    assert simulate(meshed.system, 0.5, state=meshed.state).certificate.passed


def test_a_broken_pin_is_released_and_mended_by_hand():
    """The other pin, without a name as the first, stays broken or whole as it was."""
    axis, bodies = (0.2, 1.0, 0.1), [Body(name, 2.0, (0.05, 0.06, 0.07), com=(0.5, 0.1, 0.2)) for name in ("a", "b")]
    first, other = (Breaks(Spherical(GROUND, bodies[k], at=(0, 0, 0)), force=f) for k, f in enumerate((1e3, 30.0)))
    system = System(bodies, [first, other])
    run = simulate(system, 1.0)
    assert [event.what for event in run.events] == [f"'{system.name(other)}' breaks"]
    with pytest.raises(ValueError, match="release this one first"):
        system.engage(other, run.final)
    for gone, stays in ((first, other), (other, first)):
        freed = system.release(gone, run.final)
        kept = freed.state.modes[freed.system.name(stays)]
        assert kept == run.final.modes[system.name(stays)]
        assert len(freed.state.modes) == 1
        body = gone.bodies()[1]
        mended = freed.system.engage(Revolute(GROUND, body, at=(0, 0, 0), axis=axis, name="new"), freed.state)
        after = simulate(mended.system, 1.5, state=mended.state)
        assert after.certificate.passed, str(after.certificate)


def test_a_latch_that_has_engaged_in_a_run_takes_part_in_an_impact_by_hand():
    """Two wheels that a `Switched` has joined turn as one when a third is engaged; momentum is kept."""
    axis, inertias = np.array([0.2, 0.4, 1.0]), (0.3, 0.2, 0.5)
    axis /= np.linalg.norm(axis)
    wheels = [Body(name, 1.0, (I, I, I)) for name, I in zip("abc", inertias, strict=True)]
    hinges = [Revolute(GROUND, wheel, at=(0, 0, 0), axis=axis, name=f"hinge {wheel.name}") for wheel in wheels]
    dog = Switched(Gear(hinges[0], hinges[1], ratio=1.0), engage=measures.angle(hinges[0]) > 1.0, name="dog")
    system = System(wheels, [*hinges, dog])
    run = simulate(system, 1.0, state=system.assemble(rates={hinges[0]: 2.0}))
    assert run.final.modes["dog"].name == "engaged"
    met = system.engage(Gear(hinges[1], hinges[2], ratio=1.0, name="third"), run.final)
    rates = met.state.v.reshape(3, 6)[:, 3:] @ axis
    assert np.allclose(rates, 0.3 * 2.0 / 1.0, rtol=1e-12, atol=0.0)
    assert met.lost == pytest.approx(0.5 * 0.5 * (0.3 * 2.0 / 0.5) ** 2 - 0.5 * 1.0 * 0.6**2, rel=1e-12)
    after = simulate(met.system, 2.0, state=met.state)
    assert after.certificate.passed, str(after.certificate)
    assert not after.events


def test_a_locked_clutch_slips_at_an_impact_by_hand_and_locks_again():
    """Its torque is finite: wheels a and c meet alone, and 0.75 * 0.16 / 50 s later all three turn as one."""
    a, b, c = (Body(name, 1.0, (I, I, I)) for name, I in zip("abc", (0.3, 0.2, 0.5), strict=True))
    hinges = [
        Revolute(x, y, at=(0, 0, 0), axis=(1, 2, 3), name=f"to {y.name}") for x, y in ((GROUND, a), (a, b), (GROUND, c))
    ]
    clutch = Clutch(hinges[1], torque=50.0, engaged=True, name="clutch")
    system = System([a, b, c], hinges, [clutch])
    run = simulate(system, 1.0, state=system.assemble(rates={hinges[0]: 2.0, hinges[1]: -2.0}))
    assert run.final.modes["clutch"].name == "held"
    met = system.engage(Gear(hinges[0], hinges[2], ratio=1.0, name="third"), run.final)
    after = simulate(met.system, 2.0, state=met.state)
    assert [event.what for event in after.events] == ["'clutch' locks"]
    assert after.events[0].t == pytest.approx(1.0 + 0.75 * 0.16 / 50.0, rel=1e-9)
    assert np.allclose([after.rate(hinges[0])[-1], after.rate(hinges[1])[-1]], [0.6, 0.0], rtol=1e-9, atol=1e-12)
    assert after.certificate.passed, str(after.certificate)


def test_assemble_near_a_state_of_a_run_keeps_what_has_engaged_or_broken():
    a, b = (Body(name, 1.0, (I, I, I)) for name, I in zip("ab", (0.3, 0.2), strict=True))
    hinges = [Revolute(GROUND, wheel, at=(0, 0, 0), axis=(1, 2, 3), name=f"hinge {wheel.name}") for wheel in (a, b)]
    dog = Switched(Gear(*hinges, ratio=1.0), engage=measures.angle(hinges[0]) > 1.0, name="dog")
    system = System([a, b], [*hinges, dog])
    run = simulate(system, 1.0, state=system.assemble(rates={hinges[0]: 2.0}))
    near = system.assemble(near=run.final, rates={hinges[0]: 3.0})
    assert near.modes == run.final.modes
    after = simulate(system, 2.0, state=near)
    assert np.allclose([after.rate(hinge)[-1] for hinge in hinges], 3.0, rtol=1e-12, atol=0.0)
    bob = Body("bob", 2.0, (0.05, 0.06, 0.07), com=(0.5, 0.1, 0.2))
    pin = Breaks(Spherical(GROUND, bob, at=(0, 0, 0)), force=30.0, name="pin")
    hung = System([bob], [pin])
    fallen = simulate(hung, 1.0)
    again = hung.assemble(near=fallen.final)
    assert again.modes["pin"].name == "open"
    assert np.allclose(again.q, fallen.final.q, rtol=0.0, atol=1e-12)


def test_what_cannot_engage_is_refused():
    system, state, _ = double_pendulum(0.7, -0.2, 2.0, -3.0)
    upper, lower = system.bodies
    shoulder, elbow = system.joints
    other = Body("other", 1.0, (1, 1, 1))
    for joint, text in (
        (elbow, "in the system already"), (AngleDriver(elbow, 0.0), "is a driver"), ("elbow", "is not a joint"),
        (Fixed(upper, other, at=(0, 0, 0)), "body 'other' is not in the system"),
        (Breaks(Fixed(upper, lower, at=(0, 0, 0)), force=1.0, name="bolt"), "'bolt' switches by itself.*joint in it"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=text):
            system.engage(joint, state)
    for wrong, text in (
        (None, "not a State"), ("now", "not a State"), (System([other]).state(), "1 body, the system has 2"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=text):
            system.engage(Fixed(upper, lower, at=(0, 0, 0)), wrong)
        with pytest.raises(ValueError, match=text):
            system.release(elbow, wrong)
    moved = State(state.t, state.q + np.eye(14)[0] * 0.01, state.v, coordinates=state.coordinates)
    with pytest.raises(ValueError, match="do not close"):
        system.engage(Fixed(upper, lower, at=(0, 0, 0)), moved)
    geared = system.engage(Gear(shoulder, elbow, ratio=2.0), state).system
    with pytest.raises(ValueError, match="acts through 'elbow'"):
        geared.release("elbow", state)
