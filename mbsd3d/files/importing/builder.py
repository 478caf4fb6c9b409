"""A system from the facts of a model, whichever format they come from, and what of them has no counterpart here."""

from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import InputError
from ...base.mass_properties import TRIANGLE_RULE_TOLERANCE, MassProperties, put_together
from ...base.rotations import conjugate, matrix, multiply
from ...base.wording import counted, with_article
from ...mechanism.bodies import GROUND, Body
from ...mechanism.couplings import COORDINATES_COUNT, SLOTS_COUNT, Coupler, Gear, RackPinion
from ...mechanism.drivers import AngleDriver, SlideDriver
from ...mechanism.force_element import ForceElement
from ...mechanism.forces.applied import Force
from ...mechanism.forces.between import ForceBetween, TorqueBetween
from ...mechanism.forces.brake import Brake
from ...mechanism.forces.bushing import Bushing
from ...mechanism.forces.cone_stop import RotationStop
from ...mechanism.forces.end_stop import EndStop, Stop
from ...mechanism.forces.fluid_drag import FluidDrag
from ...mechanism.forces.rotation_spring import RotationSpring
from ...mechanism.forces.springs import TorsionSpring
from ...mechanism.forces.sum_spring import SumSpring, SumStop
from ...mechanism.joints import Joint
from ...mechanism.joints.pairs import Fixed, Prismatic, Spherical
from ...mechanism.limits import Limit
from ...mechanism.mechanism import Mechanism
from ...mechanism.shapes.shape import Shape
from ...mechanism.shapes.solids import Box, Capsule, Cylinder, Ellipsoid, Hull, MeshFile, Sphere
from ...mechanism.shapes.triangles import MESH_SUFFIXES, check_mesh
from ...mechanism.signals.signal import Input, Signal
from .facts import Facts, carried, felt_inertia, length_of
from .imported import Imported, NotBuilt, Point, grouped, judged
from .joints import (
    Frame,
    Term,
    acts_along,
    bodies_of,
    check_independent,
    has_coordinate,
    joint_of,
    next_to_merge,
    parts_of,
    state_of,
)

MOMENT_ROUNDING = 1e-12  # [m L^2] of mass and extent of the model: a negative principal moment that is rounding
MESH_BYTES_MAX = 50_000_000  # [bytes] of all mesh files that are drawn: some seconds
BRAKE_YIELD = 1e-3  # [rad, m] that a brake for dry friction yields before it slips
STOP_RATE = 300.0  # [rad/s] of what a stop holds, damped critically: a contact of some 10 ms
CONE_CORNERS = 24  # [1] of the base of a cone that is drawn


def cone_corners(radius: float, half: float) -> np.ndarray:
    """Return the base and the tip of a cone along z, about the middle between them."""
    turn = 2.0 * np.pi * np.arange(CONE_CORNERS) / CONE_CORNERS
    base = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(CONE_CORNERS, -half)])
    return np.vstack([base, (0.0, 0.0, half)])


SHAPES_BY_KIND: dict[str, tuple[type[Shape], Callable[[float, float, float], tuple[Any, ...]]]] = {
    "box": (Box, lambda a, b, c: ((2 * a, 2 * b, 2 * c),)),
    "sphere": (Sphere, lambda a, b, c: (a,)),
    "capsule": (Capsule, lambda a, b, c: (a, 2 * b)),
    "cylinder": (Cylinder, lambda a, b, c: (a, 2 * b)),
    "ellipsoid": (Ellipsoid, lambda a, b, c: ((a, b, c),)),
    "cone": (Hull, lambda a, b, c: (cone_corners(a, b),)),
}
"""Kinds of geometry with a shape of their own, and its sizes."""


class Choices(NamedTuple):
    """What the caller of an import chose."""

    leave_out: tuple[str, ...] = ()
    strict: bool = False
    inertia: str = "as given"
    geometry: str = "draw"
    inputs: bool = False
    limits: str = "watched"


