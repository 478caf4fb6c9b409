"""Two discs pushed into each other at right angles roll on a table: at one distance their middle stays level."""

import numpy as np

from mbsd3d import GROUND, Body, RollingDisc, System, rotation, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

G = 9.81  # m/s^2
T_END, SAMPLES = 3.0, 901  # [s] of the run
HALF = np.sqrt(0.5)


def mechanism(*, m=0.4, r=0.1, apart=1.4142135623730951, w=6.0) -> System:
    """Build two discs of r [m], together m [kg], in planes at right angles, their centres ``apart`` radii apart; both
    stand at 45 degrees and roll at w [rad/s] about the line between their contacts.
    """
    require(apart > 0.0, f"demo 'two_circle_roller': apart = {apart:g}; give a distance above 0")
    half, disc = 0.5 * apart * r, 0.5 * m
    moments = (0.5 * disc * r**2, *2 * (0.75 * disc * r**2 + 2 * disc * half**2,))
    form = (
        shapes.Disc(r, 0.06 * r, "y", at=(-half, 0, 0), colour="darkorange"),
        shapes.Disc(r, 0.06 * r, "z", at=(half, 0, 0), colour="steelblue"),
    )
    contacts = np.array([(-half, HALF * r, 0.0), (half, -HALF * r, 0.0)])
    line = contacts[1] - contacts[0]
    omega = w * line / np.linalg.norm(line)
    middle = np.array([0.0, 0.0, HALF * r])
    body = Body("roller", m, moments, position=middle, orientation=rotation("x", np.pi / 4), omega=omega,
                velocity=np.cross(omega, middle - contacts[0]), shape=form)  # fmt: skip
    discs = [RollingDisc(GROUND, body, centre=middle + (x, 0, 0), axis=body.axes[:, k], radius=r, name=name)
             for x, k, name in ((-half, 1, "orange disc"), (half, 2, "blue disc"))]  # fmt: skip
    return System([body], discs, gravity=(0, 0, -G))


def height(u, r, apart):
    """Return the height of the middle [m] where the line of the centres rises by the sine u.

    Each centre is r times the sine of its disc's slope high, p and q: p^2 + q^2 = 1 + u^2 and apart u = q - p.
    """
    return 0.5 * r * np.sqrt(2.0 + (2.0 - apart**2) * np.asarray(u) ** 2)


def theory(*, r, apart):
    """Return the heights where the line of the centres lies level and where one disc stands upright, u = 1/(1 +
    apart).
    """
    level, upright = height(0.0, r, apart), height(1.0 / (1.0 + apart), r, apart)
    return {"rise_mm": 1e3 * (upright - level), "level_mm": 1e3 * level, "freedoms": 1.0}


def measure(build, terms, *, r, apart) -> Measured:
    """Measure the height of the middle over some rolls."""
    system = build()
    run = simulate(system, T_END, output=SAMPLES, rtol=1e-11, **terms)
    z, u = run.position("roller")[:, 2], run.rotation("roller")[:, 2, 0]
    steepest = np.flatnonzero((np.abs(u[1:-1]) >= np.abs(u[:-2])) & (np.abs(u[1:-1]) >= np.abs(u[2:])))
    require(steepest.size > 0, "demo 'two_circle_roller': it does not roll over; give more w")
    top = np.array([extreme(z[k : k + 3]) for k in steepest])
    values = {
        "rise_mm": 1e3 * (top.mean() - z[0]), "level_mm": 1e3 * z[0],
        "freedoms": float(system.check().mobility),
    }  # fmt: skip
    curves = [
        Curve("height of the middle [mm]", run.t, 1e3 * z, (run.t, 1e3 * height(u, r, apart)), scale=0.0),
        Curve("y [m]", run.position("roller")[:, 0], run.position("roller")[:, 1], along="x [m]", equal=True,
              title="way of the middle, from above"),
    ]  # fmt: skip
    return Measured(values, [run], curves)


def extreme(three):
    """Return the extreme of the parabola through three values at equal steps."""
    a, b = 0.5 * (three[0] - 2 * three[1] + three[2]), 0.5 * (three[2] - three[0])
    return three[1] - b * b / (4 * a) if abs(a) > 1e-12 else three[1]


demo = Demo(
    __name__,
    title="The roller that staggers on the level",
    question="How can two discs pushed into each other at right angles roll without going up and down?",
    beats=(
        Beat(0.0, "Two discs, each cut into the other at a right angle."),
        Beat(share(0.5), "It staggers along ..."),
        Beat(share(1.0), "... and its middle stays at one height."),
    ),
    why="Both discs touch the table at all times, so the height of each centre is given by the slope of its disc, and "
    "the slopes of both by how the line between the centres leans. Their mean rises or sinks as this line leans, by a "
    "term with 2 - (d/r)^2. At d = sqrt(2) r the term is gone: the roller staggers from disc to disc like a drunkard, "
    "and its middle stays level.",
    equation="h = (r/2) sqrt(2 + (2 - d^2/r^2) u^2); u up to 1/(1 + d/r)",
    symbols={
        "h": Symbol("height of the middle", "m", curve=(0, 2)),
        "r": Symbol("radius of a disc", "m", "r"),
        "d": Symbol("distance of the centres", "m", lambda r, apart: r * apart),
        "u": Symbol("how far the line of the centres leans"),
    },
    source="A. T. Stewart, Two-circle roller, American Journal of Physics 34 (1966); the height worked out here",
    quantities={
        "rise_mm": Quantity("rise of the middle", "mm", relative=1e-5, absolute=1e-5),
        "level_mm": Quantity("height of the middle where the line lies level", "mm"),
        "freedoms": Quantity("freedoms of both discs on the table"),
    },
    ablation=Ablation("right distance", "with the centres one radius apart it goes up and down", {"apart": 1.0}),
    against=Against("apart", 1.0, 1.6, "distance of the centres over the radius [-]"),
    show={"curves": [("position", "roller")], "traces": ["roller"], "view": (-60, 25), "hidden": ["joint names"]},
    ranges={"apart": (1.1, 1.6)},
    sliders=(
        Control("apart", 1.0, 1.6, "", "distance over radius"),
        Control("w", 3.0, 8.0, "rad/s", "speed"),
    ),
    attempt="move the discs to another distance: the middle goes up and down. It stays level at 1.414 alone.",
)  # fmt: skip
