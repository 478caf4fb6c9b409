"""State of a mechanism at one time, as at the start and the end of a run."""

import math
from collections.abc import Mapping
from dataclasses import field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import numbers
from ..base.errors import InputError
from ..base.fields import Checked, Number, Stored, derive, kept, part_class
from ..base.style import html_table


def as_entries(value: Any, what: str, part: Any) -> np.ndarray:
    """Convert to a new array of finite numbers."""
    plain = type(value) is np.ndarray and value.dtype == np.float64
    array = value.copy() if plain else numbers(value, what).copy()
    if not (math.isfinite(array.sum()) or np.isfinite(array).all()):  # a sum of numbers may overflow
        raise InputError(f"{what} has an entry that is not finite; give finite numbers")
    return array


class Entries(Stored[ArrayLike, np.ndarray]):
    """Finite numbers in the order of the bodies."""

    accepts, file_type = "array_like", list
    convert = staticmethod(as_entries)


@part_class()
class State(Checked):
    """Coordinates, velocities and internal states of the force elements at one time; not what `Input` signals are set
    to.

    Parameters
    ----------
    t : float
        [s]
    q : (7 n,) array
        Per body (r, e): reference point [m, world] and unit quaternion, scalar first, body -> world.
    v : (6 n,) array
        Per body (r_dot, w): [m/s], [rad/s], both world.
    z : (k,) array
        Internal states of the force elements, in their order; empty = their declared initial values.
    coordinates : array or None
        Hinge angles [rad] and slides [m], unwrapped, in the order of the compiled model; None = nearest to zero. They
        are those of the system: of angles that only a condition or a stepper measures a state keeps no count.
    moved : mapping
        Displacements by the assembly: body name -> (distance [m], angle [rad]) from the reference pose.
    modes : mapping
        Of parts that switch at events: name -> (mode, numbers); empty = as they are at the reference pose.
    notes : tuple of str
        Choices of the assembly where the given values do not determine the pose or the path to it.

    Raises
    ------
    ValueError
        For entries that are not finite, and numbers of q and v that do not belong together.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from mbsd3d import Body, System, simulate
    >>> stone = Body("stone", 1.0, (0.1, 0.1, 0.1), position=(0, 0, 2), velocity=(3, 0, 0), omega=(0, 0, 0))
    >>> system = System([stone])
    >>> start = system.state()
    >>> start.q, start.v
    (array([0., 0., 2., 1., 0., 0., 0.]), array([3., 0., 0., 0., 0., 0.]))
    >>> faster = replace(start, v=2.0 * start.v)
    >>> round(float(simulate(system, 0.5, state=faster).position(stone)[-1, 0]), 9)
    3.0
    """

    t: Number = kept()
    q: Entries = kept()
    v: Entries = kept()
    z: Entries = kept(default=())
    coordinates: np.ndarray | None = None
    moved: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    modes: Mapping[str, tuple[str, tuple[float, ...]]] = field(default_factory=dict)

    @classmethod
    def of_numbers(
        cls, t: float, q: np.ndarray, v: np.ndarray, z: np.ndarray, coordinates: np.ndarray | None = None, **rest: Any
    ) -> "State":
        """Return a state of finite numbers that fit, in arrays that are its own from now on: nothing is checked."""
        state = object.__new__(cls)
        derive(state, t=t, q=q, v=v, z=z, coordinates=coordinates, **{"moved": {}, "notes": (), "modes": {}, **rest})
        return state

    def check(self, what: str) -> None:
        if self.q.size % 7 or self.v.size % 6 or self.q.size // 7 != self.v.size // 6:
            raise InputError(f"State: {self.q.size} coordinates and {self.v.size} velocities; give 7 and 6 per body")

    def _repr_html_(self) -> str:
        rows = []
        for i, (q, v) in enumerate(zip(self.q.reshape(-1, 7), self.v.reshape(-1, 6), strict=True)):
            cells = (" ".join(f"{x:.4g}" for x in part) for part in (q[:3], q[3:], v[:3], v[3:]))
            rows.append((str(i + 1), *cells))
        head = ("body no.", "position [m]", "quaternion", "velocity [m/s]", "angular velocity [rad/s]")
        own = f", internal states {' '.join(f'{x:.4g}' for x in self.z)}" if self.z.size else ""
        return html_table(f"state at t = {self.t:g} s{own}", head, rows)
