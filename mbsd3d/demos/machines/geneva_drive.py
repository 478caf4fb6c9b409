"""A Geneva drive: a pin that turns evenly takes the wheel along by one slot a turn, and a cam holds it meanwhile."""

import numpy as np

from mbsd3d import GROUND, Body, PointOnPlane, Revolute, SpeedDriver, Switched, System, measures, shapes, simulate

from ..form import Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import most

TURNS, SAMPLES = 2, 1441  # [1] of the pin in a run
GAP = 1e-7  # [rad] of the driver in which neither pin nor cam holds the wheel
DRIVER_J = 2e-3  # [kg m^2]


def entry(slots, crank):
    """Return half the angle between slots, the throw over the distance of the shafts, and the angle of the pin before
    the line of the shafts where it reaches the slot [rad].
    """
    a = np.pi / slots
    ratio = crank * np.sin(a)
    require(slots >= 3 and crank >= 1.0 and ratio < 0.98,
            f"demo 'geneva_drive': {slots} slots, crank = {crank:g}; give 3 or more, and 1 or more")  # fmt: skip
    return a, ratio, np.pi - a - np.arcsin(np.sin(a) / ratio)


def cross(slots, C, directions, reach):
    """Return the shapes of a wheel with open slots."""
    wide, long = 0.09 * C, reach - 0.22 * C
    walls = []
    for turn in directions:
        along, across = np.array([np.cos(turn), np.sin(turn), 0]), np.array([-np.sin(turn), np.cos(turn), 0])
        quaternion = (np.cos(turn / 2), 0, 0, np.sin(turn / 2))
        walls += [shapes.Box((long, 0.7 * wide, 0.1 * C), at=(reach - long / 2) * along + side * 0.95 * wide * across,
                             orientation=quaternion, colour="steelblue") for side in (-1, 1)]  # fmt: skip
    return (shapes.Cylinder(0.3 * C, 0.12 * C, "z", colour="steelblue"), *walls)


def mechanism(*, slots=4, crank=1.0, C=0.1, w=4.0, J=8e-4) -> System:
    """Build a wheel, J [kg m^2], with slots, and a pin that turns at w [rad/s] about a shaft at C [m] from it; the
    throw is ``crank`` times the one with which the pin enters along the slot.
    """
    a, ratio, before = entry(slots, crank)
    hub, throw, reach = np.array([C, 0, 0]), ratio * C, C * np.sqrt(1 + ratio**2 - 2 * ratio * np.cos(before))
    directions = np.pi + a + 2 * a * np.arange(slots)
    form = (
        shapes.Cylinder(throw + 0.1 * C, 0.06 * C, "z", at=(0, 0, -0.15 * C), colour="darkgray"),
        shapes.Cylinder(0.05 * C, 0.24 * C, "z", at=(-throw, 0, -0.03 * C), colour="crimson"),
    )
    driver = Body("driver", 0.5, (DRIVER_J, DRIVER_J, DRIVER_J), com=(0, 0, 0), omega=(0, 0, w), shape=form)
    wheel = Body("wheel", 0.8, (0.6 * J, 0.6 * J, J), position=hub, shape=cross(slots, C, directions, reach))
    shaft = Revolute(GROUND, driver, at=(0, 0, 0), axis="z", name="driver shaft")
    output = Revolute(GROUND, wheel, at=hub, axis="z", name="wheel shaft")
    turned, held = measures.angle(shaft), PointOnPlane(GROUND, wheel, at=hub + (0.3 * C, 0, 0), normal="y")
    parts = [shaft, output, SpeedDriver(shaft, w, name="motor")]
    for k in range(TURNS + 1):
        start, end = 2 * np.pi * k + np.pi - before, 2 * np.pi * (k - 1) + np.pi + before
        parts.append(Switched(held, engage=turned > end + GAP if k else None, release=turned > start, engaged=k == 0,
                              name=f"cam {k + 1}"))  # fmt: skip
        along = np.array([np.cos(directions[k]), np.sin(directions[k]), 0])
        slot = PointOnPlane(wheel, driver, at=hub + reach * along, normal=(-along[1], along[0], 0))
        if k < TURNS:
            parts.append(Switched(slot, engage=turned > start + GAP, release=turned > start + 2 * before,
                                  name=f"slot {k + 1}"))  # fmt: skip
    return System([driver, wheel], parts, gravity=(0, 0, 0))


def motion(angle, ratio):
    """Return rate and acceleration of the wheel by those of the pin, -, and distance of pin and hub over that of the
    shafts, with the pin at an angle from the line of the shafts [rad]: tan(phi) = q sin / (1 - q cos).
    """
    square = 1 - 2 * ratio * np.cos(angle) + ratio**2
    rate = ratio * (np.cos(angle) - ratio) / square
    return rate, -ratio * (1 - ratio**2) * np.sin(angle) / square**2, np.sqrt(square)


