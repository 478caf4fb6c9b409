"""Every demo reaches its theory, notices when something is wrong, and is found; its theory agrees with validation."""

import json
import sys
import types
from functools import cache
from importlib import metadata
from math import inf, isfinite, nan
from pathlib import Path

import numpy as np
import pytest
from helpers.closed_forms import cardan as shafts
from helpers.closed_forms import rotations
from helpers.demo_checks import small
from matplotlib.colors import to_hex
from scipy.integrate import solve_ivp

import mbsd3d
from mbsd3d import simulate
from mbsd3d.demos.base import Outcome, Row
from mbsd3d.demos.discovery import own_demos
from mbsd3d.demos.floating import dzhanibekov
from mbsd3d.demos.loops import door
from mbsd3d.demos.report import report, table, write
from mbsd3d.demos.shafts import cardan, crank
from mbsd3d.demos.terms import wall
from mbsd3d.demos.tops import heavy_top
from mbsd3d.errors import InputError
from mbsd3d.extend import Quantity, discover, theme
from validation import theory

REFERENCES = Path(__file__).parents[2] / "validation" / "references"
ENGINE = Path(__file__).parents[2] / "engines" / "references" / "engine.json"


@cache
def outcome(name):
    """What a demo gives, computed once."""
    return own_demos()[name].run()


@pytest.mark.parametrize(
    ("name", "quantity", "number"),
    [
        ("cardan", "greatest_over_least", 4 / 3),
        ("cardan", "amplitude_2x", 0.14359),
        ("cardan", "amplitude_4x", 0.01031),
        ("crank", "along_1x_N", 10.966),
        ("crank", "along_2x_N", 4.1111),
        ("crank", "along_4x_N", 0.29497),
        ("crank", "along_6x_N", 0.02382),
        ("crank", "along_1x_without_centripetal_N", 9.870),
        ("dzhanibekov", "flip_interval_s", 6.6212239803),
        ("wall", "crank_1x_N", 9.870),
        ("wall", "hinge_gap_m", 3.14159),
        ("wall", "quaternion_deg", 144.686),
        ("wall", "quaternion_length", 3.2969),
    ],
)
def test_published_digits(name, quantity, number):
    digits = len(f"{number:.10g}".replace("0.", "").replace(".", "").lstrip("0"))
    assert outcome(name).quantities[quantity].computed == pytest.approx(number, rel=10.0 ** (1 - digits))


def defaults(name):
    """Demo, its parameters, and what its theory says of them."""
    demo = own_demos()[name]
    return demo.parameters, demo.expected(demo.parameters)


PUBLISHED_TOP = {"spin": 150.0, "precession": -4.61538, "tilt_deg": 90.0, "t": 2.0}


def test_the_published_top_runs_as_published():
    assert own_demos()["heavy_top"].run(**PUBLISHED_TOP).passed


def test_theory_of_the_top_agrees_with_validation():
    case = json.loads((REFERENCES / "heavy_top_fast.json").read_text())["reference"]["values"][-1]
    p = defaults("heavy_top")[0] | PUBLISHED_TOP
    known = own_demos()["heavy_top"].expected(p)
    assert known["fall_s"] == pytest.approx(0.37260347381, rel=1e-11)  # published digits
    # own equations at 3e-14 a step beside a Taylor series of 80 bits; the top passes the lowest point three times
    assert [known[f"{axis}_m"] for axis in "xyz"] == pytest.approx([case[f"com_{axis}"] for axis in "xyz"], abs=1e-11)
    a, c, weight = p["It"] + p["m"] * p["l"] ** 2, p["I3"], p["m"] * heavy_top.G * p["l"]
    rates = theory.steady_precession(a, c, p["spin"], weight, np.radians(p["steady_tilt_deg"]))
    found = known["slow_precession_rad_s"], known["fast_precession_rad_s"]
    assert found == pytest.approx(rates, rel=1e-13)
    t = np.linspace(0.0, 2.0, 41)
    for tilt in (90.0, 65.0):
        curve = rotations.nutation(a, c, p["spin"], weight, np.radians(tilt), 0.0, p["precession"])
        named = {name: p[name] for name in ("m", "l", "It", "I3", "spin", "precession")} | {"tilt_deg": tilt}
        assert heavy_top.path(t, **named)[:, 2] == pytest.approx(curve.height(t), abs=1e-11)


