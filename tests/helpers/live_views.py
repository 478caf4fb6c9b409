"""What tests of live views ask of their servers and wait for."""

import re
import socket
import time


def listens(url: str) -> bool:
    """Whether something answers there."""
    host, port = re.match(r"http://(.+):(\d+)", url).groups()
    with socket.socket() as probe:
        return probe.connect_ex((host, int(port))) == 0


def until(condition, seconds=60.0):
    """Wait; False if it does not come true."""
    end = time.perf_counter() + seconds
    while time.perf_counter() < end:
        if condition():
            return True
        time.sleep(0.02)
    return False


def knock(url, **headers):
    """(status, headers) of a request over a plain socket: a browser would not send such a one."""
    host, port, path = re.fullmatch(r"http://(.+):(\d+)(/.*)", url).groups()
    lines = {"Host": f"{host}:{port}", "Connection": "close"} | {k.replace("_", "-"): v for k, v in headers.items()}
    text = f"GET {path} HTTP/1.1\r\n" + "".join(f"{k}: {v}\r\n" for k, v in lines.items()) + "\r\n"
    with socket.create_connection((host, int(port)), timeout=10) as line:
        line.sendall(text.encode())
        head = b""
        while b"\r\n\r\n" not in head and (piece := line.recv(4096)):
            head += piece
    first, *rest = head.split(b"\r\n\r\n")[0].decode().split("\r\n")
    return int(first.split()[1]), dict(line.split(": ", 1) for line in rest)


def connected(view, count=3):
    """Browsers that stay, as far as the server can tell."""
    from viser import __version__
    from websockets.sync.client import connect

    cookie = knock(view.url)[1]["Set-Cookie"].partition(";")[0]
    address, protocol = view.url.partition("?")[0].replace("http", "ws"), [f"viser-v{__version__}"]
    return [connect(address, additional_headers={"Cookie": cookie}, subprotocols=protocol) for _ in range(count)]
