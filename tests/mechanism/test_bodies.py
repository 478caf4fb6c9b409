"""Skating, constant-velocity and screw joints against closed forms."""

import numpy as np
import pytest
from helpers.models import across, direction, moved_reference, random_body, random_inertia

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    ConstantVelocity,
    KnifeEdge,
    Planar,
    PointOnPlane,
    Ramp,
    Revolute,
    Screw,
    Sine,
    State,
    System,
    Torque,
    accelerations,
    simulate,
)
from mbsd3d.rotations import matrix

RTOL = 1e-11
ACCURACY = 1e-8
"""Two integrations of a motion of order one at 1e-11 or better; contact forces differ by 10 times as much."""


def skater(rng, ahead):
    """(system, normal, blade direction, moment of inertia about the normal through G, blade): in a general plane."""
    normal = direction(rng)
    blade = across(rng, normal)
    body = random_body(rng, "skater")
    G = body.position + matrix(body.orientation) @ body.com
    edge = KnifeEdge(GROUND, body, at=G - ahead * blade, lateral=np.cross(normal, blade), name="blade")
    R = matrix(body.orientation)
    moment = normal @ R @ body.inertia @ R.T @ normal
    return body, G, normal, blade, moment, [Planar(GROUND, body, at=G, normal=normal), edge]


def test_skate_on_a_slope_drifts_sideways():
    """From rest with spin w: g' sin(wt)^2 / (2 w^2) down, g' (wt - sin(2wt)/2) / (2 w^2) across (Neimark, Fufaev)."""
    rng, w, pull = np.random.default_rng(95), 2.3, 3.1
    body, G, normal, blade, _, joints = skater(rng, 0.0)
    system = System([body], joints, gravity=pull * blade - 7.0 * normal)  # the blade points down the slope
    q = np.concatenate([body.position, body.orientation])
    v = np.concatenate([np.cross(w * normal, body.position - G), w * normal])
    solution = simulate(system, 4.0, state=State(0.0, q, v), rtol=RTOL, output=21)
    turn = w * solution.t
    way = solution.com(body) - G
    assert way @ blade == pytest.approx(pull / (2 * w**2) * np.sin(turn) ** 2, abs=ACCURACY)
    drift = pull / (2 * w**2) * (turn - np.sin(2 * turn) / 2)
    assert way @ np.cross(normal, blade) == pytest.approx(drift, abs=ACCURACY)
    assert drift[-1] > 2.0


def test_chaplygin_sleigh():
    """G ahead of the blade by a: v = V tanh(k t + c), w = sqrt(V k / a) sech(k t + c), k = m a V / (I + m a^2)."""
    rng, a, V, phase = np.random.default_rng(96), 0.4, 1.7, -1.1
    body, G, normal, blade, moment, joints = skater(rng, a)
    k = body.mass * a * V / (moment + body.mass * a**2)

    def motion(t):
        return V * np.tanh(k * t + phase), np.sqrt(V * k / a) / np.cosh(k * t + phase)

    v0, w0 = motion(0.0)
    edge = G - a * blade
    v = np.concatenate([v0 * blade + np.cross(w0 * normal, body.position - edge), w0 * normal])
    system = System([body], joints, gravity=(0, 0, 0))
    start = State(0.0, np.concatenate([body.position, body.orientation]), v)
    solution = simulate(system, 4.0, state=start, rtol=RTOL, output=21)
    forward, spin = motion(solution.t)
    ahead, side = (solution.body_axis(body, x) for x in (blade, np.cross(normal, blade)))
    assert solution.omega(body) == pytest.approx(np.outer(spin, normal), abs=ACCURACY)
    at = solution.velocity(body) + np.cross(
        solution.omega(body), solution.body_point(body, edge) - solution.position(body)
    )
    assert at == pytest.approx(forward[:, None] * ahead, abs=ACCURACY)
    assert forward[0] < 0 < forward[-1]  # pushed backwards it turns round
    force = body.mass * spin * forward * (1 - body.mass * a**2 / (moment + body.mass * a**2))  # m (v w + a w_dot)
    assert solution.reaction("blade").force == pytest.approx(force[:, None] * side, abs=10 * ACCURACY)


RATE = 11.0


def shaft(rng, name, at, axis, moment):
    """A body of revolution about ``axis`` with its centre of mass on it, from a general O."""
    body = random_body(rng, name, position=at, com=(0, 0, 0))
    spin = matrix(body.orientation).T @ axis
    inertia = moment * (0.9 * np.eye(3) + 0.1 * np.outer(spin, spin))
    return moved_reference(
        Body(name, body.mass, inertia, position=at, orientation=body.orientation), 0.2 * direction(rng)
    )


