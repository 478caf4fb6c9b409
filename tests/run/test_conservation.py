"""Long runs: flips, tops, conserved quantities, and constraints that do not drift."""

import numpy as np
import pytest
from helpers.closed_forms import rotations
from helpers.models import all_joints_mechanism, consistent_state, moved_reference, same_rotation
from scipy.integrate import solve_ivp

from mbsd3d import GROUND, Body, Spherical, System, rotation, simulate
from mbsd3d.rotations import matrix
from validation import cases, theory
from validation.cases.comparison import compare

MOMENTS = np.array([1.0, 2.0, 3.0])
MIDDLE = 5.0
"""rad/s about the middle axis."""


def racket(off, shift_seed=None):
    """The body of the case file with ``off`` rad/s about its other axes; the seed moves O off the centre of mass."""
    body = Body("racket", 1.5, MOMENTS, omega=(off, MIDDLE, off), velocity=(1.0, 2.0, 3.0))
    if shift_seed is not None:
        body = moved_reference(body, 0.5 * np.random.default_rng(shift_seed).normal(size=3))
    return body


def flips(off, count, shift_seed=None, rtol=1e-12, **options):
    """(greatest error of the quaternion, of the angular velocity over |w|) in ``count`` flips."""
    body, omega = racket(off, shift_seed), np.array([off, MIDDLE, off])
    t_end = count * rotations.flip_interval(MOMENTS, omega)
    system = System(bodies=[body], gravity=(0.0, 0.0, 0.0))
    solution = simulate(system, t_end, rtol=rtol, output=10 * count + 1, **options)
    exact = theory.free_body(solution.t, MOMENTS, omega)
    turned = same_rotation(solution.orientation(body), rotations.quaternion(exact.rotation.astype(float)))
    return turned, np.abs(solution.omega_body(body) - exact.omega_body).max() / MIDDLE


def amplified(off, count=20):
    """What rounding comes to: a random walk over 2500 to 3100 steps, in units of the distance from the separatrix.

    That is ``(off / MIDDLE)^2``; a change of it by a part of its size shifts every flip by such a part of a radian.
    """
    return np.finfo(float).eps * np.sqrt(3000) * count * (MIDDLE / off) ** 2


def test_flips_from_a_hundredth_off_the_middle_axis():
    quaternion, omega = flips(1e-2, 20)
    assert quaternion < amplified(1e-2)  # 6e-8
    assert omega < amplified(1e-2)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_flips_with_the_reference_point_off_the_centre_of_mass(seed):
    quaternion, omega = flips(1e-2, 20, seed)
    assert quaternion < amplified(1e-2)
    assert omega < amplified(1e-2)


def scipy_flips(off, count):
    """The same error of the angular velocity for Euler's three equations alone, by scipy's DOP853."""
    omega = np.array([off, MIDDLE, off])
    times = np.linspace(0.0, count * rotations.flip_interval(MOMENTS, omega), 10 * count + 1)

    def euler(_, w):
        return np.cross(MOMENTS * w, w) / MOMENTS

    run = solve_ivp(euler, times[[0, -1]], omega, "DOP853", times, rtol=1e-13, atol=1e-14)
    return np.abs(run.y.T - theory.free_body(times, MOMENTS, omega).omega_body).max() / MIDDLE


@pytest.mark.slow
@pytest.mark.parametrize("seed", [None, 1])
def test_flips_of_the_case_file_are_as_good_as_rounding_allows(seed):
    """A thousandth off the axis, where rounding of the state itself leaves 1e-7 to 1e-6."""
    quaternion, omega = flips(1e-3, 20, seed)
    assert max(quaternion, omega) < amplified(1e-3)  # 6e-6
    assert scipy_flips(1e-3, 20) > 1e-3 * amplified(1e-3)  # another integrator's random walk is no better


