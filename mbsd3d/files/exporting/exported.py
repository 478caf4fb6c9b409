"""What an export wrote: the text, where its frames lie, and what of the system is not in it as it is here."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree import ElementTree

import numpy as np

from ...base.checks import as_tuple, short_repr
from ...base.errors import InputError
from ...base.paths import as_path, write_atomically
from ...base.style import html_text
from ...base.wording import counted
from ...mechanism.forces.springs import JointFriction, TorsionSpring
from ...mechanism.joints import Joint
from ...mechanism.joints.pairs import Prismatic, Revolute
from ...mechanism.limits import Limit
from ...mechanism.mechanism import Mechanism
from ..importing.imported import Point

UNLIMITED_RANGE = 1e9  # [rad, m] of a coordinate without limits, where a format asks for some
WHOLE = Point("", np.zeros(3), np.eye(3))  # a frame that is that of its body


class NotExportable(InputError):  # noqa: N818 - a verdict, not a mistake
    """Error of a system with a part that a format has no element for; the text names the part and the reason."""


class Exported(NamedTuple):
    """A system as text of another format, and what of it is not as it is here.

    ``text``: the whole file; ``path``: where it was written, or None. ``frames``: name of a body of the file -> body of
    the system, and origin and axes of its frame in that body. ``soft``: joints that hold exactly here and by springs
    there. ``inactive``: what was left out for the caller, or does nothing here and is watched only. ``said``: what the
    export had to choose. ``meshes``: name of an OBJ file -> its text, of shapes that the format has no solid for; they
    are written beside the file.

    Examples
    --------
    >>> from mbsd3d import GROUND, Body, Gear, Revolute, System
    >>> one, two = (Body(name, mass=1.0, inertia=(0.1, 0.1, 0.2)) for name in ("one", "two"))
    >>> a, b = (Revolute(GROUND, x, at=(0, 0, 0), axis=(0, 0, 1), name=n) for x, n in ((one, "a"), (two, "b")))
    >>> made = System([one, two], [a, b, Gear(a, b, ratio=-2, name="gear")]).to_mjcf()
    >>> made.soft, made.frames["one"].body
    (('gear',), 'one')
    """

    text: str
    path: Path | None = None
    frames: dict[str, Point] = {}  # noqa: RUF012 - given anew by every export
    soft: tuple[str, ...] = ()
    inactive: tuple[str, ...] = ()
    said: tuple[str, ...] = ()
    meshes: dict[str, str] = {}  # noqa: RUF012 - given anew by every export

    def __repr__(self) -> str:
        return f"<exported: {self}>"

    def _repr_html_(self) -> str:
        return html_text(str(self))

    def __str__(self) -> str:
        parts = [f"'{self.path}'" if self.path else f"{len(self.text)} characters"]
        parts += [f"soft: {', '.join(self.soft)}"] if self.soft else []
        parts += [f"inactive: {', '.join(self.inactive)}"] if self.inactive else []
        parts += [counted(len(self.meshes), "mesh file")] if self.meshes else []
        return "; ".join([*parts, *self.said])


def called(system: Mechanism, part: Any) -> str:
    """Name a joint or force with its class: "joint 'hinge' (Revolute)"."""
    return f"{'joint' if isinstance(part, Joint) else 'force'} '{system.name(part)}' ({type(part).__name__})"


def without(system: Mechanism, leave_out: Sequence[Any]) -> tuple[Mechanism, tuple[str, ...]]:
    """Return the system without the joints and forces that the caller leaves out, and their names."""
    given = (leave_out,) if isinstance(leave_out, str) else as_tuple(leave_out, "leave_out", "joints and forces")
    parts = [*system.joints, *system.forces]
    known = {id(part): part for part in parts}
    by_name = {system.name(part): part for part in parts}
    gone: set[int] = set()
    for wanted in given:
        part = by_name.get(wanted) if isinstance(wanted, str) else known.get(id(wanted))
        if part is None:
            have = ", ".join(f"'{name}'" for name in by_name) or "none"
            raise InputError(f"leave_out: {short_repr(wanted)} is not a joint or force of the system; there are {have}")
        gone.add(id(part))
    if not gone:
        return system, ()
    names = tuple(system.name(part) for part in parts if id(part) in gone)
    for part in parts:
        if lost := next((other for other in part.partners() if id(other) in gone and id(part) not in gone), None):
            text = f"{called(system, part)} acts through '{system.name(lost)}', which is left out; leave it out too"
            raise NotExportable(text)
    joints = [joint for joint in system.joints if id(joint) not in gone]
    forces = [force for force in system.forces if id(force) not in gone]
    limits = [limit for limit in system.limits if id(limit.joint) not in gone]
    return Mechanism(system.bodies, joints, forces, system.gravity, title=system.title, limits=limits), names


def refuse(system: Mechanism, found: Iterable[tuple[Any, str]], fmt: str) -> None:
    """Raise an error that lists all parts that cannot be written, each with its reason, if there are any."""
    refused = list(found)
    if refused:
        text = "; ".join(f"{called(system, part)}: {why}" for part, why in refused)
        names = ", ".join(f'"{system.name(part)}"' for part, _ in refused)
        raise NotExportable(f"{fmt} cannot hold {text}; leave out with leave_out=[{names}], or change the system")


def numbers(*values: Any) -> str:
    """Write numbers that read back bit for bit; -0.0 is 0."""
    return " ".join(repr(float(x) + 0.0) for value in values for x in np.ravel(value))


def add(parent: ElementTree.Element, tag: str, /, **attributes: str) -> ElementTree.Element:
    """Add an element to another; return it."""
    return ElementTree.SubElement(parent, tag, attributes)


def range_of(limits: Sequence[Limit]) -> tuple[float, float] | None:
    """Return the range that all limits leave, None without any."""
    if not limits:
        return None
    lower = max(-UNLIMITED_RANGE if limit.lower is None else limit.lower for limit in limits)
    return lower, min(UNLIMITED_RANGE if limit.upper is None else limit.upper for limit in limits)


class Loads(NamedTuple):
    """Spring and damper of a hinge or slider: -stiffness (x - rest) - damping x_dot."""

    stiffness: float
    rest: float
    damping: float


def loads_of(system: Mechanism, joint: Joint) -> Loads:
    """Return what springs, dampers and viscous friction on a joint add up to: -k1 (x - x1) - k2 (x - x2) is one."""
    on = [x for x in system.forces if isinstance(x, TorsionSpring | JointFriction) and x.hinge is joint]
    springs = [x for x in on if isinstance(x, TorsionSpring) and x.stiffness]
    stiffness = sum(x.stiffness for x in springs)
    rest = sum(x.stiffness * x.angle for x in springs) / stiffness if springs else 0.0
    return Loads(stiffness, rest, sum(x.viscous if isinstance(x, JointFriction) else x.damping for x in on))


def foreign_loads(system: Mechanism, what: str, springs: bool) -> list[tuple[Any, str]]:
    """Return the forces that are not dampers (or ``springs``) of hinges and sliders, with the reason."""
    found: list[tuple[Any, str]] = []
    for force in system.forces:
        known = isinstance(force, TorsionSpring) and (springs or force.stiffness == 0.0)
        known |= isinstance(force, JointFriction) and force.coulomb == 0.0
        if not known:
            found.append((force, f"the format has {what} of joints only"))
        elif not isinstance(force.hinge, Revolute | Prismatic):  # type: ignore[attr-defined]
            found.append((force, f"the format has {what} of hinges and sliders only"))
    return found


def foreign_rotors(system: Mechanism) -> list[tuple[Any, str]]:
    """Return the joints with a reflected inertia, which URDF and SDF have no element for."""
    with_rotor = [joint for joint in system.joints if any(inertia for _, inertia in joint.reflected())]
    return [(joint, "its reflected inertia has no place in the format; set it to 0") for joint in with_rotor]


def moments_of(inertia: np.ndarray) -> dict[str, str]:
    """Return the entries of an inertia by the names that URDF and SDF have for them."""
    pairs = [(a, b) for a in range(3) for b in range(a, 3)]
    return {f"i{'xyz'[a]}{'xyz'[b]}": numbers(inertia[a, b]) for a, b in pairs}


def not_written(system: Mechanism) -> list[str]:
    """Return the limits that are not those of hinges and sliders."""
    return [limit.what() for limit in system.limits if not isinstance(limit.joint, Revolute | Prismatic)]


def roll_pitch_yaw(R: np.ndarray) -> np.ndarray:
    """Return the angles of R = Rz(yaw) Ry(pitch) Rx(roll) [rad].

    By atan2, where asin loses half the digits near 90 degrees; there roll is of no great meaning, and yaw follows from
    R Rx(-roll), so that both together are right.
    """
    roll = np.arctan2(R[2, 1], R[2, 2])
    s, c = np.sin(roll), np.cos(roll)
    pitch = np.arctan2(-R[2, 0], np.hypot(R[2, 1], R[2, 2]))
    return np.array([roll, pitch, np.arctan2(s * R[0, 2] - c * R[0, 1], c * R[1, 1] - s * R[1, 2])])


def xml_text(root: ElementTree.Element) -> str:
    """Return an XML text with one element a line."""
    ElementTree.indent(root)
    return ElementTree.tostring(root, "unicode") + "\n"


def written(made: Exported, path: str | Path | None, suffixes: Sequence[str], replace: bool) -> Exported:
    """Write a text to its file, whole or not at all, and the meshes it names; without a path it stays a text."""
    if path is None:
        return made
    place = as_path(path, f"model{suffixes[0]}")
    if place.suffix.lower() not in suffixes:
        raise InputError(f"'{place}': the name does not end in {' or '.join(suffixes)}; give one that does")
    made = made._replace(path=write_atomically(place, made.text.encode(), replace=replace))
    for name, text in made.meshes.items():  # a name is that of its content: what is there is the same
        write_atomically(place.parent / name, text.encode())
    return made
