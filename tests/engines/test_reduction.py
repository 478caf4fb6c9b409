"""The sum of planes against the spatial block load, and each hypothesis of the reduction broken in turn."""

from dataclasses import fields, replace

import numpy as np
import pytest
from helpers.closed_forms import slider_crank as crank_theory

import validation
from engines import planar
from engines.balance.planes.shaft import bound
from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Cylindrical,
    Distance,
    Fixed,
    Force,
    Kinematic,
    PointOnLine,
    PointOnPlane,
    Polynomial,
    Prismatic,
    Ramp,
    Revolute,
    Sine,
    SpeedDriver,
    Spherical,
    SpringDamper,
    System,
    Table,
    Torque,
    Universal,
    rotation,
    simulate,
    spectrum,
)
from mbsd3d.rotations import matrix
from validation.cases.inline_four import CRANK_RATE, inline_four


def one_turn(system, rate=CRANK_RATE):
    """One turn of the crank by kinematics."""
    return simulate(system, 2 * np.pi / rate, method=Kinematic(), output=37)


TIMES = np.linspace(0, 2 * np.pi / CRANK_RATE, 25)
EXACT = 1e-12
"""Of the single-cylinder force: two solvers that only round."""
HINGES = ["bearing", *(f"bore {i}" for i in range(1, 5))]


def single_force():
    """Largest force of one cylinder of `inline_four` on its block [N]."""
    cylinder = crank_theory.SliderCrank(1.0, 2.0, 2.0, 0.5, 4.0, 0.5, 1 / 3, 5.0)
    return np.abs(crank_theory.block_force(cylinder, np.linspace(0, 6, 200), CRANK_RATE)).max()


def load(solution, *names):
    """Force and moment about the origin that joints, on their bodies b, exert back on what holds them."""
    force = moment = 0.0
    for name in names:
        reaction = solution.reaction(name)
        force = force - reaction.force
        moment = moment - reaction.moment - np.cross(reaction.point, reaction.force)
    return force, moment


def changed(system, parts=None, gravity=None):
    """A system with some parts replaced: by name, a mapping of new fields or a function of the old part."""
    parts, new = parts or {}, {id(GROUND): GROUND}

    def rebuilt(part):
        ends = {x.name: new[id(getattr(part, x.name))] for x in fields(part) if id(getattr(part, x.name)) in new}
        change = parts.get(part.name, {})
        new[id(part)] = change(replace(part, **ends)) if callable(change) else replace(part, **(ends | change))
        return new[id(part)]

    bodies, joints = [rebuilt(body) for body in system.bodies], [rebuilt(joint) for joint in system.joints]
    return System(bodies, joints, gravity=system.gravity if gravity is None else gravity)


def only(reduction, hypothesis, part):
    """The failure of a hypothesis by a part; no other hypothesis fails."""
    assert not reduction.holds
    assert {failure.hypothesis for failure in reduction.failures} == {hypothesis}, str(reduction)
    (found,) = [failure for failure in reduction.failures if part in failure.part]
    assert f"{hypothesis}: '" in str(reduction) and found.unit in str(reduction)
    return found


def test_inline_four_is_the_sum_of_its_planes():
    system = inline_four()
    reduction, spatial = validation.reduce_to_planes(system), one_turn(system)
    assert reduction.holds and [plane.z for plane in reduction.planes] == pytest.approx([-0.3, -0.1, 0.1, 0.3])
    assert [plane.units for plane in reduction.planes] == [(f"rod {i}",) for i in range(1, 5)]
    assert all(isinstance(plane.system, planar.System) for plane in reduction.planes)
    for driver in (True, False):
        force, moment = load(spatial, *HINGES, *(["motor"] if driver else []))
        found = reduction.block_load(spatial.t, driver=driver)
        assert np.abs(found.force - force).max() < EXACT * single_force()
        assert np.abs(found.moment - moment).max() < EXACT * single_force() * 1.0  # m: the crank radius
    assert np.abs(force[:, 2]).max() > single_force()  # the second orders add up: there is something to agree on


def test_orders_of_the_sum_of_planes():
    """The second order of four pistons adds up, the first cancels."""
    load_of_planes = validation.reduce_to_planes(inline_four()).block_load(TIMES).force
    found = spectrum(TIMES, load_of_planes, rate=CRANK_RATE)
    assert abs(found.at(2)[2]) == pytest.approx(16.444383944, abs=1e-9)  # published to 16.44 N, closed form beyond
    assert np.abs(found.at(1)).max() < EXACT * single_force()


