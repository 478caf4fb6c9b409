"""Processes of tests that kill: who is below one, who still runs, and how often they are killed."""

import os
from pathlib import Path

from helpers.sweep_models import MOMENTS

END = 15.0  # s: workers end at once, one that is still importing after that, which takes seconds on a busy machine

KILLS = int(os.environ.get("MBSD3D_TEST_KILLS", MOMENTS))


def children(pid):
    """All processes below one, from /proc."""
    parents = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
        except OSError:  # ended meanwhile
            continue
        parents.setdefault(int(fields[1]), []).append((int(folder.name), fields[0]))
    found, todo = [], [pid]
    while todo:
        for child, state in parents.get(todo.pop(), []):
            todo.append(child)
            if state != "Z":
                found.append(child)
    return found


def alive(pids):
    """Those that still run."""
    found = []
    for pid in pids:
        try:
            if (Path("/proc") / str(pid) / "stat").read_text().rpartition(")")[2].split()[0] != "Z":
                found.append(pid)
        except OSError:
            continue
    return found
