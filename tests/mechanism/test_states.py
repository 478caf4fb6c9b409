"""Own states of force elements and feedback of measures, against hand-written equations integrated by scipy."""

import numpy as np
import pytest
from helpers.models import direction, random_body
from scipy.integrate import solve_ivp

from mbsd3d import (
    GROUND,
    Body,
    Cylindrical,
    IntegrationError,
    Prismatic,
    Revolute,
    State,
    StateFeedback,
    System,
    TorsionSpring,
    load,
    measures,
    simulate,
)
from mbsd3d.extend import compile_system

RTOL = 1e-11
AGREES = 1e-9
"""A hundred times the tolerance of either integration; the quantities compared are of order one."""

GAINS, REFERENCE, TAU = (40.0, 6.0), (0.3, -0.2), 0.07


def cart(tau=TAU, gains=GAINS, name="servo"):
    """(system, slider, servo, axis): a body of general shape on a general slider under filtered feedback."""
    rng = np.random.default_rng(1)
    body, axis = random_body(rng, "cart", mass=1.7), direction(rng)
    slider = Prismatic(GROUND, body, at=rng.normal(size=3), axis=axis, name="slider")
    seen = [measures.slide(slider), measures.slide_rate(slider)]
    servo = StateFeedback(measures=seen, gains=gains, on=slider, reference=REFERENCE, time_constant=tau, name=name)
    return System([body], [slider], [servo]), slider, servo, axis


def by_hand(axis, t, start=REFERENCE):
    """x, z1, z2 and the work of the filtered feedback of the cart: m x'' = m g.n - sum g (z - r), z' = (y - z)/tau."""
    weight = np.array([0.0, 0.0, -9.81]) @ axis

    def rates(_, y):
        x, v, *z, _ = y
        load = -sum(g * (z_i - r) for g, z_i, r in zip(GAINS, z, REFERENCE, strict=True))
        return [v, weight + load / 1.7, (x - z[0]) / TAU, (v - z[1]) / TAU, load * v]

    return solve_ivp(rates, (0, t[-1]), [0, 0, *start, 0], "DOP853", t, rtol=1e-12, atol=1e-13).y[[0, 2, 3, 4]]


def test_filtered_feedback_of_a_cart():
    system, slider, servo, axis = cart()
    solution = simulate(system, 2.0, rtol=RTOL, output=41)
    x, z1, z2, work = by_hand(axis, solution.t)
    assert np.ptp(x) > 0.1  # it moves
    assert solution.slide(slider) == pytest.approx(x, abs=AGREES)
    assert solution.state_of(servo) == pytest.approx(np.array([z1, z2]).T, abs=AGREES)
    assert solution.work(servo) == pytest.approx(work, abs=10 * AGREES)  # joules: tens of newtons times metres
    assert solution.certificate.passed


def test_own_states_have_columns_units_and_a_figure(tmp_path):
    system, slider, servo, _ = cart()
    solution = simulate(system, 0.5, output=6)
    data, z = solution.to_xarray(), solution.state_of(servo)
    assert data["own_state"].values.tolist() == ["servo.slide of slider", "servo.slide rate of slider"]
    assert data["state_unit"].values.tolist() == ["m", "m/s"]  # those of the measures that are filtered
    assert np.array_equal(data["state"].sel(own_state="servo.slide rate of slider"), z[:, 1]) and np.ptp(z[:, 1]) > 0.1
    header, *rows = [line.split(",") for line in solution.to_csv(tmp_path / "cart").read_text().splitlines()]
    place = header.index("servo.slide of slider.state [m]")
    assert [float(row[place]) for row in rows] == z[:, 0].tolist()
    figure = solution.plot("state", servo)
    labels = [axes.get_ylabel().replace("\n", " ") for axes in figure.axes]
    assert labels == ["state of servo.slide of slider [m]", "state of servo.slide rate of slider [m/s]"]
    assert np.array_equal(figure.axes[1].lines[0].get_ydata(), z[:, 1])
    with pytest.raises(ValueError, match="no internal states"):
        simulate(cart(tau=None)[0], 0.1).plot("state")


def test_own_states_can_be_given():
    system, slider, servo, axis = cart()
    start, given = system.state(), (0.8, -1.1)
    assert np.array_equal(start.z, REFERENCE)
    assert np.array_equal(system.assemble(slides={slider: 0.1}).z, REFERENCE)
    solution = simulate(system, 1.0, state=State(0.0, start.q, start.v, given), rtol=RTOL, output=11)
    x, z1, *_ = by_hand(axis, solution.t, given)
    assert solution.slide(slider) == pytest.approx(x, abs=AGREES)
    assert solution.state_of("servo")[:, 0] == pytest.approx(z1, abs=AGREES)


