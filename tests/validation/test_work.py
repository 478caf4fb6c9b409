"""Work of single forces and drivers."""

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Kinematic,
    Polynomial,
    Revolute,
    SpeedDriver,
    StateFeedback,
    System,
    Torque,
    measures,
    simulate,
)

AXIS = np.array([0.2, -0.5, 0.8]) / np.linalg.norm([0.2, -0.5, 0.8])


def test_work_of_a_torque_and_of_a_driver():
    """A torque along the hinge works T theta; a driver at constant speed takes what the torque gives."""
    rotor = Body("rotor", 1.3, (0.2, 0.3, 0.4), com=(0.03, 0.02, -0.05), position=(0.1, 0.2, 0.3))
    hinge = Revolute(GROUND, rotor, at=(0.1, 0.0, 0.2), axis=AXIS, name="hinge")
    push, motor = Torque(rotor, 0.7 * AXIS, name="push"), SpeedDriver(GROUND, rotor, axis=AXIS, speed=3.0, name="motor")
    free = simulate(System([rotor], [hinge], [push], gravity=(0, 0, 0)), 1.0, rtol=1e-10)
    np.testing.assert_allclose(free.work("push"), 0.7 * free.angle("hinge"), rtol=0, atol=1e-9)  # rtol and some steps
    np.testing.assert_allclose(free.work("push"), free.energy().work, rtol=0, atol=1e-12)
    driven = simulate(System([rotor], [hinge, motor], [push], gravity=(0, 0, 0)), 1.0, rtol=1e-10)
    np.testing.assert_allclose(driven.work(motor), -driven.work(push), rtol=0, atol=1e-9)  # the kinetic energy stays
    assert driven.work(push)[-1] == pytest.approx(0.7 * 3.0, abs=1e-9)
    with pytest.raises(ValueError, match="is not one of the joints"):
        driven.work("nobody")


@pytest.mark.parametrize("stop", [False, True])
def test_work_and_filters_of_a_driven_motion_are_of_order_two(stop):
    """theta = t^2: the driver's work is the energy gained and what feedback takes; filter: z' = (2 t - z) / tau."""
    rotor = Body("rotor", 1.3, (0.2, 0.3, 0.4), com=(0.03, 0.02, -0.5), position=(0.1, 0.2, 0.3))
    hinge = Revolute(GROUND, rotor, at=(0.1, 0.0, 0.2), axis=AXIS, name="hinge")
    tau, errors = 0.4, []
    brake = StateFeedback(measures=[measures.rate(hinge)], gains=[0.7], on=hinge, time_constant=tau, name="brake")
    system = System([rotor], [hinge, AngleDriver(hinge, Polynomial([0.0, 0.0, 1.0]), name="motor")], [brake])
    condition = measures.angle(hinge) > 0.5 if stop else None
    for output in (65, 129):
        run = simulate(system, 1.0, method=Kinematic(), output=output, stop_when=condition)
        energy, t = run.energy(), run.final.t
        z = 2.0 * (t - tau + tau * np.exp(-t / tau))
        errors.append([energy.work[-1] - (energy.total[-1] - energy.total[0]), run.state_of(brake)[-1, 0] - z])
    coarse, fine = np.abs(errors)
    assert (fine < [2e-3, 2e-4]).all()  # h^2/12 times the change of the power, 20 W/s, and of 2/tau = 5 rad/s^2 ...
    assert (coarse / fine > 3.2).all()  # 4 for order 2, 2 for order 1; the last piece before an event is shorter
