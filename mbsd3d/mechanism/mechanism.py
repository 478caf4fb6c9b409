"""The mechanism as data: bodies, joints, forces and gravity, with the checks that need no computation."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, field
from types import MappingProxyType
from typing import Any

import numpy as np

from ..base.checks import check_choice, check_name, short_repr
from ..base.errors import InputError
from ..base.fields import Frozen, Members, Vector, derive, kept, part_class
from .bodies import GROUND, Body, Part, describe_part
from .force_element import ForceElement
from .joints import Joint
from .limits import Limit, as_limits, as_sentences

PART_CLASSES = MappingProxyType({"bodies": Body, "joints": Joint, "forces": ForceElement})

KINDS = tuple(PART_CLASSES)


def as_parts(value: Any, what: str, part: Any) -> tuple[Any, ...]:
    """Convert a sequence of parts of the kind that belongs there, each once."""
    key = what.removeprefix("System: ")
    try:
        parts = tuple(value)
    except TypeError:
        raise InputError(f"{what} = {short(value)} is not a sequence; give a list, {key}=[...]") from None
    for each in parts:
        if not isinstance(each, PART_CLASSES[key]):
            raise InputError(misplaced(each, key))
    if len({id(each) for each in parts}) < len(parts):
        raise InputError(f"System: a part appears twice in {key}; list every part once")
    return parts


def misplaced(part: Any, key: str) -> str:
    """Return the error message for a part given in the list of another kind."""
    for other, kind in PART_CLASSES.items():
        if isinstance(part, kind):
            return f"System: {short(part)} is in {key}; it belongs in {other}=[...]"
    if isinstance(part, type) and issubclass(part, tuple(PART_CLASSES.values())):
        return f"System: {part.__name__} in {key} is a class; make a part of it, {part.__name__}(...)"
    return f"System: {short(part)} in {key} is not a {PART_CLASSES[key].__name__}"


def short(part: Any) -> str:
    """Return a part by its type and name, anything else as it prints, cut."""
    if isinstance(part, Body | Joint | ForceElement):
        return describe_part(part)
    return short_repr(part)


def made_of(cls: type["Mechanism"], parts: tuple[Any, ...], gravity: np.ndarray, rest: dict[str, Any]) -> "Mechanism":
    """Describe a mechanism for copies and pickles."""
    bodies, joints, forces = parts
    return cls(bodies, joints, forces, gravity, **rest)


@part_class()
class Mechanism(Frozen):
    """Bodies, joints and forces with their names; the public `System` adds the analyses.

    ``title`` is the name of the whole; ``limits`` are watched and ``notes`` repeated by the certificate of every run.
    ``derived`` holds what layers above have computed once, such as its tables;
    nothing in it is part of the description.
    """

    bodies: Members[Body] = kept(by=as_parts)
    joints: Members[Joint] = kept(default=(), by=as_parts)
    forces: Members[ForceElement] = kept(default=(), by=as_parts)
    gravity: Vector = kept(default=(0.0, 0.0, -9.81))
    _: KW_ONLY
    title: str | None = None  # of pages, files and tables
    limits: Members[Limit] = kept(default=(), by=as_limits)
    notes: Members[str] = kept(default=(), by=as_sentences)
    names: Mapping[int, str] = field(init=False, repr=False)
    derived: dict[str, Any] = field(default_factory=dict, init=False, repr=False)

    def what(self) -> str:
        return "System"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.title is not None and (not isinstance(self.title, str) or not self.title.strip()):
            raise InputError(f"System: name {self.title!r} is not a name; give a text, or None")
        if self.title is not None:
            check_name(self.title, "System:")
        if not self.bodies:
            raise InputError("System: no bodies; give at least one Body")
        derive(self, names=self._names())
        self._check_members()

    def __reduce__(self) -> tuple[Any, ...]:
        """Make copies anew of copied parts: names and tables are kept by the identity of the parts."""
        return made_of, (type(self), (self.bodies, self.joints, self.forces), self.gravity, self.besides())

    def besides(self) -> dict[str, Any]:
        """Return what a system keeps beside its parts and gravity, as its constructor takes it."""
        return {"title": self.title, "limits": self.limits, "notes": self.notes}

    def _names(self) -> dict[int, str]:
        """Return the names of all parts; nameless ones are numbered by type."""
        names: dict[int, str] = {id(GROUND): "ground"}
        counts: dict[str, int] = {}
        taken = {"ground"}
        parts: tuple[Body | Part, ...] = (*self.bodies, *self.joints, *self.forces)
        for part in parts:
            name = part.name
            if name is None:
                kind = type(part).__name__
                counts[kind] = counts.get(kind, 0) + 1
                name = f"{kind} {counts[kind]}"
            if name in taken:
                raise InputError(f"System: two parts are named '{name}'; give every part a unique name")
            names[id(part)] = name
            taken.add(name)
        return names

    def _check_members(self) -> None:
        """Check that every joint and force acts on bodies of this system and refers to joints and forces of it."""
        members = {id(body) for body in self.bodies} | {id(GROUND)}
        parts: tuple[Joint | ForceElement, ...] = (*self.joints, *self.forces)
        known = {id(part) for part in parts} | {id(part.held()) for part in self.joints}
        for part in parts:
            for body in part.bodies():
                if id(body) not in members:
                    raise InputError(
                        f"{type(part).__name__} '{self.name(part)}': body '{body.name}' is not in the system; "
                        "add it to bodies"
                    )
            for other in part.replaces():
                if any(other is one for one in parts):
                    raise InputError(
                        f"{part.what()}: stands in place of '{self.name(other)}', which is in the system too; leave "
                        "that out of it"
                    )
            for other in part.partners():
                if id(other) not in known:
                    kind = "joint" if isinstance(other, Joint) else "force"
                    raise InputError(
                        f"{type(part).__name__} '{self.name(part)}': its {kind} '{other.name}' is not in the "
                        f"system; add it to {kind}s"
                    )

        for limit in self.limits:
            if id(limit.joint) not in known:
                raise InputError(f"{limit.what()}: its joint is not in the system; add it to joints")

    def name(self, part: Any) -> str:
        """Name of a part of this system."""
        return self.names.get(id(part), getattr(part, "name", None) or type(part).__name__)

    def part(self, key: Any, kind: str = "bodies") -> Any:
        """Return a part given by itself or by its name; ValueError that lists the names for an unknown one."""
        check_choice(kind, KINDS, "part: kind")
        parts = getattr(self, kind)
        if type(key) is not str and isinstance(key, Body | Joint | ForceElement) and key in parts:
            return key
        for part in parts if kind == "joints" and isinstance(key, Joint) else ():
            if part.held() is key:
                return part
        if isinstance(key, str):
            for part in parts:
                if self.names[id(part)] == key:
                    return part
        have = ", ".join(f"'{self.name(part)}'" for part in parts) or "none"
        if isinstance(key, Body | Joint | ForceElement) and key.name in [self.name(part) for part in parts]:
            raise InputError(f"the '{key.name}' given is a part of another system; give its name instead")
        key = getattr(key, "name", None) or key
        raise InputError(f"{short_repr(key)} is not one of the {kind} of this system; there are {have}")

    def total_mass(self) -> float:
        """Sum of the masses of all bodies [kg]."""
        return float(np.sum([body.mass for body in self.bodies]))
