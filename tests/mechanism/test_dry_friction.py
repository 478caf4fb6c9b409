"""Dry friction by reactions: closed forms, friction circles, formulations of its own, jams, and what is refused."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbsd3d import (
    GROUND,
    RK4,
    Body,
    Cylindrical,
    DryFriction,
    Force,
    GearMesh,
    GeneralizedAlpha,
    Input,
    IntegrationError,
    Planar,
    Prismatic,
    RadauIIA,
    Revolute,
    Screw,
    SpeedDriver,
    Spherical,
    SpringDamper,
    System,
    Torque,
    accelerations,
    linearize,
    measures,
    simulate,
    state_space,
)

G = 9.81
HANGING = (0.0, -G, 0.0)


def incline(slope, speed, mu, **more):
    """A block on a guide up a slope, off the origin, its centre of mass beside the guide."""
    up = np.array([np.cos(slope), 0.0, np.sin(slope)])
    block = Body("block", 2.0, (0.02, 0.01, 0.03), position=(0.3, 0.2, 0.1), com=(0, 0.1, 0), velocity=speed * up)
    rail = Prismatic(GROUND, block, at=(0.3, 0.2, 0.1), axis=up, name="rail")
    return System([block], [rail], [DryFriction(rail, mu=mu, name="friction", **more)])


def test_a_block_slides_up_a_slope_and_back():
    slope, speed, mu = 0.5, 3.0, 0.3
    up, down = G * (np.sin(slope) + mu * np.cos(slope)), G * (np.sin(slope) - mu * np.cos(slope))
    system = incline(slope, speed, mu)
    run = simulate(system, 3.0, stop_when=measures.slide(system.joints[0]) < 0.0)
    way = speed**2 / (2.0 * up)
    assert run.t[-1] == pytest.approx(speed / up + np.sqrt(2.0 * way / down), abs=1e-8)
    assert run.velocity("block")[-1] @ system.joints[0].axis == pytest.approx(-speed * np.sqrt(down / up), abs=1e-8)
    assert run.work("friction")[-1] == pytest.approx(-2.0 * way * mu * 2.0 * G * np.cos(slope), rel=1e-8)
    assert run.certificate.passed


def test_elastic_slip_errs_by_what_it_yields():
    slope, speed, mu = 0.25, 3.0, 0.3
    way = speed**2 / (2.0 * G * (np.sin(slope) + mu * np.cos(slope)))
    missed = []
    for yields in (1e-3, 1e-4, 1e-5):
        run = simulate(incline(slope, speed, mu, yields=yields), 3.0)
        missed.append(abs(run.slide("rail")[-1] - way))
        assert abs(run.velocity("block")[-1]).max() < 1e-8  # it stands, and does not creep
        assert run.force("friction").force[-1] == pytest.approx(
            2.0 * G * np.sin(slope) * run.system.joints[0].axis, abs=1e-6
        )
    assert missed[0] < 5e-3 and missed[1] == pytest.approx(0.1 * missed[0], rel=0.01)
    assert missed[2] == pytest.approx(0.1 * missed[1], rel=0.01)


def test_a_ball_that_comes_to_rest_without_yields_is_named():
    """No row holds a joint that slips in more than one way."""
    with pytest.raises(IntegrationError, match=r"Spherical 'socket'; give 'friction' .* yields="):
        simulate(ball_in_socket(), 3.0)
    with pytest.raises(IntegrationError, match="comes to rest"):
        simulate(ball_in_socket(), 3.0, method=RK4(dt=1e-3))
    with pytest.raises(ValueError, match="'socket' is at rest, where friction has no direction"):
        accelerations(ball_in_socket(omega=(0, 0, 0)))


def ball_in_socket(**more):
    """A ball in its centre of mass."""
    more = {"omega": (7.2, 0.0, 9.6)} | more
    ball = Body("ball", 3.0, (0.02,) * 3, position=(0.2, 0.1, 0.4), **more)
    joint = Spherical(GROUND, ball, at=ball.position, name="socket")
    return System([ball], [joint], [DryFriction(joint, mu=0.2, ball_radius=0.015, name="friction")])


DOUBLE = dict(mass=(2.0, 1.0), inertia=(0.05, 0.02), com=(0.3, 0.25), elbow=0.6, angle=(1.0, -0.6), rate=(-0.5, 4.0))


def double_pendulum(mu=0.3, radius=0.02):
    """A plane double pendulum with friction in both pins."""
    pivot, velocity, bodies = np.zeros(3), np.zeros(3), []
    for k, name in enumerate(("upper", "lower")):
        down = np.array([np.sin(DOUBLE["angle"][k]), -np.cos(DOUBLE["angle"][k]), 0.0])
        omega = np.array([0.0, 0.0, DOUBLE["rate"][k]])
        arm, I = DOUBLE["com"][k] * down, DOUBLE["inertia"][k]
        bodies.append(
            Body(name, DOUBLE["mass"][k], (0.6 * I, 0.5 * I, I), position=pivot, com=arm, omega=omega,
                 velocity=velocity)
        )  # fmt: skip
        elbow = DOUBLE["elbow"] * down
        if k == 0:
            pivot, velocity = elbow, np.cross(omega, elbow)
    pin = Revolute(GROUND, bodies[0], at=(0, 0, 0), axis=(0, 0, 1), name="pin")
    joint = Revolute(*bodies, at=bodies[1].position, axis=(0, 0, 1), name="elbow")
    frictions = [DryFriction(x, mu=mu, pin_radius=radius, name=f"friction of {x.name}") for x in (pin, joint)]
    return System(bodies, [pin, joint], frictions, gravity=HANGING)


def plane_rates(t, y, mu, radius):
    """The same in six coordinates (x, y, angle) of the centres of mass, T = mu R |F| by a nested fixed point."""
    q, v = y[:6], y[6:12]
    m, I, l, L = DOUBLE["mass"], DOUBLE["inertia"], DOUBLE["com"], DOUBLE["elbow"]
    M = np.diag([m[0], m[0], I[0], m[1], m[1], I[1]])
    J, gamma = np.zeros((4, 6)), np.zeros(4)

    def put(rows, body, length, sign):
        c, s, w = np.cos(q[3 * body + 2]), np.sin(q[3 * body + 2]), v[3 * body + 2]
        J[rows, 3 * body : 3 * body + 2] = sign * np.eye(2)
        J[rows, 3 * body + 2] += sign * length * np.array([c, s])
        gamma[rows] += sign * length * w**2 * np.array([s, -c])

    put(slice(0, 2), 0, -l[0], 1.0)
    put(slice(2, 4), 1, -l[1], 1.0)
    put(slice(2, 4), 0, L - l[0], -1.0)
    K = np.block([[M, J.T], [J, np.zeros((4, 4))]])
    slip, w = np.sign([v[2], v[5] - v[2]]), np.zeros(2)
    for _ in range(100):
        torque = -slip * w
        Q = np.array([0, -G * m[0], torque[0] - torque[1], 0, -G * m[1], torque[1]])
        x = np.linalg.solve(K, np.concatenate([Q, gamma]))
        before, w = w, mu * radius * np.array([np.hypot(*x[6:8]), np.hypot(*x[8:10])])
        if np.abs(w - before).max() < 1e-16:
            break
    return np.concatenate([v, x[:6], [w @ np.abs([v[2], v[5] - v[2]])]])


@pytest.fixture(scope="module")
def plane_truth():
    th, w, l, L = (np.array(DOUBLE[k]) for k in ("angle", "rate", "com", "elbow"))
    down, along = np.array([np.sin(th), -np.cos(th)]).T, np.array([np.cos(th), np.sin(th)]).T
    q = [*(l[0] * down[0]), th[0], *(L * down[0] + l[1] * down[1]), th[1]]
    v = [*(l[0] * w[0] * along[0]), w[0], *(L * w[0] * along[0] + l[1] * w[1] * along[1]), w[1]]
    return solve_ivp(plane_rates, (0.0, 0.25), [*q, *v, 0.0], "DOP853", rtol=1e-12, atol=1e-13, args=(0.3, 0.02)).y[
        :, -1
    ]


@pytest.mark.parametrize(
    ("method", "rtol", "error"), [(None, 1e-10, 1e-9), (RadauIIA(), 1e-9, 1e-8), (GeneralizedAlpha(), 1e-6, 1e-4)],
    ids=str,
)  # fmt: skip
def test_a_double_pendulum_agrees_with_a_nested_solution(plane_truth, method, rtol, error):
    more = {} if method is None else {"method": method}
    run = simulate(double_pendulum(), 0.25, rtol=rtol, **more)
    upper = DOUBLE["angle"][0] + run.angle("pin")[-1]
    lower = DOUBLE["angle"][1] + run.angle("pin")[-1] + run.angle("elbow")[-1]
    assert [upper, lower] == pytest.approx(plane_truth[[2, 5]], abs=error)
    lost = -(run.work("friction of pin") + run.work("friction of elbow"))[-1]
    assert lost == pytest.approx(plane_truth[12], abs=error)
    assert run.certificate.passed and any("greatest gain" in note for note in run.certificate.notes)


def test_rk4_keeps_its_order(plane_truth):
    errors = [
        abs(DOUBLE["angle"][0] + simulate(double_pendulum(), 0.25, method=RK4(dt=0.25 / n)).angle("pin")[-1]
            - plane_truth[2])
        for n in (50, 100)
    ]  # fmt: skip
    assert 3.7 < np.log2(errors[0] / errors[1]) < 4.3


def chain(links, mu, radius):
    """Links on hinges about general axes, all of which slip."""
    rng, bodies, joints, before = np.random.default_rng(7), [], [], GROUND
    for k in range(links):
        at = np.array([0.5 * k, 0.05 * (k % 3), 0.0])
        bodies.append(Body(f"link {k}", 1.0 + 0.1 * k, (0.02, 0.03, 0.035), position=at, com=(0.25, 0.02, -0.03)))
        joints.append(Revolute(before, bodies[-1], at=at, axis=rng.normal(size=3), name=f"hinge {k}"))
        before = bodies[-1]
    frictions = [DryFriction(x, mu=mu, pin_radius=radius, collar_radius=0.5 * radius) for x in joints]
    return System(bodies, joints, frictions)


@pytest.mark.parametrize(("links", "mu", "radius"), [(3, 0.3, 0.02), (12, 0.3, 0.02), (12, 0.5, 0.1)])
def test_the_friction_of_a_chain_meets_the_law_at_every_hinge(links, mu, radius):
    system = chain(links, mu, radius)
    rng = np.random.default_rng(3)
    found = accelerations(
        system, system.assemble(rates={f"hinge {k}": rng.choice([-1, 1]) * 2.0 for k in range(links)})
    )
    assert found.certificate.passed  # Newton-Euler of each body under friction and reactions
    for joint, friction in zip(system.joints, system.forces, strict=True):
        F, k = found.reaction(joint).force[0], found.body_axis(joint.b, joint.axis)[0]
        along = F @ k
        torque = mu * radius * (np.linalg.norm(F - along * k) + 0.5 * abs(along))
        opposed = -torque * np.sign(found.rate(joint)[0]) * k
        assert found.force(friction).moment[0] == pytest.approx(opposed, rel=1e-10, abs=1e-10 * torque)


def test_a_ball_in_its_centre_of_mass_loses_its_spin_evenly():
    ball = Body("ball", 3.0, (0.02,) * 3, position=(0.2, 0.1, 0.4), omega=(7.2, 0.0, 9.6))
    joint = Spherical(GROUND, ball, at=ball.position, name="socket")
    slow = 0.2 * 0.015 * (3.0 * G + 5.0) / 0.02
    run = simulate(System([ball], [joint], [DryFriction(joint, mu=0.2, ball_radius=0.015, preload=5.0)]), 2.0)
    assert run.omega(ball)[-1] == pytest.approx(np.array([0.6, 0.0, 0.8]) * (12.0 - 2.0 * slow), abs=1e-8)
    held = DryFriction(joint, mu=0.2, ball_radius=0.015, preload=5.0, yields=1e-4)
    assert np.abs(simulate(System([ball], [joint], [held]), 3.0).omega(ball)[-1]).max() < 1e-7


def test_a_spherical_pendulum_in_a_rough_ball_joint():
    """Reference: Euler's equations about the pivot, integrated by themselves with T = mu R |F| by a fixed point."""
    at, omega = np.array([0.3, 0.0, -0.2]), np.array([0.5, 1.0, 3.0])
    body = Body("bob", 1.5, (0.01, 0.02, 0.015), position=at, velocity=np.cross(omega, at), omega=omega)
    joint = Spherical(GROUND, body, at=(0, 0, 0))
    friction = DryFriction(joint, mu=0.3, ball_radius=0.03)
    run = simulate(System([body], [joint], [friction]), 0.8, rtol=1e-10)
    assert run.com(body)[-1] == pytest.approx([-0.10044162447434, -0.20873814640011, -0.27629669978196], abs=1e-9)
    assert run.work(friction)[-1] == pytest.approx(-0.51953084990473, abs=1e-9)


