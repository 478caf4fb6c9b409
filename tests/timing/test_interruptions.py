"""Ctrl-C is answered within 0.3 s and workers end within 2 s of their parent, on an idle machine (``make timing``)."""

import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import pytest
from helpers.live_views import connected
from helpers.models import crane

from mbsd3d import Body, System, simulate

pytestmark = pytest.mark.timing

ROOT = Path(__file__).parents[2]
ANSWER, END = 0.3, 2.0  # s
MODEL = """
import mbsd3d as m
def build():
    arm = m.Body("arm", 1.0, (0.1, 0.2, 0.2), position=(0.5, 0, 0.1))
    return m.System([arm], [m.Revolute(m.GROUND, arm, at=(0, 0, 0), axis=(0, 1, 0))])
"""
COMMANDS = {
    "run": ("run", "model.py", "--t-end", "1e5", "--output", "1000"),
    "check": ("check", "model.py"),
    "warmup": ("warmup",),
    "demo": ("demo", "cardan"),
    "demos": ("demo", "--all"),
    "gallery": ("gallery",),
    "validate": ("validate",),
    "validate model": ("validate", "model.py", "--budget", "60"),
    "bicycle": ("bicycle", "sensitivity", "Browserins"),
    "circles": ("bicycle", "circles"),
    "nvh": ("nvh", "inline_4", "--page", "page"),
    "road": ("nvh", "--road", "C"),
    "valve": ("nvh", "--valve", "cycloidal"),
    "rider": ("bicycle", "rider"),
}


def living(group):
    """Processes of a group that have not ended."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:
            continue
        if int(fields[2]) == group and fields[0] != "Z":
            found.append(int(folder.name))
    return found


def stopped(process, sign, limit):
    """Send a signal; everything the process said, if it and its workers have ended in time."""
    if process.poll() is not None:
        pytest.skip("it had ended before")
    began = time.perf_counter()
    process.send_signal(sign)
    said = process.communicate(timeout=60)[0] if sign == signal.SIGINT else process.wait(timeout=60)
    assert time.perf_counter() - began < limit
    while left := living(process.pid):
        assert time.perf_counter() - began < END, f"{len(left)} processes are left"
        time.sleep(0.01)
    return said


def start(folder, *command, **environment):
    (folder / "model.py").write_text(MODEL)
    return subprocess.Popen(
        [sys.executable, "-m", *command], cwd=folder, env=os.environ | environment, stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT, text=True, start_new_session=True,
    )  # fmt: skip


@pytest.mark.parametrize("moment", [0.05, 0.4, 1.5, 4.0])
@pytest.mark.parametrize("cold", [False, True], ids=["warm", "cold"])
@pytest.mark.parametrize("name", COMMANDS)
def test_commands_answer_ctrl_c(tmp_path, name, cold, moment):
    more = {"MBSD3D_CACHE": str(tmp_path / "cache")} if cold else {}
    process = start(tmp_path, "mbsd3d", *COMMANDS[name], **more)
    time.sleep(moment)
    said = stopped(process, signal.SIGINT, ANSWER)
    assert process.returncode in (130, -signal.SIGINT)  # the second before there is a command: Python starts
    assert "Traceback" not in said or moment < 0.1
    assert not list(tmp_path.rglob("*.part"))


@pytest.mark.parametrize("sign", [signal.SIGINT, signal.SIGKILL])
@pytest.mark.parametrize("executor", ["threads", "processes"])
@pytest.mark.parametrize("moment", [0.5, 1.5, 4.0])
def test_sweeps_end_with_their_workers(tmp_path, executor, sign, moment):
    more = {"MBSD3D_MARK": str(tmp_path / "mark"), "MBSD3D_FAST": "0", "PYTHONPATH": f"{ROOT}:{ROOT / 'tests'}"}
    process = start(tmp_path, "helpers.sweep_models", tmp_path / "sweep.db", "0", executor, **more)
    time.sleep(moment)
    stopped(process, sign, END)  # with what Python needs to take itself apart


def test_a_live_view_stops_at_once_with_open_connections():
    stone = Body("stone", 1.0, (0.1, 0.1, 0.1), velocity=(0, 0, 3.0), omega=(0, 0, 1.0))
    view = simulate(System([stone]), 0.1, progress=False).animate(live=True)
    open_ones, silent = connected(view), hesitant(view)
    began = time.perf_counter()
    view.stop()
    assert time.perf_counter() - began < 0.5
    for one in open_ones:
        one.close_socket()
    silent.close()


def hesitant(view):
    """A browser that has connected ahead, and has asked for nothing yet."""
    one = socket.create_connection(("127.0.0.1", view.port))
    time.sleep(0.3)  # until the server knows it
    return one


def test_a_ride_stops_at_once_with_open_connections():
    view = crane().play()
    silent, began = hesitant(view), time.perf_counter()
    view.stop()
    assert time.perf_counter() - began < 0.5
    silent.close()
