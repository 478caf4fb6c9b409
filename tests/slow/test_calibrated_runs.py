"""A hundred runs of the calibration, drawn at random from those of `make calibrate`."""

import numpy as np
import pytest

from mbsd3d import DOP853, RadauIIA
from validation.calibration.families import FAMILIES
from validation.calibration.judge import build, cases, compare, examine, march
from validation.calibration.table import described

RUN_COUNT = 2100  # of docs/theory/certificate.md

pytestmark = pytest.mark.slow

DRAWN = 100
ALL = cases(RUN_COUNT, 0, tuple(FAMILIES))
SAMPLE = [ALL[k] for k in sorted(np.random.default_rng(30).choice(RUN_COUNT, DRAWN, replace=False))]


@pytest.mark.parametrize(("family", "seed"), SAMPLE)
def test_nothing_is_wrong_without_a_word_or_fails_that_is_right(family, seed):
    record = examine(family, seed)
    assert not record.silent, described(record)
    if record.kind != "step hopeless":  # work and impulses of such steps are no better than the balances say
        assert not record.false_alarm, described(record)


@pytest.mark.parametrize("family", FAMILIES)
def test_the_truth_is_what_a_tight_run_finds(family):
    """To 1e-9: the truths are known to about 1e-11, and the tight runs err by a thousand roundings of many turns."""
    problem, _ = build(family, RUN_COUNT)
    method = RadauIIA() if family == "stiff_bushing" else DOP853(max_step=problem.t_end / 300)
    runs = march(problem, method, 1e-11 if family == "stiff_bushing" else 1e-12, 25)
    assert len(runs) == len(problem.stops) + 1
    assert compare(problem, runs)[0] < 1e-9
