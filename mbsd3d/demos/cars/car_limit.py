"""A car in circles at a steady speed, up to the limit of its tyres: roll, loads, steer and slip angles."""

import numpy as np

from mbsd3d import Pulse, System, simulate

from ..figure import Line
from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from .car import SHOW_OPTIONS, WHEELS, Car, car
from .circle import circle, circles
from .theory import (
    ROLL_SYMBOLS,
    ROLL_TOLERANCE,
    limit,
    roll_gradient,
    textbook_roll_gradient,
    transfers,
    trims,
    understeer_gradient,
)

SMALL_ACCELERATION = 1e-3  # [m/s^2] terms of second order vanish
# [m/s^2] range of the closed forms; then side forces lift the leaning car along its slides
LINEAR_ACCELERATION_MAX = 3.5
LIGHT_WHEEL_INERTIA = 1e-3  # [kg m^2] of a wheel that turns, with almost no spin


def mechanism(
    *, ms=1400.0, h=0.55, a=1.2, b=1.5, track=1.5, kf=25e3, kr=22e3, bar_f=12e3, bar_r=6e3, mu=1.0, v=20.0, steer=0.05
) -> System:  # fmt: skip
    """Build the car at v with front wheels steered to an angle [rad] within 0.3 s."""
    require(v > 0.0, f"demo 'car_limit': v = {v:g} m/s; give a speed ahead")
    return car(Car(ms, h, a, b, track, kf, kr, bar_f, bar_r, mu), v, Pulse(steer, start=0.2, edge=0.3))


def known(c: Car, v: float, spin: float) -> dict[str, float]:
    """Return closed forms of small accelerations, and the limit by trims; ``spin``: share of the wheels' spin that
    counts.
    """
    roll, without = roll_gradient(c, spin), roll_gradient(c._replace(Iw=LIGHT_WHEEL_INERTIA), spin)
    front, rear = transfers(c, spin)
    return {
        "roll_rad_s2_m": roll,
        "front_transfer_kg": front,
        "rear_transfer_kg": rear,
        "understeer_rad_s2_m": understeer_gradient(c),
        "lean_percent": 100.0 * (without - textbook_roll_gradient(c)) / roll,
        "spin_percent": 100.0 * (roll - without) / roll,
        "limit_m_s2": limit(c, v).acceleration,
    }


def theory(*, ms, h, a, b, track, kf, kr, bar_f, bar_r, mu, v):
    """Return the values of `known` with the full spin of the wheels."""
    return known(Car(ms, h, a, b, track, kf, kr, bar_f, bar_r, mu), v, 1.0)


def without_gyroscopic(*, ms, h, a, b, track, kf, kr, bar_f, bar_r, mu, v):
    """Return the values without the gyroscopic moment: half of the moment that turns the spin is I dw/dt of a wheel's
    diameter, and stays.
    """
    return known(Car(ms, h, a, b, track, kf, kr, bar_f, bar_r, mu), v, 0.5)


def measure(build, terms, *, ms, h, a, b, track, kf, kr, bar_f, bar_r, mu, v) -> Measured:
    """Measure a very wide circle, with the wheels' spin and without, circles up to the limit, and the step of the
    steer.
    """
    c = Car(ms, h, a, b, track, kf, kr, bar_f, bar_r, mu)
    wide, spinless = (
        circle(one, v, SMALL_ACCELERATION, terms=terms) for one in (c, c._replace(Iw=LIGHT_WHEEL_INERTIA))
    )
    load, found = wide.of_tyres("normal"), circles(c, v, terms)
    textbook = SMALL_ACCELERATION * textbook_roll_gradient(c)
    values = {
        "roll_rad_s2_m": wide.roll / SMALL_ACCELERATION,
        "front_transfer_kg": 0.5 * (load[1] - load[0]) / SMALL_ACCELERATION,
        "rear_transfer_kg": 0.5 * (load[3] - load[2]) / SMALL_ACCELERATION,
        "understeer_rad_s2_m": wide.steer / SMALL_ACCELERATION - (a + b) / v**2,
        "lean_percent": 100.0 * (spinless.roll - textbook) / wide.roll,
        "spin_percent": 100.0 * (wide.roll - spinless.roll) / wide.roll,
        "limit_m_s2": found[-1].acceleration,
    }
    return Measured(values, [simulate(build(), 3.0, output=301, **terms)], curves(c, v, found), notes=notes(found))


def notes(found):
    """Return a line on the last circle."""
    last = found[-1]
    used = dict(zip(WHEELS, last.of_tyres("saturation"), strict=True))
    parts = ", ".join(f"{name} {100.0 * share:.1f} %" for name, share in used.items())
    return [
        f"circles up to {last.acceleration:.4g} m/s^2; there the tyres use of their grip: {parts}; the car rolls "
        f"{np.degrees(last.roll):.3g} deg and steers {np.degrees(last.steer):.3g} deg"
    ]