def test_theory_of_the_free_body_agrees_with_validation():
    moments, w = np.array([1.0, 2.0, 3.0]), dzhanibekov.spins(1, 5.0, 1e-3)
    expected = rotations.flip_interval(moments, w)
    assert dzhanibekov.flip_interval(moments, w) == pytest.approx(expected, rel=1e-13)
    other = np.array([1.0, 2.9, 3.0])  # nearer to the greatest: least and greatest change roles
    assert dzhanibekov.flip_interval(other, w) == pytest.approx(
        integrated(other, w), rel=1e-7
    )  # 1e-13 grows 1e4-fold a flip


def integrated(moments, w):
    """Interval of the flips by Euler's equations."""

    def rate(_, w):
        return np.cross(moments * w, w) / moments

    turned = solve_ivp(rate, (0, 40), w, method="DOP853", rtol=1e-13, atol=1e-15, events=lambda _, w: w[1])
    return np.diff(turned.t_events[0]).mean()


def test_theory_of_the_cross_agrees_with_validation():
    angle, bend = np.linspace(0.0, 2 * np.pi, 37), np.radians(30.0)
    quarter = np.pi / 2  # there the angle counts from the other yoke
    rates = theory.cardan_rate(angle + quarter, bend), theory.cardan_rate(angle, bend)
    assert any(np.allclose(cardan.ratio(angle, bend), rate, rtol=1e-13, atol=0) for rate in rates)
    assert cardan.harmonics(bend) == pytest.approx(shafts.cardan_harmonics(bend, 3), rel=1e-13)


def test_theory_of_the_door_agrees_with_the_case():
    case, (p, _) = json.loads((REFERENCES / "door_two_hinges.json").read_text())["reference"], defaults("door")
    named = {name: p[name] for name in ("m", "width", "thickness", "lean_deg", "start_deg")}
    for value in case["values"]:
        angle, _ = door.swing([value["t"]], **named)
        assert angle[0] - np.radians(p["start_deg"]) == pytest.approx(value["angle"], abs=1e-12)
    forces = door.swing([0.0, 2.0], **named)[1]
    assert forces[0] == pytest.approx(case["total_hinge_force_on_door_t0"], abs=1e-10)
    assert forces[1] == pytest.approx(case["total_hinge_force_t2"], abs=1e-10)


def test_theory_of_the_crank_agrees_with_the_engine_data():
    known = json.loads(ENGINE.read_text())["single_cylinder_closed_form_N"]
    _, found = defaults("crank")
    names = ("1x_true", "2x", "4x", "6x")
    assert [found[f"along_{k}x_N"] for k in crank.ORDERS] == pytest.approx([abs(known[k]) for k in names], rel=1e-12)
    assert found["along_1x_without_centripetal_N"] == pytest.approx(known["1x_article"], rel=1e-12)
    assert found["across_1x_N"] == pytest.approx(known["perp_1x"], rel=1e-12)


def test_theory_of_the_wall_agrees_with_validation():
    turns = np.linspace(0.0, 1.0, 11)
    assert np.radians(wall.ghost(turns)) == pytest.approx(rotations.ghost_angle(turns), rel=1e-14)
    ghost = rotations.ghost_quaternion(np.linspace(0.0, 1.0, wall.STEP_COUNT + 1), (0.0, 0.0, 2 * np.pi))
    assert wall.quaternions(h_dot=False) == pytest.approx(ghost, abs=1e-12)
    assert np.linalg.norm(wall.quaternions(h_dot=True), axis=1) == pytest.approx(1.0, abs=1e-9)


