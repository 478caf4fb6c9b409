"""Couplings of files: polynomials, fixed tendons, springs of balls and free bodies, beside MuJoCo's own terms."""

import numpy as np
import pytest
from helpers.mujoco_states import closed, difference, held_by, numbers, rigid, with_key
from helpers.refused_xml import INERTIAL
from numpy.polynomial import polynomial as poly

from mbsd3d import (
    Coupler,
    Prismatic,
    RotationSpring,
    RotationStop,
    Spherical,
    SumSpring,
    SumStop,
    read_mjcf,
    read_urdf,
    simulate,
)

mujoco = pytest.importorskip("mujoco")

TOLERANCE = 1e-11  # [1] of the largest acceleration: rounding of two formulations
ARMS = [("a", "hinge", 'ref="0.2"'), ("b", "slide", 'ref="0.1"'), ("c", "slide", ""), ("d", "hinge", "")]
"""Four bodies on joints of their own, which couplings tie."""


def arms(rules):
    bodies = "".join(
        f'<body name="l{k}" pos="{i} 0.2 0"><joint name="{k}" type="{kind}" axis="1 {i}.3 2" pos="0.1 0 {i}" {ref}/>'
        f"{INERTIAL.format(1 + i)}</body>"
        for i, (k, kind, ref) in enumerate(ARMS)
    )
    return f'<mujoco><compiler angle="radian"/><worldbody>{bodies}</worldbody>{rules}</mujoco>'


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


KINDS = ("hinge", "slide", "hinge", "ball", "hinge", "slide", "hinge")


def tree(rules="", kinds=KINDS, more="", root=""):
    """Two branches of joints on a base, which is free with ``root``; joint k stands on axes of its own."""

    def branch(numbers):
        inner = ""
        for k in reversed(numbers):
            axis = "" if kinds[k] == "ball" else f'axis="1 -0.{k} 0.{9 - k}" ref="0.{k}"'
            joint = f'<joint name="j{k}" type="{kinds[k]}" pos="0.1 0 0.0{k}" {axis} {more}/>'
            place = f'pos="0.3 0.{k} 0.1" quat="0.9 0.1 0.{k} -0.2"'
            inner = f'<body name="l{k}" {place}>{joint}{INERTIAL.format(1 + 0.3 * k)}{inner}</body>'
        return inner

    half = len(kinds) // 2
    base = f'<body name="base" pos="0.2 0.1 0.5">{root}{INERTIAL.format(3)}{branch(range(half))}' if root else ""
    rest = branch(range(half, len(kinds)))
    bodies = f"{base}{rest}</body>" if root else branch(range(half)) + rest
    return f'<mujoco><compiler angle="radian"/><worldbody>{bodies}</worldbody>{rules}</mujoco>'


LONG = ("j0", "j1", "j2", "j4", "j5", "j6")


@pytest.mark.parametrize("root", ["", '<joint type="free" name="float"/>'])
@pytest.mark.parametrize("curved", [False, True])
def test_equalities_of_many_joints_are_those_of_mujoco(tmp_path, curved, root):
    """Two tendons of six joints on two branches, tied by a line or a polynomial; a third one is held."""
    weights = {"one": (0.9, -0.4, 0.7, 0.5, -1.2, 0.8), "two": (0.3, 0.6, -0.5, 1.1, 0.4, -0.7)}
    cubic = np.array([0.07, 0.6, 0.4, -0.2, 0.1] if curved else [0.07, 0.6, 0, 0, 0])
    tendons = "".join(
        f'<fixed name="{name}">'
        + "".join(f'<joint joint="{j}" coef="{w}"/>' for j, w in zip(LONG, row, strict=True))
        + "</fixed>"
        for name, row in weights.items()
    )
    rules = f"""<tendon>{tendons}</tendon><equality>
      <tendon name="tied" tendon1="one" tendon2="two" polycoef="{numbers(cubic)}"/></equality>"""
    text = tree(rules, root=root)
    model = mujoco.MjModel.from_xml_string(text)
    places = [model.joint(name).qposadr[0] for name in LONG]

    def residual(q):
        y, x = (np.array(weights[name]) @ (q - model.qpos0)[places] for name in ("one", "two"))
        return np.array([y - poly.polyval(x, cubic)])

    rng = np.random.default_rng(12)
    for _ in range(3):
        start = closed(model, model.qpos0 + 0.4 * rng.normal(size=model.nq), rng.normal(size=model.nv), residual)
        found, state, model, data = with_key(tmp_path, text, *start)
        assert np.abs(data.efc_pos).max() < 1e-13  # MuJoCo has the equality so
        held_by(model, data, residual)
        named = [f"l{k}" for k in range(len(KINDS))]
        assert difference(found.system, state, model, data, named) < TOLERANCE
    assert found.system.check().mobility == model.nv - 1
    sums = [body for body in found.system.bodies if "sum" in body.name]
    assert sums and all(body.mass == 0.0 for body in sums)
    assert f"joints of tendons are added up by {len(sums)} bodies without mass" in found.said
    run = simulate(found.system, 0.05, state=state)
    assert run.certificate.passed, run.certificate
    assert abs(residual(qpos_of(run, model))) < 1e-9


