"""A system from the facts of a model, whichever format they come from, and what of them has no counterpart here."""

from collections.abc import Callable
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import InputError
from ...base.mass_properties import TRIANGLE_RULE_TOLERANCE, MassProperties, put_together
from ...base.rotations import conjugate, matrix, multiply
from ...base.style import counted
from ...mechanism.bodies import GROUND, Body
from ...mechanism.couplings import Gear, RackPinion
from ...mechanism.drivers import AngleDriver, SlideDriver
from ...mechanism.force_element import ForceElement
from ...mechanism.forces.applied import Force
from ...mechanism.forces.between import ForceBetween, TorqueBetween
from ...mechanism.forces.brake import Brake
from ...mechanism.forces.bushing import Bushing
from ...mechanism.forces.fluid_drag import FluidDrag
from ...mechanism.forces.springs import TorsionSpring
from ...mechanism.joints import Joint
from ...mechanism.joints.pairs import Fixed, Revolute, Spherical
from ...mechanism.limits import Limit
from ...mechanism.mechanism import Mechanism
from ...mechanism.shapes.shape import Shape
from ...mechanism.shapes.solids import Box, Capsule, Cylinder, Ellipsoid, MeshFile, Sphere
from ...mechanism.shapes.triangles import MESH_SUFFIXES, check_mesh
from ...mechanism.signals.signal import Input, Signal
from .facts import Facts, carried, felt_inertia, length_of
from .imported import Imported, NotBuilt, Point, grouped, judged
from .joints import acts_along, check_independent, has_coordinate, joint_of
from .keyframes import Frame, state_of

MOMENT_ROUNDING = 1e-12  # [m L^2] of mass and extent of the model: a negative principal moment that is rounding
ROTOR_MASS_SHARE = 1e-9  # [1] of the whole mass, for a rotor that stands for an armature: a body with inertia needs one
MESH_BYTES_MAX = 50_000_000  # [bytes] of all mesh files that are drawn: some seconds
BRAKE_YIELD = 1e-3  # [rad, m] that a brake for dry friction yields before it slips
SHAPES_BY_KIND: dict[str, tuple[type[Shape], Callable[[float, float, float], tuple[Any, ...]]]] = {
    "box": (Box, lambda a, b, c: ((2 * a, 2 * b, 2 * c),)),
    "sphere": (Sphere, lambda a, b, c: (a,)),
    "capsule": (Capsule, lambda a, b, c: (a, 2 * b)),
    "cylinder": (Cylinder, lambda a, b, c: (a, 2 * b)),
    "ellipsoid": (Ellipsoid, lambda a, b, c: ((a, b, c),)),
}
"""Kinds of geometry with a shape of their own, and its sizes."""


