"""Reflected inertias of hinges and slides beside rotors on the ground that are geared to them, and beside theory."""

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    EndStop,
    Engaged,
    Fixed,
    Gear,
    GeneralizedAlpha,
    Kinematic,
    Parallel,
    Prismatic,
    RackPinion,
    RadauIIA,
    Revolute,
    Sine,
    Spherical,
    State,
    System,
    TorqueBetween,
    accelerations,
    linearize,
    rotation,
    simulate,
)

ROUNDING = 1e-11  # [1] of accelerations: that of light rotors beside bodies of some kg
TURN = rotation((1, 2, -1), 0.7)


def bodies(count, seed=3):
    rng = np.random.default_rng(seed)
    return [
        Body(f"body {k}", 1.0 + k, 0.05 * np.array([2.0, 3.0, 4.0]), com=0.1 * rng.normal(size=3),
             position=rng.normal(size=3), orientation=TURN)
        for k in range(count)
    ]  # fmt: skip


def with_rotors(system):
    """The same system with a rotor on the ground, geared 1 to 1, in place of each reflected inertia."""
    rotors, joints, known = [], [], {}
    for joint in system.joints:
        I, plain = 0.0, joint
        if isinstance(joint, Revolute) and joint.reflected_inertia:
            I = joint.reflected_inertia
            plain = Revolute(joint.a, joint.b, at=joint.at, axis=joint.axis, name=joint.name)
        elif isinstance(joint, Prismatic) and joint.reflected_mass:
            I = joint.reflected_mass
            plain = Prismatic(joint.a, joint.b, at=joint.at, axis=joint.axis, name=joint.name)
        elif isinstance(joint, AngleDriver):
            plain = AngleDriver(known[joint.hinge.name], joint.signal, name=joint.name)
        known[joint.name] = plain
        joints.append(plain)
        if I:
            rotors.append(Body(f"rotor {joint.name}", 1e-6, (I, I, I)))
            axle = Revolute(GROUND, rotors[-1], at=(0, 0, 0), axis=(0, 0, 1), name=f"axle {joint.name}")
            tie = (
                Gear(axle, plain, ratio=1.0, name=f"gear {joint.name}")
                if isinstance(plain, Revolute)
                else RackPinion(axle, plain, radius=1.0, name=f"gear {joint.name}")
            )
            joints += [axle, tie]
    return System([*system.bodies, *rotors], joints, system.forces, gravity=system.gravity)


def chain(floating, *, driven=False):
    """Five bodies in a chain and a branch, joints taken in both directions."""
    b = bodies(5)
    joints = (
        [] if floating else [Revolute(GROUND, b[0], at=b[0].position, axis=(1, 2, 2), reflected_inertia=0.7, name="a")]
    )
    joints += [
        Revolute(b[0], b[1], at=b[1].position, axis=(1, 0, 2), reflected_inertia=0.5, name="b"),
        Prismatic(b[2], b[1], at=b[2].position, axis=(0, 1, 2), reflected_mass=1.4, name="c"),
        Revolute(b[2], b[3], at=b[3].position, axis=(1, 0, -2), reflected_inertia=0.3, name="d"),
        Spherical(b[1], b[4], at=b[4].position, name="e"),
    ]
    if driven:
        joints.append(AngleDriver(joints[-2], Sine(amplitude=0.3, frequency=2.0), name="motor"))
    return System(b, joints, gravity=(0.4, -0.8, -9.6))


@pytest.mark.parametrize("floating", [False, True])
def test_it_is_a_rotor_on_the_ground(floating):
    """Accelerations and unique reactions of the chain, moving; the tie of the rotor loads no bearing."""
    system = chain(floating)
    other = with_rotors(system)
    rates = {"b": 3.0, "c": -1.2, "d": 4.0} | ({} if floating else {"a": -2.0})
    one, two = (
        accelerations(each, each.assemble(angles={"b": 0.6, "d": -4.0}, rates=rates)) for each in (system, other)
    )
    for body in system.bodies:
        scale = np.abs(two.alpha(body)).max() + np.abs(two.acceleration(body)).max()
        assert np.abs(one.alpha(body) - two.alpha(body)).max() < ROUNDING * scale
        assert np.abs(one.acceleration(body) - two.acceleration(body)).max() < ROUNDING * scale
    for joint in system.joints:
        pair = one.reaction(joint), two.reaction(joint.name)
        assert np.allclose(pair[0].force, pair[1].force, rtol=1e-9, atol=1e-9)
        assert np.allclose(pair[0].moment, pair[1].moment, rtol=1e-9, atol=1e-9)
    assert one.certificate.passed
    assert np.isclose(one.energy().kinetic[0], two.energy().kinetic[0], rtol=1e-9, atol=0)


