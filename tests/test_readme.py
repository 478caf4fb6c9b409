"""README.md: its blocks print what it shows, its commands and files exist; and the examples of all docstrings run."""

import contextlib
import doctest
import io
import pkgutil
import re
from importlib import import_module
from pathlib import Path

import pytest
from click.testing import CliRunner

import mbsd3d
from mbsd3d.cli import main

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
NUMBER = r"(?<![\w.])[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?(?![\w.]*\w)"
ROUNDING = 1e-12  # sizes below it are rounding, which differs between machines

BLOCKS = re.findall(r"^```python\n(.*?)^```\n(?:^```text\n(.*?)^```\n)?", README, re.DOTALL | re.MULTILINE)
PATHS = sorted(set(re.findall(r"`((?:mbsd3d|tests|validation)/[\w./]*|\w+\.(?:md|toml|txt))`", README)))
COMMANDS = sorted(set(re.findall(r"mbsd3d (\w+)", "".join(re.findall(r"```sh\n(.*?)```", README, re.DOTALL)))))
MODULES = ["mbsd3d", *(module.name for module in pkgutil.walk_packages(mbsd3d.__path__, "mbsd3d."))]


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


def test_blocks_print_what_is_shown(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for code, shown in BLOCKS:
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            exec(compile(code, "README.md", "exec"), names)
        assert agrees(shown, printed.getvalue()), f"README.md shows\n{shown}\nbut\n{code}\nprints\n{printed.getvalue()}"
    assert len(BLOCKS) >= 5 and all(shown for _, shown in BLOCKS)


def test_comparison_sees_a_digit_a_word_and_a_line():
    shown = "ratio 1.3333, motor 6.12e-3 N\n  rank 5\n...\nend"
    assert agrees(shown, "ratio 1.33333333, motor  0.006121 N\n rank 5\nmore\nend")
    assert agrees("a ... s\n", "a 0.3 s\n") and agrees("...", "") and agrees("[ 1.5 -2. ]", "[1.5 -2.0]")
    for wrong in ("1.3335", "1.3331", "-1.3333"):
        assert not agrees(shown, f"ratio {wrong}, motor 6.12e-3 N\n  rank 5\nend")
    assert not agrees(shown, "ratio 1.3333, motor 6.12e-3 N\n  rank 6\nend")
    assert not agrees(shown, "ratio 1.3333, motor 6.12e-3 N m\n  rank 5\nend")
    assert not agrees(shown, "ratio 1.3333, motor 6.12e-3 N\n  rank 5\nend\nmore")


def test_comparison_of_certificates_sees_sizes_and_verdicts():
    shown = "passed: x, 319 steps\n  ok   energy  4.8e-10 (limit 1e-05)\n  ok   gaps  5e-16 (limit 2e-12)"
    assert agrees(shown, "passed: x, 330 steps\n  ok   energy  1.0e-09 (limit 1e-05)\n  ok gaps 3e-15 (limit 2e-12)")
    assert not agrees(shown, shown.replace("4.8e-10", "4.8e-08"))
    assert not agrees(shown, shown.replace("5e-16", "5e-09"))
    assert not agrees(shown, shown.replace("  ok   energy", "  FAIL energy"))


def test_readme_opens_with_the_two_commands():
    first = re.search(r"```sh\n(.*?)```", README, re.DOTALL).group(1)
    assert [line.split("#")[0].split() for line in first.splitlines()] == [["make", "demo"], ["make", "test"]]


@pytest.mark.parametrize("path", PATHS)
def test_files_named_in_the_readme_exist(path):
    assert (ROOT / path).exists()


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_of_the_readme_exist(command):
    assert CliRunner().invoke(main, [command, "--help"]).exit_code == 0


@pytest.mark.parametrize("name", MODULES)
def test_examples_of_docstrings(name):
    assert doctest.testmod(import_module(name)).failed == 0


def test_there_are_examples_of_docstrings():
    finder = doctest.DocTestFinder(exclude_empty=True)
    found = [test for name in MODULES for test in finder.find(import_module(name)) if test.examples]
    assert len(found) >= 15
    assert {
        "mbsd3d.api.system.System",
        "mbsd3d.mechanism.joints.pairs.Revolute",
        "mbsd3d.mechanism.signals.curves.Table",
    } <= {test.name for test in found}
