"""Balance shafts for engines with real dimensions, and the effect of their position and timing.

"lanchester": two shafts of order 2 that turn opposite ways on both sides of the crank, at its height; "raised": the
same, one higher and one lower such that they also take the 2x torque of the inertia; "first": one shaft of order 1 that
turns against the crank, and weights on the crank for what its counterweights leave. Unbalances follow from the closed
form of the engine (`engines.balance.shafts.balance`). What a fault of fitting leaves is known in closed form: a pair
that is late by phi ``2 sin(phi / 2)`` of the force that it should cancel, one that is d off its place the force times
d, as a couple (along the crank) or as a torque (aside). `left_in_space` is the same by the reaction of the whole engine
with its geared shafts.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from engines.balance import phasor, spatial
from engines.balance.pages.portrait import upright
from engines.balance.shafts import Shaft, balance, engine_load, remainder, with_shafts
from engines.nvh.excitation.presets import Preset
from mbsd3d.errors import InputError

KINDS = ("lanchester", "raised", "first")
REFERENCE_RPM = 1000.0  # [1/min] speed at which shafts are designed; the result does not depend on it
SHAFT_DISTANCE_RATIO = 1.6  # [1] of the crank radius: distance of a shaft from the crank
UNBALANCE_ROUNDING = 1e-9  # [1] of a piston on the crank radius, or [m]; smaller unbalances and heights are rounding


def fitted(preset: Preset, kind: str) -> list[Shaft]:
    """Return the shafts of a kind for an engine; raise ValueError for an unknown kind or an engine they cannot
    balance."""
    if kind not in KINDS:
        raise InputError(f"balance shafts '{kind}' are unknown; there are {', '.join(KINDS)}")
    engine = preset.engine(REFERENCE_RPM)
    load, z = phasor.block_load(engine, dyno=True), engine.stations
    planes = (float(z.min()), float(z.max())) if np.ptp(z) > 0 else (0.0,)
    across = SHAFT_DISTANCE_RATIO * engine.radius * upright(engine.layout)[1, :2]
    order = 1 if kind == "first" else 2
    places = {-1: tuple(-across), 1: (0.0, 0.0) if order == 1 else tuple(across)}
    wanted = [Shaft(order, direction, place, planes) for direction, place in places.items()]
    found = balance(engine, load, wanted, torque=kind == "raised")
    least = UNBALANCE_ROUNDING * preset.piston_mass * engine.radius
    found = [shaft for shaft in found if max(abs(u) for u in shaft.unbalance) > least]
    if not any(not shaft.on_crank for shaft in found):
        raise InputError(f"engine '{preset.name}' has no {order}x force or couple that {kind} shafts could take")
    if (
        kind == "raised"
        and np.ptp([upright(engine.layout)[2, :2] @ shaft.position for shaft in found]) < UNBALANCE_ROUNDING
    ):
        raise InputError(f"engine '{preset.name}' has no 2x force upwards, without which raised shafts help nothing")
    return found


@dataclass(frozen=True)
class Fault:
    """Wrong installation of shafts, counterweights of the crank excepted: ``title``; late by ``phase`` [rad]; ``moved``
    (3,) along the crank, to its left and up [m]; ``heavy``: share of too much unbalance; ``one``: only the first shaft.
    """

    title: str
    phase: float = 0.0
    moved: tuple[float, float, float] = (0.0, 0.0, 0.0)
    heavy: float = 0.0
    one: bool = False


TOOTH_ANGLE = 2 * np.pi / 40
FAULTS = (
    Fault("none"), Fault("all 1 degree late", phase=np.pi / 180), Fault("all a tooth of 40 late", phase=TOOTH_ANGLE),
    Fault("all 5 mm along", moved=(0.005, 0, 0)), Fault("all 5 mm aside", moved=(0, 0.005, 0)),
    Fault("one 5 mm aside", moved=(0, 0.005, 0), one=True), Fault("one 5 mm high", moved=(0, 0, 0.005), one=True),
    Fault("one 2 % heavy", heavy=0.02, one=True),
)  # fmt: skip


def faulty(preset: Preset, shafts: Sequence[Shaft], fault: Fault) -> list[Shaft]:
    """Return the shafts with a fault; a late shaft is turned back by the angle at its order, as seen from the crank."""
    found, (x, y, z) = list(shafts), upright(preset.layout).T @ fault.moved
    loose = [k for k, shaft in enumerate(shafts) if not shaft.on_crank]
    for k in loose[:1] if fault.one else loose:
        shaft = shafts[k]
        turn = (1 + fault.heavy) * np.exp(-1j * shaft.direction * fault.phase)
        found[k] = replace(
            shaft,
            position=(shaft.position[0] + x, shaft.position[1] + y),
            planes=tuple(plane + z for plane in shaft.planes),
            unbalance=tuple(u * turn for u in shaft.unbalance),
        )
    return found


def left(preset: Preset, shafts: Sequence[Shaft], rpm: float) -> np.ndarray:
    """Return the phasors of forces [N], couples and torque [N m] that engine and shafts leave at the order of the
    shafts, shape (5,).
    """
    engine = preset.engine(rpm)
    return remainder(engine, phasor.block_load(engine, dyno=True), shafts)


def left_in_space(preset: Preset, shafts: Sequence[Shaft], rpm: float) -> np.ndarray:
    """Return the same phasors from the reaction of the fixed block of the engine with its geared shafts in space."""
    engine = preset.engine(rpm)
    turn = spatial.turn(with_shafts(spatial.build(engine, driver="dyno"), engine, shafts), engine)
    return engine_load(spatial.harmonics(turn, engine), shafts[0].order)


def apart(preset: Preset, shafts: Sequence[Shaft], height: float) -> list[Shaft]:
    """Return a pair of shafts with the given distance in height about its middle [m]; raise ValueError for other
    shafts.
    """
    pair = [shaft for shaft in shafts if not shaft.on_crank]
    if len(pair) != 2 or len(shafts) != 2:
        raise InputError(f"engine '{preset.name}': {len(pair)} shafts have no height between them; give a pair")
    up = upright(preset.layout)[2, :2]
    heights = [np.array(shaft.position) @ up for shaft in pair]
    middle, way = sum(heights) / 2, 1.0 if heights[0] >= heights[1] else -1.0
    found = []
    for shaft, at, side in zip(pair, heights, (way, -way), strict=True):
        found.append(replace(shaft, position=tuple(np.array(shaft.position) + (middle + side * height / 2 - at) * up)))
    return found


def described(preset: Preset, shafts: Sequence[Shaft]) -> str:
    """Return unbalances and positions of the shafts in a line."""
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
