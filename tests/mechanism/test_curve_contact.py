"""A point, a roller or a face on a curve: identities, third law, beads on wires, ends, what is refused."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.models import (
    Evaluation,
    consistent_state,
    derivative,
    direction,
    moved_reference,
    random_body,
    random_orientation,
)
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from mbsd3d import (
    GROUND,
    Body,
    CurveContact,
    IntegrationError,
    JointFriction,
    Polynomial,
    SlideDriver,
    SpeedDriver,
    System,
    accelerations,
    linearize,
    measures,
    rotation,
    simulate,
)
from mbsd3d.equations.at_state import coordinate_row
from mbsd3d.kernels.coordinates import coordinate
from mbsd3d.rotations import matrix
from mbsd3d.view.scene.artist import draw_system
from validation.twins.definitions import equations as reference_point

TURN = 2 * np.pi * np.arange(60) / 60
KINDS = ("point", "pin", "roller", "face")
STEP = 1e-30


def contact(kind, rng, a, b):
    """A contact in general position, beside a wide curve; it need not close."""
    frame, at = matrix(random_orientation(rng)), b.position + 0.3 * direction(rng)
    r = 5 + 0.3 * np.cos(2 * TURN)
    flat = kind in ("roller", "face")
    points = np.column_stack([r * np.cos(TURN), r * np.sin(TURN), (not flat) * 0.8 * np.sin(2 * TURN + 0.3)])
    points = points @ frame.T
    given = {
        "point": {},
        "pin": {"pin": points + 0.2 * direction(rng)},
        "roller": {"pin": frame[:, 2], "radius": 0.4},
        "face": {"face": 0.8 * frame[:, 0] + 0.6 * frame[:, 1]},
    }[kind]
    return CurveContact(a, b, points - points[7] + at + 0.3 * direction(rng), at=at, **given)


def pair(kind, seed, ground=None):
    """Two general bodies, or one and the ground, in contact."""
    rng = np.random.default_rng(seed)
    one, two = random_body(rng, "one"), random_body(rng, "two")
    a, b = (GROUND if ground == "a" else one), (GROUND if ground == "b" else two)
    return System([one, two], [contact(kind, rng, a, b)], gravity=(0.3, -0.7, -9.6))


@pytest.mark.parametrize("ground", [None, "a", "b"])
@pytest.mark.parametrize("kind", KINDS)
def test_rows_and_length_keep_their_identities_off_the_manifold(kind, ground):
    """c_dot = J v, d(J v)/dt = J v_dot - gamma, and the same of s with its gradient and bias, by complex steps."""
    system, rng = pair(kind, 11, ground), np.random.default_rng(5)
    real, exact = Evaluation(system), Evaluation(system, complex)
    q, v = real.general(rng)
    v_dot, q_dot, i = rng.normal(size=v.size), real.rates(v, q), 0
    c, J, _, gamma = exact.rows(q + 1j * STEP * q_dot, v + 1j * STEP * v_dot, 0.0)
    s, bias, *blocks = coordinate(exact.model, exact.data, i, 0.0)
    rows = np.zeros((3, 6), complex)
    ends = exact.model.coordinate["body"][i]
    rows[ends[0]], rows[ends[1]] = np.concatenate(blocks[:2]), np.concatenate(blocks[2:])
    gradient = rows[:2].ravel()
    assert np.abs(c.real).min() > 1e-3 and np.abs(gamma.real).min() > 1e-3 and abs(bias.real) > 1e-3
    J_real, size = J.real, 1 + np.abs(gamma.real).max() + abs(bias.real)
    assert c.imag / STEP == pytest.approx(J_real @ v, abs=1e-12 * size)
    assert (J @ (v + 1j * STEP * v_dot)).imag / STEP == pytest.approx(J_real @ v_dot - gamma.real, abs=1e-12 * size)
    assert s.imag / STEP == pytest.approx(gradient.real @ v, abs=1e-12 * size)
    rate = (gradient @ (v + 1j * STEP * v_dot)).imag / STEP
    assert rate == pytest.approx(gradient.real @ v_dot + bias.real, abs=1e-12 * size)


def test_the_length_is_that_of_differences_too():
    system, rng = pair("point", 12), np.random.default_rng(6)
    evaluation = Evaluation(system)
    q, v = evaluation.general(rng)
    q_dot = evaluation.rates(v, q)

    def length(h):
        evaluation.rows(evaluation.normalised(q + h * q_dot), v, 0.0)
        return np.array(coordinate(evaluation.model, evaluation.data, 0, 0.0)[0])

    length(0.0)
    gradient = coordinate_row(evaluation.compiled, evaluation.data, 0, 0.0)[1]
    assert derivative(length) == pytest.approx(gradient @ v, abs=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_rows_are_those_of_the_definition(kind):
    """c along a path of poses, s by scipy's root finder on the spline: no kernel is shared."""
    system, rng = pair(kind, 13), np.random.default_rng(7)
    joint, (one, two) = system.joints[0], system.bodies
    evaluation, line = Evaluation(system), joint.line
    q, v = evaluation.general(rng, away=0.2)
    q_dot, weight = evaluation.rates(v, q), float(kind != "face")

    def defined(h):
        a, b = evaluation.normalised(q + h * q_dot).reshape(2, 7)
        back, move = matrix(one.orientation) @ matrix(a[3:]).T, matrix(b[3:]) @ matrix(two.orientation).T
        p = one.position + back @ (b[:3] + move @ (joint.at - two.position) - a[:3])  # as the curve sees it
        e = p if weight else back @ move @ joint.face
        good = line.x(line.lengths) @ e if kind == "face" else -np.linalg.norm(line.x(line.lengths) - p, axis=1)
        near = line.lengths[int(np.argmax(good))]
        s = brentq(lambda s: line.x(s, 1) @ (e - weight * line.x(s)), near - 0.6, near + 0.6, xtol=1e-14, rtol=1e-14)
        normals = [e] if kind == "face" else [n(s) for n in joint.across]
        return np.array([n @ (p - line.x(s)) - (joint.radius or 0.0) for n in normals])

    c, J, _, _ = evaluation.rows(q, v, 0.0)
    assert c == pytest.approx(defined(0.0), abs=1e-12)
    assert J @ v == pytest.approx(derivative(defined), abs=1e-8)


