"""Stiff models: the governor against its reduced equations, a 1e8 N/m bushing, and DOP853 that says it is stiff."""

import numpy as np
import pytest
from helpers.models import direction, random_body, random_orientation
from helpers.stiff import G, governor, sensor, slider_height
from scipy.integrate import solve_ivp

from mbsd3d import (
    DOP853,
    GROUND,
    Body,
    Bushing,
    GeneralizedAlpha,
    IntegrationError,
    SpringDamper,
    System,
    simulate,
)
from mbsd3d.extend import compile_system, pack
from mbsd3d.integrators import dop853
from mbsd3d.rotations import matrix, skew
from mbsd3d.run.stiffness import force_rate
from validation import cases
from validation.suite.trials.references import RTOL_BY_CASE


@pytest.mark.slow
def test_dop853_meets_the_governor_by_hand():
    times, expected = slider_height()
    run = simulate(governor(), 2.0, rtol=1e-9, output=times)
    assert run.position("slider")[:, 2] == pytest.approx(expected, abs=1e-8)  # 10 rtol; Radau's 1e-10 times 41 outputs
    assert np.ptp(expected) > 0.2


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8])
def test_governor_with_fixed_steps_is_of_second_order(rho):
    times, expected = slider_height()
    errors = []
    for n in (256, 512, 1024):
        run = simulate(governor(), 2.0, method=GeneralizedAlpha(dt=2.0 / n, rho=rho), rtol=1e-4, output=times)
        errors.append(np.abs(run.position("slider")[:, 2] - expected).max())
        assert run.certificate.steps == n and run.certificate.passed, run.certificate.failures
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([2.0, 2.0], abs=0.15)
    # m: two swings of 0.12 at 1 Hz, late by w t (w h)^2 / 3 with rho = 0: 8e-5
    assert errors[-1] < 1.5e-4


def test_governor_with_adaptive_steps():
    times, expected = slider_height()
    explicit = simulate(governor(), 2.0, rtol=1e-4, output=times)
    run = simulate(governor(), 2.0, rtol=1e-5, method=GeneralizedAlpha(), output=times)
    assert run.certificate.passed, run.certificate.failures
    assert np.abs(run.position("slider")[:, 2] - expected).max() < 1e-4  # 10 rtol m
    assert run.certificate.steps < 0.6 * explicit.certificate.steps  # which stability keeps from longer ones


def test_bushing_of_1e8_at_a_thousand_times_the_step_of_dop853():
    """Both held to 1e-4; the mount gives by (m a / k) 2e-9 m, so the rigid model is the reference, solved to 1e-10."""
    t_end, n = 2.0, 160
    exact = simulate(sensor(rigid=True), t_end, rtol=1e-10, output=11)
    run = simulate(sensor(), t_end, method=GeneralizedAlpha(dt=t_end / n), rtol=1e-4, output=11)
    size = run.compiled.model.length
    assert np.abs(run.position("load") - exact.position("load")).max() < 1e-4 * size
    assert run.certificate.passed, run.certificate.failures
    piece = 2e-3  # s: past the first transient of 1e-4 s, DOP853 needs the same steps for ever
    explicit = simulate(sensor(), piece, method=DOP853(stiff="run"), rtol=1e-4)
    ratio = (t_end / n) / (piece / explicit.certificate.steps)
    assert ratio > 1000, ratio


def test_adaptive_steps_leave_the_stiff_scale_behind():
    exact = simulate(sensor(rigid=True), 2.0, rtol=1e-10, output=11)
    run = simulate(sensor(), 2.0, method=GeneralizedAlpha(), rtol=1e-5, output=11)
    assert run.certificate.passed, run.certificate.failures
    assert run.certificate.steps < 1000  # DOP853 needs more than a million
    assert np.abs(run.position("load") - exact.position("load")).max() < 1e2 * 1e-5 * run.compiled.model.length


# From 1e-8 on the rounding of a force of 1e8 N/m may hold the steps shorter than stability does, and the run goes on.
@pytest.mark.parametrize("rtol", [1e-3, 1e-7])
def test_dop853_stops_on_a_stiff_model_and_says_what_to_do(rtol):
    simulate(sensor(), 1e-4, rtol=rtol)  # a stiff run that ends soon goes on
    with pytest.raises(IntegrationError, match="stiff.*'mount'.*GeneralizedAlpha") as error:
        simulate(sensor(), 2.0, rtol=rtol)
    assert error.value.solution.record.evaluations < 10_000  # 700; the whole run would take a hundred million
    assert error.value.time < 0.1 and error.value.solution.t.size > 15
    assert "force 'mount'" in error.value.part


def test_dop853_goes_on_where_the_user_insists():
    run = simulate(sensor(), 0.02, method=DOP853(stiff="run"), rtol=1e-4, output=2)
    assert run.certificate.steps > 10000 and run.t[-1] == 0.02


