"""Fatigue: cycles of a history by rainflow counting, lives from an S-N curve, damage by Miner's rule.

Three neighbouring turning points p, q, r with |r - q| >= |q - p| close a cycle q - p, which counts one and is taken
out, or one half where p is the first point that is left; what remains at the end counts one half each (ASTM E1049-85,
5.4.4). A damage is ``sum count / N(amplitude)``, a mean stress s_m counts by Goodman: ``amplitude / (1 - max(s_m, 0) /
strength)``.
"""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import floats, number, short_repr
from ..base.errors import InputError, checks_arguments
from ..base.fields import Checked, Number, NumberOrNone, kept, part_class


@dataclass(frozen=True, eq=False, repr=False)
class Cycles:
    """Cycles of a history in the order in which they close; ``amplitude`` is half of ``range``."""

    range: np.ndarray  # (cycles,) in the unit of the history
    mean: np.ndarray  # (cycles,)
    count: np.ndarray  # (cycles,) 1 or 0.5

    @property
    def amplitude(self) -> np.ndarray:
        """Return half of the ranges (cycles,)."""
        return 0.5 * self.range

    def at_least(self, least: float) -> "Cycles":
        """Return the cycles of at least this range: smaller ones are rounding, or do no harm."""
        chosen = self.range >= number(least, "cycles: least", minimum=0.0)
        return Cycles(self.range[chosen], self.mean[chosen], self.count[chosen])

    def by_range(self) -> dict[float, float]:
        """Return range -> number of cycles, from the smallest range on."""
        ranges, place = np.unique(self.range, return_inverse=True)
        return {float(x): float(self.count[place == k].sum()) for k, x in enumerate(ranges)}

    def __repr__(self) -> str:
        if not self.range.size:
            return "<cycles: none>"
        return f"<cycles: {self.count.sum():g}, of ranges up to {self.range.max():.6g}>"


def turning_points(history: np.ndarray) -> np.ndarray:
    """Return the values at which a history turns, with its first and last one; equal neighbours are one."""
    changed = np.append(True, np.diff(history) != 0.0)
    values = history[changed]
    turns = np.diff(np.sign(np.diff(values))) != 0.0
    return values[np.concatenate([[True], turns, [True]])] if values.size > 2 else values


@checks_arguments
def rainflow(history: ArrayLike) -> Cycles:
    """Return the cycles of a history (samples,) by rainflow counting, half cycles kept.

    A peak between two samples can be missed: a sine at 8 samples a period can miss 8 % of its range. `pin_stress`
    samples a run at its turning points.

    >>> from mbsd3d import rainflow
    >>> rainflow([-2, 1, -3, 5, -1, 3, -4, 4, -2]).by_range()
    {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
    """
    values = floats(history, "rainflow: history", "numbers in their order, e.g. stresses [Pa]")
    if values.ndim != 1 or not values.size or not np.isfinite(values).all():
        raise InputError("rainflow: history: give finite numbers (samples,) in their order")
    found: list[tuple[float, float, float]] = []
    open_: list[float] = []
    for value in turning_points(values).tolist():
        open_.append(value)
        while len(open_) > 2 and abs(open_[-1] - open_[-2]) >= abs(open_[-2] - open_[-3]):
            first = len(open_) == 3
            found.append((open_[-3], open_[-2], 0.5 if first else 1.0))
            del open_[-3 : -2 if first else -1]
    found += [(a, b, 0.5) for a, b in zip(open_[:-1], open_[1:], strict=True)]
    one, other, count = np.array(found, float).reshape(-1, 3).T
    return Cycles(np.abs(other - one), 0.5 * (one + other), count.copy())


