"""Bad input to the Python interface: every message names the part, the value and the remedy."""

import re

import numpy as np
import pytest
from helpers.models import pendulum, random_body

from mbsd3d import (
    DOP853,
    GROUND,
    RK4,
    AeroDrag,
    AngleDriver,
    AssemblyError,
    Body,
    Bushing,
    Constant,
    ConstantVelocity,
    Distance,
    Fixed,
    Force,
    Gear,
    IntegrationError,
    JointFriction,
    Kinematic,
    Parallel,
    Perpendicular,
    Planar,
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
    measures,
    simulate,
)
from mbsd3d.errors import MbsError
from mbsd3d.inertia import box

NAN, INF = float("nan"), float("inf")
ROD = random_body(np.random.default_rng(61), "rod")
OTHER = random_body(np.random.default_rng(62), "other")
HERE, ALONG = (0.1, -0.2, 0.3), (0.6, -0.3, 0.9)
HINGE = Revolute(GROUND, ROD, at=HERE, axis=ALONG, name="hinge")
SLIDER = Prismatic(GROUND, OTHER, at=HERE, axis=ALONG, name="slider")
BALL = Spherical(GROUND, ROD, at=HERE, name="ball")
I = (0.2, 0.3, 0.25)
LONGEST = 400
"""Characters a person reads; arrays of bodies do not belong in a message."""


def says(call, *words, kind=ValueError):
    """The call fails with a message that holds all words (regular expressions); returns the error."""
    with pytest.raises(kind) as caught:
        call()
    message = str(caught.value)
    for word in words:
        assert re.search(word, message), f"{word!r} is not in: {message}"
    assert len(message) < LONGEST
    return caught.value


BODIES = {
    "mass NaN": (lambda: Body("rod", NAN, I), ["body 'rod'", "mass", "nan", "finite"]),
    "mass infinite": (lambda: Body("rod", INF, I), ["body 'rod'", "mass", "inf", "finite"]),
    "mass negative": (lambda: Body("rod", -1.5, I), ["body 'rod'", "mass", r"-1\.5", ">= 0"]),
    "mass text": (lambda: Body("rod", "heavy", I), ["body 'rod'", "mass", "heavy", "number"]),
    "inertia not symmetric": (
        lambda: Body("rod", 1.0, [[1, 0.2, 0], [0, 1, 0], [0, 0, 1]]),
        ["body 'rod'", "inertia is not symmetric", r"0\.2", "equal"],
    ),
    "triangle rule": (
        lambda: Body("rod", 1.0, (1.1, 1.2, 3.0)),
        ["body 'rod'", r"principal moments \[1\.1, 1\.2, 3\. *\]", r"3 exceeds the sum 2\.3", "check"],
    ),
    "inertia negative": (lambda: Body("rod", 1.0, (1, 1, -0.1)), ["body 'rod'", r"-0\.1 < 0", "check the signs"]),
    "inertia NaN": (lambda: Body("rod", 1.0, (1, 1, NAN)), ["body 'rod'", "inertia", "nan", "give three moments"]),
    "inertia shape": (lambda: Body("rod", 1.0, (1, 1)), ["body 'rod'", "inertia", r"\(2,\)", "give three moments"]),
    "inertia without mass": (lambda: Body("rod", 0.0, I), ["body 'rod'", "mass is 0", r"give a mass, or inertia"]),
    "quaternion not of unit length": (
        lambda: Body("rod", 1.0, I, orientation=(1, 1, 0, 0)),
        ["body 'rod'", "orientation", r"norm 1\.41421356", r"rotations\.normalize\(e\)"],
    ),
    "quaternion a hundred-thousandth too long": (
        lambda: Body("rod", 1.0, I, orientation=(1 + 1e-5, 0, 0, 0)),
        ["body 'rod'", r"norm 1\.00001", r"rotations\.normalize"],
    ),
    "matrix left-handed": (
        lambda: Body("rod", 1.0, I, orientation=np.diag([1, 1, -1.0])),
        ["body 'rod'", "left-handed", "reverse one axis"],
    ),
    "position NaN": (lambda: Body("rod", 1.0, I, position=(0, NAN, 0)), ["body 'rod'", "position", "nan", "finite"]),
    "position short": (lambda: Body("rod", 1.0, I, position=(0, 1)), ["body 'rod'", "position", "three numbers"]),
    "com text": (lambda: Body("rod", 1.0, I, com="middle"), ["body 'rod'", "com", "middle", "three numbers"]),
    "omega infinite": (lambda: Body("rod", 1.0, I, omega=(0, 0, INF)), ["body 'rod'", "omega", "inf", "finite"]),
    "no name": (lambda: Body("", 1.0, I), ["body name ''", "non-empty"]),
    "box of negative size": (lambda: box(1.0, (-1.0, 2.0, 3.0)), ["-1", "give"]),
}


