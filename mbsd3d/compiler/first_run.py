"""The first run after installation: kernels are compiled in two processes, and never nothing is said for long.

The second process compiles the time loop while the first one compiles the equations. Both write into the same files of
compiled code. The loop knows the equations by cells only (see `late`), so neither waits for the other. The second one
reads from a pipe whose other end the first one holds: it ends with the first one, however that ends.
"""

import atexit
import multiprocessing
import os
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path

from ..base.paths import drop_pieces
from .cache_folder import CACHE_FOLDER, EQUATIONS_CACHE_FOLDER, PLAIN_NUMBA, is_warm

REPORT_INTERVAL_SECONDS = 5.0  # [s] between two counts of the kernels
REPORT_TIMEOUT_SECONDS = 60.0  # [s] without a new kernel until the count ends
SLOW_COMPILE_SECONDS = 2.0  # [s] that one kernel may compile before a message says so
counters: list[threading.Thread] = []

HELPER_PROCESS_VARIABLE = "MBSD3D_SECOND"  # environment variable of the second process
HELPER_PROCESS_CODE = "\n".join(
    (
        "from mbsd3d.compiler.first_run import end_with_parent",
        "end_with_parent()",
        "from mbsd3d.run.precompile import compile_loop",
        "compile_loop()",
    )
)
others: list[subprocess.Popen[bytes]] = []


def write_message(text: str) -> None:
    """Write one line to stderr."""
    sys.stderr.write(f"mbsd3d: {text}\n")
    sys.stderr.flush()


@cache
def announce_compilation(part: str = "kernels") -> None:
    """Say once a process that a part of the code is being compiled, if it is not on disk yet."""
    if PLAIN_NUMBA:
        write_message(f"compiling {part} for this process alone, as MBSD3D_PLAIN_NUMBA=1 asks (minutes) ...")
        return
    if is_warm(part):
        return
    if part == "kernels" or is_warm():  # one line is enough at the very first run
        write_message(f"compiling {part}, once after installation (half a minute) ...")
        if part == "kernels":
            start_second()
        ended = threading.Event()
        atexit.register(ended.set)
        counters.append(threading.Thread(target=count_kernels, args=(part, ended), daemon=True))
        counters[-1].start()


def count_kernels(part: str, ended: threading.Event) -> None:
    """Write every five seconds how many kernels are on disk, until the part is complete or nothing more comes."""
    began = last = time.perf_counter()
    before = 0
    while (
        not ended.wait(REPORT_INTERVAL_SECONDS)
        and not is_warm(part)
        and time.perf_counter() - last < REPORT_TIMEOUT_SECONDS
    ):
        done = sum(1 for folder in (CACHE_FOLDER, EQUATIONS_CACHE_FOLDER) for _ in folder.rglob("*.code"))
        if done > before:
            before, last = done, time.perf_counter()
        sys.stderr.write(f"mbsd3d: {done} kernels after {time.perf_counter() - began:.0f} s\n")
        sys.stderr.flush()


@contextmanager
def announce_if_slow(name: str) -> Iterator[None]:
    """Say that a kernel is compiled if it takes long and nobody counts them."""

    def say_unless_counted() -> None:
        if not any(one.is_alive() for one in counters):
            write_message(f"compiling {name}, once after installation ...")

    timer = threading.Timer(SLOW_COMPILE_SECONDS, say_unless_counted)
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()


def start_second() -> None:
    """Start it, where there is another core and nobody has divided the work already."""
    divided = HELPER_PROCESS_VARIABLE in os.environ or multiprocessing.parent_process() or (os.cpu_count() or 1) == 1
    if others or divided or not Path(sys.executable).stem.startswith("python"):
        return
    with suppress(OSError):
        others.append(
            subprocess.Popen(
                [sys.executable, "-c", HELPER_PROCESS_CODE], env=os.environ | {HELPER_PROCESS_VARIABLE: "1"},
                stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            )
        )  # fmt: skip


def end_with_parent() -> None:
    """End this process as soon as the one that started it has ended, and leave no file that is not whole."""

    def watch() -> None:
        os.read(0, 1)  # nothing is ever written: it returns at the end of the pipe
        drop_pieces()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def wait_for_second() -> None:
    """Wait until the second process has ended: what it compiles need not be compiled twice."""
    for other in others:
        other.wait()
