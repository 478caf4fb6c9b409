"""Ropes: closed forms over pulleys that turn and slip, tackles, winches, slack, counted wraps, what is refused."""

from math import log, pi

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    RK4,
    AngleDriver,
    Body,
    DryFriction,
    EndStop,
    Force,
    Prismatic,
    Pulley,
    Revolute,
    Rope,
    SpeedDriver,
    StateFeedback,
    Stepper,
    System,
    Torque,
    Winch,
    linearize,
    measures,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix

G = 9.81
TURN = matrix(rotation((1, -2, 2), 0.7))  # so that no axis of the models is along one of the world
UP, OVER, SIDE = TURN[:, 2], TURN[:, 1], TURN[:, 0]  # against gravity, along axles, from left to right
GRAVITY = -G * UP


def place(x, z):
    """A point of the plane of the rope."""
    return x * SIDE + z * UP


def weight(name, mass, x, z, speed=0.0):
    """A weight whose rope is held off its centre of mass, on a vertical guide, with its speed upwards."""
    velocity = None if speed is None else speed * UP
    body = Body(name, mass, (0.2, 0.3, 0.25), com=(0.1, 0.2, -0.1), position=place(x, z), velocity=velocity)
    return body, Prismatic(GROUND, body, at=place(x, z), axis=UP, name=f"guide of {name}")


def over_a_drum(m1, m2, radius, mu, J=None, mass=2.0, turns=0, speed=0.0, **rope):
    """Two weights on a rope over a drum: GROUND, or one that turns with the inertia J."""
    (one, left), (two, right) = weight("one", m1, -radius, -2.0, -speed), weight("two", m2, radius, -2.6, speed)
    bodies, joints, on = [one, two], [left, right], GROUND
    if J is not None:
        turning = dict(orientation=rotation((1, 2, -1), 0.8), omega=speed / radius * -OVER)
        bodies.append(Body("drum", mass, (J, J, J), **turning))
        on = Revolute(GROUND, bodies[-1], at=(0, 0, 0), axis=-OVER, name="axle")
        joints.append(on)
    wheel = Pulley(on, radius=radius, sense=1 if on is GROUND else -1, centre=(0, 0, 0), axis=OVER, turns=turns)
    if on is not GROUND:
        wheel = Pulley(on, radius=radius, sense=-1, turns=turns)
    ends = ((one, one.position), (two, two.position))
    given = {"stiffness": 4e4, "damping": 900.0, "pretension": 40.0} | rope
    return System(bodies, joints, [Rope(ends, wheel, mu=mu, name="rope", **given)], gravity=GRAVITY)


def up(run, name):
    return run.acceleration(name)[-1] @ UP


@pytest.mark.parametrize(("m1", "m2", "J", "R"), [(10.0, 3.0, 0.05, 0.15), (4.0, 5.5, 0.09, 0.23)])
def test_a_drum_that_turns_with_the_rope(m1, m2, J, R):
    """Atwood with inertia; tensions and the load of the bearing; settled after thirty times its slowest decay."""
    run = simulate(over_a_drum(m1, m2, R, None, J), 0.8, rtol=1e-11, output=4)
    a = (m1 - m2) * G / (m1 + m2 + J / R**2)
    assert -up(run, "one") == pytest.approx(a, rel=1e-8)
    tensions = run.force("rope").tension[-1]
    assert tensions == pytest.approx([m1 * (G - a), m2 * (G + a)], rel=1e-8)
    bearing = np.linalg.norm(run.reaction("axle").force[-1])
    assert bearing == pytest.approx(tensions.sum() + 2.0 * G, rel=1e-8)
    assert run.force("rope").wrap[-1] == pytest.approx([pi], abs=1e-12)
    assert run.certificate.passed


