"""Frames of a run in equal steps of time, and how fast they are shown.

Between samples the motion is cubic where the velocities are known, and nothing is invented where samples are far apart.
With ``h`` the distance of two samples and ``s`` the share of it that has passed, every coordinate is

    p(s) = (1 + 2 s)(1 - s)^2 p0 + s (1 - s)^2 h p0_dot + s^2 (3 - 2 s) p1 + s^2 (s - 1) h p1_dot

with ``e_dot = H(e) omega / 2`` for the quaternions, which are normalised afterwards; the error is of order h^4.
"""

import math
from typing import NamedTuple

import numpy as np

from ...base.checks import short_repr
from ...base.errors import InputError
from ...base.rotations import H
from ...results.motion import Motion
from ...results.result import RunResult

TURN_PER_FRAME_MAX, FRAME_RATE = 0.2, 25.0  # [rad] a body turns from frame to frame, and [1/s] frames of a film
FRAMES_MAX, POSES_MAX = 1000, 200_000  # [frames] and [poses of all bodies] of a scene
REQUESTED_FRAMES_MAX = 100_000  # [frames] that may be asked for
# [s] of runs that are shown in real time, and length of the films of other runs
REAL_TIME_SECONDS_MIN, REAL_TIME_SECONDS_MAX, FILM_SECONDS = 2.0, 30.0, 10.0
# [rad] a body turns between two samples: beyond it the nearest sample is shown; interpolation errs by 1e-3 rad below
INTERPOLATED_TURN_MAX = 1.5


class Frames(NamedTuple):
    """Motion of all bodies and the ground (last)."""

    t: np.ndarray  # (frames,) [s]
    r: np.ndarray  # (frames, n + 1, 3) [m]
    e: np.ndarray  # (frames, n + 1, 4) unit quaternions of one sheet: neighbours have a positive product

    @property
    def first(self) -> "Frames":
        """Return the frames reduced to the first one."""
        return Frames(self.t[:1], self.r[:1], self.e[:1])


def frames_of(motion: Motion, count: int | None = None) -> Frames:
    """Return frames in equal steps of time from the first to the last sample, of a run or a mode.

    ``count`` >= 2; None = so many that no body turns by more than 0.2 rad in one and a film has 25 per second, at most
    1000, and fewer where that makes more than 200 000 poses.
    """
    t = motion.t
    if not t.size:
        raise InputError("the solution has no samples, so nothing can be shown; run it to a later time")
    whole = isinstance(count, int | np.integer) and not isinstance(count, bool)
    if count is not None and not (whole and 2 <= count <= REQUESTED_FRAMES_MAX):
        raise InputError(f"frames = {short_repr(count)}; give a whole number from 2 to {REQUESTED_FRAMES_MAX}, or None")
    times = np.linspace(t[0], t[-1], (count or enough_frames(motion)) if t[-1] > t[0] else 1)
    return frames_at(motion, times)


def frames_at(motion: Motion, t: np.ndarray) -> Frames:
    """Return frames at the given times [s] of a run."""
    r, e = poses(motion, between(motion, t))
    ground = np.broadcast_to([1.0, 0.0, 0.0, 0.0], (t.size, 1, 4))
    r = np.concatenate([r, np.zeros((t.size, 1, 3))], axis=1)
    return Frames(t, r, one_sheet(np.concatenate([e, ground], axis=1)))


