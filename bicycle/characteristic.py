"""The characteristic polynomial of a bicycle: from its equations in closed form, or from the general model."""

import numpy as np

from . import critical
from .equations import canonical
from .general import Build, linear_equations
from .models import whipple
from .parameters import Parameters


def of(parameters: Parameters) -> critical.Quartic:
    """The characteristic polynomial of a bicycle with knife-edge wheels, in closed form.

    Parameters
    ----------
    parameters : Parameters
        Or any object with its symbols; arrays and complex steps are taken too.

    Raises
    ------
    ValueError
        For round tyres, or where no mass resists a motion: then there are fewer than two freedoms.
    """
    found = canonical(parameters)
    q = critical.quartic(found.M, found.C1, np.asarray(found.g)[..., None, None] * found.K0, found.K2)
    if not np.all(np.real(q.a) > 0.0):
        raise ValueError(
            f"bicycle '{getattr(parameters, 'name', '')}': the mass matrix of lean and steer is not positive; "
            "give masses or inertias such that lean and steer both have inertia"
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
