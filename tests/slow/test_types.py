"""What users write passes a type checker: the examples, README.md and the first pages, by the stubs of the package."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from mbsd3d import __all__ as public

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
PAGES = (
    "README.md",
    "docs/start/first_mechanism.md",
    "docs/how/drivers.md",
    "docs/how/contacts.md",
    "docs/how/stepping.md",
)


def checked(*paths):
    """What mypy says of files; internals of the package are not its concern here."""
    command = [sys.executable, "-m", "mypy", "--follow-imports=silent", "--ignore-missing-imports", "--no-incremental"]
    return subprocess.run([*command, *map(str, paths)], cwd=ROOT, capture_output=True, text=True, timeout=300).stdout


def test_examples_and_pages_have_the_types_they_say(tmp_path):
    for page in PAGES:
        code = re.findall(r"^```python\n(.*?)^```", (ROOT / page).read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
        (tmp_path / f"page_{Path(page).stem}.py").write_text("\n".join(code), encoding="utf-8")
    wrong = tmp_path / "wrong.py"
    wrong.write_text("from mbsd3d import Body, simulate\nsimulate(Body('b', mass='heavy', inertia=1.0), 1.0)\n")
    said = checked(ROOT / "examples", *sorted(tmp_path.glob("*.py")))
    found = {line.split(":")[0] for line in said.splitlines() if ": error:" in line}
    assert {Path(name).name for name in found} == {"wrong.py"}, said  # and the checker sees a mistake


def test_a_type_checker_sees_every_public_name(tmp_path):
    names = [name for name in public if name != "__version__"]
    file = tmp_path / "names.py"
    file.write_text(f"from mbsd3d import {', '.join(names)}\n" + "".join(f"reveal_type({name})\n" for name in names))
    said = re.findall(r'^.*:(\d+): note: Revealed type is "(.*)"$', checked(file), re.MULTILINE)
    assert len(said) == len(names)
    assert [names[int(line) - 2] for line, kind in said if kind == "Any" or "*args: Any" in kind] == []
