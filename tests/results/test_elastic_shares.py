"""Loads of redundant joints by stiffness: against the same mechanisms on Bushings, and rigid bodies on springs."""

from dataclasses import replace

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Bushing,
    ConstantVelocity,
    Fixed,
    Ramp,
    Revolute,
    Spherical,
    SpringDamper,
    System,
    Torque,
    accelerations,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix

R = matrix(rotation((0.3, -1.0, 0.7), 0.9))
ORIGIN, AXIS = np.array([0.4, -1.2, 2.3]), R[:, 2]
PULL = (1.2, -3.0, -8.0)
ROUNDING = 1e-9  # of the largest load: 1e4 times what the null space of rows of order one is off by


def at(x, y, z=0.0, unit=1.0):
    """A place in axes that no axis of the world is aligned with."""
    return unit * (ORIGIN + R @ np.array([x, y, z]))


def part(name, x, y, mass=1.3):
    """A body, its centre of mass beside its reference point."""
    com = 0.1 * np.array([np.sin(7.0 * mass), np.cos(3.0 * mass), np.sin(5.0 * mass) + 0.4])
    turn = rotation((0.2, 0.5, -0.1), mass)
    return Body(name, mass, mass * np.diag([0.02, 0.03, 0.04]), position=at(x, y, 0.07), com=com, orientation=turn)


def door():
    """On two hinges, held ajar by a spring."""
    leaf = part("leaf", 0.5, 0.1, 2.2)
    hold = SpringDamper(GROUND, leaf, at_a=at(1.2, 0.9, 0.4), at_b=at(0.8, -0.1, 0.3), stiffness=60.0, length=0.7)
    return [leaf], [("low", GROUND, leaf, (0, 0, -0.4)), ("top", GROUND, leaf, (0, 0, 1.1))], hold


def parallelogram():
    """A coupler on three equal cranks, on hinges: open in its plane too; held by a spring."""
    feet, arm = [(0, 0), (0.9, 0.2), (2.1, -0.1)], np.array([0.25, 0.4])
    coupler = part("coupler", 1.0, 0.5, 2.4)
    cranks = [part(f"crank {k}", foot[0], foot[1] + 0.2, 1.0 + 0.3 * k) for k, foot in enumerate(feet)]
    hinges = [(f"foot {k}", GROUND, crank, (*feet[k], 0)) for k, crank in enumerate(cranks)]
    hinges += [(f"top {k}", crank, coupler, (*(arm + feet[k]), 0)) for k, crank in enumerate(cranks)]
    hold = SpringDamper(GROUND, coupler, at_a=at(-0.8, 0.6), at_b=at(0.3, 0.5), stiffness=90.0, length=0.5)
    return [coupler, *cranks], hinges, hold


def stiffness_of(name, size):
    """General: another one of each joint."""
    k = 1.0 + 0.37 * (sum(map(ord, name)) % 7)
    return size * k, 0.02 * size * (2.0 - 0.1 * k)


def on_hinges(model):
    bodies, hinges, hold = model()
    joints = [Revolute(a, b, at=at(*place), axis=AXIS, name=name) for name, a, b, place in hinges]
    return System(bodies, joints, [hold], gravity=PULL)


def on_bushings(model, size):
    bodies, hinges, hold = model()
    mounts = []
    for name, a, b, place in hinges:
        k, turning = stiffness_of(name, size)
        mounts.append(
            Bushing(a, b, at=at(*place), axes=R, stiffness=k, turning_stiffness=(turning, turning, 0.0), name=name)
        )
    return System(bodies, [], [*mounts, hold], gravity=PULL)


def moved(state, motion):
    """A state whose bodies are displaced and turned by (dx, turn) each."""
    q, motion = state.q.reshape(-1, 7).copy(), motion.reshape(-1, 6)
    q[:, :3] += motion[:, :3]
    for e, turn in zip(q[:, 3:], motion[:, 3:], strict=True):
        half = 0.5 * np.linalg.norm(turn)
        s, v = np.cos(half), 0.5 * np.sinc(half / np.pi) * turn
        e[:] = np.append(s * e[0] - v @ e[1:], s * e[1:] + e[0] * v + np.cross(v, e[1:]))
    return replace(state, q=(q / np.linalg.norm(q[:, 3:], axis=1)[:, None] ** np.repeat([0, 1], (3, 4))).ravel())


