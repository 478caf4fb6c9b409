"""Play: teeth of gears, pins in bearings, a slider in its guide; against closed forms and equations of their own."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from mbsd3d import (
    GROUND,
    RK4,
    AngleDriver,
    Backlash,
    Body,
    Gear,
    GearMesh,
    GeneralizedAlpha,
    PinPlay,
    PointStop,
    RadauIIA,
    Revolute,
    Sine,
    Stepper,
    System,
    Torque,
    linearize,
    load,
    rotation,
    simulate,
)  # fmt: skip
from mbsd3d.errors import IntegrationError
from mbsd3d.rotations import matrix

R = matrix(rotation((0.3, -0.5, 0.8), 1.1))
PLACE = np.array([0.7, -1.3, 0.4])


def gears(inertias, carrier=GROUND, rates=(None, None)):
    """Two gears on slanted parallel shafts, with their centres of mass off the shafts."""
    bodies, hinges = [], []
    for k, (name, inertia, rate) in enumerate(zip(("one", "two"), inertias, rates, strict=True)):
        at = PLACE + 0.3 * k * R[:, 0]
        com = 0.02 * R[:, k]
        own = R @ np.diag([0.3, 0.4, inertia - 1.3 * 0.02**2]) @ R.T  # about the shaft it is as given
        spin = None if rate is None else rate * R[:, 2]
        bodies.append(Body(name, 1.3, own, com=com, position=at, omega=spin))
        hinges.append(Revolute(carrier, bodies[k], at=at, axis=R[:, 2], name=f"shaft {name}"))
    return bodies, hinges


def test_gear_rattle_has_two_impacts_a_period():
    """The symmetric motion between flanks at A sin wt +- b: from A sin(w t0) + b = v pi / (2 w) and the impact law."""
    A, w, b, e = 0.001, 100.0, 0.002, 0.8
    bodies, hinges = gears((0.2, 0.3))
    ratio = -2.5
    driver = AngleDriver(hinges[0], Sine(A / ratio, w / (2 * np.pi)), name="driver")
    teeth = Backlash(Gear(*hinges, ratio=ratio), angle=2 * b, restitution=e, name="teeth")
    system = System(bodies, [*hinges, driver], [teeth], gravity=(0, 0, 0))
    run = simulate(system, 100 * 2 * np.pi / w, state=system.assemble(rates={hinges[1]: 0.19}), rtol=1e-11)
    assert len(run.events) == 200 and run.certificate.passed

    def speed(phase):
        return 2 * w / np.pi * (A * np.sin(phase) + b)

    phase = brentq(lambda f: A * w * np.cos(f) + speed(f) * (1 - e) / (1 + e), 0.5 * np.pi, np.pi)
    last = run.events[-2:]
    assert abs(run.rate(hinges[1])[-1]) == pytest.approx(0.1895578689176264, rel=1e-8)
    assert speed(phase) == pytest.approx(0.1895578689176264, rel=1e-12)
    upper = next(event for event in last if "upper" in event.action)
    assert upper.t % (2 * np.pi / w) == pytest.approx(phase / w, abs=1e-9)
    assert abs(upper.impulses["teeth"].moment @ R[:, 2]) == pytest.approx(0.3 * 2 * speed(phase), rel=1e-8)
    x = run.measure(teeth.play)
    assert np.abs(x).max() < b + 1e-9
    assert np.ptp(run.force(teeth).angle - x) == 0.0


def free_play(a, b, k, c, ratio, angle, w0):
    """Return (time of touch, rates of both after it) of a gear at w0 that takes the other one along: a damped swing."""
    I = 1.0 / (1.0 / b + ratio**2 / a)
    u = abs(ratio * w0)
    wn, z = np.sqrt(k / I), 0.5 * c / np.sqrt(k * I)
    s = np.sqrt(1.0 - z**2)
    touch = (np.pi - np.arctan2(2.0 * z * s, 1.0 - 2.0 * z**2)) / (wn * s)
    left = u * np.exp(-z * wn * touch) * (np.cos(wn * s * touch) - z / s * np.sin(wn * s * touch))
    impulse = I * (u - left) * np.sign(ratio * w0)
    return touch, (w0 - ratio * impulse / a, impulse / b)


@pytest.mark.parametrize("ratio", [-2.5, 0.7])
def test_soft_flanks_take_the_other_gear_along(ratio):
    a, b, k, c, angle, w0 = 0.2, 0.3, 500.0, 4.0, 0.05, 3.0
    bodies, hinges = gears((a, b), rates=(w0, 0.0))
    teeth = Backlash(Gear(*hinges, ratio=ratio), angle=angle, stiffness=k, damping=c, name="teeth")
    system = System(bodies, hinges, [teeth], gravity=(0, 0, 0))
    touch, expected = free_play(a, b, k, c, ratio, angle, w0)
    run = simulate(system, 0.5 * angle / abs(ratio * w0) + touch, rtol=1e-11)
    got = [run.rate(hinge)[-1] for hinge in hinges]
    assert np.abs(np.array(got) - expected).max() < 1e-8
    gone = 0.5 * (a * w0**2 - a * got[0] ** 2 - b * got[1] ** 2)
    lost = run.force(teeth).stored[-1] - run.work(teeth)[-1]  # they part while still pressed in
    assert lost == pytest.approx(gone, rel=1e-7) and run.certificate.passed
    during = simulate(system, 0.5 * angle / abs(ratio * w0) + 0.4 * touch, rtol=1e-11)
    on_b, on_a = (during.force(teeth, on=body).moment[-1] @ R[:, 2] for body in bodies[::-1])
    assert on_a == pytest.approx(-ratio * on_b, rel=1e-12) and on_b * ratio > 0.0
    assert during.force(teeth, on=GROUND).moment[-1] @ R[:, 2] == pytest.approx(-on_a - on_b, rel=1e-12)


def test_play_counts_turns_and_lags_by_half_of_itself():
    """Driven and braked for twelve turns the flanks stay in touch: the driven gear lags by half the play and T / k."""
    bodies, hinges = gears((0.2, 0.3))
    driver = AngleDriver(hinges[0], Sine(40.0, 0.05), name="driver")
    ratio, angle, k, T = -1.9, 0.04, 4e3, -2.0
    teeth = Backlash(Gear(*hinges, ratio=ratio), angle=angle, stiffness=k, damping=30.0, name="teeth")
    brake = Torque(bodies[1], -T * R[:, 2])
    system = System(bodies, [*hinges, driver], [teeth, brake], gravity=(0, 0, 0))
    run = simulate(system, 5.0, state=system.assemble(rates={hinges[1]: ratio * 4 * np.pi}), method=RadauIIA())
    assert run.angle(hinges[1])[-1] < -12 * 2 * np.pi
    last = run.measure(teeth.play)[-1]
    deep = (-T + 0.3 * ratio * 40.0 * (0.1 * np.pi) ** 2) / k  # at the turning point: brake and inertia of gear b
    assert last + 0.5 * angle == pytest.approx(deep, rel=1e-3)  # it lags by 40 rad (0.1 pi)^3 c / k and less


def test_a_carrier_that_is_free_keeps_its_balances():
    """Two gears on a free body: the torque on it is what keeps the angular momentum."""
    frame = Body("frame", 3.0, (0.6, 0.5, 0.4), position=PLACE - 0.1 * R[:, 1])
    bodies, hinges = gears((0.2, 0.3), carrier=frame)
    for law in ({"restitution": 0.6}, {"stiffness": 300.0, "damping": 2.0}):
        teeth = Backlash(Gear(*hinges, ratio=-1.5), angle=0.03, name="teeth", **law)
        system = System([frame, *bodies], hinges, [teeth], gravity=(0, 0, 0))
        run = simulate(system, 1.0, state=system.assemble(rates={hinges[0]: 2.0}), rtol=1e-10)
        assert run.certificate.passed and np.ptp(run.measure(teeth.play)) > 0.02


def test_rigid_flanks_come_to_rest_and_part_when_the_load_turns(tmp_path):
    bodies, hinges = gears((0.2, 0.3))
    push = Torque(bodies[0], np.array([Sine(0.8 * x, 0.5) for x in R[:, 2]]))
    teeth = Backlash(Gear(*hinges, ratio=-1.5), angle=0.02, restitution=0.3, name="teeth")
    system = System(bodies, hinges, [teeth, push], gravity=(0, 0, 0), name="rattle")
    run = simulate(system, 2.5, rtol=1e-10)
    said = [event.action for event in run.events]
    assert any("comes to rest" in x for x in said) and "is free" in said and run.certificate.passed
    other = load(run.save(tmp_path / "run"))
    assert str(other.certificate) == str(run.certificate) and other.events[-1].t == run.events[-1].t
    again = System.from_file(system.to_file(tmp_path / "model.toml"))
    same = simulate(again, 2.5, rtol=1e-10)
    assert np.array_equal(same.angle("shaft two"), run.angle("shaft two"))
    parts = run.at(1.2)
    on = simulate(system, 2.5, state=parts, rtol=1e-10)
    assert on.angle(hinges[1])[-1] == pytest.approx(run.angle(hinges[1])[-1], abs=1e-8)


# --- pins


def hole(**law):
    pin = Body("pin", 0.3, (1e-3, 1.2e-3, 1.1e-3), position=PLACE)
    play = PinPlay(GROUND, pin, at=PLACE, axis=R[:, 2], clearance=1e-4, name="hole", **law)
    system = System([pin], [play.guide], [play], gravity=-9.81 * R[:, 1])
    start = system.state()
    pose = np.r_[PLACE + R @ [2e-5, 5e-5, 0], start.q[3:]]
    return system, play, replace(start, q=pose, v=np.r_[R @ [0.03, 0.01, 0], 0, 0, 0])


def test_a_pin_bounces_in_its_hole():
    """Parabolas between impacts on a circle, v' = v - (1 + e) (v.n) n."""
    system, play, start = hole(restitution=0.8)
    run = simulate(system, 0.0073, state=start, rtol=1e-11)
    seen = []
    for event in run.events:
        after = int(np.searchsorted(run.t, event.t, side="right")) - 1
        x, y, _ = R.T @ (run.position("pin")[after] - PLACE)
        seen.append((event.t, np.arctan2(y, x), np.linalg.norm(run.velocity("pin")[after])))
    assert len(seen) == 4 and run.certificate.passed
    assert seen[0][:2] == pytest.approx((0.0022673929638475, 0.49447519178791355), abs=1e-9)
    assert seen[1][:2] == pytest.approx((0.004772094215884211, -0.6193121724216097), abs=1e-9)
    assert seen[3] == pytest.approx((0.0071152315310319195, -1.938966737712552, 0.054289842634114176), abs=1e-9)
    whole = simulate(system, 0.4, state=start, rtol=1e-10)
    assert "comes to rest" in whole.events[-1].action and len(whole.events) < 100
    assert whole.measure(play.play).max() < 1e-4 * (1 + 1e-6) and whole.certificate.passed
    radial = R.T @ (whole.force(play).force[-1])
    assert np.linalg.norm(radial) > 0.3 * 9.81 * 0.3  # it swings on the wall of the bearing


