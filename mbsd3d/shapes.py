"""Shapes of bodies: only drawn, never computed with."""

from typing import NamedTuple

import numpy as np


class Mesh(NamedTuple):
    """Triangles in body axes from the reference point O."""

    vertices: np.ndarray  # (k, 3) [m]
    faces: np.ndarray  # (m, 3) corners, counter-clockwise seen from outside
    shade: np.ndarray  # (m,) 0 or 1: faces with 1 are drawn darker, so that one sees a round body turn
