"""Prescribed motions without a callback: a clock and oscillators so heavy that nothing they drive is felt by them.

MuJoCo knows no function of time inside a step, but its Runge-Kutta stages carry everything that moves. A rotor that
turns by itself at 1 rad/s is a clock, one on a spring swings as a sine; an equality ties a joint to them. Their inertia
is `HEAVY` times that of the mechanism, and so the error is 1 / `HEAVY`.
"""

from typing import Any, NamedTuple

import numpy as np

from mbsd3d import Signal
from mbsd3d.extend import POLYNOMIAL, SINE

from ..base import NotExpressible

HEAVY = 1e12  # times mass and inertia of all bodies
HIGHEST = 4  # degree of the polynomials of MuJoCo's equalities


class Generator(NamedTuple):
    """An oscillator x = amplitude sin(omega t + phase); the clock x = t has omega 0."""

    name: str
    amplitude: float
    omega: float
    phase: float

    def start(self, t: float) -> tuple[float, float]:
        """x and its rate."""
        if not self.omega:
            return t, 1.0
        angle = self.omega * t + self.phase
        return self.amplitude * np.sin(angle), self.amplitude * self.omega * np.cos(angle)


class Motors:
    """The generators of a model."""

    def __init__(self, mujoco: Any, spec: Any, bodies: tuple) -> None:
        self.mujoco, self.spec = mujoco, spec
        self.inertia = HEAVY * max(1.0, sum(body.mass + np.trace(body.inertia) for body in bodies))
        self.generators: list[Generator] = []

    def clock(self) -> str:
        """The tendon whose length is the time."""
        if not any(not generator.omega for generator in self.generators):
            self.add(0.0, 0.0, 0.0)
            tendon = self.spec.add_tendon(name="clock")
            tendon.wrap_joint(self.generators[-1].name, 1.0)
        return "clock"

    def add(self, amplitude: float, omega: float, phase: float) -> str:
        """The joint of a new generator; it turns about its centre of mass, so that gravity does not move it."""
        name = f"generator {len(self.generators)}"
        body = self.spec.worldbody.add_body(name=name, mass=self.inertia, inertia=np.full(3, self.inertia))
        body.explicitinertial = True
        joint = body.add_joint(name=name, type=self.mujoco.mjtJoint.mjJNT_HINGE, axis=(0, 0, 1))
        joint.stiffness[0] = self.inertia * omega**2
        self.generators.append(Generator(name, amplitude, omega, phase))
        return name

    def generate(self, signal: Signal, integrated: bool, shown: str) -> tuple[dict[str, float], tuple[float, ...]]:
        """Generators of the sines with their factors, and ascending coefficients of the rest.

        ``integrated`` gives the integral of the signal: that of a sine is a sine, a quarter turn later.
        """
        sines, polynomial = {}, np.zeros(1)
        for term in signal.terms():
            if term.kind == SINE and term.data[1]:
                amplitude, omega, phase = term.data
                if integrated:
                    amplitude, phase = amplitude / omega, phase - np.pi / 2
                sines[self.add(amplitude, omega, phase)] = 1.0
            elif term.kind == SINE:
                polynomial = added(polynomial, np.array([term.data[0] * np.sin(term.data[2])]), integrated)
            elif term.kind == POLYNOMIAL:
                polynomial = added(polynomial, term.data, integrated)
            else:
                raise NotExpressible(
                    f"{shown}: its signal is a Table or a Pulse; MuJoCo moves only by sines and polynomials"
                )
        if polynomial.size > HIGHEST + 1:
            raise NotExpressible(
                f"{shown}: its signal is a polynomial of degree {polynomial.size - 1}; MuJoCo's equalities have "
                f"{HIGHEST} at most"
            )
        return sines, tuple(polynomial)


def added(first: np.ndarray, second: np.ndarray, integrated: bool) -> np.ndarray:
    """Sum of polynomials, the second one perhaps integrated; no leading zeros."""
    return np.polynomial.polynomial.polyadd(first, np.polynomial.polynomial.polyint(second) if integrated else second)
