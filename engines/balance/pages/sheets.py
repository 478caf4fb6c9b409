"""Content of the page of an engine as data: harmonics with words, three methods side by side, torque over a turn."""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from engines.balance import gas, phasor, report
from engines.balance.balance import Comparison
from engines.balance.layouts import Engine
from engines.balance.pages import drawings
from engines.balance.published.claims import Row
from mbsd3d.extend import digits

ROTATING_PART_SHARE_MIN = 1e-6  # [1] of a harmonic; smaller parts that turn the other way are rounding
TORQUE_ORDERS = 24  # [1] orders of the driving torque over a turn
QUANTITIES = (("force", "N"), ("couple", "N m"), ("torque", "N m"))


@dataclass(frozen=True)
class Harmonic:
    """Force or couple of one order."""

    order: int
    kind: str
    """"force" or "couple"."""
    forward: complex
    backward: complex
    noise: float

    @property
    def axes(self) -> tuple[float, float]:
        """Return the long and the short half axis of the ellipse [N or N m]."""
        f, b = abs(self.forward), abs(self.backward)
        return f + b, abs(f - b)

    @property
    def there(self) -> bool:
        """Return whether the harmonic is larger than rounding."""
        return self.axes[0] > self.noise

    @property
    def motion(self) -> str:
        """Return in words how the harmonic turns or swings."""
        f, b = abs(self.forward), abs(self.backward)
        if not self.there:
            return "balanced"
        if b <= ROTATING_PART_SHARE_MIN * f:
            return "turns with the crank, constant size"
        if f <= ROTATING_PART_SHARE_MIN * b:
            return "turns against the crank, constant size"
        if abs(f - b) <= ROTATING_PART_SHARE_MIN * (f + b):
            angle = np.degrees(np.angle(self.forward) - np.angle(self.backward)) / 2
            angle = round(angle, 3) % 180.0
            return {0.0: "swings along x", 90.0: "swings along y"}.get(angle, f"swings at {angle:.4g}\u00b0 from x")
        return f"ellipse, {'with' if f > b else 'against'} the crank"

    @property
    def cure(self) -> str:
        """Return the balance shafts that would cancel a remaining force [N] or moment [N m]."""
        f, b = (abs(part) > ROTATING_PART_SHARE_MIN * self.axes[0] for part in (self.forward, self.backward))
        if not self.there:
            return ""
        if f and b and self.order > 1:
            return f"two shafts at {self.order}x, one with and one against the crank"
        forward = "counterweights on the crank" if self.order == 1 else f"a shaft at {self.order}x with the crank"
        return " and ".join([forward] * f + [f"a shaft at {self.order}x against the crank"] * b)

    @property
    def drawing(self) -> Any:
        """Draw the rotating vectors of the harmonic."""
        label = f"{self.order}x {self.kind}: {self.motion}"
        return drawings.polar(self.forward, self.backward, label) if self.there else drawings.still(label)

    @property
    def icon(self) -> Any:
        """Draw the small ellipse of the harmonic."""
        return drawings.icon(self.forward, self.backward)


