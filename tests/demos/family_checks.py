"""What every demo of a family must do; the test file of a family imports these and says which folder it is."""

from functools import cache
from math import isfinite
from types import ModuleType

import numpy as np
import pytest
from matplotlib.figure import Figure

from mbsd3d import Body, System
from mbsd3d.demos.discovery import walk
from mbsd3d.demos.form import Ablation, Curve, Demo, Measured, Quantity
from mbsd3d.demos.report import write


def demos_of(package: ModuleType) -> pytest.MarkDecorator:
    """Every demo of a folder."""
    found = [demo for demo in walk(package) if isinstance(demo, Demo)]
    return pytest.mark.parametrize("demo", found, ids=[demo.name for demo in found])


@cache
def outcome(demo: Demo):
    """What a demo gives with its own parameters, computed once."""
    return demo.run()


def small(name, module="plugin_demos"):
    """A demo of another package that misses its theory."""
    system = System([Body("stone", 1.0, (1, 1, 1))])
    found = Measured({"one": 2.0}, (), [Curve("one [-]", [0, 1], [2, 2])])
    return Demo(
        f"{module}.{name}", "a title", "Why?", "Because.", "1 = 1", "a book", {"one": Quantity("one", "", 1e-9)},
        lambda: system, lambda: {"one": 1.0}, lambda build, terms: found, Ablation("gyroscopic", "nothing"),
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


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2])
def test_other_parameters_meet_their_theory(demo, seed):
    changed = demo.varied(np.random.default_rng(seed))
    assert changed and misses(demo.run(**changed)) == []


@pytest.mark.slow
def test_every_parameter_drives_the_mechanism(demo):
    """A number that changes neither what is computed nor the motion is none."""
    changed, here = demo.varied(np.random.default_rng(3)), outcome(demo)
    for name, value in changed.items():
        if value == demo.parameters[name]:
            value = value + 1 if isinstance(value, int | float) else None  # a count, a zero; words have their own tests
        try:
            there = demo.run(**{name: value})
        except ValueError:
            continue  # the assumptions of the formula end: that is said, and the parameter is in use
        moved = any(row.computed != there.quantities[row.name].computed for row in here.rows)
        assert moved or differs(here, there), name


def differs(here, there):
    """Whether two outcomes have other motions or systems."""
    runs = zip(here.solutions.values(), there.solutions.values(), strict=True)
    return any(
        a.t.shape != b.t.shape or not np.array_equal(a.arrays["state"], b.arrays["state"]) or masses(a) != masses(b)
        for a, b in runs
    )


def masses(run):
    return [(body.mass, *body.inertia.ravel(), *body.com) for body in run.system.bodies]


@pytest.mark.slow
def test_figure_and_files(demo, tmp_path):
    found = outcome(demo)
    assert isinstance(found.figure, Figure) and found.figure.axes
    for axes in found.figure.axes:
        labels = [text for text in (axes.get_xlabel(), axes.get_ylabel()) if text]  # rows of a table name themselves
        assert labels and all("[" in label and label.endswith("]") for label in labels), labels
    written = {path.name: path.stat().st_size for path in write(demo, found, tmp_path)}
    assert written[f"{demo.name}.png"] > 10_000 and written[f"{demo.name}.svg"] > 5_000
    assert all(written[f"{view}.html"] > 100_000 for view in found.views)
