"""Signals that swing within a fixed step: every stage may see one phase of them, in finer runs too."""

import numpy as np
import pytest

from mbsd3d import DOP853, GROUND, RK4, AngleDriver, Body, Force, GeneralizedAlpha, RadauIIA, Revolute, System, simulate
from mbsd3d.signals import Sine

MASS = 2.3  # kg


def shaken(frequency, phase):
    """A body off its centre, pushed along a general direction by 90 N."""
    body = Body("block", MASS, (0.11, 0.13, 0.17), com=(0.05, -0.02, 0.04), position=(0.3, 0.2, -0.1))
    push = [Sine(90.0 * x, frequency, phase=phase) for x in (0.6, 0.0, 0.8)]
    return body, System([body], forces=[Force(body, push, at=body.centre, name="shaker")], gravity=(0, 0, 0))


@pytest.mark.parametrize(
    ("method", "frequency"),
    [(GeneralizedAlpha(dt=0.02), 100.0), (RK4(0.02), 200.0), (DOP853(dt=0.02), 400.0), (RadauIIA(dt=0.02), 150.0)],
)
def test_a_sine_that_all_stages_see_at_one_phase_fails(method, frequency):
    body, system = shaken(frequency, np.pi / 2)
    run = simulate(system, 1.0, method=method)
    amplitude = 90.0 / (MASS * (2 * np.pi * frequency) ** 2)  # m, the motion swings by twice that
    assert np.abs(run.com(body) - body.centre).max() > 1e3 * amplitude  # what the steps make of it
    certificate = run.certificate
    assert not certificate.passed and certificate["signals"].error == pytest.approx(frequency * 0.02)
    assert any("'shaker' swings faster than the steps" in note for note in certificate.notes)
    assert not run.estimate().error < 1e-2


def test_resolved_sines_and_adaptive_steps_need_no_such_check():
    for method in (RK4(0.001), DOP853()):
        body, system = shaken(40.0, 0.4)
        run = simulate(system, 0.5, method=method)
        w = 2 * np.pi * 40.0
        away = (np.sin(0.4) - np.sin(w * run.t + 0.4) + w * run.t * np.cos(0.4)) * 90.0 / (MASS * w**2)
        known = body.centre + np.outer(away, (0.6, 0.0, 0.8))
        assert np.abs(run.com(body) - known).max() < 1e-6  # RK4: 25 steps a period
        assert run.certificate.passed and not any("faster" in note for note in run.certificate.notes)
        assert "signals" not in [check.name for check in run.certificate.checks]


def test_a_driver_is_named_too():
    arm = Body("arm", MASS, (0.1, 0.2, 0.2), com=(0.3, 0.1, 0))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0.36, 0.48, 0.8))
    motor = AngleDriver(hinge, Sine(0.2, 60.0), name="motor")
    run = simulate(System([arm], [hinge, motor]), 0.1, method=RK4(0.01), state=None)
    assert run.certificate["signals"].meaning.startswith("'motor'")
