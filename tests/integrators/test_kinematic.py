"""Driven motion: poses enough for Newton's method between samples far apart, and samples at dead centres."""

import numpy as np
import pytest

from mbsd3d import (
    DOP853,
    GROUND,
    AngleDriver,
    Body,
    GeneralizedAlpha,
    IntegrationError,
    Kinematic,
    Polynomial,
    Prismatic,
    RadauIIA,
    Ramp,
    Revolute,
    System,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix
from mbsd3d.run.global_error import refined

RATES = (2.0, 3.1, 7.0)  # rad/s


def gimbal():
    """(system, hinges): three rings in each other, turned by motors, so that angular accelerations never vanish."""
    rings = [Body(f"ring {i}", 1.0 + i, (0.1, 0.12, 0.15), com=(0.05, 0.02 * i, -0.03)) for i in range(3)]
    pairs = zip([GROUND, *rings], rings, np.eye(3), strict=False)
    hinges = [Revolute(a, b, at=(0, 0, 0), axis=axis) for a, b, axis in pairs]
    motors = [AngleDriver(hinge, Polynomial((0, rate))) for hinge, rate in zip(hinges, RATES, strict=True)]
    return System(rings, [*hinges, *motors]), hinges


@pytest.mark.parametrize("t_end", [2.0, 300.0])
def test_poses_between_wide_samples_grow_with_the_time_and_not_with_its_square(t_end):
    system, hinges = gimbal()
    run = simulate(system, t_end, method=Kinematic(), output=[0, 0.4 * t_end, t_end])
    assert run.certificate.passed, run.certificate
    for hinge, rate in zip(hinges, RATES, strict=True):  # driven, so to rounding of the angle
        assert run.angle(hinge)[-1] == pytest.approx(rate * t_end, rel=1e-14)
    # one pose in 0.3 rad of the fastest ring, which turns by less than the sum of the rates; fewer would miss turns
    assert 0.5 * max(RATES) * t_end / 0.3 < run.certificate.steps < 2.0 * sum(RATES) * t_end / 0.3


def test_an_estimate_compares_with_poses_that_are_nearer():
    """With a tighter rtol it would run the same again, and could not fail."""
    run = simulate(gimbal()[0], 2.0, method=Kinematic(), output=3)
    assert refined(run, 4.0).record.steps >= 3 * run.record.steps and run.estimate().error < 1e-12


def test_wide_samples_are_those_of_narrow_ones():
    system, _ = gimbal()
    wide, narrow = (simulate(system, 6.0, method=Kinematic(), output=count) for count in (4, 301))
    # poses are on c = 0, wherever the last one was
    assert wide.arrays["q"] == pytest.approx(narrow.arrays["q"][::100], abs=1e-12)


def wheels_and_rod(angle, tilt=0.8):
    """(system, wheel, rod, follower): two wheels with a coupling rod, tilted in space."""
    Q = rotation((1.0, 0.3, -0.7), tilt)
    R, radius, base = matrix(Q), 0.5, 1.3
    pin, axis = radius * np.array([np.sin(angle), 0, np.cos(angle)]), R @ [0.0, 1.0, 0.0]
    far = np.array([base, 0, 0])
    wheel = Body("wheel", 1.1, (0.02, 0.03, 0.04), com=(0.01, 0.02, 0.2), orientation=Q)
    rod = Body("rod", 2.0, (0.1, 0.2, 0.25), com=(0.6, 0.05, 0.1), position=R @ pin, orientation=Q)
    follower = Body("follower", 1.3, (0.02, 0.03, 0.04), com=(0.02, 0.01, 0.25), position=R @ far, orientation=Q)
    drive = Revolute(GROUND, wheel, at=(0, 0, 0), axis=axis, name="drive")
    joints = [
        drive,
        Revolute(wheel, rod, at=R @ pin, axis=axis, name="pin"),
        Revolute(rod, follower, at=R @ (pin + far), axis=axis, name="far pin"),
        Revolute(GROUND, follower, at=R @ far, axis=axis, name="far bearing"),
        AngleDriver(drive, Ramp(2 * np.pi)),
    ]
    return System([wheel, rod, follower], joints), wheel, rod, follower


@pytest.mark.parametrize("tilt", [0.0, 0.8])  # along the world's axes numbers vanish exactly
@pytest.mark.parametrize("output", [41, 361])
def test_a_coupling_rod_goes_on_along_itself_through_dead_centres_that_are_sampled(output, tilt):
    """The rod turns about nothing and its ends move as the wheels: at t = 1/4 and 3/4 s no row says so."""
    system, wheel, rod, follower = wheels_and_rod(0.0, tilt)
    run = simulate(system, 1.0, method=Kinematic(), output=output)
    near = np.isin(run.t, (0.25, 0.75))
    assert near.sum() == 2 and run.certificate.passed
    assert any(note.startswith("singular at t = ") for note in run.certificate.notes)
    # rounding 1e-16 of the poses before, 0.01 rad apart: over the pivot 1e-4 for rates, once more for accelerations,
    # 60 times as much by the binomial weights
    assert np.abs(run.omega(rod)).max() < 1e-7 and np.abs(run.alpha(rod)).max() < 1e-3
    np.testing.assert_allclose(run.omega(follower), run.omega(wheel), rtol=0, atol=1e-7)
    np.testing.assert_allclose(run.alpha(follower), run.alpha(wheel), rtol=0, atol=1e-3)
    np.testing.assert_allclose(np.linalg.norm(run.velocity(rod), axis=1), np.pi, rtol=1e-7)


@pytest.mark.parametrize("tilt", [0.0, 0.8])
def test_a_coupling_rod_is_integrated_through_dead_centres_that_are_sampled(tilt):
    """Rates are those of the integration there; forces grow without bound beside them and have no value at them."""
    system, _, rod, _ = wheels_and_rod(0.0, tilt)
    run = simulate(system, 1.0, output=41)
    assert run.certificate.passed and np.abs(run.omega(rod)).max() < 1e-6  # rtol 1e-8 of 6 rad/s
    assert any("2 of 41 samples" in note for note in run.certificate.notes)


@pytest.mark.parametrize("method", [Kinematic(), DOP853(), RadauIIA()], ids=lambda method: type(method).__name__)
def test_a_start_at_a_dead_centre_is_named(method):
    """The wheels can turn either way against each other: the joints that tell them apart are named, and what to do."""
    system, *_ = wheels_and_rod(np.pi / 2)
    said = "the pose at the start is singular.*: .*'far pin'.* can move while the rest stands.*the motion branches here"
    with pytest.raises((ValueError, IntegrationError), match=said):
        simulate(system, 1.0, method=method)


def test_a_slider_crank_with_a_rod_as_long_as_its_crank_passes_the_pose_where_it_could_rest():
    """x = 2 r cos(phi): at phi = 90 degrees the piston stands on the shaft, where it could stay for ever."""
    Q, r, start, rate = rotation((1.0, 0.3, -0.7), 0.8), 0.5, 0.3, 2 * np.pi
    R, across = matrix(Q), (np.pi / 2 - 0.3) / rate
    pin, wrist = R @ [r * np.cos(start), 0, r * np.sin(start)], R @ [2 * r * np.cos(start), 0, 0]
    crank = Body("crank", 1.1, (0.02, 0.03, 0.04), com=(0.1, 0.02, 0.05), orientation=Q)
    rod = Body("rod", 2.0, (0.1, 0.2, 0.25), com=(0.05, 0.01, 0.1), position=pin, orientation=Q)
    piston = Body("piston", 1.0, (0.1, 0.1, 0.1), com=(0.02, 0, 0.01), position=wrist, orientation=Q)
    bearing = Revolute(GROUND, crank, at=(0, 0, 0), axis=-R[:, 1])
    joints = [bearing, Revolute(crank, rod, at=pin, axis=R[:, 1]), Revolute(rod, piston, at=wrist, axis=R[:, 1])]
    joints += [Prismatic(GROUND, piston, at=wrist, axis=R[:, 0]), AngleDriver(bearing, Ramp(rate))]
    output = np.union1d(np.linspace(0, 0.45, 19), across)
    run = simulate(System([crank, rod, piston], joints), 0.45, method=Kinematic(), output=output)
    phi = start + rate * run.t
    assert run.certificate.passed and run.t[np.argmin(np.abs(phi - np.pi / 2))] == across
    for found, theory, error in (  # as for the coupling rod; the pose there is known to the 2e-13 of the sixth order
        (run.position(piston), 2 * r * np.cos(phi), 1e-11),
        (run.velocity(piston), -2 * r * rate * np.sin(phi), 1e-7),
        (run.acceleration(piston), -2 * r * rate**2 * np.cos(phi), 1e-3),
    ):
        np.testing.assert_allclose(found @ R[:, 0], theory, rtol=0, atol=error)


def test_newtons_method_that_ends_near_a_dead_centre_names_it():
    system, *_ = wheels_and_rod(0.0)
    with pytest.raises(IntegrationError, match="the pose is nearly singular: 'pin', 'far pin' and 'far bearing' can"):
        simulate(system, 1.0, method=GeneralizedAlpha(1e-3), output=41)


@pytest.mark.parametrize("clearance", [1e-2, 3e-4, 1e-5, 1e-6])
@pytest.mark.parametrize("output", [5, 200])
def test_a_four_bar_that_clears_its_dead_centre_by_little_stays_on_its_branch(clearance, output):
    """Coupler and rocker are stretched but for the clearance when the crank points away: the other branch is near.

    The coupler's far end is where two circles meet, and on one side of their centres at all times.
    """
    Q, r, base, coupler, start, rate = rotation((1.0, 0.3, -0.7), 0.8), 0.3, 1.0, 0.75, 0.4, -7.0
    R, rocker = matrix(Q), r + base - coupler + clearance

    def pins(angle):
        """Crank pin and far pin in the plane."""
        B = r * np.array([np.cos(angle), np.sin(angle)])
        to = [base, 0] - B
        d = np.hypot(*to)
        along = (coupler**2 - rocker**2 + d**2) / (2 * d)
        return B, B + (along * to + np.sqrt(coupler**2 - along**2) * np.array([-to[1], to[0]])) / d

    near, far, foot, axis = *(R @ [x, 0, z] for x, z in pins(start)), R @ [base, 0, 0], -R[:, 1]
    bars = [Body(name, 1.0, (0.02, 0.03, 0.04), com=(0.1, 0.02, 0.05), position=at, orientation=Q)
            for name, at in (("crank", (0, 0, 0)), ("coupler", near), ("rocker", foot))]  # fmt: skip
    drive = Revolute(GROUND, bars[0], at=(0, 0, 0), axis=axis)
    joints = [drive, Revolute(bars[0], bars[1], at=near, axis=axis), Revolute(bars[1], bars[2], at=far, axis=axis)]
    joints += [Revolute(GROUND, bars[2], at=foot, axis=axis), AngleDriver(drive, Ramp(rate))]
    run = simulate(System(bars, joints), 1.0, method=Kinematic(), output=output)  # just over a turn
    found = run.body_point(bars[1], far) @ R[:, [0, 2]]
    np.testing.assert_allclose(found, [pins(start + rate * t)[1] for t in run.t], rtol=0, atol=1e-8)
