"""README.md: its blocks print what it shows; files and commands named in all texts exist; docstring examples run."""

import doctest
import pkgutil
import re
from importlib import import_module
from pathlib import Path

import pytest
from click.testing import CliRunner
from helpers.page_blocks import agrees, run

import mbsd3d
from mbsd3d.extend import main

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text(encoding="utf-8")
TEXTS = [README, *((ROOT / name).read_text(encoding="utf-8") for name in ("CONTRIBUTING.md", "ARCHITECTURE.md"))]
TEXTS += [page.read_text(encoding="utf-8") for page in sorted((ROOT / "docs").rglob("*.md"))]
PATHS = sorted(set(re.findall(r"`((?:mbsd3d|tests|validation|bicycle|engines|docs)/[\w./]+)`", "".join(TEXTS))))
SHELL = "".join(block for text in TEXTS for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL))
COMMANDS = sorted(set(re.findall(r"^mbsd3d (\w+)", SHELL, re.MULTILINE)))
MODULES = ["mbsd3d", *(module.name for module in pkgutil.walk_packages(mbsd3d.__path__, "mbsd3d."))]


def test_blocks_print_what_is_shown(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(ROOT / "README.md") >= 3


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


def test_readme_is_one_page_and_its_links_lead_somewhere():
    assert README.count("\n") <= 150
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (ROOT / target).exists(), target


def test_readme_opens_with_the_two_commands():
    first = re.search(r"```sh\n(.*?)```", README, re.DOTALL).group(1)
    assert [line.split("#")[0].split() for line in first.splitlines()] == [["make", "demo"], ["make", "test"]]


@pytest.mark.parametrize("path", PATHS)
def test_files_named_in_the_texts_exist(path):
    assert (ROOT / path).exists()


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_of_the_texts_exist(command):
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
