"""Spheres that touch spheres and capsules, against closed forms, integrations of their own and impact laws."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.models import direction, random_body
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    Body,
    Contact,
    Fixed,
    Prismatic,
    RadauIIA,
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
R = matrix(rotation((0.5, -0.3, 0.8), 0.9))  # the plane of the spheres lies along no axis
M1, R1, M2, R2, SPEED, OFFSET = 1.0, 0.05, 2.0, 0.08, 3.0, 0.06


def ball(name, mass, radius, at, v=(0, 0, 0), omega=(0, 0, 0)):
    """A solid sphere whose centre has a place and a velocity, with axes and reference point of their own."""
    turn, arm = rotation((0.2, 0.9, -0.4), 0.7), np.array([0.01, -0.02, 0.03])
    return Body(name, mass, (0.4 * mass * radius**2,) * 3, com=matrix(turn).T @ arm, position=np.array(at) - arm,
                orientation=turn, velocity=np.array(v) - np.cross(omega, arm), omega=omega)  # fmt: skip


def centre_velocity(run, name):
    """Of the centre of mass at the end of a run."""
    return run.velocity(name)[-1] + np.cross(run.omega(name)[-1], run.com(name)[-1] - run.position(name)[-1])


def pair(swapped=False, far=-0.3, **law):
    """One sphere on its way to another one at rest, as far beside its line as OFFSET."""
    one = ball("one", M1, R1, R @ (far, 0, 0), R @ (SPEED, 0, 0))
    two = ball("two", M2, R2, R @ (0, OFFSET, 0))
    a, b = (two, one) if swapped else (one, two)
    sizes = {"one": R1, "two": R2}
    touch = Contact(a, b, shapes.Sphere(sizes[b.name]), other=shapes.Sphere(sizes[a.name]), name="touch", **law)
    return System([one, two], forces=[touch], gravity=(0, 0, 0))


@pytest.mark.parametrize("swapped", [False, True])
def test_two_spheres_against_an_integration_of_both_centres(swapped):
    k, c = 1e5, 40.0
    system = pair(swapped, stiffness=k, damping=c)
    touch = system.forces[0]
    down = simulate(system, 1.0, rtol=1e-11, stop_when=measures.touches(touch))
    up = simulate(system, 1.0, state=down.final, rtol=1e-11, stop_when=measures.leaves(touch))
    assert up.t[-1] - down.t[-1] == pytest.approx(0.007641254309453879, abs=1e-9)
    v1, v2 = (R.T @ centre_velocity(up, name) for name in ("one", "two"))
    assert v1 == pytest.approx([0.3086158412064928, -1.5407767966735926, 0.0], abs=1e-8)
    assert v2 == pytest.approx([1.3456920793967535, 0.7703883983367963, 0.0], abs=1e-8)

    def rates(t, y):  # of both centres, in the plane
        gap, speed = y[2:4] - y[:2], y[6:] - y[4:6]
        n = gap / np.linalg.norm(gap)
        force = max(0.0, k * (R1 + R2 - np.linalg.norm(gap)) - c * (speed @ n)) * (np.linalg.norm(gap) < R1 + R2) * n
        return np.concatenate([y[4:], -force / M1, force / M2])

    start = np.concatenate([(R.T @ down.body_point(name, b.centre)[-1])[:2] for name, b in zip(
        ("one", "two"), system.bodies, strict=True)] + [(SPEED, 0, 0, 0)])  # fmt: skip
    own = solve_ivp(rates, (0, up.t[-1] - down.t[-1]), start, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    assert np.abs(own[4:] - np.concatenate([v1[:2], v2[:2]])).max() < 1e-8


def restitution(zeta):
    """Speed after over before of m x'' = -(k x + c x') from the touch until the force ends, zeta = c / 2 sqrt(k m)."""
    w = np.sqrt(1.0 - zeta**2)  # in units of sqrt(k / m)

    def motion(t):
        s, co, decay = np.sin(w * t), np.cos(w * t), np.exp(-zeta * t)
        return decay * s / w, decay * (co - zeta / w * s)

    end = brentq(lambda t: np.dot((1.0, 2.0 * zeta), motion(t)), 1.0, np.pi / w)
    return -motion(end)[1]


def test_stiff_spheres_come_to_the_rigid_impact_with_friction():
    """Impulse (1 + e) m_r v_n along the centres and mu of it across: the miss falls with the time of touch."""
    e, mu, reduced = 0.8, 0.03, M1 * M2 / (M1 + M2)
    zeta = brentq(lambda x: restitution(x) - e, 1e-3, 0.5, xtol=1e-15)
    found = []
    for k in (1e9, 4e9):
        system = pair(stiffness=k, damping=2.0 * zeta * np.sqrt(k * reduced), friction=mu, creep=1e-6)
        run = simulate(system, 0.15, rtol=1e-10, method=STIFF)
        assert run.certificate.passed
        found.append(np.concatenate([(R.T @ centre_velocity(run, x))[:2] for x in ("one", "two")]
                                    + [(R.T @ run.omega(x)[-1])[2:] for x in ("one", "two")]))  # fmt: skip
    rigid = np.array([0.1226443753766469, -1.3889902487863266, 1.4386778123116766, 0.6944951243931633,
                      4.790449077786331, 1.4970153368082284])  # fmt: skip
    misses = [np.abs(x - rigid).max() for x in found]
    assert misses[0] < 1e-2 and misses[0] / misses[1] == pytest.approx(2.0, rel=0.05)  # half the time of touch
    assert np.abs(2.0 * found[1] - found[0] - rigid).max() < 1e-4  # second order in the time of touch


def cradle(k, **law):
    """A sphere above two level bars along no axis of the world."""
    m, r, bar, apart = 2.0, 0.05, 0.02, 0.08
    along, side = np.array([0.6, 0.8, 0.0]), np.array([-0.8, 0.6, 0.0])
    top = ball("ball", m, r, np.array([0.3, -0.1, 0.5]))
    touches = [
        Contact(GROUND, top, shapes.Sphere(r), stiffness=k, name=name, **law,
                other=shapes.Capsule(bar, 0.4, along, at=(0.3, -0.1, 0.45) + s * 0.5 * apart * side))
        for name, s in (("left", 1.0), ("right", -1.0))
    ]  # fmt: skip
    return System([top], forces=touches), m, r + bar, 0.5 * apart


def test_a_sphere_on_two_round_bars():
    k = 1e6
    system, m, reach, half = cradle(k, damping=2000.0)
    run = simulate(system, 2.0, method=RadauIIA(), rtol=1e-9)
    rest = brentq(lambda h: 2 * k * (reach - np.hypot(h, half)) * h / np.hypot(h, half) - m * 9.81, 0.8 * reach, reach)
    assert run.com("ball")[-1, 2] - 0.45 == pytest.approx(rest, abs=1e-9)
    for name in ("left", "right"):
        assert np.linalg.norm(run.force(name).force[-1]) == pytest.approx(k * (reach - np.hypot(rest, half)), rel=1e-6)
    rigid = np.sqrt(reach**2 - half**2)  # a published pair of values: m g / (2 cos a), and the height
    assert m * 9.81 / (2.0 * rigid / reach) == pytest.approx(11.95391263447777) and rigid == pytest.approx(
        0.05744562646538029)  # fmt: skip
    assert rest == pytest.approx(rigid, abs=2.0 * 12.0 / k)


def test_small_motions_in_the_cradle():
    """K = 2 k (cos^2 a - d / l sin^2 a) upright, with l the length and d the depth of the lines to the bars."""
    k = 1e5
    system, m, reach, half = cradle(k)
    state = system.equilibrium(system.state()).state
    found = np.sort(np.abs(linearize(system, state).eigenvalues.imag))[-1]
    height = brentq(
        lambda h: 2 * k * (reach - np.hypot(h, half)) * h / np.hypot(h, half) - m * 9.81, 0.5 * reach, reach
    )
    line = np.hypot(height, half)
    stiffness = 2 * k * ((height / line) ** 2 - (reach - line) / line * (half / line) ** 2)
    aside = 2 * k * ((half / line) ** 2 - (reach - line) / line * (height / line) ** 2)
    assert found == pytest.approx(np.sqrt(max(stiffness, aside) / m), rel=1e-7)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("half", [0.0, 0.4])
def test_the_clearance_is_the_least_distance(seed, half):
    """Beside a capsule and past its ends, with the normal force along the shortest line."""
    rng = np.random.default_rng(seed)
    a, b = random_body(rng, "a"), random_body(rng, "b")
    own_axis, at_a, at_b = direction(rng), 0.2 * rng.normal(size=3), 0.2 * rng.normal(size=3)
    other = shapes.Capsule(0.3, 2 * half, own_axis, at=at_a) if half else shapes.Sphere(0.3, at=at_a)
    touch = Contact(a, b, shapes.Sphere(0.2, at=at_b), other=other, stiffness=30.0, name="touch")
    near = replace(b, position=a.position + a.axes @ at_a + 0.35 * rng.normal(size=3) - b.axes @ at_b)
    touch = replace(touch, b=near)
    now = accelerations(System([a, near], forces=[touch], gravity=(0, 0, 0)))
    centre, axis = near.position + near.axes @ at_b, a.axes @ own_axis
    middle = a.position + a.axes @ at_a
    away = minimize_scalar(lambda s: np.linalg.norm(centre - middle - s * axis), bounds=(-half, half), method="bounded",
                           options={"xatol": 1e-12})  # fmt: skip
    s = min((away.x, -half, half), key=lambda s: np.linalg.norm(centre - middle - s * axis))
    line = centre - middle - s * axis
    gap = np.linalg.norm(line) - 0.5
    assert now.measure(measures.clearance(touch))[0] == pytest.approx(gap, abs=1e-9)
    force = now.force("touch")
    expected = 30.0 * max(-gap, 0.0) * line / np.linalg.norm(line)
    assert np.abs(force.force[0] - expected).max() < 1e-6
    # a direction found to 1e-8 of a length, the square root of its rounding
    assert np.abs(force.point[0] - (centre - (0.2 + 0.5 * gap) * line / np.linalg.norm(line))).max() < 1e-6


@pytest.mark.parametrize(("mu", "fall"), [(0.0, 2.0 / 3.0), (60.0, 10.0 / 17.0)])
def test_a_ball_leaves_the_ball_on_which_it_runs_down(mu, fall):
    """From rest at an angle, at cos = 2/3 of the first one if it slides, 10/17 if it rolls (a uniform sphere)."""
    first, big, small = 0.25, 0.7, 0.1
    n = np.array([0.6 * np.sin(first), 0.8 * np.sin(first), np.cos(first)])
    runner = ball("runner", 1.3, small, (big + small) * n)
    law = {"friction": mu} if mu else {}
    touch = Contact(GROUND, runner, shapes.Sphere(small), other=shapes.Sphere(big), stiffness=1e7, damping=3e3,
                    name="touch", **law)  # fmt: skip
    system = System([runner], forces=[touch])
    start = simulate(system, 0.1, method=RadauIIA(), rtol=1e-8).final  # it presses now
    pressed = simulate(system, 5.0, state=start, method=RadauIIA(), rtol=1e-8,
                       stop_when=measures.normal_force(touch) < 1e-2)  # fmt: skip
    at = pressed.com(runner)[-1]
    # it sinks by 1 um, and N ends 1e-2 N before 0 while it falls by 1 N in 4e-2 rad
    assert at[2] / np.linalg.norm(at) == pytest.approx(fall * np.cos(first), abs=2e-3)
    assert pressed.certificate.passed


@pytest.mark.parametrize("seed", range(8))
def test_no_step_passes_a_body_unseen(seed):
    """Two small spheres that meet far away, in long steps of free flight, hit or miss as their lines say."""
    rng = np.random.default_rng(seed)
    u, side = direction(rng), direction(rng)
    side = np.cross(u, side) / np.linalg.norm(np.cross(u, side))
    beside = rng.uniform(0.0, 0.25)
    dart = ball("dart", 0.2, 0.05, 40.0 * u + beside * side, -30.0 * u)
    rest = ball("rest", 0.5, 0.06, (0, 0, 0))
    shape = shapes.Sphere(0.06) if seed % 2 else shapes.Capsule(0.06, 0.3, rest.axes.T @ np.cross(u, side))
    touch = Contact(rest, dart, shapes.Sphere(0.05), other=shape, stiffness=1e5, name="touch")
    run = simulate(System([rest, dart], forces=[touch], gravity=(0, 0, -9.81)), 3.0, method=STIFF)
    hit = np.linalg.norm(run.velocity("rest")[-1] - (0, 0, -9.81 * 3.0)) > 1e-3
    assert hit == (beside < 0.11) and run.certificate.passed


def test_a_fall_from_rest_onto_a_small_ball_is_seen():
    post = Contact(GROUND, drop := ball("drop", 0.3, 0.02, (0.004, 0, 5.0)), shapes.Sphere(0.02),
                   other=shapes.Sphere(0.03), stiffness=1e6, name="post")  # fmt: skip
    for method in (DOP853(), RK4(dt=0.003)):
        run = simulate(System([drop], forces=[post]), 3.0, method=method, stop_when=measures.touches(post))
        height = np.sqrt(0.05**2 - 0.004**2)
        assert run.t[-1] == pytest.approx(np.sqrt(2 * (5.0 - height) / 9.81), rel=1e-9)


def test_momentum_and_energy_with_friction_and_rolling():
    """Two spinning spheres rub on each other in flight: what is lost is what friction and damping took."""
    one = ball("one", 1.0, 0.05, (0, 0, 0), (1, 0.1, 0), (20.0, -5.0, 40.0))
    two = ball("two", 2.0, 0.08, (0.2, 0.06, 0.03), omega=(-3.0, 15.0, 10.0))
    law = {"stiffness": 2e4, "loss": 0.1, "friction": 0.3, "rolling": 1e-3, "spinning": 2e-3, "exponent": 1.5}
    touch = Contact(one, two, shapes.Sphere(0.08), other=shapes.Sphere(0.05), name="touch", **law)
    run = simulate(System([one, two], forces=[touch], gravity=(0, 0, 0)), 0.4, rtol=1e-9, method=STIFF)
    assert run.certificate.passed
    energy = run.energy()
    assert energy.total[-1] < energy.total[0] - 0.05
    assert run.work("touch")[-1] == pytest.approx(energy.total[-1] - energy.total[0], rel=1e-7)
    spin = run.momentum()
    assert np.abs(np.ptp(spin.angular, axis=0)).max() < 1e-9 and np.abs(np.ptp(spin.linear, axis=0)).max() < 1e-9


def test_a_start_in_the_middle_is_refused():
    for other, x, middle in ((shapes.Sphere(0.2), 0.0, "centre"), (shapes.Capsule(0.2, 1.0, "x"), 0.1, "axis")):
        b = ball("b", 1.0, 0.1, (x, 0, 0))
        inside = Contact(GROUND, b, shapes.Sphere(0.1), other=other, stiffness=1e3, name="in")
        system = System([b], forces=[inside])
        for run in (accelerations, lambda x: simulate(x, 0.1)):
            with pytest.raises(ValueError, match=f"'in' .Contact.: the centre of the sphere of 'b' .* on the {middle}"):
                run(system)
    deep = ball("b", 1.0, 0.1, (0.02, 0, 0))
    with pytest.raises(ValueError, match="'b' starts 0.28 m deep in the sphere of 'ground', 0.02 m beside"):
        simulate(System([deep], forces=[Contact(GROUND, deep, shapes.Sphere(0.1), other=shapes.Sphere(0.2),
                                                stiffness=1e6)]), 0.1)  # fmt: skip


def test_a_soft_sphere_passes_through_the_middle_of_another_one():
    """The force turns round there, and all that it stores comes back."""
    slider = ball("slider", 1.0, 0.1, (-0.15, 0, 0), (1.0, 0, 0))
    rail = Prismatic(GROUND, slider, at=(0, 0, 0), axis=(1, 0, 0))
    soft = Contact(GROUND, slider, shapes.Sphere(0.1), other=shapes.Sphere(0.1), stiffness=1.0, name="soft")
    run = simulate(System([slider], [rail], [soft], gravity=(0, 0, 0)), 0.4)
    assert run.velocity(slider)[-1, 0] == pytest.approx(np.sqrt(1.0 + 0.05**2), rel=1e-7)  # it starts 50 mm deep


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"other": shapes.Box((1, 1, 1))}, "other .*Box.* give shapes.Sphere or shapes.Capsule"),
        ({"surface": shapes.Ellipsoid((1, 1, 2))}, "surface is an Ellipsoid; beside other="),
        ({"plane": ((0, 0, 1), (0, 0, 1))}, "both other and plane"),
    ],
)
def test_what_is_refused(given, text):
    b = ball("b", 1.0, 0.1, (0, 0, 1))
    with pytest.raises(ValueError, match=f"'touch' .Contact.: {text}"):
        Contact(GROUND, b, **({"surface": shapes.Sphere(0.1), "other": shapes.Sphere(0.3), "stiffness": 1e3,
                               "name": "touch"} | given))  # fmt: skip


