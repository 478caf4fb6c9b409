"""Joints of a body in a file as joints of this package, what each can carry, and where key frames put them."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import InputError
from ...base.rotations import conjugate, matrix, multiply, rotation
from ...equations.compiled import compile_system
from ...mechanism.bodies import Body
from ...mechanism.joints import Joint, coordinate_of
from ...mechanism.joints.pairs import Cylindrical, Planar, Prismatic, Revolute, Screw, Spherical, Universal
from ...mechanism.mechanism import Mechanism
from ...mechanism.state import State
from .facts import Facts

COINCIDENCE_ROUNDING = 1e-9  # [1, m] by which axes and points that are taken as one may differ
INDEPENDENT_MIN = 1e-9  # [1] least over largest singular value of the twists of joints in a row, for independent ones


def acts_along(part: Facts) -> bool:
    """Return whether something acts on the coordinate of a joint, or watches it."""
    return bool(
        part["stiffness"] or part["damping"] or part["friction"] or part["armature"] or part["limit"] is not None
        or part.get("actuated", False)
    )  # fmt: skip


def has_coordinate(joint: Joint, kind: str) -> bool:
    """Return whether a joint has the coordinate of a hinge or slide, on which springs and couplings act."""
    if kind in ("hinge", "screw"):
        return joint.angle() is not None
    return kind == "slide" and joint.slide() is not None and joint.angle() is None


def check_independent(parts: Sequence[Facts], name: str, called: str) -> None:
    """Refuse joints in a row whose motions are linearly dependent at the reference pose: none determines its share."""
    twists = []
    for part in parts:
        axis, anchor = np.array(part["axis"]), np.array(part["anchor"])
        for direction in np.eye(3) if part["type"] == "ball" else [axis]:
            turns = part["type"] != "slide"
            twist = (direction, np.cross(anchor, direction)) if turns else (np.zeros(3), direction)
            twists.append(np.concatenate(twist))
    sizes = np.linalg.svd(np.array(twists), compute_uv=False)
    if len(twists) > 6 or sizes[-1] < INDEPENDENT_MIN * sizes[0]:
        names = ", ".join(f"{part['type']} {part['name']}" for part in parts)
        raise InputError(
            f"{called}: {names} lie so at the reference pose that their motions depend on each other; leave one "
            "out, or start elsewhere (ref=)"
        )


def joint_of(a: Any, b: Any, parts: Sequence[Facts], name: str) -> Joint | None:
    """Return the joint that allows the same motion as MuJoCo's joints of one body, or None."""
    hinges = [part for part in parts if part["type"] == "hinge"]
    slides = [part for part in parts if part["type"] == "slide"]
    first = parts[0]
    if first["type"] == "ball":
        own = {"reflected_inertia": first["armature"], "name": name}
        return Spherical(a, b, at=first["anchor"], **own) if len(parts) == 1 else None
    if first["type"] == "screw":
        return Screw(a, b, at=first["anchor"], axis=first["axis"], pitch=first["pitch"], name=name)
    if first["type"] == "planar":
        return Planar(a, b, at=first["anchor"], normal=first["axis"], name=name)
    if len(hinges) + len(slides) < len(parts):
        return None
    at = (hinges or parts)[0]["anchor"]
    axes, armature = np.array([part["axis"] for part in (*hinges, *slides)]), first["armature"]
    if len(parts) > 1 and any(part["armature"] for part in parts):
        return None  # each on a joint of its own
    meet = all(np.linalg.norm(np.subtract(part["anchor"], at)) < COINCIDENCE_ROUNDING for part in hinges)
    match len(hinges), len(slides):
        case 1, 0:
            return Revolute(a, b, at=at, axis=axes[0], reflected_inertia=armature, name=name)
        case 0, 1:
            return Prismatic(a, b, at=at, axis=axes[0], reflected_mass=armature, name=name)
        case 1, 1 if np.linalg.norm(axes[0] - axes[1]) < COINCIDENCE_ROUNDING:
            return Cylindrical(a, b, at=at, axis=axes[0], name=name)
        case 2, 0 if meet and abs(axes[0] @ axes[1]) < COINCIDENCE_ROUNDING:
            return Universal(a, b, at=at, axis_a=axes[0], axis_b=axes[1], name=name)
        case 3, 0 if meet and abs(np.linalg.det(axes)) > 1e-3:  # at 0 the hinges are locked
            return Spherical(a, b, at=at, name=name)
        case 1, 2 if (
            np.abs(axes[1:] @ axes[0]).max() < COINCIDENCE_ROUNDING and np.linalg.norm(np.cross(*axes[1:])) > 1e-3
        ):
            return Planar(a, b, at=at, normal=axes[0], name=name)
    return None


class Frame(NamedTuple):
    """A body of the system: number ``body`` of the file, as it stands before the joints ``after`` have moved it."""

    made: Body
    body: int
    after: tuple[int, ...]
    slide: tuple[tuple[int, float], ...] = ()  # numbers and weights of joints by whose sum it slides along its own x


class Term(NamedTuple):
    """A term w x of a sum of coordinates: of a joint of the file, or of a slider that moves by a part of the sum."""

    joint: Joint
    weight: float
    parts: tuple[tuple[int, float], ...]  # the numbers of the joints of the file that x sums, with their weights


def bodies_of(terms: Sequence[Term]) -> dict[int, Any]:
    """Return the bodies, the ground included, between which the joints of a sum are."""
    return {id(body): body for term in terms for body in (term.joint.a, term.joint.b)}


def parts_of(terms: Sequence[Term]) -> tuple[tuple[int, float], ...]:
    """Return numbers and weights of all joints of the file in a sum of terms."""
    return tuple((k, term.weight * weight) for term in terms for k, weight in term.parts)


def next_to_merge(terms: Sequence[Term], bodies_max: int) -> tuple[list[Term], Any]:
    """Return terms whose sum a slider can take over, so that a sum is nearer to fit, and the body that carries it.

    Two are taken that have at most ``bodies_max`` bodies between them; if there are none, the last one alone, with a
    carrier that the first one has.
    """
    for i, one in enumerate(terms):
        for other in terms[i + 1 :]:
            pair = [one, other]
            if len(bodies_of(pair)) <= bodies_max:
                rest = [body for x in terms if x not in pair for body in bodies_of([x])]
                return pair, max(bodies_of(pair).items(), key=lambda item: rest.count(item[0]))[1]
    return [terms[-1]], terms[0].joint.a


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

    Twists are those of the point of the body at the origin: v_0 = r_dot - w x r. A slider moves along its own x.
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
    for k, weight in frame.slide:
        along = weight * matrix(e)[:, 0]
        r, v = r + key["joints"][k]["value"] * along, v + key["joints"][k]["rate"] * along
    return r, e / np.linalg.norm(e), v + np.cross(w, r), w
