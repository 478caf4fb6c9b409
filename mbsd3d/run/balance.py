"""Loads between bodies come in pairs: a custom force that forgets one of them is found before the run."""

import numpy as np

from ..base.errors import InputError
from ..equations.compiled import Compiled
from ..mechanism.bodies import GROUND
from .own_functions import alone, ask, own_forces

SMALL = 1e-9  # of the loads themselves: more than their sums round to


def check_balance(compiled: Compiled, y: np.ndarray, t: float) -> None:
    """ValueError for a `CustomForce` on several moving bodies whose loads leave a resultant, unless it is external.

    Sum F = 0 and sum (M + r x F) = 0 over its bodies, r the reference points, at the state and time given.
    """
    for k, force in own_forces(compiled.system):
        if force.external or len(set(map(id, force.on))) < 2:
            continue
        if any(body is GROUND for body in force.on):
            continue
        model, data = alone(compiled, k)
        ask(model, data, y, t)
        push, turn = data.body["Q"][:-1, :3], data.body["Q"][:-1, 3:]
        lever = np.cross(data.body["r"][:-1], push)
        left, most = np.abs(push.sum(0)).max(), np.abs(push).max()
        twist, largest = np.abs((turn + lever).sum(0)).max(), max(np.abs(turn).max(), np.abs(lever).max())
        if left > SMALL * most or twist > SMALL * largest:
            names = ", ".join(f"'{body.name}'" for body in force.on)
            raise InputError(
                f"force '{compiled.system.name(force)}' (CustomForce): its loads on {names} leave {left:.3g} N and "
                f"{twist:.3g} N m; give each body the opposite of what the others get, or external=True if something "
                "outside pushes"
            )
