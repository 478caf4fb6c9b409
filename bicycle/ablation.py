"""One variant of a bicycle: its self-stable ranges in closed form, and whether the general model confirms them."""

from dataclasses import dataclass, replace

import numpy as np

from mbsd3d import AngleDriver, Constant, System, linearize
from mbsd3d.mechanism import measures

from . import characteristic, critical
from .critical import Range
from .equations import canonical
from .general import Build, linearization
from .parameters import Parameters

STEP = 1e-6
"""[m/s] on both sides of an end, where the fastest growth must have opposite signs; and [1/s] of growths alike."""


@dataclass(frozen=True)
class Ablation:
    """A bicycle with something changed.

    Attributes
    ----------
    name : str
        What is changed.
    parameters : Parameters
        With the change.
    ranges : list of Range
        Self-stable speeds [m/s] in closed form; of the general model for round tyres.
    growth : float
        Fastest growth [1/s] at the speed of `Ablations`, negative where all motions decay.
    model : list of Range or None
        The ranges of the general model; None if it was not asked.
    confirmed : bool or None
        Whether its spectrum has the same fastest growth, and changes sides at every end; see `in_spectrum`.
    problem : str
        Why this variant cannot be had; then there are no ranges and no growth.
    """

    name: str
    parameters: Parameters
    ranges: list[Range]
    growth: float
    model: list[Range] | None = None
    confirmed: bool | None = None
    problem: str = ""

    @property
    def difference(self) -> float:
        """Largest difference between the ends of both [m/s]; infinite where they do not match, NaN without a model."""
        return float("nan") if self.model is None else critical.difference(self.ranges, self.model)


def round_tyres(parameters: Parameters) -> bool:
    """Which the closed form does not know."""
    return bool(parameters.tR or parameters.tF)


def quartic_of(parameters: Parameters, build: Build | None) -> critical.Quartic:
    """In closed form; of the general model for round tyres."""
    if build is not None and round_tyres(parameters):
        return characteristic.of_model(parameters, build)
    return characteristic.of(parameters)


def ablated(name: str, parameters: Parameters, build: Build | None, speed: float) -> Ablation:
    """Ranges of a bicycle, confirmed by a model."""
    q = quartic_of(parameters, build)
    found = Ablation(name, parameters, critical.ranges(q), fastest(q, speed))
    if build is None:
        return found
    model = critical.ranges(characteristic.of_model(parameters, build))
    return replace(found, model=model, confirmed=len(model) == len(found.ranges) and in_spectrum(found, build, speed))


def in_spectrum(found: Ablation, build: Build, speed: float) -> bool:
    """Whether the spectrum of the model has the same fastest growth, and changes sides at every end of a range."""

    def growth(v: float) -> float:
        A = linearization(build, found.parameters, v).A  # its own spectrum takes what is close to zero for zero
        return float(np.linalg.eigvals(A).real.max())

    ends = [v for part in found.ranges for v in part if 0.0 < v < np.inf]
    alike = abs(growth(speed) - found.growth) < STEP * max(1.0, abs(found.growth))
    return alike and all(growth(v - STEP) * growth(v + STEP) < 0.0 for v in ends)


def fastest(q: critical.Quartic, v: float) -> float:
    """Largest real part [1/s] of the roots at a speed."""
    c, d, e = (critical.value(x, v * v) for x in (q.c, q.d, q.e))
    return float(np.roots([q.a, q.b * v, c, d * v, e]).real.max())


def locked(parameters: Parameters, build: Build | None, speed: float) -> Ablation:
    """Only lean is left: a pendulum upside down, which falls at any speed with +-sqrt(-g K0_11 / M_11)."""
    name, falls = "steering locked", []
    if build is None or not round_tyres(parameters):
        linear = canonical(parameters)
        falls.append(float(np.sqrt(-linear.g * linear.K0[0, 0] / linear.M[0, 0])))
    if build is not None:
        falls.append(falling(build(parameters, speed=speed)))
    if len(falls) == 1:
        return Ablation(name, parameters, [], falls[0], model=None if build is None else [])
    return Ablation(name, parameters, [], falls[0], [], abs(falls[1] - falls[0]) < STEP * falls[0])


def falling(bicycle: System) -> float:
    """Growth [1/s] of the lean of a bicycle whose steering is held."""
    frame, steer = bicycle.part("frame"), bicycle.part("steer", "joints")
    held = replace(bicycle, joints=[*bicycle.joints, AngleDriver(steer, Constant(0.0), name="lock")])
    return float(linearize(held, outputs=[measures.lean(frame), measures.lean_rate(frame)]).eigenvalues.real.max())
