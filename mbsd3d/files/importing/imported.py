"""What an import found: the system, and all of the file that is not part of it, by what it would do to the motion."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ...base.errors import InputError
from ...base.style import html_text
from ...base.wording import counted
from ...mechanism.mechanism import Mechanism
from ...mechanism.state import State

ALWAYS_ACTING = (
    "armature", "equality", "flex", "fluid", "frictionloss", "gravcomp", "include", "inertial", "input", "joints",
    "passive", "tendon",
)  # fmt: skip
"""Kinds that act on every motion: built, or the file is refused."""
ACTING_AT_TIMES = {
    "actuator": "actuator", "limit": "limit", "effort": "effort limit", "velocity": "velocity limit",
    "safety": "safety controller", "mocap": "mocap body", "switched-off": "switched-off equality", "sleep": "sleep",
    "contact": "contact",
}  # fmt: skip
"""Kinds that act at times or on command, with what one is called: inactive, and said."""
IDLE_KINDS = ("extension",)  # without effect, which callers of older versions left out by name
KINDS = (*ALWAYS_ACTING, *ACTING_AT_TIMES, *IDLE_KINDS)
SHOWN_MAX = 20  # [1] parts that an error lists


class NotBuilt(NamedTuple):
    """Something of a file that is not part of the system."""

    kind: str
    what: str
    place: str = ""  # line and element
    number: int = 1  # of them; 0: nobody has counted
    watched: bool = False  # a limit that the certificate watches

    def __str__(self) -> str:
        return f"{self.kind}: {self.what}" + (f" ({self.place})" if self.place else "")


class Point(NamedTuple):
    """A point with axes that is fixed in a body: a site of MJCF, the frame of a link that is part of another body."""

    body: str  # name of the body, or "ground"
    position: np.ndarray  # (3,) from O of the body, in its axes [m]
    axes: np.ndarray  # (3, 3) R, axes of the point -> body axes


class Imported(NamedTuple):
    """An imported system, and what the import merged, renamed and left out.

    ``merged`` maps bodies without a joint to the body they are part of; ``renamed`` maps names the system uses to those
    of the file (a joint of the name of a body); ``dropped`` lists what acts and was left out on behalf of
    ``leave_out``; ``idle`` counts elements without effect on the motion (geoms, sites, cameras, sensors, key frames,
    tags of vendors). ``inactive``: one line on what acts at times or on command (actuators, limits, contact), which
    does nothing here; the certificate of every run repeats it. ``said``: what the import had to choose. ``missing``:
    meshes that are not drawn. ``states``: key frames by name; ``points``: sites and frames by name.
    ``inputs``: names of the `Input` signals that ``inputs=True`` asks for, each with the range of the file, or None.

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
    >>> print(found)
    1 joint, 1 body
    """

    system: Mechanism
    merged: dict[str, str]
    renamed: dict[str, str]
    dropped: tuple[str, ...]
    idle: dict[str, int]
    inactive: str = ""
    said: tuple[str, ...] = ()
    missing: tuple[str, ...] = ()
    states: dict[str, State] = {}  # noqa: RUF012 - given anew by every import
    points: dict[str, Point] = {}  # noqa: RUF012 - given anew by every import
    inputs: dict[str, tuple[float, float] | None] = {}  # noqa: RUF012 - given anew by every import

    def __repr__(self) -> str:
        return f"<imported: {self}>"

    def _repr_html_(self) -> str:
        return html_text(str(self))

    def __str__(self) -> str:
        system = self.system
        parts = [f"{counted(len(system.joints), 'joint')}, {counted(len(system.bodies), 'body')}"]
        parts += [f"inactive: {self.inactive}"] if self.inactive else []
        parts += list(self.said)
        if self.missing:
            drawn = any(body.shape is not None for body in system.bodies)
            meshes = counted(len(self.missing), "mesh file")
            parts.append(f"{meshes} not drawn" if drawn else "no geometry (meshes missing)")
        return "; ".join(parts)


class Verdict(NamedTuple):
    """What becomes of all that was not built."""

    dropped: tuple[str, ...]
    inactive: str
    notes: tuple[str, ...]  # of the system, for certificates


def judged(found: Sequence[NotBuilt], leave_out: Sequence[str], strict: bool) -> Verdict:
    """Sort what was not built, or raise an error that names what acts always and is not left out."""
    dropped = [part for part in found if part.kind in leave_out and part.kind not in IDLE_KINDS]
    rest = [part for part in found if part.kind not in leave_out and part.kind not in IDLE_KINDS]
    refused = [part for part in rest if strict or part.kind in ALWAYS_ACTING]
    if refused:
        shown = "; ".join(map(str, refused[:SHOWN_MAX]))
        shown += f"; and {len(refused) - SHOWN_MAX} more" if len(refused) > SHOWN_MAX else ""
        kinds = ", ".join(f'"{kind}"' for kind in sorted({part.kind for part in refused} - {"joints"}))
        remedy = f"; leave out with leave_out=[{kinds}]" if kinds else ""
        raise InputError(f"cannot import {shown}{remedy}, or change the file")
    inactive, gone = inactive_line(rest), tuple(f"{part.kind}: {part.what}" for part in dropped)
    notes = [f"inactive: {inactive}"] if inactive else []
    notes += [f"left out: {'; '.join(gone[:SHOWN_MAX])}"] if gone else []
    return Verdict(gone, inactive, tuple(notes))


def inactive_line(parts: Sequence[NotBuilt]) -> str:
    """Write what acts at times or on command in a line: "29 actuators, 29 limits (watched), contact"."""
    words = []
    for kind, noun in ACTING_AT_TIMES.items():
        found = [part for part in parts if part.kind == kind]
        count, watched = sum(part.number for part in found), sum(part.watched for part in found)
        if count:
            words.append(counted(count, noun))
        elif found:
            words.append(noun)
        if watched:
            words[-1] += " (watched)" if watched == count else f" ({watched} watched)"
    return ", ".join(words)


def grouped(keys: Any) -> dict[int, list[int]]:
    """Return key -> the places where it stands."""
    found: dict[int, list[int]] = {}
    for place, key in enumerate(keys):
        found.setdefault(key, []).append(place)
    return found
