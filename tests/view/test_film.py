"""Films: as many frames as they should have, each another picture, the same bytes twice, whole files or none."""

import os
import runpy
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from helpers.double_pendulum import LOWER_ARM, UPPER_ARM, WHEEL, pendulum
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from PIL import Image

from mbsd3d import GROUND, Body, Fixed, Revolute, System, accelerations, linearize, shapes, simulate
from mbsd3d.extend import theme
from mbsd3d.view.film import film
from mbsd3d.view.film.images import FilmFrames
from mbsd3d.view.scene.drawing import Layers

MAKE_PICTURES = Path(__file__).parents[2] / "docs" / "make_pictures.py"
SMALL = {"width": 160, "hidden": ["body names", "joint names"]}
REEL = {"width": SMALL["width"], "layers": Layers(hidden=SMALL["hidden"])}


@pytest.fixture(scope="module")
def solution():
    """0.2 s of the pendulum."""
    return simulate(pendulum(), 0.2, output=21)


def frames_of_gif(path) -> tuple[list[np.ndarray], list[int]]:
    """Images and durations [ms]."""
    with Image.open(path) as image:
        images, durations = [], []
        for k in range(image.n_frames):
            image.seek(k)
            images.append(np.array(image.convert("RGB")))
            durations.append(image.info["duration"])
        assert image.info["loop"] == 0
    return images, durations


@pytest.mark.slow
def test_every_frame_of_the_gif_is_another_picture(solution, tmp_path):
    path = solution.export_gif(tmp_path / "motion", speed=0.25, fps=30, **SMALL)
    images, durations = frames_of_gif(path)
    assert path.name == "motion.gif" and len(images) == 25  # 0.2 / 0.25 * 30 + 1
    assert images[0].shape == (120, 160, 3)
    assert all(np.any(a != b) for a, b in zip(images, images[1:], strict=False))
    # GIF counts in 1/100 s: 30 frames per second are 3 and 4 of them in turn, and none is lost
    assert set(durations) == {30, 40} and sum(durations) == round(25 / 30 * 100) * 10
    assert np.all(images[0][60, 0] == 255)  # the paper keeps its colour


def inked(image) -> float:
    """The share of an image that is darker than the lines of the ground."""
    return float((np.asarray(image).min(axis=2) < 150).mean())


@pytest.fixture(scope="module")
def far():
    """A spinning sled that drives away, 60 m aside and up a slope of 1 in 12, past a post."""
    post = Body("post", 1.0, (1, 1, 1), position=(0.9, 0.4, 0.2), shape=shapes.Box((0.2, 0.2, 0.9)))
    sled = Body(
        "sled", 2.0, (0.1, 0.2, 0.3), com=(0.1, 0, 0.05), velocity=(24.0, -18.0, 2.5), omega=(0, 0, 3.0),
        shape=shapes.Box((1.2, 0.5, 0.3), at=(0.1, 0, 0)),
    )  # fmt: skip
    return simulate(System([post, sled], [Fixed(GROUND, post, at=(0.9, 0.4, 0.2))], gravity=(0, 0, 0)), 2.0, output=41)


