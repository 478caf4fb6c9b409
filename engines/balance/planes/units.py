"""Hypotheses H2 and H3 of the reduction to planes: identical units, each in its own plane normal to the shaft."""

from itertools import combinations
from typing import Any, NamedTuple

import numpy as np

from engines import planar
from engines.balance.planes.shaft import EXACT_TOLERANCE, Failure, PlanarJoint, Shaft, contains, pin
from mbsd3d import GROUND
from mbsd3d.extend import kinds


class Link(NamedTuple):
    """All joints between two bodies; the frame counts as the ground."""

    a: Any
    b: Any  # Moves; not the shaft
    joints: list


class Unit(NamedTuple):
    """Bodies attached to the shaft, from the shaft outwards."""

    bodies: list
    links: list[Link]
    z: float  # Of its plane, along the axis [m]

    @property
    def name(self) -> str:
        """Return the name of the first body of the unit."""
        return self.bodies[0].name


def find_units(shaft: Shaft) -> tuple[list[Unit], list[Failure]]:
    """Return chains of bodies attached to the shaft, bodies welded to it, and the failures of H2 for all others."""
    system, failures = shaft.rows.system, []
    pairs: dict[tuple, Link] = {}
    order: dict[int, int] = {}
    for body in (*shaft.parts, *system.bodies):
        order.setdefault(id(body), len(order))
    for joint in system.joints:
        ends = {id(end): end for end in (x if shaft.moves(x) else GROUND for x in joint.bodies())}
        moving = [body for body in ends.values() if body is not GROUND]
        if joint is shaft.driver or (len(moving) < 2 and all(contains(shaft.parts, body) for body in moving)):
            continue
        if len(moving) > 2:
            failures.append(Failure("H2", system.name(joint), "couples more than two bodies", len(moving), "bodies"))
            continue
        moving.sort(key=lambda body: order[id(body)])
        a, b = moving if len(moving) == 2 else (GROUND, moving[0])
        pairs.setdefault((id(a), id(b)), Link(a, b, [])).joints.append(joint)
    units, left = [], [body for body in system.bodies if shaft.moves(body) and not contains(shaft.parts, body)]
    while left:
        chain = grown([left[0]], pairs.values(), shaft)
        left = [body for body in left if not contains(chain, body)]
        links = [link for link in pairs.values() if contains(chain, link.b)]
        roots = [link.b for link in links if contains(shaft.parts, link.a)]
        if not roots:
            failures.append(Failure("H2", chain[0].name, "does not hang on the shaft", len(chain), "bodies"))
            continue
        chain = grown(roots[:1], pairs.values(), shaft)
        links.sort(key=lambda link: max(place(chain, link.a), place(chain, link.b)))
        units.append(Unit(chain, links, plane_of(shaft, chain, links)))
    if not units and not failures:
        failures.append(Failure("H2", shaft.body.name, "carries no unit", 0, "units"))
    for part in shaft.parts[1:]:
        weld = next(x for x in pairs.values() if x.b is part and contains(shaft.parts, x.a))
        units.append(Unit([part], [weld], shaft.rows.height(part.centre)))
    return units, failures


def place(chain: list, body: Any) -> int:
    """Return the position of a body in a chain; shaft and ground come before it."""
    return next((k for k, other in enumerate(chain) if other is body), -1)


def grown(chain: list, links: Any, shaft: Shaft) -> list:
    """Return a chain with all bodies linked to it but not through shaft or frame, nearest first."""
    for body in chain:
        for link in links:
            for one, other in ((link.a, link.b), (link.b, link.a)):
                if one is body and other is not GROUND and not contains((*shaft.parts, *chain), other):
                    chain.append(other)
    return chain


def plane_of(shaft: Shaft, chain: list, links: list[Link]) -> float:
    """Return the height that most points of joints and centres of mass share [m]."""
    points = [joint.point() for link in links for joint in link.joints] + [body.centre for body in chain]
    z = np.array([shaft.rows.height(point) for point in points])
    alike = np.abs(z[:, None] - z) <= EXACT_TOLERANCE * shaft.rows.length
    return float(z[np.argmax(alike.sum(axis=1))])