def ram(arm, push, speed=1.0, mu=0.2):
    """A ram in a guide, its centre of mass an arm beside it, pushed on the axis."""
    body = Body("ram", 4.0, (0.01, 0.01, 0.01), com=(0, 0.6 * arm, 0.8 * arm), velocity=(speed, 0, 0))
    guide = Prismatic(GROUND, body, at=(0, 0, 0), axis=(1, 0, 0), name="guide")
    friction = DryFriction(guide, mu=mu, guide_length=0.2, name="pads")
    return System([body], [guide], [friction, Force(body, (push, 0, 0), at=(0, 0, 0))], gravity=(0, 0, 0))


@pytest.mark.parametrize(("push", "expected"), [(50.0, 50.0 / (4.0 * 1.5)), (-50.0, -50.0 / (4.0 * 0.5))])
def test_a_guide_pushed_beside_its_centre_of_mass(push, expected):
    found = accelerations(ram(0.25, push))  # m a = F -+ 2 mu m h a / L
    assert found.acceleration("ram")[0, 0] == pytest.approx(expected, rel=1e-12)
    assert any("greatest gain on itself 0.5 " in note and "jams from 1 on" in note for note in found.certificate.notes)


@pytest.mark.parametrize("push", [50.0, -50.0])
def test_a_guide_that_jams_is_named_with_its_gain(push):
    with pytest.raises(IntegrationError, match=r"friction holds itself, gain 1.5: .*'guide'; give a longer guide"):
        simulate(ram(0.75, push), 0.1)


