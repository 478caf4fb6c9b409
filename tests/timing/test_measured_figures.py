"""Times in the texts belong to the kernels at hand: ``make figures`` after a change of what is compiled."""

import json

import pytest

from mbsd3d.extend import CACHE
from validation.benchmark.texts import MEASURED_FILE, ROOT

pytestmark = pytest.mark.timing


def test_times_in_the_texts_are_of_these_kernels():
    assert json.loads((ROOT / MEASURED_FILE).read_text(encoding="utf-8"))["kernels"] == CACHE.name, "run make figures"
