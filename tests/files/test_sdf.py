"""The reader of SDF: accelerations of MuJoCo, loops and couplings of systems written by hand, files as they are."""

import mujoco
import numpy as np
import pytest
from helpers.exports import carried
from helpers.exports import difference as off
from helpers.mujoco_states import TOLERANCE, difference, general_motion, state_of
from scipy.spatial.transform import Rotation

from mbsd3d import (
    GROUND,
    Body,
    Gear,
    Revolute,
    Screw,
    Spherical,
    System,
    Universal,
    accelerations,
    read_sdf,
    simulate,
)

pytestmark = pytest.mark.filterwarnings("ignore:.*inactive:UserWarning")


def text_of(*values):
    """Numbers as a file has them, to the last bit."""
    return " ".join(repr(float(x)) for value in values for x in np.ravel(value))


I = {"ixx": 0.31, "iyy": 0.35, "izz": 0.22, "ixy": 0.02, "ixz": -0.03, "iyz": 0.04}
INERTIA = "".join(f"<{key}>{value}</{key}>" for key, value in I.items())


def inertial(mass, xyz=(0.11, -0.07, 0.2), rpy=(0.3, -0.4, 0.8)):
    """An <inertial> of SDF."""
    return f"<inertial><pose>{text_of(xyz, rpy)}</pose><mass>{mass}</mass><inertia>{INERTIA}</inertia></inertial>"


def mjcf_inertial(mass, xyz=(0.11, -0.07, 0.2), rpy=(0.3, -0.4, 0.8)):
    """The same in MJCF: inertia in the axes of the link."""
    R = Rotation.from_euler("xyz", rpy).as_matrix()
    A = np.array(
        [[I["ixx"], I["ixy"], I["ixz"]], [I["ixy"], I["iyy"], I["iyz"]], [I["ixz"], I["iyz"], I["izz"]]]
    )  # fmt: skip
    J = R @ A @ R.T
    full = text_of(J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2])
    return f'<inertial pos="{text_of(xyz)}" mass="{mass}" fullinertia="{full}"/>'


def link(name, mass=None, pose="", more=""):
    """A link."""
    return f'<link name="{name}">{pose}{"" if mass is None else inertial(mass)}{more}</link>'


def joint(name, kind, parent, child, more=""):
    """A joint."""
    return f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{more}</joint>'


def axis(xyz, more="", tag="axis", frame=""):
    """An axis."""
    where = f' expressed_in="{frame}"' if frame else ""
    return f"<{tag}><xyz{where}>{text_of(xyz)}</xyz>{more}</{tag}>"


def written(folder, body, name="model.sdf", version="1.9", model=True):
    """A file of one model, or of what stands in <sdf>."""
    path = folder / name
    inner = f'<model name="m">{body}</model>' if model else body
    path.write_text(f'<sdf version="{version}">{inner}</sdf>')
    return path


def places(count, seed=4):
    """Positions and roll, pitch, yaw in no special direction."""
    rng = np.random.default_rng(seed)
    return rng.normal(size=(count, 3)), rng.uniform(-3, 3, (count, 3))


def turn_of(rpy):
    """Roll, pitch, yaw as a quaternion, not by the code under test."""
    return Rotation.from_euler("xyz", rpy).as_quat(scalar_first=True)


