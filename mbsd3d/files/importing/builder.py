"""A system from the facts of a compiled MuJoCo model (`worker`), and what of them has no counterpart here."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import InputError
from ...base.mass_properties import MassProperties, combine
from ...base.rotations import conjugate, matrix, multiply
from ...mechanism.bodies import GROUND, Body
from ...mechanism.couplings import Gear, RackPinion
from ...mechanism.drivers import AngleDriver, SlideDriver
from ...mechanism.forces.springs import TorsionSpring
from ...mechanism.joints import Joint
from ...mechanism.joints.pairs import Cylindrical, Fixed, Planar, Prismatic, Revolute, Spherical, Universal
from ...mechanism.mechanism import Mechanism
from ...mechanism.shapes.base import Shape
from ...mechanism.shapes.kinds import Box, Capsule, Cylinder, Ellipsoid, Sphere

KINDS = (
    "actuator", "armature", "contact", "equality", "extension", "flex", "fluid", "frictionloss", "gravcomp", "inertial",
    "limit", "mocap", "passive", "tendon",
)  # fmt: skip
SMALL = 1e-9  # [1, m] what axes and points that are taken as one may differ by: rounding, not tolerances of a part


class Imported(NamedTuple):
    """An imported system, and what the import merged, renamed and dropped.

    ``merged`` maps bodies without a joint to the body they are part of; ``renamed`` maps names the system uses to those
    of the file (a joint of the name of a body); ``dropped`` lists everything left out on behalf of ``drop``; ``idle``
    counts elements without effect on the motion (geoms, sites, cameras, sensors, key frames).

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from mbsd3d import read_mjcf
    >>> text = '''<mujoco><worldbody><body name="arm"><joint name="arm"/><geom size="0.1"/>
    ...   <body name="hand" pos="0 0 1"><geom size="0.2"/></body></body></worldbody></mujoco>'''
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, "arm.xml")
    ...     _ = path.write_text(text)
    ...     found = read_mjcf(path)
    >>> found.merged, found.idle
    ({'hand': 'arm'}, {'geom': 2})
    """

    system: Mechanism
    merged: dict[str, str]
    renamed: dict[str, str]
    dropped: tuple[str, ...]
    idle: dict[str, int]


class Builder:
    """A system from the facts of a compiled model."""

    def __init__(self, facts: dict[str, Any], unknown: list[tuple[str, str]], drop: tuple[str, ...]) -> None:
        self.facts, self.drop = facts, drop
        self.foreign = [tuple(entry) for entry in facts["foreign"]] + unknown
        self.bodies: dict[int, Any] = {0: GROUND}
        self.group = grouped(body["weld"] for body in facts["bodies"])  # what is welded to a body, itself first
        self.joints_of = grouped(joint["body"] for joint in facts["joints"])
        self.names: set[str] = {GROUND.name}
        self.renamed: dict[str, str] = {}
        self.joints: list[Joint] = []
        self.forces: list[TorsionSpring] = []
        self.joint_of: dict[int, Joint] = {}  # number of a MuJoCo joint that is a joint of its own

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
        for equality in self.facts["equalities"]:
            self.close(equality)
        left = [f"{kind}: {what}" for kind, what in self.foreign if kind not in self.drop]
        if left:
            shown = "; ".join(left[:20]) + (f"; and {len(left) - 20} more" if len(left) > 20 else "")
            kinds = sorted({kind for kind, _ in self.foreign if kind in KINDS})
            remedy = f"; leave out with drop={kinds}" if kinds else ""
            raise InputError(f"cannot import {shown}{remedy}, or change the file")
        if len(self.bodies) == 1:
            raise InputError("no body of it can move; give one a joint")
        system = Mechanism(list(self.bodies.values())[1:], self.joints, self.forces, gravity=self.facts["gravity"])
        dropped = tuple(f"{kind}: {what}" for kind, what in self.foreign)
        return Imported(system, merged, self.renamed, dropped, {k: n for k, n in self.facts["idle"].items() if n})

    def name(self, wanted: str, kind: str) -> str:
        """A unique name: joints and bodies share one list of names here."""
        name = wanted
        while name in self.names:
            name = f"{name} ({kind})"
        if name != wanted:
            self.renamed[name] = wanted
        self.names.add(name)
        return name

    def body(self, i: int) -> Body:
        """A body with all that is welded to it; R'(x_G - x_O) and R' I_G R put it into its own axes."""
        group = [self.facts["bodies"][k] for k in self.group[i]]
        r, R = np.array(group[0]["position"]), matrix(group[0]["quaternion"])
        parts = [
            (part["mass"], R.T @ (np.array(part["centre"]) - r), R.T @ np.array(part["inertia"]) @ R) for part in group
        ]
        parts = [part for part in parts if part[0] > 0.0]
        whole = combine(parts) if parts else MassProperties(0.0, np.zeros(3), np.zeros((3, 3)))
        name, e = self.name(group[0]["name"], "body"), np.array(group[0]["quaternion"])
        look = drawn([geom for part in group for geom in part["geoms"]], r, e, R)
        return Body(name, **vars(whole), position=r, orientation=e, shape=look)

    def parent(self, i: int) -> Any:
        """The body that carries body i."""
        return self.bodies[self.facts["bodies"][self.facts["bodies"][i]["parent"]]["weld"]]

    def join(self, i: int, places: list[int]) -> None:
        """The joint between a body and its parent, with its springs and dampers."""
        parts = [self.facts["joints"][k] for k in places]
        if [part["type"] for part in parts] != ["free"]:
            name = "-".join(part["name"] for part in parts)
            made = joint_of(self.parent(i), self.bodies[i], parts, self.name(name, "joint"))
            if made is None:
                types = ", ".join(f"{part['type']} {part['name']}" for part in parts)
                self.foreign.append(("joints", f"{types} of body {self.bodies[i].name}, which make no joint of mbsd3d"))
                return
            self.joints.append(made)
            for k, part in zip(places, parts, strict=True):
                coordinate = made.angle() if part["type"] == "hinge" else made.slide()
                if part["type"] in ("hinge", "slide") and coordinate is not None:
                    self.joint_of[k] = made
        for k, part in zip(places, parts, strict=True):
            self.spring(part, self.joint_of.get(k))

    def spring(self, part: dict[str, Any], joint: Joint | None) -> None:
        """-k (x - x0) - c x_dot on a coordinate, x counted from the reference pose."""
        if part["stiffness"] == 0.0 and part["damping"] == 0.0:
            return
        wanted = "angle" if part["type"] == "hinge" else "slide"
        if joint is None or (wanted == "slide" and joint.angle() is not None):
            self.foreign.append(("passive", f"stiffness or damping of {part['type']} {part['name']}"))
            return
        name = self.name(f"{part['name']} spring", "spring")
        values = {"stiffness": part["stiffness"], "damping": part["damping"], "angle": part["rest"]}
        self.forces.append(TorsionSpring(joint, **values, name=name))

    def close(self, equality: dict[str, Any]) -> None:
        """A loop closure or a coupling."""
        name = self.name(equality["name"], "equality")
        made = self.coupling(equality, name) if equality["type"] == "joint" else self.closure(equality, name)
        if made is None:
            self.foreign.append(("equality", f"{equality['name']} ({equality['type']})"))
        else:
            self.joints.append(made)

    def closure(self, equality: dict[str, Any], name: str) -> Joint | None:
        """Two points kept together, or two bodies kept as they are at the reference pose."""
        a, b = (self.bodies[self.facts["bodies"][k]["weld"]] for k in equality["bodies"])
        at, at_b = equality["points"]
        if a is b or equality["turn"] > SMALL:
            return None
        return (Fixed if equality["type"] == "weld" else Spherical)(a, b, at=at, at_b=at_b, name=name)

    def coupling(self, equality: dict[str, Any], name: str) -> Joint | None:
        """y = a0 + a1 x of two coordinates counted from the reference pose; without x, y stays at a0."""
        y, x = equality["joints"]
        a0, a1, *rest = equality["polynomial"]
        kinds = [self.facts["joints"][k]["type"] for k in (y, x) if k >= 0]
        if y not in self.joint_of or (x >= 0 and x not in self.joint_of):
            return None
        follower = self.joint_of[y]
        if x < 0:
            return (AngleDriver if kinds == ["hinge"] else SlideDriver)(follower, a0, name=name)
        if a0 != 0.0 or any(rest) or a1 == 0.0 or kinds == ["slide", "slide"]:
            return None
        leader = self.joint_of[x]
        if kinds == ["hinge", "hinge"]:
            return Gear(leader, follower, ratio=a1, name=name)
        if kinds == ["slide", "hinge"]:
            return RackPinion(leader, follower, radius=a1, name=name)
        return RackPinion(follower, leader, radius=1.0 / a1, name=name)


def grouped(keys: Iterable[int]) -> dict[int, list[int]]:
    """Key -> the places where it stands."""
    found: dict[int, list[int]] = {}
    for place, key in enumerate(keys):
        found.setdefault(key, []).append(place)
    return found


def joint_of(a: Any, b: Any, parts: list[dict[str, Any]], name: str) -> Joint | None:
    """The joint that allows the same motion as MuJoCo's joints of one body, or None."""
    hinges = [part for part in parts if part["type"] == "hinge"]
    slides = [part for part in parts if part["type"] == "slide"]
    first = parts[0]
    at = (hinges or parts)[0]["anchor"]
    axes = np.array([part["axis"] for part in (*hinges, *slides)])
    meet = all(np.linalg.norm(np.subtract(part["anchor"], at)) < SMALL for part in hinges)
    if first["type"] == "ball":
        return Spherical(a, b, at=at, name=name) if len(parts) == 1 else None
    match len(hinges), len(slides):
        case 1, 0:
            return Revolute(a, b, at=at, axis=axes[0], name=name)
        case 0, 1:
            return Prismatic(a, b, at=at, axis=axes[0], name=name)
        case 1, 1 if np.linalg.norm(axes[0] - axes[1]) < SMALL:
            return Cylindrical(a, b, at=at, axis=axes[0], name=name)
        case 2, 0 if meet and abs(axes[0] @ axes[1]) < SMALL:
            return Universal(a, b, at=at, axis_a=axes[0], axis_b=axes[1], name=name)
        case 3, 0 if meet and abs(np.linalg.det(axes)) > 1e-3:  # at 0 the hinges are locked
            return Spherical(a, b, at=at, name=name)
        case 1, 2 if np.abs(axes[1:] @ axes[0]).max() < SMALL and np.linalg.norm(np.cross(*axes[1:])) > 1e-3:
            return Planar(a, b, at=at, normal=axes[0], name=name)
    return None


def drawn(geoms: list[dict[str, Any]], r: np.ndarray, e: np.ndarray, R: np.ndarray) -> list[Shape] | None:
    """Shapes of the geoms of a body at (r, e), R = matrix(e); None where none can: meshes, planes, height fields."""
    found = []
    for geom in geoms:
        a, b, c = geom["size"]
        place = {
            "at": R.T @ (np.array(geom["position"]) - r),
            "orientation": multiply(conjugate(e), np.array(geom["quaternion"])),
            "colour": geom["colour"] and "#" + bytes(round(255 * x) for x in geom["colour"]).hex(),
        }
        sizes = {
            "box": (Box, ((2 * a, 2 * b, 2 * c),)),
            "sphere": (Sphere, (a,)),
            "capsule": (Capsule, (a, 2 * b)),
            "cylinder": (Cylinder, (a, 2 * b)),
            "ellipsoid": (Ellipsoid, ((a, b, c),)),
        }
        if geom["shown"] and geom["type"] in sizes:
            kind, numbers = sizes[geom["type"]]
            found.append(kind(*numbers, **place))
    return found or None
