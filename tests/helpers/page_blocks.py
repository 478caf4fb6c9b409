"""Blocks of a page and what they print: a ```python block runs, the ```text block below it is its output."""

import contextlib
import io
import re
from pathlib import Path

NUMBER = r"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?(?![\w.]*\w)"
ROUNDING = 1e-12  # sizes below it are rounding, which differs between machines


def blocks(page: Path, fences: str = "python") -> list[tuple[str, str]]:
    """(code, what it prints) of all Python blocks of a page; ``py`` fences are those that need what is not required."""
    text = page.read_text(encoding="utf-8")
    block = rf"^```(?:{fences})\n(.*?)^```\n(?:\s*^```text\n(.*?)^```\n)?"
    return re.findall(block, text, re.DOTALL | re.MULTILINE)


def run(page: Path, fences: str = "python") -> int:
    """Run the blocks of a page one after the other, compare what they print; their number."""
    found, names = blocks(page, fences), {"__name__": page.stem}
    for code, shown in found:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, page.name, "exec"), names)
        text = printed.getvalue()
        assert agrees(shown, text), f"{page.name} shows\n{shown}\nbut\n{code}\nprints\n{text}"
    return len(found)


def close(shown, found):
    """Equal to one unit of the last digit shown; whole numbers without exponent exactly."""
    mantissa, _, exponent = shown.lower().partition("e")
    if "." not in mantissa and not exponent:
        return shown.lstrip("+") == found.lstrip("+") or float(shown) == float(found)
    unit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    return abs(float(shown) - float(found)) <= 1.001 * unit


def similar(shown, found):
    """The same size within a factor of ten, rounding apart: what can be asked of errors and counts."""
    shown, found = abs(float(shown)), abs(float(found))
    return max(shown, found) < ROUNDING or shown / 10 <= found <= 10 * shown or (shown < ROUNDING and found < 1e-10)


def line_agrees(shown, found, agree):
    """One line: the words are equal, ``...`` stands for any text, numbers agree."""
    pattern, at = "", 0
    for number in re.finditer(NUMBER, shown):
        pattern += words(shown[at : number.start()]) + f"({NUMBER})"
        at = number.end()
    match = re.fullmatch(pattern + words(shown[at:]) + r"\s*", found)
    numbers = re.findall(NUMBER, shown)
    return bool(match) and all(agree(a, b) for a, b in zip(numbers, match.groups(), strict=True))


def words(text):
    """Pattern of a text without numbers: any white space for white space, anything for ``...``."""
    pieces = [r"\s*".join(re.escape(word) for word in piece.split()) for piece in text.split("...")]
    return r"\s*" + ".*?".join(pieces) + r"\s*"


def agrees(shown, found):
    """All lines in order; a line ``...`` stands for any number of lines. A certificate's figures only by size."""
    agree = similar if shown.startswith(("passed:", "FAILED:")) else close
    wanted, lines, free = shown.splitlines(), found.splitlines(), False
    for line in wanted:
        if line.strip() == "...":
            free = True
            continue
        while free and lines and not line_agrees(line, lines[0], agree):
            lines.pop(0)
        if not lines or not line_agrees(line, lines.pop(0), agree):
            return False
        free = False
    return free or not lines
