"""Reactions: what the constraints determine of them, and least-norm shares of the rest.

With N the left null space of J (scaled), the multipliers are lam + N a for any a, so the wrench W lam of a joint is
known up to the span of W N. With U an orthonormal basis of the three rows of W N that are the force, the force is
determined along every direction d with U'd = 0: D = 1 - U U' projects onto these, and D F is the part of it that is
known. The same holds for the moment. The share of least norm of what is open is that of lam - N N' lam, which depends
on the unit of length. Of parts as built, N is that of the rows as the run saw them: what fits within the tolerance
repeats other rows.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ..base.checks import check_choice
from ..base.errors import InputError
from ..base.rotations import matrix, perpendiculars
from ..base.style import Sampled
from ..constraints.rank import OPEN_TOLERANCE, Analysis, orthonormal, projector, surely_independent
from ..equations.at_state import rows_at
from ..equations.compiled import Compiled
from ..equations.jacobian import RANK_TOLERANCE, BlockRows, displacement_units, islands
from ..kernels.layout import Data
from ..mechanism.bodies import GROUND, describe_part
from ..mechanism.joints import Joint
from .motion import Motion
from .record import Record

PROBE_SHARES = (0.5, 0.29, 0.83)  # [1] of the samples: where a run is looked at first; no period fits them all
NOT_DETERMINED = (
    "is not determined by the constraints, which have redundant rows there; change the joints that check() names, or "
    "read what is determined with solution.reaction"
)
ZERO_SHARE = 1e-9  # [1] of a vector: a determined part below it is none, as of the moment about a hinge's own axis
REGULAR_MIN = 1e-6  # [1] least singular value over the largest: below it, N is wrong by more than 1e-16 / 1e-6


SAMPLED = ("force", "moment", "point", "force_projector", "moment_projector")  # what a reaction has at every sample


@dataclass(frozen=True, repr=False)
class Reaction(Sampled):
    """Wrench on body b at the joint's point: force [N], moment [N m] and, in world axes, point [m], (samples, 3).

    Components are along world axes, unless `Solution.reaction` was asked for others. ``unique`` is True if the
    constraints determine all of it; ``unique_force`` and ``unique_moment`` (3,) state this for each component. A
    mechanism whose plane is not aligned with the axes mixes the determined and the open directions in every component:
    ``force_projector`` and ``moment_projector`` (samples, 3, 3) are ``D = 1 - U U'`` onto the determined directions, U
    the open ones, and `determined_force` and `determined_moment` are the determined parts.

    At a singular pose less is determined than beside it: the projectors show this, while the masks hold for all other
    poses.

    ``margins``: with ``shares="range"`` the pair (`force_margin`, `moment_margin`), else None.
    """

    force: np.ndarray
    moment: np.ndarray
    point: np.ndarray
    unique: bool
    unique_force: np.ndarray = field(repr=False)
    unique_moment: np.ndarray = field(repr=False)
    force_projector: np.ndarray = field(repr=False)
    moment_projector: np.ndarray = field(repr=False)
    margins: tuple[np.ndarray, np.ndarray] | None = field(default=None, repr=False)

    @property
    def force_margin(self) -> np.ndarray:
        """Return how far assembly tolerances may raise or lower each component of the force (samples, 3) [N]."""
        return self._margins()[0]

    @property
    def moment_margin(self) -> np.ndarray:
        """Return how far assembly tolerances may raise or lower each component of the moment (samples, 3) [N m]."""
        return self._margins()[1]

    def _margins(self) -> tuple[np.ndarray, np.ndarray]:
        """Return both margins; InputError where no range was asked for."""
        if self.margins is None:
            raise InputError('this reaction has no margin; ask for reaction(joint, shares="range", tolerances=...)')
        return self.margins

    @property
    def determined_force(self) -> np.ndarray:
        """Return the part of the force that the constraints determine, D F (samples, 3) [N]."""
        return self.force if self.unique else np.einsum("tij,tj->ti", self.force_projector, self.force)

    @property
    def determined_moment(self) -> np.ndarray:
        """Return the part of the moment that the constraints determine, D M (samples, 3) [N m]."""
        return self.moment if self.unique else np.einsum("tij,tj->ti", self.moment_projector, self.moment)

    def shown(self, kind: str) -> tuple[np.ndarray, str]:
        """Return what to draw of the "force" or the "moment" (samples, 3), and how much the constraints determine.

        "all" of it; "part", which is what is returned then; or "none", and it is a share of least norm.
        """
        values, part = getattr(self, kind), getattr(self, f"determined_{kind}")
        if getattr(self, f"unique_{kind}").all():
            return values, "all"
        known = np.abs(part).max(initial=0.0) > ZERO_SHARE * np.abs(values).max(initial=0.0)
        return (part, "part") if known else (values, "none")


def joined_reactions(pieces: list[Reaction]) -> Reaction:
    """Return the reaction of a run in pieces; it is unique where it is in all of them."""
    whole: dict[str, Any] = {name: np.concatenate([getattr(one, name) for one in pieces]) for name in SAMPLED}
    masks: dict[str, Any] = {
        name: np.all([getattr(one, name) for one in pieces], axis=0) for name in ("unique_force", "unique_moment")
    }
    given = [one.margins for one in pieces if one.margins is not None]
    margins = (np.concatenate([x for x, _ in given]), np.concatenate([x for _, x in given])) if given else None
    return Reaction(**whole, **masks, unique=all(one.unique for one in pieces), margins=margins)


class Determined(NamedTuple):
    """Directions in which the constraints determine the wrench of one or more joints on their body b."""

    force: np.ndarray  # (samples, 3, 3) projector onto those of the force, world axes
    moment: np.ndarray  # (samples, 3, 3) the same of the moment about the joint's point
    regular: np.ndarray  # (samples,) where the rank is that of the run
    tolerance: float  # of a component of an open direction; 0 where none is open

    def along(self, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return (of the force, of the moment) whether the components along unit directions are determined, (3,) each.

        ``directions``: in rows, (3, 3) or (samples, 3, 3), world axes. Only regular samples count.
        """
        if not self.tolerance:
            return np.ones(3, bool), np.ones(3, bool)
        d = np.broadcast_to(directions, self.force.shape)[self.regular]
        left = (d - np.einsum("tij,tkj->tki", D[self.regular], d) for D in (self.force, self.moment))
        return tuple(np.abs(x).max(axis=(0, 2), initial=0.0) < self.tolerance for x in left)

    def reaction(
        self, force: np.ndarray, moment: np.ndarray, point: np.ndarray, some: slice | np.ndarray,
        axes: np.ndarray | None = None,
    ) -> Reaction:  # fmt: skip
        """Return the reaction at ``some`` of the samples, at which its world values are given.

        ``axes`` (samples, 3, 3): directions in rows along which its components are; None = world axes.
        """
        D = (self.force[some], self.moment[some])
        if not self.tolerance and axes is None:
            return Reaction(force, moment, point, True, np.ones(3, bool), np.ones(3, bool), *D)
        masks = self.along(np.eye(3) if axes is None else axes)
        if axes is not None:
            turn = axes[some]
            force, moment = (np.einsum("tij,tj->ti", turn, x) for x in (force, moment))
            D = tuple(turn @ x @ turn.transpose(0, 2, 1) for x in D)
        return Reaction(force, moment, point, bool(np.all(masks)), *masks, *D)


