"""Generalised alpha: order in q, v and lam, its damping against the textbook's recurrence, rows of every kind."""

import numpy as np
import pytest
from helpers.lead_screw import lead_screw
from helpers.models import all_joints_mechanism, consistent_state, derivative, direction, pendulum, random_body
from helpers.swinging import swinging

from mbsd3d import (
    DOP853,
    GROUND,
    Body,
    Bushing,
    GeneralizedAlpha,
    IntegrationError,
    JointFriction,
    Revolute,
    Screw,
    Spherical,
    System,
    Torque,
    linearize,
    measures,
    rotation,
    simulate,
)
from mbsd3d.extend import Progress, compile_system
from mbsd3d.integrators.alpha_step import trial_state
from mbsd3d.integrators.generalized_alpha import weights
from mbsd3d.integrators.newton import fill_matrix, residual, tangent
from mbsd3d.results.record import RunOptions
from mbsd3d.rotations import as_quaternion, conjugate, exponential, logarithm, matrix, multiply
from mbsd3d.run.job import Job
from validation import cases

T = 0.5
RHO = (0.0, 0.3, 0.8, 1.0)


def double_top():
    """A spinning body on a ball joint carrying another on a hinge; nothing on an axis, nothing at the origin."""
    top = Body(
        "top", 15.0, (0.23, 0.47, 0.31), com=(0.1, 0.9, -0.2), position=(0.1, 0.2, 0.3),
        orientation=rotation((1, 0.2, -0.4), 0.7), omega=(1.0, 5.0, -2.0),
    )  # fmt: skip
    bob = Body(
        "bob", 3.0, (0.1, 0.2, 0.15), com=(0.1, 0.2, -0.2), position=(0.5, 1.2, 0.4),
        orientation=rotation((0.3, 1, 0.1), 0.35),
    )  # fmt: skip
    ball = Spherical(GROUND, top, at=(0.05, 0.1, 0.2))
    return System([top, bob], [ball, Revolute(top, bob, at=(0.4, 0.9, 0.5), axis=(1, 0.5, 0.2))])


def prepared(system, method, t_end=T, rtol=1e-8, state=None):
    """A job at its start: gives access to the method's own rates and multipliers."""
    start = state or system.state()
    return Job(compile_system(system), start, t_end, np.array([start.t, t_end]), RunOptions(method, rtol))


def finished(system, method, t_end=T, rtol=1e-8):
    """(solution, multipliers of the method itself at the end)."""
    job = prepared(system, method, t_end, rtol)
    solution = job.run(Progress("", 0.0, t_end, False))
    return solution, job.own.lam


@pytest.fixture(scope="module")
def exact():
    return simulate(double_top(), T, rtol=1e-12, output=2)


@pytest.mark.parametrize("rho", RHO)
def test_second_order_in_positions_velocities_and_multipliers(rho, exact):
    def errors(n):
        solution, lam = finished(double_top(), GeneralizedAlpha(dt=T / n, rho=rho))
        return [
            np.abs(solution.position("bob")[-1] - exact.position("bob")[-1]).max(),
            np.abs(solution.rotation("top")[-1] - exact.rotation("top")[-1]).max(),
            np.abs(solution.velocity("bob")[-1] - exact.velocity("bob")[-1]).max(),
            np.abs(solution.omega("bob")[-1] - exact.omega("bob")[-1]).max(),
            np.abs(lam - exact.arrays["lam"][-1]).max(),
        ]

    found = np.array([errors(n) for n in (64, 128, 256, 512, 1024)])
    slopes = np.log2(found[:-1] / found[1:])
    assert slopes == pytest.approx(np.full(slopes.shape, 2.0), abs=0.12)  # 2 - O(h) at the coarsest step and rho = 0
    assert slopes[-1] == pytest.approx([2.0] * 5, abs=0.02)
    assert found[-1].min() > 1e-8  # four digits above the reference


def test_ablation_steps_of_one_length_too_many_spoil_the_order(exact):
    """The check above sees an error of first order: the same run, one part in a thousand of a step late."""
    late = [
        np.abs(
            finished(double_top(), GeneralizedAlpha(dt=T / n), T * (1 + 0.5 / n))[0].position("bob")[-1]
            - exact.position("bob")[-1]
        ).max()
        for n in (128, 256, 512)
    ]
    assert np.log2(late[-2] / late[-1]) < 1.5


