"""Exports: accelerations of MuJoCo on the file, and of the file read back; what a format cannot hold is named."""

import re

import mujoco
import numpy as np
import pytest
from helpers.exports import (
    PLAIN_JOINTS,
    body,
    carried,
    difference,
    direction,
    random_tree,
    read_back,
    read_back_by_coordinates,
    states_of,
)
from helpers.mujoco_states import TOLERANCE
from helpers.mujoco_states import difference as from_mujoco

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Brake,
    ConstantVelocity,
    Cylindrical,
    Distance,
    Exported,
    Fixed,
    Force,
    Gear,
    KnifeEdge,
    Limit,
    Planar,
    PointOnLine,
    Prismatic,
    RackPinion,
    Revolute,
    RollingDisc,
    Screw,
    Sine,
    Spherical,
    SpringDamper,
    State,
    System,
    TorsionSpring,
    Universal,
    accelerations,
    read_mjcf,
    read_sdf,
    read_urdf,
    rotation,
)
from mbsd3d.extend import multiply

pytestmark = pytest.mark.filterwarnings("ignore:.*(inactive|is fixed):UserWarning")


@pytest.mark.parametrize("seed", range(6))
def test_trees_in_mjcf_move_as_here(tmp_path, seed):
    system = random_tree(seed, springs=True)
    made = system.to_mjcf(tmp_path / "model.xml")
    assert isinstance(made, Exported) and made.path.read_text() == made.text and made.soft == ()
    for model, data, state in states_of(system, made.text):
        assert from_mujoco(system, state, model, data) < TOLERANCE
    read = read_mjcf(made.path).system
    assert len(read.joints) == len([x for x in system.joints if not isinstance(x, Fixed)])
    assert read_back(system, made, read) < TOLERANCE


def test_a_wrong_number_in_a_file_would_show(tmp_path):
    system = random_tree(0)
    made = system.to_mjcf()
    mass = f'mass="{system.bodies[2].mass!r}"'
    assert mass in made.text
    path = tmp_path / "model.xml"
    path.write_text(made.text.replace(mass, f'mass="{system.bodies[2].mass * (1 + 1e-9)!r}"'))
    assert read_back(system, made, read_mjcf(path).system, count=3) > TOLERANCE


def spatial_loop(closing=Spherical):
    """A crank and a rocker on oblique axes, and a rod on a cross and a ball between them."""
    rng = np.random.default_rng(5)
    crank, rod, rocker = (body(rng, name) for name in ("crank", "rod", "rocker"))
    joints = [
        Revolute(GROUND, crank, at=(0, 0.1, 0), axis=(1, 0.2, 0.1), name="drive"),
        Universal(crank, rod, at=(0.1, 0.2, 0.3), axis_a=(0, 0, 1), axis_b=(0, 1, 0), name="pin"),
        Revolute(GROUND, rocker, at=(0.1, 1.8, 0), axis=(0.8, -0.1, 0.3), name="swing"),
        closing(rod, rocker, at=(0.3, 1.1, 0.7), name="ball"),
    ]
    return System([crank, rod, rocker], joints)


def test_a_loop_in_mjcf_is_closed_by_a_soft_equality_and_read_back_rigid(tmp_path):
    system = spatial_loop()
    made = system.to_mjcf(tmp_path / "loop.xml")
    assert made.soft == ("ball",)
    model = mujoco.MjModel.from_xml_string(made.text)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert model.neq == 1 and np.abs(data.efc_pos).max() < 1e-15  # [m] the ends meet at the reference pose
    read = read_mjcf(made.path).system
    assert read.check().mobility == system.check().mobility == 1
    assert read_back_by_coordinates(system, made, read, ["drive"], reach=0.01) < TOLERANCE


