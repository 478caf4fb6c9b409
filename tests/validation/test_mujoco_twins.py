"""The twin in MuJoCo: every part it expresses against mbsd3d, at the start and along the motion, at its order."""

import numpy as np
import pytest
from helpers.models import EXAMPLES, across, direction, middle, random_body, random_loops
from helpers.mujoco_pairs import GRAVITY, LEFT, SETTLED, Pair, bodies_of, instant, loaded, loop, tree

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    ConstantVelocity,
    Cylindrical,
    Distance,
    Fixed,
    Gear,
    GearMesh,
    Parallel,
    Perpendicular,
    Planar,
    PointOnLine,
    PointOnPlane,
    Polynomial,
    PositionDriver,
    Prismatic,
    RackPinion,
    Ramp,
    Revolute,
    Screw,
    Sine,
    SlideDriver,
    SpeedDriver,
    Spherical,
    SpringDamper,
    State,
    System,
    TorsionSpring,
    Universal,
    accelerations,
    simulate,
)
from validation.twins.base import EngineFailed
from validation.twins.mujoco import twin

mujoco = pytest.importorskip("mujoco")


EXACT = (
    Revolute, Spherical, Universal, Prismatic, Cylindrical, Planar, Fixed, PointOnLine, PointOnPlane, Parallel,
    Perpendicular, Distance,
)  # fmt: skip
COUPLED = (ConstantVelocity, Screw, Gear, RackPinion, GearMesh, AngleDriver, SlideDriver, PositionDriver)


@pytest.mark.parametrize("cls", EXACT)
def test_tree_joints(cls):
    pair = Pair(tree(cls))
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10  # rounding of sums of some tens of terms
    orders, fine = pair.orders(32)
    small = fine < 1e-11  # rounding of four hundred operations on numbers up to 50: bodies that fly at constant speed
    assert np.all(small | (np.abs(orders - 4.0) < 0.5))  # 32 steps are not yet the limit of small ones
    assert fine.max() < 1e-4


@pytest.mark.parametrize("cls", COUPLED)
def test_couplings_and_drivers_of_trees(cls):
    pair = Pair(tree(cls))
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10
    orders, fine = pair.orders(SETTLED)
    assert np.all(np.abs(orders - 2.0) < 0.2)
    assert fine[0] < 1e-7 and fine[2] < 1e-4  # at some 1 rad/s (w h)^2 is 4e-8


def test_a_planet_counts_from_its_carrier():
    """Sun and carrier turn on the ground about one axis, the planet in the carrier: angles are sums along the tree."""
    rng, (carrier, sun, planet, _) = bodies_of(6)
    axis = direction(rng)
    out = across(rng, axis)
    hinges = [
        Revolute(GROUND, carrier, at=(0, 0, 0), axis=axis),
        Revolute(GROUND, sun, at=0.2 * axis, axis=axis),
        Revolute(carrier, planet, at=0.7 * out, axis=-axis),
    ]
    mesh = GearMesh(hinges[1], hinges[2], at=0.3 * out, carrier=carrier)
    pair = Pair(System([carrier, sun, planet], [*hinges, mesh], gravity=GRAVITY))
    assert len(pair.twin.couplings[0].terms) == 3
    assert instant(pair)[1] < 1e-10
    orders, fine = pair.orders(SETTLED)
    assert np.all(np.abs(orders[:2] - 2.0) < 0.2) and fine[0] < LEFT
    assert set(pair.twin.run(0.4, 8, 4).reactions) == {pair.system.name(joint) for joint in pair.system.joints}
    assert fine[2] < 1e-5  # a couple instead of the tooth force has the bearings wrong by 3 N


@pytest.mark.parametrize("cls", [Spherical, Revolute, Universal, Cylindrical, Screw])
def test_loops_closed_by_equalities(cls):
    pair = Pair(loop(cls))
    assert pair.twin.made.layout.closing
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10  # of hard rows, the fourth-order difference of J v in them: 1e-11
    orders, fine = pair.orders(SETTLED)
    assert abs(orders[0] - 2.0) < 0.2 and orders.min() > 1.5
    assert fine[0] < LEFT


