"""Import of MJCF and URDF: the accelerations of MuJoCo, everything left over named, hostile files refused."""

import json
import re
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest
from helpers.mujoco_states import TOLERANCE, difference, general_motion, spatial, state_of
from helpers.refused_xml import BODY, HOSTILE, INERTIAL, check_refused, hostile
from scipy.linalg import null_space

from mbsd3d import (
    AngleDriver,
    Cylindrical,
    Fixed,
    Gear,
    Planar,
    Prismatic,
    RackPinion,
    Revolute,
    Spherical,
    Universal,
    accelerations,
    read_mjcf,
    simulate,
)
from mbsd3d.extend import matrix

pytestmark = pytest.mark.filterwarnings("ignore:.*inactive:UserWarning")

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
    assert difference(system, state_of(system, model, data), model, data) < TOLERANCE


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


def test_a_coordinate_held_by_an_equality_is_driven(tmp_path):
    """It starts where it is held."""
    text = f"""<mujoco>
    <worldbody><body name="arm"><joint name="arm" axis="1 2 3"/>{INERTIAL.format(1)}</body></worldbody>
    <equality><joint name="held" joint1="arm" polycoef="0.1 0 0 0 0"/></equality></mujoco>"""
    found = read_mjcf(written(tmp_path, text))
    hinge, held = found.system.joints
    assert found.renamed == {"arm (joint)": "arm"} and hinge.name == "arm (joint)"
    assert isinstance(held, AngleDriver) and found.said == ("'arm' counts from 0.1, where it starts",)
    axis = np.array([1, 2, 3]) / np.sqrt(14)
    turned = np.concatenate([[np.cos(0.05)], np.sin(0.05) * axis])
    assert np.allclose(found.system.bodies[0].orientation, turned, rtol=0, atol=1e-15)
    assert simulate(found.system, 0.1, output=2).angle(hinge)[-1] == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("second", "message"),
    [
        (
            'joint1="b" joint2="a" polycoef="0.3 1 0 0 0"',
            "'equality 0' puts 'b' at 0.1, others put it at 0.3; take one",
        ),
        ('joint1="a" joint2="b" polycoef="0.3 0.5 0 0 0"', "puts 'b' at 1.5, others put it at 0.8; take one out"),
        ('joint1="b" polycoef="0.2 0 0 0 0"', "'equality 0' puts 'b' at 0.1, others put it at 0.2"),
        ('joint1="a" joint2="b" polycoef="-0.05 0.5 0 0 0"', None),
    ],
)
def test_equalities_that_contradict_each_other_are_refused(tmp_path, second, message):
    arms = "".join(f'<body name="arm {k}"><joint name="{k}" axis="1 2 2"/>{INERTIAL.format(1)}</body>' for k in "ab")
    text = f"""<mujoco><worldbody>{arms}</worldbody><equality>
      <joint joint1="b" joint2="a" polycoef="0.1 2 0 0 0"/><joint {second}/></equality></mujoco>"""
    if message is None:
        assert read_mjcf(written(tmp_path, text)).system.check().mobility == 1  # they say the same
        return
    with pytest.raises(ValueError, match=message):
        read_mjcf(written(tmp_path, text))


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


