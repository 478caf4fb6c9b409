"""What readers of links and joints share: links with their mass, joints without loads, looks, what is passed over."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ...base.errors import InputError
from ...base.rotations import matrix, multiply
from .facts import Facts
from .folders import Folders
from .xml_tree import Node

Pose = tuple[np.ndarray, np.ndarray]  # (3,) position [m], (4,) quaternion
AT_HOME: Pose = np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0])


def after(first: Pose, second: Pose) -> Pose:
    """Return the pose of a frame that is placed by ``second`` in a frame placed by ``first``."""
    e = multiply(first[1], second[1])
    return first[0] + matrix(first[1]) @ second[0], e / np.linalg.norm(e)


@dataclass
class Link:
    """A link: what it weighs about its own frame, and where that is."""

    name: str
    node: Node | None
    mass: float = 0.0
    com: np.ndarray = field(default_factory=lambda: np.zeros(3))
    inertia: np.ndarray = field(default_factory=lambda: np.zeros((3, 3)))
    pose: Pose = AT_HOME

    def facts(self, parent: int, weld: int) -> Facts:
        """Return the link as a body on another one, welded to itself or to one before."""
        (r, e), R = self.pose, matrix(self.pose[1])
        return {
            "name": self.name, "parent": parent, "weld": weld, "position": r, "quaternion": e, "mass": self.mass,
            "centre": r + R @ self.com, "inertia": R @ self.inertia @ R.T,
        }  # fmt: skip


def unloaded(name: str, kind: str, body: int) -> Facts:
    """Return a joint on which nothing acts."""
    loads = {"stiffness": 0.0, "damping": 0.0, "friction": 0.0, "armature": 0.0, "rest": 0.0, "limit": None}
    return {"name": name, "type": kind, "body": body, "axis": np.array([1.0, 0.0, 0.0])} | loads


class ModelFile:
    """A file of links and joints while it is read."""

    def __init__(self, folders: Folders) -> None:
        self.folders = folders
        self.idle: Counter[str] = Counter()
        self.said: list[str] = []
        self.missing: list[str] = []
        self.foreign: list[Facts] = []
        self.places: dict[tuple[str, str], str] = {}

    def place_of(self, tag: str, name: str) -> str:
        """Return line and element of a link ("body"), joint, or coupling ("equality")."""
        return self.places.get((tag, name), "")

    def add(self, kind: str, what: str, joint: Any, count: int = 1) -> None:
        """Keep something of a joint that is not among the facts."""
        self.foreign.append({"kind": kind, "what": what, "element": ("joint", joint.name), "count": count})

    def list_contacts(self, able: Sequence[tuple[str, Any]]) -> None:
        """List links that could collide, each with what it is rigidly connected to."""
        if len({group for _, group in able}) > 1:
            (first, _), *_, (last, _) = able
            what = f"{first} with {last}, and perhaps others"
            self.foreign.append({"kind": "contact", "what": what, "element": ("body", first), "count": 0})

    def geoms(self, link: Link) -> list[Facts]:
        """Return what is drawn of a link; a look that is not understood is missing, and no more."""
        found: list[Facts] = []
        for visual in link.node.all("visual") if link.node else []:
            try:
                geom, pose = self.look(link, visual)
            except InputError as error:
                self.missing.append(str(error))
                continue
            if geom is not None:
                r, e = after(link.pose, pose)
                found.append(geom | {"position": r, "quaternion": e, "shown": True, "colour": self.colour(visual)})
        return found

    def look(self, link: Any, visual: Node) -> tuple[Facts | None, Pose]:
        """Return kind and sizes of a visual, None for what is listed as missing, and its pose in the link."""
        raise NotImplementedError

    def colour(self, visual: Node) -> list[float] | None:
        """Return red, green, blue of a visual, None where it has none."""
        raise NotImplementedError

    def mesh(self, name: str, scale: np.ndarray, base: Path | None = None) -> Facts | None:
        """Return the file of a mesh; None, and the file missing, for one that is not there or not plain."""
        path, factor = self.folders.find(name, base), np.unique(scale)
        if path is not None and factor.size == 1 and factor[0] > 0.0:
            return {"type": "file", "path": str(path), "scale": float(factor[0])}
        self.missing.append(f"{name}: {'mirrored or stretched' if path else 'not found'}")
        return None
