"""Pages of the engines: there for every layout, offline, with the numbers of the functions, the same bytes twice."""

import html
import re
from dataclasses import replace
from urllib.parse import unquote

import numpy as np
import pytest
from click.testing import CliRunner

from engines.balance import balance, cli, gas, report
from engines.balance.balance import compare
from engines.balance.layouts import Engine, Layout, layout, names
from engines.balance.pages import site as pages
from engines.balance.published import claims, truth
from mbsd3d.extend import digits

HOSTILE = '<i>"my & twin"</i>'


def engines():
    """Inline, V with a plus in its name, and one of a user, with masses of its own and a name that is markup."""
    twin = Layout(HOSTILE, f"{HOSTILE} {{{{ 7 * 7 }}}}", pins=(20, 130), bores=(75, 15), stations=(-0.04, 0.07))
    own = Engine(twin, rpm=900, radius=0.04, rod_length=0.13, crank_mass=1.2, crank_centre=0.01, rod_mass=0.5,
                 rod_fraction=0.3, rod_inertia=1e-3, piston_mass=0.4)  # fmt: skip
    return [Engine("I4"), Engine("V6_60_offset+60"), own]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pages") / "new" / "folder"
    assert pages.write_pages(folder, engines(), progress=False).index == folder / "index.html"
    return folder


def words(path):
    """Text of a page without tags, spaces normal."""
    text = re.sub(r"<style>.*?</style>", "", path.read_text(encoding="utf-8"), flags=re.S)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]*>", " ", text)))


def test_a_page_and_a_view_for_every_engine(folder):
    files = pages.file_names(engines())
    assert files[:2] == ["I4.html", "V6_60_offset+60.html"]
    assert {p.name for p in folder.iterdir()} == {"index.html", "views", *files}
    assert {p.name for p in (folder / "views").iterdir()} == set(files)
    assert len({file.lower() for file in pages.file_names([Engine(name) for name in names()])}) == 24


def test_links_lead_to_files_and_nothing_comes_from_outside(folder):
    for path in folder.glob("*.html"):
        text = path.read_text(encoding="utf-8")
        links = re.findall(r'(?:href|src)="([^"]*)"', text)
        assert links and not re.search(r"https?:|url\(|@import|<script|<link", text)
        for link in links:
            assert (path.parent / unquote(link)).is_file(), (path.name, link)


def test_numbers_of_a_page_are_those_of_the_functions(folder):
    for engine, file in zip(engines(), pages.file_names(engines()), strict=True):
        sheet, text = pages.make_sheet(engine), words(folder / file)
        assert sheet.left
        for h in sheet.left:
            unit = "N" if h.kind == "force" else "N m"
            assert f"{h.order}x {h.kind} {digits(h.axes[0])} {unit}" in text
            assert (
                f"{h.order}x {h.kind} [{unit}] {digits(abs(h.forward), h.axes[0])} {digits(abs(h.backward), h.axes[0])}"
                in text
            )
        for order in (n for n in sheet.orders if sheet.torque(n) > sheet.noise):
            assert f"{order}x torque N m {sheet.torque(order):.6g}" in text
        assert f"largest {digits(sheet.peak)} N m" in text
        for quantity, _ in pages.QUANTITIES:
            sizes = report.amplitudes(sheet.comparison.ways["phasor"])[quantity][1:]
            labels = [digits(x) if x > sheet.noise else "0" for x in sizes]
            assert " ".join(f"{label} {n}x" for n, label in enumerate(labels, start=1)) in text
    assert "2x force 16.44 N" in words(folder / "I4.html")  # the published figure, which is true


def test_the_index_holds_every_harmonic_and_the_whole_truth_table(folder):
    text, sheets = words(folder / "index.html"), [pages.make_sheet(engine) for engine in engines()]
    for sheet in sheets:
        row = text[text.index(sheet.engine.layout.name) :]
        values = [pages.relative(sheet, kind, n) for kind, n in pages.shades(sheets)["columns"]]
        shown = [f"{x:.3f}" for x in values if x >= 0.0095]
        cells = re.findall(r"\d+\.\d{3}\b", row)[: len(shown)]
        assert cells == shown
    for row in truth.rows():
        assert re.sub(r"\s+", " ", f"{row.what} {pages.figure(row.published)}").strip() in text
    couple = sheets[1].harmonics("couple")[0].axes[0]
    assert pages.relative(sheets[1], "couple", 1) == pytest.approx(couple / (10.966227112 * 0.1), rel=1e-9)
    assert pages.relative(sheets[0], "force", 2) == pytest.approx(4 * 4.111095986 / 10.966227112, rel=1e-9)


