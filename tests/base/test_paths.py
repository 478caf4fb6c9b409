"""Files are whole or not there: what a killed process has begun goes at the next write, what others write stays."""

import os
import signal
import subprocess
import sys
import time

import pytest

from mbsd3d.base import paths
from mbsd3d.base.paths import atomic_write
from mbsd3d.extend import write_atomically

pytestmark = pytest.mark.skipif(os.name != "posix", reason="asks for processes")

BEGINS = """
import sys, time
from pathlib import Path
from mbsd3d.base.paths import atomic_write
with atomic_write(Path(sys.argv[1])) as part:
    part.write_bytes(b"half of ")
    print("begun", flush=True)
    time.sleep(60.0)
"""


@pytest.fixture
def other(tmp_path):
    """Another process that has begun a file in the folder."""
    process = subprocess.Popen([sys.executable, "-c", BEGINS, tmp_path / "a.csv"], stdout=subprocess.PIPE)
    process.stdout.readline()
    yield process
    process.kill()
    process.wait()


def pieces(folder):
    return [path for path in folder.iterdir() if path.name.endswith(".part")]


def test_what_a_killed_process_left_goes_at_the_next_write(tmp_path, other):
    assert len(pieces(tmp_path)) == 1 and pieces(tmp_path)[0].name[0] == "."
    write_atomically(tmp_path / "b.csv", b"whole")
    assert len(pieces(tmp_path)) == 1  # it lives, and may still finish
    other.send_signal(signal.SIGKILL)
    other.wait()
    assert len(pieces(tmp_path)) == 1
    write_atomically(tmp_path / "b.csv", b"whole again")
    assert [path.name for path in tmp_path.iterdir()] == ["b.csv"]


def test_a_living_process_keeps_its_file_however_old(tmp_path, other):
    (piece,) = pieces(tmp_path)
    os.utime(piece, (0, time.time() - 30.0 * 86400.0))
    write_atomically(tmp_path / "b.csv", b"whole")
    assert piece.exists()


def test_two_files_of_one_process_do_not_disturb_each_other(tmp_path):
    with atomic_write(tmp_path / "a.csv") as part:
        part.write_bytes(b"first")
        write_atomically(tmp_path / "b.csv", b"second")
        assert part.exists()
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a.csv": b"first", "b.csv": b"second"}


def aged(folder, name, days):
    path = folder / name
    path.write_bytes(b"half")
    os.utime(path, (0, time.time() - days * 86400.0))
    return path


HEX, ELSEWHERE = "0123456789abcdef" * 2, "f" * 16


@pytest.mark.parametrize("name", [f".{HEX}.part", f".{HEX}-{ELSEWHERE}-1.part"], ids=["older version", "other machine"])
def test_where_no_process_can_be_asked_a_day_decides(tmp_path, name):
    piece = aged(tmp_path, name, 0.9)
    write_atomically(tmp_path / "b.csv", b"whole")
    assert piece.exists()
    aged(tmp_path, name, 1.1)
    write_atomically(tmp_path / "b.csv", b"whole")
    assert not piece.exists()


@pytest.mark.parametrize(
    "name", [f"{HEX}.part", f".{HEX}.part.old", ".mine.part", f".{HEX[:-1]}.part", f".{HEX}-{ELSEWHERE}.part", "a.part"]
)
def test_files_of_other_names_are_not_ours(tmp_path, name):
    piece = aged(tmp_path, name, 400.0)
    write_atomically(tmp_path / "b.csv", b"whole")
    assert piece.exists()


def test_links_folders_and_files_of_others_stay(tmp_path, monkeypatch):
    target = tmp_path / "target"
    target.write_bytes(b"a user's")
    link, folder = tmp_path / f".{HEX}.part", tmp_path / f".{HEX[::-1]}.part"
    link.symlink_to(target)
    folder.mkdir()
    os.utime(folder, (0, 0))
    write_atomically(tmp_path / "b.csv", b"whole")
    assert link.is_symlink() and folder.is_dir() and target.read_bytes() == b"a user's"
    foreign = aged(tmp_path, f".{'1' * 32}.part", 400.0)
    with monkeypatch.context() as patch:
        patch.setattr(paths.os, "geteuid", lambda: os.getuid() + 1)
        write_atomically(tmp_path / "b.csv", b"whole")
    assert foreign.exists()
