"""Two shafts at an angle: the driven one runs unevenly, and a second joint takes it back."""

from functools import partial

import numpy as np
from matplotlib.figure import Figure

from mbsd3d import (
    GROUND,
    Body,
    Cylindrical,
    PointOnLine,
    Revolute,
    Solution,
    SpeedDriver,
    System,
    Universal,
    rotation,
    simulate,
)
from mbsd3d.base.style import COLOURS, GREY
from mbsd3d.mechanism import shapes

from ..base import Exhibit, Outcome, Row, Show
from ..drawing import every, legend_below, new_figure, spectrum_bars, theory_dots

BEND, RATE = np.radians(30.0), 10.0  # rad, rad/s
INERTIA = (0.2, 1.0, 1.0)  # kg m^2, the shafts lie along the body's x
SAMPLES = 256  # of one turn: greatest and least rate are among them
ORDERS = np.array([2, 4, 6])


def ratio(angle: np.ndarray, bend: float) -> np.ndarray:
    """Output over input rate: cos b / (1 - sin^2 b cos^2(angle)), the input's cross axis in the shafts' plane at 0."""
    return np.cos(bend) / (1 - np.sin(bend) ** 2 * np.cos(angle) ** 2)


def harmonics(bend: float) -> np.ndarray:
    """Amplitudes over the mean at 2, 4, 6 times shaft speed: 2 tan^(2k)(b/2), the Poisson kernel of `ratio`."""
    return 2 * np.tan(bend / 2) ** ORDERS


def motor_torque(angle: np.ndarray, bend: float) -> np.ndarray:
    """J2 times output acceleration times ratio [N m]: all power goes into the driven shaft."""
    n = ratio(angle, bend)
    slope = -(np.sin(bend) ** 2) * np.sin(2 * angle) * n**2 / np.cos(bend)
    return INERTIA[0] * RATE**2 * n * slope


def shaft(outer: float | None, *forks: tuple[float, str]) -> list[shapes.Shape]:
    """Shape of a shaft along x about its middle: a disc at the end ``outer``, and forks (end, axis of their pin)."""
    ends = [end - np.sign(end) * 0.16 for end, _ in forks] + ([] if outer is None else [outer])
    ends += [-ends[0]] if len(ends) == 1 else []
    made: list[shapes.Shape] = [
        shapes.Cylinder(0.04, abs(ends[0] - ends[1]), "x", at=(0.5 * (ends[0] + ends[1]), 0, 0))
    ]
    if outer is not None:
        made.append(shapes.Disc(0.18, 0.04, "x", at=(outer, 0, 0)))
    for end, pin in forks:
        across = np.array([0.0, pin == "y", pin == "z"])
        inner = end - np.sign(end) * 0.16
        made.append(shapes.Box(np.array([0.04, 0.06, 0.06]) + 0.2 * across, at=(inner, 0, 0)))
        for side in (-0.115, 0.115):
            place = side * across + [0.5 * (inner + end) + 0.01 * np.sign(end), 0, 0]
            made.append(shapes.Box(np.array([0.22, 0.06, 0.06]) - 0.03 * across, at=place))
        made.append(shapes.Cylinder(0.02, 0.28, pin, at=(end, 0, 0), colour=GREY))
    return made


def direction(angle: float) -> np.ndarray:
    """Unit vector in the xy plane."""
    return np.array([np.cos(angle), np.sin(angle), 0.0])


def input_shaft() -> tuple[Body, list[shapes.Shape]]:
    """The driven input along x, ending at the origin."""
    drive = Body("drive", 1.0, INERTIA, position=(-0.5, 0, 0), shape=shaft(-0.5, (0.5, "y")))
    bearing = Revolute(GROUND, drive, at=(-0.5, 0, 0), axis=(1, 0, 0), name="bearing")
    return drive, [bearing, SpeedDriver(GROUND, drive, axis=(1, 0, 0), speed=RATE, name="motor")]


def shaft_pair(bend: float) -> System:
    """Two shafts in the xy plane that meet at the origin."""
    drive, joints = input_shaft()
    along = direction(bend)
    shape, turned = shaft(0.5, (-0.5, "z")), rotation("z", bend)
    driven = Body("driven", 1.0, INERTIA, position=0.5 * along, orientation=turned, shape=shape)
    joints += [
        Universal(drive, driven, at=(0, 0, 0), axis_a=(0, 1, 0), axis_b=(0, 0, 1), name="cross"),
        PointOnLine(GROUND, driven, at=along, axis=along, name="support"),  # a bearing here would be redundant
    ]
    return System([drive, driven], joints, gravity=(0, 0, 0))


