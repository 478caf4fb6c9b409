"""The planar solver against identities, closed forms and the spatial solver."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.closed_forms import slider_crank as crank_theory
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import mbsd3d
from engines import planar
from engines.planar.march import evaluate
from mbsd3d import AssemblyError, IntegrationError
from validation import theory

G = (0.0, -9.81)
ENGINE = crank_theory.SliderCrank(0.31, 0.83, 2.3, 0.12, 1.7, 0.37, 0.09, 0.9, crank_inertia=0.05)
SPEED, START, GRAVITY = 17.0, 0.4, (-3.1, 7.7)  # rad/s; rad at the reference pose; along the bore and across it


def body(name, position, angle, mass=1.3, com=(0.21, -0.13), **options):
    return planar.Body(name, mass, 0.07 * mass, com=com, position=position, angle=angle, **options)


def every_joint():
    """One system with all kinds of rows, some between moving bodies; not to be simulated."""
    a, b, c = body("a", (0.1, 0.4), 0.3), body("b", (1.2, -0.3), -0.8, 2.1), body("c", (0.5, 1.4), 2.2, 0.6)
    hinge, other = planar.Revolute(a, b, at=(0.7, 0.2), name="hinge"), planar.Revolute(b, c, at=(0.4, 0.9), name="o")
    rail = planar.Slider(a, c, at=(0.3, 0.8), axis=(2, 1), name="rail")
    at, along = np.array([0.2, -0.4]), np.array([0.8, 0.6])
    centre = at + 0.35 * along + 0.27 * np.array([-0.6, 0.8])
    joints = [
        hinge, other, rail,
        planar.Fixed(planar.GROUND, c, at=(0.1, -0.2), name="weld"),
        planar.Distance(b, c, at_a=(1.1, 0.2), at_b=(0.3, 1.6), name="rod"),
        planar.Rolling(a, b, at=at, along=along, radius=0.27, centre=centre, name="wheel"),
        planar.Gear(hinge, other, ratio=-1.7, name="gear"),
        planar.AngleDriver(hinge, planar.Sine(0.6, 3.0, 0.2), name="motor"),
        planar.SlideDriver(rail, planar.Polynomial((0.1, -0.4, 0.3, 0.05)), name="ram"),
    ]  # fmt: skip
    return [a, b, c], joints


@pytest.mark.parametrize("k", range(9), ids=[joint.name for joint in every_joint()[1]])
def test_rows_are_derivatives_of_their_residuals_off_the_constraints(k, monkeypatch):
    """c_dot = J v - f_dot and (J v - f_dot)_dot = J v_dot - gamma along a curved path that obeys no joint."""
    bodies, joints = every_joint()
    partners = [joint for joint in joints[k].partners()]
    monkeypatch.setattr("engines.planar.system.refuse_redundant", lambda *_: None)
    system = planar.System(bodies, [*partners, joints[k]])
    lowered, rng = system.lowered, np.random.default_rng(k)
    slope, bend = rng.normal(size=(2, 4, 3))
    slope[3] = bend[3] = 0.0  # the ground
    work, own = lowered.work(), lowered.joint_of == len(partners)

    def at(t):
        q = lowered.q + 0.3 * slope + slope * t + bend * t * t / 2
        v = slope + bend * t
        evaluate(lowered.model, work, t, q, v)
        J = lowered.jacobian(work)
        values = work.c, J @ v[:-1].ravel() - work.rate, J @ bend[:-1].ravel() - work.gamma
        return np.array([value[own] for value in values])

    t, h = 0.7, 1e-4
    slopes = (8 * (at(t + h) - at(t - h)) - at(t + 2 * h) + at(t - 2 * h)) / (12 * h)
    # differences of order 4: rounding 1e-16 / h and derivatives of order one times h^4
    assert np.abs(slopes[:2] - at(t)[1:]).max() < 1e-10
    reference = lowered.work()
    evaluate(lowered.model, reference, 0.0, lowered.q, np.zeros_like(lowered.q))
    start = {"motor": -0.6 * np.sin(0.2), "ram": -0.1}.get(joints[k].name, 0.0)
    assert np.abs(reference.c[own] - start).max() < 1e-15  # closed as drawn, but for drivers that start elsewhere


def dense(system, q, v, centripetal=1.0):
    """v_dot and lam of the saddle point as a matrix, weight only: the equation of the module, written down again."""
    work, n = system.lowered.work(), len(system.bodies)
    evaluate(system.lowered.model, work, 0.0, q, v)
    J, m = system.lowered.jacobian(work), system.lowered.model.kind.size
    M, F = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    for i, part in enumerate(system.bodies):
        c, s = np.cos(q[i, 2]), np.sin(q[i, 2])
        x, y = np.array([[c, -s], [s, c]]) @ part.com
        at = slice(3 * i, 3 * i + 3)
        M[at, at] = part.mass * np.array([[1, 0, -y], [0, 1, x], [-y, x, x * x + y * y]])
        M[3 * i + 2, 3 * i + 2] += part.inertia
        gx, gy = system.gravity
        F[at] = part.mass * np.array([gx, gy, x * gy - y * gx])
        F[3 * i : 3 * i + 2] += centripetal * part.mass * v[i, 2] ** 2 * np.array([x, y])
    K = np.block([[M, J.T], [J, np.zeros((m, m))]])
    return np.linalg.solve(K, np.concatenate([F, work.gamma])), work


def four_bar(springs=False):
    """General values; the crank turns over the top."""
    crank = body("crank", (0.02, -0.03), 0.4, 2.1, com=(0.11, 0.07), omega=11.0)
    coupler = body("coupler", (0.4, 0.5), -0.7, 1.4, com=(-0.12, 0.31))
    rocker = body("rocker", (1.1, 0.1), 1.9, 1.9, com=(0.28, 0.16))
    A, B, C, D = (0.0, 0.0), (0.21, 0.17), (0.95, 0.71), (1.0, -0.05)
    joints = [
        planar.Revolute(planar.GROUND, crank, at=A, name="A"),
        planar.Revolute(crank, coupler, at=B, name="B"),
        planar.Revolute(coupler, rocker, at=C, name="C"),
        planar.Revolute(rocker, planar.GROUND, at=D, name="D"),
    ]
    loads = [
        planar.Spring(planar.GROUND, rocker, at_a=(1.4, 0.9), at_b=(0.9, 0.4), stiffness=40.0, length=0.3),
        planar.Spring(crank, rocker, at_a=(0.3, 0.9), at_b=(1.2, 0.8), stiffness=25.0),
        planar.TorsionSpring(crank, coupler, stiffness=3.0, angle=0.4),
    ]
    return planar.System([crank, coupler, rocker], joints, loads if springs else (), G)


@pytest.mark.parametrize("centripetal", [True, False])
def test_saddle_point_is_the_dense_one(centripetal):
    system = four_bar()
    run = planar.simulate(system, 0.3, dt=1e-3, output=4, centripetal=centripetal)
    for k in range(4):
        q, v = np.zeros((2, 4, 3))
        for i, part in enumerate(system.bodies):
            q[i], v[i] = (*run.position(part)[k], run.angle(part)[k]), (*run.velocity(part)[k], run.omega(part)[k])
        x, _ = dense(system, q, v, float(centripetal))
        mine = np.concatenate([[*run.acceleration(p)[k], run.alpha(p)[k]] for p in system.bodies])
        # accelerations up to 1e3 by a matrix of condition 1e3
        assert np.abs(mine - x[:9]).max() < 1e-13 * 1e3 * np.abs(x[:9]).max()
        force = -x[9:11]  # rows of joint A are the first; crank is b there
        assert np.abs(run.reaction("A").force[k] - force).max() < 1e-10 * np.abs(force).max()


def test_four_bar_keeps_its_energy():
    energy = planar.simulate(four_bar(springs=True), 1.0, dt=2e-4).energy()
    # (w h)^5 / 120 of RK4 per step, w = 60 rad/s where it is fastest: 2e-12 of the kinetic energy, 5000 times
    assert np.ptp(energy.total) < 1e-8 * np.ptp(energy.kinetic)
    assert np.ptp(energy.kinetic) > 5.0


def test_damping_takes_its_power():
    """Without weight: dE/dt = -c l_dot^2 - c w^2, integrated by the trapezoidal rule."""
    arm = body("arm", (0.3, 0.1), 0.7, omega=9.0)
    hinge = planar.Revolute(planar.GROUND, arm, at=(0.1, 0.2))
    damper = planar.Spring(planar.GROUND, arm, at_a=(2.0, 0.3), at_b=(0.9, 0.6), stiffness=5.0, damping=0.8)
    brake = planar.TorsionSpring(planar.GROUND, arm, stiffness=0.0, damping=0.05)
    run = planar.simulate(planar.System([arm], [hinge], [damper, brake], (0, 0)), 1.0, dt=5e-4)
    span = run.point(arm, arm.local_point((0.9, 0.6))) - np.array([2.0, 0.3])
    length = np.hypot(*span.T)
    speed = run.velocity(arm) + run.omega(arm)[:, None] * np.stack(
        [-(run.point(arm, arm.local_point((0.9, 0.6))) - run.position(arm))[:, 1],
         (run.point(arm, arm.local_point((0.9, 0.6))) - run.position(arm))[:, 0]], axis=1
    )  # fmt: skip
    power = 0.8 * (np.sum(span * speed, axis=1) / length) ** 2 + 0.05 * run.omega(arm) ** 2
    lost = run.energy().total[0] - run.energy().total[-1]
    # the rule is of order 2: power'' h^2 / 12, 1e3 of the power by 2e-8
    assert lost == pytest.approx(np.trapezoid(power, run.t), rel=1e-5)
    assert lost > 1.0


@pytest.mark.parametrize("frame", ["world", "body"])
def test_forces_and_torques_that_vary_in_time(frame):
    """m a_G = F(t), I alpha = arm x F + T(t) of a free body, with its weight."""
    part = body("part", (0.4, -0.2), 0.7, velocity=(1.0, 2.0), omega=3.0)
    at = np.array([0.9, 0.5])
    loads = [
        planar.Force(part, (2.0, -1.0), at=at, frame=frame, motion=planar.Sine(1.5, 4.0, 0.6)),
        planar.Force(part, torque=0.8, motion=planar.Polynomial((0.5, 2.0))),
    ]
    run = planar.simulate(planar.System([part], (), loads, G), 0.6, dt=0.01)
    arm = run.point(part, part.local_point(at)) - run.com(part)
    turn = run.angle(part) * (frame == "body")
    c, s = np.cos(turn), np.sin(turn)
    force = 1.5 * np.sin(4 * run.t + 0.6)[:, None] * np.stack([2 * c + s, 2 * s - c], axis=1)
    spin = (arm[:, 0] * force[:, 1] - arm[:, 1] * force[:, 0] + 0.8 * (0.5 + 2 * run.t)) / part.inertia
    offset = run.com(part) - run.position(part)
    w, alpha = run.omega(part)[:, None], run.alpha(part)[:, None]
    of_com = run.acceleration(part) + alpha * np.stack([-offset[:, 1], offset[:, 0]], axis=1) - w**2 * offset
    assert run.alpha(part) == pytest.approx(spin, abs=1e-11)  # of up to 30 rad/s^2: rounding
    assert of_com == pytest.approx(force / part.mass + G, abs=1e-11)


def test_what_is_no_load_is_refused():
    with pytest.raises(ValueError, match="in loads is not a planar Load"):
        planar.System([planar.Body("a", 1.0, 1.0)], loads=[planar.GROUND])


def test_slide_driver_lifts_its_load():
    """f = 0.3 t + 0.2 t^3 up a slope: effort m (f_ddot + g sin(slope)), times in any order and far apart."""
    load, axis = body("load", (0.3, 0.1), 1.1), np.array([0.8, 0.6])
    rail = planar.Slider(planar.GROUND, load, at=(0.5, 0.5), axis=axis, name="rail")
    ram = planar.SlideDriver(rail, planar.Polynomial((0.0, 0.3, 0.0, 0.2)), name="ram")
    times = np.array([2.0, 0.5, -1.0])
    run = planar.kinematics(planar.System([load], [rail, ram], gravity=G), times)
    assert run.effort("ram") == pytest.approx(load.mass * (1.2 * times + 9.81 * 0.6), rel=1e-13)
    assert run.position(load) == pytest.approx(load.position + np.outer(0.3 * times + 0.2 * times**3, axis), abs=1e-13)
    normal = run.reaction("rail").force @ np.array([-0.6, 0.8])
    assert normal == pytest.approx(np.full(3, load.mass * 9.81 * 0.8), rel=1e-13)


def test_kinematics_follows_the_branch_over_several_turns():
    """Two samples turns apart: the positions between them are found on the way."""
    near, far = (
        planar.kinematics(slider_crank(), [0.1]),
        planar.kinematics(slider_crank(), [5 * 2 * np.pi / SPEED + 0.1]),
    )
    for part in ("rod", "piston"):
        assert far.position(part) == pytest.approx(near.position(part), abs=1e-12)
    assert far.angle("crank") - near.angle("crank") == pytest.approx(10 * np.pi, abs=1e-12)


def test_order_is_four():
    """The last position over the step, against a fine one."""
    end = [np.array([run.position(b)[-1] for b in run.system.bodies]) for run in (
        planar.simulate(four_bar(springs=True), 0.5, dt=0.5 / steps, output=2) for steps in (128, 256, 512, 8192)
    )]  # fmt: skip
    errors = [np.abs(x - end[-1]).max() for x in end[:-1]]
    assert errors[1] > 1e-9  # far above rounding
    assert np.log2(errors[1] / errors[2]) == pytest.approx(4.0, abs=0.15)


def test_steps_land_on_the_end():
    run = planar.simulate(four_bar(), 0.1003, dt=0.01)
    assert run.t[-1] == 0.1003 and len(run.t) == 12
    assert planar.simulate(four_bar(), 0.1003, dt=0.01, output=4).t[-1] == 0.1003


def test_physical_pendulum_with_its_hinge_off_the_reference_point():
    hinge, mass, inertia = np.array([0.2, -0.1]), 1.7, 0.11
    rod = planar.Body("rod", mass, inertia, com=(0.3, 0.2), position=(0.4, 0.3), angle=-0.7, omega=1.3)
    system = planar.System([rod], [planar.Revolute(planar.GROUND, rod, at=hinge, name="hinge")], gravity=G)
    run = planar.simulate(system, 3.0, dt=1e-3, output=31)
    arm = run.com(rod) - hinge
    distance = np.hypot(*arm[0])
    frequency = theory.pendulum_frequency(inertia + mass * distance**2, mass, distance, 9.81)
    start = np.arctan2(arm[0, 0], -arm[0, 1])
    angle, rate = theory.pendulum_motion(run.t, frequency, start, 1.3)
    angle, rate = np.asarray(angle, float), np.asarray(rate, float)
    # RK4: (w h)^4 w t / 120 with w = 4 rad/s, 3e-11, and more for a swing as large as this one
    assert np.abs(run.angle(rod) + 0.7 - angle + start).max() < 3e-10
    assert np.abs(run.omega(rod) - rate).max() < 1e-9
    alpha = -(frequency**2) * np.sin(angle)
    radial = np.stack([np.sin(angle), -np.cos(angle)], axis=1)
    across = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    force = mass * (distance * (alpha[:, None] * across - rate[:, None] ** 2 * radial) - G)
    # m d 2 w times an error of the rate of 1e-9
    assert np.abs(run.reaction("hinge").force - force).max() < 1e-8
    assert np.abs(run.reaction("hinge").moment).max() < 1e-13  # a hinge has none: rounding


def slider_crank(drive=None):
    """ENGINE with the bore along x, reference points off the axis and off the centres of mass."""
    e = ENGINE
    pin = e.radius * np.array([np.cos(START), np.sin(START)])
    lean = np.arcsin(e.radius / e.rod_length * np.sin(START))
    along = np.array([np.cos(lean), -np.sin(lean)])
    wrist = pin + e.rod_length * along

    def part(name, mass, inertia, centre, offset, angle):
        c, s = np.cos(angle), np.sin(angle)
        R = np.array([[c, -s], [s, c]])
        return planar.Body(name, mass, inertia, com=R.T @ np.array(offset), position=centre - offset, angle=angle)

    crank = part("crank", e.crank_mass, e.crank_inertia, e.crank_centre / e.radius * pin, np.array([0.2, -0.3]), 0.6)
    rod = part("rod", e.rod_mass, e.rod_inertia, pin + e.rod_fraction * e.rod_length * along, np.array([0.1, 0.4]), 2.0)
    piston = part("piston", e.piston_mass, 0.02, wrist, np.array([-0.2, 0.1]), -1.0)
    bearing = planar.Revolute(planar.GROUND, crank, at=(0, 0), name="bearing")
    joints = [
        bearing,
        planar.Revolute(crank, rod, at=pin, name="crankpin"),
        planar.Revolute(rod, piston, at=wrist, name="wristpin"),
        planar.Slider(planar.GROUND, piston, at=wrist, axis=(1, 0), name="bore"),
        planar.AngleDriver(bearing, drive or planar.rate(SPEED), name="motor"),
    ]
    return planar.System([crank, rod, piston], joints, gravity=GRAVITY)


def largest(values):
    return np.abs(values).max()


def test_slider_crank_forces_equal_the_closed_form():
    times = np.linspace(0.0, 2 * np.pi / SPEED, 37)
    run = planar.kinematics(slider_crank(), times)
    closed = crank_theory.slider_crank_loads(ENGINE, START + SPEED * times, SPEED, gravity=GRAVITY)
    pairs = [(run.reaction(name).force, getattr(closed, name)) for name in ("bearing", "crankpin", "wristpin")]
    pairs += [(run.reaction("bore").force[:, 1], closed.guide), (run.effort("motor"), closed.torque)]
    for mine, exact in pairs:
        assert largest(mine - exact) < 1e-12 * largest(exact)  # rounding, times the condition of the loop
    assert largest(run.reaction("bore").force[:, 0]) < 1e-12 * largest(closed.guide)


def test_slider_crank_under_an_accelerated_driver():
    """A polynomial and a sine, forwards in time and, by simulate, from one position to the next."""
    for drive, angle, speed, acceleration in (
        (planar.Polynomial((0.0, 3.0, 5.0)), lambda t: 3 * t + 5 * t * t, lambda t: 3 + 10 * t, lambda t: 10 + 0 * t),
        (planar.Sine(0.8, 4.0), lambda t: 0.8 * np.sin(4 * t), lambda t: 3.2 * np.cos(4 * t),
         lambda t: -12.8 * np.sin(4 * t)),
    ):  # fmt: skip
        run = planar.kinematics(slider_crank(drive), np.linspace(0, 1.2, 25))
        for k, t in enumerate(run.t):
            closed = crank_theory.slider_crank_loads(
                ENGINE, [START + angle(t)], speed(t), gravity=GRAVITY, acceleration=acceleration(t)
            )
            assert run.effort("motor")[k] == pytest.approx(closed.torque[0], abs=1e-10)  # of some 40 N m: rounding
            assert run.reaction("bearing").force[k] == pytest.approx(closed.bearing[0], abs=1e-10)
        integrated = planar.simulate(slider_crank(drive), 1.2, dt=1e-3, output=25)
        # every step ends on the driven positions: no error is left from the integration
        assert largest(integrated.effort("motor") - run.effort("motor")) < 1e-9
        assert largest(integrated.position("rod") - run.position("rod")) < 1e-12


def test_without_the_centripetal_term_only_the_bearing_is_wrong():
    times = np.linspace(0.0, 2 * np.pi / SPEED, 37)
    run, wrong = planar.kinematics(slider_crank(), times), planar.kinematics(slider_crank(), times, centripetal=False)
    assert largest(run.position("rod") - wrong.position("rod")) < 1e-13  # positions obey the joints: rounding
    # m w^2 s, s from the reference point to the centre of mass: every body whose r_G is not zero loses it
    lost = -sum(
        part.mass * run.omega(part)[:, None] ** 2 * (run.com(part) - run.position(part)) for part in run.system.bodies
    )
    block = sum(run.reaction(name).force - wrong.reaction(name).force for name in ("bearing", "bore"))
    assert largest(block - lost) < 1e-11 * largest(run.reaction("bearing").force)
    assert largest(block) > 0.2 * largest(run.reaction("bearing").force)


def test_disc_rolls_down_a_slope():
    """a = g sin(slope) / (1 + I / (m r^2)); friction m g sin(slope) - m a, normal force m g cos(slope)."""
    slope, radius, mass, inertia = 0.3, 0.2, 1.9, 0.03
    down, normal = np.array([np.cos(slope), -np.sin(slope)]), np.array([np.sin(slope), np.cos(slope)])
    at = np.array([0.3, -0.2])
    disc = planar.Body("disc", mass, inertia, position=at + 0.4 * down + radius * normal, angle=0.7)
    for along in (down, -down):  # which way the line points does not matter
        wheel = planar.Rolling(planar.GROUND, disc, at=at, along=along, radius=radius, name="wheel")
        run = planar.simulate(planar.System([disc], [wheel], gravity=G), 2.0, dt=1e-2, output=5)
        a = 9.81 * np.sin(slope) / (1 + inertia / (mass * radius**2))
        # RK4 is exact for parabolas
        assert run.position(disc) - disc.position == pytest.approx(a / 2 * run.t[:, None] ** 2 * down, abs=1e-12)
        assert run.angle(disc) - 0.7 == pytest.approx(-a / 2 * run.t**2 / radius, abs=1e-12)
        reaction = run.reaction(wheel)
        force = mass * 9.81 * np.cos(slope) * normal - (mass * 9.81 * np.sin(slope) - mass * a) * down
        assert reaction.force == pytest.approx(np.tile(force, (5, 1)), abs=1e-11)
        assert reaction.moment == pytest.approx(np.zeros(5), abs=1e-11)
        assert reaction.point == pytest.approx(run.position(disc) - radius * normal, abs=1e-12)


def test_unbalanced_disc_rolls_on_a_moving_plank_and_keeps_its_energy():
    plank = planar.Body("plank", 3.0, 0.4, com=(0.1, 0.05), position=(0.2, 0.1), angle=0.2, omega=0.7)
    along = np.array([np.cos(0.3), np.sin(0.3)])
    centre = np.array([0.3, 0.2]) + 0.2 * along + 0.25 * np.array([-along[1], along[0]])
    disc = planar.Body("disc", 1.1, 0.02, com=(0.08, 0.03), position=centre - [0.02, 0.01], angle=1.0, omega=-5.0)
    joints = [
        planar.Revolute(planar.GROUND, plank, at=(0, 0), name="hinge"),
        planar.Rolling(plank, disc, at=(0.3, 0.2), along=along, radius=0.25, centre=centre, name="wheel"),
    ]
    run = planar.simulate(planar.System([plank, disc], joints, gravity=G), 0.8, dt=5e-4)
    energy = run.energy()
    # RK4 at w h = 0.01: 1e-12 per step
    assert np.ptp(energy.total) < 1e-9 * np.ptp(energy.kinetic)
    assert np.abs(run.reaction("wheel").moment).max() < 1e-9  # about the contact there is none


def geared(ratio=-1.7):
    one, two = body("one", (0.1, 0.2), 0.3, 1.3), body("two", (1.0, -0.1), -0.9, 0.8)
    a = planar.Revolute(planar.GROUND, one, at=(0.0, 0.0), name="a")
    b = planar.Revolute(planar.GROUND, two, at=(0.9, 0.1), name="b")
    return planar.System([one, two], [a, b, planar.Gear(a, b, ratio=ratio, name="gear")], gravity=G)


def five_bar():
    """Two cranks in a gear, two couplers between them."""
    one, two = body("one", (0.05, 0.1), 0.3, 1.3, omega=6.0), body("two", (1.0, -0.1), -0.9, 0.8)
    left, right = body("left", (0.3, 0.5), 1.1, 0.5), body("right", (0.9, 0.6), 0.2, 0.6)
    joints = [
        planar.Revolute(planar.GROUND, one, at=(0.0, 0.0), name="A"),
        planar.Revolute(one, left, at=(0.1, 0.2), name="B"),
        planar.Revolute(left, right, at=(0.5, 0.9), name="C"),
        planar.Revolute(right, two, at=(1.1, 0.2), name="D"),
        planar.Revolute(two, planar.GROUND, at=(0.95, 0.05), name="E"),
    ]
    gear = planar.Gear(joints[0], joints[4], ratio=-1.3, name="gear")
    return planar.System([one, two, left, right], [*joints, gear], gravity=G)


def test_gear_pair_turns_as_one_body():
    """(I_a + ratio^2 I_b) alpha = torque_a + ratio torque_b, moments about the hinges."""
    run = planar.simulate(geared(), 1.0, dt=1e-3, output=6)
    one, two = run.system.bodies
    inertia, torque = 0.0, 0.0
    for part, hinge, factor in ((one, (0.0, 0.0), 1.0), (two, (0.9, 0.1), -1.7)):
        arm = run.com(part) - np.array(hinge)
        inertia = inertia + factor**2 * (part.inertia + part.mass * np.sum(arm**2, axis=1))
        torque = torque - factor * part.mass * 9.81 * arm[:, 0]
        about = -part.mass * 9.81 * arm[:, 0]
    assert run.alpha(one) == pytest.approx(torque / inertia, rel=1e-11)
    assert run.angle(two) + 0.9 == pytest.approx(-1.7 * (run.angle(one) - 0.3), abs=1e-12)
    arm = run.com(two) - np.array([0.9, 0.1])
    moment = (two.inertia + two.mass * np.sum(arm**2, axis=1)) * run.alpha(two) - about
    assert run.reaction("gear").moment == pytest.approx(moment, rel=1e-11)


def spatial(part):
    """The planar body in space, its plane that of x and y; moments across the normal of its own."""
    c, s = np.cos(part.angle), np.sin(part.angle)
    return mbsd3d.Body(
        part.name, part.mass, (0.8 * part.inertia, 0.7 * part.inertia, part.inertia), com=(*part.com, 0.0),
        position=(*part.position, 0.0), orientation=np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
        omega=None if part.omega is None else (0.0, 0.0, part.omega),
    )  # fmt: skip


def twin_of(system):
    """The same mechanism in mbsd3d without a redundant row: of every loop one pin is spherical and one universal."""
    bodies = {part.name: spatial(part) for part in system.bodies} | {"ground": mbsd3d.GROUND}
    joints, weaker = {}, {"B": "ball", "C": "cross", "crankpin": "ball", "wristpin": "cross"}
    for joint in system.joints:
        name, z = joint.name, (0.0, 0.0, 1.0)
        if isinstance(joint, planar.Gear):
            hinges = joints[joint.hinge_a.name], joints[joint.hinge_b.name]
            joints[name] = mbsd3d.Gear(*hinges, ratio=joint.ratio, name=name)
            continue
        if isinstance(joint, planar.AngleDriver):
            joints[name] = mbsd3d.AngleDriver(joints[joint.through.name], mbsd3d.Ramp(SPEED), name=name)
            continue
        ends, at = (bodies[joint.a.name], bodies[joint.b.name]), (*joint.at, 0.0)
        if isinstance(joint, planar.Slider):
            joints[name] = mbsd3d.Prismatic(*ends, at=at, axis=(*joint.axis, 0.0), name=name)
        elif weaker.get(name) == "ball":
            joints[name] = mbsd3d.Spherical(*ends, at=at, name=name)
        elif weaker.get(name) == "cross":
            joints[name] = mbsd3d.Universal(*ends, at=at, axis_a=z, axis_b=(0.6, 0.8, 0.0), name=name)
        else:
            joints[name] = mbsd3d.Revolute(*ends, at=at, axis=z, name=name)
    parts = [body for name, body in bodies.items() if name != "ground"]
    return mbsd3d.System(parts, list(joints.values()), gravity=(*system.gravity, 0.0))


@pytest.mark.parametrize("mechanism", [four_bar, geared, five_bar, slider_crank])
def test_spatial_twin_moves_alike_under_equal_forces(mechanism):
    system = mechanism()
    twin = twin_of(system)
    assert "redundant" not in str(twin.check().verdict)
    if mechanism is slider_crank:
        times = np.linspace(0, 0.5, 26)
        mine = planar.kinematics(system, times)
        theirs = mbsd3d.simulate(twin, 0.5, method=mbsd3d.Kinematic(), output=times)
        allowed = 1e-11  # no integration: rounding of both
    else:
        mine = planar.simulate(system, 0.5, dt=0.5 / 8192, output=9)
        theirs = mbsd3d.simulate(twin, 0.5, rtol=1e-12, output=9)
        allowed = 1e-9  # RK4 and DOP853 at 1e-12; the four-bar is quick
    for part in system.bodies:
        assert largest(mine.position(part) - theirs.position(part.name)[:, :2]) < allowed
        # angular accelerations of up to 1e3 rad/s^2; those of pistons are zero
        assert largest(mine.alpha(part) - theirs.alpha(part.name)[:, 2]) < allowed * max(1e3, largest(mine.alpha(part)))
    for joint in system.joints:
        a, b = mine.reaction(joint), theirs.reaction(joint.name)
        size = max(largest(a.force), largest(a.moment))
        assert largest(a.force - b.force[:, :2]) < allowed * size
        assert largest(a.moment - b.moment[:, 2]) < allowed * size


def test_errors_name_part_value_and_remedy():
    pair = geared()
    one, two = pair.bodies
    _, b, gear = pair.joints
    ground = planar.GROUND
    with pytest.raises(ValueError, match="Rolling 'wheel': radius 0.3 m, but the centre is 0.25 m.*equal"):
        planar.Rolling(ground, body("d", (0, 0.25), 0, com=(0, 0)), at=(1, 0), along=(1, 0), radius=0.3, name="wheel")
    rail = planar.Slider(ground, one, at=(0, 0), axis=(1, 0), name="rail")
    with pytest.raises(ValueError, match=r"Gear 'pair': 'rail' \(Slider\) is not a Revolute"):
        planar.Gear(rail, b, ratio=2.0, name="pair")
    with pytest.raises(ValueError, match="AngleDriver 'motor': 'gear' .Gear. is not a Revolute"):
        planar.AngleDriver(gear, planar.rate(1.0), name="motor")
    with pytest.raises(ValueError, match="1 degrees of freedom are not driven; add"):
        planar.kinematics(four_bar(), [0.0, 1.0])
    with pytest.raises(ValueError, match="times of shape .2,.; give a row of finite"):
        planar.kinematics(slider_crank(), [0.0, np.nan])
    with pytest.raises(ValueError, match="output 1; give None or a count"):
        planar.simulate(four_bar(), 1.0, dt=0.1, output=1)
    with pytest.raises(ValueError, match="Revolute 'a' is not a driver; ask for its reaction"):
        planar.simulate(pair, 0.1, dt=0.1).effort("a")
    with pytest.raises(ValueError, match="'z' is not one of the joints; there are 'a', 'b', 'gear'"):
        planar.simulate(pair, 0.1, dt=0.1).reaction("z")
    with pytest.raises(ValueError, match="body 'x': mass: -1.0 is not positive"):
        planar.Body("x", -1.0, 1.0)
    with pytest.raises(ValueError, match="axis has zero length"):
        planar.Slider(ground, one, at=(0, 0), axis=(0, 0))
    with pytest.raises(ValueError, match="body 'two' is not in the system; add it"):
        planar.System([one], [planar.Revolute(one, two, at=(0, 0))])
    with pytest.raises(ValueError, match="joint 'a' is not in the system"):
        planar.System(pair.bodies, [gear])
    with pytest.raises(ValueError, match="two parts are named 'rail'"):
        planar.System([one], [rail, planar.Slider(ground, one, at=(0, 0), axis=(0, 1), name="rail")])


def test_redundant_rows_and_dead_points_are_refused_by_name():
    part = body("part", (0.0, 0.0), 0.1)
    rails = [planar.Slider(planar.GROUND, part, at=(x, 0.0), axis=(1, 0), name=f"rail {x}") for x in (0.0, 1.0)]
    pin = planar.Distance(planar.GROUND, part, at_a=(0.3, -1.0), at_b=(0.4, 0.2), name="innocent")
    with pytest.raises(ValueError, match="2 of 5 rows are redundant .* 'rail 0.0', Slider 'rail 1.0'; remove"):
        planar.simulate(planar.System([part], [*rails, pin]), 1.0, dt=0.1)
    # a rod that is too short for the crank: the mechanism locks at a dead point
    with pytest.raises((AssemblyError, IntegrationError), match="planar: .* at t = "):
        crank = planar.Body("crank", 1.0, 0.1)
        bar = planar.Body("bar", 1.0, 0.1, position=(1.0, 0.0))
        bearing = planar.Revolute(planar.GROUND, crank, at=(0, 0), name="bearing")
        slide = planar.Slider(planar.GROUND, bar, at=(1.0, 0.0), axis=(1, 0), name="slide")
        rod = planar.Distance(crank, bar, at_a=(0.5, 0.5), at_b=(1.0, 0.0), length=0.6, name="rod")
        motor = planar.AngleDriver(bearing, planar.rate(1.0), name="motor")
        planar.kinematics(planar.System([crank, bar], [bearing, slide, rod, motor]), np.linspace(0, 6, 61))


def test_initial_velocities_are_kept_or_refused():
    run = planar.simulate(four_bar(), 0.01, dt=0.01)
    assert run.omega("crank")[0] == pytest.approx(11.0, rel=1e-14)
    part = planar.Body("part", 1.0, 0.1, position=(1, 0), velocity=(1.0, 0.0), omega=2.0)
    hinge = planar.Revolute(planar.GROUND, part, at=(0, 0), name="hinge")
    with pytest.raises(ValueError, match="contradict the rows of Revolute 'hinge'"):
        planar.simulate(planar.System([part], [hinge]), 1.0, dt=0.1)


def test_tables_are_splines_through_their_points():
    """A cubic is its own spline: driver, force and torque as with the polynomial, between and beside the points."""
    cubic = (0.2, 3.0, 5.0, -1.5)
    times = np.array([-0.1, 0.13, 0.4, 0.77, 1.3])
    table = planar.Table(times, np.polyval(cubic[::-1], times))
    runs = [planar.kinematics(slider_crank(x), np.linspace(0, 1.2, 25)) for x in (table, planar.Polynomial(cubic))]
    # rounding of the spline, 1e-15, twice differentiated over 0.2 s
    assert largest(runs[0].effort("motor") - runs[1].effort("motor")) < 1e-10 * largest(runs[1].effort("motor"))
    moved = []
    for motion in (table, planar.Polynomial(cubic)):
        part = body("part", (0.4, -0.2), 0.7, velocity=(0.0, 0.0), omega=0.0)
        push = planar.Force(part, (1.0, 2.0), torque=0.3, motion=motion)
        late = planar.Force(part, (0.5, 0.0), motion=planar.Table(times, np.sin(times)))  # a second spline
        moved.append(planar.simulate(planar.System([part], (), [late, push], G), 1.2, dt=0.01).position(part))
    assert largest(moved[0] - moved[1]) < 1e-12
    rough = np.array([0.3, -1.2, 2.0, 0.4, -0.7])  # pieces that differ
    part = planar.Body("part", 1.3, 0.1)
    push = planar.Force(part, (1.0, 0.0), motion=planar.Table(times, rough))
    other = planar.Force(part, (1.0, 0.0), motion=planar.Table(times, rough**2))
    run = planar.simulate(planar.System([part], (), [other, push], (0, 0)), 1.2, dt=0.01)
    exact = CubicSpline(times, rough)(run.t) + CubicSpline(times, rough**2)(run.t)
    assert 1.3 * run.acceleration(part)[:, 0] == pytest.approx(exact, abs=1e-13)
    with pytest.raises(ValueError, match="AngleDriver 'motor': its table covers -0.1 s to 1.3 s .* 0 s to 1.5 s; ext"):
        planar.simulate(slider_crank(table), 1.5, dt=0.1)
    with pytest.raises(ValueError, match="is asked for -1 s to 0.5 s"):
        planar.kinematics(slider_crank(table), [0.5, -1.0])
    with pytest.raises(ValueError, match="Table: times do not increase"):
        planar.Table([0, 2, 1, 3], [0, 0, 0, 0])
    with pytest.raises(ValueError, match=r"Table: times \(3,\), values \(3,\); give two rows of four"):
        planar.Table([0, 2, 3], [0, 0, 0])


def test_point_masses_where_the_rate_is_constant():
    """A piston does not turn: its moment of inertia means nothing, and 0 is as good as any; so is that of a crank."""
    heavy, times = slider_crank(), np.linspace(0, 0.5, 7)
    crank, rod, piston = heavy.bodies
    light = [replace(part, inertia=0.0) for part in (crank, piston)]
    new = {id(crank): light[0], id(rod): rod, id(piston): light[1], id(planar.GROUND): planar.GROUND}
    *pins, motor = heavy.joints
    joints = [replace(joint, a=new[id(joint.a)], b=new[id(joint.b)]) for joint in pins]
    point = planar.System([light[0], rod, light[1]], [*joints, replace(motor, through=joints[0])], gravity=GRAVITY)
    runs = [planar.kinematics(system, times) for system in (heavy, point)]
    for joint in ("bearing", "crankpin", "wristpin", "bore"):
        force = runs[0].reaction(joint).force
        assert largest(runs[1].reaction(joint).force - force) < 1e-12 * largest(force)  # rounding
    assert largest(runs[1].effort("motor") - runs[0].effort("motor")) < 1e-12 * largest(runs[0].effort("motor"))
    swung = planar.AngleDriver(joints[0], planar.Sine(0.3, 2.0), name="swing")
    with pytest.raises(ValueError, match="body 'crank': inertia 0, but its rate can change; give a number > 0"):
        planar.kinematics(planar.System(point.bodies, [*joints, swung]), times)
    bob = planar.Body("bob", 1.0, 0.0, com=(1.0, 0.0))
    with pytest.raises(ValueError, match="body 'bob': inertia 0"):
        planar.simulate(planar.System([bob], [planar.Revolute(planar.GROUND, bob, at=(0, 0))]), 1.0, dt=0.1)


@pytest.mark.parametrize("piece", [0.0, np.inf], ids=["many", "few"])
def test_pieces_leave_no_trace(piece, monkeypatch):
    """Runs go through Python now and then, so that Ctrl-C ends them; numbers are the same to the last bit."""
    normal = planar.simulate(four_bar(), 0.3, dt=1e-3, output=7), planar.kinematics(slider_crank(), np.arange(250) / 99)
    monkeypatch.setattr("engines.planar.runs.PIECE_SECONDS", piece)
    again = planar.simulate(four_bar(), 0.3, dt=1e-3, output=7), planar.kinematics(slider_crank(), np.arange(250) / 99)
    for one, two in zip(normal, again, strict=True):
        for part in one.system.bodies:
            assert np.array_equal(one.acceleration(part), two.acceleration(part.name))


def test_ctrl_c_ends_a_run(monkeypatch):
    calls = []

    def interrupted(*_):
        calls.append(_[-2:])
        if len(calls) == 3:
            raise KeyboardInterrupt
        return 0, 0, 0.0

    monkeypatch.setattr("engines.planar.runs.march", interrupted)
    with pytest.raises(KeyboardInterrupt):
        planar.simulate(four_bar(), 1e6, dt=1e-3, output=3)
    assert [begin for begin, _ in calls[1:]] == [end for _, end in calls[:-1]] and calls[0][0] == 0


def test_numbers_that_are_not_finite_name_their_body():
    """A spring without length has no direction; a free body has no joint to name."""
    still, part = body("still", (2, 2), 0.1), planar.Body("part", 1.0, 0.1, position=(1, 0))
    pull = planar.Spring(planar.GROUND, part, at_a=(0, 0), at_b=(1, 0), stiffness=1.0)
    hinge = planar.Revolute(planar.GROUND, still, at=(2, 2))
    drive = planar.SlideDriver(planar.Slider(planar.GROUND, part, at=(1, 0), axis=(1, 0)), planar.rate(-1.0))
    system = planar.System([still, part], [hinge, drive.through, drive], [pull])
    with pytest.raises(IntegrationError, match="not finite at t = 1 s: body 'part'; take a smaller dt, or keep the"):
        planar.simulate(system, 2.0, dt=0.125)


def test_pendulum_on_a_rolling_disc():
    """Lagrange's equations by hand, solved by scipy: x of the disc, angle of the bob from straight down."""
    M, I_disc, r, m, I_bob, arm, g = 1.9, 0.04, 0.25, 0.7, 0.02, 0.3, 9.81
    disc = planar.Body("disc", M, I_disc, position=(0.1, 0.2), com=(-0.1, r - 0.2))
    bob = planar.Body("bob", m, I_bob, position=(-0.4, r - 0.3), com=(0.4 - arm, 0.3), omega=2.5)
    wheel = planar.Rolling(planar.GROUND, disc, at=(0, 0), along=(1, 0), radius=r, name="wheel")
    pin = planar.Revolute(disc, bob, at=(0, r), name="pin")
    run = planar.simulate(planar.System([disc, bob], [wheel, pin], gravity=(0, -g)), 1.5, dt=2.5e-4, output=7)

    def slopes(_, state):
        _, angle, speed, w = state
        c, s = np.cos(angle), np.sin(angle)
        mass = [[M + I_disc / r**2 + m, m * arm * c], [m * arm * c, I_bob + m * arm**2]]
        return [speed, w, *np.linalg.solve(mass, [m * arm * w**2 * s, -m * g * arm * s])]

    start = [0.0, -np.pi / 2, -r * run.omega("disc")[0], 2.5]
    x, angle, *_ = solve_ivp(slopes, (0, 1.5), start, "DOP853", run.t, rtol=1e-12, atol=1e-13).y
    # RK4: (w h)^4 w t / 120 with w = 10 rad/s, 1e-11; the pair is not chaotic within one swing
    assert run.angle("bob") == pytest.approx(angle + np.pi / 2, abs=1e-9)
    assert -r * run.angle("disc") == pytest.approx(x, abs=1e-9)
    assert np.ptp(x) > 0.1


