"""Large mechanisms: ranks against dense analysis, work and time that grow with the number of bodies, memory of a run."""

import os
import subprocess
import sys
import time
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from models import (
    Evaluation,
    all_joints_mechanism,
    four_bar_ladder,
    random_body,
    random_loops,
    revolute_chain,
)
from scipy.sparse import csr_array, eye_array

from mbsd3d import GROUND, RK4, Body, PointOnLine, Revolute, State, System, Universal, rotation, samples, simulate
from mbsd3d.assembly import reference_pose
from mbsd3d.elimination import Elimination
from mbsd3d.evaluation import load_state
from mbsd3d.least import least
from mbsd3d.model import compile_system
from mbsd3d.plain import mass_matrix
from mbsd3d.rank import Analysis, redundant_combinations
from mbsd3d.rotations import conjugate, logarithm, matrix, multiply
from mbsd3d.samples import QUANTITIES, Samples
from mbsd3d.selection import choose_rows, dense_jacobian, independent_rows, scaled_jacobian, scaled_rows
from validation import cases

HERE = Path(__file__).parent
ROUNDING = 1e-11  # of rows of order one, times what an elimination with pivots down to 1e-3 may make of it


def at_reference(system):
    """(compiled, data) with the rows of the reference pose."""
    compiled = compile_system(system)
    data = compiled.data()
    load_state(compiled, data, reference_pose(system))
    return compiled, data


def dense(compiled, data):
    """The whole scaled J."""
    return scaled_jacobian(compiled.model, dense_jacobian(compiled.model, data))


def check_against_dense(system, core_rows):
    """Rank, independent rows, redundant combinations and free motions against one SVD of the whole J."""
    compiled, data = at_reference(system)
    A = dense(compiled, data)
    rank = independent_rows(A)[0].size
    found = Analysis(scaled_rows(compiled.model, data), core_rows=core_rows)
    assert found.rank == rank
    chosen, N = found.independent(), found.redundant()
    assert independent_rows(A[chosen])[0].size == chosen.size == rank
    assert N.shape == (A.shape[0], A.shape[0] - rank)
    assert np.abs(A.T @ N).max(initial=0.0) < ROUNDING
    assert np.linalg.matrix_rank(N) == N.shape[1] if N.size else True
    x = found.free_motion(np.random.default_rng(0))
    assert np.abs(A @ x).max(initial=0.0) < ROUNDING * max(np.abs(x).max(), 1.0)
    assert np.abs(x).max() > 1e-3 or rank == A.shape[1]  # normal numbers times unit motions
    return found


@pytest.mark.parametrize("core_rows", [64, 0])
@pytest.mark.parametrize("name", [name for name in cases.names() if cases.read(name)["joints"]])
def test_rank_of_every_case_is_that_of_the_whole_jacobian(name, core_rows):
    check_against_dense(cases.load(name, 7).system, core_rows)


@pytest.mark.parametrize("core_rows", [64, 0])
@pytest.mark.parametrize("seed", range(8))
def test_rank_of_random_loops_is_that_of_the_whole_jacobian(seed, core_rows):
    found = check_against_dense(random_loops(seed), core_rows)
    assert found.rank < found.m  # the doubled hinges


@pytest.mark.parametrize("seed", range(3))
def test_rank_of_the_mechanism_with_all_joints(seed):
    check_against_dense(all_joints_mechanism(seed), 0)


@pytest.mark.parametrize("lean", [0.4, 0.0])
def test_rank_of_a_ladder_away_from_and_at_its_change_point(lean):
    """2 n + 1 bodies in a plane: one freedom; laid flat a second one (Whittaker), so that the rank is one less."""
    system = four_bar_ladder(30, lean=np.pi / 2 if lean == 0.0 else lean)
    found = check_against_dense(system, 64)
    freedoms = 6 * len(system.bodies) - found.rank
    assert freedoms == (1 if lean else independent_freedoms_of_a_flat_ladder(30))


def independent_freedoms_of_a_flat_ladder(n):
    """All rods along one line: across it the n + 1 rods turn freely if couplers follow; closing them is first order.

    Heads move across the line by w_k l only; couplers of length d between heads k, k + 1 turn to follow. So no rod
    feels another one: n + 1 freedoms.
    """
    return n + 1


@pytest.mark.parametrize("offset", [1e-2, 1e-4, 1e-6, 1e-8])
def test_nearly_redundant_rows_are_left_to_the_singular_values(offset):
    """Two hinges on one leaf, out of line by an offset: the smallest singular value is proportional to it."""
    rng = np.random.default_rng(3)
    leaf = random_body(rng, "leaf")
    axis = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])
    across = np.array([0.5, 0.3, 0.0]) / np.linalg.norm([0.5, 0.3])
    hinges = [Revolute(GROUND, leaf, at=x, axis=axis) for x in (0.1 * axis, 1.3 * axis + offset * across)]
    compiled, data = at_reference(System(bodies=[leaf], joints=hinges))
    rows = scaled_rows(compiled.model, data)
    smallest = scipy.linalg.svdvals(dense(compiled, data))[5]
    found = Analysis(rows, core_rows=0)
    assert found.rank == 6
    if offset < 1e-3:  # below the pivots that are decided without singular values
        assert 0.1 < found.least / smallest < 10.0  # an elimination with good pivots keeps the order of magnitude


