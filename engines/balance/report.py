"""Tables of engine balance as header and rows of text, for the command line and for pages; studies of one engine."""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from engines.balance import gas, phasor, shafts, spatial
from engines.balance.balance import Comparison, compare
from engines.balance.harmonics import Harmonics, half_axes
from engines.balance.layouts import Engine, names
from engines.balance.published.claims import Row
from engines.balance.published.truth import single
from mbsd3d import spectrum

AMPLITUDE_ROUNDING = 1e-9  # [1] of F_single and weight; smaller amplitudes are rounding and shown as 0
WORD_COLUMNS = {
    "layout",
    "harmonic",
    "turning",
    "unit",
    "figure",
    "verdict",
    "shafts",
    "single cylinder",
    "unbalances [kg m]",
}
PUBLISHED = {
    ("single", "force", 1): 9.87, ("single", "force", 2): 4.111, ("single", "force", 4): 0.295,
    ("I3", "couple", 1): 1.71, ("I4", "force", 2): 16.44, ("I4", "force", 4): 1.18,
    ("V8_flat", "force", 2): 23.26, ("V8_flat", "force", 4): 1.67, ("V8_cross_in_sequence", "force", 4): 1.67,
    ("V8_cross_in_sequence", "couple", 1): 2.79, ("V8_cross_in_sequence", "couple", 2): 1.16,
    ("flat4_shared_face_to_face", "couple", 1): 3.95, ("flat4_shared_face_to_face", "couple", 2): 0.0,
    ("boxer4_face_to_face", "couple", 1): 0.0, ("boxer4_face_to_face", "couple", 2): 0.0,
}  # fmt: skip
"""Published amplitudes of the toy engine; the truth table says what is wrong with some of them."""
GAS_TURN_SAMPLES = 720  # [1] samples of a turn with gas; the kinks of the gas force alias as (order / count)^2
ROD_LENGTH_RATIOS = (1.5, 2.0, 3.0, 4.0)  # [1] rod lengths over the crank radius
WAYS = {"forward": (1,), "backward": (-1,), "both": (1, -1)}


class Table(NamedTuple):
    """Header and rows, all text."""

    header: list[str]
    rows: list[list[str]]

    def __str__(self) -> str:
        """Return the table with aligned columns; words to the left, numbers to the right."""
        lines = [self.header, *self.rows]
        widths = [max(len(line[k]) for line in lines) for k in range(len(self.header))]
        sides = [str.ljust if name in WORD_COLUMNS else str.rjust for name in self.header]
        return "\n".join(
            "  ".join(side(cell, width) for side, cell, width in zip(sides, line, widths, strict=True)).rstrip()
            for line in lines
        )

    @property
    def filled(self) -> "Table":
        """Return the table without empty columns."""
        kept = [k for k in range(len(self.header)) if any(row[k] for row in self.rows)]
        return Table([self.header[k] for k in kept], [[row[k] for k in kept] for row in self.rows])


def amplitudes(h: Harmonics) -> dict[str, np.ndarray]:
    """Return the amplitudes of force and couple (long half axes), torque reaction and driving torque, (orders + 1,)
    each.
    """
    turned = [half_axes(h.forward[:, k], h.backward[:, k])[0] for k in (0, 1)]
    return dict(force=turned[0], couple=turned[1], reaction=np.abs(h.moment[:, 2]), torque=np.abs(h.torque))


def value(x: float | None, noise: float = AMPLITUDE_ROUNDING) -> str:
    """Format a value: six digits, nothing for None, 0 for rounding."""
    return "" if x is None else "0" if abs(x) < noise else f"{x:.6g}"


