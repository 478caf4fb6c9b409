"""XML of a file as a tree of elements that know their lines."""

from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path

import numpy as np

from ...base.checks import check_size
from ...base.errors import InputError
from .xml_scan import EXPANDED_ELEMENTS_MAX, Parser

READ_ATTRIBUTES = {
    "origin": ("xyz", "rpy"), "axis": ("xyz",), "mass": ("value",), "mimic": ("joint", "multiplier", "offset"),
    "inertia": ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"),
}  # fmt: skip
"""Elements of which another attribute would mean another motion, as quat_xyzw of an origin does."""


@dataclass
class Node:
    """An element, with the line it starts in."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list["Node"] = field(default_factory=list)
    content: str = ""  # text inside

    @property
    def place(self) -> str:
        """Return line and element, for messages."""
        return f"line {self.line}, <{self.tag}>"

    def all(self, tag: str) -> list["Node"]:
        """Return the children of a tag."""
        return [child for child in self.children if child.tag == tag]

    def child(self, tag: str) -> "Node | None":
        """Return the only child of a tag, or None."""
        found = self.all(tag)
        if len(found) > 1:
            raise InputError(f"{found[1].place}: stands twice in <{self.tag}>; keep one")
        return found[0] if found else None

    def one(self, tag: str) -> "Node | None":
        """Return the only child of a tag, or None; an attribute that would be passed over is refused."""
        node = self.child(tag)
        if node is not None and (other := node.others(READ_ATTRIBUTES.get(tag, tuple(node.attributes)))):
            have = ", ".join(READ_ATTRIBUTES[tag])
            raise InputError(f"{node.place}: {other[0]} is not read; give {have}, or remove it")
        return node

    def others(self, known: tuple[str, ...]) -> list[str]:
        """Return the attributes beside those known, but for zeros and those of vendors, which have a prefix."""
        return [name for name, value in self.attributes.items() if name not in known and not is_idle(name, value)]

    def text(self, name: str) -> str:
        """Return an attribute that must be there."""
        value = self.attributes.get(name, "").strip()
        if not value:
            raise InputError(f"{self.place}: has no {name}; give {name}=")
        return value

    def numbers(self, name: str, count: int, default: tuple[float, ...] | None = None) -> np.ndarray:
        """Return an attribute of finite numbers; commas between those of a vector are passed over."""
        text = self.attributes.get(name)
        if text is None and default is not None:
            return np.array(default)
        return numbers_of(self.text(name), count, f"{self.place}: {name}")

    def number(self, name: str, default: float | None = None) -> float:
        """Return an attribute of one number."""
        return float(self.numbers(name, 1, None if default is None else (default,))[0])


def tree_of(path: Path, text: str) -> Node:
    """Return the root element of a text, with all below it."""
    root, count, parser = Node("", {}, 0), 0, Parser(path)
    stack = [root]

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if count > EXPANDED_ELEMENTS_MAX:
            raise InputError(
                f"{parser.place(f'<{name}>')} is one of more than {EXPANDED_ELEMENTS_MAX} elements; use fewer"
            )
        stack.append(Node(name, attributes, parser.line))
        stack[-2].children.append(stack[-1])

    def end(name: str) -> None:
        stack.pop()

    def read(words: str) -> None:
        stack[-1].content += words

    parser.parse(text, start, end, read)
    return root.children[0]


def numbers_of(text: str, count: int, what: str) -> np.ndarray:
    """Return finite numbers of a text; commas between them are passed over."""
    words = text.replace(",", " ").split()
    try:
        values = [float(word) for word in words if "_" not in word]
    except ValueError:
        values = []
    if len(values) != count or len(words) != count or not all(map(isfinite, values)):
        wanted = "a finite number" if count == 1 else f"{count} finite numbers"
        raise InputError(f"{what}='{text.strip()[:60]}' is not {wanted}; correct it")
    found = np.array(values)
    check_size(found, what)
    return found


def is_idle(name: str, value: str) -> bool:
    """Return whether an attribute has a prefix, or is nothing but zeros."""
    try:
        return ":" in name or not any(float(word) for word in value.split())
    except ValueError:
        return False
