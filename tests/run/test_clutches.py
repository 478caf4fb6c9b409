"""Clutches that slip and lock, freewheels and ratchets: closed forms, events at one time, files, what is refused."""

import numpy as np
import pytest

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AngleDriver,
    Body,
    Clutch,
    Constant,
    Cylindrical,
    EndStop,
    Freewheel,
    Gear,
    GeneralizedAlpha,
    Prismatic,
    RadauIIA,
    Ramp,
    Ratchet,
    Revolute,
    Rope,
    Sine,
    System,
    Torque,
    TorsionSpring,
    Winch,
    load,
    measures,
    rotation,
    simulate,
)  # fmt: skip
from mbsd3d.rotations import matrix

R = matrix(rotation((0.3, -0.5, 0.8), 1.1))
AXIS = R[:, 2]
PLACE = np.array([0.7, -1.3, 0.4])
RIM = 0.11  # m, of a drum


def shaft(name, J, place, **motion):
    """Return a body with the moment J about AXIS, its centre of mass off its reference point, and its bearing."""
    inertia, position = R @ np.diag([0.7 * J, 0.6 * J, J]) @ R.T, PLACE + place * AXIS
    body = Body(name, 1.0, inertia, com=0.1 * AXIS, position=position, **motion)
    return body, Revolute(GROUND, body, at=body.position, axis=AXIS, name=f"bearing of {name}")


def test_a_clutch_brings_two_shafts_to_one_speed():
    one, first = shaft("one", 1.0, 0.0, omega=6.5 * AXIS)
    two, second = shaft("two", 2.0, 0.3, omega=(0, 0, 0))
    between = Cylindrical(one, two, at=PLACE, axis=AXIS, name="between")
    closes = measures.angle(first) > 3.25
    clutch = Clutch(between, torque=2.0, engage=closes, name="clutch")
    system = System([one, two], [first, second, between], [clutch], gravity=(0, 0, 0))
    run = simulate(system, 4.0, rtol=1e-11)
    closing, locking = run.events
    assert (closing.action, locking.action) == ("engages", "locks") and abs(closing.t - 0.5) < 1e-10
    assert abs(locking.t - closing.t - 2.1666666666666665) < 1e-9
    assert abs(run.rate(second)[-1] - 2.1666666666666665) < 1e-10
    at = int(np.searchsorted(run.t, locking.t))
    began = int(np.searchsorted(run.t, closing.t))
    assert abs(run.angle(between)[at] - run.angle(between)[began] + 7.041666666666667) < 1e-8
    assert abs(run.work(clutch)[-1] + 14.083333333333334) < 1e-8
    assert np.ptp(run.angle(between)[at:]) < 1e-12  # no creep
    load_on_two = run.force(clutch).moment @ AXIS
    some = (run.t > closing.t) & (run.t < locking.t)
    assert np.abs(load_on_two[some] - 2.0).max() < 1e-12 and abs(load_on_two[-1]) < 1e-12
    assert run.certificate.passed


def test_a_clutch_slips_where_its_load_exceeds_the_torque_and_is_released():
    """Torque 0.8 t on a disc that a clutch of 1.2 N m holds: it slips from 1.5 s on, and runs free at 1 rad."""
    J, T, k = 0.3, 1.2, 0.8
    disc, hinge = shaft("disc", J, 0.0)
    holds = Clutch(hinge, torque=T, engaged=True, release=measures.angle(hinge) > 1.0, name="brake")
    drive = Torque(disc, tuple(Ramp(k * x) for x in AXIS))
    system = System([disc], [hinge], [drive, holds], gravity=(0, 0, 0))
    run = simulate(system, 4.0, rtol=1e-11)
    slips, released = run.events
    assert (slips.action, released.action) == ("slips", "is released") and abs(slips.t - T / k) < 1e-10
    assert abs(run.force("brake").moment[0] @ AXIS) < 1e-12
    wanted = (6.0 * J * 1.0 / k) ** (1 / 3)  # J x = k (t - T/k)^3 / 6
    assert abs(released.t - slips.t - wanted) < 1e-9
    rate, t = run.rate(hinge)[-1], run.t[-1]
    after = (k * (t**2 - released.t**2) / 2 + k * wanted**2 / 2) / J
    assert abs(rate - after) < 1e-8 and run.certificate.passed


def lever_and_shaft(drive, J, torque, lock, **own):
    """Return a lever that is driven, a shaft that a load torque slows to rest, and a lock between both."""
    lever, first = shaft("lever", 0.1, 0.0)
    driven, second = shaft("shaft", J, 0.3)
    between = Cylindrical(lever, driven, at=PLACE, axis=AXIS, name="between")
    motor = AngleDriver(first, drive, name="motor")
    forces = [lock(between, name="lock", **own), Clutch(second, torque=torque, engaged=True, name="load")]
    system = System([lever, driven], [first, second, between, motor], forces, gravity=(0, 0, 0))
    return system, second


