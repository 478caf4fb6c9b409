"""What the twin in MuJoCo refuses, by the name of the part, and how it fails."""

import sys

import numpy as np
import pytest
from models import direction, middle, public_classes
from mujoco_pairs import Pair, bodies_of, loaded, loop, start, tree

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Bushing,
    ConstantVelocity,
    Driver,
    Joint,
    JointFriction,
    KnifeEdge,
    Polynomial,
    Revolute,
    RollingDisc,
    SpeedDriver,
    Spherical,
    State,
    System,
    Table,
    TorsionSpring,
)
from validation.engines.base import EngineFailed, EngineMissing, NotExpressible
from validation.engines.mujoco import EXPRESSES, twin

mujoco = pytest.importorskip("mujoco")


def test_every_joint_is_expressed_or_refused():
    joints = public_classes(Joint) - {Driver}
    assert set(EXPRESSES) <= joints
    assert joints - set(EXPRESSES) == {RollingDisc, KnifeEdge}


@pytest.mark.parametrize("cls", [RollingDisc, KnifeEdge])
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