def test_states_that_are_not_given_start_as_declared():
    system, *_ = cart()
    start = system.state()
    whole, bare = (simulate(system, 0.5, state=State(0.0, start.q, start.v, z)) for z in (start.z, ()))
    assert np.array_equal(whole.final.z, bare.final.z) and np.abs(bare.final.z).max() > 0.0
    with pytest.raises(ValueError, match="3 internal states, the forces of the system have 2"):
        simulate(system, 0.5, state=State(0.0, start.q, start.v, (1.0, 2.0, 3.0)))


def test_runs_go_on_from_where_they_ended(tmp_path):
    system, slider, servo, axis = cart()
    first = simulate(system, 0.8, rtol=RTOL)
    second = simulate(system, 2.0, state=first.final, rtol=RTOL)
    x, z1, z2, _ = by_hand(axis, np.array([0.0, 1.3, 2.0]))
    assert second.final.z == pytest.approx([z1[-1], z2[-1]], abs=AGREES)
    assert second.at(1.3).z == pytest.approx([z1[1], z2[1]], abs=AGREES)
    again = load(second.save(tmp_path / "cart"))
    assert np.array_equal(again.state_of("servo"), second.state_of(servo))
    assert np.array_equal(again.final.z, second.final.z)
    assert again.certificate.passed
    further = simulate(again.system, 2.5, state=again.final, rtol=RTOL)
    assert np.array_equal(further.final.z, simulate(system, 2.5, state=second.final, rtol=RTOL).final.z)


def test_feedback_of_the_angle_is_a_spring_over_many_turns():
    rng = np.random.default_rng(3)
    body, axis, at = random_body(rng, "rotor"), direction(rng), rng.normal(size=3)
    found = []
    for spring in (False, True):
        hinge = Revolute(GROUND, body, at=at, axis=axis)
        seen = [measures.angle(hinge), measures.rate(hinge)]
        force = (
            TorsionSpring(hinge, stiffness=0.6, damping=0.05, angle=20.0)
            if spring
            else StateFeedback(measures=seen, gains=(0.6, 0.05), on=hinge, reference=(20.0, 0.0))
        )
        system = System([body], [hinge], [force])
        solution = simulate(system, 8.0, state=system.assemble(rates={hinge: 5.0}), rtol=RTOL, output=31)
        assert solution.certificate.passed  # the check of the equations counts turns, too
        found.append(solution.angle(hinge))
    assert found[1].max() > 6 * np.pi
    assert found[0] == pytest.approx(found[1], abs=10 * AGREES)  # tens of radians


def two_arms():
    """(system, first hinge, outer body, servo): a double pendulum whose root sees point, spin and lean of the tip."""
    rng = np.random.default_rng(5)
    arm, tip = random_body(rng, "arm"), random_body(rng, "tip")
    root = Revolute(GROUND, arm, at=(0.1, 0.2, 0.3), axis=direction(rng), name="root")
    elbow = Revolute(arm, tip, at=(0.6, -0.4, 0.5), axis=direction(rng), name="elbow")
    seen = [
        measures.velocity(tip, axis=AXIS, at=POINT),
        measures.omega(tip, axis=AXIS),
        measures.lean(tip, lateral=(0.3, 0.8, 0.2)),
        measures.lean_rate(tip, lateral=(0.3, 0.8, 0.2)),
    ]
    servo = StateFeedback(measures=seen, gains=(0.7, -0.4, 1.1, 0.3), on=root, reference=(0.2, 0.1, -0.3, 0.5))
    return System([arm, tip], [root, elbow], [servo]), root, tip, servo


AXIS, POINT = np.array([2.0, -1.0, 0.5]) / np.sqrt(5.25), np.array([0.9, -0.2, 0.1])


def test_load_is_the_weighted_sum_of_what_is_seen():
    system, root, tip, servo = two_arms()
    solution = simulate(system, 1.5, rtol=1e-10, output=21)
    arm = solution.rotation(tip) @ tip.local_point(POINT)
    velocity = (solution.velocity(tip) + np.cross(solution.omega(tip), arm)) @ AXIS
    lateral = solution.rotation(tip) @ tip.local_axis(np.array([0.3, 0.8, 0.2]) / np.linalg.norm([0.3, 0.8, 0.2]))
    lean = np.arcsin(lateral[:, 2])
    lean_rate = np.cross(solution.omega(tip), lateral)[:, 2] / np.cos(lean)
    load = -0.7 * (velocity - 0.2) + 0.4 * (solution.omega(tip) @ AXIS - 0.1) - 1.1 * (lean + 0.3)
    load -= 0.3 * (lean_rate - 0.5)
    assert np.ptp(load) > 1.0
    power = solution.arrays["power"][:, 0]
    assert power == pytest.approx(load * solution.rate(root), abs=1e-12)  # rounding: the same state, other formulas
    assert solution.certificate.passed


