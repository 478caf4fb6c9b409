"""Order in which `solver` eliminates bodies and rows: a spanning tree, and the loop rows that each link feels.

Joints with the most rows come into the tree first, so that few rows are left to close loops; of equal ones those near
the ground, so that few bodies feel a loop. Joints of bodies far lighter than others come before all: a light body at
the end of a branch would yield to loop rows by its own small inertia, and S would be graded by it.
"""

import heapq
from functools import lru_cache
from typing import Any

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from ..kernels.kinds import COINCIDE, ROWS_OF
from ..kernels.layout import TREE_STATE, Data, Model, Tree, single, table, tree_records
from ..solver.joint_basis import choose_blocks, choose_joint_rows
from ..solver.loop_rows import PROXIMAL_FACTOR
from ..solver.row_rank import PIVOT_UNKNOWN
from .compact_links import compact_links, is_compact
from .compiled import Compiled

# [1] of the heaviest inertia: bodies below it, and below each further power of it, are lighter by a class
INERTIA_CLASS_RATIO = 1e-3
LIGHT_SHARE_MAX = INERTIA_CLASS_RATIO * (1.0 + 1e-6)  # [1] above it no body is light, whatever logarithms round to
INERTIA_CLASSES = 8  # [classes]; lighter bodies belong to the last one
# [mu] pivot of a loop row that surely repeats no others: a thousandth of the compliance of the heaviest body in its
# loop. Rounding leaves 1e-6 of mu; the rank decision asks for 1e-10 of a singular value, the root of a pivot
INDEPENDENT_PIVOT_MIN = 1e5
REPEATED_PIVOT_MAX = 1e-4  # [mu] pivot of one that surely does: more than rounding leaves


class Groups:
    """Numbers 0 ... count - 1 in groups that are merged; `scipy.cluster` has the same, and takes 0.1 s to load."""

    def __init__(self, count: int) -> None:
        self.parent = list(range(count))

    def first(self, i: int) -> int:
        """Return the number that stands for the group of i."""
        while self.parent[i] != i:
            self.parent[i] = i = self.parent[self.parent[i]]
        return i

    def merge(self, i: int, j: int) -> bool:
        """Merge the groups of i and j; return whether they were two."""
        i, j = self.first(i), self.first(j)
        self.parent[j] = i
        return i != j

    def members(self) -> list[list[int]]:
        """Return the members of each group, in the order of their least ones."""
        found: dict[int, list[int]] = {}
        for i in range(len(self.parent)):
            found.setdefault(self.first(i), []).append(i)
        return [*found.values()]


def build_spanning_tree(model: Model, data: Data, rows: np.ndarray | None = None, dtype: type = float) -> Tree:
    """Build index tables and work space for the rows in use (all if None) at the state in ``data``.

    Rows of one link that depend on each other at this state become loop rows; ``state.worn`` asks for a new tree.
    """
    used = np.arange(model.row.size) if rows is None else np.asarray(rows, np.int64)
    on = model.row["body"]
    if rows is not None:
        on = np.full_like(on, -1)
        on[used] = model.row["body"][used]
    inertias = inertias_about_points(model)
    bodies, light = on.tobytes(), lightness(inertias).tobytes()
    *_, first, joint = spanning_tree(bodies, light)
    chosen = np.zeros(joint.size, np.int64)
    if joint.size:
        choose_joint_rows(model, data, joint, first, np.zeros((6, 6)), chosen)
    made = bodies, light, chosen.tobytes()
    planned = planned_tables(*made, model.primitive["kind"].tobytes(), model.row["metres"].tobytes(), dtype).items()
    tables = {name: np.frombuffer(bytearray(lines), kind) for name, (lines, kind) in planned}
    loop, state, plan = tables["loop"], single(TREE_STATE), loop_plan(*made)
    state["mu"] = PROXIMAL_FACTOR / (inertias.max(initial=0.0) or 1.0)
    state["soft"] = PIVOT_UNKNOWN
    if loop.size:
        heaviest = np.array(heaviest_in_loops(plan, inertias))
        loop["mu"] = PROXIMAL_FACTOR / heaviest / model.row["scale"][loop["row"]] ** 2
    state["apart"] = reflected_on_links(model, tables["link"])
    if model.singular:
        ready = model.body["inv_mass"][tables["link"]["body"]] > 0.0
        tables["link"]["alone"] = np.where(ready, tables["link"]["alone"], 0)
    compact, loose = compact_links(model, tables, dtype)
    tree = Tree(
        link=tables["link"], joint=tables["joint"], loop=loop, entry=tables["entry"],
        skyline=np.zeros((2, plan["size"]), dtype), vector=np.zeros((5, loop.size), dtype),
        shares=np.zeros(48, np.int64), state=state, compact=compact, loose=loose, used=used,
        skipped=used[:0] if rows is None else np.delete(np.arange(model.row.size), used),
    )  # fmt: skip
    choose_blocks(data, tree)
    state["compact"] = is_compact(model, tree)
    return tree


