"""Joints that engage, let go and break in a run, and what holds for every event: balances, files, restart, methods."""

from dataclasses import replace

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    RK4,
    Body,
    Breaks,
    EndStop,
    Fixed,
    Gear,
    GeneralizedAlpha,
    JointFriction,
    Kinematic,
    PointOnLine,
    Prismatic,
    RadauIIA,
    Revolute,
    Screw,
    Stepper,
    Switched,
    System,
    TorsionSpring,
    accelerations,
    load,
    measures,
    rotation,
    simulate,
)  # fmt: skip
from mbsd3d.rotations import matrix

R = matrix(rotation((0.3, -0.5, 0.8), 1.1))  # of whole cases, so that nothing lies along an axis
PLACE = np.array([0.7, -1.3, 0.4])
DOWN = -R[:, 2]


def test_a_pin_breaks_at_its_force():
    """Pendulum of a point mass that hangs on until 3 cos th - 2 cos th0 = F / (m g), then a parabola."""
    m, l, start, limit, H, g = 2.0, 0.7, 1.3, 40.0, 2.0, 9.81
    out = np.sin(start) * R[:, 0] + np.cos(start) * DOWN
    bob = Body("bob", m, (1e-9,) * 3, position=PLACE + l * out, omega=(0, 0, 0))
    pin = Breaks(Revolute(GROUND, bob, at=PLACE, axis=R[:, 1]), force=limit, name="pin")
    system = System([bob], [pin], gravity=g * DOWN)
    floor = measures.position(bob, axis=DOWN) > float(PLACE @ DOWN) + H
    run = simulate(system, 3.0, rtol=1e-11, stop_when=floor)
    (event,) = run.events
    assert event.what == "'pin' breaks" and not event.impulses and event.lost == 0.0
    at = int(np.searchsorted(run.t, event.t))
    assert run.t[at] == run.t[at + 1] == event.t
    arm = run.position(bob)[at] - PLACE
    assert abs(np.arctan2(arm @ R[:, 0], arm @ DOWN) - 0.5396059430111315) < 1e-8  # the moment of inertia counts 2e-9
    assert abs(event.t - 0.34539096733665925) < 1e-8
    assert abs(run.t[-1] - 0.7508270185242135) < 1e-8
    assert abs((run.position(bob)[-1] - PLACE) @ R[:, 0] + 0.6308105870334965) < 1e-8
    force = np.linalg.norm(run.reaction(pin).force, axis=1)
    assert force[at] == pytest.approx(limit, rel=1e-9) and (force[at + 1 :] == 0.0).all()
    assert np.allclose(run.measure(measures.reaction(pin)), force, rtol=1e-15, atol=1e-300)  # rounding of a norm
    assert run.certificate.passed and run.certificate.stopped_by.startswith("position of bob")


def door_and_latch():
    """Return the door of the truths, turned, that swings open at -0.9 rad with 1.8 rad/s, and its latch."""
    m, l, I, d = 20.0, 0.45, 5.4, 0.85
    inertia = R @ np.diag([1.35, 1.6, I - m * l * l]) @ R.T
    door = Body("door", m, inertia, com=l * R[:, 0], position=PLACE)
    hinge = Revolute(GROUND, door, at=PLACE, axis=R[:, 2], name="hinge")
    bolt = PointOnLine(GROUND, door, at=PLACE + d * R[:, 0], axis=R[:, 0], name="bolt")
    latch = Switched(bolt, engage=measures.angle(hinge) > 0.0, name="latch")
    house = System([door], [hinge, latch], gravity=(0, 0, 0))
    return house, hinge, latch, house.assemble(angles={hinge: -0.9}, rates={hinge: 1.8})


def test_a_door_falls_into_its_latch():
    house, hinge, latch, start = door_and_latch()
    run = simulate(house, 1.0, state=start, rtol=1e-11)
    (event,) = run.events
    assert abs(event.t - 0.5) < 1e-10 and abs(event.lost - 8.748) < 1e-10
    assert abs(event.impulses["latch"].force @ R[:, 1] + 11.435294117647059) < 1e-9
    assert abs(event.impulses["hinge"].force @ R[:, 1] + 4.764705882352941) < 1e-9
    at = int(np.searchsorted(run.t, event.t))
    assert run.t[at] == run.t[at + 1]
    assert np.abs(run.rate(hinge)[at : at + 2] - (1.8, 0.0)).max() < 1e-10
    assert np.abs(run.energy().lost[[at, at + 1]] - (0.0, event.lost)).max() == 0.0
    assert run.certificate.passed
    assert run.certificate["energy balance"].error < 1e-12 and run.certificate["momentum balance"].error < 1e-9