ALWAYS = [
    ("", "", '<tendon><fixed name="cord" damping="0 2"><joint joint="hinge" coef="1"/></fixed></tendon>',
     r"tendon: cord, which has damping \(line 1, <fixed>\)"),
    ('type="ball"', "", '<actuator><motor name="m" joint="hinge" armature="0.1"/></actuator>',
     r"armature: of m, an actuator of no single hinge or slide \(line 1, <motor>\)"),
    ("", "", '<actuator><motor name="m" joint="hinge" damping="0.1 0.2"/></actuator>',
     r"passive: damping of m, an actuator \(line 1, <motor>\)"),
    ('actuatorgravcomp="true"', '<body gravcomp="1"><geom size="0.1"/></body>', "",
     r"gravcomp: by the actuators of hinge, which are off or limited \(line 1, <joint>\)"),
    ("", "", '<option density="1.2" wind="1 0 2"/>', r"fluid: wind 1 0 2 \(line 1, <option>\)"),
    ("", '<geom name="fin" size="0.1" fluidshape="ellipsoid"/>', '<option viscosity="1.2"/>',
     r"fluid: the ellipsoid model of fin \(line 1, <geom>\)"),
]  # fmt: skip
AT_TIMES = [
    ("", '<geom name="a" size="0.1"/>', '<geom name="floor" type="plane" size="1 1 1"/>', "", "contact"),
    ('range="-1 1"', "", "", "", "1 limit (watched)"),
    ("", "", "", '<actuator><motor name="motor" joint="hinge"/></actuator>', "1 actuator"),
    ("", "", "", '<tendon><fixed name="cord" range="0 1"><joint joint="hinge" coef="1"/></fixed></tendon>', "1 limit"),
    ("", "", '<body name="marker" mocap="true"/>', "", "1 mocap body"),
    ("", "", "", '<option><flag sleep="enable"/></option>', "sleep"),
    ("", "", "", '<equality><joint joint1="hinge" polycoef="0 0 1 0 0" active="false"/></equality>',
     "1 switched-off equality"),
]  # fmt: skip


@pytest.mark.parametrize(("joint", "more", "after", "message"), ALWAYS)
def test_what_acts_always_is_refused_and_left_out_on_request_only(tmp_path, joint, more, after, message):
    path = written(tmp_path, f"<mujoco><worldbody>{BODY.format(joint=joint, more=more)}</worldbody>{after}</mujoco>")
    kind = message.split(":")[0]
    with pytest.raises(ValueError, match=f"model.xml': cannot import {message}; leave out with .*{kind}"):
        read_mjcf(path)
    for choice in ({"leave_out": (kind,)}, {"drop": kind}):
        found = read_mjcf(path, **choice)
        assert re.match(message.split(r" \(")[0], found.dropped[0]) and len(found.system.joints) == 1
        notes = accelerations(found.system).certificate.notes
        assert f"left out: {found.dropped[0]}" in notes  # every run says it


@pytest.mark.parametrize(("joint", "more", "beside", "after", "line"), AT_TIMES)
def test_what_acts_at_times_is_inactive_and_said(tmp_path, joint, more, beside, after, line):
    text = f"<mujoco><worldbody>{beside}{BODY.format(joint=joint, more=more)}</worldbody>{after}</mujoco>"
    path = written(tmp_path, text)
    with pytest.warns(UserWarning, match=re.escape(f"model.xml': inactive: {line}")) as caught:
        found = read_mjcf(path)
    assert len(caught) == 1 and caught[0].filename == __file__
    assert found.inactive == line and str(found) == f"1 joint, 1 body; inactive: {line}"
    assert f"inactive: {line}" in accelerations(found.system).certificate.notes
    with pytest.raises(ValueError, match="cannot import .*; leave out with leave_out="):
        read_mjcf(path, strict=True)


@pytest.mark.parametrize("load", ["stiffness", "damping", "frictionloss", "armature"])
def test_negative_loads_are_refused_at_their_joint(tmp_path, load):
    body = BODY.format(joint=f'{load}="-1"', more="")
    message = rf"joint 'hinge' \(line 1, <joint>\): {load.removesuffix('loss')} -1 < 0; give >= 0"
    with pytest.raises(ValueError, match=message):
        read_mjcf(written(tmp_path, f"<mujoco><worldbody>{body}</worldbody></mujoco>"))


def test_limits_are_watched_from_the_zero_of_the_file(tmp_path):
    text = f"""<mujoco><compiler angle="radian"/><worldbody><body name="arm">
      <joint name="elbow" axis="0.3 1 0.2" ref="0.5" range="-1 1.2"/>{INERTIAL.format(1)}</body></worldbody></mujoco>"""
    found = read_mjcf(written(tmp_path, text))
    (limit,) = found.system.limits
    assert (limit.lower, limit.upper) == (pytest.approx(-1.5), pytest.approx(0.7))
    start = found.system.assemble(rates={"elbow": 5.0})
    run = simulate(found.system, 0.2, state=start, output=21)
    angle = run.angle("elbow")
    worst = int(angle.argmax())
    text = f"limit of 'elbow' passed by {angle[worst] - 0.7:.3g} rad at {run.t[worst]:.4g} s"
    assert angle[worst] > 0.75 and text in run.certificate.notes


