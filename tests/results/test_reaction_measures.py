"""Reactions in other axes and as measures: a joint that breaks, a general pair, what is not determined."""

import numpy as np
import pytest
from helpers.models import direction, random_body
from scipy.spatial.transform import Rotation

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Kinematic,
    PointOnPlane,
    Polynomial,
    RadauIIA,
    Revolute,
    Spherical,
    StateFeedback,
    Stepper,
    System,
    linearize,
    measures,
    simulate,
)


def chain(redundant=False):
    """A body on a slanted hinge, another one on a ball, both general."""
    rng = np.random.default_rng(8)
    a, b = random_body(rng, "a"), random_body(rng, "b")
    hinge = Revolute(GROUND, a, at=a.position + 0.4 * direction(rng), axis=direction(rng), name="hinge")
    ball = Spherical(a, b, at=b.position + 0.3 * direction(rng), name="ball")
    twin = [Revolute(GROUND, a, at=hinge.at + 0.5 * hinge.axis, axis=hinge.axis, name="twin")] if redundant else []
    return System([a, b], [hinge, *twin, ball], gravity=(0.3, -0.5, -9.7))


@pytest.fixture(scope="module")
def run():
    return simulate(chain(), 1.0, rtol=1e-9, output=21)


def frame(run, body):
    """Rotation of a body by scipy, (samples, 3, 3)."""
    return Rotation.from_quat(run.orientation(body), scalar_first=True).as_matrix()


def test_components_are_along_the_axes_asked_for(run):
    world = run.reaction("ball")
    for axes in "ab":
        R, own = frame(run, axes), run.reaction("ball", axes=axes)
        assert np.einsum("tji,tj->ti", R, world.force) == pytest.approx(own.force, abs=1e-12)
        assert np.einsum("tji,tj->ti", R, world.moment) == pytest.approx(own.moment, abs=1e-12)
        assert own.point == pytest.approx(world.point, abs=0.0) and own.unique
    assert run.reaction("hinge", axes="a").force == pytest.approx(run.reaction("hinge").force, abs=0.0)  # the ground's
    own, axis = run.reaction("hinge", axes="joint"), run.system.joints[0].axis
    assert own.force[:, 2] == pytest.approx(run.reaction("hinge").force @ axis, abs=1e-12)
    assert np.abs(own.moment[:, 2]).max() < 1e-10 < 1e-2 < np.abs(own.moment[:, :2]).max()  # free about its axis
    assert np.linalg.norm(own.force, axis=1) == pytest.approx(np.linalg.norm(run.reaction("hinge").force, axis=1))


def test_axes_of_the_joint_separate_what_is_determined():
    """A plane across a slanted hinge shares the force along its axis: it mixes with all world components."""
    system = chain()
    hinge, ball = system.joints
    plane = PointOnPlane(GROUND, hinge.b, at=hinge.at, normal=hinge.axis, name="plane")
    run = simulate(System(system.bodies, [hinge, plane, ball], gravity=system.gravity), 0.2, output=3)
    world, own = run.reaction("hinge"), run.reaction("hinge", axes="joint")
    assert not world.unique and not own.unique
    assert not world.unique_force.any() and own.unique_force.tolist() == [True, True, False]
    turned = own.force_projector @ own.force[:, :, None]
    assert turned[:, :, 0] == pytest.approx(own.determined_force, abs=1e-12)
    assert np.linalg.norm(own.determined_force, axis=1) == pytest.approx(np.linalg.norm(world.determined_force, axis=1))


@pytest.mark.parametrize("axes", ["world", "a", "b"])
@pytest.mark.parametrize("of", ["force", "moment"])
def test_a_measure_is_the_component_of_the_reaction(run, axes, of):
    along = np.array([0.6, -0.48, 0.64])
    joint = run.system.part("hinge", "joints")
    body = GROUND if axes == "world" else getattr(joint, axes)
    found = run.measure([measures.reaction(joint, axis=along, of=of, axes=axes), measures.reaction(joint, of=of)])
    whole = getattr(run.reaction("hinge"), of)
    assert found[:, 0] == pytest.approx(np.sum(run.body_axis(body, along) * whole, axis=1), abs=1e-10)
    assert found[:, 1] == pytest.approx(np.linalg.norm(whole, axis=1), abs=1e-10)  # rounding of 100 N


def test_a_joint_breaks_at_its_load_and_the_mass_flies_on():
    """Point mass on a massless rod from rest: 3 cos th - 2 cos th0 = F / (m g), then a parabola to the floor."""
    m, l, start, height = 2.0, 0.7, 1.3, 2.0
    place = (l * np.sin(start), 0.0, height - l * np.cos(start))
    bob = Body("bob", m, (1e-12, 1e-12, 1e-12), position=place)
    pin = Revolute(GROUND, bob, at=(0, 0, height), axis=(0, 1, 0), name="pin")
    system = System([bob], [pin])
    swing = simulate(system, 2.0, rtol=1e-11, stop_when=measures.reaction(pin) > 40.0)
    exact = dict(rel=1e-8, abs=1e-9)  # of the quadrature
    x, _, z = swing.position(bob)[-1]
    assert swing.t[-1] == pytest.approx(0.34539096733665925, **exact)
    assert np.arctan2(x, height - z) == pytest.approx(0.5396059430111315, **exact)
    free = system.release(pin, swing.final)
    floor = measures.position(bob, axis=(0, 0, 1)) < 0.0
    fall = simulate(free.system, 2.0, state=free.state, rtol=1e-11, stop_when=floor)
    assert fall.t[-1] == pytest.approx(0.7508270185242135, **exact)
    assert fall.position(bob)[-1, 0] == pytest.approx(-0.6308105870334965, **exact)


