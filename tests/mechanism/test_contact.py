"""Contacts that press, rub and lift off, against closed forms; and surfaces that roll, against other descriptions."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.models import direction, random_body
from scipy.optimize import brentq

from mbsd3d import (
    DOP853,
    GROUND,
    Body,
    Contact,
    RadauIIA,
    Revolute,
    Rolling,
    RollingDisc,
    System,
    accelerations,
    linearize,
    load,
    measures,
    rotation,
    shapes,
    simulate,
)
from mbsd3d.rotations import matrix

STIFF = DOP853(stiff="run")


def ball(radius=0.1, mass=2.0, position=(0, 0, 0.1), **fields):
    return Body("ball", mass, (0.4 * mass * radius**2,) * 3, position=position, **fields)


@pytest.mark.parametrize(("m", "k", "c", "h"), [(20.0, 150e3, 300.0, 0.1), (3.7, 41e3, 120.0, 0.043)])
def test_a_wheel_that_is_dropped_bounces_as_the_linear_spring_says(m, k, c, h):
    g, r = 9.81, 0.3
    wheel = ball(r, m, (0.2, -0.1, r + h), velocity=(0, 0, 0), omega=(0, 0, 0))
    road = Contact(GROUND, wheel, shapes.Sphere(r), stiffness=k, damping=c, name="road")
    system = System([wheel], forces=[road], gravity=(0, 0, -g))
    fall = simulate(system, 1.0, rtol=1e-10, stop_when=measures.touches(road))
    up = simulate(system, 2.0, state=fall.final, rtol=1e-10, stop_when=measures.leaves(road))
    impact, delta = np.sqrt(2 * g * h), c / (2 * m)
    rate = np.sqrt(k / m - delta**2)

    def press(t):  # of m x'' = m g - k x - c x'
        b = (impact - delta * m * g / k) / rate
        decay, s, co = np.exp(-delta * t), np.sin(rate * t), np.cos(rate * t)
        x = m * g / k + decay * (b * s - m * g / k * co)
        x_dot = -delta * decay * (b * s - m * g / k * co) + decay * rate * (b * co + m * g / k * s)
        return x, x_dot

    ends = brentq(lambda t: np.dot((k, c), press(t)), 2.0 / rate, 4.0 / rate, xtol=1e-15)
    x, x_dot = press(ends)
    assert fall.final.t == pytest.approx(np.sqrt(2 * h / g), rel=1e-9)
    assert up.final.t - fall.final.t == pytest.approx(ends, rel=1e-8)
    assert up.velocity(wheel)[-1, 2] == pytest.approx(-x_dot, rel=1e-8)
    if m == 20.0:  # found by another program
        assert up.velocity(wheel)[-1, 2] / impact == pytest.approx(0.759947801207112, rel=1e-8)
    assert up.measure(measures.clearance(road))[-1] == pytest.approx(-x, rel=1e-6)
    assert up.certificate.passed
    # it lets go while the spring is still pressed: nothing pulls
    assert x > 0 and simulate(system, 1.0, rtol=1e-8).measure(measures.normal_force(road)).min() == 0.0


def test_restitution_by_hunt_and_crossley_depends_on_the_speed_alone():
    """v - ln(1 + x v) / x is the same on the way in and out, whatever k, exponent and mass."""
    rng = np.random.default_rng(2)
    normal, loss, speed = direction(rng), 0.3, 1.7
    body = random_body(rng, "egg", com=(0, 0, 0))
    centre = body.position
    egg = Body("egg", 1.4, (0.1, 0.2, 0.25), position=centre, velocity=-speed * normal, omega=(0, 0, 0))
    form = shapes.Sphere(0.3)  # centred: no moment
    plane = (centre - 0.35 * normal + np.cross(normal, (0.3, 0.2, 0.5)), normal)
    floor = Contact(GROUND, egg, form, stiffness=8e5, exponent=1.5, loss=loss, plane=plane, name="floor")
    run = simulate(System([egg], forces=[floor], gravity=(0, 0, 0)), 0.2, rtol=1e-10)

    def invariant(v):
        return v - np.log1p(loss * v) / loss

    away = brentq(lambda v: invariant(-v) - invariant(speed), 1e-3, speed)
    assert run.velocity(egg)[-1] @ normal == pytest.approx(away, rel=1e-8)
    assert run.energy().total[0] - run.energy().total[-1] == pytest.approx(0.7 * (speed**2 - away**2), rel=1e-8)


@pytest.mark.parametrize("mu", [0.6, 0.05])
def test_a_ball_rolls_down_a_slope_or_slides(mu):
    angle, axis = 0.4, np.array([0.3, 0.5, 0.0])
    up = matrix(rotation(axis, angle)) @ (0, 0, 1)
    down = -np.array([0, 0, 1]) + np.cos(angle) * up
    down /= np.linalg.norm(down)
    stone = ball(position=0.1 * up, velocity=(0, 0, 0), omega=(0, 0, 0))
    slope = Contact(GROUND, stone, shapes.Sphere(0.1), stiffness=1e7, damping=2e3, friction=mu, plane=((0, 0, 0), up))
    run = simulate(System([stone], forces=[slope], gravity=(0, 0, -9.81)), 0.5, method=STIFF, rtol=1e-10, output=6)
    load_ = run.force(slope)
    normal = load_.force @ up
    rubs = np.linalg.norm(load_.force - normal[:, None] * up, axis=1)
    rolls = mu > 2 / 7 * np.tan(angle)
    rate = 9.81 * (5 / 7 * np.sin(angle) if rolls else np.sin(angle) - mu * np.cos(angle))
    # 1e7 N/m turn the 1e-10 m by which a step may err into 1e-3 N of 1 N or more
    assert run.acceleration(stone)[3:] @ down == pytest.approx(rate, rel=1e-3)
    assert rubs[3:] == pytest.approx((2 / 7 * np.sin(angle) if rolls else mu * np.cos(angle)) * 2.0 * 9.81, rel=1e-3)
    assert np.all(rubs <= mu * normal * (1 + 1e-14))
    assert load_.point == pytest.approx(run.position(stone) - 0.1 * up, abs=1e-15)
    assert run.certificate.passed


def test_what_sticks_stands_still_on_a_slope_and_what_creeps_does_not():
    angle = np.arctan(0.3)
    up = np.array([np.sin(angle), 0, np.cos(angle)])
    stone = ball(position=0.1 * up, velocity=(0, 0, 0), omega=(0, 0, 0))
    numbers = dict(stiffness=2e4, damping=200.0, friction=0.5, rolling=0.05, spinning=0.01, plane=((0, 0, 0), up))
    for creep, fastest in ((None, 1e-9), (1e-3, 1.0)):
        slope = Contact(GROUND, stone, shapes.Sphere(0.1), **numbers, creep=creep, name="slope")
        run = simulate(System([stone], forces=[slope]), 3.0, method=RadauIIA(), rtol=1e-9, output=31)
        speed = np.linalg.norm(run.velocity(stone), axis=1)
        assert speed[-1] < fastest and np.ptp(run.position(stone)[20:], axis=0).max() < fastest
    assert speed[-1] > 1e-5  # creep for ever


def test_spinning_friction_stops_a_top_and_it_stays():
    stone, g = ball(omega=(0, 0, 30.0), position=(0, 0, 0.1 - 2 * 9.81 / 1e5)), 9.81
    floor = Contact(GROUND, stone, shapes.Sphere(0.1), stiffness=1e5, spinning=0.02, name="floor")
    run = simulate(System([stone], forces=[floor], gravity=(0, 0, -g)), 1.0, method=STIFF, rtol=1e-9, output=101)
    slowing = 0.02 * 2.0 * g / 0.008
    stops = 30.0 / slowing
    assert run.omega(stone)[:50, 2] == pytest.approx(30.0 - slowing * run.t[:50], abs=2e-3)
    assert stops < 0.7 and np.abs(run.omega(stone)[-1]).max() < 1e-9  # rtol
    heat = run.energy().total[0] - run.energy().total[-1]
    assert heat == pytest.approx(0.5 * 0.008 * 30.0**2, rel=1e-9)  # all of it


def test_rolling_friction_slows_a_ball_that_rolls_and_it_stays():
    """(1 + b) m a = -N arm / r, b = I / m r^2, as the friction force adds to what the moment takes."""
    r, arm, g, speed = 0.1, 4e-3, 9.81, 0.6
    rolls = ball(position=(0, 0, r - 2.0 * g / 1e6), velocity=(speed, 0, 0), omega=(0, speed / r, 0))
    floor = Contact(GROUND, rolls, shapes.Sphere(r), stiffness=1e6, damping=600.0, friction=0.5, rolling=arm)
    run = simulate(System([rolls], forces=[floor], gravity=(0, 0, -g)), 3.0, method=STIFF, rtol=1e-11, output=301)
    slowing = g * arm / (1.4 * r)
    stops = speed / slowing
    before = (run.t > 0.1) & (run.t < 0.9 * stops)
    # 1e6 N/m turn the 1e-11 m by which a step may err into 1e-5 N of 0.6 N; where stability limits steps, some add up
    assert stops < 2.5 and run.acceleration(rolls)[before, 0] == pytest.approx(-slowing, rel=1e-3)
    assert np.linalg.norm(run.velocity(rolls)[-1]) < 1e-9
    assert run.energy().total[0] - run.energy().total[-1] == pytest.approx(0.7 * 2.0 * speed**2, rel=1e-5)


def tumbling(seed=5):
    """A stone that hits a table; both float, nothing is aligned."""
    rng = np.random.default_rng(seed)
    table, stone = random_body(rng, "table"), random_body(rng, "stone", mass=0.8)
    form = shapes.Ellipsoid((0.5, 0.3, 0.2), at=0.1 * direction(rng), orientation=rotation(direction(rng), 0.7))
    normal = direction(rng)
    plane = (stone.position - 0.55 * normal, normal)
    stone = Body("stone", 0.8, stone.inertia, com=stone.com, position=stone.position, orientation=stone.orientation,
                 velocity=-2.0 * normal + 0.5 * direction(rng), omega=3.0 * direction(rng))  # fmt: skip
    hit = Contact(table, stone, form, stiffness=3e3, exponent=1.3, damping=4.0, loss=0.1, friction=0.4, rolling=0.02,
                  spinning=0.03, grip=4e3, grip_damping=20.0, plane=plane, name="hit")  # fmt: skip
    return System([table, stone], forces=[hit], gravity=(0, 0, 0)), hit


def test_two_floating_bodies_exchange_momentum_and_lose_energy():
    system, hit = tumbling()
    run = simulate(system, 0.6, rtol=1e-9)
    assert run.certificate.passed and run.measure(measures.normal_force(hit)).max() > 10.0
    assert run.momentum().linear == pytest.approx(run.momentum().linear[[0]] + 0 * run.momentum().linear, abs=1e-8)
    assert np.diff(run.energy().total).max() < 1e-7 < run.energy().total[0] - run.energy().total[-1]


@pytest.mark.parametrize("gap", [0.3, -2e-3])
def test_what_does_not_rub_has_no_derivative_either(gap):
    """A pendulum swings, or falls over, by weight less normal force in the air and where it only resists spinning."""
    m, moment, arm, r, k = 2.0, 0.025, 0.4, 0.1, 3e5
    table = ((0, 0, -arm - r - gap), (0, 0, 1))
    bob = Body("bob", m, (0.01, moment, 0.02), com=(0, 0, -arm))
    hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 1, 0))
    law = {"friction": 0.5, "spinning": 0.01} if gap > 0.0 else {"spinning": 0.01}
    rubbing = Contact(GROUND, bob, shapes.Sphere(r, at=(0, 0, -arm)), stiffness=k, plane=table, **law)
    found = linearize(System([bob], [hinge], [rubbing])).eigenvalues
    square = (m * 9.81 - k * max(-gap, 0.0)) * arm / (moment + m * arm**2)
    assert np.abs(found - np.sqrt(complex(-square))).min() < 1e-9 * np.sqrt(abs(square))


def test_clearance_is_that_of_the_lowest_of_many_points():
    system, hit = tumbling()
    run = simulate(system, 0.4, rtol=1e-8, output=5)
    form, (at, normal) = hit.surface, hit.plane
    u, v = np.meshgrid(np.linspace(0, np.pi, 400), np.linspace(0, 2 * np.pi, 800))
    sphere = np.stack([np.sin(u) * np.cos(v), np.sin(u) * np.sin(v), np.cos(u)], axis=-1).reshape(-1, 3)
    local = sphere * form.radii @ matrix(form.orientation).T + form.at
    table, stone = system.bodies
    heights = [
        np.min((R @ local.T).T @ n + (r - p) @ n)
        for R, r, p, n in zip(run.rotation(stone), run.position(stone), run.body_point(table, at),
                              run.body_axis(table, normal), strict=True)
    ]  # fmt: skip
    assert run.measure(measures.clearance(hit)) == pytest.approx(heights, abs=2e-5)  # of a net of 0.5 degrees


@pytest.mark.parametrize(
    ("surface", "disc"),
    [
        (shapes.Torus(0.3, 0.1, "y"), dict(axis=(0, 1, 0), radius=0.4, crown=0.1)),
        (shapes.Sphere(0.4), dict(axis=(0, 1, 0), radius=0.4, crown=0.4)),
        (shapes.Ellipsoid((0.4, 0.4, 0.4)), dict(axis=(1, 2, 3), radius=0.4, crown=0.4)),
    ],
)
def test_rolling_is_the_rolling_disc_where_both_are_known(surface, disc):
    body = Body("part", 1.3, (0.1, 0.2, 0.25), com=(0.02, 0.03, -0.01), position=(0.4, 0.1, 0.41))
    state = None
    for joint in (RollingDisc(GROUND, body, **disc, name="road"), Rolling(GROUND, body, surface, name="road")):
        system = System([body], [joint])
        state = state or system.assemble(near=system.state())
        found = accelerations(system, state)
        now = found.arrays["acceleration"], found.reaction("road").force, found.reaction("road").point
        if isinstance(joint, RollingDisc):
            known = now
    for one, other in zip(known, now, strict=True):
        assert one == pytest.approx(other, abs=1e-12)


def test_a_stone_rocks_at_the_rate_of_its_curvature():
    """Rolling about y on the bottom of an ellipsoid: (I + m c^2) f'' = -m g (a^2/c - c) f."""
    a, b, c, m, inertia = 0.2, 0.07, 0.05, 1.3, (2e-3, 9e-3, 1e-2)
    stone = Body("stone", m, inertia, position=(0, 0, c), velocity=(0, 0, 0), omega=(0, 0, 0))
    found = linearize(System([stone], [Rolling(GROUND, stone, shapes.Ellipsoid((a, b, c)))])).eigenvalues.imag
    for radius, moment in ((a, inertia[1]), (b, inertia[0])):
        rate = np.sqrt(m * 9.81 * (radius**2 / c - c) / (moment + m * c**2))
        assert np.abs(found - rate).min() < 1e-8 * rate


def test_a_saved_contact_comes_back_the_same(tmp_path):
    system, hit = tumbling()
    run = simulate(system, 0.3, rtol=1e-8, output=7)
    back = load(run.save(tmp_path / "hit.mbs"))
    assert np.array_equal(back.force("hit").force, run.force(hit).force)
    assert np.array_equal(back.force("hit").states["deflection x"], run.force(hit).states["deflection x"])
    system.to_file(tmp_path / "hit.json")
    again = simulate(System.from_file(tmp_path / "hit.json"), 0.3, rtol=1e-8, output=7)
    assert np.array_equal(again.position("stone"), run.position("stone"))


STONE = ball()
BAD = {
    "surface": (lambda: Contact(GROUND, STONE, shapes.Box((1, 1, 1)), stiffness=1.0), "give shapes.Sphere"),
    "no surface": (lambda: Rolling(GROUND, STONE, None), "surface None has no rule"),
    "stiffness": (lambda: Contact(GROUND, STONE, shapes.Sphere(0.1), stiffness=0.0, name="floor"), "stiffness"),
    "exponent": (lambda: Contact(GROUND, STONE, shapes.Sphere(0.1), stiffness=1.0, exponent=0.5), "exponent"),
    "ground": (lambda: Contact(STONE, GROUND, shapes.Sphere(0.1), stiffness=1.0), "b = .* is not a body"),
    "ground rolls": (lambda: Rolling(STONE, GROUND, shapes.Sphere(0.1)), "the ground cannot roll"),
    "flat": (lambda: Rolling(GROUND, STONE, shapes.Torus(0.1, 0.02)), "lies flat"),
    "no mass": (
        lambda: Contact(GROUND, Body("dot", 0.0, (0, 0, 0)), shapes.Sphere(0.1), stiffness=1.0, friction=0.3),
        "'dot' has no mass to choose grip by",
    ),
    "creep": (lambda: Contact(GROUND, STONE, shapes.Sphere(0.1), stiffness=1.0, friction=0.3, creep=0.0), "creep"),
    "grip": (
        lambda: Contact(GROUND, STONE, shapes.Sphere(0.1), stiffness=1.0, grip=3.0),
        "grip does nothing with no friction, rolling or spinning",
    ),
    "grip beside creep": (
        lambda: Contact(GROUND, STONE, shapes.Sphere(0.1), stiffness=1.0, friction=0.3, grip_damping=3.0, creep=0.1),
        "grip_damping does nothing with creep",
    ),
    "measure": (lambda: measures.clearance(STONE), "give a Contact"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input_is_named(case):
    make, text = BAD[case]
    with pytest.raises(ValueError, match=text):
        make()


def test_a_default_of_the_grip_is_not_given():
    """So it follows what is replaced, and goes where friction goes."""
    floor = Contact(GROUND, STONE, shapes.Sphere(0.1), stiffness=1e3, friction=0.3)
    assert floor.grip is None and floor.bristles == pytest.approx((1e3, np.sqrt(1e3 * STONE.mass)))
    assert replace(floor, stiffness=4e3).bristles[0] == pytest.approx(4e3)
    assert replace(floor, friction=0.0).states() == 0
