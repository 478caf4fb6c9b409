"""Pages of demos that solve: tables over the sliders, runs, and readings of curves are those of Python."""

import numpy as np
import pytest
from helpers.browser import PATIENCE, visit
from helpers.node import run_in_node
from helpers.view import built, curves_over, explored, frames_shown

from mbsd3d import simulate
from mbsd3d.demos import gallery
from mbsd3d.extend import discover

SOLVING = [name for name, demo in discover().items() if demo.sliders]
QUICK = ["dzhanibekov", "spherical_pendulum", "cardan"]  # the rest is slow
SCRIPTS = ("unpack.js", "solver.js", "explore.js")
SOLVE = """
found = given.cases.map(({values, times}) => {
  const what = given.explore, tables = tablesAt(what, what.sliders, values);
  const arrows = what.arrows.map((names, a) => names && {kind: given.kinds[a], names});
  const {made, run} = solveMotion(tables, what, arrows, times);
  while (run.advance(5));
  const k = times.length - 1, row = ({values, width}) => Array.from(values.subarray(k * width));
  return {failed: run.failed, gap: run.gap, r: row(made.r), e: row(made.e),
    lines: made.lines.map((lines) => lines && lines.map(({values}) => Array.from(values))),
    vectors: made.arrows.map((arrows) => arrows && row(arrows.vectors)),
    traces: what.traces.map((trace) => pathOf(trace, made, times.length)[k])};
});
"""


@pytest.fixture(scope="module")
def outcomes():
    """The outcome of each demo, computed once."""
    return {}


def page_of(name, outcomes):
    """(Exploration, what its script reads, run, frames, what is drawn and what was asked for) of the page of a demo."""
    demo = discover()[name]
    if name not in outcomes:
        outcomes[name] = demo.run()
    outcome = outcomes[name]
    run, options = gallery.first_view(outcome)
    given, frames = gallery.exploration(demo, outcome), frames_shown(run, options)
    data, shown = explored(run, given, frames, options)
    return given, data, run, frames, shown


def write_page(name, folder):
    """Write the page of a demo and the front page beside it."""
    assert gallery.page(name, folder)
    gallery.front([name], folder)


def settings(given, seed):
    """Values of the sliders in general position."""
    rng = np.random.default_rng(seed)
    return {x.name: x.at(rng.uniform(-0.9, 0.9)) for x in given.sliders}


@pytest.mark.parametrize("name", [x if x in QUICK else pytest.param(x, marks=pytest.mark.slow) for x in SOLVING])
def test_a_page_solves_what_python_does(name, outcomes):
    """At the first values all that is drawn is that of the page; at others poses are those of Python to 1e-6 of the
    size and radians, of chaotic or long runs to 1e3 times what Python itself changes from rtol 1e-10 to 1e-12.
    """
    given, data, run, frames, (drawn, wanted) = page_of(name, outcomes)
    few = frames.t[: max(2, min(frames.t.size, 60))]
    cases = [{"values": [x.start for x in given.sliders], "times": frames.t.tolist()}]
    others = [settings(given, seed) for seed in (1, 2)]
    cases += [{"values": list(x.values()), "times": few.tolist()} for x in others]
    kinds = [x.kind for x in drawn[0]]
    first, *found = run_in_node(SCRIPTS, SOLVE, {"explore": data, "cases": cases, "kinds": kinds})
    length = data["tables"]["length"]
    assert not first["failed"] and first["gap"] < 1e-11
    n, size = len(run.system.bodies), max(length, np.ptp(frames.r, axis=(0, 1)).max())
    bound = 1e-5 * size
    np.testing.assert_allclose(np.reshape(first["r"], (-1, 3))[:n], frames.r[-1, :n], rtol=0, atol=bound)
    products = np.abs((np.reshape(first["e"], (-1, 4))[:n] * frames.e[-1, :n]).sum(axis=1))
    assert products.min() > 1 - 1e-9
    for lines, curve in zip(first["lines"], curves_over(run, frames, wanted[0]), strict=True):
        for own, (_, values) in zip(lines or [], curve.lines, strict=False):
            largest = max(np.abs([v for _, v in curve.lines]).max(), 1e-7 * curve.size)  # of rounding nothing is asked
            np.testing.assert_allclose(own[1:-1], values[1:-1], rtol=0, atol=2e-3 * largest)
    for own, kind in zip(first["vectors"], drawn[0], strict=True):
        if own is not None:
            np.testing.assert_allclose(np.reshape(own, (-1, 3)), kind.vectors[-1], rtol=0, atol=1e-3 * kind.longest)
    for own, trace in zip(first["traces"], drawn[1], strict=True):
        np.testing.assert_allclose(own, trace.points[-1], rtol=0, atol=bound)
    for values, seen in zip(others, found, strict=True):
        assert not seen["failed"]
        system, start = built(given.build, values)
        again = [simulate(system, float(few[-1]), state=start, rtol=x, output=few) for x in (1e-10, 1e-12)]
        for i, body in enumerate(run.system.bodies):
            far = (
                1e-6 * length + 1e3 * np.abs(again[0].position(body.name)[-1] - again[1].position(body.name)[-1]).max()
            )
            np.testing.assert_allclose(seen["r"][3 * i : 3 * i + 3], again[1].position(body.name)[-1], rtol=0, atol=far)
            turned = abs(np.dot(seen["e"][4 * i : 4 * i + 4], again[1].orientation(body.name)[-1]))
            assert (
                np.sqrt(max(1 - turned**2, 0.0))
                < 1e-6 + 1e3 * np.abs(again[0].orientation(body.name)[-1] - again[1].orientation(body.name)[-1]).max()
            )


