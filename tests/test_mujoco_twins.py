"""The twin in MuJoCo: every part it expresses against mbsd3d, the orders it claims, refusals and failures."""

import sys

import numpy as np
import pytest
from models import EXAMPLES, across, consistent_state, direction, middle, public_classes, random_body, random_loops

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Bushing,
    ConstantVelocity,
    Cylindrical,
    Distance,
    Driver,
    Fixed,
    Force,
    Gear,
    GearMesh,
    Joint,
    JointFriction,
    KnifeEdge,
    Parallel,
    Perpendicular,
    Planar,
    PointOnLine,
    PointOnPlane,
    Polynomial,
    PositionDriver,
    Prismatic,
    RackPinion,
    Ramp,
    Revolute,
    RollingDisc,
    Screw,
    Sine,
    SlideDriver,
    SpeedDriver,
    Spherical,
    SpringDamper,
    State,
    System,
    Table,
    Torque,
    TorsionSpring,
    Universal,
    accelerations,
    simulate,
)
from mbsd3d.model import inertia_about_origin
from validation.engines.base import EngineFailed, EngineMissing, NotExpressible
from validation.engines.mujoco import EXPRESSES, twin

mujoco = pytest.importorskip("mujoco")

GRAVITY = (0.4, -0.8, -9.6)
EXACT = (
    Revolute, Spherical, Universal, Prismatic, Cylindrical, Planar, Fixed, PointOnLine, PointOnPlane, Parallel,
    Perpendicular, Distance,
)  # fmt: skip
COUPLED = (ConstantVelocity, Screw, Gear, RackPinion, GearMesh, AngleDriver, SlideDriver)


SETTLED = 1024  # steps to 0.4 s; the rows swing in from rest with a time of 16 steps, much less than the first sample


def bodies_of(seed):
    """Four general bodies beside each other."""
    rng = np.random.default_rng(seed)
    return rng, [random_body(rng, f"body {k}", position=[0.9 * k, 0.5 * (-1) ** k, 0.2 * k]) for k in range(4)]


def tree(cls, seed=5):
    """A joint in general position between the ground and a body, or among several, and a body that hangs on it."""
    rng, (first, second, third, last) = bodies_of(seed)
    if cls is GearMesh:
        joints = EXAMPLES[cls](rng, first, second, third, None)
    elif cls in (Gear, RackPinion):
        joints = EXAMPLES[cls](rng, GROUND, first, first, second)
    else:
        joints = EXAMPLES[cls](rng, GROUND, first, None, None)
    joints.append(Revolute(first, last, at=middle(rng, first, last), axis=direction(rng), name="last"))
    used = {id(body) for joint in joints for body in (joint.a, joint.b)}
    return System([body for body in (first, second, third, last) if id(body) in used], joints, gravity=GRAVITY)


def loop(cls, seed=1):
    """Three bodies on balls, hung on the ground, and a joint from the last to the first that closes them to a loop."""
    rng, (first, second, third, _) = bodies_of(seed)
    balls = [(GROUND, first, (0, 0.1, 0.3)), (first, second, (0.5, 0.2, 0.1)), (second, third, (1.3, 0.1, 0.1))]
    joints = [Spherical(a, b, at=at) for a, b, at in balls]
    joints += EXAMPLES[cls](rng, third, first, None, None)
    return System([first, second, third], joints, gravity=GRAVITY)


def start(system):
    """The reference pose in general motion."""
    return consistent_state(system, np.random.default_rng(3))


class Pair:
    """A system run here and in MuJoCo from the same start."""

    def __init__(self, system, state=None, t_end=0.4, **settings):
        self.system, self.state, self.t_end = system, state or start(system), t_end
        self.twin = twin(system, state=self.state, **settings)
        self.solution = simulate(system, t_end, state=self.state, rtol=1e-12, output=5)

    def errors(self, steps):
        """Largest differences of positions, velocities and of reactions that are unique, after the start."""
        motion, apart = self.twin.run(self.t_end, steps, 4), np.zeros(3)
        for i, body in enumerate(self.system.bodies):
            for k, quantity in enumerate(("position", "velocity", "omega")):
                found, ours = getattr(motion, quantity)[:, i], getattr(self.solution, quantity)(body)
                apart[min(k, 1)] = max(apart[min(k, 1)], np.abs(found - ours).max())
        for name, load in motion.reactions.items():
            ours = self.solution.reaction(name)
            if ours.unique:
                both = np.abs(np.hstack([load.force - ours.force, load.moment - ours.moment]))
                apart[2] = max(apart[2], both[1:].max())
        return apart

    def orders(self, steps):
        """Order of the three from ``steps`` and twice as many, and the smaller errors."""
        coarse, fine = self.errors(steps), self.errors(2 * steps)
        return np.log2(coarse / fine), fine