@pytest.mark.parametrize("name", BODIES)
def test_body(name):
    call, words = BODIES[name]
    says(call, *words)


def test_a_quaternion_within_a_millionth_is_normalised():
    body = Body("rod", 1.0, I, orientation=(1 + 5e-7, 0, 0, 0))
    assert np.array_equal(body.orientation, (1, 0, 0, 0))


def test_a_given_number_is_never_changed():
    body = Body("rod", 1.3, I, com=HERE, position=ALONG, velocity=(1, 2, 3), omega=(0.3, 0.2, 0.1))
    state = System(bodies=[body]).state()
    assert np.array_equal(state.q[:3], ALONG) and np.array_equal(state.v, (1, 2, 3, 0.3, 0.2, 0.1))


JOINTS = {
    "zero axis": (
        lambda: Revolute(GROUND, ROD, at=HERE, axis=(0, 0, 0), name="hinge"),
        ["joint 'hinge'", "Revolute", "axis has zero length", "give a direction"],
    ),
    "NaN axis": (
        lambda: Revolute(GROUND, ROD, at=HERE, axis=(0, 0, NAN), name="hinge"),
        ["joint 'hinge'", "axis", "nan", "finite"],
    ),
    "NaN point": (lambda: Spherical(GROUND, ROD, at=(NAN, 0, 0), name="pin"), ["joint 'pin'", "at", "nan", "finite"]),
    "zero normal": (
        lambda: Planar(GROUND, ROD, at=HERE, normal=(0, 0, 0), name="table"),
        ["joint 'table'", "normal has zero length", "give"],
    ),
    "itself": (
        lambda: Spherical(ROD, ROD, at=HERE, name="pin"),
        ["joint 'pin'", "Spherical", "rod", "itself", "two different bodies"],
    ),
    "ground to ground": (
        lambda: Fixed(GROUND, GROUND, at=HERE, name="weld"),
        ["joint 'weld'", "(?i)ground", "itself", "two different bodies"],
    ),
    "no body": (
        lambda: Spherical(GROUND, "rod", at=HERE, name="pin"),
        ["joint 'pin'", "'rod' is not a body", "give a Body"],
    ),
    "Universal parallel": (
        lambda: Universal(GROUND, ROD, at=HERE, axis_a=ALONG, axis_b=np.multiply(2, ALONG), name="cross"),
        ["joint 'cross'", "Universal", "parallel", "perpendicular"],
    ),
    "Universal skew": (
        lambda: Universal(GROUND, ROD, at=HERE, axis_a=(0, 0, 1), axis_b=(0, 1, 1), name="cross"),
        ["joint 'cross'", "45 degrees", "give perpendicular axes"],
    ),
    "Perpendicular skew": (
        lambda: Perpendicular(GROUND, ROD, axis_a=(0, 0, 1), axis_b=(0, 1, 1), name="square"),
        ["joint 'square'", "45 degrees", "give 90"],
    ),
    "ConstantVelocity bent too far": (
        lambda: ConstantVelocity(GROUND, ROD, at=HERE, axis_a=(0, 0, 1), axis_b=(0, 1, -0.5), name="shaft"),
        ["joint 'shaft'", "90 degrees or more", "point both"],
    ),
    "Distance without direction": (
        lambda: Distance(GROUND, ROD, at_a=HERE, at_b=HERE, name="link"),
        ["joint 'link'", "coincide", "use Spherical"],
    ),
    "Distance of no length": (
        lambda: Distance(GROUND, ROD, at_a=HERE, at_b=ALONG, length=0.0, name="link"),
        ["joint 'link'", "length", "not positive"],
    ),
    "Screw of NaN pitch": (
        lambda: Screw(GROUND, ROD, at=HERE, axis=ALONG, pitch=NAN, name="nut"),
        ["joint 'nut'", "pitch", "nan"],
    ),
    "Parallel of zero axis": (
        lambda: Parallel(GROUND, ROD, axis=(0, 0, 0), name="shaft"),
        ["joint 'shaft'", "axis has zero length"],
    ),
    "Gear of ratio 0": (
        lambda: Gear(HINGE, Revolute(GROUND, OTHER, at=HERE, axis=ALONG), ratio=0.0, name="gear"),
        ["joint 'gear'", "ratio is 0", "angle_b / angle_a"],
    ),
    "Gear on one hinge": (lambda: Gear(HINGE, HINGE, ratio=2.0, name="gear"), ["joint 'gear'", "hinge", "give two"]),
    "Gear without angle": (
        lambda: Gear(HINGE, SLIDER, ratio=2.0, name="gear"),
        ["joint 'gear'", "'slider'", "no angle", "e.g. a Revolute"],
    ),
    "RackPinion without slide": (
        lambda: RackPinion(HINGE, HINGE, radius=0.1, name="rack"),
        ["joint 'rack'", "'hinge'", "no slide", "e.g. a Prismatic"],
    ),
    "RollingDisc without radius": (
        lambda: RollingDisc(GROUND, ROD, axis=(0, 1, 0), radius=0.0, name="wheel"),
        ["joint 'wheel'", "radius", "not positive"],
    ),
    "RollingDisc with too large a crown": (
        lambda: RollingDisc(GROUND, ROD, axis=(0, 1, 0), radius=0.3, crown=0.4, name="wheel"),
        ["joint 'wheel'", r"crown 0\.4 exceeds the outer radius 0\.3", "crown <= radius"],
    ),
    "RollingDisc lying flat": (
        lambda: RollingDisc(GROUND, ROD, axis=(0, 0, 1), radius=0.3, name="wheel"),
        ["joint 'wheel'", "flat", "tilt"],
    ),
    "AngleDriver on a slider": (
        lambda: AngleDriver(SLIDER, Ramp(1.0), name="motor"),
        ["joint 'motor'", "'slider'", "no angle", "give"],
    ),
    "SlideDriver on a hinge": (
        lambda: SlideDriver(HINGE, Ramp(1.0), name="motor"),
        ["joint 'motor'", "'hinge'", "no slide", "give"],
    ),
    "driver with a function": (
        lambda: AngleDriver(HINGE, np.sin, name="motor"),
        ["joint 'motor'", "signal", "finite number or a signal", "Table"],
    ),
    "driver with NaN": (lambda: AngleDriver(HINGE, NAN, name="motor"), ["joint 'motor'", "signal", "nan", "give"]),
    "PositionDriver with one signal": (
        lambda: PositionDriver(ROD, at=HERE, signal=Ramp(1.0), name="motor"),
        ["joint 'motor'", "three signals", "None = free"],
    ),
    "PositionDriver with none": (
        lambda: PositionDriver(ROD, at=HERE, signal=(None, None, None), name="motor"),
        ["joint 'motor'", "all three directions are free", "at least one"],
    ),
    "SpeedDriver of zero axis": (
        lambda: SpeedDriver(GROUND, ROD, axis=(0, 0, 0), speed=1.0, name="motor"),
        ["joint 'motor'", "axis has zero length"],
    ),
}


