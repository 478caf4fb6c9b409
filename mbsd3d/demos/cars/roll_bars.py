"""Anti-roll bars of a car and the axle that slides first, as the bars move from the rear to the front."""

import numpy as np

from mbsd3d import Pulse, System, simulate

from ..figure import Line
from ..form import Ablation, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share
from .car import SHOW_OPTIONS, Car, car
from .circle import circle, circles
from .theory import ROLL_TOLERANCE, limit, trims, understeer_gradient

SMALL_ACCELERATION = 1e-3  # [m/s^2] terms of second order vanish
BAR_SHARES = (0.0, 0.35, 0.7, 1.0)  # [1] of the bars, in front
CIRCLE_STEP = 7.0  # [1] long, since only the end counts
FULL_GRIP_SHARE = 0.95  # [1] of the grip used
TYRES = ("inner front", "outer front", "inner rear", "outer rear")  # in the order of `WHEELS`, on circles to the left


def cars(h, track, bars, mu, less_grip, less_stiffness, shares=BAR_SHARES):
    """Return the same car with its bars at several shares in front."""
    c = Car(h=h, track=track, mu=mu, less_grip=less_grip, less_stiffness=less_stiffness)
    return [c._replace(bar_f=share * bars, bar_r=(1.0 - share) * bars) for share in shares]


def mechanism(
    *, h=0.55, track=1.5, bars=18e3, mu=1.0, less_grip=0.12, less_stiffness=0.25, v=20.0, share=1.0, steer=0.1
) -> System:  # fmt: skip
    """Build the car at v with a share of its bars [N m/rad] in front, whose front wheels are steered within 1 s."""
    require(v > 0.0, f"demo 'roll_bars': v = {v:g} m/s; give a speed ahead")
    (c,) = cars(h, track, bars, mu, less_grip, less_stiffness, [share])
    return car(c, v, Pulse(steer, start=0.2, edge=1.0))


def theory(*, h, track, bars, mu, less_grip, less_stiffness, v):
    """Return the largest accelerations by trims, and the understeer gradient in closed form, which is independent of
    the bars.
    """
    known = [limit(c, v).acceleration for c in cars(h, track, bars, mu, less_grip, less_stiffness, (0.0, 1.0))]
    c = Car(less_stiffness=less_stiffness)
    return {
        "limit_rear_bars_m_s2": known[0],
        "limit_front_bars_m_s2": known[1],
        "understeer_rad_s2_m": understeer_gradient(c),
    }


def measure(build, terms, *, h, track, bars, mu, less_grip, less_stiffness, v) -> Measured:
    """Measure circles up to the limit with the bars at several shares, and a very wide one."""
    group = cars(h, track, bars, mu, less_grip, less_stiffness)
    found = [circles(c, v, terms, CIRCLE_STEP) for c in group]
    wide = circle(group[-1], v, SMALL_ACCELERATION, terms=terms)
    values = {
        "limit_rear_bars_m_s2": found[0][-1].acceleration,
        "limit_front_bars_m_s2": found[-1][-1].acceleration,
        "understeer_rad_s2_m": wide.steer / SMALL_ACCELERATION - group[-1].wheelbase / v**2,
    }
    notes = [note(share, one) for share, one in zip(BAR_SHARES, found, strict=True)]
    return Measured(values, [simulate(build(), 3.0, output=301, **terms)], curves(group, v, found), notes=notes)


def note(share, found):
    """Return in a line which tyre slides first, and the state at the limit."""
    last, at = found[-1], [one.acceleration for one in found]
    used = np.array([one.of_tyres("saturation") for one in found]).T
    first = np.argmin([np.interp(FULL_GRIP_SHARE, one, at, right=np.inf) for one in used])
    parts = ", ".join(f"{name} {100.0 * one:.1f} %" for name, one in zip(TYRES, used[:, -1], strict=True))
    return (
        f"{100.0 * share:.0f} % of the bars in front: the {TYRES[first]} tyre is the first to use "
        f"{100.0 * FULL_GRIP_SHARE:.0f} "
        f"% of its grip; circles up to {last.acceleration:.3f} m/s^2, with {np.degrees(last.steer):.2f} deg of steer; "
        f"there {parts}"
    )


