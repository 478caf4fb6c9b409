"""The reader of URDF: accelerations of MuJoCo and of reduced equations, the rules of the base, files as they are."""

import json
import re
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest
from helpers.mujoco_states import TOLERANCE, difference, general_motion, state_of
from scipy.spatial.transform import Rotation

from mbsd3d import (
    GROUND,
    Brake,
    Coupler,
    Gear,
    Planar,
    Prismatic,
    RackPinion,
    Revolute,
    Spherical,
    accelerations,
    read_urdf,
    simulate,
)

pytestmark = pytest.mark.filterwarnings("ignore:.*(inactive|is fixed):UserWarning")

I = "0.31 0.35 0.22 0.02 -0.03 0.04"  # ixx iyy izz ixy ixz iyz


def text_of(values):
    """Numbers as a file has them, to the last bit."""
    return " ".join(repr(float(x)) for x in np.ravel(values))


def inertial(mass, xyz=(0.11, -0.07, 0.2), rpy=(0.3, -0.4, 0.8), moments=I):
    """An <inertial> of URDF."""
    entries = zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), moments.split(), strict=True)
    inertia = " ".join(f'{key}="{value}"' for key, value in entries)
    origin = f'<origin xyz="{text_of(xyz)}" rpy="{text_of(rpy)}"/>'
    return f'<inertial>{origin}<mass value="{mass}"/><inertia {inertia}/></inertial>'


def link(name, mass=None, more=""):
    """A link, without mass if it has none."""
    return f'<link name="{name}">{"" if mass is None else inertial(mass)}{more}</link>'


def joint(name, kind, parent, child, seed, more="", axis=True):
    """A joint at an oblique place."""
    rng = np.random.default_rng(seed)
    xyz, rpy, a = rng.normal(size=3), rng.uniform(-3, 3, 3), rng.normal(size=3)
    line = f'<axis xyz="{text_of(a)}"/>' if axis else ""
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{text_of(xyz)}" rpy="{text_of(rpy)}"/>{line}{more}</joint>'
    )


def place(seed):
    """Position, quaternion and unit axis of the same joint, as MJCF has them: not by the code under test."""
    rng = np.random.default_rng(seed)
    xyz, rpy, a = rng.normal(size=3), rng.uniform(-3, 3, 3), rng.normal(size=3)
    turn = Rotation.from_euler("xyz", rpy).as_quat(scalar_first=True)
    return f'pos="{text_of(xyz)}" quat="{text_of(turn)}"', a / np.linalg.norm(a)


def mjcf_inertial(mass, xyz=(0.11, -0.07, 0.2), rpy=(0.3, -0.4, 0.8)):
    """The same inertial in MJCF: inertia in the axes of the link."""
    xx, yy, zz, xy, xz, yz = map(float, I.split())
    R = Rotation.from_euler("xyz", rpy).as_matrix()
    J = R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T
    full = [J[0, 0], J[1, 1], J[2, 2], J[0, 1], J[0, 2], J[1, 2]]
    return f'<inertial mass="{mass}" pos="{text_of(xyz)}" fullinertia="{text_of(full)}"/>'


def written(folder, body, name="robot.urdf", head=""):
    """A file of what stands in <robot>."""
    path = folder / name
    path.write_text(f'{head}<robot name="r">{body}</robot>')
    return path


def plane(axis):
    """Two directions across an axis."""
    x = np.cross(axis, [0.3, 0.5, 0.2])
    x /= np.linalg.norm(x)
    return x, np.cross(axis, x)


ROBOT = (
    link("base", 3.1)
    + link("upper", 1.4)
    + link("tool", 0.6)
    + link("lower", 0.9)
    + link("ram", 0.8)
    + link("plate", 0.7)
    + link("stone", 1.3)
    + joint("shoulder", "revolute", "base", "upper", 1, '<dynamics damping="0.6"/><limit lower="-1" upper="2"/>')
    + joint("grip", "fixed", "upper", "tool", 2)
    + joint("elbow", "continuous", "tool", "lower", 3, '<dynamics damping="0.2" friction="0"/>')
    + joint("rod", "prismatic", "base", "ram", 4, '<dynamics damping="1.2"/>')
    + joint("table", "planar", "upper", "plate", 5)
    + joint("loose", "floating", "base", "stone", 6)
)