@pytest.mark.parametrize("cls", [Parallel, Perpendicular, Distance, PointOnLine, PositionDriver])
def test_loops_closed_by_a_piece_of_a_body(cls):
    pair = Pair(loop(cls))
    assert len(pair.twin.made.layout.extra) == 1 and not pair.twin.made.layout.closing
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10
    orders, fine = pair.orders(SETTLED)
    assert abs(orders[0] - 2.0) < 0.2 and orders.min() > 1.5 and fine[0] < LEFT


@pytest.mark.parametrize("cls", [Prismatic, Planar, PointOnPlane, ConstantVelocity, Fixed])
@pytest.mark.slow
def test_more_loops(cls):
    pair = Pair(loop(cls))
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10
    orders, _ = pair.orders(SETTLED)
    assert abs(orders[0] - 2.0) < 0.2 and orders[1] > 1.3  # of a Planar the part of the stages begins to show


def test_forces():
    pair = Pair(loaded())
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10
    orders, fine = pair.orders(64)
    assert np.all(np.abs(orders - 4.0) < 0.4) and fine[2] < 1e-6


def test_springs_push():
    rng, (first, *_) = bodies_of(3)
    springs = [
        SpringDamper(first, GROUND, at_a=first.position + 0.1, at_b=at, stiffness=20.0, length=length)
        for at, length in (((0.3, 1.0, 2.0), 4.0), ((-0.5, 1.0, 0.3), 0.0))
    ]
    pair = Pair(System([first], [], springs, gravity=GRAVITY))
    assert instant(pair)[1] < 1e-10
    assert pair.errors(128).max() < 1e-6


@pytest.mark.parametrize(
    "make",
    [
        lambda bodies, joints: SpeedDriver(
            GROUND, bodies[0], axis=-joints[0].axis, speed=Sine(1.0, 0.7, 0.2, 1.0) + Ramp(0.3, 0.1)
        ),
        lambda bodies, joints: AngleDriver(joints[0], Polynomial((0.0, 1.0, 0.3, -0.5))),
        lambda bodies, joints: SlideDriver(joints[1], Sine(0.2, 0.8) + Ramp(0.3)),
        lambda bodies, joints: AngleDriver(
            joints[0], Sine(0.2, -0.8, 0.3, -0.2 * np.sin(0.3)) + Sine(0.1, 0.0, 0.5, -0.1 * np.sin(0.5))
        ),
        lambda bodies, joints: Gear(joints[0], joints[1], ratio=-0.7),  # body b of the one is that of the other
        lambda bodies, joints: RackPinion(joints[0], joints[1], radius=0.2),
    ],
    ids=["speed", "angle", "slide", "backwards", "gear", "rack"],
)
def test_drivers_and_couplings_under_load(make):
    system = loaded(make)
    pair = Pair(system)
    assert instant(pair)[1] < 1e-10
    orders, fine = pair.orders(256)
    # 256 steps are not yet the limit
    assert np.all(np.abs(orders[:2] - 2.0) < 0.5) and fine[0] < 1e-3 and fine[2] < 0.1


def test_a_slider_moves_at_a_given_speed():
    """It slid freely: differences of 42 % in the accelerations of a right motion."""
    rng, (first, second, *_) = bodies_of(4)
    hinge = Revolute(GROUND, first, at=middle(rng, GROUND, first), axis=direction(rng))
    rail = Prismatic(first, second, at=middle(rng, first, second), axis=direction(rng))
    drive = SpeedDriver(rail, Sine(0.3, 0.7, 0.2, 0.4) + Ramp(0.3, 0.1))
    pair = Pair(System([first, second], [hinge, rail, drive], gravity=GRAVITY))
    assert instant(pair)[1] < 1e-10
    assert np.all(np.abs(pair.orders(128)[0][:2] - 2.0) < 0.5)


def test_a_speed_driver_begins_where_the_state_is_and_when():
    system = loaded(lambda bodies, joints: SpeedDriver(GROUND, bodies[0], axis=joints[0].axis, speed=Ramp(0.4, 1.0)))
    later = system.assemble(angles={"hinge": 0.7}, t=0.25)
    pair = Pair(system, later, t_end=0.5)
    assert instant(pair)[1] < 1e-10
    orders, _ = pair.orders(128)
    assert np.all(np.abs(orders[:2] - 2.0) < 0.5)  # nor are 128
    assert pair.twin.run(0.5, 4, 2).t == pytest.approx([0.25, 0.375, 0.5])


