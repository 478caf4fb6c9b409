"""Freedoms that nothing determines, freedoms of one body alone, and drivers that contradict each other: named."""

import re

import numpy as np
import pytest

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AngleDriver,
    AssemblyError,
    Body,
    Gear,
    GeneralizedAlpha,
    IntegrationError,
    Kinematic,
    PointOnLine,
    PointOnPlane,
    Polynomial,
    PositionDriver,
    Prismatic,
    Pulse,
    Ramp,
    Revolute,
    Sine,
    SlideDriver,
    SpeedDriver,
    Spherical,
    System,
    Table,
    Universal,
    inertia,
    simulate,
)
from mbsd3d.rotations import matrix

ROD_AXIS = np.array([0.8, 0.15, -0.5]) / np.linalg.norm([0.8, 0.15, -0.5])


def rod(how, radius=0.0, aside=0.0):
    """A slender rod in general position: turned by its orientation or in its own axes, O on or off its line.

    ``aside``: how far it lies from the line between the balls [m].
    """
    x = np.cross(ROD_AXIS, (0.3, 0.2, 1.0))
    x /= np.linalg.norm(x)
    R = np.column_stack([x, np.cross(ROD_AXIS, x), ROD_AXIS])
    middle = np.array([0.5, 0.425, -0.05]) + aside * x
    moments = inertia.rod(2.0, np.linalg.norm([0.8, 0.15, -0.5]), radius=radius)
    O = middle + ([0.1, -0.2, 0.3] if "off" in how else 0.0)
    if "tensor" in how:
        return Body("rod", 2.0, R @ np.diag(moments) @ R.T, position=O, com=middle - O)
    return Body("rod", 2.0, moments, orientation=R, position=O, com=R.T @ (middle - O))


def rssr(link, driven=False, first=Spherical):
    """Crank, rod and rocker between two hinges and two balls; ``first`` is the joint between crank and rod."""
    A, B, C, D = np.array([[0, 0, 0], [0.1, 0.35, 0.2], [0.9, 0.5, -0.3], [1.1, 0.2, 0.1]], float)
    crank = Body("crank", 1.0, (0.1, 0.12, 0.2), position=B / 2)
    rocker = Body("rocker", 1.0, (0.1, 0.12, 0.2), position=(C + D) / 2)
    across = np.cross(ROD_AXIS, (0, 0, 1))
    axes = {"axis_a": across, "axis_b": np.cross(ROD_AXIS, across)} if first is Universal else {}
    joints = [
        Revolute(GROUND, crank, at=A, axis=(1, 0.2, 0.1), name="crank hinge"),
        first(crank, link, at=B, name="big end", **axes),
        Spherical(link, rocker, at=C, name="small end"),
        Revolute(GROUND, rocker, at=D, axis=(0.2, 0.1, 1), name="rocker hinge"),
    ]
    return System([crank, link, rocker], joints + ([AngleDriver(joints[0], Ramp(0.1))] if driven else []))


SPIN = r"'rod'.* spins freely about its own axis \(0.837, 0.157, -0.523\) through 'big end' and 'small end'"


@pytest.mark.parametrize("how", ["turned", "turned off", "tensor", "tensor off"])
def test_a_rod_without_axial_inertia_is_named_with_axis_and_cure(how):
    found = rssr(rod(how)).check()
    assert found.verdict.startswith("undetermined: 'rod' spins freely about its own axis (0.837, 0.157, -0.523)")
    assert (
        "has no inertia about it; make Spherical 'big end' a Universal with both axes across it, or give"
        in found.verdict
    )
    for method in (DOP853(), GeneralizedAlpha(), Kinematic()):
        with pytest.raises(
            AssemblyError, match=SPIN + " and has no inertia.*'big end' a Universal with.*or give the body"
        ):
            simulate(rssr(rod(how), driven=method.order == 0), 0.1, method=method)


def test_a_start_given_by_hand_is_looked_at_too():
    thick = rssr(rod("tensor", radius=0.01))
    with pytest.raises(AssemblyError, match=SPIN):
        simulate(rssr(rod("tensor")), 0.1, state=thick.state())


@pytest.mark.parametrize("how", ["turned", "tensor off"])
def test_both_cures_cure(how):
    for system in (rssr(rod(how, radius=1e-3)), rssr(rod(how), first=Universal)):
        assert system.check().verdict == "regular: all rows are independent"
        assert simulate(system, 0.1).certificate.passed


def test_a_passive_spin_is_a_freedom_that_is_named():
    found = rssr(rod("turned", radius=0.01)).check()
    assert found.mobility == 2
    assert [note for note in found.notes if "freedom: 'rod' spins freely about its own axis" in note]
    with pytest.raises(
        ValueError,
        match="1 of 18 degrees of freedom.*"
        + SPIN
        + ".*make Spherical 'big end' a Universal with both axes across it$",
    ):
        simulate(rssr(rod("turned", radius=0.01), driven=True), 0.1, method=Kinematic())


