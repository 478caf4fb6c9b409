"""Rolling, skating, constant-velocity and screw joints against equations of motion written here."""

import numpy as np
import pytest
from models import across, consistent_state, direction, moved_reference, random_body, random_inertia, rolling_plane
from scipy.integrate import solve_ivp

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
    RollingDisc,
    Screw,
    Sine,
    State,
    System,
    Torque,
    accelerations,
    simulate,
)
from mbsd3d.rotations import matrix
from validation import reference_point

RTOL = 1e-11
ACCURACY = 1e-8
"""Two integrations of a motion of order one at 1e-11 or better; contact forces differ by 10 times as much."""


class Torus:
    """Newton and Euler about a contact point that never slips: one equation for w alone.

    With a = G - P, ``v_G = w x a``: (I + m [a]x'[a]x) w_dot = -w x I w - m a x (w x a_dot - g).
    """

    def __init__(self, disc, gravity):
        body = disc.b
        self.R0, self.mass, self.inertia = matrix(body.orientation), body.mass, body.inertia
        self.u, self.n = self.R0.T @ disc.axis, disc.plane[1]
        self.offset = body.com - self.R0.T @ (disc.centre - body.position)  # from the centre to G, body axes
        self.ring, self.crown, self.gravity = disc.radius - disc.crown, disc.crown, gravity

    def arm(self, R):
        """From the contact point to the centre of mass, for real or complex R."""
        u = R @ self.u
        level = np.cross(self.n, u)  # along the track
        up = np.cross(u, level)  # in the disc, away from the plane: |up| = |level| = sin of the tilt
        return R @ self.offset + self.ring * up / np.sqrt(level @ level) + self.crown * self.n

    def motion(self, R, w):
        """(w_dot, a_G, v of the centre of mass)."""
        spin = np.array([[0, -w[2], w[1]], [w[2], 0, -w[0]], [-w[1], w[0], 0]])
        a, a_dot = self.arm(R), self.arm(R + 1e-30j * spin @ R).imag / 1e-30
        inertia, cross = R @ self.inertia @ R.T, np.cross(np.eye(3), a)
        load = -np.cross(w, inertia @ w) - self.mass * np.cross(a, np.cross(w, a_dot) - self.gravity)
        w_dot = np.linalg.solve(inertia + self.mass * cross.T @ cross, load)
        return w_dot, np.cross(w_dot, a) + np.cross(w, a_dot), np.cross(w, a), spin

    def rates(self, _, y):
        """Of (R, w, position of G)."""
        R, w = y[:9].reshape(3, 3), y[9:12]
        w_dot, _, v, spin = self.motion(R, w)
        return np.concatenate([(spin @ R).ravel(), w_dot, v])


def torus(seed, crown, unbalanced=True):
    """(system, disc, state): a torus of any inertia in any attitude on any plane, with any velocities that roll."""
    rng = np.random.default_rng(seed)
    body = random_body(rng, "torus", com=0.1 * direction(rng))
    axis, radius = direction(rng), 0.5
    centre = body.position + matrix(body.orientation) @ body.com + (0.15 * direction(rng) if unbalanced else 0.0)
    plane = rolling_plane(rng, centre, axis, radius, crown)
    disc = RollingDisc(GROUND, body, axis=axis, radius=radius, crown=crown, centre=centre, plane=plane, name="disc")
    system = System([body], [disc], gravity=-9.7 * plane[1] + 2.0 * across(rng, plane[1]))
    return system, disc, consistent_state(system, rng)


@pytest.mark.parametrize("crown", [0.0, 0.13, 0.5])
@pytest.mark.parametrize("seed", range(4))
def test_accelerations_of_a_rolling_torus_in_generic_states(seed, crown):
    system, disc, state = torus(80 + seed, crown)
    other, found, body = Torus(disc, system.gravity), accelerations(system, state), disc.b
    w_dot, a_G, _, _ = other.motion(matrix(state.q[3:]), state.v[3:])
    # rounding times what a disc that lies nearly flat makes of it
    assert found.alpha(body)[0] == pytest.approx(w_dot, rel=1e-10, abs=1e-10 * np.abs(w_dot).max())
    force = body.mass * (a_G - system.gravity)
    assert found.reaction(disc).force[0] == pytest.approx(force, abs=1e-10 * np.abs(force).max())
    assert np.abs(found.reaction(disc).moment).max() < 1e-10 * np.abs(force).max()  # a force at the contact point