def loop_of(kind, rng):
    """A loop that a joint of a kind closes, whose body MuJoCo holds in two halves."""
    lower, upper = body(rng, "lower"), body(rng, "upper")
    axis = direction(rng)
    across = np.cross(axis, direction(rng))
    closing = {
        "Cylindrical": lambda: Cylindrical(GROUND, upper, at=(0.3, 0.2, 0.9), axis=axis, name="closing"),
        "Prismatic": lambda: Prismatic(GROUND, upper, at=(0.3, 0.2, 0.9), axis=axis, name="closing"),
        "Universal": lambda: Universal(
            GROUND, upper, at=(0.3, 0.2, 0.9), axis_a=axis, axis_b=across / np.linalg.norm(across), name="closing"
        ),
    }[kind]()
    joints = [
        Spherical(GROUND, lower, at=(0, 0, 0), name="root"), Spherical(lower, upper, at=(0.5, 0.1, 0.4), name="knee")
    ]  # fmt: skip
    return System([lower, upper], [*joints, closing])


@pytest.mark.parametrize("kind", ["Cylindrical", "Universal", "Prismatic"])
def test_loops_of_any_joint_are_read_back(tmp_path, kind):
    system = loop_of(kind, np.random.default_rng(8))
    made = system.to_mjcf(tmp_path / "loop.xml")
    read = read_mjcf(made.path).system
    assert read.check().mobility == system.check().mobility
    rng, start = np.random.default_rng(1), system.state()
    for _ in range(3):
        moving = system.assemble(near=State(0.0, start.q, rng.normal(size=start.v.size)))
        there = carried(system, moving, read, made.frames)
        assert difference(system, moving, read, there, made.frames) < TOLERANCE


def shafts(coupling):
    """Three bodies on oblique axes, and what couples them."""
    rng = np.random.default_rng(3)
    bodies = [body(rng, name) for name in ("one", "two", "three")]
    at = rng.normal(size=(3, 3))
    a = Revolute(GROUND, bodies[0], at=at[0], axis=direction(rng), name="a")
    b = Revolute(bodies[1], bodies[0], at=at[1], axis=direction(rng), name="b")
    if coupling == "screw":
        c = Screw(bodies[0], bodies[2], at=at[2], axis=direction(rng), pitch=0.3, name="c")
        return System(bodies, [a, b, c]), ["a", "b", "c turn 0"]
    if coupling == "constant velocity":
        bent = ConstantVelocity(bodies[0], bodies[2], at=at[2], axis_a=(1, 0, 0.1), axis_b=(1, 0.6, 0), name="c")
        return System(bodies, [a, b, bent]), ["a", "b", "c turn 0", "c turn 1"]
    if coupling == "rod":
        rod = Distance(bodies[2], bodies[0], at_a=at[2], at_b=at[2] + (0.3, -0.2, 0.4), name="c")
        return System(bodies, [a, b, rod]), ["a", "b", "c swing 0", "c swing 1"]
    c = Prismatic(GROUND, bodies[2], at=at[2], axis=direction(rng), name="c")
    coupled = {
        "gear": lambda: Gear(a, b, ratio=-2.3, name="teeth"),
        "rack": lambda: RackPinion(b, c, radius=0.12, name="teeth"),
    }[coupling]()
    return System(bodies, [a, b, c, coupled]), ["a", "c"] if coupling == "gear" else ["a", "b"]


@pytest.mark.parametrize("coupling", ["screw", "constant velocity", "rod", "gear", "rack"])
def test_couplings_are_equalities_and_read_back(tmp_path, coupling):
    system, driven = shafts(coupling)
    made = system.to_mjcf(tmp_path / "coupled.xml")
    soft = {"gear": ("teeth",), "rack": ("teeth",), "rod": ()}.get(coupling, ("c",))
    assert made.soft == soft and ("lost" in str(made)) == (coupling == "rod")
    read = read_mjcf(made.path).system
    assert read.check().mobility == system.check().mobility
    assert read_back_by_coordinates(system, made, read, driven, count=5) < TOLERANCE


