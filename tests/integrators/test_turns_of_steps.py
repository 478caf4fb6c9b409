"""Turns are counted by the angular velocity, and poses that do not follow from it fail the certificate."""

import numpy as np
import pytest

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AngleDriver,
    Body,
    Gear,
    GeneralizedAlpha,
    Kinematic,
    Polynomial,
    Prismatic,
    RackPinion,
    RadauIIA,
    Revolute,
    RollingDisc,
    Screw,
    Spherical,
    System,
    Torque,
    TorsionSpring,
    load,
    measures,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix

AXIS = np.array([2.0, -1.0, 2.0]) / 3.0
ACROSS = np.array([1.0, 2.0, 0.0]) / np.sqrt(5.0)
ALONG = matrix(rotation(np.cross([0, 0, 1], AXIS), np.arccos(AXIS[2])))
SPUN = ALONG @ np.diag([0.06, 0.08, 0.1]) @ ALONG.T  # 0.1 kg m^2 about AXIS, its centre of mass on it
LONG_STEPS = [GeneralizedAlpha(), GeneralizedAlpha(dt=0.1), GeneralizedAlpha(rho=0.0), DOP853(), DOP853(dt=0.001)]


def wheel(moment=0.0, spin=0.0, name="wheel", at=(0.3, -0.2, 5.0)):
    """A wheel on an axis askew, its centre of mass off its reference point."""
    body = Body(name, 2.0, SPUN, com=0.2 * AXIS, position=at, omega=spin * AXIS, velocity=(0, 0, 0))
    hinge = Revolute(GROUND, body, at=at, axis=AXIS, name=f"hinge of {name}")
    return body, hinge, [Torque(body, moment * AXIS)] if moment else []


@pytest.mark.parametrize("method", LONG_STEPS, ids=str)
@pytest.mark.parametrize("moment", [5.0, -31.0])
def test_a_wheel_that_gathers_speed_counts_its_turns(method, moment):
    body, hinge, forces = wheel(moment)
    run = simulate(System([body], [hinge], forces), 2.0, method=method)
    # half of h^2/12 of the third derivative vanishes; DOP853 holds 2e-9 a step
    assert run.angle(hinge)[-1] == pytest.approx(moment / 0.1 * 2.0, rel=1e-7)
    assert run.certificate.passed
    stopped = simulate(
        System([body], [hinge], forces), 3.0, method=method,
        stop_when=measures.angle(hinge) > 80.0 if moment > 0.0 else measures.angle(hinge) < -80.0,
    )  # fmt: skip
    assert stopped.final.t == pytest.approx(np.sqrt(2.0 * 80.0 * 0.1 / abs(moment)), rel=1e-7)


@pytest.mark.parametrize("method", [GeneralizedAlpha(), GeneralizedAlpha(dt=0.05), RadauIIA(dt=0.02)], ids=str)
@pytest.mark.parametrize("ratio", [-0.37, 2.0, 3.3])
def test_geared_wheels_count_alike(method, ratio):
    body, hinge, forces = wheel(5.0)
    other, second, _ = wheel(name="other", at=(1.3, 0.4, 2.0))
    run = simulate(System([body, other], [hinge, second, Gear(hinge, second, ratio=ratio)], forces), 1.5, method=method)
    turned = 0.5 * 5.0 / (0.1 * (1.0 + ratio**2)) * 1.5**2
    assert run.angle(hinge)[-1] == pytest.approx(turned, rel=1e-7)
    assert run.angle(second)[-1] == pytest.approx(ratio * turned, rel=1e-7)
    assert run.certificate.passed


