"""The result as text and as a figure."""

from typing import Any

from mbsd3d.extend import LINE, THIN, Theme, dress, house, theme

from .verdict import AGREES, SKIPPED, Compared, CrossCheck, Finding

SHOWN = ("position", "rotation", "velocity", "energy", "reaction force")
"""Quantities in the figure of convergence: the others follow from them."""
USUAL = 1.1e-6  # tolerance that goes without saying
HEADER = f"{'':12} {'quantity':20} {'difference':>10} {'+-':>8} {'order':>5} {'until [s]':>9}  verdict"


def table(check: CrossCheck) -> str:
    """One line per engine and quantity; differences are relative to the quantity's size in the run."""
    lines = [HEADER]
    for engine in check.engines:
        lines += [row(finding) for finding in engine.findings]
        if engine.steps:
            runs = f"{engine.steps[0]} ... {engine.steps[-1]} steps, {sum(engine.seconds):.2g} s"
            lines.append(f"{'':12} {engine.settings}; {runs}; {engine.stopped}")
    lines.append(
        f"neighbouring motions part by {check.growth:.3g} until {check.t_end:g} s; own error {check.own_error:.0e}"
    )
    return "\n".join([*lines, *check.notes, summary(check)])


def summary(check: CrossCheck) -> str:
    """The last line."""
    if check.interrupted:
        return "interrupted: what stands above was compared"
    if check.failures:
        return f"{len(check.failures)} of {len(check.findings)} comparisons differ without a proven cause"
    partly = [name for name in check.compared if name not in (*check.followed, "definitions")]
    rest = f"; of {', '.join(partly)} only the start was compared" if partly else ""
    agreeing = [name for name in check.compared if name not in partly]
    if not check.passed:
        return f"no motion was compared{rest}" if partly else "nothing was compared with another engine"
    return f"agrees with {', '.join(how_far(check, x) for x in check.engines if x.engine in agreeing)}{rest}"


def how_far(check: CrossCheck, engine: Compared) -> str:
    """The engine, with what falls short of the whole time and of the tolerance that was asked for."""
    motion = [x for x in engine.findings if x.uncertainty is not None and x.status != SKIPPED]
    until = min((x.until for x in motion), default=check.t_end)
    bound = max((x.bound for x in motion), default=0.0)
    less = [f"until {until:.4g} s of {check.t_end:g} s"] if until < check.t_end * (1 - 1e-9) else []
    less += [f"within {bound:.0e}"] if bound > 1.5 * check.tolerance else []
    return f"{engine.engine} ({', '.join(less)})" if less else engine.engine


def row(finding: Finding) -> str:
    """One line."""
    numbers = [
        number(finding.difference, "10.1e"), number(finding.uncertainty, "8.0e"), number(finding.order, "5.2f"),
        number(finding.until, "9.4g"),
    ]  # fmt: skip
    return f"{finding.engine:12} {finding.quantity:20} {' '.join(numbers)}  {verdict(finding)}"


def verdict(finding: Finding) -> str:
    """The verdict; of agreement also up to which difference where that is looser than usual, and what limits it."""
    if finding.status != AGREES:
        return finding.verdict
    loose = f" within {finding.bound:.0e}" if finding.bound > USUAL else ""
    return finding.verdict + loose + (f", {finding.reason}" if finding.reason else "")


def number(value: float | None, form: str) -> str:
    """Formatted, or as many blanks with a dash."""
    return f"{value:{form}}" if value is not None else f"{'-':>{form.split('.')[0]}}"


def convergence_figure(check: CrossCheck, dark: bool = False) -> Any:
    """Difference from our motion over the step, one panel per engine with runs, and the expected slope beside it."""
    from matplotlib.figure import Figure

    engines = [engine for engine in check.engines if engine.curves]
    look = theme(dark)
    with house(look):
        figure = Figure(figsize=(7.5, 3.6), layout="constrained", facecolor=look.paper)
        panels = figure.subplots(1, max(len(engines), 1), squeeze=False, sharey=True)[0]
        for axes, engine in zip(panels, engines, strict=False):
            draw(axes, engine, look)
        panels[0].set_ylabel("difference from mbsd3d, relative [-]")
        if not engines:
            panels[0].set_title("no engine ran")
            dress(panels[0], look)
    return figure


def draw(axes: Any, engine: Compared, look: Theme) -> None:
    """Curves of an engine."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    dress(axes, look)
    shown = [curve for curve in engine.curves if curve.quantity in SHOWN]
    for i, curve in enumerate(shown):
        kept = [(h, e) for h, e in zip(curve.steps, curve.differences, strict=True) if e > 0.0]
        if kept:
            axes.loglog(*zip(*kept, strict=True), "o-", color=look.colour(i), linewidth=LINE, markersize=4,
                        label=curve.quantity)  # fmt: skip
    if shown and engine.order:
        coarse, first = shown[0].steps[0], max(curve.differences[0] for curve in shown)
        least = min((e for curve in shown for e in curve.differences if e > 0.0), default=0.0)
        slope = [(h, 2.0 * first * (h / coarse) ** engine.order) for h in shown[0].steps]
        slope = slope[:2] + [(h, e) for h, e in slope[2:] if e >= 0.1 * least]  # below, all is rounding
        axes.loglog(
            *zip(*slope, strict=True), "--", color=look.muted, linewidth=2 * THIN, label=f"order {engine.order:g}"
        )
    for axis in (axes.xaxis, axes.yaxis):  # mathtext is off in house style: names may have dollars in them
        axis.set_major_locator(LogLocator(numticks=6))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:.0e}"))
        axis.set_minor_formatter(NullFormatter())
    axes.set_xlabel("step [s]")
    axes.set_title(engine.engine)
    axes.legend(fontsize=8, frameon=False, labelcolor=look.ink)