def test_each_switch_fails_a_check_of_the_certificate():
    tops = {name: simulate(wall.top(), 2.0, output=201, **changes) for name, changes in wall.RUNS.items()}
    assert tops["all terms"].certificate.passed
    failing = {name: run.certificate.failures for name, run in tops.items()}
    for name in (*wall.TERMS.values(), "no stabilisation"):
        assert failing[name]
    assert not failing["Baumgarte"]  # all terms are there, and its gaps are what the integration errs
    text = " ".join(failing["no w x I w"])
    assert "angular momentum" in text and "energy" not in text  # the energy cannot see it


def test_a_row_that_is_not_a_number_fails():
    assert Row("x", nan, 1.0, 1e3).error == inf and not Row("x", nan, 1.0, 1e3).passed
    assert Row("count", 5, 5, 0).passed


@pytest.mark.parametrize("number", [nan, 7.0, -inf])
def test_only_infinite_meets_infinite(number):
    """The tolerance of an infinite theory was infinite, and any number passed."""
    limit = Quantity("speed", "m/s").tolerance(inf)
    assert isfinite(limit) and Row("speed", inf, inf, limit).passed and Row("speed", inf, inf, limit).error == 0.0
    assert not Row("speed", number, inf, limit).passed and not Row("speed", inf, number, inf).passed


def small_outcome():
    """An outcome with one row that fails."""
    rows = Row("length", 1.0, 1.0, 1e-9, "m"), Row("ratio", 2.0, 1.0, 1e-9)
    return Outcome(rows, tuple, {}, lambda: ("a note",))


def test_the_table_shows_units_errors_and_failures():
    lines = table(small_outcome().rows).splitlines()
    assert [cell.strip() for cell in lines[0].split("|")] == ["quantity", "computed", "theory", "error"]
    assert "length [m]" in lines[2] and "FAIL" not in lines[2]
    assert "ratio " in lines[3] and lines[3].endswith("FAIL, limit 1e-09")
    assert table([Row("shift", -0.0, 1.0 / 3.0, 1e-9)], beyond="differs").splitlines()[2].split(" | ")[1:] == [
        "       0", "0.333333", "3.3e-01  differs",
    ]  # fmt: skip
    assert len({line.index("|") for line in lines if "|" in line}) == 1


def test_the_report_holds_why_source_and_notes():
    text = report(small("x"), small_outcome())
    for piece in ("x: a title", "why       Because.", "source    a book", "a note"):
        assert piece in text


def test_the_files_of_a_demo_can_be_read_back(tmp_path):
    demo = own_demos()["cardan"]
    files = write(demo, outcome("cardan"), tmp_path)
    names = {f"cardan{suffix}" for suffix in (".png", ".svg", ".npz", ".csv", ".html")}
    assert {path.name for path in files} == names | {"cardan_2.npz", "cardan_2.csv", "cardan_double.html"}
    without = write(demo, demo.run(), tmp_path, pages=False)
    assert {path.name for path in files} - {path.name for path in without} == {"cardan.html", "cardan_double.html"}
    again = mbsd3d.load(tmp_path / "cardan.npz")
    assert np.array_equal(again.omega("driven"), outcome("cardan").solutions["cardan"].omega("driven"))


@pytest.fixture
def plugins(monkeypatch):
    """A function that sets the entry points of mbsd3d.demos to those in the module ``plugin_demos``."""
    module = types.ModuleType("plugin_demos", "Of other packages.")
    module.good, module.taken, module.wrong = small("pendulum"), small("cardan"), "a text"
    monkeypatch.setitem(sys.modules, "plugin_demos", module)

    def install(*values):
        entries = [metadata.EntryPoint(value.partition(":")[2] or value, value, "mbsd3d.demos") for value in values]
        monkeypatch.setattr(metadata, "entry_points", lambda group: entries if group == "mbsd3d.demos" else [])

    return install


def test_what_is_drawn_over_a_parameter_alone_has_no_figure_without_a_term(tmp_path):
    demo = own_demos()["crossed_gears"]
    found = demo.run("helix")
    files = write(demo, found, tmp_path, pages=False, without="helix")
    assert {path.suffix for path in files} == {".npz", ".csv"}
    with pytest.raises(InputError, match="'Crossed screws as gears' has nothing to draw; give curves"):
        found.figure  # noqa: B018


