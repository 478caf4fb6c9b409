"""Small motions of a bicycle on tyres about a straight run: eigenvalues over the speed, critical speeds, a figure.

Nine freedoms and four deflections have 22 eigenvalues; place and heading add zeros, and speeding up, bouncing and
pitching go apart from what happens sideways. The states kept here are lean, steer and their rates, the speed to the
left of the rear hub, the yaw rate, the sideways deflections of both tyres, and the twist of a head tube that yields.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, linear_sum_assignment

from mbsd3d import Mode, System, linearize, measures
from mbsd3d.errors import InputError
from mbsd3d.extend import LINE, THIN, Measure, dress

from ..model.mechanism import outputs
from ..output import new_figure, write_table
from ..parameters import Parameters, machines

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Build = Callable[..., System]
"""``build(parameters, speed=v)`` returns a bicycle on tyres that runs straight."""
ORDER = (
    "weave", "capsize", "castering", "wobble", "second wobble", "third wobble", "fourth wobble", "tyre decay",
    "second tyre decay", "third tyre decay", "fourth tyre decay",
)  # fmt: skip
TWIN = " (conjugate)"
FOOT = 0.3048
"""[m]"""
CLOSED = 1e-8
"""How little the heading may matter, relative to the largest entry of A; rounding leaves 1e-13."""
TWO = (2.0, 6.0)
"""[m/s] from which all speeds follow."""
ROUNDING = 1e-6
"""Of the equations of almost rigid tyres, of 1e6 times their load for a radian and relaxation within 0.01 mm."""


class Limit(NamedTuple):
    """A speed at which a straight run becomes stable or unstable."""

    speed: float  # [m/s]
    frequency: float  # [rad/s] of the mode that changes: 0 = capsize


@dataclass(frozen=True, eq=False)
class TyreStability:
    """Sideways modes of a bicycle on tyres over the speed, as `study` finds them; a column of ``values`` per mode."""

    build: Build
    parameters: Parameters
    speeds: np.ndarray  # (n,) [m/s]
    values: np.ndarray  # (n, k) complex eigenvalues [1/s]
    limits: tuple[Limit, ...]  # between the speeds
    names: tuple[str, ...]

    @property
    def growth(self) -> np.ndarray:
        """(n,) of the fastest growing mode [1/s]; the bicycle is self-stable where it is negative."""
        return self.values.real.max(axis=1)

    def mode(self, name: str, speed: float) -> Mode:
        """A mode by its name at a speed [m/s]; ``.animate()`` shows it in motion."""
        if name not in self.names:
            raise InputError(f"mode '{name}' is unknown; give one of {', '.join(self.names)}")
        if not self.speeds[0] <= speed <= self.speeds[-1]:
            raise InputError(
                f"mode '{name}' is known from {self.speeds[0]:g} to {self.speeds[-1]:g} m/s; give a speed between"
            )
        wanted = np.interp(speed, self.speeds, self.values[:, self.names.index(name)])
        found = linearize(self.build(self.parameters, speed=float(speed))).modes
        return min(found, key=lambda mode: min(abs(mode.eigenvalue - s) for s in (wanted, wanted.conjugate())))

    def figure(self, *, dark: bool = False) -> "Figure":
        """Growth and frequency of the modes over the speed, with the self-stable ranges shaded."""
        return figure(self, dark=dark)

    def to_csv(self, path: str | Path) -> Path:
        """Write the eigenvalues by mode [1/s] over the speed [m/s]."""
        head = ["speed [m/s]"] + [f"{part} {name} [1/s]" for name in self.names for part in ("Re", "Im")]
        return write_table(path, head, np.column_stack([self.speeds, self.values.view(float)]))

    def __str__(self) -> str:
        edges = [self.speeds[0], *(at.speed for at in self.limits), self.speeds[-1]]
        stable = [pair for pair in zip(edges, edges[1:], strict=False) if self.stable(*pair)]
        ranges = ", ".join(f"{low:.6g} ... {high:.6g} m/s" for low, high in stable) or "nowhere"
        lines = [f"self-stable between {edges[0]:g} and {edges[-1]:g} m/s: {ranges}"]
        for at in self.limits:
            lines.append(f"  {at.speed:.6g} m/s: " + (f"{at.frequency:.5g} rad/s" if at.frequency else "capsize"))
        return "\n".join(lines)

    def stable(self, low: float, high: float) -> bool:
        """Whether it is self-stable between two neighbouring limits [m/s]."""
        return bool(np.interp(0.5 * (low + high), self.speeds, self.growth) < 0.0)


def sideways(system: System) -> list[Measure]:
    """What is kept, with the heading last."""
    rear = system.part("rear wheel")
    tyres = [measures.state(system.part(f"{wheel} tyre", "forces"), "lateral") for wheel in ("rear", "front")]
    twist = [joint for joint in system.joints if joint.name == "head twist"]
    more = [of(joint) for joint in twist for of in (measures.angle, measures.rate)]
    way = [measures.velocity(rear, axis=(0.0, 1.0, 0.0)), measures.heading_rate(system.part("frame"))]
    return [*outputs(system), *way, *tyres, *more, measures.heading(system.part("frame"))]


def matrix(system: System, speed: float) -> np.ndarray:
    """(k, k) A of the sideways states of a straight run at a speed [m/s], in body axes.

    The world's speed to the left is that over the bicycle and V heading: with it the heading drops out.
    """
    A = linearize(system, outputs=sideways(system), tolerance=ROUNDING).A
    turned = np.eye(len(A))
    turned[4, -1] = speed
    A = np.linalg.solve(turned, A @ turned)
    left = float(np.abs(A[:-1, -1]).max())
    if left > CLOSED * np.abs(A).max():
        raise InputError(f"the heading matters (residual {left:.2g}): a load does not turn along; take it away")
    return A[:-1, :-1]


def coefficients(build: Build, parameters: Parameters) -> tuple[np.ndarray, np.ndarray]:
    """(A_0, A_1), both (k, k), of A(v) = A_0 + v A_1: all speeds from two.

    Slip, gyroscopic and centripetal terms are products of v and a small rate, a deflection fades at the rate v over
    its relaxation length, and the heading, whose terms would hold v^2, is left out.
    """
    slow, fast = (matrix(build(parameters, speed=v), v) for v in TWO)
    rate = (fast - slow) / (TWO[1] - TWO[0])
    return slow - TWO[0] * rate, rate


def eigenvalues(build: Build, parameters: Parameters, speeds: ArrayLike) -> np.ndarray:
    """(n, k) complex eigenvalues [1/s] at speeds (n,) [m/s], by real part."""
    found = [matrix(build(parameters, speed=v), v) for v in np.asarray(speeds, float).ravel().tolist()]
    return np.array([np.sort_complex(np.linalg.eigvals(A)) for A in found])


def study(parameters: Parameters, speeds: ArrayLike, build: Build) -> TyreStability:
    """Follow the sideways modes over rising speeds [m/s]; see `bicycle.stability.study`."""
    speeds = np.unique(np.asarray(speeds, float))
    if speeds.size < 2:
        raise InputError("stability on tyres: give at least two different speeds, between which limits are sought")
    found = [np.linalg.eig(matrix(build(parameters, speed=v), v)) for v in speeds.tolist()]
    values, names = followed(found)
    return TyreStability(build, parameters, speeds, values, limits(parameters, speeds, values, build), names)


def followed(found: list) -> tuple[np.ndarray, tuple[str, ...]]:
    """(values with a column per mode, their names), from the fastest speed down, where modes are told apart."""
    here, shapes = found[-1]
    names = named(here)
    order = sorted(
        range(len(here)), key=lambda k: ORDER.index(names[k].removesuffix(TWIN)) + 0.5 * names[k].endswith(TWIN)
    )
    values, vectors = [here[order]], shapes[:, order]
    for there, shapes in reversed(found[:-1]):
        far = np.abs(values[-1][:, None] - there) / (1.0 + np.abs(there))
        change = far + 0.5 * (1.0 - np.abs(vectors.conj().T @ shapes) ** 2)
        place = linear_sum_assignment(change)[1]
        values.append(there[place])
        vectors = shapes[:, place]
    return np.array(values[::-1]), tuple(names[k] for k in order)


def named(values: np.ndarray) -> list[str]:
    """At the fastest speed: oscillations by frequency from weave on, decays from the slowest, capsize, on."""
    waves = iter(("weave", "wobble", "second wobble", "third wobble", "fourth wobble"))
    decays = iter(("capsize", "castering", "tyre decay", "second tyre decay", "third tyre decay", "fourth tyre decay"))
    names = [""] * len(values)
    for k in np.lexsort((-values.real, np.abs(values.imag))):
        if values[k].imag == 0.0:
            names[k] = next(decays)
        elif values[k].imag > 0.0:
            names[k] = next(waves)
            names[int(np.argmin(np.abs(values - values[k].conj())))] = names[k] + TWIN
    return names


def limits(parameters: Parameters, speeds: np.ndarray, values: np.ndarray, build: Build) -> tuple[Limit, ...]:
    """Where the largest growth changes sign between two of the speeds."""

    def worst(v: float) -> complex:
        s = np.linalg.eigvals(matrix(build(parameters, speed=v), v))
        return s[np.argmax(s.real)]

    growth, found = values.real.max(axis=1), []
    for k in np.flatnonzero(np.diff(np.signbit(growth))):
        v = brentq(lambda v: worst(v).real, speeds[k], speeds[k + 1], xtol=1e-10, rtol=1e-14)
        found.append(Limit(float(v), float(abs(worst(v).imag))))
    return tuple(found)


def published(found: TyreStability, axes: "Sequence[Axes]", ink: str) -> None:
    """Printed eigenvalues of a published machine as points."""
    rows = np.array(machines().get(found.parameters.name, {}).get("printed", {"rows": []})["rows"])
    if rows.size:
        v, capsize, weave, weave_w, wobble, wobble_w = rows.T
        style = {"color": ink, "marker": "o", "markersize": 3.5, "linestyle": "none"}
        for k, (growth, rate) in enumerate(((weave, weave_w), (wobble, wobble_w), (capsize, 0.0 * v))):
            axes[0].plot(FOOT * v, growth, label=None if k else "printed", **style)
            axes[1].plot(FOOT * v, rate, **style)


def figure(found: TyreStability, *, dark: bool = False) -> "Figure":
    """Growth and frequency of the sideways modes over the speed."""
    with new_figure(9.2, 6.2, dark) as (sheet, look):
        growth, frequency = sheet.subplots(2, 1, sharex=True, height_ratios=(1.7, 1.0))
        edges = [found.speeds[0], *(at.speed for at in found.limits), found.speeds[-1]]
        for axes in (growth, frequency):
            dress(axes, look)
            axes.margins(x=0.0)
            for low, high in zip(edges, edges[1:], strict=False):
                if found.stable(low, high):
                    axes.axvspan(low, high, color=look.good, linewidth=0.0, zorder=0)
        shown = [k for k, name in enumerate(found.names) if not name.endswith(TWIN)]
        for number, k in enumerate(shown):
            style = {"color": look.colour(number), "linewidth": LINE}
            growth.plot(found.speeds, found.values[:, k].real, label=found.names[k], **style)
            frequency.plot(found.speeds, np.abs(found.values[:, k].imag), **style)
            other = found.names[k] + TWIN
            if other in found.names:  # where an oscillation has split into two decays
                growth.plot(found.speeds, found.values[:, found.names.index(other)].real, **style)
        published(found, (growth, frequency), look.ink)
        growth.axhline(0.0, color=look.ink, linewidth=THIN)
        for at in found.limits:
            growth.axvline(at.speed, color=look.muted, linewidth=THIN, linestyle="--")
            growth.annotate(
                f"{at.speed:.4g} m/s", (at.speed, 0.99), xycoords=("data", "axes fraction"), rotation=90.0, ha="right",
                va="top", fontsize=8.5, color=look.muted,
            )  # fmt: skip
        slow = np.sort(found.values[:, shown].real, axis=1)[:, -2:]
        low, high = min(slow.min(), 0.0), max(slow.max(), 0.0)
        growth.set_ylim(low - 0.08 * (high - low), high + 0.08 * (high - low))
        growth.set_ylabel("growth, Re(s) [1/s]")
        frequency.set_ylabel("frequency, |Im(s)| [rad/s]")
        frequency.set_xlabel("speed [m/s]")
        growth.set_title(f"{found.parameters.name} on tyres: small motions about a straight run")
        growth.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), frameon=False, fontsize=9, labelcolor=look.ink)
    return sheet