def test_universal_joint_at_its_gimbal_lock_loses_a_row():
    body = Body("shaft", 1.2, (0.1, 0.2, 0.25), com=(0.1, 0.02, 0.03), position=(0.3, -0.2, 0.4))
    cross = Universal(GROUND, body, at=(0.1, 0.2, 0.3), axis_a=(1, 2, 2), axis_b=(2, 1, -2))
    system = System(bodies=[body], joints=[cross])
    compiled, data = at_reference(system)
    quarter = multiply(rotation(np.cross(cross.axis_a, cross.axis_b), -np.pi / 2), body.orientation)
    r = np.array(cross.at) + matrix(quarter) @ matrix(body.orientation).T @ (body.position - cross.at)
    load_state(compiled, data, State(0.0, np.concatenate([r, quarter]), np.zeros(6)))
    for core_rows in (64, 0):
        found = Analysis(scaled_rows(compiled.model, data), core_rows=core_rows)
        assert (found.rank, found.redundant().shape) == (3, (4, 1))


def work(system):
    """Numbers computed by the elimination and by the factorisation of the chosen rows."""
    compiled, data = at_reference(system)
    left = Elimination(scaled_rows(compiled.model, data), 1e-10)
    schur, _ = choose_rows(compiled.model, data)
    return sum(step.F.size * (1 + step.rest.size) for step in left.steps), schur.skyline.size


@pytest.mark.parametrize("build", [revolute_chain, four_bar_ladder])
def test_work_of_choosing_rows_is_proportional_to_the_number_of_bodies(build):
    small, large = work(build(80)), work(build(320))
    for few, many in zip(small, large, strict=True):
        assert np.log(many / few) / np.log(4.0) < 1.1  # 1, and the constant number of rows in the core


def seconds(call, repeats=3):
    """Shortest of a few times."""
    times = []
    for _ in range(repeats):
        began = time.perf_counter()
        call()
        times.append(time.perf_counter() - began)
    return min(times)


@pytest.mark.parametrize("build", [revolute_chain, four_bar_ladder])
def test_time_before_the_first_step_grows_in_proportion(build):
    """Four times the bodies: 4 for linear growth, 16 for quadratic; 8 leaves room for a busy machine."""
    spent = []
    for n in (100, 400):
        system = build(n)
        compiled, data = at_reference(system)
        parts = (lambda s=system: compile_system(s), lambda c=compiled, d=data: choose_rows(c.model, d), system.state)
        spent.append([seconds(part) for part in parts])
    assert (np.divide(*spent[::-1]) < 8.0).all()


def test_check_of_a_chain_and_of_a_ladder():
    chain, ladder = revolute_chain(150).check(), four_bar_ladder(25).check()
    assert (chain.rank, chain.rows, chain.mobility) == (750, 750, 150)
    assert chain.neighbour_ranks == (750, 750)
    assert (ladder.rank, ladder.redundant, ladder.mobility) == (305, 75, 1)
    assert len(ladder.shares) == 76
    assert not any(share.force_unique and share.moment_unique for share in ladder.shares)


def test_cure_of_a_ladder_is_found_and_cures():
    """One hinge per loop becomes a point on a line: 2 of 5 rows."""
    n = 15
    system = four_bar_ladder(n)
    (cure,) = system.check().cures
    assert cure.rows_removed == 3 * n
    weaker = dict(cure.replacements)
    assert set(weaker.values()) == {"PointOnLine"}
    joints = [PointOnLine(j.a, j.b, at=j.at, axis=j.axis) if system.name(j) in weaker else j for j in system.joints]
    cured = System(bodies=system.bodies, joints=joints)
    A = dense(*at_reference(cured))
    assert independent_rows(A)[0].size == len(A) == 6 * len(system.bodies) - 1


def test_a_ladder_assembles_as_parallelograms_do():
    """All rods turn by the angle of the first, no coupler turns."""
    n, angle = 20, 0.35
    system = four_bar_ladder(n)
    state = system.assemble(angles={"foot 0": angle})
    for body, pose in zip(system.bodies, state.q.reshape(-1, 7), strict=True):
        turned = logarithm(multiply(pose[3:], conjugate(body.orientation)))
        expected = angle * system.joints[0].axis if body.name.startswith("rod") else np.zeros(3)
        np.testing.assert_allclose(turned, expected, atol=1e-12)  # rounding, times a condition of about 100


