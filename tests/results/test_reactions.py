"""What redundant constraints determine of reactions: against the same mechanisms with the remedies of `check` applied.

A remedy takes out redundant rows and nothing else, so the motion and all that is determined stay the same; what is open
takes the share of the remedy, another one for each.
"""

from dataclasses import replace

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Cylindrical,
    Kinematic,
    PointOnLine,
    PointOnPlane,
    Prismatic,
    Ramp,
    Revolute,
    Spherical,
    System,
    Universal,
    bearing_load,
    bearing_pair,
    linkages,
    load,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix
from mbsd3d.view.scene.frames import frames_of
from mbsd3d.view.scene.overlays import arrows_of

R = matrix(rotation((0.3, -1.0, 0.7), 0.9))
ORIGIN, NORMAL = np.array([0.4, -1.2, 2.3]), R[:, 2]
RTOL, LIMIT = 1e-12, 1e-8  # of a run, and of reactions relative to the largest: as asked, 1e4 times the steps' errors
PULL = (1.2, -3.0, -8.0)


def at(x, y, z=0.0):
    """A place in a plane that no axis is aligned with."""
    return ORIGIN + R @ np.array([x, y, z])


def part(name, x, y, mass=1.3):
    """A body, its centre of mass beside its reference point and out of the plane."""
    com = 0.1 * np.array([np.sin(7.0 * mass), np.cos(3.0 * mass), np.sin(5.0 * mass) + 0.4])
    turn = rotation((0.2, 0.5, -0.1), mass)
    return Body(name, mass, mass * np.diag([0.02, 0.03, 0.04]), position=at(x, y, 0.07), com=com, orientation=turn)


def hinge(a, b, place, name):
    return Revolute(a, b, at=at(*place), axis=NORMAL, name=name)


def slider_crank():
    """All of it hinges, as it is drawn; r = 0.5 m, l = 1.3 m."""
    pin = 0.5 * np.array([np.cos(0.6), np.sin(0.6)])
    head = np.array([pin[0] + np.sqrt(1.3**2 - pin[1] ** 2), 0.0])
    crank, rod, piston = part("crank", 0.1, 0.2), part("rod", 0.6, 0.2, 2.1), part("piston", *head, 0.7)
    joints = [
        hinge(GROUND, crank, (0, 0), "main"), hinge(crank, rod, pin, "pin"), hinge(rod, piston, head, "wrist"),
        Prismatic(GROUND, piston, at=at(*head), axis=R[:, 0], name="bore"),
    ]  # fmt: skip
    return System([crank, rod, piston], joints, gravity=PULL)


def four_bar():
    pins = [(0, 0), (0.3, 0.6), (1.6, 0.9), (1.4, -0.1)]
    bodies = [part("crank", 0.1, 0.3, 1.1), part("coupler", 0.9, 0.8, 2.0), part("rocker", 1.5, 0.4, 1.6)]
    chain = [GROUND, *bodies, GROUND]
    joints = [hinge(chain[k], chain[k + 1], pins[k], f"pin {k}") for k in range(4)]
    return System(bodies, joints, gravity=PULL)


def three_cranks():
    """A coupler on three parallel cranks: moves as on two, and no force in the plane is determined."""
    feet, arm = [(0, 0), (0.9, 0.2), (2.1, -0.1)], np.array([0.25, 0.4])
    coupler = part("coupler", 1.0, 0.5, 2.4)
    cranks = [part(f"crank {k}", foot[0], foot[1] + 0.2, 1.0 + 0.3 * k) for k, foot in enumerate(feet)]
    joints = [hinge(GROUND, crank, foot, f"foot {k}") for k, (crank, foot) in enumerate(zip(cranks, feet, strict=True))]
    joints += [
        hinge(crank, coupler, arm + foot, f"top {k}") for k, (crank, foot) in enumerate(zip(cranks, feet, strict=True))
    ]
    return System([coupler, *cranks], joints, gravity=PULL)


def hung_door():
    """On two balls: the share along the line through both is open."""
    leaf = part("leaf", 0.5, 0.1, 2.2)
    return System(
        [leaf], [Spherical(GROUND, leaf, at=at(*x), name=n) for x, n in (((0, -0.4), "low"), ((0.1, 1.1), "top"))]
    )


def crankshaft():
    """On three bearings in line."""
    shaft = part("shaft", 0.1, 0.05, 2.0)
    bearings = [Revolute(GROUND, shaft, at=at(0, 0, z), axis=NORMAL, name=f"main {z}") for z in (0.0, 0.3, 0.9)]
    return System([shaft], bearings, gravity=PULL)