def surely_regular(tree: Tree) -> bool:
    """Return whether the factor at hand leaves no doubt that no row of a tree over all rows repeats others."""
    return repeated_rows(tree) == 0


def repeated_rows(tree: Tree) -> int | None:
    """Return how many rows of a tree over all rows repeat others; None where the factor at hand leaves a doubt."""
    if tree.skipped.size or tree.state["dense"] or tree.state["worn"]:
        return None
    pivots = tree.loop["pivot"]
    if not pivots.size:
        return 0
    independent = int((pivots > INDEPENDENT_PIVOT_MIN).sum())
    repeated = 0 if independent == pivots.size else int((pivots < REPEATED_PIVOT_MAX).sum())
    return repeated if independent + repeated == pivots.size else None


def tree_at_start(compiled: Compiled, data: Data, q: np.ndarray, t: float) -> Tree:
    """Return a new tree over all rows at a start loaded in ``data``; one built there before is copied.

    A start is asked for its velocities and then run from. ``q`` (7 n,): its poses, ``t`` [s]. Modes choose the rows.
    """
    derived, own = compiled.system.derived, data.coordinate["value"][: compiled.own_coordinates]
    start = (q.tobytes(), t, own.tobytes(), tuple(compiled.modes.items()))
    known = derived.get("tree")
    if known is None or known[0] != start:
        known = derived["tree"] = (start, build_spanning_tree(compiled.model, data))
    tree = Tree(*[copied(x) for x in known[1]])
    tree.state["compact"] = is_compact(compiled.model, tree)
    return tree


def copied(x: Any) -> Any:
    """Return a copy of a table, by its bytes where it is large: numpy copies records field by field."""
    return np.frombuffer(bytearray(x.tobytes()), x.dtype) if isinstance(x, np.ndarray) and x.dtype.names else x.copy()


def reflected_on_links(model: Model, link: np.ndarray) -> int:
    """Give each reflected inertia to the link whose joint it is in; return 1 if one is in no link.

    A link takes those that follow each other, if it leaves one direction free, or is a ball and they are of turns.
    """
    if not model.reflected.size:
        return 0
    parent = np.append(link["body"], model.body.size)[link["up"]]  # -1 takes the last one, the ground
    ball, taken = (link["rows"] == 3) & (link["point"] == 1), 0
    for i, own in enumerate(model.reflected):
        for side in range(2):
            here = (link["body"] == own["body"][side]) & (parent == own["body"][1 - side])
            here &= (link["rows"] >= 5) | (ball & (own["coordinate"] < 0))
            new = here & (link["reflections"] == 0)
            link["side"][new], link["reflected"][new] = side, i
            here &= (link["side"] == side) & (link["reflected"] + link["reflections"] == i)
            link["reflections"][here] += 1
            taken += int(here.any())
    return int(taken < model.reflected.size)


