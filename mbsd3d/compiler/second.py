"""A second process, which compiles the time loop while the first one compiles the equations.

Both write into the same files of compiled code. The loop knows the equations by cells only (see `late`), so neither
waits for the other. The second one reads from a pipe whose other end the first one holds: it ends with the first one,
however that ends.
"""

import multiprocessing
import os
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from threading import Thread

from ..base.paths import drop_pieces

MARK = "MBSD3D_SECOND"  # environment variable of the second process
WORK = "\n".join(
    (
        "from mbsd3d.compiler.second import end_with_parent",
        "end_with_parent()",
        "from mbsd3d.run.precompile import compile_loop",
        "compile_loop()",
    )
)
others: list[subprocess.Popen] = []


def start_second() -> None:
    """Start it, where there is another core and nobody has divided the work already."""
    divided = MARK in os.environ or multiprocessing.parent_process() or (os.cpu_count() or 1) == 1
    if others or divided or not Path(sys.executable).stem.startswith("python"):
        return
    streams = {"stdin": subprocess.PIPE, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with suppress(OSError):
        others.append(subprocess.Popen([sys.executable, "-c", WORK], env=os.environ | {MARK: "1"}, **streams))


def end_with_parent() -> None:
    """End this process as soon as the one that started it has ended, and leave no file that is not whole."""

    def watch() -> None:
        os.read(0, 1)  # nothing is ever written: it returns at the end of the pipe
        drop_pieces()
        os._exit(1)

    Thread(target=watch, daemon=True).start()


def wait_for_second() -> None:
    """Wait until the second process has ended: what it compiles need not be compiled twice."""
    for other in others:
        other.wait()
