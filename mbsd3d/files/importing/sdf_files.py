"""SDF files put together: the models they include from other files, and older versions in the terms of newer ones."""

from collections.abc import Iterator
from pathlib import Path

from ...base.errors import InputError
from ...base.paths import read_text
from .folders import Folders
from .xml_scan import EXPANDED_ELEMENTS_MAX, FILES_BYTES_MAX, INCLUDED_FILES_MAX
from .xml_tree import Node, is_marked, is_true, numbers_of, tree_of, words_of

VERSION_MIN = (1, 4)  # before it, elements had other names
FRAMED_VERSION = (1, 7)  # the first one whose poses and axes name their frames
DEPTH_MAX = 200  # [models] in each other
MODEL_FILES = ("model.config", "model.sdf")  # of a folder that is a model, the first of which names its SDF file
MODEL_TAGS = ("model", "merged")
"""A model with frames of its own, and one whose parts are as if they stood in the model around it."""


class SdfFiles:
    """An SDF file and those it includes, all from folders that may be read."""

    def __init__(self, path: Path, folders: Folders) -> None:
        self.folders, self.real = folders, path.resolve()
        self.bytes, self.elements = 0, 0
        self.said: list[str] = []
        self.lost: list[tuple[str, str]] = []  # models that are not found, and where they are included
        self.roots: dict[Path, Node] = {}  # of the files that are included
        self.root = self.read(path, None, "sdf")

    def whole(self) -> Node:
        """Return the root of the file, in which models stand for what includes them."""
        self.said += renew(self.root)
        return self.filled(self.root, (self.real,), 0)

    def read(self, path: Path, file: Path | None, tag: str) -> Node:
        """Read a file with a root of this tag; all files together are limited."""
        root = tree_of(path, read_text(path, FILES_BYTES_MAX - self.bytes), file)
        self.bytes += path.stat().st_size
        if root.tag != tag:
            raise InputError(f"'{path}': its root is <{root.tag}>, not <{tag}>; use the reader of its format")
        return root

    def root_of(self, path: Path) -> Node:
        """Return the root of an SDF file that is included, which is read once."""
        real = path.resolve()
        if real not in self.roots:
            self.roots[real] = self.read(path, path, "sdf")
            self.said += renew(self.roots[real])
        return self.roots[real]

    def filled(self, node: Node, line: tuple[Path, ...], depth: int) -> Node:
        """Return an element with the models that are included in it; ``line``: the files that include each other."""
        if depth > DEPTH_MAX:
            raise InputError(f"{node.place}: more than {DEPTH_MAX} models in each other; use fewer")
        children: list[Node] = []
        for child in node.children:
            if child.tag == "population":
                raise InputError(f"{child.place}: its models are made where it runs; write them out")
            if child.tag == "include":
                children += self.included(child, line, depth + 1)
            else:
                children.append(self.filled(child, line, depth + 1) if child.tag in ("world", "model") else child)
        return Node(node.tag, node.attributes, node.line, children, node.content, node.file)

    def included(self, include: Node, line: tuple[Path, ...], depth: int) -> list[Node]:
        """Return the model of another file, under the name and at the pose that an <include> gives; or its lights."""
        uri = words_of(include.child("uri"))
        path = self.find(uri, include.folder) if uri else None
        if path is None:
            self.lost.append((uri[:80], include.place))
            return []
        real = path.resolve()
        if real in line or len(line) > INCLUDED_FILES_MAX:
            why = "includes itself" if real in line else f"is one of more than {INCLUDED_FILES_MAX} in each other"
            raise InputError(f"{include.place}: '{uri[:80]}' {why}; cut the circle")
        root = self.root_of(path)
        self.elements += sum(1 for _ in every(root))
        if self.elements > EXPANDED_ELEMENTS_MAX:
            raise InputError(f"{include.place}: more than {EXPANDED_ELEMENTS_MAX} elements are included; use fewer")
        models, others = root.all("model"), [child for child in root.children if child.tag in ("light", "actor")]
        if others and not models:
            return others
        if len(models) != 1:
            raise InputError(f"{include.place}: '{uri[:80]}' holds {len(models)} models; include a file of one")
        return [self.placed(include, self.filled(models[0], (*line, real), depth))]

    def placed(self, include: Node, model: Node) -> Node:
        """Return a model with what an <include> overrides: its name, pose, and whether it is static."""
        for child in include.children:
            if "params" in child.tag:
                raise InputError(f"{child.place}: changes the model where it runs; write the model as it becomes")
        given = {tag: node for tag in ("pose", "static") if (node := include.child(tag)) is not None}
        attributes = model.attributes | {"name": words_of(include.child("name"), model.text("name"))}
        if lead := words_of(include.child("placement_frame")):
            if "pose" not in given:
                raise InputError(f"{include.place}: has a <placement_frame> and no <pose> for it; give one")
            attributes["placement_frame"] = lead
        merged = is_marked(include, "merge")
        if merged and "static" in given:
            raise InputError(
                f"{include.place}: merges a model that it makes static; give <static> to the model around it"
            )
        kept = [child for child in model.children if child.tag not in given]
        tag = "merged" if merged else "model"
        return Node(tag, attributes, include.line, [*given.values(), *kept], file=include.file)

    def find(self, uri: str, base: Path | None) -> Path | None:
        """Return the file of a model: the one that is named, or that of a folder, by its model.config or its name."""
        bases = [base] if "://" in uri else [base, *self.folders.given]
        for folder in bases:
            for name in (uri, *(f"{uri.rstrip('/')}/{file}" for file in MODEL_FILES)):
                path = self.folders.find(name, folder)
                if path is not None:
                    return self.configured(path) if path.name == MODEL_FILES[0] else path
        return None

    def configured(self, config: Path) -> Path:
        """Return the SDF file of the newest version that a model.config names, which lies beside it."""
        files = self.read(config, config, "model").all("sdf")
        if not files:
            raise InputError(f"'{config}': names no <sdf>; give one")
        newest = max(files, key=lambda file: version_of(file) if file.attributes.get("version") else (0, 0))
        path = config.parent / words_of(newest)
        if not path.resolve().is_relative_to(config.parent.resolve()):
            raise InputError(
                f"{newest.place}: '{words_of(newest)[:60]}' lies elsewhere; put it beside the model.config"
            )
        return path


