"""Rides: published point values, closed forms of small motions, laws of conservation, events, bad input."""

import doctest
import json
import re
from dataclasses import replace

import matplotlib
import numpy as np
import pytest
import scipy.linalg
from click.testing import CliRunner

from bicycle import TYPICAL, Meijaard2007, circles, named, ride, whipple
from bicycle.linear.equations import canonical
from bicycle.parameters import library, names
from bicycle.rides.manoeuvres import MANOEUVRES
from mbsd3d import IntegrationError, Pulse
from mbsd3d.extend import main
from validation import cross_check

matplotlib.use("Agg")
BENCHMARK = Meijaard2007()
M1 = library()["iftomm_uncontrolled_bicycle"]["point_values_M1"]["values"]


@pytest.fixture(scope="module")
def first():
    times = [row["t"] for row in M1]
    return ride.run(BENCHMARK, 20.0, speed=4.0, lean_rate=0.05, rtol=1e-11, output=times)


@pytest.mark.parametrize(
    ("name", "key"),
    [
        ("lean", "lean_phi"), ("lean_rate", "lean_rate"), ("steer", "steer_delta"), ("steer_rate", "steer_rate"),
        ("heading", "yaw_psi"), ("yaw_rate", "yaw_rate"), ("pitch", "pitch_theta"),
    ],
)  # fmt: skip
def test_first_manoeuvre_has_the_published_values(first, name, key):
    # rad, rad/s up to 0.7; the reference claims 3e-9 at 20 s
    assert np.abs(getattr(first, name) - [row[key] for row in M1]).max() < 2e-8


def test_first_manoeuvre_way_wheels_and_energy(first):
    rear, energy = first.contacts["rear"].point, first.solution.energy()
    assert np.abs(rear[:, 0] - [row["x_rear_contact"] for row in M1]).max() < 2e-8
    assert np.abs(rear[:, 1] + [row["y_rear_contact"] for row in M1]).max() < 2e-8  # the reference has y to the right
    assert np.abs(first.speed / BENCHMARK.rR + [row["OmR"] for row in M1]).max() < 2e-7  # 13 rad/s
    front = first.solution.angle("front hub") + [row["wheel_angle_F"] for row in M1]
    assert np.abs(front).max() < 1e-6  # of 233 rad
    assert energy.potential == pytest.approx([row["Epot"] for row in M1], abs=1e-6)
    assert energy.kinetic == pytest.approx([row["Ekin"] for row in M1], abs=1e-6)


def test_second_manoeuvre_keeps_energy_and_momentum():
    found = ride.run(BENCHMARK, **MANOEUVRES["M2"].arguments)
    assert found.event is None and found.t[-1] == 20.0
    assert found.energy_drift < 1e-9  # asked for
    assert found.solution.certificate.passed


def test_wheels_carry_the_weight_when_it_goes_straight():
    known, found = library()["static_wheel_loads"], ride.run(BENCHMARK, 0.1, speed=5.0).contacts
    assert found["rear"].normal == pytest.approx(known["rear_N"], rel=1e-13)
    assert found["front"].normal == pytest.approx(known["front_N"], rel=1e-13)
    assert max(np.abs(contact.friction).max() for contact in found.values()) < 1e-13


def test_forces_of_the_ground_are_what_the_momentum_needs():
    found = ride.run(BENCHMARK, 3.0, speed=4.6, lean_rate=0.5, rtol=1e-11, output=np.arange(0.0, 3.0, 0.002))
    total = sum(contact.force for contact in found.contacts.values())
    momentum, h = found.solution.momentum().linear, 0.002
    rate = (8 * (momentum[3:-1] - momentum[1:-3]) - (momentum[4:] - momentum[:-4])) / (12 * h)
    weight = np.array([0.0, 0.0, -found.solution.system.total_mass() * BENCHMARK.g])
    # fourth-order differences: h^4 / 30 times the fifth derivative of a momentum of 400 at rates of 10 per second
    assert np.abs(total[2:-2] + weight - rate).max() < 1e-3
    assert np.ptp(rate, axis=0).max() > 10.0
    rear = found.contacts["rear"]
    assert np.hypot(rear.along, rear.across) == pytest.approx(np.hypot(*rear.force[:, :2].T), rel=1e-12)


