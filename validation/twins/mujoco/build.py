"""MuJoCo model of a layout: bodies with their joints, and equalities that close loops.

The frame of a MuJoCo body is the frame of the body it represents: its ``xpos`` is O, its ``xquat`` the orientation.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mbsd3d import GROUND, Body, Distance, Joint, Revolute, Spherical, System
from mbsd3d.extend import quaternion_from_matrix
from validation.twins.base import NotExpressible
from validation.twins.mujoco import rods
from validation.twins.mujoco.layout import Freedoms, Layout, Piece, freedoms_of

# none is in a counterpart model, or one of no use
DISABLED_FLAGS = ("CONTACT", "LIMIT", "FRICTIONLOSS", "SENSOR", "ISLAND", "AUTORESET")
SOLVER_TOLERANCE, SOLVER_ITERATIONS = (
    1e-24,
    5,
)  # of the solver; a Newton step is exact, rounding calls for no more than five
INERTIA_MIN, INERTIA_ROUNDING = (
    1e-14,
    1e-14,
)  # [kg m^2], [m L^2]: moments of inertia MuJoCo still takes, and that matter to no digit
RAISED_INERTIA_RATIO = 1e-9  # [1] of m L^2: a moment of inertia that may be raised to `INERTIA_MIN`
LOCKED_SOLIMP = (0.9999, 0.9999, 1e-3, 0.5, 2.0)  # solimp: the stiffest that MuJoCo admits, at any residual


@dataclass
class Sketch:
    """Model under construction.

    ``poses``: number of a piece -> (r, R) where all joint coordinates are zero, world; ``joints``: number of a piece ->
    its `Freedoms`; ``closures``: joint closed by equalities -> their names; ``raised``: bodies whose moments of inertia
    were below `INERTIA_MIN`; ``sites``: how many there are; ``held``: equality -> the joint it is of.
    """

    mujoco: Any
    system: System
    layout: Layout
    spec: Any
    poses: dict[int, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    joints: dict[int, Freedoms] = field(default_factory=dict)
    closures: dict[int, list[str]] = field(default_factory=dict)
    raised: list[str] = field(default_factory=list)
    sites: int = 0
    held: dict[str, Any] = field(default_factory=dict)

    def body(self, body: Any) -> Any:
        """Return the MuJoCo body that represents a body of the system."""
        return self.spec.worldbody if body is GROUND else self.spec.body(self.layout.main[id(body)].name)

    def site(self, body: Any, point: np.ndarray) -> str:
        """Return a site at a point of a body (world, reference pose), in the axes of the body."""
        self.sites += 1
        return self.body(body).add_site(name=f"site {self.sites}", pos=body.local_point(point)).name

    def equality(self, kind: str, part: Any, name: str, objects: tuple[str, str], of: str, data: tuple = ()) -> str:
        """Add an equality of a joint between two objects of a kind; return its name."""
        made = self.spec.add_equality(name=name, name1=objects[0], name2=objects[1])
        made.type = getattr(self.mujoco.mjtEq, f"mjEQ_{kind}")
        made.objtype = getattr(self.mujoco.mjtObj, f"mjOBJ_{of}")
        made.solimp[:] = LOCKED_SOLIMP
        made.data[: len(data)] = data
        self.held[name] = part
        return name


def sketch(mujoco: Any, system: System, layout: Layout, dense: bool) -> Sketch:
    """Build bodies, joints and loop closures."""
    spec = mujoco.MjSpec()
    spec.compiler.degree = False
    spec.option.gravity = system.gravity
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.jacobian = mujoco.mjtJacobian.mjJAC_DENSE if dense else mujoco.mjtJacobian.mjJAC_AUTO
    spec.option.disableflags = sum(int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}")) for flag in DISABLED_FLAGS)
    spec.option.tolerance, spec.option.iterations = SOLVER_TOLERANCE, SOLVER_ITERATIONS
    made = Sketch(mujoco, system, layout, spec)
    for piece in layout.pieces:
        add_piece(made, piece)
    for piece in layout.extra:
        halves = tuple(
            spec.body(name).add_site(name=f"{name} of {piece.name}").name
            for name in (layout.main[id(piece.body)].name, piece.name)
        )
        made.equality("WELD", piece.joint, f"whole {piece.number}", halves, "SITE", data=(0.0,) * 10 + (1.0,))
    for joint in layout.closing:
        made.closures[id(joint)] = close(made, joint)
    return made


def add_piece(made: Sketch, piece: Piece) -> None:
    """Add a MuJoCo body below its parent, its share of mass and inertia, its joints."""
    body, parent = piece.body, piece.parent
    if parent is None:
        origin, R_parent, above = np.zeros(3), np.eye(3), made.spec.worldbody
    else:
        (origin, R_parent), above = made.poses[parent.number], made.spec.body(parent.name)
    if piece.joint is None:
        r, R = body.position, body.axes
    else:
        free = made.joints[piece.number] = freedoms_of(piece.joint, made.system.name(piece.joint))
        r, R = (
            rods.rest_pose(piece, origin, R_parent @ local_axes(rods.ends(piece)[0], np.eye(3)))
            if isinstance(piece.joint, Distance)
            else rest_pose(piece, piece.joint, free, origin, R_parent)
        )
    made.poses[piece.number] = r, R
    child = above.add_body(name=piece.name, pos=R_parent.T @ (r - origin), quat=quaternion_from_matrix(R_parent.T @ R))
    weigh(made, child, body)
    if piece.joint is None:
        child.add_freejoint(name=f"{piece.number} free").align = made.mujoco.mjtAlignFree.mjALIGNFREE_FALSE
    elif isinstance(piece.joint, Distance):
        rods.add_joints(made.mujoco, child, piece)
    else:
        add_joints(made, child, piece, free)


def rest_pose(
    piece: Piece, joint: Joint, free: Freedoms, origin: np.ndarray, R_parent: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return (r, R) of the child where all coordinates are zero: there the origins are one and B = A rest."""
    before, point, axes, turn = (
        (joint.a, free.at_a, free.A, free.rest) if piece.is_b else (joint.b, free.at_b, free.B, free.rest.T)
    )
    own_point, own_axes = (free.at_b, free.B) if piece.is_b else (free.at_a, free.A)
    F = R_parent @ local_axes(before, axes) @ turn
    R = F @ local_axes(piece.body, own_axes).T
    return origin + R_parent @ before.local_point(point) - R @ piece.body.local_point(own_point), R


