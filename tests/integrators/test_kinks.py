"""Steps over a kink of a rate, as contacts make it when they open: the estimated error must see it wherever it lies."""

import numpy as np
import pytest
from models import dropped_wheel

from mbsd3d import simulate
from mbsd3d.integrators.dop853 import TABLE

PLACES = np.linspace(0.0, 1.0, 4001)  # of the kink in the step
c, (FIRST, SECOND, THIRD) = TABLE.c, TABLE.error


def of_kink(weights):
    """What a sum of rates makes of the rate max(t - place, 0)."""
    return weights @ np.maximum(c[:, None] - PLACES, 0.0)


def estimated(*fifth):
    """Largest estimate of fifth order, corrected by that of third order as in the time loop."""
    e5 = np.max([np.abs(of_kink(weights)) for weights in fifth], axis=0)
    return e5**2 / np.sqrt(e5**2 + 0.01 * of_kink(THIRD) ** 2 + 1e-300)


def test_both_estimates_are_of_fifth_order_with_the_same_leading_term():
    for power in range(5):
        assert abs(SECOND @ c**power) < 1e-15
    assert SECOND @ c**5 == pytest.approx(FIRST @ c**5, rel=1e-12)
    assert np.abs(SECOND).max() < np.abs(FIRST).max()  # rounding of rates counts no more than before


def test_a_kink_is_seen_wherever_it_lies():
    error = np.abs(of_kink(TABLE.b) - 0.5 * (1.0 - PLACES) ** 2)
    missed = error > 30.0 * estimated(FIRST, SECOND)
    alone = error > 30.0 * estimated(FIRST)
    assert not missed[PLACES < 0.999].any()
    assert alone.mean() > 0.02  # one estimate alone is blind there


@pytest.mark.parametrize("rtol", [1e-6, 1e-8, 1e-10, 1e-12])
def test_a_bouncing_wheel_passes_from_any_height(rtol):
    """A tyre with a damper leaves the road before it is round again: its power has a kink at each end of that."""
    rng = np.random.default_rng(8)
    for _ in range(25):
        _, system = dropped_wheel(rng)
        run = simulate(system, 1.2, rtol=rtol, output=61)
        assert run.certificate.passed, f"{system.name}\n{run.certificate}"