@pytest.mark.parametrize(
    ("joints", "message"),
    [
        ('<joint name="p" axis="1 0 0"/><joint name="q" axis="1 0 0"/>', "hinge p, hinge q lie so"),
        ('<joint name="p" axis="1 0 0"/><joint name="q" axis="0 1 0"/><joint name="r" axis="1 1 0"/>',
         "hinge p, hinge q, hinge r lie so at the reference pose that their motions depend on each other; leave one"),
    ],
)  # fmt: skip
def test_joints_without_counterpart_are_named(tmp_path, joints, message):
    path = written(
        tmp_path, f'<mujoco><worldbody><body name="arm">{joints}{INERTIAL.format(1)}</body></worldbody></mujoco>'
    )
    with pytest.raises(ValueError, match=message):
        read_mjcf(path)


CHAINS = f"""<mujoco><compiler angle="radian" autolimits="true"/><option gravity="0.7 -0.4 -9.6"/><worldbody>
  <body name="base" pos="0.3 0.2 0.9" quat="0.8 0.3 -0.2 0.4"><freejoint name="float"/>{INERTIAL.format(3.1)}
    <body name="a" pos="0.3 0.1 -0.2" quat="0.5 0.1 0.7 0.3" gravcomp="0.6">
      <joint name="s1" type="slide" axis="1 2 0.3" pos="0.1 0 0.2" stiffness="20" springref="0.1"/>
      <joint name="h1" axis="0.2 -1 0.6" pos="0.05 0.2 0.1" ref="0.4" damping="0.3" range="-1 2"
        armature="0.4"/>
      <joint name="b1" type="ball" pos="0.1 -0.05 0.02" damping="0.2"/>{INERTIAL.format(1.4)}
      <body name="tool" pos="0.1 0.3 0.2" quat="0.6 -0.2 0.5 0.1" gravcomp="0.3">{INERTIAL.format(0.6)}
        <site name="tip" pos="0.1 0.2 0.3" quat="0.6 0.2 0.1 0.3"/></body>
    </body>
    <body name="b" pos="-0.3 0.1 0.2" quat="0.5 0.6 0.7 0.3"><joint name="p" axis="1 0.1 0.3" pos="0.1 0 0.2"/>
      <joint name="q" axis="0.2 -1 0.6" pos="0.05 0.2 0.1" stiffness="3"/>{INERTIAL.format(1.1)}
      <body name="c" pos="-0.1 0.1 0.1"><joint name="x" type="slide" axis="1 0.1 0.3"/>
        <joint name="y" type="slide" axis="0.1 1 0.3" armature="0.7"/><joint name="z" type="slide" axis="0.1 0 1"/>
        {INERTIAL.format(0.8)}</body>
    </body>
  </body>
  <body name="d" pos="2 0 1"><joint name="yaw" axis="0.3 0.4 1" damping="0.1" pos="0.1 0.2 0"/>
    <joint name="pitch" axis="-0.8 0.6 0" stiffness="2" springref="0.4" pos="0.1 0.2 0"/>{INERTIAL.format(0.8)}</body>
  <body name="e" pos="4 0 1" quat="0.5 0.2 0.6 0.7"><joint name="free" type="free" damping="0.3"/>
    {INERTIAL.format(0.8)}</body>
</worldbody>{{keys}}</mujoco>"""


def with_keys(text, count, angle):
    """The model with key frames at random states."""
    model, rng, lines = mujoco.MjModel.from_xml_string(text.replace("{keys}", "")), np.random.default_rng(1), []
    for k in range(count):
        q = model.qpos0.copy()
        mujoco.mj_integratePos(model, q, rng.normal(size=model.nv), angle)
        values = (" ".join(repr(float(x)) for x in numbers) for numbers in (q, rng.normal(size=model.nv)))
        lines.append('<key name="k{}" time="0.5" qpos="{}" qvel="{}"/>'.format(k, *values))
    return text.replace("{keys}", f"<keyframe>{''.join(lines)}</keyframe>")


