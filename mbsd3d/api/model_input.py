"""Models for the commands: model files, models of other programs, Python files with ``build(NAME=VALUE, ...)``."""

import inspect
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from traceback import walk_tb
from types import ModuleType
from typing import Any, NamedTuple, cast

import numpy as np

from ..base.errors import InputError, similar
from ..files.importing.imported import Imported
from ..mechanism.state import State
from .load import read_mjcf, read_sdf, read_urdf
from .system import System


class Loaded(NamedTuple):
    """A System, lines on its import, and the states of its key frames."""

    system: System
    notes: tuple[str, ...] = ()
    states: Mapping[str, State] = {}  # noqa: RUF012 - nobody writes into it


READERS: Mapping[str, Callable[..., Imported]] = {
    ".xml": read_mjcf, ".mjcf": read_mjcf, ".urdf": read_urdf, ".xacro": read_urdf, ".sdf": read_sdf,
}  # fmt: skip
"""Suffix of a model of another program -> its reader."""
WITH_ROOT = (".urdf", ".xacro", ".sdf")
"""Those whose files leave open whether the model floats."""


def load_model(
    file: str,
    drop: tuple[str, ...],
    settings: tuple[str, ...],
    *,
    inputs: bool = False,
    floating: bool | None = None,
    limits: str | None = None,
    package_paths: Sequence[str] = (),
) -> Loaded:
    """Return the System of a model file, an imported model or ``build()`` of a Python file, and notes on an import.

    ``drop``: kinds to leave out, or several with commas between them. ``settings`` are texts NAME=VALUE, the parameters
    of ``build()``. ``inputs``, ``floating``, ``limits``, ``package_paths``: see `read_urdf`. ValueError naming the file
    and the place in it.
    """
    suffix = Path(file).suffix.lower()
    if settings and suffix != ".py":
        raise InputError(f"--set is for Python files with build(...), '{file}' is none; leave it out")
    if floating is not None and suffix not in WITH_ROOT:
        option = "--floating" if floating else "--fixed"
        raise InputError(f"{option} applies to robots ({', '.join(WITH_ROOT)}) only; drop it for '{file}'")
    if suffix in READERS:
        if inputs and suffix == ".sdf":
            raise InputError(f"--input takes motors of .xml and .urdf, '{file}' has none; leave it out")
        given: dict[str, Any] = {"floating": floating} if suffix in WITH_ROOT else {}
        given |= {"inputs": True} if inputs else {}
        given |= {"limits": limits} if limits else {}
        return imported(file, suffix, drop, package_paths=tuple(package_paths), **given)
    if drop or package_paths or limits:
        option = "--leave-out" if drop else "--package-path" if package_paths else "--limits"
        kinds = ", ".join(READERS)
        raise InputError(f"{option} applies to imported models ({kinds}) only; drop it for '{file}'")
    if suffix in (".json", ".toml"):
        return Loaded(System.from_file(file))
    if suffix != ".py":
        kinds = ", ".join((".json", ".toml", *READERS))
        raise InputError(f"'{file}': give a model ({kinds}) or a Python file (.py) with build()")
    return Loaded(built_by(file, settings))


def imported(file: str, suffix: str, drop: tuple[str, ...], **given: Any) -> Loaded:
    """Return the System of a model of another program: a line on it, and what was left out, merged and renamed."""
    kinds = [kind for text in drop for kind in text.split(",") if kind]
    with warnings.catch_warnings(action="ignore"):  # the first line says it
        try:
            found = READERS[suffix](file, leave_out=kinds, **given)
        except InputError as error:
            raise InputError(in_options(str(error))) from error
    lines = [in_options(str(found))] + [f"left out {part}" for part in found.dropped]
    lines += [f"body '{name}' is part of '{whole}'" for name, whole in found.merged.items()]
    lines += [f"'{name}' was '{before}' in the file" for name, before in found.renamed.items()]
    return Loaded(cast(System, found.system), tuple(lines), found.states)


OPTIONS = (
    ("floating=True", "--floating"), ("floating=False", "--fixed"), ("package_paths", "--package-path"),
    ("raise timeout", "read it in Python with a longer timeout="),
)  # fmt: skip
"""What messages of the readers call an argument, and the option of the commands."""


