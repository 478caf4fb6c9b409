"""The Fourier helper: exact for whole periods, windows against their closed forms."""

import numpy as np
import pytest
from scipy.signal import get_window

from engines.balance.spectrum import spectrum

WINDOWS = {"none": "boxcar", "hann": "hann", "flat top": "flattop"}  # here -> in scipy.signal

RATE, RNG = 7.3, np.random.default_rng(5)


def taper(window, n):
    return get_window(WINDOWS[window], n)


def gain(window, offset, n):
    """Complex W(d) / W(0): how a bin of a record of n samples sees a tone d = ``offset`` bins above it."""
    weights = taper(window, n)
    return np.exp(2j * np.pi * np.multiply.outer(offset, np.arange(n)) / n) @ weights / weights.sum()


C = RNG.normal(size=(4, 2)) + 1j * RNG.normal(size=(4, 2))
ORDERS = np.array([0.0, 1.0, 2.0, 4.5])
C[0] = C[0].real


def tones(t):
    """sum Re(c exp(i order w t)), (n, 2)."""
    return np.real(np.exp(1j * RATE * np.outer(t, ORDERS)) @ C)


@pytest.mark.parametrize("repeated", [True, False])
@pytest.mark.parametrize("start", [0.0, 0.37])
@pytest.mark.parametrize("samples", [38, 39])
def test_exact_over_whole_periods(repeated, start, samples):
    """Two turns, so that half orders are whole; even and odd numbers of samples."""
    t = start + 2 * (2 * np.pi / RATE) / samples * np.arange(samples + repeated)
    found = spectrum(t, tones(t), rate=RATE)
    assert len(found.orders) == samples // 2 + 1
    exact = np.zeros((len(found.orders), 2), complex)
    exact[(2 * ORDERS).astype(int)] = C
    assert np.abs(found.amplitudes - exact).max() < 1e-14 * 5  # a sum of 40 numbers of order one
    assert np.array_equal(found.at(4.5), found.amplitudes[9])
    again = spectrum(t, tones(t)[:, 1], rate=RATE)
    assert np.array_equal(again.amplitudes, found.amplitudes[:, 1])
    assert found.frequency == pytest.approx(found.orders * RATE)


def test_frequencies_in_hertz():
    t = np.linspace(0, 3 * 2 * np.pi / RATE, 61)
    for times in (t, t[:-1]):  # with and without the repeated sample
        values = np.cos(RATE * times - 0.4)
        assert abs(spectrum(times, values).at(RATE / (2 * np.pi)) - np.exp(-0.4j)) < 1e-14


def test_sum_of_amplitudes_gives_the_values_back():
    """Any samples, the half sampling rate among them."""
    t, values = 0.3 + 0.1 * np.arange(16), RNG.normal(size=16)
    found = spectrum(t, values, rate=2 * np.pi / 1.6)
    assert np.real(np.exp(1j * np.outer(t, found.frequency)) @ found.amplitudes) == pytest.approx(values, abs=1e-13)


@pytest.mark.parametrize("window", WINDOWS)
def test_scalloping_is_the_closed_form(window):
    """A tone between two bins: c = A gain(d) + conj(A) gain of its image, to rounding."""
    n, c = 128, 1.3 * np.exp(0.7j)
    t = 0.05 * np.arange(n)
    for offset in (0.0, 0.31, 0.5):
        bins = 20 + offset
        values = np.real(c * np.exp(2j * np.pi * bins * t / (n * 0.05)))
        found = spectrum(t, values, window=window).amplitudes[20]
        assert abs(found - c * gain(window, offset, n) - np.conj(c) * gain(window, -bins - 20, n)) < 1e-14 * 10
    loss = 1 - abs(gain(window, 0.5, 10_000))
    assert loss == pytest.approx({"none": 0.3634, "hann": 0.1512, "flat top": 0.0011}[window], abs=1e-4)
    mean = {"none": 1.0, "hann": 0.5, "flat top": 0.21557895}[window]  # a_0 of its cosines
    assert taper(window, 8).mean() == pytest.approx(mean)


def test_windows_read_amplitudes_of_records_that_are_no_whole_periods():
    t = np.linspace(0, 10.3 * 2 * np.pi / RATE, 700)
    values = 2.0 * np.cos(RATE * t + 0.3) + 0.1 * np.cos(4 * RATE * t)
    errors = {w: abs(abs(spectrum(t, values, rate=RATE, window=w).at(1)) - 2.0) / 2.0 for w in ("hann", "flat top")}
    assert errors["hann"] < 0.16 and errors["flat top"] < 0.002  # scalloping of the windows, and a little leakage
    assert errors["hann"] > 10 * errors["flat top"]


def test_errors_name_sample_and_remedy():
    t = np.linspace(0, 2 * np.pi / RATE, 33)
    for arguments, options, message in (
        ((t**2, t), {}, "is .* off even steps .* ask the run for a number of samples"),
        ((t, np.where(t > 0.5, np.nan, t)), {}, "values is not finite at sample 19"),
        ((t, t[:-1]), {}, "n >= 3"),
        ((t, t), {"rate": 1.1 * RATE}, r"is 1.1 periods long, 1.13\d* if .* whole periods, at least one, or a window"),
        ((t, t), {"rate": 0.4 * RATE}, "is 0.4 periods long"),
        ((t, t), {"rate": 0.0}, "rate is 0, so there are no orders; give the speed"),
        ((t, np.exp(1j * t)), {}, "values of type complex128; give real numbers"),
        ((t[::-1], t), {}, "t goes from 0.8607.* s to 0 s; give times that increase"),
        (([0.0], [1.0]), {}, r"t \(1,\) and values \(1,\); give .* n >= 3"),
        ((t, t), {"window": "hamming"}, "window 'hamming' is unknown; give one of 'none', 'hann', 'flat top'"),
    ):
        with pytest.raises(ValueError, match=message):
            spectrum(*arguments, **options)
    with pytest.raises(ValueError, match="no bin at order 1.5"):
        spectrum(t, t, rate=RATE).at(1.5)
    with pytest.raises(ValueError, match="no bin at order 40"):
        spectrum(t, t, rate=RATE, window="hann").at(40)


def test_a_shaft_that_turns_backwards():
    """Orders count turns; amplitudes and phases are those of time, whichever way the shaft turns."""
    t = np.linspace(0.2, 0.2 + 2 * np.pi / RATE, 33)
    found = spectrum(t, tones(2 * t), rate=-2 * RATE)
    assert np.array_equal(found.amplitudes, spectrum(t, tones(2 * t), rate=2 * RATE).amplitudes)
    assert np.abs(found.at(1) - C[1]).max() < 1e-14 * 5


def test_phases_far_from_the_start():
    """A million seconds: the step is known to 1e-10 s of rounding, the period exactly."""
    t = 1e6 + np.linspace(0, 2 * np.pi / RATE, 33)
    found = spectrum(t, np.cos(RATE * t + 0.4), rate=RATE).at(1)
    assert abs(found - np.exp(0.4j)) < 1e-8  # rounding of w t, 7e6: 1e-9


def test_columns_decide_for_themselves_whether_they_repeat():
    """Newtons beside a small angle that has not come back."""
    t = np.linspace(0.0, 1.0, 41)
    values = np.column_stack([1e9 * np.cos(4 * np.pi * t), 0.1 * t])
    assert spectrum(t, values).orders[1] == pytest.approx(1 / (41 * t[1]))
    assert spectrum(t, values[:, 0]).orders[1] == pytest.approx(1.0)
