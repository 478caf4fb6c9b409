"""SDF of a system: links where the bodies are, joints between them in any graph, in a world with its gravity."""

from collections.abc import Sequence
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from ...mechanism.bodies import GROUND, Body
from ...mechanism.couplings import Gear, RackPinion
from ...mechanism.forces.springs import JointFriction, TorsionSpring
from ...mechanism.joints import Joint
from ...mechanism.joints.pairs import Fixed, Prismatic, Revolute, Screw, Spherical, Universal
from ...mechanism.mechanism import Mechanism
from .exported import (
    UNLIMITED_RANGE,
    WHOLE,
    Exported,
    NotExportable,
    add,
    numbers,
    range_of,
    refuse,
    roll_pitch_yaw,
    without,
    xml_text,
)

VERSION = "1.11"  # the first one that has mimics; the rest is 1.7
KINDS: dict[type, str] = {
    Revolute: "revolute", Prismatic: "prismatic", Spherical: "ball", Universal: "universal", Screw: "screw",
    Fixed: "fixed",
}  # fmt: skip
FIT_TOLERANCE = 1e-12  # [m, 1] by which a joint may be open at the reference pose: rounding


def write_sdf(system: Mechanism, leave_out: Sequence[Any]) -> Exported:
    """Return the SDF of a system."""
    kept, gone = without(system, leave_out)
    refuse(kept, foreign(kept), "SDF")
    root = Element("sdf", version=VERSION)
    title = kept.title or "mbsd3d"
    world = add(root, "world", name=title)
    put(world, "gravity", numbers(kept.gravity))
    model = add(world, "model", name=title)
    frames, names = {}, names_of(kept)
    crosses = {id(body): cross_of(kept, body) for body in kept.bodies if not body.mass}
    for body in kept.bodies:
        if id(body) not in crosses:
            frames[names[id(body)]] = WHOLE._replace(body=body.name)
            write_link(model, names[id(body)], body)
    paired = {id(joint) for pair in crosses.values() for joint in pair}
    single = [joint for joint in kept.joints if type(joint) in KINDS and id(joint) not in paired]
    elements = {id(joint): write_joint(model, kept, names, joint) for joint in single}
    for body in kept.bodies:
        if id(body) in crosses:
            write_cross(model, kept, names, body, crosses[id(body)])
    for joint in kept.joints:
        if isinstance(joint, Gear | RackPinion):
            couple(model, names, joint, elements)
    return Exported(xml_text(root), None, frames, (), gone, ())


def names_of(system: Mechanism) -> dict[int, str]:
    """Return the names of all parts: "::" is between names of models there, and some names are reserved."""
    found: dict[int, str] = {id(GROUND): "world"}
    taken = {"world", "__model__", "__root__"}
    for part in (*system.bodies, *system.joints):
        name = system.name(part).replace("::", "_")
        while name in taken:
            name += "_"
        found[id(part)] = name
        taken.add(name)
    return found


def foreign(system: Mechanism) -> list[tuple[Any, str]]:
    """Return joints and forces that have no counterpart, with the reason."""
    found: list[tuple[Any, str]] = []
    for joint in system.joints:
        if isinstance(joint, Gear | RackPinion):
            if not all(isinstance(x, Revolute | Prismatic) for x in joint.partners()):
                found.append((joint, "the format couples hinges and sliders only"))
        elif type(joint) not in KINDS:
            found.append((joint, "the format has no such joint"))
        elif is_open(joint):
            found.append((joint, "its parts do not meet at the reference pose, and the format has one frame for both"))
    for force in system.forces:
        damps = isinstance(force, TorsionSpring) or (isinstance(force, JointFriction) and force.coulomb == 0.0)
        if not damps:
            found.append((force, "the format has springs and dampers of joints only"))
        elif not isinstance(force.hinge, Revolute | Prismatic):  # type: ignore[attr-defined]
            found.append((force, "the format has springs and dampers of hinges and sliders only"))
    return found


def is_open(joint: Any) -> bool:
    """Return whether points or axes of a joint differ on both bodies at the reference pose."""
    gap = np.abs(joint.at - joint.at_b).max()
    if isinstance(joint, Revolute | Prismatic | Screw):
        gap = max(gap, np.abs(joint.axis - joint.axis_b).max())
    return bool(gap > FIT_TOLERANCE)


def cross_of(system: Mechanism, body: Body) -> tuple[Revolute, Revolute]:
    """Return the two hinges of a body without mass, through one point: a joint of two axes there."""
    joints: list[Any] = [joint for joint in system.joints if body in joint.bodies()]
    two = len(joints) == 2 and all(isinstance(joint, Revolute) for joint in joints)
    if not two or np.abs(joints[0].at - joints[1].at).max() > FIT_TOLERANCE:
        raise NotExportable(
            f"body '{body.name}': its mass is 0, and SDF needs a positive one but between two hinges through one point"
        )
    return joints[0], joints[1]


def write_cross(
    model: Element, system: Mechanism, names: dict[int, str], body: Body, hinges: tuple[Revolute, Revolute]
) -> None:
    """Write two hinges over a body without mass as one joint; the ground is never its child."""
    first, second = hinges
    if (second.b if second.a is body else second.a) is GROUND:
        first, second = second, first
    a, b = (hinge.b if hinge.a is body else hinge.a for hinge in (first, second))
    element = begin(model, names, first, "revolute2", (a, b))
    for tag, hinge, sense in (("axis", first, first.b is body), ("axis2", second, second.a is body)):
        axis = add(element, tag)
        put(axis, "xyz", numbers(hinge.axis if sense else -hinge.axis))
        load(axis, system, hinge)


