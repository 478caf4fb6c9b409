"""The start: mass matrices and accelerations of two codes at the same state."""

from typing import Any

import numpy as np

from mbsd3d import State, accelerations
from mbsd3d.extend import mass_matrix
from validation.engines.base import Array, Twin

from .ours import Ours
from .quantities import largest
from .verdict import AGREES, DIFFERS, SKIPPED, Finding

MASS = 1e-10
"""Relative difference of mass matrices: rounding of some hundred products and of the engine's own kinematics."""
START = ("acceleration", "angular acceleration")


def judge_start(system: Any, state: State, twin: Twin, ours: Ours, tolerance: float) -> list[Finding]:
    """Findings about the mass matrix and the accelerations at the start."""
    findings = [judge_mass(system, state, twin)]
    by_quantity = acceleration_differences(system, state, twin, ours)
    for name, (difference, part) in by_quantity.items():
        status = AGREES if difference <= tolerance else DIFFERS
        found = dict(difference=difference, tolerance=tolerance, until=state.t, part=part)
        findings.append(Finding(twin.engine, name, status, **found))
    return findings


def judge_mass(system: Any, state: State, twin: Twin) -> Finding:
    """T'M T of our reference-point mass matrix against the engine's, T from its velocities to ours."""
    kinetic = twin.kinetic()
    if kinetic is None:
        return Finding(twin.engine, "mass matrix", SKIPPED, reason=f"{twin.engine} does not give it here")
    T, theirs = kinetic.map, kinetic.matrix
    ours = T.T @ mass_matrix(system, state) @ T
    difference = largest(ours - theirs) / largest(theirs)
    status = AGREES if difference <= MASS else DIFFERS
    return Finding(
        twin.engine, "mass matrix", status, difference=difference, tolerance=MASS, until=state.t, part="the whole"
    )


def acceleration_differences(system: Any, state: State, twin: Twin, ours: Ours) -> dict[str, tuple[float, str]]:
    """Quantity -> (greatest relative difference, whose body): divided by the greatest acceleration, or by gravity."""
    a = np.asarray(accelerations(system, state).arrays["acceleration"][0])
    return relative_to(a, twin.accelerations(), system, ours)


def relative_to(a: Array, theirs: Array, system: Any, ours: Ours) -> dict[str, tuple[float, str]]:
    """As above, for given (bodies, 6) accelerations."""
    size = ours.size
    pull = max(largest(a[:, :3]), float(np.linalg.norm(system.gravity)), size.speed * size.spin)
    scales = (pull, max(largest(a[:, 3:]), pull / size.length))
    found = {}
    for name, part, scale in zip(START, (slice(0, 3), slice(3, 6)), scales, strict=True):
        by_body = np.abs(a[:, part] - theirs[:, part]).max(axis=1) / scale
        found[name] = (float(by_body.max()), system.bodies[int(by_body.argmax())].name)
    return found
