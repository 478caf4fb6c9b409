"""A slider-crank with play in its piston pin: it knocks, and the speed of the knock grows with the play."""

import numpy as np
from scipy.optimize import brentq

from mbsd3d import (
    GROUND,
    AngleDriver,
    Body,
    PointOnPlane,
    PointStop,
    Prismatic,
    Ramp,
    Revolute,
    System,
    shapes,
    simulate,
)

from ..form import Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol, require

SAMPLES = 721
PIN_RADIUS_RATIO = 0.2  # [1] of the throw


def carriage(play, R):
    """Return the shapes of a piston whose jaws leave a pin the play [m], and the radius of the pin [m]."""
    pin = PIN_RADIUS_RATIO * R
    inner, thick, high = pin + play / 2, 0.35 * R, 0.8 * R
    jaws = [shapes.Box((thick, high, 0.5 * R), at=(x * (inner + thick / 2), 0, 0), colour="steelblue") for x in (-1, 1)]
    bars = [shapes.Box((2 * (inner + thick), 0.12 * R, 0.5 * R), at=(0, y * high / 2, 0), colour="steelblue")
            for y in (-1, 1)]  # fmt: skip
    return (*jaws, *bars), pin


def mechanism(*, R=0.045, L=0.15, w=100.0, play=0.008, m=0.5) -> System:
    """Build a crank R and a rod L [m] at w [rad/s] from the outer dead centre on, and a piston m [kg] whose bearing
    leaves the pin a play along the bore [m].
    """
    end, (form, pin) = np.array([R + L, 0, 0]), carriage(play, R)
    web = shapes.Box((1.3 * R, 0.35 * R, 0.2 * R), at=(0.5 * R, 0, -0.4 * R), colour="dimgray")
    shank = shapes.Box((L, 0.2 * R, 0.15 * R), colour="darkorange")
    gudgeon = shapes.Cylinder(pin, 0.9 * R, "z", at=(L / 2, 0, 0), colour="crimson")
    crank = Body("crank", 2.0, (4e-3, 4e-3, 4e-3), shape=web)
    rod = Body("rod", 0.3, (1e-3, 1e-3, 1e-3), position=(R + L / 2, 0, 0), shape=(shank, gudgeon))
    piston = Body("piston", m, (3e-4, 3e-4, 3e-4), position=end, shape=form)
    main = Revolute(GROUND, crank, at=(0, 0, 0), axis="z", name="main bearing")
    joints = [
        main,
        Revolute(crank, rod, at=(R, 0, 0), axis="z", name="big end"),
        Prismatic(GROUND, piston, at=end, axis="x", name="bore"),
        PointOnPlane(piston, rod, at=end, normal="y", name="pin across the bore"),
        AngleDriver(main, Ramp(w), name="motor"),
    ]
    stop = {"lower": -play / 2, "upper": play / 2, "restitution": 0.0}
    bearing = PointStop(piston, rod, at=end, axis="x", name="bearing", **stop)
    return System([crank, rod, piston], joints, [bearing], gravity=(0, 0, 0))


def along(angle, R, L):
    """Return place of the pin along the bore [m], its derivative by the angle, and the second one."""
    s, c, root = np.sin(angle), np.cos(angle), np.sqrt(L**2 - (R * np.sin(angle)) ** 2)
    bent = (c * c - s * s) / root + (R * s * c) ** 2 / root**3
    return R * c + root, -R * s * (1 + R * c / root), -R * c - R * R * bent


def flight(play, R, L, low):
    """Return the angles at which the piston leaves the pin and lands [rad], from a dead centre at ``low`` on."""
    leaves = brentq(lambda angle: along(angle, R, L)[2], low + 0.3, low + np.pi - 0.3, xtol=1e-15)
    place, rate, _ = along(leaves, R, L)

    def gap(angle):
        return abs(along(angle, R, L)[0] - place - rate * (angle - leaves)) - play

    require(gap(low + np.pi) > 0.0, f"demo 'crank_play': a play of {play:g} m lasts beyond the dead centre; give less")
    return leaves, brentq(gap, leaves, low + np.pi, xtol=1e-15)


