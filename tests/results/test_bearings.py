"""Bearing loads against statics written here, lives against worked examples."""

import numpy as np
import pytest
from helpers.models import across, direction, random_body

from mbsd3d import (
    GROUND,
    DeepGrooveBallBearing,
    Prismatic,
    Revolute,
    RollingBearing,
    SpeedDriver,
    Spherical,
    System,
    accelerations,
    bearing_load,
    bearing_pair,
    reliability_factor,
    simulate,
)
from mbsd3d.results.bearings import BearingLoad
from mbsd3d.rotations import exponential, matrix


def spinning(seed=71, rate=7.0):
    """(system, hinge, body): a general body driven at a steady rate about a general axis."""
    rng = np.random.default_rng(seed)
    body = random_body(rng, "rotor", position=0.4 * direction(rng))
    hinge = Revolute(GROUND, body, at=0.2 * direction(rng), axis=direction(rng), name="hinge")
    driver = SpeedDriver(GROUND, body, axis=hinge.axis, speed=rate, name="motor")
    return System([body], [hinge, driver], gravity=(0.3, -0.5, -9.7)), hinge, body


def euler_wrench(body, hinge, gravity, rate, turn):
    """(force, moment about hinge.at) that hold a steadily turning body: m (w x (w x s) - g), w x I w + s x ..."""
    R = matrix(exponential(turn * hinge.axis))
    start = matrix(body.orientation)
    s = R @ (body.position + start @ body.com - hinge.at)
    inertia = R @ start @ body.inertia @ start.T @ R.T
    w = rate * hinge.axis
    force = body.mass * (np.cross(w, np.cross(w, s)) - gravity)
    return force, np.cross(s, force) + np.cross(w, inertia @ w), R


@pytest.mark.parametrize("frame", ["a", "b"])
def test_loads_of_an_unbalanced_rotor(frame):
    system, hinge, body = spinning()
    solution = simulate(system, 0.7, rtol=1e-11, output=9)
    load = bearing_load(solution, "hinge", frame=frame)
    for k, t in enumerate(solution.t):
        force, moment, R = euler_wrench(body, hinge, system.gravity, 7.0, 7.0 * t)
        u = hinge.axis
        assert load.axial[k] == pytest.approx(force @ u, abs=1e-8)  # of 60 N, integrated at 1e-11
        assert load.radial[k] == pytest.approx(np.linalg.norm(np.cross(u, force)), abs=1e-7)
        assert load.tilting[k] == pytest.approx(np.linalg.norm(np.cross(u, moment)), abs=1e-7)
        x = np.cross(u, np.eye(3)[np.argmin(np.abs(u))])
        x = (R if frame == "b" else np.eye(3)) @ x / np.linalg.norm(x)
        assert load.force[k, :2] == pytest.approx([force @ x, force @ np.cross(u, x)], abs=1e-7)
    assert load.speed == pytest.approx(np.full(9, 7.0), abs=1e-9)


def test_axis_of_a_shaft_that_was_drawn_elsewhere():
    """Body b as it comes from its drawing, with the seat at another place and in another direction than the bore."""
    rng = np.random.default_rng(75)
    body, bore, seat = random_body(rng, "rotor"), direction(rng), direction(rng)
    hinge = Revolute(GROUND, body, at=direction(rng), at_b=direction(rng), axis=bore, axis_b=seat, name="hinge")
    system = System([body], [hinge], gravity=(0.3, -0.5, -9.7))
    run = accelerations(system, system.assemble(rates={hinge: 5.0}))
    fixed, turning = (bearing_load(run, hinge, frame=frame) for frame in "ab")
    assert np.linalg.norm(np.cross(bore, seat)) > 0.1 and abs(fixed.axial[0]) > 1.0
    for what in ("axial", "radial", "tilting", "speed"):  # about one axis, whichever body it is taken from
        assert getattr(turning, what) == pytest.approx(getattr(fixed, what), rel=1e-11)  # joints close to rounding


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_pair_of_bearings_is_in_balance_with_the_shaft(way):
    """Unknown F_A (3) and F_B (2 across) from the six equations of the shaft."""
    system, hinge, body = spinning(72)
    solution = accelerations(system)
    u, x = hinge.axis, across(np.random.default_rng(1), hinge.axis)
    A, B = hinge.at - way * 0.13 * u, hinge.at + way * 0.31 * u
    fixed, floating = bearing_pair(solution, hinge, fixed=A, floating=B)
    force, moment, _ = euler_wrench(body, hinge, system.gravity, 7.0, 0.0)
    columns = [np.concatenate([e, np.cross(A - hinge.at, e)]) for e in np.eye(3)]
    columns += [np.concatenate([e, np.cross(B - hinge.at, e)]) for e in (x, np.cross(u, x))]
    wanted = np.concatenate([force, moment])
    wanted[3:] -= (moment @ u) * u  # the motor's part
    known, *_ = np.linalg.lstsq(np.column_stack(columns), wanted, rcond=None)
    F_A, F_B = known[:3], known[3] * x + known[4] * np.cross(u, x)
    assert fixed.axial[0] == pytest.approx(F_A @ u, abs=1e-10)  # rounding of 60 N
    assert fixed.radial[0] == pytest.approx(np.linalg.norm(np.cross(u, F_A)), abs=1e-10)
    assert floating.radial[0] == pytest.approx(np.linalg.norm(F_B), abs=1e-10)
    assert np.abs(floating.axial).max() < 1e-12 and fixed.tilting.max() == 0.0
    assert fixed.point[0] == pytest.approx(A, abs=1e-15) and floating.point[0] == pytest.approx(B, abs=1e-15)


