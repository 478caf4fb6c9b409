"""Circles as text: a table of all turns, and a summary of the families."""

from collections.abc import Sequence

import numpy as np

from .families import Family
from .turning import Turn

COLUMNS = {
    "lean": "rad", "steer": "rad", "speed": "m/s", "yaw_rate": "rad/s", "radius": "m", "torque": "N m", "load": "N",
    "friction": "-", "growth": "1/s",
}  # fmt: skip
"""Of the table: quantities of a turn with their units."""


def table(found: Sequence[Family], turns: Sequence[Turn] = ()) -> str:
    """CSV of all turns: the family it belongs to (0 = held by a steer torque), then `COLUMNS`."""
    rows = [(k, turn) for k, family in enumerate(found, 1) for turn in family.turns] + [(0, turn) for turn in turns]
    lines = [",".join(["family", *(f"{name} [{unit}]" for name, unit in COLUMNS.items())])]
    lines += [",".join([str(k), *(repr(float(getattr(turn, name))) for name in COLUMNS)]) for k, turn in rows]
    return "\n".join(lines) + "\n"


def summary(found: Sequence[Family]) -> str:
    """What a person wants to know of the families, one line per end and special turn."""
    lines = []
    for k, family in enumerate(found, 1):
        lines.append(f"family {k}: from {family.ends[0]} to {family.ends[1]}, {len(family.turns)} circles")
        first, last = family.turns[0], family.turns[-1]
        for name, turn in ((family.ends[0], first), *family.special, (family.ends[1], last)):
            friction = f"{turn.friction:.3f}" if turn.friction < 10.0 else "above 10"
            lines.append(
                f"  {name:28} lean {np.degrees(turn.lean):7.3f}°  steer {np.degrees(turn.steer):7.3f}°  speed "
                f"{turn.speed:8.5f} m/s  radius {turn.radius:9.4f} m  friction {friction}"
            )
    return "\n".join(lines) or "no hands-free circles on the sections that were searched"
