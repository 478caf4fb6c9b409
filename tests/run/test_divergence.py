"""When a motion is judged to grow without end."""

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    RK4,
    Body,
    GeneralizedAlpha,
    IntegrationError,
    JointFriction,
    Revolute,
    StateFeedback,
    System,
    measures,
    simulate,
)
from mbsd3d.extend import compile_system
from mbsd3d.run.failure_causes import DivergenceWatch


@pytest.mark.parametrize("start", [0.0, 1e4])
@pytest.mark.parametrize(("half_way", "diverges"), [(5.0, False), (9.5, True)])
def test_doubling_counts_against_the_time_since_the_start(start, half_way, diverges):
    """Half of 3001 steps and a doubled speed in the last 5 of 10 s are a machine, in the last 0.5 s no machine."""
    watch = DivergenceWatch(compile_system(System([Body("stone", 1.0, (1.0, 1.0, 1.0))])), start)
    y = np.zeros(13)
    assert not watch.diverges(y, 1500, start + half_way, 1.0)
    assert watch.diverges(y, 3001, start + 10.0, 2.0) == diverges


@pytest.mark.parametrize("unit", [1.0, 1e3, 1e6])
def test_a_servo_is_no_divergence_in_any_unit_of_length(unit):
    """A rim at 30 m/s is 3e4 mm/s; truth: the angle has come to its target after ten time constants."""
    rotor = Body("rotor", 1.3, unit**2 * np.array([0.11, 0.13, 0.17]), com=unit * np.array([0.02, -0.05, 0.03]))
    hinge = Revolute(GROUND, rotor, at=rotor.centre, axis=(2.0, -3.0, 6.0))
    seen = [measures.angle(hinge), measures.rate(hinge)]
    gains = unit**2 * np.array([60.0, 6.0])
    servo = StateFeedback(measures=seen, gains=gains, on=hinge, reference=(30.0, 0.0), time_constant=0.002)
    system = System([rotor], [hinge], [servo], gravity=(0, 0, 0))
    run = simulate(system, 1.5, method=GeneralizedAlpha(), rtol=1e-4, output=3)
    assert run.angle(hinge)[-1] == pytest.approx(30.0, abs=0.1)


def test_a_fixed_step_that_is_too_long_is_said_to_be():
    wheel = Body("wheel", 1.3, (0.11, 0.23, 0.17), velocity=(0, 0, 0), omega=(8.0, 16.0, 24.0))
    hinge = Revolute(GROUND, wheel, at=(0, 0, 0), axis=(1.0, 2.0, 3.0))
    brake = JointFriction(hinge, viscous=500.0)
    with pytest.raises(IntegrationError, match="no finite solution.*fixed length, take a smaller dt"):
        simulate(System([wheel], [hinge], [brake]), 40.0, method=RK4(0.2))
