"""Driven motion between samples that are far apart: poses enough for Newton's method, and not many more."""

import numpy as np
import pytest

from mbsd3d import GROUND, AngleDriver, Body, Kinematic, Polynomial, Revolute, System, simulate

RATES = (2.0, 3.1, 7.0)  # rad/s


def gimbal():
    """(system, hinges): three rings in each other, turned by motors, so that angular accelerations never vanish."""
    rings = [Body(f"ring {i}", 1.0 + i, (0.1, 0.12, 0.15), com=(0.05, 0.02 * i, -0.03)) for i in range(3)]
    pairs = zip([GROUND, *rings], rings, np.eye(3), strict=False)
    hinges = [Revolute(a, b, at=(0, 0, 0), axis=axis) for a, b, axis in pairs]
    motors = [AngleDriver(hinge, Polynomial((0, rate))) for hinge, rate in zip(hinges, RATES, strict=True)]
    return System(rings, [*hinges, *motors]), hinges


@pytest.mark.parametrize("t_end", [2.0, 300.0])
def test_poses_between_wide_samples_grow_with_the_time_and_not_with_its_square(t_end):
    system, hinges = gimbal()
    run = simulate(system, t_end, method=Kinematic(), output=[0, 0.4 * t_end, t_end])
    assert run.certificate.passed, run.certificate
    for hinge, rate in zip(hinges, RATES, strict=True):  # driven, so to rounding of the angle
        assert run.angle(hinge)[-1] == pytest.approx(rate * t_end, rel=1e-14)
    # one pose in 0.3 rad of the fastest ring, which turns by less than the sum of the rates; fewer would miss turns
    assert 0.5 * max(RATES) * t_end / 0.3 < run.certificate.steps < 2.0 * sum(RATES) * t_end / 0.3


def test_wide_samples_are_those_of_narrow_ones():
    system, _ = gimbal()
    wide, narrow = (simulate(system, 6.0, method=Kinematic(), output=count) for count in (4, 301))
    # poses are on c = 0, wherever the last one was
    assert wide.arrays["q"] == pytest.approx(narrow.arrays["q"][::100], abs=1e-12)
