"""Access to a live view: only for the browser that was given its address, not for other sites in the same browser.

Every request must name this machine as its host (a foreign name that points here is refused), come from no other
origin, and carry the token of the address: in the query of the first request, in a cookie of all later ones.
"""

import functools
import secrets
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from http import HTTPStatus
from http.cookies import CookieError, SimpleCookie
from typing import Any
from urllib.parse import parse_qs
from weakref import WeakSet

LOCAL_HOST_NAMES = ("127.0.0.1", "localhost")
GOODBYE_SECONDS = 0.2  # [s] a browser has to close its connection when the server stops
SERVER_LOCK = threading.Lock()


def new_token() -> str:
    """Return a random token of an address."""
    return secrets.token_urlsafe(16)


SINGLE_HEADERS = ("Host", "Origin", "Cookie")  # headers that a request may have once; two of them are ambiguous


def doubled(headers: Any) -> str | None:
    """Return why a request is refused if a header that decides on access stands in it more than once; else None."""
    names = [name for name in SINGLE_HEADERS if len(headers.get_all(name)) > 1]
    return f"a request has one header {names[0]}" if names else None


def refusal(headers: Any, path: str, port: int, token: str) -> str | None:
    """Return why a request is refused; None = it is not."""
    if headers.get("Host") not in [f"{name}:{port}" for name in LOCAL_HOST_NAMES]:
        return "this address belongs to another machine"
    origin = headers.get("Origin")
    if origin is not None and origin not in [f"http://{name}:{port}" for name in LOCAL_HOST_NAMES]:
        return "another page may not read this view"
    if not secrets.compare_digest(given_token(headers, path, port).encode("utf-8", "replace"), token.encode()):
        return "open the whole address that was printed, with its token"
    return None


def given_token(headers: Any, path: str, port: int) -> str:
    """Return the token of the query, else that of the cookie."""
    query = parse_qs(path.partition("?")[2]).get("token", [""])[0]
    cookie = SimpleCookie()
    with suppress(CookieError):  # another page on this machine may have set what is none
        cookie.load(headers.get("Cookie", ""))
    found = cookie.get(f"mbsd3d-{port}")
    return query or (found.value if found else "")


def guarded(process: Callable | None, token: str) -> Callable:
    """Return the function that answers requests behind the guard."""

    def answer(connection: Any, request: Any) -> Any:
        port, why = connection.local_address[1], doubled(request.headers)
        if why is not None:
            return connection.respond(HTTPStatus.BAD_REQUEST, f"{why}\n")
        why = refusal(request.headers, request.path, port, token)
        if why is not None:
            return connection.respond(HTTPStatus.FORBIDDEN, f"{why}\n")
        response = process(connection, request) if process else None
        if response is not None:
            response.headers["Set-Cookie"] = f"mbsd3d-{port}={token}; HttpOnly; SameSite=Strict; Path=/"
            response.headers["X-Frame-Options"] = "DENY"
        return response

    return answer


class Visitors:
    """Connections of a server, which must not wait at its end for incomplete requests of browsers."""

    def __init__(self) -> None:
        self.came: WeakSet[Any] = WeakSet()

    def connection(self, *arguments: Any, **options: Any) -> Any:
        """Return a new connection, for ``create_connection`` of websockets."""
        from websockets.asyncio.server import ServerConnection

        made = ServerConnection(*arguments, **options)
        self.came.add(made)
        return made

    def dismiss(self) -> None:
        """Close the connections without a complete request; called in the thread of the server."""
        for connection in self.came:
            if connection.protocol.state.name == "CONNECTING" and connection.transport is not None:
                connection.transport.abort()


@contextmanager
def guarded_serving(token: str, visitors: Visitors) -> Iterator[None]:
    """Guard servers of websockets that start inside, and let them stop soon."""
    from websockets.asyncio import server

    serve, names = server.serve, vars(server)

    @functools.wraps(serve)
    def behind_guard(*arguments: Any, process_request: Callable | None = None, **options: Any) -> Any:
        options.setdefault("close_timeout", GOODBYE_SECONDS)
        options.setdefault("create_connection", visitors.connection)
        return serve(*arguments, process_request=guarded(process_request, token), **options)

    with SERVER_LOCK:
        names["serve"] = behind_guard
        try:
            yield
        finally:
            names["serve"] = serve