def robot_in_mjcf():
    """The same robot, floating."""
    (upper, a1), (tool, _), (lower, a3), (ram, a4), (plate, a5), (_, _) = (place(seed) for seed in range(1, 7))
    x, y = plane(a5)
    return f"""<mujoco><compiler angle="radian" autolimits="false"/><worldbody>
    <body name="base"><freejoint/>{mjcf_inertial(3.1)}
      <body name="upper" {upper}><joint name="shoulder" axis="{text_of(a1)}" damping="0.6"/>{mjcf_inertial(1.4)}
        <body name="tool" {tool}>{mjcf_inertial(0.6)}
          <body name="lower" {lower}><joint name="elbow" axis="{text_of(a3)}" damping="0.2"/>{mjcf_inertial(0.9)}</body>
        </body>
        <body name="plate" {plate}><joint name="px" type="slide" axis="{text_of(x)}"/>
          <joint name="py" type="slide" axis="{text_of(y)}"/><joint name="pz" axis="{text_of(a5)}"/>
          {mjcf_inertial(0.7)}</body>
      </body>
      <body name="ram" {ram}><joint name="rod" type="slide" axis="{text_of(a4)}" damping="1.2"/>
        {mjcf_inertial(0.8)}</body>
    </body>
    <body name="stone" {place(6)[0]}><freejoint/>{mjcf_inertial(1.3)}</body>
    </worldbody></mujoco>"""


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_floating_robot_has_the_accelerations_of_mujoco(tmp_path, seed):
    found = read_urdf(written(tmp_path, ROBOT), floating=True)
    model = mujoco.MjModel.from_xml_string(robot_in_mjcf())
    assert found.system.check().mobility == model.nv == 18
    assert found.system.total_mass() == pytest.approx(8.8, rel=1e-15)  # the root's mass is there
    assert {type(part) for part in found.system.joints} == {Revolute, Prismatic, Planar}
    data = general_motion(model, seed, angle=2.5)
    assert difference(found.system, state_of(found.system, model, data), model, data) < TOLERANCE


