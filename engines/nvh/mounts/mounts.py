"""Cars and their elastic mounts, scaled to the powertrain they carry.

A mount is a `Bushing` between ground and block. The rates of a car with a bounce frequency are set such that all mounts
together carry the powertrain at it, ``sum k_z = m (2 pi f)^2``, and damp it by a share of critical,
``c = 2 zeta k / (2 pi f)`` of each; places are in halves of the powertrain's size. A car without one (null) has mounts
of its own: places [m] from the middle of the crank, rates [N/m], damping [N s/m].

>>> [mount.name for mount in mounts(car("compact"), preset("inline_4"))]
['engine side', 'gearbox side', 'torque rod']
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from engines.nvh.excitation.presets import Preset
from engines.nvh.records import data, fields, is_file, positive, record, titled, triple
from mbsd3d import GROUND, Body, Bushing, rotation
from mbsd3d.errors import InputError
from mbsd3d.extend import matrix, number

RIDE_FIELDS = (
    "mass", "roll_inertia", "pitch_inertia", "wheelbase", "front", "track", "unsprung", "spring", "damper", "tyre",
    "tyre_damping", "cornering", "seat", "brakes", "guides",
)  # fmt: skip
BEAM_FIELDS = ("mass", "roll_inertia", "length", "width", "bending", "lateral", "torsion")
SHELL_FIELDS = (*BEAM_FIELDS, "damping", "engine", "turned", "seat")


@dataclass(frozen=True)
class Mount:
    """Elastic mount of a powertrain.

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
        what = f"mount '{self.name}'"
        triple(self.at, f"{what}: at")
        triple(self.rates, f"{what}: rates", positive=True)
        triple(self.damping, f"{what}: damping", minimum=0.0)
        number(self.angle, f"{what}: angle")

    @property
    def axes(self) -> np.ndarray:
        """Return the axes of the mount in columns, shape (3, 3)."""
        return matrix(rotation("x", self.angle, degrees=True))

    @property
    def stiffness(self) -> np.ndarray:
        """Return the stiffness in car axes [N/m], shape (3, 3)."""
        return self.axes @ np.diag(self.rates) @ self.axes.T

    @property
    def dampers(self) -> np.ndarray:
        """Return the damping in car axes [N s/m], shape (3, 3)."""
        return self.axes @ np.diag(self.damping) @ self.axes.T

    def bushing(self, body: Body) -> Bushing:
        """Return the bushing between ground and a body in its reference pose."""
        return Bushing(
            GROUND, body, at=self.at, stiffness=self.rates, damping=self.damping, axes=self.axes, name=self.name
        )


@dataclass(frozen=True)
class Car:
    """A car; fields as in the data file.

    ``mounts``: name -> at, rates, angle as there; ``bounce`` [Hz], None for mounts with rates of their own;
    ``damping`` [-]; ``ride``: the car on its wheels, ``shell``: its body as a beam, None if nothing is known of them.
    ValueError for a title that is not a text, a field that is missing or unknown, a rate or frequency that is not
    positive, a negative damping, or a place that is none.
    """

    name: str
    title: str
    mounts: dict[str, dict[str, Any]]
    bounce: float | None
    damping: float | None = None
    ride: dict[str, Any] | None = None
    shell: dict[str, Any] | None = None

    def __post_init__(self) -> None:
        what, scaled = f"car '{self.name}'", self.bounce is not None
        titled(self.title, what)
        if not isinstance(self.mounts, dict) or not self.mounts:
            raise InputError(f"{what}: no mounts; give three that are not in line")
        if scaled:
            number(self.bounce, f"{what}: bounce", positive=True)
            number(self.damping, f"{what}: damping", minimum=0.0)
        for name, mount in self.mounts.items():
            fields(
                mount, ("at", "rates", "angle") if scaled else ("at", "rates", "damping", "angle"), f"mount '{name}'"
            )
            Mount(name, mount["at"], mount["rates"], mount.get("damping", (0, 0, 0)), mount["angle"])
        for part, needed in (("ride", RIDE_FIELDS), ("shell", SHELL_FIELDS)):
            if getattr(self, part) is not None:
                fields(getattr(self, part), needed, f"{what}: {part}")
        if self.shell is not None:
            what += ": shell"
            positive(self.shell, BEAM_FIELDS, what)
            number(self.shell["damping"], f"{what}: damping", minimum=0.0)
            number(self.shell["turned"], f"{what}: turned")
            for name in ("engine", "seat"):
                triple(self.shell[name], f"{what}: {name}")


def names() -> tuple[str, ...]:
    """Return the names of all cars of the data file."""
    return tuple(data("cars")["cars"])


def car(name: str) -> Car:
    """Return a car by its name, or from a file (.json) with the same fields; raise ValueError for others."""
    found, title = record("cars", name), Path(name).stem if is_file(name) else name
    fields(found, ("title", "mounts", "bounce"), f"car '{title}'", ("damping", "ride", "shell"))
    return Car(title, **found)


def mounts(chosen: Car, engine: Preset, mass: float | None = None) -> list[Mount]:
    """Return the mounts of a car for an engine; ``mass``: that they carry [kg]; None = of the block."""
    if chosen.bounce is None:
        return [Mount(name, m["at"], m["rates"], m["damping"], m["angle"]) for name, m in chosen.mounts.items()]
    block = engine.block
    mass = block.mass if mass is None else number(mass, "mounts: mass", positive=True)
    frequency = 2 * np.pi * chosen.bounce
    raw = [Mount(name, (0, 0, 0), m["rates"], (0, 0, 0), m["angle"]) for name, m in chosen.mounts.items()]
    unit = mass * frequency**2 / sum(mount.stiffness[2, 2] for mount in raw)
    found = []
    for mount, own in zip(raw, chosen.mounts.values(), strict=True):
        at = np.array(block.com) + np.array(own["at"]) * np.array(block.box) / 2
        rates = unit * np.array(mount.rates)
        damping = 2 * number(chosen.damping, f"car '{chosen.name}': damping") / frequency * rates
        found.append(Mount(mount.name, tuple(at), tuple(rates), tuple(damping), mount.angle))
    return found


def bushings(placed: Sequence[Mount], body: Body) -> list[Bushing]:
    """Return the bushings of all mounts on a body."""
    return [mount.bushing(body) for mount in placed]