@pytest.mark.parametrize("method", [GeneralizedAlpha(), DOP853()], ids=str)
def test_racks_and_screws_behind_a_wheel_travel_as_far_as_it_turns(method):
    body, hinge, forces = wheel(5.0)
    sled = Body("sled", 0.5, (0.01, 0.02, 0.03), com=(0.1, 0.02, -0.1), position=(0.5, 0, 0))
    slide = Prismatic(GROUND, sled, at=(0.5, 0, 0), axis=ACROSS, name="slide")
    rack = System([body, sled], [hinge, slide, RackPinion(hinge, slide, radius=0.05)], forces, gravity=(0, 0, 0))
    run = simulate(rack, 2.0, method=method)
    turned = 5.0 / (0.1 + 0.5 * 0.05**2) * 2.0
    assert run.position(sled)[-1] - (0.5, 0, 0) == pytest.approx(0.05 * turned * ACROSS, rel=1e-7)
    assert run.certificate.passed
    nut = Body("nut", 0.5, (0.01, 0.02, 0.03), com=(0.1, 0.02, -0.1), position=(0.3, -0.2, 5.0))
    bed = Prismatic(GROUND, nut, at=(0.3, -0.2, 5.0), axis=AXIS, name="bed")
    screw = Screw(nut, body, at=(0.3, -0.2, 5.0), axis=AXIS, pitch=0.03)
    run = simulate(System([body, nut], [hinge, bed, screw], forces, gravity=(0, 0, 0)), 2.0, method=method)
    lead = 0.03 / (2.0 * np.pi)
    assert abs(run.slide(bed)[-1]) == pytest.approx(lead * 5.0 / (0.1 + 0.5 * lead**2) * 2.0, rel=1e-7)
    assert run.certificate.passed


def test_a_lead_screw_keeps_to_its_forces_in_fixed_steps():
    """Four of its rows repeat others; what they leave open of the multipliers grew until Newton's method failed."""
    body, hinge, forces = wheel(0.5)
    nut = Body("nut", 0.5, (0.01, 0.02, 0.03), com=(0.1, 0.02, -0.1), position=(0.3, -0.2, 5.0))
    bed = Prismatic(GROUND, nut, at=(0.7, -0.4, 5.4), axis=AXIS, name="bed")
    screw = Screw(body, nut, at=(0.7, -0.4, 5.4), axis=AXIS, pitch=0.03)
    system, lead = System([body, nut], [hinge, bed, screw], forces, gravity=(0, 0, 0)), 0.03 / (2.0 * np.pi)
    run = simulate(system, 2.0, method=GeneralizedAlpha(dt=0.003))
    assert run.angle(hinge)[-1] == pytest.approx(0.5 / (0.1 + 0.5 * lead**2) * 2.0, rel=1e-9)
    assert run.certificate.passed


@pytest.mark.parametrize("step", [0.02, 0.05])
def test_fixed_collocation_turns_by_radians_in_a_step(step):
    """Newton's method was given up while the way of the reference point had yet to follow the turn."""
    body, hinge, _ = wheel(spin=40.0)
    run = simulate(System([body], [hinge]), 2.0, method=RadauIIA(dt=step))
    assert abs(run.angle(hinge)[-1] - 80.0) < 1e-2 or not run.certificate.passed


@pytest.mark.parametrize("method", [GeneralizedAlpha(), RadauIIA(), DOP853()], ids=str)
def test_a_torsion_spring_takes_up_many_turns(method):
    """A soft spring, wound by 9 rad a step and more: theta = w / s sin(s t)."""
    body, hinge, _ = wheel(spin=90.0)
    system = System([body], [hinge], [TorsionSpring(hinge, stiffness=0.02)])
    run = simulate(system, 3.0, method=method, rtol=1e-5)
    s = np.sqrt(0.02 / 0.1)
    assert run.angle(hinge)[-1] == pytest.approx(90.0 / s * np.sin(3.0 * s), abs=0.05)
    assert run.certificate.passed


