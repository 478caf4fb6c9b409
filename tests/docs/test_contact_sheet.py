"""Films of the gallery show something: bodies fill a sensible part of the frame, and the picture changes."""

from pathlib import Path
from runpy import run_path

import numpy as np
import pytest
from PIL import Image

from mbsd3d.extend import discover

SHEET = run_path(str(Path(__file__).parents[2] / "docs" / "make_contact_sheet.py"))
BODY, PAPER, GRID = (31, 119, 180), (255, 255, 255), (215, 215, 215)
SIZE = 100  # pixels of a side
SAMPLE = (  # bodies that are thin, travel, are followed, or turn by whole turns between start, middle and end
    *("block_and_tackle", "clutch_start", "crank_play", "double_lane_change", "dynamic_unbalance", "heavy_top"),
    *("poinsot", "screw_jack", "spherical_pendulum", "stewart", "tippe_top", "two_circle_roller", "wheel_on_a_string"),
)


def film(path, places, side):
    """A film of a square body of a side at places [pixels] on a grey grid."""
    frames = []
    for place in places:
        image = np.full((SIZE, SIZE, 3), PAPER, np.uint8)
        image[::10] = GRID
        image[40 : 40 + side, place : place + side] = BODY
        frames.append(Image.fromarray(image))
    frames[0].save(path, save_all=True, append_images=frames[1:], duration=100)
    return path


def test_a_body_that_moves_is_no_complaint(tmp_path):
    assert SHEET["complaints"](film(tmp_path / "good.gif", [0, 20, 45, 70], 20)) == []


def test_a_speck_is_named_with_what_it_covers(tmp_path):
    assert SHEET["complaints"](film(tmp_path / "speck.gif", [0, 20, 45, 70], 8)) == ["bodies cover 0.64 % of a frame"]


def test_what_stands_still_is_named(tmp_path):
    assert SHEET["complaints"](film(tmp_path / "still.gif", [30, 30], 20)) == ["0 % of the frame changes"]


@pytest.mark.slow
@pytest.mark.parametrize("name", SAMPLE)
def test_a_film_shows_its_effect_at_start_middle_and_end(name, tmp_path):
    path = tmp_path / f"{name}.gif"
    SHEET["gallery"].film(discover()[name].run(), path)
    assert path.exists() and SHEET["complaints"](path) == []
