"""Couplers: closed forms of two slides, many turns, slopes of zero, sums of coordinates, engaging, files, refusals."""

import numpy as np
import pytest
from numpy.polynomial import polynomial as poly

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Coupler,
    Cylindrical,
    Gear,
    Kinematic,
    Prismatic,
    RackPinion,
    Ramp,
    Revolute,
    System,
    TorsionSpring,
    accelerations,
    rotation,
    simulate,
)

CUBIC = (0.2, 0.5, -0.3, 0.4)
TURN = rotation((1, 2, -1), 0.7)


def bodies(count=3):
    rng = np.random.default_rng(7)
    return [
        Body(f"body {k}", 1.0 + k, 0.05 * np.array([2.0, 3.0, 4.0]), com=0.1 * rng.normal(size=3),
             position=rng.normal(size=3), orientation=TURN)
        for k in range(count)
    ]  # fmt: skip


def slides(coefficients=CUBIC, m1=2.0, m2=3.0, **more):
    """A slide x that its weight pulls down, and a level slide y that follows it."""
    one, two = Body("one", m1, (0.1, 0.1, 0.2)), Body("two", m2, (0.1, 0.1, 0.2), position=(0.3, 0.2, 0.1))
    x = Prismatic(GROUND, one, at=(0, 0, 0), axis=(0, 0, -1), name="x")
    y = Prismatic(GROUND, two, at=(0.3, 0.2, 0.1), axis=(3, 4, 0), name="y")
    return System([one, two], [x, y, Coupler(x, y, coefficients=coefficients, name="link", **more)]), x, y


@pytest.mark.parametrize("c", [CUBIC, (0.0, 0.0, 0.6), (-0.1, 0.3, 0.2, 0.1, -0.4, 0.3)])
def test_two_slides_move_as_energy_says(c):
    """(m1 + m2 c'^2) v^2 / 2 = m1 g x; the force is m2 (c' a + c'' v^2)."""
    m1, m2, g = 2.0, 3.0, 9.81
    system, x, y = slides(c)
    start = system.assemble(slides={x: 0.0})
    run = simulate(system, 0.45, state=start, rtol=1e-11)
    way, speed = run.slide(x), run.rate(x)
    slope, bend = (poly.polyval(way, poly.polyder(c, k)) for k in (1, 2))
    inertia = m1 + m2 * slope**2
    assert np.allclose(
        inertia * speed**2, 2 * m1 * g * way, rtol=2e-8, atol=1e-15
    )  # atol: where it starts, at rounding
    a = (m1 * g - m2 * slope * bend * speed**2) / inertia  # Lagrange
    assert np.allclose(run.slide(y), poly.polyval(way, c), rtol=0, atol=1e-13)
    force = run.reaction("link").force @ np.array([0.6, 0.8, 0.0])
    assert np.allclose(force, m2 * (slope * a + bend * speed**2), rtol=1e-7, atol=1e-9)
    assert np.abs(np.cross(run.reaction("link").force, (0.6, 0.8, 0.0))).max() < 1e-9
    assert run.certificate.passed


def test_the_follower_rests_where_the_slope_is_zero():
    """y = (x - 0.3)^2 turns round at x = 0.3 while x goes on."""
    system, x, y = slides((0.09, -0.6, 1.0))
    run = simulate(system, 0.4, state=system.assemble(slides={x: 0.0}), rtol=1e-10, output=200)
    assert run.slide(x)[-1] > 0.31 and abs(run.slide(y).min()) < 1e-4
    assert run.certificate.passed
    flat, x, y = slides((0.2,))  # x moves alone
    assert flat.check().mobility == 1
    fall = simulate(flat, 0.3, state=flat.assemble(slides={x: 0.0}))
    assert abs(fall.slide(x)[-1] - 0.5 * 9.81 * 0.3**2) < 1e-9 and np.abs(fall.slide(y) - 0.2).max() < 1e-13


