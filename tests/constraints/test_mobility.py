"""Freedoms that are lost beside a pose: infinitesimal mobility, and wheels without a common turning centre."""

import numpy as np
import pytest

from mbsd3d import (
    GROUND,
    RK4,
    AngleDriver,
    Body,
    Distance,
    Force,
    GeneralizedAlpha,
    IntegrationError,
    Ramp,
    Revolute,
    RollingDisc,
    Spherical,
    System,
    Torque,
    Universal,
    linkages,
    rotation,
    simulate,
)
from mbsd3d.rotations import matrix
from validation import cases

TILT = rotation((0.3, -1.0, 0.7), 0.9)
R = matrix(TILT)


def at(x, y, z=0.0):
    return np.array([0.4, -1.2, 2.3]) + R @ np.array([x, y, z])


def rod(name, x, y):
    """Its centre of mass beside its reference point and out of the plane."""
    return Body(name, 1.3, (0.03, 0.04, 0.05), position=at(x, y, 0.1), com=(0.03, -0.02, 0.05), orientation=TILT)


def hinge(a, b, place, name):
    return Revolute(a, b, at=at(*place), axis=R[:, 2], name=name)


def ball(a, b, place, name):
    return Spherical(a, b, at=at(*place), name=name)


def stretched(pin=hinge, lift=0.0):
    """Two rods between fixed pins, in one line if ``lift`` is zero: shaky, and no mechanism."""
    a, b = rod("a", 0.3, 0.1), rod("b", 1.2, 0.1)
    return System(
        [a, b], [pin(GROUND, a, (0, 0), "left"), pin(a, b, (0.7, lift), "knee"), pin(b, GROUND, (1.9, 0), "right")]
    )


def platform(lengths, lean=0.3):
    """On three parallel legs: a parallelogram if they are of one length, shaky else."""
    top, legs, joints = rod("platform", 0.8, 1.2), [], []
    for k, (length, foot) in enumerate(zip(lengths, ((0, 0), (1.0, 0.1), (1.7, 0.2)), strict=True)):
        head = np.array(foot) + length * np.array([np.sin(lean), np.cos(lean)])
        legs.append(rod(f"leg {k}", *(0.5 * (head + foot))))
        joints += [hinge(GROUND, legs[-1], foot, f"foot {k}"), hinge(legs[-1], top, head, f"head {k}")]
    return System([top, *legs], joints)


def infinitesimal(system):
    """What check says of lost mobility; "" for none."""
    return next((note for note in system.check().notes if note.startswith("infinitesimal")), "")


@pytest.mark.parametrize(
    ("system", "mobility", "joints"),
    [
        (stretched(), 1, ("left", "knee", "right")),
        (stretched(ball), 4, ("left", "knee", "right")),  # both rods also spin, and go on doing so
        (platform((1.0, 1.3, 0.8)), 1, ("foot 0", "head 2")),
        (platform((1.0, 1.0, 1.001)), 1, ("foot 0", "head 2")),  # a millimetre more in one leg
    ],
)
def test_what_gives_way_and_moves_nowhere_is_infinitesimal(system, mobility, joints):
    found, said = system.check(), infinitesimal(system)
    assert found.mobility == mobility and said in str(found)
    assert said.startswith(f"infinitesimal: mobility {mobility}") and all(f"'{name}'" in said for name in joints)


@pytest.mark.parametrize("system", [stretched(lift=0.2), platform((1.0, 1.0, 1.0)), platform((1.0, 1.0, 1.0), -1.1)])
def test_a_structure_and_a_parallelogram_are_not(system):
    assert not system.check().notes


def test_mechanisms_of_textbooks_keep_their_mobility():
    """Redundant ones above all: what is free at their poses is free beside them."""
    a, alpha, beta = 0.7, 0.6, 1.9
    found = [
        linkages.bennett(a, alpha, a * np.sin(beta) / np.sin(alpha), beta, 0.9),
        linkages.sarrus((0.5, 0.6), (0.45, 0.7), 1.9, 0.8, reach=0.2),
        linkages.bricard(0.8, 1.1),
    ]
    assert not any(infinitesimal(system) for system in found)
    assert [name for name in cases.names() if infinitesimal(cases.load(name).system)] == []


@pytest.mark.parametrize("method", [RK4(2e-3), GeneralizedAlpha(1e-2)])
def test_a_run_of_a_shaky_structure_names_it(method):
    """A load across it would take infinite forces; the run ends long after its start."""
    with pytest.raises(IntegrationError, match="mobility at the start is infinitesimal: .*'knee' and 'right' give way"):
        simulate(stretched(), 1.0, method=method)


def test_a_run_that_gets_through_a_shaky_structure_fails_and_names_it():
    """Adaptive steps of GeneralizedAlpha go on where the reactions are huge; no check of balances passes."""
    certificate = simulate(stretched(), 1.0, method=GeneralizedAlpha()).certificate
    assert not certificate.passed and "the mobility at the start is infinitesimal" in str(certificate)


# -- wheels ------------------------------------------------------------------------------------------------------------

