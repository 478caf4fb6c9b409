"""Which rows the fast path keeps, and in which order it eliminates them.

Rank is decided here and nowhere else, at accepted states only: by the singular values of the scaled J (columns:
displacements in units of the model's length, rotations in radians), of which the bodies have been eliminated that need
no such decision (see `mbsd3d.constraints.elimination`).
"""

from functools import lru_cache

import numpy as np
import scipy.linalg
from scipy.sparse import csr_array
from scipy.sparse.csgraph import reverse_cuthill_mckee

from ..base.concurrency import one_thread
from ..equations.jacobian import RANK_TOLERANCE, scaled_rows
from ..kernels.layout import Data, Model, Schur, schur_records, table
from .rank import Analysis


def independent_rows(A: np.ndarray, tolerance: float = RANK_TOLERANCE) -> tuple[np.ndarray, float]:
    """(indices of a largest independent set of rows of A, smallest kept singular value relative to the largest).

    The readable truth: column-pivoted QR of A', its singular values as the authority on the rank, cost cubic.
    """
    if not A.size or not A.any():
        return np.zeros(0, np.int64), 1.0
    with one_thread():
        _, pivot = scipy.linalg.qr(A.T, mode="r", pivoting=True)
        singular = scipy.linalg.svdvals(A)
    rank = int((singular > tolerance * singular[0]).sum())
    return np.sort(pivot[:rank]).astype(np.int64), float(singular[rank - 1] / singular[0])


def elimination_order(model: Model, chosen: np.ndarray) -> np.ndarray:
    """The chosen rows in reverse Cuthill-McKee order of the graph 'two rows share a moving body'."""
    return chosen[narrow_order(model.row["body"][chosen].tobytes(), model.body.size)]


@lru_cache(maxsize=8)
def narrow_order(rows: bytes, n: int) -> np.ndarray:
    """Reverse Cuthill-McKee order of rows given by their bodies; cells of a sweep share it."""
    on = np.frombuffer(rows, np.int64).reshape(-1, 4)
    place, slot = np.nonzero((on >= 0) & (on < n))
    incidence = csr_array((np.ones(place.size), (place, on[place, slot])), shape=(len(on), n))
    order = reverse_cuthill_mckee(csr_array(incidence @ incidence.T), symmetric_mode=True)
    order.setflags(write=False)
    return order


def schur_of(model: Model, chosen: np.ndarray, dtype: type = float) -> Schur:
    """Index tables and work space of the Schur complement over the chosen rows."""
    n = model.body.size
    row = elimination_order(model, chosen) if chosen.size else chosen
    on: list[list[int]] = [[] for _ in range(n)]  # places of the rows on each body, ascending
    for i, bodies in enumerate(model.row["body"][row]):
        for b in {int(b) for b in bodies if 0 <= b < n}:
            on[b].append(i)
    records = schur_records(dtype)
    body_first = np.cumsum([0, *(len(places) for places in on)])
    place, block = table(records["place"], row.size), table(records["block"], int(body_first[-1]))
    block["place"] = [i for places in on for i in places]
    block["row"] = row[block["place"]]
    slots = model.row["body"][block["row"]] == np.repeat(np.arange(n), [len(places) for places in on])[:, None]
    block["slot"] = slots.argmax(axis=1)
    block["twin"] = np.where(slots.sum(axis=1) == 2, 3 - slots[:, ::-1].argmax(axis=1), -1)
    place["row"] = row
    place["first"] = np.arange(row.size)
    for places in on:
        np.minimum.at(place["first"], places, places[0] if places else 0)
    lengths = np.arange(row.size) - place["first"] + 1
    place["line"] = np.cumsum(lengths) - lengths - place["first"]
    block["line"] = place["line"][block["place"]]
    return Schur(
        place=place,
        block=block,
        body_first=body_first.astype(np.int64),
        skyline=np.zeros(int(lengths.sum()), dtype),
        rhs=np.zeros(row.size, dtype),
        skipped=np.setdiff1d(np.arange(model.row.size), row).astype(np.int64),
    )


def choose_rows(
    model: Model, data: Data, tolerance: float = RANK_TOLERANCE, before: np.ndarray | None = None
) -> tuple[Schur, float]:
    """(Schur structure over an independent set of rows at the state in ``data``, its smallest singular value).

    The set ``before`` is kept where it is as good as the best one: at a singular position all sets are bad, and one
    chosen there may be bad everywhere.
    """
    rows = scaled_rows(model, data)
    found = Analysis(rows, tolerance)
    chosen = found.independent()
    if before is not None and before.size == chosen.size:
        kept = Analysis(rows.take(before), tolerance)
        if kept.rank == before.size and kept.least > 0.1 * found.least:
            chosen = np.sort(before)
    return schur_of(model, chosen, data.row["c"].dtype.type), found.smallest
