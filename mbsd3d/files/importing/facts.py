"""Facts of a model as a tree of bodies: what a joint carries, how large the whole is. The guarded process imports it.

Facts are numbers and names in world axes at the reference pose: ``bodies`` (the world first, each with the number of
its parent and of the body it is welded to), ``joints``, ``equalities``, ``gravity``.
"""

from typing import Any

import numpy as np

from ...base.mass_properties import MassProperties, put_together

Facts = dict[str, Any]
LENGTH_MIN = 0.01  # [m] that a model has at least, for what rounding may leave of its inertias


def carried(facts: Facts) -> list[MassProperties]:
    """Return mass, centre of mass and inertia, world axes, of each body with all that hangs on it."""
    bodies = facts["bodies"]
    parts = [[(float(x["mass"]), np.array(x["centre"], float), np.array(x["inertia"], float))] for x in bodies]
    found = []
    for i in reversed(range(len(bodies))):  # parents stand before their children
        found.append(put_together(parts[i]))
        if i:
            parts[bodies[i]["parent"]].append((found[-1].mass, found[-1].com, found[-1].inertia))
    return found[::-1]


def felt_inertia(whole: MassProperties, joint: Facts) -> float:
    """Return what a hinge (or slide) turns (or moves) at the reference pose: a' I a [kg m^2], or the mass [kg].

    Of a ball it is the inertia about the axis for which that is the largest.
    """
    if joint["type"] == "slide":
        return whole.mass
    lever = whole.com - np.array(joint["anchor"])
    inertia = whole.inertia + whole.mass * (lever @ lever * np.eye(3) - np.outer(lever, lever))
    if joint["type"] == "ball":
        return float(np.linalg.eigvalsh(inertia)[-1])
    axis = np.array(joint["axis"])
    return float(axis @ inertia @ axis)


def length_of(facts: Facts) -> float:
    """Return the extent of the model [m]."""
    points = np.array([x for body in facts["bodies"] for x in (body["position"], body["centre"])], float)
    return max(float(np.ptp(points, axis=0).max()), LENGTH_MIN)
