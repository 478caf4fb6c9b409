"""What a file may hold: one msgspec Struct per class, derived from the fields of its dataclass.

A new joint, force, signal or method needs nothing here: the annotations of its fields decide (see `base.fields`).
"""

import pkgutil
import typing
from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from functools import cache
from importlib import import_module
from types import GenericAlias, MappingProxyType, NoneType, UnionType
from typing import Any

import msgspec
import numpy as np

from .. import integrators, mechanism
from ..base.errors import InputError
from ..base.fields import FILE_VECTOR, kind_of
from ..constraints.engagement import Impulse
from ..equations.compiled import Switches
from ..integrators.method import Method
from ..mechanism.bodies import Body, Ground
from ..mechanism.force_element import ForceElement
from ..mechanism.joints import Joint
from ..mechanism.limits import Limit
from ..mechanism.measures import Condition, Measure
from ..mechanism.primitives import Coordinate
from ..mechanism.pulleys import Pulley, Winch
from ..mechanism.shapes import Shape
from ..mechanism.signals import Signal
from ..mechanism.state import State
from ..results.events import Event
from ..results.record import Record, RunOptions

TAGGED_CLASSES: tuple[type, ...] = (Joint, ForceElement, Signal, Shape, Method)
ROLE_TYPES: tuple[tuple[str, Any], ...] = (
    ("body", Body | Ground),
    ("joint", Joint),
    ("signal", Signal),
    ("shape", Shape),
    ("array", np.ndarray),
)
PLAIN_TYPES = (float, int, str, bool, NoneType)


@cache
def types() -> Mapping[str, type]:
    """Name -> class of all a file may hold: every part class without subclasses, and the parts of a record."""
    for package in (mechanism, integrators):  # so that all classes are known
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            import_module(module.name)
    found: dict[str, type] = {kind.__name__: kind for base in TAGGED_CLASSES for kind in below(base) if not below(kind)}
    others: tuple[type, ...] = (
        Body, Limit, Measure, Condition, Coordinate, State, Switches, RunOptions, Record,
        Event, Impulse, Pulley, Winch,
    )  # fmt: skip
    return MappingProxyType(found | {kind.__name__: kind for kind in others})


def below(base: Any) -> set[type]:
    """Return all classes of the package derived from ``base``."""
    subclasses: list[type] = base.__subclasses__()
    own = {kind for kind in subclasses if kind.__module__.startswith(f"{__name__.split('.')[0]}.")}
    return own.union(*(below(kind) for kind in own))


def members(annotation: Any) -> tuple[Any, ...]:
    """Return the alternatives of a union, through the items of tuples: ``tuple[Body, ...] | None`` -> (Body, None)."""
    inner = typing.get_args(annotation) if isinstance(typing.get_origin(annotation), type | UnionType) else ()
    if typing.get_origin(annotation) is typing.Union:
        inner = typing.get_args(annotation)
    return tuple(x for item in inner for x in members(item)) if inner else (annotation,)


@cache
def roles(kind: Any) -> Mapping[str, str]:
    """Return field -> "body" or "joint" where a name refers to a part, "signal", "shape", or "array" of numbers."""
    found: dict[str, str] = {}
    for field in fields(kind):
        if stored := kind_of(field.type):
            found |= {field.name: stored.role} if stored.role else {}
            continue
        classes = [x for x in members(field.type) if isinstance(x, type)]
        for role, base in ROLE_TYPES:
            if any(issubclass(x, base) for x in classes):
                found[field.name] = role
    return MappingProxyType(found)


def json_type(annotation: Any) -> Any:
    """Return the type of the JSON value for an annotation."""
    if stored := kind_of(annotation):
        return stored.file_type
    if annotation in PLAIN_TYPES:
        return annotation
    origin = typing.get_origin(annotation)
    if origin in (UnionType, typing.Union):
        alternatives = [json_type(x) for x in typing.get_args(annotation)]
        return Any if Any in alternatives else typing.Union[tuple(alternatives)]  # noqa: UP007 - their number varies
    kind = origin or annotation
    if not isinstance(kind, type):
        return Any
    if issubclass(kind, Body | Ground):
        return str
    if issubclass(kind, Joint):
        return str | dict  # a name, or a joint that is not part of the system, as of one that has engaged
    if issubclass(kind, Mapping | Signal | Shape) or is_dataclass(kind):
        return dict
    if not issubclass(kind, Sequence | np.ndarray):
        return Any
    items = [x for x in typing.get_args(annotation) if x is not ...]
    return GenericAlias(list, json_type(items[0])) if len(items) == 1 and issubclass(kind, Sequence) else list


@cache
def struct(kind: Any) -> type[msgspec.Struct]:
    """Make the Struct of a class: its fields, the optional ones unset, no others."""
    wanted: list[Any] = []
    for field in fields(kind):
        if not field.init:
            continue
        accepted = json_type(field.type)
        if field.default is MISSING and field.default_factory is MISSING:
            wanted.append((field.name, accepted))
            continue
        if accepted is not Any:
            accepted = accepted | msgspec.UnsetType | (None if field.default is None else msgspec.UnsetType)
        wanted.append((field.name, accepted, msgspec.UNSET))
    return msgspec.defstruct(kind.__name__, wanted, tag_field="type", forbid_unknown_fields=True, kw_only=True)


class Document(msgspec.Struct, forbid_unknown_fields=True):
    """A system: what its parts hold is checked one by one."""

    format: str
    version: int
    gravity: FILE_VECTOR
    bodies: list[dict[str, Any]]
    joints: list[dict[str, Any]] = []
    forces: list[dict[str, Any]] = []
    name: str | None = None
    limits: list[dict[str, Any]] = []
    notes: list[str] = []


def place_of(path: tuple[Any, ...]) -> str:
    """Write ("bodies", 3, "mass") as ``$.bodies[3].mass``."""
    return "$" + "".join(f"[{key}]" if isinstance(key, int) else f".{key}" for key in path)


def check(data: Any, schema: type[msgspec.Struct], path: tuple[Any, ...], what: str) -> None:
    """Refuse data that do not fit a schema.

    ValueError with what was expected and where, e.g. "Expected `float`, got `str` - at `$.bodies[3].mass`".
    """
    try:
        msgspec.convert(data, schema)
    except msgspec.ValidationError as error:
        message, _, inside = str(error).partition(" - at `$")
        names = ", ".join(schema.__struct_fields__)
        remedy = f"; give {names}" if message.startswith("Object ") else ""
        raise InputError(f"{what}: {message} - at `{place_of(path)}{inside.rstrip('`')}`{remedy}") from None