def slider_crank(turn, masses=1e-7, wrist=Spherical):
    """A slider-crank 1 rad past its dead centre with hardly any mass, pushed by 5 kN, turned slowly."""
    r, l, angle = 0.05, 0.15, 1.0
    pin = np.array([r * np.cos(angle), r * np.sin(angle), 0.0])
    end = np.array([pin[0] + np.sqrt(l**2 - pin[1] ** 2), 0.0, 0.0])
    light = dict(mass=masses, inertia=(1e-3 * masses,) * 3)
    crank, rod = Body("crank", **light), Body("rod", **light, position=0.5 * (pin + end))
    piston = Body("piston", **light, position=end)
    kind = Cylindrical if wrist is Spherical else Revolute  # so that nothing is held along the axes twice
    main = Revolute(GROUND, crank, at=(0, 0, 0), axis=(0, 0, 1), name="main")
    crank_pin = kind(crank, rod, at=pin, axis=(0, 0, 1), name="crank pin")
    if wrist is Spherical:
        wrist_pin = Spherical(rod, piston, at=end, name="wrist pin")
        guide = Cylindrical(GROUND, piston, at=end, axis=(1, 0, 0), name="guide")
        last = DryFriction(wrist_pin, mu=0.1, ball_radius=0.01)
    else:
        wrist_pin = Revolute(rod, piston, at=end, axis=(0, 0, 1), name="wrist pin")
        guide = Prismatic(GROUND, piston, at=end, axis=(1, 0, 0), name="guide")
        last = DryFriction(wrist_pin, mu=0.1, pin_radius=0.01)
    frictions = [DryFriction(main, mu=0.1, pin_radius=0.025), DryFriction(crank_pin, mu=0.1, pin_radius=0.02), last]
    frictions += [DryFriction(guide, mu=0.08, name="pads"), Force(piston, (-5000.0, 0, 0))]
    drive = SpeedDriver(joint=main, speed=1e-3 * turn, name="drive")
    return System([crank, rod, piston], [main, crank_pin, wrist_pin, guide, drive], frictions, gravity=(0, 0, 0))