SPIN, PLACE, TURN = 31.0, np.array([0.3, -0.2, 0.5]), matrix(rotation((0.3, -0.8, 0.5), 1.1))
"""The vee stands askew in space."""


def vee(banks=(-0.5, 0.4, -0.5), stations=(-0.21, 0.13, 0.34), phases=(0.3, 2.2, 4.4), *, throw=0.7, disc=(0, 0, 0.07)):
    """Units of general values on a block on a mount; the crank: throws of mass ``throw`` and a disc."""
    R, L, n, up = 0.11, 0.37, TURN[:, 2], TURN[:, 1]

    def at(x, y, z):
        return PLACE + TURN @ np.array([x, y, z])

    pins = [np.array([R * np.cos(q), R * np.sin(q), z]) for q, z in zip(phases, stations, strict=True)]
    lumps = [(throw, 0.8 * pin * [1, 1, 0] + pin * [0, 0, 1]) for pin in pins] + [(3.0, np.array(disc))]
    mass = sum(m for m, _ in lumps)
    centre = sum(m * p for m, p in lumps) / mass
    inertia = np.diag([0.3, 0.3, 0.4])
    for m, p in lumps:
        inertia += m * ((p - centre) @ (p - centre) * np.eye(3) - np.outer(p - centre, p - centre))
    block = Body("block", 40.0, (3, 4, 5), position=at(0.1, 0.2, 0.3), orientation=TURN)
    crank = Body("crank", mass, inertia, position=at(0, 0, 0.1), orientation=TURN, com=centre - [0, 0, 0.1])
    bearing = Revolute(block, crank, at=at(0, 0, -0.4), axis=n, name="bearing")
    joints = [Fixed(GROUND, block, at=at(0, -0.3, 0), name="mount"), bearing]
    joints += [AngleDriver(bearing, Ramp(SPIN), name="motor")]
    bodies = [block, crank]
    for i, (pin, bank) in enumerate(zip(pins, banks, strict=True), start=1):
        bore = np.array([-np.sin(bank), np.cos(bank), 0.0])
        along = pin @ bore
        wrist = bore * (along + np.sqrt(L**2 - pin[:2] @ pin[:2] + along**2)) + pin * [0, 0, 1]
        lean = (wrist - pin) / L
        frame = np.stack([np.cross(lean, [0, 0, 1]), lean, [0, 0, 1]], axis=1)
        rod = Body(
            f"rod {i}", 0.9, (0.012, 0.001, 0.013), com=(0.01, 0.12, 0.0), position=at(*pin), orientation=TURN @ frame
        )
        piston = Body(f"piston {i}", 0.6, (0.001, 0.002, 0.0015), position=at(*wrist), orientation=TURN)
        bodies += [rod, piston]
        joints += [
            Spherical(crank, rod, at=at(*pin), name=f"crankpin {i}"),
            Universal(piston, rod, at=at(*wrist), axis_a=n, axis_b=TURN @ frame[:, 0], name=f"wristpin {i}"),
            Prismatic(block, piston, at=at(*wrist), axis=TURN @ bore, name=f"bore {i}"),
        ]
    return System(bodies, joints, gravity=-6.0 * up)


def mount_load(solution):
    """Load of the moving parts on the block, from the reaction of the mount and the weight of the block."""
    force, moment = load(solution, "mount")
    block, weight = solution.system.part("block"), 40.0 * solution.system.gravity
    return force - weight, moment - np.cross(block.centre, weight)


@pytest.mark.parametrize("disc", [(0.0, 0.0, 0.07), (0.004, 0.001, 0.07)], ids=["round", "eccentric"])
def test_an_engine_askew_in_space_with_weight_and_heavy_throws(disc):
    """Two banks, uneven stations, a block on a mount; products of inertia of the crank are those of its throws.

    A disc off the axis, at a place of its own, is more than identical throws: force exact, a couple w^2 D unseen.
    """
    system = vee(disc=disc)
    reduction = validation.reduce_to_planes(system)
    times = np.linspace(0, 0.3, 31)
    force, moment = mount_load(simulate(system, 0.3, method=Kinematic(), output=times))
    found = reduction.block_load(times)
    assert np.abs(found.force - force).max() < 1e-11 * np.abs(force).max()
    unseen = 0.0
    if disc[0]:
        unseen = SPIN**2 * only(reduction, "H4", "crank").amount
        assert unseen > 0.01 * np.abs(moment).max()
    else:
        assert reduction.holds, str(reduction)
    error = np.linalg.norm(moment - found.moment, axis=1)
    assert np.abs(error - unseen).max() < 1e-11 * np.abs(moment).max()
    inside = {plane.units for plane in reduction.planes}
    assert inside == {("rod 1",), ("rod 2",), ("rod 3",), ()}  # the last one: the rest of the shaft


