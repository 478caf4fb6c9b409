"""Loops that the pose of a file leaves open, welds with a turn, and key frames that do more than joints can."""

import mujoco
import numpy as np
import pytest
from helpers.mujoco_states import TOLERANCE, state_of
from helpers.refused_xml import INERTIAL

from mbsd3d import Fixed, Spherical, accelerations, read_mjcf, simulate
from mbsd3d.rotations import matrix, multiply, rotation

pytestmark = pytest.mark.filterwarnings("ignore:.*inactive:UserWarning")

ARM = f"""<body name="arm" pos="0.3 0.2 0.9" quat="0.8 0.3 -0.2 0.4">
  <joint name="hinge" axis="1 2 -1.5" pos="0.1 0 0.2"/>
  {INERTIAL.format(1.4)}{{}}</body>"""
POSE = (0.3, -0.2, 0.4, *(np.array([0.5, -0.3, 0.6, 0.4]) / np.sqrt(0.86)))


def written(folder, text):
    path = folder / "model.xml"
    path.write_text(f'<mujoco><compiler angle="radian"/><option gravity="0.7 -0.4 -9.6"/>{text}</mujoco>')
    return path


def poses(system):
    return {body.name: (body.position, matrix(body.orientation)) for body in system.bodies}


def test_a_weld_holds_the_turn_that_it_asks_for(tmp_path):
    """A free stone, welded 80 degrees and 0.5 m away from where it starts, moves as one that grows on the arm."""
    text = " ".join(map(repr, map(float, POSE)))
    weld = f'<equality><weld name="glue" body1="arm" body2="stone" relpose="{text}"/></equality>'
    stone = f'<body name="stone" pos="1 0 0"><freejoint/>{INERTIAL.format(0.6)}</body>'
    found = read_mjcf(written(tmp_path, f"<worldbody>{ARM.format('')}{stone}</worldbody>{weld}"))
    assert "loops open by" in str(found) and "joints count from the pose so found" in str(found)
    (r_a, R_a), (r_b, R_b) = poses(found.system).values()
    assert np.allclose(R_a.T @ (r_b - r_a), POSE[:3], rtol=0, atol=1e-12)
    assert np.allclose(R_a.T @ R_b, matrix(POSE[3:]), rtol=0, atol=1e-12)
    assert [type(joint) for joint in found.system.joints][-1] is Fixed and found.system.check().mobility == 1
    grown = '<body name="stone" pos="{} {} {}" quat="{} {} {} {}">'.format(*POSE) + INERTIAL.format(0.6) + "</body>"
    model = mujoco.MjModel.from_xml_path(str(written(tmp_path, f"<worldbody>{ARM.format(grown)}</worldbody>")))
    data = mujoco.MjData(model)
    data.qpos[0], data.qvel[0] = 0.7, 2.3
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    at = accelerations(found.system, state_of(found.system, model, data))
    out = np.zeros(6)
    for name in ("arm", "stone"):
        mujoco.mj_objectAcceleration(model, data, mujoco.mjtObj.mjOBJ_XBODY, model.body(name).id, out, 0)
        assert at.alpha(name)[0] == pytest.approx(out[:3], rel=TOLERANCE, abs=1e-11)
        assert at.acceleration(name)[0] == pytest.approx(out[3:] + model.opt.gravity, rel=TOLERANCE, abs=1e-10)


FOUR_BAR = f"""<worldbody>
  <body name="crank"><joint name="a" axis="0 1 0" range="-1 1"/>{INERTIAL.format(1)}
    <body name="coupler" pos="0.4 0 0.3"><joint name="b" type="ball"/>{INERTIAL.format(1)}
      <site name="end" pos="1 0.02 0.23"/></body></body>
  <body name="rocker" pos="1 0 0"><joint name="c" axis="0.1 1 0" stiffness="3" springref="0.2" ref="0.1"/>
    {INERTIAL.format(1)}<site name="eye" pos="0.4 0 0.5"/></body></worldbody>
  <equality><connect name="pin" site1="end" site2="eye"/></equality>"""


