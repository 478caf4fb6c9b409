"""Tables of the kernels from the parts of a system: one function per table of `Model`."""

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.errors import InputError
from ..base.rotations import cross, matched_perpendiculars, perpendiculars
from ..dynamics.applied_forces import number_of_law
from ..kernels.layout import (
    BODY,
    COORDINATE,
    CUSTOM_FORCE_BODIES_MAX,
    FORCE,
    MEASURE,
    SIGNAL,
    STATE,
    TERM,
    table,
)
from ..mechanism.bodies import GROUND, Part
from ..mechanism.force_element import ForceRecord
from ..mechanism.measures import MEASURES, Measure
from ..mechanism.mechanism import Mechanism
from ..mechanism.primitives import COORDINATES, Coordinate
from ..mechanism.signals import Signal
from .row_tables import Frames, stacked

EQUAL_MOMENT_TOLERANCE = 1e-6  # [1] of the largest moment of inertia: difference of moments that counts as none


def key_of(x: Coordinate) -> tuple:
    """Return a key: two coordinates are the same when kind, bodies and geometry are."""
    return (x.kind, id(x.a), id(x.b), x.geometry)


def own_length(system: Mechanism, records: list[ForceRecord], frames: Frames, gyration: float) -> float:
    """Return the length of the largest body [m]: farthest joint or force point from its centre of mass, or gyration."""
    largest = gyration
    pairs = [pair for r in records if r.points for pair in zip(r.bodies, r.points, strict=True)]
    pairs += [(body, joint.point()) for joint in system.joints for body in joint.bodies()]
    pairs = [(frames.index[id(body)], point) for body, point in pairs if body is not GROUND]
    if pairs:
        on, points = zip(*pairs, strict=True)
        arms = stacked(points) - frames.centre[list(on)]
        largest = max(largest, math.sqrt((arms * arms).sum(axis=1).max()))
    return largest or 1.0


