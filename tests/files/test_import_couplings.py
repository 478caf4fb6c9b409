"""Couplings of files: polynomials, fixed tendons, springs of balls and free bodies, beside MuJoCo's own terms."""

import numpy as np
import pytest
from helpers.mujoco_states import difference
from helpers.refused_xml import INERTIAL
from numpy.polynomial import polynomial as poly

from mbsd3d import Coupler, Prismatic, RotationSpring, SumSpring, read_mjcf, read_urdf, simulate

mujoco = pytest.importorskip("mujoco")

TOLERANCE = 1e-11  # [1] of the largest acceleration: rounding of two formulations
ARMS = [("a", "hinge", 'ref="0.2"'), ("b", "slide", 'ref="0.1"'), ("c", "slide", ""), ("d", "hinge", "")]
"""Four bodies on joints of their own, which couplings tie."""


def numbers(values):
    return " ".join(repr(float(x)) for x in values)


def with_key(folder, text, qpos, qvel):
    """(imported system, its state, MuJoCo's model and data) at joint positions and velocities."""
    key = f'<keyframe><key name="k" qpos="{numbers(qpos)}" qvel="{numbers(qvel)}"/></keyframe>'
    text = text.replace("</mujoco>", f"{key}</mujoco>")
    path = folder / "model.xml"
    path.write_text(text)
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    found = read_mjcf(path)
    return found, found.states["k"], model, data


def arms(rules):
    bodies = "".join(
        f'<body name="l{k}" pos="{i} 0.2 0"><joint name="{k}" type="{kind}" axis="1 {i}.3 2" pos="0.1 0 {i}" {ref}/>'
        f"{INERTIAL.format(1 + i)}</body>"
        for i, (k, kind, ref) in enumerate(ARMS)
    )
    return f'<mujoco><compiler angle="radian"/><worldbody>{bodies}</worldbody>{rules}</mujoco>'


def rigid(model, data, J, gamma):
    """Put the accelerations of MuJoCo's own M and loads under rigid rows J qacc = gamma into the data."""
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    saddle = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
    load = data.qfrc_passive - data.qfrc_bias
    data.qacc[:] = np.linalg.solve(saddle, np.concatenate([load, gamma]))[: model.nv]
    mujoco.mj_rnePostConstraint(model, data)


RULES = [("b", "a", (0.3, -1.5, 0.2, 0.1, -0.05)), ("c", "b", (-0.2, 0.4, 0.0, 0.3)), ("d", "c", (0.1, 0.0, -0.7))]


def test_polynomials_of_the_fourth_degree_are_those_of_mujoco(tmp_path):
    """y - y0 = a0 + ... + a4 (x - x0)^4, from slide to slide too, over more than a turn."""
    lines = "".join(f'<joint joint1="{y}" joint2="{x}" polycoef="{numbers(c)}"/>' for y, x, c in RULES)
    zero, q, v, slopes = {"a": 0.2, "b": 0.1, "c": 0.0, "d": 0.0}, {"a": 3.9}, {"a": 1.2}, []
    for y, x, c in RULES:
        way = q[x] - zero[x]
        q[y] = zero[y] + poly.polyval(way, c)
        v[y] = poly.polyval(way, poly.polyder(c)) * v[x]
        slopes.append((poly.polyval(way, poly.polyder(c)), poly.polyval(way, poly.polyder(c, 2)) * v[x] ** 2))
    found, state, model, data = with_key(
        tmp_path, arms(f"<equality>{lines}</equality>"), [q[k] for k in "abcd"], [v[k] for k in "abcd"]
    )
    assert np.abs(data.efc_pos).max() < 1e-13  # MuJoCo has the equalities so
    J = np.zeros((3, 4))
    for row, (slope, _) in enumerate(slopes):
        J[row, row], J[row, row + 1] = -slope, 1.0
    rigid(model, data, J, [bend for _, bend in slopes])
    assert difference(found.system, state, model, data) < TOLERANCE
    assert [type(joint) for joint in found.system.joints[4:]] == [Coupler] * 3
    assert found.system.check().mobility == 1 and len(found.system.bodies) == 4
    assert "'b' counts from 0.4, where it starts" in found.said
    small = simulate(found.system, 0.05)
    assert small.certificate.passed