def test_demos_of_other_packages_join(plugins):
    plugins("plugin_demos:good")
    demos = discover()
    assert list(demos) == [*own_demos(), "pendulum"] and demos.broken == {}


def test_broken_demos_are_named_and_not_fatal(plugins):
    plugins("plugin_demos:wrong", "plugin_demos:missing", "no_such_package", "plugin_demos:taken", "plugin_demos:good")
    demos = discover()
    assert list(demos) == [*own_demos(), "pendulum"]
    assert "gives a str, not a Demo" in demos.broken["wrong"]
    assert "AttributeError" in demos.broken["missing"]
    assert "ModuleNotFoundError: No module named 'no_such_package'" in demos.broken["no_such_package"]
    assert "already named 'cardan'" in demos.broken["taken"]
    assert all("\n" not in reason for reason in demos.broken.values())


@pytest.mark.parametrize(
    ("name", "changes", "message"),
    [
        ("jet_pitch_yaw", {"Omega": 1e9}, "Omega = 1000000000.0 is a factor of 1000 or more away from 130"),
        ("jet_pitch_yaw", {"M": 1e-9}, "M = 1e-09 is a factor of 1000"),
        ("cv_joint", {"bend_deg": 1e-13}, "bend_deg = 1e-13 is a factor of 1e.12 or more away from 20"),
        ("dual_spin", {"I": [1e9, 1e9, 1e9]}, "I = .* is 1000 times .* or more"),
        ("gyrocompass", {"spin": 0}, "demo 'gyrocompass' with spin = 0.* does not run: its equations have no"),
        ("jet_pitch_yaw", {"t": 0}, "'jet_pitch_yaw' with t = 0.0: .* is not after its start; give a later time"),
        ("gyrocompass", {"A": 0.004}, "demo 'gyrocompass' with A = 0.004: body 'wheel': inertia has the principal"),
        ("gyrocompass", {"Omega_e": -0.05}, "with Omega_e = -0.05: theory has no time_to_north_s"),
        ("helicopter_90", {"Omega": -40}, "demo 'helicopter_90' with Omega = -40.0: give Omega > 0 and c > 0: "),
        ("explorer_flat_spin", {"j": 0}, "j = 0: give none below"),
        ("gyrocompass", {"psi0_deg": 180}, "due south it does not know which way to turn"),
        ("spinning_egg", {"b": 0.08}, "demo 'spinning_egg' with b = 0.08: an egg is longer than it is broad"),
        ("spinning_egg", {"t": 0.2}, "after t = 0.2 s: give a greater t or mu, and a spin near 160 rad/s"),
        ("tippe_top", {"c": -0.2}, "c = -0.2 N s/m: rubbing takes energy away; give c >= 0"),
        ("bennett", {"a": -0.2}, "a = -0.2; give a length > 0"),
        ("fishhook", {"track": 3.75}, "this car does not roll back by itself; give less damping or track"),
        ("dzhanibekov", {"I": [1, 2.5, 3], "off": 0.05}, "I lies on the separatrix, .* give another middle moment"),
        ("dzhanibekov", {"I": [2, 3, 1.5 + 4.25**0.5]}, "I lies on the separatrix"),
        ("slide_to_roll", {"spin": 49.999}, "the ball rolls from the start: v and r spin differ by 0.0001 m/s"),
    ],
)  # fmt: skip
def test_what_no_demo_can_do_is_refused_in_one_sentence(name, changes, message):
    with pytest.raises(InputError, match=message) as caught:
        own_demos()[name].run(**changes)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("ball_holonomy", {"rho": 1e-6}), ("ball_on_turntable", {"Omega": 1e-6}), ("cardan_couple", {"bend_deg": 1e-6}),
        ("cv_joint", {"bend_deg": 1e-6}), ("falling_cat", {"bend_deg": 1e-3}), ("foucault", {"Omega_e": 1e-9}),
        ("motorcycle_crank_lean", {"Jc": 1e-9}), ("non_commuting", {"b_deg": 1e-9}),
        ("swash_plate", {"tilt_deg": 1e-9}),
    ],
)  # fmt: skip
def test_what_an_ablation_takes_away_may_be_as_small_as_one_likes(name, changes):
    assert own_demos()[name].run(**changes).passed


