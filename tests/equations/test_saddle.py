"""The saddle point: the compiled path against the textbook, mass matrices against energies, massless bodies."""

import numpy as np
import pytest
from helpers.models import (
    Evaluation,
    across,
    all_joints_mechanism,
    consistent_state,
    derivative,
    direction,
    random_body,
    random_inertia,
    random_orientation,
)

from mbsd3d import GROUND, Body, Revolute, State, System, Universal, accelerations, simulate
from mbsd3d.equations.dense_solvers import inertia_about_origin
from mbsd3d.rotations import exponential, matrix, multiply
from validation import theory

# The plain solvers are imported where they are used: the other tests of this file do not need them.


def compiled_path(system, state):
    """(v_dot (6n,), lam (m,)) of the compiled solver."""
    arrays = accelerations(system, state).arrays
    return arrays["acceleration"][0].ravel(), arrays["lam"][0]


def relative(found, expected):
    """Greatest difference over the greatest expected number."""
    return np.abs(found - expected).max() / np.abs(expected).max()


@pytest.mark.parametrize("light", [1.0, 1e-4])
@pytest.mark.parametrize("seed", [3, 4])
def test_compiled_path_equals_the_textbook(seed, light):
    from mbsd3d.equations.dense_solvers import solve_plain

    system = all_joints_mechanism(seed, redundant=False, light=light)
    state = consistent_state(system, np.random.default_rng(seed))
    v_dot, lam = solve_plain(system, state)
    fast, fast_lam = compiled_path(system, state)
    # condition of the KKT matrix 1e6 to 1e9 for the light bodies, times rounding
    assert relative(fast, v_dot) < 1e-9
    assert relative(fast_lam, lam) < 1e-9


@pytest.mark.parametrize("light", [1.0, 1e-4])
def test_redundant_rows_change_shares_and_not_accelerations(light):
    from mbsd3d.equations.dense_solvers import solve_svd

    system = all_joints_mechanism(5, light=light)
    state = consistent_state(system, np.random.default_rng(5))
    v_dot, lam = solve_svd(system, state)
    fast, fast_lam = compiled_path(system, state)
    evaluation = Evaluation(system)
    _, J, _, _ = evaluation.rows(state.q, state.v, state.t)
    assert np.linalg.matrix_rank(J, tol=1e-9) == len(J) - 5  # a second hinge on the same axis
    assert relative(fast, v_dot) < 1e-9  # as above
    assert relative(J.T @ fast_lam, J.T @ lam) < 1e-9
    assert relative(fast_lam, lam) > 1e-3  # the fast path leaves rows out, the other shares among all


def test_plain_and_rank_revealing_solver_agree_on_independent_rows():
    from mbsd3d.equations.dense_solvers import solve_plain, solve_svd

    system = all_joints_mechanism(6, redundant=False)
    state = consistent_state(system, np.random.default_rng(6))
    for first, second in zip(solve_plain(system, state), solve_svd(system, state), strict=True):
        assert relative(first, second) < 1e-10  # condition of the KKT matrix 1e5


def test_solvers_agree_at_a_pose_the_mechanism_has_moved_to():
    from mbsd3d.equations.dense_solvers import solve_svd

    system = all_joints_mechanism(7, light=1e-4)
    start = consistent_state(system, np.random.default_rng(7))
    end = simulate(system, 0.2, state=start, output=2).final
    assert relative(compiled_path(system, end)[0], solve_svd(system, end)[0]) < 1e-9  # as above


def test_accelerations_meet_the_rows():
    system = all_joints_mechanism(8)
    state = consistent_state(system, np.random.default_rng(8))
    _, J, _, gamma = Evaluation(system).rows(state.q, state.v, state.t)
    v_dot, _ = compiled_path(system, state)
    assert np.abs(J @ v_dot - gamma).max() < 1e-12 * np.abs(v_dot).max()  # rounding times the condition of S


def test_ablation_one_per_cent_of_an_offset_is_seen():
    from mbsd3d.equations.dense_solvers import solve_plain

    system = all_joints_mechanism(3, redundant=False)
    state = consistent_state(system, np.random.default_rng(3))
    body = system.bodies[1]
    object.__setattr__(body, "com", 1.01 * body.com)
    changed = solve_plain(system, state)[0]
    object.__setattr__(body, "com", body.com / 1.01)
    assert relative(compiled_path(system, state)[0], changed) > 1e-7  # 100 times the tolerance of the comparison


def point_masses(rng, count=7):
    """(masses, points in body axes from O, mass, com, inertia about the centre of mass) of a general body."""
    masses, points = rng.uniform(0.2, 1.0, count), rng.normal(size=(count, 3))
    com = masses @ points / masses.sum()
    arms = points - com
    inertia = sum(m * ((x @ x) * np.eye(3) - np.outer(x, x)) for m, x in zip(masses, arms, strict=True))
    return masses, points, masses.sum(), com, inertia


def test_mass_matrix_is_that_of_the_points_it_is_made_of():
    rng = np.random.default_rng(9)
    masses, points, mass, com, inertia = point_masses(rng)
    e, v = random_orientation(rng), rng.normal(size=6)
    M = inertia_about_origin(e, com, mass, inertia)
    arms = points @ matrix(e).T
    velocities = v[:3] + np.cross(v[3:], arms)
    momentum = masses @ velocities
    about_origin = (masses[:, None] * np.cross(arms, velocities)).sum(axis=0)
    # rounding of sums over seven points
    assert 0.5 * v @ M @ v == pytest.approx(0.5 * masses @ (velocities**2).sum(axis=1), rel=1e-14)
    assert M @ v == pytest.approx(np.concatenate([momentum, about_origin]), abs=1e-13)
    assert np.array_equal(M[:3, 3:], M[3:, :3].T)


