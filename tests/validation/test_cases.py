"""All reference cases through the public interface, with the reference points at the centres of mass and off them."""

import numpy as np
import pytest
from helpers.conditions import measure_condition
from helpers.page_limits import limits

from mbsd3d import accelerations, simulate
from mbsd3d.extend import matrix
from validation.cases import reference as cases
from validation.cases.comparison import compare, condition
from validation.cases.robot import hinge_accelerations, robot_poses
from validation.suite.trials.references import ROUNDING_BY_CASE, RTOL_BY_CASE, allowed
from validation.suite.trials.trial import RTOL

TIMED = cases.names(timed=True)

SHIFTS = [None, 7]


@pytest.mark.parametrize("shift", SHIFTS)
@pytest.mark.parametrize("name", TIMED)
def test_case_reaches_its_reference(name, shift):
    case = cases.load(name, shift)
    rtol = RTOL_BY_CASE.get(name, RTOL)
    comparison = compare(case, simulate(case.system, case.t_end, rtol=rtol, output=case.times))
    assert comparison.left_out == ()
    assert comparison.scaled_error <= allowed(case, rtol)
    promised = limits("validation.md", "reference cases")[name in ROUNDING_BY_CASE]
    assert comparison.scaled_error <= promised * rtol / RTOL


@pytest.mark.parametrize("shift", SHIFTS)
@pytest.mark.parametrize("name", [name for name in cases.names() if cases.read(name).get("dof_info")])
def test_case_has_the_known_mobility(name, shift):
    case = cases.load(name, shift)
    found, known = case.system.check(), case.dof_info
    assert (found.rows, found.rank) == (known["rows"], known["rank"])
    assert found.redundant == known["redundant"]
    assert found.velocity_freedom == known["dof"]


def test_every_case_file_is_listed():
    assert len(cases.names()) == 24
    assert len(TIMED) == 20
    assert set(cases.names()) - set(TIMED) == {
        "bicycle_eigenvalues",
        "eig_fourbar2_hanging",
        "eig_hanging_pendulum",
        "robot6r_inverse_dynamics",
    }


@pytest.mark.parametrize("name", cases.names())
def test_a_shift_moves_the_reference_point_and_not_the_body(name):
    plain, moved = cases.load(name).system, cases.load(name, 7).system
    for a, b in zip(plain.bodies, moved.bodies, strict=True):
        rotation = cases._rotation(b.orientation)
        arm = rotation @ np.asarray(b.com)
        # of the size of the body, so the terms with r_G are not small
        assert np.linalg.norm(arm) > 0.02 * cases._size(cases.read(name), {"name": a.name, **_start(name, a.name)})
        assert np.allclose(b.position + arm, a.position, rtol=0, atol=1e-14)
        assert np.allclose(b.velocity + np.cross(b.omega, arm), a.velocity, rtol=0, atol=1e-12)


def _start(name, body):
    return next(spec for spec in cases.read(name)["bodies"] if spec["name"] == body)


def test_shift_by_name_and_errors():
    case = cases.load("iftomm_rscr_slidercrank", {"rod": (0.1, -0.2, 0.3)})
    shifts = {body.name: np.linalg.norm(body.com) for body in case.system.bodies}
    assert shifts == pytest.approx({"crank": 0.0, "rod": np.sqrt(0.14), "slider": 0.0}, abs=1e-15)
    with pytest.raises(ValueError, match="no such body"):
        cases.load("iftomm_rscr_slidercrank", {"wheel": (0, 0, 1)})
    with pytest.raises(ValueError, match="choose one of"):
        cases.load("engine")
    with pytest.raises(ValueError, match="unknown"):
        cases.build({**cases.read("heavy_top_fast"), "joints": [{"type": "magnet"}]})


@pytest.mark.parametrize("shift", SHIFTS)
@pytest.mark.parametrize("pose", range(4))
def test_robot_accelerates_as_its_torques_say(pose, shift):
    known = robot_poses(shift)[pose]
    state = known.system.assemble(angles=known.angles, rates=known.rates)
    for system, expected in ((known.system, known.accelerations), (known.free, known.free_accelerations)):
        solution = accelerations(system, state)
        found = hinge_accelerations(solution)[0]
        # the arm's mass matrix has a condition of 1e5; accelerations up to 50 rad/s^2
        assert np.abs(found - expected).max() < 1e-8
        raw = cases.read("robot6r_inverse_dynamics")
        link, at = raw["bodies"][-1], raw["outputs"][0]["p"]
        arm = matrix(np.array(link["q0"])).T @ np.subtract(at, link["r0"])
        tool = solution.com("link6")[0] + solution.rotation("link6")[0] @ arm
        assert np.abs(tool - raw["reference"]["values"][pose]["ee_position"]).max() < 1e-12


def test_a_stored_condition_is_the_measured_one():
    case = cases.load("coriolis_slider")
    # the greatest of five seeded changes, rounded to the digits of the file
    assert measure_condition(case) == pytest.approx(condition("coriolis_slider"), rel=0.05)
