"""Curves of a tyre: force and trail over the deflection, stiffness and grip over the load."""

from ...compiler.decorators import inner_kernel

LOAD_FACTOR_MIN = 0.1
"""Share of grip and stiffness that no load takes away."""
FULL_SLIDING_DEFLECTION = 1.5
"""Deflection, in units of that of full grip, from which all of the contact patch slides."""


@inner_kernel
def at_least(x, least):
    """Return x, but no less than a number."""
    return x if x.real > least else least + 0.0 * x


@inner_kernel
def sensitive(k, load):
    """Share 1 - k (N/N0 - 1) of a coefficient that is left at a load, given as N/N0."""
    return at_least(1.0 - k * (load - 1.0), LOAD_FACTOR_MIN)


@inner_kernel
def brush(q):
    """Return (force over that of the linear tyre, trail over that at rest) at a linear force of q times the grip.

    With the theoretical slip s = q/(1 - q/3) the force is mu N (1 - (1 - s/3)^3): the steady deflection under s is q.
    """
    force, trail = 1.0 + 0.0 * q, 1.0 + 0.0 * q
    if q.real < FULL_SLIDING_DEFLECTION:
        s = q / (1.0 - q / 3.0)
        rest, adhesion = 1.0 - s / 3.0, 1.0 - s / 3.0 + s * s / 27.0
        force, trail = adhesion / (1.0 - q / 3.0), rest * rest * rest / adhesion
    else:
        force, trail = 1.0 / q, 0.0 * q
    return force, trail
