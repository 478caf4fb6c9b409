"""The rider of five loops against published gains and factors, balance assist, courses in the nonlinear model."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from scipy.linalg import solve_continuous_lyapunov

from bicycle import Meijaard2007, assist, course, handling, named, rider, tyres, whipple
from bicycle.linear.general import linearization
from bicycle.model.mechanism import Bicycle
from bicycle.parameters import fittings
from mbsd3d import StateFeedback, measures
from mbsd3d.extend import main

TRUTHS = json.loads(Path(__file__).with_name("tyre_truths.json").read_text(encoding="utf-8"))
P = Meijaard2007()
BICYCLES = {"benchmark": "Meijaard2007", "browser": "meijaard2007_browser_jason"}
ROWS = [(name, row) for name, rows in TRUTHS["rider_closed_loop"].items() for row in rows]


def complexes(pairs):
    return np.sort_complex([complex(*pair) for pair in pairs])


@pytest.mark.parametrize(("name", "row"), ROWS, ids=lambda x: x if isinstance(x, str) else f"{x['v']} m per s")
def test_closed_loops_of_an_independent_program(name, row):
    found = rider.eigenvalues(named(BICYCLES[name]), row["v"], rider.Gains(*row["gains"]))
    # the file's numbers, up to 41, are written to 5e-12 and computed to a few of these; ours are good to 3e-13
    assert found == pytest.approx(complexes(row["eigenvalues"]), abs=3e-11)


def test_printed_factors():
    """Moore (2012), chapter Control: Charlie on the Rigidcl at 5 m/s; a root printed to four digits may be cut."""
    p, printed = named("HC_RigidCharlie"), TRUTHS["rider_sequential_closure"]
    gains = rider.gains_of(p, 5.0, steer=17.48, roll_rate=-0.44)
    assert gains[2:] == pytest.approx(printed["k_phi_psi_y"], rel=1e-11)
    for count, row in (
        (1, printed["computed"][0]["poles"]),
        (2, printed["computed"][1]["poles"]),
        (3, printed["phi_poles"]),
    ):
        found = rider.eigenvalues(p, 5.0, gains, count)
        assert found == pytest.approx(complexes(row), abs=1e-7)  # two zeros on a Jordan block
    found = rider.factors(rider.eigenvalues(p, 5.0, gains, 1))
    assert found == printed["printed_factors"]["delta"]


@pytest.mark.parametrize("k", range(4))
def test_rule_of_the_outer_loops(k):
    row, check = TRUTHS["rider_closed_loop"]["benchmark"][k], TRUTHS["rider_gain_rule_check"][k]
    found = rider.gains_of(P, row["v"], steer=row["gains"][0], roll_rate=row["gains"][1])
    assert found[2:] == pytest.approx(check["rule"], rel=1e-11)


@pytest.mark.parametrize(("name", "row"), ROWS[1:], ids=lambda x: x if isinstance(x, str) else f"{x['v']} m per s")
def test_rule_of_the_inner_loops(name, row):
    """Published gains were set by hand to about 10 dB: a tenth off in the first, a fifth in the second loop."""
    found = rider.gains_of(named(BICYCLES[name]), row["v"])
    assert found.steer == pytest.approx(row["gains"][0], rel=0.06)
    assert found.roll_rate == pytest.approx(row["gains"][1], rel=0.2)
    assert rider.eigenvalues(named(BICYCLES[name]), row["v"], found).real.max() < 0.0


@pytest.mark.parametrize(
    ("name", "speed", "text"),
    [
        ("Pista", 6.5, "steer angle loop peaks by 13 dB however small its gain.* 10 dB.* at no speed; give gains"),
        ("Meijaard2007", 2.0, "roll rate loop peaks by 10.3 dB however small.* at 2.5 ... 15 m/s; give such a speed"),
        ("Fisher", 1.0, "roll rate loop peaks by 7.22 dB at most, with gains up to -1"),
    ],
)
def test_where_the_rule_finds_no_gains(name, speed, text):
    """The weave of the riderless Pista has a damping ratio of 0.058 and peaks by itself."""
    with pytest.raises(ValueError, match=text):
        rider.gains_of(named(name), speed)


@pytest.mark.parametrize("k", range(4))
def test_handling_quality(k):
    """Of an independent program, which took the largest of its grid of frequencies: a few 1e-5 below the peak."""
    row, truth = TRUTHS["rider_closed_loop"]["benchmark"][k], TRUTHS["hqm_peak"][k]
    gains = rider.Gains(*row["gains"])
    assert handling.metric(P, row["v"], gains, truth["omega"])[0] == pytest.approx(truth["peak"], rel=1e-10)
    found = handling.peak(P, row["v"], gains)
    assert truth["peak"] <= found.value == pytest.approx(truth["peak"], rel=2e-5)
    assert found.frequency == pytest.approx(truth["omega"], rel=2e-4)


def test_handling_quality_over_the_speed(tmp_path):
    """It gets better with speed; the rule has no gains below 2.3 m/s, and unbalanced loops have no metric."""
    found = handling.study(named("HC_Benchmark"), [1.5, 2.0, 3.0, 5.0, 9.0])
    assert np.isnan(found.values[:2]).all() and (np.diff(found.values[2:]) < 0.0).all()
    assert "no gains by rule  1.5 ... 2 m/s" in str(found)
    table = np.genfromtxt(found.to_csv(tmp_path / "h"), delimiter=",", skip_header=1)
    assert table[3, 1] == found.values[3] and table[3, 3:] == pytest.approx(rider.gains_of(P, 5.0), rel=1e-3)
    with pytest.raises(ValueError, match="does not balance it"):
        handling.peak(P, 1.0, rider.Gains(9.2, -0.52, 6.2, 0.05, 0.34))
    with pytest.raises(ValueError, match="speed = 0 m/s; give positive"):
        handling.study(P, [0.0, 5.0])


@pytest.mark.parametrize("gain", TRUTHS["roll_rate_feedback_benchmark"])
def test_roll_rate_feedback(gain):
    (found,) = assist.stable_ranges(P, assist.roll_rate(float(gain)))
    assert found == pytest.approx(TRUTHS["roll_rate_feedback_benchmark"][gain], abs=1e-10)


def test_assist_in_the_general_model():
    """The same feedback as a force of the mechanism."""

    def build(p, speed):
        system = whipple(p, speed=speed)
        seen = measures.lean_rate(system.part("frame"))
        force = StateFeedback(measures=[seen], gains=(-8.0,), on=system.part("steer", "joints"))
        return Bicycle(system.bodies, system.joints, [force], gravity=system.gravity, start=system.start)

    found = np.sort_complex(linearization(build, P, 3.7).eigenvalues)
    assert found == pytest.approx(assist.eigenvalues(P, [3.7], assist.roll_rate(-8.0))[0], abs=1e-10)


def test_regulator_and_steer_into_the_fall_widen_the_range():
    (best,) = assist.stable_ranges(P, assist.regulator(P), np.linspace(12.0, 0.1, 20))  # in any order
    (fall,) = assist.stable_ranges(P, assist.into_the_fall(-20.0, -10.0), np.linspace(0.1, 12.0, 20))
    assert best == (0.1, 12.0)
    assert fall.low < 4.0 and fall.high == 12.0
    K = assist.regulator(P)(5.0)
    assert np.linalg.eigvals(assist.canonical(P).A(5.0) - assist.input_of(P) * K).real.max() < 0.0


def test_the_regulator_costs_least():
    """The integral of sum w_i x_i^2 + effort T^2 by Lyapunov's equation grows with every change of the gains."""
    weights, effort, v = np.array([1.0, 3.0, 0.5, 0.2]), 0.03, 4.0
    A, B = assist.canonical(P).A(v), assist.input_of(P)

    def cost(K):
        closed = A - B * K
        return np.trace(solve_continuous_lyapunov(closed.T, -np.diag(weights) - effort * np.outer(K, K)))

    K = assist.regulator(P, weights, effort)(v)
    for change in 1e-2 * np.diag(np.abs(K)):
        more, less = cost(K + change) / cost(K) - 1, cost(K - change) / cost(K) - 1
        assert min(more, less) > 0.0 and more == pytest.approx(less, rel=0.2)  # of second order in the change


