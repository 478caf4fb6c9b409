"""The self-stable range of a bicycle over two of its parameters, by closed form or from the general model."""

from collections.abc import Mapping, Sequence

import numpy as np

from .parameters import MEANING, Parameters

SYMBOL_ORDER = ("lowest stable speed", "highest stable speed")


def check_axes(parameters: Parameters, axes: Mapping[str, Sequence[float]]) -> dict[str, np.ndarray]:
    """Two parameters with their values."""
    if len(axes) != 2:
        raise ValueError(f"stable_map: {len(axes)} parameters; give two, e.g. {{'c': [0.05, 0.1], 'lam': [0.2, 0.4]}}")
    found = {}
    for key, values in axes.items():
        if key not in MEANING:
            raise ValueError(f"stable_map: no parameter '{key}'; there are {', '.join(MEANING)}")
        found[key] = np.asarray(values, float)
        if found[key].ndim != 1 or not found[key].size or not np.isfinite(found[key]).all():
            raise ValueError(f"stable_map: values of {key}; give a list of finite numbers")
    return found
