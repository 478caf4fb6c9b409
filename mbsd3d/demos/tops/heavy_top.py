"""The fast heavy top of the literature: it falls, turns aside, and comes back up."""

import numpy as np
from scipy.special import ellipk

from mbsd3d import GROUND, Body, Spherical, System, measures, rotation, shapes, simulate
from mbsd3d.base.style import GREY

from ..drawing import sphere_net
from ..figure import Line, Path
from ..form import Ablation, Curve, Demo, Measured, Quantity, require
from ..quadrature import cross, motion

G = 9.81  # m/s^2
TIP = 0.25  # of the stem beyond the disc, in lengths


def mechanism(*, m=15.0, l=1.0, It=0.234375, I3=0.46875, spin=150.0, precession=-4.61538, tilt_deg=90.0) -> System:
    """Top m [kg] with moments (It, It, I3) [kg m^2], the axis its y, centre of mass l [m] from the pivot; ``spin`` is
    along the axis in all, ``precession`` about the vertical [rad/s], the axis tilted from it towards y."""
    tilt = np.radians(tilt_deg)
    axis = np.array([0.0, np.sin(tilt), np.cos(tilt)])
    omega = precession * np.array([0.0, 0.0, 1.0]) + (spin - precession * np.cos(tilt)) * axis
    shape = (
        shapes.Disc(0.25 * l, 0.03 * l, "y"),
        shapes.Cylinder(0.02 * l, (1 + TIP) * l, "y", at=(0, 0.5 * (TIP - 1) * l, 0), colour=GREY),
    )
    top = Body(
        "top", m, (It, I3, It), position=l * axis, orientation=rotation("x", np.pi / 2 - tilt), omega=omega, shape=shape
    )
    return System([top], [Spherical(GROUND, top, at=(0, 0, 0), name="pivot")], gravity=(0, 0, -G))


def steady_rates(tilt, A, C, spin, weight):
    """Slow and fast steady precession [rad/s]: roots W of A W^2 cos(tilt) - C w3 W + m g l = 0."""
    square = (C * spin) ** 2 - 4 * A * np.cos(tilt) * weight
    require(square > 0, f"demo 'heavy_top': spin = {spin:g} rad/s is too slow to precess steadily; give more")
    larger = C * spin + np.copysign(np.sqrt(square), spin)
    return 2 * weight / larger, larger / (2 * A * np.cos(tilt))


def nutation(A, C, spin, precession, weight):
    """Lowest height u < 0, rate and parameter of u = low + (0 - low) sn^2(rate t + K | m), from a horizontal axis.

    Roots of (alpha - beta u)(1 - u^2) - (b - a u)^2, with a = C w3 / A, b = W, beta = 2 m g l / A, alpha = W^2. One is
    u = 0, the highest point, so what is left is a quadratic: beta u^2 - (alpha + a^2) u + 2 a b - beta = 0.
    """
    a, beta = C * spin / A, 2 * weight / A
    half, rest = 0.5 * (precession**2 + a**2) / beta, (2 * a * precession - beta) / beta
    require(rest < 0, f"demo 'heavy_top': precession = {precession:g} rad/s lifts the top at the start; give less")
    third = half + np.sqrt(half**2 - rest)
    low = rest / third
    return low, np.sqrt(beta * (third - low)) / 2, -low / (third - low)


def path(times, *, m, l, It, I3, spin, precession):
    """(times, 3) of the centre of mass [m] from y on: e'' = -e'.e' e + (C w3 / A) e x e' + (F - (e.F) e) l / A."""
    A, F = It + m * l**2, -m * G * l

    def rate(_, y):
        e, de = y[:3].tolist(), y[3:].tolist()
        turned, inwards = cross(e, de), -sum(x * x for x in de) - e[2] * F / A
        return [*de, *(inwards * e[k] + I3 * spin / A * turned[k] + (F / A if k == 2 else 0.0) for k in range(3))]

    return l * motion(rate, np.array([0, 1, 0, -precession, 0, 0]), times)[:, :3]


def falling(*, m, l, It, I3, spin, precession, t):
    """Place at t by own equations of the axis, half a nutation by an elliptic integral."""
    _, rate, k = nutation(It + m * l**2, I3, spin, precession, m * G * l)
    place = path(np.array([0.0, t]), m=m, l=l, It=It, I3=I3, spin=spin, precession=precession)[-1]
    return dict(zip(("x_m", "y_m", "z_m"), place, strict=True)) | {"fall_s": ellipk(k) / rate}


