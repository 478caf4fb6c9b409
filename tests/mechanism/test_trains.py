"""Planetary trains and a differential against Willis' equation, Lagrange's equations and statics."""

import json

import numpy as np
import pytest
from helpers.gears import ALPHA, BETA, Frame, rotor, torque

from mbsd3d import GROUND, Gear, GearMesh, Revolute, System, accelerations, simulate
from mbsd3d.files.description import describe, read_system


def planetary(mesh):
    """(frame, bodies, joints): sun and carrier on the ground, planet on the carrier, ring fixed to the ground.

    Meshes by `GearMesh` with ``carrier=``, or by `Gear` on hinges relative to the carrier.
    """
    frame = Frame(5)
    sun, planet = rotor("sun", frame.at(0, 0, 0), frame.z, 0.02), rotor("planet", frame.at(0.3, 0, 0), frame.z, 0.03)
    arm, ring = rotor("carrier", frame.at(0.1, 0.05, 0), frame.z, 0.2), rotor("ring", frame.at(0, 0, 0), frame.z, 0.5)
    on = Revolute(arm, planet, at=frame.at(0.3, 0, 0), axis=frame.z, name="planet bearing")
    if mesh:
        shafts = [Revolute(GROUND, x, at=frame.at(0, 0, 0.1), axis=frame.z) for x in (sun, arm, ring)]
        at = [frame.at(0.1, 0, 0), frame.at(0.5, 0, 0)]
        meshes = [
            GearMesh(shafts[0], on, at=at[0], pressure_angle=ALPHA, carrier=arm),
            GearMesh(on, shafts[2], at=at[1], pressure_angle=ALPHA, carrier=arm),
        ]
        return frame, [sun, arm, ring, planet], [*shafts, on, *meshes]
    shafts = [Revolute(arm, x, at=frame.at(0, 0, 0.1), axis=frame.z) for x in (sun, ring)]
    main = Revolute(GROUND, arm, at=frame.at(0, 0, 0.1), axis=frame.z)
    meshes = [Gear(shafts[0], on, ratio=-0.1 / 0.2), Gear(on, shafts[1], ratio=0.2 / 0.5)]
    return frame, [sun, arm, ring, planet], [*shafts, main, on, *meshes]


MASS = 1.3


@pytest.mark.parametrize("mesh", [True, False], ids=["GearMesh", "Gear"])
def test_planetary_train_accelerates_as_willis_and_lagrange_say(mesh):
    """Free coordinates sun s and ring r: carrier c = (0.1 s + 0.5 r) / 0.6, planet p = c - (0.1/0.2)(s - c)."""
    frame, bodies, joints = planetary(mesh)
    torques = np.array([7.0, -3.0, 2.0])  # on sun, carrier, ring
    loads = [torque(body, frame.z, value) for body, value in zip(bodies, torques, strict=False)]
    found = accelerations(System(bodies, joints, loads, gravity=(0, 0, 0)))
    c = np.array([0.1, 0.5]) / 0.6
    B = np.array([[1, 0], c, [0, 1], c - 0.5 * (np.array([1, 0]) - c)])  # rates of the four bodies from (s, r)
    carrier = 0.2 + MASS * (0.1**2 + 0.05**2) + MASS * 0.3**2  # about the main axis, with the planet's mass
    expected = B @ np.linalg.solve(B.T @ np.diag([0.02, carrier, 0.5, 0.03]) @ B, B[:3].T @ torques)
    for body, alpha in zip(bodies, expected, strict=True):
        assert found.alpha(body)[0] == pytest.approx(alpha * frame.z, abs=1e-8)  # of 100 rad/s^2


def test_planet_bearing_carries_both_tooth_forces():
    frame, bodies, joints = planetary(True)
    # stationary speeds, balanced torques: sun T, ring T 5, carrier -6 T
    loads = [torque(b, frame.z, k * 12.0) for b, k in zip(bodies, (1, -6, 5), strict=False)]
    system = System(bodies, joints, loads, gravity=(0, 0, 0))
    state = system.assemble(rates={joints[0]: 20.0, joints[2]: -3.0})
    solution = simulate(system, 0.5, state=state, rtol=1e-10, output=6)
    spin = (0.1 * 20.0 - 0.5 * 3.0) / 0.6
    assert solution.omega("carrier") == pytest.approx(np.tile(spin * frame.z, (6, 1)), abs=1e-7)
    F_t = 12.0 / 0.1
    angle = spin * solution.t
    out = np.outer(np.cos(angle), frame.x) + np.outer(np.sin(angle), frame.y)
    turn = np.outer(np.cos(angle), frame.y) - np.outer(np.sin(angle), frame.x)
    # radial parts of both meshes cancel, the tangential ones add; plus the planet's centripetal force
    expected = -2 * F_t * turn - MASS * 0.3 * spin**2 * out
    assert solution.reaction("planet bearing").force == pytest.approx(expected, abs=1e-5 * F_t)  # integrated


