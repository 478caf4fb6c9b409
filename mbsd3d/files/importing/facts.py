"""Facts of a model as a tree of bodies: what a joint carries, and how large the whole is.

Facts are numbers and names in world axes at the reference pose: ``bodies`` (the world first, each with the number of
its parent and of the body it is welded to), ``joints``, ``equalities``, ``gravity``.
"""

from typing import Any

import numpy as np

Facts = dict[str, Any]
LENGTH_MIN = 0.01  # [m] that a model has at least, for what rounding may leave of its inertias


def carried(facts: Facts, body: int) -> list[int]:
    """Return the numbers of a body and of all that hang on it; parents stand before their children."""
    found = {body}
    for i, other in enumerate(facts["bodies"]):
        if i and other["parent"] in found:
            found.add(i)
    return sorted(found)


def felt_inertia(facts: Facts, joint: Facts) -> float:
    """Return what a hinge (or slide) turns (or moves) at the reference pose: a' I a [kg m^2], or the mass [kg]."""
    axis, total = np.array(joint["axis"]), 0.0
    for i in carried(facts, joint["body"]):
        body = facts["bodies"][i]
        if joint["type"] == "slide":
            total += body["mass"]
        else:
            arm = np.cross(axis, np.subtract(body["centre"], joint["anchor"]))
            total += float(axis @ np.array(body["inertia"]) @ axis + body["mass"] * (arm @ arm))
    return total


def length_of(facts: Facts) -> float:
    """Return the extent of the model [m]."""
    points = np.array([x for body in facts["bodies"] for x in (body["position"], body["centre"])], float)
    return max(float(np.ptp(points, axis=0).max()), LENGTH_MIN)
