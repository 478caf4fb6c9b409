"""What a person sees while waiting: one line on compiling, a bar after two seconds, both on stderr."""

import sys
import time
from functools import cache
from typing import Any

from .kernels.jit import is_warm

DELAY = 2.0  # s before a bar appears


@cache
def announce_compilation(part: str = "kernels") -> None:
    """Say once a process that a part of the code is being compiled, if it is not on disk yet."""
    if is_warm(part):
        return
    if part == "kernels" or is_warm():  # one line is enough at the very first run
        sys.stderr.write(f"mbsd3d: compiling {part}, once after installation (up to a minute) ...\n")
        sys.stderr.flush()


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
