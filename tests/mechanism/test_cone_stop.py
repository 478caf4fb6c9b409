"""Cone stops: swing and twist against rotation vectors, energy, rest against statics, what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.models import direction, random_orientation
from scipy.spatial.transform import Rotation

from mbsd3d import (
    GROUND,
    Body,
    ConeStop,
    EndStop,
    Revolute,
    RotationStop,
    Spherical,
    System,
    Universal,
    accelerations,
    simulate,
)


def quaternion(turn):
    """Scalar first."""
    return turn.as_quat(scalar_first=True)


def load_after(swung, twisted, axis_b_off, **limits):
    """(moment on b, turns) where b has been twisted about its axis and then swung, about random axes."""
    rng = np.random.default_rng(3)
    a = Body("a", 1.0, (0.1, 0.1, 0.1), orientation=random_orientation(rng))
    axis_a = direction(rng)
    side = np.cross(axis_a, direction(rng))
    side /= np.linalg.norm(side)
    built = Rotation.from_rotvec(axis_b_off * side)
    axis_b = built.apply(axis_a)
    start = Body("b", 2.0, (0.2, 0.3, 0.25), com=(0.1, 0.0, 0.2), orientation=random_orientation(rng))
    whole = Rotation.from_rotvec(swung * side)
    twist = Rotation.from_rotvec(twisted * axis_a)
    turn = whole * twist * built.inv()  # back to the axis of a, twist, swing
    ball = Spherical(a, start, at=start.position)
    stop = ConeStop(ball, axis_a=axis_a, axis_b=axis_b, stiffness=7.0, name="stop", **limits)
    system = System([a, start], [ball], [stop], gravity=(0, 0, 0))
    state = system.state()
    q = state.q.copy()
    q[10:14] = quaternion(turn * Rotation.from_quat(start.orientation, scalar_first=True))
    now = accelerations(system, replace(state, q=q))
    z_b = (turn * built).apply(axis_a)
    return now.force("stop"), axis_a, z_b


@pytest.mark.parametrize("built", [0.0, 0.25])
@pytest.mark.parametrize(("swung", "twisted"), [(0.9, 0.5), (0.9, -1.8), (2.4, 2.9), (0.4, -0.3)])
def test_moments_are_those_of_swing_and_twist(built, swung, twisted):
    low, high, half = -0.7, 1.1, 0.6
    found, z_a, z_b = load_after(swung, twisted, built, half_angle=half, twist=(low, high))
    n = np.cross(z_a, z_b) / np.sin(swung)
    deep, over, under = max(swung - half, 0.0), max(twisted - high, 0.0), max(low - twisted, 0.0)
    moment = -7.0 * deep * n + 7.0 * (under - over) * (z_a + z_b) / (1.0 + np.cos(swung))
    assert found.moment[0] == pytest.approx(moment, abs=1e-12)  # rounding of moments of some N m
    assert found.stored[0] == pytest.approx(3.5 * (deep**2 + over**2 + under**2), abs=1e-12)


def test_a_swinging_and_spinning_body_keeps_what_it_does_not_lose():
    body = Body("arm", 1.4, (0.2, 0.3, 0.12), com=(0.1, 0.2, -0.4), omega=(2.0, 1.0, 3.0))
    ball = Spherical(GROUND, body, at=(0, 0, 0), name="ball")
    stop = ConeStop(
        ball, axis_a=body.centre, half_angle=0.5, twist=(-1.0, 2.0), stiffness=300.0, damping=1.5, name="stop"
    )
    run = simulate(System([body], [ball], [stop]), 4.0, rtol=1e-9, output=401)
    balance = run.energy().total - run.energy().work
    assert np.abs(balance - balance[0]).max() < 1e-7 and run.certificate.passed
    lost = -np.diff(run.work("stop"))
    assert lost.min() > -1e-9 and lost.sum() > 0.5  # it only takes energy, and does


def test_a_shaft_of_a_universal_joint_rests_on_its_cone():
    """Statics: m g l sin(angle) = k (angle - limit), the cone about the upright."""
    m, l, k, half = 3.0, 0.6, 900.0, 0.35
    shaft = Body("shaft", m, (0.4, 0.4, 0.02), com=(0, 0, l), omega=(0.2, 0.3, 0))
    joint = Universal(GROUND, shaft, at=(0, 0, 0), axis_a=(1, 0, 0), axis_b=(0, 1, 0))
    stop = ConeStop(joint, axis_a=(0, 0, 1), half_angle=half, stiffness=k, damping=60.0, name="stop")
    run = simulate(System([shaft], [joint], [stop]), 40.0, rtol=1e-9, output=2)
    up = run.rotation("shaft")[-1] @ (0, 0, 1)
    angle = np.arccos(up[2])
    assert m * 9.81 * l * np.sin(angle) == pytest.approx(k * (angle - half), rel=1e-6)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"half_angle": 3.2}, "half_angle = 3.2 limits nothing; give less than pi"),
        ({"half_angle": 0.0}, "half_angle: 0.0 is not positive"),
        ({"twist": (0.3, 0.1)}, "twist = (0.3, 0.1); give a lower and an upper limit less than a turn apart"),
        ({"twist": (-4.0, 4.0)}, "give a lower and an upper limit less than a turn apart"),
        ({"twist": 0.3}, "twist = 0.3; give (lower, upper) in rad"),
        ({"axis_b": (0, 0, -1)}, "axis_a and axis_b are opposite, so the swing has no direction; reverse one"),
    ],
)
def test_what_is_no_cone_is_refused(given, text):
    body = Body("arm", 1.4, (0.2, 0.3, 0.12))
    ball = Spherical(GROUND, body, at=(0, 0, 0))
    with pytest.raises(ValueError) as error:
        ConeStop(ball, name="cone", **({"axis_a": (0, 0, 1), "half_angle": 0.4, "stiffness": 10.0} | given))
    assert "force 'cone' (ConeStop)" in str(error.value) and text in str(error.value)


def test_a_hinge_does_not_swing_and_a_start_beyond_is_refused():
    body = Body("arm", 1.4, (0.2, 0.3, 0.12))
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1))
    with pytest.raises(ValueError, match="Revolute does not swing; give a Spherical, Universal or ConstantVelocity"):
        ConeStop(hinge, axis_a=(0, 0, 1), half_angle=0.4, stiffness=10.0)
    assert EndStop(hinge, upper=0.4, stiffness=10.0).upper == 0.4
    ball = Spherical(GROUND, body, at=(0, 0, 0))
    stop = ConeStop(ball, axis_a=(0, 0, 1), axis_b=(0, 1, 1), half_angle=0.4, stiffness=10.0, name="cone")
    with pytest.raises(ValueError, match=r"force 'cone' \(ConeStop\): the reference pose is 0.3854 beyond its limit"):
        simulate(System([body], [ball], [stop]), 1.0)


@pytest.mark.parametrize("turned", [0.3, 0.9, 3.0])
def test_a_rotation_stop_acts_against_the_rotation_vector(turned):
    """Of b relative to a as built, about any axis and however a stands; 0.6 rad are free."""
    rng = np.random.default_rng(5)
    a = Body("a", 1.0, (0.1, 0.1, 0.1), orientation=random_orientation(rng), omega=(0.3, 0.2, -0.1))
    b = Body("b", 2.0, (0.2, 0.3, 0.25), com=(0.1, 0.0, 0.2), orientation=random_orientation(rng))
    w, n = np.array([1.0, -0.4, 0.7]), direction(rng)
    ball = Spherical(a, b, at=b.position)
    stop = RotationStop(ball, angle=0.6, stiffness=7.0, damping=0.4, name="stop")
    system = System([a, b], [ball], [stop], gravity=(0, 0, 0))
    carried = Rotation.from_rotvec(1.7 * direction(rng))  # both bodies are turned, and then b alone
    q = system.state().q.copy()
    for place, turn in ((3, carried), (10, Rotation.from_rotvec(turned * n) * carried)):
        built = Rotation.from_quat(q[place : place + 4], scalar_first=True)
        q[place : place + 4] = quaternion(turn * built)
    v = np.concatenate([np.zeros(3), a.omega, np.zeros(3), a.omega + w])
    found = accelerations(system, replace(system.state(), q=q, v=v)).force("stop")
    depth, rate = max(turned - 0.6, 0.0), n @ w
    load = max(0.0, 7.0 * depth + 0.4 * rate) if depth else 0.0
    assert found.moment[0] == pytest.approx(-load * n, abs=1e-12)  # rounding of moments of some N m
    assert found.stored[0] == pytest.approx(3.5 * depth**2, abs=1e-12)


def test_a_body_stays_within_its_turn_and_comes_to_rest_on_the_stop():
    arm = Body("arm", 1.4, (0.2, 0.3, 0.12), com=(0.1, 0.2, -0.4), omega=(2.0, 1.0, 3.0))
    ball = Spherical(GROUND, arm, at=(0, 0, 0), name="ball")
    stop = RotationStop(ball, angle=0.5, stiffness=900.0, damping=30.0, name="stop")
    run = simulate(System([arm], [ball], [stop]), 3.0, rtol=1e-9, output=301)
    turns = Rotation.from_matrix(run.rotation(arm)).magnitude()
    assert 0.5 < turns.max() < 0.75 and run.certificate.passed, run.certificate
    lean = Body("lean", 2.0, (0.2, 0.2, 0.1), com=(0.0, 0.0, 0.5))
    pivot = Spherical(GROUND, lean, at=(0, 0, 0))
    hold = RotationStop(pivot, angle=0.4, stiffness=2e3, damping=200.0)
    rest = simulate(System([lean], [pivot], [hold], gravity=(0.6, 0.2, -9.8)), 8.0)
    turn = Rotation.from_matrix(rest.rotation(lean)[-1])
    weight = np.cross(turn.apply(lean.com.copy()), 2.0 * np.array([0.6, 0.2, -9.8]))
    assert np.allclose(weight, 2e3 * (turn.magnitude() - 0.4) * turn.as_rotvec() / turn.magnitude(), rtol=0, atol=1e-4)


@pytest.mark.parametrize(
    ("kind", "angle", "message"),
    [
        (Spherical, 3.2, "angle = 3.2 limits nothing; give less than pi"),
        (Spherical, -0.1, "angle"),
        (Revolute, 0.5, "Revolute does not swing; give a Spherical"),
    ],
)
def test_wrong_rotation_stops_are_refused(kind, angle, message):
    body = Body("arm", 1.0, (0.1, 0.1, 0.1))
    joint = kind(GROUND, body, at=(0, 0, 0), **({"axis": (0, 0, 1)} if kind is Revolute else {}))
    with pytest.raises(ValueError, match=message):
        RotationStop(joint, angle=angle, stiffness=1.0)
