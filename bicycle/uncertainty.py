"""What measured standard deviations of the parameters leave of the critical speeds: Monte Carlo and Sobol indices.

Parameters are taken as independent and normal. The equations in closed form solve all samples at once.

    S_k = Var(E(y | x_k)) / Var(y),   T_k = 1 - Var(E(y | all but x_k)) / Var(y)
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from . import characteristic, critical
from .parameters import NOT_NEGATIVE, POSITIVE, SYMBOLS, Parameters, names
from .parameters import deviations as published
from .sheet import write_table

OUTPUTS = ("weave speed", "capsize speed", "lowest stable speed", "stable width")


@dataclass(frozen=True, eq=False)
class MonteCarlo:
    """Samples of a bicycle whose parameters are known to standard deviations.

    Attributes
    ----------
    parameters : Parameters
        Mean values.
    deviations : mapping
        Standard deviation by symbol, SI units.
    inputs : (n, k) ndarray
        Sampled parameters, in the order of ``deviations``.
    outputs : mapping of str to (n,) ndarray
        Speeds [m/s], NaN where a sample has none; the width of the stable range is 0 then, or infinite.
    impossible : float
        Share of the samples in which frame or fork has an inertia that no body has. They are kept: without them the
        deviations would not be those that were given.
    """

    parameters: Parameters
    deviations: Mapping[str, float]
    inputs: np.ndarray
    outputs: Mapping[str, np.ndarray]
    impossible: float = 0.0

    def share(self, name: str) -> float:
        """Part of the samples that has this speed."""
        return float(np.mean(np.isfinite(self.outputs[name])))

    def quantiles(self, name: str, at: tuple[float, ...] = (0.025, 0.5, 0.975)) -> np.ndarray:
        """(k,) quantiles [m/s] of the samples that have it; NaN if none has."""
        values = self.outputs[name][np.isfinite(self.outputs[name])]
        return np.quantile(values, at) if values.size else np.full(len(at), np.nan)

    def to_csv(self, path: str | Path) -> Path:
        """One row per sample, parameters and speeds; returns the file."""
        head = [*self.deviations, *(f"{name} [m/s]" for name in self.outputs)]
        return write_table(path, head, np.column_stack([self.inputs, *self.outputs.values()]))

    def __str__(self) -> str:
        lines = [f"{len(self.inputs)} samples of {self.parameters.name}   2.5 %    median    97.5 %   [m/s]"]
        for name in self.outputs:
            low, middle, high = self.quantiles(name)
            lines.append(
                f"  {name:20} {low:9.4f} {middle:9.4f} {high:9.4f}   in {100 * self.share(name):.1f} % of them"
            )
        if self.impossible:
            lines.append(f"  {100 * self.impossible:.1f} % have an inertia of frame or fork that no body has")
        return "\n".join(lines)


@dataclass(frozen=True, eq=False)
class Sobol:
    """Shares of the variance of an output that parameters cause.

    Attributes
    ----------
    names : tuple of str
        Symbols of the k parameters.
    first, total : mapping of str to (k,) ndarray
        First-order and total index by output; NaN where some samples have no such speed.
    """

    names: tuple[str, ...]
    first: Mapping[str, np.ndarray]
    total: Mapping[str, np.ndarray]

    def to_csv(self, path: str | Path) -> Path:
        """One row per parameter; returns the file."""
        head = ["parameter", *(f"{kind} of {name}" for name in self.first for kind in ("first order", "total"))]
        columns = [x[name] for name in self.first for x in (self.first, self.total)]
        return write_table(path, head, ([key, *row] for key, *row in zip(self.names, *columns, strict=True)))


def variants(parameters: Parameters, names: tuple[str, ...], x: np.ndarray) -> SimpleNamespace:
    """The parameters with ``x`` (k, n) in the place of those called ``names``: n bicycles at once, unchecked."""
    return SimpleNamespace(**{**vars(parameters), **dict(zip(names, x, strict=True))})


def speeds_of(variant: SimpleNamespace) -> dict[str, np.ndarray]:
    """The outputs [m/s] of n bicycles."""
    q = characteristic.of(variant)
    low, high = critical.first_range(q)
    width = np.where(np.isnan(low), 0.0, high - low)
    return dict(zip(OUTPUTS, (critical.weave(q), critical.capsize(q), low, width), strict=True))


def published_deviations(parameters: Parameters) -> dict[str, float]:
    """Standard deviations published with the set of this name; empty if there is none."""
    return published(parameters.name) if parameters.name in names() else {}


def checked_deviations(parameters: Parameters, given: Mapping[str, float] | None) -> dict[str, float]:
    """Standard deviations as given or as published with the set, none of them zero."""
    given = published_deviations(parameters) if given is None else given
    found = {key: float(std) for key, std in given.items() if std != 0.0}
    what = f"bicycle '{parameters.name}'"
    if not found:
        raise ValueError(f"{what}: no standard deviations; give them by symbol, e.g. {{'c': 0.01}}")
    for key, std in found.items():
        if key not in SYMBOLS:
            raise ValueError(f"{what}: deviation of '{key}': no such parameter; there are {', '.join(SYMBOLS)}")
        if not (np.isfinite(std) and std > 0.0):
            raise ValueError(f"{what}: deviation of {key} = {std!r}; give a positive number")
    return found


def monte_carlo(
    parameters: Parameters, deviations: Mapping[str, float] | None = None, *, n: int = 10_000, seed: int = 1
) -> MonteCarlo:
    """Sample the parameters and solve for the critical speeds of every sample.

    Parameters
    ----------
    parameters : Parameters
        Mean values.
    deviations : mapping, optional
        Standard deviation by symbol, SI units; None = those published with the set.
    n : int
        Samples.
    seed : int
        Of the random numbers: the same seed gives the same samples.

    Returns
    -------
    MonteCarlo

    Raises
    ------
    ValueError
        For unknown symbols, no deviations, or deviations so large that a sample is no bicycle.
    """
    known = checked_deviations(parameters, deviations)
    if n < 2:
        raise ValueError(f"monte_carlo: n = {n} samples; give at least 2")
    keys, random = tuple(known), np.random.default_rng(seed)
    mean = np.array([getattr(parameters, key) for key in keys])
    inputs = mean + np.array(list(known.values())) * random.normal(size=(n, len(keys)))
    check_samples(parameters, keys, inputs.T)
    sampled = variants(parameters, keys, inputs.T)
    return MonteCarlo(parameters, known, inputs, speeds_of(sampled), float(np.mean(impossible(sampled))))


def impossible(variant: SimpleNamespace) -> np.ndarray:
    """Whether frame or fork has a negative second moment of its mass, which breaks the triangle rule."""
    found = np.zeros((), bool)
    for part in "BH":
        xx, yy, zz, xz = (np.asarray(getattr(variant, f"I{part}{axis}")) for axis in ("xx", "yy", "zz", "xz"))
        across, along, up = (xx + zz - yy) / 2.0, (yy + zz - xx) / 2.0, (xx + yy - zz) / 2.0
        found = found | (across < 0.0) | (along < 0.0) | (up < 0.0) | (along * up < xz**2)
    return found


def check_samples(parameters: Parameters, names: tuple[str, ...], x: np.ndarray) -> None:
    """Refuse samples (k, n) that are no bicycles."""
    for key, values in zip(names, x, strict=True):
        if (key in POSITIVE and values.min() <= 0.0) or (key in NOT_NEGATIVE and values.min() < 0.0):
            raise ValueError(
                f"bicycle '{parameters.name}': a sample has {key} = {values.min():.3g}, which no bicycle has; "
                f"give a smaller deviation of {key}, or none"
            )


def sobol(
    parameters: Parameters, deviations: Mapping[str, float] | None = None, *, n: int = 2048, seed: int = 1
) -> Sobol:
    """Sobol indices of the critical speeds by `scipy.stats.sobol_indices`, n (k + 2) samples.

    Parameters
    ----------
    parameters, deviations, seed
        As in `monte_carlo`.
    n : int
        A power of two.

    Returns
    -------
    Sobol

    Raises
    ------
    ValueError
        As `monte_carlo`; or if n is no power of two.
    """
    from scipy.stats import norm, sobol_indices

    known = checked_deviations(parameters, deviations)
    if n < 2 or n & (n - 1):
        raise ValueError(f"sobol: n = {n}; give a power of two, e.g. 2048")
    keys, exists = tuple(known), np.ones(len(OUTPUTS), bool)

    def outputs(x: np.ndarray) -> np.ndarray:
        check_samples(parameters, keys, x)
        speeds = np.array(list(speeds_of(variants(parameters, keys, x)).values()))
        exists[:] &= np.isfinite(speeds).all(axis=1)
        return speeds

    distributions = [norm(getattr(parameters, key), std) for key, std in known.items()]
    with np.errstate(invalid="ignore", divide="ignore"):
        found = sobol_indices(func=outputs, n=n, dists=distributions, rng=seed)
    # scipy makes zeros of outputs that are NaN somewhere, and drops axes of length 1
    shape = len(OUTPUTS), len(keys)
    shares = (np.where(exists[:, None], x.reshape(shape), np.nan) for x in (found.first_order, found.total_order))
    first, total = (dict(zip(OUTPUTS, x, strict=True)) for x in shares)
    return Sobol(keys, first, total)
