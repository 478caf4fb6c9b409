"""Import of MJCF and URDF: the accelerations of MuJoCo, everything left over named, hostile files refused."""

import json
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.linalg import null_space

from mbsd3d import (
    AngleDriver,
    Cylindrical,
    Gear,
    Planar,
    Prismatic,
    RackPinion,
    Revolute,
    Spherical,
    State,
    Universal,
    accelerations,
    read_mjcf,
    read_urdf,
)
from mbsd3d.base.rotations import matrix

INERTIAL = '<inertial mass="{}" pos="0.11 -0.07 0.2" fullinertia="0.31 0.35 0.22 0.02 -0.03 0.04"/>'

TREE = f"""
<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <option gravity="0.7 -0.4 -9.6"/>
  <worldbody>
    <body name="base" pos="0.3 0.2 0.9" quat="0.8 0.3 -0.2 0.4">
      <freejoint name="float"/>{INERTIAL.format(3.1)}
      <body name="upper" pos="0.3 0.1 -0.2" quat="0.5 0.1 0.7 0.3">
        <joint name="shoulder" type="hinge" pos="0.05 0.02 -0.1" axis="1 2 -1.5" ref="0.3" springref="0.7"
               stiffness="2.5" damping="0.6"/>{INERTIAL.format(1.4)}
        <body name="tool" pos="0.1 0.3 0.2" quat="0.6 -0.2 0.5 0.1">{INERTIAL.format(0.6)}
          <body name="tip" pos="0.2 0.1 0.2" quat="0.1 0.2 0.5 0.7">{INERTIAL.format(0.3)}</body>
        </body>
        <body name="ram" pos="0.2 0.1 0.4" quat="0.9 -0.1 0.2 0.1">
          <joint name="rod" type="slide" axis="0.3 1 0.4" springref="0.2" stiffness="31" damping="1.2"/>
          {INERTIAL.format(0.8)}
        </body>
      </body>
      <body name="ball" pos="-0.3 0.2 0.1" quat="0.4 0.1 0.2 -0.6">
        <joint name="socket" type="ball" pos="0.1 0.05 0.02"/>{INERTIAL.format(0.9)}
        <body name="cross" pos="0.1 -0.4 0.2" quat="0.7 0.2 0.2 -0.1">
          <joint name="yoke a" type="hinge" pos="0.1 0.2 0.3" axis="1 2 2"/>
          <joint name="yoke b" type="hinge" pos="0.1 0.2 0.3" axis="2 1 -2"/>{INERTIAL.format(1.2)}
        </body>
      </body>
    </body>
    <body name="plate" pos="1 0.2 0.4" quat="0.6 0.1 0.3 0.2">
      <joint name="px" type="slide" axis="2 1 -2"/><joint name="py" type="slide" axis="3 0 3"/>
      <joint name="turn" type="hinge" pos="0.2 0.1 0.1" axis="1 -4 -1" damping="0.4"/>{INERTIAL.format(2.2)}
      <body name="spindle" pos="0.3 0.1 0.2" quat="0.2 0.5 0.1 0.4">
        <joint name="feed" type="slide" axis="0.2 0.5 1"/>
        <joint name="spin" type="hinge" pos="0.1 0.3 0.1" axis="0.2 0.5 1" damping="0.1"/>{INERTIAL.format(0.7)}
        <body name="head" pos="0.1 0.2 0.1" quat="0.2 0.1 -0.7 0.4">
          <joint name="g1" type="hinge" pos="0.1 0 0.1" axis="1 0.2 0.1"/>
          <joint name="g2" type="hinge" pos="0.1 0 0.1" axis="0.1 1 0.3"/>
          <joint name="g3" type="hinge" pos="0.1 0 0.1" axis="0.2 -0.1 1"/>{INERTIAL.format(0.5)}
        </body>
      </body>
    </body>
    <body name="post" pos="2 1 0.3" quat="0.9 0.1 0.1 0.3">{INERTIAL.format(9.0)}
      <body name="flag" pos="0.2 0.1 0.5"><joint name="mast" axis="1 1 3"/>{INERTIAL.format(0.4)}</body>
    </body>
  </worldbody>
</mujoco>
"""


