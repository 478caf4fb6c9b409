"""A clutch that slips until both sides turn alike: what turns to heat is decided by their speeds."""

import numpy as np

from mbsd3d import GROUND, Body, Clutch, Revolute, System, shapes, simulate

from ..figure import Line
from ..form import Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

DISC_MASS = 20.0  # [kg] of a disc; its radius follows from its moment of inertia
SAMPLES, TIME_RATIO = 301, 1.6  # [1] of the run; its length over the time of slip


def disc(name, J, w, x, colour):
    """Return a disc J [kg m^2] with a bar across its face, about the x axis at w [rad/s]."""
    radius = np.sqrt(2 * J / DISC_MASS)
    form = (
        shapes.Cylinder(radius, 0.06, "x", colour=colour),
        shapes.Box((0.1, 1.9 * radius, 0.15 * radius), colour="black"),
    )
    return Body(name, DISC_MASS, (J, 0.6 * J, 0.6 * J), position=(x, 0, 0), omega=(w, 0, 0), shape=form)


def mechanism(*, J_engine=0.3, J_car=0.8, w_engine=9.0, w_car=1.0, grip=1.0) -> System:
    """Build an engine and a car, as the clutch feels them [kg m^2], at their speeds [rad/s]; the clutch slips at a
    torque [N m].
    """
    engine, car = disc("engine", J_engine, w_engine, 0.0, "orange"), disc("car", J_car, w_car, 0.2, "steelblue")
    crank = Revolute(GROUND, engine, at=(0, 0, 0), axis="x", name="crank")
    pilot = Revolute(engine, car, at=(0.1, 0, 0), axis="x", name="pilot bearing")
    return System([engine, car], [crank, pilot], [Clutch(pilot, torque=grip, engaged=True, name="clutch")])


def theory(*, J_engine, J_car, w_engine, w_car, grip):
    """Return heat by both energies, the time by the torque, and the common speed by the momentum."""
    both, difference = J_engine + J_car, w_engine - w_car
    reduced = J_engine * J_car / both
    return {
        "heat_J": 0.5 * reduced * difference**2,
        "slips_s": reduced * abs(difference) / grip,
        "common_rad_s": (J_engine * w_engine + J_car * w_car) / both,
    }


def measure(build, terms, *, J_engine, J_car, w_engine, w_car, grip) -> Measured:
    """Measure when the clutch locks, and what it has turned to heat until then."""
    require(grip > 0.0, f"demo 'clutch_start': grip = {grip:g} N m; give a torque above 0")
    known = theory(J_engine=J_engine, J_car=J_car, w_engine=w_engine, w_car=w_car, grip=grip)
    slips, common = known["slips_s"], known["common_rad_s"]
    run = simulate(build(), TIME_RATIO * slips or 1.0, output=SAMPLES, **terms)
    speeds, heat = [run.omega(name)[:, 0] for name in ("engine", "car")], -run.work("clutch")
    locked = next((event.t for event in run.events if event.action == "locks"), 0.0)
    values = {"heat_J": heat[-1], "slips_s": locked, "common_rad_s": speeds[1][-1]}
    t = run.t
    share = np.minimum(t / slips, 1.0) if slips else np.ones_like(t)
    lines = [(t, start + share * (common - start)) for start in (w_engine, w_car)]
    curves = [
        Curve("speed [rad/s]", t, speeds[0], lines[0], name="engine", more=[Line("car", speeds[1], theory=lines[1])]),
        Curve("heat [J]", t, heat, (t, known["heat_J"] * (2 * share - share**2))),
    ]
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="Half of it turns to heat",
    question="Does a car start with less heat in its clutch if one lets the pedal come softly?",
    beats=(
        Beat(0.0, "The engine turns, the car stands nearly still."),
        Beat(share(0.5), "The clutch slips and grows hot."),
        Beat(1.7455, "Both turn alike, and half of the energy between them is gone."),
    ),
    why="The clutch gives the same torque to both sides, so it brings the engine down and the car up until they turn "
    "alike, at the speed that their momentum says. Energy is left over then, the same however long it took: a soft "
    "foot slips longer with less torque, a hard one shorter. Only a smaller difference of speeds leaves less.",
    equation="heat = (1/2) J_1 J_2/(J_1 + J_2) (w_1 - w_2)^2; time = J_1 J_2/(J_1 + J_2) (w_1 - w_2)/T",
    symbols={
        "J_1": Symbol("moment of the engine", "kg m^2", "J_engine"),
        "J_2": Symbol("that of the car, at the clutch", "kg m^2", "J_car"),
        "w_1": Symbol("engine", "rad/s", curve=(0, 0)),
        "w_2": Symbol("car", "rad/s", curve=(1, 0)),
        "T": Symbol("torque of the clutch", "N m"),
    },
    source="momentum and energy of two wheels in a plastic impact; worked out here",
    quantities={
        "heat_J": Quantity("heat in the clutch", "J"),
        "slips_s": Quantity("time of slip", "s"),
        "common_rad_s": Quantity("common speed", "rad/s"),
    },
    alone="other engines have no clutch that locks",
    ablation=Ablation("difference of speeds", "nothing slips, and nothing gets warm", {"w_engine": 1.0}),
    against=Against("grip", 0.3, 3.0, "torque at which the clutch slips [N m]"),
    show={"curves": [("omega", "engine"), ("omega", "car")], "traces": [], "shown": ["engaged"], "view": (-55, 20),
          "hidden": ["joints", "joint names"]},
    may_vanish=("w_car",),
)  # fmt: skip