def test_a_spherical_joint_is_a_ball(tmp_path):
    """No word of the format, but of one of its readers; what its limits are of is not said there."""
    limit = '<limit lower="-1" upper="1"/>'
    body = link("base", 3.1) + link("head", 1.4) + joint("neck", "spherical", "base", "head", 7, limit)
    found = read_urdf(written(tmp_path, body), floating=True)
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><worldbody><body name="base"><freejoint/>{mjcf_inertial(3.1)}
        <body name="head" {place(7)[0]}><joint type="ball"/>{mjcf_inertial(1.4)}</body></body></worldbody></mujoco>"""
    )
    assert [type(x) for x in found.system.joints] == [Spherical] and found.inactive == "1 limit"
    data = general_motion(model, 3, angle=2.0)
    assert difference(found.system, state_of(found.system, model, data), model, data) < TOLERANCE


def test_a_fixed_robot_has_the_accelerations_of_mujoco(tmp_path):
    with pytest.warns(UserWarning, match=r"inactive: 1 limit \(watched\); base is fixed; floating=True frees it"):
        found = read_urdf(written(tmp_path, ROBOT))
    model = mujoco.MjModel.from_xml_string(robot_in_mjcf().replace("<freejoint/>", "", 1))
    assert found.merged == {"base": "ground", "tool": "upper"}
    data = general_motion(model, 4, angle=2.5)
    assert difference(found.system, state_of(found.system, model, data), model, data) < TOLERANCE
    (where, _), tool = place(2), found.points["tool"]
    assert tool.body == "upper" and np.abs(tool.axes - matrix_of(where)).max() < 1e-14
    assert np.abs(tool.position - np.random.default_rng(2).normal(size=3)).max() < 1e-14


def test_several_turns_are_counted(tmp_path):
    """A limit is watched from the zero of the file, over turns; nothing keeps it."""
    body = link("world") + link("arm", 1.0)
    body += joint("elbow", "revolute", "world", "arm", 1, '<limit lower="-1" upper="7" effort="3" velocity="2"/>')
    found = read_urdf(written(tmp_path, body))
    assert found.inactive == "1 limit (watched), 1 effort limit, 1 velocity limit"
    system = found.system
    run = simulate(system, 0.3, state=system.assemble(angles={"elbow": 6.9}, rates={"elbow": 4.0}), output=31)
    angle = run.angle("elbow")
    excess = np.maximum(angle - 7.0, 0.0)
    worst = int(excess.argmax())
    assert excess[worst] > 0.01
    text = f"limit of 'elbow' passed by {excess[worst]:.3g} rad at {run.t[worst]:.4g} s"
    assert text in run.certificate.notes and "inactive: " + found.inactive in run.certificate.notes


@pytest.mark.parametrize(
    ("body", "said", "mobility"),
    [
        (link("drone", 2.0), ("floating base",), 6),
        (link("drone", 2.0) + link("cam", 0.1) + joint("mount", "fixed", "drone", "cam", 1), ("floating base",), 6),
        (link("foot") + link("arm", 1.0) + joint("j", "continuous", "foot", "arm", 1), (), 1),
        (link("world") + link("arm", 1.0) + joint("j", "continuous", "world", "arm", 1), (), 1),
        (link("arm", 1.0) + joint("j", "continuous", "world", "arm", 1), (), 1),
        (link("arm", 1.0) + joint("j", "floating", "world", "arm", 1), (), 6),
    ],
)
def test_the_base_is_fixed_or_floats_as_the_file_says(tmp_path, body, said, mobility):
    found = read_urdf(written(tmp_path, body))
    assert found.said == said and found.system.check().mobility == mobility


def test_a_choice_of_the_base_is_said_once(tmp_path):
    path = written(tmp_path, link("base", 1.0) + link("arm", 1.0) + joint("j", "continuous", "base", "arm", 1))
    with pytest.warns(UserWarning, match="robot.urdf': base is fixed; floating=True frees it") as caught:
        found = read_urdf(path)
    assert len(caught) == 1 and caught[0].filename == __file__
    assert str(found) == "1 joint, 1 body; base is fixed; floating=True frees it, floating=False says so"
    assert read_urdf(path, floating=False).system.check().mobility == 1
    free = read_urdf(path, floating=True)
    assert free.system.check().mobility == 7 and str(free) == "1 joint, 2 bodies; floating base"


@pytest.mark.parametrize(
    ("body", "message"),
    [
        (link("foot") + link("arm", 1.0) + joint("j", "continuous", "foot", "arm", 1), "root 'foot' has no mass"),
        (link("arm", 1.0) + joint("j", "continuous", "world", "arm", 1), "root 'world' is the fixed frame"),
    ],
)
def test_a_base_that_cannot_float_is_refused(tmp_path, body, message):
    with pytest.raises(ValueError, match=f"robot.urdf': floating=True: the {message}; give floating=False"):
        read_urdf(written(tmp_path, body), floating=True)


def reduced(model, data, T):
    """Accelerations of y = T x in a motion that meets it: M and h of MuJoCo, (T' M T) x_dd = -T' h."""
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    h = data.qfrc_bias - data.qfrc_passive
    return T @ np.linalg.solve(T.T @ M @ T, -T.T @ h)


def test_mimics_have_the_accelerations_of_reduced_equations(tmp_path):
    """Hinge by hinge, slide by hinge, hinge by slide, slide by slide; offsets, a chain of followers."""
    rules = {"b": ("a", -1.7, 0.3), "c": ("b", 0.4, -0.2), "d": ("c", 0.9, 0.1), "e": ("d", 2.0, 0.4)}
    rules["f"] = ("e", -0.6, 0.0)
    kinds = {"a": "continuous", "b": "continuous", "c": "prismatic", "d": "prismatic", "e": "revolute"}
    kinds["f"] = "prismatic"
    body = link("base")
    parents = {"a": "base", "b": "la", "c": "la", "d": "lc", "e": "base", "f": "le"}
    for seed, (name, kind) in enumerate(kinds.items(), 1):
        mimic = ""
        if name in rules:
            mimic = '<mimic joint="{}" multiplier="{}" offset="{}"/>'.format(*rules[name])
        body += link(f"l{name}", 1.0 + 0.1 * seed) + joint(name, kind, parents[name], f"l{name}", seed, mimic)
    path = written(tmp_path, body)

    def in_mjcf(name):
        seed = list(kinds).index(name) + 1
        where, axis = place(seed)
        inner = "".join(in_mjcf(child) for child, parent in parents.items() if parent == f"l{name}")
        kind = "slide" if kinds[name] == "prismatic" else "hinge"
        line = f'<joint name="{name}" type="{kind}" axis="{text_of(axis)}"/>'
        return f'<body name="l{name}" {where}>{line}{mjcf_inertial(1.0 + 0.1 * seed)}{inner}</body>'

    nested = "".join(in_mjcf(name) for name, parent in parents.items() if parent == "base")
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><worldbody>{nested}</worldbody></mujoco>'
    )
    found = read_urdf(path)
    assert found.system.check().mobility == 1
    assert {type(part) for part in found.system.joints} == {Revolute, Prismatic, Gear, RackPinion, Coupler}
    T, values = {"a": 1.0}, {"a": 4.2}  # most of a turn
    for name, (leader, m, o) in rules.items():
        T[name], values[name] = m * T[leader], m * values[leader] + o
    data, names = mujoco.MjData(model), [model.joint(i).name for i in range(model.nv)]
    column = np.array([[T[name]] for name in names])
    data.qpos[:], data.qvel[:] = [values[name] for name in names], 1.3 * column[:, 0]
    mujoco.mj_forward(model, data)
    data.qacc[:] = reduced(model, data, column)
    mujoco.mj_rnePostConstraint(model, data)
    system = found.system
    state = system.assemble(angles={"a": 4.2}, rates={"a": 1.3})
    ours = accelerations(system, state)
    for name in kinds:
        read = ours.angle if kinds[name] != "prismatic" else ours.slide
        start = values[name] - float(read(name)[0])  # the file counts from its zero, the system from where it starts
        assert start == pytest.approx({"a": 0.0, "b": 0.3, "c": -0.08, "d": 0.028, "e": 0.456, "f": -0.2736}[name])
    assert difference(system, state, model, data, [f"l{name}" for name in kinds]) < TOLERANCE
    assert any("'b' counts from 0.3, where it starts" in text for text in found.said)


def test_a_massless_link_carries_motion_on(tmp_path):
    """A cross without mass between two hinges apart: MuJoCo has both on one body."""
    body = link("world") + link("cross") + link("arm", 1.2)
    body += joint("one", "continuous", "world", "cross", 1) + joint("two", "continuous", "cross", "arm", 2)
    system = read_urdf(written(tmp_path, body)).system
    assert [b.mass for b in system.bodies] == [0.0, 1.2]
    (outer, a), (inner, b) = place(1), place(2)
    text = f"""<mujoco><worldbody><body name="frame" {outer}><body name="arm" {inner}>
      <joint name="one" axis="{{a}}" pos="{{p}}"/><joint name="two" axis="{text_of(b)}"/>{mjcf_inertial(1.2)}
      </body></body></worldbody></mujoco>"""
    rng = np.random.default_rng(2)
    xyz, rpy = rng.normal(size=3), rng.uniform(-3, 3, 3)
    R = Rotation.from_euler("xyz", rpy).as_matrix()
    model = mujoco.MjModel.from_xml_string(text.format(a=text_of(R.T @ a), p=text_of(-R.T @ xyz)))
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:] = (0.7, -1.9), (1.3, -2.1)
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    state = system.assemble(angles={"one": 0.7, "two": -1.9}, rates={"one": 1.3, "two": -2.1})
    assert difference(system, state, model, data, ["arm"]) < TOLERANCE


def test_joints_that_nothing_feels_are_welded(tmp_path):
    point = '<link name="tip"><inertial><origin xyz="0 0 0.4"/><mass value="0.3"/><inertia ixx="0" iyy="0" izz="0"/>'
    point += "</inertial></link>"
    spin = '<joint name="spin" type="continuous"><parent link="arm"/><child link="tip"/><axis xyz="0 0 1"/></joint>'
    body = link("base") + link("arm", 1.0) + link("wheel") + link("hub") + point + spin
    body += joint("a", "continuous", "base", "arm", 1) + joint("b", "prismatic", "arm", "hub", 2)
    body += joint("c", "continuous", "hub", "wheel", 3)
    found = read_urdf(written(tmp_path, body))
    assert found.merged == {"base": "ground", "hub": "arm", "wheel": "arm", "tip": "arm"}
    assert found.said == ("welded, as nothing that has mass can feel it: 'b', 'c', 'spin'",) or set(
        re.findall("'(.*?)'", found.said[0])
    ) == {"b", "c", "spin"}
    assert [b.mass for b in found.system.bodies] == [pytest.approx(1.3, rel=1e-15)]
    tilted = written(tmp_path, body.replace('<axis xyz="0 0 1"/>', '<axis xyz="0 1 1"/>'))  # the point swings
    assert read_urdf(tilted).system.check().mobility == 2


def test_friction_slips_and_holds(tmp_path):
    body = link("world") + link("arm", 1.0)
    body += joint("j", "continuous", "world", "arm", 1, '<dynamics friction="0.4" damping="0.1"/>')
    found = read_urdf(written(tmp_path, body))
    (brake,) = (force for force in found.system.forces if isinstance(force, Brake))
    where, axis = place(1)
    text = f'<mujoco><worldbody><body name="arm" {where}><joint name="j" axis="{text_of(axis)}" damping="0.1"/>'
    text += f"{mjcf_inertial(1.0)}</body></worldbody></mujoco>"
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.qfrc_applied[:] = 0.5, 3.0, -0.4  # it slips: the torque of friction is constant
    mujoco.mj_forward(model, data)
    state = found.system.assemble(angles={"j": 0.5}, rates={"j": 3.0})
    alpha = accelerations(found.system, state).alpha("arm")[0]
    turning = matrix_of(where) @ axis
    assert turning @ alpha == pytest.approx(data.qacc[0], rel=TOLERANCE)
    assert brake.torque.value == 0.4 and "dry friction of 1 joint yields by 0.001 rad or m at rest" in found.said


def matrix_of(where):
    """Rotation matrix of the attributes of a body."""
    numbers = [float(x) for x in re.search('quat="(.*?)"', where)[1].split()]
    return Rotation.from_quat(numbers, scalar_first=True).as_matrix()


LONG = "0.1 0.2 0.7 0.01 0.02 -0.03"  # 0.7 > 0.1 + 0.2


def test_an_inertia_that_no_body_has_is_taken_as_given_and_said(tmp_path):
    body = f'<link name="world"/><link name="arm">{inertial(1.0, rpy=(0, 0, 0), moments=LONG)}</link>'
    path = written(tmp_path, body + joint("j", "continuous", "world", "arm", 1))
    found = read_urdf(path)
    (arm,) = found.system.bodies
    expected = np.array([[0.1, 0.01, 0.02], [0.01, 0.2, -0.03], [0.02, -0.03, 0.7]])
    assert np.abs(arm.inertia - expected).max() < 1e-15 and arm.inertia_as_given
    assert re.search("inertia of 'arm' has the principal moments .* no body has it; taken as given", found.said[0])
    with pytest.raises(ValueError, match=r"robot.urdf': body 'arm' \(line 1, <link>\): inertia of 'arm' .*as given"):
        read_urdf(path, inertia="refuse")
    again = type(found.system).from_file(found.system.to_file(tmp_path / "kept.toml"))
    assert np.array_equal(again.bodies[0].inertia, arm.inertia)
    state = found.system.assemble(rates={"j": 2.0})
    where, axis = place(1)
    a = matrix_of(where) @ axis  # a free spin about a fixed axis: I_a alpha = torque of gravity
    arms = matrix_of(where) @ (0.11, -0.07, 0.2)
    J = axis @ expected @ axis + np.cross(a, arms) @ np.cross(a, arms)
    torque = a @ np.cross(arms, (0.0, 0.0, -9.81))
    assert accelerations(found.system, state).alpha("arm")[0] @ a == pytest.approx(torque / J, rel=TOLERANCE)


def test_a_wrong_link_in_a_sound_group_is_no_matter(tmp_path):
    body = f'<link name="world"/><link name="arm">{inertial(1.0)}</link><link name="lid">'
    body += inertial(0.1, rpy=(0, 0, 0), moments="0.001 0.001 0.009 0 0 0") + "</link>"
    body += joint("j", "continuous", "world", "arm", 1) + joint("k", "fixed", "arm", "lid", 2)
    assert read_urdf(written(tmp_path, body), inertia="refuse").said == ()


@pytest.mark.parametrize(
    ("moments", "message"),
    [("-0.1 0.2 0.2 0 0 0", "< 0; check the signs"), ("0 0 0 0 0 0", None), ("-5e-20 0 0 0 0 0", None)],
)
def test_negative_moments_are_refused_beyond_rounding(tmp_path, moments, message):
    body = f'<link name="world"/><link name="arm">{inertial(1.0, rpy=(0, 0, 0), moments=moments)}</link>'
    path = written(tmp_path, body + joint("j", "continuous", "world", "arm", 1))
    if message:
        with pytest.raises(ValueError, match=rf"robot.urdf': body 'arm' \(line 1, <link>\): .*{message}"):
            read_urdf(path)
    else:
        assert not read_urdf(path).system.bodies[0].inertia.any()


VENDOR = """<transmission name="t"><type>x</type></transmission><gazebo reference="arm"><plugin filename="libros.so"/>
  </gazebo><ros2_control name="c" type="system"/><drake:joint/><material name="red"><color rgba="1 0 0 1"/></material>
  <sensor name="s"/>"""
LOOKS = """<visual><origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/><geometry><box size="0.2 0.4 0.6"/></geometry>
  <material name="red"/></visual><visual><geometry><cylinder radius="0.1" length="0.5"/></geometry></visual>
  <visual><geometry><sphere radius="0.2"/></geometry><material name="unknown"/></visual>
  <visual><geometry><box size="none"/></geometry></visual><visual/>
  <visual><geometry><mesh filename="package://arm_description/meshes/a.stl" scale="0.5 0.5 0.5"/></geometry></visual>
  <visual><geometry><mesh filename="package://nowhere/b.dae"/></geometry></visual>
  <collision><geometry><mesh filename="http://a/c.stl"/></geometry></collision><sensor/>"""
TRIANGLES = "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n" * 2


def package(folder, mesh=f"solid s\n{TRIANGLES}endsolid s\n"):
    """A package with a robot and a mesh; returns the robot's folder."""
    (folder / "arm_description" / "meshes").mkdir(parents=True)
    (folder / "arm_description" / "meshes" / "a.stl").write_text(mesh)
    (folder / "arm_description" / "urdf").mkdir()
    return folder / "arm_description" / "urdf"


def test_nothing_is_refused_for_its_looks_or_vendor_tags(tmp_path):
    body = VENDOR + link("world") + link("arm", 1.0, LOOKS) + joint("j", "continuous", "world", "arm", 1, "<calib/>")
    found = read_urdf(written(package(tmp_path), body))
    box, can, ball, mesh = found.system.bodies[0].shape
    assert [type(x).__name__ for x in (box, can, ball, mesh)] == ["Box", "Cylinder", "Sphere", "MeshFile"]
    assert np.allclose(box.lengths, (0.2, 0.4, 0.6)) and box.colour == "#ff0000" and ball.colour is None
    R = Rotation.from_quat(box.orientation, scalar_first=True).as_matrix()
    assert np.allclose(R, Rotation.from_euler("xyz", (0.1, 0.2, 0.3)).as_matrix(), rtol=0, atol=1e-15)
    assert np.allclose(box.at, (0.1, 0.2, 0.3), rtol=0, atol=1e-15) and (can.radius, can.length) == (0.1, 0.5)
    assert mesh.scale == 0.5 and Path(mesh.path).name == "a.stl"
    assert len(found.missing) == 3 and any("b.dae: not found" in text for text in found.missing)
    tags = {"transmission": 1, "gazebo": 1, "ros2_control": 1, "drake:joint": 1, "material": 1, "calib": 1}
    assert tags.items() <= found.idle.items() and found.idle["visual"] == 7 and found.inactive == ""
    assert str(found) == "1 joint, 1 body; 3 mesh files not drawn"
    plain = read_urdf(tmp_path / "arm_description" / "urdf" / "robot.urdf", geometry="ignore")
    assert plain.system.bodies[0].shape is None and plain.missing == ()


def test_a_mesh_that_cannot_be_drawn_is_missing(tmp_path):
    body = link("world") + link("arm", 1.0, LOOKS) + joint("j", "continuous", "world", "arm", 1)
    found = read_urdf(written(package(tmp_path, "no mesh"), body))
    assert len(found.system.bodies[0].shape) == 3 and any("a.stl" in text for text in found.missing)


PLACES = {
    "package://arm_description/meshes/a.stl": True,
    "model://arm_description/meshes/a.stl": True,
    "../meshes/a.stl": False,  # above the folder of the file; see below
    "package://arm_description/../secret/s.stl": False,
    "package://secret/s.stl": False,  # a neighbour above that does not say that it is a package
    "package://../s.stl": False,
    "package://..": False,
    "package://": False,
    "file:///etc/passwd": False,
    "/etc/passwd": False,
    "link.stl": False,
    "a\\..\\..\\..\\secret\\s.stl": False,
    "x" * 5000 + ".stl": False,
    "http://a/b.stl": False,
}


@pytest.mark.parametrize("name", PLACES)
def test_meshes_are_looked_for_in_packages_and_nowhere_else(tmp_path, name):
    folder = package(tmp_path)
    (tmp_path / "secret").mkdir()
    (tmp_path / "secret" / "s.stl").write_text(f"solid s\n{TRIANGLES}endsolid s\n")
    (folder / "link.stl").symlink_to(tmp_path / "secret" / "s.stl")
    mesh = f'<visual><geometry><mesh filename="{name}"/></geometry></visual>'
    path = written(folder, link("arm", 1.0, mesh))
    assert (read_urdf(path).missing == ()) == PLACES[name]
    given = read_urdf(path, package_paths=[tmp_path / "arm_description"])
    assert (given.missing == ()) == (PLACES[name] or name == "../meshes/a.stl")


def test_a_neighbour_that_says_it_is_a_package_is_one(tmp_path):
    folder = package(tmp_path)
    other = tmp_path / "hand_description"
    other.mkdir()
    (other / "s.stl").write_text(f"solid s\n{TRIANGLES}endsolid s\n")
    mesh = '<visual><geometry><mesh filename="package://hand_description/s.stl"/></geometry></visual>'
    path = written(folder, link("arm", 1.0, mesh))
    assert read_urdf(path).missing
    assert not read_urdf(path, package_paths=tmp_path).missing
    (other / "package.xml").write_text("<package/>")
    assert not read_urdf(path).missing


def test_contact_limits_and_controllers_are_inactive(tmp_path):
    solid = "<collision><geometry><sphere radius='0.1'/></geometry></collision>"
    more = '<limit lower="-1" upper="2" effort="30" velocity="3"/><safety_controller k_velocity="1"/><calibration/>'
    body = link("world") + link("arm", 1.0, solid) + link("hand", 1.0, solid)
    body += joint("j", "revolute", "world", "arm", 1, more) + joint("k", "prismatic", "arm", "hand", 2, more)
    path = written(tmp_path, body)
    line = "2 limits (watched), 2 effort limits, 2 velocity limits, 2 safety controllers, contact"
    with pytest.warns(UserWarning, match=re.escape(f"robot.urdf': inactive: {line}")):
        found = read_urdf(path)
    assert found.inactive == line and [(x.lower, x.upper) for x in found.system.limits] == [(-1.0, 2.0)] * 2
    assert f"inactive: {line}" in accelerations(found.system).certificate.notes
    message = r"cannot import effort: j \(line 1, <joint>\); .*; contact: .*; leave_out=\[\"contact\", \"effort\""
    with pytest.raises(ValueError, match=message.replace("; leave", ".*leave")):
        read_urdf(path, strict=True)
    kinds = ("limit", "effort", "velocity", "safety", "contact")
    found = read_urdf(path, strict=True, leave_out=kinds)
    assert found.inactive == "" and len(found.dropped) == 9 and found.system.limits == ()
    assert found.system.notes[0].startswith("left out: effort: j; ")


@pytest.mark.parametrize("head", ["\n  \n", "\ufeff", "\ufeff\n"])
def test_blank_lines_marks_and_commas_are_passed_over(tmp_path, head):
    body = '<link name="arm"><inertial><origin xyz="0.1, 0.2 ,0.3" rpy="0,0,0"/><mass value="2"/>\n<inertia ixx="1" '
    body += 'iyy="1" izz="1"/></inertial></link>'
    path = tmp_path / "robot.urdf"
    path.write_text(f'{head}<?xml version="1.0" encoding="latin-1"?>\n<robot name="r">{body}</robot>', encoding="utf-8")
    assert np.allclose(read_urdf(path).system.bodies[0].com, (0.1, 0.2, 0.3), rtol=1e-15, atol=0)
    path.write_text(f"{head}<robot>\n<link/></robot>", encoding="utf-8")
    with pytest.raises(ValueError, match=rf"robot.urdf': line {head.count(chr(10)) + 2}, <link>: has no name"):
        read_urdf(path)


WRONG = {
    "no mass": (link("a") + link("b") + joint("j", "continuous", "a", "b", 1), "no link of it has a mass; give <inert"),
    "no links": ("", "it has no <link>"),
    "negative mass": (link("a", -1.0), r"line 1, <mass> of link 'a': -1 kg < 0; give"),
    "no inertia": ('<link name="a"><inertial><mass value="1"/></inertial></link>', r"of link 'a' has no <inertia>"),
    "words": (link("a", "heavy"), "line 1, <mass>: value='heavy' is not a finite number; correct it"),
    "nan": (link("a", "nan"), "value='nan' is not a finite number"),
    "huge": (link("a", "1e999"), "value='1e999' is not a finite number"),
    "large": (link("a", "1e200"), "line 1, <mass>: value: 1e.200 is beyond the largest magnitude 1e.60"),
    "underscore": (link("a", "1_0"), "value='1_0' is not a finite number"),
    "comma": (link("a", "1,5"), "value='1,5' is not a finite number"),
    "twice": (link("a", 1.0) * 2, "a second link is named 'a'"),
    "type": (link("a", 1.0) + link("b", 1.0) + joint("j", "ball", "a", "b", 1), "'j' is of the type 'ball'; give"),
    "no link": (link("a", 1.0) + joint("j", "fixed", "a", "b", 1), "child of joint 'j' is 'b', which is not a link"),
    "two roots": (link("a", 1.0) + link("b", 1.0), "links without a parent: 'a', 'b'"),
    "loop": (
        link("a", 1.0) + link("b", 1.0) + joint("j", "fixed", "a", "b", 1) + joint("k", "fixed", "a", "b", 2),
        "link 'b' has a second parent, joint 'k' beside 'j'",
    ),
    "circle": (
        link("a", 1.0) + link("b", 1.0) + link("c", 1.0) + joint("j", "fixed", "a", "b", 1)
        + joint("k", "fixed", "b", "a", 2),
        "link 'a' hangs on itself",
    ),
    "axis": (
        link("a", 1.0) + link("b", 1.0) + joint("j", "revolute", "a", "b", 1, '<axis xyz="0 0 0"/>', axis=False),
        "axis of joint 'j' has no length",
    ),
    "mimic of itself": (
        link("a", 1.0) + link("b", 1.0) + joint("j", "continuous", "a", "b", 1, '<mimic joint="j"/>'),
        "joint 'j' follows itself",
    ),
    "mimic of nothing": (
        link("a", 1.0) + link("b", 1.0) + joint("j", "continuous", "a", "b", 1, '<mimic joint="x"/>'),
        "follows 'x', which is not a joint",
    ),
    "negative damping": (
        link("a", 1.0) + link("b", 1.0) + joint("j", "continuous", "a", "b", 1, '<dynamics damping="-1"/>'),
        "damping of joint 'j' is -1 < 0",
    ),
    "damped plane": (
        link("a", 1.0) + link("b", 1.0) + joint("j", "planar", "a", "b", 1, '<dynamics damping="1"/>'),
        r'passive: damping or friction of j \(line 1, <joint>\); leave out with leave_out=\["passive"\]',
    ),
    "turn as a quaternion": (
        link("a", 1.0).replace("<origin", '<origin quat_xyzw="1 0 0 0"'),
        "line 1, <origin>: quat_xyzw is not read; give xyz, rpy, or remove it",
    ),
    "misspelled axis": (
        link("a", 1.0) + link("b", 1.0) + joint("j", "revolute", "a", "b", 1, '<axis xzy="0 1 0"/>', axis=False),
        "line 1, <axis>: xzy is not read; give xyz, or remove it",
    ),
    "spring": (
        link("a", 1.0) + link("b", 1.0) + joint("j", "revolute", "a", "b", 1, '<dynamics spring_stiffness="3"/>'),
        r"passive: spring_stiffness of j, which is not read \(line 1, <joint>\); leave out with leave_out=\[.passive",
    ),
    "wrong case of an inertial": (
        link("a", 1.0).replace("inertial>", "Inertial>"), "<Inertial>: is not read in this case; write <inertial>",
    ),
    "wrong case of an origin": (link("a", 1.0).replace("<origin", "<Origin"), "<Origin>: is not read in this case"),
    "wrong case of a link": (link("a", 1.0) + "<Link name='b'/>", "<Link>: is not read in this case; write <link>"),
    "wrong case of a limit": (
        link("a", 1.0) + link("b", 1.0) + joint("j", "revolute", "a", "b", 1, '<LIMIT lower="0" upper="1"/>'),
        "<LIMIT>: is not read in this case; write <limit>",
    ),
    "entities": ("&b;", "undefined entity|no XML"),
    "deep": ("<a>" * 30_000, "more than 20000 elements"),
    "many": ("<a/>" * 30_000, "more than 20000 elements"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_what_is_wrong_is_named_with_its_line_and_a_remedy(tmp_path, case):
    body, message = WRONG[case]
    with pytest.raises(ValueError, match=f"robot.urdf'.*({message})"):
        read_urdf(written(tmp_path, body))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('<!DOCTYPE a [<!ENTITY b "cc">]><robot/>', "line 1: entity b is declared"),
        ('<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><robot>&b;</robot>', "entity b is declared"),
        ("<mujoco/>", "its root is <mujoco>, not <robot>"),
        ("<robot><link>", r"line 1: no XML \(no element found\)"),
        (" \n ", "is empty"),
        ("solid", "no XML"),
    ],
)
def test_files_that_are_no_urdf_are_refused(tmp_path, text, message):
    path = tmp_path / "robot.urdf"
    path.write_text(text)
    with pytest.raises(ValueError, match=f"robot.urdf'.*{message}"):
        read_urdf(path)


XACRO = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="m" value="{value}"/>
  <link name="arm"><inertial><mass value="${{m}}"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link></robot>"""
STAND_IN = """
import os
class Text(str):
    toprettyxml = lambda self: self
def process_file(path):
    text = open(path).read()
    {more}
    return Text(text.replace("${{m}}", "2.5"))
"""  # in place of the package, which may not be installed; the real one was tried too


def with_stand_in(folder, monkeypatch, more="pass"):
    """Modules xacro and yaml that a subprocess finds first."""
    (folder / "lib").mkdir()
    (folder / "lib" / "xacro.py").write_text(STAND_IN.format(more=more))
    (folder / "lib" / "yaml.py").write_text("")
    monkeypatch.setenv("PYTHONPATH", str(folder / "lib"))
    path = folder / "robot.urdf.xacro"
    path.write_text(XACRO.format(value="2.5"))
    return path


def test_xacro_is_run_where_it_is_installed(tmp_path, monkeypatch):
    assert read_urdf(with_stand_in(tmp_path, monkeypatch)).system.bodies[0].mass == 2.5


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ("open('/etc/passwd')", "it opens '/etc/passwd', outside of its folder and of package_paths"),
        ("open(path, 'w')", "it opens '.*robot.urdf.xacro'"),
        ("os.system('true')", "it asks for 'os.system'"),
        ("import subprocess; subprocess.run(['true'])", "it asks for 'subprocess.Popen'"),
        ("import socket; socket.socket()", "it asks for 'socket.__new__'"),
        ("os.remove(path)", "it asks for 'os.remove'"),
        ("raise ValueError('undefined m')", "xacro: undefined m"),
    ],
)
def test_xacro_opens_and_starts_nothing_else(tmp_path, monkeypatch, more, message):
    path = with_stand_in(tmp_path, monkeypatch, more)
    with pytest.raises(ValueError, match=f"robot.urdf.xacro': xacro: .*{message}|{message}"):
        read_urdf(path)
    assert path.read_text() == XACRO.format(value="2.5")


def test_without_xacro_the_command_is_said(tmp_path):
    probe = "import sys; sys.modules['xacro'] = None; from mbsd3d.files.importing import xacro; sys.argv[1:] = "
    path = tmp_path / "robot.urdf.xacro"
    path.write_text(XACRO.format(value="2.5"))
    probe += f"[{str(path)!r}, '7']; xacro.main()"
    done = subprocess.run([sys.executable, "-c", probe], capture_output=True, timeout=60)
    message = json.loads(done.stdout)["error"]
    assert "pip install xacro" in message and "xacro robot.urdf.xacro > robot.urdf" in message


def test_what_xacro_has_written_needs_no_xacro(tmp_path):
    body = f"<!-- made by xacro from ${{x}} -->{link('arm', 1.0)}"
    path = tmp_path / "robot.urdf"
    path.write_text(f'<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">{body}</robot>')
    assert read_urdf(path).system.bodies[0].name == "arm"


def test_unknown_choices_are_refused(tmp_path):
    path = written(tmp_path, link("arm", 1.0))
    for choice, message in (
        ({"floating": 1}, "floating = 1; give True or False"),
        ({"geometry": "all"}, "geometry 'all' is unknown; give 'draw' or 'ignore'"),
        ({"inertia": "fix"}, "inertia 'fix' is unknown; give 'as given' or 'refuse'"),
        ({"strict": "yes"}, "strict = 'yes'; give True or False"),
        ({"leave_out": ["wings"]}, "leave_out: 'wings' is not a kind of part; give some of actuator, armature"),
        ({"package_paths": [tmp_path / "none"]}, "package_paths: .* is not a folder"),
        ({"package_paths": "x" * 9999}, "package_paths: .* is not a folder"),
        ({"package_paths": ["a\0b"]}, "package_paths: .* is not a folder"),
        ({"package_paths": 3}, "package_paths: 3 is not a sequence"),
        ({"timeout": -1}, "timeout"),
    ):
        with pytest.raises(ValueError, match=message):
            read_urdf(path, **choice)


def test_the_ground_is_the_ground(tmp_path):
    body = link("arm", 1.0) + joint("j", "continuous", "world", "arm", 1)
    (hinge,) = read_urdf(written(tmp_path, body)).system.joints
    assert hinge.a is GROUND
