"""Names in a picture: beside their points, never on each other, rather on paper than on what is drawn."""

from collections.abc import Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from matplotlib.patheffects import withStroke
from matplotlib.textpath import TextPath

SIZE = 9.0  # of the letters, points
AROUND = np.radians([0, 180, 35, -35, 145, -145, 90, -90])  # directions that are tried, best first
REACHES = np.repeat([0.9, 1.6, 2.6, 4.0, 6.0], len(AROUND))  # distances that are tried, in letter sizes
TOWARDS = np.tile(np.column_stack([np.cos(AROUND), np.sin(AROUND)]), (5, 1))
EFFORT = 0.25 * (np.arange(40) // 8) + 0.03 * (np.arange(40) % 8)  # what the choices cost
STEADY = 0.8  # what the choice of the frame before costs less
CELL = 5.0  # of the map of what is painted, points
COVER = 2.0  # what a name that covers only painted paper costs; see EFFORT


class Name(NamedTuple):
    """A text for a point of the paper."""

    text: str
    point: np.ndarray  # (2,) points from the lower left corner
    colour: Any


@lru_cache(maxsize=4096)
def extent(text: str, size: float) -> float:
    """Width of a text [points]."""
    return float(TextPath((0, 0), text, size=size, usetex=False).get_extents().width) if text.strip() else 0.0


def place(
    names: list[Name],
    painted: np.ndarray,
    paper: tuple[float, float],
    kept: Sequence[int] = (),
    size: float = SIZE,
) -> tuple[list[np.ndarray], list[int]]:
    """Centres of the names on the paper.

    Parameters
    ----------
    names : list of Name
        Placed one after another, those first that stand highest.
    painted : (k, 2) ndarray
        Points of the paper that are better left free.
    paper : (float, float)
        Width and height [points].
    kept : sequence of int
        Choices of the frame before, which are preferred: in a film names must not jump.
    size : float
        Of the letters [points].

    Returns
    -------
    list of (2,) ndarray, list of int
        Centres in the order of ``names``, and the choices. Where there is no room, a name is as free as can be.
    """
    shape = np.ceil(np.array(paper) / CELL).astype(int)
    spots = (painted[((painted > 0) & (painted < paper)).all(axis=1)] / CELL).astype(int)
    ink = np.zeros(shape)
    ink[spots[:, 0], spots[:, 1]] = 1.0
    centres, choices, taken = [np.zeros(2)] * len(names), [0] * len(names), np.zeros((0, 4))
    for i in sorted(range(len(names)), key=lambda i: (-names[i].point[1], i)):
        half = np.array([0.5 * extent(names[i].text, size) + 1.5, 0.62 * size])
        places = names[i].point + TOWARDS * (REACHES[:, None] * size + half * np.abs(TOWARDS))
        costs = [trouble(np.r_[x - half, x + half], taken, ink, paper) for x in places] + EFFORT
        if kept:
            costs[kept[i]] -= STEADY
        choices[i] = int(costs.argmin())
        centres[i] = places[choices[i]]
        taken = np.vstack([taken, np.r_[centres[i] - half, centres[i] + half]])
    return centres, choices


def trouble(box: np.ndarray, taken: np.ndarray, ink: np.ndarray, paper: tuple[float, float]) -> float:
    """What speaks against a box (left, low, right, high): other names, the edge of the paper, what is painted."""
    overlap = np.minimum(box[2:], taken[:, 2:]) - np.maximum(box[:2], taken[:, :2])
    outside = np.clip(-box[:2], 0, None).sum() + np.clip(box[2:] - paper, 0, None).sum()
    left, low, right, high = np.clip((box / CELL).astype(int), 0, None)
    covered = ink[left : right + 1, low : high + 1]
    share = float(covered.mean()) if covered.size else 1.0
    return 100.0 * (overlap > 0.0).all(axis=1).sum() + 10.0 * outside + COVER * share


def write(axes: Any, names: list[Name], centres: list[np.ndarray], paper: Any, size: float = SIZE) -> None:
    """Texts with a halo of the paper's colour, and a thin line to a point that is far."""
    for name, centre in zip(names, centres, strict=True):
        half = np.array([0.5 * extent(name.text, size), 0.5 * size])
        nearest = np.clip(name.point, centre - half, centre + half)
        if np.linalg.norm(nearest - name.point) > 1.3 * size:
            axes.plot(*np.array([name.point, nearest]).T, color=name.colour, linewidth=0.6, zorder=4)
            axes.plot(*name.point, "o", color=name.colour, markersize=2.2, zorder=4)
        halo = [withStroke(linewidth=2.4, foreground=paper)]
        style = {"fontsize": size, "ha": "center", "va": "center_baseline", "path_effects": halo, "zorder": 5}
        axes.text(*centre, name.text, color=name.colour, **style)
