"""Car on four springs, two bars and four tyres, with or without an engine that spins in it."""

from typing import Any, NamedTuple

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Bushing,
    Cylindrical,
    Joint,
    Prismatic,
    Revolute,
    Signal,
    SpeedDriver,
    SpringDamper,
    System,
    Torque,
    Tyre,
    shapes,
)
from mbsd3d.api.viewable import AnimateOptions
from mbsd3d.mechanism.force_element import ForceElement

G = 9.81  # m/s^2
UP = np.array([0.0, 0.0, 1.0])
WHEELS = {"front left": (1, 1), "front right": (1, -1), "rear left": (-1, 1), "rear right": (-1, -1)}
STRUT_LENGTH = 0.5  # [m] of the springs under load; they act along one line, so it does not matter
KINGPIN_SHAPE = shapes.Lines([(0.0, 0.0, 0.0), (0.0, 0.0, 0.4)])
CRANK_MASS = 10.0  # [kg] of a crankshaft, taken from the mass without the wheels
SHOW_OPTIONS = AnimateOptions(traces=[], hidden=["joints", "joint names", "body names"], follow="chassis")  # of all


class Engine(NamedTuple):
    """Crankshaft at the centre of mass of the car."""

    J: float  # about its axis [kg m^2]; half of it about a diameter
    speed: float  # [rad/s]
    axis: tuple[float, float, float]  # to the left: across; ahead: along

    @property
    def spin(self) -> np.ndarray:
        """Return the angular velocity of the crankshaft relative to the car [rad/s]."""
        return self.speed * np.array(self.axis)


class Car(NamedTuple):
    """Parameters of the car; SI units."""

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
    kt: float = 200_000.0  # of a tyre,
    ct: float = 400.0
    damping: float = 2000.0  # of a spring
    inertia: tuple[float, float, float] = (550.0, 2200.0, 2500.0)  # of the mass without the wheels
    cornering: float = 18.0  # of a tyre, over the load,
    longitudinal: float = 20.0
    relaxation: float = 0.4
    nominal_load: float = 4000.0
    less_grip: float = 0.12  # per nominal load more
    less_stiffness: float = 0.25
    engine: Engine | None = None

    @property
    def wheelbase(self) -> float:
        """Return the distance of the axles [m]."""
        return self.a + self.b

    def share(self, wheel: str) -> float:
        """Return the share of the weight on a wheel at rest [-]."""
        return 0.5 * (self.b if wheel.startswith("front") else self.a) / self.wheelbase

    def load(self, wheel: str) -> float:
        """Return the load on a wheel at rest [N]."""
        return (self.ms * self.share(wheel) + self.mw) * G

    def place(self, wheel: str) -> np.ndarray:
        """Return the position of a wheel's centre from the centre of mass of the car [m]."""
        x, y = WHEELS[wheel]
        return np.array([self.a if x > 0 else -self.b, 0.5 * y * self.track, self.r - self.h])

    def stiffness(self, wheel: str) -> float:
        """Return the side force of a tyre over its slip angle at the load at rest [N/rad]."""
        N = self.load(wheel)
        return N * self.cornering * (1.0 - self.less_stiffness * (N / self.nominal_load - 1.0))


def chassis_of(c: Car, speed: float) -> Body:
    """Return the sprung mass as a body, without the crankshaft."""
    form = [
        shapes.Box((1.6 * c.wheelbase, 1.1 * c.track, 0.9 * c.h), at=(0, 0, 0.1 * c.h), colour="steelblue"),
        shapes.Box((0.8 * c.wheelbase, c.track, 0.8 * c.h), at=(-0.2, 0, 0.9 * c.h)),
    ]
    mass = c.ms - CRANK_MASS if c.engine else c.ms
    return Body("chassis", mass, c.inertia, position=c.h * UP, velocity=(speed, 0, 0), shape=form)