def test_a_rigid_pin_that_lies_in_its_bearing_swings_as_a_pendulum():
    """Without rebound it slides as a point on a circle: theta'' = -g / c sin(theta)."""
    system, play, start = hole(restitution=0.0)
    angle = 0.7
    pose = PLACE + 1e-4 * R @ [np.sin(angle), -np.cos(angle), 0]
    run = simulate(system, 0.05, state=replace(start, q=np.r_[pose, start.q[3:]], v=np.zeros(6)), rtol=1e-11)
    truth = solve_ivp(
        lambda t, x: [x[1], -9.81 / 1e-4 * np.sin(x[0])], (0, 0.05), [angle, 0.0], method="DOP853", rtol=1e-12,
        atol=1e-12, t_eval=run.t,
    )  # fmt: skip
    x, y, _ = R.T @ (run.position("pin") - PLACE).T
    assert np.abs(np.arctan2(x, -y) - truth.y[0]).max() < 1e-7 and run.certificate.passed
    load_on_pin = run.force(play).force @ R
    expected = 0.3 * (9.81 * np.cos(truth.y[0]) + 1e-4 * truth.y[1] ** 2)
    assert np.abs(np.linalg.norm(load_on_pin, axis=1) - expected).max() < 1e-6


def rod_in_bearing(mu=0.0):
    """A rod whose end hangs in a bearing with play, and its plane equations: x, y of the pin and the angle."""
    m, l, I, c, k, loss, creep, r = 1.3, 0.25, 0.02, 2e-3, 4e6, 0.4, 5e-3, 0.012
    C = R @ np.diag([0.7 * I, 0.8 * I, I]) @ R.T
    rod = Body("rod", m, C, com=l * R[:, 0], position=PLACE)
    rub = dict(mu=mu, creep=creep, pin_radius=r) if mu else {}
    play = PinPlay(GROUND, rod, at=PLACE, axis=R[:, 2], clearance=c, stiffness=k, loss=loss, name="bearing", **rub)
    system = System([rod], [play.guide], [play], gravity=-9.81 * R[:, 1])

    def rates(t, s):
        x, y, f, u, v, w = s
        e = np.hypot(x, y)
        F, M = np.zeros(2), 0.0
        if e > c:
            n = np.array([x, y]) / e
            N = max(0.0, k * (e - c) ** 1.5 * (1 + loss * (n @ [u, v])))
            side = np.array([-n[1], n[0]])
            V = side @ [u, v] + r * w
            rubs = mu * N * V / np.hypot(V, creep)
            F, M = -N * n - rubs * side, -r * rubs
        d = l * np.array([np.cos(f), np.sin(f)])
        A = np.array([[m, 0, -m * d[1]], [0, m, m * d[0]], [-m * d[1], m * d[0], I + m * l * l]])
        b = np.array([F[0] + m * w * w * d[0], F[1] + m * w * w * d[1] - m * 9.81, M - m * 9.81 * d[0]])
        return [u, v, w, *np.linalg.solve(A, b)]

    return system, play, rates


