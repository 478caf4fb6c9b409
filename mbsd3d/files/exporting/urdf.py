"""URDF of a system: a tree of links, each with the joint that carries it.

The frame of a link there is that of its joint; here it keeps the axes of the body, and only its origin moves.
"""

from collections.abc import Sequence
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from ...base.fields import true_or_false
from ...mechanism.bodies import Body
from ...mechanism.joints import Joint
from ...mechanism.joints.pairs import Cylindrical, Fixed, Planar, Prismatic, Revolute, Spherical, Universal
from ...mechanism.mechanism import Mechanism
from ..importing.imported import Point
from .exported import (
    UNLIMITED_RANGE,
    Exported,
    NotExportable,
    add,
    called,
    foreign_loads,
    foreign_rotors,
    loads_of,
    moments_of,
    not_written,
    numbers,
    range_of,
    refuse,
    roll_pitch_yaw,
    without,
    xml_text,
)
from .layout import Layout, Piece, Placed, lay_out
from .looks import Look, Looks, start_of

DIRECT = (Revolute, Prismatic, Fixed, Planar)
BY_MASSLESS_LINKS = (Spherical, Universal, Cylindrical)
URDF_KINDS = {"hinge": "continuous", "slide": "prismatic"}
LOOK_KINDS = ("box", "sphere", "cylinder")  # the solids of the format
STANDARD_GRAVITY = np.array([0.0, 0.0, -9.81])  # [m/s^2] that readers of URDF take
BALL_AXES = np.eye(3)  # of the three hinges in a row that stand for a ball; they lock where the second turns by 90 deg


def write_urdf(system: Mechanism, leave_out: Sequence[Any], massless: bool) -> Exported:
    """Return the URDF of a system."""
    true_or_false(massless, "massless", None)
    kept, gone = without(system, leave_out)
    refuse(kept, foreign(kept), "URDF")
    layout = lay_out(kept, rods=False)
    if layout.closing or layout.extra:
        closes: Any = layout.closing[0] if layout.closing else layout.extra[0].joint
        raise NotExportable(
            f"{called(kept, closes)} closes a loop, and URDF knows trees only; leave it out with "
            f'leave_out=["{kept.name(closes)}"], or write SDF or MJCF'
        )
    several = [piece.joint for piece in layout.pieces if type(piece.joint) in BY_MASSLESS_LINKS and not massless]
    why = "it takes links without mass, which readers treat differently; give massless=True"
    refuse(kept, [(joint, why) for joint in several], "URDF")
    tree = UrdfTree(layout)
    tree.build()
    said = list(tree.said)
    if not np.array_equal(kept.gravity, STANDARD_GRAVITY):
        said.append(f"gravity {kept.gravity.tolist()} m/s^2 has no place in URDF: set it where the file is read")
    else:
        said.append("gravity has no place in URDF: readers set 9.81 m/s^2 along -z")
    moves, why_not = start_of(kept)
    said += ["velocities at the start have no place in URDF"] if moves or why_not else []
    said += tree.looks.missing
    inactive = (*gone, *not_written(kept))
    return Exported(xml_text(tree.root), None, tree.frames, (), inactive, tuple(said), tree.looks.meshes)


def write_look(link: Element, look: Look, origin: np.ndarray) -> None:
    """Write a shape of a link, whose frame has its origin elsewhere in the body."""
    visual = add(link, "visual")
    add(visual, "origin", xyz=numbers(look.r - origin), rpy=numbers(roll_pitch_yaw(look.R)))
    geometry = add(visual, "geometry")
    match look.kind:
        case "box":
            add(geometry, "box", size=numbers(look.sizes))
        case "mesh":
            add(geometry, "mesh", filename=look.file)
        case _:
            sizes = dict(zip(("radius", "length"), map(numbers, look.sizes), strict=False))
            add(geometry, look.kind, **sizes)
    if look.rgba:
        add(add(visual, "material", name=f"colour {look.rgba}"), "color", rgba=look.rgba)


def foreign(system: Mechanism) -> list[tuple[Any, str]]:
    """Return joints and forces that have no counterpart, with the reason."""
    found: list[tuple[Any, str]] = []
    for joint in system.joints:
        if type(joint) not in DIRECT + BY_MASSLESS_LINKS:
            found.append((joint, "the format has no such joint"))
    return found + foreign_rotors(system) + foreign_loads(system, "dampers", springs=False)


