"""Every demo reaches its theory, notices when something is wrong, and is found; its theory agrees with validation."""

import importlib
import json
import re
import sys
import types
from functools import cache
from importlib import metadata
from math import inf, nan
from pathlib import Path

import numpy as np
import pytest
from closed_forms import cardan as shafts
from closed_forms import rotations
from matplotlib.figure import Figure

import mbsd3d
from mbsd3d.demos import cardan, crank, door, dzhanibekov, heavy_top, wall
from mbsd3d.demos.base import Demo, Outcome, Row, discover, own_demos
from mbsd3d.demos.report import report, table, write
from validation import theory

NAMES = ["cardan", "crank", "door", "dzhanibekov", "heavy_top", "wall"]
REFERENCES = Path(__file__).parents[2] / "validation" / "references"


@cache
def outcome(name):
    """What a demo gives, computed once."""
    return own_demos()[name].run()


def computed(name, quantity):
    """The computed number of the only row whose quantity starts so."""
    (row,) = [row for row in outcome(name).rows if row.quantity.startswith(quantity)]
    return row.computed


def test_the_demos_are_the_modules_of_the_folder():
    assert list(own_demos()) == NAMES
    for name, demo in own_demos().items():
        assert demo is importlib.import_module(f"mbsd3d.demos.{name}").demo
        assert demo.why.endswith(".") and demo.source and demo.title


@pytest.mark.parametrize("name", NAMES)
def test_every_row_meets_its_theory(name):
    assert [row for row in outcome(name).rows if not row.passed] == []
    assert outcome(name).passed and len(outcome(name).rows) >= 5


@pytest.mark.parametrize("name", NAMES)
def test_the_ablation_is_noticed(name):
    demo = own_demos()[name]
    assert demo.ablation
    ablated = demo.run(**demo.ablation)
    assert any(row.error > 0.0 and row.error >= 100 * row.tolerance for row in ablated.rows)
    assert not ablated.passed


@pytest.mark.parametrize("name", NAMES)
def test_figure_and_runs(name):
    figure, solutions = outcome(name).figure, outcome(name).solutions
    assert isinstance(figure, Figure) and name in solutions
    assert all(run == name or run.startswith(f"{name}_") for run in solutions)
    for axes in figure.axes:
        labels = [axis.get_label_text() for axis in axes._axis_map.values()]
        assert any(labels) and all(re.search(r"\[.+\]", text) for text in labels if text)  # the others name things


@pytest.mark.parametrize("name", NAMES)
def test_every_demo_is_shown_with_shapes_and_curves(name):
    views = outcome(name).views
    assert name in views and all(view == name or view.startswith(f"{name}_") for view in views)
    for solution, options in views.values():
        page = solution.animate(**options)
        assert page.frames > 100 and len(page.html) < 1.2e6  # a client of 0.8 MB, and so many frames
        assert all(body.shape is not None for body in solution.system.bodies)
        assert "curves" in options


@pytest.mark.parametrize(
    ("name", "quantity", "number"),
    [
        ("cardan", "greatest over least", 4 / 3),
        ("cardan", "2x", 0.14359),
        ("cardan", "4x", 0.01031),
        ("crank", "block force along the bore, 1x", 10.966),
        ("crank", "block force along the bore, 2x", 4.1111),
        ("crank", "block force along the bore, 4x", 0.29497),
        ("crank", "block force along the bore, 6x", 0.02382),
        ("crank", "the same force without m w x (w x s)", 9.870),
        ("dzhanibekov", "interval between flips", 6.6212239803),
        ("heavy_top", "time of fall", 0.37260347381),
        ("wall", "no m w x (w x s)", 9.870),
        ("wall", "no -J_dot v", 3.14159),
        ("wall", "no H_dot: angle", 144.686),
        ("wall", "no H_dot: length", 3.2969),
    ],
)
def test_published_digits(name, quantity, number):
    digits = len(f"{number:.10g}".replace("0.", "").replace(".", "").lstrip("0"))
    assert computed(name, quantity) == pytest.approx(number, rel=10.0 ** (1 - digits))


