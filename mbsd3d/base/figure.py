"""Figures that show themselves: the class of all that the project draws."""

from io import BytesIO

import matplotlib.figure


class Figure(matplotlib.figure.Figure):
    """A figure that a notebook shows as the value of a cell, whether pyplot has been imported or not."""

    def _repr_png_(self) -> bytes:
        """Return the picture as a notebook asks for it; IPython knows those of plain figures by pyplot alone."""
        out = BytesIO()
        self.savefig(out, format="png", bbox_inches="tight")
        return out.getvalue()