@pytest.mark.parametrize(("turn", "torque"), [(1, 218.87566135470857), (-1, 283.4960452989882)])
def test_a_slider_crank_agrees_with_friction_circles(turn, torque):
    """The rod force runs along the common tangent of both friction circles of the rod."""
    r, l, angle, mu = 0.05, 0.15, 1.0, 0.1
    beta = np.arcsin(r * np.sin(angle) / l)
    tilt = beta - turn * np.arcsin(mu * (0.01 + 0.02) / l)
    force = 5000.0 / (np.cos(tilt) + turn * 0.08 * np.sin(tilt))
    lever = r * np.sin(angle + tilt) - turn * mu * (0.02 + 0.025)
    assert abs(force * lever) == pytest.approx(torque, rel=1e-12)
    system = slider_crank(turn)
    found = accelerations(system, system.assemble())
    assert abs(found.reaction("drive").moment[0, 2]) == pytest.approx(torque, rel=1e-8)


def test_loads_that_are_not_determined_are_refused():
    system = slider_crank(1, wrist=Revolute)
    with pytest.raises(ValueError, match=r"'pads' \(DryFriction\): the joints do not determine .* 'guide', .*; "):
        accelerations(system, system.assemble())


def jack(torque, pitch, mu, beta, rate, **more):
    """A screw that cannot rise in a nut that cannot turn, which lifts 100 kg."""
    screw = Body("screw", 5.0, (0.02, 0.02, 0.02), omega=(0, 0, rate))
    nut = Body("nut", 100.0, (1, 1, 1), position=(0, 0, 0.3))
    bearing = Revolute(GROUND, screw, at=(0, 0, 0), axis=(0, 0, 1), name="bearing")
    column = Prismatic(GROUND, nut, at=(0, 0, 0.3), axis=(0, 0, 1), name="column")
    thread = Screw(nut, screw, at=(0, 0, 0.3), axis=(0, 0, 1), pitch=-pitch, name="thread")
    friction = DryFriction(thread, mu=mu, thread_radius=0.01, flank_angle=beta, name="friction", **more)
    return System([screw, nut], [bearing, column, thread], [friction, Torque(screw, (0, 0, torque))])


