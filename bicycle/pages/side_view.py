"""Bicycle from the side, to scale, as a small SVG from its parameters alone; colours are variables of the page.

Frame and fork are uniform ellipsoids with their mass, centre of mass and inertia, so that the picture shows where the
mass is.
"""

from collections.abc import Callable

import numpy as np
from markupsafe import Markup, escape

from ..parameters import Parameters

UNITS_PER_METRE = 80.0  # [units of the drawing/m] all bicycles of a page have one scale
REAR_MARGIN, DRAWING_WIDTH, DRAWING_HEIGHT = 0.7, 2.5, 1.9  # [m] behind the rear contact, of all, above the ground
GROUND_MARGIN = 8.0  # [units of the drawing] below the ground


def side_view(parameters: Parameters) -> Markup:
    """Draw an SVG element, forward to the right: wheels, frame, fork, steer axis, trail, and ellipsoids of frame and
    fork.
    """
    p = parameters

    def at(x: float, z: float) -> str:
        """Return the coordinates on paper, z down from the ground, of a point."""
        return f"{UNITS_PER_METRE * (REAR_MARGIN + x):.1f} {UNITS_PER_METRE * (DRAWING_HEIGHT + z):.1f}"

    def line(kind: str, *points: tuple[float, float]) -> str:
        return f'<path class="{kind}" d="M{"L".join(at(*point) for point in points)}"/>'

    rear, front, tilt = (0.0, -p.rR), (p.w, -p.rF), np.tan(p.lam)
    head = (p.w + p.c - 0.95 * tilt, -0.95) if p.lam < 1.0 else front
    seat = (0.33 * p.w, -0.85)
    body = line("ground", (-REAR_MARGIN, 0.0), (DRAWING_WIDTH - REAR_MARGIN, 0.0))
    body += line("axis", head, (p.w + p.c, 0.0)) + line("trail", (p.w, 0.0), (p.w + p.c, 0.0))
    body += ellipse(p, "B", "t0", at) + ellipse(p, "H", "t1", at)
    body += line("tube", rear, seat, head, front) + line("tube", seat, (0.45 * p.w, -0.3), rear)
    for (x, z), radius in ((rear, p.rR), (front, p.rF)):
        cx, cy = at(x, z).split()
        body += f'<circle class="wheel" cx="{cx}" cy="{cy}" r="{UNITS_PER_METRE * radius:.1f}"/>'
    label = escape(f"{p.name} from the side")
    return Markup(
        f'<svg viewBox="0 0 {UNITS_PER_METRE * DRAWING_WIDTH:g} {UNITS_PER_METRE * DRAWING_HEIGHT + GROUND_MARGIN:g}" '
        f'role="img" aria-label="{label}">{body}</svg>'
    )


def ellipse(p: Parameters, part: str, tint: str, at: Callable[[float, float], str]) -> str:
    """Draw the ellipsoid of a part seen from the side, with its centre of mass; nothing if it has no mass."""
    mass = getattr(p, f"m{part}")
    if mass == 0.0:
        return ""
    semi, turn = semi_axes(p.inertia(part), mass)
    cx, cy = at(getattr(p, f"x{part}"), getattr(p, f"z{part}")).split()
    a, b = np.maximum(UNITS_PER_METRE * semi, 1.5)
    shape = (
        f'<ellipse class="mass {tint}" rx="{a:.1f}" ry="{b:.1f}" transform="translate({cx} {cy}) rotate({turn:.1f})"/>'
    )
    return f'{shape}<circle class="centre {tint}" cx="{cx}" cy="{cy}" r="2.6"/>'


def semi_axes(inertia: np.ndarray, mass: float) -> tuple[np.ndarray, float]:
    """Return the semi-axes (2,) [m] of the uniform ellipsoid in the plane of x and z, and the angle of the first from x
    to z [deg].

    Negative second moments, which only impossible inertias have, are drawn as zero.
    """
    Ixx, Iyy, Izz, Ixz = inertia[0, 0], inertia[1, 1], inertia[2, 2], inertia[0, 2]
    moments = np.array([[Iyy + Izz - Ixx, -2.0 * Ixz], [-2.0 * Ixz, Ixx + Iyy - Izz]]) / 2.0
    values, vectors = np.linalg.eigh(moments)
    turn = np.degrees(np.arctan2(vectors[1, 0], vectors[0, 0]))
    return np.sqrt(5.0 * np.maximum(values, 0.0) / mass), float(turn)
