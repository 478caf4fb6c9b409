"""Runs in slices: against one run, closed forms, a sampled controller from its matrices; inputs in files; errors."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.models import direction, random_body
from scipy.linalg import expm

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AngleDriver,
    Body,
    CustomForce,
    Force,
    GeneralizedAlpha,
    Input,
    IntegrationError,
    Kinematic,
    Prismatic,
    RadauIIA,
    Ramp,
    Revolute,
    Sine,
    SpeedDriver,
    Spherical,
    SpringDamper,
    Stepper,
    System,
    Table,
    Torque,
    accelerations,
    load,
    measures,
    simulate,
)


def double_pendulum(*forces, seed=3):
    """Two bodies in general position on a ball joint and a hinge, with a Solution's handles."""
    rng = np.random.default_rng(seed)
    upper, lower = random_body(rng, "upper"), random_body(rng, "lower")
    at, elbow = rng.normal(size=3), rng.normal(size=3)
    joints = [Spherical(GROUND, upper, at=at), Revolute(upper, lower, at=elbow, axis=direction(rng), name="elbow")]
    return System([upper, lower], joints, [force(upper, lower) for force in forces])


def rotor(*signals, axis=(1.0, -2.0, 0.5)):
    """A rotor on a hinge along a general axis through its centre of mass, with torques along it."""
    n = np.array(axis) / np.linalg.norm(axis)
    body = Body("rotor", 2.0, (0.3, 0.5, 0.4), com=(0.1, 0.2, -0.1))
    hinge = Revolute(GROUND, body, at=body.centre, axis=n, name="hinge")
    forces = [Torque(body, tuple(float(x) * signal for x in n)) for signal in signals]
    return System([body], [hinge], forces, gravity=(0, 0, 0)), hinge, float(n @ np.diag((0.3, 0.5, 0.4)) @ n)


def test_own_states_are_those_of_the_force():
    def lagging(t, bodies, z, parameters, loads, z_dot):
        z_dot[0], z_dot[1] = 0.3 - z[0], z[0]

    system = double_pendulum(lambda a, b: CustomForce(lagging, on=(a, b), states=(0.7, 1.1), name="lag"))
    stepper = Stepper(system)
    stepper.advance(0.2)
    slow = 0.3 + 0.4 * np.exp(-0.2)
    assert stepper.z == pytest.approx([slow, 1.1 + 0.3 * 0.2 + 0.4 * (1 - np.exp(-0.2))], abs=1e-7)  # rtol 1e-8
    assert np.array_equal(stepper.z, stepper.state.z[:2])


@pytest.mark.parametrize(
    ("method", "rtol", "limit"),
    [
        (DOP853(), 1e-10, 1e-7),  # errors of two runs of other steps
        (RK4(1e-3), 1e-8, 1e-13),  # the slices are whole numbers of steps: the same run but for rounding
        (GeneralizedAlpha(dt=1e-3), 1e-8, 1e-8),  # the same, to what Newton's method leaves
    ],
)
def test_slices_are_one_run(method, rtol, limit):
    system = double_pendulum()
    whole = simulate(system, 0.7, method=method, rtol=rtol)
    stepper = Stepper(system, method=method, rtol=rtol)
    for t in (0.05, 0.1, 0.103, 0.4, 0.7):
        stepper.advance(t)
    assert stepper.t == 0.7
    assert np.abs(stepper.q - whole.final.q).max() < limit
    assert np.abs(stepper.v - whole.final.v).max() < 10 * limit
    assert np.array_equal(stepper.state.q, stepper.solution().final.q)


def test_fixed_steps_land_on_every_slice():
    stepper = Stepper(double_pendulum(), method=RK4(0.01))
    for t in (0.1, 0.125, 0.126):  # 10, 3 and 1 steps
        stepper.advance(t)
    assert stepper.solution().certificate.steps == 14


def test_driven_poses_follow_from_slice_to_slice():
    body = Body("arm", 2.0, (0.1, 0.2, 0.15), com=(0.3, 0.1, 0))
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(1, 2, 2), name="hinge")
    system = System([body], [hinge, AngleDriver(hinge, Ramp(3.0) + Sine(0.2, 1.0))])
    stepper = Stepper(system, method=Kinematic(), measures=[measures.angle(hinge), measures.rate(hinge)])
    for t in (0.4, 1.7, 4.0):
        stepper.advance(t)
    rate = 3.0 + 0.4 * np.pi * np.cos(8 * np.pi)
    assert stepper.measured == pytest.approx([12.0 + 0.2 * np.sin(8 * np.pi), rate], abs=1e-11)
    assert stepper.solution().t.tolist() == [0.0, 0.4, 1.7, 4.0]


