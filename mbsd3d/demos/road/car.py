"""A car on four springs, two bars and four tyres, and the circles it drives at a steady speed."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import root

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Bushing,
    Cylindrical,
    Prismatic,
    Revolute,
    Signal,
    Solution,
    SpeedDriver,
    SpringDamper,
    State,
    System,
    Torque,
    Tyre,
    accelerations,
    rotation,
    shapes,
)
from mbsd3d.base.errors import InputError
from mbsd3d.base.quaternions import multiply
from mbsd3d.base.rotations import matrix

G = 9.81  # m/s^2
UP = np.array([0.0, 0.0, 1.0])
WHEELS = {"front left": (1, 1), "front right": (1, -1), "rear left": (-1, 1), "rear right": (-1, -1)}
STRUT = 0.5  # length of the springs under load [m]: they act along one line, so it does not matter
SIZES = np.array([0.01, 0.001, 0.01, 0.1, 0.01, *[0.01] * 4, *[1.0] * 4, 100.0, *[0.01] * 8])
"""Of the unknowns of a circle: roll, pitch, height, speed to the left, steer, travels, spins, drive, deflections."""
GROWING = np.isin(np.arange(22), [2, 9, 10, 11, 12], invert=True)  # about in proportion to the acceleration
MOST = 120  # states to try: twice what a circle takes
STEADY = 1e-8  # largest acceleration left over [m/s^2, rad/s^2]; rounding leaves 1e-12


class Car(NamedTuple):
    """Numbers of the car; SI units."""

    ms: float = 1400.0  # without the wheels
    h: float = 0.55  # height of its centre of mass,
    a: float = 1.2  # behind the front axle,
    b: float = 1.5  # ahead of the rear axle
    track: float = 1.5
    kf: float = 25_000.0  # of a spring
    kr: float = 22_000.0
    bar_f: float = 12_000.0  # of an anti-roll bar [N m/rad] of roll
    bar_r: float = 6_000.0
    mu: float = 1.0
    mw: float = 40.0  # of a wheel,
    Iw: float = 1.0  # about its axle; half of it about a diameter
    r: float = 0.3  # under load
    kt: float = 200_000.0  # of a tyre

    def share(self, wheel: str) -> float:
        """Of the weight on a wheel at rest."""
        return 0.5 * (self.b if wheel.startswith("front") else self.a) / (self.a + self.b)

    def load(self, wheel: str) -> float:
        """On a wheel at rest [N]."""
        return (self.ms * self.share(wheel) + self.mw) * G

    def place(self, wheel: str) -> np.ndarray:
        """Of a wheel's centre from the centre of mass of the car."""
        x, y = WHEELS[wheel]
        return np.array([self.a if x > 0 else -self.b, 0.5 * y * self.track, self.r - self.h])


KINGPIN = shapes.Lines([(0.0, 0.0, 0.0), (0.0, 0.0, 0.4)])
INERTIA = (550.0, 2200.0, 2500.0)
DAMPING = 2000.0  # [N s/m]
TYRE: Mapping[str, float] = {
    "cornering": 18.0, "longitudinal": 20.0, "relaxation": 0.4, "nominal_load": 4000.0, "grip_sensitivity": 0.12,
    "stiffness_sensitivity": 0.25,
}  # fmt: skip


def car(c: Car, speed: float, steer: Signal | float | None, drive: float = 0.0) -> System:
    """The car at a speed [m/s] ahead, with a steer angle of both front wheels [rad] to the left.

    Wheels slide along the upward axis of the chassis. ``steer``: None holds the angle at which it is, whatever that is;
    ``drive``: torque on the rear wheels together, which the chassis bears [N m].
    """
    chassis = Body(
        "chassis", c.ms, INERTIA, position=c.h * UP, velocity=(speed, 0, 0),
        shape=[
            shapes.Box((1.6 * (c.a + c.b), 1.1 * c.track, 0.9 * c.h), at=(0, 0, 0.1 * c.h), colour="lightsteelblue"),
            shapes.Box((0.8 * (c.a + c.b), c.track, 0.8 * c.h), at=(-0.2, 0, 0.9 * c.h)),
        ],
    )  # fmt: skip
    bodies, joints, forces, carriers = [chassis], [], [], {}
    for name in WHEELS:
        at, front = chassis.position + c.place(name), name.startswith("front")
        carrier = carriers[name] = Body(f"{name} carrier", 0.0, (0, 0, 0), position=at, shape=KINGPIN)
        wheel = Body(
            f"{name} wheel", c.mw, (0.5 * c.Iw, c.Iw, 0.5 * c.Iw), position=at, velocity=(speed, 0, 0),
            omega=(0, speed / c.r, 0), shape=shapes.Cylinder(c.r, 0.2, "y", colour="dimgray"),
        )  # fmt: skip
        bodies += [carrier, wheel]
        slide = (Cylindrical if front else Prismatic)(chassis, carrier, at=at, axis=UP, name=f"{name} slide")
        joints += [slide, Revolute(carrier, wheel, at=at, axis=(0, 1, 0), name=f"{name} hub")]
        if front:
            driver = {"name": f"{name} steering"}
            held = SpeedDriver(chassis, carrier, axis=UP, speed=0.0, **driver)
            joints.append(held if steer is None else AngleDriver(slide, steer, **driver))
        k = c.kf if front else c.kr
        spring = {"stiffness": k, "damping": DAMPING, "length": STRUT + c.ms * G * c.share(name) / k}
        forces.append(SpringDamper(chassis, carrier, at_a=at + STRUT * UP, at_b=at, name=f"{name} spring", **spring))
        sunk = c.load(name) / c.kt
        tyre = {"radius": c.r + sunk, "crown": sunk, "stiffness": c.kt, "mu": c.mu, **TYRE}
        forces.append(Tyre(GROUND, wheel, axis=(0, 1, 0), name=f"{name} tyre", **tyre))
        if drive and not front:
            for body, half in ((wheel, 0.5 * drive), (chassis, -0.5 * drive)):
                forces.append(Torque(body, (0.0, half, 0.0), frame="body", name=f"drive of {name} on {body.name}"))
    for end, bar in (("front", c.bar_f), ("rear", c.bar_r)):
        left, right = carriers[f"{end} left"], carriers[f"{end} right"]
        middle, stiffness = 0.5 * (left.position + right.position), (0.0, 0.0, bar / c.track**2)
        forces.append(Bushing(left, right, at=middle, stiffness=stiffness, name=f"{end} bar"))
    return System(bodies, joints, forces, gravity=(0, 0, -G))