def written(folder, text, name="model.xml"):
    """A file of a text."""
    path = folder / name
    path.write_text(text)
    return path


def general_motion(model, seed=7):
    """MuJoCo's data at a general state: accelerations of its own recursive dynamics."""
    rng, data = np.random.default_rng(seed), mujoco.MjData(model)
    data.qpos[:] = model.qpos0
    mujoco.mj_integratePos(model, data.qpos, rng.normal(size=model.nv), 0.3)
    data.qvel[:] = rng.normal(size=model.nv)
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    return data


def spatial(function, model, data, name):
    """(linear, angular) velocity or acceleration of a body's origin, world axes."""
    out = np.zeros(6)
    function(model, data, mujoco.mjtObj.mjOBJ_XBODY, model.body(name).id, out, 0)
    return out[3:], out[:3]


def state_of(system, model, data):
    """The same state in our coordinates."""
    q = [np.concatenate([data.body(b.name).xpos, data.body(b.name).xquat]) for b in system.bodies]
    v = [np.concatenate(spatial(mujoco.mj_objectVelocity, model, data, b.name)) for b in system.bodies]
    return State(0.0, np.concatenate(q), np.concatenate(v))


def test_accelerations_are_those_of_mujoco(tmp_path):
    path = written(tmp_path, TREE)
    found = read_mjcf(path)
    system, merged, dropped = found.system, found.merged, found.dropped
    model = mujoco.MjModel.from_xml_path(str(path))
    data = general_motion(model)
    assert system.check().mobility == model.nv == 22
    kinds = {type(joint) for joint in system.joints}
    assert kinds == {Revolute, Prismatic, Spherical, Universal, Planar, Cylindrical}
    assert merged == {"tool": "upper", "tip": "upper", "post": "ground"} and dropped == ()
    found = accelerations(system, state_of(system, model, data))
    for body in system.bodies:
        linear, angular = spatial(mujoco.mj_objectAcceleration, model, data, body.name)
        linear = linear + model.opt.gravity  # MuJoCo accelerates the world against gravity instead
        size = 1.0 + max(np.abs(linear).max(), np.abs(angular).max())
        limit = 1e-9 * size  # 22 freedoms, condition of the mass matrix 1e3: rounding of both codes is below 1e-12
        assert np.abs(found.acceleration(body)[0] - linear).max() < limit, body.name
        assert np.abs(found.alpha(body)[0] - angular).max() < limit, body.name


def test_accelerations_would_show_a_wrong_mass(tmp_path):
    system = read_mjcf(written(tmp_path, TREE)).system
    model = mujoco.MjModel.from_xml_string(TREE.replace('mass="0.3"', 'mass="0.301"'))
    data = general_motion(model)
    linear, _ = spatial(mujoco.mj_objectAcceleration, model, data, "upper")
    found = accelerations(system, state_of(system, model, data)).acceleration("upper")[0]
    assert np.abs(found - linear - model.opt.gravity).max() > 1e-5


