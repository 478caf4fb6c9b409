"""SDF of a system: links where the bodies are, joints between them in any graph, in a world with its gravity."""

from collections.abc import Sequence
from typing import Any
from xml.etree.ElementTree import Element

import numpy as np

from ...base.fields import true_or_false
from ...base.rotations import perpendiculars
from ...mechanism.bodies import GROUND, Body
from ...mechanism.couplings import Gear, RackPinion
from ...mechanism.joints import Joint
from ...mechanism.joints.pairs import Cylindrical, Fixed, Planar, Prismatic, Revolute, Screw, Spherical, Universal
from ...mechanism.mechanism import Mechanism
from ...mechanism.state import State
from .exported import (
    UNLIMITED_RANGE,
    WHOLE,
    Exported,
    NotExportable,
    add,
    foreign_loads,
    foreign_rotors,
    loads_of,
    moments_of,
    not_written,
    numbers,
    range_of,
    refuse,
    roll_pitch_yaw,
    without,
    xml_text,
)
from .looks import Look, Looks, start_of

VERSION = "1.11"  # the first one that has mimics; the rest is 1.7
KINDS: dict[type, str] = {
    Revolute: "revolute", Prismatic: "prismatic", Spherical: "ball", Universal: "universal", Screw: "screw",
    Fixed: "fixed",
}  # fmt: skip
BY_MASSLESS_LINKS = (Cylindrical, Planar)
LOOK_KINDS = ("box", "sphere", "cylinder", "capsule", "ellipsoid")  # the solids of the format
FIT_TOLERANCE = 1e-12  # [m, 1] by which a joint may be open at the reference pose: rounding


def write_sdf(system: Mechanism, leave_out: Sequence[Any], massless: bool) -> Exported:
    """Return the SDF of a system."""
    true_or_false(massless, "massless", None)
    kept, gone = without(system, leave_out)
    refuse(kept, foreign(kept, massless), "SDF")
    root = Element("sdf", version=VERSION)
    title = kept.title or "mbsd3d"
    world = add(root, "world", name=title)
    put(world, "gravity", numbers(kept.gravity))
    model = add(world, "model", name=title)
    frames, names, looks = {}, names_of(kept), Looks(LOOK_KINDS)
    crosses = {id(body): cross for body in kept.bodies if not body.mass and (cross := cross_of(kept, body, massless))}
    for body in kept.bodies:
        if id(body) not in crosses:
            frames[names[id(body)]] = WHOLE._replace(body=body.name)
            write_link(model, names[id(body)], body, looks)
    paired = {id(joint) for pair in crosses.values() for joint in pair}
    single = [joint for joint in kept.joints if type(joint) in KINDS and id(joint) not in paired]
    elements = {id(joint): write_joint(model, kept, names, joint) for joint in single}
    for body in kept.bodies:
        if id(body) in crosses:
            write_cross(model, kept, names, body, crosses[id(body)])
    rows = [joint for joint in kept.joints if isinstance(joint, BY_MASSLESS_LINKS)]
    for row in rows:
        write_row(model, names, row)
    for joint in kept.joints:
        if isinstance(joint, Gear | RackPinion):
            couple(model, names, joint, elements)
    start, said = start_of(kept)
    if start and (rows or crosses):
        said = ["velocities at the start are not written, as a state has none of links without mass"]
    elif start:
        write_state(world, kept, names, start)
    return Exported(
        xml_text(root), None, frames, (), (*gone, *not_written(kept)), (*said, *looks.missing), looks.meshes
    )  # fmt: skip


def names_of(system: Mechanism) -> dict[int, str]:
    """Return the names of all parts: "::" is between names of models there, and some names are reserved."""
    found: dict[int, str] = {id(GROUND): "world", 0: "__model__", -1: "__root__"}
    for part in (*system.bodies, *system.joints):
        found[id(part)] = unique(found, system.name(part).replace("::", "_"))
    return found


def unique(names: dict[int, str], name: str) -> str:
    """Return a name that no part has, and list it."""
    while name in names.values():
        name += "_"
    names[-len(names)] = name
    return name


def foreign(system: Mechanism, massless: bool) -> list[tuple[Any, str]]:
    """Return joints and forces that have no counterpart, with the reason."""
    found: list[tuple[Any, str]] = []
    for joint in system.joints:
        if isinstance(joint, Gear | RackPinion):
            if not all(isinstance(x, Revolute | Prismatic) for x in joint.partners()):
                found.append((joint, "the format couples hinges and sliders only"))
        elif isinstance(joint, BY_MASSLESS_LINKS) and not massless:
            found.append((joint, "it takes links without mass, which Gazebo refuses; give massless=True"))
        elif type(joint) not in KINDS and not isinstance(joint, BY_MASSLESS_LINKS):
            found.append((joint, "the format has no such joint"))
        elif is_open(joint):
            found.append((joint, "its parts do not meet at the reference pose, and the format has one frame for both"))
    return found + foreign_rotors(system) + foreign_loads(system, "springs and dampers", springs=True)


def is_open(joint: Any) -> bool:
    """Return whether points or axes of a joint differ on both bodies at the reference pose."""
    gap = np.abs(joint.at - joint.at_b).max()
    if isinstance(joint, Revolute | Prismatic | Screw | Cylindrical):
        gap = max(gap, np.abs(joint.axis - joint.axis_b).max())
    return bool(gap > FIT_TOLERANCE)