@pytest.mark.parametrize(("a", "b"), [(120.0, 120.0), (150.0, 100.0), (80.0, 200.0), (180.0, 180.0), (-70.0, 40.0)])
def test_turns_whose_products_are_more_than_half_a_turn_apart(a, b):
    found = own_demos()["non_commuting"].run(a_deg=a, b_deg=b)
    half = np.radians([a, b]) / 2
    wanted = np.degrees(2 * np.arccos(1 - 2 * np.prod(np.sin(half) ** 2)))
    assert found.passed and found.quantities["angle_between_deg"].computed == pytest.approx(wanted, abs=2e-6)


@pytest.mark.parametrize("changes", [{"t": 1.0}, {"w": 0.2}, {"t": 3.0, "c": 0.05}])
def test_the_satellite_is_watched_until_it_is_calm_however_long_the_run_that_is_shown(changes):
    assert own_demos()["explorer_flat_spin"].run(**changes).passed


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        pytest.param("rattleback", {"c": 0.06}, marks=pytest.mark.slow), ("gyrocompass", {"psi0_deg": -60.0}),
        ("slide_to_roll", {"mu": 0.9}), ("jet_pitch_yaw", {"t": 60.0}), ("step_steer", {"v": 87.0}),
        ("parking", {"steer_deg": 0.03}), ("parking", {"way": 0.01}), ("slide_to_roll", {"spin": 45.0}),
        ("slide_to_roll", {"spin": 49.9}), ("slide_to_roll", {"r": 0.013, "spin": 30.0}), ("slide_to_roll", {"mu": 0}),
        ("dzhanibekov", {"I": [1, 2.48, 3], "off": 0.05}), ("helicopter_90", {"e": 4.9, "c": 30.0}),
        pytest.param("helicopter_90", {"k": 5e9}, marks=pytest.mark.slow),
        ("dual_spin", {"w": -0.5, "Omega": -100.0}), ("dual_spin", {"Omega": 150.0}),
    ],
)  # fmt: skip
def test_demos_far_from_their_own_parameters_meet_their_theory(name, changes):
    assert own_demos()[name].run(**changes).passed


@pytest.mark.parametrize(("A", "C", "w3", "rate"), [(10, 2, 5, -4.0), (12, 4, -6, 4.0), (8, 12, 6, 3.0)])
def test_a_long_body_has_its_body_cone_the_other_way_round(A, C, w3, rate):
    row = own_demos()["satellite_nutation"].run(A=A, C=C, w3=w3).quantities["body_cone_rate_rad_s"]
    assert row.passed and row.computed == pytest.approx(rate, abs=1e-12)


@pytest.mark.parametrize(("Omega", "nutation"), [(100.0, 0.5), (99.0, 0.494679955024), (105.0, 0.526549580930)])
def test_a_wobble_as_fast_as_the_turn_is_not_taken_for_it(Omega, nutation):
    """sqrt((h + 10.1 w)(h - 9.9 w) / (30.1 50.1)) with h = 0.2 Omega, w = 0.5: at 100 rad/s it is w itself."""
    row = own_demos()["dual_spin"].run(Omega=Omega).quantities["nutation_wheel_on_rad_s"]
    assert row.passed and row.computed == pytest.approx(nutation, rel=1e-11)


@pytest.mark.parametrize(
    ("M", "side"), [pytest.param(76e3, 1.84099466239, marks=pytest.mark.slow), (150e3, -1.73064830065)]
)
def test_a_nose_that_passes_straight_up_stays_beside_its_plane(M, side):
    """Its heading turned by half a turn there, 175.6 degrees; the angle to the plane of the start does not jump."""
    found = own_demos()["jet_pitch_yaw"].run(I=(13e3, 76e3, 86e3), J=4.0, Omega=1000.0, M=M)
    run, row = found.solutions["jet_pitch_yaw"], found.quantities["nose_sideways_deg"]
    assert run.rotation("aircraft")[-1][0, 0] < 0.0  # over the top: the nose points back
    assert row.passed and row.computed == pytest.approx(side, rel=1e-9)
    assert np.abs(np.diff(found.panels[0].drawn.y)).max() < 0.4  # deg a hundredth of a second, at 0.6 rad/s


