"""A slanted disc turns a shaft into the strokes of a pump."""

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Fixed,
    Kinematic,
    PointOnPlane,
    Prismatic,
    Ramp,
    Revolute,
    System,
    shapes,
    simulate,
)

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

TURN_SAMPLES = 145  # [1] of one turn; the eighths of a turn, where the torque is greatest, are among them


def mechanism(*, tilt_deg=18.0, R=0.05, m=0.2, omega=200.0, pistons=9) -> System:
    """Build a drum at omega [rad/s] about z, pistons m [kg] in bores at R [m], their shoes on a plane tilted about
    y."""
    require(pistons >= 1, f"demo 'swash_plate': pistons = {pistons}; give 1 or more")
    slope = np.tan(np.radians(tilt_deg))
    normal = (np.sin(np.radians(tilt_deg)), 0, np.cos(np.radians(tilt_deg)))
    drum = Body("drum", 1.0, (1, 1, 1), shape=(shapes.Torus(R, 0.25 * R, at=(0, 0, 2 * R)),
                shapes.Cylinder(0.15 * R, 3 * R, at=(0, 0, 3 * R))))  # fmt: skip
    turn = Revolute(GROUND, drum, at=(0, 0, 0), axis=(0, 0, 1), name="shaft")
    bodies, joints = [drum], [turn, AngleDriver(turn, Ramp(omega), name="motor")]
    for k, angle in enumerate(2 * np.pi * np.arange(pistons) / pistons):
        place = np.array([R * np.cos(angle), R * np.sin(angle), -R * np.cos(angle) * slope])
        form = (shapes.Cylinder(0.16 * R, 2 * R, at=(0, 0, R)), shapes.Sphere(0.2 * R, at=(0, 0, 0)))
        bodies.append(Body(f"piston {k + 1}", m, (1e-4,) * 3, position=place, shape=form))
        bore = Prismatic(drum, bodies[-1], at=place, axis=(0, 0, 1), name=f"bore {k + 1}")
        joints += [bore, PointOnPlane(GROUND, bodies[-1], at=place, normal=normal, name=f"shoe {k + 1}")]
    slanted = shapes.Disc(1.5 * R, 0.2 * R, normal, at=-0.35 * R * np.array(normal), colour="silver")
    plate = Body("plate", 1.0, (1, 1, 1), shape=slanted)
    return System([*bodies, plate], [*joints, Fixed(GROUND, plate, at=(0, 0, 0), name="base")], gravity=(0, 0, 0))


def theory(*, tilt_deg, R, m, omega):
    """Return the stroke 2 R tan a; of one piston the torque m (R tan a)^2 w^2 sin(2wt)/2, of three or more together
    none.
    """
    require(abs(tilt_deg) < 90, f"demo 'swash_plate': tilt_deg = {tilt_deg:g}; give less than 90")
    reach = R * np.tan(np.radians(abs(tilt_deg)))
    return {"stroke_m": 2 * reach, "one_piston_torque_peak_Nm": 0.5 * m * reach**2 * omega**2}


def measure(build, terms, *, omega) -> Measured:
    """Measure the stroke of a piston and the greatest torque of one and of all."""
    turn = 2 * np.pi / abs(omega)
    one = simulate(build(pistons=1), turn, method=Kinematic(), output=TURN_SAMPLES, **terms)
    all_of_them = simulate(build(), turn, method=Kinematic(), output=TURN_SAMPLES, **terms)
    height, torque = one.position("piston 1")[:, 2], one.effort("motor")
    degrees, peak = np.degrees(abs(omega) * one.t), build.theory["one_piston_torque_peak_Nm"]
    wave = peak * np.sin(2 * np.radians(degrees)) * np.sign(omega)
    sign = np.sign(wave @ torque) or 1.0
    curves = [
        Curve("torque of one piston [N m]", degrees, torque, (degrees, sign * wave), "shaft [deg]"),
        Curve(
            "of all pistons [N m]", degrees, all_of_them.effort("motor"), (degrees, 0 * wave), "shaft [deg]", scale=peak
        ),
    ]
    return Measured(
        {"stroke_m": np.ptp(height), "one_piston_torque_peak_Nm": abs(torque).max()}, [all_of_them, one], curves
    )


demo = Demo(
    __name__,
    title="The swash plate",
    question="How does a slanted disc turn a shaft into the stroke of a pump?",
    beats=(
        Beat(0.0, "A drum turns over a disc that stands aslant."),
        Beat(share(0.5), "The first piston is 32 mm in: its whole stroke."),
        Beat(share(1.0), "Out again, by a pure sine."),
    ),
    why="Pistons go round with a drum, and their shoes follow a plane that stands slanted: once a turn each of them "
    "is pushed in and out by a pure sine. Changing the slant changes the stroke while the pump runs. One piston "
    "alone needs a torque that swings twice a turn to be hurried to and fro; three or more in a ring cancel it "
    "exactly.",
    equation="stroke = 2 R tan a; torque of one piston = m (R tan a)^2 w^2 sin(2 w t) / 2",
    symbols={
        "R": Symbol("pistons, from the shaft", "m", "R"),
        "a": Symbol("slant", "deg", "tilt_deg"),
        "m": Symbol("piston", "kg", "m"),
        "w": Symbol("turn", "rad/s", "omega"),
        "t": Symbol("time", "s"),
    },
    source="Ivantysyn, Ivantysynova, Hydrostatic Pumps and Motors",
    quantities={
        "stroke_m": Quantity("stroke", "m"),
        "one_piston_torque_peak_Nm": Quantity("greatest torque of one piston", "N m"),
    },
    ablation=Ablation("tilt", "on an upright plate nothing moves", {"tilt_deg": 0.0}),
    against=Against("tilt_deg", 0.0, 30.0, "tilt [deg]"),
    show={"curves": [("slide", "bore 1")], "traces": []},
    sliders=(Control("tilt_deg", 0.0, 30.0, "deg", "tilt of the disc"),),
    attempt="set the disc upright: the shaft turns and nothing is pumped.",
)
