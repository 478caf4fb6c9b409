"""`fit`: parameters of a mechanism from measured data, with what the data determine about them and what they do not."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import number, short_repr
from ..base.errors import GradientError, InputError, checks_arguments, checks_method_arguments
from ..base.style import Result
from ..base.wording import counted
from .experiment import MisuseError
from .study import Study

RANK_RATIO = 1e-9  # [1] of the largest singular value: below it, data do not see a combination; rounding leaves 1e-13
SHARE_MIN = 1e-6  # [1] of the largest part of a combination: parameters with less have no part in it
REFUSED = (ValueError, ArithmeticError)  # by which `build` or a run says that there is no such mechanism


@checks_method_arguments
@dataclass(frozen=True, eq=False, repr=False)
class Fit(Result):
    """Parameters that fit data best, and what is known of them.

    Attributes
    ----------
    names, x : tuple of str, (k,) array
        Parameters and their values.
    stderr : (k,) array
        Standard errors; infinite for parameters that the data do not determine.
    cov : (k, k) array
        s^2 (J'J)^-1 over the combinations that the data determine, s^2 the sum of the weighted squares over n - rank.
    rank : int
        Number of combinations of parameters that the data determine.
    singular_values : (k,) array
        Of J in units of sigma and of the sizes of the parameters.
    combinations : tuple of dict
        Parameter -> percent: change all of them together, and the data stay the same, to first order.
    cost : float
        Half of the sum of the weighted squares.
    nfev, njev : int
        Number of runs, and of runs with derivatives.
    success, message : bool, str
        How `scipy.optimize.least_squares` ended.

    Examples
    --------
    >>> from mbsd3d import Body, Study, System, fit
    >>> def stone(start, speed):
    ...     motion = dict(position=(start, 0, 0), velocity=(speed, 0, 0), omega=(0, 0, 0))
    ...     return System([Body("stone", 1.0, (0.1, 0.1, 0.1), **motion)])
    >>> x0 = {"start": 0.0, "speed": 1.0}
    >>> study = Study(stone, x0, lambda run: {"x": run.position("stone")[:, 0]}, {"t_end": 3.0})
    >>> found = fit(study, {"t": [1.0, 2.0, 3.0], "x": [0.9, 1.1, 1.6]})
    >>> found.x.round(6), found.stderr.round(6), found.rank  # of a straight line
    (array([0.5 , 0.35]), array([0.187083, 0.086603]), 2)
    """

    names: tuple[str, ...]
    x: np.ndarray
    stderr: np.ndarray
    cov: np.ndarray
    rank: int
    singular_values: np.ndarray
    combinations: tuple[dict[str, float], ...]
    cost: float
    residuals: np.ndarray  # (n,) weighted
    nfev: int
    njev: int
    success: bool
    message: str

    @property
    def parameters(self) -> dict[str, float]:
        """Return the parameters by name."""
        return dict(zip(self.names, self.x.tolist(), strict=True))

    def confidence_interval(self, level: float = 0.95) -> dict[str, tuple[float, float]]:
        """Return the interval of each parameter that holds its true value with a probability, by Student's t."""
        from scipy.stats import t

        if not 0.0 < number(level, "confidence_interval: level") < 1.0:
            raise InputError(f"confidence_interval: level {level:g}; give a probability between 0 and 1")
        freedom = self.residuals.size - self.rank
        width = t.ppf(0.5 + 0.5 * level, freedom) * self.stderr if freedom > 0 else np.full(self.x.size, np.inf)
        limits = zip((self.x - width).tolist(), (self.x + width).tolist(), strict=True)
        return dict(zip(self.names, limits, strict=True))

    def __str__(self) -> str:
        width = max(map(len, self.names))
        rows = [f"{n:<{width}}{x:14.6g} +- {e:.2g}" for n, x, e in zip(self.names, self.x, self.stderr, strict=True)]
        unseen = [
            "the data cannot tell apart: " + ", ".join(f"{name} {percent:+.3g} %" for name, percent in one.items())
            for one in self.combinations
        ]
        return "\n".join([*rows, *unseen, f"{self.nfev} runs, {self.njev} with derivatives: {self.message}"])


@checks_arguments
def fit(
    study: Study,
    data: Any,
    *,
    sigma: float | ArrayLike | Mapping[str, float] | None = None,
    bounds: Mapping[str, tuple[float, float]] | None = None,
    x_scale: str | Mapping[str, float] | None = None,
    max_nfev: int | None = None,
) -> Fit:
    """Find the parameters of a study that fit data best, by `scipy.optimize.least_squares` from ``study.x0``.

    No step goes along combinations of parameters that the data cannot tell apart: along these ``x`` keeps the values of
    x0. A step to parameters that ``build`` refuses, such as an inertia that no body has, or with which no run reaches
    its end, is rejected, and a shorter one is tried.

    Parameters
    ----------
    study : Study
        What it measures is compared with the data.
    data : array, DataFrame, mapping of columns, or path of a CSV file
        An array (n,) is compared with ``study.fun``. Columns: ``t`` [s] are the sample times of the run, and each other
        column is compared with the value of its name, an array over the samples.
    sigma : float, array (n,) or mapping of columns
        Standard deviation of the noise: the weight of each residual is its inverse. None = 1. Its common factor does
        not matter: ``cov`` takes the noise from the residuals.
    bounds : mapping
        Parameter -> (least, greatest) value.
    x_scale : "jac", mapping or None
        As in least_squares: by the sizes of the columns of J, or parameter -> typical value; None = sizes at x0.
    max_nfev : int or None
        Largest number of runs.

    Returns
    -------
    Fit

    Raises
    ------
    InputError
        For data that do not fit what is measured, and unknown parameters.
    GradientError
        For derivatives that do not exist: see `Study`.

    Examples
    --------
    >>> import numpy as np
    >>> from mbsd3d import GROUND, Body, Prismatic, SpringDamper, Study, System, fit
    >>> def oscillator(k, c):
    ...     box = Body("box", 2.0, (0.1, 0.1, 0.1), position=(1.1, 0, 0), velocity=(0, 0, 0))
    ...     rail = Prismatic(GROUND, box, at=(0, 0, 0), axis=(1, 0, 0))
    ...     ends = dict(at_a=(0, 0, 0), at_b=(1.1, 0, 0), length=1.0)
    ...     return System([box], [rail], [SpringDamper(GROUND, box, **ends, stiffness=k, damping=c)])
    >>> study = Study(oscillator, {"k": 40.0, "c": 1.0}, lambda run: run.position("box")[:, 0], run={"t_end": 2.0})
    >>> t = np.linspace(0.0, 2.0, 21)
    >>> w, d = np.sqrt(25.0 - 0.75**2), 0.75  # of k = 50 N/m, c = 3 N s/m
    >>> x = 1.0 + 0.1 * np.exp(-d * t) * (np.cos(w * t) + d / w * np.sin(w * t))
    >>> found = fit(study, {"t": t, "value": x})
    >>> found.x.round(3), found.rank, found.combinations
    (array([50.,  3.]), 2, ())
    """
    from scipy.optimize import least_squares

    if not isinstance(study, Study):
        raise InputError(f"fit: study {short_repr(study)}; give a Study")
    measured = columns_of(data)
    compared, wanted, names = comparable(study, measured)
    weights = 1.0 / deviations(sigma, wanted, names)
    x0 = np.array(list(study.x0.values()))
    if compared.order.size != wanted.size:
        raise InputError(
            f"fit: the data have {wanted.size} numbers, measure returned {compared.order.size}; give data of the same "
            "quantities at the same samples"
        )
    low, high = limits_of(study, bounds, x0)
    count = wanted.size + x0.size  # residuals, then what holds the rest still

    def residuals(x: np.ndarray) -> np.ndarray:
        try:
            found = compared(x)
        except (MisuseError, GradientError):
            raise
        except REFUSED:
            return np.full(count, np.inf)  # makes the step shorter
        if found.shape != wanted.shape:
            return np.full(count, np.inf)  # the run has ended early
        return np.append((found - wanted) * weights, np.zeros(x0.size))

    def jacobian(x: np.ndarray) -> np.ndarray:
        jac = np.atleast_2d(compared.study.jac(x))[compared.order] * weights[:, None]
        return np.vstack([jac, held_rows(jac, study.sizes(x))])

    scale = scale_of(study, x_scale, x0)
    found = least_squares(residuals, x0, jacobian, (low, high), x_scale=scale, max_nfev=max_nfev)
    found.fun, found.jac = found.fun[: wanted.size], found.jac[: wanted.size]
    return result(study, found)


def held_rows(jac: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Return rows (k, k) by which no step goes along combinations of parameters that a Jacobian (n, k) leaves open.

    What they are rows of is 0 wherever x is: they change neither the sum of squares nor its gradient.
    """
    s, V, rank = singular_part(jac, size)
    return s.max(initial=0.0) * (V[rank:].T @ V[rank:]) / size


def singular_part(jac: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Return singular values (k,), combinations of parameters (k, k) in units of their size, and the rank."""
    _, s, V = np.linalg.svd(jac * size, full_matrices=True)
    return np.append(s, np.zeros(size.size - s.size)), V, int((s > RANK_RATIO * s.max(initial=0.0)).sum())


class Compared:
    """What a study measures, in the order of the data."""

    def __init__(self, study: Study, order: np.ndarray) -> None:
        self.study, self.order = study, order

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """Return the numbers (n,) at x."""
        found = np.atleast_1d(self.study.fun(x))
        return found if found.size <= self.order.max(initial=-1) else found[self.order]


def result(study: Study, found: Any) -> Fit:
    """Return the fit that follows from an optimum of least_squares."""
    size = study.sizes(found.x)
    s, V, rank = singular_part(found.jac, size)
    seen, unseen = V[:rank] * size, V[rank:]
    freedom = found.fun.size - rank
    variance = 2.0 * found.cost / freedom if freedom > 0 else np.inf
    cov = variance * (seen.T / s[:rank] ** 2) @ seen if rank else np.zeros((size.size, size.size))
    stderr = np.sqrt(np.diag(cov))
    open_ = (np.abs(unseen) > SHARE_MIN).any(axis=0) if rank < size.size else np.zeros(size.size, bool)
    stderr[open_] = np.inf
    return Fit(
        study.names, found.x, stderr, cov, rank, s, tuple(combination(study.names, v) for v in unseen),
        float(found.cost), found.fun, int(found.nfev), int(found.njev), bool(found.success), str(found.message),
    )  # fmt: skip


def combination(names: Sequence[str], vector: np.ndarray) -> dict[str, float]:
    """Return a combination of relative changes, the largest 1 percent."""
    percent = vector / vector[np.argmax(np.abs(vector))]
    return {name: float(x) for name, x in zip(names, percent, strict=True) if abs(x) > SHARE_MIN}


def columns_of(data: Any) -> dict[str, np.ndarray] | np.ndarray:
    """Return data as columns by name, or as one array."""
    if isinstance(data, str | Path):
        import pandas

        try:
            data = pandas.read_csv(data, skipinitialspace=True)
        except (OSError, ValueError) as error:
            raise InputError(f"fit: file '{data}' cannot be read: {error}; give a CSV file with a column t") from error
    if isinstance(data, Mapping) or hasattr(data, "columns"):
        found = {str(name): numbers_of_column(str(name), data[name]) for name in data}
        if "t" not in found or len(found) < 2:
            raise InputError(f"fit: the data have the columns {', '.join(found) or 'none'}; give t and one more")
        if len({x.size for x in found.values()}) > 1:
            raise InputError("fit: the columns have different lengths; give one number of each for every time")
        return found
    return numbers_of_column("data", data)


def numbers_of_column(name: str, values: Any) -> np.ndarray:
    """Return finite numbers (n,)."""
    try:
        found = np.array(values, float)
    except (TypeError, ValueError):
        found = np.zeros((0, 0))
    if found.ndim != 1 or not found.size:
        raise InputError(f"fit: '{name}': {short_repr(values)}; give a column of numbers")
    if not np.isfinite(found).all():
        raise InputError(f"fit: '{name}': row {int(np.argmax(~np.isfinite(found)))} is not a number; leave the row out")
    return found


def comparable(
    study: Study, data: dict[str, np.ndarray] | np.ndarray
) -> tuple[Compared, np.ndarray, list[tuple[str, int]]]:
    """Return what is compared, the numbers (n,) of the data, and (name, count) of their columns."""
    if isinstance(data, np.ndarray):
        return Compared(study, np.arange(study.values().vector.size)), data, [("data", data.size)]
    if not study.runs:
        raise InputError("fit: data over t need a study that runs; give run= to Study, or an array of data")
    t = data.pop("t")
    sampled = study.at_times(t)
    values = sampled.values()
    starts, at = {}, 0
    for name, value in values.items():
        starts[name] = at
        at += len(value) if isinstance(value, list) else 1
    for name in data:
        given = values.get(name)
        if given is None:
            raise InputError(f"fit: nothing measured is named '{name}'; measure returns {', '.join(values)}")
        if not isinstance(given, list) or len(given) != t.size:
            count = len(given) if isinstance(given, list) else "one number"
            raise InputError(
                f"fit: '{name}' has {count} of {counted(t.size, 'sample')}; let measure return one number a sample"
            )
    order = np.concatenate([starts[name] + np.arange(t.size) for name in data])
    return Compared(sampled, order), np.concatenate(list(data.values())), [(name, t.size) for name in data]


def deviations(sigma: Any, wanted: np.ndarray, names: list[tuple[str, int]]) -> np.ndarray:
    """Return the standard deviation (n,) of every number of the data."""
    if sigma is None:
        return np.ones(wanted.size)
    if isinstance(sigma, Mapping):
        known = [name for name, _ in names]
        if set(sigma) != set(known):
            raise InputError(f"fit: sigma is given for {', '.join(map(str, sigma))}; give it for {', '.join(known)}")
        parts = [np.full(count, number(sigma[name], f"fit: sigma of '{name}'", positive=True)) for name, count in names]
        return np.concatenate(parts)
    found = np.array(sigma, float)
    if found.shape not in ((), wanted.shape) or not (np.isfinite(found) & (found > 0.0)).all():
        raise InputError(f"fit: sigma {short_repr(sigma)}; give a number > 0, or {wanted.size} of them")
    return np.broadcast_to(found, wanted.shape).copy()


def limits_of(study: Study, bounds: Any, x0: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and greatest values (k,) of the parameters."""
    low, high = np.full(x0.size, -np.inf), np.full(x0.size, np.inf)
    if bounds is not None and not isinstance(bounds, Mapping):
        raise InputError(f"fit: bounds {short_repr(bounds)}; give a mapping of parameters to (least, greatest)")
    for name, limits in (bounds or {}).items():
        j = index_of(study, name, "bounds")
        try:
            low[j], high[j] = limits
        except (TypeError, ValueError):
            raise InputError(f"fit: bounds of '{name}': {short_repr(limits)}; give (least, greatest)") from None
        if not low[j] < high[j] or not low[j] <= x0[j] <= high[j]:
            raise InputError(
                f"fit: bounds of '{name}': {low[j]:g} ... {high[j]:g} do not hold x0 = {x0[j]:g}; give wider ones, or "
                "another x0"
            )
    return low, high


def scale_of(study: Study, x_scale: Any, x0: np.ndarray) -> str | np.ndarray:
    """Return the scales of the parameters for least_squares."""
    if isinstance(x_scale, str) and x_scale == "jac":
        return "jac"
    found = study.sizes(x0)
    if x_scale is not None and not isinstance(x_scale, Mapping):
        raise InputError(
            f"fit: x_scale {short_repr(x_scale)}; give 'jac', or a mapping of parameters to typical values"
        )
    for name, value in (x_scale or {}).items():
        found[index_of(study, name, "x_scale")] = number(value, f"fit: x_scale of '{name}'", positive=True)
    return found


def index_of(study: Study, name: Any, what: str) -> int:
    """Return the index of a parameter."""
    if name not in study.names:
        raise InputError(f"fit: {what} of '{name}', which the study does not have; it has {', '.join(study.names)}")
    return study.names.index(name)
