"""Films of a run: animated GIF, and MP4 through ffmpeg. A film file is complete or absent."""

import contextlib
import importlib
import io
import shutil
import subprocess
from pathlib import Path
from typing import Unpack

import numpy as np
from PIL import Image

from ...base.checks import number
from ...base.errors import InputError
from ...base.paths import atomic_write, ready_path, write_atomically
from ...base.progress import Progress
from ...base.style import channels
from ...base.version import loading
from ...results.motion import Motion
from .images import FilmFrames, FilmOptions

GIF_SECONDS = 6.0, 4.0  # [s] longest run that is shown in real time, and length of the films of other runs
GIF_FRAME_RATE_MAX = 50.0  # [1/s] frames; viewers show faster films slower
GIF_COLOURS_COUNT, PALETTE_FRAMES_COUNT = 128, 9  # [colours] of a GIF, and [frames] that its palette is made from


NO_FFMPEG = (
    "export_mp4 needs ffmpeg; install it (Debian, Ubuntu: apt install ffmpeg; macOS: brew install ffmpeg; "
    "elsewhere: pip install imageio-ffmpeg), or use export_gif"
)


def export_gif(motion: Motion, path: str | Path, *, fps: float, **options: Unpack[FilmOptions]) -> Path:
    """Write an animated GIF; see `Solution.export_gif`."""
    if number(fps, "fps", positive=True) > GIF_FRAME_RATE_MAX:
        raise InputError(f"fps = {fps:g} is more than viewers show; give at most {GIF_FRAME_RATE_MAX:g}")
    path = ready_path(path, ".gif")
    film = FilmFrames(motion, fps=fps, usual=GIF_SECONDS, **options)
    probes = np.unique(np.linspace(0, len(film) - 1, PALETTE_FRAMES_COUNT).astype(int))
    painted = {k: film.frame(k) for k in probes.tolist()}
    sample = Image.fromarray(np.concatenate(list(painted.values())))
    palette = np.array(sample.quantize(GIF_COLOURS_COUNT, method=Image.Quantize.MEDIANCUT).getpalette(), np.uint8)
    tones = with_paper(palette[: 3 * GIF_COLOURS_COUNT].reshape(-1, 3), film.sheet.paper)
    ends = np.rint(np.arange(len(film) + 1) * 100.0 / film.fps).astype(int)  # GIF counts in 1/100 s
    with Progress(f"making {path.name}", 0, len(film)) as bar:
        images = []
        for k in range(len(film)):
            frame = painted[k] if k in painted else film.frame(k)
            images.append(Image.fromarray(nearest_tones(frame, tones)))
            images[-1].putpalette(tones.ravel().tolist())
            bar.update(k + 1)
    buffer = io.BytesIO()
    durations = (10 * np.diff(ends)).tolist()
    images[0].save(buffer, "GIF", save_all=True, append_images=images[1:], duration=durations, loop=0, disposal=1)
    return write_atomically(path, buffer.getvalue())


def export_mp4(motion: Motion, path: str | Path, *, fps: float, **options: Unpack[FilmOptions]) -> Path:
    """Write an MP4; see `Solution.export_mp4`."""
    command, path = ffmpeg(), ready_path(path, ".mp4")
    film = FilmFrames(motion, fps=fps, **options)
    for side, length in (("width", film.width), ("height", film.height)):
        if length % 2:
            raise InputError(f"{side} = {length} is odd; give an even one")
    raw = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{film.width}x{film.height}", "-r", f"{film.fps:g}", "-i", "-"]
    coded = ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "18", "-movflags", "+faststart"]
    exact = ["-fflags", "+bitexact", "-flags:v", "+bitexact", "-f", "mp4"]
    with atomic_write(path) as part:
        pour([command, "-loglevel", "error", "-y", *raw, *coded, *exact, str(part)], film, path)
    return path


def pour(command: list[str], film: FilmFrames, path: Path) -> None:
    """Send all frames to a process; end it on Ctrl-C or an error, and raise what it reports."""
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        try:
            with Progress(f"making {path.name}", 0, len(film)) as bar, contextlib.suppress(BrokenPipeError):
                for k, frame in enumerate(film):
                    process.stdin.write(np.ascontiguousarray(frame).tobytes())  # type: ignore[union-attr]  # a pipe
                    bar.update(k + 1)
            _, complaint = process.communicate()
        except BaseException:
            process.kill()
            raise
    if process.returncode:
        said = complaint.decode(errors="replace").strip().splitlines()
        raise InputError(f"export_mp4: ffmpeg cannot write '{path}': {said[-1] if said else 'it says nothing'}")


def ffmpeg() -> str:
    """Return the path of ffmpeg: the program on the PATH, or the one of imageio-ffmpeg."""
    found = shutil.which("ffmpeg")
    if found is None:
        with contextlib.suppress(ImportError, RuntimeError):
            with loading():
                module = importlib.import_module("imageio_ffmpeg")
            found = module.get_ffmpeg_exe()
    if found is None:
        raise InputError(NO_FFMPEG)
    return found


def with_paper(tones: np.ndarray, paper: str) -> np.ndarray:
    """Return the tones (k, 3) with the one nearest to the paper made equal to it, so that the ground is not tinted."""
    exact = channels(paper).astype(np.uint8)
    return np.where((nearest_tones(exact[None, None], tones)[0, 0] == np.arange(len(tones)))[:, None], exact, tones)


def nearest_tones(image: np.ndarray, tones: np.ndarray) -> np.ndarray:
    """Return the places (h, w) uint8 of the tones (k, 3) nearest to the pixels (h, w, 3); exact, unlike Pillow's."""
    packed = (image.astype(np.int32) * (65536, 256, 1)).sum(axis=2)
    values, same = np.unique(packed, return_inverse=True)
    colours = np.stack([values >> 16, (values >> 8) & 255, values & 255], axis=1)
    wide = tones.astype(np.int32)
    distance = (wide**2).sum(axis=1) - 2 * colours @ wide.T
    return distance.argmin(axis=1).astype(np.uint8)[same].reshape(image.shape[:2])