def test_spherical_joint_needs_an_axis():
    rng = np.random.default_rng(73)
    body = random_body(rng)
    joint = Spherical(GROUND, body, at=direction(rng), name="ball")
    run = accelerations(System([body], [joint]))
    with pytest.raises(ValueError, match="'ball' .Spherical. has no axis; give axis="):
        bearing_load(run, joint)
    u = direction(rng)
    load, reaction = bearing_load(run, joint, axis=u), run.reaction(joint)
    assert load.axial[0] == pytest.approx(reaction.force[0] @ u, abs=1e-13)
    assert np.hypot(load.axial, load.radial) == pytest.approx(np.linalg.norm(reaction.force, axis=1), abs=1e-12)


def test_life_of_the_worked_examples():
    """Graduate Aptitude Test in Engineering (selfstudys.com): 2500 N, 1000 N, C = 7350 N, 720 rpm: 340.419 h."""
    bearing = RollingBearing(C=7350.0, X=0.56, Y=1.6, e=0.3)
    force = np.tile([1500.0, -2000.0, -1000.0], (3, 1))  # |radial| = 2500
    speed = np.full(3, -720 * 2 * np.pi / 60)
    load = BearingLoad(np.array([0.0, 1.0, 3.0]), force, np.zeros((3, 3)), np.zeros((3, 3)), speed, 0.1, "seat")
    life = bearing.life(load)
    assert life.load == pytest.approx(3000.0, rel=1e-14)
    assert life.hours == pytest.approx(340.419, abs=1e-3)  # as printed, cut after three digits
    assert life.revolutions == pytest.approx((7350 / 3000) ** 3, rel=1e-13)
    assert life.speed == pytest.approx(720 * 2 * np.pi / 60, rel=1e-14)


def test_a_life_does_not_ask_when_the_run_began():
    t, load, speed = np.array([0.0, 1.0, 3.0]), np.array([2.0, 5.0, 3.0]), np.array([6.0, -7.0, 9.0])
    first, later = (RollingBearing(C=7000.0).life_of(start + t, load, speed) for start in (0.0, 40.0))
    assert (later.hours, later.speed) == pytest.approx((first.hours, first.speed), rel=1e-13)


def test_mean_load_of_the_worked_example():
    """Mott, Machine Elements in Mechanical Design, example 14-6: 650, 750, 250 lb for 30, 10, 20 min: 597 lb."""
    t = np.array([0, 30, 30 + 1e-9, 40, 40 + 1e-9, 60]) * 60.0
    steps = np.repeat([650.0, 750.0, 250.0], 2)
    life = RollingBearing(C=7000.0).life_of(t, steps, np.full(6, 600 * 2 * np.pi / 60))
    assert life.load == pytest.approx(597.0, abs=0.5)  # as printed


def test_deep_groove_ball_bearing_reads_its_table_at_every_sample():
    """Rows f0 F_a / C0 = 0.345, 1.38, 6.89 of the table, one radial, one interpolated, two beside F_a = e F_r."""
    bearing = DeepGrooveBallBearing(C=2e4, C0=7000.0, f0=14.0)
    axial = np.array([0.345, 1.38, 6.89, 0.0, 0.517, 0.345, 0.345]) * 500.0
    radial = np.array([100.0, 100.0, 7000.0, 800.0, 100.0, 790.0, 780.0])
    expected = [56 + 1.99 * 172.5, 56 + 1.45 * 690, 56 * 70 + 3445.0, 800.0, 56 + 1.85 * 258.5]
    expected += [790.0, 0.56 * 780 + 1.99 * 172.5]  # e = 0.22
    assert bearing.equivalent(radial, -axial) == pytest.approx(expected, rel=1e-14)
    with pytest.raises(ValueError, match="f0 F_a / C0 = 8 is beyond the table, which ends at 6.89; take a greater"):
        bearing.equivalent(1000.0, [100.0, 4000.0])