def closed_pair(kind, seed, **fields):
    """Two general bodies in contact on a circle, whose spline has exact normals at its points."""
    rng = np.random.default_rng(seed)
    one, two = random_body(rng, "one", **fields), random_body(rng, "two", **fields)
    frame, at, centre = matrix(random_orientation(rng)), two.position + 0.3 * direction(rng), rng.normal(size=3)
    circle = 3.0 * np.column_stack([np.cos(TURN), np.sin(TURN), 0 * TURN]) @ frame.T
    e, z = circle[7] / 3.0, frame[:, 2]
    off, given = {
        "point": (0 * e, {}),
        "pin": (0.2 * (0.6 * e + 0.8 * z), {"pin": 0.6 * e + 0.8 * z}),
        "roller": (0.4 * e + 0.1 * z, {"pin": z, "radius": 0.4}),
        "face": (0.2 * z + 0.3 * np.cross(z, e), {"face": e}),
    }[kind]
    return one, two, CurveContact(one, two, circle - circle[7] - off + at, at=at, **given, name="contact"), centre


@pytest.mark.parametrize("kind", KINDS)
def test_free_bodies_in_contact_keep_energy_and_momentum(kind):
    """Third law and power: what a gives b it takes back at the same point, and the rows do no work."""
    one, two, joint, _ = closed_pair(kind, 21, omega=(0.3, -0.2, 0.4))
    system = System([one, two], [joint], gravity=(0, 0, 0))
    solution = simulate(system, 0.6, output=21, rtol=1e-10)
    assert solution.certificate.passed, solution.certificate
    momentum, energy = solution.momentum(), solution.energy().total
    # what a run at 1e-10 leaves
    assert np.ptp(momentum.linear, axis=0).max() < 1e-9 and np.ptp(momentum.angular, axis=0).max() < 1e-8
    assert np.ptp(energy) < 1e-8 * energy.max()
    assert np.linalg.norm(solution.reaction(joint).force, axis=1).min() > 1e-3
    assert np.ptp(solution.slide(joint)) > 1e-2
    rate = np.gradient(solution.slide(joint), solution.t, edge_order=2)
    assert solution.rate(joint)[3:-3] == pytest.approx(rate[3:-3], abs=3e-2 * np.abs(rate).max())