@pytest.mark.parametrize("on", [None, tyres.TYPICAL])
def test_a_lane_change(on):
    """In the nonlinear model the rider gets there, steering to the left first."""
    found = course.run(P, course.Course(lane=2.0), speed=5.0, tyres=on, rtol=1e-7, samples=241)
    assert found.deviation[-1] == pytest.approx(2.0, abs=0.02)
    first = np.flatnonzero(np.abs(found.torque) > 0.05)[0]
    assert found.torque[first] < 0.0 < found.deviation[-1]
    assert found.ride.solution.certificate.passed


def test_commands_of_the_loops_are_those_that_the_arms_follow():
    """T'' = 900 (U - T) - 42.42 T' of the run, with U of the commands that are read from its motion afterwards."""
    found = course.run(P, course.Course(lane=2.0, at=1.0), speed=5.0, t_end=3.0, samples=61)
    arms = found.ride.solution.force("rider", on="fork")
    U = found.gains.steer * (found.commands()["steer"] - found.ride.steer)
    known = 900.0 * (U - arms.states["torque"]) - 42.42 * arms.states["torque rate"]
    assert arms.state_rates["torque rate"] == pytest.approx(known, abs=1e-8 * np.abs(known).max())


def test_a_rider_who_falls():
    """No wheel is held down: the ride ends where one lifts, or the frame has fallen."""
    ideal, grip = (course.run(P, course.Course(lane=2.0), speed=1.0, tyres=on).ride for on in (None, tyres.TYPICAL))
    assert ideal.event.name.endswith("wheel unloaded") and ideal.contacts["front"].normal.min() > -1e-3
    assert grip.event.name == "fallen" and grip.t[-1] == grip.event.t < 12.0


