"""Friction by reactions in a run: whether the joints determine what presses, and whether friction holds itself."""

from typing import NamedTuple

import numpy as np

from ..base.errors import InputError
from ..constraints.rank import tree_over_rows
from ..constraints.redundancy import diagnose
from ..dynamics.joint_friction import HOLDS_ITSELF, pressing_loads
from ..dynamics.state_rates import evaluate
from ..equations.at_state import load_rows
from ..equations.compiled import Compiled
from ..kernels.layout import Data
from ..mechanism.forces.dry_friction import DryFriction
from ..results.checks.friction import gain_at
from ..results.reactions import RunRows, tolerance_of

HELD_GAIN = 0.99  # [1] at the last state before friction holds itself, which a run does not reach


class Blamed(NamedTuple):
    """The joint whose friction ends a run, why, and what to do."""

    part: str
    what: str
    advice: str


def check_friction_loads(start: RunRows) -> None:
    """Raise an InputError for friction by loads that the joints do not determine at the start.

    A share that is open, J' N = 0 with N != 0, must leave what presses as it is.
    """
    compiled = start.compiled
    if not compiled.model.frictions:
        return
    for found, _ in start.probes():
        data, limit = compiled.data(), tolerance_of(found)
        start.probe(0, data)  # loads the rows
        for k, force in enumerate(compiled.system.forces):
            if isinstance(force, DryFriction) and open_load(compiled, data, found, k) > limit:
                joint = compiled.system.name(force.joint)
                cures = diagnose(compiled.system, None).cures
                remedy = f"; {cures[0].text}" if cures else "; see system.check()"
                raise InputError(
                    f"force '{compiled.system.name(force)}' (DryFriction): the joints do not determine what presses in "
                    f"'{joint}', as rows repeat each other{remedy}"
                )


def open_load(compiled: Compiled, data: Data, found: list, k: int) -> float:
    """Return the largest pressing load of force k by a unit share that the joints leave open, made dimensionless."""
    model, largest = compiled.model, 0.0
    unit = model.length / compiled.system.forces[k].record().parameters["lever"]
    for island in found:
        for share in island.N.T:
            presses = np.zeros((2, 3))
            data.row["lam"] = 0.0
            data.row["lam"][island.rows] = share * model.row["scale"][island.rows]
            pressing_loads(model, data, k, presses)
            largest = max(largest, float(np.linalg.norm(presses, axis=1).max()) * unit)
    return largest


def find_held_friction(compiled: Compiled, data: Data, y: np.ndarray, t: float) -> Blamed | None:
    """Return the joint whose friction holds itself at a state, if it does."""
    if not compiled.model.frictions:
        return None
    load_rows(compiled, data, y, t)
    if not np.isfinite(data.row["J"]).all():
        return None
    tree = tree_over_rows(compiled.model, data, 0.0)
    status = evaluate(compiled.model, data, tree, t, y, np.empty_like(y))
    gain = gain_at(compiled, data, tree)
    if status != HOLDS_ITSELF and not gain.value >= HELD_GAIN:
        return None
    joint = gain.friction.joint
    size = "a longer guide, " if gain.friction.guide_length is not None else "a smaller radius, "
    return Blamed(
        f"{type(joint).__name__} '{compiled.system.name(joint)}'",
        f"friction holds itself, gain {gain.value:.3g}: from 1 on it jams, or moves in more than one way",
        f"give {size}a smaller mu or a guided load nearer to the axis",
    )