@pytest.mark.parametrize("kind", KINDS)
def test_accelerations_are_those_of_the_second_formulation(kind):
    """In general states off the reference pose, where the point is between two points of the curve."""
    one, two, joint, _ = closed_pair(kind, 23)
    system = System([one, two], [joint], gravity=(0.3, -0.7, -9.6))
    rng = np.random.default_rng(24)
    for _ in range(3):
        state = consistent_state(system, rng)
        near = replace(state, q=Evaluation(system).normalised(state.q + 0.05 * rng.normal(size=state.q.size)))
        state = system.assemble(near=near)
        state = replace(state, v=consistent(system, state, rng.normal(size=state.v.size)))
        expected, found = reference_point.solve(system, state), accelerations(system, state)
        limit = 1e-10 * np.abs(expected.acceleration).max()
        assert found.arrays["acceleration"][0] == pytest.approx(expected.acceleration, abs=limit)
        assert np.abs(found.slide(joint)[0]) > 1e-3


def consistent(system, state, wanted):
    """The velocities nearest to those wanted that the joints allow."""
    J = reference_point.constraint_rows(system, state).J
    return wanted - np.linalg.pinv(J, rcond=1e-10) @ (J @ wanted)


@pytest.mark.parametrize("kind", KINDS)
def test_reference_points_do_not_matter(kind):
    one, two, joint, shift = closed_pair(kind, 22, omega=(0.3, -0.2, 0.4), velocity=None)
    here = System([one, two], [joint])
    other = [moved_reference(body, 0.3 * shift) for body in (one, two)]
    again = CurveContact(*other, joint.curve, at=joint.at, pin=joint.pin, radius=joint.radius, face=joint.face)
    there = System(other, [again])
    first, second = accelerations(here), accelerations(there)
    assert second.alpha("one") == pytest.approx(first.alpha("one"), rel=1e-9)
    force = first.reaction(joint).force
    assert second.reaction(again).force == pytest.approx(force, abs=1e-10 * np.abs(force).max())


WIRE = 2 * np.pi * np.arange(240) / 240


def wire(u, order=0):
    """A closed wire in space and its derivatives."""
    phase = order * np.pi / 2
    return np.stack([np.cos(u + phase), 1.3 * np.sin(u + phase), 2.0**order * 0.4 * np.sin(2 * u + phase)], axis=-1)


def test_a_bead_on_a_wire_moves_as_scipy_has_it():
    """Its centre of mass is the point: x'.x' u_ddot = x'.(g - x'' u_dot^2)."""
    gravity, start = np.array([0.3, -0.7, -9.6]), 0.4
    bead = Body("bead", 0.7, (0.1, 0.2, 0.25), com=(0.1, 0.2, -0.1), position=wire(WIRE[40]) - (0.1, 0.2, -0.1))
    held = CurveContact(GROUND, bead, wire(WIRE), at=wire(WIRE[40]), name="wire")
    system = System([bead], [held], gravity=gravity)
    state = system.state()
    speed = start * wire(WIRE[40], 1)
    v = np.concatenate([speed, np.zeros(3)])
    solution = simulate(system, 2.0, state=type(state)(0.0, state.q, v), rtol=1e-11, output=21)

    def rates(_, y):
        along, bend = wire(y[0], 1), wire(y[0], 2)
        return y[1], along @ (gravity - bend * y[1] ** 2) / (along @ along)

    run = solve_ivp(rates, (0, 2.0), (WIRE[40], start), "DOP853", solution.t, rtol=1e-12, atol=1e-13)
    # points every 1.5 degrees: the spline misses the wire by 1e-9, its second derivative by 1e-6
    assert solution.com(bead) == pytest.approx(wire(run.y[0]), abs=1e-6)
    assert np.ptp(run.y[0]) > 1.0
    force = bead.mass * (solution.acceleration(bead) - gravity)
    assert solution.reaction(held).force == pytest.approx(force, abs=1e-9 * np.abs(force).max())


def figure_of_eight(**options):
    """A bead on a wire that crosses itself; its speed is 1 m/s."""
    eight = np.column_stack([np.sin(WIRE), np.sin(WIRE) * np.cos(WIRE), 0 * WIRE])
    bead = Body("bead", 0.7, (0.1, 0.2, 0.25), position=eight[11], omega=(0, 0, 0), **options)
    return bead, CurveContact(GROUND, bead, eight, at=eight[11], name="wire")


