"""Parameters of build(...) on the command line, methods by name, versions, and lines of progress in a pipe."""

import io
import re
import subprocess
import sys

import pytest
from click.testing import CliRunner

from mbsd3d import __version__, load
from mbsd3d.base import progress
from mbsd3d.extend import main

MODEL = """
from mbsd3d import GROUND, Body, Revolute, System


def build(length: float, heavy=False, label="swing", count: int = 2):
    mass = 5.0 if heavy else 1.0
    bob = Body("bob", mass, (0.1, 0.1, 0.1), position=(0.3, 0, -length))
    return System([bob], [Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0))], name=label)
"""


@pytest.fixture
def model(tmp_path):
    path = tmp_path / "swing.py"
    path.write_text(MODEL)
    return str(path)


def call(*words):
    return CliRunner().invoke(main, [str(word) for word in words])


def test_parameters_are_typed_and_used(model, tmp_path):
    done = call("run", model, "--t-end", 0.1, "--set", "length=0.5", "--set", "heavy=yes", "--set", "label=3",
                "--method", "RK4", "--dt", 0.01, "--out", tmp_path / "out")  # fmt: skip
    assert done.exit_code == 0, done.output
    found = load(tmp_path / "out" / "swing.npz")
    body = found.system.bodies[0]
    assert body.position[2] == -0.5 and body.mass == 5.0 and found.system.title == "3"
    assert str(found.record.method) == "RK4(dt=0.01)" and found.record.steps == 10
    assert call("check", model, "--set", "length=0.5").exit_code == 0


def test_parameters_are_listed(model):
    lines = call("run", model, "--help-parameters").output.splitlines()
    assert lines == [
        "length: float, required", "heavy: bool, default False", "label: str, default 'swing'", "count: int, default 2",
    ]  # fmt: skip
    for command in ("check", "show", "play"):
        assert call(command, model, "--help-parameters").output.splitlines() == lines


def test_what_is_drawn_takes_the_parameters_that_build_needs(model, tmp_path):
    assert "give --set length=VALUE" in call("show", model, "--out", tmp_path).output
    assert call("show", model, "--set", "length=0.5", "--out", tmp_path).output == f"{tmp_path / 'swing.html'}\n"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ((), r"build\(\) needs length; give --set length=VALUE. It takes length: float, required; heavy"),
        (("--set", "lenght=1"), "no such parameter, did you mean 'length'"),
        (("--set", "tilt=1"), "has no such parameter; build"),
        (("--set", "length=1", "--set", "length=2"), "--set length is given twice; give it once"),
        (("--set", "length"), "'length': give NAME=VALUE"),
        (("--set", "length=x"), "length='x' is not a float"),
        (("--set", "length=1", "--set", "count=1.5"), "count='1.5' is not an int"),
        (("--set", "length=1", "--set", "heavy=perhaps"), "heavy='perhaps' is not true or false"),
        (("--set", "length=1", "--method", "RK4"), "--method RK4 needs --dt"),
        (("--set", "length=1", "--method", "Kinematic", "--dt", "1"), "--dt is nothing that Kinematic takes"),
        (("--set", "length=1", "--method", "RK4", "--dt", "1e-30"), "needs .* steps; give a longer one"),
    ],
)
def test_slips_are_named(model, tmp_path, words, message):
    done = call("run", model, "--t-end", 1, "--out", tmp_path, *words)
    assert done.exit_code == 2 and re.search(message, done.output), done.output


def test_a_model_file_has_no_parameters(tmp_path):
    (tmp_path / "a.json").write_text("{}")
    assert "--set is for Python files" in call("check", tmp_path / "a.json", "--set", "a=1").output
    assert "only build(...) of one has parameters" in call("check", tmp_path / "a.json", "--help-parameters").output


def test_the_package_is_a_command_and_says_its_version():
    done = subprocess.run([sys.executable, "-m", "mbsd3d", "--version"], capture_output=True, text=True)
    assert done.stdout == f"mbsd3d {__version__}\n" and done.returncode == 0


def test_a_pipe_gets_lines(monkeypatch):
    said, clock = io.StringIO(), iter([0.0, 0.0, 1.0, 3.0, 4.0, 9.0])
    monkeypatch.setattr(progress.sys, "stderr", said)
    monkeypatch.setattr(progress.time, "perf_counter", lambda: next(clock))
    with progress.Progress("simulate", 0.0, 10.0, "lines") as bar:
        for value in (1.0, 3.0, 4.0, 9.0):
            bar.update(value)
    assert said.getvalue() == "mbsd3d: simulate: 30 % after 3 s\nmbsd3d: simulate: 90 % after 9 s\n"