@pytest.mark.parametrize("mu", [0.0, 0.3])
def test_a_rod_falls_into_its_bearing(mu):
    """Against plane equations of its own: touches and hops, friction at the surface of the pin."""
    system, play, rates = rod_in_bearing(mu)
    run = simulate(system, 0.25, rtol=1e-10, output=51)
    truth = solve_ivp(
        rates, (0, 0.25), np.zeros(6), method="DOP853", rtol=1e-11, atol=1e-13, max_step=1e-4, t_eval=run.t
    )
    x, y, _ = R.T @ (run.position("rod") - PLACE).T
    assert np.abs(x - truth.y[0]).max() < 2e-8 and np.abs(y - truth.y[1]).max() < 2e-8
    c = np.einsum("tij,jk->tik", run.rotation("rod"), R) @ [1.0, 0, 0] @ R
    assert np.abs(np.arctan2(c[:, 1], c[:, 0]) - truth.y[2]).max() < 1e-6
    assert np.hypot(x, y).max() > 2e-3 and run.certificate.passed
    energy = run.energy()
    assert np.abs(energy.total - energy.work - energy.total[0]).max() < 1e-7


def test_two_free_bodies_with_a_pin_between_keep_their_momenta():
    one = Body("one", 1.0, (0.1, 0.12, 0.15), position=PLACE, velocity=(0.3, 0, 0), omega=(0.5, 0.2, 1.0))
    two = Body("two", 0.7, (0.08, 0.1, 0.06), position=PLACE + 0.4 * R[:, 0], com=(0.05, 0.02, 0))
    play = PinPlay(
        one, two, at=PLACE + 0.2 * R[:, 0], axis=R[:, 2], clearance=1e-2, stiffness=2e4, exponent=1.0, damping=5.0,
        mu=0.2, creep=0.01, pin_radius=0.03,
    )  # fmt: skip
    run = simulate(System([one, two], forces=[play], gravity=(0, 0, 0)), 0.5, rtol=1e-10)
    assert run.measure(play.play).max() > 1e-2 and run.certificate.passed


