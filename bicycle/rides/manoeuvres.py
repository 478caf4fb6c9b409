"""Manoeuvres: starts and loads by name, as arguments of `bicycle.ride.run`."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np

from mbsd3d import Pulse, Signal, Sine
from mbsd3d.errors import InputError

from ..model.tyres import TYPICAL, both

FALLEN = float(np.radians(60.0))  # Default tilt of the frame at which a ride ends [rad]


@dataclass(frozen=True)
class Manoeuvre:
    """Initial state and loads of a ride; ``title`` says in one line what happens."""

    title: str
    speed: float  # [m/s]
    t_end: float = 20.0  # [s]
    start: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))  # lean, steer, rates [rad, rad/s]
    loads: Mapping[str, Signal | float] = field(
        default_factory=lambda: MappingProxyType({})
    )  # torque, push, drive, ...
    on_tyres: bool = False  # False: any wheels
    grip: Signal | None = None  # share of the grip of the tyres that is left; None = all of it

    @property
    def arguments(self) -> dict[str, Any]:
        """Return keyword arguments of `bicycle.ride.run`."""
        return {"t_end": self.t_end, "speed": self.speed, **self.start, **self.loads, **self.fittings({})}

    def fittings(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return further arguments of `bicycle.whipple`: those given, with tyres, and with the remaining grip."""
        if not self.on_tyres:
            return dict(given)
        pair = both(given.get("tyres", TYPICAL))
        return {**given, "tyres": pair if self.grip is None else tuple(less_grip(one, self.grip) for one in pair)}


def less_grip(tyre: Mapping[str, Any], share: Signal) -> dict[str, Any]:
    """Return the arguments of a tyre with a share of its ``mu``; raise ValueError where ``mu`` is not a number."""
    mu = tyre.get("mu", TYPICAL["mu"])
    if isinstance(mu, Signal) or mu is None:
        raise InputError(f"manoeuvre: mu = {mu!r} has no share that is left on a wet patch; give a number")
    return {**tyre, "mu": mu * share}


def rolled(speed: float, rate: float) -> Manoeuvre:
    """Return a manoeuvre of the IFToMM benchmark "uncontrolled bicycle": upright, with a lean rate."""
    return Manoeuvre(f"IFToMM benchmark: {speed:g} m/s, lean rate {rate:g} rad/s", speed, 20.0, {"lean_rate": rate})


MANOEUVRES: Mapping[str, Manoeuvre] = MappingProxyType({
    "M1": rolled(4.0, 0.05),
    "M2": rolled(4.6, 0.5),
    "M3": rolled(8.0, 0.05),
    "push": Manoeuvre(
        "Push to the right on frame and rider, 10 N s", 5.0, 10.0,
        loads={"push": Pulse(40.0, start=0.5, edge=0.05, duration=0.3)},
    ),
    "pulse": Manoeuvre(
        "Pulse of steer torque to the right, 0.5 N m for 0.5 s", 5.0, 10.0,
        loads={"torque": Pulse(0.5, start=0.5, edge=0.1, duration=0.6)},
    ),
    "countersteer": Manoeuvre(
        "Counter-steering: steer torque to the right from 0.5 s on", 5.0, 20.0,
        loads={"torque": Pulse(0.1, start=0.5, edge=0.1)},
    ),
    "circle": Manoeuvre(
        "Steer torque of 0.1 N m to the left until the circle is steady", 5.0, 60.0,
        loads={"torque": Pulse(-0.1, 0.0, 2.0)},
    ),
    "pedal": Manoeuvre(
        "Pedalling against the air, up to the speed it allows", 4.5, 60.0,
        loads={"drive": 6.0 + Sine(4.0, frequency=2.4), "drag": 0.6},
    ),
    "brake": Manoeuvre(
        "Front brake up to 300 N m, on tyres: the rear wheel lifts", 8.0, 0.85,
        loads={"brake": Pulse(300.0, start=0.1, edge=0.2, duration=0.6)}, on_tyres=True,
    ),
    "wet": Manoeuvre(
        "A wet patch in a curve, on tyres: a twentieth of the grip is left", 6.0, 4.0, {"lean": 0.25, "steer": 0.1},
        on_tyres=True, grip=1.0 - Pulse(0.95, start=0.8, edge=0.05, duration=3.0),
    ),
    "slow": Manoeuvre("Below the weave speed: it weaves until a wheel lifts", 2.0, 10.0, {"lean_rate": 0.05}),
})  # fmt: skip