@pytest.mark.parametrize(
    ("method", "spin", "t_end"),
    [(RK4(0.05), 100.0, 2.0), (RK4(0.03), -47.0, 3.0), (RK4(0.02), 37.0, 40.0), (DOP853(dt=0.2), 71.0, 3.0)], ids=str,
)  # fmt: skip
def test_poses_that_do_not_follow_their_velocity_fail(method, spin, t_end):
    body, hinge, _ = wheel(spin=spin)
    system = System([body], [hinge])
    run = simulate(system, t_end, method=method)
    wrong = abs(run.angle(hinge)[-1] - spin * t_end)
    assert wrong > 1e-2  # and all balances are met
    assert {"orientations"} <= {c.name for c in run.certificate.checks if not c.passed} <= {
        "orientations", "turns of hinges",
    }  # fmt: skip
    assert run.certificate["orientations"].error >= 0.99 * wrong
    assert "'wheel'" in " ".join(run.certificate.failures)
    shorter = simulate(system, t_end, method=type(method)(dt=method.dt / 16))
    assert shorter.certificate.passed and shorter.angle(hinge)[-1] == pytest.approx(spin * t_end, abs=1e-2)


def free(spin, moments=(0.05, 0.08, 0.11)):
    """A free body, its centre of mass off its reference point."""
    return System([Body("free", 1.3, moments, com=(0.03, -0.02, 0.05), velocity=(0.2, 0.1, -0.3), omega=spin)])


@pytest.mark.parametrize("spin", [(0.0, 0.0, 60.0), (20.0, -30.0, 40.0)])
def test_a_free_ball_in_long_fixed_steps_fails(spin):
    """All three moments are equal: where it points to does not act back on anything."""
    run = simulate(free(spin, (0.07, 0.07, 0.07)), 2.0, method=RK4(0.04))
    right = rotation(np.array(spin) / np.linalg.norm(spin), 2.0 * np.linalg.norm(spin))
    assert between(matrix(right), run.rotation("free")[-1]) > 0.1
    assert not run.certificate["orientations"].passed


@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-8, 1e-12])
@pytest.mark.parametrize("method", [DOP853(), RadauIIA(), GeneralizedAlpha()], ids=str)
def test_runs_that_are_right_pass(method, rtol):
    """The formula errs by more than the steps of order eight: that is no fault of theirs."""
    if isinstance(method, GeneralizedAlpha) and not 1e-6 < rtol < 1e-2:
        return  # too many steps, or too few to be right
    for system in (free((6.0, -9.0, 4.0)), free((1.0, 90.0, -2.0)), free((7.0, 2.0, 80.0), (0.05, 0.05, 0.08))):
        run = simulate(system, 3.0, method=method, rtol=rtol)
        assert run.certificate["orientations"].passed


def test_a_line_says_that_a_body_turned_far_and_files_keep_it(tmp_path):
    body, hinge, _ = wheel(spin=30.0)
    run = simulate(System([body], [hinge]), 1.0, method=GeneralizedAlpha(dt=0.1))
    assert "'wheel' turned by 3 rad in a step" in run.certificate.global_error and run.certificate.passed
    again = load(run.save(tmp_path / "run.npz"))
    assert str(again.certificate) == str(run.certificate)
    for method in (GeneralizedAlpha(dt=0.02), DOP853()):
        assert simulate(System([body], [hinge]), 1.0, method=method).certificate.global_error.startswith("unknown;")


def between(one, other):
    """Angles [rad] between rotation matrices: sqrt(8) times the sine of the half is the norm of their difference."""
    return 2.0 * np.arcsin(np.minimum(np.linalg.norm(one - other, axis=(-2, -1)) / np.sqrt(8.0), 1.0))


def apart(run, other, body):
    """Largest angle [rad] between the orientations of a body in two runs."""
    return between(run.rotation(body), other.rotation(body)).max()


def rolling(kind):
    """A ball or a disc that rolls on a plane that is tilted across its way; from rest or fast."""
    R = 0.11
    start = {"velocity": (1.3, 0.4, 0), "omega": (-0.4 / R, 1.3 / R, 0)} if kind == "fast" else {}
    ball = Body("ball", 1.7, (0.4 * 1.7 * R**2,) * 3, position=(2.0, -1.0, R), **start)
    joint = RollingDisc(GROUND, ball, axis=(0, 1, 0), radius=R, crown=R)
    return System([ball], [joint], gravity=(2.9, 1.1, -9.3))


