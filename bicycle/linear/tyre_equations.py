"""Linear equations of a bicycle on tyres about a straight run, and the limits of its stable speeds.

Kept are lean, steer and their rates, the speed to the left of the rear hub, the yaw rate, the sideways deflections of
both tyres, and the twist of a head tube that yields. Place and heading drop out; speeding up, bouncing and pitching go
apart from what happens sideways. In body axes a speed v enters by v itself, through spins, yaw and relaxation:

    x' = (A0 + v A1) x

So two linearisations hold all speeds, and a third confirms it. Where an eigenvalue crosses the imaginary axis, one is
zero or two have the sum zero: det(A0 + v A1) = 0, or det(L0 + v L1) = 0 with L X = A X + X A' on skew X. These v are
eigenvalues of pencils: no grid of speeds, and no range too narrow to be found.
"""

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from mbsd3d import System, linearize, measures
from mbsd3d.errors import InputError
from mbsd3d.extend import Measure

from ..model.mechanism import outputs
from ..parameters import Parameters
from .critical import Range

Build = Callable[..., System]
"""``build(parameters, speed=v)`` returns a bicycle on tyres that runs straight."""
AFFINE_TOLERANCE = 1e-8
"""How little the heading may matter, relative to the largest entry of A; rounding leaves 1e-13."""
GROWTH_ROUNDING = 1e-6
"""Of the equations of almost rigid tyres, of 1e6 times their load for a radian and relaxation within 0.01 mm."""
LIMIT_TOLERANCE = 1e-10
"""How well a third speed must confirm two, relative to the largest entry; rounding leaves 1e-15."""
SPEED_MAX = 200.0
"""[m/s] Up to which ranges are sought; one that is still stable there has no end."""
REAL_ROOT_TOLERANCE = 1e-4
"""Imaginary part, relative, of a speed that a pencil finds: a double one is off by the root of rounding."""
SAME_LIMIT_TOLERANCE = 1e-6
"""On both sides of a speed, relative, the largest growth must have opposite signs."""


class Limit(NamedTuple):
    """Speed at which a straight run becomes stable or unstable."""

    speed: float  # [m/s]
    frequency: float  # [rad/s] of the mode that changes: 0 = capsize


def sideways(system: System) -> list[Measure]:
    """Return the measures that are kept, with the heading last."""
    rear = system.part("rear wheel")
    tyres = [measures.state(system.part(f"{wheel} tyre", "forces"), "lateral") for wheel in ("rear", "front")]
    twist = [joint for joint in system.joints if joint.name == "head twist"]
    more = [of(joint) for joint in twist for of in (measures.angle, measures.rate)]
    way = [measures.velocity(rear, axis=(0.0, 1.0, 0.0)), measures.heading_rate(system.part("frame"))]
    return [*outputs(system), *way, *tyres, *more, measures.heading(system.part("frame"))]


def matrix(system: System, speed: float) -> np.ndarray:
    """Return A of the lateral states of a straight run at a speed [m/s], in body axes, shape (k, k).

    The world's speed to the left is that over the bicycle and V heading: with it the heading drops out.
    """
    try:
        A = linearize(system, outputs=sideways(system), tolerance=GROWTH_ROUNDING).A
    except InputError as error:
        if not any(getattr(force, "rolling_resistance", 0.0) for force in system.forces):
            raise
        raise InputError(f"{error}; rolling resistance slows a bicycle down: leave out rolling_resistance") from None
    turned = np.eye(len(A))
    turned[4, -1] = speed
    A = np.linalg.solve(turned, A @ turned)
    left = float(np.abs(A[:-1, -1]).max())
    if left > AFFINE_TOLERANCE * np.abs(A).max():
        raise InputError(f"the heading matters (residual {left:.2g}): a load does not turn along; take it away")
    return A[:-1, :-1]


def eigenvalues(build: Build, parameters: Parameters, speeds: ArrayLike) -> np.ndarray:
    """Return the complex eigenvalues [1/s] at speeds (n,) [m/s], by real part, shape (n, k)."""
    found = [matrix(build(parameters, speed=v), v) for v in np.asarray(speeds, float).ravel().tolist()]
    return np.array([np.sort_complex(np.linalg.eigvals(A)) for A in found])


class SpeedBySpeed(NamedTuple):
    """Equations A(v) of a model that depend on the speed in any way."""

    build: Build
    parameters: Parameters

    def A(self, speed: float) -> np.ndarray:
        """Return A at a speed [m/s], shape (k, k)."""
        return matrix(self.build(self.parameters, speed=speed), speed)

    def limits(self, speeds: np.ndarray) -> tuple[Limit, ...]:
        """Return the limits where the largest growth changes sign between two of the speeds [m/s]."""
        return limits_between(self.A, speeds)

    def table(self, speeds: np.ndarray) -> "Table":
        """Compute A(v) at rising speeds (n,) [m/s], to interpolate between."""
        return Table(speeds, CubicSpline(speeds, [self.A(v) for v in speeds.tolist()]))


class Table(NamedTuple):
    """Equations A(v) interpolated between known speeds, constant beyond the first and the last."""

    speeds: np.ndarray  # (n,) [m/s], rising
    spline: CubicSpline

    def A(self, speed: float) -> np.ndarray:
        """Return A at a speed [m/s], shape (k, k)."""
        return self.spline(np.clip(speed, self.speeds[0], self.speeds[-1]))

    def stable(self) -> list[Range]:
        """Return self-stable ranges from the first to the last speed."""
        return stable_between(self.A, self.speeds)