EIGHTH = np.pi / 4
LAYOUTS = {
    "single": ((0.2,), (0.17,), (0,)),
    "fork and blade": ((-0.5, 0.4), (0.1, 0.1), (20, 20)),
    "three in line": ((0.0,) * 3, (-0.1, 0.0, 0.1), (0, 120, 240)),
    "boxer": ((-2 * EIGHTH, 2 * EIGHTH) * 2, (-0.15, -0.05, 0.05, 0.15), (0, 180, 180, 0)),
    "cross-plane eight": (
        (-EIGHTH, EIGHTH) * 4, np.repeat((-0.15, -0.05, 0.05, 0.15), 2) + np.tile((-0.01, 0.01), 4),
        np.repeat((0, 90, 270, 180), 2),
    ),
}  # fmt: skip


@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts_with_heavy_throws_are_sums_of_planes(layout):
    """The product of inertia of three or eight throws is no fault: every plane carries its own."""
    banks, stations, phases = LAYOUTS[layout]
    place = (0.0, 0.0, float(np.mean(stations)))
    system = vee(banks=banks, stations=stations, phases=0.3 + np.radians(phases), disc=place)
    reduction, times = validation.reduce_to_planes(system), np.linspace(0, 0.2, 21)
    assert reduction.holds and len(reduction.planes) == len(set(stations))
    force, moment = mount_load(simulate(system, 0.2, method=Kinematic(), output=times))
    found = reduction.block_load(times)
    assert np.abs(found.force - force).max() < EXACT * np.abs(force).max()
    assert np.abs(found.moment - moment).max() < EXACT * np.abs(force).max() * 1.0  # m: distance from the origin


def test_loads_that_change_with_time_on_an_engine_askew_in_space():
    """World components of a load in its plane have parts across it that cancel."""
    bare, times = vee(), np.linspace(0, 0.3, 31)
    pulse = Table(np.linspace(0, 0.3, 13), 40 * np.cos(np.arange(13) ** 2)) + Sine(9.0, 4.0, 0.3) + Ramp(20.0, 3.0)
    piston = bare.part("piston 2", "bodies")
    loads = [Force(piston, tuple(float(x) * pulse for x in TURN @ (0.4, -0.9, 0)), name="push")]
    loads.append(Torque(bare.part("rod 1", "bodies"), tuple(float(x) * pulse for x in TURN[:, 2]), name="twist"))
    system = System(bare.bodies, bare.joints, loads, bare.gravity)
    reduction = validation.reduce_to_planes(system)
    assert reduction.holds, str(reduction)
    force, moment = mount_load(simulate(system, 0.3, method=Kinematic(), output=times))
    found = reduction.block_load(times)
    assert np.abs(found.force - force).max() < 1e-11 * np.abs(force).max()
    assert np.abs(found.moment - moment).max() < 1e-11 * np.abs(moment).max()
    leaning = Force(piston, tuple(float(x) * Sine(9.0, 4.0) for x in TURN @ (0.4, -0.9, 0.02)), name="push")
    askew = validation.reduce_to_planes(System(bare.bodies, bare.joints, [leaning], bare.gravity))
    assert only(askew, "H4", "push").amount == pytest.approx(0.18)


def test_two_units_of_one_station_share_a_plane():
    reduction = validation.reduce_to_planes(vee(stations=(-0.2, -0.2, 0.3)))
    assert [plane.units for plane in reduction.planes][:2] == [("rod 1", "rod 2"), ("rod 3",)]
    assert len(reduction.planes[0].system.bodies) == 5


def test_hinges_all_along_are_recognised_too():
    """Wrist pins and crank pins as hinges, bores that let the piston turn: by their rows, not by their names."""
    pins = {
        f"wristpin {i}": lambda old: Revolute(old.a, old.b, at=old.at, axis=(0, 1, 0), name=old.name) for i in (1, 3)
    }
    pins |= {
        f"crankpin {i}": lambda old: Revolute(old.a, old.b, at=old.at, axis=(0, 1, 0), name=old.name) for i in (2, 3)
    }
    reduction = validation.reduce_to_planes(changed(inline_four(), pins))
    assert reduction.holds
    plain = validation.reduce_to_planes(inline_four()).block_load(TIMES)
    assert np.abs(reduction.block_load(TIMES).force - plain.force).max() < EXACT * single_force()


