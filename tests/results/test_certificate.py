"""The certificate: silent on clean runs, and under every teaching switch it fails the check that must see it."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.models import (
    all_joints_mechanism,
    consistent_state,
    direction,
    middle,
    moved_reference,
    pendulum,
    random_body,
    revolute_chain,
    signal,
    spinning_wheel,
)
from scipy.integrate import solve_ivp
from scipy.linalg import expm

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AeroDrag,
    AngleDriver,
    Body,
    Bushing,
    Fixed,
    Force,
    GeneralizedAlpha,
    JointFriction,
    Kinematic,
    Prismatic,
    Pulse,
    RadauIIA,
    Ramp,
    Revolute,
    Spherical,
    SpringDamper,
    System,
    Torque,
    TorsionSpring,
    accelerations,
    measures,
    simulate,
)
from mbsd3d.results.checks.check import drift_limit
from mbsd3d.rotations import matrix
from mbsd3d.run.global_error import doubling_time, estimate
from validation import cases
from validation.cases.comparison import compare
from validation.suite.trials.references import allowed

CHECKS = {
    "joint gaps", "joint velocities", "orientations", "turns of hinges", "energy balance", "momentum balance",
    "angular momentum", "Newton-Euler", "acceleration rows", "accelerations", "reactions",
}  # fmt: skip


def swinging():
    """(system, state): a body of general shape on a skew hinge, started with 4 rad/s."""
    system, _, hinge = pendulum()
    return system, system.assemble(rates={hinge: 4.0})


def spinning():
    """The fast top with its reference point off pivot and centre of mass."""
    system = cases.load("heavy_top_fast", 7).system
    return system, system.state()


def loop():
    """Bricard's six bars, one redundant row."""
    system = cases.load("iftomm_A04_bricard", 7).system
    return system, system.state()


def everything():
    """All joints and drivers, redundant rows."""
    system = all_joints_mechanism(3)
    return system, consistent_state(system, np.random.default_rng(3))


def tumbling():
    """A free body under its weight."""
    body = random_body(np.random.default_rng(71), omega=(1.0, -2.0, 3.0), velocity=(0.1, 0.2, 0.3))
    system = System(bodies=[body])
    return system, system.state()


MECHANISMS = [swinging, spinning, loop, everything, tumbling]
HELD = [swinging, spinning, loop, everything]
"""Those with joints."""


def run(mechanism, **options):
    """Half a second, 51 samples."""
    system, state = mechanism()
    return simulate(system, 0.5, state=state, **{"output": 51, **options})


def failed(solution):
    """Names of the checks that failed."""
    return {check.name for check in solution.certificate.checks if not check.passed}


@pytest.mark.parametrize("mechanism", MECHANISMS)
@pytest.mark.parametrize(
    "options", [{}, {"rtol": 1e-4}, {"rtol": 1e-12}, {"method": RK4(1e-3)}, {"method": DOP853(dt=2e-3)}]
)
def test_clean_runs_pass(mechanism, options):
    certificate = run(mechanism, **options).certificate
    assert certificate.passed and certificate.failures == ()
    assert "passed" in str(certificate)


@pytest.mark.parametrize("mechanism", HELD)
def test_every_check_is_made(mechanism):
    made = run(mechanism)
    expected = CHECKS if made.compiled.model.coordinate.size else CHECKS - {"turns of hinges"}  # where there are some
    assert {check.name for check in made.certificate.checks} == expected


def still(kind):
    """Mechanisms at rest, far away, or very fast, whose checks still need a scale."""
    rng = np.random.default_rng(72)
    body = random_body(rng)
    at = body.position + 0.2
    if kind == "at rest without gravity":
        return System(bodies=[body], gravity=(0, 0, 0))
    if kind == "falling from rest":
        return System(bodies=[body])
    if kind == "held still":
        return System(bodies=[body], joints=[Fixed(GROUND, body, at=at)])
    if kind == "two hinges on one axis":
        axis = direction(rng)
        return System(bodies=[body], joints=[Revolute(GROUND, body, at=at + x * axis, axis=axis) for x in (0.0, 0.7)])
    if kind == "reference point a kilometre away":
        far = moved_reference(body, np.array([600.0, -700.0, 300.0]))
        return System(bodies=[far], joints=[Revolute(GROUND, far, at=at, axis=direction(rng))])
    return System(bodies=[random_body(rng, velocity=(1e3, -2e3, 5e2), omega=(2.0, 1.0, -3.0))])