@pytest.mark.parametrize(("m1", "m2", "mu", "turns"), [(10.0, 3.0, 0.25, 0), (40.0, 1.9, 0.3, 1)])
def test_a_rope_slips_over_a_rough_drum(m1, m2, mu, turns):
    """The drum of the capstan holds T1 e^(mu phi); beyond, the rope slips at that ratio, in one sense or the other."""
    k = np.exp(mu * (1 + 2 * turns) * pi)
    a = (m1 - k * m2) * G / (m1 + k * m2)
    for first, second, side in ((m1, m2, "one"), (m2, m1, "two")):
        run = simulate(over_a_drum(first, second, 0.15, mu, turns=turns), 1.0, rtol=1e-10, output=101)
        assert -up(run, side) == pytest.approx(a, rel=1e-8)
        tensions = run.force("rope").tension[-1]
        assert tensions.max() / tensions.min() == pytest.approx(k, rel=1e-9)
        slipped = run.force("rope").states["slip 1"][-1] * (1 if side == "two" else -1)
        assert slipped == pytest.approx(-run.slide(f"guide of {side}")[-1], abs=0.02)  # less the stretch
        assert run.certificate.passed
    held = simulate(over_a_drum(0.999 * k * m2, m2, 0.15, mu, turns=turns, damping=3e3), 20.0, rtol=1e-8, output=9)
    slips = held.force("rope").states["slip 1"]
    assert slips[-1] == slips[-2] and np.linalg.norm(held.velocity("one")[-1]) < 1e-6


def test_a_rope_slips_over_a_drum_that_turns():
    """More than e^(mu phi) between its weights: the drum is turned by the difference of their tensions."""
    m1, m2, J, R, mu = 30.0, 2.0, 0.4, 0.2, 0.15
    k = np.exp(mu * pi)
    a = (m1 - k * m2) * G / (m1 + k * m2)
    run = simulate(over_a_drum(m1, m2, R, mu, J), 0.6, rtol=1e-10, output=11)
    assert -up(run, "one") == pytest.approx(a, rel=1e-8)
    low = m2 * (G + a)
    assert np.linalg.norm(run.alpha("drum")[-1]) == pytest.approx((k - 1.0) * low * R / J, rel=1e-8)


@pytest.mark.parametrize(("sense", "torque"), [(1, lambda k: k - 1.0), (-1, lambda k: 1.0 - 1.0 / k)])
@pytest.mark.parametrize(("pulled", "R", "mu", "turns"), [(100.0, 0.2, 0.3, 1), (37.0, 0.13, 0.22, 0)])
def test_a_band_brake_grabs_in_one_sense(sense, torque, pulled, R, mu, turns):
    """A band about a driven drum, fixed on the left, pulled down on the right: T1 (e^(mu phi) - 1) R and less."""
    drum = Body("drum", 3.0, (0.1, 0.1, 0.1), omega=-5.0 * sense * OVER)
    axle = Revolute(GROUND, drum, at=(0, 0, 0), axis=-OVER)
    lever, guide = weight("lever", 2.0, R, -1.3)
    band = Rope(
        ((GROUND, place(-R, -0.8)), (lever, lever.position)), Pulley(axle, radius=R, sense=-1, turns=turns), mu=mu,
        stiffness=3e4, damping=300.0, pretension=90.0,
    )  # fmt: skip
    turning = SpeedDriver(axle, 5.0 * sense, name="motor")
    forces = [band, Force(lever, -(pulled - 2.0 * G) * UP)]
    run = simulate(System([drum, lever], [axle, guide, turning], forces, gravity=GRAVITY), 6.0, rtol=1e-10, output=4)
    k = np.exp(mu * (1 + 2 * turns) * pi)
    # it goes over the top from left to right: turning about -OVER is clockwise and carries the band to the lever
    grabbing = sense < 0
    expected = (k - 1.0 if grabbing else 1.0 - 1.0 / k) * pulled * R
    assert abs(run.effort("motor")[-1]) == pytest.approx(expected, rel=1e-8)


