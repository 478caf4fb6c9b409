"""Laws with a corner at the state have no linear equations there; smooth ones beside it have."""

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AeroDrag,
    Body,
    EndStop,
    ForceCurve,
    LinearActuator,
    Prismatic,
    SpringDamper,
    System,
    TorqueCurve,
    linearize,
)
from mbsd3d.errors import InputError

WAY = np.array([2.0, 3.0, 6.0]) / 7.0
MASS, K = 2.0, 1e6
ENDS = {"at_a": -WAY, "at_b": 0.0 * WAY}


def block(force):
    body = Body("block", MASS, (0.1, 0.2, 0.15), com=(0.1, -0.2, 0.05))
    rail = Prismatic(GROUND, body, at=(0, 0, 0), axis=WAY, name="rail")
    spring = SpringDamper(GROUND, body, **ENDS, stiffness=K, name="spring")
    return System([body], [rail], [spring, force(body, rail)], gravity=(0, 0, 0))


def two_slopes(body, rail):
    return ForceCurve(GROUND, body, **ENDS, points=[(-5, -5), (0, 0), (5, 15)], over="rate", name="damper")


def ram(body, rail):
    return LinearActuator(GROUND, body, **ENDS, thrust=5.0, rate=0.4, stroke=(0.5, 2.0), stiffness=1e5, name="ram")


def buffer(body, rail):
    return EndStop(rail, upper=0.0, stiffness=1e4, name="buffer")


def bent(body, rail):
    return TorqueCurve(rail, points=[(-1, 10), (0, 0), (1, -30)], over="slide", name="bent")


@pytest.mark.parametrize(
    ("force", "name"),
    [(two_slopes, "ForceCurve 'damper'"), (buffer, "EndStop 'buffer'"), (bent, "TorqueCurve 'bent'")],
)
def test_a_corner_at_rest_is_refused(force, name):
    system = block(force)
    with pytest.raises(InputError, match=f"the law of {name} has a corner at this state"):
        linearize(system)
    rest = system.equilibrium()  # the pose is found all the same
    assert rest.stability == "unknown" and "has a corner" in rest.reason


def test_an_actuator_holds_its_thrust_on_one_side_only():
    system = block(ram)
    rest = system.equilibrium()
    with pytest.raises(InputError, match="the law of LinearActuator 'ram' has a corner"):
        linearize(system, rest.state)


def test_laws_that_are_smooth_at_rest():
    """Drag with the square of the speed has slope 0 on both sides; a corner beside the state does not matter."""
    w = np.sqrt(K / MASS)
    dragged = block(lambda body, rail: AeroDrag(body, drag_area=0.5, density=1.2))
    beside = block(lambda body, rail: EndStop(rail, upper=1e-6, stiffness=1e4))
    for system in (dragged, beside):
        assert np.abs(linearize(system).eigenvalues.imag).max() == pytest.approx(w, rel=1e-12)
