"""Tyres of a bicycle: two `mbsd3d.Tyre` that carry its weight at the radii of its parameters."""

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

from mbsd3d import GROUND, Body, Tyre
from mbsd3d.errors import InputError
from mbsd3d.extend import number

from ..parameters import Parameters
from .kinematics import hubs

Tyres = Mapping[str, Any] | Sequence[Mapping[str, Any]]
"""What `mbsd3d.Tyre` takes besides geometry: for both wheels, or (rear, front)."""

TYPICAL: dict[str, Any] = {
    "cornering": 14.3, "camber": 1.0, "longitudinal": 20.0, "relaxation": 0.1, "trail": 0.02, "mu": 0.9,
    "stiffness": 2e5, "damping": 400.0,
}  # fmt: skip
"""Of a bicycle tyre under a usual load."""
GEOMETRY_ARGUMENTS = ("a", "b", "name", "axis", "radius", "crown", "centre", "plane")
TYRE_ARGUMENTS = tuple(one.name for one in fields(Tyre) if one.init and one.name not in GEOMETRY_ARGUMENTS)


def both(tyres: Tyres) -> tuple[Mapping[str, Any], Mapping[str, Any]]:
    """Return (rear, front) tyres; raise ValueError for others."""
    given = (tyres, tyres) if isinstance(tyres, Mapping) else tyres
    if not isinstance(given, Sequence) or len(given) != 2 or not all(isinstance(one, Mapping) for one in given):
        raise InputError(
            f"tyres = {tyres!r}; give the arguments of mbsd3d.Tyre in a dict, or two of them: (rear, front)"
        )
    for one in given:
        unknown = [key for key in one if key not in TYRE_ARGUMENTS]
        if unknown:
            raise InputError(f"tyres: {', '.join(map(str, unknown))} unknown; give some of {', '.join(TYRE_ARGUMENTS)}")
    rear, front = given
    return rear, front


def loads(p: Parameters) -> tuple[float, float]:
    """Return the weight on the rear and the front wheel of the upright bicycle [N]."""
    front = p.front_load * p.mass * p.g
    return p.mass * p.g - front, front


def tyres_of(p: Parameters, bodies: Sequence[Body], tyres: Tyres) -> list[Tyre]:
    """Return tyres on the rear and the front wheel; under their static load they have the radius r and the crown t.

    A tyre pressed by N/k runs like a rigid torus whose tube is as much thinner: its own is t + N/k. A ValueError for
    a bicycle that tips, which no tyre holds down, and for wheels without inertia about their axles.
    """
    light = [key for key in ("IRyy", "IFyy") if getattr(p, key) == 0.0]
    if light:
        raise InputError(
            f"bicycle '{p.name}': {' and '.join(light)} = 0: on a tyre a wheel turns freely and needs inertia "
            "about its axle; give it some, or leave out tyres"
        )
    if min(loads(p)) < 0.0:
        raise InputError(
            f"bicycle '{p.name}': it tips even at rest, with {100.0 * p.front_load:.4g} % of its weight on the front "
            "wheel, and a tyre does not pull; move its masses between the wheels, or leave out tyres"
        )
    made = []
    for wheel, hub, load, given, part in zip((bodies[0], bodies[3]), hubs(p), loads(p), both(tyres), "RF", strict=True):
        given = {"stiffness": TYPICAL["stiffness"], **given}
        name = f"{'rear' if part == 'R' else 'front'} tyre"
        pressed = load / number(given["stiffness"], f"force '{name}' (Tyre): stiffness", positive=True)
        radius, crown = getattr(p, f"r{part}") + pressed, getattr(p, f"t{part}") + pressed
        made.append(Tyre(GROUND, wheel, axis=(0, 1, 0), radius=radius, crown=crown, centre=hub, name=name, **given))
    return made
