"""Commands that write into one folder at once, and commands that are interrupted while they write: files are whole."""

import json
import signal
import subprocess
import sys
import time

import pytest

from mbsd3d import load

pytestmark = pytest.mark.slow

READERS = {".npz": load, ".json": lambda path: json.loads(path.read_text(encoding="utf-8"))}
ENDS = {".html": b"</html>", ".svg": b"</svg>", ".png": b"IEND\xaeB`\x82", ".csv": b"\n"}


def begin(folder, *arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "mbsd3d", *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        encoding="utf-8",
    )  # fmt: skip


def whole(folder):
    """Names of the files of a folder, each read or seen to its end; pieces of files are none of them."""
    found = sorted(folder.iterdir())
    for path in found:
        assert path.suffix in (*READERS, *ENDS, ".db", ".gif"), path.name
        if path.suffix in READERS:
            READERS[path.suffix](path)
        assert path.read_bytes().rstrip().endswith(ENDS.get(path.suffix, b"").rstrip())
    return {path.name for path in found}


@pytest.mark.parametrize(
    ("arguments", "written"),
    [
        (("demo", "dzhanibekov", "--out", "out"), {"dzhanibekov.npz", "dzhanibekov.csv", "dzhanibekov.png"}),
        (
            ("validate", "--case", "gallery_dzhanibekov", "--out", "out"),
            {"validation.db", "validation.html", "validation.json"},
        ),
    ],
    ids=["demo", "validate"],
)
def test_two_at_once_leave_whole_files(tmp_path, arguments, written):
    both = [begin(tmp_path, *arguments) for _ in range(2)]
    for one in both:
        said = one.communicate(timeout=600)[1]
        assert one.returncode == 0, said
    assert written <= whole(tmp_path / "out")


@pytest.mark.parametrize("arguments", [("demo", "--all", "--out", "out"), ("validate", "--quick", "--out", "out")])
def test_ctrl_c_leaves_whole_files(tmp_path, arguments):
    """When something has been written, and more is on its way."""
    running, folder = begin(tmp_path, *arguments), tmp_path / "out"
    ends = time.monotonic() + 300.0
    while not (folder.is_dir() and any(folder.iterdir())) and time.monotonic() < ends:
        time.sleep(0.02)
    time.sleep(2.0)
    running.send_signal(signal.SIGINT)
    said = running.communicate(timeout=60)[1]
    assert running.returncode == 130 and "mbsd3d: interrupted" in said and "Traceback" not in said
    assert whole(folder)
