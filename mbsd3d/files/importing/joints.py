"""Joints of a body in a file as joints of this package, and what each can carry."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...mechanism.joints import Joint
from ...mechanism.joints.pairs import Cylindrical, Planar, Prismatic, Revolute, Screw, Spherical, Universal
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
        return Spherical(a, b, at=first["anchor"], name=name) if len(parts) == 1 else None
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
