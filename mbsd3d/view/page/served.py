"""Pages served on this machine: their address, how they are opened, waited for and stopped."""

import threading
import webbrowser
from types import TracebackType
from typing import Self

from ...base.errors import InputError
from .guard import new_token
from .html import has_browser

HOST = "127.0.0.1"  # nobody else on the network sees it


class Served:
    """Page behind a guard; a context manager that stops it at its end. Subclasses set ``port``."""

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
        """Return the address, with the token that grants access."""
        return f"http://{HOST}:{self.port}/?token={self._token}"

    def can_open(self) -> bool:
        """Return True if this machine can open a browser window."""
        return has_browser()

    def open(self) -> None:
        """Show the page in the default browser; raise a ValueError if there is no browser."""
        if not self.can_open() or not webbrowser.open(self.url):
            raise InputError(f"no browser was found on this machine; open {self.url} in one")

    def wait(self) -> None:
        """Wait for Ctrl-C or `stop`; the page is stopped then."""
        try:
            while not self._ended.wait(0.2):
                pass
        except KeyboardInterrupt:
            pass  # the way to end it
        finally:
            self.stop()

    def stop(self) -> None:
        """Stop the page and free its port; browsers keep the last picture."""
        if not self._ended.is_set():
            self._ended.set()
            self._close()

    def _close(self) -> None:
        """Close what ends with the page."""
        raise NotImplementedError
