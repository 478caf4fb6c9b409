"""Accelerations at one state after another are those of `accelerations`."""

from dataclasses import replace

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Input, Revolute, Spherical, System, Torque, TorsionSpring, Tyre, accelerations
from mbsd3d.equations.compiled import Switches
from mbsd3d.extend import Rates


def pendulum_and_wheel():
    """A two-link pendulum off its centres of mass, and a wheel on a tyre, whose deflections are internal states."""
    one = Body("one", 2.0, (0.1, 0.3, 0.25), com=(0.2, 0.05, -0.1), position=(0, 0, 3), omega=(0.3, 0.1, -0.2))
    two = Body("two", 1.0, (0.05, 0.06, 0.04), com=(0.1, 0.2, 0.0), position=(0.5, 0.1, 2.8))
    wheel = Body("wheel", 6.0, (0.2, 0.3, 0.2), position=(3, 0, 0.32), velocity=(4, 0.3, 0), omega=(0.2, 9, 0.5))
    joints = [Spherical(GROUND, one, at=(0, 0, 3)), hinge := Revolute(one, two, at=(0.5, 0.1, 2.8), axis=(0.3, 1, 0.2))]
    tyre = Tyre(GROUND, wheel, axis=(0, 1, 0), radius=0.33, crown=0.04, stiffness=4e4)
    return System([one, two, wheel], joints, [TorsionSpring(hinge, stiffness=4.0), tyre])


@pytest.mark.parametrize("terms", [{}, {"gyroscopic": False, "centripetal": False}])
def test_rates_are_those_of_accelerations(terms):
    system = pendulum_and_wheel()
    start = system.state()
    rates = Rates(system, start, Switches(**terms))
    for z in (np.zeros(2), np.array([0.02, -0.03])):
        state = type(start)(start.t, start.q, start.v, z)
        a, z_dot = rates(state)
        known = accelerations(system, state, **terms)
        for k, body in enumerate(system.bodies):
            assert a[k] == pytest.approx(np.concatenate([known.acceleration(body)[0], known.alpha(body)[0]]), rel=1e-12)
        assert z_dot == pytest.approx([x[0] for x in known.force(system.forces[-1]).state_rates.values()], rel=1e-12)


def test_an_input_is_the_number_it_is_set_to():
    free = pendulum_and_wheel()

    def driven(by):
        return replace(free, forces=[*free.forces, Torque(free.part("two"), (0.4 * by, 0.0, by + 1.0), name="drive")])

    rates = Rates(driven(Input("drive", 2.0)), free.state())
    for value in (2.0, -3.5):
        rates.set("drive", value)
        for found, wanted in zip(rates(free.state()), Rates(driven(value), free.state())(free.state()), strict=True):
            assert found == pytest.approx(wanted, rel=1e-14)