@pytest.mark.parametrize("rate", [2.0, -2.0])
@pytest.mark.parametrize(("pitch", "mu", "beta"), [(0.005, 0.15, 0.0), (0.02, 0.1, 0.26)])
def test_a_jack_follows_its_lead_and_friction_angles(rate, pitch, mu, beta):
    torque, r, m, J = 5.0, 0.01, 100.0, 0.02
    lam, phi = np.arctan(pitch / (2 * np.pi * r)), np.arctan(mu / np.cos(beta))
    turning = r * np.tan(lam + np.sign(rate) * phi)
    expected = (torque - m * G * turning) / (J + m * r * np.tan(lam) * turning)
    system = jack(torque, pitch, mu, beta, rate)
    found = accelerations(system, system.assemble())
    assert found.alpha("screw")[0, 2] == pytest.approx(expected, rel=1e-10)


def test_a_self_locking_jack_stands_and_a_steep_one_runs_back():
    held = jack(0.0, 0.005, 0.15, 0.0, 0.0, yields=1e-6)
    run = simulate(held, 1.0)
    assert abs(run.rate("bearing")[-1]) < 1e-6 and run.angle("bearing")[-1] == pytest.approx(0.0, abs=1e-3)
    assert run.certificate.passed
    steep = jack(0.0, 0.02, 0.1, 0.0, 0.0, yields=1e-6)
    lam, phi = np.arctan(0.02 / (2 * np.pi * 0.01)), np.arctan(0.1)
    back = 100.0 * G * 0.01 * np.tan(lam - phi) / (0.02 + 100.0 * 1e-4 * np.tan(lam) * np.tan(lam - phi))
    assert simulate(steep, 0.5).rate("bearing")[-1] == pytest.approx(-0.5 * back, rel=1e-3)


