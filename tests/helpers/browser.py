"""Headless Chromium for the tests of pages: nothing leaves the machine, and whatever the page complains of is kept."""

import io
import os
import re
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

NAMES = ("chromium", "chromium-browser", "google-chrome")
# WebGL in software (no graphics card in a test), no background chatter, no name is ever resolved
FLAGS = (
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
)
OUTSIDE = re.compile(r"^(?!file:|data:|blob:|about:)")
PATIENCE = 180_000  # ms: a page of viser is up in 1-3 s; a minute is too short beside another suite on two cores


def missing(what: str) -> None:
    """Skip, or fail where the browser is required, with the remedy in one line."""
    if os.environ.get("MBSD3D_BROWSER") == "required":
        pytest.fail(what, pytrace=False)
    pytest.skip(what)


def executable() -> str:
    """The browser named by CHROMIUM, or the first one on PATH."""
    chosen = os.environ.get("CHROMIUM")
    if chosen:
        found = shutil.which(chosen)
        return found or missing(f"CHROMIUM={chosen} is not a program; set it to the path of Chromium or Chrome")
    found = next(filter(None, map(shutil.which, NAMES)), None)
    return found or missing(
        f"no browser ({', '.join(NAMES)}) on PATH: install one (Debian: apt install chromium) or set CHROMIUM"
    )


@contextmanager
def launch() -> Iterator[Any]:
    """One running browser (playwright's)."""
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        missing("the tests of pages need the package playwright; install it: pip install mbsd3d[test]")
    path = executable()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(FLAGS))
        yield browser
        browser.close()


@dataclass
class Visit:
    """An open page and what went wrong on it."""

    page: Any
    errors: list[str] = field(default_factory=list)  # of the console and uncaught ones
    refused: list[str] = field(default_factory=list)  # addresses outside the page that it asked for
    failed: list[str] = field(default_factory=list)  # requests without an answer

    @property
    def complaints(self) -> list[str]:
        """Everything that must not be on a page that works."""
        return [*self.errors, *self.refused, *self.failed]

    def run(self, script: str, value: Any = None) -> Any:
        """Result of JavaScript in the page."""
        return self.page.evaluate(script, value)

    def wait(self, script: str, value: Any = None) -> None:
        """Until the expression is true."""
        self.page.wait_for_function(script, arg=value, timeout=PATIENCE)

    def pixels(self, selector: str | None = None) -> np.ndarray:
        """What is seen of the window or of the first such element, (height, width, 3) uint8."""
        target = self.page.locator(selector).first if selector else self.page
        return np.asarray(Image.open(io.BytesIO(target.screenshot())).convert("RGB"))


@contextmanager
def visit(
    browser: Any, address: Path | str, *, width: int = 640, height: int = 480, query: str = "", **options: Any
) -> Iterator[Visit]:  # fmt: skip
    """A page of its own context: a file without any network, or an address on this machine (127.0.0.1). By default the
    reader wants it still, so that nothing plays by itself.
    """
    local = not isinstance(address, Path)
    options = {"reduced_motion": "reduce", **options}
    context = browser.new_context(offline=not local, viewport={"width": width, "height": height}, **options)
    seen = Visit(context.new_page())
    seen.page.set_default_timeout(PATIENCE)

    def judge(route: Any) -> None:
        if local and route.request.url.startswith(str(address)):
            route.continue_()
            return
        route.abort()

    def note(request: Any) -> None:
        if OUTSIDE.match(request.url) and not (local and request.url.startswith(str(address))):
            seen.refused.append(f"asks for {request.url[:200]}")

    context.route(OUTSIDE, judge)
    if not local:
        context.route_web_socket("**/*", lambda socket: seen.refused.append(f"asks for {socket.url}"))
    seen.page.on("request", note)
    seen.page.on("console", lambda m: seen.errors.append(f"console: {m.text}") if m.type == "error" else None)
    seen.page.on("pageerror", lambda e: seen.errors.append(f"uncaught: {e}"))
    seen.page.on("requestfailed", lambda r: seen.failed.append(f"failed: {r.url[:200]} {r.failure}"))
    try:
        seen.page.goto((str(address) if local else address.resolve().as_uri()) + query)
        yield seen
    finally:
        context.close()