def test_joints_in_any_combination_follow_each_other(tmp_path):
    """Accelerations at key frames, several turns away; bodies without mass have their states too."""
    text = with_keys(CHAINS, 3, angle=6.0)
    found = read_mjcf(written(tmp_path, text))
    model, system = mujoco.MjModel.from_xml_string(text), found.system
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT  # inactive here
    assert system.total_mass() == pytest.approx(3.1 + 1.4 + 0.6 + 1.1 + 3 * 0.8, rel=1e-14)
    names = [model.body(i).name for i in range(1, model.nbody) if model.body(i).name != "tool"]
    assert system.check().mobility == model.nv and found.inactive == "1 limit (watched)"
    assert sorted(body.mass for body in system.bodies)[:6] == [0.0] * 6  # 2 + 1 + 2 + 1 between joints
    assert {type(joint) for joint in system.joints} == {Revolute, Prismatic, Spherical}
    for k in range(3):
        data = mujoco.MjData(model)
        mujoco.mj_resetDataKeyframe(model, data, k)
        mujoco.mj_forward(model, data)
        mujoco.mj_rnePostConstraint(model, data)
        state = found.states[f"k{k}"]
        at = accelerations(system, state)
        assert state.t == 0.5 and at.drift().position.max() < 1e-13
        assert difference(system, state, model, data, names) < TOLERANCE
        turned = {name: data.joint(name).qpos[0] - (0.4 if name == "h1" else 0.0) for name in ("h1", "p", "q", "yaw")}
        assert {name: at.angle(name)[0] for name in turned} == pytest.approx(turned, rel=1e-12)  # with their turns
    assert max(map(abs, turned.values())) > np.pi
    tip, site = found.points["tip"], data.site("tip")
    pose = dict(zip((body.name for body in system.bodies), state.q.reshape(-1, 7), strict=True))[tip.body]
    R = matrix(pose[3:])
    assert np.allclose(pose[:3] + R @ tip.position, site.xpos, rtol=0, atol=1e-13)
    assert np.allclose(R @ tip.axes, site.xmat.reshape(3, 3), rtol=0, atol=1e-13)


CUBE = '<mesh name="cube" vertex="0 0 0 1 0 0 0 1 0 0 0 1" scale="0.3 0.4 0.2"/>'
QUIET = [  # what acts beside the joints and bodies themselves, without a command
    # an actuator's armature and damping, felt by the joint with the square of the gear, off or not
    ('<actuator><orientation joint="socket" kp="0"/><motor joint="a" armature="0.3" damping="2" gear="3"/>'
     '<motor jointinparent="b" armature="0.2" damping="0.4" gear="-2"/><motor joint="a" armature="0.1"/>'
     "</actuator>", ""),
    # a fluid, on the box of the inertia of each body of the file, also of those that are welded to others
    ('<option density="80" viscosity="3"/>', ""),
    # weights are not balanced where springs and dampers are off
    ('<option><flag spring="disable" damper="disable"/></option>', ""),
    # the mass of a body that cannot move is a share of the whole
    ('<compiler settotalmass="3"/><asset><hfield name="hill" nrow="2" ncol="2" size="1 1 1 0.1"/>' + CUBE + "</asset>",
     '<body><geom type="mesh" mesh="cube"/></body><body><inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/>'
     '<geom type="hfield" hfield="hill"/></body>'),
]  # fmt: skip


