"""A gear that idles with play between its teeth: the uneven turn of the engine throws it from flank to flank."""

import numpy as np
from scipy.optimize import brentq

from mbsd3d import (
    GROUND,
    AngleDriver,
    Backlash,
    Body,
    Gear,
    Revolute,
    Sine,
    System,
    Torque,
    shapes,
    simulate,
)

from ..figure import Line
from ..form import Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol, require

TEETH, R = 12, 0.15  # [1], [m] of both gears at the pitch circle
TURNS, FILMED, PER_TURN = 60, 4, 144  # [1] of the engine: until it repeats itself, of the film; samples


def wheel(first, play, colour):
    """Return the shapes of a gear whose teeth leave half of the play [rad], one of them at an angle [rad]."""
    thick, core = (2 * np.pi / TEETH - play) * R / 2, R - 0.03
    turns = first + 2 * np.pi / TEETH * np.arange(TEETH)
    teeth = [
        shapes.Box((0.06, thick, 0.05), at=(R * np.cos(turn), R * np.sin(turn), 0),
                   orientation=(np.cos(turn / 2), 0, 0, np.sin(turn / 2)), colour=colour)
        for turn in turns
    ]  # fmt: skip
    return (shapes.Cylinder(core, 0.05, "z", colour=colour), *teeth)


def mechanism(*, swing=0.06, w=6.0, play=0.2, bounce=0.6, J=0.2, load=0.0) -> System:
    """Build an engine gear that swings by ``swing`` [rad] at w [rad/s] about its even turn, as one sees it who turns
    along, and a gear J [kg m^2] that meshes with a play [rad], restitution ``bounce``; it pulls a load [N m].
    """
    require(play < np.pi / TEETH, f"demo 'gear_rattle': play = {play:g} rad; give less than {np.pi / TEETH:.3g}")
    driver = Body("engine gear", 1.0, (0.05, 0.05, 0.1), omega=(0, 0, -swing * w), shape=wheel(0, play, "darkorange"))
    form, spin = wheel(np.pi - np.pi / TEETH, play, "steelblue"), 0.5 * play * w
    loose = Body("loose gear", 2.0, (0.6 * J, 0.6 * J, J), position=(2 * R, 0, 0), omega=(0, 0, spin), shape=form)
    fast = Revolute(GROUND, driver, at=(0, 0, 0), axis="z", name="engine shaft")
    slow = Revolute(GROUND, loose, at=(2 * R, 0, 0), axis="z", name="loose shaft")
    engine = AngleDriver(fast, Sine(-swing, w / (2 * np.pi)), name="engine")
    teeth = Backlash(Gear(fast, slow, ratio=-1.0), angle=play, restitution=bounce, name="teeth")
    return System([driver, loose], [fast, slow, engine], [teeth, Torque(loose, (0, 0, -load), name="load")],
                  gravity=(0, 0, 0))  # fmt: skip


def flight(swing, w, play, bounce):
    """Return speed [rad/s] and phase [rad] of flights from flank to flank, half a turn each.

    In half a turn the gear flies twice the way of the flank and the play; the flank turns its speed round if it
    runs along with (1 - e)/(1 + e) of it against the impact.
    """

    def speed(phase):
        return 2 * w / np.pi * (swing * np.sin(phase) + play / 2)

    def missing(phase):
        return swing * w * np.cos(phase) + speed(phase) * (1 - bounce) / (1 + bounce)

    require(missing(np.pi) < 0, f"demo 'gear_rattle': a swing of {swing:g} rad is too small for this play; give more")
    phase = brentq(missing, np.pi / 2, np.pi, xtol=1e-15)
    return speed(phase), phase


def theory(*, swing, w, play, bounce, J, load):
    """Return heat of a turn, impacts, and greatest speed: of a gear that flies, or of one that follows its flank."""
    if load > J * w**2 * swing:
        return {"heat_mJ": 0.0, "impacts": 0.0, "fastest_rad_s": swing * w}
    require(load == 0.0, f"demo 'gear_rattle': load = {load:g} N m; give 0, or more than {J * w**2 * swing:.4g}")
    speed, phase = flight(swing, w, play, bounce)
    meets = speed - swing * w * np.cos(phase)
    return {"heat_mJ": 1e3 * J * (1 - bounce**2) * meets**2, "impacts": 2.0, "fastest_rad_s": speed}