def test_rows_of_the_table_make_no_jump_where_axial_forces_begin_to_count():
    """X + Y e = 1 in every row, within half a unit of the last digit of Y and of e."""
    bearing = DeepGrooveBallBearing(C=2e4, C0=7000.0, f0=14.0)
    X, Y, e = bearing.factors(500.0 * np.array([0.172, 0.345, 0.689, 1.03, 1.38, 2.07, 3.45, 5.17, 6.89]))
    assert (np.diff(e) > 0.0).all() and (np.diff(Y) < 0.0).all()
    assert (np.abs(X + Y * e - 1.0) < 0.005 * (Y + e)).all()


def test_ratings_are_keywords_so_that_none_is_mistaken():
    with pytest.raises(TypeError):
        RollingBearing(7350.0)


@pytest.mark.parametrize("p", [3.0, 10 / 3])
def test_mean_load_weighs_by_revolutions(p):
    """P = 1 + s and n = 2 + s over s = 0 ... 1: the integral of (1 + s)^p (2 + s) in closed form."""
    s = np.linspace(0.0, 1.0, 20001)
    life = RollingBearing(C=5.0, p=p).life_of(s, 1 + s, 2 + s)
    q, r = p + 1, p + 2
    integral = (2**q - 1) / q + (2**r - 1) / r
    assert life.load == pytest.approx((integral / 2.5) ** (1 / p), rel=1e-8)  # trapezoidal rule, step 5e-5
    assert life.revolutions == pytest.approx((5.0 / life.load) ** p, rel=1e-14)
    assert life.hours == pytest.approx(life.revolutions * 1e6 * 2 * np.pi / 2.5 / 3600, rel=1e-8)


def test_reliability_factors_of_the_table():
    """ISO 281:1990, as printed in catalogues (RBC Bearings): 95 ... 99 %."""
    table = {0.90: 1.0, 0.95: 0.62, 0.96: 0.53, 0.97: 0.44, 0.98: 0.33, 0.99: 0.21}
    for reliability, a1 in table.items():
        assert reliability_factor(reliability) == pytest.approx(a1, abs=5.1e-3)  # two digits printed


def test_errors_name_value_and_remedy():
    system, hinge, body = spinning(74)
    run = accelerations(system)
    load = bearing_load(run, hinge)
    rail = Prismatic(GROUND, body, at=body.position, axis=hinge.axis, name="rail")
    twice = Revolute(GROUND, body, at=hinge.at + 0.2 * hinge.axis, axis=hinge.axis, name="second")
    still = accelerations(System([body], [rail]))
    doubled = accelerations(System([body], [hinge, twice]))
    rest = BearingLoad(load.t, load.force * [1, 1, 0], 0 * load.moment, load.point, 0 * load.speed, 1.0, "hinge")
    once = np.array([[0.0, 0.0, 1.0], [3.0, 4.0, 0.0]])
    tilted = BearingLoad(np.arange(2.0), np.ones((2, 3)), once, np.zeros((2, 3)), np.ones(2), 0.1, "hinge")
    away = hinge.at + 0.1 * across(np.random.default_rng(2), hinge.axis)
    cases = [
        (lambda: RollingBearing(C=0.0), "C: 0.0 is not positive"),
        (lambda: RollingBearing(C=1.0, Y=-1.0), "Y: -1.0 is below 0.0"),
        (lambda: bearing_load(still, rail), "'rail' .Prismatic. does not turn like a bearing"),
        (lambda: bearing_load(run, "motor"), "'motor' .SpeedDriver. does not turn like a bearing"),
        (lambda: bearing_load(doubled, hinge), "redundant constraints leave its reaction open"),
        (lambda: bearing_load(run, hinge, frame="world"), "give 'a' or 'b'"),
        (lambda: bearing_pair(run, hinge, fixed=hinge.at, floating=away), "lies 0.1 m off the axis"),
        (lambda: bearing_pair(run, hinge, fixed=hinge.at, floating=hinge.at), "give two"),
        (lambda: RollingBearing(C=1e4, X=0.5, Y=1.0).life(tilted), "'hinge': a tilting moment of 5 N m"),
        (lambda: RollingBearing(C=1e4).life(load), "'hinge': a tilting moment of .*split the hinge with bearing_pair"),
        (lambda: RollingBearing(C=1e4, tilting=1e3).life(load), "an axial force of .* but Y = 0; give X, Y and e"),
        (lambda: RollingBearing(C=1e4).life(rest), "it does not turn in this run"),
        (lambda: RollingBearing(C=1e4).life_of([0, 1], [0, 0], [1, 1], "seat"), "seat: it is never loaded"),
        (lambda: reliability_factor(1.0), "no bearing is certain; give 0.9 <= R < 1"),
    ]
    for call, message in cases:
        with pytest.raises(ValueError, match=message):
            call()