def test_driven_poses_need_drivers_for_every_freedom():
    with pytest.raises(ValueError, match="Kinematic: 1 of 6 degrees of freedom are not determined"):
        Stepper(rotor(0.5)[0], method=Kinematic())


def test_inputs_hold_until_they_change():
    """Torque 2 u + 1: the angle is a parabola in each slice; two terms of one name change together."""
    push = Input("push", 0.25)
    system, hinge, inertia = rotor(2.0 * push + 1.0, 0.5 * Input("push", 0.25))
    seen = [measures.angle(hinge), measures.rate(hinge)]
    stepper = Stepper(system, measures=seen)
    angle, rate, t = 0.0, 0.0, 0.0
    for value, end in ((None, 0.3), (-1.7, 0.9), (None, 1.0), (0.6, 2.0)):
        if value is not None:
            stepper.set(push, 99.0)  # the last one at a time counts
            stepper.set("push", value)
        alpha, h = (2.5 * stepper.inputs["push"] + 1.0) / inertia, end - t
        angle, rate, t = angle + rate * h + 0.5 * alpha * h * h, rate + alpha * h, end
        stepper.advance(end)
        assert stepper.measured == pytest.approx([angle, rate], rel=1e-10, abs=1e-10)
    assert stepper.inputs == {"push": 0.6}


def test_simulate_keeps_the_first_value():
    system, hinge, inertia = rotor(Input("push", 0.8))
    assert simulate(system, 1.0).angle(hinge)[-1] == pytest.approx(0.4 / inertia, rel=1e-8)  # rtol


def test_a_sampled_controller_is_its_matrix():
    """u = -K x held for a period T: x' = (Ad - Bd K) x, from the matrix exponential."""
    system, hinge, inertia = rotor(Input("torque"))
    period, gains = 0.05, np.array([1.3, 0.7])
    block = expm(np.array([[0, 1, 0], [0, 0, 1 / inertia], [0, 0, 0]]) * period)
    closed = block[:2, :2] - np.outer(block[:2, 2], gains)
    stepper = Stepper(
        system, system.assemble(angles={hinge: 0.4}), measures=[measures.angle(hinge), measures.rate(hinge)]
    )
    for k in range(40):
        stepper.set("torque", -gains @ stepper.measured)
        stepper.advance((k + 1) * period)
    assert stepper.measured == pytest.approx(np.linalg.matrix_power(closed, 40) @ (0.4, 0.0), abs=1e-10)


@pytest.mark.parametrize(
    ("method", "error"),  # turns by quaternions at 0.02 s; trapezoids of the third
    [(None, 1e-10), (RK4(0.02), 1e-9), (GeneralizedAlpha(dt=0.001), 1e-6), (RadauIIA(), 1e-10)],
    ids=str,
)
def test_a_slope_is_a_ramp(method, error):
    """phi = phi0 + w t + (a t^2 / 2 + b t^3 / 6) / I over three pieces, one of which holds; also in the record."""
    system, hinge, inertia = rotor(Input("torque"))
    stepper = Stepper(system, measures=[measures.angle(hinge), measures.rate(hinge)], method=method)
    x = np.array([0.0, 0.0])
    for k, course in enumerate([(1.0, 3.0), (-2.0, -1.5), (0.5,)]):
        stepper.set("torque", *course)
        stepper.advance(0.4 * (k + 1))
        a, b = (*course, 0.0)[:2]
        x = np.array([x[0] + 0.4 * x[1], x[1]]) + np.array([0.08 * a + 0.064 / 6 * b, 0.4 * a + 0.08 * b]) / inertia
        assert stepper.measured == pytest.approx(x, abs=error)
        assert stepper.inputs["torque"] == pytest.approx(a + 0.4 * b, abs=1e-14)
    solution = stepper.solution()
    assert solution.certificate.passed, solution.certificate
    assert solution.record.inputs["torque"] == ((0.0, 1.0, 3.0), (0.4, -2.0, -1.5), (0.8, 0.5))
    assert np.linalg.norm(solution.at(0.2).v[3:6]) == pytest.approx((0.2 + 3.0 * 0.02) / inertia, abs=10 * error)
    assert solution.again().final.q == pytest.approx(solution.final.q, abs=1e-12)


