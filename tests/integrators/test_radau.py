"""Radau IIA: its coefficients, its order, stiff models at tight tolerances, and everything a run can hold."""

import numpy as np
import pytest
from helpers.lead_screw import lead_screw
from helpers.models import all_joints_mechanism, consistent_state, direction, random_body
from helpers.stiff import governor, sensor, slider_height

from mbsd3d import (
    DOP853,
    GROUND,
    Body,
    Force,
    IntegrationError,
    Prismatic,
    RadauIIA,
    Revolute,
    Sine,
    Spherical,
    SpringDamper,
    StateFeedback,
    Stepper,
    System,
    measures,
    simulate,
)
from mbsd3d.integrators.radau import ERROR, PAIR, REAL, A, C, T


def pendulum():
    """(system, state): two bodies in general position, swinging."""
    rng = np.random.default_rng(12)
    upper, lower = random_body(rng, "upper"), random_body(rng, "lower")
    elbow = Revolute(upper, lower, at=rng.normal(size=3), axis=direction(rng), name="elbow")
    system = System([upper, lower], [Spherical(GROUND, upper, at=rng.normal(size=3)), elbow])
    return system, system.assemble(rates={elbow: 2.0})


def test_coefficients_are_those_of_the_book():
    """Hairer and Wanner, section IV.8: order conditions, stability function R(z), eigenvalues, estimate."""
    for k in range(1, 6):  # the quadrature is of order 5
        assert A[2] @ C ** (k - 1) == pytest.approx(1 / k, abs=1e-14)  # some tens of roundings, of roots and powers
    for z in (-0.7 + 0.4j, -30.0, 2.0j):
        grown = 1 + z * A[2] @ np.linalg.solve(np.eye(3) - z * A, np.ones(3))
        pade = (1 + 2 * z / 5 + z**2 / 20) / (1 - 3 * z / 5 + 3 * z**2 / 20 - z**3 / 60)
        assert grown == pytest.approx(pade, rel=1e-12)
    assert sorted(np.linalg.eigvals(np.linalg.inv(A)).real)[-1] == pytest.approx(REAL)
    split = np.array([[REAL, 0, 0], [0, PAIR.real, -PAIR.imag], [0, PAIR.imag, PAIR.real]])
    assert np.linalg.solve(T, np.linalg.inv(A) @ T) == pytest.approx(split, abs=1e-12)
    for k in range(1, 4):  # of t^k with f(0) = 0 for k > 1: nothing is seen up to the third power
        assert ERROR @ C**k + (1.0 if k == 1 else 0.0) == pytest.approx(0.0, abs=1e-13)


@pytest.mark.parametrize("rtol", [1e-5, 1e-7, 1e-9])
def test_a_vibration_that_dies_out_costs_no_digits(rtol):
    """On a bar of 3e5 N/m, at first a tenth too short: it turns while Newton's matrix is kept."""
    bob = Body("bob", 2.5, (0.1, 0.1, 0.1), com=(0.1, 0, 0), position=(0.9, 0, 0))
    ends = {"at_a": (0, 0, 0), "at_b": (0.9, 0, 0)}
    bar = SpringDamper(GROUND, bob, **ends, stiffness=3e5, damping=200.0, length=1.0)
    run = simulate(System([bob], forces=[bar]), 1.0, method=RadauIIA(), rtol=rtol, output=11)
    true = simulate(System([bob], forces=[bar]), 1.0, rtol=1e-12, output=11, method=DOP853(stiff="run"))
    # as many local errors as there are steps, 140 to 640, some of them while the vibration is on
    assert np.abs(run.position(bob) - true.position(bob)).max() < 100 * rtol
    assert run.certificate.passed, run.certificate


def test_order_five():
    system, state = pendulum()
    true, errors = simulate(system, 1.0, state=state, rtol=1e-13).final.q, []
    for steps in (20, 40, 80):
        errors.append(np.abs(simulate(system, 1.0, state=state, method=RadauIIA(dt=1 / steps)).final.q - true).max())
    # 5 - O(h), and 20 steps are few; a method of order 4 is seen
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([5.0, 5.0], abs=0.4)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10])
def test_adaptive_steps_hold_the_tolerance(rtol):
    system, state = pendulum()
    run = simulate(system, 1.0, state=state, method=RadauIIA(), rtol=rtol, output=21)
    true = simulate(system, 1.0, state=state, rtol=1e-13, output=21)
    assert np.abs(run.arrays["q"] - true.arrays["q"]).max() < 100 * rtol  # errors add up, and grow in this motion
    assert run.certificate.passed, run.certificate


def test_the_governor_at_a_tight_tolerance():
    """Within 2e-6 m at 1e-8 by a tenth of the steps that stability makes DOP853 take."""
    times, expected = slider_height()
    run = simulate(governor(), 2.0, method=RadauIIA(), rtol=1e-8, output=times)
    assert np.abs(run.position("slider")[:, 2] - expected).max() < 5e-6
    assert run.certificate.passed, run.certificate
    explicit = simulate(governor(), 0.5, method=DOP853(stiff="run"), rtol=1e-8, output=2)
    assert 10 * run.certificate.steps < 4 * explicit.certificate.steps


