"""A coin spun on the table hums faster and faster while its face seems to stand still."""

import numpy as np

from mbsd3d import GROUND, Body, RollingDisc, System, rotation, shapes, simulate

from ..form import GRAVITY, Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share

G = 9.81  # m/s^2


def mechanism(*, a=0.04, I1_over_ma2=0.25, tilt_deg=10.0) -> System:
    """Build a thin disc of radius a [m], moments (1, 1, 2) I1, at a tilt from the table, its centre at rest."""
    tilt, mass = np.radians(tilt_deg), 0.1
    rate = precession(a, I1_over_ma2, tilt)
    omega = rate * np.sin(tilt) * np.array([-np.cos(tilt), 0, np.sin(tilt)])  # along the radius to the table
    moments = I1_over_ma2 * mass * a**2 * np.array([1, 1, 2])
    form = [shapes.Disc(a, 0.06 * a), shapes.Box((1.2 * a, 0.12 * a, 0.08 * a), colour="orangered")]
    disc = Body("disc", mass, moments, position=(0, 0, a * np.sin(tilt)), velocity=(0, 0, 0), omega=omega,
                orientation=rotation("y", tilt), shape=form)  # fmt: skip
    axis = (np.sin(tilt), 0, np.cos(tilt))
    return System([disc], [RollingDisc(GROUND, disc, axis=axis, radius=a, name="edge")], gravity=(0, 0, -G))


def precession(a, ratio, tilt):
    """Return W = sqrt(g/(a ratio sin tilt)) [rad/s]."""
    return np.sqrt(G / (a * ratio * np.sin(tilt)))


def theory(*, a, I1_over_ma2, tilt_deg):
    """Return the rates: I1 W sin(tilt) turns at W under the moment m g a cos(tilt): W^2 = g/(a (I1/m a^2) sin tilt)."""
    tilt = np.radians(tilt_deg)
    rate = precession(a, I1_over_ma2, tilt)
    return {"precession_rad_s": rate, "face_turn_rad_s": rate * (1 - np.cos(tilt))}


def measure(build, terms) -> Measured:
    """Measure rates of the disc's axis about the vertical, and of its face as seen from above, over two rounds."""
    duration = 2 * 2 * np.pi / build.theory["precession_rad_s"]
    run = simulate(build(), duration, rtol=1e-13, output=201, **terms)
    axis, e = run.rotation("disc")[:, :, 2], run.orientation("disc")
    azimuth = np.unwrap(np.arctan2(axis[:, 1], axis[:, 0]))
    face = np.unwrap(2 * np.arctan2(e[:, 3], e[:, 0]))  # precession and spin together
    values = {"precession_rad_s": np.ptp(azimuth) / run.t[-1], "face_turn_rad_s": abs(face[-1] - face[0]) / run.t[-1]}
    rates = build.theory
    curves = [
        Curve("turn of the axis [deg]", run.t, np.degrees(azimuth - azimuth[0]),
              (run.t, np.degrees(rates["precession_rad_s"] * run.t))),
        Curve("turn of the face [deg]", run.t, np.degrees(face - face[0]),
              (run.t, np.degrees(rates["face_turn_rad_s"] * run.t))),
    ]  # fmt: skip
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="Euler's disc",
    question="Why does a spun coin hum faster and faster while it seems to stop?",
    beats=(
        Beat(0.0, "The contact races round the rim."),
        Beat(share(0.5), "Once round, and the face has turned by 5.5 degrees."),
        Beat(share(1.0), "Twice round: it hums, and hardly seems to turn."),
    ),
    why="The point of contact races around the edge, and that is what one hears. The flatter the coin lies, the "
    "smaller the angular momentum that its weight has to turn, so it must turn it faster: without limit as the "
    "tilt goes to zero. But the edge and its track on the table are then nearly of the same length, and the face "
    "turns only by the difference.",
    equation="W^2 = g / (a (I_1 / m a^2) sin tilt); disc: W^2 = 4 g / (a sin tilt); the face turns at W (1 - cos tilt)",
    symbols={
        "W": Symbol("rate of the contact", "rad/s"),
        "a": Symbol("radius", "m", "a"),
        "I_1": Symbol("moment across, over m a^2", "", "I1_over_ma2"),
        "m": Symbol("disc, which does not matter"),
        "g": GRAVITY,
    },
    source="Moffatt, Nature 404 (2000) 833; O'Reilly, Nonlinear Dynamics 10 (1996) 287",
    quantities={
        "precession_rad_s": Quantity("rate of the contact point", "rad/s"),
        "face_turn_rad_s": Quantity("rate of the face", "rad/s"),
    },
    ablation=Ablation(
        "face",
        "a ring instead of a disc is slower by sqrt(2) (w lies along a principal axis, so that "
        "w x I w vanishes and leaving it out would change nothing)",
        {"I1_over_ma2": 0.5},
    ),  # fmt: skip
    against=Against("tilt_deg", 2.0, 60.0, "tilt [deg]"),
    show={"curves": [("omega", "disc")], "shown": ["angular velocity"], "traces": [], "speed": 0.02},
    sliders=(Control("tilt_deg", 4.0, 40.0, "deg", "tilt"),),
    attempt="lay it flatter: the point of contact races, and the face hardly turns.",
)
