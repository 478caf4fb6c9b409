"""Heavy top on a fixed point: it falls, turns aside, and rises again."""

import numpy as np
from scipy.special import ellipk

from mbsd3d import GROUND, Body, Spherical, System, measures, rotation, shapes, simulate

from ..figure import Drawn, Line, Path
from ..form import GRAVITY, Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..panel_drawing import sphere_net
from ..quadrature import cross, motion

G = 9.81  # m/s^2
TIP_RATIO = 0.25  # [1] of the stem beyond the disc, in lengths


def mechanism(*, m=15.0, l=1.0, It=0.234375, I3=0.46875, spin=237.0, precession=0.0, tilt_deg=60.0) -> System:
    """Build a top m [kg] with moments (It, It, I3) [kg m^2], the axis its y, centre of mass l [m] from the pivot;
    ``spin`` is along the axis in all, ``precession`` about the vertical [rad/s], the axis tilted from it towards y.
    """
    tilt = np.radians(tilt_deg)
    axis = np.array([0.0, np.sin(tilt), np.cos(tilt)])
    omega = precession * np.array([0.0, 0.0, 1.0]) + (spin - precession * np.cos(tilt)) * axis
    shape = (
        shapes.Disc(0.25 * l, 0.12 * l, "y"),
        shapes.Cylinder(0.03 * l, (1 + TIP_RATIO) * l, "y", at=(0, 0.5 * (TIP_RATIO - 1) * l, 0), colour="peru"),
    )
    top = Body(
        "top", m, (It, I3, It), position=l * axis, orientation=rotation("x", np.pi / 2 - tilt), omega=omega, shape=shape
    )
    return System([top], [Spherical(GROUND, top, at=(0, 0, 0), name="pivot")], gravity=(0, 0, -G))


def steady_rates(tilt, A, C, spin, weight):
    """Return slow and fast steady precession [rad/s]: roots W of A W^2 cos(tilt) - C w3 W + m g l = 0."""
    square = (C * spin) ** 2 - 4 * A * np.cos(tilt) * weight
    require(square > 0, f"demo 'heavy_top': spin = {spin:g} rad/s is too slow to precess steadily; give more")
    larger = C * spin + np.copysign(np.sqrt(square), spin)
    return 2 * weight / larger, larger / (2 * A * np.cos(tilt))


def nutation(tilt, A, C, spin, precession, weight):
    """Return rate and parameter of u = low + (u0 - low) sn^2(rate t + K | m), the height of the axis from u0 =
    cos(tilt) on.

    Roots of (alpha - beta u)(1 - u^2) - (b - a u)^2, with a = C w3 / A, beta = 2 m g l / A, and of the start
    b = W sin(tilt)^2 + a u0, alpha = W^2 sin(tilt)^2 + beta u0. One is u0, the highest point, so what is left is a
    quadratic: beta u^2 + (beta u0 - alpha - a^2) u + 2 a b - beta + u0 (beta u0 - alpha - a^2) = 0.
    """
    a, beta, top, square = C * spin / A, 2 * weight / A, np.cos(tilt), np.sin(tilt) ** 2
    between = -(a**2) - precession**2 * square  # beta u0 - alpha - a^2
    half, rest = -0.5 * between / beta, (2 * a * (precession * square + a * top) - beta + top * between) / beta
    third = half + np.sqrt(half**2 - rest)
    low = rest / third
    require(low < top, f"demo 'heavy_top': precession = {precession:g} rad/s lifts the top at the start; give less")
    return np.sqrt(beta * (third - low)) / 2, (top - low) / (third - low)


def path(times, *, m, l, It, I3, spin, precession, tilt_deg):
    """Integrate the centre of mass [m]: e'' = -e'.e' e + (C w3 / A) e x e' + (F - (e.F) e) l / A, shape (times, 3)."""
    A, F, tilt = It + m * l**2, -m * G * l, np.radians(tilt_deg)

    def rate(_, y):
        e, de = y[:3].tolist(), y[3:].tolist()
        turned, inwards = cross(e, de), -sum(x * x for x in de) - e[2] * F / A
        return [*de, *(inwards * e[k] + I3 * spin / A * turned[k] + (F / A if k == 2 else 0.0) for k in range(3))]

    start = np.array([0, np.sin(tilt), np.cos(tilt), -precession * np.sin(tilt), 0, 0])
    return l * motion(rate, start, times)[:, :3]


