"""Bodies with an axis of symmetry: their spin is taken out of a step, and nothing else changes."""

import numpy as np
import pytest
from helpers.closed_forms.rotations import free_symmetric_body

from mbsd3d import (
    DOP853,
    GROUND,
    Body,
    GeneralizedAlpha,
    RadauIIA,
    Revolute,
    Spherical,
    SpringDamper,
    System,
    Torque,
    TorsionSpring,
    measures,
    rotation,
    simulate,
)
from mbsd3d.dynamics.spinning import rate_without_spin, restore_spin
from mbsd3d.extend import compile_system
from mbsd3d.integrators.memory import allocate_run
from mbsd3d.rotations import matrix

AXIS = np.array([2.0, -1.0, 2.0]) / 3.0
ALONG = rotation(np.cross([0, 0, 1], AXIS), np.arccos(AXIS[2]))
ROUND = matrix(ALONG) @ np.diag([0.03, 0.03, 0.05]) @ matrix(ALONG).T  # about AXIS in the body


def top(spin, **changes):
    """A top with its axis askew in its body, on a point; so fast that its weight matters little in a turn."""
    about = {"mass": 1.3, "inertia": ROUND, "com": 0.2 * AXIS, "orientation": rotation((0.3, 1, -0.4), 0.7)} | changes
    R = matrix(about["orientation"])
    body = Body("top", position=(0.1, -0.2, 0.4), omega=R @ (spin * AXIS) + (0.3, -0.2, 0.9), **about)
    return System([body], [Spherical(GROUND, body, at=(0.1, -0.2, 0.4))], gravity=(0.4, -0.3, -9.7))


def as_before(spin):
    """Steps in which no body turns far enough to be noticed."""
    return DOP853(max_step=0.09 / spin)


def differ(a, b, body):
    """Largest difference of rotation matrices, and of angular velocities over their size."""
    apart = np.abs(a.rotation(body) - b.rotation(body)).max()
    return max(apart, np.abs(a.omega(body) - b.omega(body)).max() / np.abs(a.omega(body)).max())


def test_rates_are_those_of_the_coordinates_without_spin():
    body = top(7.0).bodies[0]
    model = compile_system(System([body])).model
    rng = np.random.default_rng(3)
    run = allocate_run(np.zeros(13), 1, np.zeros(0), 4, 4, 1)
    run.spin[0], run.now["spinning"] = (0.7, -1.9, 3.1), 1
    y0, y1, y2 = rng.normal(size=(3, 13))

    def seen(tau):
        y = y0 + tau * y1 + tau**2 * y2
        restore_spin(model, run, -tau, y)
        return y

    tau, h = 0.8, 1e-5
    y, dy = y0 + tau * y1 + tau**2 * y2, y1 + 2 * tau * y2
    rate_without_spin(model, run, tau, y, dy)
    # h^2 times third derivatives
    np.testing.assert_allclose(dy, (seen(tau + h) - seen(tau - h)) / (2 * h), rtol=0, atol=1e-8)
    back = seen(tau)
    restore_spin(model, run, tau, back)
    np.testing.assert_allclose(back, y, rtol=0, atol=1e-14)
    R = [matrix(x[3:7]) for x in (y, seen(tau))]
    turn = rotation(run.spin[0], tau * np.linalg.norm(run.spin[0]))
    np.testing.assert_allclose(R[1] @ matrix(turn), R[0], rtol=0, atol=1e-14)  # e = e' o turn


def test_a_fast_top_moves_as_it_does_by_small_steps():
    run = simulate(top(240.0), 2.0, output=201, rtol=1e-10)
    known = simulate(top(240.0), 2.0, output=201, rtol=1e-10, method=as_before(240.0))
    assert run.certificate.passed
    assert differ(run, known, "top") < 1e-8  # both err by some hundred tolerances after 76 turns


@pytest.mark.parametrize(
    ("moments", "most"),
    [((0.03, 0.03, 0.05), 1000), ((0.05, 0.05, 0.02), 500), ((0.04, 0.04, 0.04), 60)],
)  # with its spin: 917 steps and more; nutation of the flat body is slower with it, of the long one without
def test_a_free_body_is_that_of_the_closed_form_between_its_steps_too(moments, most):
    R = matrix(rotation((1, 2, -1), 1.1))
    w = np.array([0.5, -0.4, 90.0])
    body = Body("disc", 2.0, moments, position=(1, 2, 3), orientation=rotation((1, 2, -1), 1.1), velocity=(1, -2, 0.5),
                omega=R @ w)  # fmt: skip
    run = simulate(System([body]), 3.0, output=97, rtol=1e-11)
    known = free_symmetric_body(run.t, moments[0], moments[2], w, body.orientation)
    assert np.abs(run.rotation(body) - known.rotation).max() < 1e-8  # 43 turns, 1e3 rtol
    assert run.certificate.steps < most


def wheel(load):
    """A wheel on an axle that is askew, driven against a load; (system, its hinge)."""
    body = Body("wheel", 4.0, ROUND, com=0.15 * AXIS, position=(0.2, 0.1, -0.3), orientation=ALONG, omega=None)
    axis = matrix(body.orientation) @ AXIS
    hinge = Revolute(GROUND, body, at=body.position, axis=axis, name="axle")
    return System([body], [hinge], load(hinge, axis)), hinge


