"""Rank, null spaces and least squares of sparse rows against dense analysis of the whole Jacobian."""

from itertools import pairwise

import numpy as np
import pytest
import scipy.linalg
from helpers.models import (
    Evaluation,
    all_joints_mechanism,
    at_reference,
    dense_rows,
    direction,
    middle,
    random_body,
    random_loops,
)
from numpy.linalg import matrix_rank
from scipy.sparse import csr_array

from mbsd3d import GROUND, Body, Distance, Fixed, Gear, Revolute, Spherical, State, System, Universal, rotation
from mbsd3d.constraints.assembly import reference_pose
from mbsd3d.constraints.least_squares import least
from mbsd3d.constraints.rank import Analysis, redundant_combinations, surely_independent
from mbsd3d.equations.jacobian import BlockRows, scaled_rows
from mbsd3d.extend import load_state, mass_matrix
from mbsd3d.rotations import matrix, multiply
from validation import cases
from validation.cases.mechanisms import ladder

RANK_RTOL = 1e-10  # [1] between the rounding of dependent rows, 1e-13, and the least independent ones

ROUNDING = 1e-11  # of rows of order one, times what an elimination with pivots down to 1e-3 may make of it


def check_against_dense(system, core_rows):
    """Rank, independent rows, redundant combinations and free motions against one SVD of the whole J."""
    compiled, data = at_reference(system)
    A = dense_rows(compiled, data)
    rank = matrix_rank(A, rtol=RANK_RTOL)
    found = Analysis(scaled_rows(compiled.model, data), core_rows=core_rows)
    assert found.rank == rank
    chosen, N = found.independent(), found.redundant()
    assert matrix_rank(A[chosen], rtol=RANK_RTOL) == chosen.size == rank
    assert N.shape == (A.shape[0], A.shape[0] - rank)
    assert np.abs(A.T @ N).max(initial=0.0) < ROUNDING
    assert matrix_rank(N) == N.shape[1] if N.size else True
    x = found.free_motion(np.random.default_rng(0))
    assert np.abs(A @ x).max(initial=0.0) < ROUNDING * max(np.abs(x).max(), 1.0)
    assert np.abs(x).max() > 1e-3 or rank == A.shape[1]  # normal numbers times unit motions
    return found


@pytest.mark.parametrize("core_rows", [64, 0])
@pytest.mark.parametrize("name", [name for name in cases.names() if cases.read(name)["joints"]])
def test_rank_of_every_case_is_that_of_the_whole_jacobian(name, core_rows):
    check_against_dense(cases.load(name, 7).system, core_rows)


@pytest.mark.parametrize("core_rows", [64, 0])
@pytest.mark.parametrize("seed", range(4))
def test_rank_of_random_loops_is_that_of_the_whole_jacobian(seed, core_rows):
    found = check_against_dense(random_loops(seed), core_rows)
    assert found.rank < found.m  # the doubled hinges


def star(rng):
    """Thirty bodies on one carrier, neighbours tied by rods."""
    bodies = [random_body(rng, f"body {k}") for k in range(31)]
    hinges = [Revolute(bodies[0], b, at=middle(rng, bodies[0], b), axis=direction(rng)) for b in bodies[1:]]
    rods = [Distance(a, b, at_a=a.position + 0.2, at_b=b.position - 0.1) for a, b in pairwise(bodies[1:])]
    return System(
        bodies=bodies, joints=[Revolute(GROUND, bodies[0], at=(1, 2, 3), axis=direction(rng)), *hinges, *rods]
    )


def ring(rng):
    """One loop of forty hinges with general axes."""
    angles = 2 * np.pi * np.arange(40) / 40
    bodies = [random_body(rng, f"body {k}", position=(6 * np.cos(x), 6 * np.sin(x), 0.1)) for k, x in enumerate(angles)]
    hinges = [Revolute(a, b, at=middle(rng, a, b), axis=direction(rng)) for a, b in pairwise([*bodies, bodies[0]])]
    return System(bodies=bodies, joints=[Spherical(GROUND, bodies[0], at=bodies[0].position), *hinges])


def gear_train(rng):
    """Fifty wheels on hinges of the ground; each drives the next, the last one the first at a wrong ratio."""
    bodies = [random_body(rng, f"wheel {k}", position=(k, 0.1 * (k % 7), 0.3)) for k in range(50)]
    hinges = [Revolute(GROUND, b, at=b.position + 0.1, axis=direction(rng)) for b in bodies]
    gears = [Gear(a, b, ratio=-2.0 if k % 2 else -0.5) for k, (a, b) in enumerate(pairwise([*hinges, hinges[0]]))]
    return System(bodies=bodies, joints=[*hinges, *gears])