def local_axes(body: Any, axes: np.ndarray) -> np.ndarray:
    """Return world axes at the reference pose as columns in body axes."""
    return axes if body is GROUND else body.axes.T @ axes


def weigh(made: Sketch, child: Any, body: Body) -> None:
    """Set a share of mass and inertia about the centre of mass; principal axes are computed here, MuJoCo would to
    1e-12.
    """
    moments, C = np.diag(body.inertia), np.eye(3)
    if np.any(body.inertia != np.diag(moments)):
        moments, C = np.linalg.eigh(body.inertia)
        C *= np.sign(np.linalg.det(C))
        moments[2] = min(moments[2], moments[0] + moments[1])  # of a flat body, equal up to rounding
    if body.mass <= 0.0:
        raise NotExpressible(f"body '{body.name}': mass {body.mass:g} kg; MuJoCo needs a positive one")
    size = body.mass * made.system.lowered.model.length**2
    least = max(INERTIA_MIN, INERTIA_ROUNDING * size)
    if moments.min() < INERTIA_MIN and INERTIA_MIN > RAISED_INERTIA_RATIO * size:
        text = f"a moment of inertia of {moments.min():.3g} kg m^2; MuJoCo takes none below {INERTIA_MIN:g}"
        raise NotExpressible(f"body '{body.name}': {text}")
    if moments.min() < least:
        made.raised.append(body.name)
    shares = made.layout.shares(body)
    child.explicitinertial = True
    child.mass, child.inertia = body.mass / shares, np.maximum(moments, least) / shares
    child.ipos, child.iquat = body.com, quaternion_from_matrix(C)


def add_joints(made: Sketch, child: Any, piece: Piece, free: Freedoms) -> None:
    """Add the translations and rotations of a piece; where it is body a, in the reverse order and sense."""
    kinds, sense = made.mujoco.mjtJoint, 1.0 if piece.is_b else -1.0
    point = piece.body.local_point(free.at_b if piece.is_b else free.at_a)
    own = local_axes(piece.body, free.B if piece.is_b else free.A)
    back = np.eye(3) if piece.is_b else free.rest
    parts = [(slide_name(piece, k), kinds.mjJNT_SLIDE, free.rest.T[:, k]) for k in free.slides]
    if free.turns is None:
        parts.append((f"{piece.number} ball", kinds.mjJNT_BALL, np.eye(3)[2]))
    else:
        parts += [(turn_name(piece, k), kinds.mjJNT_HINGE, axis) for k, axis in enumerate(free.turns)]
    for name, kind, axis in parts if piece.is_b else parts[::-1]:
        made_joint = child.add_joint(name=name, type=kind, pos=point, axis=sense * (own @ back @ axis))
        made_joint.armature = sum(inertia for _, inertia in piece.joint.reflected()) if piece.joint else 0.0


def slide_name(piece: Piece, k: int) -> str:
    """Return the name of the slide along column k of A."""
    return f"{piece.number} slide {k}"


def turn_name(piece: Piece, k: int) -> str:
    """Return the name of hinge k."""
    return f"{piece.number} turn {k}"


def close(made: Sketch, joint: Revolute | Spherical) -> list[str]:
    """Add the equalities of a joint outside the tree, body b first: their forces act on b."""
    name = made.system.name(joint)
    ends = [(joint.at_b, joint.at)]
    if isinstance(joint, Revolute):
        x = 0.5 * made.system.lowered.model.length
        ends = [(joint.at_b + s * joint.axis_b, joint.at + s * joint.axis) for s in (-x, x)]
    found = []
    for k, (at_b, at_a) in enumerate(ends):
        sites = made.site(joint.b, at_b), made.site(joint.a, at_a)
        found.append(made.equality("CONNECT", joint, f"closing {name} {k}", sites, "SITE"))
    return found
