"""Sweeps that are killed: no process stays, nothing that came in is computed again, and the result is the same.

``MBSD3D_TEST_KILLS`` sets at how many moments (``make kills``).
"""

import os
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from helpers.processes import END, KILLS, alive, children
from helpers.sweep_models import EXECUTORS, LONG, RUN, counted, speed

from mbsd3d import sweep
from mbsd3d.sweeps.executors import cores

ROOT = Path(__file__).parents[2]
CELLS = 160


def lines(path):
    return path.read_text().splitlines() if path.exists() else []


def stored(ledger):
    """Numbers of the cells in a ledger, which may not have been made yet."""
    try:
        with closing(sqlite3.connect(ledger)) as file:
            return {cell for (cell,) in file.execute("SELECT cell FROM cells")}
    except sqlite3.OperationalError:
        return set()


def cell_of(line):
    """Number of the cell whose build has left a line."""
    torque, inertia = map(float, line.split())
    return LONG["torque"].index(torque) * len(LONG["inertia"]) + LONG["inertia"].index(inertia)


def begin(ledger, mark, executor):
    """A process that sweeps LONG."""
    environment = {"MBSD3D_MARK": str(mark), "MBSD3D_FAST": "1000", "PYTHONPATH": f"{ROOT}:{ROOT / 'tests'}"}
    command = [sys.executable, "-m", "helpers.sweep_models", str(ledger), "0", executor]
    return subprocess.Popen(command, env=os.environ | environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    os.environ["MBSD3D_MARK"] = str(tmp_path_factory.mktemp("kills") / "mark")
    return sweep(counted, LONG, speed, run=RUN)["speed"].values


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc").is_dir(), reason="reads processes from /proc")
@pytest.mark.parametrize("executor", EXECUTORS)
@pytest.mark.parametrize("moment", range(KILLS))
def test_a_killed_sweep_leaves_no_process_and_loses_nothing(tmp_path, monkeypatch, undisturbed, executor, moment):
    ledger, mark = tmp_path / "sweep.db", tmp_path / "mark"
    rng = np.random.default_rng([moment, 7])
    process = begin(ledger, mark, executor)
    wanted = int(rng.integers(0, CELLS - 20))  # cells that have begun; 0: while it starts
    if not wanted:
        time.sleep(rng.uniform(0.0, 3.0))
    while wanted and len(lines(mark)) < wanted and process.poll() is None:
        time.sleep(0.005)
    below = children(process.pid)
    victim = process.pid
    if moment % 3 == 2 and executor == "processes" and below:  # a worker: the sweep goes on by itself
        victim = below[-1]
    os.kill(victim, signal.SIGKILL)
    if victim == process.pid:
        process.wait(timeout=10)
        ends = time.monotonic() + END
        while alive(below) and time.monotonic() < ends:
            time.sleep(0.02)
        assert alive(below) == [], f"{len(alive(below))} processes still run {END} s after kill -9"
    else:
        assert process.wait(timeout=120) == 0
    begun, arrived, kept = lines(mark), [int(line) for line in lines(Path(f"{ledger}.arrived"))], stored(ledger)
    # How many cells the workers have finished that the sweep has not heard of depends on the machine. What it has heard
    # of does not: each is in the ledger before the next is taken, and the workers have no more than a window of others.
    assert set(arrived[:-1]) <= kept <= set(arrived)
    if executor != "distributed":  # whose workers get all cells at once
        assert len(begun) <= len(arrived) + 2 * cores() * (1 if victim == process.pid else 2)
    if victim != process.pid:
        assert len(kept) == CELLS
    monkeypatch.setenv("MBSD3D_MARK", str(mark))
    table = sweep(counted, LONG, speed, run=RUN, ledger=ledger)
    assert np.array_equal(table["speed"].values, undisturbed)  # to the last bit, whoever computed it
    again = sorted(cell_of(line) for line in lines(mark)[len(begun) :])
    assert again == sorted(set(range(CELLS)) - kept), "cells that had come in were computed again"
