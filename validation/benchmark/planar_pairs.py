"""Planar mechanisms built twice, for the planar solver and in space, and how well "1 - 1 = 0" holds in both.

Points are (x, y, z): the plane drops z. In space the plane of motion is normal to z, and a chain of hinges closed
into a loop repeats three rows. Without redundancy one hinge of each loop is a ball and the next one a cross, which
leave the same motion. Sums that vanish, over the forces that cancel in them, in one driven turn:

    sum of the forces of the ground + m g - m a_G = 0        Newton for the whole mechanism
    1x force of an inline four on its block = 0              the throws cancel
    force across the bores of an inline four = 0             likewise, at all orders
    force and motion out of the plane = 0                    in space
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

import mbsd3d
from engines import planar
from mbsd3d import spectrum
from mbsd3d.extend import Ground

Z = (0.0, 0.0, 1.0)
HINGE, BALL, CROSS, GUIDE = "hinge", "ball", "cross", "guide"


@dataclass(frozen=True)
class Link:
    """Body of a planar mechanism: mass [kg], inertia about z and its centre of mass [kg m^2], O and that centre [m],
    both world.
    """

    name: str
    mass: float
    inertia: float
    origin: tuple
    centre: tuple


@dataclass(frozen=True)
class Coupling:
    """Joint of two links by name, None = the ground; ``kind`` is its form in space without redundant rows."""

    name: str
    kind: str
    a: str | None
    b: str
    at: tuple
    axis: tuple = (1.0, 0.0, 0.0)  # Of a guide; of a cross, across the link b in the plane


@dataclass(frozen=True)
class Mechanism:
    """Planar mechanism with one degree of freedom; the first link turns in the first coupling.

    ``rate``: speed of the first link at t = 0, or always if driven [rad/s]; ``gravity`` (2,): [m/s^2].
    """

    name: str
    links: tuple[Link, ...]
    couplings: tuple[Coupling, ...]
    rate: float
    gravity: tuple = (0.0, -9.81)

    @property
    def turn(self) -> float:
        """Return the time of a turn of the first link at its first speed [s]."""
        return 2 * np.pi / abs(self.rate)

    def plane(self, *, driven: bool = False, centroidal: bool = False) -> planar.System:
        """Build the mechanism for the planar solver; ``centroidal`` puts every O into the centre of mass (r_G = 0)."""
        bodies: dict[str | None, Any] = {None: planar.GROUND}
        for k, link in enumerate(self.links):
            origin = np.array(link.centre if centroidal else link.origin)[:2]
            com, omega = np.array(link.centre)[:2] - origin, None if k or driven else self.rate
            bodies[link.name] = planar.Body(link.name, link.mass, link.inertia, com=com, position=origin, omega=omega)
        joints = [planar_joint(c, bodies[c.a], bodies[c.b]) for c in self.couplings]
        drivers = [planar.AngleDriver(joints[0], planar.rate(self.rate), name="motor")] if driven else []
        return planar.System([bodies[link.name] for link in self.links], [*joints, *drivers], gravity=self.gravity)

    def space(self, *, redundant: bool = False, driven: bool = False, centroidal: bool = False) -> mbsd3d.System:
        """Build the mechanism for `mbsd3d`; ``redundant`` makes every rotating joint a hinge."""
        bodies: dict[str, mbsd3d.Body] = {}
        for k, link in enumerate(self.links):
            origin = np.array(link.centre if centroidal else link.origin)
            com, omega = np.array(link.centre) - origin, None if k or driven else (0.0, 0.0, self.rate)
            moments = link.inertia * np.array([0.4, 0.9, 1.0])
            bodies[link.name] = mbsd3d.Body(link.name, link.mass, moments, com=com, position=origin, omega=omega)
        joints = [
            spatial_joint(c, mbsd3d.GROUND if c.a is None else bodies[c.a], bodies[c.b], redundant)
            for c in self.couplings
        ]
        if driven:
            joints.append(mbsd3d.AngleDriver(joints[0], mbsd3d.Ramp(self.rate), name="motor"))
        gravity = (*self.gravity, 0.0)
        return mbsd3d.System(list(bodies.values()), joints, gravity=gravity)


def planar_joint(c: Coupling, a: planar.Body, b: planar.Body) -> planar.Slider | planar.Revolute:
    """Return the planar joint of a coupling."""
    if c.kind == GUIDE:
        return planar.Slider(a, b, at=c.at[:2], axis=c.axis[:2], name=c.name)
    return planar.Revolute(a, b, at=c.at[:2], name=c.name)


def spatial_joint(c: Coupling, a: mbsd3d.Body | Ground, b: mbsd3d.Body, redundant: bool) -> mbsd3d.Joint:
    """Return the spatial joint of a coupling."""
    if c.kind == GUIDE:
        return mbsd3d.Prismatic(a, b, at=c.at, axis=c.axis, name=c.name)
    if c.kind == HINGE or redundant:
        return mbsd3d.Revolute(a, b, at=c.at, axis=Z, name=c.name)
    if c.kind == BALL:
        return mbsd3d.Spherical(a, b, at=c.at, name=c.name)
    return mbsd3d.Universal(a, b, at=c.at, axis_a=Z, axis_b=c.axis, name=c.name)


def across(a: tuple, b: tuple) -> tuple:
    """Return the unit vector in the plane at right angles to the line from a to b."""
    x, y = b[0] - a[0], b[1] - a[1]
    return (-y / np.hypot(x, y), x / np.hypot(x, y), 0.0)


def slider_crank(angle: float = 0.4, radius: float = 0.31, rod_length: float = 0.83) -> Mechanism:
    """Return a slider-crank with the piston along x, every centre of mass off its O, weight across the bore."""
    pin = (radius * np.cos(angle), radius * np.sin(angle), 0.0)
    wrist = (pin[0] + np.sqrt(rod_length**2 - pin[1] ** 2), 0.0, 0.0)
    links = (
        Link("crank", 2.3, 0.05, (0, 0, 0), (0.39 * pin[0], 0.39 * pin[1], 0.0)),
        Link("rod", 1.7, 0.09, pin, (0.63 * pin[0] + 0.37 * wrist[0], 0.63 * pin[1], 0.0)),
        Link("piston", 0.9, 0.01, wrist, (wrist[0] + 0.05, 0.0, 0.0)),
    )
    couplings = (
        Coupling("bearing", HINGE, None, "crank", (0.0, 0.0, 0.0)),
        Coupling("crankpin", BALL, "crank", "rod", pin),
        Coupling("wristpin", CROSS, "piston", "rod", wrist, across(pin, wrist)),
        Coupling("bore", GUIDE, None, "piston", wrist),
    )
    return Mechanism("slider-crank", links, couplings, rate=17.0)


def four_bar() -> Mechanism:
    """Return a crank-rocker whose crank passes the top."""
    A, B, C, D = (0.0, 0.0, 0.0), (0.21, 0.17, 0.0), (0.95, 0.71, 0.0), (1.0, -0.05, 0.0)
    links = (
        Link("crank", 2.1, 0.15, A, (0.11, 0.07, 0.0)),
        Link("coupler", 1.4, 0.10, B, (0.52, 0.55, 0.0)),
        Link("rocker", 1.9, 0.13, D, (1.08, 0.31, 0.0)),
    )
    couplings = (
        Coupling("A", HINGE, None, "crank", A),
        Coupling("B", BALL, "crank", "coupler", B),
        Coupling("C", CROSS, "rocker", "coupler", C, across(B, C)),
        Coupling("D", HINGE, None, "rocker", D),
    )
    return Mechanism("four-bar", links, couplings, rate=11.0)


def inline_four(angle: float = 0.3, radius: float = 1.0, rod_length: float = 2.0, spacing: float = 0.2) -> Mechanism:
    """Return the toy engine of references/engine.json with its bores along y, without gravity; 10 rpm."""
    centre = (0.0, 0.0, 0.0)
    links, couplings = [Link("crank", 8.0, 6.0, centre, centre)], [Coupling("bearing", HINGE, None, "crank", centre)]
    for i, side in enumerate((1.0, -1.0, -1.0, 1.0)):
        z = (i - 1.5) * spacing
        pin = (-side * radius * np.sin(angle), side * radius * np.cos(angle), z)
        wrist = (0.0, pin[1] + np.sqrt(rod_length**2 - pin[0] ** 2), z)
        links.append(Link(f"rod {i + 1}", 4.0, 1 / 3, pin, (pin[0] / 2, (pin[1] + wrist[1]) / 2, z)))
        links.append(Link(f"piston {i + 1}", 5.0, 1.0, wrist, wrist))
        couplings += [
            Coupling(f"crankpin {i + 1}", BALL, "crank", f"rod {i + 1}", pin),
            Coupling(f"wristpin {i + 1}", CROSS, f"piston {i + 1}", f"rod {i + 1}", wrist, across(pin, wrist)),
            Coupling(f"bore {i + 1}", GUIDE, None, f"piston {i + 1}", wrist, (0.0, 1.0, 0.0)),
        ]
    return Mechanism("inline four", tuple(links), tuple(couplings), rate=2 * np.pi / 6, gravity=(0.0, 0.0))


def mechanisms() -> tuple[Mechanism, ...]:
    """Return the three planar mechanisms."""
    return slider_crank(), four_bar(), inline_four()


CYCLE_SAMPLES = 72  # [1] samples of a turn
TURN_STEPS = 400  # [1] of RK4, for a free turn


class Floor(NamedTuple):
    """Largest absolute value of a sum that vanishes in theory, relative to the forces that cancel in it."""

    mechanism: str
    what: str
    plane: float | None
    space: float
    redundant: float


def cycle(mechanism: Mechanism) -> list[Any]:
    """Simulate one driven turn by kinematics: in the plane, in space, in space with redundant rows."""
    times = mechanism.turn * np.arange(CYCLE_SAMPLES + 1) / CYCLE_SAMPLES
    spatial = [mechanism.space(driven=True, redundant=redundant) for redundant in (False, True)]
    return [
        planar.kinematics(mechanism.plane(driven=True), times),
        *(
            mbsd3d.simulate(system, times[-1], method=mbsd3d.Kinematic(), output=CYCLE_SAMPLES + 1)
            for system in spatial
        ),
    ]


def cubic(values: np.ndarray) -> np.ndarray:
    """Return vectors (n, 3) from (n, 2), (n, 3) or, about z, (n,)."""
    if values.ndim == 1:
        return values[:, None] * (0.0, 0.0, 1.0)
    return np.pad(values, ((0, 0), (0, 3 - values.shape[1])))


def grounded(mechanism: Mechanism, solution: mbsd3d.Solution) -> list[np.ndarray]:
    """Return the force of the ground in each of its joints [N], shape (n, 3)."""
    return [cubic(solution.reaction(c.name).force) for c in mechanism.couplings if c.a is None]


def imbalance(mechanism: Mechanism, solution: mbsd3d.Solution) -> float:
    """Return the residual of Newton's law for the whole: largest |forces of the ground + m g - sum m a_G|, relative to
    the largest force.
    """
    forces, rest = grounded(mechanism, solution), 0.0
    for link in mechanism.links:
        arm = cubic(solution.com(link.name) - solution.position(link.name))
        alpha, omega = cubic(solution.alpha(link.name)), cubic(solution.omega(link.name))
        a = cubic(solution.acceleration(link.name)) + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
        rest = rest + link.mass * (a - (*mechanism.gravity, 0.0))
    return float(np.abs(sum(forces) - rest).max() / np.abs(forces).max())


def balanced(mechanism: Mechanism, solution: mbsd3d.Solution) -> tuple[float, float]:
    """Return (1x force along the bores, largest force across them) of the inline four on its block over F_single.

    F_single = w^2 (m_c r_c + (m_r + m_p) R), 10 kg m w^2: the 1x force of one cylinder.
    """
    single = 10.0 * mechanism.rate**2
    block = -np.sum(grounded(mechanism, solution), axis=0)
    along = spectrum(solution.t, block[:, 1], rate=mechanism.rate)
    return float(abs(along.at(1)) / single), float(np.abs(block[:, 0]).max() / single)


def noise_floors() -> list[Floor]:
    """Measure how well "1 - 1 = 0" holds: sums over a driven turn, and out-of-plane components in space."""
    floors = []
    for mechanism in mechanisms():
        runs = cycle(mechanism)
        floors.append(Floor(mechanism.name, "Newton for the whole", *(imbalance(mechanism, run) for run in runs)))
        lost = [float(np.abs(sum(f))[:, 2].max() / np.abs(f).max()) for f in (grounded(mechanism, r) for r in runs[1:])]
        floors.append(Floor(mechanism.name, "force out of the plane", None, *lost))
        forms = [mechanism.space(redundant=redundant) for redundant in (False, True)]
        free = [
            mbsd3d.simulate(system, mechanism.turn, method=mbsd3d.RK4(mechanism.turn / TURN_STEPS), output=2)
            for system in forms
        ]
        size = max(np.abs(link.origin).max() for link in mechanism.links)
        drift = [max(abs(np.ptp(run.com(link.name)[:, 2])) for link in mechanism.links) / size for run in free]
        floors.append(Floor(mechanism.name, "drift out of the plane", None, *map(float, drift)))
    pairs = [balanced(mechanism, run) for run in runs]  # of the last mechanism, the inline four
    floors.append(Floor(mechanism.name, "1x along the bores / F_single", *(pair[0] for pair in pairs)))
    floors.append(Floor(mechanism.name, "force across the bores / F_single", *(pair[1] for pair in pairs)))
    return floors
