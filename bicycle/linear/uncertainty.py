"""Critical speeds of a bicycle whose parameters are uncertain: Monte Carlo and Sobol indices.

Parameters are taken as independent and normal. The equations in closed form solve all samples at once.

    S_k = Var(E(y | x_k)) / Var(y),   T_k = 1 - Var(E(y | all but x_k)) / Var(y)
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, cast

import numpy as np

from mbsd3d import Sobol, uncertainty
from mbsd3d.errors import InputError
from mbsd3d.extend import LINE_WIDTH_POINTS, Result, new_figure, style_axes, whole, write_table

from ..parameters import NOT_NEGATIVE, POSITIVE, SYMBOL, TYRES, Parameters, check_set, checked_deviations
from . import critical

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

OUTPUTS = ("weave speed", "capsize speed", "lowest stable speed", "stable width")
FIGURE_PARAMETERS = 14  # [1] parameters of a figure: those that matter most


@dataclass(frozen=True, eq=False, repr=False)
class MonteCarlo(Result):
    """Samples of a bicycle whose parameters have standard deviations.

    Samples in which frame or fork has an inertia that no rigid body has are kept and counted: without them the
    deviations would not be those that were given.
    """

    parameters: Parameters  # mean values
    deviations: Mapping[str, float]  # standard deviation by symbol [SI units]
    inputs: np.ndarray  # (n, k) sampled parameters, in the order of ``deviations``
    outputs: Mapping[str, np.ndarray]  # (n,) [m/s] by name, NaN for none; then the stable width is 0
    impossible: float = 0.0  # share of the samples with an impossible inertia

    def share(self, name: str) -> float:
        """Return the share of the samples that have this speed [-]."""
        return float(np.mean(np.isfinite(self.outputs[name])))

    def quantiles(self, name: str, at: tuple[float, ...] = (0.025, 0.5, 0.975)) -> np.ndarray:
        """Return quantiles [m/s] of the samples that have this speed; NaN if none has; shape (k,)."""
        values = self.outputs[name][np.isfinite(self.outputs[name])]
        return np.quantile(values, at) if values.size else np.full(len(at), np.nan)

    def to_csv(self, path: str | Path) -> Path:
        """Write one row per sample, parameters and speeds; return the file."""
        head = [*self.deviations, *(f"{name} [m/s]" for name in self.outputs)]
        return write_table(path, head, np.column_stack([self.inputs, *self.outputs.values()]))

    def __str__(self) -> str:
        lines = [f"{len(self.inputs)} samples of {self.parameters.name}   2.5 %    median    97.5 %   [m/s]"]
        for name in self.outputs:
            low, middle, high = self.quantiles(name)
            share = 100 * self.share(name)
            lines.append(f"  {name:20} {low:9.4f} {middle:9.4f} {high:9.4f}   in {share:.1f} % of them")
        if self.impossible:
            lines.append(f"  {100 * self.impossible:.1f} % have an inertia of frame or fork that no rigid body has")
        return "\n".join(lines)


def variants(parameters: Parameters, names: tuple[str, ...], x: np.ndarray) -> SimpleNamespace:
    """Return the parameters with ``x`` (k, n) in place of those called ``names``: n bicycles at once, unchecked."""
    return SimpleNamespace(**{**vars(parameters), **dict(zip(names, x, strict=True))})


def speeds_of(variant: SimpleNamespace) -> dict[str, np.ndarray]:
    """Return the outputs [m/s] of n bicycles."""
    q = critical.polynomial(variant)
    low, high = critical.first_range(q)
    width = np.where(np.isnan(low), 0.0, high - low)
    return dict(zip(OUTPUTS, (critical.weave(q), critical.capsize(q), low, width), strict=True))


def known_deviations(parameters: Parameters, given: Mapping[str, float] | None) -> dict[str, float]:
    """Return standard deviations as given or as measured with the set, none of them zero."""
    check_set(parameters, "deviations")
    what = f"bicycle '{parameters.name}'"
    found = checked_deviations(parameters.deviations if given is None else given, what)
    if not found:
        raise InputError(f"{what}: no standard deviations; give them by symbol, e.g. {{'c': 0.01}}")
    if crowns := [key for key in TYRES if key in found]:
        raise InputError(f"{what}: deviation of {crowns[0]}: samples are solved for knife-edge wheels; leave it out")
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
        Standard deviation by symbol, SI units; None = ``parameters.deviations``, of a file or published.
    n : int
        Samples.
    seed : int
        Of the random numbers: the same seed gives the same samples.

    Raises
    ------
    ValueError
        For unknown symbols, no deviations, or deviations so large that a sample is impossible.
    """
    known = known_deviations(parameters, deviations)
    n, random = whole(n, "monte_carlo: n", 2), np.random.default_rng(whole(seed, "monte_carlo: seed", 0))
    keys = tuple(known)
    mean = np.array([getattr(parameters, key) for key in keys])
    inputs = mean + np.array(list(known.values())) * random.normal(size=(n, len(keys)))
    check_samples(parameters, keys, inputs.T)
    sampled = variants(parameters, keys, inputs.T)
    return MonteCarlo(parameters, known, inputs, speeds_of(sampled), float(np.mean(impossible(sampled))))


