"""Discs and wheels with round rims that roll on any plane, against Newton and Euler and a second formulation."""

import numpy as np
import pytest
from helpers.models import across, consistent_state, direction, random_body, rolling_plane
from scipy.integrate import solve_ivp

from mbsd3d import GROUND, Revolute, RollingDisc, System, accelerations, simulate
from mbsd3d.rotations import matrix
from validation.twins.definitions import equations as reference_point

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


@pytest.mark.parametrize("crown", [pytest.param(0.0, marks=pytest.mark.slow), 0.13])
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
