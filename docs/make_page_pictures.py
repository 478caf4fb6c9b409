"""Makes the pictures of the pages: ``python docs/make_page_pictures.py [PAGE ...]`` (or ``make pictures``).

The blocks of a page are run one after the other; below a block with a picture in ``pages`` or ``lessons``, its
``figure`` is written. All other pictures are those of ``make_pictures.py``.
"""

import os
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import matplotlib
from make_notebooks import BLOCK
from make_pictures import png

from mbsd3d.base.paths import write_atomically

DOCS = Path(__file__).parent


def is_own(picture: str) -> bool:
    """True for a picture that a block of its page makes."""
    return Path(picture).parent.name in ("pages", "lessons")


def pictured() -> list[Path]:
    """The pages with a picture right below a block."""
    return [
        page
        for page in sorted(DOCS.rglob("*.md"))
        if any(is_own(picture) for *_, picture in BLOCK.findall(page.read_text(encoding="utf-8")))
    ]


def make(page: Path) -> list[Path]:
    """Write the pictures of a page; their paths. Other files that its blocks write go to the working folder."""
    names, written = {"__name__": page.stem}, []
    for code, _, _, picture in BLOCK.findall(page.read_text(encoding="utf-8")):
        exec(compile(code, page.name, "exec"), names)
        if is_own(picture):
            written.append(write_atomically((page.parent / picture).resolve(), png(names["figure"])))
    return written


if __name__ == "__main__":
    matplotlib.use("agg")
    pages = [Path(name).resolve() for name in sys.argv[1:]] or pictured()
    with TemporaryDirectory() as folder:
        os.chdir(folder)
        for page in pages:
            make(page)