def test_an_ablation_by_a_term_or_by_values_is_a_ghost(outcomes):
    ghosts = {name: page_of(name, outcomes)[1]["ghost"] for name in ("dzhanibekov", "spherical_pendulum")}
    assert ghosts["dzhanibekov"]["term"] == "gyroscopic" and "tables" in ghosts["spherical_pendulum"]


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """The page of a demo that solves."""
    folder = tmp_path_factory.mktemp("solving")
    write_page("spherical_pendulum", folder)
    return folder


def test_a_page_that_solves_is_as_small_as_others(site):
    assert (site / "spherical_pendulum_seen.html").stat().st_size < 200_000
    assert not (site / "spherical_pendulum_without.html").exists()  # its ablation is the ghost


@pytest.mark.parametrize("width", [1400, 420])
def test_a_slider_moved_by_keys_changes_the_picture_and_all_numbers(chromium, site, width):
    with visit(chromium, site / "spherical_pendulum.html", width=width, height=900) as page:
        frame = next(x for x in page.page.frames if "_seen" in x.url)
        frame.wait_for_function("document.documentElement.dataset.ready === 'yes'", timeout=PATIENCE)
        frame.evaluate("mbsd3d.play(false); mbsd3d.seek(1.2)")
        frame.wait_for_timeout(1000)
        before = page.pixels("iframe")
        frame.evaluate("document.querySelector('#sliders input').focus()")
        for _ in range(20):
            page.page.keyboard.press("ArrowLeft")
        frame.wait_for_function("document.documentElement.dataset.solved === 'yes'", timeout=PATIENCE)
        angle, push = frame.evaluate("mbsd3d.explorer.values")
        assert angle < 50.0 and push == 1.5  # from 60 deg
        demo = discover()["spherical_pendulum"]
        system = demo.call(demo.mechanism, {**demo.parameters, "theta_deg": angle})
        span = "(({first, step, count}) => [first, first + step * (count - 1)])(mbsd3d.data.times)"
        times = np.array(frame.evaluate(span))
        known = simulate(system, float(times[1]), rtol=1e-12, output=times).position("bob")[-1]
        r = frame.evaluate("Array.from(mbsd3d.explorer.made.r.values.slice(-6, -3))")
        np.testing.assert_allclose(r, known, rtol=0, atol=1e-6)  # of a rod of 1 m
        half = demo.expected({**demo.parameters, "theta_deg": angle})["half_nutation_s"]
        assert f"by theory {half:.4g} s" in frame.evaluate("document.getElementById('theory').textContent")
        frame.wait_for_timeout(1000)
        assert (np.abs(page.pixels("iframe").astype(int) - before).max(axis=2) > 30).sum() > 500
        assert page.run("document.querySelector('.first').hidden && !document.getElementById('elsewhere').hidden")
        assert page.run("document.documentElement.scrollWidth") <= width
        frame.evaluate("document.querySelector('#terms button').click()")
        page.wait("!document.querySelector('.first').hidden")
        assert not page.complaints


def test_what_is_not_solved_yet_is_not_shown(chromium, site):
    """The clock stands at the last frame that is known, and the curves end there."""
    with visit(chromium, site / "spherical_pendulum_seen.html", width=700, height=900) as page:
        page.wait("document.documentElement.dataset.ready === 'yes'")
        page.run("mbsd3d.seek(1e9)")
        found = page.run("""(() => {
          mbsd3d.explorer.set([30, 1]);
          const {run, made} = mbsd3d.explorer, values = Array.from(made.lines[0][0].values);
          const [past, ahead] = [values.slice(0, run.next), values.slice(run.next)];
          return [run.next, past.every(Number.isFinite), ahead.every(Number.isNaN)];
        })()""")
        assert found[0] > 0 and found[1] and found[2]
        page.wait("document.documentElement.dataset.solved === 'yes'")
        assert not page.complaints
