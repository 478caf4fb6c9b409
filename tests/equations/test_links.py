"""What the rows of a link hold and leave free, against the rows themselves, and rows that wear while a body moves."""

import numpy as np
import pytest
from helpers.models import across, all_joints_mechanism, consistent_state, direction, random_body

from mbsd3d import GROUND, PointOnPlane, System, accelerations, simulate
from mbsd3d.equations.compiled import Switches
from mbsd3d.extend import build_spanning_tree, compile_system, load_state
from mbsd3d.solver.saddle_point import factor


def factored(system, state, blocks=True):
    """(data, tree) of a system at a state; without blocks all rows are orthogonalised."""
    compiled = compile_system(system, (), Switches())
    data = compiled.data()
    load_state(compiled, data, state)
    tree = build_spanning_tree(compiled.model, data)
    if not blocks:
        tree.link["lines"] = -1
    factor(compiled.model, data, tree)
    return data, tree


def rows_on_body(data, tree, link):
    """(r, 6) the rows of a link by the acceleration of its body."""
    held = tree.joint[link["joint"] : link["joint"] + link["rows"]]
    J = data.row["J"][held["row"]]
    both = J[np.arange(held.size), held["slot"]]
    return both + np.where(held["twin"][:, None] >= 0, J[np.arange(held.size), held["twin"]], 0.0)


@pytest.mark.parametrize("blocks", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_directions_move_one_row_each_or_none(seed, blocks):
    system = all_joints_mechanism(seed)
    data, tree = factored(system, consistent_state(system, np.random.default_rng(seed)), blocks)
    if blocks:
        assert set(tree.link["lines"]) == {0, 1, 2, 3}  # every joint has blocks,
        assert set(tree.link["point"][tree.link["lines"] == 3]) == {0, 1}  # of points that meet, and other ones
    for link in tree.link:
        J, r = rows_on_body(data, tree, link), link["rows"]
        moved = J @ link["basis"].T
        # rounding of lengths of a few metres times how far rows are from depending on each other, 20 at most
        assert moved[:, :r] == pytest.approx(np.eye(r), abs=1e-12)
        assert moved[:, r:] == pytest.approx(0.0, abs=1e-12)
        assert np.linalg.cond(link["basis"]) < 1e3


def on_two_planes(rng):
    """A body with a point in a plane of the ground and a plane of its own through a point of the ground.

    It spins about a common direction of both planes, so that their normals are parallel twice in each turn.
    """
    axis = direction(rng)
    normal = across(rng, axis)
    body = random_body(rng, "plate", position=0.3 * direction(rng), velocity=None, omega=2.0 * axis)
    near, far = body.position + 0.4 * direction(rng), body.position + 0.9 * np.cross(axis, normal)
    of_ground = PointOnPlane(GROUND, body, at=near, normal=normal, name="plane of the ground")
    of_body = PointOnPlane(body, GROUND, at=far, normal=across(rng, axis), name="plane of the body")
    return System([body], [of_ground, of_body])


@pytest.mark.parametrize("seed", [0, 1, 2, 5])
def test_rows_that_become_parallel_are_held_as_before(seed):
    """Two lines cannot be told apart then, but the rows stay independent by their moments."""
    system = on_two_planes(np.random.default_rng(seed))
    start = system.assemble()
    assert factored(system, start)[1].link["lines"].tolist() == [2]
    run = simulate(system, 4.0, state=start, rtol=1e-10, output=201)
    assert run.certificate.passed
    worn = [k for k in range(201) if factored(system, run.state(k))[1].link["lines"][0] == -1]
    assert worn  # samples where the normals are nearly parallel, which these seeds come to
    for k in worn[:3]:
        state = run.state(k)
        assert run.acceleration("plate")[k] == pytest.approx(
            accelerations(system, state).acceleration("plate")[0], abs=1e-8
        )
