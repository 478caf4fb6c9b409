"""Plans of tables: made once for all mechanisms of one structure, then filled with the numbers of each.

The structure is all but the numbers: which bodies each row, coordinate and force is between, its kind, and how many
numbers it has. In a sweep over masses and lengths that is the same in every cell. The tables of a model lie side by
side in one piece of memory, in words of eight bytes: a plan has the words that the structure determines, and the places
of the numbers, which are written all at once.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import chain
from typing import Any, NamedTuple

import numba
import numpy as np

from ..base.checks import floats
from ..kernels.kinds import ROWS_OF
from ..kernels.layout import BODY, COORDINATE, FORCE, PRIMITIVE, ROW, SIGNAL, STATE, TERM, record, table
from ..mechanism.bodies import GROUND, Body, Ground
from ..mechanism.mechanism import Mechanism
from ..mechanism.primitives import HOLONOMIC_ROWS

TABLES: dict[str, list[Any]] = {
    "body": BODY, "primitive": PRIMITIVE, "row": ROW, "coordinate": COORDINATE, "force": FORCE, "signal": SIGNAL,
    "term": TERM, "state": STATE,
}  # fmt: skip
VECTORS = ("number", "term_data", "gravity")
AXIS_PLACES = {  # kind of a coordinate -> (place in the table, 0 in a or 1 in b) of its axes
    "slide": ((0, 0),), "touch": ((2, 1),), "bearing": ((0, 0), (1, 0)), "angle": ((0, 0), (1, 0), (2, 1)), "path": (),
}  # fmt: skip
FRAME_COLUMNS = np.arange(9).reshape(3, 3).T  # places of the axes of a force in its frame, one a line


class RowStructure(NamedTuple):
    """Structure of a primitive: bodies and coordinates by number, how many of what, and its signal (-1: none)."""

    kind: int
    bodies: tuple[int, ...]
    coordinates: tuple[int, ...]
    points: int
    axes: int
    second_axes: int
    values: int
    numbers: int
    signal: int
    in_metres: bool


class CoordinateStructure(NamedTuple):
    """Structure of a hinge coordinate."""

    name: str  # of its kind
    kind: int
    bodies: tuple[int, int]
    numbers: int


class ForceStructure(NamedTuple):
    """Structure of a force element."""

    kind: int
    bodies: tuple[int, ...]
    points: int
    coordinate: int
    signals: tuple[int, ...]
    states: int
    measures: int
    numbers: int
    named: int
    option: int
    joint: int  # number of the part whose reaction it reads, -1: none


class Structure(NamedTuple):
    """Structure of a mechanism: two of one are alike but for numbers."""

    bodies: int
    rows: tuple[RowStructure, ...]
    holders: tuple[tuple[int, bool], ...]  # primitives of each part that may have rows; whether it switches
    coordinates: tuple[CoordinateStructure, ...]
    forces: tuple[ForceStructure, ...]
    first_measure: int  # that a force reads
    arms: tuple[int, ...]  # bodies on which joints and forces have points
    powers: tuple[int, ...]  # of the units of internal states
    signals: tuple[tuple[int, int], ...]
    terms: tuple[tuple[int, int, int], ...]


class Plan(NamedTuple):
    """The words of a structure, and where the numbers go."""

    words: bytes
    spans: tuple[tuple[str, int, int, np.dtype], ...]  # table, first byte, records, type
    where: np.ndarray  # words of the numbers: local points, local axes, then those that are written as they are
    points: np.ndarray  # bodies of the points,
    axes: np.ndarray  # of the axes,
    arms: np.ndarray  # and of the points that make the length of the model
    body_words: int  # the table of bodies comes first
    metres: np.ndarray  # rows that are measured in metres
    row_joint: np.ndarray  # (m,) number of the part of each row
    slices: tuple[slice, ...]  # rows of each part
    driven: tuple[int, ...]  # rows
    z_work: int
    z_drive: int
    z_impulse: int
    frictions: int


class Frames:
    """Poses of the bodies at the reference pose; the ground is the last one."""

    def __init__(self, system: Mechanism) -> None:
        bodies: list[Body | Ground] = [*system.bodies, GROUND]
        self.index = {id(body): i for i, body in enumerate(bodies)}
        self.r = np.concatenate([body.position for body in bodies]).reshape(-1, 3)
        self.R = np.concatenate([body.axes for body in bodies]).reshape(-1, 3, 3)
        self.turned_back = self.R.swapaxes(1, 2)
        self.centre = self.r + turned(self.R, np.concatenate([body.com for body in bodies]).reshape(-1, 3))

    def points(self, on: np.ndarray, points: Sequence) -> np.ndarray:
        """Return (k, 3) R'(p - r) of world points p (k, 3) in the bodies ``on`` (k,)."""
        given = finite(points, "points of rows", "finite coordinates")
        return self._local(on, given, given - self.r[on])

    def axes(self, on: np.ndarray, axes: Sequence) -> np.ndarray:
        """Return (k, 3) R'x of world directions x (k, 3) in the bodies ``on`` (k,)."""
        given = finite(axes, "axes of rows", "finite numbers")
        return self._local(on, given, given)

    def _local(self, on: np.ndarray, given: np.ndarray, arms: np.ndarray) -> np.ndarray:
        """Return R' arms; on the ground what was given, to the sign of a zero."""
        return np.where((on == len(self.R) - 1)[:, None], given, turned(self.turned_back[on], arms))


