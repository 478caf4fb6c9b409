"""End stops: closed forms of touch and rebound, stops at counted angles, slides, rest, short touches, refusals."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    Body,
    Cylindrical,
    EndStop,
    GeneralizedAlpha,
    Prismatic,
    RadauIIA,
    Revolute,
    Spherical,
    Stepper,
    System,
    Torque,
    linearize,
    measures,
    rotation,
    simulate,
)

EXACT = dict(rel=1e-8, abs=1e-9)  # of closed forms, for runs at rtol 1e-11
AXIS = np.array([1.0, -2.0, 2.0]) / 3.0


def drum(moment, rate, torque=0.0, **stop):
    """A body of a moment of inertia about a slanted hinge beside its centre of mass, with a torque and an end stop."""
    turn, com, arm = rotation((1, 2, -1), 0.8), np.array([0.2, 0.1, -0.3]), np.array([0.3, 0.1, -0.2])
    body = Body("drum", 2.0, (0.3, 0.4, 0.5), com=com, position=(0.4, 0.2, 0.1), orientation=turn)
    at = body.centre + arm
    R = Body("axes", 1.0, (1, 1, 1), orientation=turn)
    local = np.array([R.local_axis(x) for x in np.eye(3)])  # rows: world axes in body axes, so that world = local @ x
    across = arm - AXIS * (AXIS @ arm)
    own = AXIS @ local @ body.inertia @ local.T @ AXIS + 2.0 * across @ across
    share = moment / own
    body = Body("drum", 2.0 * share, share * body.inertia, com=com, position=(0.4, 0.2, 0.1), orientation=turn,
                omega=rate * AXIS)  # fmt: skip
    hinge = Revolute(GROUND, body, at=at, axis=AXIS, name="hinge")
    forces = [EndStop(hinge, name="stop", **stop)] + ([Torque(body, torque * AXIS)] if torque else [])
    return System([body], [hinge], forces, gravity=(0, 0, 0))


@pytest.mark.parametrize(("way", "turns"), [(1.0, 0.2), (-1.0, 0.3), (1.0, 7.3)])
def test_a_stop_presses_but_does_not_pull(way, turns):
    """I = 0.2, w0 = 3, k = 500, c = 4: closed forms of the damped half swing until k d + c d' = 0."""
    inertia, w0, k, c, limit = 0.2, 3.0, 500.0, 4.0, 2.0 * np.pi * turns
    ends = {"upper": limit} if way > 0 else {"lower": -limit}
    system = drum(inertia, way * w0, stiffness=k, damping=c, **ends)
    wn, z = np.sqrt(k / inertia), 0.5 * c / np.sqrt(k * inertia)
    s = np.sqrt(1.0 - z**2)
    touch = (np.pi - np.arctan2(2.0 * z * s, 1.0 - 2.0 * z**2)) / (wn * s)
    start = limit / w0
    angle, rate = measures.angle(system.joints[0]), measures.rate(system.joints[0])
    deepest = simulate(system, start + 1.0, rtol=1e-11, stop_when=rate < 0.0 if way > 0 else rate > 0.0)
    assert deepest.measure(angle)[-1] * way - limit == pytest.approx(0.045368095610298614, **EXACT)
    out = simulate(system, start + touch + 0.5, rtol=1e-11)
    assert out.rate("hinge")[-1] * way == pytest.approx(-1.7152200827543305, **EXACT)
    assert touch == pytest.approx(0.055907088814692155, rel=1e-14)
    left = out.angle("hinge")[-1] * way - limit - out.rate("hinge")[-1] * way * 0.5
    wd = wn * s  # where it leaves it is still pressed in
    gone = w0 / wd * np.exp(-z * wn * touch) * np.sin(wd * touch)
    assert left == pytest.approx(gone, abs=1e-8)
    first = simulate(system, start + 1e-7, rtol=1e-11)
    load = first.force("stop").moment[-1] @ AXIS * -way
    assert load == pytest.approx(c * w0, rel=3e-5)  # the spring adds 1.3e-5 of it within 1e-7 s
    assert out.certificate.passed
    lost = -out.work("stop")[-1]
    assert lost == pytest.approx(0.5 * inertia * (w0**2 - 1.7152200827543305**2), rel=1e-8)


def test_a_stop_at_a_counted_angle_meets_the_time_and_rate_of_free_rotation():
    system = drum(0.3, 0.0, torque=0.6, upper=21.991148575128552, stiffness=3e5, damping=0.0)
    run = simulate(system, 6.0, rtol=1e-11, stop_when=measures.angle(system.joints[0]) > 21.991148575128552)
    assert run.t[-1] == pytest.approx(4.689472099834751, **EXACT)
    assert run.rate("hinge")[-1] == pytest.approx(9.378944199669503, **EXACT)
    deepest = simulate(system, 6.0, rtol=1e-11, stop_when=measures.rate(system.joints[0]) < 0.0)
    depth = (0.6 + np.sqrt(0.6**2 + 3e5 * 0.3 * 9.378944199669503**2)) / 3e5  # k d^2 / 2 = I w^2 / 2 + T d
    assert deepest.angle("hinge")[-1] - 21.991148575128552 == pytest.approx(depth, **EXACT)


