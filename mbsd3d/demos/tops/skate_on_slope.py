"""A spinning skate on an icy slope walks sideways and never slides down."""

import numpy as np

from mbsd3d import GROUND, Body, Joint, KnifeEdge, Planar, System, rotation, shapes, simulate

from ..form import GRAVITY, Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

G = 9.81  # m/s^2


def mechanism(*, slope_deg=5.0, w=2.0, blade=1) -> System:
    """Build a skate on a slope down along x, pointing down, turning at w [rad/s]; blade = 0 takes its edge away."""
    require(blade in (0, 1), f"demo 'skate_on_slope': blade = {blade}; give 1 (with its edge) or 0 (without)")
    turned = rotation("y", slope_deg, degrees=True)
    normal = axes(slope_deg)[2]
    form = (
        shapes.Box((0.32, 0.01, 0.05), at=(0, 0, 0.025), colour="silver"),
        shapes.Box((0.27, 0.08, 0.06), at=(0, 0, 0.08)),
        shapes.Cylinder(0.055, 0.2, (-0.25, 0, 1), at=(-0.09, 0, 0.19)),
        shapes.Sphere(0.045, at=(0.12, 0, 0.1)),
    )
    skate = Body("skate", 2.0, (0.01, 0.02, 0.02), orientation=turned, velocity=(0, 0, 0), omega=w * normal, shape=form)
    joints: list[Joint] = [Planar(GROUND, skate, at=(0, 0, 0), normal=normal, name="ice")]
    joints += [KnifeEdge(GROUND, skate, at=(0, 0, 0), lateral=(0, 1, 0), name="blade")] * blade
    return System([skate], joints, gravity=(0, 0, -G))


def axes(slope_deg):
    """Return the directions down the slope, across it, and normal."""
    s, c = np.sin(np.radians(slope_deg)), np.cos(np.radians(slope_deg))
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


def path(t, slope_deg, w, blade):
    """Return the position (down, sideways) [m] with g' = g sin(slope): the speed along the blade is g' sin(w t)/w;
    without, a free puck.
    """
    g = G * np.sin(np.radians(slope_deg))
    if not blade:
        return 0.5 * g * t**2, 0.0 * t
    return g * (1 - np.cos(2 * w * t)) / (4 * w**2), g * t / (2 * w) - g * np.sin(2 * w * t) / (4 * w**2)


def theory(*, slope_deg, w, blade, t):
    """Return the position on a cycloid across the slope."""
    require(w or not blade, "demo 'skate_on_slope': w = 0: a skate that does not turn slides down; give another rate")
    down, sideways = path(t, slope_deg, w, blade)
    return {"down_slope_m": down, "sideways_m": sideways}


def measure(build, terms, *, slope_deg, w, blade, t=10.0) -> Measured:
    """Measure the position of the skate at time t [m]."""
    run = simulate(build(), t, rtol=1e-13, output=401, **terms)
    down, sideways, _ = axes(slope_deg) @ run.position("skate").T
    known = path(run.t, slope_deg, w, blade)
    path_seen = Curve(
        "up the slope [m]", sideways, -down, (known[1], -known[0]), "sideways [m]", "its path on the slope"
    )
    curve = Curve("down the slope [m]", run.t, down, (run.t, known[0]))
    return Measured({"down_slope_m": down[-1], "sideways_m": sideways[-1]}, [run], [path_seen, curve])


demo = Demo(
    __name__,
    title="The skate that walks sideways",
    question="Why does a spinning skate on an icy slope walk sideways and never slide down?",
    beats=(
        Beat(0.0, "It starts down the slope, and the blade turns."),
        Beat(0.785, "Lowest: the blade lies across."),
        Beat(1.571, "Up again where it was, and a step aside."),
        Beat(share(1.0), "Always aside, and never lower."),
    ),
    why="The blade lets the skate move along itself only. As it turns, gravity speeds it up while it points downhill "
    "and slows it down by the same amount while it points uphill; what is left is a drift across the slope. The "
    "energy never allows it to go lower than one arc: a condition on velocities alone does what no rail could.",
    equation="down = g_s (1 - cos 2 w t) / (4 w^2); sideways = g_s t / (2 w) - g_s sin 2 w t / (4 w^2); "
    "g_s = g sin(slope)",
    symbols={
        "w": Symbol("turning of the skate", "rad/s", "w"),
        "g": GRAVITY,
        "g_s": Symbol(
            "its part down the slope", "m/s^2", lambda slope_deg: 9.81 * float(np.sin(np.radians(slope_deg)))
        ),
        "t": Symbol("time", "s"),
    },
    source="Neimark, Fufaev, Dynamics of Nonholonomic Systems; Bloch, Nonholonomic Mechanics and Control, 1.6",
    quantities={
        "down_slope_m": Quantity("way down the slope", "m"),
        "sideways_m": Quantity("way across the slope", "m"),
    },
    ablation=Ablation("blade", "it slides down and nothing else", {"blade": 0}),
    show={"curves": [("position", "skate")], "traces": [("skate", (0, 0, 0))]},
    sliders=(Control("slope_deg", 1.0, 20.0, "deg", "slope"), Control("w", 0.5, 4.0, "rad/s", "turning")),
    attempt="turn it slower: it goes farther down before it turns back, and sideways faster.",
)