def test_parts_built_otherwise_and_assembled():
    rng, bodies = bodies_of(9)
    first, second, third, last = bodies

    def tilted(axis):
        return axis + 0.05 * across(rng, axis)

    u, w = direction(rng), direction(rng)
    at = [middle(rng, a, b) for a, b in ((GROUND, first), (first, second), (third, last))]
    joints = [
        Revolute(GROUND, first, at=at[0], at_b=at[0] + 0.1, axis=u, axis_b=tilted(u), name="hinge"),
        Prismatic(second, first, at=at[1], at_b=at[1] - 0.07, axis=w, axis_b=tilted(w), name="rail"),
        Distance(second, third, at_a=second.position, at_b=third.position, length=1.3),
        PointOnLine(last, third, at=at[2], at_b=at[2] + 0.05, axis=direction(rng)),
    ]
    springs = [TorsionSpring(joint, stiffness=3.0, angle=0.2) for joint in joints[:2]]
    system = System(bodies, joints, springs, gravity=GRAVITY)
    pair = Pair(system, system.assemble(rates={"hinge": 2.0}))
    assert instant(pair)[1] < 1e-10
    orders, fine = pair.orders(64)
    assert np.all(np.abs(orders - 4.0) < 0.4) and fine.max() < 1e-6


@pytest.mark.parametrize("cls", [Revolute, Spherical])
def test_a_loop_closed_by_parts_built_otherwise(cls):
    """Crosses span the tree before hinges and balls do."""
    rng, (first, second, third, _) = bodies_of(1)
    pairs = ((GROUND, first), (first, second), (second, third))
    crosses = [joint for a, b in pairs for joint in EXAMPLES[Universal](rng, a, b, None, None)]
    at, u = middle(rng, third, GROUND), direction(rng)
    axes = {"axis": u, "axis_b": u + 0.05 * across(rng, u)} if cls is Revolute else {}
    closing = cls(third, GROUND, at=at, at_b=at - 0.05 * direction(rng), **axes)
    system = System([first, second, third], [*crosses, closing], gravity=GRAVITY)
    pair = Pair(system, system.assemble())
    assert pair.twin.made.layout.closing == [closing]
    assert instant(pair)[1] < 1e-10
    orders, fine = pair.orders(SETTLED)
    assert abs(orders[0] - 2.0) < 0.2 and fine[0] < LEFT and fine[2] < 1e3 * LEFT  # of forces of some 100 N


@pytest.mark.parametrize("cls", [Fixed, Prismatic])
def test_a_speed_goes_through_what_does_not_turn(cls):
    rng, (first, second, third, _) = bodies_of(3)
    axis = direction(rng)
    joints = [
        Revolute(GROUND, first, at=middle(rng, GROUND, first), axis=axis),
        *EXAMPLES[cls](rng, second, first, None, None),
        Revolute(third, second, at=middle(rng, second, third), axis=-axis),
        SpeedDriver(GROUND, third, axis=axis, speed=Ramp(0.4, 1.0)),
    ]
    pair = Pair(System([first, second, third], joints, gravity=GRAVITY))
    assert instant(pair)[1] < 1e-10
    orders, fine = pair.orders(SETTLED)
    assert np.all(np.abs(orders[:2] - 2.0) < 0.2) and fine[0] < LEFT


def test_a_gear_between_hinges_one_behind_the_other():
    rng, (first, second, *_) = bodies_of(3)
    hinges = [
        Revolute(GROUND, first, at=middle(rng, GROUND, first), axis=direction(rng)),
        Revolute(first, second, at=middle(rng, first, second), axis=direction(rng)),
    ]
    system = System([first, second], [*hinges, Gear(hinges[1], hinges[0], ratio=-0.7)], gravity=GRAVITY)
    orders, fine = Pair(system).orders(SETTLED)
    assert np.all(np.abs(orders[:2] - 2.0) < 0.2) and fine[2] < 1e-5