def test_a_rough_journal_slows_a_pulley():
    """Atwood with a heavy pulley, then with a journal of mu r |F| at its axle."""
    m1, m2, J, R, mass, mu, rp = 5.0, 3.0, 0.02, 0.1, 4.0, 0.2, 0.01
    smooth = over_a_drum(m1, m2, R, None, J, mass=mass, speed=0.3)
    rough = System(
        smooth.bodies, smooth.joints, [*smooth.forces, DryFriction(smooth.joints[2], mu=mu, pin_radius=rp)],
        gravity=GRAVITY,
    )  # fmt: skip
    run = simulate(rough, 0.9, rtol=1e-10, output=4)
    # (T1 - T2) R - mu rp (T1 + T2 + m g) = J a / R with T1 = m1 (g - a), T2 = m2 (g + a)
    lost = mu * rp / R
    a = G * (m1 - m2 - lost * (m1 + m2 + mass)) / (m1 + m2 + J / R**2 - lost * (m1 - m2))
    assert -up(run, "one") == pytest.approx(a, rel=1e-7)


def tackle(falls, M, m, gap=0.13, mu=0.0, hauled=None, **rope):
    """A tackle with an even number of falls: a rope from GROUND, sheave by sheave, to a weight m at its end.

    ``hauled``: the weight is driven down at that speed.
    """
    load, guide = weight("load", M, 0.0, -2.0, None)
    free, rail = weight("free", m, (falls + 0.5) * gap, -1.5, None)
    wheels, x = [], 0.0
    for k in range(falls):
        x += 0.5 * gap
        below = k % 2 == 0
        centre = place(x, -1.9 if below else 0.0)
        wheels.append(Pulley(load if below else GROUND, radius=0.5 * gap, sense=1 if below else -1,
                             centre=centre, axis=-OVER))  # fmt: skip
        x += 0.5 * gap
    free_at = place(falls * gap, -1.5)
    ends = ((GROUND, place(0.0, 0.3)), (free, free_at))
    given = {"stiffness": 2e5, "damping": 2e3, "pretension": 50.0} | rope
    drive = [] if hauled is None else [SpeedDriver(rail, -hauled, name="winch")]
    forces = [Rope(ends, wheels, mu=mu, name="rope", **given)]
    return System([load, free], [guide, rail, *drive], forces, gravity=GRAVITY)


@pytest.mark.parametrize(("n", "M", "m"), [(4, 30.0, 10.0), (2, 17.0, 6.0), (6, 41.0, 8.5)])
def test_a_block_and_tackle(n, M, m):
    run = simulate(tackle(n, M, m), 1.0, rtol=1e-11, output=4)
    a = G * (n * m - M) / (M + n**2 * m)
    assert up(run, "load") == pytest.approx(a, rel=1e-8)
    assert run.force("rope").tension[-1] == pytest.approx([m * (G - n * a)], rel=1e-8)
    assert run.force("rope").wrap[-1] == pytest.approx([pi] * n, abs=1e-9)
    assert run.certificate.passed


@pytest.mark.parametrize(("n", "M", "eta"), [(4, 30.0, 0.95), (2, 11.0, 0.88), (6, 25.0, 0.97)])
def test_rough_sheaves_of_a_tackle_take_their_share(n, M, eta):
    """Raised evenly: every fall has eta times the tension of the one nearer to the hand."""
    system = tackle(n, M, 1.0, mu=-log(eta) / pi, hauled=0.1, pretension=M * G / n)
    run = simulate(system, 3.0, rtol=1e-10, output=4)
    tensions = run.force("rope").tension[-1]
    assert tensions[-1] == pytest.approx(M * G * (1.0 - eta) / (eta * (1.0 - eta**n)), rel=1e-8)
    assert tensions[:-1] == pytest.approx(eta * tensions[1:], rel=1e-9)


