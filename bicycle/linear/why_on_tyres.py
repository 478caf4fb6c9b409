"""Causes of the self-stability of a bicycle on tyres: variants of bicycle and tyres, compared with ideal wheels.

Ranges are eigenvalues of pencils, not read off a grid of speeds, see `bicycle.linear.tyre_equations`. A variant of the
tyres alone has no counterpart on ideal wheels, which know only the crown.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, replace
from functools import partial
from typing import Any

from mbsd3d import Tyre, linearize

from ..model.mechanism import whipple
from ..model.tyres import Tyres
from ..output import collected
from ..parameters import Parameters
from . import critical
from .critical import critical_speeds
from .tyre_equations import growth, required_equations
from .variants import CHANGES, Ablation, Ablations, Fields, lock

Numbers = Mapping[str, Any]
TYRE_DEFAULTS = {one.name: one.default for one in fields(Tyre) if one.init}
CROWN_INCREASE = 0.02  # [m] added to the crown radius
LIGHT_RATIO = 1e-6
"""Share of the moment of inertia about its axle that a wheel without spin momentum keeps: on a tyre it turns freely."""
TYRE_CHANGES: dict[str, Callable[[Numbers], Numbers]] = {
    "tyres without camber force": lambda one: {"camber": 0.0},
    "tyres without pneumatic trail": lambda one: {"trail": 0.0},
    "tyres without relaxation": lambda one: {"relaxation": 1e-3 * one["relaxation"]},
    "tyres half as stiff sideways": lambda one: {"cornering": 0.5 * one["cornering"]},
    "tyres twice as stiff sideways": lambda one: {"cornering": 2.0 * one["cornering"]},
}
"""Name -> numbers of `mbsd3d.Tyre` that change."""


def ablations(
    parameters: Parameters, tyres: tuple[Numbers, Numbers], fittings: Mapping[str, Any], progress: bool | None
) -> Ablations:
    """Compute ranges of the variants, and their growth at one speed [1/s]; see `bicycle.why.ablations`."""
    linear = required_equations(partial(whipple, tyres=tyres, **fittings), parameters)
    speed = critical.typical_speed(linear.stable())
    rows = variants(parameters, tyres, fittings, speed)
    count = len(CHANGES) + len(TYRE_CHANGES) + 2
    found = collected(f"variants of {parameters.name} on tyres", rows, count, progress)
    return Ablations(parameters, speed, found, count - len(found))


def variants(
    parameters: Parameters, tyres: tuple[Numbers, Numbers], fittings: Mapping[str, Any], speed: float
) -> Iterator[Ablation]:
    """Yield the changes of the bicycle, its locked steering, more crown, and the changes of the tyres."""
    for name, change in CHANGES.items():
        yield changed(parameters, name, change, {"tyres": tyres, **fittings}, speed)
    held = lock(whipple(parameters, speed, tyres=tyres, **fittings))
    yield Ablation("steering locked", parameters, [], float(linearize(held).eigenvalues.real.max()), ideal=[])
    rounder = {"tR": parameters.tR + CROWN_INCREASE, "tF": parameters.tF + CROWN_INCREASE}
    yield changed(parameters, "20 mm more crown", lambda p: rounder, {"tyres": tyres, **fittings}, speed)
    for name, refit in TYRE_CHANGES.items():
        other: Tyres = [{**one, **refit({**TYRE_DEFAULTS, **one})} for one in tyres]
        row = changed(parameters, name, lambda p: {}, {"tyres": other, **fittings}, speed)
        yield replace(row, ideal=None)


def changed(
    parameters: Parameters, name: str, change: Callable[[Parameters], Fields], fittings: Mapping[str, Any],
    speed: float,
) -> Ablation:  # fmt: skip
    """Return a variant on tyres and on ideal wheels, or why it is not possible."""
    try:
        variant = replace(parameters, **change(parameters), name=f"{parameters.name}, {name}")
        turns: Fields = {
            key: LIGHT_RATIO * getattr(parameters, key) for key in ("IRyy", "IFyy") if getattr(variant, key) == 0.0
        }
        linear = required_equations(partial(whipple, **fittings), replace(variant, **turns))
        ideal = critical_speeds(variant, whipple).stable
        return Ablation(name, variant, linear.stable(), growth(linear.A(speed)), ideal=ideal)
    except ValueError as error:
        return Ablation(name, parameters, [], float("nan"), problem=str(error))
