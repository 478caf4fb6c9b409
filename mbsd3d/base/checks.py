"""Checks of input: errors name the value and the remedy."""

import sys
from collections.abc import Hashable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .errors import CONTROL_CHARACTERS, InputError, MbsError

MAGNITUDE_MAX, MAGNITUDE_MIN = 1e60, 1e-60  # [SI units] numbers whose squares and ratios are finite
PYTHON_LOOP_MAX = 16  # [numbers] that Python looks through in less time than numpy
PLAIN_NUMBER_TYPES = frozenset((float, int, np.float64))  # need no closer look than at their size


def short_repr(value: Any) -> str:
    """Return what was given as it prints, cut where it is long; numbers of arrays as plain ones."""
    try:
        with np.printoptions(legacy="1.25"):
            text = repr(value)
    except ValueError:  # Python prints no whole number of more than 4300 digits
        return f"a {type(value).__name__} of many digits"
    return text if len(text) <= 80 else f"{text[:60]} ... ({len(text)} characters)"


def check_name(name: Any, what: str) -> None:
    """Refuse a name that is not a text, is empty, would command a terminal, or reads as something else than it is."""
    if not isinstance(name, str) or not name:
        raise InputError(f"{what} name {short_repr(name)}: give a non-empty text")
    if CONTROL_CHARACTERS.search(name):
        raise InputError(f"{what} name {short_repr(name)} holds control characters; give a text of one line")


def all_within(array: np.ndarray, most: float) -> bool:
    """Return whether all numbers lie within -most ... most; one that is not finite does not."""
    if array.size <= PYTHON_LOOP_MAX:
        return all(-most <= x <= most for x in array.ravel().tolist())
    return bool((np.abs(array) <= most).all())


def holds_truth(values: Any) -> bool:
    """Return whether a value is True or False, or a list or array of some; numpy and float() make them 1 and 0."""
    if isinstance(values, list | tuple):
        return any(map(holds_truth, values))
    return isinstance(values, bool | np.bool_) or (isinstance(values, np.ndarray) and values.dtype.kind == "b")


def floats(values: Any, what: str, remedy: str) -> np.ndarray:
    """Return a new array of finite floats; refuse texts, True and False with an error that names ``what``."""
    if type(values) is np.ndarray and values.dtype == np.float64 and all_within(values, sys.float_info.max):
        return values.copy()
    try:
        raw = np.asarray(values)
        array = raw.astype(float) if raw.dtype.kind in "fiuO" else None
    except (TypeError, ValueError, OverflowError):
        array = None
    texts = array is not None and raw.dtype.kind == "O" and any(isinstance(x, str | bytes | None) for x in raw.flat)
    if array is None or texts or holds_truth(values):
        raise InputError(f"{what}: {short_repr(values)} is not numeric; give {remedy}")
    if not all_within(array, sys.float_info.max):
        text = np.array2string(array, separator=", ", precision=9, threshold=20).replace("\n", "")
        place = f" in entry {np.flatnonzero(~np.isfinite(array))[0]}" if array.size > 4 else ""
        raise InputError(f"{what}: {text} is not finite{place}; give {remedy}")
    return array


def numbers(values: Any, what: str) -> np.ndarray:
    """Return a float array of anything numeric, also of what is not finite; an InputError names ``what``."""
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what}: {short_repr(values)} is not numeric; give numbers") from None


def check_choice(value: Any, choices: Sequence[Any], what: str) -> None:
    """Refuse anything but one of the choices."""
    if (type(value) is not str and not isinstance(value, Hashable)) or value not in choices:
        raise InputError(f"{what} {short_repr(value)} is unknown; give {' or '.join(map(repr, choices))}")


def as_tuple(values: Any, what: str, remedy: str) -> tuple[Any, ...]:
    """Return the members of a sequence as a tuple, or raise an InputError that names ``what``."""
    try:
        return tuple(values)
    except TypeError:
        raise InputError(f"{what}: {short_repr(values)} is not a sequence; give {remedy}") from None