def on_rail(mass, stiffness, damping, pull, x):
    """A mass on a rail at x, between the ground by a spring (slack at 0) and a damper, and a pull: as a stepper."""
    body = Body("mass", mass, (0.1, 0.1, 0.1), position=(x, 0, 0), velocity=(0, 0, 0), omega=(0, 0, 0))
    rail = Prismatic(GROUND, body, at=(x, 0, 0), axis=(1, 0, 0))
    spring = SpringDamper(
        GROUND, body, at_a=(-9.0, 0, 0), at_b=(x, 0, 0), stiffness=stiffness, damping=damping, length=9.0
    )
    system = System([body], [rail], [spring, Force(body, (pull, 0, 0))])
    return Stepper(system, measures=[measures.position(body, axis=(1, 0, 0)), measures.slide_rate(rail)], rtol=1e-11)


@pytest.mark.parametrize(
    ("way", "known"),
    [
        ("jacobi, held", (4.242890839092758, 1.8848276206083767, 0.8930847955708479, 0.4355813662592545)),
        ("jacobi, extrapolated", (0.4018650553299806, 0.08926780941709278, 0.020282102467925056, 0.00476640081226809)),
        ("gauss-seidel, held", (2.662683630146308, 1.2755781392755168, 0.6243247536595327, 0.30887516360853695)),
    ],
)
def test_two_models_that_set_inputs_of_each_other(way, known):
    """Force to the first, position and speed to the second; errors at 1 s as by matrix exponentials of both halves."""
    m1, m2, k1, kc, cc = 1.0, 0.5, 100.0, 80.0, 0.8
    exact = np.array([0.0062288418518515794, -0.6812021590293792, 0.293259668996103, -8.299096263191023])
    for H, error in zip((0.02, 0.01, 0.005, 0.0025), known, strict=True):
        one = on_rail(m1, k1, 0.0, Input("F"), 1.0)
        two = on_rail(m2, kc, cc, kc * Input("x") + cc * Input("v"), 0.0)
        before = None
        for k in range(round(1.0 / H)):
            (x1, v1), (x2, v2) = one.measured, two.measured
            now = np.array([kc * (x2 - x1) + cc * (v2 - v1), x1, v1])
            slopes = (now - before) / H if "extrapolated" in way and before is not None else np.zeros(3)
            before = now
            one.set("F", now[0], slope=slopes[0])
            one.advance((k + 1) * H)
            if way.startswith("gauss"):
                now[1:] = one.measured
            two.set("x", now[1], slope=slopes[1])
            two.set("v", now[2], slope=slopes[2])
            two.advance((k + 1) * H)
        found = np.abs(np.array([*one.measured, *two.measured]) - exact).max()
        assert found == pytest.approx(error, abs=1e-8)


def test_held_inputs_feed_energy():
    """The same pair without its damper, held: by how much of itself its energy grows in 1 s."""
    m1, m2, k1, kc = 1.0, 0.5, 100.0, 80.0
    known = (2.897405068548777, 0.9357810272130074, 0.37615700867669344, 0.16876032863507007)
    for H, gain in zip((0.02, 0.01, 0.005, 0.0025), known, strict=True):
        one, two = on_rail(m1, k1, 0.0, Input("F"), 1.0), on_rail(m2, kc, 0.0, kc * Input("x"), 0.0)
        for k in range(round(1.0 / H)):
            x1, x2 = one.measured[0], two.measured[0]
            one.set("F", kc * (x2 - x1))
            two.set("x", x1)
            one.advance((k + 1) * H)
            two.advance((k + 1) * H)
        (x1, v1), (x2, v2) = one.measured, two.measured
        energy = 0.5 * (m1 * v1**2 + m2 * v2**2 + k1 * x1**2 + kc * (x2 - x1) ** 2)
        assert energy / (0.5 * (k1 + kc)) - 1.0 == pytest.approx(gain, abs=1e-7)