@pytest.mark.parametrize(
    "kind",
    [
        "at rest without gravity",
        "falling from rest",
        "held still",
        "two hinges on one axis",
        "reference point a kilometre away",
        "fast",
    ],
)
def test_limiting_runs_pass(kind):
    assert simulate(still(kind), 1.0).certificate.failures == ()


@pytest.mark.parametrize("size", [1e-6, 1e-3, 1e3])
def test_the_unit_of_length_does_not_matter(size):
    """The same pendulum at another scale, density and gravity kept, time scaled by the root."""
    body = random_body(
        np.random.default_rng(73), mass=1.3 * size**3, inertia=np.diag((0.1, 0.2, 0.15)) * size**5,
        com=size * np.array((0.1, 0.2, -0.1)), position=size * np.array((0.3, -0.2, 0.1)),
    )  # fmt: skip
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(1.0, 0.2, 0.3))
    clean = simulate(System(bodies=[body], joints=[hinge]), np.sqrt(size), output=21)
    wrong = simulate(System(bodies=[body], joints=[hinge]), np.sqrt(size), output=21, centripetal=False)
    assert clean.certificate.passed and not wrong.certificate.passed


def test_errors_are_the_same_numbers_at_any_size():
    """The same without gamma and projection, which tears the hinge: relative errors of 1e-2 and more."""
    found, joints = [], ("joint gaps", "joint velocities", "acceleration rows")
    for size in (1.0, 1e-3):
        body = random_body(
            np.random.default_rng(73), mass=1.3 * size**3, inertia=np.diag((0.1, 0.2, 0.15)) * size**5,
            com=size * np.array((0.1, 0.2, -0.1)), position=size * np.array((0.3, -0.2, 0.1)),
        )  # fmt: skip
        system = System([body], [Revolute(GROUND, body, at=(0, 0, 0), axis=(1.0, 0.2, 0.3))])
        method = RK4(0.01 * np.sqrt(size))
        run = simulate(system, np.sqrt(size), output=21, gamma=False, stabilisation="none", method=method)
        found.append([run.certificate[name].error for name in joints])
    assert min(found[0]) > 1e-3 and found[1] == pytest.approx(found[0], rel=1e-9)  # rounding over 100 steps


@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_without_the_gyroscopic_term_momentum_fails_and_energy_does_not(mechanism):
    solution = run(mechanism, gyroscopic=False)
    certificate = solution.certificate
    assert {"angular momentum", "Newton-Euler"} <= failed(solution)
    assert certificate["energy balance"].passed  # w . (w x I w) = 0: energy cannot see it
    assert any("inertial term" in text for text in certificate.failures)
    assert "without gyroscopic" in str(certificate) and "FAILED" in str(certificate)


@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_without_the_centripetal_force_momentum_fails(mechanism):
    """It acts at the centre of mass of its body: the angular momentum about that of the whole sees it of several."""
    solution = run(mechanism, centripetal=False)
    seen = {"angular momentum"} if len(solution.system.bodies) > 1 else set()
    assert {"momentum balance", "Newton-Euler", *seen} <= failed(solution)
    assert "without centripetal" in str(solution.certificate)


@pytest.mark.parametrize("mechanism", MECHANISMS)
def test_switches_fail_by_a_hundred_limits(mechanism):
    for switch in ("gyroscopic", "centripetal"):
        check = run(mechanism, **{switch: False}).certificate["Newton-Euler"]
        assert check.error > 100 * check.limit


@pytest.mark.parametrize("mechanism", HELD)
def test_without_gamma_accelerations_tear_the_joints_though_the_pose_is_projected(mechanism):
    solution = run(mechanism, gamma=False)
    assert {"acceleration rows", "momentum balance"} <= failed(solution)
    assert solution.certificate["joint gaps"].passed
    check = solution.certificate["acceleration rows"]
    assert check.error > 100 * check.limit
    assert "without gamma" in str(solution.certificate)


@pytest.mark.parametrize("mechanism", [swinging, spinning])
def test_without_gamma_and_projection_the_joints_come_apart(mechanism):
    solution = run(mechanism, gamma=False, stabilisation="none")
    assert {"joint gaps", "joint velocities", "acceleration rows"} <= failed(solution)
    assert solution.drift().position.max() > 0.1
    assert "joints drift apart" in " ".join(solution.certificate.failures)