def test_small_steer_torque_makes_the_turn_of_the_linear_equations():
    """Counter-steering: first to the side of the torque, in the end to the other one."""
    torque, linear = 1e-4, canonical(BENCHMARK)
    found = ride.run(BENCHMARK, 60.0, speed=5.0, torque=Pulse(torque, 0.5, 0.1), rtol=1e-12)
    steady = np.linalg.solve(linear.g * linear.K0 + 25.0 * linear.K2, [0.0, torque])
    # slowest mode exp(-0.32 t); terms of third order are 1e-7 of the first, and 1e-5 at ten times the torque
    assert found.lean[-1] == pytest.approx(steady[0], rel=1e-6)
    assert found.steer[-1] == pytest.approx(steady[1], rel=1e-6)
    soon = (found.t > 0.5) & (found.t < 0.9)
    assert found.steer[soon].max() > 0.0 > steady[1]
    assert found.lean[soon].max() < 1e-9


def test_small_ride_follows_the_linear_equations():
    start = np.array([2e-6, -1e-6, 3e-6, 1e-6])
    names = ("lean", "steer", "lean_rate", "steer_rate")
    found = ride.run(BENCHMARK, 2.0, speed=4.0, rtol=1e-12, output=9, **dict(zip(names, start, strict=True)))
    A = canonical(BENCHMARK).A(4.0)
    expected = np.array([scipy.linalg.expm(A * t) @ start for t in found.t])
    seen = np.column_stack([getattr(found, name) for name in names])
    assert np.abs(seen - expected).max() < 1e-11  # quaternions round at 1e-16 near 1, so angles at 1e-12 over the run


def test_steady_torque_ends_in_the_circle_it_holds():
    found = ride.run(BENCHMARK, **MANOEUVRES["circle"].arguments)
    assert found.event is None
    for quarter in (90.0, 180.0, 360.0, 720.0):
        assert np.degrees(found.heading).max() > quarter
    assert np.abs(np.diff(found.heading)).max() < 0.5  # no jump
    turn = circles.turn(BENCHMARK, found.lean[-1], found.steer[-1])
    assert turn.torque == pytest.approx(-0.1, rel=1e-3)  # 60 s of a mode that dies out in 3 s, speed still changes
    assert turn.speed == pytest.approx(found.speed[-1], rel=1e-4)
    assert turn.yaw_rate == pytest.approx(found.yaw_rate[-1], rel=1e-4)


def test_mirrored_pushes_make_mirrored_rides():
    push, times = Pulse(60.0, 0.2, 0.05, 0.4), np.linspace(0.0, 4.0, 41)
    right, left = (
        ride.run(BENCHMARK, 4.0, speed=4.8, push=side * push, torque=side * Pulse(0.3, 1.0, 0.1, 0.5), output=times,
                 rtol=1e-11)
        for side in (1.0, -1.0)
    )  # fmt: skip
    limit = 2 * right.solution.record.steps * 1e-11  # every step of either may be off by its tolerance
    for name in ("lean", "steer", "heading"):
        assert np.abs(getattr(right, name) + getattr(left, name)).max() < limit
    assert right.lean[-5:].min() != 0.0 and right.contacts["rear"].across == pytest.approx(
        -left.contacts["rear"].across, abs=1e-6
    )
    work = right.solution.energy().work[-1]
    assert abs(work) > 1e-3 and right.energy_drift < 1e-9