def in_options(message: str) -> str:
    """Return a message of an import in the syntax of the command line: leave_out=["fluid"] -> --leave-out fluid."""
    kinds = re.compile(r"leave out with leave_out=\[(.*?)\]")
    message = kinds.sub(lambda found: "give --leave-out " + re.sub(r"[\" ]", "", found[1]), message)
    for argument, option in OPTIONS:
        message = message.replace(argument, option)
    return message


def write_as(system: System, target: str, omit: Sequence[str], massless: bool, replace: bool) -> str:
    """Write a system in the format of the suffix of a file; return a line on it."""
    suffix = Path(target).suffix.lower()
    if massless and suffix not in (".urdf", ".sdf"):
        raise InputError(f"--massless is for .urdf and .sdf; leave it out for '{target}'")
    if omit and suffix in (".toml", ".json"):
        raise InputError(f"--omit is for formats of other programs; leave it out for '{target}'")
    try:
        match suffix:
            case ".toml" | ".json":
                return f"'{system.to_file(target, replace=replace)}'"
            case ".xml" | ".mjcf":
                return str(system.to_mjcf(target, leave_out=omit, replace=replace))
            case ".urdf":
                return str(system.to_urdf(target, massless=massless, leave_out=omit, replace=replace))
            case ".sdf":
                return str(system.to_sdf(target, massless=massless, leave_out=omit, replace=replace))
    except InputError as error:
        raise InputError(omitted(str(error))) from error
    raise InputError(f"--to {target}: the name ends in no format; give .toml, .json, .xml, .urdf or .sdf")


def omitted(message: str) -> str:
    """Return an error of an export in the syntax of the command line: leave_out=["roll"] -> --omit roll."""
    names = re.compile(r"leave (?:it )?out with leave_out=\[(.*?)\]")
    given = names.sub(lambda found: "give " + re.sub(r'"(.*?)",?', r"--omit '\1'", found[1]), message)
    return given.replace("massless=True", "--massless").replace("replace=True", "--replace")


def parameters_of(file: str) -> list[str]:
    """Return a line per parameter of ``build()`` of a Python file."""
    if Path(file).suffix.lower() != ".py":
        raise InputError(f"'{file}' is not a Python file, only build(...) of one has parameters")
    with builder(file) as build:
        return parameter_lines(build)


def built_by(file: str, settings: tuple[str, ...]) -> System:
    """Return the System that ``build()`` of a Python file returns for parameters NAME=VALUE.

    ValueError naming file and line: a missing file, no Python, an error while it runs, no ``build()``, no System.
    """
    with builder(file) as build:
        given = given_parameters(build, settings, file)
        system = guarded(file, lambda: build(**given))
    if not isinstance(system, System):
        raise InputError(f"'{file}': build() returned {type(system).__name__}, not a System; let it return a System")
    return system


@contextmanager
def builder(file: str) -> Iterator[Callable[..., Any]]:
    """Load ``build`` of a Python file; modules beside the file can be imported inside."""
    with loaded(file) as module:
        yield module.build


@contextmanager
def loaded(file: str) -> Iterator[Any]:
    """Load a Python file with ``build``; modules beside the file can be imported inside."""
    path = Path(file)
    try:
        source = path.read_bytes()
    except OSError as error:
        raise InputError(f"'{file}': {error.strerror}; give a Python file with build()") from error
    module = ModuleType(f"model {path.stem}")
    module.__file__ = str(path)
    with importable(module, path.parent):
        guarded(file, lambda: exec(compile(source, str(path), "exec"), module.__dict__))
        if not callable(getattr(module, "build", None)):
            raise InputError(f"'{file}' has no function build(); define build() and let it return a System")
        yield module


@contextmanager
def importable(module: Any, folder: Path) -> Iterator[None]:
    """Make the module known to Python inside the block (dataclasses ask for it) and search its folder for imports."""
    place = str(folder.resolve())
    sys.modules[module.__name__] = module
    sys.path.insert(0, place)
    try:
        yield
    finally:
        sys.path.remove(place)
        del sys.modules[module.__name__]


