"""A car in circles up to the limit of its tyres: roll, loads, steer, and which tyre lets go first."""

from functools import cache

import numpy as np

from mbsd3d import Pulse, System, simulate

from ..figure import Line
from ..form import Ablation, Curve, Demo, Measured, Quantity, require
from .car import TYRE, WHEELS, Car, G, car, circle, circles

SMALL = 1e-3  # m/s^2: what is of second order has no say
STEPS = (3.0, 3.0, 1.5, 0.75, 0.25)  # m/s^2 from circle to circle,
FEWER = (3.0, 3.0, 1.5, 0.75)  # and with other bars
STANDARD = Car()


def mechanism(
    *, ms=1400.0, h=0.55, a=1.2, b=1.5, track=1.5, kf=25e3, kr=22e3, bar_f=12e3, bar_r=6e3, mu=1.0, v=20.0, steer=0.05
) -> System:  # fmt: skip
    """Car at v whose front wheels are steered to an angle [rad] within 0.3 s."""
    require(v > 0.0, f"demo 'car_limit': v = {v:g} m/s; give a speed ahead")
    c = Car(ms, h, a, b, track, kf, kr, bar_f, bar_r, mu)
    return car(c, v, Pulse(steer, start=0.2, edge=0.3))


def gradients(c: Car, Iw: float) -> dict[str, float]:
    """Roll, loads and steer per lateral acceleration where it is small.

    Springs and bar of an axle are in series with its tyres; the wheels lean by what their tyres give, and their spin is
    carried round, Iw v/r times v/R.
    """
    half = 0.5 * c.track**2
    K = {}
    for end, k, bar in (("front", c.kf, c.bar_f), ("rear", c.kr, c.bar_r)):
        K[end] = 1.0 / (1.0 / (k * half + bar) + 1.0 / (c.kt * half))
    height = c.ms * c.h + 4.0 * c.mw * c.r
    roll = (height + 4.0 * Iw / c.r) / (K["front"] + K["rear"] - height * G)
    give = []
    for end in K:
        over = c.load(f"{end} left") / TYRE["nominal_load"] - 1.0
        give.append(1.0 / (TYRE["cornering"] * (1.0 - TYRE["stiffness_sensitivity"] * over)) / G)
    return {
        "roll_rad_s2_m": roll,
        "front_transfer_kg": K["front"] * roll / c.track,
        "rear_transfer_kg": K["rear"] * roll / c.track,
        "understeer_rad_s2_m": give[0] - give[1],
    }


def theory(*, ms, h, a, b, track, kf, kr, bar_f, bar_r, mu):
    """Closed forms of small lateral accelerations, see `gradients`."""
    return gradients(Car(ms, h, a, b, track, kf, kr, bar_f, bar_r, mu), STANDARD.Iw)


def without_gyroscopic(*, ms, h, a, b, track, kf, kr, bar_f, bar_r, mu):
    """Of the moment that turns the spin round half is I dw/dt of a wheel's diameter, and stays."""
    return gradients(Car(ms, h, a, b, track, kf, kr, bar_f, bar_r, mu), 0.5 * STANDARD.Iw)


def measure(build, terms, *, ms, h, a, b, track, kf, kr, bar_f, bar_r, mu, v) -> Measured:
    """A very wide circle, circles up to the limit with the bars as given and moved, and the step of the steer."""
    c = Car(ms, h, a, b, track, kf, kr, bar_f, bar_r, mu)
    wide = circle(c, v, SMALL, terms=terms)
    load = wide.of_tyres("normal")
    values = {
        "roll_rad_s2_m": wide.roll / SMALL,
        "front_transfer_kg": 0.5 * (load[1] - load[0]) / SMALL,
        "rear_transfer_kg": 0.5 * (load[3] - load[2]) / SMALL,
        "understeer_rad_s2_m": wide.steer / SMALL - (a + b) / v**2,
    }
    bars = bar_f + bar_r
    moved = {
        "as given": c,
        "at the front": c._replace(bar_f=bars, bar_r=0.0),
        "at the rear": c._replace(bar_f=0.0, bar_r=bars),
    }

    @cache
    def found():
        return {where: circles(one, v, STEPS if one is c else FEWER, terms) for where, one in moved.items()}

    run = simulate(build(), 3.0, output=301, **terms)
    return Measured(
        values,
        [run],
        curves=lambda: curves(c, v, found()),
        notes=lambda: [note(where, group[-1]) for where, group in found().items()],
    )


