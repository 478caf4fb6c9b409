"""Systems as plain data, solutions in one file, and tables for other programs.

A file holds numbers and text only. The types it names are looked up in `TYPES`, the package's own parts; nothing is
imported or evaluated because a file says so, and no file is read with pickle.
"""

import csv
import inspect
import io
import json
import math
import os
import uuid
import zipfile
import zlib
from collections.abc import Mapping
from dataclasses import MISSING, fields, replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from . import drivers, forces, joints, signals
from .drivers import PositionDriver
from .forces import ForceElement
from .integrators.dop853 import DOP853
from .integrators.driven import Kinematic
from .integrators.rk4 import RK4
from .joints import Joint
from .measures import Condition, Measure
from .model import Compiled, Switches, compile_system
from .parts import GROUND, Body, Ground
from .primitives import Coordinate
from .signals import Signal
from .simulation import Record
from .solution import Solution
from .state import State
from .system import System

FORMAT = 1  # rises when a file of the old form cannot be read any more
SYSTEM, SOLUTION = "mbsd3d system", "mbsd3d solution"
DERIVED = ("q", "z")  # slices of the array "state"
BROKEN = (
    OSError, ValueError, KeyError, TypeError, EOFError, MemoryError, NotImplementedError, RecursionError,
    zipfile.BadZipFile, zlib.error,
)  # fmt: skip


def own_types() -> dict[str, type]:
    """Name -> class of all a file may hold: every part class with content of its own, and what a record is made of."""
    found: dict[str, type] = {}
    for module, base, content in (
        (joints, Joint, "rows"),
        (drivers, Joint, "rows"),
        (forces, ForceElement, "record"),
        (signals, Signal, "terms"),
    ):
        for name, kind in inspect.getmembers(module, inspect.isclass):
            if kind.__module__ == module.__name__ and issubclass(kind, base):
                if getattr(kind, content) is not getattr(base, content):
                    found[name] = kind
    others = (Body, Measure, Condition, Coordinate, State, Switches, Record, DOP853, RK4, Kinematic)
    return found | {kind.__name__: kind for kind in others}


TYPES: Mapping[str, type] = MappingProxyType(own_types())


class Writer:
    """Turns values into JSON-able ones; bodies and joints of the system become references to their place in it."""

    def __init__(self, system: System) -> None:
        self.references: dict[int, dict] = {id(body): {"body": i} for i, body in enumerate(system.bodies)}
        self.references |= {id(joint): {"joint": i} for i, joint in enumerate(system.joints)}

    def value(self, value: Any, what: str) -> Any:
        """One value; ``what`` names it in errors."""
        if id(value) in self.references:
            return self.references[id(value)]
        if isinstance(value, Ground):
            return {"body": "ground"}
        if isinstance(value, np.generic):
            value = value.item()
        if value is None or isinstance(value, bool | int | str):
            return value
        if isinstance(value, float):
            return value if math.isfinite(value) else {"float": repr(value)}
        if isinstance(value, np.ndarray):
            return {"array": self.value(value.tolist(), what)}
        if isinstance(value, list | tuple):
            return [self.value(item, what) for item in value]
        if isinstance(value, Mapping):
            return {"map": {str(key): self.value(item, what) for key, item in value.items()}}
        return self.part(value, what)

    def part(self, part: Any, what: str) -> dict[str, Any]:
        """Type and fields of a part, a signal or a method."""
        kind = type(part)
        if TYPES.get(kind.__name__) is not kind:
            raise ValueError(
                f"{what}: a {kind.__name__} cannot be written to a file; only numbers, texts, arrays and the parts of "
                "mbsd3d can, no functions and no classes of your own"
            )
        names = [field.name for field in fields(part) if field.init]
        return {"type": kind.__name__} | {name: self.value(getattr(part, name), f"{what}: {name}") for name in names}