@pytest.mark.parametrize("name", JOINTS)
def test_joint(name):
    call, words = JOINTS[name]
    says(call, *words)


FORCES = {
    "on no body": (
        lambda: Force("rod", (1, 0, 0), name="push"),
        ["force 'push'", "'rod' is not a body", "give a Body"],
    ),
    "a mass that is True": (lambda: Body("rod", True, (1, 1, 1)), ["body 'rod'", "mass", "a number, got True"]),
    "an inertia with True": (
        lambda: Body("rod", 1.0, [[1, 0, 0], [0, True, 0], [0, 0, 1]]),
        ["body 'rod'", "inertia", "True", "not numeric"],
    ),
    "a component that is False": (lambda: Force(ROD, (1, False, 0), name="push"), ["force 'push'", "y", "got False"]),
    "two components": (lambda: Force(ROD, (1, 0), name="push"), ["force 'push'", "force", "three components"]),
    "NaN component": (lambda: Force(ROD, (1, NAN, 0), name="push"), ["force 'push'", "along y", "nan", "give"]),
    "unknown frame": (
        lambda: Torque(ROD, (1, 0, 0), frame="local", name="twist"),
        ["force 'twist'", "frame 'local'", "'world' or 'body'"],
    ),
    "negative stiffness": (
        lambda: SpringDamper(GROUND, ROD, at_a=HERE, at_b=ALONG, stiffness=-1.0, name="spring"),
        ["force 'spring'", "stiffness", r"-1\.0", ">= 0"],
    ),
    "no direction": (
        lambda: SpringDamper(GROUND, ROD, at_a=HERE, at_b=HERE, stiffness=1.0, name="spring"),
        ["force 'spring'", "coincide", "move one"],
    ),
    "spring on a ball": (
        lambda: TorsionSpring(BALL, stiffness=1.0, name="spring"),
        ["force 'spring'", "no angle and no slide", "give a Revolute"],
    ),
    "friction without transition": (
        lambda: JointFriction(HINGE, coulomb=1.0, transition=0.0, name="brake"),
        ["force 'brake'", "transition", "> 0"],
    ),
    "bushing with a negative entry": (
        lambda: Bushing(GROUND, ROD, at=HERE, stiffness=(1, -2, 3), name="rubber"),
        ["force 'rubber'", "stiffness", "-2", "negative", ">= 0"],
    ),
    "bushing with a list in a list": (
        lambda: Bushing(GROUND, ROD, at=HERE, stiffness=3.0, damping=(1.0, [2.0, 3.0], 4.0), name="rubber"),
        ["force 'rubber'", "damping", "not numeric", "give three numbers"],
    ),
    "drag with negative area": (
        lambda: AeroDrag(ROD, drag_area=-0.1, name="drag"),
        ["force 'drag'", "drag_area", r"-0\.1", ">= 0"],
    ),
}