def test_ablation_flips_see_the_gyroscopic_term_and_one_per_cent_of_a_moment():
    assert flips(1e-2, 1, gyroscopic=False)[1] > 100 * amplified(1e-2, 1)
    exact = theory.free_body([3.0], MOMENTS, (1e-2, MIDDLE, 1e-2)).omega_body
    wrong = theory.free_body([3.0], MOMENTS * [1.0, 1.0, 1.01], (1e-2, MIDDLE, 1e-2)).omega_body
    assert np.abs(exact - wrong).max() / MIDDLE > 100 * amplified(1e-2, 1)


@pytest.mark.parametrize("seed", [pytest.param(None, marks=pytest.mark.slow), 1])
def test_energy_and_momentum_over_a_thousand_revolutions(seed):
    body = racket(1e-2, seed)
    system = System(bodies=[body], gravity=(0.0, 0.0, 0.0))
    solution = simulate(system, 1000 * 2 * np.pi / MIDDLE, rtol=1e-12, output=1001)
    momentum, energy = solution.momentum(), solution.energy().total
    spin = momentum.angular - np.cross(solution.com(body), momentum.linear)
    # the limit set
    assert np.abs(energy / energy[0] - 1).max() < 1e-10
    assert np.abs(spin - spin[0]).max() < 1e-10 * np.linalg.norm(spin[0])
    assert np.abs(momentum.linear - momentum.linear[0]).max() < 1e-10 * np.linalg.norm(momentum.linear[0])


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_floating_mechanism_of_all_joints_conserves(seed):
    system = all_joints_mechanism(seed, grounded=False, drivers=False, gravity=(0.0, 0.0, 0.0))
    start = consistent_state(system, np.random.default_rng(seed))
    solution = simulate(system, 1.0, state=start, rtol=1e-11, output=11)
    momentum, energy = solution.momentum(), solution.energy().total
    # 10 rtol over some fifty steps
    assert np.abs(energy / energy[0] - 1).max() < 1e-10
    for value in (momentum.linear, momentum.angular):
        assert np.abs(value - value[0]).max() < 1e-10 * np.abs(value[0]).max()
    assert np.ptp(solution.arrays["v"], axis=0).max() > 1.0  # it does move


def test_internal_drivers_do_work_and_leave_momentum():
    system = all_joints_mechanism(4, grounded=False, gravity=(0.0, 0.0, 0.0))
    start = consistent_state(system, np.random.default_rng(4))
    solution = simulate(system, 0.5, state=start, rtol=1e-11, output=11)
    momentum, energy = solution.momentum(), solution.energy()
    for value in (momentum.linear, momentum.angular):
        assert np.abs(value - value[0]).max() < 1e-10 * np.abs(value[0]).max()  # 10 rtol
    gained = energy.total - energy.total[0]
    assert np.abs(gained).max() > 1e-3 * energy.total[0]
    assert gained == pytest.approx(energy.work - energy.work[0], abs=1e-10 * energy.total[0])  # 10 rtol


@pytest.mark.parametrize("shift", [None, 7])
def test_bricard_does_not_drift_in_a_hundred_seconds(shift):
    solution = simulate(cases.load("iftomm_A04_bricard", shift).system, 100.0, rtol=1e-9, output=2001)
    drift, certificate = solution.drift(), solution.certificate
    assert drift.position.max() < 1e-12  # m, the limit set, at every sample and over all rows, the redundant one too
    assert drift.velocity.max() < 1e-12
    assert certificate.passed


def test_bricard_conserves_energy():
    solution = simulate(cases.load("iftomm_A04_bricard", 7).system, 100.0, rtol=1e-9)
    energy = solution.energy()
    # 100 rtol of the energy exchanged over eight hundred steps
    assert np.abs(energy.total - energy.total[0]).max() < 1e-7 * np.ptp(energy.potential)


@pytest.mark.parametrize("shift", [None, 7, 8])
def test_fast_heavy_top_at_two_seconds(shift):
    case = cases.load("heavy_top_fast", shift)
    comparison = compare(case, simulate(case.system, 2.0, rtol=1e-12, output=case.times))
    assert comparison.scaled_error < 1e-9  # the limit set; condition 1560
    assert case.times[-1] == 2.0


