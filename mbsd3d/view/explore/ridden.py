"""What a page needs so that its reader moves a mechanism himself, in the time of the clock: by hand at its forces."""

from typing import Any, NamedTuple

from ...base.errors import InputError
from ...constraints.assembly import reference_state
from ...kernels import kinds
from ...mechanism.mechanism import Mechanism
from .lowered import lowered, method


class Ride(NamedTuple):
    """Mechanism whose forces the reader gives, from -1 to 1 times what they are; it has the bodies of the film."""

    system: Mechanism
    hint: str  # what the arrow keys do
    upright: str  # body that has fallen where its y axis is steep


def ride_data(ride: Ride, film: Mechanism, origin: Any) -> dict[str, Any]:
    """Return tables, the signals that the reader gives, and what the page says; ``origin``: about which it is drawn.

    Raises
    ------
    ValueError
        If the bodies are not those of the film, or the solver of a page cannot solve the mechanism.
    """
    names, known = ([body.name for body in one.bodies] for one in (ride.system, film))
    if names != known:
        raise InputError(f"ride: its bodies {names} are not those of the film, {known}; build both alike")
    tables = lowered(ride.system, reference_state(ride.system, None))
    if any(term["kind"] != kinds.POLYNOMIAL for signal in tables["signal"] for term in signal):
        raise InputError("ride: a force changes with the time; give constant ones, which the reader multiplies")
    given = {i for force in tables["force"] for i in force["signal"] if i >= 0}
    return {
        "tables": tables,
        "method": method(),
        "given": sorted(given),
        "hint": ride.hint,
        "upright": names.index(ride.upright),
        "origin": [float(x) for x in origin],
    }