@pytest.mark.parametrize("method", [DOP853(), RK4(0.01), GeneralizedAlpha(0.01), RadauIIA()])
@pytest.mark.parametrize("speed", [1e-3, 2.0, 300.0])
def test_a_slide_at_constant_speed_in_two_guides_passes(method, speed):
    """Its accelerations are rounding of its velocity, which is no scale for the rows that hold them."""
    car, axis = Body("car", 2.0, (0.1, 0.2, 0.3), com=(0.1, 0.2, 0.3)), np.array([1.0, 2.0, -0.5])
    guides = [Prismatic(GROUND, car, at=at, axis=axis, name=f"guide {at}") for at in ((0, 0, 0), (0, 0.5, 0.7))]
    system = System([car], guides, gravity=(0, 0, 0))
    solution = simulate(system, 2.0, state=system.assemble(rates={guides[0]: speed}), method=method)
    assert solution.certificate.passed, str(solution.certificate)


def test_a_free_body_has_no_rows_to_miss():
    assert run(tumbling, gamma=False, stabilisation="none").certificate.passed


@pytest.mark.parametrize("mechanism", HELD)
def test_without_stabilisation_coarse_steps_drift(mechanism):
    solution = run(mechanism, stabilisation="none", method=RK4(0.01))
    assert {"joint gaps", "joint velocities"} <= failed(solution)
    assert "stabilisation none" in str(solution.certificate)


def test_without_stabilisation_drift_grows_over_a_long_run():
    system, state = swinging()
    solution = simulate(system, 20.0, state=state, stabilisation="none", method=RK4(0.01), output=21)
    gaps = solution.drift().position
    assert gaps[-1] > 5 * gaps[1] > 0
    assert "joint gaps" in failed(solution)


@pytest.mark.parametrize("stabilisation", ["none", "baumgarte"])
def test_states_of_a_run_without_projection_have_unit_quaternions(stabilisation):
    solution = run(everything, stabilisation=stabilisation, method=RK4(0.01))
    raw, state = (q.reshape(-1, 7)[:, 3:] for q in (solution.arrays["q"][-1], solution.final.q))
    assert np.abs(np.linalg.norm(raw, axis=1) - 1.0).max() > 1e-10  # they drift with the steps
    assert np.linalg.norm(state, axis=1) == pytest.approx(np.ones(len(state)), abs=1e-15)  # rounding
    # the same rotations: ten roundings of numbers up to 1
    assert matrix(state) == pytest.approx(matrix(raw), abs=10 * np.finfo(float).eps)


def test_baumgarte_keeps_the_drift_small():
    system, state = swinging()
    options = dict(state=state, method=RK4(0.01), output=21)
    none, baumgarte = (simulate(system, 20.0, stabilisation=s, **options) for s in ("none", "baumgarte"))
    assert {"joint gaps", "joint velocities"} <= failed(none)
    assert not failed(baumgarte)  # held to what the integration errs, since it does not project
    coarse = simulate(system, 20.0, stabilisation="baumgarte", **{**options, "method": RK4(0.05)})
    assert "joint gaps" in failed(coarse)
    assert baumgarte.drift().position.max() < 0.1 * none.drift().position.max()
    assert "stabilisation baumgarte" in str(baumgarte.certificate)


def test_baumgarte_passes_at_coarse_tolerances():
    """The equations of bodies hold as far as the joints are closed, which the motion is not the worse for."""
    system, options = revolute_chain(3), dict(output=21)
    coarse = simulate(system, 1.0, stabilisation="baumgarte", rtol=1e-3, **options)
    true = simulate(system, 1.0, **options)
    assert np.abs(coarse.position(system.bodies[-1]) - true.position(system.bodies[-1])).max() < 1e-2
    assert not failed(coarse)
    assert coarse.certificate["Newton-Euler"].error > 1e-8


@pytest.mark.parametrize("factors", [(5.0, 10.0), (20.0, 100.0), (60.0, 900.0)])
def test_baumgarte_factors_are_used(factors):
    """c_ddot + a c_dot + b c = 0 from a start with a gap: its closed form."""
    body = random_body(np.random.default_rng(74), com=(0, 0, 0))
    pin = Fixed(GROUND, body, at=body.position)
    system = System(bodies=[body], joints=[pin], gravity=(0, 0, 0))
    start = system.state()
    start.q[0] += 1e-3
    solution = simulate(
        system, 0.3, state=start, stabilisation="baumgarte", baumgarte=factors, rtol=1e-12, output=[0.1, 0.2, 0.3]
    )
    a, b = factors
    gap = np.array([expm(np.array([[0.0, 1.0], [-b, -a]]) * t)[0, 0] for t in solution.t])
    moved = solution.position(body)[:, 0] - body.position[0]
    assert moved == pytest.approx(1e-3 * gap, abs=1e-11)  # rtol times a length of one


