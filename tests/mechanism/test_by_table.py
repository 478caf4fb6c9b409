"""Forces by tables: springs and motors against quadratures, integrals, ends of tables, files, what is refused."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.interpolate import PchipInterpolator

from mbsd3d import (
    GROUND,
    Body,
    ForceCurve,
    IntegrationError,
    Prismatic,
    Revolute,
    System,
    Torque,
    TorqueCurve,
    accelerations,
    linearize,
    measures,
    simulate,
)

EXACT = dict(rel=1e-8, abs=1e-9)  # of quadratures, for runs at rtol 1e-11
STEEL = [(0.0, 0.0), (0.01, 100.0), (0.03, 500.0), (0.06, 800.0), (0.1, 3000.0)]
MOTOR = [(0.0, 30.0), (50.0, 28.0), (100.0, 35.0), (140.0, 45.0), (157.0, 0.0)]


def cart(speed=0.0, mass=5.0, **curve):
    """A cart on a slanted rail at one end of a spring by a table along the rail."""
    way = np.array([1.0, -2.0, 2.0]) / 3.0
    at = np.array([0.4, 0.1, -0.2])
    body = Body("cart", mass, (0.1, 0.2, 0.25), com=(0.1, 0.2, -0.1), position=at, velocity=speed * way)
    rail = Prismatic(GROUND, body, at=at, axis=way, name="rail")
    spring = ForceCurve(GROUND, body, at_a=at - 0.7 * way, at_b=at, name="spring", **curve)
    return System([body], [rail], [spring], gravity=(0, 0, 0))


def rotor(inertia, *forces, **state):
    """A rotor on a hinge along z, with torques on it."""
    body = Body("rotor", 2.0, (0.7, 0.6, inertia), com=(0, 0, 0.3), **state)
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    return System([body], [hinge], [make(body, hinge) for make in forces])


def test_a_mass_runs_into_a_spring_by_a_table():
    system = cart(4.0, points=STEEL)
    run = simulate(system, 0.1, rtol=1e-11, stop_when=measures.slide_rate(system.joints[0]) < 0.0)
    assert run.slide("rail")[-1] == pytest.approx(0.07229967829133345, **EXACT)
    assert run.t[-1] == pytest.approx(0.02700952076028623, **EXACT)
    assert np.linalg.norm(run.force("spring").force[-1]) == pytest.approx(1476.48230602334, **EXACT)
    assert run.force("spring").stored[-1] == pytest.approx(0.5 * 5.0 * 16.0, rel=1e-9)
    assert run.certificate.passed and run.measure(measures.length(system.forces[0]))[-1] == pytest.approx(0.7722996783)


def test_a_motor_by_a_table_speeds_up_a_rotor():
    system = rotor(
        0.8, lambda body, hinge: TorqueCurve(hinge, points=MOTOR), lambda body, _: Torque(body, (0, 0, -5.0))
    )
    run = simulate(system, 10.0, rtol=1e-11, stop_when=measures.rate(system.joints[0]) > 150.0)
    assert run.t[-1] == pytest.approx(4.434131580454404, **EXACT)
    assert run.angle("hinge")[-1] == pytest.approx(311.8464989435599, **EXACT)
    assert run.energy().work[-1] == pytest.approx(0.5 * 0.8 * 150.0**2, rel=1e-9)


@pytest.mark.parametrize("between", ["linear", "monotone"])
@pytest.mark.parametrize("beyond", ["hold", "line"])
def test_values_and_energies_are_those_of_scipy(between, beyond):
    x, y = np.array(STEEL).T - [[0.02], [250.0]]
    curve = (lambda s: np.interp(s, x, y)) if between == "linear" else PchipInterpolator(x, y)
    ends = PchipInterpolator(x, y).derivative()([x[0], x[-1]])
    slopes = (
        np.zeros(2)
        if beyond == "hold"
        else (np.diff(y)[[0, -1]] / np.diff(x)[[0, -1]] if between == "linear" else ends)
    )

    def value(s):
        if s < x[0]:
            return y[0] + slopes[0] * (s - x[0])
        return y[-1] + slopes[1] * (s - x[-1]) if s > x[-1] else float(curve(s))

    for stretch in (-0.08, -0.05, -0.02, -0.013, 0.0, 0.021, 0.04, 0.08, 0.1, 0.3):
        system = cart(points=np.column_stack([x, y]), between=between, beyond=beyond, length=0.7 - stretch)
        now = accelerations(system).force("spring")
        pull = -now.force[0] @ system.joints[0].axis
        assert pull == pytest.approx(value(stretch), abs=1e-9)  # rounding of the stretch times slopes of 1e5 N/m
        breaks = [s for s in x if min(0.0, stretch) < s < max(0.0, stretch)]
        stored = quad(value, 0.0, stretch, points=breaks or None, epsabs=1e-11, epsrel=1e-12)[0]
        assert now.stored[0] == pytest.approx(stored, abs=1e-9)


def test_energy_counts_from_the_nearer_end_of_a_table_without_zero():
    system = cart(points=[(0.1, 50.0), (0.2, 90.0)], length=0.55)
    assert accelerations(system).force("spring").stored[0] == pytest.approx(0.5 * (50.0 + 70.0) * 0.05, abs=1e-12)


def test_damper_and_spring_by_tables_agree_with_a_reduced_equation():
    inertia, spring, damper = 0.8, [(-9.0, 12.0), (-0.5, 1.0), (0.0, 0.0), (1.0, -3.0), (9.0, -40.0)], \
        [(-20.0, 9.0), (-1.0, 1.0), (0.0, 0.0), (1.0, -0.5), (20.0, -6.0)]  # fmt: skip
    system = rotor(
        inertia,
        lambda body, hinge: TorqueCurve(hinge, points=spring, over="angle", between="monotone", name="spring"),
        lambda body, hinge: TorqueCurve(hinge, points=damper, between="monotone", name="damper"),
        omega=(0, 0, 9.0),
    )
    run = simulate(system, 6.0, rtol=1e-10, output=61)
    T, D = PchipInterpolator(*np.transpose(spring)), PchipInterpolator(*np.transpose(damper))
    truth = solve_ivp(lambda t, x: [x[1], (T(x[0]) + D(x[1])) / inertia], (0.0, 6.0), [0.0, 9.0], method="DOP853",
                      rtol=1e-11, atol=1e-12, t_eval=run.t)  # fmt: skip
    assert np.abs(run.angle("hinge") - truth.y[0]).max() < 1e-7  # kinks of second derivatives in both
    assert run.angle("hinge").max() > np.pi  # counted
    stored = T.antiderivative()
    assert run.force("spring").stored == pytest.approx(stored(0.0) - stored(run.angle("hinge")), abs=1e-10)
    assert run.work("damper")[-1] < -1.0 and run.work("spring")[-1] == 0.0 and run.certificate.passed


def test_small_motions_have_the_slope_of_the_table():
    system = cart(points=STEEL, length=0.68, mass=5.0)
    held = System(system.bodies, system.joints, [*system.forces], gravity=333.3 / 5.0 * np.array(system.joints[0].axis))
    rest = held.equilibrium()
    assert accelerations(held, rest.state).force("spring").length[0] == pytest.approx(0.68 + 0.01 + 233.3 / 2e4)
    values = linearize(held, rest.state).eigenvalues
    assert np.abs(values.imag).max() == pytest.approx(np.sqrt(400.0 / 0.02 / 5.0), rel=1e-7)


def test_the_end_of_a_table_ends_the_run_in_words():
    system = rotor(0.8, lambda body, hinge: TorqueCurve(hinge, points=MOTOR[:4], name="motor"))
    with pytest.raises(IntegrationError, match=r"its table from 0 to 140 ends; give more points, or beyond=") as error:
        simulate(system, 10.0)
    assert "force 'motor'" in str(error.value)
    assert error.value.solution.rate("hinge")[-1] == pytest.approx(140.0, rel=1e-3)


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"points": [(0, 1)]}, "points has shape (1, 2); give two or more pairs of x and y, (k, 2)"),
        ({"points": [0, 1, 2]}, "points has shape (3,); give two or more pairs"),
        ({"points": [(0, 1), (1, 2), (1, 3)]}, "points: x = 1 (no. 3) does not come after 1; sort the points"),
        ({"points": [(0, 1), (1, np.nan)]}, "is not finite"),
        ({"points": STEEL, "between": "cubic"}, "between 'cubic' is unknown; give 'linear' or 'monotone'"),
        ({"points": STEEL, "beyond": "stop"}, "beyond 'stop' is unknown; give 'refuse' or 'hold' or 'line'"),
        ({"points": STEEL, "over": "length"}, "over 'length' is unknown; give 'stretch' or 'rate'"),
        ({"points": STEEL, "at_b": (0.4, 0.1, -0.2)}, "at_a and at_b coincide, so the force has no direction"),
    ],
)
def test_what_is_no_table_is_refused(given, text):
    body = Body("cart", 5.0, (0.1, 0.2, 0.25))
    with pytest.raises(ValueError) as error:
        ForceCurve(GROUND, body, name="spring", **({"at_a": (0.4, 0.1, -0.2), "at_b": (0, 0, 0)} | given))
    assert "force 'spring' (ForceCurve)" in str(error.value) and text in str(error.value)


def test_a_joint_without_the_coordinate_is_refused():
    body = Body("cart", 5.0, (0.1, 0.2, 0.25))
    rail = Prismatic(GROUND, body, at=(0, 0, 0), axis=(1, 0, 0), name="rail")
    with pytest.raises(ValueError, match="'rail' .*has no angle; give a joint that has one"):
        TorqueCurve(rail, points=MOTOR, over="angle")
