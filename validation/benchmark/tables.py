"""The benchmark in text: times to an error, ratios, goals, growth, and the settings behind them."""

from collections.abc import Sequence

from .candidates import PEERS
from .goals import MIDDLE, growth, verdicts
from .ladders import TARGETS, Reached, time_to
from .precision import Row

ENGINES = ("mbsd3d", *PEERS)
GROWING = ("chain", "ladder")
NOTES = (
    "ms of the time loop until the end pose is right to the error (distance over the model's length, angle in rad);",
    "> 5: still off after 5 ms, the longest run tried; < 5: the coarsest setting is right already; -: not compared.",
)


def milliseconds(reached: Reached | None) -> str:
    """A time with its bound."""
    return "-" if reached is None else f"{reached.bound}{1e3 * reached.seconds:.3g}"


def times(rows: Sequence[Row]) -> list[str]:
    """Times of all engines to all errors, and ratios at the middle one."""
    head = "".join(f"{engine:>{9 * len(TARGETS)}}" for engine in ENGINES)
    errors = "".join(f"{target:>9.0e}" for target in TARGETS) * len(ENGINES)
    said = [*NOTES, "", f"{'':18}{head}   ratio at {MIDDLE:.0e}", f"{'':18}{errors}{'MuJoCo':>10}{'Exudyn':>10}"]
    for row in rows:
        cells = [milliseconds(row.reached(engine, target)) for engine in ENGINES for target in TARGETS]
        said.append(f"{row.name:18}" + "".join(f"{cell:>9}" for cell in cells) + ratios(row))
    return said


def ratios(row: Row) -> str:
    """Of both peers at the middle error."""
    found = [row.ratio(peer, MIDDLE) for peer in PEERS]
    return "".join(f"{'-' if ratio is None else f'{ratio[1]}{ratio[0]:.3g}':>10}" for ratio in found)


def chosen(rows: Sequence[Row]) -> list[str]:
    """Which candidate of each peer was the best at the middle error, of how many, and how near its limit comes."""
    said = [f"best of each peer at {MIDDLE:.0e}, of how many; least error found"]
    for row in rows:
        for peer in PEERS:
            reached, tried = row.reached(peer, MIDDLE), row.of(peer)
            if reached is None:
                why = next((climbed.note for climbed in tried if climbed.note), "it has no candidate")
                said.append(f"  {row.name:18}{peer:8}not compared: {why}")
                continue
            said.append(f"  {row.name:18}{peer:8}{reached.label}  ({len(tried)} tried; {row.agreement(peer):.0e})")
    return said


def judged(rows: Sequence[Row]) -> list[str]:
    """Goals and growth."""
    said = [f"{'goal: times as long at ' + format(MIDDLE, '.0e'):44}{'aim':>7}{'least':>9}"]
    for goal, name, ratio, bound, met in verdicts(rows):
        said.append(
            f"{goal.text + ', ' + goal.peer:44}{goal.factor:7g}{bound + format(ratio, '.3g'):>9}  {met}: {name}"
        )
    for prefix in GROWING:
        for engine in ENGINES:
            found = growth(rows, engine, prefix)
            if found:
                said.append(f"{prefix}: time of {engine} ~ bodies^{found[0]:.2f} from {found[1]} to {found[2]} bodies")
    return said


def every(rows: Sequence[Row]) -> list[str]:
    """Every candidate with its time to the middle error."""
    said = [f"all candidates: ms until {MIDDLE:.0e}, settings that failed"]
    for row in rows:
        for climbed in row.climbs:
            time = milliseconds(time_to(climbed, MIDDLE)) if climbed.points else f" not compared: {climbed.note}"
            failed = f"  ({climbed.failed} failed: {climbed.note[:60]})" if climbed.failed and climbed.points else ""
            said.append(f"  {row.name:18}{climbed.engine:8}{climbed.label:66}{time:>9}{failed}")
    return said


def report(rows: Sequence[Row]) -> list[str]:
    """All of it."""
    return [*times(rows), "", *judged(rows), "", *chosen(rows), "", *every(rows)]