def theory(*, m, l, It, I3, spin, precession, steady_tilt_deg, t):
    """`falling`, and steady precession by its quadratic equation."""
    rates = steady_rates(np.radians(steady_tilt_deg), It + m * l**2, I3, spin, m * G * l)
    named = dict(zip(("slow_precession_rad_s", "fast_precession_rad_s"), rates, strict=True))
    return falling(m=m, l=l, It=It, I3=I3, spin=spin, precession=precession, t=t) | named


def without_gyroscopic(*, m, l, It, spin, precession, t):
    """It dw/dt = moment is left: the motion of a top whose moment about the axis is that across it; none is steady."""
    return falling(m=m, l=l, It=It, I3=It, spin=spin, precession=precession, t=t)


def measure(build, terms, *, m, l, It, I3, spin, precession, steady_tilt_deg=75.0, t=2.0) -> Measured:
    """The falling top at t, its first turning point, and the mean rate of both steady precessions."""
    settings, A = {"rtol": 1e-12, **terms}, It + m * l**2
    run = simulate(build(), t, output=801, **settings)
    rising = measures.velocity(run.system.bodies[0], axis=(0, 0, 1)) > 0.0
    fall = simulate(run.system, 10 * t, state=run.state(1), stop_when=rising, **settings)
    rates = steady_rates(np.radians(steady_tilt_deg), A, I3, spin, m * G * l)
    tilts = {"tilt_deg": steady_tilt_deg}
    steady = [simulate(build(precession=rate, **tilts), t, output=201, **settings) for rate in rates]
    turns = [np.unwrap(np.arctan2(*each.com("top").T[1::-1])) for each in steady]
    means = [(turn[-1] - turn[0]) / t for turn in turns]
    centre = run.com("top")
    names = ("x_m", "y_m", "z_m", "fall_s", "slow_precession_rad_s", "fast_precession_rad_s")
    values = dict(zip(names, (*centre[-1], fall.final.t, *means), strict=True))
    known = path(run.t[::20], m=m, l=l, It=It, I3=I3, spin=spin, precession=precession)
    (slow, fast), times = ((turn - turn[0]) / (2 * np.pi) for turn in turns), steady[0].t
    curves = [
        Path(("x / l [-]", "y / l [-]", "z / l [-]"), centre / l, "path of the centre of mass",
             net=sphere_net(highest=0), box=(2, 2, 1), heights=(-1, 0)),
        Curve("height of the centre of mass [m]", run.t, centre[:, 2], (run.t[::20], known[:, 2]),
              title="it falls, and comes back up"),
        Curve("revolutions about the vertical [-]", times, slow, (times, rates[0] * times / (2 * np.pi)),
              title=f"steady precession, axis at {steady_tilt_deg:g} deg", name=f"slow, {rates[0]:.3f} rad/s",
              more=[Line(f"fast, {rates[1]:.3f} rad/s", fast, theory=(times, rates[1] * times / (2 * np.pi)))]),
    ]  # fmt: skip
    return Measured(values, [run, *steady], curves)


demo = Demo(
    __name__,
    title="Heavy top: a falling weight that turns aside",
    question="Why does a spinning top fall a little, turn aside, and come back up?",
    why="In a plane the spin has no direction to change, so w x I w vanishes and a weight can only fall. In space the "
    "moment of the weight turns the spin axis sideways. Released with another rate than a steady one the top falls "
    "until its sideways motion holds it, and comes back up: it nutates. With the right rate, and there are two, "
    "it goes round at a constant height.",
    equation="A W^2 cos(tilt) - C w_3 W + m g l = 0; u_dot^2 = (alpha - beta u)(1 - u^2) - (b - a u)^2",
    source="case: Bruls, Cardona, Arnold, Mech. Mach. Theory 48 (2012) 121-137; fall: energy and two momenta, elliptic "
    "functions",
    quantities={
        **{f"{axis}_m": Quantity(f"centre of mass {axis} at t", "m") for axis in "xyz"},
        "fall_s": Quantity("time of fall (half a nutation)", "s"),
        "slow_precession_rad_s": Quantity("slow steady precession", "rad/s"),
        "fast_precession_rad_s": Quantity("fast steady precession", "rad/s"),
    },
    ablation=Ablation(
        "gyroscopic", "the top falls as if its moment about the axis were that across it", values=without_gyroscopic
    ),
    show={"curves": [("com", "top"), ("reaction", "pivot")], "traces": [("top", (0, 1 + TIP, 0))], "speed": 0.1,
          "shown": ["angular momentum"]},
    ranges={"tilt_deg": None, "m": (13.0, 15.5), "l": (0.9, 1.02), "It": (0.24, 0.27), "I3": (0.44, 0.48),
            "spin": (150.0, 175.0)},
)  # fmt: skip