def test_a_driven_hinge_carries_its_rotor():
    """The effort contains I times the acceleration; the joint itself feels none of it."""
    system = chain(False, driven=True)
    one, two = (
        simulate(each, 0.3, state=each.assemble(), rtol=1e-10, output=5) for each in (system, with_rotors(system))
    )
    assert np.allclose(one.effort("motor"), two.effort("motor"), rtol=1e-6, atol=1e-7)
    assert np.allclose(one.position(system.bodies[3]), two.position(system.bodies[3]), rtol=0, atol=1e-8)
    assert one.certificate.passed and two.certificate.passed
    b = bodies(1)
    hinge = Revolute(GROUND, b[0], at=b[0].centre, axis=(0, 0, 1), reflected_inertia=2.0)
    spun = System(b, [hinge, AngleDriver(hinge, Sine(amplitude=0.3, frequency=1.0), name="motor")])
    run = simulate(spun, 0.6, method=Kinematic(), output=7)
    alpha = -0.3 * (2 * np.pi) ** 2 * np.sin(2 * np.pi * run.t)
    R = run.rotation(b[0])
    axial = np.einsum("tij,jk,tlk->til", R, b[0].inertia, R)[:, 2, 2]
    assert np.allclose(run.effort("motor"), (2.0 + axial) * alpha, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("method", [None, GeneralizedAlpha(2e-3), RadauIIA()])
@pytest.mark.parametrize("floating", [False, True])
def test_energy_and_momentum_balance_in_every_method(floating, method):
    system = chain(floating)
    start = system.assemble(rates={"b": 3.0, "c": -1.2, "d": 4.0})
    run = simulate(system, 0.5, state=start, **({} if method is None else {"method": method}))
    assert run.certificate.passed, run.certificate


def balls(floating):
    """Five bodies on balls and a hinge, joints taken in both directions, the last one at the end of a branch."""
    b = bodies(5, seed=8)
    joints = [] if floating else [Spherical(GROUND, b[0], at=(0.2, 0.1, 0.3), reflected_inertia=0.7, name="a")]
    joints += [
        Spherical(b[0], b[1], at=(0.4, 0.1, -0.3), reflected_inertia=0.5, name="b"),
        Revolute(b[1], b[2], at=b[2].position, axis=(1, 0, 2), reflected_inertia=0.3, name="c"),
        Spherical(b[3], b[2], at=(0.6, -0.1, 0.2), reflected_inertia=1.4, name="d"),
        Spherical(b[1], b[4], at=b[4].position, name="e"),
    ]
    return System(b, joints, gravity=(0.4, -0.8, -9.6))


def spun(system, seed=2):
    """A general state: all poses on the constraints, velocities of some m/s and rad/s."""
    state = system.assemble()
    v = 3.0 * np.random.default_rng(seed).normal(size=state.v.size)
    return system.assemble(near=State(0.0, state.q, v))


@pytest.mark.parametrize("floating", [False, True])
def test_a_ball_has_rotors_about_three_axes(floating):
    """-I d(w_rel)/dt in the axes of b on b, its opposite on a: put on the plain system as a moment, it moves alike."""
    system = balls(floating)
    state = spun(system)
    one = accelerations(system, state)
    ends, plain, loads = {}, [], []
    for joint in system.joints:
        I = joint.reflected_inertia
        x = joint
        if isinstance(joint, Spherical):
            x = Spherical(joint.a, joint.b, at=joint.at, name=joint.name)
            (alpha_a, w_a), (alpha_b, w_b) = (
                (np.zeros(3), np.zeros(3)) if body is GROUND else (one.alpha(body)[0], one.omega(body)[0])
                for body in (joint.a, joint.b)
            )
            load = -I * (alpha_b - alpha_a - np.cross(w_b, w_b - w_a))
            loads.append(TorqueBetween(joint.a, joint.b, load, frame="world", name=f"rotor {joint.name}"))
            ends[joint.name] = 0.5 * I * ((w_b - w_a) ** 2).sum()
        plain.append(x)
    two = accelerations(System(system.bodies, plain, loads, gravity=system.gravity), state)
    for body in system.bodies:
        size = np.abs(two.alpha(body)).max() + np.abs(two.acceleration(body)).max()
        assert np.abs(one.alpha(body) - two.alpha(body)).max() < ROUNDING * size
        assert np.abs(one.acceleration(body) - two.acceleration(body)).max() < ROUNDING * size
    for joint in system.joints:  # the joint itself carries no moment of its rotors
        pair = one.reaction(joint), two.reaction(joint.name)
        assert np.allclose(pair[0].force, pair[1].force, rtol=1e-9, atol=1e-9)
        assert np.allclose(pair[0].moment, pair[1].moment, rtol=1e-9, atol=1e-9)
    assert one.certificate.passed
    assert one.energy().kinetic[0] == pytest.approx(two.energy().kinetic[0] + sum(ends.values()), rel=1e-12)


@pytest.mark.parametrize("method", [None, GeneralizedAlpha(2e-3), RadauIIA()])
@pytest.mark.parametrize("floating", [False, True])
def test_energy_and_momentum_of_balls_balance_in_every_method(floating, method):
    system = balls(floating)
    run = simulate(system, 0.3, state=spun(system), **({} if method is None else {"method": method}))
    assert run.certificate.passed, run.certificate


def test_a_ball_that_turns_about_one_axis_is_a_hinge():
    """The rows of other joints hold its axis: one direction is left, and three rotors turn it as one."""
    made = []
    for ball in (False, True):
        one, two = bodies(2)
        at, axis = (0.3, 0.1, 0.2), np.array([1.0, 2.0, 2.0]) / 3.0
        first = Spherical(GROUND, one, at=one.position, reflected_inertia=0.3, name="first")
        hinge = Revolute(one, two, at=at, axis=axis, reflected_inertia=0.8, name="hinge")
        parts = [Spherical(one, two, at=at, reflected_inertia=0.8, name="ball"), Parallel(one, two, axis=axis)]
        made.append(System([one, two], [first, *(parts if ball else [hinge])]))
    w = np.array([2.0, -1.0, 0.5])
    found = []
    for system in made:
        state = system.assemble(near=State(0.0, system.state().q, np.concatenate([np.zeros(3), w, np.zeros(3), 2 * w])))
        found.append(accelerations(system, state))
    for k in range(2):
        here, there = (each.alpha(each.system.bodies[k]) for each in found)
        assert np.allclose(here, there, rtol=1e-11, atol=1e-11)


def test_a_ball_may_close_a_loop():
    """All joints of a spatial four-bar have one: bodies share inertia across the loop, which balances all the same."""
    b = bodies(3, seed=4)
    joints = [
        Revolute(GROUND, b[0], at=(0, 0, 0), axis=(0.2, 1, 0), reflected_inertia=0.4, name="h"),
        Spherical(b[0], b[1], at=(0.5, 0.2, 0.3), reflected_inertia=0.6, name="s"),
        Spherical(b[2], b[1], at=(1.4, 0.1, 0.5), reflected_inertia=0.9, name="t"),
        Revolute(b[2], GROUND, at=(1.6, -0.2, 0.1), axis=(0.1, 1, 0.3), reflected_inertia=0.2, name="k"),
    ]
    system = System(b, joints)
    run = simulate(system, 0.3, state=system.assemble(rates={"h": 2.0}))
    assert run.certificate.passed, run.certificate


def four_bar():
    crank, coupler, rocker = (
        Body(n, 1.0, (0.02, 0.03, 0.03), com=(0.1, 0, 0.02)) for n in ("crank", "coupler", "rocker")
    )
    points = np.array([(0, 0, 0), (0.2, 0, 0.3), (0.9, 0, 0.5), (0.8, 0, 0)], float)
    pairs = [(GROUND, crank), (crank, coupler), (coupler, rocker)]
    joints = [
        Revolute(a, b, at=at, axis=(0, 1, 0), reflected_inertia=0.1 * (k + 1), name=f"h{k}")
        for k, ((a, b), at) in enumerate(zip(pairs, points, strict=False))
    ]
    joints.append(Revolute(rocker, GROUND, at=points[3], axis=(0, 1, 0), reflected_inertia=0.4, name="h3"))
    return System([crank, coupler, rocker], joints)


def test_loops_may_be_closed_by_such_a_joint():
    """All four hinges of a four-bar have one: bodies share inertia across the loop."""
    system = four_bar()
    other = with_rotors(system)
    runs = [
        simulate(each, 0.5, state=each.assemble(rates={"h0": 2.0}), rtol=1e-10, output=11) for each in (system, other)
    ]
    for name in ("h0", "h1", "h2", "h3"):
        assert np.allclose(runs[0].angle(name), runs[1].angle(name), rtol=0, atol=1e-8)
    assert runs[0].certificate.passed, runs[0].certificate


def test_small_motions_know_it():
    """omega^2 = m g l / (I_O + I) of a pendulum, by complex steps, with the frequency of its run."""
    bob = Body("bob", 2.0, (0.3, 0.2, 0.1), com=(0, 0, -0.4))
    hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0), reflected_inertia=0.7, name="hinge")
    system = System([bob], [hinge])
    w = np.sqrt(2.0 * 9.81 * 0.4 / (0.2 + 2.0 * 0.16 + 0.7))
    found = linearize(system).eigenvalues
    assert np.allclose(np.sort(np.abs(found.imag)), [w, w], rtol=1e-12, atol=0)
    run = simulate(system, 2.0, state=system.assemble(rates={"hinge": 1e-4}), rtol=1e-10)
    assert np.allclose(run.angle(hinge), 1e-4 / w * np.sin(w * run.t), rtol=0, atol=1e-11)


