"""Parameters of a demo as a user gives them: existing names, values of the kind of the defaults."""

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from ..base.checks import number, short_repr
from ..base.errors import InputError, MbsError, similar

OMITTABLE_TERMS = ("gyroscopic", "centripetal", "gamma")  # terms that runs can leave out
LISTED_NAMES_MAX = 20  # [1] names that are listed beside a guess
VALUE_RATIO_MAX = 1000.0  # [1] from the default; run time and validity of formulas are known for machines of some size
# [1] below the default, for a value that may vanish: then the effect goes, and the run does not change
VANISHING_RATIO_MAX = 1e12

Values = Mapping[str, Any]
"""Values of parameters by name, as JSON has them; of which kind, says the default."""


def listed(name: str, names: Sequence[str]) -> str:
    """Return a hint for an unknown name: the nearest names, and all if they are few."""
    inside = [known for known in names if len(name) > 2 and name.lower() in known.lower()]
    guess = list(dict.fromkeys(similar(name, names) + inside))[:3]
    there = f"there are {', '.join(names)}" if len(names) <= LISTED_NAMES_MAX else "see the whole list: mbsd3d demo"
    if guess:
        return f"did you mean {' or '.join(guess)}?" + (f" ({there})" if len(names) <= LISTED_NAMES_MAX else "")
    return there


def lacking(term: str) -> str:
    """Return the label of an ablation."""
    return f"no {term} term" if term in OMITTABLE_TERMS else f"without {term.replace('_', ' ').replace('-', ' ')}"


def settings(texts: Iterable[str]) -> dict[str, object]:
    """Read ``NAME=VALUE`` with values in JSON; a bare word is taken as it is."""
    found = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not (name and equals and value):
            raise InputError(f"--set {text!r} is not NAME=VALUE; write e.g. --set Omega=30")
        if name in found:
            raise InputError(f"--set {name} is given twice; give it once")
        try:
            found[name] = json.loads(value)
        except ValueError:
            if not value.isidentifier():
                raise InputError(
                    f"--set {name}: {value!r} is not JSON; write e.g. {name}=1.5 or {name}=[1,2]"
                ) from None
            found[name] = value
    return found


def checked(demo: str, defaults: Values, changes: Values, vanishing: Iterable[str] = ()) -> dict[str, Any]:
    """Return the parameters of a demo with some changed; raise ValueError that names demo, parameter and remedy.

    Those that are ``vanishing`` may be as small as one likes.
    """
    values = dict(defaults)
    for name, value in changes.items():
        if name not in defaults:
            raise InputError(f"demo '{demo}' has no parameter '{name}'; {listed(name, list(defaults))}")
        below = VANISHING_RATIO_MAX if name in vanishing else VALUE_RATIO_MAX
        values[name] = like(defaults[name], value, f"demo '{demo}': {name}", below)
    return values


def like(default: Any, value: Any, what: str, below: float = VALUE_RATIO_MAX) -> Any:
    """Return a value of the kind of the default: number, integer, word, list of the same shape, or table of these.

    A number is by less than a factor FAR above the default and by less than ``below`` below it, or 0.
    """
    if isinstance(default, str):
        if not isinstance(value, str):
            raise InputError(f"{what} = {value!r} is not a word; give e.g. {default!r}")
        return value
    if isinstance(default, Mapping):
        if not isinstance(value, Mapping):
            raise InputError(f"{what} = {value!r} is not a table; give e.g. {json.dumps(default)}")
        for key in value:
            if key not in default:
                raise InputError(f"{what} has no entry '{key}'; {listed(key, list(default))}")
        return {**default, **{key: like(default[key], item, f"{what}.{key}") for key, item in value.items()}}
    if isinstance(default, list | tuple):
        return like_list(default, value, what)
    if isinstance(value, str | bool):
        raise InputError(f"{what} = {value!r} is not a number; give e.g. {default}")
    found = number(value, what)
    times = abs(found / default) if default and found else 1.0
    far = VALUE_RATIO_MAX if times > 1.0 else below
    if not 1.0 / far < times < far:
        raise InputError(f"{what} = {value!r} is a factor of {far:g} or more away from {default:g}; stay nearer to it")
    if isinstance(default, int):
        if found != int(found):
            raise InputError(f"{what} = {value!r} is not a whole number; give e.g. {default}")
        return int(found)
    return found


def like_list(default: Sequence, value: object, what: str) -> list:
    """Return numbers in the shape of the default."""
    shape = np.shape(default)
    try:
        found = np.asarray(value)
    except ValueError:  # lists of several lengths
        found = np.asarray(None)
    if found.dtype.kind not in "iuf" or found.shape != shape or not np.isfinite(found).all():
        size = " x ".join(map(str, shape))
        raise InputError(f"{what} = {value!r}: give {size} finite numbers, e.g. {json.dumps(default)}")
    if np.abs(found).max() >= VALUE_RATIO_MAX * (np.abs(default).max() or 1.0):
        raise InputError(
            f"{what} = {value!r} is {VALUE_RATIO_MAX:g} times {json.dumps(default)} or more; stay nearer to it"
        )
    return found.astype(float).tolist()


@contextmanager
def refusing(demo: str, defaults: Values, values: Values) -> Iterator[None]:
    """Raise an error that names the parameters other than the defaults if a demo fails or has no finite numbers, within
    the block.
    """
    try:
        with np.errstate(divide="raise", over="raise", invalid="raise"):
            yield
    except (ArithmeticError, ValueError) as error:
        changed = {name: value for name, value in values.items() if value != defaults[name]}
        text, own = str(error), f"demo '{demo}': "
        named = text.startswith(f"demo '{demo}'") and any(f"{name} = " in text for name in changed)
        if not changed or (isinstance(error, InputError) and named):
            raise
        given = f"demo '{demo}' with " + ", ".join(f"{name} = {short_repr(value)}" for name, value in changed.items())
        if isinstance(error, InputError):
            raise InputError(f"{given}: {text.removeprefix(own)}") from error
        why = error if isinstance(error, MbsError) else "its equations have no finite solution"
        raise InputError(f"{given} does not run: {why}; stay nearer to the defaults") from error
