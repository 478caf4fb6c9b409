"""Rows, rank and degrees of freedom of every reference case: by mbsd3d, by Exudyn, and by the files.

Exudyn's rows are its algebraic equations without those that only set a multiplier of a free direction to zero; its rank
is what is left after the redundant ones. Neither it nor the files share code with us: the files' figures come from a
program of their own.
"""

import time
from collections.abc import Sequence
from typing import NamedTuple

from mbsd3d import System
from validation import cases
from validation.benchmark.problems import four_bar_poses, poses, whole
from validation.cases import mechanisms
from validation.twins import exudyn
from validation.twins.base import NotComparable

WINDOW_COUNTS = (2, 10, 40)  # [1] windows of the N-four-bars counted with the cases
EXUDYN_STEPS = 500  # [1] of Exudyn for the large one: error 8e-2 at the end, with h = 0.02 s


class Count(NamedTuple):
    """Rows, rank, mobility and redundant rows; None where a source does not give a count."""

    rows: int | None
    rank: int | None
    mobility: int | None
    redundant: int | None


class Counts(NamedTuple):
    """Counts of one mechanism by all engines."""

    name: str
    ours: Count
    exudyn: Count | str  # Or why it was not compared
    file: Count | None

    @property
    def agree(self) -> bool:
        """Return whether all counts are the same; False where Exudyn did not count."""
        if isinstance(self.exudyn, str):
            return False
        said = [count for count in (self.exudyn, self.file) if count is not None]
        return all(x in (None, y) for count in said for x, y in zip(count, self.ours, strict=True))


def counted(system: System) -> Count:
    """Return the count of mbsd3d, from `check`."""
    found = system.check()
    return Count(found.rows, found.rank, found.mobility, found.redundant)


def counted_by_exudyn(system: System) -> Count | str:
    """Return the count of Exudyn, by its ``ComputeSystemDegreeOfFreedom``."""
    try:
        found = exudyn.twin(system).degrees_of_freedom()
    except NotComparable as error:
        return f"not compared: {error}"
    rows, redundant = found["nAE"] - found["nPureAE"], found["redundantConstraints"]
    return Count(*map(int, (rows, rows - redundant, found["degreeOfFreedom"], redundant)))


def redundancy(names: Sequence[str] | None = None, windows: Sequence[int] = WINDOW_COUNTS) -> list[Counts]:
    """Return the counts of reference cases (None: of all) and of N-four-bars; raise ValueError if there is no such
    case.
    """
    found = []
    for name in cases.names() if names is None else names:
        case = cases.load(name)
        said = Count(*(case.dof_info.get(key) for key in ("rows", "rank", "dof", "redundant")))
        found.append((name, case.system, said if case.dof_info else None))
    found += [(f"four-bar {n}", mechanisms.four_bars(n), None) for n in windows]
    return [Counts(name, counted(system), counted_by_exudyn(system), said) for name, system, said in found]


class Large(NamedTuple):
    """Timing of the N-four-bar of many windows, from the check to the end of the run."""

    rows: int
    rank: int
    check_seconds: float
    run_seconds: float
    error: float  # At the end, against the closed form: metres over the rod length, and radians


def large(windows: int = 40, t_end: float = 10.0, rtol: float = 1e-4) -> Large:
    """Time `check` and a run through ten singular positions."""
    system = mechanisms.four_bars(windows)
    began = time.perf_counter()
    found = system.check()
    checked = time.perf_counter()
    solution = whole(system, t_end, rtol=rtol)
    done = time.perf_counter()
    error = poses(solution).distance(four_bar_poses(windows, t_end), 1.0)
    return Large(found.rows, found.rank, checked - began, done - checked, error)


def table(found: Sequence[Counts]) -> list[str]:
    """Return the counts as text."""
    said = [f"{'rows/rank/mobility/redundant':28}{'ours':>18}{'Exudyn':>18}{'file':>18}"]
    for row in found:
        words = [shown(count) for count in (row.ours, row.exudyn, row.file)]
        said.append(f"{row.name:28}" + "".join(f"{word:>18}" for word in words) + ("" if row.agree else "  DIFFERS"))
    said.append(f"{sum(row.agree for row in found)} of {len(found)} agree")
    return said


def shown(count: Count | str | None) -> str:
    """Return four numbers as text, or why there are none."""
    if count is None or isinstance(count, str):
        return count or "-"
    return "/".join("-" if x is None else str(x) for x in count)


def step_seconds() -> float:
    """Return the seconds of one of Exudyn's steps, by two, with all rows of 40 four-bars, by full pivoting: its method
    for poses with all rods on one line.
    """
    twin = exudyn.twin(mechanisms.four_bars(40), solver="generalized-alpha", linear="full-pivot")
    return twin.run(2 * 10.0 / EXUDYN_STEPS, 2, 1).seconds / 2


def report() -> list[str]:
    """Return the whole report."""
    one = large()
    said = [
        *table(redundancy()),
        f"four-bar 40: {one.rows} rows of rank {one.rank}; check {one.check_seconds:.2g} s, 10 s of motion "
        f"{one.run_seconds:.2g} s with an error of {one.error:.0e}",
    ]
    try:
        peer = EXUDYN_STEPS * step_seconds()
    except NotComparable as error:
        return [*said, f"  Exudyn: not compared: {error}"]
    ratio = peer / (one.check_seconds + one.run_seconds)
    times = f"{EXUDYN_STEPS} steps take {peer:.0f} s by the time of the first, {ratio:.0f} times ours"
    return [*said, f"  Exudyn, all rows: {times}"]
