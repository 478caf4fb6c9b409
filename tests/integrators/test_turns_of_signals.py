"""Pulses and tables over time: steps end where a signal turns, so that none is stepped over, however short."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AngleDriver,
    Body,
    Force,
    GeneralizedAlpha,
    Input,
    Kinematic,
    Prismatic,
    Pulse,
    RadauIIA,
    Ramp,
    Revolute,
    SlideDriver,
    Stepper,
    System,
    Table,
    Torque,
    simulate,
)

METHODS = pytest.mark.parametrize("method", [DOP853(), RadauIIA(), GeneralizedAlpha()], ids=lambda x: type(x).__name__)


def sled_with(signal):
    """A body of 2 kg at rest, its centre of mass off its reference point, pushed along x through that centre."""
    sled = Body("sled", 2.0, (0.1, 0.12, 0.13), com=(0.1, -0.2, 0.3), velocity=(0, 0, 0), omega=(0, 0, 0))
    return System([sled], forces=[Force(sled, (signal, 0, 0), name="push")], gravity=(0, 0, 0))


@METHODS
@pytest.mark.parametrize(("start", "duration"), [(5.0, 0.01), (3.7, 0.2), (8.123, 0.002)])
def test_a_body_at_rest_takes_the_impulse_of_a_short_pulse(method, start, duration):
    """Steps grow without bound while nothing moves; each method stepped over the pulse, and its certificate passed."""
    edge = 0.3 * duration
    run = simulate(sled_with(Pulse(3.0, start, edge, duration)), 10.0, method=method, rtol=1e-6)
    impulse = 3.0 * (duration - edge)
    assert run.velocity("sled")[-1, 0] == pytest.approx(impulse / 2.0, rel=1e-3)
    assert run.certificate.passed and run.certificate.steps < 1500


@METHODS
def test_a_blip_in_a_table_is_seen(method):
    times = np.linspace(0.0, 10.0, 1001)
    values = np.zeros(1001)
    values[[640, 641]] = 40.0, 25.0
    signal = Table(times, values)
    run = simulate(sled_with(0.5 * signal), 10.0, method=method, rtol=1e-6)
    fine = np.linspace(0.0, 10.0, 200001)
    assert run.velocity("sled")[-1, 0] == pytest.approx(0.25 * np.trapezoid(signal(fine), fine), rel=1e-3)


def test_slices_see_pulses_too():
    stepper = Stepper(sled_with(Pulse(3.0, 5.0, 0.001, 0.01) + Input("more")))
    stepper.advance(4.0)
    stepper.advance(9.0)
    assert stepper.v[0] == pytest.approx(3.0 * 0.009 / 2.0, rel=1e-7)


def swing(signal, t_end):
    """Angle of a pendulum of two kilograms whose pivot is led along x by a signal, in one coordinate of its own."""
    com, inertia, mass, g = np.array([0.02, -0.8]), 0.03, 1.3, 9.81
    whole = inertia + mass * com @ com
    (term,) = signal.terms()
    breaks = np.unique(np.clip([0.0, *term.data[1 : 2 + int(term.data[0])], t_end], 0.0, t_end))

    def rate(t, y, low, high):
        x, z = com[0] * np.cos(y[0]) + com[1] * np.sin(y[0]), com[1] * np.cos(y[0]) - com[0] * np.sin(y[0])
        a = float(signal.second_derivative(np.clip(t, low, high)))
        return [y[1], mass * (x * g - z * a) / whole]

    y = np.zeros(2)
    for low, high in zip(breaks[:-1], breaks[1:], strict=True):
        inside = low + 1e-12, high - 1e-12  # the acceleration jumps at the breaks
        y = solve_ivp(rate, (low, high), y, "DOP853", args=inside, rtol=1e-12, atol=1e-13).y[:, -1]
    return y[0]


@pytest.mark.parametrize("rtol", [1e-6, 1e-9, 1e-11])
@pytest.mark.parametrize("duration", [0.03, None])
def test_a_driver_that_jumps_in_acceleration_is_followed_at_every_tolerance(rtol, duration):
    """The end of a step lies before the jump and the next one begins behind it: at rtol 1e-11 no step was found."""
    signal = Pulse(0.1, 1.23, 0.01, duration)
    base = Body("base", 1.0, (0.1, 0.1, 0.1), position=(0.1, 0.2, 0.3))
    bob = Body("bob", 1.3, (0.02, 0.03, 0.04), position=(0.1, 0.2, -0.5), com=(0.02, 0.01, 0.0))
    slide = Prismatic(GROUND, base, at=(0, 0, 0), axis=(1, 0, 0))
    pivot = Revolute(base, bob, at=(0.1, 0.2, 0.3), axis=(0, 1, 0), name="pivot")
    system = System([base, bob], [slide, pivot, SlideDriver(slide, signal)])
    run = simulate(system, 3.0, rtol=rtol, output=[0.0, 1.23, 1.24, 3.0])
    assert run.certificate.passed
    assert run.angle("pivot")[-1] == pytest.approx(swing(signal, 3.0), abs=max(300.0 * rtol, 1e-9))
    assert run.certificate.rejected < 15


@METHODS
@pytest.mark.parametrize("output", [None, [0.0, 1.0], 5])
def test_a_run_may_end_where_a_driver_begins_to_move(method, output):
    """Its last sample has the acceleration behind the jump, and stands at the end to the last digit."""
    arm = Body("arm", 1.0, (0.02, 0.03, 0.04), com=(0.3, 0.05, 0.1), position=(0.1, 0, 0))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0.1, 1, 0.2), name="hinge")
    motor = AngleDriver(hinge, Pulse(0.5, 1.0, 0.02, 1.0))
    rtol = 1e-4 if isinstance(method, GeneralizedAlpha) else 1e-12
    run = simulate(System([arm], [hinge, motor]), 1.0, method=method, rtol=rtol, output=output)
    assert run.t[-1] == 1.0 and (np.diff(run.t) > 0.0).all()
    assert run.certificate.passed and run.certificate.rejected < 5
    assert np.linalg.norm(run.alpha(arm)[-1]) == pytest.approx(6.0 * 0.5 / 0.02**2, rel=1e-9)


FIXED = [RK4(0.01), RK4(0.037), DOP853(dt=0.1), GeneralizedAlpha(dt=0.01), RadauIIA(dt=0.02)]


@pytest.mark.parametrize("method", FIXED, ids=str)
@pytest.mark.parametrize(("start", "edge", "duration"), [(0.5, 5e-5, 1.5e-4), (0.3137, 2e-4, 0.003), (0.25, 0.1, 0.3)])
def test_fixed_steps_are_split_where_a_pulse_turns(method, start, edge, duration):
    """Shorter than a step it was gone, and so was its impulse; the certificate passed."""
    signal = Pulse(1e4, start, edge, duration)
    run = simulate(sled_with(signal), 1.0, method=method)
    # the edges are cubics, which the trapezoidal rule of GeneralizedAlpha integrates exactly only as a whole
    assert run.velocity("sled")[-1, 0] == pytest.approx(1e4 * (duration - edge) / 2.0, rel=1e-3)
    if isinstance(method, RK4 | DOP853) and edge < 0.1 * method.dt:  # its power is of ninth degree, its work less exact
        assert run.certificate.passed
    steps = int(np.ceil(1.0 / method.dt - 1e-9))
    assert steps <= run.certificate.steps <= steps + 4
    grid = np.linspace(0.0, 1.0, steps + 1)
    assert np.abs(run.t[:, None] - grid).min(axis=0).max() < 1e-12  # and the equal steps are what they were


def test_fixed_steps_of_a_stepper_are_split_too():
    stepper = Stepper(sled_with(Pulse(3e3, 0.4003, 1e-4, 5e-4) + Input("more")), method=RK4(0.01))
    for t in (0.1, 0.33, 0.4, 0.405, 1.0):
        stepper.advance(t)
    assert stepper.v[0] == pytest.approx(3e3 * 4e-4 / 2.0, rel=1e-9)
    assert stepper.solution().certificate.steps <= 10 + 23 + 7 + 1 + 60 + 4


def test_fixed_steps_keep_their_order_over_a_table():
    """A table that turns twice a second, in steps that are not part of that; with every turn a step ends."""
    times = np.linspace(0.0, 3.0, 31)
    system = sled_with(Table(times, 5.0 * np.sin(2.1 * np.pi * times + 0.4)))
    exact = simulate(system, 3.0, rtol=1e-12).position("sled")[-1, 0]
    error = [abs(simulate(system, 3.0, method=RK4(h)).position("sled")[-1, 0] - exact) for h in (0.2, 0.1, 0.05)]
    assert error[2] < 1e-5 and error[1] < 0.3 * error[0]


def test_poses_of_a_driver_are_dense_in_its_edge_only():
    """The greatest speed so far held the distance of poses down to the end: 34 825 of them."""
    arm = Body("arm", 1.0, (0.02, 0.03, 0.04), com=(0.3, 0.05, 0.1), position=(0.1, 0, 0))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0.1, 1, 0.2), name="hinge")
    motor = AngleDriver(hinge, Pulse(0.7, 0.2, 1e-4))
    run = simulate(System([arm], [hinge, motor]), 1.0, method=Kinematic(), output=[0.0, 0.20005, 1.0])
    assert run.angle(hinge) == pytest.approx([0.0, 0.35, 0.7], abs=1e-12)
    assert run.certificate.passed and run.certificate.steps < 100


def test_work_of_a_driven_run_has_the_pulse_between_its_poses():
    arm = Body("arm", 1.0, (0.02, 0.03, 0.04), com=(0.3, 0.05, 0.1), position=(0.1, 0, 0))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    push = Torque(arm, (0, 0, Pulse(80.0, 0.4003, 1e-4, 1e-3)), name="push")
    run = simulate(System([arm], [hinge, AngleDriver(hinge, Ramp(2.0))], [push]), 1.0, method=Kinematic())
    assert run.work(push)[-1] == pytest.approx(80.0 * 9e-4 * 2.0, rel=1e-9)
