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
SLOW = {"bicycle_with_rider", "clock_escapement", "geneva", "gyro_monorail", "valve_train"}


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
        runpy.run_path(str(path), run_name="__main__")
    assert agrees(said(path), printed.getvalue()), printed.getvalue()


def test_page_lists_all_examples():
    page = (ROOT / "docs/examples.md").read_text(encoding="utf-8")
    assert re.findall(r"^\| `(\w+)\.py` \|", page, re.MULTILINE) == [path.stem for path in EXAMPLES]
    assert len(EXAMPLES) >= 20 and {path.stem for path in EXAMPLES} >= SLOW