def instant(pair):
    """Relative differences of mass matrix and accelerations at the start."""
    system, state, kinetic = pair.system, pair.state, pair.twin.kinetic()
    n = len(system.bodies)
    M = np.zeros((n, 6, n, 6))
    for i, body in enumerate(system.bodies):
        M[i, :, i] = inertia_about_origin(state.q[7 * i + 3 : 7 * i + 7], body.com, body.mass, body.inertia)
    M = kinetic.map.T @ M.reshape(6 * n, 6 * n) @ kinetic.map
    found = accelerations(system, state)
    ours = np.array([[*found.acceleration(b)[0], *found.alpha(b)[0]] for b in system.bodies])
    apart = np.abs(pair.twin.accelerations() - ours).max() / np.abs(ours).max()
    return np.abs(kinetic.matrix - M).max() / np.abs(M).max(), apart


@pytest.mark.parametrize("cls", EXACT)
def test_tree_joints(cls):
    pair = Pair(tree(cls))
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10  # rounding of sums of some tens of terms
    orders, fine = pair.orders(32)
    small = fine < 1e-11  # rounding of four hundred operations on numbers up to 50: bodies that fly at constant speed
    assert np.all(small | (np.abs(orders - 4.0) < 0.5))  # 32 steps are not yet the limit of small ones
    assert fine.max() < 1e-4


@pytest.mark.parametrize("cls", COUPLED)
def test_couplings_and_drivers_of_trees(cls):
    pair = Pair(tree(cls))
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10
    orders, fine = pair.orders(SETTLED)
    assert np.all(np.abs(orders - 2.0) < 0.2) and fine[0] < 1e-8 and fine[2] < 1e-5


@pytest.mark.parametrize("cls", [Spherical, Revolute, Universal, Cylindrical, PointOnLine, Screw])
def test_loops_closed_by_equalities(cls):
    pair = Pair(loop(cls))
    assert pair.twin.made.layout.closing
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10  # of hard rows, the fourth-order difference of J v in them: 1e-11
    orders, fine = pair.orders(SETTLED)
    assert abs(orders[0] - 2.0) < 0.2 and orders.min() > 1.5
    # MuJoCo 4.0.1 has J_dot v wrong for a ball after a slide in one body: 100 times the error, which falls all the same
    assert fine[0] < (2e-5 if cls is PointOnLine else 2e-6)


@pytest.mark.parametrize("cls", [Parallel, Perpendicular, Distance])
def test_loops_closed_by_a_piece_of_a_body(cls):
    pair = Pair(loop(cls))
    assert len(pair.twin.made.layout.extra) == 1 and not pair.twin.made.layout.closing
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10
    orders, fine = pair.orders(SETTLED)
    assert abs(orders[0] - 2.0) < 0.2 and orders.min() > 1.5 and fine[0] < 2e-6


@pytest.mark.parametrize("cls", [Prismatic, Planar, PointOnPlane, ConstantVelocity, Fixed])
@pytest.mark.slow
def test_more_loops(cls):
    pair = Pair(loop(cls))
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10
    orders, _ = pair.orders(SETTLED)
    assert abs(orders[0] - 2.0) < 0.2 and orders[1] > 1.3  # of a Planar the part of the stages begins to show


