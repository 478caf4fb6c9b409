"""Angles and displacements as sums of MuJoCo's joint coordinates: fixed tendons with springs and equalities.

MuJoCo knows no function of time inside a step, but its Runge-Kutta stages carry everything that moves. A rotor that
turns by itself at 1 rad/s is a clock, one on a spring swings as a sine; an equality ties a joint to them. Their inertia
is `GENERATOR_INERTIA_RATIO` times that of the mechanism, and so the error is 1 / `GENERATOR_INERTIA_RATIO`.
"""

from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from mbsd3d import ConstantVelocity, Coupler, Engaged, GearMesh, Joint, PositionDriver, Screw, Signal, SpeedDriver
from mbsd3d.extend import Coordinate, NotExportable, along_the_teeth, kinds, weighted_sum
from validation.twins.base import NotExpressible, label, speed_of
from validation.twins.mujoco.build import Sketch

GENERATOR_INERTIA_RATIO = 1e12  # [1] of mass and inertia of all bodies, so that they do not move a generator
POLYNOMIAL_DEGREE_MAX = 4  # [1] degree of the polynomials of MuJoCo's equalities


class Generator(NamedTuple):
    """Oscillator x = amplitude sin(omega t + phase); the clock x = t has omega 0."""

    name: str
    amplitude: float
    omega: float
    phase: float

    def start(self, t: float) -> tuple[float, float]:
        """Return x and its rate at time t."""
        if not self.omega:
            return t, 1.0
        angle = self.omega * t + self.phase
        return self.amplitude * np.sin(angle), self.amplitude * self.omega * np.cos(angle)


class Motors:
    """Generators of a model."""

    def __init__(self, mujoco: Any, spec: Any, bodies: tuple) -> None:
        self.mujoco, self.spec = mujoco, spec
        self.inertia = GENERATOR_INERTIA_RATIO * max(1.0, sum(body.mass + np.trace(body.inertia) for body in bodies))
        self.generators: list[Generator] = []

    def clock(self) -> str:
        """Return the tendon whose length is the time."""
        if not any(not generator.omega for generator in self.generators):
            self.add(0.0, 0.0, 0.0)
            tendon = self.spec.add_tendon(name="clock")
            tendon.wrap_joint(self.generators[-1].name, 1.0)
        return "clock"

    def add(self, amplitude: float, omega: float, phase: float) -> str:
        """Add the joint of a new generator; it turns about its centre of mass, so that gravity does not move it."""
        name = f"generator {len(self.generators)}"
        body = self.spec.worldbody.add_body(name=name, mass=self.inertia, inertia=np.full(3, self.inertia))
        body.explicitinertial = True
        joint = body.add_joint(name=name, type=self.mujoco.mjtJoint.mjJNT_HINGE, axis=(0, 0, 1))
        joint.stiffness[0] = self.inertia * omega**2
        self.generators.append(Generator(name, amplitude, omega, phase))
        return name

    def generate(self, signal: Signal, integrated: bool, shown: str) -> tuple[dict[str, float], tuple[float, ...]]:
        """Return generators of the sines with their factors, and ascending coefficients of the rest.

        ``integrated`` gives the integral of the signal; a sine becomes a sine a quarter turn later.
        """
        sines, polynomial = {}, np.zeros(1)
        for term in signal.terms():
            if term.kind == kinds.SINE and term.data[1]:
                amplitude, omega, phase = term.data
                if integrated:
                    amplitude, phase = amplitude / omega, phase - np.pi / 2
                sines[self.add(amplitude, omega, phase)] = 1.0
            elif term.kind == kinds.SINE:
                polynomial = added(polynomial, np.array([term.data[0] * np.sin(term.data[2])]), integrated)
            elif term.kind == kinds.POLYNOMIAL:
                polynomial = added(polynomial, term.data, integrated)
            else:
                raise NotExpressible(
                    f"{shown}: its signal is a Table or a Pulse; MuJoCo moves only by sines and polynomials"
                )
        if polynomial.size > POLYNOMIAL_DEGREE_MAX + 1:
            raise NotExpressible(
                f"{shown}: its signal is a polynomial of degree {polynomial.size - 1}; MuJoCo's equalities have "
                f"{POLYNOMIAL_DEGREE_MAX} at most"
            )
        return sines, tuple(polynomial)


def added(first: np.ndarray, second: np.ndarray, integrated: bool) -> np.ndarray:
    """Sum two polynomials, the second one perhaps integrated; no leading zeros."""
    return np.polynomial.polynomial.polyadd(first, np.polynomial.polynomial.polyint(second) if integrated else second)


@dataclass(eq=False)
class Coupling:
    """Row on joint coordinates: a tendon of length sum(coefficient coordinate), held at a polynomial of time.

    A coupler is held at a polynomial of another tendon, its leader.
    """

    part: Any
    tendon: str
    equality: str
    terms: dict[str, float]
    coordinates: list[tuple[Coordinate, float]] = field(default_factory=list)
    adrift: bool = False  # only its speed is given: where it is at the start is where it begins
    leader: "Coupling | None" = None
    coefficients: tuple[float, ...] = ()

    def parts(self, data: Any, model: Any) -> list[tuple["Coupling", float]]:
        """Return the sums of the row with their slopes: its own 1, the leader's less that of the polynomial."""
        if self.leader is None:
            return [(self, 1.0)]
        x = float(data.ten_length[model.tendon(self.leader.tendon).id])
        slope = np.polynomial.polynomial.polyval(x, np.polynomial.polynomial.polyder(self.coefficients))
        return [(self, 1.0), (self.leader, -float(slope))]


