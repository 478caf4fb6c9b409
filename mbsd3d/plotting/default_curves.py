"""Default curves of a run, and those that are zero throughout."""

import numpy as np

from ..equations.compiled import holders_of
from ..mechanism.drivers import Driver
from ..mechanism.switching import is_switching
from ..results.result import RunResult
from .panels import Panel, PlotQuantity, Wanted, panels_of

CURVE_LINES_MAX = 6  # [1] of one curve, unless asked for
PAIRED_UNITS = ("[N]", "[N m]", "[kg m/s]", "[kg m²/s]")  # of which one is left out where it vanishes
MOTION_THRESHOLD = 1e-9  # [rad or m, or of its scale] smaller changes are no motion


def default_curves(run: RunResult) -> list[PlotQuantity]:
    """Return the quantities to plot by default.

    Angles or slides of joints that move (else the angular velocity of the first body), the energies, the efforts of
    drivers, the reactions of joints, and which parts that switch at events are engaged.
    """
    system = run.system
    first: PlotQuantity = ("omega_body", system.bodies[0])
    for kind in ("slide", "angle"):
        joints = [joint for joint in system.joints if getattr(joint, kind)() is not None]
        if moving := [joint for joint in joints if np.ptp(getattr(run, kind)(joint)) > MOTION_THRESHOLD]:
            first = (kind, *moving[:CURVE_LINES_MAX])
    held = [joint for joint in system.joints if not isinstance(joint, Driver)]
    chosen: list[PlotQuantity] = [first, "energy"]
    if run.compiled.drives:
        chosen.append("effort")
    if held:
        chosen.append(("reaction", *held[:CURVE_LINES_MAX]))
    if switching := [part for part in holders_of(system) if is_switching(part)]:
        chosen.append(("engaged", *switching[:CURVE_LINES_MAX]))
    return chosen


def seen_panels(run: RunResult, wanted: Wanted) -> list[Panel]:
    """Return panels of several quantities; of force and moment, momentum and its moment the vanishing one is left
    out."""
    panels: list[Panel] = []
    for entry in wanted:
        found = panels_of(run, [entry])
        least = [MOTION_THRESHOLD * x.size if x.unit in PAIRED_UNITS else 0.0 for x in found]
        seen = [
            x for x, rounding in zip(found, least, strict=True) if max(np.abs(y).max() for _, y in x.lines) > rounding
        ]
        panels += seen or found[:1]
    return panels
