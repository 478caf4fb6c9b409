"""Drivers in conflict: two motions for one degree of freedom, or one where the joints leave none."""

from dataclasses import dataclass

import numpy as np

from ..base.errors import AssemblyError
from ..equations.compiled import Compiled
from ..equations.jacobian import scaled_rows
from ..kernels.layout import Data
from ..kernels.rows import rows
from ..mechanism.drivers import AngleDriver, SlideDriver, SpeedDriver
from .rank import redundant_combinations

COORDINATE_DRIVERS = (AngleDriver, SlideDriver, SpeedDriver)
TOLERANCE = 1e-9  # [m of the model, rad] difference of prescribed values that counts as a conflict; rounding is 1e-15
# [1] least share of a driver in a dependency that names it; rounding near a singular pose puts 1e-5 into all others
DRIVER_PARTICIPATION_MIN = 1e-3
# [s] after the start, at which the signals of drivers are compared: from fast jitters to slow drifts
SIGNAL_COMPARISON_TIMES = np.concatenate([[0.0], np.logspace(-3.0, 3.0, 25)])


@dataclass(frozen=True)
class Contradiction:
    """Drivers whose rows depend on each other while their prescribed values do not."""

    drivers: tuple[str, ...]
    time: float
    gap: float  # in the unit of their rows, or that per second
    rates: bool  # whether they prescribe other rates, or other positions

    @property
    def who(self) -> str:
        """Return the drivers with their types."""
        return " and ".join(self.drivers)

    @property
    def what(self) -> str:
        """Return what is wrong."""
        thing = f"{'rates' if self.rates else 'positions'} that differ by {self.gap:.6g}"
        if len(self.drivers) == 1:
            return (
                f"prescribes a {'rate' if self.rates else 'position'} that the joints do not allow, off {self.gap:.6g}"
            )
        return f"prescribe {thing} for one motion"

    @property
    def advice(self) -> str:
        """Return the remedy."""
        if len(self.drivers) == 1:
            return "remove it, or a joint"
        return "remove one, or give them one motion"

    @property
    def text(self) -> str:
        """Return the conflict as one sentence."""
        return f"{self.who} {self.what} at t = {self.time:g} s; {self.advice}"

    def error(self) -> AssemblyError:
        """Return the error of a start or a run."""
        return AssemblyError(
            f"contradictory drivers: they {self.what}" if len(self.drivers) > 1 else f"a driver {self.what}",
            time=self.time, part=self.who, advice=self.advice,
        )  # fmt: skip


def find_contradiction(
    compiled: Compiled, data: Data, t: float, last: float = np.inf, N: np.ndarray | None = None,
    slack: float = TOLERANCE,
) -> Contradiction | None:  # fmt: skip
    """Return the first conflict among the drivers at the pose in ``data`` and time t, until ``last`` [s].

    With N' J = 0, J v = b has a solution if N' b = 0. ``N`` is that of all rows (scaled), if it is known, with
    the ``slack`` of rows that only parts with play leave dependent.
    """
    found = rivals(compiled, data, t, last)
    row, b = compiled.model.row, data.row["b"]
    if found is not None or not b.any():
        return found
    if N is None:
        N = redundant_combinations(scaled_rows(compiled.model, data))
    return judged(compiled, np.arange(row.size), N, row["scale"] * b, t, True, slack)


def rivals(compiled: Compiled, data: Data, t: float, last: float) -> Contradiction | None:
    """Return the first conflict among drivers of one hinge.

    Such rows depend on each other however the mechanism moves, so positions are compared now and rates until ``last``.
    """
    row = compiled.model.row
    pairs: dict[frozenset[int], list[int]] = {}
    for joint, k in compiled.drives:
        if isinstance(joint, COORDINATE_DRIVERS):
            pairs.setdefault(frozenset(map(id, joint.bodies())), []).append(k)
    for group in (np.array(rows_of_pair) for rows_of_pair in pairs.values() if len(rows_of_pair) > 1):
        N = redundant_combinations(scaled_rows(compiled.model, data).take(group))
        if not N.size:
            continue
        found = judged(compiled, group, N, (row["scale"] * data.row["c"])[group], t, False)
        for later in times(compiled, t, last):
            rows(compiled.model, data, later)
            found = found or judged(compiled, group, N, (row["scale"] * data.row["b"])[group], later, True)
        rows(compiled.model, data, t)
        if found is not None:
            return found
    return None


def judged(
    compiled: Compiled, where: np.ndarray, N: np.ndarray, values: np.ndarray, t: float, rates: bool,
    slack: float = TOLERANCE,
) -> Contradiction | None:  # fmt: skip
    """Return the conflict in the prescribed values of the rows ``where``: their part N N' values (N orthonormal)."""
    share, mix = np.linalg.svd(N[compiled.model.row["drive"][where] >= 0], full_matrices=False)[1:]
    N = N @ mix[share > DRIVER_PARTICIPATION_MIN].T
    gap = np.abs(N @ (N.T @ values))
    if gap.max() <= slack * max(1.0, np.abs(values).max()):
        return None
    own = [k for k in range(where.size) if gap[k] > 1e-6 * gap.max() and compiled.model.row["drive"][where[k]] >= 0]
    joints = [compiled.holders[compiled.row_joint[where[k]]] for k in own]
    names = tuple(dict.fromkeys(f"{type(joint).__name__} '{compiled.system.name(joint)}'" for joint in joints))
    return Contradiction(names, float(t), float((gap[own] / compiled.model.row["scale"][where[own]]).sum()), rates)


def times(compiled: Compiled, t: float, last: float) -> list[float]:
    """Return times at which drivers are compared: the start, and later ones at which all signals are defined."""
    signals = [row.signal for joint, _ in compiled.drives for row in joint.primitives if row.signal is not None]
    last = min([last, *(signal.interval[1] for signal in signals)])
    return [x for x in t + SIGNAL_COMPARISON_TIMES if x <= last]