def test_theory_of_the_top_agrees_with_validation():
    case = json.loads((REFERENCES / "heavy_top_fast.json").read_text())["reference"]["values"][-1]
    assert heavy_top.AT_2_S == (case["com_x"], case["com_y"], case["com_z"])
    a, c, weight = heavy_top.ABOUT_PIVOT, heavy_top.AXIAL, heavy_top.WEIGHT_MOMENT
    rates = theory.steady_precession(a, c, heavy_top.SPIN, weight, heavy_top.TILT)
    assert heavy_top.steady_rates(heavy_top.TILT) == pytest.approx(rates, rel=1e-13)
    curve = rotations.nutation(a, c, heavy_top.SPIN, weight, np.pi / 2, 0.0, heavy_top.PRECESSION)
    t = np.linspace(0.0, 2.0, 41)
    assert heavy_top.height(t) == pytest.approx(curve.height(t), abs=1e-12)


def test_theory_of_the_free_body_agrees_with_validation():
    expected = rotations.flip_interval(dzhanibekov.MOMENTS, dzhanibekov.spins(1))
    assert dzhanibekov.flip_interval() == pytest.approx(expected, rel=1e-13)


def test_theory_of_the_cross_agrees_with_validation():
    angle = np.linspace(0.0, 2 * np.pi, 37)
    quarter = np.pi / 2  # there the angle counts from the other yoke
    rates = theory.cardan_rate(angle + quarter, cardan.BEND), theory.cardan_rate(angle, cardan.BEND)
    assert any(np.allclose(cardan.ratio(angle, cardan.BEND), rate, rtol=1e-13) for rate in rates)
    assert cardan.harmonics(cardan.BEND) == pytest.approx(shafts.cardan_harmonics(cardan.BEND, 3), rel=1e-13)


def test_theory_of_the_door_agrees_with_the_case():
    case = json.loads((REFERENCES / "door_two_hinges.json").read_text())["reference"]
    for value in case["values"]:
        angle, rate = door.swing(value["t"])
        assert (angle - door.START, rate) == pytest.approx((value["angle"], value["rate"]), abs=1e-12)
    forces = door.net_force(np.array([0.0, 2.0]))
    assert forces[0] == pytest.approx(case["total_hinge_force_on_door_t0"], abs=1e-10)
    assert forces[1] == pytest.approx(case["total_hinge_force_t2"], abs=1e-10)


def test_theory_of_the_crank_agrees_with_the_engine_data():
    known = json.loads((REFERENCES / "engine.json").read_text())["single_cylinder_closed_form_N"]
    expected = [known["1x_true"], known["2x"], known["4x"], known["6x"]]
    assert crank.harmonics() == pytest.approx(expected, rel=1e-12)
    assert crank.harmonics(centripetal=False)[0] == pytest.approx(known["1x_article"], rel=1e-12)
    assert pytest.approx(known["perp_1x"], rel=1e-12) == crank.ACROSS


def test_theory_of_the_wall_agrees_with_validation():
    turns = np.linspace(0.0, 1.0, 11)
    assert np.radians(wall.ghost_angle(turns)) == pytest.approx(rotations.ghost_angle(turns), rel=1e-14)
    ghost = rotations.ghost_quaternion(np.linspace(0.0, 1.0, wall.STEPS + 1), (0.0, 0.0, wall.TURN))
    assert wall.quaternions(h_dot=False) == pytest.approx(ghost, abs=1e-12)
    assert np.linalg.norm(wall.quaternions(h_dot=True), axis=1) == pytest.approx(1.0, abs=1e-9)