def ways(comparison: Comparison) -> Table:
    """Tabulate every order and quantity by three methods and as published, without rows of zeros that are not
    published.

    Force and couple are long half axes; figures were published for the toy engine only.
    """
    engine = comparison.engine
    toy = engine == Engine(engine.layout.name) if engine.layout.name in names() else False
    found, noise = [], AMPLITUDE_ROUNDING * comparison.scale
    every = {way: amplitudes(h) for way, h in comparison.ways.items()}
    for quantity, unit in (("force", "N"), ("couple", "N m"), ("reaction", "N m"), ("torque", "N m")):
        for order in range(1, every["phasor"][quantity].size):
            cells = [value(parts[quantity][order], noise) for parts in every.values()]
            figure = PUBLISHED.get((engine.layout.name, quantity, order)) if toy else None
            if set(cells) != {"0"} or figure is not None:
                known = "" if figure is None else f"{figure:g}"
                found.append([engine.layout.name, f"{order}x {quantity}", unit, *cells, known])
    return Table(["layout", "harmonic", "unit", *every, "published"], found)


def components(comparison: Comparison) -> Table:
    """Tabulate the amplitudes of the components of the block load by three methods, and their largest difference."""
    noise, found = AMPLITUDE_ROUNDING * comparison.scale, []
    names = ("F_x", "F_y", "F_z", "M_x", "M_y", "M_z", "T")
    for order in range(1, len(comparison.ways["phasor"].torque)):
        stacked = [np.array([*h.force[order], *h.moment[order], h.torque[order]]) for h in comparison.ways.values()]
        for k, name in enumerate(names):
            cells = [value(abs(c[k]), noise) for c in stacked]
            spread = max(abs(a[k] - b[k]) for a in stacked for b in stacked)
            found.append([f"{order}x {name}", "N" if name[0] == "F" else "N m", *cells, f"{spread:.1e}"])
    return Table(["harmonic", "unit", *comparison.ways, "spread"], found)


def turning(comparison: Comparison) -> Table:
    """Tabulate forces and couples as vectors that turn with and against the crank, and their ellipse."""
    noise, h, found = AMPLITUDE_ROUNDING * comparison.scale, comparison.ways["spatial"], []
    for order in range(1, len(h.torque)):
        for k, (name, unit) in enumerate((("force", "N"), ("couple", "N m"))):
            forward, backward = np.abs(h.forward[order, k]), np.abs(h.backward[order, k])
            parts = (forward, backward, *half_axes(forward, backward))
            found.append([f"{order}x {name}", unit, *(value(float(x), noise) for x in parts)])
    return Table(["turning", "unit", "forward", "backward", "long axis", "short axis"], found)


def overview(comparisons: Sequence[Comparison]) -> Table:
    """Tabulate what is not balanced, one line per layout."""
    header = "layout,F 1x,F 2x,F 4x,F 6x,M 1x fwd,M 1x bwd,M 2x fwd,M 2x bwd,T ripple,spread".split(",")
    found = []
    for comparison in comparisons:
        h, noise = comparison.ways["spatial"], AMPLITUDE_ROUNDING * comparison.scale
        size = amplitudes(h)
        order = 1 + int(np.argmax(np.round(size["torque"][1:], 9)))
        parts = [size["force"][n] for n in (1, 2, 4, 6)]
        parts += [np.abs(part[n, 1]) for n in (1, 2) for part in (h.forward, h.backward)]
        ripple = value(size["torque"][order], noise)
        cells = [value(float(x), noise) for x in parts]
        ripple = ripple if ripple == "0" else f"{ripple} ({order}x)"
        found.append([comparison.engine.layout.name, *cells, ripple, f"{comparison.disagreement:.0e}"])
    return Table(header, found)


def truth(rows: Sequence[Row]) -> Table:
    """Tabulate published, assumed and actual figures, under a heading for each source."""
    found, source = [], None
    for row in rows:
        if row.source != source:
            source = row.source
            found.append([source, *5 * [""]])
        pair = row.actual if isinstance(row.actual, tuple) else (row.actual,)
        actual = " ... ".join(map(value, pair))
        found.append([f"  {row.what}", row.unit, value(row.published), value(row.assumed), actual, row.verdict])
    return Table(["figure", "unit", "published", "assumed", "actual", "verdict"], found)


