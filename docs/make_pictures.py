"""Makes the pictures of README and gallery: ``python docs/make_pictures.py docs/pictures`` (or ``make pictures``)."""

import io
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from mbsd3d import Body, Solution, System, demos, inertia, simulate
from mbsd3d.base.paths import write_atomically
from mbsd3d.base.style import COLOURS
from mbsd3d.demos import gallery
from mbsd3d.demos.shafts import cardan
from mbsd3d.demos.tops import heavy_top
from mbsd3d.mechanism.shapes.solids import Cylinder
from mbsd3d.view.scene.drawing import NAMES

BARE = (*NAMES, "ground grid")
SHOWN = (  # of the gallery, one or two of a family
    "gimbal_walk", "falling_cat", "tippe_top", "wrist_singularity", "kaleidocycle", "stewart",
    "swash_plate", "hypoid", "roller_cam", "double_wishbone", "parking", "no_hands",
)  # fmt: skip


def t_handle() -> Solution:
    """A T-handle thrown across the view and spun about its stem, the axis of its middle moment of inertia."""
    bar, stem = (0.4, 0.012, 0.12, "x"), (0.25, 0.014, 0.075, "z")
    middle = (0.0, 0.0, 0.01 + 0.5 * stem[2])
    parts = [(bar[0], (0.0, 0.0, 0.0), inertia.cylinder(*bar)), (stem[0], middle, inertia.cylinder(*stem))]
    solid = inertia.combine(parts)
    shape = [Cylinder(*bar[1:], at=(0, 0, 0), colour=COLOURS[0]), Cylinder(*stem[1:], at=middle, colour=COLOURS[1])]
    body = Body("T-handle", **vars(solid), velocity=(0.5, 0, 0), omega=(0.1, 0.4, 14.0), shape=shape)
    return simulate(System([body], gravity=(0, 0, 0)), 2.8, output=1121)


def png(figure: Figure) -> bytes:
    """A figure as PNG."""
    raw = io.BytesIO()
    figure.savefig(raw, format="png", dpi=130, facecolor=figure.get_facecolor())
    return few_colours(Image.open(raw))


def few_colours(image: Image.Image) -> bytes:
    """An image as PNG with 256 colours: a third of the bytes, and no difference to be seen."""
    small = io.BytesIO()
    image.convert("RGB").quantize(256, dither=Image.Dither.NONE).save(small, "PNG", optimize=True)
    return small.getvalue()


def sheet(names: Sequence[str], columns: int) -> bytes:
    """The small pictures of some demos of the gallery, side by side."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "demo.png"
        tiles = []
        for name in names:
            gallery.picture(demos.run(name), path)
            tiles.append(Image.open(path).convert("RGB"))
    width, height = tiles[0].width, min(tile.height for tile in tiles)
    whole = Image.new("RGB", (columns * width, -(-len(tiles) // columns) * height), tiles[0].getpixel((0, 0)))
    for k, tile in enumerate(tiles):
        whole.paste(tile, (k % columns * width, k // columns * height))
    return few_colours(whole)


def make(folder: Path) -> list[Path]:
    """Write the pictures of the README into a folder that exists."""
    flip = np.linspace(0.6, 2.76, 10)
    handle, top = t_handle(), simulate(heavy_top.mechanism(), 4.77, output=1201)  # once round, in five cusps
    joint = cardan.one_turn(cardan.mechanism(bend_deg=40.0), 10.0)
    tip = [("T-handle", (0.0, 0.0, 0.09))]
    strip = handle.picture(flip, traces=tip, size=(9.0, 2.6), view=(-70, 14), hidden=BARE)
    arrows = ["reaction force", "reaction moment"]
    forces = joint.picture(0.05, traces=(), shown=arrows, size=(6.4, 3.6), view=(-70, 26))
    return [
        top.export_gif(
            folder / "heavy_top.gif",
            width=400,
            height=320,
            traces=heavy_top.show(l=1.0, tilt_deg=60.0)["traces"],
            hidden=NAMES,
            view=(-60, 35),
            fps=20,
        ),
        write_atomically(folder / "dzhanibekov.png", png(strip)),
        write_atomically(folder / "cardan.png", png(forces)),
    ]


def make_sheets(folder: Path) -> None:
    """Write the pictures of demos into a folder that exists."""
    write_atomically(folder / "gallery.png", sheet(SHOWN, 4))
    write_atomically(folder / "cam.png", sheet(["roller_cam"], 1))


if __name__ == "__main__":
    make(Path(sys.argv[1]))
    make_sheets(Path(sys.argv[1]))
