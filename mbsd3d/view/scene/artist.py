"""Construction of the drawing of a system."""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np

from ...base.errors import InputError
from ...base.rotations import matrix, perpendiculars, quaternion_from_matrix
from ...base.style import COM_COLOUR, GREY, JOINT_COLOUR, colour
from ...mechanism.bodies import GROUND, Body, Part
from ...mechanism.contacts import Rolling, RollingDisc
from ...mechanism.force_element import ForceElement
from ...mechanism.forces.contact import Contact
from ...mechanism.forces.rope import OverPulleys
from ...mechanism.forces.sum_spring import SumSpring
from ...mechanism.joints import Joint
from ...mechanism.mechanism import Mechanism
from ...mechanism.shapes import Shape
from ...mechanism.shapes.homogeneous import shapes_of
from ...mechanism.shapes.shape import Solid
from ...mechanism.shapes.solids import Ellipsoid, Lines
from ...mechanism.shapes.triangles import Mesh, ball, block, hull, joined, moved
from .drawing import Drawing, Link, Piece, Rounds, Tag, Wire, bounds, corners, poses_of
from .glyphs import (
    RIM_RADIUS_RATIO,
    Spanning,
    anchor,
    circles,
    joints_of,
    limits,
    pulleys,
    scaled,
    solids,
    spokes,
    strung,
)

# [sizes of the mechanism] from the origin of the world: beyond it, a mechanism is drawn about an origin of its own
ORIGIN_DISTANCE_MAX = 100.0
LINE_WIDTH_RATIO_MAX = 0.002  # [1] width over length of a solid that is also drawn as a line
LINK_RADIUS_RATIO = 0.22  # [sizes of joints] half the thickness of a link: a barrel, 0.36 in radius, stands out of it
LINK_DIGITS_COUNT = 5  # [1] digits, after the first, of the extent of a link to which its points are drawn
SAME_POINT_TOLERANCE = 1e-6  # [extents of the points] below which two joints of a body are at one point
PEN_LIFT = np.full(3, np.nan)  # separates two strokes


def draw_system(system: Mechanism) -> Drawing:
    """Draw a system, true to scale, except for the marks of joints and points."""
    return Artist(system).draw()


def thread(vertices: np.ndarray) -> np.ndarray:
    """Return the ends (2, 3) of the middle line of points too thin for a screen; else (0, 3)."""
    middle = vertices.mean(axis=0)
    axes = np.linalg.svd(vertices - middle, full_matrices=False)[2]
    along = (vertices - middle) @ axes.T
    length, width = np.ptp(along, axis=0)[:2]
    return (
        middle + np.outer([along[:, 0].min(), along[:, 0].max()], axes[0])
        if width < LINE_WIDTH_RATIO_MAX * length
        else axes[:0]
    )


def link(points: np.ndarray, radius: float) -> Mesh:
    """Return the rod between two points, the plate between more: the hull of balls about points (k, 3) [m].

    Sizes are rounded, so that the flat faces of the hull do not fall apart into other triangles by rounding.
    """
    points = np.round(points, LINK_DIGITS_COUNT - int(np.floor(np.log10(np.ptp(points, axis=0).max()))))
    return hull((points[:, None] + float(f"{radius:.3g}") * ball().vertices).reshape(-1, 3))