def test_published_figures_stand_on_the_page_of_their_layout():
    table = truth.rows()
    shown = {name: pages.Sheet(FakeComparison(Engine(name)), ()).claims(table) for name in names()}
    whats = {name: {row.what for row in rows} for name, rows in shown.items()}
    assert "flat4 1x moment [N.m] (flat-vs-boxer article)" in whats["flat4_shared"]
    assert "peak moment V10_72_steps_of_144" in whats["V10_72"] and "6x force, V12" in whats["V12_60"]
    assert not any("V12" in what or "V10" in what for what in whats["I4"] | whats["V8_flat"])
    assert all(row.layouts and set(row.layouts) <= set(names()) for row in table)  # every row stands on some page
    assert "1x couple, crank's centre on the axis" in whats["V8_cross"]
    with pytest.raises(ValueError, match="no layout begins with 'I7'; there are single"):
        claims.family("I4 I7")


class FakeComparison:
    """What `Sheet.claims` asks for."""

    def __init__(self, engine):
        self.engine = engine


def test_marks_of_the_truth_table_follow_its_numbers():
    """A figure that counts as true is within half a percent: published with two digits or more, or 0."""
    table = truth.rows()
    pairs = {"pass": [], "fail": [], "": []}
    for row in table:
        pairs[pages.mark(row)].append((row.published, row.actual))
    for published, actual in pairs["pass"]:
        assert abs(published - actual) <= max(5e-3 * abs(actual), 1e-9)
    for published, actual in pairs["fail"]:
        assert abs(published - actual) > 5e-5 * abs(actual)
    assert all(None in pair for pair in pairs[""]) and min(map(len, pairs.values())) > 20


def test_names_are_escaped_and_no_template(folder):
    for path in folder.glob("*.html"):
        text = path.read_text(encoding="utf-8")
        assert "<i>" not in text
    assert f"<h1>{html.escape(HOSTILE, quote=True).replace('&quot;', '&#34;')} {{{{ 7 * 7 }}}}</h1>" in (
        folder / pages.file_names(engines())[2]
    ).read_text(encoding="utf-8")


@pytest.mark.slow
def test_the_same_bytes_twice(folder, tmp_path):
    pages.write_pages(tmp_path, engines(), progress=False)
    files = sorted(p.relative_to(folder) for p in folder.rglob("*.html"))
    assert files == sorted(p.relative_to(tmp_path) for p in tmp_path.rglob("*.html"))
    for file in files:
        assert (folder / file).read_bytes() == (tmp_path / file).read_bytes(), file


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("I4", "1-3-4-2, every 180\u00b0"),
        ("I3", "1-2-3, every 240\u00b0 (stated: 1-3-2)"),
        ("Vtwin_90", "1-2, 270\u00b0 to 450\u00b0 apart"),
    ],
)
def test_firing_in_words(name, said):
    assert pages.Sheet(FakeComparison(Engine(name)), ()).firing == said


def test_gas_torque_of_a_page(folder):
    """Virtual power and the spatial model are the same, with weight and on a dyno; the orders are the known ones."""
    sheet = pages.make_sheet(Engine("V6_90_shared"), gravity=(1.0, -9.0), driver="dyno", peak=700.0)
    angle, seen = sheet.gas.samples
    theory = np.interp(angle, *sheet.gas.closed)  # every sample is a place of the line
    # rounding of inertia less inertia
    np.testing.assert_allclose(seen, theory, rtol=0, atol=1e-9 * np.abs(theory).max())
    found = {order: rest for order, *rest in pages.make_sheet(Engine("I4")).gas.harmonics(6)}
    assert set(found) == {0, 2, 4, 6}
    assert found[2][0] == pytest.approx(4e4 / (3 * np.pi))  # 4244.13 N
    assert found[0][1] == pytest.approx(5000.0, rel=1e-6)  # work of four pulses over 4 pi: 4 * 10 kN * pi / 2 * 1 m
    assert f"torque on the crank [N m] 5000 {digits(found[2][1])}" in words(folder / "I4.html")
    nameless = replace(layout("I3"), pins=17 * (0.0,), bores=17 * (0.0,), stations=tuple(range(17)), firing_order=None)
    with pytest.raises(gas.FiringOrderError, match="17 cylinders; give a firing_order"):
        gas.firing_angles(nameless)


