"""Mechanisms of hinges, slides and free bodies: which are such, and the table of their links.

`solver.compact_links` computes by it.
"""

import numpy as np

from ..kernels.kinds import (
    BAUMGARTE,
    COINCIDE,
    COMPACT_ALONE,
    COMPACT_FREE,
    COMPACT_HINGE,
    COMPACT_SLIDE,
    DOT,
    IN_PLANE,
    ROWS_OF,
)
from ..kernels.layout import Model, Tree, table, tree_records

# [links] of a tree without loops: with fewer an evaluation is a small part of a run, and a first one compiles longer
LINKS_MIN = 3
UNIT_TOLERANCE = 1e-14  # [1] rounding of two directions that are perpendicular to each other and of length 1
JOINTS = {COMPACT_HINGE: (COINCIDE, DOT, DOT), COMPACT_SLIDE: (IN_PLANE, IN_PLANE, DOT, DOT, DOT)}


def compact_links(model: Model, tables: dict[str, np.ndarray], dtype: type) -> tuple[np.ndarray, np.ndarray]:
    """Return the table of compact links and the primitives that are none of their joints; no lines if a link is none.

    ``tables``: those of the spanning tree over all rows.
    """
    fields, none = tree_records(dtype)["compact"], np.zeros(0, np.int64)
    link, joint = tables["link"], tables["joint"]
    held = np.flatnonzero(link["rows"])
    if dtype is not float or not held.size or joint.size + tables["loop"].size != model.row.size:
        return table(fields, 0), none
    if (link["rows"][held] != 5).any():
        return table(fields, 0), none
    kinds, on = model.primitive["kind"], model.primitive["body"]
    rows = joint["row"].reshape(-1, 5)
    first = np.repeat(np.arange(kinds.size), np.array(ROWS_OF)[kinds])[rows[:, 0]]
    kind = np.where(kinds[first] == COINCIDE, COMPACT_HINGE, COMPACT_SLIDE)
    parent = np.append(link["body"], model.body.size)[link["up"]]  # -1 takes the last one, the ground
    child = np.where(on[first, 1] == link["body"][held], 1, 0)
    fits = (rows == rows[:, :1] + np.arange(5)).all(axis=1)
    fits &= (on[first, child] == link["body"][held]) & (on[first, 1 - child] == parent[held])
    loose = np.ones(kinds.size, bool)
    for number, primitives in JOINTS.items():
        own = np.flatnonzero(kind == number)
        for k, primitive in enumerate(primitives):
            at = np.minimum(first[own] + k, kinds.size - 1)
            fits[own] &= (kinds[at] == primitive) & (model.primitive["signal"][at] < 0)
            fits[own] &= (on[at, :2] == on[first[own], :2]).all(axis=1)
            loose[at] = False
        at = np.minimum(first[own] + len(primitives) - (2 if number == COMPACT_HINGE else 3), kinds.size - 2)
        fits[own] &= (model.primitive["axis"][at, 1] == model.primitive["axis"][at + 1, 1]).all(axis=1)
    if not fits.all() or not are_lines(model, first[kind == COMPACT_SLIDE]):
        return table(fields, 0), none
    found = table(fields, link.size)
    for name in ("body", "up", "reflected", "reflections", "side", "entry", "entries"):
        found[name] = link[name]
    found["parent"], found["kind"] = parent, np.where(link["alone"] == 1, COMPACT_ALONE, COMPACT_FREE)
    found["kind"][held], found["row"][held], found["sign"][held] = kind, rows[:, 0], 2.0 * child - 1.0
    found["leaf"] = 1
    found["leaf"][link["up"][link["up"] >= 0]] = 0
    _, opening = np.unique(link["up"], return_index=True)
    found["opens"][opening] = 1
    set_joints(model, found, held, first)
    return found, np.flatnonzero(loose)


def set_joints(model: Model, found: np.ndarray, held: np.ndarray, first: np.ndarray) -> None:
    """Copy points and axes of the joints, whose first primitives are given, to the links that they hold."""
    axis = model.primitive["axis"]
    found["on"][held] = model.primitive["body"][first, :2]
    found["point"][held] = model.primitive["point"][first, :2]
    turn = first + np.where(found["kind"][held] == COMPACT_HINGE, 1, 2)
    found["axis"][held] = np.stack([axis[turn, 0], axis[turn + 1, 0], axis[turn, 1]], axis=1)
    slides = found["kind"][held] == COMPACT_SLIDE
    on, at = held[slides], first[slides]
    found["slide"][on] = np.stack([axis[at + 4, 0], axis[at + 4, 1], axis[at, 0], axis[at + 1, 0]], axis=1)


def are_lines(model: Model, first: np.ndarray) -> bool:
    """Return whether pairs of rows hold a point on a line: normals of the same points, perpendicular to each other."""
    one, other = model.primitive[first], model.primitive[first + 1]
    x, y = one["axis"][:, 0], other["axis"][:, 0]
    products = np.stack([(x * x).sum(axis=1) - 1.0, (y * y).sum(axis=1) - 1.0, (x * y).sum(axis=1)])
    same = (one["point"][:, :2] == other["point"][:, :2]).all()
    return bool(same and (np.abs(products) < UNIT_TOLERANCE).all())


def is_compact(model: Model, tree: Tree) -> int:
    """Return 1 if state rates and projections of a model may go by the compact links of its tree, else 0.

    They know no teaching switch of rows and no stabilisation of accelerations, and give no rows to laws and measures
    that read reactions.
    """
    if tree.compact.size < LINKS_MIN and not (tree.compact.size and tree.loop.size):
        return 0
    reads = model.frictions > 0 or model.force["rows"].any() or model.measure["rows"].any()
    plain = model.gamma == 1.0 and model.stabilisation != BAUMGARTE and not model.singular
    return int(plain and not reads and tree.state["apart"] == 0)
