"""Wheel suspension of five links, as of a double wishbone or a multilink axle: its kinematics over the wheel travel.

Each link holds a point of the upright at its distance from a point of the body; a wishbone is two links that end in one
point. Five lengths leave the upright one degree of freedom. With z the height of the wheel's centre, P its lowest point
and s the length of the strut, the slopes of this curve in space are what designers ask for:

    motion ratio r = ds/dz    anti-dive  share dx_P/dz L / h    roll centre  y_P (dy_P/dz) / (dz_P/dz)

P here moves with the upright, as it does while the brake holds the wheel; L / h: wheelbase over height of the centre of
mass; share: of the braking force on this axle.

A strut of tension T carries the load W of the wheel if T r = W. As r changes over the travel the tension itself is a
spring at the wheel: of a strut of stiffness k the wheel feels

    k_w = k r^2 + T dr/dz
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any

import numpy as np

from engines.nvh.records import Record, data, fields
from mbsd3d import (
    GROUND,
    Body,
    Distance,
    Kinematic,
    PointOnPlane,
    Prismatic,
    Sine,
    SlideDriver,
    Solution,
    SpringDamper,
    System,
    shapes,
    simulate,
)  # fmt: skip
from mbsd3d.errors import InputError
from mbsd3d.extend import Ground, number, vector

LINK_COUNT, LINK_RADIUS = 5, 0.012  # of a wheel; radius they are drawn with [m]
WHEEL_INERTIA_RATIO = 0.05  # [m^2] inertia of a wheel over its mass
TRAVEL_MAX, RUN_SAMPLES = 0.08, 81  # m up and down; samples of a run
Point = Sequence[float] | np.ndarray  # (3,)
Ends = tuple[Point, Point] | np.ndarray  # (2, 3)


@dataclass(frozen=True, eq=False)
class Guide:
    """Suspension of a wheel: ``kind``: in words; ``centre``: of the left wheel [m]; x ahead, y left, z up from the road
    in the middle of the axle; ``links``: name -> (point of the body, point of the upright) [m]; ``strut``: the same of
    spring and damper.

    ValueError for another number of links than five, a link without length, or links that do not hold the wheel.
    """

    kind: str
    centre: Point
    links: dict[str, Ends]
    strut: Ends

    def __post_init__(self) -> None:
        if len(self.links) != LINK_COUNT:
            raise InputError(f"guide '{self.kind}': {len(self.links)} links; a wheel needs {LINK_COUNT}, an arm is two")
        for name, ends in (*self.links.items(), ("strut", self.strut)):
            inner, outer = (vector(end, f"guide '{self.kind}': {name}") for end in ends)
            if np.linalg.norm(np.subtract(outer, inner)) < 1e-3:
                raise InputError(f"guide '{self.kind}': {name} has no length; give two points")
        number(self.centre[2], f"guide '{self.kind}': centre[2]", positive=True)
        found = self.rig().check()
        if found.redundant or found.velocity_freedom:
            raise InputError(
                f"guide '{self.kind}': {found.redundant} links are redundant, {found.velocity_freedom} motions free; "
                "give links whose lines do not meet or run in parallel"
            )

    @cached_property
    def mirrored(self) -> "Guide":
        """Return the suspension of the right wheel."""
        across = np.array([1.0, -1.0, 1.0])
        links = {name: across * ends for name, ends in self.links.items()}
        return Guide(self.kind, across * self.centre, links, across * self.strut)

    def hold(self, body: Body | Ground, upright: Body, origin: Point = (0, 0, 0), whose: str = "") -> list[Distance]:
        """Return the links between a body and the upright, named with ``whose``; ``origin``: of the points of the
        suspension [m].
        """
        return [
            Distance(body, upright, at_a=np.add(inner, origin), at_b=np.add(outer, origin), name=name + whose)
            for name, (inner, outer) in self.links.items()
        ]

    def spring(
        self,
        body: Body,
        upright: Body,
        stiffness: float,
        damping: float,
        load: float,
        name: str,
        origin: Point = (0, 0, 0),
    ) -> SpringDamper:
        """Return the spring and damper that hold a wheel at rest under a load [N], with these rates at the wheel.

        ValueError for a load that alone is as stiff as the spring.
        """
        ratio, bend = (self.curves.at(curve, 0.0) for curve in ("ratio", "bend"))
        tension = load / ratio
        rate = (stiffness - tension * bend) / ratio**2
        if not rate > 0.0:
            raise InputError(
                f"guide '{self.kind}': its motion ratio changes so fast that a load of {load:.4g} N makes a spring of "
                f"{tension * bend:.4g} N/m at the wheel, of {stiffness:.4g} N/m in all; move the strut, or give a "
                "stiffer spring"
            )
        inner, outer = (np.add(end, origin) for end in self.strut)
        free = float(np.linalg.norm(outer - inner)) - tension / rate
        rates = dict(stiffness=rate, damping=damping / ratio**2)
        return SpringDamper(body, upright, at_a=inner, at_b=outer, length=free, **rates, name=name)

    def upright(self, mass: float, name: str, origin: Point = (0, 0, 0)) -> Body:
        """Return upright and wheel as a body at the wheel's centre, drawn with its links."""
        radius, at = self.centre[2], np.array(self.centre)
        drawn: list[shapes.Shape] = [shapes.Torus(0.8 * radius, 0.2 * radius, "y")]
        for _, outer in self.links.values():
            d = np.subtract(outer, at)
            drawn.append(shapes.Cylinder(LINK_RADIUS, float(np.linalg.norm(d)), tuple(d), at=d / 2))
        return Body(name, mass, 3 * (WHEEL_INERTIA_RATIO * mass,), position=np.add(at, origin), shape=drawn)

    def rig(self, travel: float = TRAVEL_MAX) -> System:
        """Build the test rig: the wheel on a plate that moves up and down under its centre once in a second, the body
        fixed.
        """
        upright = self.upright(20.0, "wheel")
        plate = Body("plate", 1.0, (0.1, 0.1, 0.1), shape=shapes.Box((0.3, 0.3, 0.02)))
        slide = Prismatic(GROUND, plate, at=(0, 0, 0), axis=(0, 0, 1), name="slide")
        rest = PointOnPlane(plate, upright, at=self.centre, normal=(0, 0, 1), name="wheel load")
        drive = SlideDriver(slide, Sine(travel, 1.0), name="road")
        inner, outer = self.strut
        strut = SpringDamper(GROUND, upright, at_a=inner, at_b=outer, stiffness=0.0, name="strut")
        return System([plate, upright], [slide, *self.hold(GROUND, upright), rest, drive], [strut], gravity=(0, 0, 0))

    def run(self, travel: float = TRAVEL_MAX) -> Solution:
        """Simulate the rig by kinematics from the lowest to the highest position of the wheel."""
        swing = np.arcsin(np.linspace(-1.0, 1.0, RUN_SAMPLES)[1:-1]) / (2 * np.pi)
        return simulate(self.rig(travel), 1.25, method=Kinematic(), output=1.0 + swing)

    @cached_property
    def curves(self) -> "Curves":
        """Return the suspension curves over the whole travel."""
        return curves(self, self.run())


