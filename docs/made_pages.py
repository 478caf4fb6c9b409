"""Pages of the examples and of the demos, written when the docs are built, into docs/examples/ and docs/gallery/.

A page of an example has its picture, its code, what it prints, and script and notebook to download; one of a demo its
picture, its explanation, its numbers beside theory, and its code. The tables of docs/examples.md and docs/gallery.md
become cards with these pictures.
"""

import ast
import re
import textwrap
from collections.abc import Iterator
from os.path import relpath
from pathlib import Path
from typing import NamedTuple

from make_demo_pictures import numbers
from make_notebooks import notebook

from mbsd3d.base.paths import write_atomically
from mbsd3d.demos import gallery
from mbsd3d.demos.form import Demo
from mbsd3d.demos.parameters import lacking
from mbsd3d.extend import discover
from mbsd3d.report.mathml import mathml

DOCS = Path(__file__).parent
EXAMPLES, SITE = DOCS.parent / "examples", DOCS.parent / "site"
SPELLED = {"Fmpy": "FMPy", "Fmu": "FMU", "Pid": "PID", "Rssr": "RSSR", "fmpy": "FMPy", "pid": "PID"}
ROW = re.compile(r"^\| (?:\[)?`(\w+)(?:\.py)?`.* \| (.*) \|$", re.MULTILINE)
SCRIPT = re.compile(r"\]\(\.\./((?:\.\./)*)examples/(\w+)\.py\)")
TABLE = re.compile(r"^\| (?:script|demo) \|.*\n\|---.*\n((?:\| .*\n)+)", re.MULTILINE)


class Example(NamedTuple):
    """A script of examples/ by its docstring and its code."""

    name: str
    summary: str  # the first line
    text: str  # of the docstring below it, in front of what it prints
    printed: str
    code: str  # below the docstring

    @property
    def title(self) -> str:
        """The name in words."""
        words = self.name.split("_")
        return " ".join(SPELLED.get(word, word) for word in [words[0].capitalize(), *words[1:]])


def read(path: Path) -> Example:
    """A script of examples/."""
    source = path.read_text(encoding="utf-8")
    tree = ast.parse(source)
    said, printed = (ast.get_docstring(tree) or "").split("Prints::\n\n")
    summary, _, text = said.partition("\n")
    code = "\n".join(source.splitlines()[tree.body[0].end_lineno :]).strip("\n") + "\n"
    return Example(path.stem, summary, text.strip(), textwrap.dedent(printed) + "\n", code)


def examples() -> list[Example]:
    """All scripts of examples/."""
    return [read(path) for path in sorted(EXAMPLES.glob("*.py"))]


def shown(folder: str, name: str, what: str) -> str:
    """The picture of a page, if it is there."""
    there = (DOCS / "pictures" / folder / f"{name}.png").exists()
    return f"![{what}](../pictures/{folder}/{name}.png)\n\n" if there else ""


def example_page(found: Example) -> str:
    """The page of an example, as MyST reads it."""
    name = found.name
    return (
        f"# {found.title}\n\n{found.summary}\n\n{found.text}\n\n{shown('examples', name, found.title)}"
        f"It prints:\n\n```text\n{found.printed}```\n\n```{{code-block}} python\n{found.code}```\n\n"
        f"Download: {{download}}`{name}.py <../../examples/{name}.py>`, {{download}}`{name}.ipynb`. "
        f"More [examples](../examples.md).\n"
    )


def example_notebook(found: Example) -> str:
    """The notebook of an example, whose last value is its figure."""
    block = f"```python\n{found.code}figure\n```\n```text\n{found.printed}```\n"
    return notebook(
        f"# {found.title}\n\n{found.summary}\n\n{found.text}\n\n{block}{shown('examples', found.name, found.title)}",
        DOCS / "teaching",  # beside pictures/, as the folder of the pages is
    )


