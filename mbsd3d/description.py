"""Systems as plain data: type names and fields, for files and for everything that is sent elsewhere.

The types a description names are looked up in `TYPES`, the package's own parts; nothing is imported or evaluated
because a description says so.
"""

import inspect
import math
from collections.abc import Mapping
from dataclasses import MISSING, fields
from types import MappingProxyType
from typing import Any

import numpy as np

from . import contacts, couplings, drivers, feedback, forces, joints, signals
from .custom import CustomForce, SavedForce
from .forces import ForceElement
from .integrators.dop853 import DOP853
from .integrators.driven import Kinematic
from .integrators.rk4 import RK4
from .job import Record
from .joints import Joint
from .measures import Condition, Measure
from .model import Switches
from .parts import GROUND, Body, Ground
from .primitives import Coordinate
from .signals import Signal
from .state import State
from .system import System

FORMAT = 1  # rises when a description or a file of the old form cannot be read any more
SYSTEM = "mbsd3d system"


def own_types() -> dict[str, type]:
    """Name -> class of all a file may hold: every part class with content of its own, and what a record is made of."""
    found: dict[str, type] = {}
    for module, base, content in (
        (joints, Joint, "rows"),
        (couplings, Joint, "rows"),
        (contacts, Joint, "rows"),
        (drivers, Joint, "rows"),
        (forces, ForceElement, "record"),
        (feedback, ForceElement, "record"),
        (signals, Signal, "terms"),
    ):
        for name, kind in inspect.getmembers(module, inspect.isclass):
            if kind.__module__ == module.__name__ and issubclass(kind, base):
                if getattr(kind, content) is not getattr(base, content):
                    found[name] = kind
    others = (Body, Measure, Condition, Coordinate, State, Switches, Record, DOP853, RK4, Kinematic, SavedForce)
    return found | {kind.__name__: kind for kind in others}


TYPES: Mapping[str, type] = MappingProxyType(own_types())


class Writer:
    """Turns values into JSON-able ones; bodies, joints and forces of the system become references to their place."""

    def __init__(self, system: System) -> None:
        self.references: dict[int, dict] = {id(body): {"body": i} for i, body in enumerate(system.bodies)}
        self.references |= {id(joint): {"joint": i} for i, joint in enumerate(system.joints)}
        self.references |= {id(force): {"force": i} for i, force in enumerate(system.forces)}

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
        if kind is CustomForce:
            raise ValueError(f"{what}: its function cannot be written to a file; build this force in Python")
        if TYPES.get(kind.__name__) is not kind:
            raise ValueError(
                f"{what}: a {kind.__name__} cannot be written to a file; only numbers, texts, arrays and the parts of "
                "mbsd3d can, no functions and no classes of your own"
            )
        names = [field.name for field in fields(part) if field.init]
        return {"type": kind.__name__} | {name: self.value(getattr(part, name), f"{what}: {name}") for name in names}


class Reader:
    """The way back; joints and forces are built when one first refers to them."""

    def __init__(self, bodies: list, joint_data: list, force_data: list) -> None:
        self.joint_data, self.joints = joint_data, {}
        self.force_data, self.forces = force_data, {}
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
        if key == "force":
            return self.force(inner)
        if key == "array":
            return self.array(inner)
        if key == "map" and isinstance(inner, dict):
            return {name: self.value(item) for name, item in inner.items()}
        if key == "float" and inner in ("inf", "-inf", "nan"):
            return float(inner)
        raise ValueError(f"system description: {value!r} is not understood; write it with mbsd3d.description.describe")

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
        return self.once(index, self.joint_data, self.joints, "joint")

    def force(self, index: Any) -> ForceElement:
        """The force at a place, likewise."""
        return self.once(index, self.force_data, self.forces, "force")

    def once(self, index: Any, data: list, built: dict, kind: str) -> Any:
        """A part of a list that is built when first asked for."""
        index = self.index(index, len(data), kind)
        if index not in built:
            built[index] = None
            built[index] = self.part(data[index])
        if built[index] is None:
            raise ValueError(f"system description: {kind} {index} refers to itself; refer to another {kind}")
        return built[index]

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
            raise ValueError(f"{what}: {error}; write it with mbsd3d.description.describe") from error
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


def describe(system: System, *, without_functions: bool = False) -> dict[str, Any]:
    """A system as JSON-able data: type names and fields, bodies and joints referred to by their place.

    Parameters
    ----------
    system : System
        Made of the package's own parts.
    without_functions : bool
        Write a CustomForce as what is left of it without its function, for results; otherwise it is refused.

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

    def written(part: Any) -> dict[str, Any]:
        left = part.saved() if without_functions and isinstance(part, CustomForce) else part
        return write.part(left, f"{type(part).__name__} '{system.name(part)}'")

    lists = {kind: [written(part) for part in getattr(system, kind)] for kind in ("bodies", "joints", "forces")}
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
    reader = Reader(lists["bodies"], lists["joints"], lists["forces"])
    built = [reader.joint(i) for i in range(len(lists["joints"]))]
    acting = [reader.force(i) for i in range(len(lists["forces"]))]
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
