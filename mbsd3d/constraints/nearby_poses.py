"""Poses near a given one: one coordinate displaced, or a small deviation X that the joints close again."""

import numpy as np

from ..base.rotations import matrix
from ..dynamics.state_rates import FACTOR_FROM_OTHER_POSE, PROJECTED, project_positions
from ..kernels.kinematics import displace_body
from ..kernels.layout import Data, Model, Tree


def nudged(y: np.ndarray, b: int, j: int, h: float) -> np.ndarray:
    """Return the state y with body b displaced by h in world direction j, or for j > 2 turned about direction j - 3."""
    dx, moved = np.zeros(6), y.copy()
    dx[j] = h
    displace_body(moved, 7 * b, tuple(dx[:3]), tuple(dx[3:]))
    return moved


def displaced(model: Model, y: np.ndarray, X: np.ndarray) -> np.ndarray:
    """Return y with r_G + delta r_G and exp(delta theta) o e for every body, from the first 6 n entries of X."""
    moved = y.copy()
    for i, (shift, turn) in enumerate(X[: 6 * model.body.size].reshape(-1, 2, 3)):
        q = 7 * i
        before = matrix(y[q + 3 : q + 7]) @ model.body["com"][i]
        displace_body(moved, q, tuple(shift), tuple(turn))
        moved[q : q + 3] += before - matrix(moved[q + 3 : q + 7]) @ model.body["com"][i]
    return moved


def closed(model: Model, data: Data, tree: Tree, t: float, y: np.ndarray, X: np.ndarray) -> np.ndarray | None:
    """Return `displaced`, projected onto c = 0 in the metric of M; None if the joints do not close there."""
    moved = displaced(model, y, X)
    return moved if project_positions(model, data, tree, t, moved, FACTOR_FROM_OTHER_POSE) == PROJECTED else None
