"""10 000 random models and 10 000 broken files: each runs, or is refused by an error of this package, at once."""

import warnings

import pytest
from helpers import hostile, hostile_files
from helpers.watchdog import TooLong, watched

BLOCKS = 20


@pytest.mark.slow
@pytest.mark.parametrize("block", range(BLOCKS))
def test_models_run_or_are_refused(block):
    """``hostile.ask(seed)`` is the model of a message below."""
    wrong, ran = [], 0
    count = hostile.COUNT // BLOCKS
    for seed in range(block * count, (block + 1) * count):
        try:
            with warnings.catch_warnings(), watched(f"model {seed}"):
                warnings.simplefilter("ignore")  # of numpy, about sums of numbers like 1e60
                hostile.ask(seed, 0.5)
            ran += 1
        except (TooLong, AssertionError) as error:
            wrong.append(str(error))
        except Exception as error:
            if hostile.foreign(error):
                wrong.append(f"model {seed}: {type(error).__name__}: {str(error)[:200]}")
    assert not wrong, "\n".join(wrong)
    assert ran > 0.1 * count  # they are not all refused for one silly reason


@pytest.mark.slow
@pytest.mark.parametrize("block", range(BLOCKS))
def test_files_are_read_or_refused(tmp_path, block):
    """``hostile_files.broken(seed, samples)`` is the file of a message below."""
    samples, wrong, refused = hostile_files.Samples(tmp_path), [], 0
    count = hostile_files.COUNT // BLOCKS
    for seed in range(block * count, (block + 1) * count):
        kind = "file"
        try:
            kind, read = hostile_files.broken(seed, samples)
            with warnings.catch_warnings(), watched(f"{kind} {seed}"):
                warnings.simplefilter("ignore")
                read()
        except (TooLong, AssertionError) as error:
            wrong.append(str(error))
        except Exception as error:
            refused += 1
            if hostile.foreign(error):
                wrong.append(f"{kind} {seed}: {type(error).__name__}: {str(error)[:200]}")
    assert not wrong, "\n".join(wrong)
    assert refused > 0.5 * count
