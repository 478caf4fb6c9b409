"""Default curves of a run, and those that are zero throughout."""

import numpy as np

from ..mechanism.drivers import Driver
from ..results.checks.check import scales_of
from ..results.result import RunResult
from .panels import Panel, PlotQuantity, Wanted, panels_of

CURVE_LINES_MAX = 6  # [1] of one curve, unless asked for
MOTION_THRESHOLD = 1e-9  # [rad or m, or of its scale] smaller changes are no motion


def default_curves(run: RunResult) -> list[PlotQuantity]:
    """Return the quantities to plot by default.

    Angles or slides of joints that move (else the angular velocity of the first body), the energies, the efforts of
    drivers, and the reactions of joints.
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
    return chosen


def seen_panels(run: RunResult, wanted: Wanted) -> list[Panel]:
    """Return panels of several quantities; of force and moment, momentum and its moment the vanishing one is left
    out."""
    scale = scales_of(run)
    least = {
        "[N]": scale.force,
        "[N m]": scale.moment,
        "[kg m/s]": scale.momentum,
        "[kg m²/s]": scale.angular_momentum,
    }
    panels: list[Panel] = []
    for entry in wanted:
        found = panels_of(run, [entry])
        seen = [
            x for x in found if max(np.abs(y).max() for _, y in x.lines) > MOTION_THRESHOLD * least.get(x.unit, 0.0)
        ]
        panels += seen or found[:1]
    return panels