def test_the_start_and_the_impact_of_a_joint_count_it():
    """The least kinetic energy of two hinges that a gear ties, and a door that is caught: angular momentum about it."""
    one, two = (Body(name, 1.0, (0.1, 0.1, 0.2)) for name in ("one", "two"))
    a = Revolute(GROUND, one, at=(0, 0, 0), axis=(0, 0, 1), reflected_inertia=0.3, name="a")
    b = Revolute(one, two, at=(0, 0, 0), axis=(0, 0, 1), reflected_inertia=0.5, name="b")
    system = System([one, two], [a, b], gravity=(0, 0, 0))
    start = system.assemble(rates={"a": 2.0, "b": 1.5})
    joined = system.engage(Fixed(one, two, at=(0, 0, 0), name="lock"), start)
    # p_a = (0.2 + 0.3) a + 0.2 (a + b) is kept, the rate of b ends
    p = 0.5 * 2.0 + 0.2 * 3.5
    after = accelerations(joined.system, joined.state)
    assert after.rate(a)[0] == pytest.approx(p / 0.7, rel=1e-12)
    before = 0.5 * (0.5 * 4.0 + 0.5 * 1.5**2 + 0.2 * 3.5**2)
    assert joined.lost == pytest.approx(before - 0.5 * 0.7 * (p / 0.7) ** 2, rel=1e-12)
    assert isinstance(joined.joint, Engaged)


