"""XML of a file as a tree of elements that know their lines."""

import re
from dataclasses import dataclass, field
from math import isfinite
from pathlib import Path

import numpy as np

from ...base.checks import MAGNITUDE_MAX, check_size
from ...base.errors import InputError
from .xml_scan import EXPANDED_ELEMENTS_MAX, Parser

COMMENT_PATTERN = re.compile(r"(<!\[CDATA\[.*?\]\]>)|<!--.*?-->", re.DOTALL)  # a comment, outside of plain text
INFINITE_PATTERN = re.compile(r"[+-]?inf(inity)?", re.IGNORECASE)
NUMBER_PATTERN = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
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
    file: Path | None = None  # that it stands in, None for the file that is read

    @property
    def place(self) -> str:
        """Return line and element, for messages, after the file if it is another one."""
        file = f"'{self.file.parent.name}/{self.file.name}', " if self.file else ""
        return f"{file}line {self.line}, <{self.tag}>"

    @property
    def folder(self) -> Path | None:
        """Return the folder from which it names files, None for that of the file that is read."""
        return self.file.parent if self.file else None

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


def tree_of(path: Path, text: str, file: Path | None = None) -> Node:
    """Return the root element of a text, with all below it; ``file``: see `Node`.

    Comments may come before the head, and hold "--", which XML forbids and other readers pass over.
    """
    text = COMMENT_PATTERN.sub(lambda found: found[1] or "\n" * found[0].count("\n"), text)
    root, count, parser = Node("", {}, 0), 0, Parser(path)
    stack = [root]

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if count > EXPANDED_ELEMENTS_MAX:
            raise InputError(
                f"{parser.place(f'<{name}>')} is one of more than {EXPANDED_ELEMENTS_MAX} elements; use fewer"
            )
        stack.append(Node(name, attributes, parser.line, file=file))
        stack[-2].children.append(stack[-1])

    def end(name: str) -> None:
        stack.pop()

    def read(words: str) -> None:
        stack[-1].content += words

    parser.parse(text, start, end, read)
    return root.children[0]


def words_of(node: Node | None, default: str = "") -> str:
    """Return the text inside an element."""
    return default if node is None else node.content.strip() or default


def number_in(parent: Node | None, tag: str, default: float) -> float:
    """Return the number inside a child, which may be infinite, as what is beyond all magnitudes is."""
    node = parent.child(tag) if parent else None
    text = words_of(node)
    if node is None or not text:
        return default
    if INFINITE_PATTERN.fullmatch(text) or (NUMBER_PATTERN.fullmatch(text) and abs(float(text)) > MAGNITUDE_MAX):
        return -np.inf if text.startswith("-") else np.inf
    return float(numbers_of(text, 1, node.place)[0])


def is_true(parent: Node, tag: str) -> bool:
    """Return whether the text inside a child is true."""
    node = parent.child(tag)
    return node is not None and as_truth(words_of(node, "false"), node.place)


def is_marked(node: Node, attribute: str) -> bool:
    """Return whether an attribute is true."""
    return as_truth(node.attributes.get(attribute, "false"), f"{node.place}: {attribute}")


def as_truth(text: str, what: str) -> bool:
    """Return whether a text of any case says true; InputError for one that says neither."""
    word = text.strip().lower()
    if word not in ("true", "1", "false", "0"):
        raise InputError(f"{what}: '{text[:40]}' is neither true nor false; correct it")
    return word in ("true", "1")


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