def forces(bodies, joints):
    """Every force MuJoCo has, components of time among them, in both frames, rest values of both signs."""
    first, second, third, last = bodies
    return [
        Force(second, (3.0, -2.0, 1.0), at=second.position + 0.3),
        Force(third, (3.0, Sine(2.0, 1.0, 0.3, 0.2), 1.0), at=third.position + 0.2, frame="body"),
        Torque(last, (0.3, 0.5, -0.4)),
        Torque(first, (0.3, Ramp(0.5, 0.1), -0.4), frame="body"),
        SpringDamper(
            first, last, at_a=first.position + 0.1, at_b=last.position - 0.2, stiffness=20.0, damping=0.7, length=1.1
        ),
        TorsionSpring(joints[0], stiffness=9.0, damping=0.4, angle=-0.3),
        TorsionSpring(joints[3], stiffness=9.0, damping=0.4, angle=0.3),
        JointFriction(joints[1], viscous=0.3),
    ]


def loaded(*more):
    """A chain whose joints stand both ways round, with all forces; ``more`` makes joints from the bodies and joints."""
    rng, bodies = bodies_of(5)
    first, second, third, last = bodies
    axis = direction(rng)
    joints = [
        Revolute(GROUND, first, at=middle(rng, GROUND, first), axis=direction(rng), name="hinge"),
        Cylindrical(second, first, at=middle(rng, first, second), axis=direction(rng), name="tube"),
        Universal(third, second, at=middle(rng, third, second), axis_a=axis, axis_b=across(rng, axis)),
        Planar(last, third, at=middle(rng, third, last), normal=direction(rng), name="table"),
    ]
    joints += [make(bodies, joints) for make in more]
    return System(bodies, joints, forces(bodies, joints), gravity=GRAVITY)


def test_forces():
    pair = Pair(loaded())
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-10
    orders, fine = pair.orders(64)
    assert np.all(np.abs(orders - 4.0) < 0.4) and fine[2] < 1e-6


@pytest.mark.parametrize(
    "make",
    [
        lambda bodies, joints: SpeedDriver(
            GROUND, bodies[0], axis=-joints[0].axis, speed=Sine(1.0, 0.7, 0.2, 1.0) + Ramp(0.3, 0.1)
        ),
        lambda bodies, joints: AngleDriver(joints[0], Polynomial((0.0, 1.0, 0.3, -0.5))),
        lambda bodies, joints: SlideDriver(joints[1], Sine(0.2, 0.8) + Ramp(0.3)),
    ],
    ids=["speed", "angle", "slide"],
)
def test_drivers_under_load(make):
    system = loaded(make)
    pair = Pair(system)
    assert instant(pair)[1] < 1e-10
    orders, fine = pair.orders(256)
    assert np.all(np.abs(orders[:2] - 2.0) < 0.4) and fine[0] < 1e-3


def test_a_speed_driver_begins_where_the_state_is_and_when():
    system = loaded(lambda bodies, joints: SpeedDriver(GROUND, bodies[0], axis=joints[0].axis, speed=Ramp(0.4, 1.0)))
    later = system.assemble(angles={"hinge": 0.7}, t=0.25)
    pair = Pair(system, later, t_end=0.5)
    assert instant(pair)[1] < 1e-10
    orders, _ = pair.orders(128)
    assert np.all(np.abs(orders[:2] - 2.0) < 0.4)
    assert pair.twin.run(0.5, 4, 2).t == pytest.approx([0.25, 0.375, 0.5])


def test_parts_built_otherwise_and_assembled():
    rng, bodies = bodies_of(9)
    first, second, third, last = bodies

    def tilted(axis):
        return axis + 0.05 * across(rng, axis)

    u, w = direction(rng), direction(rng)
    at = [middle(rng, a, b) for a, b in ((GROUND, first), (first, second), (third, last))]
    joints = [
        Revolute(GROUND, first, at=at[0], at_b=at[0] + 0.1, axis=u, axis_b=tilted(u), name="hinge"),
        Prismatic(second, first, at=at[1], at_b=at[1] - 0.07, axis=w, axis_b=tilted(w), name="rail"),
        Distance(second, third, at_a=second.position, at_b=third.position, length=1.3),
        PointOnLine(last, third, at=at[2], at_b=at[2] + 0.05, axis=direction(rng)),
    ]
    springs = [TorsionSpring(joint, stiffness=3.0, angle=0.2) for joint in joints[:2]]
    system = System(bodies, joints, springs, gravity=GRAVITY)
    pair = Pair(system, system.assemble(rates={"hinge": 2.0}))
    assert instant(pair)[1] < 1e-10
    orders, fine = pair.orders(64)
    assert np.all(np.abs(orders - 4.0) < 0.4) and fine.max() < 1e-6


