"""Forces by functions of the user's: against closed forms, built-in elements and scipy; compiled once; named errors."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest
from helpers.models import Evaluation, direction, random_body
from scipy.integrate import solve_ivp

from mbsd3d import (
    GROUND,
    Body,
    CustomForce,
    GeneralizedAlpha,
    IntegrationError,
    Polynomial,
    Prismatic,
    Revolute,
    SlideDriver,
    Spherical,
    SpringDamper,
    System,
    accelerations,
    arctan2,
    linearize,
    load,
    measures,
    simulate,
)
from mbsd3d.dynamics.applied_forces import loads
from mbsd3d.files.description import describe
from mbsd3d.integrators.runge_kutta import advance
from mbsd3d.kernels.kinematics import kinematics

RTOL = 1e-11
AGREES = 1e-9
"""A hundred times the tolerance of either integration; the quantities compared are of order one."""

WITH_COMPILER = pytest.mark.skipif(bool(numba.config.DISABLE_JIT), reason="needs the compiler")


def maxwell(t, bodies, z, parameters, loads, z_dot):
    """Spring k in series with a dashpot c along a direction: F_dot = k v - F k / c, -F on the body."""
    axis, k, c = parameters[:3], parameters[3], parameters[4]
    loads[0, :3] = -z[0] * axis
    z_dot[0] = k * np.sum(axis * bodies[0].velocity) - z[0] * k / c


def magnet(t, bodies, z, parameters, loads, z_dot):
    """Linear spring and damper between two points, written in vectors."""
    gap, speed = bodies[1].r - bodies[0].r, bodies[1].velocity - bodies[0].velocity
    length = np.sqrt(np.sum(gap * gap))
    n = gap / length
    pull = parameters[0] * (length - parameters[2]) + parameters[1] * np.sum(n * speed)
    loads[0, :3] = pull * n
    loads[1, :3] = -pull * n


def sled(driver=False, k=30.0, c=4.0, scales=None):
    """(system, slider, element, axis, parts): a general body on a general slider with a Maxwell element."""
    rng = np.random.default_rng(11)
    body, axis = random_body(rng, "sled", mass=1.3), direction(rng)
    slider = Prismatic(GROUND, body, at=rng.normal(size=3), axis=axis, name="slider")
    point = rng.normal(size=3)
    element = CustomForce(
        maxwell, on=body, points=[point], parameters=(*axis, k, c), states=[0.0], scales=scales, name="maxwell"
    )
    joints = [slider, SlideDriver(slider, Polynomial((0.0, 0.7)))] if driver else [slider]
    return System([body], joints, [element]), slider, element, axis


def test_maxwell_element_at_constant_speed():
    system, slider, element, axis = sled(driver=True)
    solution = simulate(system, 0.6, rtol=RTOL, output=31)
    force = 4.0 * 0.7 * (1.0 - np.exp(-30.0 / 4.0 * solution.t))  # F = c v (1 - exp(-k t / c))
    assert solution.state_of(element)[:, 0] == pytest.approx(force, abs=AGREES)
    effort = solution.effort(system.joints[1])
    assert effort == pytest.approx(force + 1.3 * 9.81 * axis[2], abs=10 * AGREES)  # tens of newtons
    assert solution.work(element) == pytest.approx(
        -0.7 * 4.0 * 0.7 * (solution.t + (np.exp(-7.5 * solution.t) - 1) / 7.5), abs=AGREES
    )
    assert solution.certificate.passed


def test_sled_on_a_maxwell_element():
    system, slider, element, axis = sled()
    solution = simulate(system, 3.0, rtol=RTOL, output=31)

    def rates(_, y):
        return [y[1], -9.81 * axis[2] - y[2] / 1.3, 30.0 * y[1] - y[2] * 30.0 / 4.0]

    exact = solve_ivp(rates, (0, 3.0), [0, 0, 0], "DOP853", solution.t, rtol=1e-12, atol=1e-13).y
    assert solution.slide(slider) == pytest.approx(exact[0], abs=AGREES)
    assert solution.state_of("maxwell")[:, 0] == pytest.approx(exact[2], abs=10 * AGREES)  # tens of newtons
    assert solution.certificate.passed and np.abs(exact[2]).max() > 1.0


def test_small_states_need_their_scale():
    """k and c of 1e-9: the state is of order 1e-9, and only errors measured against its own size are small."""
    errors = []
    for scales in (None, [1e-9]):
        system, *_ = sled(k=30e-9, c=4e-9, scales=scales)
        z = simulate(system, 3.0, rtol=1e-6, output=2).final.z[0]
        tight = simulate(system, 3.0, rtol=1e-12, output=2).final.z[0]
        errors.append(abs(z - tight) / 1e-9)
    assert errors[1] < 1e-5 < errors[0]


def two_bodies(seed, force):
    """A ball joint chain of two general bodies with an element between points of them, and one to the ground."""
    rng = np.random.default_rng(seed)
    one, two = random_body(rng, "one"), random_body(rng, "two")
    at_a, at_b, far = one.position + direction(rng), two.position + direction(rng), rng.normal(size=3)
    root = Spherical(GROUND, one, at=rng.normal(size=3))
    return System([one, two], [root], [force(one, two, at_a, at_b), force(GROUND, two, far, at_b)])


def as_custom(a, b, at_a, at_b):
    return CustomForce(magnet, on=(a, b), points=(at_a, at_b), parameters=(25.0, 0.4, 0.9))


def as_spring(a, b, at_a, at_b):
    return SpringDamper(a, b, at_a=at_a, at_b=at_b, stiffness=25.0, damping=0.4, length=0.9)


def test_a_spring_written_as_a_function_is_that_spring():
    custom, built_in = (simulate(two_bodies(12, force), 2.0, rtol=RTOL, output=21) for force in (as_custom, as_spring))
    for body in ("one", "two"):
        assert custom.position(body) == pytest.approx(built_in.position(body), abs=10 * AGREES)  # a tumbling pair
    assert custom.certificate.passed
    work = sum(custom.work(force) for force in custom.system.forces)
    stored = built_in.energy().potential - custom.energy().potential
    lost = sum(built_in.work(force) for force in built_in.system.forces)
    assert work == pytest.approx(lost - (stored - stored[0]), abs=1e-7)  # tens of joules


@pytest.mark.slow
def test_derivatives_through_a_function_are_exact():
    rng = np.random.default_rng(13)
    system = two_bodies(13, as_custom)
    exact, other = Evaluation(system, complex), Evaluation(two_bodies(13, as_spring), complex)
    q, v = exact.general(rng)
    q, v = q + 1e-30j * rng.normal(size=q.size), v + 1e-30j * rng.normal(size=v.size)
    slopes = []
    for on in (exact, other):
        kinematics(on.model, on.data, on.state(q, v))
        loads(on.model, on.data, 0.3)
        slopes.append(on.data.body["Q"].imag / 1e-30)
    assert np.abs(slopes[0]).max() > 1.0
    assert slopes[0] == pytest.approx(slopes[1], abs=1e-11)  # rounding of products of order 100


@pytest.mark.slow
@WITH_COMPILER
def test_nothing_is_recompiled_and_complex_code_comes_when_it_is_needed():
    system, _, element, _ = sled()
    simulate(system, 0.1)
    known = len(advance.signatures)

    def another(t, bodies, z, parameters, loads, z_dot):
        loads[0, 2] = 3.0 * t - bodies[0].w[0]

    second = CustomForce(another, on=system.bodies[0])
    simulate(System(system.bodies, system.joints, [element, second]), 0.1)
    assert len(advance.signatures) == known
    assert set(second.callbacks) == {(float, float)}
    System(system.bodies, system.joints, [second])
    Evaluation(System(system.bodies, system.joints, [second]), complex)
    assert set(second.callbacks) == {(float, float), (complex, float)}
    twin = CustomForce(another, on=GROUND)
    assert twin.callbacks[float, float] is second.callbacks[float, float]  # one function, compiled once


@pytest.mark.slow
def test_a_jitted_function_and_four_bodies():
    @numba.njit
    def lift(t, bodies, z, parameters, loads, z_dot):
        for i in range(bodies.shape[0]):
            loads[i, 2] = parameters[i]

    bodies = [Body(name, 1.0 + i, (1, 1, 1), position=(i, 0, 0)) for i, name in enumerate("abc")]
    force = CustomForce(lift, on=(*bodies[:2], GROUND, bodies[2]), parameters=(1.0, 2.0, 50.0, 3.0))
    solution = accelerations(System(bodies, [], [force], gravity=(0, 0, 0)))
    assert [solution.acceleration(body)[0, 2] for body in bodies] == pytest.approx([1.0, 1.0, 1.0], abs=1e-14)


@pytest.mark.slow
def test_body_frames_and_moments():
    rng = np.random.default_rng(15)
    body = random_body(rng, "craft")

    def thruster(t, bodies, z, parameters, loads, z_dot):
        R = bodies[0].R
        for i in range(3):
            loads[0, i] = R[i, 0] * parameters[0] + R[i, 1] * parameters[1] + R[i, 2] * parameters[2]
            loads[0, 3 + i] = parameters[3 + i]

    force, moment, point = direction(rng), direction(rng), body.position + direction(rng)
    craft = CustomForce(thruster, on=body, points=[point], parameters=(*force, *moment))
    solution = accelerations(System([body], [], [craft], gravity=(0, 0, 0)))
    R = solution.rotation(body)[0]
    inertia, arm = R @ body.inertia @ R.T, point - solution.com(body)[0]
    alpha = np.linalg.solve(inertia, moment + np.cross(arm, R @ force))
    assert solution.alpha(body)[0] == pytest.approx(alpha, abs=1e-12)


BALL = Body("ball", 1.0, (0.1, 0.1, 0.1), position=(0, 0, 1), com=(0.1, 0.2, 0.05))


def broken(t, bodies, z, parameters, loads, z_dot):
    """Uses a name that does not exist."""
    loads[0, 2] = no_such_name  # noqa: F821


def five(t, bodies, z, parameters, loads):
    """One argument short."""


def becomes_nan(t, bodies, z, parameters, loads, z_dot):
    """The root of a negative number after 0.3 s."""
    loads[0, 0] = np.sqrt(0.3 - t)


def raises(t, bodies, z, parameters, loads, z_dot):
    """Raises after 0.3 s."""
    if t > 0.3:
        raise ValueError("too late")
    loads[0, 0] = 1.0


def typo(t, bodies, z, parameters, loads, z_dot):
    """There is no field v."""
    loads[0, :3] = -bodies[0].v


def imports(t, bodies, z, parameters, loads, z_dot):
    """Statements that numba does not know at all."""
    import os

    os.abort()


def returns(t, bodies, z, parameters, loads, z_dot):
    """A load that nobody reads."""
    return -bodies[0].velocity


def compares(t, bodies, z, parameters, loads, z_dot):
    """A comparison that complex numbers do not have."""
    if bodies[0].r[2] < 0.0:
        loads[0, 2] = -1000.0 * bodies[0].r[2]


def spring(t, bodies, z, parameters, loads, z_dot):
    """A torsion spring about y by the angle of the body's x axis."""
    loads[0, 4] = -parameters[0] * arctan2(-bodies[0].R[2, 0], bodies[0].R[0, 0])


