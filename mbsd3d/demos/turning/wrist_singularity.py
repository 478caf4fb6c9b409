"""The wrist of a robot that nearly stretches out must whip round."""

import numpy as np

from mbsd3d import GROUND, AngleDriver, Body, Kinematic, Parallel, Ramp, Revolute, System, shapes, simulate

from ..form import Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

SAMPLES = 401  # odd: the pose nearest to the straight one is among them
JOINT_PLACE = {"at": (0, 0, 0)}  # the axes of a wrist meet


def mechanism(*, w=1.0, miss_deg=3.0) -> System:
    """Build a hand turned at w [rad/s] about a fixed axis, so that it passes the stretched wrist at an angle."""
    return wrist(w, miss_deg, -np.pi / 2)


def wrist(w, miss_deg, angle):
    """Build the hand an angle before its pose nearest to the stretched one; without a driver for w = 0."""
    miss = np.radians(miss_deg)
    axis, nearest = np.array([0, -np.cos(miss), np.sin(miss)]), np.array([0, np.sin(miss), np.cos(miss)])
    along = np.cos(angle) * nearest + np.sin(angle) * np.cross(axis, nearest)
    bend = np.cross((0, 0, 1), along) if abs(along[2]) < 1 else np.array([0, 1.0, 0])
    bend /= np.linalg.norm(bend)
    frame = np.column_stack([np.cross(bend, along), bend, along])
    fork = [
        shapes.Capsule(0.06, 0.5, "z", at=(0, 0, -0.33)),
        *(shapes.Box((0.1, 0.03, 0.16), at=(0, y, -0.03)) for y in (-0.09, 0.09)),
    ]
    knuckle = [shapes.Cylinder(0.05, 0.15, "y"), shapes.Cylinder(0.04, 0.1, "z", at=(0, 0, 0.07))]
    hand = [
        shapes.Cylinder(0.05, 0.1, "z", at=(0, 0, 0.17)),
        *(shapes.Box((0.03, 0.02, 0.12), at=(x, 0, 0.28)) for x in (-0.05, 0.05)),
    ]
    start = np.column_stack([np.cross(bend, (0, 0, 1)), bend, (0, 0, 1)])
    links = [("fork", start, fork), ("knuckle", frame, knuckle), ("hand", frame, hand)]
    fork, knuckle, hand = (Body(name, 1.0, (0.01, 0.02, 0.01), orientation=R, shape=form) for name, R, form in links)
    turn = Revolute(GROUND, hand, axis=axis, name="wanted turn", **JOINT_PLACE)
    joints = [
        turn,
        Revolute(GROUND, fork, axis=(0, 0, 1), name="axis 4", **JOINT_PLACE),
        Revolute(fork, knuckle, axis=bend, name="axis 5", **JOINT_PLACE),
        Parallel(knuckle, hand, axis=along, name="axis 6"),
    ]
    driver = [AngleDriver(turn, Ramp(w), name="task")] if w else []
    return System([fork, knuckle, hand], joints + driver, gravity=(0, 0, 0))


def theory(*, w, miss_deg):
    """Return the rates from the bend 5, the angle between axes 4 and 6: w sin(miss)/sin^2(bend) for 4, -cos(bend) times
    that for 6.
    """
    require(0 < miss_deg < 90, f"demo 'wrist_singularity': miss_deg = {miss_deg:g}; give 0 < miss_deg < 90: at 0 the "
            "wrist is stretched, and axes 4 and 6 are one")  # fmt: skip
    miss = np.radians(miss_deg)
    return {"axis4_peak_rad_s": abs(w) / np.sin(miss), "axis6_peak_rad_s": abs(w) / np.tan(miss), "freedoms_lost": 1.0}


def measure(build, terms, *, w, miss_deg) -> Measured:
    """Measure the greatest rates on the way, and the rank that `check` misses in the stretched pose."""
    run = simulate(build(), np.pi / abs(w), method=Kinematic(), output=SAMPLES, **terms)
    rates, miss = [run.rate("axis 4"), run.rate("axis 6")], np.radians(miss_deg)
    bend = np.arccos(run.rotation("hand")[:, 2, 2])
    known = w * np.sin(miss) / np.sin(bend) ** 2
    half = slice(SAMPLES // 2, None)
    values = {
        "axis4_peak_rad_s": abs(rates[0]).max(),
        "axis6_peak_rad_s": abs(rates[1]).max(),
        "freedoms_lost": wrist(0.0, miss_deg, 0.0).check().rank - wrist(0.0, 0.0, 0.0).check().rank,
    }
    curves = [
        Curve("rate of axis 4 [rad/s]", run.t, rates[0], (run.t, known)),
        Curve(
            "rate of axis 4 [rad/s]",
            np.degrees(bend[half]),
            abs(rates[0][half]),
            (np.degrees(bend[half]), abs(known[half])),
            "bend of the wrist [deg]",
            logarithmic=True,
        ),
    ]
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="A stretched robot wrist",
    question="Why does a robot that moves its hand slowly and evenly suddenly whip its wrist round?",
    beats=(
        Beat(0.0, "The hand turns slowly and evenly."),
        Beat(1.3, "Two axes are nearly in line ..."),
        Beat(share(0.5), "... and the wrist whips round, 19 times as fast as the hand."),
    ),
    why="A wrist has three axes, and when it stretches out, the first and the last become one: then three motors turn "
    "the hand about two axes only. Just before that, a turn about the lost direction is still possible, as a small "
    "difference of two large turns in opposite senses. Their greatest rates go as one over the least bend, without "
    "limit. `check()` sees it coming: it calls a pose from which little is missing nearly singular and names the two "
    "axes, and in the stretched pose itself one row is lost. Controllers keep away from both.",
    equation="q_4' = w sin(miss) / sin^2(bend); q_6' = -q_4' cos(bend); miss <= bend",
    symbols={
        "q_4": Symbol("axis 4; its rate", "rad/s", curve=(0, 0)),
        "q_6": Symbol("axis 6; its rate", "rad/s", curve=(1, 0)),
        "w": Symbol("turning of the hand", "rad/s", "w"),
    },
    source="Siciliano, Sciavicco, Villani, Oriolo, Robotics: Modelling, Planning and Control (wrist singularities)",
    quantities={
        "axis4_peak_rad_s": Quantity("greatest rate of axis 4", "rad/s"),
        "axis6_peak_rad_s": Quantity("greatest rate of axis 6", "rad/s"),
        "freedoms_lost": Quantity("degrees of freedom that check() finds lost when it is stretched"),
    },
    ablation=Ablation("nearness", "a path that keeps away by 60 degrees asks for little", {"miss_deg": 60.0}),
    against=Against("miss_deg", 2.0, 88.0, "least bend of the wrist [deg]"),
    show={"curves": [("rate", "axis 4"), ("rate", "axis 6")], "traces": [("hand", (0, 0, 0.34))]},
    sliders=(Control("miss_deg", 2.0, 60.0, "deg", "miss of the straight wrist", logarithmic=True),),
    attempt="pass farther from the straight wrist: the whip becomes a slow turn.",
)