def test_a_bead_runs_straight_over_a_crossing():
    bead, held = figure_of_eight()
    along = held.line.along(held.start)
    bead, held = figure_of_eight(velocity=along)
    length = held.line.length
    solution = simulate(System([bead], [held], gravity=(0, 0, 0)), 1.5 * length, rtol=1e-10, output=101)
    assert solution.slide(held) == pytest.approx(solution.t, abs=1e-7)
    assert solution.position(bead) == pytest.approx(held.line.x(held.start + solution.t), abs=1e-7)
    tangent, bend = (held.line.x(held.start + solution.slide(held), k) for k in (1, 2))
    square = np.einsum("ti,ti->t", tangent, tangent)[:, None]  # 1 to 1e-6
    curvature = (bend - tangent * np.einsum("ti,ti->t", tangent, bend)[:, None] / square) / square
    assert solution.reaction(held).force == pytest.approx(bead.mass * curvature, abs=1e-7)
    # every step keeps it to rtol
    assert np.ptp(solution.energy().total) < 1e-10 * solution.certificate.steps * solution.energy().total[0]


def test_a_driver_leads_along_a_curve_but_not_at_a_speed_along_an_axis():
    bead, held = figure_of_eight()
    driven = SlideDriver(held, Polynomial((0.0, 0.0, 0.5)), name="drive")
    system = System([bead], [held, driven], gravity=(0, 0, 0))
    solution = simulate(system, 1.0, state=system.assemble(), output=11)
    assert solution.position(bead) == pytest.approx(held.line.x(held.start + 0.5 * solution.t**2), abs=1e-9)
    assert solution.effort(driven) == pytest.approx(bead.mass, rel=1e-4)  # 1 m/s^2 over a length good to 1e-5
    with pytest.raises(ValueError, match="leads along a curve"):
        SpeedDriver(held, 1.0)
    with pytest.raises(ValueError, match="held from all sides"):
        held.contact_normal(solution)
    found = System([bead], [held]).assemble(slides={held: 1.0})
    assert found.q[:3] == pytest.approx(held.line.x(held.start + 1.0), abs=1e-9)
    drawn = [piece for piece in draw_system(system).pieces if piece.name == "drive"]
    assert all(np.isfinite(piece.mesh.vertices).all() for piece in drawn) and drawn


def test_friction_brakes_along_a_curve_and_a_measure_stops_there():
    """m s_ddot = -c s_dot: the bead comes to m v / c, and is at half of it after ln 2 m / c."""
    bead, held = figure_of_eight()
    bead, held = figure_of_eight(velocity=held.line.along(held.start))
    brake = JointFriction(held, viscous=0.35, name="brake")
    system, reach = System([bead], [held], [brake], gravity=(0, 0, 0)), bead.mass / 0.35
    solution = simulate(system, 5.0, stop_when=measures.slide(held) > 0.5 * reach, output=11)
    # speed and length of the spline are 1 to 1e-6
    assert solution.final.t == pytest.approx(np.log(2) * bead.mass / 0.35, rel=1e-5)
    assert solution.force(brake).power == pytest.approx(-0.35 * solution.rate(held) ** 2, rel=1e-6)


def test_a_bead_swings_at_the_bottom_with_the_curvature():
    a, b, u = 1.7, 0.9, WIRE
    bowl = np.column_stack([a * np.sin(u), 0.3 + 0 * u, -b * np.cos(u)])
    bead = Body("bead", 0.7, (0.1, 0.2, 0.25), position=bowl[0], velocity=(0, 0, 0), omega=(0, 0, 0))
    found = linearize(System([bead], [CurveContact(GROUND, bead, bowl, at=bowl[0])]))
    rates = np.abs(found.eigenvalues.imag)
    assert rates.max() == pytest.approx(np.sqrt(9.81 * b / a**2), rel=1e-6)


