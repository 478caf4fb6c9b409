"""Two inputs reach every pose of four coordinates: a car moves sideways into a gap."""

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    KnifeEdge,
    Planar,
    Revolute,
    Sine,
    SpeedDriver,
    System,
    measures,
    shapes,
    simulate,
)

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from ..quadrature import motion

DRIVING_RATE, HALF_TRACK = 1.0, 0.9  # rad/s of driving to and fro; m between the wheels and the middle

MOTION_SHARE_MIN, SINE_MIN = (
    1e-9,
    1e-5,
)  # of the longest way: a shorter one is rounding; sine of two ways that are not the same


def mechanism(*, L=2.6, steer_deg=40.0, way=2.5, beats=2) -> System:
    """Build a car of wheelbase L [m] that drives way [m] and back in 2 pi s, its front wheels to and fro beats
    times."""
    require(beats in (1, 2), f"demo 'parking': beats = {beats}; give 2 to go sideways, 1 to turn")
    axle = shapes.Cylinder(0.05, 2 * HALF_TRACK, "y", at=(0, 0, 0.3))
    rear, ahead = (
        [wheel(side) for side in (-HALF_TRACK, HALF_TRACK)],
        [wheel(side, L) for side in (-HALF_TRACK, HALF_TRACK)],
    )
    form = [shapes.Box((1.45 * L, 1.5, 0.35), at=(0.5 * L, 0, 0.55)), shapes.Box((0.75 * L, 1.3, 0.45),
            at=(0.45 * L, 0, 0.95)), axle, *rear]  # fmt: skip
    car = Body("car", 900.0, (300.0, 1200.0, 1300.0), com=(0.5 * L, 0, 0.5), shape=form)
    front = Body("front wheels", 60.0, (4.0, 2.0, 5.0), position=(L, 0, 0), shape=[part_of(x, L) for x in ahead])
    kingpin = Revolute(car, front, at=(L, 0, 0), axis=(0, 0, 1), name="kingpin")
    joints = [
        Planar(GROUND, car, at=(0, 0, 0), normal=(0, 0, 1), name="road"),
        kingpin,
        KnifeEdge(GROUND, car, at=(0, 0, 0), heading=(1, 0, 0), name="rear wheels"),
        KnifeEdge(GROUND, front, at=(L, 0, 0), heading=(1, 0, 0), name="front tread"),
        AngleDriver(kingpin, Sine(np.radians(steer_deg), beats * DRIVING_RATE / (2 * np.pi)), name="steering wheel"),
        SpeedDriver(
            GROUND,
            car,
            at=(0, 0, 0),
            direction=(1, 0, 0),
            speed=Sine(0.5 * way * DRIVING_RATE, DRIVING_RATE / (2 * np.pi)),
            name="engine",
        ),
    ]
    return System([car, front], joints, gravity=(0, 0, 0))


def wheel(side, along=0.0):
    """Draw a wheel beside the middle."""
    return shapes.Cylinder(0.3, 0.2, "y", at=(along, side, 0.3))


def part_of(form, along):
    """Return a shape about a reference point further on."""
    return shapes.Cylinder(form.radius, form.length, form.axis, at=np.asarray(form.at) - (along, 0, 0))


def own(times, *, L, steer_deg, way, beats):
    """Integrate x, y of the rear axle and heading: x' = v cos f, y' = v sin f, f' = v tan(d) / L, shape (times, 3)."""

    def rate(t, y):
        v, turn = (
            0.5 * way * DRIVING_RATE * np.sin(DRIVING_RATE * t),
            np.tan(np.radians(steer_deg) * np.sin(beats * DRIVING_RATE * t)) / L,
        )
        return [v * np.cos(y[2]), v * np.sin(y[2]), v * turn]

    return motion(rate, np.zeros(3), times)


def theory(*, L, steer_deg, way, beats):
    """Integrate own equations over one period; of four coordinates the brackets of driving and steering reach all."""
    require(
        abs(steer_deg) < 80, f"demo 'parking': steer_deg = {steer_deg:g}; wheels across do not roll, give less than 80"
    )
    x, y, turn = own(np.array([0, 2 * np.pi / DRIVING_RATE]), L=L, steer_deg=steer_deg, way=way, beats=beats)[-1]
    reached = 4 if steer_deg and way else int(bool(steer_deg)) + int(bool(way))
    return {"sideways_m": y, "ahead_m": x, "turned_deg": np.degrees(turn), "velocities": 2, "coordinates": 4,
            "reached": reached}  # fmt: skip