def test_a_film_goes_along_with_what_drives_away(far):
    """Its body stays at one place of the paper and is as large at the end as at first; the ground passes below."""
    options = {"fps": 5, "width": 240, "layers": Layers(hidden=["body names", "joint names"])}
    reel = FilmFrames(far, follow="sled", **options)
    for k in (0, 4, len(reel) - 1):
        O = reel.painter.gone(reel.way[k]).on_paper(far.position("sled")[4 * k])  # a frame is 0.2 s, a sample 0.05 s
        # interpolation of the film beside samples of the run: both are the sample here
        np.testing.assert_allclose(O, reel.painter.on_paper(far.position("sled")[0]), rtol=0, atol=1e-6)
    shares = [inked(reel.frame(k)) for k in (0, len(reel) // 2, len(reel) - 1)]
    assert min(shares) > 0.08  # of the whole box of the sled and the post, which is soon passed
    assert inked(FilmFrames(far, follow=GROUND, **options).frame(len(reel) - 1)) < 0.03  # letters mostly
    assert len({float(reel.painter.gone(way).floor) for way in reel.way}) == 1
    with pytest.raises(ValueError, match="'nobody' is not one of the bodies"):
        FilmFrames(far, follow="nobody", **options)


def test_a_picture_holds_what_it_follows(far):
    """The paper is that of the mechanism at its time; of several times it holds all unless a body is given."""

    def share(t, **options):
        figure = far.picture(t, size=(2.4, 1.8), hidden=["body names", "joint names"], **options)
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
        return inked(np.asarray(canvas.buffer_rgba())[..., :3])

    assert share(2.0) > 0.08 and share([1.0, 2.0], follow="sled") > 0.08  # 60 m are 50 sizes
    assert share(2.0, follow=GROUND) < 0.03 and share([1.0, 2.0]) < 0.03  # letters mostly
    with pytest.raises(ValueError, match="'nobody' is not one of the bodies"):
        far.picture(follow="nobody")


@pytest.mark.slow
def test_gifs_are_the_same_bytes_twice(solution, tmp_path):
    options = {"speed": 0.5, "fps": 20, "shown": ["reaction force"], "dark": True, "height": 100, **SMALL}
    first, second = (solution.export_gif(tmp_path / name, **options) for name in ("a.gif", "b.GIF"))
    assert first.read_bytes() == second.read_bytes() and second.name == "b.GIF"
    images, _ = frames_of_gif(first)
    assert len(images) == 9 and images[0].shape == (100, 160, 3)
    assert np.array_equal(images[0][60, 0], np.round(255 * np.array(to_rgb(theme(True).paper))))


def test_the_clock_tells_time_and_speed(solution):
    assert FilmFrames(solution, speed=0.02, **REEL).clock(4) == "t = 0.0032 s   (0.02× speed)"
    assert FilmFrames(solution, speed=1.0, **REEL).clock(5) == "t = 0.20 s"
    assert FilmFrames(solution, usual=(6.0, 4.0), **REEL).speed == 0.05  # 0.2 s in 4 s
    assert FilmFrames(solution, **REEL).speed == 0.02


def test_a_frame_shows_the_pose_of_its_time(solution):
    reel = FilmFrames(solution, speed=0.25, **REEL)
    for name, i in ((UPPER_ARM, 0), (WHEEL, 2)):
        # 5 steps of 0.01 s: the frame's time is that of a sample
        assert np.allclose(reel.frames.r[5, i], solution.position(name)[5], rtol=0, atol=1e-12)
    assert np.allclose(reel.traces[0].points[:: reel.finer][5], solution.com(reel.traces[0].name)[5], rtol=0, atol=1e-9)


def test_a_path_ends_where_its_body_is(solution, monkeypatch):
    """Paths have more points than the film has frames."""
    reel, painted = FilmFrames(solution, speed=0.25, **REEL), []
    monkeypatch.setattr(reel.painter, "paint", lambda axes, poses, *, traces, arrows: painted.append(traces))
    reel.frame(5)
    assert reel.finer > 1 and painted[0]
    for trace in painted[0]:
        np.testing.assert_allclose(trace.points[-1], solution.com(trace.name)[5], rtol=0, atol=1e-9)


def test_the_cursor_runs_over_the_curves(solution):
    reel = FilmFrames(solution, speed=0.25, curves=["energy", ("position", LOWER_ARM)], width=320)
    strip, last = reel.strip, len(reel) - 1
    assert reel.height == 240 + strip.height and reel.frame(3).shape == (reel.height, 320, 3)
    even = strip.columns[0] + (strip.columns[-1] - strip.columns[0]) * np.arange(last + 1) / last
    assert np.abs(strip.columns - even).max() <= 1.0  # all three are rounded to pixels
    for k in (0, 7, last):
        changed = np.unique(np.nonzero((strip.at(k) != strip.image).any(axis=2))[1])
        assert changed.min() >= strip.columns[k] - 3 and changed.max() <= strip.columns[k] + 3
        line = (strip.at(k)[:, strip.columns[k]] == np.round(255 * np.array(to_rgb(theme(False).muted)))).all(axis=1)
        rows = [slice(round(strip.height - high), round(strip.height - low)) for _, low, _, high in strip.boxes]
        beside = np.ones(strip.height, bool)
        for part in rows:  # of the image, from its top down
            beside[part] = False
            assert line[part].any()
        assert not line[beside].any()
        x, y, z = (round(heights[k]) for _, heights in strip.dots[-3:])
        for tint, row in zip(theme(False).lines, (x, y, z), strict=False):
            near = strip.at(k)[row - 1 : row + 2, strip.columns[k]]
            assert np.any(np.all(near == np.round(255 * np.array(to_rgb(tint))), axis=1)) or len({x, y, z}) < 3


def test_the_nearest_tones_are_the_nearest():
    rng = np.random.default_rng(1)
    image, tones = rng.integers(0, 256, (9, 7, 3), np.uint8), rng.integers(0, 256, (30, 3), np.uint8)
    found = film.nearest_tones(image, tones)
    distance = ((image[:, :, None].astype(int) - tones.astype(int)) ** 2).sum(axis=3)
    assert np.array_equal(np.take_along_axis(distance, found[..., None].astype(int), 2)[..., 0], distance.min(axis=2))
    paper = film.with_paper(tones, "#fefdfc")
    assert (paper != tones).any(axis=1).sum() == 1 and (paper == (254, 253, 252)).all(axis=1).sum() == 1


@pytest.mark.slow
def test_a_mode_moves_too(tmp_path):
    rod = Body("rod", 2.0, (0.3, 0.2, 0.1), position=(0.1, 0.2, -0.7))
    hinge = Revolute(GROUND, rod, at=(0.1, 0.2, 0.3), axis=(1.0, 0.2, 0.0))
    motion = linearize(System([rod], [hinge])).modes[0].motion(amplitude=0.5, cycles=1.0, samples=21)
    images, _ = frames_of_gif(motion.export_gif(tmp_path / "mode", fps=5, **SMALL))
    assert len(images) == 1 + round(5 * motion.t[-1])  # 2 to 6 s: real time
    assert all(np.any(a != b) for a, b in zip(images, images[1:], strict=False))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fps": 0}, "fps: 0.0 is not positive"),
        ({"fps": 60}, "fps = 60 is more than viewers show; give at most 50"),
        ({"fps": "fast"}, "fps: expected a number, got 'fast'"),
        ({"speed": -1}, "speed: -1.0 is not positive"),
        ({"speed": 1e-6}, "make 5000001 frames, not 2 ... 5000; give another speed"),
        ({"speed": 1e3}, "make 1 frames"),
        ({"width": 32}, "width = 32; give a whole number from 64"),
        ({"width": 480.5}, "width = 480.5; give a whole"),
        ({"height": 1e9}, "height = .*; give a whole"),
        ({"shown": "forces"}, "shown: layer 'forces' is unknown"),
        ({"curves": ["energy"], "width": 200}, "width = 200 is too small for curves; give at least 320"),
        ({"curves": ["speed"]}, "'speed' is unknown"),
        ({"colour": 1}, "colour"),
    ],
)
def test_films_refuse(solution, tmp_path, options, message):
    with pytest.raises((ValueError, TypeError), match=message):
        solution.export_gif(tmp_path / "x", **options)
    assert not list(tmp_path.iterdir())


