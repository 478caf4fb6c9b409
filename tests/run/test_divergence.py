"""When a motion is judged to grow without end."""

import numpy as np
import pytest

from mbsd3d import Body, System
from mbsd3d.equations.compiled import compile_system
from mbsd3d.run.divergence import DivergenceWatch


@pytest.mark.parametrize("start", [0.0, 1e4])
@pytest.mark.parametrize(("half_way", "diverges"), [(5.0, False), (9.5, True)])
def test_doubling_counts_against_the_time_since_the_start(start, half_way, diverges):
    """Half of 3001 steps and a doubled speed in the last 5 of 10 s are a machine, in the last 0.5 s no machine."""
    watch = DivergenceWatch(compile_system(System([Body("stone", 1.0, (1.0, 1.0, 1.0))])), start)
    y = np.zeros(13)
    assert not watch.diverges(y, 1500, start + half_way, 1.0)
    assert watch.diverges(y, 3001, start + 10.0, 2.0) == diverges
