"""Distance joint in MuJoCo: two hinges at the parent's end of the rod and a ball at the child's, all joints of one
body.

Nothing lies between them, so that the rod has no mass. The rod points along E (sin q2, -sin q1 cos q2, cos q1 cos q2),
E fixed in the parent, and at cos q2 = 0 it lies along the first hinge: there the joint is lost. With ``rods="tendons"``
it is a spatial tendon held at its length, which is never lost; but MuJoCo leaves the term J_dot v out of tendons,
and the error is J_dot v over the stiffness, 100 times greater.
"""

from typing import Any

import numpy as np

from mbsd3d import Distance
from mbsd3d.extend import Piece, rod_axes
from validation.twins.base import EngineFailed

SECOND_HINGE_COSINE_MIN = 0.1  # [1] cos q2 below which the second hinge multiplies errors by more than ten


def swing_name(piece: Piece, k: int) -> str:
    """Return the name of hinge k at the parent's end."""
    return piece.named("swing", k)


def angles(piece: Piece, rod: np.ndarray) -> tuple[float, float]:
    """Return q1, q2 of the rod, a vector to the child rotated back to the reference pose of the parent."""
    x, y, z = rod_axes(piece).T @ rod / np.linalg.norm(rod)
    return np.arctan2(-y, z), np.arcsin(np.clip(x, -1.0, 1.0))


def swing(piece: Piece, q1: float, q2: float) -> np.ndarray:
    """Return E Rx(q1) Ry(q2) E', the rotation of the rod, in world axes of the reference pose of the parent."""
    s1, c1, s2, c2 = np.sin(q1), np.cos(q1), np.sin(q2), np.cos(q2)
    E = rod_axes(piece)
    return E @ np.array([[1, 0, 0], [0, c1, -s1], [0, s1, c1]]) @ np.array([[c2, 0, s2], [0, 1, 0], [-s2, 0, c2]]) @ E.T


def check(model: Any, rods: list[tuple[str, Piece]], t: np.ndarray, qpos: np.ndarray) -> None:
    """Raise EngineFailed that names a rod that came near its first hinge."""
    for name, piece in rods:
        q2 = qpos[:, model.joint(swing_name(piece, 1)).qposadr[0]]
        late = np.flatnonzero(np.abs(np.cos(q2)) < SECOND_HINGE_COSINE_MIN)
        if late.size:
            raise EngineFailed(
                f"MuJoCo: at t = {t[late[0]]:.6g} s rod '{name}' (Distance) lies along the first of the two hinges "
                "that represent its end; use twin(..., rods='tendons')"
            )


def add_tendons(made: Any) -> list[tuple[Any, str, str]]:
    """Add (joint, tendon, equality) of every Distance that is not modelled by joints."""
    found, joints = [], {id(piece.joint) for piece in made.layout.pieces}
    for joint in made.system.joints:
        if isinstance(joint, Distance) and id(joint) not in joints:
            tendon = made.spec.add_tendon(name=f"rod {made.system.name(joint)}")
            for body, at in ((joint.a, joint.at_a), (joint.b, joint.at_b)):
                tendon.wrap_site(made.site(body, at))
            objects = tendon.name, ""
            found.append((joint, tendon.name, made.equality("TENDON", joint, tendon.name, objects, "TENDON")))
    return found


def set_lengths(model: Any, tendons: list[tuple[Any, str, str]]) -> None:
    """Set the lengths of rods: an equality counts from the length in qpos0, the rod has its own."""
    for joint, tendon, equality in tendons:
        model.eq_data[model.equality(equality).id, 0] = joint.length - model.tendon_length0[model.tendon(tendon).id]
