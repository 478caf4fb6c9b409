"""Effect of the engine's spin on roll, pitch and loads of a car on springs and tyres in a circle."""

import numpy as np

from mbsd3d import Pulse, System, simulate

from ..figure import Line
from ..form import Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from .car import SHOW_OPTIONS, Car, Engine, G, car
from .circle import circle
from .theory import ROLL_SYMBOLS, axle_stiffnesses

SMALL_ACCELERATION = 1e-3  # [m/s^2] terms of second order vanish
AXES = {"y": (0.0, 1.0, 0.0), "x": (1.0, 0.0, 0.0)}
CURVE_ACCELERATIONS = (1.0, 4.0, 7.0)  # [m/s^2] of the curves


def car_with(h, track, J, Omega, axis):
    """Build the car with a crankshaft that spins."""
    require(axis in AXES, f'demo \'engine_in_the_car\': axis = {axis!r}; give "y" (across) or "x" (along)')
    return Car(h=h, track=track, engine=Engine(J, Omega, AXES[axis]))


def mechanism(*, h=0.55, track=1.5, J=0.25, Omega=700.0, axis="y", v=26.0, steer=0.02) -> System:
    """Build the car at v with a crankshaft J [kg m^2] at Omega [rad/s] across (y) or along (x), steered within 0.3
    s."""
    return car(car_with(h, track, J, Omega, axis), v, Pulse(steer, start=0.2, edge=0.3))


def theory(*, h, track, J, Omega, axis, v):
    """Return the values of `shares` with the full gyroscopic moment."""
    return shares(car_with(h, track, J, Omega, axis), v, J)


def without_gyroscopic(*, h, track, J, Omega, axis, v):
    """Return the values without the gyroscopic moment: half of it is I dw/dt of the turning crankshaft and wheels, and
    stays.
    """
    return shares(car_with(h, track, J, Omega, axis), v, 0.5 * J, 0.5)


def shares(c, v, J, spin=1.0):
    """Return J W v/R over the acceleration v^2/R, on the springs of roll across, on those of pitch along.

    Springs in series with tyres: of roll K - (ms h + 4 mw r) g as for the circles; of pitch L^2 kf kr/(kf + kr) between
    the axles, less ms g (h - r), as round wheels do not lean. ``spin``: share of the wheels' spin that is counted.
    """
    gyro, across = J * c.engine.speed / v, c.engine.axis[1] != 0.0
    front, rear = (2.0 / (1.0 / k + 1.0 / c.kt) for k in (c.kf, c.kr))
    height, ahead = c.ms * c.h + 4.0 * c.mw * c.r, c.ms * G * (c.h - c.r)
    roll = gyro * across / (axle_stiffnesses(c).sum() - height * G)
    pitch = -gyro * (not across) / (c.wheelbase**2 * front * rear / (front + rear) - ahead)
    return {
        "roll_by_engine_rad_s2_m": roll,
        "transfer_by_engine_kg": axle_stiffnesses(c).sum() * roll / c.track,
        "share_percent": 100.0 * gyro * across / (gyro * across + height + 4.0 * spin * c.Iw / c.r),
        "pitch_by_engine_rad_s2_m": pitch,
        "front_by_engine_kg": (ahead * pitch - gyro * (not across)) / c.wheelbase,
    }


def measure(build, terms, *, h, track, J, Omega, axis, v) -> Measured:
    """Measure very wide circles with the engine running and at rest, and circles that tighten."""
    c = car_with(h, track, J, Omega, axis)
    both = [c, c._replace(engine=c.engine._replace(speed=0.0))]
    runs, stands = (circle(one, v, SMALL_ACCELERATION, terms=terms) for one in both)
    more = runs.of_tyres("normal") - stands.of_tyres("normal")
    values = {
        "roll_by_engine_rad_s2_m": (runs.roll - stands.roll) / SMALL_ACCELERATION,
        "transfer_by_engine_kg": 0.5 * (more[1] + more[3] - more[0] - more[2]) / SMALL_ACCELERATION,
        "share_percent": 100.0 * (runs.roll - stands.roll) / runs.roll,
        "pitch_by_engine_rad_s2_m": (runs.pitch - stands.pitch) / SMALL_ACCELERATION,
        "front_by_engine_kg": (more[0] + more[1]) / SMALL_ACCELERATION,
    }
    return Measured(values, [simulate(build(), 3.0, output=301, **terms)], curves(both, v, terms, shares(c, v, J)))


