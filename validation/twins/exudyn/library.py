"""The installed Exudyn: found, of a version without known bugs, and quiet."""

import warnings
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from importlib import metadata
from io import StringIO
from typing import Any

from validation.twins.base import EngineMissing, release

OLDEST = (1, 13, 6)
"""Earlier versions name their settings otherwise, and have no coordinate of a hinge (MarkerBodiesRelative...)."""

WANTED = ".".join(map(str, OLDEST))


def exudyn() -> Any:
    """The module, imported when it is asked for.

    EngineMissing if it is not installed or older than `OLDEST`.
    """
    try:
        version = metadata.version("exudyn")
    except metadata.PackageNotFoundError:
        raise EngineMissing(f"Exudyn is not installed; pip install 'exudyn>={WANTED}'") from None
    check_version(version)
    try:
        import exudyn as module
        import exudyn.itemInterface
    except ImportError as error:
        raise EngineMissing(f"Exudyn {version} does not load: {error}; install it again") from None
    return module


def check_version(version: str) -> None:
    """EngineMissing for a version before `OLDEST`."""
    if release(version) < OLDEST:
        raise EngineMissing(f"Exudyn {version} is older than {WANTED}; pip install -U 'exudyn>={WANTED}'")


@contextmanager
def quiet(module: Any) -> Iterator[StringIO]:
    """Nothing reaches the terminal, what was said is kept; the setting of the console is restored."""
    said, before = StringIO(), module.config.printToConsole
    try:
        with redirect_stdout(said), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Exudyn's own hints; what matters ends in an error text
            module.config.printToConsole = True
            yield said
    finally:
        module.config.printToConsole = before