def test_a_freewheel_on_a_lever():
    A, w = 0.3, 10.0
    system, bearing = lever_and_shaft(Constant(A) + Sine(-A, w / 2 / np.pi, np.pi / 2), 0.2, 2.0, Freewheel)
    run = simulate(system, 3 * 2 * np.pi / w, state=system.assemble(), rtol=1e-11)
    own = [event for event in run.events if event.part == "lock"]
    assert abs(own[0].t - 0.19106332362490186) < 1e-9 and own[0].action == "runs free"
    assert abs(own[1].t - 0.6283185307179586) < 1e-9 and own[1].action == "locks, 'load' slips"
    assert abs(run.angle(bearing)[np.searchsorted(run.t, own[1].t)] - 0.8) < 1e-8
    assert abs(run.angle(bearing)[-1] - 2.4) < 1e-8
    assert run.angle("between").min() > -1e-9 and run.certificate.passed


def test_a_ratchet_loses_the_rest_of_each_stroke(tmp_path):
    stroke, w, n = 0.6, 10.0, 7
    back = Constant(-stroke / 2) + Sine(stroke / 2, w / 2 / np.pi, np.pi / 2)  # back first, then ahead
    system, bearing = lever_and_shaft(back, 0.2, 20.0, Ratchet, teeth=24)
    run = simulate(system, n * 2 * np.pi / w + 1e-3, state=system.assemble(), rtol=1e-10)
    assert abs(run.angle(bearing)[-1] - 3.6651914291880923) < 1e-8
    actions = [event.action.partition(",")[0] for event in run.events if event.part == "lock"]
    assert actions.count("passes a tooth") == 2 * n and actions.count("catches") == n
    caught = [event for event in run.events if event.impulses]
    assert all(event.lost > 0.1 for event in caught)
    assert run.certificate.passed  # with what the driver works in each impact
    other = load(run.save(tmp_path / "run"))
    assert str(other.certificate) == str(run.certificate)
    again = System.from_file(system.to_file(tmp_path / "ratchet.toml"))
    short = [simulate(x, 1.0, state=x.assemble()).angle("between") for x in (system, again)]
    assert np.array_equal(*short)


def test_a_driven_pawl_takes_a_load_from_the_pawl_that_holds_it():
    """Each stroke carries the drum ahead; back, it follows the driven lever to the last tooth that it has passed.

    Where the lever turns, both pawls touch without a rate: the driven one takes the drum along and the other lets go.
    """
    stroke, w, n, pull = 0.6, 10.0, 4, 20.0
    back = Constant(-stroke / 2) + Sine(stroke / 2, w / 2 / np.pi, np.pi / 2)  # back first, then ahead
    lever, first = shaft("lever", 0.1, 0.0)
    drum, bearing = shaft("drum", 0.2, 0.3)
    between = Cylindrical(lever, drum, at=PLACE, axis=AXIS, name="between")
    pawls = [
        Freewheel(between, name="driving"),
        Ratchet(bearing, teeth=24, name="holding"),
    ]
    joints = [first, bearing, between, AngleDriver(first, back, name="arm")]
    system = System([lever, drum], joints, [*pawls, Torque(drum, -pull * AXIS)], gravity=(0, 0, 0))
    run = simulate(system, n * 2 * np.pi / w + 1e-3, state=system.assemble(), rtol=1e-10)
    tooth = 2 * np.pi / 24
    # of each stroke, 2.29 teeth, two are left; the last one ends 1e-3 s before, and 1.5e-5 rad back
    assert abs(run.angle(bearing)[-1] - ((n - 1) * 2 * tooth + stroke)) < 2e-5
    handed = [event for event in run.events if event.action == "locks, 'holding' lets go"]
    assert len(handed) == n and all(event.lost == 0.0 for event in handed)
    # at each end of a stroke ahead, when the lever has gone half a turn of its sine
    assert np.allclose([event.t for event in handed], (np.arange(n) + 0.5) * 2 * np.pi / w, rtol=0.0, atol=1e-9)
    assert run.certificate.passed