def cross_of(system: Mechanism, body: Body, massless: bool) -> tuple[Revolute, Revolute] | None:
    """Return the two hinges of a body without mass, through one point: a joint of two axes there; else it is a link."""
    joints: list[Any] = [joint for joint in system.joints if body in joint.bodies()]
    two = len(joints) == 2 and all(isinstance(joint, Revolute) for joint in joints)
    if two and np.abs(joints[0].at - joints[1].at).max() <= FIT_TOLERANCE:
        return joints[0], joints[1]
    if massless:
        return None
    raise NotExportable(
        f"body '{body.name}': its mass is 0, and SDF needs a positive one but between two hinges through one point; "
        "give it a mass, or massless=True for readers that take links without"
    )


def write_cross(
    model: Element, system: Mechanism, names: dict[int, str], body: Body, hinges: tuple[Revolute, Revolute]
) -> None:
    """Write two hinges over a body without mass as one joint; the ground is never its child."""
    first, second = hinges
    if (second.b if second.a is body else second.a) is GROUND:
        first, second = second, first
    a, b = (hinge.b if hinge.a is body else hinge.a for hinge in (first, second))
    element = begin(model, names[id(first)], first.at, "revolute2", (names[id(a)], names[id(b)]))
    for tag, hinge, sense in (("axis", first, first.b is body), ("axis2", second, second.a is body)):
        axis = add(element, tag)
        put(axis, "xyz", numbers(hinge.axis if sense else -hinge.axis))
        load(axis, system, hinge)


def put(parent: Element, tag: str, text: str, **attributes: str) -> Element:
    """Add an element with a text; return it."""
    made = add(parent, tag, **attributes)
    made.text = text
    return made


def write_link(model: Element, name: str, body: Body, looks: Looks) -> None:
    """Write a link with its mass and shapes; its frame is that of the body."""
    link = add(model, "link", name=name)
    put(link, "pose", numbers(body.position, roll_pitch_yaw(body.axes)))
    inertial = add(link, "inertial")
    put(inertial, "pose", numbers(body.com, np.zeros(3)))
    put(inertial, "mass", numbers(body.mass))
    inertia = add(inertial, "inertia")
    for tag, value in moments_of(body.inertia).items():
        put(inertia, tag, value)
    for k, look in enumerate(looks.of(body)):
        write_look(link, look, k)


def write_look(link: Element, look: Look, k: int) -> None:
    """Write a shape of a link."""
    visual = add(link, "visual", name=f"visual {k}")
    put(visual, "pose", numbers(look.r, roll_pitch_yaw(look.R)))
    shape = add(add(visual, "geometry"), look.kind)
    match look.kind:
        case "box" | "ellipsoid":
            put(shape, "size" if look.kind == "box" else "radii", numbers(look.sizes))
        case "mesh":
            put(shape, "uri", look.file)
        case _:
            for tag, value in zip(("radius", "length"), look.sizes, strict=False):
                put(shape, tag, numbers(value))
    if look.rgba:
        put(add(visual, "material"), "diffuse", look.rgba)


def write_state(world: Element, system: Mechanism, names: dict[int, str], start: State) -> None:
    """Write poses and velocities of the links, world axes."""
    state = add(world, "state", world_name="start")
    model = add(state, "model", name=str(world.get("name")))
    for body, v in zip(system.bodies, start.v.reshape(-1, 6), strict=True):
        link = add(model, "link", name=names[id(body)])
        put(link, "pose", numbers(body.position, roll_pitch_yaw(body.axes)))
        put(link, "velocity", numbers(v))


def write_row(model: Element, names: dict[int, str], joint: Cylindrical | Planar) -> None:
    """Write slides and a hinge in a row, over links without mass at the point of the joint."""
    turned = joint.b is GROUND
    ends, sense = ((joint.b, joint.a), -1.0) if turned else ((joint.a, joint.b), 1.0)
    axis: Any = joint.axis if isinstance(joint, Cylindrical) else joint.normal
    slides = [axis] if isinstance(joint, Cylindrical) else perpendiculars(axis)
    steps = [*(("prismatic", x) for x in slides), ("revolute", axis)]
    before = names[id(ends[0])]
    for k, (kind, along) in enumerate(steps):
        last, title = k == len(steps) - 1, unique(names, f"{names[id(joint)]} {k + 1}")
        link = names[id(ends[1])] if last else unique(names, f"{title} link")
        if not last:
            write_link(model, link, Body(link, 0.0, np.zeros(3), position=joint.at), Looks(()))
        element = begin(model, title, joint.at, kind, (before, link))
        put(add(element, "axis"), "xyz", numbers(sense * along), expressed_in="__model__")
        before = link


def begin(model: Element, name: str, at: np.ndarray, kind: str, ends: tuple[str, str]) -> Element:
    """Write the start of a joint between two links, in the axes of the world."""
    element = add(model, "joint", name=name, type=kind)
    put(element, "pose", numbers(at, np.zeros(3)), relative_to="__model__")
    for tag, link in zip(("parent", "child"), ends, strict=True):
        put(element, tag, link)
    return element


def write_joint(model: Element, system: Mechanism, names: dict[int, str], joint: Any) -> Element:
    """Write a joint; the ground is never the child, so that both bodies and the sense of the axes may be exchanged."""
    turned = joint.b is GROUND
    a, b = (joint.b, joint.a) if turned else (joint.a, joint.b)
    element = begin(model, names[id(joint)], joint.at, KINDS[type(joint)], (names[id(a)], names[id(b)]))
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
    """Write springs, dampers and limits of an axis."""
    spring = loads_of(system, joint)
    values = {"damping": spring.damping}
    if spring.stiffness:
        values |= {"spring_reference": spring.rest, "spring_stiffness": spring.stiffness}
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
