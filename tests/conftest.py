"""Fixtures of several test modules."""

import pytest
from browser import launch


# Of a module and not of the session: while playwright runs, its event loop occupies this thread, and other
# modules' asyncio would meet it.
@pytest.fixture(scope="module")
def chromium():
    """One headless browser per module of tests, with no way out to the network."""
    with launch() as browser:
        yield browser
