"""The gallery: pages are written, kept while nothing changes, found by words, and run without an error."""

import json
import re
import shlex
import sys
from dataclasses import replace

import numpy as np
import pytest
from helpers.browser import PATIENCE, visit
from PIL import Image

from mbsd3d.demos import gallery
from mbsd3d.demos.base import Outcome, Row
from mbsd3d.demos.discovery import own_demos
from mbsd3d.demos.parameters import checked, lacking, settings
from mbsd3d.extend import discover
from mbsd3d.report.mathml import mathml

NAME = "barrel_cam"  # has two players: its page does not solve
WAIT = {"polling": 200, "timeout": PATIENCE}  # not by pictures: a frame out of sight draws none


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The page of one demo, and a front page."""
    folder = tmp_path_factory.mktemp("site")
    assert gallery.page(NAME, folder)
    gallery.front([NAME], folder)
    return folder


def test_a_page_says_shows_and_proves(site):
    text, demo = (site / f"{NAME}.html").read_text(), own_demos()[NAME]
    for piece in (demo.question, demo.why[:40], "<svg", f'src="{NAME}_seen.html"', f'src="{NAME}_without.html"'):
        assert piece.replace("'", "&#39;") in text
    assert "def mechanism(" in text and "http" not in text.replace("http://www.w3.org", "")
    found = json.loads((site / f"{NAME}.json").read_text())
    assert found["passed"] and set(found["quantities"]) == set(demo.quantities)
    assert (site / f"{NAME}.png").stat().st_size > 5_000


def test_the_front_page_moves_unless_the_reader_wants_it_still(site):
    with Image.open(site / f"{NAME}.gif") as film:
        assert film.n_frames > 20 and film.size == (480, 360)
        film.seek(0)
        first = np.asarray(film.convert("RGB"), float)
        film.seek(film.n_frames // 3)
        assert (np.abs(np.asarray(film.convert("RGB"), float) - first).max(axis=2) > 30).sum() > 600
    source, still = re.search("<picture>(.*?)(<img.*?)</picture>", (site / "index.html").read_text()).groups()
    assert "prefers-reduced-motion: no-preference" in source and f"{NAME}.gif" in source and f"{NAME}.png" in still


def test_texts_have_the_signs_of_print():
    text = "m w x (w x s), -J_dot v and `check()`: 18 140 N along x and y, force x at t, sqrt(C/A) m/s^2, 6 - 10"
    shown = "m w × (w × s), -J\u0307 v and check(): 18\u202f140 N along x and y, force x at t, √(C/A) m/s², 6 − 10"
    assert gallery.prose(text) == shown


def test_players_share_one_viewer(site):
    assert (site / "viewer.js").stat().st_size > 500_000
    assert all(path.stat().st_size < 200_000 for path in site.glob(f"{NAME}_*.html"))


@pytest.mark.slow
def test_a_page_is_kept_until_something_changes(site):
    before = (site / f"{NAME}.html").stat().st_mtime_ns
    assert not gallery.page(NAME, site) and (site / f"{NAME}.html").stat().st_mtime_ns == before
    (site / f"{NAME}.json").write_text(json.dumps({"digest": "another"}))
    assert gallery.page(NAME, site)


ENDS = (".json", ".html", "_seen.html", "_without.html", ".png", ".gif")


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("left", [None, b"", b"{", "half", b'["not", "numbers"]'])
def test_a_page_is_kept_only_if_all_its_files_are_whole(site, monkeypatch, end, left):
    """As an interruption, a full disk or a hand leaves them."""

    def made_again(*_):
        raise KeyError("it is made again")

    monkeypatch.setattr(gallery.Demo, "run", made_again)
    assert not gallery.page(NAME, site)
    file = site / f"{NAME}{end}"
    before = file.read_bytes()
    try:
        file.unlink()
        if left is not None:
            file.write_bytes(before[: len(before) // 2] if left == "half" else left)
        with pytest.raises(KeyError, match="it is made again"):
            gallery.page(NAME, site)
    finally:
        file.write_bytes(before)
    assert not gallery.page(NAME, site)


def test_every_demo_has_a_digest_of_its_own():
    demos = discover()
    assert len({gallery.digest(demo, demo) for demo in demos.values()}) == len(demos)


def test_a_page_depends_on_helpers_scripts_and_the_page_it_leads_to():
    demos = discover()
    helpers = {module.__name__ for module in gallery.needed(sys.modules[demos["car_limit"].module])}
    assert helpers >= {f"mbsd3d.demos.cars.{name}" for name in ("car_limit", "car", "circle", "theory")}
    assert "mbsd3d.demos.cars.driver" not in helpers
    assert "bicycle.model.mechanism" in {x.__name__ for x in gallery.needed(sys.modules[demos["no_hands"].module])}
    names = {path.name for path in gallery.shared()}
    assert {"demo.html", "in_step.js", "player.js", "rows.py", "figure.py"} <= names and "car.py" not in names
    first, other = list(demos.values())[:2]
    assert gallery.digest(first, first) != gallery.digest(first, other)
    assert gallery.digest(first, other) != gallery.digest(first, replace(other, title="another title"))


def test_a_number_is_shown_as_zero_where_the_tolerance_does_not_tell_them_apart():
    assert list(gallery.cells(Row("angle", 4e-8, -9e-8, 1e-6, "rad")))[1:] == ["0", "0", "1.3 · 10⁻⁷"]
    assert list(gallery.cells(Row("angle", 4e-7, 0.25, 1e-6, "rad")))[1:] == ["4 · 10⁻⁷", "0.25", "2.5 · 10⁻¹"]


@pytest.mark.parametrize("name", discover())
def test_the_command_on_a_page_is_one_that_runs(name):
    demo = discover()[name]
    program, command, named, *options = shlex.split(gallery.command(demo))
    assert (program, command, named) == ("mbsd3d", "demo", name) and options[::2] == ["--set"] * (len(options) // 2)
    assert checked(name, demo.parameters, settings(options[1::2])) == demo.parameters


@pytest.mark.parametrize("name", discover())
def test_an_ablation_does_not_say_twice_what_is_missing(name):
    ablation = discover()[name].ablation
    assert not ablation.then.startswith("without") and "_" not in lacking(ablation.term)


@pytest.mark.slow
@pytest.mark.parametrize("width", [1400, 420])
def test_the_pages_fit_and_find(chromium, site, width):
    seen, errors = chromium.new_page(viewport={"width": width, "height": 900}), []
    seen.on("pageerror", lambda error: errors.append(str(error)))
    seen.goto((site / f"{NAME}.html").as_uri())
    assert seen.evaluate("document.documentElement.scrollWidth") <= width
    seen.goto((site / "index.html").as_uri())
    assert seen.locator("[data-words]").count() == 1 and seen.evaluate("document.body.scrollWidth") <= width
    for text, count in (
        ("barrle", 1),
        ("gruove", 1),
        ("barrle maple syrup", 0),
        ("no such effect", 0),
        ("barrel CAM", 1),
    ):
        seen.fill("#search", text)
        assert seen.locator("[data-words]:visible").count() == count, text
        assert seen.locator("#nothing").is_visible() == (count == 0)
    assert errors == []
    seen.close()


@pytest.mark.slow
def test_no_equation_is_cut_on_a_phone(chromium, site, tmp_path):
    """Those of all demos in the style of one page."""
    style = re.search("<style>.*?</style>", (site / f"{NAME}.html").read_text(), re.DOTALL)[0]
    parts = [f'<div class="equation" id="{x.name}">{mathml(x.equation)}</div>' for x in discover().values()]
    (tmp_path / "all.html").write_text(f"<!doctype html><meta charset=utf-8>{style}{''.join(parts)}")
    seen = chromium.new_page(viewport={"width": 420, "height": 900})
    seen.goto((tmp_path / "all.html").as_uri())
    cut = "[...document.querySelectorAll('.equation')].filter((x) => x.scrollWidth > x.clientWidth).map((x) => x.id)"
    assert seen.locator(".equation").count() == len(parts) and seen.evaluate(cut) == []
    seen.close()


@pytest.mark.slow
def test_the_players_keep_in_step(chromium, site):
    seen, errors = chromium.new_page(viewport={"width": 1400, "height": 900}, reduced_motion="reduce"), []
    seen.on("pageerror", lambda error: errors.append(str(error)))
    seen.goto((site / f"{NAME}.html").as_uri())
    first, other = (
        next(frame for frame in seen.frames if f"_{kind}.html" in frame.url) for kind in ("seen", "without")
    )
    for frame in (first, other):
        frame.wait_for_function("document.querySelector('canvas') && document.getElementById('message').hidden", **WAIT)
    first.evaluate("document.getElementById('play').click()")
    other.wait_for_function("document.getElementById('play').getAttribute('aria-label') === 'pause'", **WAIT)
    first.wait_for_function("document.getElementById('scrub').valueAsNumber > 0", **WAIT)
    first.evaluate("document.getElementById('play').click()")
    other.wait_for_function("document.getElementById('play').getAttribute('aria-label') === 'play'", **WAIT)
    times = [frame.evaluate("document.getElementById('scrub').valueAsNumber") for frame in (first, other)]
    assert abs(times[1] - times[0]) < 0.05
    first.evaluate("document.getElementById('back').click()")  # no play, no slider
    for frame in (first, other):
        frame.wait_for_function("t => document.getElementById('scrub').valueAsNumber < t", arg=times[0], **WAIT)
    times = [frame.evaluate("document.getElementById('scrub').valueAsNumber") for frame in (first, other)]
    assert abs(times[1] - times[0]) < 1e-3 and errors == []
    seen.close()


@pytest.mark.slow
def test_a_page_plays_in_view_and_tells_its_story(chromium, site):
    """It starts by itself, says its sentences, and its letters show the values of the moment."""
    with visit(chromium, site / f"{NAME}.html", width=1400, height=900, reduced_motion="no-preference") as page:
        frame = next(frame for frame in page.page.frames if "_seen.html" in frame.url)
        frame.wait_for_function("window.mbsd3d?.playing && mbsd3d.time > 0.05", **WAIT)
        page.run("scrollTo(0, document.body.scrollHeight)")
        frame.wait_for_function("!mbsd3d.playing", **WAIT)
        story = own_demos()[NAME].beats
        second = page.page.locator(".story button").nth(1)
        second.click()
        at = float(second.get_attribute("data-seek"))
        frame.wait_for_function("t => Math.abs(mbsd3d.time - t) < 1e-6", arg=at, **WAIT)
        page.wait("document.querySelector('.story li:nth-child(2)').ariaCurrent === 'step'")
        assert frame.locator("#caption .now").text_content() == story[1].says and not frame.evaluate("mbsd3d.playing")
        page.run("scrollTo(0, 0)"), page.page.wait_for_timeout(500)
        assert not frame.evaluate("mbsd3d.playing")  # the reader has taken over
        assert page.complaints == []


@pytest.mark.slow
@pytest.mark.parametrize("width", [1400, 420])
def test_letters_of_the_equation_live(chromium, tmp_path, width):
    """Values go with the time; letter and curve light each other; a curve below leads to its moment."""
    assert gallery.page("slide_to_roll", tmp_path)
    gallery.front(["slide_to_roll"], tmp_path)
    with visit(chromium, tmp_path / "slide_to_roll.html", width=width, height=900) as page:
        frame = next(frame for frame in page.page.frames if "_seen.html" in frame.url)
        frame.wait_for_function("document.documentElement.dataset.ready === 'yes'", **WAIT)
        frame.evaluate("mbsd3d.seek(0.2)")
        speed = page.page.locator(".symbols [data-symbol=v]")
        page.wait("document.querySelector('.symbols [data-symbol=v] output').textContent === '4.411'")  # 5 - mu g t
        speed.click()
        assert speed.get_attribute("aria-pressed") == "true"
        assert page.page.locator(".equation .lit").count() == 2  # of v, the index of v_1 is another letter
        speed.click(), page.page.mouse.move(2, 2)
        page.wait("!document.querySelector('.lit')")
        frame.locator("#curves figure:nth-child(2) li:nth-child(2)").hover()
        page.wait("document.querySelector('.symbols .lit')?.dataset.symbol === 'w'")
        at = page.run("""() => {
          const figure = document.querySelector("svg[data-time]");
          figure.scrollIntoView({block: "center"});
          const [first, last, left, right, bottom, top] = figure.dataset.time.split(" ").map(Number);
          const x = left + ((right - left) * (1.5 - first)) / (last - first);
          const {x: across, y} = new DOMPoint(x, (top + bottom) / 2).matrixTransform(figure.getScreenCTM());
          return [across, y];
        }""")
        page.page.mouse.click(*at)
        frame.wait_for_function("Math.abs(mbsd3d.time - 1.5) < 0.03", **WAIT)
        assert page.run("document.documentElement.scrollWidth") <= width and page.complaints == []


def test_a_demo_that_does_not_move_any_more_leaves_no_film(tmp_path):
    path = tmp_path / "still.gif"
    path.write_bytes(b"of yesterday")
    gallery.film(Outcome((), tuple, {}), path)
    assert not path.exists()
