"""Springs of ball joints and of sums of coordinates: closed forms, and refusals."""

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    Body,
    EndStop,
    Prismatic,
    Revolute,
    RotationSpring,
    Spherical,
    SumSpring,
    SumStop,
    System,
    TorsionSpring,
    accelerations,
    rotation,
    simulate,
)
from mbsd3d.rotations import conjugate, logarithm, multiply

TURN = rotation((3, -1, 2), 1.1)


@pytest.mark.parametrize("angle", [1e-9, 1e-4, 0.019, 0.021, 0.8, 3.1])
def test_the_moment_is_the_rotation_vector(angle):
    """A ball turned by a hinge that is not there: k |theta| about the axis, at every size of the angle."""
    n = np.array([2.0, -1.0, 2.0]) / 3.0
    carrier = Body("carrier", 3.0, (0.3, 0.4, 0.5), position=(0.1, 0.2, 0.3), orientation=TURN)
    head = Body("head", 2.0, (0.2, 0.3, 0.4), position=(1.0, 0.3, -0.2), orientation=rotation((0, 1, 3), 2.0))
    hinge = Revolute(carrier, head, at=(1, 0, 0), axis=n, name="hinge")
    spring = RotationSpring(carrier, head, stiffness=5.0, name="spring")
    system = System([carrier, head], [hinge], [spring], gravity=(0, 0, 0))
    load = accelerations(system, system.assemble(angles={hinge: angle}, pinned=[carrier])).force("spring")
    rounding = 2 * 4 * 1.1e-16  # of the angle: twice its half, of a product of four quaternions of length 1
    assert np.allclose(load.moment[0], -5.0 * angle * n, rtol=1e-12, atol=5.0 * rounding)
    assert np.isclose(load.stored[0], 2.5 * angle**2, rtol=1e-12, atol=5.0 * angle * rounding)


def test_an_isotropic_head_swings_as_a_sine():
    """With I about the com in the ball the rotation vector is that of an oscillator, as every axis keeps its place."""
    w0 = np.array([1.2, -0.7, 2.0])
    head = Body("head", 1.0, (0.3, 0.3, 0.3), orientation=TURN, omega=w0)
    ball = Spherical(GROUND, head, at=(0, 0, 0), name="ball")
    k, c = 4.0, 0.2
    system = System([head], [ball], [RotationSpring(GROUND, head, stiffness=k, damping=c)])
    run = simulate(system, 5.0, rtol=1e-11)
    turned = logarithm(multiply(run.orientation(head), conjugate(TURN)))
    decay = c / 2 / 0.3
    w = np.sqrt(k / 0.3 - decay**2)
    assert np.allclose(turned, np.outer(np.exp(-decay * run.t) * np.sin(w * run.t) / w, w0), rtol=0, atol=1e-8)
    assert run.certificate.passed


def chain(count):
    rng, found, joints, before = np.random.default_rng(4), [], [], GROUND
    for k in range(count):
        at = np.array([0.3 * k, 0.1, -0.2 * k])
        found.append(Body(f"link {k}", 1.0 + k, (0.1, 0.2, 0.15), com=0.1 * rng.normal(size=3), position=at))
        kind = Prismatic if k % 3 == 2 else Revolute
        joints.append(kind(before, found[-1], at=at, axis=rng.normal(size=3), name=f"joint {k}"))
        before = found[-1]
    return found, joints


def test_a_sum_of_six_joints_pulls_by_its_weights():
    """By virtual work the generalised load along each coordinate is w_i times that along the sum."""
    bodies, joints = chain(6)
    weights = np.array([0.8, -0.5, 1.2, 0.3, -0.9, 0.7])
    tendon = SumSpring(joints, weights=weights, stiffness=90.0, damping=2.0, rest=0.4, name="tendon")
    pulled = System(bodies, joints, [tendon])
    values = np.array([0.3, -0.2, 0.1, 0.5, -0.4, 0.2])
    angles = {j: x for j, x in zip(joints, values, strict=True) if isinstance(j, Revolute)}
    slides = {j: x for j, x in zip(joints, values, strict=True) if isinstance(j, Prismatic)}
    speeds = np.array([1.0, -2.0, 0.5, 0.3, 1.1, -0.7])
    rates = dict(zip(joints, speeds, strict=True))
    load = -90.0 * (weights @ values - 0.4) - 2.0 * weights @ speeds
    torques = [
        TorsionSpring(j, stiffness=1.0, angle=float(x + w * load))
        for j, x, w in zip(joints, values, weights, strict=True)
    ]
    apart = System(bodies, joints, torques)
    one = accelerations(pulled, pulled.assemble(angles, slides, rates))
    other = accelerations(apart, apart.assemble(angles, slides, rates))
    for body in bodies:
        assert np.allclose(one.alpha(body), other.alpha(body), rtol=1e-11, atol=1e-10)
    assert np.isclose(one.force("tendon").stored[0], 45.0 * (weights @ values - 0.4) ** 2)