class Reader:
    """The way back; joints are built when one first refers to them."""

    def __init__(self, bodies: list, joint_data: list) -> None:
        self.joint_data, self.joints = joint_data, {}
        self.bodies: list = []
        self.bodies = [self.part(entry) for entry in bodies]

    def value(self, value: Any) -> Any:
        """One value."""
        if isinstance(value, list):
            return tuple(self.value(item) for item in value)
        if not isinstance(value, dict):
            return value
        if "type" in value:
            return self.part(value)
        key, inner = next(iter(value.items())) if len(value) == 1 else ("", None)
        if key == "body":
            return GROUND if inner == "ground" else self.bodies[self.index(inner, len(self.bodies), "body")]
        if key == "joint":
            return self.joint(inner)
        if key == "array":
            return self.array(inner)
        if key == "map" and isinstance(inner, dict):
            return {name: self.value(item) for name, item in inner.items()}
        if key == "float" and inner in ("inf", "-inf", "nan"):
            return float(inner)
        raise ValueError(f"system description: {value!r} is not understood; write it with mbsd3d.files.describe")

    def array(self, rows: Any) -> np.ndarray:
        """A read-only array of numbers."""
        array = np.array(self.value(rows))
        if array.dtype.kind not in "fiub":
            raise ValueError(f"system description: array {rows!r} does not hold numbers; give numbers")
        array.setflags(write=False)
        return array

    def index(self, index: Any, count: int, kind: str) -> int:
        """A place in a list of ``count`` parts."""
        if type(index) is not int or not 0 <= index < count:
            raise ValueError(f"system description: there is no {kind} {index!r}; give 0 ... {count - 1}")
        return index

    def joint(self, index: Any) -> Joint:
        """The joint at a place; one that is under construction refers to itself."""
        index = self.index(index, len(self.joint_data), "joint")
        if index not in self.joints:
            self.joints[index] = None
            self.joints[index] = self.part(self.joint_data[index])
        if self.joints[index] is None:
            raise ValueError(f"system description: joint {index} refers to itself; refer to another joint")
        return self.joints[index]

    def part(self, data: Any) -> Any:
        """A part from its type and fields, checked by its own constructor."""
        kind = TYPES.get(data.get("type")) if isinstance(data, dict) and isinstance(data.get("type"), str) else None
        if kind is None:
            name = data.get("type") if isinstance(data, dict) else data
            raise ValueError(f"system description: type {name!r} is unknown; there are {', '.join(sorted(TYPES))}")
        values = {name: self.value(item) for name, item in data.items() if name != "type"}
        own = {field.name: field for field in fields(kind) if field.init}
        needed = {name for name, field in own.items() if field.default is MISSING and field.default_factory is MISSING}
        what = f"system description: {kind.__name__} '{values.get('name')}'"
        if values.keys() - own or needed - values.keys():
            wrong = ", ".join(sorted((values.keys() - own) | (needed - values.keys())))
            raise ValueError(f"{what}: fields {wrong} are unknown or missing; give {', '.join(own)}")
        try:
            part = kind(**values)
        except (TypeError, AttributeError) as error:
            raise ValueError(f"{what}: {error}; write it with mbsd3d.files.describe") from error
        for name, stored in values.items():  # normalising a unit vector again may move its last bit
            object.__setattr__(part, name, exact(getattr(part, name), stored))
        return part


def exact(built: Any, stored: Any) -> Any:
    """The stored array where the constructor changed no more than its rounding, else what the constructor made."""
    if isinstance(built, tuple) and isinstance(stored, tuple) and len(built) == len(stored):
        return tuple(exact(x, y) for x, y in zip(built, stored, strict=True))
    if not isinstance(built, np.ndarray) or not isinstance(stored, np.ndarray) or built.shape != stored.shape:
        return built
    return stored if built.dtype == stored.dtype and np.allclose(built, stored, rtol=1e-14, atol=0.0) else built


def describe(system: System) -> dict[str, Any]:
    """A system as JSON-able data: type names and fields, bodies and joints referred to by their place.

    Parameters
    ----------
    system : System
        Made of the package's own parts.

    Returns
    -------
    dict
        For `rebuild`; ``json.dumps`` writes it without loss.

    Raises
    ------
    ValueError
        If a part holds something that is no number, text, array or part of the package, e.g. a function.
    """
    write = Writer(system)
    lists = {
        kind: [write.part(part, f"{type(part).__name__} '{system.name(part)}'") for part in getattr(system, kind)]
        for kind in ("bodies", "joints", "forces")
    }
    return {"format": SYSTEM, "version": FORMAT, "gravity": system.gravity.tolist(), **lists}


