"""The page of every demo, one after the other in one window: drawn, moving, within the picture, without an error."""

import numpy as np
import pytest
from browser import visit
from pages import OUTSIDE, covered, differing, scene, seek, shown

from mbsd3d.demos.discovery import discover

pytestmark = pytest.mark.slow
DEMOS = discover()
PLACES = np.linspace(0.3, 1.0, 3)  # of the motion; of the first a picture is taken, as the end may be the start


@pytest.fixture(scope="module")
def window(chromium, folder):
    """A small window: what is drawn in software takes its time by the pixel."""
    blank = folder / "blank.html"
    blank.write_text("<!doctype html><link rel=icon href=data:,>")
    with visit(chromium, blank, width=480, height=300) as seen:
        yield seen


@pytest.mark.parametrize("name", DEMOS)
def test_every_demo_is_seen_moving(window, name, folder):
    demo = DEMOS[name]
    done = demo.run()
    for view, (run, options) in done.views.items():
        path = run.animate(**{"title": demo.title, **options}).save(folder / view)
        ground = f"/bodies/{len(run.system.bodies)}"
        with shown(window, path) as seen:
            times = seen.run("mbsd3d.data.times")
            first, moves = scene(seen), "nothing moves" in demo.alone
            assert covered(first)[0] > 0.03
            for share in PLACES:
                seek(seen, times["first"] + share * times["step"] * (times["count"] - 1))
                outside = [name for name in seen.run(OUTSIDE) if name.count("/") > 2]
                # where the camera goes along, ground and paths run out of the picture
                assert [name for name in outside if not name.startswith(("/traces", f"{ground}/"))] == []
                moves = moves or differing(first, scene(seen)) > 0.001 * first[..., 0].size
            assert moves
