"""Notebooks of the lessons, run anew: in a fresh process each cell shows what is stored with it.

Pyplot is there only where a lesson imports it, as in a kernel.
"""

import base64
import io
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers.page_blocks import agrees
from PIL import Image

NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs" / "notebooks").glob("*.ipynb"))
KERNEL = '''
import ast, base64, contextlib, io, json, sys

def pictures(value):
    """The pictures of a cell: of its last value, and of what pyplot has open, which the kernel shows and closes."""
    if hasattr(value, "_repr_png_"):
        yield value._repr_png_()
    pyplot = sys.modules.get("matplotlib.pyplot")
    figures = [pyplot.figure(number) for number in pyplot.get_fignums()] if pyplot else []
    if pyplot and isinstance(value, pyplot.Figure) and not hasattr(value, "_repr_png_"):
        figures.append(value)
    for figure in figures:
        out = io.BytesIO()
        figure.savefig(out, format="png", bbox_inches="tight")
        yield out.getvalue()
    if pyplot:
        pyplot.close("all")

def run(source, names):
    """Run a cell; what it printed and its pictures."""
    tree, printed, value = ast.parse(source), io.StringIO(), None
    last = tree.body.pop() if isinstance(tree.body[-1], ast.Expr) else None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), names)
        if last:
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    shown = [base64.b64encode(picture).decode() for picture in pictures(value)]
    return {"text": printed.getvalue(), "pictures": shown}

names, cells = {"__name__": "__main__"}, json.load(open(sys.argv[1], encoding="utf-8"))["cells"]
found = [run("".join(cell["source"]), names) for cell in cells if cell["cell_type"] == "code"]
json.dump(found, open("found.json", "w"))
'''
APART = 0.02  # [1] of black to white, mean over a small picture: two figures of one lesson are 0.028 apart, others more


def stored(notebook):
    """(text, picture) that each cell of code shows in a notebook."""
    for cell in json.loads(notebook.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            text = "".join(line for shown in cell["outputs"] for line in shown.get("text", ()))
            yield text, "".join(shown["data"]["image/png"] for shown in cell["outputs"] if "data" in shown)


def small(picture):
    """What is drawn in a picture, without its margins, as a few grey squares (40, 60) between 0 and 1."""
    image = Image.open(io.BytesIO(base64.b64decode(picture))).convert("L")
    drawn = image.crop(image.point(lambda grey: 255 * (grey < 230)).getbbox())
    return np.asarray(drawn.resize((60, 40), Image.Resampling.BOX)) / 255.0


def apart(first, second):
    """Mean difference of two pictures."""
    return np.abs(small(first) - small(second)).mean()


@pytest.mark.slow
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_cells_show_what_is_stored(notebook, tmp_path):
    subprocess.run([sys.executable, "-c", KERNEL, str(notebook)], cwd=tmp_path, check=True)
    found = json.loads((tmp_path / "found.json").read_text())
    for (text, picture), cell in zip(stored(notebook), found, strict=True):
        assert agrees(text, cell["text"]), cell["text"]
        assert len(cell["pictures"]) == bool(picture)
        for again in cell["pictures"]:
            assert apart(picture, again) < APART


def test_ablation_another_picture_is_seen():
    pictures = [picture for notebook in NOTEBOOKS for _, picture in stored(notebook) if picture]
    distances = [apart(a, b) for k, a in enumerate(pictures) for b in pictures[:k]]
    assert len(pictures) > 8 and min(distances) > APART