def test_a_slide_between_two_stops_agrees_with_a_reduced_equation():
    """Several impacts of a body that gravity pulls along a slanted rail, against scipy on one coordinate."""
    m, k, c, low, high = 2.3, 4e3, 25.0, -0.15, 0.4
    g = np.array([0.0, 0.0, -9.81])
    body = Body("block", m, (0.1, 0.2, 0.15), com=(0.1, -0.2, 0.3), position=(0.5, 0.2, 0.1), velocity=2.0 * AXIS)
    rail = Prismatic(GROUND, body, at=(0.3, 0.1, 0.2), axis=AXIS, name="rail")
    stop = EndStop(rail, lower=low, upper=high, stiffness=k, damping=c, name="stop")
    run = simulate(System([body], [rail], [stop], gravity=g), 1.5, rtol=1e-10, output=31)

    def rates(t, x):
        up, down = (max(k * d + c * d_dot, 0.0) if d > 0.0 else 0.0 for d, d_dot in (
            (low - x[0], -x[1]), (x[0] - high, x[1])))  # fmt: skip
        return [x[1], g @ AXIS + (up - down) / m]

    truth = solve_ivp(
        rates, (0.0, 1.5), [0.0, 2.0], method="DOP853", rtol=1e-11, atol=1e-12, max_step=1e-3, t_eval=run.t
    )
    assert np.abs(run.slide("rail") - truth.y[0]).max() < 1e-7  # edges of the touch in both, a few of them
    assert (run.slide("rail").min() < low) and run.certificate.passed
    work = run.energy().total - run.energy().work
    assert np.abs(work - work[0]).max() < 1e-8


@pytest.mark.parametrize("method", [RadauIIA(), RK4(dt=1e-4)])
def test_it_comes_to_rest_on_the_stop_where_statics_says(method):
    system = drum(0.2, 0.0, torque=1.5, upper=0.3, stiffness=400.0, damping=9.0)
    run = simulate(system, 2.0, method=method, output=3)
    assert run.angle("hinge")[-1] == pytest.approx(0.3 + 1.5 / 400.0, abs=1e-7)
    assert run.force("stop").moment[-1] @ AXIS == pytest.approx(-1.5, abs=1e-5)
    assert run.force("stop").stored[-1] == pytest.approx(0.5 * 1.5**2 / 400.0, rel=1e-4)


def test_small_motions_on_the_stop_have_its_stiffness_and_damping():
    inertia, k, c = 0.2, 400.0, 3.0
    system = drum(inertia, 0.0, torque=1.5, upper=0.3, stiffness=k, damping=c)
    rest = simulate(system, 8.0, method=RadauIIA(), rtol=1e-11, output=2).final
    roots = np.roots([inertia, c, k])
    values = linearize(system, rest).eigenvalues
    assert all(min(abs(values - root)) < 1e-6 * abs(root) for root in roots)  # the rest is left to rtol


@pytest.mark.parametrize("method", [RK4, DOP853])
@pytest.mark.parametrize("dt", [0.00031, 0.0011, 0.0043])
def test_explicit_fixed_steps_are_split_where_the_stop_is_touched(method, dt):
    """Closed form of the rebound, where the stop lets go while it is still pressed in.

    Steps keep their order, but for the place of a landing, which counts by its square, and rtol; unsplit it is 1.
    """
    inertia, w0, k, c, limit = 0.2, 3.0, 500.0, 4.0, 2.0 * np.pi * 0.2
    system = drum(inertia, w0, stiffness=k, damping=c, upper=limit)
    run = simulate(system, limit / w0 + 0.5, method=method(dt=dt))
    off = 2e-7 + (2e5 * dt**4 if method is RK4 else 0.0)  # twice the worst
    assert run.rate("hinge")[-1] == pytest.approx(-1.7152200827543305, rel=off)


def test_implicit_fixed_steps_that_a_touch_falls_into_do_not_pass():
    system = drum(0.2, 3.0, stiffness=500.0, damping=4.0, upper=0.4 * np.pi)
    coarse = simulate(system, 0.9, method=GeneralizedAlpha(dt=0.0043)).certificate
    assert not coarse["contacts"].passed and "'stop'" in coarse["contacts"].meaning
    fine = simulate(system, 0.9, method=GeneralizedAlpha(dt=0.0002)).certificate
    assert fine["contacts"].passed


