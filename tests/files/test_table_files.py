"""Tables of a run: one row a sample, names of systems, texts that no spreadsheet runs, and what a notebook shows."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Revolute, SpringDamper, System, load, simulate
from mbsd3d.files.table_files import harmless


@pytest.fixture(scope="module")
def run():
    bob = Body("bob <b>", 1.0, (0.1, 0.1, 0.1), position=(0.3, 0, -1.0))
    hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0), name="=1+1")
    ends = dict(at_a=(1.0, 0, 0), at_b=(0.3, 0, -1.0))
    spring = SpringDamper(GROUND, bob, **ends, stiffness=5.0, name="@spring")
    return simulate(System([bob], [hinge], [spring], name="swing & co"), 1.0, output=5)


def test_a_dataframe_has_one_row_a_sample(run):
    table = run.to_dataframe()
    assert table.index.name == "time [s]" and np.array_equal(table.index, run.t)
    assert np.array_equal(table["bob <b>.position.x [m]"], run.position("bob <b>")[:, 0])
    assert np.array_equal(table["@spring.force.z [N]"], run.force("@spring").force[:, 2])
    assert np.array_equal(table["=1+1.angle [rad]"], run.angle("=1+1"))
    assert len(set(table.columns)) == table.shape[1] and table.notna().all(axis=None)


def test_no_cell_of_a_table_is_a_formula(run, tmp_path):
    head, *rows = csv.reader(run.to_csv(tmp_path / "run").read_text().splitlines())
    assert "'=1+1.angle [rad]" in head and "'@spring.force.x [N]" in head
    assert not any(name[0] in "=+-@" for name in head)
    assert np.array(rows, float).tolist() == np.column_stack([run.t, run.to_dataframe()]).tolist()
    for name in ("=cmd()", "+1", "-1", "@sum", "\tx", "\rx"):
        assert harmless(name) == f"'{name}"
    assert harmless("crank-1") == "crank-1"


def test_half_a_character_in_a_name_is_a_question_mark(tmp_path):
    stone = Body("T\udcfcr", 1.0, (0.1, 0.1, 0.1))  # what a shell without UTF-8 makes of an umlaut
    head, *_ = simulate(System([stone]), 0.1, output=2).to_csv(tmp_path / "run").read_text().splitlines()
    assert head.startswith("time [s],T?r.position.x [m]")


def test_a_system_has_a_name(run, tmp_path):
    system = run.system
    assert system.title == "swing & co" and replace(system, forces=()).title == "swing & co"
    assert repr(system) == "<system 'swing & co': 1 body, 1 joint, 1 force>"
    assert repr(System(system.bodies)) == "<system: 1 body>"
    for name in ("model.json", "model.toml"):
        assert System.from_file(system.to_file(tmp_path / name)).title == "swing & co"
    assert load(run.save(tmp_path / "run")).system.title == "swing & co"
    assert run.report().title == "swing & co" and run.to_xarray().attrs["title"] == "swing & co"
    assert "swing &amp; co" in run.animate().html or "swing \\u0026 co" in run.animate().html


def test_notebooks_show_texts_that_are_no_markup(run):
    for shown in (run, run.system, run.certificate, run.system.check(), run.final):
        text = shown._repr_html_()
        assert text.startswith(("<pre", "<table>")) and "<b>" not in text
    assert "bob &lt;b&gt;" in run.system._repr_html_() and "passed" in run._repr_html_()


def test_arrays_print_by_their_sizes(run):
    assert repr(run.drift()).startswith("<Drift: position (5,) up to ")
    assert repr(run.reaction("=1+1")).startswith("<Reaction: force (5, 3) up to ")
    assert repr(run.force("@spring")).startswith("<Load: force (5, 3) up to ")
    assert max(len(repr(x)) for x in (run.energy(), run.momentum(), run.force("@spring"))) < 250
