"""Arrows in a picture: solids of revolution, with one head for forces and two for what turns."""

from typing import NamedTuple

import numpy as np

from ...base.rotations import matrix
from ...mechanism.shapes import Mesh
from ...mechanism.shapes.surfaces import moved
from ..scene.camera import Lens
from ..scene.drawing import Piece
from ..scene.motion import Arrows
from ..scene.sticks import arrow, laid
from .shading import Items, Solids

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


def arrow_along(start: np.ndarray, vector: np.ndarray, reach: float, heads: int) -> Mesh:
    """An arrow that is a short one among arrows of up to ``reach`` [m]: thinner when it is too short for its head."""
    length = float(np.linalg.norm(vector))
    head, thin = min(HEAD * reach, 0.8 * length / heads), THICK * reach * min(1.0, length / (2.0 * HEAD * reach))
    return moved(arrow(heads, length, thin, head), matrix(laid(vector[None])[0]), start)


def tips_of(arrows: Arrows, reach: float) -> np.ndarray:
    """(k, 3) where the arrows of all frames end if the longest has the length ``reach`` [m]."""
    return (arrows.points + reach / arrows.longest * arrows.vectors).reshape(-1, 3)


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
    longest, pieces = arrows.longest, []
    for k, name in enumerate(arrows.names):
        vector = reach / longest * arrows.vectors[frame, k]
        if np.linalg.norm(vector) > SHORTEST * reach:
            mesh = arrow_along(arrows.points[frame, k], vector, reach, arrows.heads)
            pieces.append(Piece(name, arrows.kind, 0, mesh, arrows.tints[k]))
    unsure = ", pale: not unique" if any(arrows.uncertain) else ""
    return Pointers(pieces, f"{arrows.kind}, longest {longest:.3g} {arrows.unit}{unsure}", arrows.colour, lens)