LEAD, PRESSURE = 0.1, np.pi / 9


def worm_drive(mu, wheel_drives, ratio=40.0, radius=0.02, load=200.0):
    """A worm and its wheel at even speed, the load on the wheel."""
    wheel_radius = ratio * radius * np.tan(LEAD)
    worm = Body("worm", 2.0, (0.01, 0.01, 0.02))
    wheel = Body("wheel", 5.0, (0.3, 0.6, 0.3), position=(radius + wheel_radius, 0, 0))
    first = Revolute(GROUND, worm, at=(0, 0, 0), axis=(0, 0, 1), name="first")
    second = Revolute(GROUND, wheel, at=wheel.position, axis=(0, 1, 0), name="second")
    mesh = GearMesh(
        first, second, at=(radius, 0, 0), pressure_angle=PRESSURE, helix_angle=np.pi / 2 - LEAD, name="mesh"
    )
    against = -np.sign(mesh.ratio) * (-1.0 if wheel_drives else 1.0)
    drive = SpeedDriver(joint=first, speed=5.0, name="drive")
    forces = [DryFriction(mesh, mu=mu), Torque(wheel, (0, against * load, 0))]
    return System([worm, wheel], [first, second, mesh, drive], forces, gravity=(0, 0, 0))


@pytest.mark.parametrize("wheel_drives", [False, True])
@pytest.mark.parametrize("mu", [0.05, 0.02])
def test_a_worm_has_the_efficiency_of_the_textbooks(mu, wheel_drives):
    system = worm_drive(mu, wheel_drives)
    torque = accelerations(system, system.assemble()).reaction("drive").moment[0, 2]
    tan, cos = np.tan(LEAD), np.cos(PRESSURE)
    expected = (cos - mu / tan) / (cos + mu * tan) if wheel_drives else (cos + mu / tan) / (cos - mu * tan)
    assert torque * (-1.0 if wheel_drives else 1.0) == pytest.approx(200.0 / 40.0 * expected, rel=1e-9)


def test_a_block_on_a_belt_sticks_and_slips():
    """Mass m, spring k, belt at V: the period and the greatest stretch of the cycle in closed form.

    mu_static gives way to mu at slip speeds about y / tau, which the block takes 6 ms to reach: 1 % of a cycle.
    """
    m, k, static, sliding, V = 1.0, 100.0, 0.4, 0.3, 0.1
    belt, block = Body("belt", 1.0, (0.1,) * 3, velocity=(V, 0, 0)), Body("block", m, (0.1,) * 3, velocity=(V, 0, 0))
    way = Prismatic(GROUND, belt, at=(0, 0, 0), axis=(1, 0, 0), name="way")
    rest = Prismatic(belt, block, at=(0, 0, 0), axis=(1, 0, 0), name="rest")
    friction = DryFriction(rest, mu=sliding, mu_static=static, yields=1e-7)
    spring = SpringDamper(GROUND, block, at_a=(-0.5, 0, 0), at_b=(0, 0, 0), stiffness=k)
    run = simulate(
        System([belt, block], [way, rest, SpeedDriver(joint=way, speed=V)], [friction, spring]), 2.5, output=25001
    )
    D, w = (static - sliding) * m * G / k, np.sqrt(k / m)
    x, t = run.position(block)[:, 0], run.t
    tops = np.flatnonzero((x[1:-1] > x[:-2]) & (x[1:-1] >= x[2:])) + 1
    assert np.diff(t[tops])[-1] == pytest.approx(2 * D / V + 2 / w * (np.pi - np.arctan(D * w / V)), rel=0.02)
    assert x[tops[-1]] == pytest.approx(sliding * m * G / k + np.hypot(D, V / w), rel=0.02)