def hoist(T=0.0, J=0.4, R=0.1, m=80.0, k=1e5, d=2e3, held=False, sense=1, **rope):
    """A drum that a torque T turns, and a load that hangs from it; in the sense it pays out."""
    load, guide = weight("load", m, R, -3.0)
    drum = Body("drum", 5.0, (J, J, J), omega=(0, 0, 0))
    axle = Revolute(GROUND, drum, at=(0, 0, 0), axis=sense * OVER, name="axle")
    # it leaves the drum on the right and runs down: clockwise about OVER, which points away from the viewer
    winch = Winch(axle, radius=R, sense=sense)
    joints = [guide, axle, *([AngleDriver(axle, 0.0)] if held else [])]
    given = {"pretension": m * G} | rope
    forces = [Rope((winch, (load, load.position)), stiffness=k, damping=d, name="rope", **given)]
    return System([load, drum], joints, [*forces, Torque(drum, tuple(-T * OVER))], gravity=GRAVITY)


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(("T", "J", "R", "m"), [(120.0, 0.4, 0.1, 80.0), (30.0, 0.15, 0.24, 21.0)])
def test_a_winch_hoists(T, J, R, m, sense):
    run = simulate(hoist(T, J, R, m, sense=sense), 0.9, rtol=1e-11, output=4)
    a = (T / R - m * G) / (m + J / R**2)
    assert up(run, "load") == pytest.approx(a, rel=1e-8)
    assert run.force("rope").tension[-1] == pytest.approx([m * (G + a)], rel=1e-8)


@pytest.mark.parametrize(("EA", "length", "m"), [(2e6, 20.0, 80.0), (7e5, 3.0, 55.0)])
def test_a_load_swings_on_the_rope_of_a_winch(EA, length, m):
    """Static stretch m g L / EA, and sqrt(EA / (L m)) with the drum held."""
    slack = hoist(m=m, k=EA / length, d=200.0, held=True, pretension=0.0)
    rest = simulate(slack, 60.0, rtol=1e-9, output=4)
    assert -rest.slide("guide of load")[-1] == pytest.approx(m * G * length / EA, rel=1e-7)
    modes = linearize(system := hoist(m=m, k=EA / length, d=0.0, held=True), system.state()).modes
    assert max(mode.frequency for mode in modes) == pytest.approx(np.sqrt(EA / (length * m)) / (2 * pi), rel=1e-8)


def path_by_hand(start, end, centre, radius, sense):
    """Length over one circle from its tangent points, by angles at the centre; plane vectors, sense 1: positive."""
    u, v = np.subtract(start, centre), np.subtract(end, centre)
    a, b = np.linalg.norm(u), np.linalg.norm(v)
    between = sense * (np.arctan2(v[1], v[0]) - np.arctan2(u[1], u[0])) % (2 * pi)
    arc = (between - np.arccos(radius / a) - np.arccos(radius / b)) % (2 * pi)
    return np.sqrt(a * a - radius**2) + np.sqrt(b * b - radius**2) + radius * arc


@pytest.mark.parametrize("seed", range(5))
def test_the_path_is_as_long_as_tangents_and_arc(seed):
    rng = np.random.default_rng(seed)
    start, end = rng.normal(size=(2, 2)) * 3 + [[-4, 0], [4, 0]]
    centre, radius, sense = rng.normal(size=2), rng.uniform(0.1, 0.6), int(rng.choice([1, -1]))
    wheel = Pulley(GROUND, radius=radius, sense=sense, centre=place(*centre), axis=-OVER)
    rope = Rope(((GROUND, place(*start)), (GROUND, place(*end))), wheel, stiffness=1.0)
    # along -OVER, SIDE turns to UP
    assert rope.path.length == pytest.approx(path_by_hand(start, end, centre, radius, sense), rel=1e-13)


def wound(turns=2, R=0.1, reach=1.0, **given):
    """A puck on a rope about a post, in the plane: it flies round and unwinds, or winds."""
    puck = Body("puck", 0.5, (0.01, 0.01, 0.01), position=place(reach, R), velocity=2.0 * UP)
    post = Pulley(GROUND, radius=R, sense=-1, centre=(0, 0, 0), axis=-OVER, turns=turns)
    # it is fixed on the left above the post and leaves it over the top
    ends = ((GROUND, place(-1.0, R - 0.02)), (puck, puck.position))
    rope = Rope(ends, post, stiffness=5e4, damping=5.0, name="rope", **given)
    return System([puck], [], [rope], gravity=(0, 0, 0))


