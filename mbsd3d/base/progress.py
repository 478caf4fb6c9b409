"""Progress on stderr after two seconds: a bar on a terminal, lines in a pipe every five."""

import sys
import threading
import time
from collections.abc import Callable
from typing import Any

from .errors import InputError

BAR_DELAY_SECONDS, LINE_INTERVAL_SECONDS = 2.0, 5.0  # s before a bar appears, and between lines


class Heartbeat:
    """A command at work: a line says so after two seconds, and after every five in which nothing else was said.

    While one is on, runs without a terminal tell their progress in lines too.
    """

    on: "Heartbeat | None" = None

    def __init__(self, title: Callable[[], str]) -> None:
        self.title, self.ended = title, threading.Event()
        self.began = self.last = time.perf_counter()

    def __enter__(self) -> "Heartbeat":
        Heartbeat.on = self
        threading.Thread(target=self.beat, daemon=True).start()
        return self

    def __exit__(self, *error: Any) -> None:
        self.end()

    def end(self) -> None:
        """Nothing more is said, e.g. while a command waits for its user."""
        self.ended.set()
        Heartbeat.on = None

    def beat(self) -> None:
        """Until the end."""
        while not self.ended.wait(0.1 * LINE_INTERVAL_SECONDS):
            now = time.perf_counter()
            if now - self.last >= (LINE_INTERVAL_SECONDS if self.last > self.began else BAR_DELAY_SECONDS):
                say(f"{self.title()}: at work for {now - self.began:.0f} s")


def said() -> None:
    """Something was said: the next sign of life is due later."""
    if Heartbeat.on is not None:
        Heartbeat.on.last = time.perf_counter()


def say(text: str) -> None:
    """A line on stderr."""
    said()
    sys.stderr.write(f"mbsd3d: {text}\n")
    sys.stderr.flush()


class Progress:
    """A bar from ``start`` to ``end`` that appears after two seconds on a terminal.

    ``show`` = "lines" writes a line every few seconds instead, for logs and pipes.
    """

    def __init__(self, title: str, start: float, end: float, show: bool | str | None = None) -> None:
        self.title, self.start, self.end = title, start, end
        if not (isinstance(show, bool | None) or (isinstance(show, str) and show == "lines")):
            raise InputError(f"progress = {show!s:.80}; give True, False, 'lines' or None")
        piped = "lines" if Heartbeat.on is not None else False
        self.show = (sys.stderr.isatty() or piped) if show is None else show
        self.said = 0.0
        self.began = time.perf_counter()
        self.bar: Any = None  # of rich, imported late
        self.task: Any = None

    def __enter__(self) -> "Progress":
        self.began = time.perf_counter()
        return self

    def __exit__(self, *error: Any) -> None:
        if self.bar is not None:
            self.bar.stop()

    def update(self, value: float) -> None:
        """Move to ``value``."""
        if not self.show:
            return
        if self.show == "lines":
            self.say(value)
            return
        if self.bar is None and time.perf_counter() - self.began > BAR_DELAY_SECONDS:
            from rich.console import Console
            from rich.progress import Progress as Bar

            self.bar = Bar(console=Console(stderr=True), transient=True)
            self.task = self.bar.add_task(self.title, total=self.end - self.start)
            self.bar.start()
        if self.bar is not None:
            said()
            self.bar.update(self.task, completed=value - self.start)

    def say(self, value: float) -> None:
        """A line with the share that is done, the first one after `DELAY`."""
        now = time.perf_counter() - self.began
        if now - self.said >= (LINE_INTERVAL_SECONDS if self.said else BAR_DELAY_SECONDS):
            self.said = now
            share = (value - self.start) / (self.end - self.start) if self.end > self.start else 1.0
            say(f"{self.title}: {100.0 * share:.0f} % after {now:.0f} s")