def check_size(array: np.ndarray, what: str) -> None:
    """Refuse numbers whose squares and ratios are beyond what a float holds."""
    if not all_within(array, MAGNITUDE_MAX):
        raise InputError(
            f"{what}: {np.abs(array).max():.3g} is beyond the largest magnitude {MAGNITUDE_MAX:.0e}; check the units"
        )


def plain_three(value: Any) -> np.ndarray | None:
    """Return a new (3,) array of three plain numbers of usual size, or None for whatever needs a closer look."""
    if type(value) is np.ndarray and value.dtype == np.float64:
        value = value.tolist() if value.shape == (3,) else ()
    if type(value) not in (tuple, list) or len(value) != 3:
        return None
    x, y, z = value
    if not (type(x) in PLAIN_NUMBER_TYPES and type(y) in PLAIN_NUMBER_TYPES and type(z) in PLAIN_NUMBER_TYPES):
        return None
    usual = (
        -MAGNITUDE_MAX <= x <= MAGNITUDE_MAX
        and -MAGNITUDE_MAX <= y <= MAGNITUDE_MAX
        and -MAGNITUDE_MAX <= z <= MAGNITUDE_MAX
    )
    return np.array((x, y, z), float) if usual else None


def vector(value: ArrayLike, what: str) -> np.ndarray:
    """Return a finite (3,) float array, or raise a ValueError that names ``what``."""
    array = plain_three(value)
    if array is None:
        array = floats(value, what, "three numbers")
        if array.shape != (3,):
            raise InputError(f"{what}: expected three numbers, got {short_repr(value)}")
        check_size(array, what)
    array.setflags(write=False)
    return array


def number(value: Any, what: str, *, minimum: float | None = None, positive: bool = False) -> float:
    """Return a finite float within its range, or raise a ValueError that names ``what``."""
    if type(value) in PLAIN_NUMBER_TYPES and -MAGNITUDE_MAX <= value <= MAGNITUDE_MAX:
        if not (positive and value < MAGNITUDE_MIN) and (minimum is None or value >= minimum):
            return float(value)
    try:
        x = None if isinstance(value, str | bytes) or holds_truth(value) else float(value)
    except (TypeError, ValueError, OverflowError):
        x = None
    if x is None:
        raise InputError(f"{what}: expected a number, got {short_repr(value)}")
    if not np.isfinite(x):
        raise InputError(f"{what}: not finite ({x}); give a finite number")
    if positive and x <= 0.0:
        raise InputError(f"{what}: {x} is not positive; give a number > 0")
    if minimum is not None and x < minimum:
        raise InputError(f"{what}: {x} is below {minimum}; give a number >= {minimum}")
    if abs(x) > MAGNITUDE_MAX or (positive and x < MAGNITUDE_MIN):
        raise InputError(
            f"{what}: {x} is outside the magnitudes {MAGNITUDE_MIN:.0e} ... {MAGNITUDE_MAX:.0e}; check the units"
        )
    return x


def whole(value: int, what: str, least: int, most: float = np.inf) -> int:
    """Return a whole number within its range, or raise a ValueError that names ``what``."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or not least <= value <= most:
        wanted = f">= {least}" if most == np.inf else f"from {least} to {most}"
        raise InputError(f"{what} = {short_repr(value)}; give a whole number {wanted}")
    return int(value)


def sequence(values: Any, what: str) -> tuple[float, ...]:
    """Return finite numbers as a tuple, or raise a ValueError that names ``what``."""
    if isinstance(values, str | bytes):
        raise InputError(f"{what}: {short_repr(values)} is not a sequence of numbers; give a tuple")
    try:
        given = tuple(values)
    except TypeError:
        raise InputError(f"{what}: {short_repr(values)} is not a sequence of numbers; give a tuple") from None
    return tuple(number(value, f"{what} no. {k + 1}") for k, value in enumerate(given))


@contextmanager
def reporting_linalg_errors(what: str) -> Iterator[None]:
    """Turn what the linear algebra inside cannot solve into an error of this package."""
    try:
        yield
    except (np.linalg.LinAlgError, OverflowError) as error:
        raise MbsError(
            f"{what}: {error}",
            advice="masses, inertias, lengths or stiffnesses differ by too many orders of magnitude; check the units",
        ) from error
