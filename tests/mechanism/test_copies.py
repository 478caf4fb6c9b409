"""Systems that are copied, or pickled for another process, after they have been used."""

import copy
import pickle
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

import numpy as np
import pytest
from helpers.forces import EXAMPLES

from mbsd3d import CustomForce, System, accelerations, simulate
from validation.cases.examples import mechanism, random_body

WAYS = {"deepcopy": copy.deepcopy, "copy": copy.copy, "pickle": lambda system: pickle.loads(pickle.dumps(system))}


def seen(system):
    """Names and accelerations, by name: what is kept by the identity of parts."""
    found = accelerations(system, system.state())
    parts = [system.name(part) for part in (*system.bodies, *system.joints, *system.forces)]
    return parts, np.array([found.acceleration(body.name)[0] for body in system.bodies])


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(3))
def test_a_copy_of_a_used_mechanism_moves_alike(seed, way):
    system = mechanism(seed)
    names, moved = seen(system)
    names_of_copy, moved_of_copy = seen(WAYS[way](system))
    assert names_of_copy == names
    np.testing.assert_array_equal(moved_of_copy, moved)


@pytest.mark.parametrize("name", EXAMPLES)
def test_a_copy_has_its_forces(name):
    rng = np.random.default_rng(3)
    bodies = [random_body(rng, "one"), random_body(rng, "two")]
    joints, force = EXAMPLES[name](rng, *bodies)
    system = System(bodies, joints, [force])
    ways = [copy.deepcopy] if isinstance(force, CustomForce) else WAYS.values()  # local functions have no pickle
    for way in ways:
        np.testing.assert_array_equal(seen(way(system))[1], seen(system)[1])


def last_pose(system):
    return simulate(system, 0.05, rtol=1e-6, progress=False).final.q


def test_other_processes_run_it():
    system = mechanism(1)
    alone = last_pose(system)
    with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
        np.testing.assert_array_equal(pool.submit(last_pose, system).result(), alone)


def test_a_run_says_how_it_goes_elsewhere():
    run = simulate(mechanism(1), 0.01, rtol=1e-6, progress=False)
    for way in (copy.deepcopy, pickle.dumps):
        with pytest.raises(ValueError, match=r"neither copied nor pickled.*solution.save\(path\)"):
            way(run)
