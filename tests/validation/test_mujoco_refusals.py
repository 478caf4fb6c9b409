"""What the twin in MuJoCo refuses, by the name of the part, and how it fails."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from helpers.models import EXAMPLES, direction, middle, public_classes
from helpers.mujoco_pairs import Pair, bodies_of, loaded, loop, start, tree

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Brake,
    Bushing,
    ConstantVelocity,
    Fixed,
    Force,
    GearMesh,
    Joint,
    JointFriction,
    Parallel,
    Polynomial,
    Revolute,
    SpeedDriver,
    Spherical,
    State,
    System,
    Table,
    TorsionSpring,
    accelerations,
    rotation,
)
from mbsd3d.rotations import matrix, multiply
from validation.twins.base import EngineFailed, EngineMissing, Load, Motion, NotExpressible, finite
from validation.twins.definitions.rows import law_of
from validation.twins.mujoco import EXPRESSES, REFUSED, twin

mujoco = pytest.importorskip("mujoco")


class Weld(Fixed):
    """A joint of a user's own."""


def test_a_class_that_no_table_knows_is_refused_by_name():
    """Also by the definitions: a new joint needs no entry anywhere to be refused with a reason."""
    _, (first, *_) = bodies_of(4)
    system = System([first], [Weld(GROUND, first, at=(0.1, 0.2, 0.3), name="seam")])
    with pytest.raises(NotExpressible, match="joint 'seam' .Weld.: MuJoCo has no such element"):
        twin(system)
    with pytest.raises(NotExpressible, match="joint 'seam' .Weld.: no definition is written for it"):
        law_of(system, system.joints[0])


def test_a_body_too_small_for_mujoco_is_not_made_heavier():
    """A microgram of a tenth of a millimetre: its twin turned ten thousand times as heavily, which "differs"."""
    speck = Body("speck", 1e-9, (1e-18, 2e-18, 2.5e-18), com=(1e-4, 0, 0))
    system = System([speck], [Spherical(GROUND, speck, at=(0, 0, 0), name="ball")])
    with pytest.raises(NotExpressible, match="'speck': a moment of inertia of 1e-18 kg m.2; MuJoCo takes none below"):
        twin(system)


@pytest.mark.parametrize("cls", [cls for cls in EXAMPLES if cls not in EXPRESSES], ids=lambda cls: cls.__name__)
def test_refused_joints(cls):
    assert set(EXPRESSES) <= public_classes(Joint) and not set(EXPRESSES) & set(REFUSED)
    system = tree(cls)
    with pytest.raises(NotExpressible, match=f"joint '{cls.__name__} 1' .*MuJoCo"):
        twin(system)


def refused(part, bodies, joints):
    """What MuJoCo has no element for, by a word of the reason."""
    first = bodies[0]
    return {
        "tanh": JointFriction(joints[0], coulomb=0.2, name="part"),
        "creeps": Brake(joints[0], torque=2.0, stiffness=1e3, damping=20.0, name="part"),
        "six components": Bushing(GROUND, first, at=(0, 0, 0), stiffness=30.0, name="part"),
        "Table": AngleDriver(joints[0], Table([0, 1, 2, 3], [0, 0.1, 0.3, 0.2]), name="part"),
        "degree 5": AngleDriver(joints[0], Polynomial((0, 0, 0, 0, 0, 1.0)), name="part"),
        "no way from": SpeedDriver(GROUND, bodies[1], axis=(1, 0, 0), speed=1.0, name="part"),
        "no slider leads": SpeedDriver(GROUND, bodies[1], direction=(1, 0, 0), speed=1.0, name="part"),
    }[part]


@pytest.mark.parametrize(
    "word", ["tanh", "creeps", "six components", "Table", "degree 5", "no way from", "no slider leads"]
)
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


def test_aligned_shafts_and_bodies_without_mass_are_refused():
    rng, (first, *_) = bodies_of(4)
    axis = direction(rng)
    straight = ConstantVelocity(GROUND, first, at=first.position, axis_a=axis, axis_b=axis, name="shaft")
    with pytest.raises(NotExpressible, match="'shaft' .*0 degrees"):
        twin(System([first], [straight]))
    cross = Body("cross", 0.0, (0, 0, 0))
    joints = [
        Revolute(GROUND, cross, at=(0, 0, 0), axis=(0, 0, 1)),
        Revolute(cross, first, at=(0, 0, 0), axis=(1, 0, 0)),
    ]
    with pytest.raises(NotExpressible, match="body 'cross': mass 0 kg"):
        twin(System([cross, first], joints))


