"""Time integration: observed orders, landing on times, repeatability, stopping, and reading between samples."""

import numpy as np
import pytest
from helpers.models import (
    all_joints_mechanism,
    consistent_state,
    direction,
    pendulum,
    random_body,
    same_rotation,
    spinning_wheel,
)
from helpers.swinging import swinging
from scipy.optimize import brentq

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    Body,
    Cylindrical,
    GeneralizedAlpha,
    Prismatic,
    Revolute,
    System,
    measures,
    simulate,
)
from validation import theory
from validation.cases import reference as cases

T = 0.1
"""s: sixteen radians of spin of the fast top, so that errors stay above rounding."""


def top_rotation(t):
    """Rotation of the top of the literature at a time, by Taylor series."""
    raw = cases.read("heavy_top_fast")["bodies"][0]
    about_pivot = np.diag(raw["inertia"]) + raw["mass"] * np.diag([1.0, 0.0, 1.0])
    weight = raw["mass"] * 9.81 * np.array([0.0, 1.0, 0.0])
    return theory.spinning_body([t], about_pivot, raw["w0"], weight_moment=weight).rotation[0].astype(float)


def errors(make, counts, shift):
    """Errors of the top's rotation at T with fixed steps."""
    system, exact = cases.load("heavy_top_fast", shift).system, top_rotation(T)
    runs = [simulate(system, T, method=make(T / n), output=2) for n in counts]
    assert [run.certificate.steps for run in runs] == list(counts)
    return np.array([np.abs(run.rotation("top")[-1] - exact).max() for run in runs])


@pytest.mark.parametrize("shift", [None, 7])
def test_rk4_is_of_fourth_order(shift):
    found = errors(RK4, (128, 256, 512, 1024), shift)
    assert np.log2(found[:-1] / found[1:]) == pytest.approx([4.0] * 3, abs=0.1)  # the limit set
    assert found[-1] > 1e-11  # far above rounding


@pytest.mark.parametrize("shift", [None, 7])
def test_dop853_with_fixed_steps_is_of_eighth_order(shift):
    found = errors(lambda dt: DOP853(dt=dt), (8, 16, 32), shift)
    slopes = np.log2(found[:-1] / found[1:])
    assert (slopes > 7.5).all() and (slopes < 9.0).all()  # the limit set
    assert found[-1] > 1e-12  # above rounding


def test_ablation_landing_beside_the_end_spoils_the_order():
    """A run that ends one part in a thousand of a step late would not be of fourth order."""
    system, late = cases.load("heavy_top_fast", 7).system, []
    for n in (128, 256, 512):
        run = simulate(system, T, method=RK4(T / n), output=2)
        late.append(np.abs(run.rotation("top")[-1] - top_rotation(T * (1 + 1e-3 / n))).max())
    assert abs(np.log2(late[-2] / late[-1]) - 4.0) > 0.5


FINER = [
    ({"rtol": 1e-6}, {"rtol": 1e-9}),
    ({"method": RK4(0.01)}, {"method": RK4(0.005)}),
    ({"method": DOP853(dt=0.07)}, {"method": DOP853(dt=0.035)}),
]


@pytest.mark.parametrize(("coarse", "fine"), FINER)
def test_tighter_tolerance_or_smaller_steps_are_better(coarse, fine):
    system, body, hinge = pendulum()
    start = system.assemble(rates={hinge: 3.0})
    exact, *found = (
        simulate(system, 1.0, state=start, output=2, **options).com(body)[-1]
        for options in ({"rtol": 1e-13}, coarse, fine)
    )
    first, second = (np.abs(x - exact).max() for x in found)
    assert second < 0.2 * first < 1e-4


@pytest.mark.parametrize("method", [RK4(0.03), DOP853(dt=0.03)])
def test_steps_that_do_not_divide_the_end_are_made_to(method):
    system, *_ = pendulum()
    solution = simulate(system, 0.1, method=method)
    assert solution.t[-1] == 0.1 and solution.final.t == 0.1
    assert np.diff(solution.t) == pytest.approx([0.025] * 4, rel=1e-14)  # never longer than asked for


@pytest.mark.parametrize("method", [None, RK4(0.01)])
def test_adaptive_and_fixed_steps_end_exactly(method):
    system, *_ = pendulum()
    t_end = 0.1 + 1 / 3
    solution = simulate(system, t_end, method=method)
    assert solution.t[0] == 0.0 and solution.t[-1] == t_end
    assert (np.diff(solution.t) > 0).all()