def theory(*, R, L, w, play, m):
    """Return both knocks of a turn: free flight from where the pin is fastest until it is a play behind or ahead."""
    require(0 < R < L and play > 0.0, "demo 'crank_play': give a throw below the length of the rod, and a play above 0")
    (leaves, lands), (_, lands_back) = flight(play, R, L, 0.0), flight(play, R, L, np.pi)
    out, back = (w * abs(along(b, R, L)[1] - along(a, R, L)[1])
                 for a, b in ((leaves, lands), flight(play, R, L, np.pi)))  # fmt: skip
    return {
        "knock_m_s": out, "lets_go_deg": np.degrees(leaves), "knocks_deg": np.degrees(lands),
        "knocks_back_deg": np.degrees(lands_back), "heat_J": 0.5 * m * (out**2 + back**2),
    }  # fmt: skip


def measure(build, terms, *, R, L, w, play, m) -> Measured:
    """Measure the second turn, as the first one begins with a play to close."""
    turn = 2 * np.pi / w
    run = simulate(build(), 2 * turn, rtol=1e-11, output=SAMPLES, **terms)
    events = [event for event in run.events if event.t > turn]
    hit, back = [event for event in events if event.lost > 0.0][:2]
    left = next(event for event in events if event.action == "is left")
    values = {
        "knock_m_s": np.sqrt(2 * hit.lost / m), "lets_go_deg": np.degrees(w * left.t) - 360,
        "knocks_deg": np.degrees(w * hit.t) - 360, "knocks_back_deg": np.degrees(w * back.t) - 360,
        "heat_J": hit.lost + back.lost,
    }  # fmt: skip
    angle = np.degrees(w * run.t)
    where = 1e3 * (along(w * run.t, R, L)[0] - run.position("piston")[:, 0])
    curves = [
        Curve("place of the pin in its bearing [mm]", angle, where, along="angle of the crank [deg]"),
        Curve("speed of the piston [m/s]", angle, run.velocity("piston")[:, 0],
              (angle, w * along(w * run.t, R, L)[1]), along="angle of the crank [deg]",
              title="theory: that of the pin"),
    ]  # fmt: skip
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="The pin that knocks",
    question="Why does a worn engine knock, and why so much louder as it wears?",
    beats=(
        Beat(0.0, "The pin sits in a hole that is too wide."),
        Beat(0.0758, "Here the piston lets go of its pin ..."),
        Beat(0.0860, "... and here it knocks."),
    ),
    why="The rod pulls the piston and pushes it in turn. Where the pull ends, half way, nothing holds the piston to "
    "its pin, and it flies on through the play while the pin slows down. It is caught by the other side with the "
    "difference of both speeds. That difference grows with the square of the time of flight and the way with its cube, "
    "so eight times the play knocks four times as fast.",
    equation="s_ddot = 0: it lets go; s - s_0 - v_0 t = play: it knocks; v about (9 j play^2/2)^(1/3)",
    symbols={
        "s": Symbol("where the pin is", "m"),
        "s_0": Symbol("where it was let go", "m"),
        "v_0": Symbol("speed there", "m/s"),
        "v": Symbol("speed of the knock", "m/s"),
        "t": Symbol("time of the flight", "s"),
        "j": Symbol("how fast the acceleration of the pin changes", "m/s^3"),
    },
    source="kinematics of the slider-crank and free flight; worked out here",
    quantities={
        "knock_m_s": Quantity("speed of the first knock", "m/s", relative=1e-7),
        "lets_go_deg": Quantity("crank angle where the piston lets go", "deg", absolute=1e-5),
        "knocks_deg": Quantity("crank angle of the first knock", "deg", absolute=1e-5),
        "knocks_back_deg": Quantity("crank angle of the second one", "deg", absolute=1e-5),
        "heat_J": Quantity("energy of both knocks", "J", relative=1e-6),
    },
    alone="other engines have no stops that strike at events",
    ablation=Ablation("play", "the pin fits, and nothing knocks that one could hear", {"play": 2e-5}),
    against=Against("play", 2e-4, 0.012, "play [m]"),
    show={"curves": [("rate", "bore")], "traces": [], "view": (-90, 60),
          "hidden": ["joints", "joint names", "body names"]},
    ranges={"play": (0.004, 0.01)},
)  # fmt: skip