def test_views_play_from_the_start(folder):
    for view in (folder / "views").iterdir():
        assert view.read_text(encoding="utf-8").rstrip().endswith(f"{pages.PLAY_SCRIPT}</body>\n</html>")


def test_a_column_without_figures_is_left_out(folder):
    assert "spatial published 2x force N 16.4444 16.4444 16.4444 16.44" in words(folder / "I4.html")
    text = words(folder / "V6_60_offset+60.html")
    assert "phasor planar spatial 6x force N 0.12376" in text
    assert "figure by its assumptions true verdict" in text  # nobody published a figure of a V6
    assert "figure published by its assumptions true verdict" in words(folder / "I4.html")


def test_pages_by_the_command_line(tmp_path):
    folder = tmp_path / "out"
    options = ("--rpm", "20", "--gravity", "2.5", "-9", "--driver", "dyno", "--gas", "321")
    result = CliRunner().invoke(cli.main, ["I3", *options, "--pages", str(folder)])
    assert result.exit_code == 0 and result.output.strip() == str(folder / "index.html")
    text, toy = words(folder / "I3.html"), Engine("I3", rpm=20.0)
    for said in ("20 rpm", "2.5 m/s² along x, \u22129 m/s² along y", "on a dyno", "Half sines of 321 N", "and weight"):
        assert said in text
    weighed = compare(toy, gravity=(2.5, -9.0), driver="dyno").ways["phasor"]
    assert f"3x reaction N m {np.abs(weighed.moment[3, 2]):.6g}" in text
    sheet = pages.make_sheet(toy, gravity=(2.5, -9.0), driver="dyno")
    # 24 orders, rounding
    np.testing.assert_allclose(sheet.closed[1][::10], sheet.samples[1], rtol=0, atol=1e-9 * sheet.peak)


def test_pages_of_ways_that_disagree_end_with_1(tmp_path, monkeypatch):
    monkeypatch.setattr(balance, "DISAGREEMENT_MAX", 0.0)
    result = CliRunner().invoke(cli.main, ["I3", "--pages", str(tmp_path)])
    assert result.exit_code == 1 and "disagree for I3" in result.output and (tmp_path / "I3.html").is_file()


def test_ways_that_disagree_are_not_called_agreed():
    sheet = pages.make_sheet(Engine("I3"))
    wrong = replace(sheet.comparison.ways["planar"], force=1.001 * sheet.comparison.ways["planar"].force)
    ways = {**sheet.comparison.ways, "planar": wrong}
    bad = replace(sheet, comparison=replace(sheet.comparison, ways=ways))
    for each, word, verdict in ((sheet, "agree to", "good"), (bad, "DISAGREE: up to", "bad")):
        text = pages.render("index.html", sheets=[(each, "I3.html")], truth=[], shades=pages.shades([each]))
        assert word in text and f'class="verdict {verdict}"' in text


def test_errors_are_named(tmp_path):
    with pytest.raises(ValueError, match="engine 'I4' would share 'I4.html' with another page; rename it"):
        pages.write_pages(tmp_path, [Engine("I4"), Engine("I4")])
    with pytest.raises(ValueError, match="'Index' would share 'Index.html'"):
        pages.file_names([Engine(replace(layout("I3"), name="Index"))])
    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match="cannot be made .*; give another one"):
        pages.write_pages(tmp_path / "file" / "below", [Engine("I3")])
    with pytest.raises(ValueError, match="no engines; give at least one"):
        pages.write_pages(tmp_path, [])
    with pytest.raises(ValueError, match="rpm 0"):
        pages.write_pages(tmp_path, [Engine("I3", rpm=0)])


@pytest.mark.slow
def test_pages_of_all_layouts(tmp_path):
    pages.write_pages(tmp_path)
    assert len(list(tmp_path.glob("*.html"))) == 25 and len(list(tmp_path.glob("views/*.html"))) == 24