def note(where, last):
    """What the last circle says."""
    used = dict(zip(WHEELS, last.of_tyres("saturation"), strict=True))
    most = max(used, key=used.get)
    return (
        f"bars {where}: circles up to {last.acceleration:.4g} m/s^2; there the {most} tyre uses "
        f"{100 * used[most]:.3g} % of its grip, the car rolls {np.degrees(last.roll):.3g} deg and steers "
        f"{np.degrees(last.steer):.3g} deg"
    )


def curves(c, v, found):
    """Steer with the bars here and there, loads of the wheels, and the grip they use, over the acceleration."""
    x = {where: np.array([one.acceleration for one in group]) for where, group in found.items()}
    steer = {where: np.degrees([one.steer for one in group]) for where, group in found.items()}
    given, small = found["as given"], gradients(c, STANDARD.Iw)
    line = np.degrees((c.a + c.b) / v**2 + small["understeer_rad_s2_m"]) * x["as given"]
    loads = np.array([one.of_tyres("normal") for one in given]).T
    used = np.array([one.of_tyres("saturation") for one in given]).T
    signs = [side * small[f"{name.split()[0]}_transfer_kg"] for name, (_, side) in WHEELS.items()]
    straight = [c.load(name) - sign * x["as given"] for name, sign in zip(WHEELS, signs, strict=True)]
    along, names = {"along": "lateral acceleration [m/s^2]"}, [*WHEELS]
    return [
        Curve(
            "steer [deg]", x["as given"], steer["as given"], (x["as given"], line), name="bars as given",
            more=[Line(f"bars {where}", steer[where], x[where]) for where in ("at the front", "at the rear")], **along,
        ),
        Curve(
            "load [N]", x["as given"], loads[0], (x["as given"], straight[0]), name=names[0],
            more=[Line(names[k], loads[k], None, (x["as given"], straight[k])) for k in (1, 2, 3)], **along,
        ),
        Curve(
            "share of the grip used [-]", x["as given"], used[0], name=names[0],
            more=[Line(names[k], used[k]) for k in (1, 2, 3)], **along,
        ),
    ]  # fmt: skip


demo = Demo(
    __name__,
    title="A car at the limit",
    question="Which tyres of a car in a circle slide first, and what have the anti-roll bars to do with it?",
    why="Cornering moves load to the outer wheels, in parts that springs and bars of the axles share. A tyre grips "
    "less per load the more load it has, so the axle with the stiffer bar slides first: bars at the front make a car "
    "run wide, bars at the rear make it turn in. Textbooks give the roll some 8 % too low: they leave out that the "
    "wheels lean with their tyres, and that their spin is carried round.",
    equation="roll = (ms h + 4 mw r + 4 Iw/r) ay / (Kf + Kr - (ms h + 4 mw r) g)",
    source="Milliken, Milliken, Race Car Vehicle Dynamics; ISO 4138 (steady circles at a constant speed)",
    quantities={
        "roll_rad_s2_m": Quantity("roll per lateral acceleration", "rad s^2/m", relative=1e-6),
        "front_transfer_kg": Quantity("load from left to right in front, per acceleration", "kg", relative=1e-6),
        "rear_transfer_kg": Quantity("load from left to right behind, per acceleration", "kg", relative=1e-6),
        "understeer_rad_s2_m": Quantity("understeer gradient", "rad s^2/m", absolute=3e-7),
    },
    mechanism=mechanism,
    theory=theory,
    measure=measure,
    ablation=Ablation(
        "gyroscopic",
        "the car rolls less by half of what its spinning wheels add; the other half is I dw/dt of the wheels",
        values=without_gyroscopic,
    ),
    alone="no other engine has this tyre",
    show={
        "curves": [("force", "front right tyre"), ("force", "rear right tyre")],
        "traces": [],
        "hidden": ["joints", "joint names", "body names"],
        "follow": "chassis",
    },
)  # fmt: skip
