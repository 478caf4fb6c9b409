"""The characteristic polynomial of a bicycle: from its equations in closed form, or from the general model."""

import numpy as np

from . import critical
from .equations import canonical
from .general import Build, linear_equations
from .models import whipple
from .parameters import Parameters

NO_INERTIA = 1e-13
"""Of the steer, relative to all mass at the wheelbase: rounding leaves 1e-16, a point mass 1 mm off the axis 1e-7."""


def of(parameters: Parameters) -> critical.Quartic:
    """The characteristic polynomial of a bicycle with knife-edge wheels, in closed form.

    Parameters
    ----------
    parameters : Parameters
        Or any object with its symbols; arrays and complex steps are taken too.

    Raises
    ------
    ValueError
        For round tyres, or where no mass resists lean or steer: then there are fewer than two freedoms.
    """
    found = canonical(parameters)
    q = critical.quartic(found.M, found.C1, np.asarray(found.g)[..., None, None] * found.K0, found.K2)
    masses = parameters.mR + parameters.mB + parameters.mH + parameters.mF
    if not np.all(np.real(q.a) > NO_INERTIA * np.real(found.M[..., 0, 0] * masses * parameters.w**2)):
        raise ValueError(
            f"bicycle '{getattr(parameters, 'name', '')}': lean or steer has no inertia, so that it is no freedom of "
            "motion; give masses off the ground and off the steer axis"
        )
    return q


def of_model(parameters: Parameters, build: Build = whipple, *, check: bool = True) -> critical.Quartic:
    """The same from the general model, see `bicycle.general.linear_equations`.

    Parameters
    ----------
    parameters : Parameters
        Round tyres too.
    build : callable
        ``build(parameters, speed=v)`` returns the bicycle.
    check : bool
        Whether a linearisation at a third speed must confirm the two from which the equations follow.

    Raises
    ------
    ValueError
        If it does not.
    """
    linear = linear_equations(build, parameters, check=check)
    if linear is None:
        raise ValueError(
            f"bicycle '{parameters.name}': a force depends on speed otherwise than through the motion, so critical "
            "speeds are no roots of a polynomial; look at stability.eigenvalues speed by speed"
        )
    return critical.quartic(linear.M, linear.C1, linear.K0, linear.K2)