def test_kinetic_energy_of_a_solution_is_v_M_v():
    system = all_joints_mechanism(10)
    state = consistent_state(system, np.random.default_rng(10))
    energy = 0.0
    for body, q, v in zip(system.bodies, state.q.reshape(-1, 7), state.v.reshape(-1, 6), strict=True):
        energy += 0.5 * v @ inertia_about_origin(q[3:], body.com, body.mass, body.inertia) @ v
    assert accelerations(system, state).energy().kinetic[0] == pytest.approx(energy, rel=1e-14)  # rounding


def test_velocity_terms_do_the_work_of_the_changing_mass_matrix():
    """v'(M_dot v / 2 - h) = 0: the scalar form of 'M_dot - 2 C is skew'."""
    rng = np.random.default_rng(11)
    mass = 1.7
    com, inertia, e, v = 0.4 * direction(rng), random_inertia(rng, mass), random_orientation(rng), rng.normal(size=6)
    w = v[3:]
    R = matrix(e)
    s, pull = R @ com, mass * np.cross(w, np.cross(w, R @ com))
    h = np.concatenate([pull, np.cross(w, R @ inertia @ R.T @ w) + np.cross(s, pull)])
    M_dot = derivative(lambda t: inertia_about_origin(multiply(exponential(t * w), e), com, mass, inertia))
    assert v @ M_dot @ v / 2 == pytest.approx(v @ h, abs=1e-11)  # of the difference


def test_second_derivative_of_the_coordinates_along_a_motion():
    """e_ddot = (H w_dot + H_dot w) / 2 with H_dot = H(e_dot), against differences of a solution."""
    body = random_body(np.random.default_rng(12), omega=(1.1, -2.3, 0.7), velocity=(0.0, 0.2, 0.1))
    t, step = 0.5, 0.01
    solution = simulate(System(bodies=[body]), 1.0, rtol=1e-13, output=[t + k * step for k in range(-2, 3)])

    def H(e):
        return np.array(
            [[-e[1], -e[2], -e[3]], [e[0], e[3], -e[2]], [-e[3], e[0], e[1]], [e[2], -e[1], e[0]]]
        )  # fmt: skip

    e, w, alpha = (x(body)[2] for x in (solution.orientation, solution.omega, solution.alpha))
    second = 0.5 * (H(e) @ alpha + H(0.5 * H(e) @ w) @ w)
    values = solution.orientation(body)
    difference = np.array([-1, 16, -30, 16, -1]) @ values / (12 * step**2)
    assert second == pytest.approx(difference, abs=1e-7)  # truncation 1e-10 times sixth derivatives of 2.6 rad/s
    without = 0.5 * H(e) @ alpha
    assert np.abs(without - difference).max() > 1e-5  # 100 times the tolerance: the second ghost


def hanging(rng):
    """A body hanging on a cross whose axes are in general position: (body, point, first axis, second axis)."""
    body = random_body(rng, "shaft", position=0.5 * direction(rng))
    first = direction(rng)
    return body, 0.2 * direction(rng), first, across(rng, first)


def test_massless_ring_is_a_universal_joint():
    rng = np.random.default_rng(13)
    body, at, first, second = hanging(rng)
    ring = Body("ring", 0.0, (0.0, 0.0, 0.0), position=at + 0.1, orientation=random_orientation(rng))
    outer, inner = Revolute(GROUND, ring, at=at, axis=first), Revolute(ring, body, at=at, axis=second)
    with_ring = System(bodies=[ring, body], joints=[outer, inner])
    cross = Universal(GROUND, body, at=at, axis_a=first, axis_b=second)
    plain = System(bodies=[body], joints=[cross])
    v = consistent_state(plain, rng).v
    start = with_ring.assemble(rates={outer: first @ v[3:], inner: second @ v[3:]})
    alone = State(0.0, plain.state().q, start.v[6:])
    thin, whole = (
        simulate(system, 1.0, state=state, rtol=1e-12, output=9)
        for system, state in ((with_ring, start), (plain, alone))
    )
    # two integrations of one motion at rtol 1e-12
    assert thin.position(body) == pytest.approx(whole.position(body), abs=1e-10)
    assert thin.omega(body) == pytest.approx(whole.omega(body), abs=1e-10)
    assert thin.reaction(inner).force == pytest.approx(whole.reaction(cross).force, abs=1e-8)
    assert thin.reaction(inner).moment == pytest.approx(whole.reaction(cross).moment, abs=1e-8)
    assert thin.certificate.passed


def test_point_mass_without_inertia_is_a_mathematical_pendulum():
    arm, start = 0.8, 1.2
    # in the plane x = 0; the hinge lies along x through the origin, the reference point beside both
    place = arm * np.array([0.0, np.sin(start), -np.cos(start)])
    origin = np.array([0.3, 0.1, -0.2])
    bob = Body("bob", 1.3, (0.0, 0.0, 0.0), com=place - origin, position=origin)
    hinge = Revolute(GROUND, bob, at=(0.0, 0.0, 0.0), axis=(1.0, 0.0, 0.0))
    solution = simulate(System(bodies=[bob], joints=[hinge]), 3.0, rtol=1e-11, output=16)
    expected, _ = theory.pendulum_motion(solution.t, np.sqrt(9.81 / arm), start)
    assert solution.angle(hinge) + start == pytest.approx(expected, abs=1e-8)  # 1e3 rtol over two swings