def test_h1_a_block_that_turns_adds_the_couple_of_a_gyroscope():
    """The frame turns at W about z: the shaft of spin moment C w answers with W x C w, which no plane sees."""
    precession, spin = 0.7, CRANK_RATE
    tiny = {"rod_mass": 4e-9, "rod_inertia": 3e-10, "piston_mass": 5e-9}  # the couple of the shaft alone
    still = changed(inline_four(crank_centre=0.0, **tiny), {"crank": {"inertia": (2.0, 3.0, 2.0)}})
    block = Body("block", 30.0, (2, 2, 3))
    bodies = [block, *still.bodies]
    pivot = Revolute(GROUND, block, at=(0, 0, 0), axis=(0, 0, 1), name="pivot")
    joints, new = [pivot, AngleDriver(pivot, Ramp(precession), name="yaw")], {}
    for joint in still.joints:
        if joint.name == "motor":
            joints.append(AngleDriver(new["bearing"], joint.signal, name="motor"))
        else:
            new[joint.name] = replace(joint, a=block) if joint.a is GROUND else joint
            joints.append(new[joint.name])
    system = System(bodies, joints, gravity=(0, 0, 0))
    reduction = validation.reduce_to_planes(system)
    failure = only(reduction, "H1", "block")
    assert failure.amount == pytest.approx(precession) and failure.unit == "rad/s" and not reduction.planes
    with pytest.raises(ValueError, match="(?s)block_load: .*'block' carries the axis of 'crank'"):
        reduction.block_load([0.0])
    spatial = simulate(system, TIMES[-1], method=Kinematic(), output=TIMES)
    _, moment = load(spatial, *HINGES, "motor")
    unseen = moment - validation.reduce_to_planes(still).block_load(TIMES).moment
    couple = -precession * 3.0 * spin  # of the moving parts on the frame, against W x L
    axis = spatial.rotation("block")[:, :, 1]
    assert unseen == pytest.approx(couple * np.cross((0, 0, 1), axis), abs=1e-6)  # rods and pistons: 1e-8 kg
    assert abs(couple) > 2.0


def test_h1_other_ways_to_break_it():
    driven = changed(inline_four(), {"motor": {"signal": Polynomial((0.0, CRANK_RATE, 0.15))}})
    assert only(validation.reduce_to_planes(driven), "H1", "motor").amount == pytest.approx(0.3)
    free = System(inline_four().bodies, gravity=(0, 0, 0))
    assert only(validation.reduce_to_planes(free), "H1", "system").amount == 0
    engine = inline_four()
    crank, rest = engine.part("crank"), [x for x in engine.joints if x.name not in ("bearing", "motor")]
    motor = SpeedDriver(GROUND, crank, axis=(0, 1, 0), speed=CRANK_RATE, name="motor")
    ball = Spherical(GROUND, crank, at=(0, -0.4, 0), name="ball")
    loose = validation.reduce_to_planes(System(engine.bodies, [ball, motor, *rest], gravity=(0, 0, 0)))
    assert {x.hypothesis for x in loose.failures} == {"H1"} and loose.failures[0].part == "crank"
    assert loose.failures[0].amount == 2 and "freedoms" in str(loose)
    line = PointOnLine(GROUND, crank, at=(0, 0.4, 0), axis=(0, 1, 0), name="line")
    held = validation.reduce_to_planes(System(engine.bodies, [ball, line, motor, *rest], gravity=(0, 0, 0)))
    assert held.holds  # two bearings are as good as a hinge
    plain = validation.reduce_to_planes(inline_four()).block_load(TIMES)
    assert np.abs(held.block_load(TIMES).moment - plain.moment).max() < EXACT * single_force()


def test_h2_unequal_pistons_add_up_but_are_not_identical_units():
    system = changed(inline_four(), {"piston 3": {"mass": 5.4}})
    reduction = validation.reduce_to_planes(system)
    failure = only(reduction, "H2", "rod 3")
    assert (failure.amount, failure.unit) == (pytest.approx(0.4), "kg") and "'piston 3'" in failure.text
    force, moment = load(one_turn(system), *HINGES, "motor")
    found = reduction.block_load(TIMES)
    every = load(simulate(system, TIMES[-1], method=Kinematic(), output=TIMES), *HINGES, "motor")
    assert np.abs(found.force - every[0]).max() < EXACT * single_force()
    assert np.abs(found.moment - every[1]).max() < EXACT * single_force()
    # what identical units would have hidden: a force of order 1, exactly 0.4 kg R w^2
    assert np.abs(np.fft.rfft(force[:-1, 2]))[1] * 2 / 36 == pytest.approx(
        0.4 * CRANK_RATE**2, abs=EXACT * single_force()
    )
    assert np.abs(moment).max() > 0.1 * 0.4 * CRANK_RATE**2