@pytest.mark.parametrize("method", [GeneralizedAlpha(), RadauIIA()], ids=str)
@pytest.mark.parametrize("kind", ["fast", "from rest"])
def test_samples_between_long_steps_are_as_exact_as_the_steps(method, kind):
    """A ball rolls with an even acceleration: 5/7 of that of a slide, and its turn follows from the way."""
    system, times = rolling(kind), np.linspace(0.0, 2.0, 101)
    run = simulate(system, 2.0, method=method, rtol=2e-4, output=times)
    exact = simulate(system, 2.0, rtol=1e-12, output=times)
    steps = simulate(system, 2.0, method=method, rtol=2e-4)
    way = np.array([1.3, 0.4]) * (kind == "fast") * 2.0 + 0.5 * 5.0 / 7.0 * np.array([2.9, 1.1]) * 4.0
    assert exact.position("ball")[-1, :2] - (2.0, -1.0) == pytest.approx(way, rel=1e-9)
    error_at_steps = apart(steps, simulate(system, 2.0, rtol=1e-12, output=steps.t), "ball")
    assert apart(run, exact, "ball") < 2.0 * error_at_steps + 2e-3
    assert np.abs(run.omega("ball") - exact.omega("ball")).max() < 2e-3 * np.abs(exact.omega("ball")).max()


def test_driven_wheels_count_between_far_poses():
    """A driver that gathers speed, and a gear behind it; poses at both ends only are asked for."""
    body, hinge, _ = wheel()
    other, second, _ = wheel(name="other", at=(1.3, 0.4, 2.0))
    motor = AngleDriver(hinge, Polynomial((0.0, 0.0, 3.0, 2.0)))
    system = System([body, other], [hinge, second, motor, Gear(hinge, second, ratio=-2.7)])
    run = simulate(system, 3.0, method=Kinematic(), output=[0.0, 3.0])
    assert run.angle(second)[-1] == pytest.approx(-2.7 * (3.0 * 9.0 + 2.0 * 27.0), rel=1e-12)
    assert run.certificate.passed and run.certificate["turns of hinges"].error < 0.1


def test_angles_that_are_no_coordinate_of_the_run_are_followed_by_both_rates():
    """The heading of a body that gathers speed about the vertical, from samples many turns apart."""
    body = Body("ball", 2.0, (0.1, 0.12, 0.1), com=(0, 0, 0.2), position=(0.3, -0.2, 5.0), omega=(0, 0, 0))
    joint = Spherical(GROUND, body, at=(0.3, -0.2, 5.0))
    run = simulate(System([body], [joint], [Torque(body, (0, 0, 5.0))]), 2.0, output=3)
    assert run.measure(measures.heading(body)) == pytest.approx(25.0 * np.array([0.0, 1.0, 4.0]), rel=1e-7)


@pytest.mark.parametrize(("power", "turned"), [(2, 4.1), (3, 2.7), (3, -3.3)])
def test_a_fixed_step_in_which_a_motion_begins_is_checked_too(power, turned):
    """theta = turned (t / dt)^(power + 2): at the start of the step nothing says that the wheel will turn."""
    body, hinge, _ = wheel()
    dt, terms = 0.3, (power + 1) * (power + 2)
    moment = Polynomial([0.0] * power + [0.1 * turned * terms / dt ** (power + 2)])
    system = System([body], [hinge], [Torque(body, [float(x) * moment for x in AXIS])], gravity=(0, 0, 0))
    run = simulate(system, dt, method=DOP853(dt=dt))
    assert abs(run.angle(hinge)[-1] - turned) > 6.0  # the mean of its rates tells another turn
    assert "turns of hinges" in {c.name for c in run.certificate.checks if not c.passed}
    shorter = simulate(system, dt, method=DOP853(dt=dt / 8))
    assert shorter.angle(hinge)[-1] == pytest.approx(turned, rel=1e-6) and shorter.certificate.passed
