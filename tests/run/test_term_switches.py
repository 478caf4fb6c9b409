"""The teaching switches mean the same in `simulate`, `accelerations` and `linearize`."""

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Revolute, Spherical, System, accelerations, linearize, simulate

TERMS = ("gyroscopic", "centripetal", "gamma")


def pendulum():
    """Two bodies in general position, centres of mass off their reference points."""
    arm = Body("arm", 1.3, (0.2, 0.3, 0.45), com=(0.2, -0.1, 0.3), position=(0.1, 0.2, -0.4), omega=(0.7, -1.1, 2.0))
    tail = Body("tail", 0.7, (0.1, 0.12, 0.05), com=(-0.1, 0.2, 0.1), position=(0.4, 0.1, -0.9))
    joints = [Spherical(GROUND, arm, at=(0, 0.1, 0)), Revolute(arm, tail, at=(0.3, 0, -0.6), axis=(1, 2, -1))]
    return System([arm, tail], joints)


@pytest.mark.parametrize("term", TERMS)
def test_accelerations_without_a_term_are_those_of_a_run_without_it(term):
    system = pendulum()
    run = simulate(system, 1e-3, output=2, **{term: False})
    now, whole = accelerations(system, **{term: False}), accelerations(system)
    for body in system.bodies:
        scale = np.abs(whole.alpha(body)).max()
        assert now.alpha(body)[0] == pytest.approx(run.alpha(body)[0], abs=1e-12 * scale)
        assert np.abs(now.alpha(body)[0] - whole.alpha(body)[0]).max() > 1e-2 * scale


def test_small_motions_without_the_gyroscopic_term():
    """An upright top behaves as if C were A_G: lambda = i A_G w / 2A +- sqrt(4 A m g l - A_G^2 w^2) / 2A."""
    m, across, along, l, spin = 0.7, 0.003, 0.002, 0.08, 20.0
    top = Body("top", m, (across, across, along), position=(0, 0, l), omega=(0, 0, spin))
    system = System([top], [Spherical(GROUND, top, at=(0, 0, 0))])
    A = across + m * l**2
    for moment, terms in ((along, {}), (across, {"gyroscopic": False})):
        growth = np.sqrt(4 * A * m * 9.81 * l - (moment * spin) ** 2) / (2 * A)
        assert linearize(system, **terms).eigenvalues.real.max() == pytest.approx(growth, rel=1e-12)
