"""Rows that repeat each other left out before Exudyn sees them, as its users do by hand.

Which ones: those that column-pivoted QR of Exudyn's own J' at the start takes last. The motion is the same; reactions
are those of one mechanism among many, so none are reported.
"""

import numpy as np
from scipy.linalg import qr

from mbsd3d.extend import on_one_thread

from .assembly import Assembly
from .equations import Equations

REMOVABLE = ("JointGeneric", "JointSpherical", "ConnectorDistance", "ConnectorCoordinate")
"""Objects of Exudyn that can do without single rows."""


@on_one_thread
def repeated_rows(model: Assembly, equations: Equations, redundant: int) -> dict[int, set[int]]:
    """id(joint) -> rows of its first object that repeat others, as many as Exudyn counts; {} if they cannot go."""
    J = equations.jacobian()
    real = np.flatnonzero(J.any(axis=1))  # the others say "multiplier = 0"
    _, _, order = qr(J[real].T, mode="economic", pivoting=True)
    last = set(real[order[len(order) - redundant :]].tolist())
    found: dict[int, set[int]] = {}
    for joint in model.system.joints:
        for place, item in enumerate(model.objects[id(joint)]):
            own = [k for k, row in enumerate(model.mbs.systemData.GetObjectLTGAE(item)) if row in last]
            if own and (place or model.mbs.GetObject(item)["objectType"] not in REMOVABLE):
                return {}
            if own:
                found[id(joint)] = set(own)
    return found