@pytest.mark.parametrize(
    "wrong",
    [{"within": 0.0}, {"period": -1.0}, {"lane": np.nan}, {"slalom": "wide"}],
    ids=lambda wrong: next(iter(wrong)),
)
def test_impossible_courses_are_refused(wrong):
    with pytest.raises(ValueError, match=f"course: {next(iter(wrong))}"):
        course.Course(**wrong)


@pytest.mark.parametrize("gains", [(46.5, -0.05), 3.0, (46.5, -0.05, 12.0, np.nan, 0.1)])
def test_a_rider_has_five_gains(gains):
    """Compiled loops would read two gains and the course as five."""
    for call in (
        rider.eigenvalues,
        handling.peak,
        lambda *given: course.run(P, course.Course(), speed=5.0, gains=gains),
    ):
        with pytest.raises(ValueError, match="rider: gain"):
            call(P, 5.0, gains)


def test_rides_and_assist_refuse_what_has_no_answer():
    for wrong, message in (({"samples": 1}, "output = 1 samples"), ({"t_end": "long"}, "t_end: expected a number")):
        with pytest.raises(ValueError, match=message):
            course.run(P, course.Course(), speed=5.0, **wrong)
    with pytest.raises(ValueError, match="course = 'slalom'; give a Course"):
        course.run(P, "slalom", speed=5.0)
    with pytest.raises(ValueError, match="at least two different speeds"):
        assist.stable_ranges(P, assist.roll_rate(-10.0), [5.0])
    with pytest.raises(ValueError, match="weights = .*; give four"):
        assist.regulator(P, (1.0, 1.0))


def test_a_course_does_not_start_on_a_wheel_that_is_not_pressed():
    tipping = replace(P, xB=-0.3)
    with pytest.raises(ValueError, match="front wheel is not pressed to the ground .* it tips even at rest"):
        course.run(tipping, course.Course(), speed=5.0, gains=rider.gains_of(P, 5.0))


def test_a_course_keeps_the_steer_damper():
    p = named("Sharp1971")
    system = course.ridden(p, 10.0, course.Course(), rider.gains_of(p, 10.0), **fittings(p))
    assert [force.name for force in system.forces] == ["rear tyre", "front tyre", "steer damper", "rider"]


def test_small_courses_are_those_of_the_linear_loops():
    """A lane of a tenth of a millimetre: the linear equations' answer, to what 3e-5 rad squared adds."""
    gains, lane = rider.Gains(*TRUTHS["rider_closed_loop"]["benchmark"][1]["gains"]), 1e-4
    found = course.run(P, course.Course(slalom=lane, period=5.0), speed=5.0, gains=gains, t_end=40.0, samples=2001)
    loops = rider.closed_loops(P, 5.0, gains)
    answer = loops.response(2.0 * np.pi / 5.0)[0, 5]
    t = found.ride.t[-400:]
    wanted = lane * np.imag(answer * np.exp(2j * np.pi / 5.0 * t))
    assert found.deviation[-400:] == pytest.approx(wanted, abs=2e-4 * lane)  # what is left of the start after 32 s


@pytest.mark.slow
def test_command(tmp_path):
    out = ["--course", "slalom", "--t-end", "2", "--out", str(tmp_path)]
    done = CliRunner().invoke(main, ["bicycle", "rider", *out], catch_exceptions=False)
    assert done.exit_code == 0
    assert "roll-rate feedback  -10 N m s/rad: stable on ideal wheels 2.81174 ... 6.02426 m/s" in done.output
    assert (tmp_path / "Meijaard2007_slalom.csv").read_text().startswith("t [s],lean [rad]")
    assert "with these gains at 5 m/s: 4.765 at 13.57 rad/s" in done.output
    assert (tmp_path / "handling_Meijaard2007.csv").read_text().startswith("speed [m/s],peak [-]")
