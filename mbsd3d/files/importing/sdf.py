"""Facts of an SDF file, version 1.7 and newer: links, joints and frames of one model or world, loops included.

Frames stand in a graph: each is placed in another one of its model, and attached to a link.
"""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...base.checks import check_size
from ...base.errors import InputError
from ...base.paths import read_text
from ...base.rotations import as_quaternion, matrix, multiply, quaternion_from_matrix, rotation
from .facts import Facts
from .folders import Folders
from .urdf import unloaded
from .xml_scan import FILES_BYTES_MAX
from .xml_tree import Node, numbers_of, tree_of

VERSION_MIN = (1, 7)  # before it, poses and axes were in other frames
CHAIN_MAX = 200  # [frames] that are placed in each other, and models in models
UNLIMITED = 1e15  # [rad, m, N, N m] from which a limit is none: the format has 1e16 or inf
ROOT = "__model__"  # the frame of a model itself
WORLD = "world"
GRAVITY = (0.0, 0.0, -9.8)  # [m/s^2] of a world that gives none
STANDARD_GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2] of a model without a world
AXIS_ALIGNMENT_MIN = 1 - 1e-9  # [1] cosine between the axis of a gearbox and that of its hinge
JOINT_AXES = {
    "revolute": ("hinge",), "continuous": ("hinge",), "prismatic": ("slide",), "screw": ("screw",), "ball": ("ball",),
    "universal": ("hinge", "hinge"), "revolute2": ("hinge", "hinge"), "fixed": (), "gearbox": (),
}  # fmt: skip
Pose = tuple[np.ndarray, np.ndarray]  # (3,) position [m], (4,) quaternion
AT_HOME: Pose = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])


def after(first: Pose, second: Pose) -> Pose:
    """Return the pose of a frame that is placed by ``second`` in a frame placed by ``first``."""
    e = multiply(first[1], second[1])
    return first[0] + matrix(first[1]) @ second[0], e / np.linalg.norm(e)


def inverse(pose: Pose) -> Pose:
    """Return the pose of the outer frame in the inner one."""
    e = pose[1] * (1.0, -1.0, -1.0, -1.0)
    return -(matrix(e) @ pose[0]), e


def words_of(node: Node | None, default: str = "") -> str:
    """Return the text inside an element."""
    return default if node is None else node.content.strip() or default


def number_in(parent: Node | None, tag: str, default: float) -> float:
    """Return the number inside a child, which may be infinite."""
    node = parent.child(tag) if parent else None
    text = words_of(node)
    if node is None or not text:
        return default
    if text.lstrip("+-").lower() in ("inf", "infinity"):
        return -np.inf if text.startswith("-") else np.inf
    return float(numbers_of(text, 1, node.place)[0])


def is_true(parent: Node, tag: str) -> bool:
    """Return whether the text inside a child is true."""
    node = parent.child(tag)
    text = words_of(node, "false").lower()
    if node is not None and text not in ("true", "1", "false", "0"):
        raise InputError(f"{node.place}: '{text[:40]}' is neither true nor false; correct it")
    return text in ("true", "1")


def raw_pose(parent: Node) -> tuple[Pose, str]:
    """Return the <pose> of an element and the name of the frame it is given in, "" for the usual one."""
    node = parent.child("pose")
    if node is None:
        return AT_HOME, ""
    form = node.attributes.get("rotation_format", "euler_rpy")
    relative, text = node.attributes.get("relative_to", "").strip(), words_of(node)
    if form == "quat_xyzw":
        values = numbers_of(text or "0 0 0 0 0 0 1", 7, node.place)
        x, y, z, w = values[3:]
        return (values[:3], as_quaternion([w, x, y, z], node.place)), relative
    if form != "euler_rpy":
        raise InputError(f"{node.place}: rotation_format '{form[:40]}'; give euler_rpy or quat_xyzw")
    values = numbers_of(text or "0 0 0 0 0 0", 6, node.place)
    roll, pitch, yaw = np.deg2rad(values[3:]) if node.attributes.get("degrees", "") in ("true", "1") else values[3:]
    return (values[:3], multiply(rotation("z", yaw), multiply(rotation("y", pitch), rotation("x", roll)))), relative