def test_a_redundant_loop_without_projection_drifts_and_goes_on():
    system, state = loop()
    solution = simulate(system, 10.0, state=state, stabilisation="none", method=RK4(0.01), output=51)
    assert "joint gaps" in failed(solution)


def test_coarse_steps_are_found_out():
    """A top turned by 1.5 rad a step: nothing is left of it, though every joint is closed."""
    solution = run(spinning, method=RK4(0.01))
    assert "energy balance" in failed(solution)
    assert solution.certificate["joint gaps"].passed


FORCES = ("driver", "damper", "hinge spring", "friction", "drag", "bushing", "push", "twist")


def worked(which):
    """Two bodies in a chain, with a driver or a force that does work."""
    rng = np.random.default_rng(75)
    a, b = random_body(rng, "a"), random_body(rng, "b")
    first = Revolute(GROUND, a, at=middle(rng, a, a), axis=direction(rng), name="first")
    second = Revolute(a, b, at=middle(rng, a, b), axis=direction(rng), name="second")
    anchor = dict(at_a=(1.0, 2.0, -1.0), at_b=b.position + 0.3)
    forces = {
        "damper": lambda: SpringDamper(GROUND, b, **anchor, stiffness=20.0, damping=5.0, name="damper"),
        "hinge spring": lambda: TorsionSpring(second, stiffness=8.0, damping=2.0, angle=0.5, name="hinge spring"),
        "friction": lambda: JointFriction(second, coulomb=3.0, viscous=1.0, transition=0.5, name="friction"),
        "drag": lambda: AeroDrag(b, drag_area=2.0, at=b.position + 0.2, wind=(3.0, 0.0, 1.0), name="drag"),
        "bushing": lambda: Bushing(
            GROUND, b, at=b.position + 0.1, stiffness=30.0, turning_stiffness=9.0, damping=4.0, turning_damping=2.0,
            name="bushing",
        ),
        "push": lambda: Force(b, (signal(rng, 5.0), 3.0, -4.0), b.position + 0.2, "body", name="push"),
        "twist": lambda: Torque(b, (signal(rng, 5.0), 3.0, -4.0), "body", name="twist"),
    }  # fmt: skip
    joints = [first, second, *([AngleDriver(first, signal(rng), name="driver")] if which == "driver" else [])]
    return System(bodies=[a, b], joints=joints, forces=[forces[which]()] if which in forces else [])


@pytest.mark.parametrize("which", FORCES)
def test_energy_balance_holds_with_the_work_of(which):
    solution = simulate(worked(which), 1.0, rtol=1e-10, output=101)
    energy, check = solution.energy(), solution.certificate["energy balance"]
    assert solution.certificate.passed
    gained, work = (x - x[0] for x in (energy.total, energy.work))
    scale = np.ptp(energy.kinetic)
    assert gained == pytest.approx(work, abs=1e-8 * scale)  # 100 rtol
    assert np.abs(work).max() > 1e-3 * scale
    # without the work the check would fail by far
    assert np.abs(work).max() / scale > 100 * check.limit


@pytest.mark.parametrize("which", [name for name in FORCES if name != "driver"])
def test_work_is_the_integral_of_the_power(which):
    solution = simulate(worked(which), 1.0, rtol=1e-10, output=2001)
    power, work = solution.arrays["power"].sum(axis=1), solution.energy().work
    simpson = (power[:-2:2] + 4 * power[1:-1:2] + power[2::2]) * 0.5e-3 / 3
    # Simpson's rule at 0.5 ms; the dry friction turns within 0.05 s
    assert work[-1] - work[0] == pytest.approx(simpson.sum(), abs=1e-6 * np.abs(power).max())


@pytest.mark.parametrize("which", ["damper", "hinge spring", "friction"])
def test_dissipation_only_takes_energy(which):
    solution = simulate(worked(which), 1.0, rtol=1e-10, output=101)
    assert (np.diff(solution.energy().work) <= 0).all()


def test_effort_times_rate_is_the_power_of_a_driver():
    system = worked("driver")
    solution = simulate(system, 1.0, rtol=1e-10, output=2001)
    power = solution.effort("driver") * solution.rate("first")
    simpson = (power[:-2:2] + 4 * power[1:-1:2] + power[2::2]) * 0.5e-3 / 3
    assert solution.energy().work[-1] == pytest.approx(simpson.sum(), rel=1e-8)  # Simpson's rule


