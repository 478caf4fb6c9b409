"""Velocities at the start: least kinetic energy on the rows, whichever way they are solved."""

import numpy as np
import pytest
from helpers.models import across, direction, random_body
from scipy.linalg import null_space

from mbsd3d import GROUND, Revolute, SpeedDriver, Spherical, System, Universal
from mbsd3d.extend import DenseEquations
from validation.cases.inline_four import inline_four

ROUNDING = 1e-12  # of velocities of order one: 1e-16 times the condition of the rows, some hundreds


def driven_chain(seed, **given):
    """A shaft that a motor turns at a steady rate, a rod on a ball joint, and a third body on a cross."""
    rng = np.random.default_rng(seed)
    shaft, rod, tail = (random_body(rng, name, **given.get(name, {})) for name in ("shaft", "rod", "tail"))
    axis, first = direction(rng), direction(rng)
    joints = [
        Revolute(GROUND, shaft, at=rng.normal(size=3), axis=axis),
        SpeedDriver(GROUND, shaft, axis=axis, speed=rng.uniform(1.0, 3.0), name="motor"),
        Spherical(shaft, rod, at=rng.normal(size=3)),
        Universal(rod, tail, at=rng.normal(size=3), axis_a=first, axis_b=across(rng, first)),
    ]
    return System([shaft, rod, tail], joints)


def closed_chain(seed):
    """The same with the tail held by a ball joint of the ground: rows that close a loop, none of them redundant."""
    chain, rng = driven_chain(seed), np.random.default_rng(100 + seed)
    return System(chain.bodies, [*chain.joints, Spherical(GROUND, chain.bodies[2], at=rng.normal(size=3))])


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("build", [driven_chain, closed_chain])
def test_velocities_have_the_least_kinetic_energy_on_the_rows(build, seed):
    """J v = b, where b is the speed of the motor alone, and M v is perpendicular to every motion the rows allow."""
    system = build(seed)
    state = system.state()
    terms = DenseEquations(system).at(state)
    motor = system.joints[1]
    b = np.zeros(len(terms.J))
    b[system.lowered.rows[id(motor)]] = motor.speed(0.0)
    np.testing.assert_allclose(terms.J @ state.v, b, rtol=0, atol=ROUNDING)
    free = null_space(terms.J)
    assert free.shape[1] == system.check().mobility
    momenta = free.T @ terms.M @ state.v
    np.testing.assert_allclose(momenta, 0.0, rtol=0, atol=ROUNDING * np.abs(terms.M @ state.v).max())


@pytest.mark.parametrize("seed", range(3))
def test_a_velocity_that_is_given_and_the_same_solved_are_one_motion(seed):
    """Given velocities go by the dense equations: both ways lead to the same motion."""
    free = driven_chain(seed)
    v = free.state().v.reshape(3, 6)
    given = driven_chain(seed, tail={"velocity": v[2, :3], "omega": v[2, 3:]})
    np.testing.assert_allclose(given.state().v, free.state().v, rtol=0, atol=1e-10)


def test_pistons_have_the_speed_of_the_slider_crank():
    """z = R cos q + sqrt(L^2 - R^2 sin^2 q) at q = 0: at rest; the crankpins go round, the rods turn back."""
    radius, length, rate = 0.7, 2.3, 1.9
    engine = inline_four(radius, length, rate=rate)
    state = engine.state()
    v = dict(zip([body.name for body in engine.bodies], state.v.reshape(-1, 6), strict=True))
    for i, side in enumerate((1.0, -1.0, -1.0, 1.0), start=1):
        np.testing.assert_allclose(v[f"piston {i}"], 0.0, rtol=0, atol=ROUNDING)
        pin = [rate * side * radius, 0, 0, 0, -rate * side * radius / length, 0]
        np.testing.assert_allclose(v[f"rod {i}"], pin, rtol=0, atol=ROUNDING)