def every(node: Node) -> Iterator[Node]:
    """Yield an element and all below it."""
    waiting = [node]
    while waiting:
        one = waiting.pop()
        yield one
        waiting += one.children


def version_of(node: Node) -> tuple[int, ...]:
    """Return the version that an element names."""
    version = numbers_of(node.text("version").replace(".", " ", 1), 2, f"{node.place}: version")
    return tuple(int(x) for x in version)


def renew(root: Node) -> list[str]:
    """Write what versions before 1.7 say in the terms of the newer ones; return the joints that are renamed for it.

    The newer ones name the frames of poses and axes, and give no joint the name of a link.
    """
    said = []
    version = version_of(root)
    if version < VERSION_MIN:
        raise InputError(
            f"{root.place}: version {root.text('version')[:20]} is older than {'.'.join(map(str, VERSION_MIN))}, "
            "whose elements have other names; convert it, e.g. by: gz sdf -p FILE"
        )
    for node in every(root) if version < FRAMED_VERSION else ():
        if node.tag == "pose" and node.attributes.get("frame"):
            node.attributes["relative_to"] = node.attributes["frame"]
        if node.tag in ("axis", "axis2"):
            in_model = node.child("use_parent_model_frame")
            if is_true(node, "use_parent_model_frame") if in_model else version < (1, 5):
                xyz = node.child("xyz") or Node("xyz", {}, node.line, content="0 0 1", file=node.file)
                xyz.attributes["expressed_in"] = "__model__"
                node.children = [xyz, *(child for child in node.children if child is not xyz)]
            node.children = [child for child in node.children if child is not in_model]
        if node.tag == "world" and node.child("gravity") is None:
            node.children += [x for physics in node.all("physics")[:1] for x in physics.all("gravity")]
        taken = {x.attributes.get("name") for x in node.all("link")} | {"world"} if node.tag == "model" else set()
        for joint in node.all("joint"):
            if (name := joint.attributes.get("name")) in taken:
                joint.attributes["name"] = f"{name} (joint)"
                said.append(f"joint '{name}' is named '{name} (joint)', as a link has its name")
    return said