def test_a_freewheel_locks_at_once_against_a_rate():
    one, first = shaft("one", 1.0, 0.0, omega=6.5 * AXIS)
    two, second = shaft("two", 2.0, 0.3, omega=(0, 0, 0))
    between = Cylindrical(one, two, at=PLACE, axis=AXIS, name="between")
    system = System([one, two], [first, second, between], [Freewheel(between, name="pawl")], gravity=(0, 0, 0))
    run = simulate(system, 1.0)
    (event,) = run.events[:1]
    assert event.what == "'pawl' is struck at the start"
    assert abs(event.lost - 14.083333333333334) < 1e-12
    assert abs(event.impulses["pawl"].moment @ AXIS - 4.333333333333333) < 1e-12
    assert np.abs(run.rate(second)[1:] - 2.1666666666666665).max() < 1e-12 and run.certificate.passed


def test_what_is_refused():
    body, hinge = shaft("disc", 1.0, 0.0)
    rail = Prismatic(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1))
    with pytest.raises(ValueError, match="never closes; give engage=, or engaged=True"):
        Clutch(hinge, torque=1.0)
    with pytest.raises(ValueError, match="has no angle"):
        Ratchet(rail, teeth=12)
    with pytest.raises(ValueError, match=r"teeth = 2\.5 is not a whole number"):
        Ratchet(hinge, teeth=2.5)
    with pytest.raises(ValueError, match="torque"):
        Clutch(hinge, torque=0.0, engaged=True)


def test_an_impact_elsewhere_does_not_turn_a_freewheel_back():
    """Two links in a plane: the upper one meets a rigid stop, which would throw the elbow back against its pawls."""
    upper, lower = (Body(name, 1.0, (0.05, 0.05, 0.05), com=(0.3, 0, 0), position=(x, 0, 0)) for name, x in
                    (("upper", 0.0), ("lower", 0.6)))  # fmt: skip
    shoulder = Revolute(GROUND, upper, at=(0, 0, 0), axis=(0, 0, 1), name="shoulder")
    elbow = Revolute(upper, lower, at=(0.6, 0, 0), axis=(0, 0, 1), name="elbow")
    stop = EndStop(shoulder, lower=-0.4, restitution=0.5, name="stop")
    system = System([upper, lower], [shoulder, elbow], [stop, Freewheel(elbow, name="pawls")], gravity=(0, 0, 0))
    start = system.assemble(angles={elbow: 0.4}, rates={shoulder: -2.0, elbow: 0.1})
    run = simulate(system, 0.6, state=start, rtol=1e-11)
    event = next(x for x in run.events if "stop" in x.impulses)
    before, after = (int(np.searchsorted(run.t, event.t, side=side)) for side in ("left", "right"))
    v, turned = np.array([run.rate(x)[before] for x in (shoulder, elbow)]), run.angle(elbow)[before]
    c = 0.6 * 0.3 * np.cos(turned)
    free = np.linalg.inv([[0.05 + 0.09 + 0.36 + 0.14 + 2 * c, 0.14 + c], [0.14 + c, 0.14]])[0]
    assert v[1] - 1.5 * v[0] * free[1] / free[0] < -0.1  # of the elbow, if the stop pushed alone
    assert np.abs([run.rate(shoulder)[after - 1] + 0.5 * v[0], run.rate(elbow)[after - 1]]).max() < 1e-12
    assert set(event.impulses) >= {"stop", "pawls"}
    assert run.rate(elbow).min() > -1e-12 and run.certificate.passed


def winch_with_pawls(swing, frequency, teeth, drum, weight, stiffness):
    """A lever swings and takes a drum along, which a pawl holds; a weight hangs from it by an elastic rope."""
    lever = Body("lever", 1.0, (0.05, 0.05, 0.02))
    reel = Body("reel", 2.0, (0.1, 0.1, drum))
    load = Body("load", weight, (0.1, 0.1, 0.1), position=(RIM, -1.0, 0))
    hinge = Revolute(GROUND, reel, at=(0, 0, 0), axis="z", name="hinge")
    pivot = Revolute(GROUND, lever, at=(0, 0, 0.1), axis="z", name="pivot")
    between = Cylindrical(lever, reel, at=(0, 0, 0.05), axis="z", name="between")
    guide = Prismatic(GROUND, load, at=load.position, axis="y", name="guide")
    crank = AngleDriver(pivot, Constant(swing) + Sine(-swing, frequency, np.pi / 2), name="crank")
    damping = 0.02 * np.sqrt(stiffness * weight)
    rope = Rope((Winch(hinge, radius=RIM, sense=-1), (load, load.position)), stiffness=stiffness, damping=damping)
    pawls = [Freewheel(between, name="driving pawl"), Ratchet(hinge, teeth=teeth, name="holding pawl")]
    return System([reel, lever, load], [hinge, pivot, between, guide, crank], [*pawls, rope], gravity=(0, -9.81, 0))


