"""A function of the user's made callable from the compiled time loop, through its address."""

import functools
import re
from collections.abc import Callable

import numba
import numpy as np
from numba import types
from numba.extending import is_jitted

from ...base.errors import InputError
from ...compiler.numba_private import CFunc
from ...kernels.layout import CUSTOM_FORCE_BODIES_MAX, data_records

# [1] place in Data.wrench that the wrapper sets to 0 when the function has returned
RETURN_FLAG_INDEX = 6 * CUSTOM_FORCE_BODIES_MAX


def wrapped(function: Callable) -> Callable:
    """Return the function behind pointers and counts; an exception leaves the mark of `RETURN_FLAG_INDEX` as it is."""
    array = numba.carray

    def called(t, poses, k, z, states, numbers, n, wrench, z_dot):
        loads = array(wrench, (RETURN_FLAG_INDEX + 1,))
        try:
            function(
                t, array(poses, (k,)), array(z, (states,)), array(numbers, (n,)), loads[: 6 * k].reshape((k, 6)),
                array(z_dot, (states,)),
            )  # fmt: skip
            loads[RETURN_FLAG_INDEX] = 0.0
        except Exception:  # numba knows no narrower one
            loads[RETURN_FLAG_INDEX] = np.nan

    return called


def uncompiled(function: Callable) -> Callable:
    """Return the function for a process without the compiler: arrays arrive as they are, and exceptions go up."""
    plain = getattr(function, "py_func", function)

    def called(t, poses, k, z, states, numbers, n, wrench, z_dot):
        plain(t, poses[:k], z, numbers, wrench[: 6 * k].reshape(k, 6), z_dot)
        wrench[RETURN_FLAG_INDEX] = 0.0

    return called


@functools.lru_cache(maxsize=256)
def callback(function: Callable, dtype: type, parameters: type) -> CFunc:
    """Return the C function for real or complex numbers, and parameters; ``.address`` is where it is."""
    real, given = (types.complex128 if x is complex else types.float64 for x in (dtype, parameters))
    pose = numba.from_dtype(np.dtype(data_records(dtype)["pose"]))
    compiled = function if is_jitted(function) else numba.njit(error_model="numpy", boundscheck=True)(function)
    pointer, size = types.CPointer, types.intp
    signature = types.void(
        types.float64, pointer(pose), size, pointer(real), size, pointer(given), size, pointer(real),
        pointer(real),
    )  # fmt: skip
    found = numba.cfunc(signature)(wrapped(compiled))
    returned = compiled.nopython_signatures[-1].return_type
    if returned is not types.none:
        raise InputError(f"it returns {returned}, which nobody reads; fill loads and z_dot and return nothing")
    return found


def reason(error: Exception) -> str:
    """Return the first line of numba's message that says something."""
    if isinstance(error, KeyError):  # all that numba says of a field that a record does not have
        return f"bodies have no {error}, they have r, R, velocity, w"
    lines = [re.sub(r"\x1b\[[0-9;]*m", "", line).strip() for line in str(error).splitlines()]
    telling = [line for line in lines if line and not line.startswith("Failed in nopython mode")]
    return (telling or [type(error).__name__])[0]