LOOP = f"""
<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body name="crank"><joint name="a" axis="0 1 0"/>{INERTIAL.format(1)}
      <body name="coupler" pos="0.4 0 0.3"><joint name="b" axis="0 1 0"/>{INERTIAL.format(1)}
        <site name="end" pos="1 0 0.2" quat="1 0 0 0"/></body>
    </body>
    <body name="rocker" pos="1 0 0"><joint name="c" axis="0 1 0"/>{INERTIAL.format(1)}
      <site name="eye" pos="0.4 0 0.5"/></body>
    <body name="wheel" pos="3 0 1"><joint name="d" axis="0.3 1 0.2"/>{INERTIAL.format(1)}</body>
    <body name="rack" pos="3 1 1"><joint name="e" type="slide" axis="1 0.3 0"/>{INERTIAL.format(1)}</body>
    <body name="lever" pos="3 2 1"><joint name="f" axis="1 0.3 0"/>{INERTIAL.format(1)}</body>
    <body name="stone" pos="5 2 1"><freejoint/>{INERTIAL.format(1)}</body>
  </worldbody>
  <equality>
    {{closure}}
    <weld name="glue" body1="stone" body2="wheel"/>
    <joint name="mesh" joint1="d" joint2="a" polycoef="0 -1.5 0 0 0"/>
    <joint name="teeth" joint1="e" joint2="d" polycoef="0 0.2 0 0 0"/>
    <joint name="teeth back" joint1="f" joint2="e" polycoef="0 4 0 0 0"/>
  </equality>
</mujoco>
"""
CLOSURES = (
    '<connect name="pin" body1="coupler" body2="rocker" anchor="1 0 0.2"/>',
    '<connect name="pin" site1="end" site2="eye"/>',
)


