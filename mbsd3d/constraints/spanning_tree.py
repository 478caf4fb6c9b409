"""Joints of a spanning tree, and those that close loops."""

import numpy as np
from scipy.cluster.hierarchy import DisjointSet

from ..equations.compiled import Compiled


def loop_weights(compiled: Compiled) -> np.ndarray:
    """Return 1 for the rows of a spanning tree of joints, 1e-4 for those that close loops."""
    weights, trees = np.ones(compiled.model.row.size), DisjointSet(range(compiled.model.body.size + 1))
    for joint in compiled.system.joints:
        first, *others = (compiled.body_index[id(body)] for body in joint.bodies())
        if not any([trees.merge(first, other) for other in others]):
            weights[compiled.rows[id(joint)]] = 1e-4
    return weights
