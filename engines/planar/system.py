"""Planar mechanism, checked, and the arrays that the kernels read."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import scipy.sparse
from numpy.typing import ArrayLike
from scipy.sparse.csgraph import reverse_cuthill_mckee

from engines.planar import rows as kinds
from engines.planar.bodies import GROUND, Body, Ground, Row, pair
from engines.planar.joints import Joint
from engines.planar.loads import Load
from engines.planar.march import evaluate
from engines.planar.rows import Model, Work
from mbsd3d.errors import InputError

# [1] of the largest singular value of the scaled rows; smaller ones are redundant rows
SINGULAR_VALUE_RATIO_MIN = 1e-10
KINDS = (("bodies", Body), ("joints", Joint), ("loads", Load))


@dataclass(frozen=True, eq=False)
class System:
    """Planar mechanism: x and y in the plane, angles counted from x to y.

    ``gravity`` (2,): [m/s^2]. ValueError for two parts of one name, a part of a body or joint that is not in the
    system; at the first run for redundant rows.
    """

    bodies: Sequence[Body]
    joints: Sequence[Joint] = ()
    loads: Sequence[Load] = ()
    gravity: Any = (0.0, -9.81)

    def __post_init__(self) -> None:
        for key, kind in KINDS:
            parts = tuple(getattr(self, key))
            for part in parts:
                if not isinstance(part, kind):
                    raise InputError(f"System: {part!r} in {key} is not a planar {kind.__name__}")
            object.__setattr__(self, key, parts)
        if not self.bodies:
            raise InputError("System: no bodies; give at least one Body")
        object.__setattr__(self, "gravity", pair(self.gravity, "System: gravity"))
        self._check_names()
        self._check_members()

    def _check_names(self) -> None:
        """Check that names are unique."""
        names = [part.name for key, _ in KINDS for part in getattr(self, key) if part.name is not None]
        for name in names:
            if names.count(name) > 1:
                raise InputError(f"System: two parts are named '{name}'; give every part a unique name")

    def _check_members(self) -> None:
        """Check that joints and loads act on bodies of the system and through joints of it."""
        members = {id(body) for body in self.bodies} | {id(GROUND)}
        parts: list[Joint | Load] = [*self.joints, *self.loads]
        for part in parts:
            rows = [part.load()] if isinstance(part, Load) else part.rows()
            for body in (body for row in rows for body in row.bodies):
                if id(body) not in members:
                    raise InputError(f"{self.name(part)}: body '{body.name}' is not in the system; add it to bodies")
        for joint in self.joints:
            for other in joint.partners():
                if other not in self.joints:
                    raise InputError(
                        f"{self.name(joint)}: its joint '{other.name}' is not in the system; add it to joints"
                    )

    def name(self, part: Any) -> str:
        """Return the name of a part for error messages."""
        return f"{type(part).__name__} '{part.name}'" if part.name else f"{type(part).__name__} without a name"

    def part(self, key: Any, kind: str) -> int:
        """Return the index of a body, joint or load given by itself or by its name."""
        parts = getattr(self, kind)
        for i, part in enumerate(parts):
            if part is key or (isinstance(key, str) and part.name == key):
                return i
        have = ", ".join(f"'{part.name}'" for part in parts) or "none"
        raise InputError(f"{getattr(key, 'name', key)!r} is not one of the {kind}; there are {have}")

    @cached_property
    def lowered(self) -> "Lowered":
        """Return the arrays, made once; raise ValueError for redundant rows."""
        return lower(self)


class Lowered(NamedTuple):
    """Arrays of a system with the joint of every row, and its reference pose."""

    model: Model
    joint_of: np.ndarray  # (m,) index of the joint
    q: np.ndarray  # (n + 1, 3) at the reference pose; the last row is the ground

    def work(self) -> Work:
        """Allocate a new set of work arrays."""
        n, m = len(self.q), self.model.kind.size
        bodies = [np.zeros((n, 3)) for _ in range(6)]
        c, rate, gamma, lam = np.zeros((4, m))
        return Work(
            np.zeros((n, 4)), np.zeros((4 * m, 3)), np.zeros((4 * m, 3)), c, rate, gamma, np.zeros((m, m)), lam, *bodies
        )

    def jacobian(self, work: Work) -> np.ndarray:
        """Return the dense J (m, 3 n) of a work space."""
        n, m = len(self.q) - 1, self.model.kind.size
        J = np.zeros((m, n, 3))
        for k, _, body in self.model.entry:
            J[k // 4, body] += work.J[k]
        return J.reshape(m, 3 * n)


def lower(system: System, centripetal: bool = True) -> Lowered:
    """Return the arrays of a system; ``centripetal`` False drops the term m w^2 s, as some planar solvers do."""
    bodies: list[Body | Ground] = [*system.bodies, GROUND]
    index = {id(body): i for i, body in enumerate(bodies)}
    rows, joint_of = [], []
    for i, joint in enumerate(system.joints):
        for row in joint.rows():
            both = [row, Row(kinds.SECOND, row.bodies, row.values)] if row.kind == kinds.COINCIDE else [row]
            rows += both
            joint_of += [i] * len(both)
    pieces = [np.empty((0, 5))]
    slot, value, motion = table(rows, index, 4, pieces)
    entry, product, place, first = pattern(rows, slot, len(system.bodies))
    loads = [part.load() for part in system.loads]
    load_slot, load_value, load_motion = table(loads, index, 2, pieces)
    load = np.column_stack([integers([row.kind for row in loads]), load_slot])
    poses = np.array([(*body.position, body.angle) for body in bodies])
    even = steady(rows)
    model = Model(
        np.array([body_row(body, id(body) in even) for body in bodies]),
        integers([row.kind for row in rows]), slot, value, np.any(motion, axis=1), motion, entry, product, place, first,
        load, load_value, load_motion, np.concatenate(pieces), np.array(system.gravity),
        np.array([float(centripetal), max(1.0, np.abs(poses[:, :2]).max())]),
    )  # fmt: skip
    lowered = Lowered(model, integers(joint_of), poses)
    refuse_redundant(system, lowered)
    return lowered


def integers(values: ArrayLike) -> np.ndarray:
    """Return an int64 array, empty for no values."""
    return np.array(values, dtype=np.int64)


def steady(rows: list[Row]) -> set[int]:
    """Return id of the bodies whose rate the rows keep constant: the ground and bodies that a slide, weld or driver
    ties to them.
    """
    found, before = {id(GROUND)}, 0
    turns = [row for row in rows if row.kind == kinds.ANGLE and row.motion.steady()]
    while len(found) > before:
        before = len(found)
        for row in turns:
            others = {id(body) for body in row.bodies} - found
            found |= others if len(others) == 1 else set()
    return found


def body_row(body: Body | Ground, even: bool) -> tuple:
    """Return mass, I_G, r_G, 1/sqrt(mass), 1/sqrt(I_G); the ground takes no part in sums.

    A point mass has I_G = 0. Where its rate is constant, alpha = 0 and any I_G gives the same motion and reactions.
    """
    if isinstance(body, Ground):
        return (0.0,) * 6
    if body.inertia == 0.0 and not even:
        raise InputError(
            f"body '{body.name}': inertia 0, but its rate can change; give a number > 0 or hold it by a Slider"
        )
    inertia = body.inertia or body.mass
    return (body.mass, inertia, *body.com, 1 / np.sqrt(body.mass), 1 / np.sqrt(inertia))


def table(
    rows: list[Row], index: dict[int, int], width: int, pieces: list[np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return bodies (m, width), numbers (m, 8), motions (m, 11) of rows or loads, their splines appended to the
    pieces."""
    ground = len(index) - 1
    slot, value = np.full((len(rows), width), ground, dtype=np.int64), np.zeros((len(rows), 8))
    motion = np.zeros((len(rows), 11))
    for i, row in enumerate(rows):
        slot[i, : len(row.bodies)] = [index[id(body)] for body in row.bodies]
        value[i, : len(row.values)] = row.values
        own = row.motion.pieces()
        motion[i] = (*row.motion.numbers(), sum(map(len, pieces)) if len(own) else 0, len(own))
        pieces.append(own)
    return slot, value, motion


