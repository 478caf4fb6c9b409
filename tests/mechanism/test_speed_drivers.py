"""Speed drivers on hinges, sliders and points: the speed they keep, the effort they take, the slips they name."""

import numpy as np
import pytest
from helpers.models import direction, middle, random_body
from scipy.spatial.transform import Rotation

from mbsd3d import (
    GROUND,
    Body,
    Cylindrical,
    Parallel,
    Prismatic,
    Ramp,
    Revolute,
    SpeedDriver,
    Spherical,
    System,
    linearize,
    simulate,
)

KEPT = 1e-10  # velocities are projected onto the rows to rounding at every sample


def pin(a, b):
    return Revolute(a, b, at=(0, 0, 0), axis=(0, 0, 1), name="pin")


def pair(seed=3):
    rng = np.random.default_rng(seed)
    return rng, random_body(rng, "a"), random_body(rng, "b")


def test_a_hinge_turns_at_its_speed_both_ways():
    rng, a, b = pair()
    at, axis = middle(rng, a, b), direction(rng)
    ground = Spherical(GROUND, a, at=a.position + 0.2 * direction(rng))
    hinge = Revolute(a, b, at=at, axis=axis, name="hinge")
    speed = Ramp(1.5, 0.4)
    one = System([a, b], [ground, hinge, SpeedDriver(hinge, speed, name="motor")])
    two = System([a, b], [ground, hinge, SpeedDriver(a, b, axis=axis, speed=speed, name="motor")])
    first, second = (simulate(system, 0.5, output=11) for system in (one, two))
    assert first.rate(hinge) == pytest.approx(speed(first.t), abs=KEPT)
    assert np.array_equal(first.position(b), second.position(b))
    assert np.array_equal(first.effort("motor"), second.effort("motor"))


def test_a_slider_moves_at_its_speed():
    rng, a, b = pair(4)
    swing = Revolute(GROUND, a, at=a.position + 0.3 * direction(rng), axis=direction(rng))
    rail = Prismatic(a, b, at=middle(rng, a, b), axis=direction(rng), name="rail")
    speed = Ramp(0.4, -0.3)
    system = System([a, b], [swing, rail, SpeedDriver(rail, speed, name="ram")])
    run = simulate(system, 0.6, output=13, rtol=1e-10)
    assert run.rate(rail) == pytest.approx(speed(run.t), abs=KEPT)
    assert run.slide(rail) == pytest.approx([-0.3 * t + 0.2 * t**2 for t in run.t], abs=1e-8)
    assert run.certificate.passed
    assert "[N]" in run.plot("effort").axes[0].get_ylabel()
    drift = run.energy().total - run.energy().work
    assert np.ptp(drift) < 1e-7 * np.ptp(run.energy().total)


def test_a_point_moves_along_a_direction_of_its_body():
    """A free body tows a ball: the velocity of its hook along its own axis, by scipy's rotations."""
    rng, a, b = pair(5)
    ahead, hook = direction(rng), a.position + 0.4 * direction(rng)
    tow = Spherical(a, b, at=hook)
    system = System([a, b], [tow, SpeedDriver(GROUND, a, at=hook, direction=ahead, speed=0.7, name="drive")])
    run = simulate(system, 0.5, output=11)
    R = Rotation.from_quat(run.orientation(a), scalar_first=True).as_matrix()
    R = R @ Rotation.from_quat(a.orientation, scalar_first=True).as_matrix().T
    v = run.velocity(a) + np.cross(run.omega(a), R @ (hook - a.position))
    assert np.einsum("ti,ti->t", v, R @ ahead) == pytest.approx(0.7, abs=KEPT)
    assert run.certificate.passed
    own = System([a], [SpeedDriver(GROUND, a, direction=ahead, speed=0.1)]).joints[0]
    assert np.array_equal(own.at, a.centre)


def test_effort_of_a_ram_is_mass_times_acceleration():
    block = Body("block", 3.0, (0.1, 0.1, 0.1))
    rail = Prismatic(GROUND, block, at=(0, 0, 0), axis=(0.6, 0, 0.8), name="rail")
    run = simulate(System([block], [rail, SpeedDriver(rail, Ramp(2.0), name="ram")]), 0.5, output=3)
    assert run.effort("ram") == pytest.approx(3.0 * (2.0 + 9.81 * 0.8), abs=1e-10)
    assert run.work("ram")[-1] == pytest.approx(run.energy().total[-1], rel=1e-8)