def test_h3_a_tilted_bore():
    tilt = np.radians(2.0)
    axis = (0.0, np.sin(tilt), np.cos(tilt))
    system = changed(inline_four(), {"bore 2": {"axis": axis, "axis_b": None}})
    reduction = validation.reduce_to_planes(system)
    failure = only(reduction, "H3", "bore 2")
    assert failure.amount == pytest.approx(2.0, rel=1e-9) and failure.unit == "deg" and not reduction.planes
    # the planes of the straight engine miss the force along the shaft
    force, _ = load(simulate(system, TIMES[-1], method=Kinematic(), output=TIMES), *HINGES)
    straight = validation.reduce_to_planes(inline_four()).block_load(TIMES).force
    unseen = np.abs(force - straight).max(axis=0)
    assert unseen[1] > 0.5 * np.sin(tilt) * 5.0 * CRANK_RATE**2 and np.abs(straight[:, 1]).max() < 1e-12


def test_h3_pins_beside_their_plane_and_bodies_free_to_leave_it():
    beside = changed(inline_four(), {"crankpin 4": {"at": (0.0, 0.33, 1.0), "at_b": (0.0, 0.33, 1.0)}})
    failure = only(validation.reduce_to_planes(beside), "H3", "crankpin 4")
    assert (failure.amount, failure.unit) == (pytest.approx(0.03), "m")
    loose = {"wristpin 1": lambda old: Spherical(old.a, old.b, at=old.at, name=old.name)}
    failure = only(validation.reduce_to_planes(changed(inline_four(), loose)), "H3", "rod 1")
    assert "free to leave" in failure.text


def test_h3_a_skew_cross_that_looks_straight_at_the_reference_pose():
    """Its axes span a plane with the normal: only a turn of the rod in its plane shows that they push it out."""
    skew = np.radians(5.0)
    axes = {"axis_a": (np.sin(skew), np.cos(skew), 0.0), "axis_b": (np.cos(skew), -np.sin(skew), 0.0)}
    failure = only(validation.reduce_to_planes(changed(inline_four(), {"wristpin 3": axes})), "H3", "wristpin 3")
    assert 0.1 < failure.amount < 5.0 and failure.unit == "deg"


def test_h4_a_product_of_inertia_in_the_crank():
    """D about its axis: the couple w^2 D turns with the shaft, and the planes show none of it."""
    product, plain = 0.05, inline_four().part("crank").inertia
    extra = product * np.array([[0, 1.0, 0], [1.0, 0, 0], [0, 0, 0]])  # with x, which is e1 or e2 of the planes
    system = changed(inline_four(), {"crank": {"inertia": plain + extra}})
    reduction = validation.reduce_to_planes(system)
    failure = only(reduction, "H4", "crank")
    assert (failure.amount, failure.unit) == (pytest.approx(product, rel=1e-9), "kg m^2")
    force, moment = load(simulate(system, TIMES[-1], method=Kinematic(), output=TIMES), *HINGES, "motor")
    found = reduction.block_load(TIMES)
    assert np.abs(found.force - force).max() < EXACT * single_force()
    unseen = np.linalg.norm(moment - found.moment, axis=1)
    assert unseen == pytest.approx(np.full(len(TIMES), CRANK_RATE**2 * product), rel=1e-10)  # rounding of 10 N m


def test_h4_bodies_that_are_not_symmetric_about_their_plane():
    inertia = np.array([[0.3, 0.02, 0], [0.02, 1 / 3, 0.01], [0, 0.01, 0.1]])
    failure = only(validation.reduce_to_planes(changed(inline_four(), {"rod 2": {"inertia": inertia}})), "H4", "rod 2")
    assert (failure.amount, failure.unit) == (pytest.approx(np.hypot(0.02, 0.01)), "kg m^2")
    off = changed(inline_four(), {"piston 1": {"com": (0.0, 0.004, 0.0)}})
    failure = only(validation.reduce_to_planes(off), "H4", "piston 1")
    assert (failure.amount, failure.unit) == (pytest.approx(0.004), "m")


