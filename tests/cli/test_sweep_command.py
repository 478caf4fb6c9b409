"""The command ``mbsd3d sweep``: its table beside single runs, and what it refuses."""

import csv
import re

import numpy as np
import pytest
from click.testing import CliRunner

import mbsd3d
from mbsd3d.extend import main


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty working directory."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def call(*arguments):
    """Run a command in this process."""
    return CliRunner().invoke(main, [str(argument) for argument in arguments], prog_name="mbsd3d")


SWEPT = """
from mbsd3d import GROUND, Body, Revolute, System

def build(length=1.0, mass: float = 2.0):
    bob = Body("bob", mass=mass, inertia=(0.1, 0.1, 0.1), position=(0.6 * length, 0, -0.8 * length))
    return System([bob], [Revolute(GROUND, bob, at=(0, 0, 0), axis="y", name="main")])

def measure(solution):
    return {"turned": solution.angle("main").max()}
"""


def test_a_sweep_writes_what_each_run_gives_alone(folder):
    (folder / "swept.py").write_text(SWEPT)
    asked = ("--measure", "max:reaction:main", "--measure", "end:position.z:bob")
    ranges = ("--set", "length=0.5:2:4", "--set", "mass=1,3")
    done = call("sweep", "swept.py", *ranges, *asked, "--t-end", "0.5", "--output", "21", "--rtol", "1e-9")
    assert done.exit_code == 0, done.output
    with (folder / "out" / "swept_sweep.csv").open() as file:
        rows = [*csv.DictReader(file)]
    assert [(row["length"], row["mass"]) for row in rows] == [
        (f"{x}", m) for x in (0.5, 1.0, 1.5, 2.0) for m in ("1.0", "3.0")
    ]
    namespace = {}
    exec(SWEPT, namespace)
    run = mbsd3d.simulate(namespace["build"](length=1.5, mass=3.0), 0.5, output=21, rtol=1e-9)
    force = np.linalg.norm(run.reaction("main").force, axis=1).max()
    assert float(rows[5]["max reaction force of main [N]"]) == force
    assert float(rows[5]["end position of bob z [m]"]) == run.position("bob")[-1, 2]
    assert (folder / "out" / "swept_sweep.png").stat().st_size > 1000


def test_a_sweep_without_measures_takes_those_of_the_file(folder):
    (folder / "swept.py").write_text(SWEPT)
    done = call("sweep", "swept.py", "--set", "length=1,2", "--t-end", "0.2", "--out", "table.csv")
    assert done.exit_code == 0 and (folder / "table.csv").read_text().startswith("length,error,turned\n")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "nothing to sweep over"),
        (("--set", "length=1:2"), "give FROM:TO:COUNT with a count of 1 or more, e.g. --set length=0.5:2:16"),
        (("--set", "length=1:2:0"), "give FROM:TO:COUNT with a count of 1 or more"),
        (("--set", "lenght=1:2:3"), "did you mean 'length'"),
        (("--set", "length=1:2:3", "--measure", "largest:angle"), "reductions are max, min, mean, rms, end"),
        (
            ("--set", "length=1:2:3", "--measure", "max:angel"),
            "all runs failed, the first: .*quantity 'angel' is unknown",
        ),
        (("--set", "length=1:2:3", "--measure", "max:angle.x:main"), "has no component x; leave it out"),
    ],
)
def test_what_a_sweep_refuses(folder, arguments, words):
    (folder / "swept.py").write_text(SWEPT)
    done = call("sweep", "swept.py", *arguments, "--t-end", "0.1")
    assert done.exit_code == 2 and re.search(words, done.stderr), done.stderr


def test_measure_is_that_of_the_file_though_build_comes_from_another(folder):
    (folder / "shared_model.py").write_text(SWEPT)
    (folder / "own.py").write_text(
        "from shared_model import build\n\ndef measure(solution):\n    return {'last': solution.t[-1]}\n"
    )
    done = call("sweep", "own.py", "--set", "length=1,2", "--t-end", "0.2", "--output", "3")
    assert done.exit_code == 0 and "last" in done.output and "turned" not in done.output, done.output


def test_a_ledger_of_another_text_of_the_file_is_refused(folder):
    (folder / "swept.py").write_text(SWEPT)
    asked = ("sweep", "swept.py", "--set", "length=1,2", "--t-end", "0.1", "--output", "3", "--ledger", "kept.db")
    first, again = call(*asked), call(*asked)
    assert first.exit_code == again.exit_code == 0 and first.output == again.output
    (folder / "swept.py").write_text(SWEPT.replace("-0.8 * length", "-0.7 * length"))
    changed = call(*asked)
    assert changed.exit_code == 2 and "belongs to another sweep" in changed.output
