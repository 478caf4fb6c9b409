"""Curves beside the scene: the panels of `Solution.plot` over the time of the frames."""

from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from ...plotting.panels import Panel, panels_of
from ...results.certificate import scales_of
from .frames import Frames

LINES = 6  # in one curve at most, unless asked for
STILL = 1e-9  # [rad or m, or of its scale] what changes less stands still


class Curve(NamedTuple):
    """One pair of axes: lines (frames,) over time."""

    label: str  # "angle of hinge"
    unit: str  # "rad"
    lines: list[tuple[str, np.ndarray]]


def curves_of(solution: Any, frames: Frames, wanted: Any = None) -> list[Curve]:
    """Curves over the time of the frames: the panels of `Solution.plot` with their labels and units.

    Parameters
    ----------
    solution : Solution or Motion
        A motion (a mode) has none.
    frames : Frames
        Of the same run, see `frames_of`.
    wanted : sequence of quantity or (quantity, part, ...), or None
        As `Solution.plot` takes them; () = none; of force and moment, momentum and angular momentum the one that is
        zero throughout is left out. None = what tells most: angles or slides of at most 6 joints that
        move (else the angular velocity of the first body), the energies, and the reactions of at most 6 joints.

    Returns
    -------
    list of Curve

    Raises
    ------
    ValueError
        For an unknown quantity or part, or a part without the quantity.
    """
    if "v" not in solution.arrays:
        return []
    if isinstance(wanted, str) or not (wanted is None or isinstance(wanted, Iterable)):
        raise ValueError(f"curves = {wanted!r}; give a list of quantities or (quantity, part, ...)")
    scale = scales_of(solution)
    least = {
        "[N]": scale.force,
        "[N m]": scale.moment,
        "[kg m/s]": scale.momentum,
        "[kg m²/s]": scale.angular_momentum,
    }
    panels = []
    for entry in telling(solution) if wanted is None else wanted:
        found = panels_of(solution, [entry])
        panels += [panel for panel in found if largest(panel) > STILL * least.get(panel.unit, 0.0)] or found[:1]
    return [curve(solution.t, frames.t, panel) for panel in panels]


def largest(panel: Panel) -> float:
    """Largest absolute value of a panel."""
    return max(float(np.abs(values).max()) for _, values in panel.lines)


def curve(samples: np.ndarray, t: np.ndarray, panel: Panel) -> Curve:
    """A panel read at the times [s], between samples along straight lines."""
    label = f"{panel.label} ({' '.join(panel.note.split())})" if panel.note else panel.label
    lines = [(name, np.interp(t, samples, values)) for name, values in panel.lines]
    return Curve(label, panel.unit.strip("[]"), lines)


def telling(solution: Any) -> list[Any]:
    """The curves that are shown if none are asked for."""
    system, wanted = solution.system, []
    for kind in ("angle", "slide"):
        joints = [joint for joint in system.joints if getattr(joint, kind)() is not None]
        moving = [joint for joint in joints if np.ptp(getattr(solution, kind)(joint)) > STILL]
        if moving:
            wanted.append((kind, *moving[:LINES]))
            break
    else:
        wanted.append(("omega_body", system.bodies[0]))
    wanted.append("energy")
    return [*wanted, ("reaction", *system.joints[:LINES])] if system.joints else wanted