def branched(floating):
    """A tree with springs whose poses go through frames in each other, as SDF and as MJCF."""
    r, rpy = places(5)
    a = np.random.default_rng(9).normal(size=(4, 3))
    a /= np.linalg.norm(a, axis=1)[:, None]
    quat = turn_of(rpy[1])[[1, 2, 3, 0]]
    springs = "<dynamics><damping>0.6</damping><spring_stiffness>3</spring_stiffness>"
    springs += "<spring_reference>0.4</spring_reference></dynamics>"
    sdf = (
        link("base", 3.1, f"<pose>{text_of(r[0], rpy[0])}</pose>")
        + link("upper", 1.4, f'<pose relative_to="base" rotation_format="quat_xyzw">{text_of(r[1], quat)}</pose>')
        + f'<frame name="flange" attached_to="upper"><pose degrees="True">{text_of(r[2], np.rad2deg(rpy[2]))}</pose>'
        + "</frame>"
        + link("tool", 0.6, '<pose relative_to="flange"/>')
        + link("ram", 0.8, f'<pose relative_to="shoulder">{text_of(r[3], rpy[3])}</pose>')
        + joint("shoulder", "revolute", "base", "upper", f"<pose>{text_of(r[4], rpy[4])}</pose>{axis(a[0], springs)}")
        + joint("wrist", "ball", "flange", "tool")
        + joint("slide", "prismatic", "ram", "upper", axis(a[2], frame="__model__"))
        + ("" if floating else joint("ground", "fixed", "world", "base"))
    )
    J = Rotation.from_euler("xyz", rpy[4])  # axes of the joint in the link that it moves
    upper = Rotation.from_euler("xyz", rpy[0]) * Rotation.from_euler("xyz", rpy[1])
    ram = J * Rotation.from_euler("xyz", rpy[3])  # in the link "upper", as its pose is in the frame of the joint
    at = r[4] + J.apply(r[3])
    sense = -(upper * ram).inv().apply(a[2])  # the child of the file carries its parent here
    mjcf = f"""<mujoco><compiler angle="radian"/><worldbody>
    <body name="base" pos="{text_of(r[0])}" quat="{text_of(turn_of(rpy[0]))}">{"<freejoint/>" if floating else ""}
      {mjcf_inertial(3.1)}
      <body name="upper" pos="{text_of(r[1])}" quat="{text_of(turn_of(rpy[1]))}">
        <joint pos="{text_of(r[4])}" axis="{text_of(J.apply(a[0]))}" stiffness="3" springref="0.4" damping="0.6"/>
        {mjcf_inertial(1.4)}
        <body name="tool" pos="{text_of(r[2])}" quat="{text_of(turn_of(rpy[2]))}"><joint type="ball"/>
          {mjcf_inertial(0.6)}</body>
        <body name="ram" pos="{text_of(at)}" quat="{text_of(ram.as_quat(scalar_first=True))}">
          <joint type="slide" axis="{text_of(sense)}"/>{mjcf_inertial(0.8)}</body>
      </body></body></worldbody></mujoco>"""
    return sdf, mjcf


@pytest.mark.parametrize("floating", [True, False])
def test_trees_have_the_accelerations_of_mujoco(tmp_path, floating):
    sdf, mjcf = branched(floating)
    found, model = read_sdf(written(tmp_path, sdf)), mujoco.MjModel.from_xml_string(mjcf)
    assert found.system.check().mobility == model.nv == (11 if floating else 5)
    assert found.said[0] == "gravity is 9.81 m/s^2 along -z, as the file has no world"
    assert found.said[1:] == (("base floats; floating=False fixes, floating=True says so",) if floating else ())
    assert found.points["flange"].body == "upper"
    for seed in range(5):
        data = general_motion(model, seed, angle=0.8)
        assert difference(found.system, state_of(found.system, model, data), model, data) < TOLERANCE


def test_models_in_models_are_placed_by_their_frames(tmp_path):
    (r, s, t), (a, b, c) = places(3)
    inner = f"""<model name="arm" placement_frame="grip" canonical_link="hand">
      <pose relative_to="stand">{text_of(s, b)}</pose>
      <frame name="grip" attached_to="hand"><pose>{text_of(t, c)}</pose></frame>
      {link("hand", 2.0, "<pose>0.1 0.2 0.3 0.4 0.5 0.6</pose>")}</model>"""
    body = link("stand", 1.0, f"<pose>{text_of(r, a)}</pose>") + inner + joint("j", "ball", "stand", "arm::grip")
    system = read_sdf(written(tmp_path, body)).system
    hand = next(x for x in system.bodies if x.name == "arm::hand")
    stand, grip = Rotation.from_euler("xyz", a), Rotation.from_euler("xyz", c)
    R = stand * Rotation.from_euler("xyz", b) * grip.inv()  # the grip is put where the pose says
    assert np.abs(hand.axes - R.as_matrix()).max() < 1e-14
    assert np.abs(hand.position - (r + stand.apply(s) - R.apply(t))).max() < 1e-13
    assert np.abs(system.joints[0].at - (r + stand.apply(s))).max() < 1e-14  # it stands in the grip, its child


def test_a_joint_stands_in_the_frame_of_its_child(tmp_path):
    """A frame that is attached to a link keeps its own place."""
    frame = '<frame name="tip" attached_to="b"><pose>0 0 2 0 0 0</pose></frame>'
    body = link("a", 1.0) + link("b", 1.0) + frame + joint("j", "ball", "a", "tip", "<pose>0 3 0 0 0 0</pose>")
    assert read_sdf(written(tmp_path, body)).system.joints[0].at.tolist() == [0.0, 3.0, 2.0]


