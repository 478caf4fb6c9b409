"""Worker processes of a command: they end with it, on Ctrl-C at once."""

from collections.abc import Iterator
from concurrent.futures import BrokenExecutor, Executor
from contextlib import contextmanager

from ..base.errors import MbsError
from ..sweeps.executors import closing, cores, process_pool


@contextmanager
def working(most: int) -> Iterator[Executor]:
    """Return a pool of at most so many processes, one a core; raise MbsError if one of them is killed."""
    try:
        with closing(process_pool(min(most, cores()))) as pool:
            yield pool
    except BrokenExecutor as error:
        raise MbsError(
            "a process that worked for this command ended without a word (killed, or out of memory)",
            advice="run the command again: what is finished is kept",
        ) from error
