"""Model files: the description of a system as JSON or TOML that people read and edit.

A file is text from anywhere: its size, encoding and nesting are limited before anything is made of it.
"""

import json
import re
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import tomlkit

from ..base.errors import InputError
from ..base.paths import as_path, read_text, write_atomically
from ..mechanism.mechanism import Mechanism
from .description import check_count, describe, read_system

TOML_NONE = {"type": "None"}  # TOML has no null
TOML_NESTING_MAX = 32  # [levels] of a dotted key in TOML; the parser's time grows with the square of it
# A key with its dots, possessive, so that the time is linear; a quote without end goes to the end of its line.
TOML_KEY = r"""(?>[\w-]++|"(?:[^"\\\n]|\\.)*+"?|'[^'\n]*+'?)"""
TOML_DOTTED_KEY = re.compile(rf"{TOML_KEY}(?>[ \t]*+\.[ \t]*+{TOML_KEY})*+")


def to_json(data: dict[str, Any]) -> str:
    """JSON with one part per line."""
    lines = []
    for key, value in data.items():
        if isinstance(value, list) and value and isinstance(value[0], dict):
            text = "[\n" + ",\n".join(f"    {json.dumps(part, ensure_ascii=False)}" for part in value) + "\n  ]"
        else:
            text = json.dumps(value, ensure_ascii=False)
        lines.append(f"  {json.dumps(key)}: {text}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """The dict of an object in JSON; a ValueError for a key that it has twice."""
    found: dict[str, Any] = {}
    for key, value in pairs:
        if key in found:
            raise InputError(f"key '{key}' appears twice in one object (value {str(value)[:40]}); keep one")
        found[key] = value
    return found


def to_toml(data: dict[str, Any]) -> str:
    """TOML with a table per part."""
    return tomlkit.dumps({key: exchanged(value, None, TOML_NONE) for key, value in data.items()})


def from_toml(text: str) -> Any:
    """The data of a TOML text."""
    if '"""' in text or "'''" in text:
        raise InputError("texts of several lines are not used in model files; write each text in one line")
    for key in TOML_DOTTED_KEY.finditer(text):
        if key[0].count(".") > TOML_NESTING_MAX:
            line = text.count("\n", 0, key.start()) + 1
            raise InputError(
                f"line {line} has more than {TOML_NESTING_MAX} dots in one name; a model nests a few levels only"
            )
    return exchanged(tomllib.loads(text), TOML_NONE, None)


def exchanged(value: Any, old: Any, new: Any) -> Any:
    """The value with ``new`` wherever ``old`` stands."""
    if value == old and type(value) is type(old):
        return new
    if isinstance(value, dict):
        return {key: exchanged(item, old, new) for key, item in value.items()}
    return [exchanged(item, old, new) for item in value] if isinstance(value, list) else value


class Form(NamedTuple):
    """A kind of file: how it is written and read, and how large it may be [bytes] to be read within seconds."""

    write: Callable[[dict[str, Any]], str]
    read: Callable[[str], Any]
    limit: int


FILE_FORMATS = {
    ".json": Form(to_json, partial(json.loads, object_pairs_hook=unique), 16_000_000),
    ".toml": Form(to_toml, from_toml, 1_000_000),
}


def form_of(path: Path) -> Form:
    """Form of a file by its suffix."""
    if path.suffix.lower() not in FILE_FORMATS:
        raise InputError(f"'{path}': a model file ends in {' or '.join(FORMS)}; give such a name")
    return FILE_FORMATS[path.suffix.lower()]


def write_model(system: Mechanism, path: str | Path, *, replace: bool) -> Path:
    """Write a model file; see `System.to_file`."""
    path = as_path(path, "model.json")
    form = form_of(path)
    data = describe(system)
    check_count(data)
    text = form.write(data)
    try:
        content = text.encode()
    except UnicodeEncodeError as error:
        raise InputError(f"'{path}': {text[error.start]!r} in a name cannot be written; rename the part") from error
    if len(content) > form.limit:
        raise InputError(f"'{path}': the model has {len(content)} bytes, {form.limit} can be read; shorten its tables")
    with naming_file(path):
        again = form.read(text)
    if again != data:
        raise InputError(f"'{path}': {path.suffix} cannot hold this model without loss; use the other format")
    return write_atomically(path, content, replace=replace)


@contextmanager
def naming_file(path: Path) -> Iterator[None]:
    """Errors inside name the file."""
    try:
        yield
    except RecursionError:
        raise InputError(f"'{path}' is nested too deep; a model nests a few levels only") from None
    except ValueError as error:
        raise InputError(f"'{path}': {error}") from error


def read_model(path: str | Path) -> Mechanism:
    """Read a model file; see `System.from_file`."""
    path = as_path(path, "model.json")
    form = form_of(path)
    text = read_text(path, form.limit)
    with naming_file(path):
        return read_system(form.read(text))[0]
