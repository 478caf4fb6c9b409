"""Events of a ride: fallen, a wheel that is not pressed to the ground any more."""

from typing import Any

import numpy as np
from scipy.optimize import brentq

from mbsd3d import accelerations
from mbsd3d.mechanism import measures
from mbsd3d.mechanism.measures import Measure

from .models import Bicycle
from .motion import WHEELS, Event, Ride
from .parameters import Parameters


def elevation(system: Bicycle) -> Measure:
    """Of the direction that is up in the frame: pi/2 minus the tilt, whichever way it tilts."""
    return measures.lean(system.part("frame"), lateral=(0.0, 0.0, 1.0))


def loads(solution: Any) -> dict[str, np.ndarray]:
    """(n,) upward force of the ground on each wheel [N]."""
    return {wheel: solution.reaction(f"{wheel} contact").force[:, 2] for wheel in WHEELS}


def check_start(parameters: Parameters, start: Ride, limit: float, held_down: bool) -> None:
    """Refuse a start at which the bicycle has fallen, or the ground would have to pull at a wheel."""
    what, tilt = f"bicycle '{parameters.name}'", np.arccos(np.clip(start.solution.rotation("frame")[0, 2, 2], -1, 1))
    if tilt >= limit:
        raise ValueError(f"{what}: tilted by {tilt:.4g} rad at the start, where {limit:.4g} counts as fallen")
    for wheel, load in loads(start.solution).items():
        if load[0] <= 0.0 < parameters.g and not held_down:
            share = parameters.front_load
            remedy = f"it tips even at rest, with {100.0 * share:.4g} % of its weight on the front wheel; give "
            if 0.0 < share < 1.0:
                remedy = "give a slower or more upright start, or "
            raise ValueError(
                f"{what}: the {wheel} wheel is not pressed to the ground at the start (load {load[0]:.6g} N); {remedy}"
                "held_down=True (--held-down) for a ground that can pull"
            )


def unloading(solution: Any) -> Event | None:
    """The first moment at which a wheel is not pressed to the ground any more."""
    if not np.any(solution.system.gravity):
        return None  # nothing presses
    found = []
    for wheel, load in loads(solution).items():
        lifted = np.flatnonzero(load <= 0.0)
        if lifted.size:
            k = int(lifted[0])
            t = brentq(load_at, *solution.t[k - 1 : k + 1], args=(solution, wheel), xtol=1e-9) if k else solution.t[0]
            found.append(Event(f"{wheel} wheel unloaded", float(t)))
    return min(found, key=lambda event: event.t, default=None)


def load_at(t: float, solution: Any, wheel: str) -> float:
    """Upward force on a wheel at any time of a run [N]."""
    return float(loads(accelerations(solution.system, solution.at(t)))[wheel][0])
