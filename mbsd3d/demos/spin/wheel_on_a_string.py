"""A spinning wheel that hangs by one end of its axle from a string: it goes round instead of down."""

import numpy as np
from scipy.optimize import brentq

from mbsd3d import GROUND, Body, Distance, System, shapes, simulate

from ..form import GRAVITY, Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

G = 9.81  # m/s^2
SPOKES, SAMPLES = 4, 721  # [1] bars across the wheel; samples of a round
SECONDS_WITHOUT_ROUND = 1.5  # [s] of a run without a round


def steady(m, C, l, s, w):
    """Return the rate at which the level axle goes round [rad/s], and how far the string leans out [rad]; 0 without
    spin.

    C w W = m g l turns the momentum of the spin; tan(b) = W^2 (l + s sin(b)) / g keeps the centre on its circle.
    """
    W = m * G * l / (C * w) if w else 0.0
    return W, brentq(lambda b: G * np.tan(b) - W**2 * (l + s * np.sin(b)), 0.0, 1.5, xtol=1e-15)


def mechanism(*, m=2.0, C=0.02, A=0.012, l=0.15, s=0.6, w=100.0) -> System:
    """Build a wheel m [kg] with moments (C, A, A) [kg m^2], its axle held l [m] from the centre by a string of s [m],
    with a spin w [rad/s] about the level axle, on its steady way round.
    """
    W, b = steady(m, C, l, s, w)
    radius, out = np.sqrt(C / m), l + s * np.sin(b)
    end = np.array([s * np.sin(b), 0, 0])
    bars = [shapes.Box((0.03 * l, 1.9 * radius, 0.1 * radius), orientation=(np.cos(a / 2), np.sin(a / 2), 0, 0),
                       colour="dimgray") for a in np.arange(SPOKES) * np.pi / SPOKES]  # fmt: skip
    axle = shapes.Cylinder(0.04 * l, 1.2 * l, "x", at=(-0.4 * l, 0, 0), colour="peru")
    form = (shapes.Torus(radius, 0.14 * radius, "x"), axle, *bars)
    wheel = Body("wheel", m, (C, A, A), position=end + (l, 0, 0), velocity=(0, W * out, 0), omega=(w, 0, W), shape=form)
    string = Distance(GROUND, wheel, at_a=(0, 0, s * np.cos(b)), at_b=end, name="string")
    return System([wheel], [string], gravity=(0, 0, -G))


def theory(*, m, C, l, s, w):
    """Return rate, lean and pull of the string; the height of the wheel stays."""
    require(w != 0, "demo 'wheel_on_a_string': w = 0: a wheel at rest falls; give a spin")
    W, b = steady(m, C, l, s, w)
    return {"round_rad_s": W, "lean_deg": np.degrees(b), "pull_N": m * G / np.cos(b), "sinks_mm": 0.0}


def measure(build, terms, *, m, C, l, s, w) -> Measured:
    """Measure one round."""
    W, b = steady(m, C, l, s, w)
    system = build()
    run = simulate(system, 2 * np.pi / abs(W) if W else SECONDS_WITHOUT_ROUND, output=SAMPLES, rtol=1e-11, **terms)
    (string,) = system.joints
    along = run.point("wheel", (-l, 0, 0)) - string.at_a
    leans = np.degrees(np.arctan2(np.hypot(along[:, 0], along[:, 1]), -along[:, 2]))
    turned, height = run.omega("wheel")[:, 2], run.position("wheel")[:, 2]
    values = {
        "round_rad_s": np.trapezoid(turned, run.t) / run.t[-1], "lean_deg": leans[-1],
        "pull_N": np.linalg.norm(run.reaction(string).force[-1]), "sinks_mm": 1e3 * (height[0] - height.min()),
    }  # fmt: skip
    place = run.position("wheel")
    angle = W * run.t
    circle = (l + s * np.sin(b)) * np.array([np.cos(angle), np.sin(angle)])
    curves = [
        Curve("y [m]", place[:, 0], place[:, 1], tuple(circle), along="x [m]", title="from above", equal=True),
        Curve("height of the wheel [m]", run.t, height, (run.t, 0 * run.t), scale=l),
    ]
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="The wheel that hangs from a string",
    question="Why does a spinning wheel that a string holds at one end of its axle not fall?",
    beats=(
        Beat(0.0, "One end of the axle hangs on a string, the other is let go."),
        Beat(share(0.25), "It does not fall: it goes round."),
        Beat(share(1.0), "Once round in 4.3 s, and it is as high as before."),
    ),
    why="The weight and the string pull the axle down with a moment that lies level, across the axle. A wheel at rest "
    "starts to turn about it, and falls. A spinning one has an angular momentum along its axle already, and the moment "
    "turns this one aside, in the level plane: the axle goes round instead of down. The faster it spins the slower it "
    "goes round.",
    equation="C w W = m g l; tan(b) = W^2 (l + s sin(b))/g",
    symbols={
        "C": Symbol("moment of the wheel along its axle", "kg m^2", "C"),
        "w": Symbol("spin", "rad/s", "w", arrow="angular momentum"),
        "W": Symbol("rate at which it goes round", "rad/s"),
        "m": Symbol("wheel", "kg", "m"),
        "g": GRAVITY,
        "l": Symbol("from the string's end to the wheel", "m", "l"),
        "s": Symbol("length of the string", "m", "s"),
        "b": Symbol("lean of the string", "rad"),
    },
    source="steady motion by the moment about the centre of mass; worked out here",
    quantities={
        "round_rad_s": Quantity("rate at which it goes round", "rad/s"),
        "lean_deg": Quantity("lean of the string", "deg", relative=1e-7, absolute=1e-7),
        "pull_N": Quantity("pull of the string", "N"),
        "sinks_mm": Quantity("how far it sinks", "mm", absolute=1e-4),
    },
    ablation=Ablation("spin", "it drops and swings to and fro", {"w": 0.0}, values=lambda: {"round_rad_s": 0.0}),
    against=Against("w", 60.0, 200.0, "spin [rad/s]"),
    show={"curves": [("position", "wheel"), ("reaction", "string")], "shown": ["angular momentum"],
          "traces": ["wheel"], "view": (-60, 20), "hidden": ["joint names"]},
    ranges={"A": (0.0118, 0.014)},
    sliders=(
        Control("w", 80.0, 200.0, "rad/s", "spin"),
        Control("l", 0.1, 0.2, "m", "axle"),
    ),
    attempt="spin it faster: it goes round slower. Take a longer axle: the weight has a longer arm, and it "
    "goes round faster.",
)  # fmt: skip