@pytest.mark.parametrize("method", [None, RadauIIA()])
def test_a_run_stops_where_a_component_crosses_its_value(run, method):
    joint = run.system.part("ball", "joints")
    load_of = measures.reaction(joint, axis=(1, 2, 2), axes="b")
    dense = simulate(chain(), 1.0, rtol=1e-9, output=2001)
    values = dense.measure(measures.reaction(dense.system.part("ball", "joints"), axis=(1, 2, 2), axes="b"))
    value = 0.5 * (values[0] + values.max())
    system = run.system
    stopped = simulate(
        system, 1.0, **({} if method is None else {"method": method}), rtol=1e-9, stop_when=load_of > value
    )
    first = int(np.argmax(values > value))
    share = (value - values[first - 1]) / (values[first] - values[first - 1])
    assert stopped.t[-1] == pytest.approx(dense.t[first - 1] + share * 5e-4, abs=1e-6)  # linear in half a millisecond
    assert stopped.measure(load_of)[-1] == pytest.approx(value, rel=1e-8)
    assert "reaction force of ball >" in stopped.certificate.stopped_by


def test_a_driven_run_stops_at_a_load():
    """Inverse dynamics: |F| = m (g + r a t ...) along a driven circle, F from the closed form."""
    bob = Body("bob", 2.0, (0.1, 0.1, 0.1), com=(0.5, 0, 0))
    pin = Revolute(GROUND, bob, at=(0, 0, 0), axis=(0, 0, 1), name="pin")
    system = System([bob], [pin, AngleDriver(pin, Polynomial((0.0, 0.0, 1.5)), name="motor")], gravity=(0, 0, 0))
    stopped = simulate(system, 3.0, method=Kinematic(), stop_when=measures.reaction(pin) > 30.0)
    # alpha = 3, omega = 3 t: m l sqrt(alpha^2 + omega^4) = 30
    assert stopped.t[-1] == pytest.approx((30.0**2 - 3.0**2) ** 0.25 / 3.0, abs=1e-7)


def test_a_run_goes_on_from_a_value_that_it_just_has(run):
    joint = run.system.part("ball", "joints")
    load_of = measures.reaction(joint)
    value = 0.5 * (run.measure(load_of)[0] + run.measure(load_of).max())
    first = simulate(run.system, 1.0, rtol=1e-10, stop_when=load_of > value)
    again = simulate(run.system, first.t[-1] + 1.0, state=first.final, rtol=1e-10, stop_when=load_of < value)
    assert again.t[-1] > first.t[-1] + 1e-3
    assert again.measure(load_of)[-1] == pytest.approx(value, rel=1e-8)


def test_a_stepper_reads_it(run):
    joint = run.system.part("hinge", "joints")
    step = Stepper(run.system, rtol=1e-9, measures=[measures.reaction(joint)])
    for k in (5, 10):
        step.advance(run.t[k])
        assert step.measured[0] == pytest.approx(np.linalg.norm(run.reaction("hinge").force[k]), rel=1e-6)


def test_what_is_not_determined_or_not_known_yet_is_refused(run):
    system = chain(redundant=True)
    seen = measures.reaction(system.part("hinge", "joints"))
    text = "reaction force of hinge is not determined by the constraints.*change the joints that check"
    with pytest.raises(ValueError, match=text):
        simulate(system, 0.1, stop_when=seen > 1.0)
    with pytest.raises(ValueError, match=text):
        simulate(system, 0.1, output=3).measure(seen)
    with pytest.raises(ValueError, match=f"Stepper: measures: {text}"):
        Stepper(system, measures=[seen])
    hinge = run.system.part("hinge", "joints")
    with pytest.raises(
        ValueError, match="the load would change reaction force of hinge, which it reads at the same time"
    ):
        StateFeedback(measures=[measures.reaction(hinge)], gains=[1.0], on=hinge)
    rest = System([run.system.bodies[0]], [hinge], gravity=run.system.gravity)
    with pytest.raises(ValueError, match="reaction force of hinge is not a function of the states alone"):
        linearize(rest, rest.equilibrium().state, outputs=[measures.reaction(hinge)])
    with pytest.raises(ValueError, match="joint 'hinge' is not in the system"):
        simulate(System(run.system.bodies, run.system.joints[1:]), 0.1).measure(measures.reaction(hinge))


def test_arguments_are_checked(run):
    hinge = run.system.part("hinge", "joints")
    for given, text in (
        ({"of": "torque"}, "of 'torque' is unknown; give 'force' or 'moment'"),
        ({"axes": "joint"}, "axes 'joint' is unknown"),
        ({"axis": (0, 0, 0)}, "measures.reaction: axis"),
    ):
        with pytest.raises(ValueError, match="measures.reaction") as error:
            measures.reaction(hinge, **given)
        assert text in str(error.value)
    with pytest.raises(ValueError, match="axes 'c' is unknown; give 'world' or 'a' or 'b' or 'joint'"):
        run.reaction("hinge", axes="c")
    with pytest.raises(ValueError, match="'ball' .*has no axis of its own; give axes='a', 'b' or 'world'"):
        run.reaction("ball", axes="joint")
