"""A ratchet that lifts: a lever swings to and fro, and only whole teeth of its way stay."""

import numpy as np

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    Constant,
    Cylindrical,
    Freewheel,
    Prismatic,
    RackPinion,
    Ratchet,
    Revolute,
    Sine,
    System,
    shapes,
    simulate,
)

from ...mechanism.force_element import ForceElement
from ..figure import Line
from ..form import Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

G = 9.81  # m/s^2
STROKES, PER_STROKE = 3, 300  # [1] of the run; samples
J_PINION = 0.02  # [kg m^2]


def ratchet_wheel(R, teeth):
    """Return the shapes of a pinion of radius R [m] with a toothed wheel beside it."""
    turns = 2 * np.pi / teeth * np.arange(teeth)
    saws = [
        shapes.Box((0.3 * R, 0.3 * R, 0.3 * R),
                   at=(1.5 * R * np.cos(turn), 0.6 * R, 1.5 * R * np.sin(turn)),
                   orientation=(np.cos(turn / 2), 0, -np.sin(turn / 2), 0), colour="darkorange")
        for turn in turns
    ]  # fmt: skip
    disc = shapes.Cylinder(1.5 * R, 0.3 * R, "y", at=(0, 0.6 * R, 0), colour="darkorange")
    return (shapes.Cylinder(R, 0.9 * R, "y", colour="gray"), disc, *saws)


def mechanism(*, m=50.0, R=0.06, teeth=16, swing=1.0, T=1.5, pawl=1) -> System:
    """Build a lever that swings by ``swing`` [rad] and back in T [s] and takes a pinion of a radius [m] along forwards,
    a load m [kg] on the rack of the pinion, and a pawl (0: none) that holds one of its teeth.
    """
    bar = shapes.Box((0.35 * R, 0.3 * R, 4 * R), at=(0, 0, 2 * R), colour="steelblue")
    knob = shapes.Sphere(0.5 * R, at=(0, 0, 4 * R), colour="crimson")
    lever = Body("lever", 1.5, (0.05, 0.05, 0.05), position=(0, -R, 0), shape=(bar, knob))
    pinion = Body("pinion", 8.0, (J_PINION, J_PINION, J_PINION), shape=ratchet_wheel(R, teeth))
    rail = shapes.Box((0.4 * R, 0.6 * R, 7 * R), at=(0.2 * R, 0, 1.5 * R), colour="gray")
    weight = shapes.Box((3 * R, 3 * R, 2.5 * R), at=(0.9 * R, 0, -3 * R), colour="seagreen")
    load = Body("load", m, (0.04 * m, 0.04 * m, 0.02 * m), position=(R, 0, -2 * R), shape=(rail, weight))
    pivot = Revolute(GROUND, lever, at=(0, -R, 0), axis="y", name="pivot")
    axle = Revolute(GROUND, pinion, at=(0, 0, 0), axis="y", name="axle")
    between = Cylindrical(lever, pinion, at=(0, -0.5 * R, 0), axis="y", name="between")
    guide = Prismatic(GROUND, load, at=load.position, axis="z", name="guide")
    rack = RackPinion(axle, guide, radius=R, name="rack")
    way = Constant(swing / 2) + Sine(-swing / 2, 1 / T, np.pi / 2)
    hand = AngleDriver(pivot, way, name="hand")
    locks: list[ForceElement] = [Freewheel(between, name="driving pawl")]
    if pawl:
        locks.append(Ratchet(axle, teeth=teeth, name="holding pawl"))
    return System([lever, pinion, load], [pivot, axle, between, guide, rack, hand], locks, gravity=(0, 0, -G))


def stays(teeth, swing, pawl):
    """Return how far the pinion has come after a stroke [rad]: by the whole teeth of the swing."""
    pitch = 2 * np.pi / teeth
    return pitch * np.floor(swing / pitch) if pawl else 0.0


def theory(*, m, R, teeth, swing, T, pawl):
    """Return rise of a stroke by whole teeth, the energy of the knock, and the share of the work that the load keeps.

    The lever moves as swing (1 - cos w t)/2, so at an angle y of it at w sqrt(y (swing - y)).
    """
    w, J = 2 * np.pi / T, J_PINION + m * R**2
    require(w**2 * swing / 2 < m * G * R / J,
            f"demo 'ratchet_hoist': T = {T:g} s, and the load flies ahead of its lever; give more")  # fmt: skip
    kept = stays(teeth, swing, pawl)
    knock, raised = 0.5 * J * w**2 * kept * (swing - kept), m * G * R * kept
    return {"rise_mm": 1e3 * R * kept, "knock_J": knock, "kept": raised / (raised + knock) if raised else 0.0}