def rebuild(data: Mapping[str, Any]) -> System:
    """The system that `describe` wrote, bit for bit.

    Parameters
    ----------
    data : mapping
        From `describe`, possibly through JSON.

    Returns
    -------
    System
        Checked by the constructors of its parts.

    Raises
    ------
    ValueError
        For another format or version, an unknown type or field, a reference to a part that is not there, or values
        that the constructors refuse.
    """
    return read_system(data)[0]


def read_system(data: Any) -> tuple[System, Reader]:
    """The system and what resolves references to its parts."""
    check_format(data, SYSTEM, "system description")
    lists = {kind: data.get(kind) for kind in ("bodies", "joints", "forces")}
    for kind, entries in lists.items():
        if not isinstance(entries, list):
            raise ValueError(f"system description: {kind} is {entries!r}; give a list")
    reader = Reader(lists["bodies"], lists["joints"])
    built = [reader.joint(i) for i in range(len(lists["joints"]))]
    acting = [reader.part(entry) for entry in lists["forces"]]
    return System(reader.bodies, built, acting, gravity=data.get("gravity")), reader


def check_format(data: Any, expected: str, what: str) -> None:
    """Refuse other formats and versions."""
    if not isinstance(data, Mapping) or data.get("format") != expected:
        raise ValueError(f"{what}: is no {expected}; give what mbsd3d wrote")
    if data.get("version") != FORMAT:
        raise ValueError(
            f"{what}: has version {data.get('version')!r} of the format, this mbsd3d reads {FORMAT}; "
            "use the mbsd3d that wrote it, or make it again with this one"
        )


def with_suffix(path: str | Path, suffix: str) -> Path:
    """The path, with the suffix appended unless it is there."""
    path = Path(path)
    return path if path.name.endswith(suffix) else path.with_name(path.name + suffix)


def write_atomically(path: Path, content: bytes) -> Path:
    """Write a whole file or nothing: under a temporary name in the same folder, then renamed.

    Parameters
    ----------
    path : Path
        Where the content will be; an older file is replaced.
    content : bytes
        All of it.

    Returns
    -------
    Path
        ``path``.

    Raises
    ------
    ValueError
        If the folder does not exist or cannot be written.
    """
    part = path.with_name(f".{path.name}.{uuid.uuid4().hex[:8]}.part")
    try:
        try:
            with part.open("xb") as handle:
                handle.write(content)
                handle.flush()
                os.fsync(handle.fileno())
            os.replace(part, path)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        raise ValueError(
            f"'{path}' cannot be written: {error.strerror}; give a file in a folder that exists, is yours and has space"
        ) from error
    return path


def save(solution: Solution, path: str | Path) -> Path:
    """Write a solution and its system to one file: arrays, and the rest as JSON text; no pickle.

    Parameters
    ----------
    solution : Solution
        Of a system that `describe` can write.
    path : str or Path
        ".npz" is appended if it is missing; an older file is replaced in one go.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ValueError
        If a part cannot be described, or the folder cannot be written.
    """
    system, record = solution.system, solution.record
    write, known = Writer(system), solution.__dict__.get("certificate")
    count = len(compile_system(system).coordinate_index)  # without that of the measure of stop_when
    final = solution.final
    if final.coordinates is not None:
        final = replace(final, coordinates=final.coordinates[:count])
    document = {
        "format": SOLUTION,
        "version": FORMAT,
        "written_by": package_version(),
        "system": describe(system),
        "record": write.part(record, "record"),
        "final": write.part(final, "final state"),
        "estimate": {"error": known and known.error, "order": known and known.order},
    }
    arrays = {name: np.asarray(array, float) for name, array in solution.arrays.items() if name not in DERIVED}
    arrays["coordinate"] = arrays["coordinate"][:, :count]
    text = np.frombuffer(json.dumps(document, allow_nan=False).encode(), np.uint8)
    buffer = io.BytesIO()
    np.savez(buffer, json=text, **arrays)
    return write_atomically(with_suffix(path, ".npz"), buffer.getvalue())


