"""A state of a run that measured angles besides those of hinges starts another run that measures others."""

import numpy as np
import pytest

from mbsd3d import GROUND, Body, Revolute, State, Stepper, System, TorsionSpring, load, measures, simulate

AXIS = np.array([0.3, -0.5, 0.8]) / np.sqrt(0.98)
RATE = 17.0  # rad/s


def spinning():
    """A free body that turns about a general axis, its turn, and an angle of another direction of it."""
    body = Body("body", 1.0, (0.3, 0.3, 0.3), position=(1, 2, 3), omega=RATE * AXIS)
    other = measures.angle_between(GROUND, body, axis_a=(1, 0, 0), axis_b=(0, 1, 0), about=AXIS)
    return System([body], gravity=(0, 0, 0)), measures.turn(GROUND, body, about=AXIS), other


def test_a_condition_on_another_angle_starts_from_that_angle():
    """The count of the turn, 51.6 rad, was taken for that of the other angle."""
    system, turn, other = spinning()
    first = simulate(system, 9.0, stop_when=turn > 51.6)
    assert first.final.t == pytest.approx(51.6 / RATE, rel=1e-9)
    assert first.final.coordinates.size == first.state().coordinates.size == 0
    found = simulate(system, 9.0, state=first.final, stop_when=other > 9.0)
    bare = State(first.final.t, first.final.q, first.final.v)
    assert found.final.t == simulate(system, 9.0, state=bare, stop_when=other > 9.0).final.t
    begun = found.measure(other)
    assert np.abs(begun[0]) < np.pi and begun[-1] == pytest.approx(9.0, abs=1e-8)  # rtol of the run
    assert found.final.t - first.final.t == pytest.approx((9.0 - begun[0]) / RATE, rel=1e-7)


def test_a_condition_and_what_is_read_afterwards_are_one_angle():
    system, turn, _ = spinning()
    first = simulate(system, 9.0, stop_when=turn > 51.6)
    again = simulate(system, 20.0, state=first.final, stop_when=turn > 60.0)
    assert again.measure(turn)[-1] == pytest.approx(60.0, abs=1e-7)


def test_hinges_and_what_forces_read_count_on(tmp_path):
    """Their angles belong to the system; what a stepper measures besides does not."""
    body = Body("body", 1.0, (0.1, 0.2, 0.3), com=(0.1, 0, 0.05), position=(0.2, -0.1, 0.4))
    hinge = Revolute(GROUND, body, at=(0.1, 0.2, 0.3), axis=AXIS, name="hinge")
    system = System([body], [hinge], [TorsionSpring(hinge, stiffness=0.2)], gravity=(0, 0, 0))
    start = system.assemble(angles={hinge: 25.0}, rates={hinge: 12.0})
    turn = measures.turn(GROUND, body, about=AXIS)
    other = measures.angle_between(GROUND, body, axis_a=(1, 0, 0), axis_b=(0, 1, 0), about=AXIS)
    stepper = Stepper(system, state=start, measures=[turn])
    stepper.advance(1.0)
    assert stepper.state.coordinates.size == 1
    second = Stepper(system, state=stepper.state, measures=[other, turn])
    second.advance(1.5)
    plain = simulate(system, 1.5, state=start)
    assert second.state.coordinates[0] == pytest.approx(plain.angle(hinge)[-1], abs=1e-7)  # two runs of rtol 1e-8
    kept = load(stepper.solution().save(tmp_path / "run"))
    assert np.array_equal(kept.final.coordinates, stepper.state.coordinates)