def test_a_run_ends_where_an_open_curve_does():
    slope = np.column_stack([np.linspace(0, 2, 41), np.zeros(41), -0.3 * np.linspace(0, 2, 41) ** 2])
    bead = Body("bead", 0.7, (0.1, 0.2, 0.25), position=slope[5], omega=(0, 0, 0))
    rail = CurveContact(GROUND, bead, slope, at=slope[5], closed=False, name="rail")
    system = System([bead], [rail])
    with pytest.raises(IntegrationError, match="end of its curve at t = .*'rail'") as error:
        simulate(system, 5.0)
    solution = error.value.solution
    assert np.linalg.norm(solution.position(bead)[-1] - slope[-1]) < 1e-5
    # z = -0.3 x^2 from rest
    start = slope[5, 0]
    time = quad(lambda x: np.sqrt((1 + 0.36 * x**2) / (2 * 9.81 * 0.3 * (x**2 - start**2))), start, 2.0, limit=200)[0]
    assert solution.t[-1] == pytest.approx(time, rel=1e-5)


FLAT = np.column_stack([3 * np.cos(TURN), 2 * np.sin(TURN), 0 * TURN])
BODY = Body("part", 1.0, (1, 1, 1), position=(3, 0, 0))


def with_cusp():
    """An astroid."""
    return np.column_stack([np.cos(TURN) ** 3, np.sin(TURN) ** 3, 0 * TURN])


def bean():
    r = 2 + 0.9 * np.cos(2 * TURN)
    return np.column_stack([r * np.cos(TURN), r * np.sin(TURN), 0 * TURN])


@pytest.mark.parametrize(
    ("curve", "given", "text"),
    [
        (FLAT[:5], {}, "8 to 20000 points"),
        (FLAT[:5], {"closed": False}, "6 to 20000 points"),
        (FLAT[:, :2], {}, "shape"),
        (np.where(FLAT == 3.0, np.nan, FLAT), {}, "finite"),
        (np.concatenate([FLAT, FLAT[:1]]), {}, "leave the last one out"),
        (np.insert(FLAT, 5, FLAT[5], axis=0), {}, "points 5 and 6 coincide"),
        (FLAT[:40], {}, "a gap of .* closed=False"),
        (with_cusp(), {}, "a corner or a cusp at point .* a turn of"),
        (FLAT, {"radius": 0.1}, "without pin="),
        (FLAT, {"pin": (0, 0, 1), "face": (1, 0, 0)}, "both face and pin"),
        (FLAT, {"pin": (0, 1, 0)}, "along the curve at point"),
        (FLAT, {"pin": (0, 0, 0)}, "zero length"),
        (FLAT, {"pin": np.ones((3, 3))}, "as the curve has"),
        (FLAT, {"pin": (0, 0, 1), "radius": -0.1}, "below 0"),
        (bean(), {"pin": (0, 0, 1), "radius": 2.0}, "hollow of radius .* smaller roller"),
        (bean(), {"face": (1, 0, 0)}, "hollow or straight at point"),
        (FLAT, {"face": (1, 0, 0.5)}, "in a plane"),
        (FLAT, {"closed": "yes"}, "closed"),
    ],
)
def test_curves_that_cannot_be_are_refused(curve, given, text):
    with pytest.raises(ValueError, match=f"joint 'cam'.*{text}"):
        CurveContact(GROUND, BODY, curve, at=(3, 0, 0), name="cam", **given)


def test_a_pin_and_an_axis_of_a_body_may_be_letters():
    turn = 2.0 * np.pi * np.arange(40) / 40
    oval = np.column_stack([0.4 * np.cos(turn), 0.3 * np.sin(turn), 0.0 * turn])
    roller = Body("roller", 1.0, (0.1, 0.1, 0.1), orientation=rotation((1, 2, 3), 0.4), omega=(0.3, 2.0, 1.0))
    joint = CurveContact(GROUND, roller, oval, at=(0.5, 0, 0), pin="z", radius=0.1, closed=True)
    assert np.array_equal(joint.pin, (0.0, 0.0, 1.0))
    run = simulate(System([roller]), 0.5, output=3)
    for body in ("roller", GROUND):
        assert np.array_equal(run.body_axis(body, "y"), run.body_axis(body, (0.0, 1.0, 0.0)))
    with pytest.raises(ValueError, match="pin is 'q'; give 'x', 'y', 'z' or a vector"):
        CurveContact(GROUND, roller, oval, at=(0.5, 0, 0), pin="q", radius=0.1, closed=True)
    with pytest.raises(ValueError, match="axis is 'q'; give 'x', 'y', 'z' or a vector"):
        run.body_axis("roller", "q")
