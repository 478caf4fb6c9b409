"""Page and socket, served on this machine behind the guard: frames go out, keys and sliders come in."""

import asyncio
import logging
import os
import socket
import threading
from collections.abc import Callable, Mapping
from contextlib import suppress
from http import HTTPStatus
from typing import TYPE_CHECKING

from ...base.errors import InputError
from ..page.guard import GOODBYE_SECONDS, Visitors, guarded
from ..page.served import HOST

if TYPE_CHECKING:
    from websockets.asyncio.server import ServerConnection
    from websockets.http11 import Request, Response

MESSAGE_BYTES_MAX = 2**12  # [bytes] of the message of a key or a slider


class Outlet:
    """Newest news and newest frame for one browser, so that a slow one is not flooded."""

    def __init__(self) -> None:
        self.due, self.news, self.frame = asyncio.Event(), "", b""

    def put(self, news: str = "", frame: bytes = b"") -> None:
        """Replace the message that waits to be sent by a newer one."""
        self.news, self.frame = news or self.news, frame or self.frame
        self.due.set()

    async def feed(self, connection: "ServerConnection") -> None:
        """Send until the connection ends."""
        from websockets.exceptions import ConnectionClosed

        with suppress(ConnectionClosed):
            while True:
                await self.due.wait()
                self.due.clear()
                news, frame, self.news, self.frame = self.news, self.frame, "", b""
                if news:
                    await connection.send(news)
                if frame:
                    await connection.send(frame)


class Server:
    """Server of the files of ``pages`` (path -> content), and at /live of the newest that `publish` was given.

    ``greet()`` gives the first message for a browser; ``hear(text)`` takes one of its own, and says if it made sense;
    ``leave(last)`` is called when one has gone.
    """

    def __init__(
        self,
        port: int,
        token: str,
        pages: Mapping[str, str],
        greet: Callable[[], str],
        hear: Callable[[str], bool],
        leave: Callable[[bool], None],
    ) -> None:
        self.pages, self.greet, self.hear, self.leave = pages, greet, hear, leave
        self.token, self.visitors = token, Visitors()
        self.outlets: set[Outlet] = set()
        self.socket = bound(port)
        self.port = self.socket.getsockname()[1]
        self.loop, self.ended = asyncio.new_event_loop(), asyncio.Event()
        ready = threading.Event()
        self.thread = threading.Thread(target=self._run, args=(ready,), name="mbsd3d play server", daemon=True)
        self.thread.start()
        ready.wait()

    def publish(self, news: str = "", frame: bytes = b"") -> None:
        """Send to all browsers, from any thread."""
        self.loop.call_soon_threadsafe(self._put, news, frame)

    def _put(self, news: str, frame: bytes) -> None:
        """Send to all browsers, in the thread of the server."""
        for outlet in self.outlets:
            outlet.put(news, frame)

    def stop(self) -> None:
        """Close all connections and free the port."""
        self.loop.call_soon_threadsafe(self.ended.set)
        self.thread.join()

    def _run(self, ready: threading.Event) -> None:
        """Serve until closed; the function of the thread."""
        asyncio.set_event_loop(self.loop)
        try:
            self.loop.run_until_complete(self._serve(ready))
        finally:
            self.loop.close()

    async def _serve(self, ready: threading.Event) -> None:
        from websockets.asyncio.server import serve

        silent = logging.getLogger("mbsd3d play server")
        silent.addHandler(logging.NullHandler())  # tracebacks of those who hang up
        silent.propagate = False
        server = await serve(
            self._converse, sock=self.socket, process_request=guarded(self._answer, self.token),
            max_size=MESSAGE_BYTES_MAX, compression=None, close_timeout=GOODBYE_SECONDS, ping_interval=None,
            create_connection=self.visitors.connection,  # type: ignore[arg-type]  # websockets takes wrappers too
            logger=silent, server_header=None,
        )  # fmt: skip
        ready.set()
        await self.ended.wait()
        server.close()
        self.visitors.dismiss()
        await server.wait_closed()

    def _answer(self, connection: "ServerConnection", request: "Request") -> "Response | None":
        """Return a file; None = the socket."""
        path = request.path.partition("?")[0]
        if path == "/live" and "websocket" in map(str.lower, request.headers.get_all("Upgrade")):
            return None
        if path not in self.pages:
            return connection.respond(HTTPStatus.NOT_FOUND, "there is no such page\n")
        response = connection.respond(HTTPStatus.OK, self.pages[path])
        del response.headers["Content-Type"]
        response.headers["Content-Type"] = "text/html; charset=utf-8"
        response.headers["Cache-Control"] = "no-store"
        response.headers["X-Content-Type-Options"] = "nosniff"
        return response

    async def _converse(self, connection: "ServerConnection") -> None:
        """With one browser, until it leaves."""
        from websockets.exceptions import ConnectionClosed

        await connection.send(self.greet())
        outlet = Outlet()
        self.outlets.add(outlet)
        feed = asyncio.create_task(outlet.feed(connection))
        try:
            async for said in connection:
                if not (isinstance(said, str) and self.hear(said)):
                    await connection.close(1008, "not understood")
        except ConnectionClosed:
            pass  # it hung up
        finally:
            self.outlets.discard(outlet)
            feed.cancel()
            self.leave(not self.outlets)


def bound(port: int) -> socket.socket:
    """Return a socket at a port of this machine, 0 = any that is free; raise a ValueError if it cannot be had."""
    try:
        return socket.create_server((HOST, port))
    except OSError as error:
        why = os.strerror(error.errno) if error.errno else error
        raise InputError(
            f"play: port {port} cannot be used: {why}; give another one, or 0 for any that is free"
        ) from error