def test_no_step_jumps_over_a_stop_that_is_touched_in_between():
    """A swinging pendulum whose stop is a hair below its highest point: both ends of a step may lie outside."""
    bob = Body("bob", 1.0, (0.02, 0.02, 0.02), com=(0, 0, -0.5), omega=(2.0, 0, 0))
    hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(1, 0, 0), name="hinge")
    free = simulate(System([bob], [hinge]), 3.0, rtol=1e-6, output=3001)
    top = free.angle("hinge").max()
    stop = EndStop(hinge, upper=top - 2e-4, stiffness=2e5, name="stop")
    run = simulate(System([bob], [hinge], [stop]), 30.0, rtol=1e-6, output=3001)
    peaks = run.angle("hinge").max()
    assert peaks < top - 1.2e-4  # it never gets through: v^2 I / 2 k at the limit is 3e-5 rad deep


@pytest.mark.parametrize(("share", "restitution"), [(0.511, 0.5), (0.149, 0.8)])
def test_the_damping_that_its_docstring_names_gives_the_restitution(share, restitution):
    assert f"{share} sqrt(k m)" in EndStop.__doc__
    system = drum(0.2, 3.0, upper=0.3, stiffness=500.0, damping=share * np.sqrt(500.0 * 0.2))
    out = simulate(system, 0.5, rtol=1e-9)
    assert out.rate("hinge")[-1] == pytest.approx(-3.0 * restitution, rel=1e-3)  # three digits of the share


def test_cylindrical_joints_have_both():
    body = Body("rod", 1.0, (0.1, 0.1, 0.1), velocity=(0, 0, 1.0), omega=(0, 0, 2.0))
    joint = Cylindrical(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1), name="joint")
    stops = [EndStop(joint, of="slide", upper=0.5, stiffness=1e4), EndStop(joint, upper=5.0, stiffness=1e4)]
    run = simulate(System([body], [joint], stops, gravity=(0, 0, 0)), 3.0)
    assert run.velocity("rod")[-1, 2] == pytest.approx(-1.0, abs=1e-6)
    assert run.rate("joint")[-1] == pytest.approx(-2.0, abs=1e-6)
    assert run.force(stops[0]).length is not None and run.force(stops[1]).angle is not None


def hinge_of(cls=Revolute, **more):
    body = Body("part", 1.0, (0.1, 0.1, 0.1))
    return body, cls(GROUND, body, at=(0, 0, 0), **more)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({}, "neither lower nor upper; give at least one limit"),
        ({"lower": 0.2, "upper": 0.2}, "lower = 0.2 is not below upper = 0.2; exchange them or set them apart"),
        ({"upper": 0.2, "stiffness": 0.0}, "stiffness: 0.0 is not positive"),
        ({"upper": 0.2, "damping": -1.0}, "damping: -1.0 is below 0"),
        ({"upper": np.inf}, "upper: not finite"),
        ({"upper": 0.2, "of": "slide"}, "has no slide; give a joint that has one"),
        ({"upper": 0.2, "of": "turn"}, "of 'turn' is unknown; give None or 'angle' or 'slide'"),
    ],
)
def test_what_is_no_stop_is_refused(given, text):
    _, hinge = hinge_of(axis=(0, 0, 1))
    with pytest.raises(ValueError) as error:
        EndStop(hinge, name="buffer", **({"stiffness": 1e3} | given))
    assert "force 'buffer' (EndStop)" in str(error.value) and text in str(error.value)


def test_a_joint_without_a_coordinate_is_refused():
    _, ball = hinge_of(Spherical)
    with pytest.raises(ValueError, match="has no angle and no slide; give a Revolute, Cylindrical or Prismatic"):
        EndStop(ball, upper=1.0, stiffness=1e3)


def test_a_start_from_the_reference_pose_beyond_a_limit_is_refused():
    body, hinge = hinge_of(axis=(0, 0, 1))
    system = System([body], [hinge], [EndStop(hinge, lower=0.2, upper=1.0, stiffness=1e3, name="buffer")])
    with pytest.raises(ValueError, match=r"force 'buffer' \(EndStop\): the reference pose is 0.2 beyond its limit"):
        simulate(system, 1.0)
    with pytest.raises(ValueError, match="the reference pose is 0.2 beyond its limit"):
        Stepper(system)
    turned = System([body], [hinge], [EndStop(hinge, lower=6.0, upper=7.0, stiffness=1e3)])
    around = replace(turned.state(), coordinates=np.array([2.0 * np.pi]))  # the same pose, a turn on
    assert simulate(turned, 0.1, state=around).angle(hinge)[-1] == pytest.approx(2.0 * np.pi, abs=1e-9)
    inside = system.assemble(angles={hinge: 0.5})
    assert simulate(system, 0.1, state=inside).angle(hinge)[-1] == pytest.approx(0.5, abs=1e-9)