def test_kinematic_runs_are_checked_by_the_equations():
    rng = np.random.default_rng(76)
    body = random_body(rng)
    hinge = Revolute(GROUND, body, at=(0.1, 0.2, -0.1), axis=direction(rng))
    system = System(bodies=[body], joints=[hinge, AngleDriver(hinge, Ramp(3.0))])
    clean = simulate(system, 1.0, method=Kinematic(), output=21)
    wrong = simulate(system, 1.0, method=Kinematic(), output=21, centripetal=False)
    assert clean.certificate.passed
    assert failed(wrong) == {"Newton-Euler"}


def test_work_in_a_kinematic_run_is_of_second_order_in_the_distance_of_poses():
    """A motor at a steady rate only lifts: its work is the change of the potential energy, exact at every pose."""
    body = random_body(np.random.default_rng(76))
    hinge = Revolute(GROUND, body, at=body.position + 0.4, axis=(0.3, 1.0, 0.2))
    motor = AngleDriver(hinge, Ramp(2.3), name="motor")
    system, gaps = System(bodies=[body], joints=[hinge, motor]), []
    for step in (1 / 32, 1 / 64, 1 / 128):
        solution = simulate(system, 1.25, method=Kinematic(max_step=step), output=2)
        energy = solution.energy()
        assert np.ptp(energy.kinetic) < 1e-12 and abs(np.ptp(energy.potential)) > 1.0  # rounding; it does lift
        gaps.append(abs(energy.total[-1] - energy.total[0] - solution.work(motor)[-1]))
    order = np.log2(np.array(gaps[:-1]) / gaps[1:])
    assert order == pytest.approx([2.0, 2.0], abs=0.01)  # steps up to 0.07 rad, squared


def test_counts_of_the_run():
    certificate = run(loop).certificate
    assert certificate.evaluations >= 12 * certificate.steps
    assert certificate.rank_events == ()
    assert certificate.rtol == 1e-8 and "DOP853" in certificate.method
    with pytest.raises(KeyError, match="joint gaps"):
        certificate["gaps"]


def test_change_point_of_the_four_bar_is_passed():
    case = cases.load("iftomm_A02_fourbar_N2")
    solution = simulate(case.system, case.t_end, rtol=1e-8, output=case.times)
    assert compare(case, solution).scaled_error < allowed(case, 1e-8)
    assert solution.certificate.passed, solution.certificate.failures


def test_a_sample_close_to_a_change_point_passes_and_says_so():
    """A parallelogram without weight turns steadily; a sample, and no step, comes to 1e-5 rad of where it is flat."""
    lean, rate, length, width = 1.1, -2.3, 0.7, 1.3
    up = length * np.array([np.cos(lean), np.sin(lean), 0.0])
    feet, axis = (np.zeros(3), np.array([width, 0.0, 0.0])), (0, 0, 1)
    cranks = [
        Body(f"crank {k}", 1.0 + k, (0.1, 0.2, 0.15), com=(0.1, -0.2, 0.05), position=foot + (0.2, 0.1 + k, -0.3),
             omega=(0, 0, rate))
        for k, foot in enumerate(feet)
    ]  # fmt: skip
    rod = Body("rod", 2.0, (0.3, 0.2, 0.25), com=(0.3, 0.1, 0), position=feet[1] + up)
    joints = [Revolute(GROUND, crank, at=foot, axis=axis) for crank, foot in zip(cranks, feet, strict=True)]
    joints += [Revolute(crank, rod, at=foot + up, axis=axis) for crank, foot in zip(cranks, feet, strict=True)]
    times = [0.0, (lean - 1e-5) / -rate, 0.8]
    solution = simulate(System([*cranks, rod], joints, gravity=(0, 0, 0)), 0.8, output=times)
    assert solution.angle(joints[0]) == pytest.approx(rate * np.array(times), abs=1e-7)
    certificate = solution.certificate
    assert certificate.passed, certificate.failures
    assert certificate["acceleration rows"].error > 1e-8  # rows that are let go there are missed
    assert any("singular position" in note for note in certificate.notes)


