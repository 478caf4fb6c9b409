"""Studies of one engine as tables: gas forces, balance shafts, rod ratio, the single cylinder with its weight."""

from dataclasses import replace

import numpy as np

from validation.spectrum import spectrum

from . import balance, gas, phasor, shafts, spatial, truth
from .harmonics import Harmonics
from .layouts import Engine
from .report import NOISE, Table, amplitudes, value

COUNT = 720  # samples of a turn with gas: its kinks fold back (order / COUNT)^2
LENGTHS = (1.5, 2.0, 3.0, 4.0)  # rod lengths over the crank radius
WAYS = {"forward": (1,), "backward": (-1,), "both": (1, -1)}


def gas_harmonics(engine: Engine, peak: float, orders: int = 6) -> Table:
    """Half sines of the gas: their sum in closed form, the torque on the crank, and what the block of the model feels.

    The torque is that of virtual power; M_z of the block and its largest other component are those of the spatial
    model on a dyno, with gas less without.
    """
    system, pulse = spatial.build(engine, driver="dyno"), gas.half_sine(peak)
    runs = [
        spatial.turn(model, engine, turns=2, count=COUNT)
        for model in (gas.with_gas(system, engine, pulse, COUNT), system)
    ]
    loads = [np.hstack(spatial.block_load(run)) for run in runs]
    torque = gas.torque(engine, pulse, engine.rate * runs[0].t)
    seen = spectrum(runs[0].t, np.column_stack([torque, loads[0] - loads[1]]), rate=engine.rate)
    push, found = np.abs(gas.force_phasors(engine, peak, 2 * orders)), []
    for half in range(2 * orders + 1):
        crank, *others, about = np.abs(seen.at(half / 2))
        cells = (value(x, NOISE * peak) for x in (push[half], crank, about, max(others)))
        found.append([f"{half / 2:g}x", *cells])
    return Table(["harmonic", "gas forces [N]", "torque [N m]", "block M_z [N m]", "block, other"], found)


def balance_shafts(engine: Engine) -> Table:
    """What counterweights and shafts in two planes leave of 1x and 2x, by theory, and how the spatial model differs."""
    load, noise = Harmonics(*phasor.block_load(engine)), NOISE * engine.single
    size, found = amplitudes(load), []
    for order in (1, 2):
        if max(size["force"][order], size["couple"][order]) < noise:
            continue
        for way in WAYS:
            wanted = shaft_set(engine, order, way)
            chosen = shafts.balance(engine, load, wanted)
            left = shafts.remainder(engine, load, chosen)
            model = shafts.with_shafts(spatial.build(engine), engine, chosen)
            seen = shafts.engine_load(spatial.harmonics(spatial.turn(model, engine), engine), order)
            weights = ", ".join(f"{abs(u):.4g}" for shaft in chosen for u in shaft.unbalance)
            before, after = (
                (np.abs(x[:2]).max(), np.abs(x[2:4]).max()) for x in (shafts.engine_load(load, order), left)
            )
            cells = (value(float(x), noise) for pair in zip(before, after, strict=True) for x in pair)
            found.append([f"{order}x {way}", *cells, f"{np.abs(seen - left).max():.0e}", weights])
    header = ["shafts", "force [N]", "left", "couple [N m]", "left", "spatial off by", "unbalances [kg m]"]
    return Table(header, found)


def shaft_set(engine: Engine, order: int, way: str) -> list[shafts.Shaft]:
    """A forward shaft (1x: counterweights on the crank) and a backward one beside it, weights at both ends."""
    z = engine.stations
    planes = (float(z.min()), float(z.max())) if np.ptp(z) > 0 else (0.0,)
    beside = 0.0 if order == 1 else engine.radius
    places = {1: (0.0, beside), -1: (0.0, -engine.radius)}
    return [shafts.Shaft(order, direction, places[direction], planes) for direction in WAYS[way]]


def rod_ratios(engine: Engine) -> Table:
    """Force and couple 2x over the rod length, three ways."""
    found = []
    for ratio in LENGTHS:
        longer = replace(engine, rod_length=ratio * engine.radius)
        sizes = [amplitudes(h) for h in balance.compare(longer).ways.values()]
        cells = [value(size[part][2], NOISE * engine.single) for part in ("force", "couple") for size in sizes]
        found.append([f"{1 / ratio:.4g}", *cells])
    header = [f"{part} {way}" for part in ("2x F", "2x M") for way in ("phasor", "planar", "spatial")]
    return Table(["R/L", *header], found)


def single_cylinder() -> Table:
    """The toy cylinder with and without weight and m w x (w x s): peaks over a turn."""
    found = []
    for weight in (False, True):
        for centripetal in (True, False):
            case = truth.single(weight, centripetal)
            torque, bearing = np.abs(case.torque), case.bearing
            angle = int(torque.argmax()) / 10
            name = f"{'with' if weight else 'no'} weight, {'all terms' if centripetal else 'no m w x (w x s)'}"
            cells = (f"{x:.4f}" for x in (torque.max(), bearing.min(), bearing.max()))
            found.append([name, *cells, f"{angle:g}"])
    header = ["single cylinder", "peak |T| [N m]", "bearing min [N]", "bearing max [N]", "peak at [degrees]"]
    return Table(header, found)