def test_wheel_that_lifts_ends_the_ride_where_its_load_vanishes():
    found = ride.run(BENCHMARK, 10.0, speed=2.0, lean_rate=0.05, output=101)
    name, t = found.event
    assert name == "front wheel unloaded" and found.t[-1] == t and 1.0 < t < 10.0
    load = found.contacts["front"].normal
    assert abs(load[-1]) < 1e-4  # 400 N/s times the 1e-9 s to which the time is found, and rounding of some 1e-9 N more
    assert (load[:-1] > 0.0).all() and (np.diff(found.t) > 0.0).all()
    mirrored = ride.run(BENCHMARK, 10.0, speed=2.0, lean_rate=-0.05)
    assert mirrored.event.name == name and mirrored.event.t == pytest.approx(t, abs=1e-6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_bicycle_that_falls_stops_at_the_tilt(side):
    found = ride.run(BENCHMARK, 10.0, speed=1.0, lean_rate=side * 0.05, fallen=np.radians(20.0))
    assert found.event.name == "fallen" and found.event.t == found.solution.final.t == found.t[-1]
    up = found.solution.rotation("frame")[:, 2, 2]
    assert np.degrees(np.arccos(up[-1])) == pytest.approx(20.0, abs=1e-6)
    assert (up[:-1] > up[-1]).all()
    assert "fallen at t = " in str(found)


@pytest.mark.slow
def test_two_mass_skate_rides_on_massless_wheels():
    """Point masses and massless wheels: it follows its linear equations, and comes back upright without a gyro."""
    skate, start = named("Tms"), 1e-5
    with pytest.raises(
        ValueError, match="the rear wheel is not pressed to the ground .* 118.* on the front wheel; give held_down=True"
    ):
        ride.run(skate, 3.0, speed=4.0)  # its weight is in front of the front wheel
    found = ride.run(skate, 3.0, speed=4.0, lean=start, output=31, rtol=1e-12, held_down=True)
    A = canonical(skate).A(4.0)
    expected = np.array([scipy.linalg.expm(A * t) @ [start, 0, 0, 0] for t in found.t])
    assert (
        np.abs(found.lean - expected[:, 0]).max() < 1e-10
    )  # terms of third order, and rounding near a quaternion of 1
    far = ride.run(skate, 40.0, speed=4.0, lean_rate=0.3, held_down=True)
    assert far.event is None and np.abs(far.lean).max() > 0.01
    assert np.abs(far.lean[-5:]).max() < 1e-3 * np.abs(far.lean).max()
    assert far.energy_drift < 1e-8 and far.solution.certificate.passed


@pytest.mark.slow
def test_all_published_bicycles_ride():
    for name in names():
        found = ride.run(named(name, unphysical=True), 3.0, speed=5.0, lean_rate=0.1, held_down=name == "Tms")
        assert found.solution.certificate.passed, name
        assert found.energy_drift < 1e-8, name


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"speed": 5.0, "lean": 1.2}, "tilted by 1.2 rad at the start, where 1.047 counts as fallen"),
        ({"speed": 5.0, "fallen": 2.0}, "fallen = 2 rad; give a tilt below pi/2"),
        ({"speed": 5.0, "fallen": 0.0}, "ride: fallen"),
        (
            {"speed": 25.0, "lean": -0.9, "steer": 0.5},
            "not pressed to the ground at the start .* give a slower or more upr",
        ),
        ({"speed": np.nan}, "speed"),
        ({"speed": 5.0, "torque": "hard"}, "ride: torque is 'hard'"),
        ({"speed": 5.0, "push": "east"}, "ride: push is 'east'"),
    ],
)
def test_bad_input_names_what_is_wrong(arguments, message):
    with pytest.raises(ValueError, match=message):
        ride.run(BENCHMARK, 1.0, **arguments)


def test_run_that_breaks_down_after_a_wheel_lifted_still_ends_with_that_event(monkeypatch):
    simulate = ride.simulate
    calls = []

    def broken(*given, **settings):
        calls.append(1)
        if len(calls) > 1:
            return simulate(*given, **settings)
        raise IntegrationError("no solution", time=9.0, solution=simulate(*given, **settings))

    monkeypatch.setattr(ride, "simulate", broken)
    assert ride.run(BENCHMARK, 10.0, speed=2.0, lean_rate=0.05).event.name == "front wheel unloaded"
    calls.clear()
    with pytest.raises(IntegrationError) as caught:
        ride.run(BENCHMARK, 1.0, speed=5.0)
    assert caught.value.solution.t[-1] == 1.0