def test_planet_in_a_ring_that_is_the_ground():
    """Carrier w, planet w (1 - 0.5/0.2): T = (I_c + m 0.3^2 + I_p 1.5^2) w_dot; the ring takes the tooth force."""
    frame, (_, arm, _, planet), _ = planetary(True)
    main = Revolute(GROUND, arm, at=frame.at(0, 0, 0.1), axis=frame.z, name="main")
    on = Revolute(arm, planet, at=frame.at(0.3, 0, 0), axis=frame.z, name="planet bearing")
    mesh = GearMesh(on, main, at=frame.at(0.5, 0, 0), pressure_angle=ALPHA, helix_angle=BETA, name="ring")
    system = System([arm, planet], [main, on, mesh], [torque(arm, frame.z, 9.0)], gravity=(0, 0, 0))
    run = simulate(system, 0.8, rtol=1e-11, output=5)
    carrier = 0.2 + MASS * (0.1**2 + 0.05**2) + MASS * 0.3**2
    alpha = 9.0 / (carrier + 0.03 * 1.5**2)
    assert run.angle(main) == pytest.approx(alpha * run.t**2 / 2, abs=1e-8)
    assert run.omega(planet) == pytest.approx(np.outer(-1.5 * alpha * run.t, frame.z), abs=1e-8)
    angle = alpha * run.t**2 / 2
    turn = np.outer(np.cos(angle), frame.y) - np.outer(np.sin(angle), frame.x)
    # on the ring: what accelerates the planet about its own axis, -0.03 * 1.5 alpha / 0.2, the other way
    assert np.einsum("ti,ti->t", run.reaction(mesh).force, turn) == pytest.approx(
        np.full(5, 0.03 * 1.5 * alpha / 0.2), abs=1e-7
    )
    assert mesh.b is GROUND and run.reaction(mesh).point == pytest.approx(
        run.reaction(mesh).point[:1] + 0.5 * (np.outer(np.cos(angle) - 1, frame.x) + np.outer(np.sin(angle), frame.y)),
        abs=1e-8,
    )


def test_bevel_differential_shares_torque_and_averages_rates():
    """Cage rate = mean of the wheels' rates; with one spider gear of inertia J about its own axis."""
    frame = Frame(6)
    cage = rotor("cage", frame.at(0, 0, 0), frame.x, 0.3)
    left, right = (rotor(name, frame.at(s, 0, 0), frame.x, 0.1) for name, s in (("left", -0.2), ("right", 0.2)))
    spider = rotor("spider", frame.at(0, 0, 0), frame.z, 0.01)
    main = Revolute(GROUND, cage, at=frame.at(0, 0, 0), axis=frame.x)
    sides = [Revolute(cage, x, at=frame.at(0, 0, 0), axis=frame.x) for x in (left, right)]
    pin = Revolute(cage, spider, at=frame.at(0, 0, 0), axis=frame.z)
    gears = [Gear(pin, sides[0], ratio=1.0), Gear(pin, sides[1], ratio=-1.0)]
    loads = [torque(cage, frame.x, 9.0), torque(left, frame.x, -2.0), torque(right, frame.x, 1.0)]
    found = accelerations(System([cage, left, right, spider], [main, *sides, pin, *gears], loads, gravity=(0, 0, 0)))
    # rates: left = c + p, right = c - p, spider c across its axis (0.8 of 0.01) and p about it
    alpha = 8.0 / (0.3 + 0.2 + 0.008), -3.0 / (0.2 + 0.01)
    for body, value in ((cage, alpha[0]), (left, alpha[0] + alpha[1]), (right, alpha[0] - alpha[1])):
        assert found.alpha(body)[0] == pytest.approx(value * frame.x, abs=1e-9)


def test_a_mesh_survives_its_description_and_a_table():
    frame, bodies, joints = planetary(True)
    system = System(bodies, joints, [torque(bodies[0], frame.z, 3.0)])
    again = System.of(read_system(json.loads(json.dumps(describe(system))))[0])
    first, second = (accelerations(x).arrays for x in (system, again))
    assert np.array_equal(first["acceleration"], second["acceleration"])
    assert again.joints[-1].carrier is again.bodies[1]
    names = accelerations(system).to_xarray()
    assert names.sizes["joint"] == 6
