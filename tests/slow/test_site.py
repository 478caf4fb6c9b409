"""The site of docs/ builds without a warning and without network; its search answers the forty questions and more."""

import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import quote

import pytest
from helpers.browser import launch, visit

pytestmark = pytest.mark.slow

DOCS = Path(__file__).parents[2] / "docs"
QUERIES = (  # what a newcomer may type for each of the questions of docs/questions.md
    "install extras",
    "reference pose",
    "quaternion velocity",
    "inertia centre of mass",
    "choose joint",
    "closed loop Denavit",
    "contact rolling",
    "prescribe motion",
    "inverse dynamics",
    "spring damper friction",
    "force table signal",
    "gear tooth bearing life",
    "tyre rider",
    "without mass",
    "spins freely",
    "own force",
    "own joint",
    "own method integrator",
    "certificate error",
    "engine mounts car",
    "redundant",
    "bearing force redundant",
    "stiff",
    "cannot close",
    "assemble angle start",
    "event stop",
    "controller step",
    "frequencies modes",
    "equilibrium preload",
    "sweep ledger",
    "reaction axes",
    "measure distance lean",
    "dataframe csv",
    "film Blender",
    "save load file",
    "MJCF URDF",
    "compare MuJoCo",
    "performance times",
    "equations function",
    "bicycle stable",
)
ASKED = {  # in the words of users of other programs: a page, or the table of terms on that of the questions
    "joint limit end stop": "how/stops",
    "singular Jacobian redundant constraints": "how/redundancy",
    "mass matrix constraint Jacobian": "api/extend",
    "loop drifts apart": "theory/projection",
    "inconsistent initial velocity": "start/when_it_fails",
    "rotor inertia gear ratio": "how/gears",
    "stiction joint friction": "how/forces",
    "flexible beam": "coming_from/exudyn",
    "torque limit saturation": "how/stepping",
    "prescribed base motion shaker": "how/drivers",
    "rope slack cable": "how/ropes",
    "hinge angle several turns": "conventions",
}
SHOWN = 5  # results that one looks at


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", "html", str(DOCS), str(folder)]
    made = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert made.returncode == 0, made.stderr
    return folder


def answers():
    """The pages that answer each question."""
    rows = re.findall(r"^\| \d+ \| .* \| (.*) \|$", (DOCS / "questions.md").read_text(encoding="utf-8"), re.MULTILINE)
    return [re.findall(r"\(([\w/]+)\.md\)", row) for row in rows]


@pytest.fixture(scope="module")
def best(site):
    """The first pages that the search of the site shows for some words."""
    with launch() as browser, visit(browser, site / "search.html") as seen:

        def ask(query):
            seen.page.goto(f"{(site / 'search.html').as_uri()}?q={quote(query)}")
            seen.wait("document.querySelector('#search-results p.search-summary')?.innerText.match(/found|did not/)")
            found = seen.run("[...document.querySelectorAll('ul.search a')].map(a => a.getAttribute('href'))")
            return list(dict.fromkeys(re.sub(r"\.html.*", "", address) for address in found))

        yield ask
        assert not seen.refused


def test_search_finds_the_answers(best):
    lost = [
        (query, pages, found)
        for query, pages in zip(QUERIES, answers(), strict=True)
        if not set(pages) & set((found := [page for page in best(query) if page != "questions"])[:SHOWN])
    ]
    assert not lost, "\n".join(map(str, lost))


def test_search_finds_the_words_of_other_programs(best):
    text = (DOCS / "questions.md").read_text(encoding="utf-8")
    assert all(f"]({page}.md)" in text.split("## Terms of other programs")[1] for page in ASKED.values())
    lost = [
        (query, found) for query, page in ASKED.items() if not {page, "questions"} & set((found := best(query))[:SHOWN])
    ]
    assert not lost, "\n".join(map(str, lost))
