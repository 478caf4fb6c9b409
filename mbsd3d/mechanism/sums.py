"""Weighted sums of angles and slides of joints."""

from collections.abc import Sequence
from typing import Any

from ..base.checks import as_tuple, check_choice, short_repr
from ..base.errors import InputError
from ..base.fields import Stored, as_numbers, or_none
from ..base.wording import counted
from .joints import Joint, coordinate_of
from .primitives import Coordinate


def as_joints(value: Any, what: str, part: Any) -> tuple[Joint, ...]:
    """Convert a joint, or a sequence of joints, to a tuple."""
    return (value,) if isinstance(value, Joint) else as_tuple(value, what, "a joint or a list of joints")


class Joints(Stored[Joint | Sequence[Joint], tuple[Joint, ...]]):
    """Joints; a single one needs no sequence."""

    accepts, role, file_type = "Joint | Sequence[Joint]", "joint", str | dict[str, Any] | list[str | dict[str, Any]]
    convert = staticmethod(as_joints)


def as_kinds(value: Any, what: str, part: Any) -> tuple[str | None, ...]:
    """Convert "angle", "slide" or None, or one of them for each joint, to a tuple."""
    kinds_given = (value,) if isinstance(value, str) else as_tuple(value, what, "one of 'angle' and 'slide' a joint")
    for kind in kinds_given:
        check_choice(kind, ("angle", "slide", None), what)
    return kinds_given


class KindsOrNone(Stored[str | Sequence[str | None] | None, tuple[str | None, ...] | None]):
    """Coordinate of each joint, or None."""

    accepts, file_type = "str | Sequence[str] | None", str | list[str | None] | None
    convert = staticmethod(or_none(as_kinds))


class NumbersOrOnes(Stored[Sequence[float] | None, tuple[float, ...] | None]):
    """Finite numbers, or None for ones."""

    accepts, file_type = "Sequence[float] | None", list[float] | None
    convert = staticmethod(or_none(as_numbers))


def places_of(
    joints: tuple[Joint, ...],
    weights: tuple[float, ...] | None,
    kinds: tuple[str | None, ...] | None,
    side: str,
    what: str,
) -> list[tuple[Joint, str]]:
    """Return (joint, "angle" or "slide") of each coordinate, or raise an InputError that names the side of a part."""
    if weights is not None and (len(weights) != len(joints) or 0.0 in weights):
        given = f"{what}: weights of {side} = {short_repr(weights)} for {counted(len(joints), 'joint')}"
        raise InputError(f"{given}; give one per joint, none of them 0")
    if kinds is not None and len(kinds) not in (1, len(joints)):
        raise InputError(
            f"{what}: {counted(len(kinds), 'coordinate')} for {counted(len(joints), 'joint')} of {side}; "
            "give one, or one per joint"
        )
    found = []
    for k, joint in enumerate(joints):
        kind = kinds[k if len(kinds) > 1 else 0] if kinds else None
        kind = kind or ("angle" if isinstance(joint, Joint) and joint.angle() is not None else "slide")
        coordinate_of(joint, kind, f"{what}: {side}")
        found.append((joint, kind))
    return found


def weighted(
    joints: tuple[Joint, ...], weights: tuple[float, ...] | None, kinds: tuple[str | None, ...] | None
) -> list[tuple[Coordinate, float]]:
    """Return the coordinates of a sum that was checked, with their weights."""
    coordinates = [coordinate_of(joint, kind, "") for joint, kind in places_of(joints, weights, kinds, "", "")]
    return list(zip(coordinates, weights or (1.0,) * len(joints), strict=True))
