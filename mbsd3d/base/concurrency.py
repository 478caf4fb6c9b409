"""Small dense algebra on one thread: faster than on many, and the same bits whatever else the machine does.

And Python by turns: threads that all run Python hand its lock to each other at every small library call, which takes
time of its own (900 engines on two quiet cores: 6.8 s, by turns 6.1 s). With a lock of their own, handed on
only for the compiled time loops, they do not.
"""

from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from contextvars import ContextVar
from functools import cache, wraps
from threading import Lock, local
from typing import ParamSpec, TypeVar

import numpy  # noqa: F401  # numpy and scipy load an OpenBLAS each: both must be there to be found
import scipy.linalg  # noqa: F401
from threadpoolctl import ThreadpoolController

P = ParamSpec("P")
T = TypeVar("T")


@cache
def _controller() -> ThreadpoolController:
    """Return the linear algebra libraries of this process; finding them takes a hundred times as long as setting."""
    return ThreadpoolController()


class _Inside(local):
    """How often a thread is inside `one_thread`."""

    always = 0  # 1: the whole process is
    depth: int

    def __init__(self) -> None:
        self.depth = _Inside.always


_INSIDE = _Inside()


@contextmanager
def one_thread() -> Iterator[None]:
    """Let BLAS and LAPACK calls inside the block use one thread; a nested block costs nothing."""
    depth = _INSIDE.depth = _INSIDE.depth + 1
    try:
        with nullcontext() if depth > 1 else _controller().limit(limits=1):
            yield
    finally:
        _INSIDE.depth = depth - 1


def keep_one_thread() -> None:
    """Let BLAS and LAPACK calls of this process use one thread from now on, in all threads that begin after this."""
    _controller().limit(limits=1)
    _Inside.always = 1
    _INSIDE.depth += 1


@contextmanager
def one_thread_for_all() -> Iterator[None]:
    """Let BLAS and LAPACK calls of the process use one thread inside the block, also in threads that begin there.

    Each of them would set and restore the number of the whole process, one while another computes.
    """
    with one_thread():
        _Inside.always, before = 1, _Inside.always
        try:
            yield
        finally:
            _Inside.always = before


def on_one_thread(function: Callable[P, T]) -> Callable[P, T]:
    """Wrap a function in `one_thread`."""

    @wraps(function)
    def limited(*arguments: P.args, **named: P.kwargs) -> T:
        with one_thread():
            return function(*arguments, **named)

    return limited


class AbandonedError(BaseException):
    """Raised in a thread whose work nobody waits for any more; no Exception, so that nothing answers it."""


class Turns:
    """A lock that can be closed for good: whoever asks for it then has to end."""

    def __init__(self) -> None:
        self.lock, self.closed = Lock(), False

    def acquire(self) -> None:
        """Wait for the turn; AbandonedError, with it, if it is of no use any more."""
        self.lock.acquire()
        if self.closed:
            raise AbandonedError

    def release(self) -> None:
        """Let the next thread take its turn."""
        self.lock.release()

    def close(self) -> None:
        """End every thread that asks from now on."""
        self.closed = True


_TURN: ContextVar[Turns | None] = ContextVar("turn", default=None)  # what this thread holds


@contextmanager
def taking_turns(turns: Turns) -> Iterator[None]:
    """Let this thread alone, of those that share the turns, run Python inside the block."""
    token = _TURN.set(turns)
    try:
        turns.acquire()
        yield
    finally:
        turns.release()
        _TURN.reset(token)


@contextmanager
def turn_passed_on() -> Iterator[None]:
    """Give the turn to another thread inside the block; nothing happens where turns are not taken."""
    turns = _TURN.get()
    if turns is not None:
        turns.release()
    try:
        yield
    finally:
        if turns is not None:
            turns.acquire()
