"""A screw that is flung, raises its load and is let go: friction decides whether it stays up."""

import numpy as np

from mbsd3d import GROUND, Body, DryFriction, Prismatic, Revolute, Screw, System, shapes, simulate

from ..form import Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import first

G = 9.81  # m/s^2
T_END, SAMPLES = 4.0, 401  # [s] of the run
LENGTH, ARM = 0.36, 0.16  # [m] of the spindle, and of its handle
COIL = 24  # [1] points of a turn of the drawn thread


def spindle(J, R, pitch, w):
    """Return the screw with its handle and two weights, J [kg m^2] about z, its thread drawn."""
    turn = np.arange(int(COIL * LENGTH / pitch)) * 2 * np.pi / COIL
    thread = np.column_stack([R * np.cos(turn), R * np.sin(turn), pitch * turn / (2 * np.pi)])
    form = (
        shapes.Cylinder(0.9 * R, LENGTH, "z", at=(0, 0, LENGTH / 2), colour="silver"),
        shapes.Lines(thread, colour="black"),
        shapes.Cylinder(0.25 * R, 2 * ARM, "x", at=(0, 0, -0.01), colour="dimgray"),
        *(shapes.Sphere(0.03, at=(x, 0, -0.01), colour="crimson") for x in (-ARM, ARM)),
    )
    return Body("screw", 5.0, (0.6 * J + 0.05, 0.6 * J + 0.05, J), omega=(0, 0, w), shape=form)


def mechanism(*, m=20.0, R=0.03, pitch=0.03, mu=0.2, J=0.1, w=20.0) -> System:
    """Build a load m [kg] on a screw of a mean radius and a pitch [m], with friction in its thread; the handle, J [kg
    m^2] in all, is flung at w [rad/s].
    """
    screw = spindle(J, R, pitch, w)
    plate = shapes.Box((0.28, 0.2, 0.03), colour="steelblue"), shapes.Cylinder(1.6 * R, 0.05, "z", at=(0, 0, -0.03))
    weight = shapes.Box((0.2, 0.16, 0.12), at=(0, 0, LENGTH - 0.02), colour="darkorange")
    posts = [shapes.Box((0.02, 0.02, LENGTH - 0.06), at=(x, 0, 0.5 * LENGTH - 0.02), colour="steelblue")
             for x in (-0.1, 0.1)]  # fmt: skip
    load = Body("load", m, (0.02 * m,) * 3, position=(0, 0, 0.1), shape=(*plate, weight, *posts))
    bearing = Revolute(GROUND, screw, at=(0, 0, 0), axis="z", name="bearing")
    column = Prismatic(GROUND, load, at=load.position, axis="z", name="column")
    thread = Screw(screw, load, at=(0, 0, 0.1), axis="z", pitch=-pitch, name="thread")
    friction = [DryFriction(thread, mu=mu, thread_radius=R, name="friction")] if mu else []
    return System([screw, load], [bearing, column, thread], friction, gravity=(0, 0, -G))


def motion(t, *, m, R, pitch, mu, J, w):
    """Return the height [m] over time: J w' = -F R tan(lead + friction angle), m r w' = F - m g with r = R tan(lead).

    Friction turns round with the motion, and holds the screw where the lead is below the friction angle.
    """
    lead, phi, arm = np.arctan2(pitch, 2 * np.pi * R), np.arctan(mu), pitch / (2 * np.pi)

    def slows(angle):
        lever = R * np.tan(angle)
        return m * G * lever / (J + m * arm * lever)

    end = w / slows(lead + phi)
    up = w * np.minimum(t, end) - 0.5 * slows(lead + phi) * np.minimum(t, end) ** 2
    back = slows(lead - phi) if lead > phi else 0.0
    return arm * (up - 0.5 * back * np.maximum(t - end, 0.0) ** 2), end


