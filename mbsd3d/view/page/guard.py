"""Who may see a live view: the browser that was given its address, and no page of another site in the same browser.

Every request must name this machine as its host (a foreign name that points here is refused), come from no other
origin, and carry the token of the address: in the query of the first request, in a cookie of all later ones.
"""

import functools
import secrets
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus
from http.cookies import SimpleCookie
from typing import Any
from urllib.parse import parse_qs, urlsplit

NAMES = ("127.0.0.1", "localhost")
CLOSING = 0.2  # s that a browser has to say goodbye when the server stops
SERVING = threading.Lock()


def new_token() -> str:
    """Token of an address, which nobody guesses."""
    return secrets.token_urlsafe(16)


def refusal(headers: Any, path: str, port: int, token: str) -> str | None:
    """Why a request is refused; None = it is not."""
    if headers.get("Host") not in [f"{name}:{port}" for name in NAMES]:
        return "this address belongs to another machine"
    origin = headers.get("Origin")
    if origin is not None and origin not in [f"http://{name}:{port}" for name in NAMES]:
        return "another page may not read this view"
    if not secrets.compare_digest(given_token(headers, path, port).encode(), token.encode()):
        return "open the whole address that was printed, with its token"
    return None


def given_token(headers: Any, path: str, port: int) -> str:
    """The token of the query, else that of the cookie."""
    query = parse_qs(urlsplit(path).query).get("token", [""])[0]
    cookie = SimpleCookie(headers.get("Cookie", "")).get(f"mbsd3d-{port}")
    return query or (cookie.value if cookie else "")


def guarded(process: Callable | None, token: str) -> Callable:
    """The answer to a request behind the guard."""

    def answer(connection: Any, request: Any) -> Any:
        port = connection.local_address[1]
        why = refusal(request.headers, request.path, port, token)
        if why is not None:
            return connection.respond(HTTPStatus.FORBIDDEN, f"{why}\n")
        response = process(connection, request) if process else None
        if response is not None:
            response.headers["Set-Cookie"] = f"mbsd3d-{port}={token}; HttpOnly; SameSite=Strict; Path=/"
            response.headers["X-Frame-Options"] = "DENY"
        return response

    return answer


@contextmanager
def guarded_serving(token: str) -> Iterator[None]:
    """Servers of websockets that start inside are guarded, and end soon when they are stopped."""
    from websockets.asyncio import server

    serve = server.serve

    @functools.wraps(serve)
    def behind_guard(*arguments: Any, process_request: Callable | None = None, **options: Any) -> Any:
        options.setdefault("close_timeout", CLOSING)
        return serve(*arguments, process_request=guarded(process_request, token), **options)

    with SERVING:
        server.serve = behind_guard
        try:
            yield
        finally:
            server.serve = serve
