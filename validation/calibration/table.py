"""Table of the calibration: how often certificate and estimate were right about runs of each method."""

from collections.abc import Sequence

import numpy as np

from validation.calibration.judge import Record
from validation.calibration.problem import METHODS
from validation.calibration.settings import CLASSES, FIXED_CLASSES

HEAD = (
    "method", "asked for", "runs", "passed, not wrong", "wrong: failed", "wrong: estimate warns", "wrong: a note warns",
    "wrong, silent", "right, failed", "failed between", "stopped", "error over what was asked: median, worst",
)  # fmt: skip
COMMAND = "python -m validation.calibration"
KINDS = [text for _, text in (*CLASSES, *FIXED_CLASSES)] + ["poses"]


def outcome(r: Record) -> int:
    """Return the column of a run, from "passed, not wrong" to "stopped"."""
    if r.stopped:
        return 7
    if r.wrong:
        return 1 if not r.passed else 2 if r.estimate == "warns" else 3 if r.warned else 4
    return 5 if r.false_alarm else 0 if r.passed else 6


def row(method: str, kind: str, records: Sequence[Record]) -> list[str]:
    """Return one line: counts of the outcomes, which add up to the runs."""
    counts = np.bincount([outcome(r) for r in records], minlength=8)
    asked = [r.error if r.fixed or kind == "poses" else r.relative / r.rtol for r in records if not r.stopped]
    found = f"{np.median(asked):.1e}, {max(asked):.1e}" if asked else ""
    return [method, kind, str(len(records)), *map(str, counts), found]


def rows(records: Sequence[Record]) -> list[list[str]]:
    """Return all lines: method by method, from tight to loose."""
    lines = []
    for method in (*METHODS, "Kinematic"):
        for kind in KINDS:
            group = [r for r in records if (r.method, r.kind) == (method, kind)]
            lines += [row(method, kind, group)] if group else []
    return [*lines, row("all", "", records)[:-1] + [""]] if records else []


def markdown(lines: Sequence[Sequence[str]]) -> str:
    """Return the table as a page has it, of its `rows`."""
    lines = [HEAD, ["---"] * len(HEAD), *lines]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def text(records: Sequence[Record]) -> str:
    """Return the table for a terminal."""
    lines = [list(HEAD), *rows(records)]
    widths = [max(len(line[k]) for line in lines) for k in range(len(HEAD))]
    return "\n".join("  ".join(x.ljust(w) for x, w in zip(line, widths, strict=True)).rstrip() for line in lines)


def offenders(records: Sequence[Record]) -> list[str]:
    """Return the silently wrong runs, the right ones that fail, and errors, each with the command that repeats it."""
    groups = {
        "wrong without a word": [r for r in records if r.silent],
        "right and not passed": [r for r in records if r.false_alarm],
        "ended in an error": [r for r in records if r.stopped],
    }
    lines = []
    for what, found in groups.items():
        lines += [f"{len(found)} {what}"] if found else []
        for r in sorted(found, key=lambda r: (r.family, r.method, r.kind)):
            lines += [f"  {described(r)}", f"    {COMMAND} --family {r.family} --seed {r.seed} --runs 1"]
    return lines


def described(r: Record) -> str:
    """Return a run in a line: settings, true error, and the statements of certificate and estimate."""
    if r.stopped:
        return f"{r.family}: {r.settings}: {r.stopped}"
    said = "; ".join(r.failures) or "passed"
    return (
        f"{r.family}: {r.settings}: error {r.error:.1e} of {r.worst}; {said}; estimate {r.estimate} ({r.estimated:.1e})"
    )
