"""Frames of an SDF file: each is placed in another one of its model, and attached to a link."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...base.checks import check_size
from ...base.errors import InputError
from ...base.rotations import as_quaternion, matrix, multiply, rotation
from .model_file import AT_HOME, Pose, after
from .sdf_files import MODEL_TAGS
from .xml_tree import Node, is_marked, numbers_of, words_of

CHAIN_MAX = 200  # [frames] that are placed in each other
ROOT = "__model__"  # the frame of a model itself
WORLD = "world"


def inverse(pose: Pose) -> Pose:
    """Return the pose of the outer frame in the inner one."""
    e = pose[1] * (1.0, -1.0, -1.0, -1.0)
    return -(matrix(e) @ pose[0]), e


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
    roll, pitch, yaw = np.deg2rad(values[3:]) if is_marked(node, "degrees") else values[3:]
    return (values[:3], multiply(rotation("z", yaw), multiply(rotation("y", pitch), rotation("x", roll)))), relative


@dataclass(eq=False)
class Model:
    """A model, or the world: its frames by name, each a link, joint, frame or model."""

    node: Node
    key: str  # name in the model around it
    name: str  # with the names of the models around it, "outer::inner"; of the only one ""
    parent: "Model | None"
    static: bool
    merged: bool = False  # its parts are named and found as those of the model around it
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

    def scopes(self) -> Iterator["Model"]:
        """Yield this model and those that are merged into it."""
        yield self
        for inner in self.inner.values():
            if inner.merged:
                yield from inner.scopes()

    def find(self, name: str, place: str) -> "tuple[Model, str]":
        """Return the model in which a frame stands, and its name there: "arm::hand" stands in the model "arm"."""
        scope, rest = self, name
        while "::" in rest:
            first, rest = rest.split("::", 1)
            found = [x.inner[first] for x in scope.scopes() if first in x.inner]
            if not found:
                raise InputError(f"{place}: '{name[:60]}' is in no model; name a frame of this model")
            scope = found[0]
        if rest in (ROOT, WORLD):
            return scope, rest
        for one in scope.scopes():
            if rest in one.frames:
                return one, rest
        raise InputError(f"{place}: '{name[:60]}' is not a link, joint or frame; name one of this model")

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
        if node.tag in MODEL_TAGS and (lead := node.attributes.get("placement_frame")):
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
        for model in self.scopes():
            for child in model.node.all("link")[:1]:
                return model.full(child.text("name"))
        for inner in self.inner.values():
            return inner.canonical(place, count + 1)
        raise InputError(f"{self.node.place}: model '{self.key}' has no link; give it one")
