"""A driver that pulls a loop into a dead centre, where speeds grow beyond all bounds: the run ends there, in words."""

import numpy as np
import pytest

from mbsd3d import IntegrationError, System, Universal, linkages, simulate
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


def test_a_run_that_ends_at_a_singular_pose_names_what_could_move():
    """A cross in Bricard's line-symmetric loop, its axis turned by 1e-9, where two branches all but meet."""
    loop = linkages.bricard_line((0.3, 0.5, 0.4), (1.0, 1.3, 0.7), (0.1, -0.05, 0.08), 0.6)
    joints, start = list(loop.joints), loop.assemble(rates={"hinge 1": 3.0})
    old = joints[1]
    across = np.cross(old.axis, (1, 0, 0))
    across /= np.linalg.norm(across)
    axis = old.axis + 1e-9 * np.cross(old.axis, across)
    joints[1] = Universal(old.a, old.b, at=old.at, axis_a=across, axis_b=axis, name=old.name)
    with pytest.raises(
        IntegrationError, match="the step size fell below its limit: the pose is nearly singular: 'hinge"
    ):
        simulate(System(loop.bodies, joints), 0.7, state=start, output=3)
