"""The characteristic polynomial of a bicycle: from its equations in closed form, or from the general model."""

from collections.abc import Callable

import numpy as np

from mbsd3d import System, linearize

from . import critical
from .equations import canonical
from .models import outputs, whipple
from .parameters import Parameters

OTHERWISE = 1e-9
"""Relative residual at which equations are not those of a bicycle: a thousand times what rounding leaves."""


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


def of_model(parameters: Parameters, build: Callable[..., System] = whipple) -> critical.Quartic:
    """The same from the general model: its linear equations at two speeds hold M^-1 C1, M^-1 g K0 and M^-1 K2.

    Parameters
    ----------
    parameters : Parameters
        Round tyres too.
    build : callable
        ``build(parameters, speed)`` returns the system, with the parts that `bicycle.models.outputs` reads.

    Raises
    ------
    ValueError
        If the equations do not depend on speed as above.
    """
    slow, fast = np.array([0.5, 2.0]) * (np.sqrt(parameters.g * parameters.w) or 1.0)
    (N, P), (N_fast, P_fast) = (split(build(parameters, v)) for v in (slow, fast))
    C1, K2 = P_fast / fast, (N_fast - N) / (fast**2 - slow**2)
    K0 = N - slow**2 * K2
    left = np.abs(P - slow * C1).max() / np.abs(P).max(), np.abs(K2[:, 0]).max() * slow**2 / np.abs(N).max()
    if max(left) > OTHERWISE:
        raise ValueError(
            f"bicycle '{parameters.name}': its damping does not grow with speed and its stiffness with the square "
            f"(residual {max(left):.2g}), so its critical speeds are no roots; look at the eigenvalues speed by speed"
        )
    return critical.quartic(np.eye(2), C1, K0, K2 * [0.0, 1.0])


def split(system: System) -> tuple[np.ndarray, np.ndarray]:
    """(2, 2) N and P of ``q'' + P q' + N q = 0`` from the general model."""
    A = linearize(system, outputs=outputs(system)).A
    return -A[2:, :2], -A[2:, 2:]
