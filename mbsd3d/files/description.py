"""Systems as plain data: type names and fields, for files and for everything that is sent elsewhere.

Parts are referred to by name, and values that a constructor derives are left out. The types a description
names are looked up in the package's own parts; nothing is imported or evaluated because a description says so.
"""

import math
from collections.abc import Mapping
from dataclasses import MISSING, fields
from types import MappingProxyType
from typing import Any

import numpy as np

from ..base.checks import floats
from ..base.errors import InputError
from ..base.wording import with_article
from ..mechanism.bodies import GROUND, Body, Ground
from ..mechanism.force_element import ForceElement
from ..mechanism.joints import Joint
from ..mechanism.limits import Limit
from ..mechanism.mechanism import Mechanism
from ..mechanism.shapes import Shape
from ..mechanism.signals import Signal
from .schema import Document, check, place_of, roles, struct, types

MODEL_FORMAT_VERSION = 2  # [1] rises when a description or a file of the old form cannot be read any more
SYSTEM_KIND = "mbsd3d system"
PARTS_MAX = 20_000  # [parts] of a file: some seconds
REFERENCED_CLASSES = MappingProxyType({"body": Body, "joint": Joint, "force": ForceElement})
NESTED_CLASSES = MappingProxyType({"signal": Signal, "shape": Shape})
# a value that no constructor was made for
CONSTRUCTOR_ERRORS = (TypeError, AttributeError, OverflowError, IndexError, KeyError)


def identical(first: Any, second: Any) -> bool:
    """Return whether two values are equal to the last bit: types, shapes and bytes of arrays, fields of parts."""
    if first is second:
        return True
    if type(first) is not type(second):
        return False
    if isinstance(first, np.ndarray):
        return first.shape == second.shape and first.dtype == second.dtype and first.tobytes() == second.tobytes()
    if isinstance(first, list | tuple):
        return len(first) == len(second) and all(map(identical, first, second))
    if type(first).__name__ in types():
        return all(identical(getattr(first, x.name), getattr(second, x.name)) for x in fields(first))
    return repr(first) == repr(second) if isinstance(first, float) else first == second


def constructor_arguments(part: Any) -> dict[str, Any]:
    """Return the fields from which the constructor makes the same part, without those it derives itself."""
    values = {x.name: getattr(part, x.name) for x in fields(part) if x.init and getattr(part, x.name) is not x.default}
    optional = [x.name for x in fields(part) if x.default is not MISSING or x.default_factory is not MISSING]
    for name in (name for name in optional if name in values):
        rest = {key: value for key, value in values.items() if key != name}
        try:
            built = type(part)(**rest)
        except (ValueError, *CONSTRUCTOR_ERRORS):
            continue
        if all(identical(getattr(built, x.name), getattr(part, x.name)) for x in fields(part) if x.init):
            values = rest
    return values


class Writer:
    """Turns values into JSON-able ones; parts of the system become references by name."""

    def __init__(self, system: Mechanism) -> None:
        self.names: dict[int, tuple[str, str]] = {id(GROUND): ("body", GROUND.name)}
        self.names |= {id(body): ("body", body.name) for body in system.bodies}
        self.names |= {id(joint): ("joint", system.name(joint)) for joint in system.joints}
        self.names |= {id(force): ("force", system.name(force)) for force in system.forces}

    def value(self, value: Any, what: str, role: str = "") -> Any:
        """Describe one value; ``what`` names it in errors, ``role`` is its field's."""
        if id(value) in self.names:
            kind, name = self.names[id(value)]
            return name if kind == role else {kind: name}
        if isinstance(value, np.generic | np.ndarray):
            value = value.tolist()
        if value is None or isinstance(value, bool | int | str):
            return value
        if isinstance(value, float):
            return value if math.isfinite(value) else {"float": repr(value)}
        if isinstance(value, list | tuple):
            return [self.value(item, what, role) for item in value]
        if isinstance(value, Mapping):
            return {"map": {str(key): self.value(item, what, role) for key, item in value.items()}}
        return self.part(value, what)

    def part(self, part: Any, what: str) -> dict[str, Any]:
        """Describe a part, a signal or a method by type and fields."""
        kind: Any = type(part)
        if hasattr(part, "saved"):
            raise InputError(f"{what}: its function cannot be written to a file; build this {kind.__name__} in Python")
        if kind not in types().values():
            raise InputError(
                f"{what}: {with_article(kind.__name__)} cannot be written to a file; "
                "only numbers, texts, arrays and the parts of "
                "mbsd3d can, no functions and no classes of your own"
            )
        role = roles(kind)
        data = {
            name: self.value(x, f"{what}: {name}", role.get(name, ""))
            for name, x in constructor_arguments(part).items()
        }
        data = {"type": kind.__name__} | ({"name": data.pop("name")} if "name" in data else {}) | data
        check(data, struct(kind), (), what)
        return data