def test_helical_gears_that_both_slide():
    rng, (first, second, *_) = bodies_of(3)
    axis, at = direction(rng), np.zeros(3)
    out = across(rng, axis)
    hinges = [Cylindrical(GROUND, first, at=at, axis=axis), Cylindrical(second, GROUND, at=at + 0.9 * out, axis=-axis)]
    mesh = GearMesh(*hinges, at=at + 0.35 * out, helix_angle=0.4)
    pair = Pair(System([first, second], [*hinges, mesh], gravity=GRAVITY))
    assert instant(pair)[1] < 1e-10
    orders, fine = pair.orders(SETTLED)
    assert np.all(np.abs(orders[:2] - 2.0) < 0.2) and fine[2] < 1e-5


def test_a_gear_on_two_hinges_loads_what_carries_the_pair():
    rng, (frame, first, second, _) = bodies_of(3)
    axis = direction(rng)
    out = across(rng, axis)
    hinges = [Revolute(frame, first, at=(0, 0, 0), axis=axis), Revolute(frame, second, at=0.9 * out, axis=axis)]
    joints = [
        Revolute(GROUND, frame, at=middle(rng, GROUND, frame), axis=direction(rng), name="frame"),
        Cylindrical(frame, first, at=0.3 * axis, axis=axis),
        *hinges,
        GearMesh(*hinges, at=0.35 * out, name="mesh"),
    ]
    pair = Pair(System([frame, first, second], joints, gravity=GRAVITY))
    assert len(pair.twin.made.layout.extra) == 1
    assert instant(pair)[1] < 1e-10
    found, ours = pair.twin.run(0.4, SETTLED, 4).reactions, pair.solution.reaction("frame")
    assert "mesh" not in found and ours.unique
    assert np.abs(found["frame"].force - ours.force)[1:].max() < 1e-4


def test_a_point_mass_has_the_least_inertia():
    point = Body("point", 1.3, (0, 0, 0), com=(0.3, 0.2, -0.1), position=(0.1, 0.2, 0.3))
    pair = Pair(System([point], [Revolute(GROUND, point, at=(0, 0, 0), axis=(0.3, 0.5, 1.0))], gravity=GRAVITY))
    assert "(point)" in pair.twin.settings
    assert instant(pair)[1] < 1e-10
    orders, _ = pair.orders(32)
    assert np.all(np.abs(orders - 4.0) < 0.5)


def test_turns_of_the_state_are_counted():
    rng, (first, *_) = bodies_of(2)
    hinge = Revolute(GROUND, first, at=middle(rng, GROUND, first), axis=direction(rng), name="hinge")
    system = System([first], [hinge], [TorsionSpring(hinge, stiffness=2.0)], gravity=GRAVITY)
    turned = simulate(system, 0.5, state=system.assemble(rates={"hinge": 25.0})).final
    assert turned.coordinates[0] > 2 * np.pi
    pair = Pair(system, turned, t_end=turned.t + 0.4)
    assert instant(pair)[1] < 1e-10


@pytest.mark.parametrize("counts", [True, False])
def test_turns_of_a_driver_are_counted(counts):
    rng, (first, *_) = bodies_of(2)
    hinge = Revolute(GROUND, first, at=middle(rng, GROUND, first), axis=direction(rng))
    system = System([first], [hinge, AngleDriver(hinge, Ramp(2.0, 20.0))], gravity=GRAVITY)
    state = system.assemble()
    pair = Pair(system, state if counts else State(state.t, state.q, state.v))
    assert pair.errors(512)[0] < 1e-5


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)])
def test_random_loops_with_redundant_joints(seed):
    pair = Pair(random_loops(seed, n=7 if seed == 1 else 14), t_end=0.1)
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-9  # forces that rows share are many times those they need
    orders, _ = pair.orders(128)
    assert np.all(orders[:2] > 1.5)


