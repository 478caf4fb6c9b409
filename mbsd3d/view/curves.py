"""Curves beside the scene: the panels of `Solution.plot` over the time of the frames."""

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..certificate import scales_of

if TYPE_CHECKING:
    from .motion import Frames

LINES = 6  # in one curve at most, unless asked for
STILL = 1e-9  # [rad or m, or of its scale] what changes less stands still


class Curve(NamedTuple):
    """One pair of axes: lines (frames,) over time."""

    label: str  # "angle of hinge"
    unit: str  # "rad"
    lines: list[tuple[str, np.ndarray]]


def curves_of(solution: Any, frames: "Frames", wanted: Any = None) -> list[Curve]:
    """Curves over the time of the frames: the panels of `Solution.plot` with their labels and units.

    Parameters
    ----------
    solution : Solution or Motion
        A motion (a mode) has none.
    frames : Frames
        Of the same run, see `frames_of`.
    wanted : sequence of quantity or (quantity, part, ...), or None
        As `Solution.plot` takes them; () = none. None = what tells most: angles or slides of at most 6 joints that
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
        raise ValueError(f"animate: curves = {wanted!r}; give a list of quantities or (quantity, part, ...)")
    if wanted is not None:
        panels = [panel for entry in wanted for panel in panels_of(solution, entry)]
    else:
        panels = [panel for entry in telling(solution) for panel in panels_of(solution, entry)]
        scale = scales_of(solution)
        least = {"[N]": STILL * scale.force, "[N m]": STILL * scale.moment}
        panels = [panel for panel in panels if largest(panel) > least.get(panel.unit, -1.0)]
    return [curve(solution.t, frames.t, panel) for panel in panels]


def panels_of(solution: Any, entry: Any) -> list[Any]:
    """The panels of "quantity" or ("quantity", part, ...)."""
    from ..panels import OF_THE_SYSTEM, PANELS

    quantity, *parts = entry if isinstance(entry, tuple | list) and entry else (entry,)
    if not isinstance(quantity, str) or quantity not in PANELS:
        raise ValueError(f"animate: curve {quantity!r} is unknown; give one of {', '.join(PANELS)}")
    if parts and quantity in OF_THE_SYSTEM:
        raise ValueError(f"animate: {quantity} is that of the whole system; give no parts")
    return PANELS[quantity](solution, quantity, tuple(parts))


def largest(panel: Any) -> float:
    """Largest absolute value of a panel."""
    return max(float(np.abs(values).max()) for _, values in panel.lines)


def curve(samples: np.ndarray, t: np.ndarray, panel: Any) -> Curve:
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
