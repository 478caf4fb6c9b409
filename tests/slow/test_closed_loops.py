"""Overconstrained loops in general position: any masses, inertias, centres of mass and base poses, all methods."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from mbsd3d import RK4, AngleDriver, GeneralizedAlpha, Kinematic, Revolute, Solution, System, simulate
from mbsd3d.extend import matrix
from mbsd3d.signals import Ramp
from validation.cases.loops import FAMILIES, as_axes
from validation.cases.mechanisms import four_bars
from validation.suite.trials.closed_forms import rods_frequency
from validation.theory import pendulum_motion

pytestmark = pytest.mark.slow

COUNTS = {"bennett": 200} | dict.fromkeys([name for name in FAMILIES if name != "bennett"], 20)
TRUE = {"bennett": 12, "goldberg": 3, "myard": 3, "bricard_line": 3, "bricard_plane": 3, "sarrus": 2, "schatz": 3}
RTOL = 1e-8  # the default
ERROR = 5e-6  # model lengths and radians at the default rtol of 1e-8; of 320 loops two err by more than 1e-6
RATE, T_END = 2.0, 1.5  # rad/s of the first hinge, s
LOOPS = [(name, seed) for name, count in COUNTS.items() for seed in range(count)]
JUDGED = [(name, seed) for name, count in TRUE.items() for seed in range(count)]


@cache
def loop(name: str, seed: int) -> System:
    return FAMILIES[name](np.random.default_rng([len(name), seed]))


@cache
def truth(name: str, seed: int) -> np.ndarray:
    """(16, n) angles of the hinges."""
    return as_axes(loop(name, seed)).motion(RATE, np.linspace(0.0, T_END, 16))


def turned(solution: Solution, hinges: Any) -> np.ndarray:
    angles = np.array([solution.angle(hinge) for hinge in hinges]).T
    return angles - angles[0]


def run(name: str, seed: int, t_end: float = T_END, output: int = 16, **options: Any) -> Solution:
    system = loop(name, seed)
    return simulate(system, t_end, state=system.assemble(rates={"hinge 1": RATE}), output=output, **options)


@pytest.mark.parametrize(("name", "seed"), LOOPS)
def test_every_loop_passes_whatever_is_written_out(name, seed):
    """Samples of one run are interpolated between steps that do not know of them; a run at 1e-11 judges both."""
    hinges = loop(name, seed).joints
    tight = run(name, seed, 3.0, 301, rtol=1e-11)
    few, many = run(name, seed, 3.0, 61), run(name, seed, 3.0, 101)
    for solution in (tight, few, many):
        assert solution.certificate.passed, solution.certificate.failures
    assert few.certificate.steps == many.certificate.steps
    known, one, other = (turned(solution, hinges) for solution in (tight, few, many))
    assert np.abs(one[::3] - other[::5]).max() < 1e-13
    assert max(np.abs(one - known[::5]).max(), np.abs(other - known[::3]).max()) < ERROR


@pytest.mark.parametrize(("name", "seed"), JUDGED)
def test_the_error_falls_with_the_tolerance(name, seed):
    """Against the product of exponentials; 1e-9 is rounding, amplified where a loop comes near a singular position."""
    errors = []
    for rtol in (1e-5, 1e-7, 1e-9, 1e-11):
        solution = run(name, seed, rtol=rtol)
        assert solution.certificate.passed, (rtol, solution.certificate.failures)
        errors.append(np.abs(turned(solution, loop(name, seed).joints) - truth(name, seed)).max())
        assert errors[-1] < max(300 * rtol, 1e-9)
    assert errors[3] < max(1e-3 * errors[0], 1e-9)


@pytest.mark.parametrize(("name", "seed"), [pair for pair in JUDGED if pair[1] == 1])
@pytest.mark.parametrize(("method", "limit"), [(RK4(dt=2e-3), 3e-5), (GeneralizedAlpha(dt=1e-3), 1e-3)])
def test_fixed_steps(name, seed, method, limit):
    """Fourth order of 2e-3 s at up to 10 rad/s, second order of 1e-3 s."""
    solution = run(name, seed, method=method)
    assert solution.certificate.passed, solution.certificate.failures
    assert np.abs(turned(solution, loop(name, seed).joints) - truth(name, seed)).max() < limit


@pytest.mark.parametrize(("name", "seed"), [pair for pair in JUDGED if pair[1] < 2])
def test_driven_loops_follow_their_geometry(name, seed):
    """Kinematic and DOP853 on a driven hinge against the closed poses of the truth at the same angle."""
    system = loop(name, seed)
    driven = System(system.bodies, [*system.joints, AngleDriver(system.joints[0], Ramp(0.3))], gravity=system.gravity)
    known, times = truth(name, seed), np.linspace(0.0, 1.0, 11)
    solutions = [simulate(driven, 1.0, method=method, output=11) for method in (Kinematic(), None)]
    for solution in solutions:
        assert solution.certificate.passed, solution.certificate.failures
        assert np.abs(turned(solution, system.joints)[:, 0] - 0.3 * times).max() < 1e-9
    first, second = (turned(solution, system.joints) for solution in solutions)
    assert np.abs(first - second).max() < ERROR
    k = int(np.argmax(known[:, 0] > 0.15))  # a pose of the free motion, reached again by the driver at its own time
    again = simulate(driven, known[k, 0] / 0.3, method=Kinematic(), output=3)
    assert np.abs(turned(again, system.joints)[-1] - known[k]).max() < 1e-9


def moved_four_bars(n: int, seed: int, reach: float = 0.3) -> System:
    """The n four-bars with every reference point somewhere else, up to ``reach`` [m] in each axis of its body."""
    rng, base, moved = np.random.default_rng(seed), four_bars(n), {}
    for body in base.bodies:
        shift = rng.uniform(-reach, reach, 3)
        arm = matrix(body.orientation) @ shift
        moved[body.name] = replace(
            body, position=body.position + arm, com=-shift, velocity=body.velocity + np.cross(body.omega, arm)
        )
    hinges = [
        Revolute(moved.get(joint.a.name, joint.a), moved[joint.b.name], at=joint.at, axis=joint.axis, name=joint.name)
        for joint in base.joints
    ]
    return System(list(moved.values()), hinges, gravity=base.gravity)


@pytest.mark.parametrize("n", [1, 2, 5, 10, 20, 40])
@pytest.mark.parametrize(
    ("seed", "rtol", "limit"), [(0, 1e-8, ERROR), (1, 1e-8, ERROR), (2, 1e-10, 1e-8), (15, 1e-11, 2e-8)]
)
def test_four_bars_from_any_reference_points(n, seed, rtol, limit):
    """Through the poses in which all rods lie on one line, and never onto another branch.

    Of 240 runs at 1e-10 and 1e-11 none errs by more than 2e-8; rounding near that pose is what they have in common.
    """
    system = moved_four_bars(n, seed)
    solution = simulate(system, 3.0, output=31, rtol=rtol)
    known = pendulum_motion(solution.t, rods_frequency(n), np.pi, -1.0)[0]
    assert np.abs(turned(solution, system.joints[: n + 1]) - (known - known[0])[:, None]).max() < limit
    assert solution.certificate.passed, solution.certificate.failures