def all_determined(samples: int) -> Determined:
    """Return the record of a wrench that is fully determined at every sample."""
    one = np.broadcast_to(np.eye(3), (samples, 3, 3))
    return Determined(one, one, np.ones(samples, bool), 0.0)


def axes_of(solution: Motion, joint: Joint, axes: str) -> np.ndarray | None:
    """Return the directions (samples, 3, 3), in rows, of the axes asked for; None = those of the world."""
    check_choice(axes, ("world", "a", "b", "joint"), "solution.reaction: axes")
    if axes == "world":
        return None
    body = joint.b if axes == "b" else joint.a
    if axes != "joint":
        own = np.eye(3) if body is GROUND else matrix(body.orientation).T
    else:
        x = joint.angle() or joint.slide()
        along = getattr(joint, "normal", None) if x is None or x.kind not in ("angle", "slide") else x.axis
        if along is None or joint.partners():
            raise InputError(
                f"solution.reaction: {describe_part(joint)} has no axis of its own; give axes='a', 'b' or 'world'"
            )
        own = np.array([*perpendiculars(along), along])
    return np.stack([solution.body_axis(body, direction) for direction in own], axis=1)


class Open(NamedTuple):
    """Shares that the constraints leave open, among rows that no other rows touch."""

    rows: np.ndarray  # (m,) which
    N: np.ndarray  # (m, k) left null space of their scaled J
    slip: float  # largest entry of J'N: rounding, or what parts as built miss each other by
    least: float  # singular value that counts, over the largest