def falling(*, m, l, It, I3, spin, precession, tilt_deg, t):
    """Return the position at t by own equations of the axis, half a nutation by an elliptic integral."""
    require(0 < tilt_deg < 180, f"demo 'heavy_top': tilt_deg = {tilt_deg:g} does not lie between 0 and 180")
    rate, k = nutation(np.radians(tilt_deg), It + m * l**2, I3, spin, precession, m * G * l)
    start = {"m": m, "l": l, "It": It, "I3": I3, "spin": spin, "precession": precession, "tilt_deg": tilt_deg}
    place = path(np.array([0.0, t]), **start)[-1]
    return dict(zip(("x_m", "y_m", "z_m"), place, strict=True)) | {"fall_s": ellipk(k) / rate}


def theory(*, m, l, It, I3, spin, precession, tilt_deg, steady_tilt_deg, t):
    """Return `falling`, and steady precession by its quadratic equation."""
    rates = steady_rates(np.radians(steady_tilt_deg), It + m * l**2, I3, spin, m * G * l)
    named = dict(zip(("slow_precession_rad_s", "fast_precession_rad_s"), rates, strict=True))
    fall = falling(m=m, l=l, It=It, I3=I3, spin=spin, precession=precession, tilt_deg=tilt_deg, t=t)
    return fall | named


def without_spin(*, m, l, It, I3, precession, tilt_deg, t):
    """Return the motion of a pendulum that falls from the same start; nothing holds it up steadily."""
    fall = falling(m=m, l=l, It=It, I3=I3, spin=0.0, precession=precession, tilt_deg=tilt_deg, t=t)
    return {**fall, "slow_precession_rad_s": np.inf, "fast_precession_rad_s": np.inf}


def measure(build, terms, *, m, l, It, I3, spin, precession, tilt_deg, steady_tilt_deg=75.0, t=5.0) -> Measured:
    """Measure the falling top at t, its first turning point, and the mean rate of both steady precessions.

    Without spin there are none: their rates are infinite then.
    """
    settings, A = {"rtol": 1e-12, **terms}, It + m * l**2
    top = build()
    run = simulate(top, t, output=401 + int(abs(spin) * t), **settings)  # a sample a radian, as films need them
    rising = measures.velocity(top.bodies[0], axis=(0, 0, 1)) > 0.0
    fall = simulate(top, 10 * t, state=run.state(1), stop_when=rising, **settings)
    rates = steady_rates(np.radians(steady_tilt_deg), A, I3, spin, m * G * l) if spin else ()
    tilts = {"tilt_deg": steady_tilt_deg}
    steady = [
        simulate(build(precession=rate, **tilts), t, output=201 + int(abs(rate) * t), **settings) for rate in rates
    ]  # two samples a radian at the least, so that turns are counted
    turns = [np.unwrap(np.arctan2(*each.com("top").T[1::-1])) for each in steady]
    means = [(turn[-1] - turn[0]) / t for turn in turns] or [np.inf, np.inf]
    centre = run.com("top")
    names = ("x_m", "y_m", "z_m", "fall_s", "slow_precession_rad_s", "fast_precession_rad_s")
    values = dict(zip(names, (*centre[-1], fall.final.t, *means), strict=True))
    start = {"m": m, "l": l, "It": It, "I3": I3, "spin": spin, "precession": precession, "tilt_deg": tilt_deg}
    known = path(run.t[::20], **start)
    curves: list[Drawn] = [
        Path(("x / l [-]", "y / l [-]", "z / l [-]"), centre / l, "path of the centre of mass",
             net=sphere_net(), box=(2, 2, 2), heights=(-1, 1)),
        Curve("height of the centre of mass [m]", run.t, centre[:, 2], (run.t[::20], known[:, 2]),
              title="it falls, and comes back up"),
    ]  # fmt: skip
    if steady:
        paths = [(turn - turn[0]) / (2 * np.pi) for turn in turns]
        slow, fast = (
            Line(f"{name}, {rate:.3f} rad/s", way, one.t, (one.t, rate * one.t / (2 * np.pi)))
            for name, rate, way, one in zip(("slow", "fast"), rates, paths, steady, strict=True)
        )
        curves.append(
            Curve("revolutions about the vertical [-]", steady[0].t, slow.y, slow.theory, name=slow.name, more=[fast],
                  title=f"steady precession, axis at {steady_tilt_deg:g} deg")
        )  # fmt: skip
    return Measured(values, [run, *steady], curves)


