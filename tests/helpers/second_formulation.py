"""Accelerations and wrenches of a mechanism beside those of a formulation that shares no kernel."""

import numpy as np

from mbsd3d import accelerations
from validation.twins.definitions import equations as reference_point


def wrench_difference(found, expected, joint):
    """Greatest difference of force and moment on body b."""
    reaction, (force, about) = found.reaction(joint), np.split(expected.wrench[id(joint)], 2)
    moment = about - np.cross(reaction.point[0] - found.position(joint.b)[0], force)
    return np.abs(np.concatenate([reaction.force[0] - force, reaction.moment[0] - moment])).max()


def differences(system, state):
    """(relative differences of accelerations and of unique wrenches, what the second formulation found)."""
    expected, found = reference_point.solve(system, state), accelerations(system, state)
    apart = np.abs(found.arrays["acceleration"][0] - expected.acceleration).max()
    load = max([1.0, *(np.abs(w).max() for w in expected.wrench.values())])
    unique = [joint for joint in system.joints if id(joint) in expected.wrench and found.reaction(joint).unique]
    worst = max((wrench_difference(found, expected, joint) for joint in unique), default=0.0)
    return apart / max(1.0, np.abs(expected.acceleration).max()), worst / load, expected
