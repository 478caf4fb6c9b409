"""The wall of shame: what is lost with each term one may forget, in numbers."""

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import ArrayLike

from mbsd3d import GROUND, Body, Revolute, Solution, Spherical, State, System, simulate
from mbsd3d.base.quaternions import H
from mbsd3d.base.style import COLOURS, GREY, LIGHT
from mbsd3d.mechanism import shapes

from ..base import Exhibit, Outcome, Row, Show
from ..drawing import every, legend_below, new_figure, plain_decades, theory_dots
from ..shafts import crank

TURN = 2 * np.pi  # rad/s: one revolution per second
MOMENTS, SPIN = np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 2.0])  # of the free body [kg m^2, rad/s]
ARM = 0.5  # m, centre of mass of the flywheel from its hinge
WHEEL = (
    shapes.Disc(0.25, 0.06),
    shapes.Cylinder(0.03, ARM, "x", at=(-0.5 * ARM, 0, 0)),
    shapes.Torus(0.07, 0.02, at=(-ARM, 0, 0)),
)
GAP = 1e-3  # m, opened on purpose
A, B = 20.0, 100.0  # Baumgarte's factors [1/s, 1/s^2]: both roots at -10/s
STEPS = 200  # of the quaternion's integration
SWITCHES: dict[str, dict] = {
    "all terms": {},
    "gyroscopic": {"gyroscopic": False},
    "centripetal": {"centripetal": False},
    "gamma": {"gamma": False},
    "none": {"stabilisation": "none"},
    "baumgarte": {"stabilisation": "baumgarte", "baumgarte": (A, B)},
}


def free_body() -> System:
    """A body without forces, turning about an axis that is not principal."""
    return System([Body("body", 1.0, MOMENTS, omega=SPIN, shape="box")], gravity=(0, 0, 0))


def flywheel() -> System:
    """A body on a hinge, its centre of mass off the axis, at one revolution per second; no gravity."""
    wheel = Body("wheel", 1.0, (0.1, 0.1, 0.1), position=(ARM, 0, 0), omega=(0, 0, TURN), shape=WHEEL)
    return System([wheel], [Revolute(GROUND, wheel, at=(0, 0, 0), axis=(0, 0, 1), name="hinge")], gravity=(0, 0, 0))


def top() -> System:
    """A fast top, its reference point between pivot and centre of mass: every term of the equations is at work."""
    moments = (0.234375, 0.46875, 0.234375)
    body = Body("top", 15.0, moments, position=(0, 0.5, 0), com=(0, 0.5, 0), omega=(0, 150, -4.61538))
    return System([body], [Spherical(GROUND, body, at=(0, 0, 0), name="pivot")])


def lost_momentum() -> float:
    """Change of L without w x I w in half a revolution about the constant w: twice its part across w [kg m^2/s]."""
    L = MOMENTS * SPIN
    return float(2 * np.linalg.norm(L - (L @ SPIN) / (SPIN @ SPIN) * SPIN))


def drifted(t: np.ndarray) -> np.ndarray:
    """Gap of the flywheel's hinge without -J_dot v [m]: the centre of mass flies straight on while the wheel turns."""
    angle = TURN * t
    return ARM * np.hypot(1 - np.cos(angle), angle - np.sin(angle))


def closing(t: np.ndarray) -> np.ndarray:
    """Gap under Baumgarte's c_ddot + 2 (10/s) c_dot + (10/s)^2 c = 0, opened by GAP at rest [m]."""
    return GAP * (1 + 0.5 * A * t) * np.exp(-0.5 * A * t)


def opened(stabilisation: str) -> Solution:
    """1 s of the flywheel with its hinge a millimetre apart, at rest, at the start."""
    system = flywheel()
    start = system.state()
    apart = State(start.t, start.q + GAP * np.eye(7)[0], start.v)
    return simulate(
        system, 1.0, state=apart, rtol=1e-12, output=51, stabilisation=stabilisation, baumgarte=(A, B), as_built=2 * GAP
    )  # fmt: skip


def hinge_gap(solution: Solution) -> np.ndarray:
    """Distance of the wheel's hinge point from the axis [m]."""
    return np.linalg.norm(solution.point("wheel", (-ARM, 0, 0)), axis=1)