def curves(c, v, found):
    """Draw steer and slip angles, loads, and roll over the acceleration, with trims and the textbook."""
    x, along = np.array([one.acceleration for one in found]), {"along": "lateral acceleration [m/s^2]"}
    angles, loads = (np.array([one.of_tyres(of) for one in found]).T for of in ("slip_angle", "normal"))
    known = trims(c, v)
    at = np.array([one.acceleration for one in known])
    known_angles, known_loads = (np.array([getattr(one, of) for one in known]).T for of in ("slip_angles", "loads"))
    axles = {"slip in front": (0, 1), "slip behind": (2, 3)}
    slips = [
        Line(name, np.degrees(angles[[*pair]].mean(axis=0)), None, (at, np.degrees(known_angles[[*pair]].mean(axis=0))))
        for name, pair in axles.items()
    ]
    names, roll = [*WHEELS], np.degrees([one.roll for one in found])
    steer = np.degrees([one.steer for one in found]), np.degrees([one.steer for one in known])
    book, some = np.degrees(textbook_roll_gradient(c)) * x, at[at < LINEAR_ACCELERATION_MAX]
    return [
        Curve("angle [deg]", x, steer[0], (at, steer[1]), name="steer", more=slips, **along),
        Curve(
            "load [N]", x, loads[0], (at, known_loads[0]), name=names[0],
            more=[Line(names[k], loads[k], None, (at, known_loads[k])) for k in (1, 2, 3)], **along,
        ),
        Curve(
            "roll [deg]", x, roll, (some, np.degrees(roll_gradient(c)) * some), more=[Line("textbook", book)], **along
        ),
    ]  # fmt: skip


demo = Demo(
    __name__,
    title="A car at the limit",
    question="How far does a car roll, and how much must one steer, on the way to the limit of its tyres?",
    beats=(
        Beat(0.0, "Straight on at 72 km/h."),
        Beat(share(0.4), "In the curve it leans outwards, and its outer tyres carry it."),
        Beat(share(1.0), "It goes round on a steady circle."),
    ),
    why="At a steady speed on ever smaller circles (ISO 4138) load goes to the outer wheels and the tyres slip, at "
    "first in proportion, then more and more, until one axle has no grip left: there is no smaller circle. "
    "Textbooks give the roll 7 to 8 % too low. They leave out that the wheels lean with the car and so have their "
    "weight aside (7 %), and that their spin is carried round, which takes a moment that rolls the car outward (2 "
    "%).",
    equation="roll = (m_s h + 4 m_w r + 4 I_w/r) a_y / (K_f + K_r - (m_s h + 4 m_w r) g)",
    symbols={
        "a_y": Symbol("acceleration sideways", "m/s^2"),
        "m_s": Symbol("body", "kg", "ms"),
        **ROLL_SYMBOLS,
    },
    source="Milliken, Milliken, Race Car Vehicle Dynamics; ISO 4138 (steady circles at a constant speed)",
    quantities={
        "roll_rad_s2_m": Quantity("roll per lateral acceleration", "rad s^2/m", relative=1e-6),
        "front_transfer_kg": Quantity("load from left to right in front, per acceleration", "kg", relative=1e-6),
        "rear_transfer_kg": Quantity("load from left to right behind, per acceleration", "kg", relative=1e-6),
        "understeer_rad_s2_m": Quantity("understeer gradient", "rad s^2/m", absolute=3e-7),
        "lean_percent": Quantity("of the roll, by the lean of the wheels", "%", absolute=1e-4),
        "spin_percent": Quantity("of the roll, by the spin of the wheels", "%", absolute=1e-4),
        "limit_m_s2": Quantity("largest lateral acceleration", "m/s^2", relative=ROLL_TOLERANCE),
    },
    ablation=Ablation(
        "gyroscopic",
        "the car rolls less by half of what its spinning wheels add; the other half is I dw/dt of the wheels",
        values=without_gyroscopic,
    ),
    alone="MuJoCo has no such tyre, and Exudyn no bar between two wheels",
    show={**SHOW_OPTIONS, "curves": [("force", "front right tyre"), ("force", "rear right tyre")]},
    ranges={"h": (0.5, 0.57), "track": (1.47, 1.65), "mu": (0.85, 1.02), "kf": (24e3, 28e3), "kr": (20e3, 25e3)},
    sliders=(
        Control("steer", 0.01, 0.06, "rad"),
        Control("v", 12.0, 22.0, "m/s", "speed"),
    ),
    attempt="steer more: the outer wheels take the load, and the front slides first.",
)  # fmt: skip