def test_turns_of_a_wheel_that_gathers_speed_are_counted():
    system, hinge = wheel(lambda hinge, axis: [Torque(hinge.b, 5.0 * axis)])
    run = simulate(system, 8.0, output=[0.0, 0.3, 2.9, 5.0, 8.0])
    assert run.angle(hinge) == pytest.approx(0.5 * 5.0 / 0.05 * run.t**2, rel=1e-9)  # 509 turns
    braked, hinge = wheel(
        lambda hinge, axis: [Torque(hinge.b, 5.0 * axis), TorsionSpring(hinge, stiffness=0.0, damping=0.04)]
    )
    run = simulate(braked, 6.0, output=7)
    k = 0.04 / 0.05
    known = 5.0 / 0.04 * (run.t - (1.0 - np.exp(-k * run.t)) / k)
    assert run.angle(hinge) == pytest.approx(known, rel=1e-8)


def test_loads_that_change_within_a_turn_keep_their_steps():
    """A spring on the rim of a fast wheel: its energy says where the rim is."""

    def load(hinge, axis):
        body = hinge.b
        rim = body.position + 0.1 * np.cross(axis, (1, 0, 0)) / np.linalg.norm(np.cross(axis, (1, 0, 0)))
        return [SpringDamper(GROUND, body, at_a=(1, 1, 1), at_b=rim, stiffness=800.0, length=0.5)]

    system, hinge = wheel(load)
    start = system.assemble(rates={hinge: 70.0})
    run = simulate(system, 1.0, state=start, output=301, rtol=1e-9)
    known = simulate(system, 1.0, state=start, output=301, rtol=1e-9, method=as_before(70.0))
    assert run.certificate.passed
    assert differ(run, known, "wheel") < 1e-6
    assert run.certificate.steps > 50


def test_a_condition_comes_true_in_the_first_turn():
    """A point of the rim passes a height once in each turn; the step goes over several."""
    system, hinge = wheel(lambda hinge, axis: [])
    start = system.assemble(rates={hinge: 50.0})
    body, axis = system.bodies[0], matrix(ALONG) @ AXIS
    rim = body.position + 0.1 * np.cross(axis, (1, 0, 0)) / np.linalg.norm(np.cross(axis, (1, 0, 0)))
    for limit in (0.05, 0.0999):  # m of 0.1; the second for 0.09 rad only
        passed = measures.offset(GROUND, body, at_a=body.position, at_b=rim, along=np.cross(axis, rim - body.position))
        run = simulate(system, 5.0, state=start, stop_when=passed > limit)
        assert run.t[-1] == pytest.approx(np.arcsin(10 * limit) / 50.0, rel=1e-8)
        later = simulate(system, 5.0, state=start, stop_when=measures.angle(hinge) > 100.0)
        assert later.t[-1] == pytest.approx(2.0, rel=1e-9)
        assert later.certificate.steps < 40


def test_steps_as_samples_show_every_turn():
    """Where every step is a sample, steps over several turns have some within them; none is lost or written twice."""
    body = top(90.0, com=(0, 0, 0), inertia=(0.04, 0.04, 0.04)).bodies[0]
    run = simulate(System([body]), 40.0, rtol=1e-9)
    # 3600 rad, of which a step without the turn takes 0.3: rounding of the inertia decides when nutation shortens them,
    # 30 steps more for each digit it costs
    assert run.certificate.steps < 600
    turned = np.linalg.norm(body.omega) * np.diff(run.t)
    assert turned.min() > 0 and turned.max() < 1.001
    few = simulate(System([body]), 40.0, rtol=1e-9, output=run.t[::50])
    assert np.abs(few.rotation("top") - run.rotation("top")[::50]).max() < 1e-9


@pytest.mark.parametrize("method", [GeneralizedAlpha(), GeneralizedAlpha(dt=0.03), RadauIIA()], ids=str)
def test_samples_of_implicit_methods_turn_evenly_within_a_step(method):
    """An even rotation costs generalised alpha no steps: one covers a radian and more, with samples and ends inside."""
    axis, rate = matrix(ALONG) @ AXIS, 40.0
    rotor = Body(
        "rotor", 1.3, ROUND + 0.004 * np.eye(3), orientation=ALONG, omega=rate * axis, position=(0.1, 0.2, 0.3)
    )
    hinge = Revolute(GROUND, rotor, at=rotor.position, axis=axis)
    system = System([rotor], [hinge], gravity=(0, 0, 0))
    run = simulate(system, 0.6, method=method, output=101)
    np.testing.assert_allclose(run.angle(hinge), rate * run.t, rtol=0, atol=1e-9)  # Radau IIA: its error at rtol 1e-8
    turned = np.array([matrix(rotation(axis, rate * t)) @ matrix(ALONG) for t in run.t])
    np.testing.assert_allclose(run.rotation(rotor), turned, rtol=0, atol=1e-9)
    across = np.cross(axis, (1, 0, 0)) / np.linalg.norm(np.cross(axis, (1, 0, 0)))
    rim = dict(at_a=rotor.position, at_b=rotor.position + 0.1 * np.cross(across, axis))
    high = measures.offset(GROUND, rotor, **rim, along=across)
    if method.dt is None:
        stopped = simulate(system, 0.6, method=method, stop_when=high > 0.0999)
        assert stopped.t[-1] == pytest.approx(np.arcsin(0.999) / rate, rel=1e-7)
