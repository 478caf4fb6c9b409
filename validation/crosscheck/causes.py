"""Attribution: a difference is explained only if changing its cause, in the same run, changes it as it should."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import State
from validation.engines.base import NotComparable, Twin

from .judge import Runs, differences
from .ladder import INTERVALS
from .ours import Ours
from .quantities import quantities
from .start import START, acceleration_differences
from .verdict import DIFFERS, EXPLAINED, Attribution, Finding


class Cause(NamedTuple):
    """A setting of a twin that may be to blame, its changed value, and by what a difference must shrink to prove it."""

    name: str
    setting: str
    value: Any
    shrinks: float


CAUSES: dict[str, tuple[Cause, ...]] = {
    "MuJoCo": (
        Cause("softness of the loops (solref)", "softness", 1.0, 0.6),
    ),
    "Exudyn": (),
}  # fmt: skip
"""By engine. ``shrinks``: the difference has to fall below this part of what it was."""


def explained(
    findings: Sequence[Finding], again: Callable[..., Twin], system: Any, state: State, ours: Ours,
    runs: Runs | None = None, span: int = 0,
) -> list[Finding]:  # fmt: skip
    """The findings, with a tried and measured cause on those that differ; without one they stay as they are."""
    suspects = [x for x in findings if x.status == DIFFERS]
    if not suspects:
        return list(findings)
    proofs: dict[str, list[Attribution]] = {x.quantity: [] for x in suspects}
    for cause in CAUSES.get(suspects[0].engine, ()):
        for name, (before, after) in changed(cause, again, system, state, ours, runs, span).items():
            if name in proofs and after <= cause.shrinks * before:
                proofs[name].append(Attribution(cause.name, f"{cause.setting} = {cause.value}", before, after))
    return [
        replace(x, status=EXPLAINED, attributions=tuple(proofs[x.quantity]))
        if x.status == DIFFERS and proofs[x.quantity]
        else x
        for x in findings
    ]


def changed(
    cause: Cause, again: Callable[..., Twin], system: Any, state: State, ours: Ours, runs: Runs | None, span: int
) -> dict[str, tuple[float, float]]:
    """Quantity -> (difference as it was, with the cause changed), each at the same step."""
    try:
        twin = again(**{cause.setting: cause.value})
        plain = again()
    except NotComparable:
        return {}
    before = acceleration_differences(system, state, plain, ours)
    after = acceleration_differences(system, state, twin, ours)
    found = {name: (before[name][0], after[name][0]) for name in START}
    if runs is None or not span:
        return found
    try:
        motion = twin.run(float(ours.motion.t[-1]), runs.ladder.steps[-1], INTERVALS)
    except NotComparable:
        return found
    other = quantities(system, motion, ours.size)
    for name, x in other.items():
        own = runs.own[name]
        away = np.abs(x.values / x.scale - own.values / own.scale)[:span]
        found[name] = (differences(runs, name, span)[-1], float(away.max()))
    return found