def at_rest(system, state):
    """Where a mechanism on bushings comes to rest near a state, by Newton's method with one Jacobian."""

    def pulled(motion):
        return accelerations(system, moved(state, motion)).arrays["acceleration"][0].ravel()

    motion, h = np.zeros(state.q.size // 7 * 6), 1e-6
    slope = np.column_stack([(pulled(h * x) - pulled(-h * x)) / (2 * h) for x in np.eye(motion.size)])
    for _ in range(6):  # the Jacobian is off by 1e-5 or so
        motion = motion - np.linalg.solve(slope, pulled(motion))
    return moved(state, motion)


@pytest.mark.parametrize("model", [door, parallelogram])
def test_shares_are_those_of_bushings_as_their_stiffness_grows(model):
    rigid, off = on_hinges(model), []
    run = accelerations(rigid, rigid.equilibrium().state)
    for size in (1e7, 1e8):  # N/m: loads differ by deflections over lengths, 1e-4 and 1e-5 of the parallelogram
        soft = on_bushings(model, size)
        rest = accelerations(soft, at_rest(soft, replace(run.final, coordinates=None)))
        given = {joint: stiffness_of(joint.name, size) for joint in rigid.joints}
        loads = []
        for joint in rigid.joints:
            found, load = run.reaction(joint, shares="elastic", stiffness=given), rest.force(joint.name)
            assert not found.unique and found.margins is None
            loads.append([found.force - load.force, found.moment - load.moment])
        off.append(np.array(loads))
    largest = max(np.abs(run.reaction(joint).force).max() for joint in rigid.joints)
    assert np.abs(off[0]).max() < 2e-3 * largest
    np.testing.assert_allclose(
        10 * off[1], off[0], rtol=0, atol=1e-6 * largest + 0.01 * np.abs(off[0]).max()
    )  # as 1 / size
    assert np.abs(10 * off[1] - off[0]).max() / 9 < 1e-6 * largest  # where both go to


STATIONS = (-0.7, -0.31, 0.0, 0.42, 0.9)


def crankshaft(unit=1.0):
    """In five bearings, turning, with its mass beside the axis; lengths in metres over ``unit``."""
    turn = rotation((0.2, 0.5, -0.1), 0.4)
    shaft = Body(
        "shaft", 12.0, unit**2 * np.diag([0.9, 1.1, 0.2]), position=at(0.02, 0.05, 0.3, unit), orientation=turn,
        com=unit * np.array([0.03, -0.02, 0.06]),
    )  # fmt: skip
    bearings = [
        Revolute(GROUND, shaft, at=at(0, 0, z, unit), axis=AXIS, name=f"main {k}") for k, z in enumerate(STATIONS)
    ]
    return System([shaft], bearings, gravity=unit * np.array(PULL))


def turning_shaft(unit=1.0):
    system = crankshaft(unit)
    return simulate(system, 0.3, state=system.assemble(rates={"main 2": 31.0}), rtol=1e-11, output=5)


def springs(names, size=1e8, unit=1.0):
    """Stiffness of the bearings, which is that of springs across and along, and of springs against tilting."""
    return {name: (k, turning * unit**2) for name in names for k, turning in [stiffness_of(name, size)]}


@pytest.fixture(scope="module")
def shaft():
    return turning_shaft()


def rigid_body_on_springs(run, given):
    """How bearings give way (rows, 6) to motions of the shaft about ORIGIN, and their stiffness; 3 and 2 rows each."""
    rows, k = [], []
    for joint in run.system.joints:
        lever = np.column_stack([np.cross(w, joint.at - ORIGIN) for w in np.eye(3)])
        rows += [np.hstack([np.eye(3), lever]), np.hstack([np.zeros((2, 3)), np.array(joint.across)])]
        k += [given[joint.name][0]] * 3 + [given[joint.name][1]] * 2
    return np.vstack(rows), np.array(k)


def test_a_shaft_in_five_bearings_is_a_rigid_body_on_springs(shaft):
    given = springs([joint.name for joint in shaft.system.joints])
    B, k = rigid_body_on_springs(shaft, given)
    whole = shaft.reaction(*shaft.system.joints)  # about the first bearing
    assert whole.unique
    net = np.hstack([whole.force, whole.moment + np.cross(whole.point - ORIGIN, whole.force)])
    motion = np.linalg.lstsq(B.T @ (k[:, None] * B), net.T, rcond=1e-12)[0]
    loads = (k[:, None] * (B @ motion)).reshape(5, 5, -1)
    for joint, load in zip(shaft.system.joints, loads, strict=True):
        found = shaft.reaction(joint, shares="elastic", stiffness=given)
        np.testing.assert_allclose(found.force, load[:3].T, rtol=0, atol=ROUNDING * np.abs(net).max())
        np.testing.assert_allclose(
            found.moment, load[3:].T @ np.array(joint.across), rtol=0, atol=ROUNDING * np.abs(net).max()
        )


def test_the_range_is_what_springs_carry_that_are_as_far_off_as_they_may_be(shaft):
    names = [joint.name for joint in shaft.system.joints]
    given, off = springs(names), {name: (1e-5 * (1 + k), 2e-5 * (6 - k)) for k, name in enumerate(names)}
    B, k = rigid_body_on_springs(shaft, given)
    d = np.concatenate([[off[name][0]] * 3 + [off[name][1]] * 2 for name in names])
    sqrt_k = np.sqrt(k)[:, None]
    stays = np.eye(25) - sqrt_k * B @ np.linalg.pinv(sqrt_k * B, rcond=1e-12)
    stretch = sqrt_k * stays * sqrt_k.T  # loads of springs by what each is too long
    for j, joint in enumerate(shaft.system.joints):
        found = shaft.reaction(joint, shares="range", stiffness=given, tolerances=off)
        mine = slice(5 * j, 5 * j + 5)
        force = np.abs(stretch[mine][:3]) @ d
        np.testing.assert_allclose(found.force_margin[0], force, rtol=1e-9)
        tilting = np.array(joint.across).T @ stretch[mine][3:]
        np.testing.assert_allclose(found.moment_margin[0], np.abs(tilting) @ d, rtol=1e-9)
        own = shaft.reaction(joint, shares="range", stiffness=given, tolerances=off, axes="joint")
        along = np.abs(AXIS @ stretch[mine][:3]) @ d
        np.testing.assert_allclose(own.force_margin[0, 2], along, rtol=1e-9)


def test_shares_and_ranges_do_not_know_the_unit_of_length(shaft):
    names = [joint.name for joint in shaft.system.joints]
    fine, off = turning_shaft(1000.0), (1e-5, 2e-5)  # millimetres, so forces in mN
    for name in names:
        one = shaft.reaction(name, shares="range", stiffness=springs(names), tolerances=off)
        other = fine.reaction(
            name, shares="range", stiffness=springs(names, unit=1000.0), tolerances=(1000.0 * off[0], off[1])
        )
        for kind, factor in (("force", 1e3), ("moment", 1e6), ("force_margin", 1e3), ("moment_margin", 1e6)):
            expected = getattr(one, kind)
            atol = 1e-7 * factor * np.abs(expected).max(initial=1.0)  # two runs of their own steps
            np.testing.assert_allclose(getattr(other, kind), factor * expected, rtol=0, atol=atol)


def test_the_loads_of_all_elastic_joints_add_up_to_those_of_any_other_shares(shaft):
    given = springs([joint.name for joint in shaft.system.joints])
    both = [shaft.reaction("main 1", "main 3", shares="elastic", stiffness=given)]
    both += [shaft.reaction(name, shares="elastic", stiffness=given) for name in ("main 1", "main 3")]
    np.testing.assert_allclose(
        both[0].force, both[1].force + both[2].force, rtol=0, atol=1e-9 * np.abs(both[0].force).max()
    )


def test_what_is_determined_stays_and_needs_no_stiffness_of_others():
    leaf, far = part("leaf", 0.5, 0.1, 2.2), part("far", 3.0, 0.4, 1.1)
    joints = [Spherical(GROUND, leaf, at=at(0, -0.4), name="low"), Spherical(GROUND, leaf, at=at(0.1, 1.1), name="top"),
              Revolute(leaf, far, at=at(2.0, 0.3), axis=R[:, 1], name="arm")]  # fmt: skip
    run = accelerations(System([leaf, far], joints, gravity=PULL))
    one, other = (
        run.reaction("low", shares="elastic", stiffness={"low": (k, 1.0), "top": (3e7, 1.0)}) for k in (1e6, 1e8)
    )
    np.testing.assert_allclose(
        one.determined_force, other.determined_force, rtol=0, atol=1e-10 * np.abs(one.force).max()
    )
    assert np.abs(one.force - other.force).max() > 0.1
    alone = run.reaction("arm", shares="range", stiffness=(1.0, 1.0), tolerances=(1e-3, 1e-3))
    assert alone.unique and not alone.force_margin.any() and not alone.moment_margin.any()
    np.testing.assert_array_equal(alone.force, run.reaction("arm").force)


def test_a_bent_constant_velocity_joint_takes_half_of_the_torque_beside_a_weld_as_stiff():
    bend = 0.8
    a, b = R[:, 0], np.cos(bend) * R[:, 0] + np.sin(bend) * R[:, 1]
    bisector = (a + b) / np.linalg.norm(a + b)
    block = part("block", 0.1, 0.2)
    joint = ConstantVelocity(GROUND, block, at=at(0, 0), axis_a=a, axis_b=b, name="bent")
    weld = Fixed(GROUND, block, at=at(0, 0), name="weld")
    twisted = System([block], [joint, weld], [Torque(block, 7.0 * bisector)], gravity=(0, 0, 0))
    found = accelerations(twisted).reaction(joint, shares="elastic", stiffness=(1e8, 1e5))
    np.testing.assert_allclose(found.moment[0], -3.5 * bisector, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (dict(shares="stiff"), "'stiff' is unknown; give 'least norm' or 'elastic' or 'range'"),
        (dict(shares="elastic"), "needs stiffness"),
        (dict(shares="range", stiffness=(1e8, 1e5)), "needs tolerances"),
        (dict(stiffness=(1e8, 1e5)), 'shares="least norm" uses no stiffness'),
        (dict(shares="elastic", stiffness=(1e8, 1e5), tolerances=(0, 0)), "uses no tolerances"),
        (dict(shares="elastic", stiffness={"top": (1e8, 1e5)}), "'low' shares the load, and nothing is given of it"),
        (dict(shares="elastic", stiffness={"lid": (1e8, 1e5)}), "'lid' is not one of the joints"),
        (dict(shares="elastic", stiffness=1e8), "every joint: 100000000.0 is not a sequence"),
        (dict(shares="elastic", stiffness={"top": (1e8, 0.0), None: (1, 1)}), "of 'top': 0.0 is not positive"),
        (dict(shares="range", stiffness=(1, 1), tolerances=(-1e-5, 0)), "tolerances of every joint: -1e-05 is below 0"),
    ],
)  # fmt: skip
def test_what_is_missing_or_wrong_is_named(given, said):
    run = accelerations(on_hinges(door))
    with pytest.raises(ValueError) as twice:
        run.reaction("top", shares="elastic", stiffness={"low": (1, 1), run.system.joints[0]: (1, 1)})
    assert "'low' is given twice" in str(twice.value)
    with pytest.raises(ValueError) as caught:
        run.reaction("top", **given)
    assert said in str(caught.value)


def test_rounding_makes_no_joint_share_loads():
    """A leaf on three joints of a table that a motor turns: the table's own hinge shares nothing, at any pose."""
    table, leaf = part("table", 0.3, -0.2, 5.0), part("leaf", 0.5, 0.1, 3.0)
    turn = Revolute(GROUND, table, at=at(0.05, 0.02), axis=R[:, 1], name="turn")
    joints = [Revolute(table, leaf, at=at(0, 0, z), axis=AXIS, name=f"hinge {z}") for z in (-0.4, 0.13)]
    joints.append(Spherical(table, leaf, at=at(0, 0, 0.55), name="ball"))
    system = System([table, leaf], [turn, AngleDriver(turn, Ramp(2.0), name="motor"), *joints])
    run = simulate(system, 3.0, state=system.assemble(rates={joints[0]: 7.0}), output=13)
    given = {joint: (1e7, 1e3) for joint in joints}
    found = [run.reaction(joint, shares="elastic", stiffness=given) for joint in joints]
    whole = run.reaction(*joints)
    assert whole.unique
    np.testing.assert_allclose(sum(x.force for x in found), whole.force, rtol=0, atol=1e-9 * np.abs(whole.force).max())
