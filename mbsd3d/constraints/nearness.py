"""Poses that are all but singular: one more freedom is nearly there, along which rates and reactions grow."""

import numpy as np

from ..equations.at_state import joint_point
from ..equations.compiled import Compiled
from ..kernels.layout import Data
from ..mechanism.drivers import Driver
from .rank import Analysis

NEAR = 2e-2  # least singular value over the largest; of the reference mechanisms none is below 0.03
APART = 0.1  # over the next one: those of long chains fall evenly, one that is being lost falls away from the others
MOVES = 0.5  # of the joint that moves most: those that are named


def nearly_singular(compiled: Compiled, data: Data, found: Analysis) -> list[str]:
    """What to say of a pose where one singular value is about to vanish: which joints could move then."""
    if found.counted.size < 2 or found.smallest >= NEAR or found.least >= APART * found.counted[-2]:
        return []
    joints = movers(compiled, data, found.least_motion())
    return [
        f"nearly singular: {joints} can all but move while the rest stands; rates and reactions grow up to "
        f"{1.0 / found.smallest:.0f} times (least singular value {found.smallest:.1e} of the largest)"
    ]


def movers(compiled: Compiled, data: Data, motion: np.ndarray) -> str:
    """Names of the joints that move most in a motion."""
    moving = joint_motion(compiled, data, motion)
    names = [f"'{name}'" for name, size in moving.items() if size >= MOVES * max(moving.values())] or ["the bodies"]
    return f"{', '.join(names[:-1])} and {names[-1]}" if len(names) > 1 else names[0]


def joint_motion(compiled: Compiled, data: Data, motion: np.ndarray) -> dict[str, float]:
    """Name of each joint and how far its bodies part at its point, radians or lengths of the model, in a motion.

    ``motion`` (6 n,) in lengths of the model and radians.
    """
    system, length, n = compiled.system, compiled.model.length, len(compiled.system.bodies)
    v = np.concatenate([motion.reshape(n, 6), np.zeros((1, 6))])  # the ground last
    r, found = data.body["r"], {}
    for joint in system.joints:
        if isinstance(joint, Driver) or len(joint.bodies()) != 2:
            continue
        a, b = (compiled.body_index[id(body)] for body in (joint.a, joint.b))
        point = joint_point(compiled, data, joint)
        at_a, at_b = (v[i, :3] + np.cross(v[i, 3:], point - r[i]) / length for i in (a, b))
        slip, turn = at_b - at_a, v[b, 3:] - v[a, 3:]
        found[system.name(joint)] = float(np.linalg.norm([slip, turn]))
    return found
