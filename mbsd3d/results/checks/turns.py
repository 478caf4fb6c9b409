"""Orientations against angular velocities, and angles of hinges against their rates, step by step."""

from ...dynamics.turning import TURN_MISS_MAX
from ..result import RunResult
from .check import DRIFT_LIMIT_MAX, Check


def turning_checks(solution: RunResult) -> list[Check]:
    """Check that bodies turned as their angular velocities say, and that hinges counted their turns."""
    record = solution.record
    if record.miscount is None or not record.steps:
        return []
    meaning = f"body '{record.missed_by}' turned otherwise than by its angular velocity; shorten the step"
    checks = [Check("orientations", record.missed, DRIFT_LIMIT_MAX, meaning)]
    if solution.compiled.model.coordinate.size:
        meaning = "hinges turned so unevenly in a step that their turns cannot be counted; shorten the step"
        checks.append(Check("turns of hinges", record.miscount, TURN_MISS_MAX, meaning))
    return checks