def test_errors_of_own_states_are_judged_alike_at_any_size():
    """Metres and metres per second grow with all lengths and with the speed, radians and radians per second do not."""
    scales = []
    for size in (1.0, 50.0):
        body = random_body(np.random.default_rng(7), com=size * np.array((0.1, 0.2, -0.1)), position=(0, 0, 0))
        bore = Cylindrical(GROUND, body, at=size * np.array((0.4, -0.1, 0.3)), axis=(0.2, 1.0, 0.3))
        seen = [f(bore) for f in (measures.angle, measures.slide, measures.rate, measures.slide_rate)]
        servo = StateFeedback(measures=seen, gains=np.ones(4), on=bore, time_constant=TAU)
        own = compile_system(System([body], [bore], [servo])).model.state[:4]
        scales.append(own["unit"] * (3.0 * size) ** own["power"])  # at 3 m/s in the one, 150 m/s in the other
    assert scales[1] / scales[0] == pytest.approx([1.0, 50.0, 1.0, 50.0], rel=1e-14)


def swing(gain, name="servo"):
    """A pendulum under feedback of its angle."""
    rng = np.random.default_rng(6)
    body = random_body(rng, "bob", position=(0.4, 0.2, -1.0))
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(0.2, 1.0, 0.3))
    force = StateFeedback(measures=[measures.angle(hinge)], gains=[gain], on=hinge, name=name)
    return System([body], [hinge], [force])


@pytest.mark.parametrize(
    "make", [lambda: swing(-400.0), lambda: cart(None, (-400.0, -8.0))[0]], ids=["hinge", "slider"]
)
def test_a_gain_that_blows_up_is_named(make):
    with pytest.raises(IntegrationError, match="grows without end.*force 'servo'.*gains") as caught:
        simulate(make(), 1e3)
    assert caught.value.solution.record.evaluations < 200_000  # 23 000 and 1000, of a run of 1000 s
    assert caught.value.solution.t.size > 10 and np.isfinite(caught.value.solution.arrays["q"]).all()


def test_steady_feedback_and_long_runs_are_not_blamed():
    rng = np.random.default_rng(8)
    body = Body("wheel", 1.2, (0.2, 0.3, 0.25), com=(0.1, 0.05, -0.02))
    hinge = Revolute(GROUND, body, at=(0.1, 0.05, -0.02), axis=direction(rng))
    speed = StateFeedback(measures=[measures.rate(hinge)], gains=[2.0], on=hinge, reference=[3000.0], time_constant=0.1)
    system = System([body], [hinge], [speed], gravity=(0, 0, 0))
    start = system.state()
    solution = simulate(system, 8.0, state=State(0.0, start.q, start.v, [0.0]), output=3)  # from rest, many turns
    assert solution.angle(hinge)[-1] > 1e4 and solution.certificate.passed


HINGE = Revolute(GROUND, Body("one", 1.0, (1, 1, 1), position=(0.3, 0, 0)), at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
OTHER = Body("stranger", 1.0, (1, 1, 1))


def feedback(**changes):
    """A feedback with some argument wrong."""
    given = dict(measures=[measures.angle(HINGE), measures.rate(HINGE)], gains=(1.0, 2.0), on=HINGE, name="servo")
    return StateFeedback(**(given | changes))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: feedback(gains=(1.0,)), r"servo.*gains: 1 value for 2 measures"),
        (lambda: feedback(gains=(1.0, np.nan)), r"servo.*gains no. 2: not finite"),
        (lambda: feedback(gains=3.0), r"servo.*gains: 3.0 is not a sequence"),
        (lambda: feedback(reference=(1.0, 2.0, 3.0)), r"servo.*reference: 3 values for 2 measures"),
        (lambda: feedback(time_constant=0.0), r"servo.*time_constant: 0.0 is not positive"),
        (lambda: feedback(measures=["angle", "rate"]), r"servo.*'angle' is not a measure"),
        (lambda: feedback(measures=[], gains=[]), r"servo.*no measures"),
        (lambda: feedback(on=OTHER), r"servo.*no angle and no slide"),
        (lambda: measures.state(feedback()), r"servo has no internal state 0; give a force"),
        (lambda: measures.state(feedback(time_constant=1.0), 2), r"servo has no internal state 2; give one of "),
        (lambda: System([HINGE.b], [], [feedback()]), r"servo.*'hinge' is not in the system"),
        (
            lambda: System(
                [HINGE.b], [HINGE], [feedback(measures=[measures.lean(OTHER)], gains=[1.0])]
            ),
            r"servo.*'stranger' is not in the system",
        ),
        (
            lambda: simulate(
                System([HINGE.b], [HINGE]), 1.0, stop_when=measures.state(feedback(time_constant=1.0)) > 2.0
            ),
            r"stop_when.*force 'servo' is not in the system",
        ),
    ],
)  # fmt: skip
def test_bad_input_is_named(make, message):
    with pytest.raises(ValueError, match=message):
        make()