@lru_cache(maxsize=32)
def planned_tables(
    bodies: bytes, light: bytes, chosen: bytes, kinds: bytes, metres: bytes, dtype: type
) -> dict[str, tuple[bytes, np.dtype]]:
    """Return the tables of a tree as its plan fills them, as bytes, since numpy copies records field by field.

    ``kinds``: of the primitives; ``metres``: which rows are measured in them.
    """
    plan, fields, tables = loop_plan(bodies, light, chosen), tree_records(dtype), {}
    for name in ("link", "joint", "loop", "entry"):
        tables[name] = table(fields[name], plan[name].size)
        for key, value in plan.items():
            if key.startswith(name + "."):
                tables[name][key.partition(".")[2]] = value
    tables["joint"] = turns_last(
        tables["link"], tables["joint"], np.frombuffer(kinds, np.int64), np.frombuffer(metres, np.int64) == 0
    )
    return {name: (lines.tobytes(), lines.dtype) for name, lines in tables.items()}


def turns_last(link: np.ndarray, joint: np.ndarray, kinds: np.ndarray, turns: np.ndarray) -> np.ndarray:
    """Order the rows of each link, those last that only turn its body; set how many others there are, at most three."""
    owner, turns = np.repeat(np.arange(link.size), link["rows"]), turns[joint["row"]]
    order = np.lexsort((turns, owner))
    count = np.bincount(owner, turns, link.size).astype(np.int64)
    part = np.repeat(np.arange(kinds.size), np.array(ROWS_OF)[kinds])[joint["row"]][order]
    lines = link["rows"] - count
    link["lines"] = np.where((lines <= 3) & (count <= 3), lines, -1)
    three = np.flatnonzero(link["lines"] == 3)
    first, last = part[link["joint"][three]], part[link["joint"][three] + 2]
    link["point"][three] = (first == last) & (kinds[first] == COINCIDE)
    return joint[order]


def inertias_about_points(model: Model) -> np.ndarray:
    """Return (n,) m L^2 and inertia of each body [kg m^2]: J M^-1 J' of scaled rows is their inverse."""
    body = model.body
    arms = (body["com"] ** 2).sum(axis=1)
    turning = np.abs(body["inertia"]).max(axis=1, initial=0.0) + body["mass"] * arms
    return np.maximum(body["mass"] * model.length**2, turning)


def lightness(inertias: np.ndarray) -> np.ndarray:
    """Return the class (n,) of each body: 0 for ordinary ones, 1 below `INERTIA_CLASS_RATIO` of the heaviest, ..."""
    share = inertias / (inertias.max(initial=0.0) or 1.0)
    if share.min(initial=1.0) > LIGHT_SHARE_MAX:
        return np.zeros(share.size, np.int64)
    least = INERTIA_CLASS_RATIO**INERTIA_CLASSES
    return np.trunc(np.log(np.maximum(share, least)) / np.log(INERTIA_CLASS_RATIO) + 1e-9).astype(np.int64)


def heaviest_in_loops(plan: dict[str, Any], inertias: np.ndarray) -> list[float]:
    """Return per loop row the largest inertia [kg m^2] that its loop moves: of links and all they carry."""
    own = inertias.tolist()
    carried = [own[body] for body in plan["bodies"]]
    for i, up in enumerate(plan["ups"]):
        if up >= 0 and carried[i] > carried[up]:
            carried[up] = carried[i]
    heaviest, most = [], max(own, default=0.0) or 1.0
    for links in plan["moved"]:
        largest = max([carried[i] for i in links], default=0.0)
        heaviest.append(largest if largest > 0.0 else most)
    return heaviest


def pairs_of(on: np.ndarray, n: int) -> np.ndarray:
    """Return (m, 2) the two bodies of rows on one or two moving bodies, the ground (n) last; -1 for other rows."""
    moving = np.where((on >= 0) & (on < n), on, -1)
    high = moving.max(axis=1, initial=-1)
    low = np.where(moving >= 0, moving, n).min(axis=1, initial=n)
    others = (moving >= 0) & (moving != high[:, None]) & (moving != low[:, None])
    two = np.where(low == high, n, high)
    pair = np.stack([low, two], axis=1)
    pair[(high < 0) | others.any(axis=1)] = -1
    # two moving bodies and the ground besides: not the row of one joint
    ground = ((on == n).any(axis=1)) & (low != high)
    pair[ground] = -1
    return pair