def test_a_rope_unwinds_until_it_comes_off():
    """Along the involute: v is kept, and the free length grows by R with the angle: l^2 - l0^2 = 2 R v t."""
    run = simulate(wound(), 3.0, rtol=1e-10, output=301)
    free = np.sqrt((run.position("puck") ** 2).sum(axis=1) - 0.01)
    stretch = run.force("rope").tension[:, 0].max() / 5e4
    assert free == pytest.approx(np.sqrt(1.0 + 2 * 0.1 * 2.0 * run.t), abs=20 * stretch)
    wraps = run.force("rope").wrap[:, 0]
    assert wraps == pytest.approx(wraps[0] - (free - 1.0) / 0.1, abs=20 * stretch / 0.1)
    assert wraps[0] > 4 * pi and wraps[-1] < wraps[0] - 4.0
    assert run.certificate.passed
    with pytest.raises(
        ValueError, match="the rope comes off a pulley, where its wrap falls below 0 at t = .*: force 'rope'"
    ):
        simulate(wound(turns=0), 30.0, rtol=1e-8)


def test_a_slack_rope_does_not_pull():
    """A stone thrown up falls back freely, is caught, and loses what the damper takes."""
    stone, guide = weight("stone", 2.0, 0.0, -1.0)
    thrown = Body("stone", 2.0, stone.inertia, com=stone.com, position=stone.position, velocity=3.0 * UP)
    guide = Prismatic(GROUND, thrown, at=thrown.position, axis=UP, name="guide")
    rope = Rope(
        ((GROUND, place(0, 1)), (thrown, thrown.position)), stiffness=5e3, damping=20.0, length=2.3, name="rope"
    )
    run = simulate(System([thrown], [guide], [rope], gravity=GRAVITY), 4.0, rtol=1e-10, output=401)
    free = run.t < 2 * 3.0 / G  # back where it began, above the end of the rope
    assert run.slide("guide")[free] == pytest.approx((3.0 * run.t - 0.5 * G * run.t**2)[free], abs=1e-9)
    tension = run.force("rope").tension[:, 0]
    assert (tension[free] == 0.0).all() and (tension >= 0.0).all() and tension.max() > 100.0
    balance = run.energy().total - run.energy().work
    assert np.abs(balance - balance[0]).max() < 1e-8 and run.certificate.passed
    fixed = simulate(System([thrown], [guide], [rope], gravity=GRAVITY), 4.0, method=RK4(dt=1e-3), output=401)
    assert fixed.slide("guide") == pytest.approx(run.slide("guide"), abs=1e-6)  # steps end where it gets taut


def test_an_eye_leads_from_plane_to_plane():
    """Over a pulley, through an eye, and along another axis: one tension, equal to the weight at rest."""
    sled = Body("sled", 3.0, (0.1, 0.1, 0.1), position=3.0 * OVER, velocity=(0, 0, 0))
    rail = Prismatic(GROUND, sled, at=3.0 * OVER, axis=OVER, name="rail")
    load, guide = weight("load", 2.0, 0.6, -1.0)
    eye, wheel = (GROUND, place(0.0, 0.1)), Pulley(GROUND, radius=0.1, sense=-1, centre=place(0.5, 0.0), axis=-OVER)
    rope = Rope(((sled, 3.0 * OVER + 0.1 * UP), (load, load.position)), (eye, wheel), stiffness=1e4, damping=100.0,
                pretension=10.0)  # fmt: skip
    run = simulate(System([sled, load], [rail, guide], [rope], gravity=GRAVITY), 1.0, rtol=1e-10, output=3)
    assert up(run, "load") == pytest.approx(-2.0 * G / 5.0, rel=1e-8)