def guarded(file: str, function: Callable[[], Any]) -> Any:
    """Call the user's code; its errors become a ValueError with file and line."""
    try:
        return function()
    except SyntaxError as error:
        raise InputError(f"'{error.filename or file}', line {error.lineno}: {error.msg}; correct the file") from error
    except (Exception, SystemExit) as error:
        lines = [line for frame, line in walk_tb(error.__traceback__) if frame.f_code.co_filename == str(Path(file))]
        where = f", line {lines[-1]}" if lines else ""
        kind = "" if isinstance(error, ValueError) else f"{type(error).__name__}: "
        raise InputError(f"'{file}'{where}: {kind}{error}") from error


TRUTH_WORDS = {"true": True, "yes": True, "on": True, "false": False, "no": False, "off": False}


def parameter_lines(build: Callable[..., Any]) -> list[str]:
    """Return one line per parameter: name, type and default."""
    found = []
    for name, x in parameters(build).items():
        kind = kind_of(x)
        default = "required" if x.default is x.empty else f"default {x.default!r}"
        found.append(f"{name}: {kind.__name__ if kind else 'number or text'}, {default}")
    return found


def given_parameters(build: Callable[..., Any], settings: Sequence[str], file: str) -> Mapping[str, Any]:
    """Name -> value of texts NAME=VALUE; ValueError listing the valid names."""
    known = parameters(build)
    found = given_texts(build, settings, file)
    return {name: typed(value, kind_of(known[name]), f"--set {name}") for name, value in found.items()}


def given_values(build: Callable[..., Any], settings: Sequence[str], file: str) -> Mapping[str, list[Any]]:
    """Name -> values of texts NAME=FROM:TO:COUNT, NAME=1,2,5 or NAME=3; ValueError naming those there are."""
    known = parameters(build)
    found = given_texts(build, settings, file)
    return {name: values_of(text, kind_of(known[name]), f"--set {name}") for name, text in found.items()}


def given_texts(build: Callable[..., Any], settings: Sequence[str], file: str) -> dict[str, str]:
    """Name -> text of texts NAME=TEXT, each a parameter of ``build()``; those without a default must be there."""
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
        found[name] = value
    missing = [name for name, x in known.items() if x.default is x.empty and name not in found]
    if missing:
        have = "; ".join(parameter_lines(build))
        raise InputError(
            f"'{file}': build() needs {', '.join(missing)}; give --set {missing[0]}=VALUE. It takes {have}"
        )
    return found


def values_of(text: str, kind: type | None, what: str) -> list[Any]:
    """Return the values of FROM:TO:COUNT, both ends among them, of a list with commas, or of a single value."""
    if ":" not in text or kind in (str, bool):
        return [typed(part, kind, what) for part in text.split(",")]
    try:
        low, high, count = text.split(":")
        values = np.linspace(float(low), float(high), int(count)).tolist()
    except ValueError:
        values = []
    if not values:
        raise InputError(f"{what}={text!r}: give FROM:TO:COUNT with a count of 1 or more, e.g. {what}=0.5:2:16")
    if kind is int and any(value != round(value) for value in values):
        raise InputError(f"{what}={text!r} is not whole everywhere; give a count that makes it so, or a list")
    return [int(value) for value in values] if kind is int else values


def parameters(build: Callable[..., Any]) -> dict[str, inspect.Parameter]:
    """Return what can be given by name; `*rest` and `**rest` have none."""
    known = inspect.signature(build).parameters.items()
    return {name: x for name, x in known if x.kind not in (x.VAR_POSITIONAL, x.VAR_KEYWORD)}


def kind_of(x: inspect.Parameter) -> type | None:
    """Return float, int, bool or str by annotation or default; None where neither says."""
    kinds: tuple[type, ...] = (float, int, bool, str)
    for kind in kinds:
        if x.annotation in (kind, kind.__name__):
            return kind
    return type(x.default) if type(x.default) in kinds else None


def typed(text: str, kind: type | None, what: str) -> Any:
    """Convert a text to a value of a type."""
    try:
        if kind is bool:
            return TRUTH_WORDS[text.lower()]
        if kind is not None:
            return kind(text)
    except (ValueError, KeyError):
        name = getattr(kind, "__name__", "")
        remedy = "true or false" if kind is bool else f"{'an' if kind is int else 'a'} {name}"
        raise InputError(f"{what}={text!r} is not {remedy}; correct it") from None
    for attempt in (int, float):
        try:
            return attempt(text)
        except ValueError:
            continue
    return text
