"""Every kind of page is clean by axe, on white paper on a screen and on dark paper on a phone."""

import subprocess
import sys
from pathlib import Path

import pytest
from helpers.browser import launch, missing, visit

pytestmark = pytest.mark.slow

MODEL = """from mbsd3d import *

def build(mass=2.0):
    arm = Body("arm", mass, (0.1, 0.1, 0.12), position=(0.3, 0, 0))
    return System([arm], [Revolute(GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")])
"""
WHY = """from mbsd3d import explain
from model import build

explain(build(), lambda run: {"x": run.position("arm")[-1, 0]}, run={"t_end": 0.5}).page("why.html")
"""
COMMANDS = (
    ("run", "model.py", "--t-end", "1", "--view", "--report", "--out", "."),
    ("validate", "model.py", "--t-end", "1", "--html", "cross.html"),
    ("validate", "--case", "bicycle_M1", "--out", "cases"),
    ("gallery", "heavy_top", "barrel_cam", "no_hands", "--out", "site"),
    ("nvh", "inline_4", "--rpm", "3000", "--page", "."),
    ("bicycle", "compare", "Browserins", "Rigid", "--out", "."),
)
RUN_AXE = """async () => (await axe.run(document, {iframes: false})).violations.map(
  (found) => [found.id, found.help, ...found.nodes.slice(0, 3).map((node) => node.html.slice(0, 200))])"""

LOADED = "document.readyState === 'complete' && !document.querySelector('[role=progressbar]')"


@pytest.fixture(scope="module")
def axe():
    """The script of axe, as the package of the tests brings it."""
    try:
        import axe_playwright_python
    except ImportError:
        missing("the tests of pages need the package axe-playwright-python; install it: pip install mbsd3d[test]")
    return Path(axe_playwright_python.__file__).with_name("axe.min.js").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """One page of each kind, as the commands write them."""
    folder = tmp_path_factory.mktemp("pages")
    (folder / "model.py").write_text(MODEL)
    (folder / "why.py").write_text(WHY)
    program = [sys.executable, "-m", "mbsd3d"]
    for command in [[*program, *words] for words in COMMANDS] + [[sys.executable, "why.py"]]:
        made = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
        assert made.returncode == 0, (command, made.stderr)
    return sorted(folder.rglob("*.html"))


def test_axe_finds_nothing(pages, axe):
    assert len(pages) >= 12
    found = []
    with launch() as browser:
        for page in pages:
            for paper, width in (("light", 1400), ("dark", 420)):
                with visit(browser, page, width=width, height=900, color_scheme=paper) as seen:
                    seen.wait(LOADED)
                    seen.run(axe)
                    found += [(page.name, paper, width, *each) for each in seen.run(RUN_AXE)]
    assert not found, "\n".join(map(str, found))
