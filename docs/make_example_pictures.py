"""Makes the pictures of the examples: ``python docs/make_example_pictures.py [NAME ...]`` (or ``make pictures``).

Each script of examples/ runs once, and its ``figure`` becomes ``docs/pictures/examples/NAME.png``.
"""

import os
import sys
from collections.abc import Iterable
from pathlib import Path
from runpy import run_path
from tempfile import TemporaryDirectory

import matplotlib
from make_pictures import png

from mbsd3d.base.paths import write_atomically

EXAMPLES, PICTURES = Path(__file__).parents[1] / "examples", Path(__file__).parent / "pictures" / "examples"


def make(names: Iterable[str]) -> None:
    """Run some examples, and write their pictures. Other files that they write go to a folder that vanishes."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    home = Path.cwd()
    with TemporaryDirectory() as folder:
        os.chdir(folder)
        for name in names:
            write_atomically(PICTURES / f"{name}.png", png(run_path(str(EXAMPLES / f"{name}.py"))["figure"]))
        os.chdir(home)


if __name__ == "__main__":
    matplotlib.use("agg")
    make(sys.argv[1:] or sorted(path.stem for path in EXAMPLES.glob("*.py")))