def test_one_moment_is_no_film(tmp_path):
    with pytest.raises(ValueError, match="one moment only; run it longer, or use solution.picture"):
        accelerations(pendulum()).export_gif(tmp_path / "x")


def test_a_missing_folder_is_named(solution, tmp_path):
    with pytest.raises(ValueError, match="nowhere"):
        solution.export_gif(tmp_path / "nowhere" / "x", speed=1, **SMALL)


def test_without_ffmpeg_one_line_says_where_to_get_it(solution, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", "")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(ValueError, match="needs ffmpeg; install it .Debian, Ubuntu: apt install ffmpeg; macOS: brew"):
        solution.export_mp4(tmp_path / "x")


def test_a_failing_ffmpeg_is_quoted_and_leaves_nothing(solution, tmp_path, monkeypatch):
    folder = tmp_path / "bin"
    folder.mkdir()
    program = folder / "ffmpeg"
    program.write_text("#!/bin/sh\ncat >/dev/null\necho 'no such codec' >&2\nexit 3\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{folder}{os.pathsep}{os.environ['PATH']}")
    with pytest.raises(ValueError, match=r"ffmpeg cannot write '.*x.mp4': no such codec"):
        solution.export_mp4(tmp_path / "x", speed=1, **SMALL)
    assert [path.name for path in tmp_path.iterdir()] == ["bin"]


needs_ffmpeg = pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="no ffmpeg on the PATH")


@needs_ffmpeg
def test_mp4_has_its_frames(solution, tmp_path):
    path = solution.export_mp4(tmp_path / "motion", speed=0.25, fps=10, **SMALL)
    again = solution.export_mp4(tmp_path / "again", speed=0.25, fps=10, **SMALL)
    assert path.name == "motion.mp4" and path.read_bytes() == again.read_bytes()
    entries = "stream=codec_name,pix_fmt,width,height,nb_read_frames,r_frame_rate"
    probe = ["ffprobe", "-v", "error", "-count_frames", "-show_entries", entries, "-of", "csv=p=0", str(path)]
    said = subprocess.run(probe, capture_output=True, text=True, check=True).stdout.strip()
    assert said == "h264,160,120,yuv420p,10/1,9"


@needs_ffmpeg
def test_an_interrupted_mp4_leaves_nothing(solution, tmp_path, monkeypatch):
    shown, frame = [], FilmFrames.frame

    def interrupted(self: FilmFrames, k: int) -> np.ndarray:
        shown.append(k)
        if k == 3:
            raise KeyboardInterrupt
        return frame(self, k)

    monkeypatch.setattr(FilmFrames, "frame", interrupted)
    with pytest.raises(KeyboardInterrupt):
        solution.export_mp4(tmp_path / "x", speed=0.25, **SMALL)
    assert shown == [0, 1, 2, 3] and not list(tmp_path.iterdir())


@needs_ffmpeg
def test_mp4_refuses_odd_sizes(solution, tmp_path):
    with pytest.raises(ValueError, match="width = 161 is odd"):
        solution.export_mp4(tmp_path / "x", width=161)
    with pytest.raises(ValueError, match="no folder"):
        solution.export_mp4(tmp_path / "nowhere" / "x", **SMALL)


@pytest.mark.slow
def test_pictures_of_the_readme_are_small(tmp_path):
    made = runpy.run_path(str(MAKE_PICTURES))["make"](tmp_path)
    sizes = {path.name: path.stat().st_size for path in made}
    assert sizes.pop("heavy_top.gif") < 400_000
    assert set(sizes) == {"dzhanibekov.png", "cardan.png"} and max(sizes.values()) < 150_000
