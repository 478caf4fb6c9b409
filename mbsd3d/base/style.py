"""Style of figures and pages: colours that are told apart with any colour vision, on light and on dark paper.

A figure gets its colours explicitly (`style_axes`), and what matplotlib looks up by itself from its own defaults
(`figure_style`): settings of the user or the machine do not change a figure, nor does a figure change them.
"""

import html
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from .checks import check_choice
from .wording import SUPERSCRIPTS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.figure import Figure

FONT = "DejaVu Sans"  # comes with matplotlib, so it is the same on every machine
LINE_WIDTH_POINTS, GRID_WIDTH_POINTS = 1.5, 0.6  # [pt] of data, and of grid and frame


@dataclass(frozen=True)
class Theme:
    """Colours of one kind of paper, "#rrggbb"."""

    paper: str
    ink: str  # text, axes
    muted: str  # what stands back: auxiliary lines, notes
    link: str  # text that leads elsewhere, as readable as ink
    grid: str
    lines: tuple[str, ...]  # of the data, in their order
    good: str  # tints of cells and areas under text
    bad: str

    def colour(self, i: int) -> str:
        """Return the colour of body or line ``i``."""
        return self.lines[i % len(self.lines)]


# Lines on light paper are Okabe and Ito's colours; black and yellow are left out: axes and paper.
LIGHT = Theme(
    paper="#ffffff",
    ink="#1a1a1a",
    muted="#707070",
    link="#0072B2",
    grid="#d9d9d9",
    lines=("#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9", "#CC79A7"),
    good="#CFE5F2",
    bad="#F6C6A8",
)
# The same hues, of such lightness that they stand out from dark paper and from each other (tests/base/test_style.py).
DARK = Theme(
    paper="#15181c",
    ink="#e8e8e8",
    muted="#9aa0a6",
    link="#62AEEA",
    grid="#363b41",
    lines=("#2B7FC4", "#DE6A1E", "#17A67C", "#F5C04A", "#8ED3FC", "#DD92BC"),
    good="#1d3d52",
    bad="#5c3016",
)
COLOURS, GREY = LIGHT.lines, LIGHT.muted
JOINT_COLOUR = "#6b6b6b"  # is seen on white and on dark paper
COM_COLOUR = "#e0e0e0"  # is seen inside bodies
GROUND_GRID_GREYS = {"light": (190, 150), "dark": (52, 84)}  # [0 to 255] of thin and thick lines
SECTOR_BRIGHTNESS = 0.72  # [1] of the darker sectors of round bodies, by which one sees them turn
DECADES_MAX = 20  # [1] of a logarithmic axis, each with its label
REPR_LINES_MAX = 12  # [1] lines of a result in a console
BOX_HEIGHT = "24em"  # of a result in a notebook: half a screen, the rest is scrolled
MUTED_COLOUR, MUTED_SHARE = "#bebebe", 0.55  # grey that uncertain and auxiliary things are mixed with, and its share


def theme(dark: bool) -> Theme:
    """Return the theme of dark or of light paper; ValueError for anything but True or False."""
    check_choice(dark, (True, False), "dark")
    return DARK if dark else LIGHT


def colour(i: int) -> str:
    """Return the colour of body or line ``i`` on light paper."""
    return LIGHT.colour(i)


def channels(colour: str) -> np.ndarray:
    """Return red, green and blue (3,), 0 ... 255, of "#rrggbb"."""
    return np.array([int(colour[k : k + 2], 16) for k in (1, 3, 5)], float)


def rgb(colour: str, brightness: float = 1.0) -> tuple[int, int, int]:
    """Return red, green and blue as whole numbers, darker for a brightness below 1."""
    red, green, blue = np.rint(brightness * channels(colour)).astype(int).tolist()
    return red, green, blue


def muted_colour(colour: str) -> str:
    """Return the paler colour of uncertain or auxiliary things."""
    return (
        "#"
        + bytes(
            np.rint((1.0 - MUTED_SHARE) * channels(colour) + MUTED_SHARE * channels(MUTED_COLOUR)).astype(np.uint8)
        ).hex()
    )


def linear(shares: np.ndarray) -> np.ndarray:
    """Return brightnesses 0 ... 1 of sRGB without the display's curve, as renderers count."""
    shares = np.asarray(shares)
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


@contextmanager
def figure_style(look: Theme = LIGHT) -> Iterator[None]:
    """Make figures within it from matplotlib's defaults and the style of figures, whatever is set outside."""
    from matplotlib import style

    settings = {
        "font.family": [FONT],
        "mathtext.fontset": "dejavusans",
        "text.parse_math": False,  # a name may have dollars in it
        "svg.hashsalt": "mbsd3d",  # else the ids in an SVG are random
        "svg.fonttype": "path",
        "figure.facecolor": look.paper,
        "axes.facecolor": look.paper,
        "text.color": look.ink,
        "axes.titlesize": 10.5,
    }
    with style.context(["default", settings]):
        yield


