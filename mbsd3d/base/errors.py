"""What is refused and what fails: one base class, and errors that say when, at which part, by how much, what to do."""

import functools
import inspect
import re
import sys
from abc import ABCMeta
from collections.abc import Callable, Iterable, Mapping
from difflib import get_close_matches
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")
CONTROL_CHARACTERS = re.compile(  # what no name may hold, and no line on a terminal
    "[\x00-\x1f\x7f-\x9f\u2028\u2029"  # ends of lines and paragraphs, and all that moves a cursor, paints or rings
    "\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069"  # what turns the order of signs: a name would read as another one
    "\u200b\u2060-\u2064\ufeff\U000e0000-\U000e007f]"  # what nobody sees; joiners within words, U+200C and D, stay
)


class MbsError(ValueError):
    """Base of all errors of this package, a `ValueError`: ``except MbsError`` catches bad input and failed runs.

    Bad input raises an `InputError`; a failed run says at which time, at which part, by how much.

    The message is ``<what> at t = <time> s: <part>, residual <residual>; <advice>``, with what is None left out.
    ``time`` [s]; ``part``: the body, joint or force, e.g. "joint 'hinge' (Revolute)"; ``residual``: the largest one, in
    the unit of the row that failed; ``solution``: what was computed up to ``time``; ``advice``: what to change.
    """

    def __init__(
        self,
        what: str,
        *,
        time: float | None = None,
        part: str | None = None,
        residual: float | None = None,
        solution: Any = None,
        advice: str | None = None,
    ) -> None:
        # The whole sentence is the only argument of the base class, so that a copy from another process reads the same.
        super().__init__(_sentence(what, time, part, residual, advice))
        self.time = time
        self.part = part
        self.residual = residual
        self.solution = solution
        self.advice = advice


class InputError(MbsError):
    """Something given is refused: the message names the part, the value and the remedy.

    >>> print(InputError("body 'rod': mass -2.0 is not positive; give a number > 0"))
    body 'rod': mass -2.0 is not positive; give a number > 0
    """


class ArgumentError(InputError, TypeError):
    """A call with an argument that there is not, or without one that there must be."""


class NameMissingError(InputError, KeyError):
    """Something asked for by a name that it does not have."""

    __str__ = ValueError.__str__  # that of a KeyError would put the sentence in quotes


class AssemblyError(MbsError):
    """No configuration or velocity satisfies the joints.

    >>> print(AssemblyError("the loop cannot be closed", part="joint 'crank'", residual=2e-3, advice="shorten the rod"))
    the loop cannot be closed: joint 'crank', residual 0.002; shorten the rod
    """


class IntegrationError(MbsError):
    """The integrator could not go on; ``solution`` holds the samples up to ``time``.

    >>> print(IntegrationError("the model is stiff", time=0.25, part="force 'mount'", advice="use GeneralizedAlpha()"))
    the model is stiff at t = 0.25 s: force 'mount'; use GeneralizedAlpha()
    """


class KernelError(MbsError):
    """A compiled function could not be made: a fault of this package, or a numba that it does not know.

    >>> print(KernelError("kernel tyre cannot be compiled: TypingError: ...; MBSD3D_PLAIN_NUMBA=1 shows where"))
    kernel tyre cannot be compiled: TypingError: ...; MBSD3D_PLAIN_NUMBA=1 shows where
    """


class EquilibriumError(MbsError):
    """No equilibrium was found, or none near the start of the search.

    >>> print(EquilibriumError("no equilibrium: body 'stone' falls", advice="hold it"))
    no equilibrium: body 'stone' falls; hold it
    """


class GradientError(MbsError):
    """A derivative that does not exist, or cannot be trusted.

    >>> print(GradientError("the event angle > 0.8 is grazed", time=0.9, advice="give a value farther from the turn"))
    the event angle > 0.8 is grazed at t = 0.9 s; give a value farther from the turn
    """


class SweepError(MbsError):
    """A sweep had to stop; ``dataset`` holds the cells that had finished.

    >>> print(SweepError("the ledger cannot be written: disk is full", advice="make room and run the sweep again"))
    the ledger cannot be written: disk is full; make room and run the sweep again
    """

    def __init__(self, what: str, *, dataset: Any = None, advice: str | None = None) -> None:
        super().__init__(what, advice=advice)
        self.dataset = dataset


def _sentence(what: str, time: float | None, part: str | None, residual: float | None, advice: str | None) -> str:
    """Join the pieces that are known to one sentence."""
    when = "" if time is None else f" at t = {time:.6g} s"
    size = None if residual is None else f"residual {residual:.3g}"
    where = ", ".join(piece for piece in (part, size) if piece)
    return what + when + (f": {where}" if where else "") + (f"; {advice}" if advice else "")


