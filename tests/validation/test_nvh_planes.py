"""What a plane can say: verdicts follow from what is measured."""

import pytest
from click.testing import CliRunner

from validation.nvh.cli import nvh
from validation.nvh.held import mounts
from validation.nvh.planes import EXACT, NEAR, NEVER, Planes, verdict


@pytest.fixture(scope="module")
def planes():
    return Planes(mounts.car("saloon"))


def test_cylinders_in_planes_of_their_own_are_summed_exactly(planes):
    for line in (planes.block(), planes.bearings()):
        assert line.verdict == EXACT and float(line.size) < 1e-10
        assert 0 < line.plane and 0 < line.space


def test_a_plane_has_no_couple_and_no_gyroscopic_term(planes):
    assert [line.verdict for line in (planes.couple(), planes.roll(), planes.spin())] == 3 * [NEVER]
    assert float(planes.couple().size.split()[0]) > 100.0
    assert float(planes.roll().size.split()[0]) > 0.5


def test_modes_across_the_crank_are_near():
    line = Planes(mounts.car("bench")).modes()
    assert line.verdict == NEAR and float(line.size.split("%")[0]) < 20.0


def test_a_difference_decides_the_verdict():
    assert verdict(-1e-3) == NEAR and verdict(1e-7) == EXACT


@pytest.mark.slow
def test_the_table_of_the_command():
    found = CliRunner().invoke(nvh, ["--planes", "--car", "saloon"])
    assert found.exit_code == 0, found.output
    assert all(word in found.output for word in (EXACT, NEAR, NEVER, "bump steer", "quarter car"))
