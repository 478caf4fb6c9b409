"""Layouts of reciprocating engines, and engines as a layout with the masses of its cylinders.

The crankshaft turns about z by ``q = w t``. At q = 0 crankpin i points along ``pins[i]`` and bore i along ``bores[i]``,
angles from x towards y; cylinder i works in the plane z = ``stations[i]``. The 24 layouts of references/engine.json:

>>> layout("I4").pins
(0.0, 180.0, 180.0, 0.0)
>>> len(names())
24
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mbsd3d.errors import InputError
from mbsd3d.extend import Checked, Number, NumberOrDerived, Stored, kept, number, part_class

CYLINDERS_MAX = 48  # [1] cylinders of an engine
DATA = Path(__file__).parents[1] / "references" / "engine.json"
SAMPLES_MAX = 600  # [1] samples of a turn; enough for R/L = 0.998
ALIASING_SHARE_MAX = 1e-13  # [1] of the force of one cylinder: part of an order that sampling may alias


@dataclass(frozen=True)
class Layout:
    """Positions of the cylinders of an engine and angles of its crankpins.

    ``name, title``: short name, and what it is; ``pins, bores`` (n,): directions of crankpins at q = 0 and of bores
    [degrees], from x towards y; ``stations`` (n,): z of the cylinders [m]; ``bank_angle``: between the banks [degrees];
    ``spacing``: bore spacing for which the stations hold [m]; ``firing_order``: as the source gives it, "1-3-4-2".
    ValueError if the numbers of pins, bores and stations differ, a value is not a number, or a cylinder does not fire
    once.

    Examples
    --------
    >>> Layout("twin", "parallel twin", pins=(0, 360), bores=(0, 0), stations=(-0.05, 0.05)).phases
    (0.0, 0.0)
    """

    name: str
    title: str
    pins: tuple[float, ...]
    bores: tuple[float, ...]
    stations: tuple[float, ...]
    bank_angle: float | None = None
    spacing: float = 0.1
    firing_order: str | None = None
    note: str = ""

    def __post_init__(self) -> None:
        what = f"layout '{self.name}'"
        for field in ("pins", "bores", "stations"):
            given = getattr(self, field)
            if isinstance(given, str) or not isinstance(given, Sequence | np.ndarray) or len(given) > CYLINDERS_MAX:
                raise InputError(
                    f"{what}: {field} {given!r:.80}; give a list, one a cylinder, of at most {CYLINDERS_MAX}"
                )
            values = tuple(number(x, f"{what}: {field}[{i}]") for i, x in enumerate(given))
            object.__setattr__(self, field, values)
        counts = {field: len(getattr(self, field)) for field in ("pins", "bores", "stations")}
        if len(set(counts.values())) > 1 or not self.pins:
            listed = ", ".join(f"{n} {field}" for field, n in counts.items())
            raise InputError(f"{what}: {listed}; give one of each per cylinder")
        object.__setattr__(self, "spacing", number(self.spacing, f"{what}: spacing", positive=True))
        order, count = self.firing_order, len(self.pins)
        every = sorted(str(i + 1) for i in range(count))
        if order is not None and not (isinstance(order, str) and sorted(order.split("-")) == every):
            raise InputError(f"{what}: firing_order {order!r}; give each of {count} cylinders once, '1-3-4-2'")

    @property
    def phases(self) -> tuple[float, ...]:
        """Return the crank angle of each cylinder from its own bore at q = 0, pin - bore, in [0, 360) [degrees]."""
        return tuple((pin - bore) % 360.0 for pin, bore in zip(self.pins, self.bores, strict=True))


@cache
def data() -> dict[str, Any]:
    """Return the content of the file of toy engines and published figures."""
    return json.loads(DATA.read_text(encoding="utf-8"))


def names() -> tuple[str, ...]:
    """Return the names of all layouts of the data file."""
    return tuple(data()["configurations"])


def layout(name: str) -> Layout:
    """Return a layout of the data file by its name or by its published name.

    ValueError if the name is unknown; it lists the names.

    >>> layout("V8_cross_article").name
    'V8_cross_in_sequence'
    """
    records = data()["configurations"]
    name = next((key for key, record in records.items() if record.get("published_as") == name), name)
    if not isinstance(name, str) or name not in records:
        raise InputError(f"layout {name!r} is unknown; there are {', '.join(records)}")
    record = records[name]
    return Layout(
        name=name,
        title=record["name"],
        pins=record["pin_deg"],
        bores=record["bore_deg"],
        stations=record["z"],
        bank_angle=record["bank_angle_deg"],
        spacing=record["bore_spacing_m"],
        firing_order=record["firing_order"],
        note=record["note"],
    )


class LayoutOrName(Stored[Layout | str, Layout]):
    """A layout, or its name in the data file."""

    @staticmethod
    def convert(value: Any, what: str, part: Any) -> Layout:
        """Return the layout itself, or look it up by name; raise ValueError for an unknown name."""
        return layout(value) if isinstance(value, str) else value


@part_class(eq=True)
class Engine(Checked):
    """Layout with dimensions, masses and speed; the default numbers are those of the toy engine (toy_set_1).

    ``layout``: or a name of the data file; ``rpm``: crank speed [1/min] >= 0; harmonics need one above 0;
    ``radius, rod_length``: crank radius R and rod length L > R [m]; ``crank_mass, crank_centre``: of the throw of one
    cylinder [kg], and how far from the axis, towards the pin, its centre of mass lies [m];
    ``rod_mass, rod_fraction, rod_inertia``: [kg]; centre of mass from the crankpin over L [-]; inertia about it, across
    the rod [kg m^2]; ``piston_mass``: [kg]; ``spacing``: bore spacing [m] to which the stations are scaled; None = that
    of the layout; ``offset``: of the bore axes from the crank axis, at right angles to the bore in the direction of
    rotation [m]. ValueError naming value and remedy, above all where the rod is too short.
    """

    layout: LayoutOrName = kept()
    rpm: Number = kept(default=10.0, minimum=0.0)
    radius: Number = kept(default=1.0, positive=True)
    rod_length: Number = kept(default=2.0, positive=True)
    crank_mass: Number = kept(default=2.0, positive=True)
    crank_centre: Number = kept(default=0.5)
    rod_mass: Number = kept(default=4.0, positive=True)
    rod_fraction: Number = kept(default=0.5)
    rod_inertia: Number = kept(default=1.0 / 3.0, positive=True)
    piston_mass: ArrayLike = 5.0
    spacing: NumberOrDerived = kept(default=None, positive=True, derived=lambda engine: engine.layout.spacing)
    offset: Number = kept(default=0.0)

    def what(self) -> str:
        """Return the name of the engine, at the start of errors."""
        return f"engine '{getattr(self.layout, 'name', self.layout)}'"

    def check(self, what: str) -> None:
        """Check one mass per piston, and a rod long enough for the crank to turn."""
        if np.ndim(self.piston_mass) and np.size(self.piston_mass) != len(self.layout.pins):
            n = len(self.layout.pins)
            raise InputError(f"{what}: {np.size(self.piston_mass)} piston masses for {n} cylinders; give one or {n}")
        for i, mass in enumerate(self.pistons, start=1):
            number(mass, f"{what}: piston_mass {i}", positive=True)
        if self.radius + abs(self.offset) >= self.rod_length:
            raise InputError(
                f"{what}: rod_length {self.rod_length:g} m must exceed radius {self.radius:g} m and offset "
                f"{abs(self.offset):g} m together, or the crank cannot turn"
            )

    @property
    def pistons(self) -> tuple[float, ...]:
        """Return the mass of each piston [kg]."""
        return tuple(np.broadcast_to(np.asarray(self.piston_mass, dtype=float), len(self.layout.pins)).tolist())

    @property
    def stations(self) -> np.ndarray:
        """Return the z of the cylinders [m], shape (n,)."""
        return np.array(self.layout.stations) * (self.spacing / self.layout.spacing)

    @property
    def ends(self) -> tuple[float, float]:
        """Return z of the first and the last main bearing [m], half a spacing beyond the cylinders."""
        return float(self.stations.min() - self.spacing / 2), float(self.stations.max() + self.spacing / 2)

    @property
    def rate(self) -> float:
        """Return the crank speed w [rad/s], above 0.

        ValueError if the engine stands still: nothing is periodic then.
        """
        if self.rpm == 0.0:
            raise InputError(f"engine '{self.layout.name}': rpm 0 has no harmonics; give a speed above 0")
        return 2 * np.pi * self.rpm / 60.0

    @property
    def single(self) -> float:
        """Return F_single, the 1x force along the bore of one cylinder, ``w^2 (m_c |r_c| + (m_r + m_p) R)`` [N].

        (A throw with a counterweight, r_c < 0, counts as if it had none: this is the scale of rounding.)
        """
        swung = self.crank_mass * abs(self.crank_centre) + (self.rod_mass + max(self.pistons)) * self.radius
        return self.rate**2 * swung

    def samples(self, orders: int = 6) -> int:
        """Return the number of samples of a turn, a multiple of 12, without aliasing above `ALIASING_SHARE_MAX` onto
        orders up to ``orders``.

        The order n of a slider-crank falls like nu^n, nu = lam / (1 + sqrt(1 - lam^2)), lam = (R + offset) / L.

        ValueError if the rod is hardly longer than the crank, so that more than `SAMPLES_MAX` would be needed.
        """
        lam = (self.radius + abs(self.offset)) / self.rod_length
        last = min(np.log(ALIASING_SHARE_MAX) / np.log(lam / (1 + np.sqrt(1 - lam**2))), 1e9)
        count = 12 * int(np.ceil((orders + max(last, orders + 1)) / 12))
        if count > SAMPLES_MAX:
            raise InputError(
                f"engine '{self.layout.name}': rod_length {self.rod_length:.9g} m hardly exceeds the crank: its orders "
                f"fall so slowly that a turn takes {count} samples, above {SAMPLES_MAX}; give a longer rod"
            )
        return count