def qpos_of(run, model):
    """Hinges and slides at the end of a run as MuJoCo counts them; other coordinates stay."""
    q = model.qpos0.copy()
    for name in LONG:
        value = run.slide(name) if model.joint(name).type[0] == mujoco.mjtJoint.mjJNT_SLIDE else run.angle(name)
        q[model.joint(name).qposadr[0]] += value[-1]
    return q


@pytest.mark.parametrize("root", ["", '<joint type="free" name="float"/>'])
@pytest.mark.parametrize("joints", [("j0", "j1"), LONG])
def test_armature_and_friction_of_tendons_are_those_of_mujoco(tmp_path, joints, root):
    """M + a J'J, and a load of the size of the friction along the tendon while it slips."""
    rng = np.random.default_rng(21)
    weights = rng.uniform(0.4, 1.2, len(joints)) * rng.choice([1, -1], len(joints))
    terms = "".join(f'<joint joint="{j}" coef="{numbers([w])}"/>' for j, w in zip(joints, weights, strict=True))
    cord = '<tendon><fixed name="cord" armature="0.7" {}>{}</fixed></tendon>'
    plain = mujoco.MjModel.from_xml_string(tree(cord.format("", terms), root=root))
    dofs = [plain.joint(name).dofadr[0] for name in joints]
    for friction in (0.0, 2.5):
        text = tree(cord.format(f'frictionloss="{friction}"' if friction else "", terms), root=root)
        q = plain.qpos0.copy()
        mujoco.mj_integratePos(plain, q, rng.normal(size=plain.nv), 0.7)
        v = rng.normal(size=plain.nv)
        v[dofs] -= weights * (weights @ v[dofs] + 1.0) / (weights @ weights)  # the tendon shortens by 1 m/s
        found, state, _, there = with_key(tmp_path, text, q, v)
        data = mujoco.MjData(plain)
        data.qpos[:], data.qvel[:], data.qfrc_applied[dofs] = there.qpos, there.qvel, friction * weights
        mujoco.mj_forward(plain, data)
        if joints == LONG:  # between branches MuJoCo leaves the armature out of M
            bare = mujoco.MjModel.from_xml_string(tree(root=root))
            its, M = mujoco.MjData(bare), np.zeros((plain.nv, plain.nv))
            its.qpos[:] = data.qpos
            mujoco.mj_forward(bare, its)
            mujoco.mj_fullM(bare, its, M)
            M[np.ix_(dofs, dofs)] += 0.7 * np.outer(weights, weights)
            data.qacc[:] = np.linalg.solve(M, data.qfrc_applied + data.qfrc_passive - data.qfrc_bias)
        mujoco.mj_rnePostConstraint(plain, data)
        assert difference(found.system, state, plain, data, [f"l{k}" for k in range(len(KINDS))]) < TOLERANCE
        run = simulate(found.system, 0.02, state=state)
        assert run.certificate.passed, run.certificate
    assert "dry friction of 1 joint yields by 0.001 rad or m at rest" in found.said
    assert (joints == LONG) == any("'cord' couples branches" in x for x in found.said)


