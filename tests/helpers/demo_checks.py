"""What every demo of a family must do; the test file of a family imports these and says which folder it is."""

import sys
from functools import cache
from math import isfinite
from types import ModuleType

import numpy as np
import pytest
from matplotlib.figure import Figure

from helpers.beats import CONDITIONS
from helpers.pages import OUTSIDE, covered, differing, many_pages, scene, seek, shown
from mbsd3d import Body, System, accelerations
from mbsd3d.demos.discovery import walk
from mbsd3d.demos.report import write
from mbsd3d.extend import Ablation, Curve, Demo, Measured, Quantity
from mbsd3d.plotting.default_curves import seen_panels
from mbsd3d.report.mathml import letters

LONG = {  # take a second or more
    *("double_lane_change", "euler_disc_end", "explorer_flat_spin", "fishhook", "rattleback", "roll_bars"),
    *("spinning_egg", "tippe_top"),
}
PLACES = np.linspace(0.3, 1.0, 3)  # of a motion; of the first a picture is taken, as the end may be the start


def demos_of(package: ModuleType) -> pytest.MarkDecorator:
    """Every demo of a folder."""
    found = (demo for demo in walk(package) if isinstance(demo, Demo))
    marked = [pytest.param(demo, id=demo.name, marks=pytest.mark.slow if demo.name in LONG else ()) for demo in found]
    return pytest.mark.parametrize("demo", marked)


@cache
def outcome(demo: Demo):
    """What a demo gives with its own parameters, computed once."""
    return demo.run()


@cache
def written(demo: Demo, folder):
    """Its files, written once."""
    return {path.name: path for path in write(demo, outcome(demo), folder)}


def small(name, module="plugin_demos"):
    """A demo of another package that misses its theory."""
    system = System([Body("stone", 1.0, (1, 1, 1))])
    found = Measured({"one": 2.0}, (), [Curve("one [-]", [0, 1], [2, 2])])
    file = ModuleType(f"{module}.{name}")
    file.mechanism, file.theory, file.measure = lambda: system, lambda: {"one": 1.0}, lambda build, terms: found
    sys.modules[file.__name__] = file
    return Demo(
        file.__name__, "a title", "Why?", "Because.", "1 = 1", "a book", {"one": Quantity("one", "", 1e-9)},
        Ablation("gyroscopic", "nothing"),
    )  # fmt: skip


def misses(outcome):
    return [(row.name, row.computed, row.theory, row.error) for row in outcome.rows if not row.passed]


def test_every_quantity_meets_its_theory(demo):
    assert misses(outcome(demo)) == []
    assert set(outcome(demo).quantities) == set(demo.quantities) == set(demo.expected(demo.parameters))


def test_the_ablation_is_noticed_and_does_what_it_says(demo):
    ablated, expected = demo.run(demo.ablation.term), demo.expected_without(demo.parameters)
    assert any(row.error >= 100 * row.tolerance for row in ablated.rows)
    for name, value in expected.items():
        found, limit = ablated.quantities[name].computed, demo.quantities[name].tolerance(value)
        assert found == value or abs(found - value) <= (limit if isfinite(value) else 0.0), name


def test_it_says_what_a_reader_asks(demo):
    assert demo.question.endswith("?") and demo.title and demo.equation and demo.source and demo.ablation.then
    assert 2 <= demo.why.count(". ") + 1 <= 6 and demo.why.endswith((".", ".)"))
    with pytest.raises(ValueError, match=rf"demo '{demo.name}' has no parameter 'nonsense'"):
        demo.run(nonsense=1.0)


def test_its_beats_say_what_is_seen_then(demo):
    run = next(iter(outcome(demo).views.values())).solution
    story, conditions = demo.story(run), CONDITIONS[demo.name]
    assert len(story) == len(conditions) >= 2 and story[0][0] == run.t[0]
    times = [t for t, _ in story]
    assert times == sorted(set(times)) and times[-1] <= run.t[-1]
    for (t, says), condition in zip(story, conditions, strict=True):
        assert says.endswith((".", " ...")) and len(says) < 90, says
        assert condition is None or condition(run, int(np.argmin(abs(run.t - t)))), says