@pytest.mark.parametrize(("beside", "body"), QUIET)
def test_what_acts_without_command_is_that_of_mujoco(tmp_path, beside, body):
    text = f"""<mujoco><option gravity="0.7 -0.4 -9.6"/>{beside}<worldbody>{body}
      <body name="one" quat="0.5 0.1 0.7 0.3" gravcomp="0.6"><joint name="a" axis="0.2 1 0.3" pos="0.1 0.2 0"
      armature="0.2" damping="0.3"/>{INERTIAL.format(1.3)}<body name="two" pos="0.4 0.1 -0.5">
      <joint name="b" type="slide" axis="1 0.1 -0.4"/>{INERTIAL.format(0.7)}
      <body name="tip" pos="0.1 0.2 0.1" quat="0.3 0.4 0.1 0.7">{INERTIAL.format(0.2)}</body></body></body>
      <body name="three" pos="3 0 0"><joint name="socket" type="ball"/>{INERTIAL.format(0.4)}</body></worldbody>
      {{keys}}</mujoco>"""
    text = with_keys(text, 1, angle=5.0)
    model, found = mujoco.MjModel.from_xml_string(text), read_mjcf(written(tmp_path, text))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    assert difference(found.system, found.states["k0"], model, data, ["one", "two", "three"]) < TOLERANCE


def test_a_weld_without_torque_holds_a_point(tmp_path):
    """Its mobility is that of MuJoCo's constraint matrix."""
    text = f"""<mujoco><worldbody><body name="a" pos="0.2 1 0"><freejoint/>{INERTIAL.format(1)}</body>
      <body name="b"><joint axis="1 2 3"/>{INERTIAL.format(1)}</body></worldbody>
      <equality><weld body1="a" body2="b" anchor="0.1 0.2 0.3" torquescale="{{}}"/></equality></mujoco>"""
    for scale, joint in (("0", Spherical), ("0.5", Fixed)):
        system = read_mjcf(written(tmp_path, text.format(scale))).system
        model = mujoco.MjModel.from_xml_string(text.format(scale))
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        J = data.efc_J.reshape(-1, model.nv)
        assert type(system.joints[-1]) is joint
        assert system.check().mobility == model.nv - np.linalg.matrix_rank(J)


def test_armatures_have_the_accelerations_of_published_numbers(tmp_path):
    """Two oblique links; own Newton-Euler equations by Jacobians, M + diag(armature)."""
    text = """<mujoco><compiler angle="radian"/><worldbody><body name="one">
      <joint name="a" axis="0.2 1 0.3" armature="0.3"/>
      <inertial mass="2" pos="0.1 0.05 -0.6" diaginertia="0.1 0.12 0.05"/>
      <body name="two" pos="0 0 -1"><joint name="b" axis="1 0.1 -0.4" armature="0.2"/>
      <inertial mass="1" pos="0 0.03 -0.4" diaginertia="0.05 0.05 0.01"/></body></body></worldbody></mujoco>"""
    system = read_mjcf(written(tmp_path, text)).system
    state = system.assemble(angles={"a": 0.024, "b": 0.901}, rates={"a": -2.847, "b": 3.589})
    found = accelerations(system, state)
    a, b = system.joints
    second = (found.alpha("two") - found.alpha("one"))[0] @ (found.rotation("one")[0] @ b.axis)
    assert [found.alpha("one")[0] @ a.axis, second] == pytest.approx(
        [-1.0847785860420869, -13.59055874731695], rel=1e-10
    )
    run = simulate(system, 0.5, state=state)
    assert run.certificate.passed, run.certificate


def test_a_universal_joint_with_nothing_on_its_angles_stays_one(tmp_path):
    text = CHAINS.replace('damping="0.1" pos="0.1', 'pos="0.1').replace('stiffness="2" springref="0.4" ', "")
    system = read_mjcf(written(tmp_path, text.replace("{keys}", ""))).system
    assert {joint.name for joint in system.joints if isinstance(joint, Universal)} == {"yaw-pitch"}


