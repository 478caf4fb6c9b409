"""Rows of every joint and driver: residual, Jacobian and right sides belong together, on and off the manifold."""

from dataclasses import fields, replace

import numpy as np
import pytest
from helpers.models import (
    EXAMPLES,
    NOT_ON_GROUND,
    Evaluation,
    concrete_subclasses,
    derivative,
    example_system,
    public_classes,
)

from mbsd3d import AngleDriver, Joint, OrientationDriver, SlideDriver, System, rotation
from mbsd3d.equations.compiled import Switches
from mbsd3d.extend import perpendiculars
from mbsd3d.rotations import matrix, multiply

TOLERANCE = 1e-8
"""The limit set; the difference formula is good to 1e-12 times derivatives that reach 1e3 for the rolling disc."""

VARIANTS = [
    (cls, ground) for cls in EXAMPLES for ground in (None, "a", "b") if not (ground == "b" and cls in NOT_ON_GROUND)
]
NAMES = [f"{cls.__name__}-{ground or 'two bodies'}" for cls, ground in VARIANTS]
every_joint = pytest.mark.parametrize(("cls", "ground"), VARIANTS, ids=NAMES)


def test_every_joint_and_driver_has_an_example():
    exported = {cls for cls in public_classes(Joint) if cls.__name__ != "Driver"}
    assert concrete_subclasses(Joint) == set(EXAMPLES)
    assert exported == set(EXAMPLES)


@pytest.mark.parametrize("cls", EXAMPLES, ids=lambda cls: cls.__name__)
def test_examples_end_with_their_class_and_are_general(cls):
    system = example_system(cls, 1)
    assert type(system.joints[-1]) is cls
    for body in system.bodies:
        assert np.abs(body.com).min() > 1e-3 and np.abs(body.orientation).min() > 1e-3


@every_joint
def test_residual_is_zero_at_the_reference_pose(cls, ground):
    evaluation = Evaluation(example_system(cls, 2, ground))
    q, v = evaluation.reference()
    c, *_ = evaluation.rows(q, v, 0.0)
    assert np.abs(c).max() < 1e-14  # differences of numbers of order one


AS_BUILT = [cls for cls in EXAMPLES if {x.name for x in fields(cls) if x.default is None} & {"at_b", "axis_b"}]


@pytest.mark.parametrize("cls", AS_BUILT, ids=lambda cls: cls.__name__)
def test_a_part_built_elsewhere_is_joined_at_the_same_places_of_its_own(cls):
    """With body b displaced, and ``at_b`` and ``axis_b`` with it, the rows are the same wherever the bodies are."""
    system, rng = example_system(cls, 11), np.random.default_rng(12)
    joint, given, turn = system.joints[-1], {}, np.array([1.0, 0.0, 0.0, 0.0])
    if hasattr(joint, "axis") and hasattr(joint, "axis_b"):
        turn = rotation(perpendiculars(joint.axis)[0], 1.2)  # about it they stay perpendiculars
        given["axis_b"] = matrix(turn) @ joint.axis
    body = replace(
        joint.b, position=joint.b.position + rng.normal(size=3), orientation=multiply(turn, joint.b.orientation)
    )
    if hasattr(joint, "at"):
        given["at_b"] = body.position + matrix(turn) @ (joint.at - joint.b.position)
    found = []
    for b, more in ((joint.b, {}), (body, given)):
        made = replace(joint, b=b, **more)
        pairs = (AngleDriver, made.angle()), (SlideDriver, made.slide())
        drivers = [driver(made, 0.3) for driver, x in pairs if x is not None]
        bodies = [b if x is joint.b else x for x in system.bodies]
        found.append(Evaluation(System(bodies, [made, *drivers])))
    q, v = found[0].general(rng)
    for x, y in zip(*(evaluation.rows(q, v, 0.0) for evaluation in found), strict=True):
        assert np.abs(x - y).max() < 1e-13  # rounding of numbers of order one


@every_joint
def test_residual_changes_by_J_v_minus_b(cls, ground):
    evaluation = Evaluation(example_system(cls, 3, ground))
    q, v = evaluation.general(np.random.default_rng(4))
    t, q_dot = 0.37, evaluation.rates(v, q)
    _, J, b, _ = evaluation.rows(q, v, t)
    rate = derivative(lambda h: evaluation.rows(evaluation.normalised(q + h * q_dot), v, t + h)[0])
    holonomic = evaluation.model.row["holonomic"] == 1
    assert np.abs(rate - (J @ v - b))[holonomic].max(initial=0.0) < TOLERANCE
    assert holonomic.all() == (cls.__name__ not in ("KnifeEdge", "RollingDisc", "Rolling", "SpeedDriver"))


@every_joint
def test_off_the_manifold_the_residual_and_its_rate_are_not_zero(cls, ground):
    evaluation = Evaluation(example_system(cls, 3, ground))
    q, v = evaluation.general(np.random.default_rng(4))
    c, J, b, _ = evaluation.rows(q, v, 0.37)
    own = evaluation.compiled.rows[id(evaluation.compiled.system.joints[-1])]
    holonomic = evaluation.model.row["holonomic"][own] == 1
    # else the identities above would be tested where terms vanish
    assert np.abs(c[own][holonomic]).min(initial=1.0) > 1e-4
    assert np.abs((J @ v - b)[own]).min() > 1e-3