@pytest.mark.parametrize("name", FORCES)
def test_force(name):
    call, words = FORCES[name]
    says(call, *words)


SIGNALS = {
    "Table too short": (lambda: Table([0, 1, 2], [0, 1, 2]), ["3 points", "needs 4"]),
    "Table out of order": (lambda: Table([0, 1, 1, 2], [0, 1, 2, 3]), [r"times\[2\]", "sort"]),
    "Sine NaN": (lambda: Sine(NAN, 1.0), ["Sine", "amplitude", "nan"]),
    "Constant text": (lambda: Constant("one"), ["Constant", "value", "'one'"]),
    "Polynomial empty": (lambda: Polynomial(()), ["Polynomial", "empty", "c0"]),
}


@pytest.mark.parametrize("name", SIGNALS)
def test_signal(name):
    call, words = SIGNALS[name]
    says(call, *words)


SYSTEMS = {
    "no bodies": (lambda: System(bodies=[]), ["no bodies", "at least one"]),
    "joint of a body that is not there": (
        lambda: System(bodies=[ROD], joints=[Spherical(ROD, OTHER, at=HERE, name="pin")]),
        ["Spherical 'pin'", "body 'other' is not in the system", "add it to bodies"],
    ),
    "force on a body that is not there": (
        lambda: System(bodies=[ROD], forces=[Force(OTHER, (1, 0, 0), name="push")]),
        ["Force 'push'", "body 'other' is not in the system", "add it to bodies"],
    ),
    "gear of a joint that is not there": (
        lambda: System(bodies=[ROD], joints=[AngleDriver(HINGE, 1.0, name="motor")]),
        ["AngleDriver 'motor'", "joint 'hinge' is not in the system", "add it to joints"],
    ),
    "two bodies of one name": (
        lambda: System(bodies=[ROD, random_body(np.random.default_rng(1), "rod")]),
        ["two parts are named 'rod'", "a unique name"],
    ),
    "body and joint of one name": (
        lambda: System(bodies=[ROD], joints=[Spherical(GROUND, ROD, at=HERE, name="rod")]),
        ["two parts are named 'rod'", "a unique name"],
    ),
    "body named ground": (
        lambda: System(bodies=[random_body(np.random.default_rng(1), "ground")]),
        ["'ground'", "a unique name"],
    ),
    "body twice": (lambda: System(bodies=[ROD, ROD]), ["twice", "bodies", "once"]),
    "gravity NaN": (lambda: System(bodies=[ROD], gravity=(0, 0, NAN)), ["gravity", "nan", "finite"]),
    "joint among the bodies": (
        lambda: System(bodies=[ROD, BALL]),
        ["Spherical 'ball' is in bodies", "belongs in joints="],
    ),
    "one body without a list": (lambda: System(ROD), ["Body 'rod' is not a sequence", r"bodies=\[...\]"]),
    "one joint without a list": (lambda: System([ROD], BALL), ["Spherical 'ball'", r"joints=\[...\]"]),
    "joint among the forces": (lambda: System([ROD], [], [BALL]), ["Spherical 'ball' is in forces", "joints="]),
    "class among the joints": (lambda: System([ROD], [Spherical]), ["is a class", r"Spherical\(...\)"]),
    "name that is none": (lambda: System([ROD], name=3), ["name 3", "text"]),
}


