"""Derivatives of runs against closed forms at 40 digits (`tests/data/studies.json`), and what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from helpers import study_models as models
from helpers.study_models import TRUTH, truth
from scipy.optimize import least_squares, minimize

from bicycle import Meijaard2007, whipple
from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    Body,
    Contact,
    CustomForce,
    Force,
    GeneralizedAlpha,
    GradientError,
    Kinematic,
    Pulse,
    Revolute,
    Study,
    System,
    accelerations,
    linearize,
    measures,
    shapes,
    simulate,
)
from mbsd3d.errors import InputError

TIGHT = {"t_end": 5.0, "rtol": 1e-10}
POSE = {"t_end": 1.0, "method": Kinematic(), "output": 2}


def lowest(solution):
    """Height of the centre of mass of the top at the end."""
    return (solution.rotation("top")[-1] @ solution.system.part("top", "bodies").com)[2]


def frequency(system):
    return np.abs(linearize(system).eigenvalues.imag).min()


def angle_at_rest(system):
    e = system.equilibrium().state.q[3:7]
    return 2.0 * np.arctan2(e[2], e[0])


RUNS = {
    "pendulum period": (models.pendulum, lambda s: 4.0 * s.t[-1], TIGHT),
    "pendulum hinge force at the lowest point": (models.pendulum, lambda s: s.reaction("hinge").force[-1, 2], TIGHT),
    "mass, spring and damper": (models.oscillator, lambda s: s.position("box")[-1, 0] - 1.0, {"rtol": 1e-10}),
    "four-bar: coupler point": (models.four_bar, lambda s: s.position("tip")[-1, 0], POSE),
    "two masses in a row: lower frequency": (models.two_masses, frequency, None),
    "arm held by a torsion spring": (models.arm_on_spring, angle_at_rest, None),
}
LONG_RUNS = {
    "grazing event, 0.1 rad before the turning point": (models.grazing, lambda s: s.t[-1], TIGHT),
    "grazing event, 1e-4 rad before the turning point": (models.grazing, lambda s: s.t[-1], TIGHT),
    "heavy top: lowest height of its nutation": (models.top, lowest, TIGHT),
    "ball on a linear spring: height after one bounce": (
        models.ball, lambda s: s.position("ball")[-1, 2], {"rtol": 1e-8},
    ),
    "Cardan joint: unevenness": (
        models.cardan, lambda s: s.rate("last")[1] / s.rate("last")[0], POSE | {"t_end": np.pi / 2},
    ),
    "Kepler orbit": (models.orbit, lambda s: 2.0 * s.t[-1], {"t_end": 20.0, "rtol": 1e-10}),
}  # fmt: skip


def squares(system):
    """Return the sum of the squares of the eigenvalues: it vanishes where the only other pair does."""
    A = linearize(system).A
    return np.trace(A @ A)


def distance_of_pairs(system):
    """Return (a - b)^2 of the squares a, b of two pairs of eigenvalues."""
    A = linearize(system).A
    B = A @ A
    return np.trace(B @ B) - (0.5 * np.trace(B)) ** 2


def excess(system):
    """Return by how much the acceleration across the string differs from that of a steady cone."""
    r = system.bodies[0].position
    across = np.array([-r[2], 0, r[0]]) / np.linalg.norm(r)
    v = system.bodies[0].velocity[1]
    return accelerations(system).acceleration("stone")[0] @ across + v * v / r[0] * across[0]


def moving(v, **changed):
    return whipple(replace(Meijaard2007(), **changed), speed=v)


def hurwitz(system):
    """Return the determinant that vanishes where a pair of eigenvalues is imaginary."""
    frame, hinge = system.part("frame", "bodies"), system.part("steer", "joints")
    seen = [measures.lean(frame), measures.angle(hinge), measures.lean_rate(frame), measures.rate(hinge)]
    a, b, c, d, e = np.poly(linearize(system, outputs=seen).A)
    return b * c * d - a * d * d - b * b * e


# Quantities that make something vanish: build, what vanishes, name of the quantity, arguments of simulate.
ROOTS = {
    "Dzhanibekov: half of a flip": (
        models.free_body, lambda s: s.omega_body("body")[-1, 1], "t", {"rtol": 1e-11},
    ),
    "rolling disc: critical speed": (models.disc, squares, "v", None),
    "sleeping top: critical spin": (models.sleeping_top, distance_of_pairs, "spin", None),
    "conical pendulum": (models.cone, excess, "w", None),
    "bicycle: weave speed": (moving, hurwitz, "v", None),
}  # fmt: skip


def compare(name, build, measure, run):
    """Check value, derivatives and estimate of an entry."""
    parameters, value, expected = truth(name)
    found = Study(build, parameters, measure, run).gradient()
    tolerance = TRUTH[name]["relative_tolerance"]
    assert found.values[0] == pytest.approx(value, rel=tolerance)
    np.testing.assert_allclose(found.jac[0], expected, rtol=tolerance)
    # digits of the closed form and of its parameters leave some 1e-15
    assert (found.estimate[0] >= (np.abs(found.jac[0] - expected) - 1e-14 * np.abs(expected)) / 3.0).all()


@pytest.mark.parametrize("name", RUNS)
def test_derivatives_are_those_of_the_closed_form(name):
    compare(name, *RUNS[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", LONG_RUNS)
def test_derivatives_of_longer_runs_are_those_of_the_closed_form(name):
    compare(name, *LONG_RUNS[name])


@pytest.mark.slow
@pytest.mark.parametrize("name", ROOTS)
def test_derivatives_of_roots_are_those_of_the_closed_form(name):
    """dx/dp = -(df/dp) / (df/dx) where f(x, p) = 0."""
    build, measure, quantity, run = ROOTS[name]
    parameters, value, expected = truth(name)
    f, jac = Study(build, {**parameters, quantity: value}, measure, run).fun_and_jac()
    tolerance = TRUTH[name]["relative_tolerance"]
    assert abs(f) <= tolerance * np.abs(jac[-1] * value)
    np.testing.assert_allclose(-jac[:-1] / jac[-1], expected, rtol=tolerance)


@pytest.mark.slow
def test_every_entry_is_tested():
    elsewhere = {
        "slider-crank: counterweight of least shaking force", "suspension: no bump steer", "coverage of 95 % intervals",
        "identifiable combinations of a damped pendulum", "base parameters of a 6R arm",
    }  # fmt: skip
    assert {*RUNS, *LONG_RUNS, *ROOTS, *elsewhere} == set(TRUTH)


@pytest.mark.slow
def test_counterweight_of_least_shaking_force():
    run = {"t_end": 2 * np.pi / 100.0, "method": Kinematic(), "output": 73}
    study = Study(models.slider_crank, {"along": -0.01, "across": 0.01}, models.shaking, run)
    found = minimize(study.fun_and_jac, [-0.01, 0.01], jac=True, method="BFGS")
    np.testing.assert_allclose(
        found.x, TRUTH["slider-crank: counterweight of least shaking force"]["value"], rtol=0.0, atol=1e-9
    )
    assert found.nfev < 20  # without derivatives 123


@pytest.mark.slow
def test_tie_rod_without_bump_steer():
    study = Study(
        models.wishbones, {"y": 0.02, "z": -0.03}, models.steer, {"t_end": 4.0, "method": Kinematic(), "output": 21}
    )
    found = least_squares(study.fun, [0.02, -0.03], jac=study.jac, xtol=1e-14, ftol=1e-14, gtol=1e-14)
    np.testing.assert_allclose(found.x, [0.0, 0.0], rtol=0.0, atol=1e-9)


def hop(h, c):
    """A ball that falls on a spring with a linear damper, whose force jumps at the touch."""
    ball = Body("ball", 1.0, (0.004, 0.004, 0.004), position=(0, 0, 0.1 + h), velocity=(0, 0, 0), omega=(0, 0, 0))
    return System([ball], forces=[Contact(GROUND, ball, shapes.Sphere(0.1), stiffness=2e4, exponent=1.0, damping=c)])


def height(solution):
    return solution.position("ball")[-1, 2]


@pytest.mark.slow
def test_force_that_jumps_at_a_touch():
    """z after touch, by the damped oscillator in closed form, differenced: no run is."""

    def closed(h, c, t=0.33, g=9.81):
        touch = np.sqrt(2 * h / g)
        d, w = c / 2, np.sqrt(2e4 - c * c / 4)
        x0, v0, s = g / 2e4, -g * touch, t - touch
        x = np.exp(-d * s) * (x0 * np.cos(w * s) + (v0 + d * x0) / w * np.sin(w * s))
        return 0.1 + x - x0

    study = Study(hop, {"h": 0.5, "c": 60.0}, height, {"t_end": 0.33, "rtol": 1e-10})
    expected = [
        (closed(0.5 + 1e-5, 60.0) - closed(0.5 - 1e-5, 60.0)) / 2e-5,
        (closed(0.5, 60.0 + 1e-3) - closed(0.5, 60.0 - 1e-3)) / 2e-3,
    ]
    found = study.gradient()
    assert found.values[0] == pytest.approx(closed(0.5, 60.0), rel=1e-9)
    np.testing.assert_allclose(found.jac[0], expected, rtol=1e-6)  # of these differences


def test_times_that_move_with_a_parameter():
    """Position after a pulse of force F from t1 to t2, at t: F/m of the integral of (t - s)."""

    def pushed(F, begin, m, t):
        box = Body("box", m, (0.1, 0.1, 0.1), velocity=(0, 0, 0), omega=(0, 0, 0))
        push = Force(box, (Pulse(F, begin, 0.1, 0.5), 0, 0))
        return System([box], forces=[push], gravity=(0, 0, 0)), {"t_end": t}

    x = {"F": 3.0, "begin": 0.4, "m": 2.0, "t": 1.5}
    study = Study(pushed, x, lambda s: s.velocity("box")[-1, 0], {"rtol": 1e-10})
    value, jac = study.fun_and_jac()
    np.testing.assert_allclose(jac, [value / 3.0, 0.0, -value / 2.0, 0.0], rtol=0.0, atol=1e-9 * value)
    far = Study(pushed, x, lambda s: s.position("box")[-1, 0], {"rtol": 1e-10}).jac()
    assert far[1] == pytest.approx(-value, rel=1e-8)  # a later push: the speed that it leaves acts for less time


def test_shapes_are_those_of_scipy():
    x = [0.7, 9.81, 0.8, 0.05, 1.3]
    build = models.pendulum
    one = Study(build, truth("pendulum period")[0], lambda s: s.t[-1], TIGHT)
    assert isinstance(one.fun(x), float) and one.jac(x).shape == (5,)
    two = Study(build, truth("pendulum period")[0], lambda s: {"t": s.t[-1], "r": s.position("bob")[-1]}, TIGHT)
    found, jac = two.fun_and_jac(dict(zip(two.names, x, strict=True)))
    assert found.shape == (4,) and jac.shape == (4, 5) and found[0] == one.fun(x)
    np.testing.assert_allclose(jac[0], one.jac(x), rtol=1e-10)  # other rounding beside other numbers
    table = two.gradient().dataset
    assert table["jac"].dims == ("value", "parameter") and table["jac"].sel(value="r[2]", parameter="l") == jac[3, 0]


def test_values_are_those_of_a_plain_run():
    parameters = truth("pendulum period")[0]
    system, more = models.pendulum(**parameters)
    study = Study(models.pendulum, parameters, lambda s: s.t[-1], TIGHT)
    assert study.fun_and_jac()[0] == simulate(system, **{**TIGHT, **more}).t[-1]


def refused(build, x0, measure, run, words, error=GradientError, **more):
    with pytest.raises(error, match=words):
        Study(build, x0, measure, run, **more).gradient()


def test_grazed_event_is_refused():
    x = truth("pendulum period")[0]
    close = {"x_stop": -x["l"] * np.sin(x["th0"] - 1e-9), **x}
    refused(models.grazing, close, lambda s: s.t[-1], TIGHT, "event position of bob < .* is grazed: .* turns back")


def test_contact_at_a_loose_tolerance_is_refused():
    run = {"t_end": 0.6, "rtol": 1e-6}
    refused(
        hop, {"h": 0.5, "c": 20.0}, height, run, "rtol 1e-06 is too loose .* Contact 'Contact 1' .* give rtol=1e-07"
    )


@pytest.mark.slow
@pytest.mark.parametrize("t_end", [20.0, 30.0])
def test_chaos_is_refused(t_end):
    def double(l):
        inner = Body("inner", 1.0, (0.01, 0.01, 0.01), position=(l, 0, 0))
        outer = Body("outer", 1.0, (0.01, 0.01, 0.01), position=(l, 0, 0.9))
        hinges = [
            Revolute(GROUND, inner, at=(0, 0, 0), axis=(0, 1, 0)),
            Revolute(inner, outer, at=(l, 0, 0), axis=(0, 1, 0)),
        ]
        return System([inner, outer], hinges)

    def end(s):
        return s.position("outer")[-1, 0]

    calm = Study(double, {"l": 1.0}, end, {"t_end": 2.0, "output": 2}).gradient()
    assert calm.error < 1e-7
    refused(double, {"l": 1.0}, end, {"t_end": t_end, "output": 2}, "cannot be repeated|with a finer tolerance")


def box(k):
    """A box whose number of springs or forces depends on the test."""
    return Body("box", 2.0, (1, 1, 1), position=(1.0, 0, 0), velocity=(0.1 * k, 0, 0), omega=(0, 0, 0))


def test_kinks_and_jumps_are_refused():
    def sized(k):
        return System([box(k)], gravity=(0, 0, 0))

    def switching(k):
        body = box(1.0)
        return System([body], forces=[Force(body, (1.0, 0, 0))] if k >= 1.0 else [])

    run, x0 = {"t_end": 0.3, "output": 3}, {"k": 1.0}
    refused(switching, x0, lambda s: s.position("box")[-1, 0], run, "structure of the model changes near 'k' = 1")
    refused(sized, x0, lambda s: abs(s.position("box")[-1, 0] - 1.03), run, "what is measured, by 'k', has a kink")
    refused(sized, x0, lambda s: np.nan, run, "measure returned .*nan")
    refused(lambda k: sized(abs(k - 1.0)), x0, lambda s: s.position("box")[-1, 0], run, "model by 'k' has a kink")

    def limited(k):
        if k != 1.0:
            raise InputError("there is no other")
        return sized(k)

    refused(limited, x0, lambda s: s.position("box")[-1, 0], run, "no model beside 'k' = 1: there is no other")


def bent(t, bodies, z, parameters, loads, z_dot):
    """Of a CustomForce: reads its parameter for complex numbers too."""
    loads[0, 0] = -parameters[0] * bodies[0].r[0]


def lossy(t, bodies, z, parameters, loads, z_dot):
    """The same, but an absolute value loses the imaginary part."""
    loads[0, 0] = -parameters[0] * abs(bodies[0].r[0])


@pytest.mark.slow
def test_custom_forces_have_derivatives_or_are_refused():
    def own(function):
        def build(k):
            body = box(1.0)
            return System([body], forces=[CustomForce(function, on=body, parameters=(k,))], gravity=(0, 0, 0))

        return build

    run, w = {"t_end": 0.4, "rtol": 1e-10}, np.sqrt(2.5)
    found = Study(own(bent), {"k": 5.0}, lambda s: s.position("box")[-1, 0], run).jac()
    by_w = -0.4 * np.sin(0.4 * w) + 0.1 * (0.4 * np.cos(0.4 * w) / w - np.sin(0.4 * w) / w**2)  # of cos + 0.1 sin / w
    assert found[0] == pytest.approx(by_w / (4 * w), rel=1e-8)
    refused(own(lossy), {"k": 5.0}, lambda s: s.position("box")[-1, 0], run, "derivative of CustomForce .* 'k' is lost")


def test_methods_without_derivatives_are_refused_by_name():
    x, run = truth("mass, spring and damper")[0], {"method": GeneralizedAlpha(1e-3)}
    refused(
        models.oscillator, x, lambda s: s.t[-1], run, "GeneralizedAlpha has no derivatives; give DOP853", InputError
    )


@pytest.mark.parametrize("method", [RK4(1e-3), DOP853(dt=5e-3)])
def test_fixed_steps(method):
    x, value, expected = truth("mass, spring and damper")
    found = Study(models.oscillator, x, lambda s: s.position("box")[-1, 0] - 1.0, {"method": method}).gradient()
    np.testing.assert_allclose(found.jac[0], expected, rtol=1e-8)


def test_bad_input_is_refused_before_anything_runs():
    x = truth("pendulum period")[0]
    for arguments, words in (
        (
            (models.pendulum, {"l": 1.0}, len, TIGHT),
            "Study: build does not take the parameters l .* it takes l, g, th0",
        ),
        ((models.pendulum, x, len, {"t_stop": 1.0}), "Study: simulate has no argument 't_stop'"),
        ((models.pendulum, {**x, "l": "long"}, len, TIGHT), "Study: x0: 'l'"),
        ((models.pendulum, [1.0], len, TIGHT), "Study: x0 .*; give a mapping"),
        ((models.pendulum, x, 3.0, TIGHT), "Study: measure 3.0 is not a function"),
        ((models.pendulum, x, len, 3.0), "Study: run 3.0; give a mapping"),
    ):
        with pytest.raises(InputError, match=words):
            Study(*arguments)
    study = Study(models.pendulum, x, lambda s: s.t[-1], TIGHT)
    with pytest.raises(InputError, match="Study: x .*; give 5 finite numbers: l, g, th0, J, m"):
        study.fun([1.0])
    with pytest.raises(InputError, match="Study: x has l; give l, g"):
        study.jac({"l": 1.0})
    with pytest.raises(InputError, match="Study: x_scale of 'L', which x0 does not have"):
        Study(models.pendulum, x, len, TIGHT, x_scale={"L": 1.0})


def test_a_measure_of_what_moves_far():
    """Samples move by metres a step: the model is changed while they stand still, and they move while it does."""

    def stone(mass, speed):
        body = Body("stone", mass, (0.1, 0.2, 0.3), com=(0.1, 0, 0), velocity=(speed, 0, 0), omega=(0, 0, 0))
        return System([body], gravity=(0, 0, 0))

    def measured(solution):
        x = solution.position("stone")[-1, 0]
        return {"energy": solution.energy().kinetic[-1], "cube": x**3, "both": solution.system.bodies[0].mass * x * x}

    m, v, t = 1.7, 900.0, 2.0
    found = Study(stone, {"mass": m, "speed": v}, measured, {"t_end": t, "rtol": 1e-10}).gradient()
    x = v * t
    exact = [[0.5 * v * v, m * v], [0.0, 3 * x * x * t], [x * x, 2 * m * x * t]]
    np.testing.assert_allclose(found.jac, exact, rtol=1e-9, atol=1e-9)