def test_what_an_import_chains_over_massless_bodies_is_one_body_again(tmp_path):
    text = """<mujoco><worldbody><body name="arm"><joint name="a" type="slide" axis="1 2 0"/>
      <joint name="b" axis="0 1 1" pos="0 .1 0" damping=".3"/><joint name="c" axis="1 0 .2" stiffness="2" pos=".1 0 0"/>
      <inertial mass="2" pos=".1 .2 .3" diaginertia=".1 .2 .25"/></body></worldbody></mujoco>"""
    (tmp_path / "first.xml").write_text(text)
    system = read_mjcf(tmp_path / "first.xml").system
    assert len(system.bodies) == 3
    made = system.to_mjcf(tmp_path / "second.xml")
    first, second = (mujoco.MjModel.from_xml_string(x) for x in (text, made.text))
    rng = np.random.default_rng(2)
    for _ in range(20):
        q, v, found = rng.normal(size=3), rng.normal(size=3), []
        for model in (first, second):
            data = mujoco.MjData(model)
            data.qpos[:], data.qvel[:] = q, v
            mujoco.mj_forward(model, data)
            found.append(data.qacc.copy())
        assert np.abs(found[0] - found[1]).max() < TOLERANCE * np.abs(found[0]).max()


def test_springs_between_points_pull_as_here():
    system = random_tree(4)
    ends = [(GROUND, system.bodies[3]), (system.bodies[1], system.bodies[4])]
    springs = [
        SpringDamper(a, b, at_a=(0.9, 0.8, -1), at_b=(-0.3, 0.4, 0.2), stiffness=7.0, damping=0.6, length=0.4)
        for a, b in ends
    ]
    system = System(system.bodies, system.joints, springs)
    for model, data, state in states_of(system, system.to_mjcf().text, 5):
        assert from_mujoco(system, state, model, data) < TOLERANCE


def test_several_springs_of_a_hinge_add_up():
    system = random_tree(1, PLAIN_JOINTS, springs=True)
    hinge = next(x for x in system.joints if isinstance(x, Revolute))
    more = [TorsionSpring(hinge, stiffness=2.0, damping=0.1, angle=a, name=f"at {a}") for a in (-0.7, 0.5)]
    system = System(system.bodies, system.joints, [*system.forces, *more])
    for model, data, state in states_of(system, system.to_mjcf().text, 5):
        assert from_mujoco(system, state, model, data) < TOLERANCE


def wheel(**more):
    """A wheel on a hinge, and what is on it."""
    disc = Body("disc", 2.0, (0.1, 0.2, 0.1), position=(0, 0, 0.5))
    hinge = Revolute(GROUND, disc, at=(0, 0, 0.5), axis=(0, 1, 0), name="hinge")
    parts = {
        "roll": lambda: RollingDisc(GROUND, disc, axis=(0, 1, 0), radius=0.5, name="roll"),
        "edge": lambda: KnifeEdge(GROUND, disc, at=(0, 0, 0), lateral=(0, 1, 0), name="edge"),
    }
    joints = [hinge] if "on" not in more else [parts[more["on"]]()]
    forces = {
        "push": lambda: Force(disc, (Sine(1.0, 2.0), 0, 0), name="push"),
        "brake": lambda: Brake(hinge, torque=2.0, stiffness=1e3, damping=1.0, name="brake"),
        "spring": lambda: TorsionSpring(hinge, stiffness=2.0, name="spring"),
    }
    return System([disc], joints, [forces[more["force"]]()] if "force" in more else [])


