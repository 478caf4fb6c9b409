"""All films of the gallery on one sheet, and a check that each shows something: ``make contact``.

Of each film the start, the middle and the end. A film fails in which the drawn mechanism covers too little of a frame,
or hardly anything changes; the exit code is then 1. The grid of the ground and the paper do not count.
"""

import sys
import time
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from PIL import Image, ImageDraw

from mbsd3d import demos
from mbsd3d.demos import gallery

SHOWN = (0.0, 0.5, 1.0)  # [1] places in a film: start, middle, end
COMPARED = (0.0, 0.21, 0.34, 1.0)  # [1] places in a film, of no whole turns of what turns evenly
TILE = (320, 240)  # [pixels]
FILMS_PER_ROW = 2
LABEL_HEIGHT = 16  # [pixels]
SATURATION_MIN = (
    30  # [1 of 255] largest less smallest channel of a pixel that belongs to a body; paper and grid are grey
)
COVERED_MIN = 0.01  # [1] of a frame that the mechanism fills; below it a film shows a speck
CHANGED_MIN = 0.002  # [1] of a frame that differs from the first
DIFFERENCE_MIN = 24  # [1 of 255] of a channel, for a pixel that differs


def frames_of(path: Path, places: Sequence[float]) -> list[np.ndarray]:
    """Return the frames of a film at places from 0 (first) to 1 (last), as (height, width, 3)."""
    with Image.open(path) as film:
        found = []
        for place in places:
            film.seek(round(place * (getattr(film, "n_frames", 1) - 1)))
            found.append(np.asarray(film.convert("RGB")).astype(int))
    return found


def complaints(path: Path) -> list[str]:
    """Return what is wrong with a film."""
    covered = [float((np.ptp(frame, axis=2) > SATURATION_MIN).mean()) for frame in frames_of(path, SHOWN)]
    first, *others = frames_of(path, COMPARED)
    changed = max(float((np.abs(frame - first).max(axis=2) > DIFFERENCE_MIN).mean()) for frame in others)
    found = []
    if min(covered) < COVERED_MIN:
        found.append(f"bodies cover {100 * min(covered):.2g} % of a frame")
    if changed < CHANGED_MIN:
        found.append(f"{100 * changed:.2g} % of the frame changes")
    return found


def sheet(films: dict[str, list[np.ndarray]], wrong: dict[str, list[str]]) -> Image.Image:
    """Return all films side by side, with their names."""
    rows = -(-len(films) // FILMS_PER_ROW)
    width, height = 3 * TILE[0], TILE[1] + LABEL_HEIGHT
    page = Image.new("RGB", (FILMS_PER_ROW * width, rows * height), "white")
    pen = ImageDraw.Draw(page)
    for k, (name, frames) in enumerate(films.items()):
        x, y = (k % FILMS_PER_ROW) * width, (k // FILMS_PER_ROW) * height
        text = ": ".join([name, *(["; ".join(wrong[name])] if wrong[name] else [])])
        pen.text((x + 4, y + 2), text, fill="#b00020" if wrong[name] else "black")
        for i, frame in enumerate(frames):
            page.paste(Image.fromarray(frame.astype(np.uint8)).resize(TILE), (x + i * TILE[0], y + LABEL_HEIGHT))
    return page


def main(target: str, *names: str) -> int:
    """Write the sheet of the named demos, or of all; return the exit code."""
    films, wrong, began = {}, {}, time.perf_counter()
    chosen = names or tuple(demos.discover())
    with TemporaryDirectory() as folder:
        for k, name in enumerate(chosen):
            path = Path(folder) / f"{name}.gif"
            gallery.film(demos.run(name), path)
            if path.exists():
                films[name], wrong[name] = frames_of(path, SHOWN), complaints(path)
            else:
                print(f"{name}: nothing moves, no film")
            print(f"film {k + 1} of {len(chosen)}, {name}, after {time.perf_counter() - began:.0f} s", file=sys.stderr)
    page = Path(target)
    page.parent.mkdir(parents=True, exist_ok=True)
    sheet(films, wrong).save(page)
    for name, found in wrong.items():
        if found:
            print(f"{name}: {'; '.join(found)}")
    print(page)
    return int(any(wrong.values()))


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