def test_a_slack_sum_does_not_pull_and_runs_balance():
    bodies, joints = chain(3)
    tendon = SumSpring(joints, weights=(1.0, 0.5, 2.0), stiffness=300.0, rest=(-0.2, 0.3), damping=0.1, name="tendon")
    run = simulate(System(bodies, joints, [tendon]), 1.0, rtol=1e-9)
    x = run.angle(joints[0]) + 0.5 * run.angle(joints[1]) + 2.0 * run.slide(joints[2])
    off = x - np.clip(x, -0.2, 0.3)
    assert np.abs(run.force(tendon).stored - 150.0 * off**2).max() < 1e-9
    assert off.any() and not off.all() and run.certificate.passed


def test_a_stop_of_a_sum_is_that_of_its_coordinates():
    """Of w x a limit is w times that of x, and a stiffness w^2 times; of three it presses back beyond its limits."""
    runs = []
    for k in range(2):
        bodies, joints = chain(1)
        w, limits = -0.3, {"lower": -0.4, "upper": 0.2}
        stop = (
            EndStop(joints[0], **limits, stiffness=500.0, damping=3.0, name="stop")
            if k == 0
            else SumStop(joints[0], weights=[w], lower=0.2 * w, upper=-0.4 * w, stiffness=500.0 / w**2,
                         damping=3.0 / w**2, name="stop")
        )  # fmt: skip
        system = System(bodies, joints, [stop])
        runs.append(simulate(system, 1.5, state=system.assemble(rates={joints[0]: 3.0}), rtol=1e-10, output=301))
        assert runs[-1].certificate.passed
    joint = [run.system.joints[0] for run in runs]
    assert np.allclose(runs[0].angle(joint[0]), runs[1].angle(joint[1]), rtol=0, atol=1e-8)
    assert np.allclose(runs[0].force("stop").stored, runs[1].force("stop").stored, rtol=0, atol=1e-6)
    assert runs[0].force("stop").stored.any()
    bodies, joints = chain(3)
    stop = SumStop(joints, weights=(1.0, 0.5, 2.0), lower=-0.2, upper=0.3, stiffness=3e3, damping=20.0, name="stop")
    run = simulate(System(bodies, joints, [stop]), 1.0, rtol=1e-9)
    x = run.angle(joints[0]) + 0.5 * run.angle(joints[1]) + 2.0 * run.slide(joints[2])
    off = x - np.clip(x, -0.2, 0.3)
    assert np.abs(run.force(stop).stored - 1500.0 * off**2).max() < 1e-9
    assert off.any() and not off.all() and run.certificate.passed


def test_files_keep_both(tmp_path):
    bodies, joints = chain(3)
    parts = [SumSpring(joints, stiffness=3.0, rest=(-0.2, 0.3)), RotationSpring(GROUND, bodies[0], stiffness=2.0)]
    System(bodies, joints, parts).to_file(tmp_path / "model.toml")
    first, second = System.from_file(tmp_path / "model.toml").forces
    assert first.rest == (-0.2, 0.3) and len(first.joints) == 3 and second.stiffness == 2.0


def test_bad_input_is_refused():
    _, (hinge, *_) = chain(1)
    for wrong, message in (
        ({"rest": (1.0, 0.0)}, "rest = .*lower, upper"),
        ({"weights": (1.0, 2.0)}, "weights of joints"),
        ({"of": "slide"}, "has no slide"),
        ({"stiffness": -1.0}, "stiffness"),
    ):
        with pytest.raises(ValueError, match=message):
            SumSpring(hinge, **{"stiffness": 1.0} | wrong)
        if "rest" not in wrong:
            with pytest.raises(ValueError, match=message):
                SumStop(hinge, **{"stiffness": 1.0, "upper": 1.0} | wrong)
    for wrong, message in (({}, "neither lower nor upper"), ({"lower": 1.0, "upper": 0.5}, "1 is not below upper")):
        with pytest.raises(ValueError, match=message):
            SumStop(hinge, stiffness=1.0, **wrong)
    with pytest.raises(ValueError, match="no joints"):
        SumSpring((), stiffness=1.0)
    with pytest.raises(ValueError, match="itself"):
        RotationSpring(GROUND, GROUND, stiffness=1.0)