def stepped(swing, frequency, teeth, drum, weight, stiffness, t_end, dt):
    """March angle of the drum and height of the weight in small steps, with the rates that the pawls allow."""
    pitch, w, c = 2 * np.pi / teeth, 2 * np.pi * frequency, 0.02 * np.sqrt(stiffness * weight)
    x, v, y, u, tooth = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(round(t_end / dt)):
        tension = max(0.0, stiffness * (RIM * x - y) + c * (RIM * v - u)) if RIM * x > y else 0.0
        u += dt * (tension / weight - 9.81)
        v += -dt * RIM * tension / drum
        v = max(v, swing * w * np.sin(w * (k + 1) * dt), (tooth - x) / dt)
        x, y = x + dt * v, y + dt * u
        tooth = max(tooth, np.floor(x / pitch) * pitch)
    return x, y


@pytest.mark.parametrize("seed", range(6))
def test_pawls_and_an_elastic_rope(seed):
    """Where the rope swings, a pawl lets go and is at rest at its tooth again and again, without load or rate."""
    rng = np.random.default_rng([seed, 7])
    given = (
        rng.uniform(0.2, 0.5), rng.uniform(0.8, 1.8), int(rng.integers(12, 40)), rng.uniform(0.01, 0.05),
        rng.uniform(3.0, 20.0), 10 ** rng.uniform(3.7, 4.5),
    )  # fmt: skip
    system = winch_with_pawls(*given)
    run = simulate(system, 1.2, state=system.assemble())
    assert run.certificate.passed and len(run.events) > 5
    assert run.rate("between").min() > -1e-8 * np.abs(run.rate("hinge")).max()  # a hundred times what events miss
    x, y = stepped(*given, 1.2, 2e-5)  # steps of first order: halved, they change the end by less than 3e-5
    assert np.isclose(run.angle("hinge")[-1], x, rtol=0.0, atol=6e-5)
    assert np.isclose(run.slide("guide")[-1], y, rtol=0.0, atol=6e-5)


@pytest.mark.parametrize("method", [DOP853(), RadauIIA(), GeneralizedAlpha(dt=0.01), RK4(dt=0.01)], ids=repr)
@pytest.mark.parametrize(
    "part",
    [
        Freewheel,
        lambda hinge: Ratchet(hinge, teeth=11),
        lambda hinge: Clutch(hinge, torque=2.0, engaged=True),
        lambda hinge: EndStop(hinge, upper=0.7, restitution=0.4),
    ],
)
def test_a_run_may_end_at_an_event_or_a_rounding_beside_it(part, method):
    body, hinge = shaft("wheel", 0.2, 0.0, omega=3.0 * AXIS)
    system = System([body], [hinge], [TorsionSpring(hinge, stiffness=0.8), part(hinge)])
    end = at_event = simulate(system, 5.0, method=method).events[0].t
    for _ in range(3):
        end = np.nextafter(end, -np.inf)
    for _ in range(7):
        run = simulate(system, end, method=method, output=[0.0, 0.3 * end, end])
        assert run.certificate.passed and abs(run.t[-1] - end) < 1e-15 and len(run.events) <= 1
        assert simulate(system, at_event + 0.01, method=method, state=run.final).certificate.passed
        end = np.nextafter(end, np.inf)


@pytest.mark.parametrize("torque", [0.0, 0.3])
def test_a_stop_that_throws_a_shaft_back_against_its_freewheel(torque):
    """The rebound is struck by the pawls in turn: the energy is gone, and the shaft stands."""
    axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    a, b = (Body(name, 1.0, (I, I, I)) for name, I in (("a", 0.2), ("b", 0.1)))
    h, k = (Revolute(GROUND, body, at=(0, 0, 0), axis=axis, name=f"hinge {body.name}") for body in (a, b))
    locks = [EndStop(h, upper=0.5, restitution=0.2, name="stop"), Freewheel(k, name="pawls"), Torque(a, torque * axis)]
    system = System([a, b], [h, k, Gear(h, k, ratio=1.0)], locks)
    run = simulate(system, 1.0, state=system.assemble(rates={k: 2.0}))
    when = 0.25 if torque == 0.0 else -2.0 + np.sqrt(5.0)
    assert np.allclose([event.t for event in run.events], when, rtol=1e-9, atol=0.0) and len(run.events) == 2
    assert run.energy().lost[-1] == pytest.approx(0.5 * 0.3 * 4.0 + 0.5 * torque, rel=1e-9)
    assert np.allclose([run.angle(h)[-1], run.rate(k)[-1]], [0.5, 0.0], rtol=1e-9, atol=1e-12)
    assert run.certificate.passed, str(run.certificate)