def test_two_slides_need_no_body_of_their_own(tmp_path):
    found, *_ = with_key(tmp_path, arms('<equality><joint joint1="c" joint2="b" polycoef="0 0.4 0 0 0"/></equality>'),
                         [0.2, 0.6, 0.2, 0], [0, 1, 0.4, 0])  # fmt: skip
    assert type(found.system.joints[-1]) is Coupler and len(found.system.bodies) == 4


TENDONS = """<tendon>
  <fixed name="one"><joint joint="a" coef="0.3"/><joint joint="b" coef="-1.1"/></fixed>
  <fixed name="two"><joint joint="c" coef="0.8"/></fixed>
  <fixed name="three"><joint joint="c" coef="0.5"/><joint joint="d" coef="0.25"/></fixed>
</tendon>"""


def test_fixed_tendons_hold_sums_of_joints(tmp_path):
    """L1 - L1_0 = a0 + a1 (L2 - L2_0) + ..., and L3 - L3_0 = a0 alone."""
    c, q, v = (0.1, 0.7, -0.4, 0.2), {"a": 2.2, "c": -0.4}, {"a": 0.7, "c": 1.3}
    x, x_dot = 0.8 * q["c"], 0.8 * v["c"]
    y, slope, bend = poly.polyval(x, c), poly.polyval(x, poly.polyder(c)), poly.polyval(x, poly.polyder(c, 2))
    q["b"], v["b"] = 0.1 - (y - 0.3 * (q["a"] - 0.2)) / 1.1, -(slope * x_dot - 0.3 * v["a"]) / 1.1
    q["d"], v["d"] = (0.15 - 0.5 * q["c"]) / 0.25, -0.5 * v["c"] / 0.25
    rules = (
        TENDONS
        + f"""<equality><tendon name="tied" tendon1="one" tendon2="two" polycoef="{numbers(c)}"/>
      <tendon name="held" tendon1="three" polycoef="0.15 0 0 0 0"/></equality>"""
    )
    found, state, model, data = with_key(tmp_path, arms(rules), [q[k] for k in "abcd"], [v[k] for k in "abcd"])
    assert np.abs(data.efc_pos).max() < 1e-14
    J = np.array([[0.3, -1.1, -0.8 * slope, 0.0], [0.0, 0.0, 0.5, 0.25]])
    rigid(model, data, J, [bend * x_dot**2, 0.0])
    assert difference(found.system, state, model, data) < TOLERANCE
    assert found.system.check().mobility == 2
    start = found.system.assemble()  # that of the file is open by a0
    assert simulate(found.system, 0.05, state=start).certificate.passed


def test_an_equality_of_too_many_bodies_is_named(tmp_path):
    five = (
        '<tendon><fixed name="all">' + "".join(f'<joint joint="{k}" coef="1"/>' for k in "abcd") + "</fixed></tendon>"
    )
    text = arms(five + '<equality><tendon name="sum" tendon1="all"/></equality>')
    (tmp_path / "model.xml").write_text(text)
    with pytest.raises(ValueError, match=r"equality: sum \(tendon\), between 5 bodies .*at most 4"):
        read_mjcf(tmp_path / "model.xml")