def test_general_pendulum_follows_its_closed_form():
    system, hinge, state, angle = swinging()
    errors = []
    for n in (256, 512):
        solution = simulate(system, 2.0, state=state, method=GeneralizedAlpha(dt=2.0 / n), output=41)
        errors.append(np.abs(solution.angle(hinge) - angle(solution.t)).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)  # second order between the steps too
    assert errors[1] < 1e-3  # rad: (h omega)^2/12 per radian, over ten of them


@pytest.mark.parametrize("rho", [0.0, 0.5, 1.0])
def test_error_coefficients_and_damping_are_those_of_chung_and_hulbert(rho):
    """Spectral radius rho at infinite frequency; for rho = 1 the trapezoidal rule with errors h^3/12."""
    c = weights(rho)
    matrix = amplification(c, 1e8)
    # triple eigenvalue: rounding and 1e-8 move it by their cube root, times three
    assert np.abs(np.linalg.eigvals(matrix)).max() == pytest.approx(rho, abs=0.02)
    if rho == 1.0:
        assert (c.error_q, c.error_v) == pytest.approx((1 / 12, 1 / 12), abs=1e-15)


def amplification(c, square):
    """Matrix of (x, h v, h^2 a, h^2 x_ddot) over a step for x_ddot = -omega^2 x, square = (omega h)^2."""
    left = np.array([
        [1, 0, -c.beta, 0], [0, 1, -c.gamma, 0], [0, 0, 1 - c.alpha_m, -(1 - c.alpha_f)], [square, 0, 0, 1],
    ])  # fmt: skip
    right = np.array([
        [1, 1, 0.5 - c.beta, 0], [0, 1, 1 - c.gamma, 0], [0, 0, -c.alpha_m, c.alpha_f], [0, 0, 0, 0],
    ])  # fmt: skip
    return np.linalg.solve(left, right)


def on_a_bushing(stiffness=1e8, speed=0.3):
    """A body whose centre of mass is held by an undamped bushing: an oscillator in every direction."""
    mass, com, place = 1.7, np.array([0.1, -0.2, 0.3]), np.array([0.4, 0.1, -0.2])
    frame = rotation((1, 2, -0.5), 0.8)
    body = Body(
        "block", mass, (0.1, 0.2, 0.15), com=com, position=place, orientation=frame,
        velocity=speed * np.array([1.0, -0.7, 0.4]), omega=(0, 0, 0),
    )  # fmt: skip
    centre = place + matrix(as_quaternion(frame, "")) @ com
    hold = Bushing(GROUND, body, at=centre, stiffness=stiffness, axes=rotation((0.2, 1, 1), 0.5))
    return System([body], forces=[hold], gravity=(0, 0, 0)), np.sqrt(stiffness / mass)


@pytest.mark.parametrize("rho", [0.2, 0.8, 1.0])
@pytest.mark.parametrize("step", [0.3, 40.0])
def test_an_oscillator_follows_the_recurrence_of_the_textbook(rho, step):
    """Resolved (omega h = 0.3) and far from it (40): the same numbers as the 4 x 4 recurrence, started with rho = 1."""
    system, omega = on_a_bushing()
    h, n = step / omega, 24
    solution = simulate(system, n * h, method=GeneralizedAlpha(dt=h, rho=rho), rtol=0.1, output=np.arange(n + 1) * h)
    moved = solution.com("block") - solution.com("block")[0]
    state = np.outer([0.0, h, 0.0, 0.0], solution.velocity("block")[0])
    expected = [state[0]]
    for k in range(n):
        before = state[3]
        state = amplification(weights(1.0 if k == 0 else rho), step**2) @ state
        if k == 0:
            c = weights(rho)
            state[2] = state[3] + (c.alpha_m - c.alpha_f) * (state[3] - before)
        expected.append(state[0])
    size = np.abs(expected).max()
    # Newton's 1e-11 and the rounding of k x with x some 0.1 m against a path of 1e-5 m, over 24 steps
    assert moved == pytest.approx(np.array(expected), abs=1e-8 * size)
    assert size > 1e-6