def quaternions(h_dot: bool) -> np.ndarray:
    """(STEPS + 1, 4) from e_ddot = (H w_dot + H_dot w) / 2 by RK4, constant w, one revolution in 1 s."""
    w, e = np.array([0.0, 0.0, TURN]), np.array([1.0, 0.0, 0.0, 0.0])

    def rate(y: np.ndarray) -> np.ndarray:
        return np.concatenate([y[4:], 0.5 * H(y[4:]) @ w if h_dot else np.zeros(4)])

    path, dt = [np.concatenate([e, 0.5 * H(e) @ w])], 1.0 / STEPS
    for _ in range(STEPS):
        y = path[-1]
        k1 = rate(y)
        k2 = rate(y + 0.5 * dt * k1)
        k3 = rate(y + 0.5 * dt * k2)
        path.append(y + dt / 6 * (k1 + 2 * k2 + 2 * k3 + rate(y + dt * k3)))
    return np.array(path)[:, :4]


def rotation_angle(e: np.ndarray) -> np.ndarray:
    """Rotation angles of quaternions about z [degrees], 0 ... 360."""
    return np.degrees(2 * np.arctan2(e[:, 3], e[:, 0]))


def ghost_angle(turns: ArrayLike) -> np.ndarray:
    """Angle of e = (1, w t / 2), what a constant e_dot leads to [degrees]: 2 atan(pi turns)."""
    return np.degrees(2 * np.arctan(np.pi * np.asarray(turns)))


def run(*, gyroscopic: bool = False, centripetal: bool = False, gamma: bool = False, h_dot: bool = False) -> Outcome:
    """What goes wrong without each term; a term set to True is kept, and the theory of its loss is not met."""
    free = simulate(free_body(), np.pi / 3, rtol=1e-12, output=51, gyroscopic=gyroscopic)
    engine = crank.one_turn(centripetal)
    flying = simulate(flywheel(), 1.0, rtol=1e-12, output=51, gamma=gamma, stabilisation="none")
    opened_by = {name: opened(name) for name in ("none", "baumgarte", "projection")}
    e = quaternions(h_dot)
    L, energy = free.momentum().angular, free.energy().total
    shaking = crank.amplitudes(crank.block_load(engine)[0][:, 2])[0]
    rows = [
        Row("no w x I w: change of energy, half a turn", energy[-1] - energy[0], 0.0, 1e-10, "J"),
        Row("no w x I w: change of angular momentum", np.linalg.norm(L[-1] - L[0]), lost_momentum(), 1e-10, "N m s"),
        Row("no m w x (w x s): crank 1x (true: 10.966)", shaking, crank.harmonics(centripetal=False)[0], 1e-9, "N"),
        Row("no -J_dot v: gap of a hinge after one turn", hinge_gap(flying)[-1], drifted(flying.t)[-1], 1e-9, "m"),
        *(
            Row(f"1 mm gap after 1 s, {name}", hinge_gap(solution)[-1], theory, 1e-12, "m")
            for (name, solution), theory in zip(opened_by.items(), (GAP, closing(1.0), 0.0), strict=True)
        ),
        Row("no H_dot: angle of one turn (true: 360)", rotation_angle(e)[-1], ghost_angle(1.0), 1e-9, "deg"),
        Row("no H_dot: length of e (true: 1)", np.linalg.norm(e[-1]), np.hypot(1, np.pi), 1e-9),
    ]
    tops = {name: simulate(top(), 2.0, output=201, **changes) for name, changes in SWITCHES.items()}
    files = {f"wall_{name}": solution for name, solution in tops.items() if name != "all terms"}
    files = {"wall": tops["all terms"], **files, "wall_free_body": free, "wall_crank": engine, "wall_flywheel": flying}
    files |= {f"wall_gap_{name}": solution for name, solution in opened_by.items()}
    left = {"title": "without -J_dot v: the wheel leaves its hinge"}
    left |= {"curves": [("com", "wheel"), "drift"], "traces": [("wheel", (0, 0, 0)), ("wheel", (ARM, 0, 0))]}
    astray = {"title": "without w x I w: the angular momentum of a free body turns with it"}
    astray |= {"curves": ["momentum", "energy"], "shown": ["angular momentum", "angular velocity"]}
    views = {"wall": Show(flying, left), "wall_free_body": Show(free, astray)}
    return Outcome(tuple(rows), partial(draw, tops, flying, opened_by, e), files, views=views)


