"""Bodies as laws see them, and what a law says."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import GROUND, System
from mbsd3d.extend import Coordinate, cross, evaluate, matrix
from validation.twins.base import Array, NotExpressible

NONE = np.zeros(3)
STATELESS = np.zeros(0)


@dataclass(frozen=True, eq=False)
class Placed:
    """A body now, where its point and axes stood along the world at the reference pose."""

    body: Any
    r: Array
    R: Array

    def axis(self, reference: Array) -> Array:
        """A direction of the body."""
        return self.R @ reference

    @property
    def axes(self) -> Array:
        """(3, 3) axes of the body in the world."""
        return self.R @ matrix(self.body.orientation)

    def point(self, reference: Array) -> Array:
        """A point of the body."""
        return self.r + self.R @ (reference - self.body.position)


@dataclass(frozen=True, eq=False)
class Moving(Placed):
    """With its velocities."""

    v: Array
    omega: Array

    def velocity(self, point: Array) -> Array:
        """Velocity of its matter at a point of space."""
        return self.v + cross(self.omega, point - self.r)


class Push(NamedTuple):
    """On b, world axes: a force at a point, a couple, and the rates of the own states; the opposite acts on a."""

    force: Array
    point: Array
    couple: Array = NONE
    rates: Array = STATELESS

    def moment(self, r: Array) -> Array:
        """About a point of space."""
        return cross(self.point - r, self.force) + self.couple


class Law(NamedTuple):
    """``push(t, a, b, z, x)``: z own states; x the hinge coordinate as it is counted, of which only turns are used."""

    a: Any
    b: Any
    push: Callable[[float, Moving, Moving, Array, float], Push]
    back: bool = True  # whether the opposite acts on a

    @property
    def sides(self) -> list[tuple[float, int]]:
        """(sign of the push, place in (a, b)) of the bodies that feel it; the ground does not."""
        felt = [(1.0, 1), (-1.0, 0)] if self.back else [(1.0, 1)]
        return [(sign, k) for sign, k in felt if (self.a, self.b)[k] is not GROUND]


def own_states(system: System, force: Any, z: Array) -> Array:
    """Those of a force, of all that a state has."""
    row = system.lowered.model.force[system.forces.index(force)]
    return z[row["state"] : row["state"] + row["states"]]


def one_axis(x: Coordinate, what: str, reason: str) -> None:
    """NotExpressible, with a reason, for a hinge whose axes on both sides differ as built."""
    if np.linalg.norm(x.axis - x.axis_b) > 1e-12:  # rounding of unit vectors
        raise NotExpressible(f"{what}: the axes on both sides differ as built; {reason}")


def follow(signal: Any, order: int = 0) -> Callable[[float], float]:
    """A signal or a derivative as f(t); a table goes on outside its interval, where differences at its ends need it."""
    terms = signal.terms()
    return lambda t: float(evaluate(terms, t, order))


def deepest(b: Placed, form: Any, n: Array) -> Array:
    """Where a surface of b reaches farthest against n: half axes r stretch a sphere, on it -r u'n / |r u'n|."""
    axes = b.R @ form.axes
    stretched = form.radii * (axes.T @ n)
    length = np.linalg.norm(stretched)
    inner = axes @ (form.radii * stretched) / length if length else np.zeros(3)
    return b.point(form.centre) - inner - form.tube * n