class Builder:
    """A system from facts; ``place_of(tag, name)`` says where an element stands in the file, "" if nobody knows."""

    def __init__(self, facts: Facts, choices: Choices, place_of: Callable[[str, str], str]) -> None:
        self.facts, self.choices, self.place_of = facts, choices, place_of
        self.not_built = [
            NotBuilt(x["kind"], x["what"], place_of(*x["element"]) if x["element"] else "", x["count"])
            for x in facts["foreign"]
        ]
        self.bodies: dict[int, Any] = {0: GROUND}
        self.inputs: dict[str, tuple[float, float] | None] = {}
        self.actuators = self.to_build() if choices.inputs else self.inactive_actuators()
        self.group = grouped(body["weld"] for body in facts["bodies"])  # what is welded to a body, itself first
        self.joints_of = grouped(joint.get("loop", joint["body"]) for joint in facts["joints"])
        self.coupled = {k for e in facts["equalities"] for k in joints_in(e)}
        self.coupled |= {k for tendon in facts.get("tendons", ()) for k in tendon["joints"]}
        self.length = length_of(facts)
        self.names: set[str] = {GROUND.name}
        self.renamed: dict[str, str] = {}
        self.said: list[str] = list(facts.get("said", ()))
        self.missing: list[str] = list(facts.get("missing", ())) if choices.geometry == "draw" else []
        self.meshes = Meshes(self.missing)
        self.frames: list[Frame] = []  # of all bodies, in their order
        self.joints: list[Joint] = []
        self.forces: list[ForceElement] = []
        self.limits: list[Limit] = []
        self.made: dict[int, Joint] = {}  # number of a joint of the file -> joint it has become, or become a part of
        self.coordinate: dict[int, Joint] = {}  # number of a hinge or slide whose angle or slide is that of a joint

    @cached_property
    def carried(self) -> list[MassProperties]:
        """Return mass properties of each body of the file with all that hangs on it."""
        return carried(self.facts)

    def build(self) -> Imported:
        """Build all parts, or raise an error that names the rest."""
        merged = {}
        for i, body in enumerate(self.facts["bodies"]):
            if i and body["weld"] == i:
                self.bodies[i] = self.body(i)
            elif i:
                merged[body["name"]] = self.bodies[body["weld"]].name
        for i in list(self.bodies)[1:]:
            self.join(i, self.joints_of.get(i, []))
        for loop, places in self.joints_of.items():
            if loop < 0:  # of joints beside the tree
                self.join(self.facts["joints"][places[0]]["body"], places)
        for equality in self.facts["equalities"]:
            self.close(equality)
        for tendon in self.facts.get("tendons", ()):
            self.pull(tendon)
        self.hold_weights()
        self.drag()
        for actuator in self.actuators:
            self.actuate(actuator)
        if brakes := sum(isinstance(force, Brake) for force in self.forces):
            self.said.append(f"dry friction of {counted(brakes, 'joint')} yields by {BRAKE_YIELD:g} rad or m at rest")
        if stops := sum(isinstance(force, Stop) for force in self.forces):
            self.said.append(f"{counted(stops, 'stop')}, which a speed v enters by v / {STOP_RATE:g} s or less")
        if sliders := sum(bool(frame.slide) for frame in self.frames):
            self.said.append(f"joints of tendons are added up by {counted(sliders, 'body')} without mass")
        verdict = judged(self.not_built, self.choices.leave_out, self.choices.strict)
        if len(self.bodies) == 1:
            raise InputError("no body of it can move; give one a joint")
        bodies = [frame.made for frame in self.frames]
        given = (bodies, self.joints, self.forces, self.facts["gravity"])
        system = Mechanism(*given, limits=self.limits, notes=verdict.notes)
        states = {
            key["name"]: state_of(system, self.frames, self.coordinate, key) for key in self.facts.get("keys", ())
        }
        points = {point["name"]: self.point(point) for point in self.facts.get("points", ())}
        idle = {kind: n for kind, n in self.facts["idle"].items() if n}
        return Imported(
            system, merged, self.renamed, verdict.dropped, idle, verdict.inactive, tuple(self.said),
            tuple(dict.fromkeys(self.missing)), states, points, self.inputs,
        )  # fmt: skip

    def name(self, wanted: str, kind: str) -> str:
        """Return a unique name: joints and bodies share one list of names here."""
        name = wanted
        while name in self.names:
            name = f"{name} ({kind})"
        if name != wanted:
            self.renamed[name] = wanted
        self.names.add(name)
        return name

    def foreign(self, kind: str, what: str, tag: str = "", name: str = "", **more: Any) -> None:
        """Keep something that is not built."""
        self.not_built.append(NotBuilt(kind, what, self.place_of(tag, name) if tag else "", **more))

    def body(self, i: int) -> Body:
        """Build a body with all that is welded to it; R'(x_G - x_O) and R' I_G R put it into its own axes."""
        group = [self.facts["bodies"][k] for k in self.group[i]]
        r, R = np.array(group[0]["position"]), matrix(group[0]["quaternion"])
        parts = [
            (part["mass"], R.T @ (np.array(part["centre"]) - r), R.T @ np.array(part["inertia"]) @ R) for part in group
        ]
        whole = put_together(parts)
        name, e = self.name(group[0]["name"], "body"), np.array(group[0]["quaternion"])
        look = None
        if self.choices.geometry == "draw":
            look = drawn([geom for part in group for geom in part["geoms"]], r, e, R, self.meshes)
        inertia, as_given = self.inertia_of(whole, group[0]["name"])
        place: dict[str, Any] = {"com": whole.com, "position": r, "orientation": e, "shape": look}
        return Body(name, whole.mass, inertia, inertia_as_given=as_given, **place)

    def inertia_of(self, whole: MassProperties, name: str) -> tuple[np.ndarray, bool]:
        """Return the inertia of a group of bodies without rounding below 0, and whether no body has it."""
        I = 0.5 * (whole.inertia + whole.inertia.T)
        moments, axes = np.linalg.eigh(I)
        largest, rounding = np.abs(moments).max(), MOMENT_ROUNDING * whole.mass * self.length**2
        if largest <= rounding:
            return np.zeros((3, 3)), False
        if moments[0] < -rounding - TRIANGLE_RULE_TOLERANCE * largest:
            raise InputError(
                f"{self.called(name)}: inertia has the principal moments {moments.tolist()}, {moments[0]:.3g} < 0; "
                "check the signs and units, and that it is taken about the centre of mass"
            )
        if moments[0] < -TRIANGLE_RULE_TOLERANCE * largest:
            moments = np.maximum(moments, 0.0)
            I = axes @ np.diag(moments) @ axes.T
        if moments[2] <= moments[0] + moments[1] + TRIANGLE_RULE_TOLERANCE * largest:
            return I, False
        text = (
            f"inertia of '{name}' has the principal moments {', '.join(f'{x:.4g}' for x in moments)}, of which the "
            "largest exceeds the sum of the others: no body has it"
        )
        if self.choices.inertia == "refuse":
            raise InputError(f'{self.called(name)}: {text}; correct it, or take it with inertia="as given"')
        self.said.append(f"{text}; taken as given")
        return I, True

    def called(self, name: str, tag: str = "body") -> str:
        """Name a body, or another part, and its place."""
        place = self.place_of(tag, name)
        return f"{tag} '{name}'" + (f" ({place})" if place else "")

    def carrier(self, i: int) -> Any:
        """Return the body that stands for number i."""
        return self.bodies[self.facts["bodies"][i]["weld"]]

    def parent(self, i: int) -> Any:
        """Return the body that carries body i."""
        return self.carrier(self.facts["bodies"][i]["parent"])

    def before(self, i: int, part: Facts) -> Any:
        """Return the body before a joint of body i: its parent, but for joints that close loops."""
        return self.carrier(part["parent"]) if "loop" in part else self.parent(i)

    def join(self, i: int, places: list[int]) -> None:
        """Build the joints between a body and its parent, with their springs, friction and limits."""
        parts = [self.facts["joints"][k] for k in places]
        for part in parts:
            for load in ("stiffness", "damping", "friction", "armature"):
                if part[load] < 0.0:
                    raise InputError(f"{self.called(part['name'], 'joint')}: {load} {part[load]:g} < 0; give >= 0")
        frames = [Frame(self.carrier(i), i, ())]
        if not parts or parts[0]["type"] == "free":
            self.frames += frames
        else:
            made = self.whole_joint(i, places, parts)
            if made is None:
                frames = self.chain(i, places, parts)
            else:
                self.joints.append(made)
                self.made |= dict.fromkeys(places, made)
            self.frames += frames[:-1] if "loop" in parts[0] else frames
            self.coordinate |= {
                k: self.made[k]
                for k, part in zip(places, parts, strict=True)
                if has_coordinate(self.made[k], part["type"])
            }
        for k, part in zip(places, parts, strict=True):
            self.load(i, k, part)

    def whole_joint(self, i: int, places: list[int], parts: list[Facts]) -> Joint | None:
        """Return one joint for all those of a body; None if there is none, or a load needs a coordinate of its own."""
        a, b = self.before(i, parts[0]), self.carrier(i)
        made = joint_of(a, b, parts, parts[0].get("title") or "-".join(part["name"] for part in parts))
        if made is None or any(
            (k in self.coupled or acts_along(part)) and not has_coordinate(made, part["type"])
            for k, part in zip(places, parts, strict=True)
            if part["type"] in ("hinge", "slide")
        ):
            return None
        return joint_of(a, b, parts, self.name(str(made.name), "joint"))

    def chain(self, i: int, places: list[int], parts: list[Facts]) -> list[Frame]:
        """Build the joints of a body one after the other, in the order of the file, over bodies without mass."""
        body, inner = self.carrier(i), self.before(i, parts[0])
        check_independent(parts, body.name, self.called(body.name))
        frames = []
        for n, (k, part) in enumerate(zip(places, parts, strict=True)):
            outer = body
            if n < len(parts) - 1:
                name = self.name(f"{body.name} after {part['name']}", "body")
                outer = Body(name, 0.0, np.zeros(3), position=body.position, orientation=body.orientation)
            frames.append(Frame(outer, i, tuple(places[n + 1 :])))
            made = joint_of(inner, outer, [part], self.name(part["name"], "joint"))
            if made is None:
                raise InputError(
                    f"{self.called(body.name)}: {with_article(part['type'])} joint cannot follow another; change it"
                )
            self.joints.append(made)
            self.made[k] = made
            inner = outer
        return frames

    def load(self, i: int, k: int, part: Facts) -> None:
        """Build what acts on a joint: springs, dampers, dry friction, limits."""
        joint, what = self.coordinate.get(k), f"{part['type']} {part['name']}"
        if part["stiffness"] or part["damping"]:
            self.spring(i, k, part)
        if part["armature"] and part["type"] == "free":
            self.heavier(i, part)
        if part["friction"]:
            if joint is None:
                self.foreign("frictionloss", what, "joint", part["name"])
            else:
                self.brake(joint, part["friction"], self.felt(part), part["name"])
        if part["limit"] is not None:
            self.limit(k, part, joint)

    def brake(self, joint: Joint, torque: float, felt: float, title: str) -> None:
        """Build the dry friction of a joint that moves what is felt [kg m^2 or kg]."""
        stiffness = torque / BRAKE_YIELD
        values = {"torque": torque, "stiffness": stiffness, "damping": np.sqrt(stiffness * felt)}
        self.forces.append(Brake(joint, **values, name=self.name(f"{title} friction", "friction")))

    def limit(self, k: int, part: Facts, joint: Joint | None) -> None:
        """Build a stop for the limits of a joint, or watch them; a stop needs a lower limit below the upper one."""
        lower, upper = part["limit"]
        kind = "angle" if part["type"] == "hinge" else "slide"
        if self.stops and joint is not None and lower < upper:
            how = self.stop(part["name"], self.felt(part))
            self.forces.append(EndStop(joint, lower=lower, upper=upper, of=kind, **how))
            return
        if self.stops and part["type"] == "ball" and 0.0 < max(lower, upper) < np.pi:  # of the whole turn
            how = self.stop(part["name"], self.felt(part))
            self.forces.append(RotationStop(self.made[k], angle=max(lower, upper), **how))
            return
        self.foreign("limit", f"range of {part['name']}", "joint", part["name"], watched=joint is not None)
        if joint is not None and "limit" not in self.choices.leave_out:
            name = part["name"] if part["name"] != joint.name else ""
            self.limits.append(Limit(joint, kind, lower, upper, name))

    @property
    def stops(self) -> bool:
        """Return whether limits become stops."""
        return self.choices.limits == "stop" and "limit" not in self.choices.leave_out

    def stop(self, title: str, felt: float) -> dict[str, Any]:
        """Return stiffness, damping and name of a stop of what is felt [kg m^2 or kg]: damped critically."""
        name = self.name(f"{title} stop", "stop")
        return {"stiffness": felt * STOP_RATE**2, "damping": 2.0 * felt * STOP_RATE, "name": name}

    def felt(self, part: Facts) -> float:
        """Return what a hinge, slide or ball turns or moves at the reference pose [kg m^2 or kg], above 0."""
        return max(felt_inertia(self.carried[part["body"]], part) + part["armature"], MOMENT_ROUNDING)

    def heavier(self, i: int, part: Facts) -> None:
        """Build the armature of a free joint: mass without weight, and isotropic inertia, at the origin of the body."""
        title, I, carrier = f"{part['name']} armature", part["armature"], self.bodies[i]
        look = Sphere(BRAKE_YIELD * self.length)
        at = {"position": carrier.position, "orientation": carrier.orientation}
        added = Body(self.name(title, "body"), I, (I, I, I), shape=look, **at)
        self.frames.append(Frame(added, i, ()))
        self.joints.append(Fixed(carrier, added, at=carrier.position, name=self.name(f"{title} seat", "joint")))
        lift = -I * np.array(self.facts["gravity"])
        self.forces.append(Force(added, lift, at=carrier.position, name=self.name(f"{title} lift", "force")))

    def spring(self, i: int, k: int, part: Facts) -> None:
        """Build -k (x - x0) - c x_dot on a coordinate; of a ball -k theta - c w, of a free joint -k r - c v besides.

        What is free of a joint is held at the origin of the body. All is counted from the reference pose.
        """
        name, joint = self.name(f"{part['name']} spring", "spring"), self.coordinate.get(k)
        if joint is not None:
            values = {"stiffness": part["stiffness"], "damping": part["damping"], "angle": part["rest"]}
            self.forces.append(TorsionSpring(joint, **values, name=name))
        elif part["type"] in ("ball", "free"):
            stiffness, damping, free = part["stiffness"], part["damping"], part["type"] == "free"
            a, b = (GROUND, self.bodies[i]) if free else (self.made[k].a, self.made[k].b)
            self.forces.append(RotationSpring(a, b, stiffness=stiffness, damping=damping, name=name))
            if free:
                line = self.name(f"{part['name']} spring along", "spring")
                self.forces.append(Bushing(a, b, at=b.position, stiffness=stiffness, damping=damping, name=line))
        else:
            self.foreign("passive", f"stiffness or damping of {part['type']} {part['name']}", "joint", part["name"])

    def inactive_actuators(self) -> list[Facts]:
        """Say that actuators do nothing; none of them is built."""
        names = [actuator["name"] for actuator in self.facts.get("actuators", ())]
        if names:
            more = f" and {len(names) - 10} more" if len(names) > 10 else ""
            self.not_built.append(NotBuilt("actuator", ", ".join(names[:10]) + more, number=len(names)))
        return []

    def to_build(self) -> list[Facts]:
        """Return the actuators that are motors or servos of one joint, which then needs a coordinate; list the rest."""
        found = []
        for actuator in self.facts.get("actuators", ()):
            if actuator["why"]:
                self.foreign("input", f"{actuator['name']} {actuator['why']}", "actuator", actuator["name"])
            else:
                self.facts["joints"][actuator["joint"]]["actuated"] = True
                found.append(actuator)
        return found

    def actuate(self, actuator: Facts) -> None:
        """Build g u + c - k (x + x_0) - d x_dot on a coordinate, with the command u as an `Input` of its name.

        A torque along the axis, or a force along it, between the bodies of the joint; the servo is a spring and damper.
        """
        name, part = actuator["name"], self.facts["joints"][actuator["joint"]]
        joint, title = self.coordinate[actuator["joint"]], self.name(name, "actuator")
        push = actuator["gain"] * Input(name)
        if actuator["constant"]:
            push = push + actuator["constant"]
        axis = joint.a.local_axis(np.array(part["axis"]))
        load: list[Signal | float] = [x * push if x else 0.0 for x in axis.tolist()]
        ends = (joint.a, joint.b, load)
        self.forces.append(
            TorqueBetween(*ends, frame="a", name=title)
            if part["type"] == "hinge"
            else ForceBetween(*ends, frame="a", at=part["anchor"], name=title)
        )
        k, d = actuator["stiffness"], actuator["damping"]
        if k or d:
            servo = self.name(f"{name} servo", "spring")
            values = {"stiffness": k, "damping": d, "angle": -actuator["origin"]}
            self.forces.append(TorsionSpring(joint, **values, name=servo))
        limits = actuator["range"]
        self.inputs[name] = None if limits is None else (float(limits[0]), float(limits[1]))
        if actuator["limited"]:
            self.foreign("effort", f"range of {name}", "actuator", name)

    def hold_weights(self) -> None:
        """Build what balances weights: -g m G upwards at the centre of mass of a body of the file."""
        for i, body in enumerate(self.facts["bodies"]):
            share, carrier = body.get("gravcomp", 0.0), self.carrier(i)
            if share and body["mass"] and carrier is not GROUND:
                up = -share * body["mass"] * np.array(self.facts["gravity"])
                name = self.name(f"{body['name']} gravcomp", "force")
                self.forces.append(Force(carrier, up, at=body["centre"], name=name))

    def drag(self) -> None:
        """Build the drag of a fluid on the box of the inertia of each body of the file."""
        if "fluid" in self.choices.leave_out:
            return
        for i, body in enumerate(self.facts["bodies"]):
            box, carrier = body.get("fluid"), self.carrier(i)
            if box and carrier is not GROUND:
                name = self.name(f"{body['name']} fluid", "force")
                self.forces.append(FluidDrag(carrier, **box, at=body["centre"], name=name))

    def point(self, point: Facts) -> Point:
        """Return a point and its axes in those of the body that carries it."""
        body = self.carrier(point["body"])
        e = matrix(body.orientation)
        return Point(body.name, e.T @ (point["position"] - body.position), e.T @ np.array(point["axes"]).reshape(3, 3))

    def close(self, equality: Facts) -> None:
        """Build a loop closure or a coupling."""
        name = self.name(equality["name"], "equality")
        build = {"joint": self.coupling, "tendon": self.tied}.get(equality["type"], self.closure)
        made = build(equality, name)
        if made is None:
            what = f"{equality['name']} ({equality['type']})"
            self.foreign("equality", what, "equality", equality["name"])
        else:
            self.joints.append(made)

    def closure(self, equality: Facts, name: str) -> Joint | None:
        """Keep two points together, or two bodies as they are at the reference pose, in which loops are closed."""
        a, b = (self.carrier(k) for k in equality["bodies"])
        at, at_b = equality["points"]
        if a is b:
            return None
        return (Fixed if equality["type"] == "weld" else Spherical)(a, b, at=at, at_b=at_b, name=name)

    def coupling(self, equality: Facts, name: str) -> Joint | None:
        """Build y = a1 x + ... + a4 x^4 from the reference pose, where a0 has put y; without x, y stays there."""
        y, x = equality["joints"]
        a1, *rest = (*equality["polynomial"], 0.0)[1:]
        kinds = [self.facts["joints"][k]["type"].replace("screw", "hinge") for k in (y, x) if k >= 0]
        if y not in self.coordinate or (x >= 0 and x not in self.coordinate):
            return None
        follower = self.coordinate[y]
        if x < 0 or not any((a1, *rest)):
            driver = AngleDriver if kinds[0] == "hinge" else SlideDriver
            return driver(follower, 0.0, name=name)
        leader = self.coordinate[x]
        match kinds, any(rest):
            case ["hinge", "hinge"], False:
                return Gear(leader, follower, ratio=a1, name=name)
            case ["slide", "hinge"], False:
                return RackPinion(leader, follower, radius=a1, name=name)
            case ["hinge", "slide"], False:
                return RackPinion(follower, leader, radius=1.0 / a1, name=name)
        return Coupler(leader, follower, coefficients=without_zeros((0.0, a1, *rest)), name=name)

    def tied(self, equality: Facts, name: str) -> Joint | None:
        """Build y = a0 + a1 x + ... of two sums of coordinates, or y = a0 of one; None for other joints."""
        (y, y_weights), (x, x_weights) = equality["sums"]
        if not {*y, *x} <= set(self.coordinate):
            return None
        leaders, followers = self.terms(x, x_weights), self.terms(y, y_weights)
        c0, *rest = coefficients = without_zeros(equality["polynomial"])
        if set(x) & set(y) or not fits(leaders + followers):
            if len(rest) < 2:  # y - c1 x = c0, one sum
                whole = dict(zip(y, y_weights, strict=True))
                for k, weight in zip(x, x_weights, strict=True):
                    whole[k] = whole.get(k, 0.0) - sum(rest) * weight
                leaders, followers, coefficients = [], self.terms([*whole], [*whole.values()]), [c0]
            most = 1 if leaders else COORDINATES_COUNT
            followers, leaders = (self.merged(side, equality["name"], most) for side in (followers, leaders))
        return Coupler(
            [term.joint for term in leaders], [term.joint for term in followers], coefficients=coefficients,
            x_weights=[term.weight for term in leaders] or None, y_weights=[term.weight for term in followers],
            name=name,
        )  # fmt: skip

    def terms(self, joints: Sequence[int], weights: Sequence[float]) -> list[Term]:
        """Return joints of the file as the terms of a sum."""
        return [Term(self.coordinate[k], w, ((k, 1.0),)) for k, w in zip(joints, weights, strict=True) if w]

    def merged(self, terms: list[Term], title: str, most: int, bodies_max: int = SLOTS_COUNT) -> list[Term]:
        """Return the same sum in so few terms that it fits a row: others move sliders without mass by a part of it.

        A slider feels no force but those of its rows, so it passes on the load of the sum to each coordinate.
        """
        while terms and not fits(terms, most, bodies_max):
            summed, carrier = next_to_merge(terms, SLOTS_COUNT - 1)
            guide = self.slider(summed, carrier, title)
            terms = [x for x in terms if x not in summed] + [Term(guide, 1.0, parts_of(summed))]
        return terms

    def slider(self, summed: list[Term], carrier: Any, title: str, armature: float = 0.0) -> Joint:
        """Build a body without mass that slides along a carrier by a sum, and return its guide, which has armature."""
        at, e = carrier.position, carrier.orientation
        slider = Body(self.name(f"{title} sum", "body"), 0.0, np.zeros(3), position=at, orientation=e)
        name, axis = self.name(f"{title} guide", "joint"), matrix(e)[:, 0]
        guide = Prismatic(carrier, slider, at=at, axis=axis, reflected_mass=armature, name=name)
        name, weights = self.name(f"{title} row", "joint"), [term.weight for term in summed]
        row = Coupler([x.joint for x in summed], guide, coefficients=(0.0, 1.0), x_weights=weights, name=name)
        self.joints += [guide, row]
        base = next((x for x in self.frames if x.made is carrier), Frame(slider, 0, ()))
        self.frames.append(Frame(slider, base.body, base.after, base.slide + parts_of(summed)))
        return guide

    def pull(self, tendon: Facts) -> None:
        """Build spring, damper and stop of a fixed tendon, on the weighted sum of its joints."""
        if not set(tendon["joints"]) <= set(self.coordinate):
            self.foreign("tendon", f"{tendon['name']}, on a joint without a coordinate", "tendon", tendon["name"])
            return
        joints = [self.coordinate[k] for k in tendon["joints"]]
        if tendon["stiffness"] or tendon["damping"]:
            values = {name: tendon[name] for name in ("weights", "stiffness", "damping", "rest")}
            self.forces.append(SumSpring(joints, **values, name=self.name(tendon["name"], "tendon")))
        if tendon["friction"] or tendon["armature"]:
            self.resist(tendon)
        if tendon["limit"] is None:
            return
        lower, upper = tendon["limit"]
        if not self.stops or not lower < upper:
            self.foreign("limit", f"length of tendon {tendon['name']}", "tendon", tendon["name"])
            return
        how = self.stop(tendon["name"], self.felt_along(tendon))
        self.forces.append(SumStop(joints, weights=tendon["weights"], lower=lower, upper=upper, **how))

    def felt_along(self, tendon: Facts) -> float:
        """Return what a load along a fixed tendon moves at the reference pose, each joint by itself."""
        given = zip(tendon["joints"], tendon["weights"], strict=True)
        return tendon["armature"] + 1.0 / sum(w**2 / self.felt(self.facts["joints"][k]) for k, w in given)

    def resist(self, tendon: Facts) -> None:
        """Build dry friction and armature of a fixed tendon: of the guide of a body that slides by its sum."""
        terms, most = self.terms(tendon["joints"], tendon["weights"]), COORDINATES_COUNT - 1
        terms = self.merged(terms, tendon["name"], most, SLOTS_COUNT - 1)
        guide = self.slider(terms, terms[0].joint.a, tendon["name"], tendon["armature"])
        if tendon["friction"]:
            self.brake(guide, tendon["friction"], self.felt_along(tendon), tendon["name"])


