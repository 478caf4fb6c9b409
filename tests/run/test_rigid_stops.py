"""Rigid stops: closed forms of falling and bouncing parts, several stops at once, rest, and what is refused."""

from itertools import combinations

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    RK4,
    AngleDriver,
    Body,
    EndStop,
    Planar,
    PointStop,
    Polynomial,
    Prismatic,
    Revolute,
    Stepper,
    System,
    Torque,
    load,
    measures,
    rotation,
    simulate,
)  # fmt: skip
from mbsd3d.errors import AssemblyError, IntegrationError
from mbsd3d.rotations import matrix

R = matrix(rotation((0.3, -0.5, 0.8), 1.1))
PLACE = np.array([0.7, -1.3, 0.4])


def test_a_slide_falls_onto_its_stop_and_comes_to_rest(tmp_path):
    h, e, g = 0.5, 0.6, 9.81
    sled = Body("sled", 2.0, (0.1, 0.2, 0.25), com=(0.1, 0.05, 0.2), position=PLACE, velocity=(0, 0, 0))
    rail = Prismatic(GROUND, sled, at=PLACE + R[:, 0], axis=R[:, 2], name="rail")
    stop = EndStop(rail, lower=-h, restitution=e, name="stop")
    system = System([sled], [rail], [stop], gravity=-g * R[:, 2])
    run = simulate(system, 2.0, rtol=1e-11)
    hits = [event for event in run.events if event.impulses]
    assert abs(hits[0].t - 0.3192754284070505) < 1e-10 and abs(hits[2].t - 0.9322842509485874) < 1e-10
    after = int(np.searchsorted(run.t, hits[4].t, side="right")) - 1
    assert abs(run.rate(rail)[after] - 0.24355147023986531) < 1e-9
    assert abs(hits[-1].rest - 1.277101713628202) < 1e-9 and "comes to rest" in hits[-1].action
    assert abs(sum(event.lost for event in hits) - 2.0 * g * h) < 1e-9
    assert abs(hits[0].impulses["stop"].force @ R[:, 2] - 2.0 * np.sqrt(2 * g * h) * (1 + e)) < 1e-9
    assert run.slide(rail).min() > -h - 1e-12 and abs(run.slide(rail)[-1] + h) < 1e-12
    assert abs(run.force(stop).force[-1] @ R[:, 2] - 2.0 * g) < 1e-9  # it carries the weight
    assert run.certificate.passed
    other = load(run.save(tmp_path / "run"))
    assert str(other.certificate) == str(run.certificate) and other.events[-1].rest == hits[-1].rest


@pytest.mark.parametrize("output", [None, 11, 1001])
def test_impacts_of_a_bouncing_ball_do_not_depend_on_its_samples(output):
    """h = 1 m, e = 0.7: sqrt(2 h / g) (1 + 2 e + 2 e^2 + ...), and the heights e^2k h between them."""
    ball = Body("ball", 0.4, (0.001, 0.001, 0.001), position=(0, 0, 1.0), velocity=(0, 0, 0))
    rail = Prismatic(GROUND, ball, at=(0, 0, 1.0), axis=(0, 0, 1), name="rail")
    run = simulate(System([ball], [rail], [EndStop(rail, lower=-1.0, restitution=0.7)]), 2.3, output=output, rtol=1e-11)
    hits = [event.t for event in run.events if event.impulses]
    known = [0.4515236409857309, 1.083656738365754, 1.5261499065317703, 1.8358951242479817, 2.0527167766493295,
             2.204491933330273]  # fmt: skip
    assert hits == pytest.approx(known, abs=1e-10)
    tops = [float(run.at(0.5 * (one + other)).q[2]) for one, other in zip(hits[:-1], hits[1:], strict=True)]
    assert tops == pytest.approx([0.49, 0.2401, 0.117649, 0.05764801, 0.0282475249], abs=1e-9)


def test_a_bar_on_a_hinge_bounces_onto_its_stop():
    m, l, c, g = 2.0, 0.4, 12.0, 9.81
    I = m * g * l / c - m * l * l
    inertia = R @ np.diag([0.3, I, 0.32]) @ R.T
    bar = Body("bar", m, inertia, com=l * R[:, 0], position=PLACE)
    hinge = Revolute(GROUND, bar, at=PLACE, axis=R[:, 1], name="hinge")
    stop = EndStop(hinge, upper=0.9, restitution=0.5, name="stop")
    system = System([bar], [hinge], [stop], gravity=-g * R[:, 2])
    run = simulate(system, 2.5, state=system.assemble(angles={hinge: -0.3}), rtol=1e-11)
    times = [event.t for event in run.events]
    assert abs(run.rate(hinge)[np.searchsorted(run.t, times[0])] - 5.088450726000179) < 1e-9
    assert np.abs(np.array(times)[[0, 1, 3]] - (0.4547485485409426, 0.995342410308342, 1.4772404545903546)).max() < 1e-9
    assert abs(run.events[-1].rest - 1.6472315921660663) < 2e-9
    assert run.angle(hinge).max() < 0.9 + 1e-9 and run.rate(hinge)[-1] == pytest.approx(0.0, abs=1e-12)
    assert run.certificate.passed


