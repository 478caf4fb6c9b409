"""Cams with rollers, flat faces and grooves against closed forms: motion, force, pressure angle, torque, float."""

import numpy as np
import pytest

from engines.closed_forms import cams
from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    CurveContact,
    Kinematic,
    Prismatic,
    Ramp,
    Revolute,
    SpringDamper,
    System,
    simulate,
)
from mbsd3d.rotations import matrix

LIFT, HALF, PITCH, ROLLER = 0.0083, np.radians(72.0), 0.0285, 0.009
MASS, RATE, PRELOAD, OMEGA = 0.13, 31e3, 270.0, 190.0
FRAME = matrix(np.array([0.7, -0.3, 0.5, 0.41]) / np.linalg.norm([0.7, -0.3, 0.5, 0.41]))  # no axis is aligned
ANGLE = 2 * np.pi * np.arange(720) / 720 - np.pi
LAWS = {"cycloidal": cams.cycloidal, "harmonic": cams.harmonic}
SMOOTH = 0.16  # rad from the ends and the nose: where the curvature jumps the spline rings, 0.43 times as much a point


def smooth(angle):
    """Where the laws have all derivatives."""
    return np.min([np.abs(np.abs(angle) - HALF), np.abs(angle), np.pi - np.abs(angle)], axis=0) > SMOOTH


def train(points, at, omega=OMEGA, **given):
    """A cam about x of the frame, a follower along its z, and a spring; points and at: in the frame, the nose up."""
    x, z = FRAME[:, 0], FRAME[:, 2]
    cam = Body("camshaft", 1.0, (1e-3, 2e-3, 2.5e-3), com=(0.01, 0.002, -0.003))
    place = FRAME @ at
    valve = Body("valve", MASS, (1e-4, 1e-4, 1e-4), position=place, com=(0.003, 0.001, 0.004))
    bearing = Revolute(GROUND, cam, at=(0, 0, 0), axis=x, name="bearing")
    joints = [
        bearing,
        AngleDriver(bearing, Ramp(omega), name="motor"),
        Prismatic(GROUND, valve, at=place, axis=z, name="guide"),
        CurveContact(cam, valve, points @ FRAME.T, at=place, **given, name="cam"),
    ]
    lift = at[2] - PITCH
    seat = place + (0.1 - lift) * z
    force = RATE * 0.1 + PRELOAD  # of a spring that pushes with the preload at no lift
    spring = SpringDamper(GROUND, valve, at_a=seat, at_b=place, stiffness=RATE, length=force / RATE)
    return System([cam, valve], joints, [spring], gravity=(0, 0, 0))


def turned(system, samples=721):
    """A turn from the nose on, and the angle from the nose within half a turn."""
    rate = abs(system.joints[1].signal.rate)
    run = simulate(system, 2 * np.pi / rate, method=Kinematic(), output=samples)
    angle = (rate * run.t + np.pi) % (2 * np.pi) - np.pi
    return run, angle


def flat(law, base=PITCH):
    """Outline under a flat face, the nose up."""
    s, ds, _ = LAWS[law](ANGLE, LIFT, HALF)
    across, up = ds, base + s
    own = [across * np.cos(ANGLE) + up * np.sin(ANGLE), up * np.cos(ANGLE) - across * np.sin(ANGLE)]
    return np.column_stack([0 * ANGLE, *own])


def rolled(law, roller=ROLLER):
    """Outline under a roller, the nose up."""
    s, ds, _ = LAWS[law](ANGLE, LIFT, HALF)
    return np.column_stack([0 * ANGLE, cams.roller_cam(ANGLE, s, ds, PITCH, roller)])


TOP = np.array([0.0, 0.0, PITCH + LIFT])


@pytest.mark.parametrize("follower", ["roller", "knife edge", "face"])
@pytest.mark.parametrize("law", LAWS)
def test_cams_lift_push_and_turn_as_their_laws_say(law, follower):
    points, given = {
        "roller": (rolled(law), {"pin": FRAME[:, 0], "radius": ROLLER}),
        "knife edge": (rolled(law, 0.0), {"pin": FRAME[:, 0], "radius": 0.0}),
        "face": (flat(law), {"face": FRAME[:, 2]}),
    }[follower]
    run, angle = turned(train(points, TOP, **given))
    contact = run.system.joints[-1]
    s, ds, dds = LAWS[law](angle, LIFT, HALF)
    good = smooth(angle)
    found = run.position("valve") @ FRAME[:, 2] - PITCH
    assert found == pytest.approx(s, abs=1e-5 * LIFT)
    along = MASS * dds * OMEGA**2 + PRELOAD + RATE * s
    tilt = 0 * s if follower == "face" else cams.pressure_angle(s, ds, PITCH)
    normal = contact.contact_normal(run) @ FRAME
    assert normal[good, 2] == pytest.approx(np.cos(tilt)[good], abs=1e-6)
    assert normal[good, 1] == pytest.approx(-np.sin(tilt)[good], abs=1e-5)
    force, size = contact.normal_force(run), along.max()
    # a point a half degree: second derivatives to 1e-6 where the law is smooth
    assert force[good] == pytest.approx((along / np.cos(tilt))[good], abs=1e-5 * size)
    assert run.effort("motor")[good] == pytest.approx((along * ds)[good], abs=1e-5 * size * LIFT)
    assert run.certificate.passed


