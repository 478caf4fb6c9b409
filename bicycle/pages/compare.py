"""Several bicycles on one page: what they are, at which speeds they stay upright by themselves, how they look and move.

The page (``index.html``) needs no network; a few of the bicycles have a page of their own with the weave mode in motion
(``views/``), about 0.8 MB each. Critical speeds are those of the closed form, confirmed by the general model; round
tyres have the general model alone.

`side_view` draws a bicycle to scale as a small SVG, from its parameters alone; colours are variables of the page. Frame
and fork are uniform ellipsoids with their mass, centre of mass and inertia, so that one sees where the mass is.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from markupsafe import Markup, escape

from mbsd3d.errors import InputError
from mbsd3d.extend import LINE, THIN, Progress, digits, dress, inline_svg, page_template, write_atomically

from ..linear import critical, stability
from ..linear.critical import CriticalSpeeds, critical_speeds
from ..linear.general import eigenvalues
from ..linear.variants import plot_ranges
from ..model.mechanism import whipple
from ..output import collected, new_figure, write_table
from ..parameters import Meijaard2007, Parameters, entry_of, find, named, names

TEMPLATES = Path(__file__).parent / "templates"
FASTEST, LOWEST, HIGHEST = 12.0, -8.0, 6.0  # of the small figures: speed [m/s], growth [1/s]
AGREES = 1e-6  # [m/s] Largest difference of critical speeds that counts as the same


@dataclass(frozen=True, eq=False)
class Entry:
    """A bicycle of the page."""

    parameters: Parameters
    critical: CriticalSpeeds
    difference: float  # from the ranges of the general model [m/s], NaN for round tyres; infinite if not equally many

    @property
    def height(self) -> float:
        """Of the centre of mass [m]."""
        p = self.parameters
        return (p.mR * p.rR - p.mB * p.zB - p.mH * p.zH + p.mF * p.rF) / p.mass

    @property
    def source(self) -> str:
        """Where the parameters were published, and whether with a rider."""
        if self.parameters.name not in names():
            return "Meijaard et al. 2007, with rider" if self.parameters.name == "Meijaard2007" else ""
        entry = entry_of(self.parameters.name)
        rider = {True: ", with rider", False: ", without rider"}.get(entry.get("includes_rider"), "")
        return f"{entry['source'].split(':')[0]}{rider}"

    @property
    def file(self) -> str:
        """Name of its page."""
        return file_of(self.parameters.name)


def check_names(bicycles: Sequence[Parameters]) -> None:
    """Refuse two bicycles of one name, whose pages would be one file."""
    known: set[str] = set()
    for parameters in bicycles:
        if file_of(parameters.name).lower() in known:  # some file systems do not tell "a" from "A"
            raise InputError(f"compare: two bicycles are called '{parameters.name}'; rename one")
        known.add(file_of(parameters.name).lower())


def file_of(name: str) -> str:
    """Name of the page of a bicycle."""
    return re.sub(r"[^A-Za-z0-9_.+-]+", "-", name).strip(".") + ".html"


def entry(parameters: Parameters) -> Entry:
    """Critical speeds of a bicycle, by closed form and general model."""
    model = critical_speeds(parameters, whipple)
    if parameters.tR or parameters.tF:
        return Entry(parameters, model, float("nan"))
    closed = critical_speeds(parameters)
    return Entry(parameters, closed, critical.difference(closed.stable, model.stable))


def entries(bicycles: Sequence[Parameters], *, progress: bool | None = None) -> list[Entry]:
    """The entries of bicycles; after Ctrl-C those that were finished."""
    return collected(f"{len(bicycles)} bicycles", map(entry, bicycles), len(bicycles), progress)


def table(found: Sequence[Entry]) -> str:
    """Critical speeds as text."""
    wide = max(len(x.parameters.name) for x in found)
    lines = [f"{'':{wide}}  {'weave':>8}  {'capsize':>8}  self-stable [m/s]"]
    for x in found:
        speeds = "  ".join(f"{v:8.4f}" if v > 0.0 else f"{'-':>8}" for v in (x.critical.weave, x.critical.capsize))
        doubt = "  NOT CONFIRMED by the general model" if x.difference > AGREES else ""
        lines.append(f"{x.parameters.name:{wide}}  {speeds}  {critical.listed(x.critical.stable)}{doubt}")
    return "\n".join(lines)


def to_csv(found: Sequence[Entry], path: str | Path) -> Path:
    """One row per bicycle, critical speeds and parameters; returns the file."""
    keys = list(found[0].parameters.values())
    head = ["bicycle", "weave [m/s]", "capsize [m/s]", "stable from [m/s]", "to [m/s]", "model differs by [m/s]", *keys]
    rows = [
        [x.parameters.name, x.critical.weave, x.critical.capsize, *part, x.difference, *x.parameters.values().values()]
        for x in found
        for part in x.critical.stable or [(float("nan"), float("nan"))]
    ]
    return write_table(path, head, rows)


def chosen(wanted: Sequence[str], unphysical: bool) -> tuple[list[Parameters], list[str]]:
    """Bicycles by name or file, all sets if none is named, and why others were left out."""
    if wanted:
        return [find(text, unphysical=unphysical) for text in wanted], []
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
    ranges = plot_ranges([(x.parameters.name, x.critical.stable) for x in found], "Self-stable ranges")
    page = page_template("compare.html", TEMPLATES).render(
        cards=cards, ranges=Markup(inline_svg(ranges, "r-")), left_out=left_out,
        difference=max((x.difference for x in found if not np.isnan(x.difference)), default=None), agrees=AGREES,
        once=[x.parameters.name for x in found if np.isnan(x.difference)], digits=digits, degrees=np.degrees,
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
    speeds = np.linspace(0.0, FASTEST, 121)
    growth = np.sort(eigenvalues(whipple, x.parameters, speeds).real, axis=1)
    with new_figure(3.4, 2.1) as (figure, look):
        axes = figure.subplots()
        dress(axes, look)
        for part in x.critical.stable:
            axes.axvspan(part.low, min(part.high, FASTEST), color=look.lines[4], alpha=0.35, linewidth=0.0)
        axes.axhline(0.0, color=look.ink, linewidth=THIN)
        axes.plot(speeds, growth, color=look.lines[0], linewidth=LINE)
        axes.set_xlim(0.0, FASTEST)
        axes.set_ylim(LOWEST, HIGHEST)
        axes.set_xlabel("speed [m/s]", fontsize=8)
        axes.set_ylabel("growth [1/s]", fontsize=8)
        axes.tick_params(labelsize=8)
    return Markup(inline_svg(figure, prefix))


SCALE = 80.0  # units of the drawing per metre: all bicycles of a page have one scale
LEFT, WIDTH, HEIGHT = 0.7, 2.5, 1.9  # [m] behind the rear contact, of all, above the ground
MARGIN = 8.0  # below the ground


def side_view(parameters: Parameters) -> Markup:
    """SVG element, forward to the right: wheels, frame, fork, steer axis, trail, and ellipsoids of frame and fork."""
    p = parameters

    def at(x: float, z: float) -> str:
        """Place of a point of the paper's axes, z down from the ground."""
        return f"{SCALE * (LEFT + x):.1f} {SCALE * (HEIGHT + z):.1f}"

    def line(kind: str, *points: tuple[float, float]) -> str:
        return f'<path class="{kind}" d="M{"L".join(at(*point) for point in points)}"/>'

    rear, front, tilt = (0.0, -p.rR), (p.w, -p.rF), np.tan(p.lam)
    head = (p.w + p.c - 0.95 * tilt, -0.95) if p.lam < 1.0 else front
    seat = (0.33 * p.w, -0.85)
    body = line("ground", (-LEFT, 0.0), (WIDTH - LEFT, 0.0))
    body += line("axis", head, (p.w + p.c, 0.0)) + line("trail", (p.w, 0.0), (p.w + p.c, 0.0))
    body += ellipse(p, "B", "t0", at) + ellipse(p, "H", "t1", at)
    body += line("tube", rear, seat, head, front) + line("tube", seat, (0.45 * p.w, -0.3), rear)
    for (x, z), radius in ((rear, p.rR), (front, p.rF)):
        cx, cy = at(x, z).split()
        body += f'<circle class="wheel" cx="{cx}" cy="{cy}" r="{SCALE * radius:.1f}"/>'
    label = escape(f"{p.name} from the side")
    return Markup(
        f'<svg viewBox="0 0 {SCALE * WIDTH:g} {SCALE * HEIGHT + MARGIN:g}" role="img" aria-label="{label}">{body}</svg>'
    )


