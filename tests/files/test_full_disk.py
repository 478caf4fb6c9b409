"""Every writer on a full disk: one sentence, the older file stays whole, and no piece of the new one is left."""

import resource
import subprocess
import sys
from contextlib import contextmanager

import pytest
from matplotlib.figure import Figure

from mbsd3d import GROUND, RK4, Body, Revolute, System, save_figure, simulate, sweep
from mbsd3d.extend import write_table

OLD = b"of the last run"
ROOM = 256  # bytes that still fit: the disk is full in the middle of every file


@contextmanager
def full_disk(room=ROOM):
    """No file of this process and those it starts grows over ``room`` bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.fixture(scope="module")
def run():
    arm = Body("arm", 1.3, (0.1, 0.2, 0.15), com=(0.1, 0.0, 0.2), position=(0.5, 0.1, 0.1))
    system = System([arm], [Revolute(GROUND, arm, at=(0, 0, 0), axis=(0.1, 1, 0))])
    return simulate(system, 0.05, method=RK4(0.01), output=3, progress=False)


WRITERS = {
    "run.npz": lambda run, path: run.save(path),
    "run.csv": lambda run, path: run.to_csv(path),
    "report.html": lambda run, path: run.report(path, curves=[]),
    "page.html": lambda run, path: run.animate(path, curves=()),
    "pose.html": lambda run, path: run.system.show(path),
    "run.glb": lambda run, path: run.export_glb(path, frames=2),
    "film.gif": lambda run, path: run.export_gif(path, width=64, fps=4),
    "model.json": lambda run, path: run.system.to_file(path, replace=True),
    "model.toml": lambda run, path: run.system.to_file(path, replace=True),
    "pose.glb": lambda run, path: run.system.export_glb(path),
    "figure.png": lambda run, path: save_figure(Figure(), path),
    "table.csv": lambda run, path: write_table(path, ["name", "x [m]"], [["a", 0.1]] * 50),
}


@pytest.mark.parametrize("name", WRITERS)
def test_the_older_file_stays(run, tmp_path, name):
    path = tmp_path / name
    path.write_bytes(OLD)
    with full_disk(), pytest.raises(ValueError, match="cannot be written: File too large; give a file in") as said:
        WRITERS[name](run, path)
    assert "\n" not in str(said.value)
    assert path.read_bytes() == OLD and [x.name for x in tmp_path.iterdir()] == [name]
    WRITERS[name](run, path)  # with room again
    assert path.read_bytes() != OLD


def build(mass):
    body = Body("wheel", mass, (0.1, 0.2, 0.15))
    return System([body], gravity=(0, 0, 0))


def height(solution):
    return {"x": solution.position("wheel")[-1, 2]}


def test_a_ledger_that_cannot_begin_says_so_and_begins_later(tmp_path):
    given = {"run": {"t_end": 0.01, "method": RK4(0.01)}, "ledger": tmp_path / "sweep.db", "progress": False}
    with full_disk(), pytest.raises(ValueError, match=r"sweep.db' cannot be used: .* is yours and has space$"):
        sweep(build, {"mass": [1.0, 2.0]}, height, **given)
    assert sweep(build, {"mass": [1.0, 2.0]}, height, **given).attrs["failed"] == 0


COMMANDS = {
    "run": ("run", "model.json", "--t-end", "0.01", "--out", "out"),
    "show": ("show", "model.json", "--out", "out"),
    "validate": ("validate", "model.json", "--budget", "0.5", "--t-end", "0.01", "--json", "out/seen.json"),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", COMMANDS)
def test_commands_say_it_in_a_line(run, tmp_path, name):
    run.system.to_file(tmp_path / "model.json")
    with full_disk():
        found = subprocess.run(
            [sys.executable, "-m", "mbsd3d", *COMMANDS[name]], cwd=tmp_path, capture_output=True, text=True, timeout=300
        )
    assert found.returncode == 2 and "Traceback" not in found.stderr
    assert found.stderr.splitlines()[-1].startswith("mbsd3d: 'out/") and "has space" in found.stderr
    assert not list(tmp_path.glob("out/*"))
