"""A long satellite swings about the vertical: the Earth pulls its near end a little more than its far one."""

import numpy as np
from scipy.special import ellipk

from mbsd3d import GROUND, Body, CentralGravity, Revolute, SpeedDriver, System, measures, rotation, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

EARTH_DISTANCE = 100.0  # [m] where the orbit needs mu = n^2 d^3; the swing does not depend on it


def globe():
    """Draw the Earth below, much nearer than it is, and the line down to it."""
    return (
        shapes.Sphere(1.2, at=(-3.2, 0, 0), colour="steelblue"),
        shapes.Cylinder(0.012, 2.0, "x", at=(-1.0, 0, 0), colour="gray"),
    )


def mechanism(*, I=(10.0, 11.0, 3.0), n=0.05, pitch_deg=40.0) -> System:
    """Build the frame of the orbit at n [rad/s] about y, x of it up; satellite I [kg m^2], its long axis z pitched from
    x.
    """
    rate, turned = np.array([0, n, 0]), rotation("y", 90.0 + pitch_deg, degrees=True)
    orbit = Body("orbit", 1.0, (1, 1, 1), omega=rate, shape=globe())
    form = (
        shapes.Cylinder(0.05, 2.4),
        shapes.Box((0.5, 0.5, 0.4), at=(0, 0, -1.2)),
        shapes.Sphere(0.2, at=(0, 0, 1.2)),
    )
    satellite = Body("satellite", 1.0, I, orientation=turned, omega=rate, shape=form)
    joints = [
        Revolute(GROUND, orbit, at=(0, 0, 0), axis=(0, 1, 0), name="way"),
        SpeedDriver(GROUND, orbit, axis=(0, 1, 0), speed=n, name="orbital motion"),
        Revolute(orbit, satellite, at=(0, 0, 0), axis=(0, 1, 0), name="pitch"),
    ]
    pull = CentralGravity(orbit, satellite, at=(-EARTH_DISTANCE, 0, 0), mu=n**2 * EARTH_DISTANCE**3, name="Earth")
    return System([orbit, satellite], joints, [pull], gravity=(0, 0, 0))


def theory(*, I, n, pitch_deg):
    """Solve I2 a'' = -3 n^2 (I1 - I3) sin a cos a from rest at the pitch: a pendulum of the angle 2 a."""
    require(I[0] > I[2], f"demo 'gravity_gradient': I = {I}: no swing unless I[0] > I[2]; make the satellite longer")
    require(
        0 < abs(pitch_deg) < 90, f"demo 'gravity_gradient': pitch_deg = {pitch_deg:g}: it swings from between 0 and 90"
    )
    return {"quarter_period_s": ellipk(np.sin(np.radians(pitch_deg)) ** 2) / (n * np.sqrt(3 * (I[0] - I[2]) / I[1]))}


def measure(build, terms, *, I, n, pitch_deg) -> Measured:
    """Measure the time from the release at rest to the vertical."""
    system, about = build(), 1 / n * np.sqrt(I[1] / abs(I[0] - I[2] or I[1]))
    upright = measures.angle(system.part("pitch", "joints")) < -np.radians(pitch_deg)
    if pitch_deg < 0:
        upright = measures.angle(system.part("pitch", "joints")) > -np.radians(pitch_deg)
    run = simulate(system, 10 * about, rtol=1e-13, stop_when=upright, **terms)
    reached = abs(np.degrees(run.angle("pitch")[-1]) + pitch_deg) < 1e-6
    seen = simulate(system, 10 * about, rtol=1e-11, output=401, **terms)
    passes = ellipk(np.sin(np.radians(pitch_deg)) ** 2) * about / np.sqrt(3) * np.arange(1, 20, 2)
    passes = passes[passes < seen.t[-1]]
    angle = pitch_deg + np.degrees(seen.angle("pitch"))
    curve = Curve(
        "pitch from the vertical [deg]", seen.t, angle, (passes, 0 * passes), title="theory: when it is upright"
    )
    return Measured({"quarter_period_s": run.final.t if reached else np.inf}, [seen], [curve])


demo = Demo(
    __name__,
    title="The same face for ever",
    question="Why does the Moon (and a long satellite) always show the same face?",
    beats=(
        Beat(0.0, "Let go 40 degrees aslant."),
        Beat(25.86, "The near end is pulled more: it comes upright."),
        Beat(51.7, "It swings over like a pendulum ..."),
        Beat(share(1.0), "... and always shows the same end."),
    ),
    why="Gravity falls off with the distance, so the near end of a long body is pulled more than the far end, and on "
    "its orbit the centrifugal force does the same. Both together turn its long axis towards the Earth like a "
    "pendulum that has two lowest points. A body turned out of the vertical swings about it; a sphere feels "
    "nothing.",
    equation="I_2 a'' = -3 n^2 (I_1 - I_3) sin a cos a",
    symbols={
        "a": Symbol("pitch since the release", "rad", curve=(0, 0)),
        "n": Symbol("rate of the orbit", "rad/s", "n"),
        "I_1": Symbol("moment along the way", "kg m^2", lambda I: I[0]),
        "I_2": Symbol("moment across the orbit", "kg m^2", lambda I: I[1]),
        "I_3": Symbol("moment along the length", "kg m^2", lambda I: I[2]),
    },
    source="Hughes, Spacecraft Attitude Dynamics, ch. 9; Goldstein, Classical Mechanics, 5.8",
    quantities={"quarter_period_s": Quantity("time from the release to the vertical", "s")},
    ablation=Ablation(
        "length",
        "with three equal moments there is no pull, and it never comes upright",
        {"I": [10.0, 10.0, 10.0]},
        values=lambda: {"quarter_period_s": np.inf},
    ),  # fmt: skip
    against=Against("pitch_deg", 5.0, 85.0, "pitch at the release [deg]"),
    show={"curves": [("angle", "pitch")], "traces": []},
    ranges={"I": [(9.0, 10.0), (9.5, 11.0), (2.5, 3.5)]},
    sliders=(Control("pitch_deg", 5.0, 75.0, "deg", "tilt at the start"),),
    attempt="let it go from farther off the vertical: it swings slower, as a pendulum does.",
)
