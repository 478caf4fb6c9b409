"""Ctrl-C, workers and noise of all tests; fixtures of several modules: a browser, a page."""

import os
import signal

import pytest
from helpers.browser import launch
from helpers.noise import noisy
from helpers.page_mechanism import mechanism
from helpers.pages import COUNT, END, TITLE, opened, seek

from mbsd3d import simulate
from mbsd3d.base import progress
from mbsd3d.equations import compiled as model


@pytest.fixture(scope="session", autouse=True)
def noise_on_masses():
    """Relative noise of ``MBSD3D_TEST_NOISE``, e.g. 1e-15, on every mass and inertia (``make test-perturbed``)."""
    with pytest.MonkeyPatch.context() as patch:
        if size := float(os.environ.get("MBSD3D_TEST_NOISE", "0")):
            patch.setattr(model, "body_table", noisy(model.body_table, size))
        yield


@pytest.fixture(autouse=True)
def silence(monkeypatch):
    """What commands say while they work depends on how busy the machine is; tests of it ask processes."""
    monkeypatch.setattr(progress.Heartbeat, "beat", lambda self: None)


def pytest_configure():
    """A suite started in the background inherits that Ctrl-C is ignored; tests send it to themselves and others."""
    if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers():
    """`-n auto`: the cores this process may use, at most 8; xdist would count the machine's, without their threads."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return min(cores, 8)


# Of a module and not of the session: while playwright runs, its event loop occupies this thread, and other
# modules' asyncio would meet it.
@pytest.fixture(scope="module")
def chromium():
    """One headless browser per module of tests, with no way out to the network."""
    with launch() as browser:
        yield browser


@pytest.fixture(scope="module")
def motion():
    """0.6 s of a crank, an arm, a tail on a spring and a bead that flies."""
    return simulate(mechanism(), END, output=COUNT)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Of the pages; with a space and an umlaut in its name."""
    return tmp_path_factory.mktemp("meine Ansichten ä")


@pytest.fixture(scope="module")
def film(motion, folder):
    """The page of the motion."""
    motion.animate(folder / "film", frames=COUNT, title=TITLE)
    return folder / "film.html"


@pytest.fixture(scope="module")
def open_film(chromium, film):
    """One window for all tests that do not need their own."""
    with opened(chromium, film, width=800, height=460) as seen:
        yield seen


@pytest.fixture
def page(open_film):
    """The window as at the start: paused at the first frame, first view, wide."""
    open_film.page.set_viewport_size({"width": 800, "height": 460})
    open_film.page.locator("#switches").evaluate("e => { e.open = false; }")
    open_film.page.mouse.move(400, 5)
    seek(open_film, 0.0)
    open_film.page.locator("#camera").click()
    return open_film
