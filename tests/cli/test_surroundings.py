"""The command line where others have it: without optional packages, in another language, on a narrow terminal."""

import json
import os
import re
import shutil
import subprocess
import sys
from dataclasses import asdict

import pytest
from click.testing import CliRunner
from helpers.scripts import PENDULUM

from bicycle import Meijaard2007
from mbsd3d.extend import main

OPTIONAL = ("viser", "pygltflib", "mujoco", "exudyn", "distributed", "dask", "imageio_ffmpeg")
NARROW = 20  # columns
NAMED = PENDULUM.replace('"bob"', '"Räder Ω"')
HANGING = """<mujoco><worldbody><body name="bob"><joint name="hinge" axis="0 1 0"/>
<inertial mass="2" pos="0 0 -0.6" diaginertia="0.1 0.1 0.02"/></body></worldbody></mujoco>"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "model.py").write_text(NAMED, encoding="utf-8")
    (tmp_path / "hanging.xml").write_text(HANGING)
    return tmp_path


ONE = "from mbsd3d.cli import main\nmain(sys.argv[1:], prog_name='mbsd3d')"


def called(*arguments, code=ONE, **environment):
    """A command in a process of its own, or other code with its arguments."""
    settings = {key: value for key, value in os.environ.items() if key not in ("LANG", "LC_ALL", "LC_CTYPE")}
    return subprocess.run(
        [sys.executable, "-c", f"import sys\n{code}", *arguments], env=settings | environment, capture_output=True,
        encoding="utf-8", timeout=600,
    )  # fmt: skip


VIEW = r"needs viser .*; install it: pip install"
BARE = {  # command: (exit code, last line on stderr); None: it works
    ("check", "model.py"): None,
    ("run", "model.py", "--t-end", "0.1"): None,
    ("validate", "model.py", "--budget", "1"): None,
    ("bicycle", "stability"): None,
    ("bicycle", "frequency"): None,
    ("bicycle", "sensitivity"): None,
    ("nvh", "inline_4"): None,
    ("demo", "dzhanibekov"): None,
    ("demo", "--list"): None,
    ("doctor",): None,
    ("warmup",): None,
    ("show", "model.py"): VIEW,
    ("play", "model.py"): VIEW,
    ("run", "model.py", "--view"): VIEW,
    ("demo", "cardan", "--view"): VIEW,
    ("gallery", "cardan"): VIEW,
    ("bicycle", "compare"): VIEW,
    ("bicycle", "circles", "--view"): VIEW,
    ("nvh", "inline_4", "--page", "out"): VIEW,
    ("check", "hanging.xml"): r"needs the package mujoco .*; install it: pip install 'mbsd3d\[import\]'",
}


ALL = """
import json
from click.testing import CliRunner
from mbsd3d.cli import main
commands = json.loads(sys.argv[1])
done = [CliRunner().invoke(main, command) for command in commands]
print(json.dumps([(x.exit_code, (x.stderr.splitlines() or [""])[-1], repr(x.exception)) for x in done]))
"""


@pytest.mark.slow
def test_without_optional_packages_a_command_works_or_says_what_it_needs(folder):
    stubs = folder / "stubs"
    stubs.mkdir()
    for name in OPTIONAL:
        (stubs / f"{name}.py").write_text(f'raise ModuleNotFoundError("No module named {name}", name="{name}")')
    done = called(json.dumps(list(BARE)), code=ALL, PYTHONPATH=str(stubs))
    wrong = []
    for (arguments, needs), found in zip(BARE.items(), json.loads(done.stdout), strict=True):
        code, said, error = found
        right = code == 0 if needs is None else code == 2 and re.search(needs, said)
        wrong += [] if right else [f"{' '.join(arguments)}: {code}, {said or error}"]
    assert not wrong, "\n".join(wrong)


GERMAN = "import locale; locale.setlocale(locale.LC_ALL, 'de_DE.UTF-8'); assert locale.str(1.5) == '1,5'\n"


@pytest.fixture
def german(tmp_path):
    """Variables of a language with a decimal comma."""
    program = shutil.which("localedef")
    if program is None:
        pytest.skip("no localedef to make a locale with")
    (tmp_path / "locales").mkdir()
    made = [program, "-i", "de_DE", "-f", "UTF-8", str(tmp_path / "locales" / "de_DE.UTF-8")]
    if subprocess.run(made, capture_output=True).returncode:
        pytest.skip("the sources of locales are not installed")
    return {"LOCPATH": str(tmp_path / "locales"), "LC_ALL": "de_DE.UTF-8"}


@pytest.mark.slow
def test_numbers_keep_their_point_where_people_write_a_comma(folder, german):
    values = [f"  {key}: {value!r}" for key, value in asdict(Meijaard2007()).items() if isinstance(value, float)]
    (folder / "mine.yml").write_text("\n".join(["parameterization: benchmark", "values:", *values]))
    commands = [("run", "model.py", "--t-end", "0.1"), ("bicycle", "stability", "mine.yml"), ("check", "hanging.xml")]
    for arguments in commands:
        out = () if arguments[0] == "check" else ("--out", "here")
        abroad = () if arguments[0] == "check" else ("--out", "abroad")
        first, second = called(*arguments, *out), called(*arguments, *abroad, code=GERMAN + ONE, **german)
        assert first.returncode == second.returncode == 0, second.stderr
    names = sorted(path.name for path in (folder / "here").iterdir() if path.suffix in (".csv", ".svg"))
    assert len(names) == 4
    for name in names:
        assert (folder / "here" / name).read_bytes() == (folder / "abroad" / name).read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize(
    "settings",
    [{"LC_ALL": "C"}, {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}],
    ids=["C", "ascii"],
)
def test_names_of_other_alphabets_go_to_plain_terminals(folder, settings):
    done = called("run", "model.py", "--t-end", "0.1", "--out", "out", **settings)
    assert done.returncode == 0, done.stderr
    assert "Räder Ω" in (folder / "out" / "model.csv").read_text(encoding="utf-8").splitlines()[0]


@pytest.mark.parametrize("name", sorted(main.list_commands(None)))
def test_help_fits_a_narrow_terminal(name, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(NARROW))
    done = CliRunner().invoke(main, [name, "--help"], terminal_width=NARROW)
    assert done.exit_code == 0 and done.output.startswith("Usage: ")