@cache
def guide(kind: str, track: float) -> Guide:
    """Return a suspension of the data file, moved outwards to a track [m]; raise ValueError for an unknown kind."""
    known = data("cars")["guides"]
    if kind not in known:
        raise InputError(f"guide '{kind}' is unknown; there are {', '.join(known)}; or give centre, links and strut")
    return made(kind, known[kind], track)


def made(kind: str, record: Record, track: float) -> Guide:
    """Return the suspension of a record, moved outwards to a track [m]; raise ValueError for a missing field or invalid
    points.
    """
    what = f"guide '{kind}'"
    fields(record, ("centre", "links", "strut"), what)
    centre = np.array(vector(record["centre"], f"{what}: centre"))
    out = np.array([0.0, number(track, "guide: track", positive=True) / 2 - centre[1], 0.0])
    if not isinstance(record["links"], dict):
        raise InputError(f"{what}: links: {record['links']!r}; give names, each with its two points")
    links = {name: ends_of(ends, f"{what}: {name}") + out for name, ends in record["links"].items()}
    return Guide(kind, centre + out, links, ends_of(record["strut"], f"{what}: strut") + out)


def ends_of(given: Any, what: str) -> np.ndarray:
    """Return the points of body and upright [m], shape (2, 3); raise ValueError for other values."""
    if not isinstance(given, list | tuple) or len(given) != 2:
        raise InputError(f"{what}: {given!r}; give two points [m], of the body and of the upright")
    return np.array([vector(end, what) for end in given])


@dataclass(frozen=True)
class Curves:
    """Suspension curves over the travel ``z`` (n,) [m].

    ``toe`` inwards and ``camber`` outwards at the top (n,) [rad]; ``track``: how far P goes outwards (n,) [m];
    ``ratio``: r = ds/dz (n,), ``bend``: dr/dz (n,) [1/m]; ``ahead``: dx_P/dz (n,); ``roll_centre``: its height (n,)
    [m].
    """

    z: np.ndarray
    toe: np.ndarray
    camber: np.ndarray
    track: np.ndarray
    ratio: np.ndarray
    bend: np.ndarray
    ahead: np.ndarray
    roll_centre: np.ndarray

    def at(self, name: str, z: float) -> float:
        """Evaluate a suspension curve at a wheel travel [m]."""
        return float(np.interp(z, self.z, getattr(self, name)))


def curves(guide: Guide, run: Solution) -> Curves:
    """Compute the suspension curves of a run on the rig."""
    R, centre, v, w = run.rotation("wheel"), run.position("wheel"), run.velocity("wheel"), run.omega("wheel")
    axle = R[:, :, 1]
    toe, camber = -np.arctan2(-axle[:, 0], axle[:, 1]), -np.arcsin(axle[:, 2])
    down = axle * axle[:, 2:] - (0, 0, 1.0)
    lowest = guide.centre[2] * down / np.linalg.norm(down, axis=1)[:, None]
    slope = (v + np.cross(w, lowest)) / v[:, 2:]
    place = centre + lowest
    height = place[:, 2] + place[:, 1] * slope[:, 1] / slope[:, 2]
    ratio = run.force("strut").rate / v[:, 2]
    # s'' = r z'' + dr/dz z'^2, and s'' from the motion of the strut's outer end
    arm = R @ np.subtract(guide.strut[1], guide.centre)
    across = np.cross(w, arm)
    along, speed = centre + arm - guide.strut[0], v + across
    pull = run.acceleration("wheel") + np.cross(run.alpha("wheel"), arm) + np.cross(w, across)
    length, dot = np.linalg.norm(along, axis=1), lambda a, b: np.einsum("ti,ti->t", a, b)
    rate = (dot(along, pull) + dot(speed, speed) - (ratio * v[:, 2]) ** 2) / length
    bend = (rate - ratio * run.acceleration("wheel")[:, 2]) / v[:, 2] ** 2
    z = centre[:, 2] - guide.centre[2]
    return Curves(z, toe, camber, place[:, 1] - guide.centre[1], ratio, bend, slope[:, 0] / slope[:, 2], height)