def package_version() -> str:
    """Version of mbsd3d."""
    from . import __version__

    return __version__


def load(path: str | Path) -> Solution:
    """Read a file of ``solution.save``; everything a solution can do works on the result.

    Parameters
    ----------
    path : str or Path
        With or without ".npz".

    Returns
    -------
    Solution
        The same numbers, bit for bit; its certificate is checked anew.

    Raises
    ------
    ValueError
        If the file is missing, truncated, of another kind or version, or its parts do not fit together.
    """
    source = Path(path) if Path(path).is_file() else with_suffix(path, ".npz")
    if not source.is_file():
        raise ValueError(f"'{source}': there is no such file; give one written by solution.save(path)")
    try:
        with source.open("rb") as handle:
            return read_solution(handle)
    except BROKEN as error:
        reason = str(error) or type(error).__name__
        raise ValueError(
            f"'{source}' cannot be read as a solution, it is of another kind, truncated or changed ({reason}); "
            "give a file written by solution.save(path), or run the simulation again"
        ) from error


def read_solution(handle: Any) -> Solution:
    """Arrays and text of an open file, checked against each other: kernels do not check bounds."""
    if not zipfile.is_zipfile(handle):
        raise ValueError("no complete .npz file")
    handle.seek(0)
    with np.load(handle, allow_pickle=False) as stored:
        arrays = {name: stored[name] for name in stored.files}
    document = json.loads(bytes(arrays.pop("json")))
    check_format(document, SOLUTION, "its text")
    system, reader = read_system(document["system"])
    record, final = reader.part(document["record"]), reader.part(document["final"])
    if not isinstance(record, Record) or not isinstance(record.switches, Switches) or not isinstance(final, State):
        raise ValueError("record and final state are of the wrong type")
    record.rank_events = list(record.rank_events)
    compiled = compile_system(system, (), record.switches)
    check_arrays(compiled, arrays, final)
    n = len(system.bodies)
    arrays["q"] = arrays["state"][:, : 7 * n].reshape(-1, n, 7)
    arrays["z"] = arrays["state"][:, 13 * n :]
    solution = Solution(compiled, arrays, record, final)
    estimate = document["estimate"]
    if estimate["error"] is None:
        return solution
    return solution.with_certificate(replace(solution.certificate, **estimate))


def check_arrays(compiled: Compiled, arrays: dict[str, Any], final: State) -> None:
    """Every array is there with the shape the model gives it."""
    model, system, n = compiled.model, compiled.system, len(compiled.system.bodies)
    rows, coordinates, elements = compiled.row_joint.size, len(compiled.coordinate_index), len(system.forces)
    shapes = {
        "t": (), "state": (13 * n + model.z_impulse + 6,), "v": (n, 6), "acceleration": (n, 6), "lam": (rows,),
        "coordinate": (coordinates,), "potential": (elements,), "power": (elements,), "residual": (2,),
    }  # fmt: skip
    samples = np.shape(arrays["t"])[:1]
    for name, shape in shapes.items():
        array = arrays[name]
        if not isinstance(array, np.ndarray) or array.dtype != float or array.shape != (*samples, *shape):
            raise ValueError(f"array '{name}' has shape {np.shape(array)}, its system needs {(*samples, *shape)}")
    sizes = (final.q.size, final.z.size, coordinates if final.coordinates is None else np.size(final.coordinates))
    if sizes != (7 * n, model.z_work, coordinates):
        raise ValueError("the final state does not fit the system")


class Quantity(NamedTuple):
    """What a column of numbers means."""

    unit: str
    frame: str
    description: str