@dataclass(eq=False)
class Model:
    """A model, or the world: its frames by name, each a link, joint, frame or model."""

    node: Node
    key: str  # name in the model around it
    name: str  # with the names of the models around it, "outer::inner"; of the only one ""
    parent: "Model | None"
    static: bool
    frames: dict[str, Node] = field(default_factory=dict)
    inner: dict[str, "Model"] = field(default_factory=dict)
    placed: dict[str, Pose] = field(default_factory=dict)

    def full(self, name: str) -> str:
        """Return the name of a part with the names of the models around it."""
        return f"{self.name}::{name}" if self.name else name

    def all_models(self) -> Iterator["Model"]:
        """Yield this model and those inside."""
        yield self
        for inner in self.inner.values():
            yield from inner.all_models()

    def find(self, name: str, place: str) -> "tuple[Model, str]":
        """Return the model in which a frame stands, and its name there: "arm::hand" stands in the model "arm"."""
        scope, rest = self, name
        while "::" in rest:
            first, rest = rest.split("::", 1)
            if first not in scope.inner:
                raise InputError(f"{place}: '{name[:60]}' is in no model; name a frame of this model")
            scope = scope.inner[first]
        if rest in scope.inner:
            return scope, rest
        if rest not in scope.frames and rest not in (ROOT, WORLD):
            raise InputError(f"{place}: '{name[:60]}' is no link, joint or frame; name one of this model")
        return scope, rest

    def local(self, name: str, place: str, seen: tuple[Any, ...] = ()) -> Pose:
        """Return the pose of a frame in that of this model."""
        scope, inner = self.find(name, place)
        pose = scope.own(inner, place, seen)
        while scope is not self and scope.parent is not None:
            pose = after(scope.parent.own(scope.key, place, seen), pose)
            scope = scope.parent
        return pose

    def own(self, name: str, place: str, seen: tuple[Any, ...] = ()) -> Pose:
        """Return the pose of a frame that stands in this model, in the frame of the model."""
        if name == ROOT or (name == WORLD and self.parent is None):
            return AT_HOME
        if name == WORLD:
            return inverse(self.in_world(place, seen))
        if name in self.placed:
            return self.placed[name]
        key = (id(self), name)
        if key in seen or len(seen) > CHAIN_MAX:
            why = "is placed in itself" if key in seen else f"is the end of more than {CHAIN_MAX} frames in each other"
            raise InputError(f"{place}: frame '{name}' {why}; cut the chain")
        node, line = self.frames[name], (*seen, key)
        pose, relative = raw_pose(node)
        if not relative:
            relative = node.attributes.get("attached_to", "") if node.tag == "frame" else ""
            relative = words_of(node.child("child")) if node.tag == "joint" else relative
        if node.tag == "model" and (lead := node.attributes.get("placement_frame")):
            inner = self.inner[name]
            pose = after(pose, inverse(inner.local(lead, node.place, line)))
        found = after(self.local(relative, node.place, line), pose) if relative else pose
        check_size(found[0], node.place)
        self.placed[name] = found
        return found

    def in_world(self, place: str, seen: tuple[Any, ...] = ()) -> Pose:
        """Return the pose of the frame of this model in the world."""
        if self.parent is None:
            return AT_HOME
        return after(self.parent.in_world(place, seen), self.parent.own(self.key, place, seen))

    def pose(self, name: str, place: str) -> Pose:
        """Return the pose of a frame in the world."""
        return after(self.in_world(place), self.local(name, place))

    def link(self, name: str, place: str, count: int = 0) -> str:
        """Return the full name of the link to which a frame is attached; the world is "world"."""
        if count > CHAIN_MAX:
            raise InputError(f"{place}: frame '{name}' is attached to itself; cut the chain")
        scope, inner = self.find(name, place)
        if inner == WORLD:
            return WORLD
        if inner in scope.inner:
            scope, inner = scope.inner[inner], ROOT
        if inner == ROOT:
            if scope.parent is None:
                return WORLD
            return scope.canonical(place, count)
        node = scope.frames[inner]
        match node.tag:
            case "link":
                return scope.full(inner)
            case "joint":
                return scope.link(words_of(node.child("child")), node.place, count + 1)
        return scope.link(node.attributes.get("attached_to", "").strip() or ROOT, node.place, count + 1)

    def canonical(self, place: str, count: int) -> str:
        """Return the full name of the link that carries the frame of this model."""
        given = self.node.attributes.get("canonical_link", "").strip()
        if given:
            return self.link(given, self.node.place, count + 1)
        for child in self.node.children:
            if child.tag == "link":
                return self.full(child.text("name"))
        for inner in self.inner.values():
            return inner.canonical(place, count + 1)
        raise InputError(f"{self.node.place}: model '{self.key}' has no link; give it one")


