"""Benchmark in text and as a figure: times to an error, ratios, goals, growth, and the settings behind them."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from mbsd3d.errors import InputError
from mbsd3d.extend import GRID_WIDTH_POINTS, LINE_WIDTH_POINTS, Figure, figure_style, style_axes, theme
from validation.benchmark.candidates import CONSTRAINTS_LABEL, ENGINES, PEERS
from validation.benchmark.precision import TARGET_ERRORS, Point, Reached, Row, time_to

MIDDLE_ERROR = 1e-6  # [1] error of the goals
GROWTH_FAMILIES = ("chain", "ladder")
NOTES = (
    "ms of the time loop until the end pose is right to the error (distance over the model's length, angle in rad);",
    "> 5: still off after 5 ms, the longest run tried; < 5: the coarsest setting is right already; -: not compared.",
)


class Goal(NamedTuple):
    """Goal of a ratio: ``peer`` takes at least ``factor`` times as long as mbsd3d, on every problem that ``applies``.

    ``only`` keeps candidates of the peer with this word: its joints as constraints, as ours are.
    """

    text: str
    peer: str
    factor: float
    applies: Callable[[Row], bool]
    only: str = ""


class Verdict(NamedTuple):
    """Problem with the least ratio, and whether the goal is met; "open" where a bound does not decide."""

    goal: Goal
    problem: str
    ratio: float
    bound: str
    met: str


def family(name: str, least: int = 0, most: int = 10**9) -> Callable[[Row], bool]:
    """Return a test for problems of a family with a number of bodies."""
    return lambda row: row.family == name and least <= row.bodies <= most


GOALS = (
    *(Goal("loops", peer, 100.0, family("loop")) for peer in PEERS),
    Goal("tops", "MuJoCo", 20.0, family("top")),
    Goal("tops", "Exudyn", 200.0, family("top")),
    Goal("tops, by constraints", "Exudyn", 200.0, family("top"), CONSTRAINTS_LABEL),
    Goal("bicycle", "Exudyn", 50.0, family("bicycle")),
    Goal("free body", "MuJoCo", 10.0, family("free body")),
    Goal("free body", "Exudyn", 2.0, family("free body")),
    Goal("chains up to 30", "MuJoCo", 0.5, family("chain", most=30)),
    Goal("chains from 150", "MuJoCo", 1.0, family("chain", least=150)),
)


def verdicts(rows: Sequence[Row]) -> list[Verdict]:
    """Return the assessment of all goals of which a problem was measured."""
    found = []
    for goal in GOALS:
        ratios = [(row.ratio(goal.peer, MIDDLE_ERROR, goal.only), row.name) for row in rows if goal.applies(row)]
        known = [(value, bound, name) for ratio, name in ratios if ratio for value, bound in [ratio]]
        if not known:
            continue
        ratio, bound, name = min(known)
        found.append(Verdict(goal, name, ratio, bound, judge(ratio, bound, goal.factor)))
    return found


def judge(ratio: float, bound: str, factor: float) -> str:
    """Return "met", "MISSED", or "open" where the ratio is a bound on the wrong side of the factor."""
    if ratio >= factor:
        return "open" if bound == "<" else "met"
    return "open" if bound == ">" else "MISSED"


def growth(rows: Sequence[Row], engine: str, prefix: str) -> tuple[float, int, int] | None:
    """Return (p, least, most) of time ~ bodies^p at the middle error, over problems named "prefix n", from 30 bodies
    on.
    """
    found = []
    for row in rows:
        reached = (
            row.reached(engine, MIDDLE_ERROR) if row.name.rsplit(" ", 1)[0] == prefix and row.bodies >= 30 else None
        )
        if reached is not None and not reached.bound:
            found.append((row.bodies, reached.seconds))
    if len(found) < 2:
        return None
    bodies, seconds = np.array(sorted(found), float).T
    return float(np.polyfit(np.log(bodies), np.log(seconds), 1)[0]), int(bodies[0]), int(bodies[-1])


def milliseconds(reached: Reached | None) -> str:
    """Format a time [ms] with its bound, in three digits."""
    if reached is None:
        return "-"
    digits = f"{1e3 * reached.seconds:.3g}"
    return f"{reached.bound}{float(digits):.0f}" if "e" in digits else f"{reached.bound}{digits}"


def times(rows: Sequence[Row]) -> list[str]:
    """Tabulate the times of all engines to all errors, and ratios at the middle one."""
    head = "".join(f"{engine:>{9 * len(TARGET_ERRORS)}}" for engine in ENGINES)
    errors = "".join(f"{target:>9.0e}" for target in TARGET_ERRORS) * len(ENGINES)
    said = [*NOTES, "", f"{'':18}{head}   ratio at {MIDDLE_ERROR:.0e}", f"{'':18}{errors}{'MuJoCo':>10}{'Exudyn':>10}"]
    for row in rows:
        cells = [milliseconds(row.reached(engine, target)) for engine in ENGINES for target in TARGET_ERRORS]
        said.append(f"{row.name:18}" + "".join(f"{cell:>9}" for cell in cells) + ratios(row))
    return said


def ratios(row: Row) -> str:
    """Return the ratios of both peers at the middle error as text."""
    found = [row.ratio(peer, MIDDLE_ERROR) for peer in PEERS]
    return "".join(f"{'-' if ratio is None else f'{ratio[1]}{ratio[0]:.3g}':>10}" for ratio in found)


def chosen(rows: Sequence[Row]) -> list[str]:
    """Return lines on the best candidate of each peer at the middle error, of how many, and the error of its limit."""
    said = [f"best of each peer at {MIDDLE_ERROR:.0e}, of how many; least error found"]
    for row in rows:
        for peer in PEERS:
            reached, tried = row.reached(peer, MIDDLE_ERROR), row.of(peer)
            if reached is None:
                why = next((climbed.note for climbed in tried if climbed.note), "it has no candidate")
                said.append(f"  {row.name:18}{peer:8}not compared: {why}")
                continue
            said.append(f"  {row.name:18}{peer:8}{reached.label}  ({len(tried)} tried; {row.agreement(peer):.0e})")
    return said


def judged(rows: Sequence[Row]) -> list[str]:
    """Return lines on goals and growth."""
    said = [f"{'goal: times as long at ' + format(MIDDLE_ERROR, '.0e'):44}{'aim':>7}{'least':>9}"]
    for goal, name, ratio, bound, met in verdicts(rows):
        said.append(
            f"{goal.text + ', ' + goal.peer:44}{goal.factor:7g}{bound + format(ratio, '.3g'):>9}  {met}: {name}"
        )
    for prefix in GROWTH_FAMILIES:
        for engine in ENGINES:
            found = growth(rows, engine, prefix)
            if found:
                said.append(f"{prefix}: time of {engine} ~ bodies^{found[0]:.2f} from {found[1]} to {found[2]} bodies")
    return said


def every(rows: Sequence[Row]) -> list[str]:
    """Tabulate every candidate with its time to the middle error."""
    said = [f"all candidates: ms until {MIDDLE_ERROR:.0e}, settings that failed"]
    for row in rows:
        for climbed in row.climbs:
            time = milliseconds(time_to(climbed, MIDDLE_ERROR)) if climbed.points else f" not compared: {climbed.note}"
            failed = f"  ({climbed.failed} failed: {climbed.note[:60]})" if climbed.failed and climbed.points else ""
            said.append(f"  {row.name:18}{climbed.engine:8}{climbed.label:66}{time:>9}{failed}")
    return said


def report(rows: Sequence[Row]) -> list[str]:
    """Return the whole report."""
    return [*times(rows), "", *judged(rows), "", *chosen(rows), "", *every(rows)]


FIGURE_PROBLEMS = (
    "free body", "top fast", "bicycle M1", "Bricard", "Andrews", "four-bar 2", "four-bar 40", "Stewart platform",
    "arm 6R", "chain 10", "chain 100", "chain 300",
)  # fmt: skip
FIGURE_COLUMNS = 4
ERROR_RANGE = (1e-10, 1e-1)  # [1] of the axes
MARKS = {"mbsd3d": "o", "MuJoCo": "s", "Exudyn": "^"}


def front(row: Row, engine: str) -> list[Point]:
    """Return the points of all candidates of an engine that none of its others beats in both time and error."""
    points = sorted((p for climbed in row.of(engine) for p in climbed.points), key=lambda p: (p.seconds, p.error))
    found: list[Point] = []
    for point in points:
        if not found or point.error < found[-1].error:
            found.append(point)
    return found


def work_precision(rows: Sequence[Row], dark: bool = False) -> Figure:
    """Plot the best candidates of each engine, error over time; down and left is better.

    ValueError if none of the problems it shows was measured.
    """
    shown = sorted(
        (row for row in rows if row.name in FIGURE_PROBLEMS), key=lambda row: FIGURE_PROBLEMS.index(row.name)
    )
    if not shown:
        raise InputError(f"none of {', '.join(FIGURE_PROBLEMS)} was measured; measure one with --mechanism")
    look = theme(dark)
    count = -(-len(shown) // FIGURE_COLUMNS)
    columns = min(FIGURE_COLUMNS, len(shown))
    with figure_style(look):
        figure = Figure(figsize=(2.9 * columns + 0.4, 2.6 * count + 0.5), layout="constrained", facecolor=look.paper)
        grid, lines = figure.subplots(count, columns, sharey=True, squeeze=False).ravel(), dict[str, Any]()
        for k, (axes, row) in enumerate(zip(grid, shown, strict=False)):
            panel(axes, row, look)
            lines = {line.get_label(): line for line in axes.get_legend_handles_labels()[0]} | lines
            if k % columns == 0:
                axes.set_ylabel("error at the end [-]")
            if k + columns >= len(shown):
                axes.set_xlabel("wall time")
        for axes in grid[len(shown) :]:
            axes.set_visible(False)
        names = [engine for engine in ENGINES if engine in lines]
        figure.legend(
            [lines[name] for name in names], names, loc="outside upper center", ncols=len(names), frameon=False,
            labelcolor=look.ink,
        )  # fmt: skip
    return figure


def seconds_text(x: float, place: Any = None) -> str:
    """Format seconds as "10 ms"."""
    return f"{1e3 * x:g} ms" if x < 1.0 else f"{x:g} s"


def panel(axes: Any, row: Row, look: Any) -> None:
    """Draw the panel of one problem."""
    for k, engine in enumerate(ENGINES):
        points = [point for point in front(row, engine) if point.error <= ERROR_RANGE[1]]
        if points:
            seconds, errors = [p.seconds for p in points], [max(p.error, ERROR_RANGE[0]) for p in points]
            axes.plot(
                seconds, errors, color=look.colour(k), linewidth=LINE_WIDTH_POINTS, marker=MARKS[engine],
                markersize=3.5, label=engine,
            )  # fmt: skip
    axes.axhline(MIDDLE_ERROR, color=look.muted, linewidth=GRID_WIDTH_POINTS, linestyle="--")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_ylim(*ERROR_RANGE)
    low, high = axes.get_xlim()
    axes.set_xlim(10 ** np.floor(np.log10(low)), 10 ** np.ceil(np.log10(high)))  # whole decades, each labelled
    axes.xaxis.set_major_formatter(seconds_text)
    axes.yaxis.set_major_formatter("{x:.0e}")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_minor_formatter("")
    axes.tick_params(labelsize="small")
    axes.set_title(row.name)
    style_axes(axes, look)
