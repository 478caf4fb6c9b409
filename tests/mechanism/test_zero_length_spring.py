"""A spring of no length through its own anchor: closed forms of motion, small motions and laws, and other programs."""

from dataclasses import replace

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AssemblyError,
    Body,
    IntegrationError,
    RadauIIA,
    SpringDamper,
    State,
    System,
    accelerations,
    linearize,
    load,
    measures,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix, skew

MASS, STIFFNESS, DAMPING = 1.7, 37.0, 3.0
SPEED = np.array([0.6, -1.1, 0.4])  # m/s of the centre of mass
TURN = np.array([2.0, -3.0, 1.0])  # rad/s
COM = np.array([0.11, -0.07, 0.23])
INERTIA = [[0.3, 0.02, -0.01], [0.02, 0.25, 0.03], [-0.01, 0.03, 0.2]]


def bob(far=0.0, moving=True):
    """A body of no symmetry that turns, its reference point off its centre of mass."""
    turned = rotation((0.3, 1.0, -0.4), 1.1)
    pose = {"com": COM, "position": np.array([0.4, -1.3, 0.8]) + far, "orientation": turned}
    velocity = SPEED - np.cross(TURN, matrix(turned) @ COM)
    return Body("bob", MASS, INERTIA, **pose, **({"velocity": velocity, "omega": TURN} if moving else {}))


def anchored(body, at, damping=0.0, **more):
    """A spring from the ground to a point of a body, where that point is."""
    return SpringDamper(GROUND, body, at_a=at, at_b=at, stiffness=STIFFNESS, damping=damping, length=0, **more)


@pytest.mark.parametrize(("damping", "far"), [(0.0, 0.0), (DAMPING, 0.0), (DAMPING, 1e3)])
def test_it_swings_straight_through_its_anchor(damping, far):
    """m x'' + c x' + k x = 0 along the line of the first velocity, while the body turns about its centre of mass."""
    body = bob(far)
    run = simulate(System([body], [], [anchored(body, body.centre, damping)], gravity=(0, 0, 0)), 5.0)
    decay = damping / (2 * MASS)
    rate = np.sqrt(STIFFNESS / MASS - decay**2)
    known = body.centre + np.outer(np.exp(-decay * run.t) * np.sin(rate * run.t) / rate, SPEED)
    # a hundred times the tolerance of the run, of a swing of 0.3 m; rounding far away, 1e-13 m times 1e4 steps, is less
    assert np.abs(run.com(body) - known).max() < 3e-7
    assert run.certificate.passed


def test_with_weight_it_goes_round_an_ellipse():
    body = bob()
    run = simulate(System([body], [], [anchored(body, body.centre)]), 9.0)
    rate, sag = np.sqrt(STIFFNESS / MASS), np.array([0.0, 0.0, -9.81]) * MASS / STIFFNESS
    known = np.outer(np.sin(rate * run.t) / rate, SPEED) + np.outer(1 - np.cos(rate * run.t), sag)
    assert np.abs(run.com(body) - body.centre - known).max() < 1e-8  # a hundred times the tolerance, of 0.5 m
    assert run.certificate.passed


def test_energy_power_length_and_rate_where_the_ends_meet():
    """From -c v on: the power is -c v^2, and the length grows by the speed."""
    body = bob()
    spring = anchored(body, body.centre, DAMPING)
    run = simulate(System([body], [], [spring], gravity=(0, 0, 0)), 0.5, output=3)
    load = run.force(spring)
    assert load.force[0] == pytest.approx(-DAMPING * SPEED, abs=1e-12)
    assert load.power[0] == pytest.approx(-DAMPING * SPEED @ SPEED, rel=1e-12)
    assert load.stored[0] == 0.0 and load.length[0] == pytest.approx(0.0, abs=1e-15)
    assert load.rate[0] == pytest.approx(np.linalg.norm(SPEED), rel=1e-12)


def test_rounding_of_the_anchor_is_no_direction():
    """Seen from a far reference point the ends part by 1e-16 m; the damper still pulls against the whole velocity."""
    for far in ((5.0, -3.0, 2.0), (0.3, 0.1, -0.7), (1e3, 2e3, -1e3)):
        velocity = SPEED - np.cross(TURN, -np.array(far))
        body = Body("bob", MASS, INERTIA, com=(0.1, 0, 0), position=far, velocity=velocity, omega=TURN)
        body = replace(body, orientation=rotation((0.3, 1.0, -0.4), 1.1))
        spring = anchored(body, (0.0, 0.0, 0.0), DAMPING)
        force = accelerations(System([body], [], [spring], gravity=(0, 0, 0))).force(spring).force[0]
        assert force == pytest.approx(-DAMPING * SPEED, rel=1e-10)  # 1e-13 of the speeds of 1e4 m/s that cancel


