"""Tables of the kernels from the parts of a system: one function per table of `Model`."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..base.errors import InputError
from ..base.rotations import cross, matched_perpendiculars, perpendiculars
from ..dynamics.applied_forces import number_of_law
from ..kernels.layout import BODY, MEASURE, REFLECTED, table
from ..mechanism.bodies import GROUND, Part
from ..mechanism.force_element import ForceRecord
from ..mechanism.measures import HOLDING_MEASURES, MEASURES, Measure
from ..mechanism.mechanism import Mechanism
from ..mechanism.primitives import Coordinate, Primitive, TurnRate
from ..mechanism.signals import Signal
from .plans import AXIS_PLACES, ForceStructure, Frames, Plan, RowStructure, stacked

EQUAL_MOMENT_TOLERANCE = 1e-6  # [1] of the largest moment of inertia: difference of moments that counts as none
NO_AXIS, NO_INVERSE = (0.0,) * 3, (0.0,) * 9
AXES_IN_ORDER = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)


def key_of(x: Coordinate) -> tuple:
    """Return a key: two coordinates are the same when kind, bodies and geometry are."""
    return (x.kind, id(x.a), id(x.b), x.geometry)


def points_of_parts(
    system: Mechanism, records: list[ForceRecord], index: dict[int, int]
) -> list[tuple[int, np.ndarray]]:
    """Return (number of the body, world point) of all points at which forces and joints act on moving bodies."""
    found = [
        (index[id(body)], point) for r in records if r.points for body, point in zip(r.bodies, r.points, strict=True)
        if body is not GROUND
    ]  # fmt: skip
    for joint in system.joints:
        point = joint.point()
        found += [(index[id(body)], point) for body in joint.bodies() if body is not GROUND]
    return found


def own_length(on: np.ndarray, points: list[np.ndarray], frames: Frames, gyration: float) -> float:
    """Return the length of the largest body [m]: farthest joint or force point from its centre of mass, or gyration."""
    largest = gyration
    if points:
        arms = stacked(points) - frames.centre[on]
        largest = max(largest, math.sqrt((arms * arms).sum(axis=1).max()))
    return largest or 1.0


def signals_of(system: Mechanism) -> list[tuple[Part, Signal]]:
    """Return (joint or force, signal) of all signals, collected once a system."""
    known: list[tuple[Part, Signal]] | None = system.derived.get("signals")
    if known is None:
        known = [(x, row.signal) for x in system.joints for row in x.primitives if row.signal is not None]
        known += [(x, signal) for x in system.forces for signal in x.own_record.signals if signal is not None]
        system.derived["signals"] = known
    return known


def check_inputs(system: Mechanism) -> None:
    """Raise a ValueError with the parts if inputs of one name start with different values."""
    first: dict[str, tuple[Part, float]] = {}
    for part, signal in signals_of(system):
        for name, start in (term.input for term in signal.terms() if term.input):
            other, known = first.setdefault(name, (part, start))
            if start != known:
                raise InputError(
                    f"two inputs '{name}' start with {known:g} and {start:g}, in '{system.name(other)}' and "
                    f"'{system.name(part)}'; give them one value, or names of their own"
                )


class InputTerm(NamedTuple):
    """Place of the value of an `Input` in the tables."""

    name: str
    start: float  # its value before anything is set
    term: int  # index of its term, a polynomial: factor times (value at t = 0, slope)
    factor: float


class Signals:
    """Signals as the flat tables of the kernels."""

    def __init__(self) -> None:
        self.spans: list[tuple[int, int]] = []
        self.terms: list[tuple[int, int, int]] = []
        self.data: list[np.ndarray] = []
        self.end = 0  # of all data so far
        self.inputs: list[InputTerm] = []

    def add(self, signal: Signal | None) -> int:
        """Return the index of a signal, -1 for none."""
        if signal is None:
            return -1
        first = len(self.terms)
        for term in signal.terms():
            start, data = self.end, np.asarray(term.data, float)
            self.data.append(data)
            self.end += data.size
            if term.input:
                self.inputs.append(InputTerm(*term.input, len(self.terms), term.factor))
            self.terms.append((term.kind, start, self.end))
        self.spans.append((first, len(self.terms)))
        return len(self.spans) - 1


def body_table(system: Mechanism) -> tuple[np.ndarray, bool, float]:
    """Return (masses, inertias and their inverses; whether one of them is singular; largest radius of gyration [m]).

    In plain numbers: arrays of a few bodies would take longer.
    """
    out, bodies = table(BODY, len(system.bodies)), system.bodies
    inverses, kinds, largest, singular = [], [], 0.0, False
    mass = [body.mass for body in bodies]
    for m, body in zip(mass, bodies, strict=True):
        moments, inverse, axes = principal(body.inertia)
        regular = m > 0.0 and moments[0] > 1e-12 * moments[2]
        singular |= not regular
        largest = max(largest, moments[2] / m if m > 0.0 else 0.0)
        root, (x, y, z) = math.sqrt(m), body.com.tolist()
        kinds.append(symmetry(moments, axes, (root * x, root * y, root * z)) if regular else (0, NO_AXIS))
        inverses.append((1.0 / m, inverse()) if regular else (0.0, NO_INVERSE))
    out["mass"], out["inv_mass"] = mass, [x for x, _ in inverses]
    out["com"] = np.concatenate([body.com for body in bodies]).reshape(-1, 3)
    out["inertia"] = np.concatenate([body.inertia for body in bodies]).reshape(-1, 9)
    out["inv_inertia"] = [x for _, x in inverses]
    out["symmetry"], out["axis"] = [kind for kind, _ in kinds], [axis for _, axis in kinds]
    return out, singular, math.sqrt(largest)


Numbers = Sequence[float]


def principal(inertia: np.ndarray) -> tuple[Numbers, Callable[[], Numbers], Callable[[int], Numbers]]:
    """Return the moments, ascending, of an inertia (3, 3); functions that give its inverse and a principal axis.

    Most are diagonal.
    """
    (a, d, e), (d_T, b, f), (e_T, f_T, c) = inertia.tolist()
    if d == e == f == d_T == e_T == f_T == 0.0:
        moments = sorted(((a, 0), (b, 1), (c, 2)))
        inverse = lambda: (1.0 / a, 0.0, 0.0, 0.0, 1.0 / b, 0.0, 0.0, 0.0, 1.0 / c)  # noqa: E731
        return [x for x, _ in moments], inverse, lambda k: AXES_IN_ORDER[moments[k][1]]
    values, vectors = np.linalg.eigh(inertia)
    return values.tolist(), lambda: np.linalg.inv(inertia).ravel().tolist(), lambda k: vectors[:, k].tolist()


def symmetry(moments: Numbers, axis_of: Callable[[int], Numbers], arm: Numbers) -> tuple[int, Numbers]:
    """Return (kind, axis) in the table of bodies; ``arm`` is the centre of mass [m] times the root of the mass.

    What is taken for symmetric decides on the length of steps only.
    """
    low, middle, high = moments
    equal = EQUAL_MOMENT_TOLERANCE * high
    x, y, z = arm
    if middle - low < equal and high - middle < equal:
        square = x * x + y * y + z * z
        root = math.sqrt(square)
        return (2, NO_AXIS) if square < equal else (1, (x / root, y / root, z / root))
    if min(middle - low, high - middle) >= equal:
        return 0, NO_AXIS
    u, v, w = axis = axis_of(2 if middle - low < equal else 0)
    off = (y * w - z * v) ** 2 + (z * u - x * w) ** 2 + (x * v - y * u) ** 2
    return (1, axis) if off < equal else (0, NO_AXIS)


def zero_directions(x: Coordinate) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions in a and b whose angle about the axis is the coordinate."""
    if x.zero_a is not None and x.zero_b is not None:
        return x.zero_a, x.zero_b
    return perpendiculars(x.axis)[0], matched_perpendiculars(x.axis, x.axis_b)[0]


