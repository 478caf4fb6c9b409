"""The linear equations of a bicycle from the general model, for all speeds from two of them.

Velocities stand in the equations of motion only in the quadratic terms of the accelerations, and all velocities of a
straight run are proportional to the speed v. So the derivative of the accelerations by velocities is linear in v, that
by displacements 1 and v^2, exactly:

    q'' = - v C1 q' - (K0 + v^2 K2) q,      q = (lean, steer)

Two linearisations, at rest and at one speed, hold everything. A third at another speed confirms it; for a model with
other forces that depend on speed (air drag, tyres) it does not, and every speed is linearised by itself.
"""

from collections.abc import Callable

import numpy as np

from mbsd3d import Linearization, System, linearize
from mbsd3d.base.checks import number

from .equations import Canonical, checked_speeds
from .models import outputs
from .parameters import Parameters
from .straight import output_matrices

Build = Callable[..., System]
"""``build(parameters, speed=v)`` returns a bicycle with a body "frame" and a hinge "steer" that runs straight."""
EXACT = 1e-9
"""How well a third speed confirms two, relative to the largest entry: rounding leaves 1e-12, any drag far more."""


def linearization(build: Build, parameters: Parameters, speed: float) -> Linearization:
    """`mbsd3d.linearize` of the straight run at a speed [m/s], with lean, steer and their rates as outputs."""
    system = build(parameters, speed=float(speed))
    return linearize(system, outputs=outputs(system))


def linear_equations(
    build: Build, parameters: Parameters, speed: float = 5.0, *, check: bool = True
) -> Canonical | None:
    """The linear equations of a model as those of the paper, divided by M; None if they are not of that form.

    Parameters
    ----------
    build : callable
        ``build(parameters, speed=v)`` returns the bicycle, e.g. `bicycle.whipple`.
    parameters : Parameters
    speed : float
        At which the second linearisation is made [m/s], not zero: best the largest of interest.
    check : bool
        Whether `linearize` at 0.6 times the speed must agree; leave it out in maps of a model that it holds for.

    Returns
    -------
    Canonical or None
        M is the unit matrix, g = 1; ``A``, ``eigenvalues`` as of the closed form.

    Raises
    ------
    ValueError
        If the speed is zero.
    """
    if number(speed, "linear equations: speed") == 0.0:
        raise ValueError("linear equations: speed = 0; what depends on speed needs one, e.g. 5 m/s")
    rest, running = matrices(build, parameters, speed)
    if np.abs(rest[2:, 2:]).max() > EXACT * np.abs(running).max():  # damping at rest
        return None
    found = Canonical(
        M=np.eye(2),
        C1=-(running - rest)[2:, 2:] / speed,
        K0=-rest[2:, :2],
        K2=-(running - rest)[2:, :2] / speed**2,
        g=1.0,
    )
    if check:
        between = linearization(build, parameters, 0.6 * speed).A
        if np.abs(between - found.A(0.6 * speed)).max() > EXACT * np.abs(running).max():
            return None
    return found


def matrices(build: Build, parameters: Parameters, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """A at rest and at a speed: from four deviations where these are known, else by `linearize`."""
    known = output_matrices(build(parameters, speed=float(speed)), parameters, float(speed))
    return known or tuple(linearization(build, parameters, v).A for v in (0.0, speed))


def eigenvalues(build: Build, parameters: Parameters, speeds: np.ndarray) -> np.ndarray:
    """Eigenvalues of the lean and steer motion of the general model about straight runs.

    Parameters
    ----------
    build : callable
        ``build(parameters, speed=v)`` returns the bicycle, e.g. `bicycle.whipple`.
    parameters : Parameters
    speeds : (n,) array_like
        [m/s]

    Returns
    -------
    (n, 4) complex ndarray
        [1/s], each row by real part, conjugates together.

    Examples
    --------
    >>> from bicycle import Meijaard2007, whipple
    >>> eigenvalues(whipple, Meijaard2007(), [0.0]).real.round(6)
    array([[-5.530944, -3.131643,  3.131643,  5.530944]])
    """
    speeds = checked_speeds(speeds)
    fastest = float(speeds[np.argmax(np.abs(speeds))]) or 1.0
    if speeds.size > 3:
        found = linear_equations(build, parameters, fastest)
        if found is not None:
            return found.eigenvalues(speeds)
    return np.array([np.sort_complex(linearization(build, parameters, v).eigenvalues) for v in speeds])