def twisting(t, bodies, z, parameters, loads, z_dot):
    """The same with numpy's arctan2, which has no complex form."""
    loads[0, 4] = -parameters[0] * np.arctan2(-bodies[0].R[2, 0], bodies[0].R[0, 0])


@pytest.mark.slow
@WITH_COMPILER
def test_the_angle_of_two_coordinates_has_an_exact_derivative():
    body = Body("wheel", 1.5, (0.2, 0.3, 0.4), position=(0.4, -0.1, 0.7))
    hinge = Revolute(GROUND, body, at=body.position, axis=(0, 1, 0))
    found = linearize(System([body], [hinge], [CustomForce(spring, on=body, parameters=[4.8])], gravity=(0, 0, 0)))
    np.testing.assert_allclose(np.sort(found.eigenvalues.imag), [-4.0, 4.0], rtol=1e-12)  # sqrt(4.8 / 0.3)
    for y, x in ((0.3, -1.2), (-0.4, 0.7), (2.0, 0.0)):
        h = 1e-30
        # four units in the last place of 3: what the vector libraries behind numpy promise
        assert arctan2(y, x) == pytest.approx(np.arctan2(y, x), abs=2e-15)
        slope = arctan2(y + 0.3j * h, x - 0.7j * h).imag / h  # (x dy - y dx) / (x^2 + y^2)
        assert slope == pytest.approx((0.3 * x + 0.7 * y) / (x * x + y * y), rel=1e-14)
    with pytest.raises(ValueError, match="'twist'.*does not compile for the complex.*mbsd3d.arctan2"):
        linearize(System([body], [hinge], [CustomForce(twisting, on=body, parameters=[4.8], name="twist")]))