def test_small_motions_of_a_pin_at_rest():
    """Down on its seat: sqrt(k / m) along the normal, sqrt(g / e) across it, e the clearance and the depth."""
    m, k = 0.3, 2e5
    system, play, start = hole(stiffness=k, exponent=1.0)
    e = 1e-4 + m * 9.81 / k
    rest = replace(start, q=np.r_[PLACE - e * R[:, 1], start.q[3:]], v=np.zeros(6))
    values = np.sort(np.abs(linearize(system, rest).eigenvalues))
    for w in (np.sqrt(k / m), np.sqrt(9.81 / e)):
        assert np.abs(values / w - 1.0).min() < 1e-7


def test_steps_do_not_pass_over_a_touch_and_the_certificate_judges_fixed_ones():
    system, play, rates = rod_in_bearing()
    free = simulate(System(system.bodies, system.joints, gravity=system.gravity), 0.02)
    assert np.linalg.norm(free.position("rod")[-1] - PLACE) < 2e-3
    coarse = simulate(system, 0.1, method=GeneralizedAlpha(dt=2e-3)).certificate
    assert not coarse["contacts"].passed and "'bearing'" in coarse["contacts"].meaning
    fixed = simulate(system, 0.06, method=RK4(dt=5e-5))
    exact = simulate(system, 0.06, rtol=1e-11)
    assert np.abs(fixed.position("rod")[-1] - exact.position("rod")[-1]).max() < 1e-7
    stepper = Stepper(system, method=RadauIIA())
    stepper.advance(0.06)
    assert np.abs(stepper.state.q[:3] - exact.position("rod")[-1]).max() < 1e-4


