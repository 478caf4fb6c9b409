"""The truth for loops against what is known of a loop in closed form; the loops against the truth."""

import numpy as np
import pytest

from mbsd3d import simulate
from mbsd3d.extend import matrix
from validation.cases.loops import FAMILIES, as_axes
from validation.theory import HingeLoop, pendulum_motion, rotation_matrix

QUICK = {"bennett": 2, "goldberg": 1, "bricard_line": 1, "schatz": 1}


def parallelogram() -> tuple[HingeLoop, float]:
    """Four parallel hinges in a tilted plane under weight, and the frequency of the pendulum that it is."""
    R = np.asarray(rotation_matrix(np.array([0.9, 0.1, -0.3, 0.2]) / np.sqrt(0.95)), float)
    flat = np.array([[0.0, 0, 0.3], [0.0, -1, -0.1], [0.7, -1, 0.2], [0.7, 0, 0.0]])  # hangs along -y of the plane
    points, axes = flat @ R.T, np.tile(R[:, 2], (4, 1))
    masses, centres = np.array([1.2, 0.8, 0.7]), np.array([[0.0, -0.4, 0.2], [0.3, -1.0, 0.1], [0.7, -0.7, -0.2]])
    inertias = np.array([R @ np.diag(x) @ R.T for x in ([0.2, 0.1, 0.15], [0.1, 0.2, 0.25], [0.12, 0.05, 0.1])])
    turning = 0.15 + 1.2 * 0.16 + 0.8 * 1.0 + 0.1 + 0.7 * 0.49
    moment = 1.2 * 0.4 + 0.8 * 1.0 + 0.7 * 0.7  # of the weight, per g
    return HingeLoop(points, axes, masses, centres @ R.T, inertias, -9.81 * R[:, 1]), np.sqrt(9.81 * moment / turning)


@pytest.mark.parametrize("rate", [2.0, 20.0])
def test_a_parallelogram_is_a_pendulum(rate):
    """It swings to and fro (2 rad/s, not through the poses on one line) as elliptic functions say."""
    loop, frequency = parallelogram()
    times = np.linspace(0.0, 2.0 if rate < 5 else 0.06, 9)
    turned, (angle, _) = loop.motion(rate, times), pendulum_motion(times, frequency, 0.0, rate)
    assert np.abs(turned - np.outer(angle, [1, -1, 1, -1])).max() < 1e-11


def test_bennetts_angles_obey_his_equation():
    """tan(theta_1 / 2) tan(theta_2 / 2) is the same all along the motion, opposite angles are."""
    system = FAMILIES["bennett"](np.random.default_rng(3))
    x, y = (matrix(body.orientation)[:, 0] for body in system.bodies[:2])
    first, second = system.joints[0].axis, system.joints[1].axis
    turned = as_axes(system).motion(2.0, np.linspace(0.0, 1.5, 7))
    assert np.abs(turned[:, 2] + turned[:, 0]).max() < 1e-11 and np.abs(turned[:, 3] + turned[:, 1]).max() < 1e-11
    ground = np.cross(system.joints[3].axis, first)  # along the common normal of the ground link
    theta = [np.arctan2(axis @ np.cross(a, b), a @ b) for axis, a, b in ((first, ground, x), (second, x, y))]
    for sign in (0.0, np.pi):  # of the ground's common normal
        product = np.tan(0.5 * (theta[0] + sign + turned[:, 0])) * np.tan(0.5 * (theta[1] + turned[:, 1]))
        if np.ptp(product) < 1e-10:
            return
    pytest.fail("no sense of the ground's common normal gives a constant product")


def test_it_refuses_what_has_not_one_freedom():
    loop, _ = parallelogram()
    axes = loop.axes.copy()
    axes[0] = axes[0] + 0.1 * np.array([1.0, 0.3, -0.2])
    stiff = HingeLoop(loop.points, axes / np.linalg.norm(axes, axis=1)[:, None], loop.masses, loop.centres,
                      loop.inertias, loop.gravity)  # fmt: skip
    with pytest.raises(ValueError, match="rank 4; one degree of freedom needs 3"):
        stiff.motion(1.0, [0.0, 1.0])


@pytest.mark.parametrize(("name", "seed"), [(name, seed) for name, count in QUICK.items() for seed in range(count)])
def test_a_loop_moves_as_its_axes_say(name, seed):
    """At the default tolerance, 1e-8: a hundred times that is what some thirty steps amplify it to."""
    system = FAMILIES[name](np.random.default_rng(seed))
    solution = simulate(system, 1.0, state=system.assemble(rates={"hinge 1": 2.0}), output=11)
    ours = np.array([solution.angle(hinge) for hinge in system.joints]).T
    assert np.abs(ours - ours[0] - as_axes(system).motion(2.0, solution.t)).max() < 1e-6
    assert solution.certificate.passed, solution.certificate.failures
