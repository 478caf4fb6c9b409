"""Times at which conditions come true, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AngleDriver,
    Body,
    GeneralizedAlpha,
    Kinematic,
    Polynomial,
    Prismatic,
    Pulse,
    Ramp,
    Revolute,
    Sine,
    StateFeedback,
    System,
    Torque,
    Universal,
    load,
    measures,
    rotation,
    simulate,
)

G = 9.81
LIMIT = 1e-10
"""The limit set for times of events, relative to the period or duration."""


def pendulum(amplitude):
    """(system, hinge, state, period): a physical pendulum, O and G off the hinge, released at an angle."""
    mass, inertia, reach = 1.4, np.array([0.3, 0.25, 0.12]), 0.7
    body = Body("bob", mass, inertia, com=(0.2, 0.1, -0.4), position=(-0.2, -0.1, 0.4 - reach))
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 1, 0))
    system = System([body], [hinge], gravity=(0, 0, -G))
    frequency = np.sqrt(mass * G * reach / (inertia[1] + mass * reach**2))
    period = 4.0 / frequency * ellipk(np.sin(amplitude / 2) ** 2)
    return system, hinge, system.assemble(angles={hinge: amplitude}), period


@pytest.mark.parametrize("amplitude", [0.4, 2.1])
@pytest.mark.parametrize("method", [DOP853(), DOP853(dt=0.02), RK4(5e-4)], ids=str)
def test_pendulum_passing_its_lowest_point(amplitude, method):
    system, hinge, state, period = pendulum(amplitude)
    solution = simulate(system, 9.0, state=state, method=method, rtol=1e-12, stop_when=measures.angle(hinge) < 0.0)
    assert abs(solution.final.t - period / 4) < LIMIT * period
    assert abs(solution.angle(hinge)[-1]) < 1e-14  # the stored sample is the event, to rounding
    assert solution.t[-1] == solution.final.t and solution.certificate.passed


def test_pendulum_turning_back():
    system, hinge, state, period = pendulum(1.3)
    solution = simulate(system, 9.0, state=state, rtol=1e-12, stop_when=measures.rate(hinge) > 1e-30)
    assert abs(solution.final.t - period / 2) < LIMIT * period


def test_the_event_of_rk4_is_as_exact_as_its_steps():
    system, hinge, state, period = pendulum(1.3)
    condition = measures.angle(hinge) < 0.0
    error = [
        abs(simulate(system, 9.0, state=state, method=RK4(h), stop_when=condition).final.t - period / 4)
        for h in (0.08, 0.04, 0.02)
    ]
    order = np.log2(np.array(error[:-1]) / error[1:])
    assert order == pytest.approx(4.0, abs=0.5)  # the event falls at another fraction of the step each time


def stone(up):
    """A thrown body, O off G; ``up`` [m/s] is the initial velocity of G."""
    com, omega = np.array([0.1, -0.2, 0.3]), np.array([0.7, -1.1, 0.4])
    body = Body("stone", 1.3, (0.1, 0.2, 0.15), com=com, position=-com, omega=omega,
                velocity=(0.4, 0.1, up) - np.cross(omega, com))  # fmt: skip
    return System([body], gravity=(0, 0, -G)), measures.position(body, axis=(0, 0, 1))


@pytest.mark.parametrize("method", [DOP853(), RK4(0.05)], ids=str)
def test_free_fall_from_rest(method):
    system, height = stone(0.0)
    solution = simulate(system, 3.0, method=method, stop_when=height < -2.5)
    assert solution.final.t == pytest.approx(np.sqrt(2 * 2.5 / G), rel=LIMIT if method.order == 8 else 1e-7)


@pytest.mark.parametrize("clearance", [0.1, 1e-6])
def test_true_and_false_again_within_one_step(clearance):
    system, height = stone(3.0)
    top = 3.0**2 / (2 * G) - clearance
    method = DOP853(dt=0.5)  # the flight above the height lasts 0.29 s, or 0.9 ms, from t = 0.306 s -+ half of it
    samples = simulate(system, 1.0, method=method)
    z = samples.com("stone")[:, 2]
    assert z.max() < top and samples.t.size == 3  # no end of a step sees it
    solution = simulate(system, 1.0, method=method, stop_when=height > top)
    exact = (3.0 - np.sqrt(2 * G * clearance)) / G
    # a nearly double root: 1e-11 m, the error of such long steps, at a speed of 4 mm/s
    assert solution.final.t == pytest.approx(exact, abs=LIMIT if clearance == 0.1 else 1e-8)
    missed = simulate(system, 1.0, method=method, stop_when=height > top + 1.01 * clearance)
    assert missed.final.t == 1.0  # a peak just below is none


def test_spin_up():
    rotor = Body("rotor", 2.0, (0.3, 0.3, 0.4), com=(0.05, -0.1, 0.2), position=(0.4, 0.3, 0.1))
    hinge = Revolute(GROUND, rotor, at=(0.45, 0.2, 0.0), axis=(0, 0, 1))
    system = System([rotor], [hinge], [Torque(rotor, (0, 0, 0.6))])
    by_rate = simulate(system, 50.0, stop_when=measures.rate(hinge) > 12.0)
    assert by_rate.final.t == pytest.approx(12.0 * 0.4 / 0.6, rel=LIMIT)
    by_angle = simulate(system, 50.0, stop_when=measures.angle(hinge) > 31.0)  # after almost five turns
    assert by_angle.final.t == pytest.approx(np.sqrt(2 * 31.0 * 0.4 / 0.6), rel=LIMIT)
    assert by_angle.final.coordinates[0] == pytest.approx(31.0, abs=1e-12)  # the turns are not forgotten


def test_an_own_state_stops_a_run():
    block = Body("block", 1.0, (0.1, 0.1, 0.1), com=(0.1, 0.2, 0.3))
    slider = Prismatic(GROUND, block, at=(0, 0, 0), axis=(1, 0, 0))
    filtered = StateFeedback(  # no gain: a filter of the constant speed 2 m/s from zero
        measures=[measures.slide_rate(slider)], gains=[0.0], on=slider, time_constant=0.3
    )
    system = System([block], [slider], [filtered])
    state = system.assemble(rates={slider: 2.0})
    solution = simulate(system, 5.0, state=state, rtol=1e-12, stop_when=measures.state(filtered) > 1.5)
    assert solution.final.t == pytest.approx(0.3 * np.log(4.0), rel=LIMIT)
    assert solution.state_of(filtered)[-1, 0] == pytest.approx(1.5, abs=1e-12)


def cardan():
    """(system, driven hinge, bend): a Cardan shaft driven at 2 rad/s."""
    bend = 0.5
    out = np.array([np.cos(bend), np.sin(bend), 0.0])
    drive = Body("drive", 1.0, (0.2, 1.0, 1.0), com=(0.1, 0.02, 0.03), position=(-0.5, 0, 0))
    driven = Body(
        "driven", 1.0, (0.2, 1, 1), com=(0.1, 0.02, 0.03), position=0.5 * out, orientation=rotation("z", bend)
    )
    entry = Revolute(GROUND, drive, at=(-0.5, 0, 0), axis=(1, 0, 0))
    exit_ = Revolute(GROUND, driven, at=out, axis=out)
    cross = Universal(drive, driven, at=(0, 0, 0), axis_a=(0, 1, 0), axis_b=(0, 0, 1))
    return System([drive, driven], [entry, exit_, cross, AngleDriver(entry, Ramp(2.0))]), exit_, bend


def cardan_angle(bend, phi):
    """Output angle of a Cardan joint whose input yoke starts in the plane of the shafts: tan(psi) cos(bend)^k = tan."""
    return np.arctan2(np.sin(phi) * np.cos(bend), np.cos(phi)), np.arctan2(np.sin(phi), np.cos(phi) * np.cos(bend))


@pytest.mark.parametrize("combine", [
    lambda x, y: (x > 0.1) and (y > 0.2), lambda x, y: (x > 0.1) or (y > 0.2), lambda x, y: 0.1 < x < 0.2,
])  # fmt: skip
def test_conditions_are_not_combined_without_a_word(combine):
    """Python's and, or and chains would silently keep one of the two."""
    _, hinge, *_ = pendulum(0.5)
    with pytest.raises(ValueError, match="condition 'angle of .* 0.1 rad' is neither true nor false.*single"):
        combine(measures.angle(hinge), measures.rate(hinge))


