"""Linearisation with internal states of force elements, against matrices written by hand."""

import numpy as np
import pytest

from mbsd3d import GROUND, Body, CustomForce, Revolute, StateFeedback, System, TorsionSpring, linearize, measures

EXACT = 1e-12
"""Rounding: the matrices have entries of order one."""


def arm():
    """(body, hinge, moment of inertia about it): an arm about an axis that is not vertical, its centre on the axis."""
    body = Body("arm", mass=2.0, inertia=(0.1, 0.5, 0.4), com=(0.2, -0.1, 0.3), position=(-0.2, 0.1, -0.3))
    return body, Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 1, 0), name="hinge"), 0.5


def test_filtered_feedback():
    body, hinge, J = arm()
    seen = [measures.angle(hinge), measures.rate(hinge)]
    servo = StateFeedback(measures=seen, gains=(30.0, 4.0), on=hinge, reference=(0.2, 0.0), time_constant=0.05)
    system = System([body], [hinge], [servo])
    state = system.assemble(angles={hinge: 0.2})
    found = linearize(system, state, outputs=[*seen, measures.state(servo, 0), measures.state(servo, 1)])
    expected = np.array([[0, 1, 0, 0], [0, 0, -30 / J, -4 / J], [20, 0, -20, 0], [0, 20, 0, -20]])
    assert np.abs(found.A - expected).max() < EXACT * np.abs(expected).max()
    full = linearize(system, state)
    assert (
        full.states[2:] == ("z0", "z1")
        and np.abs(np.sort_complex(full.eigenvalues) - np.sort_complex(np.linalg.eigvals(expected))).max()
        < 1e-11 * np.abs(expected).max()
    )  # two eigenvalues lie close together
    with pytest.raises(ValueError, match="accelerates|internal state"):
        linearize(system, system.assemble(angles={hinge: 0.1}))


@pytest.mark.slow
def test_custom_force_with_a_state():
    def coil(t, bodies, z, parameters, loads, z_dot):
        turn = bodies[0].w[1]
        loads[0, 4] = -parameters[0] * z[0] - parameters[1] * turn * np.sqrt(1.0 + turn * turn)
        z_dot[0] = turn - z[0] * (1.0 + z[0] * z[0]) / parameters[2]

    body, hinge, J = arm()
    force = CustomForce(coil, on=body, parameters=(3.0, 0.7, 0.4), states=(0.0,))
    system = System([body], [hinge], [force, TorsionSpring(hinge, stiffness=5.0)])
    outputs = [measures.angle(hinge), measures.rate(hinge), measures.state(force)]
    expected = np.array([[0, 1, 0], [-5 / J, -0.7 / J, -3 / J], [0, 1, -1 / 0.4]])
    assert np.abs(linearize(system, outputs=outputs).A - expected).max() < EXACT * np.abs(expected).max()


@pytest.mark.slow
def test_custom_force_that_depends_on_time_is_refused():
    def push(t, bodies, z, parameters, loads, z_dot):
        loads[0, 4] = np.sin(parameters[0] * t)

    body, hinge, _ = arm()
    system = System([body], [hinge], [CustomForce(push, on=body, parameters=(2.0,))])
    with pytest.raises(ValueError, match="change along the motion"):
        linearize(system)  # in balance at t = 0, but not for long


def test_outputs_are_measures_of_parts_of_the_system():
    body, hinge, _ = arm()
    servo, other = (
        StateFeedback(measures=[measures.rate(hinge)], gains=(4.0,), on=hinge, time_constant=0.05, name=name)
        for name in ("servo", "other")
    )
    system = System([body], [hinge], [servo])
    with pytest.raises(ValueError, match="outputs: state rate of hinge of other: force 'other' is not in the system"):
        linearize(system, outputs=[measures.rate(hinge), measures.state(other)])
    with pytest.raises(ValueError, match="the rate of 'angle of hinge' depends on more"):
        linearize(system, outputs=measures.angle(hinge))  # a single one is a list of one
    with pytest.raises(ValueError, match="linearize: state 3 is not a State"):
        linearize(system, 3)
    with pytest.raises(ValueError, match="mode: 1.5 is not one of"):
        linearize(system).mode(1.5)
