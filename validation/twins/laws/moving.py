"""Bodies as laws read them, and the load of a law."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import GROUND, System
from mbsd3d.extend import Coordinate, cross, evaluate, matrix
from validation.twins.base import Array, NotExpressible

ZERO_VECTOR = np.zeros(3)
STATELESS = np.zeros(0)


@dataclass(frozen=True, eq=False)
class Placed:
    """Present pose of a body, whose point and axes stood along the world at the reference pose."""

    body: Any
    r: Array
    R: Array

    def axis(self, reference: Array) -> Array:
        """Return a direction of the body."""
        return self.R @ reference

    @property
    def axes(self) -> Array:
        """Return the axes of the body in the world, shape (3, 3)."""
        return self.R @ matrix(self.body.orientation)

    def point(self, reference: Array) -> Array:
        """Return a point of the body."""
        return self.r + self.R @ (reference - self.body.position)


@dataclass(frozen=True, eq=False)
class Moving(Placed):
    """Placed body with its velocities."""

    v: Array
    omega: Array

    def velocity(self, point: Array) -> Array:
        """Return the velocity of its material point at a point of space [m/s]."""
        return self.v + cross(self.omega, point - self.r)


class Push(NamedTuple):
    """Load on b, world axes: a force at a point, a couple, and the rates of the internal states; the opposite acts on
    a.
    """

    force: Array
    point: Array
    couple: Array = ZERO_VECTOR
    rates: Array = STATELESS

    def moment(self, r: Array) -> Array:
        """Return the moment about a point of space [N m]."""
        return cross(self.point - r, self.force) + self.couple


class Law(NamedTuple):
    """Force law ``push(t, a, b, z, x)``: z internal states; x the hinge coordinate as it is counted, of which only
    turns are used.
    """

    a: Any
    b: Any
    push: Callable[[float, Moving, Moving, Array, float], Push]
    back: bool = True  # whether the opposite acts on a

    @property
    def sides(self) -> list[tuple[float, int]]:
        """Return (sign of the load, position in (a, b)) of the loaded bodies, without the ground."""
        felt = [(1.0, 1), (-1.0, 0)] if self.back else [(1.0, 1)]
        return [(sign, k) for sign, k in felt if (self.a, self.b)[k] is not GROUND]


def own_states(system: System, force: Any, z: Array) -> Array:
    """Return the internal states of a force, from those of a state."""
    row = system.lowered.model.force[system.forces.index(force)]
    return z[row["state"] : row["state"] + row["states"]]


def one_axis(x: Coordinate, what: str, reason: str) -> None:
    """Raise NotExpressible, with a reason, for a hinge whose axes on both sides differ as built."""
    if np.linalg.norm(x.axis - x.axis_b) > 1e-12:  # rounding of unit vectors
        raise NotExpressible(f"{what}: the axes on both sides differ as built; {reason}")


def follow(signal: Any, order: int = 0) -> Callable[[float], float]:
    """Return a signal or a derivative as f(t); a table extrapolates outside its interval, where differences at its ends
    need it.
    """
    terms = signal.terms()
    return lambda t: float(evaluate(terms, t, order))


def deepest(b: Placed, form: Any, n: Array) -> Array:
    """Return the point of a surface of b that reaches farthest against n: half axes r stretch a sphere, on it -r u'n /
    |r u'n|.
    """
    axes = b.R @ form.axes
    stretched = form.radii * (axes.T @ n)
    length = np.linalg.norm(stretched)
    inner = axes @ (form.radii * stretched) / length if length else np.zeros(3)
    return b.point(form.centre) - inner - form.tube * n
