"""A progress bar on stderr, after two seconds."""

import sys
import time
from typing import Any

DELAY, LINES = 2.0, 5.0  # s before a bar appears, and between lines


class Progress:
    """A bar from ``start`` to ``end`` that appears after two seconds on a terminal.

    ``show`` = "lines" writes a line every few seconds instead, for logs and pipes.
    """

    def __init__(self, title: str, start: float, end: float, show: bool | str | None = None) -> None:
        self.title, self.start, self.end = title, start, end
        self.show = sys.stderr.isatty() if show is None else show
        self.said = 0.0
        self.began, self.bar, self.task = time.perf_counter(), None, None

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
        if self.bar is None and time.perf_counter() - self.began > DELAY:
            from rich.console import Console
            from rich.progress import Progress as Bar

            self.bar = Bar(console=Console(stderr=True), transient=True)
            self.task = self.bar.add_task(self.title, total=self.end - self.start)
            self.bar.start()
        if self.bar is not None:
            self.bar.update(self.task, completed=value - self.start)

    def say(self, value: float) -> None:
        """A line with the share that is done, the first one after `DELAY`."""
        now = time.perf_counter() - self.began
        if now - self.said >= (LINES if self.said else DELAY):
            self.said = now
            share = (value - self.start) / (self.end - self.start) if self.end > self.start else 1.0
            sys.stderr.write(f"mbsd3d: {self.title}: {100.0 * share:.0f} % after {now:.0f} s\n")
            sys.stderr.flush()
