"""Motors and servos of imported models as inputs: the accelerations of MuJoCo under commands."""

import mujoco
import numpy as np
import pytest
from helpers.mujoco_states import TOLERANCE, accelerations_of, difference
from helpers.refused_xml import INERTIAL

from mbsd3d import StateFeedback, Stepper, System, accelerations, measures, read_mjcf, read_urdf, simulate

pytestmark = pytest.mark.filterwarnings("ignore:.*inactive:UserWarning", "ignore:.*is fixed:UserWarning")

ARM = f"""
<mujoco>
  <compiler angle="radian"/>
  <option gravity="0.7 -0.4 -9.6"/>
  <worldbody>
    <body name="base" pos="0.3 0.2 0.9" quat="0.8 0.3 -0.2 0.4"><freejoint/>{INERTIAL.format(3.1)}
      <body name="upper" pos="0.3 0.1 -0.2" quat="0.5 0.1 0.7 0.3">
        <joint name="shoulder" pos="0.05 0.02 -0.1" axis="1 2 -1.5" ref="0.3"/>{INERTIAL.format(1.4)}
        <body name="ram" pos="0.2 0.1 0.4" quat="0.9 -0.1 0.2 0.1">
          <joint name="rod" type="slide" axis="0.3 1 0.4" ref="-0.2"/>{INERTIAL.format(0.8)}
          <body name="hand" pos="0.1 0.2 0.1"><joint name="h1" pos="0.1 0 0.2" axis="1 2 3"/>
            <joint name="h2" pos="0.1 0.3 0.2" axis="3 0.4 -1"/>{INERTIAL.format(0.6)}</body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>{{}}</actuator>
</mujoco>
"""
ACTUATORS = """
  <motor name="turn" joint="shoulder" gear="-2.5"/>
  <position name="push" joint="rod" kp="30" kv="1.5" gear="1.7" ctrlrange="-1 1"/>
  <velocity name="spin" joint="h1" kv="0.7"/>
  <general name="odd" joint="h2" gainprm="2.1" biastype="affine" biasprm="0.4 -3 -0.2" gear="0.6"/>
  <motor joint="shoulder"/>
"""


COMMANDS = (3.1, -0.8, 2.2, 0.9, -1.3)


def written(folder, text, name="arm.xml"):
    path = folder / name
    path.write_text(text)
    return path


def keyed(text, seed=5):
    """The model with a key frame at a random state."""
    model, rng = mujoco.MjModel.from_xml_string(text), np.random.default_rng(seed)
    q = model.qpos0.copy()
    mujoco.mj_integratePos(model, q, rng.normal(size=model.nv), 0.4)
    values = (" ".join(repr(float(x)) for x in numbers) for numbers in (q, rng.normal(size=model.nv)))
    return text.replace(
        "</mujoco>", '<keyframe><key name="k" qpos="{}" qvel="{}"/></keyframe></mujoco>'.format(*values)
    )


def first_accelerations(found, names, commands):
    """(bodies, 6) accelerations at the key frame under commands."""
    stepper = Stepper(found.system, found.states["k"])
    for name, value in zip(found.inputs, commands, strict=True):
        stepper.set(name, value)
    stepper.advance(1e-9)
    run = stepper.solution()
    return np.array([np.concatenate([run.acceleration(name)[0], run.alpha(name)[0]]) for name in names])


def test_commands_act_as_in_mujoco(tmp_path):
    """General gears, references, gains and commands on a floating arm, two hinges of one body among them."""
    text = keyed(ARM.format(ACTUATORS))
    found = read_mjcf(written(tmp_path, text), inputs=True)
    assert found.inputs == {"turn": None, "push": (-1.0, 1.0), "spin": None, "odd": None, "actuator 4": None}
    assert found.inactive == "1 effort limit" and len(found.system.joints) == 4
    model, names = mujoco.MjModel.from_xml_string(text), ["base", "upper", "ram", "hand"]
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.ctrl[:] = COMMANDS
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    assert np.abs(data.actuator_force).min() > 0.1
    theirs = accelerations_of(found.system, model, data, names)
    ours = first_accelerations(found, names, COMMANDS)
    assert np.abs(ours - theirs).max() < TOLERANCE * np.abs(theirs).max()
    without = first_accelerations(found, names, [0.0] * 5)
    assert np.abs(without - theirs).max() > 0.01 * np.abs(theirs).max()


