"""What is said while kernels are compiled: once after installation, and never nothing for long."""

import atexit
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache

from .cache_folder import CACHE, EQUATIONS, PLAIN_NUMBA, is_warm
from .second import start_second

PAUSE, STALLED = 5.0, 60.0  # s between counts of the kernels, and without a new one until the count ends
SILENT = 2.0  # s that may pass while one kernel is compiled before that is said
counters: list[threading.Thread] = []


def say(text: str) -> None:
    """Write one line to stderr."""
    sys.stderr.write(f"mbsd3d: {text}\n")
    sys.stderr.flush()


@cache
def announce_compilation(part: str = "kernels") -> None:
    """Say once a process that a part of the code is being compiled, if it is not on disk yet."""
    if PLAIN_NUMBA:
        say(f"compiling {part} for this process alone, as MBSD3D_PLAIN_NUMBA=1 asks (minutes) ...")
        return
    if is_warm(part):
        return
    if part == "kernels" or is_warm():  # one line is enough at the very first run
        say(f"compiling {part}, once after installation (half a minute) ...")
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
    while not ended.wait(PAUSE) and not is_warm(part) and time.perf_counter() - last < STALLED:
        done = sum(1 for folder in (CACHE, EQUATIONS) for _ in folder.rglob("*.code"))
        if done > before:
            before, last = done, time.perf_counter()
        sys.stderr.write(f"mbsd3d: {done} kernels after {time.perf_counter() - began:.0f} s\n")
        sys.stderr.flush()


@contextmanager
def not_silent(name: str) -> Iterator[None]:
    """Say that a kernel is compiled if it takes long and nobody counts them."""
    text = f"compiling {name}, once after installation ..."
    timer = threading.Timer(SILENT, lambda: any(one.is_alive() for one in counters) or say(text))
    timer.daemon = True
    timer.start()
    try:
        yield
    finally:
        timer.cancel()
