"""Belts: frequency and decay, the limit of slip, bearings, crossed strands, planets, what is refused."""

from math import asin, pi, sin, tanh

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AngleDriver,
    Belt,
    Body,
    Pulse,
    Ramp,
    Revolute,
    System,
    Torque,
    linearize,
    measures,
    rotation,
    simulate,
)

AXIS = np.array([2.0, -1.0, 2.0]) / 3.0
ALONG = np.array([1.0, 2.0, 0.0]) / np.sqrt(5.0)  # from pulley to pulley


def drive(J1=0.01, R1=0.05, J2=0.2, R2=0.15, k=2e4, d=15.0, distance=0.6, sides=(1, 1), joints=(), forces=(), **belt):
    """Two pulleys with a belt; ``sides``: senses of the axes of their hinges."""
    turned = dict(orientation=rotation((1, -2, 1), 0.4))
    one = Body("one", 1.0, (J1, J1, J1), **turned)
    two = Body("two", 2.0, (J2, J2, J2), position=distance * ALONG, **turned)
    first = Revolute(GROUND, one, at=one.position, axis=sides[0] * AXIS, name="first")
    second = Revolute(GROUND, two, at=two.position, axis=sides[1] * AXIS, name="second")
    numbers = {"radii": (R1, R2), "stiffness": k, "damping": d, "pretension": 200.0} | belt
    loads = [Belt(first, second, name="belt", **numbers), *(make(one, two) for make in forces)]
    held = [make(first, second) for make in joints]
    return System([one, two], [first, second, *held], loads, gravity=(0, 0, 0))


@pytest.mark.parametrize("numbers", [{}, dict(J1=0.03, R1=0.12, J2=0.07, R2=0.09, k=9e3, d=8.0)])
@pytest.mark.parametrize("crossed", [False, True])
@pytest.mark.parametrize("sides", [(1, 1), (1, -1)])
def test_both_strands_make_frequency_and_decay(numbers, crossed, sides):
    given = dict(J1=0.01, R1=0.05, J2=0.2, R2=0.15, k=2e4, d=15.0) | numbers
    lever = given["R1"] ** 2 / given["J1"] + given["R2"] ** 2 / given["J2"]
    decay, square = given["d"] * lever, 2.0 * given["k"] * lever
    system = drive(**given, crossed=crossed, sides=sides)
    found = linearize(system, system.state()).eigenvalues
    expected = complex(-decay, np.sqrt(square - decay**2))
    assert min(abs(found - expected)) < 1e-8 * abs(expected)
    assert sorted(abs(found))[1] < 1e-6  # it turns freely as a whole


@pytest.mark.parametrize(("crossed", "sides", "way"), [
    (False, (1, 1), 1), (True, (1, 1), -1), (False, (1, -1), -1), (True, (-1, 1), 1),
])  # fmt: skip
def test_the_ratio_is_that_of_the_radii(crossed, sides, way):
    system = drive(crossed=crossed, sides=sides, d=60.0, joints=[lambda first, second: AngleDriver(first, Ramp(30.0))])
    run = simulate(system, 3.0, rtol=1e-9, output=4)
    assert run.angle("second")[-1] == pytest.approx(way * 90.0 / 3.0, abs=1e-7)  # fourteen turns of the first


@pytest.mark.parametrize(("mu", "phi", "F", "R1", "R2"), [(0.4, 2.8, 200.0, 0.05, 0.15), (0.25, 2.2, 90.0, 0.2, 0.31)])
def test_slip_is_reported_beyond_eytelweins_torque(mu, phi, F, R1, R2):
    """2 F R1 tanh(mu phi / 2): the certificate passes below and fails above, and names the belt."""
    distance, most = (R2 - R1) / sin(0.5 * (pi - phi)), 2.0 * F * R1 * tanh(0.5 * mu * phi)
    held = [lambda first, second: AngleDriver(second, 0.0)]
    for share in (0.99, 1.01):
        parts = [Pulse(share * most * x, start=0.0, edge=2.0) for x in AXIS]
        load = [lambda one, two, parts=parts: Torque(one, parts)]
        system = drive(R1=R1, R2=R2, d=60.0, distance=distance, pretension=F, mu=mu, joints=held, forces=load)
        rest = simulate(system, 4.0, rtol=1e-10, output=101)
        belt = system.forces[0]
        tensions, wraps = rest.force("belt").tension[-1:], belt.wraps(rest.force("belt").wrap[-1:])
        assert wraps[0] == pytest.approx([phi, 2 * pi - phi], abs=1e-9)
        assert tensions[0, 1] - tensions[0, 0] == pytest.approx(share * most / R1, rel=1e-8)
        assert rest.certificate.passed == (share < 1.0)
        assert rest.certificate["grip of belts"].error == pytest.approx(share, abs=0.004)
    assert "'belt' slips on its pulley" in str(rest.certificate.failures)


