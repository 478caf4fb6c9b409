"""What check() says of doors, four-bars, loops that miss each other, and how the cures are verified."""

import ast
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mbsd3d import (
    GROUND,
    AngleDriver,
    AssemblyError,
    Body,
    Perpendicular,
    PointOnLine,
    Revolute,
    Spherical,
    System,
    TorsionSpring,
    Universal,
    accelerations,
    inertia,
    linearize,
    linkages,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix
from validation import cases
from validation.cases.comparison import compare
from validation.suite.trials.references import allowed

TILT = rotation((1.0, 2.0, -0.5), 0.4)
R = matrix(TILT)


def door(offset=0.0, built=True):
    """A door on two hinges about a tilted axis; the upper one is out of line by ``offset`` [m].

    built: the door's part of the hinge is off; else both parts are, so that it closes but its axes are not collinear.
    """
    out = R @ (offset, 0.0, 0.0)
    leaf = Body("leaf", mass=20.0, inertia=inertia.box(20.0, (0.9, 0.04, 2.0)), com=(0.02, 0.01, -0.03),
                position=R @ (0.45, 0.0, 1.0), orientation=TILT)  # fmt: skip
    low, high, axis = R @ (0.0, 0.0, 0.2), R @ (0.0, 0.0, 1.8), R @ (0.0, 0.0, 1.0)
    bottom = Revolute(GROUND, leaf, at=low, axis=axis, name="bottom")
    top = Revolute(GROUND, leaf, at=high if built else high + out, at_b=high + out, axis=axis, name="top")
    return System(bodies=[leaf], joints=[bottom, top])


def test_door_numbers():
    found = door().check()
    assert (found.rows, found.rank, found.mobility, found.gruebler) == (10, 5, 1, -4)
    assert found.verdict.startswith("redundant, consistent")
    assert {share.joint for share in found.shares} == {"Revolute 'bottom'", "Revolute 'top'"}
    assert not any(share.force_unique or share.moment_unique for share in found.shares)


@pytest.mark.parametrize("turned", [0.0, 0.7])
def test_which_reactions_are_determined_does_not_depend_on_how_far_a_driver_has_turned_the_door(turned):
    """Both bearings push along the common axis; the ball has no moment, wherever its door stands."""
    leaf = Body("leaf", 20.0, (6.7, 8.0, 1.4), com=(0.1, 0.02, 0.3), position=(0.45, 0.1, 1.0))
    axis = np.array([0.3, -0.2, 1.0])
    low = Revolute(GROUND, leaf, at=(0.1, 0.2, 0.0), axis=axis, name="low")
    high = Spherical(GROUND, leaf, at=low.at + 2.0 * axis, name="high")
    system = System([leaf], [low, high, AngleDriver(low, turned, name="motor")])
    assert {share.joint: (share.force_unique, share.moment_unique) for share in system.check().shares} == {
        "Revolute 'low'": (False, False), "Spherical 'high'": (False, True),
    }  # fmt: skip


def test_door_cures_are_those_of_the_design_and_cure():
    texts = [cure.text for cure in door().check().cures]
    assert "remove 'bottom' (Revolute) (5 rows, all independent)" in texts
    wanted = (("bottom", "PointOnLine"), ("top", "Spherical"))
    assert wanted in [cure.replacements for cure in door().check().cures]
    leaf = door().bodies[0]
    low, high, axis = R @ (0.0, 0.0, 0.2), R @ (0.0, 0.0, 1.8), R @ (0.0, 0.0, 1.0)
    cured = System(
        bodies=[leaf], joints=[PointOnLine(GROUND, leaf, at=low, axis=axis), Spherical(GROUND, leaf, at=high)]
    )
    found = cured.check()
    assert (found.rows, found.rank, found.mobility, found.redundant) == (5, 5, 1, 0)


def test_a_cross_can_be_typed_as_its_cure_says():
    """Both axes, with digits enough for a start to meet them."""
    loop, seen = linkages.bricard(0.8, 1.1, orientation=TILT), 0
    for cure in loop.check().cures:
        said = re.fullmatch(
            r"'hinge (\d)' Revolute -> Universal with axis_a = (.+), axis_b = (.+) \(29 rows.*", cure.text
        )
        if said:
            (k, axis_a, axis_b), joints = map(ast.literal_eval, said.groups()), list(loop.joints)
            old = joints[k - 1]
            joints[k - 1] = Universal(old.a, old.b, at=old.at, axis_a=axis_a, axis_b=axis_b)
            cured, seen = System(loop.bodies, joints), seen + 1
            assert cured.state().t == 0.0 and cured.check().redundant == 0
    assert seen


@pytest.mark.parametrize(
    "acting", [lambda h: ([AngleDriver(h, 0.0)], []), lambda h: ([], [TorsionSpring(h, stiffness=3.0)])]
)
def test_a_cure_leaves_an_angle_to_what_acts_on_it(acting):
    """A hinge with a motor or a spring is not removed, nor made a ball."""
    plain, leaf = door(), door().bodies[0]
    bottom, top = (Revolute(GROUND, leaf, at=j.at, axis=j.axis, name=j.name) for j in plain.joints)
    drivers, springs = acting(bottom)
    found = System([leaf], [bottom, top, *drivers], springs).check()
    assert (("top", None),) in [cure.replacements for cure in found.cures]
    kept = {dict(cure.replacements).get("bottom", "Revolute") for cure in found.cures}
    assert kept == {"Revolute", "Cylindrical", "Planar"}


@pytest.mark.parametrize("name", ["door_two_hinges", "sarrus_linkage", "iftomm_A02_fourbar_N2", "iftomm_A03_andrews"])
def test_every_cure_keeps_the_mobility_and_leaves_no_redundancy(name):
    system = cases.load(name, 3).system
    found = system.check()
    assert found.cures
    for cure in found.cures:
        assert cure.rows_removed == found.redundant  # not one row more than the redundant ones is given up


@pytest.mark.parametrize("bars", [3, 5])
def test_a_table_on_upright_bars_has_a_cure(bars):
    """The third bar and those after it repeat a row along which the table moves, one of the two across a hinge."""
    table = Body("table", 2.0, (0.1, 1.0, 1.0), position=(0.4, 0.7, 0.1))
    legs = [Body(f"bar {k}", 1.0, (0.02, 0.1, 0.1), position=(k, 0.1, 0)) for k in range(bars)]
    joints = [Revolute(GROUND, leg, at=(k, 0, 0), axis=(0, 0, 1)) for k, leg in enumerate(legs)]
    joints += [Revolute(leg, table, at=(k, 0.5, 0), axis=(0, 0, 1)) for k, leg in enumerate(legs)]
    found = System([*legs, table], joints).check()
    assert (found.mobility, found.redundant) == (1, 4 * bars - 5)
    assert found.cures and all(cure.rows_removed == found.redundant for cure in found.cures)


def test_net_wrench_is_unique_and_right_where_shares_are_not():
    system = door()
    solution = simulate(system, 0.5, rtol=1e-10)
    top, net = solution.reaction("top"), solution.reaction("bottom", "top")
    assert not top.unique and not solution.reaction("bottom").unique
    assert net.unique
    leaf = system.bodies[0]
    # Newton: net force = m (a_G - g); a_G by the measured motion of the centre of mass
    w, alpha, arm = solution.omega(leaf), solution.alpha(leaf), solution.com(leaf) - solution.position(leaf)
    a_com = solution.acceleration(leaf) + np.cross(alpha, arm) + np.cross(w, np.cross(w, arm))
    np.testing.assert_allclose(net.force, leaf.mass * (a_com - system.gravity), rtol=0, atol=1e-9)  # rounding of 200 N
    summed = solution.reaction("bottom").force + solution.reaction("top").force
    np.testing.assert_allclose(summed, net.force, rtol=0, atol=1e-9)  # shares of least norm still add up


def test_shares_of_least_norm_belong_to_the_mechanism_and_not_to_the_metre():
    """The door at rest with all lengths times 40: the same forces, 40 times the moments."""
    small, size = door(), 40.0
    (leaf,) = small.bodies
    whole = Body("leaf", mass=leaf.mass, inertia=leaf.inertia * size**2, com=leaf.com * size,
                 position=leaf.position * size, orientation=TILT)  # fmt: skip
    hinges = [Revolute(GROUND, whole, at=j.at * size, axis=j.axis, name=j.name) for j in small.joints]
    large = System(bodies=[whole], joints=hinges)
    for name in ("bottom", "top"):
        one, other = (accelerations(system).reaction(name) for system in (small, large))
        assert not one.unique and np.abs(one.moment).max() > 1.0
        np.testing.assert_allclose(other.force, one.force, rtol=0, atol=1e-10)  # rounding of 200 N
        np.testing.assert_allclose(other.moment, size * one.moment, rtol=0, atol=1e-8)  # of 4 kN m


def test_reactions_of_independent_joints_are_unique():
    system = cases.load("iftomm_rscr_slidercrank", 3).system
    solution = simulate(system, 0.1)
    assert all(solution.reaction(joint).unique for joint in system.joints)


@pytest.mark.parametrize("built", [True, False])
def test_one_micron_is_play_and_one_millimetre_locks(built):
    fine, bad = door(1e-6, built).check(), door(1e-3, built).check()
    assert fine.verdict.startswith("redundant within the as-built tolerance")
    assert fine.mobility == 1
    assert fine.misfit == pytest.approx(1e-6, rel=1e-3)  # second-order tilt of the door
    assert bad.verdict.startswith("locked")
    assert bad.mobility == 0
    assert bad.misfit == pytest.approx(1e-3, rel=1e-3)


def test_door_built_one_micron_out_swings_within_the_tolerance():
    solution = simulate(door(1e-6), 0.5, as_built=1e-5)
    assert np.ptp(solution.angle("bottom")) > 0.1
    assert solution.drift().position.max() < 1e-5
    assert solution.certificate.passed, solution.certificate.failures
    now, first = (x.reaction("top", "bottom") for x in (accelerations(door(1e-6), as_built=1e-5), solution))
    np.testing.assert_allclose(now.force[0], first.force[0], rtol=1e-12)


@pytest.mark.parametrize("offset", [0.0, 1e-7, 8e-6])
def test_play_in_a_door_is_no_matter_of_what_hangs_on_it(offset):
    """A wheel and a link on the door, an open branch: its reactions are unique, and the door is not near to moving."""
    door, wheel = (
        Body("door", 5.0, (1, 1, 1), position=(0, 0, 1)),
        Body("wheel", 1.0, (0.1, 0.2, 0.1), position=(2, 0, 0)),
    )
    link = Body("link", 1.0, (0.1, 0.2, 0.1), position=(3.0, 0, 0.3))
    upper = np.array((0.1, 0.2, 1.5))
    joints = [
        Revolute(GROUND, door, at=(0, 0, 0.5), axis=upper - (0, 0, 0.5), name="lower"),
        Revolute(
            GROUND, door, at=upper, at_b=upper + (offset, 0.3 * offset, 0), axis=upper - (0, 0, 0.5), name="upper"
        ),
        Revolute(door, wheel, at=(2, 0, 0.3), axis=(1, 0.2, 0), name="axle"),
        Universal(wheel, link, at=(2.5, 0, 0.3), axis_a=(0, 1, 0), axis_b=(0, 0, 1), name="cross"),
    ]
    found = System([door, wheel, link], joints).check()
    assert [share.joint for share in found.shares] == ["Revolute 'lower'", "Revolute 'upper'"]
    assert found.mobility == found.configuration_freedom == 4 and found.notes == ()


def test_parts_as_built_leave_open_what_exact_ones_do():
    """Hinges of a Sarrus linkage 1e-7 m and rad out, one row let go: the shares are those of least norm, off by that.

    The lever of the misfit is the condition of the loop, below 100; a share that the choice of the row decides would be
    off by as much as it is large.
    """
    rng = np.random.default_rng(8)
    exact = linkages.sarrus((0.6, 0.7), (0.5, 0.8), 1.4, 0.9, reach=0.2, orientation=TILT)

    def off(vector):
        return vector + 1e-7 * rng.normal(size=3)

    crooked = [Revolute(j.a, j.b, at=j.at, at_b=off(j.at), axis=j.axis, axis_b=off(j.axis)) for j in exact.joints]
    fine = simulate(exact, 0.3, output=4)
    rough = simulate(System(exact.bodies, crooked), 0.3, output=4, as_built=1e-5)
    largest = max(np.abs(fine.reaction(joint).force).max() for joint in exact.joints)
    for one, other in zip(exact.joints, crooked, strict=True):
        known, found = fine.reaction(one), rough.reaction(other)
        assert not known.unique and not found.unique
        np.testing.assert_allclose(found.force, known.force, rtol=0, atol=1e-5 * largest)


def test_both_hinges_of_a_door_built_one_micron_out_carry_a_certain_load():
    solution = simulate(door(1e-6), 0.1, output=3, as_built=1e-5)
    assert not solution.reaction("bottom").unique and not solution.reaction("top").unique
    assert solution.reaction("bottom", "top").unique
    loose = simulate(door(), 0.1, output=3, as_built=0.3)  # more play than there is a misfit of
    assert not loose.reaction("top").unique and loose.reaction("bottom", "top").unique


def test_parts_out_of_line_are_told_of_as_built():
    """By a start without it, and by what has no such argument and is no run."""
    crooked = door(1e-6)
    with pytest.raises(AssemblyError, match="does not close .*'top', residual 1e-06; .*or give as_built for parts"):
        simulate(crooked, 0.1)
    for call in (accelerations, linearize):
        with pytest.raises(AssemblyError, match="^the state does not meet a joint .*simulate parts .* with as_built"):
            call(crooked, crooked.state(as_built=1e-5))


def open_loop(gap):
    """Three links in a plane that reach 3 m of a span of 3 m + gap."""
    bodies, joints, before = [], [], GROUND
    for k in range(3):
        body = Body(f"link {k}", mass=1.0, inertia=(0.1, 0.2, 0.2), com=(0.03, 0.01, 0.02), position=(k + 0.5, 0, 0))
        joints.append(Revolute(before, body, at=(k, 0, 0), axis=(0, 0, 1), name=f"pin {k}"))
        bodies.append(body)
        before = body
    joints.append(Revolute(GROUND, before, at=(3 + gap, 0, 0), at_b=(3, 0, 0), axis=(0, 0, 1), name="last pin"))
    return System(bodies=bodies, joints=joints)


def test_the_same_door_again_has_the_same_tolerance():
    solution = simulate(door(1e-6), 0.05, as_built=1e-5, output=3)
    again = solution.again()
    assert again.record.tolerance == pytest.approx(solution.record.tolerance, rel=1e-15, abs=0)
    # the tolerance comes back to rounding, so steps may differ within rtol 1e-8 of an angle of 3e-3 rad
    assert again.angle("bottom") == pytest.approx(solution.angle("bottom"), abs=1e-10)


def test_a_loop_that_cannot_close_names_gap_and_joint():
    found = open_loop(2.0).check()
    assert "cannot close: a gap of 2 m remains at Revolute 'last pin'" in found.verdict


def test_a_loop_that_can_close_is_closed_before_it_is_judged():
    found = open_loop(-0.5).check()
    assert found.misfit == 0.0
    assert (found.rank, found.mobility) == (17, 1)


def test_bicycle_freedoms():
    found = cases.load("bicycle_M1", 3).system.check()
    assert (found.coordinates, found.velocities, found.configuration_freedom, found.velocity_freedom) == (28, 24, 7, 3)


def test_singular_reference_pose_is_said():
    """A parallelogram laid flat: all rods collinear, one rank less than a little away from it."""
    raw = cases.read("eig_fourbar2_hanging")
    system = cases.build(raw).system
    flat = system.assemble(angles={"A0": np.pi / 2})
    placed = [
        Body(b.name, b.mass, b.inertia, position=flat.q[7 * i : 7 * i + 3], orientation=flat.q[7 * i + 3 : 7 * i + 7])
        for i, b in enumerate(system.bodies)
    ]
    turned = {id(old): new for old, new in zip(system.bodies, placed, strict=True)}
    where = {"A0": (0, 0), "A1": (1, 0), "A2": (2, 0), "B0l": (1, 0), "B0r": (2, 0), "B1l": (2, 0), "B1r": (3, 0)}
    joints = []
    for j in system.joints:
        a, b = turned.get(id(j.a), j.a), turned.get(id(j.b), j.b)
        joints.append(Revolute(a, b, at=(*where[j.name], 0), axis=(0, 0, 1), name=j.name))
    found = System(bodies=placed, joints=joints, gravity=(0, -9.81, 0)).check()
    assert found.rank == 27
    assert max(found.neighbour_ranks) == 29
    assert "singular (rank 27, 29 beside it): " in str(found)


def test_report_reads():
    text = str(door().check())
    for piece in (
        "10 rows of rank 5",
        "mobility 1",
        "Gruebler count -4",
        "remedy:",
        "indeterminate forces and moments",
    ):
        assert piece in text


@pytest.mark.parametrize("shift", [None, 7, 9])
def test_the_change_point_of_the_four_bar_passes(shift):
    """Twice a turn all rods are collinear and the rank drops from 29 to 27; the motion goes on along its branch."""
    case = cases.load("iftomm_A02_fourbar_N2", shift)
    solution = simulate(case.system, case.t_end, rtol=1e-8, output=case.times)
    assert compare(case, solution).scaled_error < allowed(case, 1e-8)
    assert solution.certificate.passed, solution.certificate.failures


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-6])
def test_small_parts_are_built_as_well_as_large_ones(size):
    """Hinges out of line by a hundredth of a door: 1e-5 m, what parts of a decimetre may miss, is a door of microns."""
    leaf = Body("leaf", size**3, (size**5,) * 3, position=(0.4 * size, 0.1 * size, 0))
    hinges = [Revolute(GROUND, leaf, at=(x * size, 0, z * size), axis=(0, 0, 1)) for x, z in ((0, -1), (0.01, 1))]
    assert System([leaf], hinges[:1]).check().verdict.startswith("regular")
    assert System([leaf], hinges).check().verdict.startswith("locked")


@pytest.mark.parametrize("joint", [Universal, Perpendicular])
def test_axes_typed_in_seven_digits_are_squared(joint):
    """Off by 2e-8, which a start would not meet; the second axis gives way."""
    turn = Rotation.from_rotvec((0.4, -0.7, 0.2)).as_matrix().round(7)
    part = Body("part", 1.2, (0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    at = {"at": (0.1, 0.2, 0.3)} if joint is Universal else {}
    made = joint(GROUND, part, axis_a=turn[0], axis_b=turn[1], **at)
    assert 1e-9 < abs(turn[0] @ turn[1]) < 1e-6 and abs(made.axis_a @ made.axis_b) < 1e-15
    np.testing.assert_allclose(made.axis_a, turn[0], rtol=0, atol=1e-7)  # as long as one
    assert System([part], [made]).state().q[0] == 0.4
