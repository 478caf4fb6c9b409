"""Shell of a car as a table of modes, measured or computed elsewhere: a file of comma-separated values.

    mode,frequency,damping,place,x,y,z

One line for every mode and place: ``mode``, a name or number; its ``frequency`` [Hz], 0 for a motion as a rigid body;
``damping``, share of critical; ``place``: the name of a mount, or "seat"; ``x, y, z``: the shape there for a modal mass
of 1 kg [1/sqrt(kg)], x ahead, y left, z up.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from engines.nvh.cabin.shell import Modes
from engines.nvh.records import cell, table
from mbsd3d.errors import InputError
from mbsd3d.extend import number, write_atomically

HEADER = ["mode", "frequency", "damping", "place", "x", "y", "z"]
SEAT_NAME = "seat"


class ModalTable(Modes):
    """Modes whose shapes are known at named places: name -> (3,)."""

    def at(self, places: Sequence[str]) -> np.ndarray:
        """Return the shapes at places, shape (r, 3 p); raise ValueError for a place that the table does not have."""
        for place in places:
            if place not in self.shapes[0]:
                raise InputError(
                    f"shell: the table has no place '{place}'; it has {', '.join(self.shapes[0])}; add its lines"
                )
        return np.array([np.concatenate([shape[place] for place in places]) for shape in self.shapes])


def read_modes(path: str | Path) -> ModalTable:
    """Read the modes of a file.

    ValueError for a file that cannot be read, another header, a cell that is not a number, a mode with two frequencies
    or dampings, or one that lacks a place, with its line or mode.
    """
    path = Path(path)
    _, lines = table(path, [HEADER], "shell")
    found: dict[str, tuple[tuple[float, float], dict[str, np.ndarray]]] = {}
    for what, row in lines:
        mode, place = row[0], row[3]
        frequency, damping, *shape = (cell(row[i], f"{what}: {HEADER[i]}") for i in (1, 2, 4, 5, 6))
        number(frequency, f"{what}: frequency", minimum=0.0)
        number(damping, f"{what}: damping", minimum=0.0)
        own, shapes = found.setdefault(mode, ((frequency, damping), {}))
        if own != (frequency, damping) or place in shapes:
            raise InputError(f"{what}: mode '{mode}' is given twice at '{place}' or with another frequency or damping")
        shapes[place] = np.array(shape)
    if not found:
        raise InputError(f"shell '{path.name}': no modes; give a line for every mode and place")
    known = next(iter(found.values()))[1]
    for mode, (_, shapes) in found.items():
        if missing := set(known) ^ set(shapes):
            raise InputError(f"shell '{path.name}': mode '{mode}' and the first differ in {', '.join(sorted(missing))}")
    values = np.array([own for own, _ in found.values()])
    return ModalTable(2 * np.pi * values[:, 0], values[:, 1], [shapes for _, shapes in found.values()])


def write_modes(modes: Modes, shapes: np.ndarray, places: Sequence[str], path: str | Path) -> Path:
    """Write modes with their ``shapes`` (r, 3 p) at ``places`` as such a file, and return its path."""
    lines = [",".join(HEADER)]
    for k, (rate, damping, shape) in enumerate(zip(modes.rates, modes.damping, shapes, strict=True), start=1):
        for place, values in zip(places, shape.reshape(-1, 3), strict=True):
            numbers = ",".join(f"{x + 0.0:.9g}" for x in values)
            lines.append(f"{k},{rate / (2 * np.pi):.9g},{damping:.9g},{place},{numbers}")
    return write_atomically(Path(path), ("\n".join(lines) + "\n").encode())
