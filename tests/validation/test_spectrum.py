"""The Fourier helper: exact for whole periods."""

import numpy as np
import pytest

from validation.engine_balance.spectrum import spectrum

RATE, RNG = 7.3, np.random.default_rng(5)
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


def test_sum_of_amplitudes_gives_the_values_back():
    """Any samples, the half sampling rate among them."""
    t, values = 0.3 + 0.1 * np.arange(16), RNG.normal(size=16)
    found = spectrum(t, values, rate=2 * np.pi / 1.6)
    assert np.real(np.exp(1j * np.outer(t, found.frequency)) @ found.amplitudes) == pytest.approx(values, abs=1e-13)


def test_errors_name_sample_and_remedy():
    t = np.linspace(0, 2 * np.pi / RATE, 33)
    for arguments, rate, message in (
        ((t**2, t), RATE, "is .* off even steps .* ask the run for a number of samples"),
        ((t, np.where(t > 0.5, np.nan, t)), RATE, "values is not finite at sample 19"),
        ((t, t[:-1]), RATE, "n >= 3"),
        ((t, t), 1.1 * RATE, r"is 1.1 periods long, 1.13\d* if .* whole periods, at least one"),
        ((t, t), 0.4 * RATE, "is 0.4 periods long"),
        ((t, t), 0.0, "rate is 0, so there are no orders; give the speed"),
        ((t, np.exp(1j * t)), RATE, "values of type complex128; give real numbers"),
        ((t[::-1], t), RATE, "t goes from 0.8607.* s to 0 s; give times that increase"),
        (([0.0], [1.0]), RATE, r"t \(1,\) and values \(1,\); give .* n >= 3"),
    ):
        with pytest.raises(ValueError, match=message):
            spectrum(*arguments, rate=rate)
    with pytest.raises(ValueError, match="no bin at order 1.5"):
        spectrum(t, t, rate=RATE).at(1.5)


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