def test_without_inputs_actuators_give_no_force(tmp_path):
    """Not what a servo gives at command 0."""
    text = keyed(ARM.format(ACTUATORS))
    found = read_mjcf(written(tmp_path, text))
    assert (found.inputs, found.inactive) == ({}, "5 actuators")
    model, names = mujoco.MjModel.from_xml_string(text.replace(ACTUATORS, "")), ["base", "upper", "ram", "hand"]
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    mujoco.mj_rnePostConstraint(model, data)
    assert difference(found.system, found.states["k"], model, data, names) < TOLERANCE


ASKED = {
    '<motor name="m" site="tip" gear="0 0 1 0 0 0"/>': "acts on no single hinge or slide",
    '<position name="m" joint="shoulder" kp="2" timeconst="0.1"/>': "has a state of its own",
    '<muscle name="m" joint="shoulder" lengthrange="0 1"/>': "has a state of its own",
    '<damper name="m" joint="shoulder" kv="1" ctrlrange="0 1"/>': "has a gain or bias that is not that of a motor",
    '<general name="m" joint="shoulder" biastype="affine" biasprm="0 2 0"/>': "pushes away from where it is",
}


@pytest.mark.parametrize("actuator", ASKED)
def test_other_actuators_are_asked_for(tmp_path, actuator):
    tip = '<body name="hand" pos="0.1 0.2 0.1">'
    path = written(tmp_path, ARM.format(actuator).replace(tip, tip + '<site name="tip"/>'))
    message = rf"cannot import input: m {ASKED[actuator]}.* \(line \d+, <\w+>\); leave out with leave_out=\[\"input\"\]"
    with pytest.raises(ValueError, match=message):
        read_mjcf(path, inputs=True)
    found = read_mjcf(path, inputs=True, leave_out=["input"])
    assert found.inputs == {} and found.dropped[0].startswith(f"input: m {ASKED[actuator]}")
    assert read_mjcf(path).inactive == "1 actuator"
    with pytest.raises(ValueError, match="inputs"):
        read_mjcf(path, inputs="all")


ROBOT = """<robot name="arm"><link name="base"/>
  <link name="upper"><inertial><origin xyz="0.1 0.2 0.3"/><mass value="2"/>
    <inertia ixx="0.3" iyy="0.3" izz="0.2"/></inertial></link>
  <link name="ram"><inertial><origin xyz="0.1 0 0.1"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link>
  <link name="finger"><inertial><origin xyz="0 0.1 0.1"/><mass value="0.5"/>
    <inertia ixx="0.02" iyy="0.02" izz="0.02"/></inertial></link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="1 2 2"/>
    <limit lower="-1" upper="1" effort="7" velocity="2"/></joint>
  <joint name="rod" type="prismatic"><parent link="upper"/><child link="ram"/><axis xyz="0 3 4"/><origin xyz="0 0 1"/>
    <limit effort="0" velocity="2"/></joint>
  <joint name="pinch" type="continuous"><parent link="upper"/><child link="finger"/><axis xyz="1 0 0"/>
    <mimic joint="shoulder" multiplier="2"/></joint>
</robot>"""


def test_joints_of_urdf_get_a_motor_each_but_followers(tmp_path):
    """At rest they act as feedback of rates does that asks for loads of this size along the coordinates."""
    found = read_urdf(written(tmp_path, ROBOT, "arm.urdf"), inputs=True)
    system, loads = found.system, {"shoulder": 3.0, "rod": -2.0}
    assert found.inputs == {"shoulder": (-7.0, 7.0), "rod": None}
    assert {force.name for force in system.forces} == {"shoulder (actuator)", "rod (actuator)"}
    joints = {joint.name: joint for joint in system.joints}
    feedback = [
        StateFeedback(measures=[rate(joints[name])], gains=(1.0,), on=joints[name], reference=(load,))
        for name, load in loads.items()
        for rate in (measures.rate if name == "shoulder" else measures.slide_rate,)
    ]
    at = accelerations(System(system.bodies, system.joints, feedback, gravity=system.gravity))
    stepper = Stepper(system)
    for name, load in loads.items():
        stepper.set(name, load)
    stepper.advance(1e-9)
    run = stepper.solution()
    for body in ("upper", "ram", "finger"):
        assert run.acceleration(body)[0] == pytest.approx(at.acceleration(body)[0], rel=1e-12, abs=1e-12)
        assert run.alpha(body)[0] == pytest.approx(at.alpha(body)[0], rel=1e-12, abs=1e-12)
    assert np.abs(at.alpha("upper")[0] - accelerations(system).alpha("upper")[0]).max() > 0.1
    assert simulate(system, 0.1).certificate.passed
