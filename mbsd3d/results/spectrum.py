"""Fourier analysis of sampled motions, loads and efforts: amplitudes over orders of a shaft or over frequency.

Convention: ``values = sum_k Re(c_k exp(i w_k t))`` with the times as given, so that c = A exp(i phase) belongs to
A cos(w t + phase), a cosine has a real and a sine a negative imaginary amplitude. c_0 is the mean.

Over whole periods without a window this holds to rounding for every signal without content above half the sampling
rate. A window w (sum of cosines a_j, period N) divides by its mean: a tone d bins off a bin is then seen with the gain
``W(d) / W(0)``, W(d) = sum_n w_n exp(2 pi i d n / N).
Largest loss (scalloping, d = 1/2): "none" 36.3 %, "hann" 15.1 %, "flat top" 0.11 %. Neighbours leak into a bin unless
they are more than 0, 1, 4 bins away.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..base.checks import check_choice, check_size, number, short_repr, whole
from ..base.errors import InputError
from ..base.style import Told
from ..base.wording import counted
from ..mechanism.measures import Measure
from .columns import BODY_QUANTITIES, QUANTITIES, columns_of_effort, components
from .element_loads import load_of
from .result import RunResult

WINDOWS = {"none": "boxcar", "hann": "hann", "flat top": "flattop"}  # name here -> in scipy.signal
STEP_TOLERANCE = 1e-6  # [1] of the step: allowed error of sample times
PERIOD_TOLERANCE = 1e-6  # [1] of a step: allowed error of a period
LEVEL_REFERENCES = {"m/s^2": 1e-6, "m/s": 1e-9, "N": 1e-6}  # [unit] of r.m.s. levels, ISO 1683
ANGLE_TOLERANCE = 1e-9  # [rad] of the angles at which a run is sampled over orders
RUNS_MAX = 5  # [runs] until the samples are at their angles: each squares the error
SAMPLES_MAX = 10_000_000  # [samples] of a run over orders


class Levels(NamedTuple):
    """Levels of r.m.s. values and their reference."""

    values: np.ndarray  # [dB], minus infinity for none
    unit: str  # e.g. "dB re 1e-06 N"


@dataclass(frozen=True, repr=False)
class Spectrum(Told):
    """Amplitudes of ``values = sum_k Re(c_k exp(i w_k t))``, or over orders; see `mbsd3d.Spectrum`."""

    orders: np.ndarray  # (bins,)
    amplitudes: np.ndarray  # (bins,) or (bins, k) complex
    frequency: np.ndarray  # (bins,) [rad/s]
    window: str
    name: str = ""
    unit: str = ""
    names: tuple[str, ...] = ()

    def at(self, order: float) -> np.ndarray:
        """Return c at an order or frequency [Hz]: of the bin itself; under a window, of the nearest one.

        ValueError if there is no such bin.
        """
        order = number(order, "spectrum: order")
        k = int(np.argmin(np.abs(self.orders - order)))
        off = abs(self.orders[k] - order) / (self.orders[1] - self.orders[0])
        if off > (1e-6 if self.window == "none" else 0.5 + 1e-6):
            raise InputError(
                f"spectrum: no bin at order {order:g}, the nearest is {self.orders[k]:g} and the last "
                f"{self.orders[-1]:g}; give more turns, more samples or a window"
            )
        return self.amplitudes[k]

    def levels(self, reference: float | None = None) -> Levels:
        """Return the levels [dB] of the r.m.s. values, |c| / sqrt(2), of the mean |c|.

        ``reference`` in ``unit``; None = the reference of ISO 1683 for accelerations, velocities and forces. ValueError
        for other units without one.
        """
        if reference is None and self.unit not in LEVEL_REFERENCES:
            raise InputError(f"levels: no usual reference for a quantity in {self.unit or 'no unit'}; give reference=")
        given = (
            LEVEL_REFERENCES[self.unit] if reference is None else number(reference, "levels: reference", positive=True)
        )
        size = np.abs(self.amplitudes) / np.sqrt(2.0)
        size[0] *= np.sqrt(2.0)
        with np.errstate(divide="ignore"):
            return Levels(20.0 * np.log10(size / given), f"dB re {given:g} {self.unit}".rstrip())

    def __repr__(self) -> str:
        """Return the quantity and where its largest amplitudes are."""
        size = np.abs(self.amplitudes).reshape(self.orders.size, -1).max(axis=1)
        first = [k for k in np.argsort(-size).tolist() if size[k] > 1e-9 * size.max()][:4]
        text = ", ".join(f"{size[k]:.6g} at {self.orders[k]:g}" for k in sorted(first))
        what = f" of {self.name} [{self.unit}]" if self.name else ""
        return f"<spectrum{what}: {self.orders.size} bins to {self.orders[-1]:g}, window {self.window!r}; {text}>"


@dataclass(frozen=True, repr=False)
class Density(Told):
    """One-sided power spectral density; see `mbsd3d.Density`."""

    hertz: np.ndarray
    density: np.ndarray
    name: str
    unit: str
    names: tuple[str, ...] = ()

    def __repr__(self) -> str:
        """Return a line that names the quantity."""
        return f"<density of {self.name} [{self.unit}]: {self.hertz.size} bins to {self.hertz[-1]:g} Hz>"


@dataclass(frozen=True, repr=False)
class Waterfall(Told):
    """Amplitudes over orders and the speed of a shaft; see `mbsd3d.Waterfall`."""

    t: np.ndarray  # (n,) [s]
    speeds: np.ndarray  # (n,) [rad/s]
    orders: np.ndarray  # (bins,)
    amplitudes: np.ndarray  # (n, bins) or (n, bins, k) complex
    name: str
    unit: str
    names: tuple[str, ...] = ()

    @property
    def frequencies(self) -> np.ndarray:
        """Return the frequency (n, bins) [rad/s] of each order at each speed."""
        return self.speeds[:, None] * self.orders

    def at(self, order: float) -> np.ndarray:
        """Return c (n,) or (n, k) of an order over the speed; ValueError if there is no such bin."""
        order = number(order, "waterfall: order")
        k = int(np.argmin(np.abs(self.orders - order)))
        if abs(self.orders[k] - order) > 1e-6 * self.orders[1]:
            raise InputError(
                f"waterfall: no bin at order {order:g}, the nearest is {self.orders[k]:g} and the last "
                f"{self.orders[-1]:g}; give more turns a window, or a larger per_turn"
            )
        return self.amplitudes[:, k]

    def __repr__(self) -> str:
        """Return the quantity, and the ranges of speeds and orders."""
        first, last = self.speeds[[0, -1]]
        return (
            f"<waterfall of {self.name} [{self.unit}]: {self.t.size} windows from {first:g} to {last:g} rad/s, "
            f"orders to {self.orders[-1]:g}>"
        )


def amplitudes(t: ArrayLike, values: ArrayLike, rate: float | None, window: str, *, one_unit: bool) -> Spectrum:
    """Return the spectrum of samples; ``one_unit``: columns are components, of which a small one says nothing alone."""
    check_choice(window, tuple(WINDOWS), "spectrum: window")
    t, values, step = _checked(t, values, "spectrum")
    size = np.abs(values).max(axis=None if one_unit else 0)
    repeats = bool((np.abs(values[-1] - values[0]) <= 1e-9 * size).all())
    n, length, turn = _extent(t.size, step, repeats, rate, window)
    used = values[:n].reshape(n, -1)
    from scipy.signal import get_window  # a quarter of a second: only who asks for a spectrum waits for it

    weights = get_window(WINDOWS[window], n)
    c = np.fft.rfft(weights[:, None] * used, axis=0) * 2 / weights.sum()
    c[0] /= 2
    if n % 2 == 0:
        c[-1] /= 2
    frequency = 2 * np.pi * np.arange(len(c)) / length
    c *= np.exp(-1j * frequency * t[0])[:, None]
    orders = np.arange(len(c)) * (turn / length)
    return Spectrum(orders, c.reshape(len(c), *values.shape[1:]), frequency, window)


def real_numbers(values: ArrayLike, what: str) -> np.ndarray:
    """Return an array of floats, or raise an error for what is not an array of real numbers."""
    try:
        array = np.asarray(values)
    except ValueError:
        raise InputError(f"{what}: {short_repr(values)} has rows of different lengths; give an array") from None
    if array.dtype.kind not in "iuf":
        raise InputError(f"{what} of type {array.dtype}; give real numbers")
    return array.astype(float)


def _checked(t: ArrayLike, values: ArrayLike, what: str) -> tuple[np.ndarray, np.ndarray, float]:
    """Check that times and values are finite and evenly spaced; return them with the step [s]."""
    t, values = real_numbers(t, f"{what}: t"), real_numbers(values, f"{what}: values")
    if t.ndim != 1 or t.size < 3 or values.ndim not in (1, 2) or len(values) != t.size or not values.size:
        raise InputError(f"{what}: t {t.shape} and values {values.shape}; give (n,) and (n,) or (n, k), n >= 3, k >= 1")
    for name, array in (("t", t), ("values", values)):
        if not np.isfinite(array).all():
            bad = int(np.flatnonzero(~np.isfinite(array).reshape(t.size, -1).all(axis=1))[0])
            raise InputError(f"{what}: {name} is not finite at sample {bad}; leave such samples out of the run")
        check_size(array, f"{what}: {name}")
    step = (t[-1] - t[0]) / (t.size - 1)
    if not step > 0:
        raise InputError(f"{what}: t goes from {t[0]:g} s to {t[-1]:g} s; give times that increase")
    off = np.abs(t - t[0] - step * np.arange(t.size))
    if off.max() > STEP_TOLERANCE * step:
        raise InputError(
            f"{what}: sample {int(off.argmax())} is {off.max():.3g} s off even steps of {step:.6g} s; "
            "ask the run for a number of samples (output=361), not for its own steps"
        )
    return t, values, step


def _extent(n: int, step: float, repeats: bool, rate: float | None, window: str) -> tuple[int, float, float]:
    """Return the number of samples to use, the time they cover [s] and the period of order 1 [s].

    Of whole periods that time is exact, while the step is rounded: far from t = 0 a phase w t would show it.
    """
    if rate is None:
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


class Samples(NamedTuple):
    """Sampled quantity of one part."""

    values: np.ndarray  # (samples,) or (samples, k)
    name: str
    unit: str
    names: tuple[str, ...]


def samples_of(solution: RunResult, quantity: str | Measure, part: Any, what: str) -> Samples:
    """Return a measure, or a quantity of one part by its name in tables."""
    if isinstance(quantity, Measure):
        if part is not None:
            raise InputError(f"{what}: a measure already names its part; leave {short_repr(part)} out")
        return Samples(solution.measure(quantity), quantity.label, quantity.unit, ())
    readers: dict[str, Callable[[], np.ndarray]] = {
        "angle": lambda: solution.angle(part), "slide": lambda: solution.slide(part),
        "rate": lambda: solution.rate(part), "effort": lambda: solution.effort(part),
        "reaction_force": lambda: determined(solution, part, "force", what),
        "reaction_moment": lambda: determined(solution, part, "moment", what),
        "force": lambda: load_of(solution, part).force, "force_moment": lambda: load_of(solution, part).moment,
    }  # fmt: skip
    readers |= {name: partial(getattr(solution, name), part) for name in BODY_QUANTITIES}
    readers["reaction"] = readers["reaction_force"]
    check_choice(quantity, tuple(readers), f"{what}: quantity")
    if part is None:
        raise InputError(f"{what}: {quantity} of what? give a part, e.g. ('{quantity}', part)")
    name = part if isinstance(part, str) else solution.system.name(part)
    values = readers[quantity]()
    unit = QUANTITIES["reaction_force" if quantity == "reaction" else quantity].unit
    if quantity == "effort":
        unit = columns_of_effort(solution, solution.system.part(part, "joints"))[0].unit
    elif quantity == "rate" and solution.system.part(part, "joints").angle() is None:
        unit = QUANTITIES["slide_rate"].unit
    names = components(values)[1] if values.ndim == 2 and values.shape[1] in (3, 4) else ()
    return Samples(values, f"{quantity.replace('_', ' ')} of {name}", unit, names)


def determined(solution: RunResult, joint: Any, kind: str, what: str) -> np.ndarray:
    """Return the force or moment of a joint; ValueError where the constraints do not determine it."""
    reaction = solution.reaction(joint)
    if not getattr(reaction, f"unique_{kind}").all():
        raise InputError(
            f"{what}: the {kind} of '{solution.system.name(solution.system.part(joint, 'joints'))}' is not determined, "
            "since joints are redundant; take a sum of joints, or remove the redundancy, see system.check()"
        )
    return getattr(reaction, kind)


def later_samples(solution: RunResult, found: Samples, after: float | None, what: str) -> tuple[np.ndarray, Samples]:
    """Return times and samples from a time on [s]; None = all."""
    first = 0 if after is None else int(np.searchsorted(solution.t, number(after, f"{what}: after") - 1e-12))
    if solution.t.size - first < 3:
        raise InputError(
            f"{what}: {counted(solution.t.size - first, 'sample')} left; give a longer run, or an earlier after="
        )
    return solution.t[first:], found._replace(values=found.values[first:])


def spectrum_of(solution: RunResult, quantity: str | Measure, part: Any, window: str, after: float | None) -> Spectrum:
    """See `Solution.spectrum`."""
    t, found = later_samples(solution, samples_of(solution, quantity, part, "spectrum"), after, "spectrum")
    seen = amplitudes(t, found.values, None, window, one_unit=True)
    return replace(seen, name=found.name, unit=found.unit, names=found.names)


def density_of(solution: RunResult, quantity: str | Measure, part: Any, segments: int, after: float | None) -> Density:
    """See `Solution.density`."""
    t, found = later_samples(solution, samples_of(solution, quantity, part, "density"), after, "density")
    t, values, step = _checked(t, found.values, "density")
    length = t.size // whole(segments, "density: segments", 1, t.size // 3)
    from scipy.signal import welch  # only who asks for a density waits for it

    hertz, density = welch(values, 1.0 / step, nperseg=length, axis=0)
    return Density(hertz, density, found.name, f"({found.unit})^2/Hz", found.names)


class Turns(NamedTuple):
    """Angles at which a run over whole turns of a hinge is sampled."""

    targets: np.ndarray  # (samples + 1,) [rad] counted in the sense of the turning, with the end of the last turn
    times: np.ndarray  # (samples + 1,) [s] that are near them
    whole: int  # turns


def whole_turns(solution: RunResult, hinge: Any, per_turn: int, after: float | None) -> Turns:
    """Return the angles of whole turns, and times near them by interpolating between the samples of a run."""
    per_turn = whole(per_turn, "orders: per_turn", 4, SAMPLES_MAX)
    _, angle, rate = turning(solution, hinge)
    first = 0 if after is None else int(np.searchsorted(solution.t, number(after, "orders: after") - 1e-12))
    angle, rate, t = angle[first:], rate[first:], solution.t[first:]
    name = solution.system.name(solution.system.part(hinge, "joints"))
    if t.size < 2 or not (np.diff(angle).min() > 0.0 and rate.min() > 0.0):
        raise InputError(
            f"orders: '{name}' does not turn in one sense all the time; give after=, or spectrum over time"
        )
    count = int((angle[-1] - angle[0]) / (2.0 * np.pi) + ANGLE_TOLERANCE)
    if count < 1:
        turned = (angle[-1] - angle[0]) / (2.0 * np.pi)
        raise InputError(f"orders: '{name}' turns {turned:.4g} times; orders need at least one whole turn")
    if count * per_turn > SAMPLES_MAX:
        raise InputError(
            f"orders: {count} turns of {per_turn} samples are too many; give a smaller per_turn, or after="
        )
    targets = angle[0] + 2.0 * np.pi / per_turn * np.arange(count * per_turn + 1)
    from scipy.interpolate import CubicHermiteSpline  # a tenth of a second, for orders alone

    return Turns(targets, np.clip(CubicHermiteSpline(angle, t, 1.0 / rate)(targets), t[0], t[-1]), count)


def turning(solution: RunResult, hinge: Any) -> tuple[float, np.ndarray, np.ndarray]:
    """Return (sense of the turning, angle [rad] and rate [rad/s] counted in that sense) of a hinge."""
    angle, rate = solution.angle(hinge), solution.rate(hinge)
    sign = 1.0 if angle.size and angle[-1] >= angle[0] else -1.0
    return sign, sign * angle, sign * rate


def over_angle(
    solution: RunResult, again: Callable[[np.ndarray], RunResult], hinge: Any, per_turn: int, after: float | None
) -> tuple[RunResult, Turns]:
    """Return a run with samples at equal angles of a hinge, and these; ``again``: the run with samples at times."""
    turns = whole_turns(solution, hinge, per_turn, after)
    times = turns.times
    for _ in range(RUNS_MAX):
        run = again(times)
        _, angle, rate = turning(run, hinge)
        off = turns.targets - angle
        if np.abs(off[:-1]).max() <= ANGLE_TOLERANCE:  # the end, which may be that of the run, only says the mean speed
            return run, turns._replace(times=times)
        times = np.clip(times + off / rate, solution.t[0], solution.t[-1])
    raise InputError(f"orders: the samples are {np.abs(off).max():.2g} rad off their angles; give a tighter rtol")


def orders_of(
    solution: RunResult, again: Callable[[np.ndarray], RunResult], hinge: Any, wanted: tuple[str | Measure, Any],
    per_turn: int, after: float | None,
) -> Spectrum:  # fmt: skip
    """See `Solution.orders`; ``again``: the same run with samples at other times."""
    run, (targets, times, _) = over_angle(solution, again, hinge, per_turn, after)
    found = samples_of(run, *wanted, "orders")
    seen = amplitudes(targets[:-1], found.values[:-1], 1.0, "none", one_unit=False)
    mean = (targets[-1] - targets[0]) / (times[-1] - times[0])
    return replace(seen, frequency=seen.orders * mean, name=found.name, unit=found.unit, names=found.names)


def waterfall_of(
    solution: RunResult, again: Callable[[np.ndarray], RunResult], hinge: Any, wanted: tuple[str | Measure, Any],
    turns: int, per_turn: int, after: float | None,
) -> Waterfall:  # fmt: skip
    """See `Solution.waterfall`; ``again``: the same run with samples at other times."""
    turns = whole(turns, "waterfall: turns", 1, SAMPLES_MAX)
    run, (targets, times, count) = over_angle(solution, again, hinge, per_turn, after)
    if count < turns:
        raise InputError(
            f"waterfall: the run has {count} whole turns and a window {turns}; give a longer run, or fewer turns"
        )
    found = samples_of(run, *wanted, "waterfall")
    length = turns * per_turn
    starts = np.arange(0, targets.size - length, max(1, length // 2))
    rate, low, high = turning(run, hinge)[2], starts + length // 2, starts + (length + 1) // 2  # middle by angle
    seen = [
        amplitudes(targets[k : k + length], found.values[k : k + length], 1.0, "hann", one_unit=True) for k in starts
    ]
    return Waterfall(
        t=0.5 * (times[low] + times[high]), speeds=0.5 * (rate[low] + rate[high]), orders=seen[0].orders,
        amplitudes=np.array([x.amplitudes for x in seen]), name=found.name, unit=found.unit, names=found.names,
    )  # fmt: skip