@pytest.mark.parametrize(
    ("write", "more", "message"),
    [
        ("to_mjcf", {"on": "roll"}, r"MJCF cannot hold joint 'roll' \(RollingDisc\).*leave_out=\[\"roll\"\]"),
        ("to_mjcf", {"on": "edge"}, r"joint 'edge' \(KnifeEdge\): the format has no such element"),
        ("to_mjcf", {"force": "push"}, r"force 'push' \(Force\)"),
        ("to_mjcf", {"force": "brake"}, r"force 'brake' \(Brake\)"),
        ("to_sdf", {"on": "roll"}, r"SDF cannot hold joint 'roll'"),
        ("to_sdf", {"force": "brake"}, r"the format has springs and dampers of joints only"),
        ("to_urdf", {"on": "roll"}, r"URDF cannot hold joint 'roll' \(RollingDisc\).*leave_out=\[\"roll\"\]"),
        ("to_urdf", {"force": "spring"}, r"force 'spring' \(TorsionSpring\): the format has dampers of joints only"),
    ],
)
def test_what_a_format_cannot_hold_is_named_and_left_out_on_request(write, more, message):
    system = wheel(**more)
    with pytest.raises(ValueError, match=message):
        getattr(system, write)()
    name = next(iter(more.values()))
    assert getattr(system, write)(leave_out=[name]).inactive == (name,)
    with pytest.raises(ValueError, match="'nothing' is not a joint or force of the system; there are '"):
        getattr(system, write)(leave_out=["nothing"])


def test_what_acts_through_a_part_must_go_with_it():
    system, _ = shafts("gear")
    with pytest.raises(ValueError, match="joint 'teeth' .Gear. acts through 'b', which is left out"):
        system.to_mjcf(leave_out=["b"])
    assert system.to_mjcf(leave_out=["b", system.joints[3]]).inactive == ("b", "teeth")


def test_a_driver_is_written_where_it_holds(tmp_path):
    system, _ = shafts("gear")
    held = AngleDriver(system.joints[0], 0.0, name="held")
    system = System(system.bodies, [*system.joints, held])
    made = system.to_mjcf(tmp_path / "held.xml")
    read = read_mjcf(made.path).system
    assert made.soft == ("teeth", "held") and isinstance(read.part("held", "joints"), AngleDriver)
    assert read.check().mobility == system.check().mobility == 1
    moving = System(system.bodies, [*system.joints[:-1], AngleDriver(system.joints[0], Sine(1.0, 2.0), name="motor")])
    with pytest.raises(ValueError, match="joint 'motor' .AngleDriver.: it moves by a signal"):
        moving.to_mjcf()


def test_a_body_without_mass_at_an_end_is_refused():
    tip = Body("tip", 0.0, (0, 0, 0))
    with pytest.raises(ValueError, match="body 'tip': mass 0 kg; MuJoCo needs a positive one"):
        System([tip], [Revolute(GROUND, tip, at=(0, 0, 0), axis=(1, 0, 0))]).to_mjcf()


@pytest.mark.parametrize(("write", "suffix"), [("to_mjcf", ".xml"), ("to_urdf", ".urdf"), ("to_sdf", ".sdf")])
def test_files_are_written_once_and_under_their_name(tmp_path, write, suffix):
    system = wheel()
    made = getattr(system, write)(tmp_path / f"model{suffix}")
    with pytest.raises(ValueError, match="exists; give replace=True"):
        getattr(system, write)(made.path)
    assert getattr(system, write)(made.path, replace=True).text == made.text
    with pytest.raises(ValueError, match=f"does not end in {re.escape(suffix)}"):
        getattr(system, write)(tmp_path / "model.txt")


def test_limits_are_not_enforced_by_mujoco():
    hinge = wheel().joints[0]
    system = System([hinge.b], [hinge], limits=[Limit(hinge, "angle", -0.1, 0.2)])
    made = system.to_mjcf()
    assert made.inactive == ("limit of 'hinge'",) and "range" not in made.text


@pytest.mark.parametrize("seed", range(6))
def test_trees_in_urdf_are_read_back(tmp_path, seed):
    system = random_tree(seed, PLAIN_JOINTS)
    made = system.to_urdf(tmp_path / "model.urdf")
    floats = seed % 2 == 1
    assert any("floats" in line for line in made.said) == floats and any("gravity" in line for line in made.said)
    read = read_urdf(made.path, floating=True if floats else None).system
    assert read_back(system, made, read) < TOLERANCE


