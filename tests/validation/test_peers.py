"""Rows, rank and freedoms against Exudyn's count and the files; the large N-four-bar."""

import numpy as np
import pytest

from mbsd3d import GROUND, Body, CustomForce, Revolute, System
from validation import cases
from validation.benchmark import counts as peers
from validation.cases import mechanisms


@pytest.fixture(scope="module")
def counts():
    return peers.redundancy(windows=(2,))


def test_every_case_has_the_rank_and_freedoms_that_exudyn_and_its_file_count(counts):
    assert {row.name for row in counts} >= set(cases.names())
    assert [row.name for row in counts if not row.agree] == []


def test_the_count_sees_redundant_rows(counts):
    redundant = {row.name: row.exudyn.redundant for row in counts if row.exudyn.redundant}
    assert redundant["iftomm_A03_andrews"] == 9 and redundant["door_two_hinges"] == 5 and len(redundant) >= 6


def test_a_count_that_differs_is_said():
    count = peers.Count(10, 5, 1, 5)
    row = peers.Counts("door", count, peers.Count(10, 6, 1, 4), count)
    assert not row.agree and "DIFFERS" in peers.table([row])[1]


def test_what_exudyn_cannot_express_is_not_agreement():
    def pull(t, bodies, z, parameters, loads, z_dot):
        loads[0, :3] = parameters[0]

    arm = Body("arm", 1.2, (0.02, 0.1, 0.11), com=(0.4, 0.1, 0.03))
    hinge = Revolute(GROUND, arm, at=(0, 0, 0), axis=(1, 2, 3), name="hinge")
    force = CustomForce(pull, on=(arm,), parameters=(1.0,), name="pull")
    said = peers.counted_by_exudyn(System([arm], [hinge], [force]))
    assert said.startswith("not compared") and "pull" in said
    assert not peers.Counts("arm", peers.Count(5, 5, 1, 0), said, None).agree


def test_four_bars_of_two_windows_are_the_reference_case():
    ours, case = mechanisms.four_bars(2), cases.load("iftomm_A02_fourbar_N2").system
    for a, b in zip(ours.bodies, case.bodies, strict=True):
        assert a.name == b.name and a.mass == b.mass and np.allclose(a.inertia, b.inertia, rtol=1e-15, atol=0)
    assert np.allclose(ours.state().q, case.state().q, rtol=0, atol=1e-15)
    assert np.allclose(ours.state().v, case.state().v, rtol=0, atol=1e-15)
    assert [joint.name for joint in ours.joints] == [joint.name for joint in case.joints]


@pytest.mark.slow
def test_forty_windows_are_counted_and_run():
    found = peers.large()
    assert (found.rows, found.rank) == (605, 485)
    assert found.error < 1e-3  # ten times rtol for ten singular positions; Exudyn ends 500 steps at 8e-2


@pytest.mark.timing
def test_forty_windows_take_seconds_where_a_peer_takes_minutes():
    found = peers.large()
    # measured: 0.8 s altogether against minutes; a tenth leaves room for a busy moment
    assert found.check_seconds + found.run_seconds < peers.EXUDYN_STEPS * peers.step_seconds() / 10
