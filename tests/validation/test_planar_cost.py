"""Planar mechanisms in the plane and in space: the same motion and forces, and a complete table of what they cost."""

import json
import re
import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner

from engines import planar
from mbsd3d import Kinematic, simulate
from validation.benchmark import planar_cost as tax
from validation.benchmark import planar_pairs as noise
from validation.benchmark.planar_pairs import Floor, mechanisms

MECHANISMS = {m.name: m for m in mechanisms()}
STEPS = 2000  # a turn of RK4, closed at each: errors of 8e-9 at 304 steps fall to 4e-12


@pytest.fixture(params=MECHANISMS.values(), ids=MECHANISMS)
def mechanism(request):
    return request.param


@pytest.mark.parametrize("options", [{}, {"redundant": True}, {"centroidal": True}], ids=str)
def test_space_and_plane_move_alike(mechanism, options):
    flat = planar.simulate(mechanism.plane(), mechanism.turn, dt=mechanism.turn / STEPS, output=5)
    deep = simulate(mechanism.space(**options), mechanism.turn, rtol=1e-12, output=5)
    limit = deep.record.steps * 1e-12  # m: a step adds at most its tolerance, of lengths below 1; RK4 is better
    for link in mechanism.links:
        off = deep.com(link.name) - np.pad(flat.com(link.name), ((0, 0), (0, 1)), constant_values=link.centre[2])
        assert np.abs(off).max() < limit
        assert np.abs(deep.omega(link.name)[:, 2] - flat.omega(link.name)).max() < limit * mechanism.rate


@pytest.mark.parametrize("centroidal", [False, True])
def test_driven_forces_are_the_same(mechanism, centroidal):
    """Kinematics has no error of integration: rounding times the condition of the joints."""
    times = mechanism.turn * np.arange(13) / 12
    flat = planar.kinematics(mechanism.plane(driven=True, centroidal=centroidal), times)
    system = mechanism.space(driven=True, centroidal=centroidal)
    deep = simulate(system, mechanism.turn, method=Kinematic(), output=13)
    size = max(np.abs(flat.reaction(c.name).force).max() for c in mechanism.couplings)
    for c in mechanism.couplings:
        off = deep.reaction(c.name).force[:, :2] - flat.reaction(c.name).force
        assert np.abs(off).max() < 1e-12 * size
    assert np.abs(deep.effort("motor") - flat.effort("motor")).max() < 1e-12 * size


def test_redundant_rows_are_there_and_gone(mechanism):
    """Every loop closed by hinges repeats three rows; a ball and a cross instead repeat none."""
    loops = len(mechanism.couplings) - len(mechanism.links)
    for redundant, extra in ((False, 0), (True, 3 * loops)):
        found = mechanism.space(redundant=redundant).check()
        assert (found.mobility, found.rows - found.rank) == (1, extra)


def test_floors_are_rounding():
    """Some ten forces cancel: a few times 2e-16; and each sum is of numbers that are not zero themselves."""
    floors = noise.noise_floors()
    assert [(row.mechanism, row.what) for row in floors[:3]] == [
        ("slider-crank", "Newton for the whole"),
        ("slider-crank", "force out of the plane"),
        ("slider-crank", "drift out of the plane"),
    ]
    assert len(floors) == 3 * len(MECHANISMS) + 2
    for row in floors:
        assert max(row.space, row.redundant, row.plane or 0.0) < 1e-13, row


def test_an_imbalance_is_seen():
    """One piston of the inline four a thousandth too heavy: the 1x force is that of the surplus, 5 g R w^2."""
    four = MECHANISMS["inline four"]
    links = [
        link if link.name != "piston 2" else link.__class__(**{**vars(link), "mass": 5.005}) for link in four.links
    ]
    lopsided = four.__class__(**{**vars(four), "links": tuple(links)})
    for run in noise.cycle(lopsided):
        assert noise.balanced(lopsided, run)[0] == pytest.approx(0.005 / 10.0, rel=1e-6)
        assert noise.imbalance(four, run) > 1e-5  # with the masses as they should be, Newton is violated


@pytest.fixture(scope="module")
def small():
    """One mechanism in one round: not accurate, but complete; the sweep, which starts processes, is made up."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(tax, "mechanisms", lambda: [MECHANISMS["slider-crank"]])
        patch.setattr(tax, "noise_floors", lambda: [Floor("slider-crank", "Newton for the whole", 1e-16, 2e-16, 3e-16)])
        patch.setattr(tax, "design_sweep", lambda cells: {"cells": 4, "failed": 0, "seconds": 2.0, "processor": 3.0})
        return tax.measure(rounds=1)


def complete(found, names):
    """Whether every mechanism has its rows, in the numbers and in the text."""
    for mechanism in names:
        assert [row.form for row in found.costs if row.mechanism == mechanism] == list(tax.FORMS)
        settings = [row.setting.split(",")[0] for row in found.accuracies if row.mechanism == mechanism]
        assert settings == ["RK4", "RK4", "DOP853"]
    assert all(0.0 < row.error <= tax.POSITION_ERROR_MAX for row in found.accuracies)
    assert found.sweep["cells"] == 4 and found.sweep["failed"] == 0 < found.sweep["seconds"]
    text = "\n".join(tax.lines(found))
    for row in (*found.costs, *found.accuracies, *found.floors):
        assert any(line.startswith(f"{row.mechanism:14}{row[1]}") for line in text.splitlines()), row


def test_the_table_is_complete(small):
    complete(small, ["slider-crank"])


@pytest.mark.slow
def test_the_table_of_all_mechanisms_is_complete():
    complete(tax.measure(rounds=1, cells=2), MECHANISMS)


def test_verdicts_follow_the_numbers(small):
    """Also of a ratio above the goal."""
    for ratio, words in ((0.9 * tax.RATIO_GOAL, "met"), (1.1 * tax.RATIO_GOAL, "MISSED")):
        given = small._replace(costs=[row._replace(ratio=ratio) for row in small.costs])
        (what, value, goal, met), floor, seconds = tax.verdicts(given)
        assert (value, goal, met) == (ratio, tax.RATIO_GOAL, words == "met") and floor[-1]
        assert seconds[1] == small.sweep["seconds"]
        assert re.search(rf"{what} .* {words}$", "\n".join(tax.lines(given)), re.MULTILINE)


def test_command_line_gives_json(small, monkeypatch):
    monkeypatch.setattr(tax, "measure", lambda rounds: small)
    result = CliRunner().invoke(tax.main, ["--json", "--rounds", "3"])
    data = json.loads(result.output)
    assert result.exit_code == 0 and len(data["costs"]) == len(small.costs)
    assert data["verdicts"][0]["goal"] == tax.RATIO_GOAL and data["sweep"] == small.sweep


@pytest.mark.slow
def test_runs_without_the_engines_it_does_not_measure():
    """In a process of its own: nothing of MuJoCo is imported, not even by the line about the machine."""
    code = (
        "import sys; sys.modules['mujoco'] = None; from validation.benchmark import planar_cost as tax; "
        "print(tax.machine('numpy', 'no-such-engine')); assert 'validation.benchmark.candidates' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert f"numpy {np.__version__}, no-such-engine absent" in done.stdout