class Artist:
    """Builder of the drawing of a system: bodies first, since the marks are sized by them."""

    def __init__(self, system: Mechanism) -> None:
        self.system = system
        self.place = {id(body): i for i, body in enumerate((*system.bodies, GROUND))}
        self.drawing = Drawing([], [], [], [], 0.0, 0.0)
        self.rolling = {id(joint.b): joint for joint in system.joints if isinstance(joint, RollingDisc)}
        touching = [part for part in (*system.joints, *system.forces) if isinstance(part, Rolling | Contact)]
        self.surfaces = {id(part.b): part.surface for part in touching}
        contacts = [part for part in touching if isinstance(part, Contact)]
        self.others = [(part, part.other) for part in contacts if isinstance(part.other, Solid)]
        self.surfaces |= {id(part.a): other for part, other in self.others}
        self.linked = {i: points for i, points in self.reached(system.joints).items() if self.is_link(i, points)}

    def reached(self, parts: Iterable[Part]) -> dict[int, np.ndarray]:
        """Return for each body the points (k, 3) of some parts to which it reaches out, body axes from O [m]."""
        found: dict[int, list[np.ndarray]] = {}
        for part in parts:
            for body, point in joints_of(part):
                if body is not GROUND:
                    found.setdefault(self.place[id(body)], []).append(body.local_point(point))
        return {i: np.array(points) for i, points in found.items()}

    def is_link(self, i: int, points: np.ndarray) -> bool:
        """Return whether body i has no shape and joints at two points or more, so that one sees it as a link."""
        body = self.system.bodies[i]
        extent = np.ptp(np.vstack([points, body.com]), axis=0).max()
        apart = np.ptp(points, axis=0).max() > SAME_POINT_TOLERANCE * extent
        return apart and body.shape is None and id(body) not in self.surfaces and id(body) not in self.rolling

    def bodies(self) -> None:
        """Draw the shapes of the bodies; those without one that roll as a disc are a lens of its radius."""
        for i, body in enumerate(self.system.bodies):
            if i in self.linked:
                continue
            for shape in self.shapes(body):
                tint = shape.colour or colour(i)
                try:
                    if isinstance(shape, Lines):
                        self.drawing.wires.append(Wire(body.name, "bodies", i, shape.line(body), tint))
                    elif isinstance(shape, Solid):
                        mesh = shape.mesh(body)
                        self.drawing.pieces.append(Piece(body.name, "bodies", i, mesh, tint))
                        if len(line := thread(mesh.vertices)):
                            self.drawing.wires.append(Wire(body.name, "bodies", i, line, tint))
                except ValueError as error:
                    raise InputError(f"body '{body.name}': {error}") from error

    def obstacles(self) -> None:
        """Draw what the ground itself has in the way of contacts."""
        ground = self.place[id(GROUND)]
        for part, shape in self.others:
            if part.a is GROUND:
                at = np.zeros(3) if shape.at is None else shape.at
                mesh = moved(shape.surface(), matrix(shape.orientation), at)
                self.drawing.pieces.append(Piece(self.system.name(part), "bodies", ground, mesh, shape.colour or GREY))

    def shapes(self, body: Body) -> tuple[Shape, ...]:
        """Return the shapes of a body, else the surface it rolls or touches with."""
        if body.shape is None and id(body) in self.surfaces:
            return (self.surfaces[id(body)],)
        disc = self.rolling.get(id(body))
        if body.shape is not None or disc is None or not np.allclose(disc.centre, body.centre, atol=1e-9 * disc.radius):
            return shapes_of(body)
        axis = body.local_axis(disc.axis)
        turn = quaternion_from_matrix(np.column_stack([*perpendiculars(axis), axis]))
        inner = (1.0 - 1.3 * RIM_RADIUS_RATIO) * disc.radius  # the rim is drawn with the joint
        return (Ellipsoid((inner, inner, 0.1 * disc.radius), orientation=turn),)

    def arms(self) -> None:
        """Draw wires from the centres of mass to joints and springs, and the links."""
        parts: tuple[Part, ...] = (*self.system.joints, *self.system.forces)
        for part in parts:
            if isinstance(part, Spanning):
                first, second = ((self.place[id(body)], body.local_point(point)) for body, point in joints_of(part))
                self.drawing.links.append(Link(self.system.name(part), (first, second), isinstance(part, ForceElement)))
            if isinstance(part, OverPulleys):
                self.drawing.links.extend(self.spans(part))
            if isinstance(part, ForceElement):
                self.drawing.links.extend(self.strings(part))
        for i, points in self.reached(parts).items():
            body = self.system.bodies[i]
            strokes = np.concatenate([[body.com, point, PEN_LIFT] for point in points])
            self.drawing.wires.append(Wire(body.name, "bodies", i, strokes[:-1], colour(i)))

    def links(self, size: float) -> None:
        """Draw bodies without a shape between their joints and centre of mass, and their ellipsoids as a layer."""
        for i, points in self.linked.items():
            body = self.system.bodies[i]
            mesh = link(np.vstack([points, body.com]), LINK_RADIUS_RATIO * size)
            self.drawing.pieces.append(Piece(body.name, "bodies", i, mesh, colour(i)))
            for solid in shapes_of(body):
                if isinstance(solid, Solid):
                    self.drawing.pieces.append(Piece(body.name, "inertia ellipsoids", i, solid.mesh(body), colour(i)))

    def spans(self, rope: OverPulleys) -> Iterator[Link]:
        """Return the spans of a rope, tangents of its pulleys."""
        for first, second in pairwise(rope.path.nodes):
            ends = tuple((self.place[id(x.body)], x.body.local_point(x.point)) for x in (first, second))
            frame = first if first.is_circle else second
            rounds = None
            if frame.is_circle:
                axis = frame.body.local_axis(frame.axis)
                rounds = Rounds(self.place[id(frame.body)], axis, (first.arm, second.arm))
            yield Link(self.system.name(rope), (ends[0], ends[1]), rounds=rounds)

    def strings(self, force: ForceElement) -> Iterator[Link]:
        """Return what ties the joints of a sum to each other: a coil of a spring, a rod of a stop."""
        for (one, first), (other, second) in pairwise(strung(force)):
            if not np.array_equal(first, second):
                ends = (self.place[id(one)], one.local_point(first)), (self.place[id(other)], other.local_point(second))
                yield Link(self.system.name(force), ends, isinstance(force, SumSpring))

    def circles(self) -> None:
        """Draw pulleys, rolling and pitch circles."""
        for force in self.system.forces:
            for body, mesh in pulleys(force):
                name = self.system.name(force)
                self.drawing.pieces.append(Piece(name, "joints", self.place[id(body)], mesh, JOINT_COLOUR))
        for joint in self.system.joints:
            for body, mesh in circles(joint):
                self.drawing.pieces.append(
                    Piece(self.system.name(joint), "joints", self.place[id(body)], mesh, JOINT_COLOUR)
                )

    def names(self) -> None:
        """Write names of bodies at their centres of mass, of joints at their points."""
        add = self.drawing.tags.append
        for i, body in enumerate(self.system.bodies):
            add(Tag(body.name, "body names", i, body.com, colour(i)))
        for joint in self.system.joints:
            owner, point = anchor(joint)
            add(
                Tag(
                    self.system.name(joint),
                    "joint names",
                    self.place[id(owner)],
                    owner.local_point(point),
                    JOINT_COLOUR,
                )
            )

    def grain(self, size: float) -> float:
        """Return the size of joints: a twenty-fifth of the mechanism's, but no more than a part of a typical body's."""
        ground = self.place[id(GROUND)]
        extents = [float(np.ptp(own, axis=0).max()) for i, own in corners(self.drawing).items() if i != ground]
        extents = [extent for extent in extents if extent > 0.0]
        return min(0.04 * size, 0.15 * float(np.median(extents))) if extents else 0.04 * size

    def marks(self, size: float) -> None:
        """Draw centres of mass, reference points, and balls for bodies that have no shape."""
        bar = [scaled(block(), *np.where(np.arange(3) == k, 1.5, 0.12) * size) for k in range(3)]
        cross, dot = joined(*bar), scaled(ball(), *3 * (0.4 * size,))
        add = self.drawing.pieces.append
        for i, body in enumerate(self.system.bodies):
            centre = dot._replace(vertices=dot.vertices + body.com)
            if i not in self.linked and not shapes_of(body):
                add(Piece(body.name, "bodies", i, moved(ball(), 0.5 * size * np.eye(3), body.com), colour(i)))
            add(Piece(body.name, "centre of mass", i, centre, COM_COLOUR))
            add(Piece(body.name, "reference point", i, cross, GREY))

    def joints(self, size: float) -> None:
        """Draw solids and axes of the joints, and the limits of their stops."""
        for joint in self.system.joints:
            name = self.system.name(joint)
            for body, mesh in solids(joint, size):
                self.drawing.pieces.append(Piece(name, "joints", self.place[id(body)], mesh, JOINT_COLOUR))
            for body, ends in spokes(joint, 3.0 * size):
                self.drawing.wires.append(Wire(name, "joints", self.place[id(body)], ends, JOINT_COLOUR))
        solid = corners(self.drawing, ("bodies",))
        for force in self.system.forces:
            name = self.system.name(force)
            for joint in (x for x in force.replaces() if isinstance(x, Joint)):
                for body, mesh in solids(joint, size):
                    self.drawing.pieces.append(Piece(name, "joints", self.place[id(body)], mesh, JOINT_COLOUR))
            *_, last = (GROUND, *force.bodies())  # one whose law is lost has none
            own = solid.get(self.place[id(last)], np.zeros((0, 3)))
            for body, points in limits(force, size, last.position + own @ matrix(last.orientation).T):
                wire = Wire(name, "joints", self.place[id(body)], points, JOINT_COLOUR)
                self.drawing.wires.append(wire)

    def draw(self) -> Drawing:
        """Return the whole drawing: first everything to scale, which gives the size of the marks."""
        self.bodies()
        self.obstacles()
        self.arms()
        self.circles()
        self.names()
        low, high = bounds(self.drawing, *(pose[None] for pose in poses_of(self.system)))
        size = float((high - low).max()) or 1.0
        mark = self.grain(size)
        self.links(mark)
        self.marks(mark)
        self.joints(mark)
        step = 10.0 ** np.ceil(np.log10(ORIGIN_DISTANCE_MAX * size))
        return self.drawing._replace(size=size, floor=float(low[2]), origin=step * np.round(0.5 * (low + high) / step))