QUANTITIES = {
    "position": Quantity("m", "world", "position of the reference point O"),
    "orientation": Quantity("1", "body -> world", "unit quaternion (e0, e1, e2, e3), scalar first, active"),
    "velocity": Quantity("m/s", "world", "velocity of the reference point O"),
    "omega": Quantity("rad/s", "world", "angular velocity"),
    "omega_body": Quantity("rad/s", "body", "angular velocity"),
    "acceleration": Quantity("m/s^2", "world", "acceleration of the reference point O"),
    "alpha": Quantity("rad/s^2", "world", "angular acceleration"),
    "com": Quantity("m", "world", "position of the centre of mass"),
    "angle": Quantity("rad", "joint", "angle of b relative to a, unwrapped, 0 at the reference pose; NaN: has none"),
    "slide": Quantity("m", "joint", "displacement of b relative to a, 0 at the reference pose; NaN: has none"),
    "rate": Quantity("rad/s", "joint", "rate of the angle; NaN: has none"),
    "slide_rate": Quantity("m/s", "joint", "rate of the slide of a joint without angle; NaN: has none"),
    "reaction_force": Quantity("N", "world", "force of the joint on its body b"),
    "reaction_moment": Quantity("N m", "world", "moment of the joint on its body b about reaction_point"),
    "reaction_point": Quantity("m", "world", "point at which the reaction is given"),
    "reaction_unique": Quantity("1", "none", "1: determined by the constraints, 0: a least-norm share"),
    "effort": Quantity("N m or N", "joint", "torque or force of the driver on b along its motion, see driver_unit"),
    "kinetic": Quantity("J", "world", "kinetic energy"),
    "potential": Quantity("J", "world", "potential energy of gravity and springs"),
    "total": Quantity("J", "world", "kinetic and potential energy"),
    "work": Quantity("J", "world", "work done by drivers and by forces that store no energy"),
    "linear_momentum": Quantity("kg m/s", "world", "momentum"),
    "angular_momentum": Quantity("kg m^2/s", "world", "angular momentum about the world origin"),
    "position_drift": Quantity("m or rad", "none", "largest residual of the joints"),
    "velocity_drift": Quantity("m/s or rad/s", "none", "largest velocity residual of the joints"),
}

BODY_QUANTITIES = ("position", "orientation", "velocity", "omega", "omega_body", "acceleration", "alpha", "com")


class Column(NamedTuple):
    """One quantity of one part: (samples,) or (samples, components), or one value for all samples."""

    kind: str
    part: str
    quantity: str
    unit: str
    values: np.ndarray


def columns(solution: Solution) -> list[Column]:
    """All quantities of all parts; kind is "body", "joint", "driver" or "" for the whole system."""
    system, found = solution.system, []

    def add(kind: str, part: str, quantity: str, values: Any) -> None:
        found.append(Column(kind, part, quantity, QUANTITIES[quantity].unit, np.asarray(values)))

    for body in system.bodies:
        for quantity in BODY_QUANTITIES:
            add("body", body.name, quantity, getattr(solution, quantity)(body))
    for joint in system.joints:
        name, turns, slides = system.name(joint), joint.angle() is not None, joint.slide() is not None
        for quantity, has in (("angle", turns), ("slide", slides), ("rate", turns)):
            if has:
                add("joint", name, quantity, getattr(solution, quantity)(joint))
        if slides and not turns:
            add("joint", name, "slide_rate", solution.rate(joint))
        for quantity, values in vars(solution.reaction(joint)).items():
            add("joint", name, f"reaction_{quantity}", values)
    for driver in dict.fromkeys(driver for driver, _ in solution.compiled.drives):
        found += columns_of_effort(solution, driver)
    for quantity, values in vars(solution.energy()).items():
        add("", "energy", quantity, values)
    for owner in ("momentum", "drift"):
        for quantity, values in vars(getattr(solution, owner)()).items():
            add("", "", f"{quantity}_{owner}", values)
    return found


def columns_of_effort(solution: Solution, driver: Any) -> list[Column]:
    """One column per row of a driver; a driver of several rows is named with the axis or the number of the row."""
    effort = solution.effort(driver).reshape(solution.t.size, -1)
    units = [unit for row in driver.rows() for unit in ["N" if row.in_metres else "N m"] * row.n_rows]
    if isinstance(driver, PositionDriver):
        labels = [f".{axis}" for axis, signal in zip("xyz", driver.signal, strict=True) if signal is not None]
    else:
        labels = [""] if len(units) == 1 else [f".{k}" for k in range(len(units))]
    names = [solution.system.name(driver) + label for label in labels]
    return [Column("driver", name, "effort", *rest) for name, *rest in zip(names, units, effort.T, strict=True)]