def remedied(system, kinds, normal=None):
    """The mechanism with joints of other kinds, by name, at the same places."""
    joints = []
    for joint in system.joints:
        place, kind = dict(a=joint.a, b=joint.b, at=joint.at, name=joint.name), kinds.get(joint.name, type(joint))
        if kind is type(joint):
            joints.append(joint)
        elif kind is PointOnPlane:
            joints.append(PointOnPlane(**place, normal=normal))
        elif kind is Universal:
            joints.append(Universal(**place, axis_a=np.cross(joint.axis, (1, 0, 0)), axis_b=joint.axis))
        else:
            joints.append(kind(**place, axis=joint.axis) if kind in (Cylindrical, PointOnLine) else kind(**place))
    return System(system.bodies, joints, gravity=system.gravity)


def run_of(system, state):
    return simulate(system, 0.8, state=state, rtol=RTOL, output=9)


def moving(system, rate=4.0):
    return run_of(system, system.assemble(rates={system.joints[0]: rate}))


def both(system, kinds, normal=None, rate=4.0):
    """The same motion as drawn and with a remedy."""
    other = remedied(system, kinds, normal)
    assert other.check().redundant == 0 and other.check().mobility == system.check().mobility
    start = system.assemble(rates={system.joints[0]: rate})
    drawn, cured = run_of(system, start), run_of(other, replace(start, coordinates=None))
    assert drawn.certificate.passed and cured.certificate.passed
    return drawn, cured


@pytest.fixture(scope="module")
def slider():
    return moving(slider_crank())


def check_determined(drawn, cured):
    """What is determined of every joint that was not replaced is what it carries with the remedy."""
    for name, kind in ((joint.name, type(joint)) for joint in drawn.system.joints):
        if type(cured.system.part(name, "joints")) is not kind:
            continue  # its wrench lacks what the remedy takes out
        one, two = drawn.reaction(name), cured.reaction(name)
        force = np.einsum("tij,tj->ti", one.force_projector, one.force - two.force)
        moment = np.einsum("tij,tj->ti", one.moment_projector, one.moment - two.moment)
        size = np.abs(two.force).max()  # of a mechanism of one metre
        assert not one.unique and two.unique and max(np.abs(force).max(), np.abs(moment).max()) < LIMIT * size


def directions(run, joint):
    """How many directions of the force and the moment are determined, at a general sample."""
    found = run.reaction(joint)
    return tuple(int(round(np.trace(D[4]))) for D in (found.force_projector, found.moment_projector))


UP = R @ np.array([0.4, -0.25, 0.0])  # in the plane, across the cranks
REMEDIES = [
    (slider_crank, {"pin": Spherical, "wrist": Cylindrical}),
    (slider_crank, {"pin": PointOnLine}),
    (four_bar, {"pin 1": Cylindrical, "pin 2": Spherical}),
    (four_bar, {"pin 0": PointOnLine}),
    (three_cranks, {"foot 0": Cylindrical, "top 0": Spherical, "top 2": PointOnPlane}),
]


@pytest.mark.parametrize(("make", "kinds"), REMEDIES)
def test_what_is_determined_is_that_of_the_mechanism_with_a_remedy(make, kinds):
    check_determined(*both(make(), kinds, normal=UP))


def test_hinges_in_a_plane_leave_the_axis_open_and_no_more(slider):
    """Force along the normal, moment across it; the normal has no zero, so no world component is determined."""
    for joint in slider.system.joints:
        found = slider.reaction(joint)
        assert not found.unique and not found.unique_force.any() and not found.unique_moment.any()
        assert directions(slider, joint) == (2, 1)
        assert np.abs(found.force_projector[3] - np.eye(3) + np.outer(NORMAL, NORMAL)).max() < 1e-9
        assert np.abs(found.determined_force @ NORMAL).max() < 1e-9 * np.abs(found.force).max()


def test_the_radial_load_is_given_and_the_rest_raises(slider):
    _, other = both(slider_crank(), {"pin": Spherical, "wrist": Cylindrical})
    wanted, found = bearing_load(other, "main"), bearing_load(slider, "main")
    assert found.radial == pytest.approx(wanted.radial, rel=LIMIT) and wanted.tilting.max() > 1.0
    for name in ("main", "pin", "wrist"):
        found = bearing_load(slider, name)
        assert np.isnan(found.force[:, 2]).all() and np.isfinite(found.force[:, :2]).all()
        for what in ("axial", "tilting"):
            with pytest.raises(
                ValueError, match=rf"'{name}': redundant constraints leave its {what}.* see system.check"
            ):
                getattr(found, what)
        with pytest.raises(ValueError, match="leave its tilting moment open"):
            bearing_pair(slider, name, fixed=found.point[0], floating=found.point[0] + NORMAL)
    assert "up to nan" not in repr(bearing_load(slider, "main"))