@pytest.mark.parametrize("name", SYSTEMS)
def test_system(name):
    call, words = SYSTEMS[name]
    says(call, *words)


def swing():
    """A pendulum named in full, with its hinge."""
    return System(bodies=[ROD], joints=[HINGE])


RUNS = {
    "t_end 0": (lambda: simulate(swing(), 0.0), ["t_end = 0 s", "later time"]),
    "t_end negative": (lambda: simulate(swing(), -2.0), ["t_end = -2 s", "later time"]),
    "t_end NaN": (lambda: simulate(swing(), NAN), ["t_end", "nan", "finite"]),
    "t_end without digits for a step": (
        lambda: simulate(swing(), 1e20),
        [r"t_end = 1e\+20 s", r"times there are 2e\+04 s apart", "earlier end"],
    ),
    "t_end before the state": (
        lambda: simulate(swing(), 1.0, state=State(2.0, swing().state().q, np.zeros(6))),
        ["t_end = 1 s", "start time 2 s", "later"],
    ),
    "rtol 0": (lambda: simulate(swing(), 1.0, rtol=0.0), ["rtol", "outside 1e-1", "range"]),
    "rtol NaN": (lambda: simulate(swing(), 1.0, rtol=NAN), ["rtol", "nan", "finite"]),
    "unknown stabilisation": (
        lambda: simulate(swing(), 1.0, stabilisation="magic"),
        ["stabilisation 'magic'", "'none', 'baumgarte', 'projection'"],
    ),
    "output of one sample": (lambda: simulate(swing(), 1.0, output=1), ["output = 1", "at least 2"]),
    "output beyond the end": (
        lambda: simulate(swing(), 1.0, output=[0.5, 2.0]),
        ["output", r"0\.5 \.\.\. 2", "0 ... 1"],
    ),
    "output before the start": (lambda: simulate(swing(), 1.0, output=[-1, 0.5]), ["output", "-1", "0 ... 1"]),
    "output out of order": (lambda: simulate(swing(), 1.0, output=[0.5, 0.2]), ["output", "increasing"]),
    "output NaN": (lambda: simulate(swing(), 1.0, output=[0.5, NAN]), ["output", "finite"]),
    "output a boolean": (lambda: simulate(swing(), 1.0, output=True), ["output", "count"]),
    "output text": (lambda: simulate(swing(), 1.0, output="all"), ["output", "count", "all"]),
    "stop_when a function": (
        lambda: simulate(swing(), 1.0, stop_when=lambda t: True),
        ["stop_when", "not a condition", r"measures\.angle\(hinge\) > "],
    ),
    "stop_when a bare measure": (
        lambda: simulate(swing(), 1.0, stop_when=measures.angle(HINGE)),
        ["stop_when", "not a condition", r"measures\.angle\(hinge\) > "],
    ),
    "stop_when of another system": (
        lambda: simulate(swing(), 1.0, stop_when=measures.slide(SLIDER) > 1.0),
        ["stop_when", "slider", "not in (the|this) system"],
    ),
    "stop_when true at the start": (
        lambda: simulate(swing(), 1.0, stop_when=measures.angle(HINGE) > -1.0),
        ["stop_when", "angle of hinge > -1", "holds already at the start"],
    ),
    "stop_when at NaN": (lambda: measures.angle(HINGE) > NAN, ["angle of hinge", "nan", "finite"]),
    "RK4 of no step": (lambda: RK4(0.0), ["RK4", "dt", "> 0"]),
    "DOP853 of negative step": (lambda: DOP853(dt=-0.1), ["DOP853", "dt", r"-0\.1", "> 0"]),
    "DOP853 of no largest step": (lambda: DOP853(max_step=0.0), ["DOP853", "max_step", "> 0"]),
    "Kinematic of no largest step": (lambda: Kinematic(max_step=0.0), ["Kinematic", "max_step", "> 0"]),
    "Kinematic of NaN largest step": (lambda: Kinematic(max_step=NAN), ["Kinematic", "max_step", "> 0|finite"]),
    "method by name": (lambda: simulate(swing(), 1.0, method="rk4"), ["method 'rk4'", "RK4", r"DOP853\(\)"]),
    "method as a class": (lambda: simulate(swing(), 1.0, method=DOP853), ["method", "DOP853"]),
    "Kinematic on an undriven system": (
        lambda: simulate(swing(), 1.0, method=Kinematic()),
        ["Kinematic", "1 of 6 degrees of freedom are not determined", "add drivers, or use DOP853"],
    ),
    "Kinematic on a system driven at velocity level": (
        lambda: simulate(
            System(bodies=[ROD], joints=[HINGE, SpeedDriver(GROUND, ROD, axis=ALONG, speed=1.0)]),
            1.0,
            method=Kinematic(),
        ),
        ["Kinematic", "1 of 6", "replace SpeedDriver by AngleDriver"],
    ),
    "baumgarte of one number": (
        lambda: simulate(swing(), 1.0, stabilisation="baumgarte", baumgarte=(20.0,)),
        ["baumgarte", "two"],
    ),
    "baumgarte NaN": (
        lambda: simulate(swing(), 1.0, stabilisation="baumgarte", baumgarte=(NAN, 1.0)),
        ["baumgarte", "nan", "finite"],
    ),
    "state of another system": (
        lambda: simulate(swing(), 1.0, state=State(0.0, np.zeros(14), np.zeros(12))),
        ["state", "2 bodies, the system has 1", "state of this system"],
    ),
    "state that is none": (lambda: simulate(swing(), 1.0, state=3), ["simulate", "state 3 is not a State", "assemble"]),
    "equilibrium for a state": (lambda: simulate(swing(), 1.0, state=swing().equilibrium()), ["give its .state"]),
    "accelerations of no system": (lambda: accelerations(3), ["accelerations", "3 is not a System"]),
    "state with NaN": (lambda: State(0.0, np.full(7, NAN), np.zeros(6)), ["State", "q", "finite"]),
    "state of wrong size": (lambda: State(0.0, np.zeros(7), np.zeros(5)), ["7 coordinates", "5 velocities", "7 and 6"]),
    "Table that ends too early": (
        lambda: simulate(
            System(bodies=[ROD], forces=[Force(ROD, (Table([0, 0.1, 0.2, 0.4], [1, 2, 1, 0]), 0, 0), name="push")]), 1.0
        ),
        ["'push'", r"0 s to 0\.4 s", "0 s to 1 s", "extend the table"],
    ),
    "Table of a driver that ends too early": (
        lambda: simulate(
            System(
                bodies=[ROD],
                joints=[HINGE, AngleDriver(HINGE, Table([0, 0.1, 0.2, 0.4], [0, 2, 1, 0]), name="motor")],
            ),
            1.0,
        ),
        ["'motor'", r"0 s to 0\.4 s", "0 s to 1 s", "extend the table"],
    ),
}