def fits(terms: Sequence[Term], most: int = COORDINATES_COUNT, bodies_max: int = SLOTS_COUNT) -> bool:
    """Return whether a row has room for the bodies and coordinates of a sum."""
    return len(terms) <= most and len(bodies_of(terms)) <= bodies_max


def joints_in(equality: Facts) -> list[int]:
    """Return the numbers of joints on whose coordinates an equality acts."""
    if equality["type"] == "tendon":
        return [k for joints, _ in equality["sums"] for k in joints]
    return list(equality["joints"]) if equality["type"] == "joint" else []


def without_zeros(polynomial: Sequence[float]) -> list[float]:
    """Return coefficients without the highest ones that are zero."""
    last = max((k for k, c in enumerate(polynomial) if c), default=0)
    return list(polynomial[: last + 1])


def drawn(geoms: list[Facts], r: np.ndarray, e: np.ndarray, R: np.ndarray, meshes: "Meshes") -> list[Shape] | None:
    """Return shapes of the geometry of a body at (r, e), R = matrix(e); None where none can be drawn."""
    found: list[Shape] = []
    for geom in geoms:
        place = {
            "at": R.T @ (np.array(geom["position"]) - r),
            "orientation": multiply(conjugate(e), np.array(geom["quaternion"])),
            "colour": geom["colour"] and "#" + bytes(round(255 * x) for x in geom["colour"]).hex(),
        }
        if geom["shown"] and geom["type"] in SHAPES_BY_KIND:
            kind, sizes = SHAPES_BY_KIND[geom["type"]]
            found.append(kind(*sizes(*geom["size"]), **place))
        elif geom["shown"] and geom["type"] == "file":
            found += meshes.shapes(geom, place)
    return found or None


