"""Cars as places where powertrains are held: elastic mounts, scaled to the powertrain they carry.

A mount is a `Bushing` between ground and block. The rates of a car are set such that all mounts together carry the
powertrain at the bounce frequency, ``sum k_z = m (2 pi f)^2``, and damp it by a share of critical,
``c = 2 zeta k / (2 pi f)`` of each.

>>> [mount.name for mount in mounts(car("compact"), preset("inline_4"))]
['engine side', 'gearbox side', 'torque rod']
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from mbsd3d import GROUND, Body, Bushing, rotation
from mbsd3d.errors import InputError
from mbsd3d.extend import matrix, number
from validation.nvh.engine.presets import Preset

DATA = Path(__file__).parents[1] / "data" / "cars.json"


@dataclass(frozen=True)
class Mount:
    """An elastic mount.

    ``name``; ``at`` (3,): from the middle of the crank, car axes [m]; ``rates`` (3,): along its own axes, > 0 [N/m];
    ``damping`` (3,): >= 0 [N s/m]; ``angle``: by which its axes are turned about x [degrees]. ValueError for a rate
    that is not positive, or a negative damping.
    """

    name: str
    at: tuple[float, float, float]
    rates: tuple[float, float, float]
    damping: tuple[float, float, float]
    angle: float = 0.0

    def __post_init__(self) -> None:
        for field, positive in (("rates", True), ("damping", False)):
            for i, x in enumerate(getattr(self, field)):
                what = f"mount '{self.name}': {field}[{i}]"
                number(x, what, positive=True) if positive else number(x, what, minimum=0.0)

    @property
    def axes(self) -> np.ndarray:
        """(3, 3) of the mount, in columns."""
        return matrix(rotation("x", self.angle, degrees=True))

    @property
    def stiffness(self) -> np.ndarray:
        """(3, 3) car axes [N/m]."""
        return self.axes @ np.diag(self.rates) @ self.axes.T

    def bushing(self, body: Body) -> Bushing:
        """Between ground and a body, which is at the reference pose."""
        return Bushing(
            GROUND, body, at=self.at, stiffness=self.rates, damping=self.damping, axes=self.axes, name=self.name
        )


@dataclass(frozen=True)
class Car:
    """A car of the data file.

    ``mounts``: name -> at, rates, angle as there; ``bounce`` [Hz]; ``damping`` [-]; ``ride``: the car on its wheels,
    None if nothing is known of it.
    """

    name: str
    title: str
    mounts: dict[str, dict[str, Any]]
    bounce: float
    damping: float
    ride: dict[str, Any] | None = None


@cache
def data() -> dict[str, Any]:
    """The file of cars."""
    return json.loads(DATA.read_text(encoding="utf-8"))


def names() -> tuple[str, ...]:
    """Of all cars."""
    return tuple(data()["cars"])


def car(name: str) -> Car:
    """A car by its name; ValueError for an unknown one, with all names."""
    if name not in names():
        raise InputError(f"car '{name}' is unknown; there are {', '.join(names())}")
    return Car(name, **data()["cars"][name])


def mounts(chosen: Car, engine: Preset, mass: float | None = None) -> list[Mount]:
    """The mounts of a car for an engine; ``mass``: that they carry [kg]; None = of the block."""
    block = engine.block
    mass = block.mass if mass is None else number(mass, "mounts: mass", positive=True)
    frequency = 2 * np.pi * number(chosen.bounce, f"car '{chosen.name}': bounce", positive=True)
    raw = [Mount(name, (0, 0, 0), m["rates"], (0, 0, 0), m["angle"]) for name, m in chosen.mounts.items()]
    unit = mass * frequency**2 / sum(mount.stiffness[2, 2] for mount in raw)
    found = []
    for mount, record in zip(raw, chosen.mounts.values(), strict=True):
        at = np.array(block.com) + np.array(record["at"]) * np.array(block.box) / 2
        rates = unit * np.array(mount.rates)
        damping = 2 * chosen.damping / frequency * rates
        found.append(Mount(mount.name, tuple(at), tuple(rates), tuple(damping), mount.angle))
    return found


def bushings(placed: Sequence[Mount], body: Body) -> list[Bushing]:
    """All mounts on a body."""
    return [mount.bushing(body) for mount in placed]