def theory(*, m, R, pitch, mu, J, w):
    """Return the height at the end, the highest one, and the efficiency tan(lead) / tan(lead + friction angle)."""
    require(w > 0.0, f"demo 'screw_jack': w = {w:g} rad/s; give a speed above 0, upwards")
    numbers = {"m": m, "R": R, "pitch": pitch, "mu": mu, "J": J, "w": w}
    at_end, end = motion(T_END, **numbers)
    require(end < T_END, f"demo 'screw_jack': the load rises for {end:.3g} s, longer than the run; give less w or J")
    lead = np.arctan2(pitch, 2 * np.pi * R)
    return {
        "at_end_mm": 1e3 * float(at_end), "highest_mm": 1e3 * float(motion(end, **numbers)[0]),
        "efficiency": np.tan(lead) / np.tan(lead + np.arctan(mu)),
    }  # fmt: skip


def measure(build, terms, *, m, R, pitch, mu, J, w) -> Measured:
    """Measure the height where the screw stands or turns round, and at the end; efficiency by energies of the rise."""
    run = simulate(build(), T_END, output=SAMPLES, rtol=1e-10, **terms)
    height, numbers = run.position("load")[:, 2] - 0.1, {"m": m, "R": R, "pitch": pitch, "mu": mu, "J": J, "w": w}
    known, _ = motion(run.t, **numbers)
    speed, braking = run.velocity("load")[:, 2], -run.acceleration("load")[:, 2]
    last = int(np.argmax(speed < 0.05 * speed[0])) - 1
    top = height[last] + 0.5 * speed[last] ** 2 / braking[last]  # braked evenly to the turn
    gained = m * G * top - 0.5 * m * speed[0] ** 2  # by the load, from the thread
    values = {"at_end_mm": 1e3 * height[-1], "highest_mm": 1e3 * top, "efficiency": gained / (0.5 * J * w**2)}
    curves = [
        Curve("height of the load [mm]", run.t, 1e3 * height, (run.t, 1e3 * known)),
        Curve("speed of the screw [rad/s]", run.t, run.rate("bearing")),
    ]
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="The jack that holds by itself",
    question="Why does a car on a screw jack stay up when one lets go of the handle?",
    beats=(
        Beat(0.0, "The handle turns, the load rises."),
        Beat(first(lambda run: np.abs(run.rate('bearing')) < 1e-3),
             "Let go, it stays: friction holds what the thread would let down."),
    ),
    why="Unwound, a thread is a slope. The load slides down a slope that is steeper than its friction angle and rests "
    "on a flatter one, whatever it weighs. Such a screw holds by itself, and pays for it: less than half of the work "
    "of the hand arrives at the load, since friction takes more on the way up than the weight could give on the way "
    "down.",
    equation="M = F R tan(lead +- phi); tan(lead) = pitch/(2 pi R); it holds for phi > lead",
    symbols={
        "M": Symbol("moment at the handle", "N m"),
        "F": Symbol("load", "N", lambda m: 9.81 * m),
        "R": Symbol("thread", "m", "R"),
        "phi": Symbol("friction angle", "rad", lambda mu: float(np.arctan(mu))),
    },
    source="Shigley, Mechanical Engineering Design, power screws; motion worked out here",
    quantities={
        "at_end_mm": Quantity("height at the end", "mm", absolute=1e-6),
        "highest_mm": Quantity("greatest height", "mm"),
        "efficiency": Quantity("work on the load over that of the hand", "-", relative=1e-7),
    },
    alone="other engines have no friction that follows the load of a thread",
    ablation=Ablation("friction", "it rises higher, stops, and runs back down", {"mu": 0.0}),
    against=Against("mu", 0.0, 0.3, "friction in the thread [-]", computed=7),
    show={"curves": [("position", "load"), ("rate", "bearing")], "traces": [], "view": (-60, 12), "speed": 1.0,
          "hidden": ["joints", "joint names"]},
    ranges={"mu": (0.17, 0.25)},
)  # fmt: skip