def curves(group, v, found):
    """Draw limit and grip used there over the share of the bars, and the steer up to it."""
    known = [trims(c, v) for c in group]
    percent, along = 100.0 * np.array(BAR_SHARES), {"along": "share of the bars in front [%]"}
    used = 100.0 * np.array([one[-1].of_tyres("saturation") for one in found]).T
    known_used = 100.0 * np.array([one[-1].used for one in known]).T
    limits = [np.array([one[-1].acceleration for one in some]) for some in (found, known)]
    x, steer = ([np.array([getattr(one, of) for one in some]) for some in found] for of in ("acceleration", "steer"))
    dots = [(np.array([one.acceleration for one in some]), np.degrees([one.steer for one in some])) for some in known]
    return [
        Curve("largest lateral acceleration [m/s^2]", percent, limits[0], (percent, limits[1]), **along),
        Curve(
            "grip used at the limit [%]", percent, used[0], (percent, known_used[0]), name=TYRES[0],
            more=[Line(TYRES[k], used[k], None, (percent, known_used[k])) for k in (1, 2, 3)], **along,
        ),
        Curve(
            "steer [deg]", x[-1], np.degrees(steer[-1]), dots[-1], "lateral acceleration [m/s^2]", name="bars in front",
            more=[Line("bars at the rear", np.degrees(steer[0]), x[0], dots[0])],
        ),
    ]  # fmt: skip


demo = Demo(
    __name__,
    title="Which end lets go first",
    question="Why does a stiffer anti-roll bar in front make a car run wide, and one at the rear make it spin?",
    beats=(
        Beat(0.0, "The stiff bar is in front."),
        Beat(share(0.5), "In front the outer tyre carries most ..."),
        Beat(share(1.0), "... and lets go first: it runs wide. With the bar behind it would spin."),
    ),
    why="Both bars hold the same roll, but each takes its part of the load that goes to the outer wheels over its own "
    "axle. A tyre grips less per load the more load it has, so an axle whose load is shared more unevenly has "
    "less grip: the one with the bar lets go first. Bars in front: the car runs wide and wants ever more steer; "
    "bars at the rear: the tail comes round, and the steer must be taken back; the inner driven wheel, which then "
    "bears next to nothing, spins. In gentle curves one feels none of it.",
    equation="F_max = mu (2 N (1 + k) - 2 k (N^2 + D^2)/N_0), D = K_i roll/track",
    symbols={
        "F_max": Symbol("what an axle can hold", "N"),
        "mu": Symbol("friction", "", "mu"),
        "N": Symbol("mean load of its tyres", "N"),
        "D": Symbol("load that goes to the outer one", "N"),
        "k": Symbol("grip lost for more load", "", "less_grip"),
        "N_0": Symbol("load without a curve", "N"),
        "K_i": Symbol("roll stiffness of the axle", "N m/rad"),
    },
    source="Milliken, Milliken, Race Car Vehicle Dynamics",
    quantities={
        "limit_rear_bars_m_s2": Quantity("largest lateral acceleration, bars at the rear", "m/s^2",
            relative=ROLL_TOLERANCE),
        "limit_front_bars_m_s2": Quantity("largest lateral acceleration, bars in front", "m/s^2",
            relative=ROLL_TOLERANCE),
        "understeer_rad_s2_m": Quantity("understeer gradient, bars or not", "rad s^2/m", absolute=3e-7),
    },
    ablation=Ablation(
        "load_sensitivity",
        "with grip and stiffness in proportion to the load bars in front cost nothing, and the car steers as if its "
        "tyres did not slip; bars at the rear still unload the inner driven wheel until it spins",
        {"less_grip": 0.0, "less_stiffness": 0.0},
    ),
    alone="MuJoCo has no such tyre, and Exudyn no bar between two wheels",
    show={**SHOW_OPTIONS, "curves": [("force", "front right tyre"), ("force", "rear right tyre")]},
    ranges={"share": None},
    sliders=(
        Control("steer", 0.02, 0.1, "rad"),
        Control("share", 0.0, 1.0, "", "share of the rear bar"),
    ),
    attempt="move the stiffness from one end to the other: the end with the stiffer bar lets go first.",
)  # fmt: skip