def axes_of(x: Coordinate) -> tuple[np.ndarray, ...]:
    """Return the world directions of the axes of a coordinate, in the order of `plans.AXIS_PLACES`."""
    if x.kind == "slide":
        return (x.axis,)
    if x.kind == "touch":
        return (x.axis_b,)
    if x.kind == "path":
        return ()
    x_a, x_b = zero_directions(x)
    return (x_a, cross(x.axis, x_a), x_b)[: len(AXIS_PLACES[x.kind])]


def reflected_table(system: Mechanism, where: dict[Any, int], frames: Frames) -> np.ndarray:
    """Return the table of the reflected inertias of joints, those of a joint side by side."""
    held = [pair for joint in system.joints for pair in joint.reflected()]
    out = table(REFLECTED, len(held))
    if not held:
        return out
    for i, (x, inertia) in enumerate(held):
        on = [frames.index[id(x.a)], frames.index[id(x.b)]]
        out["body"][i], out["inertia"][i], out["coordinate"][i] = on, inertia, -1
        if isinstance(x, TurnRate):
            out["axis"][i] = frames.axes(np.array(on[1:]), [x.axis])[0]
        else:
            out["coordinate"][i] = where[key_of(x)]
    return out


def parameters_of(system: Mechanism, records: list[ForceRecord]) -> list[list[float]]:
    """Return the parameters of each force: those its law declares by name, then its series of numbers."""
    return [
        [*force.law_parameters.pack(r.parameters), *(float(x) for one in r.series for x in one)]
        for force, r in zip(system.forces, records, strict=True)
    ]


