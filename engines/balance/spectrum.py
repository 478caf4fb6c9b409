"""Fourier analysis of sampled motions and multipliers: amplitudes over orders of a shaft, or over frequency.

Convention: ``values = sum_k Re(c_k exp(i w_k t))`` with the times as given, so that c = A exp(i phase) belongs to
A cos(w t + phase), a cosine has a real and a sine a negative imaginary amplitude. c_0 is the mean.

Over whole periods without a window this holds to rounding for every signal without content above half the sampling
rate. A window w (sum of cosines a_j, period N) divides by its mean: a tone d bins off a bin is then seen with the gain
``W(d) / W(0)``, W(d) = sum_n w_n exp(2 pi i d n / N).
Largest loss (scalloping, d = 1/2): "none" 36.3 %, "hann" 15.1 %, "flat top" 0.11 %. Neighbours leak into a bin unless
they are more than 0, 1, 4 bins away.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.signal import get_window

from mbsd3d.errors import InputError
from mbsd3d.extend import number

WINDOWS = {"none": "boxcar", "hann": "hann", "flat top": "flattop"}  # name here -> in scipy.signal
STEP_TOLERANCE = 1e-6  # [1] of the step: allowed error of sample times
PERIOD_TOLERANCE = 1e-6  # [1] of a step: allowed error of a period


@dataclass(frozen=True)
class Spectrum:
    """Amplitudes of ``values = sum_k Re(c_k exp(i w_k t))``."""

    orders: np.ndarray  # (bins,) multiples of the shaft speed [-]; without one, frequency [Hz]
    amplitudes: np.ndarray  # (bins,) or (bins, k) complex c
    frequency: np.ndarray  # (bins,) w [rad/s]
    window: str

    def at(self, order: float) -> np.ndarray:
        """Return c at an order: of the bin itself; under a window, of the nearest one.

        ValueError if there is no such bin.
        """
        k = int(np.argmin(np.abs(self.orders - order)))
        off = abs(self.orders[k] - order) / (self.orders[1] - self.orders[0])
        if off > (1e-6 if self.window == "none" else 0.5 + 1e-6):
            raise InputError(
                f"spectrum: no bin at order {order:g}, the nearest is {self.orders[k]:g} and the last "
                f"{self.orders[-1]:g}; give more turns, more samples or a window"
            )
        return self.amplitudes[k]


def spectrum(t: ArrayLike, values: ArrayLike, *, rate: float | None = None, window: str = "none") -> Spectrum:
    """Compute the complex amplitudes of evenly sampled values; a last sample that repeats the first is left out.

    ``t`` (n,): evenly spaced times [s]; ``values`` (n,) or (n, k): real; ``rate``: of the shaft whose turn is order 1
    [rad/s], of either sign, amplitudes are those of time; without it orders are frequencies in Hz, and the last sample
    repeats the first if it equals it to 1e-9 of the largest value of each column; ``window``: "none" (whole periods
    only), "hann" or "flat top". ValueError for uneven samples, numbers that are not real or not finite, a record of a
    broken number of periods without a window.

    Examples
    --------
    >>> t = np.linspace(0, 1, 65)
    >>> spectrum(t, 3 * np.cos(4 * np.pi * t + 0.5), rate=2 * np.pi).at(2).round(6) == np.round(3 * np.exp(0.5j), 6)
    np.True_
    """
    if window not in WINDOWS:
        raise InputError(f"spectrum: window {window!r} is unknown; give one of {', '.join(map(repr, WINDOWS))}")
    t, values, step = _checked(t, values)
    n, length, turn = _extent(t.size, step, values, rate, window)
    used = values[:n].reshape(n, -1)
    weights = get_window(WINDOWS[window], n)
    c = np.fft.rfft(weights[:, None] * used, axis=0) * 2 / weights.sum()
    c[0] /= 2
    if n % 2 == 0:
        c[-1] /= 2
    frequency = 2 * np.pi * np.arange(len(c)) / length
    c *= np.exp(-1j * frequency * t[0])[:, None]
    orders = np.arange(len(c)) * (turn / length)
    return Spectrum(orders, c.reshape(len(c), *values.shape[1:]), frequency, window)


def _checked(t: ArrayLike, values: ArrayLike) -> tuple[np.ndarray, np.ndarray, float]:
    """Check that times and values are finite and evenly spaced; return them with the step [s]."""
    t, values = np.asarray(t), np.asarray(values)
    for name, array in (("t", t), ("values", values)):
        if array.dtype.kind not in "iuf":
            raise InputError(f"spectrum: {name} of type {array.dtype}; give real numbers")
    t, values = t.astype(float), values.astype(float)
    if t.ndim != 1 or t.size < 3 or values.ndim not in (1, 2) or len(values) != t.size:
        raise InputError(f"spectrum: t {t.shape} and values {values.shape}; give (n,) and (n,) or (n, k), n >= 3")
    for name, array in (("t", t), ("values", values)):
        if not np.isfinite(array).all():
            bad = int(np.flatnonzero(~np.isfinite(array).reshape(t.size, -1).all(axis=1))[0])
            raise InputError(f"spectrum: {name} is not finite at sample {bad}; leave such samples out of the run")
    step = (t[-1] - t[0]) / (t.size - 1)
    if not step > 0:
        raise InputError(f"spectrum: t goes from {t[0]:g} s to {t[-1]:g} s; give times that increase")
    off = np.abs(t - t[0] - step * np.arange(t.size))
    if off.max() > STEP_TOLERANCE * step:
        raise InputError(
            f"spectrum: sample {int(off.argmax())} is {off.max():.3g} s off even steps of {step:.6g} s; "
            "ask the run for a number of samples (output=361), not for its own steps"
        )
    return t, values, step


def _extent(n: int, step: float, values: np.ndarray, rate: float | None, window: str) -> tuple[int, float, float]:
    """Return the number of samples to use, the time they cover [s] and the period of order 1 [s].

    Of whole periods that time is exact, while the step is rounded: far from t = 0 a phase w t would show it.
    """
    if rate is None:
        repeats = (np.abs(values[-1] - values[0]) <= 1e-9 * np.abs(values).max(axis=0)).all()
        n = n - 1 if repeats else n
        return n, n * step, 1.0
    if number(rate, "spectrum: rate") == 0.0:
        raise InputError("spectrum: rate is 0, so there are no orders; give the speed of the shaft, or none")
    period = 2 * np.pi / abs(rate)
    for used in (n - 1, n):
        count = round(used * step / period)
        if count >= 1 and abs(count * period - used * step) <= PERIOD_TOLERANCE * step:
            return used, count * period, period
    if window != "none":
        return n, n * step, period
    raise InputError(
        f"spectrum: the record is {(n - 1) * step / period:.9g} periods long, {n * step / period:.9g} if its "
        "last sample does not repeat the first; give whole periods, at least one, or a window"
    )