@pytest.mark.parametrize(
    ("nearest", "limit"), [(1.0, 1e-9), (1e-2, 1e-9), (2e-4, 1.5e-8), (1e-4, 3e-8), (5e-7, 5e-7), (0.0, 5e-7)]
)
def test_limit_of_a_tight_run_widens_with_what_rounding_does_near_a_singular_position(nearest, limit):
    """Without a jump: as rounding over the least pivot, and never by more than a run over many of them leaves."""
    record = replace(run(loop, rtol=1e-12).record, nearest=nearest)
    assert drift_limit(record) == pytest.approx(limit)


def test_a_stop_is_told_and_is_no_failure():
    system, _, hinge = pendulum()
    state = system.assemble(rates={hinge: 2.0})
    solution = simulate(system, 1.0, state=state, stop_when=measures.angle(hinge) > 0.2)
    assert solution.certificate.passed
    assert "angle" in solution.certificate.stopped_by and "0.2" in str(solution.certificate)


def top_error(solution, case):
    """True greatest rotation error [rad] at the reference times."""
    columns = compare(case, solution).columns
    return 2 * np.linalg.norm([np.abs(columns[f"q_{k}"][0] - columns[f"q_{k}"][1]).max() for k in "wxyz"])


@pytest.mark.parametrize("shift", [None, 7])
@pytest.mark.parametrize("options", [{"rtol": 1e-6}, {"rtol": 1e-8}, {"rtol": 1e-10}, {"method": RK4(5e-4)}])
def test_estimate_is_near_the_true_error(options, shift):
    case = cases.load("heavy_top_fast", shift)
    solution = simulate(case.system, 2.0, output=case.times, **options)
    found, true = solution.estimate(), top_error(solution, case)
    assert found.error is not None and true / 30 < found.error < 30 * true  # of the brief
    assert f"{found.error:.2e}" in str(found)


def test_estimate_is_the_angle_that_a_wheel_lags_behind():
    system, hinge = spinning_wheel(31.0)
    solution = simulate(system, 1.0, method=DOP853(dt=0.1))
    lag = np.abs(solution.angle(hinge) - 31.0 * solution.t).max()
    assert lag > 1e-5  # far above the tightest run's own, smaller by 4^8
    assert solution.estimate().error == pytest.approx(lag, rel=1e-3)


# errors of 2e-6 and 1e-8: far above rounding, also after two halvings of the step
@pytest.mark.parametrize(("method", "order"), [(RK4(5e-4), 4.0), (DOP853(dt=4e-3), 8.0)])
def test_estimate_observes_the_order(method, order):
    case = cases.load("heavy_top_fast", 7)
    solution = simulate(case.system, 0.5, output=6, method=method)
    assert solution.estimate().order == pytest.approx(order, abs=0.5)  # two refinements only


@pytest.mark.parametrize(("method", "order"), [(RK4(4e-3), 4.0), (GeneralizedAlpha(dt=4e-3), 2.0)])
def test_the_observed_order_is_that_of_successive_differences(method, order):
    """(x_0 - x_1) / (x_1 - x_2) = 2^p; of differences from the finest run alone it is 2^p + 1, 2.32 for order 2."""
    body = Body("top", 2.0, (0.02, 0.03, 0.04), com=(0.1, -0.05, 0.3), omega=(0.4, -0.3, 8.0), position=(0.1, 0.2, 0.3))
    top = System([body], [Spherical(GROUND, body, at=(0.05, 0.2, 0.3))])
    found = simulate(top, 0.5, method=method, output=6).estimate()
    assert found.order == pytest.approx(order, abs=0.05)  # the next power of dt: 1 % of the error at 0.03 rad a step


def test_estimate_of_an_adaptive_run_observes_an_exponent_of_one():
    case = cases.load("heavy_top_fast", 7)
    found = simulate(case.system, 0.5, output=6, rtol=1e-6).estimate()
    assert found.order == pytest.approx(1.0, abs=0.3)  # error per step proportional to rtol


def test_estimate_keeps_the_checks_of_the_run():
    solution = run(swinging, centripetal=False)
    found = solution.estimate()
    assert not found.passed and found.checks == solution.certificate.checks


def test_limits_never_exceed_what_is_useful():
    """At rtol 1e-2 the limits were 10: nothing could fail. A top turned wrong by 0.1 rad fails its estimate."""
    system, state = spinning()
    for options in ({"rtol": 1e-2}, {"rtol": 1e-3, "method": GeneralizedAlpha()}):
        solution = simulate(system, 2.0, state=state, output=51, **options)
        assert all(check.limit <= 1e-2 for check in solution.certificate.checks)
        found = estimate(solution)
        assert found.error > 0.1 and not found.passed
        assert "global error" in found.failures[0] and "tighten rtol" in found.failures[0]
        assert not solution.with_certificate(found).certificate.passed