@dataclass
class Link:
    """A link: what it weighs about its own frame, and where it is."""

    name: str
    node: Node | None
    model: Model | None
    pose: Pose
    mass: float = 0.0
    com: np.ndarray = field(default_factory=lambda: np.zeros(3))
    inertia: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
    weightless: bool = False  # gravity does not act on it


@dataclass
class Connection:
    """A joint between links, with its axes in the world."""

    name: str
    node: Node
    model: Model
    kind: str
    parent: str
    child: str
    anchor: np.ndarray
    axes: list[np.ndarray]


class SdfModel:
    """An SDF file."""

    def __init__(self, path: Path, folders: Folders) -> None:
        self.root, self.folders = tree_of(path, read_text(path, FILES_BYTES_MAX)), folders
        if self.root.tag != "sdf":
            raise InputError(f"'{path}': its root is <{self.root.tag}>, not <sdf>; use the reader of its format")
        self.idle: Counter[str] = Counter()
        self.said: list[str] = []
        self.missing: list[str] = []
        self.foreign: list[Facts] = []
        self.places: dict[tuple[str, str], str] = {}

    def place_of(self, tag: str, name: str) -> str:
        """Return line and element of a link ("body"), joint, or coupling ("equality")."""
        return self.places.get((tag, name), "")

    def read_world(self) -> Model:
        """Read the frames of the only world or model of the file."""
        root, version = self.root, self.root.text("version")
        if tuple(numbers_of(version.replace(".", " ", 1), 2, f"{root.place}: version")) < VERSION_MIN:
            raise InputError(
                f"{root.place}: version {version[:20]} places poses and axes in other frames than 1.7 and newer; "
                "convert it, e.g. by: gz sdf -p FILE"
            )
        tops = [child for child in root.children if child.tag in ("world", "model")]
        if len(tops) != 1:
            have = ", ".join(f"'{child.attributes.get('name', '')}'" for child in tops[:5]) or "none"
            raise InputError(f"{root.place}: it holds more or less than one world or model ({have}); give one")
        self.top = tops[0]
        models = self.top.all("model") if self.top.tag == "world" else tops
        self.only = models[0] if len(models) == 1 else None  # whose name is not repeated before those of its parts
        world = self.top if self.top.tag == "world" else Node("world", {}, root.line, [self.top])
        return self.read_model(world, "", "", None, False, 0)

    def read_model(self, node: Node, key: str, name: str, parent: Model | None, static: bool, depth: int) -> Model:
        """Read the frames of a model, and the models in it."""
        if depth > CHAIN_MAX:
            raise InputError(f"{node.place}: more than {CHAIN_MAX} models in each other; use fewer")
        if node.tag == "model":
            static = static or is_true(node, "static")
        made = Model(node, key, name, parent, static)
        for child in node.children:
            if child.tag in ("include", "population"):
                uri = words_of(child.child("uri")) or words_of(child.child("model"))
                raise InputError(
                    f"{child.place}: model '{uri[:60]}' is not read from another file; put it into this one, e.g. by: "
                    "gz sdf -p FILE"
                )
            if child.tag not in ("link", "joint", "frame", "model"):
                self.idle.update([child.tag] if child.tag not in ("pose", "static", "gravity", "state") else ())
                continue
            own = child.text("name")
            if own in made.frames or own in (ROOT, WORLD) or "::" in own:
                why = "another frame has" if own in made.frames else "is reserved or has '::'"
                raise InputError(f"{child.place}: the name '{own[:60]}' {why}; give another one")
            made.frames[own] = child
            if child.tag == "model":
                full = "" if child is self.only else made.full(own)
                made.inner[own] = self.read_model(child, own, full, made, static, depth + 1)
        return made

    def facts(self) -> Facts:
        """Return bodies, joints, loops and couplings for the builder."""
        self.world = self.read_world()
        models = list(self.world.all_models())
        self.links = {WORLD: Link(WORLD, None, None, AT_HOME)}
        for model in models:
            for name, node in model.frames.items():
                if node.tag == "link":
                    link = self.link(model, name, node)
                    self.links[link.name] = link
        if len(self.links) == 1:
            raise InputError("it has no <link>; give links")
        self.joints = [
            self.joint(model, name, node)
            for model in models
            for name, node in model.frames.items()
            if node.tag == "joint"
        ]
        facts: Facts = {"equalities": [], "gravity": self.gravity()}
        facts["bodies"], facts["joints"] = self.laid_out()
        self.list_couplings(facts)
        self.list_contacts()
        points = [
            {"name": model.full(name), "body": self.number[link], "position": pose[0], "axes": matrix(pose[1])}
            for model in models
            for name, node in model.frames.items()
            if node.tag == "frame"
            for link, pose in [(model.link(name, node.place), model.pose(name, node.place))]
        ]
        return facts | {
            "points": points, "foreign": self.foreign, "idle": dict(self.idle), "said": self.said,
            "missing": self.missing, "keys": self.keys(facts),
        }  # fmt: skip

    def gravity(self) -> np.ndarray:
        """Return the gravity of the world; a model alone has none, and takes the standard one."""
        if self.top.tag == "model":
            self.said.append("gravity is 9.81 m/s^2 along -z, as the file has no world")
            return np.array(STANDARD_GRAVITY)
        node = self.top.child("gravity")
        return np.array(GRAVITY) if node is None else numbers_of(words_of(node), 3, node.place)

    def link(self, model: Model, name: str, node: Node) -> Link:
        """Read a link with its mass; what the file does not give is 1 kg and 1 kg m^2, as the format says."""
        full = model.full(name)
        self.places["body", full] = node.place
        self.idle.update(child.tag for child in node.children if child.tag not in ("inertial", "pose", "gravity"))
        if is_true(node, "kinematic"):
            raise InputError(f"{node.place}: link '{full}' is kinematic, no force moves it; make its model static")
        link = Link(full, node, model, model.pose(name, node.place), mass=1.0, inertia=np.eye(3))
        link.weightless = node.child("gravity") is not None and not is_true(node, "gravity")
        inertial = node.child("inertial")
        if inertial is None:
            return link
        if inertial.attributes.get("auto", "") in ("true", "1"):
            raise InputError(
                f"{inertial.place} of link '{full}': the mass follows from the geometry; give <mass> and <inertia>"
            )
        if inertial.child("fluid_added_mass") is not None:
            element = ("body", full)
            self.foreign.append({"kind": "fluid", "what": f"added mass of {full}", "element": element, "count": 1})
        link.mass = number_in(inertial, "mass", 1.0)
        if not 0.0 <= link.mass < np.inf:
            raise InputError(f"{inertial.place} of link '{full}': {link.mass:g} kg; give a finite mass >= 0")
        moments, I = inertial.child("inertia"), np.eye(3)
        for a, row in enumerate("xyz"):
            for b, column in enumerate("xyz"[a:], a):
                I[a, b] = I[b, a] = number_in(moments, f"i{row}{column}", 1.0 if a == b else 0.0)
        (link.com, turn), relative = raw_pose(inertial)
        if relative or not np.isfinite(I).all():
            raise InputError(f"{inertial.place} of link '{full}': give finite moments, and a pose in the link's frame")
        link.inertia = matrix(turn) @ I @ matrix(turn).T
        return link

    def joint(self, model: Model, name: str, node: Node) -> Connection:
        """Read a joint; its frame is in that of the child, its axes in that of the joint or in one that is named."""
        full, kind = model.full(name), node.text("type")
        self.places["joint", full] = node.place
        if kind not in JOINT_AXES:
            have = ", ".join(JOINT_AXES)
            raise InputError(f"{node.place}: joint '{full}' is of the type '{kind[:40]}'; give one of {have}")
        ends = []
        for side in ("parent", "child"):
            end = node.child(side)
            if end is None or not words_of(end):
                raise InputError(f"{node.place}: joint '{full}' has no <{side}>; name a link or frame")
            ends.append(model.link(words_of(end), end.place))
        r, _ = model.pose(name, node.place)
        count = {"gearbox": 2}.get(kind, len([x for x in JOINT_AXES[kind] if x != "ball"]))
        axes = [self.axis(model, name, node, tag) for tag in ("axis", "axis2")[:count]]
        return Connection(full, node, model, kind, ends[0], ends[1], r, axes)

    def axis(self, model: Model, name: str, node: Node, tag: str) -> np.ndarray:
        """Return the direction of an axis in the world."""
        axis = node.child(tag)
        xyz = axis.child("xyz") if axis else None
        if axis is None:
            raise InputError(f"{node.place}: joint '{name}' has no <{tag}>; give it")
        a = np.array([0.0, 0.0, 1.0]) if xyz is None else numbers_of(words_of(xyz), 3, xyz.place)
        frame = (xyz.attributes.get("expressed_in", "").strip() if xyz else "") or name
        if axis.child("use_parent_model_frame") is not None:
            raise InputError(f"{axis.place}: use_parent_model_frame is of older versions; give expressed_in={ROOT}")
        length = float(np.linalg.norm(a))
        if length == 0.0:
            raise InputError(f"{axis.place}: the axis of joint '{name}' has no length; give a direction")
        return matrix(model.pose(frame, axis.place)[1]) @ a / length

    def laid_out(self) -> tuple[list[Facts], list[Facts]]:
        """Return bodies, in the order of a tree of joints, and joints; those that close loops come last."""
        names = list(self.links)
        rigid = {name: name for name in names}

        def root(name: str) -> str:
            while rigid[name] != name:
                rigid[name] = rigid[rigid[name]]
                name = rigid[name]
            return name

        def join(a: str, b: str) -> None:
            first, second = sorted((root(a), root(b)), key=names.index)
            rigid[second] = first

        for link in self.links.values():
            if link.model is not None and link.model.static:
                join(WORLD, link.name)
        for joint in self.joints:
            if joint.kind == "fixed":
                join(joint.parent, joint.child)
        self.group = {name: root(name) for name in names}
        for link in self.links.values():
            if link.node and link.node.child("inertial") is None and self.group[link.name] != WORLD:
                self.said.append(f"'{link.name}' has no <inertial>: 1 kg and 1 kg m^2, as the format says")
        members: dict[str, list[str]] = {}
        for name in names:
            members.setdefault(self.group[name], []).append(name)
        moving = [joint for joint in self.joints if JOINT_AXES[joint.kind]]
        touching: dict[str, list[Connection]] = {name: [] for name in members}
        for joint in moving:
            for end in {self.group[joint.parent], self.group[joint.child]}:
                touching[end].append(joint)
        bodies: list[Facts] = []
        facts: list[Facts] = []
        self.number: dict[str, int] = {}
        self.hinges: dict[str, int] = {}
        spanned: set[int] = set()

        def place(group: str, parent: int) -> None:
            for name in members[group]:
                self.number[name] = len(bodies)
                bodies.append(self.body(self.links[name], parent if name == group else self.number[group]))
                bodies[-1]["weld"] = self.number[group]

        for start in members:
            if start in self.number:
                continue
            place(start, 0)
            if start != WORLD:
                position = bodies[self.number[start]]["position"]
                facts.append(unloaded(f"{start} floats", "free", self.number[start]) | {"anchor": position})
            queue = [start]
            for group in queue:
                for joint in touching[group]:
                    ends = (joint.parent, joint.child)
                    near, far = ends if self.group[ends[0]] == group else ends[::-1]
                    if self.group[far] in self.number:
                        continue
                    spanned.add(id(joint))
                    place(self.group[far], self.number[near])
                    self.list_joint(facts, joint, self.number[self.group[far]], far == joint.parent, None)
                    queue.append(self.group[far])
        for n, joint in enumerate(joint for joint in moving if id(joint) not in spanned):
            if self.group[joint.parent] == self.group[joint.child]:
                self.said.append(f"joint '{joint.name}' moves nothing: its links are one body")
                continue
            ends, turned = (joint.parent, joint.child), joint.child == WORLD or self.group[joint.child] == WORLD
            before, last = ends[::-1] if turned else ends
            loop = {"parent": self.number[before], "loop": -1 - n}
            self.list_joint(facts, joint, self.number[self.group[last]], turned, loop)
        return bodies, facts

    def body(self, link: Link, parent: int) -> Facts:
        """Return a link as a body."""
        (r, e), R = link.pose, matrix(link.pose[1])
        return {
            "name": link.name, "parent": parent, "position": r, "quaternion": e, "mass": link.mass,
            "centre": r + R @ link.com, "inertia": R @ link.inertia @ R.T, "gravcomp": float(link.weightless),
            "geoms": self.geoms(link),
        }  # fmt: skip

    def list_joint(self, facts: list[Facts], joint: Connection, body: int, turned: bool, loop: Facts | None) -> None:
        """List a joint by its coordinates; where the parent is carried by the child, in the reverse order and sense."""
        kinds = JOINT_AXES[joint.kind]
        parts = []
        for k, kind in enumerate(kinds):
            name = joint.name if len(kinds) == 1 else f"{joint.name} {k + 1}"
            self.places.setdefault(("joint", name), joint.node.place)
            axis = np.array([1.0, 0.0, 0.0]) if kind == "ball" else joint.axes[k] * (-1.0 if turned else 1.0)
            own = {"title": joint.name, "anchor": joint.anchor, "axis": axis}
            fact = unloaded(name, kind, body) | own | (loop or {})
            if kind != "ball":
                self.load(fact, joint.node.child(("axis", "axis2")[k]), joint, name)
            if kind == "screw":
                fact["pitch"] = screw_pitch(joint.node)
            parts.append(fact)
        for fact in reversed(parts) if turned else parts:
            self.hinges[fact["name"]] = len(facts)
            facts.append(fact)

    def load(self, fact: Facts, axis: Node | None, joint: Connection, name: str) -> None:
        """Set springs, dampers, friction and limits of an axis."""
        if axis is None:
            return
        dynamics, limit = axis.child("dynamics"), axis.child("limit")
        fact["stiffness"], fact["rest"] = (number_in(dynamics, f"spring_{x}", 0.0) for x in ("stiffness", "reference"))
        fact |= {load: number_in(dynamics, load, 0.0) for load in ("damping", "friction")}
        for load in ("stiffness", "rest", "damping", "friction"):
            if not np.isfinite(fact[load]):
                raise InputError(f"{axis.place}: {load} of joint '{name}' is not finite; correct it")
        lower, upper = number_in(limit, "lower", -np.inf), number_in(limit, "upper", np.inf)
        ends = [None if abs(x) >= UNLIMITED else x for x in (lower, upper)]
        if ends != [None, None] and joint.kind != "continuous":
            if lower <= upper:
                fact["limit"] = ends
            else:
                self.add("limit", f"range of {name}, whose lower end is the higher one", joint)
        for kind in ("effort", "velocity"):
            if 0.0 <= number_in(limit, kind, -1.0) < UNLIMITED:
                self.add(kind, name, joint)

    def add(self, kind: str, what: str, joint: Connection, count: int = 1) -> None:
        """Keep something that is not among the facts."""
        self.foreign.append({"kind": kind, "what": what, "element": ("joint", joint.name), "count": count})

    def list_couplings(self, facts: Facts) -> None:
        """List gearboxes and mimics."""
        for joint in self.joints:
            if joint.kind == "gearbox":
                self.list_gearbox(facts, joint)
            for k, tag in enumerate(("axis", "axis2")[: len(JOINT_AXES[joint.kind])]):
                axis = joint.node.child(tag)
                mimic = axis.child("mimic") if axis else None
                if mimic is not None:
                    self.list_mimic(facts, joint, k, mimic)

    def list_gearbox(self, facts: Facts, joint: Connection) -> None:
        """List theta_2 = -ratio theta_1, the angles of parent and child from the reference body about both axes."""
        node = joint.node
        body, ratio = words_of(node.child("gearbox_reference_body")), number_in(node, "gearbox_ratio", 1.0)
        if not body or not np.isfinite(ratio) or ratio == 0.0:
            raise InputError(
                f"{node.place}: gearbox '{joint.name}' needs a <gearbox_reference_body>, from which both angles count, "
                "and a finite <gearbox_ratio> other than 0; give them"
            )
        reference = joint.model.link(body, node.place)
        (x, s1), (y, s2) = (
            self.hinge_of(joint, reference, end, axis)
            for end, axis in zip((joint.parent, joint.child), joint.axes, strict=True)
        )
        self.couple(facts, joint.name, node, y, x, -ratio * s1 * s2)

    def hinge_of(self, gearbox: Connection, reference: str, link: str, axis: np.ndarray) -> tuple[int, float]:
        """Return the number of the hinge between a reference body and a link, and its sense about an axis."""
        wanted = {self.group[reference], self.group[link]}
        for joint in self.joints:
            ends = [self.group[joint.parent], self.group[joint.child]]
            if JOINT_AXES[joint.kind] == ("hinge",) and set(ends) == wanted and joint.name in self.hinges:
                along = float(joint.axes[0] @ axis)
                if abs(along) > AXIS_ALIGNMENT_MIN:
                    return self.hinges[joint.name], np.sign(along) * (1.0 if ends[0] == self.group[reference] else -1.0)
        raise InputError(
            f"{gearbox.node.place}: gearbox '{gearbox.name}' finds no hinge along its axis between '{reference}' and "
            f"'{link}'; give a revolute joint there, or the axis of the one there is"
        )

    def list_mimic(self, facts: Facts, joint: Connection, k: int, mimic: Node) -> None:
        """List follower = multiplier (leader - reference) + offset, which must hold where the file puts them."""
        names = [f"{joint.name} {k + 1}" if len(JOINT_AXES[joint.kind]) == 2 else joint.name]
        lead = joint.model.full(mimic.text("joint"))
        second = mimic.attributes.get("axis", "axis") == "axis2"
        names.append(f"{lead} {2 if second else 1}" if f"{lead} 1" in self.hinges else lead)
        for name in names:
            if name not in self.hinges:
                raise InputError(f"{mimic.place}: '{name[:60]}' is no joint that moves; name one")
        factor, offset, zero = (number_in(mimic, tag, x) for tag, x in MIMIC_DEFAULTS.items())
        start = offset - factor * zero
        if not np.isfinite(start) or abs(start) > 1e-12:
            raise InputError(
                f"{mimic.place}: joint '{joint.name}' would start at {start:g}, and the file puts it at 0; correct the "
                "poses, or offset and reference"
            )
        self.couple(facts, f"{names[0]} by {names[1]}", mimic, self.hinges[names[0]], self.hinges[names[1]], factor)

    def couple(self, facts: Facts, title: str, node: Node, y: int, x: int, ratio: float) -> None:
        """List y = ratio x."""
        self.places["equality", title] = node.place
        polynomial = [0.0, ratio, 0.0, 0.0, 0.0]
        facts["equalities"].append({"name": title, "type": "joint", "joints": [y, x], "polynomial": polynomial})

    def list_contacts(self) -> None:
        """List links that could collide."""
        able = [link for link in self.links.values() if link.node and link.node.all("collision")]
        if len({self.group[link.name] for link in able}) > 1:
            what, element = f"{able[0].name} with {able[-1].name}, and perhaps others", ("body", able[0].name)
            self.foreign.append({"kind": "contact", "what": what, "element": element, "count": 0})

    def geoms(self, link: Link) -> list[Facts]:
        """Return what is drawn of a link; a look that is not understood is missing, and no more."""
        found: list[Facts] = []
        for visual in link.node.all("visual") if link.node else []:
            try:
                geometry, (pose, _) = visual.child("geometry"), raw_pose(visual)
                geom = self.geom(geometry.children[0]) if geometry and geometry.children else None
            except InputError as error:
                self.missing.append(str(error))
                continue
            if geom is not None:
                r, e = after(link.pose, pose)
                found.append(geom | {"position": r, "quaternion": e, "shown": True, "colour": colour_of(visual)})
        return found

    def geom(self, shape: Node) -> Facts | None:
        """Return kind and sizes of a visual; None, and the file missing, for what is not drawn."""
        radius = number_in(shape, "radius", 0.0)
        geom: Facts
        match shape.tag:
            case "box" | "ellipsoid":
                node = shape.child("size" if shape.tag == "box" else "radii")
                sizes = numbers_of(words_of(node), 3, shape.place)
                geom = {"type": shape.tag, "size": 0.5 * sizes if shape.tag == "box" else sizes}
            case "sphere":
                geom = {"type": "sphere", "size": [radius] * 3}
            case "cylinder" | "capsule":
                geom = {"type": shape.tag, "size": [radius, 0.5 * number_in(shape, "length", 0.0), 0.1]}
            case "mesh":
                name, scale = words_of(shape.child("uri")), shape.child("scale")
                factor = np.unique(numbers_of(words_of(scale, "1 1 1"), 3, shape.place))
                path = self.folders.find(name)
                if path is None or factor.size > 1 or factor[0] <= 0.0:
                    self.missing.append(f"{name}: {'mirrored or stretched' if path else 'not found'}")
                    return None
                return {"type": "file", "path": str(path), "scale": float(factor[0])}
            case _:
                raise InputError(f"{shape.place}: is no shape that is drawn; give box, sphere, cylinder or mesh")
        if min(geom["size"]) <= 0.0 or not np.isfinite(geom["size"]).all():
            raise InputError(f"{shape.place}: a size is not positive; give lengths > 0")
        return geom

    def keys(self, facts: Facts) -> list[Facts]:
        """Return the states of the world: poses and velocities of links, world axes."""
        nodes = self.top.all("state") if self.top.tag == "world" else []
        chains = [x["body"] for x in facts["joints"] if x["type"] != "free" and "loop" not in x]
        if nodes and len(chains) > len(set(chains)):
            self.said.append("states are not read, as links with joints of two axes have more coordinates than poses")
            return []
        return [self.key(node, facts, k) for k, node in enumerate(nodes)]

    def key(self, node: Node, facts: Facts, k: int) -> Facts:
        """Return one state; links it does not name stay where the model has them, at rest."""
        home = [np.concatenate(self.links[name].pose) for name in self.number]
        poses, twists = list(home), [np.zeros(6) for _ in home]
        waiting = [(child, self.world) for child in node.all("model")]
        for model, around in waiting:
            scope = around.inner.get(model.text("name"))
            if scope is None:
                raise InputError(f"{model.place}: the state names '{model.text('name')[:60]}', which is no model")
            waiting += [(child, scope) for child in model.all("model")]
            for link in model.all("link"):
                place = self.number.get(scope.full(link.text("name")))
                if place is None:
                    raise InputError(f"{link.place}: the state names '{link.text('name')[:60]}', which is no link")
                if link.child("pose") is not None:
                    poses[place] = np.concatenate(raw_pose(link)[0])
                velocity = link.child("velocity")
                if velocity is not None:
                    twists[place] = numbers_of(words_of(velocity), 6, velocity.place)
        time = node.child("sim_time")
        seconds = numbers_of(words_of(time), 2, time.place) if time else np.zeros(2)
        name = node.attributes.get("world_name", "state")
        return {
            "name": f"{name} {k + 1}" if k else name, "time": float(seconds @ (1.0, 1e-9)), "poses": poses,
            "twists": twists, "joints": [moved(x, facts["bodies"], home, poses) for x in facts["joints"]],
        }  # fmt: skip