@pytest.mark.parametrize("kind", ["Universal", "Cylindrical", "Spherical"])
def test_joints_of_several_coordinates_take_massless_links(tmp_path, kind):
    rng = np.random.default_rng(12)
    one, two = body(rng, "one"), body(rng, "two")
    axis = direction(rng)
    cls = {"Universal": Universal, "Cylindrical": Cylindrical, "Spherical": Spherical}[kind]
    axes = {"Universal": {"axis_a": axis, "axis_b": np.cross(axis, direction(rng))}, "Cylindrical": {"axis": axis}}
    middle = cls(two, one, at=(0.2, 0.4, -0.3), name="middle", **axes.get(kind, {}))
    system = System([one, two], [Revolute(GROUND, one, at=(0.1, 0, 0), axis=axis + 1, name="base"), middle])
    with pytest.raises(ValueError, match="joint 'middle'.*massless=True"):
        system.to_urdf()
    made = system.to_urdf(tmp_path / "model.urdf", massless=True)
    read = read_urdf(made.path).system
    assert read.check().mobility == system.check().mobility
    driven = [read.name(x) for x in read.joints]
    assert len(driven) == 1 + {"Spherical": 3}.get(kind, 2)
    assert read_back_by_coordinates(system, made, read, driven, count=5) < TOLERANCE


def test_a_loop_is_refused_in_urdf_by_the_joint_that_closes_it():
    with pytest.raises(ValueError, match="joint 'ball' .Spherical. closes a loop, and URDF knows trees only"):
        spatial_loop().to_urdf()


@pytest.mark.parametrize("pitch", [np.pi / 2, np.pi / 2 - 1e-9, -np.pi / 2 + 1e-12, 1.2, -0.3])
def test_a_link_at_a_right_angle_keeps_its_place(tmp_path, pitch):
    """By asin the pose would be off by 1e-8 there."""
    turn = rotation("z", 0.7)
    for axis, angle in (("y", pitch), ("x", -0.4)):
        turn = multiply(turn, rotation(axis, angle))
    bob = Body("bob", 1.0, (0.1, 0.2, 0.25), com=(0.1, 0.2, 0.3), position=(1, 2, 3), orientation=turn)
    system = System([bob], [Revolute(GROUND, bob, at=(0, 0.5, 0), axis=(1, 2, 3), name="hinge")])
    made = system.to_urdf(tmp_path / "bob.urdf")
    read = read_urdf(made.path).system.bodies[0]
    assert np.abs(read.axes - bob.axes).max() < 2e-15  # rounding of three factors
    assert np.abs(read.centre - bob.centre).max() < 4e-15  # [m] of some 4 m


def test_limits_and_dampers_of_urdf(tmp_path):
    tree = random_tree(0, ("Revolute", "Prismatic"), springs=False)
    limits = [Limit(x, "angle" if isinstance(x, Revolute) else "slide", -0.3, 0.4) for x in tree.joints[:3]]
    system = System(tree.bodies, tree.joints, tree.forces, limits=limits)
    found = read_urdf(system.to_urdf(tmp_path / "model.urdf").path)
    ranges = {limit.called: (limit.lower, limit.upper) for limit in found.system.limits}
    assert {ranges[x.name] for x in tree.joints[:3]} == {(-0.3, 0.4)}
    assert sorted(force.damping for force in found.system.forces) == [0.4] * 5


SDF_JOINTS = ("Revolute", "Prismatic", "Universal", "Spherical", "Fixed", "Screw")


