"""A car on its wheels: quarter, linked, half and whole, as mechanisms in space, and their small motions.

The body heaves, rolls and pitches; wheels slide along the z axis of the body on springs and dampers; tyres are springs
and dampers to the ground. A road of height z under a wheel pushes it by ``k z + c z_dot``, its tyre resting on level
ground: without weight all is measured from the loaded position. A half car has its two sides in one, a quarter car is
one corner with a body that only heaves; a linked one is a quarter car whose wheel hangs on the links of its axle.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    Force,
    Perpendicular,
    PointOnLine,
    Prismatic,
    SpringDamper,
    System,
    accelerations,
    linearize,
    measures,
    shapes,
)  # fmt: skip
from mbsd3d.errors import InputError
from mbsd3d.extend import Measure, number
from validation.nvh.road.guide import SWING, Guide, guide

KINDS = ("quarter", "linked", "half", "whole")
CORNERS = KINDS[:2]
HEIGHT, REST = 0.25, 0.3  # m: of the wheels' centres below that of the body; length of springs and tyres
Z = (0.0, 0.0, 1.0)
SPOTS = {"quarter": [(0, 0)], "linked": [(0, 0)], "half": [(1, 0), (-1, 0)], "whole": [(1, 0), (-1, 0), (0, 1)]}
"""Points (x, y) of the body whose heights say how it stands [m]."""


@dataclass(frozen=True)
class Corner:
    """A wheel: ``name``; ``x, y`` from the centre of mass [m]; ``side``: 0 left, 1 right; masses and rates [SI]."""

    name: str
    x: float
    y: float
    side: int
    mass: float
    spring: float
    damper: float
    tyre: float
    tyre_damping: float


@dataclass(frozen=True)
class Vehicle:
    """``kind``: "quarter" (front left corner), "linked" (the same on its links), "half" (both sides in one) or "whole";
    ``ride``: as in the data file.

    ValueError for an unknown kind, a mass or rate that is not positive, or a negative damping.
    """

    kind: str
    ride: dict[str, Any]

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise InputError(f"car on wheels: kind {self.kind!r} is unknown; give one of {', '.join(KINDS)}")
        for name in ("mass", "roll_inertia", "pitch_inertia", "wheelbase", "track"):
            number(self.ride[name], f"car on wheels: {name}", positive=True)
        for name in ("unsprung", "spring", "tyre"):
            for value in self.ride[name]:
                number(value, f"car on wheels: {name}", positive=True)
        for value in (*self.ride["damper"], self.ride["tyre_damping"]):
            number(value, "car on wheels: damping", minimum=0.0)

    @cached_property
    def corners(self) -> list[Corner]:
        """Front left, front right, rear left, rear right, as far as there are."""
        r, found = self.ride, []
        ahead = (1 - r["front"]) * r["wheelbase"], -r["front"] * r["wheelbase"]
        for axle, (end, x) in enumerate(zip(("front", "rear"), ahead, strict=True)):
            values = [r[name][axle] for name in ("unsprung", "spring", "damper", "tyre")] + [r["tyre_damping"]]
            if self.kind in CORNERS:
                return [Corner("wheel", 0.0, 0.0, 0, *values)]
            if self.kind == "half":
                found.append(Corner(f"{end} wheels", x, 0.0, 0, *(2 * value for value in values)))
                continue
            for side, name in enumerate(("left", "right")):
                y = (0.5 - side) * r["track"]
                found.append(Corner(f"{end} {name} wheel", x, y, side, *values))
        return found

    @property
    def mass(self) -> float:
        """Carried by the springs [kg]."""
        return self.ride["mass"] * (self.ride["front"] / 2 if self.kind in CORNERS else 1.0)

    @property
    def seat(self) -> tuple[float, float]:
        """(x, y) where the driver sits; over the wheel of a quarter car [m]."""
        x, y = self.ride["seat"]
        return {"half": (x, 0.0), "whole": (x, y)}.get(self.kind, (0.0, 0.0))

    @cached_property
    def guides(self) -> list[Guide]:
        """Of the front and the rear left wheel."""
        return [guide(kind, self.ride["track"]) for kind in self.ride["guides"]]

    @property
    def anti(self) -> tuple[float, float]:
        """(anti-dive, anti-lift): share of the pitching moment of braking that the links bear, front and rear."""
        share, arm = self.ride["brakes"], self.ride["wheelbase"] / (HEIGHT + REST)
        front, rear = (held.curves.at("ahead", 0.0) for held in self.guides)
        return share * arm * front, -(1 - share) * arm * rear

    def system(self, loads: Sequence[tuple[str, Any]] = ()) -> System:
        """The mechanism; ``loads``: (wheel, force upwards [N] or signal)."""
        r = self.ride
        size = (r["wheelbase"], r["track"], 2 * HEIGHT)
        inertia = (r["roll_inertia"], r["pitch_inertia"], r["pitch_inertia"])
        body = Body("body", self.mass, inertia, position=(0, 0, HEIGHT + REST), shape=shapes.Box(size))
        joints: list[Any] = [Prismatic(GROUND, body, at=body.position, axis=Z, name="heave")]
        if self.kind not in CORNERS:
            across = (1, 0, 0) if self.kind == "whole" else (0, 0, 1)
            joints = [PointOnLine(GROUND, body, at=body.position, axis=Z, name="heave")]
            joints.append(Perpendicular(GROUND, body, axis_a=across, axis_b=(0, 1, 0), name="no yaw"))
            if self.kind == "half":
                joints.append(Perpendicular(GROUND, body, axis_a=(1, 0, 0), axis_b=(0, 1, 0), name="no roll"))
        bodies, forces = [body], []
        for corner in self.corners:
            at = np.array([corner.x, corner.y, REST])
            tyre = shapes.Cylinder(REST, 0.2, "y")
            name = f"spring of {corner.name}"
            if self.kind == "linked":
                held, origin = self.guides[0], at - self.guides[0].centre
                wheel = held.upright(corner.mass, corner.name, origin)
                joints += held.hold(body, wheel, origin)
                strut = held.spring(body, wheel, corner.spring, corner.damper, name, origin)
            else:
                wheel = Body(corner.name, corner.mass, 3 * (SWING * corner.mass,), position=at, shape=tyre)
                joints.append(Prismatic(body, wheel, at=at, axis=Z, name=f"guide of {corner.name}"))
                above = at + (0, 0, HEIGHT)
                rates = dict(stiffness=corner.spring, damping=corner.damper)
                strut = SpringDamper(wheel, body, at_a=at, at_b=above, **rates, name=name)
            bodies.append(wheel)
            rates, name = dict(stiffness=corner.tyre, damping=corner.tyre_damping), f"tyre of {corner.name}"
            forces += [strut, SpringDamper(GROUND, wheel, at_a=at - (0, 0, REST), at_b=at, **rates, name=name)]
        named = {body.name: body for body in bodies}
        forces += [Force(named[name], (0, 0, push), name=f"road under {name}") for name, push in loads]
        return System(bodies, joints, forces, gravity=(0, 0, 0), name=f"{self.kind} car")

    def outputs(self, system: System) -> list[Measure]:
        """Heights of as many points as there are freedoms, then their velocities: of the body, then of the wheels."""
        body = system.bodies[0]
        points = [(body, (x, y, body.position[2])) for x, y in SPOTS[self.kind]] + [
            (wheel, None) for wheel in system.bodies[1:]
        ]
        places = [measures.position(part, axis=Z, at=at) for part, at in points]
        return places + [measures.velocity(part, axis=Z, at=at) for part, at in points]

    @cached_property
    def at_seat(self) -> np.ndarray:
        """(outputs,) weights of the heights of the body that give that of the seat."""
        x, y = self.seat
        body = {"half": [(1 + x) / 2, (1 - x) / 2], "whole": [(1 + x - y) / 2, (1 - x - y) / 2, y]}
        weights = np.array(body.get(self.kind, [1.0]))
        return np.concatenate([weights, np.zeros(len(self.corners))])

    @cached_property
    def equations(self) -> tuple[np.ndarray, np.ndarray]:
        """(A (2 n, 2 n), B (2 n, wheels)): small motions of the outputs, and what a force up on a wheel adds."""
        system = self.system()
        A = linearize(system, outputs=self.outputs(system)).A
        columns = []
        for corner in self.corners:
            pushed = accelerations(self.system([(corner.name, 1.0)]))
            (up,), (turn,) = pushed.acceleration("body"), pushed.alpha("body")
            body = [up[2] + turn[0] * y - turn[1] * x for x, y in SPOTS[self.kind]]
            wheels = [pushed.acceleration(other.name)[0, 2] for other in self.corners]
            columns.append(np.concatenate([np.zeros(A.shape[0] // 2), body, wheels]))
        return A, np.array(columns).T
