"""Published numbers: Cardan joints, the crank with rod and piston, the six-axis robot, and driven mechanisms."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.closed_forms import cardan as shafts
from helpers.closed_forms import slider_crank as crank_theory
from helpers.models import across, direction, moved_reference, random_body, random_inertia, random_orientation

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Cylindrical,
    Kinematic,
    PointOnLine,
    Prismatic,
    Ramp,
    Revolute,
    Sine,
    SpeedDriver,
    Spherical,
    System,
    Universal,
    accelerations,
    simulate,
)
from mbsd3d import Polynomial as Powers
from mbsd3d.rotations import exponential, matrix
from validation import theory
from validation.cases import read
from validation.cases.robot import hinge_accelerations, robot_poses

RATE = 10.0
"""rad/s of the input shafts."""


class Plane:
    """Three right-handed unit vectors in general position: two in a plane and its normal."""

    def __init__(self, seed):
        self.u = direction(np.random.default_rng(seed))
        self.v = across(np.random.default_rng(seed + 1), self.u)
        self.n = np.cross(self.u, self.v)

    def at(self, angle):
        """Unit vector at an angle from u towards v."""
        return np.cos(angle) * self.u + np.sin(angle) * self.v


def shaft_pair(bend, driver):
    """(system, input, output, hinge): shafts that meet at the origin, O and centre of mass off their axes.

    The arm of the cross on the input yoke is normal to the plane of the shafts. ``driver(input, hinge, axis)``.
    """
    plane, rng = Plane(51), np.random.default_rng(52)
    a, b = plane.u, plane.at(bend)
    first = random_body(rng, "input", position=-0.5 * a + 0.1)
    second = random_body(rng, "output", position=0.6 * b - 0.1)
    hinge = Revolute(GROUND, first, at=-0.5 * a, axis=a)
    joints = [
        hinge,
        Universal(first, second, at=(0, 0, 0), axis_a=plane.n, axis_b=np.cross(plane.n, b)),
        PointOnLine(GROUND, second, at=b, axis=b),
        driver(first, hinge, a),
    ]
    return System(bodies=[first, second], joints=joints, gravity=(0.3, -0.5, -9.7)), first, second, hinge


def output_rate(solution, body, bend):
    """Angular velocity of the output shaft about its own axis, which is fixed in space."""
    return solution.omega(body) @ Plane(51).at(bend)


def at_speed(first, hinge, axis):
    return SpeedDriver(GROUND, first, axis=axis, speed=RATE)


def at_angle(first, hinge, axis):
    return AngleDriver(hinge, Ramp(RATE))


TURN = 2 * np.pi / RATE * np.arange(256) / 256
"""s: one turn of the input shaft, equally spaced."""


@pytest.mark.parametrize("bend", np.radians([15.0, 30.0, 47.0]))
@pytest.mark.parametrize(("driver", "method"), [(at_speed, None), (at_angle, None), (at_angle, Kinematic())])
def test_cardan_joint_passes_on_the_rate_of_theory(bend, driver, method):
    system, _, second, _ = shaft_pair(bend, driver)
    solution = simulate(system, 2 * np.pi / RATE, method=method, rtol=1e-12, output=TURN)
    ratio = output_rate(solution, second, bend) / RATE
    assert ratio == pytest.approx(theory.cardan_rate(RATE * TURN, bend), abs=1e-10)  # the limit set
    assert ratio.max() / ratio.min() == pytest.approx(shafts.cardan_ratio(bend), rel=1e-10)


def test_cardan_harmonics_at_thirty_degrees():
    bend = np.radians(30.0)
    system, _, second, _ = shaft_pair(bend, at_angle)
    solution = simulate(system, 2 * np.pi / RATE, method=Kinematic(), output=TURN)
    spectrum = np.abs(np.fft.rfft(output_rate(solution, second, bend))) / 256 / RATE
    amplitudes = 2 * spectrum[1:]
    assert spectrum[0] == pytest.approx(1.0, abs=1e-12)  # the mean ratio
    assert amplitudes[[1, 3]] == pytest.approx([0.14359, 0.01031], abs=5e-6)  # as published, five digits
    assert amplitudes[[1, 3, 5]] == pytest.approx(shafts.cardan_harmonics(bend, 3), abs=1e-12)  # rounding
    assert amplitudes[[0, 2, 4]].max() < 1e-12


def test_cardan_motor_gives_back_in_a_turn_what_it_took():
    system, _, _, hinge = shaft_pair(np.radians(38.0), at_angle)
    solution = simulate(system, 2 * np.pi / RATE, method=Kinematic(), output=TURN)
    torque = solution.effort(system.joints[-1])
    assert abs(torque.mean()) < 1e-12 * np.abs(torque).max()  # rounding; weight and inertia do no net work
    assert np.ptp(torque) > 1.0
    assert solution.angle(hinge) == pytest.approx(RATE * TURN, abs=1e-12)  # rounding


def test_cardan_motor_torque_of_balanced_shafts():
    """Only the axial inertia of the output shaft counts when both centres of mass lie on their axes."""
    bend, plane, rng = np.radians(38.0), Plane(51), np.random.default_rng(58)
    first, second = plane.u, plane.at(bend)
    bodies, moments = [], []
    for name, axis, at in (("input", first, -0.5 * first), ("output", second, 0.6 * second)):
        shaft = random_body(rng, name, position=at, com=(0, 0, 0))
        R = matrix(shaft.orientation)
        frame = np.column_stack([axis, other := across(rng, axis), np.cross(axis, other)])
        inertia = R.T @ frame @ np.diag([0.2, 0.7, 0.7]) @ frame.T @ R  # symmetric about the axis
        bodies.append(moved_reference(replace(shaft, inertia=inertia), 0.3 * direction(rng)))
        moments.append(0.2)
    hinge = Revolute(GROUND, bodies[0], at=-0.4 * first, axis=first)
    cross = Universal(*bodies, at=(0, 0, 0), axis_a=plane.n, axis_b=np.cross(plane.n, second))
    driver = AngleDriver(hinge, Ramp(RATE))
    support = PointOnLine(GROUND, bodies[1], at=second, axis=second)
    system = System(bodies=bodies, joints=[hinge, cross, support, driver])
    solution = simulate(system, 2 * np.pi / RATE, method=Kinematic(), output=TURN)
    expected = theory.cardan_motor_torque(RATE * TURN, bend, RATE, moments[1])
    assert solution.effort(driver) == pytest.approx(expected, abs=1e-11)  # rounding of 10 N m
    assert np.ptp(expected) > 10.0


def double_cardan(first_bend, second_bend, seed=53):
    """(system, output, axis of the output shaft): W arrangement with aligned yokes on the middle shaft."""
    plane, rng = Plane(seed), np.random.default_rng(seed)
    a, m, b = plane.at(0.0), plane.at(first_bend), plane.at(first_bend + second_bend)
    far = 0.8 * m
    shafts = [random_body(rng, name, position=0.3 * rng.normal(size=3)) for name in ("input", "middle", "output")]
    hinge = Revolute(GROUND, shafts[0], at=-0.4 * a, axis=a)
    joints = [
        hinge,
        Universal(shafts[0], shafts[1], at=(0, 0, 0), axis_a=plane.n, axis_b=np.cross(plane.n, m)),
        Universal(shafts[1], shafts[2], at=far, axis_a=np.cross(plane.n, m), axis_b=plane.n),
        Cylindrical(GROUND, shafts[2], at=far + 0.5 * b, axis=b),
        AngleDriver(hinge, Ramp(RATE)),
    ]
    return System(bodies=shafts, joints=joints, gravity=(0.3, -0.5, -9.7)), shafts[2], b


@pytest.mark.parametrize("method", [None, Kinematic()])
def test_double_cardan_of_equal_bends_is_uniform(method):
    system, last, axis = double_cardan(np.radians(25.0), np.radians(25.0))
    solution = simulate(system, 2 * np.pi / RATE, method=method, rtol=1e-12, output=TURN)
    assert solution.omega(last) @ axis / RATE == pytest.approx(np.ones(256), abs=1e-11)  # the limit set
    assert np.ptp(np.linalg.norm(solution.omega("middle"), axis=1)) > 0.1 * RATE


def test_double_cardan_of_unequal_bends_follows_its_ratio():
    bends = np.radians(25.0), np.radians(32.0)
    system, last, axis = double_cardan(*bends)
    solution = simulate(system, 2 * np.pi / RATE, method=Kinematic(), output=TURN)
    expected = shafts.double_cardan_ratio(RATE * TURN, *bends)
    assert solution.omega(last) @ axis / RATE == pytest.approx(expected, abs=1e-11)
    assert np.ptp(expected) > 0.1


ENGINE = json.loads((Path(__file__).parents[2] / "engines" / "references" / "engine.json").read_text(encoding="utf-8"))
TOY = ENGINE["toy_set_1"]
CRANK_RATE = TOY["omega"]


def closed_form():
    """The toy engine of the articles."""
    crank, rod = TOY["crank"], TOY["rod"]
    return crank_theory.SliderCrank(
        radius=TOY["R"], rod_length=TOY["L"], crank_mass=crank["mass"], crank_centre=crank["cg_from_pivot"],
        rod_mass=rod["mass"], rod_fraction=rod["cg_fraction_from_crankpin"], rod_inertia=rod["cg_inertia"],
        piston_mass=TOY["piston"]["mass"],
    )  # fmt: skip


START = 0.4
"""rad: crank angle at the reference pose, away from the dead centres."""


def engine(gravity=0.0, signal=None, shift_seed=None):
    """(system, bearing, guide, driver, plane): crank about the normal of a general plane, bore along u, gravity -v.

    Spherical crank pin and universal wrist pin: 17 independent rows, so every reaction is unique.
    """
    plane, e = Plane(54), random_orientation(np.random.default_rng(55))
    R, L, rng = TOY["R"], TOY["L"], np.random.default_rng(56)
    towards, lean = plane.at(START), np.arcsin(TOY["lam"] * np.sin(START))
    pin, along = R * towards, plane.at(-lean)
    wrist = pin + L * along
    B = matrix(e)
    inertia = random_inertia(rng, 4.0)
    # a thin rod: its moment about the normal counts, the others do not matter in the plane
    rod_axes = np.column_stack([along, np.cross(plane.n, along), plane.n])
    rod_inertia = B.T @ rod_axes @ np.diag([0.01, 1.0, 1.0]) @ rod_axes.T @ B * TOY["rod"]["cg_inertia"]
    crank = Body("crank", TOY["crank"]["mass"], inertia, com=B.T @ (0.5 * towards), orientation=e)
    rod = Body("rod", TOY["rod"]["mass"], rod_inertia, position=pin + 0.5 * L * along, orientation=e)
    piston = Body("piston", TOY["piston"]["mass"], inertia, position=wrist, orientation=e)
    if shift_seed is not None:
        shifts = 0.4 * np.random.default_rng(shift_seed).normal(size=(3, 3))
        crank, rod, piston = (moved_reference(b, s) for b, s in zip((crank, rod, piston), shifts, strict=True))
    bearing = Revolute(GROUND, crank, at=(0, 0, 0), axis=plane.n, name="bearing")
    guide = Prismatic(GROUND, piston, at=wrist, axis=plane.u, name="guide")
    driver = AngleDriver(bearing, Ramp(CRANK_RATE) if signal is None else signal, name="driver")
    joints = [
        bearing,
        Spherical(crank, rod, at=pin, name="crank pin"),
        Universal(rod, piston, at=wrist, axis_a=np.cross(plane.n, along), axis_b=plane.n, name="wrist pin"),
        guide,
        driver,
    ]
    return System(bodies=[crank, rod, piston], joints=joints, gravity=-gravity * plane.v), bearing, guide, driver, plane


def one_turn(system, count=720, **options):
    """A driven run over one turn of the crank, equally spaced from the reference pose; (solution, crank angles)."""
    period = 2 * np.pi / CRANK_RATE
    times = period * np.arange(count) / count
    solution = simulate(system, period, method=Kinematic(), output=times, **options)
    return solution, START + CRANK_RATE * times


def block_force(system, bearing, guide, plane, **options):
    """Force on the block along the bore and across it, and the crank angles."""
    solution, angles = one_turn(system, **options)
    force = -solution.reaction(bearing).force - solution.reaction(guide).force
    return force @ np.column_stack([plane.u, plane.v, plane.n]), angles


def harmonics(values, angles):
    """Amplitudes of cos of 0 ... 6 times the crank angle over a full turn."""
    return np.array([2 * np.mean(values * np.cos(k * angles)) for k in range(7)])


@pytest.mark.parametrize("shift", [None, 3])
def test_block_force_of_the_toy_engine(shift):
    system, bearing, guide, _, plane = engine(shift_seed=shift)
    force, angles = block_force(system, bearing, guide, plane)
    bore = harmonics(force[:, 0], angles)
    assert np.abs(bore[[1, 2, 4, 6]]) == pytest.approx([10.966, 4.1111, 0.29497, 0.02382], abs=5e-4)  # as published
    exact = crank_theory.block_force(closed_form(), angles, CRANK_RATE)
    assert force[:, :2] == pytest.approx(exact, abs=1e-9)  # rounding is 1e-13
    assert np.abs(force[:, 2]).max() < 1e-9  # nothing out of the plane


def test_block_force_without_the_centripetal_force_is_that_of_the_articles():
    system, bearing, guide, _, plane = engine()
    force, angles = block_force(system, bearing, guide, plane, centripetal=False)
    assert harmonics(force[:, 0], angles)[1] == pytest.approx(9.870, abs=5e-4)  # as published
    exact = crank_theory.block_force(closed_form(), angles, CRANK_RATE, centripetal=False)
    assert force[:, :2] == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("shift", [None, 4])
@pytest.mark.parametrize(("gravity", "peak"), [(9.81, 33.123), (0.0, 6.8925)])
def test_torque_of_the_toy_engine(gravity, peak, shift):
    system, _, _, driver, _ = engine(gravity, shift_seed=shift)
    solution, angles = one_turn(system, count=3600)
    torque = crank_theory.slider_crank_torque(closed_form(), angles, CRANK_RATE, gravity=(0.0, -gravity))
    assert solution.effort(driver) == pytest.approx(torque, abs=1e-9)  # rounding is 1e-13
    assert np.abs(solution.effort(driver)).max() == pytest.approx(peak, rel=2e-5)  # as published, five digits


def test_pin_forces_of_the_toy_engine():
    system, bearing, guide, _, plane = engine(9.81, shift_seed=5)
    solution, angles = one_turn(system, count=72)
    loads = crank_theory.slider_crank_loads(closed_form(), angles, CRANK_RATE, gravity=(0.0, -9.81))
    seen = np.column_stack([plane.u, plane.v])
    for name, expected in (("bearing", loads.bearing), ("crank pin", loads.crankpin), ("wrist pin", loads.wristpin)):
        assert solution.reaction(name).force @ seen == pytest.approx(expected, abs=1e-9)  # rounding
    assert solution.reaction(guide).force @ plane.v == pytest.approx(loads.guide, abs=1e-9)
    assert all(solution.reaction(joint).unique for joint in (bearing, guide))


def test_kinematic_equals_integration():
    swing = Sine(amplitude=0.9, frequency=0.4, phase=0.5, offset=-0.9 * np.sin(0.5)) + Ramp(1.1)
    system, _, guide, driver, _ = engine(9.81, swing, shift_seed=6)
    times = np.linspace(0.0, 3.0, 31)
    driven = simulate(system, 3.0, method=Kinematic(), output=times)
    integrated = simulate(system, 3.0, rtol=1e-12, output=times)
    for name in ("q", "v", "acceleration"):
        found, expected = driven.arrays[name], integrated.arrays[name]
        assert found == pytest.approx(expected, abs=1e-9 * np.abs(expected).max())  # 1e3 rtol
    assert driven.effort(driver) == pytest.approx(integrated.effort(driver), abs=1e-8)  # of 200 N m
    assert driven.reaction(guide).moment == pytest.approx(integrated.reaction(guide).moment, abs=1e-8)
    assert driven.certificate.passed and integrated.certificate.passed


def test_kinematic_does_not_lose_its_branch_between_rare_samples():
    system, bearing, *_ = engine()
    period = 2 * np.pi / CRANK_RATE
    rare = simulate(system, 5 * period, method=Kinematic(), output=4)
    assert rare.angle(bearing) == pytest.approx(CRANK_RATE * rare.t, abs=1e-12)
    frequent = simulate(system, 5 * period, method=Kinematic(), output=301)
    assert rare.arrays["q"] == pytest.approx(frequent.arrays["q"][::100], abs=1e-12)


@pytest.mark.parametrize("shift", [None, 7])
@pytest.mark.parametrize("pose", range(4))
def test_torques_of_the_six_axis_robot(pose, shift):
    known = robot_poses(shift)[pose]
    drivers = [
        AngleDriver(hinge, Powers((angle, known.rates[hinge], acceleration / 2)))
        for (hinge, angle), acceleration in zip(known.angles.items(), known.accelerations, strict=True)
    ]
    free = known.free
    system = System(bodies=free.bodies, joints=[*free.joints, *drivers], gravity=free.gravity)
    state = system.assemble(angles=known.angles)
    found = accelerations(system, state)
    # torques up to 300 N m; a condition of 1e5 times rounding
    efforts = np.array([found.effort(driver)[0] for driver in drivers])
    torque = np.array(read("robot6r_inverse_dynamics")["reference"]["values"][pose]["tau"])
    assert efforts == pytest.approx(torque, abs=1e-9 * np.abs(torque).max())
    assert hinge_accelerations(found)[0] == pytest.approx(known.accelerations, abs=1e-9)


@pytest.mark.parametrize("shift", [None, 7])
@pytest.mark.parametrize("pose", range(4))
def test_accelerations_of_the_six_axis_robot(pose, shift):
    known = robot_poses(shift)[pose]
    state = known.system.assemble(angles=known.angles, rates=known.rates)
    for system, expected in ((known.system, known.accelerations), (known.free, known.free_accelerations)):
        found = hinge_accelerations(accelerations(system, state))[0]
        assert found == pytest.approx(expected, abs=1e-9 * max(1.0, np.abs(expected).max()))  # as above


def test_hinge_in_general_position_turns_by_the_angle_asked_for():
    rng = np.random.default_rng(57)
    body = random_body(rng)
    hinge = Revolute(GROUND, body, at=direction(rng), axis=direction(rng))
    system = System(bodies=[body], joints=[hinge, AngleDriver(hinge, Ramp(2.0))])
    solution = simulate(system, 4.0, method=Kinematic(), output=9)
    for t, R in zip(solution.t, solution.rotation(body), strict=True):
        turned = matrix(exponential(2.0 * t * hinge.axis)) @ matrix(body.orientation)
        assert np.abs(R - turned).max() < 1e-13  # rounding
