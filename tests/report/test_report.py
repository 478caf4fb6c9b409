"""The report of a run: it says what the solution says, it needs nothing from outside, and it breaks on nothing."""

import os
import re
import subprocess
import sys
from html.parser import HTMLParser

import numpy as np
import pytest
from helpers.double_pendulum import UPPER_ARM, WHEEL, pendulum
from helpers.printed_numbers import number
from matplotlib.backends.backend_agg import FigureCanvasAgg

from mbsd3d import (
    GROUND,
    RK4,
    AngleDriver,
    Body,
    IntegrationError,
    Kinematic,
    Prismatic,
    Ramp,
    Revolute,
    SpringDamper,
    System,
    accelerations,
    load,
    measures,
    simulate,
)
from mbsd3d.extend import readable
from mbsd3d.report import exhibits, facts

HOSTILE = (
    "<script>alert('1')</script>",
    "quote \" and ' & <b>",
    "Bügel-Größe ⌀ 🚲",
    "--> ]]> {{ 7 * 7 }} {% x %}",
    "_$x^2$",
)
VOID = {"meta", "img", "br", "link"}


class Page(HTMLParser):
    """Tags, the cells of every table, and whether every tag is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open, self.tags, self.rows, self.attributes, self.ids, self.text = [], [], [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        self.ids += [value for name, value in attrs if name == "id"]
        if tag not in VOID:
            self.open.append(tag)
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_startendtag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        self.ids += [value for name, value in attrs if name == "id"]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] in ("td", "th"):
            self.rows[-1][-1] += data
        if self.open and self.open[-1] not in ("style",):
            self.text.append(" ".join(data.split()))

    def row(self, *start: str) -> list[str]:
        """The first row that starts so."""
        return next(row for row in self.rows if tuple(row[: len(start)]) == start)


@pytest.fixture(scope="module")
def solution():
    """0.3 s of the pendulum."""
    return simulate(pendulum(), 0.3, output=61)


@pytest.fixture(scope="module")
def page(solution):
    """Its report."""
    return Page(solution.report().html)


def door(**changes):
    """A door on two hinges, one too many."""
    leaf = Body("leaf", 20.0, (8.0, 9.0, 1.0), position=(0.45, 0.0, 1.0), omega=(0, 0, 1))
    hinges = [
        Revolute(GROUND, leaf, at=(0, 0, z), axis=(0, 0, 1), name=name) for z, name in ((0.2, "low"), (1.8, "up"))
    ]
    return simulate(System([leaf], hinges), 0.2, **changes)


def test_the_page_needs_nothing_from_outside(solution, page):
    text = re.sub(r'xmlns(:\w+)?="[^"]*"', "", solution.report().html)
    assert not re.search(r"https?://|//\w+\.\w+/|@import|<script|<link|<iframe", text)
    for name, value in page.attributes:
        if name in ("src", "href", "xlink:href"):
            assert value.startswith(("data:", "#"))
    assert not page.open and len(page.ids) == len(set(page.ids))
    assert page.tags.count("svg") == 4 and page.tags.count("img") == 2 and page.tags.count("h1") == 1


def test_every_check_stands_there_with_error_limit_and_verdict(solution, page):
    for check in solution.certificate.checks:
        name, _, error, limit, _, verdict = page.row(check.name)
        assert number(error) == pytest.approx(check.error, rel=0.05, abs=1e-300)  # two digits
        assert f"{number(limit):.0e}" == f"{check.limit:.0e}" and "10" in limit  # as the certificate has it
        assert verdict == "✓ passed"
    assert any("Passed." in text for text in page.text)


def test_tables_hold_the_numbers_of_the_solution(solution, page):
    wheel = solution.system.part(WHEEL)
    row = page.row(WHEEL)
    assert number(row[1]) == wheel.mass
    assert number(row[-1]) == pytest.approx(np.linalg.norm(solution.omega(WHEEL), axis=1).max(), rel=1e-3)
    elbow = page.row("elbow", "Universal")
    reaction = solution.reaction("elbow")
    for values, text, when in ((reaction.force, *elbow[5:7]), (reaction.moment, *elbow[7:9])):
        size = np.linalg.norm(values, axis=1)
        assert number(text) == pytest.approx(size.max(), rel=1e-3)
        assert number(when) == pytest.approx(solution.t[size.argmax()], rel=1e-3)
    assert elbow[2:5] == ["upper arm – lower arm", "determined", "0 of 4"]
    motor = page.row("motor", "SpeedDriver")
    assert motor[2].endswith(" N m")
    assert number(motor[2].removesuffix(" N m")) == pytest.approx(np.abs(solution.effort("motor")).max(), rel=1e-3)
    assert number(motor[4]) == pytest.approx(solution.work("motor")[-1], rel=1e-3)
    spring = page.row("SpringDamper 1")
    stored = solution.arrays["potential"][:, 0]
    assert [number(text) for text in spring[3:5]] == pytest.approx([stored.min(), stored.max()], rel=1e-3)
    energy = solution.energy()
    gained, given = energy.total[-1] - energy.total[0], energy.work[-1]
    words = dict(facts.drift_facts(solution))["energy"].replace("−", "-").split()  # changed by x J, ... did y J; ...
    assert [float(words[2]), float(words[words.index("did") + 1])] == pytest.approx([gained, given], rel=1e-2)
    assert number(spring[5]) == pytest.approx(solution.work("SpringDamper 1")[-1], rel=1e-3)
    assert page.row("shoulder", "Spherical")[7:] == ["0", "–"]  # a ball carries no moment, whatever rounding leaves


def test_energies_of_a_spring_are_the_extremes_of_the_run():
    """It starts stretched by 0.2 m, passes its free length, and swings out as far on the other side."""
    bob = Body("bob", 1.0, (0.1, 0.1, 0.1), position=(0.7, 0, 0))
    rail = Prismatic(GROUND, bob, at=(0, 0, 0), axis=(1, 0, 0))
    spring = SpringDamper(GROUND, bob, at_a=(0, 0, 0), at_b=(0.7, 0, 0), stiffness=100.0, length=0.5)
    run = simulate(System([bob], [rail], [spring]), 0.5, output=501)
    (row,) = facts.force_table(run, run).rows
    assert number(row[3]) < 1e-3 and number(row[4]) == pytest.approx(0.5 * 100.0 * 0.2**2)  # passes within a sample


def test_redundant_joints_are_named_as_indeterminate():
    page = Page(door().report(curves=[], dark=False).html)
    assert page.row("low")[3:5] == ["indeterminate", "5 of 5"]
    assert any("10, of rank 5: 5 redundant" in text for text in page.text)
    assert any("shares of least norm" in text for text in page.text) and "remedy" in page.text


def test_a_failed_certificate_is_loud():
    top = Body("top", 1.0, (1.0, 2.0, 3.0), omega=(0.1, 5.0, 0.3), velocity=(0, 0, 0))
    run = simulate(System([top], gravity=(0, 0, 0)), 1.0, gyroscopic=False)
    report = run.report(dark=True)
    page = Page(report.html)
    assert not report.passed and "✗ FAILED." in page.text and repr(report).startswith("<report 'top': FAILED")
    assert all(readable(sentence) in page.text for sentence in run.certificate.failures)
    assert page.row("Newton-Euler")[-1] == "✗ FAILED" and page.row("energy balance")[-1] == "✓ passed"
    assert any(text.startswith("Switched off: the gyroscopic term") for text in page.text)


@pytest.mark.parametrize(
    ("switch", "text"),
    [("centripetal", "the centripetal term"), ("gamma", "of the acceleration rows")],
)
def test_switches_that_are_off_are_said(switch, text):
    assert text in door(output=3, **{switch: False}).report(curves=[], dark=False).html


@pytest.mark.slow
def test_what_was_not_an_ordinary_run_is_said():
    system = pendulum()
    stopped = simulate(system, 0.3, stop_when=measures.angle(system.joints[2]) > 0.1)
    assert (
        f"The run was stopped by {stopped.record.stopped_by}.".replace(">", "&gt;")
        in stopped.report(curves=[], dark=False).html
    )
    once = accelerations(system).report(dark=False)
    assert "There is a single sample" in once.html and "<svg" not in once.html and Page(once.html).row("elbow")
    arm = Body("arm", 1.0, (0.1, 0.2, 0.3), position=(0.5, 0.1, 0))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 1), name="hinge")
    driven = System([arm], [hinge, AngleDriver(hinge, Ramp(2.0), name="motor")])
    text = simulate(driven, 1.0, method=Kinematic(), output=11).report(dark=False).html
    assert "The drivers determine the motion" in text and "the drivers determine the motion" in text
    assert "stabilisation “none”" in door(stabilisation="none").report(curves=[], dark=False).html
    fixed = simulate(system, 0.01, method=RK4(0.001)).report(curves=[], dark=False).html
    assert "RK4 dt = 0.001" in fixed and "rtol" not in fixed
    assert "<dt>method</dt><dd>Kinematic</dd>" in text


def test_a_run_that_broke_off_is_reported():
    stiff = System([Body("stone", 1.0, (0.1, 0.1, 0.1), velocity=(0, 0, 3.0), omega=(0, 0, 0))])
    part = simulate(stiff, 0.5, output=5)
    error = IntegrationError("the model is stiff", time=0.5, solution=part)
    assert "stone" in error.solution.report().html
    empty = simulate(stiff, 0.5, output=5)
    for name, values in empty.arrays.items():
        empty.arrays[name] = values[:0]
    with pytest.raises(ValueError, match="report: the solution has no samples; run it"):
        empty.report()


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:Glyph .* missing")  # the font has no bicycle: a box is drawn
def test_names_and_titles_cannot_break_the_page():
    bodies = [Body(name, 1.0, (0.1, 0.2, 0.3), position=(k, 0.1, 0)) for k, name in enumerate(HOSTILE)]
    joints = [
        Revolute(GROUND, body, at=(k, 0, 0), axis=(0, 1, 0.2), name=f"hinge of {body.name}")
        for k, body in enumerate(bodies)
    ]
    report = simulate(System(bodies, joints), 0.05, output=5).report(title=f"Träger {HOSTILE[0]}")
    page = Page(report.html)
    assert not page.open and "script" not in page.tags and "b" in page.tags
    assert all(page.row(name) and page.row(f"hinge of {name}", "Revolute") for name in HOSTILE)
    assert f"Träger {HOSTILE[0]}" in page.text
    frame = Page(report._repr_html_())
    assert frame.tags == ["iframe"] and dict(frame.attributes)["srcdoc"] == report.html


@pytest.mark.slow
def test_same_run_same_bytes(tmp_path):
    """In another process, with another order of sets, and although the runs take different times."""
    code = "import sys; from helpers.double_pendulum import pendulum; from mbsd3d import simulate\n"
    code += "simulate(pendulum(), 0.1, output=9).report(sys.argv[1])"
    environment = {"PYTHONPATH": os.pathsep.join(sys.path), "PYTHONHASHSEED": "3"}

    subprocess.run([sys.executable, "-c", code, str(tmp_path / "other")], env={**os.environ, **environment}, check=True)
    simulate(pendulum(), 0.1, output=9).report(tmp_path / "one.html")
    assert (tmp_path / "one.html").read_bytes() == (tmp_path / "other.html").read_bytes()


@pytest.mark.slow
def test_a_run_read_from_a_file_gives_the_same_report(tmp_path):
    run = simulate(pendulum(), 0.1, output=9)
    options = {"curves": ["energy"], "dark": False}
    assert load(run.save(tmp_path / "run")).report(**options).html == run.report(**options).html


def test_a_large_redundant_model_is_thinned_and_says_so(monkeypatch):
    monkeypatch.setattr(facts, "ROW_ANALYSIS_COST_MAX", 1.0)
    run = door(output=7)
    few, sentence = facts.thinned(run)
    assert few.t.size == 1 and sentence == "From one sample in 7, to save time."
    assert f"Reactions and efforts: {sentence}" in run.report(curves=[], dark=False).html


@pytest.mark.slow
def test_paper(solution):
    auto, light, dark = (solution.report(dark=dark, curves=["energy"]).html for dark in (None, False, True))
    assert "@media screen and (prefers-color-scheme: dark) { :root" in auto
    assert "{ :root" not in light and "@media screen { :root" in dark
    assert [text.count("<img") for text in (auto, light, dark)] == [2, 1, 1]
    assert "var(--line0)" in auto and "#0072b2" not in auto.split("</style>")[1].lower()


@pytest.mark.slow
def test_chosen_curves(solution):
    text = solution.report(curves=[("position", UPPER_ARM), "drift"]).html
    assert text.count("<svg") == 2 and 'aria-label="position of upper arm [m] over time"' in text
    assert solution.report(curves=[], dark=False).html.count("<svg") == 0
    with pytest.raises(ValueError, match="curves 'energy' is a single text; give a list"):
        solution.report(curves="energy")
    with pytest.raises(ValueError, match="quantity 'speed' is unknown"):
        solution.report(curves=["speed"])
    with pytest.raises(ValueError, match="report: title 3 is not a text"):
        solution.report(title=3)
    with pytest.raises(ValueError, match="cannot be written"):
        solution.report("/nowhere/at/all.html", curves=[], dark=True)


def chain(count: int) -> System:
    """Links on hinges about axes that are not parallel."""
    bodies = [Body(f"link {k}", 0.1, (1e-4, 2e-4, 2e-4), position=(0.1 * k + 0.05, 0, 0)) for k in range(count)]
    joints = [
        Revolute(
            bodies[k - 1] if k else GROUND, bodies[k], at=(0.1 * k, 0, 0), axis=(0, 1, 0.1 * (k % 3)), name=f"h{k}"
        )
        for k in range(count)
    ]
    return System(bodies, joints)


def test_of_many_joints_the_most_loaded_ones_are_shown():
    run = simulate(chain(43), 0.02, method=RK4(0.01), output=3)
    kept, text = facts.loaded_joints(run)
    load = {joint.name: np.abs(run.arrays["lam"][:, run.compiled.rows[id(joint)]]).max() for joint in run.system.joints}
    assert len(kept) == 40 and "The 40 of 43 joints" in text
    assert [joint.name for joint in kept] == [name for name in load if name in {x.name for x in kept}]  # in order
    assert min(load.pop(joint.name) for joint in kept) >= max(load.values())


def test_labels_of_figures_fit_beside_their_axes(monkeypatch):
    figures = []
    monkeypatch.setattr(exhibits, "inline_svg", lambda figure, prefix: figures.append(figure) or "")
    arm = Body("arm", 1.3, (0.1, 0.2, 0.3), com=(0.2, 0.1, -0.3))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(0.2, 1, 0.3), name="hinge of the lower left arm")
    simulate(System([arm], [hinge]), 0.2, output=9).report(curves=["reaction", ("omega_body", arm), "momentum"])
    for figure in figures:
        FigureCanvasAgg(figure).draw()
        boxes = [axes.yaxis.label.get_window_extent() for axes in figure.axes]
        assert all(upper.y0 > lower.y1 for upper, lower in zip(boxes, boxes[1:], strict=False))
        assert min(box.y0 for box in boxes) > 0.0 and boxes[0].y1 < figure.bbox.height
    assert len(figures) == 3


@pytest.mark.slow
def test_sizes():
    report = simulate(chain(10), 0.5, output=1000).report()
    assert len(report.html.encode()) < 300_000
    page = Page(simulate(chain(300), 0.002, method=RK4(0.001), output=3).report(dark=False).html)
    rows = [row for row in page.rows if row[0].startswith("link ")]
    assert len(rows) == 40 and len([row for row in page.rows if re.match(r"h\d", row[0])]) == 40
    assert any("The first 40 of 300 bodies, and 260 more." in text for text in page.text)
    assert any("The 40 of 300 joints with the largest multipliers" in text for text in page.text)