@pytest.mark.parametrize("seed", range(4))
def test_start_velocities_have_least_energy(seed):
    """min v'M v / 2 with J v = b and given velocities, against null spaces by a dense SVD."""
    system = all_joints_mechanism(seed)
    pose = State(0.0, reference_pose(system).q, np.zeros(6 * len(system.bodies)))
    q, zero = Evaluation(system).reference()
    _, J, b, _ = Evaluation(system).rows(q, zero, 0.0)
    M = mass_matrix(system, pose)
    particular = np.linalg.lstsq(J, b, rcond=1e-11)[0]
    Z = scipy.linalg.null_space(J, rcond=1e-11)
    expected = particular - Z @ np.linalg.solve(Z.T @ M @ Z, Z.T @ M @ particular)
    found = system.state().v
    np.testing.assert_allclose(found, expected, atol=1e-9 * max(1.0, np.abs(expected).max()))  # condition of Z'MZ 1e4
    assert np.abs(J @ found - b).max() < 1e-12


def test_contradicting_rows_are_met_in_the_sense_of_least_squares():
    rng = np.random.default_rng(5)
    A = rng.normal(size=(9, 6))
    A[7:] = A[:2] + A[3]
    b = rng.normal(size=9)
    x = least(eye_array(6), csr_array(A), b)
    np.testing.assert_allclose(x, np.linalg.lstsq(A, b)[0], atol=1e-10)  # damping 1e-14 over the smallest pivot squared


def test_redundant_combinations_are_orthonormal():
    compiled, data = at_reference(four_bar_ladder(12))
    N = redundant_combinations(scaled_rows(compiled.model, data))
    np.testing.assert_allclose(N.T @ N, np.eye(36), atol=1e-13)
    assert np.abs(dense(compiled, data).T @ N).max() < ROUNDING


def test_reactions_of_a_ladder_are_told_apart():
    system = four_bar_ladder(16)
    solution = simulate(system, 0.05, output=3)
    feet = [solution.reaction(f"foot {k}") for k in (0, 9)]
    assert not any(foot.unique for foot in feet)
    assert solution.certificate.passed, solution.certificate.failures
    assert solution.record.svd_calls == 1


@pytest.mark.parametrize("expected", [0, 5, 64])
def test_samples_are_kept_whatever_their_number(expected):
    rng = np.random.default_rng(1)
    widths = (1, 5, 12, 3, 0, 2, 2, 2)
    rows = rng.normal(size=(64, sum(widths)))
    taken = Samples(widths, expected)
    for part in np.split(rows, [1, 1, 9, 40]):
        taken.take(part)
    arrays = taken.finished()
    assert tuple(arrays) == QUANTITIES
    np.testing.assert_array_equal(np.concatenate(list(arrays.values()), axis=1), rows)
    assert all(array.flags.c_contiguous for array in arrays.values())


def test_a_small_buffer_gives_the_same_samples(monkeypatch):
    system, method = revolute_chain(3), RK4(0.01)
    whole = [simulate(system, 0.5, method=method, output=output) for output in (190, None)]
    monkeypatch.setattr(samples, "BUFFER", 1)
    monkeypatch.setattr(samples, "FEWEST", 2)
    for first, output in zip(whole, (190, None), strict=True):
        again = simulate(system, 0.5, method=method, output=output)
        for name, array in first.arrays.items():
            np.testing.assert_array_equal(again.arrays[name], array)


def test_a_run_holds_its_samples_once(monkeypatch):
    """Peak of what is allocated, certificate included, against what is stored."""
    monkeypatch.setattr(samples, "BUFFER", 2**16)
    system = revolute_chain(100)
    state = system.state()
    simulate(system, 0.004, state=state, method=RK4(0.001))
    tracemalloc.start()
    solution = simulate(system, 0.4, state=state, method=RK4(0.001), output=401)
    assert solution.certificate.passed
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    stored = sum(array.nbytes for name, array in solution.arrays.items() if name not in ("q", "z"))  # views
    assert stored > 9e6
    assert peak < 1.6 * stored + 4e6  # a tenth for each temporary of one quantity; model and work space 4 MB


@pytest.mark.slow
def test_check_of_a_thousand_bodies_and_of_a_hundred_loops():
    assert seconds(revolute_chain(1000).check, 1) < 10.0
    assert seconds(four_bar_ladder(100).check, 1) < 10.0


@pytest.mark.slow
def test_five_thousand_bodies_run():
    system = revolute_chain(5000)
    solution = simulate(system, 0.004, method=RK4(0.001), output=5)
    assert solution.certificate.passed, solution.certificate.failures


@pytest.mark.slow
def test_a_thousand_bodies_a_thousand_samples_in_400_megabytes():
    script = """if True:
        import resource
        from models import revolute_chain
        from mbsd3d import RK4, simulate
        def peak():
            return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        simulate(revolute_chain(3), 0.01, method=RK4(0.001)).certificate
        system = revolute_chain(1000)
        before = peak()
        solution = simulate(system, 0.999, method=RK4(0.001), output=1000)
        assert solution.certificate.passed, solution.certificate.failures
        print(peak() - before)
    """
    command = [sys.executable, "-c", script]
    path = {"PYTHONPATH": f"{HERE}:{HERE.parent}"}
    found = subprocess.run(command, env={**os.environ, **path}, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr[-2000:]
    assert float(found.stdout) < 400.0
