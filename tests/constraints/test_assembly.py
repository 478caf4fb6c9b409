"""Assembling: tree joints by forward kinematics, loops by Newton, targets, pinned bodies, least-energy velocities."""

import numpy as np
import pytest
from helpers.chains import AXIS, INERTIA, arm, four_bar

from mbsd3d import (
    GROUND,
    AngleDriver,
    AssemblyError,
    Body,
    Constant,
    Cylindrical,
    Distance,
    Gear,
    GearMesh,
    Prismatic,
    RackPinion,
    Revolute,
    System,
    accelerations,
    measures,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix


def test_tree_takes_any_angles_exactly():
    system = arm()
    wanted = {"hinge 0": 2.5, "hinge 1": -1.9, "hinge 2": 7.0}  # more than a turn keeps its count
    state = system.assemble(angles=wanted)
    found = accelerations(system, state)
    for name, value in wanted.items():
        assert found.angle(name)[0] == pytest.approx(value, abs=1e-12)  # rounding of a rotation chain
    assert found.drift().position[0] < 1e-14


def test_forward_kinematics_matches_composed_rotations():
    system = arm(2)
    a, b = 0.8, -1.3
    state = system.assemble(angles={"hinge 0": a, "hinge 1": b})
    first = matrix(rotation(AXIS, a))
    second = first @ matrix(rotation(system.joints[1].axis, b))
    expected = first @ system.joints[1].at + second @ (system.bodies[1].position - system.joints[1].at)
    np.testing.assert_allclose(state.q[7:10], expected, rtol=0, atol=1e-13)


def test_loop_closes_at_a_driven_angle_and_reports_what_moved():
    system = four_bar()
    state = system.assemble(angles={"drive": 0.9})
    found = accelerations(system, state)
    assert found.angle("drive")[0] == pytest.approx(0.9, abs=1e-12)
    assert found.drift().position[0] < 1e-13
    distance, angle = state.moved["crank"]
    assert angle == pytest.approx(0.9, abs=1e-12)
    assert distance == pytest.approx(2 * 0.1 * np.sin(0.45), abs=1e-12)  # chord of the crank's reference point
    assert state.moved["rocker"][1] > 0.1


def test_slide_and_measure_targets():
    block = Body("block", mass=2.0, inertia=INERTIA, com=(0.1, 0.02, 0.03), position=(0.3, -0.2, 0.5))
    rail = Prismatic(GROUND, block, at=(0.3, -0.2, 0.5), axis=AXIS, name="rail")
    system = System(bodies=[block], joints=[rail])
    assert accelerations(system, system.assemble(slides={rail: 0.37})).slide(rail)[0] == pytest.approx(0.37, abs=1e-14)
    height = measures.position(block, axis=(0, 0, 1))
    state = system.assemble(measures={height: 1.1})
    assert accelerations(system, state).com(block)[0, 2] == pytest.approx(1.1, abs=1e-9)


def test_a_rod_has_the_length_it_is_given():
    system = arm(1)
    rod = Distance(GROUND, system.bodies[0], at_a=(0.1, 0.7, 0.2), at_b=(0.3, 0.1, 0.05), length=0.57)
    found = accelerations(closed := System(system.bodies, [*system.joints, rod]), closed.assemble())
    assert np.linalg.norm(found.body_point(rod.b, rod.at_b)[0] - rod.at_a) == pytest.approx(0.57, abs=1e-12)


def test_pinned_bodies_stay():
    system = four_bar()
    state = system.assemble(pinned=[system.part("rocker")])
    np.testing.assert_array_equal(state.q[14:], np.r_[system.bodies[2].position, system.bodies[2].orientation])
    chain = arm()
    tip, first = chain.bodies[2], chain.bodies[0]
    height = measures.position(tip, axis=(0, 0, 1))
    wanted = accelerations(chain, chain.assemble(angles={"hinge 1": 0.3, "hinge 2": -0.4})).com(tip)[0, 2]
    state = chain.assemble(measures={height: wanted}, pinned=[first])
    assert accelerations(chain, state).com(tip)[0, 2] == pytest.approx(wanted, abs=1e-9)
    np.testing.assert_array_equal(state.q[:7], np.r_[first.position, first.orientation])


def test_pinned_bodies_stay_where_an_angle_is_asked_for():
    """A hinge between two that are held does not turn; one of a floating chain moves the other link."""
    system = arm()
    with pytest.raises(AssemblyError, match="misses the angle of 'hinge 2' asked for by -0.4"):
        system.assemble(angles={"hinge 2": 0.4}, pinned=[system.bodies[2], system.bodies[1]])
    floating = System(bodies=system.bodies, joints=system.joints[1:])
    state = floating.assemble(angles={"hinge 1": 0.4}, pinned=[system.bodies[1]])
    np.testing.assert_array_equal(state.q[7:14], np.r_[system.bodies[1].position, system.bodies[1].orientation])
    assert accelerations(floating, state).angle("hinge 1")[0] == pytest.approx(0.4, abs=1e-12)


def test_what_a_pose_does_not_give_is_not_asked_of_it():
    system = four_bar()
    speed = measures.rate(system.part("drive", "joints"))
    with pytest.raises(ValueError, match="rate of drive does not follow from a pose; .* rates="):
        system.assemble(measures={speed: 0.0}, rates={"drive": 2.0})


@pytest.mark.parametrize("angle", [2.0, -50.3])
def test_gears_and_racks_follow_over_many_turns(angle):
    """b = -0.5 a by a Gear, c = r_a/r_b a by teeth inside, the rack 0.13 c; on shafts that are not parallel too."""
    wheels = [Body(f"wheel {k}", 1.0, INERTIA, com=(0.02, 0.01, 0.03), position=(0.3 * k, 0.1, 0)) for k in range(3)]
    rack = Body("rack", 2.0, INERTIA, position=(0.4, 0.5, 0.2))
    a, c = (Revolute(GROUND, wheels[k], at=(0.2 * k, 0, 0), axis=(0, 0, 1), name="abc"[k]) for k in (0, 2))
    b = Revolute(GROUND, wheels[1], at=(0.3, 0.1, 0), axis=(0.3, -0.5, 0.8), name="b")
    rail = Prismatic(GROUND, rack, at=(0, 0, 0), axis=AXIS, name="rail")
    mesh = GearMesh(a, c, at=(-0.1, 0, 0), helix_angle=0.2)
    system = System([*wheels, rack], [a, b, c, rail, Gear(a, b, ratio=-0.5), mesh, RackPinion(c, rail, radius=0.13)])
    found = accelerations(system, system.assemble(angles={"a": angle}))
    turned = [found.angle("b")[0], found.angle("c")[0], found.slide("rail")[0]]
    np.testing.assert_allclose(turned, [-0.5 * angle, angle / 5.0, 0.13 * angle / 5.0], rtol=1e-12)


def test_near_stays_on_the_branch():
    system = four_bar()
    start = system.assemble(angles={"drive": 0.5})
    state = system.assemble(angles={"drive": 0.52}, near=start)
    assert np.abs(state.q - start.q).max() < 0.05  # a small step of the crank is a small step of all


def test_rates_give_consistent_velocities():
    system = four_bar()
    state = system.assemble(angles={"drive": 0.4}, rates={"drive": 3.0})
    found = accelerations(system, state)
    assert found.rate("drive")[0] == pytest.approx(3.0, abs=1e-12)
    assert found.drift().velocity[0] < 1e-12
    ahead = system.assemble(angles={"drive": 0.4 + 3e-5}, near=state)
    behind = system.assemble(angles={"drive": 0.4 - 3e-5}, near=state)
    difference = (ahead.q[14:17] - behind.q[14:17]) / 2e-5  # the rocker's velocity by differences of poses
    np.testing.assert_allclose(found.velocity("rocker")[0], difference, rtol=0, atol=1e-8)


def test_the_rate_of_a_joint_that_turns_and_slides_is_that_of_its_angle():
    nut = Body("nut", mass=2.0, inertia=INERTIA, com=(0.1, 0.02, 0.03), position=(0.3, -0.2, 0.5))
    sleeve = Cylindrical(GROUND, nut, at=(0.3, -0.2, 0.5), axis=AXIS, name="sleeve")
    system = System([nut], [sleeve])
    found = accelerations(system, system.assemble(rates={sleeve: 3.0}))
    np.testing.assert_allclose(found.omega(nut)[0], 3.0 * AXIS, rtol=0, atol=1e-12)


def test_unknown_velocities_take_least_kinetic_energy():
    system = arm(2)
    spun = System(
        bodies=[
            system.bodies[0],
            Body("tip", mass=2.0, inertia=INERTIA, com=(0.05, -0.03, 0.02), position=system.bodies[1].position,
                 omega=1.5 * system.joints[1].axis),
        ],
        joints=[],
        gravity=(0, 0, 0),
    )  # fmt: skip
    tip = spun.bodies[1]
    free = System(bodies=[tip], gravity=(0, 0, 0))
    found = accelerations(free, free.state())
    # with omega given and velocity free, the centre of mass stays at rest: least energy
    np.testing.assert_allclose(found.velocity(tip)[0] + np.cross(tip.omega, tip.com), 0.0, rtol=0, atol=1e-14)


def test_driver_gives_the_start_velocity():
    system = four_bar()
    drive = AngleDriver(system.joints[0], Constant(0.0))
    state = System(bodies=system.bodies, joints=[*system.joints, drive]).state()
    assert np.abs(state.v).max() == 0.0


def test_what_cannot_close_names_the_gap():
    system = four_bar()
    with pytest.raises(AssemblyError, match="cannot close with this angle of 'drive', angle of 'output', a gap"):
        system.assemble(angles={"drive": 0.4, "output": 2.5})


def test_values_out_of_reach_are_no_fault_of_the_joints():
    """A crank takes its angle, and a block on a level rail cannot rise, nor move at all where it is pinned."""
    crank, block = (Body(name, mass=1.0, inertia=INERTIA, com=(0.1, 0.02, 0.03)) for name in ("crank", "block"))
    rail = Prismatic(GROUND, block, at=(0, 0, 0), axis=(0.6, 0.8, 0), name="rail")
    system = System([crank, block], [Revolute(GROUND, crank, at=(0, 0, 0), axis=AXIS, name="drive"), rail])
    wanted = dict(angles={"drive": 0.5}, measures={measures.position(block, axis=(0, 0, 1)): 0.43})
    asked = "cannot close with this angle of 'drive', position of block.*'rail'.*give other angles or values"
    with pytest.raises(AssemblyError, match=asked):
        system.assemble(**wanted)
    with pytest.raises(AssemblyError, match="misses the position of block asked for by -0.4 rad or m"):
        system.assemble(**wanted, pinned=[block])


def test_assembled_state_runs():
    system = four_bar()
    solution = simulate(system, 0.2, state=system.assemble(angles={"drive": 0.6}, rates={"drive": -2.0}))
    assert solution.certificate.passed, solution.certificate.failures