def forgetful(t, bodies, z, parameters, loads, z_dot):
    """A spring that pulls one of two bodies; the share of the opposite load is a parameter."""
    loads[0, :3] = 3.0 * (bodies[1].r - bodies[0].r)
    loads[1, :3] = -parameters[0] * loads[0, :3]
    loads[1, 3] = parameters[1]


@WITH_COMPILER
def test_loads_between_bodies_balance_or_are_external():
    bodies = [Body("a", 1.0, (0.1, 0.2, 0.2), position=(0.1, 0.2, 0.3)), BALL]

    def run(*parameters, **more):
        force = CustomForce(forgetful, on=(bodies[0], BALL), parameters=parameters, name="band", **more)
        return simulate(System(bodies, [], [force], gravity=(0, 0, 0)), 0.01)

    assert run(1.0, 0.0).certificate.passed
    for parameters in ((0.0, 0.0), (1.0, 0.2), (0.999, 0.0)):
        with pytest.raises(ValueError, match="force 'band' .CustomForce.: its loads on 'a', 'ball' leave .*external"):
            run(*parameters)
        assert run(*parameters, external=True).certificate.passed
    with pytest.raises(ValueError, match="'band'.*: external = 'yes'; give True or False"):
        run(1.0, 0.0, external="yes")