def test_numerical_damping_is_shown_by_the_certificate():
    """The energy of an unresolved vibration is lost for rho < 1, kept for rho = 1, and the balance says so."""
    system, omega = on_a_bushing()
    lost = {}
    for rho in (0.5, 1.0):
        run = simulate(system, 0.1, method=GeneralizedAlpha(dt=40.0 / omega, rho=rho), rtol=1e-6)
        energy = run.energy().total
        lost[rho] = 1.0 - energy[-1] / energy[0]
        assert run.certificate["energy balance"].error > 0.1 or rho == 1.0
        assert run.certificate.passed == (rho == 1.0), run.certificate.failures
    assert lost[0.5] > 0.99 and abs(lost[1.0]) < 1e-6  # Newton's tolerance; the trapezoidal rule keeps linear energy


@pytest.mark.parametrize("size", [1e-6, 0.02, 0.04, 0.9, 2.8])
def test_tangent_of_the_exponential_map(size):
    """T(x) a against differences of exp(x)^-1 exp(x + h a); both branches of the formula."""
    x, a = size * np.array([0.3, -0.8, 0.5]), np.array([0.7, 0.4, -1.1])
    back = conjugate(exponential(x))
    expected = derivative(lambda h: logarithm(multiply(back, exponential(x + h * a))))
    assert tangent(tuple(x), tuple(a)) == pytest.approx(expected, abs=1e-9)  # differences: 1e-12 of fifth derivatives


def every_joint():
    """(system, state): every joint, driver and a stiff bushing."""
    system = all_joints_mechanism(21)
    one, two = system.bodies[0], system.bodies[1]
    hold = Bushing(
        one, two, at=(one.position + two.position) / 2 + 0.1, stiffness=(5e3, 6e3, 7e3), turning_stiffness=300,
        damping=(200, 100, 150), turning_damping=20, axes=rotation((1, 0.3, 0.2), 0.6),
    )  # fmt: skip
    system = System(system.bodies, system.joints, [hold], gravity=system.gravity)
    return system, consistent_state(system, np.random.default_rng(5))


def free_screw():
    """(system, state): a heavy nut on the thread of a spindle, both some turns from their reference pose."""
    rng = np.random.default_rng(14)
    spindle, nut = random_body(rng, "spindle"), random_body(rng, "nut")
    hinge = Revolute(GROUND, spindle, at=rng.normal(size=3), axis=direction(rng))
    thread = Screw(spindle, nut, at=rng.normal(size=3), axis=direction(rng), pitch=-0.3, name="thread")
    system = System([spindle, nut], [hinge, thread])
    return system, system.assemble(angles={hinge: -17.0, thread: 24.0}, rates={hinge: 3.0, thread: -5.0})


@pytest.mark.parametrize("made", [every_joint, free_screw])
def test_matrix_is_the_derivative_of_the_residual(made):
    """Complex steps against central differences of the whole step."""
    system, start = made()
    h, c = 0.01, weights(0.8)
    job = prepared(system, GeneralizedAlpha(dt=1e-3), state=start)
    job.eliminate()
    job.first_step()
    assert job.call(2) == 0  # two steps, and still running
    m, d, s, run, g = job.model, job.data, job.tree, job.memory, job.own
    w, free, t = g.newton, 6 * m.body.size + m.z_work, float(run.now.t) + h
    change = (1 - c.alpha_f) / (1 - c.alpha_m)
    h_v, h_q, size = h * c.gamma * change, h * h * c.beta * change, free + s.used.size
    rates, multipliers = slice(7 * m.body.size, 7 * m.body.size + free), s.used

    def evaluate(x):
        w.rate[rates], w.lam[multipliers] = x[:free], x[free:]
        assert trial_state(m, d, s, run, g, c, t, h)
        residual(m, d, s, t, run.trial, w.rate, w.lam, h_v, w.x)
        return w.x[:size].copy()

    def slopes():
        fill_matrix(m, d, s, w, t, run.trial, h_q, h_v)
        return w.A[:size, :size].copy()

    x = np.concatenate([g.rate[rates], g.lam[multipliers]])
    sizes = []
    for _ in range(4):
        r = evaluate(x)
        sizes.append(np.abs(r).max())
        x = x - np.linalg.solve(slopes(), r)
    assert sizes[3] < 1e-6 * sizes[0]  # the matrix is right enough for Newton's method, ...
    evaluate(x)
    found, step = slopes(), 1e-2
    for j in range(0, size, 7 if size > 50 else 1):
        e = np.zeros(size)
        e[j] = step
        near, far = evaluate(x + e) - evaluate(x - e), evaluate(x + 2 * e) - evaluate(x - 2 * e)
        exact = (8 * near - far) / (12 * step)
        # ... and exact but for the curvature of c = 0; stiffness, damping and projection are far larger
        assert np.abs(found[:, j] - exact).max() < 1e-4 * np.abs(exact).max()