def curves(both, v, terms, known):
    """Draw loads due to the engine, from left to right and from rear to front, over the acceleration."""
    found = [[circle(c, v, step, terms=terms) for step in CURVE_ACCELERATIONS] for c in both]
    runs, stands = (np.array([one.of_tyres("normal") for one in group]).T for group in found)
    more, x = runs - stands, np.array(CURVE_ACCELERATIONS)
    lines = {
        "from left to right": (0.5 * (more[1] + more[3] - more[0] - more[2]), known["transfer_by_engine_kg"]),
        "from behind to the front": (more[0] + more[1], known["front_by_engine_kg"]),
    }
    (name, (y, slope)), *rest = lines.items()
    others = [Line(name, y, None, (x, slope * x)) for name, (y, slope) in rest]
    along = "lateral acceleration [m/s^2]"
    return [Curve("load moved by the engine [N]", x, y, (x, slope * x), along, name=name, more=others)]


demo = Demo(
    __name__,
    title="An engine across the car",
    question="Does the spin of a transverse engine make a car roll, or pitch, and does one notice?",
    beats=(
        Beat(0.0, "A car with its engine across, at 94 km/h."),
        Beat(share(1.0), "It leans. Of the lean the engine makes 0.8 percent."),
    ),
    why="The car carries the crankshaft's angular momentum round the corner, which takes a moment at right angles to "
    "it. Built across and turning like the wheels, the engine rolls the car outward, as its wheels do; it does "
    "not pitch it, as some books say. Built along, it pitches it and does not roll it. But nobody notices: of the roll "
    "the engine makes less than one part in a hundred, because J W v/R is small beside m h v^2/R; at higher speeds "
    "the share falls.",
    equation="roll = (m_s h + 4 m_w r + 4 I_w/r + J W/v) a_y / (K_f + K_r - (m_s h + 4 m_w r) g)",
    symbols={
        "a_y": Symbol("acceleration sideways", "m/s^2"),
        "J": Symbol("moment of the crankshaft", "kg m^2", "J"),
        "W": Symbol("spin of the engine", "rad/s", "Omega"),
        "v": Symbol("speed", "m/s", "v"),
        "m_s": Symbol("body", "kg"),
        **ROLL_SYMBOLS,
    },
    source="d(J W)/dt = w x H; Milliken, Milliken, Race Car Vehicle Dynamics (gyroscopic couples)",
    quantities={
        "share_percent": Quantity("share of the engine in the roll", "%", 1e-6, 1e-5),
        "roll_by_engine_rad_s2_m": Quantity("roll by the engine, per acceleration", "rad s^2/m", 1e-6, 1e-9),
        "transfer_by_engine_kg": Quantity("load from left to right by the engine, per acceleration", "kg", 1e-6, 1e-4),
        "pitch_by_engine_rad_s2_m": Quantity("pitch by the engine, per acceleration", "rad s^2/m", 1e-6, 1e-9),
        "front_by_engine_kg": Quantity("load to the front by the engine, per acceleration", "kg", 1e-6, 1e-4),
    },
    ablation=Ablation(
        "gyroscopic",
        "half of what the engine does is lost; the other half is I dw/dt of the crankshaft",
        values=without_gyroscopic,
    ),
    against=Against("Omega", -900.0, 900.0, "speed of the crankshaft [rad/s]", 3),
    alone="MuJoCo has no such tyre, and Exudyn no bar between two wheels",
    show={**SHOW_OPTIONS, "curves": [("force", "front right tyre"), ("force", "front left tyre")]},
)  # fmt: skip