def pattern(rows: list[Row], slot: np.ndarray, ground: int) -> tuple[np.ndarray, ...]:
    """Return the entries of J, the products that form S, and the order and profile of S by reverse Cuthill-McKee."""
    m = len(rows)
    touched = [(4 * i + k, i, int(slot[i, k])) for i in range(m) for k in range(len(rows[i].bodies))]
    touched = [entry for entry in touched if entry[2] != ground]
    pairs = [(e, f) for e in touched for f in touched if e[2] == f[2]]
    graph = scipy.sparse.coo_matrix((np.ones(len(pairs)), ([e[1] for e, _ in pairs], [f[1] for _, f in pairs])), (m, m))
    place, first = integers(np.zeros(m)), integers(np.arange(m))
    if m:
        place[reverse_cuthill_mckee(graph.tocsr(), symmetric_mode=True)] = range(m)
    products = []
    for e, f in pairs:
        line, column = place[e[1]], place[f[1]]
        if column <= line:
            products.append((line, column, e[0], f[0]))
            first[line] = min(first[line], column)
    entries = [(k, place[i], body) for k, i, body in touched]
    return integers(entries).reshape(-1, 3), integers(products).reshape(-1, 4), place, first


def refuse_redundant(system: System, lowered: Lowered) -> None:
    """Raise ValueError that names the joints whose rows depend on each other at the reference pose."""
    m = lowered.model.kind.size
    if not m:
        return
    work = lowered.work()
    evaluate(lowered.model, work, 0.0, lowered.q, np.zeros_like(lowered.q))
    J = lowered.jacobian(work)
    J = J / np.linalg.norm(J, axis=1, keepdims=True)
    left, s, _ = np.linalg.svd(J)
    kept = int((s > SINGULAR_VALUE_RATIO_MIN * s[0]).sum())
    if kept == m:
        return
    guilty = np.abs(left[:, kept:]).max(axis=1) > 1e-6
    names = dict.fromkeys(system.name(system.joints[i]) for i in lowered.joint_of[guilty])
    raise InputError(
        f"System: {m - kept} of {m} rows are redundant or singular, within {', '.join(names)}; "
        "remove a joint, or move the reference pose off the dead point"
    )