@pytest.mark.parametrize("changes", [{"steer": 0.05}, {"step": 0.05}, {"step": 0}, {"steer": -0.03, "step": 0.02}])
def test_the_single_track_is_ridden_with_the_steer_that_is_given(changes):
    """Numbers are those of the motion straight ahead; the ride ends on the circle of its steer and lost speed."""
    found = own_demos()["single_track"].run(**changes)
    run, given = found.solutions["single_track"], {"steer": 0.0, "step": 0.01} | changes
    assert found.passed and run.angle("kingpin")[-1] == pytest.approx(given["step"], abs=1e-12)
    gain, steer = found.quantities["yaw_gain_1_s"].theory, given["steer"] + given["step"]
    # the locked wheels' drag and the cosine of the steer change the speed, and so the gain, by its square
    assert run.omega("car")[-1, 2] == pytest.approx(gain * steer, rel=0.05, abs=1e-9)


def test_a_car_that_turns_many_times_while_parking_is_turned_so_far():
    row = own_demos()["parking"].run(L=0.5, way=20.0, steer_deg=70.0, beats=1).quantities["turned_deg"]
    assert row.passed and row.computed > 20 * 360


def test_a_bicycle_without_gyroscopes_rides_itself_at_no_speed():
    found = own_demos().get("no_hands") or discover().find("no_hands")
    rows = found.run(spin=0.0).quantities
    assert all(row.passed for row in rows.values())
    assert rows["weave_speed_m_s"].computed == rows["capsize_speed_m_s"].computed == inf


@pytest.mark.parametrize(
    ("name", "changes"), [("skate_on_slope", {"blade": 0}), ("cv_joint", {"cross": 1, "bend_deg": 33.0, "torque": 7.0})]
)
def test_dots_of_theory_are_those_of_the_parameters(name, changes):
    """What the ablation changes, given as parameters: the figure shows the theory that the table has."""
    demo = discover().find(name)
    for curve in demo.computed({**demo.parameters, **changes}, {}).curves:
        assert curve.theory[0] == pytest.approx(curve.x, rel=1e-9, abs=1e-9)
        assert curve.theory[1] == pytest.approx(curve.y, rel=1e-9, abs=1e-9)


def test_a_switch_that_leaves_a_cam_no_speed_to_float_says_infinite():
    assert own_demos()["roller_cam"].run("gamma").quantities["float_rad_s"].computed == np.inf


def test_the_top_meets_its_theory_from_any_tilt():
    for tilt in (40.0, 120.0):
        assert own_demos()["heavy_top"].run(tilt_deg=tilt).passed
    with pytest.raises(InputError, match="does not lie between 0 and 180"):
        own_demos()["heavy_top"].run(tilt_deg=0)


def test_beats_tell_of_the_first_parameters_alone():
    demo = own_demos()["ball_holonomy"]
    assert [says for _, says in demo.run().views["ball_holonomy"].options["captions"]] == [x.says for x in demo.beats]
    others = [demo.run(rho=0.2), demo.run(demo.ablation.term)]
    assert all("captions" not in show.options for other in others for show in other.views.values())


def test_curves_of_the_handles_have_their_colours():
    """In the scene a body has the palette's colour of its place."""
    axes = outcome("dzhanibekov").figure.axes[-1]
    found = {line.get_label(): to_hex(line.get_color()) for line in axes.lines}
    for place, name in enumerate(dzhanibekov.NAMES):
        assert found[name] == theme(False).colour(place).lower()


def test_the_path_of_the_top_is_that_of_its_tip_at_any_tilt():
    for changes in ({}, {"tilt_deg": 70.0, "l": 0.9}):
        run, options = own_demos()["heavy_top"].run(**changes).views["heavy_top"]
        _, tip = options["traces"][0]
        assert tip == pytest.approx(1.25 * run.com("top")[0], abs=1e-12)  # the stem ends a quarter beyond the disc