def components(values: np.ndarray) -> tuple[str, tuple[str, ...]]:
    """Dimension and labels of the components of a column."""
    if values.ndim < 2:
        return "", ()
    return ("axis", ("x", "y", "z")) if values.shape[1] == 3 else ("quaternion", ("e0", "e1", "e2", "e3"))


def to_csv(solution: Solution, path: str | Path) -> Path:
    """Write a table with one row per sample and one column per component, e.g. ``crank.position.x [m]``.

    Parameters
    ----------
    solution : Solution
        Its numbers are written such that they read back equal.
    path : str or Path
        ".csv" is appended if it is missing; an older file is replaced in one go.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ValueError
        If the folder cannot be written.
    """
    header, table = ["time [s]"], [solution.t]
    for column in columns(solution):
        labels = [f".{label}" for label in components(column.values)[1]] or [""]
        name = ".".join(text for text in (column.part, column.quantity) if text)
        header += [f"{name}{label} [{column.unit}]" for label in labels]
        values = np.broadcast_to(column.values, solution.t.shape) if column.values.ndim == 0 else column.values
        table += list(values.reshape(solution.t.size, len(labels)).T)
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(header)
    rows.writerows(zip(*(values.astype(float).tolist() for values in table), strict=True))
    return write_atomically(with_suffix(path, ".csv"), text.getvalue().encode())


def to_xarray(solution: Solution) -> Any:
    """All quantities as an xarray Dataset; ``dataset.to_netcdf(path, engine="h5netcdf")`` writes it.

    Parameters
    ----------
    solution : Solution
        Of any system.

    Returns
    -------
    xarray.Dataset
        Dimensions time, body, joint, driver, axis (x, y, z) and quaternion (e0 ... e3); every variable carries units,
        frame and description. Quantities a joint does not have are NaN.
    """
    import xarray

    found, system = columns(solution), solution.system
    efforts = [column for column in found if column.kind == "driver"]
    names = {
        "body": [body.name for body in system.bodies],
        "joint": [system.name(joint) for joint in system.joints],
        "driver": [column.part for column in efforts],
    }
    grouped: dict[tuple[str, str], list[Column]] = {}
    for column in found:
        grouped.setdefault((column.kind, column.quantity), []).append(column)
    variables = {key[1]: variable(key[0], group, names, solution.t.size) for key, group in grouped.items()}
    labels = {"axis": ["x", "y", "z"], "quaternion": ["e0", "e1", "e2", "e3"]} | {k: v for k, v in names.items() if v}
    labels["time"] = ("time", solution.t, {"units": "s", "description": "time"})
    if efforts:
        labels["driver_unit"] = ("driver", [column.unit for column in efforts])
    return xarray.Dataset(variables, labels, attributes(solution))


def variable(kind: str, group: list[Column], names: dict[str, list[str]], samples: int) -> tuple[list[str], Any, dict]:
    """Dimensions, values and attributes of one quantity of all parts of a kind."""
    unit, frame, description = QUANTITIES[group[0].quantity]
    attrs = {"units": unit, "frame": frame, "description": description}
    values = group[0].values
    dimension = [name for name in components(values)[:1] if name]
    if not kind:
        return ["time", *dimension], values, attrs
    if values.ndim == 0:
        return [kind], np.array([int(column.values) for column in group]), attrs
    whole = np.full((samples, len(names[kind]), *values.shape[1:]), np.nan)
    for column in group:
        whole[:, names[kind].index(column.part)] = column.values
    return ["time", kind, *dimension], whole, attrs


def attributes(solution: Solution) -> dict[str, Any]:
    """What netCDF can hold of how the solution was made."""
    certificate = solution.certificate
    return {
        "method": str(solution.record.method),
        "rtol": float(solution.record.rtol),
        "steps": int(solution.record.steps),
        "stopped_by": solution.record.stopped_by or "end of the run",
        "certificate_passed": int(certificate.passed),
        "certificate": str(certificate),
        "gravity": solution.system.gravity.tolist(),
        "mbsd3d_version": package_version(),
    }