def double_joint(bend: float) -> System:
    """Input and output parallel, a middle shaft at the angle ``bend`` with aligned yokes."""
    drive, joints = input_shaft()
    along = direction(bend)
    shape, turned = shaft(None, (-0.5, "z"), (0.5, "z")), rotation("z", bend)
    middle = Body("middle", 1.0, INERTIA, position=0.5 * along, orientation=turned, shape=shape)
    driven = Body("driven", 1.0, INERTIA, position=along + (0.5, 0, 0), shape=shaft(0.5, (-0.5, "y")))
    joints += [
        Universal(drive, middle, at=(0, 0, 0), axis_a=(0, 1, 0), axis_b=(0, 0, 1), name="cross 1"),
        Universal(middle, driven, at=along, axis_a=(0, 0, 1), axis_b=(0, 1, 0), name="cross 2"),
        Cylindrical(GROUND, driven, at=along + (1, 0, 0), axis=(1, 0, 0), name="support"),
    ]
    return System([drive, middle, driven], joints, gravity=(0, 0, 0))


def one_turn(system: System) -> Solution:
    """One turn of the input."""
    return simulate(system, 2 * np.pi / RATE, rtol=1e-12, output=SAMPLES + 1)


def output_ratio(solution: Solution) -> np.ndarray:
    """Output over input rate at the samples."""
    return solution.omega_body("driven")[:, 0] / RATE


def amplitudes(solution: Solution) -> np.ndarray:
    """Harmonics of the output rate over its mean."""
    spectrum = np.abs(np.fft.rfft(output_ratio(solution)[:-1]))
    return 2 * spectrum[ORDERS] / spectrum[0]


def run(*, bend_factor: float = 1.0) -> Outcome:
    """One turn of the single and of the double joint; ``bend_factor`` bends the shafts more than theory knows."""
    bend = bend_factor * BEND
    single, double = one_turn(shaft_pair(bend)), one_turn(double_joint(bend))
    found, even = output_ratio(single), output_ratio(double)
    rows = [Row("greatest over least output rate", found.max() / found.min(), 1 / np.cos(BEND) ** 2, 1e-10)]
    rows += [
        Row(f"{order}x amplitude over the mean rate", value, theory, 1e-10)
        for order, value, theory in zip(ORDERS, amplitudes(single), harmonics(BEND), strict=True)
    ]
    torque = motor_torque(RATE * single.t, BEND)
    rows.append(Row("greatest motor torque", single.effort("motor").max(), torque.max(), 1e-8, "N m"))
    rows.append(Row("double joint: greatest output/input rate", even.max(), 1.0, 1e-10))
    rows.append(Row("double joint: least output/input rate", even.min(), 1.0, 1e-10))
    solutions = {"cardan": single, "cardan_double": double}
    options = {"curves": [("omega_body", "driven"), ("effort", "motor")], "traces": []}
    even = {"title": "two Cardan joints: an even ratio again", **options}
    views = {"cardan": Show(single, options), "cardan_double": Show(double, even)}
    return Outcome(tuple(rows), partial(draw, single, double), solutions, views=views)


def draw(single: Solution, double: Solution) -> Figure:
    """Ratio over one turn, harmonics, motor torque."""
    titles = ("the output runs unevenly", "harmonics of the output rate", "torque that an even input takes")
    figure, (rate, bars, torque) = new_figure("Cardan joint, shafts at 30°", titles)
    angle = RATE * single.t
    degrees, dots = np.degrees(angle), every(angle.size, 25)
    rate.plot(degrees, output_ratio(single), color=COLOURS[0], label="one joint")
    rate.plot(degrees, output_ratio(double), color=COLOURS[1], label="two joints")
    theory_dots(rate, degrees[dots], ratio(angle[dots], BEND))
    rate.set(ylabel="output rate / input rate [-]")
    spectrum_bars(bars, ORDERS, [("one joint", amplitudes(single))], harmonics(BEND))
    bars.set(xlabel="multiple of the shaft speed [-]", ylabel="amplitude / mean rate [-]", ylim=(2e-4, 0.5))
    torque.plot(degrees, single.effort("motor"), color=COLOURS[0], label="one joint")
    torque.plot(degrees, double.effort("motor"), "--", color=COLOURS[1], label="two joints")
    theory_dots(torque, degrees[dots], motor_torque(angle[dots], BEND))
    torque.set(ylabel="motor torque [N m]")
    for axes in (rate, torque):
        axes.set(xlabel="input angle [°]", xticks=np.arange(0, 361, 90))
    for axes in (rate, bars, torque):
        legend_below(axes, 3)
    return figure


demo = Exhibit(
    name="cardan",
    title="Cardan joint: an uneven ratio between shafts at an angle",
    why="In a plane all shafts are parallel and a coupling hands every angle on unchanged; two shafts that meet at an "
    "angle need space, and a cross between them trades speed four times a turn.",
    source="spherical trigonometry of the cross, tan(out) = cos(bend) tan(in); the Fourier series of the rate is the "
    "Poisson kernel with q = tan^2(bend/2)",
    make=run,
    family="Shafts out of line",
    ablation={"bend_factor": 1.01},
)