@pytest.mark.parametrize("method", [None, RK4(0.01), DOP853(dt=0.05)])
def test_reruns_are_the_same_to_the_last_bit(method):
    system = all_joints_mechanism(21)
    start = consistent_state(system, np.random.default_rng(21))
    first, second = (simulate(system, 0.3, state=start, method=method, output=7) for _ in range(2))
    again = simulate(all_joints_mechanism(21), 0.3, state=start, method=method, output=7)
    for name, array in first.arrays.items():
        assert np.array_equal(array, second.arrays[name])
        assert np.array_equal(array, again.arrays[name])
    assert np.array_equal(first.final.q, second.final.q) and np.array_equal(first.final.v, second.final.v)


def test_without_output_every_accepted_step_is_kept():
    system, *_ = pendulum()
    solution = simulate(system, 1.0)
    assert solution.t.size == solution.certificate.steps + 1


def test_a_count_gives_equally_spaced_samples():
    system, *_ = pendulum()
    solution = simulate(system, 1.3, output=14)
    assert np.array_equal(solution.t, np.linspace(0.0, 1.3, 14))


@pytest.mark.parametrize("times", [[0.3], [0.0, 0.011, 0.7, 1.3], np.linspace(0.1, 1.2, 300)])
def test_an_array_of_times_is_hit_exactly(times):
    system, *_ = pendulum()
    solution = simulate(system, 1.3, output=times)
    assert np.array_equal(solution.t, times)
    assert solution.final.t == 1.3


def test_more_samples_than_a_buffer_holds():
    system, body, _ = pendulum()
    times = np.linspace(0.0, 1.0, 5001)
    dense, sparse = (simulate(system, 1.0, output=t) for t in (times, times[::500]))
    assert dense.t.size == 5001
    assert np.array_equal(dense.position(body)[::500], sparse.position(body))  # the same steps, the same samples


def test_output_does_not_change_the_motion():
    system, *_ = pendulum()
    runs = [simulate(system, 1.0, output=output) for output in (None, 3, 977)]
    assert all(np.array_equal(run.final.q, runs[0].final.q) for run in runs)


def test_general_pendulum_follows_its_closed_form():
    system, hinge, state, angle = swinging()
    solution = simulate(system, 5.0, state=state, rtol=1e-11, output=101)
    assert solution.angle(hinge) == pytest.approx(angle(solution.t), abs=1e-9)  # 100 rtol over five swings


@pytest.mark.parametrize("down", [False, True])
def test_stop_is_located(down):
    system, hinge, state, angle = swinging()
    measure, start = measures.angle(hinge), float(angle(0.0))
    value = start + (-0.4 if down else 0.3)
    condition = measure < value if down else measure > value
    solution = simulate(system, 5.0, state=state, rtol=1e-12, stop_when=condition)
    crossing = brentq(lambda t: float(angle(t)) - value, 0.4 if down else 0.0, 1.2 if down else 0.3, xtol=1e-14)
    assert 0.0 < solution.t[-1] < 5.0
    assert solution.t[-1] == pytest.approx(crossing, abs=1e-10)  # the limit set
    assert solution.angle(hinge)[-1] == pytest.approx(value, abs=1e-10)
    assert solution.final.t == solution.t[-1]
    assert "angle" in solution.certificate.stopped_by and solution.certificate.passed


@pytest.mark.parametrize("output", [None, 51, [0.01, 0.02, 4.0]])
def test_stop_ends_the_samples(output):
    system, hinge, state, angle = swinging()
    value = float(angle(0.0)) + 0.3
    solution = simulate(system, 5.0, state=state, rtol=1e-10, stop_when=measures.angle(hinge) > value, output=output)
    assert solution.angle(hinge)[-1] == pytest.approx(value, abs=1e-9)
    assert (solution.angle(hinge)[:-1] < value).all()


def test_a_stop_that_never_comes_does_nothing():
    system, hinge, state, _ = swinging()
    with_stop = simulate(system, 2.0, state=state, stop_when=measures.angle(hinge) > 50.0, output=5)
    without = simulate(system, 2.0, state=state, output=5)
    assert with_stop.final.t == 2.0 and with_stop.certificate.stopped_by is None
    assert np.array_equal(with_stop.final.q, without.final.q)


