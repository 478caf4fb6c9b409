"""Test cases of the suite in the order of the report, with their judges."""

import fnmatch
from itertools import chain

from mbsd3d.errors import InputError
from validation.suite.trials import bicycles, engines, families, loops, nvh, references, tyres, vehicles
from validation.suite.trials.trial import Trial


def trials(quick: bool = False) -> list[Trial]:
    """Return all test cases; the short list has the fewest random systems and engines.

    ``quick``: whether the run must be short. Names are unique.
    """
    rides = bicycles.trials, tyres.trials, vehicles.trials
    some = families.ladders, loops.trials, families.demonstrations, engines.trials, nvh.trials, families.randoms
    return [trial for group in (references.trials, *rides, *some) for trial in group(quick)]


def chosen(everything: list[Trial], names: tuple[str, ...]) -> list[Trial]:
    """Return the test cases of these names, which may be patterns such as ``nvh_*``; all for none.

    InputError for a name that no trial has.
    """
    known = {trial.name: trial for trial in everything}
    found = {name: fnmatch.filter(known, name) for name in names}
    unknown = [name for name, matches in found.items() if not matches]
    if unknown:
        raise InputError(f"--case '{unknown[0]}': there is no such case; --list names them all")
    return [known[name] for name in dict.fromkeys(chain(*found.values()))] if names else everything