@pytest.mark.parametrize("closure", CLOSURES)
def test_loops_have_the_mobility_of_mujoco(tmp_path, closure):
    path = written(tmp_path, LOOP.replace("{closure}", closure))
    system = read_mjcf(path).system
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    J = data.efc_J.reshape(data.nefc, model.nv)
    assert system.check().mobility == model.nv - np.linalg.matrix_rank(J) == 1
    parts = {joint.name: joint for joint in system.joints}
    assert isinstance(parts["mesh"], Gear) and parts["mesh"].ratio == -1.5
    assert isinstance(parts["teeth"], RackPinion) and parts["teeth"].radius == 0.2
    assert np.abs(parts["pin"].at - parts["pin"].at_b).max() < 1e-15
    (free,) = null_space(J).T  # what MuJoCo's equalities let turn and slide
    known = {name: free[model.joint(name).dofadr[0]] for name in "abcdef"}
    found = accelerations(system, system.assemble(rates={"a": known["a"]}))
    assert {name: found.rate(name)[0] for name in known} == pytest.approx(known, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("polynomial", ["0 -1.5 0.2 0 0", "0 -1.5 0 0 0.1", "0.1 -1.5 0 0 0", "0 0 0 0 0"])
def test_couplings_that_no_gear_has_are_named(tmp_path, polynomial):
    """y = a0 + a1 x + a2 x^2 ...: a gear has a1 alone."""
    arms = "".join(f'<body name="arm {k}"><joint name="{k}" axis="1 2 2"/>{INERTIAL.format(1)}</body>' for k in "ab")
    text = f"""<mujoco><worldbody>{arms}</worldbody>
      <equality><joint name="bent" joint1="b" joint2="a" polycoef="{polynomial}"/></equality></mujoco>"""
    with pytest.raises(ValueError, match="cannot import equality: bent"):
        read_mjcf(written(tmp_path, text))


def test_a_coordinate_held_by_an_equality_is_driven(tmp_path):
    text = f"""<mujoco>
    <worldbody><body name="arm"><joint name="arm" axis="1 2 3"/>{INERTIAL.format(1)}</body></worldbody>
    <equality><joint name="held" joint1="arm" polycoef="0.1 0 0 0 0"/></equality></mujoco>"""
    found = read_mjcf(written(tmp_path, text))
    hinge, held = found.system.joints
    assert found.renamed == {"arm (joint)": "arm"} and hinge.name == "arm (joint)"
    assert isinstance(held, AngleDriver) and float(held.signal(0.0)) == 0.1


URDF = """
<robot name="arm">
  <link name="base"><inertial><mass value="4"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="upper"><inertial><origin xyz="0.1 0.2 0.3" rpy="0.2 0.1 0.4"/><mass value="2"/>
    <inertia ixx="0.3" iyy="0.4" izz="0.5" ixy="0.02" ixz="0.03" iyz="-0.01"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0.1 -0.1 0.2"/><mass value="1.5"/>
    <inertia ixx="0.2" iyy="0.3" izz="0.3" ixy="0" ixz="0.01" iyz="0"/></inertial></link>
  <link name="hand"><inertial><origin xyz="0.02 0 0.1"/><mass value="0.4"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.03" ixy="0" ixz="0.001" iyz="0"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/>
    <origin xyz="0.1 0 1" rpy="0.3 0.2 0.1"/>
    <axis xyz="0.3 1 0.2"/><dynamics damping="0.2"/></joint>
  <joint name="elbow" type="{type}"><parent link="upper"/><child link="lower"/>
    <origin xyz="0.2 0.1 0.5" rpy="0 0.4 0.2"/>
    <axis xyz="0.1 1 0.7"/><limit lower="-1" upper="1" effort="3" velocity="2"/></joint>
  <joint name="grip" type="fixed"><parent link="lower"/><child link="hand"/>
    <origin xyz="0 0.1 0.6" rpy="0.5 0 0"/></joint>
  {more}
</robot>
"""


def test_urdf_has_the_accelerations_of_mujoco(tmp_path):
    path = written(tmp_path, URDF.format(type="continuous", more=""), "arm.urdf")
    found = read_urdf(path)
    assert found.merged == {"base": "ground", "hand": "lower"}
    model = mujoco.MjModel.from_xml_path(str(path))
    data = general_motion(model)
    ours = accelerations(found.system, state_of(found.system, model, data))
    for body in found.system.bodies:
        linear, _ = spatial(mujoco.mj_objectAcceleration, model, data, body.name)
        difference = ours.acceleration(body)[0] - linear - model.opt.gravity
        assert np.abs(difference).max() < 1e-9 * (1.0 + np.abs(linear).max()), body.name  # as above


def test_a_link_without_inertial_has_no_mass(tmp_path):
    """URDF says so, https://wiki.ros.org/urdf/XML/link; MuJoCo makes 113 kg of a ball of 0.3 m."""
    more = """<link name="cover"><collision><geometry><sphere radius="0.3"/></geometry></collision></link>
      <joint name="screw" type="fixed"><parent link="upper"/><child link="cover"/></joint>"""
    path = written(tmp_path, URDF.format(type="continuous", more=more), "arm.urdf")
    with pytest.raises(ValueError, match="inertial: the 113 kg that MuJoCo makes of the shapes of cover; .*'inertial'"):
        read_urdf(path)
    system = read_urdf(path, drop="inertial").system
    assert [body.mass for body in system.bodies] == [2.0, 1.9]
    path = written(tmp_path, URDF.format(type="continuous", more=more.replace("fixed", "continuous")), "arm.urdf")
    assert [body.mass for body in read_urdf(path, drop=["inertial", "contact"]).system.bodies] == [2.0, 1.9, 0.0]
    own = '<mujoco><compiler inertiafromgeom="true"/></mujoco>'  # as the file itself wants it
    path = written(tmp_path, URDF.format(type="continuous", more=more + own), "arm.urdf")
    assert read_urdf(path).system.total_mass() == pytest.approx(3.9 + 1000.0 * 4.0 / 3.0 * np.pi * 0.3**3, rel=1e-14)


MIMIC = """<joint name="wag" type="continuous"><parent link="base"/><child link="tail"/><axis xyz="0.2 1 0.4"/>
  <mimic joint="shoulder" multiplier="-1.7" {offset}/></joint>
  <link name="tail"><inertial><origin xyz="0.2 0.1 0.1"/><mass value="0.4"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.03" ixy="0" ixz="0.001" iyz="0"/></inertial></link>"""


def test_a_mimic_is_a_gear_named_by_its_joints(tmp_path):
    path = written(tmp_path, URDF.format(type="continuous", more=MIMIC.format(offset="")), "arm.urdf")
    gear = read_urdf(path).system.joints[-1]
    assert isinstance(gear, Gear) and gear.ratio == -1.7 and gear.name == "wag by shoulder"
    path = written(tmp_path, URDF.format(type="continuous", more=MIMIC.format(offset='offset="0.3"')), "arm.urdf")
    with pytest.raises(ValueError, match="cannot import equality: wag by shoulder"):
        read_urdf(path)


def test_a_body_is_merged_into_one_of_the_system(tmp_path):
    inner = f'<body name="hand">{INERTIAL.format(1)}</body>'
    body = f'<body name="ground"><joint name="hinge"/>{INERTIAL.format(1)}{inner}</body>'
    found = read_mjcf(written(tmp_path, f"<mujoco><worldbody>{body}</worldbody></mujoco>"))
    assert found.merged == {"hand": "ground (body)"} and found.renamed == {"ground (body)": "ground"}


def test_a_model_in_which_nothing_moves_is_refused(tmp_path):
    text = f'<mujoco><worldbody><body name="post">{INERTIAL.format(1)}</body></worldbody></mujoco>'
    with pytest.raises(ValueError, match="model.xml': no body of it can move; give one a joint"):
        read_mjcf(written(tmp_path, text))


GEOMS = f"""
<mujoco>
  <worldbody>
    <geom type="plane" size="5 5 0.1" contype="0"/>
    <body name="arm" pos="0.4 -0.3 1" quat="0.7 0.3 -0.2 0.5"><joint name="hinge" axis="1 2 3"/>{INERTIAL.format(1.0)}
      <geom name="box" type="box" size="0.1 0.2 0.3" pos="0.2 0.1 -0.3" quat="0.5 0.1 0.7 -0.4" rgba="1 0 0.2 1"/>
      <geom name="ball" type="sphere" size="0.15" pos="0.7 0.1 0.3"/>
      <geom name="hidden" type="sphere" size="0.9" group="3"/>
      <body name="tool" pos="0.1 0.4 0.2" quat="0.3 0.8 0.2 -0.1">{INERTIAL.format(0.3)}
        <geom name="rod" type="capsule" size="0.05 0.3" pos="0.2 0.1 0.1" quat="0.6 0.1 0.2 -0.4"/>
        <geom name="can" type="cylinder" size="0.2 0.1" pos="-0.2 0.1 0.1" quat="0.1 0.1 0.2 -0.4"/>
        <geom name="egg" type="ellipsoid" size="0.1 0.2 0.3" pos="0.2 0.3 0.1" quat="0.6 -0.5 0.2 -0.4"/>
      </body>
    </body>
    <body name="bare" pos="3 0 0"><freejoint/>{INERTIAL.format(1.0)}</body>
  </worldbody>
</mujoco>
"""


def test_geoms_become_shapes_where_mujoco_has_them(tmp_path):
    path = written(tmp_path, GEOMS)
    arm, bare = read_mjcf(path, drop=["contact"]).system.bodies
    data = mujoco.MjData(mujoco.MjModel.from_xml_path(str(path)))
    mujoco.mj_kinematics(data.model, data)
    names = {"box": "Box", "ball": "Sphere", "rod": "Capsule", "can": "Cylinder", "egg": "Ellipsoid"}
    assert [type(shape).__name__ for shape in arm.shape] == list(names.values()) and bare.shape is None
    for name, shape in zip(names, arm.shape, strict=True):
        geom = data.geom(name)
        assert np.allclose(arm.position + arm.axes @ shape.at, geom.xpos, rtol=0, atol=1e-12), name
        assert np.allclose(arm.axes @ matrix(shape.orientation), geom.xmat.reshape(3, 3), rtol=0, atol=1e-12), name
        assert (shape.colour == "#ff0033") if name == "box" else (shape.colour is None)
    box, ball, rod, can, egg = arm.shape
    assert np.allclose([box.lengths, 2.0 * egg.radii], (0.2, 0.4, 0.6))
    assert np.allclose([ball.radius, rod.radius, rod.length, can.radius, can.length], (0.15, 0.05, 0.6, 0.2, 0.2))


@pytest.mark.parametrize(
    ("kind", "more", "message", "drop"),
    [
        ("revolute", "", "limit: range of elbow", ("limit",)),
        ("continuous", "<transmission name='t'/>", "extension: <transmission> in line", ("extension",)),
        (
            "continuous",
            "<gazebo><plugin filename='libros.so'><period>1</period></plugin></gazebo>",
            "extension: <gazebo> in line [0-9]+(?!.*extension: )",  # and nothing inside it
            ("extension",),
        ),
    ],
)
def test_urdf_names_what_it_leaves_out(tmp_path, kind, more, message, drop):
    path = written(tmp_path, URDF.format(type=kind, more=more), "arm.urdf")
    with pytest.raises(ValueError, match=f"arm.urdf': cannot import .*{message}.*drop="):
        read_urdf(path)
    assert any(re.search(message, part) for part in read_urdf(path, drop=drop).dropped)


BODY = '<body name="arm" pos="0 0 1"><joint name="hinge" axis="1 2 3" {joint}/>{more}' + INERTIAL.format(1) + "</body>"
FOREIGN = [
    ("", '<geom name="a" size="0.1"/>', '<geom name="floor" type="plane" size="1 1 1"/>', "", "contact: floor with a"),
    ('range="-1 1"', "", "", "", "limit: range of hinge"),
    ('armature="0.1"', "", "", "", "armature: hinge"),
    ('frictionloss="0.1"', "", "", "", "frictionloss: hinge"),
    ("", "", "", '<actuator><motor name="motor" joint="hinge"/></actuator>', "actuator: motor"),
    ("", "", "", '<tendon><fixed name="cord"><joint joint="hinge" coef="1"/></fixed></tendon>', "tendon: cord"),
    ("", "", "", '<option density="1.2"/>', "fluid: density 1.2"),
    ("", "", '<body name="marker" mocap="true"/>', "", "mocap: marker"),
    (
        "",
        "",
        "",
        '<equality><joint joint1="hinge" polycoef="0 0 1 0 0" active="false"/></equality>',
        "equality: .*inactive",
    ),
]


@pytest.mark.parametrize(("joint", "more", "beside", "after", "message"), FOREIGN)
def test_what_cannot_be_imported_is_named_and_dropped_on_request_only(tmp_path, joint, more, beside, after, message):
    text = f"<mujoco><worldbody>{beside}{BODY.format(joint=joint, more=more)}</worldbody>{after}</mujoco>"
    path = written(tmp_path, text)
    with pytest.raises(ValueError, match=f"model.xml': cannot import .*{message}"):
        read_mjcf(path)
    kind = message.split(":")[0]
    found = read_mjcf(path, drop=(kind,))
    assert re.search(message, found.dropped[0]) and len(found.system.joints) == 1


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ('<joint name="p" axis="1 0 0"/><joint name="q" axis="1 1 0"/>', "hinge p, hinge q of body arm"),
        ('<joint name="p" type="slide"/><joint name="q" type="slide" axis="1 0 0"/>', "slide p, slide q of body arm"),
        ('<joint name="p" type="ball" stiffness="3"/>', "passive: stiffness or damping of ball p"),
    ],
)
def test_joints_without_counterpart_are_named(tmp_path, joints, message):
    path = written(
        tmp_path, f'<mujoco><worldbody><body name="arm">{joints}{INERTIAL.format(1)}</body></worldbody></mujoco>'
    )
    with pytest.raises(ValueError, match=message):
        read_mjcf(path)