def test_a_few_steps_explain_little():
    """What 10 steps may err, and a hundred times that: less than the thousand tolerances of a long run."""
    system, state = tumbling()
    solution = simulate(system, 0.05, state=state, rtol=1e-8)
    assert solution.certificate["energy balance"].limit == pytest.approx(1e-7 * solution.record.steps)


def test_consistency_and_global_error_are_two_lines():
    solution = run(swinging)
    before, after = str(solution.certificate), str(estimate(solution))
    assert "local consistency: ok" in before and "global error: unknown" in before
    assert "global error: ok, " in after
    assert "local consistency: FAILED" in str(run(swinging, centripetal=False).certificate)


def chaotic(t_end):
    """A double pendulum released high, and its separation rate by two runs 1e-9 rad apart."""
    rng = np.random.default_rng(77)
    a, b = random_body(rng, "a"), random_body(rng, "b")
    first = Revolute(GROUND, a, at=a.position + (0.1, 0.0, 0.6), axis=(0.1, 1.0, 0.05), name="first")
    second = Revolute(a, b, at=b.position + (0.0, 0.1, 0.5), axis=(0.1, 1.0, 0.05), name="second")
    system = System([a, b], [first, second])
    state = system.assemble(angles={first: 2.5, second: 1.0})
    return system, first, second, simulate(system, t_end, state=state, output=301)


def test_chaos_is_said_in_words():
    system, first, second, solution = chaotic(40.0)
    assert solution.certificate.passed  # every sample meets the equations
    found = estimate(solution)
    assert not found.passed and found.error > 0.1
    assert f"errors double every {found.doubling:.3g} s; shorten the run" in found.failures[0]
    beside = system.assemble(angles={first: 2.5 + 1e-9, second: 1.0})
    apart = np.abs(simulate(system, 40.0, state=beside, output=301).angle("second") - solution.angle("second"))
    doublings = np.log2(1e-2 / 1e-8)
    since, until = (np.flatnonzero(apart > size)[0] for size in (1e-8, 1e-2))
    assert found.doubling == pytest.approx((solution.t[until] - solution.t[since]) / doublings, rel=0.5)


def test_errors_that_grow_as_a_power_are_no_chaos():
    assert estimate(run(spinning, rtol=1e-6)).doubling is None
    assert estimate(run(swinging)).doubling is None
    t = np.linspace(0.0, 5.0, 60)
    assert doubling_time(t, 1e-10 * t**3) is None
    assert doubling_time(t, 1e-10 * np.exp(3.0 * t)) == pytest.approx(np.log(2.0) / 3.0)


@pytest.mark.parametrize("inertia", [1e-6, 1e-9])
def test_a_tiny_inertia_is_not_held_to_less_than_rounding(inertia):
    """The period is that of a point on a string to 1e-6, so the result is right."""
    bob = Body(
        "bob", 1.0, (inertia, 2 * inertia, 1.5 * inertia), position=(0.6, 0.1, -0.8), orientation=(0.6, 0, 0.8, 0)
    )
    solution = simulate(System([bob], [Revolute(GROUND, bob, at=(0, 0.1, 0), axis=(0, 1, 0))]), 2.0, output=401)
    assert solution.certificate.passed, solution.certificate

    def rate(t, y):
        return (y[1], -9.81 * np.sin(y[0]) / (1.0 + 2 * inertia))

    true = solve_ivp(rate, (0, 2), (np.arctan2(0.6, 0.8), 0), rtol=1e-11, atol=1e-12, t_eval=solution.t).y[0]
    x, _, z = solution.position(bob).T
    assert np.arctan2(x, -z) == pytest.approx(true, abs=1e-6)


def test_baumgarte_is_held_to_what_it_is_meant_to_do():
    assert run(spinning, stabilisation="baumgarte").certificate.passed
    assert run(swinging, stabilisation="baumgarte").certificate.passed


@pytest.mark.parametrize("method", [DOP853(), GeneralizedAlpha()])
@pytest.mark.parametrize(("speed", "push"), [(1000.0, 1e-6), (30.0, 1e-8)])
def test_a_probe_that_flies_on_under_a_small_thrust_passes(speed, push, method):
    """Its energy is known to rounding of the whole, which is as much as the thrust adds; it was said to fail."""
    velocity = speed * np.array([1.0, 0.3, -0.2])
    probe = Body("probe", 3.0, (0.3, 0.4, 0.5), com=(0.1, -0.2, 0.05), velocity=velocity, omega=(0, 0, 0))
    run = simulate(System([probe], forces=[Force(probe, (push, 0, 0))], gravity=(0, 0, 0)), 10.0, method=method)
    assert run.certificate.passed, run.certificate.failures
    assert run.velocity(probe)[-1] == pytest.approx(velocity + [10.0 * push / 3.0, 0, 0], rel=1e-12)