@pytest.mark.parametrize("name", RUNS)
def test_run(name):
    call, words = RUNS[name]
    says(call, *words)


@pytest.fixture(scope="module")
def solution():
    return simulate(swing(), 0.1)


NAMES = {
    "body": (lambda s: s.position("bob"), ["'bob' is not one of the bodies", "there are 'rod'"]),
    "joint": (lambda s: s.angle("hing"), ["'hing' is not one of the joints", "there are 'hinge'"]),
    "reaction": (lambda s: s.reaction("hing"), ["'hing' is not one of the joints", "there are 'hinge'"]),
    "no reaction": (lambda s: s.reaction(), ["no joint given", "give one or more"]),
    "driver": (lambda s: s.effort("hinge"), ["'hinge' .Revolute. is not a driver", "reaction"]),
    "slide of a hinge": (lambda s: s.slide("hinge"), ["Revolute 'hinge' has no slide", "e.g. a Prismatic"]),
    "foreign body": (lambda s: s.position(OTHER), ["'other' is not one of the bodies", "'rod'"]),
    "time after the end": (lambda s: s.at(2.0), ["t = 2 s", r"0 \.\.\. 0\.1 s"]),
    "time NaN": (lambda s: s.at(NAN), ["solution.at: t", "not finite"]),
}


@pytest.mark.parametrize("name", NAMES)
def test_unknown_names_list_what_there_is(solution, name):
    call, words = NAMES[name]
    says(lambda: call(solution), *words)


ASSEMBLY = {
    "unknown hinge": (lambda: swing().assemble(angles={"hing": 1.0}), ["'hing'", "joints", "'hinge'"]),
    "NaN angle": (lambda: swing().assemble(angles={"hinge": NAN}), ["angle of 'hinge'", "nan", "finite"]),
    "rate as text": (lambda: swing().assemble(rates={"hinge": "fast"}), ["rate of 'hinge'", "number", "fast"]),
    "slide of a hinge": (lambda: swing().assemble(slides={"hinge": 1.0}), ["'hinge'", "no slide", "e.g. a Prismatic"]),
    "no measure": (lambda: swing().assemble(measures={"hinge": 1.0}), ["'hinge' is not a measure", "mbsd3d.measures"]),
    "unknown pinned body": (lambda: swing().assemble(pinned=["bob"]), ["'bob'", "bodies", "'rod'"]),
}


