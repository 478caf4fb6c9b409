"""A pushed ball first slides; when it rolls, it keeps a share of its speed that does not depend on friction."""

import numpy as np

from mbsd3d import DOP853, GROUND, Body, Contact, System, shapes, simulate

from ..form import GRAVITY, Ablation, Against, Beat, Control, Curve, Demo, Measured, Quantity, Symbol, require
from ..moments import share

G = 9.81  # m/s^2
STIFFNESS_MIN = 1e7  # [N/m] for a mass of 1 kg
ROLL_TIME_ERROR_MAX = 2e-7  # [s] the time to roll is wrong by up to 2 mu m g / (k slip), a fifth of its tolerance
SLIP_MIN = 1e-3  # m/s: with less of it the table, of 3e10 N/m, gives way by the size of roundings


def table_stiffness(mu, slip):
    """Return the normal stiffness of the table [N/m] that keeps the share of sliding time a demo shows."""
    return max(STIFFNESS_MIN, 2 * mu * G / (ROLL_TIME_ERROR_MAX * abs(slip))) if slip else STIFFNESS_MIN


def mechanism(*, r=0.1, beta=0.4, mu=0.3, v=5.0, spin=0.0) -> System:
    """Build a body of 1 kg, radius r [m], inertia beta m r^2, at v [m/s] along x and spin [rad/s] about y, on friction
    mu.
    """
    k = table_stiffness(mu, v - r * spin)
    ball = Body("ball", 1.0, (beta * r**2,) * 3, position=(0, 0, r - G / k), velocity=(v, 0, 0),
                omega=(0, spin, 0), shape=[shapes.Sphere(r), shapes.Sphere(0.2 * r, at=(0.85 * r, 0, 0))])  # fmt: skip
    table = Contact(GROUND, ball, shapes.Sphere(r), stiffness=k, friction=mu, name="table")
    return System([ball], forces=[table], gravity=(0, 0, -G))


def theory(*, r, beta, mu, v, spin, t):
    """Return the motion with friction mu m g, which acts on speed and spin until the slip v - r w is zero."""
    slip = v - r * spin
    require(abs(slip) >= SLIP_MIN, f"the ball rolls from the start: v and r spin differ by {slip:.3g} m/s; give "
            f"{SLIP_MIN} m/s or more")  # fmt: skip
    if mu == 0:
        return {"rolls_at_m_s": v, "rolls_after_s": np.inf, "heat_J": 0.0}
    time = abs(slip) * beta / ((1 + beta) * mu * G)
    require(time < t, f"the ball slides for {time:.3g} s: give a later end t than {t} s")
    return {"rolls_at_m_s": (v + beta * r * spin) / (1 + beta), "rolls_after_s": time,
            "heat_J": 0.5 * beta / (1 + beta) * slip**2}  # fmt: skip


def measure(build, terms, *, r, beta, v, spin, t=2.0) -> Measured:
    """Measure the rolling speed, the time to rolling from the path, as the speed falls linearly, and the lost
    energy."""
    run = simulate(build(), t, method=DOP853(stiff="run"), rtol=1e-10, output=401, **terms)
    x, speed, rim = run.position("ball")[:, 0], run.velocity("ball")[:, 0], r * run.omega("ball")[:, 1]
    last = speed[-1]
    time = 2 * (x[-1] - x[0] - last * t) / (v - last) if abs(rim[-1] - last) < 1e-6 * abs(v - r * spin) else np.inf
    total = run.energy().total
    share, rolls = np.minimum(run.t / build.theory["rolls_after_s"], 1), build.theory["rolls_at_m_s"]
    curves = [
        Curve("speed [m/s]", run.t, speed, (run.t, v + (rolls - v) * share)),
        Curve("speed of the rim [m/s]", run.t, rim, (run.t, r * spin + (rolls - r * spin) * share)),
    ]
    return Measured({"rolls_at_m_s": last, "rolls_after_s": time, "heat_J": total[0] - total[-1]}, [run], curves)


demo = Demo(
    __name__,
    title="From sliding to rolling",
    question="Why does a pushed ball end up rolling at 5/7 of its speed, on ice as on felt?",
    beats=(
        Beat(0.0, "Pushed, it slides: friction slows it down and sets it turning."),
        Beat(0.4855, "Now it rolls, at 5/7 of its speed."),
        Beat(share(1.0), "Nothing slows it down any more."),
    ),
    why="Friction slows the ball and spins it up, and its moment about any point of the table is zero: the angular "
    "momentum about the table stays. When the slip is gone friction ends, so the speed at which it rolls is settled "
    "from the start, and with it the heat. More friction only makes it come sooner. With enough backspin the ball "
    "comes back.",
    equation="t = |v - r w| b / ((1 + b) mu g),  v_1 = (v + b r w) / (1 + b),  b = I / m r^2",
    symbols={
        "v": Symbol("speed", "m/s", curve=(0, 0)),
        "w": Symbol("turning", "rad/s", curve=(1, 1)),
        "v_1": Symbol("speed at which it rolls", "m/s"),
        "t": Symbol("time until it rolls", "s"),
        "r": Symbol("radius", "m", "r"),
        "b": Symbol("moment over m r^2", "", "beta"),
        "mu": Symbol("friction", "", "mu"),
        "g": GRAVITY,
        "I": Symbol("moment", "kg m^2"),
        "m": Symbol("ball", "kg"),
    },
    source="Coriolis, Theorie mathematique des effets du jeu de billard (1835); Hopkins, Patterson, Am. J. Phys. 45 "
    "(1977) 263",
    quantities={
        "rolls_at_m_s": Quantity("speed at which it rolls", "m/s", relative=1e-8),
        "rolls_after_s": Quantity("it rolls after", "s", relative=1e-6, absolute=1e-6),  # see LATE
        "heat_J": Quantity("energy lost", "J", relative=1e-6),
    },
    ablation=Ablation("friction", "it slides for ever", {"mu": 0.0}),
    against=Against("spin", -155.0, 45.0, "spin at the start [rad/s]"),
    show={"curves": [("velocity", "ball"), ("omega", "ball")], "follow": "ball", "speed": 0.5},
    ranges={"mu": (0.25, 0.4)},
    sliders=(
        Control("spin", -150.0, 0.0, "rad/s"),
        Control("mu", 0.3, 0.6, "", "friction"),
    ),
    attempt="give it backspin: below -125 rad/s it comes back.",
)  # fmt: skip