@dataclass(frozen=True)
class Sheet:
    """Engine with its harmonics by three methods."""

    comparison: Comparison
    samples: tuple[np.ndarray, np.ndarray]
    """Crank angle [degrees] and driving torque [N m] of the spatial model over a turn."""
    gas: "GasTorque | None" = None  # None where no firing order is known

    @property
    def engine(self) -> Engine:
        """Return the engine of the comparison."""
        return self.comparison.engine

    @cached_property
    def orders(self) -> range:
        """Return the orders from 1 to the highest one."""
        return range(1, len(self.comparison.ways["spatial"].torque))

    @property
    def noise(self) -> float:
        """Return the amplitude below which a harmonic is rounding [N or N m]."""
        return report.AMPLITUDE_ROUNDING * self.comparison.scale

    def harmonics(self, kind: str) -> list[Harmonic]:
        """Return the harmonics of force or couple, one per order, of the spatial model."""
        h, k = self.comparison.ways["spatial"], ("force", "couple").index(kind)
        return [Harmonic(n, kind, complex(h.forward[n, k]), complex(h.backward[n, k]), self.noise) for n in self.orders]

    def shakes(self, kind: str) -> bool:
        """Return whether any order of force or couple is unbalanced."""
        return any(h.kind == kind for h in self.left)

    def torque(self, order: int) -> float:
        """Return the amplitude of the driving torque of an order [N m]."""
        return float(np.abs(self.comparison.ways["spatial"].torque[order]))

    @cached_property
    def left(self) -> list[Harmonic]:
        """Return the unbalanced harmonics, the forces first."""
        return [h for kind in ("force", "couple") for h in self.harmonics(kind) if h.there]

    def bars(self, quantity: str) -> Any:
        """Draw the amplitudes of a quantity of `QUANTITIES` by order, three methods."""
        values = {way: report.amplitudes(h)[quantity][1:] for way, h in self.comparison.ways.items()}
        values = {way: np.where(x > self.noise, x, 0.0) for way, x in values.items()}
        texts = [digits(float(x)) for x in values["spatial"]]
        return drawings.bars(values, texts, f"{quantity} by order, three ways: {', '.join(texts)}")

    def path(self, kind: str) -> Any:
        """Draw the path of force or couple over a turn with all orders from 1x on, without the mean, which is the
        weight.
        """
        h, q = self.comparison.ways["spatial"], np.linspace(0, 2 * np.pi, 181)[:-1]
        load = h.force if kind == "force" else h.moment
        x, y = np.real(np.exp(1j * np.outer(q, self.orders)) @ load[1:]).T[:2]
        return drawings.loop(x, y, f"{kind} over a turn, all orders")

    @cached_property
    def closed(self) -> tuple[np.ndarray, np.ndarray]:
        """Return crank angle [degrees] and driving torque [N m] in closed form, every half degree."""
        q = np.linspace(0.0, 360.0, 721)
        torque = phasor.block_load(self.engine, TORQUE_ORDERS, gravity=self.comparison.gravity).torque
        return q, np.real(np.exp(1j * np.outer(np.radians(q), np.arange(TORQUE_ORDERS + 1))) @ torque)

    def curve(self) -> Any:
        """Draw the driving torque over the crank angle: closed form as a line, the spatial model as dots."""
        label = "driving torque over the crank angle"
        return drawings.curve(*self.closed, self.samples, label, "driving torque [N m]")

    @property
    def peak(self) -> float:
        """Return the largest driving torque [N m]."""
        return float(np.abs(self.closed[1]).max())

    @property
    def firing(self) -> str:
        """Return order and gaps of the ignitions of a four-stroke engine, in words."""
        plan = self.engine.layout
        try:
            angles, order = np.sort(gas.firing_angles(plan)), gas.firing_order(plan)
        except gas.FiringOrderError:  # too many cylinders to search
            return plan.firing_order or "not stated"
        gaps = np.round(np.diff([*angles, angles[0] + 720.0]), 6)
        apart = (
            f"every {gaps[0]:g}\u00b0" if np.ptp(gaps) == 0 else f"{gaps.min():g}\u00b0 to {gaps.max():g}\u00b0 apart"
        )
        stated = "" if plan.firing_order in (None, order) else f" (stated: {plan.firing_order})"
        return f"{order}, {apart}{stated}"

    def claims(self, rows: list[Row]) -> list[Row]:
        """Return the rows of the truth table about this layout."""
        return [row for row in rows if self.engine.layout.name in row.layouts]

    @staticmethod
    def columns(rows: list[Row]) -> list[tuple[str, str]]:
        """Return (attribute, title) of the figures that any of the rows has."""
        every = ("published", "published"), ("assumed", "by its assumptions"), ("actual", "true")
        return [column for column in every if any(getattr(row, column[0]) is not None for row in rows)]


@dataclass(frozen=True)
class GasTorque:
    """Torque of half sines of the gas over the power strokes on the crank, without inertia, over two turns."""

    engine: Engine
    peak: float  # On each piston [N]
    samples: tuple[np.ndarray, np.ndarray]  # Crank angle [degrees] and torque on the crank [N m] of the spatial model

    @cached_property
    def closed(self) -> tuple[np.ndarray, np.ndarray]:
        """Return crank angle [degrees] and torque [N m] by virtual power, every half degree."""
        q = np.linspace(0.0, 720.0, 1441)
        return q, gas.torque(self.engine, gas.half_sine(self.peak), np.radians(q))

    def curve(self) -> Any:
        """Draw the torque over the crank angle: virtual power as a line, the spatial model as dots."""
        label = "torque of the gas on the crank over two turns"
        return drawings.curve(*self.closed, self.samples, label, "gas torque [N m]")

    def harmonics(self, orders: int) -> list[tuple[float, float, float]]:
        """Return (order, sum of the forces [N], torque [N m]) of the harmonics above rounding, by half orders from the
        mean on.
        """
        push = np.abs(gas.force_phasors(self.engine, self.peak, 2 * orders))
        torque = np.abs(np.fft.rfft(self.closed[1][:-1])) * 2 / 1440
        torque[0] /= 2
        rows = [(half / 2, float(push[half]), float(torque[half])) for half in range(2 * orders + 1)]
        return [row for row in rows if max(row[1:]) > ROTATING_PART_SHARE_MIN * self.peak]
