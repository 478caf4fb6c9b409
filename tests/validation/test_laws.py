"""Every force element against its law written out once more, between two bodies and from the ground."""

import numpy as np
import pytest
from helpers.forces import EXAMPLES
from helpers.models import random_body
from helpers.second_formulation import differences

from mbsd3d import (
    GROUND,
    Brake,
    CurveContact,
    Gear,
    Joint,
    JointFriction,
    Planar,
    RackPinion,
    Ramp,
    Revolute,
    SlideDriver,
    State,
    System,
    TorsionSpring,
    accelerations,
    simulate,
)
from validation.cases.examples import moving
from validation.twins.definitions import equations as reference_point
from validation.twins.laws import LAWS

LIMIT = 1e-11
"""Relative: rounding of loads of order one on bodies of order one, and of the 40 nodes of a tyre's bristles."""


def loaded(name, ground):
    """(system, state, force) of two bodies with one force element, its internal states not at rest."""
    rng = np.random.default_rng(13)
    bodies = [random_body(rng, "one"), random_body(rng, "two")]
    joints, force = EXAMPLES[name](rng, GROUND if ground else bodies[0], bodies[1])
    system = System(bodies[1:] if ground else bodies, joints, [force], gravity=(0.3, -0.7, -9.6))
    start = moving(system, 5)
    z = start.z.copy()
    own = len(force.state_names())
    z[:own] += 0.1 * rng.normal(size=own)
    return system, State(start.t, start.q, start.v, z, start.coordinates), force


WRITTEN = [name for name in EXAMPLES if name.split()[0] in {law.__name__ for law in LAWS}]


@pytest.mark.parametrize("name", WRITTEN)
@pytest.mark.parametrize("ground", [False, True])
def test_laws(name, ground):
    system, state, force = loaded(name, ground)
    acceleration, wrench, _ = differences(system, state)
    assert acceleration < LIMIT and wrench < LIMIT
    bare = System(system.bodies, system.joints, gravity=system.gravity)
    alone = accelerations(bare, state=State(state.t, state.q, state.v, bare.state().z))
    loads = accelerations(system, state=state).arrays["acceleration"] - alone.arrays["acceleration"]
    assert np.abs(loads).max() > 1e-3  # the element does something here


@pytest.mark.parametrize("name", [name for name in WRITTEN if loaded(name, False)[2].state_names()])
def test_rates_of_own_states(name):
    system, state, force = loaded(name, False)
    now = reference_point.Motion(system, state, state.v.reshape(1, -1, 6))
    push, _ = reference_point.pushed(system, state, now, force, reference_point.law_of_force(system, force))
    found = accelerations(system, state=state).force(force).state_rates
    assert np.ravel([*found.values()]) == pytest.approx(push.rates, rel=LIMIT, abs=LIMIT)


def test_every_law_is_looked_at():
    assert {type(loaded(name, False)[2]) for name in WRITTEN} == set(LAWS)


@pytest.mark.parametrize("name", [name for name in EXAMPLES if name not in WRITTEN])
def test_a_force_without_a_law_is_named(name):
    system, state, force = loaded(name, False)
    with pytest.raises(ValueError, match=rf"force '.*' \({type(force).__name__}\) has no second formulation"):
        reference_point.solve(system, state)


def test_turns_of_a_spring_are_counted():
    """A torsion spring wound up by more than two turns pulls back with all of them."""
    rotor = random_body(np.random.default_rng(3), "rotor")
    hinge = Revolute(GROUND, rotor, at=rotor.centre, axis=(1, 2, 2))
    system = System([rotor], [hinge], [TorsionSpring(hinge, stiffness=3e-3, angle=0.4)])
    run = simulate(system, 0.5, state=system.assemble(rates={hinge: 30.0}))
    assert run.angle(hinge)[-1] > 4 * np.pi
    assert differences(system, run.final)[0] < 1e-9  # a step is projected