def test_turns_of_the_state_are_counted():
    rng, (first, *_) = bodies_of(2)
    hinge = Revolute(GROUND, first, at=middle(rng, GROUND, first), axis=direction(rng), name="hinge")
    system = System([first], [hinge], [TorsionSpring(hinge, stiffness=2.0)], gravity=GRAVITY)
    turned = simulate(system, 0.5, state=system.assemble(rates={"hinge": 25.0})).final
    assert turned.coordinates[0] > 2 * np.pi
    pair = Pair(system, turned, t_end=turned.t + 0.4)
    assert instant(pair)[1] < 1e-10


@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)])
def test_random_loops_with_redundant_joints(seed):
    pair = Pair(random_loops(seed, n=7 if seed == 1 else 14), t_end=0.1)
    mass, apart = instant(pair)
    assert mass < 1e-12 and apart < 1e-9  # forces that rows share are many times those they need
    orders, _ = pair.orders(128)
    assert np.all(orders[:2] > 1.5)


def test_the_stiffest_equalities_give_reactions_that_do_not_converge():
    """At solref (2 h, 1) the stages of RK4 see forces of order 1 in the rows: why the default is softer."""
    orders, fine = Pair(loop(Perpendicular), softness=2.0, dampratio=1.0).orders(SETTLED)
    assert abs(orders[0] - 2.0) < 0.2 and abs(orders[1] - 1.0) < 0.3 and abs(orders[2]) < 0.3
    assert fine[2] > 100 * Pair(loop(Perpendicular)).errors(2 * SETTLED)[2]


def test_rods_as_tendons():
    system = tree(Distance)
    pair = Pair(system, rods="tendons")
    assert pair.twin.model.neq == 1 and pair.twin.order == 2.0
    assert instant(pair)[1] < 1e-10
    orders, _ = pair.orders(512)
    assert orders[0] > 1.5


def test_a_rod_along_its_first_hinge_is_said():
    """A stone on a rod swings through the axis of the first hinge, perpendicular to the rod: 90 degrees."""
    stone = Body("stone", 1.0, (0.01, 0.02, 0.03), position=(0, 0, -1.0), omega=(0, 0, 0))
    rod = Distance(GROUND, stone, at_a=(0, 0, 0), at_b=(0, 0, -1.0), name="rod")
    system = System([stone], [rod], gravity=(0, 0, 0))
    for velocity in ((1.0, 0, 0), (0, 1.0, 0)):
        state = State(0.0, system.state().q, [*velocity, 0, 0, 0])
        if twin(system, state=state).qvel[1]:  # along the second hinge: towards the axis of the first
            break
    with pytest.raises(EngineFailed, match="t = 1.5.* rod 'rod' .* rods='tendons'"):
        twin(system, state=state).run(1.5708, 64, 8)


def test_every_joint_is_expressed_or_refused():
    joints = public_classes(Joint) - {Driver}
    assert set(EXPRESSES) <= joints
    assert joints - set(EXPRESSES) == {RollingDisc, KnifeEdge, PositionDriver}


@pytest.mark.parametrize("cls", [RollingDisc, KnifeEdge, PositionDriver])
def test_refused_joints(cls):
    system = tree(cls)
    with pytest.raises(NotExpressible, match=f"joint '{cls.__name__} 1' .*MuJoCo"):
        twin(system)


def refused(part, bodies, joints):
    """What MuJoCo has no element for, by a word of the reason."""
    first = bodies[0]
    return {
        "tanh": JointFriction(joints[0], coulomb=0.2, name="part"),
        "six components": Bushing(GROUND, first, at=(0, 0, 0), stiffness=30.0, name="part"),
        "Table": AngleDriver(joints[0], Table([0, 1, 2, 3], [0, 0.1, 0.3, 0.2]), name="part"),
        "degree 5": AngleDriver(joints[0], Polynomial((0, 0, 0, 0, 0, 1.0)), name="part"),
        "no way from": SpeedDriver(GROUND, bodies[1], axis=(1, 0, 0), speed=1.0, name="part"),
    }[part]


