"""Small dense algebra on one thread: faster than on many, and the same bits whatever else the machine does.

And Python by turns: threads that all run Python hand its lock to each other at every small library call, which takes
time of its own (900 engines on two quiet cores: 6.8 s, by turns 6.1 s). With a lock of their own, handed on
only for the compiled time loops, they do not.
"""

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from contextvars import ContextVar
from functools import cache, wraps
from typing import ParamSpec, TypeVar

import numpy  # noqa: F401  # numpy and scipy load an OpenBLAS each: both must be there to be found
import scipy.linalg  # noqa: F401
from threadpoolctl import ThreadpoolController

P, T = ParamSpec("P"), TypeVar("T")


@cache
def _controller() -> ThreadpoolController:
    """The linear algebra libraries of this process; finding them takes a hundred times as long as setting them."""
    return ThreadpoolController()


def one_thread() -> AbstractContextManager:
    """Inside, BLAS and LAPACK calls use one thread."""
    return _controller().limit(limits=1)


def on_one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """The function with `one_thread` around it."""

    @wraps(function)
    def limited(*arguments: P.args, **named: P.kwargs) -> T:
        with one_thread():
            return function(*arguments, **named)

    return limited


_TURN: ContextVar[AbstractContextManager | None] = ContextVar("turn", default=None)  # the lock that this thread holds


@contextmanager
def taking_turns(lock: AbstractContextManager) -> Iterator[None]:
    """Inside, this thread is the only one of those that share the lock which runs Python."""
    with lock:
        token = _TURN.set(lock)
        try:
            yield
        finally:
            _TURN.reset(token)


@contextmanager
def turn_passed_on() -> Iterator[None]:
    """Inside, another thread has its turn; nothing happens where turns are not taken."""
    lock = _TURN.get()
    if lock is not None:
        lock.release()
    try:
        yield
    finally:
        if lock is not None:
            lock.acquire()
