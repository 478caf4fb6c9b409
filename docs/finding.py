"""What search and index find beside the words of a page: terms of other programs, and excerpts without a server.

The one list of terms is in two places, each read here: the table at the end of docs/questions.md (topics and their
pages) and ``NAMES_ELSEWHERE`` of mbsd3d/lazy.py (names of classes, which Python tells too).
"""

import json
import re
from collections import defaultdict
from functools import cache
from pathlib import Path
from posixpath import normpath

from docutils import nodes
from sphinx import addnodes
from sphinx.transforms import SphinxTransform

from mbsd3d.lazy import NAMES_ELSEWHERE

DOCS = Path(__file__).parent
QUESTIONS = DOCS / "questions.md"
LINK = re.compile(r"\]\((?:\.\./)?([\w/]+)\.(?:md|py)(?:#([\w-]+))?\)")  # a script of examples/ has its page
COLLECTIONS = ("examples", "gallery")  # whose pages are not on the map of the book


def topics() -> dict[str, list[tuple[str, str]]]:
    """Term -> (page, anchor) of each page that the table of docs/questions.md names."""
    _, _, table = QUESTIONS.read_text(encoding="utf-8").partition("## Terms of other programs\n")
    found: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for terms, answer in re.findall(r"^\| (.*?) \| (.*) \|$", table, re.MULTILINE):
        for term in re.split(r", (?:and )?", terms.replace("`", "")):
            found[term] += [(page, anchor) for page, anchor in LINK.findall(answer)]
    return {term: places for term, places in found.items() if places}


def names() -> dict[str, list[tuple[str, str]]]:
    """Name in other programs -> (page, anchor) of what it is called here."""
    documented = {}
    for page in sorted((DOCS / "api").glob("*.md")):
        for name in re.findall(r"^\.\. auto\w+:: mbsd3d\.([\w.]+)$", page.read_text(encoding="utf-8"), re.MULTILINE):
            documented[name] = (f"api/{page.stem}", f"mbsd3d.{name}")
    found = {
        other: [documented[name] for name in re.findall(r"\w+", own) if name in documented]
        for other, own in NAMES_ELSEWHERE.items()
    }
    return {other: places for other, places in found.items() if places}


@cache
def entries() -> dict[str, list[tuple[str, str]]]:
    """Page -> its (term, anchor)."""
    by_page: dict[str, list[tuple[str, str]]] = defaultdict(list)
    for term, places in (*topics().items(), *names().items()):
        for page, anchor in dict.fromkeys(places):
            by_page[normpath(page)].append((term, anchor))
    return by_page


class Terms(SphinxTransform):
    """Gives a page its entries in the index, where the search finds them too."""

    default_priority = 700  # before the domains collect

    def apply(self) -> None:
        """Put the entries in front of the page."""
        found = entries().get(self.env.docname, ())
        if found and self.document.children:
            kept = [("single", term.replace(";", ","), anchor, "main", None) for term, anchor in found]
            self.document.insert(0, addnodes.index(entries=kept))


def text_of(doctree: nodes.document) -> str:
    """The words of a page."""
    return " ".join(doctree.astext().split())


def excerpts(app, error: Exception | None) -> None:
    """Write the words of all pages, for a search page that is opened as a file and may fetch nothing."""
    if error is None and app.builder.name == "html":
        words = {page: text_of(app.env.get_doctree(page)) for page in sorted(app.env.found_docs)}
        path = Path(app.outdir) / "_static" / "excerpts.js"
        path.write_text(f"window.EXCERPTS = {json.dumps(words, ensure_ascii=False)};\n", encoding="utf-8")


def for_the_book(app, error: Exception | None) -> None:
    """Write what the book needs of the pages: the parts with their pages, all titles, the addresses of the index."""
    if error is not None or app.builder.name != "singlehtml":
        return
    titles = {page: title.astext() for page, title in app.env.titles.items()}
    root = app.env.get_doctree(app.config.root_doc)
    parts = {}
    for tree in root.findall(addnodes.toctree):
        pages = [page for _, page in tree["entries"]]
        parts[tree["caption"]] = [
            y for x in pages for y in (x, *(() if x in COLLECTIONS else app.env.toctree_includes.get(x, ())))
        ]
    index: dict[str, set[str]] = defaultdict(set)
    for page, found in app.env.domaindata["index"]["entries"].items():
        for kind, value, anchor, *_ in found:
            if kind == "single":
                index[value.replace("; ", ", ")].add(anchor or f"document-{page}")
    kept = {"parts": parts, "titles": titles, "index": {term: sorted(places) for term, places in index.items()}}
    (Path(app.outdir) / "book.json").write_text(json.dumps(kept), encoding="utf-8")


def setup(app) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.add_transform(Terms)
    app.connect("build-finished", excerpts)
    app.connect("build-finished", for_the_book)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