def test_at_least_and_at_most_are_the_same_events():
    _, hinge, *_ = pendulum(0.5)
    angle = measures.angle(hinge)
    assert (str(angle >= 0.3), str(angle <= 0.3)) == (str(angle > 0.3), str(angle < 0.3))


def test_kinematic_runs_stop_too():
    system, hinge, bend = cardan()
    condition = measures.angle(hinge) > 0.8
    solution = simulate(system, 2.0, method=Kinematic(), stop_when=condition, output=7, as_built=1e-6)
    both = [brentq(lambda t, k=k: cardan_angle(bend, 2.0 * t)[k] - 0.8, 0.0, 0.7, xtol=1e-15) for k in (0, 1)]
    assert min(abs(solution.final.t - t) for t in both) < LIMIT  # which one depends on the yoke
    assert np.diff(both)[0] < -1e-2
    assert solution.angle(hinge)[-1] == pytest.approx(0.8, abs=1e-13)
    dynamic = simulate(system, 2.0, rtol=1e-12, stop_when=condition, as_built=1e-6)
    assert dynamic.final.t == pytest.approx(solution.final.t, abs=LIMIT)


def test_kinematic_sees_a_peak_between_its_poses():
    system, hinge, bend = cardan()
    lowest = 2.0 * np.cos(bend)  # least speed of the driven shaft, twice a turn, first after a quarter
    rate, run = measures.rate(hinge), dict(method=Kinematic(), output=np.linspace(0.0, 1.2, 2), as_built=1e-6)
    stopped = simulate(system, 1.2, stop_when=rate < lowest + 1e-4, **run)
    assert stopped.rate(hinge)[-1] == pytest.approx(lowest + 1e-4, abs=1e-12)
    assert np.pi / 4 - 0.02 < stopped.final.t < np.pi / 4  # on the way down: (8e-4 / second derivative)^(1/2) before
    assert simulate(system, 1.2, stop_when=rate < lowest - 1e-4, **run).final.t == 1.2