def test_balances_see_an_impulse_or_a_loss_that_is_left_out():
    house, _, _, start = door_and_latch()
    run = simulate(house, 1.0, state=start)
    without = replace(run, events=tuple(replace(event, lost=0.0) for event in run.events))
    assert not without.certificate["energy balance"].passed
    arrays = {name: array.copy() for name, array in run.arrays.items()}
    arrays["z"][:, -6:] = 0.0
    assert not replace(run, arrays=arrays).certificate["momentum balance"].passed


def test_free_bodies_are_joined_in_flight_and_keep_their_momenta():
    one = Body("one", 2.0, (0.1, 0.2, 0.25), com=(0.1, -0.05, 0.07), velocity=(1, 0.5, -0.2), omega=(0, 0.4, 3.0))
    two = Body(
        "two", 3.0, (0.3, 0.15, 0.2), com=(-0.02, 0.1, 0), position=(0.6, 0.3, 0.1),
        orientation=rotation((1, 2, 1), 0.4), velocity=(-0.5, 0, 0.3), omega=(1.0, -2.0, 0),
    )  # fmt: skip
    near = measures.distance(one, two)
    weld = Switched(Fixed(one, two, at=(9.0, 1.0, 2.0)), engage=near < 0.5, release=near > 9.0, name="weld")
    system = System([one, two], [weld], gravity=(0.3, -0.2, 0.5))
    run = simulate(system, 2.0, rtol=1e-10)
    (event,) = run.events
    at = int(np.searchsorted(run.t, event.t))
    p, L = run.momentum().linear, run.momentum().angular
    assert np.abs(p[at] - p[at + 1]).max() < 1e-14 * 10 and np.abs(L[at] - L[at + 1]).max() < 1e-14 * 10
    T = run.energy().kinetic
    assert event.lost > 0.1 and abs(T[at] - T[at + 1] - event.lost) < 1e-12
    apart = run.omega(one) - run.omega(two)
    assert np.abs(apart[: at + 1]).max() > 1.0 and np.abs(apart[at + 1 :]).max() < 1e-8
    assert run.certificate.passed


def geared(shape=measures.angle, lower=-0.5):
    """Return two links whose gear engages and lets go again and again, and a start with several turns."""
    door = Body("door", 20.0, (3.0, 3.4, 1.35), com=(0.45, 0.1, 0.05))
    arm = Body("arm", 3.0, (0.3, 0.4, 0.35), com=(0.15, 0.1, 0.05), position=(1, 0, 0))
    hinges = [
        Revolute(GROUND, door, at=(0, 0, 0), axis=(0, 0.3, 1), name="shoulder"),
        Revolute(door, arm, at=(1, 0, 0), axis=(0, 0.3, 1), name="elbow"),
    ]
    gear = Switched(
        Gear(*hinges, ratio=0.7), engage=shape(hinges[0]) > 0.0, release=shape(hinges[0]) < lower, name="gear"
    )
    forces = [TorsionSpring(hinges[0], stiffness=20.0), JointFriction(hinges[1], viscous=0.1)]
    system = System([door, arm], [*hinges, gear], forces)
    return system, system.assemble(angles={"shoulder": -0.9, "elbow": 7.0}, rates={"shoulder": 1.8, "elbow": -3.0})


def test_a_gear_engages_where_it_is_and_hinges_count_on():
    system, start = geared()
    run = simulate(system, 6.0, state=start)
    assert [event.action for event in run.events] == ["engages", "is released"] * 2
    assert run.certificate.passed
    for begin, end in ((0, 1), (2, 3)):
        some = (run.t > run.events[begin].t) & (run.t < run.events[end].t)
        left = run.angle("elbow") - 0.7 * run.angle("shoulder")
        assert some.sum() > 3 and np.ptp(left[some]) < 1e-8
    assert np.abs(np.diff(run.angle("elbow"))).max() < 3.0  # no turn is lost
    doubled = np.flatnonzero(np.diff(run.t) == 0.0)
    assert run.t[doubled].tolist() == [event.t for event in run.events]
    assert np.abs(run.angle("elbow")[doubled] - run.angle("elbow")[doubled + 1]).max() < 1e-14