def test_the_named_force_is_the_fastest():
    """Rates of single elements against the closed form: one mass between a soft and a hard spring."""
    block = Body("block", 2.0, (0.1, 0.1, 0.1), position=(1.0, 0, 0))
    springs = [
        SpringDamper(GROUND, block, at_a=(0, 0, 0), at_b=(1, 0, 0), stiffness=k, damping=c)
        for k, c in ((50.0, 0.0), (8e5, 0.0), (0.0, 4e4))
    ]
    compiled = compile_system(System([block], forces=springs))
    y = pack(compiled, compiled.system.state())
    found = [force_rate(compiled, compiled.data(), y, 0.0, k) for k in range(3)]
    # k/m = rate^2, c/m = rate; differences of 1e-7 leave seven digits of the force, the root of a double zero four
    assert found == pytest.approx([np.sqrt(25.0), np.sqrt(4e5), 2e4], rel=1e-3)


def test_the_rate_of_a_bushing_is_that_of_a_free_body_on_it():
    """The general body of general orientation, by its matrices written here: M x'' = -K x - D x'."""
    rng = np.random.default_rng(9)
    body = random_body(rng, mass=1.3)
    at, F = body.position + 0.4 * direction(rng), matrix(random_orientation(rng))
    K, D = np.diag((900.0, 700.0, 400.0)), np.diag((4.0, 7.0, 3.0))
    K_r, D_r = np.diag((50.0, 80.0, 30.0)), np.diag((90.0, 40.0, 70.0))
    bushing = Bushing(GROUND, body, at=at, axes=F, stiffness=np.diag(K), turning_stiffness=np.diag(K_r),
                      damping=np.diag(D), turning_damping=np.diag(D_r))  # fmt: skip
    compiled = compile_system(System([body], forces=[bushing]))
    found = force_rate(compiled, compiled.data(), pack(compiled, compiled.system.state()), 0.0, 0)
    R, reach = matrix(body.orientation), skew(at - body.position)
    s = skew(R @ body.com)
    M = np.block([[1.3 * np.eye(3), -1.3 * s], [1.3 * s, R @ body.inertia @ R.T - 1.3 * s @ s]])
    arm = np.hstack([np.eye(3), -reach])  # motion of the point of the bushing by that of O
    stiff, damped = (
        arm.T @ F @ x @ F.T @ arm + np.block([[np.zeros((3, 6))], [np.zeros((3, 3)), F @ y @ F.T]])
        for x, y in ((K, K_r), (D, D_r))
    )
    whole = np.block([[np.zeros((6, 6)), np.eye(6)], [-np.linalg.solve(M, stiff), -np.linalg.solve(M, damped)]])
    assert found == pytest.approx(np.abs(np.linalg.eigvals(whole)).max(), rel=1e-6)  # differences of 1e-7


@pytest.mark.parametrize("name", [n for n in cases.names(timed=True)])
def test_no_case_is_called_stiff(monkeypatch, name):
    """Without any patience, at loose and at tight tolerances: none of the mechanisms owes its steps to a force."""
    monkeypatch.setattr(dop853, "STIFF_WORK_MAX", 0.0)
    case = cases.load(name, 3)
    for rtol in (1e-3, 1e-5, 1e-8, 1e-11):
        if rtol >= RTOL_BY_CASE.get(name, 0.0):  # tighter, rounding may end the run at a singular position
            assert simulate(case.system, min(case.t_end, 3.0), rtol=rtol, output=2).final.t > 0.0


def test_a_long_run_that_resolves_a_vibration_is_not_stiff(monkeypatch):
    """An oscillator seen at full size for a thousand periods: accuracy limits the step, not stability."""
    monkeypatch.setattr(dop853, "STIFF_WORK_MAX", 0.0)
    block = Body("block", 2.0, (0.1, 0.1, 0.1), position=(1.3, 0, 0), velocity=(0.4, 0, 0))
    spring = SpringDamper(GROUND, block, at_a=(0, 0, 0), at_b=(1.3, 0, 0), stiffness=8e5)
    period = 2 * np.pi / np.sqrt(4e5)
    for rtol in (1e-3, 1e-8):
        run = simulate(System([block], forces=[spring], gravity=(0, 0, 0)), 1000 * period, rtol=rtol, output=2)
        assert run.certificate.steps > 1000


def test_short_fixed_steps_keep_the_order():
    """A pendulum on a spring of 1e6 N/m, 1 s: what Newton's method leaves must not add up over thousands of steps.

    Before, 16384 steps were no better than 5000: 2.3e-7 m.
    """
    bob = Body("bob", 1.0, (0.01, 0.01, 0.01), position=(1.0, 0, 0), velocity=(0, 0, 0), omega=(0, 0, 0))
    spring = SpringDamper(GROUND, bob, at_a=(0, 0, 0), at_b=(1.0, 0, 0), stiffness=1e6, damping=1e3)

    def rate(t, y):
        length = np.hypot(*y[:2])
        n = y[:2] / length
        return np.concatenate([y[2:], -(1e6 * (length - 1.0) + 1e3 * (y[2:] @ n)) * n + (0.0, -G)])

    true = solve_ivp(rate, (0, 1), (1.0, 0, 0, 0), method="DOP853", rtol=1e-12, atol=1e-14).y[:2, -1]
    errors = []
    for steps in (1024, 4096, 16384):
        run = simulate(System([bob], forces=[spring]), 1.0, method=GeneralizedAlpha(dt=1 / steps), output=2)
        errors.append(np.linalg.norm(run.position(bob)[-1, [0, 2]] - true))
    assert errors[-1] < 4e-8  # second order: h^2 w^3 t / 12 with rates of 4.4 rad/s is 2.7e-8
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([4.0, 4.0], abs=0.05)