@part_class(eq=True)
class SNCurve(Checked):
    """Cycles to failure over the amplitude of stress (Woehler): ``N = cycles (amplitude / s)^-slope`` under s.

    The numbers hold for the material, notch, surface and probability that you design for.

    Parameters
    ----------
    amplitude, cycles : float
        A point of the curve, its knee if it has one: s [Pa] > 0 and N > 0.
    slope : float
        k > 0 above the knee.
    slope_below : float or None
        Below the knee: None = the same; 2 k - 1 as Haibach has it.
    limit : bool
        Whether amplitudes below the knee do no damage at all; instead of ``slope_below``.

    Raises
    ------
    ValueError
        For numbers that are not positive, or both ``slope_below`` and ``limit``.

    Examples
    --------
    >>> steel = SNCurve(amplitude=150e6, cycles=2e6, slope=5)
    >>> round(float(steel(300e6)))
    62500
    """

    _: KW_ONLY
    amplitude: Number = kept(positive=True)
    cycles: Number = kept(positive=True)
    slope: Number = kept(positive=True)
    slope_below: NumberOrNone = kept(default=None, positive=True)
    limit: bool = False

    def check(self, what: str) -> None:
        if not isinstance(self.limit, bool | np.bool_):
            raise InputError(f"{what}: limit {short_repr(self.limit)}; give True or False")
        if self.limit and self.slope_below is not None:
            raise InputError(f"{what}: with limit=True the curve ends at its knee; leave slope_below out")

    def __call__(self, amplitude: ArrayLike) -> np.ndarray:
        """Return the cycles to failure at amplitudes [Pa]; infinite at 0, and below the knee of one with a limit."""
        given = floats(amplitude, "SNCurve: amplitudes", "finite numbers [Pa]")
        ratio = np.abs(given) / self.amplitude
        below = self.slope if self.slope_below is None else self.slope_below
        with np.errstate(divide="ignore"):
            N = self.cycles * np.where(ratio < 1.0, ratio**-below, ratio**-self.slope)
        return np.where(ratio < 1.0, np.inf, N) if self.limit else N


Life = SNCurve | Callable[[np.ndarray], ArrayLike]


@checks_arguments
def miner(cycles: Cycles, life: Life, *, strength: float | None = None) -> float:
    """Return the damage of counted cycles, ``sum count / N(amplitude)``: 1 is failure.

    ``life``: an `SNCurve`, or a function of amplitudes [Pa] that returns cycles, as from a table of your own.
    ``strength``: the ultimate strength [Pa], which corrects for mean stresses (Goodman); None = no correction.
    ValueError for a mean stress that reaches the strength, and for lives that are not positive.

    >>> from mbsd3d import SNCurve, miner, rainflow
    >>> cycles = rainflow([0, 300e6, 0, 300e6, 0])
    >>> miner(cycles, SNCurve(amplitude=150e6, cycles=2e6, slope=5)) * 1e6
    1.0
    """
    if not isinstance(cycles, Cycles):
        raise InputError(f"miner: cycles {short_repr(cycles)} are not counted; give those of rainflow(history)")
    if not callable(life):
        raise InputError(f"miner: life {short_repr(life)}: give an SNCurve, or a function of the amplitude [Pa]")
    amplitude = cycles.amplitude
    if strength is not None:
        used = np.maximum(cycles.mean, 0.0) / number(strength, "miner: strength", positive=True)
        if used.size and used.max() >= 1.0:
            raise InputError(
                f"miner: a mean stress of {cycles.mean.max():.4g} Pa reaches the strength {strength:.4g} Pa: it breaks "
                "at once; make the part stronger"
            )
        amplitude = amplitude / (1.0 - used)
    try:
        N = np.asarray(life(amplitude), float)
    except Exception as error:  # whatever the user's function raises
        raise InputError(
            f"miner: life: the function raises {type(error).__name__}: {error}; give one that takes amplitudes "
            "(cycles,) [Pa] and returns cycles to failure"
        ) from error
    if N.shape != amplitude.shape or not (N > 0.0).all():
        raise InputError("miner: life: the function must return cycles > 0 for each amplitude; give one that does")
    return float((cycles.count / N).sum())
