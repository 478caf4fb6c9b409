"""A door that is flung open, strikes its stop, swings back and is caught by its latch: what do the hinges feel?"""

import numpy as np

from mbsd3d import (
    GROUND,
    Body,
    EndStop,
    PointOnPlane,
    Revolute,
    Switched,
    System,
    TorsionSpring,
    measures,
    shapes,
    simulate,
)

from ..form import Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol, require

HEIGHT, THICKNESS = 2.0, 0.04  # [m]
SAMPLES, LONGER = 401, 1.25  # [1] of the run, its length over the time until the latch


def mechanism(*, m=20.0, b=0.9, d=0.85, w=3.5, opens=1.7, rebound=0.4, closer=6.0) -> System:
    """Build a door m [kg], b [m] wide, with a latch d [m] from its hinges, flung open at w [rad/s] as far as a stop at
    an angle [rad] with a restitution, against a closer [N m/rad].
    """
    require(0.0 < d <= b, f"demo 'latched_door': d = {d:g} m; give a latch on the door, above 0 and up to {b:g}")
    inertia = m / 12 * np.array([HEIGHT**2, b**2 + HEIGHT**2, b**2])  # of a plate
    leaf = shapes.Box((b, THICKNESS, HEIGHT), colour="burlywood")
    knob = shapes.Cylinder(0.035, 5 * THICKNESS, "y", at=(d, 0, 0), colour="crimson")
    post = shapes.Cylinder(0.03, 1.1 * HEIGHT, "z", at=(0, 0, 0), colour="dimgray")
    door = Body("door", m, inertia, com=(b / 2, 0, 0), omega=(0, 0, w), shape=(leaf, knob, post))
    hinge = Revolute(GROUND, door, at=(0, 0, 0), axis="z", name="hinge")
    bolt = PointOnPlane(GROUND, door, at=(d, 0, 0), normal="y")
    latch = Switched(bolt, engage=measures.angle(hinge) < 0.0, name="latch")
    forces = [
        TorsionSpring(hinge, stiffness=closer, name="closer"),
        EndStop(hinge, upper=opens, restitution=rebound, name="stop"),
    ]
    return System([door], [hinge, latch], forces, gravity=(0, 0, 0))


def theory(*, m, b, d, w, opens, rebound, closer):
    """Return the blow on the hinges by both momenta, the energies of both impacts, and when the latch catches."""
    J = m * b**2 / 3
    root = np.sqrt(closer / J)  # of the swing of the closer [rad/s]
    require(w > root * opens, f"demo 'latched_door': w = {w:g} rad/s does not reach the stop; give {root * opens:.3g}")
    at_stop = np.sqrt(w**2 - (root * opens) ** 2)
    back = np.hypot(rebound * at_stop, root * opens)
    out = np.arcsin(root * opens / w) / root
    return {
        "blow_N_s": m * b / 2 * back - J * back / d, "stop_J": 0.5 * (1 - rebound**2) * J * at_stop**2,
        "latch_J": 0.5 * J * back**2, "caught_s": out + np.arctan2(root * opens, rebound * at_stop) / root,
    }  # fmt: skip


def motion(t, known, *, m, b, w, opens, rebound, closer):
    """Return the angle over the time [rad]: swings of the closer, before the stop and after it."""
    root = np.sqrt(3 * closer / (m * b**2))
    before = np.minimum(t, np.arcsin(root * opens / w) / root)
    tau = root * (np.minimum(t, known["caught_s"]) - before)
    at_stop = np.sqrt((w / root) ** 2 - opens**2)
    return np.where(t > before, opens * np.cos(tau) - rebound * at_stop * np.sin(tau), w / root * np.sin(root * before))


def measure(build, terms, *, m, b, w, opens, rebound, closer) -> Measured:
    """Measure both impacts."""
    run = simulate(build(), LONGER * build.theory["caught_s"], rtol=1e-11, output=SAMPLES, **terms)
    stop, latch = run.events
    values = {
        "blow_N_s": latch.impulses["hinge"].force[1], "stop_J": stop.lost, "latch_J": latch.lost, "caught_s": latch.t,
    }  # fmt: skip
    numbers = {"m": m, "b": b, "w": w, "opens": opens, "rebound": rebound, "closer": closer}
    known = np.degrees(motion(run.t, build.theory, **numbers))
    curves = [
        Curve("angle of the door [deg]", run.t, np.degrees(run.angle("hinge")), (run.t, known)),
        Curve("kinetic energy [J]", run.t, run.energy().kinetic),
    ]
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="Where a door is best caught",
    question="Where must a door be caught so that its hinges feel nothing of it?",
    beats=(
        Beat(0.0, "The door is flung open ..."),
        Beat(lambda run: run.events[0].t, "... strikes its stop, and loses most of its energy."),
        Beat(lambda run: run.events[1].t, "The closer has brought it back; the latch catches it."),
    ),
    why="The latch must take all of the angular momentum about the hinges, so its blow is the stronger the nearer to "
    "them it is. What the door has of plain momentum is fixed. A latch at the edge takes too little of it, and the "
    "hinges take the rest; one near the hinges takes too much, and they are torn the other way. At two thirds of the "
    "width, the centre of percussion, both are right, and the hinges feel nothing.",
    equation="P d = J w_2; P + H = m b w_2/2; H = 0: d = 2 b/3",
    symbols={
        "P": Symbol("blow of the latch", "N s"),
        "H": Symbol("blow on the hinges", "N s"),
        "d": Symbol("latch", "m", "d"),
        "b": Symbol("width", "m", "b"),
        "m": Symbol("door", "kg", "m"),
        "J": Symbol("about the hinges", "kg m^2", lambda m, b: m * b**2 / 3),
        "w_2": Symbol("speed at the latch", "rad/s"),
    },
    source="momentum in a plastic impact, centre of percussion; worked out here",
    quantities={
        "blow_N_s": Quantity("blow on the hinges as the latch catches", "N s", relative=1e-7, absolute=1e-7),
        "stop_J": Quantity("energy lost at the stop", "J", relative=1e-7),
        "latch_J": Quantity("energy lost at the latch", "J", relative=1e-7),
        "caught_s": Quantity("time at which it is caught", "s", relative=1e-8),
    },
    alone="other engines have no latch that engages",
    ablation=Ablation("the wrong place", "the latch at two thirds of the width spares the hinges", {"d": 0.6}),
    against=Against("d", 0.4, 0.9, "distance of the latch from the hinges [m]", computed=6),
    show={"curves": [("rate", "hinge")], "traces": [], "view": (-60, 30), "speed": 0.5,
          "hidden": ["joints", "joint names", "body names"]},
    ranges={"d": (0.5, 0.72), "w": (3.3, 4.0), "opens": (1.5, 1.8)},
)  # fmt: skip