def test_impacts_turn_the_rotor_on_the_ground_too():
    """An end stop between two bodies on a hinge of the ground: energy and momenta balance to the tolerance of the run,
    as the angular momentum of the bodies changes by the impulse that their rotor takes from the ground.
    """
    arm, hand = bodies(2, seed=5)
    shoulder = Revolute(GROUND, arm, at=(0.3, -0.2, 0.5), axis=(1, 2, -2), name="shoulder", reflected_inertia=0.7)
    elbow = Revolute(hand, arm, at=(0.6, 0.4, -0.1), axis=(2, -1, 3), name="elbow", reflected_inertia=0.2)
    stop = EndStop(elbow, lower=-0.4, upper=0.9, restitution=0.6, name="stop")
    system = System([arm, hand], [shoulder, elbow], [stop], gravity=(1.0, 3.0, -8.0))
    run = simulate(system, 1.0, state=system.assemble(rates={shoulder: 2.0, elbow: 4.0}), rtol=1e-9)
    assert len(run.events) > 1 and run.certificate.passed, run.certificate
    twin = with_rotors(System([arm, hand], [shoulder, elbow], gravity=system.gravity))
    plain = next(joint for joint in twin.joints if joint.name == "elbow")
    same = EndStop(plain, lower=-0.4, upper=0.9, restitution=0.6, name="stop")
    twin = System(twin.bodies, twin.joints, [same], gravity=system.gravity)
    expected = simulate(twin, 1.0, state=twin.assemble(rates={"shoulder": 2.0, "elbow": 4.0}), rtol=1e-9)
    # the rotors of the twin have 1e-6 kg, and a motion of some radians amplifies that by less than 100
    assert abs(run.events[0].t - expected.events[0].t) < 1e-5
    assert np.allclose(run.at(1.0).v[:12], expected.at(1.0).v[:12], rtol=1e-3, atol=1e-3)


