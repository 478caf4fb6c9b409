"""Nothing that a sweep has finished is lost: killed processes, broken pools, Ctrl-C, a full disk; and its ledger."""

import multiprocessing
import os
import signal
import sqlite3
import subprocess
import sys
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from helpers.sweep_models import (
    GRID,
    LOCAL,
    LONG,
    RUN,
    counted,
    deadly,
    deadly_once,
    half_written,
    history,
    known,
    speed,
    touchy,
    wheel,
)

from mbsd3d import SweepError, measures, sweep
from mbsd3d.extend import Store
from mbsd3d.sweeps import executors as workers
from mbsd3d.sweeps.experiment import Outcome
from mbsd3d.sweeps.store import Ledger, LedgerError, stamp

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_a_worker_that_is_ended_leaves_no_piece_of_a_file(tmp_path):
    with pytest.raises(KeyboardInterrupt), workers.closing(workers.process_pool(1)) as pool:
        pool.submit(half_written, tmp_path)
        while not (tmp_path / "begun").exists():
            time.sleep(0.01)
        raise KeyboardInterrupt
    assert [path.name for path in tmp_path.iterdir()] == ["begun"]


@pytest.mark.slow
def test_a_killed_process_costs_its_cell_only(monkeypatch):
    pools, make = [], workers.process_pool
    monkeypatch.setattr(workers, "process_pool", lambda size: pools.append(size) or make(size))
    table = sweep(deadly, GRID, speed, run=RUN, executor="processes")
    killed = (table["torque"] == 2.0) & (table["inertia"] == 0.4)
    assert int(killed.sum()) == 1 and "WorkerDied" in str(table["error"].values[killed.values][0])
    assert table.attrs["failed"] == 1
    assert len(pools) <= 2 + 2 * workers.cores()  # one that breaks, one for each cell in flight, one for the rest
    np.testing.assert_allclose(table["speed"].values[~killed.values], known(GRID)[~killed.values], rtol=LOCAL)


@pytest.mark.slow
def test_a_cell_whose_process_died_by_accident_runs_again(tmp_path, monkeypatch):
    monkeypatch.setenv("MBSD3D_MARK", str(tmp_path / "mark"))
    table = sweep(deadly_once, GRID, speed, run=RUN, executor="processes")
    assert (tmp_path / "mark").exists() and table.attrs["failed"] == 0
    np.testing.assert_allclose(table["speed"], known(GRID), rtol=LOCAL)


class KilledWorker(Exception):  # noqa: N818
    """As `distributed` raises it."""


class Blaming(Executor):
    """A cluster that blames the culprit (2.0, 0.4) and, the first time, the cell after it as well."""

    seen = beside = False

    def submit(self, fn, /, cell):
        future, culprit = Future(), cell == {"torque": 2.0, "inertia": 0.4}
        if culprit or self.beside:
            future.set_exception(KilledWorker("Attempted to run a task on 4 different workers"))
        else:
            future.set_result(fn(cell))
        self.seen, self.beside = self.seen or culprit, culprit and not self.seen
        return future


def test_a_cluster_that_blames_the_neighbours_too():
    """Seen on a busy machine: cells held by a worker when it was killed for the fourth time failed with the culprit."""
    table = sweep(deadly, GRID, speed, run=RUN, executor=Blaming())
    killed = (table["torque"] == 2.0) & (table["inertia"] == 0.4)
    assert table.attrs["failed"] == 1 and "KilledWorker" in str(table["error"].values[killed.values][0])
    np.testing.assert_allclose(table["speed"].values[~killed.values], known(GRID)[~killed.values], rtol=LOCAL)


@pytest.mark.slow
def test_a_broken_pool_of_the_user_keeps_what_had_finished():
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        with pytest.raises(SweepError, match="broke before .* cells had finished; executor='processes'") as caught:
            sweep(deadly, GRID, speed, run=RUN, executor=pool)
    kept = caught.value.dataset["speed"].values.ravel()
    assert np.isfinite(kept[:4]).all() and np.isnan(kept[4:]).all()  # one worker: the fifth cell, (2.0, 0.4), kills it
    assert caught.value.dataset.attrs["stopped_by"] == "stopped after 4 of 12 cells"


def lines(path):
    return path.read_text().splitlines() if path.exists() else []