def four_bar(closing):
    """Links with centres of mass off their origins on oblique places; the last joint closes the loop."""
    at = np.array([[0, 0.1, 0.2], [0.3, -0.2, 0.8], [1.1, 0.3, 1.0], [1.3, 0.2, 0.1]])
    n = np.array([0.2, 1.0, -0.1]) / np.linalg.norm([0.2, 1.0, -0.1])
    sdf = "".join(
        link(name, m, f"<pose>{text_of(x)} 0 0 0</pose>") for name, m, x in zip("abc", (1, 2, 1.5), at, strict=False)
    )
    sdf += joint("j0", "revolute", "world", "a", axis(n)) + joint(
        "j1", "universal", "a", "b", axis(n) + axis((1, -0.2, 0), tag="axis2")
    )
    sdf += joint("j2", "ball", "b", "c") + closing(at[3], n)
    R = Rotation.from_euler("xyz", (0.3, -0.4, 0.8)).as_matrix()
    A = np.array([[0.31, 0.02, -0.03], [0.02, 0.35, 0.04], [-0.03, 0.04, 0.22]])
    bodies = [
        Body(name, m, R @ A @ R.T, com=(0.11, -0.07, 0.2), position=x)
        for name, m, x in zip("abc", (1, 2, 1.5), at, strict=False)
    ]
    a, b, c = bodies
    joints = [
        Revolute(GROUND, a, at=at[0], axis=n, name="j0"),
        Universal(a, b, at=at[1], axis_a=n, axis_b=(1, -0.2, 0), name="j1"),
        Spherical(b, c, at=at[2], name="j2"), Revolute(GROUND, c, at=at[3], axis=n, name="j3"),
    ]  # fmt: skip
    return sdf, System(bodies, joints)


@pytest.mark.parametrize("turned", [False, True])
def test_loops_are_closed(tmp_path, turned):
    def closing(at, n):
        where = f'<pose relative_to="__model__">{text_of(at)} 0 0 0</pose>'
        ends = ("world", "c") if not turned else ("c", "world")
        return joint("j3", "revolute", *ends, where + axis(n, frame="a"))

    sdf, system = four_bar(closing)
    read = read_sdf(written(tmp_path, sdf)).system
    assert read.check().mobility == system.check().mobility == 1
    same = system.to_mjcf().frames  # those of the bodies themselves
    for angle in (-0.2, 0.0, 0.3):
        state = system.assemble(angles={"j0": angle}, rates={"j0": 2.0})
        assert off(system, state, read, carried(system, state, read, same), same) < TOLERANCE
    turn = read.assemble(angles={"j0": 0.3})
    sense = -1.0 if turned else 1.0  # of the child about the axis, as the file says
    known = accelerations(read, turn).angle("j3")[0]
    assert known == pytest.approx(sense * accelerations(system, system.assemble(angles={"j0": 0.3})).angle("j3")[0])


def test_two_axes_are_a_universal_only_if_they_are_square_and_free(tmp_path):
    def kinds(second, more="", kind="universal"):
        body = link("a", 1.0) + link("b", 1.0, "<pose>0 0 1 0 0 0</pose>")
        body += joint("j", kind, "a", "b", axis((1, 0, 0.2)) + axis(second, more, tag="axis2"))
        return [type(x) for x in read_sdf(written(tmp_path, body)).system.joints]

    assert kinds((0, 1, 0)) == kinds((0, 1, 0), kind="revolute2") == [Universal]
    assert kinds((0.5, 1, 0), kind="revolute2") == [Revolute, Revolute]
    assert kinds((0, 1, 0), "<dynamics><damping>1</damping></dynamics>") == [Revolute, Revolute]


