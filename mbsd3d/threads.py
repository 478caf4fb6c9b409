"""Small dense algebra on one thread: faster than on many, and the same bits whatever else the machine does."""

from contextlib import AbstractContextManager
from functools import cache

import numpy  # noqa: F401  # numpy and scipy load an OpenBLAS each: both must be there to be found
import scipy.linalg  # noqa: F401
from threadpoolctl import ThreadpoolController


@cache
def _controller() -> ThreadpoolController:
    """The linear algebra libraries of this process; finding them takes a hundred times as long as setting them."""
    return ThreadpoolController()


def one_thread() -> AbstractContextManager:
    """Inside, BLAS and LAPACK calls use one thread."""
    return _controller().limit(limits=1)