def test_bearings_carry_the_strands():
    """At rest both pulleys are drawn together by both strands, along their tangents."""
    F, R1, R2, distance = 170.0, 0.05, 0.15, 0.6
    run = simulate(drive(pretension=F), 0.1, output=2)
    pulled = run.reaction("first").force[-1]
    assert pulled == pytest.approx(-2.0 * F * np.cos(asin((R2 - R1) / distance)) * ALONG, abs=1e-9)
    crossed = simulate(drive(pretension=F, crossed=True), 0.1, output=2)
    assert crossed.reaction("second").force[-1] == pytest.approx(
        2.0 * F * np.cos(asin((R2 + R1) / distance)) * ALONG, abs=1e-9
    )


def test_a_strand_gets_slack_and_only_the_other_one_pulls():
    F, k, d, R1 = 50.0, 2e4, 60.0, 0.05
    load = [lambda one, two: Torque(one, tuple(8.0 * AXIS))]
    held = [lambda first, second: AngleDriver(second, 0.0)]
    run = simulate(drive(pretension=F, k=k, d=d, joints=held, forces=load), 3.0, rtol=1e-10, output=4)
    tension = run.force("belt").tension[-1]
    assert tension == pytest.approx([0.0, 8.0 / R1], rel=1e-8) and not np.signbit(tension).any()
    assert run.angle("first")[-1] == pytest.approx((8.0 / R1 - F) / k / R1, rel=1e-8)
    assert run.certificate.passed


@pytest.mark.parametrize(("strand", "way", "value"), [(1, 1, 330.0), (0, -1, 71.0)])
def test_a_run_stops_at_the_tension_of_a_strand(strand, way, value):
    """F plus or minus what the turn of the first pulley stretches: k R theta + d R omega."""
    F, k, d, R1, turning = 200.0, 2e4, 15.0, 0.05, 0.37
    held = [lambda first, second: AngleDriver(first, Ramp(turning)), lambda first, second: AngleDriver(second, 0.0)]
    system = drive(pretension=F, k=k, d=d, R1=R1, joints=held)
    tension = measures.tension(system.forces[0], strand)
    run = simulate(system, 3.0, rtol=1e-9, stop_when=tension > value if way > 0 else tension < value)
    expected = (abs(value - F) - d * R1 * turning) / (k * R1 * turning)
    assert run.t[-1] == pytest.approx(expected, rel=1e-8)
    assert run.measure(tension)[-1] == pytest.approx(value, abs=1e-6)


def test_a_planet_on_an_arm_that_turns_round():
    """From a pulley fixed to the ground to one on an arm: w_planet / w_arm = 1 - R_sun / R_planet, many turns."""
    R_sun, R_planet = 0.12, 0.05
    arm = Body("arm", 1.0, (0.1, 0.1, 0.1), com=0.2 * ALONG)
    planet = Body("planet", 0.5, (0.002, 0.002, 0.002), position=0.5 * ALONG)
    centre = Revolute(GROUND, arm, at=(0, 0, 0), axis=AXIS, name="centre")
    sun = Revolute(arm, GROUND, at=(0, 0, 0), axis=AXIS)
    pin = Revolute(arm, planet, at=planet.position, axis=AXIS, name="pin")
    belt = Belt(sun, pin, radii=(R_sun, R_planet), stiffness=1e4, damping=20.0, pretension=300.0)
    turning = AngleDriver(centre, Ramp(8.0))
    with_sun = System([arm, planet], [centre, pin, turning, sun], [belt], gravity=(0, 0, 0))
    run = simulate(with_sun, 4.0, rtol=1e-9, output=5)
    assert run.angle("pin")[-1] == pytest.approx(-32.0 * R_sun / R_planet, abs=1e-6)  # seen from the arm
    assert run.force(belt).tension[-1] == pytest.approx([300.0, 300.0], abs=1e-4)


@pytest.mark.parametrize(("given", "message"), [
    ({"R1": 0.5, "R2": 1.2}, "one pulley lies inside the other"),
    ({"R1": 0.4, "R2": 0.3, "crossed": True}, "one pulley lies inside the other"),
    ({"radii": (0.1,)}, "radii = .*; give two numbers above 0"),
    ({"radii": (0.1, -0.1)}, "radii = .*; give two numbers above 0"),
    ({"mu": 0.0}, "mu: 0.0 is not positive"),
])  # fmt: skip
def test_what_is_refused(given, message):
    with pytest.raises(ValueError, match=message):
        drive(**given)
