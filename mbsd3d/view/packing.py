"""Arrays as short texts: whole steps, second differences, deflate, base64.

Motions are smooth, so that second differences of their steps are small numbers, whose bytes deflate well when all first
bytes come first, then all second ones. Sums of 32-bit integers wrap around and are exact: no error grows.
"""

import base64
import zlib
from typing import Any

import numpy as np

MISSING = -(2**31)  # stands for a value that is not finite


def pack(values: np.ndarray, step: float) -> dict[str, Any]:
    """Values (frames, ...) rounded to multiples of ``step``, wider where they would not fit into 30 bits."""
    values = np.asarray(values, float)
    finite = np.isfinite(values)
    largest = float(np.abs(values[finite]).max()) if finite.any() else 0.0
    step = max(float(step), largest / 2**30) or 1.0
    whole = np.where(finite, np.rint(np.where(finite, values, 0.0) / step), MISSING).astype(np.int32)
    rows = np.ascontiguousarray(whole.reshape(len(whole), -1).T)
    for _ in range(2):
        rows = np.diff(rows, axis=1, prepend=np.int32(0))
    zigzag = ((rows << 1) ^ (rows >> 31)).astype("<u4")  # small negative numbers become small positive ones
    planes = zigzag.reshape(-1, 1).view(np.uint8).T
    data = base64.b64encode(zlib.compress(planes.tobytes(), 9)).decode("ascii")
    return {"shape": list(values.shape), "step": step, "data": data}


def unpack(packed: dict[str, Any]) -> np.ndarray:
    """What `pack` was given, to half a step; NaN where a value was not finite."""
    raw = np.frombuffer(zlib.decompress(base64.b64decode(packed["data"])), np.uint8)
    zigzag = np.ascontiguousarray(raw.reshape(4, -1).T).view("<u4").astype(np.uint32).ravel()
    frames = packed["shape"][0]
    rows = ((zigzag >> 1) ^ (-(zigzag & 1).astype(np.int32)).view(np.uint32)).view(np.int32).reshape(-1, frames)
    for _ in range(2):
        rows = np.cumsum(rows, axis=1, dtype=np.int32)
    values = np.where(rows == MISSING, np.nan, rows * packed["step"])
    return np.ascontiguousarray(values.T).reshape(packed["shape"])
