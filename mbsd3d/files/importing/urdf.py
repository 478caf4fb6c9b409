"""Facts of a URDF file: links, joints and what acts on them, at the pose where all angles are zero.

Followers of a mimic start where their leaders put them. What acts on no motion is counted and passed over.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeVar

import numpy as np

from ...base.errors import InputError
from ...base.paths import read_text
from ...base.rotations import matrix, multiply, rotation
from .facts import Facts, carried, felt_inertia, length_of
from .folders import Folders
from .model_file import AT_HOME, Link, ModelFile, Pose, after, unloaded
from .xacro import expanded, is_xacro
from .xml_scan import FILES_BYTES_MAX
from .xml_tree import Node, tree_of

JOINT_KINDS = {
    "revolute": "hinge", "continuous": "hinge", "prismatic": "slide", "planar": "planar", "floating": "free",
    "fixed": "fixed", "spherical": "ball",
}  # fmt: skip
"""Types of joints; "spherical" is not a word of the format, but of one of its readers."""
LINK_TAGS = ("inertial", "visual", "collision")
INERTIAL_TAGS = ("mass", "inertia", "origin")
JOINT_TAGS = ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic", "safety_controller")
WORLD = "world"  # a link of this name at the root is the ground, declared or not
HELD_INERTIA_ROUNDING = 1e-12  # [m L^2] of mass and extent of the model: what a hinge turns, if it turns nothing


@dataclass
class Connection:
    """A joint: kind as the builder knows it, place in the parent, axis in its own frame, value at the start."""

    name: str
    node: Node
    kind: str
    parent: str
    child: str
    origin: np.ndarray
    turn: np.ndarray
    axis: np.ndarray
    start: float = 0.0


Named = TypeVar("Named", Link, Connection)


class Robot(ModelFile):
    """A URDF file; xacro is run where it is used."""

    def __init__(self, path: Path, folders: Folders, floating: bool | None, timeout: float, inputs: bool) -> None:
        text = read_text(path, FILES_BYTES_MAX)
        root = tree_of(path, expanded(path, folders, timeout) if is_xacro(path, text) else text)
        if root.tag != "robot":
            raise InputError(f"'{path}': its root is <{root.tag}>, not <robot>; use the reader of its format")
        super().__init__(folders)
        self.root, self.floating, self.inputs = root, floating, inputs
        self.chosen: list[str] = []

    def facts(self) -> Facts:
        """Return bodies, joints and couplings for the builder."""
        check_case(self.root, ("link", "joint"))
        self.idle.update(child.tag for child in self.root.children if child.tag not in ("link", "joint"))
        self.links = {link.name: link for link in self.read_links()}
        self.joints = {joint.name: joint for joint in once_each(self.root.all("joint"), self.joint)}
        order = self.in_order()
        self.set_starts()
        self.set_poses(order)
        bodies, number = self.bodies(order)
        facts: Facts = {"bodies": bodies, "joints": [], "equalities": [], "gravity": [0.0, 0.0, -9.81]}
        if not any(body["mass"] for body in bodies):
            raise InputError("no link of it has a mass; give <inertial> with mass and inertia")
        self.weld_unfelt(facts, number, order)
        self.base(facts, order[0])
        places = self.list_joints(facts, number)
        self.list_mimics(facts, places)
        if self.inputs:
            facts["actuators"] = self.motors(places)
        for name, i in number.items():
            bodies[i]["geoms"] = self.geoms(self.links[name])
        able = [name for name in number if (node := self.links[name].node) and node.all("collision")]
        self.list_contacts([(name, bodies[number[name]]["weld"]) for name in able])
        points = [
            {"name": b["name"], "body": i, "position": b["position"], "axes": matrix(b["quaternion"])}
            for i, b in enumerate(bodies)
            if i and b["weld"] != i
        ]
        return facts | {
            "points": points, "foreign": self.foreign, "idle": dict(self.idle), "said": self.said + self.chosen,
            "chosen": self.chosen, "missing": self.missing,
        }  # fmt: skip

    def read_links(self) -> Iterator[Link]:
        """Read every link, and `world` where a joint needs it undeclared."""
        links = once_each(self.root.all("link"), self.link)
        yield from links
        wanted = {end.attributes.get("link") for node in self.root.all("joint") for end in node.all("parent")}
        if not links:
            raise InputError("it has no <link>; give links")
        if WORLD in wanted - {link.name for link in links}:
            yield Link(WORLD, None)

    def link(self, node: Node) -> Link:
        """Read a link with its mass, and inertia about its centre of mass in its own axes."""
        link = Link(node.text("name"), node)
        self.places["body", link.name] = node.place
        check_case(node, LINK_TAGS)
        self.idle.update(child.tag for child in node.children if child.tag != "inertial")
        inertial = node.one("inertial")
        if inertial is None:
            return link
        check_case(inertial, INERTIAL_TAGS)
        mass, inertia, origin = (inertial.one(tag) for tag in INERTIAL_TAGS)
        if mass is None or inertia is None:
            what = "mass" if mass is None else "inertia"
            raise InputError(f"{inertial.place} of link '{link.name}' has no <{what}>; give it, zeros for none")
        link.mass = mass.number("value")
        if link.mass < 0.0:
            raise InputError(f"{mass.place} of link '{link.name}': {link.mass:g} kg < 0; give a mass >= 0")
        I = np.zeros((3, 3))
        for a, row in enumerate("xyz"):
            for b, column in enumerate("xyz"[a:], a):
                I[a, b] = I[b, a] = inertia.number(f"i{row}{column}", None if a == b else 0.0)
        link.com, turn = place_in_parent(origin)
        link.inertia = matrix(turn) @ I @ matrix(turn).T
        return link

    def joint(self, node: Node) -> Connection:
        """Read a joint, between links that are there."""
        name, kind = node.text("name"), node.text("type")
        self.places["joint", name] = node.place
        check_case(node, JOINT_TAGS)
        self.idle.update(child.tag for child in node.children if child.tag not in JOINT_TAGS)
        if kind not in JOINT_KINDS:
            have = ", ".join(JOINT_KINDS)
            raise InputError(f"{node.place}: joint '{name}' is of the type '{kind[:40]}'; give one of {have}")
        ends = [node.one(tag) for tag in ("parent", "child")]
        links = [end.text("link") if end else "" for end in ends]
        for end, link in zip(("parent", "child"), links, strict=True):
            if link not in self.links:
                raise InputError(f"{node.place}: {end} of joint '{name}' is '{link}', which is not a link; name a link")
        origin, turn = place_in_parent(node.one("origin"))
        axis_node = node.one("axis")
        axis = np.array([1.0, 0.0, 0.0]) if axis_node is None else axis_node.numbers("xyz", 3, (1.0, 0.0, 0.0))
        length = float(np.linalg.norm(axis))
        if kind in ("fixed", "floating"):
            axis, length = np.array([1.0, 0.0, 0.0]), 1.0
        if length == 0.0:
            raise InputError(f"{node.place}: the axis of joint '{name}' has no length; give a direction")
        return Connection(name, node, JOINT_KINDS[kind], links[0], links[1], origin, turn, axis / length)

    def in_order(self) -> list[str]:
        """Return the names of the links, parents before children; they must be a tree."""
        above: dict[str, Connection] = {}
        for joint in self.joints.values():
            if joint.child in above:
                raise InputError(
                    f"{joint.node.place}: link '{joint.child}' has a second parent, joint '{joint.name}' beside "
                    f"'{above[joint.child].name}'; URDF knows trees only, cut the loop"
                )
            above[joint.child] = joint
        roots = [name for name in self.links if name not in above]
        if len(roots) != 1:
            shown = ", ".join(f"'{name}'" for name in roots[:5]) or "none"
            raise InputError(f"links without a parent: {shown}; let joints connect all links to one root")
        self.above, self.below = above, {name: [] for name in self.links}  # type: ignore[var-annotated]
        for joint in self.joints.values():
            self.below[joint.parent].append(joint)
        order = roots
        for name in order:
            order += [joint.child for joint in self.below[name]]
        if len(order) < len(self.links):
            reached = set(order)
            lost = next(name for name in self.links if name not in reached)
            raise InputError(f"link '{lost}' hangs on itself by its joints; let joints connect all links to one root")
        return order

    def set_starts(self) -> None:
        """Set the values of followers where their leaders are at zero: y = multiplier x + offset."""
        for joint in self.joints.values():
            line: list[Connection] = []
            leader: Connection | None = joint
            while leader is not None:
                if leader in line:
                    raise InputError(f"{joint.node.place}: joint '{joint.name}' follows itself; cut the circle")
                line.append(leader)
                leader = self.leader(leader)
            value = 0.0
            for follower in reversed(line[:-1]):
                multiplier, offset = mimic_of(follower)
                value = multiplier * value + offset
            joint.start = value
            if value:
                self.said.append(f"'{joint.name}' counts from {value:g}, where it starts")

    def leader(self, joint: Connection) -> Connection | None:
        """Return the joint that a joint follows, or None."""
        mimic = joint.node.one("mimic")
        if mimic is None or joint.kind == "fixed":
            return None
        name = mimic.text("joint")
        if name not in self.joints:
            raise InputError(
                f"{mimic.place}: joint '{joint.name}' follows '{name[:60]}', which is not a joint; name one"
            )
        return self.joints[name]

    def set_poses(self, order: list[str]) -> None:
        """Set where the links are at the start."""
        for name in order[1:]:
            joint, link = self.above[name], self.links[name]
            link.pose = after(self.links[joint.parent].pose, (joint.origin, joint.turn))
            if joint.kind == "hinge" and joint.start:
                link.pose = after(link.pose, (np.zeros(3), rotation(joint.axis, joint.start)))
            elif joint.kind == "slide":
                link.pose = after(link.pose, (joint.axis * joint.start, AT_HOME[1]))

    def bodies(self, order: list[str]) -> tuple[list[Facts], dict[str, int]]:
        """Return the world and all links, welded where joints are fixed, and the number of every link."""
        found, number = [Link(WORLD, None).facts(0, 0) | {"geoms": []}], {}
        for i, name in enumerate(order, 1):
            number[name], joint = i, self.above.get(name)
            parent = number[joint.parent] if joint else 0
            fixed = joint is not None and joint.kind == "fixed"
            found.append(self.links[name].facts(parent, found[parent]["weld"] if fixed else i))
        return found, number

    def weld_unfelt(self, facts: Facts, number: dict[str, int], order: list[str]) -> None:
        """Weld joints that move nothing that has mass: no body can feel them, and nothing determines their motion."""
        bodies, coupled = facts["bodies"], set()
        for joint in self.joints.values():
            leader = self.leader(joint)
            coupled |= {joint.name, leader.name} if leader else set()
        mass, moves = [body["mass"] for body in bodies], [False] * len(bodies)
        largest, unfelt, whole = sum(mass) * length_of(facts) ** 2, [], carried(facts)
        for name in reversed(order[1:]):
            i, joint = number[name], self.above[name]
            felt = mass[i] > 0.0
            if felt and joint.kind == "hinge" and not moves[i]:
                turned = felt_inertia(whole[i], {"type": "hinge"} | self.line_of(joint))
                felt = turned > HELD_INERTIA_ROUNDING * largest
            if joint.kind != "fixed" and not felt and joint.name not in coupled:
                joint.kind = "fixed"
                unfelt.append(f"'{joint.name}'")
            parent = bodies[i]["parent"]
            mass[parent] += mass[i]
            moves[parent] = moves[parent] or moves[i] or joint.kind != "fixed"
        for i, name in enumerate(order, 1):
            if i > 1 and self.above[name].kind == "fixed":
                bodies[i]["weld"] = bodies[bodies[i]["parent"]]["weld"]
        if unfelt:
            self.said.append(f"welded, as nothing that has mass can feel it: {', '.join(reversed(unfelt))}")

    def line_of(self, joint: Connection) -> Facts:
        """Return point and direction of the axis of a joint, world."""
        link = self.links[joint.child]
        return {"anchor": link.pose[0], "axis": matrix(link.pose[1]) @ joint.axis}

    def base(self, facts: Facts, root: str) -> None:
        """Fix the root to the world or let it float."""
        bodies = facts["bodies"]
        mass = sum(body["mass"] for body in bodies if body["weld"] == 1)
        moving = any(joint.kind != "fixed" for joint in self.joints.values())
        floats = self.floating
        if floats and (root == WORLD or not mass):
            why = "is the fixed frame" if root == WORLD else "has no mass"
            raise InputError(f"floating=True: the root '{root}' {why}; give floating=False, or a root with a mass")
        if floats is None:
            floats = root != WORLD and mass > 0.0 and not moving
            if root != WORLD and mass > 0.0 and moving:
                self.chosen.append(f"{root} is fixed; floating=True frees it, floating=False says so")
        if floats:
            self.said.append("floating base")
            facts["joints"].append(unloaded(f"{root} floats", "free", 1) | {"anchor": bodies[1]["position"]})
            return
        for body in bodies:
            body["weld"] = 0 if body["weld"] == 1 else body["weld"]

    def list_joints(self, facts: Facts, number: dict[str, int]) -> dict[str, int]:
        """List joints that move, with dampers, friction and limits; return the number of each."""
        places = {}
        for joint in self.joints.values():
            if joint.kind == "fixed":
                continue
            fact = unloaded(joint.name, joint.kind, number[joint.child]) | self.line_of(joint)
            self.load(joint, fact)
            places[joint.name] = len(facts["joints"])
            facts["joints"].append(fact)
        return places

    def load(self, joint: Connection, fact: Facts) -> None:
        """Return dynamics and limits of a joint."""
        node, single = joint.node, joint.kind in ("hinge", "slide")
        dynamics, limits = node.one("dynamics"), node.one("limit")
        if dynamics is not None:
            values = {name: dynamics.number(name, 0.0) for name in ("damping", "friction")}
            for name, value in values.items():
                if value < 0.0:
                    raise InputError(f"{dynamics.place}: {name} of joint '{joint.name}' is {value:g} < 0; give >= 0")
            for name in dynamics.others(tuple(values)):
                self.add("passive", f"{name} of {joint.name}, which is not read", joint)
            if single:
                fact |= values
            elif any(values.values()):
                self.add("passive", f"damping or friction of {joint.name}", joint)
        if limits is not None:
            lower, upper = (limits.number(side, 0.0) for side in ("lower", "upper"))
            given = {"lower", "upper"} & set(limits.attributes)
            if single and given and node.attributes["type"] != "continuous":
                if lower <= upper:
                    fact["limit"] = [lower - joint.start, upper - joint.start]
                else:
                    self.add("limit", f"range of {joint.name}, whose lower end is the higher one", joint)
            elif given and joint.kind in ("ball", "planar"):
                self.add("limit", f"range of {joint.name}", joint)
            for kind in ("effort", "velocity"):
                if kind in limits.attributes:
                    self.add(kind, joint.name, joint)
        if node.one("safety_controller") is not None:
            self.add("safety", joint.name, joint)

    def list_mimics(self, facts: Facts, places: dict[str, int]) -> None:
        """List couplings of followers to their leaders."""
        for name, place in places.items():
            joint = self.joints[name]
            leader = self.leader(joint)
            if leader is None:
                continue
            title = f"{name} by {leader.name}"
            self.places["equality", title] = joint.node.place
            if joint.kind not in ("hinge", "slide") or leader.kind not in ("hinge", "slide", "fixed"):
                self.add("equality", f"{title}: {joint.kind} and {leader.kind}", joint)
                continue
            leads = places.get(leader.name, -1)
            polynomial = [0.0, mimic_of(joint)[0] if leads >= 0 else 0.0, 0.0, 0.0, 0.0]
            facts["equalities"].append(
                {"name": title, "type": "joint", "joints": [place, leads], "polynomial": polynomial}
            )

    def motors(self, places: dict[str, int]) -> list[Facts]:
        """Return a motor of every hinge and slide that follows no other, as the format has no actuators of its own."""
        found = []
        for name, place in places.items():
            joint = self.joints[name]
            if joint.kind not in ("hinge", "slide") or self.leader(joint) is not None:
                continue
            limits = joint.node.one("limit")
            effort = limits.number("effort", 0.0) if limits is not None else 0.0
            plain = {"why": "", "gain": 1.0, "constant": 0.0, "stiffness": 0.0, "damping": 0.0, "origin": 0.0}
            span = [-effort, effort] if effort > 0.0 else None
            found.append({"name": name, "joint": place, "range": span, "limited": False} | plain)
        return found

    def look(self, link: Link, visual: Node) -> tuple[Facts | None, Pose]:
        return self.geom(visual), place_in_parent(visual.one("origin"))

    def geom(self, visual: Node) -> Facts | None:
        """Return kind and sizes of a visual; None, and the file missing, for a mesh that is not there or not plain."""
        geometry = visual.one("geometry")
        shape = geometry.children[0] if geometry and geometry.children else visual
        match shape.tag:
            case "box":
                return {"type": "box", "size": 0.5 * positive(shape, "size", 3)}
            case "sphere":
                return {"type": "sphere", "size": [positive(shape, "radius", 1)[0]] * 3}
            case "cylinder" | "capsule":
                radius, length = positive(shape, "radius", 1)[0], positive(shape, "length", 1)[0]
                return {"type": shape.tag, "size": [radius, 0.5 * length, 0.0]}
            case "mesh":
                return self.mesh(shape.text("filename"), shape.numbers("scale", 3, (1.0, 1.0, 1.0)))
        raise InputError(f"{shape.place}: is not a shape that is drawn; give box, sphere, cylinder or mesh")

    @cached_property
    def materials(self) -> dict[str | None, list[Node]]:
        """Return the materials of the file by name."""
        found: dict[str | None, list[Node]] = {}
        for material in self.root.all("material"):
            found.setdefault(material.attributes.get("name"), []).append(material)
        return found

    def colour(self, visual: Node) -> list[float] | None:
        """Return red, green, blue of a visual, or of the material of its name; None where it has none."""
        material = next(iter(visual.all("material")), None)
        if material is None:
            return None
        for source in (material, *self.materials.get(material.attributes.get("name"), ())):
            for colour in source.all("color"):
                try:
                    return [float(x) for x in colour.numbers("rgba", 4)[:3].clip(0.0, 1.0)]
                except InputError:
                    return None
        return None


def once_each(nodes: Sequence[Node], read: Callable[[Node], Named]) -> list[Named]:
    """Read all elements of a tag; their names differ."""
    found: dict[str, Named] = {}
    for node in nodes:
        part = read(node)
        if part.name in found:
            raise InputError(f"{node.place}: a second {node.tag} is named '{part.name}'; give each its own name")
        found[part.name] = part
    return list(found.values())


def check_case(node: Node, known: tuple[str, ...]) -> None:
    """Refuse tags that are known but for their case, which readers pass over without a word."""
    for child in node.children:
        if child.tag not in known and child.tag.lower() in known:
            raise InputError(f"{child.place}: is not read in this case; write <{child.tag.lower()}>")


def mimic_of(joint: Connection) -> tuple[float, float]:
    """Return multiplier and offset of a follower."""
    mimic = joint.node.one("mimic") or joint.node
    return mimic.number("multiplier", 1.0), mimic.number("offset", 0.0)


def place_in_parent(origin: Node | None) -> tuple[np.ndarray, np.ndarray]:
    """Return position and quaternion of an <origin>: roll about x, then pitch about y, then yaw about z, fixed axes."""
    if origin is None:
        return np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])
    roll, pitch, yaw = origin.numbers("rpy", 3, (0.0, 0.0, 0.0))
    turn = multiply(rotation("z", yaw), multiply(rotation("y", pitch), rotation("x", roll)))
    return origin.numbers("xyz", 3, (0.0, 0.0, 0.0)), turn


def positive(node: Node, name: str, count: int) -> np.ndarray:
    """Return lengths > 0 [m]."""
    found = node.numbers(name, count)
    if found.min() <= 0.0:
        raise InputError(f"{node.place}: {name} is not positive; give lengths > 0")
    return found