# --- a slider in its guide


def slider_crank(e, c, w0, tilt=0.0):
    """Return system, start and hinges: four corners of the slider between the walls of its guide."""
    l1, l2, a, b = 0.153, 0.306, 0.05, 0.025
    bodies = [
        Body(name, m, R @ np.diag([0.6 * I, 0.7 * I, I]) @ R.T, position=PLACE + x * R[:, 0])
        for name, m, I, x in (
            ("crank", 0.038, 7.4e-5, 0.5 * l1), ("rod", 0.038, 5.9e-4, l1 + 0.5 * l2),
            ("slider", 0.076, 2.7e-6, l1 + l2),
        )
    ]  # fmt: skip
    pairs = ((GROUND, bodies[0], 0.0), (bodies[0], bodies[1], l1), (bodies[1], bodies[2], l1 + l2))
    hinges = [Revolute(i, j, at=PLACE + x * R[:, 0], axis=R[:, 2]) for i, j, x in pairs]
    corners = [
        PointStop(
            GROUND, bodies[2], at=PLACE + R @ [l1 + l2 + along * a, side * b, 0], axis=R[:, 1], restitution=e,
            name=name, **({"upper": c} if side > 0 else {"lower": -c}),
        )
        for name, along, side in (("1", -1, 1), ("2", 1, 1), ("3", -1, -1), ("4", 1, -1))
    ]  # fmt: skip
    system = System(bodies, hinges, corners, gravity=-9.81 * R[:, 1])
    rates = dict(zip(hinges, (w0, -1.5 * w0, 0.5 * w0), strict=True))
    return system, system.assemble(angles={hinges[0]: 0.0, hinges[1]: 0.0, hinges[2]: tilt}, rates=rates), hinges


