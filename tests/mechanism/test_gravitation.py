"""Weight that turns with a body, and a near centre: against clouds of point masses and motions known otherwise."""

import numpy as np
import pytest
from helpers.models import direction, random_orientation
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from mbsd3d import GROUND, Body, CentralGravity, Revolute, SpeedDriver, System, Weight, accelerations, simulate

MU, COM = 3.7, (0.3, -0.2, 0.5)


def cloud(rng, count=9):
    """Masses and places about their centre of mass, and mass and inertia of them all."""
    masses, places = rng.uniform(0.5, 1.5, count), rng.normal(size=(count, 3))
    places -= masses @ places / masses.sum()
    squares = np.einsum("k,ki,kj->ij", masses, places, places)
    return masses, places, np.trace(squares) * np.eye(3) - squares


def pulls(masses, places, r):
    """Force and moment about the centre of mass of Newton's attraction of every mass by the origin."""
    at = r + places
    forces = -MU * (masses / np.linalg.norm(at, axis=1) ** 3)[:, None] * at
    return forces.sum(axis=0), np.cross(places, forces).sum(axis=0)


def test_a_body_is_pulled_as_its_masses_are_to_second_order():
    rng = np.random.default_rng(3)
    masses, places, inertia = cloud(rng)
    turn, way, centre = (
        Rotation.from_quat(random_orientation(rng), scalar_first=True),
        direction(rng),
        rng.normal(size=3),
    )
    errors = []
    for r in (200.0, 400.0):
        body = Body("cloud", masses.sum(), inertia, com=COM, orientation=turn.as_quat(scalar_first=True),
                    position=centre + r * way - turn.apply(COM))  # fmt: skip
        system = System([body], forces=[CentralGravity(GROUND, body, at=centre, mu=MU)], gravity=(0, 0, 0))
        found, world = accelerations(system), turn.apply(places)
        force, moment = pulls(masses, world, r * way)
        R = turn.as_matrix()
        alpha = np.linalg.solve(R @ inertia @ R.T, moment)
        a = found.acceleration(body)[0] + np.cross(found.alpha(body)[0], turn.apply(COM))
        point = -MU * way / r**2
        errors.append([np.abs(a - force / masses.sum()).max() / np.abs(a - point).max(),
                       np.abs(found.alpha(body)[0] - alpha).max() / np.abs(alpha).max()])  # fmt: skip
    assert np.max(errors[0]) < 0.05  # of the second order itself; the next one is s/r = 0.012 of it, times a few
    assert np.array(errors[0]) / errors[1] == pytest.approx([2, 2], rel=0.03)


def test_energy_momentum_and_files_of_two_bodies_that_attract(tmp_path):
    """A heavy centre and a long body on an eccentric way about it: U is what the certificate balances."""
    centre = Body("centre", 30.0, (2.0, 3.0, 4.0), position=(0.2, 0.1, 0), velocity=(0, -0.06, 0))
    rod = Body("rod", 2.0, (4.0, 3.9, 0.3), position=(12.0, 0, 1.0), velocity=(0, 0.75, 0.2), omega=(0.1, 0.4, 0.0))
    system = System([centre, rod], forces=[CentralGravity(centre, rod, at=(0.2, 0.1, 0), mu=6.0)], gravity=(0, 0, 0))
    run = simulate(system, 40.0, rtol=1e-11, output=101)
    assert run.certificate.passed
    energy = run.energy()
    assert np.ptp(energy.total) < 1e-9 * np.abs(energy.total).max() < np.ptp(energy.kinetic)
    again = System.from_file(system.to_file(tmp_path / "pair.json"))
    again = simulate(again, 40.0, rtol=1e-11, output=101)
    assert np.array_equal(again.position("rod"), run.position("rod"))


def test_a_stone_thrown_in_a_laboratory_that_turns_about_a_point_apart():
    """r'' = g - 2 w x r' - w x (w x r) in the laboratory."""
    rng = np.random.default_rng(6)
    rate, axis, place, thrown = 0.7, direction(rng), rng.normal(size=3), rng.normal(size=3)
    g, w, times = 9.0 * direction(rng), rate * axis, np.linspace(0, 2.0, 21)
    lab = Body("lab", 1.0, (1, 1, 1), omega=w, velocity=np.zeros(3))
    stone = Body("stone", 3.0, (1, 2, 2.5), position=place, velocity=thrown + np.cross(w, place))
    hold = [Revolute(GROUND, lab, at=(0, 0, 0), axis=axis), SpeedDriver(GROUND, lab, axis=axis, speed=rate)]
    run = simulate(System([lab, stone], hold, [Weight(lab, stone, acceleration=g)], gravity=(0, 0, 0)), 2.0,
                   rtol=1e-12, output=times)  # fmt: skip
    seen = np.einsum("tji,tj->ti", run.rotation("lab"), run.position("stone"))

    def own(_, y):
        return [*y[3:], *(g - 2 * np.cross(w, y[3:]) - np.cross(w, np.cross(w, y[:3])))]

    known = solve_ivp(own, (0, 2.0), [*place, *thrown], rtol=1e-12, atol=1e-12, t_eval=times, method="DOP853").y[:3].T
    assert run.certificate.passed and np.abs(seen - known).max() < 1e-8
    assert np.abs(known - place - np.outer(times, thrown) - 0.5 * np.outer(times**2, g)).max() > 0.1


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda body: Weight(body, GROUND, acceleration=(0, 0, -9.8), name="pull"), "is not a body; give a Body"),
        (lambda body: Weight(body, body, acceleration=(0, 0, -9.8), name="pull"), "give two different bodies"),
        (lambda body: CentralGravity(GROUND, body, at=(1, 2, 3), mu=0.0, name="pull"), "mu: 0.0 is not positive"),
        (lambda body: CentralGravity(GROUND, body, at=(1, 2, 5), mu=1.0, name="pull"), "lies in the centre"),
    ],
)
def test_errors_name_the_force_and_the_remedy(make, message):
    with pytest.raises(ValueError, match=f"force 'pull'.*{message}"):
        make(Body("stone", 2.0, (1, 1, 1), com=(1, 2, 5)))
