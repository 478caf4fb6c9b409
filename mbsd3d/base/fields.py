"""Fields of parts: each is converted once, when its part is made, and read-only from then on.

A field has two types: what the constructor accepts and what the part keeps. ``at: Vector = kept()`` takes any three
numbers and keeps an array. Type checkers know both, and `mbsd3d.files` reads here what a file may hold.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import MISSING, Field, dataclass, field, fields
from functools import cache
from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Generic,
    NamedTuple,
    Never,
    Self,
    TypeVar,
    dataclass_transform,
    get_origin,
    overload,
)

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from .checks import as_tuple, number, plain_three, sequence, short_repr, vector
from .errors import ChecksArguments, InputError
from .mass_properties import check_inertia
from .rotations import as_quaternion, unit

Accepted = TypeVar("Accepted")  # by the constructor
Kept = TypeVar("Kept")  # by the part
P = TypeVar("P")
Public = TypeVar("Public")
FILE_VECTOR = Annotated[list[float], msgspec.Meta(min_length=3, max_length=3)]  # in files
FILE_DIRECTION = FILE_VECTOR | str  # "x", "y", "z" too
# in files: (3,), (4,) or (3, 3)
FILE_ROWS = Annotated[list[float | FILE_VECTOR], msgspec.Meta(min_length=3, max_length=4)]


def as_public(cls: type[Public], found: Any) -> Public:
    """Return what was found as the public class of the same fields."""
    return cls(**{x.name: getattr(found, x.name) for x in fields(cls)})  # type: ignore[arg-type]  # a dataclass


def kept(
    *,
    default: Any = MISSING,
    by: Callable[[Any, str, Any], Any] | None = None,
    derived: Callable[[Any], Any] | None = None,
    **rules: Any,
) -> Any:
    """Declare a field that is converted: by its kind with ``rules``, or by ``by(value, what, part)``.

    ``derived(part)``: what stands in for the default, from the fields before it.
    """
    return field(default=default, metadata={"by": by, "derived": derived, "rules": rules})


@dataclass_transform(eq_default=False, field_specifiers=(kept, field))
def part_class(*, eq: bool = False, repr: bool = True, init: bool = True) -> Callable[[type[P]], type[P]]:  # noqa: A002
    """Make a frozen dataclass whose fields are converted; it is compared by identity."""
    return dataclass(frozen=True, eq=eq, repr=repr, init=init)


class Stored(Generic[Accepted, Kept]):
    """A kind of field that accepts one type and keeps another.

    Type checkers read it as a descriptor; at run time a part has plain attributes.
    """

    accepts: ClassVar[str] = ""  # the first type, in signatures
    role: ClassVar[str] = ""  # in files: "body", "joint", "signal" or "shape", by name or with a type; "": a value
    file_type: ClassVar[Any] = Any  # of the value in a file, for msgspec
    convert: ClassVar[Callable[..., Any]]
    """``convert(value, what, part, **rules)``: what is kept; InputError that starts with ``what`` for nonsense."""

    if TYPE_CHECKING:

        @overload
        def __get__(self, part: None, owner: Any) -> Self: ...
        @overload
        def __get__(self, part: object, owner: Any) -> Kept: ...
        def __get__(self, part: object, owner: Any) -> Any: ...
        def __set__(self, part: Never, value: Accepted) -> None: ...


class Conversion(NamedTuple):
    """How a field is converted."""

    name: str
    convert: Callable[..., Any]
    rules: dict[str, Any]
    default: Any
    kept: Any  # of the default
    derived: Callable[[Any], Any] | None


def kind_of(annotation: Any) -> type[Stored[Any, Any]] | None:
    """Return the kind of a field, if its annotation is one."""
    kind = get_origin(annotation) or annotation
    return kind if isinstance(kind, type) and issubclass(kind, Stored) else None


@cache
def conversions(cls: type) -> tuple[Conversion, ...]:
    """Return how the fields of a class are converted, in their order; defaults are converted once for all parts."""
    found = []
    for x in fields(cls):
        kind, by, rules = kind_of(x.type), x.metadata.get("by"), x.metadata.get("rules", {})
        convert = by or (kind.convert if kind else None)
        if convert is None:
            continue
        ready = x.default if x.default in (MISSING, None) else convert(x.default, x.name, None, **rules)
        found.append(Conversion(x.name, convert, rules, x.default, ready, x.metadata["derived"]))
    return tuple(found)


class Frozen(metaclass=ChecksArguments):
    """Base of frozen dataclasses that convert their fields when they are made."""

    if TYPE_CHECKING:
        __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    def __post_init__(self) -> None:
        self.convert_fields(self.what())

    def what(self) -> str:
        """Return the type and name of the part, as errors begin."""
        return type(self).__name__

    def convert_fields(self, what: str) -> None:
        """Put what is kept of each field in its place; errors start with ``what``."""
        values = self.__dict__
        for name, convert, rules, default, ready, derived in conversions(type(self)):
            value = values[name]
            if value is not default:
                plain = plain_three(value) if convert is as_vector else None
                if plain is None:
                    values[name] = convert(value, f"{what}: {name}", self, **rules)
                else:
                    values[name] = locked(plain)
            elif derived is None:
                values[name] = ready
            else:
                values[name] = derived(self)


class Checked(Frozen):
    """The same with rules between fields."""

    def __post_init__(self) -> None:
        what = self.what()
        self.convert_fields(what)
        self.check(what)

    def check(self, what: str) -> None:
        """Refuse fields that do not fit each other; errors start with ``what``."""


def derive(part: Frozen, **values: Any) -> None:
    """Write what a part makes of several fields together, in its `check`."""
    vars(part).update(values)


def locked(array: np.ndarray) -> np.ndarray:
    """Make an array read-only and return it."""
    array.setflags(write=False)
    return array


def or_none(convert: Callable[..., Any]) -> Callable[..., Any]:
    """Let a conversion pass None on."""

    def converted(value: Any, what: str, part: Any, **rules: Any) -> Any:
        return None if value is None else convert(value, what, part, **rules)

    return converted


def as_vector(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert to three finite numbers (3,)."""
    return vector(value, what)