def test_files_restart_and_states_between_events(tmp_path):
    system, start = geared()
    run = simulate(system, 4.0, state=start, rtol=1e-10)
    other = load(run.save(tmp_path / "run"))
    assert str(other.certificate) == str(run.certificate)
    assert [repr(event) for event in other.events] == [repr(event) for event in run.events]
    assert np.array_equal(other.reaction("gear").moment, run.reaction("gear").moment)
    assert np.abs(run.reaction("gear").moment).max() > 1.0
    again = System.from_file(system.to_file(tmp_path / "gear.toml"))
    assert np.array_equal(simulate(again, 4.0, state=start, rtol=1e-10).position("arm"), run.position("arm"))
    part = simulate(system, 1.7, state=start, rtol=1e-10)
    assert part.final.modes["gear"][0] == "engaged"
    rest = simulate(system, 4.0, state=part.final, rtol=1e-10)
    assert np.abs(rest.final.q - run.final.q).max() < 1e-8 and len(rest.events) == len(run.events) - 1
    middle = run.at(1.7)
    assert np.abs(middle.q - part.final.q).max() < 1e-8 and middle.modes == part.final.modes
    a = accelerations(system, part.final)
    assert np.abs(a.reaction("gear").moment - part.reaction("gear").moment[-1]).max() < 1e-9
    assert run.estimate().error < 1e-7
    even = simulate(system, 4.0, state=start, output=41)
    assert even.t.size == 41 + 2 * len(even.events) and np.isin(np.linspace(0, 4, 41), even.t).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("method", "error"),
    [(RadauIIA(), 1e-6), (RK4(1e-3), 1e-8), (GeneralizedAlpha(1e-3), 1e-4)],  # third to eighth order, and the second
    ids=lambda x: type(x).__name__,
)
def test_methods_land_at_the_same_events(method, error):
    system, start = geared()
    exact, run = (simulate(system, 6.0, state=start, **x) for x in ({"rtol": 1e-10}, {"method": method}))
    assert run.certificate.passed and len(run.events) == 4
    assert max(abs(a.t - b.t) for a, b in zip(run.events, exact.events, strict=True)) < error


def test_what_touches_change_adds_up_over_the_pieces():
    """A block drops onto a damped stop; a light one that it takes along as it is deepest makes an event in between."""
    block, load = (Body(name, m, (m, m, m), position=PLACE) for name, m in (("block", 1.0), ("load", 0.01)))
    rail = Prismatic(GROUND, block, at=PLACE, axis=R[:, 2], name="rail")
    taken = Switched(Fixed(block, load, at=PLACE), engage=measures.slide(rail) < -0.3, name="taken")
    beside = Prismatic(GROUND, load, at=PLACE, axis=R[:, 2])
    stop = EndStop(rail, lower=-0.2, stiffness=300.0, damping=2.0, name="stop")
    system = System([block, load], [rail, beside, taken], [stop], gravity=9.81 * DOWN)
    run = simulate(system, 1.5, method=GeneralizedAlpha(dt=1e-3))
    changes = [piece.record.jump for piece in run.pieces]
    assert len(changes) == 2 and min(changes) > 0.0
    assert run.certificate["contacts"].error == pytest.approx(sum(changes), rel=1e-12)
    assert "'stop'" in run.certificate["contacts"].meaning


def test_what_cannot_switch_is_refused():
    system, start = geared()
    with pytest.raises(ValueError, match="Kinematic finds poses from drivers alone, and 'gear' switches"):
        simulate(system, 1.0, state=start, method=Kinematic())
    with pytest.raises(ValueError, match=r"Stepper: 'gear' \(Switched\) switches at events"):
        Stepper(system, start)
    a, b = (Body(name, 1.0, (1, 1, 1)) for name in "ab")
    pin = Revolute(GROUND, a, at=(0, 0, 0), axis=(0, 0, 1))
    with pytest.raises(ValueError, match=r"cannot be switched; end the run and use system\.engage"):
        Switched(Screw(a, b, at=(0, 0, 0), axis=(0, 0, 1), pitch=0.1), engage=measures.angle(pin) > 1.0)
    geared_motor = Revolute(GROUND, b, at=(0, 0, 0), axis=(0, 0, 1), reflected_inertia=0.2)
    with pytest.raises(ValueError, match="has a reflected inertia, which would come and go"):
        Breaks(geared_motor, force=9.0)
    with pytest.raises(ValueError, match="never engages; give engage="):
        Switched(Fixed(a, b, at=(0, 0, 0)), release=measures.angle(pin) > 1.0)
    with pytest.raises(ValueError, match="is not a condition; write e.g."):
        Switched(Fixed(a, b, at=(0, 0, 0)), engage=1.0)
    twice = System([a], [pin, Breaks(Revolute(GROUND, a, at=(0, 0, 1), axis=(0, 0, 1)), force=9.0, name="second")])
    with pytest.raises(ValueError, match="reaction force of second is not determined"):
        simulate(twice, 1.0)
    fallen = simulate(System([a], [pin]), 0.1).final
    with pytest.raises(ValueError, match="'gone' does not switch in this system"):
        simulate(System([a], [pin]), 1.0,
                 state=replace(fallen, t=0.0, modes={"gone": ("open", ())}))  # fmt: skip
    with pytest.raises(ValueError, match=r"'gear' has no mode \('engaged', \(1\.0,\)\)"):
        simulate(system, 1.0, state=replace(start, modes={"gear": ("engaged", (1.0,))}))


