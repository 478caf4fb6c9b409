"""The pages of docs/: their blocks print what they show, and what they name exists."""

import doctest
import inspect
import json
import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path
from runpy import run_path

import pytest
from helpers.page_blocks import blocks, run

import mbsd3d
from mbsd3d.extend import discover
from validation.cases.examples import JOINTS

DOCS = Path(__file__).parents[2] / "docs"
SLOW = {  # films, sweeps, other engines, compiled functions: a second or more
    "api/bicycle.md", "api/linkages.md", "api/measures.md", "api/results.md", "bicycles.md", "coming_from/exudyn.md",
    "coming_from/mujoco.md", "engines.md", "gallery.md", "how/compare.md", "how/files.md", "how/own_force.md",
    "how/own_method.md", "how/see.md", "how/sweeps.md", "how/tyres.md", "how/uncertainty.md", "teaching/bicycle.md",
}  # fmt: skip
MADE = {DOCS / "examples", DOCS / "gallery"}  # by made_pages.py, when the docs are built
PAGES = {str(path.relative_to(DOCS)): path for path in sorted(DOCS.rglob("*.md")) if path.parent not in MADE}
WITH_BLOCKS = [
    pytest.param(path, id=name, marks=pytest.mark.slow if name in SLOW else ())
    for name, path in PAGES.items()
    if blocks(path)
]
PEERS = {  # pages whose ``py`` blocks need a package that the tests do without
    "coming_from/bicycle_parameters.md": "bicycleparameters",
    "coming_from/drake.md": "pydrake", "coming_from/sympy.md": "sympy", "how/fmus.md": "fmpy",
    "how/see.md": "ipywidgets",
}  # fmt: skip
NEVER_RUN = {"coming_from/chrono.md"}  # no package index has PyChrono
THEORY = sorted((DOCS / "theory").glob("*.md"))
NAME = r"`((?:mbsd3d|validation|bicycle|engines)\.[\w.]+)`"


@pytest.fixture(autouse=True)
def no_figures_left():
    yield
    if "matplotlib.pyplot" in sys.modules:
        sys.modules["matplotlib.pyplot"].close("all")


