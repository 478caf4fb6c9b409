"""Balance shafts: unbalanced weights that turn k times as fast as the crank, with it or against it.

A shaft through (x, y) along z carries in the planes z_j the unbalances U_j [kg m], complex: |U_j| = mass times
eccentricity, arg U_j its direction at q = 0 from x towards y. At ``s k w``, s = +1 forward or -1 backward, the block
feels the phasors of order k (c_n means Re(c_n exp(i n q)))

    forward:  X = (k w)^2 U, Y = -i X;      backward:  X = (k w)^2 conj(U), Y = i X;
    M = sum_j (-z_j Y_j, z_j X_j, x Y_j - y X_j)

which is linear in U (forward) or conj U (backward): `balance` finds the unbalances by least squares. A shaft of order 1
that turns forward about the crank axis is a pair of counterweights, bolted to the crank.
Weight is left out: under gravity g an unbalance adds a moment of up to U g at the order of its shaft.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from engines.balance import looks
from engines.balance.harmonics import Harmonics
from engines.balance.layouts import Engine
from engines.balance.spatial import Z
from mbsd3d import Body, Fixed, Gear, Joint, Revolute, System, inertia
from mbsd3d.errors import InputError

# [1] of the largest singular value of the shafts' loads; smaller directions stay unbalanced
SINGULAR_VALUE_RATIO_MIN = 1e-10


@dataclass(frozen=True)
class Shaft:
    """A balance shaft.

    ``order``: k >= 1, its speed over that of the crank; ``direction``: +1 turns with the crank, -1 against it;
    ``position`` (2,): (x, y) of its axis [m]; ``planes`` (p,): z of its weights [m]; ``unbalance`` (p,) complex: of
    each weight at q = 0 [kg m]; zeros until `balance` has found them. ValueError for an impossible order or direction,
    or unequal numbers of planes and unbalances.
    """

    order: int
    direction: int
    position: tuple[float, float] = (0.0, 0.0)
    planes: tuple[float, ...] = (0.0,)
    unbalance: tuple[complex, ...] = ()

    def __post_init__(self) -> None:
        if self.order < 1 or self.order != int(self.order) or self.direction not in (1, -1):
            raise InputError(
                f"shaft of order {self.order}, direction {self.direction}: "
                "the order is a whole number from 1 on, the direction +1 (with the crank) or -1"
            )
        unbalance = self.unbalance or (0j,) * len(self.planes)
        if not self.planes or len(unbalance) != len(self.planes):
            raise InputError(f"shaft: {len(self.planes)} planes, {len(unbalance)} unbalances; give one for each plane")
        object.__setattr__(self, "unbalance", tuple(complex(u) for u in unbalance))

    @property
    def on_crank(self) -> bool:
        """Return whether the shaft is the counterweights of the crank."""
        return self.order == 1 and self.direction == 1 and not any(self.position)

    @property
    def pulls(self) -> bool:
        """Return whether the shaft exerts a force; a shaft with a couple alone does so wherever its axis lies."""
        return abs(sum(self.unbalance)) > SINGULAR_VALUE_RATIO_MIN * sum(map(abs, self.unbalance))


def unit_loads(shaft: Shaft, rate: float) -> np.ndarray:
    """Return the phasors of X, Y, M_x, M_y, M_z of order k for 1 kg m at angle 0 in each plane, shape (planes, 5)."""
    x, y = shaft.position
    X, z = (shaft.order * rate) ** 2, np.array(shaft.planes)
    Y = -1j * shaft.direction * X
    one = np.ones(z.size)
    return np.stack([X * one, Y * one, -z * Y, z * X, (x * Y - y * X) * one], axis=-1)


def load(shaft: Shaft, rate: float) -> np.ndarray:
    """Return the phasors of X, Y [N], M_x, M_y, M_z [N m] of a shaft on the block at its order, shape (5,)."""
    u = np.array(shaft.unbalance)
    return (u if shaft.direction > 0 else u.conj()) @ unit_loads(shaft, rate)


def engine_load(harmonics: Harmonics, order: int) -> np.ndarray:
    """Return the phasors of the block load to be balanced, shape (5,)."""
    return np.concatenate([harmonics.force[order, :2], harmonics.moment[order]])


def balance(engine: Engine, harmonics: Harmonics, shafts: Sequence[Shaft], *, torque: bool = False) -> list[Shaft]:
    """Return the shafts with the unbalances that leave the least force and couple of one harmonic.

    ``engine``: its spacing weighs couples against forces where not both can vanish; ``harmonics``: block load of the
    engine alone; ``shafts``: all of one order; ``torque``: true also moves the axes, as little as possible, so that the
    shafts that bear forces balance the torque reaction M_z, too. ValueError if the orders differ or lie beyond the
    harmonics.
    """
    orders = sorted({shaft.order for shaft in shafts})
    if len(orders) != 1 or orders[0] >= len(harmonics.force):
        raise InputError(
            f"balance: shafts of orders {orders}, harmonics up to {len(harmonics.force) - 1}; "
            "balance one order at a time, and ask for enough harmonics"
        )
    weight = np.array([1.0, 1.0, 1.0 / engine.spacing, 1.0 / engine.spacing])
    columns = np.concatenate([unit_loads(shaft, engine.rate)[:, :4] for shaft in shafts]) * weight
    target = engine_load(harmonics, orders[0])[:4] * weight
    found = np.linalg.lstsq(columns.T, -target, rcond=SINGULAR_VALUE_RATIO_MIN)[0]
    parts = np.split(found, np.cumsum([len(shaft.planes) for shaft in shafts])[:-1])
    balanced = [
        replace(shaft, unbalance=tuple(u if shaft.direction > 0 else u.conj()))
        for shaft, u in zip(shafts, parts, strict=True)
    ]
    return moved(engine, harmonics, balanced) if torque else balanced


def moved(engine: Engine, harmonics: Harmonics, shafts: Sequence[Shaft]) -> list[Shaft]:
    """Return the shafts shifted as little as possible so that M_z of their order vanishes; counterweights and pure
    couples stay.

    M_z = sum (x Y - y X) is linear in the places of the axes; forces and couples do not depend on them.
    """
    if not (free := [shaft for shaft in shafts if shaft.pulls and not shaft.on_crank]):
        return list(shafts)
    loads = np.array([load(shaft, engine.rate) for shaft in free])
    columns = np.stack([loads[:, 1], -loads[:, 0]], axis=1).ravel()
    left = remainder(engine, harmonics, shafts)[4]
    shift = np.linalg.lstsq(
        np.stack([columns.real, columns.imag]), -np.array([left.real, left.imag]), rcond=SINGULAR_VALUE_RATIO_MIN
    )[0]
    steps = iter(shift.reshape(-1, 2))
    return [
        replace(shaft, position=tuple((np.array(shaft.position) + next(steps)).tolist())) if shaft in free else shaft
        for shaft in shafts
    ]


def remainder(engine: Engine, harmonics: Harmonics, shafts: Sequence[Shaft]) -> np.ndarray:
    """Return the phasors of X, Y, M_x, M_y, M_z that engine and shafts leave at the order of the shafts, shape (5,)."""
    return engine_load(harmonics, shafts[0].order) + sum(load(shaft, engine.rate) for shaft in shafts)


def with_shafts(system: System, engine: Engine, shafts: Sequence[Shaft]) -> System:
    """Add the shafts to the engine of `spatial.build`: each on a hinge in the block, geared to the crank.

    Counterweights are fixed to the crank. Bodies are "shaft 1" ..., joints "shaft bearing 1", "gear 1" or "bolt 1" ...
    """
    block, crank = (system.part(name, "bodies") for name in ("block", "crank"))
    main = system.part("main 1", "joints")
    bodies: list[Body] = []
    joints: list[Joint] = []
    for i, shaft in enumerate(shafts, start=1):
        bodies.append(body(engine, shaft, f"shaft {i}"))
        at = (*shaft.position, 0.0)
        if shaft.on_crank:
            joints.append(Fixed(crank, bodies[-1], at=at, name=f"bolt {i}"))
            continue
        hinge = Revolute(block, bodies[-1], at=at, axis=Z, name=f"shaft bearing {i}")
        joints += [hinge, Gear(main, hinge, ratio=shaft.direction * shaft.order, name=f"gear {i}")]
    return replace(system, bodies=[*system.bodies, *bodies], joints=[*system.joints, *joints])


def body(engine: Engine, shaft: Shaft, name: str) -> Body:
    """Return a light shaft with a weight in each plane at a tenth of the crank radius, of the mass its unbalance
    needs."""
    arm = 0.1 * engine.radius
    parts = [(1e-3, np.zeros(3), 3 * (1e-3 * arm**2,))]
    for z, u in zip(shaft.planes, shaft.unbalance, strict=True):
        mass, at = abs(u) / arm, arm * np.array([np.cos(np.angle(u)), np.sin(np.angle(u)), 0.0])
        parts.append((mass, at + (0, 0, z), 3 * (0.2 * mass * arm**2,)))
    whole = inertia.combine(parts)
    shape = looks.shaft(engine, np.array(shaft.planes), np.angle(shaft.unbalance))
    return Body(name, whole.mass, whole.inertia, com=whole.com, position=(*shaft.position, 0.0), shape=shape)