def measure(build, terms, *, L, steer_deg, way, beats) -> Measured:
    """Measure a period, the count of `check` for the car without drivers, and the poses after four motions."""
    system, period = build(), 2 * np.pi / DRIVING_RATE
    run = simulate(system, period, rtol=1e-12, output=401, **terms)
    free = System(system.bodies, system.joints[:4], gravity=(0, 0, 0)).check()
    exact = {"rtol": 1e-12, **terms}  # brackets of small motions are small beside them
    moves = [pose(simulate(build(beats=2, steer_deg=0.0), period / 2, **exact)),
             pose(simulate(build(beats=2, way=0.0), period / 8, **exact)),
             *(pose(simulate(build(beats=k), period, **exact)) for k in (1, 2))]  # fmt: skip
    sizes = [np.linalg.norm(move) for move in moves]
    ways = [move / size for move, size in zip(moves, sizes, strict=True) if size > MOTION_SHARE_MIN * max(sizes)]
    end = pose(run)
    x, y, _ = np.transpose(run.position("car"))
    known = own(run.t, L=L, steer_deg=steer_deg, way=way, beats=beats)
    track = Curve("sideways [m]", x, y, (known[::8, 0], known[::8, 1]), "ahead [m]", "way of the rear axle")
    values = {"sideways_m": end[1], "ahead_m": end[0], "turned_deg": np.degrees(end[2]), "velocities": free.mobility,
              "coordinates": free.configuration_freedom,
              "reached": np.linalg.matrix_rank(ways, tol=SINE_MIN) if ways else 0}  # fmt: skip
    return Measured(values, [run], [track])


def pose(run):
    """Return (x, y, heading, steering angle) of the car at the end."""
    heading = run.measure(measures.heading(run.system.part("car")))[-1]
    return np.array([*run.position("car")[-1][:2], heading.item(), run.angle("kingpin")[-1]])


demo = Demo(
    __name__,
    title="Parking by brackets",
    question="How does a car get sideways into a gap although its wheels do not slip sideways?",
    beats=(
        Beat(0.0, "Steered to one side and driven ahead, to the other and back."),
        Beat(share(0.5), "Ahead, and turned."),
        Beat(share(1.0), "Back where it was, and 75 cm beside."),
    ),
    why="At every moment a car has two degrees of freedom only, driving and steering, and yet no pose is out of its "
    "reach: forbidden velocities are not forbidden places. Drive to and fro while the front wheels go to and fro once, "
    "and the car has turned; let them go twice, and it stands beside where it was. These are the Lie brackets of the "
    "two motions, and each adds a direction: two, three, four of the four coordinates (growth 2-3-4). Without the rows "
    "of the wheels, which no coordinate feels, counting finds four degrees of freedom; with them two.",
    equation="x' = v cos phi; y' = v sin phi; phi' = v tan delta / L",
    symbols={
        "y": Symbol("aside", "m", curve=(1, 1)),
        "phi": Symbol("heading", "rad"),
        "delta": Symbol("steer", "rad", curve=(0, 0)),
        "v": Symbol("speed", "m/s"),
        "L": Symbol("wheelbase", "m", "L"),
    },
    source="Murray, Sastry, IEEE Trans. Automatic Control 38 (1993) 700; Laumond, Robot Motion Planning and Control",
    quantities={
        "sideways_m": Quantity("moved sideways in a period", "m"),
        "ahead_m": Quantity("moved ahead", "m"),
        "turned_deg": Quantity("turned", "deg"),
        "velocities": Quantity("degrees of freedom of velocity", absolute=0.0, relative=0.0),
        "coordinates": Quantity("coordinates the wheels leave", absolute=0.0, relative=0.0),
        "reached": Quantity("of them reached with brackets", absolute=0.0, relative=0.0),
    },
    ablation=Ablation("steering", "with the front wheels straight it comes back to where it was", {"steer_deg": 0.0}),
    against=Against("steer_deg", 0.0, 45.0, "steering angle [deg]"),
    show={"curves": [("angle", "kingpin"), ("position", "car")], "traces": [("car", (0, 0, 0)),
          ("front wheels", (2.6, 0, 0))], "follow": GROUND},
    ranges={"beats": None},
    sliders=(
        Control("steer_deg", 5.0, 60.0, "deg", "steering"),
        Control("way", 0.5, 4.0, "m", "way of a stroke"),
    ),
    theory_moves=False,
    attempt="make the strokes short: the car goes sideways by their square, so short strokes gain little.",
)  # fmt: skip
