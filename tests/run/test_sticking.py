"""Friction that sticks by rows at events: closed forms, several joints at rest together, what each method does."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import null_space
from scipy.optimize import brentq

from mbsd3d import (
    GROUND,
    RK4,
    Body,
    Clutch,
    Constant,
    Cylindrical,
    DryFriction,
    EndStop,
    Force,
    GearMesh,
    GeneralizedAlpha,
    Kinematic,
    Prismatic,
    RadauIIA,
    Ramp,
    Revolute,
    Screw,
    Sine,
    SlideDriver,
    SpeedDriver,
    SpringDamper,
    Stepper,
    System,
    Torque,
    accelerations,
    extend,
    linearize,
    load,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix

G = 9.81
UP = np.array([0.0, 1.0, 0.0])


def incline(slope, speed, mu, **more):
    """A block on a guide up a slope, off the origin, its centre of mass beside the guide."""
    up = np.array([np.cos(slope), 0.0, np.sin(slope)])
    block = Body("block", 2.0, (0.02, 0.01, 0.03), position=(0.3, 0.2, 0.1), com=(0, 0.1, 0), velocity=speed * up)
    rail = Prismatic(GROUND, block, at=(0.3, 0.2, 0.1), axis=up, name="rail")
    return System([block], [rail], [DryFriction(rail, mu=mu, name="friction", **more)])


METHODS = pytest.mark.parametrize("method", [None, RadauIIA(), RK4(dt=1e-3), GeneralizedAlpha(dt=1e-3)], ids=str)
EVEN = 1e-12  # of an even deceleration, which all methods follow exactly


@METHODS
def test_a_block_sticks_on_a_slope(method):
    slope, speed, mu = 0.25, 3.0, 0.3
    slow = G * (np.sin(slope) + mu * np.cos(slope))
    run = simulate(incline(slope, speed, mu), 1.5, **({} if method is None else {"method": method}))
    (event,) = run.events
    assert event.what == "'friction' sticks" and event.t == pytest.approx(speed / slow, abs=EVEN)
    assert run.slide("rail")[-1] == pytest.approx(speed**2 / (2.0 * slow), abs=EVEN)
    assert np.ptp(run.slide("rail")[run.t >= event.t]) < 1e-14  # no creep
    assert run.force("friction").force[-1] @ run.system.joints[0].axis == pytest.approx(2.0 * G * np.sin(slope))
    assert run.certificate.passed


@METHODS
def test_a_block_turns_back_on_a_steep_slope(method):
    slope, speed, mu = 0.5, 3.0, 0.3
    up, down = G * (np.sin(slope) + mu * np.cos(slope)), G * (np.sin(slope) - mu * np.cos(slope))
    run = simulate(incline(slope, speed, mu), 1.2, **({} if method is None else {"method": method}))
    (event,) = run.events
    assert event.what == "'friction' turns back" and event.t == pytest.approx(speed / up, abs=EVEN)
    back = 0.5 * down * (1.2 - event.t) ** 2
    assert run.slide("rail")[-1] == pytest.approx(speed**2 / (2.0 * up) - back, abs=EVEN)
    assert run.certificate.passed


def swing(m, l, I, mu, R, angle):
    """A rigid pendulum with a journal, its reference point on the axis."""
    bob = Body("bob", m, (0.4 * I, 0.7 * I, I), com=(l * np.sin(angle), -l * np.cos(angle), 0))
    pin = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 0, 1), name="pin")
    return System([bob], [pin], [DryFriction(pin, mu=mu, pin_radius=R, name="journal")], gravity=-G * UP)


def test_a_pendulum_with_a_journal_swings_to_rest(tmp_path):
    """Reference: its equation with T = mu R |F| from a quadratic, by another integrator, turns by events.

    Thirteen swings at rtol 1e-10: each adds its share of error. It rests where |sin angle| <= mu R / l at a turn.
    """
    system = swing(2.5, 0.4, 0.05, 0.3, 0.05, 1.2)
    run = simulate(system, 12.0, rtol=1e-10)
    turns = 1.2 + run.angle("pin")[np.searchsorted(run.t, [event.t for event in run.events])]
    assert [event.action for event in run.events] == ["turns back"] * 12 + ["sticks"]
    assert turns[[0, 2, 12]] == pytest.approx(
        [-1.0623728825910124, -0.8275902671056605, 0.015375339465633756], abs=1e-9
    )
    assert [run.events[k].t for k in (0, 12)] == pytest.approx([0.731043783031417, 8.969864971867624], abs=1e-9)
    assert run.certificate.passed
    assert sum("greatest gain on itself 0.01 at t = 0 s" in note for note in run.certificate.notes) == 1
    other = load(run.save(tmp_path / "swing"))
    assert str(other.certificate) == str(run.certificate) and str(other.events) == str(run.events)
    again = simulate(system, 100.0, state=run.final)
    assert not again.events and np.ptp(again.angle("pin")) == 0.0


def test_a_start_at_rest_sticks_or_slips():
    assert abs(accelerations(incline(0.29, 0.0, 0.3)).acceleration("block")).max() == 0.0
    down = accelerations(incline(-0.3, 0.0, 0.3)).acceleration("block")[0]
    assert down @ (np.cos(-0.3), 0, np.sin(-0.3)) == pytest.approx(G * (np.sin(0.3) - 0.3 * np.cos(0.3)))
    held = incline(0.25, 0.0, 0.2, mu_static=1.001 * np.tan(0.25))
    assert abs(accelerations(held).acceleration("block")).max() == 0.0
    slips = accelerations(incline(0.25, 0.0, 0.2, mu_static=0.999 * np.tan(0.25))).acceleration("block")[0]
    assert slips @ (np.cos(0.25), 0, np.sin(0.25)) == pytest.approx(-G * (np.sin(0.25) - 0.2 * np.cos(0.25)))
    run = simulate(incline(0.25, 0.0, 0.3), 100.0)
    assert not run.events and np.ptp(run.slide("rail")) == 0.0 and run.certificate.passed


def test_small_motions_about_a_joint_that_sticks_have_its_row():
    """A block on a spring on a slope that sticks to its guide: the spring of a second block on it is all that moves."""
    base, top = Body("base", 2.0, (0.1,) * 3), Body("top", 0.5, (0.1,) * 3, position=(0.2, 0, 0))
    rail = Prismatic(GROUND, base, at=(0, 0, 0), axis=(1, 0, 0))
    upper = Prismatic(base, top, at=(0.2, 0, 0), axis=(1, 0, 0))
    spring = SpringDamper(base, top, at_a=(0, 0, 0), at_b=(0.2, 0, 0), stiffness=80.0)
    system = System([base, top], [rail, upper], [DryFriction(rail, mu=0.3), spring])
    found = np.abs(linearize(system, system.state()).eigenvalues)
    assert found == pytest.approx([np.sqrt(80.0 / 0.5)] * 2)


def test_a_block_on_a_belt_sticks_and_slips():
    """Mass m, spring k, belt at V: period and share of sticking of the cycle in closed form."""
    m, k, static, sliding, V = 1.0, 100.0, 0.4, 0.3, 0.1
    belt, block = Body("belt", 1.0, (0.1,) * 3, velocity=(V, 0, 0)), Body("block", m, (0.1,) * 3, velocity=(V, 0, 0))
    way = Prismatic(GROUND, belt, at=(0, 0, 0), axis=(1, 0, 0), name="way")
    rest = Prismatic(belt, block, at=(0, 0, 0), axis=(1, 0, 0), name="rest")
    friction = DryFriction(rest, mu=sliding, mu_static=static)
    spring = SpringDamper(GROUND, block, at_a=(-0.5, 0, 0), at_b=(0, 0, 0), stiffness=k)
    run = simulate(
        System([belt, block], [way, rest, SpeedDriver(joint=way, speed=V)], [friction, spring]), 2.5, rtol=1e-10
    )
    D, w = (static - sliding) * m * G / k, np.sqrt(k / m)
    stick, slip = 2.0 * D / V, 2.0 / w * (np.pi - np.arctan(D * w / V))
    times = [event.t for event in run.events]
    assert [event.action for event in run.events] == ["slips", "sticks"] * 3 + ["slips"]
    assert times[0] == pytest.approx(static * m * G / k / V, abs=1e-9)
    assert np.diff(times) == pytest.approx([slip, stick] * 3, abs=1e-9)
    assert run.certificate.passed


def test_a_block_on_a_shaken_slope():
    """Reference: parabolas between events, each by bisection; it slips at 9.56 ms and never sticks again."""
    slope, A, w = 0.1, 0.002, 60.0
    up = np.array([np.cos(slope), 0, np.sin(slope)])
    plate, block = (Body(name, 1.0, (0.1,) * 3, velocity=A * w * up) for name in ("plate", "block"))
    way = Prismatic(GROUND, plate, at=(0, 0, 0), axis=up)
    rest = Prismatic(plate, block, at=(0, 0, 0), axis=up, name="rest")
    shaken = SlideDriver(way, Sine(A, w / 2 / np.pi))
    run = simulate(System([plate, block], [way, rest, shaken], [DryFriction(rest, mu=0.3)]), 10 * np.pi / w, rtol=1e-10)
    assert [event.action for event in run.events] == ["slips"] + ["turns back"] * 9
    assert run.events[0].t == pytest.approx(0.00956142063180934, abs=1e-9)
    assert run.slide("rest")[-1] == pytest.approx(-0.02043253814434705, abs=1e-9)


def jack(torque, pitch, mu, beta, rate=0.0):
    """A screw that cannot rise in a nut that cannot turn, which lifts 100 kg."""
    screw = Body("screw", 5.0, (0.02, 0.02, 0.02), omega=(0, 0, rate))
    nut = Body("nut", 100.0, (1, 1, 1), position=(0, 0, 0.3))
    bearing = Revolute(GROUND, screw, at=(0, 0, 0), axis=(0, 0, 1), name="bearing")
    column = Prismatic(GROUND, nut, at=(0, 0, 0.3), axis=(0, 0, 1), name="column")
    thread = Screw(nut, screw, at=(0, 0, 0.3), axis=(0, 0, 1), pitch=-pitch, name="thread")
    friction = DryFriction(thread, mu=mu, thread_radius=0.01, flank_angle=beta, name="friction")
    return System([screw, nut], [bearing, column, thread], [friction, Torque(screw, (0, 0, torque))])


@pytest.mark.parametrize(("pitch", "mu", "beta"), [(0.005, 0.15, 0.0), (0.005, 0.12, 0.26), (0.02, 0.1, 0.26)])
def test_a_screw_jack_between_its_torques_of_raising_and_lowering(pitch, mu, beta):
    lam, phi, W = np.arctan(pitch / 2 / np.pi / 0.01), np.arctan(mu / np.cos(beta)), 100.0 * G
    raising, lowering = W * 0.01 * np.tan(lam + phi), W * 0.01 * np.tan(lam - phi)
    for torque, moves in ((raising, 1.0), (lowering, -1.0)):
        for share, stands in ((1e-6, False), (-1e-6, True)):
            now = accelerations(jack(torque + moves * share * W * 0.01, pitch, mu, beta))
            assert (now.alpha("screw")[0, 2] * moves > 0.0) == (not stands)
            assert not stands or abs(now.alpha("screw")).max() < 1e-12
    friction = jack(0.0, pitch, mu, beta).forces[0]
    assert friction.efficiency.forward == pytest.approx(np.tan(lam) / np.tan(lam + phi), rel=1e-12)
    assert friction.efficiency.back == pytest.approx(np.tan(lam - phi) / np.tan(lam), rel=1e-12)
    assert friction.self_locking == (lam <= phi)


def test_a_self_locking_jack_that_is_let_go_stops_and_stays():
    r, m, J, rate = 0.01, 100.0, 0.02, 8.0
    lam, phi = np.arctan(0.005 / 2 / np.pi / r), np.arctan(0.15)
    slow = m * G * r * np.tan(lam + phi) / (J + m * r * np.tan(lam) * r * np.tan(lam + phi))
    run = simulate(jack(0.0, 0.005, 0.15, 0.0, rate), 2.0)
    assert [event.action for event in run.events] == ["sticks"]
    assert run.events[0].t == pytest.approx(rate / slow, abs=1e-10)
    assert run.angle("bearing")[-1] == pytest.approx(rate**2 / 2 / slow, abs=1e-9) and run.certificate.passed


LEAD, PRESSURE = 0.1, np.pi / 9


def worm_drive(mu, on_worm, ratio=40.0, radius=0.02, on_wheel=200.0):
    """A worm and its wheel with a torque on each."""
    wheel_radius = ratio * radius * np.tan(LEAD)
    worm = Body("worm", 2.0, (0.01, 0.01, 0.02))
    wheel = Body("wheel", 5.0, (0.3, 0.6, 0.3), position=(radius + wheel_radius, 0, 0))
    first = Revolute(GROUND, worm, at=(0, 0, 0), axis=(0, 0, 1), name="first")
    second = Revolute(GROUND, wheel, at=wheel.position, axis=(0, 1, 0), name="second")
    mesh = GearMesh(first, second, at=(radius, 0, 0), pressure_angle=PRESSURE, helix_angle=np.pi / 2 - LEAD)
    torques = [Torque(worm, (0, 0, on_worm)), Torque(wheel, (0, -np.sign(mesh.ratio) * on_wheel, 0))]
    return System([worm, wheel], [first, second, mesh], [DryFriction(mesh, mu=mu), *torques], gravity=(0, 0, 0))


@pytest.mark.parametrize("mu", [0.05, 0.0942, 0.0943, 0.2])
def test_a_worm_has_the_efficiencies_of_the_textbooks_and_locks_where_they_say(mu):
    tan, cos = np.tan(LEAD), np.cos(PRESSURE)
    still = worm_drive(mu, 0.0)
    friction = still.forces[0]
    assert friction.efficiency.forward == pytest.approx((cos - mu * tan) / (cos + mu / tan), rel=1e-12)
    assert friction.efficiency.back == pytest.approx((cos - mu / tan) / (cos + mu * tan), rel=1e-9, abs=1e-14)
    locks = mu >= cos * tan  # 0.09428
    assert friction.self_locking == locks
    assert (abs(accelerations(still).alpha("wheel")).max() < 1e-12) == locks
    even = 200.0 / 40.0 / friction.efficiency.forward  # on the worm
    for share, turns in ((0.999999, False), (1.000001, True)):
        rate = accelerations(worm_drive(mu, share * even)).alpha("worm")[0, 2]
        assert rate > 1e-6 if turns else rate == pytest.approx(0.0, abs=1e-9)


def test_a_mesh_with_mu_has_its_friction(tmp_path):
    given = worm_drive(0.2, 0.0)
    first, second, mesh = given.joints
    own = GearMesh(
        first, second, at=mesh.at, pressure_angle=PRESSURE, helix_angle=np.pi / 2 - LEAD, name="mesh", mu=0.2
    )
    system = System(given.bodies, [first, second, own], given.forces[1:], gravity=(0, 0, 0))
    friction = system.part("friction of mesh", "forces")
    assert isinstance(friction, DryFriction) and friction.self_locking
    for one in (system, System.from_file(system.to_file(tmp_path / "worm.toml"))):
        assert len(one.forces) == 3 and abs(accelerations(one).alpha("wheel")).max() < 1e-12


def test_the_dense_equations_hold_the_friction_that_follows_its_load():
    system = engine(-100.0)
    state = system.assemble(rates={"main": 5.0})
    M, force, J, gamma, _ = extend.equations(system, state)
    found = accelerations(system, state)
    a = np.hstack([found.acceleration("crank"), found.alpha("crank")]).ravel()
    N = null_space(J)
    v_dot = np.linalg.lstsq(J, gamma)[0]
    v_dot = v_dot + N @ np.linalg.solve(N.T @ M @ N, N.T @ (force - M @ v_dot))
    assert v_dot[:6] == pytest.approx(a, rel=1e-9, abs=1e-9 * np.abs(a).max())


def test_a_locking_worm_runs_out_and_holds():
    run = simulate(worm_drive(0.2, 0.0), 0.5, state=worm_drive(0.2, 0.0).assemble())
    assert not run.events
    system = worm_drive(0.2, 0.0)
    run = simulate(system, 0.5, state=system.assemble(rates={"first": 30.0}))
    assert [event.action for event in run.events] == ["sticks"] and run.certificate.passed
    assert np.ptp(run.angle("second")[run.t >= run.events[0].t]) < 1e-14


def engine(torque, masses=1.0, angle=1.0, gas=5000.0):
    """A slider-crank with friction in all four joints; the rod is in two, so that all forces are determined."""
    r, l, mu = 0.05, 0.15, 0.1
    pin = r * np.array([np.cos(angle), np.sin(angle), 0.0])
    end = np.array([pin[0] + np.sqrt(l**2 - pin[1] ** 2), 0.0, 0.0])
    own = dict(mass=masses, inertia=(1e-3 * masses,) * 3)
    crank, piston = Body("crank", **own), Body("piston", **own, position=end)
    big, small = (Body(name, **own, position=0.5 * (pin + end)) for name in ("big end", "small end"))
    main = Revolute(GROUND, crank, at=(0, 0, 0), axis=(0, 0, 1), name="main")
    joints = [
        main, Revolute(crank, big, at=pin, axis=(0, 0, 1)), Prismatic(big, small, at=big.position, axis=(0, 0, 1)),
        Revolute(small, piston, at=end, axis=(0, 0, 1)),
        Cylindrical(GROUND, piston, at=end, axis=(1, 0, 0), name="bore"),
    ]  # fmt: skip
    frictions = [DryFriction(joints[k], mu=mu, pin_radius=R) for k, R in ((0, 0.025), (1, 0.02), (3, 0.01))]
    loads = [Force(piston, (-gas, 0, 0)), Torque(crank, (0.0, 0.0, torque))]
    frictions.append(DryFriction(joints[4], mu=0.08))
    return System([crank, big, small, piston], joints, [*frictions, *loads], gravity=(0, 0, 0))


LEAST, GREATEST = 218.87566135470857, 283.4960452989882  # N m by friction circles, see test_dry_friction


def test_joints_that_rest_together_stand_between_the_torques_of_friction_circles():
    for torque, moves in (
        (LEAST - 1e-6, 1),
        (LEAST + 1e-6, 0),
        (250.0, 0),
        (GREATEST - 1e-6, 0),
        (GREATEST + 1e-6, -1),
    ):
        found = accelerations(engine(-torque, 1e-3))
        assert np.sign(found.alpha("crank")[0, 2].round(6)) == moves
        held = [name for name, mode in found.final.modes.items() if mode.name == "held"]
        assert len(held) == (0 if moves else 1)  # one freedom, one row
        shared = [note for note in found.certificate.notes if "not unique: 'DryFriction" in note]
        assert moves or len(shared) == 1


@pytest.mark.parametrize(("rate", "edge"), [(10.0, (250.0 - LEAST) / 10.0), (-10.0, (GREATEST - 250.0) / 10.0)])
def test_joints_that_rest_together_start_at_the_edge(rate, edge):
    run = simulate(engine(Constant(-250.0) + Ramp(rate)), edge + 0.05)
    assert run.events[-1].t == pytest.approx(edge, abs=1e-9) and run.events[-1].action == "slips"
    assert np.ptp(run.angle("main")[run.t <= run.events[-1].t]) < 1e-12
    assert run.certificate.passed


@pytest.mark.parametrize("rate", [5.0, -5.0])
def test_joints_come_to_rest_together(rate):
    system = engine(-250.0)
    run = simulate(system, 0.2, state=system.assemble(rates={"main": rate}))
    assert len(run.events) == 1 and "sticks" in run.events[0].action and run.certificate.passed
    assert np.ptp(run.angle("main")[run.t >= run.events[0].t]) < 1e-12


def test_a_slide_that_turns_at_a_dead_centre_does_not_stick():
    """At a dead centre the piston is at rest, and no force on it stops the crank."""
    system = engine(0.0, gas=0.0)
    run = simulate(system, 0.25, state=system.assemble(rates={"main": 40.0}), rtol=1e-9)
    turned = 1.0 + run.angle("main")[np.searchsorted(run.t, [event.t for event in run.events])]
    at_bore = np.array([event.part == "DryFriction 4" for event in run.events])
    assert {event.action for event in run.events} == {"turns back"} and at_bore.sum() >= 2
    assert np.sin(turned[at_bore]) == pytest.approx(0.0, abs=1e-7)
    assert run.certificate.passed


def test_two_freedoms_come_to_rest_one_after_the_other():
    """A train of two blocks on one rail, each with its own friction: the momentum of both decides, each by its own."""
    one, two = (
        Body(name, 1.0, (0.1,) * 3, position=(x, 0, 0), velocity=(v, 0, 0))
        for name, x, v in (("one", 0, 2.0), ("two", 1, 1.0))
    )
    rails = [Prismatic(GROUND, body, at=body.position, axis=(1, 0, 0), name=f"rail {body.name}") for body in (one, two)]
    system = System([one, two], rails, [DryFriction(rails[0], mu=0.2), DryFriction(rails[1], mu=0.4)])
    run = simulate(system, 2.0)
    assert [event.t for event in run.events] == pytest.approx([1.0 / (0.4 * G), 2.0 / (0.2 * G)], abs=1e-10)
    assert all(event.action.startswith("sticks") for event in run.events) and run.certificate.passed


def test_a_stack_that_is_pulled_slips_at_the_ground_and_then_between():
    """A growing pull P = 10 t on the lower of two blocks: static friction below, then the upper one falls behind."""
    low, top = (Body(name, m, (0.1,) * 3, position=(0, 0, z)) for name, m, z in (("low", 2.0, 0.0), ("top", 1.0, 0.1)))
    ground = Prismatic(GROUND, low, at=(0, 0, 0), axis=(1, 0, 0))
    between = Prismatic(low, top, at=(0, 0, 0.1), axis=(1, 0, 0))
    frictions = [DryFriction(ground, mu=0.1, mu_static=0.15, name="below")]
    frictions.append(DryFriction(between, mu=0.3, mu_static=0.4, name="between"))
    system = System([low, top], [ground, between], [*frictions, Force(low, (Ramp(10.0), 0, 0))])
    run = simulate(system, 3.0)
    assert [event.part for event in run.events] == ["below", "between"]
    first, second = 0.15 * 3.0 * G / 10.0, (0.1 * 3.0 * G + 3.0 * 0.4 * G) / 10.0
    assert [event.t for event in run.events] == pytest.approx([first, second], abs=1e-9) and run.certificate.passed


def test_methods_without_events_name_the_remedy():
    system = incline(0.25, 3.0, 0.3)
    driven = System(system.bodies, [*system.joints, SlideDriver(system.joints[0], Ramp(3.0))], system.forces)
    with pytest.raises(ValueError, match="'friction' switches .* give it yields="):
        simulate(driven, 1.0, state=driven.assemble(), method=Kinematic())
    with pytest.raises(ValueError, match=r"'friction' \(DryFriction\) switches .* give it yields="):
        Stepper(system)


@pytest.mark.parametrize("method", [RK4(dt=1e-2), None, RadauIIA()], ids=str)
@pytest.mark.parametrize(("torque", "static"), [(1.0, None), (3.0, None), (3.0, 0.3)])
def test_a_clutch_and_friction_in_one_hinge_hold_together(torque, static, method):
    """A disc that is turned to and fro: both hold up to the sum of their torques, whichever has the row.

    Reference: over each half period it slips from where the drive reaches the sum at rest to where it has come to rest,
    in closed form. The second half takes it back.
    """
    J, drive, w = 0.2, 1.25 * (1.0 + torque), 2.0 * np.pi
    disc = Body("disc", 10.0, (0.1, 0.1, J))
    hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    forces = [Clutch(hinge, torque=torque, engaged=True, name="clutch")]
    forces += [DryFriction(hinge, mu=0.2, mu_static=static, pin_radius=0.05), Torque(disc, (0, 0, Sine(drive, 1.0)))]
    run = simulate(
        System([disc], [hinge], forces, gravity=(0, -10.0, 0)), 2.4, **({} if method is None else {"method": method})
    )
    sliding, rest = 1.0 + torque, torque + (1.0 if static is None else 1.5)
    start = np.arcsin(rest / drive) / w

    def speed(t):
        return (drive / w * (np.cos(w * start) - np.cos(w * t)) - sliding * (t - start)) / J

    end = brentq(speed, 0.3, 0.5)
    turned = (
        drive / w * (np.cos(w * start) * (end - start) - (np.sin(w * end) - np.sin(w * start)) / w)
        - 0.5 * sliding * (end - start) ** 2
    ) / J
    at = [run.angle(hinge)[np.searchsorted(run.t, t)] for t in (0.49, 0.99, 1.49, 1.99)]
    assert at == pytest.approx([turned, 0.0, turned, 0.0], abs=1e-7)  # the methods at rtol 1e-8, RK4 at 1e-2 s
    held = np.abs(run.rate(hinge)) < 1e-9
    load = np.abs(run.force("clutch").moment[:, 2]) + 0.0 * run.t
    assert (load[held] <= torque * (1.0 + 1e-9)).all() and run.certificate.passed


@METHODS
def test_a_block_that_friction_holds_against_a_stop_strikes_it_once(method):
    """What touches a rigid stop and is held by friction presses on nothing: it is not struck again by rounding."""
    rng = np.random.default_rng(1)
    for _ in range(6):
        slope, speed = rng.uniform(-0.2, 0.25), rng.uniform(1.8, 4.0)
        system = incline(slope, speed, 0.3)
        stop = EndStop(system.joints[0], upper=0.25, restitution=0.0, name="stop")
        system = System(system.bodies, system.joints, [*system.forces, stop])
        run = simulate(system, 1.0, **({} if method is None else {"method": method}))
        assert len(run.events) == 1 and run.events[0].impulses.keys() >= {"stop"} and run.certificate.passed
        assert not simulate(system, 2.0, state=run.final).events


def slanted_chain():
    """A sled, an arm and a link with friction in all joints and a clutch in one of them, axes oblique."""
    R, at = matrix(rotation((0.3, -0.5, 0.8), 1.1)), np.array([0.3, 0.2, 0.1])
    sled = Body("sled", 3.0, (0.02, 0.01, 0.025), position=at, com=R @ (0.05, 0.1, -0.03))
    arm = Body("arm", 1.5, (0.02, 0.03, 0.025), position=at + R @ (0.1, 0.3, 0.1), com=R @ (0.2, 0.1, 0.05))
    tip = Body("tip", 0.7, (0.01, 0.012, 0.015), position=at + R @ (0.5, 0.3, 0.1), com=R @ (0.1, -0.1, 0.02))
    rail = Prismatic(GROUND, sled, at=at, axis=R[:, 0], name="rail")
    hinge = Revolute(sled, arm, at=at + R @ (0.1, 0.3, 0.1), axis=R[:, 2], name="hinge")
    elbow = Revolute(arm, tip, at=at + R @ (0.5, 0.3, 0.1), axis=R @ (0.3, 0.1, 1.0), name="elbow")
    forces = [
        DryFriction(rail, mu=0.12, mu_static=0.2, name="on the rail"),
        DryFriction(hinge, mu=0.2, pin_radius=0.04, name="in the hinge"),
        DryFriction(elbow, mu=0.25, pin_radius=0.03, collar_radius=0.04, name="in the elbow"),
        Clutch(hinge, torque=2.0, engaged=True, name="clutch"),
    ]
    system = System([sled, arm, tip], [rail, hinge, elbow], forces, gravity=-G * R[:, 1])
    return system, system.assemble(rates={rail: 1.2, hinge: -2.0, elbow: 3.0})


def test_rows_that_bear_more_than_they_can_fail():
    """A run is right, or its certificate says that an event was missed."""
    system, start = slanted_chain()
    known = simulate(system, 1.5, state=start, rtol=1e-9)
    assert known.certificate.passed and known.certificate["held loads"].error < 1e-9
    for method in (RK4(dt=2e-4), GeneralizedAlpha(dt=2e-4), GeneralizedAlpha(dt=4e-4)):
        run = simulate(system, 1.5, state=start, method=method)
        off = abs(run.angle("hinge")[-1] - known.angle("hinge")[-1])
        assert off < 1e-5 or not run.certificate["held loads"].passed, method
    held = next(k for k, piece in enumerate(known.pieces) if piece.compiled.modes["clutch"].name == "held")
    piece = known.pieces[held]
    row = piece.compiled.rows[id(system.forces[3])].start
    lam = piece.arrays["lam"].copy()
    lam[-1, row] = -2.2  # N m, a tenth beyond the torque
    wrong = replace(piece, arrays=piece.arrays | {"lam": lam})
    found = known.of(wrong).certificate["held loads"]
    assert found.error == pytest.approx(0.1 / 1.1, rel=1e-9) and not found.passed


@pytest.mark.parametrize(
    ("method", "rtol"), [(None, 1e-8), (None, 1e-11), (RadauIIA(), 1e-9), (RK4(dt=1e-3), 1e-8), (RK4(dt=7e-4), 1e-8)]
)
def test_a_load_that_jumps_beyond_friction_lets_go_behind_the_jump(method, rtol):
    """A block rides on a carriage that runs into a damped stop: its load jumps where they touch.

    Reference: the equations of both, of SciPy, from the touch until their speeds are one again.
    """
    M, m, k, c, mu, speed, away = 2.0, 0.7, 900.0, 25.0, 0.2, 1.3, 0.4
    low, top = (Body(n, x, (0.1,) * 3, position=(0, 0, z), velocity=(speed, 0, 0))
                for n, x, z in (("low", M, 0.0), ("top", m, 0.1)))  # fmt: skip
    way = Prismatic(GROUND, low, at=(0, 0, 0), axis=(1, 0, 0), name="way")
    between = Prismatic(low, top, at=(0, 0, 0.1), axis=(1, 0, 0), name="between")
    forces = [EndStop(way, upper=away, stiffness=k, damping=c), DryFriction(between, mu=mu, name="friction")]
    run = simulate(
        System([low, top], [way, between], forces), 1.2, rtol=rtol, **({} if method is None else {"method": method})
    )

    def rates(t, y):
        x, v, _, u = y
        press = max(0.0, k * (x - away) + c * v)
        return v, (mu * m * G - press) / M, u, -mu * G

    def meet(t, y):
        return y[3] - y[1]

    meet.terminal, meet.direction = True, -1.0
    touch = away / speed
    known = solve_ivp(rates, (touch, 1.3), (away, speed, away, speed), events=meet, rtol=1e-11, atol=1e-13)
    print(known.t[-1], known.y[:, -1], run.events)
    assert run.events[0].what == "'friction' slips" and run.events[0].t == pytest.approx(touch, abs=1e-9)
    assert run.events[1].action in ("sticks", "turns back")
    assert run.events[1].t == pytest.approx(known.t[-1], abs=1e-6)
    at = int(np.searchsorted(run.t, run.events[1].t))
    assert run.slide("between")[at] == pytest.approx(known.y[2, -1] - known.y[0, -1], abs=1e-6)
    assert run.certificate.passed