def test_many_turns_are_counted():
    """A driver turns a hinge by seven turns; a slide and another hinge follow polynomials of it."""
    wheel, rack, other = bodies()
    hinge = Revolute(GROUND, wheel, at=wheel.position, axis=(1, 2, 2), name="hinge")
    rail = Prismatic(GROUND, rack, at=rack.position, axis=(2, -1, 1), name="rail")
    second = Revolute(rack, other, at=other.position, axis=(0, 1, 3), name="second")
    links = [Coupler(hinge, rail, coefficients=(0, 0.01, 0.002)), Coupler(hinge, second, coefficients=(0, 0.5, -0.03))]
    system = System([wheel, rack, other], [hinge, rail, second, *links, AngleDriver(hinge, Ramp(44.0))])
    run = simulate(system, 1.0, method=Kinematic(), output=50)
    assert np.abs(run.slide(rail) - poly.polyval(run.angle(hinge), (0, 0.01, 0.002))).max() < 1e-11
    assert np.abs(run.angle(second) - poly.polyval(run.angle(hinge), (0, 0.5, -0.03))).max() < 1e-11
    assert run.angle(second).min() < -36 and run.certificate.passed
    free = System([wheel, rack, other], [hinge, rail, second, *links])
    placed = free.assemble(angles={hinge: 20.0})
    assert np.abs(accelerations(free, placed).angle(second)[0] - (10.0 - 12.0)) < 1e-11


def test_of_the_first_degree_it_is_a_gear_or_a_rack():
    a, b, c = bodies()
    first = Cylindrical(GROUND, a, at=a.position, axis=(1, 0.2, 0.1), name="first")
    second = Revolute(a, b, at=b.position, axis=(0.3, 1, 0), name="second")
    rail = Prismatic(b, c, at=c.position, axis=(0.1, 0.2, 1), name="rail")
    held = TorsionSpring(rail, stiffness=30.0)

    def moved(*links):
        system = System([a, b, c], [first, second, rail, *links], [held])
        return accelerations(system), links

    gear = Gear(first, second, ratio=-1.7, name="one"), RackPinion(second, rail, radius=0.3, name="two")
    other = (
        Coupler(first, second, coefficients=(0, -1.7), name="one"),
        Coupler(second, rail, coefficients=(0, 0.3), name="two"),
    )
    (left, _), (right, _) = moved(*gear), moved(*other)
    for body in (a, b, c):
        assert np.allclose(left.acceleration(body), right.acceleration(body), rtol=1e-12, atol=1e-12)
    for name in ("one", "two"):
        assert np.allclose(left.reaction(name).moment, right.reaction(name).moment, rtol=1e-11, atol=1e-12)
        assert np.allclose(left.reaction(name).force, right.reaction(name).force, rtol=1e-11, atol=1e-12)


def test_a_differential_shares_its_torque():
    """(left + right) / 2 = input: the same torque on both wheels, whatever their speeds."""
    shaft, left, right = (Body(n, 1.0, (i, i, i)) for n, i in (("shaft", 0.1), ("left", 0.2), ("right", 0.5)))
    hinges = [Revolute(GROUND, b, at=(k, 0, 0), axis=(1, 0, 0)) for k, b in enumerate((shaft, left, right))]
    box = Coupler(hinges[0], hinges[1:], y_weights=(0.5, 0.5), coefficients=(0, 1.0), name="box")
    wound = TorsionSpring(hinges[0], stiffness=3.0, angle=1.0)
    system = System([shaft, left, right], [*hinges, box], [wound], gravity=(0, 0, 0))
    assert system.check().mobility == 2
    now = accelerations(system)
    rates = [float(now.alpha(b)[0, 0]) for b in (shaft, left, right)]
    T = 3.0 / (1 + 0.1 * (0.5 / 0.2 + 0.5 / 0.5) / 2)  # on the box; half of it on each wheel
    assert np.allclose(rates, [(3.0 - T) / 0.1, T / 2 / 0.2, T / 2 / 0.5], rtol=1e-12, atol=0)


def test_both_coordinates_of_a_cylinder():
    """slide = pitch angle / (2 pi) of a Cylindrical is a screw; the chosen coordinates may be of one joint."""
    nut = bodies(1)[0]
    guide = Cylindrical(GROUND, nut, at=nut.position, axis=(1, 2, 2), name="guide")
    thread = Coupler(guide, guide, y_of="slide", coefficients=(0, 0.3), name="thread")
    system = System([nut], [guide, thread])
    run = simulate(system, 1.5, rtol=1e-10)
    assert np.abs(run.slide(guide) - 0.3 * run.angle(guide)).max() < 1e-12 and abs(run.angle(guide)[-1]) > 2 * np.pi
    assert run.certificate.passed