class UrdfTree(Placed):
    """Links and joints of a layout."""

    def __init__(self, layout: Layout) -> None:
        super().__init__(layout)
        self.root = Element("robot", name=layout.system.title or "mbsd3d")
        self.frames: dict[str, Point] = {}
        self.said: list[str] = []
        self.looks = Looks(LOOK_KINDS)
        self.names = {piece.name for piece in layout.pieces} | {"world"}

    def build(self) -> None:
        """Write the root, and every other link with its joint."""
        roots = [piece for piece in self.layout.pieces if piece.parent is None]
        free = [piece for piece in roots if piece.joint is None]
        if len(roots) > 1 or not free:
            add(self.root, "link", name="world")
        self.floating = len(roots) > 1
        for piece in self.layout.pieces:
            self.place(piece)
            self.add(piece)
        if free and not self.floating:
            self.said.append(f"the root '{free[0].name}' floats: read it with a floating base")
        elif free:
            self.said.append(f"floating joints: {', '.join(piece.title for piece in free)}")

    def add(self, piece: Piece) -> None:
        """Write the link of a piece, and its joint with links without mass, where it is of several coordinates."""
        origin = self.origin_of(piece)
        self.frames[piece.name] = Point(piece.body.name, origin, np.eye(3))
        self.link(piece.name, piece.body, origin)
        if piece.joint is None:
            if self.floating:
                self.connect(piece.title, "floating", None, piece, piece.name)
            return
        if isinstance(piece.joint, Fixed):
            self.connect(piece.title, "fixed", piece.parent, piece, piece.name)
        elif isinstance(piece.joint, Planar):
            free = self.joints[piece.number]
            normal = piece.body.local_axis((free.B if piece.is_b else free.A)[:, 2])
            self.connect(piece.title, "planar", piece.parent, piece, piece.name, axis=normal)
        else:
            self.chain(piece)

    def chain(self, piece: Piece) -> None:
        """Write the joints of a piece one after the other, over links without mass."""
        axes = [(x.kind, x.axis, x.name) for x in self.coordinates(piece)]
        if axes[-1][0] == "ball":
            axes = [("hinge", axis, f"{piece.title} {letter}") for axis, letter in zip(BALL_AXES, "xyz", strict=True)]
            self.said.append(f"ball '{piece.title}' is three hinges, which lock where the second turns by 90 degrees")
        above: Piece | str | None = piece.parent
        for n, (kind, axis, name) in enumerate(axes):
            link = piece.name
            if n < len(axes) - 1:
                link = self.unique(f"{piece.name} after {name}")
                add(self.root, "link", name=link)
            self.connect(name, URDF_KINDS[kind], above, piece, link, axis=axis, moves=piece.joint)
            above = link

    def unique(self, name: str) -> str:
        """Return a name that no link has."""
        while name in self.names:
            name += " (link)"
        self.names.add(name)
        return name

    def origin_of(self, piece: Piece) -> np.ndarray:
        """Return the origin of the frame of a link: the point of its joint, in the body."""
        if piece.joint is None:
            return np.zeros(3)
        free = self.joints[piece.number]
        return piece.body.local_point(free.at_b if piece.is_b else free.at_a)

    def link(self, name: str, body: Body, origin: np.ndarray) -> None:
        """Write a link with its mass."""
        link = add(self.root, "link", name=name)
        for look in self.looks.of(body):
            write_look(link, look, origin)
        if body.mass == 0.0 and not np.any(body.inertia):
            return
        inertial = add(link, "inertial")
        add(inertial, "origin", xyz=numbers(body.com - origin), rpy="0 0 0")
        add(inertial, "mass", value=numbers(body.mass))
        add(inertial, "inertia", **moments_of(body.inertia))

    def connect(
        self, name: str, kind: str, above: Piece | str | None, piece: Piece, link: str, *,
        axis: np.ndarray | None = None, moves: Joint | None = None,
    ) -> None:  # fmt: skip
        """Write a joint: of a link on a piece, on another link of the same piece and place, or on the world."""
        joint = add(self.root, "joint", name=name, type=kind)
        add(joint, "parent", link=above if isinstance(above, str) else above.name if above else "world")
        add(joint, "child", link=link)
        if isinstance(above, str):
            r, R = np.zeros(3), np.eye(3)
        else:
            r, R = self.relative(piece, above)
            r = r + R @ self.origin_of(piece) - (self.origin_of(above) if above else 0.0)
        add(joint, "origin", xyz=numbers(r), rpy=numbers(roll_pitch_yaw(R)))
        if axis is not None:
            add(joint, "axis", xyz=numbers(axis))
        self.load(joint, kind, moves)

    def load(self, element: Element, kind: str, joint: Joint | None) -> None:
        """Write dampers and limits of a hinge or slider; a slider has limits always."""
        system = self.layout.system
        single = [joint] if isinstance(joint, Revolute | Prismatic) else []
        damping = loads_of(system, single[0]).damping if single else 0.0
        if damping:
            add(element, "dynamics", damping=numbers(damping))
        ends = range_of([limit for limit in system.limits if limit.joint in single])
        if ends is None and kind == "prismatic":
            ends = (-UNLIMITED_RANGE, UNLIMITED_RANGE)
        if ends is not None:
            if kind == "continuous":
                element.set("type", "revolute")
            given = {"lower": numbers(ends[0]), "upper": numbers(ends[1])}
            add(element, "limit", effort=numbers(UNLIMITED_RANGE), velocity=numbers(UNLIMITED_RANGE), **given)
