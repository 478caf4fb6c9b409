"""Prints the docs as one PDF with contents, map and index: ``python docs/make_book.py out/book`` (or ``make book``).

Sphinx makes one HTML page of all pages; a title, the contents, a map of the chapters and an index are put around it,
and Chromium prints it twice: the first print says on which pages the headings stand, the second names them.
"""

import json
import os
import shutil
import subprocess
import sys
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

from bs4 import BeautifulSoup, Tag
from pypdf import PdfReader

from mbsd3d import __version__

DOCS = Path(__file__).parent
BROWSERS = ("chromium", "chromium-browser", "google-chrome")
PRINTING = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-pdf-header-footer",
    "--host-resolver-rules=MAP * ~NOTFOUND", "--generate-pdf-document-outline", "--timeout=600000",
)  # fmt: skip
LEVELS = 3  # of headings in the contents
Numbers = Mapping[str, int]


def browser() -> str:
    """The browser that prints: that named by CHROMIUM, or the first on PATH."""
    names = (os.environ["CHROMIUM"],) if "CHROMIUM" in os.environ else BROWSERS
    found = next(filter(None, map(shutil.which, names)), None)
    if found is None:
        raise SystemExit(f"no browser ({', '.join(names)}): install one (Debian: apt install chromium) or set CHROMIUM")
    return found


def one_page(folder: Path) -> BeautifulSoup:
    """All pages of the docs as one."""
    command = [sys.executable, "-m", "sphinx", "-q", "-b", "singlehtml", "-t", "book", str(DOCS), str(folder)]
    subprocess.run(command, check=True)
    return BeautifulSoup((folder / "index.html").read_text(encoding="utf-8"), "lxml")


def headed(main: Tag) -> list[tuple[int, Tag]]:
    """(level, heading) of all headings that the contents list, each with an address of its own."""
    found = []
    for k, heading in enumerate(main.find_all([f"h{level}" for level in range(1, LEVELS + 1)])):
        heading["id"] = f"heading-{k}"
        for link in heading.find_all("a", class_="headerlink"):
            link.decompose()
        found.append((int(heading.name[1]), heading))
    return found


def line(address: str, text: str, numbers: Numbers, kind: str) -> str:
    """A line of contents or map: a text and its page."""
    page = f'<span class="page">{numbers.get(address, 0)}</span>'
    return f'<a class="{kind}" href="#{address}"><span>{text}</span>{page}</a>'


def contents(headings: list[tuple[int, Tag]], numbers: Numbers) -> str:
    """The contents."""
    lines = (line(str(x["id"]), x.decode_contents(), numbers, f"level{level}") for level, x in headings)
    return f'<nav class="contents"><h1 class="front">Contents</h1>{"".join(lines)}</nav>'


def chapter_map(parts: Mapping[str, list[str]], titles: Mapping[str, str], numbers: Numbers) -> str:
    """A map of all chapters on one page: part -> its pages, each with what belongs to it."""
    boxes = []
    for part, pages in parts.items():
        heads = [page for page in pages if "/" not in page or page.endswith("/index")]
        lines = [
            line(f"document-{page}", titles[page], numbers, "level1" if page in heads else "level2") for page in pages
        ]
        boxes.append(f"<section><h2>{part}</h2>{''.join(lines)}</section>")
    return f'<nav class="map"><h1 class="front">Map</h1><div>{"".join(boxes)}</div></nav>'


def index(entries: Mapping[str, list[str]], numbers: Numbers) -> str:
    """The index: terms by their letters, each with its pages."""
    letters: dict[str, list[str]] = defaultdict(list)
    for term in sorted(entries, key=str.lower):
        places = {numbers[address]: address for address in entries[term] if address in numbers}
        links = ", ".join(f'<a href="#{address}">{page}</a>' for page, address in sorted(places.items()))
        linked = links or ", ".join(f'<a href="#{address}">0</a>' for address in entries[term])
        letters[term[0].upper() if term[0].isalpha() else "0-9"].append(f"<p>{term} {linked}</p>")
    groups = "".join(f"<h2>{letter}</h2>{''.join(lines)}" for letter, lines in letters.items())
    return f'<nav class="index"><h1 class="front" id="the-index">Index</h1><div>{groups}</div></nav>'


def book(page: BeautifulSoup, found: Mapping, numbers: Numbers) -> str:
    """The HTML of the book."""
    main = page.find("div", role="main")
    assert isinstance(main, Tag)
    headings = headed(main)
    styles = "".join(f'<link rel="stylesheet" href="_static/{name}.css">' for name in ("pygments", "book"))
    title = (
        f'<header><h1 class="front">mbsd3d</h1><p>Spatial multibody dynamics</p><p>Version {__version__}</p></header>'
    )
    around = contents(headings, numbers), chapter_map(found["parts"], found["titles"], numbers)
    last = index(found["index"], numbers)
    return (
        f'<!DOCTYPE html><html lang="en"><head><meta charset="utf-8"><title>mbsd3d {__version__}</title>{styles}</head>'
        f"<body>{title}{''.join(around)}<main>{main.decode_contents()}</main>{last}</body></html>"
    )


def printed(html: str, folder: Path) -> Path:
    """Print a page; its PDF."""
    place, pdf = folder / "book.html", folder / "mbsd3d.pdf"
    place.write_text(html, encoding="utf-8")
    command = [browser(), *PRINTING, f"--print-to-pdf={pdf}", place.resolve().as_uri()]
    subprocess.run(command, check=True, stderr=subprocess.DEVNULL)
    return pdf


def numbers_of(pdf: Path) -> dict[str, int]:
    """Address -> page of everything that a link of a PDF leads to."""
    reader = PdfReader(pdf)
    pages = {name.lstrip("/"): reader.get_destination_page_number(x) for name, x in reader.named_destinations.items()}
    return {name: number + 1 for name, number in pages.items() if number is not None}


def make(folder: Path) -> Path:
    """Print the book into a folder."""
    page = one_page(folder)
    found = json.loads((folder / "book.json").read_text(encoding="utf-8"))
    numbers: dict[str, int] = {}
    for _ in range(2):
        pdf = printed(book(page, found, numbers), folder)
        numbers = numbers_of(pdf)
    return pdf


if __name__ == "__main__":
    print(make(Path(sys.argv[1])))
