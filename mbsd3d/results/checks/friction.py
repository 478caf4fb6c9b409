"""How far friction comes back on itself: its gain, at the samples of a run or at the state at hand."""

from typing import NamedTuple

import numpy as np

from ...constraints.rank import tree_over_rows
from ...dynamics.batch import loads_of_sample
from ...dynamics.joint_friction import friction_feedback
from ...equations.compiled import Compiled
from ...kernels.layout import Data, Tree
from ...mechanism.forces.dry_friction import DryFriction
from ...solver.saddle_point import factor
from ..result import RunResult

GAIN_SAMPLES = 200  # [samples] of a run at which the gain is looked at
GAIN_WARNED = 0.5  # [1] from which the loads depend on mu out of proportion: w grows like 1 / (1 - gain)


class Gain(NamedTuple):
    """Spectral radius of dg/dw, w = g(reaction under w), and the friction that takes most part in its mode."""

    value: float
    friction: DryFriction


def gain_at(compiled: Compiled, data: Data, tree: Tree) -> Gain:
    """Return the gain with the rows, loads, multipliers and factor at hand."""
    numbers = np.flatnonzero(compiled.model.force["rows"])
    k = numbers.size
    D, presses, columns, none, missed = (np.zeros(x) for x in ((k, k), (k, 2, 3), (k, k, 2, 3), k, k))
    friction_feedback(compiled.model, data, tree, numbers, presses, columns, none, missed, D)
    if not np.isfinite(D).all():
        return Gain(np.nan, compiled.system.forces[numbers[0]])
    values, right = np.linalg.eig(D)
    left = np.linalg.eig(D.T)
    most = int(np.argmax(np.abs(values)))
    same = int(np.argmin(np.abs(left[0] - values[most])))
    share = np.abs(right[:, most] * left[1][:, same])  # whatever the units of the loads
    return Gain(float(np.abs(values[most])), compiled.system.forces[numbers[int(np.argmax(share))]])


def friction_notes(solution: RunResult) -> list[str]:
    """Return a note with the greatest gain of friction on itself in a run."""
    compiled, arrays, t = solution.compiled, solution.arrays, solution.t
    if not compiled.model.frictions or not t.size:
        return []
    data, tree, found = compiled.data(), None, []
    samples = np.unique(np.linspace(0, t.size - 1, min(t.size, GAIN_SAMPLES)).astype(int))
    for k in samples.tolist():
        known = arrays["state"][k], arrays["coordinate"][k], arrays["lam"][k]
        loads_of_sample(compiled.model, data, t[k], *known)
        if tree is None or tree.state.worn == 1:
            tree = tree_over_rows(compiled.model, data, solution.record.tolerance)
        factor(compiled.model, data, tree)
        found.append((gain_at(compiled, data, tree), float(t[k])))
    (gain, friction), at = max(found, key=lambda each: each[0].value)
    text = f"friction: greatest gain on itself {gain:.2g} at t = {at:.4g} s ('{solution.system.name(friction.joint)}')"
    if gain >= GAIN_WARNED:
        text += f"; it jams from 1 on, and loads err by {1.0 / (1.0 - gain):.2g} times what mu errs by"
    return [text]