def test_h4_loads_that_couple_units_or_leave_the_planes():
    engine = inline_four()
    one, two = engine.part("piston 1"), engine.part("piston 2")

    def loaded(*forces, gravity=(0, 0, 0)):
        return validation.reduce_to_planes(System(engine.bodies, engine.joints, forces, gravity))

    spring = SpringDamper(one, two, at_a=one.centre, at_b=two.centre, stiffness=9.0, name="spring")
    assert only(loaded(spring), "H4", "spring").unit == "units"
    push = Force(one, (0.0, 2.5, 1.0), name="push")
    assert only(loaded(push), "H4", "push").amount == pytest.approx(2.5)
    assert only(loaded(gravity=(0.0, 1.2, -9.0)), "H4", "gravity").amount == pytest.approx(1.2)


def test_loads_in_the_planes_are_carried():
    """Gas force, spring to the frame and weight, against the spatial engine."""
    engine = inline_four()
    pistons = [engine.part(f"piston {i}") for i in (1, 2)]
    forces = [
        Force(pistons[0], (3.0, 0, Sine(20.0, 0.5, 0.3, 4.0)), at=pistons[0].centre + [0.2, 0, 0.1], name="gas"),
        Torque(engine.part("rod 3"), (0, Ramp(4.0), 0)),
        Force(engine.part("crank"), (5.0, 0.0, -2.0), at=(0.3, -0.1, 0.4), frame="body"),
        SpringDamper(GROUND, pistons[1], at_a=(0.4, -0.1, 3.0), at_b=pistons[1].centre, stiffness=7.0, damping=2.0),
    ]
    system = System(engine.bodies, engine.joints, forces, (2.0, 0.0, -9.0))
    reduction = validation.reduce_to_planes(system)
    assert reduction.holds, str(reduction)
    force, moment = load(simulate(system, TIMES[-1], method=Kinematic(), output=TIMES), *HINGES, "motor")
    found = reduction.block_load(TIMES)
    assert np.abs(found.force - force).max() < EXACT * np.abs(force).max()
    assert np.abs(found.moment - moment).max() < EXACT * np.abs(moment).max()


def agrees(system, reduction, t_end, allowed=EXACT):
    """The sum of planes is what all joints of a spatial engine put on the ground."""
    times = np.linspace(0, t_end, 13)
    solution = simulate(system, t_end, method=Kinematic(), output=times)
    grounded = [joint.name for joint in system.joints if GROUND in joint.bodies()]
    force, moment = load(solution, *grounded)
    found = reduction.block_load(times)
    size = np.abs(force).max()
    assert np.abs(found.force - force).max() < allowed * size
    assert np.abs(found.moment - moment).max() < allowed * max(np.abs(moment).max(), size * 1.0)  # m


def test_gas_pressure_from_a_table():
    """Measured pressure is a table; scaled, and with an offset."""
    engine, times = inline_four(), np.linspace(0.0, 1.01 * TIMES[-1], 90)
    gas = Table(times, np.maximum(np.sin(CRANK_RATE * times / 2), 0.0) ** 3)
    forces = [Force(engine.part(f"piston {i}"), (0, 0, -40.0 * i * gas + 3.0), name=f"gas {i}") for i in (1, 2)]
    system = System(engine.bodies, engine.joints, forces, (0, 0, 0))
    reduction = validation.reduce_to_planes(system)
    assert reduction.holds, str(reduction)
    agrees(system, reduction, TIMES[-1])
    with pytest.raises(ValueError, match="asked for 0 s to 9 s"):
        reduction.block_load([0.0, 9.0])


def test_signals_are_judged_by_their_terms_not_by_samples():
    """A push across the planes that vanishes every sixth of a second, a speed that changes after the first turn."""
    engine = inline_four()
    push = Force(engine.part("piston 1"), (0.0, Sine(2.5, 3.0), 1.0), name="push")
    reduction = validation.reduce_to_planes(System(engine.bodies, engine.joints, [push], (0, 0, 0)))
    assert only(reduction, "H4", "push").amount == pytest.approx(2.5)
    times = np.linspace(0.0, 30.0, 31)
    late = changed(
        engine, {"motor": {"signal": Table(times, CRANK_RATE * times + 0.02 * np.maximum(times - 15.0, 0) ** 3)}}
    )
    assert only(validation.reduce_to_planes(late), "H1", "motor").unit == "rad/s^2"
    even = changed(engine, {"motor": {"signal": Table(times, CRANK_RATE * times)}})
    assert validation.reduce_to_planes(even).holds