def test_a_stepper_and_a_run_agree_and_states_go_on():
    system = over_a_drum(10.0, 3.0, 0.15, 0.25)
    whole = simulate(system, 0.6, rtol=1e-10, output=3)
    first = simulate(system, 0.3, rtol=1e-10, output=3)
    rest = simulate(system, 0.6, rtol=1e-10, output=3, state=first.final)
    assert rest.final.q == pytest.approx(whole.final.q, abs=1e-8) and rest.final.z == pytest.approx(
        whole.final.z, abs=1e-8
    )
    stepper = Stepper(system, measures=[measures.slide(system.joints[0])])
    for t in np.linspace(0.02, 0.6, 30):
        stepper.advance(t)
    assert stepper.measured[0] == pytest.approx(whole.slide("guide of one")[-1], abs=1e-6)


def test_a_rope_out_of_its_plane_is_refused_by_the_certificate():
    ball = Body("ball", 1.0, (0.1, 0.1, 0.1), position=place(0.1, -1.0), velocity=1.5 * OVER)
    wheel = Pulley(GROUND, radius=0.1, sense=-1, centre=(0, 0, 0), axis=-OVER)
    rope = Rope(
        ((GROUND, place(-0.1, -1.0)), (ball, ball.position)), wheel, stiffness=1e4, pretension=9.81, name="rope"
    )
    run = simulate(System([ball], [], [rope], gravity=GRAVITY), 1.0, output=101)
    assert not run.certificate["planes of ropes"].passed and "'rope' leaves the plane" in str(run.certificate.failures)
    balance = run.energy().total
    assert np.abs(balance - balance[0]).max() < 1e-6  # its loads still belong to its energy
    assert simulate(System([ball], [], [rope], gravity=GRAVITY), 0.02).certificate.passed


A, B = (GROUND, place(-0.1, -1.0)), (GROUND, place(0.1, -1.0))
WHEEL = Pulley(GROUND, radius=0.1, sense=-1, centre=(0, 0, 0), axis=-OVER)