def test_tendons_that_share_a_joint_are_tied(tmp_path):
    """Its coefficients add up, in one row."""
    rules = """<tendon><fixed name="one"><joint joint="a" coef="0.7"/><joint joint="b" coef="1"/></fixed>
      <fixed name="two"><joint joint="a" coef="0.5"/><joint joint="c" coef="2"/></fixed></tendon>
      <equality><tendon tendon1="one" tendon2="two" polycoef="0 2 0 0 0"/></equality>"""
    found, state, model, data = with_key(tmp_path, arms(rules), [0.2, 0.1, 0, 0], [2.0, 1.0, 0.1, 0.5])
    rigid(model, data, np.array([[0.7 - 1.0, 1.0, -4.0, 0.0]]), [0.0])
    state = found.system.assemble(rates={"a": 2.0, "b": 1.0, "d": 0.5})
    assert difference(found.system, state, model, data) < TOLERANCE
    (tie,) = found.system.joints[4:]
    assert isinstance(tie, Coupler) and tie.y_weights == pytest.approx((-0.3, 1.0, -4.0))


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


def test_armatures_of_balls_are_those_of_mujoco(tmp_path):
    """Balls and hinges in rows and branches on a floating base and on the ground; file out and in again."""
    bodies = f"""<body name="a" pos="0.3 0.1 -0.2" quat="0.5 0.1 0.7 0.3">
      <joint name="p" type="ball" pos="0.1 0 0" armature="0.6"/>{INERTIAL.format(1.4)}
      <body name="b" pos="-0.3 0.1 0.2" quat="0.5 0.6 0.7 0.3">
        <joint name="q" axis="2 -1 0.4" pos="0 0.1 0" armature="0.3"/>{INERTIAL.format(1.1)}
        <body name="c" pos="-0.3 0.1 0.2" quat="0.2 -0.6 0.1 0.3">
          <joint name="r" type="ball" pos="0 0.1 0" armature="1.3"/>{INERTIAL.format(0.8)}</body></body>
      <body name="d" pos="0.2 0.4 0.1"><joint name="s" type="slide" axis="1 2 3"/>
        <joint name="t" type="ball" pos="0 0.1 0.2" armature="0.2"/>{INERTIAL.format(0.5)}</body></body>"""
    base = '<body name="base" pos="0.3 0.2 0.9"><joint type="free" name="float"/>'
    rng = np.random.default_rng(5)
    for whole in (bodies, f"{base}{INERTIAL.format(3.1)}{bodies}</body>"):
        text = f"<mujoco><option gravity='0.7 -0.4 -9.6'/><worldbody>{whole}</worldbody></mujoco>"
        model = mujoco.MjModel.from_xml_string(text)
        for _ in range(3):
            qpos, data = model.qpos0.copy(), mujoco.MjData(model)
            mujoco.mj_integratePos(model, qpos, rng.normal(size=model.nv), 1.5)
            found, state, model, data = with_key(tmp_path, text, qpos, 4.0 * rng.normal(size=model.nv))
            mujoco.mj_rnePostConstraint(model, data)
            assert difference(found.system, state, model, data, ["a", "b", "c", "d"]) < 1e-12
        run = simulate(found.system, 0.2, state=state)
        assert run.certificate.passed, run.certificate
        again = read_mjcf(found.system.to_mjcf(tmp_path / "again.xml", replace=True).path).system
        balls = [
            [x.reflected_inertia for x in each.joints if isinstance(x, Spherical)] for each in (found.system, again)
        ]
        assert sorted(balls[0]) == sorted(balls[1]) == [0.2, 0.6, 1.3]


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


