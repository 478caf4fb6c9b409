"""Clutches that slip and lock, freewheels and ratchets: closed forms, events at one time, files, what is refused."""

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Clutch,
    Constant,
    Cylindrical,
    Freewheel,
    Prismatic,
    Ramp,
    Ratchet,
    Revolute,
    Sine,
    System,
    Torque,
    load,
    measures,
    rotation,
    simulate,
)  # fmt: skip
from mbsd3d.rotations import matrix

R = matrix(rotation((0.3, -0.5, 0.8), 1.1))
AXIS = R[:, 2]
PLACE = np.array([0.7, -1.3, 0.4])


def shaft(name, J, place, **motion):
    """Return a body with the moment J about AXIS, its centre of mass off its reference point, and its bearing."""
    inertia, position = R @ np.diag([0.7 * J, 0.6 * J, J]) @ R.T, PLACE + place * AXIS
    body = Body(name, 1.0, inertia, com=0.1 * AXIS, position=position, **motion)
    return body, Revolute(GROUND, body, at=body.position, axis=AXIS, name=f"bearing of {name}")


def test_a_clutch_brings_two_shafts_to_one_speed():
    one, first = shaft("one", 1.0, 0.0, omega=6.5 * AXIS)
    two, second = shaft("two", 2.0, 0.3, omega=(0, 0, 0))
    between = Cylindrical(one, two, at=PLACE, axis=AXIS, name="between")
    closes = measures.angle(first) > 3.25
    clutch = Clutch(between, torque=2.0, engage=closes, name="clutch")
    system = System([one, two], [first, second, between], [clutch], gravity=(0, 0, 0))
    run = simulate(system, 4.0, rtol=1e-11)
    closing, locking = run.events
    assert (closing.action, locking.action) == ("engages", "locks") and abs(closing.t - 0.5) < 1e-10
    assert abs(locking.t - closing.t - 2.1666666666666665) < 1e-9
    assert abs(run.rate(second)[-1] - 2.1666666666666665) < 1e-10
    at = int(np.searchsorted(run.t, locking.t))
    began = int(np.searchsorted(run.t, closing.t))
    assert abs(run.angle(between)[at] - run.angle(between)[began] + 7.041666666666667) < 1e-8
    assert abs(run.work(clutch)[-1] + 14.083333333333334) < 1e-8
    assert np.ptp(run.angle(between)[at:]) < 1e-12  # no creep
    load_on_two = run.force(clutch).moment @ AXIS
    some = (run.t > closing.t) & (run.t < locking.t)
    assert np.abs(load_on_two[some] - 2.0).max() < 1e-12 and abs(load_on_two[-1]) < 1e-12
    assert run.certificate.passed


def test_a_clutch_slips_where_its_load_exceeds_the_torque_and_is_released():
    """Torque 0.8 t on a disc that a clutch of 1.2 N m holds: it slips from 1.5 s on, and runs free at 1 rad."""
    J, T, k = 0.3, 1.2, 0.8
    disc, hinge = shaft("disc", J, 0.0)
    holds = Clutch(hinge, torque=T, engaged=True, release=measures.angle(hinge) > 1.0, name="brake")
    drive = Torque(disc, tuple(Ramp(k * x) for x in AXIS))
    system = System([disc], [hinge], [drive, holds], gravity=(0, 0, 0))
    run = simulate(system, 4.0, rtol=1e-11)
    slips, released = run.events
    assert (slips.action, released.action) == ("slips", "is released") and abs(slips.t - T / k) < 1e-10
    assert abs(run.force("brake").moment[0] @ AXIS) < 1e-12
    wanted = (6.0 * J * 1.0 / k) ** (1 / 3)  # J x = k (t - T/k)^3 / 6
    assert abs(released.t - slips.t - wanted) < 1e-9
    rate, t = run.rate(hinge)[-1], run.t[-1]
    after = (k * (t**2 - released.t**2) / 2 + k * wanted**2 / 2) / J
    assert abs(rate - after) < 1e-8 and run.certificate.passed