def test_open_loops_are_closed_and_said(tmp_path):
    """Points coincide; what counts from the zero of the file still does: rests, limits, key frames."""
    path = written(tmp_path, FOUR_BAR)
    found = read_mjcf(path)
    (said,) = found.said
    assert said.startswith("loops open by 0.0") and found.system.check().mobility == 2
    pin = next(joint for joint in found.system.joints if joint.name == "pin")
    assert isinstance(pin, Spherical) and np.abs(pin.at - pin.at_b).max() < 1e-12
    model = mujoco.MjModel.from_xml_path(str(path))
    data, placed = mujoco.MjData(model), poses(found.system)
    angles = {}
    mujoco.mj_kinematics(model, data)
    for name, joint in (("crank", "a"), ("rocker", "c")):
        R = placed[name][1] @ data.body(name).xmat.reshape(3, 3).T
        k = model.joint(joint).id
        w = 0.5 * np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
        angles[joint] = float(np.arcsin(w @ data.xaxis[k])) + model.qpos0[model.joint(joint).qposadr[0]]
    (limit,) = found.system.limits
    assert (limit.lower, limit.upper) == (pytest.approx(-1 - angles["a"]), pytest.approx(1 - angles["a"]))
    (spring,) = found.system.forces
    assert spring.angle == pytest.approx(0.2 - angles["c"]) and abs(angles["a"]) > 1e-4
    assert simulate(found.system, 0.2).certificate.passed


def test_key_frames_behind_a_ball_are_those_of_the_file(tmp_path):
    """A slide follows a ball on one body, which a closed loop has turned at the start."""
    text = f"""<worldbody><body name="bob" pos="0 0 1"><joint name="ball" type="ball" pos="0.1 0 0.3"/>
      <joint name="out" type="slide" axis="0.2 0.3 1"/>{INERTIAL.format(1)}</body></worldbody>
      <equality><connect name="pin" body1="bob" body2="world" anchor="0.2 0.1 -0.5"/></equality>
      <keyframe><key name="k" qpos="0.8 0.3 -0.2 0.4 0.1" qvel="0.3 0.2 -0.4 0.5"/></keyframe>"""
    moved = text.replace('anchor="0.2 0.1 -0.5"', 'relpose="0.1 -0.1 0.4 1 0 0 0" torquescale="0"').replace(
        "connect", "weld"
    )
    found = read_mjcf(written(tmp_path, moved))
    assert any("loops open by" in line for line in found.said)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "model.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    bodies = [body.name for body in found.system.bodies]
    pose = found.states["k"].q.reshape(-1, 7)[bodies.index("bob")]
    assert np.allclose(pose[:3], data.body("bob").xpos, rtol=0, atol=1e-12)
    between = found.states["k"].q.reshape(-1, 7)[bodies.index("bob after ball")]
    start = {body.name: body for body in found.system.bodies}
    parts = [pose[3:] * (1, -1, -1, -1), between[3:]]  # the slide does not turn: both have one orientation
    same = multiply(*parts)
    before = multiply(start["bob"].orientation * (1, -1, -1, -1), start["bob after ball"].orientation)
    assert np.allclose(matrix(same), matrix(before), rtol=0, atol=1e-12)
    assert np.allclose(matrix(before), matrix(rotation("z", 0.0)), rtol=0, atol=1e-12)


def test_loops_that_cannot_close_are_named(tmp_path):
    connect = '<connect name="pin" site1="end" site2="far"/>'
    text = f"""<worldbody><site name="far" pos="9 0 0"/>{ARM.format('<site name="end" pos="0.3 0.4 0.5"/>')}</worldbody>
      <equality>{connect}</equality>"""
    with pytest.raises(
        ValueError, match=r"equality 'pin' stays open by \d.* m or rad; correct its points, or the pose"
    ):
        read_mjcf(written(tmp_path, text))


def test_what_key_frames_cannot_keep_is_said(tmp_path):
    text = f"""<worldbody><body name="hand" mocap="true" pos="1 0 0"/>{ARM.format("")}</worldbody>
      <actuator><general name="slow" joint="hinge" dyntype="filter" dynprm="0.1"/></actuator>
      <keyframe><key name="home" qpos="0.5"/><key name="far" mpos="2 0 0"/><key name="busy" act="0.3"/></keyframe>"""
    found = read_mjcf(written(tmp_path, text))
    assert found.said == (
        "key frame 'far' moves mocap bodies, which stay where they are",
        "key frame 'busy' sets states of actuators, which are inactive",
    )
    assert set(found.states) == {"home", "far", "busy"}
