"""Makes the pictures of the lessons: ``python docs/make_lesson_pictures.py`` (or ``make pictures``).

The blocks of a lesson are run one after the other; below a block that names a picture, its ``figure`` is written.
"""

from pathlib import Path

import matplotlib
from make_notebooks import BLOCK
from make_pictures import png

from mbsd3d.base.paths import write_atomically

DOCS = Path(__file__).parent


def make(page: Path) -> list[Path]:
    """Write the pictures of a lesson; their paths."""
    names, written = {"__name__": page.stem}, []
    for code, _, _, picture in BLOCK.findall(page.read_text(encoding="utf-8")):
        exec(compile(code, page.name, "exec"), names)
        if picture:
            written.append(write_atomically((page.parent / picture).resolve(), png(names["figure"])))
    return written


if __name__ == "__main__":
    matplotlib.use("agg")
    (DOCS / "pictures" / "lessons").mkdir(exist_ok=True)
    for page in sorted((DOCS / "teaching").glob("*.md")):
        make(page)
