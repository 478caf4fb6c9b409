"""The fast heavy top of the literature: it falls, turns aside, and comes back up."""

from functools import partial

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import ArrayLike
from scipy.special import ellipj, ellipk

from mbsd3d import GROUND, Body, Solution, Spherical, System, rotation, simulate
from mbsd3d.base.quaternions import multiply
from mbsd3d.base.style import COLOURS, GREY, LIGHT
from mbsd3d.mechanism import measures, shapes

from ..base import Exhibit, Outcome, Row, Show
from ..drawing import every, legend_below, new_figure, space, sphere_net, theory_dots

MASS, DISTANCE, INERTIA = 15.0, 1.0, (0.234375, 0.46875, 0.234375)  # kg, m, kg m^2; the body's y is its axis
SPIN, PRECESSION = 150.0, -4.61538  # rad/s at the start, axis horizontal
ABOUT_PIVOT = INERTIA[0] + MASS * DISTANCE**2  # A, transverse [kg m^2]
AXIAL, WEIGHT_MOMENT = INERTIA[1], MASS * 9.81 * DISTANCE  # C [kg m^2], m g l [N m]
AT_2_S = (-0.15041682274564178, -0.7241655916368959, -0.673022269560444)  # m, Taylor series of order 24 in 80 bits
TIP = 0.25  # m, of the stem beyond the disc, as drawn; a thin disc of 0.25 m has these moments of inertia
SHAPE = (
    shapes.Disc(0.25, 0.03, "y"),
    shapes.Cylinder(0.02, DISTANCE + TIP, "y", at=(0, 0.5 * (TIP - DISTANCE), 0), colour=GREY),
)
TILT = np.radians(75.0)  # of the steadily precessing tops, from the vertical


def steady_rates(tilt: float) -> tuple[float, float]:
    """Slow and fast steady precession [rad/s]: roots W of A W^2 cos(tilt) - C w3 W + m g l = 0."""
    larger = AXIAL * SPIN + np.sqrt((AXIAL * SPIN) ** 2 - 4 * ABOUT_PIVOT * np.cos(tilt) * WEIGHT_MOMENT)
    return 2 * WEIGHT_MOMENT / larger, larger / (2 * ABOUT_PIVOT * np.cos(tilt))


def nutation() -> tuple[float, float, float, float]:
    """Lowest and highest height u, rate and parameter of u = low + (high - low) sn^2(rate t + K | m).

    Roots of (alpha - beta u)(1 - u^2) - (b - a u)^2, with a = C w3 / A, b = W, beta = 2 m g l / A, alpha = W^2 for a
    start with a horizontal axis (u = 0); u = 0 is the highest point.
    """
    a, beta = AXIAL * SPIN / ABOUT_PIVOT, 2 * WEIGHT_MOMENT / ABOUT_PIVOT
    # u = 0 is a root, so what is left is a quadratic: beta u^2 - (alpha + a^2) u + 2 a b - beta = 0
    half, rest = 0.5 * (PRECESSION**2 + a**2) / beta, (2 * a * PRECESSION - beta) / beta
    third = half + np.sqrt(half**2 - rest)
    low = rest / third
    return low, 0.0, np.sqrt(beta * (third - low)) / 2, -low / (third - low)


def height(t: ArrayLike) -> np.ndarray:
    """Height of the centre of mass over the pivot [m]; theory."""
    low, high, rate, m = nutation()
    sn = ellipj(rate * np.asarray(t, float) + ellipk(m), m)[0]
    return DISTANCE * (low + (high - low) * sn**2)


def top(tilt: float, precession: float) -> System:
    """The top on its pivot: axis tilted from the vertical towards x, spin ``SPIN`` along it, turning about z."""
    axis = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    omega = precession * np.array([0.0, 0.0, 1.0]) + (SPIN - precession * np.cos(tilt)) * axis
    upright = multiply(rotation("y", tilt), rotation("x", np.pi / 2))
    body = Body("top", MASS, INERTIA, position=DISTANCE * axis, orientation=upright, omega=omega, shape=SHAPE)
    return System([body], [Spherical(GROUND, body, at=(0, 0, 0), name="pivot")])


def falling_top() -> System:
    """The top of the literature: axis along y at the start."""
    body = Body("top", MASS, INERTIA, position=(0, DISTANCE, 0), omega=(0, SPIN, PRECESSION), shape=SHAPE)
    return System([body], [Spherical(GROUND, body, at=(0, 0, 0), name="pivot")])


def azimuth(solution: Solution) -> np.ndarray:
    """Angle of the centre of mass about the vertical [rad], unwrapped."""
    x, y, _ = solution.com("top").T
    return np.unwrap(np.arctan2(y, x))