def test_limits_of_balls_and_tendons_become_stops(tmp_path):
    """The turn of the ball and the length of the tendon stay within their ranges, as far as MuJoCo measures them."""
    text = f"""<mujoco><compiler angle="radian"/><worldbody><body name="head" quat="0.8 0.1 0.3 -0.2">
      <joint name="neck" type="ball" range="0 0.7"/>{INERTIAL.format(1)}</body>
      <body name="one" pos="2 0 0"><joint name="a" axis="0.3 1 0.2" ref="0.2"/>{INERTIAL.format(1)}
        <body name="two" pos="0.4 0 0"><joint name="b" axis="0 1 0.3"/>{INERTIAL.format(2)}</body></body></worldbody>
      <tendon><fixed name="string" range="-0.4 0.5"><joint joint="a" coef="0.5"/><joint joint="b" coef="-1"/></fixed>
      <fixed name="seen" range="0 1"><joint joint="a" coef="1"/></fixed></tendon></mujoco>"""
    path = tmp_path / "model.xml"
    path.write_text(text)
    with pytest.warns(UserWarning, match="inactive: 3 limits$"):
        read_mjcf(path)
    found = read_mjcf(path, limits="stop")
    assert [type(force) for force in found.system.forces] == [RotationStop, SumStop, SumStop]
    assert not found.inactive and any("3 stops" in x for x in found.said)
    bare = found.system
    state = bare.assemble(near=bare.state(), rates={"a": -1.0, "b": 2.0})
    run = simulate(bare, 2.0, state=state, output=401)
    model = mujoco.MjModel.from_xml_string(text)
    data, lengths, turns = mujoco.MjData(model), [], []
    place, ball = [model.joint(x).qposadr[0] for x in "ab"], model.joint("neck").qposadr[0]
    for R, a, b in zip(run.rotation("head"), run.angle("a"), run.angle("b"), strict=True):
        data.qpos[place] = a + 0.2, b
        quat = np.zeros(4)
        mujoco.mju_mat2Quat(quat, R.ravel())
        mujoco.mju_negQuat(data.qpos[ball : ball + 4], model.body("head").quat)
        mujoco.mju_mulQuat(data.qpos[ball : ball + 4], data.qpos[ball : ball + 4].copy(), quat)
        mujoco.mj_forward(model, data)
        lengths.append(data.ten_length.copy())
        turns.append(2.0 * np.arccos(min(1.0, abs(data.qpos[ball]))))
    lengths = np.array(lengths)
    assert 0.7 < max(turns) < 0.7 + 10.0 / 300.0  # it meets its limit, at some rad/s
    assert -0.4 - 10.0 / 300.0 < lengths[:, 0].min() and lengths[:, 0].max() < 0.5 + 10.0 / 300.0
    assert lengths[:, 0].max() > 0.5 or lengths[:, 0].min() < -0.4
    assert lengths[:, 1].min() > -10.0 / 300.0 and run.certificate.passed, run.certificate
    with pytest.raises(ValueError, match="range of neck"):
        read_mjcf(path, strict=True)
    left = read_mjcf(path, limits="stop", leave_out=["limit"])
    assert not left.system.forces and len(left.dropped) == 3


def test_loads_of_balls_that_close_loops_are_named(tmp_path):
    """They count from the zero of the file, and here from where the body starts."""
    ball = f"""<body name="{{0}}" pos="{{1}} 0 0"><joint name="{{0}}" type="ball" {{2}}/>{INERTIAL.format(1)}</body>"""
    bodies = ball.format("p", 0, 'stiffness="3" range="0 0.5"') + ball.format("q", 1.2, "")
    rules = '<equality><connect body1="p" body2="q" anchor="0.5 0.1 0"/></equality>'
    text = f'<mujoco><compiler angle="radian"/><worldbody>{bodies}</worldbody>{rules}</mujoco>'
    path = tmp_path / "model.xml"
    path.write_text(text)
    assert len(read_mjcf(path, limits="stop").system.forces) == 2  # it is closed as it stands
    path.write_text(text.replace("<worldbody>", '<worldbody><site name="here" pos="0.5 0.4 0"/>').replace(
        'body1="p" body2="q" anchor="0.5 0.1 0"', 'site1="here" site2="there"').replace(
        '<joint name="p"', '<site name="there" pos="0.5 0 0.4"/><joint name="p"'))  # fmt: skip
    with pytest.raises(ValueError, match="passive: stiffness of p, which has moved to close loops"):
        read_mjcf(path, limits="stop")
    with pytest.warns(UserWarning, match="inactive: 1 limit$"):
        left = read_mjcf(path, limits="stop", leave_out=["passive"])
    assert not left.system.forces
