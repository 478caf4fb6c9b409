"""Page of a live run: the scene at its start, and the data by which its scripts move it."""

import json
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from markupsafe import Markup

from ...base.templates import page_template
from ...kernels import kinds
from ...mechanism.bodies import GROUND
from ...mechanism.joints import PointJoint
from ...mechanism.mechanism import Mechanism
from ...run.live_model import Built, Control, Playable
from ..page.content import Content, player_data
from ..page.html import as_script, asset
from ..page.recorder import Recording, client_head, printable
from ..page.stage import Stage
from ..scene.artist import draw_system
from ..scene.drawing import poses_of
from ..scene.frames import Frames
from ..scene.overlays import nearby

SCENE_SCRIPTS = ("unpack.js", "scene.js", "curves.js", "common.js")
LIVE_RUN_SCRIPTS = ("strips.js", "gamepad.js", "ride.js")
SECONDS = 10.0  # [s] of the model that the live curves show
SHAPE_KEYS = ("vertices", "faces", "points")  # of the messages of nodes

Shapes = Mapping[str, Mapping[str, list[float]]]  # node -> what makes its shape
NO_SHAPES: Shapes = {}


class Look(NamedTuple):
    """Look of a live run."""

    title: str
    layers: tuple[str, ...]
    followed: int = -1  # number of the body that the camera goes along with
    view: Sequence[float] | None = None  # azimuth and elevation at first [degrees]
    dark: bool | None = None


def ride_page(model: Playable, built: Built, look: Look) -> str:
    """Return the HTML of the page."""
    recording, (r, e) = Recording("play"), poses_of(built.system, built.state)
    still, drawing = Frames(np.array([built.state.t]), r[None], e[None]), draw_system(built.system)
    content = Content(*nearby(drawing, still), [], 1.0, look.title, look.layers, followed=look.followed)
    pivot = pivot_of(built.system) if look.followed < 0 else None
    stage = Stage(
        recording.scene, recording.camera, *content[:2], shown=look.layers, endless=True, view=look.view,
        pivot=None if pivot is None else pivot - drawing.origin,
    )  # fmt: skip
    bodies = built.system.bodies
    data = player_data(content, stage) | {
        "moving": [*range(len(bodies))],
        "bodies": [[i, body.name] for i, body in enumerate(bodies)],
        "controls": [control_data(control) for control in model.controls],
        "origin": drawing.origin.tolist(),
        "panels": [panel._asdict() for panel in model.panels],
        "seconds": SECONDS,
    }
    texts = {
        "style": asset("player.css") + asset("ride.css", __package__),
        "scene": recording.data(),
        "client": client_head(),
        "data": as_script(data),
        "script": "\n".join(
            [asset(name) for name in SCENE_SCRIPTS] + [asset(name, __package__) for name in LIVE_RUN_SCRIPTS]
        ),
        "dark": json.dumps(look.dark),
    }
    marked = {name: Markup(text) for name, text in texts.items()}
    return page_template("ride.html").render(title=printable(look.title), controls=bool(model.controls), **marked)


def pivot_of(system: Mechanism) -> np.ndarray | None:
    """Return the one point of the ground that a mechanism hangs on or stands on [m]; None if there are none or more.

    What is held at several points does not leave far the box that it takes at first.
    """
    pivots = [
        joint.at for joint in system.joints
        if isinstance(joint, PointJoint) and GROUND in (joint.a, joint.b)
        and any(row.kind == kinds.COINCIDE for row in joint.primitives)
    ]  # fmt: skip
    return pivots[0] if len(pivots) == 1 else None


def control_data(control: Control) -> dict[str, object]:
    """Return the data of a control for the page."""
    return {
        "name": control.name, "low": control.low, "high": control.high, "value": control.value, "unit": control.unit,
        "keys": [list(pair) for pair in control.keys], "pad": control.pad, "springs": control.springs,
        "hint": control.hint,
    }  # fmt: skip


def shapes_of(system: Mechanism) -> Shapes:
    """Return meshes and lines of the bodies, as the nodes of the scene hold them."""
    recording = Recording("play")
    r, e = poses_of(system)
    still = Frames(np.zeros(1), r[None], e[None])
    Stage(recording.scene, recording.camera, *nearby(draw_system(system), still))
    found = {}
    for message in recording.recorder.messages.values():
        name, props = getattr(message, "name", ""), getattr(message, "props", None)
        shape = {key: np.ravel(getattr(props, key)).tolist() for key in SHAPE_KEYS if hasattr(props, key)}
        if shape and name.startswith("/bodies/"):
            found[name] = shape
    return found
