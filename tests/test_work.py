"""Work of single forces and drivers."""

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Revolute, SpeedDriver, System, Torque, simulate

AXIS = np.array([0.2, -0.5, 0.8]) / np.linalg.norm([0.2, -0.5, 0.8])


def test_work_of_a_torque_and_of_a_driver():
    """A torque along the hinge works T theta; a driver at constant speed takes what the torque gives."""
    rotor = Body("rotor", 1.3, (0.2, 0.3, 0.4), com=(0.03, 0.02, -0.05), position=(0.1, 0.2, 0.3))
    hinge = Revolute(GROUND, rotor, at=(0.1, 0.0, 0.2), axis=AXIS, name="hinge")
    push, motor = Torque(rotor, 0.7 * AXIS, name="push"), SpeedDriver(GROUND, rotor, axis=AXIS, speed=3.0, name="motor")
    free = simulate(System([rotor], [hinge], [push], gravity=(0, 0, 0)), 1.0, rtol=1e-10)
    np.testing.assert_allclose(free.work("push"), 0.7 * free.angle("hinge"), atol=1e-9)  # rtol and some steps
    np.testing.assert_allclose(free.work("push"), free.energy().work, atol=1e-12)
    driven = simulate(System([rotor], [hinge, motor], [push], gravity=(0, 0, 0)), 1.0, rtol=1e-10)
    np.testing.assert_allclose(driven.work(motor), -driven.work(push), atol=1e-9)  # the kinetic energy stays
    assert driven.work(push)[-1] == pytest.approx(0.7 * 3.0, abs=1e-9)
    with pytest.raises(ValueError, match="is not one of the joints"):
        driven.work("nobody")
