"""Cars at rest under their weight, and what a loaded strut does to the stiffness at the wheel."""

import re

import numpy as np
import pytest

from engines.nvh.mounts import mounts
from engines.nvh.road.guide import Guide, guide
from engines.nvh.road.report import lifted, preloads, ride_of
from engines.nvh.road.vehicle import Vehicle
from mbsd3d import Body, accelerations
from validation import theory

PIVOT, CENTRE = np.array([0.42, 0.0, 0.37]), np.array([0.05, 0.755, 0.29])
STRUT = np.array([[-0.21, 0.52, 0.62], [0.11, 0.63, 0.21]])


def swing_arm() -> Guide:
    """A trailing arm: all links start on the axis through the pivot along y, so that the wheel turns about it."""
    inner = [PIVOT + (0, y, 0) for y in (0.31, 0.44, 0.52, 0.66, 0.71)]
    outer = [(0.03, 0.71, 0.17), (0.08, 0.65, 0.43), (-0.04, 0.69, 0.33), (0.01, 0.73, 0.25), (0.09, 0.62, 0.31)]
    links = {str(k): ends for k, ends in enumerate(zip(inner, outer, strict=True))}
    return Guide("swing arm", CENTRE, links, STRUT)


def of_swing_arm(z: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(s, ds/dz, d2s/dz2) of its strut: the law of cosines over the angle a that lifts the wheel to z."""
    arm, body, wheel = (point[[0, 2]] - PIVOT[[0, 2]] for point in (CENTRE, *STRUT))
    radius, rest = np.hypot(*arm), np.arctan2(arm[1], -arm[0])
    a = np.arcsin((arm[1] + z) / radius) - rest
    dz, ddz = radius * np.cos(rest + a), -radius * np.sin(rest + a)
    b, w = np.hypot(*body), np.hypot(*wheel)
    between = np.arctan2(body[1], -body[0]) - np.arctan2(wheel[1], -wheel[0]) - a
    s = np.sqrt(b**2 + w**2 - 2 * b * w * np.cos(between) + (STRUT[1, 1] - STRUT[0, 1]) ** 2)
    ds = -b * w * np.sin(between) / s
    dds = (b * w * np.cos(between) - ds**2) / s
    return s, ds / dz, (dds * dz - ds * ddz) / dz**3


def test_a_loaded_swing_arm_has_the_stiffness_of_its_closed_form():
    """Over the travel, and of the strut that carries a load: T r = W and k r^2 + T dr/dz = k_w."""
    held, load, stiffness = swing_arm(), 3100.0, 24e3
    _, ratio, bend = of_swing_arm(held.curves.z)
    assert held.curves.ratio == pytest.approx(ratio, rel=1e-9)
    # second derivatives of a run that holds 1e-12
    assert held.curves.bend == pytest.approx(bend, rel=1e-7)
    s, ratio, bend = of_swing_arm(np.zeros(1))
    strut = held.spring(Body("body", 900.0, (1, 1, 1)), held.upright(30.0, "wheel"), stiffness, 1500.0, load, "strut")
    tension = strut.stiffness * (s - strut.length)
    assert tension * ratio == pytest.approx(load, rel=1e-9)
    assert strut.stiffness * ratio**2 + tension * bend == pytest.approx(stiffness, rel=1e-8)
    assert abs(tension * bend) > 0.05 * stiffness


@pytest.mark.parametrize("kind", ["double wishbone", "multilink"])
def test_how_the_motion_ratio_of_links_changes(kind):
    held, step = guide(kind, 1.5), 2e-3
    inner, outer = held.strut
    lengths = []
    for way in (1.0, -1.0):
        shift, turn = theory.five_link_poses(held.links.values(), held.centre, way * np.array([0.0, step, 2 * step]))
        ends = held.centre + shift + turn @ (outer - held.centre)
        lengths.append(np.linalg.norm(ends - inner, axis=1))
    (rest, up, high), (_, down, low) = lengths
    second = (16 * (up + down) - (high + low) - 30 * rest) / (12 * step**2)
    # fourth order in a step of 2 mm of curves that change over 0.1 m
    assert held.curves.at("bend", 0.0) == pytest.approx(second, rel=1e-5)


@pytest.mark.parametrize("linked", [False, True])
@pytest.mark.parametrize("kind", ["quarter", "half", "whole"])
def test_the_reference_pose_is_the_car_at_rest(kind, linked):
    car = Vehicle(kind, mounts.car("saloon").ride | {"guides": ["multilink", "double wishbone"]}, linked, 23.0)
    system = car.system()
    still = accelerations(system)
    for body in system.bodies:
        assert still.acceleration(body.name) == pytest.approx(0.0, abs=1e-10 * 9.81)
        assert still.alpha(body.name) == pytest.approx(0.0, abs=1e-10 * 9.81)
    weight = 9.81 * sum(body.mass for body in system.bodies)
    borne = sum(float(force.force[2](0.0)) for force in system.forces if force.name.startswith("weight on"))
    assert borne == pytest.approx(weight, rel=1e-12)
    for body, place in zip(system.bodies, system.equilibrium().state.q.reshape(-1, 7), strict=True):
        assert place[:3] == pytest.approx(body.position, abs=1e-9)


def test_a_strut_that_is_too_soft_for_its_load_is_refused():
    held = guide("double wishbone", 1.5)
    body, upright = Body("body", 900.0, (1, 1, 1)), held.upright(30.0, "wheel")
    with pytest.raises(ValueError, match="load of 3000 N makes a spring of .* stiffer spring"):
        held.spring(body, upright, 100.0, 1500.0, 3000.0, "strut")


@pytest.mark.slow
def test_a_wheel_that_would_leave_the_road_is_named():
    car = mounts.car("compact")
    smooth, rough = (ride_of(car, "half", road, 25.0, linked=True) for road in "AE")
    assert lifted(smooth) == "" and min(smooth.tyre_load(x).min() for x in smooth.vehicle.corners) > 0.0
    said = re.match(
        r"the (\w+ left wheel) would leave the road on ([\d.]+) % .* pulls with up to (\d+) N", lifted(rough)
    )
    load = rough.tyre_load(next(x for x in rough.vehicle.corners if x.name == said[1]))
    assert float(said[2]) == pytest.approx(100 * np.mean(load < 0.0), rel=0.05) and 0.5 < float(said[2]) < 30.0
    assert float(said[3]) == pytest.approx(-load.min(), abs=0.5)


def test_what_loads_make_of_the_springs_at_the_wheels():
    said = preloads(Vehicle("whole", mounts.car("saloon").ride))
    found = [float(part) for part in re.findall(r"([+-][\d.]+)%", said)]
    loads = [0.52 * 1560 * 9.81 / 2, 0.48 * 1560 * 9.81 / 2]
    for value, kind, load, spring in zip(found, ("double wishbone", "multilink"), loads, (29e3, 33e3), strict=True):
        curves = guide(kind, 1.59).curves
        slope = np.gradient(curves.ratio, curves.z)[np.abs(curves.z).argmin()]
        assert value == pytest.approx(100 * load * slope / curves.at("ratio", 0.0) / spring, abs=0.06)