def put(parent: Element, tag: str, text: str, **attributes: str) -> Element:
    """Add an element with a text; return it."""
    made = add(parent, tag, **attributes)
    made.text = text
    return made


def write_link(model: Element, name: str, body: Body) -> None:
    """Write a link with its mass; its frame is that of the body."""
    link = add(model, "link", name=name)
    put(link, "pose", numbers(body.position, roll_pitch_yaw(body.axes)))
    inertial = add(link, "inertial")
    put(inertial, "pose", numbers(body.com, np.zeros(3)))
    put(inertial, "mass", numbers(body.mass))
    inertia = add(inertial, "inertia")
    for a, b in ("xx", "xy", "xz", "yy", "yz", "zz"):
        put(inertia, f"i{a}{b}", numbers(body.inertia["xyz".index(a), "xyz".index(b)]))


def begin(model: Element, names: dict[int, str], joint: Any, kind: str, ends: tuple[Any, Any]) -> Element:
    """Write the start of a joint between two bodies, in the axes of the world."""
    element = add(model, "joint", name=names[id(joint)], type=kind)
    put(element, "pose", numbers(joint.at, np.zeros(3)), relative_to="__model__")
    for tag, body in zip(("parent", "child"), ends, strict=True):
        put(element, tag, names[id(body)])
    return element


def write_joint(model: Element, system: Mechanism, names: dict[int, str], joint: Any) -> Element:
    """Write a joint; the ground is never the child, so that both bodies and the sense of the axes may be exchanged."""
    turned = joint.b is GROUND
    a, b = (joint.b, joint.a) if turned else (joint.a, joint.b)
    element = begin(model, names, joint, KINDS[type(joint)], (a, b))
    axes = [joint.axis_a, joint.axis_b] if isinstance(joint, Universal) else []
    axes += [joint.axis] if isinstance(joint, Revolute | Prismatic | Screw) else []
    for tag, axis in zip(("axis", "axis2"), [-x for x in reversed(axes)] if turned else axes, strict=False):
        put(add(element, tag), "xyz", numbers(axis))
    if isinstance(joint, Screw):
        put(element, "screw_thread_pitch", numbers(joint.pitch))
    if isinstance(joint, Revolute | Prismatic):
        load(axis_of(element), system, joint)
    return element


def axis_of(joint: Element) -> Element:
    """Return the only axis of a joint."""
    return next(child for child in joint if child.tag == "axis")


def load(axis: Element, system: Mechanism, joint: Joint) -> None:
    """Write springs, dampers and limits of an axis; -k1 (x - x1) - k2 (x - x2) is one spring."""
    on = [x for x in system.forces if isinstance(x, TorsionSpring | JointFriction) and x.hinge is joint]
    springs = [x for x in on if isinstance(x, TorsionSpring) and x.stiffness]
    stiffness = sum(x.stiffness for x in springs)
    values = {"damping": sum(x.viscous if isinstance(x, JointFriction) else x.damping for x in on)}
    if springs:
        rest = sum(x.stiffness * x.angle for x in springs) / stiffness
        values |= {"spring_reference": rest, "spring_stiffness": stiffness}
    if any(values.values()):
        dynamics = add(axis, "dynamics")
        for tag, value in values.items():
            put(dynamics, tag, numbers(value))
    ends = range_of([limit for limit in system.limits if limit.joint is joint])
    if ends is not None:
        limit = add(axis, "limit")
        for tag, value in zip(("lower", "upper"), ends, strict=True):
            if abs(value) < UNLIMITED_RANGE:  # what is not given is no limit there
                put(limit, tag, numbers(value))


def couple(model: Element, names: dict[int, str], joint: Gear | RackPinion, elements: dict[int, Element]) -> None:
    """Write a gearbox between two hinges on one body, else a mimic of the second coordinate."""
    lead, follower = joint.partners()
    ratio = joint.ratio if isinstance(joint, Gear) else joint.radius
    common = [x for x in (lead.a, lead.b) if x in (follower.a, follower.b) and x is not GROUND]
    hinges = isinstance(lead, Revolute) and isinstance(follower, Revolute)
    if not hinges or not common or GROUND in (lead.a, lead.b, follower.a, follower.b):
        mimic = add(axis_of(elements[id(follower)]), "mimic", joint=names[id(lead)])
        put(mimic, "multiplier", numbers(ratio))
        return
    gearbox = add(model, "joint", name=names[id(joint)], type="gearbox")
    for tag, hinge in (("parent", lead), ("child", follower)):
        put(gearbox, tag, names[id(hinge.b if hinge.a is common[0] else hinge.a)])
    for tag, hinge in (("axis", lead), ("axis2", follower)):
        axis: Any = hinge.axis if hinge.a is common[0] else -hinge.axis  # type: ignore[attr-defined]
        put(add(gearbox, tag), "xyz", numbers(axis), expressed_in="__model__")
    put(gearbox, "gearbox_ratio", numbers(-ratio))
    put(gearbox, "gearbox_reference_body", names[id(common[0])])
