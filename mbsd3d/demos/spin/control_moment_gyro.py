"""Two wheels tilted in opposite gimbals turn a satellite that has nothing to push against."""

import numpy as np
from scipy.integrate import quad

from mbsd3d import AngleDriver, Body, Polynomial, Revolute, SpeedDriver, System, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share


def mechanism(*, Is=500.0, A=0.3, C=0.5, Omega=300.0, delta_deg=60.0, T=4.0) -> System:
    """Build a satellite Is [kg m^2], wheels (C, A, A) at +-Omega [rad/s] along x, gimbals about y driven by delta in T
    [s].
    """
    d, bodies, joints = np.radians(delta_deg), [], []
    satellite = Body("satellite", 500.0, (Is, Is, Is), omega=(0, 0, 0),
                     shape=shapes.Box((1.2, 2.4, 0.8), colour="silver"))  # fmt: skip
    for side, name in ((1, "upper"), (-1, "lower")):
        place = (0, 0, 1.1 * side)
        gimbal = Body(f"{name} gimbal", 0.0, (0, 0, 0), position=place, shape=shapes.Torus(0.55, 0.03, "z"))
        wheel = Body(f"{name} wheel", 5.0, (C, A, A), position=place, omega=(side * Omega, 0, 0),
                     shape=(shapes.Disc(0.4, 0.12, "x"), shapes.Cylinder(0.03, 1.0, "x")))  # fmt: skip
        hinge = Revolute(satellite, gimbal, at=place, axis=(0, -side, 0), name=f"{name} tilt")
        joints += [
            hinge,
            AngleDriver(hinge, Polynomial((0, 0, 3 * d / T**2, -2 * d / T**3)), name=f"{name} motor"),
            Revolute(gimbal, wheel, at=place, axis=(1, 0, 0), name=f"{name} spin"),
            SpeedDriver(gimbal, wheel, axis=(1, 0, 0), speed=side * Omega, name=f"{name} speed"),
        ]
        bodies += [gimbal, wheel]
    return System([satellite, *bodies], joints, gravity=(0, 0, 0))


def rate(d, *, Is, A, C, Omega):
    """Return the rate of the satellite [rad/s] at a tilt d: the momentum about z stays zero."""
    return -2 * C * Omega * np.sin(d) / (Is + 2 * A * np.cos(d) ** 2 + 2 * C * np.sin(d) ** 2)


def tilt(t, delta_deg, T):
    """Return the tilt of the gimbals [rad]: a cubic from rest to rest."""
    return np.radians(delta_deg) * (3 * (t / T) ** 2 - 2 * (t / T) ** 3)


def theory(*, Is, A, C, Omega, delta_deg, T):
    """Return the rate by the momentum about z, and the turn by its integral."""

    def at(t):
        return rate(tilt(t, delta_deg, T), Is=Is, A=A, C=C, Omega=Omega)

    turn = quad(at, 0, T, epsabs=1e-14, epsrel=1e-13)[0]
    return {"satellite_rate_rad_s": at(T), "satellite_turn_deg": np.degrees(turn)}


def measure(build, terms, *, Is, A, C, Omega, delta_deg, T) -> Measured:
    """Measure rate and angle of the satellite when the gimbals have stopped."""
    run = simulate(build(), T, rtol=1e-12, output=201, **terms)
    w, R = run.omega("satellite")[:, 2], run.rotation("satellite")
    turn = np.unwrap(np.arctan2(R[:, 1, 0], R[:, 0, 0]))
    expected = rate(tilt(run.t, delta_deg, T), Is=Is, A=A, C=C, Omega=Omega)
    values = {"satellite_rate_rad_s": w[-1], "satellite_turn_deg": np.degrees(turn[-1])}
    return Measured(values, [run], [Curve("rate of the satellite [rad/s]", run.t, w, (run.t, expected))])


demo = Demo(
    __name__,
    title="Turning in space with nothing to push against",
    question="How does a space station turn with nothing to push against?",
    beats=(
        Beat(0.0, "Two wheels spin against each other: together they have no angular momentum."),
        Beat(share(0.5), "They tip, and no longer cancel: the station turns against them."),
        Beat(share(1.0), "All the way it has pushed on nothing but its wheels."),
    ),
    why="Two wheels spin against each other, so that their angular momenta cancel. Tilted in opposite directions by "
    "small motors, both point up a little, and their sum no longer vanishes; as nothing outside can take angular "
    "momentum, the station turns the other way. Tilting back stops it exactly. The motors only turn the axes and "
    "need little torque; the gyroscopic moments do the work.",
    equation="theta' = -2 C W sin d / (I_s + 2 A cos^2 d + 2 C sin^2 d)",
    symbols={
        "I_s": Symbol("moment of the station", "kg m^2", "Is"),
        "C": Symbol("moment of a wheel along its axis", "kg m^2", "C"),
        "A": Symbol("moment of a wheel across it", "kg m^2", "A"),
        "W": Symbol("spin of the wheels", "rad/s", "Omega", arrow="angular momentum"),
        "d": Symbol("tilt of the wheels in the end", "deg", "delta_deg"),
        "theta": Symbol("turn of the station; its rate", "rad/s", curve=(0, 2)),
    },
    source="Hughes, Spacecraft Attitude Dynamics; Wie, Space Vehicle Dynamics and Control (control moment gyros)",
    quantities={
        "satellite_rate_rad_s": Quantity("rate of the satellite at the end", "rad/s"),
        "satellite_turn_deg": Quantity("turn of the satellite", "deg"),
    },
    ablation=Ablation("spin", "wheels that do not spin turn nothing", {"Omega": 0.0}),
    against=Against("delta_deg", 0.0, 90.0, "tilt of the gimbals [deg]", computed=3),
    show={"curves": [("omega", "satellite")], "shown": ["angular momentum"], "traces": []},
    sliders=(
        Control("delta_deg", 10.0, 90.0, "deg", "tilt of the wheels"),
        Control("Omega", 0.0, 600.0, "rad/s", "spin of the wheels"),
    ),
    attempt="tilt the wheels by 90 degrees: the station turns by the most. Stop the wheels, and tilting them "
    "turns nothing.",
)