def hostile(content, root="mujoco"):
    """A model with something in it."""
    return f"<{root}>{content}<worldbody>{BODY.format(joint='', more='')}</worldbody></{root}>"


COPIES = '<worldbody><replicate count="{}"><body>' + INERTIAL.format(1) + "</body></replicate></worldbody>"
HOSTILE = {
    "absolute include": (hostile('<include file="/etc/passwd"/>'), "outside of the folder"),
    "include above": (hostile('<include file="../secret.xml"/>'), "outside of the folder"),
    "include through a link": (hostile('<include file="link/secret.xml"/>'), "leads out of the folder"),
    "include in an include through a link": (hostile('<include file="parts/a.xml"/>'), "leads out of the folder"),
    "mesh that is a link": (hostile('<asset><mesh file="x/secret.stl"/></asset>'), "leads out of the folder"),
    "many files in many folders": (
        hostile(
            "".join(f'<compiler meshdir="d{i}"/>' for i in range(5000))
            + "<asset>"
            + "".join(f'<mesh file="m{i}.stl"/>' for i in range(9000))
            + "</asset>"
        ),
        "names more than 2000 files or 10 folders",
    ),
    "mesh elsewhere": (hostile('<asset><mesh file="/tmp/a.stl"/></asset>'), "line 1: <mesh> file names"),
    "meshdir elsewhere": (hostile('<compiler meshdir="/tmp"/>'), "<compiler> meshdir names"),
    "drive": (hostile('<asset><mesh file="C:\\a.stl"/></asset>'), "outside of the folder"),
    "scheme": (hostile('<asset><mesh file="http://a/b.stl"/></asset>'), "outside of the folder"),
    "package above": (hostile('<asset><mesh file="package://../b.stl"/></asset>'), "outside of the folder"),
    "include of itself": (hostile('<include file="model.xml"/>'), "more than 100 files"),
    "second include": (hostile('<include file="part.xml"/>'), "line 1: <include> file names '/etc/passwd'"),
    "2e6 copies": (hostile(COPIES.format(2_000_000)), "<replicate> makes more than 20000 elements|<body> makes more"),
    "copies of copies": (
        hostile("<worldbody>" + '<replicate count="1000">' * 3 + "<body/>" + "</replicate>" * 3 + "</worldbody>"),
        "more than 20000",
    ),
    "copies in words": (hostile(COPIES.format("many")), "give a whole number"),
    "large composite": (hostile('<worldbody><composite count="1000 1000 1"/></worldbody>'), "more than 20000"),
    "nan": (hostile("").replace('pos="0 0 1"', 'pos="nan 0 inf"'), "position of 'arm': not finite"),
    "nan mass": (hostile("").replace('mass="1"', 'mass="nan"'), "cannot read it|not finite"),
    "entities": ('<!DOCTYPE a [<!ENTITY b "cc">]>' + hostile(""), "entity b is declared"),
    "external entity": ('<!DOCTYPE a [<!ENTITY b SYSTEM "file:///etc/passwd">]><mujoco>&b;</mujoco>', "entity b"),
    "plugin": (hostile('<extension><plugin plugin="x"/></extension>'), "asks for a plugin"),
    "deep": ("<mujoco><worldbody>" + "<body>" * 300_000, "more than 20000|no XML"),
    "no end": ("<mujoco><worldbody>", r"line 1: no XML \(no element found\)"),
    "empty": ("", "is empty"),
    "other": (hostile("", "sdf"), "its root is <sdf>, not <mujoco>"),
    "unknown element": (hostile("<nonsense/>"), "MuJoCo cannot read it: .*nonsense"),
    "memory": (hostile('<size memory="1000G"/>'), "MuJoCo cannot read it: .*memory"),
    "texture of 30 GB": (
        hostile('<asset><texture name="t" type="2d" builtin="checker" width="60000" height="60000"/></asset>'),
        "cannot read it: .*memory",
    ),
    "mesh that takes minutes": (
        hostile('<asset><mesh name="m" builtin="supertorus" params="3000 1 1 1"/></asset>'),
        "MuJoCo (takes more than|cannot read it|broke off)",
    ),
    "mesh that is missing": (hostile('<asset><mesh file="a.stl"/></asset>'), "MuJoCo cannot read it: .*a.stl"),
}


