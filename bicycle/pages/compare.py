"""Several bicycles on one page: their parameters, self-stable speeds, shape and motion.

The page (``index.html``) needs no network; a few of the bicycles have a page of their own with the weave mode in motion
(``views/``), about 0.8 MB each. Critical speeds are those of the closed form, confirmed by the general model; round
tyres have the general model alone.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from markupsafe import Markup

from mbsd3d.errors import InputError
from mbsd3d.extend import (
    GRID_WIDTH_POINTS,
    LINE_WIDTH_POINTS,
    Progress,
    Result,
    digits,
    inline_svg,
    new_figure,
    page_template,
    style_axes,
    write_atomically,
    write_table,
)

from ..linear import critical, stability
from ..linear.critical import CriticalSpeeds, Range, critical_speeds
from ..linear.general import eigenvalues
from ..linear.tyre_equations import Affine, required_equations
from ..linear.variants import NO_RANGE, plot_ranges
from ..model.mechanism import whipple
from ..output import collected
from ..parameters import Meijaard2007, Parameters, entry_of, machines, named, names
from . import ideal_or_tyres
from .side_view import side_view

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEMPLATES = Path(__file__).parent / "templates"
FIGURE_SPEED_MAX, FIGURE_GROWTH_MIN, FIGURE_GROWTH_MAX = (
    12.0,
    -8.0,
    6.0,
)  # of the small figures: speed [m/s], growth [1/s]
SPEED_TOLERANCE = 1e-6  # [m/s] largest difference of critical speeds that counts as the same


@dataclass(frozen=True, eq=False, repr=False)
class Entry(Result):
    """Bicycle of the page."""

    parameters: Parameters
    critical: CriticalSpeeds
    difference: float  # from the ranges of the general model [m/s], NaN for round tyres; infinite if not equally many
    fittings: Mapping[str, Any] = field(default_factory=dict)  # tyres and more of `bicycle.whipple`, if any
    on_tyres: Affine | None = None
    problem: str = ""  # why it does not run on tyres

    @cached_property
    def left_out(self) -> "Figure":
        """Draw what ideal wheels leave out."""
        return ideal_or_tyres.figure(self.parameters, self.fittings)

    @cached_property
    def gripping(self) -> list[Range] | None:
        """Return self-stable ranges on tyres; None for a bicycle without tyres."""
        return None if self.on_tyres is None else self.on_tyres.stable()

    @property
    def height(self) -> float:
        """Return the height of the centre of mass [m]."""
        p = self.parameters
        return (p.mR * p.rR - p.mB * p.zB - p.mH * p.zH + p.mF * p.rF) / p.mass

    @property
    def source(self) -> str:
        """Return where the parameters were published, and whether with a rider."""
        if self.parameters.name in machines():
            return machines()[self.parameters.name]["source"]
        if self.parameters.name not in names():
            return "Meijaard et al. 2007, with rider" if self.parameters.name == "Meijaard2007" else ""
        entry = entry_of(self.parameters.name)
        rider = {None: "", True: ", with rider", False: ", without rider"}.get(entry.get("includes_rider"), "")
        return f"{entry['source'].split(':')[0]}{rider}"

    @property
    def file(self) -> str:
        """Return the file name of the page of the bicycle."""
        return file_of(self.parameters.name)

    def __str__(self) -> str:
        return f"{self.parameters.name}\n{self.critical}"


def check_names(bicycles: Sequence[Parameters]) -> None:
    """Raise ValueError for two bicycles of one name, whose pages would be one file."""
    known: set[str] = set()
    for parameters in bicycles:
        if file_of(parameters.name).lower() in known:  # some file systems do not tell "a" from "A"
            raise InputError(f"compare: two bicycles are called '{parameters.name}'; rename one")
        known.add(file_of(parameters.name).lower())


def file_of(name: str) -> str:
    """Return the file name of the page of a bicycle."""
    return re.sub(r"[^A-Za-z0-9_.+-]+", "-", name).strip(".") + ".html"


def entry(parameters: Parameters, fittings: Mapping[str, Any] | None = None) -> Entry:
    """Compute critical speeds of a bicycle by closed form and general model; with tyres in ``fittings`` also on
    them."""
    model = critical_speeds(parameters, whipple)
    rest: dict[str, Any] = {}
    if fittings:
        try:
            linear = required_equations(partial(whipple, **fittings), parameters)
            rest = {"fittings": fittings, "on_tyres": linear}
        except ValueError as error:
            rest = {"problem": str(error)}
    if parameters.tR or parameters.tF:
        return Entry(parameters, model, float("nan"), **rest)
    closed = critical_speeds(parameters)
    return Entry(parameters, closed, critical.difference(closed.stable, model.stable), **rest)


def entries(
    bicycles: Sequence[Parameters], fittings: Sequence[Mapping[str, Any]] | None = None, *,
    progress: bool | None = None,
) -> list[Entry]:  # fmt: skip
    """Compute the entries of bicycles, and of their tyres if there are fittings; after Ctrl-C those that were
    finished."""
    found = map(entry, bicycles, fittings or [{}] * len(bicycles))
    return collected(f"{len(bicycles)} bicycles", found, len(bicycles), progress)


def table(found: Sequence[Entry]) -> str:
    """Return critical speeds as text."""
    wide = max(len(x.parameters.name) for x in found)
    more = any(x.fittings or x.problem for x in found)
    lines = [f"{'':{wide}}  {'weave':>8}  {'capsize':>8}  self-stable [m/s]" + "         on tyres" * more]
    for x in found:
        speeds = "  ".join(f"{v:8.4f}" if v > 0.0 else f"{'-':>8}" for v in (x.critical.weave, x.critical.capsize))
        doubt = "  NOT CONFIRMED by the general model" if x.difference > SPEED_TOLERANCE else ""
        grip = f"  not possible: {x.problem}" if x.problem else ""
        grip = grip if x.gripping is None else f"  {critical.listed(x.gripping)}"
        ideal = critical.listed(x.critical.stable)
        lines.append(f"{x.parameters.name:{wide}}  {speeds}  {ideal if not grip else f'{ideal:24}'}{doubt}{grip}")
    return "\n".join(lines)


def to_csv(found: Sequence[Entry], path: str | Path) -> Path:
    """Write one row per bicycle, critical speeds and parameters; return the file."""
    keys = list(found[0].parameters.values())
    head = ["bicycle", "weave [m/s]", "capsize [m/s]", "stable from [m/s]", "to [m/s]", "model differs by [m/s]", *keys]
    head[5:5] = ["on tyres from [m/s]", "on tyres to [m/s]"]
    rows = []
    for x in found:
        numbers = x.difference, *x.parameters.values().values()
        ranges = zip_longest(x.critical.stable or [NO_RANGE], x.gripping or [NO_RANGE], fillvalue=NO_RANGE)
        rows += [[x.parameters.name, x.critical.weave, x.critical.capsize, *a, *b, *numbers] for a, b in ranges]
    return write_table(path, head, rows)


def chosen(wanted: Sequence[str], unphysical: bool) -> tuple[list[Parameters], list[str]]:
    """Return bicycles by name or file, all sets if none is named, and why others were left out."""
    if wanted:
        return [named(text, unphysical=unphysical) for text in wanted], []
    found, left_out = [Meijaard2007()], []
    for name in names():
        try:
            found.append(named(name, unphysical=unphysical))
        except ValueError:
            left_out.append(name)
    why = "moments of inertia that no rigid body has; --unphysical accepts them"
    return found, [f"{', '.join(left_out)}: {why}"] if left_out else []


def write_page(
    folder: str | Path, found: Sequence[Entry], *, left_out: Sequence[str] = (), views: int = 4,
    progress: bool | None = None,
) -> Path:  # fmt: skip
    """Write ``index.html`` and, for the first bicycles, pages in ``views`` that show the weave; replaces older ones.

    ``left_out`` says what is missing on the page, and why. After Ctrl-C the page has the views that were finished.
    """
    if not found:
        raise InputError("compare: no bicycles; give at least one")
    check_names([x.parameters for x in found])
    folder, cards, shown = Path(folder), [], set()
    with Progress(f"page of {len(found)} bicycles", 0, len(found) + 4 * views, progress) as bar:
        try:
            for k, x in enumerate(found[:views]):
                write_view(folder / "views", x)
                shown.add(x.file)
                bar.update(4 * k + 4)
        except KeyboardInterrupt:
            pass
        for k, x in enumerate(found):
            link = f"views/{x.file}" if x.file in shown else None
            cards.append((x, side_view(x.parameters), growth_svg(x, f"g{k}-"), link))
            bar.update(4 * len(shown) + k + 1)
    ideal, tyred = [x.critical.stable for x in found], any(x.fittings or x.problem for x in found)
    bars = [(x.parameters.name, x.gripping if tyred else x.critical.stable) for x in found]
    ranges = plot_ranges(bars, "Self-stable ranges", beside=ideal if tyred else [])
    figures = [inline_svg(x.left_out, f"t{k}-") for k, x in enumerate(found[: max(views, 1)]) if x.fittings]
    page = page_template("compare.html", TEMPLATES).render(
        cards=cards, ranges=Markup(inline_svg(ranges, "r-")), left_out=left_out, tyred=tyred,
        figures=[Markup(x) for x in figures],
        difference=max((x.difference for x in found if not np.isnan(x.difference)), default=None),
        agrees=SPEED_TOLERANCE,
        once=[x.parameters.name for x in found if np.isnan(x.difference)], digits=digits, degrees=np.degrees,
    )  # fmt: skip
    return write_atomically(folder / "index.html", page.encode())


def write_view(folder: Path, x: Entry) -> Path:
    """Write a page with the weave of a bicycle in motion, at a speed in its self-stable range or at 5 m/s."""
    folder.mkdir(parents=True, exist_ok=True)
    speed = critical.typical_speed(x.critical.stable)
    mode = stability.study(x.parameters, [speed]).mode("weave", speed)
    title = f"{x.parameters.name}: weave at {speed:.3g} m/s"
    return mode.animate(title=title).save(folder / x.file)


def growth_svg(x: Entry, prefix: str) -> Markup:
    """Draw growth of the modes over the speed as a small figure, on tyres where there are some; stable ranges are
    shaded.
    """
    speeds = np.linspace(0.0, FIGURE_SPEED_MAX, 121)
    growth = np.sort(eigenvalues(whipple, x.parameters, speeds).real, axis=1)
    stable = x.critical.stable if x.gripping is None else x.gripping
    with new_figure(3.4, 2.1) as (figure, look):
        axes = figure.subplots()
        style_axes(axes, look)
        for part in stable:
            axes.axvspan(part.low, min(part.high, FIGURE_SPEED_MAX), color=look.lines[4], alpha=0.35, linewidth=0.0)
        axes.axhline(0.0, color=look.ink, linewidth=GRID_WIDTH_POINTS)
        axes.plot(
            speeds, growth, color=look.muted if x.fittings or x.problem else look.lines[0], linewidth=LINE_WIDTH_POINTS
        )
        if x.on_tyres is not None:
            values = [np.sort(np.linalg.eigvals(x.on_tyres.A(v)).real) for v in speeds[1:]]
            axes.plot(speeds[1:], values, color=look.lines[0], linewidth=LINE_WIDTH_POINTS)
        axes.set_xlim(0.0, FIGURE_SPEED_MAX)
        axes.set_ylim(FIGURE_GROWTH_MIN, FIGURE_GROWTH_MAX)
        axes.set_xlabel("speed [m/s]", fontsize=8)
        axes.set_ylabel("growth [1/s]", fontsize=8)
        axes.tick_params(labelsize=8)
    return Markup(inline_svg(figure, prefix))