def test_a_slope_that_makes_no_sense_is_refused():
    system, hinge, inertia = rotor(Input("torque"))
    with pytest.raises(ValueError, match="Stepper: slope of input 'torque': not finite"):
        Stepper(system).set("torque", 1.0, slope=np.inf)
    driven = System(system.bodies, [hinge, AngleDriver(hinge, Input("angle"), name="motor")])
    with pytest.raises(ValueError, match="input 'angle' prescribes the motion of driver 'motor'"):
        Stepper(driven).set("angle", 0.0, slope=1.0)


def controlled():
    """A double pendulum under an input that changed four times, and its stepper."""
    system = double_pendulum(lambda a, b: Force(b, (Input("wind"), -0.5 * Input("wind"), 0.0), at=b.centre + 0.3))
    stepper = Stepper(system)
    for k, value in enumerate((4.0, 0.0, -7.0, 3.0)):
        stepper.set("wind", value)
        stepper.advance(0.2 * (k + 1))
    return stepper


def test_the_certificate_judges_the_inputs_as_they_were():
    solution = controlled().solution()
    assert solution.certificate.passed, solution.certificate
    assert solution.t.tolist() == pytest.approx([0.0, 0.2, 0.4, 0.6, 0.8])
    assert solution.record.inputs["wind"] == ((0.0, 4.0), (0.2, 0.0), (0.4, -7.0), (pytest.approx(0.6), 3.0))


def test_a_file_keeps_the_inputs(tmp_path):
    solution = controlled().solution()
    again = load(solution.save(tmp_path / "run"))
    assert again.certificate.passed, again.certificate
    assert again.record.inputs == solution.record.inputs
    assert np.array_equal(again.at(0.5).q, solution.at(0.5).q)
    assert Stepper(again.system).inputs == {"wind": 0.0}
    wrong = replace(solution, record=replace(solution.record, inputs={"wind": ((0.0, 4.0),)}))
    assert not load(wrong.save(tmp_path / "wrong")).certificate["Newton-Euler"].passed


def test_a_tighter_run_repeats_the_changes():
    solution = controlled().solution()
    again = solution.again()
    assert np.abs(again.arrays["q"] - solution.arrays["q"]).max() < 1e-12
    assert solution.estimate().error < 1e-7


def test_what_is_set_at_the_start_and_never_again_is_repeated(tmp_path):
    sled = Body("sled", 2.0, (0.1, 0.1, 0.1), velocity=(0, 0, 0), omega=(0, 0, 0))
    stepper = Stepper(System([sled], forces=[Force(sled, (Input("push"), 0, 19.62))]))
    stepper.set("push", 4.0)
    stepper.advance(1.0)
    solution = stepper.solution()
    for ride in (solution, load(solution.save(tmp_path / "ride"))):
        assert abs(ride.again(2.0, output=3).final.q[0] - 4.0) < 1e-12  # F t^2 / (2 m)
        assert abs(ride.at(0.5).q[0] - 0.25) < 1e-12 and ride.estimate().error < 1e-12


def test_a_run_again_has_the_samples_that_are_asked_for():
    ride = controlled().solution()
    end = float(ride.t[-1])
    for output in (3, [0.3 * end, 0.5 * end], [0.0, end]):  # the ends of the slices are not among them
        again = ride.again(output=output)
        assert again.t.tolist() == (np.linspace(0.0, end, 3) if output == 3 else np.array(output)).tolist()
    assert np.array_equal(again.final.q, ride.final.q)
    with pytest.raises(ValueError, match="a run in segments is not repeated with stop_when"):
        ride.again(stop_when=measures.position(ride.system.bodies[0], axis=(0, 0, 1)) > 1.0)
    with pytest.raises(ValueError, match="not repeated with output=None"):
        ride.again(output=None)


def test_stepping_on_from_a_solution_repeats_nothing():
    stepper = controlled()
    before = stepper.solution()
    stepper.advance(1.0)
    assert (before.t.size, stepper.solution().t.size) == (5, 6)
    assert np.array_equal(stepper.solution().arrays["q"][:5], before.arrays["q"])


def test_nothing_is_kept_on_request():
    stepper = Stepper(double_pendulum(), keep=False)
    for k in range(3000):  # more than the buffer of the time loop holds
        stepper.advance(1e-4 * (k + 1))
    empty = stepper.solution()
    assert empty.t.size == 0
    assert not empty.certificate.passed  # nothing was looked at
    whole = Stepper(double_pendulum())
    for k in range(3000):
        whole.advance(1e-4 * (k + 1))
    assert whole.solution().t.size == 3001
    assert np.array_equal(whole.q, stepper.q)
    assert empty.at(0.1).q == pytest.approx(whole.solution().at(0.1).q, abs=1e-9)  # the start is known all the same


