"""A run through events as one result: the samples of its pieces one after the other."""

from dataclasses import dataclass, field, replace
from operator import attrgetter

import numpy as np

from .events import Event
from .record import Record
from .result import RunResult

ADDED = ("steps", "rejected", "evaluations", "svd_calls", "seconds", "loop_seconds", "jump")  # over the pieces
GREATEST = ("speed", "missed", "farthest", "overlap")


@dataclass(frozen=True, eq=False)
class Jump:
    """An event and what it adds to work of drivers [J] and to the impulse from outside [N s, N m s]."""

    event: Event
    work: np.ndarray = field(default_factory=lambda: np.zeros(0))  # of each driven row
    push: np.ndarray = field(default_factory=lambda: np.zeros(3))
    turn: np.ndarray = field(default_factory=lambda: np.zeros(3))  # about the centre of mass


def joined(pieces: list[RunResult], jumps: list[Jump]) -> RunResult:
    """Return pieces as one result; work and impulses go on from piece to piece, with those of the jumps between."""
    first, model = pieces[0], pieces[0].compiled.model
    widest, so_far = max(piece.arrays["lam"].shape[1] for piece in pieces), np.zeros(model.state.size - model.z_work)
    states, multipliers = [], []
    for k, piece in enumerate(pieces):
        state, lam = piece.arrays["state"].copy(), piece.arrays["lam"]
        counted = state[:, 13 * model.body.size + model.z_work :]
        counted += so_far
        if k < len(jumps) and counted.size:
            so_far = counted[-1].copy()
            drives = slice(model.z_drive - model.z_work, model.z_impulse - model.z_work)
            if jumps[k].work.size:
                so_far[drives] += jumps[k].work
            so_far[-6:] += np.concatenate([jumps[k].push, jumps[k].turn])
        states.append(state)
        multipliers.append(np.pad(lam, ((0, 0), (0, widest - lam.shape[1]))))
    names = [name for name in first.arrays if name not in ("state", "lam", "q", "z")]
    arrays = {name: np.concatenate([piece.arrays[name] for piece in pieces]) for name in names}
    arrays["state"], arrays["lam"] = np.concatenate(states), np.concatenate(multipliers)
    events = tuple(jump.event for jump in jumps)
    whole = replace(first, arrays=arrays, record=joined_record(pieces), final=pieces[-1].final, events=events)
    return in_pieces(whole, pieces, [piece.t.size for piece in pieces])


def in_pieces(whole: RunResult, pieces: list[RunResult], counts: list[int]) -> RunResult:
    """Return a result whose pieces read their share of its samples, so many of each."""
    n, arrays, made, begin = len(whole.system.bodies), whole.arrays, [], 0
    arrays["q"] = arrays["state"][:, : 7 * n].reshape(-1, n, 7)
    arrays["z"] = arrays["state"][:, 13 * n :]
    for piece, count in zip(pieces, counts, strict=True):
        some = slice(begin, begin + count)
        own = {name: array[some] for name, array in arrays.items()}
        own["lam"] = np.ascontiguousarray(own["lam"][:, : piece.compiled.model.row.size])
        made.append(replace(piece, arrays=own))
        begin = some.stop
    return replace(whole, pieces=tuple(made))


def joined_record(pieces: list[RunResult]) -> Record:
    """Return the record of a whole run: sums and extremes over its pieces."""
    records = [piece.record for piece in pieces]
    most = {name: max(records, key=attrgetter(name)) for name in ("farthest", "missed", "jump", "overlap")}
    sums = {name: sum(getattr(x, name) for x in records) for name in ADDED}
    miscounts = [x.miscount for x in records if x.miscount is not None]
    return replace(
        records[0], **sums, **{name: max(getattr(x, name) for x in records) for name in GREATEST},
        rank_events=[event for x in records for event in x.rank_events], nearest=min(x.nearest for x in records),
        open_audit=tuple(np.sum([x.open_audit for x in records], axis=0).tolist()),
        miscount=max(miscounts, default=None),
        **{f"{name}_by": getattr(record, f"{name}_by") for name, record in most.items()},
        stopped_by=records[-1].stopped_by, never_armed=records[-1].never_armed,
    )  # fmt: skip
