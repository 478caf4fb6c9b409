"""Times in the texts belong to the kernels at hand: ``make figures`` after a change of what is compiled."""

import json
from pathlib import Path

import pytest

from mbsd3d.extend import CACHE_FOLDER

pytestmark = pytest.mark.timing
ROOT = Path(__file__).parents[2]


def test_times_in_the_texts_are_of_these_kernels():
    measured = json.loads((ROOT / "docs" / "measured.json").read_text(encoding="utf-8"))
    assert measured["kernels"] == CACHE_FOLDER.name, "run make figures"