@lru_cache(maxsize=32)
def spanning_tree(rows: bytes, light: bytes) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return (bodies, children first; their parents, n = the ground; first candidate row of each; the candidates)."""
    on, lightness = np.frombuffer(rows, np.int64).reshape(-1, 4), np.frombuffer(light, np.int64).tolist()
    n = len(lightness)
    lightness.append(0)  # the ground
    pair = pairs_of(on, n)
    known = np.flatnonzero(pair[:, 0] >= 0)
    edges: dict[tuple[int, int], list[int]] = {}
    for k, (a, b) in zip(known.tolist(), pair[known].tolist(), strict=True):
        edges.setdefault((a, b), []).append(k)
    near: list[list[tuple[int, tuple[int, int]]]] = [[] for _ in range(n + 1)]
    for (a, b), held in edges.items():
        last = (-max(lightness[a], lightness[b]), -min(6, len(held)))
        near[a].append((b, last))
        near[b].append((a, last))
    parent, order = np.full(n, -1), []
    for root in [n, *sorted(range(n), key=lambda i: -len(near[i]))]:
        if root < n and parent[root] >= 0:
            continue
        queue = [(last, 1, other, root) for other, last in near[root]]
        if root < n:
            parent[root] = n
            order.append(root)
        heapq.heapify(queue)
        while queue:
            _, depth, body, before = heapq.heappop(queue)
            if body == n or parent[body] >= 0:
                continue
            parent[body] = before
            order.append(body)
            for other, last in near[body]:
                if other < n and parent[other] < 0:
                    heapq.heappush(queue, (last, depth + 1, other, body))
    bodies = np.array(order[::-1], np.int64)
    groups = [edges.get((min(b, parent[b]), max(b, parent[b])), []) for b in bodies]
    first = np.cumsum([0, *map(len, groups)]).astype(np.int64)
    found = np.array([k for group in groups for k in group], np.int64)
    joint = table(tree_records(float)["joint"], found.size)
    joint["row"] = found
    joint["slot"], joint["twin"] = slots_on(on[found], np.repeat(bodies, np.diff(first)))
    return bodies, parent[bodies], first, joint


def slots_on(on: np.ndarray, body: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return (slot, second slot) of each row that is on its body; -1 for none."""
    hit = on == body[:, None]
    count = hit.sum(axis=1)
    slot = np.where(count > 0, hit.argmax(axis=1), -1)
    twin = np.where(count == 2, 3 - hit[:, ::-1].argmax(axis=1), -1)
    return slot, twin


