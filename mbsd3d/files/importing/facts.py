"""Facts of a model as a tree of bodies: what a joint carries, how large the whole is, the states of key frames.

Facts are numbers and names in world axes at the reference pose: ``bodies`` (the world first, each with the number of
its parent and of the body it is welded to), ``joints``, ``equalities``, ``gravity``.
"""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...base.mass_properties import MassProperties, put_together
from ...base.rotations import conjugate, matrix, multiply, rotation
from ...equations.compiled import compile_system
from ...mechanism.bodies import Body
from ...mechanism.joints import Joint, coordinate_of
from ...mechanism.mechanism import Mechanism
from ...mechanism.state import State

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
    """Return what a hinge (or slide) turns (or moves) at the reference pose: a' I a [kg m^2], or the mass [kg]."""
    if joint["type"] == "slide":
        return whole.mass
    axis = np.array(joint["axis"])
    arm = np.cross(axis, whole.com - np.array(joint["anchor"]))
    return float(axis @ whole.inertia @ axis + whole.mass * (arm @ arm))


def length_of(facts: Facts) -> float:
    """Return the extent of the model [m]."""
    points = np.array([x for body in facts["bodies"] for x in (body["position"], body["centre"])], float)
    return max(float(np.ptp(points, axis=0).max()), LENGTH_MIN)


class Frame(NamedTuple):
    """A body of the system: number ``body`` of the file, as it stands before the joints ``after`` have moved it."""

    made: Body
    body: int
    after: tuple[int, ...]


def state_of(system: Mechanism, frames: Sequence[Frame], coordinate: Mapping[int, Joint], key: Facts) -> State:
    """Return the state of a key frame; hinges count their turns from the reference pose."""
    motions = [motion_of(frame, key) for frame in frames]
    q = np.concatenate([np.concatenate(motion[:2]) for motion in motions])
    v = np.concatenate([np.concatenate(motion[2:]) for motion in motions])
    compiled = compile_system(system)
    known = np.zeros(len(compiled.coordinate_index))
    for k, joint in coordinate.items():
        joint_key = key["joints"][k]
        kind = "angle" if joint_key["turns"] else "slide"
        known[compiled.coordinate(coordinate_of(joint, kind, "key frame"))] = joint_key["value"]
    return State(key["time"], q, v, coordinates=known)


def motion_of(frame: Frame, key: Facts) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return r, e, r_dot and w of a body: joints turn b about an anchor, and are taken back from the last to the first.

    Twists are those of the point of the body at the origin: v_0 = r_dot - w x r.
    """
    pose, twist = np.array(key["poses"][frame.body]), np.array(key["twists"][frame.body])
    r, e, w = pose[:3], pose[3:], twist[3:]
    v = twist[:3] - np.cross(w, r)
    for k in reversed(frame.after):
        joint = key["joints"][k]
        axis, anchor = np.array(joint["axis"]), np.array(joint["anchor"])
        if joint["slides"]:
            r, v = r - joint["value"] * axis, v - joint["rate"] * axis
            continue
        back, spin = rotation(axis, -joint["value"]), joint["rate"] * axis
        if not joint["turns"]:  # a ball: its quaternion and spin are in the axes of the body it moves
            spin = matrix(e) @ np.array(joint["spin"])
            back = multiply(multiply(e, conjugate(np.array(joint["turn"]))), conjugate(e))
        r, e = anchor + matrix(back) @ (r - anchor), multiply(back, e)
        w, v = w - spin, v - np.cross(anchor, spin)
    return r, e / np.linalg.norm(e), v + np.cross(w, r), w