def test_linkage_of_peaucellier_draws_a_straight_line():
    """Seven bars, several in one pin: the inversion of a circle through the centre, x = (l^2 - s^2) / (2 a)."""
    a, long, side, start = 0.5, 1.1, 0.45, 0.2
    O, A = np.zeros(2), np.array([a, 0.0])
    Q = A + a * np.array([np.cos(start), np.sin(start)])
    out = Q / np.hypot(*Q)
    middle = (long**2 - side**2 + Q @ Q) / (2 * np.hypot(*Q))
    across = np.sqrt(long**2 - middle**2) * np.array([-out[1], out[0]])
    B, D, P = middle * out + across, middle * out - across, 2 * middle * out - Q
    bars = {"AQ": (A, Q), "OB": (O, B), "OD": (O, D), "BQ": (B, Q), "DQ": (D, Q), "BP": (B, P), "DP": (D, P)}
    parts = {name: body(name, (one + two) / 2, 0.3 * len(name)) for name, (one, two) in bars.items()}
    pins = [("AQ", "BQ", Q), ("AQ", "DQ", Q), ("OB", "BQ", B), ("OB", "BP", B), ("OD", "DQ", D), ("OD", "DP", D)]
    joints = [planar.Revolute(parts[one], parts[two], at=at) for one, two, at in [*pins, ("BP", "DP", P)]]
    motor = planar.Revolute(planar.GROUND, parts["AQ"], at=A)
    joints += [motor, *(planar.Revolute(planar.GROUND, parts[name], at=O) for name in ("OB", "OD"))]
    joints += [planar.AngleDriver(motor, planar.Sine(1.1, 2.0))]
    run = planar.kinematics(planar.System(list(parts.values()), joints, gravity=G), np.linspace(0, 3, 40))
    x, y = run.point("DP", parts["DP"].local_point(P)).T
    assert x == pytest.approx(np.full(40, (long**2 - side**2) / (2 * a)), abs=1e-13)
    assert np.ptp(y) > 1.0


