"""What is installed: the version of this package, other packages as they are loaded, and what they add to it."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import metadata
from types import FrameType
from typing import TypeVar

from .errors import InputError
from .wording import with_article

T = TypeVar("T")
__version__ = "0.2.0"


@contextmanager
def loading() -> Iterator[None]:
    """Raise KeyboardInterrupt after an import if Ctrl-C came inside the block.

    Compiled packages answer Ctrl-C by an ImportError, as if they were missing, and others go on as if nothing had been.
    """
    handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(handler):
        yield
        return
    came = []

    def interrupt(number: int, frame: FrameType | None) -> None:
        came.append(number)
        handler(number, frame)

    signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, handler)
        if came:
            raise KeyboardInterrupt from None


def load_entry(entry: metadata.EntryPoint, *kinds: type[T]) -> T:
    """Load the object of an entry point, an instance of one of ``kinds``.

    A ValueError of one line names the package, and the error of its import (SystemExit included) or the type found.
    """
    package = f"package '{entry.dist.name}'" if entry.dist else f"'{entry.value}'"
    try:
        with loading():
            found = entry.load()
    except (Exception, SystemExit) as error:
        text = " ".join(str(error).split())
        raise InputError(f"{package} cannot be loaded: {type(error).__name__}: {text}; repair or remove it") from error
    if not isinstance(found, kinds):
        raise InputError(
            f"{package} gives {with_article(type(found).__name__)}, not {with_article(kinds[0].__name__)}; "
            "repair or remove it"
        )
    return found