def out_of_plane(shaft: Shaft, units: list[Unit]) -> list[Failure]:
    """Return failures of H3: joints that force bodies out of the plane, and bodies free to leave it."""
    rows, failures = shaft.rows, []
    for unit in units:
        for link in unit.links:
            moving = [body for body in link[:2] if body is not GROUND]
            tilt = rows.tilt(link.joints, moving, unit.z)
            if tilt <= EXACT_TOLERANCE:
                continue
            name = rows.system.name(link.joints[0])
            heights = [rows.height(joint.point()) for joint in link.joints]
            off = max((z - unit.z for z in heights), key=abs)
            if (
                abs(off) > EXACT_TOLERANCE * rows.length
                and rows.tilt(link.joints, moving, unit.z + off) <= EXACT_TOLERANCE
            ):
                failures.append(Failure("H3", name, f"is beside the plane of '{unit.name}'", off, "m"))
            else:
                text = f"is tilted against the plane of '{unit.name}'"
                failures.append(Failure("H3", name, text, np.degrees(tilt), "deg"))
    moving = [(body, unit.z) for unit in units for body in unit.bodies]
    for motion in rows.loose(*zip(*moving, strict=True)) if moving else ():
        body = moving[int(np.argmax(np.linalg.norm(motion, axis=1)))][0]
        failures.append(Failure("H3", body.name, "is free to leave its plane", 1, "freedom"))
    return failures


def planar_joint(shaft: Shaft, link: Link, z: float, bodies: dict) -> PlanarJoint | Failure | None:
    """Return the planar joint equivalent to the in-plane rows of a link, by their wrenches, or None without such
    rows."""
    rows = shaft.rows
    at, turn = rows.flat(link.b.position), np.array([[0.0, 0.0, 1.0]])
    W = rows.wrenches(link.joints, link.b, z, rows.poses[0])
    blocked = len(W) and np.linalg.norm(turn @ W.T) > 1 - EXACT_TOLERANCE
    a = shaft.body if contains(shaft.parts, link.a) else link.a  # its slice represents the whole shaft
    ends = bodies.get(id(a), planar.GROUND), bodies[id(link.b)]
    name = rows.system.name(link.joints[0])
    if len(W) == 0:
        return None
    if len(W) == 3:
        return planar.Fixed(*ends, at=at, name=name)
    if len(W) == 2 and blocked:
        across = (W - (W @ turn.T) @ turn)[:, :2]
        push = across[np.argmax(np.linalg.norm(across, axis=1))]
        return planar.Slider(*ends, at=at, axis=(push[1], -push[0]), name=name)
    if len(W) == 2 and np.linalg.matrix_rank(W[:, :2], EXACT_TOLERANCE) == 2 and fixed_centre(shaft, link, z):
        return planar.Revolute(*ends, at=at + centre(W, rows.length), name=name)
    if len(W) == 1 and [row.kind for joint in link.joints for row in joint.primitives] == [kinds.DISTANCE]:
        rod = link.joints[0]
        a, b = (rows.flat(end) for end in ((rod.at_a, rod.at_b) if rod.b is link.b else (rod.at_b, rod.at_a)))
        return planar.Distance(*ends, at_a=a, at_b=b, length=rod.length, name=name)
    text = "works in its plane, but the planar models here know only hinges, slides, rods and welds"
    return Failure("H3", name, text, len(W), "rows in the plane")


def centre(W: np.ndarray, length: float) -> np.ndarray:
    """Return the point d through which all forces of (2, 3) wrenches go [m]: d x f = moment."""
    return np.linalg.solve(np.stack([W[:, 1], -W[:, 0]], axis=1), length * W[:, 2])