def test_any_measure_can_stop_a_run():
    body = Body("stone", 1.3, (0.1, 0.2, 0.15), com=(0.1, -0.2, 0.3), velocity=(0.4, 0.1, 3.0), omega=(0.0, 0.0, 0.0))
    system = System(bodies=[body])
    highest = simulate(system, 5.0, stop_when=measures.velocity(body, axis=(0, 0, 1)) < 0.0)
    assert highest.t[-1] == pytest.approx(3.0 / 9.81, abs=1e-12)  # rounding
    fallen = simulate(system, 5.0, stop_when=measures.position(body, axis=(0, 0, 1)) < -1.0)
    expected = (3.0 + np.sqrt(9.0 + 2 * 9.81 * 1.3)) / 9.81
    assert fallen.t[-1] == pytest.approx(expected, abs=1e-12)


def test_states_between_the_samples():
    system, hinge, state, angle = swinging()
    solution = simulate(system, 2.0, state=state, rtol=1e-11, output=4)
    for t in (0.123, 1.0, 1.999):
        again = simulate(system, 2.0, state=state, rtol=1e-11, output=[t])
        between = solution.at(t)
        assert between.t == t
        # one error of the run, one of the start at a sample
        assert between.coordinates[0] == pytest.approx(float(angle(t)), abs=1e-9)
        assert same_rotation(between.q[3:], again.orientation("bob")[0]) < 1e-9


@pytest.mark.parametrize("kind", [Revolute, Prismatic, Cylindrical])
def test_rates_are_those_of_angles_and_slides_between_moving_bodies(kind):
    rng, h = np.random.default_rng(57), 2e-3
    a, b = random_body(rng, "a"), random_body(rng, "b")
    joint = kind(a, b, at=a.position + 0.3 * direction(rng), axis=direction(rng))
    system = System(bodies=[a, b], joints=[joint], gravity=(0, 0, 0))
    solution = simulate(system, 4 * h, state=consistent_state(system, rng), rtol=1e-12, output=np.arange(5) * h)
    x = solution.slide(joint) if kind is Prismatic else solution.angle(joint)
    slope = (8 * (x[3] - x[1]) - x[4] + x[0]) / (12 * h)
    assert solution.rate(joint)[2] == pytest.approx(slope, abs=1e-8)  # h^4 = 2e-11, rounding 1e-14 / h
    assert abs(slope) > 0.1


def test_state_at_a_sample_is_that_sample():
    system, *_ = pendulum()
    solution = simulate(system, 1.0, output=4)
    for k, t in enumerate(solution.t):
        assert np.array_equal(solution.at(t).q, solution.state(k).q)
        # A quaternion of a sample has length 1 to rounding; that of a state is scaled to it.
        assert np.allclose(solution.at(t).q, solution.arrays["q"][k].ravel(), rtol=0, atol=4e-16)


def test_a_run_goes_on_from_any_of_its_states():
    system, body, _ = pendulum()
    whole = simulate(system, 2.0, rtol=1e-11, output=[1.0, 2.0])
    first = simulate(system, 1.0, rtol=1e-11)
    second = simulate(system, 2.0, state=first.final, rtol=1e-11)
    assert second.t[0] == 1.0
    assert second.position(body)[-1] == pytest.approx(whole.position(body)[-1], abs=1e-9)  # 100 rtol


def test_angles_stay_unwrapped_over_a_restart():
    wheel = Body("wheel", 1.0, (0.1, 0.2, 0.15), omega=(0.0, 0.0, 40.0))
    hinge = Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 0, 1))
    system = System(bodies=[wheel], joints=[hinge])
    first = simulate(system, 1.0)
    second = simulate(system, 2.0, state=first.final)
    assert second.angle(hinge)[-1] == pytest.approx(80.0, abs=1e-7)  # rtol 1e-8 over 13 turns


@pytest.mark.parametrize(
    ("method", "allowed"),
    [(DOP853(dt=0.1), 2e-3), (GeneralizedAlpha(dt=0.1), 1e-8)],  # order 8 errs 5e-5 in a step of 4 rad; Newton's 1e-11
    ids=["dop853", "generalized alpha"],
)
@pytest.mark.parametrize("rate", [40.0, -37.3])
def test_angles_count_their_turns_in_steps_of_more_than_half_a_turn(method, allowed, rate):
    system, hinge = spinning_wheel(rate)
    run = simulate(system, 2.0, method=method)
    assert run.certificate.steps == 20
    assert run.angle(hinge) == pytest.approx(rate * run.t, abs=allowed)