LEVEL = [  # [s], [rad/s] by minimal coordinates of Flores, Leine, Glocker (2010)
    (0.002692502752020999, "12", 108.79372856053838), (0.0056077978680711205, "12", 81.52450238368733),
    (0.007465635169563024, "12", 73.4468847956904), None, None, (0.009009132575409523, "12", 69.34498210349463),
]  # fmt: skip
TILTED = [
    (0.0024438107305778, "2", 113.19731400183078), (0.0026603917500917632, "1", 109.984877178779),
    (0.002685667132819434, "2", 109.6027242672269), None, (0.0026963198706256423, "2", 109.40199228262102),
]  # fmt: skip


@pytest.mark.parametrize(("tilt", "t_end", "expected"), [(0.0, 0.00905, LEVEL), (0.004, 0.0027, TILTED)])
def test_a_slider_strikes_the_walls_of_its_guide(tilt, t_end, expected):
    system, start, hinges = slider_crank(0.4, 0.001, 150.0, tilt)
    run = simulate(system, t_end, state=start, rtol=1e-11)
    assert run.certificate.passed
    for event, known in zip(run.events, expected, strict=False):
        if known is None:
            continue
        after = int(np.searchsorted(run.t, event.t, side="right")) - 1
        assert event.t == pytest.approx(known[0], rel=1e-7, abs=1e-9)
        assert "".join(sorted(name for name in event.impulses if name in "1234")) == known[1]
        assert run.rate(hinges[0])[after] == pytest.approx(known[2], rel=1e-7)
        spin = sum(run.rate(hinge)[after] for hinge in hinges)
        assert tilt or abs(spin) < 1e-9  # both corners at once: it does not turn
    assert len(run.events) >= len(expected)


def test_corners_that_yield_press_at_their_points():
    """A bar that falls level onto two soft feet of different stiffness, against its plane equations."""
    m, I, k = 2.0, 0.05, (3e4, 5e4)
    bar = Body("bar", m, R @ np.diag([0.04, I, 0.06]) @ R.T, position=PLACE)
    ends = [-0.3, 0.2]
    feet = [
        PointStop(
            GROUND, bar, at=PLACE + x * R[:, 0], axis=R[:, 2], lower=-0.1, stiffness=kk, damping=20.0, name=f"{x}"
        )
        for x, kk in zip(ends, k, strict=True)
    ]
    run = simulate(System([bar], forces=feet, gravity=-9.81 * R[:, 2]), 0.3, rtol=1e-10)

    def rates(t, s):
        z, f, u, w = s
        Q = np.array([-9.81 * m, 0.0])
        for x, kk in zip(ends, k, strict=True):  # f about y: the end at x rises by -x sin f
            depth, rate = -0.1 - (z - x * np.sin(f)), -(u - x * np.cos(f) * w)
            push = max(0.0, kk * depth + 20.0 * rate) if depth > 0.0 else 0.0
            Q += [push, -x * np.cos(f) * push]
        return [u, w, Q[0] / m, Q[1] / I]

    truth = solve_ivp(
        rates, (0, 0.3), np.zeros(4), method="DOP853", rtol=1e-11, atol=1e-13, max_step=1e-4, t_eval=run.t
    )
    assert np.abs((run.position("bar") - PLACE) @ R[:, 2] - truth.y[0]).max() < 1e-8
    assert run.certificate.passed and run.force(feet[0]).stored.max() > 0.1


