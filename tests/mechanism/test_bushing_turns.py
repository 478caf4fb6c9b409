"""A bushing turned by any angle: its moment and energy against the closed form, at half a turn and beyond."""

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Bushing, State, System, accelerations, rotation, simulate
from mbsd3d.rotations import exponential, matrix, multiply

STIFFNESS = np.array([2.0, 1.3, 4.0])
AXES = rotation((1.0, 2.0, -0.5), 0.7)
AXIS = np.array([0.3, -0.5, 0.8]) / np.sqrt(0.98)


def mounted(stiffness=STIFFNESS, omega=(0.0, 0.0, 0.0)):
    body = Body("body", 1.0, (0.1, 0.1, 0.1), position=(0.2, -0.1, 0.4), orientation=AXES, omega=omega)
    mount = Bushing(GROUND, body, at=body.position, stiffness=50.0, turning_stiffness=stiffness, axes=AXES)
    return System([body], [], [mount], gravity=(0, 0, 0)), body, mount


@pytest.mark.parametrize("angle", [1e-9, 0.4, 2.0, 2.2, np.pi, np.pi + 1e-9, 4.0, 6.0, 9.5])
def test_moment_and_energy_at_any_angle(angle):
    """-2 (p0 K p + p x K p) and 2 p'K p with p0 = cos(angle/2), p = axis sin(angle/2), whatever the sign of (p0, p)."""
    system, body, mount = mounted()
    q = system.state().q.copy()
    q[3:] = multiply(exponential(angle * AXIS), q[3:])
    now = accelerations(system, State(0.0, q, np.zeros(6)))
    F = matrix(AXES)
    p0, p = np.cos(angle / 2), F.T @ AXIS * np.sin(angle / 2)
    moment = F @ (-2.0 * (p0 * STIFFNESS * p + np.cross(p, STIFFNESS * p)))
    load = now.force(mount)
    assert load.moment[0] == pytest.approx(moment, rel=1e-12, abs=4e-15)  # rounding of the rotation, times K
    assert load.stored[0] == pytest.approx(2.0 * p @ (STIFFNESS * p), rel=1e-14 + 1e-15 / angle)  # the same, over it


def test_a_body_that_turns_over_again_and_again_is_a_pendulum():
    """About an axis of equal stiffnesses: I theta'' = -K sin(theta), with the energy of more than half a turn."""
    rate, k, inertia = 9.0, 1.5, 0.1
    system, body, mount = mounted((k, k, k), omega=tuple(rate * AXIS))
    run = simulate(system, 5.0, rtol=1e-10)
    turned = 2.0 * np.arccos(np.clip(np.abs(run.orientation(body) @ np.array(AXES)), 0.0, 1.0))
    known = np.sqrt(rate**2 - 4.0 * k / inertia * np.sin(turned / 2) ** 2)
    assert np.linalg.norm(run.omega(body), axis=1) == pytest.approx(known, rel=1e-7)  # arccos leaves half the digits
    assert turned.max() > 3.0 and run.certificate.passed