def measure(build, terms, *, m, R, teeth, swing, T, pawl) -> Measured:
    """Measure some strokes: rise, knocks, and the work of the hand."""
    run = simulate(build(), STROKES * T, rtol=1e-11, output=STROKES * PER_STROKE + 1, **terms)
    rise, work = run.slide("guide"), run.work("hand")
    knocks = sum(event.lost for event in run.events)
    values = {
        "rise_mm": 1e3 * rise[-1] / STROKES, "knock_J": knocks / STROKES,
        "kept": m * G * rise[-1] / work[-1] if pawl else rise[-1],
    }  # fmt: skip
    lever, stroke = run.angle("pivot"), np.minimum(np.floor(run.t / T), STROKES - 1)
    kept, way = stays(teeth, swing, pawl), swing / 2 * (1 - np.cos(2 * np.pi * run.t / T))
    known = stroke * kept + np.where(run.t - stroke * T < T / 2, way, np.maximum(way, kept))
    pitch = 2 * np.pi / teeth
    curves = [
        Curve("turned by [teeth]", run.t, run.angle("axle") / pitch, (run.t, known / pitch), name="wheel",
              more=[Line("lever", lever / pitch, theory=(run.t, way / pitch))]),
        Curve("energy [J]", run.t, work, name="work of the hand", more=[Line("gained by the load", m * G * rise)]),
    ]  # fmt: skip
    return Measured(values, [run], curves)


def caught(run):
    """Return the time at which the pawl catches first [s]."""
    return next(event.t for event in run.events if "catches" in event.what)


demo = Demo(
    __name__,
    title="Only whole teeth count",
    question="Why does a ratchet hoist often lift no more when one pulls its lever farther?",
    beats=(
        Beat(0.0, "The lever goes forwards and takes the wheel along."),
        Beat(0.75, "Its stroke ends after two teeth and a half."),
        Beat(caught, "Half a tooth back, the pawl catches the second one with a knock."),
        Beat(share(1.0), "Three strokes, six teeth."),
    ),
    why="The lever has a pawl of its own, which takes the wheel along forwards and lets it stand on the way back. As "
    "the lever turns back the load follows it, until the last tooth that has passed lies against the other pawl. What "
    "the stroke has beyond whole teeth is given back, and on top of it the speed the load has gained by then turns to "
    "heat in the knock. More teeth lose less of both.",
    equation="h = R k p; k p <= a < (k + 1) p; p = 2 pi/n; heat = (J + m R^2) w^2 k p (a - k p)/2",
    symbols={
        "h": Symbol("rise of a stroke", "m"),
        "k": Symbol("whole teeth of a stroke", "", lambda teeth, swing: float(swing // (2 * np.pi / teeth))),
        "p": Symbol("angle of a tooth", "rad", lambda teeth: 2 * np.pi / teeth),
        "a": Symbol("swing of the lever", "rad", "swing"),
        "n": Symbol("teeth", "", "teeth"),
        "R": Symbol("pinion", "m", "R"),
        "J": Symbol("pinion", "kg m^2", lambda: J_PINION),
        "m": Symbol("load", "kg", "m"),
        "w": Symbol("of the swing", "rad/s", lambda T: 2 * np.pi / T),
    },
    source="energy of the load in a plastic impact; worked out here",
    quantities={
        "rise_mm": Quantity("rise of a stroke", "mm", absolute=1e-6),
        "knock_J": Quantity("energy of a knock", "J", relative=1e-7),
        "kept": Quantity("work on the load over that of the hand", "-", relative=1e-6),
    },
    alone="other engines have no pawls",
    ablation=Ablation("the holding pawl", "the load sinks back with the lever", {"pawl": 0}),
    against=Against("swing", 0.3, 1.7, "swing of the lever [rad]", computed=8),
    show={"curves": [("angle", "axle")], "traces": [], "view": (-65, 12),
          "hidden": ["joints", "joint names", "body names"]},
    ranges={"swing": (0.85, 1.12), "pawl": None},
)  # fmt: skip
