"""Linearisation against closed forms and hand-written matrices: none of the references shares code with ours."""

import matplotlib
import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
from helpers.closed_forms.small_motions import (
    circling_disc_rate,
    nutation_rate,
    sleigh_rate,
    upright_disc,
    whirling_pendulum_rate,
)
from helpers.models import Evaluation, all_joints_mechanism, direction, random_body, random_inertia, random_orientation

from mbsd3d import (
    GROUND,
    AngleDriver,
    AssemblyError,
    Body,
    Bushing,
    Cylindrical,
    Force,
    KnifeEdge,
    Planar,
    Prismatic,
    Ramp,
    Revolute,
    RollingDisc,
    Sine,
    SlideDriver,
    SpeedDriver,
    Spherical,
    SpringDamper,
    State,
    System,
    Table,
    TorsionSpring,
    linearize,
    measures,
    rotation,
)
from mbsd3d.errors import InputError
from mbsd3d.extend import Field, compile_system, mass_matrix
from mbsd3d.rotations import exponential, matrix
from validation import cases
from validation.theory.top import rolling_circle, steady_precession

EXACT = 1e-11
"""Rounding of some hundred operations, times the condition of eigenvalues that lie well apart."""

SHIFTS = [None, 7]


def close(found, expected, limit=EXACT):
    return abs(found - expected) <= limit * abs(expected)


def moving(found):
    """Eigenvalues that are not zero, those of a pair once."""
    return [s for s in found.eigenvalues if s != 0.0 and s.imag >= 0.0]


# --- about equilibria ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("shift", SHIFTS)
def test_hanging_pendulum(shift):
    found = linearize(cases.load("eig_hanging_pendulum", shift).system)
    assert close(found.eigenvalues[0], 3.83122751078574j)
    assert found.eigenvalues.size == 2 and len(found.modes) == 1
    assert found.mode(0).label == "angle of 'J'"


@pytest.mark.parametrize("shift", SHIFTS)
def test_two_four_bars_with_six_redundant_rows(shift):
    found = linearize(cases.load("eig_fourbar2_hanging", shift).system)
    # three rods of m l^2/3 and two couplers that go in a circle; three centres at l/2, two at l
    assert close(found.eigenvalues[0], 1j * np.sqrt(9.81 * 3.5 / 3.0))


@pytest.mark.parametrize("shift", SHIFTS)
def test_door_with_two_hinges_and_a_torsion_spring(shift):
    rng = np.random.default_rng(3)
    arm, J = np.array([0.45, 0.1, -0.2]), random_inertia(rng, 20.0)
    com = (0.0, 0.0, 0.0) if shift is None else (0.2, -0.1, 0.3)
    door = Body("door", mass=20.0, inertia=J, com=com, position=arm - com)
    hinges = [Revolute(GROUND, door, at=(0, 0, z), axis=(0, 0, 1), name=f"hinge{z}") for z in (0, 2)]
    spring = TorsionSpring(hinges[0], stiffness=35.0, damping=6.0)
    found = linearize(System([door], hinges, [spring]))
    about_hinge = J[2, 2] + 20.0 * (arm[0] ** 2 + arm[1] ** 2)
    expected = np.roots([about_hinge, 6.0, 35.0])
    assert np.abs(found.eigenvalues - expected).max() < EXACT * abs(expected[0])
    mode = found.mode(0)
    assert close(mode.natural_frequency, np.sqrt(35.0 / about_hinge) / (2 * np.pi))
    assert close(mode.damping_ratio, 6.0 / (2 * np.sqrt(35.0 * about_hinge)))
    assert close(mode.time_to_half, np.log(2) * 2 * about_hinge / 6.0) and mode.time_to_double == np.inf


def double_pendulum(seed):
    """(system at its hanging equilibrium, M, K): M = sum of J'M J, K_ij = -m g . n_i x (n_j x (p - o_j)), i <= j."""
    rng = np.random.default_rng(seed)
    bodies = [random_body(rng, name, position=direction(rng)) for name in ("upper", "lower")]
    o, n = rng.normal(size=(2, 3)), np.array([direction(rng) for _ in range(2)])
    n[:, 2] *= 0.3  # axes far from the vertical, or nothing swings
    n /= np.linalg.norm(n, axis=1)[:, None]
    R0 = [matrix(b.orientation) for b in bodies]
    p0 = [b.position + R @ b.com for b, R in zip(bodies, R0, strict=True)]
    g = np.array([0.0, 0.0, -9.81])

    def pose(x):
        first, second = matrix(exponential(x[0] * n[0])), matrix(exponential(x[1] * n[1]))
        both = first @ second
        o2, n2 = o[0] + first @ (o[1] - o[0]), first @ n[1]
        p = [o[0] + first @ (p0[0] - o[0]), o2 + both @ (p0[1] - o[1])]
        return [first @ R0[0], both @ R0[1]], p, [o[0], o2], [n[0], n2]

    def derivatives(x):
        R, p, at, axis = pose(x)
        pull, M, K = np.zeros(2), np.zeros((2, 2)), np.zeros((2, 2))
        for k, body in enumerate(bodies):
            J = np.array([np.cross(axis[j], p[k] - at[j]) for j in range(k + 1)])
            turn = np.array(axis[: k + 1]) @ R[k]
            pull[: k + 1] -= body.mass * J @ g
            M[: k + 1, : k + 1] += body.mass * J @ J.T + turn @ body.inertia @ turn.T
            for i in range(k + 1):
                for j in range(k + 1):
                    low, high = min(i, j), max(i, j)
                    K[i, j] -= body.mass * g @ np.cross(axis[low], J[high])
        return pull, M, K

    potential = lambda x: -sum(b.mass * g @ p for b, p in zip(bodies, pose(x)[1], strict=True))  # noqa: E731
    x = scipy.optimize.minimize(potential, [0.3, -0.2]).x
    for _ in range(4):  # Newton to rounding
        pull, M, K = derivatives(x)
        x = x - np.linalg.solve(K, pull)
    hinges = [Revolute(GROUND, bodies[0], at=o[0], axis=n[0], name="upper hinge")]
    hinges.append(Revolute(bodies[0], bodies[1], at=o[1], axis=n[1], name="lower hinge"))
    system = System(bodies, hinges)
    return system, system.assemble(angles=dict(zip(hinges, x, strict=True))), *derivatives(x)[1:]


