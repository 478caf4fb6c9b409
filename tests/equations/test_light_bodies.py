"""Bodies that weigh nothing beside others: accelerations and efforts against elimination in rational numbers."""

from fractions import Fraction

import numpy as np
import pytest

from mbsd3d import GROUND, AngleDriver, Body, Revolute, System, accelerations, simulate
from mbsd3d.extend import equations
from validation.cases.loops import FAMILIES, as_axes

LEAST = 1e-9  # of the largest acceleration or multiplier
MASSES = [(0.0, 0.0), (1e-12, 1e-15), (1e-9, 1e-12), (1e-6, 1e-9), (1e-3, 1e-6), (1e-3, 1e-3), (1.0, 1.0)]


def exact(K: np.ndarray, right: np.ndarray) -> np.ndarray:
    """x of K x = right, each number taken as the fraction it is."""
    rows = [[Fraction(float(x)) for x in (*row, y)] for row, y in zip(K, right, strict=True)]
    for i in range(len(rows)):
        pivot = max(range(i, len(rows)), key=lambda k: abs(rows[k][i]))
        rows[i], rows[pivot] = rows[pivot], rows[i]
        for k in range(len(rows)):
            if k != i and rows[k][i] != 0:
                factor = rows[k][i] / rows[i][i]
                rows[k] = [x - factor * y if y else x for x, y in zip(rows[k], rows[i], strict=True)]
    return np.array([float(row[-1] / row[i]) for i, row in enumerate(rows)])


def errors(system: System, state: object) -> tuple[float, float]:
    """Of accelerations and multipliers, over the largest."""
    found = accelerations(system, state)
    M, force, J, gamma, _ = equations(system, state)
    K = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
    x = exact(K, np.concatenate([force, gamma]))
    a, lam = np.ravel(found.arrays["acceleration"][0]), np.ravel(found.arrays["lam"][0])
    assert found.certificate.passed, found.certificate.failures
    n = len(force)
    return np.abs(a - x[:n]).max() / np.abs(x[:n]).max(), np.abs(lam - x[n:]).max() / np.abs(x[n:]).max()


def held(mass: float, inertia: float, far: float) -> System:
    """250 kg on a dummy body whose hinge on the ground is far away and held."""
    com = (0.02, -0.03, 0.01) if mass else (0, 0, 0)
    base = Body("base", mass, (inertia,) * 3, position=(0.3, 0.2, 0.1), com=com)
    frame = Body("frame", 250.0, (40.0, 55.0, 60.0), position=(1.0, 0.5, 0.4), com=(0.1, -0.2, 0.15))
    ground = Revolute(GROUND, base, at=(0.0, far, 0.0), axis=(0.2, 0.1, 1.0), name="ground hinge")
    hinge = Revolute(base, frame, at=(0.5, 0.3, 0.2), axis=(0.3, 1.0, 0.2), name="hinge")
    return System([base, frame], [ground, hinge, AngleDriver(ground, 0.0, name="hold")])


def chain(masses: tuple[float, ...]) -> System:
    """Links of general form on hinges along general axes."""
    bodies = [
        Body(f"link {k}", m, m * np.array([0.11, 0.12, 0.09]), com=(0.05, 0.02, 0.03),
             position=(0.5 + k, 0.1 * k, 0.05 * k))
        for k, m in enumerate(masses)
    ]  # fmt: skip
    hinges = [
        Revolute(bodies[k - 1] if k else GROUND, body, at=(k, 0.1 * k, 0.02), axis=(0.1 + 0.2 * k, 1.0, 0.3 * k),
                 name=f"h{k}")
        for k, body in enumerate(bodies)
    ]  # fmt: skip
    return System(bodies, hinges)


@pytest.mark.parametrize(("mass", "inertia"), MASSES)
@pytest.mark.parametrize("far", [2.0, 160.0])
def test_efforts_beside_dummy_bodies(mass, inertia, far):
    system = held(mass, inertia, far)
    assert max(errors(system, system.assemble(rates={"hinge": 0.7}))) < LEAST


@pytest.mark.parametrize("mass", [0.0, 1e-9, 1e-3])
def test_the_effort_does_not_depend_on_what_weighs_nothing(mass):
    """Of the held hinge: that of a massless dummy to what the dummy's weight and inertia may add at 160 m."""
    system, known = held(mass, 1e-3 * mass, 160.0), held(0.0, 0.0, 160.0)
    effort, exactly = (
        float(np.ravel(accelerations(x, x.assemble(rates={"hinge": 0.7})).effort("hold"))[0]) for x in (system, known)
    )
    assert abs(effort - exactly) < 1e-9 * abs(exactly) + 200.0 * 9.81 * mass


@pytest.mark.slow  # rational numbers of hundreds of digits
@pytest.mark.parametrize("ratio", [1e3, 1e6, 1e9, 1e12])
@pytest.mark.parametrize("order", ["up", "down", "heavy between", "light between"])
def test_mass_ratios_in_any_order(ratio, order):
    masses = {
        "up": (1.0, ratio),
        "down": (ratio, 1.0),
        "heavy between": (1.0, ratio, 1.0),
        "light between": (ratio, 1.0, ratio),
    }
    system = chain(masses[order])
    state = system.assemble(rates={f"h{k}": 0.5 + 0.2 * k for k in range(len(system.bodies))})
    assert max(errors(system, state)) < LEAST
    solution = simulate(system, 0.5, state=state, output=3)
    assert solution.certificate.passed, solution.certificate.failures
    assert solution.certificate.steps < 100  # equal masses take 10 to 30


def scaled(name: str, seed: int, k: int, factor: float) -> System:
    """A loop with link k lighter or heavier by a factor."""
    system = FAMILIES[name](np.random.default_rng([3, seed]))
    bodies = {body.name: body for body in system.bodies}
    old = system.bodies[k]
    com = old.com if factor else (0, 0, 0)
    bodies[old.name] = Body(old.name, factor * old.mass, factor * old.inertia, com=com, position=old.position,
                            orientation=old.orientation)  # fmt: skip
    hinges = [
        Revolute(bodies.get(j.a.name, GROUND), bodies.get(j.b.name, GROUND), at=j.at, axis=j.axis, name=j.name)
        for j in system.joints
    ]
    return System(list(bodies.values()), hinges, gravity=system.gravity)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1e-3, 1e-6, 1e-9, 1e-12, 0.0, 1e6, 1e9, 1e12])
@pytest.mark.parametrize("k", [0, 1, 2])
def test_light_and_heavy_links_in_a_loop(k, factor):
    system = scaled("bennett", 1, k, factor)
    solution = simulate(system, 0.5, state=system.assemble(rates={"hinge 1": 2.0}), output=6)
    angles = np.array([solution.angle(hinge) for hinge in system.joints]).T
    assert np.abs(angles - angles[0] - as_axes(system).motion(2.0, solution.t)).max() < 1e-6
    assert solution.certificate.passed, solution.certificate.failures
