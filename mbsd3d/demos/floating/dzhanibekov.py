"""A free body spun about its middle axis turns over, again and again, at the interval the elliptic integral gives."""

from functools import partial

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from scipy.optimize import brentq
from scipy.special import ellipkm1

from mbsd3d import Body, Solution, System, rotation, simulate
from mbsd3d.base.rotations import matrix
from mbsd3d.base.style import COLOURS, GREY, LIGHT
from mbsd3d.mechanism import shapes

from ..base import Exhibit, Outcome, Row, Show
from ..drawing import legend_below, new_figure, space

MOMENTS = (1.0, 2.0, 3.0)  # kg m^2
SPIN, OFF_AXIS = 5.0, 1e-3  # rad/s
MASS, SPEED = 1.5, (1.0, 2.0, 3.0)  # kg, m/s: flying along changes nothing
DURATION, SAMPLES = 30.0, 1501
BESIDE = np.array([2.7, 1.7, 0.0])  # m, from one body to the next in the view: across it


def spins(axis: int) -> np.ndarray:
    """Angular velocity at the start, body axes [rad/s]: ``SPIN`` about an axis, ``OFF_AXIS`` about the others."""
    return np.where(np.arange(3) == axis, SPIN, OFF_AXIS)


def flip_interval() -> float:
    """2 K(m) / p [s] for I1 < I2 < I3 and L^2 > 2 T I2, with 1 - m = (I3 - I1) D / ((I3 - I2)(L^2 - 2 T I1)).

    p^2 = (I3 - I2)(L^2 - 2 T I1) / (I1 I2 I3); D = L^2 - 2 T I2 = sum of I (I - I2) w^2, written so because the
    difference of the two large numbers has no digits left.
    """
    i = np.array(MOMENTS)
    w = spins(1)
    twice_energy, momentum_squared = i @ w**2, i**2 @ w**2
    excess = (i * (i - i[1])) @ w**2
    wide = (i[2] - i[1]) * (momentum_squared - twice_energy * i[0])
    return 2 * ellipkm1((i[2] - i[0]) * excess / wide) / np.sqrt(wide / i.prod())


def thrown(axis: int) -> System:
    """The body without forces, spun about one of its axes."""
    body = Body("body", MASS, MOMENTS, velocity=SPEED, omega=spins(axis))
    return System([body], gravity=(0, 0, 0))


def flips(solution: Solution) -> np.ndarray:
    """Times at which the spin about the body's middle axis changes its sign [s]."""

    def spin(t: float) -> float:
        state = solution.at(t)
        return float(matrix(state.q[3:7])[:, 1] @ state.v[3:6])

    t, w = solution.t, solution.omega_body("body")[:, 1]
    found = np.flatnonzero(w[:-1] * w[1:] < 0.0)
    return np.array([brentq(spin, t[k], t[k + 1], xtol=1e-12) for k in found])


def angular_momentum(solution: Solution) -> np.ndarray:
    """(samples, 3) about the centre of mass, world axes [kg m^2/s]."""
    return np.einsum("tij,tj->ti", solution.rotation("body"), solution.omega_body("body") * MOMENTS)


def tilt(solution: Solution, axis: int) -> np.ndarray:
    """Angle between a body axis and the angular momentum [degrees]."""
    L = angular_momentum(solution)
    cosine = np.einsum("ti,ti->t", solution.rotation("body")[:, :, axis], L) / np.linalg.norm(L, axis=1)
    return np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))


def run(*, gyroscopic: bool = True) -> Outcome:
    """30 s of the body spun about each of its axes."""
    runs = [simulate(thrown(k), DURATION, rtol=1e-12, output=SAMPLES, gyroscopic=gyroscopic) for k in range(3)]
    middle = runs[1]
    times, L, energy = flips(middle), angular_momentum(middle), middle.energy().kinetic
    interval = np.diff(times).mean() if times.size > 1 else np.inf
    w = spins(1)
    rows = [
        Row("interval between flips", interval, flip_interval(), 1e-7, "s"),
        Row("energy at 30 s", energy[-1], 0.5 * (MOMENTS @ w**2 + MASS * np.dot(SPEED, SPEED)), 1e-10, "J"),
    ]
    rows += [
        Row(f"angular momentum {axis} at 30 s", value, theory, 1e-10, "kg m^2/s")
        for axis, value, theory in zip("xyz", L[-1], MOMENTS * w, strict=True)
    ]
    files = {f"dzhanibekov_{name}": run for name, run in zip(("least", "", "greatest"), runs, strict=True)}
    files = {name.rstrip("_"): run for name, run in sorted(files.items(), key=lambda item: item[0] != "dzhanibekov_")}
    return Outcome(tuple(rows), partial(draw, runs, times), files, views={"dzhanibekov": in_space()})