@pytest.mark.parametrize("seed", range(6))
def test_trees_in_sdf_are_read_back(tmp_path, seed):
    system = random_tree(seed, SDF_JOINTS[:-1], springs=True)
    made = system.to_sdf(tmp_path / "model.sdf")
    found = read_sdf(made.path)
    floats = ("b0 floats; floating=False fixes, floating=True says so",) if seed % 2 else ()
    assert found.said == floats and found.inactive == ""
    assert sorted(type(x).__name__ for x in found.system.joints) == sorted(
        type(x).__name__ for x in system.joints if not isinstance(x, Fixed)
    )
    assert read_back(system, made, found.system) < TOLERANCE


def test_loops_in_sdf_are_native(tmp_path):
    system = spatial_loop()
    made = system.to_sdf(tmp_path / "loop.sdf")
    read = read_sdf(made.path).system
    assert made.soft == () and read.check().mobility == 1
    assert read_back_by_coordinates(system, made, read, ["drive"], reach=0.01) < TOLERANCE


@pytest.mark.parametrize("coupling", ["screw", "gear", "rack"])
def test_couplings_in_sdf_are_read_back(tmp_path, coupling):
    system, driven = shafts(coupling)
    made = system.to_sdf(tmp_path / "coupled.sdf")
    assert {"screw": "screw_thread_pitch", "gear": "mimic", "rack": "mimic"}[coupling] in made.text
    read = read_sdf(made.path).system
    assert {type(x) for x in read.joints} == {type(x) for x in system.joints}
    driven = [name.removesuffix(" turn 0") for name in driven]
    assert read_back_by_coordinates(system, made, read, driven, count=5) < TOLERANCE


@pytest.mark.parametrize("turned", [False, True])
def test_a_gear_on_one_body_is_a_gearbox(tmp_path, turned):
    rng = np.random.default_rng(6)
    carrier, one, two = (body(rng, name) for name in ("carrier", "one", "two"))
    ends = (two, carrier) if turned else (carrier, two)
    a = Revolute(carrier, one, at=rng.normal(size=3), axis=direction(rng), name="a")
    b = Revolute(*ends, at=rng.normal(size=3), axis=direction(rng), name="b")
    system = System([carrier, one, two], [a, b, Gear(a, b, ratio=1.7, name="teeth")])
    made = system.to_sdf(tmp_path / "gear.sdf")
    read = read_sdf(made.path).system
    assert 'type="gearbox"' in made.text and read.check().mobility == 7
    assert read_back_by_coordinates(system, made, read, ["a"], count=5) < TOLERANCE


@pytest.mark.parametrize("turned", [False, True])
def test_two_hinges_over_a_body_without_mass_are_one_joint_in_sdf(tmp_path, turned):
    rng = np.random.default_rng(7)
    one, cross = body(rng, "one"), Body("cross", 0.0, (0, 0, 0))
    at = rng.normal(size=3)
    pairs = [(GROUND, cross), (cross, one)]
    ends = [pair[::-1] for pair in pairs[::-1]] if turned else pairs
    hinges = [Revolute(*pair, at=at, axis=direction(rng), name=name) for pair, name in zip(ends, "ab", strict=True)]
    springs = [TorsionSpring(hinges[1], stiffness=2.0, damping=0.3, angle=0.2)]
    system = System([one, cross], hinges, springs, limits=[Limit(hinges[0], "angle", -1.0)])
    made = system.to_sdf(tmp_path / "cross.sdf")
    assert 'type="revolute2"' in made.text and list(made.frames) == ["one"]
    read = read_sdf(made.path).system
    limit = read.limits[0]
    assert (limit.lower, limit.upper) == (-1.0, None)
    names = [limit.joint.name, next(x.name for x in read.joints if x is not limit.joint)]  # of a and b there
    for angles, rates in rng.normal(size=(3, 2, 2)):
        state, there = (
            some.assemble(angles=dict(zip(these, angles, strict=True)), rates=dict(zip(these, rates, strict=True)))
            for some, these in ((system, "ab"), (read, names))
        )
        first, second = accelerations(system, state), accelerations(read, there)
        assert np.abs(first.alpha("one") - second.alpha("one")).max() < TOLERANCE * np.abs(first.alpha("one")).max()
    with pytest.raises(ValueError, match="body 'cross': its mass is 0, and SDF needs a positive one but between two"):
        System([one, cross], [hinges[0]]).to_sdf()


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("kind", [Cylindrical, Planar])
def test_slides_and_a_hinge_over_massless_links_are_exact_in_sdf(tmp_path, kind, turned):
    rng = np.random.default_rng(13)
    one, two, axis = body(rng, "one"), body(rng, "two"), direction(rng)
    ends = [(GROUND, one), (one, two)]
    along = {"axis" if kind is Cylindrical else "normal": axis}
    joints = [
        kind(*(pair[::-1] if turned else pair), at=rng.normal(size=3), **along, name=name)
        for pair, name in zip(ends, ("outer", "inner"), strict=True)
    ]
    system = System([one, two], joints, limits=[Limit(joints[0], "angle", -1.0)])
    made = system.to_sdf(tmp_path / "model.sdf", massless=True)
    assert made.inactive == ("limit of 'outer'",) and list(made.frames) == ["one", "two"]
    read = read_sdf(made.path).system
    assert read.check().mobility == system.check().mobility == (4 if kind is Cylindrical else 6)
    driven = [read.name(x) for x in read.joints]
    assert read_back_by_coordinates(system, made, read, driven, count=5) < TOLERANCE