@pytest.mark.parametrize("name", ASSEMBLY)
def test_assemble(name):
    call, words = ASSEMBLY[name]
    says(call, *words)


def moving(**given):
    """A body with given velocities on a hinge."""
    body = Body("rod", 1.0, I, position=(0.4, 0.3, -0.2), **given)
    return System(bodies=[body], joints=[Revolute(GROUND, body, at=HERE, axis=ALONG, name="hinge")])


@pytest.mark.parametrize("given", [{"omega": (1.0, 2.0, 3.0)}, {"velocity": (1.0, 0.0, 0.0)}])
def test_inconsistent_velocities_name_joint_and_residual(given):
    error = says(
        lambda: simulate(moving(**given), 1.0), "velocities contradict", "Revolute 'hinge'", "residual", "None",
        kind=AssemblyError,
    )  # fmt: skip
    assert "hinge" in error.part and abs(error.residual) > 0.1 and error.time == 0.0


def test_two_bodies_whose_velocities_contradict_a_joint_between_them():
    a = Body("a", 1.0, I, velocity=(1, 0, 0), omega=(0, 0, 0))
    b = Body("b", 1.0, I, position=ALONG, velocity=(0, 0, 0), omega=(0, 0, 0))
    system = System(bodies=[a, b], joints=[Spherical(a, b, at=HERE, name="pin")])
    error = says(system.state, "Spherical 'pin'", "residual -?1", "None", kind=AssemblyError)
    assert abs(error.residual) == pytest.approx(1.0, abs=1e-12)


def test_a_reference_pose_that_gapes():
    hinge = Revolute(GROUND, ROD, at=HERE, at_b=np.add(HERE, (0, 0, 0.01)), axis=ALONG, name="hinge")
    error = says(
        lambda: simulate(System(bodies=[ROD], joints=[hinge]), 1.0),
        "reference pose does not close", "Revolute 'hinge'", r"residual 0\.01", "assemble",
        kind=AssemblyError,
    )  # fmt: skip
    assert error.residual == pytest.approx(0.01, rel=1e-9)


def tied(length):
    """A rod on a ball joint, tied to a point 5 m away."""
    body = Body("rod", 1.0, I, position=(0.5, 0.0, 0.0))
    pin = Spherical(GROUND, body, at=(0, 0, 0), name="pin")
    rope = Distance(GROUND, body, at_a=(5, 0, 0), at_b=(1, 0, 0), length=length, name="rope")
    return System(bodies=[body], joints=[pin, rope])


def test_a_pose_that_the_joints_cannot_meet():
    error = says(tied(2.0).assemble, "cannot close", "gap", "'rope'|'pin'", "residual", "lengths", kind=AssemblyError)
    assert 0.1 < abs(error.residual) < 2.1