def run(*, gyroscopic: bool = True) -> Outcome:
    """Two seconds of the falling top and of both steady precessions."""
    settings = {"rtol": 1e-12, "gyroscopic": gyroscopic}
    falling = simulate(falling_top(), 2.0, output=801, **settings)
    body = falling.system.bodies[0]
    rising = measures.velocity(body, axis=(0, 0, 1)) > 0.0
    fall = simulate(falling.system, 1.0, state=falling.state(1), stop_when=rising, **settings)
    rates = steady_rates(TILT)
    steady = [simulate(top(TILT, rate), 2.0, output=201, **settings) for rate in rates]
    _, _, rate, m = nutation()
    rows = [
        Row(f"centre of mass {axis} at 2 s", value, theory, 1e-9, "m")
        for axis, value, theory in zip("xyz", falling.com(body)[-1], AT_2_S, strict=True)
    ]
    rows.append(Row("time of fall (half a nutation)", fall.final.t, ellipk(m) / rate, 1e-9, "s"))
    for name, solution, theory in zip(("slow", "fast"), steady, rates, strict=True):
        mean = np.ptp(azimuth(solution)) / solution.t[-1]
        rows.append(Row(f"{name} steady precession at 75 degrees", mean, theory, 1e-9, "rad/s"))
    solutions = {"heavy_top": falling, "heavy_top_slow": steady[0], "heavy_top_fast": steady[1]}
    return Outcome(
        tuple(rows), partial(draw, falling, steady, rates), solutions, views={"heavy_top": in_space(falling)}
    )


def in_space(falling: Solution) -> Show:
    """Ten times slower than life, with the path of the stem's end."""
    curves = [("com", "top"), ("reaction", "pivot")]
    tip = ("top", (0.0, DISTANCE + TIP, 0.0))
    return Show(falling, {"curves": curves, "traces": [tip], "shown": ["angular momentum"], "speed": 0.1})


def draw(falling: Solution, steady: list[Solution], rates: tuple[float, float]) -> Figure:
    """Path of the centre of mass, its height, and the azimuth of the steady precessions."""
    titles = ("3d:path of the centre of mass, 2 s", "it falls, and comes back up", "steady precession, axis at 75°")
    figure, (path, rise, turn) = new_figure("Heavy top, 150 rad/s", titles, (1.1, 1.0, 1.0))
    centre, t = falling.com("top"), falling.t
    sphere_net(path, highest=0.0)
    path.plot(*centre.T, color=COLOURS[0], linewidth=1.8)
    path.plot(*centre[:1].T, "o", color=COLOURS[1], label="start")
    path.plot([0], [0], [0], "^", color=LIGHT.ink, label="pivot")
    space(path, ("x [m]", "y [m]", "z [m]"), (2, 2, 1.1))
    path.set(zlim=(-1, 0.1), zticks=[-1, 0])
    path.legend(loc="upper left", bbox_to_anchor=(-0.1, 1.02), frameon=False, fontsize=9)
    rise.plot(t, centre[:, 2], color=COLOURS[0], label="computed")
    dots = every(t.size, 41)
    theory_dots(rise, t[dots], height(t[dots]), label="theory (elliptic functions)")
    rise.set(xlabel="time [s]", ylabel="height of the centre of mass [m]")
    for solution, rate, name, tint in zip(steady, rates, ("slow", "fast"), COLOURS, strict=False):
        turns, dots = azimuth(solution) / (2 * np.pi), every(solution.t.size, 15)
        turn.plot(solution.t, turns, color=tint, label=f"{name}, {rate:.3f} rad/s")
        theory_dots(turn, solution.t[dots], rate * solution.t[dots] / (2 * np.pi), "theory" if name == "fast" else None)
    turn.set(xlabel="time [s]", ylabel="revolutions about the vertical [-]")
    legend_below(rise, 2)
    legend_below(turn, 3)
    return figure


demo = Exhibit(
    name="heavy_top",
    title="heavy top: a falling weight that turns aside",
    why="In a plane the spin has no direction to change, so w x I w vanishes and a weight can only fall; in space its "
    "moment turns the spin axis sideways.",
    source="case: Bruls, Cardona, Arnold, Mech. Mach. Theory 48 (2012) 121-137, values at 2 s by Taylor series in 80 "
    "bits; fall: energy and two momenta, elliptic functions; steady: A W^2 cos(tilt) - C w3 W + m g l = 0",
    make=run,
    family="Tops, coins and stones",
    ablation={"gyroscopic": False},
)