def table_of(demo: Demo) -> str:
    """The numbers of a demo beside theory."""
    lines = (f"| {quantity} | {computed} | {theory} |\n" for quantity, computed, theory in numbers().get(demo.name, ()))
    return "| quantity | computed | theory |\n|---|---|---|\n" + "".join(lines)


def demo_page(demo: Demo, folder: Path) -> str:
    """The page of a demo, as MyST reads it; ``folder`` is that of the HTML page."""
    player = SITE / f"{demo.name}.html"
    seen = f"[Seen in motion, with and without what makes it]({relpath(player, folder)}). " if player.exists() else ""
    parameters = ", ".join(f"`{name}` {value}" for name, value in demo.parameters.items())
    return (
        f"# {demo.title}\n\n{gallery.prose(demo.question)}\n\n{shown('demos', demo.name, demo.title)}"
        f"{gallery.prose(demo.why)}\n\n```{{raw}} html\n<p>{mathml(demo.equation)}</p>\n```\n\n"
        f"{table_of(demo)}\nParameters: {parameters}.\n\n"
        f"{gallery.prose(lacking(demo.ablation.term)).capitalize()}: {gallery.prose(demo.ablation.then)}.\n\n"
        f"{seen}Source: {gallery.prose(demo.source)}.\n\n```sh\n{gallery.command(demo)}\n```\n\n"
        f"````{{only}} not book\n```{{code-block}} python\n{gallery.source_of(demo)}```\n````\n"
    )


def pages(folder: Path) -> Iterator[tuple[Path, str]]:
    """Paths and texts of all pages and notebooks; ``folder`` is that of the HTML pages."""
    for found in examples():
        yield DOCS / "examples" / f"{found.name}.md", example_page(found)
        yield DOCS / "examples" / f"{found.name}.ipynb", example_notebook(found)
    for demo in discover().values():
        yield DOCS / "gallery" / f"{demo.name}.md", demo_page(demo, folder / "gallery")


def write(app) -> None:
    """Write what has changed, and remove pages whose source is gone."""
    wanted = dict(pages(Path(app.outdir)))
    for path, text in wanted.items():
        path.parent.mkdir(exist_ok=True)
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            write_atomically(path, text.encode("utf-8"))
    for gone in {*(DOCS / "examples").iterdir(), *(DOCS / "gallery").iterdir()} - set(wanted):
        gone.unlink()


def cards(table: str, folder: str, pictures: str, titles: dict[str, str]) -> str:
    """The rows of a table as cards that lead to their pages."""
    lines = [":::{container} cards"]
    for name, text in ROW.findall(table):
        there = (DOCS / "pictures" / pictures / f"{name}.png").exists()
        picture = f"![](pictures/{pictures}/{name}.png) " if there else ""
        lines += [f"[{picture}**{titles[name]}** {text}]({folder}/{name}.md)", ""]
    return "\n".join([*lines, ":::", ""])


def whole(name: str) -> str:
    """The name of an object with that of its package."""
    return name if name.split(".")[0] in ("bicycle", "engines", "validation") else f"mbsd3d.{name}"


def linked_pages(app, docname: str, source: list[str]) -> None:
    """The tables of two pages as cards; names in the index of the reference, and scripts of examples/, lead to their
    pages."""
    if docname == "examples":
        titles = {found.name: found.title for found in examples()}
        source[0] = TABLE.sub(lambda table: cards(table[1], "examples", "examples", titles), source[0])
    if docname == "gallery":
        titles = {demo.name: demo.title for demo in discover().values()}
        source[0] = TABLE.sub(lambda table: cards(table[1], "gallery", "demos", titles), source[0])
    if docname == "api/index":
        source[0] = re.sub(r"`([\w.]+)`", lambda name: f"{{py:obj}}`{name[1]} <{whole(name[1])}>`", source[0])
    if not docname.startswith("examples/"):
        source[0] = SCRIPT.sub(r"](\1examples/\2.md)", source[0])


def setup(app) -> dict[str, bool]:
    """Connect to Sphinx."""
    app.connect("builder-inited", write)
    app.connect("source-read", linked_pages)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