def test_loads_in_the_plane_of_three_cranks_are_open():
    run = moving(three_cranks())
    for k in range(3):
        assert directions(run, f"foot {k}") == (1, 1)
        with pytest.raises(ValueError, match=f"'foot {k}' .Revolute.: redundant constraints leave its reaction open"):
            bearing_load(run, f"foot {k}")
    net = run.reaction("top 0", "top 1", "top 2")
    assert net.unique  # what moves the coupler


def test_two_balls_leave_their_line_open():
    run = simulate(hung_door(), 0.8, rtol=RTOL, output=9)
    leaf = run.system.bodies[0]
    line = (at(0.1, 1.1) - at(0, -0.4)) / np.linalg.norm((0.1, 1.5))
    top, both = run.reaction("top"), run.reaction("top", "low")
    assert directions(run, "top") == (2, 3) and both.unique and np.abs(top.moment).max() < 1e-9
    force = leaf.mass * (run.acceleration(leaf) + (0, 0, 9.81))  # of O; the mass centre's by the body's motion
    s = np.einsum("tij,j->ti", run.rotation(leaf), leaf.com)
    force += leaf.mass * (np.cross(run.alpha(leaf), s) + np.cross(run.omega(leaf), np.cross(run.omega(leaf), s)))
    assert both.force == pytest.approx(force, abs=1e-8 * np.abs(force).max())
    about_low = both.moment + np.cross(both.point - at(0, -0.4), both.force)
    across = np.cross(about_low, line) / np.linalg.norm(
        (0.1, 1.5)
    )  # of the upper one, from moments about the lower one
    assert top.determined_force == pytest.approx(across, abs=1e-8 * np.abs(force).max())
    turned = bearing_load(run, "top", axis=line)
    assert turned.radial == pytest.approx(np.linalg.norm(across, axis=1), rel=1e-7)
    with pytest.raises(ValueError, match="leave its axial force open"):
        _ = turned.axial


def test_a_shaft_on_three_bearings_shares_everything():
    run = moving(crankshaft())
    assert directions(run, "main 0.3") == (0, 1) and run.reaction("main 0.0", "main 0.3", "main 0.9").unique
    assert (
        np.abs(run.reaction("main 0.3").determined_moment).max() < 1e-9 * np.abs(run.reaction("main 0.3").force).max()
    )
    with pytest.raises(ValueError, match="leave its reaction open across the axis"):
        bearing_load(run, "main 0.3")


BENNETT = (0.7, 0.6, 0.7 * np.sin(1.9) / np.sin(0.6), 1.9, 0.9)
SARRUS = ((0.5, 0.6), (0.45, 0.7), 1.9, 0.8)


TURNED = dict(orientation=rotation((0.3, -1.0, 0.7), 0.9), gravity=PULL)
IN_SPACE = [
    (linkages.bennett(*BENNETT, **TURNED), {"hinge 1": PointOnLine}),
    (linkages.bennett(*BENNETT, **TURNED), {"hinge 2": Spherical, "hinge 3": Cylindrical}),
    (linkages.sarrus(*SARRUS, reach=0.2, **TURNED), {"hinge 1": Universal}),
]


@pytest.mark.parametrize(("system", "kinds"), IN_SPACE)
def test_loops_in_space(system, kinds):
    """Open directions of a Bennett linkage turn with its links and fit no axis."""
    check_determined(*both(system, kinds, rate=1.0))


def coupled_wheels():
    """Two wheels and a rod that pass their dead centre at 0.25 s, driven by a turn a second; in a tilted plane."""
    pin = np.array([0.0, 0.5])
    one, two, rod = part("wheel", 0, 0), part("far wheel", 3, 0), part("rod", 1.5, 0.5, 2.0)
    drive = hinge(GROUND, one, (0, 0), "axle")
    joints = [
        hinge(one, rod, pin, "pin"),
        hinge(rod, two, pin + (3, 0), "far pin"),
        hinge(GROUND, two, (3, 0), "far axle"),
    ]
    return System([one, rod, two], [drive, *joints, AngleDriver(drive, Ramp(2 * np.pi))], gravity=PULL)


