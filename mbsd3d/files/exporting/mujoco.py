"""MJCF of a system: bodies with their joints, equalities that close loops and couple coordinates, springs.

The frame of a body there is the frame of the body here: its ``xpos`` is O, its ``xquat`` the orientation.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any
from xml.etree.ElementTree import Element, tostring

import numpy as np

from ...base.rotations import quaternion_from_matrix
from ...equations.compiled import tables_of
from ...kernels import kinds
from ...mechanism.bodies import GROUND, Body
from ...mechanism.couplings import GearMesh
from ...mechanism.drivers import AngleDriver, SlideDriver
from ...mechanism.force_element import hinge_coordinate
from ...mechanism.forces.springs import JointFriction, SpringDamper, TorsionSpring
from ...mechanism.joints import Joint
from ...mechanism.joints.conditions import ConstantVelocity, Distance
from ...mechanism.joints.pairs import Fixed, Prismatic, Revolute, Spherical
from ...mechanism.mechanism import Mechanism
from ...mechanism.primitives import Coordinate
from ...mechanism.signals import Constant
from ...mechanism.state import State
from .exported import WHOLE, Exported, NotExportable, add, called, numbers, refuse, without, xml_text
from .layout import PARALLEL_TOLERANCE, TABLE, Layout, Piece, Placed, Z, lay_out
from .layout import Coordinate as LayoutCoordinate
from .looks import Look, Looks, start_of

INERTIA_MIN = 1e-14  # [kg m^2] moments of inertia MuJoCo still takes
INERTIA_ROUNDING = 1e-14  # [m L^2] of mass and length of the model: moments of inertia that matter to no digit
RAISED_INERTIA_RATIO = 1e-9  # [1] of m L^2: a moment of inertia that may be raised to `INERTIA_MIN`
LOCKED_SOLIMP = (0.9999, 0.9999, 1e-3, 0.5, 2.0)  # solimp: the stiffest that MuJoCo admits, at any residual
FIT_TOLERANCE = 1e-9  # [m, 1] by which a body may be off its reference pose where all coordinates are zero: rounding
MUJOCO_SIZES = {"box": 0.5, "sphere": 1.0, "cylinder": (1.0, 0.5), "capsule": (1.0, 0.5), "ellipsoid": 1.0}
"""Solids of the format and the factors of their sizes: half edges, half lengths."""
STEP_SECONDS = 1e-3  # [s] step of the file: tens of steps in a period of 20 Hz
SOLREF = (16 * STEP_SECONDS, 0.5)  # [s, 1] solref: from 16 steps on, positions and velocities are of second order


@dataclass
class MujocoTree(Placed):
    """MJCF of the bodies of a layout, their joints, and the equalities that close loops.

    ``closures``: joint closed by equalities -> their names; ``raised``: bodies whose moments of inertia were below
    `INERTIA_MIN`; ``held``: equality -> the joint it is of; ``sites``: how many there are.
    """

    root: Element = field(default_factory=lambda: Element("mujoco"))
    elements: dict[str, Element] = field(default_factory=dict)  # bodies, and "joint x" of joint x
    closures: dict[int, list[str]] = field(default_factory=dict)
    raised: list[str] = field(default_factory=list)
    held: dict[str, Any] = field(default_factory=dict)
    sites: int = 0
    weightless: frozenset[int] = frozenset()  # numbers of pieces whose joints belong to the body they carry

    @property
    def system(self) -> Mechanism:
        """Return the system."""
        return self.layout.system

    def build(self) -> None:
        """Write bodies, joints and loop closures."""
        add(self.root, "compiler", angle="radian")
        add(self.root, "option", gravity=numbers(self.system.gravity))
        self.world, self.equalities = add(self.root, "worldbody"), add(self.root, "equality")
        for piece in self.layout.pieces:
            self.add(piece)
        for piece in self.layout.extra:
            halves = [self.main(piece.body), self.elements[piece.name]]
            names = [self.add_site(one, np.zeros(3)) for one in halves]
            self.hold("weld", piece.joint, f"whole {piece.name}", site1=names[0], site2=names[1])
        for joint in self.layout.closing:
            if joint.reflected():
                name = self.system.name(joint)
                text = f"joint '{name}': it closes a loop, and MuJoCo has armature in the tree only"
                raise NotExportable(f"{text}; give its reflected inertia to another joint")
            self.closures[id(joint)] = self.close(joint)

    def main(self, body: Any) -> Element:
        """Return the element of a body of the system."""
        return self.world if body is GROUND else self.elements[self.layout.main[id(body)].name]

    def add_site(self, body: Element, at: np.ndarray) -> str:
        """Add a site at a point of a body, in the axes of the body; return its name."""
        self.sites += 1
        add(body, "site", name=f"site {self.sites}", pos=numbers(at))
        return f"site {self.sites}"

    def hold(self, kind: str, part: Any, name: str, **given: str) -> str:
        """Add an equality of a joint; return its name."""
        add(self.equalities, kind, name=name, **given, solimp=numbers(LOCKED_SOLIMP), solref=numbers(SOLREF))
        self.held[name] = part
        return name

    def add(self, piece: Piece) -> None:
        """Add a body below its parent, its share of mass and inertia, its joints."""
        self.place(piece)
        if piece.number in self.weightless:
            return
        line, parent = self.line_of(piece)
        above = self.world if parent is None else self.elements[parent.name]
        r, R = self.relative(piece, parent)
        place = {"pos": numbers(r), "quat": numbers(quaternion_from_matrix(R))}
        child = self.elements[piece.name] = add(above, "body", name=piece.name, **place)
        self.weigh(child, piece.body)
        if piece.joint is None:
            add(child, "joint", name=piece.title, type="free")
            return
        for each in line:
            for x in self.coordinates_in(piece, each):
                place = {"pos": numbers(x.at)} | ({} if x.kind == "ball" else {"axis": numbers(x.axis)})
                rotors = [inertia for _, inertia in each.joint.reflected()] if each.joint else []
                rotor = max(rotors, default=0.0)  # of a ball the same about all three axes
                place |= {"armature": numbers(rotor)} if rotor else {}
                self.elements[f"joint {x.name}"] = add(child, "joint", name=x.name, type=x.kind, **place)

    def line_of(self, piece: Piece) -> tuple[list[Piece], Piece | None]:
        """Return the pieces whose joints a body has there, the outermost first, and the body that carries it."""
        line, parent = [piece], piece.parent
        while parent is not None and parent.number in self.weightless:
            line, parent = [parent, *line], parent.parent
        return line, parent

    def coordinates_in(self, piece: Piece, each: Piece) -> list[LayoutCoordinate]:
        """Return the coordinates of a piece of the line of another one, in the axes of that one."""
        r, R = self.relative(each, piece)
        return [x._replace(at=r + R @ x.at, axis=R @ x.axis) for x in self.coordinates(each)]

    def weigh(self, child: Element, body: Body) -> None:
        """Set a share of mass and inertia about the centre of mass; principal axes are computed here, MuJoCo would to
        1e-12.
        """
        moments, C = np.diag(body.inertia), np.eye(3)
        if np.any(body.inertia != np.diag(moments)):
            moments, C = np.linalg.eigh(body.inertia)
            C *= np.sign(np.linalg.det(C))
            moments[2] = min(moments[2], moments[0] + moments[1])  # of a flat body, equal up to rounding
        if body.mass <= 0.0:
            raise NotExportable(f"body '{body.name}': mass {body.mass:g} kg; MuJoCo needs a positive one")
        size = body.mass * tables_of(self.system).model.length ** 2
        least = max(INERTIA_MIN, INERTIA_ROUNDING * size)
        if moments.min() < INERTIA_MIN and INERTIA_MIN > RAISED_INERTIA_RATIO * size:
            text = f"a moment of inertia of {moments.min():.3g} kg m^2; MuJoCo takes none below {INERTIA_MIN:g}"
            raise NotExportable(f"body '{body.name}': {text}")
        if moments.min() < least:
            self.raised.append(body.name)
        shares = self.layout.shares(body)
        weight = {"mass": numbers(body.mass / shares), "diaginertia": numbers(np.maximum(moments, least) / shares)}
        add(child, "inertial", pos=numbers(body.com), quat=numbers(quaternion_from_matrix(C)), **weight)

    def close(self, joint: Revolute | Spherical) -> list[str]:
        """Add the equalities of a joint outside the tree, body b first: their forces act on b."""
        name = self.system.name(joint)
        ends = [(joint.at_b, joint.at)]
        if isinstance(joint, Revolute):
            x = 0.5 * tables_of(self.system).model.length
            ends = [(joint.at_b + s * joint.axis_b, joint.at + s * joint.axis) for s in (-x, x)]
        found = []
        for k, (at_b, at_a) in enumerate(ends):
            sites = [self.add_site(self.main(b), b.local_point(at)) for b, at in ((joint.b, at_b), (joint.a, at_a))]
            found.append(self.hold("connect", joint, f"closing {name} {k}", site1=sites[0], site2=sites[1]))
        return found


def weightless(layout: Layout) -> frozenset[int]:
    """Return the numbers of pieces without mass that carry one other piece and nothing else."""
    carried = [piece.parent for piece in layout.pieces]
    used = {id(body) for joint in layout.closing for body in (joint.a, joint.b)}
    springs = [force for force in layout.system.forces if isinstance(force, SpringDamper)]
    used |= {id(body) for force in springs for body in force.bodies()}
    used |= {id(each.body) for piece in layout.extra for each in (piece, piece.parent) if each}
    return frozenset(
        piece.number
        for piece in layout.pieces
        if piece.joint and piece.body.mass == 0.0 and id(piece.body) not in used and carried.count(piece) == 1
    )


def mujoco_tree(layout: Layout, one_body: bool = False) -> MujocoTree:
    """Return the MJCF of a layout; ``one_body``: joints with nothing but a massless body between them are of one."""
    tree = MujocoTree(layout, weightless=weightless(layout) if one_body else frozenset())
    tree.build()
    return tree


def text_of(tree: MujocoTree) -> str:
    """Return the text of the bodies, joints and loop closures of a layout."""
    return tostring(tree.root, "unicode")


def along_the_teeth(mesh: GearMesh) -> list[tuple[Coordinate, float]]:
    """Return the contribution of sliding gears to a helical mesh: n . u of their slides, n the line of action."""
    n = mesh.direction()
    found: list[tuple[Coordinate, float]] = []
    for sign, hinge in ((-1.0, mesh.hinge_a), (1.0, mesh.hinge_b)):
        x = hinge.slide()
        if x is not None:
            factor = sign * float(n @ x.axis) * (1.0 if mesh.gear(hinge) is hinge.b else -1.0)
            found += [(x, factor)] if factor else []
    return found


def sum_of(placed: Placed, x: Coordinate, shown: str) -> dict[str, float]:
    """Return coordinates of pieces and their signs, whose sum is the coordinate.

    The way from body a to body b goes through joints that turn about its axis only, or not at all; a slide is one joint
    and what is fixed to it.
    """
    ways: list[tuple[Any, dict[str, float]]] = [(x.a, {})]
    seen = {id(x.a)}
    while ways:
        body, terms = ways.pop(0)
        if body is x.b:
            return terms
        for piece in placed.layout.pieces:
            if piece.joint is None or body not in (piece.joint.a, piece.joint.b):
                continue
            other, sign = (piece.joint.b, 1.0) if body is piece.joint.a else (piece.joint.a, -1.0)
            step = None if id(other) in seen else step_of(placed, piece, piece.joint, x)
            if step is not None:
                seen.add(id(other))
                ways.append((other, terms | {key: sign * value for key, value in step.items()}))
    raise NotExportable(
        f"{shown}: no way from '{x.a.name}' to '{x.b.name}' leads through joints that are counted along its axis, so "
        f"MuJoCo has no coordinate for its {x.kind}; leave the part out, or join the bodies along it"
    )


def weighted_sum(placed: Placed, pairs: Iterable[tuple[Coordinate, float]], shown: str) -> dict[str, float]:
    """Return coordinates of pieces and their factors, whose sum is that of factor coordinate."""
    found: dict[str, float] = {}
    for x, factor in pairs:
        for key, sign in sum_of(placed, x, shown).items():
            found[key] = found.get(key, 0.0) + factor * sign
    return found


def step_of(placed: Placed, piece: Piece, joint: Joint, x: Coordinate) -> dict[str, float] | None:
    """Return the contribution of a joint to the coordinate, None if it has none."""
    if isinstance(joint, Fixed):
        return {}
    if x.kind == "slide":
        own = joint.slide()
        along = 0.0 if own is None else float(own.axis @ x.axis)
        return {piece.named("slide", Z): np.sign(along)} if abs(abs(along) - 1.0) < PARALLEL_TOLERANCE else None
    if isinstance(joint, Prismatic):
        return {}
    axis = placed.joints[piece.number].turn_axis()
    along = 0.0 if axis is None else float(axis @ x.axis)
    return {piece.named("turn", 0): np.sign(along)} if abs(abs(along) - 1.0) < PARALLEL_TOLERANCE else None


def write_mjcf(system: Mechanism, leave_out: Sequence[Any]) -> Exported:
    """Return the MJCF of a system."""
    kept, gone = without(system, leave_out)
    refuse(kept, [*foreign_joints(kept), *foreign_forces(kept)], "MJCF")
    tree = mujoco_tree(lay_out(kept, rods=True), one_body=True)
    tree.root.set("model", kept.title or "mbsd3d")
    option = tree.root.find("option")
    if option is not None:
        option.attrib |= {"integrator": "RK4", "timestep": numbers(STEP_SECONDS)}
    Couplings(tree).build()
    for force in kept.forces:
        FORCES[type(force)](tree, force)
    if not len(tree.equalities):
        tree.root.remove(tree.equalities)
    soft = tuple(dict.fromkeys(kept.name(part) for part in tree.held.values()))
    said = [f"inertia of {', '.join(tree.raised)} raised to what MuJoCo takes"] if tree.raised else []
    rods = [piece.title for piece in tree.layout.pieces if isinstance(piece.joint, Distance)]
    said += [f"rods of two hinges and a ball, lost where they turn by 90 degrees: {', '.join(rods)}"] if rods else []
    there = [piece for piece in tree.layout.pieces if piece.name in tree.elements]
    frames = {piece.name: WHOLE._replace(body=piece.body.name) for piece in there}
    looks = Looks(tuple(MUJOCO_SIZES))
    for piece in there:
        if tree.layout.main[id(piece.body)] is piece:
            draw(tree, piece.name, looks.of(piece.body))
    start, why = start_of(kept)
    why += write_start(tree, start) if start else []
    inactive = [*gone, *(limit.what() for limit in kept.limits)]
    said += [*why, *looks.missing]
    return Exported(xml_text(tree.root), None, frames, soft, tuple(inactive), tuple(said), looks.meshes)


def draw(tree: MujocoTree, name: str, looks: Sequence[Look]) -> None:
    """Write the shapes of a body as geoms that touch nothing; its mass is given."""
    for look in looks:
        given = {"type": look.kind, "pos": numbers(look.r), "quat": numbers(quaternion_from_matrix(look.R))}
        given |= {"rgba": look.rgba} if look.rgba else {}
        if look.kind == "mesh":
            assets = tree.root.find("asset")
            assets = add(tree.root, "asset") if assets is None else assets
            if all(mesh.get("file") != look.file for mesh in assets):
                add(assets, "mesh", name=look.file, file=look.file, inertia="shell")
            given["mesh"] = look.file
        else:
            given["size"] = numbers(MUJOCO_SIZES[look.kind] * np.array(look.sizes))
        add(tree.elements[name], "geom", **given, contype="0", conaffinity="0", group="1")


def write_start(tree: MujocoTree, start: State) -> list[str]:
    """Write the velocities at the start as a key frame, or say why not.

    The pose is that of the file, qpos0. The coordinates of a body add up to its motion relative to its parent:
    ``w = w_p + sum a x_dot`` of hinges, ``v = v_p + w_p x (r - r_p) + sum (a x_dot, of hinges a x (r - at) x_dot)``.
    """
    system, rates = tree.system, {}
    motion = {id(body): v for body, v in zip(system.bodies, start.v.reshape(-1, 6), strict=True)}
    for piece in tree.layout.pieces:
        if piece.number in tree.weightless:
            continue
        (r, R), (v, w) = tree.poses[piece.number], np.split(motion[id(piece.body)], 2)
        if np.abs(r - piece.body.position).max() > FIT_TOLERANCE or np.abs(R - piece.body.axes).max() > FIT_TOLERANCE:
            return ["velocities at the start are not written: joints are open at the reference pose"]
        if piece.joint is None:
            rates[piece.title] = [*v, *(R.T @ w)]
            continue
        line, parent = tree.line_of(piece)
        if parent is not None:
            (r_p, _), (v_p, w_p) = tree.poses[parent.number], np.split(motion[id(parent.body)], 2)
            v, w = v - v_p - np.cross(w_p, r - r_p), w - w_p
        columns, names = [], []
        for x in (x for each in line for x in tree.coordinates_in(piece, each)):
            for axis in R.T if x.kind == "ball" else [R @ x.axis]:
                turns = np.zeros(3) if x.kind == "slide" else axis
                along = axis if x.kind == "slide" else np.cross(axis, -R @ x.at)
                columns.append(np.concatenate([along, turns]))
                names.append(x.name)
        solved = np.linalg.lstsq(np.array(columns).T, np.concatenate([v, w]))[0] if columns else []
        for name, rate in zip(names, solved, strict=True):
            rates.setdefault(name, []).append(rate)
    ordered = [rates[str(joint.get("name"))] for joint in tree.world.iter("joint")]
    add(add(tree.root, "keyframe"), "key", name="start", qvel=numbers(np.concatenate(ordered)))
    return []


def foreign_joints(system: Mechanism) -> list[tuple[Any, str]]:
    """Return joints and drivers that have no counterpart, with the reason."""
    found: list[tuple[Any, str]] = []
    for joint in system.joints:
        if isinstance(joint, AngleDriver | SlideDriver):
            if not isinstance(joint.signal, Constant):
                found.append((joint, "it moves by a signal, and an equality only holds"))
        elif type(joint) not in TABLE and not isinstance(joint, ConstantVelocity | Distance):
            rows = [row.kind for row in joint.rows()]
            if any(kind not in (kinds.RATIO, kinds.MESH) for kind in rows):
                found.append((joint, "the format has no such element"))
        elif any(row.signal is not None for row in joint.rows()):
            found.append((joint, "it moves by a signal, and an equality only holds"))
    return found


def foreign_forces(system: Mechanism) -> list[tuple[Any, str]]:
    """Return forces that have no counterpart, with the reason."""
    found: list[tuple[Any, str]] = []
    for force in system.forces:
        if type(force) not in FORCES:
            found.append((force, "the format has no such element"))
        elif isinstance(force, JointFriction) and force.coulomb != 0.0:
            found.append((force, "dry friction follows tanh(v / v0) here, there it is a soft constraint"))
        elif isinstance(force, SpringDamper) and force.damping and np.array_equal(force.at_a, force.at_b):
            found.append((force, "where the ends meet MuJoCo's damper pulls along x, here along the motion"))
    return found


@dataclass
class Couplings:
    """Equalities between coordinates: gears, racks, screws, drivers that hold, shafts of constant velocity."""

    tree: MujocoTree

    def build(self) -> None:
        """Write them all."""
        tree = self.tree
        for joint in tree.system.joints:
            for row in joint.rows():
                if row.kind in (kinds.RATIO, kinds.MESH):
                    pairs = list(zip(row.coordinates, row.values, strict=False))
                    pairs += along_the_teeth(joint) if isinstance(joint, GearMesh) else []
                    value = 0.0 if row.signal is None else float(row.signal(0.0))
                    terms = weighted_sum(tree, pairs, called(tree.system, joint))
                    self.hold(joint, {key: factor for key, factor in terms.items() if factor}, value)
        for piece in tree.layout.pieces:
            if isinstance(piece.joint, ConstantVelocity):
                self.hold(piece.joint, {piece.named("turn", 0): 1.0, piece.named("turn", 2): 1.0}, 0.0)

    def hold(self, joint: Joint, terms: dict[str, float], value: float) -> None:
        """Keep a sum at a value: the last coordinate follows the first, or a tendon is the sum."""
        names, name = list(terms), self.tree.system.name(joint)
        if len(terms) > 2:
            tendon = fixed_tendon(self.tree, f"held {name}", terms)
            self.tree.hold("tendon", joint, name, tendon1=tendon, polycoef=numbers(value, 0, 0, 0, 0))
            return
        last = terms[names[-1]]
        lead = {"joint2": names[0]} if len(terms) == 2 else {}
        slope = -terms[names[0]] / last if lead else 0.0
        law = numbers(value / last, slope, 0, 0, 0)
        self.tree.hold("joint", joint, name, joint1=names[-1], **lead, polycoef=law)


def fixed_tendon(tree: MujocoTree, name: str, terms: dict[str, float], **given: str) -> str:
    """Add a tendon that is a sum of coordinates; return its name."""
    tendon = add(tendons_of(tree), "fixed", name=name, **given)
    for joint, factor in terms.items():
        add(tendon, "joint", joint=joint, coef=numbers(factor))
    return name


def tendons_of(tree: MujocoTree) -> Element:
    """Return the section of tendons."""
    found = tree.root.find("tendon")
    return add(tree.root, "tendon") if found is None else found


def spring(tree: MujocoTree, force: SpringDamper) -> None:
    """Add a tendon between two sites."""
    values = {"stiffness": force.stiffness, "damping": force.damping, "springlength": force.length}
    name = tree.system.name(force)
    tendon = add(tendons_of(tree), "spatial", name=name, **{key: numbers(x) for key, x in values.items()})
    for body, at in ((force.a, force.at_a), (force.b, force.at_b)):
        add(tendon, "site", site=tree.add_site(tree.main(body), body.local_point(at)))


def torsion(tree: MujocoTree, force: TorsionSpring) -> None:
    """Add a spring along a hinge or slider."""
    turning(tree, force, force.stiffness, force.damping, force.angle)


def friction(tree: MujocoTree, force: JointFriction) -> None:
    """Add a damper along a hinge or slider."""
    turning(tree, force, 0.0, force.viscous, 0.0)


def turning(tree: MujocoTree, force: Any, stiffness: float, damping: float, rest: float) -> None:
    """Add stiffness and damping to a joint, or to a tendon where several make up the coordinate, or it has a spring.

    A rest length below zero would mean "as built" there, so that the sign of the tendon is reversed.
    """
    shown = called(tree.system, force)
    terms = sum_of(tree, hinge_coordinate(force.hinge, shown), shown)
    (name, sign), *more = terms.items()
    joint = tree.elements[f"joint {name}"]
    if not more and not {"stiffness", "damping"} & set(joint.attrib):
        values = {"stiffness": stiffness, "springref": sign * rest, "damping": damping}
        joint.attrib |= {key: numbers(x) for key, x in values.items() if x}
        return
    sense = -1.0 if rest < 0.0 else 1.0
    values = {"stiffness": stiffness, "damping": damping, "springlength": abs(rest)}
    terms = {key: sense * x for key, x in terms.items()}
    fixed_tendon(tree, tree.system.name(force), terms, **{key: numbers(x) for key, x in values.items()})


FORCES: dict[type, Callable[[MujocoTree, Any], None]] = {
    SpringDamper: spring,
    TorsionSpring: torsion,
    JointFriction: friction,
}
"""Force class -> what adds it to the file."""