def theory(*, slots, crank, C, w, J):
    """Return knocks as plastic impacts, and the greatest rate and force by the closed form of the motion."""
    require(w > 0.0, f"demo 'geneva_drive': w = {w:g} rad/s; give a speed above 0")
    a, ratio, before = entry(slots, crank)
    struck = w * motion(before, ratio)[0]
    sum_ = 1 + ratio**2
    steepest = np.arccos((np.sqrt(sum_**2 + 60 * ratio**2) - sum_) / (6 * ratio))  # of sin / square^(5/2)
    _, acceleration, arm = motion(steepest, ratio)
    return {
        "knocks_mJ": 1e3 * J * struck**2, "step_deg": np.degrees(2 * a), "fastest_rad_s": w * ratio / (1 - ratio),
        "rests": 1 - before / np.pi, "force_N": J * w**2 * abs(acceleration) / (C * arm),
    }  # fmt: skip


def peak(y):
    """Return the greatest value, by a polynomial through the largest sample and three on each side."""
    k, places = int(np.argmax(y)), np.arange(-3, 4)
    return float(np.polyval(np.polyfit(places, y[k + places], 6), np.linspace(-1, 1, 2001)).max())


def measure(build, terms, *, slots, crank, C, w, J) -> Measured:
    """Measure two turns of the pin: knocks, step and rest of the first one, and the press of the pin in its slot."""
    turn = 2 * np.pi / w
    run = simulate(build(), TURNS * turn, rtol=1e-11, output=SAMPLES, **terms)
    rate, force = run.rate("wheel shaft"), np.linalg.norm(run.reaction("slot 1").force, axis=1)
    events = [event for event in run.events if event.t < turn]
    at = {(event.part, event.action): event.t for event in events}
    holds = at["cam 2", "engages"] - at["cam 1", "is released"]
    values = {
        "knocks_mJ": 1e3 * sum(event.lost for event in events),
        "step_deg": np.degrees(abs(run.angle("wheel shaft")[-1])) / TURNS, "fastest_rad_s": np.abs(rate).max(),
        "rests": 1 - holds / turn, "force_N": peak(force),
    }  # fmt: skip
    _, ratio, before = entry(slots, crank)
    angle = np.remainder(w * run.t, 2 * np.pi) - np.pi
    known, acceleration, arm = (np.where(abs(angle) < before, x, 0.0) for x in motion(angle, ratio))
    press = [np.linalg.norm(run.reaction(f"slot {k + 1}").force, axis=1) for k in range(TURNS)]
    pressed = J * w**2 * np.abs(acceleration) / np.where(arm, C * arm, 1.0)
    curves = [
        Curve("speed of the wheel [rad/s]", run.t, -rate, (run.t, w * known)),
        Curve("press of the pin [N]", run.t, np.sum(press, axis=0), (run.t, pressed)),
    ]
    return Measured(values, [run], curves)


demo = Demo(
    __name__,
    title="Step by step from an even turn",
    question="How does a motor that never stops move a film picture by picture?",
    beats=(
        Beat(0.0, "The pin goes round, and a cam holds the wheel."),
        Beat(0.592, "The pin enters along the slot: no knock."),
        Beat(most(lambda run: -run.rate('wheel shaft')), "Half way the wheel runs 2.4 times as fast as the pin."),
        Beat(0.985, "It stands again, a quarter on, and the pin goes its way."),
    ),
    why="The pin meets the slot where its path runs along it: at this moment it moves the wheel not at all, takes it "
    "up gently and leaves it at rest again. That is so for one throw alone, the distance of the shafts times the sine "
    "of half the angle between slots. With a longer one the pin strikes the side of the slot and throws the wheel "
    "against its cam. Also with the right one the torque begins at once, and it grows fast with fewer slots.",
    equation="w_2 = w q (cos(theta) - q)/(1 - 2 q cos(theta) + q^2); q = r/C = sin(pi/n)",
    symbols={
        "w_2": Symbol("wheel", "rad/s", curve=(0, 0)),
        "w": Symbol("pin", "rad/s", "w"),
        "theta": Symbol("pin, from the line of the shafts", "rad"),
        "q": Symbol("throw over distance", "", lambda slots, crank: crank * float(np.sin(np.pi / slots))),
        "r": Symbol("throw", "m", lambda slots, crank, C: crank * C * float(np.sin(np.pi / slots))),
        "C": Symbol("distance of the shafts", "m", "C"),
        "n": Symbol("slots", "", "slots"),
    },
    source="Bickford, Mechanisms for Intermittent Motion (1972), external Geneva; knocks worked out here",
    quantities={
        "knocks_mJ": Quantity("energy of the knocks of a turn", "mJ", relative=1e-5, absolute=1e-9),
        "step_deg": Quantity("turn of the wheel a turn of the pin", "deg", absolute=1e-6),
        "fastest_rad_s": Quantity("greatest speed of the wheel", "rad/s", relative=1e-7),
        "rests": Quantity("part of the time in which it stands", "-", absolute=1e-6),
        "force_N": Quantity("greatest press of the pin", "N", relative=1e-5),
    },
    alone="other engines have no joints that come and go",
    ablation=Ablation("the right throw", "the pin strikes the slot, and the wheel its cam", {"crank": 1.06}),
    against=Against("crank", 1.0, 1.1, "throw over the right one [-]", computed=6),
    show={"curves": [("rate", "wheel shaft")], "traces": [], "view": (-90, 55),
          "speed": 0.5, "hidden": ["joints", "joint names", "body names"]},
    ranges={"crank": (1.01, 1.08)},
)  # fmt: skip