@pytest.mark.parametrize("order", [0, 1, 2])
def test_bound_of_a_signal(order):
    cubic, time = Polynomial((0.3, -1.2, 0.7, 0.4)), 1.7
    t, knots = np.linspace(-time, time, 4001), np.array([-2.0, -1.1, 0.2, 0.9, 2.0])
    read = ("__call__", "derivative", "second_derivative")[order]
    for signal in (
        cubic,
        Sine(1.3, 0.8, 0.4),
        Table(knots, np.cos(3 * knots)),
        2.0 * cubic + Sine(0.2, 3.0),
        Ramp(2.0),
    ):
        seen, most = np.abs(getattr(signal, read)(t)).max(), bound(signal.terms(), order, time)
        assert seen <= most * (1 + 1e-12) and most <= 20.0 * seen  # triangle inequality: some terms oppose each other
    assert bound(Sine(1.3, 0.8, 0.4).terms(), order, time) == pytest.approx(1.3 * (2 * np.pi * 0.8) ** order)


def test_point_mass_pistons_need_no_inertia():
    light = changed(inline_four(), {f"piston {i}": {"inertia": (0, 0, 0)} for i in range(1, 5)})
    reduction = validation.reduce_to_planes(light)
    assert reduction.holds
    agrees(light, reduction, TIMES[-1])
    rods = changed(inline_four(), {"rod 2": {"inertia": (0, 0, 0)}})
    with pytest.raises(ValueError, match="body 'rod 2': inertia 0, but its rate can change"):
        validation.reduce_to_planes(rods).block_load([0.0])


def test_what_is_bolted_to_the_shaft_is_shaft():
    """A flywheel off its axis and a web that carries a pin: slices of their own, no units; a block at rest."""
    engine = inline_four()
    crank = engine.part("crank")
    wheel = Body("flywheel", 3.0, (0.1, 0.2, 0.1), com=(0.1, 0.0, 0.05), position=(0.0, 0.5, 0.0))
    web = Body("web", 2.0, (0.1, 0.1, 0.1), position=(0.0, 0.31, 0.8))
    block = Body("block", 5.0, (1, 1, 1), position=(0, 0, -1))
    joints = [replace(x, a=web) if x.name == "crankpin 4" else x for x in engine.joints]
    joints += [
        Fixed(web, wheel, at=(0, 0.5, 0), name="bolts"),
        Fixed(crank, web, at=(0, 0.3, 1), name="press fit"),
        Fixed(GROUND, block, at=(0, 0, -1), name="mount"),
    ]
    mount = SpringDamper(GROUND, block, at_a=(0, 0, -2), at_b=(0, 0.3, -1), stiffness=4.0)
    system = System([web, wheel, *engine.bodies, block], joints, [mount], gravity=(0, 0, 0))
    reduction = validation.reduce_to_planes(system)
    assert reduction.holds, str(reduction)
    bolted = {plane.z: plane.units for plane in reduction.planes if plane.units}
    assert bolted[0.31] == ("web",) and bolted[0.5] == ("flywheel",)
    system = System(system.bodies, joints, gravity=(0, 0, 0))  # without the pull of the mount on the block
    agrees(system, validation.reduce_to_planes(system), TIMES[-1])


def flat_engine(*units):
    """A crank about z with its centre of mass between its throws, and units (bodies, joints) made on it."""
    crank = Body("crank", 2.0, (0.1, 0.1, 0.2), com=(0.02, 0.01, 0.0))
    bearing = Revolute(GROUND, crank, at=(0, 0, -0.3), axis=(0, 0, 1), name="bearing")
    made = [unit(crank, i) for i, unit in enumerate(units, start=1)]
    joints = [bearing, AngleDriver(bearing, Ramp(9.0), name="motor"), *(x for _, own in made for x in own)]
    return System([crank, *(x for own, _ in made for x in own)], joints, gravity=(0, -9.81, 0))


def oscillating(phase, z):
    """A rod that slides in a cylinder on trunnions."""

    def unit(crank, i):
        pin, pivot = np.array([0.1 * np.cos(phase), 0.1 * np.sin(phase), z]), np.array([0.5, 0.0, z])
        along = (pivot - pin) / np.linalg.norm(pivot - pin)
        rod = Body(f"rod {i}", 0.5, (0.01, 0.01, 0.01), position=pin, com=0.1 * along)
        cylinder = Body(f"cylinder {i}", 0.7, (0.02, 0.02, 0.02), position=pivot, com=-0.05 * along)
        return [rod, cylinder], [
            Spherical(crank, rod, at=pin, name=f"pin {i}"),
            Revolute(GROUND, cylinder, at=pivot, axis=(0, 0, 1), name=f"trunnion {i}"),
            Prismatic(cylinder, rod, at=pivot, axis=along, name=f"slide {i}"),
        ]

    return unit


