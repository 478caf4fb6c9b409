"""Linear actuators: closed forms of the way to their rate, rest on their stops, energy, what is refused."""

import numpy as np
import pytest

from mbsd3d import GROUND, Body, LinearActuator, Prismatic, Pulse, Revolute, System, simulate

WAY = np.array([1.0, -2.0, 2.0]) / 3.0


def sled(mass=5.0, speed=0.0, **given):
    """A sled on a slanted rail, and an actuator along the rail, 0.7 m long as built."""
    at = np.array([0.4, 0.1, -0.2])
    body = Body("sled", mass, (0.1, 0.2, 0.25), com=(0.1, 0.2, -0.1), position=at, velocity=speed * WAY)
    rail = Prismatic(GROUND, body, at=at, axis=WAY, name="rail")
    numbers = {"thrust": 20.0, "stroke": (0.5, 1.4), "stiffness": 2e4, "damping": 300.0} | given
    ram = LinearActuator(GROUND, body, at_a=at - 0.7 * WAY, at_b=at, name="ram", **numbers)
    return System([body], [rail], [ram], gravity=(0, 0, 0))


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_it_comes_to_its_rate(way):
    run = simulate(sled(thrust=20.0 * way, rate=0.3, stroke=(0.1, 9.0)), 1.0, rtol=1e-11, output=11)
    decay = 20.0 / (5.0 * 0.3)  # m v' = T (1 - v / v0)
    assert run.rate("rail") * way == pytest.approx(0.3 * (1.0 - np.exp(-decay * run.t)), abs=1e-9)
    assert run.slide("rail") * way == pytest.approx(0.3 * (run.t - (1.0 - np.exp(-decay * run.t)) / decay), abs=1e-9)


def test_it_never_gives_more_than_its_thrust():
    back = simulate(sled(speed=-0.4, rate=0.3, stroke=(0.1, 9.0)), 0.05, rtol=1e-11, output=2)
    assert back.rate("rail")[-1] == pytest.approx(-0.4 + 20.0 / 5.0 * 0.05, abs=1e-10)
    fast = simulate(sled(speed=0.9, rate=0.3, stroke=(0.1, 9.0)), 0.05, rtol=1e-11, output=2)
    assert fast.rate("rail")[-1] == pytest.approx(0.9 - 20.0 / 5.0 * 0.05, abs=1e-10)  # braked, beyond twice v0
    free = simulate(sled(stroke=(0.1, 9.0)), 0.2, rtol=1e-11, output=2)
    assert free.slide("rail")[-1] == pytest.approx(0.5 * 4.0 * 0.04, abs=1e-11)  # no rate: T at all rates


@pytest.mark.parametrize(("way", "end"), [(1.0, 0.7), (-1.0, -0.2)])
def test_it_rests_on_the_stop_at_the_end_of_its_stroke(way, end):
    run = simulate(sled(thrust=20.0 * way, rate=0.5), 6.0, rtol=1e-9, output=601)
    assert run.slide("rail")[-1] == pytest.approx(end + way * 20.0 / 2e4, abs=1e-8)
    found = run.force("ram")
    assert found.length[-1] == pytest.approx(0.7 + end + way * 1e-3, abs=1e-8)
    assert np.linalg.norm(found.force[-1]) < 1e-4  # the stop carries the thrust
    assert found.stored[-1] == pytest.approx(0.5 * 2e4 * 1e-6, rel=1e-4)
    balance = run.energy().total - run.energy().work
    assert np.abs(balance - balance[0]).max() < 1e-8 and run.certificate.passed


def test_a_boom_is_lifted_and_let_down():
    """Extends against the weight, holds at its stop, and sinks when the thrust goes."""
    boom = Body("boom", 20.0, (0.5, 6.0, 6.0), com=(0.8, 0, 0.05))
    pin = Revolute(GROUND, boom, at=(0, 0, 0), axis=(0, -1, 0), name="pin")
    ends = dict(at_a=(0.3, 0.0, -0.5), at_b=(0.7, 0, 0))
    stroke = (0.5, 0.75)
    ram = LinearActuator(GROUND, boom, **ends, thrust=Pulse(1500.0, start=0.0, edge=0.1, duration=4.0), rate=0.2,
                         stroke=stroke, stiffness=4e5, damping=6e3, name="ram")  # fmt: skip
    run = simulate(System([boom], [pin], [ram]), 9.0, rtol=1e-8, output=901)
    length = run.force("ram").length
    assert stroke[1] < length[380] < stroke[1] + 1500.0 / 4e5
    assert stroke[0] - 1500.0 / 4e5 < length[-1] < stroke[0] and abs(run.rate("pin")[-1]) < 1e-4
    assert run.certificate.passed


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"stroke": (0.9, 0.5)}, "stroke = (0.9, 0.5); give the shortest and the longest length, both above 0"),
        ({"stroke": (0.0, 0.5)}, "give the shortest and the longest length"),
        ({"stroke": (0.5,)}, "give the shortest and the longest length"),
        ({"rate": 0.0}, "rate: 0.0 is not positive"),
        ({"thrust": "full"}, "thrust is 'full'"),
    ],
)
def test_what_is_no_actuator_is_refused(given, text):
    with pytest.raises(ValueError) as error:
        sled(**given)
    assert "force 'ram' (LinearActuator)" in str(error.value) and text in str(error.value)


def test_a_start_beyond_the_stroke_is_refused():
    with pytest.raises(ValueError, match="the reference pose is 0.2 beyond its limit"):
        simulate(sled(stroke=(0.9, 1.4)), 1.0)
