"""A second process, which compiles the time loop while the first one compiles the equations.

Both write into the same files of compiled code. The loop knows the equations by cells only (see `late`), so neither
waits for the other.
"""

import multiprocessing
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

MARK = "MBSD3D_SECOND"  # environment variable of the second process
WORK = "from mbsd3d.run.ahead import compile_loop; compile_loop()"
others: list[subprocess.Popen] = []


def start_second() -> None:
    """Start it, where there is another core and nobody has divided the work already."""
    divided = MARK in os.environ or multiprocessing.parent_process() or (os.cpu_count() or 1) == 1
    if others or divided or not Path(sys.executable).stem.startswith("python"):
        return
    quiet = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
    with suppress(OSError):
        others.append(subprocess.Popen([sys.executable, "-c", WORK], env=os.environ | {MARK: "1"}, **quiet))


def wait_for_second() -> None:
    """Until it has ended: what it compiles need not be compiled twice."""
    for other in others:
        other.wait()