@pytest.mark.parametrize(("first", "second"), [(False, False), (True, False), (True, True)])
def test_a_gearbox_turns_its_child_against_its_parent(tmp_path, first, second):
    """theta_2 = -ratio theta_1, both from the reference body about the axes of the gearbox, however hinges are."""
    n, m = (0.3, 1, 0.2), (-0.3, -1, -0.2)
    ends = [("frame", "one")[:: -1 if first else 1], ("frame", "two")[:: -1 if second else 1]]
    body = link("frame", 1.0) + link("one", 1.0) + link("two", 1.0, "<pose>1 0 0 0 0 0</pose>")
    body += joint("h1", "revolute", *ends[0], axis(n, frame="__model__"))
    body += joint("h2", "revolute", *ends[1], axis(m, frame="__model__"))
    more = "<gearbox_ratio>2.5</gearbox_ratio><gearbox_reference_body>frame</gearbox_reference_body>"
    body += joint("box", "gearbox", "one", "two", axis(n) + axis(n, tag="axis2") + more)
    system = read_sdf(written(tmp_path, body)).system
    assert isinstance(system.part("box", "joints"), Gear) and system.check().mobility == 7
    state = system.assemble(rates={"h1": 1.0})
    found = {x.name: state.v[6 * i + 3 : 6 * i + 6] for i, x in enumerate(system.bodies)}
    one, two = found["one"] - found["frame"], found["two"] - found["frame"]
    assert np.abs(two + 2.5 * one).max() < 1e-12 * np.abs(two).max()
    assert np.abs(one).max() > 0.1


@pytest.mark.parametrize(
    ("pitch", "wanted"),
    [("<screw_thread_pitch>0.3</screw_thread_pitch>", 0.3), ("<thread_pitch>4</thread_pitch>", -np.pi / 2)],
)
def test_a_screw_advances_by_its_pitch_a_turn(tmp_path, pitch, wanted):
    body = link("a", 1.0) + joint("s", "screw", "world", "a", axis((1, 2, 0)) + pitch)
    screw = read_sdf(written(tmp_path, body)).system.joints[0]
    assert isinstance(screw, Screw) and screw.pitch == pytest.approx(wanted, rel=1e-15)


def test_a_mimic_follows(tmp_path):
    body = link("a", 1.0) + link("b", 1.0)
    body += joint("h", "revolute", "world", "a", axis((0, 1, 0)))
    mimic = '<mimic joint="h" axis="axis"><multiplier>-0.4</multiplier></mimic>'
    body += joint("s", "prismatic", "world", "b", axis((1, 0, 0), mimic))
    system = read_sdf(written(tmp_path, body, version="1.11")).system
    state = system.assemble(rates={"h": 2.0})
    assert state.v[6] == pytest.approx(-0.8, rel=1e-12)


WORLD = f"""<world name="w"><gravity>0.5 0 -3</gravity>
  <model name="one"><pose>0 0 1 0 0 0.5</pose>{link("l", 1.0)}</model>
  <model name="two">{link("l", 2.0)}{link("hangs", 1.0, "<pose>0 0 -1 0 0 0</pose>")}
    {joint("j", "revolute", "l", "hangs", axis((0, 1, 0)))}</model>
  <model name="table"><static>true</static>{link("l")}</model>
  <state world_name="later"><sim_time>2 500000000</sim_time><model name="two">
    <link name="l"><pose>1 2 3 0 0 0</pose><velocity>0 0 0 0 2 0</velocity></link>
    <link name="hangs"><pose>1 2 2 0 0 0</pose><velocity>-2 0 0 0 3 0</velocity></link></model></state>
</world>"""


def test_a_world_has_models_gravity_and_states(tmp_path):
    found = read_sdf(written(tmp_path, WORLD, model=False))
    assert [x.name for x in found.system.bodies] == ["one::l", "two::l", "two::hangs"]
    assert found.system.gravity.tolist() == [0.5, 0.0, -3.0]
    assert found.said == ("two::l floats; floating=False fixes, floating=True says so",)  # a stone alone is free
    assert found.system.check().mobility == 13 and found.merged == {"table::l": "ground"}
    state = found.states["later"]
    assert state.t == 2.5 and state.q[7:10].tolist() == [1.0, 2.0, 3.0] and state.v[10] == 2.0
    assert state.q[:3].tolist() == [0.0, 0.0, 1.0]  # the file does not name it
    solution = simulate(found.system, 3.0, state=state)
    assert solution.certificate.passed and solution.rate("two::j")[0] == pytest.approx(1.0)