@pytest.mark.parametrize("seed", range(4))
def test_spatial_double_pendulum(seed):
    system, state, M, K = double_pendulum(seed)
    expected = np.sqrt(scipy.linalg.eigh(K, M)[0])
    found = linearize(system, state)
    assert np.abs([s.imag for s in moving(found)] - expected).max() < 1e-10 * expected[1]  # 1e-12 missed in the pose
    hinges = [x for hinge in system.joints for x in (measures.angle(hinge), measures.rate(hinge))]
    A = linearize(system, state, outputs=[hinges[0], hinges[2], hinges[1], hinges[3]]).A
    known = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), np.zeros((2, 2))]])
    assert np.abs(A - known).max() < 1e-10 * np.abs(known).max()
    shapes = scipy.linalg.eigh(K, M)[1]
    for k, mode in enumerate(linearize(system, state, outputs=hinges).modes):
        ratio = mode.vector[2] / mode.vector[0]
        assert abs(ratio - shapes[1, k] / shapes[0, k]) < 1e-9 * max(1.0, abs(ratio))


def test_closed_four_bar_with_centres_of_mass_anywhere():
    rng = np.random.default_rng(5)
    crank, rod, rocker, base = 0.5, 0.9, 0.7, np.array([0.8, -0.15])
    at = [np.zeros(2), crank * np.array([np.cos(-1.2), np.sin(-1.2)])]
    masses, offsets = (1.3, 0.8, 2.1), np.array([[0.2, 0.07], [0.5, -0.11], [0.3, 0.09]])
    inertia = [random_inertia(rng, m, 0.2) for m in masses]

    def joint(a):
        """Where rod and rocker meet: intersection of two circles, complex-safe."""
        A = crank * np.array([np.cos(a), np.sin(a)])
        d = base - A
        square = d @ d
        along = (square + rod**2 - rocker**2) / (2 * square)
        across = -np.sqrt(rod**2 / square - along**2)
        return A, A + along * d + across * np.array([-d[1], d[0]])

    def places(a):
        """Centres of mass and unit directions of the three links."""
        A, B = joint(a)
        out = []
        for start, end, offset in zip((0 * A, A, base), (A, B, B), offsets, strict=True):
            u = (end - start) / np.sqrt((end - start) @ (end - start))
            out.append((start + offset[0] * u + offset[1] * np.array([-u[1], u[0]]), u))
        return out

    def slope(f, a, h=1e-3):
        """Central difference of eighth order."""
        weights = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
        return sum(w * (f(a + k * h) - f(a - k * h)) for k, w in enumerate(weights, 1)) / h

    def torque(a):
        return sum(m * 9.81 * p.imag[1] / 1e-30 for m, (p, _) in zip(masses, places(a + 1e-30j), strict=True))

    a = scipy.optimize.brentq(torque, -2.4, -0.8, xtol=1e-15)
    mass = 0.0
    for m, J, (p, u), (_, real) in zip(masses, inertia, places(a + 1e-30j), places(a), strict=True):
        turn = real[0] * u.imag[1] / 1e-30 - real[1] * u.imag[0] / 1e-30
        mass += m * (p.imag @ p.imag) / 1e-60 + J[1, 1] * turn**2
    expected = np.sqrt(slope(torque, a) / mass)

    at = [np.zeros(2), *joint(a), base]
    lift = lambda x: np.array([x[0], 0.4, x[1]])  # plane x z, so angles count about -y  # noqa: E731
    bodies = []
    for k, (m, J) in enumerate(zip(masses, inertia, strict=True)):
        p, u = places(a)[k]
        com = 0.3 * rng.normal(size=3)
        R = np.array([[u[0], 0, -u[1]], [0, 1, 0], [u[1], 0, u[0]]])
        bodies.append(Body(f"link{k}", mass=m, inertia=J, com=com, position=lift(p) - R @ com, orientation=R))
    pairs = ((GROUND, 0, 0), (0, 1, 1), (1, 2, 2), (GROUND, 2, 3))
    chain = [*bodies, GROUND]
    joints = [
        Revolute(GROUND if i is GROUND else chain[i], chain[j], at=lift(at[k]), axis=(0, 1, 0)) for i, j, k in pairs
    ]
    found = linearize(System(bodies, joints))
    assert close(found.eigenvalues[0].imag, expected, 1e-10)  # rounding of the difference formula
    assert abs(found.eigenvalues[0].real) < 1e-10


