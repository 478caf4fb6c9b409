"""Measures at every sample of a run, by the kernel that also feeds them back and stops runs by them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..base.checks import shown
from ..base.errors import InputError
from ..equations.compiled import compile_system, new_data, tables_of
from ..kernels.coordinates import measure, remember
from ..kernels.kinematics import kinematics
from ..mechanism.measures import Measure, check_members

if TYPE_CHECKING:
    from .run_samples import RunSamples


def measured(solution: "RunSamples", wanted: Measure | Sequence[Measure]) -> np.ndarray:
    """See `Solution.measure`."""
    measures = tuple(wanted) if isinstance(wanted, list | tuple) else (wanted,)
    for one in measures:
        if not isinstance(one, Measure):
            raise InputError(f"solution.measure: {shown(one)} is not a measure; build one with mbsd3d.measures")
        check_members(solution.system, one, "solution.measure")
    model = compile_system(solution.system, measures).model
    data, known = new_data(model), len(tables_of(solution.system).coordinate_index)
    t, arrays = solution.t, solution.arrays
    values = np.empty((t.size, len(measures)))
    for k in range(t.size):
        data.coordinate["value"][:known] = arrays["coordinate"][k, :known]  # angles of hinges count their turns
        data.coordinate["rate"][:known] = 0.0  # those of other angles go on from the sample before
        kinematics(model, data, arrays["state"][k])
        values[k] = [measure(model, data, i, t[k]) for i in range(len(measures))]
        remember(model, data, t[k])
    return values[:, 0] if isinstance(wanted, Measure) else values