def test_the_stiffest_equalities_give_reactions_that_do_not_converge():
    """At solref (2 h, 1) the stages of RK4 see forces of order 1 in the rows: why the default is softer."""
    orders, fine = Pair(loop(Perpendicular), softness=2.0, dampratio=1.0).orders(SETTLED)
    assert abs(orders[0] - 2.0) < 0.2 and abs(orders[1] - 1.0) < 0.3 and abs(orders[2]) < 0.3
    assert fine[2] > 100 * Pair(loop(Perpendicular)).errors(2 * SETTLED)[2]


def test_rods_as_tendons():
    system = tree(Distance)
    pair = Pair(system, rods="tendons")
    assert pair.twin.model.neq == 1 and pair.twin.order == 2.0
    assert instant(pair)[1] < 1e-10
    orders, fine = pair.orders(512)
    assert orders[0] > 1.5 and fine[2] < 0.1  # the error of their missing J_dot v; the rod pulls with 20 N


def test_a_rod_of_another_length_as_a_tendon():
    rng, (first, *_) = bodies_of(3)
    rod = Distance(GROUND, first, at_a=(0, 0.3, 0.1), at_b=first.position + 0.3 * direction(rng), length=0.9)
    system = System([first], [rod], gravity=GRAVITY)
    pair = Pair(system, system.assemble(), rods="tendons")
    assert instant(pair)[1] < 1e-10
    assert pair.orders(512)[0][0] > 1.5


def test_a_rod_along_its_first_hinge_is_said():
    """A stone on a rod swings through the axis of the first hinge, perpendicular to the rod: 90 degrees."""
    stone = Body("stone", 1.0, (0.01, 0.02, 0.03), position=(0, 0, -1.0), omega=(0, 0, 0))
    rod = Distance(GROUND, stone, at_a=(0, 0, 0), at_b=(0, 0, -1.0), name="rod")
    system = System([stone], [rod], gravity=(0, 0, 0))
    for velocity in ((1.0, 0, 0), (0, 1.0, 0)):
        state = State(0.0, system.state().q, [*velocity, 0, 0, 0])
        if twin(system, state=state).qvel[1]:  # along the second hinge: towards the axis of the first
            break
    with pytest.raises(EngineFailed, match="t = 1.5.* rod 'rod' .* rods='tendons'"):
        twin(system, state=state).run(1.5708, 64, 8)


def test_a_loop_of_bodies_that_are_rigid_to_each_other_has_no_rows():
    """A ball and a hinge beside a weld hold what cannot move; MuJoCo has rows of rounding there, or none."""
    rng, (first, second, *_) = bodies_of(7)
    joints = [
        Revolute(GROUND, first, at=middle(rng, GROUND, first), axis=direction(rng)),
        Fixed(first, second, at=middle(rng, first, second)),
        Spherical(first, second, at=middle(rng, first, second)),
        Revolute(first, second, at=middle(rng, first, second), axis=direction(rng)),
    ]
    pair = Pair(System([first, second], joints, gravity=GRAVITY))
    assert pair.twin.model.neq == 3
    assert instant(pair)[1] < 1e-10
    assert pair.errors(128)[:2].max() < 1e-6


def test_a_reflected_inertia_is_an_armature():
    """Hinge and slide on a moving body, taken from either side; accelerations of a tree are exact in MuJoCo."""
    rng = np.random.default_rng(6)
    first, second, third = (random_body(rng, f"body {k}", position=[0.9 * k, 0.3 * k, 0.1]) for k in range(3))
    joints = [
        Revolute(GROUND, first, at=(0.1, 0, 0.2), axis=(1, 2, 2), reflected_inertia=0.7),
        Prismatic(second, first, at=second.position, axis=(0, 1, 2), reflected_mass=3.0),
        Revolute(second, third, at=third.position, axis=(2, 1, 0), reflected_inertia=0.4),
    ]
    system = System([first, second, third], joints, gravity=GRAVITY)
    state = system.assemble(rates=dict(zip(joints, (2.0, -1.0, 3.0), strict=True)))
    ours, theirs = accelerations(system, state), twin(system, state=state).accelerations()
    for k, body in enumerate(system.bodies):
        assert np.allclose(theirs[k, :3], ours.acceleration(body)[0], rtol=1e-10, atol=1e-10)
        assert np.allclose(theirs[k, 3:], ours.alpha(body)[0], rtol=1e-10, atol=1e-10)