def lattice(rng):
    """Six by six bodies, neighbours joined by ball joints."""
    bodies = [[random_body(rng, f"{i}, {k}", position=(i, k, 0.2 * (i * k % 3))) for k in range(6)] for i in range(6)]
    pairs = [pair for line in (*bodies, *zip(*bodies, strict=True)) for pair in pairwise(line)]
    joints = [Spherical(a, b, at=middle(rng, a, b)) for a, b in pairs]
    return System(bodies=sum(bodies, []), joints=[Fixed(GROUND, bodies[0][0], at=(0, 0, 0)), *joints])


@pytest.mark.parametrize("core_rows", [64, 0])
@pytest.mark.parametrize("build", [star, ring, gear_train, lattice])
def test_rank_of_other_shapes(build, core_rows):
    check_against_dense(build(np.random.default_rng(1)), core_rows)


@pytest.mark.parametrize("seed", range(3))
def test_rank_of_the_mechanism_with_all_joints(seed):
    check_against_dense(all_joints_mechanism(seed), 0)


@pytest.mark.parametrize("lean", [0.4, 0.0])
def test_rank_of_a_ladder_away_from_and_at_its_change_point(lean):
    """2 n + 1 bodies in a plane: one degree of freedom; laid flat a second one (Whittaker), so the rank is one less."""
    system = ladder(30, lean=np.pi / 2 if lean == 0.0 else lean)
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
    smallest = scipy.linalg.svdvals(dense_rows(compiled, data))[5]
    found = Analysis(rows, core_rows=0)
    assert found.rank == 6
    if offset < 1e-3:  # below the pivots that are decided without singular values
        assert 0.1 < found.least / smallest < 10.0  # an elimination with good pivots keeps the order of magnitude


@pytest.mark.parametrize("least_value", [1.0, 1e-3, 1e-5, 1e-7, 1e-9, 0.0])
def test_independence_is_proven_where_it_is_certain_only(least_value):
    """Rows with known singular values: proven above 1e-6 times what Frobenius norms are larger by, a few."""
    rng = np.random.default_rng(11)
    U, V = (np.linalg.qr(rng.normal(size=(18, 18)))[0] for _ in range(2))
    J = (U * np.append(np.linspace(2.0, 0.5, 17), least_value)) @ V.T
    body = np.tile([0, 1, 2, -1], (18, 1))
    rows = BlockRows(body, np.concatenate([J.reshape(18, 3, 6), np.zeros((18, 1, 6))], axis=1), 3)
    assert surely_independent(rows, 1e-10) == (least_value > 1e-6)
    assert (Analysis(rows).rank == 18) == (least_value > 1e-10)
    assert not surely_independent(rows, 0.5)


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


def test_redundant_combinations_are_orthonormal():
    compiled, data = at_reference(ladder(12))
    N = redundant_combinations(scaled_rows(compiled.model, data))
    np.testing.assert_allclose(N.T @ N, np.eye(36), rtol=0, atol=1e-13)
    assert np.abs(dense_rows(compiled, data).T @ N).max() < ROUNDING


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
    # condition of Z'MZ 1e4
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-9 * max(1.0, np.abs(expected).max()))
    assert np.abs(J @ found - b).max() < 1e-12


@pytest.mark.parametrize("held", [csr_array, np.asarray])
def test_contradicting_rows_are_met_in_the_sense_of_least_squares(held):
    rng = np.random.default_rng(5)
    A = rng.normal(size=(9, 6))
    A[7:] = A[:2] + A[3]
    b = rng.normal(size=9)
    x = least(held(np.eye(6)), held(A), b)
    # damping 1e-14 over the smallest pivot squared
    np.testing.assert_allclose(x, np.linalg.lstsq(A, b)[0], rtol=0, atol=1e-10)


def test_rows_that_are_not_finite_are_refused():
    compiled, data = at_reference(ladder(2))
    data.row["J"][7, 1, 2] = np.nan
    with pytest.raises(ValueError, match="row 7 of the Jacobian is not finite"):
        Analysis(scaled_rows(compiled.model, data))


def test_no_rows_leave_everything_free():
    found = Analysis(BlockRows(np.zeros((0, 4), int), np.zeros((0, 4, 6)), 2))
    assert (found.rank, found.independent().size, found.redundant().shape) == (0, 0, (0, 0))
    assert np.count_nonzero(found.free_motion(np.random.default_rng(0))) == 12