@pytest.mark.parametrize("rho", [0.0, 0.8])
def test_tighter_tolerance_is_better_and_the_certificate_holds(rho):
    system, body, hinge = pendulum()
    start = system.assemble(rates={hinge: 3.0})
    exact = simulate(system, 1.0, state=start, rtol=1e-12, output=5).com(body)
    errors = []
    for rtol in (1e-3, 1e-5, 1e-7):
        run = simulate(system, 1.0, state=start, rtol=rtol, output=5, method=GeneralizedAlpha(rho=rho))
        assert run.certificate.passed, run.certificate.failures
        assert run.drift().position.max() < 1e-13 and run.drift().velocity.max() < 1e-12  # projected
        errors.append(np.abs(run.com(body) - exact).max())
    # a step may err rtol^0.8, so the global error goes with rtol^0.53: 12 per two decades
    assert errors[0] / errors[1] > 6 and errors[1] / errors[2] > 6
    assert errors[2] < 1e3 * 1e-7


def test_multipliers_keep_their_order_when_the_step_changes(exact):
    """With adaptive steps the method's own lam stays as close to the solution as v does: no O(h) after a change."""
    errors = []
    for rtol in (1e-4, 1e-8):
        solution, lam = finished(double_top(), GeneralizedAlpha(), rtol=rtol)
        errors.append(np.abs(lam - exact.arrays["lam"][-1]).max())
    # a step may err 10^3.2 times more: second order gives 136, first order in h only 12
    assert errors[0] / errors[1] > 60


@pytest.mark.parametrize(("turned", "evaluations"), [(0.7, 9.0), (3.0, 9.0)])
def test_rows_that_repeat_each_other_turn_with_a_matrix_that_is_kept(turned, evaluations):
    """The kept matrix is that of a pose ``turned`` [rad] ago, where other combinations of the rows were redundant."""
    system, hinge, state, angle = lead_screw()
    method = GeneralizedAlpha(dt=turned / 20.0)  # 9 to 31 rad/s
    run = simulate(system, 2.0, state=state, method=method)
    assert np.abs(run.angle(hinge) - angle(run.t)).max() < 1e-6  # rad, of 40: exact but for what Newton's method leaves
    assert run.certificate.evaluations < evaluations * run.certificate.steps
    assert run.estimate().error < 1e-6


KINDS = {
    "rolling disc": ("rolling_disc_circular", 1.5),
    "two hinges on one door": ("door_two_hinges", 1.0),
    "Bricard": ("iftomm_A04_bricard", 1.0),
    "driven linkage": ("rssr_driven", 1.0),
    "gyroscope": ("gyro_gimbal_wheel", 0.3),
}


@pytest.mark.parametrize("kind", KINDS)
def test_rolling_redundant_and_driven_rows(kind):
    name, t_end = KINDS[kind]
    system = cases.load(name, 3).system
    exact = simulate(system, t_end, rtol=1e-10, output=11)
    errors = []
    for rtol in (1e-4, 1e-6):
        run = simulate(system, t_end, rtol=rtol, output=11, method=GeneralizedAlpha())
        assert run.certificate.passed, run.certificate.failures
        errors.append(np.abs(run.arrays["q"][..., :3] - exact.arrays["q"][..., :3]).max())
    assert errors[1] < 2e-3 * exact.compiled.model.length  # 1e3 rtol and margin for the fast wheel
    assert errors[1] < 0.2 * errors[0] or errors[0] < 1e-10  # a driven linkage is exact at once


def test_all_joints_and_drivers_at_once():
    system = all_joints_mechanism(21)
    start = consistent_state(system, np.random.default_rng(21))
    exact = simulate(system, 0.2, state=start, rtol=1e-10, output=3)
    found = [
        np.abs(
            simulate(system, 0.2, state=start, output=3, method=GeneralizedAlpha(dt=0.2 / n)).arrays["q"]
            - exact.arrays["q"]
        ).max()
        for n in (128, 256)
    ]
    assert np.log2(found[0] / found[1]) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("method", [GeneralizedAlpha(dt=0.01), GeneralizedAlpha()])