def test_a_stop_stands_at_a_counted_angle():
    disc = Body("disc", 1.0, (0.2, 0.2, 0.3), position=PLACE, orientation=rotation((1, 2, -1), 0.6))
    axis = matrix(disc.orientation)[:, 2]
    hinge = Revolute(GROUND, disc, at=PLACE, axis=axis, name="hinge")
    stop = EndStop(hinge, upper=21.991148575128552, restitution=0.4, name="stop")
    system = System([disc], [hinge], [stop, Torque(disc, 0.6 * axis)], gravity=(0, 0, 0))
    run = simulate(system, 12.0, rtol=1e-11)
    first, second = run.events[:2]
    assert abs(first.t - 4.689472099834751) < 1e-8
    assert abs(run.rate(hinge)[np.searchsorted(run.t, first.t)] - 9.378944199669503) < 1e-8
    top = run.at(0.5 * (first.t + second.t))  # constant torque: halfway between the impacts
    assert abs(top.coordinates[0] - 18.472564803107986) < 1e-8
    assert abs(run.events[-1].rest - 10.942101566281087) < 1e-8
    assert run.certificate.passed


def two_links(stops):
    """Return a plane double pendulum, its joints, and its mass matrix at an angle of the elbow, angles relative."""
    m, l, I, L = (2.0, 1.0), (0.3, 0.25), (0.05, 0.02), 0.6
    bodies, across = [], -R[:, 1]
    for k, name in enumerate(("upper", "lower")):
        C = R @ np.diag([I[k], I[k], 0.3 * I[k]]) @ R.T
        bodies.append(Body(name, m[k], C, com=-l[k] * R[:, 2], position=PLACE - k * L * R[:, 2]))
    hinges = [
        Revolute(GROUND, bodies[0], at=PLACE, axis=across, name="shoulder"),
        Revolute(*bodies, at=bodies[1].position, axis=across, name="elbow"),
    ]
    forces = [EndStop(hinge, **own, name=f"stop of {hinge.name}") for hinge, own in zip(hinges, stops, strict=True)]

    def mass(elbow):
        c = m[1] * L * l[1] * np.cos(elbow)
        M = np.array([[I[0] + m[0] * l[0] ** 2 + m[1] * L**2, c], [c, I[1] + m[1] * l[1] ** 2]])
        T = np.array([[1.0, 0.0], [1.0, 1.0]])
        return T.T @ M @ T

    return System(bodies, hinges, forces, gravity=-9.81 * R[:, 2]), hinges, mass


def impact(M, v, e):
    """Return the rates after both upper stops are closed, by trying which take part."""
    W = np.linalg.inv(M)
    for count in range(3):
        for some in map(list, combinations(range(2), count)):
            P = np.zeros(2)
            if some:
                P[some] = np.linalg.solve(W[np.ix_(some, some)], ((1 + e) * v)[some])
            u = v - W @ P
            if (P >= -1e-12).all() and (-u - e * v >= -1e-12).all():
                return u, P
    raise AssertionError


@pytest.mark.parametrize(
    ("e", "v"),
    [((0.5, 0.3), (2.0, 1.0)), ((0.7, 0.9), (3.0, -8.0)), ((0.0, 0.0), (2.0, 1.0)), ((0.2, 0.2), (-0.3, 9.0))],
)
def test_two_stops_are_struck_at_once(e, v):
    """One complementarity problem: also where a stop is struck only because the other one is."""
    system, hinges, mass = two_links([{"upper": 0.7, "restitution": e[0]}, {"upper": -0.9, "restitution": e[1]}])
    start = system.assemble(angles={hinges[0]: 0.7, hinges[1]: -0.9}, rates=dict(zip(hinges, v, strict=True)))
    run = simulate(system, 0.01, state=start)
    expected, P = impact(mass(-0.9), np.array(v), np.array(e))
    got = np.array([run.rate(hinge)[1] for hinge in hinges])
    assert np.abs(got - expected).max() < 1e-12
    (event,) = run.events[:1]
    for k, hinge in enumerate(hinges):
        impulse = event.impulses.get(f"stop of {hinge.name}")
        assert abs(P[k] - (0.0 if impulse is None else impulse.moment @ R[:, 1])) < 1e-12
    assert abs(event.lost - 0.5 * (np.array(v) @ mass(-0.9) @ v - got @ mass(-0.9) @ got)) < 1e-12 and event.lost > 0.0
    for later in range(2, 1 + len(run.events)):  # what an impact throws back against the stop that it was leaving
        expected, _ = impact(mass(-0.9), expected, np.array(e))
        assert np.abs([run.rate(hinge)[later] for hinge in hinges] - expected).max() < 1e-12
    assert (expected < 1e-12).all()  # away from both upper limits
    assert run.certificate.passed