SECONDS = pytest.param("mesh that takes minutes", marks=pytest.mark.slow)  # until it is broken off


@pytest.mark.parametrize("case", [*(case for case in HOSTILE if case != SECONDS.values[0]), SECONDS])
def test_hostile_files_are_refused(tmp_path, case):
    content, message = HOSTILE[case]
    (tmp_path / "secret.xml").write_text("<mujocoinclude/>")
    folder = tmp_path / "models"
    folder.mkdir()
    (folder / "link").symlink_to(tmp_path)
    (folder / "secret.stl").symlink_to(tmp_path / "secret.xml")
    (folder / "parts").mkdir()
    (folder / "parts" / "a.xml").write_text('<mujocoinclude><include file="b.xml"/></mujocoinclude>')
    (folder / "parts" / "b.xml").symlink_to(tmp_path / "secret.xml")
    (folder / "part.xml").write_text('<mujocoinclude><include file="/etc/passwd"/></mujocoinclude>')
    with pytest.raises(ValueError, match=rf"(model|part|a).xml'(?s:.*)({message})"):
        read_mjcf(written(folder, content))


@pytest.mark.parametrize(
    "make", [lambda path: None, lambda path: path.mkdir(), lambda path: path.write_bytes(b"\xff\xfe\0")]
)
def test_what_is_no_text_is_refused(tmp_path, make):
    make(tmp_path / "model.xml")
    with pytest.raises(ValueError, match="model.xml'"):
        read_mjcf(tmp_path / "model.xml")