def lever_and_shaft(drive, J, torque, lock, **own):
    """Return a lever that is driven, a shaft that a load torque slows to rest, and a lock between both."""
    lever, first = shaft("lever", 0.1, 0.0)
    driven, second = shaft("shaft", J, 0.3)
    between = Cylindrical(lever, driven, at=PLACE, axis=AXIS, name="between")
    motor = AngleDriver(first, drive, name="motor")
    forces = [lock(between, name="lock", **own), Clutch(second, torque=torque, engaged=True, name="load")]
    system = System([lever, driven], [first, second, between, motor], forces, gravity=(0, 0, 0))
    return system, second


def test_a_freewheel_on_a_lever():
    A, w = 0.3, 10.0
    system, bearing = lever_and_shaft(Constant(A) + Sine(-A, w / 2 / np.pi, np.pi / 2), 0.2, 2.0, Freewheel)
    run = simulate(system, 3 * 2 * np.pi / w, state=system.assemble(), rtol=1e-11)
    own = [event for event in run.events if event.part == "lock"]
    assert abs(own[0].t - 0.19106332362490186) < 1e-9 and own[0].action == "runs free"
    assert abs(own[1].t - 0.6283185307179586) < 1e-9 and own[1].action == "locks, 'load' slips"
    assert abs(run.angle(bearing)[np.searchsorted(run.t, own[1].t)] - 0.8) < 1e-8
    assert abs(run.angle(bearing)[-1] - 2.4) < 1e-8
    assert run.angle("between").min() > -1e-9 and run.certificate.passed


def test_a_ratchet_loses_the_rest_of_each_stroke(tmp_path):
    stroke, w, n = 0.6, 10.0, 7
    back = Constant(-stroke / 2) + Sine(stroke / 2, w / 2 / np.pi, np.pi / 2)  # back first, then ahead
    system, bearing = lever_and_shaft(back, 0.2, 20.0, Ratchet, teeth=24)
    run = simulate(system, n * 2 * np.pi / w + 1e-3, state=system.assemble(), rtol=1e-10)
    assert abs(run.angle(bearing)[-1] - 3.6651914291880923) < 1e-8
    actions = [event.action.partition(",")[0] for event in run.events if event.part == "lock"]
    assert actions.count("passes a tooth") == 2 * n and actions.count("catches") == n
    caught = [event for event in run.events if event.impulses]
    assert all(event.lost > 0.1 for event in caught)
    assert run.certificate.passed  # with what the driver works in each impact
    other = load(run.save(tmp_path / "run"))
    assert str(other.certificate) == str(run.certificate)
    again = System.from_file(system.to_file(tmp_path / "ratchet.toml"))
    short = [simulate(x, 1.0, state=x.assemble()).angle("between") for x in (system, again)]
    assert np.array_equal(*short)


def test_a_freewheel_locks_at_once_against_a_rate():
    one, first = shaft("one", 1.0, 0.0, omega=6.5 * AXIS)
    two, second = shaft("two", 2.0, 0.3, omega=(0, 0, 0))
    between = Cylindrical(one, two, at=PLACE, axis=AXIS, name="between")
    system = System([one, two], [first, second, between], [Freewheel(between, name="pawl")], gravity=(0, 0, 0))
    run = simulate(system, 1.0)
    (event,) = run.events[:1]
    assert event.what == "'pawl' is struck at the start"
    assert abs(event.lost - 14.083333333333334) < 1e-12
    assert abs(event.impulses["pawl"].moment @ AXIS - 4.333333333333333) < 1e-12
    assert np.abs(run.rate(second)[1:] - 2.1666666666666665).max() < 1e-12 and run.certificate.passed


def test_what_is_refused():
    body, hinge = shaft("disc", 1.0, 0.0)
    rail = Prismatic(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1))
    with pytest.raises(ValueError, match="never closes; give engage=, or engaged=True"):
        Clutch(hinge, torque=1.0)
    with pytest.raises(ValueError, match="has no angle"):
        Ratchet(rail, teeth=12)
    with pytest.raises(ValueError, match=r"teeth = 2\.5 is not a whole number"):
        Ratchet(hinge, teeth=2.5)
    with pytest.raises(ValueError, match="torque"):
        Clutch(hinge, torque=0.0, engaged=True)