def row_structure(x: Primitive, signal: int, index: dict[int, int], where: dict[tuple, int]) -> RowStructure:
    """Return the structure of a primitive with a signal (-1: none)."""
    kind, bodies, points, axes, second_axes, values, coordinates, numbers, _, in_metres = x
    on, read = tuple([index[id(body)] for body in bodies]), tuple([where[key_of(c)] for c in coordinates])
    counts = len(points), len(axes), len(second_axes), len(values), len(numbers)
    return tuple.__new__(RowStructure, (kind, on, read, *counts, signal, bool(in_metres)))  # its own takes as long


def force_structures(
    system: Mechanism,
    records: list[ForceRecord],
    parameters: list[list[float]],
    index: dict[int, int],
    where: dict[tuple, int],
    signals: Signals,
    holders: dict[int, int],
) -> tuple[ForceStructure, ...]:
    """Return the structures of the forces with these parameters, and add their signals.

    ``holders``: numbers of the parts that have rows, by id.
    """
    found = []
    for force, r, numbers in zip(system.forces, records, parameters, strict=True):
        found.append(
            ForceStructure(
                kind=number_of_law(force, system.name(force)),
                bodies=tuple([index[id(b)] for b in r.bodies]),
                points=len(r.points),
                coordinate=-1 if r.coordinate is None else where[key_of(r.coordinate)],
                signals=tuple([signals.add(x) for x in r.signals]),
                states=len(r.states),
                measures=len(r.measures),
                numbers=len(numbers),
                named=force.law_parameters.size,
                option=int(r.option),
                joint=-1 if r.joint is None else holders[id(r.joint)],
            )  # fmt: skip
        )
    return tuple(found)


def vectors_of(
    primitives: list[Primitive], coordinates: list[Coordinate], records: list[ForceRecord]
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Return the world points and axes of rows, coordinates and forces, in the order of their plan."""
    points = [x for row in primitives for x in row.points]
    points += [x for one in coordinates for x in (one.point_a, one.point_b)]
    points += [x for r in records for x in r.points]
    axes = [x for row in primitives for x in row.axes]
    axes += [x for row in primitives for x in row.second_axes]
    axes += [x for one in coordinates for x in axes_of(one)]
    for r in records:
        for slot in range(len(r.bodies[:2])):
            axes += [*(r.frame if slot == 0 or r.frame_b is None else r.frame_b).T]
    return points, axes


def measure_table(
    measures: list[Measure], index: dict[int, int], where: dict[tuple, int], forces: dict[int, tuple[int, int]],
    rows: dict[int, slice],
) -> np.ndarray:  # fmt: skip
    """Return the table of measures; by their id ``forces`` gives number and first state of each force, ``rows`` those
    of each joint.
    """
    out = table(MEASURE, len(measures))
    for i, x in enumerate(measures):
        if x.plain() is not x:
            raise InputError(
                f"measure '{x.label}': factors and summands are for solution.measure, plots and conditions; give the "
                f"measure '{x.plain_label}' here, and scale gains or results"
            )
        out["kind"][i], out["body"][i], out["axis"][i] = MEASURES[x.kind], (index[id(x.a)], index[id(x.b)]), x.axis
        out["point"][i] = x.a.local_point(x.point_a), x.b.local_point(x.point_b)
        out["coordinate"][i] = -1 if x.coordinate is None else where[key_of(x.coordinate)]
        number, first = (-1, -1) if x.part is None else forces[id(x.part)]
        out["force"][i], out["state"][i] = number, -1 if x.part is None else first + x.index
        if x.kind == "tension":
            out["row"][i] = x.index
        holder = x.part if x.kind in HOLDING_MEASURES else x.joint
        if holder is not None:
            own = rows[id(holder)]
            out["row"][i], out["rows"][i] = own.start, own.stop - own.start
    return out


def state_units(
    mass: np.ndarray, frames: Frames, scales: list[tuple[float, int, int]], plan: Plan, length: float
) -> np.ndarray:
    """Return the units of the errors of z, those of internal states by their scales.

    Angular impulse is about the centre of mass: of bodies far from it a tenth of the distance counts.
    """
    total = float(mass.sum()) or 1.0
    apart = frames.r[:-1] - frames.r[:-1].sum(axis=0) / len(mass)
    arm = max(length, 0.1 * math.sqrt((apart * apart).sum(axis=1).max()))
    own = [unit * length**k for unit, k, _ in scales]
    return np.array(own + [total] * (plan.z_impulse - plan.z_work + 3) + [total * arm] * 3, float)