def test_large_files_are_not_read(tmp_path, monkeypatch):
    path = tmp_path / "model.xml"
    with path.open("wb") as handle:
        handle.truncate(200_000_000)
    monkeypatch.setattr(Path, "read_bytes", lambda path: pytest.fail(f"{path} was read"))
    with pytest.raises(ValueError, match="model.xml' has 200000000 bytes"):
        read_mjcf(path)


def test_the_clock_and_the_drop_list_are_checked(tmp_path):
    path = written(tmp_path, hostile(""))
    with pytest.raises(ValueError, match="model.xml': MuJoCo takes more than 0.001 s"):
        read_mjcf(path, timeout=1e-3)
    with pytest.raises(ValueError, match="'contacts' is not a kind of part; give some of actuator, armature, contact"):
        read_mjcf(path, drop=("contacts",))


def test_a_worker_that_breaks_off_is_reported(tmp_path, monkeypatch):
    import subprocess

    ended = subprocess.CompletedProcess([], -9, b'{"facts', b"")
    monkeypatch.setattr(subprocess, "run", lambda *args, **options: ended)
    with pytest.raises(ValueError, match=r"model.xml': MuJoCo broke off .*exit code -9"):
        read_mjcf(written(tmp_path, hostile("")))


def test_the_worker_limits_itself(tmp_path):
    import subprocess
    import sys

    path = written(tmp_path, hostile(""))
    probe = """
import resource, sys
from mbsd3d.files.importing import worker as import_worker
sys.argv = ["", sys.argv[1], "7", "mujoco"]
import_worker.main()
limits = [resource.getrlimit(kind)[0] for kind in (resource.RLIMIT_AS, resource.RLIMIT_CPU)]
open(sys.argv[1] + ".limits", "w").write(str(limits))
"""
    done = subprocess.run([sys.executable, "-c", probe, str(path)], capture_output=True, timeout=60)
    assert json.loads(done.stdout)["facts"]["bodies"][1]["name"] == "arm"
    assert (tmp_path / "model.xml.limits").read_text() == str([4 << 30, 7])


def test_files_in_the_folder_are_included(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.xml").write_text(f"<mujocoinclude>{BODY.format(joint='', more='')}</mujocoinclude>")
    text = '<mujoco><worldbody><include file="parts/arm.xml"/><camera name="eye"/></worldbody></mujoco>'
    found = read_mjcf(written(tmp_path, text))
    assert [body.name for body in found.system.bodies] == ["arm"] and found.idle == {"cam": 1}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model.xml", "parts"]  # no log beside the model