@lru_cache(maxsize=32)
def loop_plan(rows: bytes, light: bytes, chosen: bytes) -> dict[str, Any]:
    """Return the columns of the tables of `Tree`, and their lengths, when the links take the chosen candidates.

    With "bodies", "ups" (their parents), "moved": the links that each loop moves, and "size": the numbers of S.
    """
    on = np.frombuffer(rows, np.int64).reshape(-1, 4)
    bodies, parent, first, joint = spanning_tree(rows, light)
    n = bodies.size
    take = np.frombuffer(chosen, np.int64) == 1
    counts = np.add.reduceat(np.append(take, 0), first[:-1]) if n else np.zeros(0, np.int64)
    counts = np.where(np.diff(first) > 0, counts, 0)
    place = np.full(n + 1, -1)
    place[bodies] = np.arange(n)
    up = place[parent]
    in_use = np.flatnonzero((on >= 0).any(axis=1))
    loops = np.setdiff1d(in_use, joint["row"][take])
    felt = paths(on, loops, place, up, n)
    line, group = narrow_order(on[loops], felt, n)
    loops, felt = loops[line], [felt[k] for k in line]
    entries: list[list[int]] = [[] for _ in range(n)]  # places of the loop rows that each link feels, ascending
    for k, links in enumerate(felt):
        for i in links:
            entries[i].append(k)
    lengths = np.array([len(places) for places in entries], np.int64)
    starts = np.cumsum([0, *lengths])
    at = {(i, k): int(starts[i]) + j for i, places in enumerate(entries) for j, k in enumerate(places)}
    owner = np.repeat(np.arange(n), lengths)
    entry_place = np.array([k for places in entries for k in places], np.int64)
    end, first_column, last_line, start_of_line = skyline(group, entries)
    slot, twin = slots_on(on[loops[entry_place]], bodies[owner])
    return {
        "link": np.empty(n), "link.body": bodies, "link.up": up, "link.rows": counts,
        "link.joint": np.cumsum(counts) - counts, "link.entry": starts[:-1], "link.entries": lengths,
        "link.alone": (counts == 0) & (lengths == 0) & (up < 0) & ~np.isin(np.arange(n), up),
        "joint": joint[take], **{f"joint.{key}": joint[key][take] for key in ("row", "slot", "twin")},
        "loop": loops, "loop.row": loops, "loop.end": end, "loop.first": first_column, "loop.last": last_line,
        "loop.line": start_of_line,
        "size": int((np.arange(loops.size) - first_column + 1).sum()),
        "entry": entry_place, "entry.place": entry_place, "entry.line": start_of_line[entry_place],
        "entry.next": np.array([at.get((i, k), -1) for i, k in np.stack([up[owner], entry_place], 1).tolist()], int),
        "entry.slot": slot, "entry.twin": twin, "bodies": bodies.tolist(), "ups": up.tolist(),
        "moved": [[i for i, own in links.items() if own] for links in felt],
    }  # fmt: skip


def skyline(group: np.ndarray, entries: list[list[int]]) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return (end of its group, first column, last line with its column, start of its line) of each loop row in S.

    Rows that one link feels meet in S, and so do all rows of their groups.
    """
    begin, end = np.searchsorted(group, group), np.searchsorted(group, group, "right")
    first = begin.copy()
    for places in entries:
        if places:
            first[places] = np.minimum(first[places], begin[places[0]])
    first = np.array([first[b:e].min() for b, e in zip(begin, end, strict=True)], np.int64)
    width = np.arange(group.size) - first + 1
    last = np.zeros(group.size, np.int64)
    np.maximum.at(last, first, np.arange(group.size))
    return end, first, np.maximum.accumulate(last), np.cumsum(width) - width - first


def paths(on: np.ndarray, loops: np.ndarray, place: np.ndarray, up: np.ndarray, n: int) -> list[dict[int, bool]]:
    """Return the links that each loop row is felt by, down to the ground, and True where bodies of it are missing.

    Those that carry all its bodies cannot close its gap.
    """
    found = []
    for k in loops.tolist():
        count: dict[int, int] = {}
        ends = [b for b in on[k].tolist() if b >= 0]
        for b in ends:
            i = int(place[b]) if b < n else -1
            while i >= 0:
                count[i] = count.get(i, 0) + 1
                i = int(up[i])
        found.append({i: count[i] < len(ends) for i in sorted(count)})
    return found


def narrow_order(on: np.ndarray, felt: list[dict[int, bool]], n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return (order of the loop rows, the group of each then): rows between the same bodies are a group.

    Reverse Cuthill-McKee: groups that share a link lie side by side.
    """
    _, group = np.unique(np.sort(on, axis=1), axis=0, return_inverse=True)
    group = group.ravel()
    if group.max(initial=0) > 0:
        owner = np.repeat(group, [len(links) for links in felt])
        link = np.array([i for links in felt for i in links], np.int64)
        shared = csr_array((np.ones(owner.size), (owner, link)), shape=(group.max() + 1, n))
        rank = np.empty(group.max() + 1, np.int64)
        rank[reverse_cuthill_mckee(csr_array(shared @ shared.T), symmetric_mode=True)] = np.arange(rank.size)
        group = rank[group]
    order = np.argsort(group, kind="stable")
    return order, group[order]