class Reader:
    """The way back; joints and forces are built when one first refers to them."""

    def __init__(self, data: Mapping[str, Any]) -> None:
        self.bodies: dict[str, Body | Ground] = {GROUND.name: GROUND}
        for i, entry in enumerate(data["bodies"]):
            body = self.part({"type": "Body"} | entry, ("bodies", i), Body)
            if body.name in self.bodies:
                raise InputError(
                    f"two bodies are named '{body.name}' - at `$.bodies[{i}].name`; give each its own name"
                )
            self.bodies[body.name] = body
        self.places = {kind: index_by_name(data.get(f"{kind}s", []), kind) for kind in ("joint", "force")}
        self.made: dict[tuple[Any, ...], Any] = {}
        self.joints = [self.listed("joint", name, ()) for name in self.places["joint"]]
        self.forces = [self.listed("force", name, ()) for name in self.places["force"]]

    def value(self, value: Any, path: tuple[Any, ...], role: str = "") -> Any:
        """Read one value at ``path``; ``role`` is its field's."""
        if isinstance(value, list):
            if set(map(type, value)) == {float} and all(map(math.isfinite, value)):
                return tuple(value)
            return tuple(self.value(item, (*path, i), role) for i, item in enumerate(value))
        if isinstance(value, float) and not math.isfinite(value):
            raise InputError(f"{value} is not finite - at `{place_of(path)}`; give a finite number")
        if isinstance(value, dict):
            return self.part(value, path, NESTED_CLASSES[role]) if role in NESTED_CLASSES else self.tagged(value, path)
        if not (value is None or isinstance(value, bool | int | float | str)):  # TOML knows dates
            raise InputError(f"{value} is not understood - at `{place_of(path)}`; give numbers, texts and lists")
        if isinstance(value, str) and role in REFERENCED_CLASSES:
            return self.referred(role, value, path)
        return value

    def tagged(self, value: dict[str, Any], path: tuple[Any, ...]) -> Any:
        """Read an object: a part, or a value that JSON has no form for."""
        if "type" in value:
            return self.part(value, path)
        key, inner = next(iter(value.items())) if len(value) == 1 else ("", None)
        if key in REFERENCED_CLASSES and isinstance(inner, str):
            return self.referred(key, inner, path)
        if key == "map" and isinstance(inner, dict):
            return {name: self.value(item, (*path, key, name)) for name, item in inner.items()}
        if key == "float" and inner in ("inf", "-inf", "nan"):
            return float(inner)
        raise InputError(f"{str(value)[:80]} is not understood - at `{place_of(path)}`; give a part with its type")

    def referred(self, kind: str, name: str, path: tuple[Any, ...]) -> Any:
        """Return the part of a name."""
        known = self.bodies if kind == "body" else self.places[kind]
        if name not in known:
            have = ", ".join(f"'{other}'" for other in list(known)[:20]) or "none"
            raise InputError(f"there is no {kind} '{name}' - at `{place_of(path)}`; there are {have}")
        return self.bodies[name] if kind == "body" else self.listed(kind, name, path)

    def listed(self, kind: str, name: str, path: tuple[Any, ...]) -> Any:
        """Return the joint or force of a name; one that is under construction refers to itself."""
        if (kind, name) not in self.made:
            self.made[kind, name] = None
            i, entry = self.places[kind][name]
            self.made[kind, name] = self.part(entry, (f"{kind}s", i), REFERENCED_CLASSES[kind])
        if self.made[kind, name] is None:
            raise InputError(f"{kind} '{name}' refers to itself - at `{place_of(path)}`; refer to another {kind}")
        return self.made[kind, name]

    def part(self, data: dict[str, Any], path: tuple[Any, ...], base: type = object) -> Any:
        """Make a part from its type and fields, checked against the schema and by its own constructor."""
        if not isinstance(data, dict):
            raise InputError(f"{str(data)[:80]} is not a part - at `{place_of(path)}`; give an object with its type")
        name_of_type = data.get("type")
        kind: Any = types().get(name_of_type) if isinstance(name_of_type, str) else None
        if kind is None or not issubclass(kind, base):
            have = ", ".join(sorted(name for name, known in types().items() if issubclass(known, base)))
            raise InputError(f"type {data.get('type')!r} is unknown - at `{place_of(path)}`; give one of {have}")
        name = data.get("name")
        check(data, struct(kind), path, f"{kind.__name__} '{name}'" if isinstance(name, str) else kind.__name__)
        role = roles(kind)
        values = {key: self.value(x, (*path, key), role.get(key, "")) for key, x in data.items() if key != "type"}
        try:
            arrays = {
                key: floats(x, key, "numbers")
                for key, x in values.items()
                if role.get(key) == "array" and x is not None
            }
            return kind(**values | arrays)
        except (ValueError, *CONSTRUCTOR_ERRORS) as error:
            raise InputError(f"{error} - at `{place_of(path)}`") from error