def test_small_motions_see_the_friction_that_follows_its_load():
    """A force that pushes a sliding block obliquely: dv/dt by it is (cos - mu sin) / m."""
    m, mu, speed, tilt = 2.0, 0.3, 1.0, 0.4
    push = mu * m * G / (np.cos(tilt) - mu * np.sin(tilt))
    block = Body("block", m, (0.1,) * 3, velocity=(speed, 0, 0))
    guide = Prismatic(GROUND, block, at=(0, 0, 0), axis=(1, 0, 0), name="guide")
    given = Input("push", push)
    forces = [Force(block, (np.cos(tilt) * given, 0, -np.sin(tilt) * given)), DryFriction(guide, mu=mu)]
    system = System([block], [guide], forces)
    model = state_space(system, system.state(), outputs=[measures.velocity(block, axis=(1, 0, 0))])
    assert (model.C @ model.B).ravel() == pytest.approx([(np.cos(tilt) - mu * np.sin(tilt)) / m], rel=1e-10)


def test_small_motions_about_a_held_joint_have_the_stiffness_of_its_slip():
    yields, mu, R, l, m, I = 1e-3, 0.3, 0.05, 0.4, 2.5, 0.05
    body = Body("bob", m, (0.02, 0.03, I), position=(0, -l, 0))
    pin = Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1))
    friction = DryFriction(pin, mu=mu, pin_radius=R, yields=yields, settles=0.002)
    found = linearize(System([body], [pin], [friction], gravity=HANGING))
    moment, stiff = I + m * l * l, mu * R * m * G / yields
    expected = np.roots([moment, 0.002 * stiff, stiff + m * G * l])
    there = sorted(found.eigenvalues, key=abs)[1:]
    assert np.sort_complex(there) == pytest.approx(np.sort_complex(expected), rel=1e-8)


def hinge():
    body = Body("bob", 1.0, (0.1,) * 3)
    return Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1), name="pin")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (dict(mu=0.1), "needs pin_radius; give it in metres"),
        (dict(mu=-0.1, pin_radius=0.01), "mu"),
        (
            dict(mu=0.1, pin_radius=0.01, guide_length=0.2),
            "guide_length = 0.2: .* has pin_radius, collar_radius; leave",
        ),
        (dict(mu=0.1, pin_radius=0.01, mu_static=0.05), "mu_static = 0.05 is below mu = 0.1"),
        (dict(mu=0.0, pin_radius=0.01, mu_static=0.15, yields=1e-3), "mu = 0 has no elastic slip"),
        (dict(mu=0.1, pin_radius=0.01, settles=0.1), "give yields= too"),
        (dict(mu=0.1, pin_radius=0.0), "pin_radius"),
        (dict(mu=0.1, pin_radius=0.01, yields=0.0), "yields"),
    ],
)
def test_bad_sizes_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        DryFriction(hinge(), name="f", **given)


def test_mu_static_of_a_ball_takes_yields():
    ball = Body("ball", 1.0, (0.1,) * 3)
    with pytest.raises(ValueError, match="'socket' slips in more than one way, so no row holds it; give yields= too"):
        DryFriction(
            Spherical(GROUND, ball, at=(0, 0, 0), name="socket"), mu=0.1, mu_static=0.2, ball_radius=0.01, name="f"
        )


def test_joints_without_a_law_are_refused():
    body = Body("bob", 1.0, (0.1,) * 3)
    with pytest.raises(ValueError, match=r"'flat' .*has no law of friction; give one of Revolute, Prismatic"):
        DryFriction(Planar(GROUND, body, at=(0, 0, 0), normal=(0, 0, 1), name="flat"), mu=0.1)
    one, two = (Body(name, 1.0, (0.1,) * 3) for name in ("one", "two"))
    first = Revolute(GROUND, one, at=(0, 0, 0), axis=(0, 0, 1))
    second = Revolute(GROUND, two, at=(0.3, 0, 0), axis=(0, 0, 1))
    with pytest.raises(ValueError, match="roll at the pitch point"):
        DryFriction(GearMesh(first, second, at=(0.1, 0, 0), name="spur"), mu=0.1)