class Choices(NamedTuple):
    """What the caller of an import chose."""

    leave_out: tuple[str, ...] = ()
    strict: bool = False
    inertia: str = "as given"
    geometry: str = "draw"
    inputs: bool = False


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
        self.coupled = {k for e in facts["equalities"] if e["type"] == "joint" for k in e["joints"]}
        self.length = length_of(facts)
        self.names: set[str] = {GROUND.name}
        self.renamed: dict[str, str] = {}
        self.said: list[str] = list(facts.get("said", ()))
        self.missing: list[str] = list(facts.get("missing", ())) if choices.geometry == "draw" else []
        self.meshes = Meshes(self.missing)
        self.frames: list[Frame] = []  # of all bodies, in their order
        self.rotors: list[Frame] = []  # on the ground, which turn as a joint of the file moves
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
        self.hold_weights()
        self.drag()
        for actuator in self.actuators:
            self.actuate(actuator)
        if brakes := sum(isinstance(force, Brake) for force in self.forces):
            self.said.append(f"dry friction of {counted(brakes, 'joint')} yields by {BRAKE_YIELD:g} rad or m at rest")
        verdict = judged(self.not_built, self.choices.leave_out, self.choices.strict)
        if len(self.bodies) == 1:
            raise InputError("no body of it can move; give one a joint")
        self.frames += self.rotors
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
                raise InputError(f"{self.called(body.name)}: a {part['type']} joint cannot follow another; change it")
            self.joints.append(made)
            self.made[k] = made
            inner = outer
        return frames

    def load(self, i: int, k: int, part: Facts) -> None:
        """Build what acts on a joint: springs, dampers, dry friction, limits."""
        joint, kind, what = self.coordinate.get(k), part["type"], f"{part['type']} {part['name']}"
        for load in ("stiffness", "damping", "friction", "armature"):
            if part[load] < 0.0:
                raise InputError(f"{self.called(part['name'], 'joint')}: {load} {part[load]:g} < 0; give >= 0")
        if part["stiffness"] or part["damping"]:
            self.spring(i, k, part)
        if part["armature"] and joint is not None:
            self.rotor(k, part, joint)
        if part["friction"]:
            if joint is None:
                self.foreign("frictionloss", what, "joint", part["name"])
            else:
                stiffness = part["friction"] / BRAKE_YIELD
                felt = felt_inertia(self.carried[part["body"]], part) + part["armature"]
                damping = np.sqrt(stiffness * max(felt, MOMENT_ROUNDING))
                values = {"torque": part["friction"], "stiffness": stiffness, "damping": damping}
                self.forces.append(Brake(joint, **values, name=self.name(f"{part['name']} friction", "friction")))
        if part["limit"] is not None:
            watched = joint is not None
            self.foreign("limit", f"range of {part['name']}", "joint", part["name"], watched=watched)
            if joint is not None and "limit" not in self.choices.leave_out:
                name = part["name"] if part["name"] != joint.name else ""
                lower, upper = part["limit"]
                self.limits.append(Limit(joint, "slide" if kind == "slide" else "angle", lower, upper, name))

    def rotor(self, k: int, part: Facts, joint: Joint) -> None:
        """Build an armature, T = I x_dot^2 / 2 on a coordinate x: a rotor on the ground that turns as x does.

        A rotor that the parent carries would feel its turning too; the ground takes nothing but the rotor's own torque.
        """
        title, I = f"{part['name']} armature", part["armature"]
        mass = ROTOR_MASS_SHARE * self.carried[0].mass
        look = Sphere(BRAKE_YIELD * self.length)
        at = np.array(part["anchor"])
        rotor = Body(self.name(title, "body"), mass, (I, I, I), position=at, shape=look)
        axle = Revolute(GROUND, rotor, at=at, axis=(0, 0, 1), name=self.name(f"{title} axle", "joint"))
        name = self.name(f"{title} gear", "joint")
        gear = (
            Gear(axle, joint, ratio=1.0, name=name)
            if part["type"] == "hinge"
            else RackPinion(axle, joint, radius=1.0, name=name)
        )
        self.rotors.append(Frame(rotor, 0, (), k))
        self.joints += [axle, gear]

    def spring(self, i: int, k: int, part: Facts) -> None:
        """Build -k (x - x0) - c x_dot on a coordinate from the reference pose; -c w or -c v without a coordinate.

        The damping of a free joint acts at the origin of the body.
        """
        name, joint = self.name(f"{part['name']} spring", "spring"), self.coordinate.get(k)
        if joint is not None:
            values = {"stiffness": part["stiffness"], "damping": part["damping"], "angle": part["rest"]}
            self.forces.append(TorsionSpring(joint, **values, name=name))
        elif part["stiffness"] == 0.0 and part["type"] in ("ball", "free"):
            c, free = part["damping"], part["type"] == "free"
            a, b = (GROUND, self.bodies[i]) if free else (self.made[k].a, self.made[k].b)
            at, c_line = (b.position, c) if free else (part["anchor"], 0.0)
            self.forces.append(Bushing(a, b, at=at, stiffness=0.0, damping=c_line, turning_damping=c, name=name))
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
        made = self.coupling(equality, name) if equality["type"] == "joint" else self.closure(equality, name)
        if made is None:
            self.foreign("equality", f"{equality['name']} ({equality['type']})", "equality", equality["name"])
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
        """Build y = a1 x of two coordinates from the reference pose, where a0 has put y; without x, y stays there."""
        y, x = equality["joints"]
        _, a1, *rest = equality["polynomial"]
        kinds = [self.facts["joints"][k]["type"].replace("screw", "hinge") for k in (y, x) if k >= 0]
        if y not in self.coordinate or (x >= 0 and x not in self.coordinate):
            return None
        follower = self.coordinate[y]
        if x >= 0 and any(rest):
            return None
        if x < 0 or a1 == 0.0:
            driver = AngleDriver if kinds[0] == "hinge" else SlideDriver
            return driver(follower, 0.0, name=name)
        leader = self.coordinate[x]
        match kinds:
            case ["hinge", "hinge"]:
                return Gear(leader, follower, ratio=a1, name=name)
            case ["slide", "hinge"]:
                return RackPinion(leader, follower, radius=a1, name=name)
            case ["hinge", "slide"]:
                return RackPinion(follower, leader, radius=1.0 / a1, name=name)
        return self.racks(leader, x, follower, a1, name)

    def racks(self, leader: Joint, place: int, follower: Joint, ratio: float, name: str) -> Joint:
        """Build two slides in a fixed ratio: racks on a pinion without mass; ``place`` is the number of the leader."""
        pinion = Body(self.name(f"{name} pinion", "body"), 0.0, np.zeros(3))
        axle = Revolute(GROUND, pinion, at=(0, 0, 0), axis=(0, 0, 1), name=self.name(f"{name} axle", "joint"))
        self.rotors.append(Frame(pinion, 0, (), place))
        self.joints += [axle, RackPinion(axle, leader, radius=1.0, name=self.name(f"{name} rack", "joint"))]
        return RackPinion(axle, follower, radius=ratio, name=name)


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
