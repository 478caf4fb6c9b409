"""A door on two hinges: ten rows of rank five, a motion that is certain and shares of the load that are not."""

from functools import partial

import numpy as np
from matplotlib.figure import Figure
from scipy.special import ellipj, ellipk

from mbsd3d import GROUND, Body, PointOnLine, Revolute, Solution, Spherical, System, rotation, simulate
from mbsd3d.base import inertia
from mbsd3d.base.rotations import matrix
from mbsd3d.base.style import COLOURS, GREY
from mbsd3d.mechanism import shapes

from ..base import Exhibit, Outcome, Row, Show
from ..drawing import every, legend_below, new_figure, theory_dots

MASS, WIDTH, THICKNESS, HEIGHT = 20.0, 0.9, 0.04, 2.0  # kg, m
LEAN, START = np.radians(5.0), np.radians(60.0)  # of the hinge axis from the vertical; of the door from its rest
HINGES = 0.7  # distance of each hinge from the middle [m]
GRAVITY, DURATION, SAMPLES = 9.81, 6.0, 301
LEVER = WIDTH / 2  # of the centre of mass about the hinge axis [m]
ABOUT_HINGES = MASS * (WIDTH**2 / 3 + THICKNESS**2 / 12)  # kg m^2
FREQUENCY = np.sqrt(MASS * GRAVITY * np.sin(LEAN) * LEVER / ABOUT_HINGES)  # of small swings [rad/s]
SHAPE = (
    shapes.Box((WIDTH, THICKNESS, HEIGHT)),
    shapes.Cylinder(0.015, 0.2, "y", at=(0.93 * WIDTH, 0, 0), colour=GREY),
)
AXIS = np.array([np.sin(LEAN), 0.0, np.cos(LEAN)])