def test_a_body_without_mass_is_a_link_of_sdf_on_request(tmp_path):
    rng = np.random.default_rng(14)
    bare, one = Body("bare", 0.0, (0, 0, 0), position=(0, 0, 1)), body(rng, "one")
    slide = Prismatic(GROUND, bare, at=(0, 0, 0), axis=direction(rng), name="slide")
    system = System([bare, one], [slide, Revolute(bare, one, at=rng.normal(size=3), axis=direction(rng), name="hinge")])
    with pytest.raises(ValueError, match="body 'bare': its mass is 0.*or massless=True"):
        system.to_sdf()
    made = system.to_sdf(tmp_path / "model.sdf", massless=True)
    read = read_sdf(made.path).system
    assert read_back_by_coordinates(system, made, read, ["slide", "hinge"], count=5) < TOLERANCE


@pytest.mark.parametrize(
    ("part", "message"),
    [
        (lambda b: PointOnLine(GROUND, b, at=(0, 0, 0), axis=(1, 0, 0), name="x"), "the format has no such joint"),
        (
            lambda b: Cylindrical(GROUND, b, at=(0, 0, 0), axis=(1, 0, 0), name="x"),
            "it takes links without mass, which Gazebo refuses; give massless=True",
        ),
        (
            lambda b: Revolute(GROUND, b, at=(0, 0, 0), axis=(1, 0, 0), reflected_inertia=0.1, name="x"),
            "its reflected inertia has no place in the format; set it to 0",
        ),
        (
            lambda b: Spherical(GROUND, b, at=(0, 0, 0), at_b=(0, 0, 1e-3), name="x"),
            "its parts do not meet at the reference pose",
        ),
    ],
)
def test_what_sdf_cannot_hold_is_named(part, message):
    bob = Body("bob", 1.0, (0.1, 0.1, 0.1))
    with pytest.raises(ValueError, match=f"SDF cannot hold joint 'x' .*: {message}"):
        System([bob], [part(bob)]).to_sdf()