def draw(tops: dict[str, Solution], flying: Solution, opened_by: dict[str, Solution], e: np.ndarray) -> Figure:
    """Which check sees which loss, gaps of the hinge, and the quaternion without H_dot."""
    titles = ("which check of the certificate sees it", "gap of a hinge at one turn per second", "quaternion, one turn")
    figure, (table, gaps, turn) = new_figure("The wall: what each dropped term breaks", titles, (1.25, 1.0, 1.0))
    draw_table(table, tops)
    gaps.plot(flying.t[1:], hinge_gap(flying)[1:], color=COLOURS[1], label="no -J_dot v")
    some = every(flying.t.size, 13)
    theory_dots(gaps, flying.t[some][1:], drifted(flying.t[some])[1:])
    names = {"none": "no stabilisation", "baumgarte": "Baumgarte", "projection": "projection"}
    for (name, solution), tint in zip(opened_by.items(), (COLOURS[3], COLOURS[0], COLOURS[2]), strict=True):
        gaps.plot(solution.t, np.maximum(hinge_gap(solution), 1e-18), color=tint, label=f"1 mm apart, {names[name]}")
    theory_dots(gaps, flying.t[some], np.full(some.size, GAP), None)
    theory_dots(gaps, flying.t[some], closing(flying.t[some]), None)
    gaps.set(yscale="log", ylim=(1e-19, 10), xlabel="time [s]", ylabel="gap [m]")
    plain_decades(gaps, ":.0e")
    time = np.linspace(0.0, 1.0, STEPS + 1)
    turn.plot(time, 360 * time, color=GREY, linestyle="--", label="true angle")
    turn.plot(time, rotation_angle(e), color=COLOURS[0], label="angle without H_dot")
    some = every(time.size, 13)
    theory_dots(turn, time[some], ghost_angle(time[some]))
    turn.set(xlabel="time [s]", ylabel="rotation angle [°]", ylim=(0, 400), yticks=np.arange(0, 361, 90))
    length = turn.twinx()
    length.plot(time, np.linalg.norm(e, axis=1), color=COLOURS[1], label="|e| without H_dot")
    theory_dots(length, time[some], np.hypot(1, np.pi * time[some]), None)
    length.set(ylim=(0, 4))
    length.set_ylabel("|e| [-], 1 for a rotation", color=COLOURS[1])
    length.spines["top"].set_visible(False)
    legend_below(gaps, 2)
    legend_below(turn, 2, length)
    return figure


def draw_table(axes: Axes, tops: dict[str, Solution]) -> None:
    """Errors of the checks (columns) under each switch (rows), orange where the check fails."""
    certificates = {name: solution.certificate for name, solution in tops.items()}
    names = [check.name for check in certificates["all terms"].checks]
    labels = {"all terms": "all terms", "gyroscopic": "no w × I w", "centripetal": "no m w × (w × s)"}
    labels |= {"gamma": "no -J_dot v", "none": "no stabilisation", "baumgarte": "Baumgarte"}
    for i, certificate in enumerate(certificates.values()):
        for j, check in enumerate(certificate.checks):
            tint = LIGHT.good if check.passed else LIGHT.bad
            axes.fill([j, j + 1, j + 1, j], [i, i, i + 1, i + 1], color=tint, edgecolor=LIGHT.paper, linewidth=2)
            weight = "normal" if check.passed else "bold"
            axes.text(j + 0.5, i + 0.5, f"{check.error:.0e}", ha="center", va="center", fontsize=8, weight=weight)
    axes.set(xlim=(0, len(names)), ylim=(len(certificates), 0))
    axes.set_xticks(np.arange(len(names)) + 0.5, names, rotation=35, ha="right", fontsize=9)
    axes.set_yticks(np.arange(len(certificates)) + 0.5, [labels[name] for name in certificates], fontsize=9)
    axes.set_xlabel("error of the check [-], bold: too large")
    axes.tick_params(length=0)
    axes.grid(False)
    axes.spines[:].set_visible(False)


demo = Exhibit(
    name="wall",
    title="the wall: what each forgotten term breaks",
    why="All of these terms vanish in a plane for a body on its centre of mass; in space, and off it, each one that is "
    "dropped looks right to some check and is caught by another.",
    source="closed forms for constant w, in the docstrings of this file",
    make=run,
    family="What forgotten terms break",
    ablation={"gyroscopic": True, "centripetal": True, "gamma": True, "h_dot": True},
)
