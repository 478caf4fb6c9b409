"""Forces and torques between two bodies: momentum stays, and each body moves as the load says."""

import numpy as np
import pytest
from helpers.models import direction, random_body

from mbsd3d import GROUND, Force, ForceBetween, Sine, System, Torque, TorqueBetween, accelerations, simulate


def pair():
    rng = np.random.default_rng(4)
    return random_body(rng, "one"), random_body(rng, "two"), rng


@pytest.mark.parametrize("frame", ["world", "a", "b"])
def test_momentum_and_angular_momentum_stay(frame):
    a, b, rng = pair()
    loads = (Sine(0.8, 0.4, 0.3), 1.2, -0.4)
    forces = [
        ForceBetween(a, b, loads, at=b.position + direction(rng), frame=frame, name="force"),
        TorqueBetween(a, b, (0.3, Sine(0.5, 0.7), -0.2), frame=frame, name="torque"),
    ]
    run = simulate(System([a, b], forces=forces, gravity=(0, 0, 0)), 3.0, rtol=1e-9, output=31)
    momentum = run.momentum()
    for values in (momentum.linear, momentum.angular):
        assert np.abs(values - values[0]).max() < 1e-8  # rtol times momenta of some units
    gained = run.energy().kinetic - run.energy().kinetic[0]
    assert gained == pytest.approx(run.work("force") + run.work("torque"), abs=1e-8)
    assert np.abs(gained).max() > 0.1 and run.certificate.passed


@pytest.mark.parametrize("frame", ["world", "body"])
def test_from_the_ground_it_is_a_force_or_torque(frame):
    _, b, rng = pair()
    loads, at = (0.8, 1.2, -0.4), b.position + direction(rng)
    own = "b" if frame == "body" else "world"
    between = [ForceBetween(GROUND, b, loads, at=at, frame=own), TorqueBetween(GROUND, b, loads, frame=own)]
    alone = [Force(b, loads, at=at, frame=frame), Torque(b, loads, frame=frame)]
    found, truth = (accelerations(System([b], forces=forces)) for forces in (between, alone))
    assert found.acceleration(b) == pytest.approx(truth.acceleration(b), abs=1e-13)
    assert found.alpha(b) == pytest.approx(truth.alpha(b), abs=1e-13)


def test_both_ends_are_read_at_one_point():
    a, b, rng = pair()
    push = ForceBetween(a, b, (0.8, 1.2, -0.4), at=b.position + direction(rng), name="push")
    run = simulate(System([a, b], forces=[push]), 0.5, output=3)
    on_b, on_a = run.force(push), run.force(push, on=a)
    assert on_a.force == pytest.approx(-on_b.force, abs=1e-14) and on_a.point == pytest.approx(on_b.point, abs=1e-14)
    assert np.abs(on_a.moment).max() < 1e-13 and np.abs(on_b.moment).max() < 1e-13


def test_files_keep_it(tmp_path):
    a, b, rng = pair()
    system = System([a, b], forces=[TorqueBetween(a, b, (0, 0.3, Sine(1.0, 2.0)), frame="a", name="motor")])
    system.to_file(tmp_path / "model.toml")
    again = System.from_file(tmp_path / "model.toml").forces[0]
    assert again.frame == "a" and again.torque[2] == Sine(1.0, 2.0)


def test_what_is_no_pair_is_refused():
    a, _, _ = pair()
    with pytest.raises(ValueError, match="acts between 'one' and itself; give two different bodies"):
        ForceBetween(a, a, (0, 0, 1))
    with pytest.raises(ValueError, match="frame 'body' is unknown; give 'world' or 'a' or 'b'"):
        TorqueBetween(GROUND, a, (0, 0, 1), frame="body")