def test_linear_equalities_are_those_of_mujoco(tmp_path):
    """y - y0 = a0 + a1 (x - x0): the reference pose has the followers where the leaders put them."""
    arms = "".join(
        f'<body name="l{k}" pos="{i} 0 0"><joint name="{k}" type="{kind}" axis="1 {i}.3 2" {ref}/>'
        f"{INERTIAL.format(1 + i)}</body>"
        for i, (k, kind, ref) in enumerate(
            [("a", "hinge", 'ref="0.2"'), ("b", "hinge", ""), ("c", "slide", 'ref="0.1"'), ("d", "slide", "")]
        )
    )
    rules = [("b", "a", 0.3, -1.5), ("c", "b", -0.2, 0.4), ("d", "c", 0.1, -0.7)]
    lines = "".join(f'<joint joint1="{y}" joint2="{x}" polycoef="{a0} {a1} 0 0 0"/>' for y, x, a0, a1 in rules)
    text = f"""<mujoco><compiler angle="radian"/><worldbody>{arms}</worldbody><equality>{lines}</equality></mujoco>"""
    found = read_mjcf(written(tmp_path, text))
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    values, rates = {"a": 4.4}, {"a": 1.2}
    zero = {name: model.joint(name).qpos0[0] for name in "abcd"}
    for y, x, a0, a1 in rules:
        values[y] = zero[y] + a0 + a1 * (values[x] - zero[x])
        rates[y] = a1 * rates[x]
    data.qpos[:], data.qvel[:] = list(values.values()), list(rates.values())
    mujoco.mj_forward(model, data)
    assert np.abs(data.efc_pos).max() < 1e-14  # MuJoCo has the equalities so
    M, T = np.zeros((4, 4)), np.array([[rates[name] / rates["a"]] for name in "abcd"])
    mujoco.mj_fullM(model, data, M)
    data.qacc[:] = T @ np.linalg.solve(T.T @ M @ T, -T.T @ data.qfrc_bias)
    mujoco.mj_rnePostConstraint(model, data)
    system = found.system
    assert system.check().mobility == 1 and system.total_mass() == pytest.approx(1 + 2 + 3 + 4)
    state = system.assemble(angles={"a": 4.4 - 0.2}, rates={"a": 1.2})
    assert difference(system, state, model, data, [f"l{name}" for name in "abcd"]) < TOLERANCE
    assert "'b' counts from 0.3, where it starts" in found.said


def test_a_mesh_of_a_group_without_mass_is_not_needed(tmp_path):
    text = """<mujoco><compiler inertiagrouprange="3 4" discardvisual="true"/>
      <asset><mesh name="m" file="a.stl"/></asset><worldbody><body name="arm"><joint name="j"/>
      <geom type="mesh" mesh="m" group="1" contype="0" conaffinity="0"/>
      <geom size="0.2" group="3" pos="0 0 1"/></body></worldbody></mujoco>"""
    found = read_mjcf(written(tmp_path, text))
    assert found.system.total_mass() == pytest.approx(1000.0 * 4.0 / 3.0 * np.pi * 0.2**3)
    assert found.missing == ("a.stl: not found",) and found.idle == {"geom": 2}


def test_key_frames_without_end_are_not_read(tmp_path):
    text = f"<mujoco><worldbody>{BODY.format(joint='', more='')}</worldbody><keyframe>{{}}</keyframe></mujoco>"
    assert len(read_mjcf(written(tmp_path, text.format("<key/>" * 3))).states) == 3
    many = "".join(f'<body name="b{k}"><freejoint/>{INERTIAL.format(1)}</body>' for k in range(99))
    found = read_mjcf(written(tmp_path, text.format("<key/>" * 1000).replace("<worldbody>", "<worldbody>" + many)))
    assert found.states == {} and found.said == ("1000 key frames of 101 bodies are not read, as they are too many",)