def show(*, l, tilt_deg):
    """Return how it is shown: with the path of the upper end of the stem."""
    tilt = np.radians(tilt_deg)
    tip = (1 + TIP_RATIO) * l * np.array([0.0, np.sin(tilt), np.cos(tilt)])
    return {"curves": [("com", "top"), ("reaction", "pivot")], "traces": [("top", tip)], "speed": 0.5,
            "shown": ["angular momentum"], "view": (-60, 35)}  # fmt: skip


demo = Demo(
    __name__,
    title="Heavy top: a falling weight that turns aside",
    question="Why does a spinning top fall a little, turn aside, and come back up?",
    beats=(
        Beat(0.0, "Let go, it begins to fall."),
        Beat(0.4733, "Here it has turned aside, and falls no lower."),
        Beat(0.9465, "Here it is up again, a step farther round."),
        Beat(4.73, "Five such steps, and it is round."),
    ),
    why="In a plane the spin has no direction to change, so w x I w vanishes and a weight can only fall. In space the "
    "moment of the weight turns the spin axis sideways. Released with another rate than a steady one the top falls "
    "until its sideways motion holds it, and comes back up: it nutates. With the right rate, and there are two, "
    "it goes round at a constant height.",
    equation="A W^2 cos(tilt) - C w_3 W + m g l = 0; u_dot^2 = (alpha - beta u)(1 - u^2) - (b - a u)^2",
    symbols={
        "A": Symbol("moment across, at the pivot", "kg m^2", lambda m, l, It: It + m * l**2),
        "C": Symbol("moment along the axis", "kg m^2", "I3"),
        "w_3": Symbol("spin about the axis", "rad/s", "spin", arrow="angular momentum"),
        "W": Symbol("rate at which it goes round", "rad/s"),
        "m": Symbol("top", "kg", "m"),
        "g": GRAVITY,
        "l": Symbol("from the pivot to the centre of mass", "m", "l"),
        "u": Symbol("cosine of the tilt; the height of the centre of mass is l u", "m", curve=(0, 2)),
        "a": Symbol("C w_3/A", "rad/s", lambda m, l, It, I3, spin: I3 * spin / (It + m * l**2)),
        "b": Symbol("angular momentum about the vertical, over A", "rad/s"),
        "alpha": Symbol("from the energy", "1/s^2"),
        "beta": Symbol("2 m g l/A", "1/s^2", lambda m, l, It: 2 * m * 9.81 * l / (It + m * l**2)),
    },
    source="case: Bruls, Cardona, Arnold, Mech. Mach. Theory 48 (2012) 121-137; fall: energy and two momenta, elliptic "
    "functions",
    quantities={
        **{f"{axis}_m": Quantity(f"centre of mass {axis} at t", "m") for axis in "xyz"},
        "fall_s": Quantity("time of fall (half a nutation)", "s"),
        "slow_precession_rad_s": Quantity("slow steady precession", "rad/s"),
        "fast_precession_rad_s": Quantity("fast steady precession", "rad/s"),
    },
    ablation=Ablation("spin", "the top just falls, through the lowest point and up on the other side", {"spin": 0.0},
                      values=without_spin),
    show=show,
    ranges={"tilt_deg": (50.0, 70.0), "m": (13.0, 15.5), "l": (0.9, 1.02), "It": (0.24, 0.27), "I3": (0.44, 0.48),
            "spin": (220.0, 260.0)},
    sliders=(Control("spin", 150.0, 400.0, "rad/s"), Control("precession", -1.5, 3.0, "rad/s", "push sideways")),
    readings={"fall_s": ("turning", 0, 2), **{f"{axis}_m": ("last", 0, k) for k, axis in enumerate("xyz")}},
    attempt="spin it faster: it falls less, and comes back sooner. Push it sideways with the rate of slow precession, "
    "and it no longer falls at all.",
)  # fmt: skip