@pytest.mark.parametrize("page", WITH_BLOCKS)
def test_blocks_of_a_page_print_what_is_shown(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run(page)


@pytest.mark.slow
@pytest.mark.parametrize("name", PEERS)
def test_blocks_of_other_programs_print_what_is_shown(name, tmp_path, monkeypatch):
    pytest.importorskip(PEERS[name], reason=f"{name} is run where it is installed")
    monkeypatch.chdir(tmp_path)
    assert run(PAGES[name], "python|py") > len(blocks(PAGES[name]))


def test_a_picture_of_a_lesson_is_shown_once():
    """It is the value of its cell; what pyplot has open is shown by a notebook anyway."""
    for lesson in sorted((DOCS / "notebooks").glob("*.ipynb")):
        for cell in json.loads(lesson.read_text(encoding="utf-8"))["cells"]:
            if any("image/png" in output.get("data", {}) for output in cell.get("outputs", ())):
                source = "".join(cell["source"])
                last = source.splitlines()[-1]
                assert last == ("plt.show()" if "plt." in source else "figure"), lesson.name


def test_figures_show_themselves_in_a_fresh_process_without_pyplot():
    code = (
        "import sys; from mbsd3d import Body, System, simulate; from mbsd3d.extend import new_figure\n"
        "run = simulate(System([Body('b', 1.0, (1, 2, 3), omega=(1, 2, 3))]), 0.1)\n"
        "with new_figure(3, 2) as (figure, look): figure.subplots()\n"
        "for shown in (run.plot(), run.picture(), figure):\n"
        "    assert shown._repr_png_().startswith(b'\\x89PNG') and 'matplotlib.pyplot' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_blocks_that_are_not_run_say_so():
    for name, page in PAGES.items():
        text = page.read_text(encoding="utf-8")
        assert name in {*PEERS, *NEVER_RUN} or not blocks(page, "py"), name
        for before in re.split(r"^```py\n", text, flags=re.MULTILINE)[:-1]:
            assert re.search(r"\*(Not run|Run once|As above)[^`]*$", before[-400:]), name


def test_sizes_of_the_installation_are_those_of_the_packages():
    found = json.loads((DOCS / "packages.json").read_text(encoding="utf-8"))
    said = re.findall(r"pip install .*: (\d+) MB$", PAGES["start/install.md"].read_text(encoding="utf-8"), re.MULTILINE)
    assert list(map(int, said)) == list(found["MB"].values())
    project = tomllib.loads((DOCS.parent / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert found["dependencies"] == project["dependencies"], "measure again: .ci/packages"


def test_slow_pages_exist():
    assert set(PAGES) >= SLOW


def resolved(name):
    """The object of a dotted name; ImportError or AttributeError if there is none."""
    parts = name.split(".")
    for k in range(len(parts), 0, -1):
        try:
            found = import_module(".".join(parts[:k]))
        except ModuleNotFoundError:
            continue
        for attribute in parts[k:]:
            found = getattr(found, attribute)
        return found
    raise ImportError(name)


@pytest.mark.parametrize("page", THEORY, ids=lambda page: page.stem)
def test_every_equation_names_a_function_that_exists(page):
    text = page.read_text(encoding="utf-8")
    after = re.split(r"^\$\$.*\$\$$", text, flags=re.MULTILINE)[1:]
    for k, rest in enumerate(after):
        assert re.match(rf"\s*\*Computed by\* {NAME}", rest), f"{page.name}: equation {k + 1}"
    for name in re.findall(NAME, text):
        assert callable(resolved(name)), name
    assert after or page.stem == "index"


def public_names():
    """All names that users import, with those of the public modules."""
    for name in mbsd3d.__all__:
        value = getattr(mbsd3d, name)
        if not inspect.ismodule(value):
            yield name
            continue
        for inner in (n for n in getattr(value, "__all__", dir(value)) if not n.startswith("_")):
            twin = inner if inner in mbsd3d.__all__ and getattr(mbsd3d, inner) is getattr(value, inner) else None
            yield twin or f"{name}.{inner}"


API = {name: PAGES[name].read_text(encoding="utf-8") for name in PAGES if name.startswith("api/")}


@pytest.mark.parametrize("name", sorted(set(public_names()) - {"__version__"}))
def test_every_public_name_is_in_the_reference_with_an_example(name):
    pages = [text for text in API.values() if re.search(rf"^\.\. auto\w+:: mbsd3d\.{re.escape(name)}$", text, re.M)]
    assert len(pages) == 1
    examples = "".join(re.findall(r"^```python\n(.*?)^```", pages[0], re.DOTALL | re.MULTILINE))
    used = re.search(rf"\b{name.split('.')[-1]}\b", examples)
    shown = ">>>" in (inspect.getdoc(resolved(f"mbsd3d.{name}")) or "")
    assert used or shown or name == "GROUND"


@pytest.mark.slow
@pytest.mark.parametrize("name", re.findall(r"^\.\. autofunction:: (\S+)$", API["api/bicycle.md"], re.MULTILINE))
def test_every_function_of_the_other_packages_has_an_example_that_runs(name):
    found = resolved(name)
    tests = doctest.DocTestFinder(recurse=False).find(found, name, globs={})
    if any(test.examples for test in tests):
        assert not any(doctest.DocTestRunner().run(test).failed for test in tests)
    else:
        code = "".join(code for code, _ in blocks(PAGES["api/bicycle.md"]))
        assert re.search(rf"\b{name.split('.')[-1]}\(", code)


def test_every_joint_has_its_row_and_picture():
    text = PAGES["how/joints.md"].read_text(encoding="utf-8")
    for joint in JOINTS:
        assert f"| `{joint.__name__}` |" in text and (DOCS / "pictures/joints" / f"{joint.__name__}.png").exists()


def test_every_demo_is_in_the_gallery():
    listed = set(re.findall(r"^\| `(\w+)` \|", PAGES["gallery.md"].read_text(encoding="utf-8"), re.MULTILINE))
    assert listed == set(discover())
    numbers = json.loads((DOCS / "demos.json").read_text(encoding="utf-8"))
    shown = {path.stem for path in (DOCS / "pictures/demos").glob("*.png")}
    assert shown == set(numbers) == listed, "python docs/make_demo_pictures.py NAME"


@pytest.mark.parametrize("page", PAGES.values(), ids=list(PAGES))
def test_links_of_a_page_lead_somewhere(page):
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", text):
        assert target.startswith("http") or (page.parent / target).exists(), target


def test_notebooks_are_those_of_the_lessons():
    texts = run_path(str(DOCS / "make_notebooks.py"))["lessons"]()
    assert set(texts) == set((DOCS / "notebooks").glob("*.ipynb")) and len(texts) >= 5
    for path, text in texts.items():
        assert path.read_text(encoding="utf-8") == text, "make notebooks"
        code = [cell for cell in json.loads(text)["cells"] if cell["cell_type"] == "code"]
        assert len(code) == len(blocks(DOCS / "teaching" / f"{path.stem}.md"))
        assert all(cell["outputs"] for cell in code)


def test_every_lesson_has_its_pictures():
    shown = {
        page: re.findall(r"\]\([./]*pictures/((?:lessons|pages)/\S+)\)", PAGES[page].read_text("utf-8"))
        for page in PAGES
    }
    lessons = [names for page, names in shown.items() if page.startswith("teaching/") and blocks(PAGES[page])]
    assert lessons and all(len(names) >= 2 for names in lessons)
    made = {
        f"{folder}/{path.name}" for folder in ("lessons", "pages") for path in (DOCS / "pictures" / folder).iterdir()
    }
    assert {name for names in shown.values() for name in names} == made


def test_forty_questions_have_a_page():
    text = PAGES["questions.md"].read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\d+) \| .*\]\(([\w/.]+)\) \|$", text, re.MULTILINE)
    assert [int(number) for number, _ in rows] == list(range(1, 41))
    assert {page for _, page in rows} <= set(PAGES)