def in_space() -> Show:
    """Three handles side by side, each spun about another axis, which is upright, at rest on the whole."""
    bar, stem = shapes.Capsule(0.16, 2.4, "x"), shapes.Capsule(0.16, 1.1, "y", at=(0, 0.75, 0))
    upright = (rotation("y", -np.pi / 2), rotation("x", np.pi / 2), rotation("z", 0.0))
    bodies = [
        Body(
            f"{name} moment", MASS, MOMENTS, position=k * BESIDE, orientation=turned, omega=matrix(turned) @ spins(k),
            shape=(bar, stem),
        )
        for k, (name, turned) in enumerate(zip(("least", "middle", "greatest"), upright, strict=True))
    ]  # fmt: skip
    solution = simulate(System(bodies, gravity=(0, 0, 0)), DURATION, rtol=1e-10, output=SAMPLES)
    curves = [("omega_body", body) for body in bodies]
    return Show(solution, {"curves": curves, "traces": [], "shown": ["angular momentum"]})


def polhodes() -> list[np.ndarray]:
    """Paths of L / L in the body for some energies: sum of l^2 / I = c on the unit sphere, (points, 3) each."""
    i, turn, paths = 1 / np.array(MOMENTS), np.linspace(0, 2 * np.pi, 121), []
    for share in (0.03, 0.25, 0.6, 0.999):
        for around, sign in ((0, 1), (0, -1), (2, 1), (2, -1)):
            other = 2 - around
            c = i[around] + share * (i[1] - i[around])
            path = np.zeros((turn.size, 3))
            path[:, 1] = np.sqrt((c - i[around]) / (i[1] - i[around])) * np.cos(turn)
            path[:, other] = np.sqrt((c - i[around]) / (i[other] - i[around])) * np.sin(turn)
            path[:, around] = sign * np.sqrt(1 - path[:, 1] ** 2 - path[:, other] ** 2)
            paths.append(path)
    return paths


def view_of(axes: Axes3D) -> np.ndarray:
    """Unit vector towards the eye."""
    up, turn = np.radians(axes.elev), np.radians(axes.azim)
    return np.array([np.cos(up) * np.cos(turn), np.cos(up) * np.sin(turn), np.sin(up)])


def in_front(axes: Axes3D, path: np.ndarray) -> np.ndarray:
    """The path with the far side of the sphere left out."""
    return np.where((path @ view_of(axes) > 0.0)[:, None], path, np.nan)


def rim(axes: Axes3D) -> np.ndarray:
    """(73, 3) the sphere's outline."""
    view, turn = view_of(axes), np.linspace(0, 2 * np.pi, 73)
    side = np.cross([0.0, 0.0, 1.0], view) / np.hypot(*view[:2])
    return np.outer(np.cos(turn), side) + np.outer(np.sin(turn), np.cross(view, side))


def draw(runs: list[Solution], times: np.ndarray) -> Figure:
    """Angular velocity, its path on the sphere of constant angular momentum, and the tilt for all three axes."""
    titles = ("spun about the middle axis", "3d:angular momentum seen from the body", "only the middle axis turns over")
    figure, (spin, sphere, tilts) = new_figure("Dzhanibekov effect: a free body, no torque at all", titles)
    middle = runs[1]
    for k, values in enumerate(middle.omega_body("body").T):
        spin.plot(middle.t, values, color=COLOURS[k], label=f"about axis {k + 1}", linewidth=1.5)
    for k in range(4 if times.size else 0):
        label = None if k else "flips in theory"
        spin.axvline(times[0] + k * flip_interval(), color=GREY, linewidth=1.0, linestyle=":", label=label)
    spin.set(xlabel="time [s]", ylabel="angular velocity, body axes [rad/s]")
    sphere.view_init(elev=25, azim=55)
    sphere.plot(*rim(sphere).T, color=GREY, linewidth=0.7)
    for path in polhodes():
        sphere.plot(*in_front(sphere, path).T, color=LIGHT.grid, linewidth=0.9)
    names = ("least", "middle", "greatest")
    for k, (solution, name, line) in enumerate(zip(runs, names, ("-", "-", "--"), strict=True)):
        L = solution.omega_body("body") * MOMENTS
        path = in_front(sphere, L / np.linalg.norm(L, axis=1, keepdims=True))
        sphere.plot(*path.T, color=COLOURS[k], linewidth=1.8)
        sphere.plot(*path[:1].T, "o", color=COLOURS[k])
        sphere.text(*path[0], f"   axis {k + 1}", color=COLOURS[k], fontsize=9)
        tilts.plot(solution.t, tilt(solution, k), line, color=COLOURS[k], label=f"{name} moment", linewidth=1.5)
    space(sphere, [f"L{k} / L [-]" for k in (1, 2, 3)])
    tilts.set(xlabel="time [s]", ylabel="spin axis to angular momentum [°]", yticks=np.arange(0, 181, 45))
    legend_below(spin, 2)
    legend_below(tilts, 2)
    return figure


demo = Exhibit(
    name="dzhanibekov",
    title="Dzhanibekov effect: the tumbling of the middle axis",
    why="In a plane w and I w are parallel, so a free body spins on for ever; in space they are not, w x I w moves the "
    "spin through the body, and about the middle axis the smallest error grows.",
    source="Landau, Lifshitz, Mechanics, par. 37 (asymmetrical top: period 4 K/p of the elliptic functions)",
    make=run,
    family="Bodies that float",
    ablation={"gyroscopic": False},
)
