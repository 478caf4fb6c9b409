"""A progress bar on stderr, after two seconds."""

import sys
import time
from typing import Any

DELAY = 2.0  # s before a bar appears


class Progress:
    """A bar from ``start`` to ``end`` that appears after two seconds on a terminal (or when asked for)."""

    def __init__(self, title: str, start: float, end: float, show: bool | None = None) -> None:
        self.title, self.start, self.end = title, start, end
        self.show = sys.stderr.isatty() if show is None else show
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
        if self.bar is None and time.perf_counter() - self.began > DELAY:
            from rich.console import Console
            from rich.progress import Progress as Bar

            self.bar = Bar(console=Console(stderr=True), transient=True)
            self.task = self.bar.add_task(self.title, total=self.end - self.start)
            self.bar.start()
        if self.bar is not None:
            self.bar.update(self.task, completed=value - self.start)
