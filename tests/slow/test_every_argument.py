"""Every public name with every argument replaced by what people and programs give by mistake.

Each call answers, or is refused at once by an error of this package in a sentence that fits a screen.
"""

import warnings

import numpy as np
import pytest
from helpers import every_call, hostile
from helpers.watchdog import TooLong, watched

OWNERS = (
    "", "Solution", "System", "Body", "Linearization", "StateSpace", "Campbell", "Spectrum", "Density", "Stepper",
    "Signal", "Snapshot",
)  # fmt: skip
LONGEST = 500  # characters; the names of many parts may be among them


def answered(make, given):
    """What is wrong with the answer to a call; None if nothing is."""
    try:
        with warnings.catch_warnings(), watched("the call"):
            warnings.simplefilter("error")
            make(**given)
    except (TooLong, AssertionError) as error:
        return str(error)
    except Exception as error:
        if hostile.foreign(error):
            return f"{type(error).__name__}: {str(error)[:200]}"
        if len(str(error)) > LONGEST:
            return f"{len(str(error))} characters"
    return None


def wrong_answers(calls):
    """One line each; the right calls are among them if they are refused."""
    found, count = [], 0
    for make, given in calls:
        name = every_call.named(make)
        try:
            make(**given)
        except Exception as error:
            found.append(f"{name} as it should be: {error}")
        for key in given:
            for value in every_call.WRONG:
                if isinstance(value, np.ndarray) and isinstance(given[key], bool):
                    continue  # anything else is true or false
                count += 1
                problem = answered(make, given | {key: value})
                if problem is not None:
                    found.append(f"{name}({key}={value!s:.30}): {problem}")
    assert count > 500
    return found


@pytest.mark.slow
@pytest.mark.parametrize("group", ["parts", "measured", "answers", "questions"])
def test_every_argument(group, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    every_call.files(tmp_path)
    calls = getattr(every_call, group)
    wrong = wrong_answers(calls(tmp_path) if group in ("answers", "questions") else calls())
    assert not wrong, "\n".join(wrong)


@pytest.mark.slow
def test_every_misspelt_argument(tmp_path):
    """By the public name: a method is one of Solution, not of the class it is written in."""
    every_call.files(tmp_path)
    for make, given in every_call.calls(tmp_path):
        if "<lambda>" in every_call.named(make):
            continue
        with pytest.raises(TypeError) as caught:
            make(**given, colur=1)
        message = str(caught.value).replace(".__call__()", "()")  # an object that is called
        assert "colur" in message and "__" not in message, message
        owner = message.partition(":")[0].partition("(")[0].rpartition(".")[0]
        assert owner in OWNERS, message