def test_reflected_inertias_are_written_or_refused():
    """Armature in the tree of MJCF, of a ball the same about all axes; nowhere in URDF and SDF."""
    bob, rod = (Body(name, 1.0, (0.1, 0.1, 0.1), position=(k, 0, 0)) for k, name in enumerate(("bob", "rod")))
    ball = Spherical(GROUND, bob, at=(0, 0, 0), reflected_inertia=0.3, name="ball")
    assert 'armature="0.3"' in System([bob], [ball]).to_mjcf().text
    hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0), reflected_inertia=0.3, name="hinge")
    for write in ("to_urdf", "to_sdf"):
        with pytest.raises(
            ValueError, match="cannot hold joint 'hinge' .*: its reflected inertia has no place in the format"
        ):
            getattr(System([bob], [hinge]), write)()
    more = [
        Revolute(bob, rod, at=(0.5, 0, 0.2), axis=(0, 1, 0), reflected_inertia=0.1, name="elbow"),
        Revolute(rod, GROUND, at=(1.2, 0, 0), axis=(0, 1, 0), reflected_inertia=0.2, name="foot"),
    ]
    with pytest.raises(ValueError, match="closes a loop, and MuJoCo has armature in the tree only"):
        System([bob, rod], [hinge, *more]).to_mjcf()


def test_names_that_sdf_reserves_are_changed_and_mapped_back(tmp_path):
    bodies = [Body(name, 1.0, (0.1, 0.1, 0.1)) for name in ("world", "arm::hand", "arm_hand")]
    made = System(bodies, [Revolute(*bodies[:2], at=(0, 0, 0), axis=(0, 0, 1), name="arm::wrist")]).to_sdf(
        tmp_path / "model.sdf"
    )
    assert {name: frame.body for name, frame in made.frames.items()} == {
        "world_": "world", "arm_hand": "arm::hand", "arm_hand_": "arm_hand"
    }  # fmt: skip
    read = read_sdf(made.path).system
    assert read.check().mobility == 13 and read.joints[0].name == "arm_wrist"


def test_several_free_bodies_float_in_urdf(tmp_path):
    bodies = [body(np.random.default_rng(k), f"b{k}") for k in range(3)]
    system = System(bodies, [Revolute(GROUND, bodies[2], at=(0, 0, 0), axis=(1, 2, 0), name="hinge")])
    made = system.to_urdf(tmp_path / "model.urdf")
    assert "floating joints: b0 free, b1 free" in made.said
    read = read_urdf(made.path).system
    assert read.check().mobility == 13 and read_back(system, made, read, count=3) < TOLERANCE


def test_another_gravity_is_said():
    system = wheel()
    moon = System(system.bodies, system.joints, gravity=(0, 0, -1.62))
    assert any("-1.62" in line for line in moon.to_urdf().said)


@pytest.mark.parametrize("seed", [0, 2, 4])
def test_trees_in_urdf_move_so_in_pinocchio(seed):
    pinocchio = pytest.importorskip("pinocchio")
    system = random_tree(seed, ("Revolute", "Prismatic"))
    model = pinocchio.buildModelFromXML(system.to_urdf().text)
    data, rng = model.createData(), np.random.default_rng(seed)
    places = {x: model.joints[model.getJointId(x.name)].idx_v for x in system.joints}
    for _ in range(20):
        moved, rate = rng.normal(size=(2, model.nv))
        q = pinocchio.integrate(model, pinocchio.neutral(model), moved)
        rates_of_change = pinocchio.aba(model, data, q, rate, -0.4 * rate)  # dampers of joints are not applied there
        pinocchio.forwardKinematics(model, data, q, rate, rates_of_change)
        pinocchio.updateFramePlacements(model, data)
        angles, slides = (
            {x: moved[k] for x, k in places.items() if isinstance(x, kind)} for kind in (Revolute, Prismatic)
        )
        rates = {x: rate[k] for x, k in places.items()}
        found = accelerations(system, system.assemble(angles=angles, slides=slides, rates=rates))
        theirs = [
            pinocchio.getFrameAcceleration(model, data, model.getFrameId(x.name), pinocchio.LOCAL_WORLD_ALIGNED).angular
            for x in system.bodies
        ]
        ours = np.array([found.alpha(x)[0] for x in system.bodies])
        assert np.abs(ours - theirs).max() < TOLERANCE * np.abs(ours).max()