def massless_rod(phase, z, length=0.3):
    """A piston on a rod without mass."""

    def unit(crank, i):
        pin = np.array([0.1 * np.cos(phase), 0.1 * np.sin(phase), z])
        wrist = np.array([pin[0] + np.sqrt(length**2 - pin[1] ** 2), 0.0, z])
        piston = Body(f"piston {i}", 0.7, (0.02, 0.02, 0.02), position=wrist)
        ends = (crank, piston, pin, wrist) if i % 2 else (piston, crank, wrist, pin)
        rod = Distance(*ends[:2], at_a=ends[2], at_b=ends[3], name=f"rod {i}")
        return [piston], [rod, Prismatic(GROUND, piston, at=wrist, axis=(1, 0, 0), name=f"bore {i}")]

    return unit


@pytest.mark.parametrize("kind", [oscillating, massless_rod])
def test_other_units_up_to_phase(kind):
    system = flat_engine(kind(0.5, -0.1), kind(2.5, 0.1))
    reduction = validation.reduce_to_planes(system)
    assert reduction.holds, str(reduction)
    agrees(system, reduction, 0.7)


def test_h2_rods_of_two_lengths():
    uneven = flat_engine(massless_rod(0.5, -0.1), massless_rod(2.5, 0.1, length=0.33))
    assert only(validation.reduce_to_planes(uneven), "H2", "piston 2").amount == pytest.approx(0.03)


def test_h3_a_dead_point_frees_nothing():
    """Round bores: at the dead centre of the reference pose alone could the rods leave their planes."""
    round_bores = {f"bore {i}": lambda x: Cylindrical(x.a, x.b, at=x.at, axis=x.axis, name=x.name) for i in range(1, 5)}
    pins = {f"wristpin {i}": lambda x: Revolute(x.a, x.b, at=x.at, axis=(0, 1, 0), name=x.name) for i in range(1, 5)}
    assert validation.reduce_to_planes(changed(inline_four(), round_bores | pins)).holds
    loose = validation.reduce_to_planes(changed(inline_four(), round_bores))
    assert {x.hypothesis for x in loose.failures} == {"H3"} and "free to leave" in str(loose)


def test_what_the_planes_do_not_know_is_said():
    """A slotted yoke obeys the hypotheses, the planar models have no slot; a block on a hinge is at rest, not fixed."""

    def yoke(crank, i):
        pin = np.array([0.08, 0.06, 0.0])
        slide = Body("yoke", 0.7, (0.02, 0.02, 0.02), position=(0.08, 0, 0))
        slot = PointOnPlane(slide, crank, at=pin, normal=(1, 0, 0), name="slot")
        return [slide], [slot, Prismatic(GROUND, slide, at=(0.08, 0, 0), axis=(1, 0, 0), name="bore")]

    failure = only(validation.reduce_to_planes(flat_engine(yoke)), "H3", "slot")
    assert "planar models here know only hinges" in failure.text
    engine, block = inline_four(), Body("block", 30.0, (2, 2, 3))
    pivot, new = Revolute(GROUND, block, at=(0, 0, 0), axis=(0, 0, 1), name="pivot"), {}
    for joint in engine.joints:
        ends = {"a": block} if getattr(joint, "a", None) is GROUND else {}
        new[joint.name] = AngleDriver(new["bearing"], joint.signal) if joint.name == "motor" else replace(joint, **ends)
    free = validation.reduce_to_planes(System([block, *engine.bodies], [pivot, *new.values()], gravity=(0, 0, 0)))
    assert "'block' carries the axis of 'crank' and is not welded to the ground" in str(free)


def test_load_on_a_shaft_whose_reference_point_is_off_its_axis():
    engine, off = inline_four(), np.array([0.3, 0.2, 0.1])
    moved = changed(engine, {"crank": {"position": off, "com": engine.part("crank").com - off}})
    push = Force(moved.part("crank"), (5.0, 0.0, -2.0), at=(0.3, -0.1, 0.4), frame="body")
    system = System(moved.bodies, moved.joints, [push], (0, 0, 0))
    agrees(system, validation.reduce_to_planes(system), TIMES[-1])