def test_body_on_a_damped_bushing():
    rng = np.random.default_rng(8)
    body = random_body(rng, "engine", mass=3.0)
    at, F = body.position + 0.4 * direction(rng), matrix(random_orientation(rng))
    k, kr, c, cr = (np.array(x) for x in ((900.0, 700.0, 400.0), (50.0, 80.0, 30.0), (4.0, 7.0, 3.0), (0.5, 0.9, 0.4)))
    bushing = Bushing(GROUND, body, at=at, axes=F, stiffness=k, turning_stiffness=kr, damping=c, turning_damping=cr)
    found = linearize(System([body], forces=[bushing], gravity=(0, 0, 0)))
    R = matrix(body.orientation)
    s = body.position + R @ body.com - at
    S = np.array([[0, -s[2], s[1]], [s[2], 0, -s[0]], [-s[1], s[0], 0]])
    M = np.block([[3.0 * np.eye(3), -3.0 * S], [3.0 * S, R @ body.inertia @ R.T + 3.0 * S @ S.T]])
    K, D = (scipy.linalg.block_diag(F * x @ F.T, F * y @ F.T) for x, y in ((k, kr), (c, cr)))
    state_matrix = np.block([[np.zeros((6, 6)), np.eye(6)], [-np.linalg.solve(M, K), -np.linalg.solve(M, D)]])
    expected = np.linalg.eigvals(state_matrix)
    miss = np.abs(found.eigenvalues[:, None] - expected).min(axis=1)
    assert miss.max() < 1e-11 * np.abs(expected).max() and len(found.modes) == 6
    assert found.states[0].endswith("of engine") and set(found.state_units) == {"m", "rad", "m/s", "rad/s"}


def bolt(size):
    """(system, hinge, bore): an arm on a hinge and a body in its skew bore, both on springs, unstressed."""
    rng = np.random.default_rng(11)
    arm, body = (
        Body(raw.name, mass=1.4, inertia=raw.inertia * size**2, com=raw.com * size, position=raw.position * size,
             orientation=raw.orientation)
        for raw in (random_body(rng, "arm"), random_body(rng, "bolt"))
    )  # fmt: skip
    hinge = Revolute(GROUND, arm, at=arm.position + size * direction(rng), axis=direction(rng), name="hinge")
    bore = Cylindrical(arm, body, at=body.position + 0.3 * size * direction(rng), axis=direction(rng), name="bore")
    at = body.position + 0.4 * size * direction(rng)
    spring = SpringDamper(GROUND, body, at_a=at + size * direction(rng), at_b=at, stiffness=70.0)
    twists = [TorsionSpring(joint, stiffness=k * size**2) for joint, k in ((hinge, 60.0), (bore, 40.0))]
    return System([arm, body], [hinge, bore], [spring, *twists], gravity=(0, 0, 0)), hinge, bore


def test_joint_gradients_are_those_of_angles_and_slides_and_name_modes_alike_at_any_size():
    labels = []
    for size in (1.0, 50.0, 0.02):
        system, hinge, bore = bolt(size)
        seen = [f(x) for x in (hinge, bore) for f in (measures.angle, measures.rate)]
        found = linearize(system, outputs=[*seen, measures.slide(bore), measures.slide_rate(bore)])
        gradients = {(joint, kind): gradient for joint, kind, gradient in found.joint_gradients}
        for mode in found.modes:
            pose = np.hstack([mode.translation, mode.rotation]).ravel()
            for k, key, unit in ((0, (hinge, "angle"), 1.0), (2, (bore, "angle"), 1.0), (4, (bore, "slide"), size)):
                assert gradients[key] @ pose == pytest.approx(mode.vector[k], abs=1e-10 * unit)  # of order 1
        labels.append([mode.label for mode in found.modes])
    assert labels[0] == labels[1] == labels[2] and "slide of 'bore'" in labels[0] and "angle of 'bore'" in labels[0]


@pytest.mark.parametrize("seed", range(3))
def test_every_joint_on_springs_to_the_ground(seed):
    """At rest and unstressed: q' = N_v eta, N_v'M N_v eta' = -N_v'(K N_q xi + D N_v eta), rows redundant or not."""
    plain = all_joints_mechanism(seed, drivers=False, gravity=(0, 0, 0))
    rng, n = np.random.default_rng(seed), 6 * len(plain.bodies)
    k, c = rng.uniform(20.0, 60.0, size=(len(plain.bodies), 6)), rng.uniform(0.5, 2.0, size=(len(plain.bodies), 6))
    springs = [
        Bushing(GROUND, body, at=body.position, axes=np.eye(3), stiffness=x[:3], turning_stiffness=x[3:],
                damping=y[:3], turning_damping=y[3:])
        for body, x, y in zip(plain.bodies, k, c, strict=True)
    ]  # fmt: skip
    system = System(plain.bodies, plain.joints, springs, gravity=(0, 0, 0))
    state = State(0.0, system.assemble().q, np.zeros(n))
    evaluation = Evaluation(system)
    _, J, _, _ = evaluation.rows(state.q, state.v, 0.0)
    holonomic = evaluation.model.row["holonomic"] == 1
    N_q, N_v = scipy.linalg.null_space(J[holonomic], rcond=1e-10), scipy.linalg.null_space(J, rcond=1e-10)
    M, K, D = mass_matrix(system, state), np.diag(k.ravel()), np.diag(c.ravel())
    rate = -np.linalg.solve(N_v.T @ M @ N_v, N_v.T @ np.hstack([K @ N_q, D @ N_v]))
    whole = np.vstack([np.hstack([np.zeros((N_q.shape[1],) * 2), N_q.T @ N_v]), rate])
    expected = np.linalg.eigvals(whole)
    found = linearize(system, state)
    assert found.space.configuration == N_q.shape[1] > found.space.velocity == N_v.shape[1]
    miss = np.abs(found.eigenvalues[:, None] - expected).min(axis=1)
    assert miss.max() < 1e-9 * np.abs(expected).max()  # many eigenvalues, some close together


