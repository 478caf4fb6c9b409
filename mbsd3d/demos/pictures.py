"""The pictures of the README: ``python -m mbsd3d.demos.pictures docs/pictures`` (or ``make pictures``) makes them."""

import io
import sys
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from mbsd3d import GROUND, Body, PointOnLine, Revolute, Solution, System, Universal, rotation, simulate
from mbsd3d.base import inertia
from mbsd3d.base.paths import write_atomically
from mbsd3d.base.style import COLOURS
from mbsd3d.mechanism.shapes import Box, Cylinder, Disc
from mbsd3d.view.scene.layers import NAMES

from .heavy_top import falling_top

STEEL, RED, BLUE = "#8A9BA8", COLOURS[1], COLOURS[0]
BARE = (*NAMES, "ground grid")


def t_handle() -> Solution:
    """A T-handle thrown across the view and spun about its stem, the axis of its middle moment of inertia."""
    bar, stem = (0.4, 0.012, 0.12, "x"), (0.25, 0.014, 0.075, "z")
    solid = inertia.combine(
        [
            (bar[0], (0.0, 0.0, 0.0), inertia.cylinder(*bar)),
            (stem[0], (0.0, 0.0, 0.01 + 0.5 * stem[2]), inertia.cylinder(*stem)),
        ]
    )
    shape = [
        Cylinder(*bar[1:], at=(0, 0, 0), colour=BLUE),
        Cylinder(*stem[1:], at=(0, 0, 0.01 + 0.5 * stem[2]), colour=RED),
    ]
    body = Body("T-handle", **vars(solid), velocity=(0.5, 0, 0), omega=(0.1, 0.4, 14.0), shape=shape)
    return simulate(System([body], gravity=(0, 0, 0)), 2.8, output=1121)


def fork(sign: float, across: int, colour: str) -> list[Any]:
    """Shapes of a shaft along x from the origin to ``sign`` infinity, with a fork across y or z and a flywheel."""
    side = np.eye(3)[across]
    prong = np.array([0.17, 0.06, 0.06]) + (-0.02 * side)
    prongs = [Box(prong, at=k * 0.11 * side + (sign * 0.045, 0, 0), colour=colour) for k in (-1, 1)]
    base = Box(np.array([0.04, 0.06, 0.06]) + 0.2 * side, at=(sign * 0.15, 0, 0), colour=colour)
    rod = Cylinder(0.03, 0.4, "x", at=(sign * 0.34, 0, 0), colour=colour)
    wheel = Disc(0.15, 0.05, "x", at=(sign * 0.4, 0, 0), colour=colour)
    pin = Cylinder(0.02, 0.29, "xyz"[across], at=(0, 0, 0), colour=STEEL)
    return [*prongs, base, rod, wheel, pin]


def cardan_joint() -> Solution:
    """Two shafts at 40 degrees with forks, a cross between them, and flywheels that are out of balance."""
    bend = np.radians(40.0)
    along = np.array([np.cos(bend), np.sin(bend), 0.0])
    solid = {"mass": 4.0, "inertia": (0.05, 0.1, 0.1)}
    drive = Body("drive", **solid, com=(-0.4, 0.02, 0.01), omega=(14.0, 0, 0), shape=fork(-1, 1, BLUE))
    turned = rotation("z", bend)
    driven = Body("driven", **solid, com=(0.4, 0.0, 0.02), orientation=turned, shape=fork(1, 2, RED))
    joints = [
        Revolute(GROUND, drive, at=(-0.53, 0, 0), axis=(1, 0, 0), name="bearing"),
        Universal(drive, driven, at=(0, 0, 0), axis_a=(0, 1, 0), axis_b=(0, 0, 1), name="cross"),
        PointOnLine(GROUND, driven, at=0.53 * along, axis=along, name="support"),
    ]
    return simulate(System([drive, driven], joints), 1.0, output=201)


def png(figure: Any) -> bytes:
    """A figure as PNG with 256 colours: a third of the bytes, and no difference to be seen."""
    raw, small = io.BytesIO(), io.BytesIO()
    figure.savefig(raw, format="png", dpi=130, facecolor=figure.get_facecolor())
    Image.open(raw).convert("RGB").quantize(256, dither=Image.Dither.NONE).save(small, "PNG", optimize=True)
    return small.getvalue()


def make(folder: Path) -> list[Path]:
    """Write the three pictures into a folder that exists."""
    flip = np.linspace(0.6, 2.76, 10)
    handle, joint, top = t_handle(), cardan_joint(), simulate(falling_top(), 1.53, output=601)
    tip = [("T-handle", (0.0, 0.0, 0.09))]
    strip = handle.picture(flip, traces=tip, size=(9.0, 2.6), view=(-70, 14), hidden=BARE)
    forces = joint.picture(0.3, traces=(), shown=["reaction force", "reaction moment"], size=(6.4, 3.6), view=(-70, 26))
    return [
        top.export_gif(folder / "heavy_top.gif", width=400, height=320, traces=[("top", (0, 1.25, 0))], hidden=NAMES),
        write_atomically(folder / "dzhanibekov.png", png(strip)),
        write_atomically(folder / "cardan.png", png(forces)),
    ]


if __name__ == "__main__":
    make(Path(sys.argv[1]))