def test_ablation_the_top_sees_one_per_cent_of_its_moment():
    raw = cases.read("heavy_top_fast")
    inertia = np.array(raw["bodies"][0]["inertia"]) * [1.0, 0.99, 1.0]
    case = cases.build({**raw, "bodies": [{**raw["bodies"][0], "inertia": inertia}]})
    comparison = compare(case, simulate(case.system, 2.0, rtol=1e-12, output=case.times))
    assert comparison.scaled_error > 100 * 1e-9


TRANSVERSE, AXIAL, MASS, LEVER = 0.02, 0.015, 2.0, 0.3
ABOUT_PIVOT = TRANSVERSE + MASS * LEVER**2
WEIGHT = MASS * 9.81 * LEVER


def top(tilt, precession, spin, seed=41):
    """A symmetric top about the origin, tilted towards +y, reference point off both pivot and centre of mass."""
    e = rotation("x", -tilt)
    axis = matrix(e)[:, 2]
    own = spin - precession * np.cos(tilt)
    omega = np.array([0.0, 0.0, precession]) + own * axis
    body = Body(
        "top", MASS, (TRANSVERSE, TRANSVERSE, AXIAL), com=(0.0, 0.0, LEVER), orientation=e, velocity=(0, 0, 0),
        omega=omega,
    )  # fmt: skip
    body = moved_reference(body, 0.2 * np.random.default_rng(seed).normal(size=3))
    return System(bodies=[body], joints=[Spherical(GROUND, body, at=(0.0, 0.0, 0.0))]), body


@pytest.mark.parametrize("root", [0, 1], ids=["slow", "fast"])
def test_steady_precession(root):
    tilt, spin = np.radians(60.0), 150.0
    rate = theory.steady_precession(ABOUT_PIVOT, AXIAL, spin, WEIGHT, tilt)[root]
    system, body = top(tilt, rate, spin)
    solution = simulate(system, 2 * np.pi / rate, rtol=1e-12, output=21)
    phase = rate * solution.t
    circle = np.sin(tilt) * np.array([-np.sin(phase), np.cos(phase)])
    exact = LEVER * np.column_stack([*circle, np.full(21, np.cos(tilt))])
    assert np.abs(solution.com(body) - exact).max() < 1e-10  # the limit set


def test_ablation_another_rate_is_not_steady():
    tilt, spin = np.radians(60.0), 150.0
    rate = 1.01 * theory.steady_precession(ABOUT_PIVOT, AXIAL, spin, WEIGHT, tilt)[0]
    system, body = top(tilt, rate, spin)
    solution = simulate(system, 1.0, rtol=1e-10, output=101)
    assert np.ptp(solution.com(body)[:, 2]) > 100 * 1e-10


def greatest_tilt(factor):
    """Greatest tilt [rad] in 20 s of a top that starts upright within 1e-3 rad, spun at a factor of the threshold."""
    spin = factor * rotations.sleeping_spin(ABOUT_PIVOT, AXIAL, WEIGHT)
    system, body = top(1e-3, 0.0, spin)
    heights = simulate(system, 20.0, rtol=1e-10, output=2001).com(body)[:, 2]
    return np.arccos(np.clip(heights / LEVER, -1.0, 1.0)).max()


def test_sleeping_top_stays_up_above_its_threshold_and_falls_below():
    assert greatest_tilt(1.05) < 0.01  # 1e-3 rad amplified by 1 / sqrt(1.05^2 - 1) = 3.1
    assert greatest_tilt(0.95) > 0.3


def test_sleeping_top_reaches_the_tilt_of_its_cubic():
    spin = 0.95 * rotations.sleeping_spin(ABOUT_PIVOT, AXIAL, WEIGHT)
    motion = rotations.nutation(ABOUT_PIVOT, AXIAL, spin, WEIGHT, 1e-3, 0.0, 0.0)
    # sampled 2000 times: the lowest point is missed by 1e-4 at most
    assert greatest_tilt(0.95) == pytest.approx(np.arccos(motion.lowest), abs=1e-3)