def test_a_bushing_of_1e8_is_left_behind():
    exact = simulate(sensor(rigid=True), 2.0, rtol=1e-10, output=11)
    run = simulate(sensor(), 2.0, method=RadauIIA(), rtol=1e-6, output=11)
    assert run.certificate.passed, run.certificate
    assert run.certificate.steps < 300  # DOP853 needs more than a million
    assert np.abs(run.position("load") - exact.position("load")).max() < 1e2 * 1e-6 * run.compiled.model.length


def test_all_joints_and_drivers_at_once():
    system = all_joints_mechanism(3)
    state = consistent_state(system, np.random.default_rng(3))
    run = simulate(system, 0.2, state=state, method=RadauIIA(), rtol=1e-8, output=5)
    known = simulate(system, 0.2, state=state, rtol=1e-11, output=5)
    assert np.abs(run.arrays["q"] - known.arrays["q"]).max() < 1e-6
    assert run.certificate.passed, run.certificate


def test_own_states_events_and_slices():
    """A filtered servo against a stiff spring: stopped where a filter comes true, and the same motion in slices."""
    arm = Body("arm", 1.2, (0.02, 0.1, 0.1), com=(0.4, 0, 0))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, -1, 0), name="hinge")
    servo = StateFeedback(
        measures=[measures.angle(hinge), measures.rate(hinge)], gains=(40.0, 6.0), on=hinge, reference=(0.3, 0.0),
        time_constant=1e-4, name="servo",
    )  # fmt: skip
    system = System([arm], [hinge], [servo])
    condition = measures.angle(hinge) > 0.05
    found = simulate(system, 5.0, method=RadauIIA(), rtol=1e-9, stop_when=condition)
    known = simulate(system, 5.0, method=DOP853(stiff="run"), rtol=1e-11, stop_when=condition)
    assert found.final.t == pytest.approx(known.final.t, abs=1e-6)
    stepper = Stepper(system, method=RadauIIA(), rtol=1e-9)
    for t in (0.01, 0.05, 0.3):
        stepper.advance(t)
    whole = simulate(system, 0.3, method=RadauIIA(), rtol=1e-9)
    assert stepper.q == pytest.approx(whole.final.q, abs=1e-7)


def test_work_and_momentum_are_audited():
    block = Body("block", 2.0, (0.1, 0.1, 0.1), com=(0.1, 0, 0), position=(1.0, 0, 0))
    rail = Prismatic(GROUND, block, at=(1.0, 0, 0), axis=(1, 0, 0))
    forces = [
        SpringDamper(GROUND, block, at_a=(0, 0, 0), at_b=(1.0, 0, 0), stiffness=1e4, damping=50.0),
        Force(block, (Sine(30.0, 2.0), 0, 0)),
    ]
    run = simulate(System([block], [rail], forces), 1.0, method=RadauIIA(), rtol=1e-8)
    assert run.certificate.passed, run.certificate
    assert np.ptp(run.energy().work) > 1e-3


def test_reruns_are_the_same_to_the_bit():
    system, state = pendulum()
    one, two = (simulate(system, 0.5, state=state, method=RadauIIA()) for _ in range(2))
    assert np.array_equal(one.arrays["q"], two.arrays["q"])


def test_bad_parameters_and_steps_far_too_long():
    with pytest.raises(ValueError, match="RadauIIA: dt"):
        RadauIIA(dt=0.0)
    with pytest.raises(ValueError, match="RadauIIA: max_step: -1.0 is not positive"):
        RadauIIA(max_step=-1.0)
    with pytest.raises(IntegrationError, match="smaller dt"):
        simulate(governor(), 2.0, method=RadauIIA(dt=1.0))


@pytest.mark.parametrize("turned", [0.2, 0.5])
def test_stages_where_rows_repeat_each_other(turned):
    """Stages leave c = 0, where rows that repeat each other are the same no longer; ``turned`` [rad] at 20 rad/s."""
    system, hinge, state, angle = lead_screw()
    run = simulate(system, 2.0, state=state, method=RadauIIA(dt=turned / 20.0))
    assert np.abs(run.angle(hinge) - angle(run.t)).max() < 4e-4 * turned**5  # rad; order 5
    assert run.estimate().error < 4e-4 * turned**5


def test_adaptive_steps_where_rows_repeat_each_other():
    system, hinge, state, angle = lead_screw()
    run = simulate(system, 2.0, state=state, method=RadauIIA(), rtol=1e-4)
    assert np.abs(run.angle(hinge) - angle(run.t)).max() < 1e-4  # rad
    assert run.certificate.rejected < 0.1 * run.certificate.steps  # three in two where stages contradict themselves