# What people write who come from other programs or other habits: name -> what it is called here.
SYNONYMS = MappingProxyType({
    "angular_velocity": "omega", "angular_rate": "omega", "w": "omega", "pos": "position", "vel": "velocity",
    "quaternion": "orientation", "rotation": "orientation", "R": "orientation", "cog": "com", "center": "com",
    "k": "stiffness", "c": "damping", "d": "damping", "l0": "length", "rest_length": "length", "free_length": "length",
    "origin": "at", "point": "at", "location": "at", "direction": "axis", "torque": "speed", "omega": "speed",
    "dt": "method", "step": "method", "integrator": "method", "solver": "method", "tol": "rtol", "tolerance": "rtol",
    "tend": "t_end", "tf": "t_end", "duration": "t_end", "samples": "output", "initial": "state", "x0": "state",
    "constraints": "joints", "links": "bodies", "loads": "forces", "g": "gravity", "title": "name",
    "mu": "friction", "friction": "mu", "restitution": "loss", "corner_stiffness": "cornering", "teeth": "ratio",
})  # fmt: skip


def similar(name: object, known: Iterable[str]) -> list[str]:
    """Return up to three names that an unknown one may have meant, the nearest first, whatever its case."""
    lower = {text.lower(): text for text in known}
    return [lower[text] for text in get_close_matches(str(name).lower(), lower)]


def argument_error(
    name: str, signature: inspect.Signature, args: tuple[Any, ...], given: Mapping[str, Any]
) -> ArgumentError | None:
    """Describe what is wrong with a call, by the public name of what was called; return None if it fits."""
    try:
        signature.bind(*args, **given)
    except TypeError as error:
        known = [x for x in signature.parameters if x not in ("self", "cls")]
        unknown = [x for x in given if x not in known]
        takes = f"t takes {', '.join(known)}"
        if not unknown:
            return ArgumentError(f"{name}: {error}; i{takes}")
        meant = (SYNONYMS.get(unknown[0]), unknown[0].lower())
        near = [x for x in known if x in meant or x.lower() in meant] or similar(unknown[0], known)
        if unknown[0] in ("dt", "step") and near == ["method"]:
            return ArgumentError(
                f"{name}: no argument '{unknown[0]}', the step belongs to a method: method=RK4(dt=...)"
            )
        hint = f", did you mean '{near[0]}'? I" if near else "; i"
        return ArgumentError(f"{name}: no argument '{unknown[0]}'{hint}{takes}")
    return None


class Written:
    """A type as one writes it: without the modules it comes from, fields by what they accept."""

    def __init__(self, annotation: Any) -> None:
        array_like = getattr(sys.modules.get("numpy.typing"), "ArrayLike", inspect.Parameter.empty)
        plain = "array_like" if annotation == array_like else inspect.formatannotation(annotation)
        text = getattr(annotation, "accepts", "") or plain
        self.text = re.sub(r"\b(\w+\.)+(?=\w)", "", text)

    def __repr__(self) -> str:
        return self.text


class ChecksArguments(ABCMeta):
    """Classes whose wrong calls are answered by their public names, with the argument that was meant."""

    @property
    def __signature__(cls) -> inspect.Signature:
        """Return the signature of ``__init__``, for help and completion."""
        whole = inspect.signature(cls.__init__)  # type: ignore[misc]  # the class itself is meant
        own = [x.replace(annotation=Written(x.annotation)) for x in whole.parameters.values() if x.name != "self"]
        return whole.replace(parameters=own, return_annotation=inspect.Signature.empty)

    if not TYPE_CHECKING:
        __instancecheck__ = type.__instancecheck__  # no class is registered with one of these: half the time of ABCMeta

        def __call__(cls, *args, **given):
            try:
                return super().__call__(*args, **given)
            except TypeError as error:
                wrong = argument_error(cls.__name__, cls.__signature__, args, given)
                raise wrong or error from None


def checks_arguments(function: Callable[P, T], name: str | None = None) -> Callable[P, T]:
    """Describe wrong calls of a function by its public ``name``, as `ChecksArguments` does for a class."""

    @functools.wraps(function)
    def call(*args: P.args, **given: P.kwargs) -> T:
        try:
            return function(*args, **given)
        except TypeError:
            wrong = argument_error(name or function.__name__, inspect.signature(function), args, given)
            if wrong is None:
                raise
            raise wrong from None

    return call


def checks_method_arguments(cls: type[T]) -> type[T]:
    """Describe wrong calls of the public methods of a class, inherited ones included."""
    for name in dir(cls):
        method = inspect.getattr_static(cls, name)
        if name.startswith("_"):
            continue
        if inspect.isfunction(method):
            setattr(cls, name, checks_arguments(method, f"{cls.__name__}.{name}"))
        elif isinstance(method, classmethod):
            setattr(cls, name, classmethod(checks_arguments(method.__func__, f"{cls.__name__}.{name}")))
    return cls
