"""Every force element against its law written out once more, between two bodies and from the ground."""

import numpy as np
import pytest
from models import random_body
from test_loads import EXAMPLES
from test_random import differences

from mbsd3d import GROUND, Revolute, State, System, TorsionSpring, accelerations, simulate
from validation.cases.examples import moving
from validation.twins.definitions import equations as reference_point
from validation.twins.laws import LAWS

LIMIT = 1e-11
"""Relative: rounding of loads of order one on bodies of order one, and of the 40 nodes of a tyre's bristles."""


def loaded(name, ground):
    """(system, state, force) of two bodies with one force element, its own states not at rest."""
    rng = np.random.default_rng(13)
    bodies = [random_body(rng, "one"), random_body(rng, "two")]
    joints, force = EXAMPLES[name](rng, GROUND if ground else bodies[0], bodies[1])
    system = System(bodies[1:] if ground else bodies, joints, [force], gravity=(0.3, -0.7, -9.6))
    start = moving(system, 5)
    z = start.z.copy()
    own = len(force.state_names())
    z[:own] += 0.1 * rng.normal(size=own)
    return system, State(start.t, start.q, start.v, z, start.coordinates), force


WRITTEN = [name for name in EXAMPLES if type(loaded(name, False)[2]) in LAWS]


@pytest.mark.parametrize("name", WRITTEN)
@pytest.mark.parametrize("ground", [False, True])
def test_laws(name, ground):
    system, state, force = loaded(name, ground)
    acceleration, wrench, _ = differences(system, state)
    assert acceleration < LIMIT and wrench < LIMIT
    bare = System(system.bodies, system.joints, gravity=system.gravity)
    alone = accelerations(bare, state=State(state.t, state.q, state.v, bare.state().z))
    loads = accelerations(system, state=state).arrays["acceleration"] - alone.arrays["acceleration"]
    assert np.abs(loads).max() > 1e-3  # the element does something here


@pytest.mark.parametrize("name", [name for name in WRITTEN if loaded(name, False)[2].state_names()])
def test_rates_of_own_states(name):
    system, state, force = loaded(name, False)
    now = reference_point.Motion(system, state, state.v.reshape(1, -1, 6))
    push, _ = reference_point.pushed(system, state, now, force, reference_point.law_of_force(system, force))
    found = accelerations(system, state=state).force(force).state_rates
    assert np.ravel([*found.values()]) == pytest.approx(push.rates, rel=LIMIT, abs=LIMIT)


def test_every_law_is_looked_at():
    assert {type(loaded(name, False)[2]) for name in WRITTEN} == set(LAWS)


@pytest.mark.parametrize("name", [name for name in EXAMPLES if name not in WRITTEN])
def test_a_force_without_a_law_is_named(name):
    system, state, force = loaded(name, False)
    with pytest.raises(ValueError, match=rf"force '.*' \({type(force).__name__}\) has no second formulation"):
        reference_point.solve(system, state)


def test_turns_of_a_spring_are_counted():
    """A torsion spring wound up by more than two turns pulls back with all of them."""
    rotor = random_body(np.random.default_rng(3), "rotor")
    hinge = Revolute(GROUND, rotor, at=rotor.centre, axis=(1, 2, 2))
    system = System([rotor], [hinge], [TorsionSpring(hinge, stiffness=3e-3, angle=0.4)])
    run = simulate(system, 0.5, state=system.assemble(rates={hinge: 30.0}))
    assert run.angle(hinge)[-1] > 4 * np.pi
    assert differences(system, run.final)[0] < 1e-9  # a step is projected
