"""What a certificate says of rounding: copies of a mechanism, turned in space, differ by as much."""

import numpy as np
import pytest

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    Body,
    Force,
    GeneralizedAlpha,
    Prismatic,
    RadauIIA,
    Revolute,
    Spherical,
    System,
    accelerations,
    simulate,
)
from mbsd3d.results.checks.rounding import units_of
from mbsd3d.rotations import matrix

COPIES = 8
ARM = np.array([1.2, -0.7, 1.4])  # m, from the ground to the load


def hung(mass, e, hinged):
    """A load of a ton on a light rod, turned as a whole by e; the rod between ball joints or behind a hinge."""
    R = matrix(e)
    rod = Body(
        "rod", mass, mass * np.diag([0.05, 0.3, 0.33]), com=(0.3, 0.1, -0.05), position=R @ (0.1 * ARM), orientation=e
    )
    load = Body("load", 1e3, (3.0, 4.0, 5.0), com=(0.1, 0.2, -0.3), position=R @ ARM, orientation=e)
    top = Revolute(GROUND, rod, at=(0, 0, 0), axis=R @ [0.3, 0.9, 0.2], name="top") if hinged else None
    joints = [top or Spherical(GROUND, rod, at=(0, 0, 0), name="top"), Spherical(rod, load, at=R @ ARM, name="ball")]
    return System([rod, load], joints, gravity=R @ [1.0, 2.0, -9.0])


def copies(mass, hinged):
    """(largest spread of an acceleration, of a force, both in the certificate's units; the certificates)."""
    rng, a, alpha, motion, forces, found = np.random.default_rng(5), 1.0, 1.0, [], [], []
    for _ in range(COPIES):
        e = rng.normal(size=4)
        e /= np.linalg.norm(e)
        now, R = accelerations(hung(mass, e, hinged)), matrix(e)
        v_dot = now.arrays["acceleration"][0]
        a, alpha = (a, alpha) if motion else units_of(now)[:2]  # largest components differ from copy to copy
        motion.append(np.hstack([v_dot[:, :3] @ R / a, v_dot[:, 3:] @ R / alpha]))
        forces.append(now.reaction("ball").force[0] @ R / np.linalg.norm(now.reaction("ball").force[0]))
        found.append(now.certificate)
    return (*(np.abs(np.array(x) - np.mean(x, axis=0)).max() for x in (motion, forces)), found)


@pytest.mark.parametrize("mass", [1.0, 1e-4, 1e-8, 1e-12])
def test_turned_copies_differ_by_what_the_certificate_says(mass):
    """The estimate is that of one rounding, the spread that of eight: both are known to a factor of some ten."""
    spread, _, found = copies(mass, hinged=False)
    said = max(certificate["accelerations"].error for certificate in found)
    assert said / 30 < spread < 30 * said


def test_reactions_beside_a_light_rod_are_right_though_it_spins_at_random():
    """A tenth of a microgram of rod under a ton: the rounding of 1e4 N turns it, and the certificate names it."""
    _, spread, found = copies(1e-12, hinged=False)
    assert spread < 1e-13 and all(certificate["reactions"].error < 1e-13 for certificate in found)  # rounding of 1e4 N
    failures = [text for certificate in found for text in certificate.failures]
    assert failures and all("rounding of the forces on body 'rod' moves it" in text for text in failures)


def test_a_light_rod_that_its_joints_move_costs_no_digits():
    spread, _, found = copies(1e-12, hinged=True)
    assert spread < 1e-12 and all(certificate.passed for certificate in found)  # rounding over a lever of a metre


def test_a_load_is_known_to_its_rounding():
    assert all(certificate.passed for certificate in copies(1.0, hinged=False)[2])


@pytest.mark.parametrize("method", [DOP853(), GeneralizedAlpha(), RadauIIA(dt=0.02), RK4(0.01)], ids=str)
def test_a_rail_that_carries_nothing_has_no_reactions_to_be_unsure_of(method):
    """Pushed along it through its centre of mass, without gravity: all reactions are rounding, as their changes are."""
    body = Body("sled", 1.7, (0.02, 0.03, 0.04), com=(0.1, -0.05, 0.07), position=(0.3, 0.2, 0.1))
    axis = np.array([0.3, 0.9, 0.2])
    rail = Prismatic(GROUND, body, at=(0, 0, 0), axis=axis, name="rail")
    push = Force(body, 4.0 * axis, body.position + body.com)
    run = simulate(System([body], [rail], [push], (0, 0, 0)), 1.0, method=method, output=21)
    assert run.slide(rail)[-1] == pytest.approx(0.5 * 4.0 * np.linalg.norm(axis) / 1.7, rel=1e-9)
    assert run.certificate.passed, run.certificate