def swing(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angle from the rest [rad] and rate [rad/s] after a release at START: sin(angle/2) = k cd(p t | k^2)."""
    k = np.sin(START / 2)
    sn, cn, dn, _ = ellipj(FREQUENCY * np.asarray(t, float) + ellipk(k * k), k * k)
    return 2 * np.arcsin(k * sn), 2 * k * FREQUENCY * cn


def net_force(t: np.ndarray) -> np.ndarray:
    """(samples, 3) force of both hinges together [N]: m (a - g), a on the circle of the centre of mass."""
    angle, rate = swing(t)
    out = np.outer(np.cos(angle), [np.cos(LEAN), 0, -np.sin(LEAN)]) + np.outer(np.sin(angle), [0, 1, 0])
    turning = -(FREQUENCY**2) * np.sin(angle)
    a = LEVER * (turning[:, None] * np.cross(AXIS, out) - (rate**2)[:, None] * out)
    return MASS * (a + [0, 0, GRAVITY])


def door(lean: float, *, cured: bool = False) -> System:
    """The door, its hinge axis tilted towards x, open by START; reference point on the hinge axis.

    Two revolute hinges, or (``cured``) a ball above and a point on a line below.
    """
    axis = np.array([np.sin(lean), 0.0, np.cos(lean)])
    tilted = matrix(rotation("y", lean)) @ matrix(rotation("z", START))
    moments = inertia.box(MASS, (WIDTH, THICKNESS, HEIGHT))
    leaf = Body("door", MASS, moments, com=(LEVER, 0, 0), orientation=tilted, shape=SHAPE)
    top, bottom = {"at": HINGES * axis, "name": "top"}, {"at": -HINGES * axis, "axis": axis, "name": "bottom"}
    if cured:
        return System([leaf], [Spherical(GROUND, leaf, **top), PointOnLine(GROUND, leaf, **bottom)])
    return System([leaf], [Revolute(GROUND, leaf, axis=axis, **top), Revolute(GROUND, leaf, **bottom)])


def along_axis(solution: Solution, joint: str) -> np.ndarray:
    """What a hinge carries along the axis [N]."""
    return solution.reaction(joint).force @ AXIS


def run(*, lean_factor: float = 1.0) -> Outcome:
    """Six seconds of the door as built and as cured; ``lean_factor`` tilts the axis more than theory knows."""
    system = door(lean_factor * LEAN)
    built = simulate(system, DURATION, rtol=1e-11, output=SAMPLES)
    cured = simulate(door(lean_factor * LEAN, cured=True), DURATION, rtol=1e-11, output=SAMPLES)
    found, fixed = system.check(), cured.system.check()
    net, sample = built.reaction("top", "bottom"), int(np.searchsorted(built.t, 2.0 - 1e-9))
    rows = [
        Row("rows of the joints", found.rows, 10, 0),
        Row("rank: independent rows", found.rank, 5, 0),
        Row("Gruebler's count 6 - 10", found.gruebler, -4, 0),
        Row("mobility 6 - 5", found.mobility, 1, 0),
        Row("redundant rows with the cure", fixed.redundant, 0, 0),
        Row("angle at 6 s", built.angle("top")[-1] + START, swing(DURATION)[0], 1e-9, "rad"),
    ]
    rows += [
        Row(f"both hinges together, force {axis} at 2 s", value, theory, 1e-8, "N")
        for axis, value, theory in zip("xyz", net.force[sample], net_force(built.t)[sample], strict=True)
    ]
    carried = along_axis(cured, "top")
    rows.append(Row("cured: top hinge, along the axis", carried[-1], MASS * GRAVITY * np.cos(LEAN), 1e-8, "N"))
    rows.append(Row("the net force is unique (1: yes)", net.unique, 1, 0))
    rows.append(Row("the share of one hinge is unique (1: yes)", built.reaction("top").unique, 0, 0))
    notes = (f"verdict: {found.verdict}", *(f"cure: {cure.text}" for cure in found.cures))
    solutions = {"door": built, "door_cured": cured}
    curves, shown = [("angle", "top"), ("reaction", "top", "bottom")], ["reaction force"]
    views = {"door": Show(built, {"curves": curves, "shown": shown, "traces": []})}
    return Outcome(tuple(rows), partial(draw, built, cured), solutions, notes, views)


def draw(built: Solution, cured: Solution) -> Figure:
    """Swing, net force of the hinges, and who carries the weight."""
    titles = ("the motion is certain", "so is the force of both hinges together", "what one hinge carries is not")
    figure, (motion, force, shares) = new_figure("A door on two hinges: 10 rows of rank 5", titles)
    t, dots = built.t, every(built.t.size, 25)
    motion.plot(t, np.degrees(built.angle("top") + START), color=COLOURS[0], label="computed")
    theory_dots(motion, t[dots], np.degrees(swing(t[dots])[0]), "theory (elliptic functions)")
    motion.set(ylabel="angle from the rest [°]", yticks=np.arange(-60, 61, 30))
    net = built.reaction("top", "bottom").force
    weight = np.array([0.0, 0.0, MASS * GRAVITY])
    for k, axis in enumerate(("x", "y", "z, less the weight")):
        force.plot(t, (net - weight)[:, k], color=COLOURS[k], label=axis)
        theory_dots(force, t[dots], (net_force(t[dots]) - weight)[:, k], "theory" if k == 2 else None)
    force.set(ylabel="force of both hinges on the door [N]")
    for solution, line, name in ((built, "-", "two hinges"), (cured, "--", "cured")):
        outwards = np.einsum("ti,ti->t", solution.reaction("top").force, solution.rotation("door")[:, :, 0])
        shares.plot(t, along_axis(solution, "top"), line, color=COLOURS[0], label=f"along the axis, {name}")
        shares.plot(t, outwards, line, color=COLOURS[1], label=f"outwards, {name}")
    shares.set(ylabel="force of the top hinge on the door [N]")
    for axes, columns in ((motion, 2), (force, 2), (shares, 2)):
        axes.set_xlabel("time [s]")
        legend_below(axes, columns)
    return figure


demo = Exhibit(
    name="door",
    title="two-hinge door: redundant, and still certain",
    why="In a plane a hinge takes two freedoms of three and a second one locks the door; in space five of six, and a "
    "second hinge on the same axis takes the same five again, so counting says -4 where the door turns.",
    source="physical pendulum by elliptic functions; the net force by Newton's second law, m (a - g)",
    make=run,
    family="Loops that should not move",
    ablation={"lean_factor": 1.01},
)
