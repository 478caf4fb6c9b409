"""The machine-readable report: JSON with every finding, in SI units.

format    1; rises when a field changes its meaning
mbsd3d    version            machine   processor, cores, versions of what computed
quick     short list?        verdict   "agrees", or "differs" if any case does
complete  whether all cases of the list are in it
counts    verdict -> number of cases
judges    judge -> what it is
cases     per case: name, group, title, verdict, seconds, facts, and
  findings      judge, verdict, quantity, error, limit, note   (error, limit null where there is no number)
  attributions  differences to other engines explained by a number of the same run
"""

import json
from collections import Counter
from collections.abc import Sequence
from typing import Any

from mbsd3d.extend import package_version
from validation.machine import machine

from .findings import AGREES, DIFFERS, JUDGES, Record, failed

FORMAT = 1
PICTURES = ("picture", "charts")


def content_of(records: Sequence[Record], *, quick: bool, complete: bool) -> dict[str, Any]:
    """The content of the JSON file; pictures are left to the page."""
    cases = [{key: value for key, value in record.to_dict().items() if key not in PICTURES} for record in records]
    return {
        "format": FORMAT,
        "mbsd3d": package_version(),
        "machine": machine("numpy", "numba", "mujoco-core", "exudyn"),
        "quick": quick,
        "complete": complete,
        "verdict": DIFFERS if failed(records) else AGREES,
        "counts": dict(Counter(record.verdict for record in records)),
        "judges": JUDGES,
        "cases": cases,
    }


def encoded(content: dict[str, Any]) -> bytes:
    """UTF-8, indented; NaN and infinity are no JSON and would be an error."""
    return f"{json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)}\n".encode()
