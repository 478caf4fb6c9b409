"""Wheels on five links: against twist by Plücker lines, virtual work, and a quarter car with an inerter."""

from dataclasses import replace

import numpy as np
import pytest

from engines import closed_forms
from engines.nvh.mounts import mounts
from engines.nvh.road.guide import Guide, guide
from engines.nvh.road.profile import Road
from engines.nvh.road.ride import Ride
from engines.nvh.road.vehicle import Vehicle
from mbsd3d import Kinematic, simulate
from validation import theory

WHEEL_INERTIA_RATIO = 0.05  # [m^2] inertia of a wheel over its mass
BODY_HEIGHT = 0.25  # [m] of a body's centre of mass above the wheels' centres

KINDS = ("double wishbone", "multilink")
TRACK = 1.55


def velocity(held: Guide, point: np.ndarray) -> np.ndarray:
    """(3,) of a point of the upright per velocity of the wheel's centre upwards, at the reference pose."""
    found = theory.five_link_twist(held.links.values(), held.centre, np.eye(3), np.zeros(3))
    return found[:3] + np.cross(found[3:], np.subtract(point, held.centre))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_toe_camber_and_track_over_the_travel(kind, way):
    held = guide(kind, TRACK)
    z = held.curves.z[held.curves.z * way > 0][:: int(way)]
    shift, turn = theory.five_link_poses(held.links.values(), held.centre, np.concatenate([[0.0], z]))
    axle = turn[1:, :, 1]
    chosen = np.isin(held.curves.z, z)
    # the integration holds 1e-12 over a travel of 0.08 m
    assert held.curves.toe[chosen][:: int(way)] == pytest.approx(np.arctan2(axle[:, 0], axle[:, 1]), abs=1e-9)
    assert held.curves.camber[chosen][:: int(way)] == pytest.approx(-np.arcsin(axle[:, 2]), abs=1e-9)
    down = axle * axle[:, 2:] - [0, 0, 1.0]
    out = shift[1:, 1] + held.centre[2] * down[:, 1] / np.linalg.norm(down, axis=1)
    assert held.curves.track[chosen][:: int(way)] == pytest.approx(out, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_slopes_at_rest(kind):
    held = guide(kind, TRACK)
    curves = held.curves
    at = np.abs(curves.z).argmin()
    assert curves.z[at] == pytest.approx(0.0, abs=1e-12)
    inner, outer = np.array(held.strut)
    along = (outer - inner) / np.linalg.norm(outer - inner)
    assert curves.ratio[at] == pytest.approx(along @ velocity(held, outer), rel=1e-9)
    lowest = np.array([*held.centre[:2], 0.0])
    slope = velocity(held, lowest)
    assert curves.ahead[at] == pytest.approx(slope[0] / slope[2], rel=1e-9)
    assert curves.roll_centre[at] == pytest.approx(lowest[1] * slope[1] / slope[2], rel=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_toe_in_is_positive_when_the_wheel_points_at_the_middle(kind):
    held, run = guide(kind, TRACK), guide(kind, TRACK).run()
    front = run.rotation("wheel") @ [1.0, 0, 0]
    assert np.array_equal(np.sign(held.curves.toe), np.sign(-front[:, 1]))
    top = run.rotation("wheel") @ [0, 0, 1.0]
    assert np.array_equal(np.sign(held.curves.camber), np.sign(top[:, 1]))


def test_force_of_the_plate_is_that_of_the_strut_by_virtual_work():
    held = guide("multilink", TRACK)
    rig = held.rig()
    strut = replace(rig.forces[0], stiffness=30e3)
    slow = replace(rig, forces=[strut])
    run = simulate(slow, 1.25, method=Kinematic(), output=1.0 + np.array([-0.1, 0.03, 0.11]))
    law = run.force("strut")
    # the inertia of the plate and of the upright at 1 Hz is taken out with the run without a spring
    bare = simulate(rig, 1.25, method=Kinematic(), output=run.t)
    effort = run.effort("road") - bare.effort("road")
    tension = 30e3 * (law.length - strut.length)
    assert effort == pytest.approx(tension * law.rate / run.velocity("wheel")[:, 2], rel=1e-9)


def test_links_bear_their_share_of_the_pitching_of_braking():
    """Virtual work of braking forces and of the load they move, on the body held, by the twist alone."""
    car = Vehicle("whole", mounts.car("saloon").ride)
    share, wheelbase, height = car.ride["brakes"], car.ride["wheelbase"], 0.55
    for held, part, load, found in zip(car.guides, (share, 1 - share), (1.0, -1.0), car.anti, strict=True):
        slope = velocity(held, np.array([*held.centre[:2], 0.0]))
        braking, moved = np.array([-part, 0.0, 0.0]), np.array([0.0, 0.0, load * height / wheelbase])
        assert found == pytest.approx(-(braking @ slope) / (moved @ slope), rel=1e-9)
        assert 0.1 < found < 0.9


@pytest.mark.parametrize("kind", ["half", "whole"])
def test_the_load_of_a_strut_is_part_of_the_stiffness_at_its_wheel(kind):
    """``T dr/dz / k_w`` with T = load / r: the rest is that of the spring, ``k r^2 / k_w``."""
    car = Vehicle(kind, mounts.car("saloon").ride | {"front": 0.57}, linked=True)
    struts = {strut.name: strut for strut in car.system().forces}
    for held, corner, found in zip(car.guides, (car.corners[0], car.corners[-1]), car.by_load, strict=True):
        z, ratio, strut = held.curves.z, held.curves.ratio, struts[f"spring of {corner.name}"]
        middle = z.size // 2
        load = corner.load / ratio[middle]
        one, two = (load * (ratio[middle + k] - ratio[middle - k]) / (z[middle + k] - z[middle - k]) for k in (1, 2))
        # a difference over h is off by a third of what that over 2 h differs by
        assert found * corner.spring == pytest.approx(one, abs=0.5 * abs(two - one))
        assert found == pytest.approx(1.0 - strut.stiffness * ratio[middle] ** 2 / corner.spring, abs=1e-12)
    assert abs(car.by_load[0] - car.by_load[1]) > 0.1 * abs(car.by_load[0])


@pytest.mark.parametrize("car", ["compact", "saloon"])
def test_small_motions_of_a_linked_quarter_car_are_those_with_an_inerter(car):
    """What the links let the wheel move sideways and turn adds b (z_s'' - z_u''), b from the twist alone."""
    linked, w = Vehicle("quarter", mounts.car(car).ride, linked=True), 2 * np.pi * np.geomspace(0.3, 40.0, 17)
    (corner,) = linked.corners
    twist = theory.five_link_twist(linked.guides[0].links.values(), linked.guides[0].centre, np.eye(3), np.zeros(3))
    inerter = corner.mass * (twist[0] ** 2 + twist[1] ** 2 + WHEEL_INERTIA_RATIO * twist[3:] @ twist[3:])
    assert inerter > 0.005 * corner.mass
    push = corner.tyre + 1j * w * corner.tyre_damping
    found = linked.small_motions.frequency_response(w).H[..., 0] * push[:, None]
    rates = (corner.spring, corner.damper), (corner.tyre, corner.tyre_damping)
    for column, known in enumerate(closed_forms.quarter_car(w, (linked.mass, corner.mass), *rates, inerter)):
        # the motion ratio is read from the rig at rest to 1e-12, the strut has no preload
        assert found[:, column] == pytest.approx(known, rel=1e-7)


def test_a_tyre_that_rolls_damps_what_links_make_of_its_travel():
    """The side force of its slip angle at the lowest point, by the twist alone: a damper beside the strut."""
    ride, speed = mounts.car("compact").ride | {"cornering": [63e3, 0.0]}, 17.0
    rolling, w = Vehicle("quarter", ride, linked=True, speed=speed), 2 * np.pi * np.geomspace(0.3, 40.0, 17)
    (corner,) = rolling.corners
    held = rolling.guides[0]
    twist = theory.five_link_twist(held.links.values(), held.centre, np.eye(3), np.zeros(3))
    inerter = corner.mass * (twist[0] ** 2 + twist[1] ** 2 + WHEEL_INERTIA_RATIO * twist[3:] @ twist[3:])
    aside = velocity(held, np.array([*held.centre[:2], 0.0]))[1]
    damper = corner.damper + 63e3 / speed * aside**2
    assert damper > 1.005 * corner.damper
    push = corner.tyre + 1j * w * corner.tyre_damping
    found = rolling.small_motions.frequency_response(w).H[..., 0] * push[:, None]
    rates = (corner.spring, damper), (corner.tyre, corner.tyre_damping)
    for column, known in enumerate(closed_forms.quarter_car(w, (rolling.mass, corner.mass), *rates, inerter)):
        assert found[:, column] == pytest.approx(known, rel=1e-7)


@pytest.mark.parametrize("linked", [False, True])
def test_a_half_car_has_the_modes_of_a_whole_one_that_does_not_roll(linked):
    """Mirrored links on the right: heave and pitch of the whole car are those of its left half."""
    ride = mounts.car("saloon").ride
    half, whole = (Vehicle(kind, ride, linked).small_motions.poles for kind in ("half", "whole"))
    assert half.size == 8 and whole.size == 14
    for value in half:
        # accelerations of five bodies on twenty links hold 1e-10
        assert np.abs(whole - value).min() < 1e-8 * abs(value)


def dive(ride: dict, share: float, ways: list[tuple[float, float]]) -> float:
    """Angle of a braked car by small motions, a left half of it: heave, pitch and two wheels.

    With e = z_w - z + x a the travel of a wheel whose centre goes ahead by X e, its lowest point by P e (``ways``):
    energy ``k e^2 / 2 + W (X e a - H a^2 / 2)`` of a strut under the load W, and ``k_t z_w^2 / 2`` of a tyre.
    """
    K, Q, force = np.zeros((4, 4)), np.zeros(4), share * 9.81 * ride["mass"] / 2
    pitch, up = np.eye(4)[1], BODY_HEIGHT + 0.3  # of the upper ends of the struts
    for axle, (ahead, lowest) in enumerate(ways):
        front = (ride["front"], 1 - ride["front"])[axle]
        x, load = (1 - front) * ride["wheelbase"] * (1, -1)[axle], front * 9.81 * ride["mass"] / 2
        e = np.array([-1.0, x, 1.0, 0.0] if axle == 0 else [-1.0, x, 0.0, 1.0])
        K += ride["spring"][axle] * np.outer(e, e) + load * ahead * (np.outer(e, pitch) + np.outer(pitch, e))
        K[1, 1] -= load * BODY_HEIGHT
        K[2 + axle, 2 + axle] += ride["tyre"][axle]
        Q += force * (ride["brakes"], 1 - ride["brakes"])[axle] * (up * pitch - lowest * e)
    return float(np.linalg.solve(K, Q)[1])


@pytest.mark.parametrize("kind", ["half", "whole"])
def test_a_braked_car_dives_by_what_its_links_do_not_bear(kind):
    """Slopes of the wheels' paths by the twist alone."""
    ride, share = mounts.car("compact").ride, 1e-3
    for linked in (False, True):
        car = Vehicle(kind, ride, linked)
        ways = [
            (velocity(held, held.centre)[0], velocity(held, np.array([*held.centre[:2], 0.0]))[0])
            for held in car.guides
        ]  # fmt: skip
        # second order: 2e-4 at a thousandth of g, ten times more at a hundredth
        assert car.braked(share) == pytest.approx(dive(ride, share, ways if linked else [(0, 0), (0, 0)]), rel=3e-4)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["quarter", "half", "whole"])
def test_a_linked_car_over_the_road(kind):
    ride = Ride(Vehicle(kind, mounts.car("compact").ride, linked=True), Road("B", 190.0, seed=2), 35.0)
    assert ride.run.certificate.passed
    assert 1e-5 < ride.difference < 0.02  # arcs of the links over 10 mm of travel


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (dict(links={}), "0 links; a wheel needs 5"),
        (dict(strut=((0, 0.7, 0.3), (0, 0.7, 0.3))), "strut has no length"),
        (dict(centre=(0, 0.7, 0.0)), r"centre\[2\]"),
        (dict(links={str(k): ((0.1 * k, 0.3, 0.2), (0.1 * k, 0.7, 0.2)) for k in range(5)}), "motions free"),
    ],
)
def test_links_that_do_not_hold_a_wheel_are_refused(change, text):
    with pytest.raises(ValueError, match=text):
        replace(guide("multilink", TRACK), **change)


def test_unknown_guides_are_refused():
    with pytest.raises(ValueError, match="there are double wishbone"):
        guide("swing axle", TRACK)