def index_by_name(entries: list[dict[str, Any]], kind: str) -> dict[str, tuple[int, dict[str, Any]]]:
    """Name -> (place, entry) of all joints or forces; nameless ones are numbered by type, as `System` does."""
    found: dict[str, tuple[int, dict[str, Any]]] = {}
    counts: dict[str, int] = {}
    for i, entry in enumerate(entries):
        name, cls = entry.get("name"), str(entry.get("type"))
        if name is None:
            counts[cls] = counts.get(cls, 0) + 1
            name = f"{cls} {counts[cls]}"
        if str(name) in found:
            raise InputError(f"two {kind}s are named '{name}' - at `$.{kind}s[{i}]`; give each its own name")
        found[str(name)] = (i, entry)
    return found


def describe(system: Mechanism, *, without_functions: bool = False) -> dict[str, Any]:
    """Describe a system as JSON-able data: type names and fields, parts by name; `read_system` is the way back.

    A force by a function is written as what its ``saved()`` says is left of it if ``without_functions`` (for results).
    ValueError for that else, and for anything but numbers, texts, arrays and the parts of the package.
    """
    write = Writer(system)
    lists: dict[str, list[Any]] = {"bodies": [], "joints": [], "forces": []}
    for kind, entries in lists.items():
        for part in getattr(system, kind):
            stored = part.saved() if without_functions and hasattr(part, "saved") else part
            entries.append(write.part(stored, f"{type(part).__name__} '{system.name(part)}'"))
            if stored is not part:  # another type: a number by type would be another name
                entries[-1]["name"] = system.name(part)
    for body in lists["bodies"]:
        del body["type"]
    head = {"format": SYSTEM_KIND, "version": MODEL_FORMAT_VERSION} | ({"name": system.title} if system.title else {})
    limits = [write.part(limit, limit.what()) for limit in system.limits]
    rest = {key: value for key, value in (("limits", limits), ("notes", list(system.notes))) if value}
    return {**head, "gravity": system.gravity.tolist(), **lists, **rest}


def read_system(data: Any) -> tuple[Mechanism, Reader]:
    """Return the system that `describe` wrote, bit for bit, and what resolves references to its parts.

    ValueError with the place, e.g. "at `$.bodies[3].mass`", for another format or version, an unknown type or field, a
    reference to a missing part, or values that the constructor of a part refuses.
    """
    check_format(data, SYSTEM_KIND, "system description")
    check(data, Document, (), "system description")
    check_count(data)
    reader = Reader(data)
    gravity = reader.value(data["gravity"], ("gravity",))
    bodies = [body for body in reader.bodies.values() if isinstance(body, Body)]
    limits = [reader.part(entry, ("limits", i), Limit) for i, entry in enumerate(data.get("limits", []))]
    besides = {"title": data.get("name"), "limits": limits, "notes": data.get("notes", [])}
    return Mechanism(bodies, reader.joints, reader.forces, gravity=gravity, **besides), reader


def check_count(data: Mapping[str, Any]) -> None:
    """Refuse a description that would take minutes to build."""
    count = sum(len(data.get(kind, ())) for kind in ("bodies", "joints", "forces", "limits"))
    if count > PARTS_MAX:
        raise InputError(f"system description: {count} parts, a file may have {PARTS_MAX}; build it in Python")


def check_format(data: Any, expected: str, what: str) -> None:
    """Refuse other formats and versions."""
    if not isinstance(data, Mapping) or data.get("format") != expected:
        raise InputError(f'{what}: is no {expected}; its first entry must be format: "{expected}"')
    if data.get("version") != MODEL_FORMAT_VERSION:
        raise InputError(
            f"{what}: has version {data.get('version')!r} of the format - at `$.version`, "
            f"this mbsd3d reads {MODEL_FORMAT_VERSION}; "
            "use the mbsd3d that wrote it, or make it again with this one"
        )