@pytest.mark.parametrize("law", LAWS)
def test_a_roller_leaves_its_cam_at_the_speed_of_float(law):
    s, _, dds = LAWS[law](np.linspace(-np.pi, np.pi, 20001), LIFT, HALF)
    known = cams.float_rate(MASS, RATE, PRELOAD, s, dds)
    for share in (0.99, 1.01):
        system = train(rolled(law), TOP, share * known, pin=FRAME[:, 0], radius=ROLLER)
        run, angle = turned(system)
        contact, notes = system.joints[-1], run.certificate.notes
        time = contact.lifts_off(run)
        assert (time is None) == (share < 1.0) and bool(notes) == (share > 1.0)
    s, _, dds = LAWS[law](angle, LIFT, HALF)
    pulls = MASS * dds * (1.01 * known) ** 2 + PRELOAD + RATE * s < 0.0
    assert time == pytest.approx(run.t[pulls.argmax()], abs=2 * run.t[1])
    assert f"'cam' lifts off at t = {time:.6g} s" in notes[0] and run.certificate.passed


def test_a_groove_holds_both_ways_and_does_not_lift_off():
    system = train(rolled("cycloidal", 0.0), TOP, 4 * OMEGA, pin=FRAME[:, 0])
    run, _ = turned(system)
    contact = system.joints[-1]
    assert contact.normal_force(run).min() < -100.0 < 100.0 < contact.normal_force(run).max()
    assert contact.lifts_off(run) is None and run.certificate.notes == ()


def test_a_roller_larger_than_the_curvature_undercuts_its_cam():
    s, ds, dds = cams.cycloidal(ANGLE, LIFT, np.radians(40.0))
    r = PITCH + s
    radius = (r**2 + ds**2) ** 1.5 / (r**2 + 2 * ds**2 - r * dds)  # of the way of the roller's centre
    largest = radius[radius > 0.0].min()
    for share in (0.9, 1.1):
        points = np.column_stack([0 * ANGLE, cams.roller_cam(ANGLE, s, ds, PITCH, share * largest)])
        call = lambda: train(points, TOP, pin=FRAME[:, 0], radius=share * largest)  # noqa: B023, E731
        if share < 1.0:
            call()
        else:
            with pytest.raises(ValueError, match="'cam'.*a corner or a cusp.*larger base circle or a smaller roller"):
                call()


@pytest.mark.parametrize("law", LAWS)
def test_too_small_a_base_circle_gives_a_flat_follower_a_cusp(law):
    """The outline has the radius of curvature base + s + s''."""
    s, _, dds = LAWS[law](np.linspace(-np.pi, np.pi, 20001), LIFT, HALF)
    least = -(s + dds).min()
    given = {"face": FRAME[:, 2]}
    train(flat(law, 1.1 * least), np.array([0, 0, 1.1 * least + LIFT]), **given)
    with pytest.raises(ValueError, match="'cam'.*(cusp.*larger base circle|hollow)"):
        train(flat(law, 0.9 * least), np.array([0, 0, 0.9 * least + LIFT]), **given)


def barrel(omega, law, radius=0.05, reach=0.6):
    """A drum about z of the frame whose groove moves a slide along z: cycloidal to and fro."""
    turn = 2 * np.pi * np.arange(720) / 720
    z = law(turn)[0]
    groove = np.column_stack([radius * np.cos(turn), -radius * np.sin(turn), z])
    pins = groove * (1, 1, 0)
    drum = Body("drum", 2.0, (2e-3, 2e-3, 3e-3), com=(0.001, 0.002, 0.01))
    at = FRAME @ np.array([radius, 0, z[0]])
    slide = Body(
        "slide", 0.7, (1e-3, 2e-3, 2e-3), position=at + FRAME @ np.array([reach, 0.1, 0]), com=(0.01, 0.02, 0.03)
    )
    axis = FRAME[:, 2]
    bearing = Revolute(GROUND, drum, at=(0, 0, 0), axis=axis, name="bearing")
    joints = [
        bearing,
        AngleDriver(bearing, Ramp(omega), name="motor"),
        Prismatic(GROUND, slide, at=slide.position, axis=axis, name="rail"),
        CurveContact(drum, slide, groove @ FRAME.T, at=at, pin=pins @ FRAME.T, name="groove"),
    ]
    return System([drum, slide], joints, gravity=(0, 0, 0))


def test_a_barrel_cam_in_closed_form():
    """F = m z'' w^2 / cos(alpha), tan(alpha) = z' / R, torque m z'' w^2 z': the force is at right angles to the pin."""
    lift, half, radius, omega = 0.04, np.radians(130.0), 0.05, 25.0

    def law(turn):
        return cams.cycloidal((turn + np.pi) % (2 * np.pi) - np.pi, lift, half)

    system = barrel(omega, law, radius)
    assert system.check().mobility == 0 and not system.check().redundant
    run, angle = turned(system, 356)  # between the points of the groove
    s, ds, dds = law(omega * run.t)
    good = np.min([np.abs(np.abs(angle) - half), np.abs(angle)], axis=0) > SMOOTH
    groove = system.joints[-1]
    along, tilt = 0.7 * dds * omega**2, np.arctan2(ds, radius)
    way = (run.position("slide") - run.position("slide")[0]) @ FRAME[:, 2]
    assert way == pytest.approx(s - s[0], abs=1e-6 * lift)
    size = np.abs(along).max()
    force = run.reaction(groove).force @ FRAME
    assert force[good, 2] == pytest.approx(along[good], abs=1e-6 * size)
    assert np.abs(force[:, 0]).max() < 1e-7 * size  # along the pin, turned by splines, nothing is held
    assert np.abs(np.linalg.norm(force, axis=1) - np.abs(along) / np.cos(tilt))[good].max() < 1e-5 * size
    assert run.effort("motor")[good] == pytest.approx((along * ds)[good], abs=1e-6 * size * lift)
    assert np.abs(groove.normal_force(run))[good] == pytest.approx(np.abs(along / np.cos(tilt))[good], abs=1e-5 * size)
