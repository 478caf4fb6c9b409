"""Pictures of mechanisms, small enough that a hundred of them make a page that loads; convergence of engines as SVG.

Charts show the difference from our motion over the step, both logarithmic. They are drawn by hand: a hundred figures
of matplotlib would take longer than the engines, and ten times the space.
"""

import base64
import io
import math
from collections.abc import Callable, Sequence
from typing import Any

from mbsd3d.extend import house
from validation.crosscheck import Compared, CrossCheck, Curve
from validation.engine_balance.pages.drawings import stroke, svg, text
from validation.suite.trials.trial import Run

QUANTITIES = ("position", "rotation", "velocity", "energy", "reaction force")
"""The curves that are drawn; the others follow from them."""
WIDTH, HEIGHT, LEFT, BOTTOM, TOP = 300.0, 190.0, 46.0, 34.0, 22.0
LEAST = 1e-17  # Differences below it are drawn there: equal bits have no logarithm
Place = Callable[[float, float], complex]  # of a step and a difference
KEY = 18.0  # Height of the line that says which colour is what
SIZE, DOTS = (3.6, 2.7), 110  # inch, per inch
MOST = 40  # Bodies that can be told apart at this size


def picture(made: Run) -> str:
    """The mechanism at the end of its run as a data address; "" for more bodies than one can tell apart."""
    if len(made.system.bodies) > MOST:
        return ""
    figure = drawn(made)
    buffer = io.BytesIO()
    with house():
        figure.savefig(buffer, format="webp", dpi=DOTS, pil_kwargs={"quality": 70})
    return f"data:image/webp;base64,{base64.b64encode(buffer.getvalue()).decode()}"


def drawn(made: Run) -> Any:
    """A figure of the last sample, of the reference pose without one."""
    if made.solution is None:
        return made.system.picture(size=SIZE)
    last = made.solution.state(made.solution.t.size - 1)
    return made.system.picture(last, size=SIZE)


def chart(check: CrossCheck) -> str:
    """One panel per engine that ran, on common axes; "" where none ran."""
    ran = [engine for engine in check.engines if any(curve.quantity in QUANTITIES for curve in engine.curves)]
    if not ran:
        return ""
    box = bounds([curve for engine in ran for curve in engine.curves if curve.quantity in QUANTITIES])
    panels = [
        f'<g transform="translate({k * (WIDTH + 24):g} 0)">{panel(engine, *box)}</g>' for k, engine in enumerate(ran)
    ]
    width, label = 2 * (WIDTH + 24), f"convergence of {' and '.join(engine.engine for engine in ran)}"
    return str(svg(width, HEIGHT + KEY, "".join(panels) + key(), label))


def bounds(curves: Sequence[Curve]) -> tuple[int, int, int, int]:
    """Decades that hold all steps and differences."""
    steps = [math.log10(step) for curve in curves for step in curve.steps]
    sizes = [math.log10(max(size, LEAST)) for curve in curves for size in curve.differences]
    low, high = math.floor(min(sizes)), math.ceil(max(sizes))
    return math.floor(min(steps)), math.ceil(max(steps)), low, max(high, low + 1)


def panel(engine: Compared, first: int, last: int, low: int, high: int) -> str:
    """Axes, curves and the expected slope of one engine."""

    def place(step: float, size: float) -> complex:
        x = LEFT + (WIDTH - LEFT) * (math.log10(step) - first) / (last - first)
        y = HEIGHT - BOTTOM - (HEIGHT - BOTTOM - TOP) * (math.log10(max(size, LEAST)) - low) / (high - low)
        return complex(x, -y)

    every = max(1, (high - low) // 5)
    drawn = []
    for decade in range(low, high + 1, every):
        drawn.append(stroke("grid", place(10.0**first, 10.0**decade), place(10.0**last, 10.0**decade)))
        drawn.append(text(LEFT - 5, -place(10.0**first, 10.0**decade).imag + 3.5, f"1e{decade}", "end"))
    for decade in range(first, last + 1):
        drawn.append(stroke("grid", place(10.0**decade, 10.0**low), place(10.0**decade, 10.0**high)))
        drawn.append(text(place(10.0**decade, 1.0).real, HEIGHT - BOTTOM + 14, f"1e{decade}"))
    curves = [curve for curve in engine.curves if curve.quantity in QUANTITIES]
    drawn += [line(place, curve) for curve in curves]
    drawn.append(slope(place, engine, curves))
    drawn.append(text(LEFT, 12, f"{engine.engine}: relative difference [-] over step [s]", "start", "value"))
    return "".join(drawn)


def line(place: Place, curve: Curve) -> str:
    """A curve with a mark at every run."""
    tint = f"t{QUANTITIES.index(curve.quantity)}"
    points = [place(step, size) for step, size in zip(curve.steps, curve.differences, strict=True)]
    marks = "".join(f'<circle class="fill {tint}" cx="{z.real:.2f}" cy="{-z.imag:.2f}" r="2.4"/>' for z in points)
    return stroke(f"line {tint}", *points) + marks


def slope(place: Place, engine: Compared, curves: Sequence[Curve]) -> str:
    """The expected order, from the largest difference of the coarsest run on."""
    first = max(curve.differences[0] for curve in curves)
    if not engine.order or first <= 0.0:
        return ""
    least = min(max(size, LEAST) for curve in curves for size in curve.differences)
    coarse = curves[0].steps[0]
    fine = max(curves[0].steps[-1], coarse * (least / first) ** (1.0 / engine.order))  # not below the panel
    return stroke("ring muted", place(coarse, first), place(fine, first * (fine / coarse) ** engine.order))


def key() -> str:
    """Colours of the quantities, and what the dashes are."""
    parts, x = [], LEFT
    for k, quantity in enumerate((*QUANTITIES, "expected order")):
        kind = f"line t{k}" if k < len(QUANTITIES) else "ring muted"
        parts.append(stroke(kind, complex(x, -HEIGHT - 8), complex(x + 16, -HEIGHT - 8)))
        parts.append(text(x + 20, HEIGHT + 11.5, quantity, "start"))
        x += 30 + 5.6 * len(quantity)
    return "".join(parts)