def enough_frames(motion: Motion) -> int:
    """Return the number of frames for a smooth picture of a run."""
    span = float(motion.t[-1] - motion.t[0])
    if isinstance(motion, RunResult):
        fastest = float(np.linalg.norm(motion.arrays["v"][..., 3:], axis=-1).max())
    else:
        fastest = float((turns(motion) / np.diff(motion.t)).max())
    wanted = 1 + math.ceil(max(fastest * span / TURN_PER_FRAME_MAX, FRAME_RATE * span / sensible_speed(span)))
    return max(min(wanted, FRAMES_MAX, POSES_MAX // len(motion.system.bodies)), 2)


def sensible_speed(seconds: float, longest: float = REAL_TIME_SECONDS_MAX, sensible: float = FILM_SECONDS) -> float:
    """Return 1 for a run of 2 s ... ``longest``, else a round factor that makes it about ``sensible`` seconds."""
    if seconds <= 0.0 or REAL_TIME_SECONDS_MIN <= seconds <= longest:
        return 1.0
    exact = seconds / sensible
    decade = 10.0 ** np.floor(np.log10(exact))
    nearest = min((1.0, 2.0, 5.0, 10.0), key=lambda factor: abs(np.log(factor * decade / exact)))
    return float(f"{nearest * decade:.1g}")


class Between(NamedTuple):
    """Places of times among the samples; ``share`` is 0 or 1 where only the nearest sample is shown."""

    left: np.ndarray  # (times,) number of the sample before
    right: np.ndarray  # (times,) and of the one after, the same one for a single sample
    share: np.ndarray  # (times,) 0 ... 1
    step: np.ndarray  # (times,) distance of the two samples [s]

    def blend(self, values: np.ndarray) -> np.ndarray:
        """Interpolate linearly, (times, ...), between samples (samples, ...)."""
        share = self.share.reshape(-1, *[1] * (values.ndim - 1))
        return (1.0 - share) * values[self.left] + share * values[self.right]

    def compact(self) -> tuple[np.ndarray, "Between"]:
        """Return the samples that are used, in order, and the same places among these alone."""
        used, places = np.unique(np.concatenate([self.left, self.right]), return_inverse=True)
        left, right = np.split(places, 2)
        return used, self._replace(left=left, right=right)


def between(motion: Motion, t: np.ndarray) -> Between:
    """Return the places of the times [s] among the samples of a run or a mode."""
    samples = motion.t
    left = np.clip(np.searchsorted(samples, t, side="right") - 1, 0, max(samples.size - 2, 0))
    right = np.minimum(left + 1, samples.size - 1)
    step = samples[right] - samples[left]
    share = np.clip((t - samples[left]) / np.where(step > 0.0, step, 1.0), 0.0, 1.0)
    far = (turns(motion) > INTERPOLATED_TURN_MAX)[left] if samples.size > 1 else np.zeros(t.size, bool)
    return Between(left, right, np.where(far, np.round(share), share), step)


def turns(motion: Motion) -> np.ndarray:
    """Return the largest angle [rad] (samples - 1,) a body turns by from each sample to the next."""
    e = unit(motion.arrays["q"][..., 3:])
    half = 0.5 * np.linalg.norm(e[1:] - same_sheet(e[:-1], e[1:]), axis=-1)
    angle = 4.0 * np.arcsin(np.minimum(half, 1.0))
    if isinstance(motion, RunResult):  # more than half a turn is seen by the velocities only
        w = np.linalg.norm(motion.arrays["v"][..., 3:], axis=-1)
        angle = np.maximum(angle, 0.5 * (w[1:] + w[:-1]) * np.diff(motion.t)[:, None])
    return angle.max(axis=1)


def poses(motion: Motion, where: Between) -> tuple[np.ndarray, np.ndarray]:
    """Return positions (times, n, 3) [m] and unit quaternions (times, n, 4)."""
    q, s = motion.arrays["q"], where.share[:, None, None]
    (r0, e0), (r1, e1) = ((part[..., :3], unit(part[..., 3:])) for part in (q[where.left], q[where.right]))
    e1 = same_sheet(e1, e0)
    if not isinstance(motion, RunResult):
        return (1.0 - s) * r0 + s * r1, unit((1.0 - s) * e0 + s * e1)
    v0, v1 = (motion.arrays["v"][k] * where.step[:, None, None] for k in (where.left, where.right))
    a0, b0, a1, b1 = (1.0 + 2.0 * s) * (1.0 - s) ** 2, s * (1.0 - s) ** 2, s * s * (3.0 - 2.0 * s), s * s * (s - 1.0)
    r = a0 * r0 + b0 * v0[..., :3] + a1 * r1 + b1 * v1[..., :3]
    e = a0 * e0 + b0 * e_dot(e0, v0[..., 3:]) + a1 * e1 + b1 * e_dot(e1, v1[..., 3:])
    return r, unit(e)


def e_dot(e: np.ndarray, omega: np.ndarray) -> np.ndarray:
    """Return H(e) omega / 2."""
    return 0.5 * np.einsum("...ij,...j->...i", H(e), omega)


def unit(e: np.ndarray) -> np.ndarray:
    """Return quaternions of length 1; without stabilisation the norms of a run drift."""
    return e / np.linalg.norm(e, axis=-1, keepdims=True)


def same_sheet(e: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Return e or -e, whichever is nearer to the other."""
    return np.where((e * other).sum(axis=-1, keepdims=True) < 0.0, -e, e)


def one_sheet(e: np.ndarray) -> np.ndarray:
    """Return (times, n, 4) the same rotations with a positive product of neighbours in time."""
    signs = np.where((e[1:] * e[:-1]).sum(axis=-1) < 0.0, -1.0, 1.0)
    return e * np.concatenate([np.ones((1, e.shape[1])), np.cumprod(signs, axis=0)])[..., None]