def couple(made: Sketch, motors: Motors) -> list[Coupling]:
    """Add rows on coordinates: gears, racks, screws, drivers; the third rotation of constant-velocity joints."""
    found = []
    for joint in made.system.joints:
        for row in joint.rows():
            if row.kind in (kinds.RATIO, kinds.MESH):
                pairs = list(zip(row.coordinates, row.values, strict=False))
                pairs += along_the_teeth(joint) if isinstance(joint, GearMesh) else []
                found.append(hold(made, motors, joint, pairs, row.signal))
            elif isinstance(joint, Coupler):
                found.append(follow(made, joint, joint, 0.0))
            elif isinstance(joint, Engaged) and isinstance(joint.joint, Coupler):
                found.append(follow(made, joint, joint.joint, joint.offset))
            elif isinstance(joint, SpeedDriver):
                x = speed_of(joint, label(made.system, joint), "MuJoCo")
                found.append(hold(made, motors, joint, [(x, 1.0)], row.signal, adrift=True))
    for piece in made.layout.pieces:
        if isinstance(piece.joint, ConstantVelocity):
            terms = {piece.named("turn", 0): 1.0, piece.named("turn", 2): 1.0}
            found.append(hold_tendon(made, motors, piece.joint, made.system.name(piece.joint), terms, None))
        elif isinstance(piece.joint, PositionDriver):
            for k, signal in enumerate(piece.joint.signal):
                if signal is not None:
                    name, terms = f"{made.system.name(piece.joint)} {'xyz'[k]}", {piece.named("slide", k): 1.0}
                    found.append(hold_tendon(made, motors, piece.joint, name, terms, signal))
    return found


def hold(
    made: Sketch, motors: Motors, joint: Joint, pairs: list[tuple[Coordinate, float]], signal: Any, adrift: bool = False
) -> Coupling:
    """Set the sum of factor coordinate = signal, 0 without one; with ``adrift`` the signal is the rate of the sum."""
    terms = terms_of(made, pairs, label(made.system, joint))
    held = hold_tendon(made, motors, joint, made.system.name(joint), terms, signal, adrift)
    held.coordinates = pairs
    return held


def follow(made: Sketch, joint: Joint, own: Coupler, offset: float) -> Coupling:
    """Hold the sum of the followers of a coupler at the polynomial of the sum of its leaders, and an offset."""
    name, shown = made.system.name(joint), label(made.system, joint)
    if len(own.coefficients) > POLYNOMIAL_DEGREE_MAX + 1:
        raise NotExpressible(
            f"{shown}: its polynomial has the degree {len(own.coefficients) - 1}; MuJoCo's equalities have "
            f"{POLYNOMIAL_DEGREE_MAX} at most"
        )
    coefficients = (own.coefficients[0] + offset, *own.coefficients[1:])
    sums = [
        summed(made, joint, f"{side} {name}", own.sum_of(kind)) for side, kind in (("held", "y"), ("leads", "x"))
        if own.sum_of(kind)
    ]  # fmt: skip
    sums[0].coefficients, sums[0].leader = coefficients, sums[1] if len(sums) > 1 else None
    names = (sums[0].tendon, sums[1].tendon if len(sums) > 1 else "")
    sums[0].equality = made.equality("TENDON", joint, f"held {name}", names, "TENDON", (*coefficients, 0, 0, 0, 0)[:5])
    return sums[0]


def summed(made: Sketch, joint: Joint, name: str, pairs: list[tuple[Coordinate, float]]) -> Coupling:
    """Return a tendon whose length is the sum of factor coordinate."""
    terms = terms_of(made, pairs, label(made.system, joint))
    return Coupling(joint, add_tendon(made, name, terms), "", terms, pairs)


def hold_tendon(
    made: Sketch, motors: Motors, joint: Joint, name: str, terms: dict[str, float], signal: Any, adrift: bool = False
) -> Coupling:
    """Return the tendon of a sum, less the oscillations of the signal, held equal to the polynomial of time in it."""
    shown = label(made.system, joint)
    generators, polynomial = motors.generate(signal, adrift, shown) if signal is not None else ({}, ())
    tendon = add_tendon(made, f"held {name}", terms | {key: -factor for key, factor in generators.items()})
    clock = motors.clock() if len(polynomial) > 1 else ""
    data = (*polynomial, 0, 0, 0, 0, 0)[:5]
    equality = made.equality("TENDON", joint, f"held {name}", (tendon, clock), "TENDON", data)
    return Coupling(joint, tendon, equality, terms, adrift=adrift)


def add_tendon(made: Sketch, name: str, terms: dict[str, float]) -> str:
    """Add a fixed tendon; return its name."""
    tendon = made.spec.add_tendon(name=name)
    for joint, factor in terms.items():
        tendon.wrap_joint(joint, factor)
    return name


def terms_of(made: Sketch, pairs: list[tuple[Coordinate, float]], shown: str) -> dict[str, float]:
    """Return joint coordinates of MuJoCo and their factors, whose sum is that of factor coordinate."""
    try:
        return weighted_sum(made.tree, pairs, shown)
    except NotExportable as error:
        raise NotExpressible(str(error)) from None


def loads_of(joint: Joint) -> bool:
    """Return whether a coupling of this joint is part of its own reaction."""
    return isinstance(joint, Screw | ConstantVelocity | PositionDriver)
