"""A block and tackle: every fall carries its share, and friction on the sheaves takes more with every one."""

from typing import cast

import numpy as np

from mbsd3d import GROUND, Body, Prismatic, Pulley, Revolute, Rope, SpeedDriver, System, Winch, shapes, simulate

from ...results.element_loads import RopeLoad
from ..figure import Line
from ..form import GRAVITY, Ablation, Against, Beat, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

G = 9.81  # m/s^2
DEPTH = 1.6  # [m] of the load below the beam
SETTLED = 0.5  # [1] of the run, after which tensions are those of even motion


def mechanism(*, m=60.0, falls=4, mu=0.12, R=0.08, w=4.0, stiffness=2e5) -> System:
    """Build a load m [kg] on an even number of falls, over sheaves of R [m] that do not turn, friction mu on them; a
    drum of the same radius takes the rope in at w [rad/s], < 0: pays it out. ``stiffness`` of the rope [N/m].
    """
    require(falls >= 2 and falls % 2 == 0, f"demo 'block_and_tackle': falls = {falls}; give an even number from 2 on")
    wide, middle = 2 * R * falls, R * falls
    block = shapes.Box((wide - 2 * R, 0.08, 0.5 * R), colour="dimgray")
    weight = shapes.Cylinder(0.22, 0.4, "z", at=(0, 0, -0.35), colour="darkorange")
    hook = shapes.Cylinder(0.02, 0.2, "z", at=(0, 0, -0.1), colour="dimgray")
    load = Body("load", m, (0.1 * m,) * 3, position=(middle, 0, -DEPTH), shape=(block, weight, hook))
    marks = shapes.Cylinder(R, 0.12, "y", colour="steelblue"), shapes.Box((1.8 * R, 0.14, 0.2 * R), colour="white")
    drum = Body("drum", 8.0, (0.03, 0.03, 0.03), position=(wide + R, 0, -DEPTH - 0.4), shape=marks)
    axle = Revolute(GROUND, drum, at=drum.position, axis=(0, -1, 0), name="axle")
    guide = Prismatic(GROUND, load, at=load.position, axis="z", name="guide")
    line = {"radius": R, "axis": (0, -1, 0)}
    sheaves = [
        Pulley(GROUND, sense=-1, centre=(R * (2 * k + 1), 0, 0), **line) if k % 2
        else Pulley(load, sense=1, centre=(R * (2 * k + 1), 0, -DEPTH), **line)
        for k in range(falls)
    ]  # fmt: skip
    ends = (GROUND, (0, 0, 0)), Winch(axle, radius=R, sense=1)
    rope = Rope(ends, sheaves, stiffness=stiffness, damping=0.02 * stiffness, mu=mu, pretension=m * G / falls,
                name="rope")  # fmt: skip
    return System([load, drum], [guide, axle, SpeedDriver(axle, w, name="motor")], [rope], gravity=(0, 0, -G))


def shares(m, falls, mu):
    """Return the tensions of falls and pull [N] from the fixed end on, while it rises: each e^(mu pi) times the one
    before, all falls together the weight.
    """
    growth = np.exp(mu * np.pi * np.arange(falls + 1))
    return m * G * growth / growth[:-1].sum()


def theory(*, m, falls, mu):
    """Return the pull on the drum while the load rises and while it sinks, and the efficiency of rising."""
    up, down = shares(m, falls, mu), shares(m, falls, -mu)
    return {"pull_N": up[-1], "sinking_N": down[-1], "fixed_end_N": up[0], "efficiency": m * G / falls / up[-1]}


def measure(build, terms, *, m, falls, mu, R, w, t=4.0) -> Measured:
    """Measure the tensions as the drum takes in evenly, and pays out."""
    up, down = (simulate(build(w=rate), t, output=401, rtol=1e-9, **terms) for rate in (abs(w), -abs(w)))
    tension, sinking = (cast(RopeLoad, run.force("rope")).tension for run in (up, down))
    turned = up.angle("axle")[-1] - up.angle("axle")[200]
    raised = up.position("load")[-1, 2] - up.position("load")[200, 2]
    values = {
        "pull_N": tension[-1, -1], "sinking_N": sinking[-1, -1], "fixed_end_N": tension[-1, 0],
        "efficiency": m * G * raised / (tension[-1, -1] * R * turned),
    }  # fmt: skip
    known = shares(m, falls, mu)
    late = up.t > SETTLED * t
    lines = [
        Line(
            f"fall {k + 1}" if k < falls else "pull", tension[:, k], theory=(up.t[late], np.full(late.sum(), known[k]))
        )
        for k in range(tension.shape[1])
    ]
    curves = [
        Curve("tension of the rope [N]", up.t, lines[0].y, lines[0].theory, name=lines[0].name, more=lines[1:]),
        Curve("pull on the drum [N]", up.t, tension[:, -1], name="rises", more=[Line("sinks", sinking[:, -1])]),
    ]
    return Measured(values, [up], curves)


demo = Demo(
    __name__,
    title="Four falls do not lift fourfold",
    question="Why does a block and tackle with four falls not lift four times what one pulls?",
    beats=(
        Beat(0.0, "Four falls carry 60 kg."),
        Beat(share(0.25), "Up: every sheave rubs, and one pulls with 346 N instead of 147."),
        Beat(share(0.75), "From fall to fall less: 346, 237, 163, 112 and 77 N."),
    ),
    why="On smooth sheaves the rope has one tension, and each of four falls carries a quarter of the load. A rope that "
    "slides over a sheave is held back by it, more with every radian: its tension grows by e^(mu phi), half a turn a "
    "sheave. The last fall then carries more than the first one, and the hand more than the last. On the way down the "
    "same friction helps, so that a small pull keeps a large load from sinking.",
    equation="T_k = T_0 e^(k mu pi); T_0 + ... + T_n = m g; pull = T_n e^(mu pi)",
    symbols={
        "T_k": Symbol("tension after k sheaves", "N"),
        "T_0": Symbol("at the fixed end", "N"),
        "T_n": Symbol("in the last fall", "N"),
        "k": Symbol("0, 1, 2 ..."),
        "mu": Symbol("friction on a sheave", "", "mu"),
        "m": Symbol("load", "kg", "m"),
        "g": GRAVITY,
        "e": Symbol("2.718 ..."),
    },
    source="Euler (1762), Eytelwein (1808): rope on a drum; the sum of a geometric series",
    quantities={
        "pull_N": Quantity("pull while it rises", "N", relative=1e-6),
        "sinking_N": Quantity("pull while it sinks", "N", relative=1e-6),
        "fixed_end_N": Quantity("tension at the fixed end while it rises", "N", relative=1e-6),
        "efficiency": Quantity("efficiency of rising", "-", relative=1e-5),
    },
    alone="other engines have no rope that slides with friction",
    ablation=Ablation("friction", "each fall carries its quarter, and so does the hand", {"mu": 0.0}),
    against=Against("mu", 0.0, 0.3, "friction on the sheaves [-]"),
    show={"curves": [("force", "rope")], "traces": [], "view": (-75, 8), "hidden": ["joint names"]},
    ranges={"falls": None, "stiffness": None},
)  # fmt: skip