def signals_of(system: Mechanism) -> list[tuple[Part, Signal]]:
    """Return (joint or force, signal) of all signals."""
    found: list[tuple[Part, Signal | None]] = [
        (joint, row.signal) for joint in system.joints for row in joint.primitives
    ]
    found += [(force, signal) for force in system.forces for signal in force.record().signals]
    return [(part, signal) for part, signal in found if signal is not None]


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
    term: int  # index of its term, a polynomial of one coefficient: factor times the value
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

    def arrays(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return (signals, their terms, data of the terms) of the model."""
        signal, term = table(SIGNAL, len(self.spans)), table(TERM, len(self.terms))
        signal[:] = self.spans
        term[:] = self.terms
        return signal, term, np.concatenate([np.zeros(0), *self.data])


def body_table(system: Mechanism) -> tuple[np.ndarray, bool, float]:
    """Return (masses, inertias and their inverses; whether one of them is singular; largest radius of gyration [m])."""
    out, bodies = table(BODY, len(system.bodies)), system.bodies
    mass = out["mass"] = np.array([body.mass for body in bodies])
    out["com"] = stacked([body.com for body in bodies])
    inertia = np.concatenate([body.inertia for body in bodies]).reshape(-1, 3, 3)
    out["inertia"] = inertia.reshape(-1, 9)
    moments, C = np.linalg.eigh(inertia)
    heavy = mass > 0.0
    regular = heavy & (moments[:, 0] > 1e-12 * moments[:, -1])
    out["inv_mass"][regular] = 1.0 / mass[regular]
    out["inv_inertia"][regular] = np.linalg.inv(inertia[regular]).reshape(-1, 9)
    low_to_high = moments.tolist()
    arms = out["com"] * np.sqrt(mass)[:, None]
    for i in np.flatnonzero(regular).tolist():
        if (kind := symmetry(low_to_high[i], C[i], arms[i]))[0]:
            out["symmetry"][i], out["axis"][i] = kind
    gyration = math.sqrt((moments[heavy, 2] / mass[heavy]).max(initial=0.0))
    return out, not regular.all(), gyration


def symmetry(moments: list[float], C: np.ndarray, arm: np.ndarray) -> tuple[int, np.ndarray]:
    """Return (kind, axis) in the table of bodies; ``arm`` is the centre of mass [m] times the root of the mass.

    What is taken for symmetric decides on the length of steps only.
    """
    low, middle, high = moments
    equal = EQUAL_MOMENT_TOLERANCE * high
    if middle - low < equal and high - middle < equal:
        return (2, np.zeros(3)) if arm @ arm < equal else (1, arm / np.sqrt(arm @ arm))
    if min(middle - low, high - middle) >= equal:
        return 0, np.zeros(3)
    axis = C[:, 2] if middle - low < equal else C[:, 0]
    off = cross(arm, axis)
    return (1, axis) if off @ off < equal else (0, np.zeros(3))


def zero_directions(x: Coordinate) -> tuple[np.ndarray, np.ndarray]:
    """Return the directions in a and b whose angle about the axis is the coordinate."""
    if x.zero_a is not None and x.zero_b is not None:
        return x.zero_a, x.zero_b
    return perpendiculars(x.axis)[0], matched_perpendiculars(x.axis, x.axis_b)[0]


def coordinate_table(coordinates: list[Coordinate], frames: Frames, first: int) -> np.ndarray:
    """Return the table of hinge coordinates; numbers of their curves follow each other from ``first``."""
    out = table(COORDINATE, len(coordinates))
    if not coordinates:
        return out
    ends = np.array([(frames.index[id(x.a)], frames.index[id(x.b)]) for x in coordinates])
    out["kind"], out["body"] = [COORDINATES[x.kind] for x in coordinates], ends
    out["number"] = first + np.cumsum([0, *(x.numbers.size for x in coordinates)])[:-1]
    points = [point for x in coordinates for point in (x.point_a, x.point_b)]
    out["point"] = frames.points(ends.ravel(), points).reshape(-1, 2, 3)
    axes = [(i, *axis) for i, x in enumerate(coordinates) for axis in axes_of(x)]
    if axes:
        i, slot, end, directions = zip(*axes, strict=True)
        out["axis"][i, slot] = frames.axes(ends[i, end], directions)
    return out


def axes_of(x: Coordinate) -> list[tuple[int, int, np.ndarray]]:
    """Return (place in the table, 0 in a or 1 in b, world direction) of the axes of a coordinate."""
    if x.kind == "slide":
        return [(0, 0, x.axis)]
    if x.kind == "touch":
        return [(2, 1, x.axis_b)]
    if x.kind == "angle":
        x_a, x_b = zero_directions(x)
        return [(0, 0, x_a), (1, 0, cross(x.axis, x_a)), (2, 1, x_b)]
    return []


def parameters_of(system: Mechanism, records: list[ForceRecord]) -> list[list[float]]:
    """Return the parameters of each force: those its law declares by name, then its series of numbers."""
    return [
        [*force.law_parameters.pack(r.parameters), *(float(x) for one in r.series for x in one)]
        for force, r in zip(system.forces, records, strict=True)
    ]


def force_table(
    system: Mechanism,
    records: list[ForceRecord],
    numbers: list[list[float]],
    index: dict[int, int],
    where: dict[tuple, int],
    signals: Signals,
    first_measure: int,
    rows: dict[int, slice],
) -> np.ndarray:
    """Return the table of force elements with these parameters; measures they read stand from ``first_measure`` on.

    ``rows``: those of each joint by its id.
    """
    out = table(FORCE, len(records))
    for name, counts in (("state", "states"), ("measure", "measures")):
        out[counts] = [len(getattr(r, counts)) for r in records]
        out[name] = np.cumsum([0, *out[counts]])[:-1]
    out["numbers"], out["named"] = [len(given) for given in numbers], [f.law_parameters.size for f in system.forces]
    out["number"] = np.cumsum([0, *out["numbers"]])[:-1]
    out["measure"] += first_measure
    for i, r in enumerate(records):
        out["kind"][i] = number_of_law(system.forces[i], system.name(system.forces[i]))
        held = r.bodies[:CUSTOM_FORCE_BODIES_MAX]  # a spring of a sum, which may have more, acts by its coordinates
        out["bodies"][i] = len(held)
        out["body"][i, : len(held)] = [index[id(b)] for b in held]
        out["signal"][i] = [signals.add(s) for s in r.signals]
        out["coordinate"][i] = -1 if r.coordinate is None else where[key_of(r.coordinate)]
        out["option"][i] = r.option
        if r.joint is not None:
            own = rows[id(r.joint)]
            out["row"][i], out["rows"][i] = own.start, own.stop - own.start
        for slot, (body, point) in enumerate(zip(r.bodies, r.points, strict=bool(r.points))):
            out["point"][i, slot] = body.local_point(point)
        for slot, body in enumerate(r.bodies[:2]):
            axes = r.frame if slot == 0 or r.frame_b is None else r.frame_b
            out["frame"][i, slot] = np.column_stack([body.local_axis(x) for x in axes.T]).ravel()
    return out


def measure_table(
    measures: list[Measure], index: dict[int, int], where: dict[tuple, int], forces: dict[int, tuple[int, int]],
    rows: dict[int, slice],
) -> np.ndarray:  # fmt: skip
    """Return the table of measures; by their id ``forces`` gives number and first state of each force, ``rows`` those
    of each joint.
    """
    out = table(MEASURE, len(measures))
    for i, x in enumerate(measures):
        out["kind"][i], out["body"][i], out["axis"][i] = MEASURES[x.kind], (index[id(x.a)], index[id(x.b)]), x.axis
        out["point"][i] = x.a.local_point(x.point_a), x.b.local_point(x.point_b)
        out["coordinate"][i] = -1 if x.coordinate is None else where[key_of(x.coordinate)]
        number, first = (-1, -1) if x.part is None else forces[id(x.part)]
        out["force"][i], out["state"][i] = number, -1 if x.part is None else first + x.index
        holder = x.part if x.kind == "holding load" else x.joint
        if holder is not None:
            own = rows[id(holder)]
            out["row"][i], out["rows"][i] = own.start, own.stop - own.start
    return out


def state_layout(system: Mechanism, records: list[ForceRecord], n_driven: int, length: float) -> dict[str, Any]:
    """Return the layout of z and the units of its errors.

    Angular impulse is about the centre of mass: of bodies far from it a tenth of the distance counts.
    """
    scales = [scale for r in records for scale in r.scales]
    own, n_forces = len(scales), len(system.forces)
    mass = system.total_mass() or 1.0
    works = n_forces + n_driven
    places = np.array([body.position for body in system.bodies])
    arm = max(length, 0.1 * float(np.linalg.norm(places - places.mean(axis=0), axis=1).max()))
    out = table(STATE, own + works + 6)
    out["unit"] = [unit * length**k for unit, k, _ in scales] + [mass] * works + [mass] * 3 + [mass * arm] * 3
    out["power"] = [j for _, _, j in scales] + [2.0] * works + [1.0] * 6
    return {"z_work": own, "z_drive": own + n_forces, "z_impulse": own + works, "state": out}
