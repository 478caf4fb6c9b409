"""Small files that would cost much: refused before they are read, within the limits of the watchdog."""

import json
import sqlite3
import zipfile

import numpy as np
import pytest
from helpers.watchdog import watched

import mbsd3d
from bicycle.parameters.files import read_values
from mbsd3d import Body, System
from mbsd3d.sweeps.experiment import Experiment, Outcome
from mbsd3d.sweeps.grids import make_grid
from mbsd3d.sweeps.store import Ledger, LedgerError, identity

STONE = System([Body("stone", 1.0, (0.1, 0.1, 0.1))])
YAML = {
    "brackets": "[" * 20_000, "maps": "{a: " * 5000, "dashes": "- " * 9000,
    "base 60": "values:\n  a: " + "1:" * 9000 + "1",
    "digits": "values:\n  a: " + "9" * 5000, "large": "a: 1\n" * 20_000, "keys": "? " * 9000,
    "quotes": '"' * 40_000,
    "blocks": "|\n " * 9000, "indented": "".join(" " * k + "a:\n" for k in range(280)), "tags": "!!" * 9000,
}  # fmt: skip


@pytest.mark.parametrize("name", YAML)
def test_yaml(tmp_path, name):
    path = tmp_path / "bicycle.yml"
    path.write_text(YAML[name])
    with watched(name), pytest.raises(ValueError, match="bicycle.yml"):
        read_values(path)


def test_an_archive_that_unpacks_to_gigabytes(tmp_path):
    sound = mbsd3d.accelerations(STONE).save(tmp_path / "sound.npz")
    with zipfile.ZipFile(sound) as old, zipfile.ZipFile(tmp_path / "bomb.npz", "w", zipfile.ZIP_DEFLATED) as new:
        for entry in old.namelist():
            new.writestr(entry, old.read(entry) + bytes(2**26 if entry == "t.npy" else 0))
    with (
        watched("bomb", megabytes=50),
        pytest.raises(ValueError, match="is compressed, which solution.save"),
    ):
        mbsd3d.load(tmp_path / "bomb.npz")
    with zipfile.ZipFile(sound) as old, zipfile.ZipFile(tmp_path / "more.npz", "w") as new:
        for entry in (*old.namelist(), "evil.npy"):
            new.writestr(entry, old.read(entry) if entry != "evil.npy" else b"")
    with pytest.raises(ValueError, match="it holds 'evil.npy', which no solution has"):
        mbsd3d.load(tmp_path / "more.npz")


def test_a_model_of_too_many_parts(tmp_path):
    data = json.loads(STONE.to_file(tmp_path / "a.json").read_text())
    data["bodies"] = [data["bodies"][0] | {"name": f"b{k}"} for k in range(20_001)]
    (tmp_path / "b.json").write_text(json.dumps(data))
    with watched("parts"), pytest.raises(ValueError, match="20001 parts, a file may have 20000; build it in Python"):
        System.from_file(tmp_path / "b.json")


@pytest.mark.parametrize(
    "content",
    [
        None,
        "null",
        "[]",
        '{"values": null}',
        '{"values": {"value": null}}',
        '{"values": {"value": "x"}}',
        "[" * 5000,
        3,
    ],
)
def test_contents_of_a_ledger(tmp_path, content):
    """null is no NaN: it is refused, and so is what is not a number."""
    own = identity(Experiment(lambda mass: STONE, lambda run: 1.0, {}), make_grid({"mass": [1.0, 2.0]}), "")
    book = Ledger(tmp_path / "sweep.db", own, 2)
    book.keep(0, Outcome({"value": float("nan")}))
    assert np.isnan(book.finished()[0].values["value"])  # NaN that was measured comes back
    book.close()
    with sqlite3.connect(tmp_path / "sweep.db") as file:
        file.execute("DROP TABLE cells")
        file.execute("CREATE TABLE cells (cell, outcome)")
        file.execute("INSERT INTO cells VALUES (0, ?)", (content,))
    file.close()
    book = Ledger(tmp_path / "sweep.db", own, 2)
    with pytest.raises(LedgerError, match="sweep.db' cannot be read: .*; delete it"):
        book.finished()
    book.close()


def test_a_failed_cell_in_a_ledger_is_tried_again(tmp_path):
    own = identity(Experiment(lambda mass: STONE, lambda run: 1.0, {}), make_grid({"mass": [1.0, 2.0]}), "")
    book = Ledger(tmp_path / "sweep.db", own, 2)
    book.file.execute("INSERT INTO cells VALUES (1, ?)", ('{"values": {}, "error": "ValueError: x"}',))
    assert book.finished() == {}
    book.close()
