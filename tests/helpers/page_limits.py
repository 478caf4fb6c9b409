"""Limits that the pages promise: a test that holds one reads it from the page, so that no page can promise more."""

import re
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def limits(page: str, words: str) -> list[float]:
    """The numbers in the second column of the row of a page's table that starts with these words."""
    text = (DOCS / page).read_text(encoding="utf-8")
    (cell,) = re.findall(rf"^\| {re.escape(words)}[^|]*\| ([^|]*) \|$", text, re.MULTILINE)
    return [float(number) for number in re.findall(r"(?<![\w.])\d+(?:\.\d+)?(?:e-?\d+)?(?![\w.])", cell)]