def test_short_slices_cost_one_step_each():
    stepper = Stepper(double_pendulum())
    for k in range(50):
        stepper.advance(1e-4 * (k + 1))
    assert stepper.solution().certificate.steps == 50
    stepper.advance(0.0051 + 1e-12)  # a slice that ends just after
    stepper.advance(0.3)
    assert stepper.solution().certificate.steps < 50 + 2 + 30


@pytest.mark.parametrize("use", [simulate, accelerations, System.check], ids=lambda use: use.__name__)
def test_inputs_of_one_name_start_with_one_value(use):
    """They are one input, which could not keep two; both parts are named."""
    system, _, _ = rotor(2.0 * Input("push"), Input("push") + 3.0)
    end = [0.1] * (use is simulate)
    use(system, *end)
    clash = Torque(system.bodies[0], (0.0, Input("push", 1.0), 0.0), name="other")
    with pytest.raises(ValueError, match=r"two inputs 'push' start with 0 and 1, in '.*' and 'other'; give them one"):
        use(replace(system, forces=[*system.forces, clash]), *end)


def test_errors_name_what_is_wrong():
    system, hinge, _ = rotor(Input("push"))
    stepper = Stepper(system)
    stepper.advance(1.0)
    with pytest.raises(ValueError, match="'pull' is not one of the inputs.*'push'"):
        stepper.set("pull", 1.0)
    with pytest.raises(ValueError, match="input 'push': not finite"):
        stepper.set("push", np.nan)
    for t in (1.0, np.nextafter(1.0, 2.0)):  # what rounding adds is not a segment
        with pytest.raises(ValueError, match=r"t = 1 s does not lie after 1 s"):
            stepper.advance(t)
    for t_end in (np.nextafter(1.0, 2.0), 1e-320):  # no step of any method is as short
        with pytest.raises(ValueError, match="is not later than the start time"):
            simulate(system, t_end, state=replace(system.state(), t=float(round(t_end))))
    with pytest.raises(ValueError, match="method 'DOP853' is unknown"):
        Stepper(system, method="DOP853")
    with pytest.raises(ValueError, match="two inputs 'push' start with 0 and 1"):
        Stepper(rotor(Input("push"), Input("push", 1.0))[0])
    with pytest.raises(ValueError, match="Input: name"):
        Input("")
    other = measures.angle(rotor()[1])
    with pytest.raises(ValueError, match="Stepper: measures"):
        Stepper(system, measures=[other])


def test_an_input_may_not_tear_joints_apart():
    body = Body("rotor", 1.0, (0.1, 0.1, 0.2))
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1))
    motor = SpeedDriver(GROUND, body, axis=(0, 0, 1), speed=Ramp(0.0, 1.0) + Input("speed", 2.0), name="motor")
    stepper = Stepper(System([body], [hinge, motor]))
    stepper.advance(0.5)
    assert stepper.v[5] == pytest.approx(3.0)
    stepper.set("speed", 2.0)  # no jump
    with pytest.raises(ValueError, match="input 'speed' prescribes the motion of driver 'motor'"):
        stepper.set("speed", 2.5)


def test_a_slice_stays_inside_the_tables():
    table = Table([0.0, 0.5, 1.0, 1.5], [0.0, 1.0, 0.0, 1.0])
    stepper = Stepper(rotor(table)[0])
    stepper.advance(1.5)
    with pytest.raises(ValueError, match="the table covers 0 s to 1.5 s"):
        stepper.advance(1.6)


def burst(t, bodies, z, parameters, loads, z_dot):
    """A force that has no value after 0.25 s."""
    loads[0, 0] = np.sqrt(0.25 - t)


def test_a_failure_carries_what_was_kept():
    body = random_body(np.random.default_rng(5), "stone")
    stepper = Stepper(System([body], forces=[CustomForce(burst, on=(body,), name="burst")]))
    stepper.advance(0.1)
    with pytest.raises(IntegrationError, match="force 'burst'") as caught:
        stepper.advance(0.5)
    assert caught.value.solution.t[:2].tolist() == [0.0, 0.1]
    assert caught.value.solution.position(body).shape[1] == 3
