"""Makes a notebook of every lesson: ``python docs/make_notebooks.py`` writes docs/notebooks/*.ipynb.

The lessons in docs/teaching/ are what is written by hand, and their blocks run in the tests. A block of Python becomes
a cell with its output and its picture, the text between becomes cells of Markdown.
"""

import base64
import json
import re
from pathlib import Path

DOCS = Path(__file__).parent
PICTURE = r"(?:\s*^!\[([^\]]*)\]\(([^)]+)\)\n)?"
BLOCK = re.compile(r"^```python\n(.*?)^```\n(?:\s*^```text\n(.*?)^```\n)?" + PICTURE, re.DOTALL | re.MULTILINE)


def lines(text: str) -> list[str]:
    """Lines as a notebook stores them."""
    return text.strip("\n").splitlines(keepends=True)


def displayed(said: str, path: Path) -> dict:
    """The output of a cell that shows a picture."""
    data = {"image/png": base64.b64encode(path.read_bytes()).decode(), "text/plain": [said]}
    return {"data": data, "metadata": {}, "output_type": "display_data"}


def notebook(page: str, folder: Path) -> str:
    """The text of a notebook of a page that lies in a folder."""
    cells, at = [], 0
    for block in BLOCK.finditer(page):
        cells.append({"cell_type": "markdown", "metadata": {}, "source": lines(page[at : block.start()])})
        shown = [{"name": "stdout", "output_type": "stream", "text": lines(block[2])}] if block[2] else []
        shown += [displayed(block[3], folder / block[4])] if block[4] else []
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
    return {DOCS / "notebooks" / f"{page.stem}.ipynb": notebook(page.read_text("utf-8"), page.parent) for page in pages}


if __name__ == "__main__":
    (DOCS / "notebooks").mkdir(exist_ok=True)
    for path, text in lessons().items():
        path.write_text(text, encoding="utf-8")
