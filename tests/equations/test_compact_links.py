"""Mechanisms of hinges, slides and free bodies by compact links: against rows, and which mechanisms are such."""

import numpy as np
import pytest
from helpers.chains import arm, four_bar
from helpers.models import consistent_state, direction, random_body
from helpers.second_formulation import differences

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AngleDriver,
    Distance,
    DryFriction,
    Force,
    Gear,
    JointFriction,
    LengthDriver,
    Prismatic,
    Revolute,
    Sine,
    Spherical,
    SpringDamper,
    System,
    TorsionSpring,
    accelerations,
    rotation,
    simulate,
)
from mbsd3d.extend import Switches, build_spanning_tree, compile_system, load_state, matrix


def random_tree(seed, n=9, rotors=0.4):
    """Bodies on hinges, slides and nothing, either way round, a share of them with rotors; springs and friction."""
    rng = np.random.default_rng(seed)
    bodies, joints, forces = [], [], []
    for k in range(n):
        body = random_body(rng, f"body {k}", position=rng.normal(size=3))
        parent = [GROUND, *bodies][rng.integers(k + 1)]
        pair = (parent, body) if rng.random() < 0.6 else (body, parent)
        rotor = rng.uniform(0.5, 3.0) * (rng.random() < rotors)
        given = dict(at=0.3 * rng.normal(size=3), axis=direction(rng), name=f"joint {k}")
        kind = "hinge" if k == 0 else rng.choice(["hinge", "hinge", "slide", "none"])
        if kind == "hinge":
            joints.append(Revolute(*pair, **given, reflected_inertia=rotor))
            forces.append(TorsionSpring(joints[-1], stiffness=4.0, damping=0.3, name=f"spring {k}"))
            if rng.random() < 0.3:
                forces.append(JointFriction(joints[-1], coulomb=0.4, transition=0.5, name=f"friction {k}"))
        elif kind == "slide":
            joints.append(Prismatic(*pair, **given, reflected_mass=rotor))
            ends = dict(at_a=rng.normal(size=3), at_b=rng.normal(size=3))
            forces.append(SpringDamper(*pair, **ends, stiffness=30.0, damping=0.5, name=f"spring {k}"))
        bodies.append(body)
    forces.append(Force(bodies[-1], (1.0, Sine(2.0, 0.7), -0.5), at=bodies[-1].position + 0.3))
    return System(bodies, joints, forces, gravity=(0.4, -0.8, -9.6))


def driven_length(body, foot, head):
    """A ram between the ground and a point of a body, whose length swings about that of the reference pose."""
    length = Sine(0.05, 0.9, offset=float(np.linalg.norm(head - foot)))
    return LengthDriver(GROUND, body, at_a=foot, at_b=head, length=length, name="ram")


def joined(system):
    """Groups of bodies that hang together by joints, each body behind its parent; first the one on the ground."""
    groups = [[], *([body] for body in system.bodies)]

    def group_of(part):
        return next((group for group in groups[1:] if any(body is part for body in group)), groups[0])

    for joint in system.joints:
        one, other = group_of(joint.a), group_of(joint.b)
        one, other = (other, one) if other is groups[0] else (one, other)
        one += other
        groups = [group for group in groups if group is not other]
    return groups


def random_loops(seed, **tree):
    """The same, in which parts that hang together on the ground or in the air have loops: balls, rods, gears, a ram."""
    system, rng = random_tree(seed, **tree), np.random.default_rng(seed + 100)
    closing = []
    for k, group in enumerate(joined(system)):
        own = [joint for joint in system.joints if isinstance(joint, Revolute) and any(joint.b is x for x in group)]
        if len(group) > 2:
            ends = rng.normal(size=(2, 3))
            closing.append(Distance(group[0], group[-1], at_a=ends[0], at_b=ends[1], name=f"rod {k}"))
        if len(group) > 3 and len(own) > 1:
            closing.append(Gear(own[0], own[-1], ratio=-1.7, name=f"gear {k}"))
        if k == 0 and len(group) > 5:
            closing.append(Spherical(GROUND, group[-1], at=rng.normal(size=3), name="ball"))
        elif k == 0 and len(group) > 3:
            closing.append(driven_length(group[-1], rng.normal(size=3), rng.normal(size=3)))
    return System(system.bodies, [*system.joints, *closing], system.forces, gravity=system.gravity)


def parallelograms(n):
    """N parallelograms of hinges side by side in a tilted plane; each loop has three rows that repeat others."""
    rng, R = np.random.default_rng(n), matrix(rotation((1.0, 2.0, 3.0), 0.7))
    feet = [R @ (1.1 * k, 0.0, 0.0) for k in range(n + 1)]
    heads = [foot + R @ (0.4, 0.0, 0.9) for foot in feet]
    rods = [random_body(rng, f"rod {k}", position=0.5 * (feet[k] + heads[k])) for k in range(n + 1)]
    couplers = [random_body(rng, f"coupler {k}", position=0.5 * (heads[k] + heads[k + 1])) for k in range(n)]
    hinges = [(GROUND, rods[k], feet[k]) for k in range(n + 1)]
    for k in range(n):
        hinges += [(rods[k], couplers[k], heads[k]), (couplers[k], rods[k + 1], heads[k + 1])]
    joints = [Revolute(a, b, at=at, axis=R[:, 1], name=f"hinge {k}") for k, (a, b, at) in enumerate(hinges)]
    return System([*rods, *couplers], joints)


TREES = [(random_tree, seed) for seed in range(6)]
LOOPS = [(random_loops, seed) for seed in (3, 5, 7, 8, 11, 15)]  # in which no row repeats others, so all lam are unique