def test_looks_that_are_missing_stop_nothing(tmp_path):
    """Meshes, textures, materials, height fields that are not there; a mesh is needed where it gives the mass."""
    text = """<mujoco><compiler meshdir="../meshes" texturedir="/nowhere"/>
      <asset><mesh name="m" file="a.stl"/><mesh file="b.obj" scale="1 1 2"/><texture name="t" type="2d" file="t.png"/>
      <material name="red" texture="t" rgba="1 0 0 1"/><hfield name="h" file="h.png" size="1 1 1 1"/></asset>
      <worldbody><light type="image" texture="t" pos="0 0 3"/><geom type="hfield" hfield="h"/>
      <geom type="mesh" mesh="b"/><body name="arm"><joint name="j"/>{}
      <geom type="mesh" mesh="m" material="undefined"/><geom size="0.2" pos="0 0 1" material="red"/></body></worldbody>
      </mujoco>"""
    (tmp_path / "robot").mkdir()
    path = written(tmp_path / "robot", text.format(INERTIAL.format(1)))
    found = read_mjcf(path)
    (arm,) = found.system.bodies
    assert [type(x).__name__ for x in arm.shape] == ["Sphere"] and arm.shape[0].colour == "#ff0000"
    assert set(found.missing) == {"a.stl: not found", "b.obj: not found"} and found.idle["geom"] == 4
    assert str(found) == "1 joint, 1 body; inactive: contact; 2 mesh files not drawn"
    assert read_mjcf(path, geometry="ignore").system.bodies[0].shape is None
    needed = written(tmp_path / "robot", text.format(""), "needed.xml")
    message = "needed.xml': MuJoCo cannot read it: mesh file 'a.stl' gives the mass of body 'arm' and is not found"
    with pytest.raises(ValueError, match=message):
        read_mjcf(needed)
    (tmp_path / "meshes").mkdir()
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    faces = ((1, 3, 2), (1, 2, 4), (1, 4, 3), (2, 3, 4))
    lines = [f"v {x} {y} {z}" for x, y, z in corners] + ["f {} {} {}".format(*face) for face in faces]
    (tmp_path / "meshes" / "a.obj").write_text("\n".join(lines))
    for name in (path, needed):
        name.write_text(name.read_text().replace("a.stl", "a.obj"))
    with pytest.raises(ValueError, match=message.replace("a.stl", "a.obj")):  # it lies outside of what was given
        read_mjcf(needed)
    ball = 1000.0 * 4.0 / 3.0 * np.pi * 0.2**3
    system = read_mjcf(needed, package_paths=[tmp_path / "meshes"]).system
    assert system.total_mass() == pytest.approx(1000.0 / 6.0 + ball, rel=1e-6)  # corners of MuJoCo are single precision
    drawn = read_mjcf(path, package_paths=tmp_path / "meshes").system.bodies[0].shape
    assert [type(x).__name__ for x in drawn] == ["MeshFile", "Sphere"]


@pytest.mark.parametrize("head", ["\n \n", "\ufeff"])
def test_blank_lines_and_marks_are_passed_over(tmp_path, head):
    text = f'<?xml version="1.0"?>{hostile("")}'
    assert len(read_mjcf(written(tmp_path, head + text)).system.bodies) == 1


SECONDS = pytest.param("mesh that takes minutes", marks=pytest.mark.slow)  # until it is broken off


@pytest.mark.parametrize("case", [*(case for case in HOSTILE if case != SECONDS.values[0]), SECONDS])
def test_hostile_files_are_refused(tmp_path, case):
    check_refused(tmp_path, case)


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


def test_the_guarded_process_loads_no_compiler():
    """A file takes a sixth of a second so, and a second with numba and scipy."""
    code = "import sys, mbsd3d.files.importing.worker; sys.exit(bool({'numba', 'scipy', 'trimesh'} & set(sys.modules)))"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_files_in_the_folder_are_included(tmp_path):
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.xml").write_text(f"<mujocoinclude>{BODY.format(joint='', more='')}</mujocoinclude>")
    text = '<mujoco><worldbody><include file="parts/arm.xml"/><camera name="eye"/></worldbody></mujoco>'
    found = read_mjcf(written(tmp_path, text))
    assert [body.name for body in found.system.bodies] == ["arm"] and found.idle == {"cam": 1}
    assert sorted(path.name for path in tmp_path.iterdir()) == ["model.xml", "parts"]  # no log beside the model


def test_files_in_the_folder_are_included_by_any_suffix(tmp_path):
    """MuJoCo itself knows no .mjcf."""
    inner = '<mujoco><worldbody><body name="arm"><joint name="hinge"/><geom size="0.1"/></body></worldbody></mujoco>'
    (tmp_path / "arm.xml").write_text(inner)
    (tmp_path / "model.mjcf").write_text('<mujoco><include file="arm.xml"/></mujoco>')
    assert [x.name for x in read_mjcf(tmp_path / "model.mjcf").system.joints] == ["hinge"]
