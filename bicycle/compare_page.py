"""The page of `bicycle.compare`."""

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from markupsafe import Markup

import mbsd3d
from mbsd3d.base.paths import package_version, write_atomically
from mbsd3d.base.progress import Progress
from mbsd3d.base.style import DARK, LIGHT, LINE, THIN, dress, house
from mbsd3d.report.exhibits import inline_svg
from mbsd3d.report.wording import digits

from . import critical, stability
from .compare import AGREES, Entry, check_names
from .range_figure import plot_ranges
from .sketches import side_view

FASTEST, LOWEST, HIGHEST = 12.0, -8.0, 6.0  # of the small figures: speed [m/s], growth [1/s]


def write_page(
    folder: str | Path, found: Sequence[Entry], *, left_out: Sequence[str] = (), views: int = 4,
    progress: bool | None = None,
) -> Path:  # fmt: skip
    """Write the page and the views beside it.

    Parameters
    ----------
    folder : str or Path
        Is made if it is missing; older pages in it are replaced.
    found : sequence of Entry
        At least one.
    left_out : sequence of str
        What is missing on the page, and why.
    views : int
        How many of the bicycles, from the first on, get a page of their own that shows their weave.
    progress : bool, optional
        Show a bar; None = on a terminal, after two seconds.

    Returns
    -------
    Path
        ``index.html``; after Ctrl-C with the views that were finished.

    Raises
    ------
    ValueError
        For no bicycles, two of one name, or a folder that cannot be written.
    """
    if not found:
        raise ValueError("compare: no bicycles; give at least one")
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
    ranges = plot_ranges([(x.parameters.name, x.critical.stable) for x in found], "Self-stable ranges")
    page = template().render(
        cards=cards, ranges=Markup(inline_svg(ranges, "r-")), left_out=left_out,
        difference=max((x.difference for x in found if not np.isnan(x.difference)), default=None), agrees=AGREES,
        once=[x.parameters.name for x in found if np.isnan(x.difference)],
    )  # fmt: skip
    return write_atomically(folder / "index.html", page.encode())


def write_view(folder: Path, x: Entry) -> Path:
    """A page with the weave of a bicycle in motion, at a speed in its self-stable range or at 5 m/s."""
    folder.mkdir(parents=True, exist_ok=True)
    speed = critical.typical_speed(x.critical.stable)
    mode = stability.study(x.parameters, [speed]).mode("weave", speed)
    title = f"{x.parameters.name}: weave at {speed:.3g} m/s"
    return mode.animate(title=title).save(folder / x.file)


def growth_svg(x: Entry, prefix: str) -> Markup:
    """Growth of the modes over the speed as a small figure; the self-stable ranges are shaded."""
    from matplotlib.figure import Figure

    speeds = np.linspace(0.0, FASTEST, 121)
    growth = np.sort(stability.eigenvalues(stability.whipple, x.parameters, speeds).real, axis=1)
    with house():
        figure = Figure(figsize=(3.4, 2.1), layout="constrained")
        axes = figure.subplots()
        dress(axes)
        for part in x.critical.stable:
            axes.axvspan(part.low, min(part.high, FASTEST), color=LIGHT.lines[4], alpha=0.35, linewidth=0.0)
        axes.axhline(0.0, color=LIGHT.ink, linewidth=THIN)
        axes.plot(speeds, growth, color=LIGHT.lines[0], linewidth=LINE)
        axes.set_xlim(0.0, FASTEST)
        axes.set_ylim(LOWEST, HIGHEST)
        axes.set_xlabel("speed [m/s]", fontsize=8)
        axes.set_ylabel("growth [1/s]", fontsize=8)
        axes.tick_params(labelsize=8)
    return Markup(inline_svg(figure, prefix))


@cache
def template() -> Any:
    """Of the page, with the house style of reports; every text put into it is escaped."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    folders = [Path(__file__).parent / "templates", Path(mbsd3d.__file__).parent / "templates"]
    found = Environment(
        loader=FileSystemLoader(folders), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    found.filters |= {"digits": digits}
    found.globals |= {"light": LIGHT, "dark": DARK, "version": package_version(), "degrees": np.degrees}
    return found.get_template("compare.html")
