"""Balance shafts for engines with real dimensions, and what their place and timing do.

"lanchester": two shafts of order 2 that turn opposite ways on both sides of the crank, at its height; "raised": the
same, one higher and one lower such that they also take the 2x torque of the inertia; "first": one shaft of order 1 that
turns against the crank, and weights on the crank for what its counterweights leave. Unbalances follow from the closed
form of the engine (`engine_balance.shafts.balance`). A pair that is late by phi leaves ``2 sin(phi / 2)`` of the force
that it should cancel.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mbsd3d.errors import InputError
from validation.engine_balance import phasor
from validation.engine_balance.pages.portrait import upright
from validation.engine_balance.shafts import Shaft, balance, remainder
from validation.nvh.engine.presets import Preset

KINDS = ("lanchester", "raised", "first")
RPM = 1000.0
BESIDE = 1.6  # crank radii from the crank to a shaft
LEAST = 1e-9  # of a piston on the crank radius: smaller unbalances are rounding


def fitted(preset: Preset, kind: str) -> list[Shaft]:
    """The shafts of a kind for an engine; ValueError for an unknown kind, or an engine that they cannot help."""
    if kind not in KINDS:
        raise InputError(f"balance shafts '{kind}' are unknown; there are {', '.join(KINDS)}")
    engine = preset.engine(RPM)
    load, z = phasor.block_load(engine, dyno=True), engine.stations
    planes = (float(z.min()), float(z.max())) if np.ptp(z) > 0 else (0.0,)
    across = BESIDE * engine.radius * upright(engine.layout)[1, :2]
    order = 1 if kind == "first" else 2
    places = {-1: tuple(-across), 1: (0.0, 0.0) if order == 1 else tuple(across)}
    wanted = [Shaft(order, direction, place, planes) for direction, place in places.items()]
    found = balance(engine, load, wanted, torque=kind == "raised")
    least = LEAST * preset.piston_mass * engine.radius
    found = [shaft for shaft in found if max(abs(u) for u in shaft.unbalance) > least]
    if not any(not shaft.on_crank for shaft in found):
        raise InputError(f"engine '{preset.name}' has no {order}x force or couple that {kind} shafts could take")
    return found


def late(shafts: Sequence[Shaft], phase: float) -> list[Shaft]:
    """The shafts fitted late: their phasors, seen from the crank, turned back by an angle at their order [rad]."""
    return [
        replace(shaft, unbalance=tuple(u * np.exp(-1j * shaft.direction * phase) for u in shaft.unbalance))
        for shaft in shafts
    ]


def left(preset: Preset, shafts: Sequence[Shaft], rpm: float, phase: float = 0.0) -> tuple[float, float, float]:
    """Largest component of force [N], couple and torque [N m] of the shafts' order that is left if they are late."""
    engine = preset.engine(rpm)
    found = np.abs(remainder(engine, phasor.block_load(engine, dyno=True), late(shafts, phase)))
    return float(found[:2].max()), float(found[2:4].max()), float(found[4])


def described(preset: Preset, shafts: Sequence[Shaft]) -> str:
    """In a line: unbalances and places."""
    parts, R = [], upright(preset.layout)
    for shaft in shafts:
        grams = 1e6 * max(abs(u) for u in shaft.unbalance)
        weights = f"{grams:.0f} g mm" + (" at each end" if len(shaft.unbalance) > 1 else "")
        _, y, z = 1e3 * R[:, :2] @ shaft.position
        way = "with" if shaft.direction > 0 else "against"
        place = f"{y:.0f} mm beside and {z:.0f} mm above it"
        parts.append(
            f"{weights} on the crank" if shaft.on_crank else f"{shaft.order}x {way} the crank, {weights}, {place}"
        )
    return "; ".join(parts)