def test_floating_chain_has_twelve_exact_zeros():
    rng = np.random.default_rng(6)
    bodies = [random_body(rng, f"link{k}", position=(k, 0.3 * (-1) ** k, 0.2 * k)) for k in range(8)]
    at = [b.position - (0.5, 0, 0.1) for b in bodies]
    hinges = [Revolute(*bodies[k - 1 : k + 1], at=at[k], axis=direction(rng)) for k in range(1, 8)]
    springs = [TorsionSpring(hinge, stiffness=rng.uniform(1.0, 2.0)) for hinge in hinges]
    system = System(bodies, hinges, springs, gravity=(0, 0, 0))
    found = linearize(system, State(0.0, system.assemble().q, np.zeros(48)))
    # six displacements and six velocities of the whole, in Jordan blocks; an eigenvalue solver makes 1e-8 of them
    assert np.sum(found.eigenvalues == 0.0) == 12 and len(moving(found)) == 7
    assert np.abs(found.eigenvalues.real).max() < 1e-12


# --- about steady motions -------------------------------------------------------------------------------------------

DISC = dict(mass=2.0, radius=0.5, transverse=0.14, axial=0.24)


def rolling_disc(speed, heading=0.0, place=(0.0, 0.0), com=(0.0, 0.0, 0.0), **fields):
    """A disc rolling straight with its reference point ``com`` off the centre."""
    R = matrix(rotation("z", heading))
    axis, turn = R @ [0, 1, 0], R @ [0, speed / DISC["radius"], 0]
    A, C = DISC["transverse"], DISC["axial"]
    numbers = {"mass": DISC["mass"], "inertia": (A, C, A), **fields}
    centre, arm = np.array([*place, DISC["radius"]]), R @ com
    disc = Body(
        "disc", com=com, position=centre - arm, orientation=R, omega=turn,
        velocity=R @ [speed, 0, 0] - np.cross(turn, arm), **numbers,
    )  # fmt: skip
    return System([disc], [RollingDisc(GROUND, disc, axis=axis, radius=DISC["radius"], centre=centre)]), axis


@pytest.mark.parametrize("com", [(0.0, 0.0, 0.0), (0.13, -0.07, 0.21)])
@pytest.mark.parametrize("speed", [0.5, 1.0, 1.4, 2.5, -1.7])
def test_disc_rolling_straight(speed, com):
    system, axis = rolling_disc(speed, 0.4, (0.3, -0.2), com)
    expected = upright_disc(**DISC, speed=speed)
    disc = system.bodies[0]
    lean, lean_rate = measures.lean(disc, lateral=axis), measures.lean_rate(disc, lateral=axis)
    found = linearize(system, outputs=[lean, lean_rate, measures.omega(disc, axis=(0, 0, 1))])
    assert np.abs(found.A - expected).max() < EXACT * np.abs(expected).max()
    pair = max(np.linalg.eigvals(expected), key=abs)
    full = linearize(system)
    for result in (found, full):
        assert max(abs(abs(s) - abs(pair)) for s in moving(result)) < EXACT * abs(pair)
    assert (full.eigenvalues.real > 1e-9).any() == (abs(speed) < critical_speed())
    assert full.eigenvalues.size == 8 and full.space.configuration == 5 and full.space.velocity == 3


def critical_speed():
    A, C, m, r = DISC["transverse"], DISC["axial"], DISC["mass"], DISC["radius"]
    return np.sqrt(A * m * 9.81 * r**3 / (C * (C + m * r**2)))


def test_disc_at_half_a_metre_per_second_is_the_known_one():
    numbers = dict(mass=1.0, inertia=(0.0625, 0.125, 0.0625))  # a thin one of r = 0.5 m
    system, _ = rolling_disc(0.5, **numbers)
    assert close(linearize(system).eigenvalues[-1], np.sqrt(0.8 * (9.81 / 0.5 - 3 * 0.5**2 / 0.5**2)))


def test_nearest_to_the_critical_speed_the_divided_matrix_keeps_its_digits():
    system, axis = rolling_disc(critical_speed() * (1 + 1e-6))
    disc = system.bodies[0]
    outputs = [measures.lean(disc), measures.lean_rate(disc), measures.omega(disc, axis=(0, 0, 1))]
    square = np.square(max(linearize(system, outputs=outputs).eigenvalues, key=abs)).real
    A = upright_disc(**DISC, speed=critical_speed() * (1 + 1e-6))
    assert abs(square - (A[1, 0] + A[1, 2] * A[2, 1])) < 1e-13 * 9.81 / DISC["radius"]  # the square is a difference


@pytest.mark.parametrize("shift", SHIFTS)
def test_top_in_slow_precession(shift):
    found = linearize(cases.load("top_slow_precession", shift).system)
    A, C, tilt, spin, W = 0.02 + 2 * 0.3**2, 0.015, np.radians(60), 150.0, 3.0218471088585135
    expected = np.sqrt(nutation_rate(A, C, spin, 2 * 9.81 * 0.3, tilt, W))
    pair = moving(found)
    assert len(pair) == 1 and close(pair[0], 1j * expected, 1e-10)  # the state is given to 1e-14 of 150 rad/s
    assert np.abs(found.eigenvalues.real).max() < 1e-9
    assert np.abs(found.generator.rotation - [0, 0, W]).max() < 1e-10 * W
    assert np.abs(found.generator.axis_point[:2]).max() < 1e-9


@pytest.mark.parametrize("branch", [0, 1])
def test_precessing_top_has_no_false_real_root(branch):
    """The frozen matrix, without the generator, has one; slow and fast precession, tilted to any side."""
    m, l, A, C, tilt, spin = 1.5, 0.2, 0.09, 0.03, 0.7, 60.0
    W = steady_precession(A, C, spin, m * 9.81 * l, tilt)[branch]
    R = matrix(rotation("z", 0.9)) @ matrix(rotation("x", tilt))
    axis = R[:, 2]
    w = W * np.array([0, 0, 1]) + (spin - W * np.cos(tilt)) * axis
    top = Body(
        "top", mass=m, inertia=(A - m * l**2, A - m * l**2, C), com=(0, 0, l), position=(0.4, -0.3, 1.1),
        orientation=R, omega=w, velocity=(0, 0, 0),
    )  # fmt: skip
    found = linearize(System([top], [Spherical(GROUND, top, at=(0.4, -0.3, 1.1))]))
    expected = np.sqrt(nutation_rate(A, C, spin, m * 9.81 * l, tilt, W))
    assert [close(s, 1j * expected, 1e-10) for s in moving(found)] == [True]
    assert np.abs(found.generator.axis_point[:2] - [0.4, -0.3]).max() < 1e-9
    turned = found.generator.transport(1, 0) @ found.space.E
    frozen = np.linalg.eigvals(found.A + turned[found.space.chosen])
    assert frozen.real.max() > 0.1


