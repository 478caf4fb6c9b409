"""Random mechanisms of every joint, driver and coupling against a formulation that shares no kernel with them."""

from functools import cache

import numpy as np
import pytest
from helpers.models import consistent_state, random_body
from helpers.second_formulation import differences

from mbsd3d import CurveContact, IntegrationError, System, accelerations, simulate
from validation.cases.examples import EXAMPLES, mechanism, rows_of
from validation.twins.definitions import equations as reference_point
from validation.twins.definitions import rows as definitions

LIMIT = 1e-9
"""Relative, as asked; more where rounding times the condition of the inertia of what is free to move is more."""
QUICK, ALL = 40, 500
NEARLY_DEPENDENT = {207: 1e-10, 326: 3e-12, 413: 3e-11}
"""Seeds whose loop rows have pivots that differ by 6e6 to 4e7 -> limit: ten times what is left, a tenth of what
S = J M^-1 J' alone loses. Beside a solution of the same rows with 50 digits: 207 2e-11 (1.5e-9 with S alone), as the
definitions themselves; 413 7e-13 (1.2e-9)."""


def moved(system, state, t=0.05):
    """Where a short motion brings the mechanism; half-way, if a driver pulls it to a dead centre before."""
    try:
        return simulate(system, t, state=state, output=2).final
    except IntegrationError as stop:
        return moved(system, state, 0.5 * stop.solution.final.t)


@cache
def at_start(seed):
    """(system, state, differences) of a mechanism at its start."""
    system = mechanism(seed)
    state = consistent_state(system, np.random.default_rng(seed))
    return system, state, differences(system, state)


def compare(seed):
    """Both formulations at the reference pose and after a short motion."""
    system, state, first = at_start(seed)
    later = moved(system, state)
    for at, slack, found in ((state, 1e-11, first), (later, 1e-8, differences(system, later))):
        acceleration, wrench, expected = found
        # the start is rounded, a step is projected
        assert max(*expected.gaps, *expected.rates) < slack * max(1.0, np.abs(at.v).max())
        # what two stable solutions may differ by: some roundings times the condition
        limit = max(LIMIT, 10 * np.finfo(float).eps * expected.condition)
        assert acceleration < limit and wrench < limit


@pytest.mark.parametrize("seed", range(QUICK))
def test_random_mechanisms(seed):
    compare(seed)


@pytest.mark.parametrize("seed", NEARLY_DEPENDENT)
def test_nearly_dependent_rows_lose_no_digits_of_the_equations(seed):
    acceleration, wrench, _ = at_start(seed)[2]
    assert max(acceleration, wrench) < NEARLY_DEPENDENT[seed]


@pytest.mark.slow
@pytest.mark.parametrize("first", range(QUICK, ALL, 20))
def test_more_random_mechanisms(first):
    for seed in range(first, min(first + 20, ALL)):
        compare(seed)


def test_random_mechanisms_hold_every_joint_and_redundant_rows():
    systems = [at_start(seed)[0] for seed in range(QUICK)]
    kinds = {type(joint) for system in systems for joint in system.joints}
    defined = set(definitions.GEOMETRY) | set(definitions.VELOCITY)
    assert kinds | {CurveContact} == defined & set(EXAMPLES) == defined
    masses = [body.mass for system in systems for body in system.bodies]
    assert max(masses) / min(masses) > 1e4
    ranks = [at_start(seed)[2][2].rank for seed in range(QUICK)]
    redundancy = sum(rows_of(system.joints) > rank for system, rank in zip(systems, ranks, strict=True))
    assert redundancy > QUICK // 10


def test_ablation_the_second_formulation_sees_a_millionth_of_an_offset():
    system = mechanism(3)
    state = consistent_state(system, np.random.default_rng(3))
    body = system.bodies[0]
    clean = differences(system, state)[0]
    found = accelerations(system, state)
    object.__setattr__(body, "com", body.com * (1 + 1e-6))
    changed = reference_point.solve(system, state).acceleration
    apart = np.abs(found.arrays["acceleration"][0] - changed).max() / np.abs(changed).max()
    assert clean < LIMIT and apart > 10 * LIMIT


def test_the_second_formulation_knows_bodies_that_fly():
    system = System([random_body(np.random.default_rng(6), omega=(1.1, -2.3, 0.7))])
    assert differences(system, system.state())[0] < 1e-13  # rounding
