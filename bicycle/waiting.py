"""Work that takes a while: a bar shows how far it is, and Ctrl-C keeps what is finished."""

from collections.abc import Iterable
from typing import TypeVar

from mbsd3d.base.progress import Progress

T = TypeVar("T")


def collected(title: str, results: Iterable[T], count: int, progress: bool | None = None) -> list[T]:
    """Results that are computed one after another.

    Parameters
    ----------
    title : str
        Beside the bar.
    results : iterable
        Each is computed when it is asked for.
    count : int
        How many there will be.
    progress : bool, optional
        Show a bar; None = on a terminal, after two seconds.

    Returns
    -------
    list
        After Ctrl-C those that were finished.
    """
    found: list[T] = []
    with Progress(title, 0, count, progress) as bar:
        try:
            for result in results:
                found.append(result)
                bar.update(len(found))
        except KeyboardInterrupt:
            pass
    return found
