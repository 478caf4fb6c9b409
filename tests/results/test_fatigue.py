"""Rainflow counting against the standard's example and a second algorithm, Miner's sum, curves of lives, refusals."""

from collections import Counter

import numpy as np
import pytest

from mbsd3d import SNCurve, miner, rainflow

ASTM = [-2, 1, -3, 5, -1, 3, -4, 4, -2]  # E1049-85, Fig. 6
STEEL = SNCurve(amplitude=150e6, cycles=2e6, slope=5)


def by_four_points(history):
    """(range, mean) -> count: inner pairs no larger than both neighbours are cycles, the rest half cycles."""
    points, found = [], Counter()
    for x in history:
        if points and x == points[-1]:
            continue
        if len(points) > 1 and (points[-1] - points[-2]) * (x - points[-1]) > 0:
            points[-1] = x
        else:
            points.append(x)
    k = 0
    while k + 3 < len(points):
        a, b, c, d = points[k : k + 4]
        if abs(c - b) <= abs(b - a) and abs(c - b) <= abs(d - c):
            found[abs(c - b), 0.5 * (b + c)] += 1.0
            del points[k + 1 : k + 3]
            k = max(k - 2, 0)
        else:
            k += 1
    for a, b in zip(points[:-1], points[1:], strict=True):
        found[abs(b - a), 0.5 * (a + b)] += 0.5
    return found


def test_the_example_of_the_standard():
    cycles = rainflow(ASTM)
    assert cycles.by_range() == {3.0: 0.5, 4.0: 1.5, 6.0: 0.5, 8.0: 1.0, 9.0: 0.5}
    table = np.column_stack([cycles.range, cycles.mean, cycles.count]).tolist()
    assert table == [
        [3, -0.5, 0.5], [4, -1.0, 0.5], [4, 1.0, 1.0], [8, 1.0, 0.5], [9, 0.5, 0.5], [8, 0.0, 0.5], [6, 1.0, 0.5],
    ]  # fmt: skip
    assert repr(cycles) == "<cycles: 4, of ranges up to 9>"
    assert cycles.at_least(4.5).by_range() == {6.0: 0.5, 8.0: 1.0, 9.0: 0.5}


def test_another_algorithm_counts_the_same():
    """Random histories of few values, so that equal ranges and plateaus are among them; no rounding is involved."""
    rng = np.random.default_rng(5)
    for _ in range(300):
        history = rng.integers(-6, 7, size=rng.integers(1, 60)).tolist()
        cycles = rainflow(history)
        found = Counter()
        for size, mean, count in zip(cycles.range, cycles.mean, cycles.count, strict=True):
            found[float(size), float(mean)] += float(count)
        assert found == by_four_points(history)


def test_a_history_without_a_turn():
    assert rainflow([3.0]).count.size == rainflow([2.0, 2.0, 2.0]).count.size == 0
    assert rainflow([0.0, 1.0, 4.0]).by_range() == {4.0: 0.5}
    assert miner(rainflow([1.0]), STEEL) == 0.0


def test_the_damage_of_the_example():
    """In units of 60 MPa a step; sums of n / N by hand."""
    cycles = rainflow(60e6 * np.array(ASTM))
    assert miner(cycles, STEEL) == pytest.approx(1.0854080000000002e-05, rel=1e-12)  # rounding
    assert miner(cycles, STEEL, strength=900e6) == pytest.approx(1.3130316263946844e-05, rel=1e-12)
    by_table = miner(cycles, lambda s: 10.0 ** np.interp(np.log10(s), [6.0, 10.0], STEEL_LOG))
    assert by_table == pytest.approx(1.0854080000000002e-05, rel=1e-9)  # a line in logarithms


STEEL_LOG = [np.log10(2e6) - 5.0 * (x - np.log10(150e6)) for x in (6.0, 10.0)]


def test_below_the_knee():
    s = np.array([300e6, 150e6, 75e6])
    assert STEEL(s) == pytest.approx([2e6 / 32, 2e6, 2e6 * 32])
    haibach = SNCurve(amplitude=150e6, cycles=2e6, slope=5, slope_below=9)
    assert haibach(s) == pytest.approx([2e6 / 32, 2e6, 2e6 * 512])
    endless = SNCurve(amplitude=150e6, cycles=2e6, slope=5, limit=True)
    assert endless(s).tolist() == [*STEEL(s)[:2].tolist(), np.inf]
    assert miner(rainflow([0.0, 100e6, 0.0]), endless) == 0.0


def test_refusals_name_the_remedy():
    cycles = rainflow([0.0, 1.9e9, 0.0])
    for use, message in (
        (lambda: miner(cycles, STEEL, strength=900e6), r"a mean stress of 9.5e\+08 Pa reaches the strength 9e\+08 Pa"),
        (lambda: miner([1.0, 2.0], STEEL), r"miner: cycles \[1.0, 2.0\] are not counted; give those of rainflow"),
        (lambda: miner(cycles, 2e6), "miner: life 2000000.0: give an SNCurve, or a function"),
        (lambda: miner(cycles, lambda s: 0.0 * s), "must return cycles > 0"),
        (lambda: miner(cycles, lambda s, t: s), "miner: life: the function raises TypeError: .*; give one that takes"),
        (lambda: rainflow([[1.0, 2.0]]), r"rainflow: history: give finite numbers \(samples,\)"),
        (lambda: rainflow([0.0, np.nan]), "rainflow: history"),
        (lambda: rainflow([]), "rainflow: history"),
        (lambda: STEEL("high"), "SNCurve: amplitudes: 'high' is not numeric"),
        (lambda: STEEL([np.nan, 1e8]), "is not finite"),
        (lambda: SNCurve(amplitude=-1.0, cycles=2e6, slope=5), "SNCurve: amplitude: -1.0 is not positive"),
        (lambda: SNCurve(amplitude=1.0, cycles=2e6, slope=5, slope_below=9, limit=True), "leave slope_below out"),
        (lambda: SNCurve(amplitude=1.0, cycles=2e6, slope=5, limit="yes"), "limit 'yes'; give True or False"),
    ):
        with pytest.raises(ValueError, match=message):
            use()