def start(ledger, mark, *arguments, fast=1000):
    """A process that sweeps LONG with a ledger, slowly after so many cells; returns when it has begun."""
    environment = {"MBSD3D_MARK": str(mark), "MBSD3D_FAST": str(fast), "PYTHONPATH": f"{ROOT}:{ROOT / 'tests'}"}
    command = [sys.executable, "-m", "helpers.sweep_models", str(ledger), *map(str, arguments)]
    return subprocess.Popen(
        command, env=os.environ | environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def wait_for(mark, count, process):
    """Until so many cells have begun."""
    while len(lines(mark)) < count:
        assert process.poll() is None, process.communicate()[0]
        time.sleep(0.01)


@pytest.mark.slow
@pytest.mark.parametrize("how", [signal.SIGKILL, signal.SIGINT])
def test_a_ledger_goes_on_where_a_sweep_was_stopped(tmp_path, monkeypatch, how):
    ledger, mark = tmp_path / "sweep.db", tmp_path / "mark"
    process = start(ledger, mark, fast=30)  # then it cannot come to its end before the signal
    wait_for(mark, 30, process)
    process.send_signal(how)
    said, _ = process.communicate(timeout=60)
    with sqlite3.connect(ledger) as file:
        stored = file.execute("SELECT COUNT(*) FROM cells").fetchone()[0]
    begun = len(lines(mark))
    assert 160 > begun >= stored >= begun - 2 * os.cpu_count() - 2  # those in flight are lost, not one more
    if how == signal.SIGINT:
        assert f"finished {stored}; stopped after {stored} of 160 cells" in said
    monkeypatch.setenv("MBSD3D_MARK", str(mark))
    table = sweep(counted, LONG, speed, run=RUN, ledger=ledger)
    assert len(lines(mark)) == begun + 160 - stored  # none twice
    np.testing.assert_allclose(table["speed"], known(LONG), rtol=LOCAL)
    again = sweep(counted, LONG, speed, run=RUN, ledger=ledger)
    assert len(lines(mark)) == begun + 160 - stored and np.array_equal(again["speed"], table["speed"])


@pytest.mark.slow
def test_a_full_disk_is_named_and_the_finished_cells_are_returned(tmp_path):
    """A limit of 128 kB on the size of files stands in for the disk."""
    process = start(tmp_path / "sweep.db", tmp_path / "mark", 131072)
    said, _ = process.communicate(timeout=120)  # numba and the kernels have to be loaded first
    assert "sweep.db' cannot be written:" in said and "make room, and run the sweep again" in said
    finished = int(said.split("finished ")[1].split(";")[0])
    assert 10 < finished < 160


def test_failed_cells_are_tried_again(tmp_path):
    first = sweep(touchy, GRID, speed, run=RUN, ledger=tmp_path / "sweep.db")
    again = sweep(touchy, GRID, speed, run=RUN, ledger=tmp_path / "sweep.db")
    assert first.attrs["failed"] == again.attrs["failed"] == 3 and first["speed"].equals(again["speed"])


@pytest.mark.parametrize(
    "change, word",
    [
        ({"grid": GRID | {"inertia": [0.2, 0.4, 0.8]}}, "values of 'inertia'"),
        ({"tag": "second"}, "tag"),
        ({"run": RUN | {"rtol": 1e-7}}, "run"),
        ({"measure": history}, "measure"),
        ({"build": touchy}, "build"),
        ({"grid": dict(reversed(GRID.items()))}, "dims"),  # the same cells under other numbers
    ],
)
def test_the_ledger_of_another_sweep_is_refused_by_name(tmp_path, change, word):
    given = {"build": wheel, "grid": GRID, "measure": speed, "run": RUN, "ledger": tmp_path / "sweep.db"}
    sweep(**given)
    with pytest.raises(ValueError, match=rf"belongs to another sweep, it differs in {word}; give another file"):
        sweep(**(given | change))


def test_conditions_are_compared_by_all_that_they_say():
    def until(x):
        return measures.position(wheel().bodies[0], at=(x, 0, 0), axis=(1, 0, 0)) < 0.1

    assert stamp(until(0.5)) == stamp(until(0.5)) != stamp(until(0.6))  # both print as "position of wheel < 0.1 m"


def test_the_ledger_of_another_version_is_refused(tmp_path, monkeypatch):
    sweep(wheel, GRID, speed, run=RUN, ledger=tmp_path / "sweep.db")
    monkeypatch.setattr("mbsd3d.sweeps.store.package_version", lambda: "0.0.1")
    with pytest.raises(ValueError, match="belongs to another sweep, it differs in mbsd3d; give another file"):
        sweep(wheel, GRID, speed, run=RUN, ledger=tmp_path / "sweep.db")


def test_ledgers_that_cannot_be_used(tmp_path):
    (tmp_path / "text.db").write_text("a letter, not a ledger " * 100)
    for ledger in (tmp_path / "text.db", tmp_path / "nowhere" / "sweep.db", tmp_path):
        with pytest.raises(ValueError, match="ledger .* cannot be used: .*; give a file"):
            sweep(wheel, GRID, speed, run=RUN, ledger=ledger)


class InPlace(Executor):
    """Runs a cell where it is submitted, as a debugger wants it; Ctrl-C comes with the fourth."""

    def submit(self, fn, /, *args, **kwargs):
        self.count = getattr(self, "count", 0) + 1
        if self.count == 4:
            raise KeyboardInterrupt
        future = Future()
        future.set_result(fn(*args, **kwargs))
        return future


@pytest.mark.skipif(os.name != "posix", reason="Windows has no masks of signals")
def test_processes_are_deaf_to_ctrl_c_before_they_have_begun():
    """A terminal sends it to them too: they had answered by tracebacks while they loaded their modules."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, [])
    with workers.process_pool(1) as pool:
        assert signal.SIGINT in pool.submit(signal.pthread_sigmask, signal.SIG_BLOCK, []).result()
    assert signal.pthread_sigmask(signal.SIG_BLOCK, []) == before


def test_ctrl_c_returns_what_has_finished():
    table = sweep(wheel, GRID, speed, run=RUN, executor=InPlace())
    assert table.attrs["stopped_by"] == "stopped after 3 of 12 cells"
    assert np.isfinite(table["speed"].values.ravel()[:3]).all()
    assert (table["error"].values.ravel()[3:] == "not run").all()


class Failing(InPlace):
    """Fails in a way of its own at the fourth cell, or gives it back cancelled."""

    def __init__(self, error):
        self.error = error

    def submit(self, fn, /, *args, **kwargs):
        try:
            return super().submit(fn, *args, **kwargs)
        except KeyboardInterrupt:
            if self.error:
                raise self.error from None
            future = Future()
            future.cancel()
            future.set_running_or_notify_cancel()
            return future


@pytest.mark.parametrize(
    "error, words",
    [
        (OSError("no route to host"), "the executor failed, OSError: no route to host"),
        (RuntimeError("cannot schedule new futures after shutdown"), "Failing broke before 9 cells had finished"),
        (None, "Failing broke before 9 cells had finished"),
    ],
)
def test_whatever_an_executor_does_the_finished_cells_are_kept(error, words):
    with pytest.raises(SweepError, match=words) as caught:
        sweep(wheel, GRID, speed, run=RUN, executor=Failing(error))
    assert np.isfinite(caught.value.dataset["speed"].values.ravel()[:3]).all()


def test_a_store_refuses_other_work_or_begins_anew(tmp_path):
    first = Store(tmp_path / "work.db", {"setting": 1, "version": "a"}, "study")
    first.put("case", {"value": 0.1 + 0.2})
    assert Store(tmp_path / "work.db", {"setting": 1, "version": "a"}, "study").all() == {"case": {"value": 0.1 + 0.2}}
    with pytest.raises(ValueError, match="study: ledger .* belongs to another study, it differs in setting; give"):
        Store(tmp_path / "work.db", {"setting": 2, "version": "a"}, "study")
    other = Store(tmp_path / "work.db", {"setting": 2, "version": "a"}, "study", replace=True)
    assert other.all() == {}
    other.put("case", 1)
    other.clear()
    assert other.all() == {}


@pytest.mark.parametrize("cell", [3, -1, "2"])
def test_cells_that_the_grid_does_not_have_are_refused(tmp_path, cell):
    """A file that was changed by hand or belongs to a larger grid with the same settings."""
    own = {"setting": 1}
    with_more = Ledger(tmp_path / "work.db", own, 5)
    with_more.keep(2, Outcome({"value": 0.5}))
    with_more.put(cell, {"values": {"value": 0.7}, "settings": ""})
    with pytest.raises(LedgerError, match="holds cells that the grid does not have; delete it"):
        Ledger(tmp_path / "work.db", own, 3).finished()