def test_each_switch_fails_a_check_of_the_certificate():
    solutions = outcome("wall").solutions
    assert solutions["wall"].certificate.passed
    failing = {name: run.certificate.failures for name, run in solutions.items()}
    for name in ("gyroscopic", "centripetal", "gamma", "none"):
        assert failing[f"wall_{name}"]
    assert not failing["wall_baumgarte"]  # all terms are there, and its gaps are what the integration errs
    text = " ".join(failing["wall_gyroscopic"])
    assert "angular momentum" in text and "energy" not in text  # the energy cannot see it


def test_a_row_that_is_not_a_number_fails():
    assert Row("x", nan, 1.0, 1e3).error == inf and not Row("x", nan, 1.0, 1e3).passed
    assert Row("x", inf, inf, 1.0).error == inf
    assert Row("count", 5, 5, 0).passed


def small_outcome():
    """An outcome with one row that fails."""
    figure = Figure(layout="constrained")
    figure.subplots().plot([0, 1], [0, 1])
    return Outcome((Row("length", 1.0, 1.0, 1e-9, "m"), Row("ratio", 2.0, 1.0, 1e-9)), figure, {}, ("a note",))


def test_the_table_shows_units_errors_and_failures():
    lines = table(small_outcome().rows).splitlines()
    assert [cell.strip() for cell in lines[0].split("|")] == ["quantity", "computed", "theory", "error"]
    assert "length [m]" in lines[2] and "FAIL" not in lines[2]
    assert "ratio " in lines[3] and lines[3].endswith("FAIL, limit 1e-09")
    assert len({line.index("|") for line in lines if "|" in line}) == 1


def test_the_report_holds_why_source_and_notes():
    demo = Demo("x", "a title", "Because.", "a book", small_outcome)
    text = report(demo, small_outcome())
    for piece in ("x: a title", "why     Because.", "source  a book", "a note"):
        assert piece in text


def test_the_files_of_a_demo_can_be_read_back(tmp_path):
    demo = own_demos()["cardan"]
    files = write(demo, outcome("cardan"), tmp_path)
    names = {f"cardan{suffix}" for suffix in (".png", ".svg", ".npz", ".csv", ".html")}
    assert {path.name for path in files} == names | {f"cardan_double.{kind}" for kind in ("npz", "csv", "html")}
    without = write(demo, demo.run(), tmp_path, pages=False)
    assert {path.name for path in files} - {path.name for path in without} == {"cardan.html", "cardan_double.html"}
    again = mbsd3d.load(tmp_path / "cardan.npz")
    assert np.array_equal(again.omega("driven"), outcome("cardan").solutions["cardan"].omega("driven"))


@pytest.fixture
def plugins(monkeypatch):
    """A function that sets the entry points of mbsd3d.demos to those in the module ``plugin_demos``."""
    module = types.ModuleType("plugin_demos")
    module.good = Demo("pendulum", "of another package", "Why.", "source", small_outcome)
    module.taken = Demo("cardan", "taken", "Why.", "source", small_outcome)
    module.wrong = "a text"
    monkeypatch.setitem(sys.modules, "plugin_demos", module)

    def install(*values):
        entries = [metadata.EntryPoint(value.partition(":")[2] or value, value, "mbsd3d.demos") for value in values]
        monkeypatch.setattr(metadata, "entry_points", lambda group: entries if group == "mbsd3d.demos" else [])

    return install


def test_demos_of_other_packages_join(plugins):
    plugins("plugin_demos:good")
    demos = discover()
    assert list(demos) == [*NAMES, "pendulum"] and demos.broken == {}


def test_broken_demos_are_named_and_not_fatal(plugins):
    plugins("plugin_demos:wrong", "plugin_demos:missing", "no_such_package", "plugin_demos:taken", "plugin_demos:good")
    demos = discover()
    assert list(demos) == [*NAMES, "pendulum"]
    assert "gives a str, not a Demo" in demos.broken["wrong"]
    assert "AttributeError" in demos.broken["missing"]
    assert "ModuleNotFoundError: No module named 'no_such_package'" in demos.broken["no_such_package"]
    assert "already named 'cardan'" in demos.broken["taken"]
    assert all("\n" not in reason for reason in demos.broken.values())