def test_table_has_a_column_with_a_unit_for_everything(tmp_path):
    found = ride.run(replace(BENCHMARK, name="b"), 0.5, speed=5.0, lean_rate=0.1, output=6)
    path = found.to_csv(tmp_path / "ride.csv")
    frame = found.to_dataframe()
    assert [frame.index.name, *frame.columns] == path.read_text().splitlines()[0].split(",")
    assert np.array_equal(frame["steer [rad]"], found.steer) and np.array_equal(frame.index, found.t)
    assert found.to_csv(tmp_path / "ride.v2").name == "ride.v2.csv"
    header, *rows = path.read_text(encoding="utf-8").splitlines()
    values = np.array([row.split(",") for row in rows], dtype=float)
    assert len(rows) == 6 and all(name.endswith("]") for name in header.split(","))
    assert np.array_equal(values[:, header.split(",").index("lean [rad]")], found.lean)


@pytest.mark.slow
def test_command_writes_what_it_says(tmp_path):
    answer = CliRunner().invoke(main, ["bicycle", "ride", "--manoeuvre", "slow", "--out", str(tmp_path)])
    assert answer.exit_code == 0, answer.output
    assert "front wheel unloaded at t = 1.757" in answer.output
    files = {path.suffix for path in tmp_path.glob("Meijaard2007_slow*")}
    assert files == {".npz", ".csv", ".png", ".svg"}
    for name in MANOEUVRES:
        assert name in CliRunner().invoke(main, ["bicycle", "ride", "--list"]).output


@pytest.mark.slow
def test_a_ride_of_bodies_that_cannot_exist_is_written_as_far_as_it_can_be(tmp_path):
    """It had been computed, then refused by the .npz file, and all was lost."""
    options = ["Browser", "--unphysical", "--t-end", "0.2", "--out", str(tmp_path)]
    answer = CliRunner().invoke(main, ["bicycle", "ride", *options])
    assert answer.exit_code == 0 and "no .npz file" in answer.output
    assert {path.suffix for path in tmp_path.iterdir()} == {".csv", ".png", ".svg"}


@pytest.mark.slow
def test_rides_that_differ_have_files_of_their_own(tmp_path):
    common = ["bicycle", "ride", "--manoeuvre", "pulse", "--t-end", "0.1", "--out", str(tmp_path)]
    for more in ([], ["--speed", "4.25"], ["--speed", "5"], ["--fallen", "30", "--held-down"], ["--fallen", "60"]):
        assert CliRunner().invoke(main, common + more).exit_code == 0
    wet = ["bicycle", "ride", "--manoeuvre", "wet", "--t-end", "0.1", "--out", str(tmp_path)]
    for more in ([], ["--tyre", "mu=0.5"]):
        assert CliRunner().invoke(main, wet + more).exit_code == 0
    stems = ("pulse_t-end0.1", "pulse_speed4.25_t-end0.1", "pulse_t-end0.1_fallen30_held-down")
    stems += ("wet_t-end0.1_tyres", "wet_t-end0.1_tyres_mu0.5")
    assert {path.name for path in tmp_path.glob("*.csv")} == {f"Meijaard2007_{stem}.csv" for stem in stems}


def test_view_goes_along_with_the_frame():
    page = ride.view(ride.run(BENCHMARK, 0.2, speed=5.0, output=3)).html
    assert '"followed":1,' in page and re.search(r'"name":"body names"[^}]*"shown":false', page)