def test_every_letter_of_its_equation_has_a_meaning(demo):
    assert set(demo.symbols) == letters(demo.equation)
    run, options = next(iter(outcome(demo).views.values()))
    panels = [panel for entry in options["curves"] for panel in seen_panels(run, [entry])]
    for symbol in demo.symbols.values():
        curve, line = symbol.curve or (0, 0)
        assert symbol.text and line < len(panels[curve].lines)
        assert isinstance(symbol.value, str) or isfinite(demo.call(symbol.value, demo.parameters))
        assert callable(symbol.value) or symbol.value in ("", *demo.parameters)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_other_parameters_meet_their_theory(demo, seed):
    changed = demo.varied(np.random.default_rng(seed))
    assert changed and misses(demo.run(**changed)) == []


@pytest.mark.slow
def test_every_parameter_drives_the_mechanism(demo):
    """A number that changes neither the mechanism at its start, nor its motion, nor what is computed is none."""
    changed, here = demo.varied(np.random.default_rng(3)), at_start(demo, demo.parameters)
    for name, value in changed.items():
        if value == demo.parameters[name]:
            value = value + 1 if isinstance(value, int | float) else None  # a count, a zero; words have their own tests
        assert at_start(demo, {**demo.parameters, name: value}) != here or runs_otherwise(demo, {name: value}), name


def at_start(demo, values):
    """Masses, state and accelerations at the start, or None where there are none."""
    try:
        system = demo.call(demo.mechanism, values)
        now = accelerations(system)
    except (ValueError, TypeError):
        return None  # said by `run` in words
    moving = [np.concatenate([now.acceleration(body)[0], now.alpha(body)[0]]).tolist() for body in system.bodies]
    return masses(system), now.arrays["state"].tolist(), moving


def runs_otherwise(demo, changes):
    """Whether numbers or motions differ from those of the demo's own parameters."""
    try:
        there = demo.run(**changes)
    except ValueError:
        return True  # the assumptions of the formula end: that is said, and the parameter is in use
    here = outcome(demo)
    runs = zip(here.solutions.values(), there.solutions.values(), strict=True)
    return any(row.computed != there.quantities[row.name].computed for row in here.rows) or any(
        a.t.shape != b.t.shape or not np.array_equal(a.arrays["state"], b.arrays["state"]) for a, b in runs
    )


def masses(system):
    return [[body.mass, *body.inertia.ravel(), *body.com] for body in system.bodies]


@pytest.mark.slow
def test_figure_and_files(demo, folder):
    found = outcome(demo)
    assert isinstance(found.figure, Figure) and found.figure.axes
    for axes in found.figure.axes:
        labels = [text for text in (axes.get_xlabel(), axes.get_ylabel()) if text]  # rows of a table name themselves
        assert labels and all("[" in label and label.endswith("]") for label in labels), labels
    sizes = {name: path.stat().st_size for name, path in written(demo, folder).items()}
    assert sizes[f"{demo.name}.png"] > 10_000 and sizes[f"{demo.name}.svg"] > 5_000
    assert all(sizes[f"{view}.html"] > 100_000 for view in found.views)


@pytest.fixture(scope="module")
def window(chromium, folder):
    """One for the pages of all demos of a family."""
    with many_pages(chromium, folder / "blank.html") as seen:
        yield seen


@pytest.mark.slow
def test_it_is_seen_moving(demo, window, folder):
    """Its pages are drawn, move, keep within the picture, and complain of nothing."""
    for view, (run, _) in outcome(demo).views.items():
        ground = f"/bodies/{len(run.system.bodies)}"
        with shown(window, written(demo, folder)[f"{view}.html"]) as seen:
            times = seen.run("mbsd3d.data.times")
            first, moves = scene(seen), "nothing moves" in demo.alone
            assert covered(first)[0] > 0.03
            for share in PLACES:
                seek(seen, times["first"] + share * times["step"] * (times["count"] - 1))
                outside = [name for name in seen.run(OUTSIDE) if name.count("/") > 2]
                # where the camera goes along, ground and paths run out of the picture
                assert [name for name in outside if not name.startswith(f"{ground}/") and "/trace" not in name] == []
                moves = moves or differing(first, scene(seen)) > 0.001 * first[..., 0].size
            assert moves