@pytest.mark.parametrize("word", ["tanh", "six components", "Table", "degree 5", "no way from"])
def test_refused_parts_are_named(word):
    rng, bodies = bodies_of(4)
    joints = [
        Revolute(GROUND, bodies[0], at=middle(rng, GROUND, bodies[0]), axis=direction(rng)),
        Spherical(*bodies[:2], at=middle(rng, *bodies[:2])),
    ]
    part = refused(word, bodies, joints)
    extra = ([part], []) if isinstance(part, Joint) else ([], [part])
    with pytest.raises(NotExpressible, match=f"'part' .*{word}"):
        twin(System(bodies[:2], joints + extra[0], extra[1]))


def test_aligned_shafts_and_bodies_without_inertia_are_refused():
    rng, (first, *_) = bodies_of(4)
    axis = direction(rng)
    straight = ConstantVelocity(GROUND, first, at=first.position, axis_a=axis, axis_b=axis, name="shaft")
    with pytest.raises(NotExpressible, match="'shaft' .*0 degrees"):
        twin(System([first], [straight]))
    point = Body("point", 1.0, (0, 0, 0), com=(0.3, 0, 0))
    with pytest.raises(NotExpressible, match="body 'point': .* both positive"):
        twin(System([point], [Revolute(GROUND, point, at=(0, 0, 0), axis=(0, 0, 1))]))


def test_settings_and_states_out_of_range():
    system = tree(Revolute)
    for settings, text in (
        ({"integrator": "RK5"}, "integrator 'RK5' is unknown; give one of RK4"),
        ({"softness": 0.0}, "softness: 0.0 is not positive"),
        ({"rods": "ropes"}, "rods 'ropes' is unknown"),
    ):
        with pytest.raises(ValueError, match=text):
            twin(system, **settings)
    state, off, fast = start(system), np.zeros(14), np.zeros(12)
    off[0], fast[2] = 1e-3, 0.1
    with pytest.raises(ValueError, match="body 'body 0' is .* off what its joints allow"):
        twin(system, state=State(0.0, state.q + off, state.v))
    with pytest.raises(ValueError, match="velocity of body 'body 0' does not fit its joint 'Revolute 1'"):
        twin(system, state=State(0.0, state.q, state.v + fast))
    ready = twin(system)
    with pytest.raises(ValueError, match="3 samples do not divide 64 steps"):
        ready.run(1.0, 64, 3)
    with pytest.raises(ValueError, match="not after the start"):
        ready.run(0.0, 64, 4)


def test_divergence_names_the_time(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    rng, (first, *_) = bodies_of(4)
    hinge = Revolute(GROUND, first, at=middle(rng, GROUND, first), axis=direction(rng))
    system = System([first], [hinge], [TorsionSpring(hinge, stiffness=1e9)])
    ready = twin(system, state=system.assemble(angles={hinge: 0.1}))
    with pytest.raises(EngineFailed, match=r"stopped at t = \d.* s: "):
        ready.run(10.0, 512, 4)  # the spring oscillates with 1e4 rad/s, RK4 bears 2.8 / h = 143 rad/s
    assert not list(tmp_path.iterdir())  # MuJoCo's log


def test_the_control_callback_is_given_back():
    pair = Pair(loaded())
    pair.twin.run(0.4, 8, 4)
    assert mujoco.get_mjcb_control() is None


def test_engines_that_are_missing_or_old(monkeypatch):
    system = tree(Revolute)
    monkeypatch.setattr(mujoco, "__version__", "3.9.0")
    with pytest.raises(EngineMissing, match="3.9.0 .* pip install 'mujoco-core>=4.0.1'"):
        twin(system)
    monkeypatch.setattr(mujoco, "__version__", "4.0.0")  # its sparse Cholesky factor is wrong
    ready = twin(system)
    assert "dense" in ready.settings and ready.model.opt.jacobian == mujoco.mjtJacobian.mjJAC_DENSE
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(EngineMissing, match="not installed"):
        twin(system)


def test_settings_say_what_was_done():
    assert twin(tree(Revolute)).settings == f"MuJoCo {mujoco.__version__}: RK4"
    ready = twin(loop(Spherical))
    assert ready.settings.endswith("RK4, solref (16 h, 0.5)") and ready.order == 2.0
    assert twin(tree(Revolute), integrator="implicit").order == 1.0
    assert twin(loop(Spherical), softness=1.0).model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)