RADIUS, BASE = 0.3, 1.17
HEADING = matrix(rotation("z", 0.7))  # no axle aligned
CORNER = np.array([2.1, -1.3, 0.0])


def place(x, y, z=RADIUS):
    return CORNER + HEADING @ np.array([x, y, z])


def member(name, x, y, z=RADIUS, mass=3.0):
    inertia = mass * np.array([0.02, 0.03, 0.025])
    return Body(name, mass, inertia, position=place(x, y, z), com=(0.01, 0.02, -0.01), orientation=rotation("z", 0.7))


def cart(rear, half=0.37, arm=0.9, rake=0.0):
    """A frame with front wheels on kingpins, coupled by a tie rod, and rear wheels at ``rear`` [m] from its middle."""
    frame = member("frame", -0.4, 0.05, 0.5, 60.0)
    bodies, joints = [frame], []

    def wheel(name, x, y, carrier):
        body = Body(name, 2.0, (0.05, 0.09, 0.05), position=place(x, y), orientation=rotation("z", 0.7))
        bodies.append(body)
        joints.append(Revolute(carrier, body, at=place(x, y), axis=HEADING[:, 1], name=f"{name} axle"))
        joints.append(RollingDisc(GROUND, body, axis=HEADING[:, 1], radius=RADIUS, name=f"{name} tread"))

    for k, y in enumerate(rear):
        wheel(f"rear {k}", -BASE, y, frame)
    knuckles = []
    for name, side in (("left", 1), ("right", -1)):
        knuckle = member(f"{name} knuckle", 0.0, half * side)
        knuckles.append(knuckle)
        bodies.append(knuckle)
        axis = HEADING @ (np.sin(rake), 0.0, np.cos(rake))
        joints.append(Revolute(frame, knuckle, at=place(0.0, half * side), axis=axis, name=f"{name} kingpin"))
        wheel(name, 0.0, (half + 0.05) * side, knuckle)
    ends = [place(-0.15, side * arm * half) for side in (1, -1)]
    if rake:  # a rod without mass
        return System(bodies, [*joints, Distance(*knuckles, at_a=ends[0], at_b=ends[1], name="tie rod")])
    rod_ = member("tie rod", -0.15, 0.0, mass=0.5)
    joints.append(Spherical(knuckles[0], rod_, at=ends[0], name="left end"))
    joints.append(Universal(knuckles[1], rod_, at=ends[1], axis_a=(0, 0, 1), axis_b=HEADING[:, 0], name="right end"))
    return System([*bodies, rod_], joints)


@pytest.mark.parametrize(
    ("system", "mobility"),
    [(cart((0.04,)), 2), (cart((0.04,), arm=1.0), 2), (cart((0.04,), rake=0.2), 2), (cart((0.45, -0.4)), 2)],
)
def test_wheels_without_a_common_turning_centre_are_named(system, mobility):
    """Straight ahead it rolls and can be steered, steered it rolls no more: a trapezoid is right at one angle only."""
    found, said = system.check(), infinitesimal(system)
    assert found.mobility == mobility and f"mobility {mobility} in this pose alone, {mobility - 1} beside it" in said
    assert "'left tread' and 'right tread' have no common turning centre" in said and "use Tyre" in said
    assert "'left kingpin'" in said and "'right kingpin'" in said and "rear" not in said
    rows = found.rows - (found.rank + 1)  # that are redundant beside it: none of three wheels, two of four
    assert {cure.rows_removed for cure in found.cures} == ({rows} if rows else set())


def test_a_run_that_steers_names_the_wheels():
    system = cart((0.04,))
    knuckle = system.part("left knuckle")
    for load in (Torque(knuckle, (0, 0, 1.0)), Force(knuckle, (3.0, 9.0, 0.0), at=place(0.2, 0.4))):
        steered = System(system.bodies, system.joints, [load])
        run = simulate(steered, 1.0, state=steered.assemble(rates={"rear 0 axle": 5.0}))
        assert not run.certificate.passed
        assert "the mobility at the start is infinitesimal" in str(run.certificate)
        assert "'left tread' and 'right tread' have no common turning centre" in str(run.certificate)


def test_a_driver_that_will_steer_is_seen_and_one_that_holds_is_not():
    system = cart((0.04,))
    (king,) = (joint for joint in system.joints if joint.name == "left kingpin")
    held = System(system.bodies, [*system.joints, AngleDriver(king, 0.0, name="lock")])
    led = System(system.bodies, [*system.joints, AngleDriver(king, Ramp(0.3), name="steering")])
    assert held.check().mobility == led.check().mobility == 1
    assert not infinitesimal(held) and "no common turning centre" in infinitesimal(led)
    straight = simulate(held, 1.0, state=held.assemble(rates={"rear 0 axle": 5.0}))
    assert straight.certificate.passed and "infinitesimal" not in str(straight.certificate)
    ahead = straight.position("frame") - straight.position("frame")[0]
    assert np.abs(np.cross(ahead, HEADING[:, 0])).max() < 1e-9 and np.ptp(ahead @ HEADING[:, 0]) > 0.5  # m