@pytest.mark.parametrize("shift", SHIFTS)
def test_disc_rolling_on_a_circle(shift):
    found = linearize(cases.load("rolling_disc_circular", shift).system)
    body = dict(mass=0.3048, radius=0.05, transverse=0.0001905, axial=0.000381)
    motion = rolling_circle(**body, circle=0.5, lean=np.radians(5))
    axial_spin = motion.spin + motion.precession * np.sin(np.radians(5))
    rate = circling_disc_rate(**body, lean=np.radians(5), precession=motion.precession, spin=axial_spin)
    wobble, turn = np.sqrt(rate), motion.precession
    # displacements of the whole circle stand still in the world, so they turn in the axes that turn with the disc
    assert np.allclose([s.imag for s in moving(found)], [turn, wobble], rtol=1e-10, atol=0.0)
    assert np.abs(found.eigenvalues.real).max() < 1e-10
    assert abs(abs(found.generator.rotation[2]) - turn) < EXACT * turn


@pytest.mark.parametrize("speed", [2.3, -2.3])
@pytest.mark.parametrize("sideways", [0.0, 0.35])
def test_chaplygin_sleigh(speed, sideways):
    rng = np.random.default_rng(2)
    J, ahead = random_inertia(rng, 1.7), 0.4
    R, blade = matrix(rotation("z", -0.6)), np.array([0.7, 0.2, 0.0])
    centre = blade + R @ [ahead, sideways, 0.3]
    sleigh = Body(
        "sleigh", mass=1.7, inertia=J, com=(0.1, -0.2, 0.15), position=centre - R @ [0.1, -0.2, 0.15], orientation=R,
        velocity=R @ [speed, 0, 0], omega=(0, 0, 0),
    )  # fmt: skip
    edge = KnifeEdge(GROUND, sleigh, at=blade, lateral=R @ [0, 1, 0])
    system = System([sleigh], [Planar(GROUND, sleigh, at=blade, normal=(0, 0, 1)), edge])
    expected = sleigh_rate(1.7, J[2, 2], ahead, speed)
    (rate,) = moving(linearize(system))
    assert close(rate, expected)
    divided = linearize(system, outputs=[measures.omega(sleigh, axis=(0, 0, 1))])
    assert divided.A.shape == (1, 1) and close(divided.A[0, 0], expected)
    assert (divided.mode(0).time_to_double < np.inf) == (speed < 0)


def gimbal(spin, inertia=(0.03, 0.05, 0.03), angle=False):
    """(system, Jz, Jx): rotor about y in a frame about x in a frame about z, damped springs on both frames."""
    frames = [Body("outer", mass=1.0, inertia=(0.3, 0.2, 0.4)), Body("inner", mass=1.0, inertia=(0.3, 0.2, 0.15))]
    rotor = Body("rotor", mass=2.0, inertia=inertia)
    z = Revolute(GROUND, frames[0], at=(0, 0, 0), axis=(0, 0, 1), name="yaw")
    x = Revolute(frames[0], frames[1], at=(0, 0, 0), axis=(1, 0, 0), name="pitch")
    y = Revolute(frames[1], rotor, at=(0, 0, 0), axis=(0, 1, 0))
    motor = AngleDriver(y, Ramp(spin)) if angle else SpeedDriver(frames[1], rotor, axis=(0, 1, 0), speed=spin)
    springs = [TorsionSpring(z, stiffness=7.0, damping=0.3), TorsionSpring(x, stiffness=4.0, damping=0.2)]
    return System([*frames, rotor], [z, x, y, motor], springs), 0.4 + 0.15 + inertia[2], 0.3 + inertia[0]


@pytest.mark.parametrize(("angle", "t"), [(False, 0.0), (True, 0.0), (True, 2.7)])
def test_driven_rotor_in_a_gimbal(angle, t):
    system, Jz, Jx = gimbal(40.0, angle=angle)
    H = 0.05 * 40.0  # Jz yaw'' + H pitch' = ..., Jx pitch'' - H yaw' = ...
    M, G, K = np.diag([Jz, Jx]), np.array([[0.3, H], [-H, 0.2]]), np.diag([7.0, 4.0])
    known = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.linalg.solve(M, K), -np.linalg.solve(M, G)]])
    yaw, pitch, *_ = system.joints
    outputs = [measures.angle(yaw), measures.angle(pitch), measures.rate(yaw), measures.rate(pitch)]
    state = system.assemble(angles={yaw: 0.0, pitch: 0.0}, rates={yaw: 0.0, pitch: 0.0}, t=t)
    found = linearize(system, state, outputs=outputs)
    assert np.abs(found.A - known).max() < EXACT * np.abs(known).max()
    assert found.states[0] == "angle of yaw" and found.state_units == ("rad", "rad", "rad/s", "rad/s")
    expected = np.linalg.eigvals(known)
    assert (
        np.abs(linearize(system, state).eigenvalues[:, None] - expected).min(axis=0).max()
        < EXACT * np.abs(expected).max()
    )


