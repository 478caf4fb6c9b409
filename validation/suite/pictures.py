"""Pictures of mechanisms for the page, small enough that a hundred of them make a page that loads."""

import base64
import io
from typing import Any

from mbsd3d.extend import house

from .trial import Run

SIZE, DOTS = (3.6, 2.7), 110  # inch, per inch
MOST = 40
"""Bodies that can be told apart at this size."""


def picture(made: Run) -> str:
    """The mechanism at the end of its run as a data address; "" for more bodies than one can tell apart."""
    if len(made.system.bodies) > MOST:
        return ""
    figure = drawn(made)
    buffer = io.BytesIO()
    with house():
        figure.savefig(buffer, format="webp", dpi=DOTS, pil_kwargs={"quality": 70})
    return f"data:image/webp;base64,{base64.b64encode(buffer.getvalue()).decode()}"


def drawn(made: Run) -> Any:
    """A figure of the last sample, of the reference pose without one."""
    if made.solution is None:
        return made.system.picture(size=SIZE)
    last = made.solution.state(made.solution.t.size - 1)
    return made.system.picture(last, size=SIZE)