def gas_harmonics(engine: Engine, peak: float, orders: int = 6) -> Table:
    """Tabulate half sines of the gas: their sum in closed form, the torque on the crank, and the load on the block of
    the model.

    The torque follows from virtual power; M_z of the block and its largest other component come from the spatial
    model on a dyno, with gas less without.
    """
    system, pulse = spatial.build(engine, driver="dyno"), gas.half_sine(peak)
    runs = [
        spatial.turn(model, engine, turns=2, count=GAS_TURN_SAMPLES)
        for model in (gas.with_gas(system, engine, pulse, GAS_TURN_SAMPLES), system)
    ]
    loads = [np.hstack(spatial.block_load(run)) for run in runs]
    torque = gas.torque(engine, pulse, engine.rate * runs[0].t)
    seen = spectrum(runs[0].t, np.column_stack([torque, loads[0] - loads[1]]), rate=engine.rate)
    push, found = np.abs(gas.force_phasors(engine, peak, 2 * orders)), []
    for half in range(2 * orders + 1):
        crank, *others, about = np.abs(seen.at(half / 2))
        cells = (value(x, AMPLITUDE_ROUNDING * peak) for x in (push[half], crank, about, max(others)))
        found.append([f"{half / 2:g}x", *cells])
    return Table(["harmonic", "gas forces [N]", "torque [N m]", "block M_z [N m]", "block, other"], found)


def balance_shafts(engine: Engine) -> Table:
    """Tabulate the remainder of 1x and 2x with counterweights and shafts in two planes, by theory and in the spatial
    model.
    """
    load, noise = phasor.block_load(engine), AMPLITUDE_ROUNDING * engine.single
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
            every = np.abs([u for shaft in chosen for u in shaft.unbalance])
            weights = ", ".join(f"{u:.4g}" for u in np.where(every < noise / engine.rate**2, 0.0, every))
            before, after = (
                (np.abs(x[:2]).max(), np.abs(x[2:4]).max()) for x in (shafts.engine_load(load, order), left)
            )
            cells = (value(float(x), noise) for pair in zip(before, after, strict=True) for x in pair)
            found.append([f"{order}x {way}", *cells, f"{np.abs(seen - left).max():.0e}", weights])
    header = ["shafts", "force [N]", "left", "couple [N m]", "left", "spatial off by", "unbalances [kg m]"]
    return Table(header, found)


def shaft_set(engine: Engine, order: int, way: str) -> list[shafts.Shaft]:
    """Return a forward shaft (1x: counterweights on the crank) and a backward one beside it, weights at both ends."""
    z = engine.stations
    planes = (float(z.min()), float(z.max())) if np.ptp(z) > 0 else (0.0,)
    beside = 0.0 if order == 1 else engine.radius
    places = {1: (0.0, beside), -1: (0.0, -engine.radius)}
    return [shafts.Shaft(order, direction, places[direction], planes) for direction in WAYS[way]]


def rod_ratios(engine: Engine) -> Table:
    """Tabulate force and couple 2x over the rod length by three methods."""
    found = []
    for ratio in ROD_LENGTH_RATIOS:
        longer = replace(engine, rod_length=ratio * engine.radius)
        sizes = [amplitudes(h) for h in compare(longer).ways.values()]
        cells = [
            value(size[part][2], AMPLITUDE_ROUNDING * engine.single) for part in ("force", "couple") for size in sizes
        ]
        found.append([f"{1 / ratio:.4g}", *cells])
    header = [f"{part} {way}" for part in ("2x F", "2x M") for way in ("phasor", "planar", "spatial")]
    return Table(["R/L", *header], found)


def single_cylinder() -> Table:
    """Tabulate peaks over a turn of the toy cylinder with and without weight and m w x (w x s)."""
    found = []
    for weight in (False, True):
        for centripetal in (True, False):
            case = single(weight, centripetal)
            torque, bearing = np.abs(case.torque), case.bearing
            angle = int(torque.argmax()) / 10
            name = f"{'with' if weight else 'no'} weight, {'all terms' if centripetal else 'no m w x (w x s)'}"
            cells = (f"{x:.4f}" for x in (torque.max(), bearing.min(), bearing.max()))
            found.append([name, *cells, f"{angle:g}"])
    header = ["single cylinder", "peak |T| [N m]", "bearing min [N]", "bearing max [N]", "peak at [degrees]"]
    return Table(header, found)