@pytest.mark.parametrize("offset", [0.0, 0.25])
def test_pendulum_carried_round_a_shaft(offset):
    mass, J, l, turn = 1.4, (0.04, 0.05, 0.02), 0.3, 4.0

    def balance(p):
        change = 2 * mass * (offset + l * np.sin(p)) * l * np.cos(p) + (J[1] - J[2]) * np.sin(2 * p)
        return 0.5 * turn**2 * change - mass * 9.81 * l * np.sin(p)

    angle = 0.0 if offset == 0.0 else scipy.optimize.brentq(balance, 0.01, 1.5, xtol=1e-15)
    shaft = Body("shaft", mass=2.0, inertia=(0.2, 0.3, 0.2), com=(0, 0, 0.2))
    bob = Body("bob", mass=mass, inertia=(J[1], J[0], J[2]), com=(0, 0, -l), position=(offset, 0, 0))
    column = Revolute(GROUND, shaft, at=(0, 0, 0), axis=(0, 0, 1), name="column")
    hinge = Revolute(shaft, bob, at=(offset, 0, 0), axis=(0, -1, 0), name="hinge")
    system = System([shaft, bob], [column, hinge, SpeedDriver(GROUND, shaft, axis=(0, 0, 1), speed=turn)])
    state = system.assemble(angles={hinge: angle}, rates={hinge: 0.0})
    found = linearize(system, state, outputs=[measures.angle(hinge), measures.rate(hinge)])
    expected = whirling_pendulum_rate(mass, J, l, offset, turn, angle)
    assert close(found.A[1, 0], -expected, 1e-10)  # the equilibrium angle is known to rounding of a difference
    assert np.abs(found.generator.rotation - [0, 0, turn]).max() < 1e-9


BICYCLE = cases.read("bicycle_eigenvalues")


def bicycle(speed, shift):
    """The benchmark bicycle of Meijaard et al. 2007 running straight, with the steer axis to all digits."""
    raw = {**BICYCLE, "bodies": [dict(body) for body in BICYCLE["bodies"]]}
    for body in raw["bodies"]:
        body["v0"], body["w0"] = ([x * speed / 5.0 for x in body[key]] for key in ("v0", "w0"))
    tilt = np.pi / 10
    raw["joints"] = [dict(joint) for joint in raw["joints"]]
    raw["joints"][2].update(p=[1.1 - 0.9 * np.sin(tilt), 0, 0.9 * np.cos(tilt)], axis=[-np.sin(tilt), 0, np.cos(tilt)])
    return cases.build(raw, shift).system


@pytest.mark.parametrize("shift", SHIFTS)
@pytest.mark.parametrize("row", BICYCLE["reference"]["values"], ids=lambda row: f"{row['v']} m per s")
def test_bicycle_has_the_published_eigenvalues(row, shift):
    system = bicycle(row["v"], shift)
    frame, steer = system.part("rearframe"), system.part("steer", "joints")
    outputs = [measures.lean(frame), measures.angle(steer), measures.lean_rate(frame), measures.rate(steer)]
    found = linearize(system, outputs=outputs)
    expected = np.array([complex(*pair) for pair in row["eigenvalues"]])
    assert np.abs(found.eigenvalues[:, None] - expected).min(axis=0).max() < 1e-12 * np.abs(expected).max()
    full = linearize(system)
    assert full.eigenvalues.size == 10 and np.sum(full.eigenvalues == 0.0) == 6  # place, heading, speed, wheel angles
    assert np.abs(full.eigenvalues[:, None] - expected).min(axis=0).max() < 1e-12 * np.abs(expected).max()


def test_bicycle_at_its_critical_speeds():
    for name in ("weave_speed", "capsize_speed"):
        found = linearize(bicycle(BICYCLE["reference"][name], 7))
        slowest = min((s for s in found.eigenvalues if s != 0.0), key=lambda s: abs(s.real), default=0.0)
        zero = np.sum(found.eigenvalues == 0.0) == 7  # a capsize rate below rounding is a zero like the six others
        # the speeds are published with 15 digits; rounding times the condition 300 of M and rates of 13 1/s is 9e-13
        assert zero or abs(slowest.real) < 1e-12


def orbit(factor):
    """A puck on a table, on a spring to a pin, passing an apsis with ``factor`` times the speed of the circle."""
    k, m, rest, r = 30.0, 1.5, 0.4, 0.9
    turn, R = np.sqrt(k / m * (r - rest) / r), matrix(rotation("z", 0.8))
    pin, away = np.array([0.5, -0.7, 0.2]), R @ [r, 0, 0]
    puck = Body(
        "puck", mass=m, inertia=random_inertia(np.random.default_rng(1), m), position=pin + away,
        velocity=factor * turn * r * R[:, 1], omega=(0, 0, 1.7),
    )  # fmt: skip
    spring = SpringDamper(GROUND, puck, at_a=pin, at_b=pin + away, stiffness=k, length=rest)
    return System([puck], [Planar(GROUND, puck, at=pin, normal=(0, 0, 1))], [spring]), turn, k / m


def test_puck_that_circles_on_a_spring():
    system, turn, stiffness = orbit(1.0)
    found = linearize(system)
    (pair,) = moving(found)
    assert close(pair, 1j * np.sqrt(3 * turn**2 + stiffness))  # r'' = h^2/r^3 - k (r - l)/m
    assert np.abs(found.generator.rotation - [0, 0, turn]).max() < EXACT * turn
    with pytest.raises(ValueError, match="change along the motion"):
        linearize(orbit(1.1)[0])  # at an apsis the acceleration is that of some circle, but not for long


