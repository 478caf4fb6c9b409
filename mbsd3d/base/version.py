"""What is installed: the version of this package, and what others add by entry points."""

from importlib import metadata
from typing import TypeVar

from .errors import InputError

T = TypeVar("T")
__version__ = "0.2.0"


def load_entry(entry: metadata.EntryPoint, *kinds: type[T]) -> T:
    """The object of an entry point, an instance of one of ``kinds``.

    A ValueError of one line names the package, and the error of its import (SystemExit included) or the type found.
    """
    package = f"package '{entry.dist.name}'" if entry.dist else f"'{entry.value}'"
    try:
        found = entry.load()
    except (Exception, SystemExit) as error:
        text = " ".join(str(error).split())
        raise InputError(f"{package} cannot be loaded: {type(error).__name__}: {text}; repair or remove it") from error
    if not isinstance(found, kinds):
        raise InputError(f"{package} gives a {type(found).__name__}, not a {kinds[0].__name__}; repair or remove it")
    return found