def test_springs_and_dampers_of_sums_are_those_of_mujoco(tmp_path):
    """Six joints one after the other; rest lengths given, as a range, or those of springref."""
    kinds, before, after = ["hinge", "hinge", "slide", "hinge", "slide", "hinge"], "", ""
    for k, kind in enumerate(kinds):
        before += (
            f'<body name="l{k}" pos="0.3 0.{k} 0.1"><joint name="j{k}" type="{kind}" axis="1 0.{k} {k}" ref="0.{k}" '
        )
        before += f'springref="0.{k}5"/>{INERTIAL.format(1 + k)}'
        after += "</body>"
    joints = "".join(f'<joint joint="j{k}" coef="{0.9 - 0.37 * k:.2f}"/>' for k in range(6))
    some = '<joint joint="j1" coef="0.4"/><joint joint="j4" coef="1.2"/>'
    rules = f"""<tendon><fixed name="t0" stiffness="30" damping="2">{joints}</fixed>
      <fixed name="t1" stiffness="40" springlength="0.2">{some}</fixed>
      <fixed name="t2" stiffness="50" springlength="0.1 0.4">{some}</fixed><fixed name="t3" damping="3">{some}</fixed>
      </tendon>"""
    text = f'<mujoco><compiler angle="radian"/><worldbody>{before}{after}</worldbody>{rules}</mujoco>'
    rng = np.random.default_rng(3)
    for scale in (0.3, 3.0):
        found, state, model, data = with_key(tmp_path, text, scale * rng.normal(size=6), rng.normal(size=6))
        mujoco.mj_rnePostConstraint(model, data)
        assert difference(found.system, state, model, data) < TOLERANCE
    assert [type(force) for force in found.system.forces] == [SumSpring] * 4
    assert simulate(found.system, 0.2, state=state).certificate.passed


def test_springs_of_balls_and_free_bodies_are_those_of_mujoco(tmp_path):
    """-k times the rotation vector up to half a turn; a free joint is held at the body's origin as well."""
    text = f"""<mujoco><compiler angle="radian"/><worldbody>
      <body name="base" pos="0.3 0.2 0.9" quat="0.8 0.3 -0.2 0.4">
        <joint type="free" name="float" stiffness="7" damping="0.4"/>{INERTIAL.format(3.1)}
        <body name="a" pos="0.3 0.1 -0.2" quat="0.5 0.1 0.7 0.3"><joint name="h" axis="1 2 3" pos="0.1 0 0"/>
          <joint name="s" type="ball" pos="0.1 -0.05 0.02" stiffness="3" damping="0.2"/>{INERTIAL.format(1.4)}
          <body name="b" pos="-0.3 0.1 0.2" quat="0.5 0.6 0.7 0.3">
            <joint name="t" type="ball" stiffness="2"/>{INERTIAL.format(1.1)}</body>
        </body></body></worldbody></mujoco>"""
    rng = np.random.default_rng(8)
    for _ in range(4):
        qpos = rng.normal(size=16)
        for k in (3, 8, 12):
            qpos[k : k + 4] /= np.linalg.norm(qpos[k : k + 4])
        found, state, model, data = with_key(tmp_path, text, qpos, rng.normal(size=13))
        mujoco.mj_rnePostConstraint(model, data)
        assert difference(found.system, state, model, data, ["base", "a", "b"]) < TOLERANCE
    assert sum(isinstance(force, RotationSpring) for force in found.system.forces) == 3


