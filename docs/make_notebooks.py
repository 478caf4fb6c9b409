"""Makes a notebook of every lesson: ``python docs/make_notebooks.py`` writes docs/notebooks/*.ipynb.

The lessons in docs/teaching/ are what is written by hand, and their blocks run in the tests. A block of Python becomes
a cell with its output, the text between becomes cells of Markdown.
"""

import json
import re
from pathlib import Path

DOCS = Path(__file__).parent
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\s*^```text\n(.*?)^```\n)?", re.DOTALL | re.MULTILINE)


def lines(text: str) -> list[str]:
    """Lines as a notebook stores them."""
    return text.strip("\n").splitlines(keepends=True)


def notebook(page: str) -> str:
    """The text of a notebook of a page."""
    cells, at = [], 0
    for block in BLOCK.finditer(page):
        cells.append({"cell_type": "markdown", "metadata": {}, "source": lines(page[at : block.start()])})
        shown = [{"name": "stdout", "output_type": "stream", "text": lines(block[2])}] if block[2] else []
        cells.append({
            "cell_type": "code", "execution_count": None, "metadata": {}, "outputs": shown, "source": lines(block[1]),
        })  # fmt: skip
        at = block.end()
    cells.append({"cell_type": "markdown", "metadata": {}, "source": lines(page[at:])})
    for k, cell in enumerate(cells):
        cell["id"] = f"cell-{k}"
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    data = {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
    return json.dumps(data, indent=1, ensure_ascii=False) + "\n"


def lessons() -> dict[Path, str]:
    """Notebook -> its text, of all lessons."""
    pages = [page for page in sorted((DOCS / "teaching").glob("*.md")) if page.stem != "index"]
    return {DOCS / "notebooks" / f"{page.stem}.ipynb": notebook(page.read_text(encoding="utf-8")) for page in pages}


if __name__ == "__main__":
    (DOCS / "notebooks").mkdir(exist_ok=True)
    for path, text in lessons().items():
        path.write_text(text, encoding="utf-8")