def moved(joint: Facts, bodies: list[Facts], home: list[np.ndarray], poses: list[np.ndarray]) -> Facts:
    """Return what a joint has moved since the file's pose: the turn about its axis, or the way along it."""
    child = joint["body"]
    parent = joint["parent"] if "loop" in joint else bodies[child]["parent"]
    first, now = ([(x[k][:3], matrix(x[k][3:])) for k in (parent, child)] for x in (home, poses))
    back = first[0][1] @ now[0][1].T  # axes of the parent now -> as they were
    found = {"turns": joint["type"] in ("hinge", "screw"), "slides": joint["type"] == "slide", "value": 0.0}
    if found["turns"]:
        w, *v = quaternion_from_matrix(back @ now[1][1] @ first[1][1].T)
        found["value"] = 2.0 * float(np.arctan2(np.dot(v, joint["axis"]), w))
    if found["slides"]:
        way = back @ (now[1][0] - now[0][0]) - (first[1][0] - first[0][0])
        found["value"] = float(way @ joint["axis"])
    return found


MIMIC_DEFAULTS = {"multiplier": 1.0, "offset": 0.0, "reference": 0.0}


def screw_pitch(node: Node) -> float:
    """Return how far a screw moves along its axis a turn [m], right-handed.

    ``thread_pitch`` is an older element: rad/m, and left-handed where it is positive.
    """
    older = number_in(node, "thread_pitch", 0.0)
    if node.child("screw_thread_pitch") is None and node.child("thread_pitch") is not None:
        pitch = -2.0 * np.pi / older if older else np.inf
    else:
        pitch = number_in(node, "screw_thread_pitch", 1.0)
    if not np.isfinite(pitch):
        raise InputError(f"{node.place}: the pitch of the screw is not finite; give screw_thread_pitch [m] a turn")
    return pitch


def colour_of(visual: Node) -> list[float] | None:
    """Return red, green, blue of a visual, None where it has none."""
    material = visual.child("material")
    diffuse = material.child("diffuse") if material else None
    try:
        values = [] if diffuse is None else [float(x) for x in words_of(diffuse).split()[:3]]
        return [min(max(x, 0.0), 1.0) for x in values] if len(values) == 3 else None
    except ValueError:
        return None