def test_armatures_on_moving_parents_are_those_of_mujoco(tmp_path):
    """Two oblique hinges on a floating base, a slide, joints on one axis; the base has an armature of its own."""
    text = f"""<mujoco><compiler angle="radian"/><option gravity="0.7 -0.4 -9.6"/><worldbody>
      <body name="base" pos="0.3 0.2 0.9" quat="0.8 0.3 -0.2 0.4">
        <joint type="free" name="float" armature="{{}}"/>{INERTIAL.format(3.1)}
        <body name="a" pos="0.3 0.1 -0.2" quat="0.5 0.1 0.7 0.3">
          <joint name="p" axis="1 2 3" pos="0.1 0 0" armature="0.6"/>{INERTIAL.format(1.4)}
          <body name="b" pos="-0.3 0.1 0.2" quat="0.5 0.6 0.7 0.3">
            <joint name="q" axis="2 -1 0.4" pos="0 0.1 0" armature="0.3"/>{INERTIAL.format(1.1)}</body>
        </body>
        <body name="c" pos="-0.3 0.1 0.2"><joint name="r" type="slide" axis="0.1 1 0.3" armature="2.5"/>
          <joint name="s" axis="0.1 1 0.3" armature="0.2"/>{INERTIAL.format(0.7)}</body>
      </body></worldbody></mujoco>"""
    rng = np.random.default_rng(5)
    for own in (0, 0.8):
        for _ in range(3):
            qpos = rng.normal(size=11)
            qpos[3:7] /= np.linalg.norm(qpos[3:7])
            given = with_key(tmp_path, text.format(own), qpos, 4.0 * rng.normal(size=10))
            found, state, model, data = given
            mujoco.mj_rnePostConstraint(model, data)
            assert difference(found.system, state, model, data, ["base", "a", "b", "c"]) < 1e-12
        run = simulate(found.system, 0.2, state=state)
        assert run.certificate.passed, run.certificate


def test_mimics_of_slides_with_an_offset(tmp_path):
    """Two fingers: the second one starts at its offset and moves by its multiplier."""
    link = '<link name="{}"><inertial><mass value="{}"/><inertia ixx="0.1" iyy="0.1" izz="0.1"/></inertial></link>'
    joint = '<joint name="{0}" type="prismatic"><parent link="base"/><child link="{1}"/><axis xyz="{2}"/>{3}</joint>'
    text = "<robot name='hand'>" + link.format("base", 3) + link.format("left", 1) + link.format("right", 2)
    text += joint.format("one", "left", "0 0 -1", "") + joint.format(
        "two", "right", "1 0 0", '<mimic joint="one" multiplier="-0.5" offset="0.2"/>'
    )
    (tmp_path / "hand.urdf").write_text(text + "</robot>")
    found = read_urdf(tmp_path / "hand.urdf", floating=False)
    coupler = found.system.joints[-1]
    assert isinstance(coupler, Coupler) and isinstance(found.system.joints[1], Prismatic)
    run = simulate(found.system, 0.6)
    assert run.position("right")[0] == pytest.approx([0.2, 0, 0])
    assert run.slide("one")[-1] == pytest.approx(0.5 * 9.81 / (1 + 2 * 0.25) * 0.36, rel=1e-8)
    assert np.allclose(run.slide("two"), -0.5 * run.slide("one"), rtol=0, atol=1e-13)


LIMITED = f"""<mujoco><compiler angle="radian"/><worldbody><body name="arm">
  <joint name="elbow" axis="0.3 1 0.2" ref="0.5" range="-1 1.2"/>{INERTIAL.format(1)}</body>
  <body name="ram" pos="2 0 0"><joint name="rail" type="slide" axis="0 0 1" range="-0.4 0.4"/>{INERTIAL.format(2)}
  </body>
  </worldbody></mujoco>"""


def test_limits_become_stops(tmp_path):
    """The ram falls onto its stop and rests there, sunk in by g / rate^2; the arm does not pass its limit."""
    path = tmp_path / "model.xml"
    path.write_text(LIMITED)
    found = read_mjcf(path, limits="stop")
    assert not found.system.limits and not found.inactive and any("2 stops" in x for x in found.said)
    run = simulate(found.system, 3.0, state=found.system.assemble(rates={"elbow": 5.0}), output=601)
    assert run.angle("elbow").max() > 0.69 and run.angle("elbow").max() < 0.7 + 10.0 / 300.0
    assert run.slide("rail")[-1] == pytest.approx(-0.4 - 9.81 / 300.0**2, rel=1e-9)
    assert run.slide("rail").min() > -0.4 - 3.0 / 300.0 and run.certificate.passed
    with pytest.warns(UserWarning, match="2 limits"):
        watched = read_mjcf(path)
    assert len(watched.system.limits) == 2
    with pytest.raises(ValueError, match="limits"):
        read_mjcf(path, limits="hard")