def test_a_condition_that_has_just_come_true_acts_when_it_comes_true_again():
    """The value at which a gear engages also lets it go: not at once, but at the next rise through it."""
    bodies = [Body(name, 1.0, (1, 1, 1), com=(0.3, 0, 0)) for name in "ab"]
    hinges = [Revolute(GROUND, x, at=(0, 0, 0), axis=(0, 0.4, 1), name=x.name + " hinge") for x in bodies]
    rise = measures.angle(hinges[0]) > 0.1
    coupling = Switched(Gear(*hinges, ratio=-1.0), engage=rise, release=rise, name="coupling")
    system = System(bodies, [*hinges, coupling], [TorsionSpring(hinges[0], stiffness=20.0)], gravity=(0, 0, 0))
    run = simulate(system, 6.0, state=system.assemble(rates={hinges[0]: 1.0}))
    assert [event.action for event in run.events] == ["engages", "is released"] * (len(run.events) // 2)
    assert len(run.events) >= 2 and run.events[1].t - run.events[0].t > 0.5
    angle, t = run.angle(hinges[0]), run.t
    rises = t[1:][(angle[:-1] < 0.1 - 1e-9) & (angle[1:] >= 0.1 - 1e-9)]  # events lie on the value to rounding
    assert rises.tolist() == [event.t for event in run.events] and run.certificate.passed


def carriages(gap):
    """Three bodies on slides along a general axis: at 0.5 m the first lets go of its load and catches the third."""
    along, aside = R[:, 0], R[:, 1]
    bodies = [
        Body(name, mass, (0.1, 0.1, 0.1), position=PLACE + k * aside, velocity=speed * along, omega=(0, 0, 0))
        for k, (name, mass, speed) in enumerate((("car", 2.0, 1.3), ("load", 1.5, 1.3), ("third", 0.7, 0.0)))
    ]
    slides = [Prismatic(GROUND, body, at=body.position, axis=along, name=f"slide of {body.name}") for body in bodies]
    car, load, third = bodies
    way = measures.slide(slides[0])
    drop = Switched(Fixed(car, load, at=PLACE), engaged=True, release=way > 0.5, name="drop")
    catch = Switched(Fixed(car, third, at=PLACE), engage=way > 0.5 + gap, name="catch")
    fast = measures.slide_rate(slides[2]) > 0.4
    latch = Switched(Fixed(third, load, at=PLACE), engage=fast, name="latch")
    return bodies, way, System(bodies, [*slides, drop, catch, latch], gravity=9.81 * aside)


@pytest.mark.parametrize("gap", [0.0, 1e-7])
@pytest.mark.parametrize("method", [None, RK4(0.013), GeneralizedAlpha()])
def test_conditions_that_come_true_together_or_by_an_impact_all_act(method, gap):
    """Plastic impacts: 2 kg take 0.7 kg along, and both, now faster than 0.4 m/s, the load that has been dropped."""
    bodies, way, system = carriages(gap)
    run = simulate(system, 1.0, method=method)
    assert [event.part for event in run.events] == ["drop", "catch", "latch"] and run.certificate.passed
    assert np.allclose([event.t for event in run.events], 0.5 / 1.3, rtol=0, atol=1e-6)
    caught = 2.0 * 1.3 / 2.7
    joined = (2.7 * caught + 1.5 * 1.3) / 4.2
    lost = (0.5 * (2.0 * 1.3**2 - 2.7 * caught**2), 0.5 * (2.7 * caught**2 + 1.5 * 1.3**2 - 4.2 * joined**2))
    assert np.allclose([event.lost for event in run.events], (0.0, *lost), rtol=1e-9, atol=1e-12)
    assert np.allclose([run.velocity(body)[-1] @ R[:, 0] for body in bodies], joined, rtol=1e-9, atol=0)


def test_a_stop_at_the_time_of_an_event_ends_the_run():
    _, way, system = carriages(0.0)
    run = simulate(system, 1.0, stop_when=way > 0.5)
    assert abs(run.t[-1] - 0.5 / 1.3) < 1e-9 and "at t" in str(run.certificate)
