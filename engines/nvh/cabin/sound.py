"""Run-up from idle to redline as sound, from the orders at the seat rail."""

from io import BytesIO
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.io import wavfile

from engines.nvh.mounts.response import Map
from mbsd3d.extend import write_atomically

SAMPLE_RATE, RUN_UP_SECONDS = 22050, 8.0  # samples a second; of the run-up
AMPLITUDE_SHARE = 0.9  # [1] of full scale: amplitude of the sound


def run_up(found: Map, seat: np.ndarray) -> np.ndarray:
    """Return the vertical acceleration over a run-up at even angular acceleration, scaled to a maximum of 1, shape
    (samples,).

    Phasors (s, n, 3) of the map are splines over the speed; the crank angle is the integral of the speed.
    """
    t = np.arange(int(RUN_UP_SECONDS * SAMPLE_RATE)) / SAMPLE_RATE
    first, last = found.rpm[[0, -1]]
    rpm = first + (last - first) * t / RUN_UP_SECONDS
    angle = 2 * np.pi / 60 * (first * t + (last - first) * t**2 / (2 * RUN_UP_SECONDS))
    felt = CubicSpline(found.rpm, seat[:, :, 2])(rpm)
    value = sum((felt[:, k] * np.exp(1j * order * angle)).real for k, order in enumerate(found.orders))
    return value / np.abs(value).max()


def write_sound(found: Map, seat: np.ndarray, path: str | Path) -> Path:
    """Write the run-up as a WAV file of 16 bits, one channel, and return its path."""
    file = BytesIO()
    wavfile.write(file, SAMPLE_RATE, np.round(AMPLITUDE_SHARE * 32767 * run_up(found, seat)).astype(np.int16))
    return write_atomically(Path(path), file.getvalue())
