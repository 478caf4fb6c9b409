"""The gallery, play and live views killed: no process, port or half file stays, and the next call goes on.

``MBSD3D_TEST_KILLS`` sets at how many moments (``make kills``).
"""

import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from helpers.processes import END, KILLS, alive, children

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc").is_dir(), reason="reads processes from /proc"),
]
DEMOS = ("ball_on_turntable", "cardan", "dzhanibekov")
MODEL = """
import mbsd3d as m
def build():
    arm = m.Body("arm", 1.0, (0.1, 0.2, 0.2), com=(0.1, 0.2, 0.05), position=(0.5, 0, 0.1))
    hinge = m.Revolute(m.GROUND, arm, at=(0, 0, 0), axis=(1, 2, 3))
    return m.System([arm], [hinge], [m.Force(arm, (m.Input("push"), 0, 0))])
"""
LIVE = """
import sys
import mbsd3d as m
sys.path.insert(0, ".")
from model import build
system = build()
with m.simulate(system, 1.0, progress=False).animate(live=True) as view:
    print(view.url, flush=True)
    view.wait()
"""
VIEWS = {"play": ("-m", "mbsd3d", "play", "model.py", "--input", "push=-5:5"), "live": ("live.py",)}


def start(folder, *command):
    return subprocess.Popen(
        [sys.executable, *command], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )


def port_of(process):
    """Port of the address that it prints, among what it says of its progress on a busy machine."""
    for line in process.stdout:
        if found := re.match(r"http://127\.0\.0\.1:(\d+)/\?token=", line):
            return int(found[1])
    raise AssertionError("it has ended without an address")


def killed(process, victim=None):
    """kill -9 it, or a process below it, and wait until nothing of it runs."""
    below = children(process.pid)
    os.kill(process.pid if victim is None or not below else below[victim % len(below)], signal.SIGKILL)
    said = process.communicate(timeout=120)[0]
    ends = time.monotonic() + END
    while alive(below) and time.monotonic() < ends:
        time.sleep(0.02)
    assert alive(below) == [], f"{len(alive(below))} processes still run"
    return said


@pytest.mark.parametrize("moment", range(KILLS))
def test_a_killed_gallery_goes_on(tmp_path, moment):
    rng = np.random.default_rng([moment, 11])
    command = ("-m", "mbsd3d", "gallery", *DEMOS, "--out", "site")
    process, site = start(tmp_path, *command), tmp_path / "site"
    wanted = int(rng.integers(0, 14))  # files that are there; then a moment more
    while process.poll() is None and len([*site.glob("*.*")]) < wanted:
        time.sleep(0.005)
    time.sleep(rng.uniform(0.0, 1.0))
    before = {path: path.read_bytes() for path in site.glob("*.json")}
    killed(process, victim=moment if moment % 3 == 2 else None)
    done = start(tmp_path, *command)
    said = done.communicate(timeout=600)[0]
    assert done.returncode == 0, said
    for name in DEMOS:
        found = json.loads((site / f"{name}.json").read_text())
        assert found["passed"] and {f"{name}.html", f"{name}_seen.html", f"{name}.png"} <= set(found["files"])
        for file, digest in found["files"].items():
            assert sha256((site / file).read_bytes()).hexdigest() == digest
    for path, content in before.items():  # what was finished is not made again
        assert path.read_bytes() == content and f"{path.stem}: as it was" in said
    assert not list(site.rglob("*.part"))


@pytest.mark.parametrize("name", VIEWS)
@pytest.mark.parametrize("moment", range(KILLS))
def test_a_killed_view_leaves_its_port_and_nothing_else(tmp_path, name, moment):
    rng = np.random.default_rng([moment, 13])
    (tmp_path / "model.py").write_text(MODEL)
    (tmp_path / "live.py").write_text(LIVE)
    files = sorted(tmp_path.iterdir())
    process = start(tmp_path, *VIEWS[name])
    if moment % 5 == 4:  # while it starts
        time.sleep(rng.uniform(0.0, 2.0))
        killed(process)
    else:
        port = port_of(process)
        visitors = [socket.create_connection(("127.0.0.1", port)) for _ in range(3)]
        time.sleep(rng.uniform(0.0, 0.5))
        killed(process)
        for visitor in visitors:
            visitor.close()
        with socket.socket() as probe:
            assert probe.connect_ex(("127.0.0.1", port)) != 0
        if name == "play":  # the same port can be had again at once
            again = start(tmp_path, *VIEWS[name], "--port", str(port))
            assert port_of(again) == port
            killed(again)
    assert sorted(path for path in tmp_path.iterdir() if path.name != "__pycache__") == files