@every_joint
def test_row_speed_changes_by_J_v_dot_minus_gamma(cls, ground):
    evaluation = Evaluation(example_system(cls, 5, ground))
    rng = np.random.default_rng(6)
    q, v = evaluation.general(rng)
    v_dot, t = rng.normal(size=v.size), 0.37
    q_dot = evaluation.rates(v, q)
    _, J, _, gamma = evaluation.rows(q, v, t)
    rate = derivative(lambda h: evaluation.speed(evaluation.normalised(q + h * q_dot), v + h * v_dot, t + h))
    assert np.abs(rate - (J @ v_dot - gamma)).max() < TOLERANCE


@pytest.mark.parametrize("cls", EXAMPLES, ids=lambda cls: cls.__name__)
def test_ablation_without_gamma_both_rates_part(cls):
    """The check on d(J v - b)/dt must see a missing J_dot v, and the one on c_dot one per cent on J."""
    evaluation = Evaluation(example_system(cls, 5), switches=Switches(gamma=False))
    rng = np.random.default_rng(6)
    q, v = evaluation.general(rng)
    v_dot, t = rng.normal(size=v.size), 0.37
    q_dot = evaluation.rates(v, q)
    _, J, _, gamma = evaluation.rows(q, v, t)
    rate = derivative(lambda h: evaluation.speed(q + h * q_dot, v + h * v_dot, t + h))
    own = evaluation.compiled.rows[id(evaluation.compiled.system.joints[-1])]
    assert np.abs(rate - (J @ v_dot - gamma))[own].min() > 100 * TOLERANCE
    assert np.abs(0.01 * J @ v)[own].min() > 100 * TOLERANCE


@pytest.mark.parametrize("cls", [cls for cls in EXAMPLES if cls.__name__.endswith("Driver")])
def test_drivers_move(cls):
    evaluation = Evaluation(example_system(cls, 7))
    q, v = evaluation.reference()
    _, _, b, gamma = evaluation.rows(q, v, 0.37)
    own = evaluation.compiled.rows[id(evaluation.compiled.system.joints[-1])]
    assert np.abs(b[own]).min() > 0.01 and np.abs(gamma[own]).min() > 0.01


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("cls", EXAMPLES, ids=lambda cls: cls.__name__)
def test_both_identities_to_rounding_by_complex_steps(cls, seed):
    """The same two identities without a difference formula; the drivers' own dependence on time is left out of both."""
    system, rng = example_system(cls, 20 + seed), np.random.default_rng(30 + seed)
    real, exact = Evaluation(system), Evaluation(system, complex)
    q, v = real.general(rng)
    q_dot, v_dot, t, h = real.rates(v, q), rng.normal(size=v.size), 0.37, 1e-30
    c, J, b, _ = exact.rows(q + 1j * h * q_dot, v + 1j * h * v_dot, t)
    c_dot, speed_dot = c.imag / h, (J @ (v + 1j * h * v_dot) - b).imag / h
    _, J, b, gamma = real.rows(q, v, t)
    rest = signal_terms(real, q, v, t)
    holonomic = real.model.row["holonomic"] == 1
    size = 1 + np.abs(J @ v_dot) + np.abs(gamma)
    # rounding, times what a nearly flat disc makes of it
    assert np.abs((c_dot - J @ v) / size)[holonomic].max(initial=0.0) < 1e-12
    limit = 1e-10 if cls is OrientationDriver else 1e-12  # its rest is a difference, good to 1e-11
    assert np.abs((speed_dot - (J @ v_dot - gamma) - rest) / size).max() < limit


def signal_terms(evaluation, q, v, t):
    """What the signals add to gamma: f'' for a motion, f' for a speed, else 0; d(b - J v)/dt here of an orientation."""
    if any(isinstance(joint, OrientationDriver) for joint in evaluation.compiled.system.joints):
        return derivative(lambda h: -evaluation.speed(q, v, t + h))
    terms = []
    for row in (row for joint in evaluation.compiled.system.joints for row in joint.rows()):
        rate = 0.0
        if row.signal is not None:
            rate = row.signal.second_derivative(t) if row.holonomic[0] else row.signal.derivative(t)
        terms += [float(rate)] * row.n_rows
    return np.array(terms)


@pytest.mark.parametrize("cls", EXAMPLES, ids=lambda cls: cls.__name__)
def test_complex_step_equals_central_differences(cls):
    system = example_system(cls, 8)
    real, exact = Evaluation(system), Evaluation(system, complex)
    rng = np.random.default_rng(9)
    q, v = real.general(rng)
    q_dot, v_dot, t = real.rates(v, q), rng.normal(size=v.size), 0.37

    def functions(evaluation, h):
        c, J, b, _ = evaluation.rows(q + h * q_dot, v + h * v_dot, t)
        return np.concatenate([c, J @ (v + h * v_dot) - b])

    step = functions(exact, 1e-30j).imag / 1e-30
    assert np.abs(step - derivative(lambda h: functions(real, h))).max() < TOLERANCE
    assert np.abs(functions(exact, 0.0) - functions(real, 0.0)).max() < 1e-14  # the same terms, rounding apart
