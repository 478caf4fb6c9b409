"""Facts of an SDF file, version 1.7 and newer: links, joints and frames of one model or world, loops included.

Frames stand in a graph: each is placed in another one of its model, and attached to a link.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...base.errors import InputError
from ...base.inertia import box, capsule, cone, cylinder, ellipsoid
from ...base.mass_properties import MassProperties, put_together
from ...base.rotations import matrix, quaternion_from_matrix
from ...mechanism.shapes.solid_meshes import solid_of
from ...mechanism.shapes.triangles import MASS_TRIANGLES_MAX
from .facts import Facts
from .folders import Folders
from .model_file import Link, ModelFile, Pose, after, unloaded
from .sdf_files import MODEL_TAGS, SdfFiles
from .sdf_frames import ROOT, WORLD, Model, inverse, raw_pose
from .xml_tree import Node, is_marked, is_true, number_in, numbers_of, words_of

UNLIMITED = 1e15  # [rad, m, N, N m] from which a limit is none: the format has 1e16 or inf
GRAVITY = (0.0, 0.0, -9.8)  # [m/s^2] of a world that gives none
STANDARD_GRAVITY = (0.0, 0.0, -9.81)  # [m/s^2] of a model without a world
LOST_SHOWN_MAX = 5  # [1] models that are not found, which an error lists
DENSITY = 1000.0  # [kg/m^3] of geometry that gives the mass of a link, and has no density
AXIS_ALIGNMENT_MIN = 1 - 1e-9  # [1] cosine between the axis of a gearbox and that of its hinge
JOINT_AXES = {
    "revolute": ("hinge",), "continuous": ("hinge",), "prismatic": ("slide",), "screw": ("screw",), "ball": ("ball",),
    "universal": ("hinge", "hinge"), "revolute2": ("hinge", "hinge"), "fixed": (), "gearbox": (),
}  # fmt: skip


@dataclass
class SdfLink(Link):
    """A link of a model."""

    model: Model | None = None
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

    @property
    def ends(self) -> tuple[str, str]:
        """Return the names of parent and child."""
        return self.parent, self.child


class SdfModel(ModelFile):
    """An SDF file."""

    def __init__(self, path: Path, folders: Folders, floating: bool | None, leave_out: Sequence[str]) -> None:
        super().__init__(folders)
        self.files, self.floating, self.leave_out = SdfFiles(path, folders), floating, leave_out

    def read_world(self) -> Model:
        """Read the frames of the only world or model of the file."""
        root = self.files.whole()
        self.said += self.files.said
        self.check_found()
        tops = [child for child in root.children if child.tag in ("world", "model")]
        if len(tops) != 1:
            have = ", ".join(f"'{child.attributes.get('name', '')}'" for child in tops[:5]) or "none"
            raise InputError(f"{root.place}: it holds more or less than one world or model ({have}); give one")
        self.top = tops[0]
        models = self.top.all("model") if self.top.tag == "world" else tops
        self.only = models[0] if len(models) == 1 else None  # whose name is not repeated before those of its parts
        world = self.top if self.top.tag == "world" else Node("world", {}, root.line, [self.top])
        return self.read_model(world, Model(world, "", "", None, False))

    def check_found(self) -> None:
        """Refuse models that are included and not found, unless the caller leaves them out."""
        lost = self.files.lost
        for uri, place in lost:
            element = ("include", uri)
            self.places[element] = place
            self.foreign.append({"kind": "include", "what": f"model '{uri}'", "element": element, "count": 1})
        if lost and "include" not in self.leave_out:
            listed = ", ".join(f"'{uri}'" for uri, _ in lost[:LOST_SHOWN_MAX])
            more = f" and {len(lost) - LOST_SHOWN_MAX} more" if len(lost) > LOST_SHOWN_MAX else ""
            raise InputError(
                f"{lost[0][1]}: model {listed}{more} is not found in the folder of the file, above it, or in "
                'package_paths; give the folder it lies in with package_paths, or leave out with leave_out=["include"]'
            )

    def read_model(self, node: Node, made: Model) -> Model:
        """Read the frames of a model, and the models in it."""
        if node.tag == "model":
            made.static = made.static or is_true(node, "static")
        for child in node.children:
            if child.tag not in ("link", "joint", "frame", *MODEL_TAGS):
                self.idle.update([child.tag] if child.tag not in ("pose", "static", "gravity", "state") else ())
                continue
            own, merged = child.text("name"), child.tag == "merged"
            if own in (ROOT, WORLD) or "::" in own:
                raise InputError(f"{child.place}: the name '{own[:60]}' is reserved or has '::'; give another one")
            key = f"_merged__{own}__model__" if merged else own
            self.list_frame(made, key, child)
            if child.tag in MODEL_TAGS:
                full = made.name if merged else "" if child is self.only else made.full(own)
                made.inner[key] = Model(child, key, full, made, made.static, merged)
                self.read_model(child, made.inner[key])
        return made

    def list_frame(self, model: Model, name: str, node: Node) -> None:
        """List a frame of a model; all that are merged into one have different names."""
        whole = model
        while whole.merged and whole.parent is not None:
            whole = whole.parent
        if any(name in scope.frames for scope in whole.scopes()):
            raise InputError(f"{node.place}: the name '{name[:60]}' another frame has; give another one")
        model.frames[name] = node

    def facts(self) -> Facts:
        """Return bodies, joints, loops and couplings for the builder."""
        self.world = self.read_world()
        models = list(self.world.all_models())
        self.links = {WORLD: SdfLink(WORLD, None)}
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
        self.moving = [joint for joint in self.joints if JOINT_AXES[joint.kind]]
        self.number: dict[str, int] = {}  # of the body of a link
        self.hinges: dict[str, int] = {}  # number of the joint of a coordinate
        facts: Facts = {"equalities": [], "gravity": self.gravity()}
        facts["bodies"], facts["joints"] = self.laid_out()
        self.list_couplings(facts)
        able = [link.name for link in self.links.values() if link.node and link.node.all("collision")]
        self.list_contacts([(name, self.group[name]) for name in able])
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

    def link(self, model: Model, name: str, node: Node) -> SdfLink:
        """Read a link with its mass; what the file does not give is 1 kg and 1 kg m^2, as the format says."""
        full = model.full(name)
        self.places["body", full] = node.place
        self.idle.update(child.tag for child in node.children if child.tag not in ("inertial", "pose", "gravity"))
        if is_true(node, "kinematic"):
            raise InputError(f"{node.place}: link '{full}' is kinematic, no force moves it; make its model static")
        link = SdfLink(full, node, 1.0, inertia=np.eye(3), pose=model.pose(name, node.place), model=model)
        link.weightless = node.child("gravity") is not None and not is_true(node, "gravity")
        inertial = node.child("inertial")
        if inertial is None:
            return link
        if inertial.child("fluid_added_mass") is not None:
            element = ("body", full)
            self.foreign.append({"kind": "fluid", "what": f"added mass of {full}", "element": element, "count": 1})
        link.mass = number_in(inertial, "mass", 1.0)
        if not 0.0 <= link.mass < np.inf:
            raise InputError(f"{inertial.place} of link '{full}': {link.mass:g} kg; give a finite mass >= 0")
        if is_marked(inertial, "auto"):
            self.weigh(link, inertial)
            return link
        moments, I = inertial.child("inertia"), np.eye(3)
        for a, row in enumerate("xyz"):
            for b, column in enumerate("xyz"[a:], a):
                I[a, b] = I[b, a] = number_in(moments, f"i{row}{column}", 1.0 if a == b else 0.0)
        (link.com, turn), relative = raw_pose(inertial)
        if relative or not np.isfinite(I).all():
            raise InputError(f"{inertial.place} of link '{full}': give finite moments, and a pose in the link's frame")
        link.inertia = matrix(turn) @ I @ matrix(turn).T
        return link

    def weigh(self, link: SdfLink, inertial: Node) -> None:
        """Set the mass of a link by its collision geometry; a mass that is given scales the inertia."""
        node = link.node or inertial
        where = f"{inertial.place} of link '{link.name}'"
        parts = []
        for collision in node.all("collision"):
            density = number_in(collision, "density", number_in(inertial, "density", DENSITY))
            if not 0.0 < density < np.inf:
                raise InputError(f"{where}: the density is {density:g} kg/m^3; give a finite one > 0")
            solid, (r, e) = self.solid(collision, density, link.name), pose_in(link, collision)
            R = matrix(e)
            parts.append((solid.mass, r + R @ solid.com, R @ solid.inertia @ R.T))
        if not parts:
            raise InputError(f'{where}: auto="true" needs a <collision>; give one, or <mass> and <inertia>')
        whole = put_together(parts)
        share = 1.0 if inertial.child("mass") is None else link.mass / whole.mass
        link.mass, link.com, link.inertia = share * whole.mass, whole.com, share * whole.inertia

    def solid(self, collision: Node, density: float, link: str) -> MassProperties:
        """Return the mass properties of homogeneous geometry in its own frame."""
        shape = shape_of(collision)
        if shape.tag != "mesh":
            return primitive(geometry_of(shape), density)
        if shape.child("submesh") is not None:
            raise InputError(f"{shape.place}: gives the mass of link '{link}' by a part of it; give the part as a file")
        name = words_of(shape.child("uri"))
        path = self.folders.find(name, shape.folder)
        what = f"{shape.place}: mesh '{name}', which gives the mass of link '{link}'"
        if path is None:
            raise InputError(f"{what}, is not found; give its folder with package_paths, or <mass> and <inertia>")
        whole, _ = solid_of(str(path), density, 1.0, what, MASS_TRIANGLES_MAX)
        return scaled(whole, scale_of(shape))

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
        self.group = self.rigid_groups()
        members: dict[str, list[str]] = {}
        for name, group in self.group.items():
            members.setdefault(group, []).append(name)
        touching: dict[str, list[Connection]] = {group: [] for group in members}
        for joint in self.moving:
            for group in {self.group[end] for end in joint.ends}:
                touching[group].append(joint)
        bodies: list[Facts] = []
        facts: list[Facts] = []
        spanned: set[int] = set()
        for start in members:
            if start in self.number:
                continue
            self.place(bodies, members[start], 0)
            if start != WORLD:
                position = bodies[self.number[start]]["position"]
                facts.append(unloaded(f"{start} floats", "free", self.number[start]) | {"anchor": position})
            queue = [start]
            for group in queue:
                for joint in touching[group]:
                    near, far = joint.ends if self.group[joint.parent] == group else joint.ends[::-1]
                    if self.group[far] in self.number:
                        continue
                    spanned.add(id(joint))
                    self.place(bodies, members[self.group[far]], self.number[near])
                    self.list_joint(facts, joint, self.number[self.group[far]], far == joint.parent, None)
                    queue.append(self.group[far])
        self.close_loops(facts, [joint for joint in self.moving if id(joint) not in spanned])
        return bodies, facts

    def rigid_groups(self) -> dict[str, str]:
        """Return the first of the links that are fixed to each other, for all of them, and say what floats."""
        links = self.links.values()
        rigid = [joint.ends for joint in self.joints if joint.kind == "fixed"]
        rigid += [(WORLD, link.name) for link in links if link.model is not None and link.model.static]
        parts = connected(list(self.links), [*rigid, *(joint.ends for joint in self.moving)])
        floats = list(dict.fromkeys(part for part in parts.values() if part != WORLD))
        if self.floating and not floats:
            raise InputError(
                "floating=True: static models or joints hold all links to the world; take them out, or leave it out"
            )
        if self.floating is not False and set(connected(list(self.links), rigid).values()) == {WORLD}:
            raise InputError(
                "static models or fixed joints hold all links to the world, and nothing can move; take one of these out"
            )
        with_joints = {parts[joint.parent] for joint in self.moving}
        if self.floating is False:
            rigid += [(WORLD, part) for part in floats]
            self.said.append(f"fixed: {', '.join(floats)}") if floats else None
        elif self.floating is None and (free := [part for part in floats if part in with_joints]):
            verb = "float" if len(free) > 1 else "floats"
            self.said.append(f"{', '.join(free)} {verb}; floating=False fixes, floating=True says so")
        group = connected(list(self.links), rigid)
        for link in links:
            if link.node and link.node.child("inertial") is None and group[link.name] != WORLD:
                self.said.append(f"'{link.name}' has no <inertial>: 1 kg and 1 kg m^2, as the format says")
        return group

    def place(self, bodies: list[Facts], members: list[str], parent: int) -> None:
        """List links that are fixed to each other, the first of them on a body that is listed."""
        first = len(bodies)
        for name in members:
            self.number[name], link = len(bodies), self.links[name]
            more = {"gravcomp": float(link.weightless), "geoms": self.geoms(link)}
            bodies.append(link.facts(parent if name == members[0] else first, first) | more)

    def close_loops(self, facts: list[Facts], joints: list[Connection]) -> None:
        """List the joints beside the tree, each with both its bodies; the ground is never the second."""
        for n, joint in enumerate(joints):
            if self.group[joint.parent] == self.group[joint.child]:
                self.said.append(f"joint '{joint.name}' moves nothing: its links are one body")
                continue
            turned = self.group[joint.child] == WORLD
            before, last = joint.ends[::-1] if turned else joint.ends
            loop = {"parent": self.number[before], "loop": -1 - n}
            self.list_joint(facts, joint, self.number[self.group[last]], turned, loop)

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
                raise InputError(f"{mimic.place}: '{name[:60]}' is not a joint that moves; name one")
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

    def look(self, link: SdfLink, visual: Node) -> tuple[Facts | None, Pose]:
        shape, pose = shape_of(visual), pose_in(link, visual)
        if shape.tag == "mesh":
            return self.mesh(words_of(shape.child("uri")), scale_of(shape), shape.folder), pose
        return None if shape.tag in UNBOUNDED else geometry_of(shape), pose

    def colour(self, visual: Node) -> list[float] | None:
        material = visual.child("material")
        diffuse = material.child("diffuse") if material else None
        try:
            values = [] if diffuse is None else [float(x) for x in words_of(diffuse).split()[:3]]
            return [min(max(x, 0.0), 1.0) for x in values] if len(values) == 3 else None
        except ValueError:
            return None

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
                raise InputError(f"{model.place}: the state names '{model.text('name')[:60]}', which is not a model")
            waiting += [(child, scope) for child in model.all("model")]
            for link in model.all("link"):
                place = self.number.get(scope.full(link.text("name")))
                if place is None:
                    raise InputError(f"{link.place}: the state names '{link.text('name')[:60]}', which is not a link")
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


def connected(names: Sequence[str], pairs: Sequence[tuple[str, str]]) -> dict[str, str]:
    """Return, for each name, the first one of all that pairs connect it with."""
    before = {name: name for name in names}
    place = {name: n for n, name in enumerate(names)}

    def first(name: str) -> str:
        while before[name] != name:
            before[name] = before[before[name]]
            name = before[name]
        return name

    for a, b in pairs:
        one, other = sorted((first(a), first(b)), key=place.__getitem__)
        before[other] = one
    return {name: first(name) for name in names}


def pose_in(link: SdfLink, node: Node) -> Pose:
    """Return the pose of an element of a link in the frame of the link."""
    pose, frame = raw_pose(node)
    if not frame or link.model is None:
        return pose
    return after(after(inverse(link.pose), link.model.pose(frame, node.place)), pose)


def shape_of(parent: Node) -> Node:
    """Return the shape of a visual or collision."""
    geometry = parent.child("geometry")
    if geometry is None or not geometry.children:
        raise InputError(f"{parent.place}: has no <geometry> with a shape; give one")
    return geometry.children[0]


def scale_of(mesh: Node) -> np.ndarray:
    """Return the factors (3,) of a mesh along its axes."""
    return numbers_of(words_of(mesh.child("scale"), "1 1 1"), 3, mesh.place)


UNBOUNDED = ("plane", "heightmap", "image", "empty")
"""Shapes that are not drawn, and have no mass."""


def geometry_of(shape: Node) -> Facts:
    """Return kind and half sizes of a shape that is not a mesh."""
    radius, half = (number_in(shape, tag, 0.0) * share for tag, share in (("radius", 1.0), ("length", 0.5)))
    match shape.tag:
        case "box":
            size = 0.5 * numbers_of(words_of(shape.child("size")), 3, shape.place)
        case "ellipsoid":
            size = numbers_of(words_of(shape.child("radii")), 3, shape.place)
        case "sphere":
            size = np.full(3, radius)
        case "cylinder" | "capsule" | "cone":
            size = np.array([radius, half, radius])
        case _:
            raise InputError(
                f"{shape.place}: is not a solid; give box, sphere, cylinder, capsule, ellipsoid, cone or mesh"
            )
    if size.min() <= 0.0 or not np.isfinite(size).all():
        raise InputError(f"{shape.place}: a size is not positive; give lengths > 0")
    return {"type": shape.tag, "size": size}


def primitive(geometry: Facts, density: float) -> MassProperties:
    """Return the mass properties of a homogeneous shape about its own frame; the tip of a cone is along z."""
    a, b, c = sizes = geometry["size"]
    match geometry["type"]:
        case "box":
            m, com = density * 8.0 * a * b * c, 0.0
            I = box(m, 2.0 * sizes)
        case "sphere" | "ellipsoid":
            m, com = density * 4.0 / 3.0 * np.pi * a * b * c, 0.0
            I = ellipsoid(m, sizes)
        case "cylinder":
            m, com = density * 2.0 * np.pi * a**2 * b, 0.0
            I = cylinder(m, a, 2.0 * b)
        case "capsule":
            m, com = density * np.pi * a**2 * (2.0 * b + 4.0 / 3.0 * a), 0.0
            I = capsule(m, a, 2.0 * b)
        case _:
            m, com = density * 2.0 / 3.0 * np.pi * a**2 * b, -0.5 * b
            I = cone(m, a, 2.0 * b)
    return MassProperties(float(m), np.array([0.0, 0.0, com]), np.diag(I))


def scaled(whole: MassProperties, scale: np.ndarray) -> MassProperties:
    """Return the mass properties of a homogeneous solid that is stretched along its axes.

    With S = diag(scale) the mass grows by |det S|, and ``int x x' dm`` about the centre of mass to S (...) S times it.
    """
    S, more = np.diag(scale), abs(np.prod(scale))
    spread = more * S @ (0.5 * np.trace(whole.inertia) * np.eye(3) - whole.inertia) @ S
    return MassProperties(more * whole.mass, S @ whole.com, np.trace(spread) * np.eye(3) - spread)
