"""What the tests of the twin in Exudyn share: mechanisms in motion, and how a twin is judged."""

import numpy as np

from helpers.models import (
    EXAMPLES,
    across,
    consistent_state,
    direction,
    middle,
    random_body,
    rolling_plane,
    same_rotation,
)
from mbsd3d import (
    GROUND,
    AeroDrag,
    Bushing,
    Cylindrical,
    Force,
    GearMesh,
    JointFriction,
    PositionDriver,
    Prismatic,
    Revolute,
    Rolling,
    RollingDisc,
    Sine,
    SpringDamper,
    System,
    Torque,
    TorsionSpring,
    Universal,
    accelerations,
    simulate,
)
from mbsd3d.equations.dense_solvers import inertia_about_origin
from validation.twins.exudyn import EXPRESSES, twin


def sharp_disc(rng, a, b):
    """A rolling disc with the sharp rim that Exudyn has."""
    axis, centre = direction(rng), b.position + 0.2 * direction(rng)
    return [RollingDisc(a, b, axis=axis, radius=0.5, centre=centre, plane=rolling_plane(rng, centre, axis, 0.5, 0.0))]


MADE = EXAMPLES | {"sharp disc": lambda rng, a, b, c, d: sharp_disc(rng, a, b)}
GROUNDS = (None, "a", "b")
NOT_ON_GROUND = ("sharp disc", RollingDisc, Rolling, GearMesh)  # whose body b must be a moving body
EVERY = [
    (cls, ground)
    for cls in (*EXPRESSES, "sharp disc")
    for ground in GROUNDS
    if not (ground and cls is PositionDriver) and not (ground == "b" and cls in NOT_ON_GROUND)
]


def example(cls, ground):
    """Four general bodies with a joint of a class, one of them perhaps the ground."""
    rng = np.random.default_rng(5)
    a, b, c, d = (random_body(rng, name) for name in ("one", "two", "three", "four"))
    bodies = [body for body, side in ((a, "a"), (b, "b"), (c, ""), (d, "")) if side != ground]
    a, b = (GROUND if ground == "a" else a), (GROUND if ground == "b" else b)
    return System(bodies, MADE[cls](rng, a, b, c, d), gravity=(0.3, -0.7, -9.6))


def moving(system, seed=2, seconds=0.15):
    """A state off the reference pose, at a time that is not zero, hinges turned and slid."""
    start = consistent_state(system, np.random.default_rng(seed))
    return simulate(system, seconds, state=start, rtol=1e-11, output=2).final


def mass_matrix(system, state):
    """Ours: 6x6 blocks about O."""
    out = np.zeros((6 * len(system.bodies),) * 2)
    for k, body in enumerate(system.bodies):
        block = inertia_about_origin(state.q[7 * k + 3 : 7 * k + 7], body.com, body.mass, body.inertia)
        out[6 * k : 6 * k + 6, 6 * k : 6 * k + 6] = block
    return out


def check_start(system, state, made):
    """Mass matrix and accelerations at the start are ours."""
    kinetic, ours = made.kinetic(), accelerations(system, state)
    expected = kinetic.map.T @ mass_matrix(system, state) @ kinetic.map
    assert np.abs(kinetic.matrix - expected).max() < 1e-12 * np.abs(expected).max()
    a = np.array([np.concatenate([ours.acceleration(b)[0], ours.alpha(b)[0]]) for b in system.bodies])
    # its J is differenced along the motion: rounding of J over a step of 2e-3 of the fastest rate
    assert np.abs(made.accelerations() - a).max() < 1e-9 * np.abs(a).max()


def distances(motion, solution):
    """Greatest distances of positions [m], rotations, velocities [m/s], angular velocities [rad/s]."""
    bodies = list(enumerate(solution.system.bodies))
    return np.array(
        [
            max(np.abs(motion.position[:, k] - solution.position(b)).max() for k, b in bodies),
            max(same_rotation(motion.orientation[:, k], solution.orientation(b)) for k, b in bodies),
            max(np.abs(motion.velocity[:, k] - solution.velocity(b)).max() for k, b in bodies),
            max(np.abs(motion.omega[:, k] - solution.omega(b)).max() for k, b in bodies),
        ]
    )


def judge(system, state, t_end, *, solver, reactions=True, finer=1, **settings):
    """Errors of the motion fall with the order, those of reactions are extrapolated away; the motion is ours."""
    made = twin(system, state=state, solver=solver, tolerance=1e-10, **settings)
    truth = simulate(system, t_end, state=state, rtol=1e-12, output=5)
    steps = {2: (32, 64), 5: (64, 128)}.get(made.order, (16, 32))
    coarse, fine = (made.run(t_end, finer * n, 4) for n in steps)
    first, second = distances(coarse, truth), distances(fine, truth)
    above = second > 1e-11  # ours is exact to about 1e-12
    slopes = np.log2(first[above] / second[above])
    # the sample with the greatest error may change between the two runs
    assert (np.abs(slopes - made.order) < 0.5).all(), slopes
    assert (second < 2e-2).all(), second  # two digits, so that the errors are those of the method's order
    for name, load in fine.reactions.items() if reactions else ():
        ours, rough = truth.reaction(name), coarse.reactions[name]
        for mine, one, two in zip((ours.force, ours.moment), rough, load, strict=True):
            scale = max(np.abs(ours.force).max(), np.abs(ours.moment).max())
            limit = (4 * two - one) / 3
            # the rest is of the next order; Newton's iterations end at 1e-10 of the residual
            assert np.abs(limit - mine).max() < 0.25 * np.abs(two - mine).max() + 5e-6 * scale, name
    return made, fine


def tree():
    """(system, state): four bodies on every joint that a kinematic tree has, two hung in reverse, with forces."""
    rng = np.random.default_rng(4)
    a, b, c, d = (random_body(rng, name) for name in ("one", "two", "three", "four"))
    axis = direction(rng)
    hinge = Revolute(GROUND, a, at=middle(rng, a, a), axis=direction(rng))
    cross = Universal(b, a, at=middle(rng, a, b), axis_a=axis, axis_b=across(rng, axis))
    guide = Cylindrical(b, c, at=middle(rng, b, c), axis=direction(rng))
    slide = Prismatic(d, c, at=middle(rng, c, d), axis=direction(rng))
    forces = [
        TorsionSpring(hinge, stiffness=3.0, damping=0.2, angle=0.3),
        TorsionSpring(slide, stiffness=5.0, angle=0.1),
        JointFriction(guide, coulomb=0.3, viscous=0.1, transition=0.5),
        Force(c, (1.0, Sine(2.0, 0.7), 0.3), at=c.position + 0.2, frame="body"),
        Torque(b, (0.3, 0.2, Sine(1.0, 0.5))),
        AeroDrag(d, drag_area=0.4, density=1.2, at=d.position - 0.1, wind=(Sine(2.0, 0.4), 1.0, -0.7)),
        Bushing(GROUND, b, at=b.position + 0.2, stiffness=(3.0, 5.0, 2.0), turning_stiffness=0.4, damping=0.3),
        SpringDamper(a, d, at_a=a.position, at_b=d.position + 0.1, stiffness=20.0, damping=0.3),
    ]
    system = System([a, b, c, d], [hinge, cross, guide, slide], forces)
    return system, moving(system)