def beyond(t, bodies, z, parameters, loads, z_dot):
    """A parameter that was not given."""
    loads[0, 2] = parameters[3]


@pytest.mark.slow
@WITH_COMPILER
def test_what_complex_numbers_do_not_have_is_named_where_it_is_needed():
    system = System([BALL], [], [CustomForce(compares, on=BALL, name="floor")])
    assert simulate(system, 0.1).certificate.passed
    for call in (lambda: simulate(system, 0.1, method=GeneralizedAlpha(0.01)), lambda: linearize(system)):
        with pytest.raises(ValueError, match="'floor'.*'compares' does not compile for the complex numbers.*x.real"):
            call()


@pytest.mark.parametrize(
    ("make", "message"),
    [
        *(pytest.param(lambda f=f: CustomForce(f, on=BALL, name="lift"), words, marks=WITH_COMPILER) for f, words in (
            (typo, "lift.*'typo' does not compile: bodies have no 'v', they have r, R, velocity, w"),
            (imports, "lift.*'imports' does not compile: .*unsupported opcode"),
            (returns, r"lift.*'returns' does not compile: it returns array.*fill loads"),
        )),
        (lambda: CustomForce(magnet, on=3, name="lift"), "lift.*on 3; give a Body"),
        pytest.param(
            lambda: CustomForce(broken, on=BALL, name="lift"), "lift.*'broken' does not compile: .*no_such_name",
            marks=WITH_COMPILER,
        ),
        (lambda: CustomForce(five, on=BALL, name="lift"), "lift.*'five' must take the arguments t, bodies, z"),
        (lambda: CustomForce(np.sin, on=BALL, name="lift"), "lift.*is not a function"),
        (lambda: CustomForce(magnet, on=(BALL, "x"), name="lift"), "lift.*'x' is not a body"),
        (lambda: CustomForce(magnet, on=(BALL,) * 5, name="lift"), "lift.*acts on 5 bodies; give 1 to 4"),
        (lambda: CustomForce(magnet, on=BALL, points=[(0, 0, 0)] * 2, name="lift"), "lift.*2 points for 1 body"),
        (lambda: CustomForce(magnet, on=BALL, parameters=(1.0, np.inf), name="lift"), "lift.*parameters no. 2"),
        (lambda: CustomForce(magnet, on=BALL, states=(1.0,), scales=(0.0,), name="lift"), "lift.*number > 0 per state"),
        (lambda: System([Body("a", 1.0, (1, 1, 1))], [], [CustomForce(magnet, on=BALL, name="lift")]),
         "lift.*'ball' is not in the system"),
    ],
)  # fmt: skip
def test_bad_input_is_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize("function", [becomes_nan, pytest.param(raises, marks=WITH_COMPILER)])
@pytest.mark.filterwarnings("ignore:invalid value encountered in sqrt")
def test_a_function_that_fails_is_named(function):
    system = System([BALL], [], [CustomForce(function, on=BALL, name="lift")])
    with pytest.raises(IntegrationError, match="(not finite|raises ValueError: too late).*'lift'") as caught:
        simulate(system, 1.0)
    assert 0.2 < caught.value.time <= 0.3 + 1e-9
    assert caught.value.solution.t.size > 1