def test_a_coupler_that_engages_keeps_its_offset():
    system, x, y = slides(CUBIC)
    free = System(system.bodies, system.joints[:2])
    run = simulate(free, 0.2)
    joined = free.engage(Coupler(x, y, coefficients=(0, 0.5, 0.7), name="late"), run.final)
    after = simulate(joined.system, 0.3, state=joined.state)
    offset = run.slide(y)[-1] - poly.polyval(run.slide(x)[-1], (0, 0.5, 0.7))
    assert np.abs(after.slide(y) - poly.polyval(after.slide(x), (offset, 0.5, 0.7))).max() < 1e-12


def test_files_keep_it(tmp_path):
    system, x, y = slides(CUBIC, x_weights=(2.0,), y_of="slide")
    system.to_file(tmp_path / "model.json")
    again = System.from_file(tmp_path / "model.json")
    assert again.joints[2].coefficients == CUBIC and again.joints[2].x == (again.joints[0],)
    assert again.joints[2].x_weights == (2.0,) and again.joints[2].y_of == ("slide",)


A, B, C = (Body(name, 1.0, (0.1, 0.1, 0.1), position=(k, 0, 0)) for k, name in enumerate("abc"))
HINGE = Revolute(GROUND, A, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
RAIL = Prismatic(A, B, at=(1, 0, 0), axis=(1, 0, 0), name="rail")
LAST = Revolute(B, C, at=(2, 0, 0), axis=(0, 0, 1), name="last")
ROD = Cylindrical(A, C, at=(2, 0, 0), axis=(1, 0, 0), name="rod")
D = Body("d", 1.0, (0.1, 0.1, 0.1), position=(3, 0, 0))
FOURTH = Revolute(C, D, at=(3, 0, 0), axis=(0, 0, 1), name="fourth")
WRONG = {
    "no coefficient": (lambda: Coupler(HINGE, RAIL, coefficients=()), "0 coefficients for 1 joint of x; give c0"),
    "no leader": (lambda: Coupler((), RAIL, coefficients=(0, 1.0)), "2 coefficients for 0 joints of x"),
    "no follower": (lambda: Coupler(HINGE, (), coefficients=(0, 1.0)), "y has no joint"),
    "twice": (lambda: Coupler(HINGE, (RAIL, HINGE), coefficients=(0, 1.0)), "the angle of 'hinge' is given twice"),
    "kind": (lambda: Coupler(HINGE, RAIL, y_of="angle", coefficients=(0, 1.0)), "'rail'.* has no angle"),
    "unknown": (lambda: Coupler(HINGE, RAIL, y_of="turn", coefficients=(0, 1.0)), "y_of.*'turn'"),
    "kinds": (lambda: Coupler(HINGE, RAIL, y_of=("slide", "slide"), coefficients=(0, 1.0)), "2 coordinates for"),
    "weights": (lambda: Coupler(HINGE, RAIL, y_weights=(1.0, 2.0), coefficients=(0, 1.0)), "weights of y.*per joint"),
    "weight 0": (lambda: Coupler(HINGE, RAIL, x_weights=(0.0,), coefficients=(0, 1.0)), "weights of x.*none of them 0"),
    "a body": (lambda: Coupler(A, RAIL, coefficients=(0, 1.0)), "a joint or a list of joints"),
    "coordinates": (
        lambda: Coupler((ROD, ROD), (HINGE, RAIL, LAST), x_of=("angle", "slide"), coefficients=(0, 1.0)),
        "5 coordinates; give at most 4",
    ),
    "bodies": (lambda: Coupler(HINGE, (RAIL, LAST, FOURTH), coefficients=(0, 1.0)), "5 bodies, .*give at most 4"),
}  # fmt: skip


@pytest.mark.parametrize("case", WRONG)
def test_bad_input_is_refused(case):
    make, message = WRONG[case]
    with pytest.raises(ValueError, match=message):
        make()
