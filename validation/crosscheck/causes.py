"""Attribution: a difference is explained only if changing its cause, in the same run, changes it as it should."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from mbsd3d import State
from validation.crosscheck.judge import LOOSEST, Runs, limit_difference
from validation.crosscheck.ours import Ours
from validation.crosscheck.start import acceleration_differences
from validation.crosscheck.verdict import DIFFERS, EXPLAINED, Attribution, Finding
from validation.twins.base import NotComparable, Twin


class Cause(NamedTuple):
    """A setting of a twin that may be to blame, what it is changed to, and the part of a difference that then stays."""

    name: str
    setting: str
    value: Any
    stays: float


CAUSES: dict[str, tuple[Cause, ...]] = {
    "MuJoCo": (Cause("softness of the equalities (solref)", "softness", 8.0, 0.25),),  # half: error as its square
    "Exudyn": (Cause("tolerance of Newton's iterations", "tolerance", 1e-13, 0.0),),
}
"""By engine, in the order they are tried."""
NEAR = 0.2
"""By how much of the whole the remaining part may miss ``stays``: a second cause of that size would not be seen.

So it is never more than `LOOSEST` of the quantity's size, however great the difference."""


def explained(
    findings: Sequence[Finding], make: Callable[..., Twin], system: Any, state: State, ours: Ours,
    climb: Callable[[Twin], Runs] | None = None, span: int = 0,
) -> list[Finding]:  # fmt: skip
    """The findings, with a tried and measured cause on those that differ; without one they stay as they are."""
    suspects = {x.quantity: x for x in findings if x.status == DIFFERS}
    if not suspects:
        return list(findings)
    proofs: dict[str, list[Attribution]] = {name: [] for name in suspects}
    for cause in CAUSES.get(findings[0].engine, ()):
        for name, after in changed(cause, make, system, state, ours, climb, span).items():
            before = suspects[name].difference if name in suspects else None
            if before and abs(after - cause.stays * before) <= unseen(cause, suspects[name]):
                proofs[name].append(Attribution(cause.name, f"{cause.setting} = {cause.value:g}", before, after))
    return [
        replace(x, status=EXPLAINED, attributions=(*x.attributions, *proofs[x.quantity]))
        if x.status == DIFFERS and proofs[x.quantity]
        else x
        for x in findings
    ]


def unseen(cause: Cause, finding: Finding) -> float:
    """How far the difference may be from what the cause leaves; where that is nothing, the rest has to agree."""
    share = NEAR * max(cause.stays, 0.05) * finding.difference
    return min(share, LOOSEST if cause.stays else finding.bound)


def changed(
    cause: Cause, make: Callable[..., Twin], system: Any, state: State, ours: Ours,
    climb: Callable[[Twin], Runs] | None, span: int,
) -> dict[str, float]:  # fmt: skip
    """Quantity -> difference with the cause changed; of motions that of the limits, as everywhere."""
    try:
        twin = make(**{cause.setting: cause.value})
        found = {name: x[0] for name, x in acceleration_differences(system, state, twin, ours).items()}
        if climb is not None and span:
            runs = climb(twin)
            found |= {name: limit_difference(runs, name, span)[0] for name in runs.values}
    except NotComparable:
        return {}
    return found
