"""Frames, arrows, traces and curves: at a sample they are the solution's, between samples as good as they claim."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.double_pendulum import LOWER_ARM, UPPER_ARM, WHEEL, pendulum

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Force,
    Kinematic,
    Ramp,
    Revolute,
    Sine,
    Spherical,
    System,
    accelerations,
    linearize,
    rotation,
    simulate,
)
from mbsd3d.plotting.panels import Panel
from mbsd3d.rotations import matrix
from mbsd3d.view.scene.frames import frames_of
from mbsd3d.view.scene.overlays import arrows_of, curve, curves_of, every_reaction, traces_of

ROUNDING = 1e-13  # of metres, rad/s, N ... of order 1 ... 20


@pytest.fixture(scope="module")
def solution():
    """1 s of a general mechanism; 41 samples."""
    return simulate(pendulum(), 1.0, rtol=1e-11, output=41)


@pytest.fixture(scope="module")
def frames(solution):
    """Five frames from each sample to the next."""
    return frames_of(solution, 201)


def spinning(rate: float, moments=(0.2, 0.4, 0.3), **options) -> Body:
    """A body on general axes whose centre of mass is off its reference point."""
    place = {"com": (0.3, -0.2, 0.5), "position": (0.4, 0.1, -0.3), "orientation": rotation((1, -2, 3), 0.8)}
    return Body("rotor", 2.0, moments, omega=rate * np.array([0.6, 0.0, 0.8]), **place, **options)


def driven_rotor() -> System:
    """A rotor turned by a motor."""
    rotor = Body("rotor", 2.0, (0.2, 0.4, 0.3), com=(0.3, -0.2, 0.5), position=(0.4, 0.1, -0.3))
    hinge = Revolute(GROUND, rotor, at=(0.4, 0.1, 0.3), axis=(1, 2, 3), name="hinge")
    return System([rotor], [hinge, AngleDriver(hinge, Ramp(2.0), name="motor")])


def door_run():
    """Half a second of a door on two hinges."""
    door = Body("door", 20.0, (8.0, 9.0, 1.0), position=(0.45, 0.0, 1.0), omega=(0, 0, 1))
    hinges = [
        Revolute(GROUND, door, at=(0, 0, z), axis=(0, 0, 1), name=name) for z, name in ((0.2, "low"), (1.8, "up"))
    ]
    return simulate(System([door], hinges), 0.5, output=11)


def test_frames_are_the_samples_where_they_meet(solution, frames):
    assert frames.t.shape == (201,) and frames.r.shape == (201, 4, 3) and frames.e.shape == (201, 4, 4)
    for i, body in enumerate(solution.system.bodies):
        assert np.allclose(frames.r[::5, i], solution.position(body), rtol=0, atol=ROUNDING)
        assert np.allclose(matrix(frames.e[::5, i]), solution.rotation(body), rtol=0, atol=ROUNDING)
    assert (frames.r[:, -1] == 0.0).all() and (frames.e[:, -1] == [1, 0, 0, 0]).all()
    assert np.allclose(np.linalg.norm(frames.e, axis=-1), 1.0, rtol=0, atol=1e-15)
    assert ((frames.e[1:] * frames.e[:-1]).sum(axis=-1) > 0.0).all()


def test_the_interpolation_is_of_fourth_order():
    true = simulate(pendulum(), 1.0, rtol=1e-12, output=401)
    errors = []
    for count in (21, 41, 81):
        found = frames_of(simulate(pendulum(), 1.0, rtol=1e-12, output=count), 401)
        shift = np.abs(found.r[:, :-1] - true.arrays["q"][..., :3]).max()
        errors.append(max(shift, np.abs(matrix(found.e[:, :-1]) - matrix(true.arrays["q"][..., 3:])).max()))
    assert errors[0] < 3e-4  # at 0.05 s, the wheel at 3 rad/s: (h w)^4 / 384 with the higher rates of the arms
    ratios = np.divide(errors[:-1], errors[1:])
    assert (ratios > 13).all() and (ratios < 19).all()  # 16 in the limit


def test_nothing_is_invented_between_samples_that_are_far_apart():
    fast = simulate(System([spinning(40.0, (0.3, 0.3, 0.3))], gravity=(0, 0, 0)), 1.0, output=21)  # 2 rad a sample
    found = frames_of(fast, 201)
    nearest = np.abs(fast.t - found.t[:, None]).argmin(axis=1)
    apart = np.abs(fast.t[nearest] - found.t) < 0.0249  # in the middle both are as near
    assert np.allclose(matrix(found.e[apart, 0]), fast.rotation("rotor")[nearest[apart]], rtol=0, atol=ROUNDING)
    assert np.allclose(found.r[apart, 0], fast.position("rotor")[nearest[apart]], rtol=0, atol=ROUNDING)


def test_the_error_at_the_farthest_is_below_a_thousandth():
    slow = System([spinning(1.0, (0.3, 0.3, 0.3))], gravity=(0, 0, 0))  # turns at a constant rate about a fixed axis
    # 1.485 rad from sample to sample; from 1.5 rad on none is interpolated
    found = frames_of(simulate(slow, 3 * 1.485, output=4), 301)
    true = simulate(slow, 3 * 1.485, output=301)
    turned = np.swapaxes(matrix(found.e[:, 0]), -1, -2) @ true.rotation("rotor")
    angle = np.arccos(np.clip((np.trace(turned, axis1=1, axis2=2) - 1) / 2, -1, 1))
    assert 1e-5 < angle.max() < 1e-3


def test_the_number_of_frames_fits_the_motion(solution):
    film = frames_of(solution)
    turned = np.abs((film.e[1:] * film.e[:-1]).sum(axis=-1))
    assert film.t.size == 251 and 2 * np.arccos(np.clip(turned, 0, 1)).max() < 0.2  # 10 s of film for 1 s
    fast = simulate(System([spinning(40.0)], gravity=(0, 0, 0)), 4.0)
    assert frames_of(fast).t.size > 40.0 * 4.0 / 0.2  # the rate is 40 at the start, and that of the largest axis later
    assert frames_of(simulate(System([spinning(500.0)]), 4.0, rtol=1e-6)).t.size == 1000
    many = [Body(f"stone {i}", 1.0, (1, 1, 1), position=(i, 0, 0)) for i in range(400)]
    assert frames_of(simulate(System(many), 20.0, output=3)).t.size == 500


def test_a_single_sample_is_a_single_frame(solution):
    still = accelerations(pendulum())
    found = frames_of(still, 10)
    assert found.t.size == 1 and np.allclose(found.r[0, 0], still.position(UPPER_ARM)[0], rtol=0, atol=ROUNDING)
    assert all(arrows.vectors.shape == (1, len(arrows.names), 3) for arrows in arrows_of(still, found))
    assert all(values.shape == (1,) for curve in curves_of(still, found) for _, values in curve.lines)


@pytest.mark.parametrize("count", [1, 0, -3, 2.5, "many", True])
def test_a_wrong_count_is_refused(solution, count):
    with pytest.raises(ValueError, match="frames = .*; give a whole number from 2"):
        frames_of(solution, count)


def test_arrows_are_the_solutions_vectors_at_its_points(solution, frames):
    spin, momentum, force, moment = arrows_of(solution, frames)
    assert [spin.kind, momentum.kind] == ["angular velocity", "angular momentum"]
    assert [x.unit for x in (spin, momentum, force, moment)] == ["rad/s", "kg m^2/s", "N", "N m"]
    assert len({x.colour for x in (spin, momentum, force, moment)}) == 4
    assert spin.names == momentum.names == [UPPER_ARM, LOWER_ARM, WHEEL]
    for k, body in enumerate(solution.system.bodies):
        R = solution.rotation(body)
        L = np.einsum("tij,jk,tlk,tl->ti", R, body.inertia, R, solution.omega(body))
        assert np.allclose(spin.vectors[::5, k], solution.omega(body), rtol=0, atol=ROUNDING)
        assert np.allclose(momentum.vectors[::5, k], L, rtol=0, atol=ROUNDING)
        assert np.allclose(spin.points[::5, k], solution.com(body), rtol=0, atol=ROUNDING)
    assert force.names == ["shoulder", "elbow", "axle"] and moment.names == ["elbow", "axle", "motor"]
    for arrows, kind in ((force, "force"), (moment, "moment")):
        for k, name in enumerate(arrows.names):
            reaction = solution.reaction(name)
            assert np.allclose(arrows.vectors[::5, k], getattr(reaction, kind), rtol=0, atol=ROUNDING)
            assert np.allclose(arrows.points[::5, k], reaction.point, rtol=0, atol=ROUNDING)
        assert arrows.uncertain == (False,) * 3
    middle = 0.5 * (solution.reaction("elbow").force[7] + solution.reaction("elbow").force[8])
    assert np.allclose(0.5 * (force.vectors[37, 1] + force.vectors[38, 1]), middle, rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("make", [door_run, lambda: simulate(pendulum(), 0.3, output=7)])
def test_one_pass_over_the_samples_gives_the_same_reactions(make):
    run, some = make(), np.array([0, 2, 5])
    for joint, found in zip(run.system.joints, every_reaction(run, some), strict=True):
        true = run.reaction(joint)
        assert found.unique == true.unique and np.array_equal(found.point, true.point[some])
        assert np.allclose(found.force, true.force[some], rtol=0, atol=ROUNDING * 1e3)  # of some 100 N
        assert np.allclose(found.moment, true.moment[some], rtol=0, atol=ROUNDING * 1e3)


def test_points_between_samples_stay_on_their_bodies(solution, frames):
    elbow = arrows_of(solution, frames)[2].points[:, 1]
    place = pendulum().bodies[1].local_point(np.array([0.3, 0.1, -0.2]))
    carried = frames.r[:, 1] + matrix(frames.e[:, 1]) @ place
    assert np.allclose(elbow, carried, rtol=0, atol=ROUNDING)


def test_shares_that_are_not_unique_are_marked_and_what_is_zero_is_left_out():
    run = door_run()
    arrows = {x.kind: x for x in arrows_of(run, frames_of(run))}
    assert arrows["reaction force"].uncertain == (True, True)
    fall = simulate(System([Body("stone", 1.0, (1, 2, 2), velocity=(1, 2, 3), omega=(0, 0, 0))]), 1.0)
    assert arrows_of(fall, frames_of(fall)) == []
    rotor = spinning(1.0)
    hung = simulate(System([rotor], [Spherical(GROUND, rotor, at=(0.4, 0.1, -0.3))]), 1.0)
    kinds = [x.kind for x in arrows_of(hung, frames_of(hung))]
    assert kinds == ["angular velocity", "angular momentum", "reaction force"]  # a ball carries no moment


def test_traces_follow_the_centres_that_move(solution, frames):
    upper, lower = traces_of(solution, frames)  # the wheel turns about its centre of mass
    assert [upper.name, lower.name] == [UPPER_ARM, LOWER_ARM] and upper.colour != lower.colour
    assert np.allclose(lower.points[::5], solution.com(LOWER_ARM), rtol=0, atol=ROUNDING)
    body = solution.system.bodies[2]
    (rim,) = traces_of(solution, frames, [(WHEEL, (-0.4, 0.5, 0.3))])
    expected = solution.point(WHEEL, body.local_point(np.array([-0.4, 0.5, 0.3])))
    assert np.allclose(rim.points[::5], expected, rtol=0, atol=ROUNDING) and rim.name == WHEEL
    assert traces_of(solution, frames, []) == []
    (middle,) = traces_of(solution, frames, [WHEEL])
    assert np.allclose(middle.points[::5], solution.com(WHEEL), rtol=0, atol=ROUNDING)
    many = [Body(f"stone {i}", 1.0, (1, 1, 1), position=(i, 0, 0), velocity=(0, 0, i)) for i in range(1, 20)]
    run = simulate(System(many, gravity=(0, 0, 0)), 3.0, output=5)
    assert [trace.name for trace in traces_of(run, frames_of(run))] == [f"stone {i}" for i in range(8, 20)]


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([("foot", (0, 0, 0))], "'foot' is not one of the bodies of this system"),
        (["nix"], "'nix' is not one of the bodies of this system"),
        ([3], "trace 3 is neither a body nor a point of one; give a body, "),
        ([(WHEEL, (0, 0))], "trace of body 'wheel': expected three numbers"),
        (WHEEL, "traces = 'wheel'; give a list"),
        (7, "traces: 7 is not a sequence; give a list"),
    ],
)
def test_wrong_traces_are_named(solution, frames, points, message):
    with pytest.raises(ValueError, match=message):
        traces_of(solution, frames, points)


def test_curves_are_those_of_plot(solution, frames):
    wanted = [("angle", "axle"), "omega_body", ["reaction", "elbow"]]
    angle, speed, _, _, force, moment = curves_of(solution, frames, wanted)
    assert (angle.label, angle.unit) == ("angle of axle", "rad")
    assert np.allclose(angle.lines[0][1][::5], solution.angle("axle"), rtol=0, atol=ROUNDING)
    assert speed.unit == "rad/s" and [name for name, _ in speed.lines] == [UPPER_ARM, LOWER_ARM, WHEEL]
    assert np.allclose(speed.lines[2][1][::5], solution.omega_body(WHEEL)[:, 0], rtol=0, atol=ROUNDING)
    assert (force.label, force.unit, moment.unit) == ("reaction force of elbow", "N", "N m")
    assert np.allclose(force.lines[1][1][::5], solution.reaction("elbow").force[:, 1], rtol=0, atol=ROUNDING)


def test_curves_are_those_of_the_run_between_its_samples_too():
    """Values under the cursor belong to the pose that is shown: straight lines were off by 2 % of the largest."""
    stick = Body("stick", 1.0, (0.1, 2.1, 2.0), position=(0, 0, 1), omega=(0.1, 0.2, 1.0))
    system = System([stick], forces=[Force(stick, (0, 0, Sine(3.0, 0.7)), at=(2.0, 0, 1.0))])
    coarse, exact = (simulate(system, 2.0, output=output) for output in (None, 401))
    assert coarse.t.size < 40
    frames = frames_of(coarse, 401)
    for seen, truth in zip(*(curves_of(run, frames) for run in (coarse, exact)), strict=True):
        largest = max(np.abs(values).max() for _, values in truth.lines)
        for (_, found), (_, values) in zip(seen.lines, truth.lines, strict=True):
            assert np.allclose(found, values, rtol=0, atol=0.01 * largest)


def test_a_jump_has_no_horns():
    t = np.linspace(0.0, 1.0, 21)
    step, rounding, broken = (t > 0.52) * 1.0, 1e-16 * np.sin(40.0 * t) ** 8, np.where(t > 0.5, np.nan, t)
    panels = (
        Panel("load", "[N]", [("step", step), ("broken", broken)]),
        Panel("gap", "[m]", [("gap", rounding)], log=True),
    )
    (_, found), (_, cut) = curve(t, np.linspace(0.0, 1.0, 777), panels[0]).lines
    assert found.min() > -1e-12 and found.max() < 1.0 + 1e-12 and np.isfinite(cut[:388]).all() and np.isnan(cut[-1])
    assert curve(t, np.linspace(0.0, 1.0, 777), panels[1]).lines[0][1].min() >= 0.0


def test_the_curves_that_tell_most(solution, frames):
    labels = [(curve.label, curve.unit) for curve in curves_of(solution, frames)]
    assert labels == [
        ("angle of axle", "rad"),
        ("energy", "J"),
        ("effort of motor", "N m"),
        ("|reaction force|", "N"),
        ("|reaction moment|", "N m"),
    ]
    free = simulate(System([spinning(2.0)], gravity=(0, 0, 0)), 1.0)
    assert curves_of(free, frames_of(free))[0].label == "angular velocity, body axes of rotor"
    driven = simulate(driven_rotor(), 1.0, method=Kinematic(), output=11)
    assert curves_of(driven, frames_of(driven))[0].label == "angle of hinge"
    assert curves_of(solution, frames, ()) == []


def test_what_one_door_hinge_carries_is_said_to_be_open():
    run = door_run()
    assert "|reaction force| (not unique: low, up)" in [curve.label for curve in curves_of(run, frames_of(run))]


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        (["speed"], "quantity 'speed' is unknown; give one of energy, position"),
        ([("angle", "foot")], "'foot' is not one of the joints of this system"),
        ([("energy", WHEEL)], "energy belongs to the whole system"),
        (["slide"], "no joint of this system has the quantity slide"),
        ([3], r"\[3\] is not a quantity"),
        ([()], r"\[\(\)\] is not a quantity"),
        ("energy", "curves = 'energy'; give a list"),
    ],
)
def test_wrong_curves_are_named(solution, frames, wanted, message):
    with pytest.raises(ValueError, match=message):
        curves_of(solution, frames, wanted)


def test_the_sign_of_a_quaternion_is_no_turn(solution):
    """e and -e are one pose: between samples of other signs a body moves as before."""
    rod = Body("rod", 2.0, (0.06, 0.058, 0.004), position=(0.3, 0.2, -0.3), orientation=rotation("z", 0.5))
    swing = linearize(System([rod], [Revolute(GROUND, rod, at=(0.3, 0.2, 0.0), axis=(1, 2, 0))])).mode(0)
    for motion in (solution, swing.motion(amplitude=0.3, samples=31)):
        signs = np.where(np.arange(motion.t.size) % 3 == 1, -1.0, 1.0)[:, None, None]
        q = np.concatenate([motion.arrays["q"][..., :3], signs * motion.arrays["q"][..., 3:]], axis=2)
        flipped = replace(motion, arrays={**motion.arrays, "q": q})
        found, known = (frames_of(x, 2 * q.shape[0] - 1) for x in (flipped, motion))
        assert np.abs(found.r - known.r).max() < ROUNDING
        assert np.abs(matrix(found.e) - matrix(known.e)).max() < ROUNDING


def test_a_mode_moves_without_velocities():
    rod = Body("rod", 2.0, (0.06, 0.058, 0.004), position=(0.3, 0.2, -0.3), orientation=rotation("z", 0.5))
    swing = linearize(System([rod], [Revolute(GROUND, rod, at=(0.3, 0.2, 0.0), axis=(1, 2, 0))])).mode(0)
    motion = swing.motion(amplitude=0.6, samples=31)
    found = frames_of(motion, 61)
    assert np.allclose(found.r[::2, 0], motion.position(rod), rtol=0, atol=ROUNDING)
    assert np.allclose(
        found.r[1::2, 0], 0.5 * (motion.position(rod)[1:] + motion.position(rod)[:-1]), rtol=0, atol=ROUNDING
    )
    half = motion.orientation(rod)[1:] + motion.orientation(rod)[:-1]
    assert np.allclose(found.e[1::2, 0], half / np.linalg.norm(half, axis=1, keepdims=True), rtol=0, atol=ROUNDING)
    assert frames_of(motion).t.size >= 25
    assert arrows_of(motion, found) == [] and curves_of(motion, found) == []
    assert [trace.name for trace in traces_of(motion, found)] == ["rod"]