def test_defaults_of_the_format_are_used_and_said(tmp_path):
    body = link("a") + link("b", 1.0, more="<gravity>false</gravity>")
    found = read_sdf(written(tmp_path, f'<world name="w"><model name="m">{body}</model></world>', model=False))
    assert found.said == ("'a' has no <inertial>: 1 kg and 1 kg m^2, as the format says",)
    one = found.system.bodies[0]
    assert one.mass == 1.0 and np.array_equal(one.inertia, np.eye(3))
    found_rates = accelerations(found.system, found.system.state())
    assert found_rates.acceleration("a")[0].tolist() == [0.0, 0.0, -9.8]
    assert np.abs(found_rates.acceleration("b")).max() < 1e-15  # no gravity acts on it


def test_contact_and_limits_are_inactive_and_looks_are_drawn(tmp_path):
    box = "<geometry><box><size>1 2 3</size></box></geometry>"
    looks = f'<visual name="v"><pose>0 0 1 0 0 0</pose>{box}<material><diffuse>1 0 0 1</diffuse></material></visual>'
    looks += '<visual name="w"><geometry><mesh><uri>model://none/a.stl</uri></mesh></geometry></visual>'
    looks += f'<collision name="c">{box}</collision><sensor name="s" type="imu"/>'
    limits = "<limit><lower>-1</lower><upper>1</upper><effort>10</effort><velocity>inf</velocity></limit>"
    body = link("a", 1.0, more=looks) + link("b", 1.0, more=looks)
    body += joint("j", "revolute", "a", "b", axis((0, 1, 0), limits)) + '<plugin name="p" filename="evil.so"/>'
    path = written(tmp_path, body)
    with pytest.warns(UserWarning, match="inactive: 1 limit .watched., 1 effort limit, contact"):
        found = read_sdf(path)
    assert found.idle == {"visual": 4, "collision": 2, "sensor": 2, "plugin": 1}
    assert found.system.limits[0].upper == 1.0 and found.missing == ("model://none/a.stl: not found",)
    assert found.system.bodies[0].shape[0].colour == "#ff0000"
    with pytest.raises(ValueError, match="limit: range of j .line 1, <joint>."):
        read_sdf(path, strict=True)
    with pytest.warns(UserWarning, match="inactive: 1 effort limit, contact"):
        stopped = read_sdf(path, limits="stop").system
    assert not stopped.limits and [(stop.lower, stop.upper) for stop in stopped.forces] == [(-1.0, 1.0)]


A = link("a", 1.0)
WRONG = [
    (A, {"version": "1.3"}, "line 1, <sdf>: version 1.3 is older than 1.4, whose elements have other names"),
    (A, {"version": "new"}, "<sdf>: version='new' is not 2 finite numbers"),
    ("", {}, "it has no <link>; give links"),
    (A + A, {}, "<link>: the name 'a' another frame has; give another one"),
    (link("world", 1.0), {}, "the name 'world' is reserved or has '::'"),
    (A + joint("j", "hinge", "world", "a"), {}, "joint 'j' is of the type 'hinge'; give one of revolute"),
    (A + joint("j", "ball", "world", "b"), {}, "<child>: 'b' is not a link, joint or frame; name one of this model"),
    (A + '<joint name="j" type="ball"><child>a</child></joint>', {}, "joint 'j' has no <parent>; name a link"),
    (A + joint("j", "revolute", "world", "a"), {}, "joint 'j' has no <axis>; give it"),
    (A + joint("j", "revolute", "world", "a", axis((0, 0, 0))), {}, "axis of joint 'j' has no length"),
    (
        A + joint("j", "revolute", "world", "a", axis((0, 0, 1), frame="x")),
        {},
        "<axis>: 'x' is not a link, joint or frame",
    ),
    (link("a", 1.0, "<pose>1 2 3</pose>"), {}, "line 1, <pose>='1 2 3' is not 6 finite numbers; correct it"),
    (link("a", 1.0, "<pose>0 0 nan 0 0 0</pose>"), {}, "is not 6 finite numbers"),
    (link("a", 1.0, "<pose>0 0 1e200 0 0 0</pose>"), {}, "1e\\+200"),
    (link("a", 1.0, '<pose relative_to="a"/>'), {}, "frame 'a' is placed in itself; cut the chain"),
    ('<frame name="f" attached_to="g"/><frame name="g" attached_to="f"/>' + A, {}, "'[fg]' is .*itself; cut the chain"),
    ('<link name="a"><inertial><mass>-1</mass></inertial></link>', {}, "link 'a': -1 kg; give a finite mass >= 0"),
    ('<link name="a"><inertial auto="true"/></link>', {}, "of link 'a': auto=\"true\" needs a <collision>; give one"),
    ('<link name="a"><inertial><inertia><ixx>-3</ixx></inertia></inertial></link>', {}, "principal moments"),
    (link("a", 1.0, more="<kinematic>1</kinematic>"), {}, "link 'a' is kinematic, no force moves it"),
    (link("a", 1.0, '<pose degrees="yes">0 0 0 0 0 0</pose>'), {}, "<pose>: degrees: 'yes' is neither true nor false"),
    (A + "<static>maybe</static>", {}, "<static>: 'maybe' is neither true nor false"),
    (A + "<include><uri>model://table</uri></include>", {}, "<include>: model 'model://table' is not found"),
    (
        A + joint("g", "gearbox", "a", "a", axis((0, 0, 1)) + axis((0, 0, 1), tag="axis2")),
        {},
        "gearbox 'g' needs a <gear",
    ),
    ("<world name='w'/><world name='v'/>", {"model": False}, "more or less than one world or model .'w', 'v'."),
    (
        '<link name="a"><inertial><fluid_added_mass/></inertial></link>',
        {},
        "fluid: added mass of a .line 1, <link>.; leave",
    ),
]