class Meshes:
    """Mesh files, each read once here so that a drawing will not fail; those that cannot be drawn are ``missing``."""

    def __init__(self, missing: list[str]) -> None:
        self.missing, self.bytes = missing, 0
        self.known: dict[str, bool] = {}

    def shapes(self, geom: Facts, place: dict[str, Any]) -> list[Shape]:
        """Return the shape of a mesh file, or none."""
        shape = MeshFile(geom["path"], geom["scale"], **place) if geom["path"].lower().endswith(MESH_SUFFIXES) else None
        if geom["path"] not in self.known:
            self.known[geom["path"]] = self.is_readable(shape, geom["path"])
        return [shape] if shape is not None and self.known[geom["path"]] else []

    def is_readable(self, shape: MeshFile | None, path: str) -> bool:
        """Read a file, within what all files together may have."""
        try:
            self.bytes += Path(path).stat().st_size
            if shape is None or self.bytes > MESH_BYTES_MAX:
                why = (
                    "is of no kind that is drawn" if shape is None else f"exceeds {MESH_BYTES_MAX} bytes of all meshes"
                )
                raise InputError(f"'{path}' {why}")
            check_mesh(shape.path, f"MeshFile '{shape.path}'")
        except (InputError, OSError) as error:
            self.missing.append(str(error))
            return False
        return True
