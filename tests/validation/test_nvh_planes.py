"""What a plane can say: verdicts follow from what is measured."""

import re

import pytest
from click.testing import CliRunner
from said import DOCS

from validation.nvh.cli import nvh
from validation.nvh.held import mounts
from validation.nvh.planes import EXACT, NEAR, NEVER, Planes, verdict

VERDICT = re.compile(rf"[ |](?:{EXACT}|{NEAR}|{NEVER})  ?")


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
def test_the_table_of_the_command_is_that_of_the_page():
    run = CliRunner().invoke(nvh, ["--planes"])
    assert run.exit_code == 0, run.output
    said = [re.split(r"\s{2,}", line) for line in run.stdout.splitlines() if VERDICT.search(line)]
    page = (DOCS / "engines.md").read_text(encoding="utf-8")
    shown = [[cell.strip() for cell in line.split("|")[1:-1]] for line in page.splitlines() if VERDICT.search(line)]
    assert [line[1] for line in shown] == [line[1] for line in said] and len(shown) == 10
    for ours, theirs in zip(shown, said, strict=True):
        number, found = (abs(float(re.search(r"[\d.]+(e-\d+)?", line[2])[0])) for line in (ours, theirs))
        if ours[1] == EXACT:  # nothing, of the size of rounding or of the run's tolerance
            assert found < 10 * max(number, 1e-13), ours
        else:
            assert found == pytest.approx(number, rel=0.06), ours  # two digits