def impossible(variant: SimpleNamespace) -> np.ndarray:
    """Return whether frame or fork has a negative second moment of its mass, which breaks the triangle rule."""
    found = np.zeros((), bool)
    for part in "BH":
        xx, yy, zz, xz = (np.asarray(getattr(variant, f"I{part}{axis}")) for axis in ("xx", "yy", "zz", "xz"))
        across, along, up = (xx + zz - yy) / 2.0, (yy + zz - xx) / 2.0, (xx + yy - zz) / 2.0
        found = found | (across < 0.0) | (along < 0.0) | (up < 0.0) | (along * up < xz**2)
    return found


def check_samples(parameters: Parameters, names: tuple[str, ...], x: np.ndarray) -> None:
    """Raise ValueError for samples (k, n) with lengths, masses or a tilt that are impossible."""
    for key, values in zip(names, x, strict=True):
        least, most = values.min(), np.abs(values).max()
        low = (key in POSITIVE and least <= 0.0) or (key in NOT_NEGATIVE and least < 0.0)
        if low or (key == "lam" and most >= np.pi / 2):
            raise InputError(
                f"bicycle '{parameters.name}': a sample has {key} = {least if low else most:.3g}, which is impossible; "
                f"give a smaller deviation of {key}, or none"
            )


def sobol(
    parameters: Parameters, deviations: Mapping[str, float] | None = None, *, n: int = 2048, seed: int = 1
) -> Sobol:
    """Compute Sobol indices of the critical speeds by n (k + 2) samples, n a power of two; the rest as in
    `monte_carlo`.
    """
    known = known_deviations(parameters, deviations)
    n, seed = whole(n, "sobol: n", 2), whole(seed, "sobol: seed", 0)
    if n & (n - 1):
        raise InputError(f"sobol: n = {n}; give a power of two, e.g. 2048")

    def outputs(**columns: np.ndarray) -> dict[str, np.ndarray]:
        x = np.array(list(columns.values()))
        check_samples(parameters, tuple(columns), x)
        return speeds_of(variants(parameters, tuple(columns), x))

    spread = {key: ("normal", getattr(parameters, key), std) for key, std in known.items()}
    return cast(Sobol, uncertainty(outputs, spread, n, seed=seed).sobol)  # there is one of independent parameters


def plot_uncertainty(found: MonteCarlo, indices: Sobol, *, dark: bool = False) -> "Figure":
    """Plot the distribution of weave and capsize speed (left), and which parameters cause it (right)."""
    names = OUTPUTS[:2]
    total = {name: np.nan_to_num(indices.total[name]) for name in names}
    order = np.argsort(-np.maximum(*total.values()))[:FIGURE_PARAMETERS]
    with new_figure(9.0, max(3.4, 1.7 + 0.28 * len(order)), dark) as (figure, look):
        left, right = figure.subplots(1, 2)
        for k, name in enumerate(names):
            draw_samples(left, found.outputs[name], name, look.colour(k))
            place = np.arange(order.size) + 0.36 * (k - 0.5)
            right.barh(place, total[name][order], height=0.34, color=look.colour(k), label=name)
            right.plot(indices.first[name][order], place, "|", color=look.ink, markersize=7)
        for axes in (left, right):
            style_axes(axes, look)
        left.set_xlabel("speed [m/s]")
        left.set_ylabel("probability density [s/m]")
        title = f"{found.parameters.name}: {len(found.inputs)} samples, and which parameters spread them"
        figure.suptitle(title, x=0.01, ha="left", color=look.ink, fontsize=11)
        handles, labels = right.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper right", frameon=False, labelcolor=look.ink, ncols=2)
        right.grid(False, axis="y")
        right.set_yticks(range(order.size), [SYMBOL[indices.names[k]] for k in order])
        right.set_ylim(order.size - 0.4, -0.6)
        right.set_xlabel("share of the variance [1]: total index; stroke: first order")
    return figure


def draw_samples(axes: "Axes", values: np.ndarray, name: str, colour: str) -> None:
    """Draw the outline of a histogram; nothing where no sample has this speed."""
    values = values[np.isfinite(values)]
    if values.size and np.ptp(values) > 0.0:
        axes.hist(values, bins=60, density=True, histtype="step", linewidth=LINE_WIDTH_POINTS, color=colour, label=name)