def test_work_of_few_poses_is_noted():
    """The energy balance of a driven arm says how far its work is known: to 6 % by 41 poses, of order 2."""
    arm = Body("arm", 2.0, (0.1, 0.2, 0.25), com=(0.3, 0.05, 0.02))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(1.0, 0.3, -0.2))
    system = System([arm], [hinge, AngleDriver(hinge, Pulse(0.9, 0.137, 0.2, 0.5), name="motor")])
    few, many = (simulate(system, 1.0, method=Kinematic(), output=count) for count in (41, 641))
    gained, spent = few.energy().total - few.energy().total[0], few.work("motor")
    (note,) = few.certificate.notes
    assert note.startswith(f"work is known to {np.abs(gained - spent).max():.1e} J of ")
    assert few.certificate.passed and many.certificate.notes == ()


def test_angular_momentum_of_older_files_is_not_judged():
    """They hold the angular impulse about the origin."""
    solution = run(swinging)
    older = replace(solution, record=replace(solution.record, about_centre=False)).certificate
    assert older.passed and "angular momentum" not in {check.name for check in older.checks}
    assert "angular momentum not checked" in str(older)


@pytest.mark.parametrize("times", [[39.9, 40.0], [40.0]])
def test_what_went_wrong_before_the_first_sample_counts(times):
    """Samples at the end alone: the error of a chaotic run, what a damped method loses since the start."""
    _, _, _, whole = chaotic(40.0)
    late, damped = whole.again(output=times), whole.again(5.0, output=[5.0], method=GeneralizedAlpha(0.01, rho=0.2))
    assert late.certificate.passed and late.estimate().error > 0.1
    seen, every = (x.certificate["energy balance"].error for x in (damped, damped.again(output=2)))
    assert seen == pytest.approx(every, rel=1e-9) and seen > damped.certificate["energy balance"].limit
    assert np.abs(late.at(20.0).q - whole.at(20.0).q).max() < 1e-5  # a step of another length: errors grow from 1e-9


def test_runs_that_follow_each_other_say_from_when_on_errors_count():
    """The second run of a pendulum starts where the first one ended, too late: it cannot know, and says from when on
    its estimate counts. The energy balance fails both, as the load of the hinge, which does no work, is none of it.
    """
    axis = np.array([2.0, -1.0, 2.0]) / 3.0
    bob = Body("bob", 1.3, (0.03, 0.05, 0.04), com=(0.5, 0.3, -0.2))
    hinge = Revolute(GROUND, bob, at=(0.1, -0.2, 0.3), axis=axis)
    system = System([bob], [hinge], gravity=(2.0, -3.0, -9.0))
    start, method = system.assemble(rates={hinge: 9.0}), GeneralizedAlpha(dt=0.01)
    first = simulate(system, 6.0, state=start, method=method)
    second = simulate(system, 7.0, state=first.final, method=method)
    arm = bob.com - hinge.at
    across = arm - (arm @ axis) * axis
    moment = axis @ np.diag(bob.inertia.diagonal()) @ axis + 1.3 * across @ across
    pull = 1.3 * np.array([np.cross(axis, across) @ system.gravity, -across @ system.gravity])

    def rates(t, y):
        return y[1], (pull[0] * np.cos(y[0]) + pull[1] * np.sin(y[0])) / moment

    true = solve_ivp(rates, (0, 7), (0, 9.0), rtol=1e-11, atol=1e-11).y[0, -1]
    known = [run.estimate() for run in (first, second)]
    assert abs(second.angle(hinge)[-1] - true) > 3.0 * known[1].error
    assert known[1].global_error.startswith("ok") and "added from 6 s on" in known[1].global_error
    assert "finds what is added from 6 s on" in str(second.certificate) and "added" not in str(known[0])
    assert not any(run.certificate["energy balance"].passed for run in (first, second))


def test_one_state_has_no_global_error():
    system, state = swinging()
    with pytest.raises(ValueError, match="nothing was integrated"):
        accelerations(system, state).estimate()
