"""Tables of constraint rows: planned once for all mechanisms with the same kinds of rows, then filled with numbers.

Rows are alike if they are of the same kinds between the same bodies: then all but points, axes, values and signals is
the same. In a sweep over masses and lengths that is every cell.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import floats
from ..base.rotations import matrix
from ..kernels.kinds import ROWS_OF
from ..kernels.layout import PRIMITIVE, ROW, table
from ..mechanism.bodies import GROUND, Body, Ground
from ..mechanism.mechanism import Mechanism
from ..mechanism.primitives import Primitive


class Frames:
    """Poses of the bodies at the reference pose; the ground is the last one."""

    def __init__(self, system: Mechanism) -> None:
        bodies: list[Body | Ground] = [*system.bodies, GROUND]
        self.index = {id(body): i for i, body in enumerate(bodies)}
        self.r = np.concatenate([body.position for body in bodies]).reshape(-1, 3)
        self.R = matrix(np.concatenate([body.orientation for body in bodies]).reshape(-1, 4))
        self.centre = self.r + turned(self.R, stacked([body.com for body in bodies]))

    def points(self, on: ArrayLike, points: Sequence) -> np.ndarray:
        """Return (k, 3) R'(p - r) of world points p (k, 3) in the bodies ``on`` (k,)."""
        given, on = floats(stacked(points), "points of rows", "finite coordinates"), np.array(on)
        return self._local(on, given, given - self.r[on])

    def axes(self, on: ArrayLike, axes: Sequence) -> np.ndarray:
        """Return (k, 3) R'x of world directions x (k, 3) in the bodies ``on`` (k,)."""
        given, on = floats(stacked(axes), "axes of rows", "finite numbers"), np.array(on)
        return self._local(on, given, given)

    def _local(self, on: np.ndarray, given: np.ndarray, arms: np.ndarray) -> np.ndarray:
        """Return R' arms; on the ground what was given, to the sign of a zero."""
        return np.where((on == len(self.R) - 1)[:, None], given, turned(self.R[on].swapaxes(1, 2), arms))


def stacked(vectors: Sequence) -> Any:
    """Return arrays (3,) as one (k, 3), in a quarter of numpy's time for lists of arrays; anything else as it is."""
    if len(vectors) and all([type(x) is np.ndarray and x.shape == (3,) for x in vectors]):
        return np.concatenate(vectors).reshape(-1, 3)
    return vectors


def turned(R: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return R x of stacks (k, 3, 3) and (k, 3)."""
    return (R @ x[:, :, None])[:, :, 0]


Lists = tuple[tuple[int, ...], ...]  # one of each primitive


class Plan(NamedTuple):
    """Tables without their numbers, as bytes, since numpy copies records field by field."""

    primitive: tuple[bytes, np.dtype]
    row: tuple[bytes, np.dtype]
    driven: list[int]  # primitives with a signal


@lru_cache(maxsize=32)
def row_plan(
    kinds: tuple[int, ...], bodies: Lists, coordinates: Lists, driven: tuple[bool, ...], metres: tuple[bool, ...],
    holonomic: Lists,
) -> Plan:  # fmt: skip
    """Return the plan of primitives of these kinds, between these bodies and hinge coordinates."""
    out = table(PRIMITIVE, len(kinds))
    out["kind"], out["rows"] = kinds, [ROWS_OF[kind] for kind in kinds]
    out["row"] = np.cumsum(out["rows"]) - out["rows"]
    out["signal"] = out["body"] = out["coordinate"] = -1
    for name, lists in (("body", bodies), ("coordinate", coordinates)):
        lines, slots = places(tuple(map(len, lists)))
        out[name][lines, slots] = list(chain(*lists))
    rows_of = np.repeat(np.arange(out.size), out["rows"])
    row, with_signal = table(ROW, rows_of.size), np.array(driven, bool)[rows_of]
    row["body"], row["metres"] = out["body"][rows_of], np.array(metres, bool)[rows_of]
    row["holonomic"] = list(chain(*holonomic))
    row["drive"] = np.where(with_signal, np.cumsum(with_signal) - 1, -1)
    return Plan((out.tobytes(), out.dtype), (row.tobytes(), row.dtype), np.flatnonzero(driven).tolist())


@lru_cache(maxsize=128)
def places(counts: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Return (lines, slots) of the first entries of each line, as many as counted."""
    many = np.array(counts, int)
    lines = np.repeat(np.arange(many.size), many)
    return lines, np.arange(lines.size) - (np.cumsum(many) - many)[lines]


def row_tables(
    primitives: list[Primitive], coordinates: Lists, signals: list[int], frames: Frames, length: float, first: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return (table of primitives, table of rows).

    ``coordinates``: numbers of the hinge coordinates of each primitive; ``signals``: of the signals of those that have
    one; ``length``: of the model [m]; ``first``: place of their numbers, which follow each other.
    """
    index = frames.index
    plan = row_plan(
        tuple([x.kind for x in primitives]),
        tuple([tuple([index[id(body)] for body in x.bodies]) for x in primitives]),
        coordinates,
        tuple([x.signal is not None for x in primitives]),
        tuple([x.in_metres for x in primitives]),
        tuple([x.holonomic for x in primitives]),
    )
    out, row = (np.frombuffer(bytearray(lines), kind) for lines, kind in (plan.primitive, plan.row))
    out["signal"][plan.driven] = signals
    out["numbers"] = [len(x.numbers) for x in primitives]
    out["number"] = first + np.cumsum(out["numbers"]) - out["numbers"]
    fill(out, "value", [x.values for x in primitives])
    fill(out, "point", [x.points for x in primitives], frames.points)
    fill(out, "axis", [x.axes for x in primitives], frames.axes)
    fill(out, "second_axis", [x.second_axes for x in primitives], frames.axes)
    row["scale"] = np.where(row["metres"] == 1, 1.0 / length, 1.0)
    return out, row


def fill(out: np.ndarray, name: str, given: list[tuple], local: Callable | None = None) -> None:
    """Fill the numbers of each primitive from its first slot on.

    World vectors by ``local`` in the axes of the bodies.
    """
    lines, slots = places(tuple(map(len, given)))
    if lines.size:
        values = list(chain(*given))
        out[name][lines, slots] = local(out["body"][lines, slots], values) if local else values