def wheel(**given):
    numbers = {"radius": 0.1, "sense": -1, "centre": (0, 0, 0), "axis": -OVER} | given
    return Pulley(GROUND, **numbers)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Rope((A, B), wheel(radius=2.0), stiffness=1.0), "the point lies inside the pulley"),
        (
            lambda: Rope((A, B), (WHEEL, wheel(radius=0.3, centre=place(0.1, 0.1))), stiffness=1.0),
            "one pulley lies inside the other",
        ),
        (lambda: Rope((A, B), wheel(centre=0.2 * OVER), stiffness=1.0), "leaves the plane of the pulley"),
        (
            lambda: Rope((A, B), (WHEEL, wheel(centre=place(1, 0), axis=SIDE)), stiffness=1.0),
            "pulleys no. 1 and 2 of its path have axes that are not parallel",
        ),
        (
            lambda: Rope(((GROUND, place(-1, 0.1)), (GROUND, place(1, 0.1))), WHEEL, stiffness=1.0),
            "passes the pulley on 'ground' without lying on it",
        ),
        (lambda: Rope((A, B), WHEEL, stiffness=1.0, length=2.0), "length = 2 m is shorter than its path of 2.31416 m"),
        (lambda: Rope((A, B), WHEEL, stiffness=1.0, length=3.0, pretension=2.0), "both length and pretension"),
        (lambda: Rope((A, B), WHEEL, stiffness=1.0, mu=0.2), "mu > 0 with damping = 0; give damping > 0"),
        (lambda: Rope((A, B), WHEEL, stiffness=1.0, mu=(0.2, 0.1)), "2 values for 1 pulleys in mu; give one"),
        (lambda: Rope((A, B), WHEEL, stiffness=(1.0, 2.0)), "2 values for 1 sections in stiffness"),
        (lambda: Rope((A, B), WHEEL, stiffness=0.0), "stiffness: 0.0 is not positive"),
        (lambda: Rope((A, A), stiffness=1.0), "two points of it that follow each other coincide"),
        (lambda: Rope((A, WHEEL), stiffness=1.0), r"give two ends, each \(body, point\) or a Winch"),
        (lambda: Rope((A, (B, 1)), stiffness=1.0), r"points no. 2 = .*; give \(body, point\)"),
        (lambda: Rope((A, B), Winch(GROUND, radius=1, sense=1, centre=(0, 0, 0), axis=UP), stiffness=1.0), "at an end"),
        (lambda: Winch(GROUND, radius=1, sense=1, centre=(0, 0, 0), axis=UP, turns=2), "turns = 2; leave it out"),
        (lambda: wheel(sense=0), "Pulley: sense = 0; give 1 or -1"),
        (lambda: wheel(turns=-1), "Pulley: turns = -1; give a whole number >= 0"),
        (lambda: Pulley(GROUND, radius=0.1, sense=1, axis=UP), "not a hinge, without centre; give centre="),
        (lambda: Pulley("axle", radius=0.1, sense=1), "on = 'axle'; give a Body, GROUND, or the hinge"),
    ],
)  # fmt: skip
def test_what_is_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.parametrize(("mu", "F", "v"), [(0.21, 60.0, 0.035), (0.4, 35.0, -0.013)])
def test_a_run_stops_at_the_tension_of_either_side_of_a_rough_drum(mu, F, v):
    """One end is drawn out or in evenly: first its side alone is stretched, then T_1 = e^(mu phi) T_2."""
    k, c, R = 3e4, 500.0, 0.17
    low, guide = weight("one", 5.0, -R, -2.0, None)
    wheel = Pulley(GROUND, radius=R, sense=1, centre=(0, 0, 0), axis=OVER)
    ends = ((low, low.position), (GROUND, place(R, -2.3)))
    rope = Rope(ends, wheel, mu=mu, stiffness=k, damping=c, pretension=F, name="rope")
    system = System([low], [guide, SpeedDriver(guide, -v)], [rope], gravity=GRAVITY)
    grip = np.exp(np.sign(v) * mu * pi)
    begins = ((grip - 1.0) * F - c * v) / (k * v)  # s, of the slip
    one, two = measures.tension(rope), measures.tension(rope, 1)
    early, late = F + c * v + 0.6 * k * v * begins, (2.0 * F + k * v * 1.7 * begins + c * v) / (1.0 + grip)
    for seen, value, t in ((one, early, 0.6 * begins), (one, grip * late, 1.7 * begins), (two, late, 1.7 * begins)):
        run = simulate(system, 3.0 * begins, rtol=1e-10, stop_when=seen > value if v > 0.0 else seen < value)
        assert run.t[-1] == pytest.approx(t, rel=1e-8) and run.certificate.passed  # slips by steps of rtol
        both = run.measure([one, 2.0 * two - 1.0])
        assert both == pytest.approx(run.force(rope).tension * [1.0, 2.0] - [0.0, 1.0], rel=1e-12, abs=1e-9)


def test_a_spring_and_a_gain_on_its_tension_are_a_stiffer_spring():
    """A feedback that pulls g times the tension makes a rope (1 + g) times as stiff: omega^2 = (1 + g) k / m."""
    m, k, g = 3.0, 800.0, 0.7
    load, guide = weight("load", m, 0.2, -1.0)
    rope = Rope(((GROUND, place(0.2, 1.0)), (load, load.position)), stiffness=k, pretension=m * G / (1.0 + g))
    more = StateFeedback(measures=measures.tension(rope), gains=(-g,), on=guide)
    system = System([load], [guide], [rope, more], gravity=GRAVITY)
    assert abs(linearize(system, system.state()).eigenvalues.imag).max() == pytest.approx(
        np.sqrt((1.0 + g) * k / m), rel=1e-8
    )


def test_what_has_no_tension_is_refused():
    system = over_a_drum(4.0, 3.0, 0.2, 0.1)
    rope, guide = system.forces[0], system.joints[0]
    with pytest.raises(ValueError, match="rope has no section 2; give 0 to 1"):
        measures.tension(rope, 2)
    with pytest.raises(ValueError, match="has no tension; give a Rope or a Belt"):
        measures.tension(EndStop(guide, upper=1.0, stiffness=1e4))