@pytest.mark.parametrize("damping", [0.0, DAMPING])
def test_small_motions_about_the_anchor_are_stiff_in_all_directions(damping):
    """M x'' + c G'G x' + k G'G x = 0 of all six degrees of freedom, G = [1, -[s]x] of the point at s from O."""
    body = bob(moving=False)
    at = body.position + np.array([0.3, 0.5, -0.2])
    system = System([body], [], [anchored(body, at, damping)], gravity=(0, 0, 0))
    found = linearize(system).eigenvalues
    R = matrix(body.orientation)
    s, G = skew(R @ COM), np.hstack([np.eye(3), -skew(at - body.position)])
    M = np.block([[MASS * np.eye(3), -MASS * s], [MASS * s, R @ INERTIA @ R.T + MASS * s @ s.T]])
    K, C = np.linalg.solve(M, STIFFNESS * G.T @ G), np.linalg.solve(M, damping * G.T @ G)
    known = np.linalg.eigvals(np.block([[np.zeros((6, 6)), np.eye(6)], [-K, -C]]))
    known = known[np.abs(known) > 1e-3]  # six of them are 0, of the rotations about the point: Jordan blocks
    assert np.count_nonzero(found == 0.0) == 6 and known.size == 6

    def by_rate(values):
        return sorted(values, key=lambda x: (round(abs(x.imag), 6), x.imag))

    assert by_rate(found[found != 0.0]) == pytest.approx(by_rate(known), rel=1e-10)


def test_its_length_has_no_small_motion_there():
    body = bob(moving=False)
    spring = anchored(body, body.centre)
    system = System([body], [], [spring], gravity=(0, 0, 0))
    with pytest.raises(ValueError, match="is zero, where a distance has no derivative; give a position"):
        linearize(system, outputs=[measures.length(spring)])


def test_between_two_bodies_it_takes_no_momentum():
    """The relative motion has the reduced mass; the damper pulls along the line, so angular momentum stays too."""
    one = bob()
    at = one.centre
    two = Body("two", 0.9, (0.1, 0.2, 0.15), position=at, velocity=(0, 0, 0), omega=(1, 0, 2))
    spring = SpringDamper(one, two, at_a=at, at_b=at, stiffness=STIFFNESS, damping=DAMPING, length=0)
    run = simulate(System([one, two], [], [spring], gravity=(0, 0, 0)), 4.0, rtol=1e-10)
    mass = 1.0 / (1.0 / MASS + 1.0 / 0.9)
    decay = DAMPING / (2 * mass)
    rate = np.sqrt(STIFFNESS / mass - decay**2)
    apart = run.com(one) - run.com(two)
    known = np.outer(np.exp(-decay * run.t) * np.sin(rate * run.t) / rate, SPEED)
    assert np.abs(apart - known).max() < 1e-8  # a hundred times the tolerance
    assert run.certificate.passed


def test_it_holds_a_body_at_its_anchor_at_rest_and_stiffly():
    """No weight, no motion: nothing happens, by an implicit method too, whose Jacobian is taken there."""
    body = bob(moving=False)
    system = System([body], [], [anchored(body, body.centre, DAMPING)], gravity=(0, 0, 0))
    for method in (None, RadauIIA()):
        assert np.array_equal(simulate(system, 1.0, method=method).com(body)[-1], body.centre)


def test_a_file_and_a_page_have_it(tmp_path):
    body = bob()
    system = System([body], [], [anchored(body, body.centre, DAMPING, name="anchor")], gravity=(0, 0, 0))
    again = System.from_file(system.to_file(tmp_path / "model.toml"))
    assert again.part("anchor", "forces").length == 0.0
    assert np.array_equal(again.part("anchor", "forces").at_a, again.part("anchor", "forces").at_b)
    run = simulate(system, 0.5, output=9)
    assert np.array_equal(load(run.save(tmp_path / "run")).force("anchor").rate, run.force("anchor").rate)
    system.show().save(tmp_path / "shown")
    for name in ("page", "other.html"):
        assert run.animate().save(tmp_path / name).stat().st_size > 10_000


def test_a_length_that_is_not_zero_needs_a_direction():
    body = bob()
    for length in (None, 0.2):
        with pytest.raises(ValueError, match=rf"'spring'.*: at_a and at_b coincide.* of length={length} has no"):
            SpringDamper(GROUND, body, at_a=body.centre, at_b=body.centre, stiffness=1.0, length=length, name="spring")


def test_a_spring_with_a_length_that_is_pressed_to_nothing_is_named():
    """Its force has no direction there: nobody computes with it."""
    body = bob(moving=False)
    ends = {"at_a": body.centre - [0.5, 0, 0], "at_b": body.centre}
    spring = SpringDamper(GROUND, body, **ends, stiffness=STIFFNESS, length=0.4, name="strut")
    system = System([body], [], [spring], gravity=(0, 0, 0))
    start = system.state()
    q = start.q.copy()
    q[0] -= 0.5
    with pytest.raises((IntegrationError, AssemblyError, ValueError), match="strut"):
        simulate(system, 0.1, state=State(0.0, q, start.v))


def test_the_plain_law_has_the_same_accelerations():
    """Where the ends meet and where they do not."""
    pytest.importorskip("validation")
    from validation.twins.laws.loads import spring_law
    from validation.twins.laws.moving import Moving

    body = bob()
    spring = anchored(body, body.centre, DAMPING)
    system = System([body], [], [spring], gravity=(0, 0, 0))
    start = system.state()
    for shift in (0.0, 0.3):
        q = start.q.copy()
        q[:3] += shift
        alone = Moving(body, q[:3], matrix(q[3:]) @ matrix(body.orientation).T, start.v[:3], start.v[3:])
        ground = Moving(GROUND, np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))
        pushed = spring_law(spring, "").push(0.0, ground, alone, np.zeros(0), 0.0)
        run = accelerations(system, State(0.0, q, start.v))
        assert run.force(spring).force[0] == pytest.approx(pushed.force, abs=1e-12)
