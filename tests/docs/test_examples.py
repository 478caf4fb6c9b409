"""The scripts of examples/ print what their docstrings say, and docs/examples.md names them all."""

import ast
import contextlib
import io
import re
import runpy
import textwrap
from pathlib import Path

import pytest
from helpers.page_blocks import agrees

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.py"))
NEEDS = {"fmu_in_fmpy": "fmpy"}  # examples of extras
SLOW = {"bicycle_with_rider", "clock_escapement", "gyro_monorail", "valve_train"}


def said(path):
    """What the docstring of a script says that it prints."""
    text = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    return textwrap.dedent(text.split("Prints::\n\n")[1]) + "\n"


@pytest.mark.parametrize(
    "path", [pytest.param(p, id=p.stem, marks=pytest.mark.slow if p.stem in SLOW else ()) for p in EXAMPLES]
)
def test_example_prints_what_it_says(path, tmp_path, monkeypatch):
    pytest.importorskip(NEEDS.get(path.stem, "numpy"), reason="the extra that it shows is not installed")
    monkeypatch.chdir(tmp_path)
    printed = io.StringIO()
    with contextlib.redirect_stdout(printed):
        names = runpy.run_path(str(path), run_name="__main__")
    assert names["figure"].axes
    assert agrees(said(path), printed.getvalue()), printed.getvalue()


def test_page_lists_all_examples_by_their_first_lines():
    page = (ROOT / "docs/examples.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| \[`(\w+)\.py`\]\(\.\./examples/(\w+)\.py\) \| (.*) \|$", page, re.MULTILINE)
    first = {path.stem: ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) for path in EXAMPLES}
    assert {name: text for name, _, text in rows} == {name: text.splitlines()[0] for name, text in first.items()}
    assert all(name == script for name, script, _ in rows) and len(rows) == len(EXAMPLES) >= 20
    assert {path.stem for path in EXAMPLES} >= SLOW


def test_every_example_has_a_figure_and_its_picture():
    shown = {path.stem for path in (ROOT / "docs/pictures/examples").glob("*.png")}
    assert shown == {path.stem for path in EXAMPLES}, "python docs/make_example_pictures.py NAME"
