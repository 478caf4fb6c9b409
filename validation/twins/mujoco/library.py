"""MuJoCo itself: loaded when it is asked for, refused by version, kept from writing its log into the working folder."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from validation.twins.base import EngineMissing, release

OLDEST = (4, 0, 0)  # before it, RK4 turned free and ball joints at second order only
SPARSE_BUG = (4, 0, 0)  # its sparse Cholesky factor was wrong, mended in 4.0.1


def require() -> Any:
    """The module ``mujoco``.

    EngineMissing if it is not installed, or older than `OLDEST`.
    """
    try:
        import mujoco
    except ImportError as error:
        raise EngineMissing(f"MuJoCo is not installed ({error}); pip install 'mujoco-core>=4.0.1'") from None
    if release(mujoco.__version__) < OLDEST:
        raise EngineMissing(
            f"MuJoCo {mujoco.__version__} integrates orientations at second order with RK4; "
            "pip install 'mujoco-core>=4.0.1'"
        )
    return mujoco


@contextmanager
def quiet(mujoco: Any) -> Iterator[None]:
    """Warnings are read from the data afterwards; MuJoCo would also write them to a file in the working folder."""
    before, silent = mujoco.MjLogConfig.get(), mujoco.MjLogConfig.get()
    silent.logto_file = silent.logto_console = False
    silent.set()
    try:
        yield
    finally:
        before.set()
