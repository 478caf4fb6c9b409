"""Samples of a run, taken from the buffer of the time loop: one array per quantity, and no second copy of them."""

import numpy as np

BUFFER = 2**21  # numbers (16 MB) the buffer of the time loop may hold
FEWEST = 16  # samples it holds at least

QUANTITIES = ("t", "y", "acceleration", "lam", "coordinate", "potential", "power", "residual")


def buffer_size(wanted: int, width: int) -> int:
    """Samples the buffer holds: those wanted, if there is room."""
    return min(wanted, max(FEWEST, BUFFER // width))


class Samples:
    """Arrays (samples, width) of the quantities of a run, by name.

    Parameters
    ----------
    widths : tuple of int
        Numbers per sample of each of QUANTITIES.
    expected : int
        Samples to make room for; more of them make the arrays grow.
    """

    def __init__(self, widths: tuple[int, ...], expected: int) -> None:
        self.count = 0
        self.arrays = {name: np.empty((expected, width)) for name, width in zip(QUANTITIES, widths, strict=True)}

    def take(self, rows: np.ndarray) -> None:
        """Copy samples (k, sum of widths)."""
        column, count = 0, self.count + rows.shape[0]
        for array in self.arrays.values():
            room, width = array.shape
            if room < count:
                array.resize((max(count, room + room // 4), width), refcheck=False)  # in place where it can
            array[self.count : count] = rows[:, column : column + width]
            column += width
        self.count = count

    def finished(self) -> dict[str, np.ndarray]:
        """The arrays without spare room; no samples can be taken after this."""
        for array in self.arrays.values():
            array.resize((self.count, array.shape[1]), refcheck=False)
        return dict(self.arrays)