def test_what_is_refused(tmp_path):
    bodies, hinges = gears((0.2, 0.3))
    gear = Gear(*hinges, ratio=-2.0, name="mesh")
    teeth = Backlash(gear, angle=0.01, stiffness=1e3, name="teeth")
    with pytest.raises(
        ValueError, match=r"'teeth' \(Backlash\): stands in place of 'mesh', which is in the system too"
    ):
        System(bodies, [*hinges, gear], [teeth])
    mesh = GearMesh(*hinges, at=PLACE + 0.1 * R[:, 0])
    with pytest.raises(ValueError, match="is not a Gear; give a Gear; of a GearMesh one with its hinges and ratio"):
        Backlash(mesh, angle=0.01, stiffness=1e3)
    with pytest.raises(ValueError, match="its joint 'shaft two' is not in the system"):
        System(bodies, hinges[:1], [teeth])
    for own in ({}, {"stiffness": 1.0, "restitution": 0.5}):
        with pytest.raises(ValueError, match="give either stiffness= of a stop that yields, or restitution="):
            Backlash(gear, angle=0.01, **own)
        with pytest.raises(ValueError, match="give either stiffness= of a stop that yields, or restitution="):
            PinPlay(GROUND, bodies[0], at=PLACE, axis=R[:, 2], clearance=1e-3, **own)
    with pytest.raises(ValueError, match="angle: 0.0 is not positive"):
        Backlash(gear, angle=0.0, stiffness=1.0)
    hole_of = dict(at=PLACE, axis=R[:, 2], clearance=1e-3)
    with pytest.raises(ValueError, match="a rigid pin is smooth and has no loss"):
        PinPlay(GROUND, bodies[0], **hole_of, restitution=0.5, loss=0.1)
    with pytest.raises(ValueError, match="friction needs both"):
        PinPlay(GROUND, bodies[0], **hole_of, stiffness=1e6, mu=0.1)
    with pytest.raises(ValueError, match="pin_radius does nothing without mu"):
        PinPlay(GROUND, bodies[0], **hole_of, stiffness=1e6, pin_radius=0.01)
    with pytest.raises(ValueError, match="between 'one' and itself"):
        PinPlay(bodies[0], bodies[0], **hole_of, stiffness=1e6)
    with pytest.raises(ValueError, match="neither lower nor upper"):
        PointStop(GROUND, bodies[0], at=PLACE, axis=R[:, 2], stiffness=1e6)
    off = PinPlay(GROUND, bodies[0], **hole_of, at_b=PLACE + 2e-3 * R[:, 0], stiffness=1e6, name="pin")
    with pytest.raises(ValueError, match=r"'pin' \(PinPlay\): the reference pose is 0.001 beyond its limit"):
        simulate(System(bodies[:1], [off.guide], [off]), 0.1)
    rigid = Backlash(gear, angle=0.01, restitution=0.5, name="teeth")
    system = System(bodies, hinges, [rigid], gravity=(0, 0, 0))
    with pytest.raises(ValueError, match="the run starts 0.095 beyond its limit"):
        simulate(system, 1.0, state=system.assemble(angles={hinges[1]: 0.1, hinges[0]: 0.0}))
    with pytest.raises(ValueError, match=r"Stepper: 'teeth' \(Backlash\) switches at events"):
        Stepper(system)


def test_impacts_that_do_not_come_to_an_end_are_refused():
    """Without loss, in a play of 1e-9 rad: a million impacts a second."""
    bodies, hinges = gears((0.2, 0.3), rates=(3.0, 0.0))
    teeth = Backlash(Gear(*hinges, ratio=-1.0), angle=1e-6, restitution=1.0, name="teeth")
    with pytest.raises(IntegrationError, match=r"'teeth' switch.* again and again .*give stops stiffness="):
        simulate(System(bodies, hinges, [teeth], gravity=(0, 0, 0)), 1000.0)


def test_a_stop_may_start_at_its_limit_to_rounding():
    """Half a play of 1 mm off at 0.7 m: the distance of two such points is the half play but for rounding of 0.7."""
    normal = R @ (0.6, 0.0, 0.8)
    for place in np.linspace(0.1, 3.0, 30):
        at = PLACE + place * R[:, 1]
        block = Body("block", 1.0, (0.1, 0.2, 0.3), position=at, velocity=-0.1 * normal)
        stop = PointStop(GROUND, block, at=at, at_b=at + 5e-4 * normal, axis=normal, upper=5e-4, stiffness=1e6)
        run = simulate(System([block], [], [stop], gravity=-9.81 * normal), 1e-3)
        free = -(0.1 + 9.81e-3) * normal
        assert run.certificate.passed and np.allclose(run.velocity(block)[-1], free, rtol=0.0, atol=1e-9)
