"""Two Cardan joints cancel each other's unevenness, or double it if one is fitted a quarter turn out."""

import numpy as np

from mbsd3d import GROUND, Body, Cylindrical, Revolute, SpeedDriver, System, Universal, rotation, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from .cardan import ratio

INPUT_RATE, TURN_SAMPLES = 10.0, 361  # rad/s; of one turn, the extremes are at its quarters


def mechanism(*, bend_deg=30.0, phase_deg=90.0) -> System:
    """Build parallel shafts joined by a middle one at an angle; its second yoke is turned by the phase about it."""
    require(phase_deg in (0, 90), f"demo 'cardan_wrong_phase': phase_deg = {phase_deg:g}; give 90 (wrong) or 0 (right)")
    bend, ends = np.radians(bend_deg), np.array([1.0, 0, 0])
    along, across = np.array([np.cos(bend), np.sin(bend), 0]), np.array([-np.sin(bend), np.cos(bend), 0])
    bar = shapes.Cylinder(0.05, 0.9, "x")
    disc = shapes.Disc(0.2, 0.05, "x"), shapes.Box((0.06, 0.02, 0.42))
    drive = Body("drive", 1.0, (0.2, 1, 1), position=-0.5 * ends, shape=(bar, *disc))
    middle = Body("middle", 1.0, (0.2, 1, 1), position=0.5 * along, orientation=rotation("z", bend), shape=bar)
    driven = Body("driven", 1.0, (0.2, 1, 1), position=along + 0.5 * ends, shape=(bar, *disc))
    pin, other = ((0, 0, 1), (0, 1, 0)) if phase_deg == 0 else (across, (0, 0, 1))
    joints = [
        Revolute(GROUND, drive, at=-ends, axis=ends, name="bearing"),
        SpeedDriver(GROUND, drive, axis=ends, speed=INPUT_RATE, name="motor"),
        Universal(drive, middle, at=(0, 0, 0), axis_a=(0, 1, 0), axis_b=(0, 0, 1), name="cross 1"),
        Universal(middle, driven, at=along, axis_a=pin, axis_b=other, name="cross 2"),
        Cylindrical(GROUND, driven, at=along + ends, axis=ends, name="support"),
    ]
    return System([drive, middle, driven], joints, gravity=(0, 0, 0))


def theory(*, bend_deg, phase_deg):
    """Return the greatest ratio: in the wrong phase both crosses are fast and slow together, 1/cos^2 b and cos^2 b; in
    the right phase 1.
    """
    require(abs(bend_deg) < 90, f"demo 'cardan_wrong_phase': bend_deg = {bend_deg:g}: a cross locks at 90; give less")
    least = 1.0 if phase_deg == 0 else np.cos(np.radians(bend_deg)) ** 2
    return {"greatest_ratio": 1 / least, "least_ratio": least}


def measure(build, terms, *, bend_deg, phase_deg) -> Measured:
    """Measure output over input rate during one turn."""
    run = simulate(build(), 2 * np.pi / INPUT_RATE, rtol=1e-12, output=TURN_SAMPLES, **terms)
    found, b = run.omega_body("driven")[:, 0] / INPUT_RATE, np.radians(bend_deg)
    first = ratio(INPUT_RATE * run.t, b)
    middle = np.arctan2(np.sin(INPUT_RATE * run.t), np.cos(b) * np.cos(INPUT_RATE * run.t))  # angle of the middle shaft
    known = np.ones_like(first) if phase_deg == 0 else first * ratio(middle, b)
    degrees = np.degrees(INPUT_RATE * run.t)
    curve = Curve("output over input rate [-]", degrees, found, (degrees, known), "input [deg]")
    return Measured({"greatest_ratio": found.max(), "least_ratio": found.min()}, [run], [curve])


demo = Demo(
    __name__,
    title="A Cardan shaft put together wrong",
    question="What if the mechanic fits the second Cardan joint a quarter turn out?",
    beats=(
        Beat(0.0, "Put together wrong, both joints hurry together ..."),
        Beat(share(0.25), "... and wait together."),
        Beat(share(0.5), "Fitted right, one would take back what the other does."),
    ),
    why="A cross between shafts at an angle speeds up and slows down twice a turn. A second one at the same angle "
    "can take that back exactly, but only if its yoke on the middle shaft lies as that of the first. Turned by a "
    "quarter, it is fast when the first is fast, and the unevenness is squared instead of cancelled.",
    equation="greatest ratio = 1 / cos^2 b, least = cos^2 b; unevenness = 1 / cos^4 b, instead of 1",
    symbols={
        "b": Symbol("bend of each joint", "deg", "bend_deg"),
    },
    source="Seherr-Thoss, Schmelz, Aucktor, Universal Joints and Driveshafts; SAE AE-7",
    quantities={
        "greatest_ratio": Quantity("greatest output over input rate"),
        "least_ratio": Quantity("least output over input rate"),
    },
    ablation=Ablation("phase", "fitted right, the output runs evenly", {"phase_deg": 0.0}),
    against=Against("bend_deg", 0.0, 45.0, "bend [deg]"),
    show={"curves": [("omega_body", "driven")], "traces": []},
    ranges={"phase_deg": None},
    sliders=(Control("bend_deg", 0.0, 50.0, "deg", "bend"),),
    attempt="bend the shafts more, and switch on the ghost, whose yokes are in phase.",
)