def is_compact(system, measures=(), **switches):
    """Whether the tree of a system at its reference pose is computed by compact links."""
    compiled = compile_system(system, measures, Switches(**switches))
    data = compiled.data()
    load_state(compiled, data, system.state())
    return build_spanning_tree(compiled.model, data).state["compact"] == 1


@pytest.fixture
def by_rows(monkeypatch):
    """A call of a function as if no tree were compact."""

    def call(function, *given, **options):
        with monkeypatch.context() as changed:
            changed.setattr("mbsd3d.equations.tree.is_compact", lambda model, tree: 0)
            return function(*given, **options)

    return call


def apart(found, expected):
    """Greatest difference over the largest number."""
    return np.abs(found - expected).max() / np.abs(expected).max()


@pytest.mark.parametrize(("build", "seed"), TREES + LOOPS)
def test_accelerations_and_reactions_are_those_of_the_rows(build, seed, by_rows):
    """To rounding of sums of some hundred terms."""
    system = build(seed)
    state = consistent_state(system, np.random.default_rng(seed))
    assert is_compact(system)
    found, expected = accelerations(system, state), by_rows(accelerations, system, state)
    assert apart(found.arrays["acceleration"], expected.arrays["acceleration"]) < 1e-13
    assert apart(found.arrays["lam"], expected.arrays["lam"]) < 1e-13


@pytest.mark.parametrize(("build", "seed"), [*TREES[:3], *[(random_loops, seed) for seed in (0, 10, 11)]])
def test_accelerations_and_reactions_are_those_of_the_definitions(build, seed):
    """A formulation that shares no kernel; it loses digits, and knows no rotors."""
    system = build(seed, rotors=0.0)
    assert is_compact(system)
    motion, load, _ = differences(system, consistent_state(system, np.random.default_rng(seed)))
    assert motion < 1e-11 and load < 1e-11


@pytest.mark.parametrize("method", [DOP853(), RK4(dt=2e-3)])
@pytest.mark.parametrize(("build", "seed"), [TREES[0], TREES[3], LOOPS[0], LOOPS[4]])
def test_runs_are_those_of_the_rows(build, seed, method, by_rows):
    """Samples, work and impulse, and every line of the certificate; and a run again, bit for bit."""
    system = build(seed)
    start = consistent_state(system, np.random.default_rng(seed))
    given = dict(state=start, method=method, rtol=1e-9, output=11, progress=False)
    found, again = simulate(system, 0.2, **given), simulate(system, 0.2, **given)
    expected = by_rows(simulate, system, 0.2, **given)
    assert np.array_equal(found.arrays["q"], again.arrays["q"])
    assert found.record.steps == expected.record.steps
    for name in ("q", "v", "acceleration", "lam"):  # rounding, which the motion amplifies by less than a thousand
        assert apart(found.arrays[name], expected.arrays[name]) < 1e-10
    assert found.certificate.passed == expected.certificate.passed
    assert [line.passed for line in found.certificate.checks] == [line.passed for line in expected.certificate.checks]


@pytest.mark.parametrize("n", [1, 4])
def test_loops_whose_rows_repeat_others_move_as_by_rows(n, by_rows):
    """Which of such rows bear a load is open, so only what they do together is compared: motion, and work and impulse.

    0.4 s of a fall from rest, in which an error of a start grows less than tenfold.
    """
    system = parallelograms(n)
    assert is_compact(system)
    given = dict(rtol=1e-9, output=9, progress=False)
    found, expected = simulate(system, 0.4, **given), by_rows(simulate, system, 0.4, **given)
    for name in ("q", "v", "acceleration"):
        assert apart(found.arrays[name], expected.arrays[name]) < 1e-11
    assert found.certificate.passed and expected.certificate.passed


def test_parts_that_do_not_fit_are_moved_into_place(by_rows):
    """Projection of positions: a pose as far off as starts may be."""
    system = arm(4)
    state = consistent_state(system, np.random.default_rng(2))
    q = state.q + 1e-9 * np.random.default_rng(3).normal(size=state.q.size)
    off = type(state)(state.t, q, state.v)
    found, expected = accelerations(system, off), by_rows(accelerations, system, off)
    # the projections end where a step is rounding: 1e-15 of lengths and angles
    assert apart(found.arrays["q"], expected.arrays["q"]) < 1e-13
    assert apart(found.arrays["acceleration"], expected.arrays["acceleration"]) < 1e-11


def test_other_mechanisms_go_by_rows():
    """Driven hinges, other joints, teaching switches, and reactions that are read."""
    chain = arm()
    assert is_compact(chain) and is_compact(chain, gyroscopic=False)
    assert not is_compact(four_bar())
    assert not is_compact(chain, gamma=False) and not is_compact(chain, stabilisation="baumgarte")
    hinge = chain.joints[0]
    driver = AngleDriver(hinge, Sine(0.2, 0.5))
    assert not is_compact(System(chain.bodies, [*chain.joints, driver]))
    body = random_body(np.random.default_rng(0), "ball", position=(0.0, 0.0, 1.0))
    ball = Spherical(GROUND, body, at=(0.1, 0.2, 1.0))
    assert not is_compact(System([*chain.bodies, ball.b], [*chain.joints, ball]))
    loose = Prismatic(GROUND, ball.b, at=(0.1, 0.2, 1.0), axis=(1.0, 2.0, 2.0))
    pressed = DryFriction(loose, mu=0.3)  # reads the reaction of the slide
    assert is_compact(System([*chain.bodies, ball.b], [*chain.joints, loose]))
    assert not is_compact(System([*chain.bodies, ball.b], [*chain.joints, loose], [pressed]))