def measure(build, terms, *, swing, w, play, bounce, load) -> Measured:
    """Measure the last of many turns, when the motion repeats itself."""
    turn = 2 * np.pi / w
    seen = np.linspace(TURNS - 2, TURNS, 2 * PER_TURN + 1) * turn  # the curves; before them only the start is kept
    run = simulate(build(), TURNS * turn, rtol=1e-11, output=np.append(0.0, seen), **terms)
    film = simulate(build(), FILMED * turn, rtol=1e-11, output=FILMED * PER_TURN + 1, **terms)
    begins = (TURNS - 1) * turn
    hits = [event for event in run.events if event.t > begins]
    values = {
        "heat_mJ": 1e3 * sum(event.lost for event in hits), "impacts": len(hits),
        "fastest_rad_s": np.abs(run.rate("loose shaft")[run.t > begins]).max(),
    }  # fmt: skip
    late = slice(1, None)
    turns = run.t[late] / turn - TURNS + 2
    flank = swing * w * np.cos(2 * np.pi * turns)
    known = flank
    if not load:
        speed, phase = flight(swing, w, play, bounce)
        known = np.where(np.remainder(2 * np.pi * turns - phase, 2 * np.pi) < np.pi, -speed, speed)
    curves = [
        Curve("speed [rad/s]", turns, run.rate("loose shaft")[late], (turns, known), name="loose gear",
              more=[Line("flanks", -run.rate("engine shaft")[late], theory=(turns, flank))],
              along="turns of the engine [-]"),
        Curve("play between the teeth [rad]", turns, (run.angle("loose shaft") + run.angle("engine shaft"))[late],
              along="turns of the engine [-]"),
    ]  # fmt: skip
    return Measured(values, [film, run], curves)


demo = Demo(
    __name__,
    title="The gear that rattles while it idles",
    question="Why does a gearbox rattle at idle, and fall silent as soon as it pulls?",
    beats=(
        Beat(0.0, "The engine turns unevenly; one who turns along sees it swing."),
        Beat(lambda run: run.events[0].t, "Its flank strikes the loose gear ..."),
        Beat(lambda run: run.events[1].t, "... which crosses the play and strikes the other one."),
    ),
    why="Nothing holds a gear that idles. The flank that swings to it throws it off, it crosses the play at an even "
    "speed and is thrown back by the other flank, twice a turn. Each impact turns energy to heat and noise, and the "
    "engine makes it up since its flank meets the gear. A load presses the gear to one flank. Where it is larger than "
    "the torque that makes the gear follow the swing, the teeth never part.",
    equation="pi v = 2 w (a sin(phi) + s/2); a w cos(phi) = -v (1 - e)/(1 + e); silent: T > J w^2 a",
    symbols={
        "v": Symbol("loose gear", "rad/s", curve=(0, 0)),
        "w": Symbol("engine", "rad/s", "w"),
        "a": Symbol("swing", "rad", "swing"),
        "phi": Symbol("phase of the swing at an impact", "rad"),
        "s": Symbol("play", "rad", "play"),
        "e": Symbol("restitution", "", "bounce"),
        "T": Symbol("load", "N m", "load"),
        "J": Symbol("loose gear", "kg m^2", "J"),
    },
    source="law of impact and free flight; worked out here",
    quantities={
        "heat_mJ": Quantity("heat of the impacts of a turn", "mJ", relative=1e-6, absolute=1e-6),
        "impacts": Quantity("impacts a turn", "-"),
        "fastest_rad_s": Quantity("speed of the loose gear", "rad/s", relative=1e-7),
    },
    alone="other engines have no teeth with play that strike at events",
    ablation=Ablation("idling", "a load holds the teeth together, and nothing rattles", {"load": 0.55}),
    against=Against("play", 0.17, 0.25, "play between the teeth [rad]", computed=4),
    show={"curves": [("rate", "loose shaft")], "traces": [], "view": (-90, 65), "speed": 0.5,
          "hidden": ["joints", "joint names", "body names"]},
    ranges={"swing": (0.057, 0.063), "play": (0.19, 0.22), "bounce": (0.57, 0.63)},
    may_vanish=("load",),
)  # fmt: skip
