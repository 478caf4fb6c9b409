"""Causes of the self-stability of a bicycle: variants with something removed or moved, and their stable speeds.

Ranges are roots of polynomials, see `bicycle.critical`: none is too narrow to be found. The general model confirms
them: its linear equations give the same ranges, and its fastest growth changes sign within 1e-6 m/s of every end.
On tyres see `bicycle.linear.why_on_tyres`.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.polynomial import Polynomial

from mbsd3d import System, linearize, measures
from mbsd3d.errors import InputError

from ..model.mechanism import whipple
from ..model.tyres import Tyres, both
from ..output import collected
from ..parameters import Parameters, check_set, named
from . import critical, why_on_tyres
from .critical import Quartic
from .equations import canonical
from .general import Build, linearization
from .variants import CHANGES, Ablation, Ablations, lock, plot_ablations, to_csv

__all__ = ["CHANGES", "Ablation", "Ablations", "ablations", "plot_ablations", "to_csv", "two_mass_skate"]

SPECTRUM_STEP = 1e-6
"""[m/s] on both sides of an end, where the fastest growth must have opposite signs; and [1/s] between equal growths."""


def two_mass_skate() -> Parameters:
    """Return two point masses on skates, with neither trail nor spin momentum; the tilt of 5 degrees to all digits."""
    return replace(named("Tms"), lam=np.pi / 36.0, name="two-mass skate")


def quartic_of(parameters: Parameters, build: Build | None) -> Quartic:
    """Return the characteristic quartic in closed form, or from the general model for round tyres."""
    if build is not None and (parameters.tR or parameters.tF):
        return critical.model_polynomial(parameters, build)
    return critical.polynomial(parameters)


def ablated(name: str, parameters: Parameters, build: Build | None, speed: float) -> Ablation:
    """Compute the ranges of a changed bicycle, confirmed by a model."""
    q = quartic_of(parameters, build)
    found = Ablation(name, parameters, critical.ranges(q), fastest(q, speed))
    if build is None:
        return found
    model = critical.ranges(critical.model_polynomial(parameters, build))
    return replace(found, model=model, confirmed=len(model) == len(found.ranges) and in_spectrum(found, build, speed))


def in_spectrum(found: Ablation, build: Build, speed: float) -> bool:
    """Return whether the spectrum of the model has the same fastest growth, which changes sign at every end of a
    range."""

    def growth(v: float) -> float:
        A = linearization(build, found.parameters, v).A  # its own spectrum rounds small values to zero
        return float(np.linalg.eigvals(A).real.max())

    ends = [v for part in found.ranges for v in part if 0.0 < v < np.inf]
    alike = abs(growth(speed) - found.growth) < SPECTRUM_STEP * max(1.0, abs(found.growth))
    return alike and all(growth(v - SPECTRUM_STEP) * growth(v + SPECTRUM_STEP) < 0.0 for v in ends)


def fastest(q: Quartic, v: float) -> float:
    """Return the largest real part [1/s] of the roots at a speed."""
    return float(Polynomial(q.at(v)).roots().real.max())


def locked(parameters: Parameters, build: Build | None, speed: float) -> Ablation:
    """Return the bicycle with lean only: a pendulum with +-sqrt(-g K0_11 / M_11) at any speed, which falls unless it
    hangs.
    """
    name, falls = "steering locked", []
    if build is None or not (parameters.tR or parameters.tF):
        linear = canonical(parameters)
        falls.append(float(np.sqrt(complex(-linear.g * linear.K0[0, 0] / linear.M[0, 0])).real))
    if build is not None:
        falls.append(falling(build(parameters, speed=speed)))
    confirmed = abs(falls[1] - falls[0]) < SPECTRUM_STEP * max(1.0, falls[0]) if len(falls) == 2 else None
    return Ablation(name, parameters, [], falls[0], None if build is None else [], confirmed)


def falling(bicycle: System) -> float:
    """Return the growth [1/s] of the lean of a bicycle whose steering is locked."""
    frame = bicycle.part("frame")
    seen = [measures.lean(frame), measures.lean_rate(frame)]
    return float(linearize(lock(bicycle), outputs=seen).eigenvalues.real.max())


def ablations(
    parameters: Parameters, build: Build | None = whipple, *, tyres: Tyres | None = None, progress: bool | None = None,
    **fittings: float,
) -> Ablations:  # fmt: skip
    """Compute self-stable ranges of a bicycle, of its variants (`CHANGES`), with locked steering, and of a two-mass
    skate.

    On tyres, of variants of the tyres instead of the skate, and beside those of ideal wheels.

    Parameters
    ----------
    build : callable or None
        The general model that must confirm them; None = closed form alone.
    tyres : mapping, pair of them or None
        As in `bicycle.whipple`; None = ideal wheels.
    **fittings : float
        Further arguments of `bicycle.whipple` for a bicycle on tyres, e.g. ``steer_damping``, ``head_stiffness``.
    progress : bool, optional
        Show a bar; None = on a terminal, after two seconds.

    Examples
    --------
    >>> from bicycle import Meijaard2007, why
    >>> found = why.ablations(Meijaard2007(), None)
    >>> print(*{row.name: row.ranges for row in found.rows}["no trail"])
    2.933073 ... 3.128986 m/s
    """
    check_set(parameters, "why")
    if tyres is not None:
        return why_on_tyres.ablations(parameters, both(tyres), fittings, progress)
    if fittings:
        raise InputError(f"why: {', '.join(fittings)} without tyres; give tyres, e.g. bicycle.TYPICAL")
    speed, count = critical.typical_speed(critical.ranges(quartic_of(parameters, build))), len(CHANGES) + 2
    rows = collected(f"variants of {parameters.name}", one_by_one(parameters, build, speed), count, progress)
    return Ablations(parameters, speed, rows, count - len(rows))


def one_by_one(parameters: Parameters, build: Build | None, speed: float) -> Iterator[Ablation]:
    """Yield the variants, the bicycle with locked steering, and a two-mass skate."""
    for name in CHANGES:
        yield changed(parameters, name, build, speed)
    yield locked(parameters, build, speed)
    yield ablated("two-mass skate: no trail, no spin", two_mass_skate(), build, speed)


def changed(parameters: Parameters, name: str, build: Build | None, speed: float) -> Ablation:
    """Return a variant, or why it is not possible for this bicycle."""
    try:
        variant = replace(parameters, **CHANGES[name](parameters), name=f"{parameters.name}, {name}")
        return ablated(name, variant, build, speed)
    except ValueError as error:
        return Ablation(name, parameters, [], float("nan"), problem=str(error))