class Affine(NamedTuple):
    """Equations A(v) = A0 + v A1 for all v > 0."""

    A0: np.ndarray  # (k, k)
    A1: np.ndarray

    def A(self, speed: float) -> np.ndarray:
        """Return A at a speed [m/s], shape (k, k)."""
        return self.A0 + speed * self.A1

    def limits(self, speeds: np.ndarray) -> tuple[Limit, ...]:
        """Return every limit between the first and the last speed [m/s]."""
        pencils = ((self.A0, self.A1), (pair_sums(self.A0), pair_sums(self.A1)))
        found = np.concatenate([scipy.linalg.eigvals(first, -second) for first, second in pencils])
        real = np.isfinite(found) & (np.abs(found.imag) <= REAL_ROOT_TOLERANCE * np.abs(found))
        within = np.sort(found[real & (found.real > speeds[0]) & (found.real < speeds[-1])].real)
        kept: list[Limit] = []
        for v in within:
            low, high = v * (1.0 - SAME_LIMIT_TOLERANCE), v * (1.0 + SAME_LIMIT_TOLERANCE)
            if growth(self.A(low)) * growth(self.A(high)) < 0.0 and not (kept and low < kept[-1].speed):
                kept.append(limit(self.A, low, high))
        return tuple(kept)

    def stable(self) -> list[Range]:
        """Return self-stable ranges of all speeds from 0 to `SPEED_MAX`."""
        edges = [0.0, *(at.speed for at in self.limits(np.array([0.0, SPEED_MAX])))]
        return stable_parts(self.A, [*edges, np.inf])


def stable_parts(A: Callable[[float], np.ndarray], edges: Sequence[float]) -> list[Range]:
    """Return the self-stable ranges between rising speeds [m/s]."""
    pairs = [Range(float(low), float(high)) for low, high in pairwise(edges)]
    return [part for part in pairs if growth(A(between(part))) < 0.0]


def limits_between(A: Callable[[float], np.ndarray], speeds: np.ndarray) -> tuple[Limit, ...]:
    """Return the limits where the largest growth changes sign between two rising speeds [m/s]."""
    grown = [growth(A(v)) for v in speeds.tolist()]
    return tuple(limit(A, speeds[k], speeds[k + 1]) for k in np.flatnonzero(np.diff(np.signbit(grown))))


def stable_between(A: Callable[[float], np.ndarray], speeds: np.ndarray) -> list[Range]:
    """Return self-stable ranges from the first to the last of rising speeds [m/s]; limits are sought between two of
    them.
    """
    edges = [speeds[0], *(at.speed for at in limits_between(A, speeds)), speeds[-1]]
    return stable_parts(A, edges)


def between(part: Range) -> float:
    """Return a speed within a range [m/s], where its growth is evaluated."""
    return 0.5 * (part.low + (part.high if np.isfinite(part.high) else SPEED_MAX))


def growth(A: np.ndarray) -> float:
    """Return the growth of the fastest growing mode [1/s]."""
    return float(np.linalg.eigvals(A).real.max())


def limit(A: Callable[[float], np.ndarray], low: float, high: float) -> Limit:
    """Return the limit between two speeds with growths of opposite signs."""
    v = brentq(lambda v: growth(A(v)), low, high, xtol=1e-12, rtol=1e-14)
    values = np.linalg.eigvals(A(v))
    return Limit(float(v), float(abs(values[np.argmax(values.real)].imag)))


def pair_sums(A: np.ndarray) -> np.ndarray:
    """Return the matrix X -> A X + X A' on skew X, whose eigenvalues are the sums of two different ones of A, k (k -
    1)/2 squared.
    """
    rows, columns = np.triu_indices(len(A), 1)
    skew = np.zeros((len(rows), len(A), len(A)))
    skew[np.arange(len(rows)), rows, columns] = 1.0
    skew -= skew.transpose(0, 2, 1)
    return (A @ skew + skew @ A.T)[:, rows, columns].T


def equations(build: Build, parameters: Parameters, speed: float = 10.0) -> Affine | SpeedBySpeed:
    """Return the equations of all speeds > 0 from two, if a third confirms them; else every speed is linearized.

    ``speed`` [m/s] is the larger of the two. Damping of tyres at rest fades as the speed grows: such a model is not
    affine.
    """
    direct = SpeedBySpeed(build, parameters)
    low, high = 0.2 * speed, speed
    first, last = direct.A(low), direct.A(high)
    A1 = (last - first) / (high - low)
    found = Affine(first - low * A1, A1)
    third = 0.6 * speed
    size = max(np.abs(first).max(), np.abs(last).max())
    return found if np.abs(direct.A(third) - found.A(third)).max() <= LIMIT_TOLERANCE * size else direct


def required_equations(build: Build, parameters: Parameters) -> Affine:
    """Return affine `equations`; raise ValueError for others."""
    found = equations(build, parameters)
    if isinstance(found, SpeedBySpeed):
        raise InputError(
            f"bicycle '{parameters.name}': its tyres depend on speed otherwise than through slip, so the ranges of all "
            "speeds follow from no pencil; leave out standing_damping, or see stability.study, speed by speed"
        )
    return found