def test_a_singular_sample_says_nothing_about_the_others():
    """The middle sample of five is the dead centre: loads in the plane are open there and determined elsewhere."""
    run = simulate(coupled_wheels(), 0.5, method=Kinematic(), output=5)
    found = bearing_load(run, "far axle")
    assert np.isfinite(found.radial).all()
    ranks = np.trace(run.reaction("far axle").force_projector, axis1=1, axis2=2).round(6)
    assert ranks.tolist() == [2.0, 2.0, 1.0, 2.0, 2.0]


def aligned():
    """The slider-crank in the plane of x and z."""
    crank, rod = (
        Body("crank", 1.0, (0.1, 0.1, 0.1), position=(0.2, 0.03, 0)),
        Body("rod", 2.0, (0.1, 0.2, 0.2), position=(0.9, 0, 0.1)),
    )
    piston = Body("piston", 0.5, (0.1, 0.1, 0.1), position=(1.6, 0.01, 0))
    pin = (0.36, 0.0, 0.27)
    head = (0.36 + np.sqrt(1.3**2 - 0.27**2), 0.0, 0.0)
    y = (0, 1, 0)
    joints = [
        Revolute(GROUND, crank, at=(0, 0, 0), axis=y, name="main"), Revolute(crank, rod, at=pin, axis=y, name="pin"),
        Revolute(rod, piston, at=head, axis=y, name="wrist"),
        Prismatic(GROUND, piston, at=head, axis=(1, 0, 0), name="bore"),
    ]  # fmt: skip
    return System([crank, rod, piston], joints)


def test_masks_stand_in_files_and_in_figures(tmp_path):
    run = simulate(aligned(), 0.2, output=5)
    found = run.reaction("main")
    assert found.unique_force.tolist() == [True, False, True] and found.unique_moment.tolist() == [False, True, False]
    again = load(run.save(tmp_path / "run")).reaction("main")
    assert again.unique_force.tolist() == [True, False, True]
    assert np.array_equal(again.determined_force, found.determined_force)
    table = run.to_dataframe()
    assert table["main.reaction_unique_force.x [1]"].tolist() == [1.0] * 5
    assert table["main.reaction_unique_force.y [1]"].tolist() == [0.0] * 5
    assert np.array_equal(table["main.reaction_determined_force.z [N]"], found.determined_force[:, 2])
    data = run.to_xarray()
    assert data.reaction_unique_force.dims == ("joint", "axis")
    assert data.reaction_unique_moment.sel(joint="bore").values.tolist() == [0, 1, 0]
    assert np.array_equal(data.reaction_determined_force.sel(joint="pin"), run.reaction("pin").determined_force)
    force, moment = run.plot("reaction", "main").axes
    assert [t.get_text() for t in force.get_legend().get_texts()] == ["x", "y, not unique", "z"]
    assert [t.get_text() for t in moment.get_legend().get_texts()] == ["x, not unique", "y", "z, not unique"]


def test_arrows_and_reports_show_the_determined_part():
    run = simulate(aligned(), 0.2, output=5)
    page = run.report(curves=[]).html
    assert "force determined in part, moment indeterminate" in page and "it is this part" in page
    force = next(x for x in arrows_of(run, frames_of(run)) if x.kind == "reaction force")
    assert not any(force.uncertain) and np.abs(force.vectors[:, :, 1]).max() < 1e-9 * force.longest  # in the plane


def test_figures_of_a_tilted_plane_show_what_is_determined(slider):
    force, _ = slider.plot("reaction", "main").axes
    assert force.get_legend().get_title().get_text() == "the determined part"
    drawn = np.stack([line.get_ydata() for line in force.get_lines()], axis=1)
    assert drawn == pytest.approx(slider.reaction("main").determined_force, abs=1e-12)
    sizes = slider.plot("reaction").axes[0]
    assert sizes.get_legend().get_title().get_text().startswith("determined part: main,")


def test_check_says_in_which_direction_a_joint_is_open():
    text = str(aligned().check())
    assert (
        "Revolute 'main': 3 of 5 rows in redundant sets, indeterminate forces along (0, 1, 0) and moments across (0, 1"
        in text
    )
    (low, top) = hung_door().check().shares
    x, y, z = (at(0.1, 1.1) - at(0, -0.4)) / np.linalg.norm((0.1, 1.5))
    said = [float(value) for value in low.force_open.removeprefix("along (").removesuffix(")").split(",")]
    assert np.abs(np.cross(said, (x, y, z))).max() < 2e-3 and low.moment_unique and not top.force_unique  # three digits
