"""Parameters of ``build(...)`` of a model file, given as texts: NAME=VALUE, typed by annotation or default."""

import inspect
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..base.errors import InputError, similar

WORDS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}


def parameter_lines(build: Callable[..., Any]) -> list[str]:
    """One line per parameter: name, type and default."""
    found = []
    for name, x in parameters(build).items():
        kind = kind_of(x)
        default = "required" if x.default is x.empty else f"default {x.default!r}"
        found.append(f"{name}: {kind.__name__ if kind else 'number or text'}, {default}")
    return found


def given_parameters(build: Callable[..., Any], settings: Sequence[str], file: str) -> Mapping[str, Any]:
    """Name -> value of texts NAME=VALUE; ValueError naming those there are."""
    known, found = parameters(build), {}
    for text in settings:
        name, equals, value = text.partition("=")
        if not equals or not name:
            raise InputError(f"--set {text!r}: give NAME=VALUE, e.g. --set length=0.5")
        if name in found:
            raise InputError(f"--set {name} is given twice; give it once")
        if name not in known:
            near = similar(name, known)
            hint = f", did you mean '{near[0]}'?" if near else ";"
            have = "; ".join(parameter_lines(build)) or "none"
            raise InputError(f"--set {name}: '{file}' has no such parameter{hint} build() takes {have}")
        found[name] = typed(value, kind_of(known[name]), f"--set {name}")
    missing = [name for name, x in known.items() if x.default is x.empty and name not in found]
    if missing:
        have = "; ".join(parameter_lines(build))
        raise InputError(
            f"'{file}': build() needs {', '.join(missing)}; give --set {missing[0]}=VALUE. It takes {have}"
        )
    return found


def parameters(build: Callable[..., Any]) -> dict[str, inspect.Parameter]:
    """What can be given by name; `*rest` and `**rest` have none."""
    known = inspect.signature(build).parameters.items()
    return {name: x for name, x in known if x.kind not in (x.VAR_POSITIONAL, x.VAR_KEYWORD)}


def kind_of(x: inspect.Parameter) -> type | None:
    """float, int, bool or str by annotation or default; None = not said."""
    names = {"float": float, "int": int, "bool": bool, "str": str}
    annotation = names.get(x.annotation, x.annotation) if isinstance(x.annotation, str) else x.annotation
    if annotation in names.values():
        return annotation
    return type(x.default) if type(x.default) in names.values() else None


def typed(text: str, kind: type | None, what: str) -> Any:
    """A text as a value of a type."""
    try:
        if kind is bool:
            return WORDS[text.lower()]
        if kind is not None:
            return kind(text)
    except (ValueError, KeyError):
        remedy = "true or false" if kind is bool else f"{'an' if kind is int else 'a'} {kind.__name__}"
        raise InputError(f"{what}={text!r} is not {remedy}; correct it") from None
    for attempt in (int, float):
        try:
            return attempt(text)
        except ValueError:
            continue
    return text
