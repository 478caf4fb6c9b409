"""Car on its wheels: quarter, half and whole, as mechanisms in space, and their small motions.

The body heaves, rolls and pitches; wheels slide along the z axis of the body, or hang on the five links of their axle
(`Guide`), on springs and dampers; tyres are springs and dampers to the ground. Links move them sideways, too, at y_dot
where they touch the road: rolling at a speed v they bear the side force ``-C y_dot / v`` of their slip angle. A road of
height z under a wheel pushes it by ``k z + c z_dot``, its tyre resting on level ground. The reference pose is the car
at rest: springs carry the body, tyres bear the wheels too, straight up at their centres, and rates are those of this
position. A half car is the left half of one that does not roll, a quarter car is one corner with a body that only
heaves.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from engines.nvh.road.guide import WHEEL_INERTIA_RATIO, Guide, guide, made
from mbsd3d import (
    GROUND,
    Body,
    Bushing,
    Force,
    Input,
    Perpendicular,
    PointOnLine,
    Prismatic,
    SpringDamper,
    StateSpace,
    System,
    measures,
    shapes,
    state_space,
)  # fmt: skip
from mbsd3d.errors import InputError
from mbsd3d.extend import Measure, matrix, number

KINDS = ("quarter", "half", "whole")
BODY_HEIGHT, STRUT_LENGTH = 0.25, 0.3  # m: of the wheels' centres below that of the body; length of springs and tyres
Z = (0.0, 0.0, 1.0)
AXLE_FIELDS = dict.fromkeys(("unsprung", "spring", "damper", "tyre", "cornering", "guides"), "front and rear") | {
    "seat": "ahead and left"
}
Load = tuple[str, Sequence[Any], Sequence[float] | None]
GRAVITY = 9.81  # m/s^2: brakes are given as a share of it
OUTPUT_PLACES = {"quarter": [(0, 0)], "half": [(1, 0), (-1, 0)], "whole": [(1, 0), (-1, 0), (0, 1)]}
"""Points (x, y) of the body whose heights say how it stands [m]."""


@dataclass(frozen=True)
class Corner:
    """Wheel of a car: ``name``; ``x, y`` from the centre of mass [m]; ``side``: 0 left, 1 right; masses and rates [SI];
    ``load``: of the body on it [N].
    """

    name: str
    x: float
    y: float
    side: int
    mass: float
    spring: float
    damper: float
    tyre: float
    tyre_damping: float
    load: float

    @property
    def borne(self) -> float:
        """Return the static wheel load [N]."""
        return self.load + self.mass * GRAVITY


@dataclass(frozen=True)
class Vehicle:
    """Vehicle of a ``kind``: "quarter" (front left corner), "half" (left half) or "whole"; ``ride``: as in the data
    file; ``linked``: whether wheels hang on the links of their axles or slide along the body's z; ``speed``: at which
    those on links roll [m/s], None: tyres bear no side force.

    ValueError for an unknown kind, a mass, a rate or a speed that is not positive, or a negative damping.
    """

    kind: str
    ride: dict[str, Any]
    linked: bool = False
    speed: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(f"car on wheels: kind {self.kind!r} is unknown; give one of {', '.join(KINDS)}")
        for name in AXLE_FIELDS:
            given = self.ride[name]
            if isinstance(given, str) or not isinstance(given, Sequence) or len(given) != 2:
                count = f"{len(given)} in a list" if isinstance(given, list) else repr(given)
                raise InputError(f"car on wheels: {name}: {count}; give two, {AXLE_FIELDS[name]}")
        for given in self.ride["guides"]:
            if not isinstance(given, str | dict):
                raise InputError(
                    f"car on wheels: guides: {given!r}; give a name, or a record of centre, links and strut"
                )
        for value in self.ride["seat"]:
            number(value, "car on wheels: seat")
        for name in ("mass", "roll_inertia", "pitch_inertia", "wheelbase", "track"):
            number(self.ride[name], f"car on wheels: {name}", positive=True)
        for name in ("unsprung", "spring", "tyre"):
            for value in self.ride[name]:
                number(value, f"car on wheels: {name}", positive=True)
        if self.speed is not None:
            number(self.speed, "car on wheels: speed", positive=True)
        for value in (*self.ride["damper"], *self.ride["cornering"], self.ride["tyre_damping"]):
            number(value, "car on wheels: damping", minimum=0.0)
        for name in ("front", "brakes"):
            if not 0.0 < number(self.ride[name], f"car on wheels: {name}") < 1.0:
                raise InputError(f"car on wheels: {name} {self.ride[name]:g}; give a share between 0 and 1")

    @property
    def title(self) -> str:
        """Return the car in words."""
        return f"{self.kind} car{' on links' * self.linked}"

    @cached_property
    def corners(self) -> list[Corner]:
        """Return the existing corners of front left, front right, rear left, rear right."""
        r, found = self.ride, []
        ahead = (1 - r["front"]) * r["wheelbase"], -r["front"] * r["wheelbase"]
        for axle, (end, x) in enumerate(zip(("front", "rear"), ahead, strict=True)):
            load = (r["front"], 1 - r["front"])[axle] / 2 * r["mass"] * GRAVITY
            values = *(r[name][axle] for name in ("unsprung", "spring", "damper", "tyre")), r["tyre_damping"], load
            if self.kind == "quarter":
                return [Corner("wheel", 0.0, 0.0, 0, *values)]
            for side, name in enumerate(("left", "right")):
                y = (0.5 - side) * r["track"]
                found.append(Corner(f"{end} {name} wheel", x, y, side, *values))
        return found[::2] if self.kind == "half" else found

    @property
    def part(self) -> float:
        """Return the share of the car in the model [-]."""
        return {"quarter": self.ride["front"] / 2, "half": 0.5}.get(self.kind, 1.0)

    @property
    def mass(self) -> float:
        """Return the sprung mass [kg]."""
        return self.ride["mass"] * self.part

    @property
    def seat(self) -> tuple[float, float]:
        """Return (x, y) of the driver's seat [m]; above the wheel of a quarter car."""
        x, y = self.ride["seat"]
        return {"half": (x, 0.0), "whole": (x, y)}.get(self.kind, (0.0, 0.0))

    @cached_property
    def guides(self) -> list[Guide]:
        """Return the suspensions of the front and the rear left wheel."""
        track = self.ride["track"]
        return [made("own", x, track) if isinstance(x, dict) else guide(x, track) for x in self.ride["guides"]]

    @property
    def anti(self) -> tuple[float, float]:
        """Return (anti-dive, anti-lift): share of the pitching moment of braking that the links bear, front and
        rear."""
        share, arm = self.ride["brakes"], self.ride["wheelbase"] / (BODY_HEIGHT + STRUT_LENGTH)
        front, rear = (held.curves.at("ahead", 0.0) for held in self.guides)
        return share * arm * front, -(1 - share) * arm * rear

    @property
    def by_load(self) -> tuple[float, float]:
        """Return (front, rear) share of the stiffness at a wheel due to the load of its strut, ``T dr/dz / k_w``; of a
        half or whole car on links.
        """
        front, rear = (
            held.curves.at("bend", 0.0) / held.curves.at("ratio", 0.0) * corner.load / corner.spring
            for held, corner in zip(self.guides, (self.corners[0], self.corners[-1]), strict=True)
        )
        return front, rear

    def system(self, loads: Sequence[Load] = ()) -> System:
        """Build the mechanism; ``loads``: (wheel, force [N] or signals, where it acts; None: at the centre)."""
        r = self.ride
        size = (r["wheelbase"], 0.5 * r["track"], 2 * BODY_HEIGHT)
        inertia = np.array([r["roll_inertia"], r["pitch_inertia"], r["pitch_inertia"]]) * self.part
        body = Body("body", self.mass, inertia, position=(0, 0, BODY_HEIGHT + STRUT_LENGTH), shape=shapes.Box(size))
        joints: list[Any] = [Prismatic(GROUND, body, at=body.position, axis=Z, name="heave")]
        if self.kind != "quarter":
            across = (1, 0, 0) if self.kind == "whole" else (0, 0, 1)
            joints = [PointOnLine(GROUND, body, at=body.position, axis=Z, name="heave")]
            joints.append(Perpendicular(GROUND, body, axis_a=across, axis_b=(0, 1, 0), name="no yaw"))
            if self.kind == "half":
                joints.append(Perpendicular(GROUND, body, axis_a=(1, 0, 0), axis_b=(0, 1, 0), name="no roll"))
        bodies, forces = [body], []
        for corner in self.corners:
            wheel, hung, strut = self.hung(corner, body)
            bodies.append(wheel)
            joints += hung
            at, rates = wheel.position, dict(stiffness=corner.tyre, damping=corner.tyre_damping)
            tyre = SpringDamper(
                GROUND, wheel, at_a=at - (0, 0, STRUT_LENGTH), at_b=at, **rates, name=f"tyre of {corner.name}"
            )
            weight = Force(wheel, (0, 0, corner.borne), name=f"weight on {corner.name}")
            forces += [strut, tyre, weight, *self.rolling(corner, wheel)]
        named = {part.name: part for part in bodies}
        forces += [Force(named[name], push, at=at, name=f"load on {name}") for name, push, at in loads]
        return System(bodies, joints, forces, gravity=(0, 0, -GRAVITY), name=self.title)

    def rolling(self, corner: Corner, wheel: Body) -> list[Bushing]:
        """Return the side force of a rolling tyre, at the lowest point of a wheel on links."""
        if self.speed is None or not self.linked:
            return []
        slip = self.ride["cornering"][int(corner.x < 0)] / self.speed
        at = wheel.position - (0, 0, STRUT_LENGTH)
        return [Bushing(GROUND, wheel, at=at, stiffness=0.0, damping=(0, slip, 0), name=f"slip of {corner.name}")]

    def hung(self, corner: Corner, body: Body) -> tuple[Body, list[Any], SpringDamper]:
        """Return (wheel, its suspension, spring and damper) of a corner."""
        at, name = np.array([corner.x, corner.y, STRUT_LENGTH]), f"spring of {corner.name}"
        if self.linked:
            held = self.guides[int(corner.x < 0)]
            held = held.mirrored if corner.side else held
            origin = at - held.centre
            wheel = held.upright(corner.mass, corner.name, origin)
            strut = held.spring(body, wheel, corner.spring, corner.damper, corner.load, name, origin)
            return wheel, held.hold(body, wheel, origin, f" of {corner.name}"), strut
        tyre, above = shapes.Cylinder(STRUT_LENGTH, 0.2, "y"), at + (0, 0, BODY_HEIGHT)
        wheel = Body(corner.name, corner.mass, 3 * (WHEEL_INERTIA_RATIO * corner.mass,), position=at, shape=tyre)
        guided = Prismatic(body, wheel, at=at, axis=Z, name=f"guide of {corner.name}")
        free = BODY_HEIGHT + corner.load / corner.spring
        rates = dict(stiffness=corner.spring, damping=corner.damper, length=free)
        return wheel, [guided], SpringDamper(wheel, body, at_a=at, at_b=above, **rates, name=name)

    def braked(self, share: float) -> float:
        """Return the angle by which the body of a half or whole car dives under braking at a share of gravity [rad].

        The wheels are held by their brakes, forces act where they touch the road, and the body stands still again.
        """
        front, force = self.ride["brakes"], -share * GRAVITY * self.mass / len(self.corners) * 2
        loads = [
            (corner.name, (force * (front if corner.x > 0 else 1 - front), 0, 0), (corner.x, corner.y, 0.0))
            for corner in self.corners
        ]
        ahead = matrix(self.system(loads).equilibrium().state.q[3:7])[:, 0]
        return float(-np.arcsin(ahead[2]))

    def heights(self, system: System) -> list[Measure]:
        """Return the heights of as many points as there are degrees of freedom: of the body, then of the wheels."""
        body, *wheels = system.bodies
        places = [(x, y, body.position[2]) for x, y in OUTPUT_PLACES[self.kind]]
        return [measures.position(body, axis=Z, at=at) for at in places] + [
            measures.position(wheel, axis=Z) for wheel in wheels
        ]

    @cached_property
    def at_seat(self) -> np.ndarray:
        """Return the weights of the heights of the body that give the height of the seat, shape (outputs,)."""
        x, y = self.seat
        body = {"half": [(1 + x) / 2, (1 - x) / 2], "whole": [(1 + x - y) / 2, (1 - x - y) / 2, y]}
        weights = np.array(body.get(self.kind, [1.0]))
        return np.concatenate([weights, np.zeros(len(self.corners))])

    @cached_property
    def small_motions(self) -> StateSpace:
        """Return the linear model from upward forces on the wheels [N] to the heights of points [m]."""
        system = self.system([(corner.name, (0, 0, Input(corner.name)), None) for corner in self.corners])
        return state_space(system, outputs=self.heights(system))