def fixed_centre(shaft: Shaft, link: Link, z: float) -> bool:
    """Return whether the centre of a link is fixed in both bodies, from one pose to the other."""
    rows, (before, after) = shaft.rows, shaft.rows.poses
    for body in (link.a, link.b):
        if body is GROUND:
            continue
        both = [rows.wrenches(link.joints, body, z, pose) for pose in (before, after)]
        if len(both[1]) != 2 or np.linalg.matrix_rank(both[1][:, :2], EXACT_TOLERANCE) != 2:
            return False
        arms = [centre(W, rows.length) for W in both]
        angle = 0.3 + 0.1 * np.sin(1.0 + 5.0 * rows.index[id(body)])
        c, s = np.cos(angle), np.sin(angle)
        if np.linalg.norm(np.array([[c, -s], [s, c]]) @ arms[0] - arms[1]) > 1e-7 * rows.length:
            return False
    return True


def signature(shaft: Shaft, unit: Unit, joints: list[PlanarJoint], bodies: dict) -> list[tuple[str, str, float]]:
    """Return (quantity, unit, value) of the properties two units must share, independent of phase, bank and station."""
    found: list[tuple[str, str, float]] = [("number of bodies", "bodies", len(unit.bodies))]
    for spatial in unit.bodies:
        body, label = bodies[id(spatial)], f"of '{spatial.name}'"
        found += [(f"mass {label}", "kg", body.mass), (f"inertia {label}", "kg m^2", body.inertia)]
        own = [joint for joint in joints if joint.a is body or joint.b is body]
        found += [(f"number of joints {label}", "joints", len(own))]
        slides = [joint for joint in own if isinstance(joint, planar.Slider)]
        marks = marked(body, own)
        for (i, p), (k, q) in combinations(enumerate(marks), 2):
            found.append((f"distance {i}-{k} of joints and centre of mass {label}", "m", float(np.hypot(*(q - p)))))
        for p, q, r in combinations(marks, 3):
            area = (q - p)[0] * (r - p)[1] - (q - p)[1] * (r - p)[0]
            found.append((f"twice the area between joints and centre of mass {label}", "m^2", float(area)))
        for slide in slides:
            other = slide.b if slide.a is body else slide.a
            holds = isinstance(other, planar.Body) and marked(other, [x for x in joints if other in (x.a, x.b)])
            arm, axis = marks[0] - (holds[0] if holds else shaft.point), slide.axis
            axis = axis if axis @ arm > 0 else -axis
            found.append((f"offset of the slide {label}", "m", float(axis[0] * arm[1] - axis[1] * arm[0])))
            lean = marks[-1] - marks[0]
            found.append(
                (f"centre of mass across the slide {label}", "m", float(axis[0] * lean[1] - axis[1] * lean[0]))
            )
    for joint in joints:
        if joint.a is bodies[id(shaft.body)]:
            found.append(("crank radius", "m", float(np.hypot(*(pin(joint, joint.a) - shaft.point)))))
        if isinstance(joint, planar.Distance):
            found.append((f"length of '{joint.name}'", "m", joint.length))
    return found


def marked(body: planar.Body, joints: list[PlanarJoint]) -> list[np.ndarray]:
    """Return the points of a body at its joints [m], the centre of mass last."""
    return [pin(joint, body) for joint in joints if not isinstance(joint, planar.Slider)] + [body.position + body.com]


def unlike(shaft: Shaft, units: list[Unit], joints: list[list], bodies: dict) -> list[Failure]:
    """Return failures of H2: where units differ from the first one in bodies or joints; loads may differ."""
    first, failures = None, []
    for unit, own in zip(units, joints, strict=True):
        if contains(shaft.parts, unit.bodies[0]):
            continue
        mine = signature(shaft, unit, own, bodies)
        first = first or mine
        if len(mine) != len(first):
            text = f"is built otherwise than '{units[0].name}'"
            failures.append(Failure("H2", unit.name, text, len(unit.bodies), "bodies"))
            continue
        for (what, si, value), (_, _, model) in zip(mine, first, strict=True):
            scale = {"m": shaft.rows.length, "m^2": shaft.rows.length**2}.get(si, abs(model))
            if abs(value - model) > EXACT_TOLERANCE * max(scale, EXACT_TOLERANCE):
                text = f"differs from '{units[0].name}': {what} is {value:.9g} {si}, not {model:.9g}"
                failures.append(Failure("H2", unit.name, text, value - model, si))
    return failures