def test_a_thin_rod_beside_the_line_between_its_balls_swings_about_it():
    """It has no inertia about its own axis, but m d^2 about the line that it is free to turn about."""
    system = rssr(rod("turned", aside=0.1))
    assert system.check().verdict == "regular: all rows are independent"
    assert simulate(system, 0.1).certificate.passed


def test_a_joint_beside_the_axis_of_a_spin_is_not_named():
    """A point of the ground stays in a plane across the rod, wherever the rod turns about its axis."""
    free = rssr(rod("turned", radius=0.01))
    guide = PointOnPlane(free.part("rod"), GROUND, at=(0.3, -0.4, 0.2), normal=ROD_AXIS, name="guide")
    (note,) = (x for x in System(free.bodies, [*free.joints, guide]).check().notes if "spins freely" in x)
    assert re.search(SPIN, note) and "guide" not in note


def test_wheels_and_pendulums_are_not_spins():
    body, frame = Body("wheel", 1.0, (0.1, 0.1, 0.2)), Body("frame", 1.0, (0.1, 0.1, 0.2), com=(0.1, 0, 0))
    axle = Revolute(frame, body, at=(0, 0, 0), axis=(0, 0, 1))
    swing = Revolute(GROUND, frame, at=(0.3, 0, 0), axis=(0, 1, 0))
    assert System([frame, body], [swing, axle]).check().notes == ()
    two = [
        Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1)),
        PointOnLine(GROUND, body, at=(0, 0, 1), axis=(0, 0, 1)),
    ]
    assert System([body], two).check().notes == ()


def hinged(*drivers):
    """A body off its hinge with drivers made from hinge and body."""
    body = Body("rotor", 1.0, (0.1, 0.12, 0.2), com=(0.1, 0.05, 0.02))
    hinge = Revolute(GROUND, body, at=(0.2, 0.1, 0), axis=(1, 2, 3), name="hinge")
    return System([body], [hinge, *(driver(hinge, body) for driver in drivers)])


def angle(signal, name):
    return lambda hinge, body: AngleDriver(hinge, signal, name=name)


def speed(signal, name):
    return lambda hinge, body: SpeedDriver(GROUND, body, axis=(1, 2, 3), speed=signal, name=name)


@pytest.mark.parametrize(
    ("system", "text"),
    [
        (hinged(speed(2.0, "fast"), speed(1.0, "slow")), "'fast' and Spee.*'slow' prescribe rates .* by 1 for"),
        (hinged(angle(Ramp(2.0), "fast"), angle(Ramp(1.5), "slow")), "'fast' and Angl.*'slow' .* by 0.5 for"),
        (hinged(angle(0.0, "fast"), angle(0.3, "slow")), "'fast' and Angl.*'slow' prescribe positions .* by 0.3"),
        (hinged(angle(Ramp(2.0), "fast"), speed(3.0, "slow")), "'fast' and Spee.*'slow' prescribe rates .* by 1"),
        # the same rate at the start, not later
        (hinged(angle(Ramp(2.0), "fast"), angle(Sine(1.0, 1 / np.pi), "slow")), "'fast' and .*'slow' prescribe rates"),
    ],
)  # fmt: skip
def test_contradictory_drivers_are_both_named(system, text):
    verdict = system.check().verdict
    assert verdict.startswith("contradictory: ")
    assert re.search(text, verdict), verdict
    with pytest.raises(AssemblyError, match="contradictory drivers.*'fast' and .*'slow'.*remove one"):
        simulate(system, 0.3)


@pytest.mark.parametrize("method", [DOP853(), RK4(0.01), GeneralizedAlpha(), Kinematic()])
@pytest.mark.parametrize("geared", [False, True])
def test_drivers_that_part_on_the_way_are_named_when_they_do(method, geared):
    """At the start and at most times they agree; between two hinges a gear makes one motion of two."""
    bodies = [Body(f"rotor {k}", 1.0, (0.1, 0.12, 0.2), com=(0.1, 0.05, 0.02), position=(k, 0, 0)) for k in (0, 1)]
    hinges = [Revolute(GROUND, body, at=body.position, axis=(1, 2, 3)) for body in bodies]
    ratio = -1.7 if geared else 1.0
    drivers = [
        AngleDriver(hinges[0], Sine(0.3, 0.4), name="one"),
        AngleDriver(hinges[geared], Sine(0.3 * ratio, 0.4) + Pulse(0.1, 0.62, 0.02, 0.1), name="other"),
    ]
    system = System(bodies, [*hinges, Gear(*hinges, ratio=-1.7), *drivers])
    with pytest.raises(IntegrationError, match="contradictory drivers.*'one' and .*'other'; remove one") as stopped:
        simulate(system, 1.0, method=method)
    assert stopped.value.time == pytest.approx(0.62, abs=1e-2)  # the fixed step


