"""Engines with the dimensions of real ones, as `engine_balance.Engine` and with what else a powertrain needs.

The rod is known by mass and length; its centre of mass lies at `FRACTION` of the length from the crankpin and its
inertia is that of two masses at the ends over `TWO_MASSES`, the average of measured rods. Counterweights carry all that
turns with the pin and the share ``balanced`` of what goes with the piston:

    m_c r_c = -((1 - f) m_r + balanced (m_p + f m_r)) R

>>> preset("inline_4").engine(3000).layout.firing_order
'1-3-4-2'
"""

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from mbsd3d import inertia, rotation
from mbsd3d.errors import InputError
from mbsd3d.extend import matrix, number
from validation.engine_balance.layouts import Engine, Layout, layout

DATA = Path(__file__).parents[1] / "data" / "engines.json"
FRACTION, TWO_MASSES = 0.28, 1.0965


@dataclass(frozen=True)
class Block:
    """All of a powertrain that does not move relative to its block.

    ``mass`` [kg]; ``box`` (3,): edges of the uniform box of its inertia [m]; ``com`` (3,): from the middle of the
    crank, x along it, z up [m]; ``tilt``: of the box about y [degrees].
    """

    mass: float
    box: tuple[float, float, float]
    com: tuple[float, float, float]
    tilt: float

    @property
    def inertia(self) -> np.ndarray:
        """(3, 3) about the centre of mass [kg m^2]."""
        R = matrix(rotation("y", self.tilt, degrees=True))
        return R @ np.diag(inertia.box(self.mass, self.box)) @ R.T


@dataclass(frozen=True)
class Preset:
    """An engine of the data file; lengths [m], masses [kg], speeds [1/min], see there."""

    name: str
    title: str
    layout: Layout
    bore: float
    stroke: float
    rod_length: float
    spacing: float
    idle: float
    redline: float
    compression: float
    piston_mass: float
    rod_mass: float
    throw_mass: float
    balanced: float
    flywheel: float
    main_diameter: float
    main_width: float
    roller_rating: float
    block: Block

    @property
    def displacement(self) -> float:
        """Of all cylinders [m^3]."""
        return len(self.layout.pins) * np.pi / 4 * self.bore**2 * self.stroke

    def engine(self, rpm: float) -> Engine:
        """The engine at a speed [1/min] > 0; ValueError for others."""
        rpm = number(rpm, f"engine '{self.name}': rpm", positive=True)
        R, f = self.stroke / 2, FRACTION
        carried = (1 - f) * self.rod_mass + self.balanced * (self.piston_mass + f * self.rod_mass)
        return Engine(
            self.layout, rpm=rpm, radius=R, rod_length=self.rod_length, crank_mass=self.throw_mass,
            crank_centre=-carried * R / self.throw_mass, rod_mass=self.rod_mass, rod_fraction=f,
            rod_inertia=f * (1 - f) * self.rod_mass * self.rod_length**2 / TWO_MASSES, piston_mass=self.piston_mass,
            spacing=self.spacing,
        )  # fmt: skip


@cache
def data() -> dict[str, Any]:
    """The file of engines, and the ranges their numbers lie in."""
    return json.loads(DATA.read_text(encoding="utf-8"))


def names() -> tuple[str, ...]:
    """Of all engines."""
    return tuple(data()["engines"])


def preset(name: str) -> Preset:
    """An engine by its name; ValueError for an unknown one, with all names."""
    if name not in names():
        raise InputError(f"engine '{name}' is unknown; there are {', '.join(names())}")
    record = dict(data()["engines"][name])
    block = Block(**record.pop("block"))
    if "layout" in record:
        plan = layout(record.pop("layout"))
    else:
        parts = {key: record.pop(key) for key in ("pins", "bores", "stations", "firing_order")}
        plan = Layout(name, record["title"], **parts)
    return Preset(name=name, layout=plan, block=block, **record)
