"""A compiled function as bytes and back: object code, and what is said about it in JSON.

numba would pickle it, and what is unpickled can call anything. Here texts name types, out of a few, and functions and
classes of modules that are there already.
"""

import json
import sys
from collections.abc import Callable
from functools import cache
from operator import attrgetter
from typing import Any

from numba import types

from ..base.errors import InputError
from .arguments import Reference
from .numba_private import (
    CompileResult,
    Environment,
    PythonFunctionDescriptor,
    lookup_environment,
    object_code,
    signature_of,
    sigutils,
)

SIZE_BYTES = 8  # [bytes] of a number in front of each of three blocks
PLAIN_TYPES = {str(kind): kind for kind in (*types.number_domain, types.boolean, types.none)}


class FormError(InputError):
    """A function holds what cannot be written so, and is compiled at every start; or a file names what there is not."""


def packed(needed: list[tuple], made: CompileResult) -> bytes:
    """Return a compiled function and the kernels it needs, as (symbol, module, name, types), as bytes."""
    symbol, kind, (code, linked) = object_code(made)
    around = [made.environment, *made._find_referenced_environments()]
    known: dict[str, int] = {}  # text of a type -> its number: the same ones come again and again
    about = {
        "library": symbol,
        "symbol": made.fndesc.mangled_name,
        "unique": made.fndesc.unique_name,
        "inline": made.fndesc.inline,
        "environments": [(one.globals["__name__"], one.env_name) for one in around],
        "result": numbered(made.signature.return_type, known),
        "needed": [(*names, [numbered(one, known) for one in passed]) for *names, passed in needed],
    }
    special = made.objectmode, made.reload_init, made.signature.recvr, made.fndesc.kws, made.fndesc.noalias
    if kind != "object" or any(special) or any(one.consts for one in around):
        raise FormError(made.fndesc.qualname)
    text = json.dumps(about | {"types": list(known)}).encode()
    return b"".join(len(block).to_bytes(SIZE_BYTES, "little") + block for block in (text, code, linked))


def unpacked(content: bytes, function: Callable, signature: Any) -> tuple[list[tuple], tuple]:
    """Return what `packed` was given: the kernels needed, and the parts for ``CompileResult._rebuild``.

    LookupError, AttributeError, TypeError or ValueError for what names anything that is not there.
    """
    text, code, linked = blocks(content)
    about = json.loads(text)
    known = [restored(one) for one in about["types"]]
    passed, result = sigutils.normalize_signature(signature)[0], known[about["result"]]
    own, *around = (environment(*names) for names in about["environments"])
    names = function.__code__.co_varnames[: function.__code__.co_argcount]
    descriptor = PythonFunctionDescriptor(
        True, function.__module__, function.__qualname__, about["unique"], function.__doc__ or "", None, result, None,
        names, (), mangler=lambda *_, **__: about["symbol"], argtypes=tuple(passed), inline=about["inline"],
        env_name=own.env_name,
    )  # fmt: skip
    library = about["library"], "object", (code, linked)
    needed = [(*names, tuple(known[k] for k in given)) for *names, given in about["needed"]]
    return needed, (library, descriptor, own, signature_of(result, *passed), False, (), "", [], tuple(around))


def blocks(content: bytes) -> list[bytes]:
    """Return the blocks that stand one after the other."""
    found, place = [], 0
    while place < len(content):
        begin = place + SIZE_BYTES
        place = begin + int.from_bytes(content[place:begin], "little")
        found.append(content[begin:place])
    return found


def environment(module: str, name: str) -> Environment:
    """Return numba's environment of a compiled function, by its name: what the function's module holds.

    numba's own functions get none of theirs: no code reads them, and numba loads them only where it compiles.
    """
    found = lookup_environment(name)
    if found is None:
        found = Environment({"__name__": module} if module.startswith("numba.") else sys.modules[module].__dict__)
        found.env_name = name
        Environment._memo[name] = found
    return found


def numbered(kind: types.Type, known: dict[str, int]) -> int:
    """Return the number of a type among those that are known; FormError if its text does not lead back to it."""
    text = json.dumps(described(kind))
    if restored(text) != kind:
        raise FormError(str(kind))
    return known.setdefault(text, len(known))


def described(kind: types.Type) -> Any:
    """Return a type as a list of texts, numbers and lists; FormError if it is none that kernels take or return."""
    match kind:
        case types.Literal():
            return ["Literal", kind.literal_value]
        case types.Record():
            fields = [(name, described(one.type), one.offset, one.alignment) for name, one in kind.fields.items()]
            return ["Record", fields, kind.size, kind.aligned]
        case types.NestedArray():
            return ["NestedArray", described(kind.dtype), kind.shape]
        case types.Array():
            return ["Array", described(kind.dtype), kind.ndim, kind.layout, not kind.mutable, kind.aligned]
        case types.NamedTuple() | types.NamedUniTuple():
            cls = kind.instance_class
            return [type(kind).__name__, [described(one) for one in kind.types], cls.__module__, cls.__qualname__]
        case types.UniTuple() | types.Tuple():
            return ["Tuple", [described(one) for one in kind.types]]
        case Reference():
            return ["Reference", described(kind.fields)]
    if PLAIN_TYPES.get(str(kind)) != kind:
        raise FormError(str(kind))
    return [str(kind)]


def record(fields: list, size: int, aligned: bool) -> types.Record:
    """Return the type of a record."""
    return types.Record(
        [
            (name, {"type": type_of(kind), "offset": offset, "alignment": alignment})
            for name, kind, offset, alignment in fields
        ],
        size,
        aligned,
    )


def class_of(count: int, module: str, name: str) -> type:
    """Return the class of a named tuple of some fields, which a module that is there must hold."""
    cls = attrgetter(name)(sys.modules[module])
    if not (isinstance(cls, type) and issubclass(cls, tuple) and len(getattr(cls, "_fields", ())) == count):
        raise FormError(f"{module}.{name} is no named tuple of {count}")
    return cls


def reference(fields: list) -> Reference:
    """Return the type of a pointer to a named tuple; FormError for a pointer to anything else."""
    kind = type_of(fields)
    if not isinstance(kind, types.NamedTuple):
        raise FormError(f"{kind} is not passed by address")
    return Reference(kind)


TYPE_MAKERS: dict[str, Callable[..., types.Type]] = {
    "Literal": types.literal,
    "Record": record,
    "NestedArray": lambda kind, shape: types.NestedArray(type_of(kind), tuple(shape)),
    "Array": lambda kind, ndim, layout, readonly, aligned: types.Array(
        type_of(kind), ndim, layout, readonly, aligned=aligned
    ),
    "NamedTuple": lambda kinds, *cls: types.NamedTuple(list(map(type_of, kinds)), class_of(len(kinds), *cls)),
    "NamedUniTuple": lambda kinds, *cls: types.NamedUniTuple(type_of(kinds[0]), len(kinds), class_of(len(kinds), *cls)),
    "Tuple": lambda kinds: types.Tuple(list(map(type_of, kinds))),
    "Reference": reference,
}


def type_of(text: list) -> types.Type:
    """Return the type that `described` has taken apart."""
    name, *parts = text
    return TYPE_MAKERS[name](*parts) if name in TYPE_MAKERS else PLAIN_TYPES[name]


@cache
def restored(text: str) -> types.Type:
    """Return the type of a text of JSON."""
    return type_of(json.loads(text))