def ellipse(p: Parameters, part: str, tint: str, at: Callable[[float, float], str]) -> str:
    """The ellipsoid of a part seen from the side, with its centre of mass; nothing if it has no mass."""
    mass = getattr(p, f"m{part}")
    if mass == 0.0:
        return ""
    semi, turn = semi_axes(p.inertia(part), mass)
    cx, cy = at(getattr(p, f"x{part}"), getattr(p, f"z{part}")).split()
    a, b = np.maximum(SCALE * semi, 1.5)
    shape = (
        f'<ellipse class="mass {tint}" rx="{a:.1f}" ry="{b:.1f}" transform="translate({cx} {cy}) rotate({turn:.1f})"/>'
    )
    return f'{shape}<circle class="centre {tint}" cx="{cx}" cy="{cy}" r="2.6"/>'


def semi_axes(inertia: np.ndarray, mass: float) -> tuple[np.ndarray, float]:
    """(2,) semi-axes [m] of the uniform ellipsoid in the plane of x and z, and the turn of the first from x to z [deg].

    Negative second moments, which only impossible inertias have, are drawn as zero.
    """
    Ixx, Iyy, Izz, Ixz = inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 2]
    moments = np.array([[Iyy + Izz - Ixx, -2.0 * Ixz], [-2.0 * Ixz, Ixx + Iyy - Izz]]) / 2.0
    values, vectors = np.linalg.eigh(moments)
    turn = np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0]))
    return np.sqrt(5.0 * np.maximum(values, 0.0) / mass), float(turn)