def test_an_impact_that_would_give_energy_is_refused():
    """Newton's law with different restitutions of coupled stops: 0.34 J from nothing."""
    system, hinges, _ = two_links([{"upper": 0.7, "restitution": 0.2}, {"upper": -0.9, "restitution": 1.0}])
    start = system.assemble(angles={hinges[0]: 0.7, hinges[1]: -0.9}, rates={hinges[0]: -0.3, hinges[1]: 9.0})
    with pytest.raises(IntegrationError, match=r"would give 0.342 J at .*give them one restitution, or stiffness="):
        simulate(system, 0.1, state=start)


def test_a_pendulum_between_stops_keeps_all_balances():
    """Some fifteen impacts of both links on four stops; the certificate adds what they take and give."""
    both = [{"lower": -0.3, "upper": 0.7, "restitution": 0.5}, {"lower": -0.5, "upper": 0.3, "restitution": 0.6}]
    system, hinges, _ = two_links(both)
    run = simulate(system, 6.0, state=system.assemble(angles={hinges[0]: 0.5, hinges[1]: 0.1}), rtol=1e-10)
    assert len(run.events) > 10 and run.certificate.passed
    for hinge, own in zip(hinges, both, strict=True):
        assert run.angle(hinge).min() > own["lower"] - 1e-9 and run.angle(hinge).max() < own["upper"] + 1e-9
    energy = run.energy()
    assert np.abs(np.diff(energy.total + energy.lost)).max() < 1e-8


def test_a_closed_stop_opens_where_its_load_changes_sign():
    """A torque that turns over pulls the disc off its stop at t = 1: then 0.6 (t - 1)^3 / 6 / I."""
    disc = Body("disc", 1.0, (0.2, 0.2, 0.3), position=PLACE)
    hinge = Revolute(GROUND, disc, at=PLACE, axis=(0, 0, 1), name="hinge")
    pull = Torque(disc, (0, 0, Polynomial((-0.6, 0.6))))
    system = System([disc], [hinge], [EndStop(hinge, lower=0.0, restitution=0.5, name="stop"), pull])
    run = simulate(system, 2.0, rtol=1e-11)
    (event,) = run.events
    assert event.what == "'stop' is left" and abs(event.t - 1.0) < 1e-10
    assert abs(run.angle(hinge)[-1] - 0.6 / 6 / 0.3) < 1e-9
    assert abs(run.force("stop").moment[0, 2] - 0.6) < 1e-12 and run.certificate.passed


def test_a_soft_stop_approaches_the_rigid_one():
    """Impact by a stiff spring without damping against restitution 1: apart by half the time of touch."""
    angles = []
    for own in ({"restitution": 1.0}, {"stiffness": 1e9}):
        disc = Body("disc", 1.0, (0.2, 0.2, 0.3), omega=(0, 0, 2.0))
        hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
        run = simulate(System([disc], [hinge], [EndStop(hinge, upper=1.0, **own)]), 1.0)
        angles.append(run.angle(hinge)[-1])
    assert abs(angles[0]) < 1e-9
    assert angles[1] - angles[0] == pytest.approx(2.0 * np.pi * np.sqrt(0.3 / 1e9), rel=1e-3)