def test_an_angle_out_of_reach():
    body = Body("rod", 1.0, I, position=(0.5, 0.0, 0.0))
    hinge = Revolute(GROUND, body, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")
    rope = Distance(GROUND, body, at_a=(1.5, 0.1, 0), at_b=(1, 0, 0), name="rope")
    says(
        lambda: System(bodies=[body], joints=[hinge, rope]).assemble(angles={hinge: 1.0}),
        "cannot close|misses", "residual", "angle|range",
        kind=AssemblyError,
    )  # fmt: skip


OFF = {
    "pose": lambda: State(0.0, swing().state().q + np.eye(7)[0] * 0.1, np.zeros(6)),
    "velocity": lambda: State(0.0, swing().state().q, np.ones(6)),
}


@pytest.mark.parametrize("what", OFF)
def test_a_state_off_the_joints_is_refused_by_a_run(what):
    error = says(
        lambda: simulate(swing(), 1.0, state=OFF[what]()), "'hinge'", "residual", "assemble", kind=AssemblyError
    )
    assert error.residual > 0.05


@pytest.mark.parametrize("what", OFF)
def test_a_state_off_the_joints_is_refused_by_accelerations(what):
    says(lambda: accelerations(swing(), OFF[what]()), "'hinge'", "residual", "assemble", kind=AssemblyError)


@pytest.mark.parametrize("joints", [[], [HINGE]])
def test_a_state_whose_quaternion_is_not_of_unit_length(joints):
    system = System(bodies=[ROD], joints=joints)
    start = system.state()
    doubled = State(0.0, start.q * [1, 1, 1, 2, 2, 2, 2], start.v)
    says(lambda: simulate(system, 1.0, state=doubled), "state", "'rod'", "norm 2", "unit|divide")


LIMIT = Polynomial((1.7e308, (np.finfo(float).max - 1.7e308) / 0.3))
"""Exceeds the largest number at t = 0.3 s."""

BROKEN = LIMIT - LIMIT
"""Zero before 0.3 s, not a number after."""


@pytest.mark.parametrize("method", [None, RK4(0.01), DOP853(dt=0.013)])
@pytest.mark.parametrize("output", [None, 101])
def test_a_force_that_is_not_finite_after_a_time(method, output):
    push = Force(ROD, (BROKEN + 2.0, 0.3, -0.4), name="push")
    system = System(bodies=[ROD], joints=[HINGE], forces=[push])
    error = says(
        lambda: simulate(system, 1.0, method=method, output=output), "not finite", "force 'push'", r"t = 0\.[23]",
        kind=IntegrationError,
    )  # fmt: skip
    step = getattr(method, "dt", None) or 0.0
    assert error.part == "force 'push'"
    assert 0.3 - step - 1e-9 < error.time <= 0.3 + 1e-15  # rounding
    found = error.solution
    assert found.t[0] == 0.0 and found.t.size > 2  # nothing computed is lost
    assert found.t[-1] > 0.3 - max(step, 0.01) - 1e-9
    assert all(np.isfinite(array).all() for array in found.arrays.values())
    reference = simulate(
        System(bodies=[ROD], joints=[HINGE], forces=[Force(ROD, (2.0, 0.3, -0.4))]),
        1.0,
        rtol=1e-10,
        output=[found.t[-1]],
    )
    assert found.position("rod")[-1] == pytest.approx(reference.position("rod")[0], abs=1e-6)  # 100 rtol


@pytest.mark.parametrize("method", [RK4(0.01), Kinematic()])
def test_a_driver_that_is_not_finite_after_a_time(method):
    system = System(bodies=[ROD], joints=[HINGE, AngleDriver(HINGE, BROKEN + Ramp(1.0), name="motor")])
    error = says(
        lambda: simulate(system, 1.0, method=method, output=101), "not finite", "joint 'motor'", r"t = 0\.(3|29)",
        kind=IntegrationError,
    )  # fmt: skip
    assert error.solution.t[-1] == pytest.approx(0.3, abs=0.011)


def test_an_adaptive_run_with_a_driver_that_is_not_finite_after_a_time():
    system = System(bodies=[ROD], joints=[HINGE, AngleDriver(HINGE, BROKEN + Ramp(1.0), name="motor")])
    error = says(
        lambda: simulate(system, 1.0, output=101),
        "not finite",
        "joint 'motor'",
        r"t = 0\.(3|29)",
        kind=IntegrationError,
    )
    assert error.solution.t[-1] <= error.time


def massless(**given):
    """A body without mass, and one with."""
    return [Body("ghost", 0.0, (0, 0, 0), position=(0.3, 0.2, 0.1), **given), ROD]


@pytest.mark.parametrize("on_a_ball", [False, True])
def test_a_massless_body_whose_velocity_is_not_determined(on_a_ball):
    bodies = massless()
    joints = [Spherical(*bodies, at=(0.3, 0.2, 0.2))] if on_a_ball else []
    says(
        lambda: simulate(System(bodies=bodies, joints=joints), 1.0),
        "velocity of body 'ghost' is not determined", "moves no mass", "give the body a mass",
        kind=AssemblyError,
    )  # fmt: skip


def test_a_massless_body_whose_acceleration_is_not_determined():
    bodies = massless(velocity=(0, 0, 0), omega=(0, 0, 0))
    says(
        lambda: simulate(System(bodies=bodies), 1.0), "body 'ghost'", "not determined", "give the body a mass",
        kind=(AssemblyError, IntegrationError),
    )  # fmt: skip


def test_errors_can_be_caught_together_and_keep_their_parts():
    error = says(tied(2.0).assemble, "gap", kind=MbsError)
    assert isinstance(error, AssemblyError) and error.part and error.advice


def test_a_model_can_be_used_after_an_error():
    system, body, hinge = pendulum()
    first = simulate(system, 0.5, output=3)
    with pytest.raises(ValueError, match="stabilisation"):
        simulate(system, 0.5, stabilisation="magic")
    assert np.array_equal(simulate(system, 0.5, output=3).arrays["state"], first.arrays["state"])