def test_free_precession_in_space_is_steady():
    A, C = 0.7, 0.3
    w, com = np.array([0.4, -0.9, 2.0]), (0.1, 0.2, -0.3)
    body = Body("body", mass=2.0, inertia=(A, A, C), com=com, omega=w, velocity=-np.cross(w, com))
    found = linearize(System([body], gravity=(0, 0, 0)))
    assert np.abs(np.cross(found.generator.rotation, w * [A, A, C])).max() < 1e-9  # turns about its momentum
    # in turning axes a drift of the whole is a Jordan block at +-i Omega: rounding moves that by its square root
    assert np.abs(found.eigenvalues.real).max() < 10 * np.sqrt(np.finfo(float).eps) * np.linalg.norm(w)


# --- modes ------------------------------------------------------------------------------------------------------------


def test_modes_are_normalised_and_move_with_closed_joints(tmp_path):
    case = cases.load("eig_fourbar2_hanging", 7)
    found = linearize(case.system)
    mode = found.mode(0)
    moves = np.hstack([mode.translation / found.compiled.model.length, mode.rotation])
    assert abs(np.abs(moves).max() - 1.0) < 1e-12
    largest = moves.ravel()[np.argmax(np.abs(moves))]
    assert abs(largest.imag) < 1e-12 and largest.real > 0.0
    # the couplers go in a circle without turning, with the ends of rods as long as two lengths of the model
    assert np.abs(mode.shape("coupler0")[1]).max() < 1e-12
    assert abs(np.abs(mode.shape("rod1")[1][2]) - 1.0 / 2.0) < 1e-12
    motion = mode.motion(amplitude=0.3, cycles=1.0, samples=9)
    assert close(motion.t[-1], 1.0 / mode.frequency)
    pin = motion.position("rod0") + motion.rotation("rod0") @ case.system.bodies[0].local_point(np.zeros(3))
    assert np.abs(pin).max() < 1e-12  # the pin of rod 0 stays at the origin
    tilt = np.arctan2(motion.rotation("rod1")[:, 1, 0], motion.rotation("rod1")[:, 0, 0])
    assert np.abs(np.abs(tilt).max() - 0.3 * np.abs(mode.shape("rod1")[1][2])) < 0.02 * 0.3  # closing moves a little
    page = mode.animate(cycles=0.1, path=tmp_path / "mode")
    assert (tmp_path / "mode.html").read_text() == page.html
    assert page.bodies == len(case.system.bodies) and page.frames >= 25 and close(page.seconds, 0.1 / mode.frequency)


def test_modes_of_outputs_have_the_shapes_of_the_whole():
    system = bicycle(4.0, 7)
    frame, steer = system.part("rearframe"), system.part("steer", "joints")
    outputs = [measures.lean(frame), measures.angle(steer), measures.lean_rate(frame), measures.rate(steer)]
    some, whole = linearize(system, outputs=outputs), linearize(system)
    weave = [next(mode for mode in found.modes if mode.eigenvalue.imag) for found in (some, whole)]
    assert np.abs(weave[0].translation - weave[1].translation).max() < 1e-10  # rounding, times the condition of A - s
    assert np.abs(weave[0].rotation - weave[1].rotation).max() < 1e-10
    lean = weave[0].shape(frame)[1][0]  # about the direction of travel, which lifts the lateral axis
    assert abs(lean - weave[0].vector[0]) < 1e-10 and weave[0].label == "angle of 'steer'"
    mode = some.mode(0)
    assert close(mode.vector[2], mode.eigenvalue * mode.vector[0], 1e-9)  # the lean rate is the rate of the lean


def test_motion_of_every_kind_of_mode():
    found = linearize(bicycle(4.0, None))
    for mode in found.modes:
        motion = mode.motion(amplitude=0.05, cycles=1.5, samples=7)
        reach = np.abs(motion.arrays["q"] - found.state.q.reshape(-1, 7)).max()
        assert 1e-3 < reach < 0.2 and np.isfinite(motion.t).all()
    for samples in ("many", 2.5, 1, 10**12):
        with pytest.raises(InputError, match=f"motion: samples = '?{samples}'?; give a whole number from 2 to 100000"):
            mode.motion(samples=samples)
    with pytest.raises(InputError, match="animate: cycles: expected a number, got 'two'"):
        mode.animate(cycles="two")


def test_table_and_figure():
    found = linearize(gimbal(40.0)[0])
    text = str(found)
    assert len(text.splitlines()) == 2 + len(found.modes) and "angle of 'pitch'" in text and "f [Hz]" in text
    figure = found.plot()
    assert isinstance(figure, matplotlib.figure.Figure)
    axes = figure.axes[0]
    assert axes.get_xlabel().endswith("[1/s]") and axes.get_ylabel().endswith("[rad/s]")
    drawn = np.concatenate(
        [line.get_xdata() + 1j * line.get_ydata() for line in axes.lines[: len(found.modes)]]
    )  # then the axes
    assert np.isin(found.eigenvalues, drawn).all() and drawn.size == found.eigenvalues.size  # one of them zero
    with pytest.raises(ValueError, match="not one of the"):
        found.mode(99)
    assert repr(found.mode(0)).startswith(f"<mode: {found.mode(0).label}, ")
    assert repr(found.mode(0).motion(samples=3)).startswith("<motion: 3 samples, 0 ... ")


# --- refusals ---------------------------------------------------------------------------------------------------------


def pendulum():
    bob = Body("bob", mass=1.0, inertia=(0.1, 0.2, 0.3), com=(0.1, 0.05, -0.4))
    hinge = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0.2, 1, 0), name="hinge")
    return System([bob], [hinge]), hinge


def test_no_equilibrium():
    system, hinge = pendulum()
    with pytest.raises(ValueError, match="body 'bob' accelerates by .* not an equilibrium"):
        linearize(system)
    system, _ = rolling_disc(1.0)
    disc = system.bodies[0]
    cart = Body("cart", mass=1.0, inertia=(1, 1, 1), position=(0, 3, 0), velocity=(2.0, 0, 0), omega=(0, 0, 0))
    rail = Prismatic(GROUND, cart, at=(0, 3, 0), axis=(1, 0, 0))
    with pytest.raises(ValueError, match="does not move with the mechanism as a whole"):
        linearize(System([disc, cart], [*system.joints, rail]))