def test_a_constant_speed_is_a_steady_motion():
    cart = Body("cart", 2.0, (0.1, 0.2, 0.2), velocity=(0.5, 0, 0))
    bob = Body("bob", 1.0, (0.01, 0.01, 0.01), position=(0, 0, -0.5), velocity=(0.5, 0, 0))
    rail = Prismatic(GROUND, cart, at=(0, 0, 0), axis=(1, 0, 0))
    pin = Revolute(cart, bob, at=(0, 0, 0), axis=(0, 1, 0))
    found = linearize(System([cart, bob], [rail, pin, SpeedDriver(rail, 0.5)]))
    swing = np.sqrt(9.81 * 0.5 / (0.01 + 0.25))
    assert np.abs(found.eigenvalues.imag).max() == pytest.approx(swing, rel=1e-12)


def test_files_keep_them(tmp_path):
    rng, a, b = pair()
    c = random_body(rng, "c")
    hinge = Revolute(GROUND, a, at=a.position, axis=(1, 2, 2), name="hinge")
    rail = Prismatic(GROUND, b, at=b.position, axis=(1, 2, -2), name="rail")
    drivers = [
        SpeedDriver(hinge, 2.0, name="one"),
        SpeedDriver(rail, Ramp(1.0), name="two"),
        SpeedDriver(a, c, at=(0.1, 0.2, 0.3), direction=(0, 1, 1), speed=0.1, name="three"),
    ]
    system = System([a, b, c], [hinge, rail, *drivers])
    text = system.to_file(tmp_path / "model.json").read_text()
    assert '"name": "one", "speed"' in text and '"joint": "hinge"' in text
    again = System.from_file(tmp_path / "model.json")
    for old, new in zip(system.joints, again.joints, strict=True):
        assert [row.kind for row in old.rows()] == [row.kind for row in new.rows()]
    assert np.array_equal(system.state().v, again.state().v)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda a, b, nut, rod: SpeedDriver(nut, 1.0), r"'nut' \(Cylindrical\) has an angle and a slide; .* in m/s"),
        (lambda a, b, nut, rod: SpeedDriver(rod, 1.0), r"'rod' \(Spherical\) has neither angle nor slide"),
        (lambda a, b, nut, rod: SpeedDriver(a, b, speed=1.0), "neither axis nor direction; give axis= for .* rad/s"),
        (lambda a, b, nut, rod: SpeedDriver(a, b, axis=(1, 0, 0), direction=(1, 0, 0), speed=1.0), "both axis and"),
        (lambda a, b, nut, rod: SpeedDriver(a, b, axis=(1, 0, 0)), "no speed; give speed= in rad/s"),
        (
            lambda a, b, nut, rod: SpeedDriver(a, b, axis=(1, 0, 0), at=(0, 0, 0), speed=1.0),
            "a rotation needs no point",
        ),
        (lambda a, b, nut, rod: SpeedDriver(a, 3.0, axis=(1, 0, 0), speed=1.0), "b = 3.0 is not a body"),
        (lambda a, b, nut, rod: SpeedDriver(joint=a, speed=1.0), "has neither angle nor slide"),
        (lambda a, b, nut, rod: SpeedDriver(pin(a, b), 1.0, speed=2.0), "two speeds, 1.0 and 2.0; give one"),
        (
            lambda a, b, nut, rod: SpeedDriver(pin(a, b), 1.0, axis=(1, 0, 0)),
            "axis = .*, but 'pin' says what moves; leave it out",
        ),
        (lambda a, b, nut, rod: SpeedDriver(pin(a, b), 1.0, at=(1, 0, 0)), "at = .*, but 'pin' says what moves"),
    ],
)
def test_slips_are_named(make, message):
    _, a, b = pair()
    nut = Cylindrical(a, b, at=(0, 0, 0), axis=(0, 0, 1), name="nut")
    with pytest.raises(ValueError, match=message):
        make(a, b, nut, Spherical(a, b, at=(0, 0, 0), name="rod"))


def test_a_driver_of_a_joint_needs_it_in_the_system():
    _, a, _ = pair()
    hinge = Revolute(GROUND, a, at=a.position, axis=(1, 2, 2), name="hinge")
    with pytest.raises(ValueError, match="its joint 'hinge' is not in the system; add it to joints"):
        System([a], [Parallel(GROUND, a, axis=(1, 2, 2)), SpeedDriver(hinge, 1.0)])
