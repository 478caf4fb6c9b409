"""Compiled mechanisms: the description as arrays of the kernels."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from ..base.checks import floats, short_repr
from ..base.errors import InputError
from ..compiler.first_run import announce_compilation
from ..kernels import kinds
from ..kernels.kinds import SPLINE
from ..kernels.layout import CUSTOM_FORCE_BODIES_MAX, Data, Model, data_records, table
from ..mechanism.drivers import Driver
from ..mechanism.force_element import ForceElement, ForceRecord
from ..mechanism.forces.custom import FunctionForce
from ..mechanism.joints import Joint
from ..mechanism.measures import Measure
from ..mechanism.mechanism import Mechanism
from ..mechanism.primitives import COORDINATES, Coordinate, Primitive
from ..mechanism.state import State
from ..mechanism.switching import Mode, Modes, is_switching
from .plans import CoordinateStructure, Frames, Structure, filled, plan_of
from .tables import (
    InputTerm,
    Signals,
    body_table,
    check_inputs,
    force_structures,
    key_of,
    measure_table,
    own_length,
    parameters_of,
    points_of_parts,
    reflected_table,
    row_structure,
    state_units,
    vectors_of,
)

BAUMGARTE_FACTORS = (20.0, 100.0)  # [1/s, 1/s^2] a and b of gamma -= a (J v - b) + b c unless others are given


@dataclass(frozen=True)
class Switches:
    """Teaching switches and the stabilisation of constraints."""

    gyroscopic: bool = True
    centripetal: bool = True
    gamma: bool = True
    stabilisation: str = "projection"
    baumgarte: tuple[float, float] = BAUMGARTE_FACTORS

    def __post_init__(self) -> None:
        if not isinstance(self.stabilisation, str) or self.stabilisation not in STABILISATIONS:
            names = ", ".join(f"'{name}'" for name in STABILISATIONS)
            raise InputError(f"stabilisation {short_repr(self.stabilisation)} is unknown; give one of {names}")
        if self.baumgarte is not BAUMGARTE_FACTORS:
            remedy = "two factors a [1/s] >= 0 and b [1/s^2] >= 0"
            factors = floats(self.baumgarte, "baumgarte", remedy)
            if factors.shape != (2,) or (factors < 0.0).any():
                raise InputError(f"baumgarte {short_repr(self.baumgarte)}: give {remedy}")
            object.__setattr__(self, "baumgarte", tuple(factors.tolist()))
        for name in ("gyroscopic", "centripetal", "gamma"):
            if not isinstance(getattr(self, name), bool | np.bool_):
                raise InputError(f"{name} = {short_repr(getattr(self, name))}; give True or False")


STABILISATIONS = {"none": kinds.NONE, "baumgarte": kinds.BAUMGARTE, "projection": kinds.PROJECTION}


@dataclass(frozen=True, eq=False)
class Compiled:
    """Arrays of a system, and the place of each part in them."""

    system: Mechanism
    model: Model
    body_index: dict[int, int]  # id(body) -> index, the ground is n
    rows: dict[int, slice]  # id(joint) -> its rows
    coordinate_index: dict[tuple, int]  # key of a Coordinate -> index
    drives: list[tuple[Driver, int]]  # (driver, row) of every driven row
    row_joint: np.ndarray  # (m,) index into holders
    switches: Switches
    frames: Frames  # at the reference pose
    inputs: tuple[InputTerm, ...] = ()  # where the values of signals stand that are set from outside
    modes: Modes = field(default_factory=dict)  # of the parts that switch at events

    def __reduce__(self) -> tuple:
        raise InputError(
            "results are neither copied nor pickled: they are read by the parts of their system; copy the system, "
            "return numbers from other processes, or write a run by solution.save(path) for mbsd3d.load(path)"
        )

    @property
    def holders(self) -> tuple[Joint | ForceElement, ...]:
        """Return the parts that may have rows: joints, and forces that switch."""
        return holders_of(self.system)

    def coordinate(self, coordinate: Coordinate) -> int:
        """Return the index of a hinge coordinate."""
        return self.coordinate_index[key_of(coordinate)]

    @property
    def own_coordinates(self) -> int:
        """Return the number of hinge coordinates of the system itself; those that only measures read come after."""
        return len(tables_of(self.system).coordinate_index)

    def forces_alone(self, which: slice | np.ndarray) -> Model:
        """Return the tables with some of the force elements, by their places, and no other load."""
        force = self.model.force[which]
        return self.model._replace(force=force, frictions=reading_multipliers(force), gravity=np.zeros(3))

    def data(self, dtype: type = float) -> Data:
        """Return a new work space; the functions of custom forces are compiled for ``dtype`` here."""
        link(self.system, self.model, dtype)
        return new_data(self.model, dtype)


def reading_multipliers(forces: np.ndarray) -> int:
    """Return how many forces of a table have laws that read multipliers."""
    return int((forces["rows"] > 0).sum())


def link(system: Mechanism, model: Model, dtype: type) -> None:
    """Store the addresses of the custom functions for real or complex numbers in the table of forces."""
    for i, force in enumerate(system.forces):
        if isinstance(force, FunctionForce):
            model.force["address"][i, int(dtype is complex)] = force.address(dtype)


def initial_states(system: Mechanism) -> np.ndarray:
    """Return the initial values (k,) of the internal states of force elements."""
    return np.array([x for force in system.forces for x in force.own_record.states], float)


def switch_fields(switches: Switches) -> dict[str, Any]:
    """Return the fields of the model that the switches set."""
    return {
        "gyroscopic": float(switches.gyroscopic),
        "centripetal": float(switches.centripetal),
        "gamma": float(switches.gamma),
        "stabilisation": STABILISATIONS[switches.stabilisation],
        "baumgarte_velocity": float(switches.baumgarte[0]),
        "baumgarte_position": float(switches.baumgarte[1]),
    }


def holders_of(system: Mechanism) -> tuple[Joint | ForceElement, ...]:
    """Return the parts of a system that may have rows: joints, and forces that switch."""
    return (*system.joints, *[force for force in system.forces if is_switching(force)])


def first_modes(system: Mechanism) -> dict[str, Mode]:
    """Return the modes at the reference pose of all parts that switch, by name."""
    parts: list[Any] = [x for x in holders_of(system) if is_switching(x)]
    return {system.name(x): x.first_mode() for x in parts} if parts else {}


def modes_at(system: Mechanism, state: State) -> dict[str, Mode]:
    """Return the modes at a state of all parts that switch, by name; ValueError for others."""
    if not state.modes and not tables_of(system).modes:
        return {}
    modes, parts = first_modes(system), {system.name(x): x for x in holders_of(system)}
    for name, given in state.modes.items():
        if name not in modes:
            raise InputError(f"state: modes: '{name}' does not switch in this system; give a state of this system")
        try:
            modes[name] = Mode(str(given[0]), tuple(map(float, given[1])))
            rows_in(parts[name], modes, name)
        except (IndexError, TypeError, ValueError) as error:
            raise InputError(
                f"state: modes: '{name}' has no mode {short_repr(given)}; give a state of a run of this system"
            ) from error
    return modes


def compile_system(
    system: Mechanism, measures: tuple[Measure, ...] = (), switches: Switches | None = None, modes: Modes | None = None
) -> Compiled:
    """Return the arrays of a system; what depends on nothing else is lowered once a system.

    ``modes`` of the parts that switch at events: None = as at the reference pose.
    """
    announce_compilation()
    switches = switches or Switches()
    if modes:
        return lower(system, measures, switches, modes)
    known = tables_of(system)
    if measures and (known.model.measure.size or any(unread(x, known) for x in measures)):
        return lower(system, measures, switches)
    if measures:
        known = replace(known, model=known.model._replace(measure=measures_of(system, known, measures)))
    if switches == known.switches:
        return known
    return replace(known, model=known.model._replace(**switch_fields(switches)), switches=switches)


def unread(measure: Measure, known: Compiled) -> bool:
    """Return True if a measure reads an angle or slide that the tables do not hold."""
    return measure.coordinate is not None and key_of(measure.coordinate) not in known.coordinate_index


def measures_of(system: Mechanism, known: Compiled, measures: Sequence[Measure]) -> np.ndarray:
    """Return the table of measures of a system whose tables are known."""
    places = places_of_forces(system, known.model.force)
    return measure_table([*measures], known.body_index, known.coordinate_index, places, known.rows)


def tables_of(system: Mechanism) -> Compiled:
    """Return the arrays of a mechanism with all terms of the equations; made once, never written to."""
    if "tables" not in system.derived:
        system.derived["tables"] = lower(system, (), Switches())
    return system.derived["tables"]


def lower(system: Mechanism, measures: tuple[Measure, ...], switches: Switches, modes: Modes | None = None) -> Compiled:
    """Lower a system to arrays: its structure chooses a plan, its numbers fill it."""
    check_inputs(system)
    frames = Frames(system)
    index, holders = frames.index, holders_of(system)
    modes = modes or first_modes(system)
    rows_of_holder = [rows_in(x, modes, system.name(x) if modes else "") for x in holders]
    primitives = [row for rows in rows_of_holder for row in rows]
    records = [record_in(x, modes, system.name(x)) if modes else x.own_record for x in system.forces]
    parameters = parameters_of(system, records)
    read = [x for r in records for x in r.measures]
    switched = [r.coordinate for r, x in zip(records, system.forces, strict=True) if is_switching(x)] if modes else []
    coordinates = coordinates_of(system, switched, primitives, records, [*read, *measures])
    where = {key_of(x): i for i, x in enumerate(coordinates)}
    switches_of = [is_switching(x) for x in holders] if modes else [False] * len(holders)
    numbered, signals = numbers_of_parts(holders), Signals()
    forces = force_structures(system, records, parameters, index, where, signals, numbered)
    driven = [-1 if row.signal is None else signals.add(row.signal) for row in primitives]
    arms = points_of_parts(system, records, index)
    scales = [x for r in records for x in r.scales]
    plan = plan_of(Structure(
        bodies=len(system.bodies),
        rows=tuple([row_structure(x, signal, index, where) for x, signal in zip(primitives, driven, strict=True)]),
        holders=tuple([(len(rows), own) for rows, own in zip(rows_of_holder, switches_of, strict=True)]),
        coordinates=tuple([
            CoordinateStructure(x.kind, COORDINATES[x.kind], (index[id(x.a)], index[id(x.b)]), x.numbers.size)
            for x in coordinates
        ]),
        forces=forces, first_measure=len(measures), arms=tuple([on for on, _ in arms]),
        powers=tuple([power for *_, power in scales]),
        signals=tuple(signals.spans), terms=tuple(signals.terms),
    ))  # fmt: skip
    rows = {part: plan.slices[i] for part, i in numbered.items()}
    bodies, singular, gyration = body_table(system)
    length = own_length(plan.arms, [point for _, point in arms], frames, gyration)
    plain = [
        np.where(plan.metres, 1.0 / length, 1.0),
        np.array([x for row in primitives for x in row.values], float),
        *(np.array(own, float) for own in parameters if own), *(x.numbers for x in coordinates),
        *(np.array(row.numbers, float) for row in primitives if row.numbers), *signals.data, system.gravity,
        state_units(bodies["mass"], frames, scales, plan, length),
    ]  # fmt: skip
    tables: dict[str, Any] = filled(plan, frames, bodies, *vectors_of(primitives, coordinates, records), plain)
    model = Model(
        **tables,
        reflected=reflected_table(system, where, frames),
        measure=measure_table([*measures, *read], index, where, places_of_forces(system, tables["force"]), rows),
        z_work=plan.z_work, z_drive=plan.z_drive, z_impulse=plan.z_impulse, length=length, singular=int(singular),
        frictions=plan.frictions, **switch_fields(switches),
    )  # fmt: skip
    drives = [(holders[plan.row_joint[k]], k) for k in plan.driven]
    return Compiled(
        system=system,
        model=model,
        body_index=index,
        rows=rows,
        coordinate_index=where,
        drives=[(x, k) for x, k in drives if isinstance(x, Driver)],
        row_joint=plan.row_joint,
        switches=switches,
        frames=frames,
        inputs=tuple(signals.inputs),
        modes=modes,
    )


def numbers_of_parts(holders: Sequence[Joint | ForceElement]) -> dict[int, int]:
    """Return the numbers of the parts that may have rows, and of the joints that they stand for, by their id."""
    found = {id(part): i for i, part in enumerate(holders)}
    found.update([(id(part.held()), i) for i, part in enumerate(holders) if isinstance(part, Joint)])
    return found


def places_of_forces(system: Mechanism, table: np.ndarray) -> dict[int, tuple[int, int]]:
    """Return number and first internal state of each force by its id."""
    first = table["state"].tolist()
    return {id(force): (i, first[i]) for i, force in enumerate(system.forces)}


def rows_in(part: Any, modes: Modes, name: str) -> Sequence[Primitive]:
    """Return the rows of a joint or of a force that switches, in the mode of its name."""
    return part.rows_in(modes[name]) if modes and is_switching(part) else part.primitives


def record_in(force: Any, modes: Modes, name: str) -> ForceRecord:
    """Return what the law of a force reads, in the mode of its name if it switches."""
    return force.record_in(modes[name]) if is_switching(force) else force.own_record


def coordinates_of(
    system: Mechanism, switched: list[Coordinate | None], primitives: list[Primitive], records: list[ForceRecord],
    measures: list[Measure],
) -> list[Coordinate]:  # fmt: skip
    """Return the angles and slides that joints have or anything reads, each once; those of measures last.

    Those of forces that switch stand before those of rows, so that the order is the same in all modes.
    """
    wanted = [x for joint in system.joints for x in (joint.angle(), joint.slide())]
    wanted += switched
    wanted += [x for row in primitives for x in row.coordinates]
    wanted += [x.coordinate for x in records] + [x.coordinate for x in measures]
    return list({key_of(x): x for x in wanted if x is not None}.values())


def new_data(model: Model, dtype: type = float) -> Data:
    """Return a new work space with the ground in its place."""
    types = data_types(dtype)
    data = Data(
        body=np.zeros(model.body.size + 1, types["body"]),
        row=np.zeros(model.row.size, types["row"]),
        reflected=np.zeros(model.reflected.size, types["reflected"]),
        force=np.zeros(model.force.size, types["force"]),
        coordinate=np.zeros(model.coordinate.size, types["coordinate"]),
        unwrap_time=np.zeros(1),
        z=np.zeros(model.z_work, dtype),
        state_rate=np.zeros(model.z_work, dtype),
        pose=np.zeros(CUSTOM_FORCE_BODIES_MAX, types["pose"]),
        wrench=np.zeros(6 * CUSTOM_FORCE_BODIES_MAX + 1, dtype),
        scratch=np.zeros(model.force["numbers"].max(initial=0), dtype),
    )
    data.body["e"][-1, 0] = data.body["R"][-1, 0] = data.body["R"][-1, 4] = data.body["R"][-1, 8] = 1.0
    return data


@cache
def data_types(dtype: type) -> dict[str, np.dtype]:
    """Return the types of the tables of the work space, cached since looking them up is slow."""
    return {name: table(fields, 0).dtype for name, fields in data_records(dtype).items()}


History = Mapping[str, Sequence[tuple[float, ...]]]
"""Name -> (time [s], value) of the start and of every change; (time, value, slope [1/s]) where it does not hold."""


def starts(compiled: Compiled) -> dict[str, float]:
    """Return the value of each input at the start, by name."""
    return {place.name: place.start for place in compiled.inputs}


def with_own_inputs(compiled: Compiled) -> Compiled:
    """Return the same tables with signal numbers that `set_input` may overwrite."""
    return replace(compiled, model=compiled.model._replace(term_data=compiled.model.term_data.copy()))


def set_input(compiled: Compiled, name: str, value: float, slope: float = 0.0, t: float = 0.0) -> None:
    """Set all terms of an input to ``value + slope (time - t)``."""
    for place in compiled.inputs:
        if place.name == name:
            first = compiled.model.term["first"][place.term]
            compiled.model.term_data[first] = place.factor * (value - slope * t)
            compiled.model.term_data[first + 1] = place.factor * slope


def with_history(compiled: Compiled, history: History) -> Compiled:
    """Return the tables with each input in pieces, constant or sloped; at the time of a change the old one holds.

    So the sample at the end of a slice, taken before the change, meets the equations it was made with.
    """
    term, data = compiled.model.term.copy(), list(compiled.model.term_data)
    for place in compiled.inputs:
        if place.name not in history:
            continue
        times, values, slopes = np.array([(*change, 0.0)[:3] for change in history[place.name]], float).T
        breaks = np.append(np.nextafter(times, np.inf), np.inf)
        pieces = np.zeros((values.size, 4))
        pieces[:, 2:] = place.factor * np.column_stack([slopes, values])
        term["kind"][place.term], term["first"][place.term] = SPLINE, len(data)
        data += [values.size, *breaks, *pieces.ravel()]
        term["end"][place.term] = len(data)
    return replace(compiled, model=compiled.model._replace(term=term, term_data=np.array(data, float)))