def stacked(vectors: Sequence) -> Any:
    """Return arrays (3,) as one (k, 3), in a quarter of numpy's time for lists of arrays; anything else as it is."""
    if len(vectors) and all([type(x) is np.ndarray and x.shape == (3,) for x in vectors]):
        return np.concatenate(vectors).reshape(-1, 3)
    return vectors


def finite(vectors: Sequence, what: str, remedy: str) -> np.ndarray:
    """Return vectors (k, 3) of finite numbers; an InputError names ``what``."""
    given = stacked(vectors)
    plain = type(given) is np.ndarray and given.dtype == np.float64
    return given if plain and math.isfinite(given.sum()) else floats(given, what, remedy)


def turned(R: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Return R x of stacks (k, 3, 3) and (k, 3)."""
    return (R @ x[:, :, None])[:, :, 0]


@lru_cache(maxsize=32)
def plan_of(s: Structure) -> Plan:
    """Return the plan of a structure."""
    rows = [ROWS_OF[row.kind] for row in s.rows]
    m, driven = sum(rows), driven_rows(s, rows)
    states, works = len(s.powers), len(s.forces) + sum(driven)
    counts = {
        "body": s.bodies, "primitive": len(s.rows), "row": m, "coordinate": len(s.coordinates), "force": len(s.forces),
        "signal": len(s.signals), "term": len(s.terms), "state": states + works + 6,
        "number": numbers_before_rows(s) + sum(x.numbers for x in s.rows),
        "term_data": s.terms[-1][2] if s.terms else 0, "gravity": 3,
    }  # fmt: skip
    kinds = {name: record(tuple(in_words(TABLES[name]))) if name in TABLES else np.dtype(float) for name in counts}
    ends = np.cumsum([0, *(kinds[name].itemsize * count for name, count in counts.items())]).tolist()
    words, places = np.zeros(ends[-1] // 8, np.int64), np.arange(ends[-1] // 8)
    pieces = dict(zip(counts, zip(ends[:-1], ends[1:], strict=True), strict=True))
    whole = {
        name: record(tuple((x[0], np.int64, *x[2:]) for x in TABLES[name])) if name in TABLES else np.dtype(np.int64)
        for name in counts
    }
    t, at = ({name: x[a // 8 : b // 8].view(whole[name]) for name, (a, b) in pieces.items()} for x in (words, places))
    fill_rows(s, rows, driven, t)
    fill_coordinates(s, t)
    steps = np.cumsum([0, *rows_of_holders(s, rows)]).tolist()
    slices = tuple(slice(i, j) for i, j in zip(steps[:-1], steps[1:], strict=True))
    fill_forces(s, slices, t)
    t["signal"][:], t["term"][:] = list(s.signals), list(s.terms)
    t["state"]["power"] = np.array([*s.powers, *[2] * works, *[1] * 6], float).view(np.int64)
    row_joint = np.repeat(np.arange(len(s.holders)), rows_of_holders(s, rows))
    points, axes, others = places_of_numbers(s, at)
    return Plan(
        words=words.tobytes(),
        spans=tuple((name, pieces[name][0], counts[name], kinds[name]) for name in counts),
        where=np.concatenate([*(x for x, _ in (*points, *axes)), *others]),
        points=joined([on for _, on in points]), axes=joined([on for _, on in axes]), arms=np.array(s.arms, np.int64),
        body_words=ends[1] // 8, metres=t["row"]["metres"] == 1, row_joint=row_joint,
        slices=slices, driven=tuple(np.flatnonzero(driven).tolist()),
        z_work=states, z_drive=states + len(s.forces), z_impulse=states + works,
        frictions=int((t["force"]["rows"] > 0).sum()),
    )  # fmt: skip


def in_words(fields: list) -> list:
    """Return the fields of a table with numbers in the place of functions, as there are without the compiler."""
    return [(x[0], np.int64 if x[1] is object else x[1], *x[2:]) for x in fields]


def numbers_before_rows(s: Structure) -> int:
    """Return how many numbers forces and coordinates have, which stand before those of rows."""
    return sum(x.numbers for x in s.forces) + sum(x.numbers for x in s.coordinates)


def rows_of_holders(s: Structure, rows: list[int]) -> list[int]:
    """Return the number of rows of each part."""
    each = iter(rows)
    return [sum(next(each) for _ in range(count)) for count, _ in s.holders]


def driven_rows(s: Structure, rows: list[int]) -> list[bool]:
    """Return which rows are driven; not those of parts that switch, whose signal is constant and does no work."""
    switching = [switches for count, switches in s.holders for _ in range(count)]
    return [
        row.signal >= 0 and not switches
        for row, switches, count in zip(s.rows, switching, rows, strict=True)
        for _ in range(count)
    ]


def fill_rows(s: Structure, rows: list[int], driven: list[bool], t: dict[str, np.ndarray]) -> None:
    """Fill the tables of primitives and of rows."""
    out, row, count = t["primitive"], t["row"], np.array(rows, np.int64)
    out["kind"], out["rows"], out["row"] = [x.kind for x in s.rows], count, np.cumsum(count) - count
    out["signal"], out["body"], out["coordinate"] = [x.signal for x in s.rows], -1, -1
    for i, x in enumerate(s.rows):
        out["body"][i, : len(x.bodies)], out["coordinate"][i, : len(x.coordinates)] = x.bodies, x.coordinates
    out["numbers"] = [x.numbers for x in s.rows]
    first = numbers_before_rows(s)
    out["number"] = first + np.cumsum(out["numbers"]) - out["numbers"]
    of_row = np.repeat(np.arange(len(rows)), count)
    row["body"], row["metres"] = out["body"][of_row], np.array([x.in_metres for x in s.rows], np.int64)[of_row]
    row["holonomic"] = list(chain(*(HOLONOMIC_ROWS[x.kind] for x in s.rows)))
    row["drive"] = np.where(driven, np.cumsum(driven) - 1, -1)


def fill_coordinates(s: Structure, t: dict[str, np.ndarray]) -> None:
    """Fill the table of hinge coordinates; numbers of their curves follow each other, after those of forces."""
    out = t["coordinate"]
    if s.coordinates:
        out["kind"], out["body"] = [x.kind for x in s.coordinates], [x.bodies for x in s.coordinates]
        many = np.array([x.numbers for x in s.coordinates])
        out["number"] = sum(x.numbers for x in s.forces) + np.cumsum(many) - many


def fill_forces(s: Structure, slices: tuple[slice, ...], t: dict[str, np.ndarray]) -> None:
    """Fill the table of force elements."""
    out = t["force"]
    for name, counts in (("state", "states"), ("measure", "measures"), ("number", "numbers")):
        out[counts] = [getattr(x, counts) for x in s.forces]
        out[name] = np.cumsum(out[counts]) - out[counts]
    out["measure"] += s.first_measure
    for i, x in enumerate(s.forces):
        held = x.bodies[: out["body"].shape[1]]  # a spring of a sum, which may have more, acts by its coordinates
        out["kind"][i], out["bodies"][i], out["body"][i, : len(held)] = x.kind, len(held), held
        out["signal"][i], out["coordinate"][i], out["named"][i] = x.signals, x.coordinate, x.named
        out["option"][i] = x.option
        if x.joint >= 0:
            own = slices[x.joint]
            out["row"][i], out["rows"][i] = own.start, own.stop - own.start


Placed = list[tuple[np.ndarray, np.ndarray]]  # words of vectors, and the body of each vector


def places_of_numbers(s: Structure, at: dict[str, np.ndarray]) -> tuple[Placed, Placed, list[np.ndarray]]:
    """Return the words of points and of axes with their bodies, and of all other numbers, in the order of `filled`."""
    primitive, coordinate, force = at["primitive"], at["coordinate"], at["force"]
    lists = {name: [getattr(x, name) for x in s.rows] for name in ("points", "axes", "second_axes", "values")}
    slots = {name: [(i, k) for i, count in enumerate(many) for k in range(count)] for name, many in lists.items()}
    named = {"points": "point", "axes": "axis", "second_axes": "second_axis"}
    rows = {
        name: (chosen(primitive[field], slots[name]), np.array([s.rows[i].bodies[k] for i, k in slots[name]], np.int64))
        for name, field in named.items()
    }
    ends = np.array([x.bodies for x in s.coordinates], np.int64).reshape(-1, 2)
    on = [(i, place, end) for i, x in enumerate(s.coordinates) for place, end in AXIS_PLACES[x.name]]
    hinge_axes = chosen(coordinate["axis"], [(i, place) for i, place, _ in on])
    held = [(i, k) for i, x in enumerate(s.forces) for k in range(x.points)]
    framed = [(i, k) for i, x in enumerate(s.forces) for k in range(len(x.bodies[:2]))]
    frames = force["frame"][tuple(np.array(framed, np.int64).reshape(-1, 2).T)][:, FRAME_COLUMNS].ravel()
    points = [
        rows["points"],
        (coordinate["point"].ravel(), ends.ravel()),
        (chosen(force["point"], held), np.array([s.forces[i].bodies[k] for i, k in held], np.int64)),
    ]
    axes = [
        rows["axes"],
        rows["second_axes"],
        (hinge_axes, np.array([ends[i, end] for i, _, end in on], np.int64)),
        (frames, np.repeat(np.array([s.forces[i].bodies[k] for i, k in framed], np.int64), 3)),
    ]
    plain = [at["row"]["scale"], chosen(primitive["value"], slots["values"]), at["number"], at["term_data"]]
    return points, axes, [*plain, at["gravity"], at["state"]["unit"]]


def chosen(field: np.ndarray, slots: list[tuple[int, int]]) -> np.ndarray:
    """Return the entries of a field at some (line, slot), side by side."""
    return field[tuple(np.array(slots, np.int64).reshape(-1, 2).T)].ravel()


def joined(pieces: list[np.ndarray]) -> np.ndarray:
    """Return whole numbers side by side."""
    return np.concatenate([np.zeros(0, np.int64), *pieces])


def filled(
    plan: Plan, frames: Frames, bodies: np.ndarray, points: list, axes: list, plain: list[np.ndarray]
) -> dict[str, np.ndarray]:
    """Return the tables with the table of bodies, world points and axes in the axes of their bodies, other numbers."""
    memory = bytearray(plan.words)
    words = np.frombuffer(memory, float)
    words[: plan.body_words] = bodies.view(np.ndarray).view(float)
    local = [
        *([frames.points(plan.points, points).ravel()] if points else ()),
        *([frames.axes(plan.axes, axes).ravel()] if axes else ()),
    ]
    words[plan.where] = np.concatenate([*local, *plain])
    found = {name: np.ndarray((count,), kind, memory, first) for name, first, count, kind in plan.spans}
    return {name: with_records(name, x) for name, x in found.items()} if numba.config.DISABLE_JIT else found


def with_records(name: str, words: np.ndarray) -> np.ndarray:
    """Return a table as kernels read it without the compiler: functions in it, fields as attributes."""
    if name not in TABLES:
        return words
    out = table(TABLES[name], words.size)
    for field in words.dtype.names or ():
        if field != "address":
            out[field] = words[field]
    return out
