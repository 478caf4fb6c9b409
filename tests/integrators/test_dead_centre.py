"""A driver that pulls a loop into a dead centre, where speeds grow beyond all bounds: the run ends there, in words."""

import pytest

from mbsd3d import IntegrationError, simulate
from validation.cases.examples import mechanism, moving

END = {22: 0.242428, 123: 0.052851}
"""Seed of a random mechanism whose drivers bring it to one, and when [s]."""


@pytest.mark.parametrize("rtol", [1e-6, 1e-10, 1e-12])
@pytest.mark.parametrize("seed", END)
def test_a_run_into_a_dead_centre_ends_there_and_names_the_driver(seed, rtol):
    """Rounding would hold the steps at 1e-5 of the way to it, which is never gone."""
    system = mechanism(seed)
    with pytest.raises(IntegrationError, match=r"driver 'SpeedDriver 1'.*where the mechanism locks") as stopped:
        simulate(system, 0.25, state=moving(system, seed), rtol=rtol, output=9)
    assert stopped.value.time == pytest.approx(END[seed], abs=1.5e-6)
    assert stopped.value.solution.record.evaluations < 10_000
