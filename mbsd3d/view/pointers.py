"""Arrows in a picture: solids of revolution, with one head for forces and two for what turns."""

from typing import NamedTuple

import numpy as np

from ..shapes import Mesh
from .drawing import Piece
from .lens import Lens
from .motion import Arrows
from .solids import Items, Solids

SIDES = 14
THICK, HEAD = 0.018, 0.14  # radius of the shaft and length of a head, of the longest arrow
SHORTEST = 0.04  # of the longest arrow: shorter ones are not drawn


class Pointers(NamedTuple):
    """Arrows of one kind at one time, ready to be painted."""

    pieces: list[Piece]
    legend: str
    colour: str
    lens: Lens

    def items(self, longest: float) -> Items:
        """Shaded triangles and outlines."""
        here, R = np.zeros((1, 3)), np.eye(3)[None]
        return Solids(self.pieces, longest).placed(here, R, self.lens, 0.5)


def lathe(profile: list[tuple[float, float]], start: np.ndarray, along: np.ndarray) -> Mesh:
    """The solid with (radius, height) as outline about an axis."""
    side = np.cross(along, np.eye(3)[np.argmin(np.abs(along))])
    side /= np.linalg.norm(side)
    turn = np.arange(SIDES) * 2.0 * np.pi / SIDES
    round_about = np.outer(np.cos(turn), side) + np.outer(np.sin(turn), np.cross(along, side))
    rings = [start + height * along + radius * round_about for radius, height in profile]
    i, n = np.arange(SIDES), SIDES
    faces = []
    for k in range(len(profile) - 1):
        a, b, c, d = k * n + i, k * n + (i + 1) % n, (k + 1) * n + (i + 1) % n, (k + 1) * n + i
        faces += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    faces = np.concatenate(faces)
    return Mesh(np.concatenate(rings), faces, np.zeros(len(faces), int))


def arrow(start: np.ndarray, vector: np.ndarray, reach: float, heads: int) -> Mesh:
    """An arrow that is a short one among arrows of up to ``reach`` [m]: thinner when it is too short for its head."""
    length = float(np.linalg.norm(vector))
    head, thin = min(HEAD * reach, 0.8 * length / heads), THICK * reach * min(1.0, length / (2.0 * HEAD * reach))
    wide, profile = 2.8 * thin, [(0.0, 0.0), (thin, 0.0)]
    for k in range(heads, 0, -1):
        tip = length - (k - 1) * head
        profile += [(thin, tip - head), (wide, tip - head), (0.0 if k == 1 else thin, tip)]
    return lathe(profile, start, vector / length)


def longest_of(arrows: Arrows) -> float:
    """Largest magnitude over the frames."""
    return float(np.linalg.norm(arrows.vectors, axis=-1).max(initial=0.0))


def tips_of(arrows: Arrows, reach: float) -> np.ndarray:
    """(k, 3) where the arrows of all frames end if the longest has the length ``reach`` [m]."""
    return (arrows.points + reach / longest_of(arrows) * arrows.vectors).reshape(-1, 3)


def pointers_of(arrows: Arrows, frame: int, reach: float, lens: Lens) -> Pointers:
    """Arrows of one kind at a frame.

    Parameters
    ----------
    arrows : Arrows
        Over the frames, not all zero.
    frame : int
        Which.
    reach : float
        Length of the longest arrow of all frames in the picture [m].
    lens : Lens
        Where the light and the eye are.

    Returns
    -------
    Pointers
        Uncertain ones paler; the legend says kind, longest and, if so, that shares are not unique.
    """
    heads, longest, pieces = 1 if "force" in arrows.kind else 2, longest_of(arrows), []
    for k, name in enumerate(arrows.names):
        vector = reach / longest * arrows.vectors[frame, k]
        if np.linalg.norm(vector) > SHORTEST * reach:
            tint = paler(arrows.colour) if arrows.uncertain[k] else arrows.colour
            pieces.append(Piece(name, arrows.kind, 0, arrow(arrows.points[frame, k], vector, reach, heads), tint))
    unsure = ", pale: not unique" if any(arrows.uncertain) else ""
    return Pointers(pieces, f"{arrows.kind}, longest {longest:.3g} {arrows.unit}{unsure}", arrows.colour, lens)


def paler(colour: str) -> str:
    """Half way to a light grey."""
    parts = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    return "#" + "".join(f"{(part + 0xD8) // 2:02x}" for part in parts)