def style_axes(axes: "Axes", look: Theme = LIGHT) -> None:
    """Set the colours of axes, a light grid below the data and no frame at the top and the right."""
    axes.set_facecolor(look.paper)
    axes.title.set_color(look.ink)
    # ticks are made when they are first drawn, by the settings of then: so they are told now
    axes.tick_params(which="both", colors=look.ink, labelfontfamily=FONT)
    for axis in (axes.xaxis, axes.yaxis):
        axis.label.set_color(look.ink)
        axis.get_offset_text().set_color(look.ink)
    axes.grid(True, color=look.grid, linewidth=GRID_WIDTH_POINTS)
    axes.set_axisbelow(True)
    axes.spines[:].set_color(look.ink)
    axes.spines[["top", "right"]].set_visible(False)


def label_decades(axis: "Axis") -> None:
    """Label every decade like 10⁻²: the figure style writes texts as they are, without mathematics."""
    from matplotlib.ticker import LogLocator  # only who draws waits for it

    axis.set_major_locator(LogLocator(numticks=DECADES_MAX))
    axis.set_major_formatter(lambda x, _: f"10{str(round(np.log10(x))).translate(SUPERSCRIPTS)}")
    axis.set_minor_formatter("")


def label_quarter_turns(axes: "Axes") -> None:
    """Label every 90 degrees of the vertical axis, as it is drawn now."""
    low, high = np.array(axes.get_ylim()) / 90.0
    axes.set_yticks(90.0 * np.arange(np.ceil(low), np.floor(high) + 1.0))


class Result(ABC):
    """Base of results: `str` says what was found, a console shows its first lines, a notebook a box to scroll."""

    @abstractmethod
    def __str__(self) -> str:
        """Return what was found, line by line."""

    def __repr__(self) -> str:
        lines = str(self).splitlines()
        if len(lines) > REPR_LINES_MAX:
            kept = REPR_LINES_MAX - 1
            lines[kept:] = [f"  ... {len(lines) - kept} more lines: print() shows all"]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """Return the text for a notebook."""
        return f'<pre style="max-height:{BOX_HEIGHT};overflow:auto">{html.escape(str(self))}</pre>'


class Told:
    """Base of results that a console tells in a few words: a notebook shows the same words in the same letters."""

    def _repr_html_(self) -> str:
        """Return the words for a notebook."""
        return html_text(repr(self).strip("<>"))


class Sampled(Told):
    """Dataclasses of arrays over the samples: they print by shapes and largest values."""

    def __repr__(self) -> str:
        shown = []
        for x in (x for x in fields(self) if x.repr):  # type: ignore[arg-type]  # the heirs are dataclasses
            value = getattr(self, x.name)
            if isinstance(value, np.ndarray):
                value = f"{value.shape} up to {np.abs(value[np.isfinite(value)]).max(initial=0.0):.4g}"
            elif isinstance(value, dict):
                value = ", ".join(value)
            if value not in (None, ""):
                shown.append(f"{x.name} {value}")
        return f"<{type(self).__name__}: {'; '.join(shown)}>"


def html_text(text: str) -> str:
    """Return a text for a notebook, line by line as it prints."""
    return f"<pre>{html.escape(text)}</pre>"


def html_table(caption: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table for a notebook; every text is escaped."""
    lines = [f"<tr>{''.join(f'<th>{html.escape(x)}</th>' for x in head)}</tr>"]
    lines += [f"<tr>{''.join(f'<td>{html.escape(x)}</td>' for x in row)}</tr>" for row in rows]
    return f"<table><caption>{html.escape(caption)}</caption>{''.join(lines)}</table>"


@contextmanager
def new_figure(width: float, height: float, dark: bool = False) -> Iterator[tuple["Figure", Theme]]:
    """Make an empty figure [inch] with its colours, to be filled within the block."""
    from .figure import Figure  # takes half a second to load: only who draws waits for it

    look = theme(dark)
    with figure_style(look):
        yield Figure(figsize=(width, height), layout="constrained"), look


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Write columns side by side: two of words, then numbers."""
    widths = [max(len(row[k]) for row in rows) for k in range(len(rows[0]))]
    sides = [str.ljust, str.ljust, *[str.rjust] * (len(widths) - 2)]
    return ["  ".join(side(x, n) for side, x, n in zip(sides, row, widths, strict=True)).rstrip() for row in rows]
