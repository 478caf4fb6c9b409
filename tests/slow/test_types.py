"""What users write passes a type checker: the examples, README.md and the first pages, by the stubs of the package."""

import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

import bicycle
import mbsd3d
import validation
from mbsd3d import extend

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
PAGES = (
    "README.md",
    "docs/api/bicycle.md",
    "docs/how/own_joint.md",
    "docs/start/first_mechanism.md",
    "docs/how/drivers.md",
    "docs/how/contacts.md",
    "docs/how/stepping.md",
)


PACKAGES = (mbsd3d, extend, bicycle, validation)


def public_names(package):
    """Dotted names of what users import, with what of ours is in public modules and the methods of the facades."""
    for name in package.__all__:
        value, inner = getattr(package, name), []
        if inspect.ismodule(value) and hasattr(value, "__all__"):
            inner = value.__all__  # a topic of mbsd3d.extend
        elif inspect.ismodule(value):
            homes = {x: getattr(thing, "__module__", "mbsd3d") for x, thing in vars(value).items()}
            inner = [x for x, home in homes.items() if home.startswith(tuple(top.__name__ for top in PACKAGES))]
        elif name in ("System", "Solution", "Stepper"):
            inner = dir(value)
        whole = f"{package.__name__}.{name}"
        yield from (f"{whole}.{x}" for x in inner if not x.startswith("_")) if inner else [whole]


NAMES = [name for package in PACKAGES for name in public_names(package) if not name.endswith("__version__")]


@pytest.fixture(scope="module")
def said(tmp_path_factory):
    """What mypy says of examples, pages, a mistake and all names, once; internals are not its concern here."""
    folder = tmp_path_factory.mktemp("typed")
    for page in PAGES:
        code = re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
        (folder / f"page_{Path(page).stem}.py").write_text("\n".join(code), encoding="utf-8")
    wrong = "from mbsd3d import Body, simulate\nsimulate(Body('b', mass='heavy', inertia=1.0), 1.0)\n"
    (folder / "wrong.py").write_text(wrong, encoding="utf-8")
    asked = ["import bicycle, mbsd3d.extend, validation", *(f"reveal_type({name})" for name in NAMES)]
    (folder / "names.py").write_text("\n".join(asked), encoding="utf-8")
    command = [sys.executable, "-m", "mypy", "--follow-imports=silent", "--ignore-missing-imports", "--no-incremental"]
    files = map(str, (ROOT / "examples", *sorted(folder.glob("*.py"))))
    return subprocess.run([*command, *files], cwd=ROOT, capture_output=True, text=True, timeout=300).stdout


def test_examples_and_pages_have_the_types_they_say(said):
    found = [line for line in said.splitlines() if ": error:" in line]
    assert {Path(line.split(":")[0]).name for line in found} == {"wrong.py"}, found  # the checker sees a mistake,
    assert len(found) == 2, found  # in each of both calls


def test_a_type_checker_sees_every_public_name(said):
    kinds = dict(re.findall(r'^.*names.py:(\d+): note: Revealed type is "(.*)"$', said, re.MULTILINE))
    assert len(kinds) == len(NAMES) > 150
    loose = [name for name, kind in zip(NAMES, kinds.values(), strict=True) if kind == "Any" or "*args: Any" in kind]
    assert loose == []
