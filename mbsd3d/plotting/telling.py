"""What of a run is drawn if nothing is asked for, and what of it is zero throughout."""

import numpy as np

from ..mechanism.drivers import Driver
from ..results.checks.check import scales_of
from ..results.result import RunResult
from .panels import Panel, Wanted, panels_of

LINES = 6  # of one curve, at most, unless asked for
STILL = 1e-9  # [rad or m, or of its scale] what changes less stands still


def telling(run: RunResult) -> list:
    """The quantities that tell most.

    Angles or slides of joints that move (else the angular velocity of the first body), the energies, the efforts of
    drivers, and the reactions of joints.
    """
    system, first = run.system, ("omega_body", run.system.bodies[0])
    for kind in ("slide", "angle"):
        joints = [joint for joint in system.joints if getattr(joint, kind)() is not None]
        if moving := [joint for joint in joints if np.ptp(getattr(run, kind)(joint)) > STILL]:
            first = (kind, *moving[:LINES])
    held = [joint for joint in system.joints if not isinstance(joint, Driver)]
    efforts = ["effort"] if run.compiled.drives else []
    return [first, "energy", *efforts, *([("reaction", *held[:LINES])] if held else [])]


def seen_panels(run: RunResult, wanted: Wanted) -> list[Panel]:
    """Panels of several quantities; of force and moment, momentum and its moment the one that is zero is left out."""
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
        seen = [x for x in found if max(np.abs(y).max() for _, y in x.lines) > STILL * least.get(x.unit, 0.0)]
        panels += seen or found[:1]
    return panels