@pytest.mark.parametrize("crown", [0.0, 0.13])
def test_torus_rolls_on_an_inclined_plane_as_scipy_has_it(crown):
    system, disc, state = torus(91, crown)
    body, other = disc.b, Torus(disc, system.gravity)
    R = matrix(state.q[3:])
    start = np.concatenate([R.ravel(), state.v[3:], state.q[:3] + R @ body.com])
    solution = simulate(system, 1.5, state=state, rtol=RTOL, output=16)
    run = solve_ivp(other.rates, (0, 1.5), start, "DOP853", solution.t, rtol=1e-13, atol=1e-13)
    assert solution.rotation(body).reshape(-1, 9) == pytest.approx(run.y[:9].T, abs=ACCURACY)
    assert solution.omega(body) == pytest.approx(run.y[9:12].T, abs=10 * ACCURACY)
    assert solution.com(body) == pytest.approx(run.y[12:].T, abs=ACCURACY)
    assert np.ptp(solution.com(body), axis=0).max() > 0.3  # it has gone somewhere
    assert np.ptp(run.y[9:12], axis=1).min() > 0.1  # and turned over


def test_ablation_the_torus_feels_its_crown():
    system, disc, state = torus(80, 0.13)
    other = Torus(disc, system.gravity)
    w_dot = other.motion(matrix(state.q[3:]), state.v[3:])[0]
    other.ring, other.crown = 0.99 * other.ring, other.crown + 0.01 * other.ring
    assert np.abs(other.motion(matrix(state.q[3:]), state.v[3:])[0] - w_dot).max() > 1e-4 * np.abs(w_dot).max()


def bicycle(seed, crowns):
    """Frame, fork and two wheels with round tyres, leaning and steered, no axes parallel, on a general plane."""
    rng = np.random.default_rng(seed)
    z = direction(rng)
    x = across(rng, z)
    y, at = np.cross(z, x), rng.normal(size=3)
    wheels, discs, axles = [], [], []
    for name, place, radius, crown, axis in (
        ("rear", 0.0, 0.35, crowns[0], y + 0.2 * z + 0.05 * x), ("front", 1.0, 0.31, crowns[1], y + 0.3 * z - 0.3 * x)
    ):  # fmt: skip
        axis = axis / np.linalg.norm(axis)
        height = (radius - crown) * np.sqrt(1 - (axis @ z) ** 2) + crown
        centre = at + place * x + 0.07 * place * y + height * z
        wheel = random_body(rng, name, position=centre + 0.1 * direction(rng))
        wheels.append(wheel)
        axles.append((centre, axis))
        discs.append(RollingDisc(GROUND, wheel, axis=axis, radius=radius, crown=crown, centre=centre, plane=(at, z)))
    frame, fork = (random_body(rng, name, position=at + k * x + 0.8 * z) for name, k in (("frame", 0.3), ("fork", 0.8)))
    hub = [
        Revolute(body, wheel, at=centre, axis=axis)
        for body, wheel, (centre, axis) in zip((frame, fork), wheels, axles, strict=True)
    ]
    head = Revolute(frame, fork, at=at + 0.85 * x + 0.7 * z, axis=z - 0.4 * x + 0.1 * y, name="head")
    return System([frame, fork, *wheels], [*hub, head, *discs], gravity=-9.81 * z)


@pytest.mark.parametrize("crowns", [(0.0, 0.0), (0.02, 0.05), (0.35, 0.31)], ids=["edges", "tyres", "balls"])
@pytest.mark.parametrize("seed", range(3))
def test_bicycle_with_generic_wheels_in_generic_states(seed, crowns):
    """As Basu-Mandal, Chatterjee and Papadopoulos (2007) test theirs: accelerations at states nobody chose."""
    system = bicycle(100 + seed, crowns)
    found = system.check()
    assert (found.configuration_freedom, found.velocity_freedom) == (7, 3)
    state = consistent_state(system, np.random.default_rng(seed))
    expected = reference_point.solve(system, state)
    result = accelerations(system, state).arrays["acceleration"][0]
    # rounding times a condition of 1e5
    assert result == pytest.approx(expected.acceleration, abs=1e-10 * np.abs(expected.acceleration).max())


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


@pytest.mark.parametrize("bend", [0.2, 0.6, 1.1])
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
