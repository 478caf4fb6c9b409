"""Calls with wrong arguments are answered by public names, with the argument that was meant."""

import inspect
import pickle

import numpy as np
import pytest

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    Body,
    Contact,
    CurveContact,
    Force,
    Gear,
    Input,
    Prismatic,
    Pulse,
    Ramp,
    Revolute,
    RollingDisc,
    SpringDamper,
    State,
    Stepper,
    System,
    Table,
    accelerations,
    inertia,
    linearize,
    linkages,
    load,
    measures,
    samples,
    shapes,
    simulate,
    sweep,
)
from mbsd3d.errors import ArgumentError, MbsError
from validation import cross_check, reduce_to_planes

BOB = Body("bob", 1.0, (0.1, 0.1, 0.1), position=(0, 0, -1))
HINGE = Revolute(GROUND, BOB, at=(0, 0, 0), axis=(0, 1, 0), name="hinge")
SLIDER = Prismatic(GROUND, BOB, at=(0, 0, 0), axis=(1, 0, 0))
SWING = System([BOB], [HINGE])
ENDS = {"at_a": (0, 0, 0), "at_b": (0, 0, -1)}


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: simulate(SWING, 1.0, dt=0.1), r"simulate: no argument 'dt', the step belongs to a method: method=RK4"),
        (lambda: simulate(SWING), "simulate: missing a required argument: 't_end'; it takes system, t_end"),
        (lambda: linearize(SWING, output=[]), "linearize: no argument 'output', did you mean 'outputs'"),
        (
            lambda: Body("b", 1.0, (1, 1, 1), angular_velocity=(0, 0, 1)),
            "Body: no argument 'angular_velocity', .*'omega'",
        ),
        (lambda: SpringDamper(GROUND, BOB, **ENDS, k=3), "SpringDamper: no argument 'k', did you mean 'stiffness'. It"),
        (lambda: SpringDamper(GROUND, BOB, **ENDS, stiffness=1, c=3), "no argument 'c', did you mean 'damping'"),
        (lambda: Revolute(GROUND, BOB, at=(0, 0, 0)), "^Revolute: missing a required argument: 'axis'; it takes a, b"),
        (
            lambda: Revolute(GROUND, BOB, at=(0, 0, 0), axes=(1, 0, 0)),
            "Revolute: no argument 'axes', did you mean 'axis'",
        ),
        (lambda: System([BOB], joint=[HINGE]), "System: no argument 'joint', did you mean 'joints'"),
        (lambda: Force(BOB, (1, 0, 0), colour=3), "Force: no argument 'colour'; it takes body, force"),
        (lambda: Ramp(slope=1.0), "Ramp: no argument 'slope'; it takes rate, offset"),
        (lambda: SWING.assemble(angle={}), "System.assemble: no argument 'angle', did you mean 'angles'. It takes"),
        (lambda: System.from_file(file="x"), "System.from_file: no argument 'file'; it takes path"),
        (lambda: accelerations(SWING).position(part=BOB), "Solution.position: no argument 'part'; it takes body"),
        (lambda: measures.distance(GROUND, BOB, at=(0, 0, 0)), "distance: no argument 'at', did you mean 'at_b'. It"),
        (lambda: linkages.schatz(), "schatz: missing a required argument: 'length'; it takes length, angle"),
        (lambda: inertia.box(1.0, length=(1, 1, 1)), "box: no argument 'length', did you mean 'lengths'"),
        (lambda: inertia.combine(), "combine: missing a required argument: 'parts'"),
        (lambda: cross_check(SWING, 1.0, engine="mujoco"), "cross_check: no argument 'engine', did you mean 'engines'"),
        (
            lambda: Contact(GROUND, BOB, shapes.Sphere(0.1), stiffness=1e4, mu=0.3),
            "Contact: no argument 'mu', did you mean 'friction'",
        ),
        (lambda: sweep(None, {}, measures=None), "sweep: no argument 'measures', did you mean 'measure'"),
    ],
)
def test_wrong_calls(call, message):
    with pytest.raises(ArgumentError, match=message) as caught:
        call()
    assert isinstance(caught.value, TypeError) and isinstance(caught.value, MbsError)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: simulate(SWING, 1.0, output=0.01),
            r"output = 0.01: give a count, or .* numpy.arange\(0, t_end, 0.01\)",
        ),
        (lambda: simulate(SWING, 1.0, output=10**18), "more than memory holds; give at most"),
        (lambda: simulate(SWING, 1.0, baumgarte=3), "baumgarte 3: give two factors"),
        (lambda: simulate(SWING, 1.0, gyroscopic="x"), "gyroscopic = 'x'; give True or False"),
        (lambda: simulate(SWING, 1.0, as_built="1mm"), "as_built: expected a number, got '1mm'"),
        (lambda: simulate(SWING, 1.0, method=RK4(1e-30)), "dt = 1e-30 s needs 1e.30 steps; give a longer one"),
        (
            lambda: simulate(SWING, 1.0, method=DOP853(max_step=1e-20)),
            "max_step = 1e-20 s needs 1e.20 steps; give a lon",
        ),
        (
            lambda: Stepper(SWING, method=RK4(1e-30)).advance(1.0),
            "Stepper: dt = 1e-30 s needs 1e.30 steps; give a longer",
        ),
        (lambda: SWING.check(as_built="1mm"), "as_built: expected a number, got '1mm'"),
        (lambda: SWING.assemble(angles=[1]), r"angles = \[1\] is not a mapping; give e.g. {hinge: 0.3}"),
        (
            lambda: Body("b", 1e300, (1, 1, 1)),
            "mass: 1e.300 is outside the magnitudes 1e-60 ... 1e.60; check the units",
        ),
        (lambda: Body("b", 1e-300, (1, 1, 1)), "mass 1e-300 is below 1e-60; check the units, or give 0"),
        (lambda: Body("b", 10**400, (1, 1, 1)), "mass: expected a number, got 1000.*401 characters"),
        (lambda: Body("b", "2", (1, 1, 1)), "mass: expected a number, got '2'"),
        (lambda: Body(3, 1.0, (1, 1, 1)), "body name 3: give a non-empty text"),
        (lambda: Body("a\x1b[2J", 1.0, (1, 1, 1)), r"body name 'a\\x1b.2J' holds control characters; give a text"),
        (lambda: System([BOB], name="a\nb"), r"System: name 'a\\nb' holds control characters; give a text of one line"),
        (lambda: Input("a\x9b1m"), r"Input: name 'a\\x9b1m' holds control characters; give a text of one line"),
        (lambda: Revolute(GROUND, BOB, at=(0, 0, 0), axis=(0, 1, 0), name=3), "Revolute name 3: give a non-empty text"),
        (lambda: Pulse(1.0, 0.0, 1e-110), "an edge of 1e-110 s is too steep to compute with"),
        (lambda: Table([0, 1, 2, 3], [0, 1e308, 0, -1e308]), "make a spline too steep to compute with"),
        (lambda: Table([0, 1e-300, 2e-300, 1], [0, 1, 2, 3]), "make a spline too steep to compute with"),
        (lambda: linearize(SWING, outputs=3), "linearize: outputs = 3 is not a sequence; give a list"),
        (lambda: SWING.assemble(pinned=BOB), "assemble: pinned = .* is not a sequence; give a list of bodies"),
        (lambda: accelerations(SWING).at("x"), "solution.at: t: expected a number, got 'x'"),
        (lambda: accelerations(SWING).state(5), "solution.state: sample 5 is not one of 1; give 0 ... 0"),
        (lambda: accelerations(SWING).body_point("bob", "x"), "body_point|local_point: point: 'x' is not numeric"),
        (lambda: RollingDisc(GROUND, BOB, axis=(0, 1, 0), radius=1.0, plane=(0, 0, 1)), "plane .*; give a point and a"),
        (lambda: linkages.bennett(0.3, None, 0.4, 1.2, 0.7), "bennett: .*: expected a number, got None"),
        (
            lambda: linkages.rssr(0.3, 1.5, 1, 1, 0.5, 0.2, spin="yes"),
            "rssr: spin 'yes' is unknown; give True or False",
        ),
        (lambda: measures.touches(HINGE), "measures.touches: .* is not a contact; give a Contact"),
        (lambda: Stepper(SWING, keep="yes"), "Stepper: keep 'yes' is unknown; give True or False"),
        (lambda: measures.angle("hinge"), "measures.angle: 'hinge' is not a joint; give the part itself"),
        (lambda: Gear(HINGE, SLIDER, ratio=2.0), "a Prismatic without a name has no angle; give a joint that has one"),
        (lambda: CurveContact(GROUND, BOB, np.ones((20_001, 3)), at=(0, 0, 0)), "give 8 to 20000 points"),
        (lambda: reduce_to_planes(BOB), "reduce_to_planes: .* is not a System; give"),
        (lambda: load("a\0b"), "path = 'a.x00b' names no file; give a name such as 'result.npz'"),
        (lambda: load(300 * "ü"), "path = 'ü.*: a name of 600 bytes; give one of at most 255"),
        (
            lambda: SWING.part(Body("bob", 1.0, (0.1, 0.1, 0.1))),
            "the 'bob' given is a part of another system; give its",
        ),
        (lambda: load(None), "path = None names no file; give a name such as 'result.npz'"),
        (lambda: simulate(SWING, 1.0, progress="bar"), "progress = bar; give True, False, 'lines' or None"),
        (lambda: SWING.part("bob", "body"), "part: kind 'body' is unknown; give 'bodies' or 'joints' or 'forces'"),
        (lambda: State("x", [0, 0, 0, 1, 0, 0, 0], [0] * 6), "State: t: expected a number, got 'x'"),
        (lambda: samples({"a": (0, 1)}, 10**18, method="random"), "count 1000000000000000000; give a whole number"),
        (lambda: System([BOB], gravity=None), "gravity: None is not numeric; give three numbers"),
    ],
)
def test_wrong_values(call, message):
    with pytest.raises(ValueError, match=message):
        call()


def test_help_and_copies_see_the_real_signatures():
    assert list(inspect.signature(Revolute).parameters)[:2] == ["a", "b"]
    assert list(inspect.signature(simulate).parameters)[:2] == ["system", "t_end"]
    assert list(inspect.signature(System).parameters)[:4] == ["bodies", "joints", "forces", "gravity"]
    assert isinstance(State(0.0, [0, 0, 0, 1, 0, 0, 0], [0] * 6), State)


def test_a_mistake_inside_a_part_is_not_explained_away():
    class Odd(Force):
        def check(self, what):
            raise TypeError("from inside")

    with pytest.raises(TypeError, match="^from inside$"):
        Odd(BOB, (1, 0, 0))