def test_what_is_refused():
    disc = Body("disc", 1.0, (0.2, 0.2, 0.3))
    hinge = Revolute(GROUND, disc, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    for own in ({}, {"stiffness": 1.0, "restitution": 0.5}):
        with pytest.raises(ValueError, match="give either stiffness= of a stop that yields, or restitution="):
            EndStop(hinge, upper=1.0, **own)
    for own in ({"restitution": 1.2}, {"restitution": 0.5, "damping": 1.0}):
        with pytest.raises(ValueError, match=r"give 0 \.\.\. 1, and no damping"):
            EndStop(hinge, upper=1.0, **own)
    system = System([disc], [hinge], [EndStop(hinge, upper=1.0, restitution=0.5, name="stop")])
    with pytest.raises(ValueError, match="the run starts 0.5 beyond its limit"):
        simulate(system, 1.0, state=system.assemble(angles={hinge: 1.5}))
    with pytest.raises(ValueError, match=r"Stepper: 'stop' \(EndStop\) switches at events"):
        Stepper(system)
    driver = AngleDriver(hinge, Polynomial((0.0, 2.0)), name="driver")
    with pytest.raises(AssemblyError, match="two of them ask for different motions"):
        simulate(System([disc], [hinge, driver], system.forces), 1.0)


def test_a_run_ends_behind_an_impact_that_makes_its_condition_come_true(tmp_path):
    drum = Body("drum", 2.0, R @ np.diag([0.3, 0.4, 0.5]) @ R.T, position=PLACE, omega=5.0 * R[:, 2])
    hinge = Revolute(GROUND, drum, at=PLACE, axis=R[:, 2], name="hinge")
    stop = EndStop(hinge, upper=6.0, restitution=0.5, name="stop")
    system = System([drum], [hinge], [stop])
    run = simulate(system, 8.0, rtol=1e-11, stop_when=measures.rate(hinge) < 0.0)
    assert abs(run.t[-1] - 1.2) < 1e-10 and abs(run.rate(hinge)[-1] + 2.5) < 1e-10
    assert abs(run.rate(hinge)[-2] - 5.0) < 1e-10 and len(run.events) == 1
    assert "rate of hinge < 0" in run.record.stopped_by
    assert run.certificate.passed
    other = load(run.save(tmp_path / "run"))
    assert str(other.certificate) == str(run.certificate) and other.t.size == run.t.size
    # struck at the start
    first = simulate(system, 8.0, state=system.assemble(angles={hinge: 6.0}), stop_when=measures.rate(hinge) < 0.0)
    assert first.t.tolist() == [0.0, 0.0] and abs(first.rate(hinge)[-1] + 2.5) < 1e-12


def test_a_condition_that_has_not_been_false_since_the_start_waits_through_an_impact():
    drum = Body("drum", 2.0, R @ np.diag([0.3, 0.4, 0.5]) @ R.T, position=PLACE, omega=5.0 * R[:, 2])
    hinge = Revolute(GROUND, drum, at=PLACE, axis=R[:, 2], name="hinge")
    system = System([drum], [hinge], [EndStop(hinge, lower=-3.0, upper=6.0, restitution=0.5)])
    run = simulate(system, 20.0, rtol=1e-11, stop_when=measures.angle(hinge) > 0.0)
    # to 6 at 5, back to -3 at 2.5, and to 0 again at 1.25 rad/s
    assert abs(run.t[-1] - (6 / 5 + 9 / 2.5 + 3 / 1.25)) < 1e-10 and abs(run.angle(hinge)[-1]) < 1e-10


def test_a_run_that_is_struck_at_its_start_keeps_its_options():
    drum = Body("drum", 2.0, R @ np.diag([0.3, 0.4, 0.5]) @ R.T, position=PLACE, omega=5.0 * R[:, 2])
    hinge = Revolute(GROUND, drum, at=PLACE, axis=R[:, 2], name="hinge")
    system = System([drum], [hinge], [EndStop(hinge, upper=6.0, restitution=0.5)])
    run = simulate(system, 0.5, state=system.assemble(angles={hinge: 6.0}), method=RK4(dt=0.01))
    assert len(run.events) == 1 and run.record.method == RK4(dt=0.01)


@pytest.mark.parametrize(("feet", "e"), [((-0.31, 0.27), 0.0), ((-0.35, 0.33), 0.4), ((-0.28, 0.36), 0.7)])
def test_a_bar_that_rocks_from_foot_to_foot_comes_to_rest(feet, e):
    """Each foot lifts the other one, ever lower, until that is not seen: no row of impacts within microseconds."""
    tilt, J = 0.23, 0.3
    bar = Body("bar", 2.0, (J, J, J), position=(0, 0, 0.3), orientation=rotation("y", tilt), omega=(0, 0.4, 0))
    along = np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
    plane = Planar(GROUND, bar, at=bar.position, normal=(0, 1, 0))
    given = {"at": (0, 0, 0), "axis": (0, 0, 1), "lower": 0.0, "restitution": e}
    stops = [PointStop(GROUND, bar, at_b=bar.position + x * along, name=f"{x}", **given) for x in feet]
    run = simulate(System([bar], [plane], stops), 3.0)
    times = np.array([event.t for event in run.events])
    assert run.certificate.passed and 4 < times.size < 150 and "comes to rest" in run.events[-1].what
    assert np.diff(times).min() > 1e-5  # a hop of 1e-8 m takes 9e-5 s, and of the tilted bar somewhat less
    assert np.abs(run.velocity(bar)[-1]).max() < 1e-9 and abs(run.position(bar)[-1, 2]) < 1e-9  # rests on both
    assert all(run.force(stop).force[-1, 2] > 1.0 for stop in stops)
    assert np.isclose(sum(event.lost for event in run.events), 2.0 * 9.81 * 0.3 + 0.5 * J * 0.4**2, rtol=1e-8, atol=0.0)