def as_direction(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert to a unit vector (3,)."""
    return unit(value, what)


def as_orientation(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert to a unit quaternion (4,)."""
    return locked(as_quaternion(value, what))


def as_inertia(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert to a symmetric matrix (3, 3) [kg m^2] that fits the mass of the part."""
    as_given = getattr(part, "inertia_as_given", False) is True
    return locked(check_inertia(value, part.mass, what.removesuffix(": inertia"), as_given=as_given))


def as_number(value: Any, what: str, part: Any, *, minimum: float | None = None, positive: bool = False) -> float:
    """Convert to a finite number within its range."""
    return number(value, what, minimum=minimum, positive=positive)


def as_numbers(value: Any, what: str, part: Any) -> tuple[float, ...]:
    """Convert to a tuple of finite numbers."""
    return sequence(value, what)


def as_members(value: Any, what: str, part: Any) -> tuple[Any, ...]:
    """Convert a sequence to a tuple of its members."""
    return as_tuple(value, what, "a list")


def true_or_false(value: Any, what: str, part: Any) -> bool:
    """Accept True or False, nothing that counts as one of them."""
    if not isinstance(value, bool):
        raise InputError(f"{what} = {short_repr(value)}; give True or False")
    return value


class Truth(Stored[Any, bool]):
    """True or False."""

    accepts, file_type = "bool", bool
    convert = staticmethod(true_or_false)


class Vector(Stored[ArrayLike, np.ndarray]):
    """Three finite numbers [m, m/s or rad/s], world or body axes as its part says."""

    accepts, file_type = "array_like", FILE_VECTOR
    convert = staticmethod(as_vector)


class VectorOrNone(Stored[ArrayLike | None, np.ndarray | None]):
    """Three finite numbers, or None."""

    accepts, file_type = "array_like | None", FILE_VECTOR
    convert = staticmethod(or_none(as_vector))


class VectorOrDerived(Stored[ArrayLike | None, np.ndarray]):
    """Three finite numbers; None = what follows from other fields."""

    accepts, file_type = "array_like | None", FILE_VECTOR
    convert = staticmethod(as_vector)


class Direction(Stored[str | ArrayLike, np.ndarray]):
    """A direction in world axes at the reference pose, "x", "y", "z" or three numbers, kept as a unit vector."""

    accepts, file_type = "str | array_like", FILE_DIRECTION
    convert = staticmethod(as_direction)


class DirectionOrNone(Stored[str | ArrayLike | None, np.ndarray | None]):
    """A direction, or None."""

    accepts, file_type = "str | array_like | None", FILE_DIRECTION
    convert = staticmethod(or_none(as_direction))


class DirectionOrDerived(Stored[str | ArrayLike | None, np.ndarray]):
    """A direction; None = what follows from other fields."""

    accepts, file_type = "str | array_like | None", FILE_DIRECTION
    convert = staticmethod(as_direction)


class Orientation(Stored[ArrayLike, np.ndarray]):
    """A unit quaternion, scalar first, or a rotation matrix; kept as a quaternion."""

    accepts, file_type = "array_like", FILE_ROWS
    convert = staticmethod(as_orientation)


class Inertia(Stored[ArrayLike, np.ndarray]):
    """(3,) or (3, 3) inertia about the centre of mass [kg m^2], after the mass; kept as a matrix."""

    accepts, file_type = "array_like", FILE_ROWS
    convert = staticmethod(as_inertia)


class Array(Stored[ArrayLike, np.ndarray]):
    """Numbers of a shape that its part checks."""

    accepts = "array_like"


class Number(Stored[float, float]):
    """A finite number in a range: ``minimum=``, or ``positive=True``."""

    accepts, file_type = "float", float
    convert = staticmethod(as_number)


class NumberOrNone(Stored[float | None, float | None]):
    """A number, or None."""

    accepts, file_type = "float | None", float | None
    convert = staticmethod(or_none(as_number))


class NumberOrDerived(Stored[float | None, float]):
    """A number; None = what follows from other fields."""

    accepts, file_type = "float | None", float | None
    convert = staticmethod(as_number)


class Numbers(Stored[Sequence[float], tuple[float, ...]]):
    """Finite numbers."""

    accepts, file_type = "Sequence[float]", list[float]
    convert = staticmethod(as_numbers)


class NumbersOrDerived(Stored[Sequence[float] | None, tuple[float, ...]]):
    """Finite numbers; None = what follows from other fields."""

    accepts, file_type = "Sequence[float] | None", list[float]
    convert = staticmethod(as_numbers)


class Members(Stored[Iterable[P], tuple[P, ...]], Generic[P]):
    """Parts of one kind, in their order."""

    accepts = "Sequence"
    convert = staticmethod(as_members)
