"""Immediate response to Ctrl-C, in the compiler too."""

import atexit
import os
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from types import FrameType

from ..base.paths import drop_pieces

INTERRUPT_EXIT_CODE = 130  # of a process that Ctrl-C ended, as a shell gives it
INTERRUPT_MESSAGE = "mbsd3d: interrupted"
INTERRUPT_GRACE_SECONDS = 0.15  # [s] until Python has responded wherever it can; chunks of the time loop take 0.05 s
SECOND_INTERRUPT_SECONDS = 1.0  # [s] within which a user may press again


@contextmanager
def answered_at_once() -> Iterator[threading.Event]:
    """End the process on Ctrl-C in the compiler within the block: Python does not respond for seconds there, and
    nothing is lost.

    Yields what says whether Ctrl-C has come: a library that is being loaded may answer it by an error of its own.

    Python marks a signal and acts when it is its turn; a thread that reads the marks sees whether it was. Elsewhere
    Ctrl-C is the usual KeyboardInterrupt: runs and sweeps keep what they have. A press soon after another is the same.
    """
    answered, came, pressed = threading.Event(), threading.Event(), -SECOND_INTERRUPT_SECONDS
    if threading.current_thread() is not threading.main_thread():
        yield came
        return

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal pressed
        answered.set()
        came.set()
        before, pressed = pressed, time.monotonic()
        if pressed - before >= SECOND_INTERRUPT_SECONDS:
            raise KeyboardInterrupt

    reader, writer = os.pipe()
    os.set_blocking(writer, False)
    before, handler = signal.set_wakeup_fd(writer, warn_on_full_buffer=False), signal.signal(signal.SIGINT, interrupt)
    threading.Thread(target=listen, args=(reader, answered), daemon=True).start()
    try:
        yield came
    finally:
        signal.signal(signal.SIGINT, handler)
        signal.set_wakeup_fd(before)
        os.close(writer)  # the thread reads the end, and ends


def listen(reader: int, answered: threading.Event) -> None:
    """Wait for Ctrl-C; end the process if the main thread is in the compiler."""
    while signs := os.read(reader, 1):
        if signs[0] == signal.SIGINT and not answered.wait(INTERRUPT_GRACE_SECONDS) and compiling():
            sys.stderr.write(f"{INTERRUPT_MESSAGE}\n")
            sys.stderr.flush()
            os._exit(INTERRUPT_EXIT_CODE)
        answered.clear()
    os.close(reader)


def end_now() -> None:
    """End the process in order, without waiting for threads or for the cleanup of modules."""
    atexit._run_exitfuncs()
    drop_pieces()
    for stream in (sys.stdout, sys.stderr):
        with suppress(OSError, ValueError):
            stream.flush()
    os._exit(INTERRUPT_EXIT_CODE)


def compiling() -> bool:
    """Return whether another thread holds the lock of numba's compiler, for longer than it takes to read a kernel."""
    module = sys.modules.get("mbsd3d.compiler.numba_private")
    if module is None:
        return False
    for _ in range(5):
        if not module.is_compiling():
            return False
        time.sleep(0.01)
    return True