@WITH_COMPILER
def test_a_place_beyond_the_end_of_an_array_is_an_error():
    """Unchecked, it would read any number."""
    system = System([BALL], [], [CustomForce(beyond, on=BALL, parameters=(1.0, 2.0, 3.0), name="lift")])
    with pytest.raises(IntegrationError, match="force 'lift'.*parameters or function"):
        simulate(system, 1.0)


def test_models_are_refused_but_results_are_kept(tmp_path):
    system, slider, element, _ = sled()
    with pytest.raises(ValueError, match="CustomForce 'maxwell': its function cannot be written"):
        describe(system)
    solution = simulate(system, 0.5, stop_when=measures.state(element) > 1e9)
    again = load(solution.save(tmp_path / "sled"))
    assert np.array_equal(again.state_of("maxwell"), solution.state_of(element))
    assert np.array_equal(again.work("maxwell"), solution.work(element))
    assert np.array_equal(again.slide("slider"), solution.slide(slider))
    assert again.certificate.passed and "'maxwell' was saved without its function" in str(again.certificate)
    with pytest.raises(ValueError, match="force 'maxwell'.*not saved.*CustomForce"):
        again.at(0.123)


SCRIPT = """
import json
from mbsd3d import accelerations
from test_custom import as_custom, two_bodies
print(json.dumps(accelerations(two_bodies(12, as_custom)).arrays["acceleration"].ravel().tolist()))
"""


@pytest.mark.slow
@WITH_COMPILER
def test_the_same_without_the_compiler():
    paths = os.pathsep.join([str(Path(__file__).parent), *sys.path])
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": paths}
    done = subprocess.run([sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True)
    plain = json.loads(done.stdout)
    compiled = accelerations(two_bodies(12, as_custom)).arrays["acceleration"].ravel()
    assert compiled == pytest.approx(plain, abs=1e-10)  # rounding of accelerations of order 100