def open_shares(rows: BlockRows, tolerance: float) -> list[Open]:
    """Return what scaled rows leave open, island by island: one null space would grow with the cube of a system."""
    if surely_independent(rows, tolerance):
        return []
    found = []
    for own in islands(rows):
        alone = rows.alone(own)
        if surely_independent(alone, tolerance):
            continue
        analysis = Analysis(alone, tolerance)
        if (N := orthonormal(analysis.redundant())).shape[1]:
            found.append(Open(own, N, float(np.abs(alone.sparse().T @ N).max()), analysis.smallest))
    return found


def tolerance_of(found: list[Open]) -> float:
    """Return the size below which a component of W N counts as zero."""
    return max(OPEN_TOLERANCE, 10.0 * max((island.slip for island in found), default=0.0))


class Group(NamedTuple):
    """Joints of one body b whose net wrench is asked for."""

    rows: np.ndarray  # (m,) of all of them
    on_b: np.ndarray  # (m, 4) slots of their rows that act on b

    def wrench(self, J: np.ndarray, rows: np.ndarray, arm: np.ndarray) -> np.ndarray:
        """Return force [N] and moment [N m] (6, m) on b of unit multipliers of rows, about the end of an arm from O.

        ``J`` (rows, 4, 6) blocks of all rows at a pose.
        """
        T = np.zeros((6, len(J)))
        T[:, self.rows] = -np.where(self.on_b[:, :, None], J[self.rows], 0.0).sum(axis=1).T
        T[3:] -= np.cross(arm, T[:3], axisb=0, axisc=0)
        return T[:, rows]

    def open_wrench(self, compiled: Compiled, J: np.ndarray, found: list[Open]) -> np.ndarray:
        """Return W N (6, k): force in units of the model's length and moment about O, of unit combinations of rows.

        ``J`` (rows, 4, 6) blocks of all rows at the pose at which ``found`` was found.
        """
        model = compiled.model
        W = np.where(self.on_b[:, :, None], J[self.rows], 0.0).sum(axis=1) * model.row["scale"][self.rows, None]
        W *= displacement_units(model.length, 1)
        parts = [np.zeros((6, 0))]
        for island in found:
            theirs = np.minimum(np.searchsorted(island.rows, self.rows), island.rows.size - 1)  # these are ascending
            mine = island.rows[theirs] == self.rows
            if mine.any():
                parts.append(W[mine].T @ island.N[theirs[mine]])
        return np.hstack(parts)


def group_of(compiled: Compiled, parts: list[Joint]) -> Group:
    """Return the rows of joints that act on the body b of the first one."""
    rows = np.concatenate([np.arange(compiled.model.row.size)[compiled.rows[id(part)]] for part in parts])
    return Group(rows, compiled.model.row["body"][rows] == compiled.body_index[id(parts[0].b)])


