"""Poses that are all but singular: one more freedom is nearly there, along which rates and reactions grow."""

import numpy as np

from ..equations.compiled import Compiled
from ..kernels.layout import Data
from ..mechanism.drivers import Driver
from .rank import Analysis

NEAR = 2e-2  # least singular value over the largest; of the reference mechanisms none is below 0.03
APART = 0.1  # over the next one: those of long chains fall evenly, one that is being lost falls away from the others
MOVES = 0.5  # of the joint that moves most: those that are named


def nearly_singular(compiled: Compiled, data: Data, found: Analysis) -> list[str]:
    """What to say of a pose where one singular value is about to vanish: which joints could move then."""
    kept = found.singular[found.singular > found.tolerance * found.largest]
    if kept.size < 2 or kept[-1] >= NEAR * kept[0] or kept[-1] >= APART * kept[-2]:
        return []
    moving, least = joint_motion(compiled, data, found.least_motion()), kept[-1] / kept[0]
    names = [f"'{name}'" for name, size in moving.items() if size >= MOVES * max(moving.values())] or ["the bodies"]
    joints = f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]
    return [
        f"nearly singular: {joints} can all but move while the rest stands; rates and reactions grow up to "
        f"{1.0 / least:.0f} times (least singular value {least:.1e} of the largest)"
    ]


def joint_motion(compiled: Compiled, data: Data, motion: np.ndarray) -> dict[str, float]:
    """Name of each joint and how far its bodies part at its point, radians or lengths of the model, in a motion.

    ``motion`` (6 n,) in lengths of the model and radians.
    """
    system, length, n = compiled.system, compiled.model.length, len(compiled.system.bodies)
    v = np.concatenate([motion.reshape(n, 6), np.zeros((1, 6))])  # the ground last
    r, R = data.body["r"], data.body["R"].reshape(-1, 3, 3)
    found = {}
    for joint in system.joints:
        if isinstance(joint, Driver) or len(joint.bodies()) != 2:
            continue
        a, b = (compiled.body_index[id(body)] for body in (joint.a, joint.b))
        point = r[b] + R[b] @ joint.b.local_point(joint.point())
        there = [v[i, :3] + np.cross(v[i, 3:], point - r[i]) / length for i in (a, b)]
        found[system.name(joint)] = float(
            np.hypot(*(np.linalg.norm(x) for x in (there[1] - there[0], v[b, 3:] - v[a, 3:])))
        )
    return found