def test_constant_velocity_joint_is_one_while_its_bend_changes():
    """(w_b - w_a) . (e_a + e_b) = 0 gives equal rates for any bend and any rate of bending."""
    rng = np.random.default_rng(97)
    n = direction(rng)
    a = across(rng, n)
    bend = 0.35
    b = np.cos(bend) * a + np.sin(bend) * np.cross(n, a)
    at = rng.normal(size=3)
    first, arm = shaft(rng, "first", at - 0.5 * a, a, 0.1), random_body(rng, "arm", position=at + 0.3 * n)
    second = shaft(rng, "second", at + 0.6 * b, b, 0.2)
    drive = Revolute(GROUND, first, at=at - 0.7 * a, axis=a, name="drive")
    swing = Revolute(GROUND, arm, at=at, axis=n, name="swing")
    seat = Revolute(arm, second, at=at + 0.4 * b, axis=b, name="seat")

    class Bisector(ConstantVelocity):
        """The one row that couples the turning; the bearings hold the centre already."""

        def rows(self):
            return super().rows()[1:]

    joint = Bisector(first, second, at=at, axis_a=a, axis_b=b, name="joint")
    amplitude = 0.5
    motors = [AngleDriver(drive, Ramp(RATE)), AngleDriver(swing, Sine(amplitude, 0.7))]
    system = System([first, arm, second], [drive, swing, seat, joint, *motors], [Torque(second, (0.3, -0.2, 0.5))])
    solution = simulate(system, 1.3, rtol=RTOL, output=27)
    assert solution.angle(seat) == pytest.approx(RATE * solution.t, abs=1e-9)  # 15 rad
    assert np.ptp(solution.angle(swing)) > amplitude


@pytest.mark.parametrize("bend", [0.004, 0.2, 0.6, 1.1])
def test_constant_velocity_joint_passes_torque_with_the_couple_of_the_textbook(bend):
    """Its moment lies along the bisector of the shafts: T / cos(bend / 2), with T tan(bend / 2) across each shaft."""
    rng = np.random.default_rng(98)
    n = direction(rng)
    a = across(rng, n)
    b = np.cos(bend) * a + np.sin(bend) * np.cross(n, a)
    at = rng.normal(size=3)
    first, second = shaft(rng, "first", at - 0.5 * a, a, 0.1), shaft(rng, "second", at + 0.6 * b, b, 0.2)
    drive = Revolute(GROUND, first, at=at - 0.7 * a, axis=a, name="drive")
    joint = ConstantVelocity(first, second, at=at, axis_a=a, axis_b=b, name="joint")
    # the far end of the second shaft on its line: 5 + 4 + 2 rows
    guides = [PointOnPlane(GROUND, second, at=at + b, normal=x) for x in (n, np.cross(n, b))]
    torque = 4.0
    loads = [Torque(first, torque * a), Torque(second, -1.5 * b)]
    system = System([first, second], [drive, joint, *guides], loads, gravity=(0, 0, 0))
    state = system.assemble(rates={drive: RATE})
    found = accelerations(system, state)
    alpha = (torque - 1.5) / (0.1 + 0.2)
    assert found.alpha("first")[0] == pytest.approx(alpha * a, abs=1e-9)  # of 1e2 rad/s^2
    assert found.alpha("second")[0] == pytest.approx(alpha * b, abs=1e-9)
    passed = torque - 0.1 * alpha
    moment = found.reaction(joint).moment[0]
    bisector = (a + b) / np.linalg.norm(a + b)
    assert moment == pytest.approx(passed / np.cos(bend / 2) * bisector, abs=1e-9)
    assert np.linalg.norm(np.cross(b, moment)) == pytest.approx(passed * np.tan(bend / 2), abs=1e-9)


def test_screw_press():
    """Spindle on a bearing, nut kept from turning: (J + m p^2) theta_ddot = T - m p g.u; force and torque F p of it."""
    rng = np.random.default_rng(99)
    u, at = direction(rng), rng.normal(size=3)
    pitch, torque, J = 0.4, 1.9, 0.3
    p = pitch / (2 * np.pi)
    spindle = shaft(rng, "spindle", at + 0.2 * u, u, J)
    nut = random_body(rng, "nut", position=at + 0.6 * direction(rng))
    nut = Body("nut", nut.mass, random_inertia(rng, nut.mass), com=nut.com, position=nut.position)
    bearing = Revolute(GROUND, spindle, at=at, axis=u)
    thread = Screw(spindle, nut, at=at + 0.3 * u, axis=u, pitch=pitch, name="thread")
    side = across(rng, u)
    key = PointOnPlane(GROUND, nut, at=at + 0.3 * u + 0.5 * side, normal=np.cross(u, side), name="key")
    system = System([spindle, nut], [bearing, thread, key], [Torque(spindle, torque * u)], gravity=(0.4, -0.7, -9.6))
    solution = simulate(system, 1.2, rtol=RTOL, output=7)
    pull = nut.mass * system.gravity @ u
    alpha = (torque - p * pull) / (J + nut.mass * p**2)  # the spindle turns forwards, the nut goes back
    assert solution.alpha("spindle") == pytest.approx(np.tile(alpha * u, (7, 1)), abs=ACCURACY)
    way = -p * alpha * solution.t**2 / 2
    assert solution.com(nut) - solution.com(nut)[0] == pytest.approx(np.outer(way, u), abs=ACCURACY)
    held = solution.reaction(thread)
    force = -nut.mass * p * alpha - pull
    assert held.force @ u == pytest.approx(np.full(7, force), abs=ACCURACY * 10)
    # torque about the axis: on the nut it is -p times the axial force (no friction)
    about = held.moment + np.cross(held.point - at, held.force)
    assert about @ u == pytest.approx(np.full(7, -p * force), abs=ACCURACY * 10)
