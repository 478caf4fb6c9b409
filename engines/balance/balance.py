"""Comparison of one engine by three methods: closed form, sum of planar models, whole engine in space."""

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from engines.balance import phasor, planar_sum, spatial
from engines.balance.harmonics import Harmonics
from engines.balance.layouts import Engine

DISAGREEMENT_MAX = 1e-9  # [1] of the scale; rounding of models with up to 26 bodies stays below 1e-12


@dataclass(frozen=True)
class Comparison:
    """Harmonics of one engine by three methods that share no equation."""

    engine: Engine
    ways: dict[str, Harmonics]
    """"phasor", "planar", "spatial"."""
    gravity: tuple[float, float] = (0.0, 0.0)  # In the plane of the cylinders [m/s^2]
    driver: str = "block"
    """Where the driving torque reacts, "block" or "dyno"."""

    @property
    def scale(self) -> float:
        """Return the sum of F_single and the weight of a cylinder [N], the scale of rounding even at low crank
        speed."""
        return self.engine.single + phasor.mass(self.engine) * float(np.linalg.norm(self.gravity))

    @property
    def disagreement(self) -> float:
        """Return the largest difference of two methods in any order and component over the scale; moments over the
        spacing.
        """
        pairs = combinations(self.ways.values(), 2)
        return max(one.difference(other, self.engine.spacing) for one, other in pairs) / self.scale

    @property
    def agrees(self) -> bool:
        """Return whether all three methods agree within `DISAGREEMENT_MAX`."""
        return self.disagreement <= DISAGREEMENT_MAX


def compare(engine: Engine, orders: int = 6, *, gravity: Any = (0.0, 0.0), driver: str = "block") -> Comparison:
    """Compute the harmonics 0 ... ``orders`` of block load and driving torque by three methods.

    ``engine``: of identical, centred cylinders; ``gravity`` (2,): in the plane of the cylinders [m/s^2]; ``driver``:
    where the driving torque reacts, "block" or "dyno". ValueError for an engine without the closed form, or at rpm 0.
    """
    dyno = driver == "dyno"
    system = spatial.build(engine, driver=driver, gravity=(*gravity, 0.0))
    turn = spatial.turn(system, engine, count=engine.samples(orders))
    ways = {
        "phasor": phasor.block_load(engine, orders, gravity=gravity, dyno=dyno),
        "planar": planar_sum.harmonics(engine, orders, gravity=gravity, dyno=dyno),
        "spatial": spatial.harmonics(turn, engine, orders),
    }
    return Comparison(engine, ways, tuple(gravity), driver)