def thrown(speed, height=0.0):
    """A stone thrown up, its reference point off its centre of mass, and the height of that."""
    stone = Body(
        "stone",
        1.3,
        (0.1, 0.2, 0.15),
        com=(0.1, -0.2, 0.3),
        position=(-0.1, 0.2, height - 0.3),
        velocity=(0.2, 0, speed),
        omega=(0, 0, 0),
    )
    return System([stone], gravity=(0, 0, -G)), measures.position(stone, axis=(0, 0, 1))


METHODS = [DOP853(), DOP853(dt=0.05), RK4(2e-3), GeneralizedAlpha(dt=1e-3)]


@pytest.mark.parametrize("method", METHODS, ids=str)
@pytest.mark.parametrize("height", [0.0, 10.0])
def test_a_run_may_start_at_the_value_on_the_way_out(method, height):
    """From z = 0 upwards until z < 0: back after 2 v / g, not at once; the method is exact for a parabola."""
    system, z = thrown(3.0, height)
    solution = simulate(system, 5.0, method=method, stop_when=z < height)
    assert solution.final.t == pytest.approx(6.0 / G, abs=1e-9)


def test_a_short_hop_within_one_step_is_seen():
    system, z = thrown(1e-3)
    assert simulate(system, 5.0, stop_when=z < 0.0).final.t == pytest.approx(2e-3 / G, rel=1e-6)


def test_a_condition_that_comes_true_at_the_start_waits_for_the_next_time():
    """z > 10 from z = 10 upwards: left on the true side, it does not come true again; nor does z < 10 in a fall."""
    system, z = thrown(3.0, 10.0)
    assert simulate(system, 2.0, stop_when=z > 10.0).final.t == 2.0
    system, z = thrown(0.0, 10.0)
    assert simulate(system, 2.0, stop_when=z < 10.0).final.t == 2.0
    system, hinge, state, period = pendulum(1.3)
    lowest = simulate(system, 9.0, state=state, rtol=1e-11, stop_when=measures.angle(hinge) < 0.0)
    for condition, turns in ((measures.angle(hinge) < 0.0, 1.0), (measures.angle(hinge) > 0.0, 0.5)):
        again = simulate(system, 9.0, state=lowest.final, rtol=1e-11, stop_when=condition)
        assert again.final.t - lowest.final.t == pytest.approx(turns * period, rel=1e-8)