def test_files_and_drawings_have_the_other_surface(tmp_path):
    hub = Body("hub", 1.0, (0.1,) * 3)
    b = ball("b", 1.0, 0.1, (0, 0, 1))
    bars = [Contact(x, b, shapes.Sphere(0.1), other=shapes.Capsule(0.05, 0.4, "x", at=(0, 0, 0.5)), stiffness=1e3,
                    name=name) for x, name in ((GROUND, "bar"), (hub, "arm"))]  # fmt: skip
    system = System([hub, b], [Fixed(GROUND, hub, at=(0, 0, 0))], bars)
    system.to_file(tmp_path / "model.toml")
    again = System.from_file(tmp_path / "model.toml")
    assert [force.other.length for force in again.forces] == [0.4, 0.4]
    run = simulate(system, 0.3)
    run.save(tmp_path / "run")
    assert np.array_equal(load(tmp_path / "run").force("bar").force, run.force("bar").force)
    assert "bar" in (tmp_path / "page.html").read_text() if system.show(tmp_path / "page.html") else False


@pytest.mark.parametrize("method", (DOP853(), STIFF, RK4(dt=1e-5)))
def test_a_contact_that_lets_a_body_through_has_no_passed_certificate(method):
    """k (R + r)^2 / 2 is the energy of an even spring at the centre; with less, the sphere comes out behind."""
    u = np.array([0.3, -0.5, 0.8]) / np.sqrt(0.98)
    for share, through in ((0.7, False), (1.3, True)):
        dart, small, big = ball("dart", 0.7, 0.05, 0.4 * u, -30.0 * u), 0.05, 0.07
        k = 0.7 * 30.0**2 / (small + big) ** 2 / share
        touch = Contact(GROUND, dart, shapes.Sphere(small), other=shapes.Sphere(big), stiffness=k, name="touch")
        run = simulate(System([dart], forces=[touch], gravity=(0, 0, 0)), 0.05, method=method)
        assert (run.position("dart")[-1] @ u < 0.0) == through
        overlap = run.certificate["overlap"]
        assert not overlap.passed and "'touch' is too soft" in overlap.meaning  # to 0.84 and 1 of the centre: both do
        stiff = Contact(GROUND, dart, shapes.Sphere(small), other=shapes.Sphere(big), stiffness=10 * k, name="touch")
        run = simulate(System([dart], forces=[stiff], gravity=(0, 0, 0)), 0.05, method=method)
        deepest = np.sqrt(share / 10)  # of the even spring, over the sum of the radii
        assert run.certificate.passed and run.certificate["overlap"].error == pytest.approx(deepest, rel=0.05)


def test_no_step_ends_in_the_midst_of_a_body_that_its_stages_flew_past():
    """From whatever distance it comes, the sphere leaves with one velocity: before the touch it flies freely."""
    touch_at, v = np.array([0.019, 0.009, 0.113]), np.array([-0.22, 0.34, -1.16])  # centres 0.115 m apart: they touch
    found = []
    for time in np.geomspace(0.05, 0.2, 12):
        one, two = ball("one", 0.08, 0.076, (0, 0, 0)), ball("two", 0.13, 0.039, touch_at - time * v, v)
        touch = Contact(one, two, shapes.Sphere(0.039), other=shapes.Sphere(0.076), stiffness=2.3e4, name="touch")
        run = simulate(System([one, two], forces=[touch], gravity=(0, 0, 0)), 0.4, method=STIFF, rtol=1e-10)
        found.append(centre_velocity(run, "two"))
    assert np.allclose(found, found[0], rtol=0.0, atol=1e-6) and np.linalg.norm(found[0] - v) > 0.5