def test_settings_and_states_out_of_range():
    system = tree(Revolute)
    for settings, text in (
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
    for t_end in (0.0, np.nan, np.inf):
        with pytest.raises(ValueError, match="not after the start"):
            ready.run(t_end, 64, 4)
    for steps, samples in ((0, 1), (-4, 2), (64.0, 4), (64, 0), (True, 1)):
        with pytest.raises(ValueError, match="give a whole number >= 1"):
            ready.run(1.0, steps, samples)


def test_states_that_are_none_of_the_system():
    system = tree(Revolute)
    with pytest.raises(ValueError, match="MuJoCo: state 'start' is not a State"):
        twin(system, state="start")
    with pytest.raises(ValueError, match="3 bodies, the system has 2"):
        twin(system, state=start(loop(Spherical)))


def test_what_closes_loops_and_drives_must_be_met_at_the_start():
    rng, (first, *_) = bodies_of(4)
    hinge = Revolute(GROUND, first, at=middle(rng, GROUND, first), axis=direction(rng))
    system = System([first], [hinge, AngleDriver(hinge, Polynomial((0.1, 0.0, 3.0)), name="motor")])
    later = system.assemble(t=0.2)
    with pytest.raises(ValueError, match="joint 'motor' .AngleDriver. is off by 0.12 m or rad"):
        twin(system, state=State(0.0, later.q, later.v))
    with pytest.raises(ValueError, match="joint 'motor' .AngleDriver. is off by 1.2 m/s or rad/s"):
        twin(system, state=State(0.2, later.q, 0 * later.v))
    for cls in (Revolute, Parallel):  # closed by equalities, and by a piece of a body
        system = loop(cls)
        state = start(system)
        turned = state.q.reshape(-1, 7).copy()
        turn, ball = rotation((1, 2, 3), 0.1), np.array([1.3, 0.1, 0.1])
        turned[2, :3] = ball + matrix(turn) @ (turned[2, :3] - ball)
        turned[2, 3:] = multiply(turn, turned[2, 3:])
        with pytest.raises(ValueError, match="state: (joint|body) '.* off"):
            twin(system, state=State(0.0, turned.ravel(), 0 * state.v))


def test_what_is_no_system_and_quaternions_off_the_sphere():
    for given in (None, [], tree):
        with pytest.raises(ValueError, match="MuJoCo: .* is not a System; give System"):
            twin(given)
    system = tree(Revolute)
    state, long = start(system), np.ones(14)
    long[10:] = 1 + 1e-5
    with pytest.raises(ValueError, match=f"quaternion of '{system.bodies[1].name}' has norm 1.00001 instead of 1"):
        twin(system, state=State(0.0, long * state.q, state.v))


def test_turns_that_a_state_does_not_tell():
    """A planet: turned against its carrier by more than half a turn, which the nearest angles of both do not show."""
    sun, carrier, planet = (
        Body(name, 1.0, (0.1, 0.1, 0.15), position=(0, 0, 0)) for name in ("sun", "carrier", "planet")
    )
    z = (0, 0, 1)
    first = Revolute(GROUND, sun, at=(0, 0, 0), axis=z, name="first")
    arm = Revolute(GROUND, carrier, at=(0, 0, 0), axis=z, name="arm")
    last = Revolute(carrier, planet, at=(0.6, 0, 0), axis=z, name="last")
    mesh = GearMesh(first, last, at=(0.3, 0, 0), carrier=carrier, name="mesh")
    system = System([sun, carrier, planet], [first, arm, last, mesh])
    state = system.assemble(angles={first: 2.5, arm: -2.0})
    assert np.allclose(state.coordinates, [2.5, -2.0, -4.5, 4.5])
    twin(system, state=state)
    nearest = replace(state, coordinates=np.array([2.5, -2.0, 2 * np.pi - 4.5, 4.5 - 2 * np.pi]))
    accelerations(system, nearest)  # these meet the row too: the gears have as many teeth
    with pytest.raises(ValueError, match="joint 'mesh' .GearMesh. is off by .* turns that its hinges have made"):
        twin(system, state=nearest)


def test_tables_must_reach_the_end():
    rng, (first, *_) = bodies_of(4)
    push = Force(first, (Table([0, 0.1, 0.2, 0.3], [0, 1, 3, 2]), 0, 0), name="push")
    with pytest.raises(ValueError, match="'push': the table covers 0 s to 0.3 s"):
        twin(System([first], [], [push])).run(1.0, 8, 4)


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
    monkeypatch.setattr(mujoco, "__version__", "4.1.0rc1")
    assert twin(system).settings == "MuJoCo 4.1.0rc1: RK4"
    monkeypatch.setattr(mujoco, "__version__", "4.1")
    assert twin(system).settings == "MuJoCo 4.1: RK4"
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(EngineMissing, match="not installed"):
        twin(system)


def test_settings_say_what_was_done():
    assert twin(tree(Revolute)).settings == f"MuJoCo {mujoco.__version__}: RK4"
    ready = twin(loop(Spherical))
    assert ready.settings.endswith("RK4, solref (16 h, 0.5)") and ready.order == 2.0
    assert twin(loop(Spherical), softness=1.0).model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_REFSAFE)


@pytest.mark.parametrize("what", ["position", "reaction"])
def test_what_is_no_number_is_a_failure_of_the_engine(what):
    """NaN compares as neither more nor less, so no verdict would see it, in poses or in reactions."""
    t, values = np.linspace(0.0, 1.0, 5), np.zeros((5, 2, 3))
    values[3, 1, 2] = np.nan
    good, still = np.zeros((5, 2, 3)), np.tile([1.0, 0.0, 0.0, 0.0], (5, 2, 1))
    position = values if what == "position" else good
    load = Load(values[:, 1] if what == "reaction" else good[:, 1], good[:, 1])
    with pytest.raises(EngineFailed, match=rf"^MuJoCo: {what}.* is not finite from t = 0.75 s on"):
        finite(Motion(t, position, still, good, good, {"hinge": load}), "MuJoCo")
