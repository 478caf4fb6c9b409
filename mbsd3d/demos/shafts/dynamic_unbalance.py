"""A wheel whose centre of mass lies on its axis still shakes its bearings, if it is mounted aslant."""

import numpy as np

from mbsd3d import GROUND, Body, PointOnLine, SpeedDriver, Spherical, System, rotation, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol
from ..moments import share


def mechanism(*, A=0.3, C=0.5, omega=30.0, tilt_deg=15.0, span=0.5) -> System:
    """Build a disc (A, A, C) [kg m^2] at a tilt on a shaft along z at omega [rad/s], two bearings span [m] apart."""
    tilted = rotation("y", tilt_deg, degrees=True)
    bar = shapes.Cylinder(0.008, 1.2 * span, at=(0, 0, 0), orientation=rotation("y", -tilt_deg, degrees=True))
    wheel = Body("wheel", 20.0, (A, A, C), orientation=tilted, omega=(0, 0, omega), shape=(shapes.Disc(0.2, 0.05), bar))
    joints = [
        Spherical(GROUND, wheel, at=(0, 0, -span / 2), name="lower bearing"),
        PointOnLine(GROUND, wheel, at=(0, 0, span / 2), axis=(0, 0, 1), name="upper bearing"),
        SpeedDriver(GROUND, wheel, axis=(0, 0, 1), speed=omega, name="motor"),
    ]
    return System([wheel], joints, gravity=(0, 0, 0))


def theory(*, A, C, omega, tilt_deg, span):
    """Return w x I w = (C - A) w^2 sin a cos a, a couple that the bearings hold over their span."""
    a = np.radians(tilt_deg)
    return {"bearing_force_N": abs((C - A) * omega**2 * np.sin(a) * np.cos(a)) / span}


def measure(build, terms, *, omega) -> Measured:
    """Measure the force of a bearing, which turns with the wheel."""
    run = simulate(build(), 2 * 2 * np.pi / abs(omega), rtol=1e-12, output=121, **terms)
    force = run.reaction("upper bearing").force
    size, known = np.linalg.norm(force, axis=1), build.theory["bearing_force_N"]
    phase = np.arctan2(run.rotation("wheel")[:, 1, 2], run.rotation("wheel")[:, 0, 2])
    degrees = np.degrees(abs(omega) * run.t)
    sign = np.sign(force[0, 0]) or 1.0
    curve = Curve("force of a bearing along x [N]", degrees, force[:, 0], (degrees, sign * known * np.cos(phase)),
                  "turn [deg]")  # fmt: skip
    return Measured({"bearing_force_N": size.mean()}, [run], [curve])


demo = Demo(
    __name__,
    title="Balanced, and still shaking",
    question="Why does a statically balanced wheel still shake its bearings?",
    beats=(
        Beat(0.0, "The disc sits aslant: L does not lie along the shaft."),
        Beat(share(0.125), "To carry L round, both bearings must push."),
        Beat(share(0.25), "Half a turn, and they push the other way."),
    ),
    why="A disc mounted aslant has its centre of mass on the axis: at rest it lies in any position. But its angular "
    "momentum does not lie along the shaft. As the wheel turns, this arrow is carried round a cone, and carrying "
    "it round takes a moment, which the two bearings supply by forces that turn with the wheel. That is why a "
    "tyre is balanced on both sides of the rim.",
    equation="F = |C - A| w^2 sin a cos a / span",
    symbols={
        "F": Symbol("force of a bearing", "N", curve=(0, 0), arrow="reaction force"),
        "C": Symbol("moment of the disc along its axis", "kg m^2", "C"),
        "A": Symbol("moment across it", "kg m^2", "A"),
        "w": Symbol("turn", "rad/s", "omega"),
        "a": Symbol("how much it sits aslant", "deg", "tilt_deg"),
    },
    source="Den Hartog, Mechanical Vibrations, ch. 6; ISO 21940",
    quantities={"bearing_force_N": Quantity("force of a bearing", "N")},
    ablation=Ablation(
        "gyroscopic",
        "nothing shakes, as nothing shakes for A = C or without the tilt",
        values=lambda: {"bearing_force_N": 0.0},
    ),  # fmt: skip
    against=Against("tilt_deg", 0.0, 45.0, "tilt [deg]"),
    show={
        "curves": [("reaction", "upper bearing")],
        "shown": ["reaction force", "angular momentum"],
        "traces": [],
        "speed": 0.1,
    },  # fmt: skip
    ranges={"A": (0.28, 0.34), "C": (0.43, 0.55)},  # C < 2 A, as of any body,
    sliders=(
        Control("tilt_deg", 1.0, 45.0, "deg", "tilt of the disc"),
        Control("omega", 10.0, 60.0, "rad/s", "speed"),
    ),
    attempt="turn it twice as fast: the bearings carry four times as much.",
)