@pytest.mark.parametrize("case", WRONG, ids=[message[:40] for _, _, message in WRONG])
def test_what_is_wrong_is_named_with_its_line_and_a_remedy(tmp_path, case):
    body, more, message = case
    path = written(tmp_path, body, **more)
    with pytest.raises(ValueError, match=message) as caught:
        read_sdf(path)
    assert str(path) in str(caught.value)


def nested(depth):
    """Models in models."""
    return "".join(f'<model name="m{i}">' for i in range(depth)) + A + "</model>" * depth


def chained(count):
    """Frames that are placed in each other, the last first."""
    frames = [f'<frame name="f{i}" attached_to="f{i + 1}"/>' for i in range(count)]
    return "".join(frames) + f'<frame name="f{count}"/>' + A


HOSTILE = {
    "entity": ('<!DOCTYPE s [<!ENTITY x "&#60;link/>">]><sdf version="1.9">&x;</sdf>', "entity x.* is declared"),
    "file": ('<!DOCTYPE s [<!ENTITY x SYSTEM "/etc/passwd">]><sdf version="1.9">&x;</sdf>', "entity x.* is declared"),
    "nested": (
        f'<sdf version="1.9"><model name="m">{nested(5000)}</model></sdf>',
        "more than 200 models in each other",
    ),
    "chain": (f'<sdf version="1.9"><model name="m">{chained(5000)}</model></sdf>', "200 frames|itself; cut the chain"),
    "circle": (
        '<sdf version="1.9"><model name="m" placement_frame="a"><link name="a"><pose relative_to="world"/></link>'
        "</model></sdf>",
        "frame 'm' is placed in itself; cut the chain",
    ),
    "many": (f'<sdf version="1.9"><model name="m">{"<link/>" * 30000}</model></sdf>', "more than 20000 elements"),
    "cut": ('<sdf version="1.9"><model name="m"><link', "no XML"),
    "other": ("<robot/>", "its root is <robot>, not <sdf>"),
    "digits": ('<sdf version="1_0"><model name="m"/></sdf>', "is not"),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_files_are_refused(tmp_path, case):
    text, message = HOSTILE[case]
    path = tmp_path / "model.sdf"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        read_sdf(path)


def test_meshes_are_not_opened_outside(tmp_path):
    outside, inside = tmp_path / "mesh.stl", tmp_path / "in"
    outside.write_text("solid s\nendsolid s\n")
    inside.mkdir()
    look = '<visual name="v"><geometry><mesh><uri>{}</uri></mesh></geometry></visual>'
    for uri in ("../mesh.stl", f"file://{outside}", str(outside)):
        found = read_sdf(written(inside, link("a", 1.0, more=look.format(uri))))
        assert found.missing == (f"{uri}: not found",)


@pytest.mark.parametrize("case", ["cut", "other", "digits"])
def test_errors_name_the_file_once(tmp_path, case):
    path = tmp_path / "model.sdf"
    path.write_text(HOSTILE[case][0])
    with pytest.raises(ValueError) as caught:
        read_sdf(path)
    assert str(caught.value).count(f"'{path}'") == 1