class Probe(NamedTuple):
    """The rows at one sample that leave something open."""

    open: list[Open]
    J: np.ndarray  # (rows, 4, 6) blocks per slot


class RunRows(NamedTuple):
    """What the rows of a run are taken from."""

    compiled: Compiled
    t: np.ndarray  # (samples,)
    states: np.ndarray
    coordinates: np.ndarray
    record: Record

    @property
    def tolerance(self) -> float:
        """Return the relative tolerance of the rank."""
        return max(RANK_TOLERANCE, self.record.tolerance)

    def probe(self, k: int, data: Data) -> Probe:
        """Return what is open at a sample, with the rows loaded in ``data``."""
        rows = rows_at(self.compiled, data, self.t[k], self.states[k], self.coordinates[k])
        return Probe(open_shares(rows, self.tolerance), data.row["J"])

    def probes(self) -> list[Probe]:
        """Return what is open at a few samples; none where the run left out no row, or all are independent at one.

        Rows that are independent at one pose are so at all but singular ones.
        """
        count, found = self.t.size, []
        if not self.compiled.model.row.size or not count or self.record.rows_left_out == 0:
            return []
        for k in dict.fromkeys(int(share * count) for share in PROBE_SHARES):
            found.append(self.probe(k, self.compiled.data()))
            if not found[-1].open:
                return []
        return found

    def share_out(self, lam: np.ndarray, groups: list[Group], arms: list[np.ndarray]) -> "Shares":
        """Return multipliers of least norm in the model's own units, and what is determined of groups of joints.

        ``lam`` (samples, rows): of the run; ``arms`` (samples, 3): from O of body b to the joint's point, world [m].
        """
        samples, scale, length = self.t.size, self.compiled.model.row["scale"], self.compiled.model.length
        shared, D = lam.copy(), np.empty((len(groups), 2, samples, 3, 3))
        count, least, limit = np.zeros(samples, int), np.ones(samples), np.full(samples, OPEN_TOLERANCE)
        data = self.compiled.data()
        for k in range(samples):
            found, J = self.probe(k, data)
            limit[k] = tolerance_of(found)
            for own, N, _, smallest in found:
                mu = lam[k, own] / scale[own]
                shared[k, own] = (mu - N @ (N.T @ mu)) * scale[own]
                count[k], least[k] = count[k] + N.shape[1], min(least[k], smallest)
            for g, (group, arm) in enumerate(zip(groups, arms, strict=True)):
                W = group.open_wrench(self.compiled, J, found)
                moment = W[3:] - np.cross(arm[k] / length, W[:3], axisb=0, axisc=0)
                D[g, :, k] = projector(W[:3], limit[k]), projector(moment, limit[k])
        regular = regular_samples(count, least)
        largest = float(limit.max(initial=0.0))
        return Shares(shared, [Determined(force, moment, regular, largest) for force, moment in D])


class Shares(NamedTuple):
    """Least-norm shares of a run, and what is determined of each group of joints."""

    lam: np.ndarray  # (samples, rows)
    determined: list[Determined]


def regular_samples(count: np.ndarray, least: np.ndarray) -> np.ndarray:
    """Return where the rank is the highest of the run, and no singular value is about to vanish; never nowhere.

    ``count`` (samples,): of redundant combinations; ``least`` (samples,): singular value over the largest.
    """
    highest = count == count.min(initial=count.max(initial=0))
    return highest & (least >= min(REGULAR_MIN, least[highest].max(initial=0.0)))


def is_unique(compiled: Compiled, probes: list[Probe], group: Group) -> bool:
    """Return True if the wrench of a group about O is determined at all probes."""
    worst = (
        np.abs(group.open_wrench(compiled, J, found)).max(initial=0.0) / tolerance_of(found) for found, J in probes
    )
    return all(x < 1.0 for x in worst)