ROUND = 2 * np.pi * np.arange(160) / 160
WIRE = np.stack([np.cos(ROUND), 1.3 * np.sin(ROUND), 0.3 * np.sin(2 * ROUND)], axis=1)
CAM = (0.3 + 0.02 * np.cos(ROUND))[:, None] * np.stack([0 * ROUND, np.cos(ROUND), np.sin(ROUND)], axis=1)
CONTACTS = {
    "wire": (WIRE, dict(at=WIRE[7])),
    "roller": (CAM, dict(at=1.17 * CAM[40], pin=(1, 0, 0), radius=0.05)),
    "face": (CAM, dict(at=CAM[40], face=(0, 0, 1))),
}
ALONG = {
    "spring": lambda way, wheel: TorsionSpring(way, stiffness=4.0, damping=0.2, angle=0.3),
    "friction": lambda way, wheel: JointFriction(way, viscous=0.5),
    "brake": lambda way, wheel: Brake(way, torque=0.3, stiffness=40.0, damping=1.0),
    "driver": lambda way, wheel: SlideDriver(way, Ramp(0.4)),
    "rack": lambda way, wheel: RackPinion(wheel, way, radius=0.1),
}


@pytest.mark.parametrize("kind", ALONG)
@pytest.mark.parametrize("contact", CONTACTS)
def test_ways_along_curves(contact, kind):
    """Loads and rows along the curve of a bead, a roller and a face: they were taken for those of a hinge."""
    rng, (curve, where) = np.random.default_rng(8), CONTACTS[contact]
    one, two, three = (random_body(rng, name, position=(0, 0, 0)) for name in ("one", "two", "three"))
    way, at = CurveContact(one, two, curve, **where), (-0.2, 0.1, 0.1)
    hinge, wheel = (
        Revolute(GROUND, one, at=(0, 0.1, 0), axis=(1, 0.2, 0.1)),
        Revolute(GROUND, three, at=at, axis=(1, 9, 3)),
    )
    part = ALONG[kind](way, wheel)
    rows, loads = ([part], []) if isinstance(part, Joint) else ([], [part])
    system = System([one, two, three], [hinge, wheel, way, *rows], loads, gravity=(0.3, -0.7, -9.6))
    run = simulate(system, 0.1, state=system.assemble())
    acceleration, wrench, expected = differences(system, run.final)
    assert acceleration < 1e-9 and wrench < 1e-9 and expected.gaps.max() < 1e-9  # a step is projected


def test_laps_of_a_bead_are_counted():
    """A spring along a wire, wound up by more than a lap, pulls back with all of it, and a driver leads beyond one."""
    bead = random_body(np.random.default_rng(3), "bead", position=WIRE[7])
    way = CurveContact(GROUND, bead, WIRE, at=WIRE[7])
    spring, drive = TorsionSpring(way, stiffness=3.0, angle=0.4), SlideDriver(way, Ramp(90.0))
    for joints, forces in (([way], [spring]), ([way, drive], [])):
        system = System([bead], joints, forces)
        run = simulate(system, 0.16, state=system.assemble(rates={} if forces == [] else {way: 90.0}))
        assert run.slide(way)[-1] > 1.1 * way.line.length
        acceleration, _, expected = differences(system, run.final)
        assert acceleration < 1e-9 and expected.gaps.max() < 1e-9


def test_gears_and_racks_on_a_planar_joint():
    rng = np.random.default_rng(4)
    plate, wheel = (random_body(rng, name) for name in ("plate", "wheel"))
    table = Planar(GROUND, plate, at=(0.1, 0.2, 0.3), normal=(0.3, -0.4, 0.8))
    hinge = Revolute(GROUND, wheel, at=(0, 0, 0.1), axis=(0.2, 0.9, 0.1))
    system = System([plate, wheel], [table, hinge, Gear(table, hinge, ratio=-1.3)])
    acceleration, wrench, _ = differences(system, moving(system, 5))
    assert acceleration < LIMIT and wrench < LIMIT