def car(c: Car, speed: float, steer: Signal | float | None, drive: Signal | float = 0.0) -> System:
    """Build the car at a speed [m/s] ahead, with a steer angle of both front wheels [rad] to the left.

    Wheels slide along the upward axis of the chassis. ``steer``: None holds the angle at which it is, whatever that is;
    ``drive``: torque on the rear wheels together, which the chassis bears [N m].
    """
    chassis = chassis_of(c, speed)
    bodies, carriers = [chassis], {}
    joints: list[Joint] = []
    forces: list[ForceElement] = []
    for name in WHEELS:
        at, front = chassis.position + c.place(name), name.startswith("front")
        carrier = carriers[name] = Body(f"{name} carrier", 0.0, (0, 0, 0), position=at, shape=KINGPIN_SHAPE)
        wheel = Body(
            f"{name} wheel", c.mw, (0.5 * c.Iw, c.Iw, 0.5 * c.Iw), position=at, velocity=(speed, 0, 0),
            omega=(0, speed / c.r, 0), shape=shapes.Cylinder(c.r, 0.2, "y", colour="dimgray"),
        )  # fmt: skip
        bodies += [carrier, wheel]
        slide = (Cylindrical if front else Prismatic)(chassis, carrier, at=at, axis=UP, name=f"{name} slide")
        joints += [slide, Revolute(carrier, wheel, at=at, axis=(0, 1, 0), name=f"{name} hub")]
        if front:
            driver: dict[str, Any] = {"name": f"{name} steering"}
            held = SpeedDriver(chassis, carrier, axis=UP, speed=0.0, **driver)
            joints.append(held if steer is None else AngleDriver(slide, steer, **driver))
        else:
            for body, half in ((wheel, 0.5 * drive), (chassis, -0.5 * drive)):
                forces.append(Torque(body, (0.0, half, 0.0), frame="body", name=f"drive of {name} on {body.name}"))
        k = c.kf if front else c.kr
        spring = {"stiffness": k, "damping": c.damping, "length": STRUT_LENGTH + c.ms * G * c.share(name) / k}
        forces.append(
            SpringDamper(chassis, carrier, at_a=at + STRUT_LENGTH * UP, at_b=at, name=f"{name} spring", **spring)
        )
        forces.append(tyre_of(c, name, wheel))
    for end, bar in (("front", c.bar_f), ("rear", c.bar_r)):
        left, right = carriers[f"{end} left"], carriers[f"{end} right"]
        middle, stiffness = 0.5 * (left.position + right.position), (0.0, 0.0, bar / c.track**2)
        forces.append(Bushing(left, right, at=middle, stiffness=stiffness, name=f"{end} bar"))
    if c.engine:
        bodies, joints = with_engine(c.engine, bodies, joints)
    return System(bodies, joints, forces, gravity=(0, 0, -G))


def tyre_of(c: Car, name: str, wheel: Body) -> Tyre:
    """Return the tyre of a wheel, with an unloaded radius that gives the radius r under its load."""
    sunk = c.load(name) / c.kt
    return Tyre(
        GROUND, wheel, axis=(0, 1, 0), radius=c.r + sunk, crown=sunk, stiffness=c.kt, damping=c.ct, mu=c.mu,
        cornering=c.cornering, longitudinal=c.longitudinal, relaxation=c.relaxation, nominal_load=c.nominal_load,
        grip_sensitivity=c.less_grip, stiffness_sensitivity=c.less_stiffness, name=f"{name} tyre",
    )  # fmt: skip


def with_engine(engine: Engine, bodies: list[Body], joints: list[Joint]) -> tuple[list[Body], list[Joint]]:
    """Add crankshaft, bearing and speed after all other parts."""
    chassis, moments = bodies[0], 0.5 * engine.J * (1.0 + np.abs(engine.axis))
    crank = Body(
        "crankshaft", CRANK_MASS, moments, position=chassis.position, velocity=chassis.velocity, omega=engine.spin,
        shape=shapes.Cylinder(0.1, 0.7, "xyz"[int(np.argmax(np.abs(engine.axis)))]),
    )  # fmt: skip
    bearing = Revolute(chassis, crank, at=chassis.position, axis=engine.axis, name="crank bearing")
    speed = SpeedDriver(chassis, crank, axis=engine.axis, speed=engine.speed, name="engine speed")
    return [*bodies, crank], [*joints, bearing, speed]