def test_effort_of_a_slide_on_an_arm_that_turns():
    """Held at the distance r from the axis: -m w^2 r along the arm, wherever it points; the weight is off."""
    arm, load = body("arm", (0.1, 0.2), 0.4), planar.Body("load", 0.9, 0.02, position=(0.6, 0.8), angle=1.3)
    hinge = planar.Revolute(planar.GROUND, arm, at=(0, 0))
    rail = planar.Slider(arm, load, at=(0.6, 0.8), axis=(0.6, 0.8))
    ram = planar.SlideDriver(rail, planar.Polynomial((0.0,)), name="ram")
    motor = planar.AngleDriver(hinge, planar.rate(3.0))
    run = planar.kinematics(planar.System([arm, load], [hinge, rail, ram, motor], gravity=(0, 0)), np.arange(5) / 3)
    assert run.effort("ram") == pytest.approx(np.full(5, -0.9 * 9.0 * 1.0), rel=1e-12)


def test_torsion_spring_counts_from_the_reference_pose():
    """-k (0 - angle0) on b at the start, whichever way the bodies point; the opposite on a."""
    a, b = planar.Body("a", 1.0, 0.2, angle=0.7), planar.Body("b", 1.0, 0.05, angle=-1.9)
    spring = planar.TorsionSpring(a, b, stiffness=3.0, angle=0.4)
    run = planar.simulate(planar.System([a, b], (), [spring], (0, 0)), 0.1, dt=0.1)
    assert run.alpha("b")[0] == pytest.approx(3.0 * 0.4 / 0.05, rel=1e-14)
    assert run.alpha("a")[0] == pytest.approx(-3.0 * 0.4 / 0.2, rel=1e-14)


def test_a_slide_on_a_body_that_turns_does_not_hold_a_point_mass():
    arm, bob = body("arm", (0.1, 0.2), 0.4), planar.Body("bob", 1.0, 0.0, position=(0.6, 0.8))
    joints = [planar.Revolute(planar.GROUND, arm, at=(0, 0)), planar.Slider(arm, bob, at=(0.6, 0.8), axis=(1, 0))]
    with pytest.raises(ValueError, match="body 'bob': inertia 0, but its rate can change"):
        planar.simulate(planar.System([arm, bob], joints), 1.0, dt=0.1)