def test_unsymmetric_rotors_are_refused():
    system, _ = rolling_disc(1.0, inertia=(0.14, 0.24, 0.12))
    with pytest.raises(ValueError, match="change along the motion .* body 'disc'"):
        linearize(system)
    with pytest.raises(ValueError, match="change along the motion"):
        linearize(gimbal(40.0, (0.03, 0.05, 0.035))[0])


def test_signals_that_vary_are_named():
    system, hinge = pendulum()
    bob = system.bodies[0]
    slider = Prismatic(GROUND, bob, at=(0, 0, 0), axis=(0, 0.6, 0.8))
    table = Table((0, 1, 2, 3), (0.0, 0.1, 0.0, 0.2))
    for driver in (AngleDriver(hinge, Sine(0.1, 2.0), name="motor"), AngleDriver(hinge, table, name="motor")):
        with pytest.raises(ValueError, match="signal of 'motor' varies"):
            linearize(System([bob], [hinge, driver]))
    with pytest.raises(ValueError, match="signal of 'motor' varies"):
        linearize(System([bob], [slider, SlideDriver(slider, 0.5 * Sine(0.1, 2.0), name="motor")]))
    with pytest.raises(ValueError, match="signal of 'push' varies .* give a constant"):
        linearize(System([bob], [hinge], [Force(bob, (0, 0, Ramp(1.0)), name="push")]))
    with pytest.raises(ValueError, match="signal of 'motor' varies .* a constant speed"):
        linearize(System([bob], [hinge, SpeedDriver(GROUND, bob, axis=(0.2, 1, 0), speed=Ramp(1.0), name="motor")]))


def test_nothing_free_and_inconsistent_states():
    system, hinge = pendulum()
    with pytest.raises(ValueError, match="leave no degree of freedom"):
        linearize(System(system.bodies, [hinge, AngleDriver(hinge, 0.0)]))
    state = system.state()
    state.q[0] += 0.01
    with pytest.raises(AssemblyError, match="hinge"):
        linearize(system, state)


def test_force_without_a_derivative_is_named():
    system, hinge = pendulum()
    system = System(system.bodies, [hinge], [TorsionSpring(hinge, stiffness=3.0, name="coil")])
    field = Field(compile_system(system), system.state(), 0)
    field.check_finite({})
    field.data.force["power"][0] = np.nan  # as a function of the user's leaves it that fails for complex numbers
    with pytest.raises(ValueError, match="TorsionSpring 'coil' has no derivative"):
        field.check_finite({})
    with pytest.raises(ValueError, match="no finite derivative"):
        field.data.force["power"][0] = 0.0
        field.check_finite({"c": np.array([np.nan])})


def test_singular_position():
    """A parallelogram stretched out on a line: there it may also fold into the antiparallel form."""
    length = (1.0, 2.0, 1.0)
    starts = ((0, 0, 0), (1, 0, 0), (2, 0, 0))
    bars = [
        Body(f"bar{k}", mass=1.0, inertia=(0.1, 0.1, 0.1), com=(x / 2, 0, 0), position=start)
        for k, (x, start) in enumerate(zip(length, starts, strict=True))
    ]
    at = ((0, 0, 0), (1, 0, 0), (3, 0, 0), (2, 0, 0))
    pairs = ((GROUND, bars[0]), (bars[0], bars[1]), (bars[1], bars[2]), (GROUND, bars[2]))
    joints = [Revolute(a, b, at=p, axis=(0, 0, 1)) for (a, b), p in zip(pairs, at, strict=True)]
    with pytest.raises(ValueError, match="singular position"):
        linearize(System(bars, joints, gravity=(0, 0, 0)))


def test_outputs_that_do_not_close():
    system, _ = rolling_disc(1.0)
    disc, other = system.bodies[0], Body("other", mass=1.0, inertia=(1, 1, 1))
    lean, rate, turn = measures.lean(disc), measures.lean_rate(disc), measures.omega(disc, axis=(0, 0, 1))
    with pytest.raises(ValueError, match="do not close: the rate of 'lean rate of disc'"):
        linearize(system, outputs=[lean, rate])
    with pytest.raises(ValueError, match="depend on each other"):
        linearize(system, outputs=[lean, rate, turn, measures.lean(disc)])
    with pytest.raises(ValueError, match="body 'other' is not in the system"):
        linearize(system, outputs=[measures.lean(other)])
    with pytest.raises(ValueError, match="not a measure"):
        linearize(system, outputs=["lean"])
    with pytest.raises(ValueError, match="is zero, where a distance has no derivative"):
        linearize(system, outputs=[measures.distance(disc, disc)])
    with pytest.raises(ValueError, match="does not depend on the states"):
        linearize(system, outputs=[measures.distance(disc, disc, at_b=(0.1, 0, 0))])
    circle = cases.load("rolling_disc_circular").system
    with pytest.raises(ValueError, match="not the same function all along"):
        linearize(circle, outputs=[measures.position(circle.bodies[0], axis=(1, 0, 0))])
    with pytest.raises(ValueError, match="not a System"):
        linearize("mechanism")


def test_axes_of_the_world_do_not_matter():
    """The whole model turned about the vertical and moved: the same eigenvalues."""
    rng = np.random.default_rng(4)
    heading, place = 1.1, rng.normal(size=2)
    plain, moved = (linearize(rolling_disc(0.7, *where)[0]) for where in ((), (heading, place)))
    assert np.abs(plain.eigenvalues - moved.eigenvalues).max() < EXACT * np.abs(plain.eigenvalues).max()
