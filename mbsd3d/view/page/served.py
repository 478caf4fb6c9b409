"""What is served on this machine: where a browser finds it, how it is opened, waited for and ended."""

import threading
import webbrowser
from types import TracebackType
from typing import Self

from ...base.errors import InputError
from .guard import new_token
from .html import has_browser

HOST = "127.0.0.1"  # nobody else on the network sees it


class Served:
    """A page behind a guard; a context manager that stops it at its end. Subclasses set ``port``."""

    kind = "page"
    port: int

    def __init__(self) -> None:
        self._ended, self._token = threading.Event(), new_token()

    def __repr__(self) -> str:
        return f"<{self.kind}: {self.url}{' (stopped)' if self._ended.is_set() else ''}>"

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: type[BaseException] | BaseException | TracebackType | None) -> None:
        self.stop()

    @property
    def url(self) -> str:
        """Where a browser finds it, with the token that lets it in."""
        return f"http://{HOST}:{self.port}/?token={self._token}"

    def can_open(self) -> bool:
        """True if this machine can open a browser window."""
        return has_browser()

    def open(self) -> None:
        """Show it in the default browser; raises ValueError if there is no browser."""
        if not self.can_open() or not webbrowser.open(self.url):
            raise InputError(f"no browser was found on this machine; open {self.url} in one")

    def wait(self) -> None:
        """Return after Ctrl-C or `stop`; it is stopped then."""
        try:
            while not self._ended.wait(0.2):
                pass
        except KeyboardInterrupt:
            pass  # the way to end it
        finally:
            self.stop()

    def stop(self) -> None:
        """End it and free its port; browsers keep the last picture."""
        if not self._ended.is_set():
            self._ended.set()
            self._close()

    def _close(self) -> None:
        """What ends with it."""
        raise NotImplementedError
