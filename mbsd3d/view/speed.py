"""How fast a run is shown: in real time where one can follow it."""

import numpy as np

SHORT, LONG, SENSIBLE = 2.0, 30.0, 10.0  # s of a run shown in real time; s any other one takes


def sensible_speed(seconds: float, longest: float = LONG, sensible: float = SENSIBLE) -> float:
    """Real time for a run of 2 s ... ``longest``, else a round factor that makes it about ``sensible`` seconds."""
    if seconds <= 0.0 or SHORT <= seconds <= longest:
        return 1.0
    exact = seconds / sensible
    decade = 10.0 ** np.floor(np.log10(exact))
    nearest = min((1.0, 2.0, 5.0, 10.0), key=lambda factor: abs(np.log(factor * decade / exact)))
    return float(f"{nearest * decade:.1g}")