def test_output_does_not_change_the_motion_and_reruns_are_the_same(method):
    system, *_ = pendulum()
    runs = [simulate(system, 1.0, output=output, method=method, rtol=1e-5) for output in (None, 3, 977, 3)]
    assert all(np.array_equal(run.final.q, runs[0].final.q) for run in runs)
    assert np.array_equal(runs[1].arrays["acceleration"], runs[3].arrays["acceleration"])
    assert runs[0].t.size == runs[0].certificate.steps + 1 and runs[0].t[-1] == 1.0


def test_a_stop_is_located_on_the_dense_output():
    system, hinge, state, angle = swinging()
    value = float(angle(0.0)) + 0.3
    run = simulate(
        system, 5.0, state=state, rtol=1e-7, stop_when=measures.angle(hinge) > value, method=GeneralizedAlpha()
    )
    assert run.angle(hinge)[-1] == pytest.approx(value, abs=1e-10)
    assert float(angle(run.t[-1])) == pytest.approx(value, abs=1e-4)  # 1e3 rtol


def test_a_run_goes_on_from_its_final_state():
    system, body, _ = pendulum()
    whole = simulate(system, 1.0, method=GeneralizedAlpha(), rtol=1e-7, output=2)
    first = simulate(system, 0.4, method=GeneralizedAlpha(), rtol=1e-7)
    second = simulate(system, 1.0, state=first.final, method=GeneralizedAlpha(), rtol=1e-7)
    assert second.position(body)[-1] == pytest.approx(whole.position(body)[-1], abs=1e-4)  # 1e3 rtol


def test_teaching_switches_act_or_are_refused():
    system = double_top()
    runs = [
        simulate(system, 0.1, method=GeneralizedAlpha(dt=1e-3), rtol=1e-5, **off)
        for off in ({}, {"gyroscopic": False}, {"centripetal": False})
    ]
    assert [run.certificate.passed for run in runs] == [True, False, False]
    for off in ({"gamma": False}, {"stabilisation": "baumgarte"}):
        with pytest.raises(ValueError, match="hold no gamma"):
            simulate(system, 0.1, method=GeneralizedAlpha(dt=1e-3), **off)


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"rho": 1.2}, "rho 1.2 is outside"),
        ({"rho": float("nan")}, "rho"),
        ({"dt": 0.0}, "dt"),
        ({"dt": -1.0}, "dt"),
        ({"max_step": 0.0}, "max_step"),
    ],
)
def test_bad_parameters(fields, message):
    with pytest.raises(ValueError, match=message):
        GeneralizedAlpha(**fields)


def test_steps_far_too_long_are_an_error_with_advice():
    """A revolution of the fast top per step: no end of the step can be found."""
    system = cases.load("heavy_top_fast", 3).system
    with pytest.raises(IntegrationError, match="smaller dt") as error:
        simulate(system, 20.0, method=GeneralizedAlpha(dt=1.0))
    assert error.value.solution.t.size >= 1


def test_dop853_takes_a_known_choice_only():
    with pytest.raises(ValueError, match="'stop' or 'run'"):
        DOP853(stiff="perhaps")


@pytest.mark.parametrize("rate", [2.0, 40.0, -3000.0])
def test_dry_friction_has_a_derivative_at_every_speed(rate):
    """Of a complex number numpy's tanh overflows from 355 transitions on, 3.6 rad/s at the default."""
    disc = Body("disc", 2.0, (0.3, 0.3, 0.5), com=(0.0, 0.0, 0.2), omega=(0, 0, rate))
    hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    friction = JointFriction(hinge, coulomb=0.3, viscous=0.02)
    held = Torque(disc, (0, 0, 0.3 * np.sign(rate) + 0.02 * rate))
    run = simulate(System([disc], [hinge], [friction]), 0.5, method=GeneralizedAlpha(), rtol=1e-6)
    dry = 0.3 * np.sign(rate) / 0.02
    assert run.rate(hinge)[-1] == pytest.approx((rate + dry) * np.exp(-0.02) - dry, abs=1e-5 * abs(rate))
    poles = linearize(System([disc], [hinge], [friction, held])).eigenvalues
    assert np.abs(np.asarray(poles) + 0.04).min() < 1e-9  # -c/I; the dry part no longer changes