@pytest.mark.parametrize("seed", range(4))
def test_drivers_that_lock_a_loop_do_not_contradict_each_other(seed):
    """Five hinges through one point, two of them driven until the axes of the others lie in a plane.

    Three rows repeat others: near that pose rounding mixes the drivers into their combinations.
    """
    rng = np.random.default_rng(seed)
    axes = rng.normal(size=(5, 3))
    links = [Body(f"link {k}", 1.0, (0.1, 0.12, 0.15), com=rng.uniform(-0.2, 0.2, 3)) for k in range(4)]
    parts = [GROUND, *links, GROUND]
    hinges = [Revolute(parts[k], parts[k + 1], at=0.3 * axes[k], axis=axes[k]) for k in range(5)]
    motors = [AngleDriver(hinges[0], Ramp(0.3), name="M1"), AngleDriver(hinges[3], Ramp(-0.4), name="M2")]
    system, ended = System(links, [*hinges, *motors]), []
    for method in (Kinematic(), DOP853()):
        with pytest.raises(IntegrationError, match="'M1' .* and driver 'M2' .* where the mechanism locks") as stopped:
            simulate(system, 4.0, method=method, output=9)
        ended.append(stopped.value.time)
        turned = stopped.value.solution.final.q.reshape(-1, 7)[:, 3:]
    assert ended[0] == pytest.approx(ended[1], abs=1e-4)
    now = [matrix(turned[k - 1]) @ axes[k] if k else axes[k] for k in (1, 2, 4)]
    assert abs(np.linalg.det([axis / np.linalg.norm(axis) for axis in now])) < 1e-2  # the square root of the way left


def test_drivers_that_disagreed_before_the_start_are_not_to_blame():
    """Angles and rates are equal at 1 s only; what is wrong is the angular velocity that the user gave."""
    body = Body("rotor", 1.0, (0.1, 0.12, 0.2), com=(0.1, 0.05, 0.02), omega=(0.5, 0.1, 0.2))
    hinge = Revolute(GROUND, body, at=(0.2, 0.1, 0), axis=(1, 2, 3), name="hinge")
    signals = Polynomial((0.0, 1.0)), Polynomial((0.3, 0.4, 0.3))
    system = System([body], [hinge, *(AngleDriver(hinge, signal) for signal in signals)])
    with pytest.raises(AssemblyError, match="the given velocities contradict a joint"):
        system.assemble(t=1.0)


def test_a_driver_of_what_is_locked():
    body = Body("block", 1.0, (0.1, 0.1, 0.2))
    rail = Prismatic(GROUND, body, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    stop = PointOnLine(GROUND, body, at=(0, 0, 0), axis=(0, 1, 0), name="stop")
    system = System([body], [rail, stop, SlideDriver(rail, Ramp(0.2), name="pusher")])
    assert "SlideDriver 'pusher' prescribes a rate that the joints do not allow" in system.check().verdict
    with pytest.raises(AssemblyError, match="SlideDriver 'pusher'; remove it, or a joint"):
        simulate(system, 0.1)


def test_a_driven_door_with_play_is_no_contradiction():
    leaf = Body("door", 20.0, inertia.box(20.0, (0.9, 0.04, 2.0)), com=(0.45, 0, 0))
    upper = Revolute(GROUND, leaf, at=(0, 0, 0.7), axis=(0, 0, 1), name="upper")
    lower = Revolute(GROUND, leaf, at=(0, 0, -0.7), at_b=(0, 1e-6, -0.7), axis=(0, 0, 1), name="lower")
    found = System([leaf], [upper, lower, AngleDriver(upper, Ramp(1.0))]).check()
    assert "contradictory" not in found.verdict
    assert "redundant" in found.verdict


def test_drivers_that_agree_are_only_redundant():
    """Twice the same motion, of whatever kind; and two points of a body driven in step on circles."""
    table = Table(np.linspace(0, 1, 9), 2.0 * np.linspace(0, 1, 9))
    for system in (
        hinged(angle(Ramp(2.0), "a"), angle(Polynomial((0.0, 2.0)), "b")),
        hinged(angle(Ramp(2.0), "a"), speed(2.0, "b")),
        hinged(angle(Ramp(2.0), "a"), angle(table, "b")),
    ):
        assert "redundant, consistent" in system.check().verdict
        assert simulate(system, 0.5).certificate.passed
    plate = Body("plate", 1.0, (0.1, 0.1, 0.2))
    round_trip = lambda r: (Sine(r, 0.5, np.pi / 2, -r), Sine(r, 0.5), 0.0)  # noqa: E731
    drivers = [PositionDriver(plate, at=(r, 0, 0), signal=round_trip(r)) for r in (0.3, 0.7)]
    assert "contradictory" not in System([plate], drivers).check().verdict
