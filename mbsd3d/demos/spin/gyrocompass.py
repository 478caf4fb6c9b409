"""A wheel kept level on the turning Earth swings its axis about true north."""

import numpy as np

from mbsd3d import GROUND, Body, Revolute, SpeedDriver, System, measures, shapes, simulate

from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..quadrature import swing


def mechanism(*, Omega_e=0.05, lat_deg=40.0, psi0_deg=60.0, A=0.01, C=0.02, G=0.005, spin=200.0) -> System:
    """Build the Earth turning at Omega_e [rad/s] about z, a card (G, G, G) [kg m^2] on the vertical, a wheel (C, A, A)
    in it.
    """
    lat, psi = np.radians(lat_deg), np.radians(psi0_deg)
    up, north = np.array([np.cos(lat), 0, np.sin(lat)]), np.array([-np.sin(lat), 0, np.cos(lat)])
    axis = np.cos(psi) * north + np.sin(psi) * np.cross(up, north)
    turned = np.column_stack([axis, np.cross(up, axis), up])
    rate = np.array([0, 0, Omega_e])
    earth = Body("earth", 10.0, (1, 1, 1), omega=rate, shape=shapes.Torus(0.4, 0.02, "z"))
    card = Body("card", 0.1, (G, G, G), orientation=turned, omega=rate, shape=shapes.Torus(0.2, 0.01, "z"))
    wheel = Body("wheel", 1.0, (C, A, A), orientation=turned, omega=rate + spin * axis,
                 shape=(shapes.Disc(0.15, 0.04, "x"), shapes.Cylinder(0.01, 0.38, "x")))  # fmt: skip
    joints = [
        Revolute(GROUND, earth, at=(0, 0, 0), axis=(0, 0, 1), name="axis of the Earth"),
        SpeedDriver(GROUND, earth, axis=(0, 0, 1), speed=Omega_e, name="day"),
        Revolute(earth, card, at=(0, 0, 0), axis=up, name="vertical"),
        Revolute(card, wheel, at=(0, 0, 0), axis=axis, name="spin"),
    ]
    return System([earth, card, wheel], joints, gravity=(0, 0, 0))


def time_to_north(factor, twist, *, W, psi0, inertia):
    """Integrate inertia s'' = -factor W sin s + twist W^2 sin s cos s from rest at psi0 to 0; W = rate to north."""
    psi0 = abs(psi0)

    def square(s):
        return 2 * W * (factor * (np.cos(s) - np.cos(psi0)) + 0.5 * twist * W * (np.sin(s) ** 2 - np.sin(psi0) ** 2))

    return 0.5 * swing(lambda s: square(s) / inertia, -psi0, psi0)[0]


def theory(*, Omega_e, lat_deg, psi0_deg, A, C, G, spin):
    """Return the time of (A + G) s'' = -h W cos(lat) sin s + (A + G - G) W^2 cos^2(lat) sin s cos s, h the momentum of
    the wheel.
    """
    require(abs(psi0_deg) < 179.99, f"demo 'gyrocompass': psi0_deg = {psi0_deg:g}: due south it does not know which "
            "way to turn; give less than 179.99")  # fmt: skip
    W, psi0 = Omega_e * np.cos(np.radians(lat_deg)), np.radians(psi0_deg)
    h = C * (spin + W * np.cos(psi0))
    return {"time_to_north_s": time_to_north(h, A, W=W, psi0=psi0, inertia=A + G)}


def without_gyroscopic(*, Omega_e, lat_deg, psi0_deg, A, G, spin):
    """Return the time without the gyroscopic moment: half of it is I dw/dt of the turning wheel: (A + G) s'' = -A (spin
    + ...) W cos(lat) sin s.
    """
    W, psi0 = Omega_e * np.cos(np.radians(lat_deg)), np.radians(psi0_deg)
    sigma = spin + W * np.cos(psi0)
    return {"time_to_north_s": time_to_north(A * sigma, A, W=W, psi0=psi0, inertia=A + G)}


def measure(build, terms, *, Omega_e, lat_deg, psi0_deg, C, A, G, spin) -> Measured:
    """Measure the time at which the axis passes the meridian."""
    system, psi0 = build(), np.radians(psi0_deg)
    period = 2 * np.pi * np.sqrt((A + G) / abs(C * spin * Omega_e * np.cos(np.radians(lat_deg))))
    turned = measures.angle(system.part("vertical", "joints"))
    north = turned < -psi0 if psi0 > 0 else turned > -psi0
    run = simulate(system, 3 * period, rtol=1e-13, stop_when=north, **terms)
    seen = simulate(system, 2 * period, rtol=1e-11, output=401, **terms)
    quarter = build.theory["time_to_north_s"]
    passes = quarter * np.arange(1, 8, 2)
    passes = passes[passes < seen.t[-1]]
    angle = psi0_deg + np.degrees(seen.angle("vertical"))
    curve = Curve("axis east of north [deg]", seen.t, angle, (passes, 0 * passes), title="theory: when it points north")
    return Measured({"time_to_north_s": run.final.t}, [seen], [curve])


demo = Demo(
    __name__,
    title="The gyrocompass",
    question="How does a wheel find true north without a magnet?",
    beats=(
        Beat(0.0, "Let go 60 degrees beside north."),
        Beat(0.527, "It passes north."),
        Beat(1.055, "It swings as far to the other side."),
        Beat(1.582, "And over north again: it swings about nothing else."),
    ),
    why="The Earth carries the wheel's axis along, unless the axis points to the pole. The wheel resists such a turn "
    "with a moment at right angles to it; kept level, it can only follow this moment about the vertical, and "
    "that takes its axis towards the meridian. It swings about north like a pendulum, slowly where the Earth "
    "turns slowly, and not at all at the pole. (The Earth turns 700 times too fast here, so that one can watch "
    "it.)",
    equation="A_u s'' = -C w W cos(lat) sin s; small swings: T = 2 pi sqrt(A_u / (C w W cos lat))",
    symbols={
        "s": Symbol("turn of the card since the release", "rad", curve=(0, 0)),
        "A_u": Symbol("moment of card and wheel about the vertical", "kg m^2", lambda A, G: A + G),
        "C": Symbol("moment of the wheel along its axis", "kg m^2", "C"),
        "w": Symbol("spin of the wheel", "rad/s", "spin", arrow="angular momentum"),
        "W": Symbol("turn of the Earth, much quickened", "rad/s", "Omega_e"),
        "T": Symbol("time of a swing", "s"),
    },
    source="Goldstein, Classical Mechanics (gyrocompass); Arnold, Maunder, Gyrodynamics",
    quantities={"time_to_north_s": Quantity("time from the release to north", "s")},
    ablation=Ablation(
        "gyroscopic", "half the moment is lost, and it takes longer by sqrt(C/A)", values=without_gyroscopic
    ),  # fmt: skip
    show={"curves": [("angle", "vertical")], "shown": ["angular momentum"], "traces": []},
    ranges={"A": (0.01, 0.012), "C": (0.01, 0.019)},
    sliders=(
        Control("lat_deg", 0.0, 80.0, "deg", "latitude"),
        Control("spin", 100.0, 300.0, "rad/s"),
    ),
    attempt="go north: the nearer to the pole, the longer it takes to find north, as less of the Earth's "
    "turn is level there.",
)