@pytest.mark.parametrize(("method", "height"), [(DOP853(), 0.0), (DOP853(), 10.3), (RK4(0.05), -2.7)], ids=str)
def test_a_ball_that_bounces_ever_lower_never_falls_through(method, height):
    """Below a hop of 1e-9 of its size the condition was not armed, and the ball fell on after 55 bounces."""
    system, z = thrown(0.0, height + 1.3)
    state, kept, floor, flight = system.state(), 0.7, z < height, np.sqrt(2.0 * 1.3 / G)
    for k in range(90):
        run = simulate(system, state.t + 4.0, state=state, method=method, stop_when=floor, output=2)
        assert run.certificate.stopped_by is not None, k
        state = replace(run.final, v=run.final.v * [1, 1, -kept, 1, 1, 1])
    assert state.t == pytest.approx(flight * (1.0 + 2.0 * kept / (1.0 - kept)), rel=1e-9)
    assert state.q[2] + 0.3 == pytest.approx(height, abs=1e-9)


def test_a_certificate_names_a_condition_that_was_never_armed(tmp_path):
    system, z = thrown(0.0, 10.0)
    run = simulate(system, 2.0, stop_when=z < 10.0)
    (note,) = [text for text in run.certificate.notes if "never armed" in text]
    assert str(z < 10.0) in note and note in str(load(run.save(tmp_path / "fall.npz")).certificate)
    for other in (simulate(system, 2.0, stop_when=z < 9.0), simulate(system, 2.0, stop_when=z < -99.0)):
        assert not any("armed" in text for text in other.certificate.notes)


def test_a_driven_run_starts_at_the_value_too():
    body = Body("arm", 2.0, (0.1, 0.2, 0.15), com=(0.3, 0.1, 0))
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(1, 2, 2), name="hinge")
    system = System([body], [hinge, AngleDriver(hinge, Sine(0.5, 0.25))])
    for condition, end in ((measures.angle(hinge) < 0.0, 2.0), (measures.angle(hinge) > 0.0, 4.0)):
        solution = simulate(system, 5.0, method=Kinematic(), stop_when=condition, output=7)
        assert solution.final.t == pytest.approx(end, abs=1e-10)


def test_a_condition_that_holds_by_more_than_rounding_is_still_refused():
    system, z = thrown(3.0, 10.0)
    with pytest.raises(ValueError, match="holds already at the start"):
        simulate(system, 1.0, stop_when=z > 10.0 - 1e-6)


@pytest.mark.parametrize(
    "signals",
    [
        (Polynomial((0, 0, 0, 2.0)), Polynomial((0, 0, 0, -3.0))),
        (Sine(1.0, 1.0, np.pi / 2, -1.0), Sine(0.8, 2.0)),
        (Pulse(9.0, 0.3, 0.1), Pulse(-4.0, 0.4, 0.02)),
    ],
)
@pytest.mark.parametrize("output", [[0.0, 1.0, 2.0], [0.0, 0.77, 1.9]])
def test_driven_poses_do_not_depend_on_the_outputs(signals, output):
    """A gimbal driven from rest: nothing at the start tells how far it will turn until the next output."""
    outer = Body("outer", 1.0, (0.1, 0.1, 0.1), com=(0.1, 0, 0.2))
    inner = Body("inner", 1.0, (0.1, 0.2, 0.1), com=(0.1, 0.05, 0))
    joints = [
        Revolute(GROUND, outer, at=(0, 0, 0), axis=(0, 0.2, 1)),
        Revolute(outer, inner, at=(0, 0, 0), axis=(1, 0, 0)),
    ]
    system = System([outer, inner], joints + [AngleDriver(j, s) for j, s in zip(joints, signals, strict=True)])
    sparse = simulate(system, 2.0, method=Kinematic(), output=output)
    for joint, signal in zip(joints, signals, strict=True):
        assert sparse.angle(joint) == pytest.approx(signal(sparse.t), abs=1e-9)
    dense = simulate(system, 2.0, method=Kinematic(max_step=0.004), output=output)
    assert np.abs(dense.arrays["q"] - sparse.arrays["q"]).max() < 1e-11
    assert sparse.certificate.passed, sparse.certificate
