"""Measures over a run against scipy's rotations, and the same measures as stops, outputs, targets and curves."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.models import direction, random_body
from scipy.spatial.transform import Rotation

from mbsd3d import (
    DOP853,
    GROUND,
    Body,
    Force,
    Prismatic,
    Revolute,
    Spherical,
    SpringDamper,
    StateFeedback,
    System,
    TorsionSpring,
    linearize,
    load,
    measures,
    simulate,
)

ROUNDING = 1e-12  # of values of size 1 to 10, after a rotation or two


def tumbling():
    """Two free bodies and a spring between them, on their way through general poses."""
    rng = np.random.default_rng(3)
    a, b = (replace(random_body(rng, x), velocity=direction(rng), omega=2.0 * direction(rng)) for x in "ab")
    ends = dict(at_a=a.position + 0.3 * direction(rng), at_b=b.position + 0.2 * direction(rng))
    spring = SpringDamper(a, b, **ends, stiffness=2.0, name="spring")
    return System([a, b], forces=[spring], gravity=(0.1, 0.2, -9.0))


@pytest.fixture(scope="module")
def run():
    return simulate(tumbling(), 0.8, output=161)


def turned(run, name):
    """(samples, 3, 3) rotation from the reference pose."""
    body = run.system.part(name)
    now, first = (Rotation.from_quat(x, scalar_first=True) for x in (run.orientation(name), body.orientation))
    return (now * first.inv()).as_matrix()


def protractor(run, axis, zero, axis_b, first):
    """Angle in the plane across ``axis`` fixed in a, unwrapped from ``first`` on."""
    A, B = turned(run, "a"), turned(run, "b")
    seen = np.einsum("tji,tj->ti", A, B @ axis_b)
    x = zero - axis * (axis @ zero)
    x /= np.linalg.norm(x)
    angle = np.unwrap(np.arctan2(seen @ np.cross(axis, x), seen @ x))
    return angle + 2 * np.pi * np.round((first - angle[0]) / (2 * np.pi))


def test_angles_and_offsets_by_hand(run):
    rng = np.random.default_rng(11)
    a, b = run.system.bodies
    u, v, n = direction(rng), direction(rng), direction(rng)
    between = measures.angle_between(a, b, axis_a=u, axis_b=v)
    found = run.measure(between)
    assert found[0] == pytest.approx(np.arccos(u @ v), abs=ROUNDING)
    normal = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
    assert found == pytest.approx(protractor(run, normal, u, v, found[0]), abs=ROUNDING)
    about = run.measure(measures.angle_between(a, b, axis_a=u, axis_b=v, about=n))
    assert about == pytest.approx(protractor(run, n, u, v, about[0]), abs=ROUNDING)
    assert -np.pi <= about[0] <= np.pi
    at_a, at_b = a.position + 0.3 * u, b.position - 0.2 * v
    A, B = turned(run, "a"), turned(run, "b")
    p = run.position(a) + A @ (at_a - a.position)
    q = run.position(b) + B @ (at_b - b.position)
    offset = run.measure(measures.offset(a, b, along=n, at_a=at_a, at_b=at_b))
    assert offset == pytest.approx(np.einsum("ti,ti->t", A @ n, q - p), abs=ROUNDING)
    spring = run.system.forces[0]
    assert run.measure(measures.length(spring)) == pytest.approx(run.force(spring).length, abs=ROUNDING)


def test_heading_and_camber_by_hand(run):
    b, forward, axle = run.system.part("b"), np.array([0.8, 0.5, 0.33]), np.array([-0.2, 0.9, 0.4])
    ahead = turned(run, "b") @ (forward / np.linalg.norm(forward))
    expected = np.unwrap(np.arctan2(ahead[:, 1], ahead[:, 0]))
    assert run.measure(measures.heading(b, forward=forward)) == pytest.approx(expected, abs=ROUNDING)
    side = turned(run, "b") @ (axle / np.linalg.norm(axle))
    assert run.measure(measures.camber(b, axle=axle)) == pytest.approx(np.arcsin(side[:, 2]), abs=1e-10)


def test_rates_are_the_slopes_of_values(run):
    """Central differences over 1e-5 s: error of the third derivative, some 1e3, times 1e-10 / 6."""
    a, b = run.system.bodies
    h, axis = 1e-5, np.array([0.36, 0.48, 0.8])
    near = simulate(run.system, 0.3 + h, rtol=1e-12, output=[0.3 - h, 0.3, 0.3 + h], method=DOP853())
    pairs = [
        (measures.heading(b), measures.heading_rate(b)),
        (measures.turn(a, b, about=axis), measures.turn_rate(a, b, about=axis)),
        (measures.offset(a, b, along=axis), measures.offset_rate(a, b, along=axis)),
    ]
    for value, rate in pairs:
        x = near.measure(value)
        assert (x[2] - x[0]) / (2 * h) == pytest.approx(near.measure(rate)[1], abs=1e-6), value


def test_the_pose_between_bodies(run):
    a, b = run.system.bodies
    pose = measures.between(a, b)
    assert list(pose) == ["x", "y", "z", "turn_x", "turn_y", "turn_z"]
    values = run.measure(list(pose.values()))
    A, gap = turned(run, "a"), run.com(b) - run.com(a)
    assert values[:, :3] == pytest.approx(np.einsum("tji,tj->ti", A, gap), abs=ROUNDING)
    assert values[0, 3:] == pytest.approx(0.0, abs=ROUNDING)
    single = System([Body("rod", 1.0, (0.1, 0.2, 0.2), omega=(0, 0, 5.0))], gravity=(0, 0, 0))
    spin = simulate(single, 4.0, output=81)  # three turns
    turn = spin.measure(measures.between(GROUND, single.bodies[0])["turn_z"])
    limit = 1e-8 * spin.certificate.steps  # every step keeps rtol
    assert turn == pytest.approx(5.0 * spin.t, abs=limit)
    assert spin.measure(measures.heading(single.bodies[0])) == pytest.approx(5.0 * spin.t, abs=limit)


def test_measures_agree_with_what_a_run_says_itself():
    rng = np.random.default_rng(4)
    rod = random_body(rng, "rod")
    hinge = Revolute(GROUND, rod, at=rod.position + 0.4 * direction(rng), axis=direction(rng), name="hinge")
    spring = TorsionSpring(hinge, stiffness=0.0)
    spun = simulate(System([rod], [hinge], [spring]), 8.0, output=9)  # whole turns between samples
    assert np.array_equal(spun.measure(measures.angle(hinge)), spun.angle(hinge))
    assert spun.measure(measures.rate(hinge)) == pytest.approx(spun.rate(hinge), abs=ROUNDING * 10)
    axis = direction(rng)
    assert spun.measure(measures.position(rod, axis=axis)) == pytest.approx(spun.com(rod) @ axis, abs=ROUNDING)
    assert spun.measure(measures.omega(rod, axis=axis)) == pytest.approx(spun.omega(rod) @ axis, abs=ROUNDING * 10)


def test_new_measures_stop_runs_and_are_fed_back_and_met(run):
    a, b = run.system.bodies
    limit = float(run.measure(measures.heading(b))[0]) + 0.3
    stopped = simulate(run.system, 5.0, stop_when=measures.heading(b) > limit)
    assert stopped.measure(measures.heading(b))[-1] == pytest.approx(limit, abs=1e-9)
    near = run.system.assemble(measures={measures.offset(a, b, along=(0, 0, 1)): 1.5})
    there = simulate(run.system, 0.1, state=near, output=2)
    assert there.measure(measures.offset(a, b, along=(0, 0, 1)))[0] == pytest.approx(1.5, abs=1e-8)
    a = replace(a, velocity=None, omega=None)
    slide = Prismatic(GROUND, a, at=a.position, axis=(1, 0, 0), name="slide")
    servo = StateFeedback(measures=[measures.heading(b)], gains=[3.0], on=slide, name="servo")
    fed = simulate(System([a, b], [slide], [servo]), 0.4, output=5)
    assert fed.force("servo").force @ (1, 0, 0) == pytest.approx(-3.0 * fed.measure(measures.heading(b)), abs=1e-10)


def test_a_heading_is_an_output_of_linearize():
    """A boat on a torsion spring about z: the output has the frequency of the spring."""
    boat = Body("boat", 2.0, (0.1, 0.3, 0.4))
    pin = Revolute(GROUND, boat, at=(0, 0, 0), axis=(0, 0, 1), name="pin")
    system = System([boat], [pin], [TorsionSpring(pin, stiffness=1.6)])
    outputs = [measures.heading(boat), measures.heading_rate(boat)]
    found = linearize(system, outputs=outputs)
    np.testing.assert_allclose(found.A, [[0, 1], [-1.6 / 0.4, 0]], rtol=0, atol=1e-12)


def test_curves_are_measures_too(run, tmp_path):
    a, b = run.system.bodies
    gap, ahead = measures.distance(a, b), measures.heading(b)
    assert run.plot(gap).axes[0].get_ylabel() == "distance a to b [m]"
    both = run.plot(["energy", ahead, (gap, measures.length(run.system.forces[0]))])
    assert [x.get_ylabel() for x in both.axes] == ["energy [J]", "heading of b [rad]", "measures [m]"]
    assert np.array_equal(both.axes[1].lines[0].get_ydata(), run.measure(ahead))
    assert run.plot(ahead, degrees=True).axes[0].get_ylabel() == "heading of b [°]"
    assert "heading of b" in str(run.report(curves=[ahead]).html)
    again = load(run.save(tmp_path / "run"))
    bodies = [again.system.part(name) for name in "ab"]
    assert np.array_equal(again.measure(measures.distance(*bodies)), run.measure(gap))


def test_slips_are_named(run):
    a, b = run.system.bodies
    other = Body("other", 1.0, (1, 1, 1))
    with pytest.raises(ValueError, match="body 'other' is not in the system"):
        run.measure(measures.distance(a, other))
    with pytest.raises(ValueError, match="solution.measure: 'distance' is not a measure"):
        run.measure("distance")
    with pytest.raises(ValueError, match="parallel at the reference pose; give the axis as about="):
        measures.angle_between(a, b, axis_a=(1, 2, 3), axis_b=(1, 2, 3))
    with pytest.raises(ValueError, match=r"measures.heading: \[0.0, 0.0, 1.0\] lies along the axis"):
        measures.heading(b, forward=(0, 0, 2))
    with pytest.raises(ValueError, match="'b' is not a body; give a Body"):
        measures.turn(a, "b", about=(0, 0, 1))
    with pytest.raises(ValueError, match="is not a SpringDamper or ForceCurve; use measures.distance"):
        measures.length(a)
    with pytest.raises(ValueError, match="'energy' is not a measure, as others in the list are"):
        run.plot([(measures.distance(a, b), "energy")])


def test_names_of_the_module_are_measures_alone():
    found = [value for name, value in vars(measures).items() if not name.startswith("__")]
    assert len(found) > 20
    assert all(value.__module__.startswith("mbsd3d.mechanism.") and value.__doc__ for value in found)


def test_force_and_joint_are_untouched_by_measures():
    """A measure adds no row and no force: the same run with and without a stop that never comes."""
    rng = np.random.default_rng(9)
    bob = random_body(rng, "bob")
    system = System([bob], [Spherical(GROUND, bob, at=(0.1, 0.2, 0.9))], [Force(bob, (0.3, 0, 0))])
    plain = simulate(system, 0.5, output=3)
    watched = simulate(system, 0.5, output=3, stop_when=measures.heading(bob) > 1e3)
    assert np.array_equal(plain.position(bob), watched.position(bob))


def test_measures_take_numbers_as_factors_and_summands(run):
    height = measures.position(run.system.part("a"), axis=(0.2, 0.3, -1.0))
    values = run.measure(height)
    for made, known in (
        (2.5 * height, 2.5 * values), (height * np.float64(2.5), 2.5 * values), (-height / 4.0, -values / 4.0),
        (3.0 * (height + 0.25), 3.0 * values + 0.75), (1.0 - 2.0 * height, 1.0 - 2.0 * values),
    ):  # fmt: skip
        assert made.unit == "m" and run.measure(made) == pytest.approx(known, rel=1e-14, abs=1e-14)
    both = run.measure([height, 2.0 * height])
    assert np.array_equal(both[:, 1], 2.0 * both[:, 0])
    assert run.plot(2.0 * height - 1.0).axes[0].get_ylabel().split()[:2] == ["2", "x"]


def test_conditions_on_scaled_measures_stop_where_the_plain_ones_do():
    system = tumbling()
    height = measures.position(system.part("a"), axis=(0.0, 0.0, 1.0))
    level = simulate(system, 0.8, output=9).measure(height)[4]
    plain = simulate(system, 0.8, stop_when=height < level)
    for condition in (3.0 * height - 0.5 < 3.0 * level - 0.5, 1.0 - height > 1.0 - level):
        assert simulate(system, 0.8, stop_when=condition).t[-1] == pytest.approx(plain.t[-1], rel=1e-12, abs=0.0)
    assert 0.0 < plain.t[-1] < 0.8


def test_what_measures_do_not_take_says_so(run):
    height = measures.position(run.system.part("a"), axis=(0.0, 0.0, 1.0))
    spin = measures.omega(run.system.part("a"), axis=(0.0, 0.0, 1.0))
    for wrong, text in (
        (lambda: height * 0.0, r"\* 0 is 0 whatever the motion"), (lambda: height / 0, "give another divisor"),
        (lambda: height + spin, "combines with numbers only"), (lambda: height * "x", "expected a number, got 'x'"),
        (lambda: (height > 1.0) & (spin < 2.0), "single comparison: run to the first one"),
        (lambda: (height > 1.0) | (spin < 2.0), "joined by & or |"),
        (lambda: linearize(run.system, run.state(0), outputs=[2.0 * height]), "scale gains or results"),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=text):
            wrong()
