"""Rows, rank and freedoms against Exudyn's count and the files; the large N-four-bar."""

import numpy as np
import pytest

from mbsd3d import GROUND, Body, CustomForce, Revolute, System
from validation import cases
from validation.benchmark.problems import four_bar_poses, poses, whole
from validation.cases import mechanisms
from validation.suite.findings import AGREES, NOT_COMPARED
from validation.suite.trials.references import Count, counted_by_exudyn, counts, freedoms, standing


def test_every_case_has_the_rank_and_freedoms_that_exudyn_and_its_file_count():
    redundant = {}
    for name in cases.names():
        case = standing(name)
        of_file, of_exudyn = freedoms(case)
        assert of_exudyn.verdict == AGREES, f"{name}: {of_exudyn.note}"
        assert of_file.verdict == (AGREES if case.source.dof_info else NOT_COMPARED), f"{name}: {of_file.note}"
        redundant[name] = counted_by_exudyn(case.system).redundant
    assert redundant["iftomm_A03_andrews"] == 9 and redundant["door_two_hinges"] == 5
    assert sum(count > 0 for count in redundant.values()) >= 6


def test_a_count_that_differs_is_said():
    (found,) = counts(standing("door_two_hinges"), {"who": Count(10, 6, 1, 4)})
    assert found.verdict == "differs" and found.error == 2 and "; ours 10, 5, 1, 5" in found.note


def test_what_exudyn_cannot_express_is_not_agreement():
    def pull(t, bodies, z, parameters, loads, z_dot):
        loads[0, :3] = parameters[0]

    arm = Body("arm", 1.2, (0.02, 0.1, 0.11), com=(0.4, 0.1, 0.03))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(1, 2, 3), name="hinge")
    force = CustomForce(pull, on=(arm,), parameters=(1.0,), name="pull")
    said = counted_by_exudyn(System([arm], [hinge], [force]))
    assert isinstance(said, str) and "pull" in said


def test_four_bars_of_two_windows_are_the_reference_case():
    ours, case = mechanisms.four_bars(2), cases.load("iftomm_A02_fourbar_N2").system
    for a, b in zip(ours.bodies, case.bodies, strict=True):
        assert a.name == b.name and a.mass == b.mass and np.allclose(a.inertia, b.inertia, rtol=1e-15, atol=0)
    assert np.allclose(ours.state().q, case.state().q, rtol=0, atol=1e-15)
    assert np.allclose(ours.state().v, case.state().v, rtol=0, atol=1e-15)
    assert [joint.name for joint in ours.joints] == [joint.name for joint in case.joints]


@pytest.mark.slow
def test_forty_windows_are_counted_and_run():
    system = mechanisms.four_bars(40)
    found = system.check()
    assert (found.rows, found.rank) == (605, 485)
    error = poses(whole(system, 10.0, rtol=1e-4)).distance(four_bar_poses(40, 10.0), 1.0)
    assert error < 1e-3  # ten times rtol for ten singular positions; Exudyn ends 500 steps at 8e-2