def test_published_numbers():
    """Two oblique links; own Newton-Euler equations by Jacobians, M + diag(reflected)."""
    one = Body("one", 2.0, (0.1, 0.12, 0.05), com=(0.1, 0.05, -0.6))
    two = Body("two", 1.0, (0.05, 0.05, 0.01), com=(0, 0.03, -0.4), position=(0, 0, -1))
    a = Revolute(GROUND, one, at=(0, 0, 0), axis=(0.2, 1, 0.3), reflected_inertia=0.3, name="a")
    b = Revolute(one, two, at=(0, 0, -1), axis=(1, 0.1, -0.4), reflected_inertia=0.2, name="b")
    system = System([one, two], [a, b])
    found = accelerations(system, system.assemble(angles={"a": 0.024, "b": 0.901}, rates={"a": -2.847, "b": 3.589}))
    first = found.alpha(one)[0] @ a.axis
    second = (found.alpha(two) - found.alpha(one))[0] @ (found.rotation(one)[0] @ b.axis)
    assert [first, second] == pytest.approx([-1.0847785860420869, -13.59055874731695], rel=1e-12)


def test_a_rotor_that_a_link_carries_is_another_thing():
    """The same links; a disc on the first turns 3 times the second hinge: it feels that the first one turns too.

    Own Newton-Euler equations by Jacobians.
    """
    axis = np.array([1, 0.1, -0.4])
    one = Body("one", 2.0, (0.1, 0.12, 0.05), com=(0.1, 0.05, -0.6))
    two = Body("two", 1.0, (0.05, 0.05, 0.01), com=(0, 0.03, -0.4), position=(0, 0, -1))
    n = axis / np.linalg.norm(axis)
    disc = 0.01 * (np.eye(3) + np.outer(n, n))  # axial 0.02, across 0.01 kg m^2
    rotor = Body("rotor", 0.4, disc, position=(0, 0, -1))
    a = Revolute(GROUND, one, at=(0, 0, 0), axis=(0.2, 1, 0.3), name="a")
    b = Revolute(one, two, at=(0, 0, -1), axis=axis, name="b")
    axle = Revolute(one, rotor, at=(0, 0, -1), axis=axis, name="axle")
    system = System([one, two, rotor], [a, b, axle, Gear(b, axle, ratio=3.0)])
    start = system.assemble(angles={"a": 0.886, "b": 0.023}, rates={"a": 3.81, "b": -3.353})
    found = accelerations(system, start)
    first = found.alpha(one)[0] @ a.axis
    second = (found.alpha(two) - found.alpha(one))[0] @ (found.rotation(one)[0] @ b.axis)
    assert [first, second] == pytest.approx([-5.1359035994805895, 2.6084818901063476], rel=1e-10)


def test_files_keep_it_and_bad_input_is_refused(tmp_path):
    system = chain(False)
    system.to_file(tmp_path / "model.json")
    again = System.from_file(tmp_path / "model.json")
    assert again.joints[1].reflected_inertia == 0.5 and again.joints[2].reflected_mass == 1.4
    b = bodies(1)[0]
    with pytest.raises(ValueError, match="reflected_inertia"):
        Revolute(GROUND, b, at=(0, 0, 0), axis=(0, 0, 1), reflected_inertia=-1.0)
    with pytest.raises(ValueError, match="reflected_inertia"):
        Spherical(GROUND, b, at=(0, 0, 0), reflected_inertia=-1.0)
    with pytest.raises(ValueError, match="reflected_mass"):
        Prismatic(GROUND, b, at=(0, 0, 0), axis=(0, 0, 1), reflected_mass=np.nan)