def test_help_says_the_usual_tilt():
    assert "[default: 60]" in CliRunner().invoke(main, ["bicycle", "ride", "--help"]).output


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--speed", "0"], "a manoeuvre needs a bicycle that rolls"),
        (["Nobody"], "there is no bicycle 'Nobody'"),
        (["--fallen", "95"], "give a tilt below pi/2"),
        (["--t-end", "-1"], "--t-end: -1.0 is not positive"),
        (["--t-end", "nan"], "--t-end: not finite"),
    ],
)
def test_command_refuses_in_one_line(options, message, tmp_path):
    answer = CliRunner().invoke(main, ["bicycle", "ride", *options, "--out", str(tmp_path)])
    assert answer.exit_code == 2 and message in answer.output and len(answer.output.splitlines()) == 1


def test_every_manoeuvre_has_its_own_numbers():
    assert json.dumps({name: m.title for name, m in MANOEUVRES.items()}).count("IFToMM") == 3
    known = library()["iftomm_uncontrolled_bicycle"]["manoeuvres"]
    for name, numbers in known.items():
        assert MANOEUVRES[name].speed == numbers["v0"]
        assert MANOEUVRES[name].start == {"lean_rate": numbers["roll_rate0"]}


def test_a_rider_pedals_up_to_the_speed_that_the_air_allows():
    """m v' = M/r - rho c_d A v^2/2 in the mean: v = V tanh(t F/(m V) + ...); strokes of the pedals hardly show."""
    found = ride.run(BENCHMARK, **MANOEUVRES["pedal"].arguments, output=6001)
    p, force = BENCHMARK, 6.0 / BENCHMARK.rR
    mass, limit = p.mass + p.IRyy / p.rR**2 + p.IFyy / p.rF**2, np.sqrt(2.0 * force / (1.225 * 0.6))
    known = limit * np.tanh(np.arctanh(4.5 / limit) + found.t * force / (mass * limit))
    assert np.abs(found.advance - known).max() < 2.1 * 4.0 / p.rR / mass / (2.0 * np.pi * 2.4)  # 1 - cos of a stroke
    assert found.advance == pytest.approx(found.rolling("front"), rel=1e-9)
    assert np.degrees(np.abs(found.lean).max()) < 1e-6 and found.solution.certificate.passed
    assert {force.name for force in found.solution.system.forces} >= {"drag", "drive torque on rear wheel"}
    work = found.solution.energy().work  # of pedals and air, and nothing else changes the energy
    assert found.energy_drift < 1e-9 and work[-1] > 0.0


def test_a_wet_patch_leaves_a_share_of_the_grip_that_is_given():
    """Nothing given is replaced: a twentieth is left of any grip."""
    (rear, front), other = MANOEUVRES["wet"].fittings({"tyres": (TYPICAL | {"mu": 0.6}, TYPICAL)})["tyres"], TYPICAL
    assert [rear["mu"](t) for t in (0.0, 2.0)] == pytest.approx([0.6, 0.03])
    assert [front["mu"](t) for t in (0.8, 2.0)] == pytest.approx([other["mu"], 0.05 * other["mu"]])
    assert rear | other == other and MANOEUVRES["brake"].fittings({})["tyres"] == (TYPICAL, TYPICAL)
    with pytest.raises(ValueError, match="mu = None has no share.*give a number"):
        MANOEUVRES["wet"].fittings({"tyres": TYPICAL | {"mu": None}})


def test_examples():
    result = doctest.testmod(ride)
    assert result.attempted and not result.failed


@pytest.mark.slow
@pytest.mark.parametrize("name", ["M1", "M2", "M3"])
def test_manoeuvres_agree_with_exudyn(name):
    """Limits of ever shorter steps, where 12 s of them let these be known (M1, M2: all 5 s on a quiet machine)."""
    manoeuvre = MANOEUVRES[name]
    system = whipple(BENCHMARK, speed=manoeuvre.speed, **manoeuvre.start)
    seen = cross_check(system, 5.0, state=system.state(), engines=["exudyn"], budget=12.0)
    assert seen.failures == ()
    assert seen.verdict["Exudyn", "acceleration"] == "agrees" and seen.verdict["Exudyn", "mass matrix"] == "agrees"
    assert seen.passed, str(seen.table())