@dataclass(frozen=True, eq=False)
class Circle:
    """A steady circle to the left; roll to the right and nose down are positive [rad]."""

    speed: float  # [m/s] of the centre of mass, ahead
    acceleration: float  # speed times yaw rate [m/s^2]
    x: np.ndarray  # (22,) the unknowns as solved, see `SIZES`
    at: Solution  # one sample, without the drive

    @property
    def roll(self) -> float:
        """[rad]"""
        return float(self.x[0])

    @property
    def steer(self) -> float:
        """[rad]"""
        return float(self.x[4])

    @property
    def drive(self) -> float:
        """Torque on the rear wheels that keeps the speed [N m]."""
        return float(self.x[13])

    def of_tyres(self, quantity: str) -> np.ndarray:
        """(4,) what `Solution.force` gives of the tyres, in the order of `WHEELS`."""
        return np.array([getattr(self.at.force(f"{name} tyre"), quantity)[0] for name in WHEELS])


class Balance:
    """What a state lacks to be a steady circle; accelerations are linear in the drive, so two systems do."""

    def __init__(self, c: Car, speed: float, acceleration: float, terms: Mapping[str, bool]) -> None:
        self.c, self.speed, self.terms = c, speed, terms
        self.turn = acceleration / speed * UP
        self.systems = [car(c, speed, None, drive) for drive in (0.0, 1.0)]

    def state(self, x: np.ndarray) -> State:
        """State of the unknowns: the chassis rolls about the line ahead, then pitches about its own axis."""
        e, centre = multiply(rotation("x", x[0]), rotation("y", x[1])), x[2] * UP
        v = np.array([self.speed, x[3], 0.0])
        q, rates = [centre, e], [v, self.turn]
        for k, name in enumerate(WHEELS):
            arm = matrix(e) @ (self.c.place(name) + x[5 + k] * UP)
            e_wheel = multiply(e, rotation("z", x[4])) if name.startswith("front") else e
            q += [centre + arm, e_wheel] * 2
            there = v + np.cross(self.turn, arm)
            rates += [there, self.turn, there, self.turn + x[9 + k] * matrix(e_wheel)[:, 1]]
        return State(0.0, np.concatenate(q), np.concatenate(rates), z=x[14:])

    def __call__(self, x: np.ndarray) -> np.ndarray:
        """(22,) accelerations over those of a circle, and rates of the deflections."""
        state = self.state(x)
        found = [accelerations(system, state, **self.terms) for system in self.systems]
        free, driven = (self.left_over(one) for one in found)
        rates = [rate for name in WHEELS for rate in found[0].force(f"{name} tyre").state_rates.values()]
        return np.concatenate([free + x[13] * (driven - free), *rates])

    def left_over(self, one: Solution) -> np.ndarray:
        """(14,) of the chassis, travels and spins."""
        up, found = one.rotation("chassis")[0, :, 2], [one.alpha("chassis")[0]]
        for body in ("chassis", *(f"{name} wheel" for name in WHEELS)):
            gap = one.acceleration(body)[0] - np.cross(self.turn, one.velocity(body)[0])
            found.append(gap if body == "chassis" else [up @ gap, one.rotation(body)[0, :, 1] @ one.alpha(body)[0]])
        return np.concatenate(found)


def circle(
    c: Car, speed: float, acceleration: float, near: Circle | None = None, terms: Mapping[str, bool] | None = None
) -> Circle:  # fmt: skip
    """The circle at a speed [m/s] and an acceleration to the left [m/s^2], sought near another one.

    Raises
    ------
    InputError
        If there is none near it: beyond the grip of the tyres there is none.
    """
    balance = Balance(c, speed, acceleration, terms or {})
    start = np.zeros(SIZES.size)
    start[[2, 4]], start[9:13] = (c.h, (c.a + c.b) * acceleration / speed**2), speed / c.r
    if near is not None:
        start = near.x * np.where(GROWING, acceleration / near.acceleration, 1.0)
    found = root(lambda x: balance(SIZES * x), start / SIZES, tol=1e-12, options={"maxfev": MOST})
    left = float(np.abs(found.fun).max())
    if not left < STEADY:
        raise InputError(
            f"car: no circle at {speed:g} m/s and {acceleration:.4g} m/s^2 ({left:.2g} m/s^2 are left over); give a "
            "smaller acceleration, or a circle near it"
        )
    x = SIZES * found.x
    return Circle(speed, acceleration, x, accelerations(balance.systems[0], balance.state(x), **(terms or {})))


def circles(c: Car, speed: float, steps: Iterable[float], terms: Mapping[str, bool] | None = None) -> list[Circle]:
    """Circles at rising accelerations, each one step [m/s^2] on from the one before; a step that fails is left out."""
    found: list[Circle] = []
    for step in steps:
        last = found[-1] if found else None
        try:
            found.append(circle(c, speed, step + (last.acceleration if last else 0.0), last, terms))
        except InputError:
            continue
    return found
